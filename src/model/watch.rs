//! What is watched for while a scene moves: stops of hinge coordinates, and crossings that the user asks for.

use super::build::Place;
use super::description::{Attachment, BodyDescription, Description};
use super::output::{EnergyKind, Output, Quantity};
use super::problem::{Element, Problem};
use super::stop::{LimitDescription, Side, Stop, StopLaw};
use super::{Body, End, Model};
use crate::suggest;
use nalgebra::Vector3;

/// Something a run takes note of, or ends with.
#[derive(Debug, Clone, PartialEq)]
pub struct EventDescription {
    /// Unique name.
    pub name: String,
    /// What is watched.
    pub of: WatchedDescription,
    /// The value that it crosses (m or rad).
    pub value: f64,
    /// Which way counts.
    pub direction: Direction,
    /// Whether the run ends there.
    pub stops: bool,
}

/// A number that changes as a scene moves.
#[derive(Debug, Clone, PartialEq)]
pub enum WatchedDescription {
    /// A hinge coordinate.
    Hinge {
        /// Body whose hinge it is.
        body: String,
        /// Which coordinate, from 0.
        coordinate: usize,
    },
    /// Where a point is along a direction, inertial axes.
    Point {
        /// The point.
        on: Attachment,
        /// The direction; need not be of unit length.
        axis: Vector3<f64>,
    },
    /// An output of one number, or one number of an output.
    Output {
        /// `camber`, or `tip[2]` of an output with several numbers.
        name: String,
    },
}

/// Which way a crossing counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Direction {
    /// From below to above.
    Up,
    /// From above to below.
    Down,
    /// Either.
    Both,
}

/// An event, compiled.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Name.
    pub name: String,
    /// What is watched.
    pub of: Watched,
    /// The value that it crosses (m or rad).
    pub value: f64,
    /// Which way counts.
    pub direction: Direction,
    /// Whether the run ends there.
    pub stops: bool,
}

/// What an event watches, compiled.
#[derive(Debug, Clone, PartialEq)]
pub enum Watched {
    /// Index into the position vector.
    Position(usize),
    /// A point, and a unit vector in inertial axes.
    Point(End, Vector3<f64>),
    /// Index among the numbers of all outputs.
    Output(usize),
}

