//! The scene as several cases that are computed side by side.

use crate::dynamics::ensemble::WIDTH;
use crate::dynamics::{Ensemble, Fault};
use crate::integrate::{Method, Options, Staged, Start};
use crate::model::Model;
use crate::simulate::problem::Equations;
use std::sync::Arc;

/// A step that disturbs nothing: this part of the scene's own time.
const STEP: f64 = 1e-4;

/// The scene in every lane of an ensemble.
pub(super) struct Beside {
    ensemble: Ensemble,
    /// The start.
    q: Vec<[f64; WIDTH]>,
    v: Vec<[f64; WIDTH]>,
    a: Vec<[f64; WIDTH]>,
    /// What is stepped: systems, steppers, and their states.
    motions: [Equations; WIDTH],
    steppers: [Box<dyn Staged<Equations>>; WIDTH],
    time: [f64; WIDTH],
    at: [Vec<[f64; WIDTH]>; 2],
}

impl Beside {
    /// `None` for scenes that are not computed side by side.
    pub(super) fn new(model: &Arc<Model>) -> Option<Box<Self>> {
        let ensemble = Ensemble::new(&std::array::from_fn(|_| Arc::clone(model)))?;
        let lanes = |numbers: &[f64]| numbers.iter().map(|x| [*x; WIDTH]).collect::<Vec<_>>();
        let (q, v) = (lanes(&model.start_position), lanes(&model.start_velocity));
        let mut motions: [Equations; WIDTH] = std::array::from_fn(|_| Equations::new(model));
        let start = Start {
            time: 0.0,
            position: &model.start_position,
            velocity: &model.start_velocity,
            end: 1e9 * model.time_scale(),
        };
        let options = Options { step: Some(STEP * model.time_scale()), ..Options::default() };
        let steppers = motions.iter_mut().map(|motion| Method::Rk4.start_staged(motion, &options, start)?.ok());
        let steppers: Vec<_> = steppers.collect::<Option<_>>()?;
        let (a, at, time) = (v.clone(), [q.clone(), v.clone()], [0.0; WIDTH]);
        Some(Box::new(Self { ensemble, q, v, a, motions, steppers: steppers.try_into().ok()?, time, at }))
    }

    /// Accelerations of all cases at the start.
    pub(super) fn accelerations(&mut self) -> Result<(), Fault> {
        let Self { ensemble, q, v, a, time, .. } = self;
        match ensemble.accelerations(&[true; WIDTH], time, (q, v), a) {
            Ok(()) => Ok(()),
            Err(faults) => (*faults).into_iter().flatten().next().map_or(Ok(()), Err),
        }
    }

    /// The next step of every case, of four evaluations; whether there is one.
    pub(super) fn step(&mut self) -> bool {
        let Self { ensemble, a, motions, steppers, time, at: [q, v], .. } = self;
        loop {
            for (lane, (stepper, motion)) in steppers.iter_mut().zip(&mut *motions).enumerate() {
                let Ok(asked) = stepper.ask(motion) else { return false };
                time[lane] = asked;
                let (at, rates) = stepper.asked().split_at(q.len());
                q.iter_mut().zip(at).for_each(|(to, x)| to[lane] = *x);
                v.iter_mut().zip(rates).for_each(|(to, x)| to[lane] = *x);
            }
            if ensemble.accelerations(&[true; WIDTH], time, (q, v), a).is_err() {
                return false;
            }
            let mut accepted = false;
            for (lane, (stepper, motion)) in steppers.iter_mut().zip(&mut *motions).enumerate() {
                let answered = stepper.answer(motion, &mut |out| {
                    out.iter_mut().zip(&*a).for_each(|(out, a)| *out = a[lane]);
                    Ok(())
                });
                match answered {
                    Ok(one) => accepted |= one,
                    Err(_) => return false,
                }
            }
            if accepted {
                return true;
            }
        }
    }
}
