//! Systems side by side against each of them alone, against the printed method and against closed forms.

pub(crate) mod scenes;

use crate::common::{build, relative_difference, take_inertia};
use scenes::{arm, state, varied};
use std::sync::Arc;
use stillpoint::dynamics::ensemble::WIDTH;
use stillpoint::dynamics::{Ensemble, Fault, System, applied};
use stillpoint::integrate::Method;
use stillpoint::model::Model;
use stillpoint::model::description::{BodyDescription, Description, HingeDescription};
use stillpoint::motion::Motion;
use stillpoint::record::Recorder;
use stillpoint::simulate::outputs::OutputRanges;
use stillpoint::simulate::{Integrator, Settings, State, Summary, run, run_together, runs_together};
use stillpoint::spatial::Wrench;
use stillpoint::transfer::plain;

const ALL: [bool; WIDTH] = [true; WIDTH];

/// The accelerations of each system, computed side by side, by system.
fn side_by_side(models: &[Arc<Model>; WIDTH]) -> Result<[Vec<f64>; WIDTH], Box<[Option<Fault>; WIDTH]>> {
    let mut ensemble = Ensemble::new(models).expect("one structure");
    let (q, v) = state(models);
    let mut a = vec![[0.0; WIDTH]; v.len()];
    ensemble.accelerations(&ALL, &[0.0; WIDTH], (&q, &v), &mut a)?;
    Ok(std::array::from_fn(|lane| a.iter().map(|a| a[lane]).collect()))
}

/// Those of one system by the method as it is printed.
fn printed(model: &Arc<Model>) -> Vec<f64> {
    let (q, v) = (&model.start_position, &model.start_velocity);
    let mut motion = Motion::new(model);
    motion.update(model, q, v);
    let mut wrenches = vec![Wrench::ZERO; model.links.len()];
    applied::apply(&applied::Laws::new(model), &motion, &mut wrenches);
    let mut tau = v.clone();
    applied::hinge::apply(model, q, v, &mut tau);
    plain::accelerations(model, &motion, &wrenches, &tau).expect("a regular scene").hinge.as_slice().to_vec()
}

/// 240 structures with every hinge, armature, spring, bushing and load, each with other numbers in every lane. Sums of up to
/// twenty-five terms, condition numbers up to some hundred, as for the sweep of one system (`plain.rs`).
#[test]
fn systems_side_by_side_accelerate_as_the_printed_method_says() {
    let mut structures = 0;
    for seed in 0..240 {
        let Some(models) = varied(seed) else { continue };
        structures += 1;
        let found = side_by_side(&models).expect("regular scenes");
        for (model, found) in models.iter().zip(&found) {
            let off = relative_difference(found, &printed(model));
            assert!(off < 1e-11, "seed {seed}: {off:e}");
        }
    }
    assert!(structures > 200, "{structures}");
}

/// A point mass on two axes that nearly meet in a plane with it, in one lane: its pivot loses ten digits, and the answer has what
/// the sweep of one system refines.
#[test]
fn digits_lost_in_one_lane_are_found_again() {
    let bent = |angle: f64| {
        let first = HingeDescription::revolute([0.0, 0.0, 1.0]).velocity([0.3]).position([0.2]);
        let second = HingeDescription::revolute([1.0, 0.0, 0.0]).on("swivel", [0.0, 0.0, 0.0]).position([angle]);
        let swivel = BodyDescription::new("swivel", first).mass(1e-3).inertia([1e-9; 3]);
        let bob = BodyDescription::new("bob", second).mass(1.0).center([0.0, 0.0, -1.0]).inertia([1e-9; 3]);
        build(&Description::new("swivel").body(swivel).body(bob))
    };
    let models = std::array::from_fn(|lane| bent(if lane == 1 { 1e-4 } else { 0.5 + 0.1 * lane as f64 }));
    let found = side_by_side(&models).expect("regular scenes");
    for (model, found) in models.iter().zip(&found) {
        let mut alone = vec![0.0; 2];
        let (q, v) = (&model.start_position, &model.start_velocity);
        System::new(model).at(0.0, q, v).accelerations(&mut alone).expect("a regular scene");
        // Where none is lost, the pivots are 1 and 0.1.
        assert!(relative_difference(found, &alone) < 1e-13, "{found:?} {alone:?}");
    }
}

/// A hinge that nothing resists in one lane is that lane's fault, and no other's.
#[test]
fn a_singular_lane_is_told_alone() {
    let mut models = std::array::from_fn(|lane| arm(3, false, lane));
    take_inertia(&mut models[2], "link2");
    Arc::make_mut(&mut models[2]).coordinates[2].armature = 0.0;
    let faults = side_by_side(&models).expect_err("singular");
    for (lane, fault) in faults.iter().enumerate() {
        let singular = matches!(fault, Some(Fault::Singular { body, .. }) if body == "link2");
        assert!(if lane == 2 { singular } else { fault.is_none() }, "{lane}: {fault:?}");
    }
}

