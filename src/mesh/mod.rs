//! Triangle meshes from files: STL, OBJ, glTF and MSH. For pictures, and where a density is given for mass.
//!
//! Numbers are taken as they stand in the file, in its own axes. A file that says more than it holds is refused before
//! anything of the size that it claims is allocated.

mod file;
#[cfg(feature = "import")]
mod gltf;
#[cfg(feature = "import")]
mod hull;
#[cfg(feature = "import")]
mod msh;
#[cfg(feature = "import")]
mod obj;
#[cfg(feature = "import")]
mod parts;
mod solid;
#[cfg(feature = "import")]
mod stl;

pub use file::MeshError;
#[cfg(feature = "import")]
pub use file::bytes as contents;
#[cfg(feature = "import")]
pub use hull::{Triangles, hull};
#[cfg(feature = "import")]
pub use parts::{NotConvex, Part};
pub use solid::{NotSolid, Solid};

#[cfg(feature = "import")]
use crate::foreign;
use std::path::Path;

/// Triangles with their corners.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mesh {
    /// Corners (units of the file).
    pub vertices: Vec<[f32; 3]>,
    /// Three corners each, counter-clockwise as seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// One normal per corner, where the file gives them.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Red, green, blue, opacity of each corner, 0…1, where the file gives colours.
    pub colors: Option<Vec<[f32; 4]>>,
}

/// Reads a mesh of one format.
#[cfg(feature = "import")]
type Read = fn(&Path) -> Result<Mesh, MeshError>;

impl Mesh {
    /// Reads a mesh; its format follows from the extension of the file: `stl`, `obj`, `gltf`, `glb`, `msh`.
    ///
    /// # Errors
    /// If the file cannot be read, is larger than its [`budget`](crate::budget), or is not what its extension says.
    #[cfg(feature = "import")]
    pub fn read(path: &Path) -> Result<Self, MeshError> {
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or_default();
        let (parser, read): (_, Read) = match extension.to_ascii_lowercase().as_str() {
            "stl" => ("the reader of STL files", stl::read),
            "obj" => ("the reader of OBJ files", obj::read),
            "gltf" | "glb" => ("the reader of glTF files", gltf::read),
            "msh" => ("the reader of MSH files", msh::read),
            _ => return Err(MeshError::Unknown(path.to_owned())),
        };
        let mesh = foreign::parse(parser, || read(path)).map_err(|panicked| MeshError::damaged(path, panicked))??;
        mesh.checked(path)
    }

    /// Always an error in this build.
    ///
    /// # Errors
    /// Always.
    #[cfg(not(feature = "import"))]
    pub fn read(path: &Path) -> Result<Self, MeshError> {
        Err(MeshError::Absent(path.to_owned()))
    }

    /// Lowest and highest corner; `None` without corners.
    pub fn bounds(&self) -> Option<[[f32; 3]; 2]> {
        let first = *self.vertices.first()?;
        let widen = |[low, high]: [[f32; 3]; 2], at: &[f32; 3]| {
            [0, 1].map(|end| std::array::from_fn(|i| if end == 0 { low[i].min(at[i]) } else { high[i].max(at[i]) }))
        };
        Some(self.vertices.iter().fold([first, first], widen))
    }

    /// Corners that are there and numbers that are finite.
    #[cfg(feature = "import")]
    fn checked(self, path: &Path) -> Result<Self, MeshError> {
        file::check_size(path, self.vertices.len(), self.triangles.len())?;
        let count = self.vertices.len();
        if let Some(corner) = self.triangles.iter().flatten().find(|corner| **corner as usize >= count) {
            return Err(MeshError::damaged(path, format!("a triangle names corner {corner}, there are {count}")));
        }
        if let Some(at) = self.vertices.iter().flatten().find(|x| !x.is_finite()) {
            return Err(MeshError::damaged(path, format!("a corner is at {at}")));
        }
        if self.triangles.is_empty() {
            return Err(MeshError::damaged(path, "it has no triangles".to_owned()));
        }
        Ok(self)
    }
}
