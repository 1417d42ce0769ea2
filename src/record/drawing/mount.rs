//! Bushings as what they are in most machines: a block of rubber between two steel plates.
//!
//! Each plate is carried by one of the two frames that the bushing joins, and so is each end of the rubber. What is drawn is as far out of
//! shape as the bushing is: nothing is exaggerated.

use super::Triangles;
use super::anchor::{carried, toward};
use super::bounds::Outline;
use crate::record::Scene;
use crate::record::scene::BushingPicture;
use crate::spatial::Pose;
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Height of a relaxed block, edge and thickness of its plates and radius of its rubber, against the scene or the smaller of its bodies.
const HEIGHT: f64 = 0.036;
const EDGE: f64 = 0.048;
const PLATE: f64 = 0.006;
const RADIUS: f64 = 0.021;
/// Sides of the rubber.
const SIDES: usize = 16;

const RUBBER: [f64; 3] = [0.17, 0.17, 0.18];
const STEEL: [f64; 3] = [0.66, 0.68, 0.71];
const GROUND: [f64; 3] = [0.30, 0.31, 0.33];

/// A surface whose corners are carried by two frames.
#[derive(Debug, Clone)]
pub(in crate::record) struct Mount {
    /// The bodies (`None`: the ground), and the frames in their axes. The block stands along z, from the first to the second.
    pub(in crate::record) frames: [(Option<usize>, Pose); 2],
    /// For each corner which of the frames carries it.
    pub(in crate::record) carriers: Vec<usize>,
    /// For each corner its colour.
    pub(in crate::record) tints: Vec<[f64; 3]>,
    /// Each corner in the axes of its frame.
    local: Triangles,
}

impl Mount {
    /// Of a bushing in a scene of some size (m), whose bodies have these outlines.
    pub(in crate::record) fn new(scene: &Scene, bushing: &BushingPicture, outlines: &[Outline], size: f64) -> Self {
        let axis = axis(&bushing.stiffness);
        let turn =
            |[w, x, y, z]: [f64; 4]| UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.0).unwrap_or_default();
        // From its frame to the centre of mass, if it has one: the side of the relaxed block that a body is on.
        let aside = |k: usize| {
            let (body, at) = bushing.ends[k];
            let center = body.and_then(|body| scene.bodies.get(body)).map(|body| body.center);
            let apart = center.map_or(Vector3::zeros(), |center| Vector3::from(center) - Vector3::from(at));
            turn(bushing.frames[k]).inverse_transform_vector(&apart)[axis]
        };
        let mut along = Vector3::zeros();
        along[axis] = if aside(1) < aside(0) { -1.0 } else { 1.0 };
        let frame = |k: usize| {
            let (body, at) = bushing.ends[k];
            let turn = turn(bushing.frames[k]) * toward(&along);
            (body, Isometry3::from_parts(Translation3::from(at), turn))
        };
        let reach =
            |(body, _): &(Option<usize>, [f64; 3])| body.and_then(|body| outlines.get(body)).map(Outline::reach);
        let bodies = bushing.ends.iter().filter_map(reach).filter(|reach| *reach > 0.0);
        let unit = bodies.map(|reach| 2.0 * reach).fold(size, f64::min);
        // Beside a body that stands on the ground, in the middle between two bodies.
        let [first, second] = [0, 1].map(|k| bushing.ends[k].0.is_none());
        let below = match (first, second) {
            (true, _) => 1.0,
            (_, true) => 0.0,
            _ => 0.5,
        };
        let low = -below * HEIGHT * unit;
        let color = |is_ground: bool| if is_ground { GROUND } else { STEEL };
        let (local, carriers, tints) = block(unit, low, [color(first), color(second)]);
        Self { frames: [frame(0), frame(1)], carriers, tints, local }
    }

    /// The frames in these poses of the bodies, in inertial axes.
    pub(in crate::record) fn poses(&self, poses: &[Pose]) -> [Pose; 2] {
        self.frames.map(|(body, frame)| carried(body, poses) * frame)
    }

    /// Three corners each.
    #[cfg(feature = "view")]
    pub(in crate::record) fn corners(&self) -> &[[u32; 3]] {
        &self.local.corners
    }

    /// The surface in inertial axes moved to a point (m): single precision has the digits there.
    pub(in crate::record) fn triangles(&self, poses: &[Pose], origin: &Vector3<f64>) -> Triangles {
        let frames = self.poses(poses);
        let mut triangles = self.local.clone();
        for (k, carrier) in self.carriers.iter().enumerate() {
            let (at, normal) = (&mut triangles.positions[k], &mut triangles.normals[k]);
            let place = frames[*carrier] * Point3::from(Vector3::from(*at).cast::<f64>());
            *at = (place.coords - origin).cast::<f32>().into();
            *normal = (frames[*carrier].rotation * Vector3::from(*normal).cast::<f64>()).cast::<f32>().into();
        }
        triangles
    }
}

