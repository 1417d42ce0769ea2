//! What drives, motors, gears and loops carry, and how it is shared where it is not unique.

use super::{FOUR_BAR, coordinate, read};
use nalgebra::Vector3;
use std::sync::Arc;
use stillpoint::constraint::LoopReaction;
use stillpoint::dynamics::System;
use stillpoint::integrate::Method;
use stillpoint::model::Model;
use stillpoint::record::{Memory, Opening, OwnedSample, Scene};
use stillpoint::simulate::{self, Integrator, Settings, State};

/// A run from the start as given, recorded.
fn recorded(model: &Arc<Model>, duration: f64, rate: f64) -> (Scene, Vec<OwnedSample>) {
    let settings = Settings {
        duration,
        integrator: Integrator::Method(Method::Dop853),
        tolerance: 1e-12,
        absolute_tolerance: 1e-12,
        ..Settings::default()
    };
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let scene = simulate::scene(model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: "", statics: None });
    simulate::run(model, &settings, rate, &start, &mut memory, &mut |_, _| true).unwrap_or_else(|e| panic!("{e}"));
    (scene, memory.samples)
}

/// The column of a channel.
fn column(scene: &Scene, owner: &str, name: &str) -> usize {
    let found = scene.couplings.iter().position(|channel| channel.body == owner && channel.name == name);
    found.unwrap_or_else(|| panic!("no {owner}.{name} in {:?}", scene.couplings))
}

/// What loops pass in a state, shared.
fn loops(model: &Arc<Model>, q: &[f64], v: &[f64]) -> Vec<LoopReaction> {
    let mut system = System::new(model);
    let mut at = system.at(0.0, q, v);
    at.accelerations(&mut vec![0.0; v.len()]).expect("accelerations");
    at.share_multipliers().expect("shares");
    at.loop_reactions()
}

const ARM: &str = r#"
[[body]]
name = "upper"
mass = 2.0
center = [0.02, 0.0, -0.3]
inertia = [0.06, 0.06, 0.004]
markers = { tip = [0.0, 0.0, -0.6] }
hinge = { type = "revolute", axis = [0.1, 1.0, 0.0], position = 0.4, armature = 0.05, damping = 0.3 }
[[body]]
name = "lower"
mass = 1.0
center = [0.0, 0.03, -0.2]
inertia = [0.02, 0.02, 0.001]
hinge = { type = "revolute", parent = "upper", at = "tip", axis = [0.3, 1.0, 0.0], position = 0.2, velocity = 2.0 }
"#;

/// The torque that is recorded of a drive is what inverse dynamics asks of its hinge, that of a motor what its law says.
#[test]
fn a_drive_pushes_what_inverse_dynamics_asks() {
    let motor = "[[motor]]\nname = \"elbow motor\"\nhinge = \"lower\"\ntype = \"expression\"\nexpression = \"0.5*sin(3*t) - 0.2*v\"\n";
    let drive =
        "[[drive]]\nname = \"shoulder motor\"\nhinge = \"upper\"\ntype = \"sine\"\namplitude = 0.7\nfrequency = 1.3\n";
    let (_, driven) = read(&format!("{ARM}{motor}{drive}"));
    let (_, free) = read(&format!("{ARM}{motor}"));
    let (scene, samples) = recorded(&driven, 1.0, 50.0);
    let [drive, motor] = ["shoulder motor", "elbow motor"].map(|name| column(&scene, name, "torque"));
    assert_eq!((scene.couplings.len(), scene.not_unique.len()), (2, 0));
    let mut system = System::new(&free);
    let mut largest = 0.0_f64;
    for sample in &samples {
        let mut asked = vec![0.0; 2];
        system
            .at(sample.time, &sample.positions, &sample.velocities)
            .residual(&sample.accelerations, &mut asked)
            .expect("a balance");
        largest = largest.max(asked[0].abs());
        // Round-off of torques of some 50 N m; nothing is asked of the free elbow.
        assert!((sample.couplings[drive] - asked[0]).abs() < 1e-11, "{} {asked:?}", sample.couplings[drive]);
        assert!(asked[1].abs() < 1e-11, "{asked:?}");
        let law = 0.5 * (3.0 * sample.time).sin() - 0.2 * sample.velocities[1];
        assert!((sample.couplings[motor] - law).abs() < 1e-13);
    }
    assert!(largest > 10.0, "{largest}");
}

