//! The equilibrium of a scene with loops, drives and gears: stationary points of the potential on the closed positions.
//!
//! ```text
//! r(q) = b − τ: the residual at rest,   G: gradients of the rows,   B: the inertia each coordinate sees
//! (1)  G B^(−1/2) = U S Vᵀ,   Z = B^(−1/2) V₂: the motions that keep every row (V₂ spans the null space)
//! (2)  λ = U S⁻¹ V₁ᵀ B^(−1/2) r: what the rows have to hold;   Zᵀ r: what they cannot
//! (3)  H = Zᵀ (∂(r − Gᵀλ)/∂q) Z: the stiffness along the closed positions, their curvature in it
//! ```
//!
//! The search is the one of the tree, in the coordinates `y` of `Z` and with every trial closed again: Newton within a
//! trust region down the potential, whose curvature is known by eigenvalues, so that saddles are left. Where loads have
//! no potential, or any equilibrium will do, Newton with a line search on the residual. Everything is dense: O(n³).
//!
//! **Drives** stay where they are at t = 0, and where the rest can be at rest beside a driven motion (a governor that
//! spins), they keep their velocity: the kinetic energy then counts as a potential of the opposite sign.
//! **Locks** hold like rows; what they hold is reported.
//! **Singular positions**: where rows hang on each other that are independent elsewhere, the motions that only exist
//! there do not count: the branch that the search came along is kept.

mod certificate;
mod view;

use super::equilibrium::Equilibrium;
use super::search::Iteration;
use super::{Method, Settings, Want};
use crate::dynamics::Fault;
use crate::model::Model;
use view::{Tied, View};

const MOST_STEPS: usize = 400;
/// Largest turn (rad), and part of the scene's length, of one step.
const LONGEST_STEP: f64 = 0.6;

/// Finds the equilibrium from the guess `start`, whose loops are closed or nearly so.
///
/// # Errors
/// Where the system cannot be evaluated at the guess, and for the baselines, which know no loops.
pub(super) fn equilibrium(model: &Model, settings: &Settings, start: &[f64]) -> Result<Equilibrium, Fault> {
    if matches!(settings.method, Method::Relaxation | Method::Lagrange) {
        return Err(Fault::Tied { method: settings.method.name() });
    }
    let mut tied = Tied::new(model, start)?;
    let mut history = Vec::new();
    let mut notes = Vec::new();
    let descends = settings.want == Want::Stable && model.is_conservative();
    let first = tied.view(start, None)?;
    let (view, stage) = match descends {
        _ if first.place.is_exact() && !(descends && tied.curvatures(&first)?.0.first().is_some_and(|c| *c < 0.0)) => {
            (first, "start")
        }
        true => (descend(&mut tied, first, &mut history, &mut notes)?, "trust region"),
        false => (approach(&mut tied, first, &mut history)?, "newton"),
    };
    let view = polish(&mut tied, view, &mut history)?;
    certificate::certify(tied, settings, view, stage, history, notes)
}

/// Down the potential within a trust region.
fn descend(
    tied: &mut Tied<'_>,
    mut view: View,
    history: &mut Vec<Iteration>,
    notes: &mut Vec<String>,
) -> Result<View, Fault> {
    let mut radius = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let (curvatures, directions) = tied.curvatures(&view)?;
        let count = curvatures.len();
        let along: Vec<f64> =
            (0..count).map(|i| (0..count).map(|k| directions[(k, i)] * view.gradient[k]).sum()).collect();
        let negative = curvatures.first().is_some_and(|lowest| *lowest < -1e-9 * view.stiffest);
        if view.place.is_exact() && !negative {
            return Ok(view);
        }
        if negative && view.place.is_balanced() {
            let names = tied.names(&view, &(0..count).map(|k| directions[(k, 0)]).collect::<Vec<_>>());
            notes.push(format!("left an unstable equilibrium along {names}"));
        }
        let longest = tied.longest(&view, LONGEST_STEP);
        radius = f64::min(radius, longest);
        let Some((mut y, shift)) = step_within(&curvatures, &along, radius) else { return Ok(view) };
        if negative && view.place.is_balanced() {
            // On a saddle the gradient says nothing: along the steepest way down.
            y = vec![0.0; count];
            y[0] = 0.2 * radius;
        }
        let predicted: f64 = (0..count).map(|i| along[i] * y[i] + 0.5 * curvatures[i] * y[i] * y[i]).sum();
        let step: Vec<f64> = (0..count).map(|k| (0..count).map(|i| directions[(k, i)] * y[i]).sum()).collect();
        let size = norm(&step);
        let Some(next) = tied.moved(&view, &step)? else {
            radius = 0.25 * size;
            if radius < 1e-12 * longest {
                return Ok(view);
            }
            continue;
        };
        let gained = next.potential - view.potential;
        let round_off = 1e-13 * (view.potential.abs() + view.energy_scale);
        let better = if predicted.abs() > round_off {
            gained / predicted > 1e-4
        } else {
            next.place.residual().0 < view.place.residual().0
        };
        if predicted.abs() > round_off {
            let ratio = gained / predicted;
            if ratio < 0.25 {
                radius = 0.25 * size;
            } else if ratio > 0.75 && size > 0.8 * radius {
                radius *= 2.0;
            }
        }
        if better {
            let residual = next.place.residual().0;
            history.push(Iteration { stage: "trust region", residual, step: size, shift });
            view = next;
        } else if predicted.abs() <= round_off || radius < 1e-12 * longest {
            return Ok(view);
        }
    }
    Ok(view)
}

