//! `completions`: what a shell needs to complete our commands and options.

use super::{Cli, Exit, output};
use clap::{Args, CommandFactory};
use clap_complete::Shell;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "stillpoint", &mut script);
    output::print(String::from_utf8(script)?.trim_end())?;
    Ok(Exit::Done)
}
