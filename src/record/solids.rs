//! What is drawn for each body: its own shapes, or a stand-in.

use super::Scene;
use super::form::along;
pub(super) use super::form::{Form, Solid};
use super::scene::{BodyPicture, ShapePicture};
use super::stems::{held_at, stems};
use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, SymmetricEigen, Translation3, UnitQuaternion, Vector3};
use std::path::Path;

/// Quiet colours that can be distinguished on dark and on light ground.
const PALETTE: [[f64; 3]; 8] = [
    [0.42, 0.60, 0.78],
    [0.87, 0.62, 0.36],
    [0.50, 0.70, 0.52],
    [0.80, 0.48, 0.46],
    [0.62, 0.55, 0.76],
    [0.76, 0.68, 0.45],
    [0.46, 0.71, 0.73],
    [0.80, 0.58, 0.70],
];

/// Colour number `index`, repeating.
pub(super) fn palette(index: usize) -> [f64; 4] {
    let [r, g, b] = PALETTE[index % PALETTE.len()];
    [r, g, b, 1.0]
}

/// The solids of every body: the scenario's shapes, with stems to where the body is held; failing those (or where a mesh file cannot be read) rods from the
/// root marker to the other markers and to where the next bodies hang; failing those a box of the body's inertia, on a rod if it is off the hinge.
pub(super) fn solids(scene: &Scene) -> Vec<Vec<Solid>> {
    let mut points: Vec<Vec<[f64; 3]>> =
        scene.bodies.iter().map(|body| body.markers.iter().map(|(_, at)| *at).collect()).collect();
    for body in &scene.bodies {
        if let Some(points) = body.parent.and_then(|parent| points.get_mut(parent))
            && !points.contains(&body.hinge_at)
        {
            points.push(body.hinge_at);
        }
    }
    let longest = points.iter().flatten().map(|&end| Vector3::from(end).norm()).sum();
    let held = held_at(scene);
    let of_body = |(index, (body, points)): (usize, (&BodyPicture, &Vec<[f64; 3]>))| {
        let color = palette(index);
        let mut shapes: Vec<Solid> = body.shapes.iter().filter_map(|shape| from_shape(shape, color)).collect();
        if shapes.is_empty() {
            return stand_in(body, points, longest, color);
        }
        let stems = stems(body, &shapes, &held[index]);
        shapes.extend(stems);
        shapes
    };
    scene.bodies.iter().zip(&points).enumerate().map(of_body).collect()
}

/// Takes out what stands for the bodies of beams, whose surfaces are drawn.
pub(super) fn drop_of_beams(scene: &Scene, solids: &mut [Vec<Solid>]) {
    for beam in &scene.beams {
        for body in beam.elements.iter().map(|element| element.body).chain([beam.begin]) {
            solids[body].clear();
        }
    }
}

fn from_shape(shape: &ShapePicture, color: [f64; 4]) -> Option<Solid> {
    let form = match (shape.kind.as_str(), shape.size.as_slice()) {
        ("box" | "plane", &[x, y, z]) => Form::Box([x, y, z]),
        ("sphere", &[radius]) => Form::Ball(radius),
        ("cylinder", &[radius, length]) => Form::Cylinder { radius, length },
        ("capsule", &[radius, length]) => Form::Capsule { radius, length },
        ("mesh", &[x, y, z]) => mesh(shape.file.as_deref()?, [x, y, z])?,
        ("mesh", &[scale]) => mesh(shape.file.as_deref()?, [scale; 3])?,
        _ => return None,
    };
    let [w, x, y, z] = shape.quaternion;
    let turn = UnitQuaternion::try_new(Quaternion::new(w, x, y, z), 0.0).unwrap_or_default();
    let pose = Isometry3::from_parts(Translation3::from(shape.position), turn);
    Some(Solid {
        form,
        pose,
        color: shape.color.unwrap_or(color),
        own_color: shape.color.is_some(),
        unbounded: shape.kind == "plane",
    })
}

