//! Samples kept in memory, for tests and reports.

use super::{ContactInstants, ContactPush, Event, Opening, Outcome, OwnedSample, RecordError, Recorder, Sample, Scene};
use std::sync::Arc;

/// Keeps everything it is given.
#[derive(Debug, Clone, PartialEq)]
pub struct Memory {
    /// The still part.
    pub scene: Scene,
    /// In the order they came.
    pub samples: Vec<OwnedSample>,
    /// In the order they came.
    pub events: Vec<Event>,
    /// Of scenes with contact: times of samples (s), and what contacts push with then, one and the same list where nothing has changed.
    pub contacts: ContactInstants,
    /// Once finished.
    pub outcome: Option<Outcome>,
}

impl Memory {
    /// An empty recording of the scene.
    pub fn new(opening: &Opening) -> Self {
        Self {
            scene: opening.scene.clone(),
            samples: Vec::new(),
            events: Vec::new(),
            contacts: Vec::new(),
            outcome: None,
        }
    }
}

impl Recorder for Memory {
    fn sample(&mut self, sample: &Sample) -> Result<(), RecordError> {
        sample.check(&self.scene)?;
        self.samples.push(sample.to_owned());
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), RecordError> {
        self.events.push(event.clone());
        Ok(())
    }

    fn contacts(&mut self, time: f64, contacts: &[ContactPush]) -> Result<(), RecordError> {
        let same = self.contacts.last().filter(|(_, last)| **last == contacts);
        let pushes = same.map_or_else(|| Arc::new(contacts.to_vec()), |(_, last)| Arc::clone(last));
        self.contacts.push((time, pushes));
        Ok(())
    }

    fn finish(&mut self, outcome: &Outcome) -> Result<(), RecordError> {
        self.outcome.get_or_insert_with(|| outcome.clone());
        Ok(())
    }
}
