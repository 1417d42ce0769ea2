//! Turns about a first axis, then about a second one carried by the first.

use super::axes::{Say, has_no_direction};
use super::joint::Joint;
use super::question::{Condition, Freedom, Keys, Names};
use nalgebra::{UnitQuaternion, Vector3};

/// Sine of the angle between two axes below which they count as parallel.
const PARALLEL: f64 = 1e-6;

/// Turns about a first axis, then about a second one carried by the first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Universal {
    /// Axes, hinge frame (both angles zero).
    pub axes: [Vector3<f64>; 2],
}

impl Freedom for Universal {
    const NAME: &'static str = "universal";
    const DOC: &'static str =
        "Turns about the first of `axes`, then about the second, carried by the first. Coordinates: both angles.";
    const CLOSES: Option<&'static str> = 
        Some("Turns about the first of `axes` (on the first body) and about the second (on the second body).");
    const AXES: usize = 2;
    const POSITIONS: Names = &[("first_angle", "rad"), ("second_angle", "rad")];
    const VELOCITIES: Names = &[("first_rate", "rad/s"), ("second_rate", "rad/s")];
    const ORDER: Option<[&'static str; 2]> = Some(["about the first axis, about the second"; 2]);

    fn read(keys: &dyn Keys) -> Self {
        Self { axes: keys.axes() }
    }

    fn check(&self, owner: &str, say: Say<'_>) {
        let [first, second] = &self.axes;
        if has_no_direction(first) || has_no_direction(second) {
            let message = format!("an axis of the universal {owner} is zero or not finite");
            say("axes", message, "allowed: two finite vectors that are not zero");
        } else if first.normalize().cross(&second.normalize()).norm() < PARALLEL {
            let message = format!("the two axes of the universal {owner} are parallel");
            say("axes", message, "they must span a plane; usually they are perpendicular");
        }
    }

    fn axes(&self) -> Vec<Vector3<f64>> {
        self.axes.to_vec()
    }

    fn elementary(&self, _: &[f64]) -> Vec<(Joint, UnitQuaternion<f64>)> {
        self.axes.iter().map(Joint::turn).collect()
    }

    fn conditions(&self) -> Vec<Condition> {
        let [first, second] = self.axes.map(|axis| axis.normalize());
        let apart = Condition::Aligned { first, second, cosine: first.dot(&second) };
        Condition::together().into_iter().chain([apart]).collect()
    }

    fn shared(&self) -> Vec<Vector3<f64>> {
        Vec::new()
    }
}
