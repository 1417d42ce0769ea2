//! Independent coordinates: what rows leave free to choose, and how the others follow.
//!
//! ```text
//! (1)  G δq = e d:  G_d δq_d + G_i δq_i = e d,   δq_d = −G_d⁻¹ G_i s + G_d⁻¹ e d
//! ```
//!
//! The dependent ones are the pivots of an elimination with complete pivoting, so that `G_d` is as regular as can be; held
//! coordinates are rows of their own.

use super::{Input, Place, Signal};
use crate::model::Model;
use faer::Mat;
use std::cmp::Ordering;

/// Columns of the motions of a scene.
pub(super) struct Basis {
    /// Velocity coordinates whose steps are states, in order.
    pub(super) independent: Vec<usize>,
    /// Dependent coordinates.
    pub(super) dependent: Vec<usize>,
    /// `[Z Y]`: steps of all coordinates, one column for each state of position.
    pub(super) columns: Mat<f64>,
    /// Drives whose targets are inputs.
    drives: Vec<usize>,
}

/// If no entry that is left is above this part of the largest, the rows that are left are linearly dependent.
const DEPENDENT: f64 = 1e-11;

impl Basis {
    pub(super) fn new(model: &Model, rows: &Mat<f64>, held: &[usize], inputs: &[Input]) -> Self {
        let n = model.velocity_count();
        let drives: Vec<usize> = inputs.iter().filter_map(Input::drive).collect();
        let count = rows.nrows() + held.len();
        // [G | e], then eliminated.
        let mut table = Mat::zeros(count, n + drives.len());
        for i in 0..rows.nrows() {
            (0..n).for_each(|j| table[(i, j)] = rows[(i, j)]);
            for (k, drive) in drives.iter().enumerate() {
                let at = model.drives[*drive].coordinate.velocity;
                let is_own = (0..n).all(|j| (rows[(i, j)] != 0.0) == (j == at));
                table[(i, n + k)] = if is_own { rows[(i, at)] } else { 0.0 };
            }
        }
        held.iter().enumerate().for_each(|(k, at)| table[(rows.nrows() + k, *at)] = 1.0);
        let pivots = eliminate(&mut table, n);
        let dependent: Vec<usize> = pivots.iter().map(|(_, column)| *column).collect();
        let independent: Vec<usize> = (0..n).filter(|j| !dependent.contains(j)).collect();
        let mut columns = Mat::zeros(n, independent.len() + drives.len());
        for (k, at) in independent.iter().enumerate() {
            columns[(*at, k)] = 1.0;
            pivots.iter().for_each(|(row, column)| columns[(*column, k)] = -table[(*row, *at)]);
        }
        for k in 0..drives.len() {
            pivots.iter().for_each(|(row, column)| columns[(*column, independent.len() + k)] = table[(*row, n + k)]);
        }
        let mut dependent = dependent;
        dependent.sort_unstable();
        Self { independent, dependent, columns, drives }
    }

    /// Names and units of the states of position.
    pub(super) fn states(&self, model: &Model) -> Vec<Signal> {
        let target = |drive: &usize| {
            let drive = &model.drives[*drive];
            let unit = if drive.coordinate.slides { "m" } else { "rad" };
            Signal { name: format!("{}.target", drive.name), unit: unit.to_owned() }
        };
        let own =
            self.independent.iter().map(|at| Signal { name: label(model, *at), unit: unit(model, *at).to_owned() });
        own.chain(self.drives.iter().map(target)).collect()
    }

    /// Names and units of their rates.
    pub(super) fn rates(&self, model: &Model) -> Vec<Signal> {
        let rate = |state: Signal| {
            let Signal { name, unit } = state;
            Signal { name: format!("d({name})/dt"), unit: format!("{unit}/s") }
        };
        self.states(model).into_iter().map(rate).collect()
    }

