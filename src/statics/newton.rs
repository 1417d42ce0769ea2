//! Newton on the differentiated transfer equations with a line search: the method of the paper.
//!
//! At rest the condition q̈(q) = 0 reads `f(q) = 0` for the forces `f` that the transfer equations leave in the hinges,
//! and the columns of `∂f/∂q = −K` are those equations differentiated. The merit of the line search is
//! `½ fᵀ B⁻¹ f` with the hinges' inertias `B`, so forces and moments compare. Finds the equilibrium near the start,
//! whatever its stability.

use super::landscape::Landscape;
use super::linear;
use super::search::{Iteration, Place};
use crate::dynamics::Fault;

const MOST_ITERATIONS: usize = 60;

/// Runs from `place`; the answer is balanced or the best that was found.
pub(super) fn run(
    landscape: &mut Landscape<'_, '_>,
    mut place: Place,
    history: &mut Vec<Iteration>,
) -> Result<Place, Fault> {
    for _ in 0..MOST_ITERATIONS {
        if place.is_balanced() {
            break;
        }
        let Some(next) = step(landscape, &place, history)? else { break };
        place = next;
    }
    Ok(place)
}

fn merit(landscape: &Landscape<'_, '_>, force: &[f64]) -> f64 {
    force.iter().zip(&landscape.metric).map(|(f, b)| 0.5 * f * f / b).sum()
}

/// One step with backtracking: the Newton direction, and where that is no descent the direction of Levenberg and
/// Marquardt, which always is.
fn step(
    landscape: &mut Landscape<'_, '_>,
    place: &Place,
    history: &mut Vec<Iteration>,
) -> Result<Option<Place>, Fault> {
    let stiffness = landscape.dense_stiffness(&place.q)?;
    landscape.look(&place.q)?;
    let before = merit(landscape, &place.force);
    let damped = |landscape: &Landscape<'_, '_>, part: f64| levenberg(landscape, &stiffness, &place.force, part);
    let directions = [landscape.newton(&place.force), damped(landscape, 1e-6), damped(landscape, 1e-2)];
    for direction in directions.into_iter().flatten() {
        let mut scale = 1.0;
        for _ in 0..12 {
            let x: Vec<f64> = direction.iter().map(|x| scale * x).collect();
            let q = landscape.moved(&place.q, &x);
            if let Ok(next) = Place::at(landscape, q)
                && merit(landscape, &next.force) <= (1.0 - 1e-4 * scale) * before
            {
                let size = landscape.size(&x);
                history.push(Iteration { stage: "newton", residual: next.residual().0, step: size, shift: 0.0 });
                return Ok(Some(next));
            }
            scale *= 0.5;
        }
    }
    Ok(None)
}

/// `(Kᵀ B⁻¹ K + λ B) x = Kᵀ B⁻¹ f`, λ being `part` of the largest curvature.
fn levenberg(landscape: &Landscape<'_, '_>, k: &faer::Mat<f64>, force: &[f64], part: f64) -> Option<Vec<f64>> {
    let n = force.len();
    let b = &landscape.metric;
    let weighted = faer::Mat::from_fn(n, n, |i, j| k[(i, j)] / b[i]);
    let normal = k.transpose() * &weighted;
    let curvature = (0..n).map(|i| normal[(i, i)] / b[i]).fold(0.0, f64::max);
    let shift: Vec<f64> = b.iter().map(|b| part * curvature * b).collect();
    let rhs: Vec<f64> = (0..n).map(|j| (0..n).map(|i| weighted[(i, j)] * force[i]).sum()).collect();
    Some(linear::Definite::of(&normal, &shift)?.solve(&rhs))
}
