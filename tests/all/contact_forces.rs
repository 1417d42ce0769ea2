//! What contacts are told to push with, and what becomes of motion where steps capture them: balances, cones, what an impact gives back.

use crate::contact_in_motion::{FLOOR, exact, read};
use nalgebra::{UnitQuaternion, Vector3};
use std::sync::Arc;
use stillpoint::integrate::Method;
use stillpoint::model::Model;
use stillpoint::record::{Memory, Opening};
use stillpoint::simulate::{self, Integrator, Settings, State, Summary, run};

/// A run from the given state, with its samples.
fn kept(model: &Arc<Model>, duration: f64, tolerance: f64, rate: f64) -> (Summary, Memory) {
    let settings = Settings {
        start: simulate::Start::Given,
        duration,
        tolerance,
        absolute_tolerance: tolerance,
        integrator: Integrator::Method(Method::Dop853),
        ..Settings::default()
    };
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let scene = simulate::scene(model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: "", statics: None });
    let summary = run(model, &settings, rate, &start, &mut memory, &mut |_, _| true).expect("a run");
    (summary, memory)
}

/// A coin tips off a drum and comes to rest flat on the floor: what it is told to stand on balances it there, force and moment.
#[test]
fn forces_at_rest_balance_what_they_hold() {
    let text = "[[body]]\nname = \"drum\"\nshape = { cylinder = [0.2, 0.2] }\nhinge = { type = \"fixed\" }\n\
         [[body]]\nname = \"floor\"\nshape = { plane = [0, 0, 1], at = [0, 0, -0.3] }\nhinge = { type = \"fixed\" }\n\
         [[body]]\nname = \"coin\"\ndensity = 1000\nshape = { cylinder = [0.08, 0.06] }\nhinge = { type = \"free\", \
         position = [0.22218574730812973, 0, 0.13, 0.9663189346689568, 0, 0, -0.25734746258755364] }\n\
         [[contact]]\nbetween = [\"*\", \"*\"]\nfriction = 0.2\nrestitution = 0.3\n";
    let model = read(text);
    let (summary, memory) = kept(&model, 0.8, 1e-7, 200.0);
    assert!(summary.state.velocity.iter().all(|v| *v == 0.0), "it rests: {:?}", summary.state.velocity);
    let weight = 1000.0 * std::f64::consts::PI * 0.08 * 0.08 * 0.06 * 9.80665;
    let middle = Vector3::from_column_slice(&summary.state.position[..3]);
    let (_, pushes) = memory.contacts.last().expect("what it stands on");
    let (mut force, mut moment) = (Vector3::zeros(), Vector3::zeros());
    for push in pushes.iter() {
        let [point, own] = [push.point, push.force].map(Vector3::from);
        let own = if push.between[1] == "coin" { own } else { -own };
        force += own;
        moment += (point - middle).cross(&own);
    }
    // Sweeps find rates to 1e-7 of what the scene accelerates with; ten times that for their sums.
    assert!((force - Vector3::z() * weight).norm() < 1e-6 * weight, "{force}");
    assert!(moment.norm() < 1e-6 * weight * 0.08, "{moment}");
}

/// A log rolls down askew: how its ends share what friction holds along it is not unique, and those of least norm would leave the cone of
/// the end that bears less.
#[test]
fn what_is_told_to_stick_is_within_its_cone() {
    let text = format!(
        "gravity = [2.14, 4.01, -8.69]\n{FLOOR}[[body]]\nname = \"log\"\ndensity = 300\n\
         shape = {{ cylinder = [0.0738, 0.2293], rpy = [0, 1.5707963267948966, 0] }}\n\
         hinge = {{ type = \"free\", position = [0, 0, 0.0738, 1, 0, 0, 0] }}\n\
         [[contact]]\nbetween = [\"floor\", \"log\"]\nfriction = 0.3\n"
    );
    let (summary, memory) = kept(&read(&text), 1.0, 1e-7, 50.0);
    // It rolls: two thirds of what pulls it.
    assert!((summary.state.velocity[1] / (4.01 * 2.0 / 3.0) - 1.0).abs() < 1e-6, "{:?}", summary.state.velocity);
    let mut count = 0;
    for (time, pushes) in &memory.contacts {
        for push in pushes.iter().filter(|push| !push.slips) {
            let [normal, force] = [push.normal, push.force].map(Vector3::from);
            let bears = normal.dot(&force);
            let across = (force - normal * bears).norm();
            // Slacks of cones are found to eight digits.
            assert!(across <= 0.3 * bears * (1.0 + 1e-6), "{time} s: {push:?}");
            count += 1;
        }
    }
    assert!(count > 20, "{count} forces");
}

