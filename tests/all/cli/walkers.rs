//! Robots out of URDF files that stand on their feet: forces, polygon and tilt against what statics of one rigid body says.

use super::Bench;
use crate::common::Random;
use nalgebra::{UnitQuaternion, Vector3};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

const G: f64 = 9.80665;

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// A trunk on legs that turn in gears too stiff to give way, with balls for feet on the ground.
struct Walker {
    urdf: String,
    feet: Vec<[f64; 2]>,
    /// Of the trunk (m): all places of the file count from there.
    height: f64,
    center: Vector3<f64>,
    mass: f64,
}

fn inertial(mass: f64, at: Vector3<f64>) -> String {
    let moment = 0.02 * mass;
    format!(
        "<inertial><origin xyz=\"{:?} {:?} {:?}\"/><mass value=\"{mass:?}\"/><inertia ixx=\"{moment:?}\" iyy=\"{moment:?}\" \
         izz=\"{moment:?}\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>",
        at.x, at.y, at.z
    )
}

fn walker(random: &mut Random) -> Walker {
    let legs = 3 + random.below(4);
    let height = random.between(0.3, 0.6);
    let trunk = Vector3::new(random.between(-0.6, 0.6), random.between(-0.6, 0.6), height);
    let mass = random.between(2.0, 8.0);
    let (mut total, mut moment) = (mass, trunk * mass);
    let base = Vector3::z() * height;
    let mut urdf = format!("<robot name=\"walker\"><link name=\"trunk\">{}</link>", inertial(mass, trunk - base));
    let mut feet = Vec::new();
    for leg in 0..legs {
        let angle = (leg as f64 + random.between(-0.3, 0.3)) * std::f64::consts::TAU / legs as f64;
        let (out, radius) = (random.between(0.2, 0.5), random.between(0.02, 0.06));
        let foot = Vector3::new(out * angle.cos(), out * angle.sin(), radius);
        let hip = Vector3::new(0.4 * foot.x, 0.4 * foot.y, height - random.between(0.0, 0.1));
        let turn: UnitQuaternion<f64> = random.turn();
        let (roll, pitch, yaw) = turn.euler_angles();
        // The turn as the file says it.
        let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
        let (axis, weight) = (random.unit(), random.between(0.2, 1.0));
        let middle = turn.inverse_transform_vector(&(0.5 * (foot - hip)));
        let end = 2.0 * middle;
        let at = hip - base;
        let _ = write!(
            urdf,
            "<link name=\"leg{leg}\">{}<collision><origin xyz=\"{:?} {:?} {:?}\"/><geometry><sphere radius=\"{radius:?}\"/></geometry>\
             </collision></link><joint name=\"hip{leg}\" type=\"continuous\"><parent link=\"trunk\"/><child link=\"leg{leg}\"/>\
             <origin xyz=\"{:?} {:?} {:?}\" rpy=\"{roll:?} {pitch:?} {yaw:?}\"/><axis xyz=\"{:?} {:?} {:?}\"/>\
             <dynamics friction=\"1000\"/></joint>",
            inertial(weight, middle),
            end.x,
            end.y,
            end.z,
            at.x,
            at.y,
            at.z,
            axis.x,
            axis.y,
            axis.z
        );
        total += weight;
        moment += 0.5 * (hip + foot) * weight;
        feet.push([foot.x, foot.y]);
    }
    Walker { urdf: urdf + "</robot>", feet, height, center: moment / total, mass: total }
}

/// How far it is from a point to the border of the feet's polygon, towards a direction; negative if the point is outside of it
/// (m). By the sides of all pairs of feet that have all others on one hand.
fn to_border(feet: &[[f64; 2]], from: [f64; 2], towards: [f64; 2]) -> f64 {
    let mut nearest = f64::INFINITY;
    for (i, a) in feet.iter().enumerate() {
        for (j, b) in feet.iter().enumerate().filter(|(j, _)| *j != i) {
            let normal = [b[1] - a[1], a[0] - b[0]];
            let beyond = |p: &[f64; 2]| normal[0] * (p[0] - a[0]) + normal[1] * (p[1] - a[1]);
            let side = feet.iter().enumerate().all(|(k, foot)| k == i || k == j || beyond(foot) < 0.0);
            if !side {
                continue;
            }
            if beyond(&from) >= 0.0 {
                return -beyond(&from) / normal[0].hypot(normal[1]);
            }
            let along = normal[0] * towards[0] + normal[1] * towards[1];
            if along > 0.0 {
                nearest = nearest.min(-beyond(&from) / along);
            }
        }
    }
    nearest
}

