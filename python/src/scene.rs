//! Scenes: from files and texts.

use crate::batch;
use crate::control::Controller;
use crate::dynamics::{self, Dynamics};
use crate::equilibrium::{Equilibrium, Searched};
use crate::fit;
use crate::interrupt::Interrupt;
use crate::linear::Linear;
use crate::path;
use crate::run::{Asked, Run, run};
use crate::simulator::Simulator;
use crate::start::Keywords;
use crate::{NoEquilibrium, SceneError};
use numpy::PyArray1;
use pyo3::exceptions::{
    PyFileNotFoundError, PyIsADirectoryError, PyOSError, PyPermissionError, PyTypeError, PyValueError,
};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyMapping};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use stillpoint::constraint::assemble;
use stillpoint::import::{Taken, counted};
use stillpoint::model::{Model, Problem};
use stillpoint::motion::relative;
use stillpoint::scenario::{self, LoadError, Override, Scenario};
use stillpoint::simulate::{Start, State};
use stillpoint::text_file::ReadError;

/// A scene, as `load` and `parse` give it. It never changes: with other numbers it is another one.
#[pyclass(frozen, module = "stillpoint")]
pub(crate) struct Scene {
    scenario: Scenario,
    model: Arc<Model>,
    /// What it was made of, to be made again with other numbers whatever becomes of the file: its name, from whose folder models and
    /// meshes are found, and what was set. The text is the scenario's.
    name: String,
    set: Vec<String>,
    /// What a person should know of how its loops were closed.
    notes: Vec<String>,
}

/// What pickle keeps: what makes the scene again, and of what.
type Pickled<'py> = (Bound<'py, PyAny>, (String, String, Vec<String>));

/// Coordinates and velocities.
type Positions<'py> = (Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

fn listed(problems: Vec<Problem>) -> PyErr {
    SceneError::new_err(problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
}

/// What is to be set: `{"link.stiffness": 5.0}`.
fn settings(set: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<String>> {
    let Some(set) = set else { return Ok(Vec::new()) };
    // A text that is shown as it is formatted would swallow Ctrl-C.
    let one = |(address, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
        Ok(format!("{}={}", address.str()?.to_cow()?, toml(&value)?))
    };
    mapping("set", set)?.iter().map(one).collect()
}

/// A dictionary of any mapping.
pub(crate) fn mapping<'py>(name: &str, given: &Bound<'py, PyAny>) -> PyResult<Bound<'py, PyDict>> {
    if let Ok(dictionary) = given.cast::<PyDict>() {
        return Ok(dictionary.clone());
    }
    let wrong = || PyTypeError::new_err(format!("`{name}` is {}, expected: a mapping", dynamics::shown(given)));
    given.cast::<PyMapping>().map_err(|_| wrong())?;
    Ok(given.py().get_type::<PyDict>().call1((given,))?.cast_into()?)
}

/// One name, or several.
#[derive(FromPyObject)]
pub(crate) enum Names {
    One(String),
    Several(Vec<String>),
}

impl Names {
    pub(crate) fn all(self) -> Vec<String> {
        match self {
            Self::One(name) => vec![name],
            Self::Several(names) => names,
        }
    }
}

/// A value as TOML has it.
fn toml(value: &Bound<'_, PyAny>) -> PyResult<String> {
    value.py().import("stillpoint._toml")?.call_method1("inline", (value,))?.extract()
}

impl Scene {
    fn new(scenario: Scenario, name: String, set: Vec<String>) -> PyResult<Self> {
        let model = Model::build(&scenario.description).map_err(listed)?;
        let (model, assembly) = assemble(model).map_err(listed)?;
        Ok(Self { scenario, model, name, set, notes: assembly.notes })
    }

    fn of_file(path: &Path, set: Vec<String>) -> PyResult<Self> {
        let scenario = scenario::load_with(path, &overrides(&set)?).map_err(|error| match error {
            LoadError::Problems(problems) => SceneError::new_err(problems.render(false)),
            LoadError::File(error) => unreadable(&error),
        })?;
        Self::new(scenario, absolute(path), set)
    }

