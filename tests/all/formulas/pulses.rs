//! What a formula of time does for a short time is done, whatever the steps.

use crate::common::Random;
use crate::contact_in_motion::{go, read};
use std::f64::consts::PI;
use stillpoint::integrate::Method;
use stillpoint::simulate::Summary;

const METHODS: [Method; 5] = [Method::Dopri5, Method::Dop853, Method::Adams, Method::Radau9, Method::Sdirk4];
/// Of every run (s).
const DURATION: f64 = 10.0;
/// Runs at a tolerance of 10⁻⁸ are within this part of the largest velocity: a few hundred steps add up, and those around a
/// smooth pulse are controlled relative to the scene.
const WITHIN: f64 = 1e-5;

/// A force of an impulse of about 1 N s as a formula, and that impulse.
fn pulse(random: &mut Random) -> (String, f64) {
    let width = 10.0_f64.powf(random.between(-6.0, -0.6));
    let (middle, height) = (random.between(2.0, 8.0), random.between(0.5, 2.0) / width);
    let (from, to) = (middle - 0.5 * width, middle + 0.5 * width);
    match random.below(8) {
        0 => (format!("{height:?}*({from:?} < t <= {to:?})"), height * (to - from)),
        1 => (format!("if(abs(t-{middle:?}) < {:?}, {height:?}, 0)", 0.5 * width), height * width),
        2 => (format!("{height:?}*max(0, 1 - abs(t-{middle:?})/{width:?})"), height * width),
        // What is left of a box with a hole.
        3 => {
            let hole = [from + 0.25 * width, middle];
            let text = format!(
                "({height:?} if not {:?} <= t < {:?} else 0) if {from:?} < t < {to:?} else 0",
                hole[0], hole[1]
            );
            (text, height * (to - from - hole[1] + hole[0]))
        }
        4 => {
            let (period, on) = (random.between(0.3, 4.0), 0.3 * width);
            let whole = (DURATION / period).floor();
            let time = whole * on + on.min(DURATION - whole * period);
            let height = random.between(0.5, 2.0) / time;
            (format!("{height:?}*(t % {period:?} < {on:?})"), height * time)
        }
        5 => (format!("{height:?}*exp(-((t-{middle:?})/{:?})^2)", 0.2 * width), height * 0.2 * width * PI.sqrt()),
        6 => {
            let (low, high) = (middle - 0.3 * width, middle + 0.3 * width);
            let edge = 0.02 * width;
            let text = format!("{height:?}/2*(tanh((t-{low:?})/{edge:?}) - tanh((t-{high:?})/{edge:?}))");
            (text, height * (high - low))
        }
        _ => {
            let text =
                format!("{height:?}*(1 - cos(2*pi*(t-{from:?})/{width:?}))/2 if {from:?} <= t <= {to:?} else 0*q*v");
            (text, 0.5 * height * width)
        }
    }
}

/// A mass of 2 kg on a slide, with a motor.
fn slide(force: &str, speed: f64) -> String {
    format!(
        "gravity = [0, 0, 0]\n[[body]]\nname = \"p\"\nmass = 2.0\n\
         hinge = {{ type = \"prismatic\", axis = [1, 0, 0], velocity = {speed:?} }}\n\
         [[motor]]\nname = \"m\"\nhinge = \"p\"\ntype = \"expression\"\nexpression = \"{force}\"\n"
    )
}

/// Random pulses of any shape and width, one or two, at rest and moving: the velocity is that of their impulse.
#[test]
fn pulses_give_their_impulse() {
    let mut random = Random::new(61);
    for case in 0..120 {
        let (mut text, mut impulse) = pulse(&mut random);
        if case % 3 == 0 {
            let (other, more) = pulse(&mut random);
            (text, impulse) = (format!("({text}) - ({other})"), impulse - more);
        }
        let speed = if case % 2 == 0 { 0.0 } else { random.between(-1.0, 1.0) };
        let model = read(&slide(&text, speed));
        let method = METHODS[case % METHODS.len()];
        let found = go(&model, DURATION, 1e-8, method).state.velocity[0];
        let expected = speed + 0.5 * impulse;
        assert!((found - expected).abs() < 2.0 * WITHIN, "case {case}, {method:?}: {found} for {expected}\n{text}");
    }
}

