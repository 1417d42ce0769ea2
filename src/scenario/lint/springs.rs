//! Springs that pull at the start as nothing else does, or let what they carry fall.

use super::lengths::{Length, longest, reach};
use super::{Scene, Written, by_coordinate, exactly, hinge_of, in_millimetres, text, units};
use crate::hinge::HingeKind;
use crate::model::description::{BodyDescription, GROUND};
use crate::model::problem::number;
use nalgebra::{UnitQuaternion, Vector3};
use std::collections::{BTreeMap, BTreeSet};
use toml::de::{DeTable, DeValue};

/// A spring that pulls at the start with so many times the weight of the whole scene is hardly meant...
const WEIGHTS: f64 = 1000.0;
/// ... if its length is so many times the longest of the others, too: small mechanisms have springs as strong as that.
const LONG: f64 = 10.0;
/// Nobody writes less than a millimetre in millimetres (mm).
const LEAST: f64 = 1.0;
/// A spring that lets its own body sink by so many times the longest length of the scene is hardly meant, either.
const SUNK: f64 = 10.0;
/// The length of a scene that has none (m).
const USUAL: f64 = 1.0;
/// What has less of gravity than this part is no slide that bears a weight.
const STEEP: f64 = 0.5;

pub(super) fn check(scene: &Scene<'_>, lengths: &[Length<'_>]) {
    let springs = Springs::new(scene, lengths);
    for body in scene.tables("body") {
        springs.in_hinge(body);
    }
    for force in scene.tables("force").filter(|force| text(force, "type") == Some("spring")) {
        springs.between(force);
    }
}

struct Springs<'s, 'a> {
    scene: &'s Scene<'a>,
    lengths: &'s [Length<'a>],
    bodies: BTreeMap<&'s str, &'s BodyDescription>,
    /// How often couplings, forces, loads and contacts name a body.
    named: BTreeMap<&'s str, usize>,
    /// Bodies that carry others.
    parents: BTreeSet<&'s str>,
    /// Bodies that are named so, or carry one that is.
    held: BTreeSet<&'s str>,
}

