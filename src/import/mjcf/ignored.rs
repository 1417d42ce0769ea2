//! What nobody has read, in few words: one note for what is alike.

use super::super::log::{Place, Taken};
use super::super::xml::{self, Element};
use super::actuator::TRANSMISSION;
use super::tree::Tree;
use std::collections::{BTreeMap, BTreeSet};

/// Elements without an equal here, and why.
const ELEMENTS: [(&[&str], &str); 9] = [
    (&["contact"], "contacts are not imported without `[model] contact = true` or `convert --contact`"),
    (&["sensor"], "there are no sensors: a recording has positions, velocities, accelerations and reactions"),
    (&["visual", "statistic", "size", "custom"], "it is for MuJoCo's viewer and memory"),
    (&["light", "camera"], "the viewer has its own"),
    (&["texture", "skin", "hfield", "layer"], "it is for pictures and contacts"),
    (&["extension", "plugin"], "plugins are programs of MuJoCo"),
    (
        &["deformable", "flexcomp", "flex", "composite"],
        "bodies that bend are not imported: describe slender ones with `[[beam]]`; what it would make is missing",
    ),
    (&["lengthrange"], "it is for the muscles of MuJoCo's compiler"),
    (&["equality", "tuple", "numeric", "text"], "it has no equal here"),
];

/// Attributes without an equal here, and why.
const ATTRIBUTES: [(&[&str], &str); 7] = [
    (
        &[
            "contype",
            "conaffinity",
            "condim",
            "priority",
            "friction",
            "solmix",
            "solref",
            "solimp",
            "margin",
            "gap",
            "fluidshape",
            "fluidcoef",
            "surfacevel",
            "maxhullvert",
            "adhesion",
        ],
        "contacts are imported with `contact = true`, and then rigid; fluids are not simulated, constraints are exact",
    ),
    (&["solreflimit", "solimplimit", "solreffriction", "solimpfriction"], "stops and dry friction are rigid"),
    (
        &[
            "group",
            "user",
            "width",
            "rgba",
            "material",
            "texture",
            "texrepeat",
            "texuniform",
            "shininess",
            "specular",
            "reflectance",
            "emission",
            "metallic",
            "roughness",
            "castshadow",
            "smoothnormal",
            "octree_maxdepth",
            "normal",
            "texcoord",
            "inertia",
            "builtin",
            "params",
            "size",
            "type",
            "vertex",
            "face",
            "content_type",
        ],
        "for pictures, marks and meshes",
    ),
    (
        &[
            "actuatorgravcomp",
            "lengthrange",
            "actrange",
            "actlimited",
            "actdim",
            "actearly",
            "inheritrange",
            "dynprm",
            "nsample",
            "interp",
            "delay",
            "input",
            "velrange",
            "ffrange",
            "bias",
        ],
        "bounds, delays and states of actuators",
    ),
    (
        &[
            "fitaabb",
            "discardvisual",
            "usethread",
            "texturedir",
            "saveinertial",
            "savecompiled",
            "savecanonical",
            "conflict",
            "passthrough",
            "sleep",
            "fuse",
            "treeindex",
        ],
        "for MuJoCo's compiler",
    ),
    (&["fusestatic"], "MuJoCo merges bodies without joints first: masses differ with `settotalmass` or `boundmass`"),
    (
        &[
            "impratio",
            "cone",
            "jacobian",
            "solver",
            "iterations",
            "tolerance",
            "ls_iterations",
            "ls_tolerance",
            "noslip_iterations",
            "noslip_tolerance",
            "ccd_iterations",
            "ccd_tolerance",
            "sdf_iterations",
            "sdf_initpoints",
            "sleep_tolerance",
            "magnetic",
            "o_margin",
            "o_solref",
            "o_solimp",
            "o_friction",
            "mpr_iterations",
            "mpr_tolerance",
            "apirate",
            "collision",
            "constraint",
            "contact",
            "warmstart",
            "filterparent",
            "refsafe",
            "sensor",
            "midphase",
            "nativeccd",
            "island",
            "eulerdamp",
            "autoreset",
            "override",
            "energy",
            "fwdinv",
            "invdiscrete",
            "multiccd",
            "diagexact",
            "ipc",
            "speculative",
        ],
        "for MuJoCo's solver of contacts",
    ),
];

/// Attributes that are read where they matter, beside those of actuators: in a class that nobody uses they are nothing to tell.
const KNOWN: [&str; 49] = [
    "class",
    "childclass",
    "name",
    "pos",
    "quat",
    "axisangle",
    "euler",
    "xyaxes",
    "zaxis",
    "axis",
    "type",
    "ref",
    "springref",
    "springdamper",
    "stiffness",
    "damping",
    "armature",
    "frictionloss",
    "range",
    "limited",
    "springyield",
    "mass",
    "density",
    "size",
    "fromto",
    "mesh",
    "shellinertia",
    "scale",
    "refpos",
    "refquat",
    "file",
    "springlength",
    "kp",
    "kv",
    "dampratio",
    "timeconst",
    "gainprm",
    "biasprm",
    "gaintype",
    "biastype",
    "dyntype",
    "active",
    "anchor",
    "relpose",
    "torquescale",
    "polycoef",
    "gravcomp",
    "actuatorfrcrange",
    "actuatorfrclimited",
];

