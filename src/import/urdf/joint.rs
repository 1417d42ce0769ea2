//! Joints, as hinges and gears.

use super::pose::{place, turn};
use super::tree::{Joint, Link, Tree};
use crate::import::Options;
use crate::import::draft::{Draft, Entry};
use crate::import::log::{Problem, Taken};
use crate::import::xml::Element;
use crate::suggest::closest;
use nalgebra::{UnitQuaternion, Vector2, Vector3};

/// What to do about a mimic that cannot be meant.
const WITHOUT_MIMICS: &str = "`mimics = false` in `model`, or `convert --no-mimics`, leaves out all of them";

const TYPES: [&str; 6] = ["revolute", "continuous", "prismatic", "fixed", "floating", "planar"];

/// Name and hinge of the link that nothing carries.
pub(super) fn root(link: &Link<'_>, body: &mut Entry, options: &Options) {
    body.set("name", link.body.as_str(), Some(link.name_place.clone()));
    let mut hinge = Entry::new(None);
    hinge.set("type", if options.floating { "free" } else { "fixed" }, None);
    for (key, value) in [("at", options.at), ("rpy", options.rpy)] {
        if value != [0.0; 3] {
            hinge.numbers(key, &value, None);
        }
    }
    body.inline("hinge", hinge);
}

/// Name and hinge of the link that a joint carries. Tells the name of the body that carries the motion.
pub(super) fn write(
    joint: &Joint<'_>,
    tree: &Tree<'_>,
    body: &mut Entry,
    draft: &mut Draft,
    options: &Options,
) -> String {
    let (element, link) = (&joint.element, &tree.links[joint.child]);
    let kind = kind_of(joint);
    let name = link.body.clone();
    body.comment(&format!("joint `{}`, {kind}", joint.name));
    body.set("name", name.clone(), Some(link.name_place.clone()));
    let mut hinge = Entry::new(Some(element.place()));
    hinge.set("type", hinge_type(kind), element.attribute("type").map(|attribute| attribute.place()));
    let parent = tree.links[joint.parent].body.as_str();
    hinge.set("parent", parent, Some(joint.parent_place.clone()));
    place(element, &mut hinge);
    let axis = axis(element, kind);
    if kind == "planar" && (axis.xy() != Vector2::zeros() || axis.z < 0.0) {
        return tilted(joint, tree, body, draft, options, parent, axis);
    }
    if matches!(kind, "revolute" | "continuous" | "prismatic") {
        let from = element.child("axis").and_then(|axis| axis.attribute("xyz"));
        hinge.numbers("axis", axis.as_slice(), from.map(|xyz| xyz.place()));
    }
    effort(element, kind, body, draft, &name);
    limits(element, kind, options, &mut hinge);
    dynamics(element, kind, options, &mut hinge);
    body.inline("hinge", hinge);
    name
}

