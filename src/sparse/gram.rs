//! The products of each two sparse rows as a matrix, factorized.

use super::cholesky::Cholesky;
use super::products::Products;
use super::rows::SparseRows;
use std::sync::Arc;

/// Inverse iterations for the smallest singular value.
const ITERATIONS: usize = 12;

/// `A = G W Gᵀ` with weights `W` of the coordinates, factorized.
#[derive(Debug, Clone)]
pub struct Gram {
    products: Arc<Products>,
    values: Vec<f64>,
    cholesky: Cholesky,
}

impl Gram {
    /// Of rows and the weight of each column; `None` if the rows are linearly dependent to working precision.
    pub fn of(rows: &SparseRows, weights: &[f64]) -> Option<Self> {
        Self::damped(rows, weights, 0.0, None)
    }

    /// As [`Gram::of`], with the order of another Gram matrix if that has the same pattern.
    pub(crate) fn of_like(rows: &SparseRows, weights: &[f64], like: Option<&Self>) -> Option<Self> {
        Self::damped(rows, weights, 0.0, like)
    }

    /// The Gram matrix with `damping` times its largest diagonal entry added to the diagonal, in the order of another Gram matrix if
    /// that has the same pattern; `None` if it is singular to working precision.
    pub(crate) fn damped(rows: &SparseRows, weights: &[f64], damping: f64, like: Option<&Self>) -> Option<Self> {
        let known = like.filter(|like| like.products.are_of(rows)).map(|like| Arc::clone(&like.products));
        let products = known.unwrap_or_else(|| Arc::new(Products::of(rows, weights.len())));
        let mut values = products.values(rows, weights);
        let diagonal = || products.starts[1..].iter().map(|next| next - 1);
        let largest = diagonal().map(|at| values[at]).fold(0.0, f64::max);
        diagonal().for_each(|at| values[at] += damping * largest);
        let mut cholesky = match like.filter(|like| like.products.is_like(&products)) {
            Some(like) => like.cholesky.of_same_order(),
            None => Cholesky::new(products.pattern()),
        };
        cholesky.llt(products.pattern(), &values).then_some(())?;
        Some(Self { products, values, cholesky })
    }

    /// `x ← A⁻¹ x`, refined once.
    pub fn solve(&self, x: &mut [f64]) {
        let (rhs, mut residual) = (x.to_vec(), vec![0.0; x.len()]);
        let mut scratch = self.cholesky.another_scratch();
        self.cholesky.solve_in(&mut scratch, x);
        super::times(self.products.pattern(), &self.values, x, &mut residual);
        residual.iter_mut().zip(&rhs).for_each(|(r, b)| *r = b - *r);
        self.cholesky.solve_in(&mut scratch, &mut residual);
        x.iter_mut().zip(&residual).for_each(|(x, dx)| *x += dx);
    }

    /// The smallest singular value of `G W^½`, by inverse iteration: right to a few percent, and never below the true one.
    pub fn smallest_singular_value(&self) -> f64 {
        let mut scratch = self.cholesky.another_scratch();
        let golden = 0.618_033_988_749_894_9;
        let mut x: Vec<f64> = (0..self.products.len()).map(|i| 0.5 + ((i + 1) as f64 * golden).fract()).collect();
        let mut size = 0.0;
        for _ in 0..ITERATIONS {
            let norm = x.iter().map(|x| x * x).sum::<f64>().sqrt();
            x.iter_mut().for_each(|x| *x /= norm);
            self.cholesky.solve_in(&mut scratch, &mut x);
            size = x.iter().map(|x| x * x).sum::<f64>().sqrt();
        }
        (1.0 / size).sqrt()
    }
}
