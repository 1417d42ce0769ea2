//! The solids that bodies are drawn as.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

/// A solid in body axes, centred on its own origin; cylinders and capsules along its z.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Solid {
    pub(super) form: Form,
    /// `body_from_solid`.
    pub(super) pose: Isometry3<f64>,
    /// Red, green, blue, opacity, 0…1.
    pub(super) color: [f64; 4],
    /// Whether the scenario chose the colour.
    pub(super) own_color: bool,
    /// Whether it is the part of a plane that is drawn.
    pub(super) unbounded: bool,
}

/// The forms of solids (m).
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Form {
    /// Edge lengths.
    Box([f64; 3]),
    /// Radius.
    Ball(f64),
    /// Along z.
    Cylinder { radius: f64, length: f64 },
    /// Along z; the length of the cylindrical part.
    Capsule { radius: f64, length: f64 },
    /// The mesh file and its content.
    Mesh { file: String, contents: Vec<u8>, media_type: &'static str, scale: [f64; 3] },
}

/// The pose of a form along z from a point by a way (m); `None` if the way has no length.
pub(super) fn along(from: Vector3<f64>, way: Vector3<f64>) -> Option<Isometry3<f64>> {
    let along = way.try_normalize(0.0)?;
    let turn = UnitQuaternion::rotation_between(&Vector3::z(), &along)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    Some(Isometry3::from_parts(Translation3::from(from + 0.5 * way), turn))
}
