//! Controllers: at the instants of a period they read outputs of the scene and set motors of type `input`, which hold their value
//! until the next instant.
//!
//! ```text
//! (1)  instants tₖ = k T,  k = 0, 1, …:   uₖ = law(yₖ),  uₖ acts on tₖ ≤ t < tₖ₊₁        (sample and hold)
//! (2)  gain:  u = bias − K (y − y*)
//! (3)  pid:   e = y* − y,  Iₖ = Iₖ₋₁ + T eₖ,  dₖ = (eₖ − eₖ₋₁) / T  (0 at the first instant),  u = bias + P e + I Iₖ + D dₖ
//! (4)         beyond its `limit` u is cut; Iₖ = Iₖ₋₁ then if `integral` eₖ would drive it further beyond (conditional integration)
//! ```
//!
//! `yₖ` are outputs just before the instant, with the inputs that act until then; all controllers of one instant read the same.
//! Statics sees the value that an input starts with: its own `force`, or the `bias` of its controller.

use super::Model;
use super::description::Description;
use super::motor::Motor;
use super::output::Output;
use super::problem::{Element, Problem, counted};
use crate::formula::Formula;
use crate::suggest::closest;
use std::collections::HashMap;

/// A controller, by names.
#[derive(Debug, Clone, PartialEq)]
pub struct ControllerDescription {
    /// Unique name.
    pub name: String,
    /// Time between its instants (s), > 0.
    pub period: f64,
    /// Names of the outputs that it reads; one of several numbers gives all of them.
    pub senses: Vec<String>,
    /// Names of the motors of type `input` that it sets.
    pub drives: Vec<String>,
    /// What it makes of the one for the other.
    pub law: ControlLawDescription,
    /// What it remembers of an earlier run that goes on; empty for none.
    pub memory: Vec<f64>,
}

/// How a controller gets from what it senses to what it drives.
#[derive(Debug, Clone, PartialEq)]
pub enum ControlLawDescription {
    /// (2) of the module.
    Gain {
        /// `K`: a row for each input, a column for each number that is sensed.
        matrix: Vec<Vec<f64>>,
        /// `y*`; empty for zeros.
        setpoint: Vec<f64>,
        /// Empty for zeros (N or N m).
        bias: Vec<f64>,
    },
    /// (3) and (4) of the module: one number is sensed and one input driven.
    Pid {
        /// `P`
        proportional: f64,
        /// `I` (1/s)
        integral: f64,
        /// `D` (s)
        derivative: f64,
        /// `y*`
        setpoint: f64,
        /// Bias (N or N m).
        bias: f64,
        /// `u` is not beyond it, either way (N or N m).
        limit: Option<f64>,
    },
    /// A formula for each input, in the names of what is sensed and the time `t` (s).
    Expression {
        /// As written.
        texts: Vec<String>,
    },
}

impl ControlLawDescription {
    /// What the input at this place starts with.
    pub(super) fn bias(&self, index: usize) -> f64 {
        match self {
            Self::Gain { bias, .. } => bias.get(index).copied().unwrap_or(0.0),
            Self::Pid { bias, .. } => *bias,
            Self::Expression { .. } => 0.0,
        }
    }
}

/// A controller, compiled.
#[derive(Debug, Clone)]
pub struct Controller {
    /// Name.
    pub name: String,
    /// Period (s).
    pub period: f64,
    /// The numbers that it reads, by their places among all outputs.
    pub senses: Vec<usize>,
    /// The inputs that it sets, by their places in [`Model::inputs`].
    pub drives: Vec<usize>,
    law: ControlLaw,
    /// What it remembers at the start.
    memory: Vec<f64>,
}

#[derive(Debug, Clone)]
enum ControlLaw {
    Gain { matrix: Vec<f64>, setpoint: Vec<f64>, bias: Vec<f64> },
    Pid { gains: [f64; 3], setpoint: f64, bias: f64, limit: f64 },
    Expression(Vec<Formula>),
}

