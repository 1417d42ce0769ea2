//! Wavefront OBJ, with the colours of its materials.

use super::Mesh;
use super::file::{MeshError, bytes, bytes_up_to, check_size};
use crate::budget::MATERIAL_BYTES;
use std::cell::Cell;
use std::io::Cursor;
use std::path::Path;

const OPTIONS: tobj::LoadOptions =
    tobj::LoadOptions { single_index: true, triangulate: false, ignore_points: true, ignore_lines: true };

pub(super) fn read(path: &Path) -> Result<Mesh, MeshError> {
    let text = bytes(path)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    let (corners, triangles) = size(&text);
    check_size(path, corners, triangles)?;
    let left = Cell::new(MATERIAL_BYTES);
    // A material that is missing costs its colour.
    let material = |file: &Path| match bytes_up_to(&folder.join(file), left.get()) {
        Ok(bytes) => {
            left.set(left.get().saturating_sub(bytes.len() as u64));
            tobj::load_mtl_buf(&mut Cursor::new(bytes))
        }
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
        let (mut rest, mut arities) = (&mesh.indices[..], mesh.face_arities.iter());
        while !rest.is_empty() {
            // Without counts all are triangles.
            let count = arities.next().map_or(3, |count| *count as usize).clamp(1, rest.len());
            let (face, others) = rest.split_at(count);
            whole.triangles.extend(cut(face, corners).iter().map(|it| it.map(|corner| corner.saturating_add(first))));
            rest = others;
        }
    }
    whole.normals = (normals.len() == whole.vertices.len()).then_some(normals);
    whole.colors = colored.then_some(colors);
    Ok(whole)
}

/// A face as triangles. Of four corners, which need not lie in a plane, the shorter diagonal is the edge, as most readers of
/// this format have it; others are a fan from their first corner.
fn cut(face: &[u32], corners: &[[f32; 3]]) -> Vec<[u32; 3]> {
    if let [a, b, c, d] = *face {
        let apart = |one: u32, other: u32| {
            let ends = corners.get(one as usize).zip(corners.get(other as usize));
            ends.map_or(0.0, |(one, other)| one.iter().zip(other).map(|(x, y)| (x - y) * (x - y)).sum::<f32>())
        };
        return if apart(a, c) < apart(b, d) { vec![[a, b, c], [a, c, d]] } else { vec![[a, b, d], [b, c, d]] };
    }
    let fan = face.windows(2).skip(1).map(|pair| [face[0], pair[0], pair[1]]);
    fan.collect()
}

/// How many corners and triangles a text says, by the letters of its lines.
fn size(text: &[u8]) -> (usize, usize) {
    let mut counts = (0, 0);
    for line in text.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii_start) {
        match line {
            [b'v', b' ' | b'\t', ..] => counts.0 += 1,
            [b'f', b' ' | b'\t', rest @ ..] => {
                let corners = rest.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).count();
                counts.1 += corners.saturating_sub(2);
            }
            _ => {}
        }
    }
    counts
}
