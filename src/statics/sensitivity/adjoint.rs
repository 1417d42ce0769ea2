//! Sensitivities to many numbers: what an output asks of the forces is found once, and no equilibrium beside this one is needed for a
//! number.
//!
//! ```text
//! z_k: the motions, zᵢᵀB z_k = δᵢₖ, at fixed numbers     G_k = d/dh y(q ⊞ h z_k),    Y_k = d/dh f(q ⊞ h z_k) = −K z_k
//! (4)  μᵀY_k + G_k = 0                for every k: one solution μ an output, of Kᵀ
//! (5)  dy/dp = ∂y/∂p + μᵀ ∂f/∂p       both at q, with the loops closed again
//! (6)  μ = Σ_k z_k Σ_j G_j z_jᵀB x_k,     K x_k = B z_k
//! ```
//!
//! (6) solves (4) by the factorization of the statics, which knows `K` and no transpose; what it leaves of (4) is solved for again, and what is
//! left then, with the errors of the differences, says how far `μ` may be off. A number costs the differences of (5) alone, an output those of its motions. What is not smooth, or not
//! known well enough in this way, is left to the other.

use super::{FARTHEST, FIRST, PROVED, SMALL, Study, ZERO};
use crate::extrapolate::{Derivative, derivative};
use crate::model::Parameter;

/// Differences of (5) whose error is a larger part of a derivative are left to the direct way, and so is a `μ` that may make it off by more than
/// the other part.
const KNOWN: f64 = 1e-8;
const BOUND: f64 = 1e-7;
/// Solutions of (4), the first included.
const ROUNDS: usize = 3;

/// What each row asks of the forces.
pub(super) struct Adjoint {
    /// Row by row, over the free coordinates: `μ`, and how far it may be off.
    multipliers: Vec<[Vec<f64>; 2]>,
}

/// The motions, and what each of them changes.
struct Motions {
    motions: Vec<Vec<f64>>,
    /// `G_k` of every row and `Y_k`, and their errors.
    changes: Vec<Derivative>,
    /// `z_jᵀB x_k`, by `k`, then `j`.
    inverse: Vec<Vec<f64>>,
}

impl Adjoint {
    /// Of a study to so many numbers; `None` if they are no more than the motions, or if something is not smooth along one of these.
    pub(super) fn of(study: &mut Study<'_>, numbers: usize, go_on: &dyn Fn() -> bool) -> Option<Self> {
        // No solution costs less than three numbers.
        if study.neutral || numbers <= 3 || study.levers.is_empty() {
            return None;
        }
        let motions = study.moving.motions(study.q, 0.0).ok()?;
        if motions.is_empty() || motions.len() >= numbers {
            return None;
        }
        let mut changes = Vec::with_capacity(motions.len());
        for motion in &motions {
            if !go_on() {
                return None;
            }
            changes.push(study.along_motion(motion)?);
        }
        let inertia = study.moving.metric().inertia.clone();
        let weighed = |x: &[f64]| x.iter().zip(&inertia).map(|(x, b)| b * x).collect::<Vec<f64>>();
        let pushes: Vec<Vec<f64>> = motions.iter().map(|motion| weighed(motion)).collect();
        let answers = study.moving.answers(study.q, 0.0, &pushes).ok()?;
        let inverse = answers.iter().map(|answer| pushes.iter().map(|push| dot(push, answer)).collect()).collect();
        let all = Motions { motions, changes, inverse };
        let multipliers =
            (0..study.rows.len()).map(|row| all.multipliers(row, study.rows.len())).collect::<Option<_>>()?;
        Some(Self { multipliers })
    }

