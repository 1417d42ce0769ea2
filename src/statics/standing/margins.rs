//! How far a number of the scene may go, and how far it may be tilted, while the pose stands.

use super::answer::{Interval, Margins};
use super::closed::Scene;
use super::following::Following;
use super::supports::{Bearers, load};
use super::{Margin, Settings, Unanswered};
use crate::contact::support::{Limit, Undecided};
use crate::model::parameter::Field;
use crate::model::problem::{in_one_line, significant};
use crate::model::{Description, Model, Parameter, Problem};
use crate::statics::problem::assembled::Assembled;
use nalgebra::Vector3;
use std::sync::Arc;

/// A pose that stands, and whose.
#[derive(Clone, Copy)]
pub(super) struct Standing<'a> {
    pub(super) description: &'a Description,
    pub(super) model: &'a Arc<Model>,
    pub(super) settings: &'a Settings,
    pub(super) pose: &'a [f64],
}

pub(super) fn margins(stands: Standing<'_>, asked: &Margin, bearers: &mut Bearers) -> Result<Margins, Unanswered> {
    let mut margins = Margins::default();
    let Standing { description, pose, .. } = stands;
    // Where something follows the load, what of it a squeeze bears is not asked.
    let follows = bearers.pushed.iter().any(|pushed| !pushed);
    let mut unsqueezed = match asked.numbers.is_empty() && !asked.tilt || follows {
        true => None,
        false => bearers.unsqueezed().or_else(|why| match why {
            why @ Undecided::Inexact { .. } => {
                margins.notes.push(format!("what of the ranges only a squeeze bears is not known: {why}"));
                Ok(None)
            }
            why => Err(why),
        })?,
    };
    for parameter in &asked.numbers {
        let range = match follows {
            true => following_interval(stands, bearers, parameter),
            false => interval(description, pose, bearers, parameter),
        };
        match range {
            Ok(mut range) => {
                // The present value stands: an end on its other side is one at it, but for what the program resolves.
                let value = parameter.value(description);
                range.range = [range.range[0].min(value), range.range[1].max(value)];
                if let Some(unsqueezed) = &mut unsqueezed {
                    margins.notes.extend(squeezed(description, pose, unsqueezed, parameter, &range));
                }
                margins.numbers.push(range);
            }
            Err(why) if is_note(&why) => {
                margins.notes.push(format!("the range of `{}` is not known: {why}", parameter.address));
            }
            Err(why) => return Err(why),
        }
    }
    match asked.tilt.then(|| tilt(stands, bearers)) {
        Some(Err(why)) if is_note(&why) => {
            margins.notes.push(format!("how far it can be tilted is not known: {why}"));
        }
        Some(found) => {
            margins.tilt = found?;
            if let Some(unsqueezed) = &unsqueezed {
                margins.notes.extend(squeezed_tilt(stands, unsqueezed, &margins.tilt));
            }
        }
        None => {}
    }
    Ok(margins)
}

/// Whether a range alone has no answer.
fn is_note(why: &Unanswered) -> bool {
    // What follows the load may come upon something that it did not touch.
    matches!(
        why,
        Unanswered::Undecided(Undecided::Inexact { .. }) | Unanswered::Unbalanced { .. } | Unanswered::Untouchable(_)
    )
}

/// The range of a number: loads are affine in it, so that a difference is its direction.
fn interval(
    description: &Description,
    pose: &[f64],
    bearers: &mut Bearers,
    parameter: &Parameter,
) -> Result<Interval, Unanswered> {
    let direction = direction(description, pose, bearers, parameter)?;
    let [low, high] = [false, true].map(|upwards| bearers.supports.limit(&bearers.load, &direction, upwards));
    Ok(between(description, parameter, low?, high?))
}

/// The range of a number that what no support pushes follows.
fn following_interval(
    stands: Standing<'_>,
    bearers: &mut Bearers,
    parameter: &Parameter,
) -> Result<Interval, Unanswered> {
    let Standing { description, model, settings, pose } = stands;
    let value = parameter.value(description);
    let direction = direction(description, pose, bearers, parameter)?;
    let (_, assembled) = Assembled::of(model.clone()).map_err(Unanswered::Open)?;
    let at = |by: f64| -> Result<Arc<Model>, Unanswered> {
        let mut moved = description.clone();
        let fixed = |why: String| Unanswered::Fixed { address: parameter.address.clone(), why };
        parameter.set(&mut moved, value + by).map_err(fixed)?;
        let built = Model::build(&moved).map_err(|found| fixed(in_one_line(&found)))?;
        Ok(assembled.apply(built, &mut pose.to_vec()).map_err(Unanswered::Open)?.starting_at(pose))
    };
    let unit = bearers.as_large_again(&direction);
    let least = Some(least(parameter) - value).filter(|end| end.is_finite());
    let follows = Following { at: &at, settings, pose, pushed: &bearers.pushed, least };
    let ends = [false, true].map(|upwards| match follows.end(unit, upwards)? {
        Some(end) => Ok(end),
        None => as_held(bearers.supports.clone().limit(&bearers.load, &direction, upwards)?),
    });
    let [low, high]: [Result<Limit, Unanswered>; 2] = ends;
    Ok(between(description, parameter, low?, high?))
}

