//! What a user asks of a scene, as numbers: one kind a file, each answers the questions of `Measure`.
//!
//! [`crate::model::output`] has outputs as they are described and compiled. [`Outputs`] evaluates those of a model at one
//! place, from a force balance there and from what the caller knows besides it ([`Given`]).
//!
//! Expressions follow from other outputs: they are evaluated last, in the order of their depth. Variations are by the
//! chain rule through [`crate::motion::variation`]:
//!
//! ```text
//! (1)  y = y(t, links(q, q̇, q̈), q, q̇),   δy = ∂y/∂links δlinks + ∂y/∂q δq + ∂y/∂q̇ δq̇ + ∂y/∂t δt
//! (2)  dy/dt: δq = q̇, δq̇ = q̈, δt = 1
//! ```

mod angle;
mod coordinate;
mod distance;
mod energy;
mod expression;
mod force;
mod orientation;
mod place;
mod point;
mod question;
mod reaction;
mod section;

pub use place::{AtStops, Looked};
pub use question::{Given, Varied};

use crate::constraint::LoopReaction;
use crate::dynamics::{Balanced, Fault};
use crate::model::output::{ForceQuantity, Source};
use crate::model::{Model, Quantity};
use crate::motion::variation::{Direction, LinkVariation, outward};
use question::{At, Measure, Variation};

/// Evaluates the outputs of a model.
#[derive(Debug, Clone)]
pub struct Outputs {
    /// Indices of the outputs, each after those that it follows from.
    order: Vec<usize>,
    /// Whether what loops pass is asked for.
    loops: bool,
    /// The time (s), then the numbers of all outputs: the variables of expressions.
    values: Vec<f64>,
    /// The variations of these; not a number where one is not known.
    variations: Vec<f64>,
    links: Vec<LinkVariation>,
    /// The numbers of one output.
    scratch: Vec<f64>,
}

impl Outputs {
    /// Room for the outputs of a model; `None` for a model without.
    pub fn new(model: &Model) -> Option<Self> {
        let outputs = &model.outputs;
        let count = outputs.last()?.range().end;
        let depth = |index: &usize| match &outputs[*index].quantity {
            Quantity::Expression(expression) => expression.depth,
            _ => 0,
        };
        let mut order: Vec<usize> = (0..outputs.len()).collect();
        order.sort_by_key(depth);
        let is_loop = |quantity: &Quantity| {
            matches!(quantity, Quantity::Force(ForceQuantity { source: Source::Loop(_) | Source::Rod(_), .. }))
        };
        Some(Self {
            order,
            loops: outputs.iter().any(|output| is_loop(&output.quantity)),
            values: vec![0.0; count + 1],
            variations: vec![0.0; count + 1],
            links: vec![LinkVariation::default(); model.links.len()],
            scratch: vec![0.0; outputs.iter().map(|output| output.units.len()).max().unwrap_or(0)],
        })
    }

    /// Whether a model asks for powers.
    pub fn asks_power(model: &Model) -> bool {
        model.outputs.iter().any(|output| matches!(output.quantity, Quantity::Power(_)))
    }

    /// The numbers of all outputs at a place, in the order of the model. Multipliers must have been shared
    /// ([`Evaluated::share_multipliers`](crate::dynamics::Evaluated::share_multipliers)) before the balance.
    ///
    /// # Errors
    /// The output that is not a finite number.
    pub fn evaluate(&mut self, balanced: &Balanced<'_>, given: &Given<'_>) -> Result<&[f64], Fault> {
        self.numbers(balanced, given);
        self.check(balanced.system().model())?;
        Ok(&self.values[1..])
    }

    /// As [`Outputs::evaluate`], some of them perhaps not finite.
    pub fn numbers(&mut self, balanced: &Balanced<'_>, given: &Given<'_>) -> &[f64] {
        let model = balanced.system().model();
        let loops = self.loops(balanced);
        self.values[0] = balanced.time();
        for index in &self.order {
            let output = &model.outputs[*index];
            let own = &mut self.scratch[..output.units.len()];
            measure(&output.quantity).value(&At { balanced, given, loops: &loops, values: &self.values }, own);
            self.values[output.first + 1..][..own.len()].copy_from_slice(own);
        }
        &self.values[1..]
    }

    /// Refuses the last [`Outputs::numbers`] if they are not finite.
    ///
    /// # Errors
    /// The output that is not.
    pub fn check(&self, model: &Model) -> Result<(), Fault> {
        let mut outputs = self.order.iter().map(|index| &model.outputs[*index]);
        match outputs.find(|output| self.values[1..][output.range()].iter().any(|x| !x.is_finite())) {
            Some(output) => Err(Fault::NotFinite { what: "the output", element: output.name.clone() }),
            None => Ok(()),
        }
    }

    /// The variations (1) of all outputs in one direction, after [`Outputs::evaluate`] at the same place; what [`Varied::others`] has for
    /// one whose variation is not known, or not a number: of what loops, drives, gears, stops and hinges pass on, of energies and powers, and of
    /// an angle without sign between parallel directions.
    pub fn vary(&mut self, balanced: &Balanced<'_>, given: &Given<'_>, by: &Varied<'_>) -> &[f64] {
        let model = balanced.system().model();
        let loops = self.loops(balanced);
        let direction = Direction { position: by.position, velocity: by.velocity, acceleration: by.acceleration };
        let (motion, accelerations) = (balanced.motion(), balanced.link_accelerations());
        outward(model, motion, accelerations, given.accelerations, &direction, 1..model.links.len(), &mut self.links);
        self.variations[0] = by.time;
        let at = At { balanced, given, loops: &loops, values: &self.values };
        for index in &self.order {
            let output = &model.outputs[*index];
            let own = &mut self.scratch[..output.units.len()];
            let variation = Variation { links: &self.links, by, values: &self.variations };
            if !measure(&output.quantity).vary(&at, &variation, own) {
                match by.others.get(output.range()) {
                    Some(others) => own.copy_from_slice(others),
                    None => own.fill(f64::NAN),
                }
            }
            self.variations[output.first + 1..][..own.len()].copy_from_slice(own);
        }
        &self.variations[1..]
    }

    /// What loops pass, if that is asked for.
    fn loops(&self, balanced: &Balanced<'_>) -> Vec<LoopReaction> {
        if self.loops { balanced.loop_reactions() } else { Vec::new() }
    }
}

fn measure(quantity: &Quantity) -> &dyn Measure {
    match quantity {
        Quantity::Point(point) => point,
        Quantity::Distance(distance) => distance,
        Quantity::Angle(angle) => angle,
        Quantity::Orientation(orientation) => orientation,
        Quantity::Coordinate(coordinate) => coordinate,
        Quantity::Rate(rate) => rate,
        Quantity::Force(force) => force,
        Quantity::Length(length) => length,
        Quantity::Reaction(reaction) => reaction,
        Quantity::Section(section) => section,
        Quantity::Energy(energy) => energy,
        Quantity::Power(power) => power,
        Quantity::Expression(expression) => expression,
    }
}
