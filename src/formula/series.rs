//! Truncated Taylor series with four derivatives: what curves of guided motion need.
//!
//! ```text
//! (3)  f(g₀ + h) = Σ f⁽ᵏ⁾(g₀) hᵏ/k!,   h = Σ gₖ xᵏ without its constant term,   k ≤ 4
//! ```

use super::function::{Binary, Unary};
use super::number::{Number, is_at_limit};
use std::f64::consts::{LN_2, LN_10};

/// Coefficients of 1, x … x⁴.
#[derive(Debug, Clone, Copy)]
pub(super) struct Series(pub(super) [f64; 5]);

/// A factor of zero is zero, whatever it multiplies.
fn times(factor: f64, x: f64) -> f64 {
    if factor == 0.0 || x == 0.0 { 0.0 } else { factor * x }
}

impl Series {
    fn is_constant(&self) -> bool {
        self.0[1..] == [0.0; 4]
    }

    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }

    fn sum(a: Self, b: Self) -> Self {
        Self(std::array::from_fn(|k| a.0[k] + b.0[k]))
    }

    fn product(a: Self, b: Self) -> Self {
        Self(std::array::from_fn(|k| (0..=k).map(|i| times(a.0[i], b.0[k - i])).sum()))
    }

    fn quotient(a: Self, b: Self) -> Self {
        let mut q = [0.0; 5];
        for k in 0..5 {
            let known: f64 = (0..k).map(|i| times(q[i], b.0[k - i])).sum();
            q[k] = (a.0[k] - known) / b.0[0];
        }
        Self(q)
    }

    /// Equation 3 with `f` and its four derivatives at the constant term.
    fn composed(self, f: [f64; 5]) -> Self {
        let h = Self([0.0, self.0[1], self.0[2], self.0[3], self.0[4]]);
        let (mut power, mut factorial) = (Self([1.0, 0.0, 0.0, 0.0, 0.0]), 1.0);
        let mut sum = [0.0; 5];
        for (k, derivative) in f.into_iter().enumerate() {
            factorial *= k.max(1) as f64;
            (0..5).for_each(|i| sum[i] += times(derivative / factorial, power.0[i]));
            power = Self::product(power, h);
        }
        Self(sum)
    }

    /// The series with this rate and value.
    fn integral(value: f64, rate: Self) -> Self {
        Self(std::array::from_fn(|k| if k == 0 { value } else { rate.0[k - 1] / k as f64 }))
    }

    fn rate(self) -> Self {
        Self(std::array::from_fn(|k| if k == 4 { 0.0 } else { (k + 1) as f64 * self.0[k + 1] }))
    }

    /// `selfᵇ` for a constant exponent.
    fn to_the(self, b: f64) -> Self {
        let mut f = [0.0; 5];
        let mut factor = 1.0;
        for (k, f) in f.iter_mut().enumerate() {
            *f = times(factor, self.0[0].powf(b - k as f64));
            factor *= b - k as f64;
        }
        self.composed(f)
    }
}

