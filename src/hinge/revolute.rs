//! Turns about one axis.

use super::axes::{around, check_axis};
use super::joint::Joint;
use super::question::{Condition, Freedom, Keys, Names, Say};
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

    fn check(&self, owner: &str, say: Say<'_>) {
        check_axis(&self.axis, owner, say);
    }

    fn axes(&self) -> Vec<Vector3<f64>> {
        vec![self.axis]
    }

    fn elementary(&self, _: &[f64]) -> Vec<(Joint, UnitQuaternion<f64>)> {
        vec![Joint::turn(&self.axis)]
    }

    fn conditions(&self) -> Vec<Condition> {
        let perpendicular = Condition::perpendicular;
        let [t, u, n] = around(&self.axis);
        vec![Condition::Along(t), Condition::Along(u), Condition::Along(n), perpendicular(t, n), perpendicular(u, n)]
    }
}
