//! Motions to record: prescribed, not simulated.

use nalgebra::{Translation3, UnitQuaternion, Vector3};
use std::path::{Path, PathBuf};
use stillpoint::record::scene::{BodyPicture, BushingPicture, Channel, LinePicture, LoadPicture, ShapePicture};
use stillpoint::record::{Energy, Opening, Outcome, OwnedSample, Recorder, RecordingFile, Scene};
use stillpoint::spatial::{Pose, Wrench};

pub(crate) const SCENARIO: &str = "title = \"Two links and a box\"\n# ümlaut\n";
pub(crate) const STATICS: &str = r#"{"converged":true,"residual_force":1.2345678901234567e-13}"#;
pub(crate) const OUTCOME: &str = r#"{"end_time":2.0}"#;

/// Samples per second.
const RATE: f64 = 100.0;

/// A scene and how it moves.
pub(crate) struct Motion {
    pub(crate) scene: Scene,
    pose: fn(usize, f64) -> Pose,
}

impl Motion {
    /// A double pendulum with shapes, and a box without any that hangs on two springs.
    pub(crate) fn double_link() -> Self {
        let link = |name: &str, parent, at, color: Option<[f64; 4]>| BodyPicture {
            shapes: vec![ShapePicture {
                kind: "box".into(),
                size: vec![0.05, 0.08, 1.0],
                file: None,
                position: [0.0, 0.0, -0.5],
                quaternion: [1.0, 0.0, 0.0, 0.0],
                color,
            }],
            ..body(name, parent, at, "revolute", &[[0.0, 1.0, 0.0]])
        };
        let floating = BodyPicture {
            inertia: [0.02, 0.03, 0.025, 0.0, 0.0, 0.0],
            markers: Vec::new(),
            center: [0.0; 3],
            ..body("box", None, [0.0; 3], "free", &[])
        };
        let rod = body("rod[0]", Some(1), [0.0, 0.0, -1.0], "spherical", &[]);
        let line = |name: &str, x: f64, from: [f64; 3]| LinePicture {
            name: name.into(),
            ends: vec![(None, [x, 0.0, 2.2]), (Some(2), from)],
            spring: Some([100.0, 0.3]),
            ..LinePicture::default()
        };
        let load = |name: &str, turns| LoadPicture {
            name: name.into(),
            body: 1,
            at: [0.0, 0.0, -1.0],
            force: [5.0, 0.0, 0.0],
            torque: [0.0, 1.0, 0.0],
            turns,
            over_time: None,
        };
        let scene = Scene {
            title: "Two links and a box".into(),
            bodies: vec![
                link("upper", None, [0.0, 0.0, 2.0], None),
                link("lower", Some(0), [0.0, 0.0, -1.0], None),
                floating,
                rod,
            ],
            lines: vec![line("left spring", 1.0, [-0.2, 0.0, 0.15]), line("right spring", 2.0, [0.2, 0.0, 0.15])],
            bushings: vec![BushingPicture {
                name: "mount".into(),
                ends: [(None, [1.5, 0.0, 1.0]), (Some(2), [0.0, 0.0, -0.15])],
                frames: [[1.0, 0.0, 0.0, 0.0]; 2],
                stiffness: [1.0, 1.0, 2.0],
            }],
            beams: Vec::new(),
            loads: vec![load("wind", false), load("thrust", true)],
            positions: channels(&[("upper", "angle", "rad"), ("lower", "angle", "rad")])
                .chain(channels(&[("box", "x", "m"), ("box", "y", "m"), ("box", "z", "m")]))
                .chain(["w", "x", "y", "z"].into_iter().flat_map(|part| {
                    channels(&[("rod[0]", part, "1")]).map(move |c| Channel { name: format!("quaternion {part}"), ..c })
                }))
                .collect(),
            velocities: channels(&[("upper", "rate", "rad/s"), ("lower", "rate", "rad/s")])
                .chain(channels(&[("box", "x", "m/s"), ("box", "y", "m/s"), ("box", "z", "m/s")]))
                .chain(channels(&[("rod[0]", "x", "rad/s"), ("rod[0]", "y", "rad/s"), ("rod[0]", "z", "rad/s")]))
                .collect(),
            couplings: channels(&[("time", "", "N m"), ("ring", "force.x", "N"), ("ring", "gap", "m")]).collect(),
            outputs: ["time", "camber", "tip[0]", "tip[1]"]
                .map(|name| Channel { body: String::new(), name: name.into(), unit: "m".into() })
                .into(),
            not_unique: vec!["ring".into()],
            watched: true,
            ..Scene::default()
        };
        Self { scene, pose: double_link_pose }
    }