    /// One column, by (5); `None` if that is not known well enough.
    pub(super) fn by<'a>(&self, study: &mut Study<'a>, one: &'a Parameter, value: f64) -> Option<Vec<Option<f64>>> {
        let varied = study.moving.vary_by(std::slice::from_ref(one), value);
        let found = varied.ok().and_then(|()| self.column(study, one, value));
        study.moving.vary_by(&[], value).ok()?;
        found
    }

    /// (5), both of its terms as one function of the number: what cancels in their sum is no error of it.
    fn column(&self, study: &mut Study<'_>, one: &Parameter, value: f64) -> Option<Vec<Option<f64>>> {
        let (unit, rows) = (study.unit(one, value), study.rows.len());
        let none = vec![0.0; study.levers.len()];
        let sums = |all: &[f64]| -> Vec<f64> {
            let of = |(y, [multipliers, _]): (&f64, &[Vec<f64>; 2])| y + dot(multipliers, &all[rows..]);
            all.iter().zip(&self.multipliers).map(of).collect()
        };
        let round_off =
            |(noise, [multipliers, _]): (&f64, &[Vec<f64>; 2])| noise + together(multipliers, &study.noise[rows..]);
        let noise: Vec<f64> = study.noise.iter().zip(&self.multipliers).map(round_off).collect();
        let sizes: Vec<f64> = study.units.iter().map(|size| SMALL * size / unit).collect();
        let (center, mut after, mut change) = (sums(&study.center), None, None);
        let mut of = |h: f64| {
            let all = study.along(&none, value, h)?;
            match (h > 0.0, &after) {
                (true, None) => after = Some(all[rows..].to_vec()),
                // How forces change, as far as what is off in the multipliers asks for it: over the largest distance.
                (false, Some(after)) if change.is_none() => {
                    change =
                        Some(after.iter().zip(&all[rows..]).map(|(a, b)| (a - b) / (-2.0 * h)).collect::<Vec<f64>>());
                }
                _ => {}
            }
            Ok(sums(&all))
        };
        let found = derivative(&mut of, &center, FIRST * unit, (&sizes, &noise)).ok()?;
        // At the end of what is allowed there is one side only.
        let change = change.filter(|_| !found.kinks.contains(&true))?;
        let mut column = Vec::with_capacity(rows);
        for (row, [_, off]) in self.multipliers.iter().enumerate() {
            let (x, error) = (found.value[row], found.error[row]);
            let round_off = ZERO * study.units[row] / unit;
            let is_known = |error: f64, part: f64| error <= (part * x.abs()).max(round_off);
            if !(is_known(error, KNOWN) && is_known(together(off, &change), BOUND)) {
                return None;
            }
            column.push(Some(if x.abs() <= round_off { 0.0 } else { x }));
        }
        Some(column)
    }
}

impl Motions {
    /// `μ` of a row, and how far it may be off; `None` if (4) does not hold.
    fn multipliers(&self, row: usize, rows: usize) -> Option<[Vec<f64>; 2]> {
        let asked: Vec<f64> = self.changes.iter().map(|change| change.value[row]).collect();
        let most = asked.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let mut multipliers = vec![0.0; self.motions[0].len()];
        let left = |multipliers: &[f64]| -> Vec<f64> {
            let of = |(change, asked): (&Derivative, &f64)| asked + dot(multipliers, &change.value[rows..]);
            self.changes.iter().zip(&asked).map(of).collect()
        };
        let unsure = |multipliers: &[f64]| -> Vec<f64> {
            let of = |change: &Derivative| change.error[row] + together(multipliers, &change.error[rows..]);
            self.changes.iter().map(of).collect()
        };
        // Differences have fewer digits than the factorization: what they do not tell from zero is not solved for.
        for _ in 0..ROUNDS {
            let more = self.solved(&left(&multipliers));
            multipliers.iter_mut().zip(&more).for_each(|(x, more)| *x += more);
            if left(&multipliers).iter().zip(&unsure(&multipliers)).all(|(x, unsure)| x.abs() <= *unsure) {
                break;
            }
        }
        let left: Vec<f64> =
            left(&multipliers).iter().zip(unsure(&multipliers)).map(|(x, unsure)| x.abs().max(unsure)).collect();
        if left.iter().any(|x| !(*x <= PROVED * most)) {
            return None;
        }
        let off = self.off(&left);
        Some([multipliers, off])
    }

    /// (6) for these `G_j`.
    fn solved(&self, asked: &[f64]) -> Vec<f64> {
        let mut found = vec![0.0; self.motions[0].len()];
        for (motion, inverse) in self.motions.iter().zip(&self.inverse) {
            let part = dot(asked, inverse);
            found.iter_mut().zip(motion).for_each(|(x, z)| *x += part * z);
        }
        found
    }

    /// How far (6) is off if the `G_j` are by so much.
    fn off(&self, asked: &[f64]) -> Vec<f64> {
        let parts: Vec<f64> = self.inverse.iter().map(|inverse| together(asked, inverse)).collect();
        let free = 0..self.motions[0].len();
        free.map(|i| parts.iter().zip(&self.motions).map(|(part, z)| (part * z[i]).powi(2)).sum::<f64>().sqrt())
            .collect()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The error of [`dot`], that of each factor `b` being by chance and its own.
fn together(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a * b).powi(2)).sum::<f64>().sqrt()
}

impl Study<'_> {
    /// Derivatives of the rows and the unbalanced forces along a motion at fixed numbers; `None` if they are not smooth.
    fn along_motion(&mut self, motion: &[f64]) -> Option<Derivative> {
        let fastest = motion.iter().zip(&self.levers).map(|(x, lever)| x.abs() / lever).fold(0.0, f64::max);
        let unit = 1.0 / fastest.max(f64::MIN_POSITIVE);
        let sizes: Vec<f64> = self.units.iter().chain(&self.forces).map(|size| SMALL * size / unit).collect();
        let (center, noise) = (self.center.clone(), self.noise.clone());
        let along = &mut |h: f64| self.along(motion, 0.0, h);
        let found = derivative(along, &center, FARTHEST * unit, (&sizes, &noise)).ok()?;
        (!found.kinks.contains(&true)).then_some(found)
    }
}
