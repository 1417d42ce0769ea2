//! One address space for all texts of a scenario: the file first, then every override of the command line.
//!
//! A span is a range of bytes in it, so that a value knows where it was written, whoever wrote it.

use super::diagnostic::Place;
use std::cell::OnceCell;
use std::ops::Range;

/// The texts, one after the other.
#[derive(Debug)]
pub(super) struct Sources<'t> {
    parts: Vec<Part<'t>>,
}

#[derive(Debug)]
struct Part<'t> {
    name: String,
    text: &'t str,
    start: usize,
    line_starts: OnceCell<Vec<usize>>,
    /// For a text that was made from others: where its parts were written there.
    origins: Vec<(Range<usize>, Range<usize>)>,
}

/// The longest piece of a line that is shown [bytes].
const LONGEST_EXCERPT: usize = 400;

impl<'t> Sources<'t> {
    pub(super) fn new(name: &str, text: &'t str) -> Self {
        let mut sources = Self { parts: Vec::new() };
        sources.add(name, text);
        sources
    }

    /// Adds a text and tells at which address it starts.
    pub(super) fn add(&mut self, name: &str, text: &'t str) -> usize {
        // One address between two texts, so that the end of one is not the start of the next.
        let start = self.parts.last().map_or(0, |last| last.start + last.text.len() + 1);
        self.parts.push(Part { name: name.to_owned(), text, start, line_starts: OnceCell::new(), origins: Vec::new() });
        start
    }

    /// Says of the text added last, which was made from others, where its parts were written: spans here and there. Of
    /// several that hold a place the narrowest counts.
    pub(super) fn made_from(&mut self, origins: Vec<(Range<usize>, Range<usize>)>) {
        if let Some(part) = self.parts.last_mut() {
            part.origins = origins;
        }
    }

    /// The text at a span.
    pub(super) fn text(&self, span: &Range<usize>) -> &'t str {
        let part = self.part(span.start);
        part.text.get(span.start - part.start..span.end.saturating_sub(part.start)).unwrap_or("")
    }

    /// File, line, column and the line itself; of a span over several lines the first one.
    pub(super) fn place(&self, span: &Range<usize>) -> Place {
        let part = self.part(span.start);
        let around = part.origins.iter().filter(|(here, _)| here.contains(&span.start));
        if let Some((_, there)) = around.min_by_key(|(here, _)| here.len()) {
            return self.place(there);
        }
        let starts = part.line_starts.get_or_init(|| line_starts(part.text));
        let from = floor(part.text, span.start - part.start);
        let line = starts.partition_point(|start| *start <= from);
        let line_start = starts[line - 1];
        let rest = &part.text[line_start..];
        let whole = rest.split('\n').next().unwrap_or(rest).trim_end_matches('\r');
        let mark = (from - line_start).min(whole.len());
        let mark_end = span.end.saturating_sub(part.start + line_start).clamp(mark, whole.len());
        let cut_start =
            floor(whole, mark.saturating_sub(LONGEST_EXCERPT / 2) * usize::from(whole.len() > LONGEST_EXCERPT));
        let cut_end = floor(whole, whole.len().min(cut_start + LONGEST_EXCERPT));
        Place {
            file: part.name.clone(),
            line,
            column: whole[..mark].chars().count() + 1,
            excerpt: whole[cut_start..cut_end].to_owned(),
            marked: mark - cut_start..floor(whole, mark_end.min(cut_end)) - cut_start,
        }
    }

    fn part(&self, address: usize) -> &Part<'t> {
        let after = self.parts.partition_point(|part| part.start <= address);
        &self.parts[after.max(1) - 1]
    }
}

fn line_starts(text: &str) -> Vec<usize> {
    std::iter::once(0).chain(text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(i, _)| i + 1)).collect()
}

/// The nearest character boundary at or before an index.
fn floor(text: &str, index: usize) -> usize {
    let mut index = index.min(text.len());
    while !text.is_char_boundary(index) {
        index -= 1;
    }
    index
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_lines_and_characters_from_one() {
        let mut sources = Sources::new("a.toml", "x = 1\nµ = \"ä\"\r\nlast");
        let start = sources.add("command line", "--set x=2");
        let place = sources.place(&(11..15));
        assert_eq!((place.file.as_str(), place.line, place.column), ("a.toml", 2, 5));
        assert_eq!((place.excerpt.as_str(), place.marked), ("µ = \"ä\"", 5..9));
        let end = sources.place(&(start - 1..start - 1));
        assert_eq!((end.line, end.column), (3, 5), "the end of the file belongs to the file");
        let set = sources.place(&(start + 8..start + 9));
        assert_eq!((set.file.as_str(), set.line, set.column), ("command line", 1, 9));
        assert_eq!(sources.text(&(start + 8..start + 9)), "2");
    }

    #[test]
    fn long_lines_are_cut_around_the_mark() {
        let text = format!("{}!{}", "ä".repeat(5_000), "z".repeat(5_000));
        let place = Sources::new("a.toml", &text).place(&(10_000..10_001));
        assert_eq!(place.column, 5_001);
        assert!(place.excerpt.len() <= LONGEST_EXCERPT);
        assert_eq!(&place.excerpt[place.marked], "!");
    }
}
