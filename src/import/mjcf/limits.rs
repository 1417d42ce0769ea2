//! Limits of joints: rigid stops here, and no start beyond them.

use super::super::Options;
use super::super::log::Taken;
use super::scene::Scene;

/// Takes all limits, and puts every joint that starts beyond its limits to the nearer one. Couplings are read after it: they
/// hold from where the joints start.
pub(super) fn settle(scene: &mut Scene<'_>, options: &Options) {
    let limited: Vec<usize> =
        scene.in_order().into_iter().filter(|joint| scene.joints[*joint].range.is_some()).collect();
    let Some(&first) = limited.first() else { return };
    let others = match limited.len() {
        1 => "its limits are".to_owned(),
        2 => "its limits and those of another joint are".to_owned(),
        count => format!("its limits and those of {} other joints are", count - 1),
    };
    let element = scene.joints[first].element;
    if options.without_limits {
        element.note(Taken::Ignored, format!("{others} left out, as asked for"));
        limited.iter().for_each(|joint| scene.joints[*joint].range = None);
        return;
    }
    element.note(Taken::Approximated, format!("{others} soft there and rigid stops here"));
    for index in limited {
        let joint = &mut scene.joints[index];
        let [low, high] = joint.range.unwrap_or_default();
        let [given, reference] = [joint.start[0], joint.reference];
        let start = given.clamp(low, high);
        if start != given {
            joint.start[0] = start;
            let [given, low, high, start] = [given, low, high, start].map(|at| at + reference);
            let what = format!("qpos {given} is beyond its limits {low} … {high}: the joint starts at {start}");
            joint.element.note(Taken::Approximated, what);
        }
    }
}

/// Says which joints a coupling has put beyond their limits.
pub(super) fn note_coupled(scene: &Scene<'_>) {
    for joint in &scene.joints {
        if let Some([low, high]) = joint.range.filter(|[low, high]| !(*low..=*high).contains(&joint.start[0])) {
            let what = format!(
                "a constraint starts it at {}, outside its limits {low} … {high} (counted from its reference)",
                joint.start[0]
            );
            joint.element.note(Taken::Used, what);
        }
    }
}
