//! `[[beam]]` and `[[cable]]`: flexible beams.

use super::body::Names;
use super::findings::Finding;
use super::force::between;
use super::hinge::hinge;
use super::quantities::Parameters;
use super::reader::{Reader, numbers, only, rows};
use crate::model::beam::MUCH_TURN;
use crate::model::description::{
    BeamDescription, BeamShape, FreeStrains, GROUND, HingeDescription, LineLoad, Material, Section,
};
use nalgebra::{Matrix6, Vector3, Vector6};

/// Reads a `[[beam]]`; without a readable name there is nothing that others could refer to.
pub(super) fn beam(table: &Reader<'_>, parameters: &Parameters) -> Option<BeamDescription> {
    let name = table.text("name")?;
    let mut beam = BeamDescription::new(name, hinge(table, name, None, parameters).description);
    beam.shape = shape(table, name)?;
    beam.twist = table.number("twist").unwrap_or(0.0);
    let beam = common(table, beam)?;
    warn_of_turns(table, &beam);
    Some(beam)
}

/// Reads a `[[cable]]` but for its ends, which [`close`] adds once all names are known.
pub(super) fn cable(table: &Reader<'_>) -> Option<BeamDescription> {
    let name = table.text("name")?;
    let mut cable = BeamDescription::cable(name, (GROUND, [0.0; 3]), (GROUND, [0.0; 3]));
    let pretension = match only(table, &format!("cable `{name}`"), &["length", "pretension"])? {
        "length" => {
            cable.shape = BeamShape::Straight { length: table.number("length")? };
            None
        }
        _ => Some(table.number("pretension")?),
    };
    let ends = table.value("ends").and_then(|ends| ends.get_ref().as_array());
    let clamped = [0, 1].map(|end| ends.is_some_and(|ends| ends[end].get_ref().as_str() == Some("fixed")));
    cable.far.iter_mut().for_each(|far| (far.clamped, far.pretension) = (clamped, pretension));
    cable.bending = table.number("bending");
    common(table, cable)
}

/// Gives a cable its ends.
pub(super) fn close(cable: &mut BeamDescription, table: &Reader<'_>, names: &Names<'_>) {
    let (Some([from, to]), Some(far)) = (between(table, names), &mut cable.far) else { return };
    cable.hinge = HingeDescription::fixed().on(&from.body, from.point);
    far.at = to;
}

/// What beams and cables have in common.
fn common(table: &Reader<'_>, mut beam: BeamDescription) -> Option<BeamDescription> {
    let name = beam.name.clone();
    beam.elements = table.count("elements").unwrap_or(beam.elements);
    beam.degree = table.count("degree").unwrap_or(beam.degree);
    beam.sections = sections(table, &name)?;
    beam.material = table.table("material").map(|material| {
        let poisson = material.number("poisson").unwrap_or(0.3);
        // A number that cannot be read is an error already: that there is no material would be said besides.
        let [young, density] = ["young", "density"].map(|key| material.number(key).unwrap_or(1.0));
        Material { young, poisson, density }
    });
    beam.mass_per_length = table.number("mass_per_length");
    beam.rotary = table.vector("rotary");
    beam.free = free(table).unwrap_or(beam.free);
    beam.damping = table.number("damping").unwrap_or(0.0);
    let markers = table.names("markers").into_iter();
    beam.markers = markers.filter_map(|(name, all)| Some((name.to_owned(), all.number(name)?))).collect();
    beam.load = table.table("load").and_then(|load| {
        let follows = load.text("axes") == Some("body");
        Some(LineLoad { force: load.vector("force")?, follows })
    });
    Some(beam)
}

