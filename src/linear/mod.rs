//! The equations of a scene about one place, linear: `ẋ = A x + B u`, `y = C x + D u`.
//!
//! The free motions of hinge coordinates are `δq = Z s + Y d`: `s` are independent coordinates that rows of loops, drives,
//! gears and what is held leave, `d` moves targets of drives that are inputs. With mass, damping and stiffness of the
//! residual ([`Linearization`]) and inputs that push with `F u`,
//!
//! ```text
//! (1)  Zᵀ M (Z s̈ + Y d̈) + Zᵀ D (Z ṡ + Y ḋ) + Zᵀ K (Z s + Y d) = Zᵀ F u
//! (2)  x = (s, d, ṡ, ḋ),   the inputs being u and d̈
//! (3)  a ball that turns with ω:  φ̇ = δω − ω × φ
//! ```
//!
//! `K`, `D`, `M` are the transfer equations differentiated, `C` and `D` the outputs by the chain rule
//! ([`Outputs::vary`](crate::output::Outputs::vary)) along `δq`, `δq̇`, and `δq̈` by (1). What hinges, rows and sections pass on, energies and
//! powers follow by extrapolated differences along the same directions (`beside`).

mod basis;
mod beside;
mod discrete;
mod inputs;
mod kinks;
mod response;
mod told;

pub use discrete::{Overflow, hold};
pub use inputs::{Input, Unfit};
pub use told::{LeftOut, Why};

use crate::constraint::Constraints;
use crate::dynamics::{Fault, Linearization, System};
use crate::force::Act;
use crate::model::{Model, StopLaw};
use crate::motion::variation::{Direction, LinkVariation, outward};
use basis::Basis;
use faer::linalg::solvers::Solve;
pub use faer::{Mat, c64};
use std::sync::Arc;

/// A place about which a scene is linearized.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Time (s).
    pub time: f64,
    /// Hinge coordinates.
    pub position: Vec<f64>,
    /// Hinge velocities.
    pub velocity: Vec<f64>,
    /// Of an equilibrium the multipliers of the independent rows; `None` for a state with its accelerations.
    pub multipliers: Option<Vec<f64>>,
    /// Velocity coordinates that are held: locks, and rigid stops that bear.
    pub held: Vec<usize>,
    /// Indices of compliant stops that push.
    pub pressed: Vec<usize>,
}

/// A state, an input or an output.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Signal {
    /// Name.
    pub name: String,
    /// SI unit.
    pub unit: String,
}

/// The equations.
#[derive(Debug, Clone)]
pub struct StateSpace {
    /// States × states.
    pub a: Mat<f64>,
    /// States × inputs.
    pub b: Mat<f64>,
    /// Outputs × states.
    pub c: Mat<f64>,
    /// Outputs × inputs.
    pub d: Mat<f64>,
    /// Of the rows of `a`.
    pub states: Vec<Signal>,
    /// Of the columns of `b`.
    pub inputs: Vec<Signal>,
    /// Of the rows of `c`.
    pub outputs: Vec<Signal>,
    /// Coordinates that follow from the states.
    pub dependent: Vec<String>,
    /// Outputs that were not asked for by name and whose variation is not known.
    pub left_out: Vec<String>,
    /// Inputs that push no motion at this place: their columns of `b` are zero.
    pub idle: Vec<String>,
    /// What a person should know of the place.
    pub notes: Vec<String>,
}

/// The most degrees of freedom of a tree whose equations are made: they are dense.
const MOST: usize = 1000;

/// Why there are no equations.
#[derive(Debug, thiserror::Error)]
pub enum LinearError {
    /// The place cannot be evaluated.
    #[error(transparent)]
    Fault(#[from] Fault),
    /// Loops, drives or gears in motion.
    #[error(
        "the scene moves at this place ({hinge}), and has loops, drives or gears: it is linearized at rest only; what drives keep turning counts as motion"
    )]
    Moves {
        /// A hinge that moves.
        hinge: String,
    },
    /// An output whose variation is not known.
    #[error("the output `{}` has no row in linear equations: {}", .0.name, .0.why)]
    Output(LeftOut),
    /// Dense matrices of this size are of no use.
    #[error("the tree of the scene has {0} degrees of freedom: its equations are dense, and made for {MOST} at most")]
    Large(usize),
    /// Motions without inertia.
    #[error("a motion of the scene has no inertia at this place")]
    Massless,
}

