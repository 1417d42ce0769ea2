//! Features of cylinders: two faces, the side as an edge with a radius about it, and two rims.
//!
//! A rim (radius `r`, across the axis `a`) meets a face at its lowest point, which moves along it. With `n` the normal from the face, `σ = |a × n|`,
//! `d` from the axis to that point and the tangent `e = a × d`:
//!
//! ```text
//! (1)  gap = n·(end − face) − r σ,   d = −(n − a a·n)/σ
//! (2)  the point moves along the rim at   s = −(r/σ) (e·(ṅ − ω × n)) e
//! ```
//!
//! Against a ball at `x` the nearest point moves at `s = r φ̇ e`, with `w = x − (end + r d)`,
//!
//! ```text
//! (3)  φ̇ = (e·(ẋ − v) + (ω × e)·w) / (r + d·w),   v that of the material point of the rim
//! ```
//!
//! (2) has no limit as the disc comes to lie flat: there points that are fixed to the rim take over, as corners of a polygon. Edges that lie
//! across a disc are in [`super::chord`], rims that meet edges or each other askew in [`super::askew`].

use super::feature::{Feature, Meeting, Near, PARALLEL, PlacedBoundary, Rim, TILTED, crossing, on_edge, on_face};
use super::{askew, chord};
use nalgebra::Vector3;

/// Points that are fixed to each rim.
const CORNERS: u16 = 12;
/// A disc that is tilted by no more lies flat, for what events decide (rad).
const FLAT: f64 = 1e-6;
/// Points that are fixed to a rim are none at a larger tilt.
const STEEP: f64 = 0.2;
/// A rim that is tilted by less has no lowest point.
const NONE: f64 = 1e-9;
/// The end of a side counts as that of a line along it if it is turned against the other surface, and an edge against it, by no more (rad).
const ALONG: f64 = 1e-3;

/// Pairs of features of two solids of which one, at least, is a cylinder.
pub(super) fn pairs(a: &PlacedBoundary<'_>, b: &PlacedBoundary<'_>) -> Vec<[Feature; 2]> {
    let mut all = Vec::new();
    if a.of.rim > 0.0 {
        of_cylinder(a, b, |mine, other| all.push([mine, other]));
    }
    if b.of.rim > 0.0 {
        of_cylinder(b, a, |mine, other| {
            // Of two cylinders the pairs of both lists may be the same.
            if a.of.rim == 0.0 || !all.contains(&[other, mine]) {
                all.push([other, mine]);
            }
        });
    }
    all
}

fn of_cylinder(own: &PlacedBoundary<'_>, other: &PlacedBoundary<'_>, mut put: impl FnMut(Feature, Feature)) {
    let ends = || (0..2).map(Feature::Vertex);
    let corners = |of: &PlacedBoundary<'_>| if of.of.rim > 0.0 { 2 + 2 * CORNERS } else { of.vertices.len() as u16 };
    let vertices = |of: &PlacedBoundary<'_>| (0..corners(of)).map(Feature::Vertex);
    (0..2).for_each(|face| vertices(other).for_each(|vertex| put(Feature::Face(face), vertex)));
    other.face_list().for_each(|face| vertices(own).for_each(|vertex| put(vertex, face)));
    other.edge_list().for_each(|edge| put(Feature::Edge(0), edge));
    other.edge_list().for_each(|edge| ends().for_each(|end| put(end, edge)));
    if other.of.rim == 0.0 && other.of.radius == 0.0 {
        other.edge_list().for_each(|edge| chord::CHORDS.for_each(|chord| put(Feature::Edge(chord), edge)));
    }
    other.edge_list().for_each(|edge| askew::RIMS.for_each(|rim| put(Feature::Edge(rim), edge)));
    if other.of.rim > 0.0 {
        askew::RIMS.for_each(|rim| askew::RIMS.for_each(|against| put(Feature::Edge(rim), Feature::Edge(against))));
    } else {
        vertices(other).for_each(|vertex| put(Feature::Edge(0), vertex));
    }
    if other.of.radius > 0.0 {
        vertices(other).for_each(|vertex| ends().for_each(|end| put(end, vertex)));
    }
}

/// How two features stand to each other; `None` if they have no normal.
pub(super) fn meeting(
    a: &PlacedBoundary<'_>,
    b: &PlacedBoundary<'_>,
    [one, other]: [Feature; 2],
    near: &Near,
) -> Option<Meeting> {
    if a.of.rim > 0.0
        && let Some(found) = of(a, b, [one, other], near)
    {
        return Some(found);
    }
    if b.of.rim > 0.0 { of(b, a, [other, one], near).map(swapped) } else { None }
}

