//! `<geom>`: what a body looks like, and what it weighs where nothing else says so.

use super::super::log::Taken;
use super::asset::{Assets, Mesh};
use super::defaults::Settled;
use super::mass;
use super::pose;
use super::scene::{Drawn, Solid};
use super::settings::{Settings, choice};
use super::weigh::Weight;
use crate::model::description::MassProperties;
use crate::model::shape::{Geometry, Shape};
use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::PI;

/// What a geom is without further words, in kg/m³.
const DENSITY: f64 = 1000.0;

/// Geoms of these groups are shown; others are for contacts.
const SHOWN: f64 = 2.0;

const TYPES: [&str; 9] = ["plane", "hfield", "sphere", "capsule", "ellipsoid", "cylinder", "box", "mesh", "sdf"];

/// A geom as it was read.
pub(super) struct Geom {
    pub(super) drawn: Option<Drawn>,
    /// Whether it can touch others as it is drawn; if it cannot, why not.
    pub(super) touching: Result<(), String>,
    /// Body axes; or why it is not known.
    pub(super) mass: Result<MassProperties, String>,
    /// Its principal axes as MuJoCo has them, body axes.
    pub(super) axes: UnitQuaternion<f64>,
}

/// Reads a geom; `frame` stands between the body and the geom, `counts` tells whether it is part of
/// the body's mass. `None` if it was refused.
pub(super) fn geom(
    settled: &Settled<'_>,
    settings: &Settings,
    assets: &Assets,
    frame: &Isometry3<f64>,
    counts: bool,
) -> Option<Geom> {
    let element = settled.element;
    let kind = match settled.attribute("type") {
        Some(attribute) => TYPES[choice(&attribute, &TYPES)?],
        None => "sphere",
    };
    let group = settled.number("group").unwrap_or(0.0);
    let weighs = counts && (settings.inertia_groups[0]..=settings.inertia_groups[1]).contains(&group);
    let color = color(settled, assets);
    let size = settled.numbers("size", 3).unwrap_or_default();
    let (pose, size) = place(settled, settings, kind, size)?;
    let pose = frame * pose;
    let shell = settled.flag("shellinertia") == Some(true);
    let (mut touching, shown) = (Ok(()), group <= SHOWN && color.is_none_or(|color| color[3] > 0.0));
    let draw = |solid: Solid, pose: Isometry3<f64>| {
        let drawn = Drawn { solid, pose, color, visible: shown, touch: None, place: element.place() };
        Some(drawn).filter(|_| shown || settings.contacts)
    };
    let (drawn, unit) = match kind {
        "plane" if settings.contacts => {
            let drawn = draw(Solid::Numbers("plane", vec![0.0, 0.0, 1.0]), pose);
            return Some(Geom { drawn, touching, mass: Ok(mass::NOTHING), axes: pose.rotation });
        }
        "plane" | "hfield" | "sdf" => {
            let what = match kind {
                "plane" => {
                    "a plane is there for contacts, which are not imported without `contact = true`; it is not drawn"
                }
                "hfield" => "a height field is there for contacts: it touches nothing and is not drawn",
                _ => "a signed distance field has no shape here and weighs nothing",
            };
            element.note(Taken::Ignored, what);
            // Only what does not move can have planes and height fields.
            let unknown = kind == "sdf" && weighs;
            let mass = if unknown { Err(what.to_owned()) } else { Ok(mass::NOTHING) };
            return Some(Geom { drawn: None, touching, mass, axes: pose.rotation });
        }
        "mesh" => {
            let name = settled.attribute("mesh").or_else(|| element.required("mesh"))?;
            let Some(mesh) = assets.meshes.get(name.value) else {
                let near = element.log.near(name.value, assets.meshes.keys().map(String::as_str));
                let help = near.map(|near| format!("did you mean `{near}`?"));
                let problem = name.wrong(&format!("is \"{}\": there is no such mesh in <asset>", name.value));
                element.refuse(problem.maybe_help(help));
                return None;
            };
            let file = mesh.file.clone();
            if settings.contacts {
                touching = mesh.hull().map_err(str::to_owned);
            }
            let drawn = file.map(|file| (Solid::Mesh(file, mesh.placing.scale), pose * mesh.placing.pose()));
            let unit = if weighs && !weightless(settled) { of_mesh(settled, mesh)? } else { Ok(mass::NOTHING) };
            (drawn, unit)
        }
        _ => {
            if let Some(attribute) = settled.attribute("mesh") {
                let problem = attribute.wrong("asks for a primitive that is fitted to a mesh, which is not done here");
                element.refuse(problem.help("write the size and pose that MuJoCo finds, as `mj_saveLastXML` does"));
                return None;
            }
            let (solid, unit) = primitive(settled, kind, &size, shell)?;
            if kind == "ellipsoid" {
                touching = Err(format!("{kind}s touch nothing yet"));
            }
            (Some((solid, pose)), Ok(unit))
        }
    };
    let axes = pose.rotation * own_axes(kind, &unit);
    let mass = match unit {
        Ok(unit) if weighs => Ok(mass::placed(&weight(settled, &unit)?, &pose)),
        unit => unit.map(|_| mass::NOTHING),
    };
    let drawn = drawn.and_then(|(solid, pose)| draw(solid, pose));
    Some(Geom { drawn, touching, mass, axes })
}

