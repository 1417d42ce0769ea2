//! Floating parts: what neither the ground nor a force from outside holds is left where it was as a whole.
//!
//! Bodies that are joined to each other and not to the ground have equilibria all along the rigid motions that their hinges on the
//! ground allow. A search steps where its forces lead, in a metric that is not the mass, and carries them along. Of these equilibria the
//! one is given that is the least mass-weighted distance from the guess,
//!
//! ```text
//! min ∫ |R (x − C) + C₀ − x₀|² dm:    R = V diag(1, 1, det V Uᵀ) Uᵀ,    ∫ (x − C)(x₀ − C₀)ᵀ dm = U S Vᵀ         (1)
//! ```
//!
//! (Kabsch 1976): the centre of mass stays, and so does the mean orientation, as in a motion that keeps its momentum. It is the
//! search's own equilibrium, moved as one. If something holds a part along some directions, it moves along the others alone; it does
//! not turn beside gravity and loads that keep their direction, nor if its mass is on one line.

use crate::dynamics::{Fault, System};
use crate::force::Act;
use crate::model::Model;
use crate::motion::Motion;
use crate::statics::problem::Landscape;
use crate::statics::problem::parts::joined;
use crate::statics::problem::place::Place;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use std::sync::Arc;

/// Cosines and second moments (beside the largest) below this are zero: an axis is free of what holds a part, a part is a line.
const FREE: f64 = 1e-9;

/// A balanced place with its floating parts where they were in the guess, if it is balanced there too.
///
/// # Errors
/// The element whose numbers are not finite.
pub(super) fn left_in_place(landscape: &mut Landscape<'_>, guess: &[f64], place: Place) -> Result<Place, Fault> {
    let model = &Arc::clone(landscape.model());
    if !place.is_balanced() || place.q == guess || !model.contacts.is_empty() {
        return Ok(place);
    }
    let parts = floating(model);
    if parts.is_empty() {
        return Ok(place);
    }
    let rest = landscape.steady.clone();
    let mut motion_of = |q: &[f64]| landscape.system().at(0.0, q, &rest).motion().clone();
    let [from, to] = [motion_of(guess), motion_of(&place.q)];
    let mut step = vec![0.0; rest.len()];
    parts.iter().for_each(|part| part.back(model, &from, &to, &mut step));
    let mut q = place.q.clone();
    System::displace(model, &mut q, &step);
    let moved = Place::at(landscape, q)?;
    Ok(if moved.is_balanced() { moved } else { place })
}

/// What carries a part on the ground.
struct Carrier {
    /// Links of slides that nothing holds, from the ground on.
    slides: Vec<usize>,
    /// The ball behind three of them.
    ball: Option<usize>,
}

/// Links that are joined to each other and not to the ground.
struct Part {
    links: Vec<usize>,
    carriers: Vec<Carrier>,
    /// Whether it is the same turned as a whole.
    turns: bool,
}

/// The parts of a model that no element joins to the ground.
fn floating(model: &Model) -> Vec<Part> {
    let of = parts(model);
    let bound = bound(model);
    let mut loaded = vec![false; model.links.len()];
    model
        .forces
        .iter()
        .filter_map(|force| force.law.dead())
        .for_each(|(link, load)| loaded[of[link]] |= load.norm() > 0.0);
    let mut parts: Vec<Part> = Vec::new();
    let mut place = vec![usize::MAX; model.links.len()];
    for (index, link) in model.links.iter().enumerate().skip(1).filter(|(index, _)| of[*index] != of[0]) {
        if place[of[index]] == usize::MAX {
            place[of[index]] = parts.len();
            let turns = model.gravity.norm() == 0.0 && !loaded[of[index]];
            parts.push(Part { links: Vec::new(), carriers: Vec::new(), turns });
        }
        let part = &mut parts[place[of[index]]];
        part.links.push(index);
        if link.parent == 0 {
            part.carriers.push(carrier(model, &bound, index));
        }
    }
    parts.retain(|part| part.carriers.iter().all(|carrier| !carrier.slides.is_empty()));
    parts
}

/// Per link the first of those that it is joined to, by hinges, force elements, loops and gears; hinges on the ground do not count.
fn parts(model: &Model) -> Vec<usize> {
    let inner = model.links.iter().enumerate().skip(1).filter(|(_, link)| link.parent != 0);
    let hinges = inner.map(|(index, link)| [index, link.parent]);
    let forces =
        model.forces.iter().flat_map(|force| force.law.ends().windows(2).map(|pair| [pair[0].link, pair[1].link]));
    let loops = model.loops.iter().map(|closed| [closed.ends[0].link, closed.ends[1].link]);
    let gears = model.gears.iter().map(|gear| gear.coordinates.map(|one| one.link));
    joined(model.links.len(), hinges.chain(forces).chain(loops).chain(gears))
}

/// Per velocity coordinate whether something of its own holds or pushes it.
fn bound(model: &Model) -> Vec<bool> {
    let own = model.coordinates.iter().map(|one| one.lock || one.stiffness != 0.0 || one.force != 0.0);
    let mut bound: Vec<bool> = own.collect();
    let driven = model.drives.iter().map(|drive| drive.coordinate.velocity);
    let geared = model.gears.iter().flat_map(|gear| gear.coordinates.map(|one| one.velocity));
    let pushed = model.pushed().map(|one| one.velocity);
    let stopped = model.stops.iter().map(|stop| stop.velocity);
    driven.chain(geared).chain(pushed).chain(stopped).for_each(|velocity| bound[velocity] = true);
    bound
}

