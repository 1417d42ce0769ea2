//! What values a formula takes over a stretch of one variable, by interval arithmetic (Moore, *Interval Analysis*, 1966).
//!
//! ```text
//! (3)  x ∈ X, y ∈ Y  ⇒  f(x, y) ∈ F(X, Y)
//! ```
//!
//! `F` is spanned by the values at the ends of both ranges where `f` rises or falls all the way, and by what lies between them
//! besides. A range holds all values but may be wider than they are: as its stretch shrinks, it does. What follows from other
//! variables than the one is not known, and nothing is said of it.

use super::function::{Binary, Unary};
use super::{Formula, Operation};
use std::f64::consts::{PI, TAU};

/// All values between two numbers, or not known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Range {
    pub(super) low: f64,
    pub(super) high: f64,
    /// Whether it follows from the one variable alone.
    known: bool,
}

/// A range, and whether anything on the way to it may change its rule within the stretch: `abs`, `if`, a comparison.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stretch {
    pub(super) range: Range,
    pub(super) switches: bool,
}

impl Range {
    const UNKNOWN: Self = Self { low: f64::NEG_INFINITY, high: f64::INFINITY, known: false };
    /// Known to follow from the one variable, and no more.
    const ANY: Self = Self { known: true, ..Self::UNKNOWN };
    /// No value at all, as of the root of what is negative.
    const NOTHING: Self = Self { low: f64::NAN, high: f64::NAN, known: true };

    fn new(low: f64, high: f64) -> Self {
        // What is not a number may be anything.
        if low.is_nan() || high.is_nan() { Self::ANY } else { Self { low, high, known: true } }
    }

    fn point(value: f64) -> Self {
        if value.is_nan() { Self::NOTHING } else { Self::new(value, value) }
    }

    pub(super) fn is_nothing(self) -> bool {
        self.low.is_nan()
    }

    /// From one number to the other, whichever is larger; nothing if there is neither.
    pub(super) fn between([a, b]: [f64; 2]) -> Self {
        if a.is_nan() && b.is_nan() { Self::NOTHING } else { Self::of(&[a, b]) }
    }

    /// From the least to the largest of some numbers.
    fn of(values: &[f64]) -> Self {
        if values.iter().any(|x| x.is_nan()) {
            return Self::ANY;
        }
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        Self::new(low, values.iter().copied().fold(f64::NEG_INFINITY, f64::max))
    }

    pub(super) fn width(self) -> f64 {
        self.high - self.low
    }

    fn is_point(self) -> bool {
        self.low == self.high
    }

    fn has(self, x: f64) -> bool {
        self.low <= x && x <= self.high
    }

    fn around(self, other: Self) -> Self {
        Self::new(self.low.min(other.low), self.high.max(other.high))
    }

    /// The values at both ends of a function that rises or falls all the way.
    fn ends(self, f: impl Fn(f64) -> f64) -> Self {
        Self::of(&[f(self.low), f(self.high)])
    }

    /// The values at all ends of a function that rises or falls all the way in either argument.
    fn corners(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let (a, b) = (self, other);
        Self::of(&[f(a.low, b.low), f(a.low, b.high), f(a.high, b.low), f(a.high, b.high)])
    }

    /// Whether a number `first + k period` is within, for a whole k.
    fn meets(self, first: f64, period: f64) -> bool {
        first + ((self.low - first) / period).ceil() * period <= self.high
    }

    /// A sine or cosine: 1 at `crest` and every turn from there.
    fn wave(self, f: impl Fn(f64) -> f64, crest: f64) -> Self {
        if !(self.width() < TAU) {
            return Self::new(-1.0, 1.0);
        }
        let Self { low, high, .. } = self.ends(f);
        let (top, bottom) = (self.meets(crest, TAU), self.meets(crest - PI, TAU));
        Self::new(if bottom { -1.0 } else { low }, if top { 1.0 } else { high })
    }

