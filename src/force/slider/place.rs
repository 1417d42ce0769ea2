//! A slider on an element at one instant: (1) to (6) of [`super`].

use super::SliderLaw;
use crate::force::end::{Anchor, AnchorVariation};
use crate::spatial::link::{LinkMotion, LinkVariation};
use nalgebra::Vector3;

/// A node of the beam at one instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub(super) anchor: Anchor,
    /// `l t`
    pub(super) tangent: Vector3<f64>,
    /// Its rate.
    turning: Vector3<f64>,
    /// ω
    spin: Vector3<f64>,
}

/// How it varies.
#[derive(Debug, Clone, Copy)]
pub(super) struct NodeVariation {
    pub(super) anchor: AnchorVariation,
    pub(super) tangent: Vector3<f64>,
    turning: Vector3<f64>,
    spin: Vector3<f64>,
}

impl Node {
    pub(super) fn of(anchor: Anchor, tangent: Vector3<f64>, spin: Vector3<f64>) -> Self {
        Self { anchor, tangent, turning: spin.cross(&tangent), spin }
    }

    fn vary(&self, link: &LinkMotion, by: &LinkVariation) -> NodeVariation {
        let tangent = by.turn.cross(&self.tangent);
        let turning = by.angular_velocity.cross(&self.tangent) + self.spin.cross(&tangent);
        NodeVariation { anchor: self.anchor.vary(link, by), tangent, turning, spin: by.angular_velocity }
    }
}

/// A slider on an element at one instant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    pub(super) element: usize,
    pub(super) point: Anchor,
    pub(super) nodes: [Node; 2],
    /// The weights of (1) and their first two derivatives.
    hermite: [[f64; 4]; 3],
    /// u
    pub(super) u: f64,
    /// d
    pub(super) across: Vector3<f64>,
    /// c′ and c″
    slopes: [Vector3<f64>; 2],
}

/// How it varies.
pub(super) struct PlaceVariation {
    pub(super) point: AnchorVariation,
    pub(super) nodes: [NodeVariation; 2],
    pub(super) u: f64,
    pub(super) across: Vector3<f64>,
    pub(super) force: Vector3<f64>,
}

/// Newton steps towards the nearest point, at most: from the chord three do in beams that are bent a little.
const MOST_STEPS: usize = 30;

impl Place {
    /// (2) by Newton's method from the nearest point of the chord.
    pub(super) fn of(element: usize, point: Anchor, nodes: [Node; 2]) -> Self {
        let chord = nodes[1].anchor.position - nodes[0].anchor.position;
        let u = chord.dot(&(point.position - nodes[0].anchor.position)) / chord.norm_squared();
        let mut place = Self { element, point, nodes, hermite: hermite(u), u, across: chord, slopes: [chord; 2] };
        let (mut before, mut best) = (f64::INFINITY, place.locate(u));
        for _ in 0..MOST_STEPS {
            // Round-off no longer shrinks.
            if !(best.abs() < before) || best == 0.0 {
                break;
            }
            before = best.abs();
            best = place.locate(place.u + best);
        }
        place
    }

    /// Goes to `u`; returns the step from there to the nearest point.
    fn locate(&mut self, u: f64) -> f64 {
        (self.u, self.hermite) = (u, hermite(u));
        let [a, b] = &self.nodes;
        let shape = [a.anchor.position, a.tangent, b.anchor.position, b.tangent];
        self.across = self.point.position - self.mix(0, shape);
        self.slopes = [self.mix(1, shape), self.mix(2, shape)];
        self.across.dot(&self.slopes[0]) / self.bent()
    }

    /// The denominator of (6); where the point is beyond the centre of curvature there is no nearest one, and it is left out.
    fn bent(&self) -> f64 {
        let [first, second] = &self.slopes;
        let (straight, bend) = (first.norm_squared(), self.across.dot(second));
        if bend < straight { straight - bend } else { straight }
    }

    /// (1), or a derivative with respect to `u`, of any four vectors.
    fn mix(&self, order: usize, [pa, ta, pb, tb]: [Vector3<f64>; 4]) -> Vector3<f64> {
        let [h00, h10, h01, h11] = self.hermite[order];
        h00 * pa + h10 * ta + h01 * pb + h11 * tb
    }