fn swapped(meeting: Meeting) -> Meeting {
    let swap = |[a, b]: [Vector3<f64>; 2]| [b, a];
    Meeting {
        features: [meeting.features[1], meeting.features[0]],
        normal: -meeting.normal,
        cores: swap(meeting.cores),
        edges: swap(meeting.edges),
        radii: [meeting.radii[1], meeting.radii[0]],
        rims: [meeting.rims[1], meeting.rims[0]],
        ..meeting
    }
}

/// A pair whose first feature is of a cylinder.
fn of(own: &PlacedBoundary<'_>, other: &PlacedBoundary<'_>, features: [Feature; 2], near: &Near) -> Option<Meeting> {
    let none = Vector3::zeros();
    let about = if other.of.rim > 0.0 { other.of.rim } else { other.of.radius };
    match features {
        [Feature::Face(face), Feature::Vertex(vertex)] => {
            let (normal, end) = (cap(own, face), own.vertices[usize::from(face)]);
            let (point, rim, flat, before) = match other.of.rim > 0.0 {
                true => corner(other, vertex, &-normal)?,
                false => {
                    let point = other.vertices[usize::from(vertex)];
                    (point, None, f64::INFINITY, other.before(&normal, vertex))
                }
            };
            let foot = point - normal * normal.dot(&(point - end));
            let inside = (own.of.rim - (foot - end).norm()).min(before);
            let found = Meeting::new(features, normal, [foot, point], [none; 2], [0.0, other.of.radius], inside);
            Some(Meeting { rims: [None, rim], flat, ..found })
        }
        [Feature::Vertex(vertex), Feature::Face(face)] if other.of.rim == 0.0 => {
            let (normal, _, _) = on_face(other, face, &own.vertices[0]);
            let (point, rim, flat, before) = corner(own, vertex, &-normal)?;
            let (_, foot, inside) = on_face(other, face, &point);
            let inside = if other.of.plane.is_some() { inside } else { inside.min(before) };
            let found = Meeting::new(features, -normal, [point, foot], [none; 2], [0.0, other.of.radius], inside);
            Some(Meeting { rims: [rim, None], flat, ..found })
        }
        [Feature::Edge(edge), Feature::Edge(against)] if chord::CHORDS.contains(&edge) => {
            chord::meeting(own, other, [edge, against])
        }
        [Feature::Edge(edge), Feature::Edge(against)] if askew::RIMS.contains(&edge) => {
            match other.of.rim > 0.0 && against > 0 {
                true => askew::with_rim(own, other, [edge, against], near),
                false => askew::with_edge(own, other, [edge, against], about, near),
            }
        }
        [Feature::Edge(0), Feature::Edge(against)] if other.of.rim == 0.0 || against == 0 => {
            crossing(own, other, [0, against], [own.of.rim, about], near)
        }
        [Feature::Edge(edge), Feature::Vertex(vertex)] if other.of.rim == 0.0 => {
            let point = other.vertices[usize::from(vertex)];
            let (foot, u, along) = on_edge(own.ends(edge), &point);
            let normal = (point - foot).try_normalize(0.0)?;
            let inside = along.min(other.below(&-normal, &point, &[usize::from(vertex)]));
            let radii = [own.of.rim, other.of.radius];
            Some(Meeting::new(features, normal, [foot, point], [u, none], radii, inside))
        }
        [Feature::Vertex(end), Feature::Edge(edge)] if end < 2 => {
            let point = own.vertices[usize::from(end)];
            let (foot, u, along) = on_edge(other.ends(edge), &point);
            let normal = (foot - point).try_normalize(0.0)?;
            // Of an edge across the axis the side meets what lies beside it, and nothing beyond its end.
            let turned = (ALONG - normal.dot(&axis(own)).abs().max(u.cross(&axis(own)).norm())) * own.of.rim;
            let behind = other.below(&-normal, &foot, &other.of.edges[usize::from(edge)]);
            let inside = along.min(turned).min(behind);
            Some(Meeting::new(features, normal, [point, foot], [none, u], [own.of.rim, about], inside))
        }
        [Feature::Vertex(end), Feature::Vertex(vertex)] if end < 2 && other.of.rim == 0.0 => {
            let (at, point) = (own.vertices[usize::from(end)], other.vertices[usize::from(vertex)]);
            let (axis, from) = (cap(own, end), point - at);
            let across = from - axis * axis.dot(&from);
            let out = across.try_normalize(NONE * own.of.rim)?;
            let nearest = at + out * own.of.rim;
            let normal = (point - nearest).try_normalize(0.0)?;
            let beyond = axis.dot(&from).min(across.norm() - own.of.rim);
            let inside = beyond.min(other.below(&-normal, &point, &[usize::from(vertex)]));
            let radii = [0.0, other.of.radius];
            let found = Meeting::new(features, normal, [nearest, point], [none; 2], radii, inside);
            Some(Meeting { rims: [Some(Rim::new(own, out, 0.0)), None], ..found })
        }
        _ => None,
    }
}

