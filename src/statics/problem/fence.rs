//! Limits of hinges at which a search among loops, drives and gears halts, to go on with another set of stops that bear.
//!
//! Coordinates that are tied together follow each other, so that none of them can be cut at its limit by itself as in a tree (see
//! [`super::limits`]): the whole step is, where the first of them arrives,
//!
//! ```text
//! q(t) = q ⊞ t x, rows closed:     t ← t (limit − qᵢ)/(qᵢ(t) − qᵢ)   over the coordinates that are beyond, the least    (1)
//! ```
//!
//! (regula falsi): exactly for gears, and for loops in as many steps as their curvature asks for.

use super::Landscape;

/// Steps of (1): of a search step over which they do not converge to the slack, the trust region takes a shorter one.
const MOST: usize = 24;

/// A coordinate that is as near to its limit as so many slacks is brought onto it.
const NEAR: f64 = 1e3;

/// What a coordinate must not leave in a search.
#[derive(Debug, Clone, Copy)]
pub(in crate::statics) struct Gate {
    /// Index of the stop.
    pub stop: usize,
    /// Index into the position vector.
    pub position: usize,
    /// Lowest and highest value (m or rad).
    pub range: [f64; 2],
    /// How far beyond counts as within (m or rad).
    pub slack: f64,
}

impl Gate {
    /// By how much a value is beyond the range, towards the limit that it has passed; within the slack 0.
    fn beyond(&self, value: f64) -> f64 {
        let [low, high] = self.range;
        let off = if value > high { value - high } else { (value - low).min(0.0) };
        if off.abs() > self.slack { off } else { 0.0 }
    }

    /// Which part of the way between two values, the second beyond, is within.
    fn part(&self, from: f64, to: f64) -> f64 {
        let limit = if to > from { self.range[1] } else { self.range[0] };
        let within = if to > from { limit - from } else { from - limit };
        if within <= self.slack { 0.0 } else { (limit - from) / (to - from) }
    }

    /// Whether a value is nearly at an end of the range.
    fn is_at(&self, value: f64) -> bool {
        self.range.iter().any(|limit| (value - limit).abs() <= NEAR * self.slack)
    }
}

/// The gates, and the one that halted a search.
#[derive(Debug, Clone)]
pub(super) struct Fence {
    gates: Vec<Gate>,
    hit: Option<usize>,
}

/// A step up to a gate.
#[derive(Debug, Clone, Copy)]
pub(in crate::statics) struct Halt {
    /// The part of the step that leads there.
    pub part: f64,
    /// Its stop.
    pub stop: usize,
}

impl Landscape<'_> {
    /// Halts the search at these gates.
    pub(in crate::statics) fn fence(&mut self, gates: Vec<Gate>) {
        self.fence = Some(Box::new(Fence { gates, hit: None }));
    }

    /// Whether a position is beyond a gate.
    pub(super) fn is_beyond(&self, q: &[f64]) -> bool {
        self.fence.as_ref().is_some_and(|fence| fence.gates.iter().any(|gate| gate.beyond(q[gate.position]) != 0.0))
    }

    /// Where a step from `q` meets the first gate; `None` if it meets none, or if the loops bend too much to tell.
    pub(in crate::statics) fn halted(&mut self, q: &[f64], x: &[f64]) -> Option<Halt> {
        let fence = self.fence.take()?;
        let mut halt = None;
        for _ in 0..MOST {
            let part = halt.map_or(1.0, |halt: Halt| halt.part);
            let step: Vec<f64> = x.iter().map(|x| part * x).collect();
            let to = self.moved(q, &step);
            let beyond = fence.gates.iter().filter(|gate| gate.beyond(to[gate.position]) != 0.0);
            let parts = beyond.map(|gate| (part * gate.part(q[gate.position], to[gate.position]), gate.stop));
            let Some((part, stop)) = parts.min_by(|a, b| a.0.total_cmp(&b.0)) else { break };
            halt = Some(Halt { part, stop });
            if part == 0.0 {
                break;
            }
        }
        self.fence = Some(fence);
        halt
    }

    /// Halts the search if `q` is at the gate of a stop.
    pub(in crate::statics) fn halt_at(&mut self, stop: usize, q: &[f64]) {
        let Some(fence) = &mut self.fence else { return };
        let is_at = |gate: &Gate| gate.stop == stop && gate.is_at(q[gate.position]);
        fence.hit = fence.gates.iter().any(is_at).then_some(stop);
    }

    /// Lets the coordinates go beyond.
    pub(in crate::statics) fn unfence(&mut self) {
        self.fence = None;
    }

    /// The stop at whose gate the search has ended.
    pub(in crate::statics) fn halted_at(&self) -> Option<usize> {
        self.fence.as_ref()?.hit
    }
}
