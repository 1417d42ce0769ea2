//! Rigid stops and dry friction of hinges as supports of the cone problem, beside contacts.

use super::cone::Law;
use super::frame::{Column, along};
use super::pairs::Key;
use crate::dynamics::{Factorized, System};
use crate::model::{Model, Side, Stop, StopSide};
use crate::round_off::ON_A_LIMIT;
use nalgebra::Vector3;
use std::sync::Arc;

/// What bears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Id {
    /// Two features of two shapes.
    Contact(Key),
    /// A rigid stop.
    Stop(StopSide),
    /// Index of the dry friction of a hinge.
    Friction(usize),
}

/// A support: up to three rows of `J`, and the law of their forces.
#[derive(Debug, Clone)]
pub(crate) struct Support {
    pub(crate) id: Id,
    pub(crate) columns: [Column; 3],
    /// What a motion along the first row may use up (m or rad).
    pub(crate) gap: f64,
    pub(crate) law: Law,
    /// Of what slides, its law if it comes to rest, where that is another one.
    pub(crate) at_rest: Option<Law>,
}

impl Support {
    fn of_hinge(id: Id, first: usize, signs: &[f64], gap: f64, law: Law) -> Self {
        let column = |i: usize| signs.get(i).map_or_else(Vec::new, |sign| vec![(first + i, *sign)]);
        Self { id, columns: [column(0), column(1), column(2)], gap, law, at_rest: None }
    }

    /// How it slides: `J x` across a contact, all of it in a hinge.
    pub(crate) fn slid(&self, x: &[f64]) -> Vector3<f64> {
        let rates = self.rates(x);
        if let Id::Friction(_) = self.id { rates } else { Vector3::new(0.0, rates.y, rates.z) }
    }

    /// The scene's own speed across a contact, or that of a hinge (m/s or rad/s).
    pub(crate) fn speed(&self, model: &Model) -> f64 {
        match self.id {
            Id::Friction(index) => speed(model, model.hinge_friction[index].velocity),
            Id::Contact(_) | Id::Stop(_) => model.length_scale() / model.time_scale(),
        }
    }

    /// `J x`.
    pub(crate) fn rates(&self, x: &[f64]) -> Vector3<f64> {
        Vector3::from_fn(|i, _| along(&self.columns[i], x))
    }
}

/// The scene's own speed along a velocity coordinate (m/s or rad/s).
pub(crate) fn speed(model: &Model, velocity: usize) -> f64 {
    let unit = if model.lengths().any(|length| length == velocity) { model.length_scale() } else { 1.0 };
    unit / model.time_scale()
}

/// Puts coordinates that have passed rigid limits back on them: of trees each by itself, beside loops, drives and gears one after the other by
/// the shortest displacement that these allow, in the metric of the inertia.
pub(crate) fn within_limits(mass: &mut Factorized<'_>, q: &mut [f64]) {
    let model = Arc::clone(mass.system().model());
    let back = |stop: &Stop, q: &[f64]| q[stop.position].clamp(stop.range[0], stop.range[1]);
    let rigid = || model.stops.iter().filter(|stop| stop.is_rigid());
    if model.is_constrained() && rigid().any(|stop| back(stop, q) != q[stop.position]) {
        let (mut push, mut change) = (vec![0.0; model.velocity_count()], vec![0.0; model.velocity_count()]);
        for stop in rigid().filter(|stop| !model.coordinates[stop.velocity].lock) {
            let way = back(stop, q) - q[stop.position];
            if way == 0.0 {
                continue;
            }
            push[stop.velocity] = 1.0;
            mass.answer_impulse(&push, &mut change);
            push[stop.velocity] = 0.0;
            let own = change[stop.velocity];
            if own > 0.0 {
                change.iter_mut().for_each(|x| *x *= way / own);
                System::displace(&model, q, &change);
            }
        }
    }
    // What is left is rounding, or what loops and drives do not let go: the run looks at that.
    for stop in rigid() {
        let way = back(stop, q) - q[stop.position];
        if !model.is_constrained() || ON_A_LIMIT.hides(way, 1.0 + q[stop.position].abs()) {
            q[stop.position] += way;
        }
    }
}

/// Both limits of every rigid stop, and dry friction: what holds a hinge that is slower than `still` (parts of the scene's speeds),
/// or what it slides with.
pub(crate) fn supports(model: &Model, q: &[f64], v: &[f64], still: f64) -> Vec<Support> {
    let mut all = Vec::new();
    let is_free = |velocity: usize| !model.coordinates[velocity].lock;
    for (index, stop) in model.stops.iter().enumerate().filter(|(_, stop)| is_free(stop.velocity)) {
        if !stop.is_rigid() {
            continue;
        }
        let at = q[stop.position];
        for side in Side::ALL {
            let gap = side.of([at - stop.range[0], stop.range[1] - at]);
            if gap.is_finite() {
                let id = Id::Stop(StopSide { stop: index, at: side });
                let law = Law::Coulomb { stick: 0.0, slide: 0.0 };
                all.push(Support::of_hinge(id, stop.velocity, &[-side.sign()], gap, law));
            }
        }
    }
    for (index, own) in model.hinge_friction.iter().enumerate().filter(|(_, own)| is_free(own.velocity)) {
        let speed = v[own.velocity..own.velocity + own.count].iter().map(|v| v * v).sum::<f64>().sqrt();
        let [stick, slide] = [own.friction.stick, own.friction.slide].map(|bound| Law::Bounded { bound });
        let (rests, signs) = (speed <= still, [1.0; 3]);
        let (id, law) = (Id::Friction(index), if rests { stick } else { slide });
        let mut support = Support::of_hinge(id, own.velocity, &signs[..own.count], 0.0, law);
        support.at_rest = (!rests && own.friction.slide < own.friction.stick).then_some(stick);
        all.push(support);
    }
    all
}