/// What a drive puts in, torque times rate, is the energy that the mechanism gains.
#[test]
fn the_work_of_a_drive_is_the_energy_gained() {
    let drive = "[[drive]]\nname = \"motor\"\nhinge = \"crank\"\ntype = \"expression\"\nexpression = \"3*t + 2*t^2\"\n";
    let (_, model) = read(&format!("{}{drive}", FOUR_BAR.replace(", velocity = 14.0", "")));
    let rate = 500.0;
    let (scene, samples) = recorded(&model, 1.0, rate);
    let torque = column(&scene, "motor", "torque");
    let power = |sample: &OwnedSample| sample.couplings[torque] * coordinate(&model, &sample.velocities, "crank");
    // Simpson's rule.
    let work: f64 =
        samples.windows(3).step_by(2).map(|w| power(&w[0]) + 4.0 * power(&w[1]) + power(&w[2])).sum::<f64>()
            / (3.0 * rate);
    let energy = |sample: &OwnedSample| sample.energy.kinetic + sample.energy.potential;
    let gained = energy(&samples[samples.len() - 1]) - energy(&samples[0]);
    assert!(gained.abs() > 0.5, "{gained}");
    // The rule's error, by halving the rate: 1e-7.
    assert!((work - gained).abs() < 1e-6 * gained.abs(), "{work} J in, {gained} J gained");
}

/// The force of a loop is what the body of its second end needs beside its hinge and its weight, in every sample; the
/// report says that what holds a planar linkage in its plane is not unique.
#[test]
fn the_force_of_a_loop_balances_its_body() {
    let (_, model) = read(FOUR_BAR);
    let (scene, samples) = recorded(&model, 0.5, 100.0);
    assert_eq!(scene.not_unique, ["coupler-rocker"]);
    let [fx, fz, my, gap] =
        ["force.x", "force.z", "moment.y", "gap"].map(|name| column(&scene, "coupler-rocker", name));
    let rocker = model.body("rocker").expect("the rocker");
    let (mass, inertia) = (0.5, 0.004);
    for sample in &samples {
        let pick = |list: &[f64]| coordinate(&model, list, "rocker");
        let (angle, rate, acceleration) =
            (pick(&sample.positions), pick(&sample.velocities), pick(&sample.accelerations));
        let along = Vector3::new(angle.sin(), 0.0, angle.cos());
        let across = Vector3::new(angle.cos(), 0.0, -angle.sin());
        let center = 0.15 * (acceleration * across - rate * rate * along);
        let needed = mass * (center + Vector3::new(0.0, 0.0, 9.80665));
        let (hinge, found) = (&sample.reactions[rocker], &sample.couplings);
        let force = Vector3::new(found[fx], 0.0, found[fz]);
        let size = needed.norm() + force.norm();
        assert!((force + hinge.force - needed).norm() < 1e-11 * size, "{force} {} {needed}", hinge.force);
        // About the hinge: the pin's force is all that turns the rocker beside its weight.
        let turning = (inertia + mass * 0.15 * 0.15) * acceleration;
        let torque = (0.3 * along).cross(&force).y + 0.15 * along.cross(&Vector3::new(0.0, 0.0, -mass * 9.80665)).y;
        assert!((turning - torque).abs() < 1e-11 * size, "{turning} {torque}");
        assert!(found[my].abs() < 1e-13 * size && found[gap] < 1e-14, "{found:?}");
    }
    let [reaction] = &loops(&model, &model.start_position, &model.start_velocity)[..] else { panic!("one loop") };
    assert!(!reaction.unique && reaction.pull.is_none());
    let around: Vec<&str> = reaction.around.iter().map(|body| model.bodies[*body].name.as_str()).collect();
    assert_eq!(around, ["crank", "coupler", "rocker"]);
}

