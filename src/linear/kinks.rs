//! Places where forces have a kink: they have no derivative there, and what is computed is that of one side.
//!
//! ```text
//! (1)  A(h) = |f(+h) − 2 f(0) + f(−h)| / h    along one motion: proportional to h where f is smooth, constant at a kink
//! ```

use super::{Basis, Mat, Place, basis};
use crate::dynamics::{Fault, Linearization, System};
use crate::model::Model;
use crate::round_off::LOAD;
use std::sync::Arc;

/// The distances of (1): the first, rad, parts of the scene's length, and these by its time; and how much shorter each one is than the last.
const FAR: f64 = 1e-4;
const SHORTER: f64 = 4.0;
const DISTANCES: usize = 3;
/// At a kink (1) changes by no more than this part from one to the next; of smooth forces it falls to a fourth.
const STAYS: f64 = 0.2;
/// A kink by less than this part of the stiffness is none.
const SLIGHT: f64 = 1e-4;

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
    // What (1) is by round-off at distance 1: of the terms that cancel.
    let mut scratch = vec![0.0; n];
    let terms = system.at(place.time, &place.position, &place.velocity).residual(a, &mut scratch)?.magnitudes().force;
    let noise: Vec<f64> = terms.iter().map(|size| LOAD.of(*size)).collect();
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
            let mut shorter = far;
            let mut levels = Vec::with_capacity(DISTANCES);
            for _ in 0..DISTANCES {
                levels.push((shorter, apart(system, shorter)?));
                shorter /= SHORTER;
            }
            let of = if by_rate { &linear.damping } else { &linear.stiffness };
            for i in 0..n {
                let stays = levels.windows(2).all(|two| (two[1].1[i] - two[0].1[i]).abs() <= STAYS * two[0].1[i]);
                let (distance, last) = (levels[DISTANCES - 1].0, levels[DISTANCES - 1].1[i]);
                let least = (SLIGHT * size(of, i, &along)).max(noise[i] / distance);
                felt[i] |= stays && last > least;
            }
        }
    }
    Ok((0..n).filter(|i| felt[*i]).map(|i| basis::label(&model, i)).collect())
}

/// What a step along a motion is measured in: it moves a coordinate by 1 rad, or by the scene's length, at most.
pub(super) fn reach(model: &Model, along: &[f64]) -> f64 {
    let mut unit = vec![1.0; along.len()];
    model.lengths().for_each(|i| unit[i] = model.length_scale());
    1.0 / along.iter().zip(&unit).map(|(z, unit)| (z / unit).abs()).fold(f64::MIN_POSITIVE, f64::max)
}

/// The size of the terms of a row of a matrix along a motion.
fn size(of: &Mat<f64>, row: usize, along: &[f64]) -> f64 {
    along.iter().enumerate().map(|(j, z)| (of[(row, j)] * z).abs()).sum()
}
