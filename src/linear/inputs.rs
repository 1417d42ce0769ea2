//! What pushes a scene from outside: forces in coordinates, components of loads, targets of drives.

use crate::force::Act;
use crate::model::address::split_component;
use crate::model::description::{Description, ForceKind, LoadAxes};
use crate::model::output::{Source, follows_from};
use crate::model::parameter::Field;
use crate::model::problem::counted;
use crate::model::{Element, Model, Output, Parameter, Quantity};
use crate::spatial::link::LinkMotion;
use crate::suggest::closest;
use nalgebra::Matrix3;

/// An input.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Input {
    /// A force (N or N m) in a velocity coordinate, beside what acts there.
    Coordinate {
        /// As it is asked for.
        name: String,
        /// The coordinate.
        velocity: usize,
        /// The motor that it is the force of.
        motor: Option<usize>,
    },
    /// A component of a load, beside what it has.
    Load {
        /// As it is asked for.
        name: String,
        /// Index of the force element.
        element: usize,
        /// 0 to 2 of the force (N), 3 to 5 of the torque (N m).
        component: usize,
        /// Whether it turns with the body.
        follows: bool,
    },
    /// The acceleration of a drive's target, in addition to its motion (m/s² or rad/s²).
    Drive {
        /// As it is asked for.
        name: String,
        /// Index of the drive.
        drive: usize,
    },
}

/// Why a name is no input.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Unfit {
    /// What is wrong.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
}

impl Input {
    /// The inputs that a name stands for: a motor or a drive (by name, or by place as `drive[0]`), `hinge.force` of a body by its address, a
    /// load's components.
    ///
    /// # Errors
    /// If it stands for nothing that pushes.
    pub fn find(description: &Description, model: &Model, name: &str) -> Result<Vec<Self>, Unfit> {
        if let Some(motor) = model.motors.iter().position(|motor| motor.name == name) {
            return Ok(vec![Self::motor(model, motor, name)]);
        }
        if let Some(drive) = model.drives.iter().position(|drive| drive.name == name) {
            return Ok(vec![Self::Drive { name: name.to_owned(), drive }]);
        }
        if let Some(input) = Self::by_place(model, name) {
            return input.map(|input| vec![input]);
        }
        let found = Parameter::find(description, name).map_err(|error| {
            let known = model
                .motors
                .iter()
                .map(|one| one.name.as_str())
                .chain(model.drives.iter().map(|one| one.name.as_str()));
            let near = closest(name, known).map(|near| format!("did you mean `{near}`?"));
            Unfit { message: error.message, help: near.or(error.help) }
        })?;
        let one = |parameter: &Parameter| {
            let name = parameter.address.clone();
            match (parameter.element, parameter.field) {
                (Element::Body(body), Field::Force) => {
                    let velocity = model.bodies[body].hinge.velocity + parameter.component();
                    Ok(Self::Coordinate { name, velocity, motor: None })
                }
                (Element::Motor(motor), Field::Force) => Ok(Self::motor(model, motor, &name)),
                (Element::Force(element), Field::Force | Field::Torque) => {
                    let torque = if parameter.field == Field::Torque { 3 } else { 0 };
                    let follows = match &description.forces[element].kind {
                        ForceKind::Load(load) => load.axes == LoadAxes::Body,
                        _ => false,
                    };
                    Ok(Self::Load { name, element, component: torque + parameter.component(), follows })
                }
                _ => Err(Unfit {
                    message: format!("`{name}` is no force"),
                    help: Some("inputs are forces of hinges, motors and loads, and drives".to_owned()),
                }),
            }
        };
        found.iter().map(one).collect()
    }

    /// `motor[0]`, `drive[1]`: by its place in the scene, with or without a name; `None` for other names.
    fn by_place(model: &Model, name: &str) -> Option<Result<Self, Unfit>> {
        let (kind, Some(place)) = split_component(name) else { return None };
        let (found, count) = match kind {
            "motor" => (
                model.motors.get(place).map(|motor| Self::motor(model, place, &motor.name)),
                counted(model.motors.len(), "motor", "motors"),
            ),
            "drive" => (
                model.drives.get(place).map(|drive| Self::Drive { name: drive.name.clone(), drive: place }),
                counted(model.drives.len(), "drive", "drives"),
            ),
            _ => return None,
        };
        Some(
            found.ok_or_else(|| Unfit {
                message: format!("`{name}`: the scene has {count}, counted from 0"),
                help: None,
            }),
        )
    }

    fn motor(model: &Model, motor: usize, name: &str) -> Self {
        let velocity = model.motors[motor].coordinate.velocity;
        Self::Coordinate { name: name.to_owned(), velocity, motor: Some(motor) }
    }

    /// As it is asked for.
    pub fn name(&self) -> &str {
        match self {
            Self::Coordinate { name, .. } | Self::Load { name, .. } | Self::Drive { name, .. } => name,
        }
    }

    /// SI unit.
    pub fn unit(&self, model: &Model) -> &'static str {
        let slides = |velocity: usize| {
            let hinge = &model.bodies[model.coordinates[velocity].body].hinge;
            hinge.kind.velocities()[velocity - hinge.velocity].1 == "m/s"
        };
        match *self {
            Self::Coordinate { velocity, .. } if slides(velocity) => "N",
            Self::Coordinate { .. } => "N m",
            Self::Load { component: 0..3, .. } => "N",
            Self::Load { .. } => "N m",
            Self::Drive { drive, .. } if model.drives[drive].coordinate.slides => "m/s²",
            Self::Drive { .. } => "rad/s²",
        }
    }

    /// The drive whose target it is.
    pub(super) fn drive(&self) -> Option<usize> {
        match self {
            Self::Drive { drive, .. } => Some(*drive),
            _ => None,
        }
    }

    /// Axes in which a load's components are given, inertial axes.
    pub(super) fn load_axes(&self, model: &Model, link: &LinkMotion) -> Matrix3<f64> {
        match self {
            Self::Load { follows: true, .. } => link.turn * self.own_axes(model),
            _ => Matrix3::identity(),
        }
    }

    /// These axes, seen from those in which the load is constant: inertial ones or its link's.
    pub(super) fn own_axes(&self, model: &Model) -> Matrix3<f64> {
        let Self::Load { element, follows: true, .. } = *self else { return Matrix3::identity() };
        let body = model.forces[element].law.ends()[0].body;
        let turn = body.map(|body| model.bodies[body].link_from_body.rotation.to_rotation_matrix());
        turn.map_or_else(Matrix3::identity, nalgebra::Rotation3::into_inner)
    }

    /// Whether an output is what this input pushes with, or may follow from it.
    pub fn is_told_by(&self, model: &Model, output: &Output) -> bool {
        let is_own = |output: &Output| match (self, &output.quantity) {
            (Self::Coordinate { motor: Some(motor), .. }, Quantity::Force(force)) => {
                matches!(force.source, Source::Motor(index) if index == *motor)
            }
            (Self::Load { element, .. }, Quantity::Force(force)) => {
                matches!(force.source, Source::Element(index) if index == *element)
            }
            _ => false,
        };
        follows_from(&model.outputs, output, is_own).is_some()
    }
}