/// A door on two equal hinges beside each other: of all that carries it, the smallest is equal shares of the weight, and
/// of the moment what makes the sum of squares least.
#[test]
fn redundant_hinges_share_what_they_carry() {
    let (height, width, mass) = (0.8, 0.45, 20.0);
    let hinge = |name: &str, z: f64| {
        format!(
            "[[loop]]\nname = \"{name}\"\ntype = \"revolute\"\naxis = [0, 0, 1]\n\
             between = [{{ body = \"ground\", at = [0, 0, {z:?}] }}, {{ body = \"door\", at = [{:?}, 0, {z:?}] }}]\n",
            -width
        )
    };
    let text = format!(
        "[[body]]\nname = \"door\"\nmass = {mass:?}\ninertia = [2.0, 2.5, 1.5]\n\
         hinge = {{ type = \"free\", position = [{width:?}, 0, 0, 1, 0, 0, 0] }}\n{}{}",
        hinge("upper", height),
        hinge("lower", -height)
    );
    let (_, model) = read(&text);
    assert_eq!(model.degrees_of_freedom(), 1);
    let still = vec![0.0; model.velocity_count()];
    let both = loops(&model, &model.start_position, &still);
    let weight = mass * 9.80665;
    // 2 h x + 2 m = w d with x² + (m / L)² least, L the lever from the door's root marker to a hinge.
    let length = f64::hypot(height, width);
    let share = weight * width / (2.0 * (height * height + length * length));
    for (reaction, side) in both.iter().zip([1.0, -1.0]) {
        let (force, moment) = (Vector3::new(-side * share * height, 0.0, 0.5 * weight), share * length * length);
        assert!(!reaction.unique);
        assert!((reaction.force - force).norm() < 1e-11 * weight, "{}: {} {force}", reaction.name, reaction.force);
        assert!((reaction.moment.y.abs() - moment).abs() < 1e-11 * weight, "{} {moment}", reaction.moment);
    }
}

/// A rod's load is its pull; of a scene that nothing couples nothing is recorded.
#[test]
fn rods_pull_and_trees_carry_nothing() {
    let rod = "[[body]]\nname = \"bob\"\nmass = 3.0\ninertia = [0.1, 0.1, 0.1]\nhinge = { type = \"free\", position = [0, 0, -2, 1, 0, 0, 0] }\n\
               [[loop]]\nname = \"tie\"\ntype = \"rod\"\nlength = 2.0\nbetween = [\"bob\", { body = \"ground\", at = [0, 0, 0] }]\n";
    let (_, model) = read(rod);
    let [tie] = &loops(&model, &model.start_position, &model.start_velocity)[..] else { panic!("one loop") };
    let weight = 3.0 * 9.80665;
    assert!(tie.unique && (tie.pull.expect("a rod") - weight).abs() < 1e-12 * weight, "{tie:?}");
    // It acts on the second end, the ground, downwards.
    assert!((tie.force.z + weight).abs() < 1e-12 * weight, "{}", tie.force);
    let (scene, samples) = recorded(&model, 0.1, 10.0);
    assert_eq!(samples[0].couplings, [tie.pull.expect("a rod"), tie.gap]);
    assert_eq!(scene.couplings[0].name, "pull");
    let (_, free) = read(FOUR_BAR.split("[[loop]]").next().expect("the bodies"));
    let (scene, samples) = recorded(&free, 0.1, 10.0);
    assert!(scene.couplings.is_empty() && samples.iter().all(|sample| sample.couplings.is_empty()));
}

