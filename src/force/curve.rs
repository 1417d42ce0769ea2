//! A spring and damper by tables, along the line between two points.
//!
//! ```text
//! x = x_b − x_a,  L = |x|,  u = x / L
//! pull  F = f(L − L₀) + g(L̇),   L̇ = u·(v_b − v_a)
//! force on a: +F u,  on b: −F u;   potential ∫₀ f + g(0) (L − L₀),   dissipated (g(L̇) − g(0)) L̇
//! ```
//!
//! What a damper's table pulls with at rest is a constant pull, which has a potential. The tables are read as
//! [`super::table`] says; one read straight from point to point has kinks, at which the tangent is that of longer or faster.
//! They are the boundaries of its law: 2 k that at point k of the extension, 2 k + 1 that at point k of the rate.

use super::segment::Segment;
use super::table::{Interpolation, Table};
use super::{Act, Attachment, Carrier, Describe, End, ForceDescription, LineKind, Magnitude, Picture, Report, Switch};
use crate::spatial::Wrench;
use crate::spatial::link::{LinkMotion, LinkVariation};
use nalgebra::Vector3;

/// Along the line between two points: pull by extension plus pull by its rate.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// The two ends.
    pub between: [Attachment; 2],
    /// Points of extension (m), increasing, and pull (N); empty for none.
    pub extension: Vec<[f64; 2]>,
    /// Points of the extension's rate (m/s), increasing, and pull (N); empty for none.
    pub rate: Vec<[f64; 2]>,
    /// Between the points.
    pub interpolation: Interpolation,
    /// The distance of the ends at which the extension is zero (m), ≥ 0.
    pub length: f64,
}

/// A curve, compiled.
#[derive(Debug, Clone)]
pub struct CurveLaw {
    ends: [End; 2],
    extension: Option<Table>,
    rate: Option<Table>,
    length: f64,
    /// What the table of the rate pulls with at rest.
    at_rest: f64,
}

impl ForceDescription {
    /// A spring by a table of extension (m) and pull (N) between two points, of this unstretched length (m); smooth.
    pub fn curve(
        name: &str,
        from: impl Into<Attachment>,
        to: impl Into<Attachment>,
        extension: Vec<[f64; 2]>,
        length: f64,
    ) -> Self {
        let (between, interpolation) = ([from.into(), to.into()], Interpolation::Smooth);
        let kind = Curve { between, extension, rate: Vec::new(), interpolation, length };
        Self { name: name.to_owned(), kind: kind.into() }
    }
}

impl Describe for Curve {
    type Law = CurveLaw;

    fn attachments(&self) -> Vec<(String, &Attachment)> {
        (0..2).map(|i| (format!("between[{i}]"), &self.between[i])).collect()
    }

    fn check(&self, report: &mut Report<'_>) {
        let name = report.name;
        for (what, points) in [("extension", &self.extension), ("rate", &self.rate)] {
            if let Some(bad) = Table::check(points).filter(|_| !points.is_empty()) {
                let key = bad.index.map_or(format!("force.{what}"), |index| format!("force.{what}[{index}]"));
                report.add(&key, format!("the curve of `{name}` {}", bad.message), bad.help);
            }
        }
        if self.extension.is_empty() && self.rate.is_empty() {
            report.add("force", format!("`{name}` has no points"), "a curve needs two points or more");
        }
        report.not_negative("length", self.length, "m");
        report.apart(&self.between, "a curve");
    }

    fn compile(&self, carriers: &[Carrier]) -> CurveLaw {
        let table = |points: &[[f64; 2]]| (!points.is_empty()).then(|| Table::new(points, self.interpolation));
        let (extension, rate) = (table(&self.extension), table(&self.rate));
        let at_rest = rate.as_ref().map_or(0.0, |table| table.value(0.0)[0]);
        CurveLaw { ends: [carriers[0].end, carriers[1].end], extension, rate, length: self.length, at_rest }
    }

    fn numbers(&self, key: &str) -> Vec<(f64, &'static str)> {
        if key == "length" { vec![(self.length, "m")] } else { Vec::new() }
    }

    fn set(&mut self, _key: &str, _index: usize, value: f64) {
        self.length = value;
    }
}

impl Act for CurveLaw {
    fn ends(&self) -> &[End] {
        &self.ends
    }

    fn wrenches(&self, links: &[LinkMotion], give: &mut impl FnMut(usize, Wrench)) {
        let state = State::of(self, links);
        let [on_a, on_b] = state.segment.pull(state.force());
        give(0, on_a);
        give(1, on_b);
    }

    fn vary(&self, links: &[LinkMotion], by: &[LinkVariation], give: &mut impl FnMut(usize, Wrench)) {
        let state = State::of(self, links);
        let by = state.segment.vary(&self.ends, links, by);
        let ([_, stiffness], [_, damping]) = (state.elastic, state.damper);
        let force = if state.segment.distance == 0.0 {
            stiffness * by.between
        } else {
            (stiffness * by.distance + damping * by.rate) * state.segment.direction + state.pull() * by.direction
        };
        let [on_a, on_b] = state.segment.vary_pull(&by, state.force(), force);
        give(0, on_a);
        give(1, on_b);
    }