    fn times(self, other: Self) -> Self {
        // An end that is infinite stands for numbers without bound, all of which zero takes to zero.
        self.corners(other, |a, b| if a == 0.0 || b == 0.0 { 0.0 } else { a * b })
    }

    fn over(self, other: Self) -> Self {
        match other.has(0.0) {
            true if other.is_point() => Self::NOTHING,
            true => Self::ANY,
            false => self.corners(other, |a, b| a / b),
        }
    }

    fn power(self, exponent: Self) -> Self {
        let ends = self.corners(exponent, f64::powf);
        let whole = exponent.is_point() && exponent.low.fract() == 0.0;
        match (self.low < 0.0, self.has(0.0)) {
            (true, false) if !whole && exponent.is_point() => Self::NOTHING,
            (true, _) if !whole => Self::ANY,
            (_, true) if exponent.low < 0.0 => Self::ANY,
            (true, true) => ends.around(Self::point(0.0_f64.powf(exponent.low))),
            _ => ends,
        }
    }
}

impl Unary {
    /// The values over a range, and whether the rule may change within it.
    fn range(self, x: Range) -> (Range, bool) {
        let at = |y: f64| self.value(y);
        if x.is_point() || x.is_nothing() {
            return (Range::point(at(x.low)), false);
        }
        let smooth = |range: Range| (range, false);
        match self {
            Self::Sin => smooth(x.wave(f64::sin, 0.5 * PI)),
            Self::Cos => smooth(x.wave(f64::cos, 0.0)),
            Self::Tan if x.meets(0.5 * PI, PI) || !(x.width() < PI) => smooth(Range::ANY),
            Self::Cosh if x.has(0.0) => smooth(x.ends(at).around(Range::point(1.0))),
            // What is not defined at one of the ends may be anything; at both, on one side of zero, it is so nowhere between.
            _ if self.bends() && !x.has(0.0) && at(x.low).is_nan() && at(x.high).is_nan() => smooth(Range::NOTHING),
            Self::Abs if x.has(0.0) => (x.ends(at).around(Range::point(0.0)), true),
            Self::Not if x.has(0.0) => (Range::new(0.0, 1.0), true),
            Self::Sign if x.has(0.0) => (Range::new(-1.0, 1.0), true),
            Self::Floor | Self::Ceil | Self::Round | Self::Trunc => {
                let ends = x.ends(at);
                (ends, !ends.is_point())
            }
            Self::Fract if x.low.trunc() != x.high.trunc() => (Range::new(-1.0, 1.0), true),
            // What rises or falls all the way.
            _ => smooth(x.ends(at)),
        }
    }

    /// Which rule is followed at a place, for those that have several.
    fn rule(self, x: f64) -> Option<f64> {
        match self {
            Self::Abs => Some(if x < 0.0 { -1.0 } else { 1.0 }),
            Self::Fract => Some(x.trunc()),
            Self::Not | Self::Sign | Self::Floor | Self::Ceil | Self::Round | Self::Trunc => Some(self.value(x)),
            _ => None,
        }
    }
}

