//! Statics heeds the limits of hinges: what lies on its stop rests there, and the stop says what it bears.

use crate::common::{Random, build};
use crate::scenarios::{found, shipped};
use std::sync::Arc;
use stillpoint::dynamics::System;
use stillpoint::model::{Model, Side, StopLaw};
use stillpoint::scenario;
use stillpoint::statics::{BearingStop, Equilibrium, Method, Settings, StabilityVerdict, Want, equilibrium};

const G: f64 = 9.80665;

fn read(text: &str) -> Arc<Model> {
    build(&scenario::parse("stops.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}")).description)
}

fn find(model: &Arc<Model>) -> Equilibrium {
    let found = equilibrium(model, &Settings::default(), &model.start_position).expect("statics");
    assert!(found.converged, "{:?}", found.notes);
    found
}

fn stop<'a>(found: &'a Equilibrium, hinge: &str) -> &'a BearingStop {
    found.stops.iter().find(|stop| stop.hinge == hinge).unwrap_or_else(|| panic!("{hinge}: {:?}", found.stops))
}

#[track_caller]
fn near(found: f64, expected: f64, tolerance: f64) {
    assert!((found - expected).abs() <= tolerance, "found {found}, expected {expected} within {tolerance:e}");
}

/// The moments of all weights about each hinge are what its stop bears; the hand hangs straight down.
#[test]
fn the_stops_of_the_arm_bear_the_moments_of_its_weights() {
    let (scenario, model) = shipped("arm_on_stop", &[]);
    let found = found(&scenario, &model);
    let (upper, elbow, wrist) = (found.position[0], found.position[1], found.position[2]);
    near(upper, 0.4, 0.0);
    near(upper + elbow + wrist, std::f64::consts::FRAC_PI_2, 1e-9);
    let rubber = stop(&found, "`fore`");
    let of_fore = G * (2.0 * 0.25 + 0.5 * 0.5) * (upper + elbow).cos();
    near(rubber.load, of_fore, 1e-9);
    near(rubber.load, 400.0 * rubber.depth, 1e-9);
    near(elbow, 0.1 + rubber.depth, 1e-12);
    let rigid = stop(&found, "`upper`");
    near(rigid.load, of_fore + G * (3.0 * 0.3 + 2.5 * 0.6) * upper.cos(), 1e-9);
    assert!(rigid.side == Side::High && rubber.side == Side::High && rigid.depth == 0.0 && found.stops.len() == 2);
    // Only what the stops leave free decides; the mode of the hand does not move the shoulder.
    let stability = found.stability.as_ref().expect("a verdict");
    assert_eq!((stability.verdict, stability.modes.len()), (StabilityVerdict::Stable, 2));
    assert!(stability.modes.iter().all(|mode| mode.shape.len() == 3 && mode.shape[0] == 0.0));
    // All methods say the same, from where Newton alone does not stand the hand upright.
    let near_by = [0.3, 0.0, 1.2];
    for method in Method::ALL {
        let other = equilibrium(&model, &Settings { method, want: Want::Stable, ..Settings::default() }, &near_by)
            .expect("statics");
        assert!(other.converged, "{method:?}: {:?}", other.notes);
        near(stop(&other, "`upper`").load, rigid.load, 1e-6);
        near(other.position[1], elbow, 1e-8);
    }
}

/// What falls lands: without its ledge the tray has no equilibrium at all.
#[test]
fn what_falls_comes_to_rest_on_its_stop() {
    let (_, model) = shipped("stops", &[]);
    let found = find(&model);
    let at = |name: &str| found.position[model.bodies[model.body(name).expect("a body")].hinge.position];
    near(at("tray"), -0.2, 0.0);
    near(stop(&found, "`tray`").load, 9.81, 1e-9);
    near(stop(&found, "`hammer`").load, 2.0 * 9.81, 1e-9);
    near(at("hammer"), -2.0 * 9.81 / 2e4, 1e-12);
    near(at("pendulum"), 0.0, 1e-9);
}

