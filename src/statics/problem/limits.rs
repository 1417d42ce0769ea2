//! Limits of hinges in a landscape of a tree: rigid ones bound the coordinates, compliant ones are part of the potential.
//!
//! ```text
//! minimize V(q) + Σ ½ k_s d²  within  low ≤ q ≤ high          d: depth beyond a compliant limit                   (1)
//! 0 ≤ λ ⊥ q − low ≥ 0,   0 ≤ λ ⊥ high − q ≥ 0                  λ: what a rigid stop bears                          (2)
//! ```
//!
//! A coordinate at a rigid limit into which its force presses is *active*: its stop holds it, an infinite pivot in the sweep,
//! and it is not among the free coordinates. The active set is chosen anew at every place (a projected Newton method,
//! Bertsekas 1982); steps end at the first limit of each coordinate. Where `λ` is within round-off the stop is *weakly active*:
//! the second-order conditions look to that side of it (see [`crate::statics::certify::cone`]).

use super::place::{BALANCED, Place};
use super::{Landscape, Scales};
use crate::dynamics::{Fault, Magnitudes};
use crate::model::{Model, Side, Stop};
use crate::round_off::ON_A_LIMIT;

/// A stop that holds its coordinate and bears nothing.
#[derive(Debug, Clone, Copy)]
pub(in crate::statics) struct Weak {
    /// Index of the velocity coordinate.
    pub velocity: usize,
    /// At which limit.
    pub side: Side,
    /// Size of the stiffness terms there (N/m, N m/rad).
    pub stiffness: f64,
}

/// The limits of a scene, and which of them are active.
#[derive(Debug, Clone)]
pub(in crate::statics) struct Limits {
    stops: Vec<Stop>,
    /// Velocity coordinates that no lock holds.
    unlocked: Vec<usize>,
    /// `B` of all velocity coordinates.
    inertia: Vec<f64>,
    weak: Vec<Weak>,
    /// Stiffness of the compliant stops that are pressed at the place last looked at, one number per free coordinate.
    pub(in crate::statics) pressed: Vec<f64>,
}

impl Limits {
    fn rigid(&self) -> impl Iterator<Item = &Stop> {
        self.stops.iter().filter(|stop| stop.is_rigid())
    }

    /// The stiffness and the signed depth of every compliant stop that is pressed.
    fn pressed<'a>(&'a self, q: &'a [f64]) -> impl Iterator<Item = (&'a Stop, f64, f64)> {
        self.stops.iter().filter_map(|stop| stop.pressed(q).map(|[stiffness, depth]| (stop, stiffness, depth)))
    }

    /// `B` of every coordinate that no lock holds.
    pub(in crate::statics) fn inertias(&self) -> impl Iterator<Item = (&usize, f64)> {
        self.unlocked.iter().map(|i| (i, self.inertia[*i]))
    }

    /// Energy of the compliant stops (J).
    pub(in crate::statics) fn potential(&self, q: &[f64]) -> f64 {
        self.pressed(q).map(|(_, stiffness, depth)| 0.5 * stiffness * depth * depth).sum()
    }

    /// What the compliant stops add to the residual of each velocity coordinate.
    pub(in crate::statics) fn add_residual(&self, q: &[f64], residual: &mut [f64]) {
        self.pressed(q).for_each(|(stop, stiffness, depth)| residual[stop.velocity] += stiffness * depth);
    }

    pub(in crate::statics) fn add_magnitudes(&self, q: &[f64], sizes: &mut Magnitudes) {
        for (stop, stiffness, depth) in self.pressed(q) {
            sizes.force[stop.velocity] += stiffness * depth.abs();
            sizes.noise[stop.velocity] += stiffness * (depth.abs() + q[stop.position].abs());
            sizes.stiffness[stop.velocity] += stiffness;
        }
    }

    pub(in crate::statics) fn look(&mut self, q: &[f64], free: &[usize]) {
        let mut all = vec![0.0; self.inertia.len()];
        self.pressed(q).for_each(|(stop, stiffness, _)| all[stop.velocity] += stiffness);
        self.pressed = free.iter().map(|i| all[*i]).collect();
    }

    /// Brings a position within the rigid limits. What is not a number stays that.
    pub(in crate::statics) fn project(&self, q: &mut [f64]) {
        for stop in self.rigid() {
            if let Some(side) = stop.passed(q[stop.position], 0.0) {
                q[stop.position] = stop.limit(side);
            }
        }
    }
}

/// A position within the rigid limits of a model: what is beyond a limit, or nearly at it, stands on it.
pub(in crate::statics) fn within_limits(model: &Model, q: &[f64]) -> Vec<f64> {
    let (mut within, slides) = (q.to_vec(), super::slides(model));
    for stop in model.stops.iter().filter(|stop| stop.is_rigid()) {
        let unit = if slides[stop.velocity] { model.length_scale() } else { 1.0 };
        let value = within[stop.position];
        let slack = ON_A_LIMIT.of(unit.max(value.abs()));
        if let Some(side) = stop.reached(value, slack) {
            within[stop.position] = stop.limit(side);
        }
    }
    within
}

