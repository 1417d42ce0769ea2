//! Inverse dynamics: the hinge forces that given accelerations would need, and the reactions that go with them.

use super::flexible::RodBalance;
use super::plan::{has_light_links, has_outweighed_links};
use super::{LinkAcceleration, accelerate, inboard, lever};
use crate::model::{Joint, Model};
use crate::motion::Motion;
use crate::pages::Pages;
use crate::spatial::Wrench;
use crate::spatial::quad::{Columns, Quad, wrench};

/// What every link does and passes on for given hinge accelerations.
#[derive(Debug, Clone)]
pub struct Balance {
    /// Accelerations of the root markers.
    pub accelerations: Pages<LinkAcceleration>,
    /// What the inboard hinge passes to each link at its root marker; entry 0 is what the ground has to hold.
    pub reactions: Pages<Wrench>,
    /// What the stations of flexible elements do and pass on.
    pub rods: Vec<RodBalance>,
    /// Whether some links carry bodies that are far heavier.
    is_light: bool,
    /// Whether some carry bodies that are a thousand times heavier, or more.
    is_outweighed: bool,
    /// Second rates of the coordinates of modal bodies.
    pub modals: Vec<Vec<f64>>,
}

impl Balance {
    /// Room for a model's links.
    pub fn new(model: &Model) -> Self {
        let n = model.links.len();
        Self {
            accelerations: Pages::filled(LinkAcceleration::default(), n),
            reactions: Pages::filled(Wrench::ZERO, n),
            rods: model.rods.iter().map(RodBalance::new).collect(),
            is_light: has_light_links(model),
            is_outweighed: has_outweighed_links(model),
            modals: model.modals.iter().map(|modal| vec![0.0; modal.modal.count()]).collect(),
        }
    }

    /// Whether some links carry bodies that are a thousand times heavier, or more.
    pub fn is_outweighed(&self) -> bool {
        self.is_outweighed
    }

    /// Root → tips by eq. (2), tips → root by eq. (1); `residual ← Hᵀ f + A q̈ − τ`, which vanishes for the true
    /// accelerations (eq. (3)).
    pub fn update(
        &mut self,
        model: &Model,
        motion: &Motion,
        applied: &[Wrench],
        tau: &[f64],
        hinge: &[f64],
        residual: &mut [f64],
    ) {
        self.outward(model, motion, applied, hinge);
        self.inward(model, motion, hinge, residual);
        for (at, coordinate) in model.coordinates.iter().enumerate() {
            residual[at] += coordinate.armature * hinge[at] - tau[at];
        }
    }
    /// Root → tips: eq. (2), and what each link needs on its own by eq. (1).
    #[inline(always)]
    fn outward(&mut self, model: &Model, motion: &Motion, applied: &[Wrench], hinge: &[f64]) {
        self.reactions[0] = Wrench::ZERO - applied[0];
        let g = Quad::of(&model.gravity);
        let mut before = LinkAcceleration::default();
        for (index, (link, at)) in model.links.iter().zip(&motion.links).enumerate().skip(1) {
            // Along a chain the parent's acceleration is still in registers.
            let parent = if link.parent + 1 == index { before } else { self.accelerations[link.parent] };
            let mut a = inboard(at, &parent, true);
            accelerate(link, at, motion, hinge, &mut a);
            self.accelerations[index] = a;
            before = a;
            let (mass, J) = (Quad::all(link.mass), Columns::symmetric(&at.inertia));
            let (w, c) = (Quad::of(&at.angular_velocity), Quad::of(&at.center));
            let (linear, angular) = (Quad::of(&a.linear), Quad::of(&a.angular));
            // In the same form as the velocity terms of the arms: where the two cancel, so does their round-off.
            let swing = w.cross(w.cross(c)) - g;
            let force = mass * (angular.cross_add(c, linear) + swing);
            let turning = J.times_add(&a.angular, c.cross(mass * linear));
            let moment = turning + w.cross_add(J.times(&at.angular_velocity), g.cross(mass * c));
            self.reactions[index] = wrench(force, moment) - applied[index];
            if let Joint::Modal { modal, count } = link.joint {
                let second = &hinge[link.velocity..link.velocity + count];
                let body = &model.modals[modal].modal;
                self.reactions[index] += motion.modals[modal].wrench(body, Some(&model.gravity), &a, second);
            }
        }
    }

    /// Tips → root: eqs. (1) and (3).
    #[inline(always)]
    fn inward(&mut self, model: &Model, motion: &Motion, hinge: &[f64], residual: &mut [f64]) {
        let mut carried = (Quad::default(), Quad::default());
        for index in (1..model.links.len()).rev() {
            let (link, at) = (&model.links[index], &motion.links[index]);
            let f = self.reactions[index];
            let (mut force, mut moment) = (Quad::of(&f.force) + carried.0, Quad::of(&f.moment) + carried.1);
            let f = wrench(force, moment);
            self.reactions[index] = f;
            match link.joint {
                Joint::None | Joint::Interface { .. } => {}
                Joint::Modal { modal, count } => {
                    let own = link.velocity..link.velocity + count;
                    let (body, here) = (&model.modals[modal], &motion.modals[modal]);
                    let (a, rows) = (&self.accelerations[index], &mut residual[own.clone()]);
                    self.modals[modal].copy_from_slice(&hinge[own.clone()]);
                    here.rows(&body.modal, Some(&model.gravity), a, &hinge[own], rows);
                    here.pull(body.links.iter().map(|link| &self.reactions[*link]), rows);
                }
                Joint::Turn => residual[link.velocity] = Quad::of(&at.axis).dot(moment),
                Joint::Slide { .. } => residual[link.velocity] = Quad::of(&at.axis).dot(force),
                Joint::Screw { pitch } => {
                    let n = Quad::of(&at.axis);
                    residual[link.velocity] = n.dot(moment) + pitch * n.dot(force);
                }
                Joint::Ball { .. } => {
                    let row = at.turn.tr_mul(&f.moment);
                    residual[link.velocity..link.velocity + 3].copy_from_slice(row.as_slice());
                }
                Joint::Flex { rod, .. } | Joint::Along { rod } => {
                    let own = link.velocity..link.velocity + link.joint.counts().1;
                    let given = (&model.rods[rod], &motion.rods[rod]);
                    let (parent, rows) = (&self.accelerations[link.parent], &mut residual[own.clone()]);
                    let passed = self.rods[rod].inward(given, &model.gravity, parent, &hinge[own], &f, rows);
                    // As seen at the tip.
                    let passed = passed.shifted(-at.arm);
                    (force, moment) = (Quad::of(&passed.force), Quad::of(&passed.moment));
                }
            }
            carried = match self.is_light {
                false => (force, Quad::of(&at.arm).cross_add(force, moment)),
                true => (force, moment + Quad::of(&lever(&at.arm, &force.vector()))),
            };
            if link.parent + 1 != index {
                self.reactions[link.parent] += wrench(carried.0, carried.1);
                carried = (Quad::default(), Quad::default());
            }
        }
        self.reactions[0] += wrench(carried.0, carried.1);
    }
}
