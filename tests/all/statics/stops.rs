//! Statics heeds the limits of hinges: what lies on its stop rests there, and the stop says what it bears.

use crate::common::build;
use crate::scenarios::{found, shipped};
use std::sync::Arc;
use stillpoint::model::{Model, Side};
use stillpoint::scenario;
use stillpoint::statics::{BearingStop, Equilibrium, Method, Settings, StabilityVerdict, Want, equilibrium};

const G: f64 = 9.80665;

fn read(text: &str) -> Arc<Model> {
    build(&scenario::parse("stops.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}")).description)
}

fn find(model: &Arc<Model>) -> Equilibrium {
    let found = equilibrium(model, &Settings::default(), &model.start_position).expect("statics");
    assert!(found.converged, "{:?}", found.notes);
    found
}

fn stop<'a>(found: &'a Equilibrium, hinge: &str) -> &'a BearingStop {
    found.stops.iter().find(|stop| stop.hinge == hinge).unwrap_or_else(|| panic!("{hinge}: {:?}", found.stops))
}

#[track_caller]
fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "found {found}, expected {expected} within {tolerance:e}");
}

/// The moments of all weights about each hinge are what its stop bears; the hand hangs straight down.
#[test]
fn the_stops_of_the_arm_bear_the_moments_of_its_weights() {
    let (scenario, model) = shipped("arm_on_stop", &[]);
    let found = found(&scenario, &model);
    let (upper, elbow, wrist) = (found.position[0], found.position[1], found.position[2]);
    near(upper, 0.4, 0.0);
    near(upper + elbow + wrist, std::f64::consts::FRAC_PI_2, 1e-9);
    let rubber = stop(&found, "`fore`");
    let of_fore = G * (2.0 * 0.25 + 0.5 * 0.5) * (upper + elbow).cos();
    near(rubber.load, of_fore, 1e-9);
    near(rubber.load, 400.0 * rubber.depth, 1e-9);
    near(elbow, 0.1 + rubber.depth, 1e-12);
    let rigid = stop(&found, "`upper`");
    near(rigid.load, of_fore + G * (3.0 * 0.3 + 2.5 * 0.6) * upper.cos(), 1e-9);
    assert!(rigid.side == Side::High && rubber.side == Side::High && rigid.depth == 0.0 && found.stops.len() == 2);
    // Only what the stops leave free decides; the mode of the hand does not move the shoulder.
    let stability = found.stability.as_ref().expect("a verdict");
    assert_eq!((stability.verdict, stability.modes.len()), (StabilityVerdict::Stable, 2));
    assert!(stability.modes.iter().all(|mode| mode.shape.len() == 3 && mode.shape[0] == 0.0));
    // All methods say the same, from where Newton alone does not stand the hand upright.
    let near_by = [0.3, 0.0, 1.2];
    for method in Method::ALL {
        let other = equilibrium(&model, &Settings { method, want: Want::Stable, ..Settings::default() }, &near_by)
            .expect("statics");
        assert!(other.converged, "{method:?}: {:?}", other.notes);
        near(stop(&other, "`upper`").load, rigid.load, 1e-6);
        near(other.position[1], elbow, 1e-8);
    }
}

/// What falls lands: without its ledge the tray has no equilibrium at all.
#[test]
fn what_falls_comes_to_rest_on_its_stop() {
    let (_, model) = shipped("stops", &[]);
    let found = find(&model);
    let at = |name: &str| found.position[model.bodies[model.body(name).expect("a body")].hinge.position];
    near(at("tray"), -0.2, 0.0);
    near(stop(&found, "`tray`").load, 9.81, 1e-9);
    near(stop(&found, "`hammer`").load, 2.0 * 9.81, 1e-9);
    near(at("hammer"), -2.0 * 9.81 / 2e4, 1e-12);
    near(at("pendulum"), 0.0, 1e-9);
}

/// A lever pushed off its stop leaves it; one pushed onto it stays, and the push decides how hard.
#[test]
fn a_stop_never_pulls() {
    let lever = |force: f64| {
        read(&format!(
            "gravity = [0, 0, 0]\n[[body]]\nname = \"lever\"\nmass = 1\ninertia = [1, 1, 1]\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], stiffness = 2.0, force = {force}, limits = [0.0, 1.0] }}\n"
        ))
    };
    let off = find(&lever(0.5));
    near(off.position[0], 0.25, 1e-12);
    assert!(off.stops.is_empty(), "{:?}", off.stops);
    let on = find(&lever(-0.5));
    near(on.position[0], 0.0, 0.0);
    near(stop(&on, "`lever`").load, 0.5, 1e-12);
    let far = find(&lever(5.0));
    assert_eq!(stop(&far, "`lever`").side, Side::High);
    near(stop(&far, "`lever`").load, 3.0, 1e-12);
}

/// An upright rod between two stops falls onto one of them; held exactly between, it is unstable, and said to be.
#[test]
fn an_inverted_pendulum_lies_on_a_stop() {
    let rod = |position: f64| {
        read(&format!(
            "[[body]]\nname = \"rod\"\nmass = 1\ncenter = [0, 0, 0.5]\ninertia = [0.1, 0.1, 0.01]\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], position = {position}, limits = [-0.3, 0.3] }}\n"
        ))
    };
    for (position, side) in [(0.1, 0.3), (-0.1, -0.3)] {
        let found = find(&rod(position));
        near(found.position[0], side, 0.0);
        near(found.stops[0].load, G * 0.5 * 0.3_f64.sin(), 1e-12);
    }
    let model = rod(0.0);
    let any = Settings { want: Want::Any, ..Settings::default() };
    let between = equilibrium(&model, &any, &model.start_position).expect("statics");
    assert!(between.converged && between.stops.is_empty() && between.position[0] == 0.0);
    assert_eq!(between.stability.expect("a verdict").verdict, StabilityVerdict::Unstable);
}
