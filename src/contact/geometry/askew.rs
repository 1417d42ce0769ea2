//! Rims of cylinders that meet straight edges and other rims askew: where the distance between both is smallest.
//!
//! ```text
//! (1)  w = x_b − x_a,  w·t_a = 0,  w·t_b = 0        t along the rims, or along the edge: the normal is ± t_a × t_b / |t_a × t_b|
//! (2)  seen along an edge a rim is an ellipse, a = r, b = r |tilt|:  cos θ = a q₁/(τ + a² − b²),  sin θ = b q₂/τ
//!      at the root of (a q₁/(τ + a² − b²))² + (b q₂/τ)² = 1 with τ > 0, q in the first quadrant
//! ```
//!
//! (2) is D. Eberly's ("Distance from a Point to an Ellipse", 2011); its left side falls and is convex, so that Newton's method comes to the root from
//! below without fail. A pair counts where the normal is among those of the rim, between its face's and its side's, and among those of the
//! other surface: beyond that faces, sides and, of edges that lie across a face, both ends of their chord ([`super::chord`]) take over.

use super::chord;
use super::feature::{Feature, Meeting, Near, PARALLEL, PlacedBoundary, Rim, TILTED};
use super::tangents;
use nalgebra::{Matrix2, Vector2, Vector3};

/// Edges of a cylinder beyond its side and its chords: the rims of both faces, each in two halves, across what is seen of an edge.
pub(super) const RIMS: std::ops::Range<u16> = 5..9;
/// The first half of each stands for all of it against another rim.
const WHOLE: [u16; 2] = [5, 7];
/// Steps of Newton's method.
const MOST_STEPS: usize = 40;
/// Newton's method on two angles that are this close to their end (rad) and come no closer is there.
const STANDSTILL: f64 = 1e-9;
/// Points of a rim from which the nearest of another are looked for.
const STARTS: usize = 24;

/// A circle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Circle {
    pub(super) middle: Vector3<f64>,
    /// Unit vector across it.
    pub(super) axis: Vector3<f64>,
    pub(super) radius: f64,
}

/// A point of one, seen from its middle: unit vectors.
#[derive(Debug, Clone, Copy)]
struct Spot {
    out: Vector3<f64>,
    tangent: Vector3<f64>,
}

impl Circle {
    fn spot(&self, out: Vector3<f64>) -> Spot {
        Spot { out, tangent: self.axis.cross(&out) }
    }

    fn point(&self, spot: &Spot) -> Vector3<f64> {
        self.middle + spot.out * self.radius
    }

    /// The spot that is turned on by an angle (rad), a small one.
    fn turned(&self, spot: &Spot, by: f64) -> Spot {
        self.spot((spot.out * by.cos() + spot.tangent * by.sin()).normalize())
    }

    /// The spot that is nearest to a point off the axis.
    fn nearest(&self, point: &Vector3<f64>) -> Option<Spot> {
        let from = point - self.middle;
        let out = (from - self.axis * self.axis.dot(&from)).try_normalize(0.0)?;
        Some(self.spot(out))
    }

    /// Across the axis, along what is seen of a direction; any if nothing is.
    fn along(&self, u: &Vector3<f64>) -> Vector3<f64> {
        let [first, _] = tangents(&self.axis);
        (u - self.axis * self.axis.dot(u)).try_normalize(1e-9).unwrap_or(first)
    }

    /// The spot that is nearest to the line through `p` along `u` among those that lie backward (0) or forward (1) along it; `None` if the
    /// distance has no minimum there, or if it is smaller on the other side and not `both` are asked for.
    fn beside(&self, p: &Vector3<f64>, u: &Vector3<f64>, half: u16, both: bool) -> Option<Spot> {
        let along = self.along(u);
        let across = self.axis.cross(&along);
        let tilt = self.axis.dot(u);
        // Seen along u: the point of the line beside the ellipse, whose second axis is across both.
        let (from, a, b) = (p - self.middle, self.radius, self.radius * tilt.abs());
        let q = [from.dot(&across), from.dot(&u.cross(&across))];
        let [cos, sin] = on_ellipse(a, b, q.map(f64::abs));
        // A point at the angle θ is seen at −tilt r sin θ.
        let own = if -tilt * q[1] >= 0.0 { 1 } else { 0 };
        if own != half && !both {
            return None;
        }
        let side = if half == 1 { 1.0 } else { -1.0 };
        let first = self.spot((across * (cos * q[0].signum()) + along * (side * sin)).normalize());
        let (mut spot, mut is_least) = (first, own == half);
        for _ in 0..MOST_STEPS {
            let arm = p - self.point(&spot);
            let w = arm - u * u.dot(&arm);
            let slope = self.radius * (1.0 - u.dot(&spot.tangent).powi(2)) + w.dot(&spot.out);
            let turn = w.dot(&spot.tangent) / slope;
            is_least = slope > 0.0;
            if !is_least || !(turn.abs() > f64::EPSILON) {
                break;
            }
            spot = self.turned(&spot, turn.clamp(-0.5, 0.5));
        }
        (is_least && side * spot.out.dot(&along) > -0.5).then_some(spot)
    }
}

