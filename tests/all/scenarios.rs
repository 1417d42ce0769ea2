//! The shipped scenarios: every one runs, and each makes good one physical claim that is worked out here, apart from
//! the program.

use crate::common::{answered, build};
use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::path::PathBuf;
use std::sync::Arc;
use stillpoint::model::Model;
use stillpoint::record::{Memory, Opening, OwnedSample};
use stillpoint::scenario::{Override, Scenario, load_with};
use stillpoint::simulate::{self, Start, State, Summary, run};
use stillpoint::statics::{Equilibrium, StabilityVerdict, equilibrium};

const G: f64 = 9.80665;

/// The scenario files, by name, as they stand in the folder: a new one cannot be forgotten.
pub(crate) fn names() -> Vec<String> {
    let folder = std::fs::read_dir(folder()).expect("the folder of scenarios");
    let paths = folder.map(|entry| entry.expect("an entry").path());
    let toml = paths.filter(|path| path.extension().is_some_and(|extension| extension == "toml"));
    let mut names: Vec<String> =
        toml.map(|path| path.file_stem().expect("a name").to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("scenarios")
}

pub(crate) fn file(name: &str) -> PathBuf {
    folder().join(format!("{name}.toml"))
}

pub(crate) fn shipped(name: &str, changes: &[&str]) -> (Scenario, Arc<Model>) {
    let changes: Vec<Override> = changes.iter().map(|text| Override::parse(text).expect("a change")).collect();
    let mut scenario = load_with(&file(name), &changes).unwrap_or_else(|error| panic!("{error}"));
    let mut model = build(&scenario.description);
    if !scenario.unknown.is_empty() {
        let held = answered(&scenario, model).unwrap_or_else(|error| panic!("{error}"));
        assert!(held.found.converged, "{:?}", held.found.notes);
        (scenario.description, model) = (held.description, held.model);
    }
    (scenario, model)
}

pub(crate) fn found(scenario: &Scenario, model: &Arc<Model>) -> Equilibrium {
    let found = equilibrium(model, &scenario.statics, &model.start_position).expect("statics");
    assert!(found.converged, "{:?}", found.notes);
    found
}

/// Runs as the program does; all samples.
fn simulated(scenario: &Scenario, model: &Arc<Model>) -> (Summary, Vec<OwnedSample>) {
    let start = match scenario.simulate.start {
        Start::Given => State { position: model.start_position.clone(), velocity: model.start_velocity.clone() },
        Start::Equilibrium => {
            State { position: found(scenario, model).position, velocity: vec![0.0; model.velocity_count()] }
        }
    };
    let scene = simulate::scene(model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: &scenario.text, statics: None });
    let summary = run(model, &scenario.simulate, scenario.record.rate, &start, &mut memory, &mut |_, _| true)
        .unwrap_or_else(|error| panic!("{}: {error}", scenario.name));
    (summary, memory.samples)
}

/// The coordinates of one hinge.
fn coordinates<'a>(model: &Model, position: &'a [f64], body: &str) -> &'a [f64] {
    let hinge = &model.bodies[model.body(body).expect("a body")].hinge;
    &position[hinge.position..hinge.position + hinge.kind.counts().0]
}

fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "found {found}, expected {expected} within {tolerance:e}");
}

#[test]
fn every_scenario_loads_without_warnings_and_keeps_its_energy() {
    let names = names();
    assert!(names.len() >= 12, "{names:?}");
    for name in &names {
        // Two seconds, or all of a story that is shorter: what moves for milliseconds takes minutes of seconds.
        let own = load_with(&file(name), &[]).unwrap_or_else(|error| panic!("{error}")).simulate.duration;
        let duration = own.min(2.0);
        let (scenario, model) = shipped(name, &[&format!("simulate.duration={duration}")]);
        assert!(scenario.warnings.is_empty(), "{name}: {}", scenario.warnings);
        assert!(!model.title.is_empty() && !scenario.text.starts_with("title"), "{name}: no title or no story");
        let (summary, samples) = simulated(&scenario, &model);
        assert_eq!(summary.end_time, duration, "{name}");
        // A stage has a sample just before and one just after it, beside those that are due.
        let mut times: Vec<f64> = samples.iter().map(|sample| sample.time).collect();
        times.dedup();
        let due = |time: f64| (time * scenario.record.rate - (time * scenario.record.rate).round()).abs() < 1e-9;
        times.retain(|time| model.stages.is_none() || due(*time));
        assert_eq!(times.len(), 1 + (duration * scenario.record.rate * (1.0 + f64::EPSILON)) as usize, "{name}");
        // The tolerances of the files are 1e-9 and smaller per step of error; some hundred steps add up.
        let kinetic = samples.iter().map(|sample| sample.energy.kinetic).fold(0.0, f64::max);
        let size = summary.energy_start.abs().max(model.total_mass() * G * model.length_scale()).max(kinetic);
        assert!(summary.energy_drift < 1e-7 * size, "{name}: drift {:e} of {size}", summary.energy_drift);
    }
}

/// Wherever it is guessed the chain of twenty hangs: every link straight down, the tip two metres below the ceiling of 2.5 m.
#[test]
fn the_chain_of_twenty_hangs_from_any_guess() {
    for (first, tenth) in [("3", "-2"), ("-1.5", "3"), ("0", "0")] {
        let changes = [format!("link[0].position={first}"), format!("link[10].position={tenth}")];
        let (scenario, model) = shipped("chain_of_twenty", &[&changes[0], &changes[1]]);
        let found = found(&scenario, &model);
        let tip = found.poses[19] * Point3::new(0.1, 0.0, 0.0);
        near(tip.z, 0.5, 1e-9);
        near(tip.x, 0.0, 1e-7);
        assert_eq!(found.stability.expect("an equilibrium").verdict, StabilityVerdict::Stable);
    }
}

#[test]
fn the_scenarios_show_every_hinge_and_every_force() {
    let texts: String = names().iter().map(|name| std::fs::read_to_string(file(name)).expect("a file")).collect();
    for feature in [
        "\"fixed\"",
        "\"revolute\"",
        "\"prismatic\"",
        "\"cylindrical\"",
        "\"universal\"",
        "\"planar\"",
        "\"spherical\"",
        "\"free\"",
        "\"spring\"",
        "\"bushing\"",
        "\"load\"",
        "axes = \"body\"",
        "density",
        "repeat",
        "next",
        "armature",
        "damping",
        "rest = ",
        "lock = true",
        "limits = {",
        "[[event]]",
        "rpy",
        "want = \"any\"",
        "box",
        "cylinder",
        "capsule",
        "sphere",
        "[model]",
        "[model.hinges]",
    ] {
        assert!(texts.contains(feature), "no scenario shows {feature}");
    }
}

/// K(k) by the arithmetic–geometric mean.
fn complete_elliptic_integral(modulus: f64) -> f64 {
    let (mut a, mut b) = (1.0, (1.0 - modulus * modulus).sqrt());
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    FRAC_PI_2 / a
}