/// The first four derivatives of a function at `x`, where its value is `f`.
fn derivatives(of: Unary, x: f64, f: f64) -> [f64; 4] {
    // Of `c xᵖ`, from the first on.
    let powers = |first: f64, p: f64| {
        [first, first * p / x, first * p * (p - 1.0) / (x * x), first * p * (p - 1.0) * (p - 2.0) / (x * x * x)]
    };
    // Of a function whose slope is r = |1 ∓ x²|^(−1/2): r' = ± x r³.
    let root = |r: f64, sign: f64| {
        let (r3, r5, x2) = (r.powi(3), r.powi(5), x * x);
        [r, sign * x * r3, sign * r3 + 3.0 * x2 * r5, 9.0 * x * r5 + sign * 15.0 * x * x2 * r.powi(7)]
    };
    // Of one whose slope is r = 1/(1 ∓ x²): r' = ± 2 x r².
    let inverse = |r: f64, sign: f64| {
        let (r2, r3, x2) = (r * r, r.powi(3), x * x);
        [r, sign * 2.0 * x * r2, sign * 2.0 * r2 + 8.0 * x2 * r3, 24.0 * x * r3 + sign * 48.0 * x * x2 * r3 * r]
    };
    // Of one with f' = slope and f'' = c f f'.
    let riccati = |slope: f64, c: f64| {
        let second = c * f * slope;
        let third = c * (slope * slope + f * second);
        [slope, second, third, c * (3.0 * slope * second + f * third)]
    };
    match of {
        Unary::Sin => [x.cos(), -f, -x.cos(), f],
        Unary::Cos => [-x.sin(), -f, x.sin(), f],
        Unary::Tan => riccati(1.0 + f * f, 2.0),
        Unary::Tanh => riccati(x.cosh().powi(-2), -2.0),
        Unary::Asin => root(((1.0 - x) * (1.0 + x)).powf(-0.5), 1.0),
        Unary::Acos => root(((1.0 - x) * (1.0 + x)).powf(-0.5), 1.0).map(|slope| -slope),
        Unary::Asinh => root((1.0 + x * x).powf(-0.5), -1.0),
        Unary::Acosh => root(((x - 1.0) * (x + 1.0)).powf(-0.5), -1.0),
        Unary::Atan => inverse(1.0 / (1.0 + x * x), -1.0),
        Unary::Atanh => inverse(1.0 / ((1.0 - x) * (1.0 + x)), 1.0),
        Unary::Sinh => [x.cosh(), f, x.cosh(), f],
        Unary::Cosh => [x.sinh(), f, x.sinh(), f],
        Unary::Exp => [f; 4],
        Unary::Ln => powers(1.0 / x, -1.0),
        Unary::Log2 => powers(1.0 / (x * LN_2), -1.0),
        Unary::Log10 => powers(1.0 / (x * LN_10), -1.0),
        Unary::Sqrt => powers(0.5 / f, -0.5),
        Unary::Cbrt => powers(f / (3.0 * x), -2.0 / 3.0),
        // Straight on both sides of their kinks.
        Unary::Minus
        | Unary::Not
        | Unary::Abs
        | Unary::Sign
        | Unary::Floor
        | Unary::Ceil
        | Unary::Round
        | Unary::Trunc
        | Unary::Fract => [of.derivatives(x, f)[0], 0.0, 0.0, 0.0],
    }
}

impl Number for Series {
    fn constant(value: f64) -> Self {
        Self([value, 0.0, 0.0, 0.0, 0.0])
    }

    fn value(self) -> f64 {
        self.0[0]
    }

    fn unary(self, function: Unary) -> Self {
        let (x, value) = (self.0[0], function.value(self.0[0]));
        if self.is_constant() || is_at_limit(&[x], value) {
            return Self::constant(value);
        }
        let [first, second, third, fourth] = derivatives(function, x, value);
        self.composed([value, first, second, third, fourth])
    }

    fn binary(function: Binary, a: Self, b: Self) -> Self {
        if let Some(second) = function.takes_second(a.0[0], b.0[0]) {
            return if second { b } else { a };
        }
        let value = function.value(a.0[0], b.0[0]);
        if is_at_limit(&[a.0[0], b.0[0]], value) {
            return Self::constant(value);
        }
        let product = Self::product;
        let mut series = match function {
            Binary::Add => Self::sum(a, b),
            Binary::Subtract => Self::sum(a, b.map(|x| -x)),
            Binary::Multiply => product(a, b),
            Binary::Divide => Self::quotient(a, b),
            // a − b n, where n jumps.
            Binary::Remainder => {
                let n = function.surface(a.0[0], b.0[0]).slopes[1];
                Self::sum(a, b.map(|x| times(n, x)))
            }
            Binary::Power if b.is_constant() => a.to_the(b.0[0]),
            Binary::Power => product(b, a.unary(Unary::Ln)).unary(Unary::Exp),
            Binary::Atan2 => {
                let turning = Self::sum(product(a.rate(), b), product(a, b.rate()).map(|x| -x));
                Self::integral(value, Self::quotient(turning, Self::sum(product(a, a), product(b, b))))
            }
            Binary::Hypot => Self::sum(product(a, a), product(b, b)).to_the(0.5),
            // The first four take one of both, above.
            Binary::Min
            | Binary::Max
            | Binary::And
            | Binary::Or
            | Binary::FloorDivide
            | Binary::Less
            | Binary::LessOrEqual
            | Binary::Greater
            | Binary::GreaterOrEqual
            | Binary::Equal
            | Binary::NotEqual => Self::constant(value),
        };
        series.0[0] = value;
        series
    }
}

