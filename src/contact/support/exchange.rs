//! Rims: any of their points may press, of which programs know some at a time.
//!
//! ```text
//! (1)  u_n(φ) ≥ μ |u_t(φ)|   at every angle φ of the arcs,   u(φ) = u_0 + u_1 cos φ + u_2 sin φ
//! ```
//!
//! is what (D) asks of a motion: a program with as many cones as a rim has points. Those at which the motion of a program with
//! some of them goes against (1) the most are added, and the program is solved again, until there are none (exchange method:
//! Hettich, Kortanek, "Semi-infinite programming", SIAM Review 35, 1993). Between two neighbours that press, the middle of their
//! pressure is added with them: it is off the rim by the square of their distance only, where the motion, of which a rim that tips
//! leaves many, halves that distance.

use super::{Cone, Supports};
use std::f64::consts::TAU;

type Column = Vec<(usize, f64)>;

/// A rim that presses as Coulomb says, or without friction.
#[derive(Debug, Clone)]
pub struct RimSupport {
    /// 0 if there is none.
    pub friction: f64,
    /// Columns of the normal and of both tangents: at the middle, and what a point at angle 0 and one a quarter of a turn further
    /// add to them.
    pub columns: [[Column; 3]; 3],
    /// From an angle to a larger one (rad).
    pub arcs: Vec<[f64; 2]>,
    /// Angles whose points are supports already (rad), and which ones these are.
    pub known: Vec<(f64, usize)>,
}

/// What a motion of a program may go against (1), in parts of its largest rate: the answer is that much too small at most, in parts of the
/// loads...
const ALLOWED: f64 = 1e-10;
/// ... or so many times what it goes against it at points that the program has, which is how well it is solved.
const SOLVED: f64 = 4.0;
/// Points of a turn at which (1) is looked at first.
const PARTS: usize = 48;
/// Points that are nearer to each other are one (rad): between them (1) is missed by a part of its square.
const ONE: f64 = 1e-6;
/// What bears less than this part of what its rim bears does not press.
const PRESSES: f64 = 1e-6;
/// Exchanges of one question.
pub(super) const MOST_EXCHANGES: usize = 60;

impl RimSupport {
    /// `u_n − μ |u_t|` at an angle, of the rates of all columns, with a part of its friction.
    fn margin(&self, rates: &[[f64; 3]; 3], part: f64, angle: f64) -> f64 {
        let (sin, cos) = angle.sin_cos();
        let [n, t, s] = [0, 1, 2].map(|k| rates[0][k] + rates[1][k] * cos + rates[2][k] * sin);
        let friction = self.friction * part;
        // What cannot slide at several points of a rim does at none.
        if friction > 0.0 && friction.is_finite() { n - friction * t.hypot(s) } else { n }
    }

    /// Angles at which a motion (velocity coordinates) goes against (1) and further than beside them, by more than `enough` of what pushes
    /// there grows by.
    fn against(&self, motion: &[f64], part: f64, enough: f64) -> Vec<f64> {
        let rate = |column: &Column| column.iter().map(|(row, entry)| entry * motion[*row]).sum::<f64>();
        let rates = self.columns.each_ref().map(|set| set.each_ref().map(rate));
        let margin = |angle: f64| self.margin(&rates, part, angle);
        let largest = rates.iter().flatten().fold(1.0_f64, |most, rate| most.max(rate.abs()));
        let missed = self.known.iter().map(|(angle, _)| -margin(*angle)).fold(0.0, f64::max);
        let friction = Some(self.friction * part).filter(|friction| *friction > 0.0 && friction.is_finite());
        let allowed = (ALLOWED * largest + SOLVED * missed).max(enough * friction.unwrap_or(1.0));
        let mut found = Vec::new();
        for [from, to] in &self.arcs {
            let parts = ((to - from) / TAU * PARTS as f64).ceil().max(2.0);
            let step = (to - from) / parts;
            let whole = *to >= from + TAU;
            // Before the first and after the last point of an arc there is none.
            let at = |k: f64| if whole || (0.0..=parts).contains(&k) { margin(from + k * step) } else { f64::INFINITY };
            for k in (0..=parts as usize).map(|k| k as f64) {
                if at(k) <= at(k - 1.0) && at(k) <= at(k + 1.0) {
                    let ends = if whole { [f64::NEG_INFINITY, f64::INFINITY] } else { [*from, *to] };
                    let [low, high] = [k - 1.0, k + 1.0].map(|k| (from + k * step).clamp(ends[0], ends[1]));
                    let angle = lowest(&margin, low, high);
                    if margin(angle) < -allowed {
                        found.push(angle);
                    }
                }
            }
        }
        found
    }