/// Times at which the first coordinate passes zero upwards, by linear interpolation.
fn upward_passes(samples: &[OwnedSample]) -> Vec<f64> {
    let passes = samples.windows(2).filter(|pair| pair[0].positions[0] < 0.0 && pair[1].positions[0] >= 0.0);
    let between = |pair: &[OwnedSample]| {
        let (a, b) = (pair[0].positions[0], pair[1].positions[0]);
        pair[0].time + (pair[1].time - pair[0].time) * a / (a - b)
    };
    passes.map(between).collect()
}

#[test]
fn pendulum_swings_with_the_period_of_the_elliptic_integral() {
    let (scenario, model) = shipped("pendulum", &["record.rate=1000"]);
    let (_, samples) = simulated(&scenario, &model);
    let passes = upward_passes(&samples);
    let swings = passes.len() - 1;
    let period = (passes[swings] - passes[0]) / swings as f64;
    // Rod of 1 m: J/(m g c) = (1/3)/(g/2).
    let slow = (1.0 / 3.0 / (0.5 * G)).sqrt();
    let expected = 4.0 * slow * complete_elliptic_integral((PI / 6.0).sin());
    // The angle bends by (θ' Ω²) h²/8 ≈ 1e-8 rad between samples where it passes zero at 3.5 rad/s.
    near(period, expected, 1e-7);
    assert!(expected > 1.07 * TAU * slow, "60 degrees are no small angle");
}

/// The inputs of the crane by the moments of its weights about the hinges, worked out by hand.
#[test]
fn crane_is_held_by_the_moments_of_its_weights() {
    let (scenario, model) = shipped("crane_held", &[]);
    let (boom, jib) = (0.9_f64, 0.9_f64 - 0.5);
    // Masses of the boxes, and how far out along its own member each one stands.
    let masses = [1500.0 * 3.0 * 0.25 * 0.25, 1500.0 * 2.0 * 0.18 * 0.18, 2000.0 * 1.5 * 0.1 * 0.1, 250.0];
    let along_jib = [1.0, 0.5 + 0.8 + 0.75, 0.5 + 0.8 + 1.5];
    let about_elbow: f64 = (0..3).map(|i| masses[i + 1] * G * along_jib[i] * jib.cos()).sum();
    let outboard: f64 = masses[1..].iter().sum::<f64>() * G;
    let about_shoulder = about_elbow + (masses[0] * 1.5 * G + outboard * 3.0) * boom.cos();
    // The strut pushes from the foot to the lug: its arm is that of its line about the shoulder.
    let lug = [0.9 * boom.cos() + 0.1 * boom.sin(), 0.9 * boom.sin() - 0.1 * boom.cos()];
    let foot = [0.3, -1.5];
    let line = [lug[0] - foot[0], lug[1] - foot[1]];
    let length = line[0].hypot(line[1]);
    let arm = (lug[0] * line[1] - lug[1] * line[0]) / length;
    let value = |address: &str| {
        let one = &stillpoint::model::Parameter::find(&scenario.description, address).expect("an address")[0];
        one.value(&scenario.description)
    };
    // Twelve digits of numbers worked out with some ten roundings.
    near(value("jib.force"), about_elbow, 1e-12 * about_shoulder);
    near(value("telescope.force"), (masses[2] + masses[3]) * G * jib.sin(), 1e-12 * about_shoulder);
    near(value("strut.length"), length + about_shoulder / arm / 2.0e6, 1e-12);
    assert_eq!(found(&scenario, &model).position, model.start_position, "the pose is the one that was given");
}

/// The least preloads that carry a weight off the middle of four mounts lie in a plane over their corners.
#[test]
fn level_table_is_held_by_a_plane_of_preloads() {
    let (scenario, model) = shipped("level_table", &[]);
    let (plate, load) = (2700.0 * 1.4 * 0.04, 40.0);
    let weight = G * (plate + load);
    let middle = [0.3, -0.15].map(|at| at * load / (plate + load));
    for (name, [x, y]) in [
        ("front_left", [0.6, 0.4]),
        ("front_right", [0.6, -0.4]),
        ("rear_left", [-0.6, 0.4]),
        ("rear_right", [-0.6, -0.4]),
    ] {
        let address = format!("{name}.preload[2]");
        let one = &stillpoint::model::Parameter::find(&scenario.description, &address).expect("an address")[0];
        let expected = weight / 4.0 * (1.0 + middle[0] * x / 0.36 + middle[1] * y / 0.16);
        near(one.value(&scenario.description), expected, 1e-10 * weight);
    }
    let found = found(&scenario, &model);
    assert_eq!(found.position, model.start_position, "level, as it was given");
    // Springs of 25 N/mm at four corners under all of the weight; the modes about them are others.
    let heave = (4.0 * 2.5e4 / (plate + load)).sqrt() / TAU;
    let stability = found.stability.expect("modes");
    assert!(stability.modes.iter().any(|mode| (mode.frequency_hz - heave).abs() < 0.1 * heave));
}

#[test]
fn chain_hangs_straight_down_and_its_lowest_frequency_is_that_of_bernoulli() {
    let (scenario, model) = shipped("hanging_chain", &[]);
    let equilibrium = found(&scenario, &model);
    near(equilibrium.position[0], FRAC_PI_2, 1e-12);
    assert!(equilibrium.position[1..].iter().all(|angle| angle.abs() < 1e-12), "round-off of 5 m of chain");
    // A heavy string of length L: f = j₀ √(g/L) / 4π, j₀ the first zero of the Bessel function J₀. A chain of n links
    // that ends in a free link differs by a part in n².
    let bernoulli = 2.404_825_557_695_773 * (G / 5.0_f64).sqrt() / (2.0 * TAU);
    let modes = &equilibrium.stability.expect("a verdict").modes;
    near(modes[0].frequency_hz / bernoulli, 1.0, 1e-4);
}

/// Accelerations of two equal uniform rods of 0.5 m, angles from the vertical: Lagrange's equations by hand.
fn double_pendulum(y: [f64; 4]) -> [f64; 4] {
    let [one, two, fast_one, fast_two] = y;
    let (sine, cosine) = (one - two).sin_cos();
    let right = [
        -0.5 * sine * fast_two * fast_two - 1.5 * G / 0.5 * one.sin(),
        0.5 * sine * fast_one * fast_one - 0.5 * G / 0.5 * two.sin(),
    ];
    let (a, b, c) = (4.0 / 3.0, 0.5 * cosine, 1.0 / 3.0);
    let determinant = a * c - b * b;
    let first = (c * right[0] - b * right[1]) / determinant;
    [fast_one, fast_two, first, (a * right[1] - b * right[0]) / determinant]
}

