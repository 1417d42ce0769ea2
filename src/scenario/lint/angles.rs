//! Degrees in the place of radians.

use super::{Scene, Written, by_coordinate, exactly, hinge_of, limits, tables, units};
use crate::model::problem::number;
use std::f64::consts::TAU;

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
    for (list, key) in [("loop", "rpy"), ("loop", "rpy_second"), ("force", "rpy"), ("model", "rpy")] {
        for place in scene.tables(list).filter_map(|table| table.get(key)) {
            scene.numbers(place).iter().for_each(|written| check_angle(scene, key, written));
        }
    }
}

fn check_angle(scene: &Scene<'_>, path: &str, written: &Written) {
    let angle = written.value;
    if angle.abs() <= TAU * (1.0 + 1e-6) {
        return;
    }
    let message = format!("`{path}`: {angle} rad is more than a turn");
    let help = format!(
        "angles are radians: {angle}° are {}; write \"{angle} deg\" for degrees, or \"{angle} rad\" if it is meant",
        number(angle.to_radians())
    );
    scene.warn(written, message, help);
}
