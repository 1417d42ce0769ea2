//! MSH, the binary meshes of MuJoCo: four counts, then corners, normals, texture coordinates and triangles.

use super::Mesh;
use super::file::{MeshError, bytes};
use std::path::Path;

/// Four counts of 32 bits.
const HEADER: usize = 16;

pub(super) fn read(path: &Path) -> Result<Mesh, MeshError> {
    let bytes = bytes(path)?;
    let (words, rest) = bytes.as_chunks::<4>();
    let count = |index: usize| words.get(index).and_then(|word| usize::try_from(i32::from_le_bytes(*word)).ok());
    let counts = [count(0), count(1), count(2), count(3)];
    let [Some(corners), Some(normals), Some(textures), Some(faces)] = counts else {
        return Err(MeshError::damaged(path, "it does not begin with four counts"));
    };
    // Counts are below 2³¹: the sum does not overflow 64 bits. It is looked at before anything of its size is allocated.
    let claimed =
        HEADER as u64 + 4 * (3 * corners as u64 + 3 * normals as u64 + 2 * textures as u64 + 3 * faces as u64);
    if claimed != bytes.len() as u64 || !rest.is_empty() {
        let what = format!("its header asks for {claimed} bytes; it has {}", bytes.len());
        return Err(MeshError::damaged(path, what));
    }
    let (vertices, others) = words[4..].split_at(3 * corners);
    let triangles = &others[3 * normals + 2 * textures..];
    let vertices = vertices.as_chunks::<3>().0.iter().map(|at| at.map(f32::from_le_bytes)).collect();
    let triangles = triangles.as_chunks::<3>().0.iter().map(|at| at.map(u32::from_le_bytes)).collect();
    Ok(Mesh { vertices, triangles, normals: None, colors: None })
}
