//! The time loop.

use super::choice::Choice;
use super::ledger::{GAUSS, Ledger};
use super::problem::Motion;
use super::sampler::Sampler;
use super::settings::Settings;
use super::stiffness::fastest;
use crate::dynamics::Fault;
use crate::integrate::{Component, Limit, Method, Options, Start, Statistics, StepError, Stepper};
use crate::model::Model;
use crate::record::{RecordError, Recorder};
use crate::spatial::Pose;
use std::time::{Duration, Instant};

/// Step of the fixed-step method where none is given: this part of the scene's own time, and never above 1 ms.
const FIXED_STEP: f64 = 0.01;

/// An explicit method that cannot take longer steps is refused (s).
const SHORTEST_USEFUL_STEP: f64 = 1e-9;

/// A state to start from.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Hinge coordinates.
    pub position: Vec<f64>,
    /// Hinge velocities.
    pub velocity: Vec<f64>,
}

/// What a run did.
#[derive(Debug, Clone)]
pub struct Summary {
    /// Reached time (s).
    pub end_time: f64,
    /// Whether it was stopped from outside before its end.
    pub interrupted: bool,
    /// The methods that were used, in order.
    pub integrators: Vec<Method>,
    /// Why the method is what it is, where it was chosen.
    pub choice: Option<String>,
    /// Work of all methods.
    pub statistics: Statistics,
    /// Kinetic plus potential energy at the start (J).
    pub energy_start: f64,
    /// Kinetic plus potential energy at the end (J).
    pub energy_end: f64,
    /// Largest |E − E₀ − work done + dissipated| at the ends of steps (J).
    pub energy_drift: f64,
    /// Widest gap of loops, gears and drives at the ends of steps (m; rad times the scene's length).
    pub constraint_error: f64,
    /// The last state.
    pub state: State,
    /// Root markers of the named bodies at the end.
    pub poses: Vec<Pose>,
    /// Number of samples handed to the recorder.
    pub samples: usize,
    /// Time spent in steps (s).
    pub wall: Duration,
}

/// Why a run ended early.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The integrator cannot go on.
    #[error("{0}")]
    Step(String),
    /// An explicit method on a scene that is far too stiff for it.
    #[error(
        "`{method}` is an explicit method and would need steps below {step:.1e} s: the hinge coordinate {hinge} moves at \
         {rate:.1e} per second; try `integrator = \"radau9\"`, \"sdirk4\" or \"auto\", or a softer spring or damper there"
    )]
    Stiff {
        /// The method.
        method: &'static str,
        /// The velocity coordinate that moves fastest.
        hinge: String,
        /// Its angular frequency or decay rate (1/s).
        rate: f64,
        /// Longest stable step (s).
        step: f64,
    },
    /// The system cannot be evaluated where a sample is due.
    #[error("at t = {time} s: {fault}")]
    Sample {
        /// (s)
        time: f64,
        /// Why.
        fault: Fault,
    },
    /// The recording cannot be written.
    #[error(transparent)]
    Record(#[from] RecordError),
}

/// Steps from `start` to the end of the run, hands samples to `recorder` at `rate` per second, and asks `go_on` after
/// every step with the time reached.
///
/// # Errors
/// Where a step cannot be made or a sample cannot be kept; what was recorded until then stays.
pub fn run(
    model: &Model,
    settings: &Settings,
    rate: f64,
    start: &State,
    recorder: &mut dyn Recorder,
    go_on: &mut dyn FnMut(f64, &State) -> bool,
) -> Result<Summary, RunError> {
    let mut motion = Motion::new(model);
    let mut start = start.clone();
    motion
        .at(0.0)
        .settle(&mut start.position, &mut start.velocity)
        .map_err(|fault| RunError::Sample { time: 0.0, fault })?;
    let energies = motion.at(0.0).energies(&start.position, &start.velocity);
    let mut run = Run {
        model,
        gap: motion.at(0.0).gap(&start.position),
        ledger: Ledger::new(model, energies),
        sampler: Sampler::new(model, rate, settings.duration),
        state: start.clone(),
        wall: Duration::ZERO,
        integrators: Vec::new(),
        choice: None,
        statistics: Statistics::default(),
    };
    run.sampler.sample(&mut motion, &run.ledger, 0.0, &start, recorder)?;
    let end_time = run.go(&mut motion, settings, recorder, go_on)?;
    let now = motion.at(end_time).energies(&run.state.position, &run.state.velocity);
    let mut poses = Vec::new();
    motion.at(end_time).poses(&mut poses);
    Ok(Summary {
        end_time,
        interrupted: end_time < settings.duration,
        integrators: run.integrators,
        choice: run.choice,
        statistics: run.statistics,
        energy_start: energies.kinetic + energies.potential,
        energy_end: now.kinetic + now.potential,
        energy_drift: run.ledger.drift,
        constraint_error: run.gap,
        state: run.state,
        poses,
        samples: run.sampler.count,
        wall: run.wall,
    })
}

