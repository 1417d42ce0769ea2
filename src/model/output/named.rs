//! What the names in outputs stand for.

use super::super::Model;
use super::super::couplings::Closure;
use super::super::description::Description;
use super::super::problem::number;
use super::{LengthQuantity, Source};
use crate::force::Act;
use crate::hinge::Names;
use crate::suggest::closest;
use std::ops::Range;

/// Why a name stands for nothing.
pub(super) struct Unknown {
    pub(super) message: String,
    pub(super) help: Option<String>,
}

fn unknown(message: String, help: impl Into<Option<String>>) -> Unknown {
    Unknown { message, help: help.into() }
}

/// The places of hinge coordinates, or of their rates, and their units. Addresses are `body` for all coordinates of a
/// hinge, `body.position[1]`, `body.velocity[1]`, or `body.angle` by the coordinate's own name.
pub(super) fn coordinates(model: &Model, address: &str, rate: bool) -> Result<(Range<usize>, Vec<String>), Unknown> {
    let names = || model.bodies.iter().map(|body| body.name.as_str());
    let rest = |name: &str| match address.strip_prefix(name)? {
        "" => Some(""),
        rest => rest.strip_prefix('.'),
    };
    let body = model.bodies.iter().filter(|body| rest(&body.name).is_some()).max_by_key(|body| body.name.len());
    let Some(body) = body else {
        let written = address.rsplit_once('.').map_or(address, |(body, _)| body);
        let near = closest(written, names()).map(|near| format!("did you mean `{near}`?"));
        return Err(unknown(format!("there is no hinge coordinate `{address}`"), near));
    };
    let (hinge, key) = (&body.hinge, rest(&body.name).unwrap_or_default());
    let key = key.strip_prefix("hinge.").unwrap_or(key);
    let (own, plain) =
        (if rate { hinge.kind.velocities() } else { hinge.kind.positions() }, hinge.kind.plain_coordinates());
    let first = if rate { hinge.velocity } else { hinge.position };
    let units = |range: Range<usize>| own[range].iter().map(|(_, unit)| (*unit).to_owned()).collect::<Vec<_>>();
    let wrong = |message: String| {
        let known: Vec<String> = own.iter().map(|(name, _)| format!("`{}.{name}`", body.name)).collect();
        unknown(message, (!known.is_empty()).then(|| format!("it has {}", known.join(", "))))
    };
    if own.is_empty() {
        return Err(unknown(format!("the {} hinge of `{}` has no coordinates", hinge.kind.name(), body.name), None));
    }
    let named = |names: Names, below: usize| names.iter().take(below).position(|(name, _)| *name == key);
    // Of angles and distances the rate may be addressed by the coordinate.
    let positions = || named(hinge.kind.positions(), plain).filter(|_| rate);
    if let Some(index) = named(own, usize::MAX).or_else(positions) {
        return Ok((first + index..first + index + 1, units(index..index + 1)));
    }
    let index = match key {
        "" | "position" | "velocity" => None,
        _ => {
            let inner = key.strip_prefix("position[").or_else(|| key.strip_prefix("velocity["));
            let index = inner.and_then(|inner| inner.strip_suffix(']')?.parse::<usize>().ok());
            Some(index.ok_or_else(|| wrong(format!("the hinge of `{}` has no coordinate `{key}`", body.name)))?)
        }
    };
    // The coordinates of a turn in space have no rates of their own.
    let by_position = rate && key.starts_with("position") && index.is_none_or(|index| index >= plain);
    if key.starts_with("velocity") && !rate || by_position && plain < own.len() {
        let right = if rate { "velocity" } else { "position" };
        return Err(wrong(format!("`{address}` is addressed by `{right}` here")));
    }
    match index {
        None => Ok((first..first + own.len(), units(0..own.len()))),
        Some(index) if index < own.len() => Ok((first + index..first + index + 1, units(index..index + 1))),
        Some(_) => Err(wrong(format!("the hinge of `{}` has no coordinate `{key}`", body.name))),
    }
}

/// The place in a list that `name` is, or that `key[i]` addresses.
fn find<T>(list: &[T], key: &str, name: &str, of: impl Fn(&T) -> &str) -> Option<usize> {
    let placed = || name.strip_prefix(key)?.strip_prefix('[')?.strip_suffix(']')?.parse().ok();
    list.iter().position(|one| of(one) == name).or_else(|| placed().filter(|index| *index < list.len()))
}

