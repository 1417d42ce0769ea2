//! Inverse dynamics: the hinge forces that given accelerations would need, and the reactions that go with them.

use super::element::bias;
use super::{LinkAcceleration, accelerate, along, inboard};
use crate::model::{Joint, Model};
use crate::motion::Motion;
use crate::spatial::Wrench;

/// What every link does and passes on for given hinge accelerations.
#[derive(Debug, Clone)]
pub struct Balance {
    /// Accelerations of the root markers.
    pub accelerations: Vec<LinkAcceleration>,
    /// What the inboard hinge passes to each link at its root marker; entry 0 is what the ground has to hold.
    pub reactions: Vec<Wrench>,
}

impl Balance {
    /// Room for a model's links.
    pub fn new(model: &Model) -> Self {
        let n = model.links.len();
        Self { accelerations: vec![LinkAcceleration::default(); n], reactions: vec![Wrench::ZERO; n] }
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
        self.reactions[0] = Wrench::ZERO - applied[0];
        for index in 1..model.links.len() {
            let (link, at) = (&model.links[index], &motion.links[index]);
            let mut a = inboard(at, &self.accelerations[link.parent], true);
            accelerate(link, at, hinge, &mut a);
            self.accelerations[index] = a;
            let force = link.mass * (a.linear + a.angular.cross(&at.center));
            let moment = link.mass * at.center.cross(&a.linear) + at.inertia * a.angular;
            self.reactions[index] = Wrench { force, moment } + bias(link.mass, &model.gravity, at) - applied[index];
        }
        for index in (1..model.links.len()).rev() {
            let (link, at) = (&model.links[index], &motion.links[index]);
            let f = self.reactions[index];
            let first = link.velocity;
            match link.joint {
                Joint::None => {}
                Joint::Turn | Joint::Slide { .. } => residual[first] = along(&link.joint, &at.axis, &f),
                Joint::Ball { .. } => {
                    residual[first..first + 3].copy_from_slice(at.turn.tr_mul(&f.moment).as_slice());
                }
            }
            self.reactions[link.parent] += f.shifted(at.arm);
        }
        for (at, coordinate) in model.coordinates.iter().enumerate() {
            residual[at] += coordinate.armature * hinge[at] - tau[at];
        }
    }
}
