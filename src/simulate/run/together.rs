//! Runs of several models at once: each takes the steps that it would take alone, and their accelerations are computed side by side
//! in an [`Ensemble`].
//!
//! A model asks for one evaluation after the other ([`Staged`]); a round answers one of each. Nothing is shared but the round: steps
//! differ from model to model, and each has its own ledger, samples and end.

use super::{Prepared, Run, fixed_step};
use crate::dynamics::{Ensemble, Fault};
use crate::integrate::{Method, Options, Staged, Start, Stepper};
use crate::model::Model;
use crate::record::Recorder;
use crate::simulate::checks::pace::Pace;
use crate::simulate::error::{RunError, named};
use crate::simulate::events::dead_centre;
use crate::simulate::events::search::Search;
use crate::simulate::problem::Equations;
use crate::simulate::run::Summary;
use crate::simulate::settings::{Integrator, Resume, Settings};
use crate::simulate::state::State;
use crate::spatial::lanes::WIDTH;
use std::sync::Arc;
use std::time::Instant;

/// Whether runs of this model with these settings can be computed together: an explicit Runge–Kutta method that the user has
/// chosen, systems that an ensemble covers, and nothing that ends steps or changes what acts: no stops, events, controllers, ropes or
/// tables with kinks, motions or motors that begin another rule on the way.
pub fn covers(model: &Model, settings: &Settings) -> bool {
    let staged = matches!(settings.integrator, Integrator::Method(method) if method.is_staged());
    let watched = !model.events.is_empty() || !model.controllers.is_empty() || model.switching().next().is_some();
    let run = [settings.begin(), settings.begin() + settings.duration];
    let breaks = model.motors.iter().any(|motor| !motor.breaks(run).is_empty());
    staged && settings.resume.is_none() && Ensemble::covers(model) && !watched && !breaks && !model.has_boundaries()
}

/// One model on its way.
struct Lane<'m> {
    model: &'m Arc<Model>,
    motion: Equations,
    run: Run<'m, 'static>,
    stepper: Box<dyn Staged<Equations>>,
    pace: Pace,
    energy_start: f64,
    begun: Instant,
}

/// Runs models that [`covers`] accepts and that differ in numbers alone, each from its own start and to its own recorder; otherwise as
/// [`super::super::run`] with each of them. `None` if their structures differ, or the law of a motor breaks in one of them.
pub fn run_together(
    models: &[Arc<Model>; WIDTH],
    settings: &Settings,
    rate: f64,
    starts: &[State; WIDTH],
    recorders: &mut [&mut dyn Recorder; WIDTH],
    go_on: &mut dyn FnMut(f64, &State) -> bool,
) -> Option<[Result<Summary, RunError>; WIDTH]> {
    let Integrator::Method(method) = settings.integrator else { return None };
    let mut ensemble = Ensemble::new(models)?;
    let mut done: [Option<Result<Summary, RunError>>; WIDTH] = std::array::from_fn(|_| None);
    let mut lanes: [Option<Lane<'_>>; WIDTH] = std::array::from_fn(|lane| {
        let begun = Lane::begin(&models[lane], method, settings, rate, &starts[lane], recorders[lane]);
        begun.map_err(|error| done[lane] = Some(Err(error))).ok()
    });
    if lanes.iter().flatten().any(|lane| !lane.run.timetable.is_empty()) {
        return None;
    }
    let zeros = |count: usize| vec![[0.0; WIDTH]; count];
    let (mut q, mut v) = (zeros(models[0].position_count()), zeros(models[0].velocity_count()));
    let (mut a, mut time) = (v.clone(), [settings.begin(); WIDTH]);
    loop {
        for lane in 0..WIDTH {
            let Some(own) = &mut lanes[lane] else { continue };
            match own.ask() {
                Ok(at) => time[lane] = at,
                Err(error) => {
                    done[lane] = Some(Err(error));
                    lanes[lane] = None;
                    continue;
                }
            }
            let (at, rates) = own.stepper.asked().split_at(q.len());
            q.iter_mut().zip(at).for_each(|(to, x)| to[lane] = *x);
            v.iter_mut().zip(rates).for_each(|(to, x)| to[lane] = *x);
        }
        let asked = lanes.each_ref().map(Option::is_some);
        if asked == [false; WIDTH] {
            break;
        }
        let mut faults = ensemble.accelerations(&asked, &time, (&q, &v), &mut a).err();
        for lane in 0..WIDTH {
            let fault = faults.as_mut().and_then(|faults| faults[lane].take());
            let own = |out: &mut [f64]| out.iter_mut().zip(&a).for_each(|(out, a)| *out = a[lane]);
            let went = match &mut lanes[lane] {
                Some(one) => one.answer(fault, &own, settings, recorders[lane], go_on),
                None => continue,
            };
            if let Some(went) = went.map(|ends| ends.then_some(())).transpose() {
                let ended = lanes[lane].take();
                done[lane] = ended.map(|one| went.and_then(|()| one.end(method, settings)));
            }
        }
    }
    let all: Option<Vec<_>> = done.into_iter().collect();
    all?.try_into().ok()
}