impl Binary {
    /// The values over two ranges, and whether the rule may change within them.
    fn range(self, a: Range, b: Range) -> (Range, bool) {
        let at = |a: f64, b: f64| self.value(a, b);
        let looks_at_both = !matches!(self, Self::And | Self::Or);
        if a.is_nothing() || (b.is_nothing() && looks_at_both) {
            return (Range::NOTHING, false);
        }
        if a.is_point() && b.is_point() {
            return (Range::point(at(a.low, b.low)), false);
        }
        let smooth = |range: Range| (range, false);
        let apart = Range::new(a.low - b.high, a.high - b.low);
        match self {
            Self::Add => smooth(Range::new(a.low + b.low, a.high + b.high)),
            Self::Subtract => smooth(apart),
            Self::Multiply => smooth(a.times(b)),
            Self::Divide => smooth(a.over(b)),
            Self::Power => smooth(a.power(b)),
            Self::FloorDivide | Self::Remainder if b.has(0.0) && b.is_point() => smooth(Range::NOTHING),
            Self::FloorDivide | Self::Remainder if b.has(0.0) => (Range::ANY, true),
            Self::FloorDivide | Self::Remainder => {
                let quotient = a.corners(b, |a, b| Self::FloorDivide.value(a, b));
                let all = match self {
                    Self::FloorDivide => quotient,
                    _ if quotient.is_point() && !b.is_point() => {
                        let taken = quotient.times(b);
                        Range::new(a.low - taken.high, a.high - taken.low)
                    }
                    _ if quotient.is_point() => a.ends(|a| at(a, b.low)),
                    _ => Range::of(&[0.0, b.low, b.high]),
                };
                (all, !quotient.is_point())
            }
            // Around the origin, and where it jumps by a turn.
            Self::Atan2 if a.has(0.0) && b.low <= 0.0 => (Range::new(-PI, PI), true),
            Self::Atan2 => smooth(a.corners(b, at)),
            Self::Hypot => smooth(Unary::Abs.range(a).0.corners(Unary::Abs.range(b).0, at)),
            Self::Min => (Range::new(a.low.min(b.low), a.high.min(b.high)), apart.has(0.0)),
            Self::Max => (Range::new(a.low.max(b.low), a.high.max(b.high)), apart.has(0.0)),
            Self::And | Self::Or if a.has(0.0) && !a.is_point() => (a.around(b), true),
            Self::And => smooth(if a.has(0.0) { a } else { b }),
            Self::Or => smooth(if a.has(0.0) { b } else { a }),
            Self::Less | Self::LessOrEqual | Self::Greater | Self::GreaterOrEqual | Self::Equal | Self::NotEqual => {
                match apart.has(0.0) {
                    true => (Range::new(0.0, 1.0), true),
                    false => smooth(Range::point(at(a.low, b.low))),
                }
            }
        }
    }

    /// Which rule is followed at a place, for those that have several.
    fn rule(self, a: f64, b: f64) -> Option<f64> {
        match self {
            Self::FloorDivide | Self::Remainder => Some(Self::FloorDivide.value(a, b)),
            Self::Atan2 => Some(if b < 0.0 && a.is_sign_negative() { -1.0 } else { 1.0 }),
            Self::Min | Self::Max | Self::And | Self::Or => {
                self.takes_second(a, b).map(|second| if second { 1.0 } else { 0.0 })
            }
            Self::Less | Self::LessOrEqual | Self::Greater | Self::GreaterOrEqual | Self::Equal | Self::NotEqual => {
                Some(self.value(a, b))
            }
            Self::Add | Self::Subtract | Self::Multiply | Self::Divide | Self::Power | Self::Hypot => None,
        }
    }
}

/// Evaluates a formula over stretches of one variable.
pub(super) struct Ranges<'f> {
    formula: &'f Formula,
    variable: usize,
    registers: Vec<Range>,
}

impl<'f> Ranges<'f> {
    pub(super) fn new(formula: &'f Formula, variable: usize) -> Self {
        Self { formula, variable, registers: vec![Range::UNKNOWN; formula.registers] }
    }

    /// All of the formula between two values of the variable.
    pub(super) fn whole(&mut self, between: [f64; 2]) -> Stretch {
        self.part(between, [0, self.formula.steps.len() - 1])
    }

    /// The result of the last of some steps, if these are all that it follows from.
    pub(super) fn part(&mut self, [low, high]: [f64; 2], steps: [usize; 2]) -> Stretch {
        let variable = self.variable;
        self.follow(|index| if index == variable { Range::new(low, high) } else { Range::UNKNOWN }, steps)
    }

