//! Which numbers elements have, and what they measure.

use super::super::beam::{BeamDescription, BeamShape};
use super::super::couplings::{Closure, CoordinateName, MotionDescription};
use super::super::description::{BodyDescription, Description, ForceDescription};
use super::super::motor::{MotorDescription, MotorLawDescription};
use super::super::problem::Element;
use super::{Field, Quantity};
use crate::force::Describe;

/// What the numbers of an element in this field measure.
pub(super) fn quantities(description: &Description, element: Element, field: Field) -> Vec<Quantity> {
    match element {
        Element::Scene | Element::Gear(_) | Element::Event(_) => Vec::new(),
        Element::Contact(_) | Element::Output(_) | Element::Controller(_) | Element::Stage(_) => Vec::new(),
        Element::Motor(index) => of_motor(description, &description.motors[index], field).into_iter().collect(),
        Element::Loop(index) => {
            let closed = &description.loops[index];
            let rod = matches!(closed.closure, Closure::Rod { .. }) && field == Field::Length;
            if rod { vec![Quantity::Length] } else { Vec::new() }
        }
        Element::Drive(index) => {
            let drive = &description.drives[index];
            let steady = matches!(drive.motion, MotionDescription::Rate { .. }) && field == Field::Rate;
            if steady { vec![of_rate(description, &drive.coordinate)] } else { Vec::new() }
        }
        Element::Body(index) => of_body(&description.bodies[index], field),
        Element::Beam(index) => of_beam(&description.beams[index], field).into_iter().collect(),
        Element::Force(index) => of_force(&description.forces[index], field),
    }
}

/// Whether a coordinate is a distance.
fn slides(description: &Description, coordinate: &CoordinateName) -> bool {
    let body = description.bodies.iter().find(|body| body.name == coordinate.body);
    let unit = body.and_then(|body| Some(body.hinge.kind.velocities().get(coordinate.index)?.1));
    unit == Some("m/s")
}

fn of_rate(description: &Description, coordinate: &CoordinateName) -> Quantity {
    if slides(description, coordinate) { Quantity::Speed } else { Quantity::TurnRate }
}

fn of_motor(description: &Description, motor: &MotorDescription, field: Field) -> Option<Quantity> {
    let pick = |slide: Quantity, turn: Quantity| if slides(description, &motor.coordinate) { slide } else { turn };
    match (&motor.law, field) {
        (
            MotorLawDescription::Constant { .. } | MotorLawDescription::Pd { .. } | MotorLawDescription::Input { .. },
            Field::Force,
        ) => Some(pick(Quantity::Force, Quantity::Torque)),
        (MotorLawDescription::Pd { .. }, Field::Stiffness) => Some(pick(Quantity::Stiffness, Quantity::TurnStiffness)),
        _ => None,
    }
}

fn of_body(body: &BodyDescription, field: Field) -> Vec<Quantity> {
    let (positions, velocities) = body.hinge.kind.counts();
    let slides = body.hinge.kind.velocities().iter().map(|(_, unit)| *unit == "m/s");
    let pick = |slide: Quantity, turn: Quantity| slides.map(move |s| if s { slide } else { turn });
    match field {
        Field::Mass => vec![Quantity::Mass],
        Field::Force => pick(Quantity::Force, Quantity::Torque).collect(),
        Field::Stiffness => pick(Quantity::Stiffness, Quantity::TurnStiffness).collect(),
        // The numbers of a quaternion do not move one by one.
        Field::Position | Field::Rest => {
            let count = if positions == velocities { positions } else { positions - 4 };
            pick(Quantity::Length, Quantity::Angle).take(count).collect()
        }
        Field::Gravity | Field::Young | Field::Torque | Field::Length => Vec::new(),
        Field::Pretension | Field::Preload | Field::Rate | Field::Named => Vec::new(),
    }
}

fn of_beam(beam: &BeamDescription, field: Field) -> Option<Quantity> {
    let is_tensioned = beam.far.as_ref().is_some_and(|far| far.pretension.is_some());
    match (field, &beam.shape) {
        (Field::Length, BeamShape::Straight { .. }) if !is_tensioned => Some(Quantity::Length),
        (Field::Pretension, _) => is_tensioned.then_some(Quantity::Force),
        (Field::Young, _) => beam.material.map(|_| Quantity::Stress),
        _ => None,
    }
}

fn of_force(force: &ForceDescription, field: Field) -> Vec<Quantity> {
    force.kind.numbers(field.name()).into_iter().filter_map(|(_, unit)| Quantity::of_unit(unit)).collect()
}
