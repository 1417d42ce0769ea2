//! Work and precision: what every method costs for the error it makes, on one scene.
//!
//! A run of each method at each tolerance (or step, where that is fixed) is compared with a reference run by another
//! method, at the tolerance 10⁻¹³ (on the stiffest scenes 10⁻¹¹ or 10⁻⁹): `dop853`, or `radau9` on a scene so stiff that an explicit method would take all day; and
//! `radau9` or `radau5` for the points of the reference method itself. What the two references differ by is the smallest
//! error that can be told.
//!
//! The error is the largest of all hinge coordinates and velocities at eight times spread evenly over the run, each in
//! its scale (1 rad, the scene's length, the same per the scene's time); between steps as dense output gives it. The
//! time is that of the steps alone.

use crate::integrate::{Method, Options, Problem, Start, Statistics, StepError, Stepper};
use crate::model::Model;
use crate::model::problem::number;
use crate::simulate::error::{RunError, named};
use crate::simulate::problem::Equations;
use crate::simulate::state::State;
use crate::simulate::stiffness::fastest;
use std::fmt;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Looks at the state are spread evenly over the run, the last one at its end.
const LOOKS: u32 = 8;
/// Steps between two looks at the clock and two calls of `go_on`.
const STRIDE: u64 = 64;
/// Short runs are repeated within this time, and the shortest counts.
const REPEAT_WITHIN: Duration = Duration::from_millis(60);
const MOST_REPEATS: u32 = 5;
/// Relative and absolute tolerances of the references, the first with which both are made in time: on the stiffest scenes
/// rounding leaves nothing at the tightest.
const REFERENCE_TOLERANCES: [f64; 3] = [1e-13, 1e-11, 1e-9];
/// A reference may take as long as this many of the runs that are compared with it.
const REFERENCE_TIMES: u32 = 4;
/// The reference of all methods but itself, and its own: on scenes that an explicit method can follow, and on stiff ones.
const REFERENCES: [[Method; 2]; 2] = [[Method::Dop853, Method::Radau9], [Method::Radau9, Method::Radau5]];
/// A scene is stiff here where stability alone would ask an explicit method for more steps times degrees of freedom.
const MOST_EXPLICIT_WORK: f64 = 2e6;

/// What is measured.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Simulated time (s).
    pub duration: f64,
    /// Methods, in the order of the points.
    pub methods: Vec<Method>,
    /// Relative and absolute tolerances of adaptive methods.
    pub tolerances: Vec<f64>,
    /// Steps of fixed-step methods (s).
    pub steps: Vec<f64>,
    /// A run that takes longer than this is given up.
    pub limit: Duration,
}

impl Plan {
    /// All methods, tolerances from 10⁻³ to 10⁻¹², steps from a fifth of the scene's time downwards by halves.
    pub fn new(model: &Model, duration: f64, limit: Duration) -> Self {
        let coarsest = 0.2 * model.time_scale();
        Self {
            duration,
            methods: Method::ALL.to_vec(),
            tolerances: (3..=12).map(|exponent| 10.0_f64.powi(-exponent)).collect(),
            steps: (0..10).map(|halvings| coarsest * 0.5_f64.powi(halvings)).collect(),
            limit,
        }
    }

    /// The settings of a method.
    fn settings(&self, method: Method) -> Vec<Setting> {
        match method.needs_step() {
            true => self.steps.iter().map(|step| Setting::Step(*step)).collect(),
            false => self.tolerances.iter().map(|tolerance| Setting::Tolerance(*tolerance)).collect(),
        }
    }
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tolerance(tolerance) => write!(f, "tolerance = {tolerance:.0e}"),
            Self::Step(step) => write!(f, "step = {}", number(*step)),
        }
    }
}

/// What a method was asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Setting {
    /// Relative and absolute tolerance.
    Tolerance(f64),
    /// Fixed step (s).
    Step(f64),
}

/// One run and how it compares.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// The method.
    pub method: Method,
    /// What it was asked for.
    pub setting: Setting,
    /// Its errors, or why there are none.
    pub outcome: Result<Errors, String>,
    /// Time of the steps; of several runs the shortest.
    pub wall: Duration,
    /// Work of one run.
    pub statistics: Statistics,
}

impl Point {
    fn failed(method: Method, setting: Setting, why: String) -> Self {
        let (wall, statistics) = (Duration::ZERO, Statistics::default());
        Self { method, setting, outcome: Err(why), wall, statistics }
    }
}

/// Differences to the reference, the largest of all looks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Of hinge coordinates and velocities, in their scales.
    pub state: f64,
    /// Of kinetic plus potential energy (J).
    pub energy: f64,
}

/// All points, and what they are compared with.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// The reference of all methods but itself, and its own.
    pub references: [Method; 2],
    /// Relative and absolute tolerance of both.
    pub tolerance: f64,
    /// What the references differ by: smaller errors cannot be told.
    pub agreement: Errors,
    /// In the order of the plan.
    pub points: Vec<Point>,
    /// Whether it was stopped from outside.
    pub interrupted: bool,
}

