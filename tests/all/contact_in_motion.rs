//! Contact in motion, by events, against closed forms and conservation laws.

use crate::common::Random;
use nalgebra::{UnitQuaternion, Vector3};
use std::fmt::Write as _;
use std::sync::Arc;
use stillpoint::constraint::assemble;
use stillpoint::integrate::Method;
use stillpoint::model::Model;
use stillpoint::record::{Memory, Opening};
use stillpoint::scenario::parse;
use stillpoint::simulate::events::Occurrence;
use stillpoint::simulate::{self, Integrator, RunError, Settings, State, Summary, run};

const G: f64 = 9.80665;

/// The model of a scenario, its loops closed.
pub(crate) fn read(text: &str) -> Arc<Model> {
    let scenario = parse("scene.toml", text, &[]).unwrap_or_else(|problem| panic!("{}\n{text}", problem.render(false)));
    assemble(Model::build(&scenario.description).unwrap()).unwrap().0
}

/// A run from the given state.
pub(crate) fn tried(model: &Arc<Model>, duration: f64, tolerance: f64, method: Method) -> Result<Summary, RunError> {
    let settings = Settings {
        start: simulate::Start::Given,
        duration,
        tolerance,
        absolute_tolerance: tolerance,
        integrator: Integrator::Method(method),
        ..Settings::default()
    };
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let scene = simulate::scene(model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: "", statics: None });
    run(model, &settings, 1.0 / duration, &start, &mut memory, &mut |_, _| true)
}

pub(crate) fn go(model: &Arc<Model>, duration: f64, tolerance: f64, method: Method) -> Summary {
    tried(model, duration, tolerance, method).unwrap_or_else(|error| panic!("{error}"))
}

pub(crate) fn exact(text: &str, duration: f64) -> Summary {
    go(&read(text), duration, 1e-11, Method::Dop853)
}

pub(crate) fn kinds(summary: &Summary) -> Vec<&str> {
    summary.events.iter().map(|event| event.kind.name()).collect()
}

pub(crate) const FLOOR: &str =
    "[[body]]\nname = \"floor\"\nshape = { plane = [0, 0, 1] }\nhinge = { type = \"fixed\" }\n";

/// A free body: mass, moments of inertia, shape, position, turn, velocity, angular velocity.
fn body(
    name: &str,
    mass: f64,
    inertia: [f64; 3],
    shape: &str,
    pose: (Vector3<f64>, UnitQuaternion<f64>),
    speed: [f64; 6],
) -> String {
    let (at, q) = pose;
    format!(
        "[[body]]\nname = \"{name}\"\nmass = {mass:?}\ninertia = {inertia:?}\nshape = {shape}\nhinge = {{ type = \"free\", \
         position = {:?}, velocity = {speed:?} }}\n",
        [at.x, at.y, at.z, q.w, q.i, q.j, q.k]
    )
}

fn contact(friction: f64, restitution: f64) -> String {
    format!("[[contact]]\nbetween = [\"*\", \"*\"]\nfriction = {friction:?}\nrestitution = {restitution:?}\n")
}

fn level(z: f64) -> (Vector3<f64>, UnitQuaternion<f64>) {
    (Vector3::z() * z, UnitQuaternion::identity())
}

/// Reference `incline_slides`, at any heading: just beyond the cone a box slides by g (sin φ − μ cos φ) t²/2.
#[test]
fn a_box_slides_beyond_its_cone() {
    let mut random = Random::new(71);
    for part in [1.0 + 1e-6, 1.001, 1.1, 2.0] {
        for _ in 0..3 {
            let (friction, mass) = (random.between(0.1, 0.6), random.between(0.1, 50.0));
            let phi = (part * friction).atan();
            let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), random.between(-3.0, 3.0))
                * UnitQuaternion::from_axis_angle(&Vector3::y_axis(), phi);
            let normal = turn * Vector3::z();
            let text = FLOOR.replace("[0, 0, 1]", &format!("{:?}", [normal.x, normal.y, normal.z]))
                + &body("box", mass, [0.05 * mass; 3], "{ box = [0.4, 0.3, 0.1] }", (normal * 0.05, turn), [0.0; 6])
                + &contact(friction, 0.0);
            let summary = exact(&text, 2.0);
            let moved = Vector3::from_column_slice(&summary.state.position[..3]) - normal * 0.05;
            let expected = turn * Vector3::x() * (G * (phi.sin() - friction * phi.cos()) * 2.0);
            assert!((moved - expected).norm() < 1e-9, "{part}: {moved:?} {expected:?}");
            assert!(summary.energy_drift < 1e-9 * mass, "{summary:?}");
        }
    }
}

