//! Small faults of XML that others read over: they are mended in a copy in which every byte stays at its place, and said.

use super::log::{Log, Place, Taken};
use super::xml::{self, Unread};
use roxmltree::Error;
use std::sync::Arc;

/// More prefixes than these nobody forgets to declare.
const MOST_PREFIXES: usize = 32;

/// A text as it can be parsed: further `<?xml … ?>` are blanks, and the colon after a prefix that nobody declares is a `_`.
/// What else is wrong stays as it is.
pub(super) fn readable(text: Arc<str>, source: usize, log: &Log) -> Arc<str> {
    let mut text = without_declarations(text, source, log);
    for _ in 0..MOST_PREFIXES {
        let Some(prefix) = undeclared(&text) else { break };
        // Macros are recognized by their prefix, and are no models.
        if prefix == "xacro" {
            break;
        }
        let found = names_with(&text, &prefix);
        let Some(&first) = found.first() else { break };
        let place = Place { source, span: first..first + prefix.len() + 1 };
        let what = format!("no xmlns declares the prefix `{prefix}:`, which stands before {} names", found.len());
        log.note(place, format!("`{prefix}:`"), Taken::Approximated, format!("{what}: they are read as `{prefix}_…`"));
        let mut bytes = text.as_bytes().to_vec();
        found.iter().for_each(|at| bytes[at + prefix.len()] = b'_');
        let Ok(mended) = String::from_utf8(bytes) else { break };
        text = mended.into();
    }
    text
}

/// The first prefix that nobody declares.
fn undeclared(text: &str) -> Option<String> {
    match xml::document(text) {
        Err(Unread::Syntax(Error::UnknownNamespace(prefix, _))) => Some(prefix),
        _ => None,
    }
}

/// An XML declaration counts where the file begins; later ones come from files that were put together.
fn without_declarations(text: Arc<str>, source: usize, log: &Log) -> Arc<str> {
    let mut bytes = Vec::new();
    for item in items(&text) {
        let Item::Instruction(start, end) = item else { continue };
        let begins = text[..start].trim_start_matches('\u{feff}').is_empty();
        if begins || !text[start..].starts_with("<?xml") || !text[start + 5..].starts_with(char::is_whitespace) {
            continue;
        }
        if bytes.is_empty() {
            bytes = text.as_bytes().to_vec();
        }
        bytes[start..end].fill(b' ');
        let place = Place { source, span: start..end };
        let what = "an XML declaration counts only where the file begins: this one is left out";
        log.note(place, "`<?xml … ?>`".to_owned(), Taken::Approximated, what);
    }
    // Blanks stand for whole characters only: the text stays UTF-8.
    if bytes.is_empty() { text } else { String::from_utf8(bytes).map_or(text, Into::into) }
}

/// Where tags and attributes with a prefix begin.
fn names_with(text: &str, prefix: &str) -> Vec<usize> {
    let mut found = Vec::new();
    for item in items(text) {
        let Item::Tag(start, end) = item else { continue };
        let bytes = text.as_bytes();
        let mut at = start + 1 + usize::from(bytes.get(start + 1) == Some(&b'/'));
        let mut begins = true;
        while at < end {
            let rest = &text[at..end];
            if begins && rest.strip_prefix(prefix).is_some_and(|rest| rest.starts_with(':')) {
                found.push(at);
            }
            begins = bytes[at].is_ascii_whitespace();
            at += match bytes[at] {
                quote @ (b'"' | b'\'') => rest[1..].find(char::from(quote)).map_or(rest.len(), |close| close + 2),
                _ => rest.chars().next().map_or(1, char::len_utf8),
            };
        }
    }
    found
}

/// What stands in a text, from its first byte to the one after its last.
enum Item {
    Tag(usize, usize),
    Instruction(usize, usize),
}

/// Tags and processing instructions; comments, character data and document types are passed over.
fn items(text: &str) -> impl Iterator<Item = Item> {
    let mut at = 0;
    std::iter::from_fn(move || {
        loop {
            let start = at + text[at..].find('<')?;
            let rest = &text[start..];
            let until = |end: &str| rest.find(end).map_or(text.len(), |found| start + found + end.len());
            if rest.starts_with("<!--") {
                at = until("-->");
            } else if rest.starts_with("<![CDATA[") {
                at = until("]]>");
            } else if rest.starts_with("<?") {
                at = until("?>");
                return Some(Item::Instruction(start, at));
            } else {
                at = close(text, start);
                if !rest.starts_with("<!") {
                    return Some(Item::Tag(start, at));
                }
            }
        }
    })
}

/// One past the `>` of a tag that is not within quotes.
fn close(text: &str, start: usize) -> usize {
    let mut quoted = None;
    for (at, byte) in text.bytes().enumerate().skip(start) {
        match (quoted, byte) {
            (None, b'>') => return at + 1,
            (None, b'"' | b'\'') => quoted = Some(byte),
            (Some(quote), _) if quote == byte => quoted = None,
            _ => {}
        }
    }
    text.len()
}
