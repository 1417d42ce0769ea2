//! Events that watch expressions: however often one crosses its value in a step, and however short.

use crate::common::Random;
use crate::contact_in_motion::{go, read};
use std::f64::consts::{FRAC_PI_6, TAU};
use stillpoint::integrate::Method;

const METHODS: [Method; 5] = [Method::Dopri5, Method::Dop853, Method::Adams, Method::Radau9, Method::Sdirk4];

/// A bead that moves on with 1 m/s, or rests, and what is watched of it and the time.
fn bead(speed: f64, expression: &str, event: &str) -> String {
    format!(
        "gravity = [0, 0, 0]\n[[body]]\nname = \"p\"\nmass = 1.0\n\
         hinge = {{ type = \"prismatic\", axis = [1, 0, 0], velocity = {speed:?} }}\n\
         [[output]]\nname = \"x\"\ntype = \"coordinate\"\nof = \"p\"\n\
         [[output]]\nname = \"inner\"\ntype = \"expression\"\nexpression = \"{expression}\"\n\
         [[output]]\nname = \"watched\"\ntype = \"expression\"\nexpression = \"2*inner\"\n\
         [[event]]\nname = \"e\"\noutput = \"watched\"\n{event}\n"
    )
}

/// `2 sin(k s)` comes up through 1 at `s = (π/6 + 2πn)/k`: of the place of what moves, and of the time.
#[test]
fn waves_are_crossed_as_often_as_they_come() {
    let mut random = Random::new(71);
    for case in 0..10 {
        let (rate, method) = (random.between(3.0, 120.0), METHODS[case % METHODS.len()]);
        let (variable, speed) = if case % 2 == 0 { ("x", 1.0) } else { ("t", 0.0) };
        let text = bead(speed, &format!("sin({rate:?}*{variable})"), "value = 1.0\ndirection = \"up\"");
        let found = go(&read(&text), 10.0, 1e-8, method).events;
        let right: Vec<f64> =
            (0..).map(|n| (FRAC_PI_6 + TAU * f64::from(n)) / rate).take_while(|time| *time < 10.0).collect();
        assert_eq!(found.len(), right.len(), "{method:?}, sin({rate} {variable})");
        for (found, right) in found.iter().zip(right) {
            assert!((found.time - right).abs() < 1e-9, "{method:?}: {} not {right}", found.time);
        }
    }
}

/// A pulse that is far shorter than a step stops a run where it begins to be high; windows of comparisons, too.
#[test]
fn pulses_are_not_jumped_over() {
    let mut random = Random::new(72);
    for case in 0..20 {
        let (middle, width) = (random.between(0.5, 9.5), 10.0_f64.powf(random.between(-4.0, -1.0)));
        let method = METHODS[case % METHODS.len()];
        let variable = if case % 3 == 0 { "t" } else { "x" };
        let (expression, begins) = match case % 2 {
            0 => (format!("exp(-(({variable}-{middle:?})/{width:?})**2)"), middle - width * 4.0_f64.ln().sqrt()),
            _ => (format!("{:?} < {variable} < {middle:?}", middle - width), middle - width),
        };
        let text = bead(1.0, &expression, "value = 0.5\naction = \"stop\"");
        let summary = go(&read(&text), 10.0, 1e-8, method);
        assert!(
            (summary.end_time - begins).abs() < 1e-8,
            "{method:?}, {expression}: {} not {begins}",
            summary.end_time
        );
    }
}

/// What stays at the value of an event crosses nothing, and costs no search without end.
#[test]
fn what_stays_at_its_value_is_no_event() {
    for expression in ["0.5", "0.5 + 0*x", "min(x, 0.5)"] {
        let summary = go(&read(&bead(1.0, expression, "value = 1.0")), 10.0, 1e-8, Method::Dopri5);
        assert!(summary.events.len() <= 1, "{expression}: {:?}", summary.events);
    }
}
