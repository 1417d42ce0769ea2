//! What a report is made of: from a recording, or from a scenario that is run.

use super::super::inputs::Inputs;
use super::super::output::{Interrupt, Progress};
use super::super::recording::add_viewer;
use super::super::samples;
use super::super::{Common, Exit, json, output, poses, scene, statics};
use crate::import::Taken;
use crate::model::Model;
use crate::record::gltf::Clip;
use crate::record::view::Sink;
use crate::record::{
    Energy, Event, Fanout, Footage, Memory, Opening, Outcome, OwnedSample, Recorder, Recording, Scene, Tubes,
};
use crate::scenario::{self, Scenario};
use crate::simulate::verify::verify;
use crate::simulate::{self, RunError, Start, State};
use crate::spatial::Wrench;
use serde_json::{Value, json};
use std::path::Path;
use std::sync::Arc;

/// Everything that a report says.
pub(in crate::cli) struct Material {
    /// Name of the source, without folder and extension.
    pub(in crate::cli) name: String,
    pub(in crate::cli) scene: Scene,
    /// The scenario, word for word.
    pub(in crate::cli) scenario: String,
    /// Version of the program that computed it.
    pub(in crate::cli) version: String,
    /// What the page says it was made by; `None` for the words of the command line.
    pub(in crate::cli) called: Option<String>,
    /// What `statics --json` says; null if nothing was looked for.
    pub(in crate::cli) statics: Value,
    /// What `run --json` says; null without a run.
    pub(in crate::cli) outcome: Value,
    /// Of the run.
    pub(in crate::cli) samples: Vec<OwnedSample>,
    /// Without a run the pose that was found, at rest, without what couplings and outputs say of it.
    still: Option<OwnedSample>,
    pub(in crate::cli) events: Vec<Event>,
    /// Modes, and motions of recordings that hold no run.
    pub(in crate::cli) clips: Vec<Clip>,
    /// What importers ignored or approximated, one line each.
    pub(in crate::cli) ignored: Vec<String>,
    /// What is left out, in words.
    pub(in crate::cli) notes: Vec<String>,
    pub(in crate::cli) exit: Exit,
    /// The files that it was made of.
    pub(in crate::cli) inputs: Inputs,
}

fn stem(path: &Path) -> String {
    path.file_stem().filter(|stem| *stem != "-").unwrap_or("report".as_ref()).to_string_lossy().into_owned()
}

impl Material {
    pub(in crate::cli) fn of_recording(path: &Path, meshes: bool, quiet: bool) -> anyhow::Result<Self> {
        let footage = Footage::open(path, meshes)?;
        samples::warn_if_cut(&footage.recording, quiet);
        let parse = |text: &Option<String>| -> Value {
            text.as_deref().and_then(|text| serde_json::from_str(text).ok()).unwrap_or_default()
        };
        let recording = &footage.recording;
        let (statics, outcome) = (parse(&recording.statics), parse(&recording.outcome));
        let is_run = outcome["modes"].is_null() && outcome["iterates"].is_null();
        let mut kept = Vec::new();
        let mut notes = footage.notes.clone();
        if is_run {
            samples::each(recording, |sample| {
                kept.push(sample.clone());
                Ok(())
            })?;
        }
        let clips = if is_run { modes_again(recording, &statics) } else { footage.clips()? };
        if clips.is_empty() && statics["modes"].as_array().is_some_and(|modes| !modes.is_empty()) {
            notes.push(
                "the modes do not play: the recording does not hold all that they follow from; `stillpoint report` of the scenario shows \
                 them"
                    .to_owned(),
            );
        }
        if !recording.complete {
            notes.push(format!("the recording is {}: this is what was kept of it", recording.ending().name()));
        }
        Ok(Self {
            called: None,
            name: stem(path),
            scene: recording.scene.clone(),
            scenario: recording.scenario.clone(),
            version: recording.version.clone(),
            clips,
            events: recording.events()?,
            statics,
            outcome,
            samples: kept,
            still: None,
            ignored: Vec::new(),
            notes,
            exit: Exit::Done,
            inputs: Inputs::new([path]),
        })
    }