impl Study {
    /// The fastest point with an error of at most `error`.
    pub fn recommend(&self, error: f64) -> Option<&Point> {
        let good = |point: &&Point| point.outcome.as_ref().is_ok_and(|errors| errors.state <= error);
        self.points.iter().filter(good).min_by_key(|point| point.wall)
    }
}

/// Measures; asks `go_on` now and then with the part of all runs that is done. `None` if it was stopped before there
/// was anything to compare with.
///
/// # Errors
/// If a reference cannot be made.
pub fn precision(
    model: &Arc<Model>,
    start: &State,
    plan: &Plan,
    go_on: &mut dyn FnMut(f64) -> bool,
) -> Result<Option<Study>, RunError> {
    if let Some(one) = model.controllers.first() {
        let name = &one.name;
        return Err(RunError::Step(format!(
            "integrators are compared on one smooth motion, and the controller `{name}` sets its inputs at instants: take it out"
        )));
    }
    if model.stages.is_some() {
        return Err(RunError::Stages(
            "integrators are compared on one smooth motion; `run --verify` compares two runs",
        ));
    }
    if let Some(rule) = model.contacts.first() {
        let why =
            "no method has anything to do in a scene at rest, and in one that moves each begins anew at every event"
                .to_owned();
        return Err(RunError::Contact { name: rule.name.clone(), why });
    }
    let runs = REFERENCES[0].len() + plan.methods.iter().map(|method| plan.settings(*method).len()).sum::<usize>();
    let mut bench = Bench { model, start, plan, motion: Equations::new(model), runs, done: 0, go_on };
    let methods = bench.references();
    let Some(References { runs: references, tolerance }) = bench.reference_runs(methods)? else { return Ok(None) };
    let agreement = bench.compare(&references[0], &references[1]);
    let mut study = Study { references: methods, tolerance, agreement, points: Vec::new(), interrupted: false };
    for &method in &plan.methods {
        let reference = &references[usize::from(method == methods[0])];
        let mut pace = Pace::default();
        for setting in plan.settings(method) {
            let point = match pace.expected() {
                Some(expected) if expected > plan.limit => {
                    let why = format!("not tried: it would take longer than {} s", plan.limit.as_secs_f64());
                    Some(Point::failed(method, setting, why))
                }
                _ => bench.point(method, setting, reference),
            };
            let Some(point) = point else {
                study.interrupted = true;
                return Ok(Some(study));
            };
            pace.see(point.wall);
            study.points.push(point);
            bench.done += 1;
        }
    }
    Ok(Some(study))
}

/// The times of a method's last two runs: the next one takes longer by the same factor.
#[derive(Default)]
struct Pace {
    before: Duration,
    last: Duration,
}

impl Pace {
    fn see(&mut self, wall: Duration) {
        self.before = self.last;
        self.last = wall.max(self.last);
    }

    /// The time of the next run; `None` if there is nothing to go by.
    fn expected(&self) -> Option<Duration> {
        let factor = (self.last.as_secs_f64() / self.before.as_secs_f64()).clamp(1.0, 10.0);
        Duration::try_from_secs_f64(factor * self.last.as_secs_f64()).ok()
    }
}

/// The looks of both reference runs, and their tolerance.
struct References {
    runs: Vec<Vec<Look>>,
    tolerance: f64,
}

/// The state and energy at a look.
struct Look {
    state: State,
    energy: f64,
}

/// How a run ended, where it made all the steps it was allowed to.
#[derive(Clone, Copy, PartialEq)]
enum End {
    Reached,
    /// It took too long.
    GivenUp,
    Interrupted,
}

struct Run {
    end: End,
    looks: Vec<Look>,
    wall: Duration,
    statistics: Statistics,
}

struct Bench<'a, 'g> {
    model: &'a Model,
    start: &'a State,
    plan: &'a Plan,
    motion: Equations,
    /// How many runs there are, and how many are done.
    runs: usize,
    done: usize,
    go_on: &'g mut dyn FnMut(f64) -> bool,
}

