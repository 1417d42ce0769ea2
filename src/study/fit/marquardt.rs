//! Least squares of smooth residuals within bounds, by damped Gauss–Newton steps (Levenberg 1944, Marquardt 1963).
//!
//! ```text
//! (1)  (JᵀJ + λ D²) s = −Jᵀ r,    D: the largest sizes that the columns of J have had (Moré 1978)
//! (2)  ρ = (|r|² − |r(x + s)|²) / (|r|² − |r + J s|²)
//! (3)  λ ← λ max(1/3, 1 − (2ρ − 1)³) where ρ > 0, else λ ← λ ν, ν ← 2 ν        (Nielsen 1999)
//! ```
//!
//! A parameter at a bound beyond which the sum of squares would fall stays there; one that a step would carry over its bound goes as
//! far as that, and the step is solved again for the others.

use nalgebra::{DMatrix, DVector};

/// Steps, at most.
const MOST_STEPS: usize = 200;
/// Trials for one step, at most.
const MOST_TRIALS: usize = 40;
/// `λ` at the start.
const DAMPING: f64 = 1e-3;
/// The residuals are perpendicular to all columns of the Jacobian when no cosine exceeds this.
const PERPENDICULAR: f64 = 1e-11;
/// A step of less than this part of the parameters changes nothing.
const SHORT: f64 = 1e-12;
/// A sum of squares that would fall by less than this part of itself is the least.
const FLAT: f64 = 1e-15;
/// Sums of squares that differ by less than this part are one.
const ROUND_OFF: f64 = 1e-12;
/// Where no step helps any more, round-off of the residuals is in the way if no cosine exceeds this.
const NEARLY: f64 = 1e-4;

/// Why residuals have no value.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Stop {
    /// There are none at these parameters.
    No(String),
    /// The caller ended it.
    Interrupted,
}

/// Residuals that depend on parameters.
pub(super) trait Residuals {
    /// Their values.
    fn at(&mut self, x: &[f64]) -> Result<DVector<f64>, Stop>;

    /// ∂r/∂x where they were evaluated last with success; `x` is that place.
    fn jacobian(&mut self, x: &[f64]) -> Result<DMatrix<f64>, Stop>;
}

/// Where the search has ended.
#[derive(Debug, Clone)]
pub(super) struct Minimum {
    pub x: Vec<f64>,
    pub residuals: DVector<f64>,
    pub jacobian: DMatrix<f64>,
    /// Parameters at a bound beyond which the sum of squares would fall.
    pub held: Vec<bool>,
    /// Steps that were taken.
    pub steps: usize,
    /// Whether it is a minimum.
    pub converged: bool,
}

/// The parameters of least squares within bounds, from `start`.
///
/// # Errors
/// Residuals that have no value at the start, or a caller that ended it.
pub(super) fn least_squares(
    of: &mut dyn Residuals,
    start: &[f64],
    (low, high): (&[f64], &[f64]),
) -> Result<Minimum, Stop> {
    let mut x: Vec<f64> = (0..start.len()).map(|j| start[j].clamp(low[j], high[j])).collect();
    let mut residuals = of.at(&x)?;
    let mut sizes = vec![0.0_f64; x.len()];
    let mut damping = DAMPING;
    for steps in 0.. {
        let jacobian = of.jacobian(&x)?;
        let gradient = jacobian.transpose() * &residuals;
        let norms: Vec<f64> = jacobian.column_iter().map(|column| column.norm()).collect();
        sizes.iter_mut().zip(&norms).for_each(|(size, norm)| *size = size.max(*norm));
        let held: Vec<bool> =
            (0..x.len()).map(|j| gradient[j] > 0.0 && x[j] <= low[j] || gradient[j] < 0.0 && x[j] >= high[j]).collect();
        let cosine = |j: usize| match held[j] || gradient[j] == 0.0 {
            true => 0.0,
            false => (gradient[j] / (norms[j] * residuals.norm())).abs(),
        };
        let cosine = (0..x.len()).map(cosine).fold(0.0, f64::max);
        let at = Place { x: &x, residuals: &residuals, jacobian: &jacobian, sizes: &sizes, held: &held, low, high };
        let next = match cosine <= PERPENDICULAR || steps == MOST_STEPS {
            true => Next::None(cosine <= PERPENDICULAR),
            false => at.next(of, &mut damping, &gradient)?,
        };
        match next {
            Next::Step(step, there) => (x, residuals) = (step, there),
            Next::Last(x, residuals) => {
                let jacobian = of.jacobian(&x)?;
                return Ok(Minimum { x, residuals, jacobian, held, steps: steps + 1, converged: true });
            }
            Next::None(least) => {
                let converged = least || cosine <= NEARLY && steps < MOST_STEPS;
                return Ok(Minimum { x, residuals, jacobian, held, steps, converged });
            }
        }
    }
    Err(Stop::Interrupted)
}

/// What follows a place.
enum Next {
    /// A better one, and its residuals.
    Step(Vec<f64>, DVector<f64>),
    /// One that is better by no more than round-off of the sum of squares: the least.
    Last(Vec<f64>, DVector<f64>),
    /// Nothing; whether it is least to round-off.
    None(bool),
}

