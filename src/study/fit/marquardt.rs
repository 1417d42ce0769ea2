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
//!
//! `D` keeps its largest sizes, so that a parameter whose influence shrinks on the way takes ever shorter steps. Where these end
//! [`runaway`](super::runaway) looks on: whether a bound is ahead, whether the sum of squares has a minimum at all, or whether another
//! search with the sizes of that place goes further.

use super::residuals::{Minimum, Residuals, Stop};
use super::runaway::{Beyond, beyond};
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
const SAME_SUM: f64 = 1e-12;
/// Searches that may follow each other, each of which lowers the sum of squares by more than this part of itself.
const MOST_SEARCHES: usize = 30;
const WORTH: f64 = 1e-9;
/// Where no step helps any more, round-off of the residuals is in the way if no cosine exceeds this.
const NEARLY: f64 = 1e-4;

/// The parameters of least squares within bounds, from `start`.
///
/// # Errors
/// Residuals that have no value at the start, or a caller that ended it.
pub(super) fn least_squares(
    of: &mut dyn Residuals,
    start: &[f64],
    (low, high): (&[f64], &[f64]),
) -> Result<Minimum, Stop> {
    let (mut low, mut high) = (low.to_vec(), high.to_vec());
    let start: Vec<f64> = (0..start.len()).map(|j| start[j].clamp(low[j], high[j])).collect();
    // The largest of all searches, beside those of each.
    let mut largest = vec![0.0; start.len()];
    let mut found = descend(of, &start, 0, &mut largest, (&low, &high))?;
    for _ in 0..MOST_SEARCHES {
        let place = match beyond(of, &found, (&start, &largest), (&low, &high))? {
            Beyond::Nothing => return Ok(found),
            Beyond::Falls(falls) => return Ok(Minimum { falls, converged: false, ..found }),
            Beyond::Bound(place) => place,
            Beyond::Step => found.x.clone(),
        };
        // Where nothing is felt of it any more, a parameter that has been put to its bound stays there.
        for (j, at) in place.iter().enumerate().filter(|(j, at)| **at != found.x[*j]) {
            if *at == low[j] || *at == high[j] || *at == 0.0 {
                (low[j], high[j]) = (*at, *at);
            }
        }
        let next = descend(of, &place, found.steps, &mut largest, (&low, &high))?;
        let is_lower = next.residuals.norm_squared() < (1.0 - WORTH) * found.residuals.norm_squared();
        if place == found.x && !is_lower {
            let converged = found.converged && found.cosine <= NEARLY;
            return Ok(Minimum { converged, ..found });
        }
        found = next;
    }
    Ok(Minimum { converged: false, ..found })
}

