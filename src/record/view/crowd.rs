//! Scenes of many bodies: all solids of one form drawn as one thing, since each thing of its own costs the viewer time
//! in every frame, whether it moves or not.

use super::entity::{color, path, point, quaternion};
use super::sdk::{
    Boxes3D, Capsules3D, Color, Cylinders3D, Ellipsoids3D, EntityPath, FillMode, LineStrips3D, Radius,
    SerializedComponentColumn,
};
use super::sent::Sent;
use super::stream::Stream;
use crate::record::Scene;
use crate::record::solids::{Form, Solid};
use crate::spatial::Pose;
use nalgebra::{Isometry3, Translation3};

/// From so many bodies on.
pub(super) const CROWD: usize = 300;

/// Solids by form, and the lines that join bodies to their parents: from afar nothing else is left of a long chain.
#[derive(Debug, Clone, Default)]
pub(super) struct Crowd {
    groups: Vec<Group>,
    /// Body and parent.
    joined: Vec<(usize, usize)>,
}

#[derive(Debug, Clone)]
struct Group {
    kind: Kind,
    /// The body, its solid's pose in it, and its size as the viewer's primitive takes it.
    members: Vec<(usize, Isometry3<f64>, [f32; 3])>,
    colors: Vec<Color>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Box,
    Ball,
    Cylinder,
    Capsule,
}

/// What a crowd does in a stretch of samples: by group centres and turns, then the lines.
#[derive(Debug, Clone, Default)]
pub(super) struct Moves {
    groups: Vec<(Vec<[f32; 3]>, Vec<super::sdk::Quaternion>)>,
    lines: Vec<[[f32; 3]; 2]>,
}

impl Crowd {
    /// Of the bodies that are drawn with others; the others are taken out of `solids`. Meshes stay on their own.
    pub(super) fn take(scene: &Scene, solids: &mut [Vec<Solid>]) -> Option<Self> {
        if scene.bodies.len() < CROWD {
            return None;
        }
        let mut crowd = Self::default();
        for (index, solids) in solids.iter_mut().enumerate() {
            if solids.iter().any(|solid| matches!(solid.form, Form::Mesh { .. })) {
                continue;
            }
            solids.drain(..).for_each(|solid| crowd.add(index, &solid));
        }
        let joined = scene.bodies.iter().enumerate().filter_map(|(index, body)| Some((index, body.parent?)));
        crowd.joined = joined.collect();
        Some(crowd)
    }

    fn add(&mut self, body: usize, solid: &Solid) {
        let (kind, pose, size) = match solid.form {
            Form::Box(edges) => (Kind::Box, solid.pose, edges.map(|edge| 0.5 * edge as f32)),
            Form::Ball(radius) => (Kind::Ball, solid.pose, [radius as f32; 3]),
            Form::Cylinder { radius, length } => (Kind::Cylinder, solid.pose, [length as f32, radius as f32, 0.0]),
            Form::Capsule { radius, length } => {
                // The viewer's capsules start at their origin.
                let start = solid.pose * Translation3::new(0.0, 0.0, -0.5 * length);
                (Kind::Capsule, start, [length as f32, radius as f32, 0.0])
            }
            Form::Mesh { .. } => return,
        };
        let found = self.groups.iter().position(|group| group.kind == kind);
        let at = found.unwrap_or_else(|| {
            self.groups.push(Group { kind, members: Vec::new(), colors: Vec::new() });
            self.groups.len() - 1
        });
        self.groups[at].members.push((body, pose, size));
        self.groups[at].colors.push(color(solid.color));
    }

    /// How many poses a sample takes.
    pub(super) fn members(&self) -> usize {
        self.groups.iter().map(|group| group.members.len()).sum::<usize>() + self.joined.len()
    }

