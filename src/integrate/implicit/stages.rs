//! The coupled stages of a collocation method, solved with one sweep of the tangent per stage and iteration.
//!
//! The stage equations `X_i = x + h Σ_j a_ij k_j` couple all stages. With a lower triangular `L` of equal diagonal entries `γ`
//! (see `splitting.rs`) they are iterated in the form
//!
//! ```text
//! (1)  X_i = x + h Σ_{j<i} l_ij k_j + h γ k_i + h Σ_j (a_ij − l_ij) k_j°,     k° from the iteration before,
//! ```
//!
//! of which every row, taken in order, is the equation of a diagonally implicit stage with `g = h γ` (see
//! `implicit/stage.rs`). It is not solved but corrected once: a residual and a solve with the tangent
//! `K = c₂ ∂r/∂a + c₁ ∂r/∂v + ∂r/∂q`, `c₁ = 1/g`, `c₂ = 1/g²`. The shift is real and the same for all stages, so one O(n) sweep
//! factorizes for all of them: no complex arithmetic, no matrix of `s n` unknowns, and of a long chain one tangent stays
//! in the cache where one for each stage would not.
//!
//! **Prediction**: the rates of past stages as a polynomial in time, continued (`history.rs`). That is a long way to the last
//! stages, so in the first sweep each stage that is corrected takes part in predicting those after it, which then lie
//! close: where rates are smooth, errors that the second sweep meets are ten to a hundred times smaller for it, two or three sweeps'
//! worth. What is left of (1) in that sweep is `X_i = x + h Σ_j a_ij k_j`: old rates of stages before `i` are no use.
//!
//! **The tangent** is that of the middle stage as first predicted (one at either end of the step takes up to a fifth more
//! sweeps). It is kept while it serves, and where it costs half a sweep more than a new one would it is renewed at once:
//! that takes a third of one or less. If it did not even serve the step after its own, sixteen steps renew it without trying.
//!
//! A step that may not be shortened, or whose problem asks for care (see `care.rs`), and that one tangent does not carry to its end, is
//! tried again with a tangent at each stage in each sweep.
//!
//! **Stiff systems**: a step that is still slow after some sweeps goes on with the other `L` of `splitting.rs`, and so do the
//! next 64. The tangent stays: both have the same `γ`.
//!
//! **Stopping**: by the largest change of a stage in an iteration (see `contraction.rs`).

use crate::integrate::{
    implicit::care::Care,
    implicit::collocation::Collocation,
    implicit::contraction::{Accuracy, Iteration},
    implicit::history::History,
    implicit::splitting::Splitting,
    implicit::stage::{NO_CORRECTION, Stage, correct, place},
    implicit::tangent::{Shift, TangentCache},
    problem::{ImplicitProblem, Point},
    step::error::Limit,
    step::norm::{ErrorNorm, largest_difference},
    step::rates::{combine, require_finite},
    step::stages::StepStages,
    step::statistics::Statistics,
};

/// With the poorest contraction, six digits are gained in 33.
const MAX_ITERATIONS: u32 = 40;
/// An old tangent is renewed where that saves so many sweeps.
const WORTH: f64 = 0.5;
/// The splitting for stiff systems is taken where so many iterations end with a contraction poorer than this,
const SLOW: (u32, f64) = (7, 0.2);
/// for so many steps.
const STIFF: u32 = 64;
/// Steps that renew a tangent without trying after one that did not even serve the step after its own.
const RENEWALS: u32 = 16;

/// How the stages of a method are solved.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Solution {
    pub(crate) splitting: Splitting,
    pub(crate) accuracy: Accuracy,
    /// Past steps whose rates are kept to predict from.
    pub(crate) steps: usize,
    /// Rates that a prediction is made from, those of this step included.
    pub(crate) most: usize,
}

/// The stages of the step tried and of those before.
#[derive(Debug)]
pub(crate) struct Stages {
    pub(crate) method: Collocation,
    /// `γ`.
    pub(crate) diagonal: f64,
    /// The weights of (1) for `rates`: of `k`, then of `k − k°`; for what steps resolve and for stiff systems.
    rows: [Vec<Vec<f64>>; 2],
    /// Which of the two, and how many steps more.
    stiff: Option<u32>,
    /// `k_1 … k_s`, each `(N(q) v, a)`, then their changes in this iteration.
    pub(crate) rates: Vec<Vec<f64>>,
    /// `X_1 … X_s`.
    pub(crate) states: Vec<Vec<f64>>,
    history: History,
    /// The known part of a stage.
    known: Vec<f64>,
    /// A stage as the iteration before left it.
    before: Vec<f64>,
    /// Inverse weights of the norm in this step.
    weights: Vec<f64>,
    /// Residual, then correction; in velocity coordinates.
    correction: Vec<f64>,
    acceleration: Vec<f64>,
    accuracy: Accuracy,
    /// What the iteration of the last step left, in tolerances.
    pub(crate) left: f64,
    tangent: TangentCache,
    /// The best contraction with a new tangent.
    best: f64,
    /// Steps that are to renew it unasked.
    renewals: u32,
    care: Care,
}

