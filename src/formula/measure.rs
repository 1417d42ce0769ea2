//! What a formula measures, from what its variables measure: one pass over its steps.

use super::function::{Binary, Unary};
use super::{Formula, FormulaError, Operation};
use crate::quantity::measure::{ANGLE, Measure};
use std::ops::Range;

/// An intermediate result and the part of the text that it comes from.
#[derive(Debug, Clone)]
struct Term {
    value: f64,
    measure: Measure,
    place: Range<usize>,
}

impl Formula {
    /// What it measures, given values and measures of its variables in the order in which they were named. The values are
    /// needed for exponents.
    ///
    /// # Errors
    /// If numbers of different units are added or compared, or a function or an exponent has a unit: which part of the text.
    ///
    /// # Panics
    /// If a variable that it uses is not given.
    pub fn measure(&self, variables: &[(f64, Measure)]) -> Result<Measure, FormulaError> {
        let blank = Term { value: 0.0, measure: Measure::Plain, place: 0..0 };
        let mut registers = vec![blank; self.registers];
        for (step, place) in self.steps.iter().zip(&self.places) {
            let leaf = |(value, measure): (f64, Measure)| Term { value, measure, place: place.clone() };
            registers[step.to] = match step.operation {
                Operation::Constant(value) => leaf((value, Measure::Plain)),
                Operation::Variable(index) => leaf(variables[index]),
                Operation::Copy(from) => registers[from].clone(),
                Operation::Unary(function, of) => unary(function, &registers[of])?,
                Operation::Binary(function, a, b) => binary(function, &registers[a], &registers[b])?,
                Operation::Select(condition, yes, no) => {
                    let measure = together(&registers[yes], &registers[no])?;
                    let taken = if registers[condition].value == 0.0 { no } else { yes };
                    Term { measure, ..registers[taken].clone() }
                }
            };
        }
        Ok(registers[0].measure)
    }
}

fn unary(function: Unary, of: &Term) -> Result<Term, FormulaError> {
    let measure = match function {
        Unary::Minus | Unary::Abs => of.measure,
        Unary::Not | Unary::Sign => Measure::Plain,
        Unary::Sqrt => Measure::Plain.times(of.measure, 0.5),
        Unary::Cbrt => Measure::Plain.times(of.measure, 1.0 / 3.0),
        Unary::Asin | Unary::Acos | Unary::Atan => pure(of, "an argument of a function").map(|()| ANGLE)?,
        _ => pure(of, "an argument of a function").map(|()| Measure::Plain)?,
    };
    Ok(Term { value: function.value(of.value), measure, place: of.place.clone() })
}

fn binary(function: Binary, a: &Term, b: &Term) -> Result<Term, FormulaError> {
    let measure = match function {
        Binary::Multiply => a.measure.times(b.measure, 1.0),
        Binary::Divide => a.measure.times(b.measure, -1.0),
        Binary::Power => {
            pure(b, "an exponent")?;
            Measure::Plain.times(a.measure, b.value)
        }
        Binary::Atan2 => together(a, b).map(|_| ANGLE)?,
        Binary::Add | Binary::Subtract | Binary::Remainder => together(a, b)?,
        Binary::Min | Binary::Max | Binary::Hypot | Binary::And | Binary::Or => together(a, b)?,
        Binary::FloorDivide
        | Binary::Less
        | Binary::LessOrEqual
        | Binary::Greater
        | Binary::GreaterOrEqual
        | Binary::Equal
        | Binary::NotEqual => together(a, b).map(|_| Measure::Plain)?,
    };
    Ok(Term { value: function.value(a.value, b.value), measure, place: around(a, b) })
}

fn around(a: &Term, b: &Term) -> Range<usize> {
    a.place.start.min(b.place.start)..a.place.end.max(b.place.end)
}

/// What two numbers measure that are added or compared.
fn together(a: &Term, b: &Term) -> Result<Measure, FormulaError> {
    a.measure.together(b.measure).ok_or_else(|| {
        let message = format!("one number is measured in {}, the other in {}", a.measure, b.measure);
        FormulaError::new(around(a, b), message).help("what is added or compared has the same unit")
    })
}

fn pure(term: &Term, what: &str) -> Result<(), FormulaError> {
    if term.measure.is_pure() {
        return Ok(());
    }
    let message = format!("{what} has no unit, and this is measured in {}", term.measure);
    Err(FormulaError::new(term.place.clone(), message).help("divide it by what it is compared with"))
}
