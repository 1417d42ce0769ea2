//! A rope: pulls, never pushes, along the path through its points, and slides through the inner ones without friction.
//!
//! ```text
//! x_i = p_{i+1} − p_i,  d_i = |x_i|,  u_i = x_i / d_i            one segment from each point to the next
//! (1) e = Σ d_i − L₀,   ė = Σ u_i · (v_{i+1} − v_i)
//! (2) T = max(0, k e + c ė)                                      the same tension in every segment
//! (3) force on point i:  T (u_i − u_{i−1})                       at the first and last point of one segment only
//! (4) δT = k δe + c δė where T > 0, else 0,   δu_i = (1 − u_i u_iᵀ) δx_i / d_i
//! (5) potential ½ k max(0, e)²;   dissipated T ė − k max(0, e) ė ≥ 0
//! (6) boundaries: e + (c/k) ė = 0, from slack to taut;  e = 0, to a path longer than L₀
//! ```
//!
//! (2) is continuous: a damped rope that is pulled out fast begins to pull shortly before its path is as long as it is.
//! A segment without length has no direction: then the force is not a number, which stops whoever asked.

use super::elastic;
use super::end::Anchor;
use super::segment::Segment;
use super::{Act, Attachment, Carrier, Describe, End, ForceDescription, LineKind, Magnitude, Picture, Report, Switch};
use crate::spatial::Wrench;
use crate::spatial::link::{LinkMotion, LinkVariation};
use nalgebra::Vector3;

/// Tension `max(0, k (path − length) + c d(path)/dt)` along the path through its points.
#[derive(Debug, Clone, PartialEq)]
pub struct Rope {
    /// Its points in their order, two or more.
    pub through: Vec<Attachment>,
    /// Stiffness (N/m), > 0.
    pub stiffness: f64,
    /// Unstretched length (m), > 0.
    pub length: f64,
    /// Damping (N s/m), ≥ 0.
    pub damping: f64,
}

/// A rope, compiled.
#[derive(Debug, Clone)]
pub struct RopeLaw {
    ends: Vec<End>,
    stiffness: f64,
    length: f64,
    damping: f64,
    /// The sides of the boundaries (6) on which it is kept; `None` to take those of each state.
    kept: Option<Sides>,
}

/// On which sides of the boundaries (6) a rope is.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sides {
    /// T > 0
    taut: bool,
    /// e > 0
    long: bool,
}

/// The index of the boundary from slack to taut.
const TAUT: usize = 0;
/// The index of the boundary to a path longer than the rope; a rope without damping crosses both at once and has only the
/// first.
const LONG: usize = 1;

impl ForceDescription {
    /// A rope through two or more points: stiffness (N/m), unstretched length (m), damping (N s/m).
    pub fn rope(name: &str, through: Vec<Attachment>, stiffness: f64, length: f64, damping: f64) -> Self {
        Self { name: name.to_owned(), kind: Rope { through, stiffness, length, damping }.into() }
    }
}

impl Describe for Rope {
    type Law = RopeLaw;

    fn attachments(&self) -> Vec<(String, &Attachment)> {
        self.through.iter().enumerate().map(|(i, at)| (format!("through[{i}]"), at)).collect()
    }

    fn check(&self, report: &mut Report<'_>) {
        let name = report.name;
        report.positive("stiffness", self.stiffness, "N/m");
        report.positive("length", self.length, "m");
        report.not_negative("damping", self.damping, "N s/m");
        match &self.through[..] {
            [] | [_] => {
                let message = format!("`{name}` goes through {} point", self.through.len());
                report.add("through", message, "a rope needs two points or more");
            }
            [first, others @ ..] if others.iter().all(|at| at.body == first.body) => {
                let message = format!("all points of `{name}` are on `{}`", first.body);
                report.add("through", message, "a rope within one rigid body does nothing");
            }
            _ => {}
        }
    }

