//! Mass properties of a body, given or from its shapes.

use super::findings::Finding;
use super::format::BODY;
use super::reader::{Reader, number, numbers, rows};
use crate::mesh::Mesh;
use crate::model::burn::BurnDescription;
use crate::model::description::{MassProperties, Timeline};
use crate::model::problem::counted;
use crate::model::shape::{Geometry, Shape, combined};
use nalgebra::{Matrix3, Point3, Vector3};
use std::path::Path;

/// Mass properties, and the masses of the copies where a repeat gives a list.
#[derive(Debug)]
pub(super) struct Mass {
    pub(super) properties: MassProperties,
    pub(super) each: Option<Vec<f64>>,
}

/// What stands in for what could not be read, so that nothing else is found wrong because of it.
pub(super) const STAND_IN: MassProperties = MassProperties {
    mass: 1.0,
    center: Vector3::new(0.0, 0.0, 0.0),
    inertia: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
};

pub(super) fn mass(body: &Reader<'_>, owner: &str, repeat: Option<usize>, shapes: &[Shape]) -> Mass {
    let errors = body.findings.errors();
    let unreadable = ["mass", "center", "inertia", "density", "shape"]
        .into_iter()
        .any(|key| body.has(key) && body.value(key).is_none() && (key != "shape" || body.has("density")));
    // A misspelt key may be the one that is missing.
    let misspelt = body.table.keys().any(|key| BODY.declarations(key.get_ref()).next().is_none());
    let unreadable = unreadable || misspelt && !body.has("mass");
    let mass = if body.has("density") { filled(body, owner, shapes) } else { given(body, owner, repeat) };
    match mass {
        Some(mass) if !unreadable && body.findings.errors() == errors => mass,
        _ => Mass { properties: STAND_IN, each: None },
    }
}

fn given(body: &Reader<'_>, owner: &str, repeat: Option<usize>) -> Option<Mass> {
    if !body.has("mass") {
        for key in ["inertia", "center"] {
            if body.has(key) {
                let message = format!("body `{owner}`: `{key}` without `mass`");
                let help = "give `mass`, or `density` to have both follow from the shapes";
                body.findings.push(Finding::error(body.key_span(key), message).help(help));
            }
        }
    }
    let (mass, each) = masses(body, owner, repeat)?;
    let center = body.vector("center").unwrap_or_default();
    let inertia = body.numbers("inertia").map_or_else(Matrix3::zeros, |moments| tensor(&moments));
    Some(Mass { properties: MassProperties { mass, center, inertia }, each })
}

/// xx, yy, zz, or those and xy, xz, yz.
fn tensor(moments: &[f64]) -> Matrix3<f64> {
    match *moments {
        [xx, yy, zz, xy, xz, yz] => Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz),
        [xx, yy, zz] => Matrix3::from_diagonal(&Vector3::new(xx, yy, zz)),
        _ => Matrix3::zeros(),
    }
}

/// A mass that burns away, of a body of this name.
pub(super) fn burn(body: &Reader<'_>, owner: &str) -> Option<BurnDescription> {
    let table = body.table("burn")?;
    let beside = ["mass", "center", "inertia", "density"].into_iter().find(|key| body.has(key));
    if let Some(key) = beside.or_else(|| body.has("repeat").then_some("repeat")) {
        let message = format!("body `{owner}`: `{key}` beside `burn`");
        let help = "a body that burns has `mass`, `center` and `inertia` in its table, and is one";
        body.findings.push(Finding::error(body.key_span(key), message).help(help));
        return None;
    }
    let timeline = Timeline { times: table.numbers("times")? };
    let masses = table.numbers("mass")?;
    let list = |key: &str| table.value(key).map(|value| rows(value.get_ref()).unwrap_or_default());
    let (centers, inertias) = (list("center"), list("inertia"));
    for (key, count) in [("center", centers.as_ref().map(Vec::len)), ("inertia", inertias.as_ref().map(Vec::len))] {
        if let Some(count) = count.filter(|count| *count != masses.len()) {
            let message = format!(
                "body `{owner}`: `burn` has {} and {} of `{key}`",
                counted(masses.len(), "mass", "masses"),
                counted(count, "row", "rows")
            );
            table.findings.push(Finding::error(table.span_of(key), message));
            return None;
        }
    }
    let row = |(i, mass): (usize, &f64)| MassProperties {
        mass: *mass,
        center: centers.as_ref().map_or_else(Vector3::zeros, |all| Vector3::from_column_slice(&all[i])),
        inertia: inertias.as_ref().map_or_else(Matrix3::zeros, |all| tensor(&all[i])),
    };
    let rows = masses.iter().enumerate().map(row).collect();
    Some(BurnDescription { body: owner.to_owned(), timeline, rows })
}

