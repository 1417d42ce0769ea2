//! Turns about one axis.

use super::axes::around;
use super::joint::Joint;
use super::question::{Condition, Freedom, Keys, Names};
use nalgebra::{UnitQuaternion, Vector3};

/// Turns about one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Revolute {
    /// Axis, hinge frame.
    pub axis: Vector3<f64>,
}

impl Freedom for Revolute {
    const NAME: &'static str = "revolute";
    const DOC: &'static str = "Turns about `axis`. Coordinate: angle.";
    const CLOSES: Option<&'static str> = Some("Turns about `axis`.");
    const AXES: usize = 1;
    const POSITIONS: Names = &[("angle", "rad")];
    const VELOCITIES: Names = &[("rate", "rad/s")];

    fn read(keys: &dyn Keys) -> Self {
        Self { axis: keys.axis() }
    }

    fn axes(&self) -> Vec<Vector3<f64>> {
        vec![self.axis]
    }

    fn elementary(&self, _: &[f64]) -> Vec<(Joint, UnitQuaternion<f64>)> {
        vec![Joint::turn(&self.axis)]
    }

    fn conditions(&self) -> Vec<Condition> {
        let around = around(&self.axis);
        around.map(Condition::Along).into_iter().chain(Condition::upright(around)).collect()
    }
}
