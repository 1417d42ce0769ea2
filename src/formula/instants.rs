//! When a formula of time changes its rule, or does something for a short time only.
//!
//! A pulse that is shorter than a step is nothing to a method whose evaluations all lie beside it.
//!
//! **Switches.** Where a comparison, `abs` or `%` of the time alone changes its rule is found by halving stretches of time until
//! ranges ([`super::range`]) say that nothing changes within them, or until they are two numbers next to each other: none is missed,
//! however short what it begins.
//!
//! **Bursts.** What is smooth but short, as `exp(-((t-3)/1e-4)^2)`, is found in the same way: every part `f` of the formula that
//! is curved is divided into stretches of length `ℓ` over which it changes by little, and
//!
//! ```text
//! (4)  width f(stretch) / ℓ  >  rate (max f − min f) / T
//! ```
//!
//! is fast, with the [`RATES`]. Fast stretches next to each other, for less than [`SHORT`] of all the time `T`, are a burst.

use super::function::{Binary, Unary};
use super::range::{Range, Ranges};
use super::{Formula, Jet, Operation};

/// Operations on ranges in the search for switches, at most: half a second.
const MOST_OF_SWITCHES: usize = 8_000_000;
/// Operations in the search for bursts, and of its operations on derivatives.
const MOST_OF_BURSTS: usize = 10_000_000;
/// Switches that are told, at most: each of them ends a step.
const MOST_SWITCHES: usize = 10_000;
/// Bursts of one part that are told, at most.
const MOST_BURSTS: usize = 1_000;
/// Stretches that one part is divided into, at most.
const MOST_STRETCHES: usize = 65_536;
/// A stretch over which a part changes by less than this, of all that it does, is not divided.
const LITTLE: f64 = 0.04;
/// What would do all that it does in less than one part in so many of the time is fast: steps beside formulas are a hundredth of a run. The
/// second is for what is fast beside something that is nearly so itself.
const RATES: [f64; 2] = [40.0, 400.0];
/// What changes at this part of a rate that is fast belongs to it: waves are not fast at their flanks alone.
const AWAKE: f64 = 0.4;
/// What is fast for a longer part of the time than this is met by some step.
const SHORT: f64 = 0.02;
/// Stretches are not divided below this part of the time.
const FINEST: f64 = 1e-11;
/// No instant is nearer to the ends of the time than this part of it.
const BESIDE: f64 = 1e-12;
/// Into so many parts a burst is divided: a step that ends within it sees it.
const WITHIN: usize = 9;

/// How time is divided.
#[derive(Clone, Copy)]
struct Look {
    /// No stretch is longer than this part of the time.
    longest: f64,
    /// What changes within every stretch of this part of the time, over half of it, changes all the time.
    dense: f64,
}

/// With ranges, which say of a stretch of any length whether something is in it.
const RANGES: Look = Look { longest: 1.0, dense: 1.0 / 4096.0 };
/// With values at the ends of stretches, which say so of what stays different.
const VALUES: Look = Look { longest: 1.0 / 256.0, dense: 1.0 / 1024.0 };

/// A piece of time and what is between its ends.
#[derive(Clone, Copy)]
struct Piece {
    ends: [f64; 2],
    /// `None` where there is no value.
    range: Option<Range>,
}

impl Piece {
    fn length(&self) -> f64 {
        self.ends[1] - self.ends[0]
    }

    /// By how much it changes, at most.
    fn width(&self) -> f64 {
        self.range.map_or(0.0, Range::width)
    }
}

/// What is known of the result of a step before any number is.
#[derive(Clone, Copy, PartialEq)]
enum Follows {
    Nothing,
    /// From the one variable.
    Time,
    Others,
}

impl Formula {
    /// The times at which it begins to follow another rule, and those around what it does for a short time only, if `variable` is the
    /// time and goes from one to the other (s); in order. Of a formula that changes more often than can be told, the first ones.
    pub fn instants(&self, variable: usize, run: [f64; 2]) -> Vec<f64> {
        self.found(variable, run, false)
    }

    /// The instants of a formula in one variable alone, and those around a short time in which its derivative changes.
    pub fn instants_of_motion(&self, run: [f64; 2]) -> Vec<f64> {
        self.found(0, run, true)
    }

