//! What a closed mesh encloses.

use super::Mesh;
use nalgebra::{Matrix3, Vector3};
use std::collections::HashMap;

/// The body that a closed mesh encloses, of density one.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    /// Volume (m³), positive.
    pub volume: f64,
    /// Its centre (m).
    pub center: Vector3<f64>,
    /// Inertia about the centre for a density of 1 kg/m³ (kg m²).
    pub inertia: Matrix3<f64>,
    /// The triangles look inwards; they were taken as if they looked outwards.
    pub inside_out: bool,
}

/// Why a mesh encloses nothing.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NotSolid {
    /// There are edges where the surface ends.
    #[error("it is not closed: {edges} edges belong to one triangle alone, or to two that look different ways, the first from {from} to {to}", from = shown(between[0]), to = shown(between[1]))]
    Open {
        /// How many.
        edges: usize,
        /// The ends of the first of them, as they stand in the file.
        between: [[f32; 3]; 2],
    },
    /// It is flat.
    #[error("it encloses no volume")]
    Flat,
}

fn shown([x, y, z]: [f32; 3]) -> String {
    format!("[{x}, {y}, {z}]")
}

impl Mesh {
    /// The body that the mesh encloses once its axes are scaled.
    ///
    /// Corners at the same place are one corner. Every edge has to be passed as often one way as the other: then the
    /// sum over tetrahedra from any point to the triangles is the volume, whatever the shape.
    ///
    /// # Errors
    /// If the surface has a border, or encloses nothing.
    pub fn solid(&self, scale: Vector3<f64>) -> Result<Solid, NotSolid> {
        self.check_closed()?;
        let [low, high] = self.bounds().unwrap_or_default().map(|end| Vector3::from(end).cast::<f64>());
        let middle = 0.5 * (low + high).component_mul(&scale);
        let corner =
            |index: u32| Vector3::from(self.vertices[index as usize]).cast::<f64>().component_mul(&scale) - middle;
        let (mut volume, mut first, mut second) = (0.0, Vector3::zeros(), Matrix3::zeros());
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(corner);
            let part = a.dot(&b.cross(&c)) / 6.0;
            let sum = a + b + c;
            volume += part;
            first += sum * (part / 4.0);
            second +=
                (a * a.transpose() + b * b.transpose() + c * c.transpose() + sum * sum.transpose()) * (part / 20.0);
        }
        let size = (high - low).component_mul(&scale).abs().max();
        // Round-off of a sum over the triangles.
        if !(volume.abs() > 1e-12 * size.powi(3)) {
            return Err(NotSolid::Flat);
        }
        let center = first / volume;
        let about_center = second / volume - center * center.transpose();
        let about_center = about_center * volume.abs();
        let inertia = Matrix3::identity() * about_center.trace() - about_center;
        // A mirrored mesh looks inwards because of its scale, not of itself.
        let inside_out = volume * scale.product().signum() < 0.0;
        Ok(Solid { volume: volume.abs(), center: center + middle, inertia, inside_out })
    }

    fn check_closed(&self) -> Result<(), NotSolid> {
        let mut places: HashMap<[u32; 3], u32> = HashMap::new();
        // Zero has two signs.
        let key = |at: &[f32; 3]| at.map(|x| (x + 0.0).to_bits());
        let welded: Vec<u32> =
            (0..).zip(&self.vertices).map(|(index, at)| *places.entry(key(at)).or_insert(index)).collect();
        let mut balance: HashMap<[u32; 2], i64> = HashMap::new();
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|corner| welded[corner as usize]);
            for [from, to] in [[a, b], [b, c], [c, a]].into_iter().filter(|[from, to]| from != to) {
                let (edge, way) = if from < to { ([from, to], 1) } else { ([to, from], -1) };
                *balance.entry(edge).or_insert(0) += way;
            }
        }
        let open = balance.iter().filter(|(_, balance)| **balance != 0).map(|(edge, _)| *edge);
        let (edges, first) = (open.clone().count(), open.min());
        match first {
            Some(edge) => Err(NotSolid::Open { edges, between: edge.map(|corner| self.vertices[corner as usize]) }),
            None => Ok(()),
        }
    }
}
