//! `new`: a scenario to start from.

use super::{Exit, output};
use anyhow::{Context, bail};
use clap::{Args, ValueEnum};
use std::io::{ErrorKind, Write};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The file to write; `-` prints it instead
    file: PathBuf,
    /// What to start from
    #[arg(long, value_enum, default_value_t = Kind::Pendulum)]
    kind: Kind,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

/// The scenes that a new file can start from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Kind {
    /// A rod on a pin
    Pendulum,
    /// Equal links in a row, with a weight
    Chain,
    /// An arm of three joints held by servos
    Robot,
    /// A closed loop of bars on a spring
    Linkage,
}

impl Kind {
    fn text(self) -> &'static str {
        match self {
            Self::Pendulum => include_str!("new/pendulum.toml"),
            Self::Chain => include_str!("new/chain.toml"),
            Self::Robot => include_str!("new/robot.toml"),
            Self::Linkage => include_str!("new/linkage.toml"),
        }
    }
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let path = &arguments.file;
    if path.as_os_str() == "-" {
        output::print(arguments.kind.text().trim_end())?;
        return Ok(Exit::Done);
    }
    let name = path.display().to_string();
    // A name with a blank would have to be quoted.
    let quoted = if name.contains(' ') { format!("'{name}'") } else { name.clone() };
    let text = arguments.kind.text().replace("NAME.toml", &quoted);
    let text = match path.file_stem().and_then(|stem| stem.to_str()) {
        Some(stem) => text.replace("NAME.mcap", &format!("{stem}.mcap")),
        None => text,
    };
    match std::fs::File::create_new(path) {
        Ok(mut file) => file.write_all(text.as_bytes()).with_context(|| format!("cannot write `{name}`"))?,
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {
            bail!("`{name}` is there already, and is left as it is; choose another name")
        }
        Err(error) => return Err(error).with_context(|| format!("cannot write `{name}`")),
    }
    if !arguments.quiet {
        output::print(&format!("{name} is written; to try it: stillpoint statics {quoted}"))?;
    }
    Ok(Exit::Done)
}
