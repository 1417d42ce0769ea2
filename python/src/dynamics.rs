//! The equations of motion at any state.

use faer::Mat;
use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayLike1, PyArrayMethods};
use pyo3::exceptions::{PyArithmeticError, PyKeyError, PyValueError};
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use stillpoint::dynamics::System;
use stillpoint::model::{Body, Model};
use stillpoint::suggest::closest;

/// Anything that numpy takes as a list of numbers.
type Numbers<'py> = PyArrayLike1<'py, f64, AllowTypeChange>;

/// Accelerations, forces and their derivatives of the smooth scene: gravity, springs, dampers, motors, loads, loops and drives;
/// stops are open and dry friction is left out. Time is 0.
#[pyclass(frozen, module = "stillpoint")]
pub(crate) struct Dynamics {
    model: Arc<Model>,
    system: Mutex<System>,
}

/// What is wrong with a list of numbers.
fn check(name: &str, numbers: &[f64], count: usize) -> PyResult<()> {
    if numbers.len() != count {
        return Err(PyValueError::new_err(format!("`{name}` has {} numbers, the scene {count}", numbers.len())));
    }
    match numbers.iter().position(|number| !number.is_finite()) {
        Some(at) => Err(PyValueError::new_err(format!("`{name}[{at}]` is {}, allowed: finite numbers", numbers[at]))),
        None => Ok(()),
    }
}

fn matrix<'py>(py: Python<'py>, of: &Mat<f64>) -> Bound<'py, PyArray2<f64>> {
    let rows: Vec<Vec<f64>> = (0..of.nrows()).map(|i| (0..of.ncols()).map(|j| of[(i, j)]).collect()).collect();
    match rows.is_empty() {
        true => PyArray2::zeros(py, [0, 0], false),
        false => PyArray2::from_vec2(py, &rows).unwrap_or_else(|_| PyArray2::zeros(py, [0, 0], false)),
    }
}

fn fault(error: stillpoint::dynamics::Fault) -> PyErr {
    PyArithmeticError::new_err(error.to_string())
}

impl Dynamics {
    pub(crate) fn new(model: &Arc<Model>) -> Self {
        Self { model: Arc::clone(model), system: Mutex::new(System::new(model)) }
    }

    fn system(&self) -> MutexGuard<'_, System> {
        self.system.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn check(&self, q: &[f64], v: Option<&[f64]>, a: Option<&[f64]>) -> PyResult<()> {
        check("q", q, self.model.position_count())?;
        v.map_or(Ok(()), |v| check("v", v, self.model.velocity_count()))?;
        a.map_or(Ok(()), |a| check("a", a, self.model.velocity_count()))
    }

    /// A point by `"body.marker"`, `"body"` or `("body", [x, y, z])`: its link, and where it is there.
    fn point(&self, point: &Bound<'_, PyAny>) -> PyResult<(usize, [f64; 3])> {
        let (name, at) = match point.extract::<(String, [f64; 3])>() {
            Ok((name, at)) => (name, Some(at)),
            Err(_) => (point.extract::<String>()?, None),
        };
        let (body, marker) = match (at, self.model.body(&name), name.rsplit_once('.')) {
            (Some(at), body, _) => (body, Some(at)),
            (None, Some(body), _) => (Some(body), Some([0.0; 3])),
            (None, None, Some((body, marker))) => {
                let body = self.model.body(body);
                let markers = body.into_iter().flat_map(|body| &self.model.bodies[body].markers);
                (body, markers.into_iter().find(|(name, _)| name == marker).map(|(_, at)| (*at).into()))
            }
            _ => (None, None),
        };
        let (Some(body), Some(at)) = (body, marker) else {
            let of_body = |body: &Body| {
                let markers = body.markers.iter().map(|(marker, _)| format!("{}.{marker}", body.name));
                markers.chain([body.name.clone()]).collect::<Vec<_>>()
            };
            let known: Vec<String> = self.model.bodies.iter().flat_map(of_body).collect();
            let near = closest(&name, known.iter().map(String::as_str)).map(|near| format!("; did you mean `{near}`?"));
            return Err(PyKeyError::new_err(format!("no point is called `{name}`{}", near.unwrap_or_default())));
        };
        let body = &self.model.bodies[body];
        let on_link = body.link_from_body * nalgebra::Point3::from(at);
        Ok((body.link, on_link.coords.into()))
    }
}

