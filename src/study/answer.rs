//! What is asked of every case, and the columns in which its answer stands.
//!
//! `Listing::all` is the one list of these columns: it is walked once without an answer, for their names, and once for each
//! case, for what stands in them.

use super::column::{Cell, Column, Kind};
use crate::dynamics::System;
use crate::force::Act;
use crate::model::description::StageDescription;
use crate::model::output::{Output, Source};
use crate::model::{Model, Quantity, Side};
use crate::scenario::Scenario;
use crate::simulate::Summary;
use crate::statics::{Equilibrium, Stability, most_modes, standing};
use std::sync::Arc;

/// What is asked of a case.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Question {
    /// Whether it is simulated.
    pub run: bool,
    /// How long a case may take (s); infinite for ever.
    pub time_limit: f64,
}

impl Question {
    /// Whether a scene is asked for its equilibrium: runs that start as given are not.
    pub fn asks_statics(&self, scenario: &Scenario) -> bool {
        !self.run || scenario.simulate.start == crate::simulate::Start::Equilibrium
    }
}

/// What a case came to.
#[derive(Debug)]
pub struct Answer {
    /// The scene, with unknown inputs as they were found.
    pub model: Arc<Model>,
    /// The equilibrium, if it was asked for; as far as it was found, if none was.
    pub found: Option<Equilibrium>,
    /// The run, if it was asked for.
    pub run: Option<Summary>,
    /// The outputs of the equilibrium, or of the run its end, least, largest and mean square, in the order of the columns.
    pub outputs: Vec<f64>,
}

/// The columns that answers to a question about a scene have.
pub fn columns(scenario: &Scenario, model: &Model, question: &Question) -> Vec<Column> {
    let mut columns = Vec::new();
    Listing { answer: None, take: &mut |column, _| columns.push(column()) }.all(scenario, model, question);
    columns
}

/// What stands in these columns.
pub fn cells(scenario: &Scenario, answer: &Answer, question: &Question) -> Vec<Cell> {
    let mut cells = Vec::new();
    Listing { answer: Some(answer), take: &mut |_, cell| cells.push(cell) }.all(scenario, &answer.model, question);
    cells
}

/// A column of an output.
pub(super) struct OutputColumn<'a> {
    /// The output, by its index.
    pub(super) output: usize,
    /// Its place in [`Answer::outputs`].
    place: usize,
    pub(super) name: String,
    unit: &'a str,
}

/// The columns of the outputs of a scene: at the equilibrium, or over the run. What is called like the column that it has anyway has no
/// second one.
pub(super) fn output_columns<'a>(model: &'a Model, question: &Question) -> impl Iterator<Item = OutputColumn<'a>> {
    let run = question.run;
    let parts: &[&str] = if run { &[".end", ".min", ".max", ".rms"] } else { &[""] };
    let numbers = model.outputs.iter().enumerate().flat_map(|(output, one)| {
        let each = one.labels().zip(&one.units).enumerate();
        each.map(move |(index, (label, unit))| (output, index, label, unit.as_str()))
    });
    numbers.enumerate().flat_map(move |(number, (output, index, label, unit))| {
        let is_there = !run && column_of(model, &model.outputs[output].quantity, index).as_ref() == Some(&label);
        let parts = if is_there { &[] } else { parts };
        let one = move |(part, end): (usize, &&str)| OutputColumn {
            output,
            place: number * parts.len() + part,
            name: format!("{label}{end}"),
            unit,
        };
        parts.iter().enumerate().map(one).collect::<Vec<_>>()
    })
}

/// The column that a number of a quantity has in answers of statics, whether or not there is an output of it.
fn column_of(model: &Model, quantity: &Quantity, index: usize) -> Option<String> {
    match quantity {
        Quantity::Coordinate(coordinate) => {
            let position = coordinate.range.start + index;
            model.bodies.iter().find_map(|body| {
                let names = body.hinge.kind.positions();
                let (name, _) = names.get(position.checked_sub(body.hinge.position)?)?;
                Some(format!("{}.{name}", body.name))
            })
        }
        Quantity::Force(force) => match force.source {
            Source::Drive(drive) => Some(format!("drives.{}", model.drives[drive].name)),
            Source::Motor(motor) => Some(format!("motors.{}", model.motors[motor].name)),
            Source::Line(line) => {
                let force = &model.forces[line];
                force.law.pull_name().map(|_| format!("pulls.{}", force.name))
            }
            _ => None,
        },
        _ => None,
    }
}

