//! Newton on the differentiated transfer equations with a line search: the method of the paper.
//!
//! At rest the condition q̈(q) = 0 reads `f(q) = 0` for the forces `f` that the transfer equations leave in the hinges,
//! and the columns of `∂f/∂q = −K` are those equations differentiated. The merit of the line search is
//! `½ fᵀ B⁻¹ f` with the hinges' inertias `B`, so forces and moments compare. Finds the equilibrium near the start,
//! whatever its stability.

use crate::dynamics::Fault;
use crate::statics::effort::Iteration;
use crate::statics::problem::Landscape;
use crate::statics::problem::place::Place;

const MOST_ITERATIONS: usize = 60;

/// Runs from `place`; the answer is balanced or the best that was found.
pub(in crate::statics) fn run(
    landscape: &mut Landscape<'_>,
    mut place: Place,
    history: &mut Vec<Iteration>,
) -> Result<Place, Fault> {
    for _ in 0..MOST_ITERATIONS {
        if place.is_balanced() || !landscape.goes_on() {
            break;
        }
        let Some(next) = step(landscape, &place, history)? else { break };
        place = next;
    }
    Ok(place)
}

fn merit(landscape: &Landscape<'_>, force: &[f64]) -> f64 {
    force.iter().zip(&landscape.metric).map(|(f, b)| 0.5 * f * (f / b)).sum()
}

/// One step with backtracking: the Newton direction, and where that is no descent the direction of Levenberg and
/// Marquardt, which always is.
fn step(landscape: &mut Landscape<'_>, place: &Place, history: &mut Vec<Iteration>) -> Result<Option<Place>, Fault> {
    landscape.look(&place.q)?;
    let before = merit(landscape, &place.force);
    let newton = landscape.newton(&place.force);
    if let Some(next) = newton.map(|x| along(landscape, place, &x, before, history)).transpose()?.flatten() {
        return Ok(Some(next));
    }
    let stiffness = landscape.dense_stiffness(&place.q)?;
    landscape.look_densely(&place.q)?;
    for part in [1e-6, 1e-2] {
        if let Some(x) = landscape.levenberg(&stiffness, &place.force, part)
            && let Some(next) = along(landscape, place, &x, before, history)?
        {
            return Ok(Some(next));
        }
    }
    Ok(None)
}

/// The first place of a halving line search along a direction that is better by enough.
fn along(
    landscape: &mut Landscape<'_>,
    place: &Place,
    direction: &[f64],
    before: f64,
    history: &mut Vec<Iteration>,
) -> Result<Option<Place>, Fault> {
    let mut scale = 1.0 / landscape.stretch(&place.q, direction).max(1.0);
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
    Ok(None)
}
