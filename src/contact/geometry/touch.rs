//! Gap, normal and points of two solids.

use super::cylinder;
use super::disc::{Arcs, Disc};
use super::polygon::{Point, common, hull};
use super::solid::{Placed, apart};
use nalgebra::Vector3;
use std::f64::consts::TAU;

/// How two solids touch.
#[derive(Debug, Clone, PartialEq)]
pub struct Touch {
    /// Eq. (1) (m): negative if they overlap.
    pub gap: f64,
    /// From the first to the second, inertial axes.
    pub normal: Vector3<f64>,
    /// Corners of the region of contact, halfway between both surfaces (m), and some points of each rim.
    pub points: Vec<Vector3<f64>>,
    /// Rims of discs on which it ends.
    pub rims: Vec<RimArcs>,
}

/// Arcs of a circle that bound a region of contact.
#[derive(Debug, Clone, PartialEq)]
pub struct RimArcs {
    /// (m)
    pub middle: Vector3<f64>,
    /// To where its angle is 0 and a quarter of a turn (m), across each other.
    pub arms: [Vector3<f64>; 2],
    /// From an angle to a larger one (rad).
    pub arcs: Vec<[f64; 2]>,
}

impl RimArcs {
    /// Its point at an angle (rad).
    pub fn at(&self, angle: f64) -> Vector3<f64> {
        self.middle + self.arms[0] * angle.cos() + self.arms[1] * angle.sin()
    }

    /// Angles that stand for it at first: the ends of its arcs, and between them those of an octagon with corners on the tangents.
    pub fn corners(&self) -> Vec<f64> {
        let mut found = Vec::new();
        for [from, to] in &self.arcs {
            let is_whole = *to >= *from + TAU;
            let eighth = TAU / 8.0;
            let between = (0..16).map(|k| k as f64 * eighth).filter(|angle| {
                if is_whole { *angle < TAU } else { (from + 0.1 * eighth..to - 0.1 * eighth).contains(angle) }
            });
            found.extend(between);
            if !is_whole {
                found.extend([*from, *to]);
            }
        }
        found
    }
}

/// Solids whose contact has no normal: two points in one place, two segments on one line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("a point or an edge without a radius lies on another: their contact has no normal")]
pub struct NoNormal;

/// Separations that differ by this part of the slack are equally good.
const EQUAL: f64 = 1e-3;

/// How two solids touch; `None` if they are further apart than `slack` (m), which is also how far features may stand off the
/// common tangent plane.
///
/// # Errors
/// [`NoNormal`].
pub fn touch(a: &Placed, b: &Placed, slack: f64) -> Result<Option<Touch>, NoNormal> {
    if let Some(normal) = a.plane {
        return Ok(if b.plane.is_some() { None } else { from_plane(&normal, a, b, slack) });
    }
    if let Some(normal) = b.plane {
        return Ok(from_plane(&normal, b, a, slack).map(|touch| Touch { normal: -touch.normal, ..touch }));
    }
    let Some(normal) = normal(a, b, slack)? else { return Ok(None) };
    Ok(region(&normal, a, b, slack))
}

/// What rests on a plane: all of its own features count.
fn from_plane(normal: &Vector3<f64>, plane: &Placed, b: &Placed, slack: f64) -> Option<Touch> {
    let level = normal.dot(&plane.vertices[0]);
    let gap = -b.support(&-normal) - b.radius - level;
    if gap > slack {
        return None;
    }
    let frame = Frame::new(normal);
    let height = level + 0.5 * gap;
    let (corners, rims) = match frame.disc(b, -1.0, slack) {
        Some(disc) => (Vec::new(), vec![frame.rim(&disc, vec![[0.0, TAU]], height)]),
        None => (hull(&frame.lowest(b, -1.0, slack), slack), Vec::new()),
    };
    Some(Touch { gap, normal: *normal, points: frame.points(&corners, &rims, height, slack), rims })
}

/// The normal from `a` to `b` if their surfaces are not surely further apart than the slack.
fn normal(a: &Placed, b: &Placed, slack: f64) -> Result<Option<Vector3<f64>>, NoNormal> {
    if let Some((apart, normal)) = axes(a, b, slack) {
        let faces = [a, b].map(|core| !core.normals.is_empty());
        // Between polytopes, and if a point or a segment is on or in one, these axes are all that count.
        let all = faces == [true, true] || faces != [false, false] && apart <= slack;
        if all || apart - a.radius - b.radius > slack {
            return Ok((apart - a.radius - b.radius <= slack).then_some(normal));
        }
    }
    let (from, to) = nearest(a, b);
    let between = to - from;
    let far = between.norm();
    if far - a.radius - b.radius > slack {
        return Ok(None);
    }
    // A core that lies on the other, or in it, has the normal of the axes.
    if far > slack {
        return Ok(Some(between / far));
    }
    axes(a, b, slack).map(|(_, normal)| Some(normal)).ok_or(NoNormal)
}

