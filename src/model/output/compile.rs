//! From described outputs to compiled ones.

use super::super::build::Place;
use super::super::description::{Attachment, Description, Point};
use super::super::problem::{Element, Problem};
use super::super::{End, Model};
use super::named::{Unknown, coordinates, line, section, source};
use super::{
    AngleQuantity, Axes, CoordinateQuantity, DirectionDescription, DistanceQuantity, ExpressionQuantity, ForceQuantity,
    Order, OrientationQuantity, Output, OutputDescription, PointQuantity, Quantity, QuantityDescription, RateQuantity,
    ReactionQuantity, SectionQuantity, Source,
};
use crate::formula::Formula;
use nalgebra::{UnitQuaternion, Vector3};
use std::collections::{HashMap, HashSet};

/// The most numbers that the outputs of a scene may have.
const MOST_NUMBERS: usize = 100_000;

/// The points and bodies that an output names, each with its key in scenario files.
pub(in crate::model) fn attachments(of: &QuantityDescription) -> Vec<(&'static str, Attachment)> {
    let root = |body: &str| Attachment { body: body.to_owned(), point: Point::At(Vector3::zeros()) };
    match of {
        QuantityDescription::Point { on, .. } => vec![("of", on.clone())],
        QuantityDescription::Distance { between: [a, b] } => {
            vec![("between[0]", a.clone()), ("between[1]", b.clone())]
        }
        QuantityDescription::Angle { of, against, .. } => {
            vec![("of.body", root(&of.body)), ("against.body", root(&against.body))]
        }
        QuantityDescription::Orientation { body } | QuantityDescription::Reaction { body, .. } => {
            vec![("of", root(body))]
        }
        _ => Vec::new(),
    }
}

/// Compiles the outputs of a scene whose tree and couplings are complete into its model.
pub(in crate::model) fn compile(
    description: &Description,
    places: &[Vec<Place>],
    carrier: &dyn Fn(&Place) -> (End, UnitQuaternion<f64>),
    model: &mut Model,
) -> Vec<Problem> {
    let mut compiler = Compiler { description, model, problems: Vec::new() };
    compiler.check_names();
    let mut compiled: Vec<Option<(Vec<String>, Quantity)>> = Vec::new();
    for (index, (output, places)) in description.outputs.iter().zip(places).enumerate() {
        let carried: Vec<(End, UnitQuaternion<f64>)> = places.iter().map(carrier).collect();
        compiled.push(compiler.one(index, output, &carried));
    }
    if !compiler.problems.is_empty() {
        return compiler.problems;
    }
    let mut first = 0;
    let mut outputs = Vec::new();
    for (output, compiled) in description.outputs.iter().zip(compiled) {
        let Some((units, quantity)) = compiled else { continue };
        outputs.push(Output { name: output.name.clone(), units, first, quantity });
        first = outputs.last().map_or(0, |output| output.range().end);
    }
    if first > MOST_NUMBERS {
        let message = format!("the outputs have {first} numbers, more than {MOST_NUMBERS}");
        return vec![Problem { element: Element::Scene, field: "output".to_owned(), message, help: None }];
    }
    let mut problems = shared_names(&outputs);
    if problems.is_empty() {
        problems = expressions(description, &mut outputs);
    }
    model.outputs = outputs;
    problems
}

struct Compiler<'a> {
    description: &'a Description,
    model: &'a Model,
    problems: Vec<Problem>,
}