    /// Middles of pressure of neighbours, of the normal force of every support.
    fn middles(&self, pressure: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut known: Vec<(f64, f64)> =
            self.known.iter().map(|(angle, support)| (angle.rem_euclid(TAU), pressure(*support))).collect();
        known.sort_by(|a, b| a.0.total_cmp(&b.0));
        let least = PRESSES * known.iter().fold(0.0, |most: f64, (_, force)| most.max(*force));
        let next = |i: usize| match known.get(i + 1) {
            Some(next) => *next,
            None => (known[0].0 + TAU, known[0].1),
        };
        let pairs = (0..known.len()).map(|i| (known[i], next(i)));
        let middles = pairs.filter(|((_, low), (_, high))| *low > least && *high > least);
        let middles = middles.map(|((from, low), (to, high))| from + (to - from) * high / (low + high));
        middles.filter(|angle| self.has(*angle)).collect()
    }

    /// Whether an angle is on one of the arcs.
    fn has(&self, angle: f64) -> bool {
        self.arcs.iter().any(|[from, to]| (angle - from).rem_euclid(TAU) <= to - from)
    }
}

/// Where a function with one minimum between two places has it (golden section), or at one of them.
fn lowest(f: &impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let ends = [low, high];
    while high - low > 0.01 * ONE {
        let (a, b) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
        if f(a) <= f(b) { high = b } else { low = a }
    }
    [ends[0], ends[1]].into_iter().fold(0.5 * (low + high), |best, end| if f(end) < f(best) { end } else { best })
}

impl Supports {
    /// Adds a rim whose `known` points are supports.
    pub fn add_rim(&mut self, rim: RimSupport) {
        self.rims.push(rim);
    }

    /// Points of rims that were added: which rim, and the angle (rad); their supports are the last ones, in this order.
    pub fn added(&self) -> &[(usize, f64)] {
        &self.added
    }

    /// Whether a support is a point of a rim of which three others are known: what slides at none of these slides nowhere on the rim,
    /// each part of `u_t(φ)` in (1) having two roots at most unless it is zero.
    pub(super) fn follows(&self, support: usize) -> bool {
        let Some(place) = (support + self.added.len()).checked_sub(self.len()) else { return false };
        let rim = self.added[place].0;
        let from_here = self.added[place..].iter().filter(|(of, _)| *of == rim).count();
        self.rims[rim].known.len() >= 3 + from_here
    }

    /// Adds the points of rims at which a motion (velocity coordinates) goes against (1) with a part of all friction, by more than
    /// `enough`, and the middles of pressure of forces there; whether there are any.
    pub(super) fn exchange(&mut self, motion: &[f64], forces: &[f64], part: f64, enough: f64) -> bool {
        let before = self.added.len();
        for at in 0..self.rims.len() {
            let mut angles = self.rims[at].against(motion, part, enough);
            if angles.is_empty() {
                continue;
            }
            angles.extend(self.rims[at].middles(|support| forces[self.starts[support]]));
            for angle in angles {
                let apart =
                    |(known, _): &(f64, usize)| (known - angle).sin().abs() > ONE || (known - angle).cos() < 0.0;
                if self.rims[at].known.iter().all(apart) {
                    self.add_point(at, angle);
                }
            }
        }
        self.added.len() > before
    }

    fn add_point(&mut self, at: usize, angle: f64) {
        let support = self.len();
        let rim = &mut self.rims[at];
        rim.known.push((angle, support));
        let (sin, cos) = angle.sin_cos();
        let column = |k: usize| -> Column {
            let part = |set: usize, by: f64| rim.columns[set][k].iter().map(move |(row, entry)| (*row, by * entry));
            let mut sum: Column = Vec::new();
            for (row, entry) in part(0, 1.0).chain(part(1, cos)).chain(part(2, sin)) {
                match sum.iter_mut().find(|(known, _)| *known == row) {
                    Some((_, sum)) => *sum += entry,
                    None => sum.push((row, entry)),
                }
            }
            sum
        };
        let friction = rim.friction;
        let (cone, columns) = match friction > 0.0 {
            true => (Cone::Coulomb { friction }, (0..3).map(column).collect()),
            false => (Cone::Ray, vec![column(0)]),
        };
        let columns: Vec<Column> = columns;
        self.added.push((at, angle));
        self.add(cone, 1.0, columns);
    }
}
