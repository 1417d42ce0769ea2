//! What a run says of its own error, what the program chooses, and what it refuses.

use stillpoint::integrate::Method;
use stillpoint::record::Fanout;
use stillpoint::simulate::verify::{Verified, quaternion_error, verify};
use stillpoint::simulate::{RunError, State, Summary, run};

use crate::common::build;
use crate::scenarios::shipped;

fn go(name: &str, changes: &[&str]) -> Result<(Summary, Verified), RunError> {
    let (scenario, model) = shipped(name, changes);
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let summary = run(&model, &scenario.simulate, 1.0, &start, &mut Fanout::new(), &mut |_, _| true)?;
    // A few roundings of four squares.
    assert!(quaternion_error(&model, &summary.state) < 1e-15);
    let verified = verify(&model, &scenario.simulate, &start, &summary, &mut |_| true)?.expect("nobody stopped it");
    Ok((summary, verified))
}

/// Against the same run at a tolerance that leaves rounding alone: the estimate is the error within a tenth of it.
#[test]
fn the_estimated_error_of_a_run_is_its_error() {
    for (name, method) in
        [("five_links", "dopri5"), ("five_links", "adams"), ("heavy_top", "radau5"), ("heavy_top", "sdirk4")]
    {
        let method = format!("simulate.integrator={method:?}");
        let (loose, verified) = go(name, &[&method, "simulate.tolerance=1e-6"]).expect("a run");
        let (exact, _) = go(name, &["simulate.integrator=\"dop853\"", "simulate.tolerance=1e-12"]).expect("a run");
        let pairs = loose.state.velocity.iter().zip(&exact.state.velocity);
        let error = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!((verified.rate / error - 1.0).abs() < 0.1, "{name} {method}: {verified:?} {error:e}");
        assert!(verified.angle > 0.0 && verified.length == 0.0 && verified.method != loose.integrators[0]);
    }
}

#[test]
fn auto_leaves_the_explicit_method_where_the_scene_is_stiff_and_only_there() {
    let (stiff, verified) =
        go("stiff_chain", &["simulate.integrator=\"auto\"", "simulate.tolerance=1e-8"]).expect("a run");
    assert_eq!(stiff.integrators, [Method::Adams, Method::Radau9]);
    assert!(stiff.choice.as_ref().is_some_and(|said| said.contains("held by stability")), "{:?}", stiff.choice);
    assert!(stiff.statistics.steps < 400 && verified.angle < 1e-7, "{:?} {verified:?}", stiff.statistics);
    let (smooth, _) = go("heavy_top", &["simulate.integrator=\"auto\"", "simulate.tolerance=1e-8"]).expect("a run");
    assert_eq!(smooth.integrators, [Method::Adams]);
}

/// A mass on a stiff, damped spring: `λ = (−5 ± 8.7 i)·10³/s`. Every tolerance finds that out within its first steps.
#[test]
fn a_damped_vibration_is_stiff_once_it_has_died_out() {
    for tolerance in ["1e-4", "1e-7", "1e-10"] {
        let text = format!(
            "gravity = [0, -9.8, 0]\nsimulate = {{ start = \"given\", duration = 2.0, tolerance = {tolerance} }}\n\
             [[body]]\nname = \"arm\"\nhinge = {{ type = \"revolute\", axis = [0, 0, 1], position = 1.0 }}\n\
             [[body]]\nname = \"mass\"\nmass = 1.0\nhinge = {{ type = \"prismatic\", parent = \"arm\", \
             axis = [0, -1, 0], position = 1.0, stiffness = 1e8, damping = 1e4, rest = 1.0 }}\n"
        );
        let scenario = stillpoint::scenario::parse("spring.toml", &text, &[]).expect("a scenario");
        let model = build(&scenario.description);
        let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
        let summary =
            run(&model, &scenario.simulate, 1.0, &start, &mut Fanout::new(), &mut |_, _| true).expect("a run");
        assert!(summary.integrators.len() == 2 && summary.integrators[0] == Method::Adams, "{:?}", summary.integrators);
        // A tenth of what stability would take.
        assert!(summary.statistics.steps < 5_000, "{tolerance}: {:?}", summary.statistics);
    }
}

#[test]
fn an_explicit_method_on_a_scene_far_too_stiff_is_refused_with_advice() {
    let changes = ["lower.damping=1e12", "simulate.duration=0.1", "simulate.integrator=\"dopri5\""];
    let error = go("double_pendulum", &changes).expect_err("too stiff").to_string();
    assert!(error.contains("`dopri5` is an explicit method") && error.contains("`lower`"), "{error}");
    assert!(error.contains("radau9"), "{error}");
}

/// A body that a stage sets free falls on parabolas, which a low order has exactly: its steps are held by nothing.
#[test]
fn free_fall_is_not_stiff() {
    for (tolerance, hinge, duration) in [
        (1e-10, "type = \"spherical\"", 20.0),
        (1e-3, "type = \"revolute\", axis = [1, 0, 0]", 5.0),
        (1e-6, "type = \"prismatic\", axis = [1, 0, 0]", 20.0),
        (1e-8, "type = \"revolute\", axis = [1, 0, 0]", 2.0),
    ] {
        let text = format!(
            "simulate = {{ start = \"given\", duration = {duration:?}, tolerance = {tolerance:e} }}\n\
             [[body]]\nname = \"ball\"\nmass = 0.5\ninertia = [0.01, 0.01, 0.01]\nhinge = {{ at = [0, 0, -1], {hinge} }}\n\
             [[stage]]\nwhen = {{ time = 0.1 }}\nopen = [\"ball\"]\n"
        );
        let scenario = stillpoint::scenario::parse("fall.toml", &text, &[])
            .unwrap_or_else(|problems| panic!("{problems}\n{text}"));
        let model = build(&scenario.description);
        let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
        let summary =
            run(&model, &scenario.simulate, 1.0, &start, &mut Fanout::new(), &mut |_, _| true).expect("a run");
        assert_eq!(summary.integrators, [Method::Adams], "{text}: {:?}", summary.choice);
    }
}
