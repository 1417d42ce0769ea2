//! How hinge coordinates follow from hinge velocities: those of spherical hinges are quaternions, all others integrate.
//!
//! ```text
//! (1)  ṗ = ½ p ∘ (0, ω)                                      p a quaternion, ω in the axes that it leads from
//! (2)  (1 − ½ h Ω) p = p*,   p = (p* + ½ h Ω p*) / (1 + ¼ h² |ω|²)      Ω skew, Ω² = −|ω|²;  an implicit step
//! ```

use crate::model::Model;
use crate::round_off::UNIT_NORM;
use std::ops::Range;

/// Coordinates one after the other that step alike.
enum Run {
    /// Of turns and slides, whose rates are the velocities.
    Plain { positions: Range<usize>, velocities: Range<usize> },
    /// The numbers of a quaternion and the angular velocities, from these places on.
    Ball(usize, usize),
}

/// The coordinates of a model; a long chain of revolute hinges is one run.
pub(super) struct Coordinates(Vec<Run>);

impl Coordinates {
    /// The runs of coordinates of a model.
    pub(super) fn new(model: &Model) -> Self {
        let mut runs = Vec::new();
        for link in &model.links {
            let (at, from) = (link.position, link.velocity);
            if link.joint.is_flex() {
                let count = link.joint.counts().0;
                runs.push(Run::Plain { positions: at..at + count, velocities: from..from + count });
                continue;
            }
            match (link.joint.counts().0, runs.last_mut()) {
                (0, _) => {}
                (4, _) => runs.push(Run::Ball(at, from)),
                (_, Some(Run::Plain { positions, velocities })) if positions.end == at && velocities.end == from => {
                    (positions.end, velocities.end) = (at + 1, from + 1);
                }
                _ => runs.push(Run::Plain { positions: at..at + 1, velocities: from..from + 1 }),
            }
        }
        Self(runs)
    }

    /// `rate` ← q̇ of positions `q` and velocities `v`, by (1).
    pub(super) fn rate(&self, q: &[f64], v: &[f64], rate: &mut [f64]) {
        for run in &self.0 {
            match run {
                Run::Plain { positions, velocities } => rate[positions.clone()].copy_from_slice(&v[velocities.clone()]),
                Run::Ball(at, from) => {
                    rate[*at..at + 4].copy_from_slice(&half_product(&q[*at..at + 4], &v[*from..from + 3]));
                }
            }
        }
    }

    /// Brings quaternions back to unit length.
    pub(super) fn normalize(&self, q: &mut [f64]) {
        for run in &self.0 {
            if let Run::Ball(at, _) = run {
                let p = &mut q[*at..at + 4];
                let square = p.iter().map(|x| x * x).sum::<f64>();
                // What has been normalised stays, so that a state is the same whoever takes it up again.
                if (square - 1.0).abs() > UNIT_NORM.of(1.0) {
                    let norm = square.sqrt();
                    p.iter_mut().for_each(|x| *x /= norm);
                }
            }
        }
    }

    /// `q` ← positions at the end of an implicit step (s) from `start`, whose velocities there are `v`; by (2).
    pub(super) fn implicit(&self, start: &[f64], step: f64, v: &[f64], q: &mut [f64]) {
        for run in &self.0 {
            match run {
                Run::Plain { positions, velocities } => {
                    let known = start[positions.clone()].iter().zip(&v[velocities.clone()]);
                    q[positions.clone()].iter_mut().zip(known).for_each(|(q, (start, v))| *q = start + step * v);
                }
                Run::Ball(at, from) => {
                    let (at, from) = (*at, *from);
                    let (p, w) = (&start[at..at + 4], &v[from..from + 3]);
                    let turned = half_product(p, w);
                    let scale = 1.0 + 0.25 * step * step * w.iter().map(|w| w * w).sum::<f64>();
                    for i in 0..4 {
                        q[at + i] = (p[i] + step * turned[i]) / scale;
                    }
                }
            }
        }
    }
}

/// `½ p ∘ (0, ω)`: the rate of a quaternion from the angular velocity in the axes it leads from.
fn half_product(p: &[f64], w: &[f64]) -> [f64; 4] {
    [
        0.5 * (-p[1] * w[0] - p[2] * w[1] - p[3] * w[2]),
        0.5 * (p[0] * w[0] + p[2] * w[2] - p[3] * w[1]),
        0.5 * (p[0] * w[1] + p[3] * w[0] - p[1] * w[2]),
        0.5 * (p[0] * w[2] + p[1] * w[1] - p[2] * w[0]),
    ]
}
