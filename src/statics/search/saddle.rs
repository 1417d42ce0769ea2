//! Leaving a saddle: along the direction of negative curvature that runs away fastest, downhill as far as it goes.
//!
//! ```text
//! K x = λ B x,  λ lowest:   x ← (K + σB)⁻¹ B x,   −λ < σ ≤ −1.2 λ       inverse iteration
//! ```
//!
//! `K + σB` is definite where `σ` is above `−λ`, so the same factorizations that say so bracket `σ`. A direction from a
//! single negative pivot will not do in its place: of a strut of 200 links it is hundreds of times less steep, and
//! leads uphill again within a hundredth of a radian.

use crate::round_off::ENERGY;
use crate::statics::certify::known::look_closer;
use crate::statics::problem::place::Place;
use crate::statics::problem::sizes::{NEUTRAL, comparable};
use crate::statics::problem::{Landscape, MOST_MODES};

/// Trials for a shift that is large enough, each sixteen times the one before.
const MOST_TRIALS: usize = 20;
/// Inverse iterations.
const ITERATIONS: usize = 12;
/// How closely the shift is bracketed.
const BRACKET: f64 = 1.2;
/// The shortest step that is always tried, as part of one radian of every coordinate, and what the next one is longer by.
const SHORT: f64 = 1e-3;
const LONGER: f64 = 4.0;
/// The shortest step of all: what it gains is below the round-off of any potential.
const SHORTEST: f64 = 1e-9;
/// A stiffness below this part of its terms has no sign.
pub(super) const NO_SIGN: f64 = 1e-13;

/// A step that leads down, and the potential after it.
pub(in crate::statics) struct WayOut {
    pub step: Vec<f64>,
    pub potential: f64,
}

/// The step off a balanced `place`, no longer than `radius`; none if no motion runs away, or none gets lower.
pub(in crate::statics) fn way_out(
    landscape: &mut Landscape<'_>,
    place: &Place,
    potential: f64,
    radius: f64,
) -> Option<WayOut> {
    let sizes = comparable(&place.scales.stiffness);
    let slack = |part: f64| sizes.iter().map(|k| part * k).collect::<Vec<f64>>();
    // Mostly there is none, and one factorization says so.
    landscape.negative_direction(&slack(NO_SIGN))?;
    let direction = match landscape.negative_direction(&slack(NEUTRAL)) {
        Some(first) => fastest(landscape, place, &first).unwrap_or(first),
        None => {
            // What is neutral leads nowhere, and what is nearly so is looked at closely.
            if !landscape.conservative || landscape.heeds_limits() || landscape.free.len() > MOST_MODES {
                return None;
            }
            let falls = look_closer(landscape, place).ok().and_then(|known| known.falls);
            landscape.look(&place.q).ok()?;
            falls?
        }
    };
    downhill(landscape, place, &direction, potential, radius)
}

/// The lowest place that is found along a `direction` of negative curvature, no longer than `radius`; none if none is lower.
pub(in crate::statics) fn downhill(
    landscape: &mut Landscape<'_>,
    place: &Place,
    direction: &[f64],
    potential: f64,
    radius: f64,
) -> Option<WayOut> {
    let size = landscape.size(direction);
    // No further than loops close again.
    let whole: Vec<f64> = direction.iter().map(|d| radius / size * d).collect();
    let whole_part = 1.0 / landscape.stretch(&place.q, &whole).max(1.0);
    let round_off = ENERGY.of(potential.abs() + landscape.stirred(place));
    let mut lowest = WayOut { step: Vec::new(), potential };
    let mut part = SHORT;
    while part <= 1.0 {
        lower(landscape, place, &whole, part * whole_part, &mut lowest);
        part *= LONGER;
    }
    part = SHORT / LONGER;
    while lowest.step.is_empty() && part > SHORTEST {
        lowest.potential = potential - round_off;
        lower(landscape, place, &whole, part * whole_part, &mut lowest);
        part /= LONGER;
    }
    (!lowest.step.is_empty()).then_some(lowest)
}

/// Both ways by `part` of the `whole` step: kept where the potential is below the lowest so far.
fn lower(landscape: &mut Landscape<'_>, place: &Place, whole: &[f64], part: f64, lowest: &mut WayOut) {
    for sign in [1.0, -1.0] {
        let step: Vec<f64> = whole.iter().map(|x| sign * part * x).collect();
        let q = landscape.moved(&place.q, &step);
        let potential = landscape.potential(&q);
        if potential < lowest.potential {
            *lowest = WayOut { step, potential };
        }
    }
}

/// The motion of the lowest `λ` at the place last looked at, from a `first` one; none if no
/// shift makes the stiffness definite.
fn fastest(landscape: &mut Landscape<'_>, place: &Place, first: &[f64]) -> Option<Vec<f64>> {
    let metric = landscape.metric.clone();
    let largest = place.scales.stiffness.iter().zip(&metric).map(|(k, b)| k / b).fold(0.0, f64::max);
    let (mut low, mut high) = (NEUTRAL * largest, largest);
    let enough = (0..MOST_TRIALS).any(|_| {
        let definite = landscape.factorize(high);
        if !definite {
            (low, high) = (high, 16.0 * high);
        }
        definite
    });
    if !enough {
        return None;
    }
    while high > BRACKET * low {
        let between = (low * high).sqrt();
        if landscape.factorize(between) { high = between } else { low = between }
    }
    if !landscape.factorize(high) {
        return None;
    }
    let mut x = first.to_vec();
    for _ in 0..ITERATIONS {
        let size = landscape.size(&x);
        let weighted: Vec<f64> = x.iter().zip(&metric).map(|(x, b)| b * x / size).collect();
        x = landscape.solve(&weighted);
    }
    x.iter().all(|x| x.is_finite()).then_some(x)
}
