//! Slides in the xy plane of the hinge frame and turns about its z.

use super::axes::frame;
use super::joint::Joint;
use super::question::{Condition, Freedom, Keys, Names};
use nalgebra::{UnitQuaternion, Vector3};

/// Slides in the xy plane of the hinge frame and turns about its z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Planar;

impl Freedom for Planar {
    const NAME: &'static str = "planar";
    const DOC: &'static str = 
        "Slides in the xy plane of the hinge frame and turns about its z. Coordinates: x, y, angle.";
    const CLOSES: Option<&'static str> = Some("Slides in the xy plane of the loop's frame and turns about its z.");
    const POSITIONS: Names = &[("x", "m"), ("y", "m"), ("angle", "rad")];
    const VELOCITIES: Names = &[("vx", "m/s"), ("vy", "m/s"), ("rate", "rad/s")];
    const ORDER: Option<[&'static str; 2]> = Some(["x, y, about z"; 2]);

    fn read(_: &dyn Keys) -> Self {
        Self
    }

    fn axes(&self) -> Vec<Vector3<f64>> {
        vec![Vector3::z()]
    }

    fn elementary(&self, _: &[f64]) -> Vec<(Joint, UnitQuaternion<f64>)> {
        let [x, y, z] = frame();
        vec![Joint::slide(&x), Joint::slide(&y), Joint::turn(&z)]
    }

    fn conditions(&self) -> Vec<Condition> {
        std::iter::once(Condition::Along(Vector3::z())).chain(Condition::upright(frame())).collect()
    }
}
