//! The smooth parts of a formula: within cells of the numbers that its steps switch with.
//!
//! | step | number `x` that it switches with | ends of cells |
//! |---|---|---|
//! | `sign(a)`, `abs(a)` | `a` | 0 |
//! | `a < b`, `min(a, b)`, … | their difference | 0 |
//! | `floor(a)`, `ceil(a)`, `trunc(a)`, `fract(a)` | `a` | whole numbers |
//! | `round(a)` | `a` | halves between them |
//! | `a // b`, `a % b` | `a / b` | whole numbers |
//!
//! A formula whose steps are kept in their cells is smooth wherever its functions are; `x` then tells how far a cell goes. A step
//! that follows from fixed numbers and the time alone is not kept: when it switches is known before ([`Formula::instants`]).

use super::function::{Binary, Unary};
use super::number::{Gradient, Number};
use super::{Formula, Operation, finite};

/// The cells in which the steps of a formula are kept, in the order of the steps; none for a formula as it stands.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Pieces {
    cells: Vec<Cell>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Cell {
    /// Index of the step.
    step: usize,
    rule: Rule,
    /// −1 or 1 below and above zero, and 0 on it for a sign; or the whole number that the step gives.
    index: i64,
}

/// A step that switches.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Rule {
    One(Unary),
    Two(Binary),
}

/// One end of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellEnd {
    /// Index of the cell.
    pub cell: usize,
    /// Whether it is the upper one.
    pub is_upper: bool,
}

impl Rule {
    fn of(operation: Operation) -> Option<Self> {
        match operation {
            Operation::Unary(function, _) => {
                use Unary::{Abs, Ceil, Floor, Fract, Round, Sign, Trunc};
                matches!(function, Abs | Sign | Floor | Ceil | Round | Trunc | Fract).then_some(Self::One(function))
            }
            Operation::Binary(function, ..) => {
                use Binary::{FloorDivide, Greater, GreaterOrEqual, Less, LessOrEqual, Max, Min, Remainder};
                let switches = matches!(
                    function,
                    Min | Max | Less | LessOrEqual | Greater | GreaterOrEqual | FloorDivide | Remainder
                );
                switches.then_some(Self::Two(function))
            }
            _ => None,
        }
    }

    /// `x` of the table, of the arguments of the step; the second is not looked at if it has one alone.
    fn number<T: Number>(self, a: T, b: T) -> T {
        match self {
            Self::One(_) => a,
            Self::Two(Binary::FloorDivide | Binary::Remainder) => T::binary(Binary::Divide, a, b),
            Self::Two(Binary::Less | Binary::LessOrEqual | Binary::Max) => T::binary(Binary::Subtract, b, a),
            Self::Two(_) => T::binary(Binary::Subtract, a, b),
        }
    }

    /// The cell of a number that changes at a rate.
    fn cell(self, x: f64, rate: f64) -> i64 {
        let onwards = |whole: f64, below: bool, above: bool| {
            // On an end it is the cell that it comes to.
            let by = i64::from(above && rate > 0.0) - i64::from(below && rate < 0.0);
            whole as i64 + by
        };
        let side = |of: f64| i64::from(of > 0.0) - i64::from(of < 0.0);
        match self {
            Self::One(Unary::Sign) => {
                if x == 0.0 {
                    side(rate)
                } else {
                    side(x)
                }
            }
            Self::One(Unary::Floor) | Self::Two(Binary::FloorDivide | Binary::Remainder) => {
                onwards(x.floor(), x == x.floor(), false)
            }
            Self::One(Unary::Ceil) => onwards(x.ceil(), false, x == x.ceil()),
            Self::One(Unary::Trunc | Unary::Fract) => {
                let whole = x.trunc();
                onwards(whole, x == whole && whole > 0.0, x == whole && whole < 0.0)
            }
            Self::One(Unary::Round) => {
                let (whole, half) = (x.round_ties_even(), (x - x.floor()) == 0.5);
                onwards(whole, half && whole > x, half && whole < x)
            }
            // On zero as the step has it, if the number stays there.
            Self::Two(Binary::Less | Binary::Greater) if x == 0.0 => {
                if rate > 0.0 {
                    1
                } else {
                    -1
                }
            }
            _ if x == 0.0 => {
                if rate < 0.0 {
                    -1
                } else {
                    1
                }
            }
            _ => side(x),
        }
    }

    /// The ends of a cell.
    fn ends(self, index: i64) -> [Option<f64>; 2] {
        let whole = index as f64;
        match self {
            Self::One(Unary::Floor) | Self::Two(Binary::FloorDivide | Binary::Remainder) => {
                [Some(whole), Some(whole + 1.0)]
            }
            Self::One(Unary::Ceil) => [Some(whole - 1.0), Some(whole)],
            Self::One(Unary::Round) => [Some(whole - 0.5), Some(whole + 0.5)],
            Self::One(Unary::Trunc | Unary::Fract) => {
                [Some(if index > 0 { whole } else { whole - 1.0 }), Some(if index < 0 { whole } else { whole + 1.0 })]
            }
            _ => [(index >= 0).then_some(0.0), (index <= 0).then_some(0.0)],
        }
    }

