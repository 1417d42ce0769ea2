//! Loops, drives and gears: identities that hold for all of them, and what is said where they cannot be.

mod assembly;
mod bad_input;
mod cost;
mod couplings;
mod identities;
mod linkages;
mod locks;
mod massless;
mod modes;
mod motors;
mod order;
mod prestress;
mod rank;
mod repeats;
mod stops;
mod trusses;

use std::sync::Arc;
use stillpoint::constraint::assemble;
use stillpoint::model::Model;
use stillpoint::record::Fanout;
use stillpoint::scenario::{self, Scenario};
use stillpoint::simulate::{self, Settings, State, Summary};

/// A scenario's text, read, built and assembled.
fn read(text: &str) -> (Scenario, Arc<Model>) {
    let scenario = scenario::parse("scene.toml", text, &[])
        .unwrap_or_else(|problems| panic!("{}\n{text}", problems.render(false)));
    let model = Model::build(&scenario.description).expect("a model");
    let (model, _) = assemble(model).expect("an assembly");
    (scenario, model)
}

/// A run from the start as given.
fn run(model: &Arc<Model>, settings: &Settings) -> Summary {
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    simulate::run(model, settings, 10.0, &start, &mut Fanout::new(), &mut |_, _| true)
        .unwrap_or_else(|error| panic!("{error}"))
}

fn coordinate(model: &Model, list: &[f64], body: &str) -> f64 {
    list[model.bodies[model.body(body).expect("a body")].hinge.position]
}

/// A crank-rocker whose crank is the shortest bar.
const FOUR_BAR: &str = r#"
[[body]]
name = "crank"
mass = 2.0
center = [0.0, 0.0, 0.05]
inertia = [0.004, 0.004, 0.001]
markers = { pin = [0.0, 0.0, 0.1] }
hinge = { type = "revolute", axis = [0.0, 1.0, 0.0], velocity = 14.0 }

[[body]]
name = "coupler"
mass = 0.6
center = [0.0, 0.0, 0.175]
inertia = [0.006, 0.006, 0.0001]
markers = { pin = [0.0, 0.0, 0.35] }
hinge = { type = "revolute", parent = "crank", at = "pin", axis = [0.0, 1.0, 0.0], position = 1.1 }

[[body]]
name = "rocker"
mass = 0.5
center = [0.0, 0.0, 0.15]
inertia = [0.004, 0.004, 0.0001]
markers = { pin = [0.0, 0.0, 0.3] }
hinge = { type = "revolute", at = [0.4, 0.0, 0.0], axis = [0.0, 1.0, 0.0], position = -0.2 }

[[loop]]
name = "coupler-rocker"
type = "revolute"
between = ["coupler.pin", "rocker.pin"]
axis = [0.0, 1.0, 0.0]
"#;
