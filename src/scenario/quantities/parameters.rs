//! `[parameters]`: numbers with names, their values and what they measure.

use super::super::reader::number;
use crate::formula::{self, Formula};
use crate::model::parameter::{self as model, NamedNumber};
use crate::quantity::measure::Measure;
use crate::quantity::{Dimension, Quantity};
use std::ops::Range;
use toml::de::{DeTable, DeValue};

/// The name of their table.
pub(in crate::scenario) const PARAMETERS: &str = "parameters";

/// Names and values of `[parameters]`.
#[derive(Debug, Default)]
pub(in crate::scenario) struct Parameters {
    names: Vec<String>,
    /// Their values, and what they measure.
    pub(super) numbers: Vec<(f64, Measure)>,
}

impl Parameters {
    /// What is wrong in it is said when the table itself is read.
    pub(in crate::scenario) fn read(document: &DeTable<'_>) -> Self {
        Self::read_after(document, &Self::default())
    }

    /// As [`read`](Self::read), after changes: a number without a unit in the place of one that had one, in `given`, is meant in
    /// the SI unit of that.
    pub(super) fn read_after(document: &DeTable<'_>, given: &Self) -> Self {
        let table = document.get(PARAMETERS).and_then(|value| value.get_ref().as_table());
        let entries = table.into_iter().flat_map(|table| table.iter());
        let mut open: Vec<_> = entries.map(|(name, value)| (name.get_ref().to_string(), value.get_ref())).collect();
        let mut found = Self::default();
        // Those that follow from others come when these are known.
        loop {
            let before = open.len();
            open.retain(|(name, value)| match found.evaluate(value) {
                Some((number, measure)) => {
                    let measure = match (*value, given.names.iter().position(|known| known == name)) {
                        (DeValue::Integer(_) | DeValue::Float(_), Some(index)) => given.numbers[index].1,
                        _ => measure,
                    };
                    let number = (number, measure);
                    found.names.push(name.clone());
                    found.numbers.push(number);
                    false
                }
                None => true,
            });
            if open.len() == before {
                return found;
            }
        }
    }

    fn evaluate(&self, value: &DeValue<'_>) -> Option<(f64, Measure)> {
        match value {
            DeValue::String(text) if text.contains('{') => {
                let formula = Formula::parse(text, &self.names()).ok()?;
                let value = Some(formula.value(&self.values())).filter(|value| value.is_finite())?;
                // What does not add up is said at its place, and fits everywhere else.
                Some((value, formula.measure(&self.numbers).unwrap_or(Measure::Plain)))
            }
            DeValue::String(text) => {
                Quantity::parse(text).ok().map(|quantity| (quantity.value, quantity.dimension.into()))
            }
            other => number(other).map(|value| (value, Measure::Plain)),
        }
    }

    pub(super) fn values(&self) -> Vec<f64> {
        self.numbers.iter().map(|(value, _)| *value).collect()
    }

    pub(in crate::scenario) fn names(&self) -> Vec<&str> {
        self.names.iter().map(String::as_str).collect()
    }

    /// As a description has them: by name, whatever follows from what.
    pub(in crate::scenario) fn list(&self) -> Vec<NamedNumber> {
        let of = |(name, (value, measure)): (&String, &(f64, Measure))| NamedNumber {
            name: name.clone(),
            value: *value,
            quantity: if *measure == Measure::Plain { model::Quantity::Plain } else { measured(*measure) },
        };
        let mut list: Vec<NamedNumber> = self.names.iter().zip(&self.numbers).map(of).collect();
        list.sort_by(|a, b| a.name.cmp(&b.name));
        list
    }

    /// The first name in a formula that stands for a variable of its own and for a parameter, with where it stands.
    pub(in crate::scenario) fn ambiguous(&self, text: &str, variables: &[&str]) -> Option<(String, Range<usize>)> {
        let is_both = |name: &&str| variables.contains(name) && self.names.iter().any(|known| known == name);
        formula::names(text).into_iter().find(|(name, _)| is_both(&name.as_str()))
    }

    /// A formula that has passed [`Formula::parse`] with these names, with numbers in their places.
    pub(in crate::scenario) fn put_into(&self, text: &str, variables: &[&str]) -> String {
        formula::with_numbers(text, |name| {
            let known = self.names.iter().position(|known| known == name);
            known.filter(|_| !variables.contains(&name)).map(|index| self.numbers[index].0)
        })
    }
}

/// The quantity that is measured so, if addresses know it.
fn measured(measure: Measure) -> model::Quantity {
    let fits = |quantity: &model::Quantity| Dimension::of(quantity.unit()).is_ok_and(|unit| measure.fits(unit));
    model::Quantity::ALL.into_iter().find(fits).unwrap_or(model::Quantity::Plain)
}