/// Where a step begins.
struct Place<'a> {
    x: &'a [f64],
    residuals: &'a DVector<f64>,
    jacobian: &'a DMatrix<f64>,
    sizes: &'a [f64],
    held: &'a [bool],
    low: &'a [f64],
    high: &'a [f64],
}

impl Place<'_> {
    /// The next place whose sum of squares is smaller.
    fn next(&self, of: &mut dyn Residuals, damping: &mut f64, gradient: &DVector<f64>) -> Result<Next, Stop> {
        let cost = self.residuals.norm_squared();
        let mut grow = 2.0;
        for _ in 0..MOST_TRIALS {
            let step = self.step(*damping);
            let scaled = |of: &dyn Fn(usize) -> f64| {
                (0..self.x.len()).map(|j| (self.sizes[j] * of(j)).powi(2)).sum::<f64>().sqrt()
            };
            if scaled(&|j| step[j]) <= SHORT * scaled(&|j| self.x[j]) {
                return Ok(Next::None(*damping <= 1.0));
            }
            let predicted = -2.0 * gradient.dot(&step) - (self.jacobian * &step).norm_squared();
            let moved: Vec<f64> =
                (0..self.x.len()).map(|j| (self.x[j] + step[j]).clamp(self.low[j], self.high[j])).collect();
            let there = match of.at(&moved) {
                Ok(there) => Some(there),
                Err(Stop::No(_)) => None,
                Err(ended) => return Err(ended),
            };
            if predicted <= FLAT * cost {
                let least = *damping <= 1.0;
                return Ok(match there.filter(|there| least && there.norm_squared() <= (1.0 + ROUND_OFF) * cost) {
                    Some(there) => Next::Last(moved, there),
                    None => Next::None(least),
                });
            }
            if let Some(there) = there
                && there.norm_squared() < cost
            {
                let ratio = (cost - there.norm_squared()) / predicted;
                *damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).max(1.0 / 3.0);
                return Ok(Next::Step(moved, there));
            }
            *damping *= grow;
            grow *= 2.0;
        }
        Ok(Next::None(false))
    }

    /// Eq. (1) within the bounds.
    fn step(&self, damping: f64) -> DVector<f64> {
        let count = self.x.len();
        let mut step = DVector::zeros(count);
        // What nothing follows from stays where it is.
        let mut free: Vec<usize> = (0..count).filter(|j| !self.held[*j] && self.sizes[*j] > 0.0).collect();
        while !free.is_empty() {
            let rest = self.residuals + self.jacobian * &step;
            let rows = self.jacobian.nrows();
            let mut matrix = DMatrix::zeros(rows + free.len(), free.len());
            let mut right = DVector::zeros(rows + free.len());
            right.rows_mut(0, rows).copy_from(&-rest);
            for (at, j) in free.iter().enumerate() {
                matrix.view_mut((0, at), (rows, 1)).copy_from(&self.jacobian.column(*j));
                matrix[(rows + at, at)] = damping.sqrt() * self.sizes[*j];
            }
            let factor = matrix.qr();
            let projected = factor.q().transpose() * right;
            let Some(part) = factor.r().solve_upper_triangular(&projected) else { return step };
            let beyond = |at: &usize| {
                let j = free[*at];
                self.x[j] + part[*at] < self.low[j] || self.x[j] + part[*at] > self.high[j]
            };
            let over: Vec<usize> = (0..free.len()).filter(beyond).collect();
            for (at, j) in free.iter().enumerate() {
                if over.is_empty() || over.contains(&at) {
                    step[*j] = (self.x[*j] + part[at]).clamp(self.low[*j], self.high[*j]) - self.x[*j];
                }
            }
            if over.is_empty() {
                break;
            }
            let mut at = 0;
            free.retain(|_| {
                at += 1;
                !over.contains(&(at - 1))
            });
        }
        step
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley, `r = (10 (y − x²), 1 − x)`: the least is at (1, 1).
    struct Valley;

    impl Residuals for Valley {
        fn at(&mut self, x: &[f64]) -> Result<DVector<f64>, Stop> {
            Ok(DVector::from_vec(vec![10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]]))
        }

        fn jacobian(&mut self, x: &[f64]) -> Result<DMatrix<f64>, Stop> {
            Ok(DMatrix::from_row_slice(2, 2, &[-20.0 * x[0], 10.0, -1.0, 0.0]))
        }
    }

    #[test]
    fn the_valley_ends_where_it_is_known_to() {
        let free = [f64::NEG_INFINITY, f64::INFINITY].map(|end| vec![end; 2]);
        let found = least_squares(&mut Valley, &[-1.2, 1.0], (&free[0], &free[1])).expect("a minimum");
        assert!(found.converged && found.x.iter().all(|x| (x - 1.0).abs() < 1e-9), "{found:?}");
    }

    /// With x ≤ 0.5 the least is at the bound, where y = x² gives a residual of 0.5.
    #[test]
    fn a_bound_holds_its_parameter_and_the_others_go_on() {
        let low = vec![f64::NEG_INFINITY; 2];
        let found = least_squares(&mut Valley, &[-1.2, 1.0], (&low, &[0.5, 9.0])).expect("a minimum");
        assert!(found.converged && found.held == [true, false], "{found:?}");
        assert!(found.x[0] == 0.5 && (found.x[1] - 0.25).abs() < 1e-9, "{found:?}");
        assert!((found.residuals.norm() - 0.5).abs() < 1e-12);
    }
}
