//! The equations about an equilibrium.

use crate::dynamics::{matrix, numbers, shown};
use numpy::ndarray::Array3;
use numpy::{Complex64, IntoPyArray, PyArray1, PyArray2, PyArray3, PyReadonlyArray2};
use pyo3::exceptions::{PyArithmeticError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
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

/// What pickle keeps: `A`, `B`, `C`, `D`; states, inputs and outputs; dependent coordinates, outputs that were left out, inputs that nothing
/// feels, and notes.
type Whole<'py> = ([Bound<'py, PyArray2<f64>>; 4], [Kept; 3], [Vec<String>; 4]);

/// `A` and `B` from step to step.
type Steps<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

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

    /// Outputs that were not asked for by name and whose variation is not known.
    #[getter]
    fn left_out(&self) -> Vec<String> {
        self.space.left_out.clone()
    }

    /// What there is to say besides.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.space.notes.clone()
    }

    /// The SI unit of every state, input and output.
    #[getter]
    fn units<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let units = PyDict::new(py);
        let StateSpace { states, inputs, outputs, .. } = &self.space;
        for signal in states.iter().chain(inputs).chain(outputs) {
            units.set_item(&signal.name, &signal.unit)?;
        }
        Ok(units)
    }

    /// Eigenvalues of `A` (1/s), slowest first.
    #[getter]
    fn eigenvalues<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<Complex64>> {
        let values = self.space.eigenvalues().into_iter().map(|[re, im]| Complex64::new(re, im));
        PyArray1::from_vec(py, values.collect())
    }

    /// The frequency response `C (iω − A)⁻¹ B + D` at frequencies (Hz): an array of frequencies × outputs × inputs, amplitude and phase
    /// of each output by each input. With `displacement` the inputs that are drives count by how far they move, in place of their
    /// acceleration: transmissibilities. At a frequency with which the equations swing freely it is the limit: what nothing holds back is
    /// infinite there, along the axis that its phase tends to, and nothing is NaN.
    #[pyo3(signature = (frequencies, *, displacement = false))]
    fn response<'py>(
        &self,
        py: Python<'py>,
        frequencies: &Bound<'py, PyAny>,
        displacement: bool,
    ) -> PyResult<Bound<'py, PyArray3<Complex64>>> {
        let expected = "a frequency in Hz, or a list of them";
        let frequencies = match frequencies.len() {
            Ok(_) => numbers("`frequencies`", frequencies, expected)?,
            Err(_) => vec![frequencies.extract::<f64>().map_err(|_| {
                PyTypeError::new_err(format!("`frequencies` is {}, expected: {expected}", shown(frequencies)))
            })?],
        };
        if let Some(wrong) = frequencies.iter().find(|hz| !(**hz >= 0.0 && hz.is_finite())) {
            return Err(PyValueError::new_err(format!("a frequency is {wrong} Hz, allowed: finite and at least 0")));
        }
        let space = &self.space;
        let (rows, columns) = (space.outputs.len(), space.inputs.len());
        let mut all = Array3::zeros((frequencies.len(), rows, columns));
        for (k, hz) in frequencies.iter().enumerate() {
            let omega = std::f64::consts::TAU * hz;
            let answer = if displacement { space.transmissibility(omega) } else { space.response(omega) };
            for (i, j) in (0..rows).flat_map(|i| (0..columns).map(move |j| (i, j))) {
                all[[k, i, j]] = Complex64::new(answer[(i, j)].re, answer[(i, j)].im);
            }
        }
        Ok(all.into_pyarray(py))
    }

    /// The equations from step to step (s), inputs held constant over each: `(A, B)`.
    fn discretize<'py>(&self, py: Python<'py>, step: f64) -> PyResult<Steps<'py>> {
        if !(step > 0.0 && step.is_finite()) {
            return Err(PyValueError::new_err(format!("`step` is {step}, allowed: above 0")));
        }
        let (a, b) = self.space.hold(step).map_err(|why| PyArithmeticError::new_err(why.to_string()))?;
        Ok((matrix(py, &a), matrix(py, &b)))
    }

    /// For notebooks.
    fn _repr_html_<'py>(slf: &Bound<'py, Self>) -> PyResult<Bound<'py, PyAny>> {
        slf.py().import("stillpoint._html")?.call_method1("linear", (slf,))
    }

    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, Whole<'py>)> {
        let StateSpace { a, b, c, d, states, inputs, outputs, dependent, left_out, idle, notes } = &self.space;
        let again = py.get_type::<Self>().getattr("_again")?;
        let matrices = [a, b, c, d].map(|of| matrix(py, of));
        let others = [dependent, left_out, idle, notes].map(Clone::clone);
        Ok((again, (matrices, [states, inputs, outputs].map(|of| kept(of)), others)))
    }

    #[staticmethod]
    fn _again(matrices: [PyReadonlyArray2<'_, f64>; 4], named: [Kept; 3], others: [Vec<String>; 4]) -> Self {
        let [a, b, c, d] = matrices.map(|array| {
            let of = array.as_array();
            Mat::from_fn(of.nrows(), of.ncols(), |i, j| of[[i, j]])
        });
        let ([states, inputs, outputs], [dependent, left_out, idle, notes]) = (named.map(signals), others);
        Self { space: StateSpace { a, b, c, d, states, inputs, outputs, dependent, left_out, idle, notes } }
    }

    fn __repr__(&self) -> String {
        let [x, u, y] = [&self.space.states, &self.space.inputs, &self.space.outputs].map(Vec::len);
        format!("<Linear: {x} states, {u} inputs, {y} outputs>")
    }
}
