//! Paths of equilibria.

use crate::arrow::arrow_stream;
use crate::interrupt::Interrupt;
use crate::scene::frozen;
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::{PyKeyError, PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyCapsule, PyDict, PyList};
use stillpoint::scenario::Scenario;
use stillpoint::statics::path;
use stillpoint::suggest::closest;

/// Branches of equilibria, along which a number of the scene moves.
#[pyclass(frozen, module = "stillpoint")]
pub(crate) struct Path {
    parameter: String,
    found: path::Path,
    /// Names of outputs and coordinates.
    outputs: Vec<String>,
    coordinates: Vec<String>,
}

/// One curve of equilibria: `branch.parameter`, `branch["camber"]`, `branch["arm.angle"]`.
#[pyclass(frozen, module = "stillpoint")]
pub(crate) struct Branch {
    of: Py<Path>,
    index: usize,
}

/// Follows the path of a scenario.
pub(crate) fn follow(py: Python<'_>, scenario: &Scenario) -> PyResult<Path> {
    let Some(settings) = &scenario.path else {
        let message =
            "which number moves is not said: give `parameter`, `start` and `end`, or `[statics.path]` in the scene";
        return Err(PyValueError::new_err(message));
    };
    let model = stillpoint::model::Model::build(&scenario.description);
    let model = model
        .map_err(|problems| PyValueError::new_err(problems.iter().map(ToString::to_string).collect::<String>()))?;
    let interrupt = Interrupt::new();
    let watched = &interrupt;
    let found =
        py.detach(move || path::follow(&scenario.description, &scenario.statics, settings, &mut |_| watched.go_on()));
    interrupt.check()?;
    let found = found.map_err(PyRuntimeError::new_err)?;
    let scene = stillpoint::simulate::scene(&model);
    let coordinates = crate::dynamics::coordinates(&model);
    let outputs = scene.outputs.iter().map(|one| one.name.clone()).collect();
    Ok(Path { parameter: settings.parameter.clone(), found, outputs, coordinates })
}

#[pymethods]
impl Path {
    /// The address of what moves.
    #[getter]
    fn parameter(&self) -> &str {
        &self.parameter
    }

    /// Branches in the order they were found.
    #[getter]
    fn branches(slf: &Bound<'_, Self>) -> Vec<Branch> {
        (0..slf.get().found.branches.len()).map(|index| Branch { of: slf.clone().unbind(), index }).collect()
    }

    /// Whether every branch was followed to an end of the range, or into itself.
    #[getter]
    fn complete(&self) -> bool {
        self.found.complete
    }

    /// What a person should know.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.found.notes.clone()
    }

    fn __repr__(&self) -> String {
        let points: usize = self.found.branches.iter().map(|branch| branch.points.len()).sum();
        format!("<Path of `{}`: {points} equilibria on {} branches>", self.parameter, self.found.branches.len())
    }
}

impl Branch {
    fn branch(&self) -> &path::PathBranch {
        &self.of.get().found.branches[self.index]
    }

    fn each<'py>(&self, py: Python<'py>, of: impl Fn(&path::PathPoint) -> f64) -> PyResult<Bound<'py, PyArray1<f64>>> {
        frozen(py, &self.branch().points.iter().map(of).collect::<Vec<f64>>())
    }
}

#[pymethods]
impl Branch {
    /// Values of what moves.
    #[getter]
    fn parameter<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.each(py, |point| point.parameter)
    }

    /// Hinge coordinates: a row a point.
    #[getter]
    fn q<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        let rows: Vec<Vec<f64>> = self.branch().points.iter().map(|point| point.position.clone()).collect();
        PyArray2::from_vec2(py, &rows).unwrap_or_else(|_| PyArray2::zeros(py, [0, 0], false))
    }

    /// Potential energy (J).
    #[getter]
    fn potential<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyArray1<f64>>> {
        self.each(py, |point| point.potential)
    }

    /// `"stable"`, `"unstable"` or `"neutral"` of every point.
    #[getter]
    fn verdicts(&self) -> Vec<&'static str> {
        self.branch().points.iter().map(|point| point.verdict.name()).collect()
    }

    /// What happens on the way: dictionaries with `point`, `kind`, `parameter`, `carriers`.
    #[getter]
    fn events<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let all = PyList::empty(py);
        for (index, point) in self.branch().points.iter().enumerate() {
            let Some(event) = &point.event else { continue };
            let one = PyDict::new(py);
            one.set_item("point", index)?;
            one.set_item("kind", event.kind.name())?;
            one.set_item("parameter", point.parameter)?;
            one.set_item("carriers", &event.carriers)?;
            all.append(one)?;
        }
        Ok(all)
    }

    /// Branch and point that it leaves from.
    #[getter]
    fn parent(&self) -> Option<(usize, usize)> {
        self.branch().parent
    }

    /// An output or a coordinate along the branch.
    fn __getitem__<'py>(&self, py: Python<'py>, name: &str) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let of = self.of.get();
        let place = |list: &[String]| list.iter().position(|one| one == name);
        if let Some(at) = place(&of.outputs) {
            return self.each(py, |point| point.outputs[at]);
        }
        if let Some(at) = place(&of.coordinates) {
            return self.each(py, |point| point.position[at]);
        }
        let known = of.outputs.iter().chain(&of.coordinates).map(String::as_str);
        let near = closest(name, known).map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
        Err(PyKeyError::new_err(format!("no output or coordinate is called `{name}`{near}")))
    }

    fn __len__(&self) -> usize {
        self.branch().points.len()
    }

    /// Names of outputs and coordinates.
    fn keys(&self) -> Vec<String> {
        let of = self.of.get();
        of.outputs.iter().chain(&of.coordinates).cloned().collect()
    }

    /// What moves, outputs, coordinates, potential energy and verdicts as a table, for programs that speak Arrow.
    #[pyo3(signature = (requested_schema = None))]
    fn __arrow_c_stream__<'py>(
        &self,
        py: Python<'py>,
        requested_schema: Option<&Bound<'py, PyAny>>,
    ) -> PyResult<Bound<'py, PyCapsule>> {
        let _ = requested_schema;
        let of = self.of.get();
        let mut columns = vec![(of.parameter.clone(), self.parameter(py)?.into_any())];
        for name in self.keys() {
            if !columns.iter().any(|(other, _)| *other == name) {
                let numbers = self.__getitem__(py, &name)?.into_any();
                columns.push((name, numbers));
            }
        }
        columns.push(("potential".to_owned(), self.potential(py)?.into_any()));
        columns.push(("verdict".to_owned(), PyList::new(py, self.verdicts())?.into_any()));
        arrow_stream(py, columns)
    }

    fn __repr__(&self) -> String {
        format!("<Branch {}: {} equilibria>", self.index, self.branch().points.len())
    }
}
