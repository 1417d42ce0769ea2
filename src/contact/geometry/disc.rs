//! Discs that lie flat on something: what they have in common with it, in the tangent plane.

use super::polygon::{Point, holds};
use std::f64::consts::TAU;

/// The face of a cylinder.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Disc {
    pub(super) middle: Point,
    pub(super) radius: f64,
}

/// Parts of a rim: from an angle to a larger one (rad); a whole turn if nothing cuts it.
pub(super) type Arcs = Vec<[f64; 2]>;

impl Disc {
    fn at(&self, angle: f64) -> Point {
        [self.middle[0] + self.radius * angle.cos(), self.middle[1] + self.radius * angle.sin()]
    }

    fn has(&self, point: Point, slack: f64) -> bool {
        (point[0] - self.middle[0]).hypot(point[1] - self.middle[1]) <= self.radius + slack
    }

    /// What it has in common with a convex polygon, a segment or a point: corners of that, and arcs of its own rim.
    pub(super) fn with_polygon(&self, polygon: &[Point], slack: f64) -> (Vec<Point>, Arcs) {
        let mut corners: Vec<Point> = polygon.iter().copied().filter(|corner| self.has(*corner, slack)).collect();
        let sides = if polygon.len() == 2 { 1 } else { polygon.len() };
        let sides = (0..sides).map(|i| (polygon[i], polygon[(i + 1) % polygon.len()]));
        let cuts: Vec<f64> = sides.flat_map(|(from, to)| self.cuts(from, to)).collect();
        if polygon.len() < 3 {
            corners.extend(cuts.into_iter().map(|angle| self.at(angle)));
            return (corners, Vec::new());
        }
        (corners, arcs(cuts, |angle| holds(polygon, self.at(angle), slack)))
    }

    /// The arcs of its rim that are on another disc; of one that lies on it with the same rim, all of it.
    pub(super) fn with_disc(&self, other: &Self, slack: f64) -> Arcs {
        let [x, y] = [0, 1].map(|i| other.middle[i] - self.middle[i]);
        let apart = x.hypot(y);
        // Cosine of half the angle of the common chord.
        let half =
            (apart * apart + self.radius * self.radius - other.radius * other.radius) / (2.0 * apart * self.radius);
        let cuts = match apart > slack && half.abs() < 1.0 {
            true => [-1.0, 1.0].map(|side| y.atan2(x) + side * half.acos()).to_vec(),
            false => Vec::new(),
        };
        arcs(cuts, |angle| other.has(self.at(angle), slack))
    }

    /// Whether another disc has the same rim.
    pub(super) fn is_on(&self, other: &Self, slack: f64) -> bool {
        let apart = (self.middle[0] - other.middle[0]).hypot(self.middle[1] - other.middle[1]);
        apart <= slack && (self.radius - other.radius).abs() <= slack
    }

    /// Angles at which a segment cuts the rim.
    fn cuts(&self, from: Point, to: Point) -> Vec<f64> {
        let (along, off) = ([to[0] - from[0], to[1] - from[1]], [from[0] - self.middle[0], from[1] - self.middle[1]]);
        let a = along[0] * along[0] + along[1] * along[1];
        let b = along[0] * off[0] + along[1] * off[1];
        let c = off[0] * off[0] + off[1] * off[1] - self.radius * self.radius;
        let square = b * b - a * c;
        if !(square > 0.0) {
            return Vec::new();
        }
        let places = [-1.0, 1.0].map(|side| (-b + side * square.sqrt()) / a);
        let on = places.into_iter().filter(|t| (0.0..=1.0).contains(t));
        on.map(|t| (off[1] + t * along[1]).atan2(off[0] + t * along[0])).collect()
    }
}

/// The parts of a turn between cuts whose middle is within.
fn arcs(cuts: Vec<f64>, within: impl Fn(f64) -> bool) -> Arcs {
    let mut cuts: Vec<f64> = cuts.into_iter().map(|angle| angle.rem_euclid(TAU)).collect();
    cuts.sort_by(f64::total_cmp);
    let Some(first) = cuts.first().copied() else {
        return if within(0.0) { vec![[0.0, TAU]] } else { Vec::new() };
    };
    let ends = cuts.iter().copied().skip(1).chain([first + TAU]);
    let mut found: Arcs = Vec::new();
    for (from, to) in cuts.iter().copied().zip(ends) {
        if to > from && within(0.5 * (from + to)) {
            match found.last_mut() {
                // A corner that touches the rim cuts nothing off.
                Some(last) if last[1] == from => last[1] = to,
                _ => found.push([from, to]),
            }
        }
    }
    found
}
