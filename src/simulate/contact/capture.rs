//! Many contacts, or too many events: steps that capture all of an instant's events at once.
//!
//! ```text
//! (1)  q_m = q ⊞ ½ h v,   v_f = v + h q̈_free(q_m, ½ (v + v_f + h p)),   v⁺ = v_f + M⁻¹ Jᵀ λ,   q⁺ = q_m ⊞ ½ h v⁺
//! (2)  K* ∋ w + μ |w_t| n  ⊥  λ ∈ K(μ),   w = J v⁺ + ½ h c + n (2 max(g_m, 0) / h + e min(u_n, 0))
//!      p   M⁻¹ Jᵀ λ / h of the step before: what impulses do within the step to what depends on velocities
//!      c   by how much u̇ is more than J q̈: what the contact's own way over the bodies does
//! ```
//!
//! (Moreau 1988, Jean 1999: Moreau–Jean's method with the cone problem of [`crate::contact::cone`].) All pairs that might meet within the step
//! are in (2), with the way that is left to them: nothing sinks but by half a step's way at an impact, of which a part is taken back behind
//! every step ([`super::raise`]), and steps may be halved. What bounces is left alone until it has met: a step that ended on the way would take its speed.
//! Coordinates of trees are put back on their rigid limits. Dry friction of hinges is bounded in (2). The method has order 1 at impacts and
//! order 2 where contacts roll, and what spins keeps its energy: the midpoint rule has no growth of its own. A step and its two halves are
//! compared in positions, and where nothing strikes in velocities, too, which jump at impacts; the halves are kept.

use super::moreau::{Ahead, Ask, Made, SWEEPS_OF_STEP, moreau};
use super::{Contacts, Regime};
use crate::contact::frame::{self, Frame};
use crate::contact::hinges::Id;
use crate::contact::pairs::Key;
use crate::dynamics::applied::Rubbing;
use crate::dynamics::{Factorized, Fault, System};
use crate::integrate::{Failure, Limit, Problem as _, Progress, Start, StepError, Stepper};
use crate::simulate::problem::Equations;
use crate::simulate::state::State;
use nalgebra::Vector3;

/// Steps are at most this part of the scene's time, at first and at least those.
const LONGEST: f64 = 0.02;
const FIRST: f64 = 2e-3;
const SHORTEST: f64 = 1e-5;
/// Positions of a step and of its halves differ by no more than the root of a run's tolerance, within these bounds (parts of the
/// largest shape that may touch): half the digits, as the order is one.
const COARSE: [f64; 2] = [1e-5, 2e-2];
/// A gap below this part of a shape's size is none for the events that take over.
const CLOSES: f64 = 1e-4;
/// Rates of contacts are found to this part of what makes a difference of positions as large as it may be in a step, or as far as so many
/// sweeps take them.
const FOUND: f64 = 0.02;
/// Forces at rest balance to this part of what the scene accelerates with, as far as sweeps take them.
const BALANCED: f64 = 1e-7;
/// Sweeps for them, once for each rest: some times those of a step.
const SWEEPS_AT_REST: usize = 5_000;
/// Steps with the same contacts in the same states after which events take over again.
const CALM: usize = 10;
/// A step gains no more than this part of the kinetic energy.
const GAINED: f64 = 0.01;
/// Energy that a step may gain as its forces are found to [`FOUND`] only, in parts of the scene's weight over its length.
const UNBALANCED: f64 = 1e-9;
/// What has sunk by more than this part of a shape's size is lost; a longer step than the shortest sinks by no more than a quarter of what
/// is left to it.
pub(super) const LOST: f64 = 1e-2;
const SINKS: f64 = 0.25;

/// What carries over from step to step.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Memory {
    /// Impulses of the last step over its length (N).
    pub(super) forces: Vec<(Id, Vector3<f64>)>,
    /// What they accelerated with (m/s², rad/s²).
    pub(super) pressed: Vec<f64>,
    /// What pushed in the last step.
    pub(super) active: Vec<Id>,
    pub(super) calm: usize,
    /// Steps in which nothing moved.
    pub(super) still: usize,
    /// Energy that contacts took out and that drives put into their impulses since it was last asked for (J).
    pub(super) lost: f64,
    pub(super) work: f64,
    /// When the last step began and ended (s).
    pub(super) last: [f64; 2],
    pub(super) steps: usize,
    /// The step that is tried next (s).
    pub(super) step: f64,
    /// How deep anything has sunk at the end of the last step, in parts of its size, if there was one.
    pub(super) depth: Option<f64>,
}

