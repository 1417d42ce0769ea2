//! Where a part is.

use super::Triangles;
use super::anchor::{Anchor, carried, point, toward};
use super::mount::Mount;
use super::sweep::Sweep;
use crate::spatial::Pose;
use nalgebra::{Isometry3, Translation3, UnitQuaternion};
use std::sync::Arc;

/// Something that is drawn: triangles in axes of their own, and where these axes are.
#[derive(Debug, Clone)]
pub struct Part {
    /// Name of the body, line, load or hinge.
    pub name: String,
    /// In the part's axes. Parts of one form share them. Empty of beams and bushings, whose surfaces change as they bend.
    pub triangles: Arc<Triangles>,
    /// Red, green, blue, opacity, 0…1.
    pub color: [f64; 4],
    /// Whether it stands for something without bounds, or for a body that is not framed: no frame holds it.
    pub unbounded: bool,
    /// Whether it is an arrow. Pictures paint these over everything else: an arrow that pushes on a body would vanish in it.
    pub is_arrow: bool,
    pub(super) place: Place,
}

/// What a part moves with.
#[derive(Debug, Clone)]
pub(super) enum Place {
    /// A body (`None`: the ground): the pose in its axes, and the scale.
    Body { body: Option<usize>, pose: Pose, scale: [f64; 3] },
    /// Two points: the part's z goes from the first to the second and is as long as they are apart.
    Span { ends: [Anchor; 2], radius: f64 },
    /// A point of a body: the direction in space stays.
    Point { at: Anchor, turn: UnitQuaternion<f64>, scale: f64 },
    /// Cross sections of a beam, with the colour of each if what they bear is shown.
    Swept { sweep: Arc<Sweep>, tints: Vec<[f64; 3]> },
    /// The two frames of a bushing.
    Mounted(Arc<Mount>),
}

/// Where a part's axes are at one instant: `world_from_part = pose · diag(scale)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// Of the part's axes.
    pub pose: Pose,
    /// Along the part's axes; zero of a part that cannot be seen.
    pub scale: [f64; 3],
}

impl Part {
    /// Where it is when the bodies are in these poses.
    pub fn place(&self, poses: &[Pose]) -> Placement {
        match &self.place {
            Place::Body { body, pose, scale } => Placement { pose: carried(*body, poses) * pose, scale: *scale },
            Place::Point { at, turn, scale } => {
                let pose = Isometry3::from_parts(Translation3::from(point(at, poses)), *turn);
                Placement { pose, scale: [*scale; 3] }
            }
            Place::Span { ends, radius } => {
                let [a, b] = ends.map(|end| point(&end, poses));
                let along = b - a;
                // Points at one place have no direction between them.
                let scale = if along.norm() > 1e-9 * radius { [*radius, *radius, along.norm()] } else { [0.0; 3] };
                Placement { pose: Isometry3::from_parts(a.into(), toward(&along)), scale }
            }
            Place::Mounted(mount) => Placement { pose: mount.poses(poses)[0].translation.into(), scale: [1.0; 3] },
            Place::Swept { sweep, .. } => {
                let first = sweep.poses(poses).map(|poses| poses[0].translation);
                let scale = if first.is_some() { 1.0 } else { 0.0 };
                Placement { pose: first.unwrap_or_default().into(), scale: [scale; 3] }
            }
        }
    }

    /// The bodies that it moves with.
    pub(super) fn bodies(&self) -> impl Iterator<Item = usize> {
        let ends = match &self.place {
            Place::Body { body, .. } => [*body, None],
            Place::Point { at, .. } => [at.0, None],
            Place::Span { ends, .. } => ends.map(|end| end.0),
            Place::Swept { sweep, .. } => sweep.ends.map(Some),
            Place::Mounted(mount) => mount.frames.map(|(body, _)| body),
        };
        ends.into_iter().flatten()
    }

    /// The surface of a beam, and the colours of its cross sections, if it is one.
    pub(in crate::record) fn swept(&self) -> Option<(&Sweep, &[[f64; 3]])> {
        match &self.place {
            Place::Swept { sweep, tints } => Some((sweep, tints)),
            _ => None,
        }
    }

    /// The block of a bushing, if it is one.
    pub(in crate::record) fn mount(&self) -> Option<&Mount> {
        match &self.place {
            Place::Mounted(mount) => Some(mount),
            _ => None,
        }
    }

    /// The body that it moves with as one piece, and its place in that body's axes; `None` if it moves otherwise. Of the ground the
    /// body is `None`.
    pub fn rigid(&self) -> Option<(Option<usize>, Placement)> {
        match &self.place {
            Place::Body { body, pose, scale } => Some((*body, Placement { pose: *pose, scale: *scale })),
            _ => None,
        }
    }
}
