//! What a hinge passes to its body at the body's root marker: force, then moment.

use super::question::{At, Measure};
use crate::model::output::{Axes, ReactionQuantity};

impl Measure for ReactionQuantity {
    fn value(&self, at: &At<'_>, out: &mut [f64]) {
        let reaction = &at.given.reactions[self.body];
        let seen = match self.axes {
            Axes::Inertial => [reaction.force, reaction.moment],
            Axes::Body => {
                let body = &at.balanced.system().model().bodies[self.body];
                let turn = at.balanced.motion().body_pose(body).rotation.inverse();
                [turn * reaction.force, turn * reaction.moment]
            }
        };
        let mut all = seen.iter().flatten();
        match self.component {
            Some(index) => out[0] = all.nth(index).copied().unwrap_or(f64::NAN),
            None => out.iter_mut().zip(all).for_each(|(out, x)| *out = *x),
        }
    }
}
