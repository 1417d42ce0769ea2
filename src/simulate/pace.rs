//! Whether a run gets anywhere.

/// Steps over which the pace is taken.
const STEPS: u64 = 5_000;
/// A run that would need more steps than this from here on is given up: days, of any scene.
const MOST: f64 = 1e9;

/// The pace of the last steps of a run.
#[derive(Debug)]
pub(super) struct Pace {
    steps: u64,
    /// When they began (s).
    since: f64,
}

/// A run that creeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Creep {
    /// The mean step (s).
    pub(super) step: f64,
    /// Steps to the end at that pace.
    pub(super) left: f64,
}

impl Pace {
    /// Of a run that starts at a time (s).
    pub(super) fn new(time: f64) -> Self {
        Self { steps: 0, since: time }
    }

    /// Looks at the time (s) a step has reached; tells where the `end` is out of reach.
    pub(super) fn see(&mut self, time: f64, end: f64) -> Option<Creep> {
        self.steps += 1;
        if self.steps < STEPS {
            return None;
        }
        let step = (time - self.since) / STEPS as f64;
        *self = Self::new(time);
        let left = (end - time) / step;
        (left > MOST).then_some(Creep { step, left })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_given_up_where_its_end_is_out_of_reach_and_only_there() {
        let creeps = |step: f64| {
            let mut pace = Pace::new(0.0);
            (1..=2 * STEPS).find_map(|i| pace.see(i as f64 * step, 10.0))
        };
        assert_eq!(creeps(1e-7), None);
        let creep = creeps(1e-9).expect("ten thousand million steps");
        assert!((creep.step / 1e-9 - 1.0).abs() < 1e-9 && (creep.left / 1e10 - 1.0).abs() < 1e-3, "{creep:?}");
    }
}