/// A lever pushed off its stop leaves it; one pushed onto it stays, and the push decides how hard.
#[test]
fn a_stop_never_pulls() {
    let lever = |force: f64| {
        read(&format!(
            "gravity = [0, 0, 0]\n[[body]]\nname = \"lever\"\nmass = 1\ninertia = [1, 1, 1]\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], stiffness = 2.0, force = {force}, limits = [0.0, 1.0] }}\n"
        ))
    };
    let off = find(&lever(0.5));
    near(off.position[0], 0.25, 1e-12);
    assert!(off.stops.is_empty(), "{:?}", off.stops);
    let on = find(&lever(-0.5));
    near(on.position[0], 0.0, 0.0);
    near(stop(&on, "`lever`").load, 0.5, 1e-12);
    let far = find(&lever(5.0));
    assert_eq!(stop(&far, "`lever`").side, Side::High);
    near(stop(&far, "`lever`").load, 3.0, 1e-12);
}

/// An upright rod between two stops falls onto one of them; held exactly between, it is unstable, and said to be.
#[test]
fn an_inverted_pendulum_lies_on_a_stop() {
    let rod = |position: f64| {
        read(&format!(
            "[[body]]\nname = \"rod\"\nmass = 1\ncenter = [0, 0, 0.5]\ninertia = [0.1, 0.1, 0.01]\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], position = {position}, limits = [-0.3, 0.3] }}\n"
        ))
    };
    for (position, side) in [(0.1, 0.3), (-0.1, -0.3)] {
        let found = find(&rod(position));
        near(found.position[0], side, 0.0);
        near(found.stops[0].load, G * 0.5 * 0.3_f64.sin(), 1e-12);
    }
    let model = rod(0.0);
    let any = Settings { want: Want::Any, ..Settings::default() };
    let between = equilibrium(&model, &any, &model.start_position).expect("statics");
    assert!(between.converged && between.stops.is_empty() && between.position[0] == 0.0);
    assert_eq!(between.stability.expect("a verdict").verdict, StabilityVerdict::Unstable);
}

/// Loads that turn with their bodies have no potential, and where the turns from the guess meet no set that bears, the stops at which the motion
/// itself comes to rest are those. What they bear is the virtual work of all loads.
#[test]
fn stops_beside_loads_that_turn_with_their_bodies_are_found_by_the_motion() {
    let model = read(
        r#"
        [[body]]
        name = "b0"
        mass = 0.3832081533334364
        center = [-0.13870553779937014, 0.25739276437714614, -0.057391297464484466]
        inertia = [0.01093447322423046, 0.008560638250371035, 0.007887583926438162]
        hinge = { type = "revolute", at = [-1.1780088401310633, -0.23441952099004237, 0.1139271455735039], rpy = [0.46897786508742256, 0.568981263834284, 0.6346777881599402], axis = [0.49716074405376404, 0.14242573607056525, 0.6904853540677682], limits = { low = -0.14703257126722344, high = 0.20857778231999538 } }
        [[body]]
        name = "b1"
        mass = 1.3287573104605028
        center = [-0.12698949361324613, -0.023915463271919714, -0.506200330187409]
        inertia = [0.027739800919735484, 0.02814315826041127, 0.03935643174606057]
        hinge = { type = "revolute", at = [0.34088073654990725, -0.32858163814190666, 0.0087458831093812], rpy = [0.38459732712472716, 0.3572249408239553, 0.532308087178229], parent = "b0", axis = [0.3997742267234366, -0.9054790553600608, -0.3781625540393897], limits = { low = -0.071631267360289, high = 0.2950066164731744 } }
        [[force]]
        type = "load"
        name = "e0"
        on = { body = "b0", at = [-0.8636602115961743, 0.21721182177292866, 0.11886780116613894] }
        force = [0.21852145523442879, 16.017788913209156, -2.393556274730243]
        axes = "body"
        [[force]]
        type = "rope"
        name = "e1"
        through = [{ body = "b1", at = [0.08963781747815808, 0.10999834198588258, 0.6795937876202183] }, { body = "ground", at = [-1.8531518828110498, -0.7796196063115359, -2.7533722951126176] }, { body = "ground", at = [1.670222491829157, 0.7137421182990187, 2.9266057824391236] }]
        stiffness = 7.504202255808212
        length = 0.5570096775742437
        [[force]]
        type = "rope"
        name = "e2"
        through = [{ body = "b0", at = [-0.5077895406037708, 0.15675692372509764, 0.41906328394719056] }, { body = "ground", at = [0.5354229246876716, -1.625882190620652, -0.8307145203593707] }, { body = "b1", at = [0.9983654458458933, 1.4569312330036648, 0.2072047166379982] }]
        stiffness = 34.80780860944723
        length = 0.5540301997008261
        [[force]]
        type = "load"
        name = "e3"
        on = { body = "b0", at = [0.07852428372267231, -0.07931741851934415, -0.5178268764129058] }
        force = [9.827395110230576, -4.992955985391521, -11.849437664170246]
        axes = "body"
        "#,
    );
    let settings = Settings { want: Want::Any, ..Settings::default() };
    let found = equilibrium(&model, &settings, &model.start_position).expect("statics");
    assert!(found.converged, "{:?}", found.notes);
    near(stop(&found, "`b0`").load, 58.741, 1e-3);
    near(stop(&found, "`b1`").load, 144.599, 1e-3);
    assert!(found.stops.iter().all(|stop| stop.side == Side::High));
}

