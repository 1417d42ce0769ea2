//! What the columns of a table are: the time, numbers that were set, and what was measured.

use super::scenes::accepts;
use super::table::{DataColumn, MeasuredTable};
use super::{FitQuestion, Trouble};
use crate::model::description::{OutputDescription, QuantityDescription};
use crate::model::{Model, Parameter};
use crate::quantity::Dimension;
use crate::scenario::{Override, Scenario};
use crate::suggest::closest;

/// The heading of the time of a run.
const TIME: &str = "time";
/// Headings of natural frequencies, as in `statics --sensitivity` and as in the tables of `sweep`.
const FREQUENCIES: [&str; 2] = ["frequency[", "frequencies_hz["];

/// Something measured.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Measure {
    /// An output of the scene, by its label.
    Output(String),
    /// A natural frequency, by its place among them.
    Frequency(usize),
}

/// A measured column of the table.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MeasuredColumn {
    /// Its place in the table.
    pub column: usize,
    pub of: Measure,
    /// Its unit; `1` for a number without.
    pub unit: String,
    /// What numbers of the table, in SI units, are divided by: what 1 of its unit is.
    pub size: f64,
}

/// What the columns are.
#[derive(Debug, Default)]
pub(super) struct Roles {
    /// Of a run: the place of the times.
    pub time: Option<usize>,
    /// Places of the columns that set the numbers of their names.
    pub settings: Vec<usize>,
    pub measured: Vec<MeasuredColumn>,
    /// Coordinates that are measured and are no outputs of the scene.
    pub more: Vec<OutputDescription>,
}

impl Roles {
    /// The roles of the columns of a table.
    ///
    /// # Errors
    /// A column that is nothing that is known, an empty cell of a number that was set, nothing measured.
    pub(super) fn of(
        table: &MeasuredTable,
        (scenario, set): (&Scenario, &[Override]),
        model: &Model,
        question: &FitQuestion,
    ) -> Result<Self, Trouble> {
        for name in &question.ignored {
            if !table.columns.iter().any(|column| column.name == *name) {
                let near = near(name, table.columns.iter().map(|column| column.name.as_str()));
                return Err(Trouble::Data(format!("the data has no column `{name}` to ignore{near}")));
            }
        }
        let mut roles = Self::default();
        for (place, column) in table.columns.iter().enumerate() {
            if question.ignored.contains(&column.name) {
                continue;
            }
            if let Some(measured) = roles.measured(place, column, model, question)? {
                roles.measured.push(measured);
            } else if roles.time != Some(place) {
                roles.setting(place, column, (scenario, set), model, question)?;
            }
        }
        if question.run && roles.time.is_none() {
            let why = "a fit to runs needs a column `time` (s)";
            return Err(Trouble::Data(why.to_owned()));
        }
        if roles.measured.is_empty() {
            let known = known_measures(model);
            let has = match known.is_empty() {
                true => "the scene has no `[[output]]`".to_owned(),
                false => format!("the scene has `{}`", known.join("`, `")),
            };
            return Err(Trouble::Data(format!("no column is something measured: {has}")));
        }
        Ok(roles)
    }

    /// The time or something measured, if the column is that.
    fn measured(
        &mut self,
        place: usize,
        column: &DataColumn,
        model: &Model,
        question: &FitQuestion,
    ) -> Result<Option<MeasuredColumn>, Trouble> {
        let name = column.name.as_str();
        if name == TIME && question.run {
            check_unit(column, "s")?;
            if column.values.iter().any(|time| !(*time >= 0.0)) {
                return Err(Trouble::Data("the column `time` has a cell that is no time ≥ 0 s".to_owned()));
            }
            self.time = Some(place);
            return Ok(None);
        }
        let labels = model.outputs.iter().flat_map(|output| output.labels().zip(&output.units));
        let output = labels.into_iter().find(|(label, _)| label == name).map(|(_, unit)| unit.clone());
        let found = match output {
            Some(unit) => Some((Measure::Output(name.to_owned()), unit)),
            None => frequency(name)
                .filter(|_| !question.run)
                .map(|index| (Measure::Frequency(index), "Hz".to_owned()))
                .or_else(|| self.coordinate(name, model)),
        };
        let Some((of, unit)) = found else { return Ok(None) };
        check_unit(column, &unit)?;
        // Without a unit in its heading a column counts as what is measured does.
        let size = if column.dimension.is_some() { Dimension::size_of(&unit) } else { 1.0 };
        Ok(Some(MeasuredColumn { column: place, of, unit, size }))
    }