/// The problems of all limits and events.
pub(super) fn check(description: &Description) -> Vec<Problem> {
    let mut problems = Vec::new();
    for (index, body) in description.bodies.iter().enumerate() {
        let (name, hinge) = (&body.name, &body.hinge);
        problems.extend(second_rigid_stops(index, body));
        let mut add = |message: String, help: &str| {
            let help = (!help.is_empty()).then(|| help.to_owned());
            let (element, field) = (Element::Body(index), "hinge.limits".to_owned());
            problems.push(Problem { element, field, message, help });
        };
        for limit in &hinge.limits {
            let LimitDescription { coordinate, low, high, law } = *limit;
            if coordinate >= hinge.kind.plain_coordinates() {
                let message = format!(
                    "the {} hinge of `{name}` has no coordinate {coordinate} that can be limited",
                    hinge.kind.name()
                );
                add(message, "angles and distances can; the numbers of a quaternion cannot");
            } else if !(low < high) || (low.is_infinite() && high.is_infinite()) {
                add(format!("the limits of the hinge of `{name}` from {low} to {high} are none"), "low comes first");
            }
            let held = hinge.position.get(coordinate).copied().unwrap_or(0.0);
            if hinge.lock && matches!(law, StopLaw::Rigid { .. }) && (held < low || held > high) {
                let message = format!("`{name}` is locked at {held}, beyond its limits from {low} to {high}");
                add(message, "take off the lock, move the position or the limits, or give the stop a `stiffness`");
            }
            let fine = match law {
                StopLaw::Rigid { restitution } => (0.0..=1.0).contains(&restitution),
                StopLaw::Compliant { stiffness, damping } => {
                    stiffness > 0.0 && stiffness.is_finite() && damping >= 0.0 && damping.is_finite()
                }
            };
            if !fine {
                let allowed = "allowed: restitution 0 to 1, or a stiffness above 0 and a damping of at least 0";
                add(format!("the stop of the hinge of `{name}` is {law:?}"), allowed);
            }
        }
    }
    for (index, event) in description.events.iter().enumerate() {
        let element = Element::Event(index);
        let mut add = |field: &str, message: String, help: Option<String>| {
            problems.push(Problem { element, field: field.to_owned(), message, help });
        };
        if description.events[..index].iter().any(|other| other.name == event.name) {
            add("name", format!("two events are called `{}`", event.name), Some("names must be unique".to_owned()));
        }
        if !event.value.is_finite() {
            add("value", format!("the value of event `{}` is {}", event.name, event.value), None);
        }
        let known = || description.bodies.iter().map(|body| body.name.as_str());
        match &event.of {
            WatchedDescription::Hinge { body, coordinate } => match description.bodies.iter().find(|b| b.name == *body)
            {
                None => {
                    let near = suggest::closest_of_many(index, body, known());
                    let help = near.map(|near| format!("did you mean `{near}`?"));
                    add("hinge", format!("there is no body `{body}`"), help);
                }
                Some(found) if *coordinate >= found.hinge.kind.plain_coordinates() => {
                    let kind = found.hinge.kind.name();
                    let message = format!("the {kind} hinge of `{body}` has no coordinate {coordinate} to watch");
                    let help = "angles and distances can be watched; for a quaternion watch a point of the body";
                    add("coordinate", message, Some(help.to_owned()));
                }
                Some(_) => {}
            },
            WatchedDescription::Point { axis, .. } => {
                if !(axis.norm() > 0.0 && axis.norm().is_finite()) {
                    add("axis", format!("the axis of event `{}` has no direction", event.name), None);
                }
            }
            // What it watches is looked up when outputs are compiled.
            WatchedDescription::Output { .. } => {}
        }
    }
    problems
}

/// Rigid stops on a side of a coordinate that has one already: the one behind would never be reached.
fn second_rigid_stops(index: usize, body: &BodyDescription) -> Vec<Problem> {
    let sides = |limit: &LimitDescription| {
        let rigid = limit.law.is_rigid();
        Side::ALL.map(|side| {
            let at = side.of([limit.low, limit.high]);
            (limit.coordinate, side, at, rigid && at.is_finite())
        })
    };
    let limits = &body.hinge.limits;
    let mut problems = Vec::new();
    for (place, limit) in limits.iter().enumerate() {
        for (coordinate, side, at, _) in sides(limit).into_iter().filter(|(.., rigid)| *rigid) {
            let same = |other: &&(usize, Side, f64, bool)| other.3 && (other.0, other.1) == (coordinate, side);
            let Some(first) = limits[..place].iter().flat_map(sides).find(|other| same(&other)) else { continue };
            let message = format!(
                "coordinate {coordinate} of the hinge of `{}` has a second rigid stop on its {} side, at {at}: the first is at {}",
                body.name,
                side.name(),
                first.2
            );
            let help =
                "keep the one that is reached first, or give the other a `stiffness`: compliant stops may overlap";
            let field = format!("hinge.limits[{place}]");
            problems.push(Problem { element: Element::Body(index), field, message, help: Some(help.to_owned()) });
        }
        // One table from high to low is refused where it is read.
        let own = sides(limit).into_iter().filter(|(.., rigid)| *rigid);
        let crossed = own.flat_map(|(coordinate, side, at, _)| {
            let others = limits[..place].iter().flat_map(sides);
            let other = others.filter(move |other| other.3 && other.0 == coordinate && other.1 != side);
            other.map(move |other| (coordinate, side.of([[at, other.2], [other.2, at]])))
        });
        for (coordinate, [low, high]) in crossed.filter(|(_, [low, high])| low >= high) {
            let message = format!(
                "coordinate {coordinate} of the hinge of `{}` has its low rigid stop at {low} and its high one at {high}: they leave no room",
                body.name
            );
            let help = "the low one is below the high one; a hinge without room is one of type `fixed`";
            let field = format!("hinge.limits[{place}]");
            problems.push(Problem { element: Element::Body(index), field, message, help: Some(help.to_owned()) });
        }
    }
    problems
}

