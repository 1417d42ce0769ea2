//! Systems whose fastest motion is far below the step.

use stillpoint::integrate::{Method, Start, Stepper};

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

#[test]
fn dopri5_says_that_stability_holds_its_step() {
    let start = Start { end: 1.0, ..ON_THE_SOLUTION };
    let stiff = run(Method::Dopri5, &mut damped(1e4), &adaptive(1e-5), start);
    assert!(stiff.stability_limited());
    let smooth = run(Method::Dopri5, &mut damped(1.0), &adaptive(1e-5), start);
    assert!(!smooth.stability_limited());
    let implicit = run(Method::Sdirk4, &mut damped(1e4), &adaptive(1e-5), start);
    assert!(!implicit.stability_limited());
    assert!(implicit.statistics().steps * 5 < stiff.statistics().steps);
}
