//! Runs: of a scene as it is, or through the stages that change it.

use super::control::Function;
use super::error::RunError;
use super::run::{Summary, run_one};
use super::scene::of_structure;
use super::search::Search;
use super::settings::Settings;
use super::staged;
use super::state::State;
use crate::model::Model;
use crate::record::{Recorder, Scene};
use std::sync::Arc;

/// What a picture of this model needs to know.
pub fn scene(model: &Arc<Model>) -> Scene {
    match &model.stages {
        None => of_structure(model),
        Some(whole) => staged::scene(whole, model),
    }
}

/// Steps from `start` to the end of the run, hands samples to `recorder` at `rate` per second, and asks `go_on` with the time
/// reached after every step and now and then between samples.
///
/// # Errors
/// Where a step cannot be made or a sample cannot be kept; what was recorded until then stays.
pub fn run(
    model: &Arc<Model>,
    settings: &Settings,
    rate: f64,
    start: &State,
    recorder: &mut dyn Recorder,
    go_on: &mut dyn FnMut(f64, &State) -> bool,
) -> Result<Summary, RunError> {
    run_with(model, settings, rate, start, recorder, go_on, Search::RUN, None)
}

/// As [`run`], with a function that sets the inputs at instants of its own.
///
/// # Errors
/// As [`run`], and what the function says.
pub fn run_controlled(
    model: &Arc<Model>,
    settings: &Settings,
    rate: f64,
    start: &State,
    recorder: &mut dyn Recorder,
    go_on: &mut dyn FnMut(f64, &State) -> bool,
    function: Function<'_>,
) -> Result<Summary, RunError> {
    run_with(model, settings, rate, start, recorder, go_on, Search::RUN, Some(function))
}

/// As [`run`], with events looked for in another way, and a function as a controller.
///
/// # Errors
/// As [`run`].
#[expect(clippy::too_many_arguments, reason = "those of the two functions above")]
pub(super) fn run_with(
    model: &Arc<Model>,
    settings: &Settings,
    rate: f64,
    start: &State,
    recorder: &mut dyn Recorder,
    go_on: &mut dyn FnMut(f64, &State) -> bool,
    search: Search,
    function: Option<Function<'_>>,
) -> Result<Summary, RunError> {
    match &model.stages {
        None => run_one(model, settings, rate, start, recorder, go_on, search, function, None),
        Some(whole) => {
            staged::refuse(whole, settings, function.is_some())?;
            staged::run(whole, model, settings, rate, start, recorder, go_on, search)
        }
    }
}
