//! A scene in code, its equilibrium, what kind of equilibrium it is, and what the hinges bear:
//! `cargo run --example equilibrium`

#![allow(clippy::print_stdout, clippy::unwrap_used)]

use stillpoint::model::Model;
use stillpoint::model::description::{BodyDescription, Description, ForceDescription, GROUND, HingeDescription};
use stillpoint::statics;

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    // A boom on a pin, held by a cable; the guess is level.
    let pin = HingeDescription::revolute([0.0, 1.0, 0.0]);
    let boom = BodyDescription::new("boom", pin)
        .mass(40.0)
        .center([1.5, 0.0, 0.0])
        .inertia([0.2, 30.0, 30.0])
        .marker("end", [3.0, 0.0, 0.0]);
    let cable = ForceDescription::spring("cable", ("boom", "end"), (GROUND, [0.0, 0.0, 2.5]), 4000.0, 3.8, 0.0);
    let scene = Description::new("Boom on a cable").body(boom).force(cable);
    let model = Model::build(&scene).map_err(|problems| format!("{problems:?}"))?;

    let found = statics::equilibrium(&model, &statics::Settings::default(), &model.start_position)?;
    assert!(found.converged, "{:?}", found.notes);
    println!("the boom rests at {:.4} rad, {:.1e} N m unbalanced", found.position[0], found.residual_force);
    if let Some(stability) = &found.stability {
        println!("{}: {:.3} Hz", stability.verdict.name(), stability.modes[0].frequency_hz);
    }
    let force = found.reactions[0].force;
    println!("the pin bears {:.1} N, {:.1} N upwards", force.norm(), force.z);
    Ok(())
}
