//! First guesses for the stage accelerations of [`Sdirk4`](crate::integrate::Sdirk4).
//!
//! The quadratic through three accelerations that are already known, chosen near the stage but well apart, so that
//! their small errors are not blown up. Before the first step is done there are fewer: a line or a constant.
//!
//! ```text
//! stage at   1/4: from −1, −1/2 (of the last step) and 0      11/20: from 0, 1/4, 3/4
//!            3/4: from −1/2, 0, 1/4                            1/2: from 1/4, 3/4, 11/20      1: from 1/4, 3/4, 1/2
//! ```

use crate::integrate::method::tableau::sdirk4::C;

/// Slots of the known accelerations: start and middle of the last step, start of this one, then its stages.
const LAST_START: usize = 0;
const LAST_MIDDLE: usize = 1;
const START: usize = 2;
const STAGES: usize = 3;
/// The stage in the middle of a step, and the one at its end.
const MIDDLE: usize = STAGES + 3;
const END: usize = STAGES + 4;
/// The slots each stage is predicted from.
const NODES: [[usize; 3]; 5] = [
    [LAST_START, LAST_MIDDLE, START],
    [LAST_MIDDLE, START, STAGES],
    [START, STAGES, STAGES + 1],
    [STAGES, STAGES + 1, STAGES + 2],
    [STAGES, STAGES + 1, MIDDLE],
];

/// Accelerations at known times.
#[derive(Debug)]
pub(crate) struct Predictor {
    known: Vec<Vec<f64>>,
    /// `None` before the first accepted step.
    last_step: Option<f64>,
}

impl Predictor {
    /// Starts with the acceleration at the start alone.
    pub(crate) fn new(acceleration: &[f64]) -> Self {
        Self { known: vec![acceleration.to_vec(); END + 1], last_step: None }
    }

    /// The acceleration at the start of the step.
    pub(crate) fn start(&self) -> &[f64] {
        &self.known[START]
    }

    /// Keeps the acceleration found for a stage.
    pub(crate) fn record(&mut self, stage: usize, acceleration: &[f64]) {
        self.known[STAGES + stage].copy_from_slice(acceleration);
    }

    /// The step of length `step` is accepted: its end is the next start.
    pub(crate) fn advance(&mut self, step: f64) {
        self.known.swap(LAST_START, START);
        self.known.swap(LAST_MIDDLE, MIDDLE);
        self.known.swap(START, END);
        self.last_step = Some(step);
    }

    /// `guess ←` the predicted acceleration of a stage, the earlier ones being recorded.
    pub(crate) fn predict(&self, stage: usize, step: f64, guess: &mut [f64]) {
        guess.fill(0.0);
        for &node in &NODES[stage] {
            let Some(at) = self.place(node, step) else { continue };
            let others = NODES[stage].iter().filter(|other| **other != node);
            let weight: f64 = others
                .filter_map(|&other| self.place(other, step))
                .map(|other| (C[stage] - other) / (at - other))
                .product();
            guess.iter_mut().zip(&self.known[node]).for_each(|(guess, known)| *guess += weight * known);
        }
    }

    /// Where a slot lies, in steps from the start; `None` if nothing is known there.
    fn place(&self, slot: usize, step: f64) -> Option<f64> {
        match slot {
            LAST_START => self.last_step.map(|last| -last / step),
            LAST_MIDDLE => self.last_step.map(|last| -0.5 * last / step),
            START => Some(0.0),
            stage => Some(C[stage - STAGES]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_is_predicted_exactly() {
        let quadratic = |t: f64| 2.0 - 3.0 * t + 0.5 * t * t;
        let mut predictor = Predictor::new(&[quadratic(-0.4)]);
        let record_all = |predictor: &mut Predictor, start: f64, step: f64| {
            for (stage, c) in C.iter().enumerate() {
                predictor.record(stage, &[quadratic(start + c * step)]);
            }
        };
        record_all(&mut predictor, -0.4, 0.4);
        predictor.advance(0.4);
        record_all(&mut predictor, 0.0, 0.7);
        for (stage, c) in C.iter().enumerate() {
            let mut guess = [0.0];
            predictor.predict(stage, 0.7, &mut guess);
            // Rounding of three terms with weights up to 12.
            assert!((guess[0] - quadratic(c * 0.7)).abs() < 1e-14);
        }
    }

    #[test]
    fn the_first_stage_of_all_is_predicted_from_the_start() {
        let mut guess = [0.0];
        Predictor::new(&[7.0]).predict(0, 0.1, &mut guess);
        assert_eq!(guess, [7.0]);
    }
}
