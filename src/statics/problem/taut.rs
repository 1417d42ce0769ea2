//! Loads across rows that are taut: two rods in one line, a wire without sag.
//!
//! Rows that are linearly dependent at a position may leave a motion `x` to first order that they stop to second, (2) of
//! `prestress`: an infinitesimal mechanism. They push along their gradients only, which do no work on `x`: whatever they bear, a force
//! along `x` stays as it is, and next to the position they would have to bear the more the nearer it is. If (3) of `prestress` holds
//! without any other stiffness, no motion leads away, and there is nothing to search for (second-order rigidity: Connelly & Whiteley,
//! 1996).

use super::Landscape;
use super::place::Place;
use super::prestress::NO_STIFFNESS;
use crate::dynamics::Fault;
use faer::Mat;

/// Self-stresses that are asked one by one.
const MOST_STRESSES: usize = 64;

/// What is unbalanced at a place along a motion of first order only.
pub(in crate::statics) struct Taut {
    /// The loops, drives and gears that stop the motion to second order.
    pub(in crate::statics) names: Vec<String>,
    /// Whether they stop every motion.
    pub(in crate::statics) rigid: bool,
    /// The free coordinate that moves across them with most of the force.
    pub(in crate::statics) worst: Option<usize>,
}

impl Landscape<'_> {
    /// Whether what is left of the forces at a place acts along a motion that rows leave to first order only.
    ///
    /// # Errors
    /// The element whose numbers are not finite.
    pub(in crate::statics) fn taut(&mut self, place: &Place) -> Result<Option<Taut>, Fault> {
        let is_dense = self.ties.as_ref().is_some_and(|ties| !ties.sweeps);
        if !is_dense || self.system.left_out_rows() == 0 || place.is_balanced() {
            return Ok(None);
        }
        let z = self.tangent(&place.q)?;
        if !self.share_prestress(&place.q, &z)? {
            return Ok(None);
        }
        // `B Z Zᵀ f`, as a motion.
        let x = Mat::from_fn(z.nrows(), 1, |i, _| place.force[i] / self.metric[i]);
        let moved = self.moved_squares(&x)[0];
        let count = self.system.self_stresses().min(MOST_STRESSES);
        let mut names: Vec<String> = Vec::new();
        // Its parts, one for each coordinate.
        let parts = Mat::from_fn(x.nrows(), x.nrows(), |i, j| if i == j { x[(i, 0)] } else { 0.0 });
        let mut across = vec![0.0_f64; x.nrows()];
        for j in 0..count {
            let alone: Vec<f64> = (0..self.system.self_stresses()).map(|k| f64::from(u8::from(j == k))).collect();
            let stiffness = self.stress_stiffness(&place.q, &x, &alone)?[(0, 0)];
            if stiffness.abs() > NO_STIFFNESS / self.length * moved {
                names.extend(self.system.stressed(j));
                let of = self.stress_stiffness(&place.q, &parts, &alone)?;
                across.iter_mut().enumerate().for_each(|(i, sum)| *sum += of[(i, i)].abs());
            }
        }
        names.sort_unstable();
        names.dedup();
        if names.is_empty() {
            return Ok(None);
        }
        let sizes = self.moved_squares(&z);
        let down = Mat::from_fn(z.ncols(), z.ncols(), |i, j| if i == j { -sizes[i] } else { 0.0 });
        let rigid = self.certified(&place.q, &z, &down, &sizes)?.is_some();
        let least = NO_STIFFNESS / self.length * moved;
        let work = |i: &usize| (place.force[*i] * x[(*i, 0)]).abs();
        let worst = (0..across.len()).filter(|i| across[*i] > least).max_by(|a, b| work(a).total_cmp(&work(b)));
        Ok(Some(Taut { names, rigid, worst }))
    }

    /// How far each motion moves the scene: sums of squares (m²).
    fn moved_squares(&self, z: &Mat<f64>) -> Vec<f64> {
        let square = |i: usize, k: usize| (z[(i, k)] * self.unit(i)).powi(2);
        (0..z.ncols()).map(|k| (0..z.nrows()).map(|i| square(i, k)).sum()).collect()
    }
}
