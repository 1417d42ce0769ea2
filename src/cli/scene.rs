//! Loading a scenario for a command: everything that is wrong is said here, once.

use super::{Common, Exit, output};
use crate::model::Model;
use crate::scenario::{LoadError, Override, Scenario, load_with};
use anyhow::anyhow;

/// A scenario with its model, or the exit code after its problems were printed.
pub(super) fn load(common: &Common) -> anyhow::Result<Result<(Scenario, Model), Exit>> {
    let overrides: Vec<Override> = common.set.iter().map(|text| Override::parse(text)).collect::<Result<_, _>>()?;
    let scenario = match load_with(&common.scenario, &overrides) {
        Ok(scenario) => scenario,
        Err(LoadError::Problems(problems)) => {
            output::note(problems.render(output::errors_in_color()).trim_end());
            return Ok(Err(Exit::Wrong));
        }
        Err(other) => return Err(other.into()),
    };
    if !scenario.warnings.is_empty() && !common.quiet {
        output::note(scenario.warnings.render(output::errors_in_color()).trim_end());
    }
    let model = Model::build(&scenario.description)
        .map_err(|problems| anyhow!("{}", problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n")))?;
    Ok(Ok((scenario, model)))
}
