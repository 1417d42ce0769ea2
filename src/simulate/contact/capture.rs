//! Many contacts, or too many events: steps that capture all of an instant's events at once.
//!
//! ```text
//! (1)  q_m = q ⊞ ½ h v,   v⁺ = v + h q̈_free(q_m, v) + M⁻¹ Jᵀ λ,   q⁺ = q_m ⊞ ½ h v⁺
//! (2)  K* ∋ w + μ |w_t| n  ⊥  λ ∈ K(μ),   w = J v⁺ + ½ h c + n (2 max(g_m, 0) / h + e min(u_n, 0))
//!      c   by how much u̇ is more than J q̈: what the contact's own way over the bodies does
//! ```
//!
//! (Moreau 1988, Jean 1999: Moreau–Jean's method with the cone problem of [`crate::contact::cone`].) All pairs that might meet within the step
//! are in (2), with the way that is left to them: nothing sinks but by half a step's way at an impact, of which a part is taken back behind
//! every step ([`super::raise`]), and steps may be halved. What bounces is left alone until it has met: a step that ended on the way would take its speed.
//! Coordinates of trees are put back on their rigid limits. Dry friction of hinges is bounded in (2). The method has order 1 at impacts and
//! order 2 where contacts roll; a step and its two halves are compared in positions, as velocities jump at impacts, and the halves are kept.

use super::blocks::Blocks;
use super::{Contacts, Regime};
use crate::contact::cone::{Law, Problem};
use crate::contact::frame::{self, Frame, along};
use crate::contact::geometry::feature::Meeting;
use crate::contact::hinges::{self, Id, Support};
use crate::contact::pairs::Key;
use crate::dynamics::applied::Rubbing;
use crate::dynamics::{Factorized, Fault, System};
use crate::integrate::{Failure, Limit, Problem as _, Progress, Start, StepError, Stepper};
use crate::simulate::problem::Motion;
use crate::simulate::state::State;
use nalgebra::{Matrix3, Vector3};

/// Steps are at most this part of the scene's time, and at least that.
const LONGEST: f64 = 0.02;
const SHORTEST: f64 = 1e-5;
/// Positions of a step and of its halves differ by no more than the root of a run's tolerance, within these bounds (parts of the
/// scene's length): half the digits, as the order is one.
const COARSE: [f64; 2] = [1e-5, 2e-3];
/// What has sunk or rises has turned by as much: features count to this part of a size beyond where they do. Edges that lie across each other would lose
/// their contact to a turn of 1e-7.
const ASKEW: f64 = 1e-4;
/// A gap below this part of a shape's size is none for the events that take over.
const CLOSES: f64 = 1e-4;
/// Rates of contacts are found to this part of what makes a difference of positions as large as it may be in a step, or as far as so many
/// sweeps take them.
const FOUND: f64 = 0.02;
const MOST_SWEEPS: usize = 1200;
/// Steps with the same contacts in the same states after which events take over again.
const CALM: usize = 10;
/// A step gains no more than this part of the kinetic energy.
const GAINED: f64 = 0.01;
/// Energy gain that is rounding, in parts of the scene's weight over its length.
const ROUNDING: f64 = 1e-9;
/// What has sunk by more than this part of a shape's size is lost; a longer step than the shortest sinks by no more than a quarter of it.
pub(super) const LOST: f64 = 1e-2;
const SINKS: f64 = 0.25 * LOST;

/// What carries over from step to step.
#[derive(Debug, Default)]
pub(super) struct Memory {
    /// Impulses of the last step over its length (N).
    forces: Vec<(Id, Vector3<f64>)>,
    /// What pushed in the last step.
    active: Vec<Id>,
    calm: usize,
    /// Steps in which nothing moved.
    still: usize,
    /// Energy that contacts took out and that drives put into their impulses since it was last asked for (J).
    lost: f64,
    work: f64,
    pub(super) steps: usize,
    /// The step that is tried next (s).
    pub(super) step: f64,
    /// How deep anything has sunk at the end of the last step, in parts of its size, if there was one.
    depth: Option<f64>,
}

impl Memory {
    /// Of steps that begin anew: how many there have been and how long the last one was stays.
    pub(super) fn restart(&mut self) {
        *self = Self { steps: self.steps, step: self.step, ..Self::default() };
    }

