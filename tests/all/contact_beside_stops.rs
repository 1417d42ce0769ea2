//! Contact beside compliant stops that push already when a run starts: what contact does is decided with what stops push.

use crate::common::Random;
use crate::contact_in_motion::{exact, kinds, read, tried};
use stillpoint::integrate::Method;
use stillpoint::simulate::Summary;

const G: f64 = 9.80665;
/// A hundred times what a step may be wrong by, 10⁻¹¹ of the scene's length, which is below 1 m.
const TOLERANCE: f64 = 1e-9;
const FLOOR: &str = "[[body]]\nname = \"floor\"\nshape = { plane = [0, 0, 1] }\nhinge = { type = \"fixed\" }\n\
                     [[contact]]\nbetween = [\"floor\", \"box\"]\n";

/// A box of mass m on the floor, guided upwards, whose stop pushes with k p > m g from the start: it leaves the floor at once and
/// moves as m z̈ = k (l − z) − m g, so that z = z₀ + (l − m g / k) (1 − cos ωt) with ω² = k / m.
#[test]
fn a_stop_lifts_what_stands_on_the_floor() {
    let (mass, stiffness, low) = (2.0, 800.0, 0.05);
    let text = format!(
        "{FLOOR}friction = 0.4\n[[body]]\nname = \"box\"\nmass = {mass:?}\ninertia = [0.01, 0.01, 0.01]\nshape = {{ box = [0.2, \
         0.2, 0.2] }}\nhinge = {{ type = \"prismatic\", at = [0, 0, 0.1], axis = [0, 0, 1], limits = {{ low = {low:?}, stiffness = \
         {stiffness:?} }} }}\n"
    );
    let (rise, omega) = (low - mass * G / stiffness, (stiffness / mass).sqrt());
    // The stop lets go at z = l, where cos ωt = 1 − l / (l − m g / k) < 0: not before ωt = π / 2.
    for angle in [0.01, 0.3, 1.5] {
        let summary = exact(&text, angle / omega);
        let expected = rise * (1.0 - f64::cos(angle));
        assert!((summary.state.position[0] - expected).abs() < TOLERANCE, "{angle}: {:?} {expected}", summary.state);
        assert_eq!(kinds(&summary), [""; 0], "{:?}", summary.events);
    }
}

/// A box on a cart that slides up and down stands on the floor with both their weight and is pushed along it with k p > μ N: it slides
/// from the start, m ẍ = k (l − x) − μ N.
#[test]
fn a_stop_pushes_what_would_stick() {
    let (cart, mass, stiffness, low, friction) = (0.5, 2.0, 800.0, 0.05, 0.3);
    let text = format!(
        "{FLOOR}friction = {friction:?}\n[[body]]\nname = \"cart\"\nmass = {cart:?}\ninertia = [0.01, 0.01, 0.01]\nhinge = {{ type = \
         \"prismatic\", at = [0, 0, 0.1], axis = [0, 0, 1] }}\n[[body]]\nname = \"box\"\nmass = {mass:?}\ninertia = [0.01, 0.01, \
         0.01]\nshape = {{ box = [0.2, 0.2, 0.2] }}\nhinge = {{ type = \"prismatic\", parent = \"cart\", axis = [1, 0, 0], limits = \
         {{ low = {low:?}, stiffness = {stiffness:?} }} }}\n"
    );
    let (rubs, omega) = (friction * (cart + mass) * G, (stiffness / mass).sqrt());
    let push = low - rubs / stiffness;
    for angle in [0.01, 0.3, 1.5] {
        let summary = exact(&text, angle / omega);
        let expected = push * (1.0 - f64::cos(angle));
        assert!((summary.state.position[1] - expected).abs() < TOLERANCE, "{angle}: {:?} {expected}", summary.state);
        assert_eq!(kinds(&summary), [""; 0], "{:?}", summary.events);
    }
}