#[pymethods]
impl Dynamics {
    /// Number of position coordinates.
    #[getter]
    fn nq(&self) -> usize {
        self.model.position_count()
    }

    /// Number of velocity coordinates.
    #[getter]
    fn nv(&self) -> usize {
        self.model.velocity_count()
    }

    /// q̈(q, v).
    fn acceleration<'py>(
        &self,
        py: Python<'py>,
        q: Numbers<'py>,
        v: Numbers<'py>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (q, v) = (q.as_slice()?, v.as_slice()?);
        self.check(q, Some(v), None)?;
        let a = PyArray1::zeros(py, self.model.velocity_count(), false);
        let mut out = a.readwrite();
        self.system().at(0.0, q, v).accelerations(out.as_slice_mut()?).map_err(fault)?;
        Ok(a)
    }

    /// The generalized forces that are needed beyond those of the scene for these accelerations.
    fn inverse<'py>(
        &self,
        py: Python<'py>,
        q: Numbers<'py>,
        v: Numbers<'py>,
        a: Numbers<'py>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (q, v, a) = (q.as_slice()?, v.as_slice()?, a.as_slice()?);
        self.check(q, Some(v), Some(a))?;
        let force = PyArray1::zeros(py, self.model.velocity_count(), false);
        let mut out = force.readwrite();
        let mut system = self.system();
        let none = vec![0.0; system.constraint_rank()];
        system.set_multipliers(&none);
        system.at(0.0, q, v).residual(a, out.as_slice_mut()?).map_err(fault)?;
        Ok(force)
    }

    /// M(q).
    fn mass<'py>(&self, py: Python<'py>, q: Numbers<'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let q = q.as_slice()?;
        self.check(q, None, None)?;
        let v = vec![0.0; self.model.velocity_count()];
        let mut system = self.system();
        let linear = system.at(0.0, q, &v).linearize(&v).map_err(fault)?;
        Ok(matrix(py, &linear.mass))
    }

    /// (∂q̈/∂q, ∂q̈/∂v) in velocity coordinates: of a ball's quaternion along a small turn about its own axes.
    fn derivatives<'py>(
        &self,
        py: Python<'py>,
        q: Numbers<'py>,
        v: Numbers<'py>,
    ) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>)> {
        let (q, v) = (q.as_slice()?, v.as_slice()?);
        self.check(q, Some(v), None)?;
        let (by_position, by_velocity) = self.system().at(0.0, q, v).acceleration_jacobians().map_err(fault)?;
        Ok((matrix(py, &by_position), matrix(py, &by_velocity)))
    }

    /// The Jacobian of a point, 3 × nv: its velocity in inertial axes is J v. With `angular` 6 × nv, the body's angular velocity
    /// below.
    #[pyo3(signature = (point, q, angular = false))]
    fn jacobian<'py>(
        &self,
        py: Python<'py>,
        point: &Bound<'py, PyAny>,
        q: Numbers<'py>,
        angular: bool,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let q = q.as_slice()?;
        self.check(q, None, None)?;
        let (link, at) = self.point(point)?;
        let n = self.model.velocity_count();
        let mut columns = Mat::zeros(if angular { 6 } else { 3 }, n);
        let mut unit = vec![0.0; n];
        let mut system = self.system();
        for j in 0..n {
            unit[j] = 1.0;
            let place = system.at(0.0, q, &unit);
            let moving = &place.motion().links[link];
            let arm = moving.turn * nalgebra::Vector3::from(at);
            let linear = moving.velocity + moving.angular_velocity.cross(&arm);
            for i in 0..3 {
                columns[(i, j)] = linear[i];
                if angular {
                    columns[(3 + i, j)] = moving.angular_velocity[i];
                }
            }
            unit[j] = 0.0;
        }
        Ok(matrix(py, &columns))
    }

    fn __repr__(&self) -> String {
        format!("<Dynamics of `{}`: nq {}, nv {}>", self.model.title, self.nq(), self.nv())
    }
}
