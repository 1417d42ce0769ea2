//! The time loop of one structure.

mod fine;
mod instants;
pub(super) mod prepared;
mod stepper;
mod steps;
pub(super) mod together;
mod touching;
mod transition;

use crate::integrate::{Method, Statistics, Stepper};
use crate::model::Model;
use crate::model::beam::Wound;
use crate::model::description::When;
use crate::model::stop::sides;
use crate::record::{Event, Recorder};
use crate::round_off::TIME;
use crate::simulate::asked::Asked;
use crate::simulate::checks::pace::EventPace;
use crate::simulate::choice::Choice;
use crate::simulate::control::{Control, Function};
use crate::simulate::error::RunError;
use crate::simulate::events::search::Search;
use crate::simulate::events::timetable::Timetable;
use crate::simulate::events::{Events, Hit, Kind, Occurrence};
use crate::simulate::mode::Mode;
use crate::simulate::problem::Equations;
use crate::simulate::resting;
use crate::simulate::samples::ledger::{Booked, Ledger};
use crate::simulate::samples::sampler::Sampler;
use crate::simulate::settings::{Integrator, Resume, Settings};
use crate::simulate::state::State;
use crate::simulate::stiffness::fastest;
use crate::simulate::stops::instant::{self, Outcome};
use crate::spatial::Pose;
use prepared::Prepared;
use std::sync::Arc;
use std::time::{Duration, Instant};
use steps::Ending;

/// Step of the fixed-step method where none is given: this part of the scene's own time, and never above 1 ms...
const FIXED_STEP: f64 = 0.01;
/// ... nor above this part of the time in which a compliant stop turns something around: what methods of order 4 make of that is 1e-7 of its energy.
const OF_A_PUSH: f64 = 0.05;

/// An explicit method that cannot take longer steps is refused (s).
const SHORTEST_USEFUL_STEP: f64 = 1e-9;

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
    /// Events at the same instant at which it would have ended, too.
    pub stopped_with: Vec<String>,
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
    /// Largest |E − E₀ − work done + dissipated| at the ends of steps and at samples (J).
    pub energy_drift: f64,
    /// The largest energy at the ends of steps and at samples: kinetic, kinetic plus potential, put in, taken out (J).
    pub energy_largest: f64,
    /// Widest gap of loops, gears and drives at the ends of steps (m; rad times the scene's length).
    pub constraint_error: f64,
    /// Outputs that were told with stages: which stage, the name of the number, the number.
    pub told: Vec<(String, String, f64)>,
    /// Stages that did not come: which, and what it waits for.
    pub pending: Vec<(String, When)>,
    /// The last state, of this model.
    pub state: State,
    /// The model at the end: after changes of structure another one than at the start.
    pub model: Arc<Model>,
    /// What a run needs beside it to go on from there.
    pub resume: Resume,
    /// Root markers of the named bodies at the end.
    pub poses: Vec<Pose>,
    /// The tolerance asked for.
    pub tolerance: f64,
    /// The outputs at the end, in the order of the model.
    pub outputs: Vec<f64>,
    /// What the inputs are at the end, in the order of [`Model::inputs`] (N or N m).
    pub inputs: Vec<f64>,
    /// What the controllers remember at the end, in the order of the model.
    pub memories: Vec<Vec<f64>>,
    /// Beams with elements that turned by more than 1.5 rad in a sample: when they turned most (s), and by how much.
    pub wound: Vec<(f64, Wound)>,
    /// Motors whose formulas switched to and fro, or too often: steps went across their switches.
    pub across: Vec<String>,
    /// Impacts: of hinges on their stops, and between bodies.
    pub impacts: usize,
    /// Impacts between bodies that came back with less than their restitution, as all of it would have gained energy.
    pub held_back: usize,
    /// Steps that captured contacts instead of following their events.
    pub capture_steps: usize,
    /// Number of samples handed to the recorder.
    pub samples: usize,
    /// Time spent in steps and in what happens between them (s).
    pub wall: Duration,
}

/// A run of one structure. If it goes on where the run of another one ended, `booked` is what that one's ledger has.
///
/// # Errors
/// As [`crate::simulate::run`].
pub(super) fn run_one(
    model: &Arc<Model>,
    start: &State,
    asked: Asked<'_, '_>,
    booked: Option<&Booked>,
) -> Result<Summary, RunError> {
    let Asked { settings, rate, recorder, go_on, search, function } = asked;
    let given = model;
    let (prepared, mut motion) = Prepared::new(model, settings, start, function.is_none())?;
    let held = Arc::clone(&prepared.model);
    let (mut run, energy_start) =
        Run::begin(&held, &mut motion, settings, rate, (prepared, search, function, booked), recorder)?;
    let resume = run.go(&mut motion, settings, recorder, go_on)?;
    run.end(&mut motion, settings, resume, energy_start, given)
}

