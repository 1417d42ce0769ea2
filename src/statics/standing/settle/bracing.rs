//! Steps of what only its supports hold up: its stiffness is not definite, and stays so however near to its rest it is, so that σ could not fall.
//! Where it is not, the rows that did not move in the last step are springs beside it, and what their forces do to it is part of it
//! ([`crate::statics::problem::braced`]): the steps become those of Newton's method on the contacts that bear.

use super::{LITTLE_WAY, Search};
use crate::contact::cone::Law;
use crate::contact::frame::Column;
use crate::contact::hinges::{Id, Support};
use crate::contact::pairs::Key;
use crate::statics::problem::braced::Braced;
use faer::Mat;
use nalgebra::Vector3;

/// κ in parts of the σ at which the matrix is not definite, and what counts as inside of a cone.
const BRACE: f64 = 1e6;
const INSIDE: f64 = 0.999;
/// Curvatures of gaps are differences over this part of the scene's length, along no more than so many motions.
const BESIDE: f64 = 1e-4;
const MOST_MOTIONS: usize = 32;

/// The matrix of a step with its springs.
pub(super) struct Bracing {
    matrix: Braced,
    /// Stiffness across contacts (N/m).
    springs: Vec<(Id, f64)>,
}

impl Search<'_, '_> {
    /// Factorizes the matrix of (1), beside what bears where it is not definite without; false if it is not with that, either.
    pub(super) fn factorize(&mut self, q: &[f64], supports: &[Support]) -> bool {
        self.bracing = None;
        if self.landscape.factorize(self.sigma) {
            return true;
        }
        let Some(mut matrix) = self.landscape.braced(q) else { return false };
        if let Some(curvature) = self.curvature(q, &matrix, supports) {
            matrix.take_off(&curvature);
        }
        self.brace = self.brace.max(BRACE * self.sigma);
        let mut springs = Vec::new();
        for support in supports {
            for (c, column) in self.kept(support).iter().enumerate() {
                let row = self.of_free(column);
                let spring = matrix.brace(&row, self.brace);
                if c == 0 {
                    springs.push((support.id, spring));
                }
            }
        }
        if matrix.factorize(self.sigma) {
            self.bracing = Some(Bracing { matrix, springs });
            return true;
        }
        // Differences have moved the system: back to where the step starts. What cannot be evaluated there is not factorized next, either.
        let _ = self.landscape.look(q);
        false
    }

    /// Solves with the last factorization.
    pub(super) fn solve(&mut self, rhs: &[f64]) -> Vec<f64> {
        match &self.bracing {
            Some(bracing) => bracing.matrix.solve(rhs),
            None => self.landscape.solve(rhs),
        }
    }

    /// A force, with what springs of contacts pull with: towards the ends of their ways.
    pub(super) fn pulled(&self, force: &[f64], supports: &[Support], ways: &[f64]) -> Vec<f64> {
        let mut force = force.to_vec();
        let Some(bracing) = &self.bracing else { return force };
        for (support, way) in supports.iter().zip(ways) {
            let Some((_, spring)) = bracing.springs.iter().find(|(id, _)| *id == support.id) else { continue };
            let row = self.of_free(&support.columns[0]);
            force.iter_mut().zip(row).for_each(|(force, entry)| *force -= spring * way * entry);
        }
        force
    }

    /// A row by free coordinate.
    fn of_free(&self, column: &Column) -> Vec<f64> {
        let mut row = vec![0.0; self.model.velocity_count()];
        column.iter().for_each(|(i, value)| row[*i] = *value);
        self.landscape.free.iter().map(|i| row[*i]).collect()
    }

    /// `∂²(Σ λ g)/∂q²` of the contacts that bore in the last step, along the motions of a matrix, by differences; `None` if there are too many
    /// motions, or a contact ends beside this position.
    fn curvature(&mut self, q: &[f64], braced: &Braced, supports: &[Support]) -> Option<Mat<f64>> {
        let count = braced.count();
        if count > MOST_MOTIONS {
            return None;
        }
        let mut bears: Vec<(Key, f64)> = Vec::new();
        for support in supports.iter().filter(|support| !self.kept(support).is_empty()) {
            let (Id::Contact(key), Some(force)) = (support.id, self.known(support.id)) else { continue };
            bears.push((key, force.x));
        }
        let mut ways = Vec::with_capacity(count);
        for j in 0..count {
            let motion = braced.motion(j);
            let full = self.spread(&motion);
            let far = self.farthest(q, &full);
            let step = if far > 0.0 { BESIDE * self.model.length_scale() / far } else { 0.0 };
            ways.push((motion, step));
        }
        let mut worked = |x: &[f64]| -> Option<f64> {
            let q = self.landscape.moved(q, x);
            if !q.iter().all(|q| q.is_finite()) {
                return None;
            }
            let rest = vec![0.0; self.model.velocity_count()];
            let motion = self.landscape.system().at(0.0, &q, &rest);
            self.pairs.place(motion.motion());
            bears.iter().map(|(key, force)| Some(force * self.pairs.meeting(key)?.gap)).sum()
        };
        let mut curvature = Mat::zeros(count, count);
        for i in 0..count {
            for j in 0..=i {
                let ([(a, h), (b, k)], mut sum) = ([&ways[i], &ways[j]], 0.0);
                if *h == 0.0 || *k == 0.0 {
                    continue;
                }
                for (one, other) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                    let x: Vec<f64> = a.iter().zip(b).map(|(a, b)| one * h * a + other * k * b).collect();
                    sum += one * other * worked(&x)?;
                }
                let value = sum / (4.0 * h * k);
                (curvature[(i, j)], curvature[(j, i)]) = (value, value);
            }
        }
        Some(curvature)
    }

    /// The force of a support in the last step.
    pub(super) fn known(&self, id: Id) -> Option<Vector3<f64>> {
        self.warm.iter().find(|(known, _)| *known == id).map(|(_, force)| *force)
    }

    /// Rows of a support along which the last step did not move: it bore, and its friction held.
    fn kept<'c>(&self, support: &'c Support) -> &'c [Column] {
        let (Some(force), Law::Coulomb { stick, .. }) = (self.known(support.id), support.law) else { return &[] };
        match () {
            () if !(force.x > 0.0) || support.gap > LITTLE_WAY * self.model.length_scale() => &[],
            () if force.yz().norm() < INSIDE * stick * force.x => &support.columns,
            () => &support.columns[..1],
        }
    }
}
