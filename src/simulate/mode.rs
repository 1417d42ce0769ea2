//! The discrete state of a run: which stops and dry friction hold or push, and what contacts do. With the state and the time it is all that a run
//! follows from: one that goes on from where another ended has it from there, and decides nothing anew that has been decided.
//!
//! | | |
//! |---|---|
//! | `held` | what rests on rigid stops and by dry friction: `stops::nonsmooth` |
//! | `pushing`, `rubbing` | compliant stops that push, and what dry friction does: [`Phase`](crate::dynamics::applied::Phase) |
//! | `contacts` | closed contacts, sticking or slipping, or the forces of the last captured step: `simulate::contact` |
//!
//! On which side of its boundaries a spring, a rope or a formula is follows from the state.
//!
//! As a list of numbers it goes into files: [`Mode::numbers`], read by [`Mode::of_numbers`].

use crate::dynamics::applied::Rubbing;
use crate::model::{Model, Side, StopSide};
use crate::simulate::contact::ContactMode;
use crate::simulate::error::RunError;
use crate::simulate::problem::Equations;
use crate::simulate::state::State;
use crate::simulate::stops::nonsmooth::Holding;
use nalgebra::Vector3;

/// The first of the numbers: how the others are to be read.
const LAYOUT: f64 = 1.0;

/// The discrete state of a run.
#[derive(Debug, Clone, PartialEq)]
pub struct Mode {
    held: Vec<Held>,
    pushing: Vec<StopSide>,
    rubbing: Vec<Rubbing>,
    contacts: Option<ContactMode>,
}

/// What is at rest, and by what: the range of its force follows from that.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Held {
    velocity: usize,
    count: usize,
    stop: Option<StopSide>,
    friction: Option<usize>,
}

impl Held {
    fn holding(self) -> Holding {
        let Self { velocity, count, stop, friction } = self;
        let range = [f64::NEG_INFINITY, f64::INFINITY];
        Holding { velocity, count, stop, friction, range, slack: 0.0 }
    }
}

impl Mode {
    /// Whether forces are those of captured steps: nothing is decided then where a run goes on.
    pub(super) fn follows_steps(&self) -> bool {
        self.contacts.as_ref().is_some_and(ContactMode::follows_steps)
    }

    /// Whether contacts were followed.
    pub(super) fn has_contacts(&self) -> bool {
        self.contacts.is_some()
    }

    /// Asks again whether what rests does so, as what acts may have changed.
    #[must_use]
    pub fn awake(mut self) -> Self {
        self.contacts.iter_mut().for_each(ContactMode::wake);
        self
    }

    /// As finite numbers.
    pub fn numbers(&self) -> Vec<f64> {
        let mut out = vec![LAYOUT, self.held.len() as f64];
        let side = |side: &StopSide| [side.stop as f64, f64::from(u8::from(side.at == Side::High))];
        for held in &self.held {
            out.extend([held.velocity as f64, held.count as f64, f64::from(u8::from(held.stop.is_some()))]);
            held.stop.iter().for_each(|stop| out.extend(side(stop)));
            out.push(held.friction.map_or(-1.0, |index| index as f64));
        }
        out.push(self.pushing.len() as f64);
        self.pushing.iter().for_each(|one| out.extend(side(one)));
        out.push(self.rubbing.len() as f64);
        for rubbing in &self.rubbing {
            match rubbing {
                Rubbing::Sticks => out.push(0.0),
                Rubbing::Slides(direction) => {
                    out.push(1.0);
                    out.extend(direction.iter());
                }
                Rubbing::Dependent(force) => out.extend([2.0, *force]),
            }
        }
        out.push(f64::from(u8::from(self.contacts.is_some())));
        self.contacts.iter().for_each(|contacts| contacts.write(&mut out));
        out
    }

    /// From such numbers; `None` if they are no mode. Whether contacts rest is asked again: the scene may be another one by now.
    pub fn of_numbers(numbers: &[f64]) -> Option<Self> {
        let mut numbers = Numbers(numbers);
        if numbers.next()? != LAYOUT {
            return None;
        }
        let held = numbers.list(|numbers| {
            let (velocity, count) = (numbers.count()?, numbers.count()?);
            let stop = if numbers.flag()? { Some(numbers.side()?) } else { None };
            let friction = match numbers.next()? {
                -1.0 => None,
                index => Some(count_of(index)?),
            };
            Some(Held { velocity, count, stop, friction })
        })?;
        let pushing = numbers.list(Numbers::side)?;
        let rubbing = numbers.list(|numbers| {
            Some(match numbers.count()? {
                0 => Rubbing::Sticks,
                1 => Rubbing::Slides(numbers.vector()?),
                2 => Rubbing::Dependent(numbers.next()?),
                _ => return None,
            })
        })?;
        let contacts = if numbers.flag()? { Some(ContactMode::read(&mut numbers)?) } else { None };
        numbers.0.is_empty().then(|| Self { held, pushing, rubbing, contacts }.awake())
    }