/// While a stop holds the right rod, the loop passes what balances the other two bars: half the coupler's weight, and the
/// pull that keeps the left rod out, `g tan q` times its own half weight and the coupler's half. The stop's rows stand
/// beside the loop's and take nothing from them.
#[test]
fn what_a_loop_passes_is_right_while_a_stop_holds() {
    const G: f64 = 9.80665;
    let (scenario, mut model) = crate::scenarios::shipped("parallelogram_on_stop", &[]);
    let right = model.bodies.iter().position(|body| body.name == "right").expect("the rod");
    let check = |scene: &Scene, sample: &OwnedSample, tolerance: f64| {
        let expected = [("force.x", 1.5 * G * 0.2_f64.tan()), ("force.y", 0.0), ("force.z", -G), ("moment.y", 0.0)];
        for (name, expected) in expected {
            let found = sample.couplings[column(scene, "coupler-right", name)];
            assert!((found - expected).abs() < tolerance, "{name} at {} s: {found}, not {expected}", sample.time);
        }
        assert!(sample.couplings[column(scene, "coupler-right", "gap")] < 1e-12);
        // The hinge of the right rod carries half of all weights, and the pull.
        let hinge = &sample.reactions[right];
        assert!((hinge.force.z - 2.0 * G).abs() < tolerance, "{}", hinge.force);
        assert!((hinge.force.x + 1.5 * G * 0.2_f64.tan()).abs() < tolerance, "{}", hinge.force);
    };
    // It comes to rest after some blows, and its loads are those of rest from then on.
    let scene = simulate::scene(&model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: "", statics: None });
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let summary = simulate::run(&model, &scenario.simulate, 100.0, &start, &mut memory, &mut |_, _| true);
    let rest = summary.unwrap_or_else(|error| panic!("{error}")).events.last().expect("events").time;
    let held: Vec<&OwnedSample> = memory.samples.iter().filter(|sample| sample.time > rest).collect();
    assert!(held.len() > 10, "{} samples after {rest} s", held.len());
    held.iter().for_each(|sample| check(&scene, sample, 1e-9));
    // Started there, it is held from the first sample on.
    Arc::make_mut(&mut model).start_position.copy_from_slice(&[0.2, -0.2, 0.2]);
    Arc::make_mut(&mut model).start_velocity.fill(0.0);
    let (scene, samples) = recorded(&model, 0.1, 100.0);
    samples.iter().for_each(|sample| check(&scene, sample, 1e-9));
}

/// A drive that pushes a slider to where crank and rod are in line is named, with its hinge and the time.
#[test]
fn a_drive_at_its_dead_centre_is_named() {
    let text = r#"
[[body]]
name = "crank"
mass = 1.0
center = [0.25, 0, 0]
inertia = [0.01, 0.03, 0.03]
markers = { pin = [0.5, 0, 0] }
hinge = { type = "revolute", axis = [0, 1, 0], position = -0.7 }
[[body]]
name = "rod"
mass = 1.0
center = [0.5, 0, 0]
inertia = [0.01, 0.1, 0.1]
markers = { pin = [1.0, 0, 0] }
hinge = { type = "revolute", parent = "crank", at = "pin", axis = [0, 1, 0], position = 1.0 }
[[body]]
name = "slider"
mass = 1.0
inertia = [0.1, 0.1, 0.1]
hinge = { type = "prismatic", axis = [1, 0, 0], position = 1.3 }
[[loop]]
name = "pin"
type = "revolute"
between = ["rod.pin", "slider"]
axis = [0, 1, 0]
[[drive]]
name = "pusher"
hinge = "slider"
type = "rate"
rate = 0.2
"#;
    let (_, model) = read(text);
    for (method, step) in [(Method::Dop853, None), (Method::Radau5, None), (Method::Rk4, Some(1e-3))] {
        let integrator = Integrator::Method(method);
        let settings = Settings { duration: 4.0, integrator, step, ..Settings::default() };
        let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
        let scene = simulate::scene(&model);
        let mut memory = Memory::new(&Opening { scene: &scene, scenario: "", statics: None });
        let error = simulate::run(&model, &settings, 100.0, &start, &mut memory, &mut |_, _| true).expect_err("an end");
        // From 1.3 m to 1.5 m at 0.2 m/s.
        let error = error.to_string();
        assert!(error.contains("t = 0.99") || error.contains("t = 1 s"), "{method:?}: {error}");
        let named = "drive `pusher` stands next to a dead centre: the loops let `slider` move no further";
        assert!(error.contains(named), "{method:?}: {error}");
    }
}
