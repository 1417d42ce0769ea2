//! One number of a scenario varied, an equilibrium for each, every one starting from the last:
//! `cargo run --example sweep`

#![allow(clippy::print_stdout, clippy::unwrap_used)]

use stillpoint::model::{Model, Parameter};
use stillpoint::scenario;
use stillpoint::statics;

const SCENARIO: &str = r#"
[[body]]
name = "arm"
mass = 2.0
center = [0.4, 0.0, 0.0]
inertia = [0.01, 0.03, 0.03]
hinge = { type = "revolute", axis = [0.0, 1.0, 0.0], stiffness = 10.0 }
"#;

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let scenario = scenario::parse("arm.toml", SCENARIO, &[])?;
    let mut description = scenario.description;
    let stiffness = Parameter::find(&description, "arm.stiffness")?;
    let mut guess: Option<Vec<f64>> = None;
    for value in [80.0, 40.0, 20.0, 10.0, 5.0] {
        stiffness.iter().try_for_each(|one| one.set(&mut description, value))?;
        let model = Model::build(&description).map_err(|problems| format!("{problems:?}"))?;
        let start = guess.as_ref().unwrap_or(&model.start_position);
        let found = statics::equilibrium(&model, &scenario.statics, start)?;
        assert!(found.converged, "{:?}", found.notes);
        println!("{value:>5} N m/rad: {:.6} rad after {} steps", found.position[0], found.iterations);
        guess = Some(found.position);
    }
    Ok(())
}