    fn of_text(name: &str, text: &str, set: Vec<String>) -> PyResult<Self> {
        let scenario = scenario::parse(name, text, &overrides(&set)?)
            .map_err(|problems| SceneError::new_err(problems.render(false)))?;
        Self::new(scenario, absolute(Path::new(name)), set)
    }
}

/// The exception for a file that cannot be read, as Python's own functions raise it.
fn unreadable(error: &ReadError) -> PyErr {
    let text = error.to_string();
    match error {
        ReadError::Missing { .. } => PyFileNotFoundError::new_err(text),
        ReadError::Folder { .. } => PyIsADirectoryError::new_err(text),
        ReadError::Unreadable { source, .. } => by_kind(source, text),
        _ => PyOSError::new_err(text),
    }
}

/// The exception of the operating system's kind, with words of our own.
pub(crate) fn by_kind(error: &std::io::Error, text: String) -> PyErr {
    match error.kind() {
        std::io::ErrorKind::NotFound => PyFileNotFoundError::new_err(text),
        std::io::ErrorKind::PermissionDenied => PyPermissionError::new_err(text),
        std::io::ErrorKind::IsADirectory => PyIsADirectoryError::new_err(text),
        _ => PyOSError::new_err(text),
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
pub(crate) fn load(path: PathBuf, set: Option<&Bound<'_, PyAny>>) -> PyResult<Scene> {
    Scene::of_file(&path, settings(set)?)
}

/// Reads the text of a scenario.
#[pyfunction]
#[pyo3(signature = (text, set = None, name = "scene.toml"))]
pub(crate) fn parse(text: &str, set: Option<&Bound<'_, PyAny>>, name: &str) -> PyResult<Scene> {
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

    /// Degrees of freedom that loops, gears and drives leave. There are `len(scene.velocities)` hinge velocities.
    #[getter]
    fn degrees_of_freedom(&self) -> usize {
        self.model.degrees_of_freedom()
    }

    /// Names of the position coordinates, in the order of `q`.
    #[getter]
    fn coordinates(&self) -> Vec<String> {
        dynamics::coordinates(&self.model)
    }

    /// Names of the velocity coordinates, in the order of `v`.
    #[getter]
    fn velocities(&self) -> Vec<String> {
        dynamics::velocities(&self.model)
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

    /// What the reader would warn of, what its models have that was not taken as it stands, and how its loops were closed.
    #[getter]
    fn warnings(&self) -> String {
        let taken = self.scenario.models.iter().filter(|model| !model.notes.is_empty());
        let lines = taken.map(|model| {
            let path = model.sources.first().map(|source| source.path.display().to_string()).unwrap_or_default();
            let lost = model.notes.iter().filter(|note| note.verdict != Taken::Used);
            let lost = lost.map(|note| {
                format!("  line {}: {}: {}: {}\n", note.line, note.element, note.verdict.word(), note.what)
            });
            format!("{path}: {}\n{}", counted(&model.notes), lost.collect::<String>())
        });
        let notes = self.notes.iter().map(|note| format!("{note}\n"));
        self.scenario.warnings.render(false) + &lines.chain(notes).collect::<String>()
    }

    /// The same scene with other numbers, by their addresses: `scene.with_set({"spring.stiffness": 900})`.
    fn with_set(&self, set: &Bound<'_, PyAny>) -> PyResult<Self> {
        self.with(&settings(Some(set))?)
    }

    /// The state nearest to a given one that loops, drives and gears agree with: `(q, v)`. Without velocities they are zero.
    #[pyo3(signature = (q, v = None))]
    fn close<'py>(&self, py: Python<'py>, q: Vec<f64>, v: Option<Vec<f64>>) -> PyResult<Positions<'py>> {
        let v = v.unwrap_or_else(|| vec![0.0; self.model.velocity_count()]);
        let found = nearest(&self.model, fitting(&self.model, q, v)?)?;
        Ok((frozen(py, &found.position)?, frozen(py, &found.velocity)?))
    }

    /// The equilibrium that statics finds.
    fn equilibrium(slf: &Bound<'_, Self>) -> PyResult<Equilibrium> {
        let found = Self::search(slf)?;
        match found.converged() {
            true => Ok(found),
            false => Err(found.refused(slf.py())),
        }
    }

    /// What statics finds, an equilibrium or not: what a pickled one is made of again.
    #[pyo3(name = "_search")]
    fn search(slf: &Bound<'_, Self>) -> PyResult<Equilibrium> {
        let (py, this) = (slf.py(), slf.get());
        let interrupt = Interrupt::new();
        let asked = &interrupt;
        let found = py.detach(move || Searched::new(&this.scenario, &this.model, &|| asked.go_on()));
        interrupt.check()?;
        Ok(Equilibrium::new(slf.clone().unbind(), Arc::new(found.map_err(NoEquilibrium::new_err)?)))
    }

    /// The equations about the equilibrium, or about a state `start = (q, v)` as it stands: from inputs by their addresses (all motors of
    /// type `input` unless others are named) to outputs by name (all).
    #[pyo3(signature = (inputs = None, outputs = None, *, start = None))]
    fn linearize(
        slf: &Bound<'_, Self>,
        inputs: Option<Names>,
        outputs: Option<Names>,
        start: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Linear> {
        let Some(start) = start else {
            return Self::equilibrium(slf)?.linearize(inputs, outputs);
        };
        let (inputs, outputs) = (inputs.map(Names::all), outputs.map(Names::all));
        let Self { model, scenario, .. } = slf.get();
        let state = closed(model, state(model, start)?)?;
        let place = (scenario.simulate.begin(), state);
        let linear = stillpoint::cli::linearize_at(&scenario.description, model, place, inputs, outputs);
        linear.map(Linear::new).map_err(|error| PyValueError::new_err(format!("{error:#}")))
    }

    /// A run. It starts where the file says; a number of samples per second, and what the file has in `[simulate]`, may be given.
    /// `controller(time, outputs)` sets the motors of type `input` every `period` seconds: it returns a number, a list of all, or a
    /// dictionary of some.
    #[pyo3(signature = (duration = None, *, rate = None, integrator = None, tolerance = None, step = None, start = None, controller = None, period = None))]
    #[expect(clippy::too_many_arguments, reason = "keywords")]
    fn run(
        slf: &Bound<'_, Self>,
        duration: Option<f64>,
        rate: Option<f64>,
        integrator: Option<&str>,
        tolerance: Option<f64>,
        step: Option<f64>,
        start: Option<&Bound<'_, PyAny>>,
        controller: Option<Py<PyAny>>,
        period: Option<f64>,
    ) -> PyResult<Run> {
        let keywords = Keywords::new(duration, rate, integrator, tolerance, step)?;
        let asked = Self::asked(slf, &keywords, start)?;
        let control = Controller::of(&asked.model, controller, positive("period", period)?)?;
        run(slf.py(), &asked, control)
    }

    /// The scene at its start, to go on as far as it is told to.
    #[pyo3(signature = (*, integrator = None, tolerance = None, step = None, start = None))]
    fn simulator(
        slf: &Bound<'_, Self>,
        integrator: Option<&str>,
        tolerance: Option<f64>,
        step: Option<f64>,
        start: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Simulator> {
        let keywords = Keywords::new(None, None, integrator, tolerance, step)?;
        Ok(Simulator::new(Self::asked(slf, &keywords, start)?))
    }

    /// A run for each of several changes (`[{"arm.mass": 2.0}, …]`), on all processors: what each has alone, to the bit; with `lanes`
    /// those that can be computed side by side are, as a sweep has them, and agree to round-off. In the place of one that fails its
    /// exception.
    #[pyo3(signature = (sets, duration = None, *, rate = None, integrator = None, tolerance = None, step = None, threads = None, lanes = false))]
    #[expect(clippy::too_many_arguments, reason = "keywords")]
    fn batch<'py>(
        slf: &Bound<'py, Self>,
        sets: &Bound<'py, PyAny>,
        duration: Option<f64>,
        rate: Option<f64>,
        integrator: Option<&str>,
        tolerance: Option<f64>,
        step: Option<f64>,
        threads: Option<usize>,
        lanes: bool,
    ) -> PyResult<Vec<Bound<'py, PyAny>>> {
        let keywords = Keywords::new(duration, rate, integrator, tolerance, step)?;
        let threads = batch::processors(threads)?;
        let sets = batch::list("sets", sets, "a list of dictionaries")?;
        let sets = sets.iter().map(|set| batch::unless_ended(slf.py(), settings(Some(set))));
        batch::runs(slf, &sets.collect::<PyResult<Vec<_>>>()?, &keywords, (threads, lanes))
    }

    /// The equilibrium, and with `run` a run, for many values of some numbers, on all processors: columns by name, a row a case.
    /// `over` has values by address, every combination of them; `vary` distributions (`"normal(2, 0.1)"`), drawn `cases` times.
    #[pyo3(signature = (over = None, *, vary = None, cases = None, seed = 0, sample = None, run = false, time_limit = None, threads = None))]
    #[expect(clippy::too_many_arguments, reason = "keywords")]
    fn sweep<'py>(
        slf: &Bound<'py, Self>,
        over: Option<&Bound<'py, PyAny>>,
        vary: Option<&Bound<'py, PyAny>>,
        cases: Option<i128>,
        seed: i128,
        sample: Option<&str>,
        run: bool,
        time_limit: Option<f64>,
        threads: Option<usize>,
    ) -> PyResult<Bound<'py, PyAny>> {
        let over = over.map(|over| mapping("over", over)).transpose()?;
        let vary = vary.map(|vary| mapping("vary", vary)).transpose()?;
        let plan = batch::plan(over.as_ref(), vary.as_ref(), cases, seed, sample)?;
        let limit = positive("time_limit", time_limit)?.unwrap_or(f64::INFINITY);
        let this = slf.get();
        let columns = batch::sweep(slf.py(), &this.scenario, overrides(&this.set)?, plan, (run, limit), threads)?;
        slf.py().import("stillpoint._table")?.call_method1("Table", (columns,))
    }

    /// Numbers of the scene that bring it closest to measurements, with their standard errors. `data` is a table (mapping, data frame
    /// or CSV file): columns named after outputs were measured, columns named by addresses were set. `parameters` is a list of
    /// `"address=start,low..high"`, or a dictionary of addresses with `None`, a start, or `(start, low, high)`. With `run` the
    /// measurements are of a run, at the times of the column `time`.
    #[pyo3(signature = (data, parameters, *, run = false, deviations = None, ignore = None, confidence = 0.95))]
    fn fit<'py>(
        slf: &Bound<'py, Self>,
        data: &Bound<'py, PyAny>,
        parameters: &Bound<'py, PyAny>,
        run: bool,
        deviations: Option<&Bound<'py, PyDict>>,
        ignore: Option<Vec<String>>,
        confidence: f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let this = slf.get();
        let asked = fit::Asked { parameters, run, deviations, ignore, confidence };
        fit::of_scene(slf, (&this.scenario, &overrides(&this.set)?), data, &asked)
    }

    /// The equilibrium followed while a number of the scene moves from one value to another, around folds and into side branches.
    /// What is not given is as in `[statics.path]`.
    #[pyo3(signature = (parameter = None, start = None, end = None, *, at = None, step = None, points = None, branches = None))]
    #[expect(clippy::too_many_arguments, reason = "keywords")]
    fn path<'py>(
        slf: &Bound<'py, Self>,
        parameter: Option<&str>,
        start: Option<f64>,
        end: Option<f64>,
        at: Option<Vec<f64>>,
        step: Option<f64>,
        points: Option<usize>,
        branches: Option<bool>,
    ) -> PyResult<path::Path> {
        let (py, set) = (slf.py(), PyDict::new(slf.py()));
        let given = |key: &str, value: Option<Bound<'py, PyAny>>| match value {
            Some(value) => set.set_item(key, value),
            None => Ok(()),
        };
        given("parameter", parameter.map(|x| x.into_pyobject(py)).transpose()?.map(Bound::into_any))?;
        given("from", start.map(|x| x.into_pyobject(py)).transpose()?.map(Bound::into_any))?;
        given("to", end.map(|x| x.into_pyobject(py)).transpose()?.map(Bound::into_any))?;
        given("at", at.map(|x| x.into_pyobject(py)).transpose()?.map(Bound::into_any))?;
        given("step", step.map(|x| x.into_pyobject(py)).transpose()?.map(Bound::into_any))?;
        given("points", points.map(|x| x.into_pyobject(py)).transpose()?.map(Bound::into_any))?;
        given(
            "branches",
            branches.map(|x| x.into_pyobject(py).map(|x| x.to_owned())).transpose()?.map(Bound::into_any),
        )?;
        if set.is_empty() {
            return path::follow(py, &slf.get().scenario);
        }
        let scene = match slf.get().scenario.path {
            None => {
                let whole = PyDict::new(py);
                whole.set_item("statics.path", set)?;
                slf.get().with_set(whole.as_any())?
            }
            Some(_) => {
                let each = PyDict::new(py);
                for (key, value) in set.iter() {
                    each.set_item(format!("statics.path.{}", key.extract::<String>()?), value)?;
                }
                slf.get().with_set(each.as_any())?
            }
        };
        path::follow(py, &scene.scenario)
    }

    /// The equations of motion of the smooth scene: stops are open, dry friction is left out.
    fn dynamics(slf: &Bound<'_, Self>) -> Dynamics {
        Dynamics::new(slf.clone().unbind(), &slf.get().model)
    }

    fn __repr__(&self) -> String {
        let (bodies, freedoms) = (self.model.bodies.len(), self.model.degrees_of_freedom());
        let [bodies, freedoms] = [(bodies, "body", "bodies"), (freedoms, "degree of freedom", "degrees of freedom")]
            .map(|(count, one, many)| format!("{count} {}", if count == 1 { one } else { many }));
        format!("<Scene `{}`: {bodies}, {freedoms}>", self.model.title)
    }

    /// For notebooks.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("stillpoint._html")?.call_method1("scene", (slf,))
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

    pub(crate) fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// The scene with more set.
    pub(crate) fn with(&self, more: &[String]) -> PyResult<Self> {
        Self::of_text(&self.name, &self.scenario.text, self.set.iter().chain(more).cloned().collect())
    }

    /// What a run of these arguments is.
    fn asked(slf: &Bound<'_, Self>, keywords: &Keywords, start: Option<&Bound<'_, PyAny>>) -> PyResult<Asked> {
        let this = slf.get();
        let start = start.map(|start| closed(&this.model, state(&this.model, start)?)).transpose()?;
        let found = match start {
            None if this.scenario.simulate.start == Start::Equilibrium => {
                Some(Arc::clone(Self::equilibrium(slf)?.held()))
            }
            _ => None,
        };
        Ok(keywords.asked(this, start, found))
    }
}

