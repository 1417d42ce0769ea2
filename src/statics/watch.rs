//! How long a search may go on.

use std::cell::Cell;
use std::time::{Duration, Instant};

/// Why a search was ended before it came to its own end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ended {
    /// Its time was over.
    Time,
    /// The caller asked for it.
    Stopped,
}

/// Asked between two steps.
pub(super) struct Watch<'w> {
    go_on: &'w dyn Fn() -> bool,
    limit: f64,
    until: Option<Instant>,
    ended: Cell<Option<Ended>>,
}

impl<'w> Watch<'w> {
    /// From now on for `limit` seconds (infinite for ever), and as long as `go_on` says so.
    pub(super) fn new(limit: f64, go_on: &'w dyn Fn() -> bool) -> Self {
        let length = Duration::try_from_secs_f64(limit).ok();
        let until = length.and_then(|length| Instant::now().checked_add(length));
        Self { go_on, limit, until, ended: Cell::new(None) }
    }

    pub(super) fn goes_on(&self) -> bool {
        if self.ended.get().is_none() {
            let over = self.until.is_some_and(|until| Instant::now() >= until);
            self.ended.set(match (over, (self.go_on)()) {
                (_, false) => Some(Ended::Stopped),
                (true, true) => Some(Ended::Time),
                (false, true) => None,
            });
        }
        self.ended.get().is_none()
    }

    /// What to say of a search that was ended in `stage`; `None` when it came to its own end.
    pub(super) fn note(&self, stage: &str, residual: f64) -> Option<String> {
        let left =
            format!("in the stage `{stage}`: the best residual until then is {residual:.1e} of the forces that cancel");
        self.ended.get().map(|ended| match ended {
            Ended::Time => {
                format!("the time limit of {} s ended the search {left}; `[statics] time_limit` sets it", self.limit)
            }
            Ended::Stopped => format!("the search was stopped {left}"),
        })
    }
}
