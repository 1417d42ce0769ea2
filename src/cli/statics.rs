//! `statics`: the equilibrium and what it is.

use super::inputs::Inputs;
use super::output::Interrupt;
use super::{Common, Exit, baselines, json, number, output, path, poses, recording, scene, sensitivity, text};
use crate::model::{Description, Model, Parameter};
use crate::scenario::{Scenario, start};
use crate::statics::{Equilibrium, Method, Observers, answer, equilibrium_observed, outputs, standing};
use crate::study::Axis;
use anyhow::Context;
use clap::Args;
use clap::builder::PossibleValuesParser;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    structure: scene::Structure,
    /// How to find it, whatever the file says
    #[arg(long, value_name = "NAME", value_parser = PossibleValuesParser::new(Method::ALL.map(Method::name)))]
    method: Option<String>,
    /// Find it by every method from the same guess, and print what each needed and how far their answers are apart
    #[arg(long, conflicts_with = "method")]
    compare: bool,
    /// With `--compare`: for several values of a number of the file, as `link.repeat=5,10,20`
    #[arg(long, value_name = "PATH=VALUES", requires = "compare", conflicts_with = "start", value_parser = Axis::parse)]
    over: Option<Axis>,
    /// Begin the search at the pose of this file, as `--save` writes it
    #[arg(long, value_name = "START.toml")]
    start: Option<PathBuf>,
    /// Write the equilibrium there, for `--start` of other commands; nothing where none is found
    #[arg(long, value_name = "START.toml", conflicts_with = "compare")]
    save: Option<PathBuf>,
    /// How these outputs answer to the numbers of the scene: derivatives of `[[output]]`s by their names, of `frequency[0]`, …
    #[arg(long, value_name = "OUTPUT", num_args = 1.., conflicts_with = "compare")]
    sensitivity: Vec<String>,
    /// With `--sensitivity`: by these numbers alone, as `spring.length` or `hinge.stiffness`
    #[arg(long, value_name = "ADDRESS", num_args = 1.., requires = "sensitivity")]
    parameter: Vec<String>,
    /// Record the mode shapes there, two seconds each, for `view`
    #[arg(long, value_name = "FILE.mcap", conflicts_with = "compare")]
    modes: Option<PathBuf>,
    /// Record how the scene gives way there, or would first with less friction: contact and dry friction alone, two seconds
    #[arg(long, value_name = "FILE.mcap", conflicts_with = "compare")]
    collapse: Option<PathBuf>,
    /// Record the poses of the search there, one per second, for `view`
    #[arg(long, value_name = "FILE.mcap", conflicts_with = "compare")]
    iterates: Option<PathBuf>,
    /// Draw what the beams bear over their arc length: forces, moments and stress as a plot (.svg) or a table (.csv)
    #[arg(long, value_name = "FILE.svg|csv", conflicts_with = "compare")]
    diagram: Option<PathBuf>,
    /// With `--diagram`: of these beams alone. Names with commas between them, `*` stands for anything
    #[arg(long, value_name = "BEAMS", value_delimiter = ',', requires = "diagram")]
    beams: Vec<String>,
    #[command(flatten)]
    viewers: recording::Viewers,
    /// Write the result there as JSON; with `--compare` table and plot, as PATH.csv, .json and .svg. If the file has
    /// `[statics.path]`: beginning of the names PATH.path.csv, .svg and .mcap; default: the scenario's name
    #[arg(long, short = 'o', value_name = "PATH")]
    out: Option<PathBuf>,
    /// As of `run` and `rest`, which print all of the equilibrium then: here it is always all
    #[arg(long, short, hide = true)]
    verbose: bool,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let common = &arguments.common;
    if let Some(change) = &arguments.over {
        return baselines::over(common, change, arguments.out.as_deref());
    }
    let (mut scenario, mut model) =
        match scene::load_structure(common, &arguments.structure, arguments.start.as_deref())? {
            Ok(loaded) => loaded,
            Err(exit) => return Ok(exit),
        };
    if let Some(why) = arguments.ignored().filter(|_| standing::is_for(&model)) {
        anyhow::bail!(
            "{}: `{why}` knows neither contact nor dry friction: leave it out, or take them out",
            scenario.name
        );
    }
    if let Some(name) = &arguments.method {
        let named = Method::ALL.into_iter().find(|method| method.name() == name);
        scenario.statics.method = named.unwrap_or_default();
    }
    if arguments.compare {
        return baselines::main(&scenario, &model, common, arguments.out.as_deref());
    }
    let read = Inputs::of_scenario(common, &scenario, arguments.start.as_deref());
    let Arguments { save, modes, collapse, iterates, out, diagram, .. } = arguments;
    let written = [save, modes, collapse, iterates, out, diagram, arguments.viewers.rrd()];
    written.into_iter().flatten().try_for_each(|output| read.spare(output))?;
    let sinks = arguments.viewers.sinks();
    let watched = arguments.iterates.is_some() || !sinks.is_empty();
    let mut trail = Vec::new();
    let (found, wall) = find_watched(&mut scenario, &mut model, watched.then_some(&mut trail))?;
    let (mut result, asked) = told(&scenario, &model, &found, wall)?;
    if !common.json && !common.quiet {
        output::print(&text::heading(&model, &scenario.name))?;
        output::print(&text::statics(&model, &found, &scenario.unknown, wall))?;
        super::beams::found(&model, &found)?.map_or(Ok(()), |beams| output::print(&beams))?;
        super::modals::text(&model, &found.position, &found.poses).map_or(Ok(()), |modals| output::print(&modals))?;
        text::outputs(&model, &asked).map_or(Ok(()), |table| output::print(&table))?;
    }
    arguments.tell_sensitivities(&scenario, &model, &found, &mut result)?;
    let path = scenario.path.as_ref();
    let followed =
        path.map(|path| path::main(&scenario, path, &model, common, arguments.out.as_deref())).transpose()?;
    if let Some(followed) = &followed {
        result["path"] = followed.json(&model);
    } else if let Some(path) = &arguments.out {
        output::save(path, format!("{result:#}\n").as_bytes())?;
    }
    if watched {
        let outlets = (arguments.iterates.as_deref(), &sinks[..]);
        result["iterates"] = poses::iterates(common, &scenario, &model, &found, trail, outlets)?.into();
    }
    let moves = found.stability.as_ref().is_some_and(|stability| !stability.modes.is_empty());
    if let Some(path) = arguments.modes.as_deref()
        && !(found.balanced && moves)
    {
        let why = if found.balanced { "nothing is free to move" } else { "there is no equilibrium" };
        output::warning(&format!("no modes to record in `{}`: {why}", path.display()));
    } else if let Some(path) = arguments.modes.as_deref() {
        let shown = poses::modes(common, &scenario, &model, &found, path)?;
        if !common.json && !common.quiet {
            let modes = number::count(shown, "mode", "modes");
            output::print(&format!("  recording    {} ({modes}, two seconds each)", path.display()))?;
        }
    }
    if let Some(path) = &arguments.collapse {
        arguments.record_collapse(&scenario, &model, &found, path)?;
    }
    arguments.draw_diagram(&scenario, &model, &found)?;
    arguments.save_start(&scenario, &model, &found)?;
    if common.json {
        output::print(&serde_json::to_string(&result)?)?;
    } else if let Some(followed) = followed.as_ref().filter(|_| !common.quiet) {
        output::print(&followed.text())?;
    }
    let complete = followed.is_none_or(|followed| followed.path.complete);
    Ok(match (found.converged && complete, Interrupt::install()?.requested()) {
        (true, _) => Exit::Done,
        (false, true) => Exit::Interrupted,
        (false, false) => Exit::No,
    })
}

