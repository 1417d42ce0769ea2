//! Where every named body is and how it moves, by walking from the ground to it each time it is asked for.

use nalgebra::{Matrix3, Quaternion, Rotation3, Unit, UnitQuaternion, Vector3};
use stillpoint::model::description::{Attachment, Description, GROUND, HingeDescription, HingeKind, Point};

/// A body at one instant, inertial axes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Placed {
    /// `world_from_body`.
    pub(crate) turn: Matrix3<f64>,
    /// Root marker.
    pub(crate) position: Vector3<f64>,
    /// Centre of mass.
    pub(crate) center: Vector3<f64>,
    /// Of the root marker.
    pub(crate) velocity: Vector3<f64>,
    /// Angular velocity.
    pub(crate) spin: Vector3<f64>,
}

impl Placed {
    pub(crate) const GROUND: Self = Self {
        turn: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        position: Vector3::new(0.0, 0.0, 0.0),
        center: Vector3::new(0.0, 0.0, 0.0),
        velocity: Vector3::new(0.0, 0.0, 0.0),
        spin: Vector3::new(0.0, 0.0, 0.0),
    };

    /// Velocity of the material point that is at `point`.
    pub(crate) fn velocity_at(&self, point: &Vector3<f64>) -> Vector3<f64> {
        self.velocity + self.spin.cross(&(point - self.position))
    }
}

/// The index of a named body; `None` for the ground.
pub(crate) fn named(description: &Description, name: &str) -> Option<usize> {
    (name != GROUND).then(|| description.bodies.iter().position(|body| body.name == name).expect("a known body"))
}

/// A point in the axes of the body that it is on.
pub(crate) fn point_in_body(description: &Description, body: Option<usize>, point: &Point) -> Vector3<f64> {
    match point {
        Point::At(at) => *at,
        Point::Marker(name) => {
            let markers = &description.bodies[body.expect("the ground has no markers")].markers;
            markers.iter().find(|(marker, _)| marker == name).expect("a known marker").1
        }
    }
}

/// The body of an attachment, where that body is, and where the point is.
pub(crate) fn attached(
    description: &Description,
    placed: &[Placed],
    to: &Attachment,
) -> (Option<usize>, Placed, Vector3<f64>) {
    let body = named(description, &to.body);
    let at = body.map_or(Placed::GROUND, |body| placed[body]);
    (body, at, at.position + at.turn * point_in_body(description, body, &to.point))
}

/// The hinge frame on the parent: axes, and origin.
pub(crate) fn hinge_frame(
    description: &Description,
    hinge: &HingeDescription,
    parent: &Placed,
) -> (Matrix3<f64>, Vector3<f64>) {
    let at = point_in_body(description, named(description, &hinge.parent), &hinge.at);
    (parent.turn * hinge.frame.to_rotation_matrix().into_inner(), parent.position + parent.turn * at)
}

/// Where a body is at the start of its scene.
pub(crate) fn place(description: &Description, body: Option<usize>) -> Placed {
    let Some(index) = body else { return Placed::GROUND };
    let given = &description.bodies[index];
    let parent = place(description, named(description, &given.hinge.parent));
    let (axes, origin) = hinge_frame(description, &given.hinge, &parent);
    let relative = relative(&given.hinge);
    let turn = axes * relative.turn.matrix();
    let position = origin + axes * relative.shift;
    Placed {
        turn,
        position,
        center: position + turn * given.mass.center,
        velocity: parent.velocity_at(&position) + axes * relative.slip,
        spin: parent.spin + axes * relative.spin,
    }
}

/// Of the body in its hinge frame, hinge axes.
struct Relative {
    shift: Vector3<f64>,
    turn: Rotation3<f64>,
    slip: Vector3<f64>,
    spin: Vector3<f64>,
}

fn relative(hinge: &HingeDescription) -> Relative {
    let q = position_of(hinge);
    let v = velocity_of(hinge);
    let mut shift = Vector3::zeros();
    let mut turn = Rotation3::identity();
    let mut slip = Vector3::zeros();
    let mut spin = Vector3::zeros();
    match &hinge.kind {
        HingeKind::Fixed => {}
        HingeKind::Revolute { axis } => {
            turn = about(axis, q[0]);
            spin = axis.normalize() * v[0];
        }
        HingeKind::Prismatic { axis } => {
            shift = axis.normalize() * q[0];
            slip = axis.normalize() * v[0];
        }
        HingeKind::Screw { axis, pitch } => {
            let n = axis.normalize();
            (shift, slip) = (n * (pitch * q[0]), n * (pitch * v[0]));
            (turn, spin) = (about(axis, q[0]), n * v[0]);
        }
        HingeKind::Cylindrical { axis } => {
            shift = axis.normalize() * q[0];
            slip = axis.normalize() * v[0];
            turn = about(axis, q[1]);
            spin = axis.normalize() * v[1];
        }
        HingeKind::Universal { axes: [first, second] } => {
            turn = about(first, q[0]) * about(second, q[1]);
            spin = first.normalize() * v[0] + about(first, q[0]) * second.normalize() * v[1];
        }
        HingeKind::Along { .. } => unreachable!("`guides` has an oracle of its own"),
        HingeKind::Planar => {
            shift = Vector3::new(q[0], q[1], 0.0);
            slip = Vector3::new(v[0], v[1], 0.0);
            turn = about(&Vector3::z(), q[2]);
            spin = Vector3::z() * v[2];
        }
        HingeKind::Spherical => {
            turn = quaternion(&q).to_rotation_matrix();
            spin = turn * Vector3::new(v[0], v[1], v[2]);
        }
        HingeKind::Free => {
            shift = Vector3::new(q[0], q[1], q[2]);
            slip = Vector3::new(v[0], v[1], v[2]);
            turn = quaternion(&q[3..]).to_rotation_matrix();
            spin = turn * Vector3::new(v[3], v[4], v[5]);
        }
    }
    Relative { shift, turn, slip, spin }
}

/// Coordinates with the defaults filled in.
pub(crate) fn position_of(hinge: &HingeDescription) -> Vec<f64> {
    filled(&hinge.position, &hinge.kind)
}

/// Rest coordinates with the defaults filled in.
pub(crate) fn rest_of(hinge: &HingeDescription) -> Vec<f64> {
    filled(&hinge.rest, &hinge.kind)
}

fn filled(list: &[f64], kind: &HingeKind) -> Vec<f64> {
    if !list.is_empty() {
        return list.to_vec();
    }
    match kind {
        HingeKind::Spherical => vec![1.0, 0.0, 0.0, 0.0],
        HingeKind::Free => vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        plain => vec![0.0; plain.counts().0],
    }
}

/// Velocities with the defaults filled in.
pub(crate) fn velocity_of(hinge: &HingeDescription) -> Vec<f64> {
    if hinge.velocity.is_empty() { vec![0.0; hinge.kind.counts().1] } else { hinge.velocity.clone() }
}

/// The unit quaternion of w, x, y, z.
pub(crate) fn quaternion(list: &[f64]) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::new(list[0], list[1], list[2], list[3]))
}

fn about(axis: &Vector3<f64>, angle: f64) -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Unit::new_normalize(*axis), angle)
}
