//! What joins the shapes of a body to the points where something holds it: a shape is often less than the body, as the bob of a pendulum
//! or the disc of a top.
//!
//! A stem goes from the point straight to the nearest place of the body's shapes. Points that are within a shape or all but touch one need
//! none, nor do revolute hinges whose axis goes through a shape: a ring is held where the axis meets it.

use super::Scene;
use super::form::{Form, Solid, along};
use super::scene::BodyPicture;
use nalgebra::{Point3, Unit, Vector3};

/// A point that is as near to a shape as this part of the shape's half thickness needs no stem; a stem is no thicker.
const NEAR: f64 = 0.25;
/// The thickest stem against its length.
const SLENDER: f64 = 0.06;
/// The place of an axis that is nearest to a shape is sought with as many steps, each of which leaves two thirds: to 1e-10 of its length.
const STEPS: usize = 60;

/// Where a body is held, body axes (m).
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Held {
    at: Point3<f64>,
    /// The axis of a revolute hinge.
    axis: Option<Unit<Vector3<f64>>>,
}

/// Where hinges and lines hold every body. Hinges that let a body leave its root marker, or leave a point of its own for another, hold it
/// nowhere.
pub(super) fn held_at(scene: &Scene) -> Vec<Vec<Held>> {
    let mut places: Vec<Vec<Held>> = vec![Vec::new(); scene.bodies.len()];
    let mut add = |body: Option<usize>, at: [f64; 3], axis: Option<&[f64; 3]>| {
        let held = Held { at: at.into(), axis: axis.and_then(|axis| Unit::try_new((*axis).into(), 0.0)) };
        if let Some(places) = body.and_then(|body| places.get_mut(body)).filter(|places| !places.contains(&held)) {
            places.push(held);
        }
    };
    for (index, body) in scene.bodies.iter().enumerate() {
        let axes = [&body.own_axes, &body.hinge_axes];
        let [own, parents] = axes.map(|axes| axes.first().filter(|_| body.hinge == "revolute"));
        if matches!(body.hinge.as_str(), "revolute" | "universal" | "spherical") {
            add(Some(index), [0.0; 3], own);
            add(body.parent, body.hinge_at, parents);
        }
    }
    scene.ends().for_each(|(body, at)| add(*body, *at, None));
    places
}

/// The stems of a body from where it is held to its shapes; none of a body with a plane, or with a mesh, of which nobody knows how far it
/// reaches.
pub(super) fn stems(body: &BodyPicture, shapes: &[Solid], held: &[Held]) -> Vec<Solid> {
    let is_known = |shape: &Solid| !(shape.unbounded || matches!(shape.form, Form::Mesh { .. }));
    if shapes.len() < body.shapes.len() || !shapes.iter().all(is_known) {
        return Vec::new();
    }
    let stem = |held: &Held| {
        let ways = shapes.iter().filter_map(|shape| Some((shape, nearest(shape, &held.at)? - held.at)));
        let (shape, way) = ways.min_by(|a, b| a.1.norm().total_cmp(&b.1.norm()))?;
        let is_near = |shape: &Solid, away: f64| away <= NEAR * thinnest(&shape.form);
        let meets = |axis: Unit<Vector3<f64>>| shapes.iter().any(|shape| is_near(shape, apart(shape, &held.at, &axis)));
        if is_near(shape, way.norm()) || held.axis.is_some_and(meets) {
            return None;
        }
        let radius = (NEAR * thinnest(&shape.form)).min(SLENDER * way.norm());
        let form = Form::Capsule { radius, length: way.norm() };
        Some(Solid { form, pose: along(held.at.coords, way)?, unbounded: false, ..shape.clone() })
    };
    held.iter().filter_map(stem).collect()
}

/// How far an axis passes a solid (m): by a search in three parts, as the distance from a convex form is a convex function along a line.
fn apart(solid: &Solid, at: &Point3<f64>, axis: &Unit<Vector3<f64>>) -> f64 {
    let away = |t: f64| {
        let place = at + t * axis.as_ref();
        nearest(solid, &place).map_or(f64::INFINITY, |near| (near - place).norm())
    };
    // The nearest place of the axis is the foot of a place of the solid.
    let reach = (solid.pose.translation.vector - at.coords).norm() + furthest(&solid.form);
    let (mut low, mut high) = (-reach, reach);
    for _ in 0..STEPS {
        let [a, b] = [low + (high - low) / 3.0, high - (high - low) / 3.0];
        if away(a) < away(b) { high = b } else { low = a }
    }
    away(0.5 * (low + high))
}