/// (2): cosine and sine of the point of an ellipse with half axes `a` ≥ `b` that is nearest to a point of the first quadrant.
fn on_ellipse(a: f64, b: f64, [x, y]: [f64; 2]) -> [f64; 2] {
    // In parts of a.
    let (b, x, y) = (b / a, x / a, y / a);
    let longer = 1.0 - b * b;
    // Here the left side is at least 1.
    let mut t = (x - longer).max(b * y);
    if !(t > 0.0) {
        // On the longer axis, within what both ends bend around.
        let cos = x / longer;
        return [cos, (1.0 - cos * cos).max(0.0).sqrt()];
    }
    for _ in 0..MOST_STEPS {
        let [c, s] = [x / (t + longer), b * y / t];
        let slope = -2.0 * (c * c / (t + longer) + s * s / t);
        let step = (1.0 - c * c - s * s) / slope;
        if !(step > f64::EPSILON * t) {
            break;
        }
        t += step;
    }
    let [c, s] = [x / (t + longer), b * y / t];
    let size = c.hypot(s);
    [c / size, s / size]
}

/// Spots of two circles at which their distance is smallest, (1).
fn least(a: &Circle, b: &Circle) -> Vec<[Spot; 2]> {
    let [first, second] = tangents(&a.axis);
    let start = |k: usize| {
        let (sin, cos) = (std::f64::consts::TAU * k as f64 / STARTS as f64).sin_cos();
        a.spot(first * cos + second * sin)
    };
    let far = |spot: &Spot| {
        let point = a.point(spot);
        b.nearest(&point).map_or(f64::INFINITY, |near| (b.point(&near) - point).norm_squared())
    };
    let starts: Vec<(Spot, f64)> = (0..STARTS).map(start).map(|spot| (spot, far(&spot))).collect();
    let mut found: Vec<[Spot; 2]> = Vec::new();
    for k in 0..STARTS {
        let (spot, distance) = starts[k];
        if distance > starts[(k + 1) % STARTS].1 || distance >= starts[(k + STARTS - 1) % STARTS].1 {
            continue;
        }
        let Some(other) = b.nearest(&a.point(&spot)) else { continue };
        if let Some(pair) = refined(a, b, [spot, other])
            && !found.iter().any(|known| (known[0].out - pair[0].out).norm() < 1e-6)
        {
            found.push(pair);
        }
    }
    found
}

/// (1) by Newton's method on the angles of both spots; `None` if it ends where the distance is not smallest.
fn refined(a: &Circle, b: &Circle, [mut one, mut other]: [Spot; 2]) -> Option<[Spot; 2]> {
    let mut last = f64::INFINITY;
    for step in 1..=MOST_STEPS {
        let w = b.point(&other) - a.point(&one);
        let pull = Vector2::new(-w.dot(&one.tangent) * a.radius, w.dot(&other.tangent) * b.radius);
        let mixed = -one.tangent.dot(&other.tangent) * a.radius * b.radius;
        let [x, y] = [a.radius * (a.radius + w.dot(&one.out)), b.radius * (b.radius - w.dot(&other.out))];
        let curved = Matrix2::new(x, mixed, mixed, y);
        let is_least = x > 0.0 && curved.determinant() > 0.0;
        // Where the distance is not curved as at its least, downhill.
        let turn = match is_least {
            true => -curved.try_inverse()? * pull,
            false => -pull / (x.abs() + y.abs() + mixed.abs()),
        };
        let size = turn.amax();
        let is_done = size <= 2.0 * f64::EPSILON || size < STANDSTILL && size > 0.5 * last;
        if is_least && is_done || step == MOST_STEPS {
            return is_least.then_some([one, other]);
        }
        last = size;
        let most = size.max(0.3) / 0.3;
        (one, other) = (a.turned(&one, turn.x / most), b.turned(&other, turn.y / most));
    }
    None
}

