//! Which cases a study has: the points of a grid, and samples of varied numbers at each.
//!
//! Case `c` of a plan with `n` samples is sample `c mod n` at point `c div n` of the grid, the last axis moving fastest. The
//! samples are the same at every point of the grid, so that what differs between two points is the grid's doing (common
//! random numbers).

use super::axis::Axis;
use super::correlation::Correlation;
use super::distribution::{Distribution, FORMS, written};
use super::sample::{Sampler, Sampling};
use std::fmt::Write;

/// A number of the scene with a distribution.
#[derive(Debug, Clone, PartialEq)]
pub struct Variation {
    /// As after `--set`.
    pub path: String,
    /// Of its value, in SI units.
    pub distribution: Distribution,
    /// The median, with the unit in which the distribution is written.
    pub median: String,
}

impl Variation {
    /// Reads `path=normal(5, 0.1)`.
    ///
    /// # Errors
    /// As [`Distribution::parse`].
    pub fn parse(text: &str) -> Result<Self, String> {
        let (path, written) = text.split_once('=').ok_or_else(|| format!("write a path and {FORMS}"))?;
        if path.trim().is_empty() {
            return Err(format!("write a path and {FORMS}"));
        }
        let written = written.trim().trim_matches(['"', '\'']);
        let (distribution, median) = Distribution::parse(written)?;
        Ok(Self { path: path.trim().to_owned(), distribution, median })
    }
}

impl Variation {
    /// A value in SI units, with the unit in which the distribution is written.
    pub fn written(&self, value: f64) -> String {
        written(value, self.median.split_once(' ').map_or("", |(_, unit)| unit))
    }
}

/// One number or word of a case.
#[derive(Debug, Clone, PartialEq)]
pub enum Value<'p> {
    /// Of an axis: as written, and its number if all values of the axis are numbers.
    Written(&'p str, Option<f64>),
    /// Of a distribution, in SI units.
    Drawn(f64),
}

/// What is drawn, and how.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Draw {
    /// The way to sample.
    pub sampling: Sampling,
    /// Samples at every point of the grid, ≥ 1.
    pub samples: u64,
    /// What the samples follow from.
    pub seed: u64,
}

impl Default for Draw {
    fn default() -> Self {
        Self { sampling: Sampling::default(), samples: 1, seed: 0 }
    }
}

/// All cases of a study.
#[derive(Debug, Clone)]
pub struct Plan {
    /// The grid.
    pub axes: Vec<Axis>,
    /// What is drawn at every point of it.
    pub varied: Vec<Variation>,
    /// How it is drawn.
    pub draw: Draw,
    /// The values of every axis as numbers.
    numbers: Vec<Option<Vec<f64>>>,
    sampler: Sampler,
    correlation: String,
    cases: u64,
}

/// More cases than this no study has.
pub const MOST_CASES: u64 = 1_000_000_000;

impl Plan {
    /// A plan. `correlation` is the text of a matrix, see [`Correlation::parse`].
    ///
    /// # Errors
    /// If there are more than [`MOST_CASES`], if the matrix is none, or if this way to sample cannot do it.
    pub fn new(axes: Vec<Axis>, varied: Vec<Variation>, draw: Draw, correlation: Option<&str>) -> Result<Self, String> {
        let points = axes.iter().try_fold(1_u64, |points, axis| points.checked_mul(axis.values.len() as u64));
        let cases = points.and_then(|points| points.checked_mul(draw.samples));
        let cases = cases
            .filter(|cases| *cases <= MOST_CASES)
            .ok_or_else(|| format!("the plan asks for more than {MOST_CASES} cases"))?;
        let addresses: Vec<&str> = varied.iter().map(|one| one.path.as_str()).collect();
        let correlation = correlation.map(|text| Correlation::parse(text, &addresses)).transpose()?;
        let text = correlation.as_ref().map_or(String::new(), Correlation::text);
        let sampler = Sampler::new((draw.sampling, draw.seed, draw.samples), varied.len(), correlation)?;
        let numbers = axes.iter().map(Axis::numbers).collect();
        Ok(Self { axes, varied, draw, numbers, sampler, correlation: text, cases })
    }

    /// Number of cases.
    pub fn cases(&self) -> u64 {
        self.cases
    }