    /// The result of the last of some steps, from ranges of all variables.
    fn follow(&mut self, variable: impl Fn(usize) -> Range, [first, last]: [usize; 2]) -> Stretch {
        let (registers, mut switches, mut range) = (&mut self.registers, false, Range::UNKNOWN);
        for step in &self.formula.steps[first..=last] {
            let mut note = |(range, switched): (Range, bool)| {
                switches |= switched;
                range
            };
            range = match step.operation {
                Operation::Constant(value) => Range::point(value),
                Operation::Variable(index) => variable(index),
                Operation::Copy(from) => registers[from],
                Operation::Unary(function, of) if registers[of].known => note(function.range(registers[of])),
                Operation::Binary(function, a, b) if registers[a].known && registers[b].known => {
                    note(function.range(registers[a], registers[b]))
                }
                Operation::Unary(..) | Operation::Binary(..) => Range::UNKNOWN,
                Operation::Select(condition, yes, no) => {
                    let (condition, yes, no) = (registers[condition], registers[yes], registers[no]);
                    match condition.known {
                        false => Range::UNKNOWN,
                        true if condition.is_nothing() => Range::NOTHING,
                        true if !condition.has(0.0) => yes,
                        true if condition.is_point() => no,
                        true if yes.known && no.known => note((yes.around(no), true)),
                        true => note((Range::UNKNOWN, true)),
                    }
                }
            };
            registers[step.to] = range;
        }
        Stretch { range, switches }
    }
}

impl Formula {
    /// The least and the largest value over ranges of all variables, or numbers beyond them; infinite where that is not known, not numbers
    /// where there is no value.
    pub fn range(&self, variables: &[[f64; 2]]) -> [f64; 2] {
        let of = |index: usize| variables.get(index).map_or(Range::UNKNOWN, |ends| Range::between(*ends));
        let mut ranges = Ranges::new(self, 0);
        ranges.follow(of, [0, self.steps.len() - 1]);
        // The last step of comparisons in a chain is not its result.
        let found = ranges.registers[0];
        [found.low, found.high]
    }

