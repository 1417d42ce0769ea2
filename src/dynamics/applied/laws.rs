//! The laws of a system: those of its model, each kept in a smooth part where a run keeps it there.
//!
//! The laws of ropes, and tables that are read straight from point to point, have boundaries at which they are not smooth. A
//! run keeps each law on its side of them within a step and ends the step at a boundary that is crossed (`simulate::events`),
//! so that no formula of an integrator reaches across one.

use super::phase::Phase;
use crate::force::{Act, Force, Switch};
use crate::model::{HingeCurve, Model};
use crate::motion::Motion;
use std::sync::Arc;

/// The laws of a system; those of the model until they are kept.
#[derive(Debug, Clone)]
pub struct Laws {
    /// Force elements, as in the model.
    pub forces: Arc<[Force]>,
    /// Curves in hinges, as in the model.
    pub curves: Arc<[HingeCurve]>,
    /// What motors of type `input` are asked to push with, in the order of [`Model::inputs`] (N or N m).
    pub inputs: Vec<f64>,
    /// What stops and dry friction do.
    pub phase: Phase,
}

/// A boundary between two smooth parts of a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Boundary {
    /// A force element by its index, or behind those a curve in a hinge.
    pub element: usize,
    /// Which of its boundaries.
    pub index: usize,
}

impl Laws {
    /// The model's laws, none kept on a side.
    pub fn new(model: &Model) -> Self {
        let inputs = model.inputs.iter().map(|motor| model.motors[*motor].given().unwrap_or(0.0)).collect();
        Self { forces: Arc::clone(&model.forces), curves: Arc::clone(&model.curves), inputs, phase: Phase::new(model) }
    }

    /// Keeps all laws in the parts to which a state belongs, in a copy of the model's.
    pub fn keep(&mut self, motion: &Motion, q: &[f64], v: &[f64]) {
        Arc::make_mut(&mut self.forces).iter_mut().for_each(|force| force.law.keep(&motion.links));
        for curve in Arc::make_mut(&mut self.curves) {
            let argument = curve.argument(q, v);
            curve.table.keep(argument);
        }
    }

    /// The boundaries next to the parts in which laws are kept.
    pub fn boundaries(&self) -> impl Iterator<Item = Boundary> {
        let of_forces = self.forces.iter().map(|force| force.law.boundaries()).enumerate();
        let of_curves = self.curves.iter().enumerate().map(|(index, curve)| {
            let [low, high] = curve.table.kinks();
            (self.forces.len() + index, [low, high, None, None])
        });
        let each = |(element, indices): (usize, [Option<usize>; 4])| {
            indices.into_iter().flatten().map(move |index| Boundary { element, index })
        };
        of_forces.chain(of_curves).flat_map(each)
    }

    /// The function whose change of sign is the crossing of a boundary.
    pub fn switch(&self, Boundary { element, index }: Boundary, motion: &Motion, q: &[f64], v: &[f64]) -> Switch {
        match self.forces.get(element) {
            Some(force) => force.law.switch(index, &motion.links),
            None => self.curves[element - self.forces.len()].switch(index, q, v),
        }
    }

    /// Whether a law is kept on the positive side of a boundary.
    pub fn side(&self, Boundary { element, index }: Boundary) -> bool {
        match self.forces.get(element) {
            Some(force) => force.law.side(index),
            None => self.curves[element - self.forces.len()].table.side(index),
        }
    }

    /// Keeps a law on the other side of a boundary from now on.
    pub fn cross(&mut self, Boundary { element, index }: Boundary) {
        let count = self.forces.len();
        match element < count {
            true => Arc::make_mut(&mut self.forces)[element].law.cross(index),
            false => Arc::make_mut(&mut self.curves)[element - count].table.cross(index),
        }
    }
}
