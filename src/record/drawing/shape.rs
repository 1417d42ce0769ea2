//! What of a part depends on the instant: the surface of a beam is one at every instant, all others are what they were.

use super::Triangles;
use super::place::{Part, Place};
use crate::spatial::Pose;
use std::sync::Arc;

/// What of a part depends on the instant.
#[derive(Debug, Clone)]
pub(in crate::record) struct Shape {
    /// In the axes of its placement.
    pub(in crate::record) triangles: Arc<Triangles>,
    /// Colours of the corners; empty if the part has one.
    pub(in crate::record) tints: Vec<[f64; 3]>,
}

impl Part {
    /// What it is when bodies and cross sections are in these poses.
    pub(in crate::record) fn shape(&self, poses: &[Pose]) -> Shape {
        let Place::Swept { sweep, tints } = &self.place else {
            return Shape { triangles: self.triangles.clone(), tints: Vec::new() };
        };
        let triangles = sweep.triangles(poses, &self.place(poses).pose.translation.vector);
        let tint = |corner: usize| tints.get(sweep.ring_of(corner)).copied();
        let tints = (0..triangles.positions.len()).map_while(tint).collect::<Vec<_>>();
        Shape { triangles: Arc::new(triangles), tints }
    }
}
