//! Ends of the curves that bodies are guided along: nothing goes beyond them. An end that a rigid stop keeps a body from is none.

use super::{Link, Model, Side, Stop};
use crate::element::Rod;
use crate::round_off::ON_A_CURVE;

/// One end of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurveEnd {
    /// Index of the body whose hinge it is.
    pub body: usize,
    /// Index into the position vector.
    pub position: usize,
    /// Index into the velocity vector.
    pub velocity: usize,
    /// Arc length there (m).
    pub at: f64,
    /// Which end of the curve it is.
    pub side: Side,
    /// What rounding leaves of it (m).
    pub slack: f64,
}

impl CurveEnd {
    /// How far a coordinate is beyond it (m).
    pub fn beyond(&self, position: &[f64]) -> f64 {
        self.side.sign() * (position[self.position] - self.at)
    }
}

impl Model {
    /// The end of a curve that a position is beyond, by more than rounding.
    pub fn beyond_curve(&self, position: &[f64]) -> Option<&CurveEnd> {
        self.curve_ends.iter().find(|end| !(end.beyond(position) <= end.slack))
    }
}

/// The ends of all curves but for those behind a rigid stop.
pub(super) fn ends(links: &[Link], rods: &[Rod], stops: &[Stop]) -> Vec<CurveEnd> {
    let of_link = |link: &Link| {
        let [from, to] = rods[link.joint.rod()?].guide()?.range();
        let (body, position, velocity) = (link.body, link.position, link.velocity);
        let slack = ON_A_CURVE.of(to - from);
        Some(Side::ALL.map(|side| CurveEnd { body, position, velocity, at: side.of([from, to]), side, slack }))
    };
    let guarded = |end: &CurveEnd| {
        let behind = |stop: &Stop| end.side.sign() * (end.at - stop.limit(end.side));
        let rigid = |stop: &&Stop| stop.position == end.position && stop.is_rigid();
        stops.iter().filter(rigid).any(|stop| behind(stop) >= -end.slack)
    };
    links.iter().filter_map(of_link).flatten().filter(|end| !guarded(end)).collect()
}