impl Arguments {
    /// The recording of how the scene gives way.
    fn record_collapse(
        &self,
        scenario: &Scenario,
        model: &Arc<Model>,
        found: &Equilibrium,
        path: &Path,
    ) -> anyhow::Result<()> {
        let common = &self.common;
        match poses::collapse(common, scenario, model, found, path)? {
            Some(said) if !common.json && !common.quiet => {
                output::print(&format!("  recording    {} (two seconds: {said})", path.display()))
            }
            Some(_) => Ok(()),
            None => {
                let why = match &found.standing {
                    None => "the scene has neither contact nor dry friction",
                    Some(_) => "no friction has to hold it",
                };
                output::warning(&format!("no collapse to record in `{}`: {why}", path.display()));
                Ok(())
            }
        }
    }

    /// The diagrams that are asked for; of what does not balance there are none.
    fn draw_diagram(&self, scenario: &Scenario, model: &Arc<Model>, found: &Equilibrium) -> anyhow::Result<()> {
        let Some(path) = &self.diagram else { return Ok(()) };
        if !found.balanced {
            output::warning(&format!("no diagram in `{}`: there is no equilibrium", path.display()));
            return Ok(());
        }
        let title = if model.title.is_empty() { &scenario.name } else { &model.title };
        let beams = super::beams::diagram::write(model, found, path, &self.beams, title)?;
        if self.common.json || self.common.quiet {
            return Ok(());
        }
        let beams = number::count(beams, "beam", "beams");
        output::print(&format!("  diagram      {} ({beams})", path.display()))
    }

