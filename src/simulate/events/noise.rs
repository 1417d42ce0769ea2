//! What rounding makes of the numbers that events watch.
//!
//! A number that loops, gears or drives keep at a value is never there but for rounding: a docked body has no distance from its port, and that
//! comes out on either side of zero. Such a number has crossed nothing until it has left what rounding makes of it:
//!
//! ```text
//! (1)  number of the scene:  part · max(size of the number, that of its unit in the scene)
//! (2)  expression:           how far it reaches over the noise of its numbers, by interval arithmetic
//! ```

use crate::formula::Formula;
use crate::model::{Model, Quantity};
use crate::round_off::{RoundOff, WATCHED, WATCHED_BESIDE_LOOPS};

/// The noise of watched numbers.
#[derive(Debug)]
pub(super) struct Noise {
    part: RoundOff,
    /// The scene's length (m).
    length: f64,
    /// What each number of all outputs is compared with, in its unit.
    sizes: Vec<f64>,
    /// All expressions, those first that others follow from.
    expressions: Vec<(usize, Formula)>,
    /// The time and the values that were asked about last, and what rounding makes of them.
    seen: Vec<f64>,
    ranges: Vec<[f64; 2]>,
}

impl Noise {
    pub(super) fn new(model: &Model) -> Self {
        let (length, time) = (model.length_scale(), model.time_scale());
        let size = |unit: &String| match unit.as_str() {
            "m" => length,
            "m/s" => length / time,
            "rad" | "1" => 1.0,
            "rad/s" => 1.0 / time,
            // Of a force or an energy nothing is known but how large it is.
            _ => 0.0,
        };
        Self {
            part: if model.is_constrained() { WATCHED_BESIDE_LOOPS } else { WATCHED },
            length,
            sizes: model.outputs.iter().flat_map(|output| &output.units).map(size).collect(),
            expressions: expressions(model),
            seen: Vec::new(),
            ranges: Vec::new(),
        }
    }

    /// Of a coordinate (rad, m) or a point (m).
    pub(super) fn of_place(&self, x: f64, is_distance: bool) -> f64 {
        self.part.of(x.abs().max(if is_distance { self.length } else { 1.0 }))
    }

    /// Of one of the numbers of all outputs, whose values at a time (s) these are; 0 where (2) does not end.
    pub(super) fn of_number(&mut self, number: usize, time: f64, values: &[f64]) -> f64 {
        if self.seen.split_first() != Some((&time, values)) {
            self.spread(time, values);
        }
        let (Some([low, high]), Some(x)) = (self.ranges.get(number + 1), values.get(number)) else { return 0.0 };
        Some((high - x).max(x - low)).filter(|noise| noise.is_finite()).unwrap_or(0.0)
    }

    /// What rounding makes of the time and of all numbers.
    fn spread(&mut self, time: f64, values: &[f64]) {
        let Self { part, sizes, expressions, seen, ranges, .. } = self;
        seen.clear();
        seen.push(time);
        seen.extend_from_slice(values);
        let about = |x: f64, size: f64| [x - part.of(x.abs().max(size)), x + part.of(x.abs().max(size))];
        ranges.clear();
        ranges.push([time; 2]);
        ranges.extend(values.iter().zip(sizes.iter()).map(|(x, size)| about(*x, *size)));
        for (at, formula) in expressions.iter() {
            ranges[*at + 1] = formula.range(ranges);
        }
    }
}

/// The outputs that are expressions, by their numbers among all outputs, those first that others follow from.
pub(super) fn expressions(model: &Model) -> Vec<(usize, Formula)> {
    let mut found = Vec::new();
    for output in &model.outputs {
        if let Quantity::Expression(expression) = &output.quantity {
            found.push((expression.depth, output.first, expression.formula.clone()));
        }
    }
    found.sort_by_key(|(depth, ..)| *depth);
    found.into_iter().map(|(_, number, formula)| (number, formula)).collect()
}
