//! MJCF, the models of MuJoCo.
//!
//! ```text
//! model.xml ─ tree ─► elements, includes expanded ─ model (defaults, settings, assets) ─► body, joint, geom, mass ─► Scene
//!                                                                                                       │
//!            Draft ◄─ lower ◄─ couple (loops, gears), actuator, tendon (springs), key (start) ◄─────────┘
//! ```
//!
//! What MuJoCo does is taken over where it has an equal here, exactly: bodies, joints in any number per body, mass
//! properties, springs, dampers, armature, servos. Its soft constraints become rigid ones. What has no equal is noted.

mod actuator;
mod asset;
mod attach;
mod body;
mod collide;
mod couple;
mod defaults;
mod geom;
mod ignored;
mod inertia;
mod joint;
mod key;
mod law;
mod limits;
mod lower;
mod mass;
mod model;
mod pair;
mod pose;
mod scene;
mod servo;
mod settings;
mod tendon;
mod touch;
mod tree;
mod weigh;
mod weld;

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
    let models = model::read(&tree, path, options);
    let mut scene = body::read(&models, 0);
    mass::scale(&mut scene);
    if scene.bodies.len() == 1
        && let Some(found) = root.within(&["composite", "flexcomp"])
    {
        let message = format!("`{}` is not imported, and the model has no other body", found.name());
        found.refuse(Problem::at(found.place(), message).help("describe what is slender and bends with `[[beam]]`"));
    }
    let key = key::read(&models, &scene.instances, options);
    key.place(&models, &mut scene);
    if !log.is_fine() {
        return None;
    }
    if options.weld_massless {
        weld::massless(&mut scene);
    }
    limits::settle(&mut scene, options);
    let mut output = lower::Output::new(&scene, options);
    let mut tendons = tendon::Tendons::default();
    for instance in scene.instances.clone() {
        let model = &models[instance.model];
        scene.enter(&instance, &models);
        tendon::read(&model.tree, &model.defaults, &mut scene, &mut output, &mut tendons);
        if scene.settings.contacts {
            pair::read(&model.tree, &model.defaults, &mut scene);
        }
        couple::read(&model.tree, &model.defaults, &mut scene, &tendons, &mut output);
    }
    actuator::read(&models, &mut scene, &tendons, &key, &mut output);
    limits::note_coupled(&scene);
    let mut draft = Draft::new();
    output.write(&scene, &key, options, &mut draft);
    ignored::sweep(&tree);
    log.gather();
    Some(draft)
}