    fn found(&self, variable: usize, [begin, end]: [f64; 2], moves: bool) -> Vec<f64> {
        let all = end - begin;
        let run = [begin + BESIDE * all, end - BESIDE * all];
        if !self.uses(variable) || !(run[1] > run[0]) {
            return Vec::new();
        }
        let mut found = self.switches(variable, run);
        let mut begins = vec![run[0]];
        begins.extend(&found);
        let ends = found.iter().map(|time| time.next_down()).chain([run[1]]);
        let parts: Vec<[f64; 2]> =
            begins.iter().zip(ends).map(|(from, to)| [*from, to]).filter(|[from, to]| to > from).collect();
        let (mut ranges, mut done) = (Ranges::new(self, variable), 0);
        for steps in self.curved(variable) {
            let mut range = |between| {
                done += 1 + steps[1] - steps[0];
                (done <= MOST_OF_BURSTS).then(|| ranges.part(between, steps).range)
            };
            found.extend(bursts(&mut range, &parts, all, RANGES));
        }
        if moves {
            let speed = |time: f64| self.jet(&[Jet::variable(time)]).first;
            let mut range = |ends: [f64; 2]| {
                done += ends.len() * self.steps.len();
                (done <= MOST_OF_BURSTS).then(|| Range::between(ends.map(speed)))
            };
            found.extend(bursts(&mut range, &parts, all, VALUES));
        }
        found.retain(|time| *time > run[0] && *time < run[1]);
        found.sort_by(f64::total_cmp);
        found.dedup();
        found
    }

    /// The first numbers of all new rules.
    fn switches(&self, variable: usize, run: [f64; 2]) -> Vec<f64> {
        let (mut found, mut left, mut done) = (Vec::new(), vec![run], 0);
        let mut ranges = Ranges::new(self, variable);
        while let Some([from, to]) = left.pop() {
            done += self.steps.len();
            if done > MOST_OF_SWITCHES || found.len() == MOST_SWITCHES {
                break;
            }
            if !ranges.whole([from, to]).switches {
                continue;
            }
            let middle = from + 0.5 * (to - from);
            if middle > from && middle < to {
                left.extend([[middle, to], [from, middle]]);
            } else if self.rules(variable, from) != self.rules(variable, to) {
                found.push(to);
            }
        }
        found
    }

    /// The parts that follow from a variable alone and are curved: the first and the last step of each.
    fn curved(&self, variable: usize) -> Vec<[usize; 2]> {
        let (mut registers, mut curved) = (vec![(Follows::Nothing, 0); self.registers], Vec::new());
        for (index, step) in self.steps.iter().enumerate() {
            let join = |of: &[(Follows, usize)]| {
                let has = |follows| of.iter().any(|(one, _)| *one == follows);
                let first = of.iter().map(|(_, first)| *first).min().unwrap_or(index);
                match (has(Follows::Others), has(Follows::Time)) {
                    (true, _) => (Follows::Others, first),
                    (false, true) => (Follows::Time, first),
                    (false, false) => (Follows::Nothing, first),
                }
            };
            let (to, bends) = match step.operation {
                Operation::Constant(_) => ((Follows::Nothing, index), false),
                Operation::Variable(at) if at == variable => ((Follows::Time, index), false),
                Operation::Variable(_) => ((Follows::Others, index), false),
                Operation::Copy(from) => (registers[from], false),
                Operation::Unary(function, of) => (join(&[registers[of]]), function.bends()),
                Operation::Binary(function, a, b) => {
                    let moves = [a, b].map(|of| registers[of].0 == Follows::Time);
                    (join(&[registers[a], registers[b]]), function.bends(moves))
                }
                Operation::Select(condition, yes, no) => {
                    (join(&[registers[condition], registers[yes], registers[no]]), false)
                }
            };
            registers[step.to] = to;
            if bends && to.0 == Follows::Time {
                curved.push([to.1, index]);
            }
        }
        curved
    }
}

impl Unary {
    /// Whether it is no straight line, apart from where it changes its rule.
    pub(super) fn bends(self) -> bool {
        match self {
            Self::Minus
            | Self::Not
            | Self::Abs
            | Self::Sign
            | Self::Floor
            | Self::Ceil
            | Self::Round
            | Self::Trunc
            | Self::Fract => false,
            Self::Sin
            | Self::Cos
            | Self::Tan
            | Self::Asin
            | Self::Acos
            | Self::Atan
            | Self::Sinh
            | Self::Cosh
            | Self::Tanh
            | Self::Asinh
            | Self::Acosh
            | Self::Atanh
            | Self::Exp
            | Self::Ln
            | Self::Log2
            | Self::Log10
            | Self::Sqrt
            | Self::Cbrt => true,
        }
    }
}

