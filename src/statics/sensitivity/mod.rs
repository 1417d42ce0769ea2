//! Sensitivities: how an equilibrium, what is asked of it and its frequencies change with the numbers of the scene.
//!
//! ```text
//! (1)  f(q, p) = 0  stays while p changes:      K s = ∂f/∂p,    dq/dp = s + c,    K = −∂f/∂q
//! (2)  y = y(q, p):                              dy/dp = d/dh y(q ⊞ h dq/dp, p + h)  at h = 0
//! (3)  ω² = φᵀKφ / φᵀMφ  of a mode φ:            dω²/dp by (2) with φ as it is, brought onto the rows: ω² is stationary in φ
//! ```
//!
//! `c` is what loops move that change with `p` themselves, at fixed independent coordinates. `K` is factorized once, by the sweep of
//! the transfer equations where that covers the scene; nothing but the equilibrium is solved for. Derivatives by a number
//! are extrapolated differences at given positions (see [`crate::extrapolate`]), so that every kind of number and of output counts:
//! multipliers, reactions and what stops bear follow from the place. Along the curve of (2) forces stay balanced to first order, and
//! that is checked: it proves (1). Where there are more numbers than motions they are taken from the other end (see `adjoint`).

mod adjoint;
mod rows;
mod stops;

use super::certify::bearing::{self, Set};
use super::certify::equilibrium::Equilibrium;
use super::family::Moving;
use super::inverse::unit;
use super::problem::assembled::Assembled;
use super::search::curve::Family;
use super::standing;
use crate::extrapolate::{Derivative, derivative};
use crate::model::description::Description;
use crate::model::parameter::{Field, Quantity};
use crate::model::problem::Element;
use crate::model::{Model, Parameter};
use adjoint::Adjoint;
use rows::{Row, of_name};
use std::f64::consts::TAU;
use std::sync::Arc;
pub use stops::idle_stops;
use stops::one_sided;

/// The largest distance of a difference, as a part of a number's unit.
const FIRST: f64 = 1e-2;
/// The farthest that any coordinate moves in a difference: radians, or part of the scene's length.
const FARTHEST: f64 = 0.05;
/// A size of derivatives below which they count as small: this part of the output's unit over the number's.
const SMALL: f64 = 1e-3;
/// A derivative below this part of the output's unit over the number's is round-off: zero.
const ZERO: f64 = 1e-11;
/// A derivative whose error is larger than this part of it, or of [`SMALL`], is not known.
const KNOWN: f64 = 1e-6;
/// A slope is corrected, so many times at most and as long as that halves its error, until what it leaves unbalanced moves the coordinates by
/// less than the first part of it; with more than the other part it is not known.
const CLOSE: f64 = 1e-10;
const EXACT: f64 = 1e-5;
const HALVES: f64 = 0.5;
const MOST_ROUNDS: usize = 3;
/// Forces that change along (2) by more than this part of ∂f/∂p disprove (1).
const PROVED: f64 = 1e-6;
/// A frequency of a shape is that of the mode if they differ by less than this part.
const SAME: f64 = 1e-6;

/// Why there is no derivative where differences do not settle.
const ROUGH: &str = "the forces do not change smoothly with it";
/// Why there is none at a switch.
const KINK: &str = "the forces have a kink here: a spring, rope or motor is at a switch";

/// Derivatives of outputs by numbers of the scene.
#[derive(Debug, Clone)]
pub struct Sensitivities {
    /// The rows.
    pub outputs: Vec<Response>,
    /// The columns.
    pub parameters: Vec<Influence>,
    /// Row by row: the derivative, in SI units of the output by the number; `None` if there is none, as a note says.
    pub derivatives: Vec<Vec<Option<f64>>>,
    /// What a person should know.
    pub notes: Vec<String>,
}

/// A row: one number of an output, or a frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Response {
    /// `camber`, `tip[2]` or `frequency[0]`.
    pub name: String,
    /// SI unit; `1` for a number without.
    pub unit: String,
    /// At the equilibrium.
    pub value: f64,
}