/// Classical Runge–Kutta from rest, angles after `time`.
fn thrown(mut y: [f64; 4], time: f64) -> [f64; 2] {
    let step = 1e-4;
    let add = |y: [f64; 4], k: [f64; 4], h: f64| std::array::from_fn(|i| y[i] + h * k[i]);
    for _ in 0..(time / step).round() as usize {
        let a = double_pendulum(y);
        let b = double_pendulum(add(y, a, 0.5 * step));
        let c = double_pendulum(add(y, b, 0.5 * step));
        let d = double_pendulum(add(y, c, step));
        y = std::array::from_fn(|i| y[i] + step / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    [y[0], y[1]]
}

#[test]
fn double_pendulum_runs_part_exponentially() {
    let offset = 1e-8;
    let apart = |time: f64| {
        let at = |lower: f64| {
            let (given, duration) = (format!("lower.position={lower:e}"), format!("simulate.duration={time}"));
            let (scenario, model) = shipped(
                "double_pendulum",
                &[&given, &duration, "simulate.tolerance=1e-13", "simulate.absolute_tolerance=1e-13"],
            );
            let position = simulated(&scenario, &model).0.state.position;
            [position[0], position[0] + position[1]]
        };
        let (program, ours) =
            ([at(0.0), at(offset)], [0.0, offset].map(|x| thrown([FRAC_PI_2, FRAC_PI_2 + x, 0.0, 0.0], time)));
        // Errors of 1e-12 grow as the offset does: 1e-4 of what the two runs are apart, with room for accumulation.
        let size = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        let (distance, expected) = (size(program[0], program[1]), size(ours[0], ours[1]));
        near(distance / expected, 1.0, 1e-2);
        distance
    };
    let [early, late] = [2.0, 8.0].map(apart);
    // Growth in proportion to time would be a factor of four; this is some powers of ten.
    assert!(late > 100.0 * early && late < 0.1, "{early:e} {late:e}");
}

#[test]
fn pencil_falls_as_fast_as_its_eigenvalue_says() {
    // A slender pencil on its tip: λ² = m g c / J, J about the tip.
    let (mass, center, inertia): (f64, f64, f64) = (0.006, 0.0875, 1.53125e-5);
    let rate = (mass * G * center / (inertia + mass * center * center)).sqrt();
    let (scenario, model) = shipped("pencil", &[]);
    let equilibrium = found(&scenario, &model);
    let stability = equilibrium.stability.expect("a verdict");
    assert_eq!(stability.verdict, StabilityVerdict::Unstable);
    // Round-off of some products.
    near(stability.modes[0].growth_rate, rate, 1e-12 * rate);
    let thrown =
        ["simulate.start=given", "pencil.position=1e-6", "simulate.duration=0.8", "simulate.absolute_tolerance=1e-14"];
    let (scenario, model) = shipped("pencil", &thrown);
    let (_, samples) = simulated(&scenario, &model);
    let last = samples.last().expect("a sample");
    // Let go from rest: θ₀ cosh λ t; nonlinear terms are θ²/6 < 1e-6 of it.
    near(last.positions[0] / (1e-6 * (rate * last.time).cosh()), 1.0, 1e-6);
}

/// Where something hangs: masses and centres in space of a body and all that hangs on it.
fn carried(model: &Model, equilibrium: &Equilibrium, body: usize) -> (f64, Vector3<f64>) {
    let mut mass = 0.0;
    let mut moment = Vector3::zeros();
    for (index, one) in model.bodies.iter().enumerate() {
        let mut above = Some(index);
        while let Some(now) = above
            && now != body
        {
            above = model.bodies[now].parent;
        }
        if above.is_some() {
            mass += one.mass.mass;
            moment += one.mass.mass * (equilibrium.poses[index] * Point3::from(one.mass.center)).coords;
        }
    }
    (mass, moment / mass)
}

#[test]
fn calder_mobile_balances_every_arm() {
    let (scenario, model) = shipped("calder_mobile", &[]);
    let equilibrium = found(&scenario, &model);
    assert_eq!(equilibrium.stability.as_ref().expect("a verdict").verdict, StabilityVerdict::Stable);
    for (index, body) in model.bodies.iter().enumerate() {
        let hook = equilibrium.poses[index].translation.vector;
        let (mass, center) = carried(&model, &equilibrium, index);
        // All that hangs there has its weight right below the hook: moments about the two level axes cancel.
        assert!((center - hook).xy().norm() < 1e-12, "{}: {:?}", body.name, center - hook);
        assert!(center.z < hook.z, "{}", body.name);
        let reaction = equilibrium.reactions[index].force;
        assert!((reaction - Vector3::new(0.0, 0.0, mass * G)).norm() < 1e-10, "{}: {reaction:?}", body.name);
    }
    let tilt = |name: &str| {
        let pose = &equilibrium.poses[model.body(name).expect("an arm")];
        (pose * Vector3::x()).z.asin()
    };
    let arms = ["long_arm", "left_arm", "right_arm", "small_arm"].map(tilt);
    assert!(arms.iter().all(|tilt| tilt.abs() > 0.05 && tilt.abs() < 0.4), "unequal, and pleasant: {arms:?}");
}

#[test]
fn machine_on_mounts_sinks_by_weight_over_stiffness() {
    let (scenario, model) = shipped("machine_on_mounts", &[]);
    let equilibrium = found(&scenario, &model);
    let motor = 2700.0 * PI * 0.09 * 0.09 * 0.3;
    let (mass, stiffness) = (160.0 + motor, 4.0 * 150.0e3 + 2.0 * 50.0e3);
    let position = coordinates(&model, &equilibrium.position, "machine");
    near(position[2], 0.1 - mass * G / stiffness, 1e-12);
    assert!(
        position[..2].iter().chain(&position[4..]).all(|x| x.abs() < 1e-12),
        "upright, in the middle: {position:?}"
    );
    let modes = &equilibrium.stability.expect("a verdict").modes;
    assert_eq!(modes.len(), 6);
    let bounce = (stiffness / mass).sqrt() / TAU;
    // The coil springs stand upright and the mounts are symmetric: bouncing is a mode of its own.
    let closest = modes.iter().map(|mode| (mode.frequency_hz - bounce).abs()).fold(f64::INFINITY, f64::min);
    assert!(closest < 1e-9 * bounce, "{bounce} Hz is not among {modes:?}");
}

#[test]
fn spinning_top_precesses_at_the_rate_of_the_gyroscopic_formula() {
    let (scenario, model) = shipped("spinning_top", &[]);
    let (_, samples) = simulated(&scenario, &model);
    let (mass, center, spin, lean) = (0.2, 0.045, 150.0, 20.0_f64.to_radians());
    let (polar, across) = (1.8e-4, 1.1e-4 + mass * center * center);
    // Steady precession: A Ω² cos θ − C ω Ω + m g c = 0, the slow root.
    let (a, b, c) = (across * lean.cos(), polar * spin, mass * G * center);
    let rate = 2.0 * c / (b + (b * b - 4.0 * a * c).sqrt());
    assert!((rate / (c / b) - 1.0) < 0.1, "close to the formula of the fast top, m g c / C ω");
    for sample in samples.iter().step_by(100) {
        let p = coordinates(&model, &sample.positions, "top");
        let turn = UnitQuaternion::new_normalize(Quaternion::new(p[0], p[1], p[2], p[3]));
        let axis = turn * Vector3::z();
        let angle = rate * sample.time;
        let expected = Vector3::new(lean.sin() * angle.cos(), lean.sin() * angle.sin(), lean.cos());
        // A tolerance of 1e-10 per step, some thousand steps, and growth in proportion to time.
        assert!((axis - expected).norm() < 1e-6, "at {} s: {axis:?}, expected {expected:?}", sample.time);
    }
}

#[test]
fn gyroscope_stays_level_and_turns_at_weight_times_arm_over_spin() {
    let (scenario, model) = shipped("gyroscope_in_gimbals", &[]);
    let (_, samples) = simulated(&scenario, &model);
    let rate = 0.1 * G * 0.15 / (0.001 * 200.0);
    for sample in &samples {
        // A tolerance of 1e-10 per step and some thousand steps.
        near(coordinates(&model, &sample.positions, "inner_ring")[0], 0.0, 1e-7);
        near(coordinates(&model, &sample.positions, "outer_ring")[0], rate * sample.time, 1e-6);
    }
    let without = ["weight.mass=0", "outer_ring.velocity=0", "inner_ring.velocity=0.01"];
    let (scenario, model) = shipped("gyroscope_in_gimbals", &without);
    let (_, samples) = simulated(&scenario, &model);
    let astray = samples.iter().map(|s| coordinates(&model, &s.positions, "inner_ring")[0].abs()).fold(0.0, f64::max);
    // Without the weight a push nods it by J ω₀ / (C Ω) at most, J some thousandths of kg m²: it does not go astray.
    assert!(astray < 0.01 * 0.004 / (0.001 * 200.0), "{astray}");
}

#[test]
fn spring_arm_needs_no_lock_to_keep_its_direction() {
    let (scenario, model) = shipped("spring_arm", &[]);
    let equilibrium = found(&scenario, &model);
    let (name, held) = &equilibrium.holding[0];
    assert_eq!((equilibrium.holding.len(), name.as_str()), (1, "`column`"));
    // All forces are in one plane with the column's axis; round-off of 100 N at 1 m.
    assert!(held.abs() < 1e-12, "{held:e}");
    let reach = |name: &str| equilibrium.poses[model.body(name).expect("a body")].translation.vector;
    let (elbow, lamp) = (reach("forearm"), reach("lamp"));
    for point in [elbow, lamp] {
        near(point.y.atan2(point.x), 0.6, 1e-12);
    }
    // The springs do lift the arm: it reaches out, about level, by more than its upper half.
    assert!(lamp.xy().norm() > 0.9 && (lamp.z - 0.7).abs() < 0.2, "{lamp:?}");
    // The column carries the lot: its own weight, the arm's and the bag's, less what the ceiling spring lifts.
    let bracket = equilibrium.poses[model.body("upper_arm").expect("a body")] * Point3::new(0.3, 0.0, 0.0);
    let stretch = Point3::new(0.0, 0.0, 1.3) - bracket;
    let lift = 330.0 * (stretch.norm() - 0.3) * stretch.z / stretch.norm();
    let floor = equilibrium.reactions[model.body("column").expect("a body")].force.z;
    near(floor, model.total_mass() * G + 5.0 - lift, 1e-10);
}

#[test]
fn fan_holds_its_arm_where_weight_and_thrust_cancel() {
    let (scenario, model) = shipped("fan_pendulum", &[]);
    let equilibrium = found(&scenario, &model);
    assert_eq!(equilibrium.stability.as_ref().expect("a verdict").verdict, StabilityVerdict::Stable);
    // F l = (m_arm c + m_fan l) g sin θ, the thrust always across the arm.
    let angle = (4.0 * 0.8 / ((0.4 * 0.4 + 0.6 * 0.8) * G)).asin();
    near(equilibrium.position[0], angle, 1e-12);
}

#[test]
fn caster_table_stands_where_the_pulls_of_its_ropes_cancel() {
    let (scenario, model) = shipped("caster_table", &[]);
    let equilibrium = found(&scenario, &model);
    let p = coordinates(&model, &equilibrium.position, "table");
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), p[2]);
    let table = Isometry3::from_parts(Translation3::new(p[0], p[1], 0.72), turn);
    let ropes = [
        ([0.0, 1.6], [0.0, 0.38], 120.0, 0.9),
        ([-1.8, -1.2], [-0.58, -0.38], 90.0, 1.0),
        ([1.8, -1.2], [0.58, -0.38], 90.0, 1.0),
    ];
    let edge = table * Point3::new(0.6, 0.1, 0.0);
    let push = Vector3::new(-15.0, 5.0, 0.0);
    let (mut force, mut moment) = (push, edge.coords.cross(&push));
    for (wall, corner, stiffness, length) in ropes {
        let at = table * Point3::new(corner[0], corner[1], 0.0);
        let away = Point3::new(wall[0], wall[1], 0.72) - at;
        let pull = away.normalize() * stiffness * (away.norm() - length);
        force += pull;
        moment += at.coords.cross(&pull);
    }
    // Round-off of 50 N at 1 m.
    assert!(force.norm() < 1e-11 && moment.z.abs() < 1e-11, "{force:?} {moment:?}");
    assert!(push.norm() > 10.0 && p.iter().all(|x| x.abs() < 0.2), "pushed aside, not away: {p:?}");
}

