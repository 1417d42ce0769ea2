//! Motors: forces in hinge coordinates that follow a law of time, place and speed.

use super::Model;
use super::controller;
use super::couple::{Scalar, scalar};
use super::couplings::{CoordinateName, MotionDescription};
use super::description::Description;
use super::prescribed::Prescribed;
use super::problem::{Element, Problem, counted};
use crate::formula::{CellEnd, Formula, Pieces};
use std::borrow::Cow;
use std::collections::HashMap;

/// A force (N) or torque (N m) in a hinge coordinate, as a user describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct MotorDescription {
    /// Unique name; scenario files without one get `motor[i]`.
    pub name: String,
    /// Where it acts.
    pub coordinate: CoordinateName,
    /// What it pushes with.
    pub law: MotorLawDescription,
    /// It never pushes with more (N or N m), > 0; `None` for no limit.
    pub limit: Option<f64>,
}

/// The law of a motor.
#[derive(Debug, Clone, PartialEq)]
pub enum MotorLawDescription {
    /// Always the same.
    Constant {
        /// Force (N or N m).
        force: f64,
    },
    /// Straight lines through points, constant before the first and after the last.
    Table {
        /// What it is looked up by.
        over: Over,
        /// (s, or m/s or rad/s), increasing.
        at: Vec<f64>,
        /// Forces (N or N m).
        forces: Vec<f64>,
    },
    /// `stiffness (s − q) + damping (ṡ − q̇) + force`, towards the target `s(t)`.
    Pd {
        /// The target.
        target: TargetDescription,
        /// (N/m or N m/rad), ≥ 0.
        stiffness: f64,
        /// (N s/m or N m s/rad), ≥ 0.
        damping: f64,
        /// Added (N or N m).
        force: f64,
    },
    /// A formula in the time `t` (s), the coordinate `q` (m or rad) and its rate `v` (m/s or rad/s).
    Expression {
        /// As written.
        text: String,
    },
    /// A number from outside.
    Input {
        /// What it pushes with until one comes (N or N m); `None` for the bias of its controller, zero without one.
        force: Option<f64>,
    },
}

/// What a table of forces is looked up by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Over {
    /// The time.
    Time,
    /// The rate of the coordinate.
    Speed,
}

/// Where a motor wants its coordinate to be.
#[derive(Debug, Clone, PartialEq)]
pub enum TargetDescription {
    /// At a value (m or rad).
    Value(f64),
    /// On a motion, as drives have it.
    Motion(MotionDescription),
}

/// A motor, compiled.
#[derive(Debug, Clone)]
pub struct Motor {
    /// Name.
    pub name: String,
    /// Where it acts.
    pub coordinate: Scalar,
    law: MotorLaw,
    /// Infinite for none.
    limit: f64,
}

#[derive(Debug, Clone)]
enum MotorLaw {
    Constant(f64),
    Table { over: Over, at: Vec<f64>, forces: Vec<f64> },
    Pd { target: Prescribed, stiffness: f64, damping: f64, force: f64 },
    Formula(Box<Formula>),
    Input(f64),
}

/// What a formula of a motor may use: the time (s), the coordinate (m or rad) and its rate (m/s or rad/s).
pub const VARIABLES: [&str; 3] = ["t", "q", "v"];
const TIME: usize = 0;
const COORDINATE: usize = 1;
const SPEED: usize = 2;

/// What a motor pushes with at one state.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Push {
    /// Force (N or N m).
    pub force: f64,
    /// Its derivative with respect to the coordinate (N/m or N m/rad).
    pub by_position: f64,
    /// Its derivative with respect to the rate (N s/m or N m s/rad).
    pub by_velocity: f64,
}

impl Motor {
    /// The push at a time (s), place and rate of its coordinate.
    pub fn at(&self, time: f64, q: f64, v: f64) -> Push {
        self.within(&Pieces::default(), time, q, v)
    }

