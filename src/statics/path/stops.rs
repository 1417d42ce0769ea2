//! Stops on the way of a path: where a branch comes to one or lifts off it, and how it goes on from there.
//!
//! Which stops bear is fixed along a branch: a rigid one holds its coordinate there, a compliant one is a spring of the
//! hinge. A branch ends where a coordinate comes to its limit, and where what a stop bears falls to zero. The next one
//! begins there with the other set, in the direction of the parameter in which the stop is pressed, or the coordinate
//! leaves its limit: that may be back where it came from.

use super::PathPoint;
use super::trace::{OffStops, Seed, StopChange, Tracer};
use crate::model::{Side, Stop, StopLaw};
use crate::round_off::EIGENVECTOR;
use crate::statics::certify::bearing::Set;
use crate::statics::family::Moving;
use crate::statics::search::curve::{Direction, Point};

/// A load below this part of the forces in its hinge is none; a coordinate is at its limit within this (rad, or part of
/// the scene's length).
const SLACK: f64 = 1e-10;
/// How far ahead the new branch is looked at, in largest steps.
const AHEAD: f64 = 1e-3;

/// How far a stop is from a change: positive as long as nothing changes, with the round-off of that.
fn clear(moving: &mut Moving<'_>, stop: &Stop, side: Side, bears: bool, point: &Point) -> Result<[f64; 2], String> {
    let limit = stop.limit(side);
    let slack = SLACK * if moving.slides(stop.velocity) { moving.length() } else { 1.0 };
    let depth = stop.depth(side, &point.place.q);
    match (bears, stop.law) {
        (false, _) => Ok([-depth, slack.max(SLACK * limit.abs())]),
        (true, StopLaw::Compliant { .. }) => Ok([depth, slack.max(SLACK * limit.abs())]),
        (true, StopLaw::Rigid { .. }) => {
            let [held, size] = moving.held(&point.place.q, point.parameter, stop.velocity)?;
            Ok([-side.sign() * held, SLACK * size])
        }
    }
}

/// How a branch begins.
pub(super) enum Beginning {
    At(Box<Seed>),
    /// Not without this stop.
    Closes(usize, Side),
    Nowhere,
}

/// A point that the stops of a set do not hold.
struct Untenable;

impl Tracer<'_> {
    /// The first stop that a step comes to or lifts off.
    pub(super) fn change(&mut self, a: &Point, b: &Point, step: f64) -> Option<StopChange> {
        let set = self.moving.set().clone();
        let mut first: Option<StopChange> = None;
        for (index, now) in set.iter().enumerate() {
            let stop = self.moving.stop(index);
            for side in stop.sides().filter(|side| now.is_none_or(|now| now == *side)) {
                let value =
                    |tracer: &mut Self, point: &Point| clear(&mut tracer.moving, &stop, side, now.is_some(), point);
                let Ok([end, slack]) = value(self, b) else { continue };
                if end >= -slack {
                    continue;
                }
                let start = value(self, a).map_or(0.0, |[start, _]| start).max(0.0);
                let ends = [(0.0, start), (step, end)];
                let located = self.located(a, ends, &mut |tracer, point| value(tracer, point).ok().map(|[x, _]| x));
                // If the branch begins on it, the stop changes at once.
                let (s, point) = located.unwrap_or_else(|| (0.0, a.clone()));
                if first.as_ref().is_none_or(|first| s < first.s) {
                    let mut set = set.clone();
                    set[index] = if now.is_none() { Some(side) } else { None };
                    first = Some(StopChange { set, index, side, point, s });
                }
            }
        }
        first
    }

    /// A set of stops with the rigid ones that are touched and that a direction does not leave: what they bear grows along it.
    pub(super) fn staying(&mut self, mut set: Set, q: &[f64], direction: &[f64]) -> Set {
        let least = EIGENVECTOR.of(direction.iter().fold(0.0, |most, x| most.max(x.abs())));
        for index in 0..set.len() {
            let stop = self.moving.stop(index);
            let stays = stop.is_rigid() && direction[stop.velocity].abs() <= least;
            let slack = SLACK * if self.moving.slides(stop.velocity) { self.moving.length() } else { 1.0 };
            let touched = |side: &Side| stop.depth(*side, q).abs() <= slack.max(SLACK * stop.limit(*side).abs());
            if set[index].is_none() && stays {
                set[index] = stop.sides().find(touched);
            }
        }
        set
    }

    /// The branch that leaves stops that bear nothing at a bifurcation, on the side that they leave open. Others that are touched there
    /// may close on it: then it is another branch, with these in the set.
    pub(super) fn leaving(&mut self, off: &OffStops, point: &PathPoint, parent: (usize, usize)) -> Beginning {
        let model = self.moving.model();
        let free = (0..model.velocity_count()).filter(|i| !model.coordinates[*i].lock);
        let x = free.map(|i| off.direction[i]).collect();
        let Some(normal) = self.moving.metric().unit(&Direction { x, parameter: 0.0 }) else {
            return Beginning::Nowhere;
        };
        let Some(seed) = self.seed(&point.position, point.parameter, &normal, parent) else {
            return Beginning::Nowhere;
        };
        match self.passed(&seed.point, &point.position) {
            Ok(None) => Beginning::At(Box::new(seed)),
            Ok(Some((index, side))) => Beginning::Closes(index, side),
            Err(Untenable) => Beginning::Nowhere,
        }
    }

    /// The stop that a point is furthest beyond, of those that `from` touches.
    fn passed(&mut self, point: &Point, from: &[f64]) -> Result<Option<(usize, Side)>, Untenable> {
        let set = self.moving.set().clone();
        let mut worst: Option<(f64, (usize, Side))> = None;
        for (index, now) in set.iter().enumerate() {
            let stop = self.moving.stop(index);
            for side in stop.sides().filter(|side| now.is_none_or(|now| now == *side)) {
                let [clear, slack] =
                    clear(&mut self.moving, &stop, side, now.is_some(), point).map_err(|_| Untenable)?;
                if clear >= -slack {
                    continue;
                }
                // What bears would have to pull, or a stop is passed that is out of reach.
                if now.is_some() || stop.depth(side, from) < -slack {
                    return Err(Untenable);
                }
                if worst.is_none_or(|(most, _)| clear / slack < most) {
                    worst = Some((clear / slack, (index, side)));
                }
            }
        }
        Ok(worst.map(|(_, passed)| passed))
    }

    /// The branch that goes on after a change, if there is one.
    pub(super) fn onward(&mut self, change: &StopChange, parent: (usize, usize)) -> Option<Seed> {
        let (q, parameter) = (change.point.place.q.clone(), change.point.parameter);
        let stop = self.moving.stop(change.index);
        let bears = change.set[change.index].is_some();
        let went = if change.point.ahead.parameter < 0.0 { -1.0 } else { 1.0 };
        for sign in [went, -went] {
            let still = vec![0.0; self.moving.metric().inertia.len()];
            let towards = Direction { x: still, parameter: sign };
            let (look, step) = (AHEAD * self.settings.step, self.settings.step);
            let mut curve = self.curve();
            let Some(point) = curve.correct(q.clone(), parameter, &towards, step) else { continue };
            let Some(beside) = curve.ahead(&point, look) else { continue };
            if clear(&mut self.moving, &stop, change.side, bears, &beside).is_ok_and(|[clear, _]| clear > 0.0) {
                return Some(Seed { point, parent: Some(parent), beside: step });
            }
        }
        None
    }
}
