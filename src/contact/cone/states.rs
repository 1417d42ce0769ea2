//! The equations of states that sweeps have found: sticking contacts keep still, slipping ones do not sink, each with its own force.

use super::{ConeState, Law, Problem, RANK};
use nalgebra::{DMatrix, DVector, Vector3};

/// Rows of these equations, and refinements of their solution.
const MOST_ROWS: usize = 240;
const MOST_POLISHED: usize = 8;
/// Steps of Newton's method with states that change.
const MOST_STEPS: usize = 20;
/// Refinements of a solution of these rows.
const REFINEMENTS: usize = 3;
/// What their solution may lack, in parts of rates and of forces.
const POLISHED: f64 = 1e-12;

/// One equation of states: what it measures at a contact, and what it pushes there.
struct Row {
    of: usize,
    measures: Vector3<f64>,
    pushes: Vector3<f64>,
}

impl Problem {
    /// Forces that meet the equations of these states, as near as can be to those that are given; `None` if they are not within their
    /// laws: then the states are not the right ones, or there are too many rows.
    pub(super) fn polished(&self, near: &[Vector3<f64>], states: &[ConeState]) -> Option<Vec<Vector3<f64>>> {
        let size = (0..near.len()).map(|i| self.rate_size(i, near)).fold(0.0, f64::max);
        let mut forces = near.to_vec();
        for _ in 0..MOST_POLISHED {
            for i in (0..forces.len()).filter(|i| states[*i] == ConeState::Slip) {
                let rate = self.rate(i, &forces).yz();
                if let (Law::Coulomb { slide, .. }, Some(d)) = (self.laws[i], rate.try_normalize(POLISHED * size)) {
                    let normal = forces[i].x;
                    (forces[i].y, forces[i].z) = (-slide * normal * d.x, -slide * normal * d.y);
                }
            }
            let rows = self.rows(&forces, states)?;
            let missing = self.missing(&rows, &forces);
            if missing.amax() <= POLISHED * size && self.obeys(&forces, states, size) {
                return Some(forces);
            }
            let change = shortest(&self.matrix_of(&rows), missing)?;
            rows.iter().zip(change.iter()).for_each(|(row, change)| forces[row.of] += row.pushes * *change);
        }
        None
    }

    /// Forces and their states by Newton's method with the states that forces and rates predict (Alart, Curnier, "A mixed formulation for
    /// frictional contact problems prone to Newton like solution methods", CMAME 92, 1991), each step as short as can be: where contacts share
    /// what others could bear alone sweeps creep. `None` if it does not end, or there are too many rows.
    pub(super) fn newton(
        &self,
        near: &[Vector3<f64>],
        states: &[ConeState],
    ) -> Option<(Vec<Vector3<f64>>, Vec<ConeState>)> {
        let size = (0..near.len()).map(|i| self.rate_size(i, near)).fold(0.0, f64::max);
        let (mut forces, mut states) = (near.to_vec(), states.to_vec());
        let mut before: Vec<Vec<ConeState>> = Vec::new();
        for _ in 0..MOST_STEPS {
            let rates: Vec<Vector3<f64>> = (0..forces.len()).map(|i| self.rate(i, &forces)).collect();
            for (i, rate) in rates.iter().enumerate() {
                self.predict(i, rate, &mut forces[i], &mut states[i]);
            }
            // States that come back after others go round.
            if before.last() != Some(&states) {
                if before.contains(&states) {
                    return None;
                }
                before.push(states.clone());
            }
            let rows = self.rows(&forces, &states)?;
            let missing = self.missing(&rows, &forces);
            if missing.amax() <= POLISHED * size && self.obeys(&forces, &states, size) {
                return Some((forces, states));
            }
            let change = shortest(&self.matrix_of(&rows), missing)?;
            rows.iter().zip(change.iter()).for_each(|(row, change)| forces[row.of] += row.pushes * *change);
        }
        None
    }

    /// The state that a contact's force and rate predict, and the force as it is at the bound of that.
    fn predict(&self, i: usize, rate: &Vector3<f64>, force: &mut Vector3<f64>, state: &mut ConeState) {
        let Law::Coulomb { stick, slide } = self.laws[i] else { return };
        let own = self.own(i)[(0, 0)];
        if !(own > 0.0) {
            return;
        }
        let ahead = *force - rate / own;
        (*force, *state) = match ahead.yz().norm() {
            _ if ahead.x <= 0.0 => (Vector3::zeros(), ConeState::Open),
            along if stick > 0.0 && along <= stick * ahead.x => (*force, ConeState::Stick),
            along => {
                let normal = if force.x > 0.0 { force.x } else { ahead.x };
                let tangential = if along > 0.0 { ahead.yz() * (slide * normal / along) } else { ahead.yz() };
                (Vector3::new(normal, tangential.x, tangential.y), ConeState::Slip)
            }
        };
    }

