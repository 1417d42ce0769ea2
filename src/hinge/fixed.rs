//! Welds.

use super::axes::frame;
use super::joint::Joint;
use super::question::{Condition, Freedom, Keys, Names};
use nalgebra::{UnitQuaternion, Vector3};

/// Welds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fixed;

impl Freedom for Fixed {
    const NAME: &'static str = "fixed";
    const DOC: &'static str = "Welded to the parent.";
    const CLOSES: Option<&'static str> = Some("Welds both ends together.");
    const POSITIONS: Names = &[];
    const VELOCITIES: Names = &[];

    fn read(_: &dyn Keys) -> Self {
        Self
    }

    fn elementary(&self, _: &[f64]) -> Vec<(Joint, UnitQuaternion<f64>)> {
        Vec::new()
    }

    fn conditions(&self) -> Vec<Condition> {
        [Condition::together(), Condition::parallel(frame())].concat()
    }

    fn shared(&self) -> Vec<Vector3<f64>> {
        frame().to_vec()
    }
}
