//! Numbers that are allowed and hardly meant: slips of the unit. Each is a warning with its place, the reason and the likely conversion; nothing
//! is changed. A number whose unit is written beside it (`"720 deg"`) is taken at its word.

use super::findings::{Finding, Findings};
use super::quantities::Numbers;
use super::spans::walk;
use crate::model::Description;
use std::f64::consts::TAU;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Hinges all of whose coordinates are angles.
const TURNING: [&str; 3] = ["revolute", "universal", "screw"];
/// Keys of a hinge that hold such angles.
const ANGLES: [&str; 3] = ["position", "rest", "limits"];
/// Stronger than on any planet (m/s²): Jupiter's is 25.
const STRONGEST: f64 = 100.0;
/// A length is out of line if it is so many times the median of all...
const APART: f64 = 200.0;
/// ... and in line, within this factor, if it is taken as millimetres...
const ALIKE: f64 = 5.0;
/// ... unless lengths lead up to it, none so many times the one before: a long row of bodies is no slip.
const GAP: f64 = 10.0;

/// A spring that pulls at the start with so many times the weight of the whole scene is hardly meant.
const WEIGHTS: f64 = 1000.0;
/// A spring that lets its own body sink by so many times the longest length of the scene is hardly meant, either.
const SUNK: f64 = 10.0;

type Place<'a> = &'a Spanned<DeValue<'a>>;

/// A number, and where it is written.
type Written = (Range<usize>, f64);

/// Judges the numbers of a scene.
pub(super) fn check(document: &DeTable<'_>, numbers: &Numbers, findings: &Findings) {
    let plain = |place: Place<'_>| -> Vec<Written> {
        let mut all = Vec::new();
        collect(place, &mut all);
        all.retain(|(span, _)| !numbers.is_text(span));
        all
    };
    if let Some(gravity) = document.get("gravity") {
        let (span, parts) = (gravity.span(), plain(gravity));
        if let [(_, x), (_, y), (_, z)] = parts[..] {
            check_gravity(&span, [x, y, z], findings);
        }
    }
    let gravity = document.get("gravity").map_or_else(usual_gravity, |place| sizes(&plain(place)));
    let weight = weight(document, &gravity);
    let mut lengths = Vec::new();
    for body in tables(document, "body") {
        let kind = walk(body, "hinge.type").and_then(|kind| kind.get_ref().as_str());
        let angles = ANGLES.iter().filter(|_| kind.is_some_and(|kind| TURNING.contains(&kind)));
        let paths = angles.map(|key| format!("hinge.{key}")).chain(["hinge.rpy".to_owned(), "shape.rpy".to_owned()]);
        for path in paths {
            let Some(place) = exactly(body, &path) else { continue };
            plain(place).iter().for_each(|written| check_angle(&path, written, findings));
        }
        for path in ["hinge.at", "center"] {
            if let Some(place) = exactly(body, path) {
                lengths.extend(plain(place).into_iter().filter(|(_, x)| *x != 0.0));
            }
        }
    }
    let longest = lengths.iter().fold(0.0, |longest: f64, (_, x)| longest.max(x.abs()));
    for body in tables(document, "body") {
        let one = |path: &str| exactly(body, path).map(plain).filter(|all| all.len() == 1).map(|mut all| all.remove(0));
        if walk(body, "hinge.type").and_then(|kind| kind.get_ref().as_str()) != Some("prismatic") {
            continue;
        }
        let Some(stiffness) = one("hinge.stiffness").filter(|(_, stiffness)| *stiffness > 0.0) else { continue };
        check_preload(&stiffness, one("hinge.position"), one("hinge.rest"), weight, findings);
        let axis = exactly(body, "hinge.axis").map(|place| sizes(&plain(place)));
        let along = axis.map_or(0.0, |axis| along(&axis, &gravity));
        if let Some((_, mass)) = one("mass") {
            check_sag(&stiffness, mass * along, longest, findings);
        }
    }
    for (list, key) in [("loop", "rpy"), ("force", "rpy")] {
        for place in tables(document, list).filter_map(|table| table.get(key)) {
            plain(place).iter().for_each(|written| check_angle(key, written, findings));
        }
    }
    check_lengths(&lengths, findings);
    check_stages(document, numbers, findings);
}

