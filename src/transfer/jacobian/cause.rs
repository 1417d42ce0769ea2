//! What a column sets off in the subtree of its hinge: eq. (J1).

use crate::model::{Link, Model};
use crate::motion::variation::LinkAcceleration;
use crate::motion::{LinkMotion, Motion};
use crate::spatial::Wrench;
use crate::transfer::balance::Balance;
use nalgebra::Vector3;

/// One column at its own hinge.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Cause {
    /// `α`.
    pub alpha: LinkAcceleration,
    /// `w`, the angular part of `β`.
    pub rate: Vector3<f64>,
    /// `e`: first what turns or moves the forces that are there.
    pub passed: Wrench,
    /// `D⁻¹ u` of the coordinates of the same link, from hinge springs and dampers.
    pub own: [f64; 3],
}

impl Cause {
    /// Adds `factor` times another one of the same hinge.
    pub(super) fn add_times(&mut self, factor: f64, other: &Self) {
        self.alpha.linear += factor * other.alpha.linear;
        self.alpha.angular += factor * other.alpha.angular;
        self.rate += factor * other.rate;
        self.passed.add_times(factor, &other.passed);
    }

    /// From the link's root marker to that of the parent, at `−arm` from it.
    pub(super) fn move_to_parent(&mut self, arm: &Vector3<f64>) {
        self.passed = self.passed.shifted(*arm);
        self.alpha.linear -= self.alpha.angular.cross(arm);
    }
}

/// By position and by velocity, for a turn about the axis `n` through the root marker; `at` has its velocity relative to
/// the reference. At the marker the fields of the parent are `V_P = [v; ω_P]` and `A_P = [r̈ − g − ω_P × v; ω̇_P]`, with
/// `r̈` and `v` of the marker itself, so that by the Jacobi identity
///
/// ```text
/// ∂q_j    w = ω_P × n,   α = [(r̈ − g) × n + 2 v × w;  ω̇_P × n + ω_P × w]
/// ∂q̇_j    w = n,         α = [2 v × n;  (ω_P + ω) × n]
/// ```
pub(super) fn of_turn(
    axis: &Vector3<f64>,
    model: &Model,
    motion: &Motion,
    balance: &Balance,
    at: &LinkMotion,
    index: usize,
) -> [Cause; 2] {
    let parent = model.links[index].parent;
    let (w, dw) = (&motion.links[parent].angular_velocity, &balance.accelerations[parent].angular);
    let (acceleration, f) = (balance.accelerations[index].linear - model.gravity, &balance.reactions[index]);
    let rate = w.cross(axis);
    let by_position = Cause {
        alpha: LinkAcceleration {
            linear: acceleration.cross(axis) + 2.0 * at.velocity.cross(&rate),
            angular: dw.cross(axis) + w.cross(&rate),
        },
        rate,
        passed: Wrench { force: axis.cross(&f.force), moment: axis.cross(&f.moment) },
        own: [0.0; 3],
    };
    let by_velocity = Cause {
        alpha: LinkAcceleration {
            linear: 2.0 * at.velocity.cross(axis),
            angular: (w + at.angular_velocity).cross(axis),
        },
        rate: *axis,
        ..Cause::default()
    };
    [by_position, by_velocity]
}

/// By position and by velocity, for a slide along `n`, which turns nothing: `w = 0`, and `α` has no angular part. (A screw
/// is a turn and `p` times a slide: what its slip adds to `r̈` and to `2 v × w` cancels.)
///
/// ```text
/// ∂q_j    α = ω̇_P × n + ω_P × (ω_P × n)
/// ∂q̇_j    α = 2 ω_P × n
/// ```
pub(super) fn of_slide(
    axis: &Vector3<f64>,
    motion: &Motion,
    balance: &Balance,
    link: &Link,
    index: usize,
) -> [Cause; 2] {
    let (w, dw) = (&motion.links[link.parent].angular_velocity, &balance.accelerations[link.parent].angular);
    let swing = w.cross(axis);
    let only = |linear: Vector3<f64>| Cause {
        alpha: LinkAcceleration { linear, angular: Vector3::zeros() },
        ..Cause::default()
    };
    let passed = Wrench { force: Vector3::zeros(), moment: axis.cross(&balance.reactions[index].force) };
    [Cause { passed, ..only(dw.cross(axis) + w.cross(&swing)) }, only(2.0 * swing)]
}
