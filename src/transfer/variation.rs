//! The action of the tangent: how the inverse dynamics residual varies when coordinates, velocities and accelerations
//! vary in one direction. The transfer equations of [`super`], differentiated term by term; no reduced matrix is.
//!
//! ```text
//! body    δf_R = m (δr̈ + δω̇×c + ω̇×δc + δ(ω×(ω×c))),  δm_R = m (δc×(r̈−g) + c×δr̈) + δ(J ω̇) + δ(ω×J ω)
//!         with δc = δθ×c,  (δJ) y = δθ×(J y) − J (δθ×y)
//! arm     δm_P gains  δd × f + d × δf
//! row     turn: δ(n·m) = n·δm + (δθ_P×n)·m;   slide: the same of f;   screw: their sum with p f
//!         ball, in link axes: Rᵀ (δm − δθ×m)
//! ```

use super::balance::Balance;
use crate::element::{Rod, RodPoint, joined, row};
use crate::model::{Joint, Link, Model};
use crate::motion::variation::{Direction, LinkAcceleration, LinkVariation, modal_direction, outward, rod_direction};
use crate::motion::{LinkMotion, Motion};
use crate::pages::Pages;
use crate::spatial::Wrench;
use nalgebra::Vector3;
use std::ops::Range;

/// Scratch for the action of the tangent.
#[derive(Debug, Clone)]
pub struct Variation {
    /// Variations of the links' motion; written by [`Variation::outward`].
    pub links: Pages<LinkVariation>,
    /// Variations of the wrenches at the root markers.
    wrenches: Pages<Wrench>,
    /// Variations of the applied wrenches: filled in by whoever knows the forces, between the two sweeps.
    pub applied: Pages<Wrench>,
    /// Variations of the stations of one flexible element.
    stations: Vec<LinkVariation>,
}

impl Variation {
    /// Room for a model's links.
    pub fn new(model: &Model) -> Self {
        let n = model.links.len();
        let stations = model.rods.iter().map(|rod| rod.steps() + 1).max().unwrap_or(0);
        Self {
            links: Pages::filled(LinkVariation::default(), n),
            wrenches: Pages::filled(Wrench::ZERO, n),
            applied: Pages::filled(Wrench::ZERO, n),
            stations: vec![LinkVariation::default(); stations],
        }
    }

    /// Root → tips over all links.
    pub fn outward(&mut self, model: &Model, motion: &Motion, balance: &Balance, hinge: &[f64], by: &Direction<'_>) {
        outward(model, motion, &balance.accelerations, hinge, by, 1..model.links.len(), &mut self.links);
    }

    /// Root → tips over one subtree only; everything else must not vary.
    pub fn outward_subtree(
        &mut self,
        model: &Model,
        motion: &Motion,
        balance: &Balance,
        hinge: &[f64],
        by: &Direction<'_>,
        subtree: Range<usize>,
    ) {
        outward(model, motion, &balance.accelerations, hinge, by, subtree, &mut self.links);
    }

    /// Back to no variation on one subtree.
    pub fn clear(&mut self, subtree: Range<usize>) {
        self.links[subtree].fill(LinkVariation::default());
    }

    /// Tips → root over all links: `out ← δ(Hᵀ f + A q̈)`.
    pub fn inward(&mut self, model: &Model, motion: &Motion, balance: &Balance, by: &Direction<'_>, out: &mut [f64]) {
        for index in 1..model.links.len() {
            self.wrenches[index] = self.of_body(model, motion, balance, index);
        }
        for index in (1..model.links.len()).rev() {
            self.pass_on(model, motion, balance, by, index, out);
        }
    }

    /// Tips → root from one subtree: every other row is on the way to the root or does not vary.
    pub fn inward_subtree(
        &mut self,
        model: &Model,
        motion: &Motion,
        balance: &Balance,
        by: &Direction<'_>,
        subtree: Range<usize>,
        out: &mut [f64],
    ) {
        let root = subtree.start;
        for index in subtree.clone() {
            self.wrenches[index] = self.of_body(model, motion, balance, index);
        }
        let mut above = model.links[root].parent;
        while above != 0 {
            self.wrenches[above] = Wrench::ZERO;
            if let Some(modal) = model.links[above].joint.modal() {
                let others = model.modals[modal].links.iter().filter(|link| !subtree.contains(*link));
                others.for_each(|link| self.wrenches[*link] = Wrench::ZERO);
            }
            above = model.links[above].parent;
        }
        for index in subtree.rev() {
            self.pass_on(model, motion, balance, by, index, out);
        }
        let mut above = model.links[root].parent;
        while above != 0 {
            self.pass_on(model, motion, balance, by, above, out);
            above = model.links[above].parent;
        }
    }

