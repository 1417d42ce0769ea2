//! The stiffness beside supports that bear, with what their forces add to it and springs along their rows.
//!
//! ```text
//! (1)  K − ∂²(Σ λ g)/∂q² + σB + κ Σ JᵀJ / (J B⁻¹ Jᵀ)          g, J: gaps of the supports and their gradients
//! ```
//!
//! What only its supports hold up has a stiffness that is not definite, and stays so however near to its rest it is. Where these rows do not move
//! nothing changes by their springs: the steps are those of the Lagrangian, convex where it has a minimum along them (Bertsekas,
//! "Constrained Optimization and Lagrange Multiplier Methods", 1982, 2.2).

use super::Landscape;
use super::linear::Definite;
use faer::Mat;

/// Up to so many free coordinates the matrix is written down.
const MOST: usize = 600;

/// (1) at a position, along the motions that loops leave.
pub(in crate::statics) struct Braced {
    /// `Z` of the motions that loops leave, in which the metric is the identity; `None` without loops.
    along: Option<Mat<f64>>,
    metric: Vec<f64>,
    matrix: Mat<f64>,
    factor: Option<Definite>,
}

impl Braced {
    /// Motions along which it is written down.
    pub(in crate::statics) fn count(&self) -> usize {
        self.matrix.nrows()
    }

    /// One of them, in free coordinates.
    pub(in crate::statics) fn motion(&self, index: usize) -> Vec<f64> {
        let n = self.metric.len();
        match &self.along {
            Some(z) => (0..n).map(|i| z[(i, index)]).collect(),
            None => (0..n).map(|i| if i == index { 1.0 } else { 0.0 }).collect(),
        }
    }

    /// Takes off what forces of supports do to the stiffness, by two motions.
    pub(in crate::statics) fn take_off(&mut self, curvature: &Mat<f64>) {
        self.matrix -= curvature;
    }

    /// Adds the spring of a row (by free coordinate); its stiffness.
    pub(in crate::statics) fn brace(&mut self, row: &[f64], brace: f64) -> f64 {
        let r = self.along(row);
        let metric = |j: usize| if self.along.is_some() { 1.0 } else { self.metric[j] };
        let softness: f64 = r.iter().enumerate().map(|(j, r)| r * r / metric(j)).sum();
        let spring = if softness > 0.0 { brace / softness } else { 0.0 };
        for j in (0..r.len()).filter(|j| r[*j] != 0.0) {
            (0..r.len()).for_each(|i| self.matrix[(i, j)] += spring * r[i] * r[j]);
        }
        spring
    }

    /// Factorizes it with `σ` (1/s²); false if it is not definite.
    pub(in crate::statics) fn factorize(&mut self, shift: f64) -> bool {
        let of = |j: usize| if self.along.is_some() { shift } else { shift * self.metric[j] };
        let shifts: Vec<f64> = (0..self.count()).map(of).collect();
        self.factor = Definite::of(&self.matrix, &shifts);
        self.factor.is_some()
    }

    /// Solves with the last factorization; numbers that are not finite if there is none.
    pub(in crate::statics) fn solve(&self, rhs: &[f64]) -> Vec<f64> {
        let Some(factor) = &self.factor else { return vec![f64::NAN; rhs.len()] };
        let y = factor.solve(&self.along(rhs));
        match &self.along {
            Some(z) => (0..z.nrows()).map(|i| y.iter().enumerate().map(|(j, y)| z[(i, j)] * y).sum()).collect(),
            None => y,
        }
    }

    fn along(&self, rhs: &[f64]) -> Vec<f64> {
        match &self.along {
            Some(z) => (0..z.ncols()).map(|j| (0..z.nrows()).map(|i| z[(i, j)] * rhs[i]).sum()).collect(),
            None => rhs.to_vec(),
        }
    }
}

impl Landscape<'_> {
    /// (1) without supports at a position; `None` in large scenes, of loads without a potential, and where it cannot be evaluated.
    pub(in crate::statics) fn braced(&mut self, q: &[f64]) -> Option<Braced> {
        if self.free.len() > MOST || !self.conservative {
            return None;
        }
        let (along, mut matrix) = match self.ties.is_some() {
            true => self.stiffness_along(q).map(|(z, h)| (Some(z), h)).ok()?,
            false => (None, self.dense_stiffness(q).ok()?),
        };
        if along.is_none() {
            let stops = self.with_stops(&vec![0.0; self.free.len()]).into_owned();
            stops.iter().enumerate().for_each(|(i, stop)| matrix[(i, i)] += stop);
        }
        Some(Braced { along, metric: self.metric.clone(), matrix, factor: None })
    }
}
