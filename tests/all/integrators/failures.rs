//! What a person is told where a run cannot go on.

use stillpoint::integrate::{
    Component, Failure, ImplicitProblem, Limit, Method, Options, Point, Problem, Start, StepError,
};

use super::problems::Scalar;
use super::{METHODS, adaptive, fixed};

const START: Start<'_> = Start { time: 0.0, position: &[0.0], velocity: &[1.0], end: 1.0 };

/// The error of a run that must fail, and the time and state where it stopped.
fn failure<P: ImplicitProblem>(method: Method, problem: &mut P, options: &Options) -> StepError {
    let mut stepper = match method.start(problem, options, START) {
        Ok(stepper) => stepper,
        Err(error) => return error,
    };
    while !stepper.finished() {
        if let Err(error) = stepper.step(problem) {
            assert!(stepper.position().iter().chain(stepper.velocity()).all(|x| x.is_finite()));
            return error;
        }
    }
    panic!("the run must not reach its end");
}

#[test]
fn a_rate_that_is_not_finite_at_the_start() {
    for method in METHODS {
        let mut problem = Scalar::oscillator(0.0, 0.0, |_| f64::NAN);
        let error = failure(method, &mut problem, &fixed(0.1));
        assert_eq!(error.limit(), Some(&Limit::NotFinite(Component::Velocity(0))));
        assert_eq!(error.to_string(), "cannot start at t = 0 s: v[0] or its rate is not a finite number");
    }
}

#[test]
fn a_rate_that_stops_being_finite_on_the_way() {
    let problem = || Scalar::oscillator(0.0, 0.0, |t| if t > 0.5 { f64::INFINITY } else { 0.0 });
    let fixed = failure(Method::Rk4, &mut problem(), &fixed(0.25)).to_string();
    insta::assert_snapshot!(fixed, @"the fixed step of 0.25 s from t = 0.5 s fails: v[0] or its rate is not a finite number; beyond the stability limit of an explicit method numbers grow without bound: shorten the step, or try sdirk4");
    for method in [Method::Dopri5, Method::Dop853, Method::Sdirk4] {
        let error = failure(method, &mut problem(), &adaptive(1e-6));
        let StepError::Underflow { time, limit, .. } = error else { panic!("{error}") };
        assert_eq!(limit, Limit::NotFinite(Component::Velocity(0)));
        // Steps shrink towards the wall until time stands still.
        assert!((time - 0.5).abs() < 1e-12);
    }
}

#[test]
fn a_fixed_explicit_step_beyond_stability() {
    let mut problem = Scalar::oscillator(1e8, 0.0, |_| 0.0);
    let error = failure(Method::Rk4, &mut problem, &fixed(0.01));
    assert!(error.to_string().ends_with("shorten the step, or try sdirk4"), "{error}");
}

#[test]
fn an_adaptive_explicit_step_held_by_stability_to_the_end() {
    let mut problem = Scalar::oscillator(0.0, 1e17, |_| 0.0);
    let error = failure(Method::Dopri5, &mut problem, &adaptive(1e-6));
    assert_eq!(error.limit(), Some(&Limit::Stability));
    insta::assert_snapshot!(error, @"the step from t = 0 s shrank to 1.77636e-16 s, too small to go on: the step is held by stability, not accuracy (the system is stiff): try sdirk4");
}

#[test]
fn a_solution_that_leaves_to_infinity() {
    for method in [Method::Dopri5, Method::Dop853, Method::Sdirk4] {
        // v = 1 / (1 − 2 t)
        let mut problem = Scalar::new(|_, _, v| 2.0 * v * v, |_, _, v| (0.0, 4.0 * v));
        let error = failure(method, &mut problem, &adaptive(1e-6));
        let StepError::Underflow { time, .. } = error else { panic!("{error}") };
        assert!((time - 0.5).abs() < 1e-4, "{method:?} stopped at {time}");
    }
}

#[test]
fn stage_equations_that_newton_cannot_solve() {
    // A stiff spring whose slope the Jacobian does not know.
    let mut problem = Scalar::new(|_, q, _| -1e8 * q, |_, _, _| (0.0, 0.0));
    let error = failure(Method::Sdirk4, &mut problem, &fixed(0.1));
    assert_eq!(error.limit(), Some(&Limit::Newton));
    insta::assert_snapshot!(error, @"the fixed step of 0.1 s from t = 0 s fails: Newton's iteration for the stages does not converge; look for a jump or a singular configuration near this time, or loosen a tolerance that is close to rounding; shorten the step, or let the method choose it");
}

