//! What drives, motors, gears and loops push with, as numbers of a recording.

use crate::dynamics::System;
use crate::model::Model;
use crate::record::scene::Channel;

/// Their names and units, in the order of [`fill`].
pub(super) fn channels(model: &Model) -> Vec<Channel> {
    let channel = |body: &str, name: &str, unit: &str| Channel {
        body: body.to_owned(),
        name: name.to_owned(),
        unit: unit.to_owned(),
    };
    let push = |body: &str, slides: bool| match slides {
        true => channel(body, "force", "N"),
        false => channel(body, "torque", "N m"),
    };
    let drives = model.drives.iter().map(|drive| push(&drive.name, drive.coordinate.slides));
    let motors = model.motors.iter().map(|motor| push(&motor.name, motor.coordinate.slides));
    let gears = model.gears.iter().map(|gear| push(&gear.name, gear.coordinates[0].slides));
    let loops = model.loops.iter().flat_map(|closed| {
        let forces = ["x", "y", "z"].map(|axis| channel(&closed.name, &format!("force {axis}"), "N"));
        let moments = ["x", "y", "z"].map(|axis| channel(&closed.name, &format!("moment {axis}"), "N m"));
        forces.into_iter().chain(moments).chain([channel(&closed.name, "gap", "m")])
    });
    drives.chain(motors).chain(gears).chain(loops).collect()
}

/// The numbers at the last evaluation, whose multipliers have been shared.
pub(super) fn fill(system: &System<'_>, out: &mut Vec<f64>) {
    out.clear();
    if let Some(rows) = system.constraints() {
        out.extend(rows.drive_forces().map(|(_, force)| force));
    }
    out.extend(system.motor_forces().map(|(_, force)| force));
    if let Some(rows) = system.constraints() {
        out.extend(rows.gear_forces().map(|(_, force)| force));
    }
    for reaction in system.loop_reactions() {
        out.extend(reaction.force.iter().chain(&reaction.moment));
        out.push(reaction.gap);
    }
}
