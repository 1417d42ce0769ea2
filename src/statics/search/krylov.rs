//! The step of a trust region for any radius from one factorization: the secular equation in a Krylov space.
//!
//! ```text
//! (K + σB) x = f,  |x|_B = Δ:      A = K + σ₀B factorized, definite;   C = A⁻¹B
//! (1) C V = V T + β v eᵀ           Lanczos in the metric B, begun at A⁻¹f       (Ericsson & Ruhe 1980)
//! (2) x = (1 + (σ − σ₀) C)⁻¹ A⁻¹f ≈ V y,    y = Σ s (sᵀ V⁻¹A⁻¹f) / θ(σ + λ),    T s = θ s,   λ = 1/θ − σ₀
//! (3) |y(σ)| = Δ,   σ ≥ max(0, −λ₁);   or y + τ s₁ where |y| is less for all of these
//! ```
//!
//! (3) is what Moré and Sorensen (1983) solve by a factorization for every σ, in the space of Gould, Lucidi, Roma and Toint (1999): a
//! dozen solutions take its place, and a smaller radius costs nothing. The lowest eigenvalue comes with it. Forces without a part
//! along the lowest mode never find that, so the space begins a little beside `A⁻¹f`.

use nalgebra::DMatrix;

/// Vectors at most: what is not settled by then takes another pole.
const MOST_VECTORS: usize = 24;
/// What (2) may leave of the force, relative.
const LEFT: f64 = 1e-3;
/// How well the lowest pair has to be known, relative to `θ`.
const LOWEST: f64 = 1e-2;
/// How far the first vector is from `A⁻¹f`, relative.
const BESIDE: f64 = 1e-6;
/// A vector that shrinks to this part of what it was depends on those before it.
const DEPENDENT: f64 = 1e-12;
/// Halvings of the logarithm of `σ + λ₁` until two neighbouring numbers are left.
const HALVINGS: usize = 60;

/// The space of (1).
#[derive(Debug)]
pub(super) struct Krylov {
    /// `σ₀`.
    pole: f64,
    /// `V`, and `v` at the end unless nothing was left.
    basis: Vec<Vec<f64>>,
    /// `T`: on the diagonal, and beside it with `β` at the end.
    diagonal: Vec<f64>,
    beside: Vec<f64>,
    /// `|A⁻¹f|_B`.
    size: f64,
}

/// The solution of (3) in the space.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Within {
    /// `σ`.
    pub(super) shift: f64,
    /// `λ₁`.
    pub(super) lowest: f64,
    /// Whether more vectors would change little.
    pub(super) is_settled: bool,
}

impl Krylov {
    /// Begins at `A⁻¹f` and another solution `A⁻¹Bw`, `w` with a bit of everything in it; none if there is nothing to begin with.
    pub(super) fn new(pole: f64, metric: &[f64], mut first: Vec<f64>, other: &[f64]) -> Option<Self> {
        let (size, beside) = (norm(metric, &first), norm(metric, other));
        if beside > 0.0 {
            let part = BESIDE * size / beside;
            first.iter_mut().zip(other).for_each(|(x, y)| *x += part * y);
        }
        let whole = norm(metric, &first);
        first.iter_mut().for_each(|x| *x /= whole);
        (size > 0.0 && size.is_finite() && whole.is_finite()).then(|| Self {
            pole,
            basis: vec![first],
            diagonal: Vec::new(),
            beside: Vec::new(),
            size,
        })
    }

    /// `σ₀`.
    pub(super) fn pole(&self) -> f64 {
        self.pole
    }

    /// Whether nothing is known of the stiffness yet.
    pub(super) fn is_empty(&self) -> bool {
        self.diagonal.is_empty()
    }

    /// Whether another vector may be added.
    pub(super) fn grows(&self) -> bool {
        self.diagonal.len() < MOST_VECTORS && self.basis.len() > self.diagonal.len()
    }

    /// `B v`, of which [`Krylov::grow`] wants `A⁻¹`.
    pub(super) fn last(&self, metric: &[f64]) -> Vec<f64> {
        let last = &self.basis[self.diagonal.len()];
        last.iter().zip(metric).map(|(v, b)| b * v).collect()
    }

    /// One step of (1), orthogonal to every vector there is, twice.
    pub(super) fn grow(&mut self, metric: &[f64], mut next: Vec<f64>) {
        let whole = norm(metric, &next);
        let mut along = 0.0;
        for _ in 0..2 {
            for (k, v) in self.basis.iter().enumerate() {
                let part: f64 = v.iter().zip(&next).zip(metric).map(|((v, x), b)| b * v * x).sum();
                next.iter_mut().zip(v).for_each(|(x, v)| *x -= part * v);
                along += if k == self.diagonal.len() { part } else { 0.0 };
            }
        }
        let left = norm(metric, &next);
        self.diagonal.push(along);
        self.beside.push(left);
        if left > DEPENDENT * whole {
            next.iter_mut().for_each(|x| *x /= left);
            self.basis.push(next);
        }
    }