    /// Which rule each of its parts follows at one value of a variable, of those that follow from it alone: equal lists, equal rules.
    pub(super) fn rules(&self, variable: usize, at: f64) -> Vec<f64> {
        let (mut registers, mut rules) = (vec![None; self.registers], Vec::new());
        for step in &self.steps {
            registers[step.to] = match step.operation {
                Operation::Constant(value) => Some(value),
                Operation::Variable(index) => (index == variable).then_some(at),
                Operation::Copy(from) => registers[from],
                Operation::Unary(function, of) => registers[of].map(|x: f64| {
                    rules.extend(function.rule(x));
                    function.value(x)
                }),
                Operation::Binary(function, a, b) => registers[a].zip(registers[b]).map(|(a, b)| {
                    rules.extend(function.rule(a, b));
                    function.value(a, b)
                }),
                Operation::Select(condition, yes, no) => match registers[condition] {
                    Some(0.0) => registers[no],
                    Some(condition) if !condition.is_nan() => registers[yes],
                    _ => None,
                },
            };
        }
        // A rule without a value is the same as itself.
        rules.iter_mut().filter(|rule| rule.is_nan()).for_each(|rule| *rule = f64::INFINITY);
        rules
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Between ends near and far, and over points.
    const LENGTHS: [f64; 5] = [0.0, 1e-6, 0.01, 0.7, 5.0];

    #[test]
    fn ranges_hold_all_values() {
        let texts = [
            "sin(3*t) + cos(t/2)",
            "tan(t)",
            "abs(t-3.3) - t**3",
            "exp(-((t-3.3)/0.1)^2)",
            "t%1 - t//2",
            "t % (2+sin(t)) + t % -0.7 + 3 // (t+10)",
            "max(t, 2) * min(-t, 1)",
            "sqrt(abs(t)) + cbrt(t) + atan(t) + tanh(t) + cosh(t)",
            "asin(t/4) + acos(t/9) + asinh(t) + acosh(1+t^2) + atanh(t/10) + sinh(t)",
            "ln(5+t) + log2(6+t) * log10(7+t)",
            "1/(t-2)",
            "(t-1)^2 + (t-1)^3 + 2^t + (t-1)^-1 + (5+t)^0.5 + (5+t)^t",
            "(t-1)^0 + t^-2 + abs(t)^1.5",
            "if(0.5 < t and not t > 2, t, -t)",
            "floor(t)*ceil(t) + round(3*t) + trunc(t) + fract(t) + sign(t-1)",
            "atan2(t, 2-t) + hypot(t, 1-t) + atan2(1+t, t-3)",
            "(t > 1) + (t == 2) + (t or 3) + (t != 0) + (t >= 1 <= 2)",
            "1/(1+t^2)/(2-cos(t))",
        ];
        for text in texts {
            let formula = Formula::parse(text, &["t"]).unwrap();
            let mut ranges = Ranges::new(&formula, 0);
            for k in 0..400 {
                let low = -4.0 + 0.02 * f64::from(k);
                for length in LENGTHS {
                    let Stretch { range, .. } = ranges.whole([low, low + length]);
                    for part in 0..=20 {
                        let value = formula.value(&[low + length * f64::from(part) / 20.0]);
                        // Round-off of functions that rise or fall all the way.
                        let slack = 1e-12 * (1.0 + value.abs());
                        let within = range.low - slack <= value && value <= range.high + slack;
                        assert!(within || value.is_nan(), "{text} at {low} + {length}: {value} is not in {range:?}");
                    }
                }
            }
        }
    }

    /// Short stretches have narrow ranges.
    #[test]
    fn ranges_shrink_with_their_stretch() {
        for text in ["sin(3*t)*cos(t)", "exp(-t^2)*t", "atan2(t, t-3)", "t % 7.0", "hypot(t, 1) - t^3/(1+t^2)"] {
            let formula = Formula::parse(text, &["t"]).unwrap();
            let width = Ranges::new(&formula, 0).whole([0.3, 0.3 + 1e-9]).range.width();
            assert!(width < 1e-7, "{text}: {width:e}");
        }
    }

    /// What has no value switches nothing: it is found where it begins to have one.
    #[test]
    fn what_is_not_defined_is_nothing() {
        for text in [
            "sqrt(t) < 1",
            "asin(t) > 0",
            "abs(ln(t))",
            "floor(t/0)",
            "max(1, t % 0)",
            "if(acosh(t), 1, 2)",
            "t^0.5 > 3 or 1",
        ] {
            let formula = Formula::parse(text, &["t"]).unwrap();
            let Stretch { range, switches } = Ranges::new(&formula, 0).whole([-3.0, -2.0]);
            assert!(range.is_nothing() && !switches, "{text}: {range:?}");
        }
    }

    /// Over ranges of all variables; the last step of comparisons in a chain is not their result.
    #[test]
    fn ranges_of_several_variables_hold_the_result() {
        let formula = Formula::parse("1 < q < 2", &["t", "q"]).unwrap();
        let over = |q: [f64; 2]| formula.range(&[[0.0, 9.0], q]);
        assert_eq!([over([0.0, 3.0]), over([3.0, 4.0]), over([1.2, 1.8])], [[0.0, 1.0], [0.0; 2], [1.0; 2]]);
        assert_eq!(Formula::parse("t*q", &["t", "q"]).unwrap().range(&[[-1.0, 2.0], [3.0, 4.0]]), [-4.0, 8.0]);
    }

    /// Of other variables nothing is known, but for what does not need them.
    #[test]
    fn what_follows_from_others_is_not_known() {
        let formula = Formula::parse("if(t < 1, q*abs(t-0.5), abs(q))", &["t", "q"]).unwrap();
        let mut ranges = Ranges::new(&formula, 0);
        let at = |ranges: &mut Ranges<'_>, between| {
            let Stretch { range, switches } = ranges.whole(between);
            (range.known, switches)
        };
        assert_eq!(at(&mut ranges, [0.0, 0.4]), (false, false));
        assert_eq!(at(&mut ranges, [0.0, 0.6]), (false, true));
        assert_eq!(at(&mut ranges, [0.9, 1.1]), (false, true));
        assert_eq!(at(&mut ranges, [2.0, 3.0]), (false, false));
    }
}
