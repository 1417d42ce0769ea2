//! Inverse statics: the pose is given, the inputs that hold it are found, or it is said that none can.

use crate::common::{Options, build, random_scene};
use stillpoint::dynamics::System;
use stillpoint::model::{Model, Parameter, Side};
use stillpoint::scenario::{self, Scenario};
use stillpoint::statics::{InverseAnswer, Settings, hold};

fn held(scenario: &Scenario) -> InverseAnswer {
    let pose = Model::build(&scenario.description).expect("a model").start_position.clone();
    hold(&scenario.description, &scenario.unknown, &pose, &scenario.statics).expect("numbers that are finite")
}

fn read(text: &str) -> Scenario {
    scenario::parse("inverse.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}"))
}

/// With a motor in every hinge any pose can be held, and only by the forces that the balance leaves open.
#[test]
fn motors_in_all_hinges_hold_every_pose() {
    for seed in 0..30 {
        let mut description = random_scene(seed, &Options { bodies: 9, springs: true, welds: true });
        let unknown = Parameter::find(&description, "hinge.force").expect("hinges");
        let pose = build(&description).start_position.clone();
        let held = hold(&description, &unknown, &pose, &Settings::default()).expect("finite numbers");
        assert!(held.found.converged, "seed {seed}: {:?}", held.found.notes);
        // The same forces from one balance without motors: `τ = M·0 + b − springs and loads`.
        description.bodies.iter_mut().for_each(|body| body.hinge.force.clear());
        let model = build(&description);
        let rest = vec![0.0; model.velocity_count()];
        let mut needed = rest.clone();
        System::new(&model).at(0.0, &pose, &rest).residual(&rest, &mut needed).expect("finite numbers");
        let largest = needed.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        // In the order of the addresses, body by body.
        let order = model.bodies.iter().flat_map(|body| {
            let (_, count) = body.hinge.kind.counts();
            body.hinge.velocity..body.hinge.velocity + count
        });
        for (at, (address, value)) in order.zip(&held.found.unknowns) {
            // Round-off of sums of some hundred terms.
            assert!((value - needed[at]).abs() < 1e-12 * largest, "seed {seed}: {address} {value} {}", needed[at]);
        }
    }
}

/// An arm of 1 m and 2 kg on a hinge, horizontal, with springs from its tip straight up.
fn arm(springs: &[(f64, f64)], unknown: &str) -> String {
    let mut text = format!(
        "gravity = [0, 0, -10]\n[statics]\nunknown = {unknown}\n[[body]]\nname = \"arm\"\nmass = 2\ncenter = [0.5, 0, 0]\n\
         inertia = [0.01, 0.2, 0.2]\nhinge = {{ type = \"revolute\", axis = [0, 1, 0] }}\n"
    );
    for (index, (stiffness, length)) in springs.iter().enumerate() {
        text += &format!(
            "[[force]]\nname = \"s{index}\"\ntype = \"spring\"\nstiffness = {stiffness}\nlength = {length}\n\
             between = [{{ body = \"arm\", at = [1, 0, 0] }}, {{ body = \"ground\", at = [1, 0, 1] }}]\n"
        );
    }
    text
}

/// `Σ kᵢ (1 − lᵢ) = 10 N`; of all answers the one that changes the lengths least changes them by multiples of `kᵢ`.
#[test]
fn of_many_answers_the_least_change_is_taken() {
    let scenario = read(&arm(&[(100.0, 0.9), (300.0, 1.0)], "[\"s0.length\", \"s1.length\"]"));
    let found = held(&scenario).found;
    assert!(found.converged, "{:?}", found.notes);
    // They pull 10 N already: nothing changes.
    assert_eq!(found.unknowns, [("s0.length".to_owned(), 0.9), ("s1.length".to_owned(), 1.0)]);
    let found = held(&read(&arm(&[(100.0, 1.0), (300.0, 1.0)], "[\"s0.length\", \"s1.length\"]"))).found;
    assert!(found.notes.iter().any(|note| note.contains("determines 1 of 2 unknowns")), "{:?}", found.notes);
    let changes = found.unknowns.iter().map(|(_, length)| 1.0 - length).collect::<Vec<_>>();
    let factor = 10.0 / (100.0_f64.powi(2) + 300.0_f64.powi(2));
    assert!((changes[0] - 100.0 * factor).abs() < 1e-14 && (changes[1] - 300.0 * factor).abs() < 1e-14, "{changes:?}");
}

