//! Numbers with units: `45 deg`, `300 mm`, `5 N/mm`, `2 N m/rad`, `60 rpm`.
//!
//! A unit is a product of the symbols of [`mod@unit`], each with an SI prefix and a power: `kg m^2`, `kg m²`, `N·s/m`, `1/s`,
//! `N m/(rad s)`. After a `/` stands one symbol, or several in brackets: `N/m s` could be read in two ways and is refused.
//!
//! Angles have a dimension of their own here: `2 N m` is a torque and no stiffness of a hinge, which is `2 N m/rad`.
//!
//! ```
//! let spring = stillpoint::quantity::Quantity::parse("5 N/mm")?;
//! assert_eq!(spring.value, 5000.0);
//! assert!(spring.dimension == stillpoint::quantity::Dimension::of("N/m")?);
//! # Ok::<(), stillpoint::quantity::QuantityError>(())
//! ```

pub mod measure;
pub mod unit;

use crate::suggest::closest;
use std::fmt;
use std::ops::Range;

/// Powers of kg, m, s and rad.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Hash)]
pub struct Dimension([i8; 4]);

/// A number with its unit, in SI units and radians.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantity {
    /// In SI units and radians.
    pub value: f64,
    /// What it measures.
    pub dimension: Dimension,
    /// Where its unit begins (in bytes); the end of the text if it has none.
    pub unit_start: usize,
}

/// Why a text is no quantity.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct QuantityError {
    /// Where in the text (in bytes).
    pub span: Range<usize>,
    /// What is wrong there.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
}

/// Powers of kg, m, s and rad, and what has them.
const NAMES: [([i8; 4], &str); 20] = [
    ([1, 0, 0, 0], "a mass"),
    ([0, 1, 0, 0], "a length"),
    ([0, 0, 1, 0], "a time"),
    ([0, 0, 0, 1], "an angle"),
    ([0, 2, 0, 0], "an area"),
    ([0, 3, 0, 0], "a volume"),
    ([1, -3, 0, 0], "a density"),
    ([1, 2, 0, 0], "a moment of inertia"),
    ([0, 0, -1, 0], "a frequency"),
    ([0, 1, -1, 0], "a speed"),
    ([0, 1, -2, 0], "an acceleration"),
    ([0, 0, -1, 1], "an angular speed"),
    ([1, 1, -2, 0], "a force"),
    ([1, 2, -2, 0], "a torque or an energy"),
    ([1, -1, -2, 0], "a pressure"),
    ([1, 2, -3, 0], "a power"),
    ([1, 0, -2, 0], "the stiffness of a spring"),
    ([1, 0, -1, 0], "the damping of a spring"),
    ([1, 2, -2, -1], "the stiffness of a hinge"),
    ([1, 2, -1, -1], "the damping of a hinge"),
];

/// The largest power of a symbol.
const LARGEST_POWER: i8 = 9;

impl QuantityError {
    fn new(span: Range<usize>, message: impl Into<String>) -> Self {
        Self { span, message: message.into(), help: None }
    }

    fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

impl fmt::Display for QuantityError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.help {
            Some(help) => write!(f, "{} ({help})", self.message),
            None => f.write_str(&self.message),
        }
    }
}

impl std::error::Error for QuantityError {}

impl Dimension {
    /// That of a unit.
    ///
    /// # Errors
    /// If the text is no unit.
    pub fn of(unit: &str) -> Result<Self, QuantityError> {
        let mut reader = Reader { text: unit, at: 0 };
        let found = reader.product()?;
        reader.end()?;
        Ok(found.dimension)
    }

    /// What 1 of a unit is in SI units and radians; 1 of a text that is no unit.
    pub fn size_of(unit: &str) -> f64 {
        Quantity::parse(&format!("1 {unit}")).map_or(1.0, |one| one.value)
    }

    fn times(self, other: Self, power: i8) -> Self {
        Self(std::array::from_fn(|i| self.0[i].saturating_add(other.0[i].saturating_mul(power))))
    }

    /// The power of each base unit, by its symbol.
    pub fn powers(self) -> [(&'static str, i8); 4] {
        let [mass, length, time, angle] = self.0;
        [("kg", mass), ("m", length), ("s", time), ("rad", angle)]
    }

    /// What has it, with its article; `None` if that has no common name.
    pub fn name(self) -> Option<&'static str> {
        let named = NAMES.iter().find(|(powers, _)| *powers == self.0);
        named.map(|(_, name)| *name)
    }

