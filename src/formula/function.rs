//! Functions of one and of two arguments with their first and second derivatives.

use std::f64::consts::{LN_2, LN_10};

/// A function of one argument.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unary {
    Minus,
    Not,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Asinh,
    Acosh,
    Atanh,
    Exp,
    Ln,
    Log2,
    Log10,
    Sqrt,
    Cbrt,
    Abs,
    Sign,
    Floor,
    Ceil,
    Round,
    Trunc,
    Fract,
}

/// A function of two arguments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Binary {
    Add,
    Subtract,
    Multiply,
    Divide,
    FloorDivide,
    Remainder,
    Power,
    Min,
    Max,
    Atan2,
    Hypot,
    And,
    Or,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
    Equal,
    NotEqual,
}

/// Value, first and second derivatives of a function of two arguments.
#[derive(Debug, Clone, Copy)]
pub(super) struct Surface {
    pub(super) value: f64,
    /// With respect to the first and the second argument.
    pub(super) slopes: [f64; 2],
    /// Twice by the first, by both, twice by the second.
    pub(super) curvatures: [f64; 3],
}

fn flag(condition: bool) -> f64 {
    if condition { 1.0 } else { 0.0 }
}

/// What is infinite at a pole is not a number at all: nothing that follows from it may look like one. What is only too large for a number
/// goes on as infinite: `1/(1 + exp(x))` is zero there.
fn but_at_pole(x: f64, is_pole: bool) -> f64 {
    if x.is_infinite() && is_pole { f64::NAN } else { x }
}

impl Unary {
    pub(super) fn value(self, x: f64) -> f64 {
        let grows = matches!(self, Self::Exp | Self::Sinh | Self::Cosh);
        if x.is_nan() { x } else { but_at_pole(self.of_number(x), x.is_finite() && !grows) }
    }

    /// Its value where infinite ones count.
    pub(super) fn of_number(self, x: f64) -> f64 {
        match self {
            Self::Minus => -x,
            Self::Not => flag(x == 0.0),
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Tan => x.tan(),
            Self::Asin => x.asin(),
            Self::Acos => x.acos(),
            Self::Atan => x.atan(),
            Self::Sinh => x.sinh(),
            Self::Cosh => x.cosh(),
            Self::Tanh => x.tanh(),
            Self::Asinh => x.asinh(),
            Self::Acosh => x.acosh(),
            Self::Atanh => x.atanh(),
            Self::Exp => x.exp(),
            Self::Ln => x.ln(),
            Self::Log2 => x.log2(),
            Self::Log10 => x.log10(),
            Self::Sqrt => x.sqrt(),
            Self::Cbrt => x.cbrt(),
            Self::Abs => x.abs(),
            Self::Sign if x == 0.0 => 0.0,
            Self::Sign => x.signum(),
            Self::Floor => x.floor(),
            Self::Ceil => x.ceil(),
            // Half to even, as Python does it.
            Self::Round => x.round_ties_even(),
            Self::Trunc => x.trunc(),
            Self::Fract => x.fract(),
        }
    }

    /// First and second derivative at `x`, where the value is `f`.
    pub(super) fn derivatives(self, x: f64, f: f64) -> [f64; 2] {
        match self {
            Self::Minus => [-1.0, 0.0],
            Self::Not | Self::Sign | Self::Floor | Self::Ceil | Self::Round | Self::Trunc => [0.0, 0.0],
            Self::Fract => [1.0, 0.0],
            Self::Abs => [if x < 0.0 { -1.0 } else { 1.0 }, 0.0],
            Self::Sin => [x.cos(), -f],
            Self::Cos => [-x.sin(), -f],
            Self::Tan => [1.0 + f * f, 2.0 * f * (1.0 + f * f)],
            Self::Asin => inverse((1.0 - x) * (1.0 + x), x),
            Self::Acos => inverse((1.0 - x) * (1.0 + x), x).map(|slope| -slope),
            Self::Atan => {
                let slope = 1.0 / (1.0 + x * x);
                [slope, -2.0 * x * slope * slope]
            }
            Self::Sinh => [x.cosh(), f],
            Self::Cosh => [x.sinh(), f],
            Self::Tanh => {
                // 1 − tanh² without cancellation.
                let slope = x.cosh().powi(-2);
                [slope, -2.0 * f * slope]
            }
            Self::Asinh => inverse(1.0 + x * x, -x),
            Self::Acosh => inverse((x - 1.0) * (x + 1.0), -x),
            Self::Atanh => {
                let slope = 1.0 / ((1.0 - x) * (1.0 + x));
                [slope, 2.0 * x * slope * slope]
            }
            Self::Exp => [f, f],
            Self::Ln => [1.0 / x, -1.0 / (x * x)],
            Self::Log2 => [1.0 / (x * LN_2), -1.0 / (x * x * LN_2)],
            Self::Log10 => [1.0 / (x * LN_10), -1.0 / (x * x * LN_10)],
            Self::Sqrt => [0.5 / f, -0.25 / (f * x)],
            Self::Cbrt => [1.0 / (3.0 * f * f), -2.0 / (9.0 * f * f * x)],
        }
    }
}

/// Derivatives of a function whose slope is `square^(−1/2)`; `x` is minus half the derivative of the square.
fn inverse(square: f64, x: f64) -> [f64; 2] {
    let slope = 1.0 / square.sqrt();
    [slope, x * slope / square]
}

