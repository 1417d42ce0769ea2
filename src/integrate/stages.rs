//! The coupled stages of a collocation method, solved with one sweep of the tangent per stage and iteration.
//!
//! The stage equations `X_i = x + h Σ_j a_ij k_j` couple all stages. With `A = L U` (see `collocation.rs`) they are
//! iterated in the form
//!
//! ```text
//! (1)  X_i = x + h Σ_{j<i} l_ij k_j + h l_ii k_i + h Σ_j (a_ij − l_ij) k_j°,     k° from the iteration before,
//! ```
//!
//! of which every row, taken in order, is the equation of a diagonally implicit stage with `g = h l_ii` (see
//! `newton.rs`). It is not solved but corrected once: a residual and a solve with the tangent taken at the predicted
//! stage, `K = c₂ ∂r/∂a + c₁ ∂r/∂v + ∂r/∂q`, `c₁ = 1/g`, `c₂ = 1/g²`. The shifts `l_ii` are real, so each tangent is the
//! O(n) sweep of the accelerations' family: no complex arithmetic, no matrix of `s n` unknowns.
//!
//! **Convergence**: for `ẋ = λ x`, `z = h λ`, the error is multiplied by `z (1 − z L)⁻¹ (A − L)`. It vanishes for
//! `z → 0`, and for `z → −∞` it tends to `1 − U`, which is nilpotent. Its largest spectral radius in the left half plane
//! is 0.37, 0.51, 0.61 for Radau of 3, 4, 5 stages and 0.14, 0.30 for Gauss of 2, 3.
//! P.J. van der Houwen, J.J.B. de Swart, *Triangularly implicit iteration methods for ODE-IVP solvers*,
//! SIAM J. Sci. Comput. 18 (1997).
//!
//! **Prediction**: the rates of the last accepted step as a polynomial in time, continued.
//!
//! **Stopping**: by the largest change of a stage in an iteration (see `iteration.rs`).

use crate::integrate::{
    collocation::Collocation,
    error::Limit,
    iteration::{Accuracy, Iteration},
    newton::{ROUNDINGS, Stage, evaluate, place},
    norm::ErrorNorm,
    problem::{ImplicitProblem, Point},
    rates::{combine, require_finite},
    statistics::Statistics,
};

/// With the poorest contraction, six digits are gained in 28.
const MAX_ITERATIONS: u32 = 40;
/// A factorization serves steps that differ from its own by this fraction: the rounding of time, no more.
const STEP_BAND: f64 = 1e-3;
/// Tangents are renewed where a step took this many iterations more than the one they were made for.
const MORE_ITERATIONS: u32 = 1;

/// The stages of the step tried and of the one before.
#[derive(Debug)]
pub(crate) struct Stages {
    pub(crate) method: Collocation,
    /// The weights of (1) for `rates`: of `k`, then of `k − k°`.
    rows: Vec<Vec<f64>>,
    /// `k_1 … k_s`, each `(N(q) v, a)`, then their changes in this iteration.
    pub(crate) rates: Vec<Vec<f64>>,
    /// `X_1 … X_s`.
    pub(crate) states: Vec<Vec<f64>>,
    /// Rates of the last accepted step.
    kept: Vec<Vec<f64>>,
    /// `None` before the first one.
    last_step: Option<f64>,
    /// The known part of a stage.
    known: Vec<f64>,
    /// Change of a stage.
    change: Vec<f64>,
    /// Residual, then correction; in velocity coordinates.
    correction: Vec<f64>,
    acceleration: Vec<f64>,
    accuracy: Accuracy,
    tangents: Option<Tangents>,
}

/// What is known of the factorizations.
#[derive(Debug, Clone, Copy)]
struct Tangents {
    /// `h` they were made for.
    step: f64,
    /// Made for the step now tried.
    fresh: bool,
    /// Iterations of the step they were made for.
    iterations: u32,
    slow: bool,
}

impl Stages {
    /// Room for a problem.
    pub(crate) fn new<P: ImplicitProblem>(problem: &mut P, method: Collocation, accuracy: Accuracy) -> Self {
        let s = method.stages();
        problem.reserve(s);
        let velocity_count = problem.velocity_count();
        let state = vec![0.0; problem.position_count() + velocity_count];
        let row = |i: usize| {
            let (a, l) = (&method.rows[i], &method.lower[i]);
            let mut row = a.clone();
            row[i] -= l[i];
            row.extend((0..i).map(|j| l[j] - a[j]));
            row
        };
        Self {
            rows: (0..s).map(row).collect(),
            rates: vec![state.clone(); 2 * s],
            states: vec![state.clone(); s],
            kept: vec![state.clone(); s],
            last_step: None,
            known: state.clone(),
            change: state,
            correction: vec![0.0; velocity_count],
            acceleration: vec![0.0; velocity_count],
            accuracy,
            tangents: None,
            method,
        }
    }