fn scene(friction: f64, height: f64) -> String {
    format!(
        "[model]\nfile = \"walker.urdf\"\nbase = \"free\"\nat = [0, 0, {height:?}]\ncontact = true\n[statics]\nmargin = [\"tilt\"]\n\
         [[body]]\nname = \"floor\"\nshape = {{ plane = [0, 0, 1] }}\nhinge = {{ type = \"fixed\" }}\n\
         [[contact]]\nbetween = [\"*\", \"floor\"]\nfriction = {friction:?}\n"
    )
}

#[test]
fn robots_stand_on_the_polygon_of_their_feet() {
    let bench = Bench::new();
    let mut random = Random::new(0x0f00_7ed5);
    let (mut standing, mut falling) = (0, 0);
    for _ in 0..30 {
        let walker = walker(&mut random);
        let friction = random.between(0.4, 1.2);
        bench.write("walker.urdf", &walker.urdf);
        bench.write("scene.toml", scene(friction, walker.height));
        let from = [walker.center.x, walker.center.y];
        let inside = to_border(&walker.feet, from, [1.0, 0.0]);
        let stands = inside > 0.0;
        let answer = bench.call(&["statics", "scene.toml", "--json"]).code(i32::from(!stands)).json();
        let found = &answer["standing"];
        assert_eq!(found["verdict"], if stands { "stands" } else { "falls" }, "{inside}: {found}");
        assert_eq!(found["contacts"], walker.feet.len(), "{found}");
        if !stands {
            falling += 1;
            continue;
        }
        standing += 1;
        let weight = walker.mass * G;
        let (mut sum, mut moment) = (Vector3::zeros(), Vector3::zeros());
        for one in found["forces"].as_array().unwrap() {
            let vector = |key: &str| Vector3::from_fn(|i, _| number(&one[key][i]));
            let sign = if one["between"][0] == "floor" { 1.0 } else { -1.0 };
            sum += sign * vector("force");
            moment += vector("point").cross(&(sign * vector("force")));
        }
        let weighs = walker.center.cross(&(-Vector3::z() * weight));
        assert!((sum - Vector3::z() * weight).norm() < 1e-8 * weight, "{sum}");
        assert!((moment + weighs).norm() < 1e-8 * weight, "{moment} {weighs}");
        for (name, towards) in [("+x", [1.0, 0.0]), ("-x", [-1.0, 0.0]), ("+y", [0.0, 1.0]), ("-y", [0.0, -1.0])] {
            // It tips over a side, or slides: forces in proportion to what presses hold it until then.
            let expected = (to_border(&walker.feet, from, towards) / walker.center.z).min(friction);
            let tilt = number(&found["margins"]["tilt"][name]);
            assert!((tilt - expected).abs() < 1e-6 * (1.0 + expected), "{name}: {tilt} {expected}");
        }
    }
    assert!(standing >= 8 && falling >= 4, "{standing} stand, {falling} fall");
}

