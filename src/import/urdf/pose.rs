//! Where an `<origin>` puts what it belongs to.

use crate::import::draft::Entry;
use crate::import::xml::Element;
use nalgebra::UnitQuaternion;

/// `at` and `rpy` out of an `<origin>`.
pub(super) fn place(element: &Element<'_>, entry: &mut Entry) {
    let Some(origin) = element.child("origin") else { return };
    for (from, to) in [("xyz", "at"), ("rpy", "rpy")] {
        let Some(attribute) = origin.attribute(from) else { continue };
        if let Some(numbers) = attribute.vector::<3>().filter(|numbers| *numbers != [0.0; 3]) {
            entry.numbers(to, &numbers, Some(attribute.place()));
        }
    }
}

/// Roll, pitch, yaw of an `<origin>`.
pub(super) fn turn(element: &Element<'_>) -> UnitQuaternion<f64> {
    let rpy = element.child("origin").and_then(|origin| origin.vector::<3>("rpy"));
    rpy.map_or_else(UnitQuaternion::identity, |[r, p, y]| UnitQuaternion::from_euler_angles(r, p, y))
}
