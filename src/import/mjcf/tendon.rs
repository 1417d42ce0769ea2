//! `<tendon>`: springs along a line, and springs in a joint.

use super::super::draft::Entry;
use super::super::log::Taken;
use super::super::xml::{Attribute, Element};
use super::defaults::{Defaults, Settled};
use super::lower::Output;
use super::scene::{Joint, Scene, find};
use super::tree::Tree;
use std::collections::HashMap;

/// Tendons by name, for those that refer to them.
#[derive(Default)]
pub(super) struct Tendons {
    names: HashMap<String, Path>,
}

/// What a tendon runs over.
#[derive(Clone)]
pub(super) enum Path {
    /// Joints and their factors.
    Fixed(Vec<(usize, f64)>),
    /// Two sites.
    Line([usize; 2]),
    /// What cannot be told here.
    Other,
}

impl Tendons {
    /// The joints of a fixed tendon.
    pub(super) fn fixed(&self, attribute: &Attribute<'_>, scene: &Scene<'_>) -> Option<Vec<(usize, f64)>> {
        match self.path(attribute, scene)? {
            Path::Fixed(terms) => Some(terms.clone()),
            _ => None,
        }
    }

    /// Whether there is one of this name, as the whole model has it.
    pub(super) fn has(&self, name: &str) -> bool {
        self.names.contains_key(name)
    }

    /// What a tendon runs over; `None` if there is no such tendon: that has been said.
    pub(super) fn path(&self, attribute: &Attribute<'_>, scene: &Scene<'_>) -> Option<&Path> {
        let found = self.names.get(&scene.full(attribute.value));
        if found.is_none() && !scene.prefix.is_empty() {
            let what =
                format!("the tendon `{}` of its model is not attached: nor is what refers to it", attribute.value);
            attribute.element.note(Taken::Ignored, what);
        } else if found.is_none() {
            let near = attribute.element.log.near(attribute.value, self.names.keys().map(String::as_str));
            let help = near.map(|near| format!("did you mean `{near}`?"));
            let problem = attribute.wrong(&format!("is \"{}\": there is no such tendon", attribute.value));
            attribute.element.refuse(problem.maybe_help(help));
        }
        found
    }
}

/// Reads the tendons of a model and what acts along them.
pub(super) fn read<'a>(
    tree: &Tree<'a>,
    defaults: &Defaults<'a>,
    scene: &mut Scene<'a>,
    output: &mut Output,
    tendons: &mut Tendons,
) {
    for element in tree.section("tendon") {
        if !["fixed", "spatial"].contains(&element.name()) {
            continue;
        }
        let settled = defaults.under(&element, "tendon", None);
        let path = match element.name() {
            "fixed" => fixed(tree, &element, scene),
            _ => line(tree, &element, scene),
        };
        if path.is_none() && !scene.prefix.is_empty() {
            settled.skip(&[
                "name",
                "stiffness",
                "damping",
                "springlength",
                "range",
                "limited",
                "frictionloss",
                "armature",
            ]);
            continue;
        }
        let path = path.unwrap_or(Path::Other);
        acts(&settled, &path, scene, output);
        if let Some(name) = element.text("name") {
            tendons.names.insert(scene.full(name), path);
        }
    }
}

fn fixed<'a>(tree: &Tree<'a>, element: &Element<'a>, scene: &Scene<'a>) -> Option<Path> {
    let mut terms: Vec<(usize, f64)> = Vec::new();
    for part in tree.all(element, "joint") {
        let attribute = part.required("joint")?;
        let joint = find(&attribute, "joint", &scene.names.joints, scene)?;
        part.required("coef")?;
        let factor = part.number("coef")?;
        if !scene.joints[joint].kind.is_scalar() {
            part.refuse(attribute.wrong("must be a hinge or a slide"));
            return None;
        }
        terms.push((joint, factor));
    }
    Some(Path::Fixed(terms))
}

fn line<'a>(tree: &Tree<'a>, element: &Element<'a>, scene: &Scene<'a>) -> Option<Path> {
    let parts = tree.children(element);
    let mut sites = Vec::new();
    for part in &parts {
        part.see();
        match part.name() {
            "site" => {
                let attribute = part.required("site")?;
                sites.push(find(&attribute, "site", &scene.names.sites, scene)?);
            }
            "geom" => Settled::bare(part).skip(&["geom", "sidesite"]),
            "pulley" => Settled::bare(part).skip(&["divisor"]),
            _ => {}
        }
    }
    Some(match <[usize; 2]>::try_from(sites) {
        Ok(ends) if parts.len() == 2 => Path::Line(ends),
        _ => Path::Other,
    })
}