/// Two arms that a gear ties together, each between soft stops: along the one motion that is left the potential, stops included, has a minimum
/// where they are found, and stops bear what their stiffness says.
#[test]
fn soft_stops_beside_a_gear_bear_at_a_minimum() {
    let mut random = Random::new(0x50f7_5704);
    let mut pressed = [0; 3];
    for case in 0..200 {
        let ratio = random.between(0.4, 1.6) * if case % 2 == 0 { 1.0 } else { -1.0 };
        let (mut text, mut arms) = (String::new(), Vec::new());
        for (name, others) in [("a", ratio), ("b", 1.0)] {
            let mut between = |low: f64, high: f64| random.between(low, high);
            let (mass, length, turn) = (between(0.5, 3.0), between(0.2, 0.8), between(-3.0, 3.0));
            let (low, high) = (between(-0.9, 0.3), between(0.3, 0.9));
            let (soft, spring, rest) = (10f64.powf(between(0.5, 3.0)), between(0.0, 20.0), between(-0.5, 0.5));
            text += &format!(
                "[[body]]\nname = \"{name}\"\nmass = {mass:?}\ncenter = [{:?}, 0, {:?}]\ninertia = [0.01, 0.01, 0.01]\nhinge = {{ type = \
                 \"revolute\", axis = [0, 1, 0], stiffness = {spring:?}, rest = {rest:?}, limits = {{ low = {low:?}, high = {high:?}, stiffness = \
                 {soft:?} }} }}\n",
                length * turn.sin(),
                -length * turn.cos()
            );
            let potential = move |angle: f64| {
                let depth = (angle - high).max(low - angle).max(0.0);
                -mass * G * length * (angle - turn).cos()
                    + 0.5 * spring * (angle - rest).powi(2)
                    + 0.5 * soft * depth * depth
            };
            arms.push(move |along: f64| potential(others * along));
        }
        text += &format!("[[gear]]\ntype = \"ratio\"\nratio = {ratio:?}\nbetween = [\"a\", \"b\"]\n");
        let found = find(&read(&text));
        assert!(found.converged, "case {case}: {:?}\n{text}", found.notes);
        assert!((found.position[0] - ratio * found.position[1]).abs() < 1e-12, "case {case}: {:?}", found.position);
        let energy = |along: f64| arms.iter().map(|arm| arm(along)).sum::<f64>();
        let (at, h) = (found.position[1], 1e-4);
        let (before, here, after) = (energy(at - h), energy(at), energy(at + h));
        let (slope, bend) = ((after - before) / (2.0 * h), (after - 2.0 * here + before) / (h * h));
        assert!(bend > 0.0 && slope.abs() < 0.5 * h * bend, "case {case}: {slope} {bend}\n{text}");
        pressed[found.stops.len()] += 1;
    }
    assert!(pressed[1] > 40 && pressed[2] > 10, "{pressed:?}");
}

