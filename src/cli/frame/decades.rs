//! A logarithmic axis whose ticks are round numbers: 1, 2, 5 times powers of ten, or powers of ten alone.

use crate::model::problem::significant;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint, Ranged};
use std::ops::Range;

/// How far outside of the axis a number may be and still be drawn at its end.
const BESIDE: f64 = 1e-9;

/// A range of positive numbers on a logarithmic axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::cli) struct Decades {
    low: f64,
    high: f64,
}

impl Decades {
    /// From the one to the other, both positive.
    pub(in crate::cli) fn new(low: f64, high: f64) -> Self {
        Self { low, high }
    }

    /// Whole decades around the positive ones of some numbers.
    pub(in crate::cli) fn around(numbers: impl Iterator<Item = f64>) -> Self {
        let positive = numbers.filter(|x| *x > 0.0);
        let (low, high) = positive.fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
        if !(low <= high && high.is_finite()) {
            return Self::new(1.0, 10.0);
        }
        let (low, high) = (low.log10().floor(), high.log10().ceil());
        Self::new(10.0_f64.powf(low), 10.0_f64.powf(high.max(low + 1.0)))
    }

    /// A tick as it is written; ticks have one digit that is not zero.
    pub(in crate::cli) fn tick(x: &f64) -> String {
        significant(*x, 1)
    }
}

impl Ranged for Decades {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let part = (value / self.low).log10() / (self.high / self.low).log10();
        limit.0 + (part * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        let most = hint.max_num_points().max(1);
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let inside = |x: &f64| *x >= self.low * (1.0 - BESIDE) && *x <= self.high * (1.0 + BESIDE);
        let at = |powers: &mut dyn Iterator<Item = i32>, digits: &[f64]| -> Vec<f64> {
            powers
                .flat_map(|power| digits.iter().map(move |digit| digit * 10.0_f64.powi(power)))
                .filter(inside)
                .collect()
        };
        let all = at(&mut (first..=last), &[1.0, 2.0, 5.0]);
        if all.len() <= most {
            return all;
        }
        let stride = ((last - first) as usize + 1).div_ceil(most);
        at(&mut (first..=last).step_by(stride), &[1.0])
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

#[cfg(test)]
mod tests {
    use super::Decades;
    use plotters::coord::ranged1d::{BoldPoints, Ranged};

    #[test]
    fn ticks_say_exactly_where_they_stand() {
        for (low, high) in [(0.3, 80.0), (1e-9, 1e12), (0.018_35, 31.0), (1.0, 10.0), (4e-7, 3e-5), (2e5, 9e8)] {
            let axis = Decades::new(low, high);
            let ticks = axis.key_points(BoldPoints(11));
            assert!((2..=11).contains(&ticks.len()), "{ticks:?}");
            for tick in ticks {
                let said: f64 = Decades::tick(&tick).parse().expect("a number");
                assert!((said / tick - 1.0).abs() < 1e-14, "{said} at {tick}");
                let place = axis.map(&tick, (0, 100_000)) as f64 / 1e5;
                assert!((place - (said / low).log10() / (high / low).log10()).abs() < 1e-5, "{said}");
            }
        }
    }

    #[test]
    fn decades_are_whole_around_numbers() {
        assert_eq!(Decades::around([0.03, 7.0].into_iter()), Decades::new(0.01, 10.0));
        assert_eq!(Decades::around([100.0].into_iter()), Decades::new(100.0, 1000.0));
        assert_eq!(Decades::around([0.0, 300.0].into_iter()), Decades::new(100.0, 1000.0));
        assert_eq!(Decades::around([].into_iter()), Decades::new(1.0, 10.0));
    }
}