/// Principal axes in the axes of the geom: MuJoCo turns a mesh to its own.
fn own_axes(kind: &str, unit: &Result<MassProperties, String>) -> UnitQuaternion<f64> {
    match unit {
        Ok(unit) if kind == "mesh" => mass::principal(&unit.inertia),
        _ => UnitQuaternion::identity(),
    }
}

/// What a mesh weighs with a density of one, or why that is not known; `None` if it was refused.
fn of_mesh(settled: &Settled<'_>, mesh: &Mesh) -> Option<Result<MassProperties, String>> {
    if let Some(attribute) = settled.attribute("shellinertia").filter(|attribute| attribute.value == "true") {
        let problem = attribute.wrong("is for other solids than meshes");
        attribute.element.refuse(problem.help("write inertia=\"shell\" where the mesh is declared, in <asset>"));
        return None;
    }
    let weight = mesh.weight().map_err(str::to_owned);
    if let Ok(Weight { remark: Some(remark), .. }) = &weight {
        settled.element.note(Taken::Used, remark.as_str());
    }
    Some(weight.map(|weight| weight.unit))
}

/// Whether its mass or its density is zero.
fn weightless(settled: &Settled<'_>) -> bool {
    settled.attribute("mass").or_else(|| settled.attribute("density")).and_then(|at| at.number()) == Some(0.0)
}

/// `mass`, or `density` times what it weighs with a density of one.
fn weight(settled: &Settled<'_>, unit: &MassProperties) -> Option<MassProperties> {
    let given = match settled.attribute("mass") {
        Some(_) => Some(settled.not_negative("mass")?),
        None => None,
    };
    let density = match settled.attribute("density") {
        Some(_) => settled.not_negative("density")?,
        None => DENSITY,
    };
    if given == Some(0.0) || given.is_none() && density == 0.0 {
        return Some(mass::NOTHING);
    }
    let factor = given.map_or(density, |mass| mass / unit.mass);
    Some(MassProperties { mass: unit.mass * factor, inertia: unit.inertia * factor, ..*unit })
}

/// The pose, and the size where `fromto` says the length.
fn place(
    settled: &Settled<'_>,
    settings: &Settings,
    kind: &str,
    mut size: Vec<f64>,
) -> Option<(Isometry3<f64>, Vec<f64>)> {
    let Some(attribute) = settled.attribute("fromto") else { return Some((pose::pose(settled, settings), size)) };
    if !matches!(kind, "capsule" | "cylinder" | "box" | "ellipsoid") {
        let problem = attribute.wrong(&format!("says where a long solid begins and ends; this is a {kind}"));
        let help =
            "give `pos`, or one of type=\"capsule\", \"cylinder\", \"box\", \"ellipsoid\"; MuJoCo refuses it too";
        attribute.element.refuse(problem.help(help));
        return None;
    }
    let ends: [f64; 6] = attribute.vector()?;
    let [a, b, c, d, e, f] = ends;
    let (from, to) = (Vector3::new(a, b, c), Vector3::new(d, e, f));
    let along = from - to;
    if !(along.norm() > 1e-14) {
        attribute.element.refuse(attribute.wrong(&format!("is \"{}\", of no length", attribute.value)));
        return None;
    }
    let half = 0.5 * along.norm();
    match kind {
        "capsule" | "cylinder" => {
            size.resize(2, 0.0);
            size[1] = half;
        }
        _ => {
            size.resize(3, 0.0);
            // The cross section is square or round, whatever the second number says.
            size[1] = size[0];
            size[2] = half;
        }
    }
    let pose = Isometry3::from_parts(Translation3::from(0.5 * (from + to)), pose::from_z_to(&along));
    Some((pose, size))
}

