//! Compliant contact: a spring and a damper along the normal.

use crate::common::answered;
use crate::contact_in_motion::{FLOOR, go, read};
use stillpoint::integrate::Method;
use stillpoint::scenario::parse;

const G: f64 = 9.80665;

/// A ball that falls onto a spring: it sinks and comes back as `δ = g/ω² (1 − cos ωt) + v/ω sin ωt` has it, and bounces to where it
/// came from.
#[test]
fn a_ball_bounces_on_a_spring() {
    let (stiffness, height) = (2e4, 0.2_f64);
    let text = FLOOR.to_owned()
        + "[[body]]\nname = \"ball\"\nmass = 0.5\ninertia = [0.001, 0.001, 0.001]\nshape = { sphere = 0.05 }\n"
        + &format!("hinge = {{ type = \"free\", position = [0, 0, {:?}, 1, 0, 0, 0] }}\n", 0.05 + height)
        + &format!("[[contact]]\nbetween = [\"floor\", \"ball\"]\nstiffness = {stiffness:?}\n");
    let (speed, omega) = ((2.0 * G * height).sqrt(), (stiffness / 0.5_f64).sqrt());
    let (fall, contact) = (speed / G, 2.0 / omega * (std::f64::consts::PI - (speed * omega / G).atan()));
    for method in [Method::Dop853, Method::Radau9] {
        let summary = go(&read(&text), 2.0 * fall + contact, 1e-10, method);
        let times: Vec<(&str, f64)> = summary.events.iter().map(|event| (event.kind.name(), event.time)).collect();
        assert_eq!(
            times.iter().map(|(kind, _)| *kind).collect::<Vec<_>>(),
            ["strikes", "lifts"],
            "{method:?}: {times:?}"
        );
        assert!((times[0].1 - fall).abs() < 1e-9 && (times[1].1 - fall - contact).abs() < 1e-9, "{times:?}");
        assert!((summary.state.position[2] - 0.05 - height).abs() < 1e-8, "{:?}", summary.state.position);
        assert!(summary.energy_drift < 1e-8 && summary.dissipated.abs() < 1e-9, "{method:?}: {}", summary.energy_drift);
    }
}

/// A box on four springs with dampers that is put down askew rocks, and comes to rest where they bear its weight; it slides on as it was pushed.
#[test]
fn a_box_on_dampers_comes_to_rest() {
    let (mass, stiffness) = (2.0, 5e3);
    let turn = [0.02_f64.cos(), 0.02_f64.sin() * 0.6, 0.02_f64.sin() * 0.8, 0.0];
    let text = FLOOR.to_owned()
        + &format!(
            "[[body]]\nname = \"box\"\nmass = {mass:?}\ninertia = [0.02, 0.02, 0.03]\nshape = {{ box = [0.3, 0.3, 0.1] }}\n"
        )
        + &format!(
            "hinge = {{ type = \"free\", position = [0, 0, 0.06, {:?}, {:?}, {:?}, 0], ",
            turn[0], turn[1], turn[2]
        )
        + "velocity = [0.25, 0, 0, 0, 0, 0] }\n[[contact]]\nbetween = [\"floor\", \"box\"]\n"
        + &format!("stiffness = {stiffness:?}\ndamping = 60.0\n");
    let depth = mass * G / (4.0 * stiffness);
    for (method, slack) in [(Method::Dop853, 1e-8), (Method::Radau5, 1e-7)] {
        let summary = go(&read(&text), 3.0, 1e-10, method);
        let q = &summary.state.position;
        assert!((q[2] - 0.05 + depth).abs() < slack, "{method:?}: {} {depth}", q[2] - 0.05);
        assert!((q[0] - 0.75).abs() < slack && q[1].abs() < slack, "{method:?}: {q:?}");
        assert!((q[3].abs() - 1.0).abs() < slack, "{method:?}: {q:?}");
        assert!(summary.energy_drift < 1e-6, "{method:?}: {}", summary.energy_drift);
    }
}

/// Statics does not know compliant contact, and says so; a law cannot be both.
#[test]
fn what_is_not_there_is_refused() {
    let text = FLOOR.to_owned()
        + "[[body]]\nname = \"ball\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\nshape = { sphere = 0.1 }\n"
        + "hinge = { type = \"free\", position = [0, 0, 0.1, 1, 0, 0, 0] }\n[[contact]]\nbetween = [\"*\", \"*\"]\n";
    let both = parse("scene.toml", &(text.clone() + "stiffness = 1e4\nrestitution = 0.5\n"), &[]);
    assert!(both.unwrap_err().render(false).contains("a contact with `stiffness` has no `restitution`"));
    let rubs = parse("scene.toml", &(text.clone() + "stiffness = 1e4\nfriction = 0.5\n"), &[]);
    assert!(rubs.unwrap_err().render(false).contains("is compliant, and has friction"));
    let text = text + "stiffness = 1e4\n";
    let answer = answered(&parse("scene.toml", &text, &[]).unwrap(), read(&text));
    assert!(answer.expect_err("refused").to_string().contains("is compliant"));
}

/// A ball on a spring with a strong damper that is pulled up for a moment: it leaves faster than the spring follows, and is borne again
/// when it comes back, though it has never been above the floor. Against the steps of a method of its own.
#[test]
fn what_a_damper_let_go_of_is_borne_again() {
    let (stiffness, damping, pull, until) = (100.0, 50.0, 60.0, 0.015);
    let text = FLOOR.to_owned()
        + "[[body]]\nname = \"ball\"\nmass = 1.0\ninertia = [0.016, 0.016, 0.016]\nshape = { sphere = 0.2 }\n"
        + "hinge = { type = \"free\", position = [0, 0, 0.1019, 1, 0, 0, 0] }\n"
        + &format!("[[contact]]\nbetween = [\"floor\", \"ball\"]\nstiffness = {stiffness:?}\ndamping = {damping:?}\n")
        + &format!("[[force]]\ntype = \"load\"\non = \"ball\"\nforce = [0, 0, {pull:?}]\n")
        + &format!("over_time = {{ times = [0.0, {until:?}, {until:?}, 10.0], values = [1.0, 1.0, 0.0, 0.0] }}\n");
    let acceleration = |t: f64, z: f64, v: f64| {
        let depth = 0.2 - z;
        let pressed = if depth > 0.0 { (stiffness * depth - damping * v).max(0.0) } else { 0.0 };
        pressed - G + if t < until { pull } else { 0.0 }
    };
    let (mut t, mut z, mut v, h) = (0.0, 0.1019, 0.0, 1e-5);
    while t < 1.0 - 0.5 * h {
        // The middle of each step, where the pull is constant: of order 2.
        let middle = acceleration(t + 0.5 * h, z + 0.5 * h * v, v + 0.5 * h * acceleration(t + 1e-9, z, v));
        z += h * (v + 0.5 * h * middle);
        v += h * middle;
        t += h;
    }
    for method in [Method::Dop853, Method::Radau5] {
        let summary = go(&read(&text), 1.0, 1e-10, method);
        let found = summary.state.position[2];
        // Where the force begins and ends the other method loses its order: some steps' change of it.
        assert!((found - z).abs() < 1e-6, "{method:?}: {found} {z}");
        assert!(summary.energy_drift < 1e-7 && summary.dissipated > 0.0, "{method:?}: {}", summary.energy_drift);
    }
}
