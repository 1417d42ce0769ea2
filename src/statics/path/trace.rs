//! One branch, point by point.

use super::{BranchEnd, EventKind, PathBranch, PathEvent, PathPoint, PathSettings};
use crate::model::Side;
use crate::statics::certify::bearing::Set;
use crate::statics::certify::sides::{Leaving, Sides};
use crate::statics::certify::stability::StabilityVerdict;
use crate::statics::certify::weak::Around;
use crate::statics::family::{Count, Moving};
use crate::statics::search::curve::{Curve, Direction, Family, Point};
use crate::statics::search::illinois::illinois;

/// A step is given up below this part of the largest one.
const SMALLEST: f64 = 1e-6;
/// Bodies that are named at an event.
const MOST_CARRIERS: usize = 5;
/// How far branches are looked for beside a bifurcation, in largest steps, and how often that is halved: the null vector leaves
/// the branch by the square of the distance, while folds and other bifurcations beside it stay where they are. Corrected by no
/// more than this distance first points are within one step of the bifurcation.
const BESIDE: f64 = 0.7;
const HALVINGS: i32 = 10;
/// A seed lies on a branch that is nearer to it than this part of its distance from the bifurcation. A branch has a point there;
/// its chord to the next one leaves it by up to 0.04 of a step in the middle, and by 0.16 of the distance near its ends.
const ON: f64 = 0.4;

/// What follows branches.
pub(super) struct Tracer<'a> {
    pub(super) moving: Moving<'a>,
    pub(super) settings: &'a PathSettings,
    /// Points of the branch that was followed last at which others leave stops.
    pub(super) off_stops: Vec<(usize, OffStops)>,
}

/// A bifurcation whose branches leave stops that bear nothing.
#[derive(Debug, Clone)]
pub(super) struct OffStops {
    /// The stops that bear on them.
    pub set: Set,
    /// Where they leave, over all velocity coordinates.
    pub direction: Vec<f64>,
}

/// Where a branch begins.
pub(super) struct Seed {
    pub(super) point: Point,
    pub(super) parent: Option<(usize, usize)>,
    /// Distance from the bifurcation that it leaves (arclength); 0 for others.
    pub(super) beside: f64,
}

/// What changes at the end of a branch.
#[derive(Debug, Clone)]
pub(super) struct StopChange {
    /// The stops that bear from there on.
    pub set: Set,
    /// Which of them has changed, and on which side.
    pub index: usize,
    pub side: Side,
    /// Where.
    pub point: Point,
    /// Arclength since the last point.
    pub s: f64,
}

/// A point on the way between two others, by arclength from the first.
struct Between {
    s: f64,
    point: Point,
    event: Option<PathEvent>,
    wanted: bool,
    off: Option<OffStops>,
}

impl<'a> Tracer<'a> {
    pub(super) fn new(moving: Moving<'a>, settings: &'a PathSettings) -> Self {
        Self { moving, settings, off_stops: Vec::new() }
    }

