//! The release of the guess: it is held by forces, and these are let go (a Newton homotopy).
//!
//! At the guess `q₀` the forces `f(q₀)` are left in the hinges. Together with forces that hold it, the guess is in
//! balance; the family
//!
//! ```text
//! f(q) − (1 − λ) f(q₀) = 0,     λ from 0 to 1                                                 (1)
//! ```
//!
//! leads from it to a balance of the scene itself. Its curve is followed by arclength, so that it may turn back on its
//! way: there Newton's method, which asks for less force in every step, has nowhere to go.

use super::curve::{Curve, Direction, Family, Look, Metric};
use crate::dynamics::Fault;
use crate::statics::effort::Iteration;
use crate::statics::problem::Landscape;
use crate::statics::problem::place::{Place, SHIFT};
use crate::statics::watch::Watch;

/// Steps along the curve, and their largest size: 1 is all of the load, or a radian or a length of every coordinate.
const MOST_STEPS: usize = 400;
const LARGEST: f64 = 0.1;
const SMALLEST: f64 = 1e-7;
/// A curve that goes this far does not come back.
const FAR: f64 = 200.0;

struct Release<'l, 's> {
    landscape: &'l mut Landscape<'s>,
    held: Vec<f64>,
}

impl Family for Release<'_, '_> {
    fn look(&mut self, q: &[f64], parameter: f64) -> Result<Look, String> {
        let mut look = || -> Result<Look, Fault> {
            let mut place = Place::at(self.landscape, q.to_vec())?;
            self.landscape.look(q)?;
            // What the rows carry of them is theirs.
            let held = self.landscape.along_rows(q, &self.held)?;
            for (i, held) in held.iter().enumerate() {
                place.force[i] -= (1.0 - parameter) * held;
                place.scales.force[i] += ((1.0 - parameter) * held).abs();
            }
            let none = vec![0.0; place.force.len()];
            let mut newton = self.landscape.newton_shifted(&place.force, &none);
            if newton.is_none() {
                let shift = self.landscape.shift(&place, SHIFT);
                newton = self.landscape.newton_shifted(&place.force, &shift);
            }
            let newton = newton.unwrap_or_else(|| vec![f64::NAN; place.force.len()]);
            let slope = self.landscape.solve(&self.held);
            Ok(Look { place, newton, slope })
        };
        look().map_err(|fault| fault.to_string())
    }

    fn moved(&mut self, q: &[f64], x: &[f64]) -> Vec<f64> {
        self.landscape.moved(q, x)
    }
}

/// Runs from the guess; the answer is balanced or the guess.
pub(in crate::statics) fn run(
    landscape: &mut Landscape<'_>,
    guess: &Place,
    history: &mut Vec<Iteration>,
) -> Result<Place, Fault> {
    let watch = landscape.watch;
    let metric = Metric { inertia: landscape.metric.clone(), reach: landscape.reach(), range: 1.0 };
    let held = guess.force.clone();
    let reached = {
        let mut family = Release { landscape, held };
        let mut curve = Curve::new(&mut family, metric);
        follow(&mut curve, guess, history, &|| watch.is_none_or(Watch::goes_on))
    };
    match reached {
        // Without the forces that held the guess, to the last digit.
        Some(q) => Place::at(landscape, q),
        None => Ok(guess.clone()),
    }
}

/// Along the curve from λ = 0 to 1; `None` if it does not get there.
fn follow(
    curve: &mut Curve<'_>,
    guess: &Place,
    history: &mut Vec<Iteration>,
    go_on: &dyn Fn() -> bool,
) -> Option<Vec<f64>> {
    let still = vec![0.0; guess.force.len()];
    let towards = Direction { x: still, parameter: 1.0 };
    let mut here = curve.correct(guess.q.clone(), 0.0, &towards, LARGEST)?;
    let (mut step, mut travelled) = (0.25 * LARGEST, 0.0);
    for _ in 0..MOST_STEPS {
        if !go_on() {
            return None;
        }
        let Some(next) = curve.step(&here, step) else {
            step *= 0.4;
            if step < SMALLEST {
                return None;
            }
            continue;
        };
        let left = (1.0 - next.parameter).abs();
        history.push(Iteration { stage: "release", residual: left, step, shift: 0.0 });
        if next.parameter >= 1.0 {
            let ends = [(0.0, here.parameter - 1.0), (step, next.parameter - 1.0)];
            let (_, point) = curve.root(&here, ends, 1e-12, &mut |_, point| Some(point.parameter - 1.0))?;
            return Some(point.place.q);
        }
        travelled += step;
        if travelled > FAR {
            return None;
        }
        let factor = [2.0, 2.0, 1.6, 1.2, 1.0].get(next.iterations).copied().unwrap_or(0.6);
        step = (step * factor).min(LARGEST);
        here = next;
    }
    None
}