    /// The start file that is asked for.
    fn save_start(&self, scenario: &Scenario, model: &Model, found: &Equilibrium) -> anyhow::Result<()> {
        let Some(path) = &self.save else { return Ok(()) };
        if !found.converged {
            let path = path.display();
            output::warning(&format!("`{path}` is not written: this is not the equilibrium that was asked for"));
            return Ok(());
        }
        let inputs = inputs(&scenario.description, found);
        let text = start::text(model, &found.position, &found.velocity, &inputs, &found.carried);
        output::save(path, text.as_bytes())
    }

    /// The sensitivities that are asked for, on the terminal and in the result.
    fn tell_sensitivities(
        &self,
        scenario: &Scenario,
        model: &Arc<Model>,
        found: &Equilibrium,
        result: &mut Value,
    ) -> anyhow::Result<()> {
        if self.sensitivity.is_empty() {
            return Ok(());
        }
        if !found.balanced {
            output::warning("no sensitivities: there is no equilibrium");
            return Ok(());
        }
        let interrupt = Interrupt::install()?;
        let (asked, by, go_on) = (&self.sensitivity, &self.parameter, || !interrupt.requested());
        let table = sensitivity::of(&scenario.description, model, found, asked, by, &go_on);
        let table = table.with_context(|| scenario.name.clone())?;
        result["sensitivities"] = sensitivity::json(&table);
        if let Some(notes) = result["notes"].as_array_mut() {
            notes.extend(table.notes.iter().map(|note| note.as_str().into()));
        }
        if self.common.json || self.common.quiet { Ok(()) } else { output::print(&sensitivity::text(&table)) }
    }

    /// What asks for methods that search without contact and dry friction.
    fn ignored(&self) -> Option<&'static str> {
        let method = self.method.as_ref().map(|_| "--method");
        if self.compare { Some("--compare") } else { method }
    }
}

/// The equilibrium and the time it took. Where inputs are unknown, scene and model get those that were found.
pub(super) fn find(scenario: &mut Scenario, model: &mut Arc<Model>) -> anyhow::Result<(Equilibrium, Duration)> {
    find_watched(scenario, model, None)
}

/// Finds the equilibrium; the poses of the search go to `trail`.
fn find_watched(
    scenario: &mut Scenario,
    model: &mut Arc<Model>,
    trail: Option<&mut Vec<Vec<f64>>>,
) -> anyhow::Result<(Equilibrium, Duration)> {
    let before = Instant::now();
    let context = || format!("{}: statics cannot start", scenario.name);
    let interrupt = Interrupt::install()?;
    let go_on = || !interrupt.requested();
    if let Some(trail) = trail.filter(|_| scenario.unknown.is_empty() && !standing::is_for(model)) {
        let observers = Observers { go_on: Some(&go_on), trail: Some(trail), ..Observers::default() };
        let found = equilibrium_observed(model, &scenario.statics, &model.start_position, observers);
        return Ok((found.with_context(context)?, before.elapsed()));
    }
    let description = scenario.description.clone();
    let held = answer(description, model.clone(), scenario.sought(), &scenario.statics, &scenario.margin, &go_on)
        .with_context(context)?;
    (scenario.description, *model) = (held.description, held.model);
    Ok((held.found, before.elapsed()))
}

/// The equilibrium as JSON, and its outputs.
pub(super) fn told(
    scenario: &Scenario,
    model: &Arc<Model>,
    found: &Equilibrium,
    wall: Duration,
) -> anyhow::Result<(Value, Vec<f64>)> {
    let mut value = json::statics(model, found, wall.as_secs_f64());
    let asked = outputs(model, found).with_context(|| scenario.name.clone())?;
    value["outputs"] = json::outputs(model, &asked);
    Ok((value, asked))
}

/// What holds the pose besides the scenario file: motor forces that are not zero, and what was unknown.
fn inputs(description: &Description, found: &Equilibrium) -> Vec<(String, f64)> {
    let motors = Parameter::find(description, "hinge.force").unwrap_or_default();
    let motors = motors.iter().map(|one| (one.address.clone(), one.value(description)));
    let other = |(address, force): &(String, f64)| {
        *force != 0.0 && !found.unknowns.iter().any(|(unknown, _)| unknown == address)
    };
    motors.filter(other).chain(found.unknowns.iter().cloned()).collect()
}
