//! What a picture of a recording needs to know besides the samples. Written into the recording, so that a viewer needs
//! nothing else.

use super::beam::BeamPicture;
#[cfg(feature = "record")]
use crate::budget;
#[cfg(feature = "record")]
use std::collections::HashSet;

/// Ends of the names of a wrench's numbers, inertial axes.
pub(crate) const WRENCH: [(&str, &str); 6] = [
    ("force.x", "N"),
    ("force.y", "N"),
    ("force.z", "N"),
    ("moment.x", "N m"),
    ("moment.y", "N m"),
    ("moment.z", "N m"),
];

/// The still part of a recording: names, shapes, lines, channels.
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Scene {
    /// Title of the scenario.
    pub title: String,
    /// Every named body, in the order of the samples' poses.
    pub bodies: Vec<BodyPicture>,
    /// Springs, bushings, ropes and rigid rods: drawn as lines through their points.
    pub lines: Vec<LinePicture>,
    /// Beams and cables.
    #[cfg_attr(feature = "record", serde(default))]
    pub beams: Vec<BeamPicture>,
    /// Constant loads: drawn as arrows.
    #[cfg_attr(feature = "record", serde(default))]
    pub loads: Vec<LoadPicture>,
    /// Names of the hinge coordinates, in the order of `Sample::positions`.
    pub positions: Vec<Channel>,
    /// Names of the hinge velocities, in the order of `Sample::velocities` and `Sample::accelerations`.
    pub velocities: Vec<Channel>,
    /// Names of what drives, motors, gears, loops, ropes and curves push with, in the order of `Sample::couplings`; empty where there are
    /// none, and where that is not recorded.
    #[cfg_attr(feature = "record", serde(default))]
    pub couplings: Vec<Channel>,
    /// Names of the outputs' numbers, in the order of `Sample::outputs`, each as it is: `camber`, `tip[2]`, without a body.
    #[cfg_attr(feature = "record", serde(default))]
    pub outputs: Vec<Channel>,
    /// Loops whose reactions are not unique: recorded are the smallest of those that balance.
    #[cfg_attr(feature = "record", serde(default))]
    pub not_unique: Vec<String>,
    /// Whether there are stops that may be hit, or events of the scenario.
    #[cfg_attr(feature = "record", serde(default))]
    pub watched: bool,
}

/// A body as it is drawn.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct BodyPicture {
    /// Name.
    pub name: String,
    /// Index of the parent in `Scene::bodies`, `None` for the ground.
    pub parent: Option<usize>,
    /// Mass (kg) and centre of mass, body axes (m).
    pub mass: f64,
    /// Centre of mass, body axes (m).
    pub center: [f64; 3],
    /// Inertia about the centre of mass, body axes: xx, yy, zz, xy, xz, yz (kg m²).
    pub inertia: [f64; 6],
    /// Named points, body axes (m).
    pub markers: Vec<(String, [f64; 3])>,
    /// Solids; empty where the scenario gives none and a stand-in is drawn.
    pub shapes: Vec<ShapePicture>,
    /// Hinge kind and its axes in the **parent's** axes (ground: inertial axes), at `hinge_at` of the parent.
    pub hinge: String,
    /// Hinge axes, parent's axes.
    pub hinge_axes: Vec<[f64; 3]>,
    /// Hinge point, parent's axes (m).
    pub hinge_at: [f64; 3],
}

/// A solid as it is drawn.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct ShapePicture {
    /// `box`, `sphere`, `cylinder`, `capsule`, `mesh`, or `plane`: a thin box whose upper face is a part of it.
    pub kind: String,
    /// Edge lengths (box, plane); radius; radius and length; scale.
    pub size: Vec<f64>,
    /// Mesh file.
    pub file: Option<String>,
    /// Position in body axes (m).
    pub position: [f64; 3],
    /// Orientation `body_from_shape`, w, x, y, z.
    pub quaternion: [f64; 4],
    /// Red, green, blue, opacity.
    pub color: Option<[f64; 4]>,
}

/// A spring, bushing, rope or rigid rod as it is drawn.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct LinePicture {
    /// Name.
    pub name: String,
    /// The points that it goes through, two or more: body index (`None`: ground) and point in its axes.
    pub ends: Vec<(Option<usize>, [f64; 3])>,
    /// Of a spring its stiffness (N/m) and free length (m): what it pulls with follows from where its ends are.
    #[cfg_attr(feature = "record", serde(default))]
    pub spring: Option<[f64; 2]>,
    /// Whether it pulls only, as a rope, and is slack otherwise.
    #[cfg_attr(feature = "record", serde(default))]
    pub pulls_only: bool,
}

/// A constant load as it is drawn.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct LoadPicture {
    /// Name.
    pub name: String,
    /// Index of the body it acts on.
    pub body: usize,
    /// Where, body axes (m).
    pub at: [f64; 3],
    /// Force (N).
    pub force: [f64; 3],
    /// Torque (N m).
    pub torque: [f64; 3],
    /// Whether both are in body axes and turn with the body; else they are in inertial axes.
    pub turns: bool,
}

/// A plotted number.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Channel {
    /// Body whose hinge it belongs to; drive, motor, gear or loop.
    pub body: String,
    /// Name of the coordinate within the hinge: `angle`, `x`, `qw`; of what is pushed: `torque`, `force.x`, `gap`.
    pub name: String,
    /// SI unit.
    pub unit: String,
}

/// A scene from its JSON text, as far as other numbers follow from its own: indices lead to bodies, names are unique, and
/// no sample of it is larger than its bodies can make it.
#[cfg(feature = "record")]
pub(super) fn parse(json: &str) -> Result<Scene, String> {
    let scene: Scene = serde_json::from_str(json).map_err(|error| error.to_string())?;
    let bodies = scene.bodies.len();
    let most = [
        ("bodies", bodies, budget::BODIES),
        ("hinge coordinates", scene.positions.len(), budget::COORDINATES * bodies),
        ("hinge velocities", scene.velocities.len(), budget::COORDINATES * bodies),
        ("couplings", scene.couplings.len(), budget::BODIES),
        ("outputs", scene.outputs.len(), budget::BODIES),
        ("lines", scene.lines.len(), budget::BODIES),
        ("loads", scene.loads.len(), budget::BODIES),
    ];
    if let Some((what, found, most)) = most.into_iter().find(|(_, found, most)| found > most) {
        return Err(format!("{found} {what}, where there can be {most} at most"));
    }
    let parents = scene.bodies.iter().filter_map(|body| body.parent);
    let ends = scene.lines.iter().flat_map(|line| &line.ends).filter_map(|(body, _)| *body);
    let loads = scene.loads.iter().map(|load| load.body);
    if let Some(index) = parents.chain(ends).chain(loads).find(|index| *index >= bodies) {
        return Err(format!("body {index} of {bodies}"));
    }
    if let Some(fault) = super::beam::fault(&scene.beams, bodies) {
        return Err(fault);
    }
    let mut names = HashSet::new();
    if let Some(twice) = scene.bodies.iter().find(|body| !names.insert(body.name.as_str())) {
        return Err(format!("two bodies are called `{}`", twice.name));
    }
    for channels in [&scene.positions, &scene.velocities, &scene.outputs] {
        let mut names = HashSet::new();
        let key = |channel: &'_ Channel| (channel.body.clone(), channel.name.clone());
        if let Some(twice) = channels.iter().find(|channel| !names.insert(key(channel))) {
            return Err(format!("two channels are called `{}.{}`", twice.body, twice.name));
        }
    }
    Ok(scene)
}