/// Which sweep over the stages it is.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Pass {
    First,
    /// What is old of a stage is that of the pass before.
    Later,
}

impl Stages {
    /// Room for a problem whose rate at the start is `rate`.
    pub(crate) fn new<P: ImplicitProblem>(problem: &mut P, method: Collocation, how: Solution, rate: &[f64]) -> Self {
        let s = method.stages();
        problem.reserve();
        let acceleration = vec![0.0; problem.velocity_count()];
        let state = vec![0.0; rate.len()];
        let Solution { splitting, accuracy, steps, most } = how;
        let row = |i: usize, below: &[f64]| {
            let a = &method.rows[i];
            let mut row = a.clone();
            row[i] -= splitting.diagonal;
            row.extend(below.iter().zip(a).map(|(l, a)| l - a));
            row
        };
        let rows = |below: &[&[f64]]| below.iter().enumerate().map(|(i, below)| row(i, below)).collect();
        Self {
            rows: [rows(splitting.smooth), rows(splitting.stiff)],
            stiff: None,
            diagonal: splitting.diagonal,
            rates: vec![state.clone(); 2 * s],
            states: vec![state.clone(); s],
            history: History::new(rate, steps * s, most),
            known: state.clone(),
            before: state.clone(),
            weights: state,
            correction: acceleration.clone(),
            acceleration,
            accuracy,
            left: 0.0,
            tangent: TangentCache::default(),
            best: 1.0,
            renewals: 0,
            care: Care::of(problem),
            method,
        }
    }

    /// Solves the stages of a step from `start` at `time`.
    ///
    /// # Errors
    /// [`Limit::Newton`] where the iteration diverges or is too slow; where the system cannot be evaluated.
    pub(crate) fn solve<P: ImplicitProblem>(
        &mut self,
        problem: &mut P,
        norm: &ErrorNorm,
        (time, start): (f64, &[f64]),
        step: f64,
        statistics: &mut Statistics,
    ) -> Result<(), Limit> {
        let s = self.method.stages();
        self.predict_after(0, step);
        self.prepare(problem, (time, start), step, statistics)?;
        for i in 0..s {
            self.correct(problem, (time, start), step, (i, Pass::First), statistics)?;
            self.predict_after(i + 1, step);
        }
        // The rows of that sweep met predictions that improved on the way: its corrections say nothing of what those were
        // wrong by.
        let end = &self.states[s - 1];
        norm.inverse_weights(start, end, &mut self.weights);
        let rounding = NO_CORRECTION * norm.rounding(end);
        let mut iteration = Iteration::new(self.accuracy, MAX_ITERATIONS).patient(s as u32, SLOW.0);
        loop {
            let mut size = 0.0_f64;
            for i in 0..s {
                self.correct(problem, (time, start), step, (i, Pass::Later), statistics)?;
                size = size.max(largest_difference(&self.states[i], &self.before, &self.weights));
            }
            let done = iteration.converged(size, rounding)?;
            if self.stiff.is_none() && iteration.is_slow(SLOW) {
                self.stiff = Some(STIFF);
            }
            if !self.care.is_taken() && !self.serves(&iteration) && !done {
                let stage = s / 2;
                self.before.copy_from_slice(&self.states[stage]);
                self.renew(problem, (time, stage), step, statistics)?;
                // A stage that an old tangent led astray may have made it a poor one.
                self.tangent.doubt();
            }
            if done {
                self.left = iteration.leaves(size);
                return require_finite(&self.states[s - 1], problem.position_count());
            }
        }
    }

    /// The step is accepted: its rates are those to predict from, its tangent is old.
    pub(crate) fn advance(&mut self, step: f64, statistics: &Statistics) {
        let s = self.method.stages();
        self.history.advance(step, &self.method.nodes, &mut self.rates[..s]);
        self.stiff = self.stiff.and_then(|steps| steps.checked_sub(1));
        self.care.advance(step, statistics);
        self.tangent.advance();
    }