/// The stops of a scene without problems.
pub(super) fn stops(description: &Description, bodies: &[Body]) -> Vec<Stop> {
    let of_body = |(body, (written, built)): (usize, (&BodyDescription, &Body))| {
        let (position, velocity) = (built.hinge.position, built.hinge.velocity);
        let stop = move |limit: &LimitDescription| Stop {
            body,
            position: position + limit.coordinate,
            velocity: velocity + limit.coordinate,
            range: [limit.low, limit.high],
            law: limit.law,
        };
        written.hinge.limits.iter().map(stop).collect::<Vec<_>>()
    };
    description.bodies.iter().zip(bodies).enumerate().flat_map(of_body).collect()
}

/// Compiles the events of a scene whose outputs are compiled into its model; `end` compiles a point on a body.
pub(super) fn events(
    description: &Description,
    end: impl Fn(&Place) -> End,
    points: &[Option<Place>],
    model: &mut Model,
) -> Vec<Problem> {
    let mut problems = Vec::new();
    for (index, (event, point)) in description.events.iter().zip(points).enumerate() {
        let of = match (&event.of, point) {
            (WatchedDescription::Hinge { body, coordinate }, _) => {
                let built = model.bodies.iter().find(|built| built.name == *body);
                built.map(|built| Watched::Position(built.hinge.position + coordinate))
            }
            (WatchedDescription::Point { axis, .. }, Some(place)) => Some(Watched::Point(end(place), axis.normalize())),
            (WatchedDescription::Point { .. }, None) => None,
            (WatchedDescription::Output { name }, _) => match watched_output(model, name) {
                Ok(number) => Some(Watched::Output(number)),
                Err((message, help)) => {
                    let (element, field) = (Element::Event(index), "output".to_owned());
                    problems.push(Problem { element, field, message, help });
                    None
                }
            },
        };
        let EventDescription { name, value, direction, stops, .. } = event.clone();
        model.events.extend(of.map(|of| Event { name, of, value, direction, stops }));
    }
    problems
}

/// The number of an output that an event watches, among those of all outputs; or what is wrong with its name.
fn watched_output(model: &Model, name: &str) -> Result<usize, (String, Option<String>)> {
    let labels = || model.outputs.iter().flat_map(Output::labels);
    if let Some(output) = model.outputs.iter().find(|output| output.name == name && output.units.len() > 1) {
        let help = format!("watch one of them: `{name}[0]`");
        return Err((format!("the output `{name}` has {} numbers", output.units.len()), Some(help)));
    }
    let Some(number) = labels().position(|label| label == name) else {
        let known: Vec<String> = labels().collect();
        let near = suggest::closest(name, known.iter().map(String::as_str));
        return Err((format!("there is no output `{name}`"), near.map(|near| format!("did you mean `{near}`?"))));
    };
    let output = model.outputs.iter().find(|output| output.range().contains(&number));
    match output.map(|output| &output.quantity) {
        Some(Quantity::Energy(EnergyKind::Input | EnergyKind::Dissipated)) => {
            let help = "watch a power, or a kinetic or potential energy".to_owned();
            Err((format!("`{name}` is added up from step to step, and is not known within one"), Some(help)))
        }
        _ => Ok(number),
    }
}

/// The point that an event watches.
pub(super) fn attachment(event: &EventDescription) -> Option<&Attachment> {
    match &event.of {
        WatchedDescription::Point { on, .. } => Some(on),
        WatchedDescription::Hinge { .. } | WatchedDescription::Output { .. } => None,
    }
}
