//! Damaged meshes are answered with a mesh or an error, never with a panic.

use super::{each, edits};
use std::path::Path;
use stillpoint::mesh::Mesh;

const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nusemtl a\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
const MTL: &str = "newmtl a\nKa 1 1 1\nKd 0.5 0.25 0.125\nKs 0 0 0\nNs 10\nd 1\nillum 2\n";

const WORDS: &[&[u8]] = &[
    b" ",
    b"\n",
    b"v",
    b"vn",
    b"vt",
    b"f",
    b"Kd",
    b"Kd 0 0\n",
    b"Ka\n",
    b"d\n",
    b"usemtl",
    b"mtllib",
    b"1/2/3",
    b"-1",
    b"0",
    b"1e999",
    b"nan",
    b"99999999999",
    b"\0",
    b"\xff",
];

fn answered(path: &Path) {
    match Mesh::read(path) {
        Ok(mesh) => assert!(mesh.triangles.iter().flatten().all(|corner| (*corner as usize) < mesh.vertices.len())),
        Err(error) => assert!(error.to_string().contains(&path.display().to_string()), "{error}"),
    }
}

#[test]
fn damaged_materials_and_objects_are_answered() {
    let folder = tempfile::tempdir().expect("a folder");
    let (obj, mtl) = (folder.path().join("o.obj"), folder.path().join("m.mtl"));
    each(1000, (edits(12, WORDS), edits(12, WORDS)), |(of_obj, of_mtl)| {
        let (mut o, mut m) = (OBJ.as_bytes().to_vec(), MTL.as_bytes().to_vec());
        of_obj.iter().for_each(|edit| edit.apply(&mut o));
        of_mtl.iter().for_each(|edit| edit.apply(&mut m));
        std::fs::write(&mtl, m).expect("written");
        std::fs::write(&obj, OBJ).expect("written");
        answered(&obj);
        std::fs::write(&obj, o).expect("written");
        answered(&obj);
        Ok(())
    });
}

#[test]
fn a_parser_that_panics_is_named_with_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let obj = folder.path().join("o.obj");
    std::fs::write(&obj, OBJ).expect("written");
    for colour in ["Kd 0 0", "Kd 0", "Ka 1 1"] {
        std::fs::write(folder.path().join("m.mtl"), format!("newmtl a\n{colour}\n")).expect("written");
        answered(&obj);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn devices_are_no_meshes_and_no_materials() {
    let folder = tempfile::tempdir().expect("a folder");
    let obj = folder.path().join("o.obj");
    let many = "mtllib /dev/zero\n".repeat(30);
    std::fs::write(&obj, OBJ.replace("mtllib m.mtl\n", &many)).expect("written");
    assert_eq!(Mesh::read(&obj).expect("a mesh without colours").triangles.len(), 4);
    std::os::unix::fs::symlink("/dev/zero", folder.path().join("z.stl")).expect("linked");
    let said = Mesh::read(&folder.path().join("z.stl")).expect_err("no end").to_string();
    assert!(said.contains("no regular file"), "{said}");
}
