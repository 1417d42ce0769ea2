//! Stepping by hand.

use crate::RunError;
use crate::control::{inputs, outputs, set};
use crate::dynamics::shown;
use crate::interrupt::Interrupt;
use crate::run::Asked;
use crate::scene::{checked, closed, frozen};
use numpy::PyArray1;
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use stillpoint::integrate::Method;
use stillpoint::simulate::{self, Grid, Mode, Resume, State};
use stillpoint::simulator::{self, Snapshot};

/// A scene at a time: it goes on as far as it is told to, with stops, events and controllers as in a run.
#[pyclass(frozen, module = "stillpoint")]
pub(crate) struct Simulator {
    now: Mutex<simulator::Simulator>,
    /// Who has it steps: threads take turns, and none steps from where another one has gone on.
    turn: Mutex<()>,
}

impl Simulator {
    pub(crate) fn new(asked: Asked) -> Self {
        let Asked { model, settings, start, .. } = asked;
        Self { now: Mutex::new(simulator::Simulator::new(model, settings, start)), turn: Mutex::new(()) }
    }

    /// Goes on, with these inputs, to the time (s) that follows from where it is.
    fn go(&self, py: Python<'_>, inputs: Option<Vec<f64>>, until: impl Fn(f64) -> f64 + Send) -> PyResult<()> {
        let interrupt = Interrupt::new();
        let watched = &interrupt;
        // Nobody waits for it with the interpreter in hand.
        let done = py.detach(move || {
            let _turn = self.turn.lock().unwrap_or_else(PoisonError::into_inner);
            let mut now = self.now().clone();
            if let Some(inputs) = &inputs {
                now.set_inputs(inputs);
            }
            let begin = now.snapshot().time;
            let time = until(begin);
            if !(time >= begin && time.is_finite()) {
                return Err(format!("`time` is {time}, allowed: not earlier than {begin} s"));
            }
            let done = if time > begin { now.advance(time, &|| watched.go_on()) } else { Ok(()) };
            if done.is_ok() && watched.go_on() {
                *self.now() = now;
            }
            Ok(done)
        });
        interrupt.check()?;
        done.map_err(PyValueError::new_err)?.map_err(failed)
    }

    fn now(&self) -> MutexGuard<'_, simulator::Simulator> {
        self.now.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// What `state` gives: time, coordinates, velocities, inputs, memories, and what the next step follows from.
#[derive(FromPyObject)]
struct Kept(f64, Vec<f64>, Vec<f64>, Vec<f64>, Vec<Vec<f64>>, Option<Next>);

/// What a next step follows from: the time, the method, its step (s), the grid of fixed steps, and what stops, dry friction and contacts do.
#[derive(FromPyObject)]
struct Next(f64, String, Option<f64>, Option<(f64, u64)>, Option<Vec<f64>>);

impl Next {
    fn resume(self) -> PyResult<Resume> {
        let Self(time, method, step, grid, mode) = self;
        let method = Method::ALL.into_iter().find(|one| one.name() == method).ok_or_else(|| {
            PyValueError::new_err(format!("no integrator is called `{method}`: this is no state of this version"))
        })?;
        if step.is_some_and(|step| !(step > 0.0 && step.is_finite())) {
            return Err(PyValueError::new_err("the step of a state is a finite number above 0"));
        }
        if grid.is_some_and(|(origin, _)| !origin.is_finite()) {
            return Err(PyValueError::new_err("the grid of a state begins at a finite time"));
        }
        let mode = mode.map(|numbers| Mode::of_numbers(&numbers).map(Arc::new));
        if mode == Some(None) {
            return Err(PyValueError::new_err("what stops and contacts do is no part of a state of this version"));
        }
        let grid = grid.map(|(origin, steps)| Grid { origin, steps });
        Ok(Resume { time, method, step, grid, mode: mode.flatten() })
    }
}

fn failed(error: simulate::RunError) -> PyErr {
    RunError::new_err(error.to_string())
}

fn of_another(error: simulator::AnotherScene) -> PyErr {
    PyTypeError::new_err(error.to_string())
}

#[pymethods]
impl Simulator {
    /// The time (s).
    #[getter]
    fn time(&self) -> f64 {
        self.now().snapshot().time
    }

    /// Hinge coordinates.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        frozen(py, &self.now().snapshot().state.position)
    }