    /// Contacts that pushed in the last step, and with what.
    pub(super) fn pairs(&self) -> impl Iterator<Item = (&Key, &Vector3<f64>)> {
        self.forces.iter().filter_map(|(id, force)| match id {
            Id::Contact(key) => Some((key, force)),
            Id::Stop(_) | Id::Friction(_) => None,
        })
    }
}

/// A step and what it did.
struct Made {
    position: Vec<f64>,
    velocity: Vec<f64>,
    forces: Vec<(Id, Vector3<f64>)>,
    lost: f64,
    /// What drives put into impulses (J).
    work: f64,
    /// What impulses take out behind all other forces of the step, whose work on the way is not theirs (J): never negative.
    opposed: f64,
    /// Whether its forces are found.
    found: bool,
}

/// The stepper of (1).
pub(in crate::simulate) struct Capture {
    progress: Progress,
    /// Positions may differ by this, in parts of these scales.
    tolerance: f64,
    scales: Vec<f64>,
    before: (Vec<f64>, Vec<f64>),
    next: Vec<f64>,
}

impl Capture {
    /// From a start to its end.
    ///
    /// # Errors
    /// A start that is none.
    pub(in crate::simulate) fn new(motion: &Motion, start: Start<'_>, tolerance: f64) -> Result<Self, StepError> {
        let before = (start.position.to_vec(), start.velocity.to_vec());
        let progress = Progress::new(motion, start)?;
        let (mut scales, model) = (motion.scales().0.to_vec(), motion.model());
        if let Some(contacts) = &motion.contacts {
            let slides = model.links.iter().filter(|link| link.joint.is_distance());
            slides.for_each(|link| scales[link.position] = contacts.lengths[1]);
        }
        let tolerance = tolerance.sqrt().clamp(COARSE[0], COARSE[1]);
        Ok(Self { progress, tolerance, scales, before, next: Vec::new() })
    }

    /// A step and its halves, which are what is kept.
    ///
    /// # Errors
    /// A state that cannot be evaluated.
    fn attempt(&self, motion: &mut Motion, time: f64, [q, v]: [&[f64]; 2], step: f64) -> Result<Tried, Fault> {
        let warm = motion.contacts.as_ref().map_or_else(Vec::new, |contacts| contacts.memory.forces.clone());
        let smallest = motion.contacts.as_ref().map_or(0.0, |contacts| contacts.lengths[0]);
        let fine = FOUND * self.tolerance * smallest;
        let whole = moreau(motion, time, [q, v], step, &warm, fine)?;
        let first = moreau(motion, time, [q, v], 0.5 * step, &warm, fine)?;
        let from = [first.position.as_slice(), first.velocity.as_slice()];
        let mut made = moreau(motion, time + 0.5 * step, from, 0.5 * step, &first.forces, fine)?;
        let both = whole.position.iter().zip(&made.position);
        let off = both.zip(&self.scales).map(|((a, b), scale)| (a - b).abs() / scale);
        let error = off.fold(0.0, f64::max) / self.tolerance;
        made.lost += first.lost;
        made.work += first.work;
        made.opposed += first.opposed;
        let (raised, depth) = motion.raise(time + step, &mut made.position, &made.velocity)?;
        made.lost -= raised;
        let Motion { contacts: Some(contacts), system, .. } = motion else {
            return Ok(Tried { made, error, found: true, gained: 0.0, depth: 0.0, sinks: 0.0 });
        };
        let after = system.at(time + step, &made.position, &made.velocity).energies().kinetic;
        let rounding = ROUNDING * contacts.scale * contacts.model.length_scale();
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
        self.found && self.error <= 1.0 && self.gained <= 0.0 && self.sinks <= SINKS
    }
}

