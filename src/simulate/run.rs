//! The time loop.

use super::choice::Choice;
use super::dead_centre;
use super::error::{RunError, named};
use super::events::{Events, Hit, Kind, Occurrence, Turn};
use super::ledger::{GAUSS, Ledger};
use super::pace::{Creep, Pace};
use super::problem::Motion;
use super::sampler::Sampler;
use super::settings::Settings;
use super::stiffness::fastest;
use super::stops::Side;
use super::timetable::Timetable;
use crate::integrate::{Method, Options, Problem, Start, Statistics, Stepper};
use crate::model::{Model, StopLaw};
use crate::record::{Event, Recorder};
use crate::spatial::Pose;
use std::time::{Duration, Instant};

/// Step of the fixed-step method where none is given: this part of the scene's own time, and never above 1 ms.
const FIXED_STEP: f64 = 0.01;

/// An explicit method that cannot take longer steps is refused (s).
const SHORTEST_USEFUL_STEP: f64 = 1e-9;

/// What comes back from an impact with fewer than this many tolerances of a speed comes to rest.
const REST_SPEEDS: f64 = 10.0;
/// So does what would rise by fewer than about this many roundings of a coordinate: it would fall as fast by rounding alone.
const ROUNDED_HEIGHT: f64 = 8.0;
/// Rounding of a coordinate on its limit, of one and more.
const ON_THE_LIMIT: f64 = 1e-12;

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
    /// What happened on the way, in order of time.
    pub events: Vec<Occurrence>,
    /// The event that ended the run.
    pub stopped_by: Option<String>,
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
    /// Work of motors, drives and loads without a potential (J).
    pub work: f64,
    /// What dampers and impacts took out (J).
    pub dissipated: f64,
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
    let start = &start;
    check_limits(model, start)?;
    let mut resting = Vec::new();
    for (index, stop) in model.stops.iter().enumerate() {
        for side in stop.signs().map(|sign| Side { stop: index, sign }) {
            let depth = stop.depth(side.sign, &start.position);
            motion.push(side, depth > 0.0 && stop.push(side.sign, &start.position, &start.velocity) > 0.0);
            let slack = ON_THE_LIMIT * stop.limit(side.sign).abs().max(1.0);
            let rigid = matches!(stop.law, StopLaw::Rigid { .. });
            if rigid && depth.abs() <= slack && start.velocity[stop.velocity] == 0.0 {
                // What lies on a stop from the start stays there while it presses.
                let fault = |fault| RunError::Sample { time: 0.0, fault };
                motion.hold(0.0, start, side).map_err(fault)?;
                let held = motion.held().len() - 1;
                match motion.pressure(0.0, start, held) > 0.0 {
                    true => resting.push(side),
                    false => motion.release(0.0, start, held).map_err(fault)?,
                }
            }
        }
    }
    let energies = motion.energies(0.0, &start.position, &start.velocity);
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
        events: Events::new(model, start),
        happened: Vec::new(),
        stopped_by: None,
        timetable: Timetable::new(model, settings.duration),
    };
    if let Some(events) = &mut run.events {
        for side in resting {
            let stop = &model.stops[side.stop];
            let (name, value) = (model.bodies[stop.body].name.clone(), stop.limit(side.sign));
            events.happened.push(Occurrence { time: 0.0, kind: Kind::Rest, name, value, speed: 0.0 });
        }
        events.arm(&mut motion, 0.0, start);
    }
    run.sampler.sample(&mut motion, &run.ledger, 0.0, start, recorder)?;
    let end_time = run.go(&mut motion, settings, recorder, go_on)?;
    let now = motion.energies(end_time, &run.state.position, &run.state.velocity);
    let mut poses = Vec::new();
    motion.at(end_time).poses(&mut poses);
    Ok(Summary {
        end_time,
        interrupted: end_time < settings.duration && run.stopped_by.is_none(),
        events: run.happened,
        stopped_by: run.stopped_by,
        integrators: run.integrators,
        choice: run.choice,
        statistics: run.statistics,
        energy_start: energies.kinetic + energies.potential,
        energy_end: now.kinetic + now.potential,
        work: run.ledger.energy(&now).work,
        dissipated: run.ledger.energy(&now).dissipated,
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
    /// `None` for a model without stops and events.
    events: Option<Events>,
    /// What is told of so far.
    happened: Vec<Occurrence>,
    stopped_by: Option<String>,
    timetable: Timetable,
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
        let mut choice = Choice::new(settings, self.model, self.timetable.is_empty());
        let mut time = 0.0;
        loop {
            let next = self.timetable.next(time);
            choice.restart();
            if self.integrators.last() != Some(&choice.method) {
                self.refuse_hopeless(motion, choice.method, time)?;
                self.integrators.push(choice.method);
            }
            let mut stepper = self.stepper(motion, settings, choice.method, time)?;
            let mut pace = Pace::new(time);
            let (mut switch, mut stopped, mut turn) = (false, false, None);
            while !stepper.finished() && !switch && !stopped && turn.is_none() {
                let hit = self.step(motion, stepper.as_mut())?;
                time = hit.map_or(stepper.time(), |hit| hit.time);
                turn = hit.map(|hit| hit.turn);
                self.tell(motion, Some(stepper.as_mut()), recorder)?;
                self.sampler.up_to(motion, &self.ledger, stepper.as_mut(), time, recorder)?;
                if let Some(creep) = pace.see(time, settings.duration).filter(|_| !choice.method.needs_step()) {
                    return Err(self.creeps(motion, time, creep));
                }
                stopped = !go_on(time, &self.state);
                switch = turn.is_none() && choice.review(motion, stepper.as_ref());
            }
            add(&mut self.statistics, stepper.statistics());
            if switch {
                let (name, value) = (choice.method.name().to_owned(), time - stepper.previous_time());
                self.mark(Occurrence { time, kind: Kind::Switch, name, value, speed: 0.0 }, recorder)?;
            }
            self.choice = choice.said();
            let turned = turn.is_some();
            if let Some(turn) = turn {
                self.turn(motion, settings, time, turn)?;
                self.tell(motion, None, recorder)?;
            }
            if self.stopped_by.is_some() {
                let state = self.state.clone();
                self.sampler.sample(motion, &self.ledger, time, &state, recorder)?;
            }
            if time >= settings.duration || stopped || self.stopped_by.is_some() {
                return Ok(time);
            }
            if !turned && time >= self.timetable.end(next) {
                time = next;
            }
        }
    }

    /// Hands on what happened since the last call, after the samples before it where those are not made yet.
    fn tell(
        &mut self,
        motion: &mut Motion<'m>,
        mut stepper: Option<&mut dyn Stepper<Motion<'m>>>,
        recorder: &mut dyn Recorder,
    ) -> Result<(), RunError> {
        let happened = self.events.as_mut().map_or_else(Vec::new, |events| std::mem::take(&mut events.happened));
        for occurrence in happened {
            if let Some(stepper) = &mut stepper {
                self.sampler.up_to(motion, &self.ledger, *stepper, occurrence.time, recorder)?;
            }
            self.mark(occurrence, recorder)?;
        }
        Ok(())
    }

    fn mark(&mut self, occurrence: Occurrence, recorder: &mut dyn Recorder) -> Result<(), RunError> {
        let name = match occurrence.kind {
            Kind::Switch => "integrator".to_owned(),
            _ => occurrence.name.clone(),
        };
        recorder.event(&Event { time: occurrence.time, name, text: occurrence.to_string() })?;
        self.happened.push(occurrence);
        Ok(())
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
            duration: Some(settings.duration),
            step: settings.step.or(default),
            rho_infinity: settings.rho_infinity,
            // A step that was asked for is kept.
            max_step: self.timetable.longest_step.filter(|_| !method.needs_step() && settings.step.is_none()),
            ..Options::default()
        };
        self.refuse_hopeless(motion, method, time)?;
        let end = self.timetable.end(self.timetable.next(time));
        let start = Start { time, position: &self.state.position, velocity: &self.state.velocity, end };
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

    fn creeps(&self, motion: &mut Motion<'m>, time: f64, Creep { step, left }: Creep) -> RunError {
        let fastest = fastest(motion, time, &self.state.position, &self.state.velocity);
        let (hinge, rate) = fastest.map_or(("of no name".to_owned(), f64::NAN), |fastest| {
            (self.model.label(fastest.coordinate), fastest.rate)
        });
        dead_centre::beside(RunError::Creep { time, step, left, hinge, rate }, self.model, time, &self.state)
    }

    /// One step, and the account of it up to its end or to what happens before.
    fn step(
        &mut self,
        motion: &mut Motion<'m>,
        stepper: &mut dyn Stepper<Motion<'m>>,
    ) -> Result<Option<Hit>, RunError> {
        let before = Instant::now();
        let (model, state) = (self.model, &self.state);
        stepper
            .step(motion)
            .map_err(|error| dead_centre::beside(named(model, &error), model, stepper.time(), state))?;
        self.wall += before.elapsed();
        let hit = match &mut self.events {
            Some(events) => events.look(motion, stepper)?,
            None => None,
        };
        let until = hit.map_or(stepper.time(), |hit| hit.time);
        let State { position, velocity } = &mut self.state;
        stepper.interpolate(motion, until, position, velocity).map_err(|error| named(self.model, &error))?;
        if self.model.is_constrained() {
            self.gap = self.gap.max(motion.at(until).gap(position));
        }
        if self.ledger.flows() {
            let (from, length) = (stepper.previous_time(), until - stepper.previous_time());
            for (node, weight) in GAUSS {
                let time = from + node * length;
                self.sampler.interpolate(motion, stepper, time)?;
                let State { position, velocity } = &self.sampler.state;
                let powers = motion.powers(time, position, velocity);
                self.ledger.add(&powers, weight * length);
            }
        }
        self.ledger.close_step(&motion.energies(until, &self.state.position, &self.state.velocity));
        Ok(hit)
    }

    /// What follows from an event.
    fn turn(&mut self, motion: &mut Motion<'m>, settings: &Settings, time: f64, turn: Turn) -> Result<(), RunError> {
        match turn {
            Turn::Push(side, pushes) => {
                // A pad that lets go before it is relaxed takes its spring's energy with it.
                let before = self.energy(motion, time);
                motion.push(side, pushes);
                self.ledger.lose(before - self.energy(motion, time));
            }
            Turn::Switch => {}
            Turn::Stop(event) => self.stopped_by = Some(self.model.events[event].name.clone()),
            Turn::Release(held) => {
                if motion.rests_with_others(held) {
                    return Err(self.jam(time, motion.held()[held]));
                }
                motion.release(time, &self.state, held).map_err(|fault| RunError::Sample { time, fault })?;
            }
            Turn::Strike(side) => self.strike(motion, settings, time, side)?,
        }
        if let Some(events) = &mut self.events {
            events.arm(motion, time, &self.state);
        }
        Ok(())
    }

    /// Kinetic plus potential energy now (J).
    fn energy(&self, motion: &mut Motion<'m>, time: f64) -> f64 {
        let energies = motion.energies(time, &self.state.position, &self.state.velocity);
        energies.kinetic + energies.potential
    }

    /// An impact: the speed comes back, or the coordinate stays where something presses it on.
    fn strike(&mut self, motion: &mut Motion<'m>, settings: &Settings, time: f64, side: Side) -> Result<(), RunError> {
        let fault = |fault| RunError::Sample { time, fault };
        let stop = &self.model.stops[side.stop];
        let StopLaw::Rigid { restitution } = stop.law else { return Ok(()) };
        self.state.position[stop.position] = stop.limit(side.sign);
        let speed = self.state.velocity[stop.velocity];
        let (_, scales) = motion.scales();
        let least = (REST_SPEEDS * settings.absolute_tolerance).max((ROUNDED_HEIGHT * f64::EPSILON).sqrt());
        let slow = restitution * speed.abs() <= least * scales[stop.velocity];
        let restitution = if slow { 0.0 } else { restitution };
        let before = self.energy(motion, time);
        let free = motion.strike(time, &mut self.state, side, restitution).map_err(fault)?;
        if !free && !slow {
            return Err(self.jam(time, side));
        }
        self.ledger.lose(before - self.energy(motion, time));
        let mut kind = Kind::Impact;
        if slow {
            motion.hold(time, &self.state, side).map_err(fault)?;
            let held = motion.held().len() - 1;
            if motion.pressure(time, &self.state, held) > 0.0 {
                kind = Kind::Rest;
            } else {
                motion.release(time, &self.state, held).map_err(fault)?;
            }
        }
        if let Some(events) = &mut self.events {
            let name = self.model.bodies[stop.body].name.clone();
            events.happened.push(Occurrence { time, kind, name, value: stop.limit(side.sign), speed });
        }
        Ok(())
    }

    /// A stop that something without another way runs through.
    fn jam(&self, time: f64, side: Side) -> RunError {
        let stop = &self.model.stops[side.stop];
        let drives: Vec<String> = self.model.drives.iter().map(|drive| format!("`{}`", drive.name)).collect();
        let by = if drives.is_empty() { "loops and gears".to_owned() } else { drives.join(", ") };
        RunError::Jam { time, hinge: self.model.bodies[stop.body].name.clone(), limit: stop.limit(side.sign), by }
    }
}

/// A run starts within its rigid limits: they are walls.
fn check_limits(model: &Model, start: &State) -> Result<(), RunError> {
    for stop in &model.stops {
        let value = start.position[stop.position];
        let slack = ON_THE_LIMIT * value.abs().max(1.0);
        let beyond = value < stop.range[0] - slack || value > stop.range[1] + slack;
        if beyond && matches!(stop.law, StopLaw::Rigid { .. }) {
            let hinge = model.bodies[stop.body].name.clone();
            return Err(RunError::Limit { hinge, value, low: stop.range[0], high: stop.range[1] });
        }
    }
    Ok(())
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
