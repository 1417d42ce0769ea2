//! An instant of contact: impacts, what touches afterwards, and whether it sticks, slips or lifts.

use super::impact::FOUND;
use super::slip;
use super::watch::BEYOND;
use super::{Closed, ContactState, Contacts, GAP, Regime, STRAIGHT, Trouble};
use crate::contact::cone::{Answer, ConeState, Law, Problem};
use crate::contact::frame::{Frame, problem, responses};
use crate::contact::geometry::feature::Meeting;
use crate::contact::pairs::Key;
use crate::dynamics::{Factorized, Fault, System};
use crate::simulate::events::Kind;
use crate::simulate::state::State;
use nalgebra::Vector3;

/// Impacts that cause impacts at one instant.
const MOST_ROUNDS: usize = 60;
/// Friction is smaller by this part when a force has reached its limit, so that what is there slips; else larger by half of it.
const LESS: f64 = 1e-7;
/// What slips accelerates by more than this part of the largest acceleration.
pub(super) const SLIPS: f64 = 1e-9;
/// A slip that begins is against its friction to this part of its acceleration.
const AGAINST: f64 = 1e-4;
/// What is open sinks by no more than this part of the largest acceleration.
pub(super) const SINKS: f64 = 1e-7;
/// Turns of the directions of slips that begin.
const MOST_TURNS: usize = 20;
/// Sweeps of the cone problem until the states of its contacts are tried, more of them each time: they may be right long before its forces are.
const SWEEPS: [usize; 3] = [200, 5_000, 50_000];
/// Forces that change by less than this part in a sweep tell what slips.
const SETTLED: f64 = 1e-6;
/// The whole scene rests if nothing accelerates by more than this part of the scene's own acceleration: what forces within cones balance.
const STILL: f64 = 1e-8;

/// What slips accelerates by more than this part of the largest acceleration in an answer: what has not been found yet does so clearly.
fn slips(found: &Answer) -> f64 {
    if found.change <= FOUND { SLIPS } else { SLIPS.max(1e-4) }
}

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
    /// Whether there was an impact.
    pub(in crate::simulate) struck: bool,
    /// By impacts (J).
    pub(in crate::simulate) lost: f64,
    /// What springs of contacts held that bear no more, less what those hold that bear again (J). Those that come or go while they are deep
    /// hold what nothing has put in or taken out: that is unaccounted for.
    pub(in crate::simulate) released: f64,
}