/// Reference `sliding_block`, `sphere_slides_then_rolls`, `hoop_slides_then_rolls`: what slides stops, or rolls, when it should, and
/// stays where it stops.
#[test]
fn what_slides_comes_to_rest_or_rolls() {
    let box_ = body(
        "box",
        2.0,
        [0.0133, 0.0333, 0.0333],
        "{ box = [0.4, 0.2, 0.2] }",
        level(0.1),
        [4.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    );
    let summary = exact(&(FLOOR.to_owned() + &box_ + &contact(0.3, 0.0)), 12.0);
    assert_eq!(kinds(&summary), ["sticks"]);
    assert!((summary.events[0].time - 4.0 / (0.3 * G)).abs() < 1e-9);
    assert!((summary.state.position[0] - 16.0 / (0.6 * G)).abs() < 1e-9);
    assert!(summary.state.velocity.iter().all(|v| *v == 0.0));
    for k in [0.4, 0.5, 2.0 / 3.0, 1.0] {
        let ball = body("ball", 1.0, [k * 0.01; 3], "{ sphere = 0.1 }", level(0.1), [3.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let summary = exact(&(FLOOR.to_owned() + &ball + &contact(0.2, 0.0)), 1.5);
        assert_eq!(kinds(&summary), ["rolls"], "{k}");
        assert!((summary.events[0].time - 3.0 * k / ((1.0 + k) * 0.2 * G)).abs() < 1e-9, "{k}");
        assert!((summary.state.velocity[0] - 3.0 / (1.0 + k)).abs() < 1e-9, "{k}");
    }
}

/// Reference `bouncing_ball`: each blow at its time, and rest where their series ends.
#[test]
fn a_ball_bounces_and_comes_to_rest() {
    for e in [0.5, 0.8] {
        let ball = body("ball", 1.0, [0.001; 3], "{ sphere = 0.05 }", level(1.05), [0.0; 6]);
        let summary = exact(&(FLOOR.to_owned() + &ball + &contact(0.3, e)), 6.0);
        let first = (2.0 / G).sqrt();
        let blows: Vec<&Occurrence> = summary.events.iter().filter(|event| event.kind.name() == "strikes").collect();
        let tenth = first * (1.0 + 2.0 * (1..10).map(|k| f64::powi(e, k)).sum::<f64>());
        assert!((blows[0].time - first).abs() < 1e-12 && (blows[9].time - tenth).abs() < 1e-10);
        let rest = first * (1.0 + e) / (1.0 - e);
        let last = blows.last().unwrap();
        assert!((last.time - rest).abs() < 1e-5 && summary.impacts == blows.len(), "{} {rest}", last.time);
        assert!(summary.state.velocity.iter().all(|v| *v == 0.0) && (summary.state.position[2] - 0.05).abs() < 1e-12);
    }
}

/// Reference `rocking_block` (Housner 1963): time and loss of the first blow.
#[test]
fn a_block_rocks_from_edge_to_edge() {
    let (b, h, tilt) = (0.1_f64, 0.4_f64, 0.1_f64);
    let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), tilt);
    let at = Vector3::z() * (b * tilt.sin() + h * tilt.cos());
    let inertia = [10.0 * (0.04 + 0.64) / 12.0, 10.0 * (0.04 + 0.64) / 12.0, 10.0 * 0.08 / 12.0];
    let block = body("block", 10.0, inertia, "{ box = [0.2, 0.2, 0.8] }", (at, turn), [0.0; 6]);
    let summary = exact(&(FLOOR.to_owned() + &block + &contact(1.0, 0.0)), 0.3);
    assert_eq!(kinds(&summary), ["strikes"]);
    assert!((summary.events[0].time - 0.264_758_625_578_136_3).abs() < 1e-8, "{:?}", summary.events);
    // (1 − ratio²) of what was kinetic is lost: ratio = 1 − 3/2 sin² α.
    let (alpha, reach) = ((b / h).atan(), b.hypot(h));
    let before = 10.0 * G * reach * (1.0 - (alpha - tilt).cos()) - 10.0 * G * reach * (1.0 - alpha.cos());
    let ratio: f64 = 1.0 - 1.5 * alpha.sin().powi(2);
    let lost = before.abs() * (1.0 - ratio * ratio);
    assert!((summary.dissipated - lost).abs() < 1e-8, "{} {lost}", summary.dissipated);
}

/// Reference `newtons_cradle`: blows go from neighbour to neighbour.
#[test]
fn the_last_ball_of_a_cradle_leaves_alone() {
    let mut text = "gravity = [0, 0, 0]\n".to_owned();
    for i in 0..5 {
        let (at, speed) = if i == 0 { (-0.1, 1.0) } else { (0.1 * f64::from(i), 0.0) };
        write!(
            text,
            "[[body]]\nname = \"b{i}\"\nmass = 1\ninertia = [0.001, 0.001, 0.001]\nshape = {{ sphere = 0.05 }}\n\
             hinge = {{ type = \"prismatic\", axis = [1, 0, 0], position = {at:?}, velocity = {speed:?} }}\n"
        )
        .unwrap();
    }
    let summary = exact(&(text + &contact(0.0, 1.0)), 1.0);
    assert_eq!((summary.impacts, kinds(&summary)), (4, vec!["strikes"; 4]));
    let off = summary.state.velocity.iter().zip([0.0, 0.0, 0.0, 0.0, 1.0]).map(|(v, expected)| (v - expected).abs());
    assert!(off.fold(0.0, f64::max) < 1e-9, "{:?}", summary.state.velocity);
}

/// Reference `falling_ladder`: a smooth one leaves the wall where its top has come down to two thirds of its height.
#[test]
fn a_falling_ladder_leaves_the_wall() {
    let (length, angle, mass) = (2.0_f64, 1.221_730_476_396_030_6_f64, 5.0);
    let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), angle - std::f64::consts::FRAC_PI_2);
    let at = Vector3::new(0.5 * length * angle.cos(), 0.0, 0.5 * length * angle.sin());
    let inertia = mass * length * length / 12.0;
    let text = FLOOR.to_owned()
        + &FLOOR.replace("floor", "wall").replace("[0, 0, 1]", "[1, 0, 0]")
        + &body("ladder", mass, [inertia, inertia, 1e-3], "{ capsule = [0, 2.0] }", (at, turn), [0.0; 6])
        + &contact(0.0, 0.0);
    let summary = exact(&text, 0.8);
    assert_eq!(kinds(&summary), ["lifts"]);
    assert!((summary.events[0].time - 0.597_629_856_579_229_3).abs() < 1e-8, "{:?}", summary.events);
    assert!((summary.state.velocity[0] - 1.344_722_914_847_565).abs() < 1e-8, "{:?}", summary.state.velocity);
}