fn mesh(file: &str, scale: [f64; 3]) -> Option<Form> {
    let path = Path::new(file);
    let media_type = match path.extension()?.to_str()?.to_ascii_lowercase().as_str() {
        "glb" => "model/gltf-binary",
        "gltf" => "model/gltf+json",
        "obj" => "model/obj",
        "stl" => "model/stl",
        "dae" => "model/vnd.collada+xml",
        _ => return None,
    };
    Some(Form::Mesh { file: file.to_owned(), contents: contents(path)?, media_type, scale })
}

/// `longest` is the length of all stand-ins in a row.
fn stand_in(body: &BodyPicture, points: &[[f64; 3]], longest: f64, color: [f64; 4]) -> Vec<Solid> {
    let solid = |form, pose| Solid { form, pose, color, own_color: false, unbounded: false };
    let rods: Vec<Solid> =
        points.iter().filter_map(|&end| rod(end.into(), longest)).map(|(form, pose)| solid(form, pose)).collect();
    if !rods.is_empty() {
        return rods;
    }
    let center = Translation3::from(body.center);
    let (edges, turn) = inertia_box(body);
    let is_box = edges.iter().all(|edge| *edge > 0.0);
    let (form, half) = match is_box {
        true => (Form::Box(edges.into()), 0.5 * edges),
        false => (Form::Ball(POINT), Vector3::repeat(POINT)),
    };
    let away = turn.inverse() * center.vector;
    let reaches = away.iter().zip(half.iter()).all(|(away, half)| away.abs() <= (1.0 + NEAR) * half);
    // Nothing holds a free body at its root marker.
    let is_held = body.mass > 0.0 && body.hinge != "free";
    let arm = if is_held && !reaches { rod(center.vector, longest) } else { None };
    let arm = arm.map(|(form, pose)| solid(form, pose));
    std::iter::once(solid(form, Isometry3::from_parts(center, turn))).chain(arm).collect()
}

/// A stand-in that is as near to the hinge as this part of its half thickness is not seen to be off it.
const NEAR: f64 = 0.25;

/// Radius of a body that has a mass but no size (m).
const POINT: f64 = 0.03;
/// Thickness of stand-ins against their length.
const SLENDER: f64 = 0.03;

/// A capsule from the root marker to `end`; `None` if they are the same point. Links of a long chain are stouter, to
/// be seen at all.
fn rod(end: Vector3<f64>, longest: f64) -> Option<(Form, Isometry3<f64>)> {
    let length = end.norm();
    let radius = (0.003 * longest).clamp(SLENDER * length, 0.2 * length);
    Some((Form::Capsule { radius, length }, along(Vector3::zeros(), end)?))
}

/// Edges and orientation of the homogeneous box that has the body's mass and inertia. With principal moments A, B, C
/// and mass m its edges are `a² = 6 (B + C − A) / m` and so on, none thinner than a fraction of the longest; zero for
/// a body without mass or without inertia.
fn inertia_box(body: &BodyPicture) -> (Vector3<f64>, UnitQuaternion<f64>) {
    let [xx, yy, zz, xy, xz, yz] = body.inertia;
    let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
    if !(body.mass > 0.0 && inertia.iter().all(|entry| entry.is_finite())) {
        return (Vector3::zeros(), UnitQuaternion::identity());
    }
    let principal = SymmetricEigen::new(inertia);
    let moments = principal.eigenvalues;
    let edges = moments.map(|moment| (6.0 * (moments.sum() - 2.0 * moment) / body.mass).max(0.0).sqrt());
    let mut axes = principal.eigenvectors;
    if axes.determinant() < 0.0 {
        axes.neg_mut();
    }
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    let thinnest = SLENDER * edges.max();
    (edges.map(|edge| edge.max(thinnest)), turn)
}