impl<'m> Lane<'m> {
    fn begin(
        model: &'m Arc<Model>,
        method: Method,
        settings: &Settings,
        rate: f64,
        start: &State,
        recorder: &mut dyn Recorder,
    ) -> Result<Self, RunError> {
        let (prepared, mut motion) = Prepared::new(model, settings, start, false)?;
        let (mut run, energy_start) =
            Run::begin(model, &mut motion, settings, rate, (prepared, Search::RUN, None, None), recorder)?;
        let begin = settings.begin();
        run.refuse_hopeless(&mut motion, method, begin)?;
        run.integrators.push(method);
        let options = Options {
            relative: settings.tolerance,
            absolute: settings.absolute_tolerance,
            duration: Some(settings.duration),
            step: fixed_step(model, settings, method).or(settings.step),
            rho_infinity: settings.rho_infinity,
            max_step: run.timetable.longest_step.filter(|_| !method.needs_step() && settings.step.is_none()),
            ..Options::default()
        };
        let State { position, velocity } = &run.state;
        let start = Start { time: begin, position, velocity, end: run.end };
        let stepper = method.start_staged(&mut motion, &options, start);
        let stepper = match stepper {
            Some(stepper) => stepper.map_err(|error| named(model, &error))?,
            None => return Err(RunError::Step(format!("{} is not stepped evaluation by evaluation", method.name()))),
        };
        Ok(Self { model, motion, run, stepper, pace: Pace::new(begin), energy_start, begun: Instant::now() })
    }

    /// The time of the next evaluation (s).
    fn ask(&mut self) -> Result<f64, RunError> {
        let asked = self.stepper.ask(&mut self.motion);
        let time = self.stepper.time();
        asked.map_err(|error| dead_centre::beside(named(self.model, &error), self.model, time, &self.run.state))
    }

    /// Takes an evaluation, and does what follows a step; whether the run has ended.
    fn answer(
        &mut self,
        fault: Option<Fault>,
        accelerations: &dyn Fn(&mut [f64]),
        settings: &Settings,
        recorder: &mut dyn Recorder,
        go_on: &mut dyn FnMut(f64, &State) -> bool,
    ) -> Result<bool, RunError> {
        let Self { model, motion, run, stepper, pace, .. } = self;
        let mut fault = fault;
        let accepted = stepper.answer(motion, &mut |a| match fault.take() {
            Some(fault) => Err(fault.into()),
            None => {
                accelerations(a);
                Ok(())
            }
        });
        let time = stepper.time();
        let beside = |error| dead_centre::beside(named(model, &error), model, time, &run.state);
        if !accepted.map_err(beside)? {
            return Ok(false);
        }
        run.state.position.copy_from_slice(stepper.position());
        run.state.velocity.copy_from_slice(stepper.velocity());
        let stepper: &mut dyn Stepper<Equations> = stepper.as_mut();
        let mut stopped = !run.tell(motion, stepper, time, recorder, go_on)?;
        recorder.pause()?;
        run.close_step(motion, stepper, time)?;
        let fixed = fixed_step(model, settings, run.integrators[0]).is_some();
        if let Some(creep) = pace.see(time, run.end).filter(|_| !fixed) {
            return Err(run.creeps(stepper, creep));
        }
        stopped |= !go_on(time, &run.state);
        Ok(stopped || stepper.finished())
    }

    fn end(self, method: Method, settings: &Settings) -> Result<Summary, RunError> {
        let Self { model, mut motion, mut run, stepper, energy_start, begun, .. } = self;
        run.statistics.add(stepper.statistics());
        // The round is shared: of its time each has a part.
        run.wall = begun.elapsed() / WIDTH as u32;
        let resume = Resume { time: stepper.time(), method, step: None, grid: None, mode: None };
        run.end(&mut motion, settings, resume, energy_start, model)
    }
}