    /// (3) of the module: what a ball's angular velocity does to its rotation vector.
    pub(super) fn turn(&self, model: &Model, place: &Place, a: &mut Mat<f64>) {
        for link in model.links.iter().filter(|link| link.joint.is_ball()) {
            let w = &place.velocity[link.velocity..link.velocity + 3];
            let state = |i: usize| self.independent.iter().position(|at| *at == link.velocity + i);
            let ([Some(x), Some(y), Some(z)], true) = ([0, 1, 2].map(state), w.iter().any(|w| *w != 0.0)) else {
                continue;
            };
            for (row, column, entry) in
                [(x, y, w[2]), (x, z, -w[1]), (y, z, w[0]), (y, x, -w[2]), (z, x, w[1]), (z, y, -w[0])]
            {
                a[(row, column)] += entry;
            }
        }
    }
}

/// Gauss–Jordan elimination with complete pivoting among the first columns; the row and column of each pivot, which is 1.
fn eliminate(table: &mut Mat<f64>, n: usize) -> Vec<(usize, usize)> {
    let (rows, all) = (table.nrows(), table.ncols());
    let largest = (0..rows).flat_map(|i| (0..n).map(move |j| (i, j))).map(|at| table[at].abs()).fold(0.0, f64::max);
    let mut pivots: Vec<(usize, usize)> = Vec::new();
    loop {
        let open = |i: &usize| pivots.iter().all(|(row, _)| row != i);
        let entries = (0..rows).filter(open).flat_map(|i| (0..n).map(move |j| (i, j)));
        let best = entries.max_by(|a, b| table[*a].abs().partial_cmp(&table[*b].abs()).unwrap_or(Ordering::Equal));
        let Some((row, column)) = best.filter(|at| table[*at].abs() > DEPENDENT * largest) else { return pivots };
        let pivot = table[(row, column)];
        (0..all).for_each(|j| table[(row, j)] /= pivot);
        for i in (0..rows).filter(|i| *i != row) {
            let factor = table[(i, column)];
            if factor != 0.0 {
                (0..all).for_each(|j| table[(i, j)] -= factor * table[(row, j)]);
                table[(i, column)] = 0.0;
            }
        }
        pivots.push((row, column));
    }
}

/// Strains of beams, in their order.
const STRAINS: [&str; 6] = ["stretch", "shear_y", "shear_z", "twist", "bend_y", "bend_z"];

/// Of a coordinate of a beam's element which strain it is, and the degree of its polynomial.
fn strain(model: &Model, velocity: usize) -> Option<(usize, usize)> {
    let body = &model.bodies[model.coordinates[velocity].body];
    let joint = &model.links[body.link].joint;
    let rod = joint.rod().filter(|_| joint.is_flex())?;
    let (rod, index) = (&model.rods[rod], velocity - model.links[body.link].velocity);
    Some((rod.strain_of(index), index / rod.free_strains().count()))
}

/// A velocity coordinate as a state: `crank.angle`, `arm.turn[0]` of a rotation vector, `boom/2.bend_y[0]` of the second
/// element of a beam.
pub(super) fn label(model: &Model, velocity: usize) -> String {
    let body = &model.bodies[model.coordinates[velocity].body];
    if let Some((strain, degree)) = strain(model, velocity) {
        return format!("{}.{}[{degree}]", body.name, STRAINS[strain]);
    }
    if let Some((modal, name)) = model.modal_of(velocity) {
        return format!("{}.{name}", modal.name);
    }
    let (index, plain) = (velocity - body.hinge.velocity, body.hinge.kind.plain_coordinates());
    match body.hinge.kind.positions().get(index).filter(|_| index < plain) {
        Some((name, _)) => format!("{}.{name}", body.name),
        None => format!("{}.turn[{}]", body.name, index - plain),
    }
}

fn unit(model: &Model, velocity: usize) -> &'static str {
    if let Some((strain, _)) = strain(model, velocity) {
        return if strain < 3 { "m" } else { "rad" };
    }
    if model.modal_of(velocity).is_some() {
        return if model.lengths().any(|length| length == velocity) { "m" } else { "rad" };
    }
    let hinge = &model.bodies[model.coordinates[velocity].body].hinge;
    if hinge.kind.velocities()[velocity - hinge.velocity].1 == "m/s" { "m" } else { "rad" }
}
