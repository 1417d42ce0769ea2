//! Systems whose fastest motion is far below the step.

use stillpoint::integrate::{Method, Options, Start, Stepper};

use super::problems::Scalar;
use super::{adaptive, fixed, run};

/// A strong damper of this rate in 1/s.
const RATE: f64 = 1e6;

/// `q = sin t` held by a damper of `rate` that follows it: the problem of Prothero and Robinson for the velocity.
fn damped(rate: f64) -> Scalar {
    Scalar::oscillator(0.0, rate, move |t| rate * t.cos() - t.sin())
}

const ON_THE_SOLUTION: Start<'_> = Start { time: 0.0, position: &[0.0], velocity: &[1.0], end: 10.0 };

fn errors(reached: &dyn Stepper<Scalar>) -> [f64; 2] {
    let t = reached.time();
    [(reached.position()[0] - t.sin()).abs(), (reached.velocity()[0] - t.cos()).abs()]
}

#[test]
fn sdirk4_steps_far_over_the_fastest_time_constant() {
    let reached = run(Method::Sdirk4, &mut damped(RATE), &adaptive(1e-5), ON_THE_SOLUTION);
    let statistics = reached.statistics();
    assert!(statistics.largest_step > 1e5 / RATE, "{statistics:?}");
    assert!(statistics.steps < 100, "{statistics:?}");
    assert!(errors(&*reached).iter().all(|error| *error < 1e-5));
}

#[test]
fn sdirk4_keeps_order_4_in_the_position_held_by_a_strong_damper() {
    let run_fixed = |step: f64| errors(&*run(Method::Sdirk4, &mut damped(RATE), &fixed(step), ON_THE_SOLUTION));
    let ([coarse, _], [fine, fine_velocity]) = (run_fixed(0.1), run_fixed(0.05));
    let order = (coarse / fine).log2();
    assert!((3.75..5.0).contains(&order), "order {order:.2}");
    // What stage order 1 leaves in the stiff component: less than h / rate.
    assert!(fine_velocity < 0.05 / RATE);
}

#[test]
fn a_transient_dies_out_and_the_output_inside_its_step_stays_bounded() {
    let mut problem = damped(RATE);
    let start = Start { velocity: &[5.0], ..ON_THE_SOLUTION };
    let mut stepper = Method::Sdirk4.start(&mut problem, &adaptive(1e-4), start).expect("the run starts");
    let (mut q, mut v) = ([0.0], [0.0]);
    while !stepper.finished() {
        stepper.step(&mut problem).expect("the step is made");
        let step = stepper.time() - stepper.previous_time();
        for part in [0.25, 0.5, 0.75] {
            let time = stepper.previous_time() + part * step;
            stepper.interpolate(&mut problem, time, &mut q, &mut v).expect("a state");
            // The velocity falls from 5 and then stays within the unit circle; some overshoot is the method's own.
            assert!((-2.0..5.5).contains(&v[0]), "velocity {} in a step of {step:e} s", v[0]);
        }
    }
    assert!(errors(&*stepper)[1] < 1e-4);
    assert!(stepper.statistics().steps < 100);
}

#[test]
fn van_der_pol_meets_the_published_digits() {
    // μ = 1000 at t = 2000: Mazzia, Magherini, Test Set for Initial Value Problem Solvers, problem VDPOL, there in the
    // time t/μ and to 16 digits.
    let published = [1.706167732170483, -0.8928097010247975e-3];
    let start = Start { time: 0.0, position: &[2.0], velocity: &[0.0], end: 2000.0 };
    for tolerance in [1e-4, 1e-6, 1e-8] {
        let reached = run(Method::Sdirk4, &mut Scalar::van_der_pol(1000.0), &adaptive(tolerance), start);
        // The moment of the two jumps before carries their errors on.
        assert!((reached.position()[0] - published[0]).abs() < 30.0 * tolerance);
        assert!((reached.velocity()[0] - published[1]).abs() < 30.0 * tolerance);
    }
}

/// Where the step does not resolve the damper, the method of stage order 1 leaves an error `O(h / rate)` in the velocity,
/// those of stage order 3 and 5 leave `O(h^s / rate)`.
#[test]
fn radau_has_its_stage_order_in_the_velocity_held_by_a_strong_damper() {
    let error = |method: Method, step: f64| {
        let reached = run(method, &mut damped(1e3), &fixed(step), ON_THE_SOLUTION);
        errors(&*reached)[1]
    };
    for (method, stages) in [(Method::Radau5, 3), (Method::Radau9, 5)] {
        let order = (error(method, 0.5) / error(method, 0.25)).log2();
        // `h rate` is some hundred: the next term of the error is not far.
        assert!(order > f64::from(stages) - 0.5, "{method:?}: {order:.2}");
        assert!(error(method, 0.5) < 0.1 * error(Method::Sdirk4, 0.5), "{method:?}");
    }
}

