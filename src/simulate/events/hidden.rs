//! What an output that is an expression does between two looks: the range of its formula over all that its variables do there says whether it may
//! cross the value of an event.
//!
//! ```text
//! (1)  number of the scene over a stretch h:  within the hull of  a, a + h ȧ/3, b − h ḃ/3, b      (Bézier's points of the cubic)
//! (2)  time, numbers  →  expressions, by interval arithmetic (`crate::formula`)
//! ```
//!
//! A stretch in which that holds the value is halved, until the expression rises or falls through it all the way, as its rates at some places
//! on the cubics say, or nothing is left of it.

use super::Events;
use crate::formula::Formula;
use crate::integrate::Stepper;
use crate::model::{Model, Quantity, Watched};
use crate::round_off::WATCHED;
use crate::simulate::error::RunError;
use crate::simulate::problem::Equations;

/// Stretches looked at in one step, at most.
const MOST: u32 = 20_000;
/// A stretch is not shorter than this part of its step.
const FINEST: f64 = 1e-6;
/// Places of a stretch at which the rate of an expression has the sign of what it does from end to end, if it rises or falls all the way.
const PLACES: u32 = 16;
/// They lie at multiples of the golden ratio: no wave has the same phase at all of them.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// All outputs at one time within a step; not a number where they, or their rates, are not known.
#[derive(Debug, Default)]
struct Seen {
    time: f64,
    values: Vec<f64>,
    rates: Vec<f64>,
}

/// The expressions that events watch.
#[derive(Debug)]
pub(super) struct Hidden {
    /// Which number of all outputs, and the value that it crosses.
    watched: Vec<(usize, f64)>,
    /// All expressions, those first that others follow from.
    expressions: Vec<(usize, Formula)>,
    left: Seen,
    right: Seen,
    /// Of the time, and of the numbers of all outputs: ranges, and values and rates at one place.
    ranges: Vec<[f64; 2]>,
    values: Vec<f64>,
    rates: Vec<f64>,
    /// The last stretch (s), and how many there were in this step.
    length: f64,
    looked: u32,
}

impl Hidden {
    /// `None` for a model whose events watch no expression.
    pub(super) fn new(model: &Model) -> Option<Box<Self>> {
        let mut expressions = Vec::new();
        for output in &model.outputs {
            if let Quantity::Expression(expression) = &output.quantity {
                expressions.push((expression.depth, output.first, expression.formula.clone()));
            }
        }
        expressions.sort_by_key(|(depth, ..)| *depth);
        let watched: Vec<(usize, f64)> = model
            .events
            .iter()
            .filter_map(|event| match event.of {
                Watched::Output(number) if expressions.iter().any(|one| one.1 == number) => Some((number, event.value)),
                _ => None,
            })
            .collect();
        let expressions = expressions.into_iter().map(|(_, number, formula)| (number, formula)).collect();
        let (ranges, values, rates) = (Vec::new(), Vec::new(), Vec::new());
        let (left, right) = (Seen { time: f64::NAN, ..Seen::default() }, Seen::default());
        let new = Self { watched, expressions, left, right, ranges, values, rates, length: f64::INFINITY, looked: 0 };
        (!new.watched.is_empty()).then(|| Box::new(new))
    }

    /// A step begins.
    pub(super) fn begin(&mut self) {
        (self.left.time, self.length, self.looked) = (f64::NAN, f64::INFINITY, 0);
    }

    /// Whether an expression may cross the value of an event between left and right without that being seen at the ends.
    fn hides_any(&mut self) -> bool {
        let Self { expressions, left, right, ranges, .. } = self;
        if left.values.len() != right.values.len() {
            return false;
        }
        let h = right.time - left.time;
        ranges.clear();
        ranges.push([left.time, right.time]);
        ranges.extend((0..left.values.len()).map(|k| {
            let ([a, b], rates) = ([left.values[k], right.values[k]], [left.rates[k], right.rates[k]]);
            // Of a rate that is not known `min` and `max` take the other number.
            let turns = [a + h * rates[0] / 3.0, b - h * rates[1] / 3.0];
            [turns[0].min(turns[1]).min(a).min(b), turns[0].max(turns[1]).max(a).max(b)]
        }));
        for (number, formula) in expressions {
            ranges[*number + 1] = formula.range(ranges);
        }
        (0..self.watched.len()).any(|index| {
            let (number, value) = self.watched[index];
            let [low, high] = self.ranges[number + 1];
            let may = low <= value && value <= high && high - low > WATCHED.of(value.abs().max(1.0));
            may && !self.passes(number, value)
        })
    }