    /// Whether it is that of pure numbers.
    pub fn is_none(self) -> bool {
        self == Self::default()
    }
}

impl Quantity {
    /// Whether a text can be meant as a quantity: it begins like a number.
    pub fn is_meant(text: &str) -> bool {
        let unsigned = text.trim_start().trim_start_matches(['+', '-', '−']).trim_start();
        unsigned.starts_with(|c: char| c.is_ascii_digit() || c == '.')
    }

    /// Reads a number and its unit.
    ///
    /// # Errors
    /// What is wrong and where: no number, an unknown symbol, a unit that can be read in two ways.
    pub fn parse(text: &str) -> Result<Self, QuantityError> {
        let mut reader = Reader { text, at: 0 };
        let number = reader.number()?;
        reader.blank();
        let unit_start = reader.at;
        if reader.rest().is_empty() {
            return Ok(Self { value: number, dimension: Dimension::default(), unit_start });
        }
        let unit = reader.product()?;
        reader.end()?;
        let value = match unit.divided {
            true => number / unit.factor,
            false => number * unit.factor,
        };
        if !value.is_finite() {
            return Err(QuantityError::new(0..text.len(), format!("`{text}` is not a finite number")));
        }
        Ok(Self { value, dimension: unit.dimension, unit_start })
    }
}

/// A unit: its factor to SI units, or the number that it divides by; which of both is exact is kept.
#[derive(Debug, Clone, Copy)]
struct Unit {
    factor: f64,
    divided: bool,
    dimension: Dimension,
}

impl Unit {
    const ONE: Self = Self { factor: 1.0, divided: false, dimension: Dimension([0; 4]) };

    /// Times the power of a symbol. Factors below one are kept as what they divide by: a thousandth is not a number in
    /// binary, a thousand is.
    fn times(self, symbol: &Self, power: i8) -> Self {
        let dimension = self.dimension.times(symbol.dimension, power);
        let divided = symbol.divided != (power < 0);
        let factor = symbol.factor.powi(i32::from(power.unsigned_abs()));
        let (factor, divided) = match self.divided == divided {
            true => (self.factor * factor, divided),
            false if self.factor >= factor => (self.factor / factor, self.divided),
            false => (factor / self.factor, divided),
        };
        Self { factor, divided, dimension }
    }
}

struct Reader<'t> {
    text: &'t str,
    at: usize,
}

