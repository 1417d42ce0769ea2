//! An instant of contact: blows, what touches afterwards, and whether it sticks, slips or lifts.

use super::cone::State as Did;
use super::frame::{Frame, problem, responses};
use super::impact::{FOUND, MOST_SWEEPS};
use super::{Closed, Contacts, GAP, Mode, STRAIGHT, Trouble};
use crate::dynamics::{Fault, System};
use crate::simulate::events::Kind;
use crate::simulate::state::State;
use nalgebra::Vector3;

/// Blows that cause blows at one instant.
const MOST_ROUNDS: usize = 60;
/// Friction is smaller by this part when a force has reached its limit, so that what is there slips; else larger by half of it.
const LESS: f64 = 1e-7;
/// What slips accelerates by more than this part of the largest acceleration.
const SLIPS: f64 = 1e-9;
/// Accelerations below this part of the largest are round-off.
const ROUND_OFF: f64 = 1e-9;
/// The whole scene rests if nothing accelerates by more than this part of the scene's own acceleration: what forces within cones balance.
const STILL: f64 = 1e-8;

/// What happened at an instant of contact, to be told.
#[derive(Debug, Clone)]
pub(in crate::simulate) struct Told {
    pub(in crate::simulate) kind: Kind,
    /// Names of the bodies.
    pub(in crate::simulate) between: [String; 2],
    /// Index of the rule.
    pub(in crate::simulate) rule: usize,
    /// (m/s)
    pub(in crate::simulate) speed: f64,
}

/// What an instant changed.
#[derive(Debug, Default)]
pub(in crate::simulate) struct Changed {
    pub(in crate::simulate) told: Vec<Told>,
    /// (J)
    pub(in crate::simulate) lost: f64,
}

impl Contacts {
    /// Resolves an instant: the state after it, and what is closed from there on. `at_limit` if a force has left its cone.
    ///
    /// # Errors
    /// What cannot be decided, by name.
    pub(in crate::simulate) fn resolve(
        &mut self,
        system: &mut System,
        time: f64,
        state: &mut State,
        at_limit: bool,
    ) -> Result<Changed, Trouble> {
        let before = self.told();
        self.resting = false;
        let mut changed = Changed::default();
        let mut struck: Vec<usize> = Vec::new();
        for round in 0.. {
            self.lift(system, time, state)?;
            let frames = self.meet(system, time, state)?;
            if !frames.iter().any(|frame| self.approaches(frame)) {
                break;
            }
            if round == MOST_ROUNDS {
                let worst = frames.iter().find(|frame| self.approaches(frame)).map_or(0, |frame| frame.key.couple);
                let why = format!("{MOST_ROUNDS} rounds of blows at one instant leave them approaching");
                return Err(Trouble::Contact { between: self.between(worst), why });
            }
            let blows = self.blows(system, state, &frames)?;
            changed.lost += blows.lost;
            for blow in blows.all {
                struck.push(blow.couple);
                changed.told.push(self.say(Kind::Strikes, blow.couple, blow.speed));
            }
        }
        let frames = self.meet(system, time, state)?;
        let near = |frame: &Frame| frame.speed.x < self.rest;
        let frames: Vec<Frame> = frames.into_iter().filter(near).collect();
        self.closing = GAP;
        self.close(&frames);
        self.hold(system, time, state)?;
        self.decide(system, time, state, if at_limit { LESS } else { -0.5 * LESS })?;
        self.tell(&before, &struck, &mut changed);
        Ok(changed)
    }

    fn say(&self, kind: Kind, couple: usize, speed: f64) -> Told {
        Told { kind, between: self.between(couple), rule: self.pairs.couples[couple].rule, speed }
    }

    /// All that touches, the system being factorized there.
    fn meet(&mut self, system: &mut System, time: f64, state: &State) -> Result<Vec<Frame>, Fault> {
        system.pressed().fill(crate::spatial::Wrench::ZERO);
        let mut a = vec![0.0; state.velocity.len()];
        system.at(time, &state.position, &state.velocity).accelerations(&mut a)?;
        Ok(self.touching(system, time, state))
    }

    /// Brings what touches to gaps of zero.
    fn lift(&mut self, system: &mut System, time: f64, state: &mut State) -> Result<(), Fault> {
        let length = self.model.length_scale();
        for _ in 0..6 {
            let frames = self.meet(system, time, state)?;
            let gaps: Vec<f64> = frames.iter().map(|frame| frame.meeting.gap).collect();
            // What parts may stay open.
            let off = |(gap, frame): (&f64, &Frame)| if frame.speed.x > self.rest { gap.min(0.0) } else { *gap };
            let off: Vec<f64> = gaps.iter().zip(&frames).map(off).collect();
            if !off.iter().any(|gap| gap.abs() > 1e-15 * length) {
                break;
            }
            self.frames = frames;
            let by = self.lifted(system, &state.position, &state.velocity, &off);
            System::displace(&self.model, &mut state.position, &by);
        }
        Ok(())
    }

    /// Contacts of these frames are closed from now on: those that slip do, others stick until it is decided.
    fn close(&mut self, frames: &[Frame]) {
        let closed = frames.iter().map(|frame| {
            let slip = frame.slip();
            let friction = self.law(frame.key.couple).friction;
            let mode = match slip.norm() > self.slow {
                _ if friction.stick == 0.0 => Mode::Slip(Vector3::zeros()),
                true => Mode::Slip(slip.normalize()),
                false => Mode::Stick,
            };
            let meeting = frame.meeting;
            let force = Vector3::zeros();
            Closed { key: frame.key, mode, gap: meeting.gap, meeting, force, slip, straight: false, across: 0.0 }
        });
        self.closed = closed.collect();
    }