    fn check_places(&self, places: &[(Option<usize>, Vector3<f64>)], report: &mut Report<'_>) {
        for (i, pair) in places.windows(2).enumerate() {
            if pair[0] == pair[1] {
                let message = format!("`{}` goes through the same point twice in a row", report.name);
                report.add(&format!("through[{}]", i + 1), message, "a segment without length has no direction");
            }
        }
    }

    fn compile(&self, carriers: &[Carrier]) -> RopeLaw {
        let Self { stiffness, length, damping, .. } = *self;
        let ends = carriers.iter().map(|carrier| carrier.end).collect();
        RopeLaw { ends, stiffness, length, damping, kept: None }
    }

    fn numbers(&self, key: &str) -> Vec<(f64, &'static str)> {
        elastic::numbers(self.stiffness, self.length, key)
    }

    fn set(&mut self, key: &str, _index: usize, value: f64) {
        elastic::set(&mut self.stiffness, &mut self.length, key, value);
    }
}

impl Act for RopeLaw {
    fn ends(&self) -> &[End] {
        &self.ends
    }

    fn wrenches(&self, links: &[LinkMotion], give: &mut impl FnMut(usize, Wrench)) {
        let stretch = self.stretch(links);
        if !stretch.sides(self).taut {
            return;
        }
        let tension = stretch.pull(self);
        for (i, segment) in self.segments(links).enumerate() {
            let [on_a, on_b] = segment.pull(tension * segment.direction);
            give(i, on_a);
            give(i + 1, on_b);
        }
    }

    fn vary(&self, links: &[LinkMotion], by: &[LinkVariation], give: &mut impl FnMut(usize, Wrench)) {
        let stretch = self.stretch(links);
        if !stretch.sides(self).taut {
            return;
        }
        let tension = stretch.pull(self);
        let segments = || {
            self.segments(links).zip(self.ends.windows(2)).map(|(segment, pair)| (segment, segment.vary(pair, links, by)))
        };
        let change: f64 = segments().map(|(_, by)| self.stiffness * by.distance + self.damping * by.rate).sum();
        for (i, (segment, by)) in segments().enumerate() {
            let force = change * segment.direction + tension * by.direction;
            let [on_a, on_b] = segment.vary_pull(&by, tension * segment.direction, force);
            give(i, on_a);
            give(i + 1, on_b);
        }
    }

    fn potential(&self, links: &[LinkMotion]) -> f64 {
        0.5 * self.stiffness * self.stretch(links).stored(self).powi(2)
    }

    fn dissipated(&self, links: &[LinkMotion]) -> f64 {
        let stretch = self.stretch(links);
        (stretch.tension(self) - self.stiffness * stretch.stored(self)) * stretch.rate
    }

    fn has_damping(&self) -> bool {
        self.damping != 0.0
    }

    fn magnitude(&self, links: &[LinkMotion]) -> Magnitude {
        let stretch = self.stretch(links);
        let (tension, taut) = (stretch.tension(self), stretch.sides(self).taut);
        let reach: f64 = self.ends.iter().map(|end| Anchor::of(end, links).position.norm()).sum();
        Magnitude {
            // Both segments at an inner point pull.
            force: 2.0 * tension,
            noise: if taut { self.stiffness * (2.0 * reach + self.length) } else { 0.0 },
            stiffness: if taut { self.stiffness } else { 0.0 },
            ..Magnitude::default()
        }
    }

