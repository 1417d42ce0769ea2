//! The lowest modes of a large system: subspace iteration with the O(n) tangent (Bathe 1971).
//!
//! ```text
//! Y = (K + sM)⁻¹ M X,   Ritz values of Y,   until the wanted ones stand still
//! ```
//!
//! `s ≥ 0` is the smallest shift of a coarse ladder with K + sM positive definite: zero at a stable equilibrium.

use super::stability::NEUTRAL;
use crate::dynamics::{Coefficients, Fault, MassAction, System, TangentSolver};
use faer::Mat;

/// Modes that are wanted, and vectors that carry them: the more, the faster.
const WANTED: usize = 8;
const VECTORS: usize = 14;
/// Eigenvalues that change by less than this part of themselves stand still.
const STILL: f64 = 1e-10;
const MOST_ITERATIONS: usize = 100;

/// What sweeps alone can tell.
pub(super) struct Lowest {
    pub unstable: usize,
    pub neutral: usize,
    /// Eigenvalues of `K x = λ M x`, ascending, and their vectors in free coordinates.
    pub modes: Vec<(f64, Vec<f64>)>,
    /// Momentum `M x` of each.
    pub momenta: Vec<Vec<f64>>,
}

struct Sweeps<'s, 'm> {
    system: &'s mut System<'m>,
    solver: TangentSolver,
    q: &'s [f64],
    rest: Vec<f64>,
    shift: Vec<f64>,
    free: &'s [usize],
    full: Vec<f64>,
    product: Vec<f64>,
    mass: MassAction,
}

/// Counts and lowest modes at `q`; the model's forces must be covered by the sweep.
pub(super) fn lowest(system: &mut System<'_>, q: &[f64], free: &[usize], magnitude: &[f64]) -> Result<Lowest, Fault> {
    let model = system.model();
    let n = model.velocity_count();
    let mut shift = vec![f64::INFINITY; n];
    free.iter().for_each(|i| shift[*i] = 0.0);
    let solver = TangentSolver::new(model);
    let (zero, mass) = (vec![0.0; n], MassAction::new(model));
    let mut sweeps =
        Sweeps { system, solver, q, rest: zero.clone(), shift, free, full: zero.clone(), product: zero, mass };
    let unstable = sweeps.negative(magnitude, NEUTRAL)?;
    let neutral = sweeps.negative(magnitude, -NEUTRAL)?.saturating_sub(unstable);
    let (modes, momenta) = sweeps.iterate(neutral)?;
    Ok(Lowest { unstable, neutral, modes, momenta })
}

impl Sweeps<'_, '_> {
    /// Negative eigenvalues of `K + part · diag(magnitude)`.
    fn negative(&mut self, magnitude: &[f64], part: f64) -> Result<usize, Fault> {
        for (i, size) in self.free.iter().zip(magnitude) {
            self.shift[*i] = part * size;
        }
        let with = Coefficients { shift: &self.shift, symmetric: true, ..Coefficients::default() };
        self.system.factorize_tangent(&mut self.solver, self.q, &self.rest, &self.rest, &with)?;
        for i in self.free {
            self.shift[*i] = 0.0;
        }
        Ok(self.solver.negative_pivots())
    }

    /// Factorizes `K + sM`; false where it is not definite.
    fn factorize(&mut self, s: f64) -> Result<bool, Fault> {
        let with =
            Coefficients { c2: s, shift: &self.shift, symmetric: true, definite: true, ..Coefficients::default() };
        self.system.factorize_tangent(&mut self.solver, self.q, &self.rest, &self.rest, &with)
    }

    fn solve(&mut self, rhs: &[f64]) -> Vec<f64> {
        self.full.fill(0.0);
        for (i, value) in self.free.iter().zip(rhs) {
            self.full[*i] = *value;
        }
        self.solver.solve(self.system.model(), &mut self.full);
        self.free.iter().map(|i| self.full[*i]).collect()
    }

    fn mass_times(&mut self, x: &[f64]) -> Vec<f64> {
        self.full.fill(0.0);
        for (i, value) in self.free.iter().zip(x) {
            self.full[*i] = *value;
        }
        self.system.mass_times(&mut self.mass, &self.full, &mut self.product);
        self.free.iter().map(|i| self.product[*i]).collect()
    }

