//! The stops of hinges that an equilibrium rests on, and what they bear.
//!
//! With the stops that bear known, the scene is one without stops: a rigid one holds its coordinate at the limit like a
//! lock, a compliant one is a spring of the hinge,
//!
//! ```text
//! k (q − rest) + k_s (q − limit) = k' (q − rest'),     k' = k + k_s,   rest' = (k rest + k_s limit)/k'        (1)
//! ```
//!
//! so that every search, its certificate and its modes hold for it as they are.

use super::equilibrium::{Bearing, Equilibrium};
use super::modes::Mode;
use crate::constraint::Closer;
use crate::dynamics::{Fault, System};
use crate::model::{Model, Stop, StopLaw};
use std::sync::Arc;

/// A coordinate that is further beyond its limit than this (rad, or part of the scene's length) has passed it.
pub(in crate::statics) const PASSED: f64 = 1e-12;

/// A rigid stop pulls where its load is below this part of the largest force in the balance.
pub(in crate::statics) const PULLS: f64 = 1e-10;

/// How far loops are brought at a time (rad, m; below 1 m part of the scene's length).
const SHORT: f64 = 0.1;

/// Which side of each stop bears: −1, 1, or 0 for none.
pub(in crate::statics) type Set = Vec<i8>;

pub(in crate::statics) fn limit(model: &Model, index: usize, side: i8) -> f64 {
    model.stops[index].limit(f64::from(side))
}

pub(in crate::statics) fn unit(model: &Model, velocity: usize) -> f64 {
    if crate::statics::problem::slides(model)[velocity] { model.length_scale() } else { 1.0 }
}

/// The side on which a coordinate is at its limit or beyond.
fn touched(model: &Model, stop: &Stop, q: &[f64]) -> i8 {
    let slack = PASSED * unit(model, stop.velocity);
    match q[stop.position] {
        value if value <= stop.range[0] + slack => -1,
        value if value >= stop.range[1] - slack => 1,
        _ => 0,
    }
}

/// The sides that a pose touches.
pub(in crate::statics) fn touching(model: &Model, q: &[f64]) -> Set {
    model.stops.iter().map(|stop| touched(model, stop, q)).collect()
}

/// The rigid stops that a pose has passed: hinge, limit, and where it stands.
pub(in crate::statics) fn passed(model: &Model, q: &[f64]) -> Vec<(String, f64, f64)> {
    let beyond = |stop: &Stop| {
        let value = q[stop.position];
        let slack = PASSED * unit(model, stop.velocity).max(value.abs());
        let limit = if value < stop.range[0] { stop.range[0] } else { stop.range[1] };
        let passes = value < stop.range[0] - slack || value > stop.range[1] + slack;
        (passes && stop.is_rigid()).then(|| (model.label(stop.velocity), limit, value))
    };
    model.stops.iter().filter_map(beyond).collect()
}

/// Of the stops of the set the one that would have to pull most in a balance of the scene in which they bear.
pub(in crate::statics) fn pulling(
    model: &Arc<Model>,
    set: &Set,
    bearing: &Arc<Model>,
    found: &Equilibrium,
) -> Result<Option<usize>, Fault> {
    let (held, sizes) = held(bearing, found)?;
    let pull = |index: usize| {
        let of = load(model, index, set[index], &found.position, &held);
        of / sizes[model.stops[index].velocity].max(f64::MIN_POSITIVE)
    };
    let worst = (0..set.len()).filter(|index| set[*index] != 0).min_by(|a, b| pull(*a).total_cmp(&pull(*b)));
    Ok(worst.filter(|index| pull(*index) < -PULLS))
}

/// The scene in which these stops bear, and the guess on them; `None` if loops have no position there.
pub(in crate::statics) fn with(model: &Model, set: &Set, start: &[f64]) -> Option<(Arc<Model>, Vec<f64>)> {
    let (mut bearing, mut guess) = (Model::clone(model), start.to_vec());
    bearing.stops.clear();
    let mut held = Vec::new();
    for (index, side) in set.iter().enumerate().filter(|(_, side)| **side != 0) {
        let (stop, limit) = (&model.stops[index], limit(model, index, *side));
        let coordinate = &mut bearing.coordinates[stop.velocity];
        match stop.law {
            StopLaw::Rigid { .. } => {
                coordinate.lock = true;
                held.push((stop.position, limit));
            }
            StopLaw::Compliant { stiffness, damping } => {
                coordinate.damping += damping;
                // Eq. (1).
                let sum = coordinate.stiffness + stiffness;
                coordinate.rest = (coordinate.stiffness * coordinate.rest + stiffness * limit) / sum;
                coordinate.stiffness = sum;
            }
        }
    }
    bring(&mut bearing, &mut guess, &held).then(|| (Arc::new(bearing), guess))
}

