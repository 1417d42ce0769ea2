//! What of a part depends on the instant: surfaces of beams and bushings bend, all others are what they were.

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
        let origin = self.place(poses).pose.translation.vector;
        match &self.place {
            Place::Swept { sweep, tints } => {
                let triangles = sweep.triangles(poses, &origin);
                let tint = |corner: usize| tints.get(sweep.ring_of(corner)).copied();
                let tints = (0..triangles.positions.len()).map_while(tint).collect::<Vec<_>>();
                Shape { triangles: Arc::new(triangles), tints }
            }
            Place::Mounted(mount) => {
                Shape { triangles: Arc::new(mount.triangles(poses, &origin)), tints: mount.tints.clone() }
            }
            _ => Shape { triangles: self.triangles.clone(), tints: Vec::new() },
        }
    }
}