    /// The cell beyond an end.
    fn beyond(self, index: i64, is_upper: bool) -> i64 {
        let up = if is_upper { 1 } else { -1 };
        match self {
            Self::One(Unary::Floor | Unary::Ceil | Unary::Round | Unary::Trunc | Unary::Fract)
            | Self::Two(Binary::FloorDivide | Binary::Remainder) => index + up,
            _ => up,
        }
    }

    /// What the step gives in a cell.
    fn within<T: Number>(self, index: i64, a: T, b: T) -> T {
        let whole = T::constant(index as f64);
        match self {
            Self::One(Unary::Abs) => {
                if index < 0 {
                    a.unary(Unary::Minus)
                } else {
                    a
                }
            }
            Self::One(Unary::Fract) => T::binary(Binary::Subtract, a, whole),
            Self::One(_) | Self::Two(Binary::FloorDivide) => whole,
            Self::Two(Binary::Remainder) => T::binary(Binary::Subtract, a, T::binary(Binary::Multiply, b, whole)),
            Self::Two(Binary::Min | Binary::Max) => {
                if index > 0 {
                    b
                } else {
                    a
                }
            }
            Self::Two(_) => T::constant(if index > 0 { 1.0 } else { 0.0 }),
        }
    }
}

impl Operation {
    /// Its arguments, the first one twice if it has one alone.
    fn arguments<T: Number>(&self, registers: &[T]) -> [T; 2] {
        match *self {
            Self::Unary(_, of) => [registers[of]; 2],
            Self::Binary(_, a, b) => [registers[a], registers[b]],
            _ => [registers[0]; 2],
        }
    }
}

impl Pieces {
    /// None.
    pub const NONE: Self = Self { cells: Vec::new() };

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }

    /// Follows the formula as it stands from now on.
    pub fn clear(&mut self) {
        self.cells.clear();
    }

    /// The ends of its cells.
    pub fn ends(&self) -> impl Iterator<Item = CellEnd> {
        self.cells.iter().enumerate().flat_map(|(cell, own)| {
            let [lower, upper] = own.rule.ends(own.index).map(|end| end.is_some());
            let ends = [(false, lower), (true, upper)];
            ends.into_iter().filter(|(_, is)| *is).map(move |(is_upper, _)| CellEnd { cell, is_upper })
        })
    }

    /// Goes on in the cell beyond an end.
    pub fn cross(&mut self, end: CellEnd) {
        if let Some(cell) = self.cells.get_mut(end.cell) {
            cell.index = cell.rule.beyond(cell.index, end.is_upper);
        }
    }
}

impl Formula {
    /// The steps that switch with any of these variables, each in some cell: [`Formula::keep`] says in which.
    pub fn pieces(&self, moving: &[usize]) -> Pieces {
        let mut moves = vec![false; self.registers];
        let mut cells = Vec::new();
        for (step, taken) in self.steps.iter().enumerate() {
            let does = match taken.operation {
                Operation::Constant(_) => false,
                Operation::Variable(index) => moving.contains(&index),
                Operation::Copy(of) | Operation::Unary(_, of) => moves[of],
                Operation::Binary(_, a, b) => moves[a] || moves[b],
                Operation::Select(condition, yes, no) => moves[condition] || moves[yes] || moves[no],
            };
            moves[taken.to] = does;
            cells.extend(Rule::of(taken.operation).filter(|_| does).map(|rule| Cell { step, rule, index: 0 }));
        }
        Pieces { cells }
    }

    /// Keeps the steps in the cells that they are in, or come to as the variables change at these rates.
    ///
    /// # Panics
    /// If a variable that it uses is not given.
    pub fn keep(&self, pieces: &mut Pieces, variables: &[f64], rates: &[f64]) {
        let mut cells = pieces.cells.iter_mut().peekable();
        let along = |index: usize| Gradient { value: variables[index], slopes: [rates[index]] };
        self.run_with(along, |at, operation, registers| {
            let cell = cells.next_if(|cell| cell.step == at)?;
            let [a, b] = operation.arguments(registers);
            let x = cell.rule.number(a, b);
            cell.index = cell.rule.cell(x.value, x.slopes[0]);
            Some(cell.rule.within(cell.index, a, b))
        });
    }

    /// As [`Formula::gradient`], with steps kept in their cells.
    ///
    /// # Panics
    /// If a variable that it uses is not given.
    pub fn gradient_within<const N: usize>(
        &self,
        pieces: &Pieces,
        variables: &[f64],
        by: [usize; N],
    ) -> (f64, [f64; N]) {
        let found = self.run_with(gradient_of(variables, by), within(pieces));
        (finite(found.value), found.slopes)
    }

