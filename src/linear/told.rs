//! The rows of the outputs, and which of them have none.

use super::beside::{Along, Beside, is_shared};
use super::{Basis, Input, LinearError, Mat, Place, Signal, StateMatrices};
use crate::dynamics::{Fault, Linearization, System};
use crate::model::output::{EnergyKind, ExpressionQuantity, ForceQuantity, Source, follows_from};
use crate::model::{Model, Output, Quantity};
use crate::output::{AtStops, Outputs, Varied};
use std::sync::Arc;

/// The rows of the outputs.
pub(super) struct Told {
    pub(super) c: Mat<f64>,
    pub(super) d: Mat<f64>,
    pub(super) outputs: Vec<Signal>,
    pub(super) left_out: Vec<LeftOut>,
}

/// An output without a row.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// Its name.
    pub name: String,
    /// Why it has none.
    pub why: Why,
}

/// Why an output has no row.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Why {
    /// Energies of ledgers.
    #[error("it is added up from the start of a run, and follows from no state")]
    Summed,
    /// Forces of contacts.
    #[error("contact is none of the equations")]
    Contact,
    /// What an input pushes with.
    #[error("it is, or may follow from, the force of the input `{0}` itself")]
    Input(String),
    /// What linearly dependent rows push with.
    #[error("more rows share it than move anything, and how they do is not known")]
    Shared,
    /// Kinks, and what differences do not find.
    #[error("it has a kink at this place, or its derivative is not found to six digits")]
    Rough,
}

impl Why {
    /// Of an output that is known not to vary as the others do; `known` has what each number of the outputs is known to do.
    fn of(model: &Model, output: &Output, known: &[bool], are_shared: bool) -> Self {
        let unknown = |output: &Output| {
            !matches!(output.quantity, Quantity::Expression(_)) && !output.range().all(|number| known[number])
        };
        match follows_from(&model.outputs, output, unknown).map(|output| &output.quantity) {
            Some(Quantity::Energy(EnergyKind::Input | EnergyKind::Dissipated)) => Self::Summed,
            Some(Quantity::Force(ForceQuantity { source: Source::Contact(_), .. })) => Self::Contact,
            Some(quantity) if are_shared && is_shared(model, quantity) => Self::Shared,
            _ => Self::Rough,
        }
    }
}

/// What there is to say of outputs that are left out, each reason once.
pub(super) fn notes(left_out: &[LeftOut]) -> Vec<String> {
    let first = |one: &&LeftOut| left_out.iter().find(|other| other.why == one.why) == Some(one);
    let note = |one: &LeftOut| {
        let names: Vec<&str> =
            left_out.iter().filter(|other| other.why == one.why).map(|other| other.name.as_str()).collect();
        format!("left out: `{}`: {}", names.join("`, `"), one.why)
    };
    left_out.iter().filter(first).map(note).collect()
}

/// The variations of all numbers of the outputs along each direction; `others` has those that the caller knows.
fn vary(
    system: &mut System,
    outputs: &mut Outputs,
    (place, a): (&Place, &[f64]),
    directions: &[[Vec<f64>; 3]],
    (stops, others): (&AtStops, &[Vec<f64>]),
) -> Result<Vec<Vec<f64>>, Fault> {
    let each = directions.iter().enumerate().map(|(j, [position, velocity, acceleration])| {
        let others = others.get(j).map_or(&[][..], |others| &others[..]);
        Varied { time: 0.0, position, velocity, acceleration, others }
    });
    let along: Vec<Varied<'_>> = each.collect();
    Ok(outputs.look(system.at(place.time, &place.position, &place.velocity), a, stops, &along)?.variations)
}

