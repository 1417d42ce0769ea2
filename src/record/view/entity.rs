//! What the viewer calls things by, and numbers as it has them: paths, points, turns, colours.

use super::sdk::{Color, EntityPath, EntityPathPart, Quaternion};
use nalgebra::{UnitQuaternion, Vector3};

/// Name of the timeline.
pub(super) const TIMELINE: &str = "sim_time";

/// The text that stays, and the one that changes.
pub(super) const STATICS: &str = "statics";
pub(super) const CAPTION: &str = "caption";

/// A path of names that may hold any character.
pub(super) fn path(parts: &[&str]) -> EntityPath {
    EntityPath::from(parts.iter().map(|part| EntityPathPart::new(*part)).collect::<Vec<_>>())
}

pub(super) fn body_path(name: &str) -> EntityPath {
    path(&["world", name])
}

pub(super) fn center_path() -> EntityPath {
    path(&["center of mass"])
}

pub(super) fn point(vector: &Vector3<f64>) -> [f32; 3] {
    vector.cast::<f32>().into()
}

pub(super) fn quaternion(turn: &UnitQuaternion<f64>) -> Quaternion {
    let turn = turn.quaternion().cast::<f32>();
    Quaternion::from_xyzw([turn.i, turn.j, turn.k, turn.w])
}

pub(super) fn color(rgba: [f64; 4]) -> Color {
    let [r, g, b, a] = rgba.map(|part| (255.0 * part.clamp(0.0, 1.0)).round() as u8);
    Color::from_unmultiplied_rgba(r, g, b, a)
}
