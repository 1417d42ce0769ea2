//! The equations of motion at any state.

use crate::scene::{Scene, with_turns};
use faer::Mat;
use numpy::{AllowTypeChange, PyArray1, PyArray2, PyArrayLike1, PyArrayMethods, PyUntypedArray};
use pyo3::exceptions::{PyArithmeticError, PyKeyError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use stillpoint::dynamics::System;
use stillpoint::model::{Body, Model};
use stillpoint::suggest::closest;

/// Anything that numpy takes as a list of numbers.
type Numbers<'a, 'py> = &'a Bound<'py, PyAny>;

/// Two matrices, as numpy has them.
type Pair<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>);

/// Accelerations, forces and their derivatives of the smooth scene: gravity, springs, dampers, motors, loads, loops and drives;
/// stops are open and dry friction is left out. Time is 0.
#[pyclass(frozen, module = "stillpoint")]
pub(crate) struct Dynamics {
    scene: Py<Scene>,
    model: Arc<Model>,
    solver: Mutex<Solver>,
}

/// The system, and room for one answer per velocity.
struct Solver {
    system: System,
    answer: Vec<f64>,
}

/// Letters of a value that are shown.
const SHOWN: usize = 60;

/// The shape of what numpy takes for an array of several dimensions.
fn shape(given: &Bound<'_, PyAny>) -> Option<String> {
    let shape = given.py().import("numpy").and_then(|numpy| numpy.call_method1("shape", (given,))).ok()?;
    (shape.len().ok()? > 1).then(|| shape.to_string())
}

/// What was given in the place of something else: the value, shortened, and its type.
pub(crate) fn shown(given: &Bound<'_, PyAny>) -> String {
    let value = given.repr().map_or_else(|_| "something".to_owned(), |repr| repr.to_string());
    let value = match value.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{} …", &value[..end]),
        None => value,
    };
    let of_type = given.get_type().name().map_or_else(|_| "unknown".to_owned(), |name| name.to_string());
    format!("{value} (type `{of_type}`)")
}

/// The numbers of an array of one dimension: the usual case, which asks numpy for nothing. What is derived from an array may mean
/// something else by its numbers.
fn plain(given: Numbers<'_, '_>) -> Option<Vec<f64>> {
    let array = given.cast::<PyArray1<f64>>().ok()?;
    if !given.get_type().is(given.py().get_type::<PyUntypedArray>()) {
        return None;
    }
    // A view of every second number has to be gathered.
    Some(array.to_vec().unwrap_or_else(|_| array.to_owned_array().to_vec()))
}

/// One list of numbers, whatever numpy takes for that.
pub(crate) fn numbers(name: &str, given: &Bound<'_, PyAny>, expected: &str) -> PyResult<Vec<f64>> {
    if let Some(numbers) = plain(given) {
        return Ok(numbers);
    }
    // A cast would show what is masked.
    if given.hasattr("mask")? && given.py().import("numpy.ma")?.call_method1("is_masked", (given,))?.is_truthy()? {
        let message = format!("{name} is {}, expected: {expected}, none masked", shown(given));
        return Err(PyValueError::new_err(message));
    }
    // A cast would lose what is imaginary.
    if given.py().import("numpy")?.call_method1("iscomplexobj", (given,))?.is_truthy()? {
        return Err(PyTypeError::new_err(format!("{name} is {}, expected: {expected}, none complex", shown(given))));
    }
    match given.extract::<PyArrayLike1<'_, f64, AllowTypeChange>>() {
        Ok(array) => Ok(array.as_array().iter().copied().collect()),
        Err(_) => Err(match shape(given) {
            Some(shape) => PyValueError::new_err(format!("{name} has the shape {shape}, expected: {expected}")),
            None => PyTypeError::new_err(format!("{name} is {}, expected: {expected}", shown(given))),
        }),
    }
}