    pub(super) fn curve(&mut self) -> Curve<'_> {
        let metric = self.moving.metric().clone();
        Curve::new(&mut self.moving, metric)
    }

    /// The equilibrium at `from`, on its way to `to`.
    pub(super) fn first(&mut self, q: &[f64]) -> Result<Seed, String> {
        let (from, to, step) = (self.settings.from, self.settings.to, self.settings.step);
        let still = vec![0.0; self.moving.metric().inertia.len()];
        let towards = Direction { x: still, parameter: to - from };
        let mut curve = self.curve();
        let point = curve.correct(q.to_vec(), from, &towards, step).ok_or(curve.reason)?;
        Ok(Seed { point, parent: None, beside: 0.0 })
    }

    /// Whether a seed lies on a branch that was followed already.
    pub(super) fn is_on(&self, seed: &Seed, branch: &PathBranch) -> bool {
        let away = |point: &PathPoint| {
            let x = self.moving.apart(&seed.point.place.q, &point.position);
            Direction { x, parameter: point.parameter - seed.point.parameter }
        };
        let near = (ON * seed.beside).powi(2);
        let all: Vec<Direction> = branch.points.iter().map(away).collect();
        all.windows(2).any(|pair| self.moving.metric().square_to_segment(&pair[0], &pair[1]) < near)
    }

    /// Follows a branch from its seed to its end; tells how it goes on where that is at a stop.
    pub(super) fn trace(
        &mut self,
        seed: Seed,
        go_on: &mut dyn FnMut(f64) -> bool,
    ) -> Result<(PathBranch, Option<StopChange>), String> {
        self.off_stops.clear();
        let parent = seed.parent;
        let first = seed.point;
        let mut count = self.moving.count(&first.place, first.parameter)?;
        let mut branch = PathBranch { parent, points: Vec::new(), end: BranchEnd::Points };
        let wanted = self.settings.at.contains(&first.parameter);
        self.push(&mut branch, &first, count, 0.0, None, wanted)?;
        let (mut here, mut arclength, mut step) = (first.clone(), 0.0, 0.25 * self.settings.step);
        while branch.points.len() < self.settings.points {
            let stepped = self.curve_step(&here, step);
            let next = match stepped {
                Ok(next) => next,
                Err(reason) => {
                    step *= 0.4;
                    if step < SMALLEST * self.settings.step {
                        branch.end = BranchEnd::Lost(reason);
                        break;
                    }
                    continue;
                }
            };
            let next_count = self.moving.count(&next.place, next.parameter)?;
            let mut between = self.events(&here, &next, step, [count, next_count]);
            let mut leaves = self.marks(&here, &next, step, &mut between);
            between.sort_by(|a, b| a.s.total_cmp(&b.s));
            let change = self.change(&here, &next, step);
            let change = change.filter(|change| !leaves || between.last().is_none_or(|last| change.s < last.s));
            if let Some(change) = &change {
                between.retain(|one| one.s < change.s);
                leaves = false;
            }
            for one in between {
                let count = match one.event {
                    Some(_) => Count { neutral: 1, unstable: count.unstable.min(next_count.unstable), ..count },
                    None => self.moving.count(&one.point.place, one.point.parameter)?,
                };
                self.off_stops.extend(one.off.map(|off| (branch.points.len(), off)));
                self.push(&mut branch, &one.point, count, arclength + one.s, one.event, one.wanted)?;
            }
            if let Some(change) = change {
                let count = self.moving.count(&change.point.place, change.point.parameter)?;
                let (stop, lifts) = (self.moving.stop(change.index), change.set[change.index].is_none());
                let kind = if lifts { EventKind::Lift } else { EventKind::Stop };
                let carriers = vec![self.moving.model().owner(stop.velocity).to_owned()];
                let event = PathEvent { kind, directions: 1, carriers };
                self.push(&mut branch, &change.point, count, arclength + change.s, Some(event), false)?;
                let (hinge, limit) = (self.moving.model().label(stop.velocity), stop.limit(change.side));
                branch.end = BranchEnd::Stop { hinge, limit, lifts };
                return Ok((branch, Some(change)));
            }
            if leaves {
                let reached = branch.points.last().is_some_and(|last| self.ends_range(last.parameter));
                let lost = || BranchEnd::Lost("the end of the range cannot be met".to_owned());
                branch.end = if reached { BranchEnd::Range } else { lost() };
                break;
            }
            arclength += step;
            self.push(&mut branch, &next, next_count, arclength, None, false)?;
            if arclength > 8.0 * self.settings.step && self.is_back(&first, &next, step) {
                branch.end = BranchEnd::Closed;
                break;
            }
            let factor = [2.0, 2.0, 1.6, 1.2, 1.0].get(next.iterations).copied().unwrap_or(0.6);
            step = (step * factor).min(self.settings.step);
            (here, count) = (next, next_count);
            if !go_on(here.parameter) {
                branch.end = BranchEnd::Lost("stopped from outside".to_owned());
                break;
            }
        }
        Ok((branch, None))
    }

    /// Whether a value of the parameter is an end of its range.
    fn ends_range(&self, parameter: f64) -> bool {
        let near = 1e-9 * self.moving.metric().range;
        [self.settings.from, self.settings.to].iter().any(|end| (end - parameter).abs() <= near)
    }

    fn curve_step(&mut self, from: &Point, step: f64) -> Result<Point, String> {
        let mut curve = self.curve();
        curve.step(from, step).ok_or(curve.reason)
    }

    /// Whether the branch has come back to where it began.
    fn is_back(&self, first: &Point, now: &Point, step: f64) -> bool {
        let x = self.moving.apart(&first.place.q, &now.place.q);
        let apart = Direction { x, parameter: now.parameter - first.parameter };
        let metric = self.moving.metric();
        metric.dot(&apart, &apart).sqrt() < 0.75 * step && metric.dot(&first.ahead, &now.ahead) > 0.9
    }

    /// Folds, bifurcations and flutter between two points.
    fn events(&mut self, a: &Point, b: &Point, step: f64, counts: [Count; 2]) -> Vec<Between> {
        let mut found = Vec::new();
        let [before, after] = counts;
        let changes = before.negative.abs_diff(after.negative);
        let folds = a.ahead.parameter * b.ahead.parameter < 0.0;
        let mut others = changes;
        if folds {
            let ends = [(0.0, a.ahead.parameter), (step, b.ahead.parameter)];
            let small = 1e-12 * self.settings.step * self.moving.metric().range;
            let located = self.curve().root(a, ends, small, &mut |_, point| Some(point.ahead.parameter));
            others = changes.saturating_sub(1);
            if let Some((s, point)) = located {
                // A branch that is a mirror image of itself turns in a bifurcation: no direction changes sides.
                let kind = if changes == 0 { EventKind::Bifurcation } else { EventKind::Fold };
                found.push(self.event(s, point, kind, 1));
            }
        }
        if others > 0 && !folds {
            let located = self.singular(a, step, [before, after]);
            found.extend(located.map(|(s, point)| self.event(s, point, EventKind::Bifurcation, others)));
        }
        let on_stops = [before, after].map(|count| count.unstable - count.sided);
        if changes == 0 && on_stops[0] != on_stops[1] {
            let located = self.by_count(a, step, before, |count| count.unstable - count.sided);
            let directions = on_stops[0].abs_diff(on_stops[1]);
            found.extend(located.map(|(s, point)| self.event(s, point, EventKind::Flutter, directions)));
        }
        // The stiffness along the stops is the same there; that off them passes zero.
        if on_stops == [0, 0] && before.sided != after.sided {
            let unstable = if before.sided > 0 { a } else { b };
            let located = self.by_count(a, step, before, |count| count.sided);
            found.extend(located.and_then(|(s, point)| self.off(s, point, unstable)));
        }
        found
    }

    /// A bifurcation off stops, between a solution that runs away there and one that does not.
    fn off(&mut self, s: f64, point: Point, unstable: &Point) -> Option<Between> {
        let Around { pressed, sides, .. } = self.moving.around(&unstable.place.q, unstable.parameter).ok()??;
        let Sides::Leave(Leaving { coordinates, direction, .. }) = sides else { return None };
        let mut carriers: Vec<String> = coordinates.iter().map(|i| self.moving.model().owner(*i).to_owned()).collect();
        carriers.dedup();
        let event = PathEvent { kind: EventKind::Bifurcation, directions: 1, carriers };
        let set = self.staying(pressed, &point.place.q, &direction);
        Some(Between { s, point, event: Some(event), wanted: false, off: Some(OffStops { set, direction }) })
    }

    fn event(&mut self, s: f64, point: Point, kind: EventKind, directions: usize) -> Between {
        let carriers = match kind {
            EventKind::Fold => self.carriers(&point.ahead.x.clone()),
            _ => self.null(&point).map_or(Vec::new(), |x| self.carriers(&x)),
        };
        Between { s, point, event: Some(PathEvent { kind, directions, carriers }), wanted: false, off: None }
    }

    /// The place where a number of directions changes, by halving.
    fn by_count(&mut self, a: &Point, step: f64, before: Count, of: impl Fn(&Count) -> usize) -> Option<(f64, Point)> {
        let (mut low, mut high, mut best) = (0.0, step, None);
        for _ in 0..46 {
            let s = 0.5 * (low + high);
            let point = self.curve().ahead(a, s)?;
            let count = self.moving.count(&point.place, point.parameter).ok()?;
            if of(&count) == of(&before) {
                low = s;
            } else {
                high = s;
            }
            best = Some((s, point));
        }
        best
    }

    /// The place where the stiffness of one direction passes zero: first by halving, then by its root.
    fn singular(&mut self, a: &Point, step: f64, counts: [Count; 2]) -> Option<(f64, Point)> {
        let (mut low, mut high) = (0.0, step);
        for _ in 0..5 {
            let s = 0.5 * (low + high);
            let point = self.curve().ahead(a, s)?;
            let count = self.moving.count(&point.place, point.parameter).ok()?;
            if count.negative == counts[0].negative { low = s } else { high = s }
        }
        let near = self.curve().ahead(a, 0.5 * (low + high))?;
        let single = counts[0].negative.abs_diff(counts[1].negative) == 1;
        let along = if single { self.null(&near) } else { None };
        let by_root = along.and_then(|b| {
            let value = |tracer: &mut Self, s: f64| {
                let point = tracer.curve().ahead(a, s)?;
                tracer.moving.stiffness_along(&point.place.q, point.parameter, &b)
            };
            let ends = [(low, value(self, low)?), (high, value(self, high)?)];
            (ends[0].1 * ends[1].1 < 0.0).then_some(())?;
            // A stiffness that cannot be solved with is the zero that is looked for.
            self.located(a, ends, &mut |tracer, point| {
                Some(tracer.moving.stiffness_along(&point.place.q, point.parameter, &b).unwrap_or(0.0))
            })
        });
        by_root.or_else(|| self.by_count(a, step, counts[0], |count| count.negative))
    }

    /// The root of a number along the curve; `None` if the number cannot be evaluated on the way.
    pub(super) fn located(
        &mut self,
        a: &Point,
        ends: [(f64, f64); 2],
        of: &mut dyn FnMut(&mut Self, &Point) -> Option<f64>,
    ) -> Option<(f64, Point)> {
        let small = 1e-13 * ends[0].1.abs().max(ends[1].1.abs());
        let mut failed = false;
        let found = illinois(ends, small, |s| {
            let at = self.curve().ahead(a, s).and_then(|point| Some((of(self, &point)?, point)));
            failed |= at.is_none();
            at
        });
        found.filter(|_| !failed)
    }

    /// The zero-stiffness direction at a singular point.
    fn null(&mut self, point: &Point) -> Option<Vec<f64>> {
        let inertia = &self.moving.metric().inertia;
        let part = |(i, b): (usize, &f64)| (0.5 + (i as f64 * 1.618_033_988_75).fract()) / b.sqrt();
        let first = inertia.iter().enumerate().map(part).collect();
        self.moving.softest(&point.place.q, point.parameter, first)
    }

    /// Bodies whose hinges carry a direction, most of it first.
    fn carriers(&self, x: &[f64]) -> Vec<String> {
        let model = self.moving.model();
        let free = (0..model.velocity_count()).filter(|i| !model.coordinates[*i].lock);
        let mut parts: Vec<(usize, f64)> = Vec::new();
        for ((at, x), b) in free.zip(x).zip(&self.moving.metric().inertia) {
            let body = model.coordinates[at].body;
            match parts.last_mut() {
                Some((last, sum)) if *last == body => *sum += b * x * x,
                _ => parts.push((body, b * x * x)),
            }
        }
        parts.sort_by(|a, b| b.1.total_cmp(&a.1));
        let least = 0.05 * parts.iter().map(|(_, part)| part).sum::<f64>();
        parts
            .iter()
            .take_while(|(_, part)| *part > least)
            .take(MOST_CARRIERS)
            .map(|(body, _)| model.bodies[*body].name.clone())
            .collect()
    }

    /// Wanted values of the parameter between two points, and its range: whether the branch leaves it. What comes after
    /// is dropped.
    fn marks(&mut self, a: &Point, b: &Point, step: f64, between: &mut Vec<Between>) -> bool {
        let (low, high) = (self.settings.from.min(self.settings.to), self.settings.from.max(self.settings.to));
        // Between events the parameter goes one way.
        let mut stops: Vec<(f64, f64)> = vec![(0.0, a.parameter)];
        stops.extend(between.iter().map(|one| (one.s, one.point.parameter)));
        stops.push((step, b.parameter));
        stops.sort_by(|a, b| a.0.total_cmp(&b.0));
        let slack = 1e-12 * (high - low);
        for pair in stops.windows(2) {
            let (start, end) = (pair[0], pair[1]);
            let inside = |value: f64| (start.1 < value) != (end.1 < value) && start.1 != value;
            let outside = end.1 > high + slack || end.1 < low - slack;
            let bound = if end.1 > high { high } else { low };
            let values = self.settings.at.clone().into_iter().filter(|at| inside(*at) && (low..=high).contains(at));
            let ends = outside.then_some(bound);
            for (value, wanted) in values.map(|at| (at, true)).chain(ends.map(|bound| (bound, false))) {
                if ends == Some(value) && wanted {
                    continue;
                }
                let located = self.landing(a, [start, end], value);
                let wanted = self.settings.at.contains(&value);
                between.extend(located.map(|(s, point)| Between { s, point, event: None, wanted, off: None }));
            }
            if outside {
                between.retain(|one| one.s <= end.0);
                return true;
            }
        }
        false
    }

    /// The point of the curve at exactly this value of the parameter.
    fn landing(&mut self, a: &Point, ends: [(f64, f64); 2], value: f64) -> Option<(f64, Point)> {
        let [low, high] = ends.map(|(s, parameter)| (s, parameter - value));
        let (small, near) = (1e-13 * self.moving.metric().range, self.settings.step);
        let mut curve = self.curve();
        let (s, point) = curve.root(a, [low, high], small, &mut |_, point| Some(point.parameter - value))?;
        // Exactly there: across the parameter.
        let still = vec![0.0; point.ahead.x.len()];
        let across = Direction { x: still, parameter: 1.0 };
        let exact = curve.correct(point.place.q.clone(), value, &across, near);
        let turned = exact.map(|exact| Point { ahead: point.ahead.clone(), ..exact });
        Some((s, turned.unwrap_or(point)))
    }

    fn push(
        &mut self,
        branch: &mut PathBranch,
        point: &Point,
        count: Count,
        arclength: f64,
        event: Option<PathEvent>,
        wanted: bool,
    ) -> Result<(), String> {
        let record = self.moving.record(&point.place.q, point.parameter, &[])?;
        record.fault.map_or(Ok(()), |fault| Err(fault.to_string()))?;
        let verdict = match (count.unstable, count.neutral) {
            (0, 0) => StabilityVerdict::Stable,
            (0, _) => StabilityVerdict::Neutral,
            _ => StabilityVerdict::Unstable,
        };
        branch.points.push(PathPoint {
            parameter: point.parameter,
            arclength,
            position: point.place.q.clone(),
            poses: record.poses,
            reactions: record.reactions,
            potential: record.potential,
            outputs: record.outputs,
            relative_residual: point.place.residual().0,
            verdict,
            unstable_directions: count.unstable,
            wanted,
            event,
        });
        Ok(())
    }
}

