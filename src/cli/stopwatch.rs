//! Timing of a routine in-process: repetitions of a loop that is long enough for the clock.

use serde_json::{Value, json};
use std::hint::black_box;
use std::time::{Duration, Instant};

/// Loops timed.
const REPETITIONS: usize = 15;
/// Length of one loop: far above the resolution of the clock, short enough to fall between interruptions.
const LOOP: Duration = Duration::from_millis(8);

/// What one call of a routine takes (ns).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Cost {
    /// The fastest loop: the routine undisturbed.
    pub(super) min: f64,
    /// The loop in the middle.
    pub(super) median: f64,
}

impl Cost {
    pub(super) fn json(self) -> Value {
        json!({ "min": self.min, "median": self.median })
    }
}

/// Times `call`, warmed up; a call that takes longer than a loop is one loop.
pub(super) fn time<T>(mut call: impl FnMut() -> T) -> Cost {
    let warm = Instant::now();
    let mut calls = 0_u32;
    while calls == 0 || warm.elapsed() < LOOP {
        black_box(call());
        calls += 1;
    }
    let mut loops = [0.0; REPETITIONS];
    for each in &mut loops {
        let start = Instant::now();
        for _ in 0..calls {
            black_box(call());
        }
        *each = start.elapsed().as_nanos() as f64 / f64::from(calls);
    }
    loops.sort_by(f64::total_cmp);
    Cost { min: loops[0], median: loops[REPETITIONS / 2] }
}
