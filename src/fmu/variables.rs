//! The variables of an FMU: one table, by value reference, that the model description and every instance follow.

use super::{FmuError, Scene};
use crate::model::output::{EnergyKind, follows_from};
use crate::model::{Model, Output, Parameter, Quantity};
use crate::simulate;
use std::collections::HashSet;
use std::sync::Arc;

/// What a variable is of a scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Role {
    /// The time, which is independent.
    Time,
    /// A motor of type `input` that no controller drives: its place in [`Model::inputs`].
    Input(usize),
    /// A number of the scene, by the address that is the variable's name.
    Parameter,
    /// A hinge coordinate, by its place among all.
    Position(usize),
    /// A hinge velocity, by its place among all.
    Velocity(usize),
    /// A number of an `[[output]]`, by its place among the numbers of all.
    Output(usize),
}

/// A variable. Its value reference is its place in [`Variables::list`].
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Unique.
    pub name: String,
    /// SI unit; empty for none.
    pub unit: String,
    /// What it is.
    pub role: Role,
    /// Of inputs and parameters.
    pub start: Option<f64>,
}

/// All variables.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Variables {
    /// By value reference; the first one is the time.
    pub list: Vec<Variable>,
    /// Outputs that are no variables: energies that count from the start of a run, and what follows from them.
    pub left_out: Vec<String>,
}

impl Variables {
    /// The variables of a scene whose inputs have the values of `model`; `parameters` are addresses of numbers beside `[parameters]`.
    ///
    /// # Errors
    /// An address that stands for no number or for several, and two variables of one name.
    pub fn of(scene: &Scene, model: &Arc<Model>, parameters: &[String]) -> Result<Self, FmuError> {
        let variable = |name: &str, unit: &str, role: Role| Variable {
            name: name.to_owned(),
            unit: unit.to_owned(),
            role,
            start: None,
        };
        let mut list = vec![variable("time", "s", Role::Time)];
        for (place, motor) in model.inputs.iter().enumerate() {
            if model.controllers.iter().any(|one| one.drives.contains(&place)) {
                continue;
            }
            let motor = &model.motors[*motor];
            let unit = if motor.coordinate.slides { "N" } else { "N m" };
            list.push(Variable { start: motor.given(), ..variable(&motor.name, unit, Role::Input(place)) });
        }
        for parameter in numbers(scene, parameters)? {
            let start = Some(parameter.value(&scene.scenario.description));
            list.push(Variable { start, ..variable(&parameter.address, parameter.quantity.unit(), Role::Parameter) });
        }
        let channels = simulate::scene(model);
        for (place, channel) in channels.positions.iter().enumerate() {
            list.push(variable(&format!("{}.{}", channel.body, channel.name), &channel.unit, Role::Position(place)));
        }
        // Coordinates of beams and their rates share a name, as in recordings: `rod/1.bend_y_0_dot` is the rate.
        let positions: HashSet<(&str, &str)> = channels.positions.iter().map(|one| (&*one.body, &*one.name)).collect();
        for (place, channel) in channels.velocities.iter().enumerate() {
            let dot = if positions.contains(&(&*channel.body, &*channel.name)) { "_dot" } else { "" };
            let name = format!("{}.{}{dot}", channel.body, channel.name);
            list.push(variable(&name, &channel.unit, Role::Velocity(place)));
        }
        let mut left_out = Vec::new();
        for output in &model.outputs {
            if is_accumulated(model, output) {
                left_out.push(output.name.clone());
                continue;
            }
            let each = output.range().zip(output.labels()).zip(&output.units);
            list.extend(each.map(|((place, label), unit)| variable(&label, unit, Role::Output(place))));
        }
        check_names(&list)?;
        Ok(Self { list, left_out })
    }

    /// The variable of a value reference.
    ///
    /// # Errors
    /// If there is none.
    pub fn get(&self, reference: u32) -> Result<&Variable, FmuError> {
        let last = u32::try_from(self.list.len() - 1).unwrap_or(u32::MAX);
        self.list.get(reference as usize).ok_or(FmuError::NoVariable { reference, last })
    }
}

/// The numbers that are parameters: all of `[parameters]`, then those of addresses.
fn numbers(scene: &Scene, addresses: &[String]) -> Result<Vec<Parameter>, FmuError> {
    let description = &scene.scenario.description;
    let named = description.named.list().iter().map(|one| format!("parameters.{}", one.name));
    let mut all: Vec<Parameter> = Vec::new();
    for address in named.chain(addresses.iter().cloned()) {
        let found = Parameter::find(description, &address).map_err(|unknown| {
            let help = unknown.help.map(|help| format!("\nhint: {help}")).unwrap_or_default();
            FmuError::Scene(format!("`{address}` is no parameter: {}{help}", unknown.message))
        })?;
        let [one] = &found[..] else {
            let each: Vec<String> = found.iter().map(|one| format!("`{}`", one.address)).collect();
            return Err(FmuError::Scene(format!("`{address}` stands for {} numbers: {}", each.len(), each.join(", "))));
        };
        if scene.scenario.unknown.iter().any(|unknown| unknown.address == one.address) {
            let message = format!("`{address}` is unknown to statics, which finds it: it is no parameter");
            return Err(FmuError::Scene(message));
        }
        if !all.iter().any(|other| other.address == one.address) {
            all.push(one.clone());
        }
    }
    Ok(all)
}

/// Whether an output counts energies from the start of a run, or follows from one that does.
fn is_accumulated(model: &Model, output: &Output) -> bool {
    let counts =
        |output: &Output| matches!(output.quantity, Quantity::Energy(EnergyKind::Input | EnergyKind::Dissipated));
    follows_from(&model.outputs, output, counts).is_some()
}

fn check_names(list: &[Variable]) -> Result<(), FmuError> {
    let what = |role: &Role| match role {
        Role::Time => "the time",
        Role::Input(_) => "an input",
        Role::Parameter => "a parameter",
        Role::Position(_) => "a hinge coordinate",
        Role::Velocity(_) => "a hinge velocity",
        Role::Output(_) => "an output",
    };
    let mut seen = HashSet::new();
    for variable in list {
        let name = &variable.name;
        if !seen.insert(name) {
            let both: Vec<&str> = list.iter().filter(|one| one.name == *name).map(|one| what(&one.role)).collect();
            let message = format!("variables need unique names, and `{name}` is {}: rename one", both.join(" and "));
            return Err(FmuError::Scene(message));
        }
        if name.chars().any(char::is_control) {
            return Err(FmuError::Scene(format!(
                "the name {name:?} of {} has control characters",
                what(&variable.role)
            )));
        }
    }
    Ok(())
}
