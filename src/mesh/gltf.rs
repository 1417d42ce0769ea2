//! glTF, as text with its buffers beside it and as one binary file. Materials give their base colour; textures,
//! animations and skins are left out.

use super::Mesh;
use super::file::{MeshError, bytes, bytes_up_to, check_size};
use crate::budget::{MESH_BYTES, MESH_DEPTH, MESH_NODES};
use base64::Engine;
use gltf::accessor::{DataType, Dimensions};
use gltf::mesh::Mode;
use gltf::{Accessor, Document, Node, Primitive};
use nalgebra::{Matrix3, Matrix4, Point3, Vector3};
use std::path::Path;

pub(super) fn read(path: &Path) -> Result<Mesh, MeshError> {
    let file = bytes(path)?;
    let gltf::Gltf { document, blob } =
        gltf::Gltf::from_slice(&file).map_err(|error| MeshError::damaged(path, error))?;
    let buffers = buffers(path, &document, blob)?;
    let mut reading =
        Reading { path, buffers, whole: Mesh::default(), normals: Vec::new(), colors: Vec::new(), visits: 0 };
    let scene = document.default_scene().or_else(|| document.scenes().next());
    match scene {
        Some(scene) => scene.nodes().try_for_each(|node| reading.node(&node, Matrix4::identity(), 0))?,
        // Without a scene every mesh stands for itself.
        None => document
            .meshes()
            .flat_map(|mesh| mesh.primitives())
            .try_for_each(|primitive| reading.primitive(&primitive, &Matrix4::identity()))?,
    }
    let Reading { mut whole, normals, colors, .. } = reading;
    whole.normals = (normals.len() == whole.vertices.len()).then_some(normals);
    whole.colors = colors.iter().any(|color| *color != [1.0; 4]).then_some(colors);
    Ok(whole)
}

fn buffers(path: &Path, document: &Document, mut blob: Option<Vec<u8>>) -> Result<Vec<Vec<u8>>, MeshError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut left = MESH_BYTES;
    let one = |buffer: gltf::Buffer<'_>| {
        let data = match buffer.source() {
            gltf::buffer::Source::Bin => blob.take().unwrap_or_default(),
            gltf::buffer::Source::Uri(uri) => match uri.strip_prefix("data:") {
                Some(data) => {
                    let data = data.split_once(";base64,").map_or("", |(_, data)| data);
                    let decoded = base64::engine::general_purpose::STANDARD.decode(data);
                    decoded.map_err(|error| MeshError::damaged(path, error))?
                }
                None => {
                    let data = bytes_up_to(&folder.join(uri), left)?;
                    left -= data.len() as u64;
                    data
                }
            },
        };
        if data.len() < buffer.length() {
            let (index, length) = (buffer.index(), buffer.length());
            let what = format!("buffer {index} should have {length} bytes; it has {}", data.len());
            return Err(MeshError::damaged(path, what));
        }
        Ok(data)
    };
    document.buffers().map(one).collect()
}

struct Reading<'p> {
    path: &'p Path,
    buffers: Vec<Vec<u8>>,
    whole: Mesh,
    normals: Vec<[f32; 3]>,
    colors: Vec<[f32; 4]>,
    /// Of nodes and primitives.
    visits: usize,
}

