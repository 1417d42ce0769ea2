//! Numbers as reports show them; JSON and tables have all digits.

pub(super) use crate::model::problem::counted as count;
use crate::model::problem::significant;
use crate::quantity::{Dimension, Quantity};
use crate::round_off::SHOWN;
use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Significant digits without `--digits`.
pub(super) const USUAL_DIGITS: u8 = 4;
/// No number of a report is shown with more digits to tell it from others of its kind.
const MOST_DIGITS: usize = 9;
/// Significant digits of a number in a report, set once by `--digits`.
static DIGITS: AtomicUsize = AtomicUsize::new(USUAL_DIGITS as usize);

/// Sets how many significant digits reports show.
pub(super) fn show_digits(digits: u8) {
    DIGITS.store(usize::from(digits), Ordering::Relaxed);
}

/// How many significant digits reports show.
pub(super) fn shown_digits() -> usize {
    DIGITS.load(Ordering::Relaxed)
}

/// As many significant digits as reports show, without trailing zeros: `-9.807`, `0.1`, `2.5e-9`.
pub(super) fn number(x: f64) -> String {
    significant(x, shown_digits())
}

/// A number with at least so many significant digits, and with as many as reports show.
pub(super) fn number_to(x: f64, digits: usize) -> String {
    significant(x, shown_digits().max(digits))
}

/// Significant digits that tell numbers apart which are as many values of one thing, at most [`MOST_DIGITS`]: no fewer than reports show.
pub(super) fn digits_apart(values: &[f64]) -> usize {
    let shown = |digits: usize| values.iter().map(|x| number_to(*x, digits)).collect::<BTreeSet<_>>().len();
    let least = shown_digits();
    let all = shown(MOST_DIGITS);
    (least..MOST_DIGITS).find(|digits| shown(*digits) == all).unwrap_or(MOST_DIGITS)
}

/// The mean of some numbers, and the standard deviation of a sample; that of fewer than two is 0.
pub(super) fn mean_and_deviation(values: &[f64]) -> [f64; 2] {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let squares = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
    [mean, (squares / values.len().saturating_sub(1).max(1) as f64).sqrt()]
}

/// Names in the order in which people count: `rocket_2` before `rocket_10`.
pub(super) fn natural(one: &str, other: &str) -> std::cmp::Ordering {
    let parts = |text: &str| -> Vec<(u128, String)> {
        let runs = text.as_bytes().chunk_by(|a, b| a.is_ascii_digit() == b.is_ascii_digit());
        let part = |run: &[u8]| {
            let text = String::from_utf8_lossy(run).into_owned();
            (text.parse().unwrap_or(u128::MAX), text)
        };
        runs.map(part).collect()
    };
    parts(one).cmp(&parts(other)).then_with(|| one.cmp(other))
}

/// Two digits for what should be small: `7.3e-10`, `0`; without an exponent where it is not.
pub(super) fn small(x: f64) -> String {
    match x.abs() {
        0.0 => "0".to_owned(),
        size if (1e-3..1e4).contains(&size) => {
            let digits = (1.0 - size.log10().floor()).max(0.0) as usize;
            format!("{x:.digits$}")
        }
        _ => format!("{x:.1e}"),
    }
}

/// The number that an option gives in a unit: `0.5`, or with one of that dimension, `500 ms`.
pub(super) fn in_unit(text: &str, unit: &str) -> Result<f64, String> {
    if let Ok(number) = text.trim().parse() {
        return Ok(number);
    }
    let quantity = Quantity::parse(text).map_err(|error| error.to_string())?;
    match Dimension::of(unit) {
        Ok(dimension) if quantity.dimension == dimension => Ok(quantity.value),
        _ => Err(format!("it is measured in {unit}, not in `{}`", text[quantity.unit_start..].trim())),
    }
}

/// A time (s) that an option gives.
pub(super) fn time(text: &str) -> Result<f64, String> {
    in_unit(text, "s")
}

/// Zero for a number that is round-off of others of size `scale`.
pub(super) fn without_noise(x: f64, scale: f64) -> f64 {
    if SHOWN.hides(x, scale) { 0.0 } else { x }
}

