//! Several recorders fed at once.

use super::{ContactPush, Event, Outcome, RecordError, Recorder, Sample};

/// Feeds one recorder that matters and any number of onlookers. An onlooker that fails is dropped and the failure kept
/// for the caller to report; the run and the recorder that matters never notice.
#[derive(Default)]
pub struct Fanout {
    recorder: Option<Box<dyn Recorder>>,
    onlookers: Vec<Box<dyn Recorder>>,
    lost: Vec<RecordError>,
}

impl Fanout {
    /// Without any recorder: takes samples and forgets them.
    pub fn new() -> Self {
        Self::default()
    }

    /// Sets the recorder whose errors stop the run.
    pub fn recorder(mut self, recorder: impl Recorder + 'static) -> Self {
        self.recorder = Some(Box::new(recorder));
        self
    }

    /// Adds a recorder whose errors do not stop the run.
    pub fn onlooker(mut self, onlooker: impl Recorder + 'static) -> Self {
        self.onlookers.push(Box::new(onlooker));
        self
    }

    /// Takes the failures of onlookers since the last call.
    pub fn take_lost(&mut self) -> Vec<RecordError> {
        std::mem::take(&mut self.lost)
    }

    fn tell_onlookers(&mut self, mut tell: impl FnMut(&mut dyn Recorder) -> Result<(), RecordError>) {
        let lost = &mut self.lost;
        self.onlookers.retain_mut(|onlooker| tell(onlooker.as_mut()).map_err(|error| lost.push(error)).is_ok());
    }
}

impl Recorder for Fanout {
    fn sample(&mut self, sample: &Sample) -> Result<(), RecordError> {
        if let Some(recorder) = &mut self.recorder {
            recorder.sample(sample)?;
        }
        self.tell_onlookers(|onlooker| onlooker.sample(sample));
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), RecordError> {
        if let Some(recorder) = &mut self.recorder {
            recorder.event(event)?;
        }
        self.tell_onlookers(|onlooker| onlooker.event(event));
        Ok(())
    }

    fn contacts(&mut self, time: f64, contacts: &[ContactPush]) -> Result<(), RecordError> {
        if let Some(recorder) = &mut self.recorder {
            recorder.contacts(time, contacts)?;
        }
        self.tell_onlookers(|onlooker| onlooker.contacts(time, contacts));
        Ok(())
    }

    fn pause(&mut self) -> Result<(), RecordError> {
        if let Some(recorder) = &mut self.recorder {
            recorder.pause()?;
        }
        self.tell_onlookers(|onlooker| onlooker.pause());
        Ok(())
    }

    fn finish(&mut self, outcome: &Outcome) -> Result<(), RecordError> {
        let finished = self.recorder.as_mut().map_or(Ok(()), |recorder| recorder.finish(outcome));
        self.tell_onlookers(|onlooker| onlooker.finish(outcome));
        finished
    }
}
