//! What can go wrong with recordings and pictures.

use std::io;
use std::path::PathBuf;

/// An error of this module: what, where, and what helps.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    /// The file cannot be created.
    #[error("cannot create the recording `{}`: {source}", path.display())]
    Create {
        /// File that was to be created.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// Two runs want the same file.
    #[error("the recording `{}` is being written by another run; choose another name with `--out`", path.display())]
    Busy {
        /// File that is locked.
        path: PathBuf,
    },
    /// A run is not over yet.
    #[error("the recording `{}` is still being written by a run: recover it when that has ended", path.display())]
    Unfinished {
        /// File that is locked.
        path: PathBuf,
    },
    /// Writing failed in the middle.
    #[error("cannot write the recording `{}`: {source}; {}", path.display(), if *kept { "what was written before stays readable there" } else { "nothing is kept there" })]
    Write {
        /// File as it stands on disk.
        path: PathBuf,
        /// Why.
        source: io::Error,
        /// Whether the description and the samples up to the last flush are there.
        kept: bool,
    },
    /// A sample does not fit the scene it belongs to.
    #[error("the sample at {time} s has {found} {what}, the scene has {expected}")]
    Mismatch {
        /// Simulated time (s).
        time: f64,
        /// Which array.
        what: &'static str,
        /// Its length in the sample.
        found: usize,
        /// Its length by the scene.
        expected: usize,
    },
    /// The file cannot be read.
    #[error("cannot read the recording `{}`: {source}", path.display())]
    Read {
        /// File.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The file is something else.
    #[error("`{}` is not a recording: {why}", path.display())]
    NotARecording {
        /// File.
        path: PathBuf,
        /// How that was seen.
        why: String,
    },
    /// The file contradicts itself.
    #[error("the recording `{}` is damaged: {what}", path.display())]
    Damaged {
        /// File.
        path: PathBuf,
        /// Where and how.
        what: String,
    },
    /// The viewer or its file cannot be reached.
    #[error("cannot show the picture: {what}{}", if hint.is_empty() { String::new() } else { format!("\nhint: {hint}") })]
    View {
        /// What happened.
        what: String,
        /// What helps; may be empty.
        hint: String,
    },
}