/// Attributes that do nothing in a free joint.
const NOTHING_OF_FREE: [&str; 6] = ["axis", "pos", "range", "limited", "ref", "springref"];

/// Whether an attribute would do something in this element.
fn matters(key: &str, element: &Element<'_>) -> bool {
    let is_free = element.name() == "freejoint" || element.name() == "joint" && element.text("type") == Some("free");
    !(is_free && NOTHING_OF_FREE.contains(&key))
}

fn is_known(key: &str) -> bool {
    KNOWN.contains(&key) || TRANSMISSION.contains(&key)
}

/// Of attributes that are known, and that nothing asks for where they stand.
const WITHOUT_EFFECT: &str = "it has no effect there";

/// More lines than these are only counted.
const LISTED: usize = 6;

/// What is alike by element and by why it is not taken: which attributes, and where they stand.
type Groups = BTreeMap<(String, &'static str), (BTreeSet<String>, Vec<Place>)>;

/// Notes everything that was not read.
pub(super) fn sweep(tree: &Tree<'_>) {
    let mut groups = Groups::new();
    for root in tree.roots() {
        elements(&root, false, &mut groups);
    }
    let log = tree.root.log;
    for ((element, why), (attributes, places)) in groups {
        let mut distinct: Vec<usize> = places.iter().map(|place| log.line(place).1).collect();
        distinct.sort_unstable();
        distinct.dedup();
        let listed = distinct.iter().take(LISTED).map(usize::to_string).collect::<Vec<_>>().join(", ");
        let more = if distinct.len() > LISTED { ", …" } else { "" };
        let count = match (places.len(), distinct.len()) {
            (1, _) => String::new(),
            (count, 1) => format!("{count} times: "),
            (_, lines) if lines <= LISTED => format!("lines {listed}: "),
            (count, _) => format!("{count} times (lines {listed}{more}): "),
        };
        let attributes: Vec<String> = attributes.iter().map(|key| format!("`{key}`")).collect();
        let attributes = if attributes.is_empty() { String::new() } else { format!("{}: ", attributes.join(", ")) };
        log.note(places[0].clone(), element, Taken::Ignored, format!("{attributes}{count}{why}"));
    }
}

fn elements(root: &Element<'_>, in_default: bool, groups: &mut Groups) {
    let mut stack = vec![(*root, in_default)];
    while let Some((element, in_default)) = stack.pop() {
        if !element.was_seen() {
            unread(&element, in_default, groups);
            continue;
        }
        let in_default = in_default || element.name() == "default";
        for attribute in element.unread_attributes() {
            let known = in_default && is_known(attribute.key);
            let why = ATTRIBUTES.iter().find(|(names, _)| names.contains(&attribute.key)).map(|(_, why)| *why);
            match why {
                _ if known => {}
                Some(why) => {
                    let (keys, places) = groups.entry((element.name().to_owned(), why)).or_default();
                    keys.insert(attribute.key.to_owned());
                    places.push(attribute.place());
                }
                None if is_known(attribute.key) => {
                    let (keys, places) = groups.entry((element.name().to_owned(), WITHOUT_EFFECT)).or_default();
                    keys.insert(attribute.key.to_owned());
                    places.push(attribute.place());
                }
                None => {
                    let near = element.log.near(attribute.key, KNOWN.into_iter().chain(TRANSMISSION));
                    let near = near.filter(|near| matters(near, &element));
                    let near = near.map(|near| format!(": did you mean `{near}`?")).unwrap_or_default();
                    let value = xml::cut(attribute.value);
                    let what = format!("`{} = \"{value}\"` is not known here{near}", attribute.key);
                    element.log.note(attribute.place(), element.label(), Taken::Ignored, what);
                }
            }
        }
        let children: Vec<Element<'_>> = element.unread_children().collect();
        stack.extend(children.into_iter().rev().map(|child| (child, in_default)));
    }
}

fn unread(element: &Element<'_>, in_default: bool, groups: &mut Groups) {
    let why = ELEMENTS.iter().find(|(names, _)| names.contains(&element.name())).map(|(_, why)| *why);
    match why {
        Some(why) => groups.entry((format!("<{}>", element.name()), why)).or_default().1.push(element.place()),
        None if in_default => groups
            .entry((format!("<{}> in <default>", element.name()), "it has no equal here"))
            .or_default()
            .1
            .push(element.place()),
        None => element.note(Taken::Ignored, "not known here, nor is anything within it"),
    }
}
