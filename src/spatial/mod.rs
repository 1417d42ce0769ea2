//! Mechanics of one rigid body: poses, wrenches, symmetric tensors, rotation vectors. Knows nothing of systems.
//!
//! Vectors are resolved in inertial axes unless a name says otherwise; a rotation `world_from_body` turns body axes
//! into inertial ones.

pub mod fused;
pub mod lanes;
pub mod link;
pub mod principal;
pub mod quad;
pub mod rotation;
pub mod sym3;
pub mod twist;

pub use principal::Principal;
pub use sym3::Sym3;

use nalgebra::{Isometry3, Vector3};
use std::ops::{Add, AddAssign, Sub};

/// Position and orientation of a frame: `world_from_body`.
pub type Pose = Isometry3<f64>;

/// A force and a moment at a point that the context names, inertial axes (N, N m).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wrench {
    /// Force (N).
    pub force: Vector3<f64>,
    /// Moment (N m).
    pub moment: Vector3<f64>,
}

impl Wrench {
    /// No force, no moment.
    pub const ZERO: Self = Self { force: Vector3::new(0.0, 0.0, 0.0), moment: Vector3::new(0.0, 0.0, 0.0) };

    /// A force at a point, taken at another point from which it is `arm` away.
    #[inline]
    pub fn at_arm(force: Vector3<f64>, arm: Vector3<f64>) -> Self {
        Self { force, moment: fused::cross(&arm, &force) }
    }

    /// This wrench taken at a point that lies at `−arm` from its own: the moment gains `arm × force`.
    #[inline]
    pub fn shifted(&self, arm: Vector3<f64>) -> Self {
        Self { force: self.force, moment: fused::cross_add(&arm, &self.force, &self.moment) }
    }

    /// This wrench times `factor`.
    #[inline]
    pub fn times(&self, factor: f64) -> Self {
        Self { force: factor * self.force, moment: factor * self.moment }
    }

    /// Adds `factor` times another.
    #[inline(always)]
    pub fn add_times(&mut self, factor: f64, other: &Self) {
        self.force = fused::scale_add(factor, &other.force, &self.force);
        self.moment = fused::scale_add(factor, &other.moment, &self.moment);
    }

    /// Whether every number is finite.
    #[inline]
    pub fn is_finite(&self) -> bool {
        (self.force + self.moment).iter().all(|x| x.is_finite())
    }
}

impl Add for Wrench {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self { force: self.force + o.force, moment: self.moment + o.moment }
    }
}

impl Sub for Wrench {
    type Output = Self;
    #[inline]
    fn sub(self, o: Self) -> Self {
        Self { force: self.force - o.force, moment: self.moment - o.moment }
    }
}

impl AddAssign for Wrench {
    #[inline]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
