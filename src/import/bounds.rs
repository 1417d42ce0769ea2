//! What an XML text would ask of a parser, found by one pass over it: what its entities expand to, and how many attributes
//! one element has.

use crate::budget;
use std::collections::HashMap;

/// Entities within entities; more are a circle or made to break readers.
const DEEPEST: usize = 20;

/// What is beyond its budget in a text: the byte, and what to say.
pub(super) fn beyond(text: &str) -> Option<(usize, String)> {
    entities(text).or_else(|| attributes(text))
}

fn entities(text: &str) -> Option<(usize, String)> {
    const START: &str = "<!ENTITY";
    let first = text.find(START)?;
    let mut declared: HashMap<&str, &str> = HashMap::new();
    let mut end = first;
    while let Some(at) = text[end..].find(START) {
        let inner = &text[end + at + START.len()..];
        let (name, value) = declaration(inner).unwrap_or_default();
        declared.insert(name, value);
        end += at + START.len();
    }
    let mut sizes = HashMap::new();
    let total = references(&text[end..])
        .fold(0, |total: usize, name| total.saturating_add(expanded(name, &declared, &mut sizes, 0)));
    let most = budget::XML_ENTITY_BYTES;
    (total > most)
        .then(|| (first, format!("the entities of this file expand to more than {most} bytes, the most that is read")))
}

/// Name and value of what follows `<!ENTITY`; nothing of parameters and of what stands elsewhere.
fn declaration(text: &str) -> Option<(&str, &str)> {
    let text = text.trim_start();
    let (name, rest) = text.split_once(char::is_whitespace)?;
    let rest = rest.trim_start();
    let quote = rest.chars().next().filter(|quote| matches!(quote, '"' | '\''))?;
    Some((name, rest[1..].split_once(quote)?.0))
}

/// The names between `&` and `;`.
fn references(text: &str) -> impl Iterator<Item = &str> {
    text.split('&').skip(1).filter_map(|rest| Some(rest.split_once(';')?.0))
}

/// Bytes of an entity with all that is within it; of an unknown one (such as `amp`) none.
fn expanded<'t>(
    name: &'t str,
    declared: &HashMap<&'t str, &'t str>,
    sizes: &mut HashMap<&'t str, usize>,
    depth: usize,
) -> usize {
    if let Some(size) = sizes.get(name) {
        return *size;
    }
    let Some(value) = declared.get(name) else { return 0 };
    if depth > DEEPEST {
        return usize::MAX;
    }
    let within = references(value)
        .fold(0_usize, |total, inner| total.saturating_add(expanded(inner, declared, sizes, depth + 1)));
    let size = within.saturating_add(value.len());
    sizes.insert(name, size);
    size
}

fn attributes(text: &str) -> Option<(usize, String)> {
    let bytes = text.as_bytes();
    let (mut at, most) = (0, budget::XML_ATTRIBUTES);
    while let Some(open) = text.get(at..).and_then(|rest| rest.find('<')) {
        let start = at + open;
        at = match text.get(start..) {
            Some(rest) if rest.starts_with("<!--") => past(text, start, "-->"),
            Some(rest) if rest.starts_with("<![CDATA[") => past(text, start, "]]>"),
            _ => {
                let (end, count) = tag(bytes, start);
                if count > most {
                    let what = format!("this element has more than {most} attributes, the most that is read");
                    return Some((start, what));
                }
                end
            }
        };
    }
    None
}

fn past(text: &str, start: usize, end: &str) -> usize {
    text[start..].find(end).map_or(text.len(), |at| start + at + end.len())
}

/// Where a tag ends, and how many equals signs stand in it outside of quotes.
fn tag(bytes: &[u8], start: usize) -> (usize, usize) {
    let (mut count, mut quote) = (0, None);
    for (at, byte) in bytes.iter().enumerate().skip(start) {
        match (byte, quote) {
            (b'"' | b'\'', None) => quote = Some(*byte),
            (byte, Some(open)) if *byte == open => quote = None,
            (b'=', None) => count += 1,
            (b'>', None) => return (at + 1, count),
            _ => {}
        }
    }
    (bytes.len(), count)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entities_count_as_often_as_they_are_used() {
        let text = |uses: usize, size: usize| {
            let value = "x".repeat(size);
            format!("<!DOCTYPE r [<!ENTITY e \"{value}\"><!ENTITY f '&e;&e;'>]><r a=\"{}\"/>", "&f;".repeat(uses))
        };
        let most = budget::XML_ENTITY_BYTES;
        assert_eq!(beyond(&text(10, 1000)), None);
        assert_eq!(beyond(&text(most / 2100, 1000)), None);
        assert!(beyond(&text(most / 2000 + 1, 1000)).is_some());
        let circle = "<!DOCTYPE r [<!ENTITY a '&b;'><!ENTITY b '&a;'>]><r>&a;</r>";
        assert!(beyond(circle).is_some());
        assert_eq!(beyond("<r>&amp;&lt;</r>"), None);
    }

    #[test]
    fn attributes_are_counted_outside_of_quotes_and_comments() {
        let many = |count: usize| (0..count).map(|k| format!(" a{k}='='")).collect::<String>();
        let most = budget::XML_ATTRIBUTES;
        assert_eq!(beyond(&format!("<!-- <r{} --><r{}/>", many(2 * most), many(most))), None);
        assert_eq!(beyond(&format!("<r><s{}/></r>", many(most + 1))).map(|(at, _)| at), Some(3));
        assert_eq!(beyond("<"), None);
        assert_eq!(beyond("<r a='"), None);
    }
}
