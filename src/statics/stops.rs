//! Stops of hinges: which of them an equilibrium rests on, and what they bear.
//!
//! With the stops that bear known, the scene is one without stops: a rigid one holds its coordinate at the limit like a
//! lock, a compliant one is a spring of the hinge,
//!
//! ```text
//! k (q − rest) + k_s (q − limit) = k' (q − rest'),     k' = k + k_s,   rest' = (k rest + k_s limit)/k'        (1)
//! ```
//!
//! so that every search, its certificate and its modes hold for it as they are. In a tree whose loads have a potential the set
//! that bears is the active set of a minimum within the limits (see [`crate::statics::bounded`]). Elsewhere it is found by turns: a
//! coordinate beyond its limit gets its stop, a stop that would have to pull is taken away, and the search starts from the
//! guess again. It ends where every stop that bears presses and no other is passed: the conditions of Signorini. Where a
//! search ends in no balance, stops in the way of the forces left there are tried.
//!
//! **Beside loops, drives and gears** coordinates depend on each other, and two stops can seldom bear at once: of those
//! that are passed only the first on the way from the guess is added, the loops are brought onto it from there in short
//! steps, and where they cannot be, it takes the place of the others.

use super::bounded;
use super::equilibrium::{Equilibrium, search_free};
use super::landscape::Landscape;
use super::settings::{Settings, Want};
use super::stability::Mode;
use super::watch::Watch;
use crate::constraint::Closer;
use crate::dynamics::{Fault, System};
use crate::model::{Model, Stop, StopLaw};
use std::collections::HashSet;
use std::sync::Arc;

/// A coordinate that is further beyond its limit than this (rad, or part of the scene's length) has passed it.
const PASSED: f64 = 1e-12;
/// A rigid stop pulls where its load is below this part of the largest force in the balance.
const PULLS: f64 = 1e-10;
/// How far loops are brought at a time (rad, m; below 1 m part of the scene's length).
const SHORT: f64 = 0.1;

/// A stop that an equilibrium rests on.
#[derive(Debug, Clone, PartialEq)]
pub struct Bearing {
    /// The body whose hinge it is, as in [`Model::label`].
    pub hinge: String,
    /// Whether it is the low limit.
    pub low: bool,
    /// The limit (m or rad).
    pub limit: f64,
    /// What it bears (N or N m), ≥ 0.
    pub load: f64,
    /// How far it gives way (m or rad); 0 for a rigid one.
    pub depth: f64,
}

/// Which side of each stop bears: −1, 1, or 0 for none.
pub(super) type Set = Vec<i8>;

/// The equilibrium with the stops heeded; poses of the search go to `trail`.
pub(super) fn search(
    model: &Arc<Model>,
    settings: &Settings,
    start: &[f64],
    watch: &Watch<'_>,
    searched: &mut dyn FnMut(),
    mut trail: Option<&mut Vec<Vec<f64>>>,
) -> Result<Equilibrium, Fault> {
    let (descends, stable) = (bounded::is_for(model, settings), settings.want == Want::Stable);
    if descends
        && stable
        && let Some(found) = bounded::search(model, settings, start, watch, searched, trail.as_deref_mut())?
    {
        return Ok(found);
    }
    let found = by_turns(model, settings, start, watch, searched, trail.as_deref_mut())?;
    // The nearest equilibrium was wanted; downhill there is one, wherever it is.
    if descends
        && !(stable || found.balanced)
        && let Some(found) = bounded::search(model, settings, start, watch, searched, trail)?
    {
        return Ok(found);
    }
    Ok(found)
}

