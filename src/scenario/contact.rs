//! `[[contact]]`, and `friction` wherever it stands.

use super::findings::Finding;
use super::reader::{Reader, Value, number};
use super::spans::{self, SpanTable};
use crate::hinge::HingeKind;
use crate::mesh::Mesh;
use crate::model::contact::fits;
use crate::model::description::{BodyDescription, ContactDescription, Description, DryFriction};
use crate::model::shape::{Geometry, Hull};
use crate::model::{Element, Problem, StopLaw};
use nalgebra::Vector3;
use std::collections::HashMap;
use std::path::Path;

/// Reads a `[[contact]]`; `None` if too little of it is readable.
pub(super) fn contact(table: &Reader<'_>, index: usize) -> Option<ContactDescription> {
    let name = table.text("name").map_or_else(|| format!("contact[{index}]"), str::to_owned);
    let sides = table.value("between")?.get_ref().as_array()?;
    let mut sides = sides.iter().map(|side| side.get_ref().as_str().map(str::to_owned));
    let friction = table.value("friction").and_then(|value| friction(table, value));
    let law = law(table, &format!("contact `{name}`"), "a contact");
    Some(ContactDescription {
        name,
        between: [sides.next()??, sides.next()??],
        friction: friction.unwrap_or(DryFriction::new(0.0)),
        law,
    })
}

/// A rigid or a compliant law; `owner` is what has it, `kind` what that is.
pub(super) fn law(table: &Reader<'_>, owner: &str, kind: &str) -> StopLaw {
    let compliant = table.has("stiffness");
    for (key, other) in [("restitution", true), ("damping", false)] {
        if table.has(key) && compliant == other {
            let message = match other {
                true => format!("{owner}: {kind} with `stiffness` has no `restitution`"),
                false => format!("{owner}: {kind} with `damping` needs a `stiffness`"),
            };
            let help = format!("{kind} is rigid, with `restitution`, or compliant, with `stiffness` and `damping`");
            table.findings.push(Finding::error(table.key_span(key), message).help(help));
        }
    }
    match table.number("stiffness") {
        Some(stiffness) => StopLaw::Compliant { stiffness, damping: table.number("damping").unwrap_or(0.0) },
        None => StopLaw::Rigid { restitution: table.number("restitution").unwrap_or(0.0) },
    }
}

/// Pairs that are named in a warning.
const MOST_NAMED: usize = 3;

/// Warns of bodies that a pattern fits and that do not touch because one hangs on the other.
pub(super) fn check_neighbours(scenario: &Reader<'_>, description: &Description) {
    let index: HashMap<&str, &BodyDescription> =
        description.bodies.iter().map(|body| (body.name.as_str(), body)).collect();
    let solid = |body: &BodyDescription| body.shapes.iter().any(|shape| shape.collides);
    let named = |pair: [&str; 2]| {
        let is = |one: &[String; 2]| one[0] == pair[0] && one[1] == pair[1] || one[0] == pair[1] && one[1] == pair[0];
        description.contacts.iter().any(|contact| is(&contact.between))
    };
    let tables = scenario.tables("contact");
    for (table, contact) in tables.iter().zip(&description.contacts) {
        let [one, other] = &contact.between;
        // Everything with everything means what can come together.
        if !(one.contains('*') || other.contains('*')) || one == "*" && other == "*" {
            continue;
        }
        let left_out = |body: &BodyDescription| {
            // What is welded together cannot touch, however it is named.
            if matches!(body.hinge.kind, HingeKind::Fixed) {
                return None;
            }
            let parent = *index.get(body.hinge.parent.as_str())?;
            let fit = |a: &BodyDescription, b: &BodyDescription| fits(one, &a.name) && fits(other, &b.name);
            let both = fit(body, parent) || fit(parent, body);
            let silent = both && solid(body) && solid(parent) && !named([&body.name, &parent.name]);
            silent.then(|| format!("`{}` and `{}`", parent.name, body.name))
        };
        let pairs: Vec<String> = description.bodies.iter().filter_map(left_out).collect();
        if pairs.is_empty() {
            continue;
        }
        let more = if pairs.len() > MOST_NAMED {
            format!(", and {} more pairs", pairs.len() - MOST_NAMED)
        } else {
            String::new()
        };
        let message = format!(
            "contact `{}` leaves out {}{more}: a pattern does not join a body and the one that it hangs on",
            contact.name,
            pairs[..pairs.len().min(MOST_NAMED)].join(", ")
        );
        let help = "a `[[contact]]` with both names joins them";
        scenario.findings.push(Finding::warning(table.span_of("between"), message).help(help));
    }
}