#[cfg(test)]
mod tests {
    use crate::formula::{Formula, Jet};

    /// What is divided by what is too large for a number is zero, and so are its derivatives: of a logistic function far from its middle.
    #[test]
    fn functions_of_what_overflows_are_at_their_limits() {
        for text in [
            "1/(1+exp((t-1)/1e-4))",
            "0.3/(1+cosh(1e4*(t-5)))",
            "2 - 3/(1+exp(5e3*(t-1)))^2",
            "exp(-exp(1e3*t))",
            "1 + tanh(sinh(1e3*t))",
            "atan(exp(500*t))/4",
            // Not the number itself overflows, but its square.
            "1/(1+exp(150*t))",
        ] {
            let formula = Formula::parse(text, &["t"]).unwrap();
            let (value, at) = (formula.value(&[3.0]), formula.derivatives(3.0));
            assert!(value.is_finite() && at[0] == value, "{text}: {at:?}");
            assert!(at[1..].iter().all(|derivative| derivative.abs() < 1e-180), "{text}: {at:?}");
            let jet = formula.jet(&[Jet::variable(3.0)]);
            assert!(jet.value == value && jet.first.abs() < 1e-180 && jet.second.abs() < 1e-180, "{text}: {jet:?}");
        }
    }

    /// Every function: each derivative is the difference quotient (of fourth order) of the one before it.
    #[test]
    fn derivatives_are_those_of_differences() {
        let texts = [
            "sin(t) + 2*cos(3*t)",
            "tan(t/2)",
            "asin(t/3)*acos(t/4)",
            "atan(2*t)",
            "sinh(t)/cosh(t)",
            "tanh(t)^2",
            "asinh(t) - atanh(t/2)",
            "acosh(2+t)",
            "exp(-t^2)",
            "ln(1+t) + log2(2+t)*log10(3+t)",
            "sqrt(1+t^2)",
            "cbrt(2+t)",
            "abs(t)*t",
            "t^3 - 2*t^2.5",
            "(1+t)^t",
            "atan2(sin(t), 2+t)",
            "hypot(t, 1-t)",
            "(5*t) % 7",
            "max(t, 0.1) + min(t, 3)",
            "t if t > 0 else -t",
            "floor(t)*t + fract(t)",
            "1/(1+t)",
        ];
        for text in texts {
            let formula = Formula::parse(text, &["t"]).unwrap();
            for t in [0.31, 0.62, 0.87] {
                let (at, h) = (formula.derivatives(t), 1e-3);
                assert!((at[0] - formula.value(&[t])).abs() <= 1e-15 * at[0].abs().max(1.0), "{text}");
                for k in 0..4 {
                    let near = |by: f64| formula.derivatives(t + by * h)[k];
                    let by_difference = (8.0 * (near(1.0) - near(-1.0)) - near(2.0) + near(-2.0)) / (12.0 * h);
                    let size = at.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
                    // h⁴ times the fifth derivative further on, and round-off over h.
                    assert!((at[k + 1] - by_difference).abs() < 3e-8 * size, "{text} {t} {k}: {at:?} {by_difference}");
                }
            }
        }
    }
}
