//! Outputs that appear whole or not at all: written under another name beside the target, and renamed when they are done.
//!
//! A link is followed to the file that it names, which is replaced; the link stays. A device is written as it stands.
//! Files of the same temporary name that somebody else left are never truncated nor removed: the next free name is taken.

use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// Links that lead to links; the operating system follows as many.
const MOST_LINKS: usize = 40;
/// Names that are tried beside one target: more files that other programs left there are for a person to look at.
const MOST_NAMES: usize = 100;

/// What an output's name stands for, once links are followed.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Place {
    /// A regular file, or a name that is still free.
    File(PathBuf),
    /// A device: it can be neither renamed nor removed without harm, and is written as it stands.
    Device(PathBuf),
}

/// Follows the links of an output's name.
///
/// # Errors
/// If it is a folder, a pipe, a socket, one of this program's open files (`/dev/stdout`), or read-only.
pub fn place(target: &Path) -> io::Result<Place> {
    let mut path = target.to_owned();
    for _ in 0..MOST_LINKS {
        if path.starts_with("/proc") || path.starts_with("/dev/fd") {
            return Err(io::Error::other(
                "it stands for a file that this program has open already; name the file itself",
            ));
        }
        match fs::symlink_metadata(&path) {
            Ok(about) if about.is_symlink() => {
                let folder = path.parent().unwrap_or(Path::new(""));
                path = folder.join(fs::read_link(&path)?);
            }
            Ok(about) if about.is_dir() => return Err(io::ErrorKind::IsADirectory.into()),
            Ok(about) if about.is_file() && about.permissions().readonly() => {
                return Err(io::Error::new(io::ErrorKind::PermissionDenied, "it is there already and read-only"));
            }
            Ok(about) if about.is_file() => return Ok(Place::File(path)),
            Ok(about) if is_device(&about) => return Ok(Place::Device(path)),
            Ok(_) => return Err(io::Error::other("it is a pipe or a socket, and a file is needed")),
            Err(error) if error.kind() == io::ErrorKind::NotFound && path.file_name().is_some() => {
                return Ok(Place::File(path));
            }
            Err(error) => return Err(error),
        }
    }
    Err(io::Error::other(format!("it is a link that leads through more than {MOST_LINKS} links")))
}

#[cfg(unix)]
fn is_device(about: &fs::Metadata) -> bool {
    use std::os::unix::fs::FileTypeExt;
    about.file_type().is_char_device() || about.file_type().is_block_device()
}

#[cfg(not(unix))]
fn is_device(_: &fs::Metadata) -> bool {
    true
}

/// The names that an unfinished output may have: `run.mcap.partial`, `run.2.mcap.partial`, `run.3.mcap.partial`, ….
pub fn partial_names(target: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    let target = target.to_owned();
    let stem = target.file_stem().unwrap_or_default().to_owned();
    let extension = target.extension().map(ToOwned::to_owned);
    (1..=MOST_NAMES).map(move |number| {
        let mut name = OsString::from(&stem);
        if number > 1 {
            name.push(format!(".{number}"));
        }
        for end in extension.iter().map(OsString::as_os_str).chain(["partial".as_ref()]) {
            name.push(".");
            name.push(end);
        }
        target.with_file_name(name)
    })
}

/// Whether two names lead to one file. Names that lead nowhere do not.
pub fn is_same(one: &Path, other: &Path) -> bool {
    let same_name = || fs::canonicalize(one).is_ok_and(|one| fs::canonicalize(other).is_ok_and(|other| one == other));
    match (fs::metadata(one), fs::metadata(other)) {
        (Ok(a), Ok(b)) => identity(&a).zip(identity(&b)).map_or_else(same_name, |(a, b)| a == b),
        _ => false,
    }
}

/// Whether the open file is still the one of this name: it may have been renamed or removed since.
pub fn is_still(file: &File, name: &Path) -> io::Result<bool> {
    match fs::symlink_metadata(name) {
        Ok(there) => Ok(identity(&there) == identity(&file.metadata()?)),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(error),
    }
}

/// Device and inode; a system without them has no hard links that could be confused.
#[cfg(unix)]
fn identity(about: &fs::Metadata) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    Some((about.dev(), about.ino()))
}

#[cfg(not(unix))]
fn identity(_: &fs::Metadata) -> Option<(u64, u64)> {
    None
}