    /// Solves the stages of a step from `start` at `time`, the rate there being `rate`.
    ///
    /// # Errors
    /// [`Limit::Newton`] where the iteration diverges or is too slow; where the system cannot be evaluated.
    pub(crate) fn solve<P: ImplicitProblem>(
        &mut self,
        problem: &mut P,
        norm: &ErrorNorm,
        (time, start, rate): (f64, &[f64], &[f64]),
        step: f64,
        statistics: &mut Statistics,
    ) -> Result<(), Limit> {
        let s = self.method.stages();
        self.predict(step, rate);
        for i in 0..s {
            combine(&mut self.states[i], start, step, &self.method.rows[i], &self.rates);
        }
        self.renew(problem, time, step, statistics)?;
        let mut iteration = Iteration::new(self.accuracy, MAX_ITERATIONS);
        loop {
            let mut size = 0.0_f64;
            for i in 0..s {
                self.correct(problem, (time, start), step, i, statistics)?;
                size = size.max(norm.measure(&self.change, start, &self.states[i]).value);
            }
            let rounding = ROUNDINGS * norm.rounding(&self.states[s - 1]);
            if iteration.converged(size, rounding)? {
                self.finish(iteration.count());
                return require_finite(&self.states[s - 1], problem.position_count());
            }
        }
    }

    /// The step is accepted: its rates are those to predict from, its tangents are old.
    pub(crate) fn advance(&mut self, step: f64) {
        for (kept, rate) in self.kept.iter_mut().zip(&mut self.rates) {
            std::mem::swap(kept, rate);
        }
        self.last_step = Some(step);
        if let Some(tangents) = &mut self.tangents {
            tangents.fresh = false;
        }
    }

    /// Gives up the tangents where they are old; false where they are of this very step.
    pub(crate) fn discard_old(&mut self) -> bool {
        let old = self.tangents.as_ref().is_some_and(|tangents| !tangents.fresh);
        if old {
            self.tangents = None;
        }
        old
    }

    /// `k` from the last step, or from the rate at the start.
    fn predict(&mut self, step: f64, rate: &[f64]) {
        let s = self.method.stages();
        let (rates, _) = self.rates.split_at_mut(s);
        for (i, to) in rates.iter_mut().enumerate() {
            let Some(last) = self.last_step else {
                to.copy_from_slice(rate);
                continue;
            };
            let at = 1.0 + self.method.nodes[i] * step / last;
            to.fill(0.0);
            for (j, kept) in self.kept.iter().enumerate() {
                let weight = self.method.lagrange(j, at);
                to.iter_mut().zip(kept).for_each(|(to, kept)| *to += weight * kept);
            }
        }
    }

    /// Makes sure of tangents that serve this step.
    fn renew<P: ImplicitProblem>(
        &mut self,
        problem: &mut P,
        time: f64,
        step: f64,
        statistics: &mut Statistics,
    ) -> Result<(), Limit> {
        let serve = |last: &Tangents| !last.slow && (step / last.step - 1.0).abs() <= STEP_BAND;
        if self.tangents.as_ref().is_some_and(serve) {
            return Ok(());
        }
        self.tangents = None;
        let position_count = problem.position_count();
        for (i, state) in self.states.iter().enumerate() {
            let (q, v) = state.split_at(position_count);
            let at = Point { time: time + self.method.nodes[i] * step, q, v, a: &self.rates[i][position_count..] };
            let c1 = 1.0 / (step * self.method.lower[i][i]);
            statistics.jacobian_evaluations += 1;
            problem.factorize(i, at, c1, c1 * c1).map_err(Limit::Failure)?;
        }
        self.tangents = Some(Tangents { step, fresh: true, iterations: 0, slow: false });
        Ok(())
    }

    /// Row `i` of (1), corrected once; its change is left in `change`.
    fn correct<P: ImplicitProblem>(
        &mut self,
        problem: &mut P,
        (time, start): (f64, &[f64]),
        step: f64,
        i: usize,
        statistics: &mut Statistics,
    ) -> Result<(), Limit> {
        let (s, position_count) = (self.method.stages(), problem.position_count());
        combine(&mut self.known, start, step, &self.rows[i], &self.rates);
        let g = step * self.method.lower[i][i];
        let stage = Stage { time: time + self.method.nodes[i] * step, step: g, known: &self.known, start };
        let state = &mut self.states[i];
        self.change.copy_from_slice(state);
        self.acceleration.copy_from_slice(&self.rates[i][position_count..]);
        place(problem, stage, &self.acceleration, state);
        evaluate(problem, stage.time, state, &self.acceleration, &mut self.correction, statistics)?;
        statistics.newton_iterations += 1;
        statistics.solves += 1;
        problem.solve(i, &mut self.correction);
        let c2 = 1.0 / (g * g);
        self.acceleration.iter_mut().zip(&self.correction).for_each(|(a, correction)| *a -= c2 * correction);
        place(problem, stage, &self.acceleration, state);
        self.change.iter_mut().zip(&*state).for_each(|(change, now)| *change = now - *change);

        // k and k − k°.
        let (rates, changes) = self.rates.split_at_mut(s);
        let (q, v) = state.split_at(position_count);
        changes[i].copy_from_slice(&rates[i]);
        let (position_rate, acceleration) = rates[i].split_at_mut(position_count);
        problem.position_rate(q, v, position_rate);
        acceleration.copy_from_slice(&self.acceleration);
        changes[i].iter_mut().zip(&rates[i]).for_each(|(change, now)| *change = now - *change);
        Ok(())
    }

    /// Takes note of how well the tangents serve.
    fn finish(&mut self, iterations: u32) {
        if let Some(tangents) = &mut self.tangents {
            if tangents.fresh {
                tangents.iterations = iterations;
            }
            tangents.slow |= iterations > tangents.iterations + MORE_ITERATIONS;
        }
    }
}