    /// Sizes and colours.
    pub(super) fn send(&self, stream: &Stream) -> Sent {
        for group in &self.groups {
            let sizes = || group.members.iter().map(|(_, _, size)| *size);
            let (lengths, radii) = (sizes().map(|size| size[0]), sizes().map(|size| size[1]));
            let (at, colors, fill) = (group.path(), group.colors.clone(), FillMode::Solid);
            match group.kind {
                Kind::Box => {
                    let boxes = Boxes3D::update_fields().with_half_sizes(sizes());
                    stream.log(at, &boxes.with_colors(colors).with_fill_mode(fill))?;
                }
                Kind::Ball => {
                    let balls = Ellipsoids3D::update_fields().with_half_sizes(sizes());
                    stream.log(at, &balls.with_colors(colors).with_fill_mode(fill))?;
                }
                Kind::Cylinder => {
                    let cylinders = Cylinders3D::update_fields().with_lengths(lengths).with_radii(radii);
                    stream.log(at, &cylinders.with_colors(colors).with_fill_mode(fill))?;
                }
                Kind::Capsule => {
                    let capsules = Capsules3D::update_fields().with_lengths(lengths).with_radii(radii);
                    stream.log(at, &capsules.with_colors(colors).with_fill_mode(fill))?;
                }
            }
        }
        let lines = LineStrips3D::update_fields().with_radii([Radius::new_ui_points(1.0)]);
        stream.log(joined_path(), &lines.with_colors([JOINED]))
    }

    /// Adds the bodies at one instant.
    pub(super) fn push(&self, poses: &[Pose], moves: &mut Moves) {
        moves.groups.resize_with(self.groups.len(), Default::default);
        for (group, (centers, turns)) in self.groups.iter().zip(&mut moves.groups) {
            for (body, solid, _) in &group.members {
                let pose = poses[*body] * solid;
                centers.push(point(&pose.translation.vector));
                turns.push(quaternion(&pose.rotation));
            }
        }
        let at = |body: usize| point(&poses[body].translation.vector);
        moves.lines.extend(self.joined.iter().map(|(body, parent)| [at(*parent), at(*body)]));
    }

    /// The columns of `samples` samples.
    pub(super) fn columns(
        &self,
        moves: Moves,
        samples: usize,
    ) -> Sent<Vec<(EntityPath, Vec<SerializedComponentColumn>)>> {
        let mut all = Vec::new();
        for (group, (centers, turns)) in self.groups.iter().zip(moves.groups) {
            let lengths = std::iter::repeat_n(group.members.len(), samples);
            let columns: Vec<SerializedComponentColumn> = match group.kind {
                Kind::Box => {
                    Boxes3D::update_fields().with_centers(centers).with_quaternions(turns).columns(lengths)?.collect()
                }
                Kind::Ball => {
                    let balls = Ellipsoids3D::update_fields().with_centers(centers).with_quaternions(turns);
                    balls.columns(lengths)?.collect()
                }
                Kind::Cylinder => {
                    let cylinders = Cylinders3D::update_fields().with_centers(centers).with_quaternions(turns);
                    cylinders.columns(lengths)?.collect()
                }
                Kind::Capsule => {
                    let capsules = Capsules3D::update_fields().with_translations(centers).with_quaternions(turns);
                    capsules.columns(lengths)?.collect()
                }
            };
            all.push((group.path(), columns));
        }
        let lengths = std::iter::repeat_n(self.joined.len(), samples);
        let lines = LineStrips3D::update_fields().with_strips(moves.lines).columns(lengths)?.collect();
        all.push((joined_path(), lines));
        Ok(all)
    }
}

const JOINED: Color = Color(super::sdk::Rgba32::from_rgb(90, 110, 130));

fn joined_path() -> EntityPath {
    path(&["world", "bodies", "joined"])
}

impl Group {
    fn path(&self) -> EntityPath {
        path(&[
            "world",
            "bodies",
            match self.kind {
                Kind::Box => "boxes",
                Kind::Ball => "balls",
                Kind::Cylinder => "cylinders",
                Kind::Capsule => "capsules",
            },
        ])
    }
}