/// What a PID controller remembers: the integral, the last error, and whether there was one.
const PID_MEMORY: usize = 3;

impl Controller {
    /// What it remembers when a run starts.
    pub fn memory(&self) -> &[f64] {
        &self.memory
    }

    /// The law at an instant (s): the numbers that it reads in, the values of what it drives out. An expression whose value is not
    /// finite gives that.
    pub fn act(&self, time: f64, sensed: &[f64], memory: &mut [f64], out: &mut Vec<f64>) {
        out.clear();
        match &self.law {
            ControlLaw::Gain { matrix, setpoint, bias } => {
                let off = || sensed.iter().zip(setpoint).map(|(y, wanted)| y - wanted);
                let row = |(row, bias): (&[f64], &f64)| bias - row.iter().zip(off()).map(|(k, y)| k * y).sum::<f64>();
                out.extend(matrix.chunks(sensed.len()).zip(bias).map(row));
            }
            ControlLaw::Pid { gains: [p, i, d], setpoint, bias, limit } => {
                let [integral, last, acted] = memory else { return };
                let error = setpoint - sensed[0];
                let rate = if *acted == 0.0 { 0.0 } else { (error - *last) / self.period };
                let next = *integral + self.period * error;
                let wanted = bias + p * error + i * next + d * rate;
                // (4)
                if !(wanted.abs() > *limit && i * error * wanted > 0.0) {
                    *integral = next;
                }
                (*last, *acted) = (error, 1.0);
                let push = bias + p * error + i * *integral + d * rate;
                out.push(if push.abs() > *limit { limit.copysign(push) } else { push });
            }
            ControlLaw::Expression(formulas) => {
                let variables: Vec<f64> = sensed.iter().copied().chain([time]).collect();
                out.extend(formulas.iter().map(|formula| formula.value_or_infinity(&variables)));
            }
        }
    }
}

impl Model {
    /// The model of a run that goes on: what its inputs are (N or N m) and what its controllers remember, each in the order of the
    /// model.
    pub fn continued(&self, inputs: &[f64], memories: &[Vec<f64>]) -> Self {
        let mut model = self.clone();
        for (motor, force) in self.inputs.iter().zip(inputs) {
            model.motors[*motor].give(*force);
        }
        for (controller, memory) in model.controllers.iter_mut().zip(memories) {
            controller.memory.clone_from(memory);
        }
        model
    }
}

/// The value that an input starts with: the bias of its controller; zero without one.
pub(super) fn bias(description: &Description, motor: &str) -> f64 {
    let of = |controller: &ControllerDescription| {
        let index = controller.drives.iter().position(|name| name == motor)?;
        Some(controller.law.bias(index))
    };
    description.controllers.iter().find_map(of).unwrap_or(0.0)
}

/// Compiles the controllers of a scene whose motors and outputs are complete into its model.
pub(super) fn compile(description: &Description, model: &mut Model) -> Vec<Problem> {
    let mut compiler = Compiler { description, model, problems: Vec::new(), driven: HashMap::new() };
    let all = description.controllers.iter().enumerate();
    let compiled: Vec<Controller> = all.filter_map(|(index, one)| compiler.one(index, one)).collect();
    let problems = compiler.problems;
    model.controllers = compiled;
    problems
}

struct Compiler<'a> {
    description: &'a Description,
    model: &'a Model,
    problems: Vec<Problem>,
    /// Controllers by the inputs that they drive.
    driven: HashMap<usize, &'a str>,
}

impl<'a> Compiler<'a> {
    fn wrong(&mut self, index: usize, field: &str, message: String, help: impl Into<String>) {
        let element = Element::Controller(index);
        self.problems.push(Problem { element, field: field.to_owned(), message, help: Some(help.into()) });
    }

