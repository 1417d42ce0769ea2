//! The file on disk: opened early, under another name until it is whole.
//!
//! # Two runs of one output
//!
//! The unfinished file of `run.mcap` is the first of `run.mcap.partial`, `run.2.mcap.partial`, … that no earlier run
//! left there, and carries an exclusive lock from before the first byte until after the rename. What an earlier run left
//! is kept, and locked (shared, so that it can be recovered meanwhile): every other run of the same output meets one of
//! these locks and is refused. A lock counts only if the name still leads to the locked file once it is held: between
//! opening and locking, another run may have given the file its final name, or removed it.

use super::{Ending, FileWriter, Recording};
use crate::record::{Opening, RecordError};
use crate::whole_file::{self, Place};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};

/// A recording file that is open for writing but has no content yet. Create it before the long work, so that a wrong
/// folder or a full disk shows at once. Dropped unused, it leaves nothing behind.
#[derive(Debug)]
pub struct RecordingFile {
    /// As it was asked for.
    target: PathBuf,
    /// The file that `target` leads to; `None` for a device, which is written as it stands.
    place: Option<PathBuf>,
    partial: Unused,
    file: File,
    /// What earlier runs left, and the locks on it.
    left: Vec<(PathBuf, File)>,
    ros: bool,
}

impl RecordingFile {
    /// Opens `<target>.partial`, locked against other runs. A recording called `target` stays as it is until this one is
    /// finished, and is replaced then.
    ///
    /// # Errors
    /// When the folder is missing or not writable, `target` is a folder, a pipe or a file that is no recording, or
    /// another run is writing it.
    pub fn create(target: &Path) -> Result<Self, RecordError> {
        let failed = |source| RecordError::Create { path: target.into(), source };
        let place = match whole_file::place(target).map_err(failed)? {
            Place::File(path) => path,
            Place::Device(path) => return Self::onto(target, &path).map_err(failed),
        };
        if !is_replaceable(&place).map_err(failed)? {
            let why = "it is there already and no recording, and is not replaced; choose another name";
            return Err(failed(io::Error::new(ErrorKind::AlreadyExists, why)));
        }
        let mut left = Vec::new();
        for name in whole_file::partial_names(&place) {
            match claim(&name, target)? {
                Claim::Ours(file) => {
                    let partial = Unused(name);
                    return Ok(Self { target: target.into(), place: Some(place), partial, file, left, ros: false });
                }
                Claim::Left(file) => left.push((name, file)),
                Claim::Foreign => {}
            }
        }
        Err(failed(whole_file::too_many(&place)))
    }

    /// A device is written as it stands.
    fn onto(target: &Path, device: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().write(true).open(device)?;
        let partial = Unused(PathBuf::new());
        Ok(Self { target: target.into(), place: None, partial, file, left: Vec::new(), ros: false })
    }

    /// Whether `/robot_description` and `/joint_states` are written too, ROS 2 messages by which Rerun draws a recording
    /// that is opened directly. Readers that decode every channel have to know CDR then. Left out where the scene is large.
    pub fn with_ros(mut self, ros: bool) -> Self {
        self.ros = ros;
        self
    }

    /// What earlier runs of this output left unfinished. It is kept; [`Recording::recover`](super::Recording::recover)
    /// makes recordings of it.
    pub fn left(&self) -> impl Iterator<Item = &Path> {
        self.left.iter().map(|(name, _)| name.as_path())
    }

    /// Writes what is known before the first sample.
    ///
    /// # Errors
    /// When it cannot be written; nothing is left then.
    pub fn begin(self, opening: &Opening) -> Result<FileWriter, RecordError> {
        // Holds the lock until the file is begun or removed.
        let failed = |source| RecordError::Create { path: self.target.clone(), source };
        let _lock = self.file.try_clone().map_err(failed)?;
        let paths = match self.place {
            Some(place) => Paths { asked: self.target, written: self.partial.0.clone(), place: Some(place) },
            None => Paths { asked: self.target.clone(), written: self.target, place: None },
        };
        let locks = self.left.into_iter().map(|(_, file)| file).collect();
        let writer = FileWriter::begin(self.file, paths, opening, self.ros, locks)?;
        self.partial.keep();
        Ok(writer)
    }
}

