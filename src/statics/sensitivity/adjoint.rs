//! Sensitivities to many numbers: what an output asks of the forces is found once, and no equilibrium beside this one is needed for a
//! number.
//!
//! ```text
//! z_k: the motions, at fixed numbers     G_k = d/dh y(q ⊞ h z_k),    Y_k = d/dh f(q ⊞ h z_k)
//! (4)  K μ = Σ B z_k G_k                  one solution an output
//! (5)  dy/dp = ∂y/∂p + μᵀ ∂f/∂p           both at q, with the loops closed again
//! (6)  Σ (μ·B z_k) Y_k + Σ B z_k G_k = 0  proves (4)
//! ```
//!
//! `K` is symmetric where all loads have a potential. A number costs the differences of (5) alone, an output those of its motions. What is not
//! smooth, or not known well enough in this way, is left to the other.

use super::{FARTHEST, FIRST, PROVED, SMALL, Study, ZERO};
use crate::extrapolate::derivative;
use crate::model::Parameter;

/// An error larger than this part of a derivative is left to the direct way.
const KNOWN: f64 = 1e-9;

/// What each row asks of the forces.
pub(super) struct Adjoint {
    /// Row by row: `μ`, over the free coordinates.
    multipliers: Vec<Vec<f64>>,
}

impl Adjoint {
    /// Of a study to so many numbers; `None` if they are no more than the motions, or if something is not smooth along one of these.
    pub(super) fn of(study: &mut Study<'_>, numbers: usize, go_on: &dyn Fn() -> bool) -> Option<Self> {
        // No solution costs less than three numbers.
        if study.neutral || numbers <= 3 || study.levers.is_empty() {
            return None;
        }
        let q = study.q;
        let motions = study.moving.motions(q, 0.0).ok()?;
        if motions.is_empty() || motions.len() >= numbers {
            return None;
        }
        let inertia = study.moving.metric().inertia.clone();
        let (count, free) = (study.rows.len(), inertia.len());
        let mut asked = vec![vec![0.0; free]; count];
        let mut slopes = Vec::with_capacity(motions.len());
        for motion in &motions {
            if !go_on() {
                return None;
            }
            let slope = study.along_motion(motion)?;
            for (asked, slope) in asked.iter_mut().zip(&slope) {
                (0..free).for_each(|i| asked[i] += inertia[i] * motion[i] * slope);
            }
            slopes.push(slope);
        }
        let mut multipliers = Vec::with_capacity(count);
        for asked in &asked {
            if asked.iter().all(|x| *x == 0.0) {
                multipliers.push(vec![0.0; free]);
                continue;
            }
            let answer = study.moving.answer(q, 0.0, asked, false).ok()?;
            let mut left = asked.clone();
            for (motion, slope) in motions.iter().zip(&slopes) {
                let part: f64 = (0..free).map(|i| answer[i] * inertia[i] * motion[i]).sum();
                (0..free).for_each(|i| left[i] += part * slope[count + i]);
            }
            let most = asked.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            if left.iter().any(|x| !(x.abs() <= PROVED * most)) {
                return None;
            }
            multipliers.push(answer);
        }
        Some(Self { multipliers })
    }

    /// One column, by (5); `None` if that is not known well enough.
    pub(super) fn by<'a>(&self, study: &mut Study<'a>, one: &'a Parameter, value: f64) -> Option<Vec<Option<f64>>> {
        let varied = study.moving.vary_by(std::slice::from_ref(one), value);
        let found = varied.ok().and_then(|()| self.column(study, one, value));
        study.moving.vary_by(&[], value).ok()?;
        found
    }

    fn column(&self, study: &mut Study<'_>, one: &Parameter, value: f64) -> Option<Vec<Option<f64>>> {
        let unit = study.unit(one, value);
        let sizes: Vec<f64> = study.units.iter().chain(&study.forces).map(|size| SMALL * size / unit).collect();
        let (center, noise) = (study.center.clone(), study.noise.clone());
        let none = vec![0.0; study.levers.len()];
        let found = derivative(&mut |h| study.along(&none, value, h), &center, FIRST * unit, (&sizes, &noise)).ok()?;
        if found.kinks.contains(&true) {
            return None;
        }
        let count = study.rows.len();
        let mut column = Vec::with_capacity(count);
        for (row, multipliers) in self.multipliers.iter().enumerate() {
            let sum = |of: &dyn Fn(f64, usize) -> f64| -> f64 {
                multipliers.iter().enumerate().map(|(i, x)| of(*x, count + i)).sum()
            };
            let x = found.value[row] + sum(&|x, i| x * found.value[i]);
            let error = found.error[row] + sum(&|x, i| (x * found.error[i]).abs());
            let round_off = ZERO * study.units[row] / unit;
            if !(error <= (KNOWN * x.abs()).max(round_off)) {
                return None;
            }
            column.push(Some(if x.abs() <= round_off { 0.0 } else { x }));
        }
        Some(column)
    }
}

impl Study<'_> {
    /// Derivatives of the rows and the unbalanced forces along a motion at fixed numbers; `None` if they are not smooth or not known.
    fn along_motion(&mut self, motion: &[f64]) -> Option<Vec<f64>> {
        let fastest = motion.iter().zip(&self.levers).map(|(x, lever)| x.abs() / lever).fold(0.0, f64::max);
        let unit = 1.0 / fastest.max(f64::MIN_POSITIVE);
        let sizes: Vec<f64> = self.units.iter().chain(&self.forces).map(|size| SMALL * size / unit).collect();
        let (center, noise) = (self.center.clone(), self.noise.clone());
        let along = &mut |h: f64| self.along(motion, 0.0, h);
        let found = derivative(along, &center, FARTHEST * unit, (&sizes, &noise)).ok()?;
        let known = |i: usize| found.error[i] <= KNOWN * found.value[i].abs().max(sizes[i]);
        (!found.kinks.contains(&true) && (0..sizes.len()).all(known)).then_some(found.value)
    }
}