/// What carries the links behind a link on the ground.
fn carrier(model: &Model, bound: &[bool], first: usize) -> Carrier {
    let (mut slides, mut next) = (Vec::new(), Some(first));
    let is_free = |index: usize| {
        let (from, count) = (model.links[index].velocity, model.links[index].joint.counts().1);
        !bound[from..from + count].contains(&true)
    };
    while let Some(index) = next.filter(|index| model.links[*index].joint.is_slide() && is_free(*index)) {
        slides.push(index);
        let mut carried = (index + 1..model.links[index].subtree_end).filter(|at| model.links[*at].parent == index);
        next = carried.next().filter(|_| carried.next().is_none());
    }
    let ball = next.filter(|index| slides.len() == 3 && model.links[*index].joint.is_ball() && is_free(*index));
    Carrier { slides, ball }
}

/// Mass, centre of mass and `∫ x x₀ᵀ dm` of some links in two positions.
struct Moments {
    centers: [Vector3<f64>; 2],
    /// About the centres.
    mixed: Matrix3<f64>,
}

impl Part {
    /// The moments at two positions, the first being the later; `None` without mass.
    fn moments(&self, model: &Model, now: &Motion, before: &Motion) -> Option<Moments> {
        let (mut mass, mut sums, mut mixed) = (0.0, [Vector3::zeros(); 2], Matrix3::zeros());
        for index in &self.links {
            let (m, [x, y]) = (model.links[*index].mass, [&now.links[*index], &before.links[*index]]);
            mass += m;
            sums[0] += m * (x.position + x.center);
            sums[1] += m * (y.position + y.center);
            let about = x.inertia.matrix();
            let second = Matrix3::from_diagonal_element(0.5 * about.trace()) - about;
            mixed += m
                * (x.position * y.position.transpose()
                    + x.position * y.center.transpose()
                    + x.center * y.position.transpose())
                + second * x.turn * y.turn.transpose();
        }
        let centers = sums.map(|sum| sum / mass);
        mixed -= mass * centers[0] * centers[1].transpose();
        (mass > 0.0).then_some(Moments { centers, mixed })
    }

    /// Adds the motion of (1), from a later position to where the part was.
    fn back(&self, model: &Model, from: &Motion, to: &Motion, step: &mut [f64]) {
        let Some(Moments { centers: [now, before], mixed }) = self.moments(model, to, from) else { return };
        let turn =
            if self.turns && self.carriers.iter().all(|one| one.ball.is_some()) { nearest(&mixed) } else { None };
        let allowed = self.allowed(to);
        for carrier in &self.carriers {
            let axes: Vec<Vector3<f64>> = carrier.slides.iter().map(|link| to.links[*link].axis).collect();
            let by = match turn.zip(carrier.ball) {
                Some((turn, ball)) => {
                    let at = to.links[ball].position;
                    let by = turn.scaled_axis();
                    let own = to.links[ball].turn.tr_mul(&by);
                    let first = model.links[ball].velocity;
                    (0..3).for_each(|i| step[first + i] += own[i]);
                    turn * (at - now) + before - at
                }
                None => allowed * (before - now),
            };
            let square: Matrix3<f64> = axes.iter().map(|axis| axis * axis.transpose()).sum();
            let Ok(inverse) = square.pseudo_inverse(FREE) else { continue };
            for (link, axis) in carrier.slides.iter().zip(&axes) {
                step[model.links[*link].velocity] += axis.dot(&(inverse * by));
            }
        }
    }

    /// The projector on the directions that all carriers allow.
    fn allowed(&self, motion: &Motion) -> Matrix3<f64> {
        let across = |carrier: &Carrier| {
            let axes = carrier.slides.iter().map(|link| motion.links[*link].axis);
            let square: Matrix3<f64> = axes.map(|axis| axis * axis.transpose()).sum();
            square
                .pseudo_inverse(FREE)
                .map_or_else(|_| Matrix3::identity(), |inverse| Matrix3::identity() - square * inverse)
        };
        let held: Matrix3<f64> = self.carriers.iter().map(across).sum();
        let eigen = held.symmetric_eigen();
        let free =
            (0..3).filter(|k| eigen.eigenvalues[*k].abs() < FREE).map(|k| eigen.eigenvectors.column(k).into_owned());
        free.map(|axis: Vector3<f64>| axis * axis.transpose()).sum()
    }
}

/// `R` of (1); `None` for mass on one line.
fn nearest(mixed: &Matrix3<f64>) -> Option<UnitQuaternion<f64>> {
    let svd = mixed.svd(true, true);
    let (u, v) = (svd.u?, svd.v_t?.transpose());
    let least = (0..3).min_by(|a, b| svd.singular_values[*a].total_cmp(&svd.singular_values[*b]))?;
    let largest = svd.singular_values.max();
    let many = svd.singular_values.iter().filter(|value| **value > FREE * largest).count();
    let mut signs = Vector3::repeat(1.0);
    signs[least] = (v * u.transpose()).determinant().signum();
    let turn = v * Matrix3::from_diagonal(&signs) * u.transpose();
    (many >= 2).then(|| UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(turn)))
}