/// Where stops by turns lead nowhere, compliant ones as springs do: no way along the motions that a gear leaves goes down in the potential, stops included.
#[test]
fn soft_stops_beside_a_gear_are_found_as_springs() {
    let model = read(
        r#"
        gravity = [0, 0, -9.8066]
        [[body]]
        name = "b0"
        mass = 0.782
        center = [0.0001, 0.1643, -0.0717]
        inertia = [0.0211, 0.0197, 0.0169]
        hinge = { type = "revolute", at = [0.0632, -0.368, 1.4195], rpy = [-0.1008, 0.0112, -0.403], parent = "ground", axis = [-1.5879, -0.7717, -0.4972], armature = 0.1176, limits = { low = -0.0432, high = 0.4742, stiffness = 428.9908 } }
        [[body]]
        name = "b1"
        mass = 2.0551
        center = [-0.0999, -0.0083, 0.1098]
        inertia = [0.05, 0.0437, 0.0609]
        hinge = { type = "planar", at = [-0.5927, -1.3445, -0.4286], rpy = [-1.2644, -1.5731, -0.214], parent = "ground", stiffness = [74.2247, 51.6621, 88.4009], rest = [-0.1681, 0.0494, 0.3467], force = [1.4603, 5.3262, -1.1739], armature = [0.4602, 0.482, 0.2419], limits = { low = -0.0106, high = 0.9339, stiffness = 130.2994 } }
        [[body]]
        name = "b2"
        mass = 1.6667
        center = [-0.0096, 0.1816, -0.3526]
        inertia = [0.0484, 0.0367, 0.0339]
        hinge = { type = "revolute", at = [-0.0344, -0.6561, 0.1963], rpy = [1.1756, 0.6738, 0.9228], parent = "ground", axis = [0.2534, -0.2235, -0.2297], stiffness = 15.008, rest = -0.0353, limits = { low = 0.0056, high = 0.4124, stiffness = 264.5524 } }
        [[force]]
        type = "spring"
        name = "e0"
        between = [{ body = "b0", at = [1.218, 0.2618, 0.153] }, { body = "ground", at = [0.6333, 0.7592, 4.4696] }]
        stiffness = 39.7422
        length = 1.7451
        [[force]]
        type = "spring"
        name = "e1"
        between = [{ body = "b1", at = [0.1656, -0.3801, -0.306] }, { body = "b2", at = [0.1432, 0.8697, 0.1506] }]
        stiffness = 255.6956
        length = 0.9174
        [[gear]]
        type = "ratio"
        ratio = 0.5684
        between = ["b0", "b2"]
        "#,
    );
    let found = find(&model);
    assert!(!found.stops.is_empty());
    let rest = vec![0.0; model.velocity_count()];
    let potential = |q: &[f64]| {
        let depth = |stop: &stillpoint::model::Stop| {
            let value = q[stop.position];
            (value - stop.range[1]).max(stop.range[0] - value).max(0.0)
        };
        let stiffness = |stop: &stillpoint::model::Stop| match stop.law {
            StopLaw::Compliant { stiffness, .. } => stiffness,
            StopLaw::Rigid { .. } => unreachable!("all of them are soft"),
        };
        let of_stops: f64 = model.stops.iter().map(|stop| 0.5 * stiffness(stop) * depth(stop).powi(2)).sum();
        System::new(&model).at(0.0, q, &rest).energies().potential + of_stops
    };
    // b0, then x, y, angle of b1, then b2: the gear turns b0 by 0.5684 of b2.
    let ways =
        [[0.5684, 0.0, 0.0, 0.0, 1.0], [0.0, 1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0, 0.0]];
    for way in ways {
        let at = |h: f64| potential(&found.position.iter().zip(way).map(|(q, by)| q + h * by).collect::<Vec<_>>());
        let [before, here, after] = [at(-1e-4), at(0.0), at(1e-4)];
        // A slope of 1e-4 of what a radian of it would cost.
        let (slope, bend) = ((after - before) / 2e-4, (after - 2.0 * here + before) / 1e-8);
        assert!(bend > 0.0 && slope.abs() < 1e-4 * bend, "{way:?}: {slope} {bend}");
    }
}
