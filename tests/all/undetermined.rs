//! Motions whose inertia is nothing but the round-off of what is beyond them.

use crate::common::{Random, build};
use nalgebra::{UnitQuaternion, Vector3};
use std::sync::Arc;
use stillpoint::dynamics::{Fault, System};
use stillpoint::model::Model;
use stillpoint::model::description::*;

/// A point mass on the axis of its hinge, and from a point of that axis on a body that a ball lets turn about it as it likes: whatever
/// the ball carries, nothing of it turns with the hinge. All in random frames, so that no zero is exact.
fn spindle(random: &mut Random, armature: f64, torque: f64) -> Description {
    let axis = random.unit();
    let on_axis = |random: &mut Random| axis * random.between(0.2, 2.0);
    let mut hinge = HingeDescription::new(HingeKind::Revolute { axis }).position([random.between(-3.0, 3.0)]);
    hinge.frame = random.turn();
    hinge.force = vec![torque];
    hinge.armature = vec![armature];
    let spindle = BodyDescription::new("spindle", hinge).mass(random.between(0.1, 3.0)).center(on_axis(random));
    let turn = random.turn();
    let mut ball = HingeDescription::spherical().position([turn.w, turn.i, turn.j, turn.k]);
    ball.parent = "spindle".to_owned();
    ball.at = Point::At(on_axis(random));
    ball.frame = random.turn();
    let mass = random.between(0.1, 3.0) * 10_f64.powf(random.between(-1.0, 5.0));
    let arm = random.vector(0.5);
    let bob = BodyDescription::new("bob", ball)
        .mass(mass)
        .center(arm)
        .inertia(Vector3::new(0.4, 0.5, 0.6) * mass * random.between(0.01, 0.5));
    Description::new("spindle").body(spindle).body(bob)
}

fn accelerations(model: &Arc<Model>) -> Result<Vec<f64>, Fault> {
    let still = vec![0.0; model.velocity_count()];
    let mut found = still.clone();
    let start = model.start_position.clone();
    System::new(model).at(0.0, &start, &still).accelerations(&mut found).map(|_| found)
}

#[test]
fn a_motion_whose_inertia_is_round_off_is_refused_by_name() {
    for seed in 0..300 {
        let mut random = Random::new(seed);
        let torque = random.between(-5.0, 5.0);
        let model = build(&spindle(&mut random, 0.0, torque));
        match accelerations(&model) {
            Err(Fault::Singular { body, .. }) => assert_eq!(body, "spindle", "seed {seed}"),
            other => panic!("seed {seed}: {other:?}"),
        }
    }
}

#[test]
fn an_armature_alone_determines_it() {
    for seed in 0..300 {
        let mut random = Random::new(seed);
        let (torque, armature) = (random.between(-5.0, 5.0), 10_f64.powf(random.between(-4.0, 0.0)));
        let model = build(&spindle(&mut random, armature, torque));
        let found = accelerations(&model).unwrap_or_else(|fault| panic!("seed {seed}: {fault}"));
        let at = model.bodies[model.body("spindle").expect("a body")].hinge.velocity;
        // Weights act in points of the axis, and the ball passes no moment: torque over armature. A weight is known
        // to act within some roundings of 4 m.
        let weight = 9.80665 * model.total_mass();
        let allowed = 1e-9 * torque.abs() + 64.0 * f64::EPSILON * 4.0 * weight;
        assert!(
            (found[at] * armature - torque).abs() < allowed,
            "seed {seed}: {:e} for {torque:e}",
            found[at] * armature
        );
    }
}

/// The same about two axes: a universal hinge before a ball at its centre.
#[test]
fn a_cross_that_carries_nothing_but_a_ball_is_refused_by_name() {
    for seed in 0..100 {
        let mut random = Random::new(seed);
        let first = random.unit();
        let second = first.cross(&random.unit()).normalize();
        let mut hinge = HingeDescription::new(HingeKind::Universal { axes: [first, second] });
        hinge.frame = random.turn();
        hinge.position = random.list(2, -1.0, 1.0);
        let cross = BodyDescription::new("cross", hinge).mass(1.0);
        let turn = UnitQuaternion::from_scaled_axis(random.vector(1.5));
        let mut ball = HingeDescription::spherical().position([turn.w, turn.i, turn.j, turn.k]);
        ball.parent = "cross".to_owned();
        let bob = BodyDescription::new("bob", ball).mass(2.0).center(random.vector(0.5)).inertia([0.1, 0.2, 0.25]);
        let model = build(&Description::new("cross").body(cross).body(bob));
        match accelerations(&model) {
            Err(Fault::Singular { body, .. }) => assert_eq!(body, "cross", "seed {seed}"),
            other => panic!("seed {seed}: {other:?}"),
        }
    }
}
