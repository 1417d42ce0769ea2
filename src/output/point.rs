//! Position, velocity and acceleration of a point that a link carries.
//!
//! ```text
//! (1) x = p + r,   ẋ = v + ω × r,   ẍ = a + ω̇ × r + ω × (ω × r),   r = R s
//! (2) in body axes: y = Rᵀ x,  δy = Rᵀ (δx − δθ × x);   one component: n·y
//! ```

use super::question::{At, Measure, Variation};
use crate::force::end::Anchor;
use crate::model::output::{Order, PointQuantity};
use nalgebra::Vector3;

impl PointQuantity {
    /// (2) of a vector in inertial axes.
    fn components(&self, at: &At<'_>, vector: &Vector3<f64>, out: &mut [f64]) {
        let seen = match &self.turn {
            Some(turn) => (at.balanced.motion().links[self.end.link].turn * turn).tr_mul(vector),
            None => *vector,
        };
        match self.axis {
            Some(axis) => out[0] = axis.dot(&seen),
            None => out.copy_from_slice(seen.as_slice()),
        }
    }

    /// (1)
    fn vector(&self, at: &At<'_>) -> Vector3<f64> {
        let links = &at.balanced.motion().links;
        let anchor = Anchor::of(&self.end, links);
        match self.order {
            Order::Position => anchor.position,
            Order::Velocity => anchor.velocity,
            Order::Acceleration => {
                let (w, a) = (&links[self.end.link].angular_velocity, at.balanced.link_accelerations()[self.end.link]);
                a.linear + a.angular.cross(&anchor.arm) + w.cross(&w.cross(&anchor.arm))
            }
        }
    }
}

impl Measure for PointQuantity {
    fn value(&self, at: &At<'_>, out: &mut [f64]) {
        self.components(at, &self.vector(at), out);
    }

    fn vary(&self, at: &At<'_>, by: &Variation<'_>, out: &mut [f64]) -> bool {
        let links = &at.balanced.motion().links;
        let (link, varied) = (&links[self.end.link], &by.links[self.end.link]);
        let anchor = Anchor::of(&self.end, links);
        let change = anchor.vary(link, varied);
        let mut vector = match self.order {
            Order::Position => change.position,
            Order::Velocity => change.velocity,
            // On the ground nothing accelerates.
            Order::Acceleration if by.by.acceleration.is_empty() && self.end.link != 0 => return false,
            Order::Acceleration => {
                let (w, dw) = (&link.angular_velocity, &varied.angular_velocity);
                let angular = at.balanced.link_accelerations()[self.end.link].angular;
                let swing = dw.cross(&w.cross(&anchor.arm)) + w.cross(&(dw.cross(&anchor.arm) + w.cross(&change.arm)));
                varied.acceleration
                    + varied.angular_acceleration.cross(&anchor.arm)
                    + angular.cross(&change.arm)
                    + swing
            }
        };
        if self.turn.is_some() {
            vector -= varied.turn.cross(&self.vector(at));
        }
        self.components(at, &vector, out);
        true
    }
}