    /// What rows lack with these forces.
    fn missing(&self, rows: &[Row], forces: &[Vector3<f64>]) -> DVector<f64> {
        let each = rows.iter().map(|row| -row.measures.dot(&self.rate(row.of, forces)));
        DVector::from_iterator(rows.len(), each)
    }

    /// What rows measure of what they push.
    fn matrix_of(&self, rows: &[Row]) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(rows.len(), rows.len());
        // Rows stand in the order of their contacts.
        let first = |of: usize| rows.partition_point(|row| row.of < of);
        for (i, row) in rows.iter().enumerate() {
            for (with, block) in &self.blocks[row.of] {
                let measured = block.tr_mul(&row.measures);
                for (j, other) in rows.iter().enumerate().skip(first(*with)).take_while(|(_, other)| other.of == *with)
                {
                    matrix[(i, j)] = measured.dot(&other.pushes);
                }
            }
        }
        matrix
    }

    /// What the rates of a contact are made of.
    fn rate_size(&self, i: usize, forces: &[Vector3<f64>]) -> f64 {
        let parts = self.blocks[i].iter().map(|(j, block)| (block * forces[*j]).amax());
        parts.fold(self.rates[i].amax(), f64::max)
    }

    /// The equations of states; what slips does so along the velocity that it has with these forces. `None` if there are too many.
    fn rows(&self, forces: &[Vector3<f64>], states: &[ConeState]) -> Option<Vec<Row>> {
        let mut rows = Vec::new();
        for (of, state) in states.iter().enumerate() {
            let own = self.own(of);
            let mut add = |measures: Vector3<f64>, pushes: Vector3<f64>| rows.push(Row { of, measures, pushes });
            match (state, self.laws[of]) {
                (ConeState::Open, _) | (ConeState::Slip, Law::Bounded { .. }) => {}
                (ConeState::Stick, _) => {
                    (0..3)
                        .filter(|k| own[(*k, *k)] > 0.0)
                        .for_each(|k| add(Vector3::ith(k, 1.0), Vector3::ith(k, 1.0)));
                }
                (ConeState::Slip, Law::Sliding { friction, direction }) => {
                    add(Vector3::x(), Vector3::new(1.0, -friction * direction.x, -friction * direction.y));
                }
                (ConeState::Slip, Law::Coulomb { .. }) => {
                    // Along the force that it has: a change of it keeps the direction.
                    let tangential = forces[of].yz() / forces[of].x;
                    add(Vector3::x(), Vector3::new(1.0, tangential.x, tangential.y));
                }
            }
        }
        (rows.len() <= MOST_ROWS && rows.iter().all(|row| row.pushes.iter().all(|x| x.is_finite()))).then_some(rows)
    }

    /// Whether forces and the rates that they leave are those of states.
    fn obeys(&self, forces: &[Vector3<f64>], states: &[ConeState], size: f64) -> bool {
        let largest = forces.iter().map(|force| force.amax()).fold(0.0, f64::max);
        let slack = POLISHED * largest;
        (0..forces.len()).all(|i| {
            let (force, rate) = (forces[i], self.rate(i, forces));
            match (states[i], self.laws[i]) {
                (ConeState::Open, _) => rate.x >= -POLISHED * size,
                (ConeState::Stick, Law::Coulomb { stick, .. }) => {
                    force.x >= -slack && force.yz().norm() <= stick * force.x + slack
                }
                (ConeState::Stick, Law::Bounded { bound }) => force.norm() <= bound + slack,
                (ConeState::Stick, Law::Sliding { .. }) => false,
                // Of a force at its bound the sweeps have the direction.
                (ConeState::Slip, Law::Bounded { .. }) => {
                    force.dot(&rate) <= 0.0 && force.cross(&rate).norm() <= POLISHED.sqrt() * force.norm() * size
                }
                (ConeState::Slip, Law::Sliding { .. }) => force.x >= -slack,
                (ConeState::Slip, Law::Coulomb { stick, .. }) => {
                    let (along, across) = (force.yz().dot(&rate.yz()), force.yz().perp(&rate.yz()));
                    let straight = along <= 0.0 && across.abs() <= POLISHED * force.yz().norm() * size;
                    force.x >= -slack && (stick == 0.0 || straight)
                }
            }
        })
    }
}

/// The solution of least norm of rows that may be linearly dependent, but for what is below [`RANK`] of their products: `Bᵀ(B Bᵀ + δ 1)⁻¹ r`,
/// refined (Björck, "Numerical methods for least squares problems", 1996, 2.9).
fn shortest(rows: &DMatrix<f64>, mut missing: DVector<f64>) -> Option<DVector<f64>> {
    let mut products = rows * rows.transpose();
    let damping = RANK * products.diagonal().max();
    (0..products.nrows()).for_each(|i| products[(i, i)] += damping);
    let factor = products.cholesky()?;
    let mut found = DVector::zeros(rows.ncols());
    for _ in 0..REFINEMENTS {
        let change = rows.tr_mul(&factor.solve(&missing));
        missing -= rows * &change;
        found += change;
    }
    Some(found)
}
