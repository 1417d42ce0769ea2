//! What formulas are computed with: plain numbers, truncated Taylor series, gradients.

use super::function::{Binary, Unary};

/// What a program can be run on.
pub(super) trait Number: Copy {
    fn constant(value: f64) -> Self;
    fn value(self) -> f64;
    fn unary(self, function: Unary) -> Self;
    fn binary(function: Binary, a: Self, b: Self) -> Self;
}

impl Number for f64 {
    fn constant(value: f64) -> Self {
        value
    }

    fn value(self) -> f64 {
        self
    }

    fn unary(self, function: Unary) -> Self {
        function.value(self)
    }

    fn binary(function: Binary, a: Self, b: Self) -> Self {
        function.value(a, b)
    }
}

/// A number that may be infinite.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extended(pub(super) f64);

impl Number for Extended {
    fn constant(value: f64) -> Self {
        Self(value)
    }

    fn value(self) -> f64 {
        self.0
    }

    fn unary(self, function: Unary) -> Self {
        Self(if self.0.is_nan() { self.0 } else { function.of_number(self.0) })
    }

    fn binary(function: Binary, a: Self, b: Self) -> Self {
        Self(function.extended(a.0, b.0))
    }
}

/// A truncated Taylor series: value, first and second derivative along a parameter.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Jet {
    /// The value.
    pub value: f64,
    /// Its first derivative.
    pub first: f64,
    /// Its second derivative.
    pub second: f64,
}

impl Jet {
    /// The parameter itself.
    pub fn variable(value: f64) -> Self {
        Self { value, first: 1.0, second: 0.0 }
    }

    /// What does not change with it.
    pub fn constant(value: f64) -> Self {
        Self { value, first: 0.0, second: 0.0 }
    }

    /// From `q b = a`: no power of `b`, which may be large, is taken.
    fn quotient(a: Self, b: Self) -> Self {
        let value = Binary::Divide.value(a.value, b.value);
        let first = (a.first - times(b.first, value)) / b.value;
        let second = (a.second - 2.0 * times(b.first, first) - times(b.second, value)) / b.value;
        Self { value, first, second }
    }
}

/// Whether a function has come to its limit: its arguments, or one of them, are too large for a number, its value is not. It has no slope there,
/// as `1/(1 + exp(x))`.
pub(super) fn is_at_limit(arguments: &[f64], value: f64) -> bool {
    value.is_finite() && arguments.iter().any(|argument| argument.is_infinite())
}

/// `slope · x`, zero for what does not change: a slope may be infinite there.
fn times(slope: f64, x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { slope * x }
}

impl Number for Jet {
    fn constant(value: f64) -> Self {
        Self::constant(value)
    }

    fn value(self) -> f64 {
        self.value
    }

    fn unary(self, function: Unary) -> Self {
        let value = function.value(self.value);
        if self.first == 0.0 && self.second == 0.0 || is_at_limit(&[self.value], value) {
            return Self::constant(value);
        }
        let [slope, curvature] = function.derivatives(self.value, value);
        // Equations 1 and 2.
        Self {
            value,
            first: times(slope, self.first),
            second: times(times(curvature, self.first), self.first) + times(slope, self.second),
        }
    }

    fn binary(function: Binary, a: Self, b: Self) -> Self {
        if let Some(second) = function.takes_second(a.value, b.value) {
            return if second { b } else { a };
        }
        if function == Binary::Divide {
            return Self::quotient(a, b);
        }
        let at = function.surface(a.value, b.value);
        if is_at_limit(&[a.value, b.value], at.value) {
            return Self::constant(at.value);
        }
        let ([by_a, by_b], [by_aa, by_ab, by_bb]) = (at.slopes, at.curvatures);
        // Equations 1 and 2 of two arguments.
        Self {
            value: at.value,
            first: times(by_a, a.first) + times(by_b, b.first),
            // Squares of what is large may be too large.
            second: times(times(by_aa, a.first), a.first)
                + 2.0 * times(times(by_ab, a.first), b.first)
                + times(times(by_bb, b.first), b.first)
                + times(by_a, a.second)
                + times(by_b, b.second),
        }
    }
}

/// A value and its derivatives with respect to `N` variables.
#[derive(Debug, Clone, Copy)]
pub(super) struct Gradient<const N: usize> {
    pub(super) value: f64,
    pub(super) slopes: [f64; N],
}

impl<const N: usize> Number for Gradient<N> {
    fn constant(value: f64) -> Self {
        Self { value, slopes: [0.0; N] }
    }

    fn value(self) -> f64 {
        self.value
    }

    fn unary(self, function: Unary) -> Self {
        let value = function.value(self.value);
        if self.slopes == [0.0; N] || is_at_limit(&[self.value], value) {
            return Self::constant(value);
        }
        let [slope, _] = function.derivatives(self.value, value);
        Self { value, slopes: self.slopes.map(|by| times(slope, by)) }
    }

    fn binary(function: Binary, a: Self, b: Self) -> Self {
        if let Some(second) = function.takes_second(a.value, b.value) {
            return if second { b } else { a };
        }
        if function == Binary::Divide {
            let value = function.value(a.value, b.value);
            let slopes = std::array::from_fn(|i| (a.slopes[i] - times(b.slopes[i], value)) / b.value);
            return Self { value, slopes };
        }
        let at = function.surface(a.value, b.value);
        if is_at_limit(&[a.value, b.value], at.value) {
            return Self::constant(at.value);
        }
        let slopes = std::array::from_fn(|i| times(at.slopes[0], a.slopes[i]) + times(at.slopes[1], b.slopes[i]));
        Self { value: at.value, slopes }
    }
}
