//! Meshes: the same box out of every format, what it weighs, and files that lie.

use nalgebra::Vector3;
use std::path::PathBuf;
use stillpoint::mesh::Mesh;
use stillpoint::model::shape::{Geometry, Shape};
use stillpoint::scenario::load;

/// Edges of the box, and where its lowest corner is; all of them numbers that 32 bits hold.
const EDGES: [f32; 3] = [0.5, 0.25, 1.0];
const LOW: [f32; 3] = [0.25, -0.5, 2.0];

fn corner(index: usize) -> [f32; 3] {
    std::array::from_fn(|axis| LOW[axis] + if index >> axis & 1 == 1 { EDGES[axis] } else { 0.0 })
}

/// Two triangles per side, seen from outside.
const TRIANGLES: [[usize; 3]; 12] = [
    [0, 2, 1],
    [1, 2, 3],
    [4, 5, 6],
    [5, 7, 6],
    [0, 1, 4],
    [1, 5, 4],
    [2, 6, 3],
    [3, 6, 7],
    [0, 4, 2],
    [2, 4, 6],
    [1, 3, 5],
    [3, 7, 5],
];

fn binary_stl(triangles: &[[usize; 3]], header: &[u8]) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.resize(80, 0);
    bytes.extend(u32::try_from(triangles.len()).expect("few").to_le_bytes());
    for triangle in triangles {
        bytes.extend([0; 12]);
        triangle.iter().flat_map(|index| corner(*index)).for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

fn text_stl() -> String {
    let facet = |triangle: &[usize; 3]| {
        let vertex = |index: &usize| {
            let [x, y, z] = corner(*index);
            format!("vertex {x} {y} {z}\n")
        };
        let vertices: String = triangle.iter().map(vertex).collect();
        format!("facet normal 0 0 1\nouter loop\n{vertices}endloop\nendfacet\n")
    };
    format!("solid box\n{}endsolid box\n", TRIANGLES.iter().map(facet).collect::<String>())
}

fn obj() -> String {
    let vertices: String = (0..8).map(corner).map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    let faces: String = TRIANGLES.iter().map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1)).collect();
    format!("mtllib box.mtl\n{vertices}usemtl red\n{faces}")
}

fn buffer() -> Vec<u8> {
    let corners = (0..8).flat_map(corner).flat_map(f32::to_le_bytes);
    corners.chain(TRIANGLES.iter().flatten().map(|index| u8::try_from(*index).expect("few"))).collect()
}

/// The box once, half as large, in a node that doubles it.
fn gltf(uri: Option<&str>) -> String {
    let uri = uri.map(|uri| format!("\"uri\":\"{uri}\",")).unwrap_or_default();
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],"nodes":[{{"mesh":0}}],
        "materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[1.0,0.0,0.0,1.0]}}}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}},"indices":1,"material":0}}]}}],
        "buffers":[{{{uri}"byteLength":132}}],
        "bufferViews":[{{"buffer":0,"byteLength":96}},{{"buffer":0,"byteOffset":96,"byteLength":36}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":8,"type":"VEC3","min":[0,0,0],"max":[9,9,9]}},
        {{"bufferView":1,"componentType":5121,"count":36,"type":"SCALAR"}}]}}"#
    )
}

fn glb() -> Vec<u8> {
    let mut json = gltf(None).into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let data = buffer();
    let length = |bytes: &[u8]| u32::try_from(bytes.len()).expect("few").to_le_bytes();
    let mut file = b"glTF\x02\0\0\0".to_vec();
    file.extend(u32::try_from(12 + 8 + json.len() + 8 + data.len()).expect("few").to_le_bytes());
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", data)] {
        file.extend(length(&chunk));
        file.extend(kind);
        file.extend(chunk);
    }
    file
}