/// An end for which what follows the load was held where it is, as it finds no balance elsewhere: none says nothing.
fn as_held(limit: Limit) -> Result<Limit, Unanswered> {
    if limit.value.is_finite() { Ok(limit) } else { Err(Unanswered::Unbalanced { value: 0.0 }) }
}

/// What a number is at least: no mass is negative, whatever the balance would allow.
fn least(parameter: &Parameter) -> f64 {
    if parameter.field == Field::Mass { 0.0 } else { f64::NEG_INFINITY }
}

fn between(description: &Description, parameter: &Parameter, low: Limit, high: Limit) -> Interval {
    let value = parameter.value(description);
    Interval {
        name: parameter.address.clone(),
        range: [(value + low.value).max(least(parameter)), value + high.value],
        motions: [low.motion, high.motion],
    }
}

/// Values of a range that are nearer to each other than this part of it are one.
const ONE: f64 = 1e-6;

/// Where within a range a scene begins to stand only if it has been squeezed, of what bears without that.
fn squeezed(
    description: &Description,
    pose: &[f64],
    unsqueezed: &mut Bearers,
    parameter: &Parameter,
    range: &Interval,
) -> Vec<String> {
    let Ok(stands) = interval(description, pose, unsqueezed, parameter) else { return Vec::new() };
    let ([low, high], [least, most]) = (range.range, stands.range);
    let apart = |one: f64, other: f64| one != other && (one - other).abs() > ONE * one.abs().min(other.abs()).max(1e-9);
    let note = |way: &str, value: f64| {
        let value = significant(value, 4);
        format!("with `{}` {way} {value} it stands only if it has been squeezed (wedged)", parameter.address)
    };
    let low = (least > low && apart(least, low)).then(|| note("below", least));
    let high = (most < high && apart(most, high)).then(|| note("above", most));
    low.into_iter().chain(high).collect()
}

/// Beyond which tilt a scene begins to stand only if it has been squeezed.
fn squeezed_tilt(stands: Standing<'_>, unsqueezed: &Bearers, ends: &[(String, f64, Vec<f64>)]) -> Vec<String> {
    let Ok(without) = tilt(stands, unsqueezed) else { return Vec::new() };
    let mut notes = Vec::new();
    for ((way, own, _), (_, end, _)) in without.iter().zip(ends) {
        if end - own > ONE * own.max(1e-9) {
            let angle = significant(own.atan().to_degrees(), 4);
            notes.push(format!(
                "tilted by more than {angle}° towards {way} it stands only if it has been squeezed (wedged)"
            ));
        }
    }
    notes
}

/// How the load changes with a number.
fn direction(
    description: &Description,
    pose: &[f64],
    bearers: &Bearers,
    parameter: &Parameter,
) -> Result<Vec<f64>, Unanswered> {
    let value = parameter.value(description);
    let step = value.abs().max(1.0);
    let mut moved = description.clone();
    let fixed = |why: String| Unanswered::Fixed { address: parameter.address.clone(), why };
    parameter.set(&mut moved, value + step).map_err(fixed)?;
    let model = Model::build(&moved).map_err(|found| fixed(in_one_line(&found)))?;
    let changed = load(&model, pose)?;
    Ok(changed.iter().zip(&bearers.load).map(|(changed, load)| (changed - load) / step).collect())
}

/// With more supports than this two threads share the directions of a tilt: each program takes longer than a thread does to begin.
const MANY: usize = 200;

/// An axis across gravity, by name: the gravity that is added along it (m/s²) and how loads change with that.
type Axis<'a> = (&'a str, Vector3<f64>, Vec<f64>);

