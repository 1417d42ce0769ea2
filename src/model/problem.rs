//! What is wrong with a description, said so that a scenario file can point at it.

use crate::force::question::Flaw;
use std::fmt;

/// One problem of a description.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Which element.
    pub element: Element,
    /// Which field of it, as in scenario files: `inertia`, `hinge.parent`, `between(1)`.
    pub field: String,
    /// What is wrong, with the element's name, the value and what is allowed.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
}

impl Problem {
    /// What is wrong with the numbers or points of a force.
    pub(super) fn of_force(index: usize, flaw: Flaw) -> Self {
        Self { element: Element::Force(index), field: flaw.key, message: flaw.message, help: Some(flaw.help) }
    }
}

/// The element a problem belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Element {
    /// The scene as a whole.
    Scene,
    /// Index into `Description::bodies`.
    Body(usize),
    /// Index into `Description::forces`.
    Force(usize),
    /// Index into `Description::loops`.
    Loop(usize),
    /// Index into `Description::drives`.
    Drive(usize),
    /// Index into `Description::gears`.
    Gear(usize),
    /// Index into `Description::motors`.
    Motor(usize),
    /// Index into `Description::events`.
    Event(usize),
    /// Index into `Description::contacts`.
    Contact(usize),
    /// Index into `Description::beams`.
    Beam(usize),
    /// Index into `Description::outputs`.
    Output(usize),
    /// Index into `Description::controllers`.
    Controller(usize),
    /// Index into `Description::stages`.
    Stage(usize),
}

/// Six significant digits without trailing zeros, of numbers that files give: `-9.80665`, `0.1`, `2.5e-9`.
pub fn number(x: f64) -> String {
    significant(x, 6)
}

/// Four significant digits, as in reports, of numbers that are computed: `-9.807`, `0.5236`, `1.019e6`.
pub fn rounded(x: f64) -> String {
    const DIGITS: usize = 4;
    // Of what is as large nobody counts the last digits.
    match x.abs() >= 1e5 {
        true => exponential(x, DIGITS),
        false => significant(x, DIGITS),
    }
}

/// So many significant digits (≥ 1) without trailing zeros; the digits before the point are never rounded away.
pub fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let size = x.abs().log10().floor();
    if !(-4.0..7.0).contains(&size) {
        return exponential(x, digits);
    }
    let decimals = (digits as f64 - 1.0 - size).max(0.0) as usize;
    without_zeros(&format!("{x:.decimals$}")).to_owned()
}

fn exponential(x: f64, digits: usize) -> String {
    let shown = format!("{x:.*e}", digits - 1);
    match shown.split_once('e') {
        Some((digits, power)) => format!("{}e{power}", without_zeros(digits)),
        None => shown,
    }
}

/// `3 bodies`, `1 body`.
pub fn counted(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// Digits of two numbers that may look alike, up to all there are.
const DIGITS: std::ops::RangeInclusive<usize> = 6..=17;

/// Two numbers with as many digits as tell them apart, six at least.
pub fn apart(a: f64, b: f64) -> [String; 2] {
    let both = |digits: usize| [a, b].map(|x| significant(x, digits));
    let differ = DIGITS.map(both).find(|[a, b]| a != b);
    differ.unwrap_or_else(|| [a, b].map(number))
}

fn without_zeros(digits: &str) -> &str {
    if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits }
}

/// All problems as one sentence for a message that has no place for a list.
pub fn in_one_line(problems: &[Problem]) -> String {
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.message)?;
        match &self.help {
            Some(help) => write!(f, " ({help})"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{apart, number, significant};

    #[test]
    fn numbers_that_look_alike_get_the_digits_that_tell_them_apart() {
        assert_eq!(apart(0.25, 0.75), ["0.25", "0.75"]);
        assert_eq!(apart(0.069_308_800_123, 0.069_308_800_124), ["0.069308800123", "0.069308800124"]);
        assert_eq!(apart(1.0, 1.0 + f64::EPSILON), ["1", "1.0000000000000002"]);
    }

    #[test]
    fn numbers_are_as_short_as_they_can_be() {
        let shown = [-9.80665, 0.1, 100.0, 2.5e-9, 1.0 / 3.0, 123456789.0, -0.0, f64::NAN].map(number);
        assert_eq!(shown, ["-9.80665", "0.1", "100", "2.5e-9", "0.333333", "1.23457e8", "0", "NaN"]);
        assert_eq!([123456.7, 0.99996, 2.345e-9].map(|x| significant(x, 4)), ["123457", "1", "2.345e-9"]);
        assert_eq!(significant(0.1 + 0.2, 17), "0.30000000000000004");
    }
}
