//! Loading a scenario for a command: everything that is wrong is said here, once.

use super::{Common, Exit, output, text};
use crate::constraint;
use crate::model::{Model, Problem};
use crate::scenario::{Diagnostics, LoadError, Override, Scenario, load_start, load_with};
use anyhow::anyhow;
use std::path::Path;

/// A scenario with its model, or the exit code after its problems were printed.
pub(super) fn load(common: &Common) -> anyhow::Result<Result<(Scenario, Model), Exit>> {
    let overrides: Vec<Override> = common.set.iter().map(|text| Override::parse(text)).collect::<Result<_, _>>()?;
    let scenario = match load_with(&common.scenario, &overrides) {
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
    let mut model = Model::build(&scenario.description).map_err(listed)?;
    assemble(common, &mut model)?;
    Ok(Ok((scenario, model)))
}

fn listed(problems: Vec<Problem>) -> anyhow::Error {
    anyhow!("{}", problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))
}

/// Closes the loops, and says what that took.
fn assemble(common: &Common, model: &mut Model) -> anyhow::Result<()> {
    let assembly = constraint::assemble(model).map_err(listed)?;
    for note in assembly.notes.iter().filter(|_| !common.quiet) {
        output::note(note);
    }
    Ok(())
}

/// The same, at the start that a file gives.
pub(super) fn load_at(common: &Common, start: Option<&Path>) -> anyhow::Result<Result<(Scenario, Model), Exit>> {
    let (mut scenario, model) = match load(common)? {
        Ok(loaded) => loaded,
        Err(exit) => return Ok(Err(exit)),
    };
    let Some(path) = start else { return Ok(Ok((scenario, model))) };
    let mut started = match load_start(path, &scenario.description) {
        Ok(started) => started,
        Err(LoadError::Problems(problems)) => return Ok(Err(refused(&problems))),
        Err(other) => return Err(other.into()),
    };
    for (address, before, now) in started.changes.iter().filter(|_| !common.quiet) {
        let (before, now) = (text::number(*before), text::number(*now));
        output::note(&format!("{}: `{address}` is {now} (the scenario says {before})", path.display()));
    }
    scenario.description = started.description;
    assemble(common, &mut started.model)?;
    Ok(Ok((scenario, started.model)))
}

fn refused(problems: &Diagnostics) -> Exit {
    output::note(problems.render(output::errors_in_color()).trim_end());
    Exit::Wrong
}