/// Every method acts on the same short pulse beside a pendulum, which keeps steps of its own.
#[test]
fn every_method_sees_a_train_of_pulses_beside_a_pendulum() {
    let pendulum = "[[body]]\nname = \"bob\"\nmass = 1.0\ncenter = [0, 0, -1]\n\
                    hinge = { type = \"revolute\", axis = [0, 1, 0], position = 0.5 }\n";
    for method in METHODS {
        for (force, impulse) in [
            ("10*(0.5 < t % 1 < 0.501)", 0.1),
            ("1000*exp(-((fract(t)-0.5)/0.001)^2)", 10.0 * PI.sqrt()),
            ("1e4*(t > 3)*exp(-max(0, t-3)*1e4)", 1.0),
        ] {
            let text = slide(force, 0.0).replace("gravity = [0, 0, 0]", "gravity = [0, 0, -9.81]") + pendulum;
            let found = go(&read(&text), DURATION, 1e-8, method).state.velocity[0];
            let expected = 0.5 * impulse;
            assert!(
                (found - expected).abs() < WITHIN * (1.0 + expected),
                "{method:?}: {found} for {expected} of {force}"
            );
        }
    }
}

/// A table on a drive, and a ball on it that nothing holds.
fn driven(motion: &str, ball: &str) -> String {
    format!(
        "gravity = [0, 0, 0]\n[[body]]\nname = \"table\"\nmass = 3.0\nhinge = {{ type = \"prismatic\", axis = [1, 0, 0] }}\n\
         [[body]]\nname = \"ball\"\nmass = 1.0\nhinge = {{ type = \"prismatic\", parent = \"table\", axis = [1, 0, 0]{ball} }}\n\
         [[drive]]\nname = \"d\"\nhinge = \"table\"\ntype = \"expression\"\nexpression = \"{motion}\"\n"
    )
}

/// Unaccounted energy of a run (J), which is no more than round-off of the energies.
fn accounts(summary: &Summary, what: &str) {
    assert!(summary.energy_drift < 1e-7, "{what}: {:e} J unaccounted for", summary.energy_drift);
}

/// A drive whose velocity jumps takes nothing along that is free, and its work is booked.
#[test]
fn the_work_of_jumps_of_velocity_is_booked() {
    let summary = go(&read(&driven("min(t, 1)", "")), 2.0, 1e-8, Method::Dop853);
    let [table, ball] = summary.state.velocity[..] else { panic!() };
    assert!(table.abs() < 1e-12 && (ball - 1.0).abs() < 1e-9, "{table}, {ball}");
    assert!((summary.state.position[1] - 1.0).abs() < 1e-9, "{:?}", summary.state.position);
    assert!((summary.work + 1.5).abs() < 1e-9, "{} J", summary.work);
    accounts(&summary, "min(t, 1)");
    let mut random = Random::new(62);
    for case in 0..20 {
        let mut number = |low, high| random.between(low, high);
        let (a, b, c, d, e) =
            (number(-2.0, 2.0), number(0.5, 9.0), number(-2.0, 2.0), number(0.5, 9.0), number(-0.5, 0.5));
        let motion = format!("{a:?}*abs(t-{b:?}) + {c:?}*max(0, t-{d:?}) + {e:?}*t^2");
        let method = METHODS[case % METHODS.len()];
        let summary = go(&read(&driven(&motion, "")), DURATION, 1e-8, method);
        let slope = a + c + 2.0 * e * DURATION;
        let [table, ball] = summary.state.velocity[..] else { panic!() };
        // The ball keeps the velocity that the table has at the start.
        assert!(
            (table - slope).abs() < 1e-9 && (table + ball + a).abs() < 1e-5,
            "{motion}, {method:?}: {table}, {ball}"
        );
        accounts(&summary, &motion);
    }
}

/// A table that starts at once takes along what lies against its edge; what the impact takes out is booked, too.
#[test]
fn what_lies_on_a_stop_of_a_table_that_jumps_is_struck() {
    for (restitution, speed) in [(0.0, 0.0), (0.5, 0.5)] {
        let stop = format!(", limits = {{ low = 0.0, restitution = {restitution:?} }}");
        let summary = go(&read(&driven("max(0, t-1)", &stop)), 2.0, 1e-8, Method::Dopri5);
        let ball = summary.state.velocity[1];
        assert!((ball - speed).abs() < 1e-9, "{ball} for {speed}");
        let energy = 0.5 * (1.0 - restitution * restitution);
        assert!((summary.dissipated - energy).abs() < 1e-9, "{} J for {energy} J", summary.dissipated);
        accounts(&summary, "on a stop");
    }
}

/// A corner that is rounded within microseconds is a corner to what is on the table.
#[test]
fn rounded_corners_of_drives_are_followed() {
    let model = read(&driven("sqrt((t-3.3)^2 + 1e-10)", ""));
    for method in METHODS {
        let summary = go(&model, DURATION, 1e-8, method);
        let [table, ball] = summary.state.velocity[..] else { panic!() };
        assert!((table - 1.0).abs() < 1e-9, "{method:?}: {table}");
        assert!((table + ball + 1.0).abs() < 1e-6, "{method:?}: {ball}");
    }
}

