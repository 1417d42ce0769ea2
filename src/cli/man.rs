//! `man`: the manual pages.

use super::{Cli, Exit, output};
use anyhow::Context;
use clap::{Args, CommandFactory};
use std::path::PathBuf;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// Write `stillpoint.1` and a page for every command into this folder; without it the first page is printed
    #[arg(value_name = "DIR")]
    folder: Option<PathBuf>,
}

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let command = Cli::command();
    match &arguments.folder {
        Some(folder) => {
            let failed = || format!("cannot write manual pages into `{}`", folder.display());
            std::fs::create_dir_all(folder).with_context(failed)?;
            clap_mangen::generate_to(command, folder).with_context(failed)?;
        }
        None => {
            let mut page = Vec::new();
            clap_mangen::Man::new(command).render(&mut page)?;
            output::print(String::from_utf8(page)?.trim_end())?;
        }
    }
    Ok(Exit::Done)
}