struct Run<'m> {
    model: &'m Model,
    gap: f64,
    ledger: Ledger,
    sampler: Sampler,
    state: State,
    wall: Duration,
    integrators: Vec<Method>,
    choice: Option<String>,
    statistics: Statistics,
}

impl<'m> Run<'m> {
    /// Runs with one method, or from one to the other where the choice is the program's.
    fn go(
        &mut self,
        motion: &mut Motion<'m>,
        settings: &Settings,
        recorder: &mut dyn Recorder,
        go_on: &mut dyn FnMut(f64, &State) -> bool,
    ) -> Result<f64, RunError> {
        let mut choice = Choice::new(settings);
        let mut time = 0.0;
        loop {
            self.integrators.push(choice.method);
            let mut stepper = self.stepper(motion, settings, choice.method, time)?;
            let mut switch = false;
            let mut stopped = false;
            while !stepper.finished() && !switch && !stopped {
                self.step(motion, stepper.as_mut())?;
                self.sampler.up_to(motion, &self.ledger, stepper.as_mut(), recorder)?;
                stopped = !go_on(stepper.time(), &self.state);
                switch = choice.review(motion, stepper.as_ref());
            }
            time = stepper.time();
            add(&mut self.statistics, stepper.statistics());
            self.choice = choice.said();
            if stepper.finished() || stopped {
                return Ok(time);
            }
        }
    }

    fn stepper(
        &mut self,
        motion: &mut Motion<'m>,
        settings: &Settings,
        method: Method,
        time: f64,
    ) -> Result<Box<dyn Stepper<Motion<'m>>>, RunError> {
        let default = method.needs_step().then(|| (FIXED_STEP * self.model.time_scale()).min(1e-3));
        let options = Options {
            relative: settings.tolerance,
            absolute: settings.absolute_tolerance,
            step: settings.step.or(default),
            rho_infinity: settings.rho_infinity,
            ..Options::default()
        };
        motion.set_retries(!options.fixed && !method.needs_step());
        self.refuse_hopeless(motion, method, time)?;
        let start =
            Start { time, position: &self.state.position, velocity: &self.state.velocity, end: settings.duration };
        method.start(motion, &options, start).map_err(|error| named(self.model, &error))
    }

    /// An explicit method that stability would hold below any useful step is refused.
    fn refuse_hopeless(&self, motion: &mut Motion<'m>, method: Method, time: f64) -> Result<(), RunError> {
        let Some(reach) = method.stability_reach() else { return Ok(()) };
        let State { position, velocity } = &self.state;
        let Some(fastest) = fastest(motion, time, position, velocity) else { return Ok(()) };
        let step = reach / fastest.rate;
        if step >= SHORTEST_USEFUL_STEP {
            return Ok(());
        }
        Err(RunError::Stiff {
            method: method.name(),
            hinge: self.model.label(fastest.coordinate),
            rate: fastest.rate,
            step,
        })
    }

    fn step(&mut self, motion: &mut Motion<'m>, stepper: &mut dyn Stepper<Motion<'m>>) -> Result<(), RunError> {
        let before = Instant::now();
        stepper.step(motion).map_err(|error| named(self.model, &error))?;
        self.wall += before.elapsed();
        self.state.position.copy_from_slice(stepper.position());
        self.state.velocity.copy_from_slice(stepper.velocity());
        if self.model.is_constrained() {
            self.gap = self.gap.max(motion.at(stepper.time()).gap(&self.state.position));
        }
        if self.ledger.flows() {
            let (from, length) = (stepper.previous_time(), stepper.time() - stepper.previous_time());
            for (node, weight) in GAUSS {
                let time = from + node * length;
                self.sampler.interpolate(motion, stepper, time)?;
                let State { position, velocity } = &self.sampler.state;
                let powers = motion.at(time).powers(position, velocity);
                self.ledger.add(&powers, weight * length);
            }
        }
        self.ledger.close_step(motion.at(stepper.time()), &self.state.position, &self.state.velocity);
        Ok(())
    }
}

fn add(sum: &mut Statistics, part: &Statistics) {
    sum.steps += part.steps;
    sum.rejected_steps += part.rejected_steps;
    sum.acceleration_evaluations += part.acceleration_evaluations;
    sum.residual_evaluations += part.residual_evaluations;
    sum.jacobian_evaluations += part.jacobian_evaluations;
    sum.solves += part.solves;
    sum.newton_iterations += part.newton_iterations;
}

/// The error with the hinge's name in place of an index.
pub(super) fn named(model: &Model, error: &StepError) -> RunError {
    let text = error.to_string();
    let component = match error.limit() {
        Some(Limit::ErrorEstimate(component) | Limit::NotFinite(component)) => *component,
        _ => return RunError::Step(text),
    };
    let body = match component {
        Component::Position(index) => model
            .bodies
            .iter()
            .find(|body| (body.hinge.position..body.hinge.position + body.hinge.kind.counts().0).contains(&index))
            .map(|body| format!("the position of `{}`", body.name)),
        Component::Velocity(index) => Some(format!("the velocity of {}", model.label(index))),
    };
    RunError::Step(match body {
        Some(body) => text.replace(&component.to_string(), &body),
        None => text,
    })
}
