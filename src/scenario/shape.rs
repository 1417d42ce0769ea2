//! `shape`: solids for pictures, and for mass where a density is given.

use super::fields::listed;
use super::findings::Finding;
use super::reader::Reader;
use crate::mesh::Mesh;
use crate::model::description::Description;
use crate::model::shape::{Geometry, Shape};
use crate::suggest::closest;
use nalgebra::{Isometry3, Translation3, Vector3};
use std::path::Path;
use toml::Spanned;
use toml::de::DeValue;

const SOLIDS: [&str; 6] = ["box", "sphere", "cylinder", "capsule", "plane", "mesh"];

/// The solids of a body; mesh files are found from `folder`.
pub(super) fn shapes(body: &Reader<'_>, owner: &str, folder: &Path) -> Vec<Shape> {
    body.tables("shape").iter().filter_map(|table| shape(table, owner, folder)).collect()
}

fn shape(table: &Reader<'_>, owner: &str, folder: &Path) -> Option<Shape> {
    let given: Vec<&str> = SOLIDS.into_iter().filter(|solid| table.has(solid)).collect();
    let [solid] = given[..] else {
        let said = if given.is_empty() { "none".to_owned() } else { listed(given.into_iter()) };
        let message = format!("shape of body `{owner}`: needs exactly one solid, found {said}");
        let help = format!("one of {}", listed(SOLIDS.into_iter()));
        table.findings.push(Finding::error(table.span.clone(), message).help(help));
        return None;
    };
    if solid != "mesh" && table.has("scale") {
        let message = format!("shape of body `{owner}`: `scale` is for meshes, a {solid} has its size");
        table.findings.push(Finding::error(table.key_span("scale"), message));
    }
    if solid != "mesh" && table.has("hull") {
        let message = format!("shape of body `{owner}`: `hull` is for meshes, a {solid} is convex");
        table.findings.push(Finding::error(table.key_span("hull"), message));
    }
    let at = table.vector("at").unwrap_or_default();
    Some(Shape {
        geometry: geometry(table, solid, folder)?,
        pose: Isometry3::from_parts(Translation3::from(at), table.turn("rpy")),
        color: color(table, owner),
        collides: table.flag("contact").unwrap_or(true),
        visible: table.flag("visible").unwrap_or(true),
    })
}

fn geometry(table: &Reader<'_>, solid: &str, folder: &Path) -> Option<Geometry> {
    Some(match solid {
        "box" => Geometry::Box(table.vector("box")?),
        "sphere" => Geometry::Sphere(table.number("sphere")?),
        "plane" => {
            let normal: Vector3<f64> = table.vector("plane")?;
            if !(normal.norm() > 0.0) {
                let finding =
                    Finding::error(table.span_of("plane"), "a plane whose normal is zero has no direction".to_owned());
                table.findings.push_value(finding.help("for example `plane = [0.0, 0.0, 1.0]`"));
                return None;
            }
            Geometry::Plane(normal)
        }
        "mesh" => {
            let scale = table.number("scale").map(Vector3::repeat).or_else(|| table.vector("scale"));
            let file = folder.join(table.text("mesh")?);
            if !file.is_file() {
                let message = format!("there is no mesh file `{}`: it is not drawn", file.display());
                table.findings.push(Finding::warning(table.span_of("mesh"), message));
            }
            let scale = scale.unwrap_or(Vector3::repeat(1.0));
            Geometry::Mesh { file, scale, hull: table.flag("hull").unwrap_or(false), parts: Vec::new() }
        }
        _ => {
            let (radius, length) = round(table, solid)?;
            match solid {
                "cylinder" => Geometry::Cylinder { radius, length },
                _ if length == 0.0 => {
                    let message = "a capsule of length 0 is a sphere".to_owned();
                    let finding = Finding::error(table.span_of(solid), message)
                        .help("`sphere = radius`; a radius of 0 is a point");
                    table.findings.push_value(finding);
                    return None;
                }
                _ => Geometry::Capsule { radius, length },
            }
        }
    })
}

/// Radius and length, as a list or as a table.
fn round(table: &Reader<'_>, solid: &str) -> Option<(f64, f64)> {
    match table.table(solid) {
        Some(size) => Some((size.number("radius")?, size.number("length")?)),
        None => match table.numbers(solid)?[..] {
            [radius, length] => Some((radius, length)),
            _ => None,
        },
    }
}