    pub(in crate::cli) fn of_scenario(
        common: &Common,
        only_statics: bool,
        verified: bool,
    ) -> anyhow::Result<Result<Self, Exit>> {
        let (mut scenario, mut model) = match scene::load(common)? {
            Ok(loaded) => loaded,
            Err(exit) => return Ok(Err(exit)),
        };
        let interrupt = Interrupt::install()?;
        let given = scenario.simulate.start == Start::Given && !only_statics;
        let found = if given { None } else { Some(statics::find(&mut scenario, &mut model)?) };
        let told = found.as_ref().map(|(found, wall)| statics::told(&scenario, &model, found, *wall)).transpose()?;
        let state = match &found {
            None => Some(State { position: model.start_position.clone(), velocity: model.start_velocity.clone() }),
            Some((found, _)) if found.converged => {
                Some(State { position: found.position.clone(), velocity: found.velocity.clone() })
            }
            Some(_) => None,
        };
        let mut material = Self {
            called: None,
            name: stem(&common.scenario),
            scene: simulate::scene(&model),
            scenario: scenario.text.clone(),
            version: env!("CARGO_PKG_VERSION").to_owned(),
            statics: told.map_or(Value::Null, |(value, _)| value),
            outcome: Value::Null,
            samples: Vec::new(),
            still: None,
            events: Vec::new(),
            clips: found
                .as_ref()
                .filter(|(found, _)| found.balanced)
                .map_or(Vec::new(), |(found, _)| poses::mode_clips(&model, found)),
            ignored: ignored(&scenario),
            notes: Vec::new(),
            inputs: Inputs::of_scenario(common, &scenario, None),
            exit: if state.is_some() { Exit::Done } else { Exit::No },
        };
        match state {
            Some(state) if !only_statics => material.run(common, &scenario, &model, &state, verified, &interrupt)?,
            _ => {
                let q = found.as_ref().map_or(&model.start_position, |(found, _)| &found.position);
                let reactions =
                    found.as_ref().filter(|(found, _)| found.balanced).map(|(found, _)| &found.reactions[..]);
                material.stand(&model, q, reactions);
            }
        }
        Ok(Ok(material))
    }

    /// The run and its samples.
    fn run(
        &mut self,
        common: &Common,
        scenario: &Scenario,
        model: &Arc<Model>,
        start: &State,
        verified: bool,
        interrupt: &Interrupt,
    ) -> anyhow::Result<()> {
        let settings = &scenario.simulate;
        let mut memory = Memory::new(&Opening { scene: &self.scene, scenario: &scenario.text, statics: None });
        let shown = || Progress::new(settings.begin() + settings.duration, common.quiet || common.json);
        let mut progress = shown();
        let mut go_on = |time: f64, _: &State| {
            progress.at(time);
            !interrupt.requested()
        };
        let ran = simulate::run(model, settings, scenario.record.rate, start, &mut memory, &mut go_on);
        drop(progress);
        (self.samples, self.events) = (memory.samples, memory.events);
        let summary = match ran {
            Ok(summary) => summary,
            Err(RunError::Record(error)) => return Err(error.into()),
            Err(error) => {
                self.outcome = json!({ "error": error.to_string() });
                self.exit = Exit::No;
                output::error(&anyhow::Error::new(error));
                return Ok(());
            }
        };
        self.outcome = json::run(&scenario.name, "", Value::Null, &summary);
        if verified && !summary.interrupted {
            let mut progress = shown();
            let mut go_on = |time: f64| {
                progress.at(time);
                !interrupt.requested()
            };
            match verify(model, settings, start, &summary, &mut go_on) {
                Ok(Some(found)) => self.outcome["verified"] = json::verified(&found),
                Ok(None) => {}
                Err(error) => self.notes.push(format!("the run could not be verified: {error}")),
            }
        }
        Ok(())
    }