fn acts<'a>(settled: &Settled<'a>, path: &Path, scene: &mut Scene<'a>, output: &mut Output) {
    let element = settled.element;
    let first = |key: &str| settled.numbers(key, 3).unwrap_or_else(|| vec![0.0]);
    let (stiffness, damping) = (first("stiffness"), first("damping"));
    if stiffness.iter().chain(&damping).any(|number| !(*number >= 0.0)) {
        settled.refuse("stiffness and damping must be ≥ 0", "");
        return;
    }
    if stiffness.iter().skip(1).chain(damping.iter().skip(1)).any(|number| *number != 0.0) {
        element.note(Taken::Approximated, "of stiffness and damping only the linear parts are taken");
    }
    for key in ["frictionloss", "armature"] {
        if settled.number(key).is_some_and(|number| number != 0.0) {
            element.note(Taken::Ignored, format!("`{key}` along a tendon"));
        }
    }
    settled.skip(&["range"]);
    if settled.limited("limited", "range", scene.settings.autolimits) && scene.settings.limits {
        element.note(Taken::Ignored, "`range`: the length of a tendon has no stop here");
    }
    let stiffness = if scene.settings.springs { stiffness[0] } else { 0.0 };
    let damping = if scene.settings.dampers { damping[0] } else { 0.0 };
    // −1 alone asks for the length at the reference: lengths of fixed tendons may be negative.
    let lengths = settled.numbers("springlength", 2).filter(|lengths| lengths.iter().any(|length| *length != -1.0));
    if stiffness == 0.0 && damping == 0.0 {
        if matches!(path, Path::Other) {
            element.note(Taken::Ignored, "it runs over more than two sites");
        }
        return;
    }
    if let Some([slack, taut]) = lengths.as_deref()
        && slack != taut
        && stiffness > 0.0
    {
        element.note(Taken::Ignored, "`springlength` with two lengths: a spring with play has no equal here");
        return;
    }
    let given = lengths.map(|lengths| lengths[0]);
    let relaxed = |joint: &Joint<'_>| joint.relaxed;
    match path {
        Path::Fixed(terms) => match terms[..] {
            [(joint, factor)] if factor != 0.0 => {
                let joint = &mut scene.joints[joint];
                // Length is a factor times qpos.
                let rest = given.map_or(joint.relaxed, |length| length / factor - joint.reference);
                joint.acting.spring(stiffness * factor * factor, rest);
                joint.acting.damping += damping * factor * factor;
                element.note(Taken::Used, format!("its spring and damper are in the hinge of `{}`", joint.name));
            }
            _ => {
                let what = "springs and dampers that act on several joints at once have no equal here";
                element.note(Taken::Ignored, what);
            }
        },
        Path::Line(ends) => {
            let ends = ends.map(|site| (scene.sites[site].body, scene.sites[site].pose.translation.vector));
            let poses = scene.poses(relaxed);
            let [a, b] = ends.map(|(body, at)| poses[body] * nalgebra::Point3::from(at));
            let length = given.unwrap_or_else(|| (b - a).norm());
            let says = output.says(&element, "");
            let name = output.unique(element.text("name").unwrap_or("tendon"));
            output.spring(&element, scene, (says, name), ends, [stiffness, length, damping]);
        }
        Path::Other => element.note(Taken::Ignored, "it runs over more than two sites: its spring and damper are lost"),
    }
}

impl Output {
    /// A spring between two points.
    pub(super) fn spring(
        &mut self,
        element: &Element<'_>,
        scene: &Scene<'_>,
        (says, name): (String, String),
        ends: [(usize, nalgebra::Vector3<f64>); 2],
        [stiffness, length, damping]: [f64; 3],
    ) {
        if ends[0].0 == ends[1].0 {
            element.note(Taken::Ignored, "both ends are on the same body");
            return;
        }
        let mut entry = Entry::new(Some(element.place()));
        entry.comment(&says);
        entry.set("name", name, None);
        entry.set("type", "spring", None);
        let between = ends.map(|(body, at)| self.attachment(scene, body, at));
        entry.set("between", between.into_iter().collect::<toml_edit::Array>(), None);
        entry.set("stiffness", stiffness, None);
        entry.set("length", length, None);
        if damping != 0.0 {
            entry.set("damping", damping, None);
        }
        self.forces.push(entry);
    }
}
