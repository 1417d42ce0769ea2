//! A straight segment between two points of links: what springs, curves and ropes pull along.
//!
//! ```text
//! (1) x = p_b − p_a,  d = |x|,  u = x / d,  w = v_b − v_a,  ḋ = u·w
//! (2) δd = u·δx,  δu = (δx − u δd) / d,  δḋ = δu·w + u·δw
//! (3) force on a: +f,  on b: −f, at their arms r;   δm = ±(r × δf + δr × f)
//! ```

use super::End;
use super::end::{Anchor, AnchorVariation};
use crate::spatial::Wrench;
use crate::spatial::link::{LinkMotion, LinkVariation};
use nalgebra::Vector3;

/// A segment at one instant, (1).
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    /// a and b.
    pub(super) points: [Anchor; 2],
    /// x, d, u; without length the direction is not a number.
    pub(super) between: Vector3<f64>,
    pub(super) distance: f64,
    pub(super) direction: Vector3<f64>,
    /// w and ḋ
    velocity: Vector3<f64>,
    pub(super) rate: f64,
}

/// How a segment varies, (2).
#[derive(Debug, Clone, Copy)]
pub(super) struct SegmentVariation {
    points: [AnchorVariation; 2],
    /// δx, δd, δḋ, δu
    pub(super) between: Vector3<f64>,
    pub(super) distance: f64,
    pub(super) rate: f64,
    pub(super) direction: Vector3<f64>,
}

impl Segment {
    #[inline]
    pub(super) fn of(ends: &[End], links: &[LinkMotion]) -> Self {
        let points = [Anchor::of(&ends[0], links), Anchor::of(&ends[1], links)];
        let between = points[1].position - points[0].position;
        let distance = between.norm();
        let velocity = points[1].velocity - points[0].velocity;
        let direction = between / distance;
        Self { points, between, distance, direction, velocity, rate: direction.dot(&velocity) }
    }

    /// With no direction at all, for what pulls nowhere if its points lie on each other.
    pub(super) fn touching(self) -> Self {
        Self { direction: Vector3::zeros(), rate: 0.0, ..self }
    }

    /// (2); without length the direction stays.
    pub(super) fn vary(&self, ends: &[End], links: &[LinkMotion], by: &[LinkVariation]) -> SegmentVariation {
        self.varied([0, 1].map(|i| self.points[i].vary(&links[ends[i].link], &by[ends[i].link])))
    }

    /// [`Segment::vary`] with one link, all others being at rest.
    #[inline]
    pub(super) fn vary_with(
        &self,
        ends: &[End],
        links: &[LinkMotion],
        (link, by): (usize, &LinkVariation),
    ) -> SegmentVariation {
        let own = |i: usize| match ends[i].link == link {
            true => self.points[i].vary(&links[link], by),
            false => AnchorVariation::default(),
        };
        self.varied([own(0), own(1)])
    }

    #[inline]
    fn varied(&self, points: [AnchorVariation; 2]) -> SegmentVariation {
        let (between, velocity) = (points[1].position - points[0].position, points[1].velocity - points[0].velocity);
        let distance = self.direction.dot(&between);
        let direction = match self.distance {
            0.0 => Vector3::zeros(),
            length => (between - distance * self.direction) / length,
        };
        let rate = direction.dot(&self.velocity) + self.direction.dot(&velocity);
        SegmentVariation { points, between, distance, rate, direction }
    }

    /// (3): the wrenches on the links of a and b.
    #[inline]
    pub(super) fn pull(&self, force: Vector3<f64>) -> [Wrench; 2] {
        let [a, b] = &self.points;
        [Wrench::at_arm(force, a.arm), Wrench::at_arm(-force, b.arm)]
    }

    /// (3), varied with the force.
    pub(super) fn vary_pull(&self, by: &SegmentVariation, force: Vector3<f64>, varied: Vector3<f64>) -> [Wrench; 2] {
        let on = |i: usize, sign: f64| Wrench {
            force: sign * varied,
            moment: sign * (self.points[i].arm.cross(&varied) + by.points[i].arm.cross(&force)),
        };
        [on(0, 1.0), on(1, -1.0)]
    }
}