/// The state of an argument `start`.
fn state(model: &Model, start: &Bound<'_, PyAny>) -> PyResult<State> {
    let refused = || {
        let message = format!("`start` is {}, expected: (q, v), two lists of numbers", dynamics::shown(start));
        PyTypeError::new_err(message)
    };
    let parts = start.try_iter().map_err(|_| refused())?.collect::<PyResult<Vec<_>>>()?;
    if parts.iter().any(|part| part.len().is_err()) {
        return Err(refused());
    }
    let list = |(index, part)| {
        let numbers = dynamics::numbers(&format!("`start[{index}]`"), part, "a list of numbers")?;
        match numbers.iter().position(|number| !number.is_finite()) {
            Some(at) => {
                let message = format!("`start[{index}][{at}]` is {}, allowed: finite numbers", numbers[at]);
                Err(PyValueError::new_err(message))
            }
            None => Ok(numbers),
        }
    };
    let lists = parts.iter().enumerate().map(list).collect::<PyResult<Vec<Vec<f64>>>>()?;
    let [position, velocity] = <[Vec<f64>; 2]>::try_from(lists)
        .map_err(|given| PyValueError::new_err(format!("`start` has {} parts, expected: (q, v)", given.len())))?;
    fitting(model, position, velocity)
}

/// Coordinates and velocities, as many as the scene has.
fn fitting(model: &Model, position: Vec<f64>, velocity: Vec<f64>) -> PyResult<State> {
    let (q, v) = (model.position_count(), model.velocity_count());
    let given = (position.len(), velocity.len());
    if given == (q, v) {
        return Ok(State { position, velocity });
    }
    let message = format!("`start` has {} positions and {} velocities, the scene {q} and {v}", given.0, given.1);
    Err(PyValueError::new_err(message))
}