/// What converges fast where steps resolve the motion is slow here: the stages change over to what is fast on stiff systems.
#[test]
fn the_stages_of_a_stiff_system_take_few_sweeps() {
    let reached = run(Method::Radau9, &mut damped(1e3), &adaptive(1e-10), ON_THE_SOLUTION);
    let counters = reached.statistics();
    let per_step = counters.residual_evaluations as f64 / counters.steps as f64;
    // Five for each sweep: 34, and 67 with the other splitting.
    assert!(per_step < 40.0, "{per_step}");
}

#[test]
fn van_der_pol_at_a_tight_tolerance_takes_radau_a_third_of_the_steps() {
    let published = [1.706167732170483, -0.8928097010247975e-3];
    let start = Start { time: 0.0, position: &[2.0], velocity: &[0.0], end: 2000.0 };
    let steps = |method: Method| {
        let reached = run(method, &mut Scalar::van_der_pol(1000.0), &adaptive(1e-9), start);
        assert!((reached.position()[0] - published[0]).abs() < 3e-8, "{method:?}");
        assert!((reached.velocity()[0] - published[1]).abs() < 3e-8, "{method:?}");
        reached.statistics().steps
    };
    assert!(3 * steps(Method::Radau9) < steps(Method::Sdirk4));
}

/// The part of an oscillation far faster than the step that a step of generalized-α leaves: the user's number.
#[test]
fn generalized_alpha_damps_what_is_too_fast_as_asked() {
    for rho in [0.0, 0.3, 0.8, 1.0] {
        let mut problem = Scalar::oscillator(1e8, 0.0, |_| 0.0);
        // Differences of numbers of the size 10⁸ h² are what the iteration ends with.
        let options = Options { relative: 1e-6, absolute: 1e-6, rho_infinity: rho, ..fixed(1.0) };
        let start = Start { time: 0.0, position: &[1.0], velocity: &[0.0], end: 41.0 };
        let mut stepper = Method::GeneralizedAlpha.start(&mut problem, &options, start).expect("the run starts");
        let mut size = Vec::new();
        while !stepper.finished() {
            stepper.step(&mut problem).expect("the step is made");
            size.push(stepper.position()[0].abs());
        }
        // At infinity all roots are −ρ, threefold: the amplitude goes as ρⁿ times a polynomial of n of degree 2 at most.
        let late = (size[40] / size[20]).powf(1.0 / 20.0);
        let expected = match rho {
            // One root is left at −1 for ρ = 1, and at 0 what is left is rounding and less.
            0.0 => 0.0..0.3,
            _ => 0.95 * rho..1.15 * rho,
        };
        assert!(size[20] < 1e-15 || expected.contains(&late), "{rho}: {late}, {size:?}");
    }
}

/// …while what the step resolves is left alone: of an oscillation of 60 steps a period, a hundredth is lost in ten periods.
#[test]
fn generalized_alpha_leaves_what_the_step_resolves() {
    let tau = std::f64::consts::TAU;
    let start = Start { time: 0.0, position: &[1.0], velocity: &[0.0], end: 10.0 * tau };
    for rho in [0.5, 0.8, 1.0] {
        let options = Options { rho_infinity: rho, ..fixed(tau / 60.0) };
        let mut problem = Scalar::oscillator(1.0, 0.0, |_| 0.0);
        let mut stepper = Method::GeneralizedAlpha.start(&mut problem, &options, start).expect("the run starts");
        while !stepper.finished() {
            stepper.step(&mut problem).expect("the step is made");
        }
        let amplitude = stepper.position()[0].hypot(stepper.velocity()[0]);
        assert!((0.99..1.001).contains(&amplitude), "{rho}: {amplitude}");
    }
}

#[test]
fn dopri5_says_that_stability_holds_its_step() {
    let start = Start { end: 1.0, ..ON_THE_SOLUTION };
    let stiff = run(Method::Dopri5, &mut damped(1e4), &adaptive(1e-3), start);
    assert!(stiff.stability_limited());
    let smooth = run(Method::Dopri5, &mut damped(1.0), &adaptive(1e-3), start);
    assert!(!smooth.stability_limited());
    let implicit = run(Method::Sdirk4, &mut damped(1e4), &adaptive(1e-3), start);
    assert!(!implicit.stability_limited());
    assert!(implicit.statistics().steps * 5 < stiff.statistics().steps);
}