impl<'t> Reader<'t> {
    fn rest(&self) -> &'t str {
        &self.text[self.at..]
    }

    fn blank(&mut self) {
        self.at = self.text.len() - self.rest().trim_start().len();
    }

    fn take(&mut self, signs: &[char]) -> bool {
        match self.rest().chars().next().filter(|next| signs.contains(next)) {
            Some(next) => self.at += next.len_utf8(),
            None => return false,
        }
        true
    }

    fn end(&mut self) -> Result<(), QuantityError> {
        self.blank();
        match self.rest().chars().next() {
            None => Ok(()),
            Some(')') => Err(QuantityError::new(self.at..self.at + 1, "this bracket was never opened")),
            Some(next) => {
                let span = self.at..self.at + next.len_utf8();
                Err(QuantityError::new(span, format!("`{}` is no part of a unit", next.escape_debug())))
            }
        }
    }

    fn number(&mut self) -> Result<f64, QuantityError> {
        self.blank();
        let negative = self.rest().starts_with(['-', '−']);
        self.take(&['-', '−', '+']);
        self.blank();
        let rest = self.rest();
        let digits = |from: usize| {
            rest[from..].find(|c: char| !c.is_ascii_digit() && c != '_').map_or(rest.len(), |length| from + length)
        };
        let mut end = digits(0);
        if rest[end..].starts_with('.') {
            end = digits(end + 1);
        }
        if let Some(exponent) = rest[end..].strip_prefix(['e', 'E']) {
            let sign = usize::from(exponent.starts_with(['+', '-']));
            if exponent[sign..].starts_with(|c: char| c.is_ascii_digit()) {
                end = digits(end + 1 + sign);
            }
        }
        let written = &rest[..end];
        let span = self.at..self.at + end.max(1).min(rest.len().max(1));
        self.at += end;
        match written.replace('_', "").parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(if negative { -number } else { number }),
            Ok(_) => {
                let error = QuantityError::new(span, "this number is larger than any that can be computed with");
                Err(error.help("the largest is 1.8e308"))
            }
            _ => {
                let error = QuantityError::new(span, "a quantity begins with a number");
                Err(error.help("for example `\"45 deg\"`"))
            }
        }
    }

    /// Factors, until the end or a closing bracket.
    fn product(&mut self) -> Result<Unit, QuantityError> {
        let mut unit = Unit::ONE;
        let (mut slash, mut divides) = (None, false);
        loop {
            let factor = self.factor()?;
            if let Some(slash) = slash.filter(|_| !divides) {
                let error = QuantityError::new(slash..self.at, "this unit can be read in two ways");
                return Err(error.help("after a `/` stands one symbol, or several in brackets: `N m/(rad s)`"));
            }
            unit = unit.times(&factor, if divides { -1 } else { 1 });
            self.blank();
            if self.rest().is_empty() || self.rest().starts_with(')') {
                return Ok(unit);
            }
            divides = self.rest().starts_with('/');
            if divides {
                slash = Some(self.at);
            }
            self.take(&['/', '*', '·', '×']);
        }
    }

    /// A symbol with its power, `1`, or a product in brackets.
    fn factor(&mut self) -> Result<Unit, QuantityError> {
        self.blank();
        let start = self.at;
        if self.take(&['(']) {
            let inner = self.product()?;
            if !self.take(&[')']) {
                return Err(QuantityError::new(start..start + 1, "this bracket is never closed"));
            }
            let power = self.power()?;
            return Ok(Unit::ONE.times(&inner, power));
        }
        if self.rest().starts_with('1') && !self.rest()[1..].starts_with(|c: char| c.is_ascii_digit() || c == '.') {
            self.at += 1;
            return Ok(Unit::ONE);
        }
        let length = self.rest().find(|c: char| !c.is_alphabetic() && c != '°').unwrap_or(self.rest().len());
        let symbol = &self.rest()[..length];
        if symbol.is_empty() {
            let next = self.rest().chars().next();
            let span = start..start + next.map_or(0, char::len_utf8);
            let found = next.map_or("the text ends".to_owned(), |next| format!("`{}` stands", next.escape_debug()));
            return Err(QuantityError::new(span, format!("{found} where a unit should")));
        }
        self.at += length;
        let Some((factor, divided, powers)) = unit::symbol(symbol) else { return Err(unknown(symbol, start)) };
        let power = self.power()?;
        Ok(Unit::ONE.times(&Unit { factor, divided, dimension: Dimension(powers) }, power))
    }

    /// `^2`, `**-1`, `²`, `⁻¹`; 1 without one.
    fn power(&mut self) -> Result<i8, QuantityError> {
        const RAISED: [(char, char); 11] = [
            ('⁻', '-'),
            ('⁰', '0'),
            ('¹', '1'),
            ('²', '2'),
            ('³', '3'),
            ('⁴', '4'),
            ('⁵', '5'),
            ('⁶', '6'),
            ('⁷', '7'),
            ('⁸', '8'),
            ('⁹', '9'),
        ];
        let start = self.at;
        let plain = self.rest().starts_with('^') || self.rest().starts_with("**");
        if plain {
            self.at += if self.rest().starts_with('^') { 1 } else { 2 };
        }
        let mut digits = String::new();
        for next in self.rest().chars() {
            let digit = match plain {
                true => Some(next).filter(|next| next.is_ascii_digit() || *next == '-' && digits.is_empty()),
                false => RAISED.into_iter().find(|(raised, _)| *raised == next).map(|(_, digit)| digit),
            };
            let Some(digit) = digit else { break };
            digits.push(digit);
            self.at += next.len_utf8();
        }
        if !plain && digits.is_empty() {
            return Ok(1);
        }
        match digits.parse::<i8>() {
            Ok(power) if power != 0 && power.abs() <= LARGEST_POWER => Ok(power),
            _ => {
                let message = format!("a power is a whole number from -{LARGEST_POWER} to {LARGEST_POWER}, not 0");
                Err(QuantityError::new(start..self.at.max(start + 1).min(self.text.len()), message))
            }
        }
    }
}

fn unknown(symbol: &str, start: usize) -> QuantityError {
    let known: Vec<&str> = unit::SYMBOLS.iter().map(|(symbol, ..)| *symbol).collect();
    let help = match closest(symbol, known.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("known are {}, with SI prefixes", known.join(", ")),
    };
    QuantityError::new(start..start + symbol.len(), format!("unknown unit `{symbol}`")).help(help)
}