/// A column: a number of the scene that may change.
#[derive(Debug, Clone, PartialEq)]
pub struct Influence {
    /// The address that stands for it alone.
    pub address: String,
    /// SI unit; empty if that is not said.
    pub unit: &'static str,
    /// In the scene.
    pub value: f64,
}

/// Why there are no sensitivities.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum SensitivityError {
    /// Nothing to differentiate.
    #[error("there is no equilibrium: nothing of it can change")]
    NoEquilibrium,
    /// Contact or dry friction hold a pose within bounds.
    #[error(
        "the scene has contact or dry friction, which hold a pose as it is until they give way: it has no derivatives"
    )]
    Friction,
    /// The pose is given.
    #[error(
        "the pose is given and numbers are unknown: sensitivities are those of an equilibrium that is found from all numbers"
    )]
    Unknown,
    /// A name that is not known.
    #[error("the scenario has no output `{name}`{hint}")]
    Output {
        /// As it was asked for.
        name: String,
        /// What may have been meant.
        hint: String,
    },
    /// A frequency that there is not.
    #[error("`{name}`: {why}")]
    Frequency {
        /// As it was asked for.
        name: String,
        /// What is in the way.
        why: String,
    },
    /// The caller ended it.
    #[error("interrupted")]
    Interrupted,
    /// The equilibrium cannot be evaluated again.
    #[error("{0}")]
    Failed(String),
}

/// The derivatives of `asked` (names of outputs, `frequency[0]` …) at an equilibrium by `parameters`, as long as what bears bears
/// and what is switched on stays so. `parameters` of `None` are all that an equilibrium follows from ([`influences`]). `go_on` is asked
/// before each of them.
///
/// # Errors
/// See [`SensitivityError`].
pub fn sensitivities(
    description: &Description,
    model: &Arc<Model>,
    found: &Equilibrium,
    asked: &[String],
    parameters: Option<Vec<Parameter>>,
    go_on: &dyn Fn() -> bool,
) -> Result<Sensitivities, SensitivityError> {
    if !found.balanced {
        return Err(SensitivityError::NoEquilibrium);
    }
    if standing::is_for(model) {
        return Err(SensitivityError::Friction);
    }
    let is_aimed = !found.aimed.is_empty();
    if !found.unknowns.is_empty() && !is_aimed {
        return Err(SensitivityError::Unknown);
    }
    let (mut outputs, mut rows) = (Vec::new(), Vec::new());
    for name in asked {
        of_name(model, found, name, &mut outputs, &mut rows)?;
    }
    let parameters = parameters.unwrap_or_else(|| influences(description));
    let numbers = parameters.iter().map(|one| Influence {
        address: one.address.clone(),
        unit: one.quantity.unit(),
        value: one.value(description),
    });
    let numbers: Vec<Influence> = numbers.collect();
    let set = bearing::borne(model, found);
    let mut study = Study::new(description, model, found, (&rows, &mut outputs), set)?;
    let mut columns: Vec<Vec<Option<f64>>> = Vec::new();
    // Nothing is differentiated if no row has derivatives.
    let differentiates = study.without.iter().any(Option::is_none);
    let adjoint = if differentiates { Adjoint::of(&mut study, parameters.len(), go_on) } else { None };
    for (one, number) in parameters.iter().zip(&numbers) {
        if !go_on() {
            return Err(SensitivityError::Interrupted);
        }
        let column = match differentiates {
            true => adjoint.as_ref().and_then(|adjoint| adjoint.by(&mut study, one, number.value)),
            false => Some(vec![None; rows.len()]),
        };
        columns.push(column.unwrap_or_else(|| study.by(one, number)));
    }
    let Study { mut notes, without, .. } = study;
    let of_row = |(row, why): (usize, &Option<String>)| {
        columns.iter().map(|column| column[row].filter(|_| why.is_none())).collect()
    };
    let derivatives = without.iter().enumerate().map(of_row).collect();
    for (output, why) in outputs.iter().zip(&without) {
        notes.extend(why.iter().map(|why| format!("no derivatives of `{}`: {why}", output.name)));
    }
    if is_aimed {
        notes.push("numbers that were found for the aim stay as they are: nothing is aimed again".to_owned());
    }
    Ok(Sensitivities { outputs, parameters: numbers, derivatives, notes })
}