    /// What is set: the axes, then what is drawn.
    pub fn paths(&self) -> impl Iterator<Item = &str> {
        self.axes.iter().map(|axis| axis.path.as_str()).chain(self.varied.iter().map(|one| one.path.as_str()))
    }

    /// Whether every value of a path is a number, in the order of [`paths`](Self::paths).
    pub fn are_numbers(&self) -> impl Iterator<Item = bool> {
        self.numbers.iter().map(Option::is_some).chain(self.varied.iter().map(|_| true))
    }

    /// The values of a case < [`cases`](Self::cases), in the order of [`paths`](Self::paths).
    pub fn values(&self, case: u64) -> Vec<Value<'_>> {
        let mut values = self.point(case / self.draw.samples);
        if !self.varied.is_empty() {
            let probabilities = self.sampler.probabilities(case % self.draw.samples);
            let drawn = self.varied.iter().zip(probabilities);
            values.extend(drawn.map(|(one, u)| Value::Drawn(one.distribution.quantile(u))));
        }
        values
    }

    /// Values of no case: the first or the last of every axis, and of every distribution the number below which a part `u` is.
    pub fn probe(&self, last: bool, u: f64) -> Vec<Value<'_>> {
        let points = self.cases / self.draw.samples;
        let mut values = self.point(if last { points - 1 } else { 0 });
        values.extend(self.varied.iter().map(|one| Value::Drawn(one.distribution.quantile(u))));
        values
    }

    /// The values of the axes at a point of the grid.
    fn point(&self, point: u64) -> Vec<Value<'_>> {
        let mut rest = point;
        let mut values = vec![Value::Written("", None); self.axes.len()];
        for (index, axis) in self.axes.iter().enumerate().rev() {
            let count = axis.values.len() as u64;
            let at = (rest % count) as usize;
            rest /= count;
            values[index] = Value::Written(&axis.values[at], self.numbers[index].as_ref().map(|numbers| numbers[at]));
        }
        values
    }

    /// Everything that the numbers of a case follow from.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for axis in &self.axes {
            let _ = writeln!(text, "over {:?} {:?}", axis.path, axis.values);
        }
        for one in &self.varied {
            let _ = writeln!(text, "vary {:?} {}", one.path, one.distribution);
        }
        let Draw { sampling, samples, seed } = self.draw;
        let _ = writeln!(text, "{} {samples} {seed} {}", sampling.name(), self.correlation);
        text
    }
}

/// Values as they are written after `--set`.
pub(super) fn texts(values: &[Value<'_>]) -> Vec<String> {
    let text = |value: &Value<'_>| match value {
        Value::Written(text, _) => (*text).to_owned(),
        Value::Drawn(number) => format!("{number:?}"),
    };
    values.iter().map(text).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(samples: u64) -> Plan {
        let axes = ["a=1,2", "b=x,y,z"].map(|text| Axis::parse(text).expect("an axis")).to_vec();
        let varied = vec![Variation::parse("c=uniform(0 mm, 1 mm)").expect("a distribution")];
        Plan::new(axes, varied, Draw { samples, seed: 5, ..Draw::default() }, None).expect("a plan")
    }

    #[test]
    fn the_last_axis_moves_fastest_and_samples_repeat_at_every_point() {
        let plan = plan(2);
        assert_eq!(plan.cases(), 12);
        assert_eq!(plan.paths().collect::<Vec<_>>(), ["a", "b", "c"]);
        assert_eq!(plan.are_numbers().collect::<Vec<_>>(), [true, false, true]);
        for case in 0..12 {
            let values = plan.values(case);
            let (a, b) = (["1", "2"][case as usize / 6], ["x", "y", "z"][case as usize / 2 % 3]);
            assert_eq!(values[0], Value::Written(a, a.parse().ok()));
            assert_eq!(values[1], Value::Written(b, None));
            assert_eq!(values[2], plan.values(case % 2)[2]);
            assert!(matches!(values[2], Value::Drawn(c) if c > 0.0 && c < 1e-3));
        }
        assert_ne!(plan.values(0)[2], plan.values(1)[2]);
    }

    #[test]
    fn more_cases_than_can_be_are_refused() {
        let axes = vec![Axis::parse("a=1:2:1000").expect("an axis"); 4];
        assert!(Plan::new(axes, Vec::new(), Draw::default(), None).expect_err("many").contains("more than 1000000000"));
        assert!(Variation::parse("=normal(1,2)").is_err() && Variation::parse("normal").is_err());
    }
}