/// Goes down from a place as far as steps lead.
fn descend(
    of: &mut dyn Residuals,
    start: &[f64],
    taken: usize,
    largest: &mut [f64],
    (low, high): (&[f64], &[f64]),
) -> Result<Minimum, Stop> {
    let (mut x, mut residuals) = (start.to_vec(), of.at(start)?);
    let mut sizes = vec![0.0_f64; x.len()];
    let (mut damping, mut refused) = (DAMPING, None);
    for steps in taken.. {
        let jacobian = of.jacobian(&x)?;
        let gradient = jacobian.transpose() * &residuals;
        let norms: Vec<f64> = jacobian.column_iter().map(|column| column.norm()).collect();
        sizes.iter_mut().zip(&norms).for_each(|(size, norm)| *size = size.max(*norm));
        largest.iter_mut().zip(&sizes).for_each(|(largest, size)| *largest = largest.max(*size));
        let is_held =
            |j: usize| low[j] == high[j] || gradient[j] > 0.0 && x[j] <= low[j] || gradient[j] < 0.0 && x[j] >= high[j];
        let held: Vec<bool> = (0..x.len()).map(is_held).collect();
        let cosine = |j: usize| match held[j] || gradient[j] == 0.0 {
            true => 0.0,
            false => (gradient[j] / (norms[j] * residuals.norm())).abs(),
        };
        let cosine = (0..x.len()).map(cosine).fold(0.0, f64::max);
        let at = Place { x: &x, residuals: &residuals, jacobian: &jacobian, sizes: &sizes, held: &held, low, high };
        let next = match cosine <= PERPENDICULAR || steps >= MOST_STEPS {
            true => Next::None(cosine <= PERPENDICULAR),
            false => at.next(of, (&mut damping, &mut refused), &gradient)?,
        };
        let minimum = |x, residuals, jacobian, steps, converged, refused| Minimum {
            x,
            residuals,
            jacobian,
            held: held.clone(),
            steps,
            converged,
            falls: Vec::new(),
            refused,
            cosine,
        };
        match next {
            Next::Step(step, there) => (x, residuals) = (step, there),
            Next::Last(x, residuals) => {
                let jacobian = of.jacobian(&x)?;
                return Ok(minimum(x, residuals, jacobian, steps + 1, true, None));
            }
            Next::None(least) => {
                let converged = least || cosine <= NEARLY && steps < MOST_STEPS;
                let refused = refused.filter(|_| !converged);
                return Ok(minimum(x, residuals, jacobian, steps, converged, refused));
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
    /// `refused` becomes why the last trial had no answer, if it had none.
    fn next(
        &self,
        of: &mut dyn Residuals,
        (damping, refused): (&mut f64, &mut Option<String>),
        gradient: &DVector<f64>,
    ) -> Result<Next, Stop> {
        let cost = self.residuals.norm_squared();
        let mut grow = 2.0;
        *refused = None;
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
                Err(Stop::No(why)) => {
                    *refused = Some(why);
                    None
                }
                Err(ended) => return Err(ended),
            };
            if predicted <= FLAT * cost {
                let least = *damping <= 1.0;
                return Ok(match there.filter(|there| least && there.norm_squared() <= (1.0 + SAME_SUM) * cost) {
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
    use super::super::residuals::Way;
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

    /// Two residuals of one parameter; none where they have no value.
    type Pair = fn(f64) -> Option<[f64; 2]>;

    /// A sum of two squares.
    struct Single(Pair);

    impl Residuals for Single {
        fn at(&mut self, x: &[f64]) -> Result<DVector<f64>, Stop> {
            (self.0)(x[0]).map(|r| DVector::from_row_slice(&r)).ok_or_else(|| Stop::No("none".to_owned()))
        }

        fn jacobian(&mut self, x: &[f64]) -> Result<DMatrix<f64>, Stop> {
            let (here, h) = (self.at(x)?, if x[0] == 0.0 { 1e-6 } else { 1e-6 * x[0] });
            Ok(DMatrix::from_columns(&[(self.at(&[x[0] + h])? - here) / h]))
        }
    }

    fn single(of: Pair, range: [f64; 2]) -> Minimum {
        least_squares(&mut Single(of), &[25.0], (&range[..1], &range[1..])).expect("an end")
    }

    const FREE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

    /// What falls towards one, zero, or as a logarithm all the way to infinity.
    #[test]
    fn what_has_no_minimum_runs_off() {
        let falling: [Pair; 3] = [
            |x| (x > 0.0).then(|| [1.0 + 1.0 / x, 0.5]),
            |x| (x > 0.0).then(|| [1.0 / x, 0.0]),
            |x| (x > 0.0).then(|| [1.0 / (1.0 + x.ln().max(0.0)), 0.5]),
        ];
        for of in falling {
            let found = single(of, FREE);
            assert!(!found.converged && found.falls == [(0, Way::Up)], "{found:?}");
        }
        let found = single(|x| (x > 0.0).then_some([1.0 + x, 0.5]), FREE);
        assert!(!found.converged && found.falls == [(0, Way::Zero)], "{found:?}");
        // With an answer at zero the least is there.
        let found = single(|x| (x >= 0.0).then_some([1.0 + x, 0.5]), FREE);
        assert!(found.converged && found.x == [0.0] && found.held == [true], "{found:?}");
    }

    #[test]
    fn what_falls_to_a_bound_ends_there() {
        for end in [30.0, 1e4, 1e15] {
            let found = single(|x| (x > 0.0).then(|| [1.0 + 1.0 / x, 0.5]), [1.0, end]);
            assert!(found.converged && found.x == [end] && found.held == [true], "{found:?}");
        }
    }

    /// A minimum far away, where the parameter is felt 10¹² times less than at the start; and one that is nearly flat.
    #[test]
    fn a_minimum_is_found_however_faintly_it_is_felt() {
        let found = single(|x| Some([1e6 / x - 1.0, 0.01]), FREE);
        assert!(found.converged && (found.x[0] / 1e6 - 1.0).abs() < 1e-4, "{found:?}");
        let found = single(|x| Some([1e-7 * (x - 40.0), 1.0]), FREE);
        assert!(found.converged && found.falls.is_empty(), "{found:?}");
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
