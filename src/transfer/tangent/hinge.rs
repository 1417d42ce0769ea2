//! One hinge at the point of the tangent.

use super::At;
use super::blocks::{
    ACCELERATION, AT_REST_IN_PLACE, Column, MOVING, MOVING_IN_PLACE, RATE, TURN, TURN_ACCELERATION, VELOCITY, apply,
    cross_times, position, twice,
};
use crate::model::{Joint, Link};
use crate::motion::variation::LinkVariation;
use crate::spatial::Wrench;
use nalgebra::{Matrix3, Vector3};

/// One hinge at the point of the tangent: `T` and `h` of eq. (2).
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Hinge {
    pub(super) slides: bool,
    pub(super) turn: Matrix3<f64>,
    pub(super) axis: Vector3<f64>,
    pub(super) arm: Vector3<f64>,
    /// Angular velocity and acceleration of the parent.
    w: Vector3<f64>,
    dw: Vector3<f64>,
    /// Relative motion: turning and its rate, sliding and its rate.
    spin: Vector3<f64>,
    spin_rate: Vector3<f64>,
    slip: Vector3<f64>,
    slip_rate: Vector3<f64>,
    c1: f64,
    c2: f64,
}

impl Hinge {
    pub(super) fn new(link: &Link, at: &At<'_>, index: usize) -> Self {
        let own = &at.motion.links[index];
        let zero = Vector3::zeros();
        let first = link.velocity;
        let (spin, spin_rate, slip, slip_rate) = match link.joint {
            Joint::None => (zero, zero, zero, zero),
            Joint::Turn => (own.relative, own.axis * at.hinge[first], zero, zero),
            Joint::Slide { .. } => (zero, zero, own.relative, own.axis * at.hinge[first]),
            Joint::Ball { .. } => {
                let local = Vector3::new(at.hinge[first], at.hinge[first + 1], at.hinge[first + 2]);
                (own.relative, own.turn * local, zero, zero)
            }
        };
        Self {
            slides: matches!(link.joint, Joint::Slide { .. }),
            turn: own.turn,
            axis: own.axis,
            arm: own.arm,
            w: at.motion.links[link.parent].angular_velocity,
            dw: at.balance.accelerations[link.parent].angular,
            spin,
            spin_rate,
            slip,
            slip_rate,
            c1: at.c1,
            c2: at.c2,
        }
    }

    /// `S ← S T`.
    #[inline]
    pub(super) fn compose<const N: usize>(&self, S: &mut [Column; N]) {
        let d = &self.arm;
        if N == AT_REST_IN_PLACE || N == MOVING_IN_PLACE {
            let position = S[position::<N>()];
            S[TURN].minus_cross(&position, d);
        }
        if N >= MOVING {
            self.compose_moving(S);
        }
    }

    /// `S ← Xᵀ S`.
    #[inline]
    pub(super) fn shift<const N: usize>(&self, S: &mut [Column; N]) {
        S.iter_mut().for_each(|column| column.shift(&self.arm));
    }

    /// What velocities and accelerations add to `S T`.
    fn compose_moving<const N: usize>(&self, S: &mut [Column; N]) {
        let (d, w) = (&self.arm, &self.w);
        let (swing, slip) = (w.cross(d), self.slip.cross_matrix());
        let turning = twice(w, d);
        let swinging = turning + slip;
        let [rate, turn_acceleration, acceleration] = [S[RATE], S[TURN_ACCELERATION], S[ACCELERATION]];
        S[TURN].minus_cross(&rate, &self.spin);
        S[TURN].minus(&turn_acceleration, &(self.spin_rate.cross_matrix() + twice(w, &self.spin)));
        let by_turn = twice(&self.dw, d) + cross_times(w, &(swinging + slip)) + self.slip_rate.cross_matrix();
        S[TURN].minus(&acceleration, &by_turn);
        S[RATE].minus_cross(&turn_acceleration, &self.spin);
        S[RATE].minus(&acceleration, &((swing + 2.0 * self.slip).cross_matrix() + turning));
        S[TURN_ACCELERATION].minus_cross(&acceleration, d);
        if N == MOVING_IN_PLACE {
            let velocity = S[VELOCITY];
            S[TURN].minus(&velocity, &swinging);
            S[RATE].minus_cross(&velocity, d);
        }
    }

    /// `S h` for one coordinate.
    #[inline]
    pub(super) fn reach_one<const N: usize>(&self, S: &[Column; N]) -> Wrench {
        let mut h = LinkVariation::default();
        self.add_one(&mut h, 1.0);
        apply(S, &h)
    }

    /// `z += h δq` for one coordinate.
    #[inline]
    pub(super) fn add_one(&self, z: &mut LinkVariation, step: f64) {
        let (c1, c2) = (self.c1, self.c2);
        let n = self.axis * step;
        let wn = self.w.cross(&n);
        if self.slides {
            z.position += n;
            z.velocity += c1 * n + wn;
            z.acceleration += c2 * n + self.dw.cross(&n) + self.w.cross(&(wn + 2.0 * c1 * n));
        } else {
            z.turn += n;
            z.angular_velocity += c1 * n;
            z.angular_acceleration += c2 * n + c1 * wn;
        }
    }

    /// `z += h φ` for a ball turned by `φ`, inertial axes.
    pub(super) fn add_ball(&self, z: &mut LinkVariation, phi: &Vector3<f64>) {
        let spin = self.c1 * phi + phi.cross(&self.spin);
        z.turn += phi;
        z.angular_velocity += spin;
        z.angular_acceleration += self.c2 * phi + phi.cross(&self.spin_rate) + self.w.cross(&spin);
    }

    /// `T z_P`.
    #[inline]
    pub(super) fn carry<const N: usize>(&self, p: &LinkVariation) -> LinkVariation {
        let d = &self.arm;
        let arm = p.turn.cross(d);
        let mut z = LinkVariation { turn: p.turn, position: p.position + arm, ..LinkVariation::default() };
        if N >= MOVING {
            let (w, dw) = (self.w, p.angular_velocity);
            let (spin, slip) = (p.turn.cross(&self.spin), p.turn.cross(&self.slip));
            let swing = dw.cross(d) + w.cross(&arm);
            z.angular_velocity = dw + spin;
            z.velocity = p.velocity + swing + slip;
            z.angular_acceleration =
                p.angular_acceleration + p.turn.cross(&self.spin_rate) + dw.cross(&self.spin) + w.cross(&spin);
            z.acceleration = p.acceleration
                + p.angular_acceleration.cross(d)
                + self.dw.cross(&arm)
                + dw.cross(&(w.cross(d) + 2.0 * self.slip))
                + w.cross(&(swing + 2.0 * slip))
                + p.turn.cross(&self.slip_rate);
        }
        z
    }
}