/// Numbers of one column, their decimal points below each other: all of the same width.
pub(super) fn aligned(numbers: impl IntoIterator<Item = f64>) -> Vec<String> {
    let shown: Vec<String> = numbers.into_iter().map(number).collect();
    // Where the decimal point is, or would be.
    let point = |text: &String| text.find(['.', 'e']).unwrap_or(text.len());
    let before = shown.iter().map(point).max().unwrap_or(0);
    let after = shown.iter().map(|text| text.len() - point(text)).max().unwrap_or(0);
    let pad = |text: &String| {
        let point = point(text);
        format!("{:>before$}{:<after$}", &text[..point], &text[point..])
    };
    shown.iter().map(pad).collect()
}

/// A number of a table that programs read: the shortest digits that give the number back, with an exponent where that is shorter.
pub(super) fn exact(x: f64) -> String {
    format!("{x:?}")
}

/// `1st`, `2nd`, `13th`.
pub(super) fn ordinal(n: usize) -> String {
    let end = match (n % 100, n % 10) {
        (11..=13, _) => "th",
        (_, 1) => "st",
        (_, 2) => "nd",
        (_, 3) => "rd",
        _ => "th",
    };
    format!("{n}{end}")
}

/// `25 ×`, `0.31 ×`.
pub(super) fn times(factor: f64) -> String {
    if factor >= 10.0 { format!("{factor:.0} ×") } else { format!("{factor:.2} ×") }
}

#[cfg(test)]
mod tests {
    use super::{aligned, digits_apart, exact, in_unit, mean_and_deviation, natural, ordinal};

    #[test]
    fn options_have_units() {
        assert_eq!(
            [in_unit("0.5", "s"), in_unit("-500 ms", "s"), in_unit("2 kHz", "Hz")],
            [Ok(0.5), Ok(-0.5), Ok(2e3)]
        );
        assert_eq!(in_unit("2 mm", "s"), Err("it is measured in s, not in `mm`".to_owned()));
        assert!(in_unit("soon", "s").is_err());
    }

    #[test]
    fn numbers_of_one_thing_are_told_apart() {
        assert_eq!(digits_apart(&[0.78532, 0.78529, 0.78521]), 5);
        assert_eq!(digits_apart(&[1.0, 2.0, 2.0]), 4);
        assert_eq!(digits_apart(&[1.0, 1.0 + 1e-12]), 4);
        let [mean, deviation] = mean_and_deviation(&[1.0, 2.0, 3.0]);
        assert!((mean - 2.0).abs() < 1e-15 && (deviation - 1.0).abs() < 1e-15);
    }

    #[test]
    fn names_are_in_the_order_of_their_numbers() {
        let mut names = ["rocket_10", "rocket_2", "jack", "rocket_2b", "rocket_02", "2"];
        names.sort_by(|a, b| natural(a, b));
        assert_eq!(names, ["2", "jack", "rocket_02", "rocket_2", "rocket_2b", "rocket_10"]);
    }

    #[test]
    fn decimal_points_stand_below_each_other() {
        assert_eq!(aligned([0.5135, 73.57, -101.0, 2.5e-9]), ["   0.5135", "  73.57  ", "-101     ", "   2.5e-9"]);
        assert!(aligned([]).is_empty());
    }

    #[test]
    fn ordinals_end_as_they_are_said() {
        let shown = [1, 2, 3, 4, 11, 12, 13, 21, 102, 111, 1003].map(ordinal);
        assert_eq!(shown.join(" "), "1st 2nd 3rd 4th 11th 12th 13th 21st 102nd 111th 1003rd");
    }

    #[test]
    fn exact_numbers_come_back() {
        for x in [0.1 + 0.2, 1e300, 5e-324, -0.0, 1.0, 123456789.0] {
            assert_eq!(exact(x).parse::<f64>().map(f64::to_bits), Ok(x.to_bits()));
            assert!(exact(x).len() < 25);
        }
    }
}