/// How it is drawn, and its mass properties for a density of one.
fn primitive(settled: &Settled<'_>, kind: &str, size: &[f64], shell: bool) -> Option<(Solid, MassProperties)> {
    let needed = match kind {
        "sphere" => 1,
        "capsule" | "cylinder" => 2,
        _ => 3,
    };
    if size.len() < needed || size[..needed].iter().any(|number| !(*number > 0.0)) {
        let what = format!("a {kind} needs {needed} positive number{} in `size`", if needed == 1 { "" } else { "s" });
        settled.refuse(
            &format!("{what}, found {size:?}"),
            "sizes are half sizes: radius, half the height, half the edges",
        );
        return None;
    }
    let (solid, geometry) = match kind {
        "sphere" => (Solid::Numbers("sphere", vec![size[0]]), Geometry::Sphere(size[0])),
        "capsule" => {
            let [radius, length] = [size[0], 2.0 * size[1]];
            (Solid::Numbers("capsule", vec![radius, length]), Geometry::Capsule { radius, length })
        }
        "cylinder" => {
            let [radius, length] = [size[0], 2.0 * size[1]];
            (Solid::Numbers("cylinder", vec![radius, length]), Geometry::Cylinder { radius, length })
        }
        "box" => {
            let edges = 2.0 * Vector3::new(size[0], size[1], size[2]);
            (Solid::Numbers("box", edges.iter().copied().collect()), Geometry::Box(edges))
        }
        _ => {
            let radii = Vector3::new(size[0], size[1], size[2]);
            settled
                .element
                .note(Taken::Approximated, "an ellipsoid is drawn as the box around it; it weighs what it weighs");
            let unit = if shell { ellipsoid_surface(&radii) } else { ellipsoid(&radii) };
            return Some((Solid::Numbers("box", (2.0 * radii).iter().copied().collect()), unit));
        }
    };
    let unit = if shell {
        surface(&geometry)
    } else {
        Shape { geometry, pose: Isometry3::identity(), color: None, collides: true, visible: true }
            .mass_properties(1.0)?
    };
    Some((solid, unit))
}

fn ellipsoid(radii: &Vector3<f64>) -> MassProperties {
    let mass = 4.0 / 3.0 * PI * radii.product();
    let s = radii.component_mul(radii);
    let moments = Vector3::new(s.y + s.z, s.x + s.z, s.x + s.y) * (mass / 5.0);
    MassProperties { mass, center: Vector3::zeros(), inertia: Matrix3::from_diagonal(&moments) }
}

/// The surface of an ellipsoid with a density of 1 kg/m², as MuJoCo has it: its area by Thomsen's formula, spread like the
/// space between this ellipsoid and one of radii 1 µm longer.
fn ellipsoid_surface(radii: &Vector3<f64>) -> MassProperties {
    const EXPONENT: f64 = 1.6075;
    const THICKNESS: f64 = 1e-6;
    let pairs = [radii.x * radii.y, radii.y * radii.z, radii.z * radii.x];
    let mean = pairs.iter().map(|pair| pair.powf(EXPONENT)).sum::<f64>() / 3.0;
    let mass = 4.0 * PI * mean.powf(1.0 / EXPONENT);
    let (inner, outer) = (ellipsoid(radii), ellipsoid(&radii.add_scalar(THICKNESS)));
    let inertia = (outer.inertia - inner.inertia) * (mass / (outer.mass - inner.mass));
    MassProperties { mass, center: Vector3::zeros(), inertia }
}

/// The surface of a solid with a density of 1 kg/m².
fn surface(geometry: &Geometry) -> MassProperties {
    let (mass, moments) = match *geometry {
        Geometry::Sphere(r) => {
            let mass = 4.0 * PI * r * r;
            (mass, Vector3::repeat(2.0 / 3.0 * mass * r * r))
        }
        Geometry::Cylinder { radius: r, length: l } => {
            let (wall, lids) = (2.0 * PI * r * l, 2.0 * PI * r * r);
            let along = wall * r * r + lids * r * r / 2.0;
            let across = wall * (r * r / 2.0 + l * l / 12.0) + lids * (r * r / 4.0 + l * l / 4.0);
            (wall + lids, Vector3::new(across, across, along))
        }
        Geometry::Capsule { radius: r, length: l } => {
            let (wall, ends) = (2.0 * PI * r * l, 4.0 * PI * r * r);
            let along = wall * r * r + 2.0 / 3.0 * ends * r * r;
            // Half spheres: 2/3 r² about their middle point, whose centroid is r/2 beyond it.
            let across = wall * (r * r / 2.0 + l * l / 12.0) + ends * (2.0 / 3.0 * r * r + l * l / 4.0 + l * r / 2.0);
            (wall + ends, Vector3::new(across, across, along))
        }
        Geometry::Box(edges) => {
            let [a, b, c] = [edges.x, edges.y, edges.z];
            let faces = [2.0 * b * c, 2.0 * a * c, 2.0 * a * b];
            // A pair of faces across each axis: a rectangle about its middle, moved out by half an edge.
            let squares = [a * a, b * b, c * c];
            let spread = |axis: usize| {
                (0..3)
                    .map(|face| faces[face] * squares[axis] * if face == axis { 0.25 } else { 1.0 / 12.0 })
                    .sum::<f64>()
            };
            let [x, y, z] = [spread(0), spread(1), spread(2)];
            (faces.iter().sum(), Vector3::new(y + z, x + z, x + y))
        }
        Geometry::Plane(_) | Geometry::Mesh { .. } => (0.0, Vector3::zeros()),
    };
    MassProperties { mass, center: Vector3::zeros(), inertia: Matrix3::from_diagonal(&moments) }
}

/// `rgba`, or the colour of the material.
fn color(settled: &Settled<'_>, assets: &Assets) -> Option<[f64; 4]> {
    let material = settled.text("material").and_then(|name| assets.colors.get(name).copied());
    let given = settled.vector::<4>("rgba").map(|color| color.map(|part| part.clamp(0.0, 1.0)));
    given.or(material)
}
