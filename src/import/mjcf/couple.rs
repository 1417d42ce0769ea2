//! `<equality>`: loops, gears, and coordinates that are held.

use super::super::draft::Entry;
use super::super::log::Taken;
use super::super::xml::Element;
use super::defaults::{Defaults, Settled};
use super::lower::Output;
use super::pose::roll_pitch_yaw;
use super::scene::{Kind, Scene, WORLD, find};
use super::tendon::Tendons;
use super::tree::Tree;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

/// Reads all couplings. Those that hold coordinates against each other also set where these start.
pub(super) fn read<'a>(
    tree: &Tree<'a>,
    defaults: &Defaults<'a>,
    scene: &mut Scene<'a>,
    tendons: &Tendons,
    output: &mut Output,
) {
    let reference = scene.poses(|_| 0.0);
    for element in tree.section("equality") {
        if !["connect", "weld", "joint", "tendon"].contains(&element.name()) {
            continue;
        }
        // Defaults of all constraints stand under one name.
        let settled = defaults.under(&element, "equality", None);
        element.text("name");
        if settled.flag("active") == Some(false) || !scene.settings.equality {
            element.note(Taken::Ignored, "it is not active at the start");
            read_all(&settled);
            continue;
        }
        match element.name() {
            "connect" | "weld" => {
                if let Some(entry) = closure(&settled, scene, &reference, output) {
                    output.loops.push(entry);
                }
            }
            kind => coordinates(&settled, kind, scene, tendons, output),
        }
    }
}

/// Marks what is of no further interest.
fn read_all(settled: &Settled<'_>) {
    const KEYS: [&str; 13] = [
        "body1",
        "body2",
        "site1",
        "site2",
        "anchor",
        "relpose",
        "torquescale",
        "joint1",
        "joint2",
        "tendon1",
        "tendon2",
        "polycoef",
        "active",
    ];
    settled.skip(&KEYS);
}

/// A body by name; the world where there is none.
pub(super) fn body(element: &Element<'_>, key: &str, scene: &Scene<'_>) -> Option<usize> {
    let Some(attribute) = element.attribute(key) else { return Some(WORLD) };
    find(&attribute, "body", &scene.names.bodies, scene)
}

/// The two ends of a loop: body and frame in it.
type Ends = [(usize, Isometry3<f64>); 2];

fn closure(
    settled: &Settled<'_>,
    scene: &Scene<'_>,
    reference: &[Isometry3<f64>],
    output: &mut Output,
) -> Option<Entry> {
    let element = settled.element;
    let welded = element.name() == "weld" && settled.number("torquescale") != Some(0.0);
    let ends = if element.attribute("site1").is_some() || element.attribute("site2").is_some() {
        let site = |key| {
            let index = find(&element.required(key)?, "site", &scene.names.sites, scene)?;
            Some((scene.sites[index].body, scene.sites[index].pose))
        };
        [site("site1")?, site("site2")?]
    } else {
        element.required("body1")?;
        let bodies = [body(&element, "body1", scene)?, body(&element, "body2", scene)?];
        if element.name() == "connect" {
            connected(settled, bodies, reference)?
        } else {
            welds(settled, bodies, reference)?
        }
    };
    if ends[0].0 == ends[1].0 {
        settled.refuse("both ends are on the same body", "");
        return None;
    }
    let mut entry = Entry::new(Some(element.place()));
    let kind = if welded { "fixed" } else { "spherical" };
    entry.comment(&output.says(&element, "a soft constraint there, exact here"));
    entry.set("name", output.unique(element.text("name").unwrap_or(element.name())), None);
    entry.set("type", kind, None);
    let between = ends.map(|(body, frame)| output.attachment(scene, body, frame.translation.vector));
    let [first, second] = between;
    entry.set("between", [first, second].into_iter().collect::<toml_edit::Array>(), None);
    if welded {
        output.vector(&mut entry, "rpy", roll_pitch_yaw(&ends[0].1.rotation), None);
        // Also where it is zero: left out, it would follow from the positions.
        entry.numbers("rpy_second", &super::pose::clean(roll_pitch_yaw(&ends[1].1.rotation)), None);
    }
    Some(entry)
}

fn connected(settled: &Settled<'_>, bodies: [usize; 2], reference: &[Isometry3<f64>]) -> Option<Ends> {
    settled.element.required("anchor")?;
    let anchor = Translation3::from(Vector3::from(settled.vector::<3>("anchor")?));
    let [first, second] = bodies;
    let other = reference[second].inverse() * reference[first] * anchor;
    Some([(first, anchor.into()), (second, other)])
}

