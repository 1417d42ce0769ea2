//! Slips that turn as they end: on a slope the direction of a slip is not that in which it comes to rest, and two ends of one body have a
//! direction each.

use crate::common::Random;
use crate::contact_in_motion::{FLOOR, go, kinds, read};
use nalgebra::Vector3;
use stillpoint::integrate::Method;

/// A ball slides and spins down a slope until it rolls. Its slip `u` obeys `u̇ = a − k û` with `a` the slope's pull and `k = 7/2 μ g_n`, so
/// that `d/dt (k |u| + a·u) = a² − k²`: it ends after `(k |u₀| + a·u₀) / (k² − a²)`.
#[test]
fn a_ball_on_a_slope_rolls_when_its_slip_has_turned_to_rest() {
    let mut random = Random::new(0x51ee);
    for case in 0..24 {
        let [across, along, pressed] = [random.between(-2.0, 2.0), random.between(0.5, 3.0), random.between(6.0, 11.0)];
        let pull = Vector3::new(along, across, 0.0);
        let [friction, radius] = [random.between(0.25, 0.9), random.between(0.03, 0.3)];
        let velocity = Vector3::new(random.between(-1.0, 1.0), random.between(-1.0, 1.0), 0.0);
        let spin = Vector3::from_fn(|_, _| random.between(-1.0, 1.0)) / radius;
        let text = format!(
            "gravity = [{along}, {across}, {}]\n{FLOOR}[[body]]\nname = \"ball\"\nmass = 1\n\
             inertia = [{1}, {1}, {1}]\nshape = {{ sphere = {radius} }}\n\
             hinge = {{ type = \"free\", position = [0, 0, {radius}, 1, 0, 0, 0], \
             velocity = [{2}, {3}, 0, {4}, {5}, {6}] }}\n\
             [[contact]]\nbetween = [\"floor\", \"ball\"]\nfriction = {friction}\n",
            -pressed,
            0.4 * radius * radius,
            velocity.x,
            velocity.y,
            spin.x,
            spin.y,
            spin.z
        );
        let slip = velocity + spin.cross(&Vector3::new(0.0, 0.0, -radius));
        let k = 3.5 * friction * pressed;
        let ends = (k * slip.norm() + pull.dot(&slip)) / (k * k - pull.norm_squared());
        let model = read(&text);
        let speed = model.length_scale() / model.time_scale();
        for tolerance in [1e-6, 1e-9] {
            let summary = go(&model, 1.2 * ends, tolerance, Method::Dop853);
            assert_eq!(kinds(&summary), ["rolls"], "case {case} at {tolerance}");
            // What the tolerance tells from rest slows down by at least this; the steps of the slip come on top.
            let off = (summary.events[0].time - ends).abs();
            let allowed = 4.0 * tolerance * speed.max(1.0) / (k - pull.norm());
            assert!(off < allowed, "case {case} at {tolerance}: {off} of {ends} s, allowed {allowed}");
            assert!(summary.statistics.steps < 200, "case {case} at {tolerance}: {} steps", summary.statistics.steps);
        }
    }
}

/// A log slides askew down a slope until it rolls: both ends slip, each in its own direction, and come to rest at one instant.
#[test]
fn a_log_that_slides_askew_rolls_when_both_ends_have_come_to_rest() {
    let mut random = Random::new(0x109);
    for case in 0..12 {
        let [along, across] = [random.between(-1.0, 1.0), random.between(2.0, 4.0)];
        let [velocity, turns] = [random.between(0.1, 0.8), random.between(-2.0, 2.0)];
        let text = format!(
            "gravity = [{along}, {across}, -8.7]\n{FLOOR}[[body]]\nname = \"log\"\ndensity = 300\n\
             shape = {{ cylinder = [0.07, 0.3], rpy = [0, 1.5707963267948966, 0] }}\n\
             hinge = {{ type = \"free\", position = [0, 0, 0.07, 1, 0, 0, 0], velocity = [{velocity}, 0.3, 0, {turns}, 0, 0] }}\n\
             [[contact]]\nbetween = [\"floor\", \"log\"]\nfriction = 0.35\n"
        );
        let model = read(&text);
        let all = [1e-5, 1e-7, 1e-9].map(|tolerance| go(&model, 0.5, tolerance, Method::Dop853));
        let finest = &all[2];
        assert_eq!(kinds(finest).first(), Some(&"rolls"), "case {case}");
        for (summary, tolerance) in all.iter().zip([1e-5, 1e-7, 1e-9]) {
            assert_eq!(kinds(summary), kinds(finest), "case {case} at {tolerance}");
            let off = (summary.events[0].time - finest.events[0].time).abs();
            assert!(off <= 100.0 * tolerance, "case {case} at {tolerance}: {off} s");
            assert!(summary.statistics.steps < 500, "case {case} at {tolerance}: {} steps", summary.statistics.steps);
        }
    }
}

