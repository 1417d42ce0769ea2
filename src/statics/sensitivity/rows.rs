//! What is differentiated: numbers of outputs, and frequencies by the shapes of their modes.

use super::{KNOWN, Response, SensitivityError};
use crate::model::Model;
use crate::round_off::FORCE;
use crate::statics::certify::equilibrium::Equilibrium;
use crate::statics::certify::modes::NaturalMode;
use crate::statics::certify::stability::Stability;
use crate::suggest::closest;

/// One row, and where it comes from.
pub(super) enum Row {
    /// The place of an output's number.
    Output(usize),
    /// The shape of a mode, in velocity coordinates.
    Frequency(Vec<f64>),
    /// A frequency without derivatives, and what is in the way.
    Without(String),
}

impl Row {
    /// How large its numbers are beside which its value `x` may be round-off: that of an output with several is the largest of those that
    /// have its unit.
    pub(super) fn size(&self, model: &Model, all: &[f64], x: f64) -> f64 {
        let Self::Output(place) = self else { return x.abs() };
        let own = model.outputs.iter().filter(|output| output.range().contains(place));
        let numbers = own.flat_map(|output| {
            let unit = &output.units[*place - output.first];
            output
                .range()
                .zip(&output.units)
                .filter(move |(_, other)| *other == unit)
                .map(|(other, _)| all[other].abs())
        });
        numbers.fold(0.0, f64::max)
    }

    /// Its shape.
    pub(super) fn shape(&self) -> Option<&[f64]> {
        match self {
            Self::Output(_) | Self::Without(_) => None,
            Self::Frequency(shape) => Some(shape),
        }
    }
}

/// The rows of a name.
pub(super) fn of_name(
    model: &Model,
    found: &Equilibrium,
    name: &str,
    outputs: &mut Vec<Response>,
    rows: &mut Vec<Row>,
) -> Result<(), SensitivityError> {
    for output in &model.outputs {
        let of = output.range().zip(output.labels()).zip(&output.units);
        for ((place, label), unit) in of.filter(|((_, label), _)| label == name || output.name == name) {
            outputs.push(Response { name: label, unit: unit.clone(), value: 0.0 });
            rows.push(Row::Output(place));
        }
    }
    if outputs.iter().any(|one| one.name == name || one.name.starts_with(&format!("{name}["))) {
        return Ok(());
    }
    let Some(index) = name.strip_prefix("frequency[").and_then(|rest| rest.strip_suffix(']')?.parse::<usize>().ok())
    else {
        let known = model.outputs.iter().map(|output| output.name.as_str()).chain(["frequency[0]"]);
        // As tables of `sweep` call it.
        let of_table = name.strip_prefix("frequencies_hz").map(|place| format!("frequency{place}"));
        let near = of_table.or_else(|| closest(name, known).map(str::to_owned));
        let hint = near.map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
        return Err(SensitivityError::Output { name: name.to_owned(), hint });
    };
    let modes: Vec<_> = found.stability.iter().flat_map(Stability::swinging).collect();
    let Some(mode) = modes.get(index) else {
        let why = match modes.len() {
            0 => "the equilibrium has no frequencies".to_owned(),
            1 => "the equilibrium has one frequency, `frequency[0]`".to_owned(),
            count => format!("the frequencies of the equilibrium are 0 to {}", count - 1),
        };
        return Err(SensitivityError::Frequency { name: name.to_owned(), why });
    };
    outputs.push(Response { name: name.to_owned(), unit: "Hz".to_owned(), value: mode.frequency_hz });
    rows.push(match without(model, found, index, &modes) {
        Some(why) => Row::Without(why),
        None => Row::Frequency(shape(model, mode)),
    });
    Ok(())
}

/// Why a frequency has no derivatives, if it has none.
fn without(model: &Model, found: &Equilibrium, index: usize, modes: &[&NaturalMode]) -> Option<String> {
    let frequency = modes[index].frequency_hz;
    if frequency == 0.0 {
        return Some("the motion has zero stiffness, and a frequency there no derivative".to_owned());
    }
    if !model.is_conservative_at_rest() || found.velocity.iter().any(|v| *v != 0.0) {
        return Some(
            "frequencies have derivatives here only if all loads have a potential and nothing spins".to_owned(),
        );
    }
    // Shapes of modes are mixed by the round-off of the stiffness over the distance of their squares.
    let square = |mode: &NaturalMode| mode.frequency_hz.powi(2);
    let largest = modes.iter().map(|mode| square(mode)).fold(0.0, f64::max);
    let apart = |other: &usize| (square(modes[*other]) - square(modes[index])).abs();
    let nearest = (0..modes.len()).filter(|other| *other != index).min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
    if KNOWN * apart(&nearest) > FORCE.of(largest) {
        return None;
    }
    let other = modes[nearest].frequency_hz;
    Some(match other == frequency {
        true => {
            format!("the frequency is repeated, so it has no derivative: it equals `frequency[{nearest}]`, {other} Hz")
        }
        false => format!(
            "its {frequency} Hz are so near to `frequency[{nearest}]`, {other} Hz, that rounding mixes the two shapes: no derivative is known"
        ),
    })
}

/// Shape of a mode, in velocity coordinates.
fn shape(model: &Model, mode: &NaturalMode) -> Vec<f64> {
    let mut shape = vec![0.0; model.velocity_count()];
    let free = (0..shape.len()).filter(|i| !model.coordinates[*i].lock).collect::<Vec<_>>();
    free.into_iter().zip(&mode.shape).for_each(|(i, x)| shape[i] = *x);
    shape
}
