//! `<asset>`: meshes, and materials for their colours.

use super::super::log::Taken;
use super::super::xml::Element;
use super::super::{Options, files};
use super::defaults::{Defaults, Settled};
use super::geom::{Assets, Mesh};
use super::settings::Settings;
use super::tree::Tree;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use std::collections::HashMap;
use std::path::Path;

/// Where files are found, and from where they are named.
pub(super) struct Folders<'o> {
    pub(super) model: &'o Path,
    pub(super) options: &'o Options,
}

pub(super) fn read<'a>(tree: &Tree<'a>, defaults: &Defaults<'a>, settings: &Settings, folders: &Folders<'_>) -> Assets {
    let mut assets = Assets { meshes: HashMap::new(), colors: HashMap::new() };
    for element in tree.section("asset") {
        match element.name() {
            "mesh" => {
                let settled = defaults.of(&element, None);
                if let Some((name, mesh)) = mesh(&settled, settings, folders) {
                    assets.meshes.insert(name, mesh);
                }
            }
            "material" => {
                let settled = defaults.of(&element, None);
                if let (Some(name), Some(color)) = (element.text("name"), settled.vector::<4>("rgba")) {
                    assets.colors.insert(name.to_owned(), color.map(|part| part.clamp(0.0, 1.0)));
                }
            }
            _ => {}
        }
    }
    assets
}

/// The last part of a file's path, whichever way it leans.
fn base(file: &str) -> &str {
    file.rsplit(['/', '\\']).next().unwrap_or(file)
}

fn mesh(settled: &Settled<'_>, settings: &Settings, folders: &Folders<'_>) -> Option<(String, Mesh)> {
    let element: Element<'_> = settled.element;
    let file = settled.text("file");
    let stem = || file.map(|file| base(file).rsplit_once('.').map_or(base(file), |(stem, _)| stem).to_owned());
    let name = element.text("name").map(str::to_owned).or_else(stem)?;
    let scale = settled.vector("scale").unwrap_or([1.0; 3]);
    let path = file.and_then(|file| {
        let within = settings.mesh_folder.join(if settings.strip_path { base(file) } else { file });
        let path = folders.model.parent().unwrap_or(Path::new("")).join(within);
        let found = path.is_file();
        if !found {
            element.note(Taken::Ignored, format!("no file `{}`: it is not drawn", path.display()));
        }
        found.then_some(path)
    });
    if file.is_none() {
        element.note(Taken::Ignored, "vertices in the model itself: it is not drawn");
    }
    if scale.iter().any(|factor| *factor <= 0.0) {
        element.note(Taken::Ignored, "`scale` mirrors it: it is not drawn");
    }
    let drawn = path.as_ref().filter(|_| scale.iter().all(|factor| *factor > 0.0));
    let file = drawn.map(|path| files::from_folder(path, folders.options.folder.as_deref(), folders.model));
    Some((name, Mesh { file, scale, path, frame: frame(settled, scale) }))
}

/// `refpos` and `refquat`: they are taken off the vertices before these are scaled.
fn frame(settled: &Settled<'_>, scale: [f64; 3]) -> Isometry3<f64> {
    let at = settled.vector("refpos").map_or_else(Vector3::zeros, Vector3::from);
    let turn = settled.vector("refquat").map_or_else(UnitQuaternion::identity, |[w, x, y, z]: [f64; 4]| {
        UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
    });
    if turn.angle() > 0.0 && scale != [scale[0]; 3] {
        settled
            .element
            .note(Taken::Approximated, "`refquat` with unequal `scale`: it is drawn scaled along its old axes");
    }
    let moved = Translation3::from(at.component_mul(&Vector3::from(scale)));
    (moved * turn).inverse()
}