#[test]
fn collar_slides_until_the_spring_carries_its_weight_and_turns_its_arm_down() {
    let (scenario, model) = shipped("collar_on_a_rod", &[]);
    let equilibrium = found(&scenario, &model);
    let p = coordinates(&model, &equilibrium.position, "collar");
    // Along a rod that slants by 30 degrees; relaxed at 1 m.
    near(p[0], 1.0 - 2.0 * G * 0.5 / 60.0, 1e-12);
    let pose = &equilibrium.poses[model.body("collar").expect("a body")];
    let arm = pose * Vector3::x();
    let rod = pose * Vector3::z();
    // Of all directions across the rod the arm takes the lowest one.
    near(arm.z, -(1.0 - rod.z * rod.z).sqrt(), 1e-12);
}

/// The knees of the jack come together by the pitch of the thread, and the drive pushes with what virtual work says: a load
/// `W` on arms of length `L` with half the width `c` takes `W p c/√(L² − c²)`.
#[test]
fn the_screw_of_the_jack_lifts_the_car() {
    let (scenario, model) = shipped("scissor_jack", &[]);
    let (arm, pitch) = (0.2_f64, 4e-3 / TAU);
    let height = |half: f64| 2.0 * (arm * arm - half * half).sqrt();
    let equilibrium = found(&scenario, &model);
    near(coordinates(&model, &equilibrium.position, "car")[0], height(0.16), 1e-12);
    // Arms lift at a quarter and at three quarters of the height, what the knees carry at half of it.
    let weight = G * (400.0 + 2.0 * 0.8 + 0.5 * (0.2 + 0.5 + 0.2));
    near(equilibrium.drive_forces[0].1, weight * pitch * 0.16 / (0.5 * height(0.16)), 1e-9);
    let (summary, samples) = simulated(&scenario, &model);
    for sample in &samples {
        let turned = coordinates(&model, &sample.positions, "rod")[0];
        near(coordinates(&model, &sample.positions, "car")[0], height(0.16 - 0.5 * pitch * turned), 1e-11);
        near(coordinates(&model, &sample.positions, "nut")[0], 80.0 * TAU - turned, 1e-9);
    }
    near(coordinates(&model, &summary.state.position, "car")[0], 0.32, 1e-11);
}

