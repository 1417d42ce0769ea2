//! Hinges that move next to nothing of what hangs on them.
//!
//! A hinge whose links beyond it are free to turn against it moves only a part of their inertia, the articulated one: in chains of like
//! links a fair part. If a link weighs next to nothing and carries much, its acceleration is the quotient of a
//! round-off by a small inertia: huge, and without meaning. What is huge without that is worth a look at its numbers.

use super::{output, text};
use crate::dynamics::{MassAction, System};
use crate::model::Model;
use serde_json::{Value, json};
use std::sync::Arc;

/// An acceleration (m/s² or rad/s²) beyond this many times gravity, or gravity over the scene's length, is none that a scene of
/// like masses makes: a chain of a thousand links that lets go makes some hundred.
const EXTREME: f64 = 1e6;
/// An inertia below this part of what hangs on it explains such an acceleration.
const LIGHT: f64 = 1e-6;

/// A coordinate of a hinge whose acceleration is extreme.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Light {
    hinge: String,
    unit: &'static str,
    /// What it moves while all beyond it is free, and what hangs on it (kg or kg m²).
    inertia: f64,
    carried: f64,
    /// At the given state (m/s² or rad/s²).
    acceleration: f64,
}

impl Light {
    pub(super) fn json(&self) -> Value {
        let ratio = self.inertia / self.carried;
        json!({
            "hinge": super::output::bare(&self.hinge),
            "inertia": self.inertia,
            "carried": self.carried,
            "ratio": ratio,
            "acceleration": self.acceleration,
        })
    }
}

/// The hinges of a scene with extreme accelerations at its start, and what they move.
pub(super) fn ill_conditioned(model: &Arc<Model>) -> Vec<Light> {
    let (q, v) = (&model.start_position, &model.start_velocity);
    let mut system = System::new(model);
    let mut accelerations = v.clone();
    // What cannot be computed is said where it is asked for.
    let mut at_start = system.at(0.0, q, v);
    let mut inertia = vec![0.0; v.len()];
    if at_start.articulated_inertia(&mut inertia).is_err() || at_start.accelerations_alone(&mut accelerations).is_err()
    {
        return Vec::new();
    }
    let gravity = model.gravity.norm().max(1.0);
    let per_length = gravity / model.length_scale();
    let mut action = MassAction::new(model);
    let mut found = Vec::new();
    for body in &model.bodies {
        for (index, (_, unit)) in body.hinge.kind.velocities().iter().enumerate() {
            let at = body.hinge.velocity + index;
            let slides = *unit == "m/s";
            let usual = if slides { gravity } else { per_length };
            // Each that is looked at costs a sweep.
            if !(accelerations[at].abs() > EXTREME * usual) || found.len() == MOST_LISTED {
                continue;
            }
            let (mut one, mut column) = (vec![0.0; v.len()], vec![0.0; v.len()]);
            one[at] = 1.0;
            at_start.mass_times(&mut action, &one, &mut column);
            let unit = if slides { "kg" } else { "kg m²" };
            let (hinge, acceleration) = (model.label(at), accelerations[at]);
            found.push(Light { hinge, unit, inertia: inertia[at], carried: column[at], acceleration });
        }
    }
    found
}

/// Coordinates that are looked for; more say nothing new.
const MOST_LISTED: usize = 100;
/// Hinges that are named one by one.
const MOST_NAMED: usize = 5;

/// Says which they are.
pub(super) fn warn(name: &str, found: &[Light]) {
    for Light { hinge, unit, inertia, carried, acceleration } in found.iter().take(MOST_NAMED) {
        let over = if *unit == "kg" { "m/s²" } else { "rad/s²" };
        let (times, acceleration) = (carried / inertia, text::number(*acceleration));
        let (inertia, carried) = (text::number(*inertia), text::number(*carried));
        output::warning(&match times > 1.0 / LIGHT {
            true => format!(
                "{name}: {hinge} moves an inertia of {inertia} {unit} and carries {carried} {unit}, {} times as much: its acceleration \
                 at the given state, {acceleration} {over}, means nothing (give the light bodies their inertia, or weld them)",
                text::number(times)
            ),
            false => format!(
                "{name}: {hinge} moves an inertia of {inertia} {unit}, and accelerates by {acceleration} {over} at the given state: is a \
                 mass, an inertia or a force in other units than the rest?"
            ),
        });
    }
    if found.len() > MOST_NAMED {
        output::warning(&format!("{name}: so do {} other hinges", found.len() - MOST_NAMED));
    }
}