impl Memory {
    /// Of steps that begin anew: how many there have been and how long the last one was stays.
    pub(super) fn restart(&mut self) {
        *self = Self { steps: self.steps, step: self.step, ..Self::default() };
    }

    /// Contacts that pushed in the last step, and with what.
    pub(super) fn pairs(&self) -> impl Iterator<Item = (&Key, &Vector3<f64>)> + Clone {
        self.forces.iter().filter_map(|(id, force)| match id {
            Id::Contact(key) => Some((key, force)),
            Id::Stop(_) | Id::Friction(_) => None,
        })
    }
}

/// The stepper of (1).
pub(in crate::simulate) struct Capture {
    progress: Progress,
    /// Positions may differ by this, in parts of these scales.
    tolerance: f64,
    /// Steps are this part of what they may be.
    part: f64,
    scales: Vec<f64>,
    before: (Vec<f64>, Vec<f64>),
    next: Vec<f64>,
}

impl Capture {
    /// From a start to its end, at a run's tolerance; `part`: see [`crate::simulate::events::search::Search`].
    ///
    /// # Errors
    /// A start that is none.
    pub(in crate::simulate) fn new(
        motion: &Equations,
        start: Start<'_>,
        (tolerance, part): (f64, f64),
    ) -> Result<Self, StepError> {
        let before = (start.position.to_vec(), start.velocity.to_vec());
        let progress = Progress::new(motion, start)?;
        let (mut scales, model) = (motion.scales().0.to_vec(), motion.model());
        if let Some(contacts) = &motion.contacts {
            let slides = model.links.iter().filter(|link| link.joint.is_distance());
            slides.for_each(|link| scales[link.position] = contacts.lengths[1]);
        }
        let tolerance = tolerance.sqrt().clamp(COARSE[0], COARSE[1]) * part * part;
        Ok(Self { progress, tolerance, part, scales, before, next: Vec::new() })
    }

    /// A step and its halves, which are what is kept.
    ///
    /// # Errors
    /// A state that cannot be evaluated.
    fn attempt(&self, motion: &mut Equations, time: f64, [q, v]: [&[f64]; 2], step: f64) -> Result<Tried, Fault> {
        let memory = motion.contacts.as_ref().map(|contacts| &contacts.memory);
        let (warm, pressed) =
            memory.map_or_else(Default::default, |memory| (memory.forces.clone(), memory.pressed.clone()));
        let smallest = motion.contacts.as_ref().map_or(0.0, |contacts| contacts.lengths[0]);
        let fine = FOUND * self.tolerance * smallest;
        let ask = Ask { warm: &warm, pressed: &pressed, fine, sweeps: SWEEPS_OF_STEP, ahead: Ahead::Strikes };
        let pushing = motion.system.phase().pushing.clone();
        let whole = moreau(motion, time, [q, v], step, ask)?;
        let first = moreau(motion, time, [q, v], 0.5 * step, Ask { pressed: &whole.pressed, ..ask })?;
        let from = [first.position.as_slice(), first.velocity.as_slice()];
        let mut made = moreau(
            motion,
            time + 0.5 * step,
            from,
            0.5 * step,
            Ask { warm: &first.forces, pressed: &first.pressed, ..ask },
        )?;
        motion.system.phase_mut().pushing = pushing;
        let off = |[a, b]: [&[f64]; 2], scales: &[f64]| {
            let both = a.iter().zip(b).zip(scales);
            both.map(|((a, b), scale)| (a - b).abs() / scale).fold(0.0, f64::max)
        };
        let mut error = off([&whole.position, &made.position], &self.scales) / self.tolerance;
        // Where nothing is struck velocities go on, and what a turn leaves of them stays.
        if !(whole.struck || first.struck || made.struck) {
            let off = off([&whole.velocity, &made.velocity], motion.scales().1);
            error = error.max(off.max(first.turned).max(made.turned) / self.tolerance);
        }
        made.lost += first.lost;
        made.work += first.work;
        made.opposed += first.opposed;
        made.held_back += first.held_back;
        // What that puts in comes from nowhere: it is left unaccounted for.
        let depth = motion.raise(time + step, &mut made.position, &made.velocity)?;
        let Equations { contacts: Some(contacts), system, .. } = motion else {
            return Ok(Tried { made, error, found: true, gained: 0.0, depth: 0.0, sinks: 0.0 });
        };
        let after = system.at(time + step, &made.position, &made.velocity).energies().kinetic;
        let rounding = UNBALANCED * contacts.scale * contacts.model.length_scale();
        let gained = -made.opposed - GAINED * after - rounding;
        let (found, sinks) = (first.found && made.found, depth - contacts.memory.depth.unwrap_or(0.0));
        Ok(Tried { found, made, error, gained, depth, sinks })
    }
}