/// Grashof's rule: the crank turns round, the rocker stays between the two angles at which crank and coupler lie in one
/// line (cosine rule).
#[test]
fn the_crank_turns_and_the_rocker_swings() {
    let (scenario, model) = shipped("four_bar", &[]);
    let (summary, samples) = simulated(&scenario, &model);
    let (crank, coupler, rocker, ground) = (0.1_f64, 0.35_f64, 0.3_f64, 0.4_f64);
    let reach = |across: f64| {
        let cosine = (rocker * rocker + ground * ground - across * across) / (2.0 * rocker * ground);
        // From upright, towards +x: the rocker stands at the right end of the ground bar.
        cosine.acos() - FRAC_PI_2
    };
    let (left, right) = (reach(coupler - crank), reach(coupler + crank));
    let swing: Vec<f64> = samples.iter().map(|sample| coordinates(&model, &sample.positions, "rocker")[0]).collect();
    let (lowest, highest) = swing.iter().fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
    // Sampled at 100 per second: the ends of a swing are missed by at most ½ · acceleration · (5 ms)².
    assert!(lowest >= left - 1e-12 && lowest < left + 2e-3, "{lowest} {left}");
    assert!(highest <= right + 1e-12 && highest > right - 2e-3, "{highest} {right}");
    assert!(coordinates(&model, &summary.state.position, "crank")[0] > 4.0 * TAU);
    assert!(summary.constraint_error < 1e-13, "{:e}", summary.constraint_error);
}

/// The slider is where the crank's angle puts it, through every dead centre.
#[test]
fn the_slider_follows_its_crank() {
    let (scenario, model) = shipped("slider_crank", &[]);
    let (summary, samples) = simulated(&scenario, &model);
    let (crank, rod) = (0.1_f64, 0.3_f64);
    for sample in &samples {
        let angle = coordinates(&model, &sample.positions, "crank")[0];
        let slider = coordinates(&model, &sample.positions, "slider")[0];
        near(slider, crank * angle.cos() + (rod * rod - (crank * angle.sin()).powi(2)).sqrt(), 1e-12);
    }
    let turned = coordinates(&model, &summary.state.position, "crank")[0];
    assert!(turned > 10.0 * TAU, "{turned}");
}

/// The published benchmark: its end state, to the digits that the published one has.
#[test]
fn the_squeezer_reaches_the_published_end() {
    let (scenario, model) = shipped("andrews_squeezer", &[]);
    let (summary, _) = simulated(&scenario, &model);
    let published = [
        ("crank", 15.810_771_09),
        ("rod", -15.756_371_05),
        ("spring plate", 0.040_822_240_13),
        ("lower link", -0.534_730_116_3),
        ("lower arm", 0.524_409_965_9),
        ("upper link", 0.534_730_116_3),
        ("upper arm", 1.048_080_741),
    ];
    for (body, angle) in published {
        near(coordinates(&model, &summary.state.position, body)[0], angle, 2e-7);
    }
}

/// Opposite hinges of Bricard's ring turn alike, and neighbours obey sin q + sin p + sin q sin p = 0.
#[test]
fn bricards_ring_keeps_its_relation_while_it_swings() {
    let (scenario, model) = shipped("bricard", &[]);
    let (_, samples) = simulated(&scenario, &model);
    let mut widest = 0.0_f64;
    for sample in &samples {
        let angle = |i: usize| coordinates(&model, &sample.positions, &format!("bar{i}"))[0];
        let (q, p) = (angle(0), angle(1));
        near(angle(2), q, 1e-9);
        near(angle(3), p, 1e-9);
        near(q.sin() + p.sin() + q.sin() * p.sin(), 0.0, 1e-9);
        widest = widest.max(q);
    }
    assert!(widest > 3.0, "{widest}");
}

/// Porter's formula: the balls hang h = (1 + M/m) g/ω² below the top, and stay there.
#[test]
fn the_governor_hangs_where_porters_formula_says() {
    let (scenario, model) = shipped("flyball_governor", &[]);
    let found = found(&scenario, &model);
    let height = (1.0 + 2.0 / 1.0) * G / (12.0 * 12.0);
    // The balls are points but for an inertia of 0.4 g m², a part in 200 of theirs about the hinge, symmetric: no moment.
    near(0.3 * coordinates(&model, &found.position, "left")[0].sin(), height, 1e-12);
    assert_eq!(found.velocity[model.bodies[model.body("shaft").expect("a body")].hinge.velocity], 12.0);
    let (_, samples) = simulated(&scenario, &model);
    for sample in samples {
        near(0.3 * coordinates(&model, &sample.positions, "right")[0].sin(), height, 1e-9);
        near(coordinates(&model, &sample.positions, "shaft")[0], 12.0 * sample.time, 1e-10);
    }
}

/// Every turn of the crank brings the toe back to where it was, and its step is long and flat.
#[test]
fn the_strandbeest_walks() {
    // All of its minute where that is no long time.
    let shortened: &[&str] = if cfg!(debug_assertions) { &["simulate.duration=10"] } else { &[] };
    let (scenario, model) = shipped("strandbeest_leg", shortened);
    let (summary, samples) = simulated(&scenario, &model);
    assert!(summary.constraint_error < 1e-12, "{:e}", summary.constraint_error);
    let foot = model.body("foot").expect("a body");
    let toe = |sample: &OwnedSample| sample.bodies[foot] * Point3::new(0.774659, 0.0, -4.838378);
    let first: Vec<Point3<f64>> = samples[..50].iter().map(toe).collect();
    for (i, sample) in samples.iter().enumerate() {
        near((toe(sample) - first[i % 50]).norm(), 0.0, 1e-8);
    }
    let lowest = first.iter().map(|p| p.z).fold(f64::MAX, f64::min);
    let highest = first.iter().map(|p| p.z).fold(f64::MIN, f64::max);
    let along: Vec<f64> = first.iter().filter(|p| p.z < lowest + 0.15).map(|p| p.x).collect();
    let step = along.iter().fold(f64::MIN, |m, x| m.max(*x)) - along.iter().fold(f64::MAX, |m, x| m.min(*x));
    // Jansen's step: some four decimetres long within 15 mm of height, lifted by more than one decimetre between.
    assert!(step > 3.5 && highest - lowest > 1.0, "step {step}, lift {}", highest - lowest);
}