/// A horizontal load of `t` times the weight on everything, in the four directions of the inertial axes across gravity.
fn tilt(stands: Standing<'_>, bearers: &Bearers) -> Result<Vec<(String, f64, Vec<f64>)>, Unanswered> {
    let Standing { model, pose, settings, .. } = stands;
    let size = model.gravity.norm();
    if !(size > 0.0) {
        return Ok(Vec::new());
    }
    let down = model.gravity / size;
    let follows = bearers.pushed.iter().any(|pushed| !pushed);
    let mut axes = Vec::new();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate().filter(|(axis, _)| *axis != down.iamax()) {
        let along = Vector3::ith(axis, 1.0);
        let across = (along - down * down.dot(&along)).normalize() * size;
        let changed = load(&tilted(model, &across), pose)?;
        let direction: Vec<f64> = changed.iter().zip(&bearers.load).map(|(changed, load)| changed - load).collect();
        axes.push((name, across, direction));
    }
    let end = |across: &Vector3<f64>, direction: &[f64], upwards: bool| -> Result<Limit, Unanswered> {
        if follows {
            let at = |by: f64| Ok(tilted(model, &(across * by)));
            let follows = Following { at: &at, settings, pose, pushed: &bearers.pushed, least: None };
            if let Some(end) = follows.end(bearers.as_large_again(direction), upwards)? {
                return Ok(end);
            }
        }
        let limit = bearers.supports.clone().limit(&bearers.load, direction, upwards)?;
        if follows { as_held(limit) } else { Ok(limit) }
    };
    let both_ways = |(name, across, direction): &Axis<'_>| -> Result<Vec<(String, f64, Vec<f64>)>, Unanswered> {
        let ways = [("+", true), ("-", false)].map(|(sign, upwards)| {
            let limit = end(across, direction, upwards)?;
            Ok((format!("{sign}{name}"), limit.value.abs(), limit.motion))
        });
        ways.into_iter().collect()
    };
    let found: Result<Vec<_>, Unanswered> = match bearers.supports.len() > MANY {
        true => std::thread::scope(|scope| {
            let others: Vec<_> = axes[1..].iter().map(|axis| scope.spawn(|| both_ways(axis))).collect();
            let first = both_ways(&axes[0]);
            let joined =
                others.into_iter().map(|other| other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
            std::iter::once(first).chain(joined).collect()
        }),
        false => axes.iter().map(both_ways).collect(),
    };
    Ok(found?.concat())
}

/// The model with gravity changed by this (m/s²).
fn tilted(model: &Arc<Model>, by: &Vector3<f64>) -> Arc<Model> {
    let mut tilted = Model::clone(model);
    tilted.gravity += by;
    Arc::new(tilted)
}

/// Part of a range, or of its end where it has one, that a clamped value keeps from the end: at the end itself nothing is spared.
const SPARED: f64 = 1e-4;

/// The scene and its model with the unknown inputs at their own values, each clamped into the range that those before it leave,
/// those behind it being free; `None` if no values hold the pose.
pub(super) fn clamped(
    description: &Description,
    model: &Arc<Model>,
    settings: &Settings,
    pose: &[f64],
    unknown: &[Parameter],
) -> Result<Option<(Description, Arc<Model>)>, Unanswered> {
    let (_, assembled) = Assembled::of(model.clone()).map_err(Unanswered::Open)?;
    let at = |changed: &Description| -> Result<Arc<Model>, Unanswered> {
        let fixed = |found: Vec<Problem>| Unanswered::Open(in_one_line(&found));
        let built = Model::build(changed).map_err(fixed)?;
        Ok(assembled.apply(built, &mut pose.to_vec()).map_err(Unanswered::Open)?.starting_at(pose))
    };
    let (mut changed, mut now) = (description.clone(), at(description)?);
    for (k, parameter) in unknown.iter().enumerate() {
        let scene = Scene::new(&now, pose, settings.gap)?;
        let mut bearers = Bearers::new(&now, pose, &scene)?;
        for free in &unknown[k + 1..] {
            let direction = direction(&changed, pose, &bearers, free)?;
            bearers.free(&direction);
        }
        let range = match interval(&changed, pose, &mut bearers, parameter) {
            Ok(found) => found.range,
            Err(Unanswered::Undecided(_)) => return Ok(None),
            Err(other) => return Err(other),
        };
        let value = spared(parameter.value(&changed), range);
        let fixed = |why: String| Unanswered::Fixed { address: parameter.address.clone(), why };
        parameter.set(&mut changed, value).map_err(fixed)?;
        now = at(&changed)?;
    }
    Ok(Some((changed, now)))
}

/// A value clamped into a range, not quite to its ends.
fn spared(value: f64, [low, high]: [f64; 2]) -> f64 {
    let width = if (high - low).is_finite() { high - low } else { low.abs().min(high.abs()) };
    let (low, high) = (low + SPARED * width, high - SPARED * width);
    if low < high { value.clamp(low, high) } else { 0.5 * (low + high) }
}

/// The range of every unknown input, the others being free: they are supports that bear whatever they have to.
pub(super) fn inputs(
    description: &Description,
    model: &Arc<Model>,
    settings: &Settings,
    pose: &[f64],
    unknown: &[Parameter],
) -> Result<Vec<Interval>, Unanswered> {
    let scene = Scene::new(model, pose, settings.gap)?;
    let plain = Bearers::new(model, pose, &scene)?;
    let directions: Result<Vec<Vec<f64>>, Unanswered> =
        unknown.iter().map(|one| direction(description, pose, &plain, one)).collect();
    let directions = directions?;
    let mut found = Vec::new();
    for (k, parameter) in unknown.iter().enumerate() {
        let mut bearers = Bearers::new(model, pose, &scene)?;
        for (_, other) in directions.iter().enumerate().filter(|(other, _)| *other != k) {
            bearers.free(other);
        }
        match interval(description, pose, &mut bearers, parameter) {
            Ok(range) => found.push(range),
            // No value of it holds the pose.
            Err(Unanswered::Undecided(_)) => {}
            Err(other) => return Err(other),
        }
    }
    Ok(found)
}