    /// A hinge coordinate or rate by its own name, as recordings and tables call it: it becomes an output.
    fn coordinate(&mut self, name: &str, model: &Model) -> Option<(Measure, String)> {
        for body in &model.bodies {
            let Some(key) = name.strip_prefix(&body.name).and_then(|rest| rest.strip_prefix('.')) else { continue };
            let of =
                |list: &[(&str, &str)]| list.iter().find(|(own, _)| *own == key).map(|(_, unit)| (*unit).to_owned());
            let position = of(body.hinge.kind.positions());
            let is_position = position.is_some();
            let Some(unit) = position.or_else(|| of(body.hinge.kind.velocities())) else { continue };
            let address = name.to_owned();
            let quantity = match is_position {
                true => QuantityDescription::Coordinate { of: address },
                false => QuantityDescription::Rate { of: address },
            };
            self.more.push(OutputDescription::new(name, quantity));
            return Some((Measure::Output(name.to_owned()), unit));
        }
        None
    }

    /// A column of a number that was set.
    fn setting(
        &mut self,
        place: usize,
        column: &DataColumn,
        (scenario, set): (&Scenario, &[Override]),
        model: &Model,
        question: &FitQuestion,
    ) -> Result<(), Trouble> {
        let name = column.name.as_str();
        if let Some(row) = column.values.iter().position(|x| x.is_nan()) {
            let message =
                format!("`{name}` has no number in row {}: what was set has to be known in every row", row + 1);
            // A column that is nothing at all is told as that.
            if accepts(scenario, set, name, 1.0).is_ok() {
                return Err(Trouble::Data(message));
            }
        }
        let number = Parameter::find(&scenario.description, name);
        if let Ok(found) = &number
            && let Some(unit) = found.first().map(|one| one.quantity.unit()).filter(|unit| !unit.is_empty())
        {
            check_unit(column, unit)?;
        }
        if let Err(problems) = accepts(scenario, set, name, column.values[0]) {
            if number.is_ok() {
                return Err(Trouble::Problems(problems));
            }
            let mut known = known_measures(model);
            known.extend(Parameter::all(&scenario.description).into_iter().map(|one| one.address));
            known.extend(question.run.then(|| TIME.to_owned()));
            if name == TIME && !question.run {
                let message = "the column `time` is the time of a run, and the fit is to equilibria; with `run` (`--run`) it is to a \
                               run, `--ignore time` leaves it out";
                return Err(Trouble::Data(message.to_owned()));
            }
            let near = near(name, known.iter().map(String::as_str));
            return Err(Trouble::Data(format!(
                "the column `{name}` is neither an output nor a number of the scene{near}; `--ignore` leaves it out"
            )));
        }
        self.settings.push(place);
        Ok(())
    }
}

/// All that can be measured by name.
fn known_measures(model: &Model) -> Vec<String> {
    let labels = model.outputs.iter().flat_map(|output| output.labels());
    let coordinates = model
        .bodies
        .iter()
        .flat_map(|body| body.hinge.kind.positions().iter().map(move |(name, _)| format!("{}.{name}", body.name)));
    labels.chain(coordinates).collect()
}

fn near<'a>(name: &str, known: impl Iterator<Item = &'a str>) -> String {
    closest(name, known).map_or_else(String::new, |near| format!("; did you mean `{near}`?"))
}

/// The place of a natural frequency.
fn frequency(name: &str) -> Option<usize> {
    FREQUENCIES.iter().find_map(|before| name.strip_prefix(before)?.strip_suffix(']')?.parse().ok())
}

fn check_unit(column: &DataColumn, unit: &str) -> Result<(), Trouble> {
    let Some(measured) = column.dimension else { return Ok(()) };
    match Dimension::of(unit) {
        Ok(own) if own != measured => {
            let message =
                format!("the unit in the heading of `{}` does not fit: it is measured in {unit}", column.name);
            Err(Trouble::Data(message))
        }
        _ => Ok(()),
    }
}
