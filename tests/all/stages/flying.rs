//! Statics after a stage that lets a body fly.

use crate::common::answered;
use stillpoint::model::Model;
use stillpoint::model::description::Description;
use stillpoint::scenario::{Scenario, parse};
use stillpoint::simulate::at_stage;
use stillpoint::statics::Equilibrium;

/// A carriage on a spring with a ball on it, let go of by a stage; `more` is what else the scene has.
fn scene(gravity: f64, more: &str) -> Scenario {
    let text = format!(
        r#"
        gravity = [0.0, 0.0, {gravity:?}]
        [[body]]
        name = "carriage"
        mass = 3.0
        hinge = {{ type = "prismatic", axis = [0, 0, 1], stiffness = 300.0 }}
        [[body]]
        name = "ball"
        mass = 2.0
        inertia = [0.1, 0.1, 0.1]
        shape = {{ sphere = 0.1 }}
        hinge = {{ type = "fixed", parent = "carriage", at = [0, 0, 1] }}
        [[stage]]
        name = "let go"
        when = {{ time = 1.0 }}
        open = ["ball"]
        {more}
        "#
    );
    parse("scene.toml", &text, &[]).unwrap_or_else(|problem| panic!("{}", problem.render(false)))
}

/// What a stage leaves where the scene rests, at `z`, and its equilibrium.
fn after(scenario: Scenario, z: f64) -> (Description, Vec<String>, Equilibrium) {
    let (left, said) = at_stage(&scenario.description, "let go", Some(&[z])).unwrap();
    let model = Model::build(&left).unwrap();
    let scenario = Scenario { description: left.clone(), ..scenario };
    (left, said, answered(&scenario, model).unwrap().found)
}

/// The carriage is at rest without the ball, which stays where it was let go.
#[test]
fn what_flies_is_held_and_the_rest_is_in_balance_without_it() {
    let z = -5.0 * 10.0 / 300.0;
    let (left, said, found) = after(scene(-10.0, ""), z);
    assert_eq!(said, ["`ball` flies: nothing else acts on it, and statics holds it where its hinge opens"]);
    assert!(left.bodies[1].hinge.lock && found.converged, "{:?}", found.notes);
    assert!((found.position[0] + 0.1).abs() < 1e-12, "{:?}", found.position);
    assert_eq!(found.position[1..4], [0.0, 0.0, 1.0 + z]);
    let modes = &found.stability.as_ref().expect("a verdict").modes;
    assert!((modes[0].frequency_hz - 10.0 / std::f64::consts::TAU).abs() < 1e-12 && modes.len() == 1, "{modes:?}");
}

/// What a spring reaches finds its own balance, what may touch something is not said to fly, and without gravity nothing falls.
#[test]
fn what_something_acts_on_is_not_held() {
    let spring = r#"
        [[force]]
        type = "spring"
        between = ["ball", { body = "ground", at = [0, 0, 3] }]
        stiffness = 50.0
        length = 1.0
        "#;
    let (left, said, found) = after(scene(-10.0, spring), -0.15);
    assert!(said.is_empty() && !left.bodies[1].hinge.lock && found.converged, "{said:?} {:?}", found.notes);
    // 2 kg on 50 N/m, 1 m long, under 3 m.
    assert!((found.position[3] - 1.6).abs() < 1e-9, "{:?}", found.position);
    let floor = r#"
        [[body]]
        name = "floor"
        shape = { plane = [0, 0, 1], at = [0, 0, -4] }
        hinge = { type = "fixed" }
        [[contact]]
        between = ["ball", "floor"]
        "#;
    for scenario in [scene(-10.0, floor), scene(0.0, "")] {
        let (left, said) = at_stage(&scenario.description, "let go", Some(&[0.0])).unwrap();
        assert!(said.is_empty() && !left.bodies[1].hinge.lock, "{said:?}");
    }
}

/// The shipped launcher has its modes after a rocket has left.
#[test]
fn the_launcher_is_at_rest_without_its_first_rocket() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/launcher.toml");
    let mut scenario = stillpoint::scenario::load(path.as_ref()).unwrap_or_else(|error| panic!("{error}"));
    (scenario.unknown, scenario.aim) = Default::default();
    let (left, said) = at_stage(&scenario.description, "exit_1", None).unwrap();
    assert!(said.iter().any(|said| said.starts_with("`rocket_1` flies")), "{said:?}");
    let model = stillpoint::constraint::assemble(Model::build(&left).unwrap()).unwrap().0;
    let found = answered(&Scenario { description: left, ..scenario }, model).unwrap().found;
    assert!(found.converged, "{:?}", found.notes);
    assert!(found.stability.as_ref().is_some_and(|stability| stability.modes[0].frequency_hz > 1.0));
}
