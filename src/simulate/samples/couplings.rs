//! What drives, motors, gears, loops, ropes and curves push with, as numbers with names: for recordings.

use crate::dynamics::{Evaluated, System};
use crate::model::Model;
use crate::model::couplings::Closure;
use crate::record::scene::{Channel, WRENCH};
use std::sync::Arc;

/// The names, in the order of [`fill`]: drives, motors, gears, loops, ropes and curves, each in the order of the model.
pub(in crate::simulate) fn channels(model: &Model) -> Vec<Channel> {
    let channel = |owner: &str, name: &str, unit: &str| Channel {
        body: owner.to_owned(),
        name: name.to_owned(),
        unit: unit.to_owned(),
    };
    let push = |owner: &str, slides: bool| match slides {
        true => channel(owner, "force", "N"),
        false => channel(owner, "torque", "N m"),
    };
    let mut all: Vec<Channel> = model.drives.iter().map(|drive| push(&drive.name, drive.coordinate.slides)).collect();
    all.extend(model.motors.iter().map(|motor| push(&motor.name, motor.coordinate.slides)));
    for gear in &model.gears {
        let slides = gear.coordinates[0].slides;
        all.extend([push(&gear.name, slides), channel(&gear.name, "gap", if slides { "m" } else { "rad" })]);
    }
    for closed in &model.loops {
        match closed.closure {
            Closure::Rod { .. } => all.push(channel(&closed.name, "pull", "N")),
            Closure::Hinge(_) => all.extend(WRENCH.map(|(name, unit)| channel(&closed.name, name, unit))),
        }
        all.push(channel(&closed.name, "gap", "m"));
    }
    all.extend(model.pulls().map(|(force, name)| channel(&force.name, name, "N")));
    all
}

/// The numbers at a place with its accelerations, after its multipliers have been shared.
pub(in crate::simulate) fn fill(at: &mut Evaluated<'_>, accelerations: &[f64], out: &mut Vec<f64>) {
    out.clear();
    let rows = at.system().constraints();
    out.extend(rows.into_iter().flat_map(|rows| rows.drive_pushes(at.system().model(), accelerations)));
    out.extend(at.motor_forces().map(|(_, force)| force));
    let rows = at.system().constraints();
    out.extend(rows.into_iter().flat_map(|rows| rows.gear_pushes().flatten()));
    for reaction in at.loop_reactions() {
        match reaction.pull {
            Some(pull) => out.push(pull),
            None => out.extend(reaction.force.iter().chain(reaction.moment.iter())),
        }
        out.push(reaction.gap);
    }
    out.extend(at.pulls().map(|(_, pull)| pull));
}

/// Loops whose reactions are not unique at the given start; none if that cannot be evaluated.
pub(in crate::simulate) fn not_unique(model: &Arc<Model>) -> Vec<String> {
    if model.loops.is_empty() {
        return Vec::new();
    }
    let mut system = System::new(model);
    let mut at = system.at(0.0, &model.start_position, &model.start_velocity);
    match at.share_multipliers() {
        Ok(()) => {
            let reactions = at.loop_reactions().into_iter();
            reactions.filter(|reaction| !reaction.unique).map(|reaction| reaction.name).collect()
        }
        Err(_) => Vec::new(),
    }
}
