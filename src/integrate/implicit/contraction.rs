//! When an iteration of an implicit method may stop: one rule for single stages, coupled ones and the generalized-α method.
//!
//! With the contraction `θ` the error left after a change of norm `‖Δ‖` is about `θ/(1−θ) ‖Δ‖`. `θ` is taken over the
//! last two changes: a single quotient says little while the error's shape still changes. A change as small as rounding
//! ends the iteration too, and so does one that no longer shrinks where it is harmless.
//! Hairer, Wanner, *Solving ODEs II*, IV.8.

use crate::integrate::step::error::Limit;

/// A change of this size is given up: the contraction cannot be so poor at the first look that a thousandfold growth
/// is followed by convergence.
const HOPELESS: f64 = 1e3;

/// How exact an iteration has to be, in tolerances of a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Accuracy {
    /// Error that may be left.
    pub(crate) left: f64,
    /// A change that does not shrink further is harmless up to this size: it is rounding of the residual.
    pub(crate) stalled: f64,
    /// A better contraction is not believed. Of coupled stages in a stiff system the last ones are right at once, and
    /// their small changes say nothing of the first ones, to which that has yet to pass on.
    pub(crate) least_contraction: f64,
}

/// An iteration under way.
#[derive(Debug)]
pub(crate) struct Iteration {
    accuracy: Accuracy,
    /// Changes of the last iteration and of the one before.
    before: [Option<f64>; 2],
    /// The change of the first iteration.
    first: f64,
    done: u32,
    /// Iterations in which changes may grow.
    patience: u32,
    /// Iterations in which it is not given up.
    grace: u32,
    most: u32,
    contraction: f64,
    /// The contraction expected before one is seen.
    prior: Option<f64>,
}

impl Iteration {
    /// At most `most` iterations.
    pub(crate) fn new(accuracy: Accuracy, most: u32) -> Self {
        Self {
            accuracy,
            before: [None; 2],
            first: 0.0,
            done: 0,
            patience: 0,
            grace: 0,
            most,
            contraction: 0.0,
            prior: None,
        }
    }

    /// Judges the first change by a contraction seen elsewhere: of like stages with the same tangent.
    pub(crate) fn expecting(self, contraction: Option<f64>) -> Self {
        Self { prior: contraction, ..self }
    }

    /// Neither gives up nor takes changes for rounding in the first `iterations`: of coupled stages in a stiff system they may
    /// grow before they vanish. Nor does it give up in so many `more`.
    pub(crate) fn patient(self, iterations: u32, more: u32) -> Self {
        Self { patience: iterations, grace: iterations + more, ..self }
    }

    /// The contraction last seen; `None` before the second iteration.
    pub(crate) fn contraction(&self) -> Option<f64> {
        (self.done > 1).then_some(self.contraction)
    }

    /// Whether so many iterations or more ended with a contraction poorer than this.
    pub(crate) fn is_slow(&self, (iterations, contraction): (u32, f64)) -> bool {
        self.done >= iterations && self.contraction > contraction
    }

    /// About how many more iterations there are with this contraction; infinite where it is none.
    pub(crate) fn left(&self, contraction: f64) -> f64 {
        let to_go = self.before[0].map_or(0.0, |size| (self.accuracy.left / size).ln());
        if contraction < 1.0 { (to_go / contraction.ln()).max(0.0) } else { f64::INFINITY }
    }

    /// The error left after a change of this size.
    fn remaining(&self, contraction: f64, size: f64) -> f64 {
        let contraction = contraction.max(self.accuracy.least_contraction);
        contraction / (1.0 - contraction) * size
    }

    /// What an iteration that has stopped after a change of norm `size` leaves, by the contraction seen: one that is not believed before
    /// it stops is that of stiff parts, of which nothing adds up. Where changes shrink no longer that is the change itself.
    pub(crate) fn leaves(&self, size: f64) -> f64 {
        match self.contraction() {
            Some(contraction) if contraction < 1.0 => contraction / (1.0 - contraction) * size,
            _ => size,
        }
    }

    /// Whether the iteration may stop after a change of norm `size`, `rounding` being that of rounding.
    ///
    /// # Errors
    /// [`Limit::Newton`] where it diverges or is too slow.
    pub(crate) fn converged(&mut self, size: f64, rounding: f64) -> Result<bool, Limit> {
        self.done += 1;
        let before = self.before;
        self.before = [Some(size), before[0]];
        if self.done == 1 {
            self.first = size;
        }
        if let [Some(last), second] = before {
            self.contraction = second.map_or(size / last, |second| (size / second).sqrt());
        }
        if size <= rounding {
            return Ok(true);
        }
        if !size.is_finite() {
            return Err(Limit::Newton);
        }
        match self.judge(size, before) {
            Ok(false) if self.done >= self.most => Err(Limit::Newton),
            judged => judged,
        }
    }

    /// The rule itself, for a change above rounding with those before it.
    fn judge(&self, size: f64, before: [Option<f64>; 2]) -> Result<bool, Limit> {
        let [Some(last), second] = before else {
            let contraction = self.prior.filter(|prior| *prior < 1.0);
            return Ok(contraction.is_some_and(|prior| self.remaining(prior, size) <= self.accuracy.left));
        };
        if self.contraction < 1.0 {
            let remaining = self.remaining(self.contraction, size);
            let left = self.accuracy.left;
            let reachable = |contraction: f64| remaining * contraction.powi((self.most - self.done) as i32) <= left;
            // The first quotient is too poor a witness to give up on.
            if reachable(self.contraction) || second.is_none() || self.done <= self.patience {
                return Ok(remaining <= left);
            }
            // Hardly shrinking is as good as not shrinking.
            if size <= self.accuracy.stalled {
                return Ok(true);
            }
            if self.done <= self.grace {
                return Ok(false);
            }
            // Coupled stages of a stiff system turn as they shrink: of a slow stretch and the whole way the faster is believed.
            let whole = (size / self.first).powf(1.0 / f64::from(self.done - 1));
            return if reachable(whole) { Ok(false) } else { Err(Limit::Newton) };
        }
        match second {
            Some(_) if self.done <= self.patience && size <= HOPELESS * last => Ok(false),
            Some(_) if size <= self.accuracy.stalled => Ok(true),
            Some(_) if self.done <= self.grace && size <= HOPELESS * last => Ok(false),
            Some(_) => Err(Limit::Newton),
            None if self.done > self.patience && size <= self.accuracy.stalled => Ok(true),
            None if size > HOPELESS * last => Err(Limit::Newton),
            None => Ok(false),
        }
    }
}