    /// As [`Motor::at`], with its formula kept in pieces.
    pub fn within(&self, pieces: &Pieces, time: f64, q: f64, v: f64) -> Push {
        let push = match &self.law {
            MotorLaw::Constant(force) | MotorLaw::Input(force) => Push { force: *force, ..Push::default() },
            MotorLaw::Table { over: Over::Time, at, forces } => {
                Push { force: straight(at, forces, time).0, ..Push::default() }
            }
            MotorLaw::Table { over: Over::Speed, at, forces } => {
                let (force, slope) = straight(at, forces, v);
                Push { force, by_position: 0.0, by_velocity: slope }
            }
            MotorLaw::Pd { target, stiffness, damping, force } => {
                let now = target.at(time);
                Push {
                    force: stiffness * (now.position - q) + damping * (now.velocity - v) + force,
                    by_position: -stiffness,
                    by_velocity: -damping,
                }
            }
            MotorLaw::Formula(formula) => {
                let (force, [by_position, by_velocity]) =
                    formula.gradient_within(pieces, &[time, q, v], [COORDINATE, SPEED]);
                Push { force, by_position, by_velocity }
            }
        };
        // Written so that a number that is not one stays visible.
        match push.force.abs() > self.limit {
            true => self.saturated(push.force),
            false => push,
        }
    }

    /// The pieces of its formula; none if it has no formula that switches with its coordinate.
    pub fn pieces(&self) -> Pieces {
        match &self.law {
            MotorLaw::Formula(formula) => formula.pieces(&[COORDINATE, SPEED]),
            _ => Pieces::default(),
        }
    }

    /// Keeps its formula in the pieces that a state belongs to.
    pub fn keep(&self, pieces: &mut Pieces, time: f64, q: f64, v: f64) {
        if let MotorLaw::Formula(formula) = &self.law {
            formula.keep(pieces, &[time, q, v], &[1.0, v, 0.0]);
        }
    }

    /// How far a piece of its formula is above an end, and its derivatives by the time, the coordinate and its rate.
    pub fn above(&self, pieces: &Pieces, end: CellEnd, time: f64, q: f64, v: f64) -> (f64, [f64; 3]) {
        match &self.law {
            MotorLaw::Formula(formula) => formula.above(pieces, end, &[time, q, v], [TIME, COORDINATE, SPEED]),
            _ => (f64::NAN, [0.0; 3]),
        }
    }

    /// What it pushes with if a number from outside asks for `force`, within its limit.
    pub fn saturated(&self, force: f64) -> Push {
        let force = if force.abs() > self.limit { self.limit.copysign(force) } else { force };
        Push { force, ..Push::default() }
    }

    /// Lets one of type `input` push with this until a number comes (N or N m).
    pub(super) fn give(&mut self, force: f64) {
        if let MotorLaw::Input(given) = &mut self.law {
            *given = force;
        }
    }

    /// The most that it pushes with (N or N m); infinite for no limit.
    pub fn limit(&self) -> f64 {
        self.limit
    }

    /// Of one of type `input` what it pushes with until a number comes (N or N m).
    pub fn given(&self) -> Option<f64> {
        match self.law {
            MotorLaw::Input(force) => Some(force),
            MotorLaw::Constant(_) | MotorLaw::Table { .. } | MotorLaw::Pd { .. } | MotorLaw::Formula(_) => None,
        }
    }

    /// The formula of its law, or of its target, as written.
    pub fn formula(&self) -> Option<&str> {
        match &self.law {
            MotorLaw::Formula(formula) => Some(formula.text()),
            MotorLaw::Pd { target, .. } => target.formula(),
            MotorLaw::Constant(_) | MotorLaw::Input(_) | MotorLaw::Table { .. } => None,
        }
    }

