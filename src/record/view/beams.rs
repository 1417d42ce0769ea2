//! Beams: surfaces that bend, coloured by what they bear.

use super::entity::{color, path};
use super::sdk::{Color, EntityPath, Mesh3D, TimeColumn, components};
use super::sent::Sent;
use super::stream::Stream;
use crate::record::drawing::shades::shade;
use crate::record::drawing::sweep::Sweep;
use crate::record::{Sample, Scene, Tubes};
use nalgebra::Vector3;

/// Beams thinner than this part of the scene are drawn as thick as that.
const LEAST: f64 = 0.0015;

/// The surfaces of a scene, and how they are coloured.
#[derive(Debug, Clone, Default)]
pub(super) struct Beams {
    tubes: Tubes,
    sweeps: Vec<(String, Sweep)>,
    /// What has the darkest colour (Pa or N m); zero if that is not known.
    most: f64,
}

/// What one of them does in a stretch of samples.
#[derive(Debug, Clone, Default)]
pub(super) struct Bent {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    colors: Vec<Color>,
}

impl Beams {
    /// Of a scene of some size (m), whose beams bear at most so much (Pa or N m).
    pub(super) fn new(scene: &Scene, size: f64, most: f64) -> Self {
        let tubes = Tubes::new(scene);
        let sweep = |tube: &_| Sweep::new(tube, LEAST * size);
        let sweeps = tubes.beams.iter().map(|tube| (tube.name.clone(), sweep(tube))).collect();
        Self { tubes, sweeps, most }
    }

    /// How many there are.
    pub(super) fn count(&self) -> usize {
        self.sweeps.len()
    }

    /// How many numbers a sample takes.
    pub(super) fn numbers(&self) -> usize {
        // Sixteen corners a cross section, each with a place, a normal and a colour.
        16 * 7 * self.tubes.count()
    }

    fn path(name: &str) -> EntityPath {
        path(&["beams", name])
    }

    /// What does not change: which corners belong together.
    pub(super) fn send(&self, stream: &Stream) -> Sent {
        for (name, sweep) in &self.sweeps {
            let corners = sweep.corners.iter().map(|corners| components::TriangleIndices((*corners).into()));
            stream.log(Self::path(name), &Mesh3D::update_fields().with_triangle_indices(corners))?;
        }
        Ok(())
    }

    /// Adds a sample.
    pub(super) fn push(&self, sample: &Sample, columns: &mut [Bent]) {
        if self.sweeps.is_empty() {
            return;
        }
        let mut poses = sample.bodies.to_vec();
        self.tubes.extend(sample.positions, &mut poses);
        let loads = self.tubes.loads(&poses, sample.reactions);
        let mut from = 0;
        for ((_, sweep), column) in self.sweeps.iter().zip(columns) {
            let triangles = sweep.triangles(&poses, &Vector3::zeros());
            let tint = |corner: usize| {
                let load = loads.get(from + sweep.ring_of(corner)).copied().unwrap_or(0.0);
                let [r, g, b] = shade(if self.most > 0.0 { load / self.most } else { 0.0 });
                color([r, g, b, 1.0])
            };
            column.colors.extend((0..triangles.positions.len()).map(tint));
            column.positions.extend(triangles.positions);
            column.normals.extend(triangles.normals);
            from += sweep.rings();
        }
    }

    /// Sends a stretch of so many samples.
    pub(super) fn send_columns(&self, stream: &Stream, times: &TimeColumn, columns: Vec<Bent>, drawn: usize) -> Sent {
        for ((name, _), bent) in self.sweeps.iter().zip(columns).filter(|(_, bent)| !bent.positions.is_empty()) {
            let lengths = std::iter::repeat_n(bent.positions.len() / drawn, drawn);
            let surface = Mesh3D::update_fields()
                .with_vertex_positions(bent.positions)
                .with_vertex_normals(bent.normals)
                .with_vertex_colors(bent.colors);
            stream.send_columns(Self::path(name), times.clone(), surface.columns(lengths)?)?;
        }
        Ok(())
    }
}
