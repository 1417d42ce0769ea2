//! What a run of a scene is, from the keywords of Python's functions: made without Python, for threads that do not hold it.

use crate::equilibrium::Searched;
use crate::run::Asked;
use crate::scene::{Scene, positive};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::sync::Arc;
use stillpoint::integrate::Method;
use stillpoint::simulate::{Integrator, Start, State, TOLERANCES};
use stillpoint::suggest::closest;

/// What stands in the place of the file's numbers.
#[derive(Clone, Copy)]
pub(crate) struct Keywords {
    duration: Option<f64>,
    rate: Option<f64>,
    integrator: Option<Integrator>,
    tolerance: Option<f64>,
    step: Option<f64>,
}

/// Why there is no run.
pub(crate) enum Refused {
    /// The scene is none.
    Scene(PyErr),
    /// Statics cannot begin.
    Statics(String),
    /// Statics found no equilibrium.
    NoEquilibrium(Box<Scene>, Arc<Searched>),
}

impl Keywords {
    /// Durations and steps in s, samples per second, a relative and absolute tolerance.
    ///
    /// # Errors
    /// `ValueError` of what a scenario file may not have, either.
    pub(crate) fn new(
        duration: Option<f64>,
        rate: Option<f64>,
        integrator: Option<&str>,
        tolerance: Option<f64>,
        step: Option<f64>,
    ) -> PyResult<Self> {
        let named = |name: &str| {
            Integrator::named(name).ok_or_else(|| {
                let known = Method::ALL.map(Method::name).into_iter().chain(["auto"]);
                let near = closest(name, known).map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
                PyValueError::new_err(format!("no integrator is called `{name}`{near}"))
            })
        };
        Ok(Self {
            duration: positive("duration", duration)?,
            rate: positive("rate", rate)?,
            integrator: integrator.map(named).transpose()?,
            tolerance: tolerance.map(allowed).transpose()?,
            step: positive("step", step)?,
        })
    }

    /// The run of a scene from a state, from an equilibrium, or from where the file says.
    pub(crate) fn asked(&self, scene: &Scene, start: Option<State>, found: Option<Arc<Searched>>) -> Asked {
        let (scenario, model) = (scene.scenario(), scene.model());
        let mut settings = scenario.simulate.clone();
        settings.duration = self.duration.unwrap_or(settings.duration);
        settings.step = self.step.or(settings.step);
        settings.integrator = self.integrator.unwrap_or(settings.integrator);
        if let Some(tolerance) = self.tolerance {
            (settings.tolerance, settings.absolute_tolerance) = (tolerance, tolerance);
        }
        let given = || State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
        let (model, start) = match (&found, start) {
            (Some(found), _) => (Arc::clone(found.model()), found.state()),
            (None, start) => (Arc::clone(model), start.unwrap_or_else(given)),
        };
        let (name, text, rate) =
            (scenario.name.clone(), scenario.text.clone(), self.rate.unwrap_or(scenario.record.rate));
        Asked { model, settings, rate, start, held: found, name, text }
    }

    /// The run of a scene with more set, from where it says; `None` if `go_on` ended it.
    pub(crate) fn prepared(
        &self,
        scene: &Scene,
        set: &[String],
        go_on: &dyn Fn() -> bool,
    ) -> Option<Result<Asked, Refused>> {
        let scene = match go_on().then(|| scene.with(set))? {
            Ok(scene) => scene,
            Err(error) => return Some(Err(Refused::Scene(error))),
        };
        let found = match scene.scenario().simulate.start == Start::Equilibrium {
            true => Some(Searched::new(scene.scenario(), scene.model(), go_on)),
            false => None,
        };
        if !go_on() {
            return None;
        }
        Some(match found.transpose() {
            Err(error) => Err(Refused::Statics(error)),
            Ok(Some(found)) if !found.converged() => Err(Refused::NoEquilibrium(Box::new(scene), Arc::new(found))),
            Ok(found) => Ok(self.asked(&scene, None, found.map(Arc::new))),
        })
    }
}

/// A tolerance that a scenario file may have.
fn allowed(tolerance: f64) -> PyResult<f64> {
    let [least, most] = TOLERANCES;
    if (least..=most).contains(&tolerance) {
        return Ok(tolerance);
    }
    Err(PyValueError::new_err(format!("`tolerance` is {tolerance:e}, allowed: {least:e} to {most}")))
}