/// At rest the tyre carries all that stands on it; after the bump the car comes back.
#[test]
fn the_tyre_carries_the_car_and_the_bump_passes() {
    let (scenario, model) = shipped("double_wishbone", &["simulate.duration=12"]);
    let found = found(&scenario, &model);
    let weight = (350.0 + 6.0 + 25.0 + 4.0) * G;
    let upright = found.poses[model.body("upright").expect("a body")];
    let hub = upright * Point3::new(0.0, 0.08, 0.08) - Point3::new(0.0, 0.79, 0.0);
    let pressed = 200_000.0 * (0.32 - hub.norm());
    near(pressed * hub.z / hub.norm(), weight, 1e-6 * weight);
    let (summary, samples) = simulated(&scenario, &model);
    let heave = |position: &[f64]| coordinates(&model, position, "chassis")[0];
    let rest = heave(&found.position);
    let largest = samples.iter().map(|s| (heave(&s.positions) - rest).abs()).fold(0.0, f64::max);
    assert!(largest > 0.005, "{largest}");
    // The heave of 0.83 Hz is damped by the strut; eleven seconds leave less than a thousandth of it.
    near(heave(&summary.state.position), rest, 1e-3 * largest);
}

/// The boom's cylinder pushes what the moments of all weights about the boom's pin ask for; nothing moves.
#[test]
fn the_excavator_stays_and_its_cylinders_push_what_they_must() {
    let (scenario, model) = shipped("excavator", &[]);
    let found = found(&scenario, &model);
    assert_eq!(model.degrees_of_freedom(), 0);
    // All that hangs on the boom: its own moment about the pin at its foot, the piston of the boom being cut off.
    let pin = Point3::new(0.0, 0.0, 1.5);
    let place = |body: &str| found.poses[model.body(body).expect("a body")];
    let carried = ["boom", "stick", "bucket", "stick barrel", "stick piston", "bucket barrel", "bucket piston"];
    let moment: f64 = carried
        .iter()
        .map(|name| {
            let mass = &model.bodies[model.body(name).expect("a body")].mass;
            mass.mass * G * ((place(name) * Point3::from(mass.center)) - pin).x
        })
        .sum();
    // The cylinder pushes along its line; barrel and piston hang between its pins, half of their moments each way.
    let (foot, eye) = (Point3::new(0.6, 0.0, 0.9), place("boom") * Point3::new(1.4, 0.0, -0.1));
    let line = (eye - foot).normalize();
    let cylinder: f64 = ["boom barrel", "boom piston"]
        .iter()
        .map(|name| {
            let mass = &model.bodies[model.body(name).expect("a body")].mass;
            mass.mass * G * ((place(name) * Point3::from(mass.center)) - foot).x
        })
        .sum();
    let length = (eye - foot).norm();
    // Across the line the eye carries the share of the cylinder's weight that its foot does not.
    let across = Vector3::new(-line.z, 0.0, line.x);
    let side = -cylinder / length;
    let lever = |direction: &Vector3<f64>| (eye - pin).x * direction.z - (eye - pin).z * direction.x;
    let along = (moment - side * lever(&across)) / lever(&line);
    let mut system = stillpoint::dynamics::System::new(&model);
    let mut a = vec![0.0; model.velocity_count()];
    system.at(0.0, &found.position, &found.velocity).accelerations(&mut a).expect("accelerations");
    let rows = system.constraints().expect("rows");
    let (_, force) = rows.drive_forces(&model, &a).find(|(name, _)| name == "boom valve").expect("the drive");
    // The drive also carries the piston's weight along the line.
    let piston = 40.0 * G * line.z;
    near(force, along + piston, 1e-6 * along.abs());
    let (_, samples) = simulated(&scenario, &model);
    let moved = samples.iter().flat_map(|s| s.positions.iter().zip(&found.position).map(|(a, b)| (a - b).abs()));
    assert!(moved.fold(0.0, f64::max) < 1e-11);
}

/// Torque of the weights that hang on a hinge about its axis, from the poses that statics found.
fn weight_about(model: &Arc<Model>, found: &Equilibrium, hinge: &str) -> f64 {
    let mut system = stillpoint::dynamics::System::new(model);
    let mut poses = Vec::new();
    system.at(0.0, &found.position, &vec![0.0; model.velocity_count()]).poses(&mut poses);
    let carrier = model.body(hinge).expect("a body");
    let stillpoint::model::description::HingeKind::Revolute { axis } = model.bodies[carrier].hinge.kind else {
        panic!("`{hinge}` turns")
    };
    let axis = poses[carrier] * axis;
    let carried = |mut body: usize| loop {
        if body == carrier {
            return true;
        }
        match model.bodies[body].parent {
            Some(parent) => body = parent,
            None => return false,
        }
    };
    let torque = |index: usize| {
        let body = &model.bodies[index];
        let arm = (poses[index] * Point3::from(body.mass.center)).coords - poses[carrier].translation.vector;
        arm.cross(&Vector3::new(0.0, 0.0, -body.mass.mass * G)).dot(&axis)
    };
    (0..model.bodies.len()).filter(|body| carried(*body)).map(torque).sum()
}

/// Every joint of the arm twists its spring by the moment of what hangs on it.
#[test]
fn arm_out_of_a_urdf_sags_by_its_weights() {
    let (scenario, model) = shipped("arm_from_urdf", &[]);
    assert_eq!(scenario.models.len(), 1);
    let found = found(&scenario, &model);
    assert_eq!(found.stability.as_ref().expect("an equilibrium").verdict, StabilityVerdict::Stable);
    let springs = [
        ("turret", 150.0, 0.0),
        ("upper_arm", 900.0, 0.5),
        ("forearm", 500.0, 1.1),
        ("wrist", 150.0, 0.0),
        ("hand", 150.0, 0.6),
        ("flange", 150.0, 0.0),
    ];
    for (body, stiffness, rest) in springs {
        let angle = coordinates(&model, &found.position, body)[0];
        near(stiffness * (angle - rest), weight_about(&model, &found, body), 1e-9);
    }
    // It does sag: 2 kg at the end of 0.8 m are not held for nothing.
    assert!(coordinates(&model, &found.position, "upper_arm")[0] > 0.54);
}

/// The jaws stay upright, one finger mirrors the other, and the spring between them carries all weights.
#[test]
fn gripper_out_of_a_urdf_opens_in_parallel() {
    let (scenario, model) = shipped("gripper_from_urdf", &[]);
    let found = found(&scenario, &model);
    let at = |body: &str| coordinates(&model, &found.position, body)[0];
    let angle = at("left_crank");
    near(at("right_crank"), -angle, 1e-12);
    for side in ["left", "right"] {
        near(at(&format!("{side}_crank")) + at(&format!("{side}_jaw")), 0.0, 1e-10);
        near(at(&format!("{side}_rocker")), at(&format!("{side}_crank")), 1e-10);
    }
    // Virtual work: per finger two bars lift half as far as the jaw on its circle of 60 mm; the spring reaches from jaw
    // to jaw, 0.04 m apart where the cranks hang straight down.
    let lift = 2.0 * (2.0 * 0.05 * 0.03 + 0.12 * 0.06) * G * angle.sin();
    let distance = 0.04 + 2.0 * 0.06 * angle.sin();
    let push = 200.0 * (0.11 - distance) * 2.0 * 0.06 * angle.cos();
    near(push, lift, 1e-9);
    assert!(angle > 0.2, "it opens");
}

