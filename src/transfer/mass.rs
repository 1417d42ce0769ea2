//! The action of the mass matrix: hinge forces for hinge accelerations alone, without weight, velocities or forces.

use super::flexible::RodBalance;
use super::{LinkAcceleration, accelerate, along, inboard};
use crate::model::{Joint, Model};
use crate::motion::Motion;
use crate::spatial::Wrench;

/// Scratch for `M x`.
#[derive(Debug, Clone)]
pub struct MassAction {
    a: Vec<LinkAcceleration>,
    f: Vec<Wrench>,
    rods: Vec<RodBalance>,
}

impl MassAction {
    /// Room for a model's links.
    pub fn new(model: &Model) -> Self {
        let n = model.links.len();
        let rods = model.rods.iter().map(RodBalance::new).collect();
        Self { a: vec![LinkAcceleration::default(); n], f: vec![Wrench::ZERO; n], rods }
    }

    /// `product ← M x`, armatures included: eq. (2) root → tips, eq. (1) tips → root, without their velocity terms.
    pub fn times(&mut self, model: &Model, motion: &Motion, x: &[f64], product: &mut [f64]) {
        self.f[0] = Wrench::ZERO;
        for index in 1..model.links.len() {
            let (link, at) = (&model.links[index], &motion.links[index]);
            let mut a = inboard(at, &self.a[link.parent], false);
            accelerate(link, at, motion, x, &mut a);
            if let Joint::Modal { modal, count } = link.joint {
                let second = &x[link.velocity..link.velocity + count];
                self.a[index] = a;
                self.f[index] = motion.modals[modal].wrench(&model.modals[modal].modal, None, &a, second);
                let rigid = Wrench {
                    force: link.mass * (a.linear + a.angular.cross(&at.center)),
                    moment: link.mass * at.center.cross(&a.linear) + at.inertia * a.angular,
                };
                self.f[index] += rigid;
                continue;
            }
            let force = link.mass * (a.linear + a.angular.cross(&at.center));
            let moment = link.mass * at.center.cross(&a.linear) + at.inertia * a.angular;
            self.a[index] = a;
            self.f[index] = Wrench { force, moment };
        }
        for index in (1..model.links.len()).rev() {
            let (link, at) = (&model.links[index], &motion.links[index]);
            let mut f = self.f[index];
            match link.joint {
                Joint::None => {}
                // At the frame, whose link comes after those of its interfaces.
                Joint::Interface { .. } => {}
                Joint::Modal { modal, count } => {
                    let own = link.velocity..link.velocity + count;
                    let (body, at) = (&model.modals[modal], &motion.modals[modal]);
                    let (second, rows) = (&x[own.clone()], &mut product[own]);
                    at.rows(&body.modal, None, &self.a[index], second, rows);
                    at.pull(body.links.iter().map(|link| &self.f[*link]), rows);
                }
                Joint::Ball { .. } => {
                    product[link.velocity..link.velocity + 3].copy_from_slice(at.turn.tr_mul(&f.moment).as_slice());
                }
                Joint::Flex { rod, .. } | Joint::Along { rod } => {
                    let own = link.velocity..link.velocity + link.joint.counts().1;
                    let (given, x, rows) = ((&model.rods[rod], &motion.rods[rod]), &x[own.clone()], &mut product[own]);
                    f = self.rods[rod].inward_change(given, &self.a[link.parent], x, &f, rows).shifted(-at.arm);
                }
                _ => product[link.velocity] = along(&link.joint, &at.axis, &f),
            }
            self.f[link.parent] += f.shifted(at.arm);
        }
        for ((product, coordinate), x) in product.iter_mut().zip(&model.coordinates).zip(x) {
            *product += coordinate.armature * x;
        }
    }
}
