//! The equations about an equilibrium.

use crate::dynamics::matrix;
use numpy::{PyArray2, PyReadonlyArray2};
use pyo3::prelude::*;
use stillpoint::linear::{Mat, Signal, StateSpace};

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

/// Names and units of signals, as pickle keeps them.
type Kept = Vec<(String, String)>;

/// What pickle keeps: `A`, `B`, `C`, `D`; states, inputs and outputs; dependent coordinates, and outputs that were left out.
type Whole<'py> = ([Bound<'py, PyArray2<f64>>; 4], [Kept; 3], [Vec<String>; 2]);

fn kept(signals: &[Signal]) -> Kept {
    signals.iter().map(|signal| (signal.name.clone(), signal.unit.clone())).collect()
}

fn signals(kept: Kept) -> Vec<Signal> {
    kept.into_iter().map(|(name, unit)| Signal { name, unit }).collect()
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

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Whole<'py>)> {
        let StateSpace { a, b, c, d, states, inputs, outputs, dependent, left_out } = &self.space;
        let again = py.get_type::<Self>().getattr("_again")?;
        let matrices = [a, b, c, d].map(|of| matrix(py, of));
        Ok((again, (matrices, [states, inputs, outputs].map(|of| kept(of)), [dependent.clone(), left_out.clone()])))
    }

    #[staticmethod]
    fn _again(matrices: [PyReadonlyArray2<'_, f64>; 4], named: [Kept; 3], others: [Vec<String>; 2]) -> Self {
        let [a, b, c, d] = matrices.map(|array| {
            let of = array.as_array();
            Mat::from_fn(of.nrows(), of.ncols(), |i, j| of[[i, j]])
        });
        let ([states, inputs, outputs], [dependent, left_out]) = (named.map(signals), others);
        Self { space: StateSpace { a, b, c, d, states, inputs, outputs, dependent, left_out } }
    }

    fn __repr__(&self) -> String {
        let [x, u, y] = [&self.space.states, &self.space.inputs, &self.space.outputs].map(Vec::len);
        format!("<Linear: {x} states, {u} inputs, {y} outputs>")
    }
}
