//! Steppers of a run: which step one begins with, and what it leaves to the run that goes on.

use super::{Run, fixed_step, resumed_grid};
use crate::integrate::{Method, Options, Start, Stepper};
use crate::simulate::contact::Capture;
use crate::simulate::error::{RunError, named};
use crate::simulate::problem::Equations;
use crate::simulate::resting::AtRest;
use crate::simulate::settings::{Grid, Resume, Settings};

impl Run<'_, '_> {
    /// The stepper of a method from the state at a time (s) to where steps have to end next.
    ///
    /// # Errors
    /// If the method cannot start there.
    pub(super) fn stepper(
        &mut self,
        motion: &mut Equations,
        settings: &Settings,
        method: Method,
        time: f64,
    ) -> Result<Box<dyn Stepper<Equations>>, RunError> {
        let end = self.segment_end(self.next(time));
        let carried = self.carried.take();
        let start = Start { time, position: &self.state.position, velocity: &self.state.velocity, end };
        if self.rests {
            let at_rest = AtRest::new(motion, start).map_err(|error| named(self.model, &error))?;
            return Ok(Box::new(at_rest));
        }
        if motion.is_captured() {
            motion.let_go(time, &self.state).map_err(|fault| RunError::Sample { time, fault })?;
            let (tolerance, part) = (settings.tolerance, self.captured);
            let capture = Capture::new(motion, start, (tolerance, part)).map_err(|error| named(self.model, &error))?;
            return Ok(Box::new(capture));
        }
        let given = fixed_step(self.model, settings, method);
        let fixed = given.map(|step| self.fine_step(motion, settings, time, step));
        let acted = self.control.as_ref().is_some_and(|control| control.acted(time));
        let begins = settings.resume.as_ref().filter(|resume| resume.time == time);
        let resumed = begins.filter(|resume| resume.method == method).and_then(|resume| resume.step);
        // After a stage at the very end of a run no step follows.
        let lasts = |length: &f64| *length > 0.0 || begins.is_none();
        let options = Options {
            relative: settings.tolerance,
            absolute: settings.absolute_tolerance,
            duration: Some(settings.duration).filter(lasts),
            step: fixed.or(carried).or(settings.step.filter(|_| begins.is_none())).or(resumed).or(settings.step),
            // Of controllers every instant begins a grid.
            grid: begins.and(fixed).filter(|_| !acted && fixed == given).and_then(|step| resumed_grid(settings, step)),
            rho_infinity: settings.rho_infinity,
            // A step that was asked for is kept.
            max_step: self.timetable.longest_step.filter(|_| fixed.is_none() && settings.step.is_none()),
            ..Options::default()
        };
        method.start(motion, &options, start).map_err(|error| named(self.model, &error))
    }

    /// What a run needs to go on from a time; the stepper began at `origin`.
    pub(super) fn resume(
        &self,
        settings: &Settings,
        method: Method,
        stepper: &mut dyn Stepper<Equations>,
        [origin, time]: [f64; 2],
    ) -> Resume {
        let fixed = fixed_step(self.model, settings, method);
        let grid = fixed.and_then(|step| {
            let acted = self.control.as_ref().is_some_and(|control| control.acted(origin));
            let begins = settings.resume.as_ref().filter(|resume| resume.time == origin && !acted);
            let (origin, before) = begins.and_then(|_| resumed_grid(settings, step)).unwrap_or((origin, 0));
            let grid = Grid { origin, steps: before + stepper.statistics().steps };
            (grid.origin + grid.steps as f64 * step == time).then_some(grid)
        });
        let step = fixed.or_else(|| stepper.next_step());
        Resume { time, method, step, grid, mode: None }
    }
}