impl<'a> Bench<'a, '_> {
    /// The reference of all methods but itself, and its own.
    fn references(&mut self) -> [Method; 2] {
        let State { position, velocity } = self.start;
        let rate = fastest(&mut self.motion, 0.0, position, velocity).map_or(0.0, |fastest| fastest.rate);
        let reach = REFERENCES[0][0].stability_reach().unwrap_or(f64::INFINITY);
        let work = rate * self.plan.duration / reach * self.model.velocity_count() as f64;
        REFERENCES[usize::from(work > MOST_EXPLICIT_WORK)]
    }

    /// The runs to compare with, and their tolerance; `None` if they were stopped from outside.
    fn reference_runs(&mut self, methods: [Method; 2]) -> Result<Option<References>, RunError> {
        let limit = REFERENCE_TIMES * self.plan.limit.max(Duration::from_secs(1));
        let mut why = RunError::Step("the reference runs take too long: shorten the run or allow more time".to_owned());
        for tolerance in REFERENCE_TOLERANCES {
            let mut runs = Vec::new();
            for method in methods {
                match self.run(method, Setting::Tolerance(tolerance), Some(limit)) {
                    Ok(Run { end: End::Reached, looks, .. }) => runs.push(looks),
                    Ok(Run { end: End::Interrupted, .. }) => return Ok(None),
                    Ok(Run { end: End::GivenUp, .. }) => break,
                    Err(error) => {
                        why = error;
                        break;
                    }
                }
            }
            if runs.len() == methods.len() {
                self.done += runs.len();
                return Ok(Some(References { runs, tolerance }));
            }
        }
        Err(why)
    }

    /// The point of a method; `None` if it was stopped from outside.
    fn point(&mut self, method: Method, setting: Setting, reference: &[Look]) -> Option<Point> {
        let begun = Instant::now();
        let mut best: Option<Point> = None;
        for _ in 0..MOST_REPEATS {
            let run = match self.run(method, setting, Some(self.plan.limit)) {
                Ok(run) => run,
                Err(error) => return Some(Point::failed(method, setting, error.to_string())),
            };
            let outcome = match run.end {
                End::Interrupted => return None,
                End::GivenUp => Err(format!("given up after {} s", self.plan.limit.as_secs_f64())),
                End::Reached => Some(self.compare(&run.looks, reference))
                    .filter(|errors| errors.state.is_finite() && errors.energy.is_finite())
                    .ok_or_else(|| "the error is not a finite number".to_owned()),
            };
            let wall = best.as_ref().map_or(run.wall, |best| best.wall.min(run.wall));
            best = Some(Point { method, setting, outcome, wall, statistics: run.statistics });
            if begun.elapsed() > REPEAT_WITHIN {
                break;
            }
        }
        best
    }

    /// One run with looks.
    fn run(&mut self, method: Method, setting: Setting, limit: Option<Duration>) -> Result<Run, RunError> {
        let model = self.model;
        let options = match setting {
            Setting::Tolerance(tolerance) => Options { relative: tolerance, absolute: tolerance, ..Options::default() },
            Setting::Step(step) => Options { step: Some(step), ..Options::default() },
        };
        let State { position, velocity } = self.start;
        let start = Start { time: 0.0, position, velocity, end: self.plan.duration };
        let wrong = |error| named(model, &error);
        let mut stepper = method.start(&mut self.motion, &options, start).map_err(wrong)?;
        let mut looks = Vec::new();
        let mut wall = Duration::ZERO;
        let mut end = End::Reached;
        while !stepper.finished() {
            let before = Instant::now();
            for _ in 0..STRIDE {
                stepper.step(&mut self.motion).map_err(wrong)?;
                if stepper.time() >= self.due(looks.len()) {
                    break;
                }
            }
            wall += before.elapsed();
            self.look(stepper.as_mut(), &mut looks).map_err(wrong)?;
            let part = stepper.time() / self.plan.duration;
            if !(self.go_on)((self.done as f64 + part) / self.runs as f64) {
                end = End::Interrupted;
                break;
            }
            if limit.is_some_and(|limit| wall > limit) && !stepper.finished() {
                end = End::GivenUp;
                break;
            }
        }
        Ok(Run { end, looks, wall, statistics: *stepper.statistics() })
    }

    /// Every look that is due within the last step.
    fn look(&mut self, stepper: &mut dyn Stepper<Equations>, looks: &mut Vec<Look>) -> Result<(), StepError> {
        while looks.len() < LOOKS as usize {
            let due = self.due(looks.len());
            if stepper.time() < due {
                break;
            }
            let State { mut position, mut velocity } = self.start.clone();
            stepper.interpolate(&mut self.motion, due, &mut position, &mut velocity)?;
            let energies = self.motion.energies(due, &position, &velocity);
            let energy = energies.kinetic + energies.potential;
            looks.push(Look { state: State { position, velocity }, energy });
        }
        Ok(())
    }

    /// The time of a look (s).
    fn due(&self, look: usize) -> f64 {
        self.plan.duration * (look + 1) as f64 / f64::from(LOOKS)
    }

    fn compare(&self, run: &[Look], reference: &[Look]) -> Errors {
        let (positions, velocities) = self.motion.scales();
        let mut errors = Errors { state: 0.0, energy: 0.0 };
        for (run, reference) in run.iter().zip(reference) {
            let state = distance(&run.state.position, &reference.state.position, positions).max(distance(
                &run.state.velocity,
                &reference.state.velocity,
                velocities,
            ));
            errors.state = errors.state.max(state);
            errors.energy = errors.energy.max((run.energy - reference.energy).abs());
        }
        errors
    }
}

/// The largest difference of two lists, each component in its scale; infinite where a number is not finite.
fn distance(x: &[f64], y: &[f64], scales: &[f64]) -> f64 {
    let differences = x.iter().zip(y).zip(scales).map(|((x, y), scale)| (x - y).abs() / scale);
    differences.map(|d| if d.is_finite() { d } else { f64::INFINITY }).fold(0.0, f64::max)
}
