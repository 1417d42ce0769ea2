//! Random formulas as trees: written in several ways, and evaluated by recursion.

use crate::common::Random;

/// How a tree is written.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Style {
    /// Brackets around everything, and calls in place of words.
    Bracketed,
    /// As few brackets as Python's precedence allows; powers with `^`.
    Sparse,
    /// The same in Python's own words.
    Python,
}

pub(super) enum Tree {
    Number(f64),
    /// 0 to 2: t, q, v.
    Name(usize),
    Minus(Box<Tree>),
    Not(Box<Tree>),
    Binary(&'static str, Box<Tree>, Box<Tree>),
    /// `a op b op c`
    Chain(Box<Tree>, Vec<(&'static str, Tree)>),
    Call(&'static str, Vec<Tree>),
    /// Condition, then, else.
    Choice(Box<Tree>, Box<Tree>, Box<Tree>),
}

const SMOOTH: [&str; 17] = [
    "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "exp", "ln",
    "log10", "sqrt", "cbrt",
];
const JUMPY: [&str; 8] = ["abs", "sign", "floor", "ceil", "round", "trunc", "fract", "log2"];
const COMPARISONS: [&str; 6] = ["<", "<=", ">", ">=", "==", "!="];
// Python's levels of precedence.
const OR: usize = 1;
const AND: usize = 2;
const NOT: usize = 3;
const COMPARISON: usize = 4;
const SUM: usize = 5;
const PRODUCT: usize = 6;
const SIGN: usize = 7;
const POWER: usize = 8;
const ATOM: usize = 9;

fn pick<T: Copy>(random: &mut Random, list: &[T]) -> T {
    list[random.below(list.len())]
}

fn flag(condition: bool) -> f64 {
    f64::from(u8::from(condition))
}

impl Tree {
    /// With kinks: comparisons, choices and functions that jump, too.
    pub(super) fn random(random: &mut Random, depth: usize, kinks: bool) -> Self {
        if depth == 0 || random.below(8) == 0 {
            return match random.below(3) {
                0 => Self::Number(pick(random, &[0.0, 1.0, 2.0, 3.0, 0.5, 1e-3, 12.25])),
                _ => Self::Name(random.below(3)),
            };
        }
        let inner = |random: &mut Random| Box::new(Self::random(random, depth - 1, kinks));
        match random.below(if kinks { 13 } else { 7 }) {
            0 => Self::Minus(inner(random)),
            1 => Self::Binary("^", inner(random), Box::new(Self::Number(pick(random, &[0.0, 1.0, 2.0, 3.0, 0.5])))),
            2 => Self::Binary("^", inner(random), inner(random)),
            3 | 4 => Self::Binary(pick(random, &["+", "-", "*", "/"]), inner(random), inner(random)),
            5 => Self::Call(pick(random, &SMOOTH), vec![*inner(random)]),
            6 => Self::Call(pick(random, &["atan2", "hypot", "log"]), vec![*inner(random), *inner(random)]),
            7 => Self::Call(pick(random, &JUMPY), vec![*inner(random)]),
            8 => {
                let count = 2 + random.below(2);
                Self::Call(pick(random, &["min", "max"]), (0..count).map(|_| *inner(random)).collect())
            }
            9 => Self::Binary(pick(random, &["and", "or", "//", "%"]), inner(random), inner(random)),
            10 => Self::Not(inner(random)),
            11 => {
                let count = 1 + random.below(3);
                Self::Chain(inner(random), (0..count).map(|_| (pick(random, &COMPARISONS), *inner(random))).collect())
            }
            _ => Self::Choice(inner(random), inner(random), inner(random)),
        }
    }

    pub(super) fn text(&self, style: Style, outer: usize) -> String {
        let part = |tree: &Self, level: usize| match style {
            Style::Bracketed => format!("({})", tree.text(style, 0)),
            _ => tree.text(style, level),
        };
        let (text, level) = match self {
            Self::Number(x) => (format!("{x:?}"), ATOM),
            Self::Name(index) => (super::NAMES[*index].to_owned(), ATOM),
            Self::Minus(of) => (format!("-{}", part(of, SIGN)), SIGN),
            Self::Not(of) => (format!("not {}", part(of, NOT)), NOT),
            Self::Binary("^", a, b) => {
                let sign = if style == Style::Python { "**" } else { "^" };
                (format!("{}{sign}{}", part(a, ATOM), part(b, SIGN)), POWER)
            }
            Self::Binary(sign, a, b) => {
                let level = match *sign {
                    "or" => OR,
                    "and" => AND,
                    "+" | "-" => SUM,
                    _ => PRODUCT,
                };
                (format!("{} {sign} {}", part(a, level), part(b, level + 1)), level)
            }
            Self::Chain(first, others) => {
                let others = others.iter().map(|(sign, tree)| format!(" {sign} {}", part(tree, COMPARISON + 1)));
                (format!("{}{}", part(first, COMPARISON + 1), others.collect::<String>()), COMPARISON)
            }
            Self::Call(name, list) => {
                let list: Vec<String> = list.iter().map(|tree| tree.text(style, 0)).collect();
                (format!("{name}({})", list.join(", ")), ATOM)
            }
            Self::Choice(condition, yes, no) if style != Style::Python => {
                let [condition, yes, no] = [condition, yes, no].map(|tree| tree.text(style, 0));
                (format!("if({condition}, {yes}, {no})"), ATOM)
            }
            Self::Choice(condition, yes, no) => {
                (format!("{} if {} else {}", part(yes, OR), part(condition, OR), part(no, 0)), 0)
            }
        };
        if level < outer { format!("({text})") } else { text }
    }

    /// What is infinite in the end is no value.
    pub(super) fn value(&self, at: &[f64; 3]) -> f64 {
        let found = self.extended(at);
        if found.is_finite() { found } else { f64::NAN }
    }

    /// What is too large for a number is infinite, what is so at a pole is none.
    fn extended(&self, at: &[f64; 3]) -> f64 {
        match self {
            Self::Number(x) => *x,
            Self::Name(index) => at[*index],
            Self::Minus(of) => -of.extended(at),
            Self::Not(of) => defined(&[of.extended(at)], |x| flag(x[0] == 0.0)),
            Self::Binary("and", a, b) => {
                defined(&[a.extended(at)], |a| if a[0] == 0.0 { a[0] } else { b.extended(at) })
            }
            Self::Binary("or", a, b) => defined(&[a.extended(at)], |a| if a[0] == 0.0 { b.extended(at) } else { a[0] }),
            Self::Binary(sign, a, b) => {
                let [a, b] = [a, b].map(|tree| tree.extended(at));
                let is_pole = matches!(*sign, "/" | "//" | "%") && b == 0.0 || *sign == "^" && a == 0.0;
                defined(&[a, b], |x| but_at_pole(binary(sign, x[0], x[1]), is_pole))
            }
            Self::Chain(first, others) => {
                let values: Vec<f64> = std::iter::once(first.extended(at))
                    .chain(others.iter().map(|(_, tree)| tree.extended(at)))
                    .collect();
                for (i, (sign, _)) in others.iter().enumerate() {
                    let holds = defined(&values[i..i + 2], |x| flag(compare(sign, x[0], x[1])));
                    if holds != 1.0 {
                        return holds;
                    }
                }
                1.0
            }
            Self::Call(name, list) => {
                let list: Vec<f64> = list.iter().map(|tree| tree.extended(at)).collect();
                defined(&list, |list| match *name {
                    "min" => list[1..].iter().fold(list[0], |a, b| if *b < a { *b } else { a }),
                    "max" => list[1..].iter().fold(list[0], |a, b| if *b > a { *b } else { a }),
                    "atan2" => list[0].atan2(list[1]),
                    "hypot" => list[0].hypot(list[1]),
                    "log" => {
                        let [a, b] = [list[0], list[1]].map(|x| but_at_pole(x.ln(), x == 0.0));
                        defined(&[a, b], |x| but_at_pole(x[0] / x[1], b == 0.0))
                    }
                    name => {
                        let grows = matches!(name, "exp" | "sinh" | "cosh");
                        but_at_pole(call(name, list[0]), list[0].is_finite() && !grows)
                    }
                })
            }
            Self::Choice(condition, yes, no) => {
                defined(&[condition.extended(at)], |x| if x[0] == 0.0 { no } else { yes }.extended(at))
            }
        }
    }
}

/// What follows from numbers: none if one of them is none.
fn defined(arguments: &[f64], of: impl FnOnce(&[f64]) -> f64) -> f64 {
    if arguments.iter().any(|x| x.is_nan()) { f64::NAN } else { of(arguments) }
}

fn but_at_pole(x: f64, is_pole: bool) -> f64 {
    if x.is_infinite() && is_pole { f64::NAN } else { x }
}

fn compare(sign: &str, a: f64, b: f64) -> bool {
    match sign {
        "<" => a < b,
        "<=" => a <= b,
        ">" => a > b,
        ">=" => a >= b,
        "==" => a == b,
        _ => a != b,
    }
}

fn binary(sign: &str, a: f64, b: f64) -> f64 {
    match sign {
        "+" => a + b,
        "-" => a - b,
        "*" => a * b,
        "/" => a / b,
        "^" => a.powf(b),
        "%" => remainder(a, b),
        "//" if b == 0.0 => a / b,
        "//" => {
            // CPython's float_floor_div.
            let div = (a - remainder(a, b)) / b;
            if div - div.floor() > 0.5 { div.floor() + 1.0 } else { div.floor() }
        }
        other => unreachable!("{other}"),
    }
}

fn remainder(a: f64, b: f64) -> f64 {
    let rest = a % b;
    match rest == 0.0 {
        true => 0.0_f64.copysign(b),
        false if rest * b.signum() < 0.0 => rest + b,
        false => rest,
    }
}

fn call(name: &str, x: f64) -> f64 {
    match name {
        "sin" => x.sin(),
        "cos" => x.cos(),
        "tan" => x.tan(),
        "asin" => x.asin(),
        "acos" => x.acos(),
        "atan" => x.atan(),
        "sinh" => x.sinh(),
        "cosh" => x.cosh(),
        "tanh" => x.tanh(),
        "asinh" => x.asinh(),
        "acosh" => x.acosh(),
        "atanh" => x.atanh(),
        "exp" => x.exp(),
        "ln" => x.ln(),
        "log2" => x.log2(),
        "log10" => x.log10(),
        "sqrt" => x.sqrt(),
        "cbrt" => x.cbrt(),
        "abs" => x.abs(),
        "sign" if x == 0.0 => 0.0,
        "sign" => x.signum(),
        "floor" => x.floor(),
        "ceil" => x.ceil(),
        "round" => x.round_ties_even(),
        "trunc" => x.trunc(),
        "fract" => x - x.trunc(),
        other => unreachable!("{other}"),
    }
}