/// Motors hold an arm at rest from the first step on: what it sags by is what their springs need to carry the weight.
#[test]
fn robot_holds_from_the_first_step() {
    let (scenario, model) = shipped("robot_holds", &[]);
    let rest = found(&scenario, &model);
    let angle = |body: &str| coordinates(&model, &rest.position, body)[0];
    let (shoulder, elbow, grip) = (angle("upper_arm"), angle("forearm"), angle("finger"));
    let reach = |length: f64, bend: f64| length * bend.sin();
    let bend = shoulder + elbow;
    let beyond_elbow = G * (3.0 * reach(0.17, bend) + 0.3 * reach(0.35 + grip + 0.05, bend));
    let beyond_shoulder = beyond_elbow + G * (5.0 * reach(0.2, shoulder) + 3.3 * reach(0.4, shoulder));
    near(1500.0 * (0.9 - shoulder), -beyond_shoulder, 1e-9);
    near(700.0 * (0.8 - elbow) - 8.0, -beyond_elbow, 1e-9);
    near(2000.0 * grip, 20.0 - 0.3 * G * bend.cos(), 1e-9);
    let (summary, samples) = simulated(&scenario, &model);
    for sample in &samples {
        for (now, start) in sample.positions.iter().zip(&rest.position) {
            near(*now, *start, 1e-9);
        }
    }
    // The work of forces of 25 N m at speeds that are zero to the tolerance of the run only.
    assert!(summary.energy_drift < 1e-6, "{:e}", summary.energy_drift);
}

/// A motor runs up to where its characteristic meets what the load asks for; its work is in the energy ledger.
#[test]
fn winch_runs_up_to_the_speed_of_its_load() {
    let (scenario, model) = shipped("winch", &["simulate.tolerance=1e-8"]);
    let (summary, _) = simulated(&scenario, &model);
    let speed = summary.state.velocity[model.body("load").map_or(0, |body| model.bodies[body].hinge.velocity)];
    let rate = speed / 0.1;
    assert!(rate > 5.0, "on the second line of the table: {rate}");
    near((120.0 - 8.0 * rate) / 0.1, 40.0 * G + 60.0 * speed * speed, 1e-2);
    assert!(summary.energy_end - summary.energy_start > 1000.0);
    // The quadrature of the work over steps across the corner of the table.
    assert!(summary.energy_drift < 1e-3, "{:e}", summary.energy_drift);
}

/// A chain between two walls hangs in the figure of constant horizontal pull: the slopes of its links fall evenly.
#[test]
fn suspended_chain_hangs_with_constant_horizontal_pull() {
    let (scenario, model) = shipped("suspended_chain", &[]);
    let rest = found(&scenario, &model);
    let mut angle = 0.0;
    let slopes = rest.position.iter().map(|turn| {
        angle += turn;
        angle.tan()
    });
    let slopes: Vec<f64> = slopes.collect();
    let fall = slopes[0] - slopes[1];
    assert!(fall > 0.01);
    for pair in slopes.windows(2) {
        near(pair[0] - pair[1], fall, 1e-9);
    }
    // Both walls carry half.
    near(rest.reactions[0].force.z, 0.5 * 50.0 * 0.05 * G, 1e-9);
}

/// Six motors hold a platform that cannot turn, at the height where weights and springs balance along its one way down.
#[test]
fn stewart_platform_rests_over_constrained() {
    let (scenario, model) = shipped("stewart_platform", &[]);
    let (model, assembly) = stillpoint::constraint::assemble(model).expect("an assembly");
    assert_eq!(assembly.degrees_of_freedom, 3);
    assert_eq!(assembly.redundant.iter().map(|(_, redundant, _)| redundant).sum::<usize>(), 3);
    let rest = found(&scenario, &model);
    let height = coordinates(&model, &rest.position, "platform")[2];
    // By virtual work: a leg of length L leans by a horizontal 0.4 m; its cylinder's weight sits 0.3 m up, its rod's
    // 0.25 m below its head.
    let energy = |h: f64| {
        let length = h.hypot(0.4);
        let spring = 0.5 * 40_000.0 * (0.9849 - length).powi(2);
        60.0 * G * h + 6.0 * (4.0 * G * 0.3 * h / length + 2.0 * G * (length - 0.25) * h / length + spring)
    };
    let slope = (energy(height + 1e-5) - energy(height - 1e-5)) / 2e-5;
    near(slope, 0.0, 1e-5);
    let (summary, samples) = simulated(&scenario, &model);
    for sample in &samples {
        near(sample.positions[model.bodies[model.body("platform").expect("it")].hinge.position + 2], height, 1e-9);
    }
    assert!(summary.constraint_error < 1e-12, "{:e}", summary.constraint_error);
}

/// What the first universal joint spoils the second mends: the driven shaft turns as the driving one, the shaft between
/// by `tan(angle) = tan(turn) cos(bend)`, and it takes no power on the whole.
#[test]
fn double_cardan_turns_evenly() {
    let (scenario, model) = shipped("double_cardan", &["simulate.tolerance=1e-10"]);
    assert_eq!(stillpoint::constraint::assemble(model.clone()).expect("an assembly").1.redundant[0].1, 1);
    let (summary, samples) = simulated(&scenario, &model);
    let at = |name: &str| model.body(name).expect("a body");
    for sample in &samples {
        let x = |body: usize| sample.bodies[body].rotation * Vector3::x();
        let (driving, driven) = (x(at("driving")), x(at("driven")));
        near(driving.dot(&driven), 1.0, 1e-12);
        near(driving.cross(&driven).norm(), 0.0, 1e-8);
        // About the axis of the shaft between, from the direction its yoke had at the start.
        let between = &sample.bodies[at("between")].rotation;
        let turn = TAU * sample.time;
        let yoke = between * Vector3::x();
        let expected = (turn.tan() * 0.5_f64.cos()).atan();
        let found = yoke.dot(&Vector3::new(0.0, 0.5_f64.cos(), 0.5_f64.sin())).atan2(yoke.x);
        near((found - expected - ((found - expected) / PI).round() * PI).abs(), 0.0, 1e-8);
    }
    assert!(summary.constraint_error < 1e-13 && summary.energy_drift < 1e-6);
}

/// Three cranks stay parallel through every change point, though each could leave the others there.
#[test]
fn coupled_cranks_pass_their_change_points() {
    for method in ["dop853", "rk4", "sdirk4", "radau9"] {
        let method = format!("simulate.integrator={method:?}");
        let (scenario, model) = shipped("coupled_cranks", &[&method, "simulate.tolerance=1e-8"]);
        let (summary, samples) = simulated(&scenario, &model);
        let turned = coordinates(&model, &summary.state.position, "crank0")[0];
        assert!(turned > 2.0 * TAU, "several change points: {turned}");
        for sample in &samples {
            for crank in ["crank1", "crank2"] {
                let one = coordinates(&model, &sample.positions, "crank0")[0];
                near(coordinates(&model, &sample.positions, crank)[0], one, 1e-7);
            }
        }
        assert!(summary.energy_drift < 1e-4, "{method}: {:e}", summary.energy_drift);
    }
}

