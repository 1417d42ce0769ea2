//! Gravity that is too strong, or points upward.

use super::{Finding, Scene};
use crate::model::description::{BodyDescription, GROUND, HingeKind};
use crate::model::problem::{number, significant};
use crate::model::shape::Geometry;
use nalgebra::Vector3;

/// Stronger than on any planet (m/s²): Jupiter's is 25.
const STRONGEST: f64 = 100.0;
/// A direction that has so much of gravity is the vertical one.
const MOST: f64 = 0.5;

pub(super) fn check(scene: &Scene<'_>) {
    let Some(place) = scene.document.get("gravity") else { return };
    let written: Vec<f64> =
        scene.numbers(place).iter().filter(|written| !written.is_text).map(|written| written.value).collect();
    let [x, y, z] = written[..] else { return };
    let gravity = Vector3::new(x, y, z);
    let size = gravity.norm();
    let warn = |message: String, help: String| {
        scene.findings.push(Finding::warning(place.span(), message).help(help));
    };
    if size > STRONGEST {
        let times = significant(size / 9.80665, 4);
        let message = format!("gravity is {} m/s², {times} times that of the earth", number(size));
        let shown = written.iter().map(|x| format!("{}", x / 1000.0)).collect::<Vec<_>>().join(", ");
        let help = format!("lengths are metres: if these are mm/s², write [{shown}], and all lengths in metres");
        warn(message, help);
    } else if z > MOST * size {
        let message = format!("gravity points upward: z is {z} m/s²");
        let help =
            format!("if z is up, write [{x}, {y}, {}]; if z is down in this scene, pictures show it upside down", -z);
        warn(message, help);
    } else if let Some((body, floor)) = above_a_floor(scene, &gravity) {
        let [up, down] = [floor, -floor].map(|v| v.map(|x| (1e6 * x).round() / 1e6 + 0.0));
        let message = format!(
            "gravity points upward: away from the plane of `{body}`, whose outside is [{}, {}, {}]",
            up.x, up.y, up.z
        );
        let turned = size * down;
        let help = format!(
            "what is in front of the plane falls off it: for a floor write [{}, {}, {}]",
            number(turned.x),
            number(turned.y),
            number(turned.z)
        );
        warn(message, help);
    }
}

/// The plane on the ground from which gravity leads away, with its body and its normal; `None` if another one holds what falls.
fn above_a_floor<'a>(scene: &'a Scene<'_>, gravity: &Vector3<f64>) -> Option<(&'a str, Vector3<f64>)> {
    // Without contact there are no floors; where gravity is along z, up is.
    if scene.description.contacts.is_empty() || gravity.z.abs() >= MOST * gravity.norm() {
        return None;
    }
    let planes: Vec<(&str, Vector3<f64>)> = scene.description.bodies.iter().flat_map(planes).collect();
    let along = |(_, normal): &(&str, Vector3<f64>)| normal.dot(gravity) / gravity.norm();
    if planes.iter().any(|plane| along(plane) < 0.0) {
        return None;
    }
    // A floor is level.
    planes.into_iter().find(|plane| along(plane) > LEVEL)
}

/// The cosine of the steepest floor that is one.
const LEVEL: f64 = 0.9;

/// The outsides of the planes of a body that is fixed to the ground, inertial axes.
fn planes(body: &BodyDescription) -> impl Iterator<Item = (&str, Vector3<f64>)> {
    let is_fixed = body.hinge.kind == HingeKind::Fixed && body.hinge.parent == GROUND;
    body.shapes.iter().filter(move |shape| is_fixed && shape.collides).filter_map(|shape| match &shape.geometry {
        Geometry::Plane(normal) => {
            Some((body.name.as_str(), (body.hinge.frame * (shape.pose.rotation * normal)).normalize()))
        }
        _ => None,
    })
}
