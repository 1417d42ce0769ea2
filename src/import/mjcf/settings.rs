//! What `<compiler>` and `<option>` say about the whole model.

use super::super::log::Taken;
use super::super::xml::{Attribute, Element};
use super::tree::Tree;
use crate::suggest::closest;
use nalgebra::Vector3;
use std::path::PathBuf;

/// How the file is to be read.
#[derive(Debug, Clone)]
pub(super) struct Settings {
    /// Radians in a unit of angle.
    pub(super) angle: f64,
    /// Axes of Euler angles in order; upper case letters stay in space.
    pub(super) euler: [char; 3],
    pub(super) autolimits: bool,
    pub(super) inertia_from_geoms: FromGeoms,
    pub(super) inertia_groups: [f64; 2],
    pub(super) bound_mass: f64,
    pub(super) bound_inertia: f64,
    pub(super) balance_inertia: bool,
    pub(super) total_mass: Option<f64>,
    pub(super) mesh_folder: PathBuf,
    pub(super) strip_path: bool,
    pub(super) align_free: bool,
    pub(super) gravity: Vector3<f64>,
    /// Whether the file gives it.
    pub(super) has_gravity: bool,
    /// Whether other settings of attached models are more than a warning.
    pub(super) merges: bool,
    pub(super) springs: bool,
    pub(super) dampers: bool,
    pub(super) friction: bool,
    /// Whether geoms touch each other.
    pub(super) contacts: bool,
    /// Whether a body does not touch the one that it hangs on.
    pub(super) filter_parent: bool,
    pub(super) equality: bool,
    pub(super) limits: bool,
    pub(super) actuation: bool,
    pub(super) clamp_control: bool,
    /// Groups of actuators that are switched off.
    pub(super) idle_groups: Vec<f64>,
}

/// Where mass properties come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FromGeoms {
    /// From geoms where `<inertial>` is missing.
    Auto,
    /// Always from geoms.
    Always,
    /// Always from `<inertial>`.
    Never,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            angle: std::f64::consts::PI / 180.0,
            euler: ['x', 'y', 'z'],
            autolimits: true,
            inertia_from_geoms: FromGeoms::Auto,
            inertia_groups: [0.0, 5.0],
            bound_mass: 0.0,
            bound_inertia: 0.0,
            balance_inertia: false,
            total_mass: None,
            mesh_folder: PathBuf::new(),
            strip_path: false,
            align_free: false,
            gravity: Vector3::new(0.0, 0.0, -9.81),
            has_gravity: false,
            merges: false,
            springs: true,
            dampers: true,
            friction: true,
            contacts: true,
            filter_parent: true,
            equality: true,
            limits: true,
            actuation: true,
            clamp_control: true,
            idle_groups: Vec::new(),
        }
    }
}

/// Reads both; what is wrong in them is in the log.
pub(super) fn read(tree: &Tree<'_>) -> Settings {
    let mut settings = Settings::default();
    for element in tree.all(&tree.root, "compiler") {
        settings.compiler(&element);
    }
    for element in tree.all(&tree.root, "option") {
        settings.option(tree, &element);
    }
    settings
}

impl Settings {
    /// Whether passive forces act: MuJoCo computes none, not even `gravcomp`, if springs and dampers are both switched off.
    pub(super) fn has_passive_forces(&self) -> bool {
        self.springs || self.dampers
    }