    /// The times at which its law begins to follow another rule (s), of a formula those within a run ([`Formula::instants`]).
    pub fn breaks(&self, run: [f64; 2]) -> Cow<'_, [f64]> {
        match &self.law {
            MotorLaw::Table { over: Over::Time, at, .. } => Cow::Borrowed(at),
            MotorLaw::Pd { target, .. } => target.breaks(run),
            MotorLaw::Formula(formula) => Cow::Owned(formula.instants(TIME, run)),
            MotorLaw::Constant(_) | MotorLaw::Input(_) | MotorLaw::Table { .. } => Cow::Borrowed(&[]),
        }
    }

    /// Whether a formula says what it does over time.
    pub fn is_formula(&self) -> bool {
        match &self.law {
            MotorLaw::Pd { target, .. } => target.is_formula(),
            MotorLaw::Formula(_) => true,
            MotorLaw::Constant(_) | MotorLaw::Input(_) | MotorLaw::Table { .. } => false,
        }
    }

    /// As [`Prescribed::longest_step`].
    pub fn longest_step(&self, run: f64) -> f64 {
        match &self.law {
            MotorLaw::Pd { target, .. } => target.longest_step(run),
            MotorLaw::Formula(formula) if formula.uses(TIME) => 0.01 * run,
            MotorLaw::Formula(_) | MotorLaw::Constant(_) | MotorLaw::Input(_) | MotorLaw::Table { .. } => f64::INFINITY,
        }
    }

    /// Whether it follows a formula of its coordinate, which may be anything anywhere.
    pub fn is_of_place(&self) -> bool {
        matches!(&self.law, MotorLaw::Formula(formula) if formula.uses(COORDINATE))
    }

    /// The shortest way of its coordinate over which something in its formula can come and go (m, rad), as [`Formula::detail`].
    pub fn detail(&self) -> f64 {
        if let MotorLaw::Formula(formula) = &self.law { formula.detail(COORDINATE) } else { f64::INFINITY }
    }

    /// Whether its force is the same at all times as long as its coordinate rests.
    pub fn is_steady(&self) -> bool {
        match &self.law {
            MotorLaw::Constant(_) | MotorLaw::Input(_) | MotorLaw::Table { over: Over::Speed, .. } => true,
            MotorLaw::Table { over: Over::Time, .. } => false,
            MotorLaw::Pd { target, .. } => target.is_steady() && target.at(0.0).velocity == 0.0,
            MotorLaw::Formula(formula) => !formula.uses(TIME),
        }
    }

    /// Whether its force at rest at t = 0 is the derivative of a potential that is known.
    pub fn has_potential(&self) -> bool {
        match &self.law {
            MotorLaw::Formula(formula) => !formula.uses(COORDINATE),
            MotorLaw::Constant(_) | MotorLaw::Input(_) | MotorLaw::Table { .. } | MotorLaw::Pd { .. } => true,
        }
    }

    /// Whether its force depends on the speed of its coordinate.
    pub fn has_damping(&self) -> bool {
        match &self.law {
            MotorLaw::Pd { damping, .. } => *damping != 0.0,
            MotorLaw::Formula(formula) => formula.uses(SPEED),
            MotorLaw::Table { over, .. } => *over == Over::Speed,
            MotorLaw::Constant(_) | MotorLaw::Input(_) => false,
        }
    }

    /// Its force at rest at t = 0 where that is the same at every place of its coordinate (N or N m).
    pub fn constant(&self) -> Option<f64> {
        let follows = match &self.law {
            MotorLaw::Formula(formula) => formula.uses(COORDINATE),
            MotorLaw::Pd { stiffness, .. } => *stiffness != 0.0,
            MotorLaw::Constant(_) | MotorLaw::Input(_) | MotorLaw::Table { .. } => false,
        };
        (!follows).then(|| self.at(0.0, 0.0, 0.0).force)
    }

    /// The potential (J) of its force at rest at t = 0, if it has one: statics goes down it.
    pub fn potential(&self, q: f64) -> f64 {
        let MotorLaw::Pd { target, stiffness, damping, force } = &self.law else {
            return -self.at(0.0, q, 0.0).force * q;
        };
        let start = target.at(0.0);
        let x = q - start.position;
        let bias = damping * start.velocity + force;
        if *stiffness == 0.0 {
            return -bias.clamp(-self.limit, self.limit) * x;
        }
        // Within its limit a parabola, beyond its tangents.
        let ends = [(bias - self.limit) / stiffness, (bias + self.limit) / stiffness];
        let within = x.clamp(ends[0].min(ends[1]), ends[0].max(ends[1]));
        let pushes = bias - stiffness * within;
        0.5 * stiffness * within * within - bias * within - pushes * (x - within)
    }
}

