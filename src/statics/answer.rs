//! What every command asks of a scene: its equilibrium, or the inputs that hold its pose.

use super::aim::aim;
use super::inverse::{InverseAnswer, hold};
use super::search::{Observers, equilibrium_observed};
use super::settings::{Margin, Settings, Sought};
use super::standing::{self, Unanswered};
use crate::model::Model;
use crate::model::description::Description;
use std::sync::Arc;

/// The equilibrium of a scene from its start position; when numbers of it are `sought`, the values that hold that position, or those
/// whose equilibrium has the outputs that are aimed at; with the scene and the model that it belongs to. With dry friction or contact it is the pose as given if that
/// stands, and `margin` says what may move while it does. `go_on` is asked once for every step of the search: `false` ends
/// it, and the answer says so.
///
/// # Errors
/// If the system cannot be evaluated at the start: a singular hinge, a number that is not finite; and if shapes overlap, or
/// whether they stand cannot be decided.
pub fn answer(
    description: Description,
    model: Arc<Model>,
    sought: Sought<'_>,
    settings: &Settings,
    margin: &Margin,
    go_on: &dyn Fn() -> bool,
) -> Result<InverseAnswer, Unanswered> {
    if !sought.aim.is_empty() {
        return Ok(aim(description, model, sought, settings, go_on)?);
    }
    if !sought.unknown.is_empty() {
        let held = hold(&description, sought.unknown, &model.start_position, settings)?;
        return standing::inputs(&description, held, &model, sought.unknown, settings, margin);
    }
    let search = || {
        let observers = Observers { go_on: Some(go_on), ..Observers::default() };
        equilibrium_observed(&model, settings, &model.start_position, observers)
    };
    let found = match standing::is_for(&model) {
        true => standing::equilibrium(&description, &model, settings, margin, &search, go_on)?,
        false => search()?,
    };
    Ok(InverseAnswer { description, model, found })
}
