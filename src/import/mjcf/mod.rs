//! MJCF, the models of MuJoCo.
//!
//! ```text
//! model.xml ─ tree ─► elements, includes expanded ─ defaults, settings ─► body, joint, geom, mass ─► Scene
//!                                                                                                       │
//!            Draft ◄─ lower ◄─ couple (loops, gears), actuator, tendon (springs), key (start) ◄─────────┘
//! ```
//!
//! What MuJoCo does is taken over where it has an equal here, exactly: bodies, joints in any number per body, mass
//! properties, springs, dampers, armature, servos. Its soft constraints become rigid ones. What has no equal is noted.

mod actuator;
mod asset;
mod body;
mod couple;
mod defaults;
mod geom;
mod ignored;
mod inertia;
mod joint;
mod key;
mod lower;
mod mass;
mod pose;
mod scene;
mod servo;
mod settings;
mod tendon;
mod tree;

use super::Options;
use super::draft::Draft;
use super::log::Problem;
use super::xml::Element;
use std::path::Path;

/// Reads a model; what is wrong in it is in the log.
pub(super) fn read(root: &Element<'_>, path: &Path, options: &Options) -> Option<Draft> {
    let log = root.log;
    if options.floating {
        let message = "an MJCF model says itself what floats".to_owned();
        log.refuse(Problem::at(root.place(), message).help("give the body a <freejoint/>"));
        return None;
    }
    let files = tree::Files::gather(root, path)?;
    let documents = files.documents(log)?;
    let tree = tree::Tree { root: *root, files: &files, documents: &documents };
    let settings = settings::read(&tree);
    let defaults = defaults::Defaults::read(&tree);
    let assets = asset::read(&tree, &defaults, &settings, &asset::Folders { model: path, options });
    let mut scene = body::read(&tree, &defaults, &settings, &assets);
    mass::scale(&mut scene);
    let key = key::read(&tree, options);
    key.place(&tree, &mut scene);
    if !log.is_fine() {
        return None;
    }
    let mut output = lower::Output::new(&scene, options);
    let tendons = tendon::read(&tree, &defaults, &mut scene, &mut output);
    couple::read(&tree, &defaults, &mut scene, &tendons, &mut output);
    actuator::read(&tree, &defaults, &mut scene, &tendons, &key, &mut output);
    lower::note_limits(&mut scene, options);
    let mut draft = Draft::new();
    output.write(&scene, &key, options, &mut draft);
    ignored::sweep(&tree);
    log.gather();
    Some(draft)
}
