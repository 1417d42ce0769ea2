//! The file on disk: opened early, under another name until it is whole.

use super::FileWriter;
use crate::record::{Opening, RecordError};
use std::fs::{self, File, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};

/// A recording file that is open for writing but has no content yet. Create it before the long work, so that a wrong
/// folder or a full disk shows at once. Dropped unused, it leaves nothing behind.
#[derive(Debug)]
pub struct RecordingFile {
    target: PathBuf,
    partial: Unused,
    file: File,
    ros: bool,
}

impl RecordingFile {
    /// Opens `<target>.partial`, locked against other runs. A file called `target` stays as it is until the recording
    /// is finished, and is replaced then.
    ///
    /// # Errors
    /// When the folder is missing or not writable, `target` is a folder, or another run is writing it.
    pub fn create(target: &Path) -> Result<Self, RecordError> {
        let failed = |source| RecordError::Create { path: target.into(), source };
        if target.is_dir() || target.file_name().is_none() {
            return Err(failed(std::io::ErrorKind::IsADirectory.into()));
        }
        if fs::metadata(target).is_ok_and(|found| !found.is_file()) {
            return Self::onto(target).map_err(failed);
        }
        let mut name = target.as_os_str().to_owned();
        name.push(".partial");
        let partial = PathBuf::from(name);
        // Not truncated on opening: it may be another run's.
        let file = OpenOptions::new().write(true).create(true).truncate(false).open(&partial).map_err(failed)?;
        match file.try_lock() {
            Err(TryLockError::WouldBlock) => return Err(RecordError::Busy { path: partial }),
            // A file system without locks gives no protection, and needs none to be written.
            Ok(()) | Err(TryLockError::Error(_)) => {}
        }
        if file.metadata().map_err(failed)?.is_file() {
            file.set_len(0).map_err(failed)?;
        }
        Ok(Self { target: target.into(), partial: Unused(partial), file, ros: false })
    }

    /// A device or a pipe is written as it stands: it can be neither renamed nor removed without harm.
    fn onto(target: &Path) -> std::io::Result<Self> {
        let file = OpenOptions::new().write(true).open(target)?;
        Ok(Self { target: target.into(), partial: Unused(PathBuf::new()), file, ros: false })
    }

    /// Whether `/robot_description` and `/joint_states` are written too, ROS 2 messages by which Rerun draws a recording
    /// that is opened directly. Readers that decode every channel have to know CDR then. Left out where the scene is large.
    pub fn with_ros(mut self, ros: bool) -> Self {
        self.ros = ros;
        self
    }

    /// Writes what is known before the first sample.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn begin(self, opening: &Opening) -> Result<FileWriter, RecordError> {
        let partial = self.partial.keep();
        let written = if partial.as_os_str().is_empty() { self.target.clone() } else { partial };
        FileWriter::begin(self.file, self.target, written, opening, self.ros)
    }
}

/// A file that is removed unless it is kept.
#[derive(Debug)]
struct Unused(PathBuf);

impl Unused {
    fn keep(mut self) -> PathBuf {
        std::mem::take(&mut self.0)
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
