//! Says while a run goes on that it meets far more events than anybody expects.

use super::number::number;
use super::output;
use crate::record::{Event, Outcome, RecordError, Recorder, Sample};

/// So many events are told, and each ten times as many: some seconds of most scenes.
const MANY: u64 = 50_000;

/// An onlooker that counts.
#[derive(Debug)]
pub(super) struct Storm {
    count: u64,
    told: u64,
    begin: f64,
    end: f64,
}

impl Storm {
    /// Of a run between two times (s).
    pub(super) fn new(begin: f64, end: f64) -> Self {
        Self { count: 0, told: MANY, begin, end }
    }
}

impl Recorder for Storm {
    fn sample(&mut self, _sample: &Sample) -> Result<(), RecordError> {
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), RecordError> {
        self.count += 1;
        if self.count == self.told {
            self.told *= 10;
            let pace = self.count as f64 / (event.time - self.begin);
            output::warning(&format!(
                "at t = {} s there were {} events, the last of `{}`; at this pace there are {} more to come: what gives back all of its \
                 speed strikes for ever, a restitution below 1 comes to rest",
                number(event.time),
                self.count,
                event.name,
                number((pace * (self.end - event.time)).round())
            ));
        }
        Ok(())
    }

    fn finish(&mut self, _outcome: &Outcome) -> Result<(), RecordError> {
        Ok(())
    }
}
