//! Which mesh files of a recording are read when it is looked at.

use super::Scene;
use std::collections::BTreeSet;
use std::path::Path;

/// Takes the mesh files out of a scene that do not lie in the folder of its recording or below, links followed. What is
/// left out is said; a stand-in is drawn for it.
#[cfg_attr(not(any(feature = "record", test)), expect(dead_code, reason = "only recordings are drawn"))]
pub(super) fn keep_own(scene: &mut Scene, recording: &Path) -> Vec<String> {
    let folder = recording.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let folder = folder.canonicalize();
    let is_own = |file: &str| {
        let own =
            |folder: &std::path::PathBuf| Path::new(file).canonicalize().is_ok_and(|file| file.starts_with(folder));
        folder.as_ref().is_ok_and(own)
    };
    let mut strangers = BTreeSet::new();
    for shape in scene.bodies.iter_mut().flat_map(|body| &mut body.shapes) {
        if let Some(file) = shape.file.take_if(|file| !is_own(file)) {
            strangers.insert(file);
        }
    }
    let note = |first: &String| {
        let more = if strangers.len() > 1 { format!(" and {} more", strangers.len() - 1) } else { String::new() };
        format!("the mesh `{first}`{more} is not in the recording's folder and is not drawn; `--meshes` reads it")
    };
    strangers.first().map(note).into_iter().collect()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use crate::record::scene::{BodyPicture, ShapePicture};

    #[test]
    fn only_files_of_the_folder_are_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let own = folder.path().join("own");
        std::fs::create_dir_all(own.join("below")).expect("folders");
        for name in ["stranger.stl", "own/mesh.stl", "own/below/mesh.stl"] {
            std::fs::write(folder.path().join(name), "solid").expect("written");
        }
        std::os::unix::fs::symlink(folder.path().join("stranger.stl"), own.join("link.stl")).expect("linked");
        let shape = |name: &str| ShapePicture {
            kind: "mesh".into(),
            size: vec![1.0],
            file: Some(own.join(name).display().to_string()),
            position: [0.0; 3],
            quaternion: [1.0, 0.0, 0.0, 0.0],
            color: None,
        };
        let names = ["mesh.stl", "below/mesh.stl", "link.stl", "../stranger.stl", "missing.stl", "/etc/passwd"];
        let body = BodyPicture {
            name: "body".into(),
            parent: None,
            mass: 1.0,
            center: [0.0; 3],
            inertia: [1.0; 6],
            markers: Vec::new(),
            shapes: names.map(shape).into(),
            hinge: "free".into(),
            hinge_axes: Vec::new(),
            hinge_at: [0.0; 3],
            own_axes: Vec::new(),
        };
        let mut scene = Scene { bodies: vec![body], ..Scene::default() };
        let notes = keep_own(&mut scene, &own.join("run.mcap"));
        let kept: Vec<bool> = scene.bodies[0].shapes.iter().map(|shape| shape.file.is_some()).collect();
        assert_eq!(kept, [true, true, false, false, false, false]);
        assert!(notes.len() == 1 && notes[0].contains("and 3 more"), "{notes:?}");
    }
}
