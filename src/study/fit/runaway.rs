//! Whether the sum of squares has a minimum where a search has ended.
//!
//! A sum of squares may fall for ever: a spring that measurements want to be rigid grows, and what it gains by that shrinks with
//! it, until a step of the search changes nothing any more. That looks like a minimum and is none. Two signs make a parameter
//! suspect where a search has ended, at `x` with the residuals `r` and their Jacobian `J`:
//!
//! ```text
//! (1)  s = −J⁺ r, the step without damping, is long beside x
//! (2)  x is far from the start, and the residuals hardly feel it there
//! ```
//!
//! What is suspect is tried: from `x` on along `s`, to a hundredfold of the parameter and as far as the linear model says that the
//! sum of squares doubles; or towards zero, if beyond that there is no answer. A minimum rises there, however badly it is determined;
//! where nothing rises there is none.

use super::residuals::{Minimum, Residuals, Stop, Way};
use nalgebra::DVector;

/// (1): a step of at least this part of the parameter.
const LONG: f64 = 0.1;
/// (2): a parameter of at least so many times its start.
const AFAR: f64 = 2.0;
/// (2): a change of the parameter as a whole does less than this part of what it did.
const FAINT: f64 = 1e-6;
/// A parameter below this part of its start is on its way to zero.
const SMALL: f64 = 1e-3;
/// A sum of squares that rises by no more than this part of itself does not rise: runs are computed to some 1e-9.
const LEVEL: f64 = 1e-6;
/// Singular values of the Jacobian, its columns of length one, below this part of the largest are zero.
const RANK: f64 = 1e-8;
/// How far a parameter is tried at least, in parts of itself.
const REACH: [f64; 2] = [9.0, 99.0];

/// What is beyond the end of a search.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Beyond {
    /// Nothing that is known: it is a minimum if the search says so.
    Nothing,
    /// A sum of squares that does not rise up to a bound, or up to zero where that ends what has answers: that place.
    Bound(Vec<f64>),
    /// A sum of squares that falls all the way along these parameters.
    Falls(Vec<(usize, Way)>),
    /// A long step that is worth another search.
    Step,
}

/// Looks beyond the end of a search from `start`; `sizes` are the largest lengths that the columns of the Jacobian have had.
///
/// # Errors
/// A caller that ended it.
pub(super) fn beyond(
    of: &mut dyn Residuals,
    found: &Minimum,
    (start, sizes): (&[f64], &[f64]),
    (low, high): (&[f64], &[f64]),
) -> Result<Beyond, Stop> {
    let mut end = End { of, found, low, high, step: undamped(found) };
    let own = |j: usize| match start[j].abs() {
        size if size > 0.0 => size,
        _ if (high[j] - low[j]).is_finite() => high[j] - low[j],
        _ => 1.0,
    };
    let free = (0..start.len()).filter(|j| !found.held[*j]);
    let (mut suspect, mut small) = (Vec::new(), Vec::new());
    for j in free {
        let (x, norm) = (found.x[j], found.jacobian.column(j).norm());
        if end.step[j].abs() >= LONG * x.abs().max(own(j)) {
            suspect.push(j);
        } else if x.abs() >= AFAR * own(j) && norm * x.abs() <= FAINT * sizes[j] * own(j) {
            end.step[j] = x;
            suspect.push(j);
        }
        if x != 0.0 && x.abs() <= SMALL * own(j) {
            // So small a number may no longer be felt.
            if norm <= FAINT * sizes[j] {
                end.step[j] = -2.0 * x;
            }
            if -end.step[j] / x > 1.0 {
                small.push(j);
            }
        }
    }
    let mut falls = Vec::new();
    for j in &small {
        match end.falls_to_zero(*j)? {
            Some(Some(zero)) => return Ok(Beyond::Bound(zero)),
            Some(None) => falls.push((*j, Way::Zero)),
            None => {}
        }
    }
    for j in suspect.iter().filter(|j| !small.contains(j)) {
        match end.falls_along(&[*j])? {
            Some(Some(bound)) => return Ok(Beyond::Bound(bound)),
            Some(None) => falls.push((*j, if end.step[*j] > 0.0 { Way::Up } else { Way::Down })),
            None => {}
        }
    }
    if falls.is_empty() && suspect.len() > 1 {
        match end.falls_along(&suspect)? {
            Some(Some(bound)) => return Ok(Beyond::Bound(bound)),
            Some(None) => falls.extend(suspect.iter().map(|j| (*j, Way::Together))),
            None => {}
        }
    }
    Ok(match falls.is_empty() {
        false => Beyond::Falls(falls),
        true if suspect.is_empty() => Beyond::Nothing,
        true => Beyond::Step,
    })
}

