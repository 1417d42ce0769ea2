//! How a number of a scene is distributed.
//!
//! A distribution is asked for its quantile function `F⁻¹` alone: every way to sample gives probabilities `u` in (0, 1), and
//! `x = F⁻¹(u)` has the distribution.

use crate::model::problem::counted;
use crate::quantity::{Dimension, Quantity};
use statrs::distribution::{ContinuousCDF, Normal};
use std::fmt;

/// The largest number below 1.
pub(super) const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;

/// A distribution of a real number, in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Distribution {
    /// Normal: mean and standard deviation ≥ 0.
    Normal(f64, f64),
    /// Between two ends, every number as likely as any other.
    Uniform(f64, f64),
    /// Of a positive number whose logarithm is normal: mean > 0 and standard deviation ≥ 0 of the number itself.
    Lognormal(f64, f64),
    /// Low end, mode and high end.
    Triangular(f64, f64, f64),
}

/// What may be written.
pub const FORMS: &str =
    "normal(mean, deviation), lognormal(mean, deviation), uniform(low, high) or triangular(low, mode, high)";

impl Distribution {
    /// Reads `normal(5, 0.1)`; the numbers may have units of one kind: `normal(2 kg, 100 g)`. With it the median, as it may be
    /// written in a file with the first of these units.
    ///
    /// # Errors
    /// What is wrong with it: no such distribution, too few numbers, units of two kinds or a number without one beside others, a
    /// negative deviation, ends the wrong way round.
    pub fn parse(text: &str) -> Result<(Self, String), String> {
        let inner = text.trim().strip_suffix(')').and_then(|text| text.split_once('('));
        let (name, inner) = inner.ok_or_else(|| format!("`{text}` is no distribution: write {FORMS}"))?;
        let numbers = inner.split(',').map(|part| number(part.trim())).collect::<Result<Vec<_>, _>>()?;
        let Written { dimension, unit, .. } = numbers[0];
        // An angle has a kind of its own: `deg` beside a number without a unit would be radians.
        let fits = |other: &Written<'_>| other.dimension == dimension && other.unit.is_empty() == unit.is_empty();
        if !numbers.iter().all(fits) {
            return Err(format!(
                "the numbers of `{text}` have units that measure different things, or only some have one"
            ));
        }
        let of = |values: Vec<f64>| Self::of(name.trim(), &values).map_err(|why| format!("`{text}`: {why}"));
        let found = of(numbers.iter().map(|one| one.value).collect())?;
        let median = match numbers.iter().all(|other| other.unit == unit) {
            true => of(numbers.iter().map(|one| one.number).collect())?.quantile(0.5),
            false => found.quantile(0.5) / number(&format!("1 {unit}"))?.value,
        };
        Ok((found, format!("{median:?} {unit}").trim_end().to_owned()))
    }

    fn of(name: &str, values: &[f64]) -> Result<Self, String> {
        let found = match (name, values) {
            ("normal", [mean, deviation]) => Self::Normal(*mean, *deviation),
            ("uniform", [low, high]) => Self::Uniform(*low, *high),
            ("lognormal", [mean, deviation]) => Self::Lognormal(*mean, *deviation),
            ("triangular", [low, mode, high]) => Self::Triangular(*low, *mode, *high),
            ("normal" | "uniform" | "lognormal" | "triangular", _) => {
                return Err(format!("{} written: write {FORMS}", counted(values.len(), "number is", "numbers are")));
            }
            _ => return Err(format!("there is no distribution `{name}`: write {FORMS}")),
        };
        found.check()?;
        Ok(found)
    }

    fn check(&self) -> Result<(), String> {
        match *self {
            Self::Normal(_, deviation) | Self::Lognormal(_, deviation) if deviation < 0.0 => {
                Err(format!("the standard deviation is {deviation:?}, and it is not negative"))
            }
            Self::Lognormal(mean, _) if !(mean > 0.0) => {
                Err(format!("the mean is {mean:?}, and that of a lognormal number is positive"))
            }
            Self::Uniform(low, high) if !(low <= high) => {
                Err(format!("the low end {low:?} is above the high end {high:?}"))
            }
            Self::Triangular(low, mode, high) if !(low <= mode && mode <= high) => {
                Err(format!("low end, mode and high end are in this order, not {low:?}, {mode:?}, {high:?}"))
            }
            _ => Ok(()),
        }
    }

    /// The number below which a part `u` of all numbers is, 0 < u < 1.
    pub fn quantile(&self, u: f64) -> f64 {
        match *self {
            Self::Normal(mean, deviation) => mean + deviation * standard_normal(u),
            Self::Uniform(low, high) => low + (high - low) * u,
            Self::Lognormal(mean, deviation) => {
                // Of ln x: variance s² = ln(1 + (deviation / mean)²), mean ln(mean) − s²/2.
                let variance = (deviation / mean).powi(2).ln_1p();
                mean * (variance.sqrt() * standard_normal(u) - 0.5 * variance).exp()
            }
            Self::Triangular(low, mode, high) if high > low => {
                let width = high - low;
                match u * width < mode - low {
                    true => low + (u * width * (mode - low)).sqrt(),
                    false => high - ((1.0 - u) * width * (high - mode)).sqrt(),
                }
            }
            Self::Triangular(low, ..) => low,
        }
    }
}