    fn one(&mut self, index: usize, one: &'a ControllerDescription) -> Option<Controller> {
        let (before, name) = (self.problems.len(), &one.name);
        if self.description.controllers[..index].iter().any(|other| other.name == *name) {
            self.wrong(index, "name", format!("two controllers are called `{name}`"), "names must be unique");
        }
        if !(one.period > 0.0 && one.period.is_finite()) {
            let message = format!("`period` of `{name}` is {}", one.period);
            self.wrong(index, "period", message, "allowed: a finite number > 0 s");
        }
        let (mut senses, mut labels) = (Vec::new(), Vec::new());
        for sensed in &one.senses {
            let outputs = &self.model.outputs;
            let whole = outputs.iter().find(|output| output.name == *sensed);
            let numbers = |output: &Output| output.range().zip(output.labels()).collect::<Vec<_>>();
            let found = match whole {
                Some(output) => numbers(output),
                None => outputs.iter().flat_map(numbers).filter(|(_, label)| label == sensed).collect(),
            };
            if found.is_empty() {
                let near = closest(sensed, outputs.iter().map(|output| output.name.as_str()));
                let help = near.map_or_else(
                    || "it reads `[[output]]`s by their names".to_owned(),
                    |near| format!("did you mean `{near}`?"),
                );
                self.wrong(
                    index,
                    "senses",
                    format!("`{name}` senses `{sensed}`, which is no output of the scene"),
                    help,
                );
            }
            found.into_iter().for_each(|(place, label)| {
                senses.push(place);
                labels.push(label);
            });
        }
        let drives: Vec<usize> = one.drives.iter().filter_map(|driven| self.input(index, one, driven)).collect();
        let known = drives.len() == one.drives.len() && self.problems.len() == before;
        let law = self.law(index, one, &labels, known)?;
        let count = if matches!(law, ControlLaw::Pid { .. }) { PID_MEMORY } else { 0 };
        let memory = if one.memory.is_empty() { vec![0.0; count] } else { one.memory.clone() };
        if memory.len() != count || memory.iter().any(|x| !x.is_finite()) {
            let message = format!("`{name}` remembers {count} finite numbers, not {:?}", one.memory);
            self.wrong(index, "memory", message, "take those that `run --save-end` has written");
        }
        let (name, period) = (name.clone(), one.period);
        (self.problems.len() == before).then_some(Controller { name, period, senses, drives, law, memory })
    }

    /// The place of an input among those of the model.
    fn input(&mut self, index: usize, one: &'a ControllerDescription, driven: &str) -> Option<usize> {
        let name = &one.name;
        let place = self.model.inputs.iter().position(|motor| self.model.motors[*motor].name == driven);
        let Some(place) = place else {
            let is_motor = self.model.motors.iter().any(|motor| motor.name == driven);
            let inputs = self.model.inputs.iter().map(|motor| self.model.motors[*motor].name.as_str());
            let help = match closest(driven, inputs) {
                Some(near) => format!("did you mean `{near}`?"),
                None => "it sets `[[motor]]`s of type `input` by their names".to_owned(),
            };
            let what = if is_motor { "a motor with a law of its own" } else { "no motor of the scene" };
            self.wrong(index, "drives", format!("`{name}` drives `{driven}`, which is {what}"), help);
            return None;
        };
        if let Some(other) = self.driven.insert(place, name) {
            let message = format!("`{name}` drives `{driven}`, which `{other}` drives");
            self.wrong(index, "drives", message, "an input has one controller");
        }
        Some(place)
    }

