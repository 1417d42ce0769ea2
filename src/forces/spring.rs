//! A spring and damper along the line between two points.
//!
//! ```text
//! x = x_b − x_a,  L = |x|,  u = x / L
//! tension  T = k (L − L₀) + c L̇,   L̇ = u·(v_b − v_a)
//! force on a: +T u,  on b: −T u;   potential ½ k (L − L₀)²
//! ```
//!
//! A spring with L₀ = 0 is regular at L = 0 (force k x). With L₀ > 0 the direction is undefined there and the force is
//! not a number, which stops whoever asked.

use super::Magnitude;
use crate::model::End;
use crate::motion::Motion;
use crate::motion::point::Point;
use crate::motion::variation::LinkVariation;
use crate::spatial::Wrench;
use nalgebra::Vector3;

pub(super) struct Spring {
    points: [Point; 2],
    stiffness: f64,
    length: f64,
    damping: f64,
    /// x, L, u
    between: Vector3<f64>,
    distance: f64,
    direction: Vector3<f64>,
    /// v_b − v_a and L̇
    velocity: Vector3<f64>,
    rate: f64,
}

impl Spring {
    pub(super) fn at(ends: &[End; 2], motion: &Motion, stiffness: f64, length: f64, damping: f64) -> Self {
        let points = [Point::of(&ends[0], motion), Point::of(&ends[1], motion)];
        let between = points[1].position - points[0].position;
        let distance = between.norm();
        let touching = distance == 0.0 && length == 0.0;
        let direction = if touching { Vector3::zeros() } else { between / distance };
        let velocity = points[1].velocity - points[0].velocity;
        let rate = direction.dot(&velocity);
        Self { points, stiffness, length, damping, between, distance, direction, velocity, rate }
    }

    /// Force on the first end.
    fn force(&self) -> Vector3<f64> {
        let elastic = self.stiffness * (self.between - self.length * self.direction);
        elastic + self.damping * self.rate * self.direction
    }

    pub(super) fn wrenches(&self) -> [Wrench; 2] {
        let force = self.force();
        [Wrench::at_arm(force, self.points[0].arm), Wrench::at_arm(-force, self.points[1].arm)]
    }

    pub(super) fn vary(&self, ends: &[End; 2], motion: &Motion, by: &[LinkVariation]) -> [Wrench; 2] {
        let [a, b] = [0, 1].map(|i| self.points[i].vary(&motion.links[ends[i].link], &by[ends[i].link]));
        let (between, velocity) = (b.position - a.position, b.velocity - a.velocity);
        let turn = if self.distance == 0.0 {
            Vector3::zeros()
        } else {
            (between - self.direction.dot(&between) * self.direction) / self.distance
        };
        let rate = turn.dot(&self.velocity) + self.direction.dot(&velocity);
        let force =
            self.stiffness * (between - self.length * turn) + self.damping * (rate * self.direction + self.rate * turn);
        let total = self.force();
        let on = |arm: Vector3<f64>, varied: Vector3<f64>, sign: f64| Wrench {
            force: sign * force,
            moment: sign * (arm.cross(&force) + varied.cross(&total)),
        };
        [on(self.points[0].arm, a.arm, 1.0), on(self.points[1].arm, b.arm, -1.0)]
    }

    pub(super) fn magnitude(&self) -> Magnitude {
        Magnitude {
            force: self.force().norm(),
            noise: self.stiffness * (self.points[0].position.norm() + self.points[1].position.norm() + self.length),
            stiffness: self.stiffness,
            ..Magnitude::default()
        }
    }

    pub(super) fn potential(&self) -> f64 {
        0.5 * self.stiffness * (self.distance - self.length).powi(2)
    }

    pub(super) fn dissipated(&self) -> f64 {
        self.damping * self.rate * self.rate
    }
}