/// A corner strikes so that Newton's law with friction gains energy at all of its restitution (Kane's paradox): what comes back is as much
/// of it as gains none, whatever more is asked for, and the run says so.
#[test]
fn what_comes_back_of_an_impact_gains_no_energy_and_is_no_less_than_it_may_be() {
    let strike = |restitution: f64| {
        let text = format!(
            "gravity = [0, 0, 0]\n{FLOOR}[[body]]\nname = \"box\"\ndensity = 700\nshape = {{ box = [0.266, 0.2094, 0.2858] }}\n\
             hinge = {{ type = \"free\", position = [0, 0, 0.2369041588923187, -0.2292865964899807, -0.8974767223787208, \
             0.35109258046616587, 0.1367376663542204], velocity = [-0.7391779181837066, 0.838916123097571, -1.2550195244094726, \
             -0.9680539197816769, -2.7712562758378243, -2.2392182448450386] }}\n\
             [[contact]]\nbetween = [\"floor\", \"box\"]\nfriction = 0.3\nrestitution = {restitution:?}\n"
        );
        let summary = exact(&text, 0.2);
        (summary.state.velocity[2], summary.dissipated / summary.energy_largest, summary.held_back)
    };
    let [most, nine, eight, none] = [1.0, 0.9, 0.8, 0.0].map(strike);
    // The part is found to 1e-9.
    assert!(most.1.abs() < 1e-8 && most.1 >= -1e-12 && most.2 == 1, "{most:?}");
    assert!((most.0 - nine.0).abs() < 1e-8 && nine.2 == 1, "{most:?} {nine:?}");
    assert!(nine.0 > eight.0 && eight.0 > none.0 && [eight.2, none.2] == [0, 0], "{nine:?} {eight:?} {none:?}");
    assert!(eight.1 > 0.0 && none.1 > eight.1, "{eight:?} {none:?}");
}

/// A log that has struck a drum's rim flies on with 240 rad/s and touches nothing: nothing turns it about another axis, and its energy stays.
#[test]
fn what_flies_after_an_impact_keeps_its_spin() {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
    let text = format!(
        "[[body]]\nname = \"rock\"\nshape = {{ cylinder = [0.2, 0.2] }}\nhinge = {{ type = \"fixed\" }}\n\
         [[body]]\nname = \"log\"\ndensity = 1000\nshape = {{ cylinder = [0.05, 0.2] }}\nhinge = {{ type = \"free\", \
         position = [0.23, 0, 0.5, {:?}, {:?}, 0, 0], velocity = [0, 0, -30, 0, 0, 0] }}\n\
         [[contact]]\nbetween = [\"rock\", \"log\"]\nfriction = 0.3\n",
        turn.w, turn.i
    );
    let (summary, _) = kept(&read(&text), 3.0, 1e-8, 200.0);
    let v = &summary.state.velocity;
    assert!((v[5].abs() / 240.9 - 1.0).abs() < 1e-3, "{v:?}");
    assert!(v[3].hypot(v[4]) < 1e-6, "{v:?}");
    assert!(summary.energy_drift < 1e-4 * summary.energy_largest, "{}", summary.energy_drift);
}

/// Three links in a row on a cart rest on the floor with a ball each: in front of their hinges the first link's ball presses along them as
/// hard as one likes. Forces of least norm leave a cone; those that are told do not, and the cart's hinge passes on what is left of the weight.
#[test]
fn what_hinges_share_is_told_within_the_cones_and_in_balance() {
    let (masses, cart, length, angle) = ([1.798, 0.39, 1.3], 2.26, 0.2838275146264348, 0.4469183265819252);
    let link = |index: usize, parent: &str, at: f64, position: f64| {
        format!(
            "[[body]]\nname = \"l{index}\"\nmass = {:?}\ncenter = [{:?}, 0, 0]\ninertia = [1e-4, 0.01, 0.01]\n\
             shape = {{ sphere = 0.02, at = [{length:?}, 0, 0] }}\nhinge = {{ type = \"revolute\", parent = \"{parent}\", \
             at = [{at:?}, 0, 0], axis = [0, 1, 0], position = {position:?} }}\n",
            masses[index],
            length / 2.0
        )
    };
    let text = format!(
        "{FLOOR}[[body]]\nname = \"cart\"\nmass = {cart:?}\ninertia = [0.01, 0.01, 0.01]\nhinge = {{ type = \"prismatic\", \
         at = [0, 0, 0.14266701313225003], axis = [1, 0, 0], velocity = 0.2693836376357617 }}\n{}{}{}\
         [[contact]]\nbetween = [\"floor\", \"l*\"]\nfriction = {{ stick = 0.2043468096329762, slide = 0.19924885000351006 }}\n",
        link(0, "cart", 0.0, angle),
        link(1, "l0", length, -angle),
        link(2, "l1", length, 0.0)
    );
    let (summary, memory) = kept(&read(&text), 0.5, 1e-8, 40.0);
    assert!(summary.state.velocity.iter().all(|v| *v == 0.0), "{:?}", summary.state.velocity);
    let (_, pushes) = memory.contacts.last().expect("what it stands on");
    let (mut lifts, mut pulls) = (0.0, 0.0);
    for push in pushes.iter() {
        let [normal, force] = [push.normal, push.force].map(Vector3::from);
        let bears = normal.dot(&force);
        // Slacks of cones are found to eight digits.
        assert!((force - normal * bears).norm() <= 0.2043468096329762 * bears * (1.0 + 1e-6), "{push:?}");
        (lifts, pulls) = (lifts + force.z, pulls + force.x);
    }
    let hinge = memory.samples.last().expect("a sample").reactions[1];
    let weight = (masses.iter().sum::<f64>() + cart) * 9.80665;
    assert!((lifts + hinge.force.z - weight).abs() < 1e-9 * weight, "{lifts} {hinge:?} {weight}");
    assert!(pulls.abs() < 1e-9 * weight, "{pulls}");
}
