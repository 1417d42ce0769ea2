//! STL, as text and as bytes.

use super::Mesh;
use super::file::{MeshError, bytes, check_size};
use std::io::Cursor;
use std::path::Path;

/// A header of 80 bytes and the number of triangles, and the bytes of each.
const HEADER: usize = 84;
const TRIANGLE: usize = 50;
/// The shortest text of a triangle: `facet normal 0 0 0 outer loop vertex 0 0 0 …`.
const SHORTEST: usize = 80;

pub(super) fn read(path: &Path) -> Result<Mesh, MeshError> {
    let mut bytes = bytes(path)?;
    // Files of bytes may begin like text, so their length decides. It is looked at first: what is read allocates by the
    // number in the header.
    let claimed = bytes.get(80..HEADER).and_then(|count| Some(u32::from_le_bytes(count.try_into().ok()?) as usize));
    let length = claimed.and_then(|count| count.checked_mul(TRIANGLE)?.checked_add(HEADER));
    if length != Some(bytes.len()) && !bytes.trim_ascii_start().starts_with(b"solid") {
        let what = match claimed.zip(length) {
            Some((count, length)) => {
                format!("{count} triangles, as its header says, take {length} bytes; it has {}", bytes.len())
            }
            None => format!("{} bytes are too few for an STL file", bytes.len()),
        };
        return Err(MeshError::damaged(path, what));
    }
    // As text a triangle takes some 100 bytes at least.
    let triangles = claimed.filter(|_| length == Some(bytes.len())).unwrap_or(bytes.len() / SHORTEST);
    check_size(path, 0, triangles)?;
    if length == Some(bytes.len()) {
        // Nothing in this header is text.
        bytes[..5].fill(0);
    }
    let read = stl_io::read_stl(&mut Cursor::new(&bytes)).map_err(|error| MeshError::damaged(path, error))?;
    let vertices = read.vertices.iter().map(|at| [at[0], at[1], at[2]]).collect();
    let corner = |corner: usize| u32::try_from(corner).unwrap_or(u32::MAX);
    let triangles = read.faces.iter().map(|face| face.vertices.map(corner)).collect();
    Ok(Mesh { vertices, triangles, normals: None, colors: None })
}