/// The minimizer of the quadratic model within `radius`, in the directions of the curvatures, and its shift.
fn step_within(curvatures: &[f64], along: &[f64], radius: f64) -> Option<(Vec<f64>, f64)> {
    let lowest = *curvatures.first()?;
    let at = |shift: f64| -> Vec<f64> {
        curvatures.iter().zip(along).map(|(c, g)| if *g == 0.0 { 0.0 } else { -g / (c + shift) }).collect()
    };
    if lowest > 0.0 {
        let y = at(0.0);
        if norm(&y) <= radius {
            return Some((y, 0.0));
        }
    }
    let size = norm(along);
    if size == 0.0 {
        return None;
    }
    // |y(shift)| falls from infinity (or the hard case) to zero: bisection in the logarithm above the pole.
    let pole = (-lowest).max(0.0);
    let scale = curvatures.iter().fold(size / radius, |m, c| m.max(c.abs()));
    let (mut low, mut high) = (1e-16 * scale, 4.0 * (scale + size / radius));
    for _ in 0..200 {
        let middle = (low * high).sqrt();
        if norm(&at(pole + middle)) > radius {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some((at(pole + high), pole + high))
}

/// Newton with a line search on the residual: to the nearest equilibrium, whatever it is.
fn approach(tied: &mut Tied<'_>, mut view: View, history: &mut Vec<Iteration>) -> Result<View, Fault> {
    for _ in 0..MOST_STEPS {
        if view.place.is_exact() {
            break;
        }
        let Some(step) = tied.newton(&view)? else { break };
        let longest = tied.longest(&view, LONGEST_STEP);
        let mut scale = (longest / norm(&step)).min(1.0);
        let mut better = None;
        for _ in 0..20 {
            let trial: Vec<f64> = step.iter().map(|x| scale * x).collect();
            if let Some(next) = tied.moved(&view, &trial)?
                && norm(&next.gradient) <= (1.0 - 1e-4 * scale) * norm(&view.gradient)
            {
                better = Some((next, norm(&trial)));
                break;
            }
            scale *= 0.5;
        }
        let Some((next, step)) = better else { break };
        let residual = next.place.residual().0;
        history.push(Iteration { stage: "newton", residual, step, shift: 0.0 });
        view = next;
    }
    Ok(view)
}

/// Newton steps while they still halve the residual.
fn polish(tied: &mut Tied<'_>, mut view: View, history: &mut Vec<Iteration>) -> Result<View, Fault> {
    for _ in 0..10 {
        if view.place.is_exact() {
            break;
        }
        let Some(step) = tied.newton(&view)? else { break };
        match tied.moved(&view, &step)? {
            Some(next) if next.place.residual().0 <= 0.5 * view.place.residual().0 => {
                let residual = next.place.residual().0;
                history.push(Iteration { stage: "polish", residual, step: norm(&step), shift: 0.0 });
                view = next;
            }
            _ => break,
        }
    }
    Ok(view)
}

fn norm(list: &[f64]) -> f64 {
    list.iter().map(|x| x * x).sum::<f64>().sqrt()
}
