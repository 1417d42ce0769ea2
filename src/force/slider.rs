//! A point that slides along a beam, pressed onto its axis by a spring and a damper across it.
//!
//! Between two nodes of the beam, a and b, of tangents `t` and an element of length `l` apart, the axis is the cubic through
//! both with these tangents (Hermite; off by `l⁴`):
//!
//! ```text
//! (1) c(u) = h₀₀ p_a + h₁₀ l t_a + h₀₁ p_b + h₁₁ l t_b,      0 ≤ u ≤ 1
//! (2) d = x − c(u),   d · c′(u) = 0                          u: the nearest point of the axis
//! (3) w = v_x − ċ|_u − ω(u) × d,   ω(u) = (1 − u) ω_a + u ω_b,   τ = c′ / |c′|
//! (4) F = −k d − c (w − τ τ·w)                               on the point; potential ½ k d², dissipated c |w − τ τ·w|²
//! (5) on node a: −h₀₀ F and the couple −l h₁₀ t_a × F − (1 − u) d × F;   on b: −h₀₁ F, −l h₁₁ t_b × F − u d × F
//! (6) δu = ((δx − δc|_u) · c′ + d · δc′|_u) / (c′·c′ − d·c″)
//! (7) boundaries: u = 0 at the node where an element begins, to the element before; at both ends of the beam, to none
//! ```
//!
//! All of (5) together balances `F` at `x`. By (2) the force follows from the potential alone. A point that has come past an end
//! of the beam is free, and stays so in a run.

mod place;

use super::end::Anchor;
use super::{Act, Attachment, Carrier, Describe, End, ForceDescription, Magnitude, Picture, Report, Switch, Within};
use crate::force::Point;
use crate::spatial::Wrench;
use crate::spatial::link::{LinkMotion, LinkVariation};
use nalgebra::Vector3;
use place::{Node, Place};

/// Presses a point onto the axis of a beam, along which it slides.
#[derive(Debug, Clone, PartialEq)]
pub struct Slider {
    /// The point.
    pub on: Attachment,
    /// The name of the beam or cable.
    pub along: String,
    /// Stiffness across the axis (N/m), > 0.
    pub stiffness: f64,
    /// Damping across the axis (N s/m), ≥ 0.
    pub damping: f64,
    /// The nodes of the beam, from its root: known once it has been taken apart into elements.
    pub(crate) nodes: Vec<Attachment>,
    /// How far each node is from the root, along the unstrained beam (m).
    pub(crate) stations: Vec<f64>,
}

/// A slider, compiled.
#[derive(Debug, Clone)]
pub struct SliderLaw {
    /// The point, then the nodes.
    ends: Vec<End>,
    /// The axis of the beam at each node, in the axes of its link.
    axes: Vec<Vector3<f64>>,
    stations: Vec<f64>,
    stiffness: f64,
    damping: f64,
    kept: Kept,
}

/// Where a slider is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kept {
    /// Nowhere: it takes the element of each state.
    No,
    /// On an element.
    On(usize),
    /// Beyond an end of the beam.
    Off,
}

/// A point that is beyond an end of the beam by less than this part of its length is on it.
const SAME: f64 = 1e-9;

/// The index of the boundary that the ends of the beam are; that of inner node `i` is `i`.
const ENDS: usize = 0;

impl ForceDescription {
    /// A point that slides along a beam: stiffness (N/m) and damping (N s/m) across its axis.
    pub fn slider(name: &str, on: impl Into<Attachment>, along: &str, stiffness: f64, damping: f64) -> Self {
        let kind = Slider::new(on.into(), along.to_owned(), stiffness, damping);
        Self { name: name.to_owned(), kind: kind.into() }
    }
}

impl Slider {
    /// A point that slides along the beam of a name: stiffness (N/m) and damping (N s/m) across its axis.
    pub fn new(on: Attachment, along: String, stiffness: f64, damping: f64) -> Self {
        Self { on, along, stiffness, damping, nodes: Vec::new(), stations: Vec::new() }
    }

    /// Finds the nodes of its beam: the bodies where elements begin and end, and how far each is from the root (m).
    pub(crate) fn lay(&mut self, nodes: impl Iterator<Item = (String, f64)>) {
        let at_root = |body| Attachment { body, point: Point::Marker("root".to_owned()) };
        (self.nodes, self.stations) = nodes.map(|(body, station)| (at_root(body), station)).unzip();
    }
}

impl Describe for Slider {
    type Law = SliderLaw;

    fn attachments(&self) -> Vec<(String, &Attachment)> {
        let nodes = self.nodes.iter().map(|node| ("along".to_owned(), node));
        std::iter::once(("on".to_owned(), &self.on)).chain(nodes).collect()
    }

    fn check(&self, report: &mut Report<'_>) {
        report.positive("stiffness", self.stiffness, "N/m");
        report.not_negative("damping", self.damping, "N s/m");
        if self.on.body == self.along {
            let message = format!("`{}` slides along `{}` and is on it, too", report.name, self.along);
            report.add("on", message, "give a point of another body");
        }
    }

