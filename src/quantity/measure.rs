//! What a formula of quantities measures: powers of kg, m, s and rad that add up in products.
//!
//! A number without a unit is *plain*: alone or in a sum it stands for what its place asks for, in a product it is a pure
//! number. Scaling a quantity by plain numbers keeps its angle; where two quantities are multiplied a radian counts as 1, as
//! in SI, for a speed is a rate of turning times a radius:
//!
//! ```text
//! (rad/s) · m  =  m/s            N/m · m²  =  N m  or  N m/rad
//! ```

use super::Dimension;
use std::fmt;

/// What a number measures, as far as that is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Measure {
    /// Not known: a number without a unit, which fits everywhere.
    Plain,
    /// A product of powers.
    Of {
        /// Powers of kg, m and s.
        base: [f64; 3],
        /// The power of rad; `None` if radians count as 1.
        angle: Option<f64>,
    },
}

/// An angle (rad).
pub const ANGLE: Measure = Measure::Of { base: [0.0; 3], angle: Some(1.0) };

/// Powers of units are small fractions: none of them differ by less.
const SAME_POWER: f64 = 1e-9;

fn alike(a: f64, b: f64) -> bool {
    (a - b).abs() < SAME_POWER
}

impl From<Dimension> for Measure {
    fn from(Dimension(powers): Dimension) -> Self {
        let [kg, m, s, rad] = powers.map(f64::from);
        Self::Of { base: [kg, m, s], angle: Some(rad) }
    }
}

impl Measure {
    /// Whether a number that measures this can stand where that dimension is asked for.
    pub fn fits(self, dimension: Dimension) -> bool {
        self.together(dimension.into()).is_some()
    }

    /// Whether it is a pure number or an angle, or may be meant as one.
    pub fn is_pure(self) -> bool {
        match self {
            Self::Plain => true,
            Self::Of { base, .. } => base.iter().all(|power| alike(*power, 0.0)),
        }
    }

    /// What a sum of both measures; `None` if they do not add up.
    #[must_use]
    pub fn together(self, other: Self) -> Option<Self> {
        match (self, other) {
            (Self::Plain, known) | (known, Self::Plain) => Some(known),
            (Self::Of { base, angle }, Self::Of { base: second, angle: other }) => {
                let same = base.iter().zip(&second).all(|(a, b)| alike(*a, *b));
                let turns = angle.zip(other).is_none_or(|(a, b)| alike(a, b));
                (same && turns).then_some(Self::Of { base, angle: angle.or(other) })
            }
        }
    }

    /// What the product with the `exponent`-th power of another number measures; −1 for a quotient.
    #[must_use]
    pub fn times(self, other: Self, exponent: f64) -> Self {
        match (self, other) {
            (known, Self::Plain) => known,
            (Self::Plain, Self::Of { base, angle }) => {
                let kept = exponent.abs() == 1.0;
                let angle = angle.filter(|_| kept).map(|angle| angle * exponent);
                Self::Of { base: base.map(|power| power * exponent), angle }
            }
            (Self::Of { base, .. }, Self::Of { base: second, .. }) => {
                Self::Of { base: std::array::from_fn(|i| base[i] + exponent * second[i]), angle: None }
            }
        }
    }
}

/// As a unit: `kg m²/s²`.
impl fmt::Display for Measure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::Of { base: [kg, m, s], angle } = *self else { return f.write_str("1") };
        let powers = [("kg", kg), ("m", m), ("s", s), ("rad", angle.unwrap_or(0.0))];
        let part = |sign: f64| -> Vec<String> {
            let wanted = powers.iter().filter(|(_, power)| power * sign > SAME_POWER);
            wanted.map(|(symbol, power)| format!("{symbol}{}", raised(power * sign))).collect()
        };
        let (over, under) = (part(1.0), part(-1.0));
        f.write_str(&if over.is_empty() { "1".to_owned() } else { over.join(" ") })?;
        match &under[..] {
            [] => Ok(()),
            [one] => write!(f, "/{one}"),
            several => write!(f, "/({})", several.join(" ")),
        }
    }
}

/// A power as it is written behind a symbol.
fn raised(power: f64) -> String {
    match power {
        one if alike(one, 1.0) => String::new(),
        two if alike(two, 2.0) => "²".to_owned(),
        three if alike(three, 3.0) => "³".to_owned(),
        other => format!("^{}", (other * 1e6).round() / 1e6),
    }
}