/// All numbers that an equilibrium follows from: start positions are guesses, except those of hinges that are locked.
pub fn influences(description: &Description) -> Vec<Parameter> {
    let is_guess = |one: &Parameter| match one.element {
        Element::Body(body) => one.field == Field::Position && !description.bodies[body].hinge.lock,
        _ => false,
    };
    Parameter::all(description).into_iter().filter(|one| !is_guess(one)).collect()
}

/// The equilibrium, and what is asked of it.
struct Study<'a> {
    moving: Moving<'a>,
    model: &'a Arc<Model>,
    q: &'a [f64],
    rows: &'a [Row],
    /// The numbers of the rows, followed by the unbalanced forces.
    center: Vec<f64>,
    /// Units of the rows.
    units: Vec<f64>,
    /// How large the forces are that cancel.
    forces: Vec<f64>,
    /// The largest of them; where they are round-off, what the stiffness bears over a radian or the scene's length.
    largest: f64,
    /// Round-off of `center`.
    noise: Vec<f64>,
    /// The free coordinates over one radian or the scene's length.
    levers: Vec<f64>,
    /// Shift of a stiffness that has zero-stiffness directions.
    neutral: bool,
    names: Vec<String>,
    /// Why a row has no derivatives, if that is so.
    without: Vec<Option<String>>,
    notes: Vec<String>,
}

impl<'a> Study<'a> {
    fn new(
        description: &Description,
        model: &'a Arc<Model>,
        found: &'a Equilibrium,
        (rows, outputs): (&'a [Row], &mut [Response]),
        set: Set,
    ) -> Result<Self, SensitivityError> {
        let built = Model::build(description).map_err(|problems| {
            SensitivityError::Failed(problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))
        })?;
        let (_, assembled) = Assembled::of(built).map_err(SensitivityError::Failed)?;
        let q = &found.position[..];
        let moving = Moving::new(description, assembled, &[], 0.0, 1.0, (q, set.clone()));
        let mut moving = moving.map_err(SensitivityError::Failed)?;
        let place = moving.place(q, 0.0).map_err(SensitivityError::Failed)?;
        if !place.is_balanced() {
            return Err(SensitivityError::Failed("the equilibrium is none of the scene as it is described".to_owned()));
        }
        let notes = one_sided(model, found, &set, place.scales.force.iter().fold(0.0_f64, |m, f| m.max(*f)));
        let stability = found.stability.as_ref();
        let slides = (0..model.velocity_count()).filter(|i| !moving.model().coordinates[*i].lock);
        let length = moving.length();
        let levers: Vec<f64> = slides.map(|i| if moving.slides(i) { length } else { 1.0 }).collect();
        let stiff = place.scales.stiffness.iter().zip(&levers).map(|(k, lever)| k * lever);
        let [most, stiffest] =
            [place.scales.force.clone(), stiff.collect()].map(|all| all.into_iter().fold(0.0_f64, f64::max));
        let mut noise = place.scales.noise;
        if model.is_constrained() {
            // Loops are closed to round-off, and what is stiff feels that.
            let stiff = place.scales.stiffness.iter().zip(&levers).map(|(k, lever)| f64::EPSILON * k * lever);
            noise.iter_mut().zip(stiff).for_each(|(noise, stiff)| *noise = noise.max(stiff));
        }
        let mut study = Self {
            moving,
            model,
            q,
            rows,
            center: Vec::new(),
            units: Vec::new(),
            forces: place.scales.force,
            largest: if most > ZERO * stiffest { most } else { stiffest },
            noise,
            levers,
            neutral: stability.is_some_and(|stability| stability.neutral_directions > 0),
            names: outputs.iter().map(|output| output.name.clone()).collect(),
            without: rows
                .iter()
                .map(|row| if let Row::Without(why) = row { Some(why.clone()) } else { None })
                .collect(),
            notes,
        };
        let none = vec![0.0; study.levers.len()];
        study.center = study.along(&none, 0.0, 0.0).map_err(SensitivityError::Failed)?;
        let all = study.moving.record(q, 0.0, &[]).map_err(SensitivityError::Failed)?.outputs;
        let sizes: Vec<f64> = rows.iter().zip(&study.center).map(|(row, x)| row.size(model, &all, *x)).collect();
        for (((output, value), size), (row, without)) in
            outputs.iter_mut().zip(&study.center).zip(&sizes).zip(rows.iter().zip(&mut study.without))
        {
            match row {
                Row::Output(_) => output.value = *value,
                Row::Frequency(_) if (value / output.value - 1.0).abs() < SAME => output.value = *value,
                Row::Frequency(_) => {
                    *without = Some("rows that are linearly dependent do not determine it".to_owned());
                }
                Row::Without(_) => {}
            }
            let quantity = Quantity::of_unit(&output.unit).unwrap_or(Quantity::Plain);
            study.units.push(unit(quantity, *size, model, study.largest).max(*size));
        }
        study.noise = study.units.iter().map(|unit| f64::EPSILON * unit).chain(study.noise).collect();
        if study.neutral {
            study.notes.push("along zero-stiffness directions the equilibrium is taken to stay where it is".to_owned());
        }
        Ok(study)
    }

