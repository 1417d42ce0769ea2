//! `man`: the manual pages.

use super::{Cli, Exit, output};
use anyhow::Context;
use clap::{Args, Command, CommandFactory};
use clap_mangen::Man;
use clap_mangen::roff::{Roff, roman};
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Write `stillpoint.1` and a page for every command into this folder; without it the first page is printed
    #[arg(value_name = "DIR")]
    folder: Option<PathBuf>,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let mut command = Cli::command().disable_help_subcommand(true);
    command.build();
    match &arguments.folder {
        Some(folder) => {
            let failed = || format!("cannot write manual pages into `{}`", folder.display());
            std::fs::create_dir_all(folder).with_context(failed)?;
            write(&command, folder).with_context(failed)?;
        }
        None => output::print(String::from_utf8(page(&command)?)?.trim_end())?,
    }
    Ok(Exit::Done)
}

/// The pages of a command and of those below it.
fn write(command: &Command, folder: &Path) -> anyhow::Result<()> {
    std::fs::write(folder.join(Man::new(command.clone()).get_filename()), page(command)?)?;
    command.get_subcommands().try_for_each(|below| write(below, folder))
}

/// One page, its examples in a section of their own.
fn page(command: &Command) -> std::io::Result<Vec<u8>> {
    let examples = command.get_after_help().map(ToString::to_string);
    let man = Man::new(command.clone().after_help(None::<&str>));
    let mut page = Vec::new();
    man.render(&mut page)?;
    if let Some(examples) = examples {
        let mut roff = Roff::new();
        roff.control("SH", ["EXAMPLES"]).control("nf", []);
        for line in examples.lines().filter(|line| *line != "Examples:") {
            roff.text([roman(line)]);
        }
        page.extend(roff.control("fi", []).to_roff().into_bytes());
    }
    Ok(page)
}