/// The equations about a place. `outputs` are names; `None` for all whose variation is known.
///
/// # Errors
/// See [`LinearError`].
pub fn linearize(
    model: &Arc<Model>,
    place: &Place,
    inputs: &[Input],
    outputs: Option<&[String]>,
) -> Result<StateSpace, LinearError> {
    let n = model.velocity_count();
    if n > MOST {
        return Err(LinearError::Large(n));
    }
    let tied = model.is_constrained() || !place.held.is_empty();
    if let Some(moving) = place.velocity.iter().position(|v| *v != 0.0).filter(|_| tied) {
        return Err(LinearError::Moves { hinge: model.label(moving) });
    }
    let mut system = System::new(model);
    let (q, v) = (&place.position[..], &place.velocity[..]);
    let mut a = vec![0.0; n];
    system.at(place.time, q, v).accelerations(&mut a)?;
    if let Some(multipliers) = &place.multipliers {
        a.fill(0.0);
        system.set_multipliers(multipliers);
    }
    let multipliers = system.constraints().map_or_else(Vec::new, Constraints::independent_multipliers);
    let mut at = system.at(place.time, q, v);
    let rows = at.constraint_matrix();
    let mut linear = at.linearize(&a)?;
    press(model, place, &mut linear);
    let basis = Basis::new(model, &rows, &place.held, inputs);
    let idle = inputs.iter().filter(|input| pushes_nothing(model, place, &basis, input));
    let idle: Vec<String> = idle.map(|input| input.name().to_owned()).collect();
    let mut motion = StateMatrices::new(model, place, &linear, &basis, inputs)?;
    if place.multipliers.is_none() && tied {
        // Rows that turn while the scene accelerates: by the Jacobian of the accelerations that they allow.
        let (by_position, _) = at.acceleration_jacobians()?;
        motion.accelerating(&basis, &by_position);
    }
    system.set_multipliers(&multipliers);
    let about = (&basis, &linear, &rows);
    let told = told::tell(&mut system, (place, &a), about, (&motion, &multipliers), inputs, outputs)?;
    let mut notes = told::notes(&told.left_out);
    let felt = kinks::kinks(&mut system, place, &a, &basis, &linear)?;
    if !felt.is_empty() {
        notes.push(format!(
            "forces have a kink here, which {} feel: a spring, rope, damper or motor is at a switch; the equations are those of one side",
            listed(&felt)
        ));
    }
    let signal = |name: String, unit: &str| Signal { name, unit: unit.to_owned() };
    let (positions, rates) = (basis.states(model), basis.rates(model));
    Ok(StateSpace {
        a: motion.a,
        b: motion.b,
        c: told.c,
        d: told.d,
        states: positions.into_iter().chain(rates).collect(),
        inputs: inputs.iter().map(|input| signal(input.name().to_owned(), input.unit(model))).collect(),
        outputs: told.outputs,
        dependent: basis.dependent.iter().map(|at| basis::label(model, *at)).collect(),
        left_out: told.left_out.into_iter().map(|one| one.name).collect(),
        idle,
        notes,
    })
}

/// Names that are told, the others counted.
fn listed(names: &[String]) -> String {
    const MOST: usize = 4;
    let told = names.iter().take(MOST).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
    match names.len().saturating_sub(MOST) {
        0 => told,
        more => format!("{told} and {more} more"),
    }
}

/// What a motion feels of a unit input, in parts of what it could feel of it: below, it is round-off.
const FELT: f64 = 1e-12;

/// Whether an input does no work along any motion.
fn pushes_nothing(model: &Model, place: &Place, basis: &Basis, input: &Input) -> bool {
    if input.drive().is_some() {
        return false;
    }
    let push = push(model, place, input);
    (0..basis.independent.len()).all(|k| {
        let work = |i: usize| basis.columns[(i, k)] * push[i];
        let (sum, size) = (0..push.len()).map(work).fold((0.0, 0.0), |(sum, size), x| (sum + x, size + x.abs()));
        sum.abs() <= FELT * size
    })
}

/// Adds the stiffness and damping of compliant stops that push.
fn press(model: &Model, place: &Place, linear: &mut Linearization) {
    for index in &place.pressed {
        let stop = &model.stops[*index];
        if let StopLaw::Compliant { stiffness, damping } = stop.law {
            linear.stiffness[(stop.velocity, stop.velocity)] += stiffness;
            linear.damping[(stop.velocity, stop.velocity)] += damping;
        }
    }
}

/// (1) and (2), solved for the accelerations.
struct StateMatrices {
    a: Mat<f64>,
    b: Mat<f64>,
    /// Accelerations of all hinge coordinates: by each state, then by each input.
    answers: Mat<f64>,
}

