//! Strains of beams that are not free although they matter.

use super::{Finding, Place, Scene, exactly, text};
use crate::hinge::HingeKind;
use crate::model::beam::{BeamDescription, FreeStrains, Section};
use crate::model::couplings::Closure;
use crate::model::description::{ForceKind, Point};
use crate::model::problem::{number, significant};
use std::collections::{HashMap, HashSet};
use toml::de::DeTable;

/// A material that would be strained by more than this gives way, and so does the answer: advice on elements is for errors of this size, too.
const MUCH: f64 = 1e-3;

/// A stiffness that is given may stand in for one without limit: by more than this it does not.
const FAR: f64 = 1e-2;

/// Shear of a beam whose deflection is from shear to less than this part is no loss.
const SHARE: f64 = 1e-2;

pub(super) fn check(scene: &Scene<'_>) {
    let carried = carried(scene);
    let clamped = clamped(scene);
    let beams: HashMap<&str, &BeamDescription> =
        scene.description.beams.iter().map(|beam| (beam.name.as_str(), beam)).collect();
    for table in ["beam", "cable"].into_iter().flat_map(|list| scene.tables(list)) {
        let Some(beam) = text(table, "name").and_then(|name| beams.get(name)) else { continue };
        let force = carried.get(beam.name.as_str()).copied().unwrap_or(0.0) + own(scene, beam);
        check_locked(scene, table, beam, force);
        let far = beam.far.as_ref().map_or(clamped.contains(beam.name.as_str()), |far| far.clamped[1]);
        if far && is_clamped(beam) && !beam.free.twist {
            check_twist(scene, table, beam);
        }
    }
}

/// The forces and weights that act on beams directly (N).
fn carried<'s>(scene: &Scene<'s>) -> HashMap<&'s str, f64> {
    let mut found: HashMap<&str, f64> = HashMap::new();
    let gravity = scene.description.gravity.norm();
    for body in &scene.description.bodies {
        *found.entry(body.hinge.parent.as_str()).or_insert(0.0) += body.mass.mass * gravity;
    }
    for force in &scene.description.forces {
        if let ForceKind::Load(load) = &force.kind {
            *found.entry(load.on.body.as_str()).or_insert(0.0) += load.force.norm();
        }
    }
    found
}

/// The weight of a beam, what acts along it, and its pretension (N).
fn own(scene: &Scene<'_>, beam: &BeamDescription) -> f64 {
    let along = beam.load.map_or(0.0, |load| load.force.norm());
    let pretension = beam.far.as_ref().and_then(|far| far.pretension).unwrap_or(0.0);
    beam.mass() * scene.description.gravity.norm() + along * beam.shape.length() + pretension
}

/// A beam that bends hangs in the end: then it bears along itself whatever acts on it.
fn check_locked(scene: &Scene<'_>, table: &DeTable<'_>, beam: &BeamDescription, force: f64) {
    let is_given = beam.sections.iter().any(|(_, section)| matches!(section, Section::Stiffness(_)));
    let most = if is_given { FAR } else { MUCH };
    let locked = beam.locked(force);
    if locked.stretch > most {
        let help = FreeStrains { stretch: true, ..beam.free };
        tell(
            scene,
            table,
            beam,
            ("stretch", "along it, its weight and what it bears, would stretch it by"),
            force,
            locked.stretch,
            help,
        );
    } else if locked.shear > most && locked.share > SHARE {
        let help = FreeStrains { shear: true, ..beam.free };
        tell(
            scene,
            table,
            beam,
            ("shear", "across it, its weight and what it bears, would shear it by"),
            force,
            locked.shear,
            help,
        );
    }
}

fn tell(
    scene: &Scene<'_>,
    table: &DeTable<'_>,
    beam: &BeamDescription,
    (what, does): (&str, &str),
    force: f64,
    strain: f64,
    free: FreeStrains,
) {
    let Some(place) = place(table, "free") else { return };
    let (force, strain) = (number(force), significant(strain, 3));
    let message = format!("`{}` leaves out {what}: {force} N {does} {strain}", beam.name);
    let help = format!("write {}, or check the material and the loads", free.written());
    scene.findings.push(Finding::warning(place.span(), message).help(help));
}

/// Where something of a beam is told: at a key if it is there, else at its name.
fn place<'a>(table: &'a DeTable<'a>, key: &str) -> Option<Place<'a>> {
    exactly(table, key).or_else(|| table.get("name"))
}

/// The beams whose tips are held by fixed loops.
fn clamped<'s>(scene: &Scene<'s>) -> HashSet<&'s str> {
    let loops = scene.description.loops.iter().filter(|closed| match &closed.closure {
        Closure::Hinge(kind) => *kind == HingeKind::Fixed,
        Closure::Rod { .. } => false,
    });
    let is_tip = |point: &Point| match point {
        Point::At(_) => true,
        Point::Marker(name) => name == "tip",
    };
    let ends = loops.flat_map(|closed| &closed.between);
    ends.filter(|end| is_tip(&end.point)).map(|end| end.body.as_str()).collect()
}

fn is_clamped(beam: &BeamDescription) -> bool {
    beam.far.as_ref().map_or_else(|| beam.hinge.kind == HingeKind::Fixed, |far| far.clamped[0])
}

fn check_twist(scene: &Scene<'_>, table: &DeTable<'_>, beam: &BeamDescription) {
    let Some(place) = place(table, if table.contains_key("free") { "free" } else { "ends" }) else { return };
    let message = format!(
        "`{}` is clamped at both ends and does not twist: its ends can only turn as bending lets them",
        beam.name
    );
    let free = FreeStrains { twist: true, ..beam.free };
    let help = format!("write {}; what bends within one plane alone gives the same answer", free.written());
    scene.findings.push(Finding::warning(place.span(), message).help(help));
}
