//! How wrong a run is: the same run once more, tighter and by another method.
//!
//! The second run has a hundredth of the tolerance, or half the step where that is fixed, and is made by a method that
//! shares nothing with the first but the system: what the two end states differ by is the error of the first, as long
//! as the second is much the better one. On a chaotic scene they differ by as much as the motion itself: then no method
//! can say where it ends.
//!
//! **Longest steps** where steps could miss what a formula or a sine does are others: the ends of both runs' steps fall together nowhere
//! but at breaks (`Search::CHECK`).
//!
//! **Captured steps** (`simulate::contact`) are none of either method: the second run has an eighth of them, and an error between them
//! and their halves of a 64th. Their order is one, so that what they differ by is seven eighths of the error of the first, or more.
//!
//! **Events** are looked for in another way, too: other looks within other steps, and another root finder. What happens to
//! each stop and each watched number is compared in order; and between the events of the second run its dense output is
//! scanned for states beyond a rigid stop, by nothing but their coordinates.

use crate::integrate::Method;
use crate::model::problem::number;
use crate::model::{Model, Stop};
use crate::record::{Outcome, RecordError, Recorder, Sample};
use crate::simulate::asked::Asked;
use crate::simulate::entry::run_with;
use crate::simulate::error::RunError;
use crate::simulate::events::search::Search;
use crate::simulate::events::{Kind, Occurrence};
use crate::simulate::run::Summary;
use crate::simulate::settings::{Integrator, Settings};
use crate::simulate::state::State;
use std::collections::BTreeMap;
use std::sync::Arc;

/// The second run's tolerance is this part of the first one's.
const TIGHTER: f64 = 1e-2;
const TIGHTEST: f64 = 1e-13;
/// It may take this many times the steps of the first run, and some: on a scene whose fast vibrations the first one
/// passed over and the second one would follow, it would take days.
const MOST_STEPS: u64 = 50;
const FREE_STEPS: u64 = 20_000;
/// States between events that are looked at, per step of the first run, and at most.
const STATES: f64 = 4.0;
const MOST_STATES: f64 = 1e5;

/// The estimated error of a run at its end, the largest of each kind of coordinate.
#[derive(Debug, Clone, PartialEq)]
pub struct Verified {
    /// The method of the second run.
    pub method: Method,
    /// Its tolerance.
    pub tolerance: f64,
    /// Whether the first run has captured steps; those of the second are an eighth as long.
    pub captured: bool,
    /// Of distances (m).
    pub length: f64,
    /// Of angles, and of the turn between quaternions (rad).
    pub angle: f64,
    /// Of speeds along hinges (m/s).
    pub speed: f64,
    /// Of rates (rad/s).
    pub rate: f64,
    /// Of the end itself, where an event ended the run (s).
    pub time: f64,
    /// Of events; `None` for a scene without stops and events.
    pub events: Option<VerifiedEvents>,
}

/// How the events of two runs compare, and what a scan for passed stops found.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct VerifiedEvents {
    /// Events of the first run.
    pub events: usize,
    /// Events of the first run that happen in the second one as well, in the same order for each stop and each watched number.
    pub same: usize,
    /// The largest difference of their times (s).
    pub apart: f64,
    /// The first event from which on the runs differ (s).
    pub differ_from: Option<f64>,
    /// States of the second run that were scanned.
    pub scanned: usize,
    /// How far the worst of them is beyond a rigid stop (m or rad).
    pub beyond: f64,
}

/// Runs again and compares. `None` if it was stopped from outside.
///
/// # Errors
/// If the second run cannot be made.
pub fn verify(
    model: &Arc<Model>,
    settings: &Settings,
    start: &State,
    first: &Summary,
    go_on: &mut dyn FnMut(f64) -> bool,
) -> Result<Option<Verified>, RunError> {
    // What stability held, or could have held, is not given to an explicit method.
    let last = first.integrators.last().copied().unwrap_or(Method::Radau9);
    let method = match last {
        // Implicit methods take an evaluation per coordinate for each of their matrices there.
        Method::Dop853 if !model.contacts.is_empty() => Method::Dopri5,
        Method::Rk4 | Method::Dopri5 | Method::Adams | Method::Gauss => Method::Dop853,
        Method::Radau9 => Method::Radau5,
        Method::Dop853 | Method::Sdirk4 | Method::Radau5 | Method::GeneralizedAlpha => Method::Radau9,
    };
    let tolerance = (TIGHTER * settings.tolerance).max(TIGHTEST);
    let settings = Settings {
        duration: if first.stopped_by.is_some() { settings.duration } else { first.end_time - settings.begin() },
        integrator: Integrator::Method(method),
        tolerance,
        absolute_tolerance: (TIGHTER * settings.absolute_tolerance).max(TIGHTEST),
        step: None,
        ..settings.clone()
    };
    let watched = !model.stops.is_empty() || !model.events.is_empty() || !model.contacts.is_empty();
    let states = if watched { (STATES * first.statistics.steps as f64).clamp(1.0, MOST_STATES) } else { 1.0 };
    let rate = states / settings.duration;
    let mut scan = Scan { stops: &model.stops, scans: model.stages.is_none(), scanned: 0, beyond: 0.0 };
    let most = FREE_STEPS + MOST_STEPS * first.statistics.steps;
    let (mut steps, mut too_long) = (0, false);
    let mut go_on = |time: f64, _: &State| {
        steps += 1;
        // The pace of a tenth of them tells.
        too_long = steps >= most || (steps >= most / 10 && steps as f64 * settings.duration > most as f64 * time);
        !too_long && go_on(time)
    };
    let (recorder, search) = (&mut scan, Search::CHECK);
    let asked = Asked { settings: &settings, rate, recorder, go_on: &mut go_on, search, function: None };
    let second = run_with(model, start, asked)?;
    if too_long && second.interrupted {
        return Err(RunError::Step(gives_up(method, tolerance, steps, second.end_time)));
    }
    if second.interrupted {
        return Ok(None);
    }
    let mut found = Verified {
        method,
        tolerance,
        captured: first.capture_steps > 0,
        length: 0.0,
        angle: 0.0,
        speed: 0.0,
        rate: 0.0,
        time: (second.end_time - first.end_time).abs(),
        events: watched.then(|| {
            let VerifiedEvents { events, same, apart, differ_from, .. } = compare_events(&first.events, &second.events);
            VerifiedEvents { events, same, apart, differ_from, scanned: scan.scanned, beyond: scan.beyond }
        }),
    };
    if first.state.position.len() != second.state.position.len() {
        return Err(RunError::Stages("a second run, with a tighter tolerance, ends in another structure"));
    }
    compare(&first.model, &first.state, &second.state, &mut found);
    Ok(Some(found))
}

