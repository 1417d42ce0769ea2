//! The library that every FMU holds.

use crate::fmu::MARK;
use anyhow::{Context, bail};
use std::env::consts::{ARCH, DLL_PREFIX, DLL_SUFFIX, OS};
use std::path::{Path, PathBuf};

/// How it is built.
const BUILD: &str = "cargo build --release -p stillpoint-fmu";

pub(super) struct Library {
    pub(super) bytes: Vec<u8>,
    /// As FMI calls it: `x86_64-linux`.
    pub(super) platform: String,
}

/// The library of a path, or the one beside the program.
///
/// # Errors
/// If it is not there, or is not that of this version: how to build it.
pub(super) fn read(path: Option<&Path>) -> anyhow::Result<Library> {
    let name = format!("{DLL_PREFIX}stillpoint_fmu{DLL_SUFFIX}");
    let path: PathBuf = match path {
        Some(path) => path.to_owned(),
        None => {
            let program = std::env::current_exe().context("the folder of the program is not known")?;
            let beside = program.with_file_name(&name);
            // Of a Python package the interpreter is the program, and nothing of ours lies beside it.
            if program.file_stem().is_none_or(|stem| stem != env!("CARGO_PKG_NAME")) {
                bail!(
                    "the Python package has no library of FMUs, which every FMU holds\nhint: build `{name}` from a clone of the sources of \
                     this version, {} (`{BUILD}`), and name it with `--library target/release/{name}`",
                    env!("CARGO_PKG_VERSION")
                );
            }
            if !beside.is_file() {
                bail!(
                    "there is no `{}`: an FMU holds this library\nhint: build it (`{BUILD}`) and copy it there, or name it with `--library`",
                    beside.display()
                );
            }
            beside
        }
    };
    let bytes = std::fs::read(&path).with_context(|| format!("cannot read `{}`", path.display()))?;
    if !bytes.windows(MARK.len()).any(|window| window == MARK.as_bytes()) {
        bail!(
            "`{}` is not the library of this program ({MARK})\nhint: build it from the same sources: `{BUILD}`",
            path.display()
        );
    }
    Ok(Library { bytes, platform: platform()? })
}

fn platform() -> anyhow::Result<String> {
    let system = match OS {
        "macos" => "darwin",
        "linux" | "windows" => OS,
        other => bail!("FMI names no platform for {other}"),
    };
    match ARCH {
        "x86_64" | "aarch64" | "x86" => Ok(format!("{ARCH}-{system}")),
        other => bail!("FMI names no platform for {other}"),
    }
}