    #[allow(clippy::type_complexity)]
    fn iterate(&mut self, neutral: usize) -> Result<(Vec<(f64, Vec<f64>)>, Vec<Vec<f64>>), Fault> {
        let unit = 1.0 / self.system.model().time_scale().powi(2);
        // Neutral motions make K itself singular: a shift well below the wanted eigenvalues takes care of them.
        let mut s = if neutral > 0 { 1e-3 * unit } else { 0.0 };
        while !self.factorize(s)? {
            if s > 1e30 * unit {
                return Ok((Vec::new(), Vec::new()));
            }
            s = if s == 0.0 { 1e-3 * unit } else { 4.0 * s };
        }
        let count = VECTORS.min(self.free.len());
        let mut basis = start(self.free.len(), count);
        let mut momenta: Vec<Vec<f64>> = basis.iter().map(|x| self.mass_times(x)).collect();
        let mut values = vec![f64::INFINITY; count];
        for _ in 0..MOST_ITERATIONS {
            let mut images: Vec<Vec<f64>> = momenta.iter().map(|p| self.solve(p)).collect();
            let mut moved: Vec<Vec<f64>> = images.iter().map(|y| self.mass_times(y)).collect();
            // Images lean towards the softest direction, all of them: upright again, or their products are round-off.
            orthonormalize(&mut images, &mut moved, &mut momenta);
            // (K + sM) Y = M X, so the projected stiffness is Yᵀ M X.
            let stiffness = gram(&images, &momenta);
            let mass = gram(&images, &moved);
            let Some((ritz, vectors)) = super::stability::generalized(&stiffness, &mass) else { break };
            basis = combine(&images, &vectors);
            momenta = combine(&moved, &vectors);
            let wanted = WANTED.min(count);
            let still = (0..wanted).all(|i| (ritz[i] - values[i]).abs() <= STILL * ritz[i].abs());
            values = ritz;
            if still {
                break;
            }
        }
        if values.iter().any(|value| !value.is_finite()) {
            return Ok((Vec::new(), Vec::new()));
        }
        let wanted = WANTED.min(count);
        momenta.truncate(wanted);
        Ok((values.iter().map(|value| value - s).zip(basis).take(wanted).collect(), momenta))
    }
}

/// Vectors with a bit of everything: low-discrepancy numbers, the same every time.
fn start(n: usize, count: usize) -> Vec<Vec<f64>> {
    let golden = 0.618_033_988_749_894_9;
    (0..count)
        .map(|j| (0..n).map(|i| ((i * (j + 1) + j * j) as f64 * golden + 0.5 / (j + 1) as f64).fract() - 0.5).collect())
        .collect()
}

/// Makes the images `Y` orthonormal in the mass, `M Y` and `(K + sM) Y` along with them (Gram and Schmidt, twice).
fn orthonormalize(images: &mut [Vec<f64>], moved: &mut [Vec<f64>], pulled: &mut [Vec<f64>]) {
    for j in 0..images.len() {
        for i in (0..j).chain(0..j) {
            let part = dot(&moved[i], &images[j]);
            for lists in [&mut *images, &mut *moved, &mut *pulled] {
                let (before, after) = lists.split_at_mut(j);
                after[0].iter_mut().zip(&before[i]).for_each(|(x, y)| *x -= part * y);
            }
        }
        let size = dot(&images[j], &moved[j]).max(0.0).sqrt();
        if size > 0.0 {
            for list in [&mut images[j], &mut moved[j], &mut pulled[j]] {
                list.iter_mut().for_each(|x| *x /= size);
            }
        }
    }
}

/// `a · b` in eight sums side by side: a single one would wait for itself at every number.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a, b) = (a.chunks_exact(sums.len()), b.chunks_exact(sums.len()));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    for (a, b) in a.zip(b) {
        for i in 0..sums.len() {
            sums[i] += a[i] * b[i];
        }
    }
    sums.iter().sum::<f64>() + rest
}

fn gram(left: &[Vec<f64>], right: &[Vec<f64>]) -> Mat<f64> {
    let product = Mat::from_fn(left.len(), left.len(), |i, j| dot(&left[i], &right[j]));
    Mat::from_fn(left.len(), left.len(), |i, j| 0.5 * (product[(i, j)] + product[(j, i)]))
}

fn combine(images: &[Vec<f64>], vectors: &Mat<f64>) -> Vec<Vec<f64>> {
    (0..images.len())
        .map(|j| {
            let mut sum = vec![0.0; images[0].len()];
            for (i, image) in images.iter().enumerate() {
                let part = vectors[(i, j)];
                sum.iter_mut().zip(image).for_each(|(sum, x)| *sum += part * x);
            }
            sum
        })
        .collect()
}
