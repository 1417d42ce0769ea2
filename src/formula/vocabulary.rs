//! The names that formulas know beside their variables.

use super::function::{Binary, Unary};
use std::f64::consts::{E, PI, TAU};

/// What a name in front of a bracket stands for.
#[derive(Debug, Clone, Copy)]
pub(super) enum Function {
    One(Unary),
    Two(Binary),
    /// Of two or more arguments, two by two from the left.
    Several(Binary),
    /// `log(x)` or `log(x, base)`.
    Log,
    /// `if(c, a, b)`
    If,
    /// One argument times a constant.
    Scale(f64),
}

pub(super) const FUNCTIONS: [(&str, Function); 35] = [
    ("abs", Function::One(Unary::Abs)),
    ("min", Function::Several(Binary::Min)),
    ("max", Function::Several(Binary::Max)),
    ("if", Function::If),
    ("sin", Function::One(Unary::Sin)),
    ("cos", Function::One(Unary::Cos)),
    ("tan", Function::One(Unary::Tan)),
    ("asin", Function::One(Unary::Asin)),
    ("acos", Function::One(Unary::Acos)),
    ("atan", Function::One(Unary::Atan)),
    ("atan2", Function::Two(Binary::Atan2)),
    ("sinh", Function::One(Unary::Sinh)),
    ("cosh", Function::One(Unary::Cosh)),
    ("tanh", Function::One(Unary::Tanh)),
    ("asinh", Function::One(Unary::Asinh)),
    ("acosh", Function::One(Unary::Acosh)),
    ("atanh", Function::One(Unary::Atanh)),
    ("exp", Function::One(Unary::Exp)),
    ("ln", Function::One(Unary::Ln)),
    ("log", Function::Log),
    ("log2", Function::One(Unary::Log2)),
    ("log10", Function::One(Unary::Log10)),
    ("sqrt", Function::One(Unary::Sqrt)),
    ("cbrt", Function::One(Unary::Cbrt)),
    ("pow", Function::Two(Binary::Power)),
    ("hypot", Function::Two(Binary::Hypot)),
    ("sign", Function::One(Unary::Sign)),
    ("signum", Function::One(Unary::Sign)),
    ("floor", Function::One(Unary::Floor)),
    ("ceil", Function::One(Unary::Ceil)),
    ("round", Function::One(Unary::Round)),
    ("trunc", Function::One(Unary::Trunc)),
    ("fract", Function::One(Unary::Fract)),
    ("radians", Function::Scale(PI / 180.0)),
    ("degrees", Function::Scale(180.0 / PI)),
];

pub(super) const CONSTANTS: [(&str, f64); 12] = [
    ("pi", PI),
    ("PI", PI),
    ("π", PI),
    ("tau", TAU),
    ("TAU", TAU),
    ("τ", TAU),
    ("e", E),
    ("E", E),
    ("true", 1.0),
    ("True", 1.0),
    ("false", 0.0),
    ("False", 0.0),
];

/// What formulas know besides the variables, for people: constants and functions.
pub fn vocabulary() -> String {
    let functions: Vec<String> = FUNCTIONS.iter().map(|(name, _)| format!("`{name}`")).collect();
    format!("the constants `pi`, `tau`, `e`, and the functions {}", functions.join(", "))
}