/// A heavy cart comes down on the floor with a light box that runs into a damped stop. The impact's friction, at most μ (M + m) u, stops
/// the box, whose momentum is far less; what the stop pushes then, k p < μ (M + m) g, does not move it. The damper's force of before,
/// c |v| > μ (M + m) g, would. Until then m ẍ + c ẋ + k (x − l) = 0.
#[test]
fn what_an_impact_stops_does_not_slip_by_the_damper_of_before() {
    let (cart, mass, stiffness, damping, low, friction, height) = (10.0, 0.1, 50.0, 40.0, 0.05, 0.3, 1e-4);
    let text = format!(
        "{FLOOR}friction = {friction:?}\n[[body]]\nname = \"cart\"\nmass = {cart:?}\ninertia = [0.01, 0.01, 0.01]\nhinge = {{ type = \
         \"prismatic\", at = [0, 0, 0.1], axis = [0, 0, 1], position = {height:?}, velocity = -1.0 }}\n[[body]]\nname = \
         \"box\"\nmass = {mass:?}\ninertia = [0.01, 0.01, 0.01]\nshape = {{ box = [0.2, 0.2, 0.2] }}\nhinge = {{ type = \
         \"prismatic\", parent = \"cart\", axis = [1, 0, 0], velocity = -1.0, limits = {{ low = {low:?}, stiffness = \
         {stiffness:?}, damping = {damping:?} }} }}\n"
    );
    let summary = exact(&text, 0.01);
    let time = (f64::sqrt(1.0 + 2.0 * G * height) - 1.0) / G;
    // x = l + a e^{rt} + b e^{st} from x = 0 and ẋ = −1.
    let root = f64::sqrt(damping * damping - 4.0 * stiffness * mass);
    let [r, s] = [1.0, -1.0].map(|sign| (sign * root - damping) / (2.0 * mass));
    let a = (-1.0 + s * low) / (r - s);
    let b = -low - a;
    let speed: f64 = a * r * f64::exp(r * time) + b * s * f64::exp(s * time);
    let bound: f64 = friction * (cart + mass) * G;
    assert!(stiffness * 2.0 * low < bound && damping * speed.abs() > bound && speed.abs() * mass < bound / G);
    assert_eq!(kinds(&summary), ["strikes"], "{:?}", summary.events);
    let expected = low + a * f64::exp(r * time) + b * f64::exp(s * time);
    assert!((summary.state.position[1] - expected).abs() < TOLERANCE, "{:?} {expected}", summary.state);
    assert_eq!(summary.state.velocity, [0.0; 2]);
}

/// Double arms over a floor, with a stop in their elbow, or friction: each gives back another part of an impact, and where several at once would
/// gain energy by that, less comes back. Energy is never gained, and none of the runs ends before its time.
#[test]
fn arms_that_strike_a_floor_and_their_stops_gain_no_energy() {
    let mut random = Random::new(0xa2);
    let (mut held, mut impacts) = (0, 0);
    for case in 0..40 {
        let mut of = |low: f64, high: f64| random.between(low, high);
        let rub = if case % 3 == 0 { of(0.2, 1.5) } else { 0.0 };
        let link = |name: &str, parent: &str, [mass, angle, rate]: [f64; 3], stops: String| {
            format!(
                "[[body]]\nname = \"{name}\"\nmass = {mass}\ncenter = [0, 0, -0.25]\ninertia = [0.01, 0.01, 0.002]\nmarkers = {{ tip = [0, 0, -0.5] }}\n\
                 shape = {{ sphere = 0.06, at = [0, 0, -0.5] }}\nhinge = {{ type = \"revolute\", axis = [0, 1, 0], {parent} position = {angle}, velocity = {rate}{stops} }}\n"
            )
        };
        let first = [of(0.3, 1.2), of(-1.4, 1.4), of(-1.0, 1.0)];
        let second = [of(0.3, 1.2), of(-0.6, 0.25), of(-1.0, 1.0)];
        let stops =
            format!(", friction = {rub}, limits = {{ low = -0.74, high = 0.28, restitution = {} }}", of(0.2, 0.9));
        let text = format!(
            "[[body]]\nname = \"floor\"\nshape = {{ plane = [0, 0, 1], at = [0, 0, {}] }}\nhinge = {{ type = \"fixed\" }}\n{}{}\
             [[contact]]\nbetween = [\"arm*\", \"floor\"]\nfriction = {}\nrestitution = {}\n",
            of(-1.05, -0.8),
            link("arm0", "", first, String::new()),
            link("arm1", "parent = \"arm0\", at = \"tip\",", second, stops),
            if case % 2 == 0 { of(0.0, 0.7) } else { 0.0 },
            of(0.1, 0.9),
        );
        let model = read(&text);
        let summary: Summary = match tried(&model, 1.0, 1e-6, Method::Dop853) {
            Ok(summary) => summary,
            // Some begin inside of the floor.
            Err(error) if error.to_string().contains("overlap") || error.to_string().contains("inside") => continue,
            Err(error) => panic!("case {case}: {error}\n{text}"),
        };
        let allowed = 1e-3 * (summary.energy_start.abs() + G);
        assert!(
            summary.energy_end < summary.energy_start + allowed,
            "case {case}: {} {}\n{text}",
            summary.energy_start,
            summary.energy_end
        );
        (held, impacts) = (held + summary.held_back, impacts + summary.impacts);
    }
    assert!(impacts > 50 && held > 0, "{impacts} impacts, {held} of them held back");
}

