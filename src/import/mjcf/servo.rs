//! Servos whose force has bounds: motors.

use super::super::draft::Entry;
use super::super::log::Taken;
use super::super::xml::Element;
use super::actuator::Acts;
use super::lower::Output;
use super::scene::{Kind, Scene};

/// A motor in the hinge of a joint, which never pushes with less than `low` nor more than `high` times the gear. False
/// where the law is none of a motor: nothing was made then.
///
/// A motor's limit is the same on both sides: the middle of the range is a constant force beside it.
pub(super) fn bounded(
    element: &Element<'_>,
    joint: usize,
    gear: f64,
    acts: &Acts,
    [low, high]: [f64; 2],
    scene: &mut Scene<'_>,
    output: &mut Output,
) -> bool {
    let carried = &mut scene.joints[joint];
    let [stiffness, damping] = [acts.slope, acts.rate].map(|factor| 0.0 - factor * gear * gear);
    let (middle, limit) = (0.5 * (low + high) * gear, 0.5 * (high - low) * gear.abs());
    let is_motor = stiffness >= 0.0 && damping >= 0.0 && limit > 0.0;
    if !is_motor || !matches!(carried.kind, Kind::Hinge | Kind::Slide) {
        return false;
    }
    // Where the coordinate is zero.
    let force = gear * (acts.constant + acts.slope * gear * carried.reference);
    let (target, added) = match stiffness > 0.0 {
        true => (force / stiffness, -middle),
        false => (0.0, force - middle),
    };
    carried.acting.force[0] += middle;
    let name = carried.name.clone();
    let mut entry = Entry::new(Some(element.place()));
    entry.comment(&output.says(element, "a servo whose force has bounds"));
    entry.set("name", output.unique(element.text("name").unwrap_or("servo")), None);
    entry.set("hinge", output.hinge_name(joint), None);
    entry.set("type", "pd", None);
    entry.set("target", target, None);
    entry.set("stiffness", stiffness, None);
    entry.set("damping", damping, None);
    if added != 0.0 {
        entry.set("force", added, None);
    }
    entry.set("limit", limit, None);
    output.motors.push(entry);
    let beside = if middle == 0.0 { String::new() } else { format!(", beside a constant force of {middle}") };
    element.note(Taken::Used, format!("a motor in the hinge of `{name}` with a limit of {limit}{beside}"));
    true
}
