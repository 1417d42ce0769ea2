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
    /// Springs, dampers, ropes and rigid rods: drawn as lines through their points.
    pub lines: Vec<LinePicture>,
    /// Bushings: drawn as blocks between their frames. Old versions have them among the lines.
    #[cfg_attr(feature = "record", serde(default))]
    pub bushings: Vec<BushingPicture>,
    /// Beams and cables.
    #[cfg_attr(feature = "record", serde(default))]
    pub beams: Vec<BeamPicture>,
    /// Curves that bodies are guided along.
    #[cfg_attr(feature = "record", serde(default))]
    pub curves: Vec<CurvePicture>,
    /// Loads: drawn as arrows.
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
    /// How large it is; `None` in recordings of old versions.
    #[cfg_attr(feature = "record", serde(default))]
    pub extent: Option<Extent>,
}

/// How large a scene is: what is said of it first, and what round-off is measured by.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct Extent {
    /// Bodies that a description names; those within beams and modal bodies are not among them.
    pub bodies: usize,
    /// Degrees of freedom that loops, drives and gears leave.
    pub freedoms: usize,
    /// A length that is typical of it (m).
    pub length: f64,
    /// Its weight (N), or the moment of that about its length if it is more than a metre (N m).
    pub weight: f64,
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
    /// Hinge axes as they stand in the body's own axes while all coordinates are zero.
    #[cfg_attr(feature = "record", serde(default))]
    pub own_axes: Vec<[f64; 3]>,
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

/// A spring, damper, rope or rigid rod as it is drawn.
#[derive(Debug, Clone, PartialEq, Default)]
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
    /// Whether it goes on beyond its last point, as a rope over a drum: nothing holds it there.
    #[cfg_attr(feature = "record", serde(default))]
    pub goes_on: bool,
    /// Of a spring of which no stiffness is known its free length (m).
    #[cfg_attr(feature = "record", serde(default))]
    pub coil: Option<f64>,
    /// Whether it is a damper without a spring.
    #[cfg_attr(feature = "record", serde(default))]
    pub is_damper: bool,
}

/// A bushing as it is drawn.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct BushingPicture {
    /// Name.
    pub name: String,
    /// The points in which its frames have their origins: body index (`None`: ground) and point in its axes. Relaxed they coincide.
    pub ends: [(Option<usize>, [f64; 3]); 2],
    /// Orientations `body_from_frame` of the frames, w, x, y, z.
    pub frames: [[f64; 4]; 2],
    /// Along the axes of the frames (N/m).
    pub stiffness: [f64; 3],
}

/// A curve that a body is guided along.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct CurvePicture {
    /// The body that is guided.
    pub name: String,
    /// The body that has the curve (`None`: the ground).
    pub body: Option<usize>,
    /// Two or more points, straight between each other, in its axes (m).
    pub points: Vec<[f64; 3]>,
}

/// A load as it is drawn.
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
    /// What scales both over time; `None` for what is always the same.
    #[cfg_attr(feature = "record", serde(default))]
    pub over_time: Option<FactorPicture>,
}

/// A factor over time: straight from point to point, constant before the first and after the last. At a time given twice it jumps; there
/// the second counts.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "record", derive(serde::Serialize, serde::Deserialize))]
pub struct FactorPicture {
    /// Not decreasing (s).
    pub times: Vec<f64>,
    /// One for each time.
    pub values: Vec<f64>,
}

impl FactorPicture {
    /// At a time (s).
    pub fn at(&self, time: f64) -> f64 {
        let after = self.times.partition_point(|at| *at <= time);
        let [before, next] = [after.saturating_sub(1), after.min(self.times.len() - 1)];
        let (from, to) = (self.values[before], self.values[next]);
        let length = self.times[next] - self.times[before];
        if after > 0 && length > 0.0 {
            from + (time - self.times[before]) / length * (to - from)
        } else {
            self.values[before]
        }
    }

    /// Whether each of one time or more has a value.
    #[cfg(feature = "record")]
    fn is_whole(&self) -> bool {
        !self.times.is_empty() && self.times.len() == self.values.len()
    }
}

