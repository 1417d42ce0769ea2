//! Statics of scenes with loops, drives and gears: all methods, paths, unknown inputs.

use crate::common::build;
use crate::scenarios::{found, shipped};
use std::sync::Arc;
use stillpoint::model::{Model, Parameter};
use stillpoint::scenario;
use stillpoint::statics::path::follow;
use stillpoint::statics::{Equilibrium, Method, Settings, StabilityVerdict, Want, equilibrium, hold};

const G: f64 = 9.80665;

/// A parallelogram of equal bars, hanging from two pins: rods down, bar across.
const PARALLELOGRAM: &str = r#"
[[body]]
name = "left"
mass = 1.0
center = [0.0, 0.0, -0.25]
inertia = [0.02, 0.02, 0.001]
markers = { pin = [0.0, 0.0, -0.5] }
hinge = { type = "revolute", axis = [0.0, 1.0, 0.0], position = 0.7 }

[[body]]
name = "bar"
mass = 2.0
center = [0.4, 0.0, 0.0]
inertia = [0.001, 0.05, 0.05]
markers = { pin = [0.8, 0.0, 0.0] }
hinge = { type = "revolute", parent = "left", at = "pin", axis = [0.0, 1.0, 0.0], position = -0.7 }

[[body]]
name = "right"
mass = 1.0
center = [0.0, 0.0, -0.25]
inertia = [0.02, 0.02, 0.001]
markers = { pin = [0.0, 0.0, -0.5] }
hinge = { type = "revolute", at = [0.8, 0.0, 0.0], axis = [0.0, 1.0, 0.0], position = 0.7 }

[[loop]]
type = "revolute"
between = ["bar.pin", "right.pin"]
axis = [0.0, 1.0, 0.0]
"#;

fn by(method: Method, model: &Arc<Model>) -> Equilibrium {
    equilibrium(model, &Settings { method, want: Want::Stable, ..Settings::default() }, &model.start_position)
        .expect("statics")
}

/// Largest distance of a root marker, and largest angle between bodies.
fn apart(a: &Equilibrium, b: &Equilibrium) -> f64 {
    let pairs = a.poses.iter().zip(&b.poses);
    pairs
        .map(|(a, b)| (a.translation.vector - b.translation.vector).norm().max(a.rotation.angle_to(&b.rotation)))
        .fold(0.0, f64::max)
}

fn read(text: &str) -> Arc<Model> {
    build(&scenario::parse("scene.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}")).description)
}

fn assert_all_agree(name: &str, model: &Arc<Model>) {
    let cascade = by(Method::Auto, model);
    assert!(cascade.converged, "{name}: {:?}", cascade.notes);
    let mut system = stillpoint::dynamics::System::new(model);
    let (mut q, mut v) = (cascade.position.clone(), cascade.velocity.clone());
    let settled = system.settle(0.0, &mut q, &mut v).expect("a closed position");
    assert!(settled.gap < 1e-12, "{name}: a gap of {:e}", settled.gap);
    for method in [Method::Newton, Method::Relaxation, Method::Lagrange] {
        let found = by(method, model);
        assert!(found.converged, "{name} by {method:?}: {:?}", found.notes);
        assert_eq!(found.method, method.name());
        let distance = apart(&cascade, &found);
        // 1e-10 of the forces over stiffnesses of some hundredths of them per unit.
        assert!(distance < 1e-8, "{name} by {method:?}: {distance:e} apart");
        for (name_of, force) in &cascade.drive_forces {
            let other = found.drive_forces.iter().find(|(name, _)| name == name_of).expect("the drive").1;
            assert!((force - other).abs() < 1e-6 * (1.0 + force.abs()), "{name}: {name_of} {force} {other}");
        }
    }
}

#[test]
fn all_methods_agree_on_closed_loops() {
    // Rods down: the potential of a parallelogram is that of one pendulum.
    let hanging = read(PARALLELOGRAM);
    assert_all_agree("parallelogram", &hanging);
    let found = by(Method::Auto, &hanging);
    assert!(found.position[0].abs() < 1e-9, "{:?}", found.position);
    // The crank is thrown in the scenario; here it may settle.
    // Upright, where the scenario has it, Newton alone would stay.
    assert_all_agree("four_bar", &shipped("four_bar", &["crank.hinge.position=2.6"]).1);
    // In the scenario the slider-crank has no weight.
    let gravity = ["gravity=[3.0, 0.0, -9.80665]"];
    assert_all_agree("slider_crank", &shipped("slider_crank", &gravity).1);
    for name in ["double_wishbone", "excavator"] {
        assert_all_agree(name, &shipped(name, &[]).1);
    }
}