impl StateMatrices {
    fn new(
        model: &Model,
        place: &Place,
        linear: &Linearization,
        basis: &Basis,
        inputs: &[Input],
    ) -> Result<Self, LinearError> {
        let (m, count) = (basis.independent.len(), basis.columns.ncols());
        let (z, all) = (basis.columns.subcols(0, m), &basis.columns);
        let mass = z.transpose() * &linear.mass * all;
        let lu = mass.subcols(0, m).to_owned().partial_piv_lu();
        let damping = lu.solve(z.transpose() * &linear.damping * all);
        let stiffness = lu.solve(z.transpose() * &linear.stiffness * all);
        let driven = lu.solve(mass.subcols(m, count - m).to_owned());
        let mut a = Mat::zeros(2 * count, 2 * count);
        let mut b = Mat::zeros(2 * count, inputs.len());
        for i in 0..count {
            a[(i, count + i)] = 1.0;
            for j in 0..count {
                if i < m {
                    a[(count + i, j)] = -stiffness[(i, j)];
                    a[(count + i, count + j)] = -damping[(i, j)];
                }
            }
        }
        basis.turn(model, place, &mut a);
        let mut target = m;
        for (column, input) in inputs.iter().enumerate() {
            match input {
                Input::Drive { .. } => {
                    (0..m).for_each(|i| b[(count + i, column)] = -driven[(i, target - m)]);
                    b[(count + target, column)] = 1.0;
                    target += 1;
                }
                Input::Coordinate { .. } | Input::Load { .. } => {
                    let push = push(model, place, input);
                    let felt = Mat::from_fn(push.len(), 1, |i, _| push[i]);
                    let answer = lu.solve(z.transpose() * felt);
                    (0..m).for_each(|i| b[(count + i, column)] = answer[(i, 0)]);
                }
            }
        }
        let finite =
            |matrix: &Mat<f64>| (0..matrix.ncols()).all(|j| (0..matrix.nrows()).all(|i| matrix[(i, j)].is_finite()));
        if !(finite(&a) && finite(&b)) {
            return Err(LinearError::Massless);
        }
        let answers = Mat::from_fn(all.nrows(), 2 * count + inputs.len(), |i, j| {
            let of = |k: usize| if j < 2 * count { a[(count + k, j)] } else { b[(count + k, j - 2 * count)] };
            (0..count).map(|k| all[(i, k)] * of(k)).sum()
        });
        Ok(Self { a, b, answers })
    }

    /// The answers to positions by the Jacobian of the accelerations.
    fn accelerating(&mut self, basis: &Basis, by_position: &Mat<f64>) {
        let count = basis.columns.ncols();
        let answer = by_position * &basis.columns;
        for j in 0..count {
            (0..answer.nrows()).for_each(|i| self.answers[(i, j)] = answer[(i, j)]);
            for (k, at) in basis.independent.iter().enumerate() {
                self.a[(count + k, j)] = answer[(*at, j)];
            }
        }
    }
}

/// What one of an input pushes each velocity coordinate with: by the power of each unit velocity.
fn push(model: &Model, place: &Place, input: &Input) -> Vec<f64> {
    let n = model.velocity_count();
    let mut push = vec![0.0; n];
    match *input {
        Input::Coordinate { velocity, .. } => push[velocity] = 1.0,
        Input::Drive { .. } => {}
        Input::Load { element, component, .. } => {
            let mut motion = crate::motion::Motion::new(model);
            motion.update(model, &place.position, &vec![0.0; n]);
            let end = model.forces[element].law.ends()[0];
            let link = &motion.links[end.link];
            let axes = input.load_axes(model, link);
            let (axis, arm) = (axes.column(component % 3).into_owned(), link.turn * end.point);
            let rest = vec![0.0; n];
            let none = vec![crate::spatial::link::LinkAcceleration::default(); model.links.len()];
            let (mut unit, mut links) = (rest.clone(), vec![LinkVariation::default(); model.links.len()]);
            for j in 0..n {
                unit[j] = 1.0;
                let by = Direction { velocity: &unit, ..Direction::default() };
                outward(model, &motion, &none, &rest, &by, 1..model.links.len(), &mut links);
                unit[j] = 0.0;
                let moved = &links[end.link];
                push[j] = match component {
                    0..3 => axis.dot(&(moved.velocity + moved.angular_velocity.cross(&arm))),
                    _ => axis.dot(&moved.angular_velocity),
                };
            }
        }
    }
    push
}

impl StateSpace {
    /// Eigenvalues of `A`, real and imaginary parts (1/s): by frequency, then by real part.
    pub fn eigenvalues(&self) -> Vec<[f64; 2]> {
        let values: Vec<c64> = self.a.eigenvalues().unwrap_or_default();
        let mut list: Vec<[f64; 2]> = values.iter().map(|x| [x.re, x.im]).collect();
        list.sort_by(|a, b| a[1].abs().total_cmp(&b[1].abs()).then(a[0].total_cmp(&b[0])).then(a[1].total_cmp(&b[1])));
        list
    }
}
