//! Scenes: from files and texts.

use crate::dynamics::Dynamics;
use crate::equilibrium::Equilibrium;
use crate::interrupt::Interrupt;
use crate::run::{Run, run};
use crate::{NoEquilibrium, SceneError};
use numpy::PyArray1;
use pyo3::exceptions::{PyOSError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
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
    /// What it was made of, to be made again with other numbers whatever becomes of the file: its name, from whose folder models and
    /// meshes are found, and what was set. The text is the scenario's.
    name: String,
    set: Vec<String>,
}

/// What pickle keeps: what makes the scene again, and of what.
type Pickled<'py> = (Bound<'py, PyAny>, (String, String, Vec<String>));

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
    fn new(scenario: Scenario, name: String, set: Vec<String>) -> PyResult<Self> {
        let model = Model::build(&scenario.description).map_err(listed)?;
        let (model, _) = assemble(model).map_err(listed)?;
        Ok(Self { scenario, model, name, set })
    }

    fn of_file(path: &Path, set: Vec<String>) -> PyResult<Self> {
        let scenario = scenario::load_with(path, &overrides(&set)?).map_err(|error| match error {
            LoadError::Problems(problems) => SceneError::new_err(problems.render(false)),
            other => PyOSError::new_err(other.to_string()),
        })?;
        Self::new(scenario, absolute(path), set)
    }

    fn of_text(name: &str, text: &str, set: Vec<String>) -> PyResult<Self> {
        let scenario = scenario::parse(name, text, &overrides(&set)?)
            .map_err(|problems| SceneError::new_err(problems.render(false)))?;
        Self::new(scenario, absolute(Path::new(name)), set)
    }
}

/// A name that means the same from every folder.
fn absolute(path: &Path) -> String {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).display().to_string()
}

fn overrides(set: &[String]) -> PyResult<Vec<Override>> {
    let wrong = |error: &dyn std::fmt::Display| SceneError::new_err(error.to_string());
    set.iter().map(|text| Override::parse(text).map_err(|error| wrong(&error))).collect()
}

/// Reads a scenario file, or that of a model (URDF, MJCF) alone; `set` changes numbers by their addresses.
#[pyfunction]
#[pyo3(signature = (path, set = None))]
pub(crate) fn load(path: PathBuf, set: Option<&Bound<'_, PyDict>>) -> PyResult<Scene> {
    Scene::of_file(&path, settings(set)?)
}

/// Reads the text of a scenario.
#[pyfunction]
#[pyo3(signature = (text, set = None, name = "scene.toml"))]
pub(crate) fn parse(text: &str, set: Option<&Bound<'_, PyDict>>, name: &str) -> PyResult<Scene> {
    Scene::of_text(name, text, settings(set)?)
}

/// An array that nobody writes to.
pub(crate) fn frozen<'py>(py: Python<'py>, numbers: &[f64]) -> PyResult<Bound<'py, PyArray1<f64>>> {
    let array = PyArray1::from_slice(py, numbers);
    array.call_method1("setflags", (false,))?;
    Ok(array)
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

    /// Names of the velocity coordinates, in the order of `v`.
    #[getter]
    fn velocities(&self) -> Vec<String> {
        let scene = stillpoint::simulate::scene(&self.model);
        scene.velocities.iter().map(|channel| format!("{}.{}", channel.body, channel.name)).collect()
    }

    /// The hinge coordinates of the file, closed loops included.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        frozen(py, &self.model.start_position)
    }

    /// The hinge velocities of the file.
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        frozen(py, &self.model.start_velocity)
    }

    /// What the reader would warn of.
    #[getter]
    fn warnings(&self) -> String {
        self.scenario.warnings.render(false)
    }

    /// The same scene with other numbers, by their addresses: `scene.with_set({"spring.stiffness": 900})`.
    fn with_set(&self, set: &Bound<'_, PyDict>) -> PyResult<Self> {
        let more = settings(Some(set))?;
        Self::of_text(&self.name, &self.scenario.text, self.set.iter().cloned().chain(more).collect())
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
                .ok_or_else(|| PyValueError::new_err(format!("no integrator is called `{name}`")))?;
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
            return Err(PyValueError::new_err(format!(
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

    fn __reduce__<'py>(slf: &Bound<'py, Self>) -> PyResult<Pickled<'py>> {
        let this = slf.get();
        let again = slf.py().get_type::<Self>().getattr("_again")?;
        Ok((again, (this.name.clone(), this.scenario.text.clone(), this.set.clone())))
    }

    #[staticmethod]
    fn _again(name: &str, text: &str, set: Vec<String>) -> PyResult<Self> {
        Self::of_text(name, text, set)
    }

    fn __copy__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __deepcopy__(slf: Py<Self>, _memo: &Bound<'_, PyAny>) -> Py<Self> {
        slf
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
            Err(PyValueError::new_err(message))
        }
        other => Ok(other),
    }
}
