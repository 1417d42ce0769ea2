//! Straight edges that lie across the end of a cylinder: both ends of the chord, where they cross its rim.
//!
//! ```text
//! (1)  w = r(φ) − p − x u,   w·u = 0,   w·t(φ) = 0        u along the edge, t along the rim: w is along n = ± u × t
//! (2)  v_b + ẏ u − v_a − ẋ t = |w| ṅ  across n,   ṫ = ω_a × t − (ẋ/r²) d      d from the axis to the point of the rim
//! ```
//!
//! With a radius about the edge `|w|` is no less than that, nearly, and the normal is its direction however rim and edge lie:
//!
//! ```text
//! (3)  ẇ = v_b + ẏ u − v_a − ẋ t,   ẇ·u + w·(ω_b × u) = 0,   ẇ·t + w·ṫ = 0,   ṅ = (ẇ − n n·ẇ)/|w|
//! ```
//!
//! The crossing begins where the edge, seen along the axis, meets the rim; Newton's method on `w·t` does the rest. A cylinder that tips over
//! the edge of a table stands on both of them.

use super::feature::{Feature, Meeting, PlacedBoundary, Rim, TILTED};
use nalgebra::Vector3;

/// Edges of a cylinder beyond its side: two ends of a chord on either face.
pub(super) const CHORDS: std::ops::Range<u16> = 1..5;
/// Steps of Newton's method.
const MOST_STEPS: usize = 12;
/// An edge that is tilted against a face by more does not lie across it (sine).
const STEEP: f64 = 0.2;
/// A crossing is where Newton's method ends near where it began (rad), with a slope that the distance has not halved.
const NEARBY: f64 = 0.3;
const SOUND: f64 = 0.5;
/// Chords shorter than this part of the radius have no ends of their own.
pub(super) const SHORT: f64 = 1e-3;

/// An end of a chord of a cylinder and an edge of a polytope; `None` of an edge along the axis.
pub(super) fn meeting(
    own: &PlacedBoundary<'_>,
    other: &PlacedBoundary<'_>,
    [chord, edge]: [u16; 2],
) -> Option<Meeting> {
    let (face, last) = (usize::from((chord - CHORDS.start) / 2), (chord - CHORDS.start) % 2 == 1);
    let radius = own.of.rim;
    let (middle, far) = (own.vertices[face], own.vertices[1 - face]);
    let outward = (middle - far).normalize();
    let [p, q] = other.ends(edge);
    let length = (q - p).norm();
    let u = (q - p) / length;
    let tilt = outward.dot(&u);
    // Seen along the axis: the chord's middle and half its length.
    let along = (u - outward * tilt).try_normalize(STEEP)?;
    let from = p - middle;
    let across = from - outward * outward.dot(&from) - along * along.dot(&from);
    let half = (radius * radius - across.norm_squared()).max(0.0).sqrt();
    let first = (across + along * if last { half } else { -half }).try_normalize(0.0)?;
    let (out, is_sound) = crossing(first, [middle, outward, p, u], radius);
    let (point, tangent) = (middle + out * radius, outward.cross(&out));
    let x = u.dot(&(point - p));
    let crossed = u.cross(&tangent).try_normalize(0.5 * SHORT).unwrap_or(outward);
    let normal = if crossed.dot(&outward) < 0.0 { -crossed } else { crossed };
    let foot = p + u * x;
    let behind = other.below(&-normal, &foot, &other.of.edges[usize::from(edge)]);
    // The normal is one of the rim: between those of the face and of the side, but for a tilt.
    let between = (normal.dot(&out) + TILTED) * radius;
    let sound = if is_sound { f64::INFINITY } else { -SHORT * radius };
    let inside = [x, length - x, counts(tilt.abs(), across.norm(), radius), behind, between, sound]
        .into_iter()
        .fold(f64::INFINITY, f64::min);
    let features = [Feature::Edge(chord), Feature::Edge(edge)];
    let found = Meeting::new(features, normal, [point, foot], [tangent, u], [0.0; 2], inside);
    Some(Meeting { rims: [Some(Rim { arm: out * radius, tangent, tilt: 0.0 }), None], ..found })
}

/// How far an edge with a tilt against the axis (its sine's absolute value) whose line passes the middle of the face at a distance (m) is one that
/// lies across it (m).
pub(super) fn counts(tilt: f64, across: f64, radius: f64) -> f64 {
    let half = (radius * radius - across * across).max(0.0).sqrt();
    let long = if half > 0.0 { half } else { radius - across } - SHORT * radius;
    long.min((STEEP - tilt) * radius)
}

