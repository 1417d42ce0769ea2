//! Wavefront OBJ, with the colours of its materials.

use super::Mesh;
use super::file::{MeshError, bytes};
use std::io::Cursor;
use std::path::Path;

const OPTIONS: tobj::LoadOptions =
    tobj::LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };

pub(super) fn read(path: &Path) -> Result<Mesh, MeshError> {
    let text = bytes(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    // A material that is missing costs its colour.
    let material = |file: &Path| match bytes(&folder.join(file)) {
        Ok(bytes) => tobj::load_mtl_buf(&mut Cursor::new(bytes)),
        Err(_) => Err(tobj::LoadError::OpenFileFailed),
    };
    let (parts, materials) = tobj::load_obj_buf(&mut Cursor::new(text), &OPTIONS, material)
        .map_err(|error| MeshError::damaged(path, error))?;
    let materials = materials.unwrap_or_default();
    let mut whole = Mesh::default();
    let (mut normals, mut colors, mut colored) = (Vec::new(), Vec::new(), false);
    for part in parts {
        let first = u32::try_from(whole.vertices.len()).map_err(|_| MeshError::damaged(path, "too many corners"))?;
        let mesh = part.mesh;
        let (corners, _) = mesh.positions.as_chunks::<3>();
        let diffuse = mesh.material_id.and_then(|id| materials.get(id)?.diffuse);
        colored |= diffuse.is_some() || !mesh.vertex_color.is_empty();
        match mesh.vertex_color.as_chunks::<3>().0 {
            own if own.len() == corners.len() => colors.extend(own.iter().map(|[r, g, b]| [*r, *g, *b, 1.0])),
            _ => {
                let [r, g, b] = diffuse.unwrap_or([1.0; 3]);
                colors.extend(corners.iter().map(|_| [r, g, b, 1.0]));
            }
        }
        normals.extend_from_slice(mesh.normals.as_chunks::<3>().0);
        whole.vertices.extend_from_slice(corners);
        let triangles = mesh.indices.as_chunks::<3>().0;
        whole.triangles.extend(triangles.iter().map(|corners| corners.map(|corner| corner.saturating_add(first))));
    }
    whole.normals = (normals.len() == whole.vertices.len()).then_some(normals);
    whole.colors = colored.then_some(colors);
    Ok(whole)
}