/// The numbers of an argument: so many, and all of them finite.
fn list(name: &str, given: Numbers<'_, '_>, count: usize) -> PyResult<Vec<f64>> {
    // What errors say is written for them alone.
    let numbers = match plain(given) {
        Some(numbers) => numbers,
        None => numbers(&format!("`{name}`"), given, &format!("a list of {count} numbers"))?,
    };
    if numbers.len() != count {
        return Err(PyValueError::new_err(format!("`{name}` has {} numbers, the scene {count}", numbers.len())));
    }
    match numbers.iter().position(|number| !number.is_finite()) {
        Some(at) => Err(PyValueError::new_err(format!("`{name}[{at}]` is {}, allowed: finite numbers", numbers[at]))),
        None => Ok(numbers),
    }
}

pub(crate) fn matrix<'py>(py: Python<'py>, of: &Mat<f64>) -> Bound<'py, PyArray2<f64>> {
    let rows: Vec<Vec<f64>> = (0..of.nrows()).map(|i| (0..of.ncols()).map(|j| of[(i, j)]).collect()).collect();
    match rows.is_empty() || of.ncols() == 0 {
        true => PyArray2::zeros(py, [of.nrows(), of.ncols()], false),
        false => PyArray2::from_vec2(py, &rows).unwrap_or_else(|_| PyArray2::zeros(py, [0, 0], false)),
    }
}

/// Names of the position coordinates, in the order of `q`.
pub(crate) fn coordinates(model: &Arc<Model>) -> Vec<String> {
    let scene = stillpoint::simulate::scene(model);
    scene.positions.iter().map(|channel| format!("{}.{}", channel.body, channel.name)).collect()
}

/// Names of the velocity coordinates, in the order of `v`.
pub(crate) fn velocities(model: &Arc<Model>) -> Vec<String> {
    let scene = stillpoint::simulate::scene(model);
    scene.velocities.iter().map(|channel| format!("{}.{}", channel.body, channel.name)).collect()
}

/// A matrix of finite numbers alone.
fn finite<'py>(py: Python<'py>, name: &str, of: &Mat<f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
    match of.col_iter().all(|column| column.iter().all(|x| x.is_finite())) {
        true => Ok(matrix(py, of)),
        false => Err(PyArithmeticError::new_err(format!("{name} is not finite at this `q`"))),
    }
}

fn fault(error: stillpoint::dynamics::Fault) -> PyErr {
    PyArithmeticError::new_err(error.to_string())
}

/// Where a point is on its body (m).
fn place(at: &Bound<'_, PyAny>) -> PyResult<[f64; 3]> {
    const NAME: &str = "the place in `point`";
    const THREE: &str = "[x, y, z] in the axes of the body";
    let place = <[f64; 3]>::try_from(numbers(NAME, at, THREE)?)
        .map_err(|other| PyValueError::new_err(format!("{NAME} has {} numbers, expected: {THREE}", other.len())))?;
    match place.iter().position(|number| !number.is_finite()) {
        Some(i) => Err(PyValueError::new_err(format!("{NAME} is {} at [{i}], allowed: finite numbers", place[i]))),
        None => Ok(place),
    }
}

impl Dynamics {
    pub(crate) fn new(scene: Py<Scene>, model: &Arc<Model>) -> Self {
        let solver = Solver { system: System::new(model), answer: vec![0.0; model.velocity_count()] };
        Self { scene, model: Arc::clone(model), solver: Mutex::new(solver) }
    }

    fn solver(&self) -> MutexGuard<'_, Solver> {
        self.solver.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn positions(&self, q: Numbers<'_, '_>) -> PyResult<Vec<f64>> {
        let q = list("q", q, self.model.position_count())?;
        with_turns(&self.model, &q)?;
        Ok(q)
    }

    fn velocities_of(&self, name: &str, v: Numbers<'_, '_>) -> PyResult<Vec<f64>> {
        list(name, v, self.model.velocity_count())
    }

