//! One function that is watched, and what was seen of it.

use super::Function;

/// A function, and what was seen of it.
#[derive(Debug)]
pub(super) struct Watch {
    pub(super) function: Function,
    /// Its sign before the event.
    pub(super) positive: bool,
    /// Values up to this beyond zero are rounding, unless the number changes faster than `still`.
    pub(super) band: f64,
    /// Infinite for a function whose rate is not known or does not count.
    pub(super) still: f64,
    /// The lowest value since it has this sign, with zero before the event and more after it.
    pub(super) lowest: f64,
    /// Value and rate at the last look; 0 for a rate that is not known.
    pub(super) last: [f64; 2],
    /// Value and rate at the next one.
    pub(super) next: [f64; 2],
    /// The value where it was last found on the far side.
    pub(super) found: f64,
}

impl Watch {
    /// A value or rate as it is below zero before the event and above after it.
    pub(super) fn towards(&self, value: f64) -> f64 {
        if self.positive { -value } else { value }
    }

    /// A value and its rate: above zero if the event has happened.
    pub(super) fn beyond(&self, [value, rate]: [f64; 2]) -> f64 {
        let (value, rate) = (self.towards(value), self.towards(rate));
        match value > self.band || rate > self.still {
            true => value,
            // On the far side by rounding, or on the way back from there.
            false => -value.abs(),
        }
    }

    /// Goes on from the next look.
    pub(super) fn take_next(&mut self) {
        self.last = self.next;
        self.lowest = self.lowest.min(self.towards(self.last[0]));
    }

    /// Whether the sign has changed at the next look.
    pub(super) fn changed(&self) -> bool {
        self.beyond(self.next) > 0.0
    }
}
