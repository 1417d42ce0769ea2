//! The time loop.

use super::ledger::{GAUSS, Ledger};
use super::problem::Motion;
use super::settings::{Integrator, Settings, Start as At};
use crate::dynamics::Fault;
use crate::integrate::{Component, Limit, Method, Options, Start, Statistics, StepError, Stepper};
use crate::model::Model;
use crate::record::{RecordError, Recorder, Sample};
use crate::spatial::{Pose, Wrench};
use std::time::{Duration, Instant};

/// Step of the fixed-step method where none is given: this part of the scene's own time, and never above 1 ms.
const FIXED_STEP: f64 = 0.01;

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
    /// Runs with one method, and with the implicit one from where the explicit one turns out to be held by stability.
    fn go(
        &mut self,
        motion: &mut Motion<'m>,
        settings: &Settings,
        recorder: &mut dyn Recorder,
        go_on: &mut dyn FnMut(f64, &State) -> bool,
    ) -> Result<f64, RunError> {
        let auto = settings.integrator == Integrator::Auto;
        let mut method = match settings.integrator {
            Integrator::Rk4 => Method::Rk4,
            Integrator::Dopri5 => Method::Dopri5,
            Integrator::Dop853 => Method::Dop853,
            Integrator::Sdirk4 => Method::Sdirk4,
            // What rests has only its fastest vibrations left: a method that need not follow them takes long steps.
            Integrator::Auto if settings.start == At::Equilibrium => Method::Sdirk4,
            Integrator::Auto => Method::Dopri5,
        };
        if auto {
            let choice = match method {
                Method::Sdirk4 => "auto: sdirk4, the run starts at rest",
                _ => "auto: dopri5, no stiffness was met",
            };
            self.choice = Some(choice.to_owned());
        }
        let mut time = 0.0;
        loop {
            self.integrators.push(method);
            let mut stepper = self.stepper(motion, settings, method, time)?;
            let mut switch = false;
            let mut stopped = false;
            while !stepper.finished() && !switch && !stopped {
                self.step(motion, stepper.as_mut())?;
                self.sampler.up_to(motion, &self.ledger, stepper.as_mut(), recorder)?;
                stopped = !go_on(stepper.time(), &self.state);
                switch = auto && method == Method::Dopri5 && stepper.stability_limited();
            }
            time = stepper.time();
            add(&mut self.statistics, stepper.statistics());
            if stepper.finished() || stopped {
                return Ok(time);
            }
            method = Method::Sdirk4;
            self.choice = Some(format!("auto: dopri5 was held by stability at t = {time:.3e} s, sdirk4 from there"));
        }
    }

    fn stepper(
        &mut self,
        motion: &mut Motion<'m>,
        settings: &Settings,
        method: Method,
        time: f64,
    ) -> Result<Box<dyn Stepper<Motion<'m>>>, RunError> {
        let step = match (method, settings.step) {
            (Method::Rk4, None) => Some((FIXED_STEP * self.model.time_scale()).min(1e-3)),
            (_, step) => step,
        };
        let options =
            Options { relative: settings.tolerance, absolute: settings.absolute_tolerance, step, ..Options::default() };
        motion.set_retries(method != Method::Rk4 && settings.step.is_none());
        let start =
            Start { time, position: &self.state.position, velocity: &self.state.velocity, end: settings.duration };
        method.start(motion, &options, start).map_err(|error| named(self.model, &error))
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

/// Samples at equal times, and at the very end.
struct Sampler {
    rate: f64,
    end: f64,
    count: usize,
    /// Index of the next sample: due at `next / rate`.
    next: u64,
    state: State,
    accelerations: Vec<f64>,
    residual: Vec<f64>,
    poses: Vec<Pose>,
    reactions: Vec<Wrench>,
}

impl Sampler {
    fn new(model: &Model, rate: f64, end: f64) -> Self {
        let n = model.velocity_count();
        Self {
            rate,
            end,
            count: 0,
            next: 1,
            state: State { position: model.start_position.clone(), velocity: model.start_velocity.clone() },
            accelerations: vec![0.0; n],
            residual: vec![0.0; n],
            poses: Vec::new(),
            reactions: Vec::new(),
        }
    }

    fn interpolate<'m>(
        &mut self,
        motion: &mut Motion<'m>,
        stepper: &mut dyn Stepper<Motion<'m>>,
        time: f64,
    ) -> Result<(), RunError> {
        let State { position, velocity } = &mut self.state;
        stepper.interpolate(motion, time, position, velocity).map_err(|error| named(motion.model(), &error))?;
        // Between the ends of a step the state is as good as the interpolation: loops are closed by hand.
        motion.at(time).settle(position, velocity).map_err(|fault| RunError::Sample { time, fault })?;
        Ok(())
    }

    /// Every sample due within the last step.
    fn up_to<'m>(
        &mut self,
        motion: &mut Motion<'m>,
        ledger: &Ledger,
        stepper: &mut dyn Stepper<Motion<'m>>,
        recorder: &mut dyn Recorder,
    ) -> Result<(), RunError> {
        loop {
            let due = (self.next as f64 / self.rate).min(self.end);
            let last = stepper.finished() && due >= self.end;
            if due > stepper.time() {
                return Ok(());
            }
            self.interpolate(motion, stepper, due)?;
            let state = self.state.clone();
            self.sample(motion, ledger, due, &state, recorder)?;
            self.next += 1;
            if last {
                return Ok(());
            }
        }
    }

    fn sample(
        &mut self,
        motion: &mut Motion<'_>,
        ledger: &Ledger,
        time: f64,
        state: &State,
        recorder: &mut dyn Recorder,
    ) -> Result<(), RunError> {
        let system = motion.at(time);
        let (q, v) = (&state.position, &state.velocity);
        let fault = |fault| RunError::Sample { time, fault };
        system.accelerations(q, v, &mut self.accelerations).map_err(fault)?;
        system.residual(q, v, &self.accelerations, &mut self.residual).map_err(fault)?;
        system.reactions(&mut self.reactions);
        system.poses(&mut self.poses);
        let energy = ledger.energy(&system.energies(q, v));
        recorder.sample(&Sample {
            time,
            positions: q,
            velocities: v,
            accelerations: &self.accelerations,
            bodies: &self.poses,
            reactions: &self.reactions,
            energy,
        })?;
        self.count += 1;
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
