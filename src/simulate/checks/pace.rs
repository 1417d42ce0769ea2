//! Whether a run gets anywhere.

/// Steps over which the pace is taken.
const STEPS: u64 = 5_000;
/// A run that would need more steps than this from here on is given up: days, of any scene.
const MOST: f64 = 1e9;
/// Short steps within something short that a formula of the time does are waited for if they are no more than this to its end: a pulse
/// takes a method of order 2 some hundred thousand, however short it is.
const MOST_WITHIN: f64 = 1e6;
/// A run is given up after so many paces in a row at which its end is out of reach: a light body between heavy ones, as they pull it
/// straight, takes some thousand steps within a nanosecond and goes on.
const PASSAGE: u32 = 4;

/// The pace of the last steps of a run.
#[derive(Debug)]
pub(in crate::simulate) struct Pace {
    steps: u64,
    /// When they began (s).
    since: f64,
    /// When formulas of the time begin to do something else (s).
    until: Option<f64>,
    /// How often the end was out of reach, one after the other.
    slow: u32,
}

/// A run that creeps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::simulate) struct Creep {
    /// The mean step (s).
    pub(in crate::simulate) step: f64,
    /// Steps to the end at that pace.
    pub(in crate::simulate) left: f64,
}

impl Pace {
    /// Of a run that starts at a time (s).
    pub(in crate::simulate) fn new(time: f64) -> Self {
        Self { steps: 0, since: time, until: None, slow: 0 }
    }

    /// What formulas of the time do now they do until then (s).
    pub(in crate::simulate) fn until(self, until: Option<f64>) -> Self {
        Self { until, ..self }
    }

    /// Looks at the time (s) a step has reached; tells where the `end` is out of reach.
    pub(in crate::simulate) fn see(&mut self, time: f64, end: f64) -> Option<Creep> {
        self.steps += 1;
        if self.steps < STEPS {
            return None;
        }
        let step = (time - self.since) / STEPS as f64;
        let left = (end - time) / step;
        let ends = self.until.is_some_and(|until| (until - time) / step <= MOST_WITHIN);
        let slow = if left > MOST && !ends { self.slow + 1 } else { 0 };
        *self = Self { steps: 0, since: time, slow, ..*self };
        (slow >= PASSAGE).then_some(Creep { step, left })
    }
}

/// Events over which their pace is taken, per side of a stop and one more.
const EVENTS: u64 = 500;
/// A pace that would meet more events than this up to the end is too fast.
const MOST_EVENTS: f64 = 1e8;
/// A run is given up after so many times the pace was too fast, one after the other: bounces that accumulate end before, but
/// for those that give back all but less than a thousandth of their speed.
const PATIENCE: u32 = 25;

/// The pace of the last events that changed how a run goes on.
#[derive(Debug)]
pub(in crate::simulate) struct EventPace {
    window: u64,
    count: u64,
    /// When they began (s).
    since: f64,
    /// How often the pace was too fast, one after the other.
    fast: u32,
}

/// Events that creep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::simulate) struct Storm {
    /// Events counted.
    pub(in crate::simulate) count: u64,
    /// The time they took (s).
    pub(in crate::simulate) span: f64,
}

impl EventPace {
    /// Of a scene whose stops have so many sides: many of them have many events at once.
    pub(in crate::simulate) fn new(sides: usize) -> Self {
        Self { window: EVENTS * (1 + sides as u64), count: 0, since: 0.0, fast: 0 }
    }

    /// Looks at the time (s) of an event; tells if the `end` is out of reach.
    pub(in crate::simulate) fn see(&mut self, time: f64, end: f64) -> Option<Storm> {
        self.count += 1;
        if self.count < self.window {
            return None;
        }
        let (count, span) = (self.count, time - self.since);
        (self.count, self.since) = (0, time);
        let fast = count as f64 * (end - time) > MOST_EVENTS * span;
        self.fast = if fast { self.fast + 1 } else { 0 };
        (self.fast >= PATIENCE).then_some(Storm { count, span })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn events_are_given_up_on_if_they_take_no_time_and_only_then() {
        let storm = |events: i32, time_of: &dyn Fn(i32) -> f64| {
            let mut pace = EventPace::new(1);
            (0..events).find_map(|i| pace.see(time_of(i), 10.0))
        };
        assert_eq!(storm(100_000, &|i| 1e-5 * f64::from(i)), None);
        // A ball that gives back all but a thousandth of its speed, until that is 1e-7 of what it was.
        assert_eq!(storm(16_000, &|i| 2.0 * (1.0 - 0.999_f64.powi(i))), None);
        let found = storm(100_000, &|i| 1.0 + 1e-21 * f64::from(i)).expect("a storm");
        assert_eq!((found.count, found.span), (1000, 0.0));
        assert!(storm(100_000, &|i| 0.5 + 1e-13 * f64::from(i)).is_some());
    }

    #[test]
    fn a_run_is_given_up_where_its_end_is_out_of_reach_and_only_there() {
        let creeps = |step: f64| {
            let mut pace = Pace::new(0.0);
            (1..=u64::from(2 * PASSAGE) * STEPS).find_map(|i| pace.see(i as f64 * step, 10.0))
        };
        assert_eq!(creeps(1e-7), None);
        let creep = creeps(1e-9).expect("ten thousand million steps");
        assert!((creep.step / 1e-9 - 1.0).abs() < 1e-9 && (creep.left / 1e10 - 1.0).abs() < 1e-3, "{creep:?}");
        // A pulse that ends in time, and one that does not.
        let within = |until: f64| {
            let mut pace = Pace::new(0.0).until(Some(until));
            (1..=u64::from(2 * PASSAGE) * STEPS).find_map(|i| pace.see(i as f64 * 1e-12, 10.0))
        };
        assert_eq!((within(1e-7), within(1e-5).is_some()), (None, true));
        // Three times as many steps as a pace is taken over, within a nanosecond: a passage.
        let mut pace = Pace::new(0.0);
        let through = |i: u64| if i < 3 * STEPS { 1e-13 * i as f64 } else { 1e-4 * (i - 3 * STEPS) as f64 };
        assert_eq!((1..10 * STEPS).find_map(|i| pace.see(through(i), 10.0)).map(|creep| creep.left), None);
    }
}
