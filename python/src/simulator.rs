//! Stepping by hand.

use crate::RunError;
use crate::control::{inputs, outputs, set};
use crate::interrupt::Interrupt;
use crate::run::Asked;
use crate::scene::frozen;
use numpy::PyArray1;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use stillpoint::integrate::Method;
use stillpoint::model::Model;
use stillpoint::record::Fanout;
use stillpoint::simulate::{self, Resume, Settings, State, Summary};

/// A scene at a time: it goes on as far as it is told to, with stops, events and controllers as in a run.
#[pyclass(frozen, module = "stillpoint")]
pub(crate) struct Simulator {
    now: Mutex<Now>,
}

/// Where it is.
#[derive(Clone)]
struct Now {
    /// With the inputs and what controllers remember.
    model: Arc<Model>,
    settings: Settings,
    time: f64,
    state: State,
    inputs: Vec<f64>,
    memories: Vec<Vec<f64>>,
    /// `None` at the start, and after a change from outside.
    resume: Option<Resume>,
    events: Vec<simulate::events::Occurrence>,
}

impl Simulator {
    pub(crate) fn new(asked: Asked) -> Self {
        let Asked { model, settings, start, .. } = asked;
        let inputs = model.inputs.iter().map(|motor| model.motors[*motor].given().unwrap_or(0.0)).collect();
        let memories = model.controllers.iter().map(|one| one.memory().to_vec()).collect();
        let (resume, events) = (None, Vec::new());
        let time = settings.begin();
        Self { now: Mutex::new(Now { model, settings, time, state: start, inputs, memories, resume, events }) }
    }

    fn now(&self) -> MutexGuard<'_, Now> {
        self.now.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Now {
    /// Goes on to a time (s).
    fn advance(&mut self, until: f64, go_on: &dyn Fn() -> bool) -> Result<(), simulate::RunError> {
        // The method of one that has not stepped yet is its settings'.
        let resume = self.resume.unwrap_or(Resume { time: self.time, method: Method::Rk4, step: None, grid: None });
        let settings = Settings { duration: until - self.time, resume: Some(resume), ..self.settings };
        let model = Arc::new(self.model.continued(&self.inputs, &self.memories));
        let rate = 0.5 / settings.duration;
        let go_on = &mut |_: f64, _: &State| go_on();
        let done = simulate::run(&model, &settings, rate, &self.state, &mut Fanout::new(), go_on)?;
        self.take(done);
        Ok(())
    }

    fn take(&mut self, done: Summary) {
        (self.time, self.state, self.resume) = (done.end_time, done.state, Some(done.resume));
        (self.inputs, self.memories) = (done.inputs, done.memories);
        self.events.extend(done.events);
    }
}

#[pymethods]
impl Simulator {
    /// The time (s).
    #[getter]
    fn time(&self) -> f64 {
        self.now().time
    }

    /// Hinge coordinates.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        frozen(py, &self.now().state.position)
    }