    fn compile(&self, carriers: &[Carrier]) -> SliderLaw {
        SliderLaw {
            ends: carriers.iter().map(|carrier| carrier.end).collect(),
            axes: carriers[1..].iter().map(|carrier| carrier.turn * Vector3::x()).collect(),
            stations: self.stations.clone(),
            stiffness: self.stiffness,
            damping: self.damping,
            kept: Kept::No,
        }
    }

    fn numbers(&self, key: &str) -> Vec<(f64, &'static str)> {
        match key {
            "stiffness" => vec![(self.stiffness, "N/m")],
            _ => Vec::new(),
        }
    }

    fn set(&mut self, _key: &str, _index: usize, value: f64) {
        self.stiffness = value;
    }
}

impl Act for SliderLaw {
    fn ends(&self) -> &[End] {
        &self.ends
    }

    fn wrenches(&self, links: &[LinkMotion], give: &mut impl FnMut(usize, Wrench)) {
        let Some(place) = self.place(links) else { return };
        let force = place.force(self);
        give(0, Wrench::at_arm(force, place.point.arm));
        for (i, node) in place.nodes.iter().enumerate() {
            let [weight, slope] = place.weights(0, i);
            let couple = slope * node.tangent.cross(&force) + place.share(i) * place.across.cross(&force);
            let mut wrench = Wrench::at_arm(-weight * force, node.anchor.arm);
            wrench.moment -= couple;
            give(1 + place.element + i, wrench);
        }
    }

    fn vary(&self, links: &[LinkMotion], by: &[LinkVariation], give: &mut impl FnMut(usize, Wrench)) {
        let Some(place) = self.place(links) else { return };
        let varied = place.vary(self, links, by);
        let (force, by_force) = (place.force(self), varied.force);
        give(0, vary_at_arm(force, place.point.arm, by_force, varied.point.arm));
        for (i, node) in place.nodes.iter().enumerate() {
            let ([weight, slope], [by_weight, by_slope]) = (place.weights(0, i), place.weights(1, i).map(|w| varied.u * w));
            let (share, by_share) = (place.share(i), if i == 0 { -varied.u } else { varied.u });
            let on_node = &varied.nodes[i];
            let by_couple = by_slope * node.tangent.cross(&force)
                + slope * (on_node.tangent.cross(&force) + node.tangent.cross(&by_force))
                + by_share * place.across.cross(&force)
                + share * (varied.across.cross(&force) + place.across.cross(&by_force));
            let by_push = -weight * by_force - by_weight * force;
            let mut wrench = vary_at_arm(-weight * force, node.anchor.arm, by_push, on_node.anchor.arm);
            wrench.moment -= by_couple;
            give(1 + place.element + i, wrench);
        }
    }

    fn potential(&self, links: &[LinkMotion]) -> f64 {
        self.place(links).map_or(0.0, |place| 0.5 * self.stiffness * place.across.norm_squared())
    }

    fn dissipated(&self, links: &[LinkMotion]) -> f64 {
        self.place(links).map_or(0.0, |place| self.damping * place.rate().norm_squared())
    }

    fn has_damping(&self) -> bool {
        self.damping != 0.0
    }

    fn magnitude(&self, links: &[LinkMotion]) -> Magnitude {
        let Some(place) = self.place(links) else { return Magnitude::default() };
        let reach: f64 = place.point.position.norm() + place.nodes.iter().map(|node| node.anchor.position.norm()).sum::<f64>();
        Magnitude {
            force: place.force(self).norm(),
            moment: place.nodes[0].tangent.norm() * place.force(self).norm(),
            noise: self.stiffness * reach,
            noise_moment: self.stiffness * reach * place.nodes[0].tangent.norm(),
            stiffness: self.stiffness,
            ..Magnitude::default()
        }
    }

    fn switches(&self) -> Option<[&'static str; 2]> {
        Some(["exit", "entry"])
    }

    fn is_uneven(&self) -> bool {
        true
    }

    fn boundaries(&self) -> [Option<usize>; 4] {
        let element = match self.kept {
            Kept::On(element) => element,
            // Any of them, of an element that is not known yet.
            Kept::No => return [Some(ENDS), None, None, None],
            Kept::Off => return [None; 4],
        };
        let (is_first, is_last) = (element == 0, element + 1 == self.elements());
        [(is_first || is_last).then_some(ENDS), (!is_first).then_some(element), (!is_last).then_some(element + 1), None]
    }

    fn switch(&self, boundary: usize, links: &[LinkMotion]) -> Switch {
        let Some(place) = self.place(links) else { return Switch::default() };
        let (at, speed, length) = (place.station(self), place.speed(), self.stations[self.elements()]);
        let (value, rate) = match boundary {
            ENDS if at < length - at => (at, speed),
            ENDS => (length - at, -speed),
            node => (at - self.stations[node], speed),
        };
        Switch { value, rate, is_speed: false, size: None, at, speed }
    }