/// The step of a fixed-step method; `None` for an adaptive one.
fn fixed_step(model: &Model, settings: &Settings, method: Method) -> Option<f64> {
    let default = || (FIXED_STEP * model.time_scale()).min(1e-3).min(OF_A_PUSH * model.shortest_push());
    method.needs_step().then(|| settings.step.unwrap_or_else(default))
}

/// The grid of fixed steps that a run goes on with.
fn resumed_grid(settings: &Settings, step: f64) -> Option<(f64, u64)> {
    let resume = settings.resume.as_ref().filter(|resume| resume.step == Some(step))?;
    resume.grid.map(|grid| (grid.origin, grid.steps))
}

/// When a run of fixed steps ends (s). An end that lies on the grid of these steps but for rounding is that of the grid, so that the last
/// step is one like all others; one that lies so at an instant of controllers is the instant, as in a run that goes on beyond it.
fn end(model: &Model, settings: &Settings, function: Option<&Function<'_>>) -> f64 {
    let (begin, end) = (settings.begin(), settings.begin() + settings.duration);
    let Integrator::Method(method) = settings.integrator else { return end };
    let Some(step) = fixed_step(model, settings, method) else { return end };
    let is_meant = |time: &f64| TIME.hides(time - end, end.abs());
    let periods = model.controllers.iter().map(|one| one.period).chain(function.map(|function| function.period));
    let instants = periods.map(|period| (end / period).round() * period).filter(is_meant);
    if let Some(instant) = instants.reduce(f64::min) {
        return instant;
    }
    let (origin, _) = resumed_grid(settings, step).unwrap_or((begin, 0));
    let on_grid = origin + ((end - origin) / step).round() * step;
    if is_meant(&on_grid) { on_grid } else { end }
}

/// Goes on in the mode of the run before: what has changed since then alone is an event.
fn taken_up(
    motion: &mut Equations,
    settings: &Settings,
    state: &mut State,
    mode: &Arc<Mode>,
) -> Result<Outcome, RunError> {
    let begin = settings.begin();
    let model = Arc::clone(motion.model());
    if mode.has_contacts() {
        touching::allow(motion, &model, settings)?;
    }
    motion.set_mode(begin, state, mode)?;
    match mode.follows_steps() {
        true => Ok(Outcome::default()),
        false => instant::resolve(motion, begin, state, settings.absolute_tolerance, None),
    }
}

struct Run<'m, 'f> {
    model: &'m Arc<Model>,
    /// When it ends (s).
    end: f64,
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
    event_pace: EventPace,
    /// Motors whose formulas are followed across their switches.
    across: Vec<String>,
    /// What is told of so far.
    happened: Vec<Occurrence>,
    stopped_by: Option<String>,
    stopped_with: Vec<String>,
    timetable: Timetable,
    /// Captured steps are this part of what they may be.
    captured: f64,
    /// `None` if nothing sets inputs.
    control: Option<Control<'f>>,
    /// The step that would have followed the last one before an instant (s).
    carried: Option<f64>,
    /// Whether contact holds the scene at rest, from its start to its end.
    rests: bool,
    /// Since captured steps handed back: when that was (s), and how many steps had been tried.
    handed_back: Option<(f64, u64)>,
}

