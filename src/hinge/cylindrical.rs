//! Slides along and turns about one axis.

use super::axes::around;
use super::joint::Joint;
use super::question::{Condition, Freedom, Keys, Names};
use nalgebra::{UnitQuaternion, Vector3};

/// Slides along and turns about one axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cylindrical {
    /// Axis, hinge frame.
    pub axis: Vector3<f64>,
}

impl Freedom for Cylindrical {
    const NAME: &'static str = "cylindrical";
    const DOC: &'static str = "Slides along and turns about `axis`. Coordinates: distance, angle.";
    const CLOSES: Option<&'static str> = Some("Slides along and turns about `axis`.");
    const AXES: usize = 1;
    const POSITIONS: Names = &[("distance", "m"), ("angle", "rad")];
    const VELOCITIES: Names = &[("speed", "m/s"), ("rate", "rad/s")];
    const ORDER: Option<[&'static str; 2]> = Some(["along the axis, about the axis"; 2]);

    fn read(keys: &dyn Keys) -> Self {
        Self { axis: keys.axis() }
    }

    fn axes(&self) -> Vec<Vector3<f64>> {
        vec![self.axis]
    }

    fn elementary(&self, _: &[f64]) -> Vec<(Joint, UnitQuaternion<f64>)> {
        vec![Joint::slide(&self.axis), Joint::turn(&self.axis)]
    }

    fn conditions(&self) -> Vec<Condition> {
        let around = around(&self.axis);
        [Condition::on_line(around), Condition::upright(around)].concat()
    }
}
