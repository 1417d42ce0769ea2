//! Formulas in named variables: `0.1*sin(2*pi*t)`, `-k*q if q > 0 else 0`.
//!
//! ```text
//! text ─ token ─► tokens with places ─ parse ─► steps on registers ─ eval ─► value, derivatives
//! ```
//!
//! A formula means what it means in Python: `-t^2` is −(t²), `2^3^2` is 2⁹, comparisons chain (`0 < t < 1`), `and` and
//! `or` give one of their operands. `^` is the same as `**`, and `if(c, a, b)` the same as `a if c else b`.
//!
//! Derivatives are exact and cost as much as the value: every step of the program computes with truncated Taylor series
//! (or with gradients) in place of numbers,
//!
//! ```text
//! (1)  f(g)'  = f'(g) g'
//! (2)  f(g)'' = f''(g) g'² + f'(g) g''
//! ```
//!
//! At a kink (`abs`, `min`, `max`, `if`, `floor`, …) they are those of the branch that is taken. Kinks at a time are known before
//! a run, and so is what a formula of time does for a short time only ([`Formula::instants`]): steps end there. A run keeps a formula
//! of places and speeds in one smooth piece within a step ([`Pieces`]), and ends the step where it comes to another.
//!
//! Arithmetic is that of IEEE 754: what has no value is not a number, what is too large is infinite. Whoever evaluates a
//! formula has to check its result.
//!
//! What a formula measures follows from what its variables measure ([`Formula::measure`]).
//!
//! ```
//! use stillpoint::formula::{Formula, Jet};
//! let path = Formula::parse("0.5*t^2 + sin(w*t)", &["t", "w"])?;
//! let at = path.jet(&[Jet::variable(2.0), Jet::constant(0.0)]);
//! assert_eq!((at.value, at.first, at.second), (2.0, 2.0, 1.0));
//! let (value, by_w) = path.gradient(&[2.0, 0.0], [1]);
//! assert_eq!((value, by_w), (2.0, [2.0]));
//! # Ok::<(), stillpoint::formula::FormulaError>(())
//! ```

mod detail;
mod error;
mod function;
mod instants;
mod measure;
mod number;
mod parse;
mod pieces;
mod range;
mod series;
mod token;
mod vocabulary;

pub use error::FormulaError;
pub use number::Jet;
pub use pieces::{CellEnd, Pieces};
pub use vocabulary::vocabulary;

use crate::round_off::FORMULA_BEND;
use function::{Binary, Unary};
use number::{Extended, Gradient, Number};
use series::Series;
use std::ops::Range;

/// The longest text (in bytes).
pub const LONGEST_TEXT: usize = 16_384;
/// The deepest nesting of brackets, functions, signs and powers.
pub const DEEPEST_NESTING: usize = 64;
/// The most operations, each of which is computed at every evaluation.
pub const MOST_OPERATIONS: usize = 4096;
/// The most intermediate values that are needed at one time.
pub const MOST_REGISTERS: usize = 256;

/// A formula, compiled for evaluation: one pass over its steps, without recursion and without allocation.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    text: String,
    steps: Vec<Step>,
    /// The last part of the text that was read before each step: of numbers and variables where they are written.
    places: Vec<Range<usize>>,
    /// How many registers the steps use; the result is in the first.
    registers: usize,
    /// Of each variable, whether it occurs.
    used: Vec<bool>,
}

/// One operation on registers: `to ← operation`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Step {
    to: usize,
    operation: Operation,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Operation {
    Constant(f64),
    /// Index into the variables.
    Variable(usize),
    Copy(usize),
    Unary(Unary, usize),
    Binary(Binary, usize, usize),
    /// The second if the first is not zero, else the third.
    Select(usize, usize, usize),
}

impl Formula {
    /// Compiles a text; `variables` are the names that it may use, and hide constants of the same name. A name that is
    /// no identifier is written in braces: `{left arm.angle}`.
    ///
    /// # Errors
    /// What is wrong with the text and where: syntax, unknown names, wrong numbers of arguments, limits.
    pub fn parse(text: &str, variables: &[&str]) -> Result<Self, FormulaError> {
        parse::formula(text, variables)
    }

    /// As it is written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether the variable of this index occurs in it.
    pub fn uses(&self, variable: usize) -> bool {
        self.used.get(variable).copied().unwrap_or(false)
    }

    /// Its value, not a number where that is infinite; `variables` in the order in which they were named.
    ///
    /// # Panics
    /// If a variable that it uses is not given.
    pub fn value(&self, variables: &[f64]) -> f64 {
        finite(self.run(|index| variables[index]))
    }

    /// Its value; where it has none because something in it is infinite, that: a message can say so.
    ///
    /// # Panics
    /// If a variable that it uses is not given.
    pub fn value_or_infinity(&self, variables: &[f64]) -> f64 {
        let value = self.value(variables);
        if value.is_nan() { self.run(|index| Extended(variables[index])).0 } else { value }
    }

    /// Its truncated Taylor series along a parameter, given those of the variables.
    ///
    /// # Panics
    /// If a variable that it uses is not given.
    pub fn jet(&self, variables: &[Jet]) -> Jet {
        let jet = self.run(|index| variables[index]);
        Jet { value: finite(jet.value), ..jet }
    }

    /// Its value and its first four derivatives with respect to its variable, if it has one alone; of several, along all at once.
    pub fn derivatives(&self, at: f64) -> [f64; 5] {
        let Series([value, first, second, third, fourth]) = self.run(|_| Series([at, 1.0, 0.0, 0.0, 0.0]));
        [finite(value), first, 2.0 * second, 6.0 * third, 24.0 * fourth]
    }