impl Binary {
    pub(super) fn value(self, a: f64, b: f64) -> f64 {
        match self.takes_second(a, b) {
            Some(second) => pick(second, a, b),
            None => but_at_pole(self.extended(a, b), self.has_pole(a, b)),
        }
    }

    /// Whether nothing is a number near here.
    fn has_pole(self, a: f64, b: f64) -> bool {
        match self {
            Self::Divide | Self::FloorDivide | Self::Remainder => b == 0.0,
            Self::Power => a == 0.0,
            _ => false,
        }
    }

    /// Its value where infinite ones count.
    pub(super) fn extended(self, a: f64, b: f64) -> f64 {
        match self.takes_second(a, b) {
            Some(second) => pick(second, a, b),
            None if a.is_nan() || b.is_nan() => f64::NAN,
            None => self.of_numbers(a, b),
        }
    }

    fn of_numbers(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Add => a + b,
            Self::Subtract => a - b,
            Self::Multiply => a * b,
            Self::Divide => a / b,
            Self::FloorDivide => floor_divide(a, b),
            Self::Remainder => remainder(a, b),
            Self::Power => a.powf(b),
            Self::Atan2 => a.atan2(b),
            Self::Hypot => a.hypot(b),
            Self::Min | Self::Max | Self::And | Self::Or => pick(self.takes_second(a, b) == Some(true), a, b),
            Self::Less => flag(a < b),
            Self::LessOrEqual => flag(a <= b),
            Self::Greater => flag(a > b),
            Self::GreaterOrEqual => flag(a >= b),
            Self::Equal => flag(a == b),
            Self::NotEqual => flag(a != b),
        }
    }

    /// Whether the result is the second argument, for those that give one of both: of `and` and `or` the second is not looked at
    /// where the first decides, else one that is not a number is the result.
    pub(super) fn takes_second(self, a: f64, b: f64) -> Option<bool> {
        match self {
            Self::Min => Some(b < a || b.is_nan()),
            Self::Max => Some(b > a || b.is_nan()),
            Self::And => Some(a != 0.0 && !a.is_nan()),
            Self::Or => Some(a == 0.0),
            _ => None,
        }
    }

    /// The function around a place.
    pub(super) fn surface(self, a: f64, b: f64) -> Surface {
        let value = self.value(a, b);
        let (slopes, curvatures) = match self {
            Self::Add => ([1.0, 1.0], [0.0; 3]),
            Self::Subtract => ([1.0, -1.0], [0.0; 3]),
            Self::Multiply => ([b, a], [0.0, 1.0, 0.0]),
            Self::Divide => ([1.0 / b, -value / b], [0.0, -1.0 / (b * b), 2.0 * value / (b * b)]),
            // a − b n, where n jumps.
            Self::Remainder => ([1.0, -floor_divide(a, b)], [0.0; 3]),
            Self::Power => power(a, b, value),
            Self::Atan2 => {
                let square = a * a + b * b;
                let [x, y] = [b / square, a / square];
                ([x, -y], [-2.0 * x * y, y * y - x * x, 2.0 * x * y])
            }
            Self::Hypot => {
                let [x, y] = [a / value, b / value];
                ([x, y], [y * y / value, -x * y / value, x * x / value])
            }
            Self::Min | Self::Max | Self::And | Self::Or => {
                let second = self.takes_second(a, b) == Some(true);
                ([flag(!second), flag(second)], [0.0; 3])
            }
            Self::FloorDivide
            | Self::Less
            | Self::LessOrEqual
            | Self::Greater
            | Self::GreaterOrEqual
            | Self::Equal
            | Self::NotEqual => ([0.0; 2], [0.0; 3]),
        };
        Surface { value, slopes, curvatures }
    }
}

fn pick(second: bool, a: f64, b: f64) -> f64 {
    if second { b } else { a }
}

/// Slopes and curvatures of `a^b`. A factor of zero is zero, whatever it multiplies: `t^2` has a second derivative at 0.
fn power(a: f64, b: f64, value: f64) -> ([f64; 2], [f64; 3]) {
    let times = |factor: f64, x: f64| if factor == 0.0 { 0.0 } else { factor * x };
    let by_a = times(b, a.powf(b - 1.0));
    let by_aa = times(b * (b - 1.0), a.powf(b - 2.0));
    if a == 0.0 && b > 0.0 {
        // a^b ln a vanishes with a.
        return ([by_a, 0.0], [by_aa, 0.0, 0.0]);
    }
    let log = a.ln();
    ([by_a, value * log], [by_aa, a.powf(b - 1.0) * (1.0 + b * log), value * log * log])
}

/// Python's `%`: the remainder has the sign of the divisor.
fn remainder(a: f64, b: f64) -> f64 {
    let rest = a % b;
    if rest == 0.0 {
        return 0.0_f64.copysign(b);
    }
    if (rest < 0.0) == (b < 0.0) { rest } else { rest + b }
}

/// Python's `//`: rounded towards −∞.
fn floor_divide(a: f64, b: f64) -> f64 {
    if b == 0.0 {
        return a / b;
    }
    let quotient = (a - remainder(a, b)) / b;
    let floor = quotient.floor();
    if quotient - floor > 0.5 { floor + 1.0 } else { floor }
}