impl<'m, 'f> Run<'m, 'f> {
    /// Decides what happens at the first instant, and records it; with the energy there (J).
    fn begin(
        model: &'m Arc<Model>,
        motion: &mut Equations,
        settings: &Settings,
        rate: f64,
        (prepared, search, function, booked): (Prepared, Search, Option<Function<'f>>, Option<&Booked>),
        recorder: &mut dyn Recorder,
    ) -> Result<(Self, f64), RunError> {
        let (begin, end) = (settings.begin(), end(model, settings, function.as_ref()));
        let Prepared { mut state, contacts, rests, .. } = prepared;
        motion.set_tolerance(settings.absolute_tolerance);
        if model.has_boundaries() {
            motion.at(begin, &state.position, &state.velocity).keep_laws();
        }
        let mode = settings.resume.as_ref().and_then(|resume| resume.mode.as_ref()).filter(|_| !rests);
        let outcome = match mode {
            Some(mode) => taken_up(motion, settings, &mut state, mode)?,
            None => instant::resolve(motion, begin, &mut state, settings.absolute_tolerance, None)?,
        };
        match rests {
            true => resting::prove(motion, begin, &state)?,
            false if model.contacts.is_empty() || motion.contacts.is_some() => {}
            false => touching::allow(motion, model, settings)?,
        }
        let mut before = motion.energies(begin, &state.position, &state.velocity);
        before.kinetic += outcome.lost - outcome.work;
        let mut ledger = Ledger::new(model, begin, before).going_on(booked);
        ledger.lose(outcome.lost);
        ledger.put_in(outcome.work);
        let goes_on = settings.resume.is_some();
        let mut events = Events::new(model, &state, search, (settings.absolute_tolerance, goes_on));
        if let Some(events) = &mut events {
            // What a stop pushes with from the start is no event.
            events.happened = outcome.happened;
            events.happened.retain(|occurrence| occurrence.kind != Kind::Contact);
            events.arm(motion, begin, &state);
        }
        let mut run = Run {
            model,
            end,
            gap: motion.at(begin, &state.position, &state.velocity).gap(),
            ledger,
            sampler: Sampler::new(model, rate, [begin, end]),
            state,
            wall: Duration::ZERO,
            integrators: Vec::new(),
            choice: None,
            statistics: Statistics::default(),
            events,
            across: Vec::new(),
            event_pace: EventPace::new(
                sides(&model.stops).count() + model.hinge_friction.len() + motion.system.boundaries().count(),
            ),
            happened: Vec::new(),
            stopped_by: None,
            stopped_with: Vec::new(),
            timetable: Timetable::new(model, [begin, end], search.stride),
            captured: search.captured,
            control: Control::new(model, begin, function),
            carried: None,
            rests,
            handed_back: None,
        };
        run.sampler.contacts = contacts;
        if !mode.is_some_and(|mode| mode.follows_steps()) {
            run.touch_as(motion, begin, mode.is_some())?;
        }
        if booked.is_none_or(|booked| !booked.has_run)
            && let Equations { contacts: Some(contacts), system, .. } = motion
        {
            run.ledger.held_from_start(contacts.potential(system));
        }
        run.events.iter_mut().for_each(Events::forget);
        run.arm(motion, begin);
        if run.is_due(begin) {
            run.control(motion, settings, begin)?;
            // What controllers set may lift or slide what touches.
            run.touch(motion, begin, false)?;
            run.arm(motion, begin);
        }
        motion.foresee(begin, &run.state).map_err(|fault| RunError::Sample { time: begin, fault })?;
        run.sampler.sample(motion, &mut run.ledger, begin, &run.state.clone(), recorder)?;
        let energy_start = run.ledger.start();
        Ok((run, energy_start))
    }
}

impl Run<'_, '_> {
    /// What it did, for the model that was `given`.
    fn end(
        mut self,
        motion: &mut Equations,
        settings: &Settings,
        resume: Resume,
        energy_start: f64,
        given: &Arc<Model>,
    ) -> Result<Summary, RunError> {
        let outputs = self.sampler.outputs(motion, &self.ledger, resume.time, &self.state)?;
        let resume = Resume { mode: motion.mode().map(Arc::new), ..resume };
        let summary = self.summary(motion, settings, resume, energy_start);
        Ok(Summary { outputs, model: Arc::clone(given), ..summary })
    }

    fn summary(self, motion: &mut Equations, settings: &Settings, resume: Resume, energy_start: f64) -> Summary {
        let end_time = resume.time;
        let now = motion.energies(end_time, &self.state.position, &self.state.velocity);
        let account = self.ledger.energy(&now);
        let mut poses = Vec::new();
        motion.at(end_time, &self.state.position, &self.state.velocity).poses(&mut poses);
        let on_stops = self.happened.iter().filter(|occurrence| occurrence.kind == Kind::Impact).count();
        let impacts = on_stops + motion.contacts.as_ref().map_or(0, |contacts| contacts.impacts);
        Summary {
            end_time,
            interrupted: end_time < self.end && self.stopped_by.is_none(),
            events: self.happened,
            stopped_by: self.stopped_by,
            stopped_with: self.stopped_with,
            integrators: self.integrators,
            choice: self.choice,
            statistics: self.statistics,
            energy_start,
            energy_end: now.kinetic + now.potential,
            work: account.work,
            dissipated: account.dissipated,
            energy_drift: self.ledger.drift,
            energy_largest: self.ledger.largest,
            constraint_error: self.gap,
            state: self.state,
            model: Arc::clone(self.model),
            told: Vec::new(),
            pending: Vec::new(),
            resume,
            poses,
            tolerance: settings.tolerance,
            outputs: Vec::new(),
            inputs: motion.system.inputs().to_vec(),
            memories: self.control.map_or_else(Vec::new, |control| control.memories),
            impacts,
            held_back: motion.contacts.as_ref().map_or(0, |contacts| contacts.held_back),
            capture_steps: motion.contacts.as_ref().map_or(0, |contacts| contacts.captured()),
            samples: self.sampler.count,
            wound: self.sampler.wound,
            across: self.across,
            wall: self.wall,
        }
    }

