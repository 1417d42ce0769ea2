//! `run`: find the start, simulate, record.

use super::inputs::Inputs;
use super::output::{Interrupt, Progress};
use super::recording::{Viewers, add_viewer, keep_complete, recording_file, recording_path};
use super::storm::Storm;
use super::{Common, Exit, json, output, scene, statics, text};
use crate::model::Model;
use crate::model::description::BodyDescription;
use crate::record::{Fanout, Opening, Outcome, Recorder};
use crate::scenario::{Scenario, start};
use crate::simulate::verify::{Verified, verify};
use crate::simulate::{self, RunError, Start, State, Summary};
use clap::Args;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::sync::Arc;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    /// Start at the pose, velocities and inputs of this file, as `statics --save` writes it; or go on where a run ended,
    /// as `--save-end` writes it
    #[arg(long, value_name = "START.toml")]
    start: Option<PathBuf>,
    /// Write the state at the end there, for `--start`: the run can go on from it
    #[arg(long, value_name = "START.toml")]
    save_end: Option<PathBuf>,
    /// Where the recording goes; default: the scenario's name with .mcap in this folder
    #[arg(long, short = 'o', value_name = "PATH")]
    out: Option<PathBuf>,
    /// Run once more, tighter and by another method, and say what the run is wrong by at its end
    #[arg(long)]
    verify: bool,
    /// Print all of the equilibrium, as `statics` does, not one line of it
    #[arg(long, short)]
    verbose: bool,
    #[command(flatten)]
    viewers: Viewers,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let common = &arguments.common;
    let (mut scenario, mut model) = match scene::load_at(common, arguments.start.as_deref())? {
        Ok(loaded) => loaded,
        Err(exit) => return Ok(exit),
    };
    // A file without velocities is a start at rest, and the method is chosen for that.
    let moves = model.start_velocity.iter().any(|v| *v != 0.0);
    if arguments.start.is_some() {
        let given = moves || scenario.simulate.resume.is_some();
        scenario.simulate.start = if given { Start::Given } else { Start::Equilibrium };
    }
    if let Some(from) = arguments.start.as_deref().filter(|_| moves && scenario.simulate.resume.is_none())
        && let Some(problem) = simulate::check_given(&model, &scenario.description).first()
    {
        anyhow::bail!("{}: {problem}", from.display());
    }
    if model.stages.is_some() && (arguments.save_end.is_some() || arguments.start.is_some()) {
        anyhow::bail!(
            "{}: a scene with stages begins at t = 0 and goes to its end: leave out `--start` and `--save-end`",
            scenario.name
        );
    }
    let interrupt = Interrupt::install()?;
    let path = recording_path(arguments.out.as_deref(), &common.scenario);
    let inputs = Inputs::of_scenario(common, &scenario, arguments.start.as_deref());
    inputs.spare(&path)?;
    arguments.viewers.rrd().iter().chain(&arguments.save_end).try_for_each(|written| inputs.spare(written))?;
    let file = recording_file(&path, common.quiet)?.with_ros(scenario.record.ros);
    if !common.json && !common.quiet {
        output::announce(&text::heading(&model, &scenario.name));
    }
    let from_file = || Some((given(&model), json!(GIVEN)));
    let started = if arguments.start.is_some() {
        from_file()
    } else {
        start(common, &mut scenario, &mut model, arguments.verbose)?
    };
    let Some((start, found)) = started else { return Ok(Exit::No) };
    simulate::check(&model, &scenario.simulate, &start)?;

    let still = simulate::scene(&model);
    let found_text = found.to_string();
    let opening =
        Opening { scene: &still, scenario: &scenario.text, statics: found.is_object().then_some(found_text.as_str()) };
    let mut recorder = Fanout::new().recorder(file.begin(&opening)?);
    if !common.quiet {
        let begin = scenario.simulate.begin();
        recorder = recorder.onlooker(Storm::new(begin, begin + scenario.simulate.duration));
    }
    for sink in arguments.viewers.sinks() {
        recorder = add_viewer(recorder, &sink, &opening, common.quiet)?;
    }
    let run = Run {
        common,
        scenario: &scenario,
        model: &model,
        path: &path,
        from: arguments.start.as_deref(),
        save_end: arguments.save_end.as_deref(),
        verify: arguments.verify,
        interrupt,
    };
    run.go(&start, found, recorder)
}

/// What is said of a start that is not searched for.
pub(super) const GIVEN: &str = "given";

/// The state to start from and what is said of it in JSON; `None` if there is no equilibrium to start from. On a terminal all that
/// statics says of it if `verbose`, else one line.
pub(super) fn start(
    common: &Common,
    scenario: &mut Scenario,
    model: &mut Arc<Model>,
    verbose: bool,
) -> anyhow::Result<Option<(State, Value)>> {
    if scenario.simulate.start == Start::Given {
        return Ok(Some((given(model), json!(GIVEN))));
    }
    let (found, wall) = statics::find(scenario, model)?;
    let (value, _) = statics::told(scenario, model, &found, wall)?;
    if !common.json && !common.quiet {
        output::announce(&text::equilibrium(model, &found, &scenario.unknown, wall, verbose));
    }
    if !found.converged {
        if common.json {
            output::print(&json!({ "scenario": scenario.name, "start": value }).to_string())?;
        }
        let moves = "; `simulate.start = \"given\"` lets it move from where it is";
        let hint = if model.contacts.is_empty() { "" } else { moves };
        output::warning(&format!("nothing was simulated: there is no equilibrium to start from (see above){hint}"));
        return Ok(None);
    }
    if found.stability.as_ref().is_some_and(|s| s.unstable_directions > 0) && !common.quiet {
        output::warning("the run starts on an unstable equilibrium: it stays there until something disturbs it");
    }
    // Those of the model follow also from drives.
    let gives = |body: &BodyDescription| body.hinge.velocity.iter().any(|v| *v != 0.0);
    if scenario.description.bodies.iter().any(gives) && !common.quiet {
        output::warning("the scenario gives velocities, but the run starts at rest; use `start = \"given\"` for them");
    }
    for (name, force) in found.holding.iter().filter(|(_, force)| force.abs() > 1e-9) {
        if !common.quiet {
            output::warning(&format!(
                "the lock of {name} held {}; it is released at the start of the run",
                text::borne(model, name, *force)
            ));
        }
    }
    Ok(Some((State { position: found.position, velocity: found.velocity }, value)))
}

