//! Where a run stands: time, state, the last step, and what it cost.

use crate::integrate::{
    problem::Problem,
    step::dense::Dense,
    step::error::{Component, Limit, StepError},
    step::options::Start,
    step::rates::require_finite,
    step::statistics::Statistics,
};

/// The part of a run that all methods share.
#[derive(Debug)]
pub struct Progress {
    pub(crate) time: f64,
    pub(crate) previous_time: f64,
    pub(crate) end: f64,
    pub(crate) position_count: usize,
    /// `(q, v)`.
    pub(crate) state: Vec<f64>,
    /// Index into `state` of the component that decided the error of the last step.
    pub(crate) worst: usize,
    pub(crate) dense: Dense,
    pub(crate) statistics: Statistics,
}

impl Progress {
    /// A run that has made no step yet.
    pub(crate) fn new<P: Problem>(problem: &P, start: Start<'_>) -> Result<Self, StepError> {
        let counts = [
            ("positions", start.position.len(), problem.position_count()),
            ("velocities", start.velocity.len(), problem.velocity_count()),
        ];
        for (quantity, given, expected) in counts {
            if given != expected {
                return Err(StepError::Size { quantity, given, expected });
            }
        }
        if !start.time.is_finite() {
            return Err(StepError::option("start time", start.time, "a finite number"));
        }
        if !(start.end.is_finite() && start.end >= start.time) {
            return Err(StepError::option("end time", start.end, "a finite number not before the start"));
        }
        let position_count = start.position.len();
        let mut state = [start.position, start.velocity].concat();
        problem.normalize(&mut state[..position_count]);
        require_finite(&state, position_count).map_err(|limit| StepError::Start { time: start.time, limit })?;
        let (time, previous_time, end) = (start.time, start.time, start.end);
        let dense = Dense::at_rest(&state);
        let statistics = Statistics::default();
        Ok(Self { time, previous_time, end, position_count, state, worst: 0, dense, statistics })
    }

    /// A run whose state is not to change, bit for bit.
    pub(crate) fn at_rest<P: Problem>(problem: &P, start: Start<'_>) -> Result<Self, StepError> {
        let mut progress = Self::new(problem, start)?;
        progress.state = [start.position, start.velocity].concat();
        Ok(progress)
    }

    /// One step to the end in which nothing moves.
    pub(crate) fn stay(&mut self) {
        if !self.finished() {
            self.statistics.accept(self.end - self.time);
            (self.previous_time, self.time) = (self.time, self.end);
        }
    }

    /// The time reached, in s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Where the last step started, in s; the start before the first step.
    pub fn previous_time(&self) -> f64 {
        self.previous_time
    }

    /// Whether the end is reached.
    pub fn finished(&self) -> bool {
        self.time >= self.end
    }

    /// The coordinates reached.
    pub fn position(&self) -> &[f64] {
        &self.state[..self.position_count]
    }

    /// The velocities reached.
    pub fn velocity(&self) -> &[f64] {
        &self.state[self.position_count..]
    }

    /// The length of the last step, in s; 0 before the first.
    pub(crate) fn last_step(&self) -> f64 {
        self.time - self.previous_time
    }

    /// The dense output of the last step, as far as it is made; see [`Stepper::interpolate`](crate::integrate::Stepper).
    pub(crate) fn interpolate<P: Problem>(&self, problem: &P, time: f64, q: &mut [f64], v: &mut [f64]) {
        if time >= self.time {
            q.copy_from_slice(self.position());
            v.copy_from_slice(self.velocity());
            return;
        }
        let theta = ((time - self.previous_time) / self.last_step()).max(0.0);
        self.dense.evaluate(theta, 0, q);
        self.dense.evaluate(theta, self.position_count, v);
        problem.normalize(q);
    }

    /// When the run ends, in s.
    pub(crate) fn end(&self) -> f64 {
        self.end
    }

    /// Takes note of an attempt that was given up.
    pub(crate) fn reject(&mut self) {
        self.statistics.rejected_steps += 1;
    }

    /// What the run has cost so far.
    pub fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// The component at `index` of the state.
    pub(crate) fn component(&self, index: usize) -> Component {
        Component::of_state(index, self.position_count)
    }

    /// The system cannot be evaluated at the start.
    pub(crate) fn cannot_start(&self, limit: Limit) -> StepError {
        StepError::Start { time: self.time, limit }
    }

    /// Takes `next` as the new state at `time`, and leaves the old one in `next`.
    pub(crate) fn advance(&mut self, time: f64, next: &mut Vec<f64>) {
        self.statistics.accept(time - self.time);
        self.previous_time = self.time;
        self.time = time;
        std::mem::swap(&mut self.state, next);
    }
}
