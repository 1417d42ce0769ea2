//! Loading a scenario for a command: everything that is wrong is said here, once.

use super::output::Interrupt;
use super::{Common, Exit, output, text};
use crate::constraint::{self, Assembly};
use crate::dynamics::System;
use crate::model::problem::number;
use crate::model::{Model, Problem};
use crate::scenario::{Diagnostics, LoadError, Override, Scenario, load_start, load_with};
use crate::simulate::{Start, at_stage};
use crate::statics::{Balance, answer, balance};
use anyhow::{Context, anyhow, bail};
use clap::Args;
use std::path::Path;
use std::sync::Arc;

/// A scenario with its model, or the exit code after its problems were printed.
pub(super) fn load(common: &Common) -> anyhow::Result<Result<(Scenario, Arc<Model>), Exit>> {
    load_changed(common, None)
}

/// A scenario with one more change, and its model, or the exit code after its problems were printed.
pub(super) fn load_changed(
    common: &Common,
    change: Option<Override>,
) -> anyhow::Result<Result<(Scenario, Arc<Model>), Exit>> {
    let set = common.set.iter().map(|text| Override::parse(text));
    let overrides: Vec<Override> = set.chain(change.map(Ok)).collect::<Result<_, _>>()?;
    let mut scenario = match load_with(&common.scenario, &overrides) {
        Ok(scenario) => scenario,
        Err(LoadError::Problems(problems)) => return Ok(Err(refused(&problems))),
        Err(other) => return Err(other.into()),
    };
    if !scenario.warnings.is_empty() && !common.quiet {
        output::note(scenario.warnings.render(output::errors_in_color()).trim_end());
    }
    for taken in scenario.models.iter().filter(|taken| !common.quiet && !taken.notes.is_empty()) {
        let path = taken.sources.first().map(|source| source.path.display().to_string()).unwrap_or_default();
        let counted = crate::import::counted(&taken.notes);
        output::note(&format!("{path}: {counted}; `stillpoint convert {path}` lists them"));
    }
    let (model, assembly) = match scenario.built.take() {
        Some(built) => built,
        None => constraint::assemble(Model::build(&scenario.description).map_err(listed)?).map_err(listed)?,
    };
    if model.halves.is_some() {
        join_threads();
    }
    note(common, &assembly);
    Ok(Ok((scenario, model)))
}

/// This thread is one of the two that compute the halves of a large tree: it need not be woken then.
fn join_threads() {
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZeroUsize::get).min(2);
    // Already so where a second scene is loaded.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(threads).use_current_thread().build_global();
}

