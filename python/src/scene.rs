//! Scenes: from files and texts.

use crate::dynamics::Dynamics;
use crate::equilibrium::Equilibrium;
use crate::interrupt::Interrupt;
use crate::run::{Run, run};
use crate::{NoEquilibrium, SceneError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Instant;
use stillpoint::constraint::assemble;
use stillpoint::model::{Model, Problem};
use stillpoint::scenario::{self, LoadError, Override, Scenario};
use stillpoint::simulate::{Integrator, Start, State};
use stillpoint::statics;

/// A scene, as `load` and `parse` give it. It never changes: with other numbers it is another one.
#[pyclass(frozen, module = "stillpoint")]
pub(crate) struct Scene {
    scenario: Scenario,
    model: Arc<Model>,
    /// What it was made of, to be made again: a file or a text with its name, and what was set.
    source: (Option<PathBuf>, String, String),
    set: Vec<String>,
}

fn listed(problems: Vec<Problem>) -> PyErr {
    SceneError::new_err(problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
}

/// What is to be set: `{"link.stiffness": 5.0}`.
fn settings(set: Option<&Bound<'_, PyDict>>) -> PyResult<Vec<String>> {
    let Some(set) = set else { return Ok(Vec::new()) };
    set.iter().map(|(address, value)| Ok(format!("{}={}", address.str()?, toml(&value)?))).collect()
}

/// A value as TOML has it.
fn toml(value: &Bound<'_, PyAny>) -> PyResult<String> {
    value.py().import("stillpoint._toml")?.call_method1("inline", (value,))?.extract()
}

impl Scene {
    fn new(scenario: Scenario, source: (Option<PathBuf>, String, String), set: Vec<String>) -> PyResult<Self> {
        let model = Model::build(&scenario.description).map_err(listed)?;
        let (model, _) = assemble(model).map_err(listed)?;
        Ok(Self { scenario, model, source, set })
    }

    fn of_file(path: PathBuf, set: Vec<String>) -> PyResult<Self> {
        let scenario = scenario::load_with(&path, &overrides(&set)?).map_err(|error| match error {
            LoadError::Problems(problems) => SceneError::new_err(problems.render(false)),
            other => pyo3::exceptions::PyOSError::new_err(other.to_string()),
        })?;
        Self::new(scenario, (Some(path), String::new(), String::new()), set)
    }

    fn of_text(name: String, text: String, set: Vec<String>) -> PyResult<Self> {
        let scenario = scenario::parse(&name, &text, &overrides(&set)?)
            .map_err(|problems| SceneError::new_err(problems.render(false)))?;
        Self::new(scenario, (None, name, text), set)
    }

    fn again(&self, set: Vec<String>) -> PyResult<Self> {
        match &self.source {
            (Some(path), ..) => Self::of_file(path.clone(), set),
            (None, name, text) => Self::of_text(name.clone(), text.clone(), set),
        }
    }
}

fn overrides(set: &[String]) -> PyResult<Vec<Override>> {
    let wrong = |error: &dyn std::fmt::Display| SceneError::new_err(error.to_string());
    set.iter().map(|text| Override::parse(text).map_err(|error| wrong(&error))).collect()
}

/// Reads a scenario file, or that of a model (URDF, MJCF) alone; `set` changes numbers by their addresses.
#[pyfunction]
#[pyo3(signature = (path, set = None))]
pub(crate) fn load(path: PathBuf, set: Option<&Bound<'_, PyDict>>) -> PyResult<Scene> {
    Scene::of_file(path, settings(set)?)
}

/// Reads the text of a scenario.
#[pyfunction]
#[pyo3(signature = (text, set = None, name = "scene.toml"))]
pub(crate) fn parse(text: String, set: Option<&Bound<'_, PyDict>>, name: &str) -> PyResult<Scene> {
    Scene::of_text(name.to_owned(), text, settings(set)?)
}

/// The coordinates of each hinge that has any, by the body that it carries.
pub(crate) fn by_hinge<'py>(
    py: Python<'py>,
    model: &Model,
    q: &[f64],
    positions: bool,
) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for body in &model.bodies {
        let (of_position, of_velocity) = body.hinge.kind.counts();
        let (at, count) = match positions {
            true => (body.hinge.position, of_position),
            false => (body.hinge.velocity, of_velocity),
        };
        if count > 0 {
            all.set_item(&body.name, &q[at..at + count])?;
        }
    }
    Ok(all)
}

#[pymethods]
impl Scene {
    /// The title.
    #[getter]
    fn title(&self) -> &str {
        &self.model.title
    }

    /// The names of the bodies.
    #[getter]
    fn bodies(&self) -> Vec<&str> {
        self.model.bodies.iter().map(|body| body.name.as_str()).collect()
    }

    /// Number of velocity coordinates.
    #[getter]
    fn degrees_of_freedom(&self) -> usize {
        self.model.velocity_count()
    }

    /// Names of the position coordinates, in the order of `q`.
    #[getter]
    fn coordinates(&self) -> Vec<String> {
        let scene = stillpoint::simulate::scene(&self.model);
        scene.positions.iter().map(|channel| format!("{}.{}", channel.body, channel.name)).collect()
    }

