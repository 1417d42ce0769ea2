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
//!
//! Of two numbers that loops or gears tie to each other (2) knows nothing: `a − 2 b` is anything that the one may be less anything that the
//! other may. Such an expression stays where it is if it does at both ends and in the middle, to what rounding makes of it (`noise.rs`) and
//! with rates that say so, and is at some places on the cubics no further off than these are in the middle. All that (2) allows it has to
//! come from what these numbers change it by one by one, so that nothing is left for a pulse.

use super::Events;
use super::noise::{Noise, expressions};
use crate::formula::Formula;
use crate::integrate::Stepper;
use crate::model::{Model, Watched};
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

/// Cubics show what an expression of them does if they are off by no more than this part of what (2) allows it.
const SHOWN: f64 = 1e-3;
/// The error of a cubic between two places, with the rates there, beside that in the middle: it is largest there, and of numbers that are not quite
/// of degree 4 somewhat further on.
const BESIDE: f64 = 2.0;

/// A pulse of what is held where it is is seen if it is higher than so many times what rounding makes of that. What (2) allows an expression beyond
/// the sum of what numbers change it by one by one is that, or what the expression bends by.
const LOW: f64 = 1e6;

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
    middle: Seen,
    right: Seen,
    /// Which of them may cross their values between left and right.
    suspects: Vec<usize>,
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
        let expressions = expressions(model);
        let watched: Vec<(usize, f64)> = model
            .events
            .iter()
            .filter_map(|event| match event.of {
                Watched::Output(number) if expressions.iter().any(|one| one.0 == number) => Some((number, event.value)),
                _ => None,
            })
            .collect();
        let new = Self {
            watched,
            expressions,
            left: Seen { time: f64::NAN, ..Seen::default() },
            middle: Seen::default(),
            right: Seen::default(),
            suspects: Vec::new(),
            ranges: Vec::new(),
            values: Vec::new(),
            rates: Vec::new(),
            length: f64::INFINITY,
            looked: 0,
        };
        (!new.watched.is_empty()).then(|| Box::new(new))
    }

    /// A step begins.
    pub(super) fn begin(&mut self) {
        (self.left.time, self.length, self.looked) = (f64::NAN, f64::INFINITY, 0);
    }

    /// Whether an expression may cross the value of an event between left and right without that being seen at the ends.
    fn hides_any(&mut self) -> bool {
        let Self { expressions, left, right, ranges, .. } = self;
        self.suspects.clear();
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
        for index in 0..self.watched.len() {
            let (number, value) = self.watched[index];
            let [low, high] = self.ranges[number + 1];
            let may = low <= value && value <= high && high - low > WATCHED.of(value.abs().max(1.0));
            if may && !self.passes(number, value) {
                self.suspects.push(index);
            }
        }
        !self.suspects.is_empty()
    }

    /// Whether all that may cross their values are at both ends where they are, and will be, though what they follow from moves.
    fn may_stay(&mut self, noise: &mut Noise) -> bool {
        let suspects = std::mem::take(&mut self.suspects);
        let may = suspects.iter().all(|index| {
            let number = self.watched[*index].0;
            let Self { left, right, ranges, .. } = self;
            let noise = noise.of_number(number, left.time, &left.values);
            let [begin, end] = [&*left, &*right].map(|seen| seen.rates[number] * (right.time - left.time));
            let all = [right.values[number] - left.values[number], begin, end];
            let [low, high] = ranges[number + 1];
            all.iter().all(|way| way.abs() <= noise) && high - low <= self.one_by_one(number) + LOW * noise
        });
        self.suspects = suspects;
        may
    }

    /// What the numbers that an expression follows from change it by over the stretch, one by one, their sizes added up.
    fn one_by_one(&mut self, number: usize) -> f64 {
        let Self { expressions, left, ranges, values, rates, .. } = self;
        values.clear();
        values.push(left.time);
        values.extend_from_slice(&left.values);
        let mut sum = 0.0;
        for one in 0..values.len() {
            let [low, high] = ranges[one];
            if low == high || expressions.iter().any(|(own, _)| own + 1 == one) {
                continue;
            }
            rates.clear();
            rates.resize(values.len(), 0.0);
            rates[one] = high - low;
            for (own, formula) in expressions.iter() {
                rates[*own + 1] = formula.variation(values, rates);
            }
            sum += rates[number + 1].abs();
        }
        sum
    }

    /// Whether they stay, the middle being known.
    fn stay(&mut self, noise: &mut Noise) -> bool {
        let suspects = std::mem::take(&mut self.suspects);
        let stay = suspects.iter().all(|index| {
            let number = self.watched[*index].0;
            let noise = noise.of_number(number, self.left.time, &self.left.values);
            let (at, [low, high]) = (self.left.values[number], self.ranges[number + 1]);
            let Some(middle) = self.middle.values.get(number).copied() else { return false };
            self.interpolate(0.5);
            let off = (self.values[number + 1] - middle).abs();
            let shows = (middle - at).abs() <= noise && off <= noise + SHOWN * (high - low);
            shows
                && (1..=PLACES).all(|k| {
                    self.interpolate((f64::from(k) * GOLDEN).fract());
                    (self.values[number + 1] - at).abs() <= noise + BESIDE * off
                })
        });
        self.suspects = suspects;
        stay
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
            if ends || !hidden.hides_any() || self.all_stay(hidden, motion, stepper, middle)? {
                break;
            }
            until = middle;
        }
        hidden.length = until - left;
        std::mem::swap(&mut hidden.left, &mut hidden.right);
        Ok(until)
    }

    /// Whether all that may cross their values between left and right stay where they are.
    fn all_stay(
        &mut self,
        hidden: &mut Hidden,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        middle: f64,
    ) -> Result<bool, RunError> {
        if !hidden.may_stay(&mut self.noise) {
            return Ok(false);
        }
        self.see(motion, stepper, middle, &mut hidden.middle)?;
        Ok(hidden.stay(&mut self.noise))
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
