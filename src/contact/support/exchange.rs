//! Rims: any of their points may press, of which programs know some at a time.
//!
//! ```text
//! (1)  u_n(φ) ≥ μ |u_t(φ)|   at every angle φ of the arcs,   u(φ) = u_0 + u_1 cos φ + u_2 sin φ
//! ```
//!
//! is what (D) asks of a motion: a program with as many cones as a rim has points. Those at which the motion of a program with
//! some of them goes against (1) the most are added, and the program is solved again, until there are none (exchange method:
//! Hettich, Kortanek, "Semi-infinite programming", SIAM Review 35, 1993).

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
    /// Angles whose points are supports already (rad).
    pub known: Vec<f64>,
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

    /// Angles at which a motion (velocity coordinates) goes against (1) and further than beside them.
    fn against(&self, motion: &[f64], part: f64) -> Vec<f64> {
        let rate = |column: &Column| column.iter().map(|(row, entry)| entry * motion[*row]).sum::<f64>();
        let rates = self.columns.each_ref().map(|set| set.each_ref().map(rate));
        let margin = |angle: f64| self.margin(&rates, part, angle);
        let largest = rates.iter().flatten().fold(1.0_f64, |most, rate| most.max(rate.abs()));
        let missed = self.known.iter().map(|angle| -margin(*angle)).fold(0.0, f64::max);
        let allowed = ALLOWED * largest + SOLVED * missed;
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

    /// Adds the points of rims at which a motion (velocity coordinates) goes against (1) with a part of all friction; whether there are
    /// any.
    pub(super) fn exchange(&mut self, motion: &[f64], part: f64) -> bool {
        let before = self.added.len();
        for at in 0..self.rims.len() {
            for angle in self.rims[at].against(motion, part) {
                let apart = |known: &f64| (known - angle).sin().abs() > ONE || (known - angle).cos() < 0.0;
                if self.rims[at].known.iter().all(apart) {
                    self.add_point(at, angle);
                }
            }
        }
        self.added.len() > before
    }

    fn add_point(&mut self, at: usize, angle: f64) {
        let rim = &mut self.rims[at];
        rim.known.push(angle);
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