/// Eight corners, none of the rest, and so many faces as it says.
fn msh(faces: i32) -> Vec<u8> {
    let counts = [8, 0, 0, faces].map(i32::to_le_bytes).concat();
    let corners = (0..8).flat_map(corner).flat_map(f32::to_le_bytes);
    let triangles = TRIANGLES.iter().flatten().flat_map(|index| i32::try_from(*index).expect("few").to_le_bytes());
    counts.into_iter().chain(corners).chain(triangles).collect()
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).expect("a file");
        path
    }

    fn said(&self, name: &str, bytes: impl AsRef<[u8]>) -> String {
        let path = self.write(name, bytes);
        let error = Mesh::read(&path).expect_err("a file that lies").to_string();
        error.replace(&path.display().to_string(), name)
    }
}

/// Every format, read.
fn boxes(folder: &Folder) -> Vec<Mesh> {
    folder.write("box.mtl", "newmtl red\nKd 1.0 0.0 0.0\n");
    folder.write("box.bin", buffer());
    let files = [
        folder.write("bytes.stl", binary_stl(&TRIANGLES, b"a box")),
        folder.write("like_text.stl", binary_stl(&TRIANGLES, b"solid box")),
        folder.write("text.STL", text_stl()),
        folder.write("box.msh", msh(12)),
        folder.write("box.obj", obj()),
        folder.write("box.gltf", gltf(Some("box.bin"))),
        folder.write("box.glb", glb()),
    ];
    files.iter().map(|file| Mesh::read(file).unwrap_or_else(|error| panic!("{error}"))).collect()
}

#[test]
fn every_format_holds_the_same_box() {
    let meshes = boxes(&Folder::new());
    let high = std::array::from_fn(|axis| LOW[axis] + EDGES[axis]);
    for mesh in &meshes {
        assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (8, 12));
        assert_eq!(mesh.bounds(), Some([LOW, high]));
    }
    for colored in &meshes[4..] {
        assert!(
            colored.colors.as_ref().is_some_and(|colors| colors.iter().all(|color| *color == [1.0, 0.0, 0.0, 1.0]))
        );
    }
}

/// A mesh of a box weighs what a box weighs, stretched and mirrored as well.
#[test]
fn a_closed_mesh_weighs_what_it_encloses() {
    for scale in [Vector3::new(1.0, 1.0, 1.0), Vector3::new(2.0, 0.5, 3.0), Vector3::new(-1.0, 1.0, 2.0)] {
        let edges = Vector3::from(EDGES).cast::<f64>().component_mul(&scale).abs();
        let middle = (Vector3::from(LOW) + 0.5 * Vector3::from(EDGES)).cast::<f64>().component_mul(&scale);
        let exact =
            Shape { geometry: Geometry::Box(edges), pose: middle.into(), color: None, collides: true, visible: true };
        let exact = exact.mass_properties(1.0).expect("a box");
        for mesh in boxes(&Folder::new()) {
            let solid = mesh.solid(scale).expect("a closed mesh");
            // Round-off of a dozen terms.
            assert!((solid.volume - exact.mass).abs() < 1e-14 * exact.mass);
            assert!((solid.center - exact.center).norm() < 1e-14);
            assert!((solid.inertia - exact.inertia).norm() < 1e-14 * exact.inertia.norm());
            assert!(!solid.inside_out);
        }
    }
}

#[test]
fn a_mesh_that_is_open_or_inside_out_is_told() {
    let folder = Folder::new();
    let open = Mesh::read(&folder.write("open.stl", binary_stl(&TRIANGLES[1..], b""))).expect("a mesh");
    let error = open.solid(Vector3::repeat(1.0)).expect_err("a hole");
    assert!(error.to_string().starts_with("it is not closed: 3 edges"), "{error}");
    let turned: Vec<[usize; 3]> = TRIANGLES.iter().map(|[a, b, c]| [*a, *c, *b]).collect();
    let mesh = Mesh::read(&folder.write("turned.stl", binary_stl(&turned, b""))).expect("a mesh");
    let solid = mesh.solid(Vector3::repeat(1.0)).expect("closed");
    assert!(solid.inside_out && (solid.volume - 0.125).abs() < 1e-15);
    let flat = [[0, 1, 2], [0, 2, 1]];
    let flat = Mesh::read(&folder.write("flat.stl", binary_stl(&flat, b""))).expect("a mesh");
    assert_eq!(flat.solid(Vector3::repeat(1.0)).expect_err("flat").to_string(), "it encloses no volume");
}

