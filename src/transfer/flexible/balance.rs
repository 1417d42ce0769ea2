//! Inverse dynamics of an element: eqs. (1) and (2) with given accelerations.

use super::{follow, velocity_terms};
use crate::element::{Rod, RodMotion, row};
use crate::spatial::Wrench;
use crate::transfer::LinkAcceleration;
use nalgebra::Vector3;

/// What an element's stations do and pass on for given accelerations.
#[derive(Debug, Clone)]
pub struct RodBalance {
    /// Accelerations of the stations.
    pub accelerations: Vec<LinkAcceleration>,
    /// What each station gets from the one before it, at itself (N, N m); that of station 0 is what the root frame passes.
    pub forces: Vec<Wrench>,
    /// The second rates of the coordinates.
    pub second: Vec<f64>,
}

impl RodBalance {
    /// Room for an element.
    pub fn new(rod: &Rod) -> Self {
        let stations = rod.steps() + 1;
        Self {
            accelerations: vec![LinkAcceleration::default(); stations],
            forces: vec![Wrench::ZERO; stations],
            second: vec![0.0; rod.count()],
        }
    }

    /// Tip → root with the wrench on the link of the tip: `put` gets `Zᵀ f` of every coordinate. Returns what the parent link
    /// gets at its root marker.
    pub(in crate::transfer) fn inward(
        &mut self,
        (rod, at): (&Rod, &RodMotion),
        gravity: &Vector3<f64>,
        parent: &LinkAcceleration,
        second: &[f64],
        tip: &Wrench,
        rows: &mut [f64],
    ) -> Wrench {
        self.second.copy_from_slice(second);
        follow(at, parent, second, true, &mut self.accelerations);
        self.pass(at, tip, rows, |k, a| {
            let (slice, link) = (&rod.slices[k], &at.stations[k].link);
            let mut own = velocity_terms(rod, at, k, gravity);
            own.force += slice.mass * a.linear;
            own.moment += link.inertia * a.angular;
            own
        })
    }

    /// The inward sweep for a change of the accelerations alone: no weight, no velocity terms.
    pub(in crate::transfer) fn inward_change(
        &mut self,
        (rod, at): (&Rod, &RodMotion),
        parent: &LinkAcceleration,
        second: &[f64],
        tip: &Wrench,
        rows: &mut [f64],
    ) -> Wrench {
        follow(at, parent, second, false, &mut self.accelerations);
        self.pass(at, tip, rows, |k, a| {
            let (slice, link) = (&rod.slices[k], &at.stations[k].link);
            Wrench { force: slice.mass * a.linear, moment: link.inertia * a.angular }
        })
    }

    fn pass(
        &mut self,
        at: &RodMotion,
        tip: &Wrench,
        rows: &mut [f64],
        own: impl Fn(usize, &LinkAcceleration) -> Wrench,
    ) -> Wrench {
        rows.fill(0.0);
        let (last, mut f) = (at.stations.len() - 1, *tip);
        for k in (1..=last).rev() {
            if k < last {
                f += own(k, &self.accelerations[k]);
            }
            self.forces[k] = f;
            rows.iter_mut().zip(at.subspace(k)).for_each(|(out, z)| *out += row(z, &f));
            f = f.shifted(at.stations[k].link.arm);
        }
        self.forces[0] = f;
        f.shifted(at.stations[0].link.arm)
    }
}
