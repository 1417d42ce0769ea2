//! Reading a file with a limit, and what can be wrong with it.

use std::io;
use std::path::PathBuf;
#[cfg(feature = "import")]
use std::{fs::File, io::Read, path::Path};

/// The largest mesh file that is read, in bytes.
pub const LARGEST_MESH: u64 = 256 * 1024 * 1024;

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
    /// It is larger than [`LARGEST_MESH`].
    #[error("the mesh `{}` is larger than {} MiB, the most that is read", .0.display(), LARGEST_MESH >> 20)]
    TooLarge(PathBuf),
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

/// The bytes of a file.
#[cfg(feature = "import")]
pub(super) fn bytes(path: &Path) -> Result<Vec<u8>, MeshError> {
    let unreadable = |source| MeshError::Unreadable { path: path.to_owned(), source };
    let file = File::open(path).map_err(unreadable)?;
    let mut bytes = Vec::new();
    file.take(LARGEST_MESH + 1).read_to_end(&mut bytes).map_err(unreadable)?;
    if bytes.len() as u64 > LARGEST_MESH { Err(MeshError::TooLarge(path.to_owned())) } else { Ok(bytes) }
}
