//! Fixed steps where a formula of the time does something short.
//!
//! A pulse that is over within a step or two is another one to a method of fixed steps, which sees it at three places: `1 − cos` is a third
//! more than it is. Between two breaks of the timetable that are few steps apart, steps are as many times shorter as Simpson's rule needs,
//! which is what `rk4` makes of a force of the time alone,
//!
//! ```text
//! (1)  Σ_j |S_j − S_j'|  ≤  relative ∫ |a| dt + absolute · scale
//! ```
//!
//! with the rule on a step and on its halves, for every acceleration `a(t, q, v)` at the state in which the stretch begins: adaptive
//! quadrature, at the tolerances of the run. No errors of two steps cancel in it, so the shape is resolved and not its integral alone. A
//! polynomial of degree 3 takes one step. A stretch of more than [`MOST_STEPS`] is as the user has it.

use super::Run;
use crate::simulate::problem::Equations;
use crate::simulate::settings::Settings;

/// A stretch of so many steps resolves what it is taken for.
const MOST_STEPS: f64 = 50.0;
/// Steps that a stretch is divided into, at most.
const MOST_PARTS: u32 = 4096;
/// So many divisions, one after the other, have to do: a wave may vanish at all places of one.
const AGREE: u32 = 2;
/// The next division is finer by no more than this factor.
const FASTEST: f64 = 16.0;
/// (1) falls with the fourth power of the number of steps.
const ORDER: f64 = 4.0;

/// Accelerations within a step: at its quarters.
type Places = [Vec<f64>; 5];

impl Run<'_, '_> {
    /// The fixed `step` of a run (s), or the shorter one that is needed from a time (s) to the break that follows.
    pub(super) fn fine_step(&self, motion: &mut Equations, settings: &Settings, time: f64, step: f64) -> f64 {
        let Some([_, end]) = self.timetable.formula_stretch(time) else { return step };
        let length = end - time;
        if !(length > 0.0 && length <= MOST_STEPS * step) {
            return step;
        }
        // Where accelerations cannot be evaluated the first step says so.
        let parts = self.parts(motion, settings, [time, end]).unwrap_or(1);
        step.min(length / f64::from(parts))
    }

    /// How many equal steps (1) needs between two times (s); `None` if accelerations cannot be evaluated there.
    fn parts(&self, motion: &mut Equations, settings: &Settings, between: [f64; 2]) -> Option<u32> {
        let mut places: Places = [0; 5].map(|_| vec![0.0; self.state.velocity.len()]);
        let (mut parts, mut found, mut agree) = (1, 1, 0);
        while agree < AGREE && parts <= MOST_PARTS {
            let off = self.off(motion, settings, (between, parts), &mut places)?;
            let factor = if off <= 1.0 { 2.0 } else { (1.1 * off.powf(1.0 / ORDER)).ceil().clamp(2.0, FASTEST) };
            (found, agree) = match (off <= 1.0, agree) {
                (true, 0) => (parts, 1),
                (true, agree) => (found, agree + 1),
                (false, _) => (2 * parts, 0),
            };
            parts *= factor as u32;
        }
        Some(found)
    }

    /// The left side of (1) by the right one, the largest of all coordinates.
    fn off(
        &self,
        motion: &mut Equations,
        settings: &Settings,
        ([from, to], parts): ([f64; 2], u32),
        places: &mut Places,
    ) -> Option<f64> {
        let n = f64::from(parts);
        let at = |theta: f64| if theta < n { from + theta / n * (to - from) } else { to };
        let mut sums = vec![[0.0; 2]; self.state.velocity.len()];
        self.accelerations(motion, from, &mut places[0])?;
        for part in 0..parts {
            for (quarter, a) in places.iter_mut().enumerate().skip(1) {
                self.accelerations(motion, at(f64::from(part) + 0.25 * quarter as f64), a)?;
            }
            for (i, [off, size]) in sums.iter_mut().enumerate() {
                let [a, b, c, d, e] = places.each_ref().map(|a| a[i]);
                // (a + 4c + e)/6 less ((a + 4b + c) + (c + 4d + e))/12.
                *off += (a - 4.0 * b + 6.0 * c - 4.0 * d + e).abs() / (12.0 * n);
                *size += [a, b, c, d].map(f64::abs).iter().sum::<f64>() / (4.0 * n);
            }
            places.swap(0, 4);
        }
        let allowed = |(i, [off, size]): (usize, [f64; 2])| {
            let absolute = settings.absolute_tolerance * motion.velocity_scales[i] / (to - from);
            off / (settings.tolerance * size + absolute)
        };
        Some(sums.into_iter().enumerate().map(allowed).fold(0.0, f64::max))
    }

    /// `a` ← what the state accelerates with at a time (s).
    fn accelerations(&self, motion: &mut Equations, time: f64, a: &mut [f64]) -> Option<()> {
        motion.accelerations(time, &self.state.position, &self.state.velocity, a).ok()
    }
}
