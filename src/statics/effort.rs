//! What a search worked, for reports and plots.

use crate::spatial::Wrench;

/// One iteration of the search, for reports and plots.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iteration {
    /// Which stage made it.
    pub stage: &'static str,
    /// Largest unbalanced force, relative to the forces that cancel there.
    pub residual: f64,
    /// Size of the step in the inertia metric (m √kg).
    pub step: f64,
    /// Shift `σ` of the trust region, 0 for a Newton step.
    pub shift: f64,
}

/// What one stage of the cascade worked.
#[derive(Debug, Clone, PartialEq)]
pub struct Stage {
    /// Its name.
    pub name: &'static str,
    /// Steps; time steps of a relaxation.
    pub iterations: usize,
    /// Static balances.
    pub force_evaluations: usize,
    /// Matrices, or tangents by sweeps, factorized.
    pub factorizations: usize,
    /// Largest unbalanced force where it ended, relative to the forces that cancel there.
    pub relative_residual: f64,
    /// Whether it ended in balance.
    pub balanced: bool,
}

/// What a search did, apart from what the landscape counts.
#[derive(Debug, Clone, Default)]
pub(super) struct Effort {
    pub stage: &'static str,
    pub stages: Vec<Stage>,
    pub steps: Option<usize>,
    pub accelerations: usize,
    pub forces: usize,
    pub factorizations: usize,
    pub reactions: Vec<Wrench>,
    /// Whether the potential fell without end.
    pub fell: bool,
    /// The part of the forces that may be left, if that is more than is allowed elsewhere.
    pub allowed: f64,
}