impl<'s, 'a> Springs<'s, 'a> {
    fn new(scene: &'s Scene<'a>, lengths: &'s [Length<'a>]) -> Self {
        let all = &scene.description.bodies;
        let bodies: BTreeMap<&str, &BodyDescription> = all.iter().map(|body| (body.name.as_str(), body)).collect();
        let mut named: BTreeMap<&str, usize> = BTreeMap::new();
        for list in ["force", "loop", "drive", "gear", "motor"] {
            for table in scene.tables(list) {
                names(table, &mut |name| *named.entry(name).or_insert(0) += 1);
            }
        }
        let parents = all.iter().map(|body| bare(&body.hinge.parent)).collect();
        let mut held = BTreeSet::new();
        for body in all.iter().filter(|body| named.contains_key(bare(&body.name))) {
            let mut up = Some(body);
            while let Some(one) = up.filter(|one| held.insert(one.name.as_str())) {
                up = bodies.get(one.hinge.parent.as_str()).copied();
            }
        }
        Self { scene, lengths, bodies, named, parents, held }
    }

    /// The body of a table, the first of its copies.
    fn body(&self, name: &str) -> Option<&'s BodyDescription> {
        self.bodies.get(name).or_else(|| self.bodies.get(format!("{name}[0]").as_str())).copied()
    }

    /// The weight of all bodies (N); `None` if it is none, or is not all in bodies.
    fn weight(&self) -> Option<f64> {
        let scene = self.scene.description;
        let others = !scene.beams.is_empty() || !scene.modals.is_empty();
        let mass: f64 = scene.bodies.iter().map(|body| body.mass.mass).sum();
        Some(mass * scene.gravity.norm()).filter(|weight| *weight > 0.0 && !others)
    }

    /// The springs of the coordinates of a hinge that are distances.
    fn in_hinge(&self, table: &DeTable<'_>) {
        let Some(kind) = hinge_of(table) else { return };
        let (units, (_, velocities)) = (units(&kind), kind.counts());
        let of = |key: &str, count: usize, coordinate: usize| -> Option<Written> {
            let place = exactly(table, &format!("hinge.{key}"))?;
            if place.get_ref().as_array().is_none() {
                return self.scene.numbers(place).pop();
            }
            let mut found = by_coordinate(place, count).into_iter().filter(|(of, _)| *of == coordinate);
            let only = found.next().filter(|_| found.next().is_none())?;
            self.scene.numbers(only.1).pop()
        };
        for coordinate in (0..units.len()).filter(|coordinate| units[*coordinate] == "m") {
            let Some(stiffness) = of("stiffness", velocities, coordinate).filter(|k| k.value > 0.0) else { continue };
            let ends = ["rest", "position"].map(|key| (key, of(key, units.len(), coordinate)));
            self.check_preload(&stiffness, &ends);
            self.check_hinge_sag(table, &kind, coordinate, &stiffness);
        }
    }

    /// The spring of a slide, against the weight of the scene.
    fn check_preload(&self, stiffness: &Written, ends: &[(&str, Option<Written>); 2]) {
        let value = |(_, end): &(&str, Option<Written>)| end.as_ref().map_or(0.0, |end| end.value);
        let force = stiffness.value * (value(&ends[0]) - value(&ends[1])).abs();
        let longer = if value(&ends[1]).abs() > value(&ends[0]).abs() { &ends[1] } else { &ends[0] };
        if let (key, Some(end)) = longer {
            self.tell_preload(&format!("hinge.{key}"), end, force, "");
        }
    }

    fn tell_preload(&self, key: &str, length: &Written, force: f64, least: &str) {
        let Some(weight) = self.weight().filter(|weight| force > WEIGHTS * weight) else { return };
        let (size, others) = (length.value.abs(), longest(self.lengths, Some(length)));
        if size < LEAST || size <= LONG * others {
            return;
        }
        let message = format!(
            "`{key}`: the spring has {least}{} N at the start, {:.0} times the weight of the scene",
            number(force),
            force / weight
        );
        self.scene.warn(length, message, in_millimetres(length.value));
    }

    /// A spring between points, which are no further apart than all lengths of the scene add up to.
    fn between(&self, table: &DeTable<'_>) {
        let Some(stiffness) = self.scene.number(table, "stiffness").filter(|k| k.value > 0.0) else { return };
        let scene = self.scene.description;
        // Curves and beams have lengths that are not written.
        let is_known = scene.beams.is_empty()
            && scene.modals.is_empty()
            && scene.bodies.iter().all(|body| !matches!(body.hinge.kind, HingeKind::Along { .. }))
            && !self.scene.document.contains_key("model");
        if let Some(length) = self.scene.number(table, "length").filter(|_| is_known) {
            let force = stiffness.value * (length.value - reach(self.lengths, &length));
            self.tell_preload("length", &length, force, "at least ");
        }
        let mut ends = Vec::new();
        names(table, &mut |name| ends.push(name));
        let on_ground = table.get("between").and_then(|ends| ends.get_ref().as_array()).is_some_and(|ends| {
            ends.iter().any(|end| match end.get_ref() {
                DeValue::String(text) => bare(text) == GROUND,
                other => other.as_table().and_then(|end| text(end, "body")) == Some(GROUND),
            })
        });
        if let [name] = ends[..]
            && on_ground
            && self.named.get(name) == Some(&1)
            && !self.parents.contains(name)
            && let Some(body) = self.bodies.get(name)
            && body.hinge.stiffness.iter().all(|k| *k == 0.0)
        {
            let directions = (0..3).filter_map(|coordinate| direction(&body.hinge.kind, coordinate));
            let pull = match body.hinge.kind {
                HingeKind::Free => scene.gravity.norm(),
                _ => directions.map(|direction| self.pull(body, &direction)).fold(0.0, f64::max),
            };
            self.check_sag("stiffness", name, body, pull, &stiffness);
        }
    }

    fn check_hinge_sag(&self, table: &DeTable<'_>, kind: &HingeKind, coordinate: usize, stiffness: &Written) {
        let Some(body) = text(table, "name").and_then(|name| self.body(name)) else { return };
        let Some(direction) = direction(kind, coordinate) else { return };
        // Whatever it carries may be held otherwise.
        if !self.held.contains(body.name.as_str()) {
            self.check_sag("hinge.stiffness", &body.name, body, self.pull(body, &direction), stiffness);
        }
    }

    /// What gravity has along a direction of the hinge frame (m/s²), if that is known and much of it; else 0.
    fn pull(&self, body: &BodyDescription, direction: &Vector3<f64>) -> f64 {
        let gravity = self.scene.description.gravity;
        let Some(turn) = self.turn(body, self.bodies.len()) else { return 0.0 };
        let part = (turn * direction).dot(&gravity).abs() / direction.norm();
        if part > STEEP * gravity.norm() { part } else { 0.0 }
    }

    /// How the hinge frame of a body stands if nothing below it turns.
    fn turn(&self, body: &BodyDescription, most: usize) -> Option<UnitQuaternion<f64>> {
        if body.hinge.parent == GROUND {
            return Some(body.hinge.frame);
        }
        let parent = self.bodies.get(body.hinge.parent.as_str()).filter(|_| most > 0)?;
        let is_level = matches!(parent.hinge.kind, HingeKind::Fixed | HingeKind::Prismatic { .. });
        Some(self.turn(parent, most - 1).filter(|_| is_level)? * body.hinge.frame)
    }

    /// A spring that alone carries a body, against its weight and the longest length of the scene.
    fn check_sag(&self, key: &str, name: &str, body: &BodyDescription, pull: f64, stiffness: &Written) {
        let hinge = &body.hinge;
        let scene = self.scene.description;
        let is_held = hinge.lock
            || !(hinge.limits.is_empty() && hinge.curves.is_empty() && hinge.friction.is_empty())
            || hinge.force.iter().any(|force| *force != 0.0)
            || !scene.contacts.is_empty()
            // What statics finds may be the stiffness.
            || exactly(self.scene.document, "statics.unknown").is_some();
        let longest = match longest(self.lengths, None) {
            0.0 => USUAL,
            longest => longest,
        };
        let sag = body.mass.mass * pull / stiffness.value;
        if is_held || sag <= SUNK * longest || sag / 1000.0 > longest {
            return;
        }
        let k = stiffness.value;
        let message = format!("`{key}`: {k} N/m let `{name}` sink by {} m under its own weight", number(sag));
        let help = format!(
            "stiffness is in N/m: {k} N/mm are {}; write \"{k} N/mm\", or \"{k} N/m\" if it is meant",
            number(1000.0 * k)
        );
        self.scene.warn(stiffness, message, help);
    }
}

