//! Equilibria with their certificates.

use crate::NoEquilibrium;
use crate::control::Controller;
use crate::interrupt::Interrupt;
use crate::linear::Linear;
use crate::run::{Asked, Run, run};
use crate::scene::{Names, Scene, by_hinge, frozen, positive};
use numpy::PyArray1;
use pyo3::exceptions::{PyKeyError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};
use stillpoint::model::{Model, Parameter};
use stillpoint::scenario::Scenario;
use stillpoint::simulate::State;
use stillpoint::statics;

/// Where a scene stays.
#[pyclass(frozen, module = "stillpoint")]
pub(crate) struct Equilibrium {
    scene: Py<Scene>,
    held: Arc<Searched>,
}

/// What a search has found, and how long it took.
pub(crate) struct Searched {
    answer: statics::InverseAnswer,
    wall: Duration,
    json: OnceLock<String>,
}

impl Searched {
    /// Searches for the equilibrium of a scene.
    pub(crate) fn new(scenario: &Scenario, model: &Arc<Model>, go_on: &dyn Fn() -> bool) -> Result<Self, String> {
        let before = Instant::now();
        let Scenario { description, statics, margin, .. } = scenario;
        let (description, model, sought) = (description.clone(), Arc::clone(model), scenario.sought());
        let answer = statics::answer(description, model, sought, statics, margin, go_on);
        let answer = answer.map_err(|error| error.to_string())?;
        Ok(Self { answer, wall: before.elapsed(), json: OnceLock::new() })
    }

    /// Whether it is an equilibrium.
    pub(crate) fn converged(&self) -> bool {
        self.answer.found.converged
    }

    pub(crate) fn model(&self) -> &Arc<Model> {
        &self.answer.model
    }

    pub(crate) fn state(&self) -> State {
        State { position: self.answer.found.position.clone(), velocity: self.answer.found.velocity.clone() }
    }

    /// What `stillpoint statics --json` prints.
    pub(crate) fn text(&self) -> &str {
        self.json.get_or_init(|| {
            stillpoint::cli::statics_answer(&self.answer.model, &self.answer.found, self.wall.as_secs_f64()).to_string()
        })
    }
}

/// A small motion about an equilibrium.
#[pyclass(frozen, get_all, module = "stillpoint")]
pub(crate) struct Mode {
    /// Undamped, or of the damped mode where there is damping (Hz); 0 for motions that do not come back.
    frequency: f64,
    /// Part of the critical damping; 0 without dampers, negative for what grows.
    damping_ratio: f64,
    /// Decay rate (1/s).
    decay_rate: f64,
}

#[pymethods]
impl Mode {
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (f64, f64, f64))> {
        let again = py.get_type::<Self>().getattr("_again")?;
        Ok((again, (self.frequency, self.damping_ratio, self.decay_rate)))
    }

    #[staticmethod]
    fn _again(frequency: f64, damping_ratio: f64, decay_rate: f64) -> Self {
        Self { frequency, damping_ratio, decay_rate }
    }

    fn __repr__(&self) -> String {
        format!("Mode(frequency={:.6}, damping_ratio={:.4})", self.frequency, self.damping_ratio)
    }
}

impl Equilibrium {
    pub(crate) fn new(scene: Py<Scene>, held: Arc<Searched>) -> Self {
        Self { scene, held }
    }

    /// The exception of one that is none, which has it as its `answer`.
    pub(crate) fn refused(self, py: Python<'_>) -> PyErr {
        let error = NoEquilibrium::new_err(self.why());
        match Py::new(py, self).and_then(|answer| error.value(py).setattr("answer", answer)) {
            Ok(()) => error,
            Err(other) => other,
        }
    }

    /// What a run from here starts with.
    pub(crate) fn held(&self) -> &Arc<Searched> {
        &self.held
    }

    pub(crate) fn converged(&self) -> bool {
        self.held.converged()
    }

    /// Why it is none.
    pub(crate) fn why(&self) -> String {
        let found = &self.held.answer.found;
        let mut text = match found.balanced {
            true => "the forces balance, but not all that was asked for was found".to_owned(),
            false => format!("no equilibrium was found: the residual is {:.3e} of the forces", found.relative_residual),
        };
        found.notes.iter().for_each(|note| text.push_str(&format!("\n{note}")));
        text
    }