    /// The rows and the unbalanced forces at `q ⊞ h slope` with the number that moves at `value + h`.
    fn along(&mut self, slope: &[f64], value: f64, h: f64) -> Result<Vec<f64>, String> {
        let step: Vec<f64> = slope.iter().map(|x| h * x).collect();
        let q = self.moving.moved(self.q, &step);
        let shapes: Vec<&[f64]> = self.rows.iter().filter_map(Row::shape).collect();
        let record = self.moving.record(&q, value + h, &shapes)?;
        let mut frequencies = record.curvatures.iter().map(|square| square.sqrt() / TAU);
        let mut all = Vec::with_capacity(self.rows.len() + record.force.len());
        all.extend(self.rows.iter().map(|row| match row {
            Row::Output(place) => record.outputs[*place],
            Row::Frequency(_) => frequencies.next().unwrap_or(f64::NAN),
            Row::Without(_) => 0.0,
        }));
        all.extend(record.force);
        Ok(all)
    }

    /// The fastest coordinate of a motion, in radians or parts of the scene's length.
    fn fastest(&self, slope: &[f64]) -> f64 {
        slope.iter().zip(&self.levers).map(|(x, lever)| x.abs() / lever).fold(0.0, f64::max)
    }

    /// One column.
    fn by(&mut self, one: &'a Parameter, number: &Influence) -> Vec<Option<f64>> {
        let value = number.value;
        let found = self
            .moving
            .vary_by(std::slice::from_ref(one), value)
            .and_then(|()| self.slope(one, value))
            .and_then(|(slope, change)| self.column(one, value, &slope, &change));
        let back = self.moving.vary_by(&[], value);
        match (found, back) {
            (Ok(column), Ok(())) => column,
            (Err(why), _) | (_, Err(why)) => {
                self.notes.push(format!("no derivatives by `{}`: {why}", one.address));
                vec![None; self.rows.len()]
            }
        }
    }

    /// The unit of a number: the scene's own size of such a one, or its own.
    fn unit(&self, one: &Parameter, value: f64) -> f64 {
        unit(one.quantity, value, self.model, self.largest).max(value.abs())
    }