/// Carries over what a step did; `next` has the step that is tried next (s) from the one that was.
fn remember(motion: &mut Motion, tried: Tried, next: impl Fn(f64) -> f64) {
    let Tried { made, depth, .. } = tried;
    let span = motion.model().time_scale();
    let scales = motion.scales().1.to_vec();
    let Some(contacts) = &mut motion.contacts else { return };
    let slow = contacts.slow * 1e2 / contacts.model.length_scale();
    let still = scales.iter().zip(&made.velocity).all(|(scale, v)| v.abs() <= slow * span * scale);
    let memory = &mut contacts.memory;
    memory.lost += made.lost;
    memory.work += made.work;
    memory.steps += 1;
    memory.depth = Some(depth);
    memory.step = next(memory.step);
    let active: Vec<Id> = made.forces.iter().map(|(id, _)| *id).collect();
    memory.calm = if active == memory.active { memory.calm + 1 } else { 0 };
    memory.active = active;
    memory.forces = made.forces;
    memory.still = if still { memory.still + 1 } else { 0 };
}

impl Stepper<Motion> for Capture {
    fn step(&mut self, motion: &mut Motion) -> Result<(), StepError> {
        let (time, left) = (self.progress.time(), self.progress.end() - self.progress.time());
        if left <= 0.0 {
            return Ok(());
        }
        let span = motion.model().time_scale();
        let (q, v) = (self.progress.position().to_vec(), self.progress.velocity().to_vec());
        let Motion { contacts: Some(contacts), system, .. } = motion else { return Ok(()) };
        if contacts.memory.depth.is_none() {
            system.at(time, &q, &v);
            contacts.memory.depth = Some(contacts.depth(system));
        }
        let mut h = if contacts.memory.step > 0.0 { contacts.memory.step } else { 0.1 * LONGEST * span };
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
            remember(motion, tried, |before| if last { before.max(proposed.min(h)) } else { proposed });
            let end = if last { self.progress.end() } else { time + step };
            self.progress.advance(end, &mut self.next);
            return Ok(());
        }
    }

    fn progress(&self) -> &Progress {
        &self.progress
    }

    fn interpolate(&mut self, motion: &mut Motion, time: f64, q: &mut [f64], v: &mut [f64]) -> Result<(), StepError> {
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

impl Motion {
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

    /// Energy that captured contacts took out in the last step and that is not booked yet (J).
    pub(in crate::simulate) fn not_booked(&self) -> f64 {
        self.memory.lost.max(0.0)
    }

    /// Energy that captured contacts took out and that drives put into their impulses since this was last asked (J).
    pub(in crate::simulate) fn taken(&mut self) -> [f64; 2] {
        [std::mem::take(&mut self.memory.lost), std::mem::take(&mut self.memory.work)]
    }

    /// Whether events may take over again.
    pub(in crate::simulate) fn is_calm(&self, time: f64) -> bool {
        let few = 3 * self.memory.active.len() <= super::MOST_ROWS && self.pairs.couples.len() <= super::MOST_COUPLES;
        // Dry friction and rigid stops that press are followed by captured steps alone.
        let hinges = self.memory.active.iter().any(|id| !matches!(id, Id::Contact(_)));
        let hinges = hinges || !self.model.hinge_friction.is_empty();
        self.is_captured() && few && !hinges && self.memory.calm >= CALM && time >= self.stretch.until
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
        let mut wrenches = Vec::new();
        for (id, force) in &self.memory.forces {
            let key = match id {
                Id::Contact(key) => key,
                Id::Stop(side) => {
                    push[self.model.stops[side.stop].velocity] -= side.at.sign() * force.x;
                    continue;
                }
                Id::Friction(index) => {
                    let own = &self.model.hinge_friction[*index];
                    (0..own.count).for_each(|i| push[own.velocity + i] += force[i]);
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
    }

    /// What may bear within a step: contacts, and rigid stops and dry friction of hinges.
    fn supports(&self, frames: &[Frame], q: &[f64], v: &[f64]) -> Vec<Support> {
        let contact = |frame: &Frame| {
            let friction = self.law(frame.key.couple).friction;
            // What slides has the friction of motion to the end of the step; what rests gives way at its limit and has it from the next one on.
            let has = if frame.slip().norm() > self.kept { friction.slide } else { friction.stick };
            let law = Law::Coulomb { stick: has, slide: has };
            let (columns, gap) = (frame.columns.clone(), frame.meeting.gap);
            Support { id: Id::Contact(frame.key), columns, gap, law }
        };
        let mut all: Vec<Support> = frames.iter().map(contact).collect();
        all.extend(hinges::supports(&self.model, q, v, self.slow));
        all
    }

    /// The part of a speed that an impact on a support gives back.
    fn restitution(&self, support: &Support) -> f64 {
        match support.id {
            Id::Contact(key) => self.law(key.couple).law.restitution(),
            Id::Stop(side) => self.model.stops[side.stop].law.restitution(),
            Id::Friction(_) => 0.0,
        }
    }

    /// Frames of all pairs whose gap is at most what velocities make up in a step.
    fn ahead(&mut self, motion: &crate::motion::Motion, h: f64) -> Vec<Frame> {
        self.pairs.place(motion);
        let fall = h * self.model.gravity.norm();
        let speeds: Vec<_> = (0..self.pairs.pieces.len()).map(|piece| self.pairs.speed(piece, motion)).collect();
        let margins: Vec<f64> = speeds.iter().map(|(v, turning)| h * (v.norm() + turning + fall)).collect();
        self.within(motion, &margins, |[a, b]| {
            let (a, b) = (speeds[a], speeds[b]);
            h * ((a.0 - b.0).norm() + a.1 + b.1 + fall)
        })
    }

    /// Frames of all pairs of features whose gap is at most what `reach` says of their shapes (m), of shapes within `margins` of each other
    /// (m); they are placed.
    pub(super) fn within(
        &mut self,
        motion: &crate::motion::Motion,
        margins: &[f64],
        reach: impl Fn([usize; 2]) -> f64,
    ) -> Vec<Frame> {
        frame::carried(motion, &self.model, &mut self.carried);
        let mut found: Vec<(Key, Meeting)> = Vec::new();
        for couple in self.pairs.near(margins) {
            let reach = reach(self.pairs.couples[couple].pieces);
            if self.pairs.apart(couple) <= reach {
                self.pairs.facing(couple, ASKEW, reach, &mut found);
            }
        }
        let frame = |(key, meeting)| Frame::new(&self.model, motion, &self.pairs, &self.carried, key, meeting, None);
        found.into_iter().map(frame).collect()
    }
}

/// The force of a support in a list of contacts by couples, and then of hinges.
fn remembered(forces: &[(Id, Vector3<f64>)], wanted: Id) -> Option<Vector3<f64>> {
    let from = match wanted {
        Id::Contact(key) => {
            forces.partition_point(|(id, _)| matches!(id, Id::Contact(other) if other.couple < key.couple))
        }
        Id::Stop(_) | Id::Friction(_) => forces.partition_point(|(id, _)| matches!(id, Id::Contact(_))),
    };
    let end = |id: &Id| matches!((id, wanted), (Id::Contact(other), Id::Contact(key)) if other.couple > key.couple);
    forces[from..].iter().take_while(|(id, _)| !end(id)).find(|(id, _)| *id == wanted).map(|(_, force)| *force)
}

/// How much the rates of a contact change in half a step by the way that it goes over both bodies, `½ h c` of [`crate::contact::frame`]:
/// nothing of the second order is missed then where it rolls. No more than it approaches with, `u`: where the step leads further
/// around a body than that, what it meets is another place of it.
fn bend(frame: Option<&Frame>, support: &Support, u: &Vector3<f64>, h: f64) -> Vector3<f64> {
    let Some(frame) = frame else { return Vector3::zeros() };
    let bend = match support.gap > 0.0 {
        // What has a way to go still arrives at its end.
        true => Vector3::x() * (0.25 * h * frame.bias.x),
        false => frame.bias * (0.5 * h),
    };
    let (size, most) = (bend.norm(), u.norm());
    if size > most { bend * (most / size) } else { bend }
}

/// What drives put into the impulses of supports (J).
fn driven(mass: &mut Factorized<'_>, supports: &[Support], forces: &[Vector3<f64>]) -> f64 {
    if mass.system().model().drives.is_empty() {
        return 0.0;
    }
    let n = mass.system().model().velocity_count();
    let (mut impulse, mut change) = (vec![0.0; n], vec![0.0; n]);
    for (support, force) in supports.iter().zip(forces) {
        for (column, f) in support.columns.iter().zip(force) {
            column.iter().for_each(|(i, c)| impulse[*i] += c * f);
        }
    }
    mass.answer_impulse_with_work(&impulse, &mut change)
}

/// (1) and (2); rates of contacts are found to `fine / h` (m).
fn moreau(
    motion: &mut Motion,
    time: f64,
    [q, v]: [&[f64]; 2],
    h: f64,
    warm: &[(Id, Vector3<f64>)],
    fine: f64,
) -> Result<Made, Fault> {
    let mut position = q.to_vec();
    let half = |v: &[f64]| -> Vec<f64> { v.iter().map(|v| 0.5 * h * v).collect() };
    System::displace(motion.model(), &mut position, &half(v));
    let mut velocity = vec![0.0; v.len()];
    let Motion { contacts, system, .. } = motion;
    let mut mass = system.at_without_contact(time + 0.5 * h, &position, v).into_accelerations(&mut velocity)?;
    velocity.iter_mut().zip(v).for_each(|(a, v)| *a = v + h * *a);
    let Some(contacts) = contacts else {
        return Ok(Made { position, velocity, forces: Vec::new(), lost: 0.0, work: 0.0, opposed: 0.0, found: true });
    };
    let mut frames = contacts.ahead(mass.motion(), h);
    let mut supports = contacts.supports(&frames, &position, v);
    let waits = |support: &Support| {
        support.gap > 0.0 && contacts.restitution(support) > 0.0 && along(&support.columns[0], v) < -contacts.rest
    };
    // Frames are those of the first supports.
    let mut own = supports.iter();
    frames.retain(|_| own.next().is_some_and(|support| !waits(support)));
    supports.retain(|support| !waits(support));
    let blocks = Blocks::new(contacts, &mut mass, &supports);
    let way = |support: &Support| 2.0 * support.gap.max(0.0) / h;
    let free: Vec<Vector3<f64>> = supports.iter().map(|support| support.rates(&velocity)).collect();
    let bends: Vec<Vector3<f64>> =
        supports.iter().zip(&free).enumerate().map(|(i, (support, u))| bend(frames.get(i), support, u, h)).collect();
    let rate = |(i, support): (usize, &Support)| {
        let (approach, e) = (along(&support.columns[0], v) - bends[i].x, contacts.restitution(support));
        let bounce = if -approach > contacts.rest && support.gap <= 0.0 { e * approach } else { 0.0 };
        free[i] + bends[i] + Vector3::x() * (way(support) + bounce)
    };
    // Of hinges the three numbers are their own.
    let basis = |i: usize| frames.get(i).map_or_else(Matrix3::identity, |frame| frame.basis);
    let known = |support: &Support| remembered(warm, support.id).map(|force| force * h);
    let guess = |i: usize| known(&supports[i]).map_or_else(Vector3::zeros, |force| basis(i).tr_mul(&force));
    let problem = Problem {
        blocks: blocks.matrix(),
        rates: supports.iter().enumerate().map(rate).collect(),
        laws: supports.iter().map(|support| support.law.times(h)).collect(),
    };
    let guesses: Vec<Vector3<f64>> = (0..supports.len()).map(guess).collect();
    let found = problem.sweep_to(&guesses, fine / h, MOST_SWEEPS);
    blocks.push(&found.forces, &mut velocity);
    let (mut lost, mut opposed) = (0.0, 0.0);
    for ((support, force), before) in supports.iter().zip(&found.forces).zip(&free) {
        // Positions go ½ h (v + v⁺): along that impulses do their work.
        lost -= 0.5 * force.dot(&(support.rates(v) + support.rates(&velocity)));
        opposed -= 0.5 * force.dot(&(before + support.rates(&velocity)));
    }
    let work = driven(&mut mass, &supports, &found.forces);
    let mut end = position.clone();
    System::displace(&contacts.model, &mut end, &half(&velocity));
    hinges::within_limits(&mut mass, &mut end);
    let forces = supports.iter().zip(&found.forces).enumerate().filter(|(_, (_, force))| **force != Vector3::zeros());
    let forces = forces.map(|(i, (support, force))| (support.id, basis(i) * force / h)).collect();
    Ok(Made { position: end, velocity, forces, lost, work, opposed, found: found.found })
}
