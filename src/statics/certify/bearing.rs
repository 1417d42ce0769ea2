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

use super::equilibrium::{BearingStop, Equilibrium};
use super::modes::NaturalMode;
use crate::constraint::Closer;
use crate::dynamics::{Fault, System};
use crate::model::{Model, Side, Stop, StopLaw};
use crate::round_off::ON_A_LIMIT;
use std::sync::Arc;

/// A rigid stop pulls where its load is below this part of the largest force in the balance.
pub(in crate::statics) const PULLS: f64 = 1e-10;

/// How far loops are brought at a time (rad, m; below 1 m part of the scene's length).
const SHORT: f64 = 0.1;

/// Which side of each stop bears, if one does.
pub(in crate::statics) type Set = Vec<Option<Side>>;

pub(in crate::statics) fn unit(model: &Model, velocity: usize) -> f64 {
    if crate::statics::problem::slides(model)[velocity] { model.length_scale() } else { 1.0 }
}

/// The sides on which a pose is at limits or beyond.
pub(in crate::statics) fn touching(model: &Model, q: &[f64]) -> Set {
    let touched = |stop: &Stop| stop.reached(q[stop.position], ON_A_LIMIT.of(unit(model, stop.velocity)));
    model.stops.iter().map(touched).collect()
}

/// The sides of the stops that an equilibrium rests on.
pub(in crate::statics) fn borne(model: &Model, found: &Equilibrium) -> Set {
    model.stops.iter().map(|stop| told(model, found, stop).map(|one| one.side)).collect()
}

/// What an equilibrium tells of a stop that bears; a coordinate may have several.
pub(in crate::statics) fn told<'e>(model: &Model, found: &'e Equilibrium, stop: &Stop) -> Option<&'e BearingStop> {
    let hinge = model.label(stop.velocity);
    found.stops.iter().find(|one| one.hinge == hinge && one.limit == stop.limit(one.side))
}

/// The stops of a set, and the sides on which they bear.
pub(in crate::statics) fn bearing_sides<'a>(stops: &'a [Stop], set: &'a Set) -> impl Iterator<Item = (&'a Stop, Side)> {
    stops.iter().zip(set).filter_map(|(stop, side)| Some((stop, (*side)?)))
}

/// The rigid stops that a pose has passed: hinge, limit, and where it stands.
pub(in crate::statics) fn passed(model: &Model, q: &[f64]) -> Vec<(String, f64, f64)> {
    let beyond = |stop: &Stop| {
        let value = q[stop.position];
        let slack = ON_A_LIMIT.of(unit(model, stop.velocity).max(value.abs()));
        let side = stop.passed(value, slack).filter(|_| stop.is_rigid())?;
        Some((model.label(stop.velocity), stop.limit(side), value))
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
    let pulls = model.stops.iter().zip(set).enumerate().filter_map(|(index, (stop, side))| {
        let load = load(stop, (*side)?, &found.position, &held);
        Some((index, load / sizes[stop.velocity].max(f64::MIN_POSITIVE)))
    });
    let worst = pulls.min_by(|a, b| a.1.total_cmp(&b.1));
    Ok(worst.filter(|(_, pull)| *pull < -PULLS).map(|(index, _)| index))
}

/// The scene in which these stops bear, and the guess on them; `None` if loops have no position there.
pub(in crate::statics) fn with(model: &Model, set: &Set, start: &[f64]) -> Option<(Arc<Model>, Vec<f64>)> {
    let (mut bearing, mut guess) = (Model::clone(model), start.to_vec());
    bearing.stops.clear();
    let mut held = Vec::new();
    for (stop, side) in bearing_sides(&model.stops, set) {
        let limit = stop.limit(side);
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
pub(in crate::statics) fn load(stop: &Stop, side: Side, q: &[f64], held: &[f64]) -> f64 {
    match stop.law {
        StopLaw::Rigid { .. } => -side.sign() * held[stop.velocity],
        StopLaw::Compliant { stiffness, .. } => stiffness * stop.depth(side, q),
    }
}

/// What the stops of a set push each velocity coordinate with (N or N m). `held` are the forces of locked coordinates.
pub(in crate::statics) fn pushes(stops: &[Stop], set: &Set, q: &[f64], held: &[f64]) -> Vec<f64> {
    let mut pushes = vec![0.0; held.len()];
    for (stop, side) in bearing_sides(stops, set) {
        pushes[stop.velocity] += match stop.law {
            StopLaw::Rigid { .. } => held[stop.velocity],
            StopLaw::Compliant { stiffness, .. } => stiffness * (stop.limit(side) - q[stop.position]),
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
    for (stop, side) in bearing_sides(&model.stops, set) {
        let (load, limit) = (load(stop, side, &found.position, &held), stop.limit(side));
        let depth = match stop.law {
            StopLaw::Rigid { .. } => 0.0,
            StopLaw::Compliant { .. } => stop.depth(side, &found.position).max(0.0),
        };
        let hinge = model.label(stop.velocity);
        found.stops.push(BearingStop { hinge, side, limit, load: load.max(0.0), depth });
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
        stability.modes.iter_mut().for_each(|mode: &mut NaturalMode| spread(&mut mode.shape));
        stability.damped.iter_mut().for_each(|mode| mode.shape.iter_mut().for_each(spread));
    }
    Ok(found)
}
