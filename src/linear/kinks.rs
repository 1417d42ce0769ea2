//! Places where forces have a kink: they have no derivative there, and what is computed is that of one side.
//!
//! ```text
//! (1)  A(h) = |f(+h) − 2 f(0) + f(−h)| / h    along one motion: proportional to h where f is smooth, constant at a kink
//! ```

use super::{Basis, Mat, Place, basis};
use crate::dynamics::{Fault, Linearization, System};
use crate::model::Model;
use std::sync::Arc;

/// The distance of (1), rad, parts of the scene's length, and these by its time; and how much shorter the second one is.
const FAR: f64 = 1e-4;
const SHORTER: f64 = 16.0;
/// What stays of (1) at a kink; of smooth forces a sixteenth does.
const STAYS: f64 = 0.5;
/// A kink by less than this part of the stiffness is round-off.
const SLIGHT: f64 = 1e-6;

/// Velocity coordinates that feel a kink at a place, of the positions and of the velocities.
pub(super) fn kinks(
    system: &mut System,
    place: &Place,
    a: &[f64],
    basis: &Basis,
    linear: &Linearization,
) -> Result<Vec<String>, Fault> {
    let model = Arc::clone(system.model());
    let n = a.len();
    let residual = |system: &mut System, q: &[f64], v: &[f64]| -> Result<Vec<f64>, Fault> {
        let mut residual = vec![0.0; n];
        system.at(place.time, q, v).residual(a, &mut residual)?;
        Ok(residual)
    };
    let here = residual(system, &place.position, &place.velocity)?;
    let mut felt = vec![false; n];
    for column in 0..basis.independent.len() {
        let along: Vec<f64> = (0..n).map(|i| basis.columns[(i, column)]).collect();
        let far = FAR * reach(&model, &along);
        for by_rate in [false, true] {
            let far = if by_rate { far / model.time_scale() } else { far };
            let apart = |system: &mut System, h: f64| -> Result<Vec<f64>, Fault> {
                let mut both = Vec::with_capacity(2);
                for h in [h, -h] {
                    let (mut q, mut v) = (place.position.clone(), place.velocity.clone());
                    match by_rate {
                        true => v.iter_mut().zip(&along).for_each(|(v, z)| *v += h * z),
                        false => {
                            let step: Vec<f64> = along.iter().map(|z| h * z).collect();
                            crate::motion::displace(&model, &mut q, &step);
                        }
                    }
                    both.push(residual(system, &q, &v)?);
                }
                Ok((0..n).map(|i| (both[0][i] - 2.0 * here[i] + both[1][i]).abs() / h).collect())
            };
            let (first, second) = (apart(system, far)?, apart(system, far / SHORTER)?);
            let of = if by_rate { &linear.damping } else { &linear.stiffness };
            let slope = |i: usize| size(of, i, &along).max(second[i]);
            for i in 0..n {
                // Round-off grows as the distance falls.
                let stays = second[i] > STAYS * first[i] && second[i] < first[i] / STAYS;
                felt[i] |= stays && second[i] > SLIGHT * slope(i);
            }
        }
    }
    Ok((0..n).filter(|i| felt[*i]).map(|i| basis::label(&model, i)).collect())
}

/// What a step along a motion is measured in: it moves a coordinate by 1 rad, or by the scene's length, at most.
fn reach(model: &Model, along: &[f64]) -> f64 {
    let mut unit = vec![1.0; along.len()];
    model.lengths().for_each(|i| unit[i] = model.length_scale());
    1.0 / along.iter().zip(&unit).map(|(z, unit)| (z / unit).abs()).fold(f64::MIN_POSITIVE, f64::max)
}

/// The size of the terms of a row of a matrix along a motion.
fn size(of: &Mat<f64>, row: usize, along: &[f64]) -> f64 {
    along.iter().enumerate().map(|(j, z)| (of[(row, j)] * z).abs()).sum()
}