/// Moves coordinates to where they are held, loops closed all the way; false if these cannot follow.
fn bring(bearing: &mut Model, q: &mut [f64], held: &[(usize, f64)]) -> bool {
    let given: Vec<f64> = held.iter().map(|(at, _)| q[*at]).collect();
    let length = bearing.length_scale();
    let farthest = held.iter().zip(&given).map(|((_, limit), given)| (limit - given).abs()).fold(0.0, f64::max);
    let steps =
        if bearing.is_constrained() { (farthest / (SHORT * length.min(1.0))).ceil().clamp(1.0, 1e3) } else { 1.0 };
    for step in 1..=steps as usize {
        let part = step as f64 / steps;
        for ((at, limit), given) in held.iter().zip(&given) {
            let now = if part < 1.0 { given + part * (limit - given) } else { *limit };
            q[*at] = now;
            bearing.start_position[*at] = now;
        }
        if bearing.is_constrained() && !held.is_empty() && !Closer::new(bearing).close(bearing, q) {
            return false;
        }
    }
    true
}

/// The scene in which the stops that a position touches bear, and the position on them.
pub(in crate::statics) fn bearing(model: &Arc<Model>, q: &[f64]) -> (Arc<Model>, Vec<f64>) {
    with(model, &touching(model, q), q).unwrap_or_else(|| (model.clone(), q.to_vec()))
}

/// What a stop of the set bears; negative where it would have to pull. `held` are the forces of locked coordinates.
pub(in crate::statics) fn load(model: &Model, index: usize, side: i8, q: &[f64], held: &[f64]) -> f64 {
    let stop = &model.stops[index];
    match stop.law {
        StopLaw::Rigid { .. } => -f64::from(side) * held[stop.velocity],
        StopLaw::Compliant { stiffness, .. } => stiffness * stop.depth(f64::from(side), q),
    }
}

/// What the stops of a set push each velocity coordinate with (N or N m). `held` are the forces of locked coordinates.
pub(in crate::statics) fn pushes(stops: &[Stop], set: &[i8], q: &[f64], held: &[f64]) -> Vec<f64> {
    let mut pushes = vec![0.0; held.len()];
    for (stop, side) in stops.iter().zip(set).filter(|(_, side)| **side != 0) {
        pushes[stop.velocity] += match stop.law {
            StopLaw::Rigid { .. } => held[stop.velocity],
            StopLaw::Compliant { stiffness, .. } => stiffness * (stop.limit(f64::from(*side)) - q[stop.position]),
        };
    }
    pushes
}

/// What holds every locked coordinate of an equilibrium, and how large the forces are that act there.
pub(in crate::statics) fn held(bearing: &Arc<Model>, found: &Equilibrium) -> Result<(Vec<f64>, Vec<f64>), Fault> {
    let mut system = System::new(bearing);
    let rest = vec![0.0; bearing.velocity_count()];
    let mut residual = rest.clone();
    if bearing.is_constrained() {
        system.set_multipliers(&found.multipliers);
    }
    let mut at = system.at(0.0, &found.position, &found.velocity);
    let sizes = at.residual(&rest, &mut residual)?.magnitudes().force;
    Ok((residual, sizes))
}

/// The answer in terms of the scene itself: what bears, and modes in all coordinates that it leaves free.
pub(in crate::statics) fn finish(
    model: &Arc<Model>,
    set: &Set,
    bearing: &Arc<Model>,
    mut found: Equilibrium,
) -> Result<Equilibrium, Fault> {
    let (held, _) = held(bearing, &found)?;
    for (index, side) in set.iter().enumerate().filter(|(_, side)| **side != 0) {
        let stop = &model.stops[index];
        let load = load(model, index, *side, &found.position, &held);
        let limit = limit(model, index, *side);
        let depth = match stop.law {
            StopLaw::Rigid { .. } => 0.0,
            StopLaw::Compliant { .. } => (f64::from(*side) * (found.position[stop.position] - limit)).max(0.0),
        };
        let hinge = model.label(stop.velocity);
        found.stops.push(Bearing { hinge, low: *side < 0, limit, load: load.max(0.0), depth });
    }
    let locked = |i: &usize| model.coordinates[*i].lock;
    let labels: Vec<String> = (0..model.velocity_count()).filter(locked).map(|i| model.label(i)).collect();
    found.holding.retain(|(label, _)| labels.contains(label));
    let free: Vec<bool> =
        (0..model.velocity_count()).filter(|i| !locked(i)).map(|i| !bearing.coordinates[i].lock).collect();
    let spread = |shape: &mut Vec<f64>| {
        let mut parts = std::mem::take(shape).into_iter();
        shape.extend(free.iter().map(|moves| if *moves { parts.next().unwrap_or(0.0) } else { 0.0 }));
    };
    if let Some(stability) = &mut found.stability {
        stability.modes.iter_mut().for_each(|mode: &mut Mode| spread(&mut mode.shape));
        stability.damped.iter_mut().for_each(|mode| mode.shape.iter_mut().for_each(spread));
    }
    Ok(found)
}