#[test]
fn stiffness_mass_and_loads_can_be_unknown_too() {
    for (unknown, expected) in [("s0.stiffness", 50.0), ("arm.mass", 4.0), ("gravity[2]", -20.0), ("arm.force", 10.0)] {
        // Pulls 20 N at 1 m for `length = 0.8`, k = 100; the arm weighs 10 N there.
        let found = held(&read(&arm(&[(100.0, 0.8)], &format!("[\"{unknown}\"]")))).found;
        assert!(found.converged, "{unknown}: {:?}", found.notes);
        let (_, value) = &found.unknowns[0];
        assert!((value - expected).abs() < 1e-12 * f64::abs(expected), "{unknown} = {value}");
    }
}

#[test]
fn what_no_unknown_can_hold_is_named() {
    let two = "[[body]]\nname = \"hand\"\nmass = 1\ncenter = [0.25, 0, 0]\ninertia = [0.01, 0.1, 0.1]\n\
               hinge = { type = \"revolute\", parent = \"arm\", at = [1, 0, 0], axis = [0, 1, 0] }\n";
    let found = held(&read(&(arm(&[(100.0, 0.9)], "[\"s0.length\"]") + two))).found;
    assert!(!found.converged && !found.balanced);
    let note = found.notes.last().expect("a note");
    assert!(note.starts_with("no unknown balances 2.5 N m in `hand` along [0.000, 1.000, 0.000]"), "{note}");
}

#[test]
fn an_unknown_that_cannot_influence_the_pose_is_named() {
    let idle = "[[force]]\nname = \"idle\"\ntype = \"spring\"\nstiffness = 5\nlength = 1\nbetween = [\"post\", \
                { body = \"ground\", at = [3, 0, 1.5] }]\n[[body]]\nname = \"post\"\nmass = 1\nhinge = { type = \"fixed\", \
                at = [3, 0, 0] }\n";
    let text = arm(&[(100.0, 0.8)], "[\"s0.length\", \"idle.length\"]") + idle;
    let found = held(&read(&text)).found;
    assert!(!found.converged && found.balanced, "the others do hold it");
    assert!(found.notes[0].contains("`idle.length` cannot influence the pose"), "{:?}", found.notes);
    assert_eq!(found.unknowns[1], ("idle.length".to_owned(), 1.0));
}

#[test]
fn a_value_that_cannot_be_is_not_taken() {
    // A spring of 5 N/m and 1 m pulls 5 N at most: its free length would have to be −1 m.
    let scenario = read(&arm(&[(5.0, 0.5)], "[\"s0.length\"]"));
    let held = held(&scenario);
    assert!(!held.found.converged && !held.found.balanced);
    let note = &held.found.notes[0];
    assert!(note.contains("`s0.length` = -1 m") && note.contains("cannot be"), "{note}");
    assert_eq!(held.description, scenario.description, "the scene stays what it was");
}

/// A pose that would run away is held all the same, and called what it is.
#[test]
fn an_unstable_pose_is_held_and_said_to_be_unstable() {
    let text = arm(&[], "[\"arm.force\"]").replace("axis = [0, 1, 0]", "axis = [0, 1, 0], position = -0.8");
    let found = held(&read(&text)).found;
    assert!(found.converged && found.stability.expect("a verdict").unstable_directions == 1);
    assert!((found.unknowns[0].1 + 10.0 * f64::cos(0.8)).abs() < 1e-13, "{:?}", found.unknowns);
}