/// The direction of a coordinate that is a distance, hinge frame.
fn direction(kind: &HingeKind, coordinate: usize) -> Option<Vector3<f64>> {
    match kind {
        HingeKind::Prismatic { axis } | HingeKind::Cylindrical { axis } if coordinate == 0 => Some(*axis),
        HingeKind::Planar if coordinate < 2 => Some(Vector3::ith(coordinate, 1.0)),
        HingeKind::Free if coordinate < 3 => Some(Vector3::ith(coordinate, 1.0)),
        _ => None,
    }
}

/// The bodies that a table names: texts, without markers and numbers of copies, but not its own words.
fn names<'t>(table: &'t DeTable<'_>, found: &mut dyn FnMut(&'t str)) {
    const WORDS: [&str; 8] = ["name", "type", "marker", "expression", "interpolation", "axes", "law", "over"];
    for (key, value) in table {
        let key: &str = key.get_ref();
        if !WORDS.contains(&key) {
            names_in(value.get_ref(), found);
        }
    }
}

fn names_in<'t>(value: &'t DeValue<'_>, found: &mut dyn FnMut(&'t str)) {
    match value {
        DeValue::String(text) if bare(text) != GROUND => found(bare(text)),
        DeValue::Array(items) => items.iter().for_each(|item| names_in(item.get_ref(), found)),
        DeValue::Table(table) => names(table, found),
        _ => {}
    }
}

/// A body's name without a marker and without the number of a copy.
fn bare(name: &str) -> &str {
    let name = name.split('.').next().unwrap_or(name);
    name.split('[').next().unwrap_or(name)
}