    /// The weights of the position and of the tangent of a node, or their derivatives.
    pub(super) fn weights(&self, order: usize, node: usize) -> [f64; 2] {
        [self.hermite[order][2 * node], self.hermite[order][2 * node + 1]]
    }

    /// The part of the turn of a node in that of the section.
    pub(super) fn share(&self, node: usize) -> f64 {
        if node == 0 { 1.0 - self.u } else { self.u }
    }

    /// ċ at a fixed `u`, or its derivative with respect to `u`.
    fn carried(&self, order: usize) -> Vector3<f64> {
        let [a, b] = &self.nodes;
        self.mix(order, [a.anchor.velocity, a.turning, b.anchor.velocity, b.turning])
    }

    fn spin(&self) -> Vector3<f64> {
        (1.0 - self.u) * self.nodes[0].spin + self.u * self.nodes[1].spin
    }

    /// w of (3)
    fn relative(&self) -> Vector3<f64> {
        self.point.velocity - self.carried(0) - self.spin().cross(&self.across)
    }

    /// τ
    fn axis(&self) -> Vector3<f64> {
        self.slopes[0].normalize()
    }

    /// `w − τ τ·w`
    pub(super) fn rate(&self) -> Vector3<f64> {
        let (axis, relative) = (self.axis(), self.relative());
        relative - axis * axis.dot(&relative)
    }

    /// (4)
    pub(super) fn force(&self, law: &SliderLaw) -> Vector3<f64> {
        -law.stiffness * self.across - law.damping * self.rate()
    }

    /// The length of the element (m).
    pub(super) fn length(&self, law: &SliderLaw) -> f64 {
        law.stations[self.element + 1] - law.stations[self.element]
    }

    /// How far it is from the root along the unstrained beam (m).
    pub(super) fn station(&self, law: &SliderLaw) -> f64 {
        law.stations[self.element] + self.u * self.length(law)
    }

    /// How fast that changes (m/s): (6) with rates.
    pub(super) fn speed(&self) -> f64 {
        let along = (self.point.velocity - self.carried(0)).dot(&self.slopes[0]) + self.across.dot(&self.carried(1));
        along / self.bent() * self.nodes[0].tangent.norm()
    }

    pub(super) fn vary(&self, law: &SliderLaw, links: &[LinkMotion], by: &[LinkVariation]) -> PlaceVariation {
        let of = |i: usize| law.ends[i].link;
        let point = self.point.vary(&links[of(0)], &by[of(0)]);
        let nodes = [0, 1].map(|i| {
            let link = of(1 + self.element + i);
            self.nodes[i].vary(&links[link], &by[link])
        });
        let [a, b] = &nodes;
        let shape = [a.anchor.position, a.tangent, b.anchor.position, b.tangent];
        let [first, second] = &self.slopes;
        let u = ((point.position - self.mix(0, shape)).dot(first) + self.across.dot(&self.mix(1, shape))) / self.bent();
        let across = point.position - self.mix(0, shape) - first * u;
        let slope = self.mix(1, shape) + second * u;
        let carried = self.mix(0, [a.anchor.velocity, a.turning, b.anchor.velocity, b.turning]) + self.carried(1) * u;
        let spin = (1.0 - self.u) * a.spin + self.u * b.spin + (self.nodes[1].spin - self.nodes[0].spin) * u;
        let relative = point.velocity - carried - spin.cross(&self.across) - self.spin().cross(&across);
        let (axis, w) = (self.axis(), self.relative());
        let turn = (slope - axis * axis.dot(&slope)) / first.norm();
        let rate = relative - turn * axis.dot(&w) - axis * (turn.dot(&w) + axis.dot(&relative));
        PlaceVariation { point, nodes, u, across, force: -law.stiffness * across - law.damping * rate }
    }
}

/// The cubics h₀₀, h₁₀, h₀₁, h₁₁ of Hermite, and their first two derivatives.
fn hermite(u: f64) -> [[f64; 4]; 3] {
    let (square, cube) = (u * u, u * u * u);
    [
        [2.0 * cube - 3.0 * square + 1.0, cube - 2.0 * square + u, 3.0 * square - 2.0 * cube, cube - square],
        [6.0 * (square - u), 3.0 * square - 4.0 * u + 1.0, 6.0 * (u - square), 3.0 * square - 2.0 * u],
        [12.0 * u - 6.0, 6.0 * u - 4.0, 6.0 - 12.0 * u, 6.0 * u - 2.0],
    ]
}