/// The place of a solid that is nearest to a point, body axes; `None` of a mesh.
fn nearest(solid: &Solid, point: &Point3<f64>) -> Option<Point3<f64>> {
    let at = solid.pose.inverse() * point;
    let about = |middle: Point3<f64>, radius: f64| {
        let away = at - middle;
        middle + if away.norm() > radius { radius * away.normalize() } else { away }
    };
    let near = match &solid.form {
        Form::Box(edges) => {
            Point3::from(at.coords.zip_map(&Vector3::from(*edges), |x, edge| x.clamp(-0.5 * edge, 0.5 * edge)))
        }
        Form::Ball(radius) => about(Point3::origin(), *radius),
        Form::Capsule { radius, length } => {
            about(Point3::new(0.0, 0.0, at.z.clamp(-0.5 * length, 0.5 * length)), *radius)
        }
        Form::Cylinder { radius, length } => {
            let across = at.coords.xy();
            let within = if across.norm() > *radius { *radius * across.normalize() } else { across };
            Point3::new(within.x, within.y, at.z.clamp(-0.5 * length, 0.5 * length))
        }
        Form::Mesh { .. } => return None,
    };
    Some(solid.pose * near)
}

/// Half of the least width of a form (m).
fn thinnest(form: &Form) -> f64 {
    match form {
        Form::Box([a, b, c]) => 0.5 * a.min(*b).min(*c),
        Form::Ball(radius) | Form::Capsule { radius, .. } => *radius,
        Form::Cylinder { radius, length } => radius.min(0.5 * length),
        Form::Mesh { .. } => 0.0,
    }
}

/// The radius of a ball about the middle of a form that holds it (m).
fn furthest(form: &Form) -> f64 {
    match form {
        Form::Box(edges) => 0.5 * Vector3::from(*edges).norm(),
        Form::Ball(radius) => *radius,
        Form::Cylinder { radius, length } => radius.hypot(0.5 * length),
        Form::Capsule { radius, length } => radius + 0.5 * length,
        Form::Mesh { .. } => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::scene::ShapePicture;
    use crate::record::solids::solids;

    fn body(kind: &str, size: &[f64], at: [f64; 3]) -> BodyPicture {
        BodyPicture {
            name: "body".into(),
            parent: None,
            mass: 1.0,
            center: [0.0; 3],
            inertia: [0.0; 6],
            markers: Vec::new(),
            shapes: vec![ShapePicture {
                kind: kind.into(),
                size: size.into(),
                file: None,
                position: at,
                quaternion: [1.0, 0.0, 0.0, 0.0],
                color: None,
            }],
            hinge: "spherical".into(),
            hinge_axes: Vec::new(),
            hinge_at: [0.0; 3],
            own_axes: Vec::new(),
        }
    }

    /// Length of the stem from the root marker; zero without one.
    fn length(body: BodyPicture) -> f64 {
        let drawn = solids(&Scene { bodies: vec![body], ..Scene::default() }).remove(0);
        match drawn.get(1).map(|solid| &solid.form) {
            Some(Form::Capsule { length, .. }) => *length,
            other => other.map_or(0.0, |other| panic!("{other:?}")),
        }
    }

    #[test]
    fn a_stem_is_as_long_as_the_shape_is_away() {
        for (kind, size, at, away) in [
            ("sphere", &[0.1][..], [0.0, 0.0, -1.0], 0.9),
            ("box", &[0.2, 0.2, 0.2], [0.0, 3.1, 4.1], 5.0),
            ("cylinder", &[0.1, 0.02], [0.0, 0.0, 0.11], 0.1),
            ("capsule", &[0.1, 2.0], [0.6, 0.0, 0.5], 0.5),
            ("box", &[2.0, 2.0, 2.0], [0.5, 0.5, 0.5], 0.0),
        ] {
            let found = length(body(kind, size, at));
            // Some roundings of lengths of a few metres.
            assert!((found - away).abs() < 1e-12, "{kind}: {found} in place of {away}");
        }
    }

    /// A ring of four bars turns about an axis through two of them; about one beside it it has a stem.
    #[test]
    fn an_axis_through_a_shape_needs_no_stem() {
        let ring = |axis: [f64; 3]| {
            let bars = [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]];
            let bar = |at: [f64; 3]| {
                let size = at.map(|x| if x == 0.0 { 2.0 } else { 0.1 });
                body("box", &[size[0], 0.1, size[2]], at).shapes.remove(0)
            };
            let held =
                BodyPicture { hinge: "revolute".into(), own_axes: vec![axis], ..body("sphere", &[0.1], [0.0; 3]) };
            let shapes = bars.map(bar).into();
            solids(&Scene { bodies: vec![BodyPicture { shapes, ..held }], ..Scene::default() }).remove(0).len()
        };
        assert_eq!(ring([0.0, 0.0, 1.0]), 4);
        assert_eq!(ring([1.0, 0.0, 0.0]), 4);
        assert_eq!(ring([0.0, 1.0, 0.0]), 5);
    }

    #[test]
    fn nothing_holds_a_free_body_at_its_root_marker() {
        assert_eq!(length(BodyPicture { hinge: "free".into(), ..body("sphere", &[0.1], [0.0, 0.0, -1.0]) }), 0.0);
    }
}