    /// (1): `dq/dp` in the free coordinates, and how forces change at fixed coordinates.
    fn slope(&mut self, one: &Parameter, value: f64) -> Result<(Vec<f64>, Vec<f64>), String> {
        let (unit, count) = (self.unit(one, value), self.levers.len());
        let (q, moving) = (self.q, &mut self.moving);
        let center = moving.felt(q, value)?;
        let sizes: Vec<f64> = self.forces.iter().chain(&self.levers).map(|size| SMALL * size / unit).collect();
        let of_levers = self.levers.iter().map(|lever| f64::EPSILON * lever);
        let noise: Vec<f64> = self.noise[self.rows.len()..].iter().copied().chain(of_levers).collect();
        let Derivative { value: mut change, error, kinks } =
            derivative(&mut |h| moving.felt(q, value + h), &center, FIRST * unit, (&sizes, &noise))?;
        if kinks.contains(&true) {
            return Err(KINK.to_owned());
        }
        // What closing the loops moves, (2) closes again: a part of a radian or of the scene's length is exact enough.
        let part = |i: usize| if i < count { 1.0 } else { 1.0 / SMALL };
        // Otherwise (2) shows how exact it is.
        let is_rough = |i: usize| error[i] > KNOWN * change[i].abs().max(part(i) * sizes[i]);
        if self.neutral && (0..sizes.len()).any(is_rough) {
            return Err(ROUGH.to_owned());
        }
        let moves = change.split_off(count);
        let mut slope = match change.iter().all(|x| *x == 0.0) {
            true => change.clone(),
            false => moving.answer(q, value, &change, self.neutral)?,
        };
        slope.iter_mut().zip(&moves).for_each(|(slope, moves)| *slope += moves);
        Ok((slope, change))
    }

    /// (2) and (3), and the proof of (1).
    fn column(
        &mut self,
        one: &Parameter,
        value: f64,
        slope: &[f64],
        change: &[f64],
    ) -> Result<Vec<Option<f64>>, String> {
        let (unit, count) = (self.unit(one, value), self.rows.len());
        let (mut slope, mut rounds, mut before) = (slope.to_vec(), 0, f64::INFINITY);
        let fastest = self.fastest(&slope);
        let first = (FIRST * unit).min(FARTHEST / fastest.max(f64::MIN_POSITIVE));
        let sizes: Vec<f64> = self.units.iter().chain(&self.forces).map(|size| SMALL * size / unit).collect();
        let center = self.center.clone();
        let noise = self.noise.clone();
        // What forces change along (2) is small: from that (1) is known more exactly than from what they change at fixed coordinates.
        let found = loop {
            let found = derivative(&mut |h| self.along(&slope, value, h), &center, first, (&sizes, &noise))?;
            if found.kinks[count..].contains(&true) {
                return Err(KINK.to_owned());
            }
            if self.neutral {
                break found;
            }
            let left = self.moving.answer(self.q, value, &found.value[count..], false)?;
            let off = self.fastest(&left);
            if off <= CLOSE * fastest || !(off > ZERO / unit) {
                break found;
            }
            if rounds == MOST_ROUNDS || off > HALVES * before {
                if off > EXACT * fastest.max(SMALL / unit) {
                    return Err(ROUGH.to_owned());
                }
                break found;
            }
            before = off;
            slope.iter_mut().zip(&left).for_each(|(slope, left)| *slope += left);
            rounds += 1;
        };
        let most = change.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let unproved = |i: usize| {
            let noise = found.error[i].max(ZERO * self.forces[i - count] / unit);
            found.value[i].abs() > PROVED * most + noise
        };
        if (count..center.len()).any(unproved) {
            return Err(match self.neutral {
                true => "it pushes a zero-stiffness direction: there is no equilibrium beside this one".to_owned(),
                false => "the stiffness is singular here: the equilibrium does not follow it smoothly".to_owned(),
            });
        }
        let mut column = Vec::with_capacity(count);
        for row in 0..count {
            let (x, error) = (found.value[row], found.error[row]);
            // Within its error of zero, and that far below all that counts.
            let zero = x.abs() <= (ZERO * self.units[row] / unit).max(error) && error <= KNOWN * self.units[row] / unit;
            let why = match (found.kinks[row], zero || error <= KNOWN * x.abs().max(sizes[row])) {
                (false, true) => None,
                (true, _) => Some("it has a kink here"),
                (false, false) => Some("differences do not settle"),
            };
            if let Some(why) = why {
                self.notes.push(format!("no derivative of `{}` by `{}`: {why}", self.names[row], one.address));
            }
            column.push(why.is_none().then_some(if zero { 0.0 } else { x }));
        }
        Ok(column)
    }
}