/// A step that may be too long.
struct Tried {
    /// Its second half, with what both halves took out.
    made: Made,
    /// Of its position, in parts of what is allowed.
    error: f64,
    /// Whether the forces of both halves are found.
    found: bool,
    /// Energy that it gains beyond what it may (J).
    gained: f64,
    /// How deep anything has sunk at its end, and how much deeper than at the end of the last step, in parts of its size: positions are
    /// compared with the scene's length, and shapes may be thin.
    depth: f64,
    sinks: f64,
}

impl Tried {
    /// Whether it is short enough.
    fn keeps(&self) -> bool {
        self.found && self.error <= 1.0 && self.gained <= 0.0 && self.sinks <= SINKS * (LOST - self.depth + self.sinks)
    }
}

/// Carries over what a step from one time to another did; `next` has the step that is tried next (s) from the one that was.
fn remember(motion: &mut Equations, tried: Tried, times: [f64; 2], next: impl Fn(f64) -> f64) {
    let Tried { made, depth, .. } = tried;
    let span = motion.model().time_scale();
    let scales = motion.scales().1.to_vec();
    let Some(contacts) = &mut motion.contacts else { return };
    let slow = contacts.slow * 1e2 / contacts.model.length_scale();
    let still = scales.iter().zip(&made.velocity).all(|(scale, v)| v.abs() <= slow * span * scale);
    let memory = &mut contacts.memory;
    // What contacts seem to put in is an error of the step, and unaccounted for.
    memory.lost += made.lost.max(0.0);
    memory.work += made.work;
    memory.last = times;
    memory.steps += 1;
    contacts.held_back += made.held_back;
    memory.depth = Some(depth);
    memory.step = next(memory.step);
    let active: Vec<Id> = made.forces.iter().map(|(id, _)| *id).collect();
    memory.calm = if active == memory.active { memory.calm + 1 } else { 0 };
    memory.active = active;
    memory.forces = made.forces;
    memory.pressed = made.pressed;
    memory.still = if still { memory.still + 1 } else { 0 };
}

impl Stepper<Equations> for Capture {
    fn step(&mut self, motion: &mut Equations) -> Result<(), StepError> {
        let (time, left) = (self.progress.time(), self.progress.end() - self.progress.time());
        if left <= 0.0 {
            return Ok(());
        }
        let span = self.part * motion.model().time_scale();
        let (q, v) = (self.progress.position().to_vec(), self.progress.velocity().to_vec());
        let Equations { contacts: Some(contacts), system, .. } = motion else { return Ok(()) };
        if contacts.memory.depth.is_none() {
            system.at(time, &q, &v);
            contacts.memory.depth = Some(contacts.depth(system));
        }
        let mut h = if contacts.memory.step > 0.0 { contacts.memory.step } else { FIRST * span };
        loop {
            h = h.min(LONGEST * span).max(SHORTEST * span);
            let last = h >= left * (1.0 - 1e-12);
            let step = if last { left } else { h };
            let fail = |fault: Fault| StepError::Underflow { time, step, limit: Limit::Failure(fault.into()) };
            let tried = self.attempt(motion, time, [&q, &v], step).map_err(fail)?;
            let proposed = h * (0.8 * tried.error.max(1e-9).powf(-0.5)).clamp(0.2, 3.0);
            if step > SHORTEST * span && !tried.keeps() {
                self.progress.reject();
                // Of a shorter step fewer supports are in the way, and less sinks.
                h = if tried.found && !(tried.error <= 1.0) { proposed.min(0.5 * step) } else { 0.5 * step };
                continue;
            }
            if !(tried.gained <= 0.0) {
                let message = format!("captured contacts would gain {:.3e} J more in it than rounding", tried.gained);
                return Err(StepError::Underflow { time, step, limit: Limit::Failure(Failure { message }) });
            }
            self.before = (q, v);
            self.next = [tried.made.position.as_slice(), tried.made.velocity.as_slice()].concat();
            let end = if last { self.progress.end() } else { time + step };
            remember(motion, tried, [time, end], |before| if last { before.max(proposed.min(h)) } else { proposed });
            self.progress.advance(end, &mut self.next);
            return Ok(());
        }
    }