impl Binary {
    /// Whether it is no straight line in the arguments that change, apart from where it changes its rule.
    fn bends(self, changes: [bool; 2]) -> bool {
        match self {
            Self::Power | Self::Atan2 | Self::Hypot => true,
            Self::Multiply => changes == [true; 2],
            Self::Divide => changes[1],
            _ => false,
        }
    }
}

/// The times around all that a part of a formula does for a short time only, with how it ranges between two times; none if that is not
/// known, or changes all the time.
fn bursts(range: &mut dyn FnMut([f64; 2]) -> Option<Range>, parts: &[[f64; 2]], all: f64, look: Look) -> Vec<f64> {
    let Some((pieces, size)) = divide(range, parts, all, look) else { return Vec::new() };
    let mut found: Vec<[usize; 2]> = Vec::new();
    for rate in RATES {
        let within = |run: &[usize; 2]| found.iter().any(|other| other[0] <= run[0] && run[1] <= other[1]);
        let new: Vec<_> = runs(&pieces, rate * size / all, all).into_iter().filter(|run| !within(run)).collect();
        found.extend(new);
    }
    if found.len() > MOST_BURSTS {
        return Vec::new();
    }
    let around = |[first, last]: &[usize; 2]| {
        let ([from, to], first, count) = ([pieces[*first].ends[0], pieces[*last].ends[1]], *first, last + 1 - first);
        // As many pieces between one and the next: closer where more is changing.
        let within = (1..WITHIN).map(|k| pieces[first + k * count / WITHIN].ends[0]);
        // Its faint ends.
        within.chain([2.0 * from - to, from, to, 2.0 * to - from]).collect::<Vec<f64>>()
    };
    found.iter().flat_map(around).collect()
}

/// The first and the last piece of every short run of pieces that change at some rate (1/s), if all that do at a part of it are awake.
fn runs(pieces: &[Piece], rate: f64, all: f64) -> Vec<[usize; 2]> {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    let ends = |[first, last]: [usize; 2]| [pieces[first].ends[0], pieces[last].ends[1]];
    let length = |run: [usize; 2]| ends(run)[1] - ends(run)[0];
    let changes = |index: usize, rate: f64| pieces[index].width() > rate * pieces[index].length();
    for index in (0..pieces.len()).filter(|index| changes(*index, AWAKE * rate)) {
        runs.push([index; 2]);
        // What rests for a shorter time than it is awake before or after is awake.
        while let [.., before, after] = runs[..] {
            let rest = ends(after)[0] - ends(before)[1];
            if rest >= length(before).max(length(after)) {
                break;
            }
            runs.truncate(runs.len() - 2);
            runs.push([before[0], after[1]]);
        }
    }
    // Equation 4.
    runs.retain(|run| length(*run) < SHORT * all && (run[0]..=run[1]).any(|index| changes(index, rate)));
    runs
}