impl LoadPicture {
    /// What scales it at a time (s).
    pub fn factor(&self, time: f64) -> f64 {
        self.over_time.as_ref().map_or(1.0, |over_time| over_time.at(time))
    }

    /// The largest size of what scales it at any time.
    pub fn largest_factor(&self) -> f64 {
        let sizes =
            |over_time: &FactorPicture| over_time.values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        self.over_time.as_ref().map_or(1.0, sizes)
    }
}

impl Scene {
    /// The points that lines and bushings begin, turn and end at: body index (`None`: ground) and point in its axes.
    #[cfg(feature = "record")]
    pub(super) fn ends(&self) -> impl Iterator<Item = &(Option<usize>, [f64; 3])> {
        let of_lines = self.lines.iter().flat_map(|line| &line.ends);
        of_lines.chain(self.bushings.iter().flat_map(|bushing| &bushing.ends))
    }

    /// Loads as they are at t = 0 at all times: of poses in place of a motion.
    #[cfg(feature = "record")]
    pub(super) fn hold_loads(&mut self) {
        for load in &mut self.loads {
            let factor = load.factor(0.0);
            load.over_time = None;
            load.force = load.force.map(|x| factor * x);
            load.torque = load.torque.map(|x| factor * x);
        }
    }

    /// The size of its forces and moments: its weight, or the moment of that, or its largest load (N, N m); zero of scenes without either,
    /// and of recordings that do not say how large they are.
    #[cfg(feature = "record")]
    pub fn force_size(&self) -> f64 {
        let [force, torque] = self.largest_loads();
        self.extent.map_or(0.0, |extent| extent.weight.max(force * extent.length.max(1.0)).max(torque))
    }

    /// The largest force and torque of all loads at any time (N, N m).
    #[cfg(feature = "record")]
    pub(super) fn largest_loads(&self) -> [f64; 2] {
        let norm = |of: [f64; 3]| of.iter().map(|x| x * x).sum::<f64>().sqrt();
        let largest = |of: fn(&LoadPicture) -> [f64; 3]| {
            self.loads.iter().map(|load| load.largest_factor() * norm(of(load))).fold(0.0, f64::max)
        };
        [largest(|load| load.force), largest(|load| load.torque)]
    }
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
        ("bushings", scene.bushings.len(), budget::BODIES),
        ("loads", scene.loads.len(), budget::BODIES),
        ("curves", scene.curves.len(), budget::BODIES),
    ];
    if let Some((what, found, most)) = most.into_iter().find(|(_, found, most)| found > most) {
        return Err(format!("{found} {what}, where there can be {most} at most"));
    }
    let parents = scene.bodies.iter().filter_map(|body| body.parent);
    let ends = scene.ends().filter_map(|(body, _)| *body);
    let loads = scene.loads.iter().map(|load| load.body);
    let curves = scene.curves.iter().filter_map(|curve| curve.body);
    if let Some(index) = parents.chain(ends).chain(loads).chain(curves).find(|index| *index >= bodies) {
        return Err(format!("body {index} of {bodies}"));
    }
    if let Some(fault) = super::beam::fault(&scene.beams, bodies) {
        return Err(fault);
    }
    let is_broken = |load: &&LoadPicture| load.over_time.as_ref().is_some_and(|over_time| !over_time.is_whole());
    if let Some(load) = scene.loads.iter().find(is_broken) {
        return Err(format!("the load `{}` has not a value for each of its times", load.name));
    }
    if let Some(curve) = scene.curves.iter().find(|curve| curve.points.len() < 2) {
        return Err(format!("the curve of `{}` has {} points", curve.name, curve.points.len()));
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

#[cfg(test)]
mod tests {
    use super::FactorPicture;

    #[test]
    fn a_factor_is_straight_between_its_times_and_jumps_at_one_given_twice() {
        let factor = FactorPicture { times: vec![1.0, 3.0, 3.0, 5.0], values: vec![2.0, 4.0, -1.0, 0.0] };
        let at = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 9.0].map(|time| factor.at(time));
        assert_eq!(at, [2.0, 2.0, 3.0, -1.0, -0.5, 0.0, 0.0]);
        assert_eq!(FactorPicture { times: vec![0.5], values: vec![7.0] }.at(0.0), 7.0);
    }
}
