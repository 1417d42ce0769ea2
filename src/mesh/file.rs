//! Reading a file with a limit, and what can be wrong with it.

#[cfg(feature = "import")]
use crate::budget::{MESH_BYTES, MESH_CORNERS, MESH_TRIANGLES};
use std::io;
use std::path::PathBuf;
#[cfg(feature = "import")]
use std::{fs::File, io::Read, path::Path};

/// Why a mesh cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum MeshError {
    /// The operating system does not let it be read.
    #[error("cannot read the mesh `{}`: {source}", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// What the operating system says.
        source: io::Error,
    },
    /// It is larger than [`budget`](crate::budget) allows.
    #[error("the mesh `{}` has more than {most} {what}, the most that is read", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// Of what there is too much.
        what: &'static str,
        /// How much is allowed.
        most: u64,
    },
    /// A format that is not read.
    #[error("the mesh `{}` is of a kind that is not read; allowed: .stl, .obj, .gltf, .glb, .msh", .0.display())]
    Unknown(PathBuf),
    /// This program reads no meshes.
    #[error("the mesh `{}` cannot be read: this program was built without the `import` feature", .0.display())]
    Absent(PathBuf),
    /// Not what its extension says.
    #[error("the mesh `{}` is damaged: {what}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
}

#[cfg(feature = "import")]
impl MeshError {
    pub(super) fn damaged(path: &Path, what: impl ToString) -> Self {
        Self::Damaged { path: path.to_owned(), what: what.to_string() }
    }
}

/// The bytes of a mesh file, whatever its format.
///
/// # Errors
/// If it cannot be read, is no regular file, or larger than [`MESH_BYTES`].
#[cfg(feature = "import")]
pub fn bytes(path: &Path) -> Result<Vec<u8>, MeshError> {
    bytes_up_to(path, MESH_BYTES)
}

/// The bytes of a regular file of at most so many: a device has no end, and a pipe may be waited for without one.
#[cfg(feature = "import")]
pub(super) fn bytes_up_to(path: &Path, most: u64) -> Result<Vec<u8>, MeshError> {
    let unreadable = |source| MeshError::Unreadable { path: path.to_owned(), source };
    let about = std::fs::metadata(path).map_err(unreadable)?;
    if !about.is_file() {
        return Err(unreadable(io::Error::other("it is no regular file")));
    }
    let too_large = || MeshError::TooLarge { path: path.to_owned(), what: "bytes", most };
    if about.len() > most {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(unreadable)?;
    file.take(most.saturating_add(1)).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > most { Err(too_large()) } else { Ok(bytes) }
}

/// Whether so many corners and triangles are within the budget.
#[cfg(feature = "import")]
pub(super) fn check_size(path: &Path, corners: usize, triangles: usize) -> Result<(), MeshError> {
    let both = [("corners", corners, MESH_CORNERS), ("triangles", triangles, MESH_TRIANGLES)];
    match both.into_iter().find(|(_, found, most)| found > most) {
        Some((what, _, most)) => Err(MeshError::TooLarge { path: path.to_owned(), what, most: most as u64 }),
        None => Ok(()),
    }
}