    fn listed(&self) -> Vec<Mode> {
        let Some(stability) = &self.held.answer.found.stability else { return Vec::new() };
        if stability.damped.is_empty() {
            let undamped = stability.modes.iter();
            return undamped
                .map(|mode| Mode { frequency: mode.frequency_hz, damping_ratio: 0.0, decay_rate: -mode.growth_rate })
                .collect();
        }
        let damped = stability.damped.iter();
        damped
            .map(|mode| Mode {
                frequency: mode.frequency_hz,
                damping_ratio: mode.damping_ratio,
                decay_rate: mode.decay_rate,
            })
            .collect()
    }

    fn text(&self) -> &str {
        self.held.text()
    }
}

#[pymethods]
impl Equilibrium {
    /// Hinge coordinates.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        frozen(py, &self.held.answer.found.position)
    }

    /// Hinge velocities: zero, but for drives that move.
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        frozen(py, &self.held.answer.found.velocity)
    }

    /// `"stable"`, `"unstable"` or `"neutral"`.
    #[getter]
    fn verdict(&self) -> Option<&'static str> {
        self.held.answer.found.stability.as_ref().map(|stability| stability.verdict.name())
    }

    /// Small motions, slowest first: damped ones where there is damping. A list that is a table, too.
    #[getter]
    fn modes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("stillpoint._table")?.call_method1("Modes", (self.listed(),))
    }

    /// Undamped frequencies (Hz), ascending.
    #[getter]
    fn frequencies<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        let frequencies = self.held.answer.found.stability.iter().flat_map(|stability| stability.frequencies());
        PyArray1::from_vec(py, frequencies.collect())
    }

    /// Hinge coordinates by the body that the hinge carries.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        by_hinge(py, &self.held.answer.model, &self.held.answer.found.position, true)
    }

    /// What each hinge passes to its body at its root marker, inertial axes: name → (force, moment).
    #[getter]
    fn reactions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for (body, wrench) in self.held.answer.model.bodies.iter().zip(&self.held.answer.found.reactions) {
            let [force, moment] = [wrench.force, wrench.moment].map(|x| PyArray1::from_slice(py, x.as_slice()));
            all.set_item(&body.name, (force, moment))?;
        }
        Ok(all)
    }

    /// Where the root marker of each body is: name → (position, quaternion w, x, y, z).
    #[getter]
    fn bodies<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        for (body, pose) in self.held.answer.model.bodies.iter().zip(&self.held.answer.found.poses) {
            let (at, turn) = (pose.translation.vector, pose.rotation);
            let turn = [turn.w, turn.i, turn.j, turn.k];
            all.set_item(&body.name, (PyArray1::from_slice(py, at.as_slice()), PyArray1::from_slice(py, &turn)))?;
        }
        Ok(all)
    }

    /// What is left of the forces, in parts of those that cancel.
    #[getter]
    fn residual(&self) -> f64 {
        self.held.answer.found.relative_residual
    }

    /// What was unknown, by address.
    #[getter]
    fn unknowns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let all = PyDict::new(py);
        self.held.answer.found.unknowns.iter().try_for_each(|(name, value)| all.set_item(name, value))?;
        Ok(all)
    }

    /// What there is to say besides.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.held.answer.found.notes.iter().map(ToString::to_string).collect()
    }

    /// Everything that `stillpoint statics --json` prints.
    fn as_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.call_method1("loads", (self.text(),))
    }

    /// The outputs of the scene (`[[output]]`): a number, or a list of several.
    #[getter]
    fn outputs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.as_dict(py)?.call_method1("get", ("outputs", PyDict::new(py)))
    }

    /// The equations about the equilibrium, `ẋ = A x + B u`, `y = C x + D u`: from inputs by their addresses (all motors of type `input`
    /// unless others are named) to outputs by name (all).
    #[pyo3(signature = (inputs = None, outputs = None))]
    pub(crate) fn linearize(&self, inputs: Option<Names>, outputs: Option<Names>) -> PyResult<Linear> {
        let (held, inputs, outputs) = (&self.held.answer, inputs.map(Names::all), outputs.map(Names::all));
        let linear = stillpoint::cli::linearize_about(&held.description, &held.model, &held.found, inputs, outputs);
        linear.map(Linear::new).map_err(|error| PyValueError::new_err(format!("{error:#}")))
    }

    /// How an output (`"camber"`, `"tip[2]"`, `"frequency[0]"`) answers to the numbers of the scene, or to those of some addresses:
    /// derivatives by address, `None` where there is none; `notes` says why, and as long as what they hold. Of an output with several
    /// numbers a list of them.
    #[pyo3(signature = (output, addresses = None))]
    fn sensitivity<'py>(&self, py: Python<'py>, output: &str, addresses: Option<Names>) -> PyResult<Bound<'py, PyAny>> {
        let (held, addresses) = (&self.held.answer, addresses.map(Names::all));
        let mut numbers = Vec::new();
        for address in addresses.iter().flatten() {
            let found = Parameter::find(&held.description, address).map_err(|unknown| {
                let help = unknown.help.map(|help| format!("; {help}")).unwrap_or_default();
                PyKeyError::new_err(format!("{}{help}", unknown.message))
            })?;
            numbers.extend(found);
        }
        let (asked, numbers) = ([output.to_owned()], addresses.map(|_| numbers));
        let interrupt = Interrupt::new();
        let (watched, statics::InverseAnswer { description, model, found }) = (&interrupt, held);
        let table =
            py.detach(move || statics::sensitivities(description, model, found, &asked, numbers, &|| watched.go_on()));
        interrupt.check()?;
        let table = table.map_err(|error| match error {
            statics::SensitivityError::Output { .. } => PyKeyError::new_err(error.to_string()),
            other => PyValueError::new_err(other.to_string()),
        })?;
        let all = PyDict::new(py);
        for (column, number) in table.parameters.iter().enumerate() {
            match &table.derivatives[..] {
                [one] => all.set_item(&number.address, one[column])?,
                several => {
                    let of: Vec<Option<f64>> = several.iter().map(|row| row[column]).collect();
                    all.set_item(&number.address, of)?;
                }
            }
        }
        py.import("stillpoint._table")?.call_method1("Sensitivities", (all, table.notes))
    }

    /// A run from here: what is in equilibrium stays. A controller as in `Scene.run`.
    #[pyo3(signature = (duration = None, *, rate = None, controller = None, period = None))]
    fn run(
        &self,
        py: Python<'_>,
        duration: Option<f64>,
        rate: Option<f64>,
        controller: Option<Py<PyAny>>,
        period: Option<f64>,
    ) -> PyResult<Run> {
        let scenario = self.scene.get().scenario();
        let mut settings = scenario.simulate.clone();
        settings.start = stillpoint::simulate::Start::Equilibrium;
        settings.duration = positive("duration", duration)?.unwrap_or(settings.duration);
        let asked = Asked {
            model: Arc::clone(self.held.model()),
            settings,
            rate: positive("rate", rate)?.unwrap_or(scenario.record.rate),
            start: self.held.state(),
            held: Some(Arc::clone(&self.held)),
            name: scenario.name.clone(),
            text: scenario.text.clone(),
        };
        let control = Controller::of(&asked.model, controller, period)?;
        run(py, &asked, control)
    }

    /// The search begins where the scene does and finds the same, an equilibrium or, as the answer of `NoEquilibrium`, none.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Py<Scene>,))> {
        Ok((py.get_type::<Scene>().getattr("_search")?, (self.scene.clone_ref(py),)))
    }

    /// For notebooks.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("stillpoint._html")?.call_method1("equilibrium", (slf,))
    }

    fn __repr__(&self) -> String {
        let found = &self.held.answer.found;
        let slowest = found.stability.as_ref().and_then(|stability| stability.modes.first());
        let slowest = slowest.map_or(String::new(), |mode| format!(", slowest mode {:.6} Hz", mode.frequency_hz));
        let verdict = self.verdict().unwrap_or("not certified");
        format!(
            "<Equilibrium of `{}`: {verdict}{slowest}, residual {:.1e}>",
            self.held.answer.model.title, found.relative_residual
        )
    }
}
