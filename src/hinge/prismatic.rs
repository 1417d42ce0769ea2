//! Slides along one axis.

use super::axes::{around, frame};
use super::joint::Joint;
use super::question::{Condition, Freedom, Keys, Names};
use nalgebra::{UnitQuaternion, Vector3};

/// Slides along one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Prismatic {
    /// Axis, hinge frame.
    pub axis: Vector3<f64>,
}

impl Freedom for Prismatic {
    const NAME: &'static str = "prismatic";
    const DOC: &'static str = "Slides along `axis`. Coordinate: distance.";
    const CLOSES: Option<&'static str> = Some("Slides along `axis`.");
    const AXES: usize = 1;
    const POSITIONS: Names = &[("distance", "m")];
    const VELOCITIES: Names = &[("speed", "m/s")];

    fn read(keys: &dyn Keys) -> Self {
        Self { axis: keys.axis() }
    }

    fn axes(&self) -> Vec<Vector3<f64>> {
        vec![self.axis]
    }

    fn elementary(&self, _: &[f64]) -> Vec<(Joint, UnitQuaternion<f64>)> {
        vec![Joint::slide(&self.axis)]
    }

    fn conditions(&self) -> Vec<Condition> {
        let around = around(&self.axis);
        Condition::on_line(around).into_iter().chain(Condition::parallel(around)).collect()
    }

    fn shared(&self) -> Vec<Vector3<f64>> {
        frame().to_vec()
    }
}
