//! Bushings: blocks of rubber between two plates, which are sheared and squeezed with these.

use super::entity::color;
use super::forces::spring_path;
use super::sdk::{Mesh3D, TimeColumn, components};
use super::sent::Sent;
use super::stream::Stream;
use crate::record::Scene;
use crate::record::drawing::bounds::Outline;
use crate::record::drawing::mount::{Mount, mounts};
use crate::spatial::Pose;
use nalgebra::Vector3;
use std::sync::Arc;

/// All bushings of a scene, with their names.
#[derive(Debug, Clone, Default)]
pub(super) struct Mounts(Vec<(String, Arc<Mount>)>);

/// Corners and normals of one of them in a stretch of samples.
#[derive(Debug, Clone, Default)]
pub(super) struct Strained {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

impl Mounts {
    /// Of a scene of some size (m), whose bodies have these outlines.
    pub(super) fn new(scene: &Scene, outlines: &[Outline], size: f64) -> Self {
        Self(mounts(scene, outlines, size))
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.0.len()
    }

    /// How many numbers a sample takes: each corner has a place and a normal.
    pub(super) fn numbers(&self) -> usize {
        self.0.iter().map(|(_, mount)| 6 * mount.carriers.len()).sum()
    }

    /// What does not change: which corners belong together, and their colours.
    pub(super) fn send(&self, stream: &Stream) -> Sent {
        for (name, mount) in &self.0 {
            let corners = mount.corners().iter().map(|corners| components::TriangleIndices((*corners).into()));
            let colors = mount.tints.iter().map(|[r, g, b]| color([*r, *g, *b, 1.0]));
            let looks = Mesh3D::update_fields().with_triangle_indices(corners).with_vertex_colors(colors);
            stream.log(spring_path(name), &looks)?;
        }
        Ok(())
    }

    /// Adds a sample.
    pub(super) fn push(&self, poses: &[Pose], columns: &mut [Strained]) {
        for ((_, mount), column) in self.0.iter().zip(columns) {
            let triangles = mount.triangles(poses, &Vector3::zeros());
            column.positions.extend(triangles.positions);
            column.normals.extend(triangles.normals);
        }
    }

    /// Sends a stretch of so many samples.
    pub(super) fn send_columns(
        &self,
        stream: &Stream,
        times: &TimeColumn,
        columns: Vec<Strained>,
        drawn: usize,
    ) -> Sent {
        for ((name, _), Strained { positions, normals }) in self.0.iter().zip(columns) {
            let lengths = std::iter::repeat_n(positions.len() / drawn, drawn);
            let surface = Mesh3D::update_fields().with_vertex_positions(positions).with_vertex_normals(normals);
            stream.send_columns(spring_path(name), times.clone(), surface.columns(lengths)?)?;
        }
        Ok(())
    }
}
