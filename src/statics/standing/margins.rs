//! How far a number of the scene may go, and how far it may be tilted, while the pose stands.

use super::supports::{Bearers, load};
use super::{Margin, Unanswered};
use crate::model::{Description, Model, Parameter};
use nalgebra::Vector3;

/// A range of values within which a pose stands, and how it gives way at both ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Interval {
    /// What moves.
    pub name: String,
    /// Lowest and highest value; infinite if nothing gives way.
    pub range: [f64; 2],
    /// Hinge velocities of the mechanism at each end; empty if nothing gives way.
    pub motions: [Vec<f64>; 2],
}

/// All ranges that were asked for.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Margins {
    /// Of numbers of the scene, by address.
    pub numbers: Vec<Interval>,
    /// Horizontal load in parts of the weight, by direction (`+x`, `-y`, …), and the mechanism there.
    pub tilt: Vec<(String, f64, Vec<f64>)>,
    /// Of inputs that are unknown: the range of each, the others being free.
    pub inputs: Vec<Interval>,
}

pub(super) fn margins(
    description: &Description,
    model: &Model,
    asked: &Margin,
    pose: &[f64],
    bearers: &Bearers,
) -> Result<Margins, Unanswered> {
    let mut margins = Margins::default();
    for parameter in &asked.numbers {
        margins.numbers.push(interval(description, pose, bearers, parameter)?);
    }
    if asked.tilt {
        margins.tilt = tilt(model, pose, bearers)?;
    }
    Ok(margins)
}

/// The range of a number: loads are affine in it, so that a difference is its direction.
fn interval(
    description: &Description,
    pose: &[f64],
    bearers: &Bearers,
    parameter: &Parameter,
) -> Result<Interval, Unanswered> {
    let value = parameter.value(description);
    let direction = direction(description, pose, bearers, parameter)?;
    let [low, high] = [false, true].map(|upwards| bearers.supports.limit(&bearers.load, &direction, upwards));
    let (low, high) = (low?, high?);
    Ok(Interval {
        name: parameter.address.clone(),
        range: [value + low.value, value + high.value],
        motions: [low.motion, high.motion],
    })
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
    parameter.set(&mut moved, value + step);
    let Ok(model) = Model::build(&moved) else { return Ok(vec![0.0; bearers.load.len()]) };
    let changed = load(&model, pose)?;
    Ok(changed.iter().zip(&bearers.load).map(|(changed, load)| (changed - load) / step).collect())
}

/// A horizontal load of `t` times the weight on everything, in the four directions of the inertial axes across gravity.
fn tilt(model: &Model, pose: &[f64], bearers: &Bearers) -> Result<Vec<(String, f64, Vec<f64>)>, Unanswered> {
    let size = model.gravity.norm();
    if !(size > 0.0) {
        return Ok(Vec::new());
    }
    let down = model.gravity / size;
    let mut found = Vec::new();
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate().filter(|(axis, _)| *axis != down.iamax()) {
        let along = Vector3::ith(axis, 1.0);
        let across = (along - down * down.dot(&along)).normalize();
        let mut tilted = model.clone();
        tilted.gravity += across * size;
        let changed = load(&tilted, pose)?;
        let direction: Vec<f64> = changed.iter().zip(&bearers.load).map(|(changed, load)| changed - load).collect();
        for (sign, upwards) in [("+", true), ("-", false)] {
            let limit = bearers.supports.limit(&bearers.load, &direction, upwards)?;
            found.push((format!("{sign}{name}"), limit.value.abs(), limit.motion));
        }
    }
    Ok(found)
}