    /// One pose alone, so that there is something to draw, with what hinges pass on if it balances.
    fn stand(&mut self, model: &Arc<Model>, q: &[f64], reactions: Option<&[Wrench]>) {
        let mut bodies = Vec::new();
        let rest = vec![0.0; model.velocity_count()];
        crate::dynamics::System::new(model).at(0.0, q, &rest).poses(&mut bodies);
        self.still = Some(OwnedSample {
            positions: q.to_vec(),
            velocities: rest.clone(),
            accelerations: rest,
            bodies: bodies.clone(),
            reactions: reactions.map_or_else(|| vec![Wrench::default(); bodies.len()], <[Wrench]>::to_vec),
            energy: Energy::default(),
            ..OwnedSample::default()
        });
        let tubes = Tubes::new(&self.scene);
        tubes.extend(q, &mut bodies);
        let known = reactions.filter(|_| !tubes.is_empty());
        let loads = known.map(|reactions| tubes.loads(&bodies, reactions)).into_iter().collect();
        self.clips.insert(0, Clip { name: "pose".to_owned(), times: vec![0.0], poses: vec![bodies], loads });
    }
}

impl Material {
    /// Sends the run, or the pose without one, to viewers: each time as a recording of its own.
    pub(in crate::cli) fn show(&self, sinks: &[Sink], quiet: bool) -> anyhow::Result<()> {
        let scene = match self.still {
            Some(_) => Scene { couplings: Vec::new(), outputs: Vec::new(), watched: false, ..self.scene.clone() },
            None => self.scene.clone(),
        };
        let statics = self.statics.to_string();
        let statics = self.statics.is_object().then_some(statics.as_str());
        let opening = Opening { scene: &scene, scenario: &self.scenario, statics };
        for sink in sinks {
            let mut recorder = add_viewer(Fanout::new(), sink, &opening, quiet)?;
            let mut events = self.events.iter().peekable();
            for sample in self.samples.iter().chain(&self.still) {
                while let Some(event) = events.next_if(|event| event.time <= sample.time) {
                    recorder.event(event)?;
                }
                recorder.sample(&sample.borrow())?;
            }
            events.try_for_each(|event| recorder.event(event))?;
            recorder.finish(&Outcome { summary: self.outcome.to_string() })?;
            recorder.take_lost().iter().for_each(|lost| output::warning(&lost.to_string()));
        }
        Ok(())
    }
}

/// How far the numbers of an equilibrium that is found again may be from those recorded, by another version of the program perhaps.
const AGAIN: f64 = 1e-6;

/// The modes of a run's start as motions, from the scenario that is recorded with it. None if that does not lead to the equilibrium
/// recorded: what was set beside the scenario, and the files that it names, are not in a recording.
fn modes_again(recording: &Recording, statics: &Value) -> Vec<Clip> {
    let modes = || -> Option<Vec<Clip>> {
        statics["modes"].as_array().filter(|modes| !modes.is_empty())?;
        let mut scenario = scenario::parse("scenario.toml", &recording.scenario, &[]).ok()?;
        let (mut model, _) = scenario.built.take()?;
        let (found, wall) = statics::find(&mut scenario, &mut model).ok()?;
        let (told, _) = statics::told(&scenario, &model, &found, wall).ok()?;
        let same = |key: &str| is_near(&told[key], &statics[key]);
        let is_it = found.balanced && same("positions") && same("bodies") && same("frequencies_hz");
        is_it.then(|| poses::mode_clips(&model, &found))
    };
    modes().unwrap_or_default()
}

/// Whether two values differ by round-off at most.
fn is_near(one: &Value, other: &Value) -> bool {
    match (one, other) {
        (Value::Object(one), Value::Object(other)) => {
            one.len() == other.len()
                && one.iter().all(|(key, one)| other.get(key).is_some_and(|other| is_near(one, other)))
        }
        (Value::Array(one), Value::Array(other)) => {
            one.len() == other.len() && one.iter().zip(other).all(|(one, other)| is_near(one, other))
        }
        (Value::Number(one), Value::Number(other)) => {
            let [one, other] = [one, other].map(|number| number.as_f64().unwrap_or(f64::NAN));
            (one - other).abs() <= AGAIN * (1.0 + one.abs())
        }
        (one, other) => one == other,
    }
}

fn ignored(scenario: &Scenario) -> Vec<String> {
    let notes = scenario.models.iter().flat_map(|model| &model.notes);
    let told = |note: &crate::import::Note| (note.verdict != Taken::Used).then(|| super::super::convert::line(note));
    notes.filter_map(told).collect()
}
