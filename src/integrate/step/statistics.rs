//! What a run has cost.

/// Work counters of one run; they say what a run costs on any machine.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Statistics {
    /// Accepted steps.
    pub steps: u64,
    /// Attempts that were given up: error too large, Newton's iteration failed, or a number was not finite.
    pub rejected_steps: u64,
    /// Evaluations of `a(t, q, v)`, the ones of the start included.
    pub acceleration_evaluations: u64,
    /// Evaluations of the inverse dynamics residual.
    pub residual_evaluations: u64,
    /// Jacobians formed and factorized.
    pub jacobian_evaluations: u64,
    /// Solves with a factorization.
    pub solves: u64,
    /// Newton iterations, summed over all stages.
    pub newton_iterations: u64,
    /// Shortest accepted step in s, the one that lands on the end included; 0 before the first step.
    pub smallest_step: f64,
    /// Longest accepted step in s; 0 before the first step.
    pub largest_step: f64,
    /// Sum of what the errors of accepted steps are estimated at, in parts of the state: what they may add up to, which the
    /// tolerance of a run bounds only for as many steps as there are smallest shares in it. If a step ends better than its
    /// estimate, by an order or more, this is heeded; what the iterations of coupled stages leave is in it. 0 for fixed steps.
    pub error_sum: f64,
}

impl Statistics {
    /// Counts an accepted step of `step` s.
    pub(crate) fn accept(&mut self, step: f64) {
        self.smallest_step = if self.steps == 0 { step } else { self.smallest_step.min(step) };
        self.largest_step = self.largest_step.max(step);
        self.steps += 1;
    }

    /// Adds what another part of the same run has cost.
    pub(crate) fn add(&mut self, part: &Self) {
        self.smallest_step = match (self.steps, part.steps) {
            (0, _) => part.smallest_step,
            (_, 0) => self.smallest_step,
            _ => self.smallest_step.min(part.smallest_step),
        };
        self.largest_step = self.largest_step.max(part.largest_step);
        self.steps += part.steps;
        self.error_sum += part.error_sum;
        self.rejected_steps += part.rejected_steps;
        self.acceleration_evaluations += part.acceleration_evaluations;
        self.residual_evaluations += part.residual_evaluations;
        self.jacobian_evaluations += part.jacobian_evaluations;
        self.solves += part.solves;
        self.newton_iterations += part.newton_iterations;
    }
}
