//! Anderson's mixing of the sweeps of a fixed-point iteration `x ← G(x)`.
//!
//! ```text
//! (1)  g_k = G(x_k) − x_k,   min |g_k − Σ c_i Δg_i|,   x_{k+1} = G(x_k) − Σ c_i ΔG_i
//! ```
//!
//! over the differences `Δg_i`, `ΔG_i` of the last [`DEPTH`] sweeps (Anderson, "Iterative procedures for nonlinear integral equations", J. ACM 12,
//! 1965; Walker, Ni, SIAM J. Numer. Anal. 49, 2011). Sweeps of Gauss and Seidel over contacts that press on each other in long rows take a
//! sixth of their number with it (1000 balls in a pile: 320 sweeps to 10⁻⁷, 46 with it). What is mixed lies outside of the cones by little; the
//! next sweep takes it back. Where it leads astray ([`ASTRAY`]) the best iterate is taken up again.

use nalgebra::{SMatrix, SVector, Vector3};

/// Differences that are kept.
const DEPTH: usize = 5;
/// A residual that is larger than the smallest by this factor ends the mixing, to begin anew.
const ASTRAY: f64 = 2.0;
/// What is added to the squares of the differences, in parts of them: they may be linearly dependent.
const REGULAR: f64 = 1e-10;

/// The last sweeps.
#[derive(Debug, Default)]
pub(super) struct Mixing {
    start: Vec<Vector3<f64>>,
    residual: Vec<Vector3<f64>>,
    image: Vec<Vector3<f64>>,
    /// `Δg` and `ΔG`; the oldest is written over.
    differences: [[Vec<Vector3<f64>>; 2]; DEPTH],
    count: usize,
    squares: SMatrix<f64, DEPTH, DEPTH>,
    best: f64,
    best_image: Vec<Vector3<f64>>,
    begun: bool,
}

fn dot(a: &[Vector3<f64>], b: &[Vector3<f64>]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a.dot(b)).sum()
}

impl Mixing {
    pub(super) fn new(size: usize) -> Self {
        let room = || vec![Vector3::zeros(); size];
        Self {
            start: room(),
            residual: room(),
            image: room(),
            differences: std::array::from_fn(|_| [room(), room()]),
            best: f64::INFINITY,
            best_image: room(),
            ..Self::default()
        }
    }

    /// A sweep begins at `x`.
    pub(super) fn begin(&mut self, x: &[Vector3<f64>]) {
        self.start.copy_from_slice(x);
    }

    /// `x`, where the sweep has led, becomes where the next one begins: (1).
    pub(super) fn mix(&mut self, x: &mut [Vector3<f64>]) {
        let size = x.iter().zip(&self.start).map(|(x, start)| (x - start).norm_squared()).sum::<f64>().sqrt();
        if size > ASTRAY * self.best {
            x.copy_from_slice(&self.best_image);
            (self.count, self.begun, self.best) = (0, false, f64::INFINITY);
            return;
        }
        if size < self.best {
            self.best = size;
            self.best_image.copy_from_slice(x);
        }
        if self.begun {
            let slot = self.count % DEPTH;
            let [residuals, images] = &mut self.differences[slot];
            for (i, x) in x.iter().enumerate() {
                residuals[i] = x - self.start[i] - self.residual[i];
                images[i] = x - self.image[i];
            }
            self.count += 1;
            for i in 0..self.kept() {
                let product = dot(&self.differences[i][0], &self.differences[slot][0]);
                (self.squares[(i, slot)], self.squares[(slot, i)]) = (product, product);
            }
        }
        self.begun = true;
        for (i, x) in x.iter().enumerate() {
            (self.residual[i], self.image[i]) = (x - self.start[i], *x);
        }
        let Some(parts) = self.parts() else { return };
        for (part, [_, images]) in parts.iter().zip(&self.differences) {
            x.iter_mut().zip(images).for_each(|(x, image)| *x -= image * *part);
        }
    }

    fn kept(&self) -> usize {
        self.count.min(DEPTH)
    }

    /// `c` of (1).
    fn parts(&self) -> Option<SVector<f64, DEPTH>> {
        let kept = self.kept();
        if kept == 0 {
            return None;
        }
        // Rows that are not there yet are those of the unit matrix.
        let entry = |i: usize, j: usize| match (i < kept && j < kept, i == j) {
            (true, true) => self.squares[(i, i)] * (1.0 + REGULAR) + f64::MIN_POSITIVE,
            (true, false) => self.squares[(i, j)],
            (false, same) => f64::from(u8::from(same)),
        };
        let right = |i: usize| if i < kept { dot(&self.differences[i][0], &self.residual) } else { 0.0 };
        let matrix = SMatrix::<f64, DEPTH, DEPTH>::from_fn(entry);
        let found = matrix.cholesky()?.solve(&SVector::<f64, DEPTH>::from_fn(|i, _| right(i)));
        found.iter().all(|part| part.is_finite()).then_some(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A linear iteration with four rates is at its end after six sweeps, which takes it thousands without mixing.
    #[test]
    fn linear_iterations_take_a_sweep_for_every_rate() {
        let rates = [Vector3::new(0.99, 0.5, -0.3), Vector3::new(0.9, 0.99, 0.5)];
        let end = [Vector3::new(1.0, -2.0, 3.0), Vector3::new(0.5, 4.0, -1.0)];
        let (mut x, mut mixing) = (vec![Vector3::zeros(); 2], Mixing::new(2));
        for sweep in 0..7 {
            if sweep > 0 {
                mixing.mix(&mut x);
            }
            mixing.begin(&x);
            x.iter_mut().zip(&rates).zip(&end).for_each(|((x, rate), end)| *x = end + (*x - end).component_mul(rate));
        }
        // The squares of the differences are regular to 1e-10 of themselves.
        assert!(x.iter().zip(&end).all(|(x, end)| (x - end).norm() < 1e-6), "{x:?}");
    }
}