impl Reading<'_> {
    fn node(&mut self, node: &Node<'_>, outer: Matrix4<f32>, depth: usize) -> Result<(), MeshError> {
        if depth > MESH_DEPTH {
            return Err(MeshError::damaged(self.path, format!("its nodes are nested deeper than {MESH_DEPTH}")));
        }
        self.visit()?;
        let here = outer * Matrix4::from(node.transform().matrix());
        let primitives = node.mesh().into_iter().flat_map(|mesh| mesh.primitives());
        primitives.into_iter().try_for_each(|primitive| self.primitive(&primitive, &here))?;
        node.children().try_for_each(|child| self.node(&child, here, depth + 1))
    }

    fn primitive(&mut self, primitive: &Primitive<'_>, place: &Matrix4<f32>) -> Result<(), MeshError> {
        self.visit()?;
        let Some(positions) = primitive.get(&gltf::Semantic::Positions) else { return Ok(()) };
        if !matches!(primitive.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
            return Ok(());
        }
        let of = |accessor: &Accessor<'_>| {
            accessor.data_type() == DataType::F32 && accessor.dimensions() == Dimensions::Vec3
        };
        self.check(&positions, of(&positions))?;
        let normals = primitive.get(&gltf::Semantic::Normals);
        normals.iter().try_for_each(|accessor| self.check(accessor, of(accessor)))?;
        if let Some(indices) = primitive.indices() {
            let whole = matches!(indices.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
            self.check(&indices, whole && indices.dimensions() == Dimensions::Scalar)?;
        }
        let first = self.whole.vertices.len();
        let named = primitive.indices().map_or(positions.count(), |indices| indices.count());
        let more = if primitive.mode() == Mode::Triangles { named / 3 } else { named };
        let corners = positions.count().max(normals.as_ref().map_or(0, Accessor::count));
        check_size(self.path, first.saturating_add(corners), self.whole.triangles.len().saturating_add(more))?;
        let reader = primitive.reader(|buffer| self.buffers.get(buffer.index()).map(Vec::as_slice));
        let corners: Vec<[f32; 3]> = reader.read_positions().into_iter().flatten().collect();
        let turn: Matrix3<f32> = place.fixed_view::<3, 3>(0, 0).into();
        let upright = turn.try_inverse().map_or(turn, |inverse| inverse.transpose());
        let normals = reader.read_normals().into_iter().flatten().map(|normal| {
            let normal: Vector3<f32> = upright * Vector3::from(normal);
            <[f32; 3]>::from(normal.try_normalize(0.0).unwrap_or(normal))
        });
        self.normals.extend(normals);
        let indices: Vec<u32> = match reader.read_indices() {
            Some(indices) => indices.into_u32().collect(),
            None => (0..corners.len() as u32).collect(),
        };
        let color = primitive.material().pbr_metallic_roughness().base_color_factor();
        self.colors.extend(corners.iter().map(|_| color));
        self.whole
            .vertices
            .extend(corners.iter().map(|at| <[f32; 3]>::from(place.transform_point(&Point3::from(*at)))));
        let first = u32::try_from(first).map_err(|_| MeshError::damaged(self.path, "too many corners"))?;
        let mirrored = turn.determinant() < 0.0;
        let triangles = triangles(&indices, primitive.mode()).into_iter().map(|corners| {
            let [a, b, c] = corners.map(|corner| corner.saturating_add(first));
            if mirrored { [a, c, b] } else { [a, b, c] }
        });
        self.whole.triangles.extend(triangles);
        Ok(())
    }

    /// A node that stands in several places is visited in each, and what it draws is there so many times.
    fn visit(&mut self) -> Result<(), MeshError> {
        self.visits += 1;
        match self.visits > MESH_NODES {
            true => Err(MeshError::TooLarge {
                path: self.path.to_owned(),
                what: "nodes and primitives, each as often as it is placed",
                most: MESH_NODES as u64,
            }),
            false => Ok(()),
        }
    }

    /// What the accessor claims is there, so that reading it neither fails nor allocates more than the file.
    fn check(&self, accessor: &Accessor<'_>, fits: bool) -> Result<(), MeshError> {
        let damaged = |what: &str| Err(MeshError::damaged(self.path, format!("accessor {}: {what}", accessor.index())));
        if !fits {
            return damaged("it has the wrong type for what it is used for");
        }
        if accessor.sparse().is_some() {
            return damaged("sparse accessors are not read");
        }
        let Some(view) = accessor.view() else { return damaged("it has no data") };
        let stride = view.stride().unwrap_or(accessor.size());
        let held = self.buffers.get(view.buffer().index()).map_or(0, Vec::len);
        let end = accessor
            .count()
            .checked_sub(1)
            .and_then(|last| stride.checked_mul(last)?.checked_add(accessor.offset())?.checked_add(accessor.size()));
        let view_end = view.offset().checked_add(view.length());
        match (end, view_end) {
            (Some(end), Some(view_end)) if end <= view.length() && view_end <= held => Ok(()),
            _ => damaged(&format!("its {} items do not lie in its buffer of {held} bytes", accessor.count())),
        }
    }
}

fn triangles(indices: &[u32], mode: Mode) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let turned = |(index, corners): (usize, &[u32])| match index % 2 {
                0 => [corners[0], corners[1], corners[2]],
                _ => [corners[1], corners[0], corners[2]],
            };
            indices.windows(3).enumerate().map(turned).collect()
        }
        Mode::TriangleFan => match indices {
            [center, rim @ ..] => rim.windows(2).map(|pair| [*center, pair[0], pair[1]]).collect(),
            [] => Vec::new(),
        },
        _ => indices.as_chunks::<3>().0.to_vec(),
    }
}
