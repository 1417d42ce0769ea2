//! Orientation of a body as a unit quaternion w, x, y, z: `δp = ½ (0, δθ) p`, with δθ in inertial axes.
//!
//! Of the two that stand for a turn it is the one with `w ≥ 0`, so that it is near (1, 0, 0, 0) for small turns, whatever the axes of
//! hinges. It changes its sign where a turn passes through half of a whole one.

use super::question::{At, Measure, Variation};
use crate::model::output::OrientationQuantity;
use nalgebra::Quaternion;

impl OrientationQuantity {
    fn quaternion(&self, at: &At<'_>) -> Quaternion<f64> {
        let body = &at.balanced.system().model().bodies[self.body];
        let turn = at.balanced.motion().body_pose(body).rotation.into_inner();
        let first = [turn.w, turn.i, turn.j, turn.k].into_iter().find(|part| *part != 0.0);
        if first.is_some_and(|part| part < 0.0) { -turn } else { turn }
    }
}

impl Measure for OrientationQuantity {
    fn value(&self, at: &At<'_>, out: &mut [f64]) {
        let p = self.quaternion(at);
        out.copy_from_slice(&[p.w, p.i, p.j, p.k]);
    }

    fn vary(&self, at: &At<'_>, by: &Variation<'_>, out: &mut [f64]) -> bool {
        let turn = by.links[at.balanced.system().model().bodies[self.body].link].turn;
        let change = Quaternion::from_imag(0.5 * turn) * self.quaternion(at);
        out.copy_from_slice(&[change.w, change.i, change.j, change.k]);
        true
    }
}