/// Unit vector along a cylinder.
fn axis(of: &PlacedBoundary<'_>) -> Vector3<f64> {
    of.pose.rotation * Vector3::z()
}

/// The outward normal of a face.
fn cap(of: &PlacedBoundary<'_>, face: u16) -> Vector3<f64> {
    if face == 0 { -axis(of) } else { axis(of) }
}

/// A point of a rim that may touch a face along a unit vector towards that: the lowest of an end (0 and 1), or one that is fixed to it. With
/// that come [`Meeting::flat`], and how far the other end is before the face.
fn corner(
    of: &PlacedBoundary<'_>,
    vertex: u16,
    towards: &Vector3<f64>,
) -> Option<(Vector3<f64>, Option<Rim>, f64, f64)> {
    let along = axis(of);
    let (low, high) = (of.vertices[0], of.vertices[1]);
    let tilt = along.cross(towards).norm();
    let (end, fixed) = if vertex < 2 { (vertex, None) } else { ((vertex - 2) / CORNERS, Some((vertex - 2) % CORNERS)) };
    let (at, other) = if end == 0 { (low, high) } else { (high, low) };
    let before = -towards.dot(&(other - at)) + TILTED * (other - at).norm();
    let Some(k) = fixed else {
        if tilt < NONE {
            return None;
        }
        let out = lowest(&along, towards)?;
        return Some((at + out * of.of.rim, Some(Rim::new(of, out, tilt)), f64::INFINITY, before));
    };
    // Of a disc that lies flat the end that faces the other surface counts.
    if tilt > STEEP || before < 0.0 {
        return None;
    }
    let angle = std::f64::consts::TAU * f64::from(k) / f64::from(CORNERS);
    let out = of.pose.rotation * Vector3::new(angle.cos(), angle.sin(), 0.0);
    Some((at + out * of.of.rim, None, (FLAT - tilt) * of.of.rim, before))
}

/// The direction across an axis that goes furthest along a unit vector `n`, by `a × (n × a)`: `n − a a·n`, which is the same, is rounding along
/// the axis where both are nearly one, and a rim stood as much higher or lower as that is in parts of its tilt.
pub(super) fn lowest(axis: &Vector3<f64>, n: &Vector3<f64>) -> Option<Vector3<f64>> {
    axis.cross(&n.cross(axis)).try_normalize(1e-300)
}

impl Rim {
    fn new(of: &PlacedBoundary<'_>, out: Vector3<f64>, tilt: f64) -> Self {
        Self { arm: out * of.of.rim, tangent: axis(of).cross(&out), tilt }
    }
}

/// (2) and (3): velocities of core points along their rims, `bodies` those of the material points there.
pub(super) fn slides(meeting: &Meeting, bodies: [Vector3<f64>; 2], spins: [Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
    if let [Feature::Edge(_), Feature::Edge(_)] = meeting.features {
        return chord::slides(meeting, bodies, spins);
    }
    [0, 1].map(|i| {
        let Some(Rim { arm, tangent, tilt }) = meeting.rims[i] else { return Vector3::zeros() };
        let radius = arm.norm();
        if tilt > 0.0 {
            let turning = (spins[1 - i] - spins[i]).cross(&meeting.normal);
            let sign = if i == 1 { -1.0 } else { 1.0 };
            return tangent * (sign * radius / tilt * tangent.dot(&turning));
        }
        let (w, slip) = (meeting.cores[1 - i] - meeting.cores[i], bodies[1 - i] - bodies[i]);
        let about = (tangent.dot(&slip) + spins[i].cross(&tangent).dot(&w)) / (radius + arm.dot(&w) / radius);
        tangent * (radius * about)
    })
}

/// Ends of edges count for all edges that are too parallel to have a normal.
const _: () = assert!(PARALLEL < ALONG);