/// The axis that a block stands along: the one whose stiffness differs most from that of the two others, and z if none does. Blocks are
/// stiffest in compression, sleeves softest along their pin.
fn axis(stiffness: &[f64; 3]) -> usize {
    let apart = |k: usize| (stiffness[k] - 0.5 * (stiffness[(k + 1) % 3] + stiffness[(k + 2) % 3])).abs();
    (0..3).max_by(|a, b| apart(*a).total_cmp(&apart(*b))).unwrap_or(2)
}

/// Corners in the axes of their frames, the frame of each, and the colour of each. `low` is the height of the underside.
fn block(unit: f64, low: f64, plates: [[f64; 3]; 2]) -> (Triangles, Vec<usize>, Vec<[f64; 3]>) {
    let mut triangles = Triangles::empty();
    let (mut carriers, mut tints) = (Vec::new(), Vec::new());
    let mut marked = |triangles: &Triangles, carrier: usize, tint: [f64; 3]| {
        let count = triangles.positions.len();
        carriers.resize(count, carrier);
        tints.resize(count, tint);
    };
    let (plate, edge, high) = (PLATE * unit, EDGE * unit, low + HEIGHT * unit);
    for (carrier, middle) in [(0, low + 0.5 * plate), (1, high - 0.5 * plate)] {
        triangles.cuboid(&[edge, edge, plate], middle);
        marked(&triangles, carrier, plates[carrier]);
    }
    let rings = [(0, low + plate), (1, high - plate)].map(|(carrier, height)| {
        let ring: Vec<u32> = (0..=SIDES)
            .map(|side| {
                let (sin, cos) = (TAU * side as f64 / SIDES as f64).sin_cos();
                let normal = Vector3::new(cos, sin, 0.0);
                triangles.corner(RADIUS * unit * normal + height * Vector3::z(), normal)
            })
            .collect();
        marked(&triangles, carrier, RUBBER);
        ring
    });
    let [bottom, top] = rings;
    (0..SIDES).for_each(|k| triangles.patch([bottom[k], bottom[k + 1]], [top[k], top[k + 1]]));
    (triangles, carriers, tints)
}

/// All bushings of a scene, with their names.
pub(in crate::record) fn mounts(scene: &Scene, outlines: &[Outline], size: f64) -> Vec<(String, Arc<Mount>)> {
    let mount = |bushing: &BushingPicture| Arc::new(Mount::new(scene, bushing, outlines, size));
    scene.bushings.iter().map(|bushing| (bushing.name.clone(), mount(bushing))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::drawing::triangles::volume;

    #[test]
    fn a_block_stands_along_the_axis_that_is_unlike_the_others() {
        assert_eq!(axis(&[60e3, 60e3, 150e3]), 2);
        assert_eq!(axis(&[1e4, 1e6, 1e6]), 0);
        assert_eq!(axis(&[1e5, 1e5, 1e5]), 2);
    }

    fn mount(ends: [(Option<usize>, [f64; 3]); 2]) -> Mount {
        let frames = [[1.0, 0.0, 0.0, 0.0]; 2];
        let bushing = BushingPicture { name: "m".into(), ends, frames, stiffness: [1.0, 1.0, 2.0] };
        Mount::new(&Scene::default(), &bushing, &[], 1.0)
    }

    #[test]
    fn shear_leaves_the_rubber_its_volume_and_compression_takes_it() {
        let mount = mount([(None, [0.0; 3]), (Some(0), [0.0; 3])]);
        let at = |x: f64, z: f64| volume(&mount.triangles(&[Pose::translation(x, 0.0, z)], &Vector3::zeros()));
        let (relaxed, area) = (at(0.0, 0.0), 0.5 * SIDES as f64 * RADIUS * RADIUS * (TAU / SIDES as f64).sin());
        assert!((at(0.01, 0.0) - relaxed).abs() < 1e-6 * relaxed);
        // The rubber is a mantle without ends: two thirds of `1/3 Σ x·n A` are of it.
        assert!((relaxed - at(0.0, -0.004) - 2.0 / 3.0 * 0.004 * area).abs() < 1e-3 * relaxed);
    }

    #[test]
    fn a_block_on_the_ground_ends_at_the_point_of_its_body() {
        let heights = |mount: Mount| {
            let triangles = mount.triangles(&[Pose::identity()], &Vector3::zeros());
            let ends = |pick: fn(f32, f32) -> f32, start| triangles.positions.iter().map(|at| at[2]).fold(start, pick);
            [ends(f32::min, f32::INFINITY), ends(f32::max, f32::NEG_INFINITY)].map(f64::from)
        };
        let near = |found: [f64; 2], exact: [f64; 2]| found.iter().zip(exact).all(|(a, b)| (a - b).abs() < 1e-6);
        assert!(near(heights(mount([(None, [0.0; 3]), (Some(0), [0.0; 3])])), [-HEIGHT, 0.0]));
        assert!(near(heights(mount([(Some(0), [0.0; 3]), (None, [0.0; 3])])), [0.0, HEIGHT]));
    }
}
