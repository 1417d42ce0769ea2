//! A position of the search: its unbalanced forces, and whether they prove a balance.

use super::{Landscape, Scales};
use crate::dynamics::Fault;

/// A residual within this part of the forces that cancel in it is balanced well enough to report success.
pub(in crate::statics) const BALANCED: f64 = 1e-10;

/// A residual within this part of them needs no further step: a start like that is returned bit for bit.
const EXACT: f64 = 1e-13;

/// What is missing this part of the largest share is as much out of balance as that.
const NEARLY: f64 = 0.1;

/// Shift of a singular stiffness, relative to its largest curvature.
pub(in crate::statics) const SHIFT: f64 = 1e-8;

/// A position and its unbalanced forces.
#[derive(Debug, Clone)]
pub(in crate::statics) struct Place {
    pub q: Vec<f64>,
    pub force: Vec<f64>,
    pub scales: Scales,
}

impl Place {
    pub(in crate::statics) fn at(landscape: &mut Landscape<'_>, q: Vec<f64>) -> Result<Self, Fault> {
        let (force, scales) = landscape.forces_and_scales(&q)?;
        if let Some(trail) = &mut landscape.trail {
            trail.push(q.clone());
        }
        Ok(Self { q, force, scales })
    }

    /// Largest unbalanced force relative to what cancels there, and where.
    pub(in crate::statics) fn residual(&self) -> (f64, Option<usize>) {
        self.worst(|i| self.share(i, self.scales.force[i]))
    }

    /// Largest unbalanced force relative to what cancels there or to `sizes`, whichever is larger.
    pub(in crate::statics) fn residual_beside(&self, sizes: &[f64]) -> f64 {
        self.worst(|i| self.share(i, self.scales.force[i].max(sizes[i]))).0
    }

    /// The largest force that is not balanced, in units of forces by `unit`: among those that are missing nearly as large a part of what
    /// cancels there as any. Where next to nothing acts, round-off of what acts elsewhere is all of it.
    pub(in crate::statics) fn most_unbalanced(&self, unit: impl Fn(usize) -> f64) -> Option<usize> {
        let (worst, at) = self.residual();
        let is_bad = |i: &usize| self.share(*i, self.scales.force[*i]) >= NEARLY * worst;
        let bad = (0..self.force.len()).filter(is_bad);
        bad.max_by(|i, j| (self.force[*i].abs() / unit(*i)).total_cmp(&(self.force[*j].abs() / unit(*j)))).or(at)
    }

    fn share(&self, i: usize, size: f64) -> f64 {
        // What is within the round-off counts as balanced, however small the forces are.
        let noise = self.scales.noise[i];
        let size = if noise.is_finite() { size.max(noise / BALANCED) } else { size };
        if size > 0.0 { self.force[i].abs() / size } else { f64::from(u8::from(self.force[i] != 0.0)) }
    }

    /// What round-off may leave, relative to what cancels.
    pub(in crate::statics) fn round_off(&self) -> f64 {
        self.worst(|i| if self.scales.force[i] > 0.0 { self.scales.noise[i] / self.scales.force[i] } else { 0.0 }).0
    }

    /// The residual with round-off taken off: zero where the residual is within it.
    fn excess(&self) -> f64 {
        self.worst(|i| {
            let above = self.force[i].abs() - self.scales.noise[i];
            match above > 0.0 || !self.scales.noise[i].is_finite() {
                true => above.abs() / self.scales.force[i].max(f64::MIN_POSITIVE),
                false => 0.0,
            }
        })
        .0
    }

    fn worst(&self, of: impl Fn(usize) -> f64) -> (f64, Option<usize>) {
        let mut worst = (0.0, None);
        for i in 0..self.force.len() {
            let value = of(i);
            if value > worst.0 || value.is_nan() {
                worst = (value, Some(i));
            }
        }
        worst
    }

    /// Balanced to what can be asked for.
    pub(in crate::statics) fn is_balanced(&self) -> bool {
        self.excess() <= BALANCED
    }

    /// Balanced to a part of the forces that cancel, or to what can be asked for.
    pub(in crate::statics) fn is_balanced_to(&self, part: f64) -> bool {
        self.excess() <= part.max(BALANCED)
    }

    /// The residual is the round-off of the balance itself.
    pub(in crate::statics) fn is_round_off(&self) -> bool {
        self.excess() == 0.0
    }

    /// Balanced to the last digits: nothing is gained by another step.
    pub(in crate::statics) fn is_exact(&self) -> bool {
        self.excess() <= EXACT
    }
}