/// The names of a recording that is being written.
#[derive(Debug)]
pub(super) struct Paths {
    /// As it was asked for.
    pub(super) asked: PathBuf,
    /// What is written now.
    pub(super) written: PathBuf,
    /// What that becomes when it is finished; `None` for a device.
    pub(super) place: Option<PathBuf>,
}

/// Whether a finished recording may take this name: it is free, empty, or another recording's.
fn is_replaceable(place: &Path) -> io::Result<bool> {
    let mut start = Vec::new();
    match File::open(place) {
        Ok(file) => file.take(mcap::MAGIC.len() as u64).read_to_end(&mut start)?,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(true),
        Err(error) => return Err(error),
    };
    Ok(start.is_empty() || start == mcap::MAGIC)
}

/// What stands under the name of an unfinished file.
enum Claim {
    /// It is free, and now ours.
    Ours(File),
    /// What an earlier run left.
    Left(File),
    /// Something else: a link, a pipe, a folder, or somebody else's.
    Foreign,
}

fn claim(name: &Path, target: &Path) -> Result<Claim, RecordError> {
    let opened = open(name).map_err(|source| RecordError::Create { path: target.into(), source })?;
    lock(opened, name, target)
}

/// Locks what was opened and says what it is. If another run has renamed or removed it meanwhile, both wanted the output
/// at one time, and this one is refused.
fn lock(opened: Opened, name: &Path, target: &Path) -> Result<Claim, RecordError> {
    let failed = |source| RecordError::Create { path: target.into(), source };
    let busy = || RecordError::Busy { path: name.into() };
    let (file, is_new) = match opened {
        Opened::New(file) => (file, true),
        Opened::There(file) => (file, false),
        Opened::Gone => return Err(busy()),
        Opened::Foreign => return Ok(Claim::Foreign),
    };
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => return Err(busy()),
        // A file system without locks: only what was not there before is surely nobody else's.
        Err(TryLockError::Error(_)) if is_new => return Ok(Claim::Ours(file)),
        Err(TryLockError::Error(_)) => return Ok(Claim::Left(file)),
    }
    if !whole_file::is_still(&file, name).map_err(failed)? {
        return Err(busy());
    }
    if file.metadata().map_err(failed)?.len() == 0 {
        return Ok(Claim::Ours(file));
    }
    // Whoever comes between these two meets the same file, and one of both is refused here.
    file.unlock().map_err(failed)?;
    match file.try_lock_shared() {
        Ok(()) => Ok(Claim::Left(file)),
        Err(TryLockError::WouldBlock) => Err(busy()),
        Err(TryLockError::Error(error)) => Err(failed(error)),
    }
}

/// A regular file that was opened without touching its content.
enum Opened {
    New(File),
    There(File),
    /// It was there, and is not any more.
    Gone,
    /// Something else has the name, or a file that may not be written.
    Foreign,
}

fn open(name: &Path) -> io::Result<Opened> {
    let mut options = OpenOptions::new();
    options.read(true).write(true);
    match options.clone().create_new(true).open(name) {
        Ok(file) => return Ok(Opened::New(file)),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
        Err(error) => return Err(error),
    }
    match fs::symlink_metadata(name) {
        // Opening a pipe would wait for its reader, and a link would lead elsewhere.
        Ok(about) if !about.is_file() => return Ok(Opened::Foreign),
        Ok(_) => {}
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Opened::Gone),
        Err(error) => return Err(error),
    }
    match options.open(name) {
        Ok(file) => Ok(Opened::There(file)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(Opened::Gone),
        Err(error) if error.kind() == ErrorKind::PermissionDenied => Ok(Opened::Foreign),
        Err(error) => Err(error),
    }
}

/// A file that is removed unless it is kept. It is ours and locked: nobody else has it.
#[derive(Debug)]
struct Unused(PathBuf);

