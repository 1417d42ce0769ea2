//! Degrees in the place of radians.

use super::{Scene, Written, by_coordinate, exactly, hinge_of, limits, tables, text, units};
use crate::model::problem::rounded;
use std::collections::{HashMap, HashSet};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Angles of more than a turn.
pub(super) fn check(scene: &Scene<'_>) {
    for body in ["body", "beam"].into_iter().flat_map(|list| scene.tables(list)) {
        let units = hinge_of(body).map(|kind| units(&kind)).unwrap_or_default();
        for key in ["position", "rest", "limits"] {
            let path = format!("hinge.{key}");
            let Some(place) = exactly(body, &path) else { continue };
            let found = if key == "limits" { limits(place) } else { by_coordinate(place, units.len()) };
            for (coordinate, place) in found {
                if units.get(coordinate) == Some(&"rad") {
                    scene.numbers(place).iter().for_each(|written| check_angle(scene, &path, written));
                }
            }
        }
        let turns = exactly(body, "hinge.rpy").map(|place| ("hinge.rpy", place));
        let of_shapes = tables(body.get("shape")).filter_map(|shape| Some(("shape.rpy", shape.get("rpy")?)));
        for (path, place) in turns.into_iter().chain(of_shapes) {
            scene.numbers(place).iter().for_each(|written| check_angle(scene, path, written));
        }
    }
    check_named(scene);
    for (list, key) in [("loop", "rpy"), ("loop", "rpy_second"), ("force", "rpy"), ("model", "rpy")] {
        for place in scene.tables(list).filter_map(|table| table.get(key)) {
            scene.numbers(place).iter().for_each(|written| check_angle(scene, key, written));
        }
    }
}

/// Angles that motors, drives and events have of hinges that they name, and events of outputs.
fn check_named(scene: &Scene<'_>) {
    let tables =
        || ["motor", "drive", "event"].into_iter().flat_map(|list| scene.tables(list).map(move |one| (list, one)));
    if tables().next().is_none() {
        return;
    }
    let hinges = ["body", "beam"].into_iter().flat_map(|list| scene.tables(list));
    let units: HashMap<&str, Vec<&str>> =
        hinges.filter_map(|body| Some((text(body, "name")?, units(&hinge_of(body)?)))).collect();
    let angles: HashSet<&str> = scene
        .tables("output")
        .filter(|one| text(one, "type") == Some("angle"))
        .filter_map(|one| text(one, "name"))
        .collect();
    for (list, table) in tables() {
        let coordinate = scene.number(table, "coordinate").map_or(0, |written| written.value as usize);
        let unit = |name: &str| {
            let of = units.get(name).or_else(|| units.get(name.split('[').next()?));
            of.and_then(|of| of.get(coordinate).copied())
        };
        let turns = text(table, "hinge").and_then(unit) == Some("rad");
        if !(turns || text(table, "output").is_some_and(|name| angles.contains(name))) {
            continue;
        }
        let keys: &[&'static str] = match list {
            "motor" => &["target", "target.amplitude", "target.offset"],
            "drive" => &["amplitude", "offset"],
            _ => &["value"],
        };
        let written = |key: &'static str| Some((key, scene.number(table, key)?));
        let angles = keys.iter().copied().filter_map(written).filter(|(_, angle)| !is_of_turns(angle.value));
        let ends = ["to", "target.to"].into_iter().filter_map(written).filter(|(_, end)| is_round(end.value));
        angles.chain(ends).for_each(|(key, angle)| check_angle(scene, key, &angle));
    }
}

/// Whether an angle (rad) is a number of quarters of a turn, which nobody writes in degrees.
fn is_of_turns(angle: f64) -> bool {
    const NEAR: f64 = 1e-3;
    let quarters = angle / FRAC_PI_2;
    (quarters - quarters.round()).abs() < NEAR
}

/// Whether a number is one of those that people write for the end of a motion in degrees: a multiple of five, of no more than two turns. What turns
/// for longer is given in radians as often.
fn is_round(angle: f64) -> bool {
    const STEP: f64 = 5.0;
    const MOST: f64 = 720.0;
    angle % STEP == 0.0 && angle.abs() <= MOST
}

fn check_angle(scene: &Scene<'_>, path: &str, written: &Written) {
    let angle = written.value;
    if angle.abs() <= TAU * (1.0 + 1e-6) {
        return;
    }
    let message = format!("`{path}`: {angle} rad is more than a turn");
    let help = format!(
        "angles are radians: {angle}° are {}; write \"{angle} deg\" for degrees, or \"{angle} rad\" if it is meant",
        rounded(angle.to_radians())
    );
    scene.warn(written, message, help);
}