/// Unit vectors from circles of one solid to those of another along which they may be furthest apart.
pub(super) fn axes(own: &[Circle], other: &[Circle]) -> Vec<Vector3<f64>> {
    let mut found = Vec::new();
    for (a, b) in own.iter().flat_map(|a| other.iter().map(move |b| (a, b))) {
        for [one, near] in least(a, b) {
            let Some(normal) = one.tangent.cross(&near.tangent).try_normalize(PARALLEL) else { continue };
            found.push(if normal.dot(&(one.out + a.axis)) < 0.0 { -normal } else { normal });
        }
        // The side of the other, about its axis.
        for spot in (0..2).filter_map(|half| a.beside(&b.middle, &b.axis, half, true)) {
            let arm = b.middle - a.point(&spot);
            let way = || (arm - b.axis * b.axis.dot(&arm)).try_normalize(0.0);
            let crossed = spot.tangent.cross(&b.axis).try_normalize(PARALLEL);
            let Some(normal) = crossed.or_else(way) else { continue };
            found.push(if normal.dot(&(spot.out + a.axis)) < 0.0 { -normal } else { normal });
        }
    }
    found
}

/// The rim of a face of a cylinder, its axis outwards.
fn circle(of: &PlacedBoundary<'_>, face: usize) -> Circle {
    let (middle, far) = (of.vertices[face], of.vertices[1 - face]);
    Circle { middle, axis: (middle - far).normalize(), radius: of.of.rim }
}

/// How far a normal is among those of a rim (m), those before its face by [`TILTED`] included where an edge lies flat.
fn among(circle: &Circle, spot: &Spot, normal: &Vector3<f64>, slack: f64) -> f64 {
    (normal.dot(&spot.out) + slack).min(normal.dot(&circle.axis)) * circle.radius
}

/// The normal across a rim and an edge that has a direction there, outwards, and how far their angle is above the least that gives one (m).
fn across(circle: &Circle, spot: &Spot, edge: &Vector3<f64>) -> Option<(Vector3<f64>, f64)> {
    let crossed = edge.cross(&spot.tangent);
    let (angle, normal) = (crossed.norm(), crossed.try_normalize(PARALLEL)?);
    let outwards = normal.dot(&(spot.out + circle.axis)) >= 0.0;
    Some((if outwards { normal } else { -normal }, (angle - chord::SHORT) * circle.radius))
}

fn rim(circle: &Circle, spot: &Spot) -> Option<Rim> {
    Some(Rim { arm: spot.out * circle.radius, tangent: spot.tangent, tilt: 0.0 })
}

/// A rim of a cylinder and an edge with a radius about it, of a polytope, a capsule or the side of a cylinder.
pub(super) fn with_edge(
    own: &PlacedBoundary<'_>,
    other: &PlacedBoundary<'_>,
    [which, edge]: [u16; 2],
    about: f64,
    near: &Near,
) -> Option<Meeting> {
    let (face, half) = ((which - RIMS.start) / 2, (which - RIMS.start) % 2);
    let circle = circle(own, usize::from(face));
    let [p, q] = other.ends(edge);
    let length = (q - p).norm();
    let u = (q - p) / length;
    let from = p - circle.middle;
    if (from - u * u.dot(&from)).norm() - circle.radius - about >= near.gap {
        return None;
    }
    let spot = circle.beside(&p, &u, half, about > 0.0)?;
    let point = circle.point(&spot);
    let x = u.dot(&(point - p));
    let foot = p + u * x;
    let (normal, askew) = match about > 0.0 {
        // The way from one to the other is as long as the radius, nearly.
        true => ((foot - point).try_normalize(0.5 * about)?, f64::INFINITY),
        false => across(&circle, &spot, &u)?,
    };
    let behind = other.below(&-normal, &foot, &other.of.edges[usize::from(edge)]);
    let tilt = circle.axis.dot(&u).abs();
    let side = spot.out.dot(&circle.along(&u)) * circle.radius * if half == 1 { 1.0 } else { -1.0 };
    // What lies flat beyond a face is nearest between both halves, where the rim runs along it: then it is a matter of the one.
    let between = about > 0.0 && tilt < PARALLEL && side.abs() < chord::SHORT * circle.radius;
    let side = match (between, half) {
        (true, 0) => return None,
        (true, _) => f64::INFINITY,
        (false, _) => side,
    };
    // Edges across a face have chords; what is round about an edge lies on it.
    let beside = circle.axis.cross(&circle.along(&u)).dot(&from).abs();
    let elsewhere = if about > 0.0 { f64::INFINITY } else { -chord::counts(tilt, beside, circle.radius) };
    let slack = if about > 0.0 && tilt < TILTED { TILTED } else { 0.0 };
    let own = among(&circle, &spot, &normal, slack);
    let inside = [x, length - x, behind, side, elsewhere, askew, own].into_iter().fold(f64::INFINITY, f64::min);
    let features = [Feature::Edge(which), Feature::Edge(edge)];
    let found = Meeting::new(features, normal, [point, foot], [spot.tangent, u], [0.0, about], inside);
    Some(Meeting { rims: [rim(&circle, &spot), None], ..found })
}