/// How far the norm of a quaternion may be from one, as in a file, and how far loops, drives and gears may move what is given: rad and parts
/// of the scene's length, velocities in parts of the largest.
const SLACK: f64 = 1e-6;

/// The norm of four numbers that stand for a turn.
fn norm(turn: &[f64]) -> f64 {
    turn.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Where the quaternions of a model are among its positions, with the bodies whose hinges have them.
fn quaternions(model: &Model) -> impl Iterator<Item = (&str, Range<usize>)> {
    model.bodies.iter().filter_map(|body| {
        let (first, kind) = (body.hinge.position, &body.hinge.kind);
        let turn = first + kind.plain_coordinates()..first + kind.counts().0;
        (!turn.is_empty()).then_some((body.name.as_str(), turn))
    })
}

/// Refuses positions whose quaternions are none of unit norm.
pub(crate) fn with_turns(model: &Model, position: &[f64]) -> PyResult<()> {
    for (name, turn) in quaternions(model) {
        let norm = norm(&position[turn]);
        if norm.is_nan() || (norm - 1.0).abs() > SLACK {
            let message = format!("the quaternion of the hinge of `{name}` has norm {norm}, allowed: 1");
            return Err(PyValueError::new_err(message));
        }
    }
    Ok(())
}

/// Quaternions of unit norm, in numbers that are finite.
pub(crate) fn checked(model: &Model, state: State) -> PyResult<State> {
    let State { mut position, velocity } = state;
    if position.iter().chain(&velocity).any(|x| !x.is_finite()) {
        return Err(PyValueError::new_err("a state has finite numbers alone"));
    }
    with_turns(model, &position)?;
    for (_, turn) in quaternions(model) {
        let norm = norm(&position[turn.clone()]);
        position[turn].iter_mut().for_each(|x| *x /= norm);
    }
    Ok(State { position, velocity })
}

/// The nearest state that loops, drives and gears agree with.
fn nearest(model: &Arc<Model>, state: State) -> PyResult<State> {
    let State { position, velocity } = checked(model, state)?;
    let (position, velocity) = stillpoint::constraint::closed(model, &position, &velocity).map_err(|problems| {
        PyValueError::new_err(problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
    })?;
    Ok(State { position, velocity })
}

/// A state from outside: one that loops, drives and gears agree with.
pub(crate) fn closed(model: &Arc<Model>, state: State) -> PyResult<State> {
    let closed = nearest(model, state.clone())?;
    let refused = |name: &str, given: f64, own: f64| {
        Err(PyValueError::new_err(format!(
            "loops, drives or gears do not agree with this state: `{name}` is {given:?}, in the nearest one that they agree with \
             {own:?}; `Scene.close(q, v)` gives that state"
        )))
    };
    let (names, rates) = (dynamics::coordinates(model), dynamics::velocities(model));
    let mut unit = vec![1.0; model.velocity_count()];
    model.lengths().for_each(|velocity| unit[velocity] = model.length_scale());
    for link in model.links.iter() {
        let (positions, velocities) = link.joint.counts();
        let mut moved = vec![0.0; velocities];
        relative(link, &state.position, &closed.position, &mut moved);
        if (0..velocities).any(|i| moved[i].abs() > SLACK * unit[link.velocity + i]) {
            // The number that differs most, of a quaternion perhaps.
            let apart = |at: &usize| (state.position[*at] - closed.position[*at]).abs();
            let own = link.position..link.position + positions;
            let at = own.max_by(|a, b| apart(a).total_cmp(&apart(b))).unwrap_or(link.position);
            return refused(&names[at], state.position[at], closed.position[at]);
        }
    }
    let fastest = state.velocity.iter().fold(1.0, |m: f64, v| m.max(v.abs()));
    for (at, (given, own)) in state.velocity.iter().zip(&closed.velocity).enumerate() {
        // What is given no velocity has the one that drives give it.
        if *given != 0.0 && (given - own).abs() > SLACK * fastest {
            return refused(&rates[at], *given, *own);
        }
    }
    Ok(closed)
}

/// A number that has to be finite and above zero.
pub(crate) fn positive(name: &str, number: Option<f64>) -> PyResult<Option<f64>> {
    match number {
        Some(number) if !(number > 0.0 && number.is_finite()) => {
            let message = format!("`{name}` is {number}, allowed: above 0");
            Err(PyValueError::new_err(message))
        }
        other => Ok(other),
    }
}
