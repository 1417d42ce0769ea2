//! Beams and bushings: one mesh whose corners each move with a cross section or a frame.

use super::bytes::Purpose;
use super::{Writer, linear, material, number_of};
use crate::record::drawing::mount::Mount;
use crate::record::drawing::shades::shade;
use crate::record::drawing::sweep::Sweep;
use crate::record::drawing::{Drawing, Part, Placement, Triangles};
use crate::spatial::Pose;
use nalgebra::Vector3;
use serde_json::{Map, json};

/// A surface and what carries it.
struct Skin<'a> {
    part: &'a Part,
    /// The nodes that carry it, one after the other from this one on, and where they are in the still drawing.
    first: usize,
    still: &'a [Pose],
    /// In the still drawing.
    triangles: Triangles,
    /// For each corner which of these nodes carries it, and its colour; no colours if the part has one.
    carriers: Vec<usize>,
    colors: Vec<[f64; 3]>,
}

impl Writer<'_> {
    /// The most that each cross section bears in all frames, in the order of their poses; empty if that is not known.
    pub(super) fn most(&self) -> Vec<f64> {
        let mut most: Vec<f64> = Vec::new();
        for loads in self.clips.iter().flat_map(|clip| &clip.loads) {
            most.resize(most.len().max(loads.len()), 0.0);
            most.iter_mut().zip(loads).for_each(|(most, load)| *most = most.max(*load));
        }
        most
    }

    /// The skin of a beam; nothing if its cross sections are not among the poses. `most` has what all cross sections bear, `tints` the
    /// colours of the still drawing, for a file without frames.
    pub(super) fn beam(&mut self, drawing: &Drawing, part: &Part, sweep: &Sweep, tints: &[[f64; 3]], most: &[f64]) {
        let Some(still) = sweep.poses(self.still) else { return };
        let largest = most.iter().copied().fold(0.0, f64::max);
        let before = drawing.rings_before(sweep);
        let colors: Vec<[f64; 3]> = match most.get(before..before + sweep.rings()) {
            Some(own) if largest > 0.0 => own.iter().map(|load| shade(load / largest)).collect(),
            _ => tints.to_vec(),
        };
        let first = self.nodes.len();
        for ring in 0..sweep.rings() {
            let index = sweep.first + ring;
            self.moving(&format!("{} section {ring}", part.name), None, |poses| Placement {
                pose: poses.get(index).copied().unwrap_or_default(),
                scale: [1.0; 3],
            });
        }
        let triangles = sweep.triangles(self.still, &Vector3::zeros());
        let carriers: Vec<usize> = (0..triangles.positions.len()).map(|corner| sweep.ring_of(corner)).collect();
        let colors = carriers.iter().map_while(|ring| colors.get(*ring).copied()).collect();
        self.skin(Skin { part, first, still, triangles, carriers, colors });
    }

    /// The skin of a bushing.
    pub(super) fn mount(&mut self, part: &Part, mount: &Mount) {
        let (first, still) = (self.nodes.len(), mount.poses(self.still));
        for side in 0..2 {
            self.moving(&format!("{} side {side}", part.name), None, |poses| Placement {
                pose: mount.poses(poses)[side],
                scale: [1.0; 3],
            });
        }
        let triangles = mount.triangles(self.still, &Vector3::zeros());
        let (carriers, colors) = (mount.carriers.clone(), mount.tints.clone());
        self.skin(Skin { part, first, still: &still, triangles, carriers, colors });
    }

    fn skin(&mut self, skin: Skin<'_>) {
        let Skin { part, first, still, triangles, carriers, colors } = skin;
        let joints: Vec<usize> = (first..first + still.len()).collect();
        let inverse = still.iter().flat_map(|pose| pose.inverse().to_homogeneous().cast::<f32>().as_slice().to_vec());
        let inverse = self.bytes.matrices(&inverse.collect::<Vec<_>>());
        let bones: Vec<u16> = carriers.iter().flat_map(|carrier| [*carrier as u16, 0, 0, 0]).collect();
        let weights: Vec<f32> = carriers.iter().flat_map(|_| [1.0, 0.0, 0.0, 0.0]).collect();
        let mut attributes = json!({
            "POSITION": self.bytes.floats(Purpose::Vertices, triangles.positions.as_flattened(), 3, true),
            "NORMAL": self.bytes.floats(Purpose::Vertices, triangles.normals.as_flattened(), 3, false),
            "JOINTS_0": self.bytes.bones(&bones),
            "WEIGHTS_0": self.bytes.floats(Purpose::Weights, &weights, 4, false),
        });
        let mut part = part.clone();
        if colors.len() == triangles.positions.len() {
            let tints: Vec<f32> = colors.iter().flatten().map(|part| linear(*part) as f32).collect();
            attributes["COLOR_0"] = self.bytes.floats(Purpose::Vertices, &tints, 3, false).into();
            // The colours of the corners are multiplied with that of the material.
            part.color = [1.0; 4];
        }
        let indices = self.bytes.corners(triangles.corners.as_flattened());
        let material = number_of(&mut self.materials, &mut self.numbers, material(&part));
        let mesh = json!({ "primitives": [{ "attributes": attributes, "indices": indices, "material": material }] });
        let mesh = number_of(&mut self.meshes, &mut self.numbers, mesh);
        self.skins.push(json!({ "joints": joints, "inverseBindMatrices": inverse }));
        // A root of its own: what is above a skin does not move it, its joints do.
        let mut node = Map::new();
        node.insert("name".into(), json!(part.name));
        node.insert("mesh".into(), json!(mesh));
        node.insert("skin".into(), json!(self.skins.len() - 1));
        self.nodes.push(node);
        self.roots.push(self.nodes.len() - 1);
    }
}
