//! Reading text from a file or from standard input.

use crate::budget::TEXT_BYTES;
use crate::suggest::closest;
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// Why a file's text cannot be read. `what` is what was looked for: `scenario`, `model`.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// There is no such file.
    #[error("no {what} `{}`{}", path.display(), hint.as_ref().map(|near| format!(": did you mean `{near}`?")).unwrap_or_default())]
    Missing {
        /// What was looked for.
        what: &'static str,
        /// As asked for.
        path: PathBuf,
        /// A file of the same folder with nearly this name.
        hint: Option<String>,
    },
    /// It is a folder.
    #[error("`{}` is a folder, not a {what} file", path.display())]
    Folder {
        /// What was looked for.
        what: &'static str,
        /// As asked for.
        path: PathBuf,
    },
    /// The operating system does not let it be read.
    #[error("cannot read `{}`: {source}", path.display())]
    Unreadable {
        /// As asked for.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// It is larger than [`TEXT_BYTES`].
    #[error("`{}` is larger than {} MiB, the most that is read{}", path.display(), TEXT_BYTES >> 20, if *what == "scenario" { "; use `repeat` for chains of equal bodies" } else { "" })]
    TooLarge {
        /// What was looked for.
        what: &'static str,
        /// As asked for.
        path: PathBuf,
    },
    /// It is not text.
    #[error("`{}` is not UTF-8 text: byte {byte} (line {line}) is 0x{value:02X}{hint}", path.display())]
    NotText {
        /// As asked for.
        path: PathBuf,
        /// The first byte that does not belong to text, counted from 0 in the file.
        byte: usize,
        /// Its line, from 1.
        line: usize,
        /// Its value.
        value: u8,
        /// What the file may be instead; may be empty.
        hint: &'static str,
    },
}

/// What the path `-` is called in messages.
pub const STANDARD_INPUT: &str = "standard input";

/// The text of a file, or of standard input for `-`. `what` is what the file should be, for messages.
///
/// # Errors
/// If it is not there, cannot be read, is no UTF-8 text or larger than [`TEXT_BYTES`].
pub fn read(path: &Path, what: &'static str) -> Result<String, ReadError> {
    if path == Path::new("-") {
        return from_reader(io::stdin().lock(), Path::new(STANDARD_INPUT), what);
    }
    let unreadable = |source| ReadError::Unreadable { path: path.to_owned(), source };
    let folder = || ReadError::Folder { what, path: path.to_owned() };
    let file = File::open(path).map_err(|source| match source.kind() {
        io::ErrorKind::NotFound => ReadError::Missing { what, path: path.to_owned(), hint: neighbour(path) },
        io::ErrorKind::IsADirectory => folder(),
        _ => unreadable(source),
    })?;
    let about = file.metadata().map_err(unreadable)?;
    if about.is_dir() {
        return Err(folder());
    }
    if about.len() > TEXT_BYTES as u64 {
        return Err(ReadError::TooLarge { what, path: path.to_owned() });
    }
    from_reader(file, path, what)
}

/// As [`read`], of a file that another file names: it must be a regular one, for a pipe may be waited for without end.
///
/// # Errors
/// As [`read`].
pub fn read_regular(path: &Path, what: &'static str) -> Result<String, ReadError> {
    match path.metadata() {
        Ok(about) if !about.is_file() && !about.is_dir() => {
            let source = io::Error::other("it is a device or a pipe, and a file is needed");
            Err(ReadError::Unreadable { path: path.to_owned(), source })
        }
        _ => read(path, what),
    }
}

fn from_reader(reader: impl Read, path: &Path, what: &'static str) -> Result<String, ReadError> {
    let mut bytes = Vec::new();
    let limit = TEXT_BYTES as u64 + 1;
    reader
        .take(limit)
        .read_to_end(&mut bytes)
        .map_err(|source| ReadError::Unreadable { path: path.to_owned(), source })?;
    if bytes.len() > TEXT_BYTES {
        return Err(ReadError::TooLarge { what, path: path.to_owned() });
    }
    decode(bytes, path)
}

/// UTF-8 text without a byte order mark. Zero bytes are valid UTF-8, but no text.
fn decode(mut bytes: Vec<u8>, path: &Path) -> Result<String, ReadError> {
    let mark = if bytes.starts_with(b"\xEF\xBB\xBF") { 3 } else { 0 };
    bytes.drain(..mark);
    let zero = bytes.iter().position(|byte| *byte == 0);
    let invalid = std::str::from_utf8(&bytes).err().map(|error| error.valid_up_to());
    let Some(byte) = zero.into_iter().chain(invalid).min() else {
        return String::from_utf8(bytes)
            .map_err(|error| ReadError::Unreadable { path: path.to_owned(), source: io::Error::other(error) });
    };
    let utf16 = bytes.starts_with(b"\xFF\xFE") || bytes.starts_with(b"\xFE\xFF");
    Err(ReadError::NotText {
        path: path.to_owned(),
        byte: mark + byte,
        line: 1 + bytes[..byte].iter().filter(|byte| **byte == b'\n').count(),
        value: bytes[byte],
        hint: if utf16 {
            "; it looks like UTF-16, save it as UTF-8"
        } else if bytes.starts_with(b"\x89MCAP0") {
            "; it is a recording, for `info`, `view`, `plot`, `export`"
        } else if bytes[byte] == 0 {
            ", which stands in no text"
        } else {
            ""
        },
    })
}

/// A file of the same folder with nearly the same name.
fn neighbour(path: &Path) -> Option<String> {
    let wanted = path.file_name()?.to_str()?;
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut names: Vec<String> =
        folder.read_dir().ok()?.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).collect();
    names.sort_unstable();
    let near = closest(wanted, names.iter().map(String::as_str))?;
    Some(path.with_file_name(near).display().to_string())
}
