//! A drawing as binary glTF 2.0, with animations.
//!
//! Beams are skins: a joint per cross section; so are bushings: a joint per frame. Colours of vertices cannot be animated in glTF: a beam has in every section those of the
//! most that it bears in all frames.
//!
//! One node per body with its parts below it, one per line; the scene's root turns z up into glTF's y up. What moves is keyed at every frame,
//! linear between them, and what stays is not keyed. Numbers are single precision: a file for looking, as all of glTF is.

mod bytes;
mod skin;

use super::drawing::{Drawing, Part, Placement, Triangles};
use crate::spatial::Pose;
use bytes::{Bytes, Purpose};
use nalgebra::UnitQuaternion;
use serde_json::{Map, Value, json};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// A motion with a name.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Clip {
    /// Name of the animation.
    pub name: String,
    /// Times of the frames (s), ascending.
    pub times: Vec<f64>,
    /// Poses of the bodies and of the cross sections of beams, one list per frame.
    pub poses: Vec<Vec<Pose>>,
    /// What the cross sections bear, one list per frame ([`Tubes::loads`](super::Tubes::loads)); none if that is not known.
    pub loads: Vec<Vec<f64>>,
}

/// Half a right angle: z up becomes y up.
const Y_UP: [f64; 4] = [-std::f64::consts::FRAC_1_SQRT_2, 0.0, 0.0, std::f64::consts::FRAC_1_SQRT_2];

/// What is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Glb {
    /// The file.
    pub bytes: Vec<u8>,
    /// How many animations it has: clips in which nothing moves are none.
    pub animations: usize,
}

/// The file. Bodies stand as in `still`; each clip in which something moves is an animation.
pub fn glb(drawing: &Drawing, title: &str, still: &[Pose], clips: &[Clip]) -> Glb {
    let mut writer = Writer { still, clips, ..Writer::default() };
    writer.nodes.push(Map::new());
    let mut bodies: BTreeMap<Option<usize>, usize> = BTreeMap::new();
    let most: Vec<f64> = writer.most();
    for part in &drawing.parts {
        if let Some((sweep, tints)) = part.swept() {
            writer.beam(drawing, part, sweep, tints, &most);
            continue;
        }
        if let Some(mount) = part.mount() {
            writer.mount(part, mount);
            continue;
        }
        let mesh = writer.mesh(part);
        match part.rigid() {
            Some((body, placement)) => {
                let parent = *bodies.entry(body).or_insert_with(|| {
                    let name = body.map_or("ground", |body| drawing.body_name(body));
                    writer.moving(name, None, |poses| Placement {
                        pose: body.and_then(|body| poses.get(body)).copied().unwrap_or_default(),
                        scale: [1.0; 3],
                    })
                });
                let node = writer.node(&part.name, parent, &placement);
                writer.nodes[node].insert("mesh".into(), json!(mesh));
            }
            None => {
                writer.moving(&part.name, Some(mesh), |poses| part.place(poses));
            }
        }
    }
    let animations = writer.animations.len();
    Glb { bytes: writer.finish(title), animations }
}

#[derive(Default)]
struct Writer<'a> {
    still: &'a [Pose],
    clips: &'a [Clip],
    bytes: Bytes,
    /// The first is the root.
    nodes: Vec<Map<String, Value>>,
    meshes: Vec<Value>,
    materials: Vec<Value>,
    skins: Vec<Value>,
    /// Further roots.
    roots: Vec<usize>,
    /// Accessors of positions, normals and corners, by the address of the triangles that the parts of the drawing share.
    known: HashMap<*const Triangles, [usize; 3]>,
    /// Numbers of meshes and materials, by their text.
    numbers: HashMap<String, usize>,
    /// Of each clip: times, channels, samplers.
    animations: BTreeMap<usize, (usize, Vec<Value>, Vec<Value>)>,
}

