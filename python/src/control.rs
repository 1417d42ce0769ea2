//! Python functions as controllers of a run.

use crate::dynamics::shown;
use pyo3::exceptions::{PyKeyError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::sync::{Mutex, PoisonError};
use stillpoint::model::Model;
use stillpoint::simulate::control::Sensed;

/// A function, and the time between its instants (s).
pub(crate) struct Controller {
    function: Py<PyAny>,
    pub(crate) period: f64,
}

/// What a function has raised.
#[derive(Default)]
pub(crate) struct Failed(Mutex<Option<PyErr>>);

impl Failed {
    fn note(&self, error: PyErr) -> String {
        let text = error.to_string();
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(error);
        text
    }

    /// The exception of the function in the place of the error of the run that it ended; it has the run as its `run`.
    pub(crate) fn instead_of(&self, py: Python<'_>, error: PyErr) -> PyErr {
        let Some(raised) = self.0.lock().unwrap_or_else(PoisonError::into_inner).take() else { return error };
        if let Ok(run) = error.value(py).getattr("run") {
            // Not every exception takes attributes.
            let _ = raised.value(py).setattr("run", run);
        }
        raised
    }
}

impl Controller {
    /// The controller of the arguments of a run.
    pub(crate) fn of(model: &Model, function: Option<Py<PyAny>>, period: Option<f64>) -> PyResult<Option<Self>> {
        match (function, period) {
            (None, None) => Ok(None),
            (Some(function), Some(period)) => {
                if model.inputs.is_empty() {
                    let message = "the scene has no `[[motor]]` of type `input`: a controller has nothing to set";
                    return Err(PyValueError::new_err(message));
                }
                Ok(Some(Self { function, period }))
            }
            _ => Err(PyTypeError::new_err("`controller` and `period` belong together")),
        }
    }

    /// The law of the function: `function(time, outputs)`, outputs by name, gives the inputs.
    pub(crate) fn law<'l>(
        &'l self,
        model: &'l Model,
        failed: &'l Failed,
    ) -> impl FnMut(Sensed<'_>, &mut [f64]) -> Result<(), String> + use<'l> {
        move |sensed, inputs| {
            Python::attach(|py| {
                let answer =
                    outputs(py, model, sensed.outputs).and_then(|all| self.function.bind(py).call1((sensed.time, all)));
                let set = answer.and_then(|answer| {
                    set(model, &answer, inputs).map_err(|error| {
                        // A `KeyError` as a text has quotes around its message.
                        let words =
                            error.value(py).getattr("args").and_then(|args| args.get_item(0)?.extract::<String>());
                        let words = words.unwrap_or_else(|_| error.value(py).to_string());
                        let at = format!("at t = {} s: {words}", sensed.time);
                        PyErr::from_type(error.get_type(py), at)
                    })
                });
                set.map_err(|error| failed.note(error))
            })
        }
    }
}

/// Outputs by their names: a number, or a list of several.
pub(crate) fn outputs<'py>(py: Python<'py>, model: &Model, numbers: &[f64]) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    for output in &model.outputs {
        match &numbers[output.range()] {
            [one] => all.set_item(&output.name, one)?,
            several => all.set_item(&output.name, PyList::new(py, several)?)?,
        }
    }
    Ok(all)
}

/// Inputs by their names.
pub(crate) fn inputs<'py>(py: Python<'py>, model: &Model, numbers: &[f64]) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    let names = model.inputs.iter().map(|motor| &model.motors[*motor].name);
    names.zip(numbers).try_for_each(|(name, number)| all.set_item(name, number))?;
    Ok(all)
}

/// Sets inputs: a number for the only one, a list of all, or some by their names; `None` leaves them.
pub(crate) fn set(model: &Model, answer: &Bound<'_, PyAny>, inputs: &mut [f64]) -> PyResult<()> {
    let name = |index: usize| model.motors[model.inputs[index]].name.as_str();
    if answer.is_none() {
        return Ok(());
    }
    if let Ok(some) = answer.cast::<PyDict>() {
        for (key, value) in some.iter() {
            let key: String = key.extract().map_err(|_| refused(&key, "a key of the inputs", "the name of a motor"))?;
            let Some(index) = (0..inputs.len()).find(|index| name(*index) == key) else {
                let near = stillpoint::suggest::closest(&key, (0..inputs.len()).map(name));
                let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
                return Err(PyKeyError::new_err(format!("no input is called `{key}`{near}")));
            };
            inputs[index] = value.extract().map_err(|_| refused(&value, &format!("the input `{key}`"), "a number"))?;
        }
        return check(model, inputs);
    }
    let numbers = answer.extract::<f64>().map(|one| vec![one]).or_else(|_| answer.extract());
    let numbers: Vec<f64> = numbers.map_err(|_: PyErr| {
        let names: Vec<&str> = (0..inputs.len()).map(name).collect();
        let form = format!("a number, a list of {}, a dictionary with `{}`, or None", inputs.len(), names.join("`, `"));
        refused(answer, "what sets the inputs (the answer of a controller, or `inputs`)", &form)
    })?;
    if numbers.len() != inputs.len() {
        let message = format!("{} numbers for {} inputs", numbers.len(), inputs.len());
        return Err(PyValueError::new_err(message));
    }
    inputs.copy_from_slice(&numbers);
    check(model, inputs)
}

/// Something of another type than is expected.
fn refused(given: &Bound<'_, PyAny>, what: &str, expected: &str) -> PyErr {
    PyTypeError::new_err(format!("{what} is {}, expected: {expected}", shown(given)))
}

fn check(model: &Model, inputs: &[f64]) -> PyResult<()> {
    let Some(index) = inputs.iter().position(|x| !x.is_finite()) else { return Ok(()) };
    let name = &model.motors[model.inputs[index]].name;
    Err(PyValueError::new_err(format!("the input `{name}` is {}, allowed: finite numbers", inputs[index])))
}
