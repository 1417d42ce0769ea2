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
//! **Prediction**: the rates of the last accepted step as a polynomial in time, continued. That is a long way to the last
//! stages, so in the first sweep each stage that is corrected takes part in predicting those after it, which then lie
//! close: where rates are smooth, errors that the second sweep meets are ten to a hundred times smaller for it, two or three sweeps'
//! worth. What is left of (1) in that sweep is `X_i = x + h Σ_j a_ij k_j`: old rates of stages before `i` are no use.
//!
//! **Tangents** are those of the predicted stages, made on the way of the first sweep from the residuals that it needs anyway. They
//! are kept while they serve, and where those of a fast motion do not even serve the next step, sixteen steps renew them without
//! trying: a renewal costs a sweep.
//!
//! **Stopping**: by the largest change of a stage in an iteration (see `iteration.rs`).

use crate::integrate::{
    collocation::Collocation,
    error::Limit,
    iteration::{Accuracy, Iteration},
    newton::{ROUNDINGS, Stage, evaluate, linearize, place},
    norm::ErrorNorm,
    problem::ImplicitProblem,
    rates::{combine, require_finite},
    statistics::Statistics,
};

/// With the poorest contraction, six digits are gained in 28.
const MAX_ITERATIONS: u32 = 40;
/// A factorization serves steps that differ from its own by this fraction: the rounding of time, no more.
const STEP_BAND: f64 = 1e-3;
/// Tangents are renewed where a step took this many iterations more than the one they were made for.
const MORE_ITERATIONS: u32 = 1;
/// Where tangents do not even serve the step after their own, so many steps renew them without trying.
const RENEWALS: u32 = 16;

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
    /// Steps that are to renew them unasked.
    renewals: u32,
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
    /// Steps since that they served.
    served: u32,
}

/// Which sweep over the stages it is.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Pass {
    /// The first one, with tangents of another step.
    First,
    /// The first one, with new tangents.
    Renewing,
    /// What is old of a stage is that of the pass before.
    Later,
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
            renewals: 0,
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
        let mut pass = self.first_pass(step);
        let mut iteration = Iteration::new(self.accuracy, MAX_ITERATIONS).patient(s as u32);
        loop {
            let mut size = 0.0_f64;
            for i in 0..s {
                self.correct(problem, (time, start), step, (i, pass), statistics)?;
                size = size.max(norm.measure(&self.change, start, &self.states[i]).value);
                if pass != Pass::Later {
                    self.predict_from(i, step);
                }
            }
            let rounding = ROUNDINGS * norm.rounding(&self.states[s - 1]);
            let first = std::mem::replace(&mut pass, Pass::Later);
            if first == Pass::Renewing {
                self.tangents = Some(Tangents { step, fresh: true, iterations: 0, slow: false, served: 0 });
            }
            // Its rows met predictions that improved on the way, and its corrections say nothing of what those were wrong by.
            if first != Pass::Later {
                if size.is_finite() {
                    continue;
                }
                return Err(Limit::Newton);
            }
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

    /// Whether the tangents at hand serve this step; those that do not are given up.
    fn first_pass(&mut self, step: f64) -> Pass {
        let serves = |last: &Tangents| !last.slow && (step / last.step - 1.0).abs() <= STEP_BAND;
        // What this very step is tried again with is as good as new.
        let wanted = self.tangents.as_ref().is_some_and(|last| last.fresh || self.renewals == 0);
        if wanted && self.tangents.as_ref().is_some_and(serves) {
            return Pass::First;
        }
        self.tangents = None;
        self.renewals = self.renewals.saturating_sub(1);
        Pass::Renewing
    }

    /// The rates of the stages after `i` from those that are corrected already, as far as `i`, and from the last step's:
    /// one more than it has stages, the nearest in time.
    fn predict_from(&mut self, i: usize, step: f64) {
        let Some(last) = self.last_step else { return };
        let nodes = &self.method.nodes;
        let (corrected, open) = self.rates[..nodes.len()].split_at_mut(i + 1);
        let kept = || nodes.iter().zip(&self.kept).skip(i).map(|(node, rate)| ((node - 1.0) * last / step, rate));
        let known = || kept().chain(nodes.iter().copied().zip(&*corrected));
        for (to, at) in open.iter_mut().zip(&nodes[i + 1..]) {
            to.fill(0.0);
            for (j, (node, rate)) in known().enumerate() {
                let others = known().map(|(other, _)| other).enumerate().filter(|(k, _)| *k != j);
                let weight: f64 = others.map(|(_, other)| (at - other) / (node - other)).product();
                to.iter_mut().zip(rate).for_each(|(to, rate)| *to += weight * rate);
            }
        }
    }

    /// Row `i` of (1), corrected once; its change is left in `change`.
    fn correct<P: ImplicitProblem>(
        &mut self,
        problem: &mut P,
        (time, start): (f64, &[f64]),
        step: f64,
        (i, pass): (usize, Pass),
        statistics: &mut Statistics,
    ) -> Result<(), Limit> {
        let (s, position_count) = (self.method.stages(), problem.position_count());
        let row = if pass == Pass::Later { &self.rows[i][..] } else { &self.rows[i][..s] };
        combine(&mut self.known, start, step, row, &self.rates);
        let g = step * self.method.lower[i][i];
        let stage = Stage { time: time + self.method.nodes[i] * step, step: g, known: &self.known, start };
        let state = &mut self.states[i];
        self.acceleration.copy_from_slice(&self.rates[i][position_count..]);
        if pass == Pass::Later {
            self.change.copy_from_slice(state);
        }
        place(problem, stage, &self.acceleration, state);
        if pass != Pass::Later {
            self.change.copy_from_slice(state);
        }
        if pass == Pass::Renewing {
            linearize(problem, i, stage, state, &self.acceleration, &mut self.correction, statistics)?;
        } else {
            evaluate(problem, stage.time, state, &self.acceleration, &mut self.correction, statistics)?;
        }
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
            if tangents.slow && tangents.served == 0 {
                self.renewals = RENEWALS;
            }
            tangents.served += u32::from(!tangents.fresh);
        }
    }
}
