//! Runs: of a scene as it is, or through the stages that change it.

use crate::model::Model;
use crate::record::{Recorder, Scene};
use crate::simulate::asked::Asked;
use crate::simulate::control::Function;
use crate::simulate::error::RunError;
use crate::simulate::events::search::Search;
use crate::simulate::run::{Summary, run_one};
use crate::simulate::samples::scene::of_structure;
use crate::simulate::settings::Settings;
use crate::simulate::staged;
use crate::simulate::state::State;
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
    run_with(model, start, Asked { settings, rate, recorder, go_on, search: Search::RUN, function: None })
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
    run_with(model, start, Asked { settings, rate, recorder, go_on, search: Search::RUN, function: Some(function) })
}

/// As [`run`], with all that a run can be asked for.
///
/// # Errors
/// As [`run`].
pub(super) fn run_with(model: &Arc<Model>, start: &State, asked: Asked<'_, '_>) -> Result<Summary, RunError> {
    match &model.stages {
        None => run_one(model, start, asked, None),
        Some(whole) => {
            staged::refuse(whole, asked.settings, asked.function.is_some())?;
            staged::run(whole, model, start, asked)
        }
    }
}