fn by_turns(
    model: &Arc<Model>,
    settings: &Settings,
    start: &[f64],
    watch: &Watch<'_>,
    searched: &mut dyn FnMut(),
    mut trail: Option<&mut Vec<Vec<f64>>>,
) -> Result<Equilibrium, Fault> {
    let mut set = touching(model, start);
    let mut seen = HashSet::new();
    let mut added = None;
    let (mut stages, mut steps, mut evaluations) = (Vec::new(), 0, 0);
    loop {
        seen.insert(set.clone());
        let Some((bearing, guess)) = with(model, &set, start) else {
            // The loops have no position on all of them: the others make way for the one that came last.
            let last = |(index, side): (usize, &i8)| if Some(index) == added { *side } else { 0 };
            let alone: Set = set.iter().enumerate().map(last).collect();
            set = if seen.contains(&alone) { vec![0; set.len()] } else { alone };
            if seen.contains(&set) {
                return nowhere(model, settings, start, watch, searched);
            }
            continue;
        };
        let (mut found, way) =
            search_free(&bearing, settings, &guess, watch, searched, trail.is_some().then(Vec::new))?;
        if let Some(trail) = &mut trail {
            trail.extend(way);
        }
        stages.append(&mut found.stages);
        steps += found.iterations;
        evaluations += found.force_evaluations;
        let next = match found.balanced {
            true => revised(model, &set, &bearing, &found, start)?,
            false if model.is_constrained() => first_in_the_way(model, &set, &bearing, &guess)?,
            false => in_the_way(model, &set, start)?,
        };
        let again = next.filter(|next| !seen.contains(next) && watch.goes_on());
        if found.balanced && again.is_none() && revised(model, &set, &bearing, &found, start)?.is_some() {
            let ended = watch.note(found.stage, found.relative_residual);
            give_up(&mut found, ended);
        }
        let Some(next) = again else {
            (found.stages, found.iterations, found.force_evaluations) = (stages, steps, evaluations);
            return finish(model, &set, &bearing, found);
        };
        added = (0..set.len()).find(|index| set[*index] == 0 && next[*index] != 0);
        set = next;
    }
}

fn give_up(found: &mut Equilibrium, ended: Option<String>) {
    found.converged = false;
    found.balanced = false;
    found.stability = None;
    let none = || "no set of stops bears this scene: each that was tried lets go or is passed".to_owned();
    found.notes.push(ended.unwrap_or_else(none));
}

/// Where the loops have no position on the stops that were tried: what is found without any, as no equilibrium.
fn nowhere(
    model: &Model,
    settings: &Settings,
    start: &[f64],
    watch: &Watch<'_>,
    searched: &mut dyn FnMut(),
) -> Result<Equilibrium, Fault> {
    let mut free = Model::clone(model);
    free.stops.clear();
    let free = Arc::new(free);
    let (mut found, _) = search_free(&free, settings, start, watch, searched, None)?;
    let ended = watch.note(found.stage, found.relative_residual);
    give_up(&mut found, ended);
    Ok(found)
}

fn limit(model: &Model, index: usize, side: i8) -> f64 {
    model.stops[index].range[usize::from(side > 0)]
}