/// What states of contacts give.
pub(super) struct Fits {
    /// Whether nothing sinks that is open.
    pub(super) rises: bool,
    /// Whether slips that begin are against friction.
    pub(super) brakes: bool,
    /// How contacts accelerate, each in its basis (m/s²).
    pub(super) rates: Vec<Vector3<f64>>,
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
        self.regime = Regime::Events;
        let mut changed = Changed::default();
        let mut struck: Vec<usize> = Vec::new();
        for round in 0.. {
            self.lift(system, time, state)?;
            let (frames, mut mass) = self.meet(system, time, state)?;
            let frames: Vec<Frame> = frames.into_iter().filter(|frame| self.is_rigid(frame.key.couple)).collect();
            if !frames.iter().any(|frame| self.approaches(frame)) {
                break;
            }
            if round == MOST_ROUNDS {
                let worst = frames.iter().find(|frame| self.approaches(frame)).map_or(0, |frame| frame.key.couple);
                let why = format!("{MOST_ROUNDS} rounds of impacts at one instant leave them approaching");
                return Err(Trouble::Undecided { between: self.between(worst), why });
            }
            let answers = responses(&mut mass, &frames);
            let impacts = self.strike(&frames, &answers, &mut state.velocity)?;
            changed.lost += impacts.lost;
            changed.struck = true;
            for impact in impacts.all {
                struck.push(impact.couple);
                changed.told.push(self.say(Kind::Strikes, impact.couple, impact.speed));
            }
        }
        let (frames, _) = self.meet(system, time, state)?;
        if 3 * frames.len() > super::MOST_ROWS {
            let why = format!("{} contacts are too many", frames.len());
            return Err(Trouble::Undecided { between: self.between(frames[0].key.couple), why });
        }
        let near = |frame: &Frame| match self.is_rigid(frame.key.couple) {
            true => frame.speed.x < self.rest,
            false => self.bears(frame, time) || self.is_deep(frame),
        };
        let frames: Vec<Frame> = frames.into_iter().filter(near).collect();
        self.closing = GAP;
        let bore = self.bearing();
        let pushed: Vec<(Key, bool)> = self.closed.iter().map(|was| (was.key, was.pushes)).collect();
        self.close(&frames, struck.is_empty(), time);
        changed.released += self.released(&pushed, system);
        let kinetic = |system: &mut System, state: &State| {
            system.at_without_contact(time, &state.position, &state.velocity).energies().kinetic
        };
        let moving = kinetic(system, state);
        self.hold(system, time, state)?;
        changed.lost += moving - kinetic(system, state);
        self.decide(system, time, state, if at_limit { LESS } else { -0.5 * LESS })?;
        self.tell(&before, &bore, &struck, &mut changed);
        Ok(changed)
    }

    /// Whether anything that touches, or strikes, hangs together with dry friction of hinges or with what is `stopped` (velocity coordinates).
    ///
    /// # Errors
    /// A state that cannot be evaluated.
    pub(in crate::simulate) fn is_tied_up(
        &mut self,
        system: &mut System,
        time: f64,
        state: &State,
        stopped: &[usize],
    ) -> Result<bool, Fault> {
        if self.model.hinge_friction.is_empty() && stopped.is_empty() {
            return Ok(false);
        }
        let (frames, _) = self.meet(system, time, state)?;
        let mut touching = frames.iter().filter(|frame| frame.speed.x < self.rest);
        Ok(touching.any(|frame| self.is_tied(frame.key.couple, stopped)))
    }

    fn say(&self, kind: Kind, couple: usize, speed: f64) -> Told {
        Told { kind, between: self.between(couple), rule: self.pairs.couples[couple].rule, speed }
    }

    /// All that touches, and the mass matrix there.
    fn meet<'a>(
        &mut self,
        system: &'a mut System,
        time: f64,
        state: &'a State,
    ) -> Result<(Vec<Frame>, Factorized<'a>), Fault> {
        let mut a = vec![0.0; state.velocity.len()];
        let at = system.at_without_contact(time, &state.position, &state.velocity);
        let mass = at.into_accelerations(&mut a)?;
        let mut frames = self.touching(mass.motion());
        self.leave_out(&mut frames);
        Ok((frames, mass))
    }

    /// Brings what touches to gaps of zero.
    fn lift(&mut self, system: &mut System, time: f64, state: &mut State) -> Result<(), Fault> {
        let length = self.model.length_scale();
        for _ in 0..6 {
            let (frames, mut mass) = self.meet(system, time, state)?;
            let gaps: Vec<f64> = frames.iter().map(|frame| frame.meeting.gap).collect();
            // What parts may stay open; what is compliant is where it is.
            let off = |(gap, frame): (&f64, &Frame)| match self.is_rigid(frame.key.couple) {
                true if frame.speed.x > self.rest => gap.min(0.0),
                true => *gap,
                false => 0.0,
            };
            let off: Vec<f64> = gaps.iter().zip(&frames).map(off).collect();
            if !off.iter().any(|gap| gap.abs() > 1e-15 * length) {
                break;
            }
            self.frames = frames;
            let by = self.lifted(&mut mass, &off);
            System::displace(&self.model, &mut state.position, &by);
        }
        Ok(())
    }

    /// Contacts of these frames are closed from now on: those that slip do, others stick until it is decided; what stuck goes on to
    /// if it is `undisturbed` by impacts.
    fn close(&mut self, frames: &[Frame], undisturbed: bool, time: f64) {
        // What comes to rest may take others along that hardly move any more: the directions of these would be what is left of rounding.
        let before = |frame: &Frame| self.closed.iter().find(|was| was.key == frame.key);
        let comes_to_rest = |frame: &Frame| before(frame).is_some_and(|was| self.has_come_to_rest(was, &frame.slip()));
        let any_ends = frames.iter().any(comes_to_rest);
        let closed = frames.iter().map(|frame| {
            let slip = frame.slip();
            let was = before(frame);
            let state = match was {
                Some(was) if undisturbed && was.state == ContactState::Stick => self.moves(frame, self.kept),
                Some(was) if any_ends && self.rest_of(was) > 0.0 => self.moves(frame, slip::ENDS * self.still),
                _ => self.moves(frame, self.slow),
            };
            // What has come to rest and slips again begins anew.
            let moved = was.is_some_and(|was| was.moved) && slip.norm() > self.still && state != ContactState::Stick;
            let meeting = frame.meeting;
            let force = Vector3::zeros();
            let axis = frame.basis.column(1).into_owned();
            let (straight, across, pushes, begins) = (false, 0.0, self.bears(frame, time), Vector3::zeros());
            let before = self.closed.iter().find(|was| was.key == frame.key && was.pushes == pushes);
            let since = before.map_or(time, |was| was.since);
            let (key, gap) = (frame.key, meeting.gap);
            Closed { key, state, axis, gap, meeting, force, slip, straight, moved, begins, across, pushes, since }
        });
        self.closed = closed.collect();
    }

    /// What a contact does by its velocity alone: it slips if that is faster than `slow` (m/s).
    pub(super) fn moves(&self, frame: &Frame, slow: f64) -> ContactState {
        let slip = frame.slip();
        match slip.norm() > slow {
            _ if self.law(frame.key.couple).friction.stick == 0.0 => ContactState::Slip(Vector3::zeros()),
            true => ContactState::Slip(slip.normalize()),
            false => ContactState::Stick,
        }
    }

    /// Takes from velocities what closed contacts do not allow, all of it below the speed of rest. What slips may do so in another
    /// direction then, or stick: it is held again until no more of it sticks.
    fn hold(&mut self, system: &mut System, time: f64, state: &mut State) -> Result<(), Fault> {
        let mut a = vec![0.0; state.velocity.len()];
        loop {
            let mut mass = self.refresh(system, time, &state.position, &state.velocity, &mut a)?;
            self.choose(&mut mass);
            self.project(system, time, &mut state.position, &mut state.velocity)?;
            self.refresh(system, time, &state.position, &state.velocity, &mut a)?;
            let mut ends = true;
            for at in 0..self.closed.len() {
                if self.closed[at].state != ContactState::Stick {
                    self.closed[at].state = self.moves(&self.frames[at], self.slow);
                    ends &= self.closed[at].state != ContactState::Stick;
                }
            }
            if ends {
                return Ok(());
            }
        }
    }

    /// The states of closed contacts, by one cone problem on accelerations.
    fn decide(&mut self, system: &mut System, time: f64, state: &mut State, less: f64) -> Result<(), Trouble> {
        if self.closed.is_empty() {
            return Ok(());
        }
        let mut a = vec![0.0; state.velocity.len()];
        let mut mass = self.refresh(system, time, &state.position, &state.velocity, &mut a)?;
        self.press_springs(&mut mass, &mut a);
        let mut frames = self.frames.clone();
        // Of what is compliant the normal force is known.
        for frame in frames.iter_mut().filter(|frame| !self.is_rigid(frame.key.couple)) {
            frame.columns[0].clear();
            frame.bias.x = 0.0;
        }
        let answers = responses(&mut mass, &frames);
        let rates: Vec<Vector3<f64>> = frames.iter().map(|frame| frame.rates(&a) + frame.bias).collect();
        let size = rates.iter().map(|rate| rate.amax()).fold(0.0, f64::max);
        let mut problem = problem(&frames, &answers, rates, self.laws(&frames, less));
        let mut forces = vec![Vector3::zeros(); frames.len()];
        let touching = self.closed.clone();
        if self.by_rows(system, state, &frames, [size, less])? {
            return Ok(());
        }
        self.closed.clear();
        let gives = less < 0.0 && frames.iter().any(|frame| self.gives(frame));
        let mut tried = 0;
        while let Some(sweeps) = SWEEPS.get(tried) {
            let found = problem.solve(&forces, FOUND, *sweeps);
            if !found.forces.iter().all(|f| f.iter().all(|x| x.is_finite())) {
                // Beside others that slide sweeps may run off without a paradox.
                let Some(worst) = (0..frames.len()).find(|i| problem.jams(*i)) else { break };
                let why = "pressing harder does not lift what slides there (Painlevé's paradox): rigid bodies with this friction \
                           have no acceleration";
                return Err(Trouble::Contact { between: self.between(frames[worst].key.couple), why: why.to_owned() });
            }
            tried += 1;
            let settled = found.change <= SETTLED || tried == SWEEPS.len();
            if gives && settled && self.give_way(&frames, &found, size, &mut problem) {
                (forces, tried) = (found.forces, 0);
                continue;
            }
            self.read(&touching, &frames, &found, size);
            let fits = self.fits(system, state, &frames, size)?;
            self.compare();
            let (is_found, holds) = (found.change <= FOUND, fits.rises && self.reserve() >= -BEYOND);
            // Of the right states forces may be out of their cones by rounding.
            if holds && (fits.brakes || is_found || tried == SWEEPS.len()) || is_found && self.reserve() >= -SETTLED {
                return Ok(());
            }
            forces = found.forces;
        }
        let why = format!("the forces of {} contacts are not found", frames.len());
        Err(Trouble::Undecided { between: self.between(frames[0].key.couple), why })
    }

    /// Whether friction at rest is more than in motion.
    pub(super) fn gives(&self, frame: &Frame) -> bool {
        let friction = self.law(frame.key.couple).friction;
        friction.slide < friction.stick
    }

    /// Where friction at rest is more than in motion and nothing has reached its limit, each contact holds with what it has at rest until an
    /// answer says that it slips: from then on it has what it has in motion. True if that is so of any that it was not so of before.
    fn give_way(&self, frames: &[Frame], found: &Answer, size: f64, problem: &mut Problem) -> bool {
        let (least, mut any) = (slips(found) * size, false);
        let gives = |k: usize| found.states[k] == ConeState::Slip && found.rates[k].yz().norm() > least;
        for (k, frame) in frames.iter().enumerate().filter(|(k, _)| gives(*k)) {
            let moving = self.law(frame.key.couple).friction.slide;
            if let Law::Coulomb { stick, slide } = &mut problem.laws[k]
                && *slide > moving
            {
                (*stick, *slide, any) = (stick.min(moving), moving, true);
            }
        }
        any
    }

    /// Reads the states of contacts off an answer.
    fn read(&mut self, touching: &[Closed], frames: &[Frame], found: &Answer, size: f64) {
        let slips = slips(found) * size;
        self.closed.clear();
        for (k, closed) in touching.iter().enumerate() {
            let (force, rate, mut closed) = (found.forces[k], found.rates[k], closed.clone());
            let frictionless = self.law(closed.key.couple).friction.stick == 0.0;
            closed.state = match (found.states[k], closed.state) {
                (_, state) if !self.is_rigid(closed.key.couple) => state,
                (ConeState::Open, _) if rate.x > slips => continue,
                (ConeState::Open, _) => ContactState::Spare,
                (ConeState::Stick, _) => ContactState::Stick,
                (ConeState::Slip, _) if frictionless => ContactState::Slip(Vector3::zeros()),
                (ConeState::Slip, ContactState::Slip(direction)) => ContactState::Slip(direction),
                (ConeState::Slip, _) if rate.yz().norm() <= slips => ContactState::Stick,
                (ConeState::Slip, _) => {
                    let across = |x: Vector3<f64>| frames[k].basis.column(1) * x.y + frames[k].basis.column(2) * x.z;
                    let direction = (-across(force)).try_normalize(0.0).or_else(|| across(rate).try_normalize(0.0));
                    ContactState::Slip(direction.unwrap_or_else(|| frames[k].basis.column(1).into_owned()))
                }
            };
            let sprung = self.sprung(&closed, &frames[k]);
            closed.force = frames[k].basis * (force + Vector3::x() * sprung);
            self.closed.push(closed);
        }
        self.begin_slips();
    }

    /// Forces are compared with the largest of those that the rows give: sweeps that run off have others.
    pub(super) fn compare(&mut self) {
        let largest = self.closed.iter().map(|closed| closed.force.amax()).fold(0.0, f64::max);
        self.scale = if largest > 0.0 { largest } else { self.scale };
        self.reserve.take();
    }

    /// What the rows of these states give.
    pub(super) fn fits(
        &mut self,
        system: &mut System,
        state: &State,
        frames: &[Frame],
        size: f64,
    ) -> Result<Fits, Fault> {
        let (time, q, v) = (system.time(), &state.position, &state.velocity);
        let mut a = vec![0.0; v.len()];
        for turn in 0..=MOST_TURNS + 1 {
            let mut mass = self.refresh(system, time, q, v, &mut a)?;
            self.choose(&mut mass);
            self.correct(&mut mass, &mut a);
            let bent = self.bent();
            if bent <= 1e-3 * STRAIGHT && (bent <= 1e-13 || turn == MOST_TURNS) {
                break;
            }
            self.turn(turn >= MOST_TURNS);
        }
        let rigid = |frame: &&Frame| self.is_rigid(frame.key.couple);
        let rises = frames.iter().filter(rigid).all(|frame| (frame.rates(&a) + frame.bias).x >= -SINKS * size);
        let least = SLIPS * size;
        let rates: Vec<Vector3<f64>> = self.frames.iter().map(|frame| frame.rates(&a) + frame.bias).collect();
        let all = self.closed.iter().zip(&self.frames).zip(&rates);
        let brakes = all.into_iter().all(|((closed, frame), rate)| self.brakes(closed, frame, rate, least));
        Ok(Fits { rises, brakes, rates })
    }

    /// Whether a slip that begins is against its friction; one that moves has its direction, and what accelerates by less than `least`
    /// has none.
    fn brakes(&self, closed: &Closed, frame: &Frame, rate: &Vector3<f64>, least: f64) -> bool {
        let ContactState::Slip(direction) = closed.state else { return true };
        if direction == Vector3::zeros() || closed.slip.norm() > self.slow || !self.is_rigid(closed.key.couple) {
            return true;
        }
        let (rate, along) = (rate.yz(), frame.flat(&direction));
        let forward = rate.dot(&along);
        let across = (rate - along * forward).norm();
        across <= (AGAINST * rate.norm()).max(least) && forward >= -least
    }

    /// What has changed for couples, beside impacts.
    fn tell(&self, before: &[(usize, bool)], bore: &[(usize, Meeting)], struck: &[usize], changed: &mut Changed) {
        let after = self.told();
        let now = self.bearing();
        for (couple, _) in before.iter().filter(|(couple, _)| !after.iter().any(|(other, _)| other == couple)) {
            if !struck.contains(couple) {
                let ends = bore.iter().filter(|(of, place)| of == couple && place.inside < 0.0);
                let goes_on = ends.into_iter().any(|(_, place)| self.is_carried(*couple, place, &now));
                changed.told.push(self.say(if goes_on { Kind::GoesOn } else { Kind::Lifts }, *couple, 0.0));
            }
        }
        for (couple, slips) in &after {
            let was = before.iter().find(|(other, _)| other == couple).map(|(_, slips)| *slips);
            let of = self.closed.iter().zip(&self.frames).find(|(closed, _)| closed.key.couple == *couple);
            let rolls = of.is_some_and(|(_, frame)| frame.spin.norm() > self.slow / self.model.length_scale());
            let frictionless = self.law(*couple).friction.stick == 0.0;
            let meets = of.filter(|(_, frame)| was.is_none() && !self.is_rigid(frame.key.couple));
            if let Some((_, frame)) = meets {
                changed.told.push(self.say(Kind::Strikes, *couple, -frame.speed.x));
            }
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

    /// Lets the whole scene rest from now on, with velocities of zero, if nothing moves and nothing accelerates. For scenes in which
    /// nothing changes with time.
    pub(in crate::simulate) fn rest_if_still(&mut self, state: &mut State, a: &[f64]) {
        let (length, span) = (self.model.length_scale(), self.model.time_scale());
        let rests = self.model.links.iter().skip(1).all(|link| {
            let unit = if link.joint.is_distance() { length } else { 1.0 };
            (link.velocity..link.velocity + link.joint.counts().1).all(|i| {
                state.velocity[i].abs() <= self.slow * unit / length && a[i].abs() <= STILL * unit / (span * span)
            })
        });
        if rests && !self.closed.is_empty() {
            state.velocity.fill(0.0);
            self.regime = Regime::Resting;
        }
    }
}