fn welds(settled: &Settled<'_>, bodies: [usize; 2], reference: &[Isometry3<f64>]) -> Option<Ends> {
    let anchor = settled.vector("anchor").map_or_else(Vector3::zeros, Vector3::from);
    let second: Isometry3<f64> = Translation3::from(anchor).into();
    let given = settled.vector::<7>("relpose").filter(|pose| pose[3..].iter().any(|number| *number != 0.0));
    let first = match given {
        Some([x, y, z, w, a, b, c]) => Isometry3::from_parts(
            Translation3::new(x, y, z),
            UnitQuaternion::from_quaternion(Quaternion::new(w, a, b, c)),
        ),
        None => reference[bodies[0]].inverse() * reference[bodies[1]] * second,
    };
    Some([(bodies[0], first), (bodies[1], second)])
}

/// `joint` and `tendon`: one sum of coordinates as a polynomial of another.
fn coordinates<'a>(settled: &Settled<'a>, kind: &str, scene: &mut Scene<'a>, tendons: &Tendons, output: &mut Output) {
    let element = settled.element;
    let sum = |key: &str| -> Option<Vec<(usize, f64)>> {
        let attribute = element.required(key)?;
        if kind == "tendon" {
            let found = tendons.fixed(&attribute, scene);
            if found.is_none() {
                element.note(Taken::Ignored, format!("`{}` is not a tendon of joints", attribute.value));
            }
            return found;
        }
        let joint = find(&attribute, "joint", &scene.names.joints, scene)?;
        if !scene.joints[joint].kind.is_scalar() {
            element.refuse(attribute.wrong("must be a hinge or a slide"));
            return None;
        }
        Some(vec![(joint, 1.0)])
    };
    let keys = [format!("{kind}1"), format!("{kind}2")];
    let Some(first) = sum(&keys[0]) else { return };
    let second = if element.attribute(&keys[1]).is_some() { sum(&keys[1]) } else { Some(Vec::new()) };
    let Some(second) = second else { return };
    let mut polynomial = settled.numbers("polycoef", 5).unwrap_or_else(|| vec![0.0, 1.0]);
    polynomial.resize(5, 0.0);
    // The line that touches the polynomial where it starts.
    let x: f64 = second.iter().map(|(joint, factor)| factor * scene.joints[*joint].start[0]).sum();
    let [mut value, mut slope] = [0.0, 0.0];
    if !second.is_empty() {
        for coefficient in polynomial.iter().rev() {
            slope = slope * x + value;
            value = value * x + coefficient;
        }
        if polynomial[2..].iter().any(|coefficient| *coefficient != 0.0) {
            let what = format!("the polynomial is taken as its tangent at the start: slope {slope}");
            element.note(Taken::Approximated, what);
        }
    } else {
        value = polynomial[0];
    }
    let mut terms = first;
    for (joint, factor) in second {
        match terms.iter_mut().find(|(other, _)| *other == joint) {
            Some((_, sum)) => *sum -= slope * factor,
            None => terms.push((joint, -slope * factor)),
        }
    }
    terms.retain(|(_, factor)| *factor != 0.0);
    tie(&element, &terms, value - slope * x, scene, output);
}

/// The sum of the terms is `constant`: a gear of two coordinates, or one that is held.
fn tie(element: &Element<'_>, terms: &[(usize, f64)], constant: f64, scene: &mut Scene<'_>, output: &mut Output) {
    let (first, goal, second) = match *terms {
        [(first, factor)] => (first, constant / factor, None),
        [(first, factor), (second, other)] => {
            let ratio = -other / factor;
            let goal = constant / factor + ratio * scene.joints[second].start[0];
            (first, goal, Some((second, ratio)))
        }
        _ => {
            element.note(Taken::Ignored, format!("it ties {} joints; only two can be in a gear", terms.len()));
            return;
        }
    };
    let start = scene.joints[first].start[0];
    if (start - goal).abs() > 1e-12 * (1.0 + goal.abs()) {
        let what =
            format!("`{}` starts at {goal} instead of {start}, where the constraint holds", scene.joints[first].name);
        element.note(Taken::Used, what);
    }
    scene.joints[first].start[0] = goal;
    let mut entry = Entry::new(Some(element.place()));
    entry.comment(&output.says(element, "a soft constraint there, exact here"));
    entry.set("name", output.unique(element.text("name").unwrap_or(element.name())), None);
    let hinge = |joint: usize| output.hinge_name(joint);
    let Some((second, ratio)) = second else {
        entry.set("type", "hold", None);
        entry.set("hinge", hinge(first), None);
        output.drives.push(entry);
        return;
    };
    let between = match (scene.joints[first].kind, scene.joints[second].kind) {
        (Kind::Slide, Kind::Hinge) => {
            entry.set("type", "rack", None);
            entry.set("radius", ratio, None);
            [first, second]
        }
        (Kind::Hinge, Kind::Slide) => {
            entry.set("type", "rack", None);
            entry.set("radius", 1.0 / ratio, None);
            [second, first]
        }
        _ => {
            entry.set("type", "ratio", None);
            entry.set("ratio", ratio, None);
            [first, second]
        }
    };
    entry.set("between", between.into_iter().map(hinge).collect::<toml_edit::Array>(), None);
    output.gears.push(entry);
}
