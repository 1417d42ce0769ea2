//! Points that slide along beams and begin where there is none.

use super::{Finding, Scene, exactly, text};
use crate::force::Law;
use crate::model::Model;
use crate::model::problem::number;
use crate::motion::Motion;

/// A point further beside the axis of a beam than this part of its length is hardly meant to be on it.
const FAR: f64 = 0.1;

pub(super) fn check(scene: &Scene<'_>) {
    let tables = || scene.tables("force").filter(|force| text(force, "type") == Some("slider"));
    if tables().next().is_none() {
        return;
    }
    // What is wrong with a scene that cannot be built is said elsewhere.
    let Ok(model) = Model::build(scene.description) else { return };
    let mut motion = Motion::new(&model);
    motion.update(&model, &model.start_position, &vec![0.0; model.velocity_count()]);
    for (table, force) in tables().filter_map(|table| Some((table, model.forces.iter().find(named(table))?))) {
        let (Law::Slider(law), Some(place), Some(along)) = (&force.law, exactly(table, "on"), text(table, "along"))
        else {
            continue;
        };
        let name = &force.name;
        let (message, help) = match law.beside(&motion.links) {
            None => (
                format!("`{name}` starts beyond the end of `{along}`, where nothing holds it: it never acts"),
                "start with the point beside the beam",
            ),
            Some(distance) if distance > FAR * law.beam_length() => (
                format!("`{name}` starts {} m beside the axis of `{along}`", number(distance)),
                "its spring pulls it there: start with the point near the axis",
            ),
            Some(_) => continue,
        };
        scene.findings.push(Finding::warning(place.span(), message).help(help));
    }
}

/// Whether a force is that of a table with a name.
fn named<'t>(table: &'t toml::de::DeTable<'t>) -> impl Fn(&&crate::force::Force) -> bool + 't {
    move |force| text(table, "name") == Some(force.name.as_str())
}
