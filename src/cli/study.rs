//! `study`: what a dataset of `sweep` says, or which numbers of a scene bring it closest to measurements.

#[cfg(feature = "parquet")]
mod dataset;
mod fit;

use super::Exit;
use super::palette::Theme;
use clap::Args;
#[cfg(feature = "parquet")]
pub(super) use dataset::silent;
pub(super) use fit::json as fit_json;
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The dataset: a folder that `sweep --out` has written; with `--fit` the scenario
    #[arg(value_name = "DATASET|SCENARIO")]
    studied: PathBuf,
    #[command(flatten)]
    dataset: DatasetOptions,
    #[command(flatten)]
    fit: fit::Options,
    /// Print one JSON object on standard output and nothing else there
    #[arg(long)]
    json: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

/// What is asked of a dataset.
#[derive(Debug, Args)]
struct DatasetOptions {
    /// Only this column; may be repeated. Default: all answers that differ from case to case
    #[arg(long, value_name = "COLUMN", conflicts_with = "fit")]
    of: Vec<String>,
    /// Draw one column there: its histogram, its course over the input that matters most, and what every input does to it
    #[arg(long, value_name = "FILE.svg", requires = "of")]
    svg: Option<PathBuf>,
    /// Paper and ink of that plot
    #[arg(long, value_enum, value_name = "THEME", default_value_t, requires = "svg")]
    theme: Theme,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    match &arguments.fit.fit {
        Some(data) => fit::main(arguments, data),
        None => of_dataset(arguments),
    }
}

#[cfg(feature = "parquet")]
fn of_dataset(arguments: &Arguments) -> anyhow::Result<Exit> {
    dataset::main(arguments)
}

#[cfg(not(feature = "parquet"))]
fn of_dataset(arguments: &Arguments) -> anyhow::Result<Exit> {
    let DatasetOptions { of, svg, theme } = &arguments.dataset;
    anyhow::bail!(
        "this program was built without Parquet, and reads no dataset ({} of `{}`, {svg:?}, {theme:?}); build it with `--features parquet`",
        if of.is_empty() { "all columns".to_owned() } else { of.join(", ") },
        arguments.studied.display()
    )
}
