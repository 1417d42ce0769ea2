//! What the stages of the search share: the state of the search, its stop test, its record.

use super::landscape::{Landscape, Scales};
use crate::dynamics::Fault;

/// A residual within this part of the forces that cancel in it is balanced well enough to report success.
pub(super) const BALANCED: f64 = 1e-10;
/// A residual within this part of them needs no further step: a start like that is returned bit for bit.
const EXACT: f64 = 1e-13;

/// Shift of a singular stiffness, relative to its largest curvature.
pub(super) const SHIFT: f64 = 1e-8;

/// One iteration of the search, for reports and plots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iteration {
    /// Which stage made it.
    pub stage: &'static str,
    /// Largest unbalanced force, relative to the forces that cancel there.
    pub residual: f64,
    /// Size of the step in the inertia metric (m √kg).
    pub step: f64,
    /// Shift `σ` of the trust region, 0 for a Newton step.
    pub shift: f64,
}

/// A position and its unbalanced forces.
#[derive(Debug, Clone)]
pub(super) struct Place {
    pub q: Vec<f64>,
    pub force: Vec<f64>,
    pub scales: Scales,
}

impl Place {
    pub(super) fn at(landscape: &mut Landscape<'_>, q: Vec<f64>) -> Result<Self, Fault> {
        let (force, scales) = landscape.forces_and_scales(&q)?;
        if let Some(trail) = &mut landscape.trail {
            trail.push(q.clone());
        }
        Ok(Self { q, force, scales })
    }

    /// Largest unbalanced force relative to what cancels there, and where.
    pub(super) fn residual(&self) -> (f64, Option<usize>) {
        self.worst(|i| self.share(i, self.scales.force[i]))
    }

    /// Largest unbalanced force relative to what cancels there or to `sizes`, whichever is larger.
    pub(super) fn residual_beside(&self, sizes: &[f64]) -> f64 {
        self.worst(|i| self.share(i, self.scales.force[i].max(sizes[i]))).0
    }

    fn share(&self, i: usize, size: f64) -> f64 {
        if size > 0.0 { self.force[i].abs() / size } else { f64::from(u8::from(self.force[i] != 0.0)) }
    }

    /// What round-off may leave, relative to what cancels.
    pub(super) fn round_off(&self) -> f64 {
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
    pub(super) fn is_balanced(&self) -> bool {
        self.excess() <= BALANCED
    }

    /// What is left is the round-off of the balance itself.
    pub(super) fn is_round_off(&self) -> bool {
        self.excess() == 0.0
    }

    /// Balanced to the last digits: nothing is gained by another step.
    pub(super) fn is_exact(&self) -> bool {
        self.excess() <= EXACT
    }
}

/// Newton steps while they still halve the residual: from balanced to the last digits. The best place is kept. What is
/// above [`BALANCED`] is not taken for round-off before no step halves it.
pub(super) fn polish(
    landscape: &mut Landscape<'_>,
    mut place: Place,
    history: &mut Vec<Iteration>,
) -> Result<Place, Fault> {
    // Motions that cost nothing make the stiffness singular: a shift far below the stiffness of all others keeps the
    // step finite, and delays what is left by as little as it is smaller.
    let mut part = 0.0;
    for _ in 0..10 {
        // Loops may hide a small force behind the large ones that they hold: it is taken down to their round-off.
        let done = if landscape.ties.is_some() { place.is_round_off() } else { place.is_exact() };
        if done && place.residual().0 <= BALANCED {
            break;
        }
        landscape.look(&place.q)?;
        let shift = landscape.shift(&place, part);
        let better = match landscape.newton_shifted(&place.force, &shift) {
            Some(step) => improved(landscape, &place, &step)?.map(|next| (next, step)),
            None => None,
        };
        match better {
            Some((next, step)) => {
                place = next;
                let (residual, step) = (place.residual().0, landscape.size(&step));
                history.push(Iteration { stage: "polish", residual, step, shift: 0.0 });
            }
            None if part == 0.0 => part = SHIFT,
            None => break,
        }
    }
    Ok(place)
}

/// The place after a step, where that at least halves the residual. What balances up to round-off is not left for less in
/// one coordinate and more than round-off in another.
fn improved(landscape: &mut Landscape<'_>, place: &Place, step: &[f64]) -> Result<Option<Place>, Fault> {
    let q = landscape.moved(&place.q, step);
    let kept = |next: &Place| next.is_balanced() || !place.is_balanced();
    Ok(Place::at(landscape, q).ok().filter(|next| next.residual().0 <= 0.5 * place.residual().0 && kept(next)))
}
