//! The elements of the compiled tree.

use crate::hinge::Joint;
use crate::spatial::{Principal, Sym3};
use nalgebra::{Matrix3, Vector3};

/// An elementary hinge and the rigid body outboard of it. What every evaluation reads comes first: large trees wait for
/// memory.
#[derive(Debug, Clone)]
#[repr(C)]
pub struct Link {
    /// Index of the parent link; the ground's own is 0.
    pub parent: usize,
    /// First index into the position vector.
    pub position: usize,
    /// First index into the velocity vector.
    pub velocity: usize,
    /// Which motion is free.
    pub joint: Joint,
    /// From the parent's root marker to the hinge point, parent link's axes (m).
    pub offset: Vector3<f64>,
    /// Mass of everything welded to this link (kg).
    pub mass: f64,
    /// Centre of mass from the root marker, link axes (m).
    pub center: Vector3<f64>,
    /// The inertia in principal axes.
    pub principal: Principal,
    /// Whether the link's axes are its parent's while its coordinates are zero.
    pub straight: bool,
    /// Orientation of the link on the parent link while its coordinates are zero: `parent_from_link`.
    pub turn: Matrix3<f64>,
    /// Inertia about the **root marker**, link axes (kg m²).
    pub inertia: Sym3,
    /// One past the last link of the subtree that starts here.
    pub subtree_end: usize,
    /// The named body whose hinge this is part of.
    pub body: usize,
}

impl Link {
    /// The ground: link 0.
    pub(crate) fn ground() -> Self {
        Self {
            parent: 0,
            subtree_end: 1,
            joint: Joint::None,
            offset: Vector3::zeros(),
            turn: Matrix3::identity(),
            straight: true,
            position: 0,
            velocity: 0,
            body: usize::MAX,
            mass: 0.0,
            center: Vector3::zeros(),
            inertia: Sym3::ZERO,
            principal: Principal::default(),
        }
    }

    /// What the link by itself resists a turn, or a screw motion, about its z axis with (kg m²).
    pub fn axial_inertia(&self) -> f64 {
        self.inertia.zz + self.joint.pitch().powi(2) * self.mass
    }

    /// Whether the link has neither mass nor inertia: an inner link of a hinge with several coordinates.
    #[inline]
    pub fn is_massless(&self) -> bool {
        self.mass == 0.0 && self.inertia == Sym3::ZERO
    }
}
