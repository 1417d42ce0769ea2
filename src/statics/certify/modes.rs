//! Undamped modes: their shapes, and whose motion they are.

use crate::model::Model;
use faer::Mat;

/// A direction in coordinate space, by the hinges that carry it.
#[derive(Debug, Clone, PartialEq)]
pub struct NaturalMode {
    /// Undamped frequency (Hz); 0 for a neutral one.
    pub frequency_hz: f64,
    /// Growth rate (1/s) of one that runs away, else 0.
    pub growth_rate: f64,
    /// Whether it swings, or stays, without damping: it may run away with damping that feeds it. One that does not grows without
    /// damping, or decays where its mirror image grows.
    pub swings: bool,
    /// Shape, one number per free coordinate, largest 1.
    pub shape: Vec<f64>,
    /// Bodies whose hinges carry it and their share of its kinetic energy, largest first.
    pub shares: Vec<(String, f64)>,
}

/// Frequency and growth rate of the `i`-th eigenvalue: the first ones run away, the next have zero stiffness.
pub(in crate::statics) fn rates_of(value: f64, i: usize, unstable: usize, neutral: usize) -> (f64, f64) {
    match i {
        i if i < unstable => (0.0, (-value).max(0.0).sqrt()),
        i if i < unstable + neutral => (0.0, 0.0),
        _ => (value.max(0.0).sqrt() / std::f64::consts::TAU, 0.0),
    }
}

/// Largest entry 1.
pub(in crate::statics) fn scaled(shape: &[f64]) -> Vec<f64> {
    let largest = shape.iter().fold(0.0_f64, |m, x| if x.abs() > m.abs() { *x } else { m });
    shape.iter().map(|x| x / largest).collect()
}

pub(in crate::statics) fn momentum(mass: &Mat<f64>, shape: &[f64]) -> Vec<f64> {
    let n = shape.len();
    (0..n).map(|row| (0..n).map(|j| mass[(row, j)] * shape[j]).sum()).collect()
}

/// Each hinge's share of a mode's kinetic energy, that of a beam of all its elements together; a coordinate may stand in several rows.
pub(in crate::statics) fn shares(model: &Model, free: &[usize], momentum: &[f64], shape: &[f64]) -> Vec<(String, f64)> {
    let mut owner: Vec<usize> = (0..model.bodies.len()).collect();
    for beam in &model.beams {
        let Some(last) = beam.elements.last() else { continue };
        beam.elements.iter().for_each(|element| owner[element.body] = last.body);
    }
    let mut of_body: Vec<Option<f64>> = vec![None; model.bodies.len()];
    for (row, at) in free.iter().enumerate() {
        *of_body[owner[model.coordinates[*at].body]].get_or_insert(0.0) += shape[row] * momentum[row];
    }
    let shares: Vec<(usize, f64)> =
        of_body.iter().enumerate().filter_map(|(body, part)| Some((body, (*part)?))).collect();
    let total: f64 = shares.iter().map(|(_, part)| part.abs()).sum();
    let mut sorted: Vec<(usize, f64)> = shares.into_iter().map(|(body, part)| (body, part.abs() / total)).collect();
    sorted.sort_by(|a, b| b.1.total_cmp(&a.1));
    sorted.into_iter().map(|(body, share)| (model.bodies[body].name.clone(), share)).collect()
}