    /// (3), and its `y`.
    pub(super) fn within(&self, radius: f64) -> Option<(Within, Vec<f64>)> {
        let k = self.diagonal.len();
        let mut tridiagonal = DMatrix::from_diagonal(&nalgebra::DVector::from_column_slice(&self.diagonal));
        for i in 1..k {
            tridiagonal[(i - 1, i)] = self.beside[i - 1];
            tridiagonal[(i, i - 1)] = self.beside[i - 1];
        }
        let eigen = tridiagonal.try_symmetric_eigen(f64::EPSILON, 0)?;
        let first = eigen.eigenvalues.imax();
        // Round-off of a pair that is not seen at all.
        let pairs: Vec<usize> =
            (0..k).filter(|j| eigen.eigenvalues[*j] > DEPENDENT * eigen.eigenvalues[first]).collect();
        let of = |j: usize| 1.0 / eigen.eigenvalues[j] - self.pole;
        let lowest = of(first);
        let base = (-lowest).max(0.0);
        // Part of A⁻¹f, over θ; and σ + λ for what σ is above its least.
        let parts: Vec<f64> =
            pairs.iter().map(|j| eigen.eigenvectors[(0, *j)] * self.size / eigen.eigenvalues[*j]).collect();
        let above: Vec<f64> =
            pairs.iter().map(|j| if *j == first && base > 0.0 { 0.0 } else { base + of(*j) }).collect();
        let size = |more: f64| parts.iter().zip(&above).map(|(c, a)| (c / (a + more)).powi(2)).sum::<f64>().sqrt();
        let whole = parts.iter().map(|c| c * c).sum::<f64>().sqrt();
        let mut high = whole / radius;
        if !(base == 0.0 && size(0.0) <= radius) {
            let mut low = f64::EPSILON * (base + high);
            for _ in 0..HALVINGS {
                let middle = (low * high).sqrt();
                *(if size(middle) > radius { &mut low } else { &mut high }) = middle;
            }
        } else {
            high = 0.0;
        }
        let mut along: Vec<f64> = parts.iter().zip(&above).map(|(c, a)| c / (a + high)).collect();
        let reached = along.iter().map(|y| y * y).sum::<f64>();
        if let Some(at) =
            pairs.iter().position(|j| *j == first).filter(|_| base > 0.0 && reached < 0.9 * radius * radius)
        {
            // The hard case: the lowest mode makes up the rest.
            let rest = along[at] * along[at] + radius * radius - reached;
            along[at] = if along[at] < 0.0 { -1.0 } else { 1.0 } * rest.sqrt();
        }
        let y: Vec<f64> =
            (0..k).map(|i| pairs.iter().zip(&along).map(|(j, y)| eigen.eigenvectors[(i, *j)] * y).sum()).collect();
        let shift = base + high;
        let (beta, theta) = (self.beside[k - 1], eigen.eigenvalues[first]);
        let is_whole = self.basis.len() == k;
        let left = ((shift - self.pole) * beta * y[k - 1]).abs();
        let is_known = beta * eigen.eigenvectors[(k - 1, first)].abs() <= LOWEST * theta;
        let is_settled = is_whole || (left <= LEFT * self.size && is_known);
        Some((Within { shift, lowest, is_settled }, y))
    }

    /// `V y`.
    pub(super) fn step(&self, y: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; self.basis[0].len()];
        for (v, y) in self.basis.iter().zip(y) {
            x.iter_mut().zip(v).for_each(|(x, v)| *x += y * v);
        }
        x
    }
}

/// `|x|_B`.
fn norm(metric: &[f64], x: &[f64]) -> f64 {
    x.iter().zip(metric).map(|(x, b)| b * x * x).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: usize = 200;

    /// Steps within a region for a diagonal stiffness, whose equation (3) is one of single numbers: in the interior, at its border,
    /// with a negative stiffness, and in the hard case, where the force has no part along the lowest mode.
    #[test]
    fn steps_are_those_of_the_secular_equation() {
        let metric: Vec<f64> = (0..N).map(|i| 1.0 + (i % 7) as f64).collect();
        for (lowest, hard, radius) in
            [(0.5, false, 1e3), (0.5, false, 0.1), (-3.0, false, 0.5), (-3.0, true, 50.0), (-3.0, true, 0.01)]
        {
            let k: Vec<f64> = (0..N).map(|i| metric[i] * (lowest + 0.3 * i as f64)).collect();
            let force: Vec<f64> = (0..N).map(|i| if i == 0 && hard { 0.0 } else { (i as f64 * 1.3).cos() }).collect();
            let pole = 4.0;
            let solve = |f: &[f64]| -> Vec<f64> { (0..N).map(|i| f[i] / (k[i] + pole * metric[i])).collect() };
            let other: Vec<f64> =
                metric.iter().enumerate().map(|(i, b)| b * (0.5 + (i as f64 * 0.618).fract())).collect();
            let mut krylov = Krylov::new(pole, &metric, solve(&force), &solve(&other)).expect("a force");
            let (within, y) = loop {
                let next = solve(&krylov.last(&metric));
                krylov.grow(&metric, next);
                let (within, y) = krylov.within(radius).expect("eigenvalues");
                if within.is_settled || !krylov.grows() {
                    break (within, y);
                }
            };
            assert!(within.is_settled, "{within:?}");
            assert!((within.lowest - lowest).abs() < 1e-2, "{within:?} for {lowest}");
            let x = krylov.step(&y);
            let size = norm(&metric, &x);
            let interior = within.shift == 0.0;
            assert!(
                if interior { size <= radius } else { (size / radius - 1.0).abs() < 1e-6 },
                "{size} within {radius}"
            );
            assert!(within.shift >= (-lowest).max(0.0) - 1e-2);
            // The step solves its equation but for what was settled for, and for the lowest mode in the hard case.
            let left = |i: usize| force[i] - (k[i] + within.shift * metric[i]) * x[i];
            let error = (1..N).map(|i| left(i).powi(2) / metric[i]).sum::<f64>().sqrt();
            let whole = (0..N).map(|i| force[i].powi(2) / metric[i]).sum::<f64>().sqrt();
            assert!(error <= 0.02 * whole, "{error} of {whole}");
        }
    }
}
