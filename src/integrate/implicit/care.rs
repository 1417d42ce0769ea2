//! When every correction takes a tangent of its own.
//!
//! One tangent serves a step where the residuals of all rows are of one kind. Before a body that is 10⁸ times heavier than the links
//! that carry it, the residual of its balance is 10⁸ times what moves a link: a tangent of a place that is turned by 10⁻⁵ takes a part
//! of it for the link's, and corrections lead the link astray. Steps would have to be as short as the link's turn, `√(I/M)`, whatever
//! moves. A step that one tangent does not carry to its end is tried again with a tangent at the place of each correction before it is
//! shortened, and so are the steps after it: what made it necessary is still there.
//!
//! **Worth**: where something fast happens steps are short whatever the tangents, and care is a waste. What the run gains in time for
//! its work is measured with care and without. If care gains less it pauses, twice as long whenever that happens again; if it gains far
//! less it ends early.

use crate::integrate::{problem::ImplicitProblem, step::statistics::Statistics};

/// Steps that are taken with care after one that needed it. A step without costs an attempt that fails, with care a factorization
/// for each correction, of which there are some ten.
const STEPS: u32 = 16;
/// Steps without care after it gained less than those before, the first time and at most.
const PAUSES: [u32; 2] = [16, 4096];
/// After so many steps with care it ends if it gained less than this part of what steps without it did.
const EARLY: (u32, f64) = (4, 0.5);
/// What a factorization costs, in corrections.
const FACTORIZATION: u64 = 3;

/// Whether care is taken, for how long, and what it has been worth.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Care {
    /// The problem asks for it where steps could be shortened instead.
    asked: bool,
    /// Steps with it, the step now tried among them.
    steps: u32,
    /// Steps to be made before it is taken again, and how many they are the next time.
    pause: u32,
    next_pause: u32,
    without: Gain,
    with: Gain,
    /// The work of the run that is booked in these.
    booked: u64,
}

/// How far steps went (s), and what that cost (corrections), rejected attempts included.
#[derive(Debug, Clone, Copy, Default)]
struct Gain {
    time: f64,
    work: f64,
}

impl Gain {
    /// Whether this part of the time of another was gained for the same work, or more.
    fn reaches(&self, part: f64, other: &Self) -> bool {
        self.time * other.work >= part * other.time * self.work
    }
}

impl Care {
    /// None yet.
    pub(crate) fn of<P: ImplicitProblem>(problem: &P) -> Self {
        let (without, with) = (Gain::default(), Gain::default());
        let [next_pause, _] = PAUSES;
        Self { asked: problem.asks_for_care(), steps: 0, pause: 0, next_pause, without, with, booked: 0 }
    }

    /// Whether every correction takes a tangent.
    pub(crate) fn is_taken(&self) -> bool {
        self.steps > 0
    }

    /// Takes care from the step now tried on, whose Newton iteration has failed; false if that was done already.
    pub(crate) fn take(&mut self, statistics: &Statistics) -> bool {
        let is_new = self.steps == 0;
        if is_new {
            self.book(0.0, statistics);
            self.with = Gain::default();
            self.steps = if self.asked { STEPS } else { 1 };
        }
        is_new
    }

    /// As [`Care::take`], for problems that ask for care and gain by it; false for all others, whose step is shortened instead.
    pub(crate) fn take_if_asked(&mut self, statistics: &Statistics) -> bool {
        self.asked && self.pause == 0 && self.take(statistics)
    }

    /// A step of this length (s) is accepted.
    pub(crate) fn advance(&mut self, step: f64, statistics: &Statistics) {
        self.book(step, statistics);
        match self.steps {
            0 => self.pause = self.pause.saturating_sub(1),
            1 => self.judge(),
            more => {
                self.steps = more - 1;
                let (after, part) = EARLY;
                if self.asked && STEPS - self.steps >= after && !self.with.reaches(part, &self.without) {
                    self.judge();
                }
            }
        }
    }

    /// What was done since the last time, in steps that led so far (s).
    fn book(&mut self, time: f64, statistics: &Statistics) {
        let work = statistics.newton_iterations + FACTORIZATION * statistics.jacobian_evaluations;
        let to = if self.is_taken() { &mut self.with } else { &mut self.without };
        to.time += time;
        to.work += (work - self.booked) as f64;
        self.booked = work;
    }

    /// Steps with care have ended: whether it is taken again where one fails, or after a while.
    fn judge(&mut self) {
        let [first, longest] = PAUSES;
        self.steps = 0;
        if self.with.reaches(1.0, &self.without) {
            self.next_pause = (self.next_pause / 2).max(first);
        } else {
            self.pause = self.next_pause;
            self.next_pause = (2 * self.next_pause).min(longest);
        }
        // What was long ago counts less.
        self.without = Gain { time: 0.5 * self.without.time, work: 0.5 * self.without.work };
    }
}