/// Reference `belt_stick_slip`: what a belt carries along sticks and slips in turn, with static friction above kinetic.
#[test]
fn a_belt_makes_a_block_stick_and_slip() {
    let text = "[[body]]\nname = \"belt\"\nmass = 1\nshape = { plane = [0, 0, 1] }\n\
                hinge = { type = \"prismatic\", axis = [1, 0, 0], velocity = 0.2 }\n\
                [[drive]]\nname = \"motor\"\nhinge = \"belt\"\ntype = \"expression\"\nexpression = \"0.2*t\"\n"
        .to_owned()
        + &body("block", 1.0, [0.01; 3], "{ box = [0.2, 0.2, 0.2] }", level(0.1), [0.2, 0.0, 0.0, 0.0, 0.0, 0.0])
        + "[[force]]\nname = \"spring\"\ntype = \"spring\"\nstiffness = 50\nlength = 10\n\
           between = [{ body = \"ground\", at = [-10, 0, 0.1] }, { body = \"block\", at = [0, 0, 0] }]\n\
           [[contact]]\nbetween = [\"belt\", \"block\"]\nfriction = { stick = 0.6, slide = 0.4 }\n";
    let summary = exact(&text, 3.0);
    let kinds = kinds(&summary);
    assert_eq!(kinds[..4], ["slips", "sticks", "slips", "sticks"]);
    let times: Vec<f64> = summary.events.iter().map(|event| event.time).collect();
    assert!((times[0] - 0.6 * G / 50.0 / 0.2).abs() < 1e-9, "{times:?}");
    assert!((times[1] - times[0] - 0.620_983_834_223_171_2).abs() < 1e-8, "{times:?}");
    assert!((times[2] - times[1] - 0.392_266).abs() < 1e-8, "{times:?}");
}

