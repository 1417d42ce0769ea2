//! Shapes: what a body looks like, and what it weighs when a density is given.

use super::description::MassProperties;
use nalgebra::{Isometry3, Matrix3, Vector3};
use std::path::PathBuf;

/// A solid in body axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// The solid, centred on its own origin; cylinders and capsules along its z.
    pub geometry: Geometry,
    /// Where it stands: `body_from_shape`.
    pub pose: Isometry3<f64>,
    /// Red, green, blue, opacity, 0…1.
    pub color: Option<[f64; 4]>,
    /// Whether it touches the shapes of other bodies, if there is a contact between them.
    pub collides: bool,
    /// Whether it is drawn.
    pub visible: bool,
}

/// The solids.
#[derive(Debug, Clone, PartialEq)]
pub enum Geometry {
    /// Edge lengths (m).
    Box(Vector3<f64>),
    /// Radius (m).
    Sphere(f64),
    /// Along z.
    Cylinder {
        /// Radius (m).
        radius: f64,
        /// Length (m).
        length: f64,
    },
    /// A cylinder along z with half spheres on its ends.
    Capsule {
        /// Radius (m).
        radius: f64,
        /// Of the cylindrical part (m).
        length: f64,
    },
    /// All points behind a plane through the origin: its outward normal, of any length.
    Plane(Vector3<f64>),
    /// A triangle mesh in a file.
    Mesh {
        /// File as found from the scenario's folder.
        file: PathBuf,
        /// Scale of each axis.
        scale: Vector3<f64>,
        /// Whether its convex hull touches in its place.
        hull: bool,
        /// Its convex parts, if it may touch anything.
        parts: Vec<Hull>,
    },
}

/// A convex polytope.
#[derive(Debug, Clone, PartialEq)]
pub struct Hull {
    /// Its corners (m).
    pub corners: Vec<Vector3<f64>>,
    /// Three corners each, counter-clockwise as seen from outside.
    pub triangles: Vec<[usize; 3]>,
}

impl Shape {
    /// Mass properties of the solid filled with `density` (kg/m³); `None` for a plane, which
    /// has none, and for a mesh: what it encloses stands in its file ([`crate::mesh::Mesh::solid`]).
    pub fn mass_properties(&self, density: f64) -> Option<MassProperties> {
        let (mass, principal) = match &self.geometry {
            Geometry::Box(edges) => {
                let mass = density * edges.product();
                let s = edges.component_mul(edges);
                (mass, Vector3::new(s.y + s.z, s.x + s.z, s.x + s.y) * (mass / 12.0))
            }
            Geometry::Sphere(r) => {
                let mass = density * 4.0 / 3.0 * std::f64::consts::PI * r.powi(3);
                (mass, Vector3::repeat(0.4 * mass * r * r))
            }
            Geometry::Cylinder { radius, length } => {
                let mass = density * std::f64::consts::PI * radius * radius * length;
                let across = mass * (3.0 * radius * radius + length * length) / 12.0;
                (mass, Vector3::new(across, across, 0.5 * mass * radius * radius))
            }
            Geometry::Capsule { radius: r, length: l } => {
                let middle = density * std::f64::consts::PI * r * r * l;
                let ends = density * 4.0 / 3.0 * std::f64::consts::PI * r.powi(3);
                // Each half sphere: centroid 3r/8 beyond the end, 83/320 m r² per half about its own centroid.
                let across = middle * (3.0 * r * r + l * l) / 12.0
                    + ends * (83.0 / 320.0 * r * r + (0.5 * l + 0.375 * r).powi(2));
                (middle + ends, Vector3::new(across, across, 0.5 * middle * r * r + 0.4 * ends * r * r))
            }
            Geometry::Plane(_) | Geometry::Mesh { .. } => return None,
        };
        let turn = self.pose.rotation.to_rotation_matrix();
        Some(MassProperties {
            mass,
            center: self.pose.translation.vector,
            inertia: turn * Matrix3::from_diagonal(&principal) * turn.transpose(),
        })
    }
}

/// One rigid body out of several in the same axes, by the parallel-axis theorem; their masses must not be all zero.
pub fn combined(parts: &[MassProperties]) -> MassProperties {
    let mass: f64 = parts.iter().map(|part| part.mass).sum();
    let center = parts.iter().map(|part| part.center * part.mass).sum::<Vector3<f64>>() / mass;
    let inertia = parts
        .iter()
        .map(|part| {
            let away = part.center - center;
            part.inertia + (Matrix3::identity() * away.norm_squared() - away * away.transpose()) * part.mass
        })
        .sum();
    MassProperties { mass, center, inertia }
}