/// Strands of one kind on one rail swing alike, whichever thread computes them, and the lowest bead of each lags behind the rail.
#[test]
fn strands_of_the_bead_curtain_swing_alike() {
    let (scenario, model) = shipped("bead_curtain", &["simulate.duration=0.2"]);
    let halves = model.halves.as_ref().expect("two halves");
    assert_eq!(halves.links.each_ref().map(|half| half.len()), [1080, 1080]);
    let (summary, _) = simulated(&scenario, &model);
    let strand = |name: &str| {
        let first = model.bodies[model.body(&format!("{name}[0]")).expect("a strand")].hinge.position;
        &summary.state.position[first..first + 90]
    };
    let (first, last) = (strand("strand00"), strand("strand23"));
    // Their places on the rail differ along its axis only, which no product there sees but by rounding.
    assert!(first.iter().zip(last).all(|(x, y)| (x - y).abs() < 1e-12));
    assert!(first[0] > 1e-3, "the rail swings back, the strands do not follow at once: {}", first[0]);
}

/// A rope has one tension: two equal parts carry the load, and what stretches it is the counterweight.
#[test]
fn load_hangs_in_the_bight_of_its_rope() {
    let (scenario, model) = shipped("rope_over_pulleys", &[]);
    let rest = found(&scenario, &model);
    assert_eq!(rest.stability.as_ref().map(|stability| stability.verdict), Some(StabilityVerdict::Stable));
    // sin = 36 / (2 · 30), so the hook hangs 0.75 m below pulleys that are 1 m to either side.
    let [x, y, angle] = coordinates(&model, &rest.position, "load")[..] else { panic!("three coordinates") };
    near(x, 0.0, 1e-9);
    near(1.2 + y, 2.0 - 0.75, 1e-9);
    near(angle, 0.0, 1e-9);
    // The rest of the path is the counterweight's.
    let path = 6.0 + 30.0 * G / 4e4;
    near(coordinates(&model, &rest.position, "counterweight")[0], 1.35 + 2.5 + 2.0 - path, 1e-9);
}

/// Both strings go slack and taut in turns, and a slack string leaves the arm alone.
#[test]
fn strings_of_the_marionette_go_slack_in_turns() {
    use stillpoint::simulate::events::Kind;
    let (scenario, model) = shipped("marionette", &[]);
    let (summary, _) = simulated(&scenario, &model);
    for name in ["elbow string", "hand string"] {
        let kinds: Vec<Kind> =
            summary.events.iter().filter(|event| event.name == name).map(|event| event.kind).collect();
        assert!(kinds.len() >= 4, "{name}: {kinds:?}");
        for (index, kind) in kinds.iter().enumerate() {
            assert_eq!(*kind, Kind::Force(["slack", "taut"][index % 2]), "{name}: {kinds:?}");
        }
    }
    for event in summary.events.iter().filter(|event| event.kind == Kind::Force("taut")) {
        // k e + c ė = 0: it begins to pull just before it is as long as it is.
        near(500.0 * (event.value - 0.5) + 2.0 * event.speed, 0.0, 1e-6);
        assert!(event.speed > 0.0, "{event}");
    }
}

/// At rest the curves carry the weights; through the bump the damper takes out what the ledger says.
#[test]
fn quarter_car_sinks_by_its_curves() {
    // Straight tables can be read by hand.
    let (scenario, model) = shipped("quarter_car", &["car.spring.interpolation=linear", "tyre.interpolation=linear"]);
    let rest = found(&scenario, &model);
    near(coordinates(&model, &rest.position, "car")[0], 0.9 - 0.1 - (400.0 * G - 2100.0) / 21_000.0, 1e-9);
    near(coordinates(&model, &rest.position, "wheel")[0], -0.01 - (440.0 * G - 2000.0) / 225_000.0, 1e-9);
    let (scenario, model) = shipped("quarter_car", &[]);
    let (summary, samples) = simulated(&scenario, &model);
    assert!(summary.dissipated > 1.0, "{}", summary.dissipated);
    let travel = samples.iter().map(|sample| coordinates(&model, &sample.positions, "car")[0] - 0.9);
    let deepest = travel.fold(0.0, f64::min);
    // It meets the bump stop, and not its end.
    assert!(deepest < -0.2 && deepest > -0.3, "{deepest}");
}

/// Every rod carries the weight of one plank, and the cable pulls along the bridge as a parabola does; with one plank four times
/// heavier it takes another pose, and towers and banks carry all weights.
#[test]
fn the_suspension_bridge_hangs_on_a_parabola() {
    let (scenario, model) = shipped("suspension_bridge", &[]);
    let rest = found(&scenario, &model);
    assert_eq!(rest.stability.as_ref().expect("an equilibrium").verdict, StabilityVerdict::Stable);
    let (plank, link, span, sag, distance) = (50.0 * G, 2.0 * G, 36.0, 4.5, 1.0);
    let pulls = |rest: &Equilibrium| -> Vec<f64> {
        let hangers = rest.loops.iter().filter(|one| one.name.starts_with("hanger"));
        hangers.map(|one| one.pull.expect("of a rod")).collect()
    };
    let along = (plank + link) * span * span / (8.0 * sag * distance);
    // The certificate says what rounding may leave of the balance; what a node carries is a second difference (weights 1, −2, 1)
    // of moments that add up along 36 links.
    let round_off = 4.0 * 36.0 * rest.round_off * along;
    assert!(round_off < 1e-7 * plank, "{round_off}");
    assert_eq!(pulls(&rest).len(), 35);
    pulls(&rest).iter().for_each(|pull| near(*pull, plank, round_off));
    let tower = rest.loops.iter().find(|one| one.name == "far tower").expect("the loop");
    near(tower.force.x.abs(), along, round_off);
    // Half of all weights on either side: half a plank at the bank is held by its support.
    near(tower.force.z.abs(), 0.5 * (35.0 * plank + 36.0 * link), round_off);
    // A load on one plank: all that hangs on the cable is still carried, and statics has to move.
    let (scenario, model) = shipped("suspension_bridge", &["deck[9].mass=200"]);
    let loaded = found(&scenario, &model);
    assert!(loaded.iterations > 0, "it moves");
    assert_eq!(loaded.stability.as_ref().expect("an equilibrium").verdict, StabilityVerdict::Stable);
    let upward: f64 = loaded.reactions[0].force.z + loaded.reactions[36].force.z;
    let far: f64 = loaded.loops.iter().filter(|one| one.name.starts_with("far")).map(|one| one.force.z).sum();
    let weights = (35.0 * 50.0 + 200.0 + 36.0 * 2.0) * G;
    near((upward - far).abs(), weights, round_off);
}