/// Thrown cubes tumble to rest: no blow and no slip gains energy, all of it is booked, and nothing sinks.
#[test]
fn thrown_cubes_come_to_rest() {
    let mut random = Random::new(72);
    for case in 0..6 {
        let axis = nalgebra::Unit::new_normalize(Vector3::from_fn(|_, _| random.between(-1.0, 1.0)));
        let turn = UnitQuaternion::from_axis_angle(&axis, random.between(0.0, 3.0));
        let speed = [0; 6].map(|_| random.between(-1.0, 1.0));
        let (friction, restitution) = (random.between(0.2, 0.6), random.between(0.0, 0.4));
        let cube = body("cube", 1.0, [1.0 / 600.0; 3], "{ box = [0.1, 0.1, 0.1] }", (Vector3::z() * 0.2, turn), speed);
        let summary =
            go(&read(&(FLOOR.to_owned() + &cube + &contact(friction, restitution))), 2.0, 1e-9, Method::Dop853);
        // Captured steps are of order 1.
        assert!(summary.energy_drift < 1e-3, "{case}: {}", summary.energy_drift);
        assert!(summary.capture_steps > 0 || summary.energy_drift < 1e-7, "{case}: {}", summary.energy_drift);
        assert!(summary.energy_end < summary.energy_start);
        let rests = summary.state.velocity.iter().all(|v| v.abs() < 1e-6);
        assert!(rests && (summary.state.position[2] - 0.05).abs() < 1e-6, "{case}: {:?}", summary.state);
    }
}

/// The error follows the tolerance across blows and slips, with any method that adapts its steps.
#[test]
fn errors_follow_the_tolerance_across_events() {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 0.3);
    let at = Vector3::z() * (0.1 * 0.3_f64.sin() + 0.3 * 0.3_f64.cos());
    let block =
        body("block", 1.0, [0.03, 0.04, 0.01], "{ box = [0.2, 0.2, 0.6] }", (at, turn), [0.3, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let model = read(&(FLOOR.to_owned() + &block + &contact(0.3, 0.0)));
    let best = go(&model, 0.6, 1e-13, Method::Dop853).state;
    for method in [Method::Dopri5, Method::Dop853, Method::Radau5, Method::Radau9, Method::Sdirk4] {
        for tolerance in [1e-5, 1e-7, 1e-9] {
            let found = go(&model, 0.6, tolerance, method).state;
            let off = found.position.iter().zip(&best.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 20.0 * tolerance, "{method:?} {tolerance:e}: {off:e}");
        }
    }
}

/// Two blocks that slide with a stiff damped spring between them: `auto` goes over to an implicit method, and the middle of both slows down by
/// friction alone.
#[test]
fn stiff_springs_beside_contact_are_followed_implicitly() {
    let block = |name: &str, x: f64| {
        let at = (Vector3::new(x, 0.0, 0.1), UnitQuaternion::identity());
        body(name, 1.0, [0.01, 0.01, 0.01], "{ box = [0.2, 0.2, 0.2] }", at, [4.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    };
    let spring = "[[force]]\ntype = \"spring\"\nbetween = [\"rear\", \"front\"]\nstiffness = 1e7\nlength = 0.4999\ndamping = 1e5\n";
    let floors = "[[contact]]\nbetween = [\"floor\", \"*\"]\nfriction = 0.2\n";
    let text = FLOOR.to_owned() + &block("rear", 0.0) + &block("front", 0.5) + spring + floors;
    let model = read(&text);
    let settings = Settings {
        start: simulate::Start::Given,
        duration: 1.0,
        tolerance: 1e-7,
        absolute_tolerance: 1e-7,
        ..Settings::default()
    };
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let scene = simulate::scene(&model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: "", statics: None });
    let summary =
        run(&model, &settings, 1.0, &start, &mut memory, &mut |_, _| true).unwrap_or_else(|error| panic!("{error}"));
    assert!(summary.integrators.iter().any(|method| method.stability_reach().is_none()), "{:?}", summary.choice);
    let middle = 0.5 * (summary.state.position[0] + summary.state.position[7]);
    assert!((middle - (0.25 + 4.0 - 0.1 * G)).abs() < 1e-9, "{middle}");
    assert!(summary.capture_steps == 0 && summary.statistics.steps < 300, "{:?}", summary.statistics);
}

/// Every shipped scene loads without a warning and runs to its end; the last domino lies flat, and none has sunk.
#[test]
fn shipped_scenes_run_to_their_end() {
    let folder = std::path::PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenarios/contact");
    let mut count = 0;
    for file in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.starts_with("# ") && text.contains("\ntitle = "), "{}", file.display());
        let scenario = stillpoint::scenario::load(&file).unwrap_or_else(|problem| panic!("{problem}"));
        assert!(scenario.warnings.is_empty(), "{}", file.display());
        let model = read(&text);
        let summary = go(&model, scenario.simulate.duration, scenario.simulate.tolerance, Method::Dop853);
        assert_eq!(summary.end_time, scenario.simulate.duration, "{}", file.display());
        let energy = summary.energy_start.abs() + summary.work.abs();
        assert!(summary.energy_drift < 0.02 * energy, "{}: {}", file.display(), summary.energy_drift);
        if file.ends_with("dominoes.toml") {
            assert!(summary.energy_drift > 0.0 && summary.energy_end < summary.energy_start);
            let lies = summary.state.position[7 * 4 + 2];
            assert!((lies - 0.01).abs() < 1e-4, "{:?}", summary.state.position);
            assert!((0..5).all(|i| summary.state.position[7 * i + 2] > 0.0099), "{:?}", summary.state.position);
        }
        count += 1;
    }
    assert!(count >= 6);
}