/// Straight lines through points: value and slope.
fn straight(at: &[f64], values: &[f64], x: f64) -> (f64, f64) {
    let last = at.len() - 1;
    if x <= at[0] {
        return (values[0], 0.0);
    }
    if x >= at[last] {
        return (values[last], 0.0);
    }
    let i = at.partition_point(|point| *point <= x).clamp(1, last) - 1;
    let slope = (values[i + 1] - values[i]) / (at[i + 1] - at[i]);
    (values[i] + slope * (x - at[i]), slope)
}

/// Problems of motors that need no tree.
pub(super) fn check(description: &Description, problems: &mut Vec<Problem>) {
    let mut seen = HashMap::new();
    for (index, motor) in description.motors.iter().enumerate() {
        let mut add = |field: &str, message: String, help: &str| {
            let element = Element::Motor(index);
            problems.push(Problem { element, field: field.to_owned(), message, help: Some(help.to_owned()) });
        };
        let name = &motor.name;
        if seen.insert(name, index).is_some() {
            add("name", format!("two motors are called `{name}`"), "names must be unique");
        }
        let numbers = match &motor.law {
            MotorLawDescription::Constant { force } => vec![("force", *force, f64::NEG_INFINITY)],
            MotorLawDescription::Pd { stiffness, damping, force, .. } => {
                vec![("stiffness", *stiffness, 0.0), ("damping", *damping, 0.0), ("force", *force, f64::NEG_INFINITY)]
            }
            MotorLawDescription::Input { force } => {
                force.iter().map(|force| ("force", *force, f64::NEG_INFINITY)).collect()
            }
            MotorLawDescription::Table { .. } | MotorLawDescription::Expression { .. } => vec![],
        };
        let limit = motor.limit.map(|limit| ("limit", limit, f64::MIN_POSITIVE));
        for (field, value, least) in numbers.into_iter().chain(limit) {
            if !value.is_finite() || value < least {
                let allowed = match least {
                    0.0 => "allowed: a finite number ≥ 0",
                    least if least > 0.0 => "allowed: a finite number > 0",
                    _ => "allowed: a finite number",
                };
                add(field, format!("`{field}` of `{name}` is {value}"), allowed);
            }
        }
        if let MotorLawDescription::Table { at, forces, .. } = &motor.law
            && let Some(message) = table_problem(at, forces)
        {
            add("at", format!("`{name}`: {message}"), "for example `at = [0.0, 1.0]`, `forces = [0.0, 5.0]`");
        }
    }
}

fn table_problem(at: &[f64], forces: &[f64]) -> Option<String> {
    if at.len() != forces.len() {
        return Some(format!(
            "{} and {}: there must be as many",
            counted(at.len(), "point", "points"),
            counted(forces.len(), "force", "forces")
        ));
    }
    if at.is_empty() {
        return Some("a table needs at least one point".to_owned());
    }
    if let Some(bad) = at.iter().chain(forces).find(|x| !x.is_finite()) {
        return Some(format!("a table holds {bad}: all its numbers must be finite"));
    }
    let back = at.windows(2).find(|pair| pair[1] <= pair[0])?;
    Some(format!("points must increase, but {} comes after {}", back[1], back[0]))
}

/// Compiles the motors of a model whose tree and drives are complete.
pub(super) fn motors(description: &Description, model: &mut Model, problems: &mut Vec<Problem>) {
    for (index, motor) in description.motors.iter().enumerate() {
        let element = Element::Motor(index);
        let coordinate = scalar(description, model, &motor.coordinate, element, "hinge", &motor.name, problems);
        let Some(coordinate) = coordinate else { continue };
        let mut add = |field: &str, message: String, help: &str| {
            problems.push(Problem { element, field: field.to_owned(), message, help: Some(help.to_owned()) });
        };
        if let Some(drive) = model.drives.iter().find(|drive| drive.coordinate == coordinate) {
            let label = model.label(coordinate.velocity);
            let message = format!("`{}` pushes on {label}, whose motion `{}` prescribes", motor.name, drive.name);
            add("hinge", message, "take off the motor or the drive: a drive takes whatever force it needs");
        }
        let given = (model.start_position[coordinate.position], model.start_velocity[coordinate.velocity]);
        let bias = controller::bias(description, &motor.name);
        match compile(&motor.law, given, bias) {
            Ok(law) => {
                let limit = motor.limit.unwrap_or(f64::INFINITY);
                model.motors.push(Motor { name: motor.name.clone(), coordinate, law, limit });
            }
            Err((field, message)) => {
                add(field, format!("`{}`: {message}", motor.name), "for example `expression = \"-20*q - 2*v\"`");
            }
        }
    }
}