/// Finds the convex parts of the meshes that may touch, with `[[contact]]`s alone: files are read for it.
pub(super) fn find_parts(scenario: &Reader<'_>, description: &mut Description, spans: &SpanTable<'_>) {
    let Description { bodies, contacts, .. } = description;
    let mut unreadable = Vec::new();
    for (index, body) in bodies.iter_mut().enumerate() {
        let names = |contact: &ContactDescription| contact.between.iter().any(|side| fits(side, &body.name));
        let Some(at) = contacts.iter().position(names) else { continue };
        for (k, shape) in body.shapes.iter_mut().enumerate().filter(|(_, shape)| shape.collides) {
            let Geometry::Mesh { file, scale, hull, parts } = &mut shape.geometry else { continue };
            match parts_of(file, *scale, *hull) {
                Ok(found) => *parts = found,
                Err(NoParts::File(why)) => {
                    let message = format!("body `{}` cannot touch: {why}", body.name);
                    unreadable.push(of_mesh(spans, (index, k), message, &contacts[at].name));
                }
                #[cfg(feature = "import")]
                Err(NoParts::Shape(why)) => {
                    let message = format!("the mesh `{}` of body `{}` cannot touch: {why}", file.display(), body.name);
                    let help =
                        "`hull = true` beside `mesh` lets its convex hull touch; `contact = false` nothing of it";
                    let tables = scenario.tables("contact");
                    let place = tables.get(at).map_or(0..0, |table| table.span_of("between"));
                    scenario.findings.push(Finding::error(place, message).label("it is named here").help(help));
                }
            }
        }
    }
    spans::report(spans, unreadable, scenario.findings);
}

/// What is wrong with the file of the `k`-th shape of a body.
fn of_mesh(spans: &SpanTable<'_>, (body, k): (usize, usize), message: String, contact: &str) -> Problem {
    let help = format!(
        "contact `{contact}` needs the file, which is looked for from the folder of the scenario; `contact = false` beside `mesh` lets nothing of \
         it touch"
    );
    let of_list = format!("shape[{k}].mesh");
    let mut problem =
        Problem { element: Element::Body(body), field: "shape.mesh".to_owned(), message, help: Some(help) };
    // One shape stands alone or in a list: the deepest place is that of its file.
    let listed = spans::locate(spans, &Problem { field: of_list.clone(), ..problem.clone() });
    if spans::locate(spans, &problem).map(|span| span.len()) > listed.map(|span| span.len()) {
        problem.field = of_list;
    }
    problem
}

/// Why a mesh has no convex parts.
enum NoParts {
    /// Its file cannot be read.
    File(String),
    /// It is no solid that is convex part by part.
    #[cfg(feature = "import")]
    Shape(String),
}

#[cfg(feature = "import")]
fn parts_of(file: &Path, scale: Vector3<f64>, hull: bool) -> Result<Vec<Hull>, NoParts> {
    let mesh = Mesh::read(file).map_err(|error| NoParts::File(error.to_string()))?;
    let parts = mesh.convex_parts(scale, hull).map_err(|error| NoParts::Shape(error.to_string()))?;
    Ok(parts.into_iter().map(|(corners, triangles)| Hull { corners, triangles }).collect())
}

#[cfg(not(feature = "import"))]
fn parts_of(file: &Path, _: Vector3<f64>, _: bool) -> Result<Vec<Hull>, NoParts> {
    Mesh::read(file).map(|_| Vec::new()).map_err(|error| NoParts::File(error.to_string()))
}

/// One number, or one at rest and one in motion.
pub(super) fn friction(table: &Reader<'_>, value: Value<'_>) -> Option<DryFriction> {
    if let Some(inner) = table.open(value) {
        return Some(DryFriction { stick: inner.number("stick")?, slide: inner.number("slide")? });
    }
    number(value.get_ref()).map(DryFriction::new)
}
