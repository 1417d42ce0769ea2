//! Kinks of forces at a place: springs by tables, motors by formulas and ropes that have another stiffness on either side of it.
//!
//! A law of one hinge says its slope itself, a little to either side; the law of a force between points is kept on the two sides of
//! its boundary, and the stiffness of the scene differs by one motion:
//!
//! ```text
//! (1)  K₊ − K₋ = κ a aᵀ,   a = the largest column of it, over the root of its entry on the diagonal
//! ```

use super::bearing::unit;
use super::sides::{Beyond, Sided};
use super::stability::MOST_DENSE;
use crate::dynamics::{Fault, System};
use crate::force::Act;
use crate::model::{CurveOver, Model};
use std::sync::Arc;

/// How far from a place a kink is at it (rad, or part of the scene's length): a search that ends on one knows it to no more than
/// its balance, ten digits of the forces.
const AT: f64 = 1e-9;
/// A kink by less than this part of the stiffness is none.
const SLIGHT: f64 = 1e-6;
/// At a kink slopes differ by more than this part at half the distance of what they do at the whole: of a smooth law by half.
const STAYS: f64 = 0.75;
/// How far a step goes that shows which way leads above a boundary (rad, m).
const RISE: f64 = 1e-4;

/// The kinks at a position.
///
/// # Errors
/// The element whose numbers are not finite.
pub(super) fn at(model: &Arc<Model>, q: &[f64]) -> Result<Vec<Sided>, Fault> {
    let mut found = of_hinges(model, q);
    found.extend(of_forces(model, q)?);
    Ok(found)
}

fn of_hinges(model: &Model, q: &[f64]) -> Vec<Sided> {
    let curves = model.curves.iter().filter(|curve| curve.over == CurveOver::Position).map(|curve| curve.coordinate);
    let motors = model.motors.iter().filter(|motor| motor.is_of_place()).map(|motor| motor.coordinate);
    let mut all: Vec<(usize, usize)> = curves.chain(motors).map(|at| (at.velocity, at.position)).collect();
    all.sort_unstable();
    all.dedup();
    let kink = |(velocity, position): (usize, usize)| {
        let slope = |value: f64| {
            let here = |at: &(usize, usize)| *at == (velocity, position);
            let curves = model.curves.iter().filter(|curve| curve.over == CurveOver::Position);
            let curves = curves.filter(|curve| here(&(curve.coordinate.velocity, curve.coordinate.position)));
            let motors =
                model.motors.iter().filter(|motor| here(&(motor.coordinate.velocity, motor.coordinate.position)));
            curves.map(|curve| curve.table.value(value - curve.rest)[1]).sum::<f64>()
                - motors.map(|motor| motor.at(0.0, value, 0.0).by_position).sum::<f64>()
        };
        let (here, far) = (q[position], AT * unit(model, velocity));
        let [below, above] = [here - far, here + far].map(slope);
        let nearer = slope(here + 0.5 * far) - slope(here - 0.5 * far);
        let is_kink = (above - below).abs() > SLIGHT * (below.abs() + above.abs())
            && nearer.abs() > STAYS * (above - below).abs();
        let now = slope(here);
        (is_kink && now.is_finite()).then(|| Sided {
            row: vec![(velocity, 1.0)],
            beyond: Beyond::Stiffness([below - now, above - now]),
            is_kink: true,
            name: model.label(velocity),
        })
    };
    all.into_iter().filter_map(kink).collect()
}

fn of_forces(model: &Arc<Model>, q: &[f64]) -> Result<Vec<Sided>, Fault> {
    let rest = vec![0.0; model.velocity_count()];
    let mut found = Vec::new();
    if rest.len() > MOST_DENSE || model.forces.iter().all(|force| force.law.boundaries() == [None; 4]) {
        return Ok(found);
    }
    let links = System::new(model).at(0.0, q, &rest).motion().links.clone();
    for (index, force) in model.forces.iter().enumerate() {
        let mut kept = force.law.clone();
        kept.keep(&links);
        for boundary in kept.boundaries().into_iter().flatten() {
            let switch = kept.switch(boundary, &links);
            if switch.is_speed || !(switch.value.abs() <= AT * model.length_scale()) {
                continue;
            }
            let mut crossed = kept.clone();
            crossed.cross(boundary);
            let is_above = kept.side(boundary);
            let with = |law: &crate::force::Law| {
                let mut other = Model::clone(model);
                let mut forces = other.forces.to_vec();
                forces[index].law = law.clone();
                other.forces = forces.into();
                System::new(&Arc::new(other)).at(0.0, q, &rest).stiffness()
            };
            let [here, there] = [with(&kept)?, with(&crossed)?];
            let difference = |i: usize, j: usize| there[(i, j)] - here[(i, j)];
            let by_size = |i: &usize, j: &usize| difference(*i, *i).abs().total_cmp(&difference(*j, *j).abs());
            let Some(largest) = (0..rest.len()).max_by(by_size) else { continue };
            let jump = difference(largest, largest);
            if !(jump.abs() > SLIGHT * (here[(largest, largest)].abs() + there[(largest, largest)].abs())) {
                continue;
            }
            // (1), turned so that it leads above the boundary.
            let along: Vec<f64> = (0..rest.len()).map(|i| difference(i, largest) / jump).collect();
            let mut beside = q.to_vec();
            let size = along.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            let step: Vec<f64> = along.iter().map(|x| RISE * x / size).collect();
            crate::motion::displace(model, &mut beside, &step);
            let after = System::new(model).at(0.0, &beside, &rest).motion().links.clone();
            let sign = if kept.switch(boundary, &after).value < switch.value { -1.0 } else { 1.0 };
            let row = along.iter().enumerate().filter(|(_, x)| **x != 0.0).map(|(i, x)| (i, sign * x)).collect();
            let both = if is_above { [jump, 0.0] } else { [0.0, jump] };
            found.push(Sided {
                row,
                beyond: Beyond::Stiffness(both),
                is_kink: true,
                name: format!("`{}`", force.name),
            });
        }
    }
    Ok(found)
}