fn color(table: &Reader<'_>, owner: &str) -> Option<[f64; 4]> {
    let value = table.value("color")?;
    let color = match value.get_ref() {
        DeValue::String(text) => hex(text).or_else(|| named(text)),
        _ => match table.numbers("color")?[..] {
            [r, g, b] => Some([r, g, b, 1.0]),
            [r, g, b, a] => Some([r, g, b, a]),
            _ => None,
        },
    };
    if color.is_none() {
        let message = format!("shape of body `{owner}`: `color` must be \"#rrggbb\", \"#rrggbbaa\", or a name");
        let names = NAMED.map(|(name, _)| name).join(", ");
        let near = value.get_ref().as_str().and_then(|text| closest(text, NAMED.iter().map(|(name, _)| *name)));
        let near = near.map_or(String::new(), |near| format!("did you mean \"{near}\"? "));
        let help = format!("{near}names are {names}; or for example `color = \"#cc3311\"`");
        let finding = Finding::error(Spanned::span(value), message).help(help);
        table.findings.push_value(finding);
    }
    color
}

/// The sixteen colours of HTML, and some more of CSS with their values there.
const NAMED: [(&str, u32); 24] = [
    ("black", 0x000000),
    ("silver", 0xc0c0c0),
    ("gray", 0x808080),
    ("white", 0xffffff),
    ("maroon", 0x800000),
    ("red", 0xff0000),
    ("purple", 0x800080),
    ("fuchsia", 0xff00ff),
    ("green", 0x008000),
    ("lime", 0x00ff00),
    ("olive", 0x808000),
    ("yellow", 0xffff00),
    ("navy", 0x000080),
    ("blue", 0x0000ff),
    ("teal", 0x008080),
    ("aqua", 0x00ffff),
    ("orange", 0xffa500),
    ("gold", 0xffd700),
    ("brown", 0xa52a2a),
    ("pink", 0xffc0cb),
    ("violet", 0xee82ee),
    ("turquoise", 0x40e0d0),
    ("steelblue", 0x4682b4),
    ("grey", 0x808080),
];

fn named(text: &str) -> Option<[f64; 4]> {
    let (_, rgb) = NAMED.iter().find(|(name, _)| name.eq_ignore_ascii_case(text))?;
    let [_, parts @ ..] = rgb.to_be_bytes();
    let [red, green, blue] = parts.map(|part| f64::from(part) / 255.0);
    Some([red, green, blue, 1.0])
}

fn hex(text: &str) -> Option<[f64; 4]> {
    let digits = text.strip_prefix('#').filter(|digits| digits.bytes().all(|byte| byte.is_ascii_hexdigit()))?;
    let part = |at: usize| Some(f64::from(u8::from_str_radix(digits.get(at..at + 2)?, 16).ok()?) / 255.0);
    match digits.len() {
        6 => Some([part(0)?, part(2)?, part(4)?, 1.0]),
        8 => Some([part(0)?, part(2)?, part(4)?, part(6)?]),
        _ => None,
    }
}

/// Mesh files that are there and cannot be read: what is wrong with each, and whose it is.
pub fn unreadable_meshes(scene: &Description) -> Vec<String> {
    let mut wrong = Vec::new();
    for body in &scene.bodies {
        for shape in &body.shapes {
            if let Geometry::Mesh { file, .. } = &shape.geometry
                && file.is_file()
                && let Err(error) = Mesh::read(file)
            {
                wrong.push(format!("body `{}`: {error}", body.name));
            }
        }
    }
    wrong
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hex_colors_have_six_or_eight_digits() {
        assert_eq!(hex("#ff0033"), Some([1.0, 0.0, 0.2, 1.0]));
        assert_eq!(hex("#ff003300"), Some([1.0, 0.0, 0.2, 0.0]));
        assert_eq!((named("Orange"), named("orang")), (hex("#ffa500"), None));
        for wrong in ["", "ff0033", "#ff003", "#ff003g", "#+f0033", "#äöü"] {
            assert_eq!(hex(wrong), None, "{wrong}");
        }
    }
}
