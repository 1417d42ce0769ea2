//! Cylinders at rest: axes that may separate them from other solids, nearest points, and the features in a tangent plane.
//!
//! A cylinder is a segment with a disc of radius `r` across it about every point, so that with `a` along it
//!
//! ```text
//! (1)  max n·x = max n·end + r |a × n|
//! ```
//!
//! Its faces, and its side against edges and corners, have normals in closed form. A rim (tangent `e(φ)`) that an edge (direction `u`)
//! touches has the normal `e(φ) × u / |e(φ) × u|` at a stationary point of the distance along it, a root in φ.

use super::askew::{self, Circle};
use super::solid::{Placed, apart};
use nalgebra::Vector3;

/// Parts of a turn in which stationary points are looked for.
const PARTS: usize = 48;
/// Halvings and secants of one root.
const MOST_STEPS: usize = 60;

/// Unit vectors from the cylinder `a` to `b` along which they may be furthest apart, beside those of faces and of pairs of edges; none if
/// `a` is no cylinder.
pub(super) fn axes(a: &Placed, b: &Placed) -> Vec<Vector3<f64>> {
    if a.rim == 0.0 || b.plane.is_some() {
        return Vec::new();
    }
    let along = a.edges[0];
    let mut found: Vec<Vector3<f64>> = Vec::new();
    for corner in &b.vertices {
        let from = corner - a.vertices[0];
        found.extend((from - along * along.dot(&from)).try_normalize(0.0));
    }
    if b.rim > 0.0 {
        found.extend(askew::axes(&circles(a), &circles(b)));
        return found;
    }
    for edge in &b.edges {
        found.extend(on_rim(a, b, &along, edge));
    }
    found
}

/// The rims of a cylinder, their axes outwards.
fn circles(core: &Placed) -> [Circle; 2] {
    [0, 1].map(|end| {
        let axis = (core.vertices[end] - core.vertices[1 - end]).normalize();
        Circle { middle: core.vertices[end], axis, radius: core.rim }
    })
}

/// Normals of eq. (1) of stationary distance between a rim and an edge.
fn on_rim(a: &Placed, b: &Placed, along: &Vector3<f64>, edge: &Vector3<f64>) -> Vec<Vector3<f64>> {
    let [first, second] = super::tangents(along);
    let normal = |angle: f64| {
        let tangent = second * angle.cos() - first * angle.sin();
        let n = tangent.cross(edge).try_normalize(1e-9)?;
        // Outwards, as seen from the axis.
        let out = first * angle.cos() + second * angle.sin();
        Some(if n.dot(&out) < 0.0 { -n } else { n })
    };
    let slope = |angle: f64| {
        let (n, size) = (normal(angle)?, 1e-6);
        let (more, less) = (normal(angle + size)?, normal(angle - size)?);
        let (from, to) = (furthest(a, &n), furthest(b, &-n));
        Some((more - less).dot(&(to - from)) / (2.0 * size))
    };
    let step = std::f64::consts::TAU / PARTS as f64;
    let mut found = Vec::new();
    let mut ahead = slope(0.0);
    for k in 0..PARTS {
        let (mut left, mut right) = (k as f64 * step, (k + 1) as f64 * step);
        let behind = std::mem::replace(&mut ahead, slope(right));
        let (Some(mut l), Some(mut r)) = (behind, ahead) else { continue };
        // A maximum of the distance.
        if !(l > 0.0 && r <= 0.0) {
            continue;
        }
        for _ in 0..MOST_STEPS {
            if r == 0.0 || (right - left).abs() < 1e-15 {
                break;
            }
            let middle = right - r * (right - left) / (r - l);
            let Some(at) = slope(middle) else { break };
            if at * r < 0.0 {
                (left, l) = (right, r);
            } else {
                l *= 0.5;
            }
            (right, r) = (middle, at);
        }
        found.extend(normal(right));
    }
    found.retain(|n| apart(a, b, n).is_finite());
    found
}

/// The point of a core that is furthest along a unit vector.
fn furthest(core: &Placed, n: &Vector3<f64>) -> Vector3<f64> {
    let best = core.vertices.iter().max_by(|a, b| n.dot(a).total_cmp(&n.dot(b))).copied().unwrap_or_default();
    if core.rim == 0.0 { best } else { best + outward(core, n) * core.rim }
}

/// The direction across the axis along which a rim is furthest along `n`; zero if they are all equal.
fn outward(core: &Placed, n: &Vector3<f64>) -> Vector3<f64> {
    super::rim::lowest(&core.edges[0], n).unwrap_or_else(Vector3::zeros)
}

/// Nearest points of a point or segment `a` and a cylinder `b`: the distance is convex along the segment.
pub(super) fn nearest(a: &Placed, b: &Placed) -> (Vector3<f64>, Vector3<f64>) {
    let from = a.vertices[0];
    let Some(way) = a.vertices.get(1).map(|to| to - from) else { return (from, within(b, &from)) };
    let slope = |t: f64| {
        let point = from + way * t;
        way.dot(&(point - within(b, &point)))
    };
    let (mut left, mut right) = (0.0, 1.0);
    if slope(left) >= 0.0 {
        right = left;
    } else if slope(right) <= 0.0 {
        left = right;
    }
    while right - left > 1e-16 {
        let middle = 0.5 * (left + right);
        if middle <= left || middle >= right {
            break;
        }
        if slope(middle) < 0.0 {
            left = middle;
        } else {
            right = middle;
        }
    }
    let point = from + way * right;
    (point, within(b, &point))
}

/// The point of a cylinder that is nearest to one.
fn within(core: &Placed, point: &Vector3<f64>) -> Vector3<f64> {
    let (along, low) = (core.edges[0], core.vertices[0]);
    let length = (core.vertices[1] - low).norm();
    let from = point - low;
    let height = along.dot(&from);
    let out = from - along * height;
    let far = out.norm();
    let out = if far > core.rim { out * (core.rim / far) } else { out };
    low + along * height.clamp(0.0, length) + out
}

/// The middle of the disc that is furthest along `n`, if one is, to `slack` (m).
pub(super) fn disc(core: &Placed, n: &Vector3<f64>, slack: f64) -> Option<Vector3<f64>> {
    let flat = core.rim > 0.0 && 2.0 * core.rim * core.edges[0].cross(n).norm() <= slack;
    let furthest = core.vertices.iter().max_by(|a, b| n.dot(a).total_cmp(&n.dot(b)));
    furthest.filter(|_| flat).copied()
}

/// The features of a cylinder that does not lie flat across `n` which are furthest along it, to `slack` (m): a line along its side, or one
/// point of a rim.
pub(super) fn lowest(core: &Placed, n: &Vector3<f64>, slack: f64) -> Vec<Vector3<f64>> {
    let heights: Vec<f64> = core.vertices.iter().map(|end| n.dot(end)).collect();
    let most = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let ends = core.vertices.iter().zip(&heights).filter(|(_, height)| **height >= most - slack).map(|(end, _)| *end);
    let out = outward(core, n) * core.rim;
    ends.map(|end| end + out).collect()
}
