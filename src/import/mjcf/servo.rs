//! What actuators do in the hinge of a joint: springs, dampers and constant forces, and motors where the force has bounds.

use super::super::draft::Entry;
use super::super::log::Taken;
use super::super::xml::Element;
use super::lower::Output;
use super::scene::{Acts, Part, Scene};

/// Adds an actuator to a joint; where the joint bounds what all actuators do, it waits for the others.
pub(super) fn add<'a>(joint: usize, part: Part<'a>, scene: &mut Scene<'a>, output: &mut Output) {
    if !scene.joints[joint].kind.is_scalar() {
        return;
    }
    if scene.joints[joint].motor_range.is_some() {
        scene.joints[joint].parts.push(part);
    } else {
        alone(joint, &part, scene, output);
    }
}

/// An actuator that no other one is bounded with.
fn alone(joint: usize, part: &Part<'_>, scene: &mut Scene<'_>, output: &mut Output) {
    if let Some(range) = part.bounds.filter(|_| part.acts.is_servo()) {
        if bounded(part, range, joint, scene, output) {
            return;
        }
        unbounded(&part.element, range);
    }
    unlimited(part, joint, scene);
}

/// Says that a servo's bounds are lost.
pub(super) fn unbounded(element: &Element<'_>, [low, high]: [f64; 2]) {
    element.note(Taken::Ignored, format!("`forcerange = {low} {high}`: its force has no bounds here"));
}

/// What waits in joints whose actuators are bounded together (`actuatorfrcrange`): the sum
///
/// ```text
/// clamp(Σ constant forces + Σ servos, low, high)                                    (1)
/// ```
///
/// is one motor, if the servos have no bounds of their own or there is but one of them.
pub(super) fn settle(scene: &mut Scene<'_>, output: &mut Output) {
    for joint in 0..scene.joints.len() {
        let parts = std::mem::take(&mut scene.joints[joint].parts);
        let Some(range) = scene.joints[joint].motor_range else { continue };
        let (servos, constants): (Vec<Part<'_>>, Vec<Part<'_>>) = parts.into_iter().partition(|it| it.acts.is_servo());
        let constant: f64 = constants.iter().map(|part| part.gear * part.acts.constant).sum();
        match &servos[..] {
            [] => scene.joints[joint].acting.force[0] += within(constant, range, &constants),
            [first, others @ ..] if others.is_empty() || servos.iter().all(|servo| servo.bounds.is_none()) => {
                let mut sum = Acts { constant, slope: 0.0, rate: 0.0 };
                for Part { gear, acts, .. } in &servos {
                    sum.constant += gear * acts.constant;
                    sum.slope += gear * gear * acts.slope;
                    sum.rate += gear * gear * acts.rate;
                }
                let whole = Part { element: first.element, gear: 1.0, acts: sum, bounds: None };
                together(&whole, overlap(first, constant, range), range, joint, scene, output);
            }
            _ => {
                let [low, high] = range;
                let what = format!(
                    "`actuatorfrcrange = {low} {high}`: servos with bounds of their own act in it together: their sum has no \
                     bounds here"
                );
                scene.joints[joint].element.note(Taken::Ignored, what);
                servos.iter().chain(&constants).for_each(|part| alone(joint, part, scene, output));
            }
        }
    }
}

/// The sum of constant forces within the range of its joint; that is said where it matters.
fn within(force: f64, [low, high]: [f64; 2], parts: &[Part<'_>]) -> f64 {
    let clamped = force.clamp(low, high);
    if let Some(part) = parts.first().filter(|_| clamped != force) {
        part.element.note(Taken::Used, format!("`actuatorfrcrange` of its joint lets {clamped} of {force} act"));
    }
    clamped
}

/// The range of a joint and that of its only servo, moved by the constant forces beside it.
fn overlap(servo: &Part<'_>, constant: f64, [low, high]: [f64; 2]) -> [f64; 2] {
    let Some(ends) = servo.bounds.map(|ends| ends.map(|end| servo.gear * end + constant)) else { return [low, high] };
    [low.max(ends[0].min(ends[1])), high.min(ends[0].max(ends[1]))]
}

/// All actuators of a joint as one, bounded.
fn together(
    whole: &Part<'_>,
    [low, high]: [f64; 2],
    range: [f64; 2],
    joint: usize,
    scene: &mut Scene<'_>,
    output: &mut Output,
) {
    if low >= high {
        // Its own bounds leave nothing but one end of the joint's range.
        let force = if high <= range[0] { range[0] } else { range[1] };
        whole.element.note(Taken::Used, format!("`actuatorfrcrange` of its joint leaves the constant force {force}"));
        scene.joints[joint].acting.force[0] += force;
    } else if !bounded(whole, [low, high], joint, scene, output) {
        let what = format!("`actuatorfrcrange = {low} {high}` of its joint: its force has no bounds here");
        whole.element.note(Taken::Ignored, what);
        unlimited(whole, joint, scene);
    }
}

/// A motor in the hinge of a joint, which never pushes with less than `low` nor more than `high` times the gear. False
/// where the law is none of a motor: nothing was made then.
///
/// A motor's limit is the same on both sides: the middle of the range is a constant force beside it.
fn bounded(part: &Part<'_>, [low, high]: [f64; 2], joint: usize, scene: &mut Scene<'_>, output: &mut Output) -> bool {
    let Part { element, gear, acts, .. } = part;
    let carried = &mut scene.joints[joint];
    let [stiffness, damping] = [acts.slope, acts.rate].map(|factor| 0.0 - factor * gear * gear);
    let (middle, limit) = (0.5 * (low + high) * gear, 0.5 * (high - low) * gear.abs());
    if !(stiffness >= 0.0 && damping >= 0.0 && limit > 0.0) {
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

/// `force = gear · (…)`, `length = gear · qpos`, as a spring, a damper and a constant force of the hinge.
fn unlimited(part: &Part<'_>, joint: usize, scene: &mut Scene<'_>) {
    let Part { element, gear, acts, .. } = part;
    let joint = &mut scene.joints[joint];
    let damping = -acts.rate * gear * gear;
    if damping < 0.0 {
        element
            .note(Taken::Ignored, format!("it drives with {} per unit of speed: no damper is negative here", -damping));
    } else {
        joint.acting.damping += damping;
    }
    let force = gear * (acts.constant + acts.slope * gear * joint.reference);
    if acts.slope == 0.0 {
        joint.acting.force[0] += force;
        return;
    }
    let stiffness = -acts.slope * gear * gear;
    joint.acting.spring(stiffness, force / stiffness);
    let what =
        format!("a spring in the hinge of `{}`, relaxed where it holds still ({})", joint.name, force / stiffness);
    element.note(Taken::Used, what);
}