    /// Hinge velocities.
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        frozen(py, &self.now().state.velocity)
    }

    /// Motors of type `input` by name: what they push with (N or N m).
    #[getter]
    fn inputs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let now = self.now().clone();
        inputs(py, &now.model, &now.inputs)
    }

    /// The outputs of the scene by name.
    #[getter]
    fn outputs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let now = self.now().clone();
        let mut model = now.model.continued(&now.inputs, &now.memories);
        (model.start_position, model.start_velocity) = (now.state.position, now.state.velocity);
        let numbers = simulate::outputs::at_start(&Arc::new(model), now.time);
        let numbers = numbers.map_err(|fault| RunError::new_err(fault.to_string()))?;
        outputs(py, &now.model, &numbers)
    }

    /// What has happened so far: dictionaries with `time`, `kind`, `name`, `value`, `speed`.
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let of_event = |event: &simulate::events::Occurrence| {
            let all = PyDict::new(py);
            all.set_item("time", event.time)?;
            all.set_item("kind", event.kind.name())?;
            all.set_item("name", &event.name)?;
            all.set_item("value", event.value)?;
            all.set_item("speed", event.speed)?;
            Ok(all)
        };
        self.now().events.iter().map(of_event).collect()
    }

    /// Goes on to a time (s).
    fn advance(&self, py: Python<'_>, time: f64) -> PyResult<()> {
        let interrupt = Interrupt::new();
        let watched = &interrupt;
        // Nobody waits for it with the interpreter in hand.
        let mut now = self.now().clone();
        let begin = now.time;
        if !(time > begin && time.is_finite()) {
            return Err(PyValueError::new_err(format!("`time` is {time}, allowed: later than {begin} s")));
        }
        let (now, done) = py.detach(move || {
            let done = now.advance(time, &|| watched.go_on());
            (now, done)
        });
        interrupt.check()?;
        done.map_err(|error| RunError::new_err(error.to_string()))?;
        *self.now() = now;
        Ok(())
    }

    /// Goes on by so much (s); with inputs for that time, by name, or all of them in a list.
    #[pyo3(signature = (duration, inputs = None))]
    fn step(&self, py: Python<'_>, duration: f64, inputs: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        if let Some(wanted) = inputs {
            let mut now = self.now().clone();
            set(&now.model, wanted, &mut now.inputs)?;
            self.now().inputs = now.inputs;
        }
        let until = self.now().time + duration;
        self.advance(py, until)
    }

    /// Puts it elsewhere: coordinates, velocities, inputs by name, a time.
    #[pyo3(signature = (*, q = None, v = None, inputs = None, time = None))]
    fn set(
        &self,
        q: Option<Vec<f64>>,
        v: Option<Vec<f64>>,
        inputs: Option<&Bound<'_, PyAny>>,
        time: Option<f64>,
    ) -> PyResult<()> {
        let mut next = self.now().clone();
        for (name, given, own) in [("q", q, &mut next.state.position), ("v", v, &mut next.state.velocity)] {
            let Some(given) = given else { continue };
            if given.len() != own.len() || given.iter().any(|x| !x.is_finite()) {
                let message = format!("`{name}` has {} numbers, the scene {}; all finite", given.len(), own.len());
                return Err(PyValueError::new_err(message));
            }
            *own = given;
            next.resume = None;
        }
        if let Some(wanted) = inputs {
            set(&next.model, wanted, &mut next.inputs)?;
        }
        if let Some(time) = time {
            if !(time >= 0.0 && time.is_finite()) {
                return Err(PyValueError::new_err(format!("`time` is {time}, allowed: a finite number ≥ 0")));
            }
            (next.time, next.resume) = (time, None);
        }
        *self.now() = next;
        Ok(())
    }

    /// All of it, for `restore`: plain numbers in a tuple.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let now = self.now();
        let (q, v) = (now.state.position.clone(), now.state.velocity.clone());
        (now.time, q, v, now.inputs.clone(), now.memories.clone()).into_pyobject(py)
    }

    /// Puts it where `state` was called.
    fn restore(&self, state: &Bound<'_, PyTuple>) -> PyResult<()> {
        type Kept = (f64, Vec<f64>, Vec<f64>, Vec<f64>, Vec<Vec<f64>>);
        let (time, position, velocity, inputs, memories): Kept = state.extract()?;
        let mut now = self.now();
        let lengths = |memories: &[Vec<f64>]| memories.iter().map(Vec::len).collect::<Vec<_>>();
        let fits = position.len() == now.state.position.len()
            && velocity.len() == now.state.velocity.len()
            && inputs.len() == now.inputs.len()
            && lengths(&memories) == lengths(&now.memories);
        if !fits {
            return Err(PyTypeError::new_err("this is the state of another scene"));
        }
        now.events.retain(|event| event.time <= time);
        (now.time, now.state, now.resume) = (time, State { position, velocity }, None);
        (now.inputs, now.memories) = (inputs, memories);
        Ok(())
    }

    fn __repr__(&self) -> String {
        let now = self.now();
        format!("<Simulator of `{}` at {} s>", now.model.title, now.time)
    }
}