/// Dry friction of a hinge that might touch something and does not, beside a contact that slides: events follow both. A box and a wheel slow down, each by its own friction.
#[test]
fn dry_friction_of_hinges_beside_contacts_that_slide() {
    let mut random = Random::new(0x0f81);
    for case in 0..8 {
        let (friction, speed) = (random.between(0.2, 0.6), random.between(0.5, 2.0));
        let (inertia, spin, torque) = (random.between(0.05, 0.2), random.between(1.0, 5.0), random.between(0.1, 0.5));
        let text = FLOOR.to_owned()
            + &body("box", 1.0, [0.01; 3], "{ box = [0.2, 0.2, 0.1] }", level(0.05), [speed, 0.0, 0.0, 0.0, 0.0, 0.0])
            + &format!(
                "[[body]]\nname = \"wheel\"\nmass = 1.0\ninertia = [0.1, 0.1, {inertia:?}]\nshape = {{ sphere = 0.1, at = [0, 0, 3] }}\nhinge = {{ type = \"revolute\", axis = [0, 0, 1], velocity = \
                 [{spin:?}], friction = {torque:?} }}\n"
            )
            + &contact(friction, 0.0);
        let model = read(&text);
        let summary = go(&model, 5.0, 1e-8, Method::Dopri5);
        let (way, turn) = (speed * speed / (2.0 * friction * G), inertia * spin * spin / (2.0 * torque));
        let q = &summary.state.position;
        // Between events a parabola and a line: what is left is when they end.
        assert!((q[0] - way).abs() < 1e-9 * way, "case {case}: {} {way}", q[0]);
        assert!((q[7] - turn).abs() < 1e-9 * turn, "case {case}: {} {turn}", q[7]);
        assert!(
            summary.state.velocity.iter().all(|v| *v == 0.0) && summary.capture_steps == 0,
            "case {case}: {summary:?}"
        );
    }
}