#[test]
fn all_methods_agree_on_a_steady_motion() {
    assert_all_agree("flyball_governor", &shipped("flyball_governor", &[]).1);
}

/// The rods turn together: with a lock on one the other carries it too, and the lock holds the moment of all weights.
#[test]
fn a_lock_in_a_loop_holds_by_all_methods() {
    let model = read(&PARALLELOGRAM.replacen("position = 0.7 }", "position = 0.7, lock = true }", 1));
    for method in Method::ALL {
        let found = by(method, &model);
        assert!(found.converged, "{method:?}: {:?}", found.notes);
        assert!((found.position[0] - 0.7).abs() < 1e-12 && (found.position[2] - 0.7).abs() < 1e-9, "{method:?}");
        // Virtual work: both rods by half their length, the bar by all of it.
        let moment = G * (2.0 * 0.25 + 2.0 * 0.5) * 0.7_f64.sin();
        let (_, held) = &found.holding[0];
        assert!((held.abs() - moment).abs() < 1e-9 * moment, "{method:?}: {held} instead of {moment}");
    }
}

/// Porter's formula along the whole path: the balls hang h = (1 + M/m) g/ω² below the top.
#[test]
fn the_governor_rises_by_porters_formula() {
    let (scenario, _) = shipped("governor_rise", &[]);
    let settings = scenario.path.as_ref().expect("a path");
    let path = follow(&scenario.description, &scenario.statics, settings, &mut |_| true).expect("a path");
    assert!(path.complete && path.branches.len() == 1 && path.events().count() == 0, "{:?}", path.notes);
    let (_, model) = shipped("governor_rise", &[]);
    let left = model.bodies[model.body("left").expect("a body")].hinge.position;
    let points = &path.branches[0].points;
    assert_eq!(points.iter().filter(|point| point.wanted).count(), 3);
    for point in points {
        let height = 3.0 * G / point.parameter.powi(2);
        let found = 0.3 * point.position[left].sin();
        assert!((found - height).abs() < 1e-11, "{}: {found} instead of {height}", point.parameter);
        assert_eq!(point.verdict, StabilityVerdict::Stable);
    }
    assert!((points.last().expect("points").parameter - 30.0).abs() < 1e-12);
}

