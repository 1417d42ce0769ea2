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

use super::elastic;
use super::segment::{Segment, SegmentVariation};
use super::{Act, Attachment, Carrier, Describe, End, ForceDescription, LineKind, Magnitude, Picture, Report};
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
        elastic::numbers(self.stiffness, self.length, key)
    }

    fn set(&mut self, key: &str, _index: usize, value: f64) {
        elastic::set(&mut self.stiffness, &mut self.length, key, value);
    }
}

impl Act for SpringLaw {
    fn ends(&self) -> &[End] {
        &self.ends
    }

    #[inline]
    fn wrenches(&self, links: &[LinkMotion], give: &mut impl FnMut(usize, Wrench)) {
        let segment = self.segment(links);
        let [on_a, on_b] = segment.pull(self.force(&segment));
        give(0, on_a);
        give(1, on_b);
    }

    fn vary(&self, links: &[LinkMotion], by: &[LinkVariation], give: &mut impl FnMut(usize, Wrench)) {
        let segment = self.segment(links);
        let by = segment.vary(&self.ends, links, by);
        let [on_a, on_b] = self.varied(&segment, self.force(&segment), &by);
        give(0, on_a);
        give(1, on_b);
    }

    fn in_one_place(&self, links: &[LinkMotion], within: f64) -> bool {
        self.length != 0.0 && self.segment(links).distance <= within
    }

    /// The segment and its force are the same for each of them.
    fn vary_each(
        &self,
        links: &[LinkMotion],
        _by: &mut [LinkVariation],
        (link, variations): (usize, &[LinkVariation]),
        give: &mut impl FnMut(usize, usize, Wrench),
    ) {
        let segment = self.segment(links);
        let force = self.force(&segment);
        for (index, variation) in variations.iter().enumerate() {
            let by = segment.vary_with(&self.ends, links, (link, variation));
            let [on_a, on_b] = self.varied(&segment, force, &by);
            give(index, 0, on_a);
            give(index, 1, on_b);
        }
    }

    fn potential(&self, links: &[LinkMotion]) -> f64 {
        0.5 * self.stiffness * (self.segment(links).distance - self.length).powi(2)
    }

    fn dissipated(&self, links: &[LinkMotion]) -> f64 {
        let rate = self.segment(links).rate;
        self.damping * rate * rate
    }

    fn has_damping(&self) -> bool {
        self.damping != 0.0
    }

    fn magnitude(&self, links: &[LinkMotion]) -> Magnitude {
        let segment = self.segment(links);
        Magnitude {
            force: self.force(&segment).norm(),
            noise: self.stiffness * (segment.points[0].position.norm() + segment.points[1].position.norm() + self.length),
            stiffness: self.stiffness,
            ..Magnitude::default()
        }
    }

    fn is_line(&self) -> bool {
        true
    }

    fn pull(&self, links: &[LinkMotion]) -> f64 {
        let segment = self.segment(links);
        self.stiffness * (segment.distance - self.length) + self.damping * segment.rate
    }

    fn length(&self, links: &[LinkMotion]) -> f64 {
        self.segment(links).distance
    }

    fn vary_line(&self, links: &[LinkMotion], by: &[LinkVariation]) -> [f64; 2] {
        let by = self.segment(links).vary(&self.ends, links, by);
        [by.distance, self.stiffness * by.distance + self.damping * by.rate]
    }

    fn picture(&self) -> Picture<'_> {
        let spring = LineKind::Spring { stiffness: self.stiffness, length: self.length };
        Picture::Line { through: &self.ends, kind: if self.stiffness > 0.0 { spring } else { LineKind::Damper } }
    }
}

impl SpringLaw {
    /// Its ends, and stiffness (N/m), length (m) and damping (N s/m).
    pub(super) fn numbers(&self) -> ([End; 2], [f64; 3]) {
        (self.ends, [self.stiffness, self.length, self.damping])
    }

    #[inline]
    fn segment(&self, links: &[LinkMotion]) -> Segment {
        let segment = Segment::of(&self.ends, links);
        if segment.distance == 0.0 && self.length == 0.0 { segment.touching() } else { segment }
    }

    /// The variation of what it pulls with, from its segment and the force there.
    #[inline]
    fn varied(&self, segment: &Segment, force: Vector3<f64>, by: &SegmentVariation) -> [Wrench; 2] {
        let varied = self.stiffness * (by.between - self.length * by.direction)
            + self.damping * (by.rate * segment.direction + segment.rate * by.direction);
        segment.vary_pull(by, force, varied)
    }

    /// Force on the first end.
    #[inline]
    fn force(&self, segment: &Segment) -> Vector3<f64> {
        let elastic = self.stiffness * (segment.between - self.length * segment.direction);
        elastic + self.damping * segment.rate * segment.direction
    }
}
