//! The scene of an FMU, read and put at its start.

use super::FmuError;
use crate::constraint::assemble;
use crate::model::{Model, Problem};
use crate::scenario::{self, Override, Scenario};
use crate::simulate::{Start, State};
use crate::statics;
use std::sync::Arc;

/// A scenario with its model, loops closed.
#[derive(Debug, Clone)]
pub struct Scene {
    /// As it was read.
    pub scenario: Scenario,
    /// Its model.
    pub model: Arc<Model>,
}

impl Scene {
    /// Reads a scenario. `name` is what it is called in messages, and from whose folder its files are found; `set` is `path=value`.
    ///
    /// # Errors
    /// What is wrong with the scenario, with all problems at once.
    pub fn read(name: &str, text: &str, set: &[String]) -> Result<Self, FmuError> {
        let wrong = |error: &dyn std::fmt::Display| FmuError::Scene(error.to_string());
        let overrides: Result<Vec<Override>, _> = set.iter().map(|change| Override::parse(change)).collect();
        let overrides = overrides.map_err(|error| wrong(&error))?;
        let scenario = scenario::parse(name, text, &overrides)
            .map_err(|problems| FmuError::Scene(problems.render(false).trim_end().to_owned()))?;
        let listed = |problems: Vec<Problem>| {
            FmuError::Scene(problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
        };
        let model = Model::build(&scenario.description).map_err(listed)?;
        let (model, _) = assemble(model).map_err(listed)?;
        Ok(Self { scenario, model })
    }
}

/// The model and the state that a run of a scene starts with: its equilibrium, or the state as given.
///
/// # Errors
/// If there is no equilibrium: the residual, and what statics says of it.
pub fn at_start(scene: &Scene) -> Result<(Arc<Model>, State), FmuError> {
    let Scene { scenario, model } = scene;
    if model.stages.is_some() {
        return Err(FmuError::Scene(format!(
            "{}: an FMU has one structure: a scene with stages cannot be one",
            scenario.name
        )));
    }
    if scenario.simulate.start == Start::Given {
        let (position, velocity) = (model.start_position.clone(), model.start_velocity.clone());
        return Ok((Arc::clone(model), State { position, velocity }));
    }
    let description = scenario.description.clone();
    let answer = statics::answer(
        description,
        Arc::clone(model),
        scenario.sought(),
        &scenario.statics,
        &scenario.margin,
        &|| true,
    );
    let held = answer.map_err(|error| FmuError::NoEquilibrium(format!("{}: {error}", scenario.name)))?;
    let found = held.found;
    if !found.converged {
        let notes: String = found.notes.iter().map(|note| format!("\n{note}")).collect();
        return Err(FmuError::NoEquilibrium(format!(
            "{}: no equilibrium was found: the residual is {:.3e} of the forces{notes}",
            scenario.name, found.relative_residual
        )));
    }
    Ok((held.model, State { position: found.position, velocity: found.velocity }))
}