/// A ball on a tilted turntable slips out of rolling: its slip grows from nothing, and friction turns it within a time that is as short as the
/// slip is slow. An implicit method follows that with the steps which the motion asks for, as long as its Newton matrix has that turn.
#[test]
fn a_slip_out_of_rolling_takes_implicit_methods_few_steps() {
    let mut random = Random::new(0x7a81e);
    let mut slipped = 0;
    for case in 0..8 {
        let [x, y, pressed] = [random.between(-3.0, 3.0), random.between(4.0, 6.0), random.between(6.0, 8.0)];
        let [rate, friction, radius] =
            [random.between(-1.5, -0.5), random.between(0.34, 0.44), random.between(0.1, 0.3)];
        let velocity = [random.between(-1.0, 1.0), random.between(-2.0, 0.0)];
        let text = format!(
            "gravity = [{x}, {y}, {}]\n[[body]]\nname = \"table\"\nmass = 5\ninertia = [1, 1, 1]\nshape = {{ plane = [0, 0, 1] }}\n\
             hinge = {{ type = \"revolute\", axis = [0, 0, 1], velocity = {rate} }}\n\
             [[drive]]\nhinge = \"table\"\ntype = \"rate\"\nrate = {rate}\n\
             [[body]]\nname = \"ball\"\nmass = 1.6\ninertia = [{1}, {1}, {1}]\nshape = {{ sphere = {radius} }}\n\
             hinge = {{ type = \"free\", position = [-0.4, 0.2, {radius}, 1, 0, 0, 0], velocity = [{2}, {3}, 0, 0, 0, 0] }}\n\
             [[contact]]\nbetween = [\"ball\", \"table\"]\nfriction = {friction}\n",
            -pressed,
            1.024 * radius * radius,
            velocity[0],
            velocity[1]
        );
        let model = read(&text);
        let explicit = go(&model, 2.0, 1e-8, Method::Dop853);
        let slips: Vec<f64> =
            explicit.events.iter().filter(|event| event.kind.name() == "slips").map(|e| e.time).collect();
        slipped += slips.len();
        for method in [Method::Radau5, Method::Radau9] {
            // A thousand tolerances: what begins to slip is told from rest at some tens of them, and its direction by as much. In single scenes radau5
            // took 800 steps and radau9 1800, where the one took 24 000 before.
            let implicit = go(&model, 2.0, 1e-8, method);
            assert_eq!(kinds(&implicit), kinds(&explicit), "case {case}, {method:?}");
            for (one, other) in implicit.events.iter().zip(&explicit.events) {
                assert!(
                    (one.time - other.time).abs() < 1e-5,
                    "case {case}, {method:?}: {} and {} s",
                    one.time,
                    other.time
                );
            }
            let steps = implicit.statistics.steps;
            assert!(steps < 4000, "case {case}, {method:?}: {steps} steps");
            let off = implicit
                .state
                .velocity
                .iter()
                .zip(&explicit.state.velocity)
                .fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()));
            assert!(off < 1e-5, "case {case}, {method:?}: {off} m/s apart");
        }
    }
    assert!(slipped > 3, "{slipped} of 8 balls slipped out of rolling");
}