#[test]
fn the_quadruped_stands_and_a_run_from_there_stays() {
    let bench = Bench::new();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenarios/standing/quadruped.toml");
    let file = file.to_str().expect("text");
    let answer = bench.call(&["statics", file, "--json"]).code(0).json();
    let standing = &answer["standing"];
    assert_eq!((&standing["verdict"], &standing["contacts"]), (&"stands".into(), &4.into()), "{standing}");
    let up: f64 = standing["forces"].as_array().unwrap().iter().map(|one| number(&one["force"][2]).abs()).sum();
    assert!((up - 12.2 * G).abs() < 1e-8 * up, "{up}");
    // Feet 0.13 m to either side; its centre of mass is as high as parts and angles say.
    let (thigh, shank, foot) = (0.08 * 0.6_f64.cos(), 0.3 * 0.6_f64.cos(), 0.4 * 0.6_f64.cos());
    let below = 4.0 * (0.8 * thigh + 0.2 * shank + 0.05 * foot) / 12.2;
    let expected = 0.13 / (foot + 0.02 - below);
    let tilt = number(&standing["margins"]["tilt"]["+y"]);
    assert!((tilt - expected).abs() < 1e-7, "{tilt} {expected}");
    let rest = bench.call(&["rest", file, "--json"]).code(0).json();
    assert_eq!((&rest["rested"], &rest["max_displacement"]["value"]), (&true.into(), &0.0.into()), "{rest}");
}

/// Unitree's A1 with brakes in its joints, as other people's URDF has it: boxes, cylinders, and balls for feet.
#[test]
#[ignore = "needs Python with example-robot-data (tests/python/requirements.txt)"]
fn the_a1_stands_on_its_feet() {
    let find = "import pathlib, sys; print(next(f for p in map(pathlib.Path, sys.path) for f in \
                p.glob('cmeel.prefix/share/example-robot-data/robots/a1_description/urdf/a1.urdf')))";
    let found = std::process::Command::new("python3").args(["-c", find]).output().expect("run");
    let file = String::from_utf8(found.stdout).expect("text");
    let mut text = format!(
        "[model]\nfile = {:?}\nbase = \"free\"\nat = [0, 0, {:?}]\ncontact = true\nmassless = \"weld\"\n",
        file.trim(),
        0.4 * 0.9_f64.cos() + 0.02
    );
    let (mut brakes, mut positions) = ("[model.hinges]\n".to_owned(), "[model.positions]\n".to_owned());
    for leg in ["FR", "FL", "RR", "RL"] {
        for (joint, position) in [("hip", 0.0), ("thigh", 0.9), ("calf", -1.8)] {
            let _ = writeln!(brakes, "{leg}_{joint}_joint = {{ friction = 30.0 }}");
            let _ = writeln!(positions, "{leg}_{joint}_joint = {position:?}");
        }
    }
    text += &brakes;
    text += &positions;
    text += "[statics]\nmargin = [\"tilt\"]\n[[body]]\nname = \"floor\"\nshape = { plane = [0, 0, 1] }\nhinge = { type = \"fixed\" }\n\
             [[contact]]\nbetween = [\"*\", \"floor\"]\nfriction = 0.9\n";
    let bench = Bench::new();
    bench.write("a1.toml", &text);
    let model = bench.call(&["inspect", "a1.toml", "--json"]).code(0).json();
    let center = Vector3::from_fn(|i, _| number(&model["center_of_mass"][i]));
    let answer = bench.call(&["statics", "a1.toml", "--json"]).code(0).json();
    let standing = &answer["standing"];
    assert_eq!((&standing["verdict"], &standing["contacts"]), (&"stands".into(), &4.into()), "{standing}");
    let up: f64 = standing["forces"].as_array().unwrap().iter().map(|one| number(&one["force"][2]).abs()).sum();
    assert!((up - number(&model["total_mass"]) * G).abs() < 1e-8 * up, "{up}");
    // Hips at ±0.1805 m along and ±0.047 m across, thighs 0.0838 m further out; the feet are under the thighs.
    let feet = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]].map(|[x, y]| [0.1805 * x, (0.047 + 0.0838) * y]);
    for (name, towards) in [("+x", [1.0, 0.0]), ("-x", [-1.0, 0.0]), ("+y", [0.0, 1.0]), ("-y", [0.0, -1.0])] {
        let expected = to_border(&feet, [center.x, center.y], towards) / center.z;
        let tilt = number(&standing["margins"]["tilt"][name]);
        assert!((tilt - expected).abs() < 1e-6, "{name}: {tilt} {expected}");
    }
    let rest = bench.call(&["rest", "a1.toml", "--json"]).code(0).json();
    assert_eq!((&rest["rested"], &rest["max_displacement"]["value"]), (&true.into(), &0.0.into()), "{rest}");
}