/// The axis of largest separation of two cores and how far they are apart along it; `None` if they have no axis.
fn axes(a: &Placed, b: &Placed, slack: f64) -> Option<(f64, Vector3<f64>)> {
    let crossed = a.edges.iter().flat_map(|one| b.edges.iter().map(move |other| one.cross(other)));
    let crossed = crossed.filter_map(|axis| axis.try_normalize(1e-6)).flat_map(|axis| [axis, -axis]);
    let all = a.normals.iter().copied().chain(b.normals.iter().map(|n| -n)).chain(crossed);
    let mut measured: Vec<(f64, Vector3<f64>)> = all.map(|n| (apart(a, b, &n), n)).collect();
    for normal in cylinder::axes(a, b).into_iter().chain(cylinder::axes(b, a).into_iter().map(|n| -n)) {
        measured.push((apart(a, b, &normal), normal));
    }
    let best = measured.iter().map(|(apart, _)| *apart).max_by(f64::total_cmp)?;
    let good = measured.iter().filter(|(apart, _)| *apart >= best - EQUAL * slack);
    let mut sum = Vector3::zeros();
    let mut taken: Vec<Vector3<f64>> = Vec::new();
    for (_, n) in good {
        // Faces that lie on each other have one normal, not two.
        if !taken.iter().any(|known| known.dot(n) > 1.0 - 1e-12) {
            taken.push(*n);
            sum += n;
        }
    }
    Some((best, sum.try_normalize(1e-9).unwrap_or(taken[0])))
}

/// Nearest points of two cores of which one is a point or a segment.
fn nearest(a: &Placed, b: &Placed) -> (Vector3<f64>, Vector3<f64>) {
    if b.rim > 0.0 {
        return cylinder::nearest(a, b);
    }
    if a.rim > 0.0 {
        let (to, from) = cylinder::nearest(b, a);
        return (from, to);
    }
    let mut best = (f64::INFINITY, Vector3::zeros(), Vector3::zeros());
    let mut take = |from: Vector3<f64>, to: Vector3<f64>| {
        let far = (to - from).norm_squared();
        if far < best.0 {
            best = (far, from, to);
        }
    };
    let sides = |core: &Placed| -> Vec<[Vector3<f64>; 2]> {
        let at = |i: usize| core.vertices[i];
        match core.vertices.len() {
            1 => vec![[at(0), at(0)]],
            2 => vec![[at(0), at(1)]],
            _ => core
                .triangles
                .iter()
                .flat_map(|[i, j, k]| [[at(*i), at(*j)], [at(*j), at(*k)], [at(*k), at(*i)]])
                .collect(),
        }
    };
    for one in sides(a) {
        for other in sides(b) {
            let (from, to) = between_segments(&one, &other);
            take(from, to);
        }
    }
    for vertex in &a.vertices {
        b.triangles.iter().filter_map(|t| foot(vertex, b, t)).for_each(|to| take(*vertex, to));
    }
    for vertex in &b.vertices {
        a.triangles.iter().filter_map(|t| foot(vertex, a, t)).for_each(|from| take(from, *vertex));
    }
    (best.1, best.2)
}

/// The foot of a point's perpendicular on a triangle, if it is inside.
fn foot(point: &Vector3<f64>, core: &Placed, triangle: &[usize; 3]) -> Option<Vector3<f64>> {
    let [a, b, c] = triangle.map(|i| core.vertices[i]);
    let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
    let at = point - normal * normal.dot(&(point - a));
    let inside = |p: Vector3<f64>, q: Vector3<f64>| normal.dot(&(q - p).cross(&(at - p))) >= 0.0;
    (inside(a, b) && inside(b, c) && inside(c, a)).then_some(at)
}

/// Nearest points of two segments (Ericson, "Real-time collision detection", 2005, 5.1.9); their ends may be one point.
fn between_segments([p, q]: &[Vector3<f64>; 2], [r, s]: &[Vector3<f64>; 2]) -> (Vector3<f64>, Vector3<f64>) {
    let (u, v, w) = (q - p, s - r, p - r);
    let (a, e, f) = (u.norm_squared(), v.norm_squared(), v.dot(&w));
    let along = |t: f64| t.clamp(0.0, 1.0);
    let (x, y) = match (a == 0.0, e == 0.0) {
        (true, true) => (0.0, 0.0),
        (true, false) => (0.0, along(f / e)),
        (false, true) => (along(-u.dot(&w) / a), 0.0),
        (false, false) => {
            let (b, c) = (u.dot(&v), u.dot(&w));
            let across = a * e - b * b;
            let x = if across > 1e-14 * a * e { along((b * f - c * e) / across) } else { 0.0 };
            let y = (b * x + f) / e;
            match y {
                y if y < 0.0 => (along(-c / a), 0.0),
                y if y > 1.0 => (along((b - c) / a), 1.0),
                y => (x, y),
            }
        }
    };
    (p + u * x, r + v * y)
}

