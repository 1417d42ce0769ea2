//! Maximal coordinates: a pose for every link, and the hinge coordinates that belong to them.

use crate::model::{Joint, Model};
use crate::motion::Motion;
use nalgebra::{Rotation3, UnitQuaternion, Vector3};
use std::f64::consts::TAU;

/// Poses of all links with the hinge coordinates read off them.
#[derive(Debug, Clone)]
pub(super) struct Poses {
    pub(super) motion: Motion,
    pub(super) q: Vec<f64>,
}

impl Poses {
    /// The poses of a tree at `q`.
    pub(super) fn new(model: &Model, q: &[f64]) -> Self {
        let mut motion = Motion::new(model);
        motion.update(model, q, &vec![0.0; model.velocity_count()]);
        Self { motion, q: q.to_vec() }
    }

    /// Every link moved by its part of `step`: displacement and rotation vector, inertial axes, six numbers each.
    pub(super) fn moved(&self, model: &Model, step: &[f64], scale: f64) -> Self {
        let mut new = self.clone();
        for (index, link) in model.links.iter().enumerate().skip(1) {
            let at = &mut new.motion.links[index];
            let part = |first: usize| scale * Vector3::from_column_slice(&step[first..first + 3]);
            at.position += part(6 * (index - 1));
            let mut turn = Rotation3::new(part(6 * (index - 1) + 3)) * Rotation3::from_matrix_unchecked(at.turn);
            turn.renormalize();
            at.turn = turn.into_inner();
            at.center = at.turn * link.center;
        }
        new.read(model);
        new
    }

    /// Hinge coordinates from the poses; full turns are counted from the coordinates before, or on the thread. Locked ones stay.
    fn read(&mut self, model: &Model) {
        for (index, link) in model.links.iter().enumerate().skip(1) {
            let (own, parent) = (&self.motion.links[index], &self.motion.links[link.parent]);
            let base = parent.turn * link.turn;
            let relative =
                || UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(base.transpose() * own.turn));
            let at = link.position;
            let (_, count) = link.joint.counts();
            if model.coordinates[link.velocity..link.velocity + count].iter().any(|c| c.lock) {
                continue;
            }
            match link.joint {
                Joint::None
                | Joint::Flex { .. }
                | Joint::Along { .. }
                | Joint::Modal { .. }
                | Joint::Interface { .. } => {}
                Joint::Turn | Joint::Screw { .. } => {
                    let turn = relative();
                    let angle = 2.0 * turn.k.atan2(turn.w);
                    let near = match link.joint {
                        // Its place on the thread says how many full turns it has made.
                        Joint::Screw { pitch } => {
                            let between = own.position - parent.position - parent.turn * link.offset;
                            base.column(2).dot(&between) / pitch
                        }
                        _ => self.q[at],
                    };
                    self.q[at] = angle + TAU * ((near - angle) / TAU).round();
                }
                Joint::Slide { axis } => {
                    let between = own.position - parent.position - parent.turn * link.offset;
                    self.q[at] = (base * axis).dot(&between);
                }
                Joint::Ball { .. } => {
                    let p = relative();
                    self.q[at..at + 4].copy_from_slice(&[p.w, p.i, p.j, p.k]);
                }
            }
        }
    }
}