impl Compiler<'_> {
    fn add(&mut self, index: usize, field: &str, message: String, help: &str) {
        let help = (!help.is_empty()).then(|| help.to_owned());
        self.problems.push(Problem { element: Element::Output(index), field: field.to_owned(), message, help });
    }

    fn check_names(&mut self) {
        let mut seen = HashSet::new();
        let description = self.description;
        for (index, output) in description.outputs.iter().enumerate() {
            let name = output.name.as_str();
            if name.is_empty() {
                self.add(index, "name", "an output's name is empty".to_owned(), "");
            } else if name == "t" {
                self.add(index, "name", "an output cannot be called `t`".to_owned(), "in formulas that is the time");
            } else if name == "time" {
                self.add(
                    index,
                    "name",
                    "an output cannot be called `time`".to_owned(),
                    "tables have a column of that name",
                );
            } else if !seen.insert(name) {
                self.add(index, "name", format!("two outputs are called `{name}`"), "names must be unique");
            }
        }
    }

    /// The direction of a vector; one without is a problem.
    fn unit(&mut self, index: usize, field: &str, axis: &Vector3<f64>) -> Vector3<f64> {
        let length = axis.norm();
        if length > 0.0 && length.is_finite() {
            return axis / length;
        }
        let name = &self.description.outputs[index].name;
        self.add(
            index,
            field,
            format!("`{field}` of output `{name}` has no direction"),
            "allowed: a vector of any length but zero",
        );
        Vector3::z()
    }

    /// The unit of the stress in a section, which needs a size.
    fn stress(&mut self, index: usize, beam: usize, s: f64) -> Vec<String> {
        let beam = &self.model.beams[beam];
        if beam.section_at(s).geometry().is_none() {
            let (name, beam) = (&self.description.outputs[index].name, &beam.name);
            let message = format!(
                "output `{name}`: the section of `{beam}` has a stiffness and no size: its stress is not known"
            );
            self.add(
                index,
                "component",
                message,
                "ask for `my` or `mz`, or give the section as `circle`, `tube` or `rectangle`",
            );
        }
        vec!["Pa".to_owned()]
    }

    fn known<T>(&mut self, index: usize, found: Result<T, Unknown>) -> Option<T> {
        found
            .map_err(|Unknown { message, help }| {
                let name = &self.description.outputs[index].name;
                self.add(index, "of", format!("output `{name}`: {message}"), help.as_deref().unwrap_or_default());
            })
            .ok()
    }

    fn one(
        &mut self,
        index: usize,
        output: &OutputDescription,
        carried: &[(End, UnitQuaternion<f64>)],
    ) -> Option<(Vec<String>, Quantity)> {
        let of = |unit: &str, count: usize| vec![unit.to_owned(); count];
        Some(match &output.of {
            QuantityDescription::Point { order, axis, axes, .. } => {
                let (end, turn) = carried[0];
                let axis = axis.map(|axis| self.unit(index, "axis", &axis));
                let turn = (*axes == Axes::Body).then(|| *turn.to_rotation_matrix().matrix());
                let unit = match order {
                    Order::Position => "m",
                    Order::Velocity => "m/s",
                    Order::Acceleration => "m/s²",
                };
                let count = if axis.is_some() { 1 } else { 3 };
                (of(unit, count), Quantity::Point(PointQuantity { order: *order, end, axis, turn }))
            }
            QuantityDescription::Distance { .. } => {
                (of("m", 1), Quantity::Distance(DistanceQuantity { ends: [carried[0].0, carried[1].0] }))
            }
            QuantityDescription::Angle { of: one, against, about } => {
                (of("rad", 1), Quantity::Angle(self.angle(index, [one, against], about.as_ref(), carried)))
            }
            QuantityDescription::Orientation { .. } => {
                (of("1", 4), Quantity::Orientation(OrientationQuantity { body: self.body(index, &carried[0].0)? }))
            }
            QuantityDescription::Coordinate { of } => {
                let found = coordinates(self.model, of, false);
                let (range, units) = self.known(index, found)?;
                (units, Quantity::Coordinate(CoordinateQuantity { range }))
            }
            QuantityDescription::Rate { of } => {
                let found = coordinates(self.model, of, true);
                let (range, units) = self.known(index, found)?;
                (units, Quantity::Rate(RateQuantity { range }))
            }
            QuantityDescription::Force { of, component } => {
                let found = source(self.description, self.model, of);
                let source = self.known(index, found)?;
                self.force(index, source, *component)?
            }
            QuantityDescription::Length { of: name } => {
                let found = line(self.model, name);
                (of("m", 1), Quantity::Length(self.known(index, found)?))
            }
            QuantityDescription::Section { of: name, s, component } => {
                let found = section(self.model, name, *s);
                let (beam, component) = (self.known(index, found)?, *component);
                let units = match component {
                    Some(SectionQuantity::STRESS) => self.stress(index, beam, *s),
                    _ => six(component),
                };
                (units, Quantity::Section(SectionQuantity { beam, s: *s, component }))
            }
            QuantityDescription::Reaction { component, axes, .. } => {
                let body = self.body(index, &carried[0].0)?;
                let (component, axes) = (*component, *axes);
                (six(component), Quantity::Reaction(ReactionQuantity { body, component, axes }))
            }
            QuantityDescription::Energy(kind) => (of("J", 1), Quantity::Energy(*kind)),
            QuantityDescription::Power(kind) => (of("W", 1), Quantity::Power(*kind)),
            // Its formula is read when the numbers of all outputs are known.
            QuantityDescription::Expression { unit, .. } => {
                let formula = Formula::parse("0", &[]).ok()?;
                (of(unit, 1), Quantity::Expression(ExpressionQuantity { formula, depth: 1 }))
            }
        })
    }

    fn angle(
        &mut self,
        index: usize,
        directions: [&DirectionDescription; 2],
        about: Option<&Vector3<f64>>,
        carried: &[(End, UnitQuaternion<f64>)],
    ) -> AngleQuantity {
        let keys = ["of", "against"];
        let directions = [0, 1].map(|i| {
            let (end, turn) = &carried[i];
            (end.link, turn * self.unit(index, &format!("{}.axis", keys[i]), &directions[i].axis))
        });
        let about = about.map(|about| carried[1].1 * self.unit(index, "about", about));
        AngleQuantity { directions, about }
    }

    /// A body, not the ground.
    fn body(&mut self, index: usize, end: &End) -> Option<usize> {
        if end.body.is_none() {
            let name = &self.description.outputs[index].name;
            self.add(index, "of", format!("output `{name}` is of the ground"), "name a body");
        }
        end.body
    }

    fn force(&mut self, index: usize, source: Source, component: Option<usize>) -> Option<(Vec<String>, Quantity)> {
        let push = |slides: bool| vec![if slides { "N" } else { "N m" }.to_owned()];
        let units = match &source {
            Source::Element(_) | Source::Loop(_) => six(component),
            Source::Line(_) | Source::Rod(_) => push(true),
            Source::Motor(motor) => push(self.model.motors[*motor].coordinate.slides),
            Source::Drive(drive) => push(self.model.drives[*drive].coordinate.slides),
            Source::Gear(gear) => push(self.model.gears[*gear].coordinates[0].slides),
            Source::Contact(_) => match component {
                None => vec!["N".to_owned(); 3],
                Some(..3) => push(true),
                Some(_) => {
                    let name = &self.description.outputs[index].name;
                    let message = format!("output `{name}`: the force of a contact has no moment");
                    self.add(index, "component", message, "it has `fx`, `fy` and `fz`");
                    return None;
                }
            },
            Source::Stops(velocities) => velocities.iter().flat_map(|at| push(slides(self.model, *at))).collect(),
        };
        if component.is_some() && !matches!(source, Source::Element(_) | Source::Loop(_) | Source::Contact(_)) {
            let name = &self.description.outputs[index].name;
            let message = format!("output `{name}`: this force has no components");
            self.add(
                index,
                "component",
                message,
                "bushings, loads, contacts, and loops that are no rods have components",
            );
            return None;
        }
        Some((units, Quantity::Force(ForceQuantity { source, component })))
    }
}