fn listed(problems: Vec<Problem>) -> anyhow::Error {
    anyhow!("{}", problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
}

/// Closes the loops, and says what that took.
fn assemble(common: &Common, model: Arc<Model>) -> anyhow::Result<Arc<Model>> {
    let (model, assembly) = constraint::assemble(model).map_err(listed)?;
    note(common, &assembly);
    Ok(model)
}

/// What a person should know of an assembly.
fn note(common: &Common, assembly: &Assembly) {
    assembly.notes.iter().filter(|_| !common.quiet).for_each(|note| output::note(note));
}

/// A scenario with its model at the start that a file gives, or the exit code after its problems were printed.
pub(super) fn load_at(common: &Common, start: Option<&Path>) -> anyhow::Result<Result<(Scenario, Arc<Model>), Exit>> {
    // Where another file says how it begins, what the scenario says of that is no matter.
    let begins = start.map(|_| Override::parse("simulate.start=\"equilibrium\"")).transpose()?;
    Ok(match load_changed(common, begins)? {
        Ok(loaded) => start_at(common, start, loaded)?,
        Err(exit) => Err(exit),
    })
}

/// What a command asks of one structure of a scene.
#[derive(Debug, Args)]
pub(super) struct Structure {
    /// Of a scene with `[[stage]]`s: as it is after this one and those before it in the file, in the positions given; without it
    /// as it is before the first
    #[arg(long, value_name = "NAME")]
    stage: Option<String>,
}

/// One structure of a scenario with its model at the start that a file gives, or the exit code after its problems were printed.
pub(super) fn load_structure(
    common: &Common,
    structure: &Structure,
    start: Option<&Path>,
) -> anyhow::Result<Result<(Scenario, Arc<Model>), Exit>> {
    let (mut scenario, mut model) = match load(common)? {
        Ok(loaded) => loaded,
        Err(exit) => return Ok(Err(exit)),
    };
    if let Some(stage) = &structure.stage {
        if !scenario.aim.is_empty() {
            aim_first(common, &mut scenario, &model)?;
        }
        if !scenario.unknown.is_empty() || scenario.path.is_some() {
            bail!(
                "{}: `--stage` goes without a pose that is given, `[statics] unknown`, and `[statics.path]`",
                scenario.name
            );
        }
        let at_rest = at_rest(common, &scenario, &model)?;
        let found = at_stage(&scenario.description, stage, at_rest.as_deref());
        let (left, locked) = found.map_err(|why| anyhow!("{}: {why}", scenario.name))?;
        locked.iter().filter(|_| !common.quiet).for_each(|said| output::note(said));
        scenario.description = left;
        model = assemble(common, Model::build(&scenario.description).map_err(listed)?)?;
    }
    start_at(common, start, (scenario, model))
}

/// What is aimed at before the first stage is aimed at once: the numbers that were found are those of the scene from then on.
fn aim_first(common: &Common, scenario: &mut Scenario, model: &Arc<Model>) -> anyhow::Result<()> {
    let interrupt = Interrupt::install()?;
    let (description, model) = (scenario.description.clone(), Arc::clone(model));
    let go_on = || !interrupt.requested();
    let held = answer(description, model, scenario.sought(), &scenario.statics, &scenario.margin, &go_on)
        .with_context(|| format!("{}: statics cannot start", scenario.name))?;
    if !held.found.converged {
        bail!("{}: {}", scenario.name, held.found.notes.first().map_or("no equilibrium found", String::as_str));
    }
    for (address, value) in held.found.unknowns.iter().filter(|_| !common.quiet) {
        output::note(&format!("aimed before the first stage: `{address}` = {}", number(*value)));
    }
    scenario.description = held.description;
    scenario.unknown.clear();
    scenario.aim.clear();
    Ok(())
}

/// Where a run begins whose stages come from an equilibrium; `None` if it begins in the positions of the file, or they have none.
fn at_rest(common: &Common, scenario: &Scenario, model: &Arc<Model>) -> anyhow::Result<Option<Vec<f64>>> {
    if scenario.simulate.start == Start::Given {
        return Ok(None);
    }
    let interrupt = Interrupt::install()?;
    let go_on = || !interrupt.requested();
    let (description, sought) = (scenario.description.clone(), scenario.sought());
    let held = answer(description, Arc::clone(model), sought, &scenario.statics, &scenario.margin, &go_on);
    let found = held.ok().map(|held| held.found).filter(|found| found.converged);
    if found.is_none() && !common.quiet {
        output::note("no equilibrium before the first stage: stages come in the positions of the file");
    }
    Ok(found.map(|found| found.position))
}

/// Puts a scene at the start that a file gives.
fn start_at(
    common: &Common,
    start: Option<&Path>,
    (mut scenario, model): (Scenario, Arc<Model>),
) -> anyhow::Result<Result<(Scenario, Arc<Model>), Exit>> {
    let Some(path) = start else { return Ok(Ok((scenario, model))) };
    let started = match load_start(path, &scenario.description) {
        Ok(started) => started,
        Err(LoadError::Problems(problems)) => return Ok(Err(refused(&problems))),
        Err(other) => return Err(other.into()),
    };
    for (address, before, now) in started.changes.iter().filter(|_| !common.quiet) {
        let (before, now) = (number(*before), number(*now));
        output::note(&format!("{}: `{address}` is {now} (the scenario says {before})", path.display()));
    }
    scenario.description = started.description;
    scenario.given = started.changes.into_iter().map(|(address, _, now)| (address, now)).collect();
    scenario.simulate.resume = started.resume;
    if scenario.simulate.resume.is_some() {
        // The scene is put together as the scenario has it.
        let model = assemble(common, Model::build(&scenario.description).map_err(listed)?)?;
        let Model { start_position, start_velocity, .. } = &*started.model;
        let model = model.starting_in(start_position, start_velocity);
        check_closed(path, &model, scenario.simulate.begin())?;
        return Ok(Ok((scenario, model)));
    }
    let model = assemble(common, started.model)?;
    if !common.quiet {
        check_start(path, &model, &started.multipliers)?;
    }
    Ok(Ok((scenario, model)))
}

/// Loops of a state to go on from may be open by this part of the scene's length.
const OPEN: f64 = 1e-6;

/// Refuses a state to go on from with open loops: it goes on as it stands, without assembly.
fn check_closed(path: &Path, model: &Arc<Model>, time: f64) -> anyhow::Result<()> {
    if model.loops.is_empty() {
        return Ok(());
    }
    let of_file = || path.display().to_string();
    let (q, v) = (&model.start_position, &model.start_velocity);
    let mut system = System::new(model);
    let mut at = system.at(time, q, v);
    at.accelerations(&mut vec![0.0; v.len()]).with_context(of_file)?;
    at.share_multipliers().with_context(of_file)?;
    let open = |gap: f64| !(gap <= OPEN * model.length_scale());
    match at.loop_reactions().iter().find(|closed| open(closed.gap)) {
        Some(closed) => bail!("{}: loop `{}` is open by {} m there", of_file(), closed.name, number(closed.gap)),
        None => Ok(()),
    }
}

/// Multipliers that differ by more than this part of the largest are not those of this scene.
const SAME: f64 = 1e-6;

/// Says where a start does not hold itself, and where its loops push otherwise than the file says.
fn check_start(path: &Path, model: &Arc<Model>, multipliers: &[(String, Vec<f64>)]) -> anyhow::Result<()> {
    let (q, v) = (&model.start_position, &model.start_velocity);
    let of_file = || path.display().to_string();
    let Some(Balance { residual, pushes: here }) = balance(model, q, v).with_context(of_file)? else { return Ok(()) };
    if let Some(residual) = residual {
        let share = text::small(residual.relative);
        output::warning(&format!(
            "{}: the start does not hold itself: {} in {} is not balanced ({share} of the forces there)",
            path.display(),
            text::borne(model, &residual.hinge, residual.force),
            residual.hinge
        ));
    }
    let largest = here.iter().flat_map(|(_, list)| list).fold(0.0_f64, |m, x| m.max(x.abs()));
    for (name, list) in multipliers {
        let Some((_, now)) = here.iter().find(|(other, _)| other == name) else { continue };
        // Where rows are redundant others may stand for them here.
        if now.iter().zip(list).any(|(a, b)| (*a == 0.0) != (*b == 0.0)) {
            continue;
        }
        let differs = |(a, b): &(&f64, &f64)| (*a - *b).abs() > SAME * largest.max(b.abs());
        if let Some((now, before)) = now.iter().zip(list).find(differs) {
            output::warning(&format!(
                "{}: {name} pushes with {} here, the file says {}: the scene is not the one that it was written for",
                path.display(),
                number(*now),
                number(*before)
            ));
        }
    }
    Ok(())
}

fn refused(problems: &Diagnostics) -> Exit {
    output::note(problems.render(output::errors_in_color()).trim_end());
    Exit::Wrong
}
