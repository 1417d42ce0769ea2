//! The laws of a system: those of its model, each kept in a smooth part where a run keeps it there.
//!
//! The laws of ropes, tables that are read straight from point to point, and formulas have boundaries at which they are not smooth. A
//! run keeps each law on its side of them within a step and ends the step at a boundary that is crossed (`simulate::events`),
//! so that no formula of an integrator reaches across one.

use super::phase::Phase;
use crate::force::{Act, Force, Switch};
use crate::formula::{CellEnd, Pieces};
use crate::model::motor::Motor;
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
    /// The pieces in which formulas of motors are kept, in the order of the model; empty until they are.
    pieces: Vec<Pieces>,
    /// What motors of type `input` are asked to push with, in the order of [`Model::inputs`] (N or N m).
    pub inputs: Vec<f64>,
    /// What stops and dry friction do.
    pub phase: Phase,
}

/// A boundary between two smooth parts of a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Boundary {
    /// A force element by its index, behind those a curve in a hinge, behind those a motor.
    pub element: usize,
    /// Which of its boundaries.
    pub index: usize,
}

/// What has a boundary.
enum Whose {
    Force(usize),
    Curve(usize),
    Motor(usize, CellEnd),
}

impl Laws {
    /// The model's laws, none kept on a side.
    pub fn new(model: &Model) -> Self {
        let inputs = model.inputs.iter().map(|motor| model.motors[*motor].given().unwrap_or(0.0)).collect();
        Self {
            forces: Arc::clone(&model.forces),
            curves: Arc::clone(&model.curves),
            pieces: Vec::new(),
            inputs,
            phase: Phase::new(model),
        }
    }

    /// Keeps all laws in the parts to which a state belongs, in a copy of the model's.
    pub fn keep(&mut self, model: &Model, time: f64, motion: &Motion, q: &[f64], v: &[f64]) {
        self.pieces = model.motors.iter().map(Motor::pieces).collect();
        for (motor, pieces) in model.motors.iter().zip(&mut self.pieces) {
            motor.keep(pieces, time, q[motor.coordinate.position], v[motor.coordinate.velocity]);
        }
        Arc::make_mut(&mut self.forces).iter_mut().for_each(|force| force.law.keep(&motion.links));
        for curve in Arc::make_mut(&mut self.curves) {
            let argument = curve.argument(q, v);
            curve.table.keep(argument);
        }
    }

    /// The pieces in which the formula of a motor is kept; none if it is not.
    pub fn pieces(&self, motor: usize) -> &Pieces {
        const NONE: &Pieces = &Pieces::NONE;
        self.pieces.get(motor).unwrap_or(NONE)
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
        let of_motors = self.pieces.iter().enumerate().flat_map(|(motor, pieces)| {
            let element = self.first_motor() + motor;
            pieces.ends().map(move |end| Boundary { element, index: 2 * end.cell + usize::from(end.is_upper) })
        });
        of_forces.chain(of_curves).flat_map(each).chain(of_motors)
    }

    fn first_motor(&self) -> usize {
        self.forces.len() + self.curves.len()
    }

    /// Whose boundary it is.
    fn whose(&self, Boundary { element, index }: Boundary) -> Whose {
        if element < self.forces.len() {
            Whose::Force(element)
        } else if element < self.first_motor() {
            Whose::Curve(element - self.forces.len())
        } else {
            Whose::Motor(element - self.first_motor(), CellEnd { cell: index / 2, is_upper: index % 2 == 1 })
        }
    }

    /// The motor whose formula has a boundary; `None` of forces and curves.
    pub fn motor(&self, boundary: Boundary) -> Option<usize> {
        boundary.element.checked_sub(self.first_motor())
    }

    /// The function whose change of sign is the crossing of a boundary.
    pub fn switch(&self, boundary: Boundary, model: &Model, time: f64, motion: &Motion, state: [&[f64]; 2]) -> Switch {
        let [q, v] = state;
        match self.whose(boundary) {
            Whose::Force(force) => self.forces[force].law.switch(boundary.index, &motion.links),
            Whose::Curve(curve) => self.curves[curve].switch(boundary.index, q, v),
            Whose::Motor(index, end) => {
                let motor = &model.motors[index];
                let (q, v) = (q[motor.coordinate.position], v[motor.coordinate.velocity]);
                let (value, [by_time, by_place, by_speed]) = motor.above(&self.pieces[index], end, time, q, v);
                let (unit, span) =
                    (if motor.coordinate.slides { model.length_scale() } else { 1.0 }, model.time_scale());
                let size = by_time.abs() * span + by_place.abs() * unit + by_speed.abs() * unit / span;
                // How fast a speed changes is not known.
                let is_speed = by_speed != 0.0;
                let rate = if is_speed { 0.0 } else { by_time + by_place * v };
                Switch { value, rate, is_speed, size: Some(size), at: q, speed: v }
            }
        }
    }

    /// Whether a law is kept on the positive side of a boundary.
    pub fn side(&self, boundary: Boundary) -> bool {
        match self.whose(boundary) {
            Whose::Force(force) => self.forces[force].law.side(boundary.index),
            Whose::Curve(curve) => self.curves[curve].table.side(boundary.index),
            Whose::Motor(_, end) => !end.is_upper,
        }
    }

    /// Keeps a law on the other side of a boundary from now on.
    pub fn cross(&mut self, boundary: Boundary) {
        match self.whose(boundary) {
            Whose::Force(force) => Arc::make_mut(&mut self.forces)[force].law.cross(boundary.index),
            Whose::Curve(curve) => Arc::make_mut(&mut self.curves)[curve].table.cross(boundary.index),
            Whose::Motor(motor, end) => self.pieces[motor].cross(end),
        }
    }

    /// Follows the formula of a motor as it stands from now on, across its boundaries.
    pub fn follow_across(&mut self, motor: usize) {
        self.pieces.get_mut(motor).into_iter().for_each(Pieces::clear);
    }
}