/// Eq. (2).
fn region(normal: &Vector3<f64>, a: &Placed, b: &Placed, slack: f64) -> Option<Touch> {
    let (top, bottom) = (a.support(normal) + a.radius, -b.support(&-normal) - b.radius);
    let gap = bottom - top;
    if gap > slack {
        return None;
    }
    let frame = Frame::new(normal);
    let discs = [frame.disc(a, 1.0, slack), frame.disc(b, -1.0, slack)];
    let flat = |core: &Placed, sign: f64, disc: &Option<Disc>| match disc {
        Some(disc) => vec![disc.middle],
        None => hull(&frame.lowest(core, sign, slack), slack),
    };
    let (low, high) = (flat(a, 1.0, &discs[0]), flat(b, -1.0, &discs[1]));
    let height = 0.5 * (top + bottom);
    let (corners, arcs): (Vec<Point>, Vec<(Disc, Arcs)>) = match discs {
        [None, None] => (common(&low, &high, slack), Vec::new()),
        [Some(disc), None] | [None, Some(disc)] => {
            let (corners, arcs) = disc.with_polygon(if discs[0].is_some() { &high } else { &low }, slack);
            (corners, vec![(disc, arcs)])
        }
        [Some(one), Some(other)] if one.is_on(&other, slack) => (Vec::new(), vec![(one, vec![[0.0, TAU]])]),
        [Some(one), Some(other)] => {
            (Vec::new(), vec![(one, one.with_disc(&other, slack)), (other, other.with_disc(&one, slack))])
        }
    };
    let arcs = arcs.into_iter().filter(|(_, arcs)| !arcs.is_empty());
    let rims: Vec<RimArcs> = arcs.map(|(disc, arcs)| frame.rim(&disc, arcs, height)).collect();
    let mut points = frame.points(&corners, &rims, height, slack);
    if points.is_empty() && gap < -slack {
        // They overlap so far that the features at this depth are not above each other: one point says where.
        let middle =
            |corners: &[[f64; 2]]| [0, 1].map(|i| corners.iter().map(|c| c[i]).sum::<f64>() / corners.len() as f64);
        let (one, other) = (middle(&low), middle(&high));
        points.push(frame.point(&[0.5 * (one[0] + other[0]), 0.5 * (one[1] + other[1])], height));
    }
    (!points.is_empty()).then_some(Touch { gap, normal: *normal, points, rims })
}

/// A tangent plane.
struct Frame {
    normal: Vector3<f64>,
    first: Vector3<f64>,
    second: Vector3<f64>,
}

impl Frame {
    fn new(normal: &Vector3<f64>) -> Self {
        let [first, second] = tangents(normal);
        Self { normal: *normal, first, second }
    }

    /// The disc of a cylinder that is furthest along `sign` times the normal, if one is.
    fn disc(&self, core: &Placed, sign: f64, slack: f64) -> Option<Disc> {
        let middle = cylinder::disc(core, &(self.normal * sign), slack)?;
        Some(Disc { middle: [self.first.dot(&middle), self.second.dot(&middle)], radius: core.rim })
    }

    fn rim(&self, disc: &Disc, arcs: Arcs, height: f64) -> RimArcs {
        RimArcs {
            middle: self.point(&disc.middle, height),
            arms: [self.first * disc.radius, self.second * disc.radius],
            arcs,
        }
    }

    /// Corners and points of rims, those in one place once.
    fn points(&self, corners: &[Point], rims: &[RimArcs], height: f64, slack: f64) -> Vec<Vector3<f64>> {
        let mut points: Vec<Vector3<f64>> = corners.iter().map(|corner| self.point(corner, height)).collect();
        for point in rims.iter().flat_map(|rim| rim.corners().into_iter().map(|angle| rim.at(angle))) {
            if points.iter().all(|known| (known - point).norm() > slack) {
                points.push(point);
            }
        }
        points
    }

    /// The vertices furthest along `sign` times the normal, in the plane.
    fn lowest(&self, core: &Placed, sign: f64, slack: f64) -> Vec<[f64; 2]> {
        let towards = self.normal * sign;
        if core.rim > 0.0 {
            let flat = |point: Vector3<f64>| [self.first.dot(&point), self.second.dot(&point)];
            return cylinder::lowest(core, &towards, slack).into_iter().map(flat).collect();
        }
        let most = core.support(&towards) - slack;
        let near = core.vertices.iter().filter(|v| towards.dot(v) >= most);
        near.map(|v| [self.first.dot(v), self.second.dot(v)]).collect()
    }

    fn point(&self, [x, y]: &[f64; 2], height: f64) -> Vector3<f64> {
        self.first * *x + self.second * *y + self.normal * height
    }
}

/// Two unit vectors across a unit normal: a right-handed frame with it.
pub(crate) fn tangents(normal: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let away = Vector3::ith(normal.iamin(), 1.0);
    let first = normal.cross(&away).normalize();
    [first, normal.cross(&first)]
}
