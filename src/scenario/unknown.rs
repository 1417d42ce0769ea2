//! `statics.unknown` and `statics.margin`: addresses of the numbers that inverse statics finds, and of those that may move
//! while a pose stands.

use super::findings::Finding;
use super::reader::Reader;
use crate::model::couplings::DriveDescription;
use crate::model::description::BodyDescription;
use crate::model::parameter::Field;
use crate::model::{Description, Element, Parameter};
use crate::statics::settings::Margin;

/// The parameters that the list stands for, in its order.
pub(super) fn read(scenario: &Reader<'_>, description: &Description) -> Vec<Parameter> {
    let Some(table) = scenario.table("statics") else { return Vec::new() };
    let Some(list) = table.value("unknown").and_then(|value| value.get_ref().as_array()) else { return Vec::new() };
    let mut all: Vec<Parameter> = Vec::new();
    // With an aim the pose follows from the numbers, as in every search; only guesses are no numbers of an equilibrium.
    let is_aimed = table.has("aim");
    for item in list {
        let Some(address) = item.get_ref().as_str() else { continue };
        let refuse = |message: String, help: Option<String>| {
            table.findings.push_value(Finding::error(item.span(), message).maybe_help(help));
        };
        match Parameter::find(description, address) {
            Ok(found) if is_aimed && found.iter().any(|one| is_guess(one, description)) => {
                let help = "a position can be unknown where a hinge is held: add `lock = true` to it, or a drive";
                refuse(format!("`{address}` is a guess, statics finds it"), Some(help.to_owned()));
            }
            Ok(found) if !is_aimed && found.iter().any(|one| matches!(one.element, Element::Loop(_))) => {
                let help = "lengths of rods follow from the pose; unknown can be forces, springs, loads and masses";
                refuse(format!("`{address}` is part of the pose, which is given"), Some(help.to_owned()));
            }
            Ok(found) if !is_aimed && found.iter().any(|one| one.field == Field::Position) => {
                let help = "the pose is what inverse statics starts from; for a pose leave `unknown` out";
                refuse(format!("`{address}` is part of the pose, which is given"), Some(help.to_owned()));
            }
            Ok(found) if !is_aimed && found.iter().any(|one| moves_pose(one, description)) => {
                let help = "unknown can be what leaves the pose and the points of loops where they are";
                refuse(format!("`{address}` moves the pose, which is given"), Some(help.to_owned()));
            }
            Ok(found) => match found.iter().find(|one| all.contains(one)) {
                Some(twice) => refuse(format!("`{}` is unknown twice", twice.address), None),
                None => all.extend(found),
            },
            Err(error) => refuse(error.message, error.help),
        }
    }
    all
}

/// Whether a number is where the search begins: a position of a hinge that nothing holds there.
pub(super) fn is_guess(one: &Parameter, description: &Description) -> bool {
    let Element::Body(body) = one.element else { return false };
    let driven = |drive: &DriveDescription| {
        drive.coordinate.body == description.bodies[body].name && drive.coordinate.index == one.component()
    };
    let is_held = description.bodies[body].hinge.lock || description.drives.iter().any(driven);
    one.field == Field::Position && !is_held
}

/// Whether coordinates, or where loops close, follow from a named number: seen at another value of it.
fn moves_pose(one: &Parameter, description: &Description) -> bool {
    let (value, mut moved) = (one.value(description), description.clone());
    if one.field != Field::Named || one.set(&mut moved, if value == 0.0 { 1e-3 } else { 1.001 * value }).is_err() {
        return false;
    }
    let pose = |it: &Description| it.bodies.iter().map(|body| body.hinge.position.clone()).collect::<Vec<_>>();
    let places = |it: &Description| {
        let of = |body: &BodyDescription| {
            let hinge = &body.hinge;
            (body.markers.clone(), hinge.kind, hinge.at.clone(), hinge.frame)
        };
        (it.loops.clone(), it.gears.clone(), it.drives.clone(), it.bodies.iter().map(of).collect::<Vec<_>>())
    };
    pose(&moved) != pose(description) || !description.loops.is_empty() && places(&moved) != places(description)
}

/// What may move while the pose stands.
pub(super) fn margin(scenario: &Reader<'_>, description: &Description) -> Margin {
    let mut margin = Margin::default();
    let Some(table) = scenario.table("statics") else { return margin };
    let Some(list) = table.value("margin").and_then(|value| value.get_ref().as_array()) else { return margin };
    for item in list {
        match item.get_ref().as_str() {
            // It is always said.
            None | Some("friction") => {}
            Some("tilt") => margin.tilt = true,
            Some(address) => match Parameter::find(description, address) {
                Ok(found) if found.iter().any(|one| one.field == Field::Position) => {
                    let message = format!("`{address}` is part of the pose, which is given");
                    let help =
                        "margins are of forces, loads, masses, lengths and stiffnesses, of `friction` and of `tilt`";
                    table.findings.push_value(Finding::error(item.span(), message).help(help));
                }
                Ok(found) if found.iter().any(|one| one.field == Field::Named) => {
                    let message = format!(
                        "`{address}`: a margin needs a load that varies linearly, and loads need not be linear in a parameter"
                    );
                    let help = "give the address of a force, a load, a mass, a length or a stiffness";
                    table.findings.push_value(Finding::error(item.span(), message).help(help));
                }
                Ok(found) => margin.numbers.extend(found),
                Err(error) => {
                    table.findings.push_value(Finding::error(item.span(), error.message).maybe_help(error.help));
                }
            },
        }
    }
    margin
}