    /// How it varies with its variables, given how these vary; variables that it does not use are not looked at.
    ///
    /// # Panics
    /// If a variable that it uses is not given.
    pub fn variation(&self, variables: &[f64], by: &[f64]) -> f64 {
        self.run(|index| Jet { value: variables[index], first: by[index], second: 0.0 }).first
    }

    /// Whether it has a kink, or a jump, where its variables are: along `by` the second difference over the distance does not fall with it.
    ///
    /// # Panics
    /// If a variable that it uses is not given.
    pub fn has_kink(&self, variables: &[f64], by: &[f64]) -> bool {
        let moves = |i: &usize| by[*i] != 0.0 && by[*i].is_finite() && self.uses(*i);
        let reach = |i: usize| (1.0 + variables[i].abs()) / by[i].abs();
        let far = KINK_REACH * (0..by.len()).filter(moves).map(reach).fold(f64::INFINITY, f64::min);
        if !far.is_finite() {
            return false;
        }
        let at = |h: f64| {
            let moved = |i: usize| if moves(&i) { variables[i] + h * by[i] } else { variables[i] };
            self.value(&(0..variables.len()).map(moved).collect::<Vec<_>>())
        };
        let here = at(0.0);
        let bend = |h: f64| {
            let [after, before] = [at(h), at(-h)];
            let round_off = FORMULA_BEND.of(after.abs() + 2.0 * here.abs() + before.abs());
            ((after - 2.0 * here + before).abs() - round_off) / h
        };
        let [wide, narrow] = [bend(far), bend(0.25 * far)];
        wide > 0.0 && narrow > 0.5 * wide
    }

    /// Its value, and its derivatives with respect to the variables of these indices.
    ///
    /// # Panics
    /// If a variable that it uses is not given.
    pub fn gradient<const N: usize>(&self, variables: &[f64], by: [usize; N]) -> (f64, [f64; N]) {
        let found: Gradient<N> = self.run(|index| Gradient {
            value: variables[index],
            slopes: by.map(|variable| if variable == index { 1.0 } else { 0.0 }),
        });
        (finite(found.value), found.slopes)
    }

    /// One pass over the steps, on as many registers as most formulas need, or as many as any may need.
    fn run<T: Number>(&self, variable: impl Fn(usize) -> T) -> T {
        self.run_with(variable, |_, _, _| None)
    }

    /// As [`Formula::run`]; what `instead` gives for a step, by its index, its operation and the registers before it, is its result.
    fn run_with<T: Number>(
        &self,
        variable: impl Fn(usize) -> T,
        instead: impl FnMut(usize, &Operation, &[T]) -> Option<T>,
    ) -> T {
        match self.registers {
            0..=8 => self.run_on(&mut [T::constant(0.0); 8], variable, instead),
            9..=32 => self.run_on(&mut [T::constant(0.0); 32], variable, instead),
            _ => self.run_on(&mut [T::constant(0.0); MOST_REGISTERS], variable, instead),
        }
    }

    fn run_on<T: Number>(
        &self,
        registers: &mut [T],
        variable: impl Fn(usize) -> T,
        mut instead: impl FnMut(usize, &Operation, &[T]) -> Option<T>,
    ) -> T {
        for (at, step) in self.steps.iter().enumerate() {
            if let Some(given) = instead(at, &step.operation, registers) {
                registers[step.to] = given;
                continue;
            }
            registers[step.to] = match step.operation {
                Operation::Constant(value) => T::constant(value),
                Operation::Variable(index) => variable(index),
                Operation::Copy(from) => registers[from],
                Operation::Unary(function, of) => registers[of].unary(function),
                Operation::Binary(function, a, b) => T::binary(function, registers[a], registers[b]),
                Operation::Select(condition, yes, no) => match registers[condition].value() {
                    undefined if undefined.is_nan() => T::constant(f64::NAN),
                    0.0 => registers[no],
                    _ => registers[yes],
                },
            };
        }
        registers[0]
    }
}

/// What is not a finite number is not a number at all.
fn finite(x: f64) -> f64 {
    if x.is_finite() { x } else { f64::NAN }
}

/// All names in a text, each where it stands (in bytes), up to what is no formula.
pub fn names(text: &str) -> Vec<(String, std::ops::Range<usize>)> {
    let (mut found, mut tokens) = (Vec::new(), token::Tokens::new(text));
    while let Ok((token, span)) = tokens.next() {
        match token {
            token::Token::Name(name) | token::Token::Braced(name) => found.push((name.to_owned(), span)),
            token::Token::End => break,
            _ => {}
        }
    }
    found
}

/// Kinks are looked for within this part of a variable, or of 1.
const KINK_REACH: f64 = 1e-6;

/// The text with numbers in place of names; what is no formula stays as it is.
pub fn with_numbers(text: &str, number: impl Fn(&str) -> Option<f64>) -> String {
    let (mut out, mut done, mut tokens) = (String::new(), 0, token::Tokens::new(text));
    while let Ok((token, span)) = tokens.next() {
        let value = match token {
            token::Token::Name(name) | token::Token::Braced(name) => number(name),
            token::Token::End => break,
            _ => None,
        };
        if let Some(value) = value {
            out += &text[done..span.start];
            out += &format!("({value:?})");
            done = span.end;
        }
    }
    out + &text[done..]
}