#[test]
fn other_structures_are_no_ensemble() {
    let mut models: [Arc<Model>; WIDTH] = std::array::from_fn(|lane| arm(3, false, lane));
    models[1] = arm(4, false, 1);
    assert!(Ensemble::new(&models).is_none());
    let dry = HingeDescription::prismatic([0.0, 0.0, 1.0]).friction([0.5]);
    let dry = build(&Description::new("pan").body(BodyDescription::new("pan", dry).mass(1.0)));
    assert!(!Ensemble::covers(&dry) && Ensemble::covers(&models[0]));
}

fn settings(method: Method) -> Settings {
    let mut settings = Settings { duration: 0.3, integrator: Integrator::Method(method), ..Settings::default() };
    (settings.tolerance, settings.absolute_tolerance) = (1e-6, 1e-6);
    settings.step = method.needs_step().then_some(2e-3);
    settings
}

fn starts(models: &[Arc<Model>; WIDTH]) -> [State; WIDTH] {
    models
        .each_ref()
        .map(|model| State { position: model.start_position.clone(), velocity: model.start_velocity.clone() })
}

fn together(models: &[Arc<Model>; WIDTH], settings: &Settings) -> [Summary; WIDTH] {
    assert!(models.iter().all(|model| runs_together(model, settings)));
    let mut ranges: [OutputRanges; WIDTH] = std::array::from_fn(|_| OutputRanges::default());
    let mut recorders = ranges.each_mut().map(|one| one as &mut dyn Recorder);
    let ran = run_together(models, settings, 100.0, &starts(models), &mut recorders, &mut |_, _| true);
    ran.expect("one structure").map(|summary| summary.expect("a run"))
}

/// Each takes the steps that it takes alone, rejected ones and all, and ends where it ends alone: round-off of an evaluation grows by
/// the condition of the motion, some hundred in 0.3 s.
#[test]
fn runs_side_by_side_are_the_runs_alone() {
    for (seed, method) in (0..12).zip([Method::Rk4, Method::Dopri5, Method::Dop853].into_iter().cycle()) {
        let Some(models) = varied(seed) else { continue };
        let settings = settings(method);
        for (lane, found) in together(&models, &settings).iter().enumerate() {
            let start = starts(&models)[lane].clone();
            let mut recorder = OutputRanges::default();
            let alone = run(&models[lane], &settings, 100.0, &start, &mut recorder, &mut |_, _| true).expect("a run");
            let name = format!("seed {seed}, {}, lane {lane}", method.name());
            assert_eq!((found.end_time, found.samples), (alone.end_time, alone.samples), "{name}");
            let (here, there) = (&found.statistics, &alone.statistics);
            assert_eq!((here.steps, here.rejected_steps), (there.steps, there.rejected_steps), "{name}");
            assert_eq!(here.acceleration_evaluations, there.acceleration_evaluations, "{name}");
            let off = relative_difference(&found.state.position, &alone.state.position)
                .max(relative_difference(&found.state.velocity, &alone.state.velocity));
            assert!(off < 1e-9, "{name}: {off:e}");
            assert!(
                (found.energy_drift - alone.energy_drift).abs() < 1e-9 * alone.energy_start.abs().max(1.0),
                "{name}"
            );
        }
    }
}

/// Oscillators of other stiffness and mass in each lane, against `cos √(k/m) t`. The classical method of order 4 with `h ω ≤ 0.1`
/// is off by `ω t (h ω)⁴/120` at most.
#[test]
fn oscillators_side_by_side_swing_as_their_cosine() {
    let frequency = |lane: usize| 10.0 + 5.0 * lane as f64;
    let models = std::array::from_fn(|lane| {
        let mass = 1.0 + lane as f64;
        let hinge =
            HingeDescription::prismatic([1.0, 0.0, 0.0]).position([0.1]).stiffness([mass * frequency(lane).powi(2)]);
        build(&Description::new("oscillator").body(BodyDescription::new("pan", hinge).mass(mass)))
    });
    for (lane, found) in together(&models, &settings(Method::Rk4)).iter().enumerate() {
        let (phase, step) = (frequency(lane) * 0.3, frequency(lane) * 2e-3);
        let off = (found.state.position[0] - 0.1 * phase.cos()).abs();
        assert!(off < 0.1 * phase * step.powi(4) / 100.0, "{lane}: {off:e}");
        assert!(off > 0.0, "the error of the method is above round-off");
    }
}
