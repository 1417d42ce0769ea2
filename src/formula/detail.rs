//! Over how short a way of one variable something in a formula can come and go: steps that are no longer meet all of it.
//!
//! ```text
//! (4)  |g'| ≤ s  ⇒  what f(g) does takes a way of 1/s:   f = sin, cos, tanh, exp, …
//! (5)  a polynomial, and what switches with a straight argument, has no way of its own
//! ```
//!
//! What has poles or edges of its own (a quotient, a root, a logarithm), and what switches with a bent argument, may do so over any way.

use super::function::{Binary, Unary};
use super::{Formula, Operation};

/// How a value depends on the variable.
#[derive(Debug, Clone, Copy)]
struct Detail {
    /// A bound on its slope within a piece; infinite if none is known.
    slope: f64,
    /// Its value where that is known and does not depend on anything.
    constant: Option<f64>,
    /// The shortest way over which it can come and go.
    way: f64,
}

impl Detail {
    const OTHER: Self = Self { slope: 0.0, constant: None, way: f64::INFINITY };

    fn constant(value: f64) -> Self {
        Self { constant: Some(value), ..Self::OTHER }
    }

    fn depends(&self) -> bool {
        self.slope != 0.0 || self.way.is_finite()
    }

    /// With a slope, and what switches or bends over a way of its own.
    fn with(self, slope: f64, way: f64) -> Self {
        Self { slope, constant: None, way: self.way.min(way) }
    }

    /// The way of a switch with this argument.
    fn switch(&self) -> f64 {
        if self.slope.is_finite() { f64::INFINITY } else { 0.0 }
    }

    /// Its slope times the size of a factor that does not depend on the variable.
    fn times(&self, factor: Option<f64>) -> f64 {
        match (self.slope, factor) {
            (0.0, _) => 0.0,
            (slope, Some(factor)) => slope * factor.abs(),
            (_, None) => f64::INFINITY,
        }
    }

    fn unary(self, function: Unary) -> Self {
        if let Some(value) = self.constant {
            return Self::constant(function.of_number(value));
        }
        if !self.depends() {
            return self;
        }
        match function {
            Unary::Minus => self,
            Unary::Abs | Unary::Fract => self.with(self.slope, self.switch()),
            Unary::Not | Unary::Sign | Unary::Floor | Unary::Ceil | Unary::Round | Unary::Trunc => {
                self.with(0.0, self.switch())
            }
            // Of slopes up to one.
            Unary::Sin | Unary::Cos | Unary::Atan | Unary::Tanh | Unary::Asinh => {
                self.with(self.slope, self.slope.recip())
            }
            Unary::Exp | Unary::Sinh | Unary::Cosh => self.with(f64::INFINITY, self.slope.recip()),
            Unary::Tan | Unary::Asin | Unary::Acos | Unary::Acosh | Unary::Atanh => self.with(f64::INFINITY, 0.0),
            Unary::Ln | Unary::Log2 | Unary::Log10 | Unary::Sqrt | Unary::Cbrt => self.with(f64::INFINITY, 0.0),
        }
    }

    fn binary(function: Binary, a: Self, b: Self) -> Self {
        if let (Some(x), Some(y)) = (a.constant, b.constant) {
            return Self::constant(function.value(x, y));
        }
        let both = Self { slope: a.slope + b.slope, constant: None, way: a.way.min(b.way) };
        let steepest = a.slope.max(b.slope);
        match function {
            _ if !a.depends() && !b.depends() => Self::OTHER,
            Binary::Add | Binary::Subtract => both,
            Binary::Multiply if !b.depends() => both.with(a.times(b.constant), f64::INFINITY),
            Binary::Multiply if !a.depends() => both.with(b.times(a.constant), f64::INFINITY),
            Binary::Multiply => both.with(f64::INFINITY, f64::INFINITY),
            Binary::Divide if !b.depends() => both.with(a.times(b.constant.map(f64::recip)), f64::INFINITY),
            Binary::FloorDivide if !b.depends() => both.with(0.0, a.switch()),
            Binary::Remainder if !b.depends() => both.with(a.slope, a.switch()),
            // A power of what comes and goes does so over a shorter way.
            Binary::Power if b.constant.is_some_and(|n| n >= 0.0 && n.fract() == 0.0) => {
                both.with(f64::INFINITY, a.way / b.constant.unwrap_or(1.0).max(1.0))
            }
            Binary::Divide | Binary::FloorDivide | Binary::Remainder | Binary::Power => both.with(f64::INFINITY, 0.0),
            Binary::Atan2 | Binary::Hypot => both.with(f64::INFINITY, 0.0),
            Binary::Min | Binary::Max | Binary::And | Binary::Or => both.with(steepest, both.switch()),
            Binary::Less | Binary::LessOrEqual | Binary::Greater | Binary::GreaterOrEqual => {
                both.with(0.0, both.switch())
            }
            Binary::Equal | Binary::NotEqual => both.with(0.0, both.switch()),
        }
    }
}

impl Formula {
    /// The shortest way of a variable over which something in the formula can come and go: infinite where nothing can but what ends
    /// pieces ([`super::Pieces`]), zero where it may be any.
    pub fn detail(&self, variable: usize) -> f64 {
        let mut registers = vec![Detail::OTHER; self.registers.max(1)];
        for step in &self.steps {
            registers[step.to] = match step.operation {
                Operation::Constant(value) => Detail::constant(value),
                Operation::Variable(index) if index == variable => Detail { slope: 1.0, ..Detail::OTHER },
                Operation::Variable(_) => Detail::OTHER,
                Operation::Copy(from) => registers[from],
                Operation::Unary(function, of) => registers[of].unary(function),
                Operation::Binary(function, a, b) => Detail::binary(function, registers[a], registers[b]),
                Operation::Select(condition, yes, no) => {
                    let [condition, yes, no] = [condition, yes, no].map(|of| registers[of]);
                    let slope = yes.slope.max(no.slope);
                    Detail { slope, constant: None, way: condition.way.min(yes.way).min(no.way) }
                }
            };
        }
        registers[0].way
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_are_those_of_the_functions_in_a_formula() {
        let of = |text: &str| Formula::parse(text, &["t", "q", "v"]).expect("a formula").detail(1);
        let any = f64::INFINITY;
        for (text, way) in [
            ("-3*q + 2*v", any),
            ("1500 if q > 5000 else 500", any),
            ("-(1500 if q > 5000 else 500) - 3*v*v + 60000/max(v, 1)", any),
            ("min(3*q, 2) - abs(q - 1)", any),
            ("q**3 - 2*q", any),
            ("floor(q/0.1)", any),
            ("q % 0.3", any),
            ("5*cos(q/2000)", 2000.0),
            ("tanh(q/0.01) + sin(3*q)", 0.01),
            ("tanh(sin(q))", 1.0),
            ("sin(q)**100", 0.01),
            ("exp(-2*q)", 0.5),
            ("sin(v*q)", 0.0),
            ("exp(-((q - 3)/0.01)**2)", 0.0),
            ("1/(1 + q*q)", 0.0),
            ("sqrt(q)", 0.0),
            ("1 if (q - 3)*(q - 4) < 0 else 0", 0.0),
            ("sign(sin(q/0.1))", 0.1),
            ("sin(t)", any),
        ] {
            let found = of(text);
            assert!(found == way || (found - way).abs() < 1e-12 * way, "{text}: {found}, {way}");
        }
    }
}