/// The law of a motor whose coordinate has this position (m or rad) and rate (m/s or rad/s) given; `bias` is what its controller
/// starts an input with.
fn compile(
    law: &MotorLawDescription,
    (given, rate): (f64, f64),
    bias: f64,
) -> Result<MotorLaw, (&'static str, String)> {
    Ok(match law {
        MotorLawDescription::Constant { force } => MotorLaw::Constant(*force),
        MotorLawDescription::Input { force } => MotorLaw::Input(force.unwrap_or(bias)),
        MotorLawDescription::Table { over, at, forces } => {
            MotorLaw::Table { over: *over, at: at.clone(), forces: forces.clone() }
        }
        MotorLawDescription::Pd { target, stiffness, damping, force } => {
            let target = match target {
                TargetDescription::Value(value) => Prescribed::compile(&MotionDescription::Hold, *value),
                TargetDescription::Motion(motion) => Prescribed::compile(motion, given),
            };
            let target = target.map_err(|message| ("target", message))?;
            MotorLaw::Pd { target, stiffness: *stiffness, damping: *damping, force: *force }
        }
        MotorLawDescription::Expression { text } => {
            let formula = Formula::parse(text, &VARIABLES).map_err(|error| ("expression", error.in_words(text)))?;
            if !formula.value(&[0.0, given, rate]).is_finite() {
                let message = format!("at t = 0, q = {given} and v = {rate} as given its force is not a finite number");
                return Err(("expression", message));
            }
            MotorLaw::Formula(Box::new(formula))
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motor(law: &MotorLawDescription, limit: f64) -> Motor {
        let coordinate = Scalar { link: 1, position: 0, velocity: 0, slides: false };
        Motor { name: "motor".to_owned(), coordinate, law: compile(law, (0.3, 0.0), 0.0).unwrap(), limit }
    }

    fn laws() -> Vec<MotorLawDescription> {
        let target = TargetDescription::Motion(MotionDescription::Rate { rate: 0.4 });
        let at = vec![-1.0, 0.5, 2.0];
        vec![
            MotorLawDescription::Constant { force: 3.0 },
            MotorLawDescription::Table { over: Over::Speed, at: at.clone(), forces: vec![1.0, -2.0, 0.0] },
            MotorLawDescription::Table { over: Over::Time, at, forces: vec![1.0, -2.0, 0.0] },
            MotorLawDescription::Pd { target, stiffness: 7.0, damping: 2.0, force: 0.5 },
            MotorLawDescription::Expression { text: "3*sin(2*t) - 5*q^2*v".to_owned() },
            MotorLawDescription::Expression { text: "-2*v*abs(v)".to_owned() },
        ]
    }

    /// The derivatives of the force and of the potential are what differences say; beyond the limit nothing varies.
    #[test]
    fn derivatives_are_derivatives() {
        let h = 1e-6;
        for law in laws() {
            for limit in [f64::INFINITY, 1.5] {
                let motor = motor(&law, limit);
                for (t, q, v) in [(0.2, 0.6, 0.1), (1.1, -0.9, 0.7), (0.7, 0.25, -0.3)] {
                    let push = motor.at(t, q, v);
                    assert!(push.force.abs() <= limit);
                    let by_q = (motor.at(t, q + h, v).force - motor.at(t, q - h, v).force) / (2.0 * h);
                    let by_v = (motor.at(t, q, v + h).force - motor.at(t, q, v - h).force) / (2.0 * h);
                    assert!((push.by_position - by_q).abs() < 1e-8 && (push.by_velocity - by_v).abs() < 1e-8);
                    if motor.has_potential() {
                        let slope = (motor.potential(q + h) - motor.potential(q - h)) / (2.0 * h);
                        assert!((slope + motor.at(0.0, q, 0.0).force).abs() < 1e-8, "{law:?} {limit}");
                    }
                }
            }
        }
    }
}
