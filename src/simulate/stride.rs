//! How far a step may go so that nothing on its way is overlooked.
//!
//! Estimates of errors and searches for events look at a step in some of its places. Where nothing accelerates steps grow without bound, and
//! what lies between is passed: a shape on the rim of a wheel that coasts, a marker that crosses a plane twice in every turn, the bump of a
//! table. Where a scene has something that begins and ends somewhere, no coordinate goes further in a step than
//!
//! ```text
//! (1)  0.4 rad;   half the shortest interval of a table over it, or as far as that is away;   a twentieth of the scene's length, or 0.4 rad,
//!      under a formula of it, or a quarter of the way over which its parts change where that is longer (`formula/detail.rs`);
//!      along a curve to the end of the next of its pieces, which are as long as its tangent turns by 0.3 rad or as its shape is resolved
//! ```
//!
//! at the speeds with which the step begins, by powers of two: methods that pay for a change of step seldom change it for that.

use crate::element::guide::Guide;
use crate::force::Act;
use crate::model::{CurveOver, Link, Model, Watched};
use std::sync::Arc;

/// A turn within which what turns comes near something once at most (rad).
const TURN: f64 = 0.4;
/// Part of the scene's length along which a formula is looked at once.
const WAY: f64 = 0.05;
/// Part of the shortest way over which something in a formula comes and goes.
const DETAIL: f64 = 0.25;
/// Part of the shortest interval of a table.
const INTERVAL: f64 = 0.5;

/// How far coordinates may go in a step.
#[derive(Debug, Clone, Default)]
pub(super) struct Stride {
    /// Velocity coordinates, and how far each may go (m, rad).
    reaches: Vec<(usize, f64)>,
    /// Coordinates under tables.
    tables: Vec<Tabled>,
    /// Position and velocity coordinates along curves.
    guided: Vec<(usize, usize, Arc<Guide>)>,
}

/// A coordinate under a table.
#[derive(Debug, Clone)]
struct Tabled {
    position: usize,
    velocity: usize,
    /// Where the table begins and ends (m, rad).
    span: [f64; 2],
    /// How far the coordinate may go within it (m, rad).
    within: f64,
}

impl Tabled {
    /// How far it may go from a place: what begins further on is met by the step after this one.
    fn reach(&self, q: f64) -> f64 {
        let [first, last] = self.span;
        (first - q).max(q - last).max(self.within)
    }
}

impl Stride {
    pub(super) fn new(model: &Model) -> Self {
        let mut reaches = Vec::new();
        if is_watched(model) {
            let turns = |link: &&Link| !link.joint.is_distance() && !link.joint.is_flex();
            for link in model.links.iter().skip(1).filter(turns) {
                let own = link.velocity..link.velocity + link.joint.counts().1;
                reaches.extend(own.map(|velocity| (velocity, TURN)));
            }
        }
        let over_place = model.curves.iter().filter(|curve| curve.over == CurveOver::Position);
        let tables = over_place.map(|curve| Tabled {
            position: curve.coordinate.position,
            velocity: curve.coordinate.velocity,
            span: curve.table.span().map(|x| x + curve.rest),
            within: INTERVAL * curve.table.shortest_interval(),
        });
        let tables = tables.collect();
        for motor in model.motors.iter().filter(|motor| motor.is_of_place()) {
            let way = if motor.coordinate.slides { WAY * model.length_scale() } else { TURN };
            let way = way.max(DETAIL * motor.detail());
            if way.is_finite() {
                reaches.push((motor.coordinate.velocity, way));
            }
        }
        let guide = |link: &Link| {
            let guide = model.rods[link.joint.rod()?].guide()?;
            Some((link.position, link.velocity, Arc::clone(guide)))
        };
        let guided = model.links.iter().skip(1).filter_map(guide).collect();
        Self { reaches, tables, guided }
    }

    /// The longest step from a state (s).
    pub(super) fn longest(&self, q: &[f64], v: &[f64]) -> f64 {
        let times = self.reaches.iter().map(|(i, reach)| reach / v[*i].abs());
        let along = |(s, i, guide): &(usize, usize, Arc<Guide>)| guide.stretch(q[*s], v[*i] > 0.0) / v[*i].abs();
        let under = |table: &Tabled| table.reach(q[table.position]) / v[table.velocity].abs();
        let times = times.chain(self.tables.iter().map(under));
        let time = times.chain(self.guided.iter().map(along)).fold(f64::INFINITY, f64::min);
        if time.is_finite() && time > 0.0 { time.log2().floor().exp2() } else { f64::INFINITY }
    }
}

/// Whether it matters where bodies are between the places that a step looks at.
fn is_watched(model: &Model) -> bool {
    let far = |of: &Watched| !matches!(of, Watched::Position(_));
    !model.contacts.is_empty()
        || model.events.iter().any(|event| far(&event.of))
        || model.forces.iter().any(|force| force.law.is_uneven())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fastest_for_its_reach_says_how_long_a_step_may_be() {
        let stride = Stride { reaches: vec![(0, 0.4), (2, 0.1)], ..Stride::default() };
        // 0.01 s, and the power of two below it.
        assert_eq!(stride.longest(&[], &[40.0, 1e9, -2.0]), 0.007_812_5);
        assert_eq!(stride.longest(&[], &[0.0, 1e9, -2.0]), 0.031_25);
        assert_eq!(stride.longest(&[], &[0.0, 1e9, 0.0]), f64::INFINITY);
        assert_eq!(Stride::default().longest(&[], &[1.0]), f64::INFINITY);
    }

    /// A table is met wherever a coordinate comes from, and far from it nothing is held up.
    #[test]
    fn a_table_is_met_and_holds_nothing_up_that_is_far() {
        let table = Tabled { position: 0, velocity: 0, span: [1.0, 1.5], within: 0.125 };
        let stride = Stride { tables: vec![table], ..Stride::default() };
        for (q, longest) in [(-3.0, 4.0), (0.5, 0.5), (0.99, 0.125), (1.2, 0.125), (2.5, 1.0)] {
            assert_eq!(stride.longest(&[q], &[1.0]), longest, "from {q}");
            assert_eq!(stride.longest(&[q], &[-2.0]), 0.5 * longest, "from {q}, back");
        }
    }
}