/// Rims of two cylinders: of the places at which they are nearest the one that is most among those that count.
pub(super) fn with_rim(
    own: &PlacedBoundary<'_>,
    other: &PlacedBoundary<'_>,
    [which, against]: [u16; 2],
    near: &Near,
) -> Option<Meeting> {
    if !WHOLE.contains(&which) || !WHOLE.contains(&against) {
        return None;
    }
    let [a, b] = [(own, which), (other, against)].map(|(of, which)| circle(of, usize::from((which - RIMS.start) / 2)));
    if (b.middle - a.middle).norm() - a.radius - b.radius >= near.gap {
        return None;
    }
    let make = |[one, other]: [Spot; 2]| {
        let (normal, askew) = across(&a, &one, &other.tangent)?;
        let inside = among(&a, &one, &normal, 0.0).min(among(&b, &other, &-normal, 0.0)).min(askew);
        let features = [Feature::Edge(which), Feature::Edge(against)];
        let cores = [a.point(&one), b.point(&other)];
        let found = Meeting::new(features, normal, cores, [one.tangent, other.tangent], [0.0; 2], inside);
        Some(Meeting { rims: [rim(&a, &one), rim(&b, &other)], ..found })
    };
    least(&a, &b).into_iter().filter_map(make).max_by(|one, other| one.inside.total_cmp(&other.inside))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers between −1 and 1.
    fn numbers(seed: u64) -> impl FnMut() -> f64 {
        let mut state = seed.wrapping_mul(2).wrapping_add(1);
        move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }
    }

    fn circle(next: &mut impl FnMut() -> f64) -> Circle {
        let mut vector = || Vector3::new(next(), next(), next());
        let (middle, axis) = (vector(), vector().normalize());
        Circle { middle, axis, radius: 0.6 + 0.5 * next() }
    }

    /// The spot that is nearest to a line is as near as the nearest of ten thousand, along flat rims and steep ones.
    #[test]
    fn spots_beside_lines_are_nearest() {
        for seed in 0..400 {
            let mut next = numbers(seed);
            let circle = circle(&mut next);
            let mut vector = || Vector3::new(next(), next(), next());
            let (p, mut u) = (vector() * 1.5, vector().normalize());
            match seed % 4 {
                0 => u = (u - circle.axis * circle.axis.dot(&u)).normalize(),
                1 => u = circle.axis,
                2 => u = (u - circle.axis * (0.999 * circle.axis.dot(&u))).normalize(),
                _ => {}
            }
            let far = |spot: &Spot| {
                let arm = circle.point(spot) - p;
                (arm - u * u.dot(&arm)).norm()
            };
            let found = (0..2).filter_map(|half| circle.beside(&p, &u, half, true));
            let found = found.map(|spot| far(&spot)).fold(f64::INFINITY, f64::min);
            let [first, second] = tangents(&circle.axis);
            let best = (0..10_000).map(|k| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 1e4).sin_cos();
                far(&circle.spot(first * cos + second * sin))
            });
            let best = best.fold(f64::INFINITY, f64::min);
            assert!(found <= best + 1e-12 && found > best - 1e-4, "seed {seed}: {found} {best}");
        }
    }

    /// Two circles are nearest where they are nearest of all pairs of a fine grid.
    #[test]
    fn spots_of_two_circles_are_nearest() {
        for seed in 0..300 {
            let mut next = numbers(1000 + seed);
            let (a, b) = (circle(&mut next), circle(&mut next));
            let far = |[one, other]: &[Spot; 2]| (a.point(one) - b.point(other)).norm();
            let found = least(&a, &b).iter().map(far).fold(f64::INFINITY, f64::min);
            let [first, second] = tangents(&a.axis);
            let best = (0..4000).filter_map(|k| {
                let (sin, cos) = (std::f64::consts::TAU * f64::from(k) / 4e3).sin_cos();
                let one = a.spot(first * cos + second * sin);
                b.nearest(&a.point(&one)).map(|other| far(&[one, other]))
            });
            let best = best.fold(f64::INFINITY, f64::min);
            assert!(found <= best + 1e-12 && found > best - 3e-3, "seed {seed}: {found} {best}");
        }
    }
}
