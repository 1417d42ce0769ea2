//! Slides along a curve.

use super::joint::Joint;
use super::question::{Condition, Freedom, Keys, Names};
use nalgebra::{UnitQuaternion, Vector3};

/// Slides along the curve that its description has.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Along {
    /// About and with the curve.
    pub turn: AlongTurn,
}

/// How a body turns that slides along a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AlongTurn {
    /// With the tangent, which is its x axis, and not about it.
    #[default]
    Follows,
    /// With the tangent, and freely about it.
    Free,
    /// Not at all.
    Held,
}

impl AlongTurn {
    /// The values of the key `turn`.
    pub const WORDS: &[(&str, &str)] = &[
        ("follows", "Its x axis is the tangent; it does not turn about it."),
        ("free", "Its x axis is the tangent; it turns freely about it. A second coordinate: that angle."),
        ("held", "It keeps its turn on the parent."),
    ];

    /// From the value of the key; what is no value has been said already.
    pub fn read(word: Option<&str>) -> Self {
        match word {
            Some("free") => Self::Free,
            Some("held") => Self::Held,
            _ => Self::Follows,
        }
    }
}

const POSITIONS: Names = &[("distance", "m"), ("angle", "rad")];
const VELOCITIES: Names = &[("speed", "m/s"), ("rate", "rad/s")];

impl Freedom for Along {
    const NAME: &'static str = "along";
    const DOC: &'static str = "Slides along `curve`. Coordinate: arc length; with `turn = \"free\"` also the angle about the tangent.";
    const CLOSES: Option<&'static str> = None;
    const POSITIONS: Names = POSITIONS.split_at(1).0;
    const VELOCITIES: Names = VELOCITIES.split_at(1).0;

    fn read(keys: &dyn Keys) -> Self {
        Self { turn: AlongTurn::read(keys.turn()) }
    }

    fn positions(&self) -> Names {
        if self.turn == AlongTurn::Free { POSITIONS } else { Self::POSITIONS }
    }

    fn velocities(&self) -> Names {
        if self.turn == AlongTurn::Free { VELOCITIES } else { Self::VELOCITIES }
    }

    fn order(&self) -> Option<[&'static str; 2]> {
        (self.turn == AlongTurn::Free).then_some(["along the curve, about the tangent"; 2])
    }

    fn elementary(&self, _: &[f64]) -> Vec<(Joint, UnitQuaternion<f64>)> {
        // Which element it is, the tree knows.
        let along = (Joint::Along { rod: 0 }, UnitQuaternion::identity());
        match self.turn {
            AlongTurn::Free => vec![along, Joint::turn(&Vector3::x())],
            AlongTurn::Follows | AlongTurn::Held => vec![along],
        }
    }

    fn conditions(&self) -> Vec<Condition> {
        Vec::new()
    }
}
