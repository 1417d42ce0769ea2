//! What every command asks of a scene: its equilibrium, or the inputs that hold its pose.

use super::certify::equilibrium::Equilibrium;
use super::inverse::{Held, hold};
use super::search::equilibrium_while;
use super::settings::Settings;
use crate::dynamics::Fault;
use crate::model::description::Description;
use crate::model::{Model, Parameter};
use std::sync::Arc;

/// The equilibrium of a scene from its start position, or, when numbers of it are `unknown`, the values that hold that
/// position; with the scene and the model that it belongs to. `go_on` is asked once for every step of the search: `false` ends
/// it, and the answer says so.
///
/// # Errors
/// If the system cannot be evaluated at the start: a singular hinge, a number that is not finite.
pub fn answer(
    description: Description,
    model: Arc<Model>,
    unknown: &[Parameter],
    settings: &Settings,
    go_on: &dyn Fn() -> bool,
) -> Result<Held, Fault> {
    if !unknown.is_empty() {
        return hold(&description, unknown, &model.start_position, settings);
    }
    let found: Equilibrium = equilibrium_while(&model, settings, &model.start_position, go_on)?;
    Ok(Held { description, model, found })
}