impl fmt::Display for Distribution {
    /// As it may be written, in SI units.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Normal(mean, deviation) => write!(f, "normal({mean:?}, {deviation:?})"),
            Self::Uniform(low, high) => write!(f, "uniform({low:?}, {high:?})"),
            Self::Lognormal(mean, deviation) => write!(f, "lognormal({mean:?}, {deviation:?})"),
            Self::Triangular(low, mode, high) => write!(f, "triangular({low:?}, {mode:?}, {high:?})"),
        }
    }
}

/// Quantile function of the normal distribution of mean 0 and standard deviation 1.
pub fn standard_normal(u: f64) -> f64 {
    Normal::standard().inverse_cdf(u)
}

/// Distribution function of the normal distribution of mean 0 and standard deviation 1.
pub fn standard_normal_below(z: f64) -> f64 {
    Normal::standard().cdf(z)
}

/// A number in SI units, as it may be written with a unit; empty for none.
pub(super) fn written(value: f64, unit: &str) -> String {
    let factor = if unit.is_empty() { 1.0 } else { number(&format!("1 {unit}")).map_or(1.0, |one| one.value) };
    format!("{:?} {unit}", value / factor).trim_end().to_owned()
}

/// A number with a unit, as it is written.
#[derive(Debug, Clone, Copy)]
struct Written<'t> {
    /// In its unit.
    number: f64,
    /// In SI units and radians.
    value: f64,
    /// What it measures.
    dimension: Dimension,
    /// Empty for none.
    unit: &'t str,
}

fn number(text: &str) -> Result<Written<'_>, String> {
    let found = Quantity::parse(text).map_err(|error| format!("`{text}`: {error}"))?;
    let (written, unit) = text.split_at(found.unit_start);
    let written = Quantity::parse(written).map_err(|error| format!("`{text}`: {error}"))?;
    Ok(Written { number: written.value, value: found.value, dimension: found.dimension, unit: unit.trim() })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Distribution; 4] = [
        Distribution::Normal(3.0, 0.5),
        Distribution::Uniform(-1.0, 2.0),
        Distribution::Lognormal(2.0, 0.4),
        Distribution::Triangular(1.0, 1.5, 4.0),
    ];

    /// Mean and standard deviation, by the midpoint rule in u: its error falls as the tails of the quantile function.
    #[test]
    fn quantiles_have_the_moments_of_the_distribution() {
        let exact = [(3.0, 0.5), (0.5, 3.0 / 12_f64.sqrt()), (2.0, 0.4), (6.5 / 3.0, (7.75_f64 / 18.0).sqrt())];
        let count = 1_000_000;
        for (one, (mean, deviation)) in ALL.iter().zip(exact) {
            let at = |k: usize| one.quantile((k as f64 + 0.5) / f64::from(count));
            let of = |f: &dyn Fn(f64) -> f64| (0..count as usize).map(|k| f(at(k))).sum::<f64>() / f64::from(count);
            let first = of(&|x| x);
            let second = of(&|x| (x - first).powi(2)).sqrt();
            assert!((first - mean).abs() < 1e-5 * mean.abs(), "{one}: mean {first}");
            assert!((second - deviation).abs() < 2e-5 * deviation, "{one}: deviation {second}, not {deviation}");
        }
    }

    #[test]
    fn what_is_shown_is_what_is_read() {
        for one in ALL {
            assert_eq!(Distribution::parse(&one.to_string()).map(|(read, _)| read), Ok(one));
        }
        let of_unit = (Distribution::Normal(0.3, 0.001), "300.0 mm".to_owned());
        assert_eq!(Distribution::parse("normal(300 mm, 1 mm)"), Ok(of_unit));
        let (of_units, median) = Distribution::parse("normal(2 kg, 100 g)").expect("masses");
        assert_eq!((of_units, median.as_str()), (Distribution::Normal(2.0, 0.1), "2.0 kg"));
        let (of_units, median) = Distribution::parse("uniform(900 mm, 1.1 m)").expect("lengths");
        assert_eq!((of_units, median.as_str()), (Distribution::Uniform(0.9, 1.1), "1000.0 mm"));
        assert_eq!(Distribution::parse(" uniform( 1 , 1 ) ").map(|(one, _)| one.quantile(0.3)), Ok(1.0));
    }

    #[test]
    fn what_is_no_distribution_is_refused_with_the_reason() {
        for (text, word) in [
            ("5", "is no distribution"),
            ("normal(1, -2)", "is not negative"),
            ("normal(1)", "1 number is written"),
            ("normal(1, 2, 3)", "3 numbers are written"),
            ("normal(1, nan)", "nan"),
            ("normal(1 m, 2 kg)", "measure different things"),
            ("normal(1 m, 2)", "only some have one"),
            ("normal(1 rad, 2)", "only some have one"),
            ("normal()", "begins with a number"),
            ("normal(1e400,5)", "larger than any"),
            ("uniform(-1e999 mm,5 mm)", "larger than any"),
            ("lognormal(0, 1)", "positive"),
            ("uniform(2, 1)", "above the high end"),
            ("triangular(1, 3, 2)", "in this order"),
            ("gauss(1, 2)", "no distribution `gauss`"),
            ("normal(1, 2", "is no distribution"),
            ("normal(1, 1e999)", "1e999"),
        ] {
            let error = Distribution::parse(text).expect_err(text);
            assert!(error.contains(word), "{text}: {error}");
        }
    }
}
