//! What every command asks of a scene: its equilibrium, or the inputs that hold its pose.

use super::inverse::{Held, hold};
use super::search::{Observers, equilibrium_observed};
use super::settings::{Margin, Settings};
use super::standing::{self, Unanswered};
use crate::model::description::Description;
use crate::model::{Model, Parameter};
use std::sync::Arc;

/// The equilibrium of a scene from its start position, or, when numbers of it are `unknown`, the values that hold that
/// position; with the scene and the model that it belongs to. With dry friction or contact it is the pose as given if that
/// stands, and `margin` says what may move while it does. `go_on` is asked once for every step of the search: `false` ends
/// it, and the answer says so.
///
/// # Errors
/// If the system cannot be evaluated at the start: a singular hinge, a number that is not finite; and if shapes overlap, or
/// whether they stand cannot be decided.
pub fn answer(
    description: Description,
    model: Arc<Model>,
    unknown: &[Parameter],
    settings: &Settings,
    margin: &Margin,
    go_on: &dyn Fn() -> bool,
) -> Result<Held, Unanswered> {
    if !unknown.is_empty() {
        let held = hold(&description, unknown, &model.start_position, settings)?;
        return standing::inputs(&description, held, &model, unknown, settings, margin);
    }
    let search = || {
        let observers = Observers { go_on: Some(go_on), ..Observers::default() };
        equilibrium_observed(&model, settings, &model.start_position, observers)
    };
    let found = match standing::is_for(&model) {
        true => standing::equilibrium(&description, &model, settings, margin, &search, go_on)?,
        false => search()?,
    };
    Ok(Held { description, model, found })
}