/// Where other branches leave the bifurcations of a branch.
pub(super) fn seeds(tracer: &mut Tracer<'_>, branch: &PathBranch, index: usize, notes: &mut Vec<String>) -> Vec<Seed> {
    let mut found = Vec::new();
    for (at, point) in branch.points.iter().enumerate() {
        let leaves_stops = tracer.off_stops.iter().any(|(of, _)| *of == at);
        let is_one = |event: &&PathEvent| event.kind == EventKind::Bifurcation && !leaves_stops;
        let Some(event) = point.event.as_ref().filter(is_one) else { continue };
        let value = crate::model::problem::rounded(point.parameter);
        if event.directions > 1 {
            let count = if event.directions == 2 { "double".to_owned() } else { format!("{}-fold", event.directions) };
            notes.push(format!("{count} bifurcation at {value}: its branches are not followed"));
            continue;
        }
        let beside = tracer.beside(point, (index, at));
        if beside.len() < 2 {
            let sides = if beside.is_empty() { "either side" } else { "one side" };
            notes.push(format!("bifurcation at {value}: no branch was found within a step of it on {sides}"));
        }
        found.extend(beside);
    }
    found
}

impl Tracer<'_> {
    /// The first points of the branch that crosses at a bifurcation, one on either side: within a step of it, and within the
    /// range of the parameter.
    fn beside(&mut self, point: &PathPoint, parent: (usize, usize)) -> Vec<Seed> {
        let mut found = Vec::new();
        let Ok(place) = self.moving.place(&point.position, point.parameter) else { return found };
        let still = vec![0.0; self.moving.metric().inertia.len()];
        let ahead = Direction { x: still, parameter: 1.0 };
        let base = Point { place, parameter: point.parameter, ahead, iterations: 0 };
        let Some(null) = self.null(&base) else { return found };
        let across = Direction { x: null, parameter: 0.0 };
        let Some(across) = self.moving.metric().unit(&across) else { return found };
        for sign in [1.0, -1.0] {
            let normal = Direction { x: across.x.iter().map(|x| sign * x).collect(), parameter: 0.0 };
            found.extend(self.seed(&base.place.q, base.parameter, &normal, parent));
        }
        found
    }

    /// The first point of a branch that leaves a bifurcation along `normal`.
    pub(super) fn seed(
        &mut self,
        q: &[f64],
        parameter: f64,
        normal: &Direction,
        parent: (usize, usize),
    ) -> Option<Seed> {
        (0..=HALVINGS).find_map(|halvings| {
            let beside = BESIDE * 0.5_f64.powi(halvings) * self.settings.step;
            let x: Vec<f64> = normal.x.iter().map(|x| beside * x).collect();
            let q = self.moving.moved(q, &x);
            let point = self.curve().correct(q, parameter, normal, beside)?;
            self.is_within_range(point.parameter).then_some(Seed { point, parent: Some(parent), beside })
        })
    }

    fn is_within_range(&self, parameter: f64) -> bool {
        let (low, high) = (self.settings.from.min(self.settings.to), self.settings.from.max(self.settings.to));
        let slack = 1e-12 * (high - low);
        parameter >= low - slack && parameter <= high + slack
    }
}