/// Columns and what stands in them, for an answer whose scene has other columns than those before.
pub fn pairs(scenario: &Scenario, answer: &Answer, question: &Question) -> Vec<(Column, Cell)> {
    let mut pairs = Vec::new();
    Listing { answer: Some(answer), take: &mut |column, cell| pairs.push((column(), cell)) }.all(
        scenario,
        &answer.model,
        question,
    );
    pairs
}

/// Walks over the columns; `take` gets each of them with what stands in it.
struct Listing<'a, 'f> {
    answer: Option<&'a Answer>,
    take: &'f mut dyn FnMut(&dyn Fn() -> Column, Cell),
}

impl<'a> Listing<'a, '_> {
    fn put(&mut self, kind: Kind, unit: &'static str, name: &dyn Fn() -> String, cell: Cell) {
        (self.take)(&|| Column::new(name(), kind, unit), cell);
    }

    fn number(&mut self, unit: &'static str, name: &dyn Fn() -> String, number: Option<f64>) {
        self.put(Kind::Number, unit, name, number.into());
    }

    fn whole(&mut self, name: &str, number: Option<u64>) {
        let cell = number.map_or(Cell::Empty, |number| Cell::Whole(number as i64));
        self.put(Kind::Whole, "", &|| name.to_owned(), cell);
    }

    fn word(&mut self, name: &str, word: Option<impl Into<std::borrow::Cow<'static, str>>>) {
        let cell = word.map_or(Cell::Empty, |word| Cell::Word(word.into()));
        self.put(Kind::Word, "", &|| name.to_owned(), cell);
    }

    /// Every column of an answer: a new kind of answer gets its line here.
    fn all(&mut self, scenario: &Scenario, model: &Model, question: &Question) {
        if question.asks_statics(scenario) {
            self.statics(scenario, model);
        }
        if question.run {
            self.run(model);
        }
        self.outputs(model, question);
    }

    fn outputs(&mut self, model: &Model, question: &Question) {
        let values = self.answer.map_or(&[][..], |answer| &answer.outputs);
        for OutputColumn { place, name, unit, .. } in output_columns(model, question) {
            let cell = values.get(place).copied().into();
            (self.take)(&|| Column::new(name.clone(), Kind::Number, unit.to_owned()), cell);
        }
    }

    fn statics(&mut self, scenario: &Scenario, model: &Model) {
        let found = self.answer.and_then(|answer| answer.found.as_ref());
        let held = found.filter(|found| found.converged);
        for unknown in &scenario.unknown {
            let value = held.and_then(|held| {
                held.unknowns.iter().find(|(address, _)| *address == unknown.address).map(|(_, value)| *value)
            });
            self.number(unknown.quantity.unit(), &|| unknown.address.clone(), value);
        }
        let stability = found.and_then(|found| found.stability.as_ref());
        self.word("stability", stability.map(|stability| stability.verdict.name()));
        if standing::is_for(model) {
            self.standing(scenario, found);
        }
        // In a scene with slides and axes the largest may be of either.
        let [force, acceleration] = match model.lengths().count() {
            0 => ["N m", "rad/s²"],
            lengths if lengths == model.velocity_count() => ["N", "m/s²"],
            _ => ["", ""],
        };
        self.number(force, &|| "residual_force".to_owned(), found.map(|found| found.residual_force));
        self.number(
            acceleration,
            &|| "residual_acceleration".to_owned(),
            found.map(|found| found.residual_acceleration),
        );
        self.whole("iterations", found.map(|found| found.iterations as u64));
        self.modes(model, held.and_then(|held| held.stability.as_ref()));
        self.positions(model, "", held.map(|held| &held.position[..]));
        self.forces(model, held);
    }

    /// Natural frequencies and damped modes, in the order of statics.
    fn modes(&mut self, model: &Model, stability: Option<&Stability>) {
        // The same number in every case, whatever its verdict.
        let modes = most_modes(model);
        let frequencies: Vec<f64> = stability.map_or(Vec::new(), |stability| stability.frequencies().collect());
        for k in 0..modes {
            self.number("Hz", &|| format!("frequencies_hz[{k}]"), frequencies.get(k).copied());
        }
        if model.has_damping() {
            let damped = stability.map_or(&[][..], |stability| &stability.damped);
            // A mode that creeps has two rates, each of which counts.
            for k in 0..2 * modes {
                let mode = damped.get(k);
                self.number("Hz", &|| format!("damped_frequencies_hz[{k}]"), mode.map(|mode| mode.frequency_hz));
                self.number("", &|| format!("damping_ratios[{k}]"), mode.map(|mode| mode.damping_ratio));
            }
        }
    }

    /// Whether it stands, and by how much.
    fn standing(&mut self, scenario: &Scenario, found: Option<&'a Equilibrium>) {
        let standing = found.and_then(|found| found.standing.as_deref());
        self.word("standing", standing.map(|standing| standing.verdict.name()));
        self.number("", &|| "standing.slack".to_owned(), standing.map(|standing| standing.slack));
        let margin = standing.and_then(|standing| standing.friction_margin);
        self.number("", &|| "standing.friction_margin".to_owned(), margin);
        let numbers = standing.map_or(&[][..], |standing| &standing.margins.numbers);
        let inputs = standing.map_or(&[][..], |standing| &standing.margins.inputs);
        let asked = scenario.margin.numbers.iter().map(|one| ("margins", one, numbers));
        let unknown = scenario.unknown.iter().map(|one| ("inputs", one, inputs));
        for (list, parameter, ranges) in asked.chain(unknown) {
            let range = ranges.iter().find(|one| one.name == parameter.address).map(|one| one.range);
            for side in Side::ALL {
                // Nothing limits it: as in JSON, no number.
                let number = range.map(|range| side.of(range)).filter(|number| number.is_finite());
                self.number(
                    parameter.quantity.unit(),
                    &|| format!("{list}.{}.{}", parameter.address, side.name()),
                    number,
                );
            }
        }
        if scenario.margin.tilt {
            let tilt = standing.map_or(&[][..], |standing| &standing.margins.tilt);
            for direction in ["+x", "-x", "+y", "-y", "+z", "-z"] {
                let one = tilt.iter().find(|(name, ..)| name == direction).map(|(_, value, _)| *value);
                self.number("", &|| format!("margins.tilt.{direction}"), one.filter(|number| number.is_finite()));
            }
        }
    }

    fn positions(&mut self, model: &Model, before: &str, position: Option<&[f64]>) {
        for body in &model.bodies {
            for (index, (name, unit)) in body.hinge.kind.positions().iter().enumerate() {
                let number = position.map(|position| position[body.hinge.position + index]);
                self.number(unit, &|| format!("{before}{}.{name}", body.name), number);
            }
        }
    }

    /// What drives, motors, ropes and curves, locks and stops push with.
    fn forces(&mut self, model: &Model, held: Option<&'a Equilibrium>) {
        let unit = |slides: bool| if slides { "N" } else { "N m" };
        for (index, drive) in model.drives.iter().enumerate() {
            let force = held.and_then(|held| held.drive_forces.get(index)).map(|(_, force)| *force);
            self.number(unit(drive.coordinate.slides), &|| format!("drives.{}", drive.name), force);
        }
        let motors = held.map_or(Vec::new(), |held| model.motor_forces(&held.position, &held.velocity));
        for (index, motor) in model.motors.iter().enumerate() {
            let force = motors.get(index).map(|(_, force)| *force);
            self.number(unit(motor.coordinate.slides), &|| format!("motors.{}", motor.name), force);
        }
        let pulling = model.forces.iter().filter(|force| force.law.pull_name().is_some());
        let pulls = self.pulls(held);
        for (index, force) in pulling.enumerate() {
            self.number("N", &|| format!("pulls.{}", force.name), pulls.get(index).copied());
        }
        for velocity in (0..model.velocity_count()).filter(|velocity| model.coordinates[*velocity].lock) {
            let force = held.map(|held| {
                let label = model.label(velocity);
                held.holding.iter().find(|(name, _)| *name == label).map(|(_, force)| *force)
            });
            let force = force.flatten();
            self.number(force_unit(model, velocity), &|| format!("holding.{}", place(model, velocity)), force);
        }
        for (index, stop) in model.stops.iter().enumerate() {
            // Several stops of a coordinate bear together.
            if model.stops[..index].iter().any(|other| other.velocity == stop.velocity) {
                continue;
            }
            for side in Side::ALL {
                let load = held.map(|held| {
                    let label = model.label(stop.velocity);
                    let here = held.stops.iter().filter(|bearing| bearing.hinge == label && bearing.side == side);
                    here.fold(0.0, |sum, bearing| sum + bearing.load)
                });
                let name = || format!("stops.{}.{}", place(model, stop.velocity), side.name());
                self.number(force_unit(model, stop.velocity), &name, load);
            }
        }
    }

    fn pulls(&self, held: Option<&Equilibrium>) -> Vec<f64> {
        let Some((answer, held)) = self.answer.zip(held) else { return Vec::new() };
        if answer.model.forces.iter().all(|force| force.law.pull_name().is_none()) {
            return Vec::new();
        }
        let mut system = System::new(&answer.model);
        system.at(0.0, &held.position, &held.velocity).pulls().map(|(_, pull)| pull).collect()
    }

    fn run(&mut self, model: &Model) {
        let run = self.answer.and_then(|answer| answer.run.as_ref());
        self.number("s", &|| "end_time".to_owned(), run.map(|run| run.end_time));
        self.whole("steps", run.map(|run| run.statistics.steps));
        self.whole("impacts", run.map(|run| run.impacts as u64));
        self.whole("events", run.map(|run| run.events.len() as u64));
        self.word("stopped_by", run.and_then(|run| run.stopped_by.clone()));
        self.number("J", &|| "energy_drift".to_owned(), run.map(|run| run.energy_drift));
        for (stage, output) in told(model) {
            for (label, unit) in output.labels().zip(&output.units) {
                let is_it = |one: &&(String, String, f64)| one.0 == stage.name && one.1 == label;
                let value = run.and_then(|run| run.told.iter().find(is_it)).map(|(.., value)| *value);
                let name = || format!("{}.{label}", stage.name);
                (self.take)(&|| Column::new(name(), Kind::Number, unit.clone()), value.into());
            }
        }
        // Of a scene with stages these are other coordinates at the end: its outputs say what is asked.
        if model.stages.is_none() {
            self.positions(model, "final ", run.map(|run| &run.state.position[..]));
        }
    }
}

/// The stages of a scene, each with the outputs that are told with it.
pub(super) fn told(model: &Model) -> impl Iterator<Item = (&StageDescription, &Output)> {
    let stages = model.stages.iter().flat_map(|whole| &whole.stages);
    stages.flat_map(|stage| {
        let of_it = model.outputs.iter().filter(|output| stage.outputs.contains(&output.name));
        of_it.map(move |output| (stage, output))
    })
}

/// A velocity coordinate in the heading of a column: the body's name, with its index if the hinge has several.
fn place(model: &Model, velocity: usize) -> String {
    let body = &model.bodies[model.coordinates[velocity].body];
    match body.hinge.kind.velocities().len() {
        1 => body.name.clone(),
        _ => format!("{}[{}]", body.name, velocity - body.hinge.velocity),
    }
}

fn force_unit(model: &Model, velocity: usize) -> &'static str {
    let body = &model.bodies[model.coordinates[velocity].body];
    if body.hinge.kind.velocities()[velocity - body.hinge.velocity].1 == "m/s" { "N" } else { "N m" }
}
