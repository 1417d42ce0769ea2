//! What is round-off in a report, by the sizes of its scene, as in the tables on the terminal.

use super::super::text::{size, without_noise};
use super::material::Material;
use crate::record::scene::{Channel, Extent};
use serde_json::Value;

/// Sizes of the numbers of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sizes {
    /// A typical length (m); zero in recordings that do not say it.
    length: f64,
    /// The weight, or its moment (N, N m); zero likewise.
    weight: f64,
}

impl Sizes {
    pub(super) fn of(material: &Material) -> Self {
        let known = |extent: Extent| Self { length: extent.length, weight: extent.weight };
        material.scene.extent.map_or(Self { length: 0.0, weight: 0.0 }, known)
    }

    /// A number of a unit, zero if it is round-off.
    pub(super) fn clean(self, x: f64, unit: &str) -> f64 {
        without_noise(x, size(unit, self.length, self.weight))
    }

    /// A coordinate or speed that may be one of a turn or of a slide, zero if it is round-off of both.
    pub(super) fn clean_coordinate(self, x: f64) -> f64 {
        without_noise(x, self.length.min(1.0))
    }

    /// The sizes of forces and moments, the largest of which are these (N, N m).
    pub(super) fn of_wrenches(self, [force, moment]: [f64; 2]) -> [f64; 2] {
        let force = force.max(self.weight);
        [force, moment.max(self.length * force)]
    }

    /// The size of energies, the largest of which is this (J).
    pub(super) fn of_energies(self, largest: f64) -> f64 {
        largest.max(self.weight)
    }
}

/// The unit of each number of an output; none if the recording does not say it.
pub(super) fn units<'m>(material: &'m Material, output: &str) -> Vec<&'m str> {
    let is_of = |channel: &&Channel| {
        let rest = channel.name.strip_prefix(output).filter(|_| channel.body.is_empty());
        rest.is_some_and(|rest| rest.is_empty() || rest.starts_with('['))
    };
    material.scene.outputs.iter().filter(is_of).map(|channel| channel.unit.as_str()).collect()
}

/// The numbers of a value that is one or a list of several.
pub(super) fn numbers_of(value: &Value) -> Vec<f64> {
    match value.as_array() {
        Some(list) => list.iter().filter_map(Value::as_f64).collect(),
        None => value.as_f64().into_iter().collect(),
    }
}
