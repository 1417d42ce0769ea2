//! Reading and setting the number that an address stands for.

use super::super::beam::{BeamDescription, BeamShape};
use super::super::controller;
use super::super::couplings::{Closure, MotionDescription};
use super::super::description::Description;
use super::super::motor::MotorLawDescription;
use super::super::problem::Element;
use super::{Field, Parameter, named};
use crate::force::Describe;

fn beam(beam: &BeamDescription, field: Field) -> f64 {
    match (field, &beam.shape, &beam.material) {
        (Field::Length, BeamShape::Straight { length }, _) => *length,
        (Field::Young, _, Some(material)) => material.young,
        (Field::Pretension, ..) => beam.far.as_ref().and_then(|far| far.pretension).unwrap_or(f64::NAN),
        _ => f64::NAN,
    }
}

impl Parameter {
    /// Its value.
    pub fn value(&self, description: &Description) -> f64 {
        let list = |list: &[f64]| list.get(self.index).copied().unwrap_or(0.0);
        match self.element {
            Element::Scene if self.field == Field::Named => description.named.list()[self.index].value,
            Element::Scene => description.gravity[self.index],
            // Events, contacts, outputs and controllers have no parameters.
            Element::Event(_)
            | Element::Contact(_)
            | Element::Output(_)
            | Element::Controller(_)
            | Element::Stage(_) => f64::NAN,
            Element::Body(body) => {
                let body = &description.bodies[body];
                match self.field {
                    Field::Mass => body.mass.mass,
                    Field::Position => list(&body.hinge.position),
                    Field::Rest => list(&body.hinge.rest),
                    Field::Stiffness => list(&body.hinge.stiffness),
                    _ => list(&body.hinge.force),
                }
            }
            Element::Force(force) => {
                let numbers = description.forces[force].kind.numbers(self.field.name());
                numbers.get(self.index).map_or(f64::NAN, |(number, _)| *number)
            }
            Element::Loop(index) => match description.loops[index].closure {
                Closure::Rod { length } => length,
                Closure::Hinge(_) => f64::NAN,
            },
            Element::Drive(index) => match description.drives[index].motion {
                MotionDescription::Rate { rate } => rate,
                _ => f64::NAN,
            },
            Element::Motor(index) => match (&description.motors[index].law, self.field) {
                (MotorLawDescription::Pd { stiffness, .. }, Field::Stiffness) => *stiffness,
                (MotorLawDescription::Pd { force, .. } | MotorLawDescription::Constant { force }, _) => *force,
                (MotorLawDescription::Input { force }, _) => {
                    force.unwrap_or_else(|| controller::bias(description, &description.motors[index].name))
                }
                _ => f64::NAN,
            },
            Element::Gear(_) => f64::NAN,
            Element::Beam(index) => beam(&description.beams[index], self.field),
        }
    }

    /// Gives it a value; whether that is allowed is checked by [`Model::build`](crate::model::Model::build).
    ///
    /// # Errors
    /// If it is a named number of which no description can be made with this value: why. The description is as it was.
    pub fn set(&self, description: &mut Description, value: f64) -> Result<(), String> {
        if self.field == Field::Named {
            if self.value(description).to_bits() != value.to_bits() {
                *description = named::with(description, self.index, value)?;
            }
            return Ok(());
        }
        self.put(description, value);
        Ok(())
    }

    /// Puts a value where the number stands.
    pub(super) fn put(&self, description: &mut Description, value: f64) {
        match self.element {
            Element::Scene => description.gravity[self.index] = value,
            Element::Event(_)
            | Element::Contact(_)
            | Element::Output(_)
            | Element::Controller(_)
            | Element::Stage(_) => {}
            Element::Body(body) => {
                let body = &mut description.bodies[body];
                let (positions, velocities) = body.hinge.kind.counts();
                let quaternion = positions != velocities;
                let (list, count) = match self.field {
                    Field::Mass => {
                        body.mass.mass = value;
                        return;
                    }
                    Field::Position => (&mut body.hinge.position, positions),
                    Field::Rest => (&mut body.hinge.rest, positions),
                    Field::Stiffness => (&mut body.hinge.stiffness, velocities),
                    _ => (&mut body.hinge.force, velocities),
                };
                if list.is_empty() {
                    list.resize(count, 0.0);
                    if quaternion && count == positions {
                        list[count - 4] = 1.0;
                    }
                }
                list[self.index] = value;
            }
            Element::Force(force) => description.forces[force].kind.set(self.field.name(), self.index, value),
            Element::Loop(index) => {
                if let Closure::Rod { length } = &mut description.loops[index].closure {
                    *length = value;
                }
            }
            Element::Drive(index) => {
                if let MotionDescription::Rate { rate } = &mut description.drives[index].motion {
                    *rate = value;
                }
            }
            Element::Motor(index) => match (&mut description.motors[index].law, self.field) {
                (MotorLawDescription::Pd { stiffness, .. }, Field::Stiffness) => *stiffness = value,
                (MotorLawDescription::Pd { force, .. } | MotorLawDescription::Constant { force }, _) => *force = value,
                (MotorLawDescription::Input { force }, _) => *force = Some(value),
                _ => {}
            },
            Element::Gear(_) => {}
            Element::Beam(index) => {
                let beam = &mut description.beams[index];
                match (self.field, &mut beam.shape, &mut beam.material) {
                    (Field::Length, BeamShape::Straight { length }, _) => *length = value,
                    (Field::Young, _, Some(material)) => material.young = value,
                    (Field::Pretension, ..) => beam.far.iter_mut().for_each(|far| far.pretension = Some(value)),
                    _ => {}
                }
            }
        }
    }
}