    /// Many links in a row.
    pub(crate) fn chain(count: usize) -> Self {
        let parent = |index: usize| index.checked_sub(1);
        let name = |index: usize| format!("link[{index}]");
        let bodies =
            (0..count).map(|k| body(&name(k), parent(k), [0.1, 0.0, 0.0], "revolute", &[[0.0, 1.0, 0.0]])).collect();
        let channel = |kind: &str, unit: &str, k| Channel { body: name(k), name: kind.into(), unit: unit.into() };
        let scene = Scene {
            title: "Chain".into(),
            bodies,
            lines: Vec::new(),
            loads: Vec::new(),
            positions: (0..count).map(|k| channel("angle", "rad", k)).collect(),
            velocities: (0..count).map(|k| channel("rate", "rad/s", k)).collect(),
            ..Scene::default()
        };
        Self { scene, pose: |index, time| Pose::translation(0.1 * index as f64, 0.0, (time + index as f64).sin()) }
    }

    pub(crate) fn opening(&self) -> Opening<'_> {
        Opening { scene: &self.scene, scenario: SCENARIO, statics: Some(STATICS) }
    }

    pub(crate) fn times(end: f64) -> impl Iterator<Item = f64> {
        (0..=(end * RATE).round() as usize).map(|k| k as f64 / RATE)
    }

    /// Numbers that fill every bit.
    pub(crate) fn at(&self, time: f64) -> OwnedSample {
        let wave = |count: usize, phase: f64| (0..count).map(|k| (time * 3.0 + k as f64 + phase).sin()).collect();
        let positions: Vec<f64> = wave(self.scene.positions.len(), 0.0);
        let velocities: Vec<f64> = wave(self.scene.velocities.len(), 1.0);
        let accelerations: Vec<f64> = wave(self.scene.velocities.len(), 2.0);
        let poses = (0..self.scene.bodies.len()).map(|k| (self.pose)(k, time)).collect();
        let reaction = |k: usize| Wrench {
            force: Vector3::new(time / 3.0, -0.0, k as f64 / 7.0),
            moment: Vector3::new(time.cos(), 1e-300, -1e300),
        };
        let potential = 4.0 * (1.0 - (2.0 * time).sin());
        OwnedSample {
            time,
            positions,
            velocities,
            accelerations,
            bodies: poses,
            reactions: (0..self.scene.bodies.len()).map(reaction).collect(),
            couplings: wave(self.scene.couplings.len(), 3.0),
            outputs: wave(self.scene.outputs.len(), 4.0),
            energy: Energy {
                kinetic: 4.0 - potential * (-0.1 * time).exp(),
                potential,
                work: 0.0,
                dissipated: 4.0 * (1.0 - (-0.1 * time).exp()),
                error: 1e-9 * (7.0 * time).sin(),
            },
        }
    }
}

/// Records `seconds` of the motion and finishes. Gives back where.
pub(crate) fn record(path: &Path, motion: &Motion, seconds: f64) -> PathBuf {
    let mut writer = RecordingFile::create(path).and_then(|file| file.begin(&motion.opening())).expect("open");
    for time in Motion::times(seconds) {
        writer.sample(&motion.at(time).borrow()).expect("written");
    }
    writer.finish(&Outcome { summary: OUTCOME.into() }).expect("finished");
    writer.path().to_owned()
}

fn body(name: &str, parent: Option<usize>, at: [f64; 3], hinge: &str, axes: &[[f64; 3]]) -> BodyPicture {
    BodyPicture {
        name: name.into(),
        parent,
        mass: 1.0,
        center: [0.0, 0.0, -0.5],
        inertia: [0.1, 0.1, 0.002, 0.0, 0.0, 0.0],
        markers: vec![("tip".into(), [0.0, 0.0, -0.5])],
        shapes: Vec::new(),
        hinge: hinge.into(),
        hinge_axes: axes.to_vec(),
        hinge_at: at,
        own_axes: Vec::new(),
    }
}

fn channels<'a>(names: &'a [(&'a str, &'a str, &'a str)]) -> impl Iterator<Item = Channel> + use<> {
    let channel =
        |&(body, name, unit): &(&str, &str, &str)| Channel { body: body.into(), name: name.into(), unit: unit.into() };
    names.iter().map(channel).collect::<Vec<_>>().into_iter()
}

fn double_link_pose(body: usize, time: f64) -> Pose {
    let turn = |angle: f64| UnitQuaternion::from_axis_angle(&Vector3::y_axis(), angle);
    let upper = Pose::from_parts(Translation3::new(0.0, 0.0, 2.0), turn(0.8 * (2.0 * time).sin()));
    let down = Translation3::new(0.0, 0.0, -1.0);
    let lower = upper * down * turn(0.6 * (3.1 * time).sin());
    match body {
        0 => upper,
        1 => lower,
        2 => {
            let sway = Translation3::new(1.5 + 0.1 * time.sin(), 0.05 * time.cos(), 1.2 + 0.3 * (4.0 * time).sin());
            Pose::from_parts(sway, turn(0.2 * (5.0 * time).sin()))
        }
        _ => lower * down * UnitQuaternion::from_scaled_axis(Vector3::new(0.5 * time.sin(), 0.0, 0.4)),
    }
}