/// The variations of all numbers of the outputs by each state, then by each input.
fn variations(
    system: &mut System,
    outputs: &mut Outputs,
    (place, a): (&Place, &[f64]),
    (basis, linear, rows): (&Basis, &Linearization, &Mat<f64>),
    (motion, multipliers): (&StateMatrices, &[f64]),
    inputs: &[Input],
) -> Result<Vec<Vec<f64>>, LinearError> {
    let (states, count) = (motion.a.ncols(), basis.columns.ncols());
    let spread = |column: &dyn Fn(usize) -> f64| -> Vec<f64> {
        (0..a.len()).map(|i| (0..count).map(|k| basis.columns[(i, k)] * column(k)).sum()).collect()
    };
    let directions: Vec<[Vec<f64>; 3]> = (0..states + inputs.len())
        .map(|j| {
            let unit = |k: usize| f64::from(u8::from(k == j));
            let acceleration = (0..a.len()).map(|i| motion.answers[(i, j)]).collect();
            [spread(&|k| unit(k)), spread(&|k| unit(count + k)), acceleration]
        })
        .collect();
    let all = vary(system, outputs, (place, a), &directions, (&AtStops::default(), &[]))?;
    let values = |system: &mut System, outputs: &mut Outputs, stops: &AtStops| {
        outputs.look(system.at(place.time, &place.position, &place.velocity), a, stops, &[]).map(|told| told.values)
    };
    let Some(beside) = Beside::new(system, outputs, (place, a), (basis, linear, rows), multipliers, &all)? else {
        let here = values(system, outputs, &AtStops::default())?;
        return Ok(without_kinks(system.model(), place.time, &here, all));
    };
    let mut others = Vec::with_capacity(directions.len());
    for (j, [position, velocity, acceleration]) in directions.iter().enumerate() {
        let input = j.checked_sub(states).map(|input| &inputs[input]);
        let along = Along { position, velocity, acceleration, input };
        others.push(beside.vary(system, outputs, &along, all[j].len())?);
    }
    system.set_multipliers(multipliers);
    let stops = beside.stopped_here(system.model());
    let all = vary(system, outputs, (place, a), &directions, (&stops, &others))?;
    let here = values(system, outputs, &stops)?;
    Ok(without_kinks(system.model(), place.time, &here, all))
}

/// The variations without those of formulas that have a kink in them at these values, and of what follows from these.
fn without_kinks(model: &Model, time: f64, values: &[f64], mut all: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let variables: Vec<f64> = [time].into_iter().chain(values.iter().copied()).collect();
    let mut expressions: Vec<(usize, &ExpressionQuantity)> = model.outputs.iter().filter_map(of_formula).collect();
    expressions.sort_by_key(|(_, expression)| expression.depth);
    for column in &mut all {
        for (number, expression) in &expressions {
            let by: Vec<f64> = [0.0].into_iter().chain(column.iter().copied()).collect();
            let follows = (1..by.len()).any(|i| by[i].is_nan() && expression.formula.uses(i));
            if follows || expression.formula.has_kink(&variables, &by) {
                column[*number] = f64::NAN;
            }
        }
    }
    all
}

fn of_formula(output: &Output) -> Option<(usize, &ExpressionQuantity)> {
    match &output.quantity {
        Quantity::Expression(expression) => Some((output.first, expression)),
        _ => None,
    }
}

pub(super) fn tell(
    system: &mut System,
    (place, a): (&Place, &[f64]),
    (basis, linear, rows): (&Basis, &Linearization, &Mat<f64>),
    (motion, multipliers): (&StateMatrices, &[f64]),
    inputs: &[Input],
    asked: Option<&[String]>,
) -> Result<Told, LinearError> {
    let model = &Arc::clone(system.model());
    let states = motion.a.ncols();
    let empty =
        Told { c: Mat::zeros(0, states), d: Mat::zeros(0, inputs.len()), outputs: Vec::new(), left_out: Vec::new() };
    let Some(mut outputs) = Outputs::new(model) else { return Ok(empty) };
    let about = (basis, linear, rows);
    let all = variations(system, &mut outputs, (place, a), about, (motion, multipliers), inputs)?;
    let count = model.outputs.last().map_or(0, |last| last.range().end);
    let known: Vec<bool> = (0..count).map(|row| all.iter().all(|column| column[row].is_finite())).collect();
    let are_shared = basis.dependent.len() < rows.nrows() + place.held.len();
    let mut told = Vec::new();
    let mut left_out = Vec::new();
    let named = |name: &String| model.outputs.iter().find(|output| output.name == *name);
    let chosen: Vec<&Output> =
        asked.map_or_else(|| model.outputs.iter().collect(), |names| names.iter().filter_map(named).collect());
    for output in chosen {
        let why = match inputs.iter().find(|input| input.is_told_by(model, output)) {
            Some(input) => Why::Input(input.name().to_owned()),
            None if output.range().all(|row| known[row]) => {
                told.extend(output.range().zip(output.labels()).zip(output.units.clone()));
                continue;
            }
            None => Why::of(model, output, &known, are_shared),
        };
        left_out.push(LeftOut { name: output.name.clone(), why });
    }
    if let Some(refused) = left_out.first().filter(|_| asked.is_some()) {
        return Err(LinearError::Output(refused.clone()));
    }
    let entry = |row: usize, column: usize| all[column][told[row].0.0];
    Ok(Told {
        c: Mat::from_fn(told.len(), states, entry),
        d: Mat::from_fn(told.len(), inputs.len(), |i, j| entry(i, states + j)),
        outputs: told.iter().map(|((_, name), unit)| Signal { name: name.clone(), unit: unit.clone() }).collect(),
        left_out,
    })
}
