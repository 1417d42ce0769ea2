//! What is at rest stays at rest: every shipped scenario with an equilibrium, with an explicit and an implicit method.

use crate::scenarios::{found, names, shipped};
use std::sync::Arc;
use stillpoint::force::Act;
use stillpoint::model::Model;
use stillpoint::record::Fanout;
use stillpoint::scenario::Scenario;
use stillpoint::simulate::rest::{Rest, TOLERANCE, rest};
use stillpoint::statics::StabilityVerdict;

/// One falls over, one has a motor that winds, one is thrown through its change points, one is held by a lock of statics alone,
/// one burns, one fires.
const NO_REST: [&str; 6] = ["pencil", "winch", "coupled_cranks", "four_bar_tolerances", "rocket", "gun"];

fn proof(scenario: &Scenario, model: &Arc<Model>) -> Rest {
    let equilibrium = found(scenario, model);
    rest(model, &equilibrium, &scenario.simulate, 10.0, &mut Fanout::new(), &mut |_| true)
        .unwrap_or_else(|error| panic!("{}: {error}", scenario.name))
}

fn all_rest(integrator: &str) {
    let method = format!("simulate.integrator={integrator}");
    for name in names().iter().filter(|name| !NO_REST.contains(&name.as_str())) {
        let changes =
            [&method, "simulate.tolerance=1e-10", "simulate.absolute_tolerance=1e-10", "simulate.duration=10"];
        let (scenario, model) = shipped(name, &changes);
        // What is driven does not rest.
        let moves =
            |drive: &stillpoint::model::Drive| !drive.motion.is_steady() || drive.motion.at(0.0).velocity != 0.0;
        // Stability holds an explicit method to 150 000 steps on the chain; beams, which are stiffer, rest with their own settings below.
        if model.drives.iter().any(moves)
            || model.forces.iter().any(|force| force.law.steady_until() < 10.0)
            || (name == "stiff_chain" && integrator == "dopri5")
            || !model.beams.is_empty()
        {
            continue;
        }
        let proof = proof(&scenario, &model);
        assert!(proof.rested && proof.duration == 10.0, "{name} with {integrator}: {proof:?}");
        assert!(proof.displacement.value < 1e-9 && proof.growth.is_none(), "{name} with {integrator}: {proof:?}");
    }
}

#[test]
fn every_stable_scenario_rests_for_ten_seconds_with_dopri5() {
    all_rest("dopri5");
}

#[test]
fn every_stable_scenario_rests_for_ten_seconds_with_sdirk4() {
    all_rest("sdirk4");
}

/// As a user lets them: `auto`, their own tolerance and duration.
#[test]
fn beams_rest() {
    for name in ["beam_cantilever", "beam_column", "stayed_mast"] {
        let (scenario, model) = shipped(name, &[]);
        let proof = proof(&scenario, &model);
        assert!(proof.rested && proof.displacement.value < 1e-9 && proof.growth.is_none(), "{name}: {proof:?}");
    }
}

/// A governor turns at its rate and its arms stay out; a suspension stays until its road moves.
#[test]
fn steady_motions_rest_beside_their_drives() {
    for (name, disturbed) in
        [("flyball_governor", None), ("governor_rise", None), ("double_wishbone", Some(0.5)), ("launcher", Some(1.0))]
    {
        let (scenario, model) = shipped(name, &[]);
        let proof = proof(&scenario, &model);
        assert!(proof.rested && proof.displacement.value < TOLERANCE, "{name}: {proof:?}");
        let end = disturbed.unwrap_or(scenario.simulate.duration);
        assert!((proof.duration - end).abs() < 1e-3 * end, "{name}: {proof:?}");
        assert_eq!(proof.disturbed.is_some(), disturbed.is_some(), "{name}: {proof:?}");
    }
}

#[test]
fn a_proof_does_not_depend_on_the_tolerance_of_the_scene() {
    // A loose tolerance lets an explicit method wander by as much before it takes a smaller step.
    for name in ["pendulum", "collar_on_a_rod", "machine_on_mounts"] {
        let loose = ["simulate.integrator=dopri5", "simulate.tolerance=1e-4", "simulate.absolute_tolerance=1e-4"];
        let (scenario, model) = shipped(name, &loose);
        let proof = proof(&scenario, &model);
        assert!(proof.rested && proof.displacement.value < TOLERANCE, "{name}: {proof:?}");
    }
}

#[test]
fn the_pencil_leaves_as_fast_as_predicted() {
    let (scenario, model) = shipped("pencil", &[]);
    let proof = proof(&scenario, &model);
    let growth = proof.growth.as_ref().expect("unstable");
    let observed = growth.observed.expect("it falls within the time that is given");
    assert!(!proof.rested);
    // Measured between 1e-5 and 1e-3 rad, where sin θ differs from θ by θ²/6 < 1e-6 of it.
    assert!((observed / growth.predicted - 1.0).abs() < 1e-6, "{growth:?}");
}

#[test]
fn motions_that_cost_nothing_do_not_spoil_the_residual() {
    // The outer ring and the rotor may stand anywhere: the stiffness matrix is singular.
    let (scenario, model) = shipped("gyroscope_in_gimbals", &[]);
    let equilibrium = found(&scenario, &model);
    assert_eq!(equilibrium.stability.as_ref().expect("a verdict").verdict, StabilityVerdict::Neutral);
    // Polished to round-off like every other.
    assert!(equilibrium.relative_residual < 1e-13, "{:e}", equilibrium.relative_residual);
}