/// The tables of a list such as `[[body]]`.
fn tables<'a>(document: &'a DeTable<'a>, list: &str) -> impl Iterator<Item = &'a DeTable<'a>> {
    let list = document.get(list).and_then(|list| list.get_ref().as_array());
    list.into_iter().flat_map(|list| list.iter().filter_map(|item| item.get_ref().as_table()))
}

/// The value on a path, if all of its keys are there.
fn exactly<'a>(table: &'a DeTable<'a>, path: &str) -> Option<Place<'a>> {
    match path.split_once('.') {
        Some((key, rest)) => exactly(table.get(key)?.get_ref().as_table()?, rest),
        None => table.get(path),
    }
}

/// All numbers of lists within lists.
fn collect(place: Place<'_>, found: &mut Vec<Written>) {
    let number = |text: &str| text.replace('_', "").parse::<f64>().ok().filter(|x| x.is_finite());
    let value = match place.get_ref() {
        DeValue::Integer(text) => number(text.as_str()),
        DeValue::Float(text) => number(text.as_str()),
        DeValue::Array(items) => {
            items.iter().for_each(|item| collect(item, found));
            None
        }
        _ => None,
    };
    found.extend(value.map(|value| (place.span(), value)));
}

fn check_angle(path: &str, (span, angle): &Written, findings: &Findings) {
    if angle.abs() <= TAU * (1.0 + 1e-6) {
        return;
    }
    let message = format!("`{path}`: {angle} rad is more than a turn");
    let help = format!(
        "angles are radians: {angle}° are {:.6}; write \"{angle} deg\" for degrees, or \"{angle} rad\" if it is meant",
        angle.to_radians()
    );
    findings.push(Finding::warning(span.clone(), message).help(help));
}

fn check_gravity(span: &Range<usize>, gravity: [f64; 3], findings: &Findings) {
    let size = gravity.iter().map(|x| x * x).sum::<f64>().sqrt();
    if size > STRONGEST {
        let message = format!("gravity is {size} m/s², {:.0} times that of the earth", size / 9.80665);
        let shown = gravity.map(|x| format!("{}", x / 1000.0)).join(", ");
        let help = format!("lengths are metres: if these are mm/s², write [{shown}], and all lengths in metres");
        findings.push(Finding::warning(span.clone(), message).help(help));
    } else if gravity[2] > 0.5 * size {
        let [x, y, z] = gravity;
        let message = format!("gravity points upward: z is {z} m/s²");
        let help =
            format!("if z is up, write [{x}, {y}, {}]; if z is down in this scene, pictures show it upside down", -z);
        findings.push(Finding::warning(span.clone(), message).help(help));
    }
}

/// That of a scene without the key (m/s²).
fn usual_gravity() -> Vec<f64> {
    Description::new("").gravity.as_slice().to_vec()
}

fn sizes(written: &[Written]) -> Vec<f64> {
    written.iter().map(|(_, x)| *x).collect()
}

/// What gravity has along an axis (m/s²), if that is at least half of it; 0 if not, or if either is not three numbers.
fn along(axis: &[f64], gravity: &[f64]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let part = dot(axis, gravity).abs() / dot(axis, axis).sqrt();
    if axis.len() == 3 && gravity.len() == 3 && part > 0.5 * dot(gravity, gravity).sqrt() { part } else { 0.0 }
}

/// The weight of all bodies (N), if every one has a mass that is written as a number.
fn weight(document: &DeTable<'_>, gravity: &[f64]) -> Option<f64> {
    let number = |table: &DeTable<'_>, key: &str| {
        let mut all = Vec::new();
        collect(table.get(key)?, &mut all);
        if let [(_, x)] = all[..] { Some(x) } else { None }
    };
    let masses =
        tables(document, "body").map(|body| Some(number(body, "mass")? * number(body, "repeat").unwrap_or(1.0)));
    let mass: f64 = masses.sum::<Option<f64>>()?;
    Some(mass * gravity.iter().map(|x| x * x).sum::<f64>().sqrt())
}

