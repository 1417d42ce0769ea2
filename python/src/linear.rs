//! The equations about an equilibrium.

use crate::dynamics::matrix;
use numpy::PyArray2;
use pyo3::prelude::*;
use stillpoint::linear::{Signal, StateSpace};

/// `ẋ = A x + B u`, `y = C x + D u`.
#[pyclass(frozen, module = "stillpoint")]
pub(crate) struct Linear {
    space: StateSpace,
}

impl Linear {
    pub(crate) fn new(space: StateSpace) -> Self {
        Self { space }
    }
}

fn names(signals: &[Signal]) -> Vec<&str> {
    signals.iter().map(|signal| signal.name.as_str()).collect()
}

#[pymethods]
impl Linear {
    #[getter(A)]
    fn a<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        matrix(py, &self.space.a)
    }

    #[getter(B)]
    fn b<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        matrix(py, &self.space.b)
    }

    #[getter(C)]
    fn c<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        matrix(py, &self.space.c)
    }

    #[getter(D)]
    fn d<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray2<f64>> {
        matrix(py, &self.space.d)
    }

    /// Independent coordinates, then their rates.
    #[getter]
    fn states(&self) -> Vec<&str> {
        names(&self.space.states)
    }

    /// What pushes.
    #[getter]
    fn inputs(&self) -> Vec<&str> {
        names(&self.space.inputs)
    }

    /// What is observed.
    #[getter]
    fn outputs(&self) -> Vec<&str> {
        names(&self.space.outputs)
    }

    /// Coordinates that follow from the states.
    #[getter]
    fn dependent(&self) -> Vec<String> {
        self.space.dependent.clone()
    }

    fn __repr__(&self) -> String {
        let [x, u, y] = [&self.space.states, &self.space.inputs, &self.space.outputs].map(Vec::len);
        format!("<Linear: {x} states, {u} inputs, {y} outputs>")
    }
}