fn unit(model: &Model, velocity: usize) -> f64 {
    if super::landscape::slides(model)[velocity] { model.length_scale() } else { 1.0 }
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
pub(super) fn touching(model: &Model, q: &[f64]) -> Set {
    model.stops.iter().map(|stop| touched(model, stop, q)).collect()
}

/// The rigid stops that a pose has passed: hinge, limit, and where it stands.
pub(super) fn passed(model: &Model, q: &[f64]) -> Vec<(String, f64, f64)> {
    let beyond = |stop: &Stop| {
        let value = q[stop.position];
        let slack = PASSED * unit(model, stop.velocity).max(value.abs());
        let limit = if value < stop.range[0] { stop.range[0] } else { stop.range[1] };
        let passes = value < stop.range[0] - slack || value > stop.range[1] + slack;
        (passes && matches!(stop.law, StopLaw::Rigid { .. })).then(|| (model.label(stop.velocity), limit, value))
    };
    model.stops.iter().filter_map(beyond).collect()
}

/// Of the stops of the set the one that would have to pull most in a balance of the scene in which they bear.
pub(super) fn pulling(
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

/// The scene in which these stops bear, and the guess on them; `None` where loops have no position there.
pub(super) fn with(model: &Model, set: &Set, start: &[f64]) -> Option<(Arc<Model>, Vec<f64>)> {
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

/// Moves coordinates to where they are held, loops closed all the way; false where these cannot follow.
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
pub(super) fn bearing(model: &Arc<Model>, q: &[f64]) -> (Arc<Model>, Vec<f64>) {
    with(model, &touching(model, q), q).unwrap_or_else(|| (model.clone(), q.to_vec()))
}

/// What a stop of the set bears; negative where it would have to pull. `held` are the forces of locked coordinates.
fn load(model: &Model, index: usize, side: i8, q: &[f64], held: &[f64]) -> f64 {
    let stop = &model.stops[index];
    match stop.law {
        StopLaw::Rigid { .. } => -f64::from(side) * held[stop.velocity],
        StopLaw::Compliant { stiffness, .. } => {
            stiffness * f64::from(side) * (q[stop.position] - limit(model, index, side))
        }
    }
}

/// What holds every locked coordinate of an equilibrium, and how large the forces are that act there.
fn held(bearing: &Arc<Model>, found: &Equilibrium) -> Result<(Vec<f64>, Vec<f64>), Fault> {
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

/// The set after a balance: stops that are passed added, those that pull taken away. `None` where nothing changes.
fn revised(
    model: &Arc<Model>,
    set: &Set,
    bearing: &Arc<Model>,
    found: &Equilibrium,
    start: &[f64],
) -> Result<Option<Set>, Fault> {
    let (held, sizes) = held(bearing, found)?;
    let mut next = set.clone();
    let mut passed: Vec<(f64, usize, i8)> = Vec::new();
    for (index, side) in next.iter_mut().enumerate() {
        let stop = &model.stops[index];
        let value = found.position[stop.position];
        let slack = PASSED * unit(model, stop.velocity).max(value.abs());
        if *side != 0 {
            let pulls = match stop.law {
                StopLaw::Rigid { .. } => {
                    load(model, index, *side, &found.position, &held) < -PULLS * sizes[stop.velocity]
                }
                StopLaw::Compliant { .. } => f64::from(*side) * (value - limit(model, index, *side)) < -slack,
            };
            if pulls {
                *side = 0;
            }
        } else if value < stop.range[0] - slack || value > stop.range[1] + slack {
            let towards: i8 = if value < stop.range[0] { -1 } else { 1 };
            let from = start[stop.position];
            passed.push(((limit(model, index, towards) - from) / (value - from), index, towards));
        }
    }
    passed.sort_by(|a, b| a.0.total_cmp(&b.0));
    // Coordinates of loops follow each other: the first stop on the way may keep the others from being passed.
    let count = if model.is_constrained() { 1 } else { passed.len() };
    passed.iter().take(count).for_each(|(_, index, towards)| next[*index] = *towards);
    Ok((next != *set).then_some(next))
}

/// Of the stops towards which the forces at the guess drive loops, gears and drives, the one that is reached first, added.
/// `None` where there is no other.
fn first_in_the_way(model: &Arc<Model>, set: &Set, bearing: &Arc<Model>, guess: &[f64]) -> Result<Option<Set>, Fault> {
    let mut system = System::new(bearing);
    let mut landscape = Landscape::new(&mut system, guess)?;
    let force = landscape.force(guess)?;
    let mut first: Option<(f64, usize, i8)> = None;
    for (index, stop) in model.stops.iter().enumerate().filter(|(index, _)| set[*index] == 0) {
        let Some(row) = landscape.free.iter().position(|i| *i == stop.velocity) else { continue };
        let speed = force[row] / landscape.metric[row];
        let towards: i8 = if speed < 0.0 { -1 } else { 1 };
        let time = (limit(model, index, towards) - guess[stop.position]) / speed;
        if time.is_finite() && first.is_none_or(|first| time < first.0) {
            first = Some((time, index, towards));
        }
    }
    Ok(first.map(|(_, index, towards)| {
        let mut next = set.clone();
        next[index] = towards;
        next
    }))
}

/// The stops towards which the forces at the guess push, added. `None` where there is no other.
fn in_the_way(model: &Arc<Model>, set: &Set, start: &[f64]) -> Result<Option<Set>, Fault> {
    let rest = vec![0.0; model.velocity_count()];
    let mut residual = rest.clone();
    System::new(model).at(0.0, start, &rest).residual(&rest, &mut residual)?;
    let mut next = set.clone();
    for (stop, side) in model.stops.iter().zip(next.iter_mut()).filter(|(_, side)| **side == 0) {
        let towards: i8 = if residual[stop.velocity] > 0.0 { -1 } else { 1 };
        if stop.range[usize::from(towards > 0)].is_finite() && residual[stop.velocity] != 0.0 {
            *side = towards;
        }
    }
    Ok((next != *set).then_some(next))
}

/// The answer in terms of the scene itself: what bears, and modes in all coordinates that it leaves free.
pub(super) fn finish(
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