fn given(model: &Model) -> State {
    State { position: model.start_position.clone(), velocity: model.start_velocity.clone() }
}

struct Run<'a> {
    common: &'a Common,
    scenario: &'a Scenario,
    model: &'a Arc<Model>,
    path: &'a Path,
    /// The start file.
    from: Option<&'a Path>,
    /// Where the state at the end goes.
    save_end: Option<&'a Path>,
    /// Run again to see what the run is wrong by.
    verify: bool,
    interrupt: Interrupt,
}

impl Run<'_> {
    fn go(&self, start: &State, found: Value, mut recorder: Fanout) -> anyhow::Result<Exit> {
        let settings = &self.scenario.simulate;
        let outcome = {
            let mut progress =
                Progress::new(settings.begin() + settings.duration, self.common.quiet || self.common.json);
            let mut go_on = |time: f64, _: &State| {
                progress.at(time);
                !self.interrupt.requested()
            };
            simulate::run(self.model, settings, self.scenario.record.rate, start, &mut recorder, &mut go_on)
        };
        let path = self.path.display().to_string();
        let summary = match outcome {
            Ok(summary) => summary,
            Err(RunError::Record(error)) => return Err(error.into()),
            Err(error) => {
                let summary = json!({ "scenario": self.scenario.name, "error": error.to_string() });
                keep_complete(self.path, self.common.quiet)?;
                recorder.finish(&Outcome { summary: summary.to_string() })?;
                if self.common.json {
                    output::print(&summary.to_string())?;
                }
                output::error(&anyhow::Error::new(error));
                output::note(&format!("what was simulated until then is in {path}"));
                return Ok(Exit::No);
            }
        };
        let mut result = json::run(&self.scenario.name, &path, found, &summary);
        if let Some(from) = self.from {
            result["start_file"] = json!(from.display().to_string());
        }
        let verified = match self.verify && !summary.interrupted {
            true => self.verify(start, &summary)?,
            false => None,
        };
        if let Some(verified) = &verified {
            result["verified"] = json::verified(verified);
        }
        if let Some(path) = self.save_end {
            let unknown = self.scenario.unknown.iter();
            let found = unknown.map(|one| (one.address.clone(), one.value(&self.scenario.description)));
            let is_unknown = |address: &str| self.scenario.unknown.iter().any(|one| one.address == address);
            let given = self.scenario.given.iter().filter(|(address, _)| !is_unknown(address)).cloned();
            let motor = |index: &usize| format!("{}.force", self.model.motors[*index].name);
            let set = self.model.inputs.iter().map(motor).zip(summary.inputs.iter().copied());
            let is_set = |address: &str| self.model.inputs.iter().any(|index| motor(index) == *address);
            let others = found.chain(given).filter(|(address, _)| !is_set(address));
            let inputs: Vec<(String, f64)> = others.chain(set).collect();
            let text = start::text_at_end(self.model, &summary.resume, &summary.state, &inputs, &summary.memories);
            output::save(path, text.as_bytes())?;
            result["end_file"] = json!(path.display().to_string());
        }
        if summary.interrupted {
            keep_complete(self.path, self.common.quiet)?;
        }
        recorder.finish(&Outcome { summary: result.to_string() })?;
        for lost in recorder.take_lost() {
            output::warning(&format!("{lost}\nthe recording is not affected"));
        }
        if self.common.json {
            output::print(&result.to_string())?;
        } else if !self.common.quiet {
            output::print(&text::run(&summary.model, &summary, &path))?;
            text::outputs(&summary.model, &summary.outputs).map_or(Ok(()), |table| output::print(&table))?;
            if let Some(verified) = &verified {
                output::print(&text::verified(verified))?;
            }
        }
        Ok(if summary.interrupted { Exit::Interrupted } else { Exit::Done })
    }

    /// The second run; one that cannot be made is said, and the first stays as it is.
    fn verify(&self, start: &State, first: &Summary) -> anyhow::Result<Option<Verified>> {
        let settings = &self.scenario.simulate;
        let mut progress = Progress::new(settings.begin() + settings.duration, self.common.quiet || self.common.json);
        let mut go_on = |time: f64| {
            progress.at(time);
            !self.interrupt.requested()
        };
        match verify(self.model, settings, start, first, &mut go_on) {
            Ok(verified) => Ok(verified),
            Err(RunError::Record(error)) => Err(error.into()),
            Err(error) => {
                output::warning(&format!("the run could not be verified: {error}"));
                Ok(None)
            }
        }
    }
}
