//! The dynamic cases once more, all with the same tolerance and each with several methods: what error they reach.
//!
//! A case is the test function itself. While a survey is on, `head` takes the survey's method and tolerance instead of the
//! case's own, and what the case would check is measured.

use std::cell::RefCell;
use std::time::Duration;
use stillpoint::integrate::Statistics;

/// What a case did under a survey.
#[derive(Debug, Clone, Default)]
pub(super) struct Found {
    integrator: String,
    tolerance: f64,
    /// Largest error, of numbers above 1 relative to them.
    pub(super) error: f64,
    pub(super) steps: u64,
    /// Accelerations and force balances.
    pub(super) evaluations: u64,
    /// Time spent in steps.
    pub(super) wall: Duration,
}

thread_local! {
    static SURVEY: RefCell<Option<Found>> = const { RefCell::new(None) };
}

/// Runs a case with a method at a tolerance.
pub(super) fn survey(integrator: &str, tolerance: f64, case: fn()) -> Found {
    let found = Found { integrator: integrator.to_owned(), tolerance, ..Found::default() };
    SURVEY.set(Some(found));
    case();
    SURVEY.take().expect("the survey is on")
}

pub(super) fn is_on() -> bool {
    SURVEY.with_borrow(Option::is_some)
}

/// The method and tolerance to run with, where a case would take these.
pub(super) fn asked(integrator: &str, tolerance: f64) -> (String, f64) {
    SURVEY.with_borrow(|survey| match survey {
        Some(found) => (found.integrator.clone(), found.tolerance),
        None => (integrator.to_owned(), tolerance),
    })
}

/// Takes note of a run.
pub(super) fn ran(work: &Statistics, wall: Duration) {
    SURVEY.with_borrow_mut(|survey| {
        if let Some(found) = survey {
            found.steps += work.steps;
            found.wall += wall;
            found.evaluations += work.acceleration_evaluations + work.residual_evaluations;
        }
    });
}

/// Takes note of an error; true where a survey is on, and nothing else is to be made of it.
pub(super) fn noted(error: f64, expected: f64) -> bool {
    SURVEY.with_borrow_mut(|survey| {
        survey.as_mut().map(|found| found.error = found.error.max(error / expected.abs().max(1.0))).is_some()
    })
}