/// A ball leaves a damped stop faster than that relaxes, `k p < c v`: the stop lets go while it is still pressed. A wall throws it back, and the stop
/// pushes again: `m p̈ + c ṗ + k p = 0` from the impact on, until that force is none.
#[test]
fn a_stop_that_has_let_go_pushes_what_an_impact_throws_back() {
    let mut random = Random::new(0xb10);
    for case in 0..24 {
        let [mass, damping] = [random.between(0.5, 3.0), random.between(20.0, 150.0)];
        let [speed, restitution] = [random.between(1.0, 6.0), random.between(0.2, 1.0)];
        let [from, struck] = [random.between(0.012, 0.03), random.between(0.002, 0.01)];
        let stiffness = random.between(0.1, 0.9) * damping * speed / from;
        let back = restitution * speed;
        let (decay, discriminant) = (0.5 * damping / mass, (0.5 * damping / mass).powi(2) - stiffness / mass);
        let at = |t: f64| {
            // sinh(wt)/w and cosh(wt), or sin and cos.
            let w = discriminant.abs().sqrt();
            let (sine, cosine) = match discriminant > 0.0 {
                true => ((w * t).sinh() / w, (w * t).cosh()),
                false => ((w * t).sin() / w, (w * t).cos()),
            };
            let pressed = (-decay * t).exp() * (struck * cosine + (back + decay * struck) * sine);
            let rate = (-decay * t).exp() * (back * cosine - (stiffness / mass * struck + decay * back) * sine);
            [pressed, rate]
        };
        let mut long = 0.05;
        let ends = |time: f64| {
            let [pressed, rate] = at(time);
            stiffness * pressed + damping * rate <= 0.0 || pressed < struck
        };
        // Before the stop lets go again, and before the wall is met again.
        while (1..=100).any(|k| ends(0.01 * long * f64::from(k))) {
            long *= 0.9;
        }
        let text = format!(
            "gravity = [0, 0, 0]\n[[body]]\nname = \"wall\"\nmass = 1\nshape = {{ plane = [-1, 0, 0], at = [{}, 0, 0] }}\nhinge = {{ type = \
             \"fixed\" }}\n[[body]]\nname = \"ball\"\nmass = {mass}\ninertia = [1, 1, 1]\nshape = {{ sphere = 0.1 }}\nhinge = {{ type = \
             \"prismatic\", axis = [1, 0, 0], position = {}, velocity = {speed}, limits = {{ low = 0.0, stiffness = {stiffness}, damping = \
             {damping} }} }}\n[[contact]]\nbetween = [\"wall\", \"ball\"]\nrestitution = {restitution}\n",
            0.1 - struck,
            -from
        );
        let summary = exact(&text, (from - struck) / speed + long);
        let [pressed, rate] = at(long);
        let off = [summary.state.position[0] + pressed, summary.state.velocity[0] + rate];
        assert!(
            off[0].abs() < TOLERANCE && off[1].abs() < 1e3 * TOLERANCE,
            "case {case}: {off:?}, {:?}",
            summary.events
        );
        assert!(summary.energy_drift.abs() < 1e-9 * summary.energy_largest, "case {case}: {}", summary.energy_drift);
    }
}

/// A ball runs onto a damped stop and, 1 cm further, onto a rigid one, in a scene whose other ball never meets it: captured steps take the
/// impact. It comes back with `e u`, where the damped stop, `k p − c e u < 0`, pushes no more.
#[test]
fn a_damped_stop_lets_go_of_what_a_captured_impact_throws_back() {
    for (restitution, damping) in [(0.3, 80.0), (0.5, 60.0), (0.2, 100.0)] {
        let (stiffness, speed, way) = (300.0, 2.0, 0.01);
        let text = format!(
            "gravity = [0, 0, 0]\n[[body]]\nname = \"a\"\nmass = 1\ninertia = [1, 1, 1]\nshape = {{ sphere = 0.05 }}\nhinge = {{ type = \
             \"prismatic\", axis = [1, 0, 0], velocity = {speed:?}, limits = [{{ high = 0.19, stiffness = {stiffness:?}, damping = \
             {damping:?} }}, {{ high = 0.2, restitution = {restitution:?} }}] }}\n[[body]]\nname = \"b\"\nmass = 1\ninertia = [1, 1, \
             1]\nshape = {{ sphere = 0.05 }}\nhinge = {{ type = \"prismatic\", axis = [1, 0, 0], position = 5.0, velocity = 10.0 \
             }}\n[[contact]]\nbetween = [\"a\", \"b\"]\n"
        );
        // p̈ = −k p − c ṗ by small steps of fourth order, from the damped stop to the rigid one.
        let rate = |[p, v]: [f64; 2]| [v, -stiffness * p - damping * v];
        let (mut at, h) = ([0.0, speed], 1e-7);
        while at[0] < way {
            let plus = |k: [f64; 2], part: f64| [at[0] + part * h * k[0], at[1] + part * h * k[1]];
            let first = rate(at);
            let second = rate(plus(first, 0.5));
            let third = rate(plus(second, 0.5));
            let fourth = rate(plus(third, 1.0));
            at = [0, 1].map(|i| at[i] + h / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i]));
        }
        let back = -restitution * at[1];
        assert!(stiffness * way + damping * back < 0.0, "the damped stop pushes no more");
        // Captured steps are of order 1: their length follows from the tolerance.
        for (tolerance, allowed) in [(1e-8, 5e-3), (1e-10, 1e-3)] {
            let summary = tried(&read(&text), 0.5, tolerance, Method::Dop853).unwrap_or_else(|error| panic!("{error}"));
            let off = (summary.state.velocity[0] / back - 1.0).abs();
            assert!(off < allowed, "{restitution}, {damping} at {tolerance}: {} for {back}", summary.state.velocity[0]);
        }
    }
}