    fn progress(&self) -> &Progress {
        &self.progress
    }

    fn interpolate(
        &mut self,
        motion: &mut Equations,
        time: f64,
        q: &mut [f64],
        v: &mut [f64],
    ) -> Result<(), StepError> {
        let (from, to) = (self.progress.previous_time(), self.progress.time());
        let part = if to > from { ((time - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
        let mix = |a: f64, b: f64| if part >= 1.0 { b } else { a + part * (b - a) };
        let (before, after) = (&self.before, (self.progress.position(), self.progress.velocity()));
        q.iter_mut().zip(before.0.iter().zip(after.0)).for_each(|(q, (a, b))| *q = mix(*a, *b));
        v.iter_mut().zip(before.1.iter().zip(after.1)).for_each(|(v, (a, b))| *v = mix(*a, *b));
        motion.normalize(q);
        Ok(())
    }
}

impl Equations {
    /// The forces of captured steps at a state from which they begin, for what is told of it: of a short step in which nothing strikes.
    ///
    /// # Errors
    /// A state that cannot be evaluated.
    pub(in crate::simulate) fn foresee(&mut self, time: f64, state: &State) -> Result<(), Fault> {
        if !self.is_captured() {
            return Ok(());
        }
        self.let_go(time, state)?;
        let fine = self.contacts.as_ref().map_or(0.0, |contacts| FOUND * COARSE[0] * contacts.lengths[0]);
        self.press_at(time, state, fine, (SWEEPS_OF_STEP, Ahead::Waits))
    }

    /// The forces that hold a state at rest, where its points of contact are.
    ///
    /// # Errors
    /// A state that cannot be evaluated.
    pub(in crate::simulate) fn balance_at_rest(&mut self, time: f64, state: &State) -> Result<(), Fault> {
        self.press_at(
            time,
            state,
            BALANCED * FIRST * FIRST * self.model().length_scale(),
            (SWEEPS_AT_REST, Ahead::Rests),
        )
    }

    /// The forces of a short step from a state in which nothing strikes, its rates found to `fine` over the step (m).
    fn press_at(&mut self, time: f64, state: &State, fine: f64, (sweeps, ahead): (usize, Ahead)) -> Result<(), Fault> {
        let warm = self.contacts.as_ref().map_or_else(Vec::new, |contacts| contacts.memory.forces.clone());
        let step = FIRST * self.model().time_scale();
        let ask = Ask { warm: &warm, pressed: &[], fine, sweeps, ahead };
        // Stops that the middle of the step touches push there, and begin to when a step has gone there.
        let pushing = self.system.phase().pushing.clone();
        let made = moreau(self, time, [&state.position, &state.velocity], step, ask);
        self.system.phase_mut().pushing = pushing;
        let made = made?;
        if let Some(contacts) = &mut self.contacts {
            contacts.memory.forces = made.forces;
        }
        Ok(())
    }

    /// Lets go of everything that stops and dry friction hold: captured steps bear it from now on.
    pub(in crate::simulate) fn let_go(&mut self, time: f64, state: &State) -> Result<(), Fault> {
        self.hold(time, state, &[])?;
        self.system.phase_mut().rubbing.fill(Rubbing::Sticks);
        Ok(())
    }
}

impl Contacts {
    /// The couple that has sunk deepest in the last place, and how far, in parts of its size.
    pub(in crate::simulate) fn deepest(&self) -> Option<([String; 2], f64)> {
        let near = self.pairs.near(&vec![0.0; self.pairs.pieces.len()]).into_iter();
        let depth = |couple: usize| (couple, self.pairs.depth(couple) / self.pairs.couples[couple].size);
        let (couple, depth) =
            near.filter(|couple| self.is_rigid(*couple)).map(depth).max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((self.between(couple), depth))
    }

    /// How deep anything has sunk at the place of a system, in parts of its size.
    pub(super) fn depth(&mut self, system: &System) -> f64 {
        self.pairs.place_at(system.links());
        self.deepest().map_or(0.0, |(_, depth)| depth)
    }

    /// The couple that has sunk by more than [`LOST`], and how far; places shapes at the place of the system.
    pub(in crate::simulate) fn sunk(&mut self, system: &System) -> Option<([String; 2], f64)> {
        self.pairs.place_at(system.links());
        self.deepest().filter(|(_, depth)| *depth > LOST)
    }

    /// Lets events go on: what captured steps have brought together is closed.
    pub(in crate::simulate) fn end_capture(&mut self) {
        self.regime = Regime::Events;
        self.closing = CLOSES;
    }

    /// Of the last captured step what is not booked yet at a time within it: energy that contacts take out in all of it, and what drives have
    /// put into their impulses by then, which are spread over the step (J).
    pub(in crate::simulate) fn not_booked(&self, time: f64) -> [f64; 2] {
        let Memory { lost, work, last: [from, to], .. } = self.memory;
        let part = if to > from { ((time - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
        [lost.max(0.0), part * work]
    }

    /// Energy that captured contacts took out and that drives put into their impulses since this was last asked (J).
    pub(in crate::simulate) fn taken(&mut self) -> [f64; 2] {
        [std::mem::take(&mut self.memory.lost), std::mem::take(&mut self.memory.work)]
    }

    /// Whether events may take over again.
    pub(in crate::simulate) fn is_calm(&self, time: f64) -> bool {
        let few = 3 * self.memory.active.len() <= super::MOST_ROWS && self.pairs.couples.len() <= super::MOST_COUPLES;
        let stopped = self.memory.active.iter().filter_map(|id| match id {
            Id::Stop(side) => Some(self.model.stops[side.stop].velocity),
            Id::Contact(_) | Id::Friction(_) => None,
        });
        let stopped: Vec<usize> = stopped.collect();
        let mut contacts = self.memory.pairs().map(|(key, _)| key.couple);
        let tied = contacts.clone().any(|couple| self.is_tied(couple, &stopped));
        // What touches nothing is left to itself at once.
        let until = if contacts.next().is_none() { f64::NEG_INFINITY } else { self.stretch.until };
        self.is_captured() && few && !tied && self.memory.calm >= CALM && time >= until
    }

    /// Whether nothing has moved for some captured steps.
    pub(in crate::simulate) fn is_still(&self) -> bool {
        self.is_captured() && self.memory.still >= 3
    }

    /// Adds what the forces of the last captured step do to accelerations, and hands them to the system.
    pub(super) fn carry(&mut self, mass: &mut Factorized<'_>, a: &mut [f64]) {
        let motion = mass.motion();
        frame::carried(motion, &self.model, &mut self.carried);
        self.pairs.place(motion);
        let mut push = vec![0.0; a.len()];
        let (mut wrenches, mut of_hinges) = (Vec::new(), Vec::new());
        for (id, force) in &self.memory.forces {
            let key = match id {
                Id::Contact(key) => key,
                Id::Stop(side) => {
                    let (velocity, force) = (self.model.stops[side.stop].velocity, -side.at.sign() * force.x);
                    push[velocity] += force;
                    of_hinges.push((velocity, force));
                    continue;
                }
                Id::Friction(index) => {
                    let own = &self.model.hinge_friction[*index];
                    for i in 0..own.count {
                        push[own.velocity + i] += force[i];
                        of_hinges.push((own.velocity + i, force[i]));
                    }
                    continue;
                }
            };
            let Some(meeting) = self.pairs.meeting(key) else { continue };
            let frame = Frame::new(&self.model, motion, &self.pairs, &self.carried, *key, meeting, None);
            frame.push(&frame.basis.tr_mul(force), &mut push);
            wrenches.push((frame.links, meeting.point, *force));
        }
        let mut change = vec![0.0; a.len()];
        mass.answer_impulse(&push, &mut change);
        a.iter_mut().zip(&change).for_each(|(a, change)| *a += change);
        if self.is_at_rest() {
            a.fill(0.0);
        }
        wrenches.into_iter().for_each(|(links, point, force)| super::rows::press(mass, links, &point, &force));
        of_hinges.into_iter().for_each(|(velocity, force)| mass.press_hinge(velocity, force));
    }

    /// Adds to `out` what rigid stops push each velocity coordinate with by the forces of captured steps (N or N m).
    pub(in crate::simulate) fn stop_forces(&self, out: &mut [f64]) {
        for (id, force) in self.memory.forces.iter().filter(|_| self.follows_steps()) {
            if let Id::Stop(side) = id {
                out[self.model.stops[side.stop].velocity] -= side.at.sign() * force.x;
            }
        }
    }
}