/// An arm of two links falls on a floor while its elbow hits a rigid stop: it ends on both, where geometry says.
#[test]
fn an_arm_ends_on_the_floor_and_on_its_stop() {
    for friction in [0.0, 0.05] {
        let text = FLOOR.to_owned()
            + &format!(
                "[[body]]\nname = \"upper\"\nmass = 1.0\ncenter = [0.25, 0, 0]\ninertia = [0.001, 0.02, 0.02]\nhinge = {{ type = \"revolute\", axis = \
                 [0, 1, 0], at = [0, 0, 0.5], friction = {friction:?} }}\n[[body]]\nname = \"lower\"\nmass = 0.5\ncenter = [0.2, 0, 0]\ninertia = [0.001, \
                 0.01, 0.01]\nshape = {{ sphere = 0.02, at = [0.4, 0, 0] }}\nhinge = {{ type = \"revolute\", parent = \"upper\", axis = [0, 1, 0], at = \
                 [0.5, 0, 0], position = [0.3], limits = [[-1.0, 0.5]] }}\n"
            )
            + &contact(0.4, 0.0);
        let model = read(&text);
        let summary = go(&model, 4.0, 1e-7, Method::Dopri5);
        let q = &summary.state.position;
        assert!(model.stops.iter().all(|stop| q[stop.position] >= stop.range[0] && q[stop.position] <= stop.range[1]));
        // The tip's height above the floor.
        let height = 0.5 - 0.5 * q[0].sin() - 0.4 * (q[0] + q[1]).sin() - 0.02;
        assert!(height.abs() < 1e-6, "{friction}: {height:e} {q:?}");
        assert!((q[1] + 1.0).abs() < 1e-9 || (q[1] - 0.5).abs() < 1e-9, "{friction}: {q:?}");
        assert!(summary.state.velocity.iter().all(|v| v.abs() < 1e-6), "{friction}: {:?}", summary.state.velocity);
    }
}

