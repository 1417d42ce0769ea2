//! Work and precision as the library measures them.

use crate::scenarios::shipped;
use std::sync::Arc;
use std::time::Duration;
use stillpoint::integrate::Method;
use stillpoint::model::Model;
use stillpoint::simulate::State;
use stillpoint::simulate::precision::{Plan, Setting, Study, precision};

fn measure(model: &Arc<Model>, plan: &Plan, stop_after: f64) -> Option<Study> {
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    precision(model, &start, plan, &mut |part| part < stop_after).expect("a reference")
}

fn thrown_pendulum() -> (Arc<Model>, Plan) {
    let (_, model) = shipped("double_pendulum", &[]);
    let methods = Method::ALL.into_iter().filter(|method| *method != Method::GeneralizedAlpha).collect();
    let plan = Plan { methods, ..Plan::new(&model, 0.5, Duration::from_secs(20)) };
    (model, plan)
}

#[test]
fn the_error_falls_with_the_tolerance_and_with_the_step_of_every_method() {
    let (model, plan) = thrown_pendulum();
    let study = measure(&model, &plan, 2.0).expect("nobody stopped it");
    assert!(!study.interrupted);
    // Two references at 1e-13 over half a second.
    assert!(study.agreement.state < 1e-11 && study.agreement.energy < 1e-11, "{:?}", study.agreement);
    for &method in &plan.methods {
        let mine: Vec<_> = study.points.iter().filter(|point| point.method == method).collect();
        assert_eq!(mine.len(), 10);
        let error = |i: usize| mine[i].outcome.as_ref().expect("a measured point").state;
        // Nine decades of tolerance, or nine halvings at order four.
        assert!(error(9) < 1e-6 * error(0), "{method:?}: {:e} and {:e}", error(0), error(9));
        assert!(mine[9].statistics.steps > mine[0].statistics.steps && mine[9].wall > Duration::ZERO);
        assert_eq!(method.needs_step(), matches!(mine[0].setting, Setting::Step(_)));
    }
    let fit = study.recommend(1e-6).expect("a point");
    assert!(fit.outcome.as_ref().is_ok_and(|errors| errors.state <= 1e-6));
    let faster = study.points.iter().filter(|point| point.wall < fit.wall);
    assert!(faster.into_iter().all(|point| point.outcome.as_ref().is_ok_and(|errors| errors.state > 1e-6)));
    assert!(study.recommend(1e-30).is_none());
}

#[test]
fn the_error_of_a_method_of_order_2_falls_with_the_tolerance() {
    let (model, plan) = thrown_pendulum();
    let plan = Plan { methods: vec![Method::GeneralizedAlpha], tolerances: vec![1e-3, 1e-4, 1e-5, 1e-6], ..plan };
    let study = measure(&model, &plan, 2.0).expect("nobody stopped it");
    let error = |i: usize| study.points[i].outcome.as_ref().expect("a measured point").state;
    // Three decades, less one for the steps that add up.
    assert!(error(3) < 1e-2 * error(0), "{:e} and {:e}", error(0), error(3));
}

#[test]
fn a_scene_too_stiff_for_explicit_methods_has_references_all_the_same() {
    let (_, stiff) = shipped("double_pendulum", &["lower.stiffness=1e9", "lower.damping=1e7"]);
    let plan = Plan {
        methods: vec![Method::Sdirk4],
        tolerances: vec![1e-4, 1e-7],
        ..Plan::new(&stiff, 0.5, Duration::from_secs(20))
    };
    let study = measure(&stiff, &plan, 2.0).expect("nobody stopped it");
    assert_eq!(study.references, [Method::Radau9, Method::Radau5]);
    assert!(study.agreement.state < 1e-9, "{:?}", study.agreement);
    let error = |i: usize| study.points[i].outcome.as_ref().expect("a measured point").state;
    assert!(error(1) < 1e-2 * error(0) && error(0) < 1e-3, "{:e} and {:e}", error(0), error(1));
}

#[test]
fn runs_that_fail_or_take_too_long_are_kept_and_say_why() {
    let (model, plan) = thrown_pendulum();
    let hasty = Plan { limit: Duration::ZERO, methods: vec![Method::Sdirk4], ..plan.clone() };
    let study = measure(&model, &hasty, 2.0).expect("nobody stopped it");
    assert_eq!(study.points.len(), 10);
    assert_eq!(study.points[0].outcome, Err("given up after 0 s".to_owned()));
    assert_eq!(study.points[9].outcome, Err("not tried: it would take longer than 0 s".to_owned()));
    assert!(study.recommend(1.0).is_none_or(|point| point.outcome.is_ok()));

    // Steps far beyond the stability of an explicit method, on a stiff hinge.
    let (_, stiff) = shipped("double_pendulum", &["lower.stiffness=1e6"]);
    let coarse = Plan { steps: vec![0.05], methods: vec![Method::Rk4], ..plan };
    let study = measure(&stiff, &coarse, 2.0).expect("nobody stopped it");
    let why = study.points[0].outcome.as_ref().expect_err("it must diverge");
    assert!(why.contains("try sdirk4") || why.contains("not a finite number"), "{why}");
}

#[test]
fn what_is_done_is_kept_when_it_is_stopped() {
    let (model, plan) = thrown_pendulum();
    let study = measure(&model, &plan, 0.5).expect("points before the stop");
    assert!(study.interrupted);
    // Half of eighty points and two references are 41 runs; the last of them is stopped when it gets there.
    assert_eq!(study.points.len(), 38);
    assert!(measure(&model, &plan, 0.0).is_none(), "nothing to compare with");
}