/// Divides time until a part of a formula changes by little within every piece: the pieces in order, and by how much it changes in all.
fn divide(
    range: &mut dyn FnMut([f64; 2]) -> Option<Range>,
    parts: &[[f64; 2]],
    all: f64,
    look: Look,
) -> Option<(Vec<Piece>, f64)> {
    let mut piece = |ends: [f64; 2]| {
        let found = range(ends)?;
        Some(Piece { ends, range: (!found.is_nothing()).then_some(found) })
    };
    let mut pieces = parts.iter().map(|ends| piece(*ends)).collect::<Option<Vec<Piece>>>()?;
    loop {
        let bounded = pieces.iter().filter_map(|piece| piece.range).filter(|range| range.width().is_finite());
        let hull = bounded
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], range| [low.min(range.low), high.max(range.high)]);
        let size = (hull[1] - hull[0]).max(0.0);
        let wide = |piece: &Piece| {
            let changes = !(piece.width() <= LITTLE * size) && piece.length() > FINEST * all;
            changes || piece.length() > look.longest * all
        };
        let count = pieces.iter().filter(|piece| wide(piece)).count();
        if count == 0 || pieces.len() + count > MOST_STRETCHES {
            return Some((pieces, size));
        }
        let dense = pieces.iter().filter(|piece| wide(piece) && piece.length() <= look.dense * all);
        if dense.map(Piece::length).sum::<f64>() > 0.5 * all {
            return None;
        }
        let mut divided = Vec::with_capacity(pieces.len() + count);
        for one in &pieces {
            let [from, to] = one.ends;
            let middle = from + 0.5 * (to - from);
            match wide(one) && middle > from && middle < to {
                true => divided.extend([piece([from, middle])?, piece([middle, to])?]),
                false => divided.push(*one),
            }
        }
        if divided.len() == pieces.len() {
            return Some((pieces, size));
        }
        pieces = divided;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn instants(text: &str, run: [f64; 2]) -> Vec<f64> {
        Formula::parse(text, &["t", "q", "v"]).unwrap().instants(0, run)
    }

    fn of_motion(text: &str, run: [f64; 2]) -> Vec<f64> {
        Formula::parse(text, &["t"]).unwrap().instants_of_motion(run)
    }

    /// The first numbers at which a formula follows another rule, wherever that is in a run.
    #[test]
    fn switches_are_found_to_the_last_digit() {
        let next = f64::next_up;
        let table = [
            ("10*(3 <= t < 3.001)", vec![3.0, 3.001]),
            ("if(t > 3, q, v)", vec![next(3.0)]),
            ("min(t, 1)*q", vec![next(1.0)]),
            ("-5*v + abs(t-2)", vec![2.0]),
            ("floor(t/4) + q", vec![4.0, 8.0]),
            ("sign(t-5)", vec![5.0, next(5.0)]),
            ("(t == 7)*q", vec![7.0, next(7.0)]),
            ("q*(t//3 > 1 and t%3 < 1)", vec![1.0, 3.0, 4.0, 6.0, 7.0, 9.0]),
            ("max(q, 2) + abs(v) + min(t, q)", vec![]),
            ("q^2 + 3*t", vec![]),
            ("q > 1", vec![]),
        ];
        for (text, expected) in table {
            assert_eq!(instants(text, [0.0, 10.0]), expected, "{text}");
        }
        assert_eq!(instants("t > 1e3", [0.0, 1e4]), [next(1e3)]);
        assert!(instants("t > 1e3", [0.0, 1e3]).is_empty() && instants("t >= 2", [2.0, 3.0]).is_empty());
    }

    /// Beginnings and ends of boxes of any width are found, and the values on both sides are those of their rules.
    #[test]
    fn no_box_is_too_short() {
        for k in 0..60 {
            let width = 10.0_f64.powf(-0.2 * f64::from(k));
            let middle = 2.0 + 0.1 * f64::from(k);
            let text = format!("if(abs(t-{middle:?})<{:?}, 3, q)", 0.5 * width);
            let formula = Formula::parse(&text, &["t", "q"]).unwrap();
            let found = formula.instants(0, [0.0, 10.0]);
            let value = |time: f64| formula.value(&[time, 0.0]);
            let jumps: Vec<f64> = found.into_iter().filter(|time| value(*time) != value(time.next_down())).collect();
            let [begin, end] = jumps[..] else { panic!("{text}: {jumps:?}") };
            assert!((end - begin - width).abs() < 1e-14 && (begin + 0.5 * width - middle).abs() < 1e-14, "{text}");
        }
    }

    /// Between two switches nothing switches, in formulas of random parts.
    #[test]
    fn rules_hold_from_one_switch_to_the_next() {
        let parts = [
            "t",
            "t-5",
            "sin(3*t)",
            "t%1.7",
            "abs(t-4)",
            "floor(2*t)",
            "max(t, 3)",
            "(t > 6)",
            "t^2/9",
            "exp(-t)",
            "round(t)",
            "fract(0.7*t)",
            "cos(t)",
            "t//-0.9",
            "(2 < t <= 8)",
            "(-3.1)",
            "sqrt(t)",
            "q",
        ];
        let joins = ["+", "-", "*", "<", ">=", "and", "or", "%", "//", "/", "if t < 7 else"];
        let mut seed = 7_u64;
        let mut pick = |count: usize| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as usize % count
        };
        for _ in 0..40 {
            let mut text = parts[pick(parts.len())].to_owned();
            for _ in 0..1 + pick(4) {
                text = format!("({text} {} {})", joins[pick(joins.len())], parts[pick(parts.len())]);
                text = ["", "", "abs", "sign", "trunc"][pick(5)].to_owned() + &text;
            }
            let formula = Formula::parse(&text, &["t", "q"]).unwrap();
            let switches = formula.switches(0, [0.001, 9.999]);
            for pair in switches.windows(2).filter(|_| switches.len() < MOST_SWITCHES) {
                let [from, to] = [pair[0], pair[1].next_down()];
                let rules = formula.rules(0, from);
                let mut within = (0..=20).map(|k| (from + (to - from) * f64::from(k) / 20.0).min(to));
                assert!(within.all(|time| formula.rules(0, time) == rules), "{text} between {from} and {to}");
            }
        }
    }

    /// Whether some of the instants are before, some within and some after `middle ± width`.
    fn surround(found: &[f64], middle: f64, width: f64) -> bool {
        let has = |from: f64, to: f64| found.iter().any(|time| *time > from && *time < to);
        has(middle - 300.0 * width, middle - 2.2 * width)
            && has(middle - 2.2 * width, middle)
            && has(middle, middle + 2.2 * width)
            && has(middle + 2.2 * width, middle + 300.0 * width)
    }

    /// Smooth pulses of all kinds and widths, alone and beside what is large and slow.
    #[test]
    fn bursts_are_surrounded() {
        for k in 0..16 {
            let width = 10.0_f64.powf(-2.5 - 0.4 * f64::from(k));
            let x = format!("((t-3.3)/{width:?})");
            for text in [
                format!("exp(-{x}^2)"),
                format!("1000*sin(t) + exp(-{x}^2)"),
                format!("q*exp(-{x}*{x}) - 5*v"),
                format!("exp(-min({x}^2, 700)) + 1e3*t^2"),
                format!("1e5*cos(3*t)/(1+{x}^4)"),
                format!("1/cosh(max(-300, min(300, {x})))"),
                format!("tanh({x}+1) - tanh({x}-1)"),
            ] {
                let found = instants(&text, [0.0, 10.0]);
                assert!(surround(&found, 3.3, width), "{text}: {found:?}");
                assert!(found.len() < 60, "{text}: {}", found.len());
            }
        }
        let train = instants("1000*exp(-((fract(t)-0.5)/0.001)^2)", [0.0, 10.0]);
        assert!((0..10).all(|k| surround(&train, 0.5 + f64::from(k), 0.001)), "{train:?}");
    }

    /// A motion whose velocity changes in a short time bends there.
    #[test]
    fn rounded_corners_of_motions_are_surrounded() {
        for width in [1e-2, 1e-4, 1e-6] {
            for text in [format!("sqrt((t-3.3)^2 + {width:?}^2)"), format!("(t-3.3)*atan((t-3.3)/{width:?})")] {
                let found = of_motion(&text, [0.0, 10.0]);
                assert!(surround(&found, 3.3, width), "{text}: {found:?}");
            }
        }
    }

    /// What goes on all the time has no instants, and neither has what is slow.
    #[test]
    fn what_never_rests_is_let_be() {
        for text in [
            "sin(1e4*t)",
            "sin(2*pi*t)",
            "cos(40*t)*exp(-t)",
            "t^5 - 3*t^4 + t",
            "exp(-t)",
            "sin(1e3*t)^2",
            "1/(1+t)",
            "asin(0.1*sin(10*t)) + 0.2*t^2",
            "sin(97*t)",
        ] {
            assert!(instants(text, [0.0, 10.0]).is_empty(), "{text}: {:?}", instants(text, [0.0, 10.0]));
            assert!(of_motion(text, [0.0, 10.0]).is_empty(), "{text} as a motion");
        }
    }

    /// Of more switches than can be told the first ones are.
    #[test]
    fn the_search_is_bounded() {
        let found = instants("sin(1e5*t) > 0", [0.0, 10.0]);
        assert!(found.len() == MOST_SWITCHES && found.windows(2).all(|pair| pair[0] < pair[1]), "{}", found.len());
        for text in [
            "abs(sin(t)^2 + cos(t)^2 - 1)",
            "tan(1e6*t) + 1/sin(1e5*t)",
            "sqrt(t-t*t)",
            "atan2(sin(1e6*t), cos(1e6*t))",
        ] {
            let count = instants(text, [0.0, 10.0]).len();
            assert!(count <= 2 * MOST_SWITCHES, "{text}: {count}");
        }
    }
}