/// The contacts of a recording push as hard as the body accelerates, and on its second body: slides, stands and captured steps alike.
#[test]
fn recorded_contacts_are_what_moves_a_body() {
    let mut random = Random::new(0xc0_117a);
    for case in 0..12 {
        let (mass, friction) = (random.between(0.5, 3.0), random.between(0.1, 0.6));
        let speed = if case % 3 == 0 { 0.0 } else { random.between(0.5, 2.0) };
        // A foot that glides along the floor on a slider with dry friction: captured steps follow both.
        let slider = "[[body]]\nname = \"slider\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
                      hinge = { type = \"prismatic\", axis = [1, 0, 0], at = [0, 20, 1], velocity = 1.0, friction = 0.1 }\n\
                      [[body]]\nname = \"foot\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\nshape = { sphere = 0.1 }\n\
                      hinge = { type = \"prismatic\", parent = \"slider\", axis = [0, 0, 1], position = -0.9 }\n\
                      [[contact]]\nbetween = [\"floor\", \"foot\"]\nfriction = 0.0\n";
        let text = FLOOR.to_owned()
            + &body("box", mass, [0.01; 3], "{ box = [0.2, 0.2, 0.1] }", level(0.05), [speed, 0.0, 0.0, 0.0, 0.0, 0.0])
            + &contact(friction, 0.0)
            + if case % 3 == 2 { slider } else { "" };
        let model = read(&text);
        let settings = Settings { start: simulate::Start::Given, duration: 0.1, ..Settings::default() };
        let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
        let scene = simulate::scene(&model);
        let mut memory = Memory::new(&Opening { scene: &scene, scenario: "", statics: None });
        let summary = run(&model, &settings, 100.0, &start, &mut memory, &mut |_, _| true).unwrap();
        assert_eq!(summary.capture_steps > 0, case % 3 == 2, "case {case}");
        assert_eq!(memory.contacts.len(), memory.samples.len(), "case {case}");
        for ((time, contacts), sample) in memory.contacts.iter().zip(&memory.samples) {
            assert_eq!(*time, sample.time);
            let on_box = |one: &stillpoint::record::ContactPush| {
                let sign = if one.between[1] == "box" { 1.0 } else { -1.0 };
                Vector3::from(one.force) * sign
            };
            let contacts: Vec<_> = contacts.iter().filter(|one| one.between.iter().any(|name| name == "box")).collect();
            let sum: Vector3<f64> = contacts.iter().map(|one| on_box(one)).sum();
            let a = Vector3::new(sample.accelerations[0], sample.accelerations[1], sample.accelerations[2] + G);
            // Captured steps have the forces of their steps.
            let slack = if summary.capture_steps > 0 { 1e-5 } else { 1e-9 };
            // Before its first step nothing bears.
            if summary.capture_steps == 0 || *time > 0.05 {
                assert!((sum - a * mass).norm() < slack * mass * G, "case {case} at {time}: {sum} {a}");
                assert!(contacts.iter().all(|one| one.slips == (speed > 0.0)), "case {case}: {contacts:?}");
            }
        }
    }
}

/// Half a second of a pile, after whose hundred impacts at one instant sweeps of the cone problem run off.
fn jammed() -> (Arc<Model>, Memory) {
    let pile = "[[body]]\nname = \"b0\"\ndensity = 1232.030303954935\nshape = { box = [0.30936075853717926, 0.22737720208215045, 0.02] }\nhinge = { type = \"free\", position = [0.0408737093854699, 0.003034214873477159, 0.35, -0.6572050010462299, -0.700180850135228, -0.013900660379579799, -0.27863082267535644] }\n\
                [[body]]\nname = \"b1\"\ndensity = 277.41335962359966\nshape = { box = [0.12395330333761923, 0.12375374656411896, 0.28375394593756054] }\nhinge = { type = \"free\", position = [0.017848247354391916, 0.042295010916240425, 0.7, -0.7260300487036278, -0.15498242882997595, 0.05981992166680472, 0.6672948314689292] }\n\
                [[body]]\nname = \"b2\"\ndensity = 524.6931809937472\nshape = { sphere = 0.11632265249180603 }\nhinge = { type = \"free\", position = [0.015453313141290573, 0.013300802315834678, 1.0499999999999998, -0.5001604194833877, 0.32317787494295047, -0.7893188091301011, 0.14957083098986662] }\n\
                [[body]]\nname = \"b3\"\ndensity = 1865.007902873305\nshape = { box = [0.37476160099231715, 0.25479350069105505, 0.02] }\nhinge = { type = \"free\", position = [0.019372343378646184, -0.02728905133986147, 1.4, -0.25617086748423334, 0.08335332810562467, 0.4724141280346101, -0.8391981893327646] }\n";
    let rules = "[[contact]]\nbetween = [\"b*\", \"floor\"]\nfriction = 0.8\nrestitution = 0.3\n\
                 [[contact]]\nbetween = [\"b*\", \"b*\"]\nfriction = 0.5\n";
    let text = format!("{FLOOR}{pile}{rules}");
    let scenario = parse("scene.toml", &text, &[]).unwrap_or_else(|problem| panic!("{}", problem.render(false)));
    let model = assemble(Model::build(&scenario.description).unwrap()).unwrap().0;
    let settings = Settings { start: simulate::Start::Given, duration: 3.0, ..scenario.simulate };
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let scene = simulate::scene(&model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: "", statics: None });
    run(&model, &settings, 1000.0, &start, &mut memory, &mut |time, _| time < 0.45)
        .unwrap_or_else(|error| panic!("{error}"));
    (model, memory)
}

/// Two contacts pulled with 30 N, for 30 ms.
#[test]
fn no_contact_pulls_in_a_pile() {
    let (model, memory) = jammed();
    let weight: f64 = model.bodies.iter().map(|body| body.mass.mass * G).sum();
    let mut seen = 0;
    for (time, contacts) in &memory.contacts {
        for contact in contacts.iter() {
            let pressure = Vector3::from(contact.normal).dot(&Vector3::from(contact.force));
            // Forces of captured steps are found to some parts in a million of the weight.
            assert!(pressure > -1e-6 * weight, "at {time} s {:?} pull with {pressure} N", contact.between);
            seen += 1;
        }
    }
    assert!(seen > 100, "{seen}");
}

/// Friction and impacts of a pile take energy out, and put none in.
#[test]
fn dissipation_of_a_pile_never_falls() {
    let (_, memory) = jammed();
    let mut before = 0.0;
    for sample in &memory.samples {
        let taken = sample.energy.dissipated;
        // Round-off of differences of some 100 J, step by step.
        assert!(taken > before - 1e-9, "dissipated falls from {before} to {taken} J at {} s", sample.time);
        before = taken;
    }
}