    /// Takes from velocities what closed contacts do not allow, all of it below the speed of rest.
    fn hold(&mut self, system: &mut System, time: f64, state: &mut State) -> Result<(), Fault> {
        self.project(system, time, &mut state.position, &mut state.velocity).map(drop)
    }

    /// The modes of closed contacts, by one cone problem on accelerations.
    fn decide(&mut self, system: &mut System, time: f64, state: &mut State, less: f64) -> Result<(), Trouble> {
        if self.closed.is_empty() {
            return Ok(());
        }
        let n = state.velocity.len();
        let mut a = vec![0.0; n];
        self.refresh(system, time, &state.position, &state.velocity, &mut a)?;
        let frames = self.frames.clone();
        let answers = responses(system, &state.position, &state.velocity, &frames);
        let rates: Vec<Vector3<f64>> = frames.iter().map(|frame| frame.rates(&a) + frame.bias).collect();
        let size = rates.iter().map(|rate| rate.amax()).fold(0.0, f64::max);
        let problem = problem(&frames, &answers, rates, self.laws(&frames, less));
        let found = problem.solve(&vec![Vector3::zeros(); frames.len()], FOUND, MOST_SWEEPS);
        if found.change > 1e-8 || found.forces.iter().any(|f| !f.iter().all(|x| x.is_finite())) {
            let worst = found.forces.iter().position(|f| !f.iter().all(|x| x.is_finite()));
            let between = self.between(frames[worst.unwrap_or(0)].key.couple);
            let why = match worst {
                Some(_) => {
                    "pressing harder does not lift what slides there (Painlevé's paradox): rigid bodies with this \
                            friction have no acceleration"
                        .to_owned()
                }
                None => format!("the forces of {} contacts are not found in {} sweeps", frames.len(), found.sweeps),
            };
            return Err(Trouble::Contact { between, why });
        }
        let mut kept = Vec::new();
        for (k, mut closed) in std::mem::take(&mut self.closed).into_iter().enumerate() {
            let (force, rate) = (found.forces[k], found.rates[k]);
            let frictionless = self.law(closed.key.couple).friction.stick == 0.0;
            closed.mode = match (found.states[k], closed.mode) {
                (Did::Open, _) if rate.x > ROUND_OFF * size => continue,
                (Did::Open, _) => Mode::Spare,
                (Did::Stick, _) => Mode::Stick,
                (Did::Slip, _) if frictionless => Mode::Slip(Vector3::zeros()),
                (Did::Slip, Mode::Slip(direction)) => Mode::Slip(direction),
                (Did::Slip, _) if rate.yz().norm() <= SLIPS * size => Mode::Stick,
                (Did::Slip, _) => {
                    let against = -(frames[k].basis.column(1) * force.y + frames[k].basis.column(2) * force.z);
                    let along = frames[k].basis.column(1) * rate.y + frames[k].basis.column(2) * rate.z;
                    let direction = against.try_normalize(0.0).or_else(|| along.try_normalize(0.0));
                    Mode::Slip(direction.unwrap_or_else(|| frames[k].basis.column(1).into_owned()))
                }
            };
            closed.force = frames[k].basis * force;
            closed.straight = matches!(closed.mode, Mode::Slip(direction) if direction != Vector3::zeros());
            kept.push(closed);
        }
        self.closed = kept;
        self.refresh(system, time, &state.position, &state.velocity, &mut a)?;
        self.correct(system, &state.position, &state.velocity, &mut a)?;
        if self.bent() > 1e-3 * STRAIGHT {
            self.closed.iter_mut().for_each(|closed| closed.straight = false);
        }
        let largest = found.forces.iter().map(|f| f.amax()).fold(0.0, f64::max);
        self.scale = if largest > 0.0 { largest } else { self.scale };
        Ok(())
    }

    /// What has changed for couples, beside blows.
    fn tell(&self, before: &[(usize, bool)], struck: &[usize], changed: &mut Changed) {
        let after = self.told();
        for (couple, _) in before.iter().filter(|(couple, _)| !after.iter().any(|(other, _)| other == couple)) {
            if !struck.contains(couple) {
                changed.told.push(self.say(Kind::Lifts, *couple, 0.0));
            }
        }
        for (couple, slips) in &after {
            let was = before.iter().find(|(other, _)| other == couple).map(|(_, slips)| *slips);
            let of = self.closed.iter().zip(&self.frames).find(|(closed, _)| closed.key.couple == *couple);
            let rolls = of.is_some_and(|(_, frame)| frame.spin.norm() > self.slow / self.model.length_scale());
            let frictionless = self.law(*couple).friction.stick == 0.0;
            let kind = match (was, slips) {
                (Some(false), true) => Kind::Slip,
                (Some(true), false) if !frictionless => {
                    if rolls {
                        Kind::Rolls
                    } else {
                        Kind::Stick
                    }
                }
                _ => continue,
            };
            changed.told.push(self.say(kind, *couple, 0.0));
        }
    }

    /// Whether nothing moves and nothing accelerates: the whole scene rests from now on if nothing changes with time. Its
    /// velocities are zero then.
    pub(in crate::simulate) fn comes_to_rest(&mut self, state: &mut State, a: &[f64]) -> bool {
        let (length, span) = (self.model.length_scale(), self.model.time_scale());
        let rests = self.model.links.iter().skip(1).all(|link| {
            let unit = if link.joint.is_slide() { length } else { 1.0 };
            (link.velocity..link.velocity + link.joint.counts().1).all(|i| {
                state.velocity[i].abs() <= self.slow * unit / length && a[i].abs() <= STILL * unit / (span * span)
            })
        });
        if rests && !self.closed.is_empty() {
            state.velocity.fill(0.0);
            self.resting = true;
        }
        self.resting
    }
}
