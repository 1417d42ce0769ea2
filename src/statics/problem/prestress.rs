//! Prestress of linearly dependent rows.
//!
//! Rows that are linearly dependent at a position carry self-stresses `ω`, `Gᵀ ω = 0`: multipliers `λ + Σ αⱼ ωⱼ` balance the same
//! loads, whatever `α` is. If the rows are dependent in all positions around (a planar four-bar of spatial hinges) a
//! self-stress has no stiffness. Where they are not (three rods whose lines meet in a point, a rope-straight pair of rods) it
//! does:
//!
//! ```text
//! (1)  H(α) = Zᵀ K(λ) Z + Σ αⱼ Sⱼ,     Sⱼ = Zᵀ (K(λ + ωⱼ) − K(λ)) Z        Z: the motions of first order
//! (2)  xᵀ Sⱼ x ≠ 0 for some j           the rows open along x at second order: no finite motion starts along it
//! (3)  H(α) positive definite           stable, whichever α says so (prestress stability: Connelly & Whiteley, 1996)
//! ```
//!
//! (3) is the sufficient condition of second order where multipliers are not unique. The frequencies of such motions are
//! those of elastic rows in the limit of large stiffness, and depend on how the rows share the load: `λ` is the share of equally
//! stiff ones (the least sum of squares, see [`crate::dynamics::Evaluated::share_multipliers`]).

use super::Landscape;
use super::sizes::{NEUTRAL, symmetric};
use crate::dynamics::Fault;
use faer::{Mat, Side};

/// A self-stress whose stiffness is below this part of that of a row over one length of the scene has none: axes that are
/// parallel to five digits leave as much.
pub(super) const NO_STIFFNESS: f64 = 1e-4;
/// Steps of the search for `α` in (3): it takes a few where there is one.
const MOST_STEPS: usize = 200;

/// What the self-stresses of a position do to its motions.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::statics) enum Prestress {
    /// Nothing: multipliers may not be unique, the stiffness along the motions is.
    None,
    /// The stiffness depends on how the rows share the load. Equally stiff rows are taken.
    Shared,
    /// The stiffness depends on how the rows share the load, and rigid rows are stable if equally stiff ones would give way.
    Certified,
}

/// Motions that are looked at where a basis of them is too large to be made.
const SAMPLES: usize = 3;