    /// Runs with one method, or from one to the other where the choice is the program's.
    fn go(
        &mut self,
        motion: &mut Equations,
        settings: &Settings,
        recorder: &mut dyn Recorder,
        go_on: &mut dyn FnMut(f64, &State) -> bool,
    ) -> Result<Resume, RunError> {
        let mut choice = Choice::new(settings, self.model, self.timetable.is_empty());
        let mut time = settings.begin();
        loop {
            let next = self.next(time);
            choice.restart();
            if !self.rests && self.integrators.last() != Some(&choice.method) {
                self.refuse_hopeless(motion, choice.method, time)?;
                self.integrators.push(choice.method);
            }
            let origin = time;
            let mut stepper = self.stepper(motion, settings, choice.method, time)?;
            let ending = self.steps(motion, stepper.as_mut(), &mut choice, time, recorder, go_on)?;
            let Ending { transition, switches, captures, stopped, .. } = ending;
            time = ending.time;
            self.statistics.add(stepper.statistics());
            let resume = self.resume(settings, choice.method, stepper.as_mut(), [origin, time]);
            if switches && self.hands_back(motion, time) {
                self.hand_back(motion, settings, time, choice.method)?;
                self.mark_all(recorder)?;
            } else if switches {
                let (name, value) = (choice.method.name().to_owned(), time - stepper.previous_time());
                let unit = "s".to_owned();
                let switch = Occurrence { time, kind: Kind::Switch, name, value, unit, speed: 0.0, between: None };
                self.mark(switch, recorder)?;
            }
            self.choice = if self.rests { Some(resting::SAID.to_owned()) } else { choice.said() };
            if captures {
                self.mark_all(recorder)?;
                self.arm(motion, time);
            }
            let before = Instant::now();
            if let Some(transition) = transition {
                self.transition(motion, settings, choice.method, Hit { time, transition })?;
                self.wall += before.elapsed();
                self.mark_all(recorder)?;
            }
            if self.stopped_by.is_some() {
                let state = self.state.clone();
                self.sampler.sample(motion, &mut self.ledger, time, &state, recorder)?;
            }
            if time >= self.end || stopped || self.stopped_by.is_some() {
                return Ok(resume);
            }
            if (transition.is_none() || self.is_due(next)) && time >= self.segment_end(next) {
                let before = Instant::now();
                self.lose_mass(motion, time, next);
                self.jump(motion, settings, [time, next])?;
                time = next;
                if self.is_due(time) {
                    self.carried = resume.step;
                    self.control(motion, settings, time)?;
                }
                if motion.contacts.is_some() {
                    // What drives and motors do may be another thing from here on.
                    self.touch(motion, time, false)?;
                    self.arm(motion, time);
                }
                self.wall += before.elapsed();
                self.mark_all(recorder)?;
            }
        }
    }

    /// Hands on samples and events up to a time within the last step, in order; false if `go_on` asked to stop.
    fn tell(
        &mut self,
        motion: &mut Equations,
        stepper: &mut dyn Stepper<Equations>,
        until: f64,
        recorder: &mut dyn Recorder,
        go_on: &mut dyn FnMut(f64, &State) -> bool,
    ) -> Result<bool, RunError> {
        let happened = self.events.as_mut().map_or_else(Vec::new, |events| std::mem::take(&mut events.happened));
        for occurrence in happened {
            let time = occurrence.time;
            if !self.sampler.up_to(motion, &mut self.ledger, stepper, time, recorder, go_on)? {
                return Ok(false);
            }
            self.mark(occurrence, recorder)?;
        }
        // A sample at an instant has what controllers set there.
        let until = if self.is_due(until) { TIME.below(until) } else { until };
        self.sampler.up_to(motion, &mut self.ledger, stepper, until, recorder, go_on)
    }

    /// Hands on what happened at a transition.
    fn mark_all(&mut self, recorder: &mut dyn Recorder) -> Result<(), RunError> {
        let happened = self.events.as_mut().map_or_else(Vec::new, |events| std::mem::take(&mut events.happened));
        happened.into_iter().try_for_each(|occurrence| self.mark(occurrence, recorder))
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

    /// An explicit method that stability would hold below any useful step is refused.
    fn refuse_hopeless(&self, motion: &mut Equations, method: Method, time: f64) -> Result<(), RunError> {
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
}
