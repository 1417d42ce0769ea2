//! Springs that pull at the start as nothing else does, or let what they carry fall.

use super::lengths::Lengths;
use super::{Scene, Written, by_coordinate, exactly, hinge_of, in_millimetres, limits, text, units};
use crate::force::{Act, Law};
use crate::hinge::HingeKind;
use crate::model::Model;
use crate::model::description::{BodyDescription, GROUND};
use crate::model::problem::{number, rounded};
use crate::motion::Motion;
use nalgebra::{UnitQuaternion, Vector3};
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use toml::de::{DeTable, DeValue};

/// A spring that pulls or pushes at the start with so many times the weight of the whole scene is hardly meant, unless a stop may bear it: valves
/// are pressed on their seats as hard as that.
const WEIGHTS: f64 = 1000.0;
/// Nobody writes less than a millimetre in millimetres (mm).
const LEAST: f64 = 1.0;
/// A spring that lets its own body sink by so many times the longest length of the scene is hardly meant, either.
const SUNK: f64 = 10.0;
/// The length of a scene that has none (m).
const USUAL: f64 = 1.0;
/// What has less of gravity than this part is no slide that bears a weight.
const STEEP: f64 = 0.5;

/// `model` is that of the scene; `None` if the scene has none.
pub(super) fn check(scene: &Scene<'_>, lengths: &Lengths<'_>, model: Option<&Model>) {
    let springs = Springs::new(scene, lengths);
    for body in scene.tables("body") {
        springs.in_hinge(body);
    }
    let is_spring = |force: &&DeTable<'_>| text(force, "type") == Some("spring");
    scene.tables("force").filter(is_spring).for_each(|force| springs.carries(force));
    if let Some(model) = model.filter(|_| scene.tables("force").any(|force| is_spring(&force))) {
        springs.between(model);
    }
}

struct Springs<'s, 'a> {
    scene: &'s Scene<'a>,
    lengths: &'s Lengths<'a>,
    bodies: BTreeMap<&'s str, &'s BodyDescription>,
    /// How often couplings, forces, loads and contacts name a body.
    named: BTreeMap<&'s str, usize>,
    /// Bodies that carry others.
    parents: BTreeSet<&'s str>,
    /// Bodies that are named so, or carry one that is.
    held: BTreeSet<&'s str>,
    /// The weight of all bodies (N); `None` if it is none, or is not all in bodies.
    weight: Option<f64>,
    /// Whether statics finds numbers of the scene: one of a spring is a guess then.
    is_sought: bool,
    /// How the hinge frames of bodies stand, if nothing below them turns: those that were asked for.
    turns: RefCell<BTreeMap<&'s str, Option<UnitQuaternion<f64>>>>,
}

impl<'s, 'a> Springs<'s, 'a> {
    fn new(scene: &'s Scene<'a>, lengths: &'s Lengths<'a>) -> Self {
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
        let is_of_bodies = scene.description.beams.is_empty() && scene.description.modals.is_empty();
        let weight = all.iter().map(|body| body.mass.mass).sum::<f64>() * scene.description.gravity.norm();
        let weight = (is_of_bodies && weight > 0.0).then_some(weight);
        let is_sought = exactly(scene.document, "statics.unknown").is_some();
        let turns = RefCell::default();
        Self { scene, lengths, bodies, named, parents, held, weight, is_sought, turns }
    }