impl Landscape<'_> {
    /// Where sweeps are the way: looks once whether self-stresses have a stiffness along some motions without a pattern. If so
    /// the verdict depends on `α` of (1), and matrices take the place of sweeps.
    pub(in crate::statics) fn heed_prestress(&mut self, q: &[f64]) -> Result<(), Fault> {
        let is_open = self.ties.as_ref().is_some_and(|ties| ties.sweeps && ties.stiffens.is_none());
        if !is_open || self.system.left_out_rows() == 0 || !self.goes_on() {
            return Ok(());
        }
        let mut samples = Mat::zeros(self.free.len(), SAMPLES);
        for k in 0..SAMPLES {
            let some = |i: usize| (1.0 + (i * (k + 1)) as f64 * 1.618_033_988_75).sin() / self.unit(i);
            let momentum: Vec<f64> = (0..self.free.len()).map(|i| self.metric[i] * some(i)).collect();
            // `Z Zᵀ B x`
            let along = self.along_rows(q, &momentum)?;
            along.iter().enumerate().for_each(|(i, f)| samples[(i, k)] = f / self.metric[i]);
        }
        if self.share_prestress(q, &samples)?
            && let Some(ties) = &mut self.ties
        {
            ties.go_densely();
        }
        Ok(())
    }

    /// Takes the multipliers of equally stiff rows if self-stresses have a stiffness along the motions `z` at a closed position
    /// whose multipliers are in the system; says whether they do.
    pub(in crate::statics) fn share_prestress(&mut self, q: &[f64], z: &Mat<f64>) -> Result<bool, Fault> {
        let known = self.ties.as_ref().and_then(|ties| ties.stiffens);
        if known == Some(false) || z.ncols() == 0 || self.system.left_out_rows() == 0 {
            return Ok(false);
        }
        let steady = self.steady.clone();
        self.system.at(0.0, q, &steady).share_multipliers()?;
        let stiffens = match known {
            Some(known) => known,
            None => self.has_stiffness(q, z)?,
        };
        if !stiffens {
            let multipliers =
                self.ties.as_ref().and_then(|ties| ties.view.as_ref()).map(|view| view.multipliers.clone());
            self.system.set_multipliers(&multipliers.unwrap_or_default());
        }
        if let Some(ties) = &mut self.ties {
            ties.stiffens = Some(stiffens);
        }
        Ok(stiffens)
    }

    /// (2) for a combination of all self-stresses without a pattern: if it has no stiffness, none has.
    fn has_stiffness(&mut self, q: &[f64], z: &Mat<f64>) -> Result<bool, Fault> {
        let count = self.system.self_stresses();
        let mix: Vec<f64> = (0..count).map(|j| (1.0 + 1.7 * (j as f64 + 1.0) * (j as f64 + 2.3)).sin()).collect();
        let stiffness = self.stress_stiffness(q, z, &mix)?;
        let size = mix.iter().map(|x| x * x).sum::<f64>().sqrt();
        let square = |i: usize, k: usize| (z[(i, k)] * self.unit(i)).powi(2);
        // A sample moves all of a large scene at once, and a self-stress stiffens some part of it.
        let moves = |k: usize| match self.ties.as_ref().is_some_and(|ties| ties.sweeps) {
            true => (0..z.nrows()).map(|i| square(i, k)).fold(0.0, f64::max),
            false => (0..z.nrows()).map(|i| square(i, k)).sum::<f64>(),
        };
        let moved: Vec<f64> = (0..z.ncols()).map(moves).collect();
        let limit = NO_STIFFNESS * size / self.length;
        let above = |i: usize, j: usize| stiffness[(i, j)].abs() > limit * (moved[i] * moved[j]).sqrt();
        Ok((0..z.ncols()).any(|i| (0..z.ncols()).any(|j| above(i, j))))
    }

    /// How far a free coordinate moves the scene per unit (m).
    pub(in crate::statics) fn unit(&self, free: usize) -> f64 {
        if self.slides[self.free[free]] { 1.0 } else { self.length }
    }

    /// `Σ αⱼ Sⱼ` of (1); the multipliers stay as they are.
    pub(super) fn stress_stiffness(&mut self, q: &[f64], z: &Mat<f64>, alpha: &[f64]) -> Result<Mat<f64>, Fault> {
        let load = self.system.multiplier_size().max(f64::MIN_POSITIVE.sqrt());
        let size = alpha.iter().map(|x| x * x).sum::<f64>().sqrt();
        // A stress of the size of the load loses no digits when it is added.
        let scale = if load > 1e-9 { load / size } else { 1.0 / size };
        let without = self.along(q, z)?;
        let add = |alpha: &[f64], by: f64| alpha.iter().map(|x| by * x).collect::<Vec<f64>>();
        self.system.add_self_stress(&add(alpha, scale));
        let with = self.along(q, z);
        self.system.add_self_stress(&add(alpha, -scale));
        let with = with?;
        Ok(symmetric(&Mat::from_fn(z.ncols(), z.ncols(), |i, j| (with[(i, j)] - without[(i, j)]) / scale)))
    }

    /// `Zᵀ K Z` with the multipliers in the system.
    fn along(&mut self, q: &[f64], z: &Mat<f64>) -> Result<Mat<f64>, Fault> {
        let steady = self.steady.clone();
        let mut all = Mat::zeros(steady.len(), z.ncols());
        for (row, i) in self.free.iter().enumerate() {
            (0..z.ncols()).for_each(|j| all[(*i, j)] = z[(row, j)]);
        }
        let pushed = self.system.at(0.0, q, &steady).stiffness_times(&all)?;
        Ok(z.transpose() * Mat::from_fn(z.nrows(), z.ncols(), |row, j| pushed[(self.free[row], j)]))
    }

    /// `H(α)` of (3), from `stiffness`, the one of equally stiff rows; `None` if no `α` was found. `sizes` are those of the
    /// stiffness terms. Steps of the subgradient method for the largest smallest eigenvalue, which is concave in `α`.
    pub(in crate::statics) fn certified(
        &mut self,
        q: &[f64],
        z: &Mat<f64>,
        stiffness: &Mat<f64>,
        sizes: &[f64],
    ) -> Result<Option<Mat<f64>>, Fault> {
        let n = z.ncols();
        let root: Vec<f64> = sizes.iter().map(|size| size.max(f64::MIN_POSITIVE).sqrt()).collect();
        let scaled = |m: &Mat<f64>| Mat::from_fn(n, n, |i, j| m[(i, j)] / (root[i] * root[j]));
        let mut sum = scaled(&symmetric(stiffness));
        let first = sum.norm_l2();
        let mut stresses = None;
        for step in 0..MOST_STEPS {
            let Ok(eigen) = sum.self_adjoint_eigen(Side::Lower) else { return Ok(None) };
            if eigen.S()[0] > NEUTRAL {
                return Ok(Some(Mat::from_fn(n, n, |i, j| sum[(i, j)] * root[i] * root[j])));
            }
            if stresses.is_none() {
                stresses = Some(self.unit_stresses(q, z, &scaled)?);
            }
            let stresses = stresses.iter().flatten();
            let x = |i: usize| eigen.U()[(i, 0)];
            let along =
                |s: &Mat<f64>| (0..n).map(|i| (0..n).map(|k| x(i) * s[(i, k)] * x(k)).sum::<f64>()).sum::<f64>();
            let gradient: Vec<f64> = stresses.clone().map(along).collect();
            let norm = gradient.iter().map(|g| g * g).sum::<f64>().sqrt();
            if !(norm > NO_STIFFNESS) {
                return Ok(None);
            }
            // Twice what lifts this direction, less and less.
            let length = 2.0 * (first + eigen.S()[0].abs()) / (norm * (1.0 + step as f64).sqrt());
            for (stress, g) in stresses.zip(&gradient) {
                sum += faer::Scale(length * g / norm) * stress;
            }
        }
        Ok(None)
    }

    /// `Sⱼ` of (1) in the units of `scaled`, each of unit norm; those without stiffness left out.
    fn unit_stresses(
        &mut self,
        q: &[f64],
        z: &Mat<f64>,
        scaled: &dyn Fn(&Mat<f64>) -> Mat<f64>,
    ) -> Result<Vec<Mat<f64>>, Fault> {
        let (n, count) = (z.ncols(), self.system.self_stresses());
        let mut stresses = Vec::new();
        for j in 0..count {
            let unit: Vec<f64> = (0..count).map(|i| f64::from(u8::from(i == j))).collect();
            let stress = scaled(&self.stress_stiffness(q, z, &unit)?);
            let norm = stress.norm_l2();
            if norm > 0.0 {
                stresses.push(Mat::from_fn(n, n, |i, k| stress[(i, k)] / norm));
            }
        }
        Ok(stresses)
    }
}