    /// Hinge velocities.
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        frozen(py, &self.now().snapshot().state.velocity)
    }

    /// Motors of type `input` by name: what they push with (N or N m).
    #[getter]
    fn inputs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let now = self.now();
        inputs(py, now.model(), &now.snapshot().inputs)
    }

    /// The outputs of the scene by name.
    #[getter]
    fn outputs<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let mut now = self.now().clone();
        let numbers = py.detach(|| now.outputs().map(<[f64]>::to_vec)).map_err(failed)?;
        let all = outputs(py, now.model(), &numbers);
        let mut here = self.now();
        if here.snapshot() == now.snapshot() {
            *here = now;
        }
        all
    }

    /// What has happened so far: dictionaries with `time`, `kind`, `name`, `value`, its `unit`, `speed`.
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let of_event = |event: &simulate::events::Occurrence| {
            let all = PyDict::new(py);
            all.set_item("time", event.time)?;
            all.set_item("kind", event.kind.name())?;
            all.set_item("name", &event.name)?;
            all.set_item("value", event.value)?;
            all.set_item("unit", &event.unit)?;
            all.set_item("speed", event.speed)?;
            Ok(all)
        };
        self.now().events().iter().map(of_event).collect()
    }

    /// Goes on to a time (s); nothing happens if it is there.
    fn advance(&self, py: Python<'_>, time: f64) -> PyResult<()> {
        self.go(py, None, |_| time)
    }

    /// Goes on by so much (s); with inputs for that time, by name, or all of them in a list.
    #[pyo3(signature = (duration, inputs = None))]
    fn step(&self, py: Python<'_>, duration: f64, inputs: Option<&Bound<'_, PyAny>>) -> PyResult<()> {
        if !(duration >= 0.0 && duration.is_finite()) {
            let message = format!("`duration` is {duration}, allowed: a finite number ≥ 0 (s)");
            return Err(PyValueError::new_err(message));
        }
        let inputs = inputs.map(|wanted| {
            let now = self.now().clone();
            let mut inputs = now.snapshot().inputs.clone();
            set(now.model(), wanted, &mut inputs).map(|()| inputs)
        });
        self.go(py, inputs.transpose()?, |begin| begin + duration)
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
        let here = self.now().clone();
        let mut next = here.snapshot().clone();
        let is_moved = q.is_some() || v.is_some();
        for (name, given, own) in [("q", q, &mut next.state.position), ("v", v, &mut next.state.velocity)] {
            let Some(given) = given else { continue };
            if given.len() != own.len() {
                let message = format!("`{name}` has {} numbers, the scene {}", given.len(), own.len());
                return Err(PyValueError::new_err(message));
            }
            if let Some(at) = given.iter().position(|x| !x.is_finite()) {
                let message = format!("`{name}[{at}]` is {}, allowed: finite numbers", given[at]);
                return Err(PyValueError::new_err(message));
            }
            *own = given;
            next.resume = None;
        }
        if let Some(wanted) = inputs {
            set(here.model(), wanted, &mut next.inputs)?;
        }
        if let Some(time) = time {
            if !(time >= 0.0 && time.is_finite()) {
                return Err(PyValueError::new_err(format!("`time` is {time}, allowed: a finite number ≥ 0")));
            }
            (next.time, next.resume) = (time, None);
        }
        if is_moved {
            // Drives are somewhere else later: there the state stands as it is.
            next.state = match next.time == 0.0 {
                true => closed(here.model(), next.state)?,
                false => checked(here.model(), next.state)?,
            };
        }
        self.now().place(next).map_err(of_another)
    }

    /// All of it, for `restore`, in a tuple: time, coordinates, velocities, inputs, what controllers remember, and what the next step
    /// follows from, so that it goes on from there to the same bits.
    fn state<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyTuple>> {
        let here = self.now();
        let now = here.snapshot();
        let (q, v) = (now.state.position.clone(), now.state.velocity.clone());
        let next = now.resume.as_ref().map(|resume| {
            let grid = resume.grid.map(|grid| (grid.origin, grid.steps));
            let mode = resume.mode.as_ref().map(|mode| mode.numbers());
            (resume.time, resume.method.name(), resume.step, grid, mode)
        });
        (now.time, q, v, now.inputs.clone(), now.memories.clone(), next).into_pyobject(py)
    }

    /// Puts it where `state` was called.
    fn restore(&self, state: &Bound<'_, PyAny>) -> PyResult<()> {
        let Kept(time, position, velocity, inputs, memories, next) = state.extract().map_err(|_| {
            PyTypeError::new_err(format!("`state` is {}, expected: what `Simulator.state()` gave", shown(state)))
        })?;
        let resume = next.map(Next::resume).transpose()?.filter(|resume| resume.time == time);
        if !(time >= 0.0 && time.is_finite()) {
            return Err(PyValueError::new_err(format!(
                "the time of the state is {time}, allowed: a finite number ≥ 0"
            )));
        }
        if inputs.iter().chain(memories.iter().flatten()).any(|x| !x.is_finite()) {
            return Err(PyValueError::new_err("a state has finite numbers alone"));
        }
        let model = Arc::clone(self.now().model());
        let (q, v) = (model.position_count(), model.velocity_count());
        let state = State { position, velocity };
        if (state.position.len(), state.velocity.len()) == (q, v) {
            checked(&model, state.clone())?;
        }
        let snapshot = Snapshot { time, state, inputs, memories, resume, stopped_by: None };
        self.now().restore(snapshot).map_err(of_another)
    }

    fn __repr__(&self) -> String {
        let now = self.now();
        format!("<Simulator of `{}` at {} s>", now.model().title, now.snapshot().time)
    }
}