/// The bytes of a mesh file; without the readers of meshes there is no budget to hold them to.
fn contents(path: &std::path::Path) -> Option<Vec<u8>> {
    #[cfg(feature = "import")]
    return crate::mesh::contents(path).ok();
    #[cfg(not(feature = "import"))]
    return std::fs::read(path).ok();
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body() -> BodyPicture {
        BodyPicture {
            name: "body".into(),
            parent: None,
            mass: 2.0,
            center: [0.0, 0.0, 1.0],
            inertia: [0.0; 6],
            markers: Vec::new(),
            shapes: Vec::new(),
            hinge: "free".into(),
            hinge_axes: Vec::new(),
            hinge_at: [0.0; 3],
            own_axes: Vec::new(),
        }
    }

    fn drawn(body: BodyPicture) -> Vec<Solid> {
        solids(&Scene { bodies: vec![body], ..Scene::default() }).remove(0)
    }

    #[test]
    fn a_body_without_shapes_is_drawn_as_the_box_of_its_inertia() {
        // A homogeneous box of 0.2 × 0.3 × 0.6 m and 2 kg.
        let square = |a: f64, b: f64| 2.0 * (a * a + b * b) / 12.0;
        let inertia = [square(0.3, 0.6), square(0.2, 0.6), square(0.2, 0.3), 0.0, 0.0, 0.0];
        let solids = drawn(BodyPicture { inertia, ..body() });
        let Form::Box(edges) = solids[0].form else { panic!("{:?}", solids[0].form) };
        let turned = solids[0].pose.rotation * Vector3::from(edges);
        // Eigenvalues of a 3 × 3 matrix: a few roundings.
        assert!((turned.abs() - Vector3::new(0.2, 0.3, 0.6)).norm() < 1e-12, "{turned}");
        assert_eq!(solids[0].pose.translation.vector, Vector3::new(0.0, 0.0, 1.0));
    }

    #[test]
    fn a_rod_leads_to_every_marker_in_every_direction() {
        for end in [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0], [1.0, 2.0, 2.0]] {
            let solids = drawn(BodyPicture { markers: vec![("tip".into(), end)], ..body() });
            let Form::Capsule { length, .. } = solids[0].form else { panic!("{:?}", solids[0].form) };
            let tip = solids[0].pose * nalgebra::Point3::new(0.0, 0.0, 0.5 * length);
            assert!((tip.coords - Vector3::from(end)).norm() < 1e-12, "{tip} is not {end:?}");
        }
    }

    /// A homogeneous rod reaches its hinge; a bob of the same mass at its middle does not.
    #[test]
    fn what_is_off_its_hinge_hangs_on_a_rod() {
        let hung = |moment: f64, kind: &str| {
            let inertia = [moment, moment, 1e-6, 0.0, 0.0, 0.0];
            drawn(BodyPicture { inertia, hinge: kind.into(), ..body() })
        };
        assert_eq!(hung(2.0 * 2.0 * 2.0 / 12.0, "revolute").len(), 1);
        for kind in ["revolute", "prismatic", "fixed"] {
            let Form::Capsule { length, .. } = hung(1e-3, kind)[1].form else { panic!("no rod: {kind}") };
            assert!((length - 1.0).abs() < 1e-12, "{length}");
        }
        assert_eq!(hung(1e-3, "free").len(), 1);
    }

    #[test]
    fn a_point_mass_is_a_ball_and_a_missing_mesh_a_stand_in() {
        let missing = ShapePicture {
            kind: "mesh".into(),
            size: vec![1.0],
            file: Some("no such file.stl".into()),
            position: [0.0; 3],
            quaternion: [1.0, 0.0, 0.0, 0.0],
            color: None,
        };
        assert_eq!(drawn(body())[0].form, Form::Ball(POINT));
        assert_eq!(drawn(BodyPicture { shapes: vec![missing], ..body() })[0].form, Form::Ball(POINT));
    }
}