    fn law(&mut self, index: usize, one: &ControllerDescription, labels: &[String], known: bool) -> Option<ControlLaw> {
        let (name, sensed, driven) = (&one.name, labels.len(), one.drives.len());
        let mut finite = |field: &str, numbers: &[f64]| {
            if let Some(bad) = numbers.iter().find(|x| !x.is_finite()) {
                self.wrong(index, field, format!("`{field}` of `{name}` holds {bad}"), "allowed: finite numbers");
            }
        };
        match &one.law {
            ControlLawDescription::Gain { matrix, setpoint, bias } => {
                matrix.iter().for_each(|row| finite("matrix", row));
                finite("setpoint", setpoint);
                finite("bias", bias);
                let fits = matrix.len() == driven && matrix.iter().all(|row| row.len() == sensed);
                if known && !fits {
                    let columns: Vec<usize> = matrix.iter().map(Vec::len).collect();
                    let message = format!(
                        "`matrix` of `{name}` has rows of {columns:?} numbers: {driven} of {sensed} are wanted"
                    );
                    let help = format!("a row for each input it drives, a column for each of {}", labels.join(", "));
                    self.wrong(index, "matrix", message, help);
                }
                for (field, list, count) in [("setpoint", setpoint, sensed), ("bias", bias, driven)] {
                    if known && !list.is_empty() && list.len() != count {
                        let message = format!(
                            "`{field}` of `{name}` has {}: {}",
                            counted(list.len(), "number", "numbers"),
                            counted(count, "is wanted", "are wanted")
                        );
                        self.wrong(index, field, message, "or none, for zeros");
                    }
                }
                let or_zeros =
                    |list: &[f64], count: usize| if list.is_empty() { vec![0.0; count] } else { list.to_vec() };
                let (setpoint, bias) = (or_zeros(setpoint, sensed), or_zeros(bias, driven));
                fits.then(|| ControlLaw::Gain { matrix: matrix.concat(), setpoint, bias })
            }
            ControlLawDescription::Pid { proportional, integral, derivative, setpoint, bias, limit } => {
                finite("proportional", &[*proportional]);
                finite("integral", &[*integral]);
                finite("derivative", &[*derivative]);
                finite("setpoint", &[*setpoint]);
                finite("bias", &[*bias]);
                if known && (sensed, driven) != (1, 1) {
                    let field = if sensed == 1 { "drives" } else { "senses" };
                    let message = format!(
                        "`{name}` senses {} and drives {}",
                        counted(sensed, "number", "numbers"),
                        counted(driven, "input", "inputs")
                    );
                    self.wrong(
                        index,
                        field,
                        message,
                        "a PID controller has one of each; several numbers want several controllers",
                    );
                }
                let limit = limit.unwrap_or(f64::INFINITY);
                if !(limit > 0.0) {
                    self.wrong(index, "limit", format!("`limit` of `{name}` is {limit}"), "allowed: a number > 0");
                }
                let gains = [*proportional, *integral, *derivative];
                Some(ControlLaw::Pid { gains, setpoint: *setpoint, bias: *bias, limit })
            }
            ControlLawDescription::Expression { texts } => {
                if known && texts.len() != driven {
                    let message = format!(
                        "`{name}` has {} for {}",
                        counted(texts.len(), "formula", "formulas"),
                        counted(driven, "input", "inputs")
                    );
                    self.wrong(index, "expression", message, "one for each input that it drives");
                }
                let texts = if known { &texts[..] } else { &[] };
                Some(ControlLaw::Expression(self.formulas(index, name, texts, labels)))
            }
        }
    }

    /// The formulas that can be read.
    fn formulas(&mut self, index: usize, name: &str, texts: &[String], labels: &[String]) -> Vec<Formula> {
        let variables: Vec<&str> = labels.iter().map(String::as_str).chain(["t"]).collect();
        let mut formulas = Vec::new();
        for text in texts {
            match Formula::parse(text, &variables) {
                Ok(formula) => formulas.push(formula),
                Err(error) => {
                    let message = format!("`{name}`: {}", error.in_words(text));
                    let help = format!("it may use {}", variables.join(", "));
                    self.wrong(index, "expression", message, help);
                }
            }
        }
        formulas
    }
}

/// The motors of type `input`, in their order.
pub(super) fn inputs(motors: &[Motor]) -> Vec<usize> {
    (0..motors.len()).filter(|index| motors[*index].given().is_some()).collect()
}