fn gives_up(method: Method, tolerance: f64, steps: u64, time: f64) -> String {
    format!(
        "the second run, by {} at a tolerance of {tolerance:.0e}, took {steps} steps to t = {} s and would need \
         {MOST_STEPS} times those of the first: it follows vibrations that the first one passed over; verify at a looser \
         tolerance, or damp what vibrates",
        method.name(),
        number(time)
    )
}

/// Looks at the coordinates of samples, and keeps none.
struct Scan<'m> {
    stops: &'m [Stop],
    /// Columns of a scene with stages are not those of its first structure.
    scans: bool,
    scanned: usize,
    beyond: f64,
}

impl Recorder for Scan<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), RecordError> {
        if !self.scans {
            return Ok(());
        }
        self.scanned += 1;
        for stop in self.stops.iter().filter(|stop| stop.is_rigid()) {
            let value = sample.positions[stop.position];
            self.beyond = self.beyond.max(stop.range[0] - value).max(value - stop.range[1]);
        }
        Ok(())
    }

    fn finish(&mut self, _: &Outcome) -> Result<(), RecordError> {
        Ok(())
    }
}

/// Compares what happens to each stop and each watched number, in order.
fn compare_events(first: &[Occurrence], second: &[Occurrence]) -> VerifiedEvents {
    let told = |all: &[Occurrence]| {
        let mut of = BTreeMap::<(String, u64), Vec<(f64, Kind, bool)>>::new();
        for event in all.iter().filter(|event| event.kind != Kind::Switch) {
            // The energy that a stage takes is a result.
            let value = if event.kind == Kind::Stage { 0.0 } else { event.value };
            of.entry((event.name.clone(), value.to_bits())).or_default().push((
                event.time,
                event.kind,
                event.speed > 0.0,
            ));
        }
        of
    };
    let (first, second) = (told(first), told(second));
    let mut found = VerifiedEvents { events: first.values().map(Vec::len).sum(), ..VerifiedEvents::default() };
    let mut differ_from = f64::INFINITY;
    for key in first.keys().chain(second.keys().filter(|key| !first.contains_key(*key))) {
        let [one, other] = [&first, &second].map(|of| of.get(key).map_or(&[][..], Vec::as_slice));
        let same = one.iter().zip(other).take_while(|(a, b)| (a.1, a.2) == (b.1, b.2)).count();
        found.same += same;
        let apart = one.iter().zip(other).take(same).map(|(a, b)| (a.0 - b.0).abs());
        found.apart = apart.fold(found.apart, f64::max);
        let next = [one, other].map(|of| of.get(same).map_or(f64::INFINITY, |event| event.0));
        differ_from = differ_from.min(next[0]).min(next[1]);
    }
    found.differ_from = differ_from.is_finite().then_some(differ_from);
    found
}

fn compare(model: &Model, a: &State, b: &State, found: &mut Verified) {
    for link in &model.links {
        let (way, pace) = match link.joint.is_distance() {
            true => (&mut found.length, &mut found.speed),
            false => (&mut found.angle, &mut found.rate),
        };
        *way = way.max(crate::motion::distance(link, &a.position, &b.position));
        for i in link.velocity..link.velocity + link.joint.counts().1 {
            *pace = pace.max((a.velocity[i] - b.velocity[i]).abs());
        }
    }
}

/// How far the quaternions of a state are from unit length, the largest.
pub fn quaternion_error(model: &Model, state: &State) -> f64 {
    let balls = model.links.iter().filter(|link| link.joint.is_ball());
    let of_link = |link: &crate::model::Link| {
        let p = &state.position[link.position..link.position + 4];
        (p.iter().map(|x| x * x).sum::<f64>().sqrt() - 1.0).abs()
    };
    balls.map(of_link).fold(0.0, f64::max)
}