/// A table that goes to and fro within a pulse of any width leaves the ball where it is, in runs of any duration; then steps grow again:
/// what is left of the pulse is 10⁻¹⁰⁰ and less, no number to be divided by.
#[test]
fn steps_grow_again_after_a_pulse_of_a_drive() {
    let mut random = Random::new(63);
    let methods = [Method::Dopri5, Method::Dop853, Method::Sdirk4, Method::Radau5, Method::Radau9];
    let given = [(7.0, 1e-4), (9.0, 1e-4)];
    let more: Vec<_> =
        (0..16).map(|_| (random.between(4.0, 10.0), 10.0_f64.powf(random.between(-6.0, -3.0)))).collect();
    for (duration, width) in given.into_iter().chain(more) {
        let model = read(&driven(&format!("0.001*exp(-((t-3.3)/{width:?})^2)"), ""));
        for method in methods {
            let summary = go(&model, duration, 1e-8, method);
            let what = format!("{method:?}, {duration} s, {width:e} s");
            let [table, ball] = summary.state.velocity[..] else { panic!() };
            // At its fastest the table has 0.86 mm per width.
            let fastest = 0.86e-3 / width;
            assert!(table.abs() < 1e-9 && (table + ball).abs() < 1e-6 * fastest.max(1.0), "{what}: {table}, {ball}");
            let steps = summary.statistics.steps + summary.statistics.rejected_steps;
            assert!(steps < 3000, "{what}: {steps} steps");
        }
    }
}

/// `generalized-alpha` is of order 2: it takes as many steps through a pulse of any width, and ends.
#[test]
fn a_method_of_low_order_comes_through_pulses_of_any_width() {
    for width in [1e-2, 1e-4, 1e-6, 1e-7] {
        let force = format!("{:?}*exp(-((t-3.3)/{width:?})^2)", 1.0 / width);
        let summary = go(&read(&slide(&force, 0.0)), DURATION, 1e-6, Method::GeneralizedAlpha);
        let (found, expected) = (summary.state.velocity[0], 0.5 * PI.sqrt());
        assert!((found - expected).abs() < 1e-6, "{width}: {found} for {expected}");
        assert!(summary.statistics.steps < 30_000, "{width}: {} steps", summary.statistics.steps);
    }
    let model = read(&driven("0.001*exp(-((t-3.3)/1e-5)^2)", ""));
    let summary = go(&model, 7.0, 1e-6, Method::GeneralizedAlpha);
    let [table, ball] = summary.state.velocity[..] else { panic!() };
    assert!(table.abs() < 1e-9 && (table + ball).abs() < 1e-4, "{table}, {ball}");
    assert!(summary.statistics.steps < 200_000, "{} steps", summary.statistics.steps);
}

/// Fixed steps are shorter where a formula does something that is over within a few of them, and nowhere else.
#[test]
fn fixed_steps_follow_pulses_that_are_shorter() {
    let mut random = Random::new(64);
    for case in 0..60 {
        let (text, impulse) = pulse(&mut random);
        let model = read(&slide(&text, 0.0));
        let method = [Method::Rk4, Method::Gauss][case % 2];
        let summary = go(&model, DURATION, 1e-8, method);
        let (found, expected) = (summary.state.velocity[0], 0.5 * impulse);
        // The tails of a smooth pulse are beside its stretch.
        assert!((found - expected).abs() < WITHIN, "case {case}, {method:?}: {found} for {expected}\n{text}");
        // Of 1 ms, and some hundred for each pulse.
        assert!(
            summary.statistics.steps < 30_000,
            "case {case}, {method:?}: {} steps\n{text}",
            summary.statistics.steps
        );
    }
    // A wave through a switch, of a third more to three places of it.
    for (method, width) in [(Method::Rk4, 1e-3), (Method::Rk4, 1e-6), (Method::Gauss, 1e-3), (Method::Gauss, 1e-6)] {
        let force = format!("{:?}*(1-cos(2*pi*(t-3.3)/{width:?}))*(3.3 <= t <= 3.3+{width:?})", 1.0 / width);
        let summary = go(&read(&slide(&force, 0.0)), DURATION, 1e-8, method);
        let found = summary.state.velocity[0];
        assert!((found - 0.5).abs() < 1e-6, "{method:?}, {width}: {found}");
        assert!(summary.energy_drift < 1e-6, "{method:?}, {width}: {:e} J unaccounted for", summary.energy_drift);
    }
    // What is constant between its switches takes one step.
    let summary = go(&read(&slide("10*(0.5 < t % 1 < 0.505)", 0.0)), DURATION, 1e-8, Method::Rk4);
    assert!(summary.statistics.steps < 10_100, "{} steps", summary.statistics.steps);
}