/// Whether a velocity coordinate is that of a distance.
fn slides(model: &Model, velocity: usize) -> bool {
    let hinge = &model.bodies[model.coordinates[velocity].body].hinge;
    hinge.kind.velocities()[velocity - hinge.velocity].1 == "m/s"
}

/// Units of a force and a moment, or of one of their components.
fn six(component: Option<usize>) -> Vec<String> {
    let all = ["N", "N", "N", "N m", "N m", "N m"].map(str::to_owned);
    component.map_or_else(|| all.to_vec(), |index| vec![all[index].clone()])
}

/// Outputs with the name of a number of another one: recordings, tables and formulas know numbers by name.
fn shared_names(outputs: &[Output]) -> Vec<Problem> {
    let several = outputs.iter().filter(|output| output.units.len() > 1);
    let numbers: HashMap<String, &str> =
        several.flat_map(|output| output.labels().map(|label| (label, output.name.as_str()))).collect();
    let named =
        outputs.iter().enumerate().filter_map(|(index, output)| Some((index, output, numbers.get(&output.name)?)));
    let problem = |(index, output, of): (usize, &Output, &&str)| Problem {
        element: Element::Output(index),
        field: "name".to_owned(),
        message: format!("an output cannot be called `{}`: that is a number of the output `{of}`", output.name),
        help: Some(format!("give it another name, or leave it out: `{}` can be asked for by this name", output.name)),
    };
    named.map(problem).collect()
}