/// The type of a joint, or `fixed` where it is welded.
fn kind_of(joint: &Joint<'_>) -> &'static str {
    if joint.welded { "fixed" } else { kind(&joint.element) }
}

/// Welds the joints on which nothing with mass or inertia hangs, and says so.
pub(super) fn weld_massless(tree: &mut Tree<'_>) {
    let mut heavy: Vec<bool> = tree.links.iter().map(|link| super::link::weighs(&link.element)).collect();
    for &index in tree.order.iter().rev() {
        let Some(joint) = tree.links[index].joint else { continue };
        let parent = tree.joints[joint].parent;
        if heavy[index] {
            heavy[parent] = true;
            continue;
        }
        let element = tree.joints[joint].element;
        if kind(&element) != "fixed" {
            tree.joints[joint].welded = true;
            element.see_all();
            element.note(Taken::Approximated, "it carries nothing with mass: it is fixed, as asked for");
        }
    }
}

fn kind(joint: &Element<'_>) -> &'static str {
    let Some(given) = joint.required("type") else { return "fixed" };
    let known = TYPES.into_iter().find(|known| *known == given.value);
    known.unwrap_or_else(|| {
        let help = match closest(given.value, TYPES.into_iter()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("one of {}", TYPES.map(|known| format!("`{known}`")).join(", ")),
        };
        joint.refuse(given.wrong(&format!("does not know `{}`", given.value)).help(help));
        "fixed"
    })
}

fn hinge_type(kind: &str) -> &str {
    match kind {
        "continuous" => "revolute",
        "floating" => "free",
        same => same,
    }
}

fn axis(joint: &Element<'_>, kind: &str) -> Vector3<f64> {
    let Some(axis) = joint.child("axis") else { return Vector3::x() };
    if matches!(kind, "fixed" | "floating") {
        // Many write one, often of no direction; there is nothing in it.
        axis.see_all();
        return Vector3::x();
    }
    let Some(xyz) = axis.required("xyz") else { return Vector3::x() };
    match xyz.vector::<3>().map(Vector3::from) {
        Some(axis) if axis != Vector3::zeros() => axis,
        Some(_) => {
            axis.refuse(xyz.wrong("is zero").help("an axis has a direction"));
            Vector3::x()
        }
        None => Vector3::x(),
    }
}

/// A planar joint whose normal is not z: a body without mass whose z is the normal carries the motion, and the link is
/// welded to it in its own axes.
fn tilted(
    joint: &Joint<'_>,
    tree: &Tree<'_>,
    body: &mut Entry,
    draft: &mut Draft,
    options: &Options,
    parent: &str,
    normal: Vector3<f64>,
) -> String {
    let element = &joint.element;
    let z_to_normal = UnitQuaternion::rotation_between(&Vector3::z(), &normal)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    let name = tree.free(format!("{}{}", options.prefix, joint.name), "_plane");
    let mut plane = Entry::new(Some(element.place()));
    plane.comment(&format!("joint `{}`, planar: z of this body is the normal of the plane", joint.name));
    plane.set("name", name.as_str(), None);
    let mut hinge = Entry::new(Some(element.place()));
    hinge.set("type", "planar", None);
    hinge.set("parent", parent, Some(joint.parent_place.clone()));
    if let Some(at) = element.child("origin").and_then(|origin| origin.vector::<3>("xyz")) {
        hinge.numbers("at", &at, None);
    }
    let angles = |turn: UnitQuaternion<f64>| <[f64; 3]>::from(turn.euler_angles());
    hinge.numbers("rpy", &angles(turn(element) * z_to_normal), None);
    dynamics(element, "planar", options, &mut hinge);
    plane.inline("hinge", hinge);
    draft.add("body", plane);

    let mut weld = Entry::new(Some(element.place()));
    weld.set("type", "fixed", None);
    weld.set("parent", name.as_str(), None);
    weld.numbers("rpy", &angles(z_to_normal.inverse()), None);
    body.inline("hinge", weld);
    let what = format!("its plane is not xy: a body `{name}` of no mass was put in between, whose z is the normal");
    element.note(Taken::Used, what);
    name
}

/// `effort`, the limit of every motor that a scenario with this model puts into the hinge. A scenario that goes on from the text has it as a
/// comment: no key of a hinge stands for it.
fn effort(joint: &Element<'_>, kind: &str, body: &mut Entry, draft: &mut Draft, name: &str) {
    let Some((limit, effort)) = joint.child("limit").and_then(|it| Some((it, it.attribute("effort")?))) else { return };
    let Some(most) = effort.number() else { return };
    if most < 0.0 {
        limit.refuse(effort.wrong(&format!("is {most}, allowed: ≥ 0")));
    } else if !matches!(kind, "revolute" | "continuous" | "prismatic") {
        limit.note(Taken::Ignored, format!("`effort = {most}`: a {kind} joint has no motor"));
    } else if most == 0.0 {
        limit.note(Taken::Ignored, "`effort = 0`: a motor without a `limit` of its own has none");
    } else {
        draft.efforts.push((name.to_owned(), format!("{most:?}")));
        body.comment(&format!("its effort: write `limit = {most:?}` into every [[motor]] in it"));
        let what = "no motor acts in it; of a scenario with this file as its `model` it is the `limit` of every [[motor]] in it that has none of \
                    its own; converted it is a comment, and limits nothing";
        limit.note(Taken::Used, format!("`effort = {most}`: {what}"));
    }
}

/// Limits, and where the motion starts if zero is beyond them.
fn limits(joint: &Element<'_>, kind: &str, options: &Options, hinge: &mut Entry) {
    let Some(limit) = joint.child("limit") else {
        if matches!(kind, "revolute" | "prismatic") {
            joint.note(Taken::Approximated, format!("a {kind} joint without <limit>: it has no stops"));
        }
        return;
    };
    let ends = ["lower", "upper"].map(|key| limit.attribute(key));
    let numbers = ends.map(|end| end.map(|end| end.number()));
    if let Some(velocity) = limit.attribute("velocity") {
        limit.note(Taken::Ignored, format!("`velocity = {}`: hinges have no largest speed", velocity.value));
    }
    if !matches!(kind, "revolute" | "prismatic") {
        if ends.iter().any(Option::is_some) {
            limit.note(Taken::Ignored, format!("a {kind} joint has no `lower` and `upper`"));
        }
        return;
    }
    // What is absent is zero, says URDF.
    let [Some(low), Some(high)] = numbers.map(|end| end.unwrap_or(Some(0.0))) else { return };
    if low > high {
        let message = format!("{}: `lower` {low} is above `upper` {high}", limit.label());
        joint.refuse(Problem::at(limit.place(), message).help("swap the two"));
    } else if options.without_limits {
        limit.note(Taken::Ignored, "left out, as asked for");
    } else if low == high {
        let what = format!("from {low} to {high} they leave no room: the joint has no stops");
        limit.note(Taken::Ignored, what);
    } else {
        let start = 0.0_f64.clamp(low, high);
        if start != 0.0 {
            hinge.set("position", start, Some(limit.place()));
            let what = format!("0 is beyond them: the joint starts at {start}");
            limit.note(Taken::Used, what);
        }
        hinge.numbers("limits", &[low, high], Some(limit.place()));
    }
}

fn dynamics(joint: &Element<'_>, kind: &str, options: &Options, hinge: &mut Entry) {
    let Some(dynamics) = joint.child("dynamics") else { return };
    if let Some(damping) = dynamics.attribute("damping") {
        match damping.number() {
            Some(number) if number < 0.0 => dynamics.refuse(damping.wrong(&format!("is {number}, allowed: ≥ 0"))),
            Some(number) if number > 0.0 && kind == "fixed" => {
                dynamics.note(Taken::Ignored, "`damping` of a joint that does not move");
            }
            Some(number) if number > 0.0 => hinge.set("damping", number, Some(damping.place())),
            _ => {}
        }
    }
    if let Some(friction) = dynamics.attribute("friction") {
        match friction.number() {
            Some(number) if number < 0.0 => dynamics.refuse(friction.wrong(&format!("is {number}, allowed: ≥ 0"))),
            Some(number) if number > 0.0 && kind == "fixed" => {
                dynamics.note(Taken::Ignored, "`friction` of a joint that does not move");
            }
            Some(number) if number > 0.0 && options.without_friction => {
                dynamics.note(Taken::Ignored, format!("`friction = {number}`: left out, as asked for"));
            }
            Some(number) if number > 0.0 => hinge.set("friction", number, Some(friction.place())),
            _ => {}
        }
    }
}

/// Mimics, as gears. `bodies` are the names of the bodies that carry the joints' motions.
pub(super) fn gears(tree: &Tree<'_>, bodies: &[String], draft: &mut Draft, options: &Options) {
    for (index, joint) in tree.joints.iter().enumerate() {
        let Some(mimic) = joint.element.child("mimic") else { continue };
        if options.without_mimics {
            mimic.see_all();
            mimic.note(Taken::Ignored, "left out, as asked for: the joint moves by itself");
            continue;
        }
        let Some(leader) = mimic.required("joint") else { continue };
        let Some(other) = tree.joint(leader.value) else {
            let message = format!("{}: there is no joint `{}`", mimic.label(), leader.value);
            let help = match tree.near(leader.value, leader.element.log) {
                Some(near) => format!("did you mean `{near}`? {WITHOUT_MIMICS}"),
                None => WITHOUT_MIMICS.to_owned(),
            };
            mimic.refuse(Problem::at(leader.place(), message).help(help));
            continue;
        };
        let kinds = [index, other].map(|joint| kind_of(&tree.joints[joint]));
        if kinds[0] == "fixed" || tree.joints[other].welded {
            mimic.note(Taken::Ignored, "a fixed joint follows nothing, and nothing follows it");
            continue;
        }
        let many =
            [index, other].into_iter().zip(kinds).find(|(_, kind)| matches!(*kind, "fixed" | "planar" | "floating"));
        if let Some((which, kind)) = many {
            let message = format!("{}: joint `{}` is {kind}", mimic.label(), tree.joints[which].name);
            let help = "a joint of one coordinate follows another: revolute, continuous or prismatic";
            mimic.refuse(Problem::at(leader.place(), message).help(help));
            continue;
        }
        let number = |key: &str, default: f64| mimic.attribute(key).map_or(Some(default), |found| found.number());
        let (Some(multiplier), Some(offset)) = (number("multiplier", 1.0), number("offset", 0.0)) else { continue };
        if multiplier == 0.0 {
            let message = format!("{}: with `multiplier` 0 the joint does not move", mimic.label());
            mimic.refuse(Problem::at(mimic.place(), message).help("make it a fixed joint"));
            continue;
        }
        let slides = kinds.map(|kind| kind == "prismatic");
        draft.add("gear", gear(&mimic, joint.name, [&bodies[index], &bodies[other]], slides, multiplier, offset));
    }
}

/// q_follower = multiplier · q_leader + offset. If a turn follows a slide it is said the other way round: a rack is
/// named before its pinion.
fn gear(
    mimic: &Element<'_>,
    name: &str,
    [follower, leader]: [&str; 2],
    slides: [bool; 2],
    multiplier: f64,
    offset: f64,
) -> Entry {
    let from = |key: &str| mimic.attribute(key).map(|attribute| attribute.place());
    let mut gear = Entry::new(Some(mimic.place()));
    let (kind, key) = if slides[0] == slides[1] { ("ratio", "ratio") } else { ("rack", "radius") };
    let turned = slides == [false, true];
    let (ends, factor, offset) = match turned {
        false => ([follower, leader], multiplier, offset),
        true => ([leader, follower], 1.0 / multiplier, -offset / multiplier),
    };
    gear.comment(&format!("joint `{name}` follows"));
    gear.set("name", format!("{name} mimic"), None);
    gear.set("type", kind, None);
    gear.set("between", ends.into_iter().collect::<toml_edit::Array>(), from("joint"));
    gear.set(key, factor, from("multiplier"));
    gear.set("offset", offset, from("offset"));
    gear
}