    /// Whether an expression goes through a value once, rising or falling all the way.
    fn passes(&mut self, number: usize, value: f64) -> bool {
        let [a, b] = [&self.left.values, &self.right.values].map(|all| all[number] - value);
        let along = |rates: &[f64]| rates[number] * (b - a) > 0.0;
        let ends = a * b <= 0.0 && along(&self.left.rates) && along(&self.right.rates);
        ends && (1..=PLACES).all(|k| {
            self.interpolate((f64::from(k) * GOLDEN).fract());
            self.rates[number + 1] * (b - a) > 0.0
        })
    }

    /// Values and rates at a part of the stretch: cubics, straight lines of numbers whose rates are not known, and expressions of both.
    fn interpolate(&mut self, s: f64) {
        let Self { expressions, left, right, values, rates, .. } = self;
        let h = right.time - left.time;
        values.clear();
        rates.clear();
        values.push(left.time + s * h);
        rates.push(1.0);
        for k in 0..left.values.len() {
            let (a, whole) = (left.values[k], right.values[k] - left.values[k]);
            let bend = |rate: f64| if rate.is_nan() { 0.0 } else { h * rate - whole };
            let [rise, fall] = [bend(left.rates[k]), bend(right.rates[k])];
            // a + s whole + s (1 − s) ((1 − s) rise − s fall)
            let (t, bow) = (1.0 - s, (1.0 - s) * rise - s * fall);
            values.push(a + s * whole + s * t * bow);
            rates.push((whole + (t - s) * bow - s * t * (rise + fall)) / h);
        }
        for (number, formula) in expressions {
            values[*number + 1] = formula.value(values);
            rates[*number + 1] = formula.variation(values, rates);
        }
    }
}

impl Events {
    /// A time from `left` to `right` up to which looks at both ends show what expressions do.
    pub(super) fn shown_until(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        [left, right]: [f64; 2],
    ) -> Result<f64, RunError> {
        let Some(mut hidden) = self.hidden.take() else { return Ok(right) };
        let found = self.halved(&mut hidden, motion, stepper, [left, right]);
        self.hidden = Some(hidden);
        found
    }

    fn halved(
        &mut self,
        hidden: &mut Hidden,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        [left, right]: [f64; 2],
    ) -> Result<f64, RunError> {
        if hidden.left.time != left {
            self.see(motion, stepper, left, &mut hidden.left)?;
        }
        let finest = FINEST * (stepper.time() - stepper.previous_time());
        let mut until = right.min(left + 2.0 * hidden.length);
        loop {
            self.see(motion, stepper, until, &mut hidden.right)?;
            hidden.looked += 1;
            let middle = left + 0.5 * (until - left);
            let ends = hidden.looked >= MOST || until - left <= finest || !(middle > left && middle < until);
            if ends || !hidden.hides_any() {
                break;
            }
            until = middle;
        }
        hidden.length = until - left;
        std::mem::swap(&mut hidden.left, &mut hidden.right);
        Ok(until)
    }

    fn see(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        time: f64,
        seen: &mut Seen,
    ) -> Result<(), RunError> {
        self.move_to(motion, stepper, time)?;
        seen.time = time;
        seen.values.clear();
        seen.rates.clear();
        if let Some([values, rates]) = self.outputs.as_mut().and_then(|all| all.seen(motion, time, &self.state)) {
            seen.values.extend_from_slice(values);
            seen.rates.extend_from_slice(rates);
        }
        Ok(())
    }
}