    fn keep(&mut self, links: &[LinkMotion]) {
        self.kept = Kept::No;
        self.kept = self.place(links).map_or(Kept::Off, |place| Kept::On(place.element));
    }

    fn side(&self, boundary: usize) -> bool {
        match self.kept {
            Kept::On(element) => boundary <= element,
            Kept::No | Kept::Off => false,
        }
    }

    fn cross(&mut self, boundary: usize) {
        let Kept::On(element) = self.kept else { return };
        self.kept = match boundary {
            ENDS => Kept::Off,
            node if node <= element => Kept::On(node - 1),
            node => Kept::On(node),
        };
    }

    fn pull_name(&self) -> Option<&'static str> {
        Some("side force")
    }

    fn is_line(&self) -> bool {
        true
    }

    fn pull(&self, links: &[LinkMotion]) -> f64 {
        self.place(links).map_or(0.0, |place| place.force(self).norm())
    }

    fn length(&self, links: &[LinkMotion]) -> f64 {
        self.place(links).map_or_else(|| self.nearer_end(links), |place| place.station(self))
    }

    fn vary_line(&self, links: &[LinkMotion], by: &[LinkVariation]) -> [f64; 2] {
        let Some(place) = self.place(links) else { return [0.0; 2] };
        let (varied, force) = (place.vary(self, links, by), place.force(self));
        let pull = if force == Vector3::zeros() { 0.0 } else { force.normalize().dot(&varied.force) };
        [varied.u * place.length(self), pull]
    }

    fn within(&self, tip: usize, links: &[LinkMotion]) -> Option<Within> {
        let place = self.place(links).filter(|place| self.ends[2 + place.element].link == tip)?;
        let mut on = [Wrench::ZERO; 2];
        self.wrenches(links, &mut |end, wrench| {
            if end > 0 {
                on[end - 1 - place.element] = wrench;
            }
        });
        Some(Within { at: place.u * place.length(self), root: self.ends[1 + place.element].link, on })
    }

    fn picture(&self) -> Picture<'_> {
        Picture::Nothing
    }
}

impl SliderLaw {
    /// How far the point is beside the axis (m); `None` beyond the ends of the beam.
    pub fn beside(&self, links: &[LinkMotion]) -> Option<f64> {
        self.place(links).map(|place| place.across.norm())
    }

    /// The unstrained length of the beam (m).
    pub fn beam_length(&self) -> f64 {
        self.stations[self.elements()]
    }

    fn elements(&self) -> usize {
        self.axes.len() - 1
    }

    /// Where it is kept or, if it is not, on the element of which its point is nearest; `None` beyond the ends of the beam.
    fn place(&self, links: &[LinkMotion]) -> Option<Place> {
        match self.kept {
            Kept::On(element) => Some(self.on_element(element, links)),
            Kept::Off => None,
            Kept::No => {
                let point = Anchor::of(&self.ends[0], links).position;
                // How far the point is beyond a node.
                let beyond = |i: usize| {
                    let node = &self.ends[1 + i];
                    let axis = links[node.link].turn * self.axes[i];
                    axis.dot(&(point - Anchor::of(node, links).position))
                };
                let (last, slack) = (self.elements(), SAME * self.stations[self.elements()]);
                let from = |i: usize| beyond(i) >= if i == 0 { -slack } else { 0.0 };
                let to = |i: usize| beyond(i) <= if i == last { slack } else { 0.0 };
                let candidates = (0..last).filter(|element| from(*element) && to(element + 1));
                let places = candidates.map(|element| self.on_element(element, links));
                places.min_by(|a, b| a.across.norm_squared().total_cmp(&b.across.norm_squared()))
            }
        }
    }

    /// How far the end of the beam that is nearer to the point is from the root (m).
    fn nearer_end(&self, links: &[LinkMotion]) -> f64 {
        let at = |i: usize| Anchor::of(&self.ends[i], links).position;
        let distance = |i: usize| (at(i) - at(0)).norm();
        if distance(1) < distance(1 + self.elements()) { 0.0 } else { self.stations[self.elements()] }
    }

    /// (1) to (3) on an element, and on the same cubic beyond its nodes.
    fn on_element(&self, element: usize, links: &[LinkMotion]) -> Place {
        let length = self.stations[element + 1] - self.stations[element];
        let node = |i: usize| {
            let (end, axis) = (&self.ends[1 + element + i], &self.axes[element + i]);
            let link = &links[end.link];
            Node::of(Anchor::of(end, links), length * (link.turn * axis), link.angular_velocity)
        };
        Place::of(element, Anchor::of(&self.ends[0], links), [node(0), node(1)])
    }
}

/// How the wrench of a force at an arm varies.
fn vary_at_arm(force: Vector3<f64>, arm: Vector3<f64>, by_force: Vector3<f64>, by_arm: Vector3<f64>) -> Wrench {
    Wrench { force: by_force, moment: arm.cross(&by_force) + by_arm.cross(&force) }
}
