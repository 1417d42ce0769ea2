//! Runs as arrays.

use crate::RunError;
use crate::interrupt::Interrupt;
use crate::recorder::Columns;
use crate::scene::by_hinge;
use numpy::PyArray1;
use pyo3::exceptions::{PyKeyError, PyMemoryError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::collections::HashMap;
use std::sync::Arc;
use stillpoint::model::Model;
use stillpoint::simulate::{self, Settings, State, Summary};

/// A run: `run.time`, `run["arm.angle"]`, and what it came to.
#[pyclass(frozen, mapping, module = "stillpoint")]
pub(crate) struct Run {
    model: Arc<Model>,
    summary: Summary,
    time: Py<PyArray1<f64>>,
    /// Name and unit, in order.
    names: Vec<(String, String)>,
    columns: Vec<Py<PyArray1<f64>>>,
    by_name: HashMap<String, usize>,
}

/// More samples than this are refused: each column would have 80 GB.
const MOST_SAMPLES: f64 = 1e10;

/// Runs a model and keeps its samples.
pub(crate) fn run(py: Python<'_>, model: &Arc<Model>, settings: &Settings, rate: f64, start: State) -> PyResult<Run> {
    let interrupt = Interrupt::new();
    let asked = &interrupt;
    let (model, settings) = (Arc::clone(model), *settings);
    let of_run = Arc::clone(&model);
    let done = py.detach(move || {
        let scene = simulate::scene(&of_run);
        let samples = rate * settings.duration + 2.0;
        let mut columns = (samples < MOST_SAMPLES).then(|| Columns::new(&scene, samples as usize)).flatten()?;
        let done = simulate::run(&of_run, &settings, rate, &start, &mut columns, &mut |_, _| asked.go_on());
        Some(done.map(|summary| (summary, columns)))
    });
    interrupt.check()?;
    let done = done.ok_or_else(|| {
        let samples = rate * settings.duration;
        PyMemoryError::new_err(format!(
            "{samples:.0} samples do not fit into memory: take a smaller `rate` or `duration`"
        ))
    })?;
    let (summary, columns) = done.map_err(|error| RunError::new_err(error.to_string()))?;
    let names = columns.names();
    let by_name = names.iter().enumerate().map(|(at, (name, _))| (name.clone(), at)).collect();
    let array = |numbers: Vec<f64>| -> PyResult<Py<PyArray1<f64>>> {
        let array = PyArray1::from_vec(py, numbers);
        array.call_method1("setflags", (false,))?;
        Ok(array.unbind())
    };
    Ok(Run {
        model,
        summary,
        time: array(columns.time)?,
        names,
        columns: columns.columns.into_iter().map(array).collect::<PyResult<_>>()?,
        by_name,
    })
}

#[pymethods]
impl Run {
    /// Times of the samples (s).
    #[getter]
    fn time(&self, py: Python<'_>) -> Py<PyArray1<f64>> {
        self.time.clone_ref(py)
    }

    /// Names of the columns.
    #[getter]
    fn columns(&self) -> Vec<&str> {
        self.names.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// The SI unit of each column.
    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let units = PyDict::new(py);
        self.names.iter().try_for_each(|(name, unit)| units.set_item(name, unit))?;
        Ok(units)
    }

    fn __getitem__(&self, py: Python<'_>, name: &str) -> PyResult<Py<PyArray1<f64>>> {
        match self.by_name.get(name) {
            Some(at) => Ok(self.columns[*at].clone_ref(py)),
            None if name == "time" => Ok(self.time.clone_ref(py)),
            None => {
                let known = self.names.iter().map(|(name, _)| name.as_str());
                let near = stillpoint::suggest::closest(name, known).map(|near| format!("; did you mean `{near}`?"));
                Err(PyKeyError::new_err(format!("no column is called `{name}`{}", near.unwrap_or_default())))
            }
        }
    }

    fn __len__(&self) -> usize {
        self.names.len()
    }

    fn __contains__(&self, name: &str) -> bool {
        name == "time" || self.by_name.contains_key(name)
    }

    fn __iter__(slf: &Bound<'_, Self>) -> PyResult<Py<PyAny>> {
        let names = pyo3::types::PyList::new(slf.py(), slf.get().columns())?;
        Ok(names.call_method0("__iter__")?.unbind())
    }

    fn keys(&self) -> Vec<&str> {
        self.columns()
    }

    /// Reached time (s).
    #[getter]
    fn end_time(&self) -> f64 {
        self.summary.end_time
    }

    /// The last positions.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.summary.state.position)
    }

    /// The last velocities.
    #[getter]
    fn v<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.summary.state.velocity)
    }

    /// The last positions by hinge.
    #[getter]
    fn positions<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        by_hinge(py, &self.model, &self.summary.state.position, true)
    }

    /// What happened: dictionaries with `time`, `kind`, `name`, `value`, `speed`.
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
        self.summary.events.iter().map(of_event).collect()
    }

    /// Steps that were taken.
    #[getter]
    fn steps(&self) -> u64 {
        self.summary.statistics.steps
    }

    /// Largest energy that is unaccounted for (J).
    #[getter]
    fn energy_drift(&self) -> f64 {
        self.summary.energy_drift
    }

    /// The methods that stepped.
    #[getter]
    fn integrators(&self) -> Vec<&str> {
        self.summary.integrators.iter().map(|method| method.name()).collect()
    }

    /// Writes the columns to a CSV file.
    fn save(&self, py: Python<'_>, path: std::path::PathBuf) -> PyResult<()> {
        py.import("stillpoint._table")?
            .call_method1("save", (path, self.names.clone(), self.time.clone_ref(py), self.arrays(py)))?;
        Ok(())
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let samples = self.time.bind(py).len()?;
        let methods = self.integrators().join(", then ");
        Ok(format!("<Run of `{}` to {} s: {samples} samples, {methods}>", self.model.title, self.summary.end_time))
    }
}

impl Run {
    fn arrays(&self, py: Python<'_>) -> Vec<Py<PyArray1<f64>>> {
        self.columns.iter().map(|column| column.clone_ref(py)).collect()
    }
}