/// The spring of a slide, against the weight of the scene.
fn check_preload(
    (_, stiffness): &Written,
    position: Option<Written>,
    rest: Option<Written>,
    weight: Option<f64>,
    findings: &Findings,
) {
    let value = |written: &Option<Written>| written.as_ref().map_or(0.0, |(_, x)| *x);
    let force = stiffness * (value(&position) - value(&rest)).abs();
    let Some(weight) = weight.filter(|weight| *weight > 0.0 && force > WEIGHTS * weight) else { return };
    let Some(((span, length), key)) = rest.zip(Some("rest")).or(position.zip(Some("position"))) else { return };
    let message = format!(
        "`hinge.{key}`: the spring has {force:.3e} N at the start, {:.0} times the weight of the scene",
        force / weight
    );
    let help = format!(
        "lengths are metres: {length} mm are {}; write \"{length} mm\", or \"{length} m\" if it is meant",
        length / 1000.0
    );
    findings.push(Finding::warning(span, message).help(help));
}

/// The spring of a slide, against the weight (N) of its body and the longest length of the scene (m).
fn check_sag((span, stiffness): &Written, weight: f64, longest: f64, findings: &Findings) {
    let sag = weight / stiffness;
    if longest > 0.0 && sag > SUNK * longest && sag / 1000.0 <= longest {
        let message =
            format!("`hinge.stiffness`: {stiffness} N/m let the body sink by {sag:.3e} m under its own weight");
        let help = format!(
            "stiffness is in N/m: {stiffness} N/mm are {}; write \"{stiffness} N/mm\", or \"{stiffness} N/m\" if it is meant",
            1000.0 * stiffness
        );
        findings.push(Finding::warning(span.clone(), message).help(help));
    }
}

/// What waits for a time after the end of the run.
fn check_stages(document: &DeTable<'_>, numbers: &Numbers, findings: &Findings) {
    let one = |place: Place<'_>| -> Option<f64> {
        let mut all = Vec::new();
        collect(place, &mut all);
        all.first().map(|(_, x)| *x)
    };
    let Some(duration) = exactly(document, "simulate.duration").and_then(one) else { return };
    for stage in tables(document, "stage") {
        let Some((place, time)) = exactly(stage, "when.time").and_then(|place| Some((place, one(place)?))) else {
            continue;
        };
        if time > duration && !numbers.is_text(&place.span()) {
            let message = format!("the stage comes at {time} s, after the end of the run at {duration} s");
            findings
                .push(Finding::warning(place.span(), message).help("a longer `duration` in `[simulate]` reaches it"));
        }
    }
}

fn check_lengths(lengths: &[Written], findings: &Findings) {
    let mut sizes: Vec<f64> = lengths.iter().map(|(_, x)| x.abs()).collect();
    if sizes.len() < 3 {
        return;
    }
    sizes.sort_unstable_by(f64::total_cmp);
    let above = &sizes[sizes.len() / 2..];
    let median = above[0];
    let Some(gap) = above.windows(2).find(|pair| pair[1] > GAP * pair[0]) else { return };
    for (span, length) in lengths {
        let (times, in_line) = (length.abs() / median, length.abs() / 1000.0 / median);
        if length.abs() >= gap[1] && times >= APART && (1.0 / ALIKE..=ALIKE).contains(&in_line) {
            let message = format!("{length} m is {times:.0} times the median of the scene's lengths, {median} m");
            let help = format!(
                "lengths are metres: {length} mm are {}; write \"{length} mm\", or \"{length} m\" if it is meant",
                length / 1000.0
            );
            findings.push(Finding::warning(span.clone(), message).help(help));
        }
    }
}
