//! What is round-off in reports and plots, by the sizes of their scene, as in the tables on the terminal.

use super::text::{size, without_noise};
use crate::record::{OwnedSample, Scene};

/// Sizes of the numbers of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sizes {
    /// A typical length (m); zero in recordings that do not say it.
    length: f64,
    /// The weight or the largest load, or its moment (N, N m); zero likewise.
    force: f64,
}

impl Sizes {
    pub(super) fn of(scene: &Scene) -> Self {
        Self { length: scene.extent.map_or(0.0, |extent| extent.length), force: scene.force_size() }
    }

    /// The size of numbers of a unit; zero if nothing is known of them. Of speeds and accelerations it is what would go through the scene in
    /// a second.
    pub(super) fn of_unit(self, unit: &str) -> f64 {
        match unit {
            "m/s" | "m/s²" => self.length,
            "rad/s" | "rad/s²" => 1.0,
            _ => size(unit, self.length, self.force),
        }
    }

    /// A number of a unit, zero if it is round-off.
    pub(super) fn clean(self, x: f64, unit: &str) -> f64 {
        without_noise(x, size(unit, self.length, self.force))
    }

    /// A coordinate or speed that may be one of a turn or of a slide, zero if it is round-off of both.
    pub(super) fn clean_coordinate(self, x: f64) -> f64 {
        without_noise(x, self.length.min(1.0))
    }

    /// The sizes of forces and moments, the largest of which are these (N, N m).
    pub(super) fn of_wrenches(self, [force, moment]: [f64; 2]) -> [f64; 2] {
        let force = force.max(self.force);
        [force, moment.max(self.length * force)]
    }

    /// The size of energies, the largest of which is this (J).
    pub(super) fn of_energies(self, largest: f64) -> f64 {
        largest.max(self.force)
    }
}

/// Whether a run stays where it is: then what it has of speeds and accelerations is round-off, however fast it swings by that of stiff springs.
pub(super) struct Still {
    sizes: Sizes,
    first: Option<Vec<f64>>,
    samples: usize,
    moves: bool,
}

impl Still {
    pub(super) fn new(sizes: Sizes) -> Self {
        Self { sizes, first: None, samples: 0, moves: false }
    }

    pub(super) fn see(&mut self, sample: &OwnedSample) {
        self.samples += 1;
        let first = self.first.get_or_insert_with(|| sample.positions.clone());
        let moved = |(a, b): (&f64, &f64)| self.sizes.clean_coordinate(a - b) != 0.0;
        self.moves |= first.iter().zip(&sample.positions).any(moved);
    }

    /// Of as few as two samples nothing is known: they may be one at a turn of a swing.
    pub(super) fn lasts(&self) -> bool {
        self.samples > 2 && !self.moves
    }
}