    /// A point by `"body.marker"`, `"body"` or `("body", [x, y, z])`: its link, and where it is there.
    fn point(&self, point: &Bound<'_, PyAny>) -> PyResult<(usize, [f64; 3])> {
        let (name, at) = match point.extract::<String>() {
            Ok(name) => (name, None),
            Err(_) => {
                let (name, at) = point.extract::<(String, Bound<'_, PyAny>)>().map_err(|_| {
                    let form = "expected: \"body.marker\", \"body\" or (\"body\", [x, y, z])";
                    PyTypeError::new_err(format!("`point` is {}, {form}", shown(point)))
                })?;
                (name, Some(place(&at)?))
            }
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

    /// Names of the position coordinates, in the order of `q`.
    #[getter]
    fn coordinates(&self) -> Vec<String> {
        coordinates(&self.model)
    }

    /// Names of the velocity coordinates, in the order of `v`.
    #[getter]
    fn velocities(&self) -> Vec<String> {
        velocities(&self.model)
    }

    /// q̈(q, v).
    fn acceleration<'py>(
        &self,
        py: Python<'py>,
        q: Numbers<'_, 'py>,
        v: Numbers<'_, 'py>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (q, v) = (&*self.positions(q)?, &*self.velocities_of("v", v)?);
        let Solver { system, answer } = &mut *self.solver();
        system.at(0.0, q, v).accelerations(answer).map_err(fault)?;
        Ok(PyArray1::from_slice(py, answer))
    }

    /// The generalized forces that are needed beyond those of the scene for these accelerations. What loops, gears and drives push with
    /// is no part of the scene's forces here.
    fn inverse<'py>(
        &self,
        py: Python<'py>,
        q: Numbers<'_, 'py>,
        v: Numbers<'_, 'py>,
        a: Numbers<'_, 'py>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let (q, v, a) = (&*self.positions(q)?, &*self.velocities_of("v", v)?, &*self.velocities_of("a", a)?);
        let Solver { system, answer } = &mut *self.solver();
        let none = vec![0.0; system.constraint_rank()];
        system.set_multipliers(&none);
        system.at(0.0, q, v).residual(a, answer).map_err(fault)?;
        Ok(PyArray1::from_slice(py, answer))
    }

    /// M(q).
    fn mass<'py>(&self, py: Python<'py>, q: Numbers<'_, 'py>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let q = &*self.positions(q)?;
        let v = vec![0.0; self.model.velocity_count()];
        let system = &mut self.solver().system;
        let linear = system.at(0.0, q, &v).linearize(&v).map_err(fault)?;
        finite(py, "the mass matrix", &linear.mass)
    }

    /// (∂q̈/∂q, ∂q̈/∂v) in velocity coordinates: of a ball's quaternion along a small turn about its own axes.
    fn derivatives<'py>(&self, py: Python<'py>, q: Numbers<'_, 'py>, v: Numbers<'_, 'py>) -> PyResult<Pair<'py>> {
        let (q, v) = (&*self.positions(q)?, &*self.velocities_of("v", v)?);
        let (by_position, by_velocity) = self.solver().system.at(0.0, q, v).acceleration_jacobians().map_err(fault)?;
        Ok((finite(py, "∂q̈/∂q", &by_position)?, finite(py, "∂q̈/∂v", &by_velocity)?))
    }

    /// The Jacobian of a point, 3 × nv: its velocity in inertial axes is J v. With `angular` 6 × nv, the body's angular velocity
    /// below.
    #[pyo3(signature = (point, q, angular = false))]
    fn jacobian<'py>(
        &self,
        py: Python<'py>,
        point: &Bound<'py, PyAny>,
        q: Numbers<'_, 'py>,
        angular: bool,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let q = &*self.positions(q)?;
        let (link, at) = self.point(point)?;
        let n = self.model.velocity_count();
        let mut columns = Mat::zeros(if angular { 6 } else { 3 }, n);
        let mut unit = vec![0.0; n];
        let system = &mut self.solver().system;
        // The coordinates on the way to the ground: no other moves the point.
        let mut way = Vec::new();
        let mut on_way = link;
        while on_way != 0 {
            let moving = &self.model.links[on_way];
            way.extend(moving.velocity..moving.velocity + moving.joint.counts().1);
            on_way = moving.parent;
        }
        for j in way {
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
        finite(py, "the Jacobian", &columns)
    }

    /// The dynamics of the scene that they are of.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (Py<Scene>,))> {
        Ok((py.get_type::<Scene>().getattr("dynamics")?, (self.scene.clone_ref(py),)))
    }

    fn __repr__(&self) -> String {
        format!("<Dynamics of `{}`: nq {}, nv {}>", self.model.title, self.nq(), self.nv())
    }
}