/// Reads the formulas of expressions, and orders them: each follows from others of lower depth.
fn expressions(description: &Description, outputs: &mut [Output]) -> Vec<Problem> {
    let mut problems = Vec::new();
    let labels: Vec<String> = outputs.iter().flat_map(Output::labels).collect();
    let names: Vec<&str> = std::iter::once("t").chain(labels.iter().map(String::as_str)).collect();
    let owners: Vec<usize> = outputs.iter().enumerate().flat_map(|(i, output)| vec![i; output.units.len()]).collect();
    // Of each expression the outputs that it follows from.
    let mut uses: Vec<Vec<usize>> = vec![Vec::new(); outputs.len()];
    for (index, described) in description.outputs.iter().enumerate() {
        let QuantityDescription::Expression { text, .. } = &described.of else { continue };
        match Formula::parse(text, &names) {
            Ok(formula) => {
                uses[index] = (0..owners.len()).filter(|k| formula.uses(k + 1)).map(|k| owners[k]).collect();
                outputs[index].quantity = Quantity::Expression(ExpressionQuantity { formula, depth: 0 });
            }
            Err(error) => problems.push(Problem {
                element: Element::Output(index),
                field: "expression".to_owned(),
                message: format!("output `{}`: {}", described.name, error.in_words(text)),
                help: error.help,
            }),
        }
    }
    if !problems.is_empty() {
        return problems;
    }
    let is_expression = |output: &Output| matches!(output.quantity, Quantity::Expression(_));
    let mut depths: Vec<Option<usize>> = outputs.iter().map(|output| (!is_expression(output)).then_some(0)).collect();
    loop {
        let ready = |i: &usize| depths[*i].is_none() && uses[*i].iter().all(|used| depths[*used].is_some());
        let Some(index) = (0..outputs.len()).find(ready) else { break };
        let deepest = uses[index].iter().filter_map(|used| depths[*used]).max().unwrap_or(0);
        depths[index] = Some(deepest + 1);
        if let Quantity::Expression(expression) = &mut outputs[index].quantity {
            expression.depth = deepest + 1;
        }
    }
    problems.extend(depths.iter().position(Option::is_none).map(|start| cycle(outputs, &uses, &depths, start)));
    problems
}

/// The problem that expressions follow from each other.
fn cycle(outputs: &[Output], uses: &[Vec<usize>], depths: &[Option<usize>], start: usize) -> Problem {
    let (mut path, mut at) = (Vec::new(), start);
    while !path.contains(&at) {
        path.push(at);
        at = uses[at].iter().copied().find(|used| depths[*used].is_none()).unwrap_or(start);
    }
    let from = path.iter().position(|index| *index == at).unwrap_or(0);
    let ring = path[from..].iter().chain([&at]).map(|index| outputs[*index].name.as_str());
    let message = format!("outputs follow from each other: `{}`", ring.collect::<Vec<_>>().join("` uses `"));
    let help = Some("one of them must be written without the others".to_owned());
    Problem { element: Element::Output(at), field: "expression".to_owned(), message, help }
}
