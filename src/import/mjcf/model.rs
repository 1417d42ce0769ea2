//! A model and those that it can attach (`<asset><model>`), each with its own settings, classes and assets.

use super::super::Options;
use super::super::log::{Problem, Taken};
use super::asset::{self, Assets};
use super::defaults::Defaults;
use super::settings::{self, Settings};
use super::tree::Tree;
use std::collections::HashMap;
use std::path::Path;

/// A model before its bodies are read.
pub(super) struct Model<'a> {
    pub(super) tree: Tree<'a>,
    pub(super) settings: Settings,
    pub(super) defaults: Defaults<'a>,
    pub(super) assets: Assets,
    /// Models that it can attach, by name: places in the list of all.
    pub(super) models: HashMap<String, usize>,
}

/// Where a model's elements stand in the whole.
#[derive(Debug, Clone)]
pub(super) struct Instance {
    /// Its place in the list of all models.
    pub(super) model: usize,
    /// Stands before its names.
    pub(super) prefix: String,
    /// The bodies that it has brought.
    pub(super) bodies: std::ops::Range<usize>,
}

/// The main model first, then those within it.
pub(super) fn read<'a>(tree: &Tree<'a>, path: &Path, options: &Options) -> Vec<Model<'a>> {
    let mut list = Vec::new();
    add(tree, path, options, &mut list);
    let main = list[0].settings.clone();
    for model in list.iter_mut().skip(1) {
        model.settings.adopt(&main, &model.tree.root);
    }
    list
}

fn add<'a>(tree: &Tree<'a>, path: &Path, options: &Options, list: &mut Vec<Model<'a>>) -> usize {
    let mut settings = settings::read(tree);
    settings.friction &= !options.without_friction;
    settings.contacts &= options.contact;
    let defaults = Defaults::read(tree);
    let assets = asset::read(tree, &defaults, &settings, &asset::Folders { model: path, options });
    let index = list.len();
    list.push(Model { tree: *tree, settings, defaults, assets, models: HashMap::new() });
    for element in tree.section("asset").into_iter().filter(|element| element.name() == "model") {
        element.see();
        element.text("content_type");
        let Some((child, path)) = tree.model(&element) else { continue };
        if child.root.name() != "mujoco" {
            let message = format!("{}: a <{}> cannot be attached", element.label(), child.root.name());
            element.refuse(Problem::at(element.place(), message).help("convert it to MJCF, with <mujoco> around it"));
            continue;
        }
        let own = child.root.text("model");
        let name = element.text("name").or(own).unwrap_or_default().to_owned();
        let at = add(&child, path, options, list);
        if list[index].models.insert(name.clone(), at).is_some() {
            let message = format!("{}: two models are called `{name}`", element.label());
            element.refuse(Problem::at(element.place(), message).help("give each its own `name`"));
        }
    }
    index
}

impl Settings {
    /// Takes over what holds for all models at once; what an attached one says otherwise is noted, or refused where the main
    /// model asks for more than a warning.
    fn adopt(&mut self, main: &Self, root: &super::super::xml::Element<'_>) {
        let own = self.clone();
        self.gravity = main.gravity;
        (self.springs, self.dampers, self.equality) = (main.springs, main.dampers, main.equality);
        self.friction = main.friction;
        (self.contacts, self.filter_parent) = (main.contacts, main.filter_parent);
        (self.limits, self.actuation, self.clamp_control) = (main.limits, main.actuation, main.clamp_control);
        self.idle_groups.clone_from(&main.idle_groups);
        let flags =
            |it: &Self| [it.springs, it.dampers, it.friction, it.equality, it.limits, it.actuation, it.clamp_control];
        let gravity = own.gravity != main.gravity && own.has_gravity;
        if !gravity && flags(&own) == flags(main) && own.idle_groups.iter().all(|it| main.idle_groups.contains(it)) {
            return;
        }
        if main.merges {
            let message = "it has another gravity or other flags than the model that it is part of".to_owned();
            let help = "say them there, and leave out `conflict` in <compiler>: which of them count is not merged here";
            root.refuse(Problem::at(root.place(), message).help(help));
        } else {
            let what = "its own gravity, flags and groups in <option>: those of the model that it is part of count";
            root.note(Taken::Ignored, what);
        }
    }
}