/// A rod that grows moves what it holds: the path goes along positions that its length closes.
#[test]
fn a_path_follows_a_rod_that_grows() {
    // A plate that may move in the plane x, z, hung from one point by a rod.
    let text = r#"
[statics.path]
parameter = "tie.length"
from = 0.5
to = 1.5
at = [1.0]
[[body]]
name = "plate"
mass = 2.0
center = [0.0, -0.1, 0.0]
inertia = [0.1, 0.2, 0.2]
hinge = { type = "planar", rpy = [1.5707963267948966, 0.0, 0.0], position = [0.1, -0.4, 0.3], stiffness = [5.0, 0.0, 0.0], rest = [0.4, 0.0, 0.0] }
[[loop]]
name = "tie"
type = "rod"
between = ["plate", { body = "ground", at = [0.0, 0.0, 0.0] }]
length = 0.5
"#;
    let scenario = scenario::parse("tie.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
    let settings = scenario.path.as_ref().expect("a path");
    let path = follow(&scenario.description, &scenario.statics, settings, &mut |_| true).expect("a path");
    assert!(path.complete, "{:?}", path.notes);
    assert_eq!(path.branches[0].points.iter().filter(|point| point.wanted).count(), 1);
    for point in &path.branches[0].points {
        let (x, z) = (point.position[0], point.position[1]);
        assert!((x.hypot(z) - point.parameter).abs() < 1e-12, "{}: {x} {z}", point.parameter);
        // The pull to the side and the weight stand along the rod.
        let (side, weight) = (5.0 * (0.4 - x), 2.0 * G);
        assert!((side * z + weight * x).abs() < 1e-10 * weight, "{}: {x} {z}", point.parameter);
    }
}

/// Cylinders that push with unknown forces need what the drives of the same pose need.
#[test]
fn unknown_cylinder_forces_are_those_of_the_drives() {
    let (scenario, model) = shipped("excavator", &[]);
    let driven = found(&scenario, &model);
    let mut description = scenario.description.clone();
    description.drives.clear();
    let address = |name: &str| Parameter::find(&description, &format!("{name} piston.force")).expect("a hinge");
    let unknown: Vec<Parameter> = ["boom", "stick", "bucket"].into_iter().flat_map(address).collect();
    let held = hold(&description, &unknown, &driven.position, &Settings::default()).expect("statics");
    assert!(held.found.converged, "{:?}", held.found.notes);
    for ((address, force), (name, drive)) in held.found.unknowns.iter().zip(&driven.drive_forces) {
        assert!((force - drive).abs() < 1e-7 * drive.abs(), "{address}: {force}, but {name} {drive}");
    }
    // A motor where a loop leaves nothing to hold: four forces for three motions, the least of them.
    let more = [unknown, Parameter::find(&description, "stick.force").expect("a hinge")].concat();
    let held = hold(&description, &more, &driven.position, &Settings::default()).expect("statics");
    assert!(held.found.converged && held.found.notes.iter().any(|note| note.contains("determines 3 of 4")));
}

/// A bar between two guides, its ends on them: geared to each other they move as one.
#[test]
fn gears_agree_by_all_methods() {
    let text = r#"
[[body]]
name = "wheel"
mass = 1.0
center = [0.2, 0.0, 0.0]
inertia = [0.02, 0.02, 0.02]
hinge = { type = "revolute", axis = [0.0, 1.0, 0.0], position = 0.4 }
[[body]]
name = "pinion"
mass = 0.5
center = [0.1, 0.0, 0.05]
inertia = [0.01, 0.01, 0.01]
hinge = { type = "revolute", at = [0.6, 0.0, 0.0], axis = [0.0, 1.0, 0.0], position = -0.3, stiffness = 0.3 }
[[gear]]
type = "ratio"
ratio = -0.5
between = ["wheel", "pinion"]
"#;
    let model = read(text);
    assert_all_agree("gears", &model);
    let found = by(Method::Auto, &model);
    // q₁ − q₁(0) = −½ (q₂ − q₂(0)), and virtual work along that motion.
    let (a, b) = (found.position[0], found.position[1]);
    assert!((a - 0.4 + 0.5 * (b + 0.3)).abs() < 1e-12, "{a} {b}");
    let wheel = 1.0 * G * 0.2 * a.cos();
    let pinion = 0.5 * G * (0.1 * b.cos() - 0.05 * -b.sin()) - 0.3 * b;
    assert!((-0.5 * wheel + pinion).abs() < 1e-9, "{wheel} {pinion}");
}

/// Three rods between two pins, with next to no slack: the sag is the square root of it. Where the loop is that taut its
/// closed positions are known to round-off over the angle of its rows, and a residual above 1e-10 is said to be that.
#[test]
fn a_nearly_taut_loop_is_as_exact_as_it_can_be_and_says_so() {
    for slack in [1e-2, 1e-5, 1e-8] {
        let angle = (1.0 - slack / 0.8_f64).acos();
        let rod = |name: &str, length: f64, on: &str, position: f64| {
            format!(
                "[[body]]\nname = \"{name}\"\nmass = {length:?}\ncenter = [{:?}, 0, 0]\ninertia = [1e-4, 0.01, 0.01]\n\
                 markers = {{ tip = [{length:?}, 0, 0] }}\n\
                 hinge = {{ type = \"revolute\", {on} axis = [0, 1, 0], position = {position:?} }}\n",
                0.5 * length
            )
        };
        // Bent to one side at first.
        let text = [
            rod("a", 0.4, "", 1.1 * angle),
            rod("b", 0.2, "parent = \"a\", at = \"tip\",", -0.9 * angle),
            rod("c", 0.4, "parent = \"b\", at = \"tip\",", -1.2 * angle),
            format!(
                "[[loop]]\ntype = \"revolute\"\nbetween = [\"c.tip\", {{ body = \"ground\", at = [{:?}, 0, 0] }}]\naxis = [0, 1, 0]\n",
                1.0 - slack
            ),
        ]
        .concat();
        let found = by(Method::Auto, &read(&text));
        assert!(found.converged, "{slack:e}: {:?}", found.notes);
        // A gap of 1e-14 m over the slope of the closing distance, 0.8 sin θ.
        let known = 1e-13 / angle;
        assert!((found.position[0] - angle).abs() < known, "{slack:e}: {:e}", found.position[0] - angle);
        let said = found.notes.iter().any(|note| note.contains("is round-off"));
        assert!(said || found.relative_residual <= 1e-10, "{slack:e}: {:e}", found.relative_residual);
        // Rows known to a few roundings over their angle, times multipliers that grow by the same: some forty roundings.
        assert!(found.relative_residual < 1e-14 / (angle * angle), "{slack:e}: {:e}", found.relative_residual);
    }
}

/// Upright the cranks balance on their change from falling left to falling right; downhill, through the positions in which
/// all bars lie in one line, they hang.
#[test]
fn upright_cranks_fall_through_their_change_points_and_hang() {
    let (scenario, model) = shipped("coupled_cranks", &[]);
    assert!(model.start_position.iter().all(|angle| *angle == 0.0));
    let found = found(&scenario, &model);
    for (index, name) in ["crank0", "crank1", "crank2"].iter().enumerate() {
        let body = model.body(name).expect("a crank");
        let angle = found.position[model.bodies[body].hinge.position];
        assert!((angle.abs() - std::f64::consts::PI).abs() < 1e-9, "crank{index} at {angle}");
    }
    assert_eq!(found.stability.as_ref().map(|s| s.verdict), Some(StabilityVerdict::Stable));
    assert!(found.notes.iter().any(|note| note.contains("left an unstable equilibrium")), "{:?}", found.notes);
}

/// Scissors of bars of 1 m and 1 kg, `stages` of them, that hang from a pin by one end of the first bar; a spring of the
/// given stiffness and length lies between the upper ends, `angle` is from the vertical to the bars, and `tilt` turns all.
fn scissors(stages: usize, [stiffness, length]: [f64; 2], angle: f64, tilt: f64) -> Arc<Model> {
    let bar = |name: &str, top: f64, hinge: &str, position: f64| {
        format!(
            "[[body]]\nname = \"{name}\"\nmass = 1.0\ncenter = [0, 0, {:?}]\ninertia = [0.0833333, 0.0833333, 1e-4]\n\
             markers = {{ top = [0, 0, {top:?}], mid = [0, 0, {:?}], low = [0, 0, {:?}] }}\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], {hinge} position = {position:?} }}\n",
            top - 0.5,
            top - 0.5,
            top - 1.0
        )
    };
    let mut text = String::new();
    for i in 0..stages {
        let (parent, position) = match i {
            0 => (String::new(), tilt - angle),
            _ => (format!("parent = \"b{}\", at = \"low\",", i - 1), -2.0 * angle),
        };
        text += &bar(&format!("a{i}"), 0.0, &parent, position);
        text += &bar(&format!("b{i}"), 0.5, &format!("parent = \"a{i}\", at = \"mid\","), 2.0 * angle);
        if i > 0 {
            text += &format!(
                "[[loop]]\ntype = \"revolute\"\nbetween = [\"a{}.low\", \"b{i}.top\"]\naxis = [0, 1, 0]\n",
                i - 1
            );
        }
    }
    text += &format!(
        "[[force]]\ntype = \"spring\"\nbetween = [\"a0.top\", \"b0.top\"]\nstiffness = {stiffness:?}\nlength = {length:?}\n"
    );
    read(&text)
}

/// Where they hang: all stages alike, the centre of mass below the pin. `angle` is near.
fn hanging_scissors(stages: usize, [stiffness, length]: [f64; 2], mut angle: f64) -> (f64, f64) {
    let n = stages as f64;
    for _ in 0..50 {
        let (s, c) = angle.sin_cos();
        // The centre of mass is r = ½ √(s² + n² c²) below the pin, the upper ends are s apart.
        let r = 0.5 * (s * s + n * n * c * c).sqrt();
        let (slope, curve) = (s * c * (1.0 - n * n) / (4.0 * r), (c * c - s * s) * (1.0 - n * n) / (4.0 * r));
        let force = -2.0 * n * G * slope + stiffness * (s - length) * c;
        let bent = -2.0 * n * G * (curve - slope * slope / r) + stiffness * (c * c - (s - length) * s);
        angle -= force / bent;
    }
    (angle, (angle.tan() / n).atan())
}

/// Every stage hangs its loops on those above; flat and nearly closed they are close to a position where rows hang on each
/// other. Rounding is no excuse there: what is left stays below what it may leave, and that is little.
#[test]
fn hanging_scissors_are_exact_to_round_off() {
    for stages in [3, 10, 20, 40] {
        let k = stages as f64;
        for (spring, near) in [([2000.0 * k, 1.0], 1.0), ([50.0 * k, 0.3], 0.2), ([1e7 * k, 0.01], 0.01)] {
            let (angle, tilt) = hanging_scissors(stages, spring, near);
            for beside in [0.0, 1e-12, 1e-6, 1e-2] {
                let guess = angle + beside;
                let model = scissors(stages, spring, guess, (guess.tan() / k).atan());
                let found = by(Method::Auto, &model);
                assert!(found.converged, "{stages}, {spring:?}: {:?}", found.notes);
                assert!(
                    found.relative_residual <= found.round_off,
                    "{:e} {:e}",
                    found.relative_residual,
                    found.round_off
                );
                assert!(found.round_off < 1e-11, "{:e}", found.round_off);
                let off = (found.position[1] - 2.0 * angle).abs().max((found.position[0] - (tilt - angle)).abs());
                assert!(off < 1e-12, "{stages}, {spring:?}, {beside:e}: {off:e}");
            }
        }
        // Flat, their ends in two points: from beside it they go, and what they end in is an equilibrium.
        for beside in [1e-10, 1e-6] {
            let found = by(Method::Auto, &scissors(stages, [2e4 * k, 0.999], 0.5 * std::f64::consts::PI + beside, 0.0));
            assert!(found.converged && found.relative_residual < 1e-11, "{stages}: {:e}", found.relative_residual);
        }
    }
}

/// Three rods that are all but taut, in axes turned about two others by `turn`; the angles of the first and of the middle
/// one from the straight line.
fn taut(slack: f64, turn: f64, [first, middle, last]: [f64; 3]) -> Arc<Model> {
    let (s, c) = turn.sin_cos();
    let turned = |[x, y, z]: [f64; 3]| {
        let (x, z) = (c * x + s * z, c * z - s * x);
        format!("[{:?}, {:?}, {z:?}]", c * x - s * y, s * x + c * y)
    };
    let rod = |name: &str, length: f64, on: &str, position: f64| {
        format!(
            "[[body]]\nname = \"{name}\"\nmass = {length:?}\ncenter = {}\ninertia = [0.01, 0.01, 0.01]\n\
             markers = {{ tip = {} }}\nhinge = {{ type = \"revolute\", {on} axis = {}, position = {position:?} }}\n",
            turned([0.5 * length, 0.0, 0.0]),
            turned([length, 0.0, 0.0]),
            turned([0.0, 1.0, 0.0])
        )
    };
    let text = [
        format!("gravity = {}\n", turned([0.0, 0.0, -G])),
        rod("a", 0.4, "", first),
        rod("b", 0.2, "parent = \"a\", at = \"tip\",", middle - first),
        rod("c", 0.4, "parent = \"b\", at = \"tip\",", last - middle),
        format!(
            "[[loop]]\ntype = \"revolute\"\nbetween = [\"c.tip\", {{ body = \"ground\", at = {} }}]\naxis = {}\n",
            turned([1.0 - slack, 0.0, 0.0]),
            turned([0.0, 1.0, 0.0])
        ),
    ]
    .concat();
    read(&text)
}

/// What is said of round-off is what rounding does: the same pose in axes that round otherwise leaves other forces, up to
/// that and not far below it. And it excuses nothing else: a pose that is off by ten times as much is not balanced.
#[test]
fn round_off_is_what_rounding_does_and_excuses_nothing_else() {
    for slack in [1e-4, 1e-6, 1e-8] {
        let angle = (1.0 - slack / 0.8_f64).acos();
        let (mut largest, mut allowed) = (0.0_f64, f64::INFINITY);
        for k in 0..40 {
            let model = taut(slack, 0.05 + 0.03 * f64::from(k), [angle, 0.0, -angle]);
            let settings = Settings { want: Want::Any, ..Settings::default() };
            let found = equilibrium(&model, &settings, &model.start_position).expect("statics");
            assert_eq!((found.converged, found.stage), (true, "start"), "{slack:e} {k}: {:?}", found.notes);
            assert!(found.relative_residual <= found.round_off, "{:e} {:e}", found.relative_residual, found.round_off);
            largest = largest.max(found.relative_residual);
            allowed = allowed.min(found.round_off);
        }
        assert!(largest > 0.02 * allowed, "{slack:e}: {largest:e} of {allowed:e}");
    }
    // So taut that rounding may leave more than one part in 10¹⁰.
    let slack = 1e-10;
    let angle = 2.0 * (slack / 1.6_f64).sqrt().asin();
    let model = |off: f64| {
        // On closed positions: 0.4 (sin α + sin γ) + 0.2 sin β = 0, and the same of 1 − cos is the slack.
        let first = angle * (1.0 + off);
        let (mut middle, mut last) = (0.0, -angle);
        for _ in 0..20 {
            let sum = 0.4 * f64::sin(first) + 0.2 * f64::sin(middle) + 0.4 * f64::sin(last);
            let less = |angle: f64| 2.0 * (0.5 * angle).sin().powi(2);
            let gap = 0.4 * less(first) + 0.2 * less(middle) + 0.4 * less(last) - slack;
            let [a, b, c, d] = [0.2 * middle.cos(), 0.4 * last.cos(), 0.2 * middle.sin(), 0.4 * last.sin()];
            let whole = a * d - b * c;
            middle -= (sum * d - gap * b) / whole;
            last -= (a * gap - c * sum) / whole;
        }
        taut(slack, 0.0, [first, middle, last])
    };
    let left = |off: f64| {
        let model = model(off);
        let balance = stillpoint::statics::balance(&model, &model.start_position, &[0.0; 3]).expect("finite");
        balance.and_then(|balance| balance.residual)
    };
    let round_off = by(Method::Auto, &model(0.0)).round_off;
    assert!((1e-11..1e-9).contains(&round_off), "{round_off:e}");
    for off in [10.0, 30.0, 100.0] {
        let residual = left(off * round_off).expect("a pose that is not balanced");
        assert!(residual.relative > 3.0 * round_off, "{}", residual.relative);
    }
    assert_eq!(left(0.0), None);
}

/// A linkage settles as fast beside one of a millionth of its mass as alone: what is light does not hold back what is heavy.
#[test]
fn a_heavy_linkage_settles_beside_a_light_one() {
    let found = |ratio: f64| {
        let mut text = String::new();
        for (name, at, mass) in [("one", 0.0, 1.0), ("other", 3.0, ratio)] {
            let bar = |part: &str, hinge: &str, length: f64, position: f64| {
                let inertia = mass * length * length / 12.0;
                format!(
                    "[[body]]\nname = \"{name} {part}\"\nmass = {mass:?}\ncenter = [{:?}, 0, 0]\n\
                     inertia = [{inertia:?}, {inertia:?}, {inertia:?}]\nmarkers = {{ tip = [{length:?}, 0, 0] }}\n\
                     hinge = {{ type = \"revolute\", {hinge}, axis = [0, 1, 0], position = {position:?} }}\n",
                    0.5 * length
                )
            };
            text += &bar("crank", &format!("at = [{at:?}, 0, 0]"), 0.4, 2.5);
            text += &bar("coupler", &format!("parent = \"{name} crank\", at = \"tip\""), 1.0, -2.4);
            text += &bar("rocker", &format!("at = [{:?}, 0, 0]", at + 1.0), 0.7, 1.9);
            text += &format!(
                "[[loop]]\ntype = \"revolute\"\nbetween = [\"{name} coupler.tip\", \"{name} rocker.tip\"]\naxis = [0, 1, 0]\n"
            );
        }
        by(Method::Auto, &read(&text))
    };
    let alike = found(1.0);
    for ratio in [1e-6, 1e6] {
        let found = found(ratio);
        assert!(found.converged && found.iterations <= alike.iterations + 5, "{ratio:e}: {} steps", found.iterations);
        let off = found.position.iter().zip(&alike.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-9, "{ratio:e}: {off:e}");
    }
}
