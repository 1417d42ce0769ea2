//! Work and precision: what every method costs for the error it makes, on one scene.
//!
//! A run of each method at each tolerance (or step, where that is fixed) is compared with a reference run by another
//! method: `dop853` with the tolerance 10⁻¹³, and `dopri5` with the same for the points of `dop853` itself. What the two
//! references differ by is the smallest error that can be told.
//!
//! The error is the largest of all hinge coordinates and velocities at eight times spread evenly over the run, each in
//! its scale (1 rad, the scene's length, the same per the scene's time); between steps as dense output gives it. The
//! time is that of the steps alone.

use super::problem::Motion;
use super::run::{RunError, State, named};
use crate::integrate::{Method, Options, Problem, Start, Statistics, StepError, Stepper};
use crate::model::Model;
use std::time::{Duration, Instant};

/// Looks at the state are spread evenly over the run, the last one at its end.
const LOOKS: u32 = 8;
/// Steps between two looks at the clock and two calls of `go_on`.
const STRIDE: u64 = 64;
/// Short runs are repeated within this time, and the shortest counts.
const REPEAT_WITHIN: Duration = Duration::from_millis(60);
const MOST_REPEATS: u32 = 5;
/// Relative and absolute tolerance of the references.
const REFERENCE_TOLERANCE: f64 = 1e-13;
/// The reference of all methods but itself, and its own.
const REFERENCES: [Method; 2] = [Method::Dop853, Method::Dopri5];

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

/// Measures; asks `go_on` now and then with the part of all runs that is done. `None` where it was stopped before there
/// was anything to compare with.
///
/// # Errors
/// Where a reference cannot be made.
pub fn precision(
    model: &Model,
    start: &State,
    plan: &Plan,
    go_on: &mut dyn FnMut(f64) -> bool,
) -> Result<Option<Study>, RunError> {
    let runs = REFERENCES.len() + plan.methods.iter().map(|method| plan.settings(*method).len()).sum::<usize>();
    let mut bench = Bench { model, start, plan, motion: Motion::new(model), runs, done: 0, go_on };
    let mut references = Vec::new();
    for method in REFERENCES {
        match bench.run(method, Setting::Tolerance(REFERENCE_TOLERANCE), None)? {
            Run { end: End::Reached, looks, .. } => references.push(looks),
            Run { .. } => return Ok(None),
        }
        bench.done += 1;
    }
    let agreement = bench.compare(&references[0], &references[1]);
    let mut study = Study {
        references: REFERENCES,
        tolerance: REFERENCE_TOLERANCE,
        agreement,
        points: Vec::new(),
        interrupted: false,
    };
    for &method in &plan.methods {
        let reference = &references[usize::from(method == REFERENCES[0])];
        for setting in plan.settings(method) {
            let Some(point) = bench.point(method, setting, reference) else {
                study.interrupted = true;
                return Ok(Some(study));
            };
            study.points.push(point);
            bench.done += 1;
        }
    }
    Ok(Some(study))
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
    motion: Motion<'a>,
    /// How many runs there are, and how many are done.
    runs: usize,
    done: usize,
    go_on: &'g mut dyn FnMut(f64) -> bool,
}

impl<'a> Bench<'a, '_> {
    /// The point of a method; `None` where it was stopped from outside.
    fn point(&mut self, method: Method, setting: Setting, reference: &[Look]) -> Option<Point> {
        let none = Statistics::default();
        let failed = |why: String| Point { method, setting, outcome: Err(why), wall: Duration::ZERO, statistics: none };
        let begun = Instant::now();
        let mut best: Option<Point> = None;
        for _ in 0..MOST_REPEATS {
            let run = match self.run(method, setting, Some(self.plan.limit)) {
                Ok(run) => run,
                Err(error) => return Some(failed(error.to_string())),
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
    fn look(&mut self, stepper: &mut dyn Stepper<Motion<'a>>, looks: &mut Vec<Look>) -> Result<(), StepError> {
        while looks.len() < LOOKS as usize {
            let due = self.due(looks.len());
            if stepper.time() < due {
                break;
            }
            let State { mut position, mut velocity } = self.start.clone();
            stepper.interpolate(&mut self.motion, due, &mut position, &mut velocity)?;
            let energies = self.motion.at(due).energies(&position, &velocity);
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