impl Unused {
    fn keep(mut self) {
        self.0 = PathBuf::new();
    }
}

impl Drop for Unused {
    fn drop(&mut self) {
        if !self.0.as_os_str().is_empty() {
            // Nothing was written to it; where it cannot be removed it does no harm.
            let _ = fs::remove_file(&self.0);
        }
    }
}

/// Keeps the complete recording of this name, if there is one, beside the one of a run that did not reach its end and is
/// about to take its name: renames it to `<target>~`, and gives that name back. An older one of that name goes.
///
/// # Errors
/// If it cannot be renamed.
pub fn keep_complete(target: &Path) -> Result<Option<PathBuf>, RecordError> {
    let failed = |source| RecordError::Create { path: target.into(), source };
    let Ok(Place::File(place)) = whole_file::place(target) else { return Ok(None) };
    if !Recording::open(&place).is_ok_and(|there| there.ending() == Ending::Complete) {
        return Ok(None);
    }
    let mut kept = place.as_os_str().to_owned();
    kept.push("~");
    let kept = PathBuf::from(kept);
    fs::rename(&place, &kept).map_err(failed)?;
    whole_file::sync_folder(&kept).map_err(failed)?;
    Ok(Some(kept))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::record::{Outcome, Recorder, Scene};

    fn begun(target: &Path) -> FileWriter {
        let scene = Scene::default();
        let opening = Opening { scene: &scene, scenario: "", statics: None };
        RecordingFile::create(target).and_then(|file| file.begin(&opening)).expect("begun")
    }

    fn finish(mut writer: FileWriter) {
        writer.finish(&Outcome { summary: "{}".to_owned() }).expect("finished");
    }

    /// The steps of a second run, with the end of the first between opening and locking.
    #[test]
    fn a_run_that_ends_between_opening_and_locking_keeps_its_recording() {
        let folder = tempfile::tempdir().expect("a folder");
        let target = folder.path().join("run.mcap");
        let partial = folder.path().join("run.mcap.partial");
        let first = begun(&target);
        let opened = open(&partial).expect("opened");
        assert!(matches!(opened, Opened::There(_)));
        finish(first);
        let whole = fs::read(&target).expect("read");
        // What was opened is the finished recording now.
        assert!(matches!(lock(opened, &partial, &target), Err(RecordError::Busy { .. })));
        assert_eq!(fs::read(&target).expect("read"), whole);
        finish(begun(&target));
        assert!(!partial.exists());
    }

    #[test]
    fn a_run_that_gives_up_between_opening_and_locking_leaves_a_free_name() {
        let folder = tempfile::tempdir().expect("a folder");
        let target = folder.path().join("run.mcap");
        let partial = folder.path().join("run.mcap.partial");
        let first = RecordingFile::create(&target).expect("created");
        let opened = open(&partial).expect("opened");
        drop(first);
        assert!(matches!(lock(opened, &partial, &target), Err(RecordError::Busy { .. })));
        finish(begun(&target));
    }

    #[test]
    fn what_is_left_is_locked_against_other_runs_and_free_to_be_recovered() {
        let folder = tempfile::tempdir().expect("a folder");
        let target = folder.path().join("run.mcap");
        drop(begun(&target));
        let left = fs::read(folder.path().join("run.mcap.partial")).expect("left");
        let second = RecordingFile::create(&target).expect("another name");
        assert_eq!(second.left().collect::<Vec<_>>(), [folder.path().join("run.mcap.partial")]);
        assert!(folder.path().join("run.2.mcap.partial").exists());
        assert!(matches!(RecordingFile::create(&target), Err(RecordError::Busy { .. })));
        let saved = folder.path().join("saved.mcap");
        Recording::open(&folder.path().join("run.mcap.partial")).expect("ours").recover(&saved).expect("recovered");
        drop(second);
        assert!(!folder.path().join("run.2.mcap.partial").exists());
        assert_eq!(fs::read(folder.path().join("run.mcap.partial")).expect("left"), left);
    }
}
