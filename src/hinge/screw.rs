//! Turns about an axis and slides along it, the distance in proportion to the angle.

use super::axes::{Say, around, check_axis};
use super::joint::Joint;
use super::question::{Condition, Freedom, Keys, Names};
use nalgebra::{UnitQuaternion, Vector3};

/// Turns about an axis and slides along it by `pitch` per radian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Screw {
    /// Axis, hinge frame.
    pub axis: Vector3<f64>,
    /// Distance along the axis for a turn by 1 rad (m/rad), not zero; negative for a left-hand thread.
    pub pitch: f64,
}

impl Freedom for Screw {
    const NAME: &'static str = "screw";
    const DOC: &'static str = "Turns about `axis` and slides along it by `pitch` times the angle. Coordinate: angle.";
    const CLOSES: Option<&'static str> =
        Some("Turns about `axis` and slides along it by `pitch` times the angle, from the nearest turn of the thread.");
    const AXES: usize = 1;
    const POSITIONS: Names = &[("angle", "rad")];
    const VELOCITIES: Names = &[("rate", "rad/s")];

    fn read(keys: &dyn Keys) -> Self {
        Self { axis: keys.axis(), pitch: keys.pitch() }
    }

    fn check(&self, owner: &str, say: Say<'_>) {
        check_axis(&self.axis, owner, say);
        if self.pitch == 0.0 || !self.pitch.is_finite() {
            let help = "allowed: a finite number that is not zero, negative for a left-hand thread; \
                a hinge that turns without sliding is `revolute`";
            say("pitch", format!("the pitch of the {owner} is {} m/rad", self.pitch), help);
        }
    }

    fn axes(&self) -> Vec<Vector3<f64>> {
        vec![self.axis]
    }

    fn elementary(&self, _: &[f64]) -> Vec<(Joint, UnitQuaternion<f64>)> {
        vec![Joint::screw(&self.axis, self.pitch)]
    }

    fn conditions(&self) -> Vec<Condition> {
        let around = around(&self.axis);
        let [across, _, axis] = around;
        let thread = Condition::Thread { axis, across, pitch: self.pitch };
        Condition::on_line(around).into_iter().chain(Condition::upright(around)).chain([thread]).collect()
    }
}