    fn potential(&self, links: &[LinkMotion]) -> f64 {
        let extension = State::of(self, links).segment.distance - self.length;
        self.extension.as_ref().map_or(0.0, |table| table.integral(extension)) + self.at_rest * extension
    }

    fn dissipated(&self, links: &[LinkMotion]) -> f64 {
        State::of(self, links).damping_power().max(0.0)
    }

    fn input(&self, links: &[LinkMotion]) -> f64 {
        (-State::of(self, links).damping_power()).max(0.0)
    }

    fn has_damping(&self) -> bool {
        self.rate.is_some()
    }

    fn magnitude(&self, links: &[LinkMotion]) -> Magnitude {
        let state = State::of(self, links);
        let ([force, stiffness], [damper, _]) = (state.elastic, state.damper);
        let [a, b] = &state.segment.points;
        let reach = a.position.norm() + b.position.norm() + self.length;
        Magnitude {
            force: (force + damper).abs(),
            noise: force.abs() + damper.abs() + stiffness.abs() * reach,
            stiffness: stiffness.abs(),
            ..Magnitude::default()
        }
    }

    fn is_uneven(&self) -> bool {
        true
    }

    fn boundaries(&self) -> [Option<usize>; 4] {
        let kinks = |table: &Option<Table>| table.as_ref().map_or([None; 2], Table::kinks);
        let ([a, b], [c, d]) = (kinks(&self.extension), kinks(&self.rate));
        [a.map(|k| 2 * k), b.map(|k| 2 * k), c.map(|k| 2 * k + 1), d.map(|k| 2 * k + 1)]
    }

    fn switch(&self, boundary: usize, links: &[LinkMotion]) -> Switch {
        let Segment { distance, rate, .. } = State::of(self, links).segment;
        let (is_speed, extension) = (boundary % 2 == 1, distance - self.length);
        let kink = self.table(boundary).map_or(f64::NAN, |table| table.kink(boundary / 2));
        let (value, of_value) = if is_speed { (rate - kink, 0.0) } else { (extension - kink, rate) };
        Switch { value, rate: of_value, is_speed, at: extension, speed: rate, size: None }
    }

    fn keep(&mut self, links: &[LinkMotion]) {
        let Segment { distance, rate, .. } = State::of(self, links).segment;
        let extension = distance - self.length;
        self.extension.iter_mut().for_each(|table| table.keep(extension));
        self.rate.iter_mut().for_each(|table| table.keep(rate));
    }

    fn side(&self, boundary: usize) -> bool {
        self.table(boundary).is_some_and(|table| table.side(boundary / 2))
    }

    fn cross(&mut self, boundary: usize) {
        let table = if boundary % 2 == 1 { &mut self.rate } else { &mut self.extension };
        table.iter_mut().for_each(|table| table.cross(boundary / 2));
    }

    fn pull_name(&self) -> Option<&'static str> {
        Some("pull")
    }

    fn is_line(&self) -> bool {
        true
    }

    fn pull(&self, links: &[LinkMotion]) -> f64 {
        State::of(self, links).pull()
    }

    fn length(&self, links: &[LinkMotion]) -> f64 {
        State::of(self, links).segment.distance
    }

    fn vary_line(&self, links: &[LinkMotion], by: &[LinkVariation]) -> [f64; 2] {
        let State { segment, elastic: [_, stiffness], damper: [_, damping], .. } = State::of(self, links);
        let by = segment.vary(&self.ends, links, by);
        [by.distance, stiffness * by.distance + damping * by.rate]
    }

    fn picture(&self) -> Picture<'_> {
        let spring = LineKind::Curved { length: self.length };
        Picture::Line { through: &self.ends, kind: if self.extension.is_some() { spring } else { LineKind::Damper } }
    }
}

impl CurveLaw {
    /// The table to which a boundary belongs.
    fn table(&self, boundary: usize) -> Option<&Table> {
        if boundary % 2 == 1 { self.rate.as_ref() } else { self.extension.as_ref() }
    }
}

/// A curve at one instant.
struct State<'a> {
    law: &'a CurveLaw,
    segment: Segment,
    /// f and g with their slopes.
    elastic: [f64; 2],
    damper: [f64; 2],
}

impl<'a> State<'a> {
    fn of(law: &'a CurveLaw, links: &[LinkMotion]) -> Self {
        let segment = Segment::of(&law.ends, links);
        let value = |table: &Option<Table>, x: f64| table.as_ref().map_or([0.0; 2], |table| table.value(x));
        let elastic = value(&law.extension, segment.distance - law.length);
        // Without a pull a point that lies on the other is pulled nowhere.
        let touching = segment.distance == 0.0 && elastic[0] + law.at_rest == 0.0;
        let segment = if touching { segment.touching() } else { segment };
        Self { law, segment, elastic, damper: value(&law.rate, segment.rate) }
    }

    fn pull(&self) -> f64 {
        self.elastic[0] + self.damper[0]
    }

    /// Force on the first end.
    fn force(&self) -> Vector3<f64> {
        self.pull() * self.segment.direction
    }

    /// `(g(L̇) − g(0)) L̇`
    fn damping_power(&self) -> f64 {
        (self.damper[0] - self.law.at_rest) * self.segment.rate
    }
}