#[test]
fn addresses_are_checked_in_the_file() {
    let bad = [
        ("[\"arm.forc\"]", "no number `forc`"),
        ("[\"leg.force\"]", "nothing is called `leg`"),
        ("[\"arm.position\"]", "part of the pose"),
        ("[\"arm.force\", \"hinge.force\"]", "`arm.force` is unknown twice"),
        ("[]", "must be"),
        ("[3]", "must be"),
    ];
    for (unknown, expected) in bad {
        let problems = scenario::parse("inverse.toml", &arm(&[], unknown), &[]).expect_err("a problem");
        let first = problems.iter().next().expect("one");
        assert!(first.message.contains(expected) && first.place.as_ref().is_some_and(|at| at.line == 3), "{problems}");
    }
}

/// The arm lies on a post: its limit bears what the spring leaves, and no more than the weight. A spring that lifts it lets
/// the post go, and the length that just does is the answer, not one at which the post would pull.
#[test]
fn a_touched_stop_bears_what_the_unknowns_leave_and_never_pulls() {
    let on_post = |springs: &[(f64, f64)], limits: &str| {
        let text = arm(springs, "[\"s0.length\"]");
        held(&read(&text.replace("axis = [0, 1, 0] }", &format!("axis = [0, 1, 0], limits = {limits} }}")))).found
    };
    // Turning about +y lowers the arm: its post is the upper limit. A spring of 4 N leaves 6 N m to it: nothing changes.
    let lying = on_post(&[(100.0, 0.96)], "[-1.0, 0.0]");
    assert!(lying.converged, "{:?}", lying.notes);
    assert_eq!(lying.unknowns, [("s0.length".to_owned(), 0.96)]);
    assert!((lying.stops[0].load - 6.0).abs() < 1e-12 && lying.stops[0].side == Side::High, "{:?}", lying.stops);
    // One of 30 N would lift it: 10 N are enough.
    let lifted = on_post(&[(100.0, 0.7)], "[-1.0, 0.0]");
    assert!(lifted.converged && lifted.stops.is_empty(), "{:?} {:?}", lifted.notes, lifted.stops);
    assert!((lifted.unknowns[0].1 - 0.9).abs() < 1e-12, "{:?}", lifted.unknowns);
    // A limit that the pose has passed is no place to be.
    let beyond = on_post(&[(100.0, 0.96)], "[-1.0, -0.1]");
    assert!(!beyond.converged && !beyond.balanced);
    assert!(beyond.notes[0].contains("beyond the limit -0.1 of `arm`, which stands at 0"), "{:?}", beyond.notes);
    // Rubber that is pressed is a spring: 50 N m/rad over 0.1 rad are 5 N m, the spring has to pull the other 5 N.
    let rubber = on_post(&[(100.0, 1.0)], "{ high = -0.1, low = -1.0, stiffness = 50.0, damping = 1.0 }");
    assert!(rubber.converged, "{:?}", rubber.notes);
    assert!((rubber.unknowns[0].1 - 0.95).abs() < 1e-12 && (rubber.stops[0].load - 5.0).abs() < 1e-12);
}

/// A parallelogram on the stop of one rod: the stop stands for the weights of all bars, through the loop, and a motor in
/// the other rod takes nothing from it unless it has to.
#[test]
fn a_stop_beside_a_loop_bears_through_it() {
    let (scenario, _) = crate::scenarios::shipped("parallelogram_on_stop", &[]);
    let text = scenario.text.replace("position = 1.0", "position = 0.2").replace("position = -1.0", "position = -0.2");
    let text = text.replacen("[simulate]", "[statics]\nunknown = [\"left.force\"]\n[simulate]", 1);
    let weights = (2.0 * 0.25 + 2.0 * 0.5) * 9.80665 * 0.2_f64.sin();
    let found = held(&read(&text)).found;
    assert!(found.converged, "{:?}", found.notes);
    assert!((found.stops[0].load - weights).abs() < 1e-9, "{:?}", found.stops);
    assert!(found.unknowns[0].1.abs() < 1e-12);
    // With the limit on the other side the stop would have to pull: the motor holds all of it.
    let found = held(&read(&text.replace("low = 0.2", "high = 0.2"))).found;
    assert!(found.converged && found.stops.is_empty(), "{:?} {:?}", found.notes, found.stops);
    assert!((found.unknowns[0].1.abs() - weights).abs() < 1e-9, "{:?}", found.unknowns);
}