    fn compiler(&mut self, element: &Element<'_>) {
        if let Some(radian) = element.attribute("angle").and_then(|at| choice(&at, &["degree", "radian"])) {
            self.angle = if radian == 1 { 1.0 } else { std::f64::consts::PI / 180.0 };
        }
        if let Some(sequence) = element.attribute("eulerseq") {
            let letters: Vec<char> = sequence.value.chars().collect();
            match <[char; 3]>::try_from(letters) {
                Ok(letters) if letters.iter().all(|letter| "xyzXYZ".contains(*letter)) => self.euler = letters,
                _ => {
                    let problem =
                        sequence.wrong(&format!("must be three of x, y, z, X, Y, Z, found \"{}\"", sequence.value));
                    element.refuse(problem.help("\"xyz\" is the default; \"XYZ\" is roll, pitch, yaw as in URDF"));
                }
            }
        }
        if let Some(global) = element.attribute("coordinate").and_then(|at| choice(&at, &["local", "global"]))
            && global == 1
        {
            let problem = element.attribute("coordinate").map(|at| at.wrong("is \"global\", which is not read"));
            let help = "global coordinates left MuJoCo in version 2.3.4: save the model again with an older one";
            problem.into_iter().for_each(|problem| element.refuse(problem.help(help)));
        }
        if let Some(conflict) = element.attribute("conflict").and_then(|at| choice(&at, &["warning", "merge", "error"]))
        {
            self.merges = conflict != 0;
        }
        flag(element, "autolimits", &mut self.autolimits);
        flag(element, "balanceinertia", &mut self.balance_inertia);
        flag(element, "strippath", &mut self.strip_path);
        flag(element, "alignfree", &mut self.align_free);
        if let Some(from) = element.attribute("inertiafromgeom").and_then(|at| choice(&at, &["false", "true", "auto"]))
        {
            self.inertia_from_geoms = [FromGeoms::Never, FromGeoms::Always, FromGeoms::Auto][from];
        }
        if let Some(groups) = element.vector("inertiagrouprange") {
            self.inertia_groups = groups;
        }
        self.bound_mass = element.number("boundmass").unwrap_or(self.bound_mass);
        self.bound_inertia = element.number("boundinertia").unwrap_or(self.bound_inertia);
        self.total_mass = element.number("settotalmass").or(self.total_mass).filter(|mass| *mass > 0.0);
        for key in ["assetdir", "meshdir"] {
            if let Some(folder) = element.text(key) {
                self.mesh_folder = PathBuf::from(folder);
            }
        }
    }

    fn option(&mut self, tree: &Tree<'_>, element: &Element<'_>) {
        if let Some(gravity) = element.vector("gravity") {
            self.gravity = Vector3::from(gravity);
            self.has_gravity = true;
        }
        if let Some(groups) = element.attribute("actuatorgroupdisable").and_then(|at| at.numbers()) {
            self.idle_groups.extend(groups);
        }
        for key in ["timestep", "integrator"] {
            if let Some(at) = element.attribute(key) {
                let what = format!("`{key} = \"{}\"`: `[simulate]` has its own integrator and tolerance", at.value);
                element.note(Taken::Ignored, what);
            }
        }
        for key in ["density", "viscosity", "wind"] {
            if let Some(at) = element.attribute(key)
                && at.numbers().is_some_and(|list| list.iter().any(|number| *number != 0.0))
            {
                element.note(Taken::Ignored, format!("`{key} = \"{}\"`: nothing here moves in a fluid", at.value));
            }
        }
        for flags in tree.all(element, "flag") {
            let mut gravity = true;
            for (key, value) in [
                ("spring", &mut self.springs),
                ("damper", &mut self.dampers),
                ("frictionloss", &mut self.friction),
                ("equality", &mut self.equality),
                ("limit", &mut self.limits),
                ("actuation", &mut self.actuation),
                ("clampctrl", &mut self.clamp_control),
                ("gravity", &mut gravity),
                ("contact", &mut self.contacts),
                ("filterparent", &mut self.filter_parent),
            ] {
                if let Some(at) = flags.attribute(key)
                    && let Some(enabled) = choice(&at, &["disable", "enable"])
                {
                    *value = enabled == 1;
                    if enabled == 0 {
                        at.element.note(Taken::Used, format!("`{key}` is switched off, and is left out"));
                    }
                }
            }
            if let Some(passive) = flags.attribute("passive")
                && choice(&passive, &["disable", "enable"]) == Some(0)
            {
                (self.springs, self.dampers) = (false, false);
                flags.note(Taken::Used, "`passive` is switched off: springs and dampers are left out");
            }
            if !gravity {
                self.gravity = Vector3::zeros();
                self.has_gravity = true;
            }
        }
    }
}

fn flag(element: &Element<'_>, key: &str, value: &mut bool) {
    if let Some(word) = element.attribute(key).and_then(|at| choice(&at, &["false", "true"])) {
        *value = word == 1;
    }
}

/// Which of the words an attribute holds; otherwise that has been said.
pub(super) fn choice(attribute: &Attribute<'_>, words: &[&str]) -> Option<usize> {
    let found = words.iter().position(|word| *word == attribute.value);
    if found.is_none() {
        let listed = words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ");
        let problem = attribute.wrong(&format!("must be one of {listed}, found \"{}\"", attribute.value));
        let near = closest(attribute.value, words.iter().copied());
        attribute.element.refuse(problem.maybe_help(near.map(|near| format!("did you mean \"{near}\"?"))));
    }
    found
}