    fn of_body(&self, model: &Model, motion: &Motion, balance: &Balance, index: usize) -> Wrench {
        let link = &model.links[index];
        if link.is_massless() {
            return Wrench::ZERO - self.applied[index];
        }
        let varied =
            vary_body(link, &motion.links[index], &balance.accelerations[index], &self.links[index], &model.gravity);
        varied - self.applied[index]
    }

    /// The row of one hinge, and what its link passes to the parent.
    #[inline]
    fn pass_on(
        &mut self,
        model: &Model,
        motion: &Motion,
        balance: &Balance,
        by: &Direction<'_>,
        index: usize,
        out: &mut [f64],
    ) {
        let (link, at, f) = (&model.links[index], &motion.links[index], &balance.reactions[index]);
        if let Some(modal) = link.joint.modal() {
            self.pass_modal(model, motion, balance, by, (index, modal), out);
        }
        if let Some(rod) = link.joint.rod() {
            let passed = self.pass_through(model, motion, balance, by, (index, rod), out);
            self.wrenches[link.parent] += passed;
            accelerate_armatures(model, link, by, out);
            return;
        }
        let (delta, first) = (self.wrenches[index], link.velocity);
        let axis_by = self.links[link.parent].turn.cross(&at.axis);
        let about = || at.axis.dot(&delta.moment) + axis_by.dot(&f.moment);
        let along = || at.axis.dot(&delta.force) + axis_by.dot(&f.force);
        match link.joint {
            // Of elements see `pass_through`.
            Joint::None | Joint::Flex { .. } | Joint::Along { .. } | Joint::Modal { .. } | Joint::Interface { .. } => {}
            Joint::Turn => out[first] = about(),
            Joint::Slide { .. } => out[first] = along(),
            Joint::Screw { pitch } => out[first] = about() + pitch * along(),
            Joint::Ball { .. } => {
                let row = at.turn.tr_mul(&(delta.moment - self.links[index].turn.cross(&f.moment)));
                out[first..first + 3].copy_from_slice(row.as_slice());
            }
        }
        accelerate_armatures(model, link, by, out);
        let mut passed = delta.shifted(at.arm);
        passed.moment += self.arm((link, index), at, by).cross(&f.force);
        self.wrenches[link.parent] += passed;
    }

    /// The rows of a modal body, from its own variation and that of what its interfaces pass; adds its wrench to that of its frame.
    #[inline(never)]
    fn pass_modal(
        &mut self,
        model: &Model,
        motion: &Motion,
        balance: &Balance,
        by: &Direction<'_>,
        (index, modal): (usize, usize),
        out: &mut [f64],
    ) {
        let (link, body, here) = (&model.links[index], &model.modals[modal], &motion.modals[modal]);
        let rows = &mut out[link.velocity..link.velocity + body.modal.count()];
        let (second, by) = (&balance.modals[modal][..], modal_direction(link, by));
        let state = (&motion.links[index], &model.gravity, &balance.accelerations[index]);
        self.wrenches[index] += here.vary(&body.modal, state, second, &self.links[index], by, rows);
        for ((tip, given), link) in here.tips.iter().zip(&body.modal.tips).zip(&body.links) {
            let (delta, f, turn) = (self.wrenches[*link], &balance.reactions[*link], self.links[*link].turn);
            let turned =
                Wrench { force: delta.force - turn.cross(&f.force), moment: delta.moment - turn.cross(&f.moment) };
            tip.rows(&turned).for_each(|(i, row)| rows[i] += row);
            if by[0].iter().any(|step| *step != 0.0) {
                tip.curvature(given, &motion.links[index], f, |i, j, entry| rows[i] += entry * by[0][j]);
            }
        }
    }