/// (1), of the parameters that no bound holds; zero for those that nothing follows from.
fn undamped(found: &Minimum) -> Vec<f64> {
    let mut step = vec![0.0; found.x.len()];
    let norm = |j: usize| found.jacobian.column(j).norm();
    let felt: Vec<usize> = (0..step.len()).filter(|j| !found.held[*j] && norm(*j) > 0.0).collect();
    if felt.is_empty() {
        return step;
    }
    let columns: Vec<DVector<f64>> = felt.iter().map(|j| found.jacobian.column(*j) / norm(*j)).collect();
    let parts = nalgebra::DMatrix::from_columns(&columns).svd(true, true);
    let least = RANK * parts.singular_values.max();
    // Both sides were asked for: there is a solution.
    let solution = parts.solve(&found.residuals, least).unwrap_or_else(|_| DVector::zeros(felt.len()));
    for (at, j) in felt.iter().enumerate() {
        step[*j] = -solution[at] / norm(*j);
    }
    step
}

/// The end of a search.
struct End<'a> {
    of: &'a mut dyn Residuals,
    found: &'a Minimum,
    low: &'a [f64],
    high: &'a [f64],
    /// How far each parameter would go.
    step: Vec<f64>,
}

impl End<'_> {
    /// Whether the sum of squares does not rise at a place; `None` if there is no answer.
    fn is_level(&mut self, x: &[f64]) -> Result<Option<bool>, Stop> {
        match self.of.at(x) {
            Ok(there) => Ok(Some(there.norm_squared() <= (1.0 + LEVEL) * self.found.residuals.norm_squared())),
            Err(Stop::No(_)) => Ok(None),
            Err(ended) => Err(ended),
        }
    }

    /// Whether the sum of squares does not rise along the steps of some parameters: as far as it is tried, or to the bound that is
    /// met first, which is given.
    fn falls_along(&mut self, which: &[usize]) -> Result<Option<Option<Vec<f64>>>, Stop> {
        let mut direction = DVector::zeros(self.step.len());
        which.iter().for_each(|j| direction[*j] = self.step[*j]);
        let x = &self.found.x;
        // In parts of the step: a multiple of the parameter that it moves most, and where the linear model doubles the sum.
        let most = which.iter().map(|j| (self.step[*j] / x[*j]).abs()).fold(0.0, f64::max);
        let doubled = self.found.residuals.norm() / (&self.found.jacobian * &direction).norm();
        let [near, far] = REACH.map(|reach| if most.is_finite() && most > 0.0 { reach / most } else { reach });
        let far = if doubled.is_finite() { doubled.clamp(far, far.max(self.of.reach() / most)) } else { far };
        let until = |j: &usize| {
            let end = if direction[*j] > 0.0 { self.high[*j] } else { self.low[*j] };
            ((end - x[*j]) / direction[*j], end, *j)
        };
        let (bound, end, at_bound) =
            which.iter().map(until).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((f64::INFINITY, 0.0, 0));
        let mut answered = false;
        for part in [near, (near * far).sqrt(), far].into_iter().filter(|part| *part < bound) {
            let place: Vec<f64> = (0..x.len()).map(|j| x[j] + part * direction[j]).collect();
            match self.is_level(&place)? {
                Some(true) => answered = true,
                Some(false) => return Ok(None),
                None => {}
            }
        }
        if bound.is_finite() {
            let mut place: Vec<f64> = (0..x.len()).map(|j| x[j] + bound * direction[j]).collect();
            place[at_bound] = end;
            match self.is_level(&place)? {
                Some(true) => return Ok(Some(Some(place))),
                Some(false) => return Ok(None),
                None => {}
            }
        }
        Ok(answered.then_some(None))
    }

    /// Whether the sum of squares does not rise on the way of a parameter to zero, and there is no answer where its step leads beyond:
    /// zero itself is a bound then, and given, if it has an answer.
    fn falls_to_zero(&mut self, j: usize) -> Result<Option<Option<Vec<f64>>>, Stop> {
        let mut place = self.found.x.clone();
        let beyond = place[j] + self.step[j];
        if (self.low[j]..=self.high[j]).contains(&beyond) {
            place[j] = beyond;
            if self.is_level(&place)?.is_some() {
                return Ok(None);
            }
        }
        for part in REACH.map(|reach| 1.0 / (1.0 + reach)) {
            place[j] = part * self.found.x[j];
            if self.is_level(&place)? != Some(true) {
                return Ok(None);
            }
        }
        place[j] = 0.0;
        Ok(match self.is_level(&place)? {
            Some(true) => Some(Some(place)),
            Some(false) => None,
            None => Some(None),
        })
    }
}
