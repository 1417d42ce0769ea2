//! An independent answer, slow and obvious: Newton's and Euler's equations of every named body in absolute coordinates,
//! the hinges as constraints, one dense linear system.
//!
//! Nothing compiled is used, only the [`Description`]: no links, no sweeps, no shared law of force. Unknown are, for
//! every body (welded ones too), the acceleration of its centre of mass, its angular acceleration, and the force and
//! the moment that its hinge passes to it at its root marker. Twelve equations per body:
//!
//! ```text
//! Newton        m a − f + Σ f_child                                          = m g + forces applied
//! Euler         J ω̇ − m − (R − C)×f + Σ [m_child + (R_child − C)×f_child]    = −ω×Jω + moments applied
//! forbidden     second derivative of a geometric condition                   = 0
//! free          direction · f (or m) + armature · q̈                          = hinge force
//! ```

pub(crate) mod force;
mod hinge;
pub(crate) mod hinge_force;
pub(crate) mod place;

use faer::Mat;
use faer::linalg::solvers::Solve;
use hinge::Form;
use nalgebra::Vector3;
use place::Placed;
use stillpoint::model::description::Description;

/// What the equations of motion say about the start of a scene.
pub(crate) struct Answer {
    /// Hinge accelerations of every body, in the order of its velocities.
    pub(crate) hinges: Vec<Vec<f64>>,
    /// Force and moment that its hinge passes to every body, at its root marker, inertial axes.
    pub(crate) reactions: Vec<[Vector3<f64>; 2]>,
    /// The equations, for whoever asks how well they are conditioned.
    matrix: Mat<f64>,
}

impl Answer {
    /// Ratio of the largest to the least singular value of the equations, each equation and each unknown scaled to its
    /// largest entry first so that units do not count.
    pub(crate) fn condition(&self) -> f64 {
        let n = self.matrix.nrows();
        let mut scaled = self.matrix.clone();
        for i in 0..n {
            let largest = (0..n).fold(0.0_f64, |m, j| m.max(scaled[(i, j)].abs()));
            (0..n).for_each(|j| scaled[(i, j)] /= largest);
        }
        for j in 0..n {
            let largest = (0..n).fold(0.0_f64, |m, i| m.max(scaled[(i, j)].abs()));
            (0..n).for_each(|i| scaled[(i, j)] /= largest);
        }
        let values = scaled.singular_values().expect("finite equations");
        values[0] / values[n - 1]
    }
}

/// Columns of one body's unknowns.
pub(crate) fn acceleration_of(body: usize) -> usize {
    12 * body
}
pub(crate) fn spin_of(body: usize) -> usize {
    12 * body + 3
}
pub(crate) fn force_of(body: usize) -> usize {
    12 * body + 6
}
pub(crate) fn moment_of(body: usize) -> usize {
    12 * body + 9
}

/// Solves the equations of motion at the start of a scene.
pub(crate) fn solve(description: &Description) -> Answer {
    let count = description.bodies.len();
    let placed: Vec<Placed> = (0..count).map(|index| place::place(description, Some(index))).collect();
    let mut matrix = Mat::<f64>::zeros(12 * count, 12 * count);
    let mut right = Mat::<f64>::zeros(12 * count, 1);
    let mut freedoms = Vec::new();
    for body in 0..count {
        newton_euler(description, &placed, body, &mut matrix, &mut right);
        let conditions = hinge::conditions(description, &placed, body);
        let mut row = 12 * body + 6;
        let mut add = |form: &Form| {
            form.terms.iter().for_each(|(column, factor)| matrix[(row, *column)] += factor);
            right[(row, 0)] = -form.rest;
            row += 1;
        };
        conditions.forbidden.iter().for_each(&mut add);
        let given = &description.bodies[body].hinge;
        let forces = hinge_force::of(given);
        for (i, freedom) in conditions.free.iter().enumerate() {
            let armature = given.armature.get(i).copied().unwrap_or(0.0);
            let mut balance = freedom.acceleration.times(armature);
            balance.terms.extend(&freedom.force);
            balance.rest -= forces[i];
            add(&balance);
        }
        freedoms.push(conditions.free);
    }
    let x = solve_refined(&matrix, &right);
    let value = |form: &Form| form.rest + form.terms.iter().map(|(column, factor)| factor * x[*column]).sum::<f64>();
    let three = |at: usize| Vector3::new(x[at], x[at + 1], x[at + 2]);
    Answer {
        hinges: freedoms.iter().map(|of| of.iter().map(|free| value(&free.acceleration)).collect()).collect(),
        reactions: (0..count).map(|body| [three(force_of(body)), three(moment_of(body))]).collect(),
        matrix,
    }
}

/// The six equations of one body about its centre of mass.
fn newton_euler(
    description: &Description,
    placed: &[Placed],
    body: usize,
    matrix: &mut Mat<f64>,
    right: &mut Mat<f64>,
) {
    let (mass, at) = (&description.bodies[body].mass, &placed[body]);
    let row = 12 * body;
    let inertia = at.turn * mass.inertia * at.turn.transpose();
    let mut force = mass.mass * description.gravity;
    let mut moment = -at.spin.cross(&(inertia * at.spin));
    for push in force::pushes(description, placed).iter().filter(|push| push.body == Some(body)) {
        force += push.force;
        moment += push.torque + (push.at - at.center).cross(&push.force);
    }
    for i in 0..3 {
        matrix[(row + i, acceleration_of(body) + i)] = mass.mass;
        for j in 0..3 {
            matrix[(row + 3 + i, spin_of(body) + j)] = inertia[(i, j)];
        }
        right[(row + i, 0)] = force[i];
        right[(row + 3 + i, 0)] = moment[i];
    }
    for (other, given) in description.bodies.iter().enumerate() {
        let sign = match other == body {
            true => -1.0,
            false if given.hinge.parent == description.bodies[body].name => 1.0,
            false => continue,
        };
        let lever = (placed[other].position - at.center).cross_matrix();
        for i in 0..3 {
            matrix[(row + i, force_of(other) + i)] = sign;
            matrix[(row + 3 + i, moment_of(other) + i)] = sign;
            for j in 0..3 {
                matrix[(row + 3 + i, force_of(other) + j)] = sign * lever[(i, j)];
            }
        }
    }
}

/// LU with row pivoting, then one step of iterative refinement.
fn solve_refined(matrix: &Mat<f64>, right: &Mat<f64>) -> Vec<f64> {
    let factors = matrix.partial_piv_lu();
    let mut x = factors.solve(right);
    let residual = right - matrix * &x;
    x += factors.solve(&residual);
    (0..x.nrows()).map(|i| x[(i, 0)]).collect()
}
