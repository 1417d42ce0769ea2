//! From text to tokens, each with its place.

use super::FormulaError;
use std::ops::Range;

/// A token.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Token<'t> {
    Number(f64),
    /// An identifier.
    Name(&'t str),
    /// A name in braces.
    Braced(&'t str),
    /// An operator, a bracket or a comma.
    Sign(&'static str),
    End,
}

/// Longer ones first: the first that fits is taken.
const SIGNS: [&str; 17] = ["**", "//", "==", "!=", "<=", ">=", "<", ">", "+", "-", "*", "/", "%", "^", "(", ")", ","];

/// Signs of other languages and what is meant by them.
const FOREIGN: [(&str, &str); 9] = [
    ("&&", "write `and`"),
    ("||", "write `or`"),
    ("&", "write `and`"),
    ("|", "for the absolute value write `abs(…)`, for a choice `or`"),
    ("!", "write `not`, or `!=` for a comparison"),
    ("=", "a comparison is written `==`"),
    ("?", "a choice is written `if(condition, a, b)`"),
    ("[", "brackets are round: `(…)`"),
    (";", "arguments are separated by commas"),
];

/// Signs that look like those that are meant.
const LOOK_ALIKE: [(char, &str); 7] =
    [('−', "-"), ('·', "*"), ('×', "*"), ('÷', "/"), ('≤', "<="), ('≥', ">="), ('≠', "!=")];

pub(super) struct Tokens<'t> {
    text: &'t str,
    at: usize,
}

impl<'t> Tokens<'t> {
    pub(super) fn new(text: &'t str) -> Self {
        Self { text, at: 0 }
    }

    /// The next token; at the end of the text `End`, again and again.
    pub(super) fn next(&mut self) -> Result<(Token<'t>, Range<usize>), FormulaError> {
        let rest = &self.text[self.at..];
        let blank = rest.len() - rest.trim_start().len();
        let (start, rest) = (self.at + blank, &rest[blank..]);
        let Some(first) = rest.chars().next() else {
            self.at = self.text.len();
            return Ok((Token::End, self.at..self.at));
        };
        let (token, length) = if first.is_ascii_digit() || first == '.' {
            number(rest, start)?
        } else if first.is_alphabetic() || first == '_' {
            let length = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
            (Token::Name(&rest[..length]), length)
        } else if first == '{' {
            braced(rest, start)?
        } else {
            sign(rest, first, start)?
        };
        self.at = start + length;
        Ok((token, start..self.at))
    }
}

fn braced(rest: &str, start: usize) -> Result<(Token<'_>, usize), FormulaError> {
    match rest.find('}') {
        Some(end) => Ok((Token::Braced(rest[1..end].trim()), end + 1)),
        None => Err(FormulaError::new(start..start + 1, "this brace is never closed")),
    }
}

fn sign(rest: &str, first: char, start: usize) -> Result<(Token<'static>, usize), FormulaError> {
    if let Some(sign) = SIGNS.into_iter().find(|sign| rest.starts_with(sign)) {
        return Ok((Token::Sign(sign), sign.len()));
    }
    if let Some((sign, meant)) = LOOK_ALIKE.into_iter().find(|(sign, _)| *sign == first) {
        return Ok((Token::Sign(meant), sign.len_utf8()));
    }
    if let Some((sign, help)) = FOREIGN.into_iter().find(|(sign, _)| rest.starts_with(sign)) {
        return Err(FormulaError::new(start..start + sign.len(), format!("`{sign}` is no operator")).help(help));
    }
    let span = start..start + first.len_utf8();
    Err(FormulaError::new(span, format!("`{}` means nothing in a formula", first.escape_debug())))
}

/// A decimal number as in Python: `3`, `.5`, `2.`, `1e-3`, `1_000`.
fn number(rest: &str, start: usize) -> Result<(Token<'_>, usize), FormulaError> {
    let bytes = rest.as_bytes();
    let digits = |mut at: usize| {
        while bytes.get(at).is_some_and(u8::is_ascii_digit)
            || bytes.get(at) == Some(&b'_') && bytes.get(at + 1).is_some_and(u8::is_ascii_digit)
        {
            at += 1;
        }
        at
    };
    let mut end = digits(0);
    if bytes.get(end) == Some(&b'.') {
        end = digits(end + 1);
    }
    if end == 1 && bytes[0] == b'.' {
        return Err(FormulaError::new(start..start + 1, "a number needs digits"));
    }
    if matches!(bytes.get(end), Some(b'e' | b'E')) {
        let signed = end + 1 + usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
        if bytes.get(signed).is_some_and(u8::is_ascii_digit) {
            end = digits(signed);
        }
    }
    let written = &rest[..end];
    let follows = rest[end..].chars().next().filter(|c| c.is_alphanumeric() || *c == '_' || *c == '.');
    if let Some(follows) = follows {
        let span = start..start + end + follows.len_utf8();
        if follows == '.' || follows.is_ascii_digit() || follows == '_' {
            return Err(FormulaError::new(span, format!("`{written}{follows}` is no number")));
        }
        let name: String = rest[end..].chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
        let error = FormulaError::new(start..start + end + name.len(), format!("`{written}{name}` is no number"));
        return Err(error.help(format!("a product is written with `*`: `{written}*{name}`")));
    }
    match written.replace('_', "").parse::<f64>() {
        Ok(value) if value.is_finite() => Ok((Token::Number(value), end)),
        _ => Err(FormulaError::new(start..start + end, format!("`{written}` is not a finite number"))),
    }
}