    /// Whether it may be of a scene with these stops, this dry friction and contact.
    pub fn fits(&self, model: &Model) -> bool {
        let known = |side: &StopSide| side.stop < model.stops.len();
        let holds = |held: &Held| {
            held.velocity + held.count <= model.velocity_count()
                && held.stop.iter().all(known)
                && held.friction.is_none_or(|index| index < model.hinge_friction.len())
        };
        self.held.iter().all(holds)
            && self.pushing.iter().all(known)
            && self.rubbing.len() == model.hinge_friction.len()
            && (self.contacts.is_none() || !model.contacts.is_empty())
    }
}

impl Equations {
    /// What stops, dry friction and contacts do; `None` for a model that has none of them, and one that contact holds at rest.
    pub(super) fn mode(&self) -> Option<Mode> {
        let contacts = self.contacts.as_ref().map(|contacts| contacts.mode());
        if self.nonsmooth.is_none() && contacts.is_none() {
            return None;
        }
        let phase = self.system.phase();
        let keep = |held: &Holding| {
            let Holding { velocity, count, stop, friction, .. } = *held;
            Held { velocity, count, stop, friction }
        };
        Some(Mode {
            held: self.held().iter().map(keep).collect(),
            pushing: phase.pushing.clone(),
            rubbing: phase.rubbing.clone(),
            contacts,
        })
    }

    /// Goes on with what stops, dry friction and contacts did at this time and state.
    ///
    /// # Errors
    /// [`RunError::Mode`] if that is of another scene, [`RunError::Sample`] where the state cannot be evaluated.
    pub(super) fn set_mode(&mut self, time: f64, state: &State, mode: &Mode) -> Result<(), RunError> {
        if !mode.fits(self.model()) {
            return Err(RunError::Mode { time });
        }
        let phase = self.system.phase_mut();
        phase.pushing.clone_from(&mode.pushing);
        phase.rubbing.clone_from(&mode.rubbing);
        let held: Vec<Holding> = mode.held.iter().map(|held| held.holding()).collect();
        self.hold(time, state, &held).map_err(|fault| RunError::Sample { time, fault })?;
        let (Some(contacts), Some(mode)) = (&mut self.contacts, &mode.contacts) else { return Ok(()) };
        self.system.at(time, &state.position, &state.velocity);
        if contacts.set_mode(&self.system, mode) { Ok(()) } else { Err(RunError::Mode { time }) }
    }
}

/// Numbers that are read one after the other.
pub(in crate::simulate) struct Numbers<'a>(&'a [f64]);

impl Numbers<'_> {
    /// The next one, unless there is none or it is no number.
    pub(in crate::simulate) fn next(&mut self) -> Option<f64> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first).filter(|x| !x.is_nan())
    }

    /// One that counts, or names by its place.
    pub(in crate::simulate) fn count(&mut self) -> Option<usize> {
        count_of(self.next()?)
    }

    pub(in crate::simulate) fn flag(&mut self) -> Option<bool> {
        Some(self.count()? == 1)
    }

    pub(in crate::simulate) fn vector(&mut self) -> Option<Vector3<f64>> {
        Some(Vector3::new(self.next()?, self.next()?, self.next()?))
    }

    pub(in crate::simulate) fn side(&mut self) -> Option<StopSide> {
        Some(StopSide { stop: self.count()?, at: if self.flag()? { Side::High } else { Side::Low } })
    }

    /// As many of them as the next one says.
    pub(in crate::simulate) fn list<T>(&mut self, mut each: impl FnMut(&mut Self) -> Option<T>) -> Option<Vec<T>> {
        let count = self.count()?;
        // Each has a number at least.
        if count > self.0.len() {
            return None;
        }
        (0..count).map(|_| each(self)).collect()
    }
}

/// A whole number below 2³².
fn count_of(x: f64) -> Option<usize> {
    ((0.0..4_294_967_296.0).contains(&x) && x.fract() == 0.0).then_some(x as usize)
}