/// `density` beside a mesh: twice as high weighs twice as much; a hole is an error with a way out.
#[test]
fn density_fills_a_mesh() {
    let folder = Folder::new();
    folder.write("box.stl", binary_stl(&TRIANGLES, b""));
    folder.write("hole.stl", binary_stl(&TRIANGLES[1..], b""));
    let body = |mesh: &str| {
        format!(
            "[[body]]\nname = \"a\"\ndensity = 1000.0\nhinge = {{ type = \"free\" }}\n\
             shape = {{ mesh = \"{mesh}\", scale = [1.0, 1.0, 2.0], at = [0.0, 0.0, 1.0] }}\n"
        )
    };
    let scenario = load(&folder.write("scene.toml", body("box.stl"))).unwrap_or_else(|error| panic!("{error}"));
    let mass = scenario.description.bodies[0].mass;
    assert!((mass.mass - 250.0).abs() < 1e-11 && (mass.center - Vector3::new(0.5, -0.375, 6.0)).norm() < 1e-14);
    let said = load(&folder.write("scene.toml", body("hole.stl"))).expect_err("a hole").to_string();
    assert!(said.contains("has no mass: it is not closed: 3 edges") && said.contains("help: close the mesh"), "{said}");
}

#[test]
fn files_that_lie_are_refused() {
    let folder = Folder::new();
    let mut many = binary_stl(&TRIANGLES, b"");
    many[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    let huge = gltf(Some("box.bin")).replace("\"count\":8", "\"count\":4000000000");
    let far = gltf(Some("box.bin")).replace("\"byteLength\":36", "\"byteLength\":3600");
    let wild = obj().replace("f 1 3 2", "f 1 3 200");
    folder.write("box.bin", buffer());
    folder.write("short.bin", &buffer()[..100]);
    let cut = &binary_stl(&TRIANGLES, b"")[..333];
    let lost = gltf(Some("data:application/octet-stream;base64,AAAA"));
    for (name, bytes, expected) in [
        ("many.stl", &many[..], "4294967295 triangles, as its header says, take 214748364834 bytes; it has 684"),
        ("cut.stl", cut, "12 triangles, as its header says, take 684 bytes; it has 333"),
        ("empty.stl", b"", "0 bytes are too few for an STL file"),
        ("words.stl", b"solid words\nfacet abnormal\n", "is damaged"),
        ("none.stl", &binary_stl(&[], b""), "it has no triangles"),
        ("huge.gltf", huge.as_bytes(), "accessor 0: its 4000000000 items do not lie in its buffer of 132 bytes"),
        ("far.gltf", far.as_bytes(), "accessor 1: its 36 items do not lie in its buffer of 132 bytes"),
        ("short.gltf", gltf(Some("short.bin")).as_bytes(), "buffer 0 should have 132 bytes; it has 100"),
        ("lost.gltf", lost.as_bytes(), "buffer 0 should have 132 bytes; it has 3"),
        ("wild.obj", wild.as_bytes(), "is damaged"),
        ("cut.glb", &glb()[..200], "is damaged"),
        ("far.msh", &msh(4000)[..], "its header asks for 48112 bytes; it has 256"),
        ("short.msh", b"abc", "it does not begin with four counts"),
        ("a.dae", b"<COLLADA/>", "is of a kind that is not read; allowed: .stl, .obj, .gltf, .glb, .msh"),
    ] {
        let said = folder.said(name, bytes);
        assert!(said.contains(name) && said.contains(expected), "{said}");
    }
}