    /// The rows of a flexible element, and what its parent link gets: `δ(Zᵀ f) = Zᵀ δ'f + Γ δq` at every station, with
    /// `δ'f = δf − δθ × f` in axes that turn with it.
    #[inline(never)]
    fn pass_through(
        &mut self,
        model: &Model,
        motion: &Motion,
        balance: &Balance,
        by: &Direction<'_>,
        (index, rod): (usize, usize),
        out: &mut [f64],
    ) -> Wrench {
        let link = &model.links[index];
        let (given, at, felt) = (&model.rods[rod], &motion.rods[rod], &balance.rods[rod]);
        let second = &felt.second[..];
        let stations = &mut self.stations;
        let point =
            RodPoint { parent: &motion.links[link.parent], acceleration: &balance.accelerations[link.parent], second };
        let direction = rod_direction(link, by);
        at.vary(given, &point, &direction, &self.links[link.parent], |k, varied| stations[k] = *varied);
        let rows = &mut out[link.velocity..link.velocity + given.count()];
        rows.fill(0.0);
        let (last, mut delta) = (given.steps(), self.wrenches[index]);
        for k in (1..=last).rev() {
            let (station, varied, f) = (&at.stations[k].link, &self.stations[k], &felt.forces[k]);
            if k < last {
                delta += vary_slice(given, k, station, &felt.accelerations[k], varied);
            }
            let turned = Wrench {
                force: delta.force - varied.turn.cross(&f.force),
                moment: delta.moment - varied.turn.cross(&f.moment),
            };
            for (out, z) in rows.iter_mut().zip(at.subspace(k)) {
                *out += row(z, &turned);
            }
            if direction.position.iter().any(|step| *step != 0.0) {
                let local = at.local(given, k, second);
                let own = station.turn.transpose();
                let (force, moment) = (own * f.force, own * f.moment);
                let gradient = local.gradient(&joined(&force, &moment));
                for (i, out) in rows.iter_mut().enumerate() {
                    for (j, step) in direction.position.iter().enumerate().filter(|(_, step)| **step != 0.0) {
                        *out += local.curvature(&gradient, i, j) * step;
                    }
                }
            }
            delta = delta.shifted(station.arm);
            delta.moment += (varied.position - self.stations[k - 1].position).cross(&f.force);
        }
        let arm = self.stations[0].position - self.links[link.parent].position;
        let mut passed = delta.shifted(at.stations[0].link.arm);
        passed.moment += arm.cross(&felt.forces[0].force);
        passed
    }

    /// δd.
    #[inline]
    fn arm(&self, (link, index): (&Link, usize), at: &LinkMotion, by: &Direction<'_>) -> Vector3<f64> {
        let turned = self.links[link.parent].turn.cross(&at.arm);
        let per_coordinate = match link.joint {
            Joint::Slide { .. } => 1.0,
            Joint::Screw { pitch } => pitch,
            Joint::Interface { .. } => return self.links[index].position - self.links[link.parent].position,
            _ => return turned,
        };
        match by.position.get(link.velocity) {
            Some(step) => turned + at.axis * (per_coordinate * step),
            None => turned,
        }
    }
}

/// What the armatures of a hinge need for accelerations that vary.
fn accelerate_armatures(model: &Model, link: &Link, by: &Direction<'_>, out: &mut [f64]) {
    if !by.acceleration.is_empty() {
        for i in link.velocity..link.velocity + link.joint.counts().1 {
            out[i] += model.coordinates[i].armature * by.acceleration[i];
        }
    }
}

/// A slice inside a flexible element: as a body with its centre of mass at the station, less its load.
fn vary_slice(rod: &Rod, k: usize, at: &LinkMotion, a: &LinkAcceleration, by: &LinkVariation) -> Wrench {
    let (slice, w, dw) = (&rod.slices[k], at.angular_velocity, by.angular_velocity);
    let inertia_varied = |y: Vector3<f64>| by.turn.cross(&(at.inertia * y)) - at.inertia * by.turn.cross(&y);
    let mut force = slice.mass * by.acceleration;
    if rod.follows {
        force -= by.turn.cross(&rod.load_at(k, &at.turn));
    }
    let moment = inertia_varied(a.angular)
        + at.inertia * by.angular_acceleration
        + dw.cross(&(at.inertia * w))
        + w.cross(&(inertia_varied(w) + at.inertia * dw));
    Wrench { force, moment }
}

#[inline]
fn vary_body(link: &Link, at: &LinkMotion, a: &LinkAcceleration, by: &LinkVariation, gravity: &Vector3<f64>) -> Wrench {
    let (m, c, w) = (link.mass, at.center, at.angular_velocity);
    let dc = by.turn.cross(&c);
    let dw = by.angular_velocity;
    let inertia_varied = |y: Vector3<f64>| by.turn.cross(&(at.inertia * y)) - at.inertia * by.turn.cross(&y);
    let swing = dw.cross(&w.cross(&c)) + w.cross(&(dw.cross(&c) + w.cross(&dc)));
    let force = m * (by.acceleration + by.angular_acceleration.cross(&c) + a.angular.cross(&dc) + swing);
    let moment = m * (dc.cross(&(a.linear - gravity)) + c.cross(&by.acceleration))
        + inertia_varied(a.angular)
        + at.inertia * by.angular_acceleration
        + dw.cross(&(at.inertia * w))
        + w.cross(&(inertia_varied(w) + at.inertia * dw));
    Wrench { force, moment }
}
