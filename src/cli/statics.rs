//! `statics`: the equilibrium and what it is.

use super::{Common, Exit, json, output, scene, text};
use crate::statics::{Equilibrium, equilibrium};
use anyhow::Context;
use clap::Args;
use std::path::PathBuf;
use std::time::{Duration, Instant};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    #[command(flatten)]
    common: Common,
    /// Write the result there as JSON
    #[arg(long, value_name = "PATH")]
    out: Option<PathBuf>,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let common = &arguments.common;
    let (scenario, model) = match scene::load(common)? {
        Ok(loaded) => loaded,
        Err(exit) => return Ok(exit),
    };
    let (found, wall) = find(&scenario, &model)?;
    let result = json::statics(&model, &found, wall.as_secs_f64());
    if let Some(path) = &arguments.out {
        std::fs::write(path, format!("{result:#}\n")).with_context(|| format!("cannot write `{}`", path.display()))?;
    }
    if common.json {
        output::print(&result.to_string())?;
    } else if !common.quiet {
        output::print(&text::heading(&model, &scenario.name))?;
        output::print(&text::statics(&model, &found, wall))?;
    }
    Ok(if found.converged { Exit::Done } else { Exit::No })
}

/// The equilibrium and the time it took.
pub(super) fn find(
    scenario: &crate::scenario::Scenario,
    model: &crate::model::Model,
) -> anyhow::Result<(Equilibrium, Duration)> {
    let before = Instant::now();
    let found = equilibrium(model, &scenario.statics, &model.start_position)
        .with_context(|| format!("{}: statics cannot start", scenario.name))?;
    Ok((found, before.elapsed()))
}