    /// The stages as last solved, the states `position_count` coordinates and their velocities.
    pub(crate) fn of_step(&self, position_count: usize) -> StepStages<'_> {
        let Collocation { nodes, weights, nested, .. } = &self.method;
        StepStages { nodes, states: &self.states, weights, nested, position_count }
    }

    /// Gives up the tangent where it is old, or takes more of them if the problem asks for that; false if neither would help.
    pub(crate) fn discard_old(&mut self, statistics: &Statistics) -> bool {
        self.tangent.discard_old() || self.care.take_if_asked(statistics)
    }

    /// Tries the step again with a tangent for each correction; false if that was tried.
    pub(crate) fn take_care(&mut self, statistics: &Statistics) -> bool {
        self.care.take(statistics)
    }

    /// The rates of all stages but the first `found`, from the past and from those.
    fn predict_after(&mut self, found: usize, step: f64) {
        let nodes = &self.method.nodes;
        let (corrected, open) = self.rates[..nodes.len()].split_at_mut(found);
        for (to, node) in open.iter_mut().zip(&nodes[found..]) {
            self.history.predict((step, &nodes[..found], corrected), node * step, to);
        }
    }

    /// Makes sure of a tangent that serves this step: a new one, at the predicted middle stage, where the last does not.
    fn prepare<P: ImplicitProblem>(
        &mut self,
        problem: &mut P,
        (time, start): (f64, &[f64]),
        step: f64,
        statistics: &mut Statistics,
    ) -> Result<(), Limit> {
        // What this very step is tried again with is as good as new.
        if self.tangent.serves(step) && (self.tangent.is_fresh() || self.renewals == 0) {
            return Ok(());
        }
        self.best = 1.0;
        self.renewals = self.renewals.saturating_sub(1);
        let middle = self.method.stages() / 2;
        self.renew_at(problem, (time, start), step, (middle, Pass::First), statistics)
    }

    /// A new tangent where a stage is as its row says.
    fn renew_at<P: ImplicitProblem>(
        &mut self,
        problem: &mut P,
        (time, start): (f64, &[f64]),
        step: f64,
        (i, pass): (usize, Pass),
        statistics: &mut Statistics,
    ) -> Result<(), Limit> {
        let row = weights(&self.rows, self.stiff, (i, pass));
        combine(&mut self.known, start, step, row, &self.rates);
        let stage = Stage { time, step: step * self.diagonal, known: &self.known, start };
        place(problem, stage, &self.rates[i][problem.position_count()..], &mut self.before);
        self.renew(problem, (time, i), step, statistics)
    }

    /// A new tangent, at a stage whose state is in `before`.
    fn renew<P: ImplicitProblem>(
        &mut self,
        problem: &mut P,
        (time, stage): (f64, usize),
        step: f64,
        statistics: &mut Statistics,
    ) -> Result<(), Limit> {
        let position_count = problem.position_count();
        let (q, v) = self.before.split_at(position_count);
        let a = &self.rates[stage][position_count..];
        let c1 = 1.0 / (step * self.diagonal);
        let at = Point { time: time + self.method.nodes[stage] * step, q, v, a };
        self.tangent.renew(problem, at, Shift { step, c1, c2: c1 * c1 }, statistics)
    }

    /// Takes note of how well the tangent serves; false if a new one would do better.
    fn serves(&mut self, iteration: &Iteration) -> bool {
        let Some(contraction) = iteration.contraction() else { return true };
        if self.tangent.is_fresh() {
            self.best = self.best.min(contraction);
            return true;
        }
        let serves = iteration.left(contraction) - iteration.left(self.best) < WORTH;
        if !serves && self.tangent.served_none() {
            self.renewals = RENEWALS;
        }
        serves
    }

    /// Row `i` of (1), corrected once; where the stage was is left in `before`.
    fn correct<P: ImplicitProblem>(
        &mut self,
        problem: &mut P,
        (time, start): (f64, &[f64]),
        step: f64,
        (i, pass): (usize, Pass),
        statistics: &mut Statistics,
    ) -> Result<(), Limit> {
        let (s, position_count) = (self.method.stages(), problem.position_count());
        if self.care.is_taken() {
            self.renew_at(problem, (time, start), step, (i, pass), statistics)?;
        }
        combine(&mut self.known, start, step, weights(&self.rows, self.stiff, (i, pass)), &self.rates);
        let g = step * self.diagonal;
        let stage = Stage { time: time + self.method.nodes[i] * step, step: g, known: &self.known, start };
        std::mem::swap(&mut self.before, &mut self.states[i]);
        let state = &mut self.states[i];
        let (rates, changes) = self.rates.split_at_mut(s);
        let (rate, change) = (&mut rates[i], &mut changes[i]);
        self.acceleration.copy_from_slice(&rate[position_count..]);
        place(problem, stage, &self.acceleration, state);
        correct(problem, stage.time, state, &self.acceleration, &mut self.correction, statistics)?;
        statistics.newton_iterations += 1;
        let Shift { c2, .. } = self.tangent.shift()?;
        self.acceleration.iter_mut().zip(&self.correction).for_each(|(a, correction)| *a -= c2 * correction);
        place(problem, stage, &self.acceleration, state);

        // k and k − k°.
        std::mem::swap(rate, change);
        let (q, v) = state.split_at(position_count);
        let (position_rate, acceleration) = rate.split_at_mut(position_count);
        problem.position_rate(q, v, position_rate);
        acceleration.copy_from_slice(&self.acceleration);
        change.iter_mut().zip(rate).for_each(|(change, now)| *change = *now - *change);
        Ok(())
    }
}

/// The weights of row `i` of (1) in a sweep.
fn weights(rows: &[Vec<Vec<f64>>; 2], stiff: Option<u32>, (i, pass): (usize, Pass)) -> &[f64] {
    let rows = &rows[usize::from(stiff.is_some())];
    match pass {
        Pass::First => &rows[i][..rows.len()],
        Pass::Later => &rows[i],
    }
}
