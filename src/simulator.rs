//! A scene that is stepped from outside: it goes on as far as it is told to, and its inputs may change in between.
//!
//! Each step is a run of [`simulate`] that goes on where the last one ended, with its stops, events and controllers. What is
//! kept between two of them is one [`Snapshot`], so that going back to one and on again gives the same bits.

use crate::integrate::Method;
use crate::model::Model;
use crate::record::{Fanout, Outcome, RecordError, Recorder, Sample};
use crate::simulate::events::Occurrence;
use crate::simulate::{self, Resume, RunError, Settings, State, Summary};
use std::sync::Arc;

/// Where a simulator is: all that its next step follows from.
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshot {
    /// Time (s).
    pub time: f64,
    /// Hinge positions and velocities.
    pub state: State,
    /// In the order of [`Model::inputs`] (N or N m).
    pub inputs: Vec<f64>,
    /// What each controller remembers, in the order of the model.
    pub memories: Vec<Vec<f64>>,
    /// How the last step ended; `None` at the start, and after a change from outside.
    pub resume: Option<Resume>,
    /// The event that ended the run.
    pub stopped_by: Option<String>,
}

/// A scene at a time.
#[derive(Debug, Clone)]
pub struct Simulator {
    model: Arc<Model>,
    settings: Settings,
    now: Snapshot,
    events: Vec<Occurrence>,
    /// The outputs here, once they are known.
    outputs: Option<Vec<f64>>,
}

/// A snapshot of another scene: the numbers of its positions, velocities, inputs or memories differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("this is the state of another scene")]
pub struct AnotherScene;

impl Simulator {
    /// A model at a state, at the time at which its settings begin; their duration is of no account.
    pub fn new(model: Arc<Model>, settings: Settings, start: State) -> Self {
        let now = Snapshot {
            time: settings.begin(),
            state: start,
            inputs: model.inputs.iter().map(|motor| model.motors[*motor].given().unwrap_or(0.0)).collect(),
            memories: model.controllers.iter().map(|one| one.memory().to_vec()).collect(),
            resume: None,
            stopped_by: None,
        };
        Self { model, settings, now, events: Vec::new(), outputs: None }
    }

    /// Puts its clock at a time (s) before the first step.
    pub fn begin(&mut self, time: f64) {
        (self.now.time, self.now.resume, self.outputs) = (time, None, None);
    }

    /// The model as it was at the start.
    pub fn model(&self) -> &Arc<Model> {
        &self.model
    }

    /// Where it is.
    pub fn snapshot(&self) -> &Snapshot {
        &self.now
    }

    /// What has happened so far, in order of time.
    pub fn events(&self) -> &[Occurrence] {
        &self.events
    }

    /// Goes on to a later time (s), or to the event that ends the run. `go_on` is asked after every step of the method; `false`
    /// ends it there. A step that fails leaves everything as it was.
    ///
    /// # Errors
    /// As [`simulate::run`].
    pub fn advance(&mut self, until: f64, go_on: &dyn Fn() -> bool) -> Result<(), RunError> {
        if self.model.stages.is_some() {
            return Err(RunError::Stages("a simulator that is stepped has one structure; `run` goes through all"));
        }
        let duration = until - self.now.time;
        let done = self.run(duration, &mut Fanout::new(), &mut || go_on())?;
        self.now = Snapshot {
            time: done.end_time,
            state: done.state,
            inputs: done.inputs,
            memories: done.memories,
            resume: Some(done.resume),
            stopped_by: done.stopped_by,
        };
        self.events.extend(done.events);
        self.outputs = Some(done.outputs);
        Ok(())
    }

    /// A run from here; nothing is kept of it.
    fn run(
        &self,
        duration: f64,
        recorder: &mut dyn Recorder,
        go_on: &mut dyn FnMut() -> bool,
    ) -> Result<Summary, RunError> {
        // The method of one that has not stepped yet is its settings'.
        let first = Resume { time: self.now.time, method: Method::Rk4, step: None, grid: None, mode: None };
        let resume = Some(self.now.resume.clone().unwrap_or(first));
        let settings = Settings { duration, resume, ..self.settings.clone() };
        let model = Arc::new(self.model.continued(&self.now.inputs, &self.now.memories));
        simulate::run(&model, &settings, 0.5 / duration, &self.now.state, recorder, &mut |_, _| go_on())
    }

    /// The outputs here, in the order of the model: those of the last step or, if something was changed since then, those of the
    /// first sample of a run from here. Energies that were put in or taken out count from the last step.
    ///
    /// # Errors
    /// As [`simulate::run`].
    pub fn outputs(&mut self) -> Result<&[f64], RunError> {
        if self.outputs.is_none() {
            let mut first = FirstOutputs(None);
            if !self.model.outputs.is_empty() {
                self.run(self.settings.duration, &mut first, &mut || false)?;
            }
            self.outputs = Some(first.0.unwrap_or_default());
        }
        Ok(self.outputs.as_deref().unwrap_or_default())
    }

    /// Sets all inputs, in the order of the model (N or N m; finite).
    pub fn set_inputs(&mut self, inputs: &[f64]) {
        if self.now.inputs != inputs {
            self.now.inputs.copy_from_slice(inputs);
            self.outputs = None;
            // What rests may not do so any more.
            if let Some(resume) = &mut self.now.resume {
                resume.mode = resume.mode.take().map(|mode| Arc::new(Arc::unwrap_or_clone(mode).awake()));
            }
        }
    }

    /// Puts it elsewhere: where it has been before, or at a state from outside. What has happened so far stays told.
    ///
    /// # Errors
    /// If the numbers of the snapshot do not fit the model.
    pub fn place(&mut self, snapshot: Snapshot) -> Result<(), AnotherScene> {
        let lengths = |now: &Snapshot| {
            let memories: Vec<usize> = now.memories.iter().map(Vec::len).collect();
            (now.state.position.len(), now.state.velocity.len(), now.inputs.len(), memories)
        };
        if lengths(&snapshot) != lengths(&self.now) {
            return Err(AnotherScene);
        }
        (self.now, self.outputs) = (snapshot, None);
        Ok(())
    }

    /// As [`place`](Self::place), back in time: events after it have not happened.
    ///
    /// # Errors
    /// As [`place`](Self::place).
    pub fn restore(&mut self, snapshot: Snapshot) -> Result<(), AnotherScene> {
        let time = snapshot.time;
        self.place(snapshot)?;
        self.events.retain(|event| event.time <= time);
        Ok(())
    }
}

/// Keeps the outputs of the first sample.
struct FirstOutputs(Option<Vec<f64>>);

impl Recorder for FirstOutputs {
    fn sample(&mut self, sample: &Sample) -> Result<(), RecordError> {
        self.0.get_or_insert_with(|| sample.outputs.to_vec());
        Ok(())
    }

    fn finish(&mut self, _outcome: &Outcome) -> Result<(), RecordError> {
        Ok(())
    }
}