/// Makes a rename in the folder of this file survive a loss of power, on systems where a folder can be flushed.
///
/// # Errors
/// If the folder's entry cannot be written.
pub fn sync_folder(file: &Path) -> io::Result<()> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    // A folder that may not be read, or a file system that flushes no folders, gives no such promise to anybody.
    let Ok(folder) = File::open(folder) else { return Ok(()) };
    match folder.sync_all() {
        Err(error) if !matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported) => Err(error),
        _ => Ok(()),
    }
}

/// An output that is being written. Dropped before [`finish`](WholeFile::finish), it leaves nothing behind, and what was
/// there before stays as it was.
#[derive(Debug)]
pub struct WholeFile {
    file: File,
    /// `None` for a device, and once it has been renamed.
    unfinished: Option<PathBuf>,
    target: PathBuf,
}

impl WholeFile {
    /// Opens an output.
    ///
    /// # Errors
    /// As [`place`], and if the folder is missing or not writable.
    pub fn create(target: &Path) -> io::Result<Self> {
        let target = match place(target)? {
            Place::File(path) => path,
            Place::Device(path) => {
                let file = OpenOptions::new().write(true).open(&path)?;
                return Ok(Self { file, unfinished: None, target: path });
            }
        };
        for name in partial_names(&target) {
            match OpenOptions::new().write(true).create_new(true).open(&name) {
                Ok(file) => return Ok(Self { file, unfinished: Some(name), target }),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        Err(too_many(&target))
    }

    /// The open file, for writers that want one.
    ///
    /// # Errors
    /// If the operating system gives no second handle.
    pub fn handle(&self) -> io::Result<File> {
        self.file.try_clone()
    }

    /// The name under which it is written now.
    pub fn path(&self) -> &Path {
        self.unfinished.as_deref().unwrap_or(&self.target)
    }

    /// Why nothing more can be written, if that is so: a writer that works in another thread may not tell.
    ///
    /// # Errors
    /// What the operating system says, such as that the disk is full.
    pub fn probe(&mut self) -> io::Result<()> {
        self.file.seek(SeekFrom::End(0))?;
        self.file.write_all(&[0; 1 << 16])?;
        self.file.sync_all()
    }

    /// Gives it its name, on the disk and not only in memory.
    ///
    /// # Errors
    /// If the last bytes or the name cannot be written; nothing is left then.
    pub fn finish(mut self) -> io::Result<()> {
        let Some(unfinished) = &self.unfinished else { return self.file.flush() };
        if let Ok(before) = fs::metadata(&self.target) {
            fs::set_permissions(unfinished, before.permissions())?;
        }
        self.file.sync_all()?;
        fs::rename(unfinished, &self.target)?;
        self.unfinished = None;
        sync_folder(&self.target)
    }

    /// Leaves the unfinished file alone: its name is somebody else's by now.
    pub fn abandon(mut self) {
        self.unfinished = None;
    }

    /// As [`finish`](Self::finish), and replaces nothing: of several programs that write one name at once, one succeeds.
    ///
    /// # Errors
    /// As [`finish`](Self::finish); [`AlreadyExists`](io::ErrorKind::AlreadyExists) if the name is taken.
    pub fn finish_new(self) -> io::Result<()> {
        let Some(unfinished) = &self.unfinished else { return self.finish() };
        self.file.sync_all()?;
        match fs::hard_link(unfinished, &self.target) {
            Ok(()) => sync_folder(&self.target),
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => Err(error),
            // A file system without hard links.
            Err(_) if !self.target.exists() => self.finish(),
            Err(error) => Err(error),
        }
    }
}

/// Too many files that others left beside this target.
pub fn too_many(target: &Path) -> io::Error {
    let names = target.with_extension("*.partial");
    io::Error::other(format!("{MOST_NAMES} unfinished files are beside it (`{}`): remove some", names.display()))
}

/// Writes a file whole or not at all.
///
/// # Errors
/// As [`WholeFile::create`] and [`WholeFile::finish`].
pub fn write(target: &Path, content: &[u8]) -> io::Result<()> {
    let mut file = WholeFile::create(target)?;
    file.write_all(content)?;
    file.finish()
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for WholeFile {
    fn drop(&mut self) {
        if let Some(unfinished) = &self.unfinished {
            // It is ours and of no use; if it cannot be removed it does no harm.
            let _ = fs::remove_file(unfinished);
        }
    }
}