fn masses(body: &Reader<'_>, owner: &str, repeat: Option<usize>) -> Option<(f64, Option<Vec<f64>>)> {
    let Some(value) = body.value("mass") else { return Some((0.0, None)) };
    if let Some(mass) = number(value.get_ref()) {
        return Some((mass, None));
    }
    let list = numbers(value.get_ref())?;
    match repeat {
        Some(copies) if copies == list.len() => Some((list[0], Some(list))),
        _ if list.len() == 1 => Some((list[0], None)),
        _ => {
            let allowed = match repeat {
                Some(copies) => format!("one number or a list of {copies}, one per copy"),
                None => "one number".to_owned(),
            };
            let message = format!("body `{owner}`: `mass` must be {allowed}, found a list of {}", list.len());
            let help = repeat.is_none().then(|| "lists are for bodies with `repeat`".to_owned());
            body.findings.push_value(Finding::error(value.span(), message).maybe_help(help));
            None
        }
    }
}

/// All solids filled with one density, about their common centre of mass.
fn filled(body: &Reader<'_>, owner: &str, shapes: &[Shape]) -> Option<Mass> {
    for key in ["mass", "center", "inertia"] {
        if body.has(key) {
            let message = format!("body `{owner}`: both `density` and `{key}`");
            let help = "with `density`, mass, centre and inertia follow from the shapes: keep one of the two";
            body.findings.push(Finding::error(body.key_span(key), message).help(help));
        }
    }
    let density = body.number("density")?;
    let mut solids = Vec::new();
    for shape in shapes {
        match &shape.geometry {
            Geometry::Mesh { file, scale, .. } => solids.push(enclosed(body, owner, density, shape, file, *scale)?),
            _ => solids.extend(shape.mass_properties(density)),
        }
    }
    if solids.is_empty() {
        if !body.has("shape") || !shapes.is_empty() {
            let message = format!("body `{owner}`: `density` needs a shape with a volume");
            let help = "give a `shape`: a box, sphere, cylinder, capsule or closed mesh";
            body.findings.push(Finding::error(body.key_span("density"), message).help(help));
        }
        return None;
    }
    Some(Mass { properties: combined(&solids), each: None })
}

/// What a mesh encloses, filled.
fn enclosed(
    body: &Reader<'_>,
    owner: &str,
    density: f64,
    shape: &Shape,
    file: &Path,
    scale: Vector3<f64>,
) -> Option<MassProperties> {
    let refuse = |message: String, help: &str| {
        body.findings.push(Finding::error(body.span_of("shape"), format!("body `{owner}`: {message}")).help(help));
    };
    let mesh = match Mesh::read(file) {
        Ok(mesh) => mesh,
        Err(error) => {
            refuse(error.to_string(), "with `density` the mesh is needed for its volume");
            return None;
        }
    };
    let solid = match mesh.solid(scale) {
        Ok(solid) => solid,
        Err(error) => {
            let help = "close the mesh, or give `mass`, `center` and `inertia` instead of `density`";
            refuse(format!("the mesh `{}` has no mass: {error}", file.display()), help);
            return None;
        }
    };
    if solid.inside_out {
        let message = format!("body `{owner}`: the triangles of `{}` look inwards", file.display());
        let help = "their volume was taken as positive";
        body.findings.push(Finding::warning(body.span_of("shape"), message).help(help));
    }
    let turn = shape.pose.rotation.to_rotation_matrix();
    Some(MassProperties {
        mass: density * solid.volume,
        center: (shape.pose * Point3::from(solid.center)).coords,
        inertia: turn * (solid.inertia * density) * turn.transpose(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_halves_weigh_what_the_whole_weighs() {
        use nalgebra::Isometry3;
        let solid = |edges: Vector3<f64>, z: f64| {
            let pose = Isometry3::translation(0.3, 0.0, z);
            Shape { geometry: Geometry::Box(edges), pose, color: None, collides: true, visible: true }
                .mass_properties(700.0)
                .expect("a box")
        };
        let whole = solid(Vector3::new(0.1, 0.2, 1.0), 0.5);
        let halves = combined(&[solid(Vector3::new(0.1, 0.2, 0.4), 0.2), solid(Vector3::new(0.1, 0.2, 0.6), 0.7)]);
        // Round-off of sums of numbers below 10.
        assert!((whole.mass - halves.mass).abs() < 1e-13);
        assert!((whole.center - halves.center).norm() < 1e-14);
        assert!((whole.inertia - halves.inertia).norm() < 1e-14);
    }
}
