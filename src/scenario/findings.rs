//! What the reader has found so far. It never stops at the first problem.

use super::diagnostic::{Diagnostic, Severity};
use super::sources::Sources;
use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::ops::Range;

/// A finding before its place is looked up.
#[derive(Debug)]
pub(super) struct Finding {
    severity: Severity,
    span: Option<Range<usize>>,
    /// The part of the text that is meant, if the value at `span` is a text: bytes of what it says, not of how it is
    /// written.
    within: Option<Range<u32>>,
    message: String,
    label: String,
    help: Option<String>,
}

impl Finding {
    pub(super) fn error(span: Range<usize>, message: String) -> Self {
        Self { severity: Severity::Error, span: Some(span), within: None, message, label: String::new(), help: None }
    }

    pub(super) fn warning(span: Range<usize>, message: String) -> Self {
        Self { severity: Severity::Warning, ..Self::error(span, message) }
    }

    /// An error that has no place in the file.
    pub(super) fn without_place(message: String) -> Self {
        Self { span: None, ..Self::error(0..0, message) }
    }

    /// First and last byte.
    fn place(&self) -> Option<(usize, usize)> {
        self.span.as_ref().map(|span| (span.start, span.end))
    }

    /// Points at a part of the text that the value is.
    pub(super) fn within(mut self, part: Range<usize>) -> Self {
        // Files are far smaller than 4 GB.
        self.within = Some(part.start as u32..part.end as u32);
        self
    }

    pub(super) fn label(mut self, label: impl Into<String>) -> Self {
        self.label = label.into();
        self
    }

    pub(super) fn help(self, help: impl Into<String>) -> Self {
        self.maybe_help(Some(help.into()))
    }

    pub(super) fn maybe_help(mut self, help: Option<String>) -> Self {
        self.help = help;
        self
    }
}

/// All findings, and which values must not be read because of them.
#[derive(Debug, Default)]
pub(super) struct Findings {
    list: RefCell<Vec<Finding>>,
    errors: Cell<usize>,
    unreadable: RefCell<BTreeSet<(usize, usize)>>,
}

impl Findings {
    pub(super) fn push(&self, finding: Finding) {
        self.errors.set(self.errors.get() + usize::from(finding.severity == Severity::Error));
        self.list.borrow_mut().push(finding);
    }

    /// Adds a finding about a value, which is not read from now on.
    pub(super) fn push_value(&self, finding: Finding) {
        if let Some(span) = &finding.span {
            self.unreadable.borrow_mut().insert((span.start, span.end));
        }
        self.push(finding);
    }

    /// Whether something was found within this value.
    pub(super) fn touch(&self, value: &Range<usize>) -> bool {
        let unreadable = self.unreadable.borrow();
        unreadable.range((value.start, 0)..(value.end, 0)).next().is_some()
    }

    /// Whether this value lies within one about which something was found.
    pub(super) fn cover(&self, value: &Range<usize>) -> bool {
        let unreadable = self.unreadable.borrow();
        let before = unreadable.range(..=(value.start, usize::MAX)).next_back();
        before.is_some_and(|(start, end)| *start <= value.start && value.end <= *end)
    }

    /// How many errors there are.
    pub(super) fn errors(&self) -> usize {
        self.errors.get()
    }

    /// With lines and columns, in the order of the file.
    pub(super) fn into_diagnostics(self, sources: &Sources<'_>) -> Vec<Diagnostic> {
        let mut list = self.list.into_inner();
        // What an error says of a place needs no warning besides.
        let is_error = |finding: &&Finding| finding.severity == Severity::Error;
        let wrong: BTreeSet<_> = list.iter().filter(is_error).filter_map(Finding::place).collect();
        list.retain(|finding| is_error(&finding) || finding.place().is_none_or(|place| !wrong.contains(&place)));
        list.sort_by_key(|finding| finding.span.as_ref().map(|span| span.start));
        let resolve = |finding: Finding| Diagnostic {
            severity: finding.severity,
            message: finding.message,
            place: finding.span.map(|span| match finding.within {
                Some(part) => sources.place(&inside(sources, &span, &(part.start as usize..part.end as usize))),
                None => sources.place(&span),
            }),
            label: finding.label,
            help: finding.help,
        };
        list.into_iter().map(resolve).collect()
    }
}

/// Where a part of a text is written, given where the text is.
fn inside(sources: &Sources<'_>, value: &Range<usize>, part: &Range<usize>) -> Range<usize> {
    let written = sources.text(value);
    let start = value.start + raw_offset(written, part.start);
    let end = value.start + raw_offset(written, part.end);
    // A part without length, such as the end of the text, is marked at one character.
    start..end.max(start + 1)
}

/// From a byte of what a TOML string says to the byte of how it is written; what is no string says what is written.
fn raw_offset(written: &str, wanted: usize) -> usize {
    let Some(quote @ ('"' | '\'')) = written.chars().next() else { return wanted };
    let triple: String = [quote; 3].iter().collect();
    let mut at = if written.starts_with(&triple) { 3 } else { 1 };
    if at == 3 {
        // A line break right after the quotes does not count.
        let rest = &written[at..];
        at += if rest.starts_with("\r\n") { 2 } else { usize::from(rest.starts_with('\n')) };
    }
    let mut said = 0;
    while said < wanted {
        let Some(letter) = written[at..].chars().next() else { return written.len() };
        let (length, bytes) = match letter {
            '\\' if quote == '"' => escape(&written[at..]),
            other => (other.len_utf8(), other.len_utf8()),
        };
        at += length;
        said += bytes;
    }
    at
}

/// How long an escape sequence is as written, and what it stands for [bytes].
fn escape(rest: &str) -> (usize, usize) {
    let digits = match rest[1..].chars().next() {
        Some('x') => 2,
        Some('u') => 4,
        Some('U') => 8,
        // A line break and the blanks around it stand for nothing.
        Some(blank) if blank.is_whitespace() => return (rest.len() - rest[1..].trim_start().len(), 0),
        Some(letter) => return (1 + letter.len_utf8(), 1),
        None => return (1, 1),
    };
    let code = rest.get(2..2 + digits).and_then(|hex| u32::from_str_radix(hex, 16).ok()).and_then(char::from_u32);
    (2 + digits, code.map_or(1, char::len_utf8))
}

#[cfg(test)]
mod tests {
    use super::raw_offset;

    /// A character of what a string says is found where it is written.
    #[test]
    fn parts_of_texts_are_found_behind_escapes() {
        let texts = [
            "\"t + x\"",
            "'t + x'",
            "\"\\u0074\\t\\\"\\\\ x\"",
            "\"\"\"\n t\\\n   + x\"\"\"",
            "'''\nt + x'''",
            "\"\\U0001F600 \\u00e4 x\"",
            "t + x",
        ];
        for written in texts {
            let text = match written.starts_with(['"', '\'']) {
                true => {
                    toml::de::DeValue::parse(written).expect("TOML").into_inner().as_str().expect("text").to_owned()
                }
                false => written.to_owned(),
            };
            let at = raw_offset(written, text.find('x').expect("an x"));
            assert_eq!(&written[at..=at], "x", "{written}");
        }
    }
}
