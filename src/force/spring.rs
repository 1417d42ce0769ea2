//! A spring and damper along the line between two points.
//!
//! ```text
//! x = x_b − x_a,  L = |x|,  u = x / L
//! tension  T = k (L − L₀) + c L̇,   L̇ = u·(v_b − v_a)
//! force on a: +T u,  on b: −T u;   potential ½ k (L − L₀)²
//! ```
//!
//! A spring with L₀ = 0 is regular at L = 0 (force k x). With L₀ > 0 the direction is undefined there and the force is
//! not a number, which stops whoever asked.

use super::end::Anchor;
use super::{Act, Attachment, Carrier, Describe, End, ForceDescription, Magnitude, Picture, Report};
use crate::spatial::Wrench;
use crate::spatial::link::{LinkMotion, LinkVariation};
use nalgebra::Vector3;

/// Along the line between two points: tension `k (distance − length) + c d(distance)/dt`.
#[derive(Debug, Clone, PartialEq)]
pub struct Spring {
    /// The two ends.
    pub between: [Attachment; 2],
    /// Stiffness (N/m), ≥ 0.
    pub stiffness: f64,
    /// Unstretched length (m), ≥ 0.
    pub length: f64,
    /// Damping (N s/m), ≥ 0.
    pub damping: f64,
}

/// A spring, compiled.
#[derive(Debug, Clone)]
pub struct SpringLaw {
    ends: [End; 2],
    stiffness: f64,
    length: f64,
    damping: f64,
}

impl ForceDescription {
    /// A spring along the line between two points: stiffness (N/m), unstretched length (m), damping (N s/m).
    pub fn spring(
        name: &str,
        from: impl Into<Attachment>,
        to: impl Into<Attachment>,
        stiffness: f64,
        length: f64,
        damping: f64,
    ) -> Self {
        let kind = Spring { between: [from.into(), to.into()], stiffness, length, damping };
        Self { name: name.to_owned(), kind: kind.into() }
    }
}

impl Describe for Spring {
    type Law = SpringLaw;

    fn attachments(&self) -> Vec<(String, &Attachment)> {
        (0..2).map(|i| (format!("between[{i}]"), &self.between[i])).collect()
    }

    fn check(&self, report: &mut Report<'_>) {
        report.not_negative("stiffness", self.stiffness, "N/m");
        report.not_negative("length", self.length, "m");
        report.not_negative("damping", self.damping, "N s/m");
        report.apart(&self.between, "a spring");
    }

    fn compile(&self, carriers: &[Carrier]) -> SpringLaw {
        let Self { stiffness, length, damping, .. } = *self;
        SpringLaw { ends: [carriers[0].end, carriers[1].end], stiffness, length, damping }
    }

    fn numbers(&self, key: &str) -> Vec<(f64, &'static str)> {
        match key {
            "stiffness" => vec![(self.stiffness, "N/m")],
            "length" => vec![(self.length, "m")],
            _ => Vec::new(),
        }
    }

    fn set(&mut self, key: &str, _index: usize, value: f64) {
        match key {
            "stiffness" => self.stiffness = value,
            _ => self.length = value,
        }
    }
}

impl Act for SpringLaw {
    fn ends(&self) -> &[End] {
        &self.ends
    }

    #[inline]
    fn wrenches(&self, links: &[LinkMotion], give: &mut impl FnMut(usize, Wrench)) {
        let state = State::of(self, links);
        let force = state.force();
        give(0, Wrench::at_arm(force, state.points[0].arm));
        give(1, Wrench::at_arm(-force, state.points[1].arm));
    }

    fn vary(&self, links: &[LinkMotion], by: &[LinkVariation], give: &mut impl FnMut(usize, Wrench)) {
        let state = State::of(self, links);
        let [on_a, on_b] = state.vary(links, by);
        give(0, on_a);
        give(1, on_b);
    }

    fn potential(&self, links: &[LinkMotion]) -> f64 {
        0.5 * self.stiffness * (State::of(self, links).distance - self.length).powi(2)
    }

    fn dissipated(&self, links: &[LinkMotion]) -> f64 {
        let rate = State::of(self, links).rate;
        self.damping * rate * rate
    }

    fn has_damping(&self) -> bool {
        self.damping != 0.0
    }

    fn magnitude(&self, links: &[LinkMotion]) -> Magnitude {
        let state = State::of(self, links);
        Magnitude {
            force: state.force().norm(),
            noise: self.stiffness * (state.points[0].position.norm() + state.points[1].position.norm() + self.length),
            stiffness: self.stiffness,
            ..Magnitude::default()
        }
    }

    fn picture(&self) -> Picture<'_> {
        Picture::Line { through: &self.ends, spring: Some([self.stiffness, self.length]), pulls_only: false }
    }
}

/// A spring at one instant.
struct State<'a> {
    law: &'a SpringLaw,
    points: [Anchor; 2],
    /// x, L, u
    between: Vector3<f64>,
    distance: f64,
    direction: Vector3<f64>,
    /// v_b − v_a and L̇
    velocity: Vector3<f64>,
    rate: f64,
}

impl<'a> State<'a> {
    #[inline]
    fn of(law: &'a SpringLaw, links: &[LinkMotion]) -> Self {
        let points = [Anchor::of(&law.ends[0], links), Anchor::of(&law.ends[1], links)];
        let between = points[1].position - points[0].position;
        let distance = between.norm();
        let touching = distance == 0.0 && law.length == 0.0;
        let direction = if touching { Vector3::zeros() } else { between / distance };
        let velocity = points[1].velocity - points[0].velocity;
        let rate = direction.dot(&velocity);
        Self { law, points, between, distance, direction, velocity, rate }
    }

    /// Force on the first end.
    fn force(&self) -> Vector3<f64> {
        let elastic = self.law.stiffness * (self.between - self.law.length * self.direction);
        elastic + self.law.damping * self.rate * self.direction
    }

    fn vary(&self, links: &[LinkMotion], by: &[LinkVariation]) -> [Wrench; 2] {
        let SpringLaw { ends, stiffness, length, damping } = self.law;
        let [a, b] = [0, 1].map(|i| self.points[i].vary(&links[ends[i].link], &by[ends[i].link]));
        let (between, velocity) = (b.position - a.position, b.velocity - a.velocity);
        let turn = if self.distance == 0.0 {
            Vector3::zeros()
        } else {
            (between - self.direction.dot(&between) * self.direction) / self.distance
        };
        let rate = turn.dot(&self.velocity) + self.direction.dot(&velocity);
        let force =
            *stiffness * (between - *length * turn) + *damping * (rate * self.direction + self.rate * turn);
        let total = self.force();
        let on = |arm: Vector3<f64>, varied: Vector3<f64>, sign: f64| Wrench {
            force: sign * force,
            moment: sign * (arm.cross(&force) + varied.cross(&total)),
        };
        [on(self.points[0].arm, a.arm, 1.0), on(self.points[1].arm, b.arm, -1.0)]
    }
}