/// The element whose force is asked for.
pub(super) fn source(description: &Description, model: &Model, name: &str) -> Result<Source, Unknown> {
    let force =
        find(&model.forces, "force", name, |one| &one.name).map(|index| match model.forces[index].law.is_line() {
            true => ("force", Source::Line(index)),
            false => ("force", Source::Element(index)),
        });
    let motor = find(&model.motors, "motor", name, |one| &one.name).map(|index| ("motor", Source::Motor(index)));
    let drive = find(&model.drives, "drive", name, |one| &one.name).map(|index| ("drive", Source::Drive(index)));
    let gear = find(&model.gears, "gear", name, |one| &one.name).map(|index| ("gear", Source::Gear(index)));
    let closed = find(&model.loops, "loop", name, |one| &one.name).map(|index| match model.loops[index].closure {
        Closure::Rod { .. } => ("loop", Source::Rod(index)),
        Closure::Hinge(_) => ("loop", Source::Loop(index)),
    });
    let contact =
        find(&description.contacts, "contact", name, |one| &one.name).map(|index| ("contact", Source::Contact(index)));
    let mut found: Vec<(&str, Source)> = [force, motor, drive, gear, closed, contact].into_iter().flatten().collect();
    if found.len() > 1 {
        let kinds: Vec<&str> = found.iter().map(|(kind, _)| *kind).collect();
        let help = format!("address one of them by its place, as `{}[0]`", kinds[0]);
        return Err(unknown(format!("`{name}` is the name of a {}", kinds.join(" and of a ")), help));
    }
    if let Some((_, source)) = found.pop() {
        return Ok(source);
    }
    if let Some(body) = model.body(name) {
        let mut stops: Vec<usize> =
            model.stops.iter().filter(|stop| stop.body == body).map(|stop| stop.velocity).collect();
        stops.sort_unstable();
        stops.dedup();
        if !stops.is_empty() {
            return Ok(Source::Stops(stops));
        }
        let help = "a hinge without `limits` has no stops; what it passes on is `type = \"reaction\"`";
        return Err(unknown(format!("the hinge of `{name}` has no stops"), help.to_owned()));
    }
    let named = model.forces.iter().map(|one| one.name.as_str());
    let named = named.chain(model.motors.iter().map(|one| one.name.as_str()));
    let named = named.chain(model.drives.iter().map(|one| one.name.as_str()));
    let named = named.chain(model.gears.iter().map(|one| one.name.as_str()));
    let named = named.chain(model.loops.iter().map(|one| one.name.as_str()));
    let named = named.chain(description.contacts.iter().map(|one| one.name.as_str()));
    let near = closest(name, named).map(|near| format!("did you mean `{near}`?"));
    Err(unknown(format!("no force element, motor, drive, gear, loop or contact is called `{name}`"), near))
}

/// The spring, curve or rope whose length is asked for.
pub(super) fn line(model: &Model, name: &str) -> Result<LengthQuantity, Unknown> {
    if let Some(beam) = model.beams.iter().position(|beam| beam.name == name) {
        return Ok(LengthQuantity::Beam(beam));
    }
    match find(&model.forces, "force", name, |one| &one.name) {
        Some(index) if model.forces[index].law.is_line() => Ok(LengthQuantity::Line(index)),
        Some(_) => Err(unknown(
            format!("`{name}` has no length"),
            "springs, curves, ropes, sliders, beams and cables have one".to_owned(),
        )),
        None => {
            let lines = model.forces.iter().filter(|force| force.law.is_line()).map(|force| force.name.as_str());
            let all = lines.chain(model.beams.iter().map(|beam| beam.name.as_str()));
            let near = closest(name, all).map(|near| format!("did you mean `{near}`?"));
            Err(unknown(format!("no spring, curve, rope, slider, beam or cable is called `{name}`"), near))
        }
    }
}

/// A section of a beam or cable.
pub(super) fn section(model: &Model, name: &str, s: f64) -> Result<usize, Unknown> {
    let Some(index) = model.beams.iter().position(|beam| beam.name == name) else {
        let near = closest(name, model.beams.iter().map(|beam| beam.name.as_str()));
        let help = near.map(|near| format!("did you mean `{near}`?"));
        return Err(unknown(format!("no beam or cable is called `{name}`"), help));
    };
    let length = model.beams[index].length;
    match (0.0..=length * (1.0 + 1e-9)).contains(&s) {
        true => Ok(index),
        false => {
            Err(unknown(format!("`{name}` has no section at s = {s}"), format!("allowed: 0 … {} m", number(length))))
        }
    }
}