    /// The hinge coordinates of the file, closed loops included.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Bound<'py, numpy::PyArray1<f64>> {
        numpy::PyArray1::from_slice(py, &self.model.start_position)
    }

    /// The hinge velocities of the file.
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> Bound<'py, numpy::PyArray1<f64>> {
        numpy::PyArray1::from_slice(py, &self.model.start_velocity)
    }

    /// What the reader would warn of.
    #[getter]
    fn warnings(&self) -> String {
        self.scenario.warnings.render(false)
    }

    /// The same scene with other numbers, by their addresses: `scene.with_set({"spring.stiffness": 900})`.
    fn with_set(&self, set: &Bound<'_, PyDict>) -> PyResult<Self> {
        let more = settings(Some(set))?;
        self.again(self.set.iter().cloned().chain(more).collect())
    }

    /// The equilibrium that statics finds.
    fn equilibrium(slf: &Bound<'_, Self>) -> PyResult<Equilibrium> {
        let (py, this) = (slf.py(), slf.get());
        let interrupt = Interrupt::new();
        let before = Instant::now();
        let Scenario { description, unknown, statics, margin, .. } = &this.scenario;
        let (description, model) = (description.clone(), Arc::clone(&this.model));
        let asked = &interrupt;
        let answer =
            py.detach(move || statics::answer(description, model, unknown, statics, margin, &|| asked.go_on()));
        interrupt.check()?;
        let held = answer.map_err(|error| NoEquilibrium::new_err(error.to_string()))?;
        let equilibrium = Equilibrium::new(slf.clone().unbind(), held, before.elapsed());
        if equilibrium.converged() {
            return Ok(equilibrium);
        }
        let error = NoEquilibrium::new_err(equilibrium.why());
        error.value(py).setattr("answer", Py::new(py, equilibrium)?)?;
        Err(error)
    }

    /// A run. It starts where the file says; a number of samples per second, and what the file has in `[simulate]`, may be given.
    #[pyo3(signature = (duration = None, *, rate = None, integrator = None, tolerance = None, step = None, start = None))]
    fn run(
        slf: &Bound<'_, Self>,
        duration: Option<f64>,
        rate: Option<f64>,
        integrator: Option<&str>,
        tolerance: Option<f64>,
        step: Option<f64>,
        start: Option<(Vec<f64>, Vec<f64>)>,
    ) -> PyResult<Run> {
        let this = slf.get();
        let mut settings = this.scenario.simulate;
        settings.duration = positive("duration", duration)?.unwrap_or(settings.duration);
        if let Some(tolerance) = positive("tolerance", tolerance)? {
            (settings.tolerance, settings.absolute_tolerance) = (tolerance, tolerance);
        }
        settings.step = positive("step", step)?.or(settings.step);
        if let Some(name) = integrator {
            settings.integrator = Integrator::named(name)
                .ok_or_else(|| pyo3::exceptions::PyValueError::new_err(format!("no integrator is called `{name}`")))?;
        }
        let rate = positive("rate", rate)?.unwrap_or(this.scenario.record.rate);
        let (model, start) = match start {
            Some((position, velocity)) => (Arc::clone(&this.model), State { position, velocity }),
            None if settings.start == Start::Equilibrium => {
                let found = Self::equilibrium(slf)?;
                settings.start = Start::Equilibrium;
                (Arc::clone(found.model()), found.state())
            }
            None => {
                let (position, velocity) = (this.model.start_position.clone(), this.model.start_velocity.clone());
                (Arc::clone(&this.model), State { position, velocity })
            }
        };
        let wrong = start.position.len() != model.position_count() || start.velocity.len() != model.velocity_count();
        if wrong {
            let (q, v) = (model.position_count(), model.velocity_count());
            return Err(pyo3::exceptions::PyValueError::new_err(format!(
                "`start` has {} positions and {} velocities, the scene {q} and {v}",
                start.position.len(),
                start.velocity.len()
            )));
        }
        run(slf.py(), &model, &settings, rate, start)
    }

    /// The equations of motion of the smooth scene: stops are open, dry friction is left out.
    fn dynamics(&self) -> Dynamics {
        Dynamics::new(&self.model)
    }

    fn __repr__(&self) -> String {
        let (bodies, freedoms) = (self.model.bodies.len(), self.model.velocity_count());
        let [bodies, freedoms] = [(bodies, "body", "bodies"), (freedoms, "degree of freedom", "degrees of freedom")]
            .map(|(count, one, many)| format!("{count} {}", if count == 1 { one } else { many }));
        format!("<Scene `{}`: {bodies}, {freedoms}>", self.model.title)
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Self>,
    ) -> PyResult<(Bound<'py, PyAny>, (Option<PathBuf>, String, String, Vec<String>))> {
        let this = slf.get();
        let (path, name, text) = this.source.clone();
        let again = slf.py().get_type::<Self>().getattr("_again")?;
        Ok((again, (path, name, text, this.set.clone())))
    }

    #[staticmethod]
    fn _again(path: Option<PathBuf>, name: String, text: String, set: Vec<String>) -> PyResult<Self> {
        match path {
            Some(path) => Self::of_file(path, set),
            None => Self::of_text(name, text, set),
        }
    }
}

impl Scene {
    pub(crate) fn scenario(&self) -> &Scenario {
        &self.scenario
    }
}

/// A number that has to be finite and above zero.
fn positive(name: &str, number: Option<f64>) -> PyResult<Option<f64>> {
    match number {
        Some(number) if !(number > 0.0 && number.is_finite()) => {
            let message = format!("`{name}` is {number}, allowed: above 0");
            Err(pyo3::exceptions::PyValueError::new_err(message))
        }
        other => Ok(other),
    }
}
