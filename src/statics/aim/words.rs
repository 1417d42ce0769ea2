//! What is said of an aim that is missed.

use crate::dynamics::System;
use crate::force::Act;
use crate::model::description::Description;
use crate::model::problem::{apart, number};
use crate::model::{Model, Parameter};
use crate::statics::certify::equilibrium::Equilibrium;
use crate::statics::settings::Aim;
use std::sync::Arc;

/// What is where, and where it should be.
pub(super) fn missed(aimed: &[(String, f64)], aim: &[Aim]) -> String {
    let one = |((name, value), aim): (&(String, f64), &Aim)| {
        let [value, aim] = apart(*value, aim.value);
        format!("`{name}` is {value} and not {aim}")
    };
    aimed.iter().zip(aim).map(one).collect::<Vec<_>>().join(", ")
}

/// What holds where no number has an influence: stops that bear, ropes that are slack; and what to do about it.
pub(super) fn held(model: &Arc<Model>, found: &Equilibrium, unknown: &[Parameter]) -> String {
    let mut holds: Vec<String> = Vec::new();
    for stop in &found.stops {
        holds.push(format!("{} rests on its {} stop at {}", stop.hinge, stop.side.name(), number(stop.limit)));
    }
    let mut system = System::new(model);
    let at = system.at(0.0, &found.position, &found.velocity);
    let links = &at.motion().links;
    for force in model.forces.iter() {
        let is_slack = || force.law.boundaries()[0].is_some_and(|taut| force.law.switch(taut, links).value < 0.0);
        if force.law.switches() == Some(["slack", "taut"]) && is_slack() {
            holds.push(format!("`{}` is slack", force.name));
        }
    }
    match (holds.is_empty(), unknown.first()) {
        (false, Some(one)) => format!(
            ", because here {}: begin with other numbers, from which it does not (`--set {}=…`)",
            holds.join(", "),
            one.address
        ),
        _ => String::new(),
    }
}

/// Numbers that cannot go further down.
pub(super) fn at_bound(held: &[usize], unknown: &[Parameter], description: &Description) -> String {
    let one = |j: &usize| format!("`{}` = {}", unknown[*j].address, number(unknown[*j].value(description)));
    match held.len() {
        0 => String::new(),
        _ => format!(" with {} as near to zero as it can be", held.iter().map(one).collect::<Vec<_>>().join(", ")),
    }
}
