//! Fits of a scene to measurements.

use crate::interrupt::Interrupt;
use crate::scene::Scene;
use numpy::{AllowTypeChange, PyArrayLike1};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use stillpoint::scenario::{Override, Scenario};
use stillpoint::study::fit::table::MeasuredTable;
use stillpoint::study::fit::{Adjusted, FitQuestion, Trouble, fit};

/// The parameters of a fit: `"address=start,low..high"` in a list, or a dictionary of addresses, each with `None`, a start, or
/// `(start, low, high)`.
fn adjusted(parameters: &Bound<'_, PyAny>) -> PyResult<Vec<Adjusted>> {
    if let Ok(named) = parameters.cast::<PyDict>() {
        let of = |(address, value): (Bound<'_, PyAny>, Bound<'_, PyAny>)| {
            let address = address.extract::<String>()?;
            let (start, range) = match value.extract::<Option<f64>>() {
                Ok(start) => (start, [None, None]),
                Err(_) => {
                    let (start, low, high) =
                        value.extract::<(Option<f64>, Option<f64>, Option<f64>)>().map_err(|_| {
                            PyTypeError::new_err(format!("`{address}` has None, a start, or (start, low, high)"))
                        })?;
                    (start, [low, high])
                }
            };
            let [low, high] = range;
            Ok(Adjusted { address, start, range: [low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY)] })
        };
        return named.iter().map(of).collect();
    }
    if parameters.extract::<String>().is_ok() {
        return Err(PyTypeError::new_err("`parameters` is a list of addresses, or a dictionary"));
    }
    let texts = parameters.extract::<Vec<String>>()?;
    texts.iter().map(|text| Adjusted::parse(text).map_err(PyValueError::new_err)).collect()
}

/// Columns of numbers by their headings.
type Columns<'py> = Vec<(String, PyArrayLike1<'py, f64, AllowTypeChange>)>;

/// What is asked of a fit beside its data.
pub(crate) struct Asked<'a, 'py> {
    pub(crate) parameters: &'a Bound<'py, PyAny>,
    pub(crate) run: bool,
    pub(crate) deviations: Option<&'a Bound<'py, PyDict>>,
    pub(crate) ignore: Option<Vec<String>>,
    pub(crate) confidence: f64,
}

/// The fit, as `stillpoint._fit` has it.
pub(crate) fn of_scene<'py>(
    scene: &Bound<'py, Scene>,
    (scenario, set): (&Scenario, &[Override]),
    data: &Bound<'py, PyAny>,
    asked: &Asked<'_, 'py>,
) -> PyResult<Bound<'py, PyAny>> {
    let py = scene.py();
    let python = py.import("stillpoint._fit")?;
    let columns: Columns<'py> = python.call_method1("columns", (data,))?.extract()?;
    let columns = columns.into_iter().map(|(name, values)| (name, values.as_array().iter().copied().collect()));
    let table = MeasuredTable::new(columns.collect()).map_err(PyValueError::new_err)?;
    let given = asked.deviations.iter().flat_map(|given| given.iter());
    let deviations = given.map(|(name, value)| Ok((name.extract::<String>()?, value.extract::<f64>()?)));
    let question = FitQuestion {
        parameters: adjusted(asked.parameters)?,
        run: asked.run,
        deviations: deviations.collect::<PyResult<_>>()?,
        ignored: asked.ignore.clone().unwrap_or_default(),
        level: asked.confidence,
    };
    let interrupt = Interrupt::new();
    let watched = &interrupt;
    let found = py.detach(|| fit(scenario, set, &table, &question, &|| watched.go_on()));
    interrupt.check()?;
    match found {
        Ok(found) => python.call_method1("Fit", (scene, stillpoint::cli::fit_answer(&found).to_string())),
        Err(Trouble::Problems(problems)) => Err(crate::SceneError::new_err(problems.render(false))),
        Err(other) => Err(PyValueError::new_err(other.to_string())),
    }
}