    /// The body of a table, the first of its copies.
    fn body(&self, name: &str) -> Option<&'s BodyDescription> {
        self.bodies.get(name).or_else(|| self.bodies.get(format!("{name}[0]").as_str())).copied()
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
            let stops = exactly(table, "hinge.limits").map(limits).unwrap_or_default();
            if !stops.iter().any(|(of, _)| *of == coordinate) {
                let ends = ["rest", "position"].map(|key| (key, of(key, units.len(), coordinate)));
                self.check_preload(&stiffness, &ends);
            }
            self.check_hinge_sag(table, &kind, coordinate, &stiffness);
        }
    }

    /// The spring of a slide, against the weight of the scene.
    fn check_preload(&self, stiffness: &Written, ends: &[(&str, Option<Written>); 2]) {
        let value = |(_, end): &(&str, Option<Written>)| end.as_ref().map_or(0.0, |end| end.value);
        let force = stiffness.value * (value(&ends[0]) - value(&ends[1])).abs();
        let longer = if value(&ends[1]).abs() > value(&ends[0]).abs() { &ends[1] } else { &ends[0] };
        if let (key, Some(end)) = longer {
            self.tell_preload(&format!("hinge.{key}"), end, force);
        }
    }

    fn tell_preload(&self, key: &str, length: &Written, force: f64) {
        let weight = self.weight.filter(|weight| force > WEIGHTS * weight && !self.is_sought);
        let Some(weight) = weight else { return };
        let message = format!(
            "`{key}`: the spring has {} N at the start, {} times the weight of the scene",
            rounded(force),
            rounded((force / weight).round())
        );
        let help = match length.value.abs() < LEAST {
            true => format!("stiffness is in N/m, lengths are metres; write \"{} m\" if it is meant", length.value),
            false => in_millimetres(length.value),
        };
        self.scene.warn(length, message, help);
    }

    /// Springs between points, as the model begins.
    fn between(&self, model: &Model) {
        let mut motion = Motion::new(model);
        motion.update(model, &model.start_position, &vec![0.0; model.velocity_count()]);
        for (table, force) in self.scene.tables("force").zip(model.forces.iter()) {
            if let (Law::Spring(spring), Some(length)) = (&force.law, self.scene.number(table, "length")) {
                self.tell_preload("length", &length, spring.pull(&motion.links).abs());
            }
        }
    }

    /// A spring between points that alone carries a body.
    fn carries(&self, table: &DeTable<'_>) {
        let Some(stiffness) = self.scene.number(table, "stiffness").filter(|k| k.value > 0.0) else { return };
        let scene = self.scene.description;
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
    fn pull(&self, body: &'s BodyDescription, direction: &Vector3<f64>) -> f64 {
        let gravity = self.scene.description.gravity;
        let Some(turn) = self.turn(body) else { return 0.0 };
        let part = (turn * direction).dot(&gravity).abs() / direction.norm();
        if part > STEEP * gravity.norm() { part } else { 0.0 }
    }

    /// How the hinge frame of a body stands if nothing below it turns.
    fn turn(&self, body: &'s BodyDescription) -> Option<UnitQuaternion<f64>> {
        let mut turns = self.turns.borrow_mut();
        // Down to the ground or to a body that is known, and back; in a ring of parents nothing stands.
        let (mut way, mut at) = (Vec::new(), Some(body));
        let mut turn = loop {
            let Some(one) = at.filter(|_| way.len() <= self.bodies.len()) else { break None };
            if let Some(known) = turns.get(one.name.as_str()) {
                break *known;
            }
            way.push(one);
            if one.hinge.parent == GROUND {
                break Some(UnitQuaternion::identity());
            }
            at = self.bodies.get(one.hinge.parent.as_str()).copied();
        };
        for one in way.into_iter().rev() {
            let parent = self.bodies.get(one.hinge.parent.as_str());
            let is_level =
                parent.is_none_or(|it| matches!(it.hinge.kind, HingeKind::Fixed | HingeKind::Prismatic { .. }));
            turn = turn.filter(|_| is_level).map(|turn| turn * one.hinge.frame);
            turns.insert(&one.name, turn);
        }
        turn
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
            || self.is_sought;
        let longest = match self.lengths.longest() {
            0.0 => USUAL,
            longest => longest,
        };
        let sag = body.mass.mass * pull / stiffness.value;
        if is_held || sag <= SUNK * longest || sag / 1000.0 > longest {
            return;
        }
        let k = stiffness.value;
        let message = format!("`{key}`: {k} N/m let `{name}` sink by {} m under its own weight", rounded(sag));
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