impl Writer<'_> {
    /// The mesh of a part; parts of one form share its numbers.
    fn mesh(&mut self, part: &Part) -> usize {
        let address = Arc::as_ptr(&part.triangles);
        let [positions, normals, corners] = match self.known.get(&address) {
            Some(accessors) => *accessors,
            None => {
                let Triangles { positions, normals, corners, .. } = &*part.triangles;
                let accessors = [
                    self.bytes.floats(Purpose::Vertices, positions.as_flattened(), 3, true),
                    self.bytes.floats(Purpose::Vertices, normals.as_flattened(), 3, false),
                    self.bytes.corners(corners.as_flattened()),
                ];
                self.known.insert(address, accessors);
                accessors
            }
        };
        let material = number_of(&mut self.materials, &mut self.numbers, material(part));
        let attributes = json!({ "POSITION": positions, "NORMAL": normals });
        let mesh = json!({ "primitives": [{ "attributes": attributes, "indices": corners, "material": material }] });
        number_of(&mut self.meshes, &mut self.numbers, mesh)
    }

    /// A node that stays where it is in its parent.
    fn node(&mut self, name: &str, parent: usize, placement: &Placement) -> usize {
        let mut node = Map::new();
        node.insert("name".into(), json!(name));
        let at = placement.pose.translation.vector;
        let turn = quaternion(&placement.pose.rotation);
        for (key, value, rest) in [
            ("translation", at.as_slice(), [0.0; 4]),
            ("rotation", &turn, [0.0, 0.0, 0.0, 1.0]),
            ("scale", &placement.scale, [1.0; 4]),
        ] {
            if value != &rest[..value.len()] {
                node.insert(key.into(), json!(value.iter().map(|x| *x as f32).collect::<Vec<_>>()));
            }
        }
        self.nodes.push(node);
        let number = self.nodes.len() - 1;
        let children = self.nodes[parent].entry("children").or_insert_with(|| json!([]));
        if let Some(children) = children.as_array_mut() {
            children.push(json!(number));
        }
        number
    }

    /// A node below the root that every clip moves.
    fn moving(&mut self, name: &str, mesh: Option<usize>, place: impl Fn(&[Pose]) -> Placement) -> usize {
        let still = place(self.still);
        let node = self.node(name, 0, &still);
        if let Some(mesh) = mesh {
            self.nodes[node].insert("mesh".into(), json!(mesh));
        }
        for (number, clip) in self.clips.iter().enumerate().filter(|(_, clip)| clip.times.len() > 1) {
            let places: Vec<Placement> = clip.poses.iter().map(|poses| place(poses)).collect();
            let moves = |of: &dyn Fn(&Placement) -> Vec<f64>| -> Option<Vec<f32>> {
                let first = of(&still);
                let same = |place: &Placement| of(place) == first;
                (!places.iter().all(same)).then(|| places.iter().flat_map(of).map(|x| x as f32).collect())
            };
            let translations = moves(&|place| place.pose.translation.vector.as_slice().to_vec());
            let rotations = moves(&|place| quaternion(&place.pose.rotation).to_vec()).map(continuous);
            let scales = moves(&|place| place.scale.to_vec());
            for (path, values, width) in
                [("translation", translations, 3), ("rotation", rotations, 4), ("scale", scales, 3)]
            {
                if let Some(values) = values {
                    self.channel(number, node, path, &values, width);
                }
            }
        }
        node
    }

    fn channel(&mut self, clip: usize, node: usize, path: &str, values: &[f32], width: usize) {
        let bytes = &mut self.bytes;
        let (times, channels, samplers) = self.animations.entry(clip).or_insert_with(|| {
            let clip = &self.clips[clip];
            let begin = clip.times[0];
            let times: Vec<f32> = clip.times.iter().map(|time| (time - begin) as f32).collect();
            (bytes.floats(Purpose::Keys, &times, 1, true), Vec::new(), Vec::new())
        });
        let output = bytes.floats(Purpose::Keys, values, width, false);
        channels.push(json!({ "sampler": samplers.len(), "target": { "node": node, "path": path } }));
        samplers.push(json!({ "input": *times, "output": output, "interpolation": "LINEAR" }));
    }

    fn finish(mut self, title: &str) -> Vec<u8> {
        self.nodes[0].insert("name".into(), json!("z up"));
        self.nodes[0].insert("rotation".into(), json!(Y_UP));
        let mut root = Map::new();
        let generator = concat!("stillpoint ", env!("CARGO_PKG_VERSION"));
        root.insert("asset".into(), json!({ "version": "2.0", "generator": generator }));
        root.insert("scene".into(), json!(0));
        let roots: Vec<usize> = std::iter::once(0).chain(self.roots).collect();
        root.insert("scenes".into(), json!([{ "name": title, "nodes": roots }]));
        root.insert("nodes".into(), json!(self.nodes));
        let animation = |(clip, (_, channels, samplers)): (&usize, &(usize, Vec<Value>, Vec<Value>))| json!({ "name": self.clips[*clip].name, "channels": channels, "samplers": samplers });
        let animations: Vec<Value> = self.animations.iter().map(animation).collect();
        // Lists without members are not allowed.
        let lists =
            [("meshes", self.meshes), ("materials", self.materials), ("skins", self.skins), ("animations", animations)];
        for (key, list) in lists {
            if !list.is_empty() {
                root.insert(key.into(), json!(list));
            }
        }
        self.bytes.finish(root)
    }
}

/// The number of an entry in its list; equal ones are listed once.
fn number_of(list: &mut Vec<Value>, numbers: &mut HashMap<String, usize>, entry: Value) -> usize {
    *numbers.entry(entry.to_string()).or_insert_with(|| {
        list.push(entry);
        list.len() - 1
    })
}

/// Colours are linear in glTF (IEC 61966-2-1).
fn linear(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    if x <= 0.04045 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) }
}

fn material(part: &Part) -> Value {
    let [r, g, b, opacity] = part.color;
    let [r, g, b] = [r, g, b].map(linear);
    let color = [r, g, b, opacity.clamp(0.0, 1.0)];
    let mut material = json!({
        "pbrMetallicRoughness": { "baseColorFactor": color, "metallicFactor": 0.0, "roughnessFactor": 0.7 }
    });
    if opacity < 1.0 {
        material["alphaMode"] = json!("BLEND");
    }
    if !part.triangles.closed && part.swept().is_none() {
        material["doubleSided"] = json!(true);
    }
    material
}

/// x, y, z, w.
fn quaternion(turn: &UnitQuaternion<f64>) -> [f64; 4] {
    [turn.i, turn.j, turn.k, turn.w]
}

/// Of the two quaternions of each turn the one that is nearer to that before.
fn continuous(mut values: Vec<f32>) -> Vec<f32> {
    for k in (4..values.len()).step_by(4) {
        let (before, here) = values.split_at_mut(k);
        let dot: f32 = before[k - 4..].iter().zip(here.iter()).map(|(a, b)| a * b).sum();
        if dot < 0.0 {
            here[..4].iter_mut().for_each(|x| *x = -*x);
        }
    }
    values
}