impl Landscape<'_> {
    /// Bounds the coordinates by the limits of the scene. For trees.
    pub(in crate::statics) fn heed_limits(&mut self) {
        let mut inertia = vec![0.0; self.rest.len()];
        self.free.iter().zip(&self.metric).for_each(|(i, b)| inertia[*i] = *b);
        let (stops, unlocked) = (self.model().stops.clone(), self.free.clone());
        let (weak, pressed) = (Vec::new(), vec![0.0; unlocked.len()]);
        self.limits = Some(Box::new(Limits { stops, unlocked, inertia, weak, pressed }));
    }

    /// Whether limits bound the coordinates.
    pub(in crate::statics) fn heeds_limits(&self) -> bool {
        self.limits.is_some()
    }

    /// Chooses the active set at `q` and gives the place in the coordinates that stay free; `None` without limits.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub(in crate::statics) fn choose_active(&mut self, q: &[f64]) -> Result<Option<Place>, Fault> {
        let Some(limits) = &self.limits else { return Ok(None) };
        let unlocked = limits.unlocked.clone();
        self.residuals += 1;
        let (force, mut scales) = self.forces_of(&unlocked, q)?;
        self.heed_least(&unlocked, &mut scales);
        let Some(limits) = &mut self.limits else { return Ok(None) };
        let (mut held, mut weak) = (vec![false; self.rest.len()], Vec::new());
        for stop in limits.stops.iter().filter(|stop| stop.is_rigid()) {
            let Some(side) = stop.reached(q[stop.position], 0.0) else { continue };
            let Ok(row) = unlocked.binary_search(&stop.velocity) else { continue };
            let nothing = BALANCED * scales.force[row] + scales.noise[row];
            // Eq. (2): it never pulls.
            held[stop.velocity] = side.sign() * force[row] >= -nothing || stop.range[0] == stop.range[1];
            if force[row].abs() <= nothing && stop.range[0] < stop.range[1] {
                weak.push(Weak { velocity: stop.velocity, side, stiffness: scales.stiffness[row] });
            }
        }
        limits.weak = weak;
        let rows: Vec<usize> = (0..unlocked.len()).filter(|row| !held[unlocked[*row]]).collect();
        self.set_free(rows.iter().map(|row| unlocked[*row]).collect());
        let pick = |all: &[f64]| rows.iter().map(|row| all[*row]).collect::<Vec<f64>>();
        let scales =
            Scales { force: pick(&scales.force), noise: pick(&scales.noise), stiffness: pick(&scales.stiffness) };
        Ok(Some(Place { q: q.to_vec(), force: pick(&force), scales }))
    }

    /// Stops at `q` that bear nothing; as of the last choice.
    pub(in crate::statics) fn weakly_active(&self) -> Vec<Weak> {
        self.limits.as_ref().map_or_else(Vec::new, |limits| limits.weak.clone())
    }

    /// Holds these coordinates too.
    pub(in crate::statics) fn hold(&mut self, velocities: &[usize]) {
        self.set_free(self.free.iter().copied().filter(|i| !velocities.contains(i)).collect());
    }

    /// Lets these coordinates move again.
    pub(in crate::statics) fn let_go(&mut self, velocities: &[usize]) {
        let Some(limits) = &self.limits else { return };
        let free = |i: &usize| self.free.binary_search(i).is_ok() || velocities.contains(i);
        self.set_free(limits.unlocked.iter().copied().filter(free).collect());
    }

    fn set_free(&mut self, free: Vec<usize>) {
        let Some(limits) = &mut self.limits else { return };
        limits.pressed = vec![0.0; free.len()];
        if free != self.free {
            self.metric = free.iter().map(|i| limits.inertia[*i]).collect();
            self.stiffness.hold_all_but(&free);
            self.free = free;
        }
    }

    /// Free coordinates at a limit that a step from `q` would pass.
    pub(in crate::statics) fn blocked(&self, q: &[f64], x: &[f64]) -> Vec<usize> {
        let Some(limits) = &self.limits else { return Vec::new() };
        let passes = |stop: &&Stop| {
            let Some(side) = stop.reached(q[stop.position], 0.0) else { return false };
            self.free.binary_search(&stop.velocity).is_ok_and(|row| side.sign() * x[row] > 0.0)
        };
        limits.rigid().filter(passes).map(|stop| stop.velocity).collect()
    }

    /// The step that is left of `x` when each coordinate ends at its limits; `None` when none is reached.
    pub(in crate::statics) fn cut(&self, q: &[f64], x: &[f64]) -> Option<Vec<f64>> {
        let limits = self.limits.as_ref()?;
        let mut cut: Option<Vec<f64>> = None;
        for stop in limits.rigid() {
            let Ok(row) = self.free.binary_search(&stop.velocity) else { continue };
            let value = q[stop.position];
            if let Some(side) = stop.passed(value + x[row], 0.0) {
                cut.get_or_insert_with(|| x.to_vec())[row] = stop.limit(side) - value;
            }
        }
        cut
    }
}