    /// How far a step that is kept in its cell is above an end of that, and the derivatives of it.
    ///
    /// # Panics
    /// If a variable that it uses is not given.
    pub fn above<const N: usize>(
        &self,
        pieces: &Pieces,
        end: CellEnd,
        variables: &[f64],
        by: [usize; N],
    ) -> (f64, [f64; N]) {
        let Some(cell) = pieces.cells.get(end.cell) else { return (f64::NAN, [0.0; N]) };
        let mut kept = within(pieces);
        let mut found = None;
        self.run_with(gradient_of(variables, by), |at, operation, registers| {
            if at == cell.step {
                let [a, b] = operation.arguments(registers);
                found = Some(cell.rule.number(a, b));
            }
            kept(at, operation, registers)
        });
        let [lower, upper] = cell.rule.ends(cell.index);
        let (Some(x), Some(level)) = (found, if end.is_upper { upper } else { lower }) else {
            return (f64::NAN, [0.0; N]);
        };
        (x.value - level, x.slopes)
    }
}

fn gradient_of<const N: usize>(variables: &[f64], by: [usize; N]) -> impl Fn(usize) -> Gradient<N> {
    move |index| Gradient {
        value: variables[index],
        slopes: by.map(|variable| if variable == index { 1.0 } else { 0.0 }),
    }
}

/// What steps give that are kept in their cells.
fn within<T: Number>(pieces: &Pieces) -> impl FnMut(usize, &Operation, &[T]) -> Option<T> {
    let mut cells = pieces.cells.iter().peekable();
    move |at, operation, registers| {
        let cell = cells.next_if(|cell| cell.step == at)?;
        let [a, b] = operation.arguments(registers);
        Some(cell.rule.within(cell.index, a, b))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXTS: [&str; 14] = [
        "-3*sign(q)",
        "abs(q - 0.3*v)*q",
        "floor(5*q)/5 + ceil(3*v)",
        "round(4*q) - trunc(3*q) + fract(2*v)",
        "q // 0.3 + v % 0.7",
        "min(q, v, 0.2) - max(q*q, v)",
        "1 if v > 0 else -0.5",
        "if(q <= v, q^2, v^3)",
        "(q >= 0.1)*(v < 0.4)*q",
        "sign(q - 0.2*sign(v))",
        "-3*sign(q)*(t < 5) - q",
        "sign(sin(20*q))",
        "1 if 0 < q < 0.5 else v",
        "-q % 0.25",
    ];

    /// Within its cells a formula is what it is; beyond one end of one of them it is what it is there.
    #[test]
    fn cells_are_left_where_the_formula_switches() {
        let (mut crossings, mut bits) = (0, 0x2545_f491_4f6c_dd1d_u64);
        let mut random = || {
            bits ^= bits << 13;
            bits ^= bits >> 7;
            bits ^= bits << 17;
            (bits >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        };
        for text in TEXTS {
            let formula = Formula::parse(text, &["t", "q", "v"]).unwrap();
            let mut pieces = formula.pieces(&[1, 2]);
            assert!(!pieces.is_empty(), "{text}");
            for _ in 0..400 {
                let at = [1.0, random(), random()];
                formula.keep(&mut pieces, &at, &[1.0, 0.0, 0.0]);
                let plain = formula.gradient(&at, [1, 2]);
                assert_eq!(formula.gradient_within(&pieces, &at, [1, 2]), plain, "{text} at {at:?}");
                // A short way off, all ends that are passed are crossed.
                let off = [1.0, at[1] + 0.02 * random(), at[2] + 0.02 * random()];
                let passed = |pieces: &Pieces| {
                    pieces.ends().find(|end| {
                        let (above, _) = formula.above(pieces, *end, &off, [1, 2]);
                        if end.is_upper { above > 0.0 } else { above < 0.0 }
                    })
                };
                while let Some(end) = passed(&pieces) {
                    pieces.cross(end);
                    crossings += 1;
                }
                let (kept, plain) = (formula.gradient_within(&pieces, &off, [1, 2]), formula.gradient(&off, [1, 2]));
                assert!((kept.0 - plain.0).abs() < 1e-14, "{text} at {off:?}: {kept:?}, {plain:?}");
                assert_eq!(kept.1, plain.1, "{text} at {off:?}");
            }
        }
        assert!(crossings > 100, "{crossings}");
    }

    /// What is on an end is in the cell that it comes to; a sign of zero stays zero.
    #[test]
    fn on_an_end_the_rate_decides() {
        for (text, rate, beside) in [
            ("sign(q)", 1.0, 1.0),
            ("sign(q)", -1.0, -1.0),
            ("sign(q)", 0.0, 0.0),
            ("floor(q + 2)", -1.0, 1.0),
            ("ceil(q + 2)", 1.0, 3.0),
            ("round(q + 0.5)", 1.0, 1.0),
            ("round(q + 1.5)", -1.0, 1.0),
            ("trunc(q + 2)", -1.0, 1.0),
            ("trunc(q - 2)", 1.0, -1.0),
            ("trunc(q)", -1.0, 0.0),
            ("q > 0", 1.0, 1.0),
            ("q >= 0", -1.0, 0.0),
        ] {
            let formula = Formula::parse(text, &["q"]).unwrap();
            let mut pieces = formula.pieces(&[0]);
            formula.keep(&mut pieces, &[0.0], &[rate]);
            assert_eq!(formula.gradient_within(&pieces, &[1e-9 * rate], [0]).0, beside, "{text} at {rate}");
        }
    }
}