fn shape(table: &Reader<'_>, name: &str) -> Option<BeamShape> {
    if only(table, &format!("beam `{name}`"), &["length", "curve"])? == "length" {
        return Some(BeamShape::Straight { length: table.number("length")? });
    }
    let curve = table.table("curve")?;
    match only(&curve, &format!("curve of beam `{name}`"), &["arc", "helix", "points"])? {
        "points" => {
            let value = curve.value("points")?;
            let points = rows(value.get_ref())?.iter().map(|point| Vector3::from_column_slice(point)).collect();
            match BeamShape::through(points) {
                Ok(shape) => Some(shape),
                Err(flaw) => {
                    let message = format!("curve of beam `{name}` {}", flaw.message);
                    curve.findings.push_value(Finding::error(value.span(), message).help(flaw.help));
                    None
                }
            }
        }
        "arc" => match curve.numbers("arc")?[..] {
            [radius, angle] => Some(BeamShape::Arc { radius, angle }),
            _ => None,
        },
        _ => match curve.numbers("helix")?[..] {
            [radius, pitch, turns] => Some(BeamShape::Helix { radius, pitch, turns }),
            _ => None,
        },
    }
}

fn sections(table: &Reader<'_>, name: &str) -> Option<Vec<(f64, Section)>> {
    let tables = table.tables("section");
    let several = tables.len() > 1;
    let read = |one: &Reader<'_>| {
        if several && !one.has("s") {
            let message = format!("a section of beam `{name}` has no `s`");
            let help = "in a list every section says where it is: `s`, the distance from the root in m";
            one.findings.push(Finding::error(one.span.clone(), message).help(help));
        }
        Some((one.number("s").unwrap_or(0.0), section(one, name)?))
    };
    tables.iter().map(read).collect()
}

fn section(table: &Reader<'_>, name: &str) -> Option<Section> {
    let key = only(table, &format!("section of beam `{name}`"), &["circle", "tube", "rectangle", "stiffness"])?;
    let pair = || table.numbers(key).and_then(|list| <[f64; 2]>::try_from(list).ok());
    Some(match key {
        "circle" => Section::Circle { radius: table.number(key)? },
        "tube" => pair().map(|[outer, inner]| Section::Tube { outer, inner })?,
        "rectangle" => pair().map(|[width, height]| Section::Rectangle { width, height })?,
        _ => {
            let value = table.value(key)?.get_ref();
            let matrix = match numbers(value) {
                Some(diagonal) => Matrix6::from_diagonal(&Vector6::from_iterator(diagonal)),
                None => Matrix6::from_row_iterator(rows(value)?.into_iter().flatten()),
            };
            Section::Stiffness(matrix)
        }
    })
}

fn free(table: &Reader<'_>) -> Option<FreeStrains> {
    let items = table.value("free")?.get_ref().as_array()?;
    let has = |word: &str| items.iter().any(|item| item.get_ref().as_str() == Some(word));
    Some(FreeStrains { bend: has("bend"), twist: has("twist"), stretch: has("stretch"), shear: has("shear") })
}

/// Elements that are further from their points than this part of the length are worth a word.
const STRAY: f64 = 1e-3;

fn warn_of_turns(table: &Reader<'_>, beam: &BeamDescription) {
    // Numbers that no beam can have are errors of their own.
    let each = if (1..=100_000).contains(&beam.elements) { beam.most_turn() } else { 0.0 };
    if each > MUCH_TURN && each.is_finite() {
        let message = format!("beam `{}` turns by {each:.2} rad in an element", beam.name);
        let needed = (each * beam.elements as f64 / MUCH_TURN).ceil();
        let help = format!("{needed} elements turn by no more than {MUCH_TURN} rad each");
        table.findings.push(Finding::warning(table.span_of("elements"), message).help(help));
        return;
    }
    // Beyond what is an error of the model.
    let (strays, length) = (if each > 0.0 { beam.strays() } else { 0.0 }, beam.shape.length());
    if strays > STRAY * length && strays <= BeamDescription::MOST_STRAY * length {
        let message = format!("the elements of beam `{}` stray from its points by {strays:.2e} m", beam.name);
        let help = "more elements follow them more closely";
        table.findings.push(Finding::warning(table.span_of("elements"), message).help(help));
    }
}