/// A system that cannot be evaluated where `q` is above 0.5.
struct Blocked;

impl Blocked {
    fn check(q: &[f64]) -> Result<(), Failure> {
        if q[0] > 0.5 { Err(Failure { message: "hinge `lid` is blocked".into() }) } else { Ok(()) }
    }
}

impl Problem for Blocked {
    fn position_count(&self) -> usize {
        1
    }
    fn velocity_count(&self) -> usize {
        1
    }
    fn acceleration(&mut self, _time: f64, q: &[f64], _v: &[f64], a: &mut [f64]) -> Result<(), Failure> {
        a[0] = 0.0;
        Self::check(q)
    }
    fn position_rate(&self, _q: &[f64], v: &[f64], rate: &mut [f64]) {
        rate.copy_from_slice(v);
    }
    fn normalize(&self, _q: &mut [f64]) {}
    fn scales(&self) -> (&[f64], &[f64]) {
        (&[1.0], &[1.0])
    }
}

impl ImplicitProblem for Blocked {
    fn implicit_position(&self, start: &[f64], step: f64, v: &[f64], q: &mut [f64]) {
        q[0] = start[0] + step * v[0];
    }
    fn displace(&self, from: &[f64], by: &[f64], q: &mut [f64]) {
        q[0] = from[0] + by[0];
    }
    fn residual(&mut self, _time: f64, q: &[f64], _v: &[f64], a: &[f64], r: &mut [f64]) -> Result<(), Failure> {
        r.copy_from_slice(a);
        Self::check(q)
    }
    fn reserve(&mut self) {}
    fn factorize(&mut self, _at: Point<'_>, _c1: f64, _c2: f64) -> Result<(), Failure> {
        Ok(())
    }
    fn solve(&mut self, _rhs: &mut [f64]) {}
}

#[test]
fn a_failure_of_the_system_keeps_its_own_words() {
    for method in METHODS {
        let error = failure(method, &mut Blocked, &fixed(0.2));
        assert!(error.to_string().contains("hinge `lid` is blocked"), "{error}");
    }
    for method in [Method::Dopri5, Method::Dop853, Method::Sdirk4] {
        let error = failure(method, &mut Blocked, &adaptive(1e-6));
        let StepError::Underflow { time, limit, .. } = error else { panic!("{error}") };
        assert_eq!(limit.to_string(), "hinge `lid` is blocked");
        // q = t.
        assert!((time - 0.5).abs() < 1e-12);
    }
}

#[test]
fn settings_out_of_range_are_named() {
    let mut problem = Scalar::oscillator(1.0, 0.0, |_| 0.0);
    let good = Options::default();
    let cases = [
        (Method::Dopri5, Options { relative: -1.0, ..good }, "the relative tolerance is -1, allowed is 0 to 0.1"),
        (Method::Dopri5, Options { absolute: 0.0, ..good }, "the absolute tolerance is 0, allowed is above 0"),
        (Method::Sdirk4, Options { step: Some(f64::NAN), ..good }, "the step is NaN, allowed is above 0 s"),
        (Method::Sdirk4, Options { max_step: Some(0.0), ..good }, "the longest step is 0, allowed is above 0 s"),
        (Method::Rk4, good, "a fixed step was asked for but not given: set the step"),
    ];
    for (method, options, message) in cases {
        assert_eq!(failure(method, &mut problem, &options).to_string(), message);
    }
    for method in METHODS {
        // Half the rounding of the time 1.
        let lost = Options { step: Some(1e-16), max_step: Some(1e-16), fixed: true, ..good };
        let start = Start { time: 1.0, end: 2.0, ..START };
        let mut stepper = method.start(&mut problem, &lost, start).expect("the run starts");
        let message = stepper.step(&mut problem).expect_err("time stands still").to_string();
        assert_eq!(
            message,
            "the step is 0.0000000000000001, allowed is long enough to differ from the rounding of time"
        );
    }
    let backwards = Start { end: -1.0, ..START };
    let error = Method::Dopri5.start(&mut problem, &good, backwards).err().map(|error| error.to_string());
    assert_eq!(error.as_deref(), Some("the end time is -1, allowed is a finite number not before the start"));
    let short = Start { position: &[], ..START };
    let error = Method::Dopri5.start(&mut problem, &good, short).err().map(|error| error.to_string());
    assert_eq!(error.as_deref(), Some("the start has 0 positions, the system has 1"));
}
