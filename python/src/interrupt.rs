//! Ctrl-C in something that takes long.

use pyo3::prelude::*;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// How often Python is asked.
const PERIOD: Duration = Duration::from_millis(50);

/// Asks Python now and then whether to go on.
pub(crate) struct Interrupt {
    /// When it was asked last, and what was raised.
    asked: Mutex<(Instant, Option<PyErr>)>,
}

impl Interrupt {
    pub(crate) fn new() -> Self {
        Self { asked: Mutex::new((Instant::now(), None)) }
    }

    fn asked(&self) -> MutexGuard<'_, (Instant, Option<PyErr>)> {
        self.asked.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Whether to go on; for code that does not hold the interpreter.
    pub(crate) fn go_on(&self) -> bool {
        let (last, raised) = &mut *self.asked();
        if raised.is_some() || last.elapsed() < PERIOD {
            return raised.is_none();
        }
        *last = Instant::now();
        *raised = Python::attach(|py| py.check_signals()).err();
        raised.is_none()
    }

    /// What was raised on the way, a `KeyboardInterrupt`.
    pub(crate) fn check(self) -> PyResult<()> {
        self.asked().1.take().map_or(Ok(()), Err)
    }
}