    fn not_finite(&self, links: &[LinkMotion]) -> Option<&'static str> {
        (!self.stretch(links).tension(self).is_finite()).then_some("the tension")
    }

    fn in_one_place(&self, links: &[LinkMotion], within: f64) -> bool {
        self.segments(links).any(|segment| segment.distance <= within)
    }

    fn switches(&self) -> Option<[&'static str; 2]> {
        Some(["slack", "taut"])
    }

    fn is_uneven(&self) -> bool {
        true
    }

    fn boundaries(&self) -> [Option<usize>; 4] {
        [Some(TAUT), self.has_damping().then_some(LONG), None, None]
    }

    fn switch(&self, boundary: usize, links: &[LinkMotion]) -> Switch {
        let Stretch { extension, rate } = self.stretch(links);
        let (value, known) = match boundary {
            TAUT => (extension + self.damping / self.stiffness * rate, !self.has_damping()),
            _ => (extension, true),
        };
        let (at, rate_of_value) = (self.length + extension, if known { rate } else { 0.0 });
        Switch { value, rate: rate_of_value, is_speed: false, at, speed: rate, size: None }
    }

    fn keep(&mut self, links: &[LinkMotion]) {
        let stretch = self.stretch(links);
        self.kept = None;
        self.kept = Some(stretch.sides(self));
    }

    fn side(&self, boundary: usize) -> bool {
        self.kept.is_some_and(|sides| if boundary == TAUT { sides.taut } else { sides.long })
    }

    fn cross(&mut self, boundary: usize) {
        let undamped = !self.has_damping();
        if let Some(Sides { taut, long }) = &mut self.kept {
            match boundary {
                TAUT => *taut = !*taut,
                _ => *long = !*long,
            }
            if undamped {
                *long = *taut;
            }
        }
    }

    fn pull_name(&self) -> Option<&'static str> {
        Some("tension")
    }

    fn is_line(&self) -> bool {
        true
    }

    fn pull(&self, links: &[LinkMotion]) -> f64 {
        self.stretch(links).tension(self)
    }

    fn length(&self, links: &[LinkMotion]) -> f64 {
        self.segments(links).map(|segment| segment.distance).sum()
    }

    fn vary_line(&self, links: &[LinkMotion], by: &[LinkVariation]) -> [f64; 2] {
        let varied = self.segments(links).zip(self.ends.windows(2)).map(|(segment, pair)| segment.vary(pair, links, by));
        let [length, rate] = varied.fold([0.0; 2], |[length, rate], by| [length + by.distance, rate + by.rate]);
        let taut = self.stretch(links).sides(self).taut;
        [length, if taut { self.stiffness * length + self.damping * rate } else { 0.0 }]
    }

    fn picture(&self) -> Picture<'_> {
        let kind = LineKind::Rope { stiffness: self.stiffness, length: self.length };
        Picture::Line { through: &self.ends, kind }
    }
}

/// How long the path of a rope is, (1).
#[derive(Debug, Clone, Copy, Default)]
struct Stretch {
    /// e
    extension: f64,
    /// ė
    rate: f64,
}

impl Stretch {
    /// `k e + c ė`
    fn pull(&self, law: &RopeLaw) -> f64 {
        law.stiffness * self.extension + law.damping * self.rate
    }

    /// Where the rope is kept, or is at this state; what is not a number counts as taut, so that it is seen.
    fn sides(&self, law: &RopeLaw) -> Sides {
        law.kept.unwrap_or_else(|| Sides { taut: !(self.pull(law) <= 0.0), long: !(self.extension <= 0.0) })
    }

    /// (2)
    fn tension(&self, law: &RopeLaw) -> f64 {
        if self.sides(law).taut { self.pull(law) } else { 0.0 }
    }

    /// The extension that stores energy, `max(0, e)`.
    fn stored(&self, law: &RopeLaw) -> f64 {
        if self.sides(law).long { self.extension } else { 0.0 }
    }
}

impl RopeLaw {
    fn segments(&self, links: &[LinkMotion]) -> impl Iterator<Item = Segment> {
        self.ends.windows(2).map(|pair| Segment::of(pair, links))
    }

    fn stretch(&self, links: &[LinkMotion]) -> Stretch {
        let start = Stretch { extension: -self.length, rate: 0.0 };
        self.segments(links).fold(start, |sum, segment| Stretch {
            extension: sum.extension + segment.distance,
            rate: sum.rate + segment.rate,
        })
    }
}
