//! What multipliers do to the two links of a constraint.

use crate::spatial::Wrench;
use nalgebra::Vector3;

/// Displacement (or force) and turn (or moment) of a link.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Part {
    Place,
    Turn,
}

/// What a multiplier of size one does: `force` and `on_link` to the link, `−force` and `on_parent` to the parent. The
/// same numbers are the gradient with respect to displacements and small turns.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gradient {
    pub(super) force: Vector3<f64>,
    pub(super) on_link: Vector3<f64>,
    pub(super) on_parent: Vector3<f64>,
}

impl Gradient {
    pub(super) fn times(&self, factor: f64) -> Self {
        Self { force: factor * self.force, on_link: factor * self.on_link, on_parent: factor * self.on_parent }
    }

    pub(super) fn on_link(&self, size: f64) -> Wrench {
        Wrench { force: size * self.force, moment: size * self.on_link }
    }

    pub(super) fn on_parent(&self, size: f64) -> Wrench {
        Wrench { force: -size * self.force, moment: size * self.on_parent }
    }

    /// The blocks that are not zero by kind: link, part, row vector.
    pub(super) fn blocks(&self, link: usize, parent: usize) -> [(usize, Part, Vector3<f64>); 4] {
        [
            (link, Part::Place, self.force),
            (link, Part::Turn, self.on_link),
            (parent, Part::Place, -self.force),
            (parent, Part::Turn, self.on_parent),
        ]
    }
}