/// The direction from the axis to the crossing (1) of the rim about `middle` and the line through `p` along `u`, from a `first` one; and whether
/// it is one of its own.
fn crossing(first: Vector3<f64>, [middle, outward, p, u]: [Vector3<f64>; 4], radius: f64) -> (Vector3<f64>, bool) {
    let (mut out, mut is_sound) = (first, true);
    for _ in 0..MOST_STEPS {
        let tangent = outward.cross(&out);
        let arm = middle + out * radius - p;
        let apart = arm - u * u.dot(&arm);
        let straight = radius * (1.0 - u.dot(&tangent).powi(2));
        let slope = straight - apart.dot(&out);
        is_sound = (slope - straight).abs() < SOUND * straight;
        let turn = -apart.dot(&tangent) / slope;
        if !is_sound || !(turn.abs() > f64::EPSILON) {
            break;
        }
        out = (out + tangent * turn).normalize();
        is_sound = (out - first).norm() < NEARBY;
        if !is_sound {
            break;
        }
    }
    (out, is_sound)
}

/// (2): velocities of the crossing along the rims among two edges, `bodies` those of the material points there.
pub(super) fn slides(meeting: &Meeting, bodies: [Vector3<f64>; 2], spins: [Vector3<f64>; 2]) -> [Vector3<f64>; 2] {
    if let Some((slides, _)) = about(meeting, bodies, spins) {
        return slides;
    }
    let ([u, v], n) = (meeting.edges, meeting.normal);
    let steady = turned(meeting, [spins[0].cross(&u), spins[1].cross(&v)]);
    let (slip, none) = (bodies[1] - bodies[0], Vector3::zeros());
    let apart = n.dot(&(meeting.cores[1] - meeting.cores[0]));
    // What a unit speed along either moves across n: itself, and the end of w as the normal turns with a rim.
    let moved = [0, 1].map(|i| {
        let bent = meeting.rims[i].as_ref().map_or(none, |Rim { arm, .. }| -arm / arm.norm_squared());
        let (own, by) = if i == 0 { (u, turned(meeting, [bent, none])) } else { (v, -turned(meeting, [none, bent])) };
        own + apart * by
    });
    let along = |i: usize| {
        if meeting.rims[i].is_none() {
            return none;
        }
        let (own, sign) = if i == 0 { (u, 1.0) } else { (v, -1.0) };
        let off = sign * (slip - apart * steady);
        own * (off.cross(&moved[1 - i]).dot(&n) / moved[i].cross(&moved[1 - i]).dot(&n))
    };
    [along(0), along(1)]
}

/// (3): velocities along a rim beside an edge with a radius about it, and the rate of their normal (1/s); `None` of other pairs.
pub(super) fn about(
    meeting: &Meeting,
    bodies: [Vector3<f64>; 2],
    spins: [Vector3<f64>; 2],
) -> Option<([Vector3<f64>; 2], Vector3<f64>)> {
    // The rim first, whichever body has it.
    let rim = match meeting.rims {
        [Some(_), None] => 0,
        [None, Some(_)] => 1,
        _ => return None,
    };
    let edge = 1 - rim;
    if meeting.radii[edge] == 0.0 {
        return None;
    }
    let Rim { arm, tangent, .. } = meeting.rims[rim]?;
    let (u, w, slip) = (meeting.edges[edge], meeting.cores[edge] - meeting.cores[rim], bodies[edge] - bodies[rim]);
    let along = tangent.dot(&u);
    let by_edge = slip.dot(&u) + w.dot(&spins[edge].cross(&u));
    let by_rim = slip.dot(&tangent) + w.dot(&spins[rim].cross(&tangent));
    let bent = 1.0 + w.dot(&arm) / arm.norm_squared();
    let x = (by_rim - along * by_edge) / (bent - along * along);
    let y = along * x - by_edge;
    let (moved, n) = (slip + u * y - tangent * x, meeting.normal);
    let sign = if rim == 0 { 1.0 } else { -1.0 };
    let turned = (moved - n * n.dot(&moved)) * (sign / w.norm());
    let mut slides = [Vector3::zeros(); 2];
    slides[rim] = tangent * x;
    Some((slides, turned))
}

/// How the normal of two edges turns with them (1/s).
pub(super) fn turned(meeting: &Meeting, [du, dv]: [Vector3<f64>; 2]) -> Vector3<f64> {
    let ([u, v], n) = (meeting.edges, meeting.normal);
    let crossed = u.cross(&v);
    let sign = if crossed.dot(&n) < 0.0 { -1.0 } else { 1.0 };
    let turned = sign * (du.cross(&v) + u.cross(&dv));
    (turned - n * n.dot(&turned)) / crossed.norm()
}

/// How the direction of an edge that is a rim turns beside its body, as the crossing moves along it at `slide`.
pub(super) fn bends(rim: Option<&Rim>, slide: &Vector3<f64>) -> Vector3<f64> {
    let Some(Rim { arm, tangent, .. }) = rim else { return Vector3::zeros() };
    arm * (-slide.dot(tangent) / arm.norm_squared())
}
