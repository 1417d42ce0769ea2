//! Many contacts, or too many events: steps that capture all of an instant's events at once.
//!
//! ```text
//! (1)  q_m = q ⊞ ½ h v,   v⁺ = v + h q̈_free(q_m, v) + M⁻¹ Jᵀ λ,   q⁺ = q_m ⊞ ½ h v⁺
//! (2)  K* ∋ w + μ |w_t| n  ⊥  λ ∈ K(μ),   w = J v⁺ + n (2 max(g_m, 0) / h + 0.2 min(g_m, 0) / h_max + e min(u_n, 0))
//! ```
//!
//! (Moreau 1988, Jean 1999: Moreau–Jean's method with the cone problem of [`super::cone`].) All pairs that might meet within the step
//! are in (2), with the way that is left to them: nothing sinks but by the rounding of the forces, of which a part is taken back with
//! every step, and steps may be halved. The method has order 1; a step and its two
//! halves are compared in positions, as velocities jump at blows, and the halves are kept.
//!
//! `M⁻¹` is made of the blocks of the trees on the ground, all of them in as many solutions as the largest has coordinates.

use super::cone::{Law, Problem};
use super::frame::{self, Column, Frame};
use super::pairs::{Key, restitution};
use super::watch::DEEPER;
use super::{Contacts, LOOSE};
use crate::dynamics::{Fault, System};
use crate::integrate::{Failure, Limit, Problem as _, Progress, Start, StepError, Stepper};
use crate::simulate::problem::Motion;
use crate::spatial::Wrench;
use nalgebra::{DMatrix, Matrix3, Vector3};

/// Steps are at most this part of the scene's time, and at least that.
const LONGEST: f64 = 0.02;
const SHORTEST: f64 = 1e-5;
/// Positions of a step and of its halves differ by no more than this part of the scene's length, if a run asks for more.
const COARSE: f64 = 1e-4;
/// Forces are found to this part of the largest, or as far as so many sweeps take them.
const FOUND: f64 = 1e-9;
const MOST_SWEEPS: usize = 400;
/// Steps with the same contacts in the same states after which events take over again.
const CALM: usize = 10;
/// What has sunk by rounding of the forces rises by this part of it in a step, in the longest one at most.
const RISES: f64 = 0.2;
/// A step gains no more than this part of the kinetic energy.
const GAINED: f64 = 0.01;
/// Nor of the scene's weight over its length.
const ROUNDING: f64 = 1e-9;
/// What has sunk by more than this part of a shape's size is lost.
pub(super) const LOST: f64 = 1e-2;
/// Trees with more coordinates than this are answered row by row.
const LARGE: usize = 30;

/// What carries over from step to step.
#[derive(Debug, Default)]
pub(super) struct Memory {
    /// Impulses of the last step over its length (N).
    forces: Vec<(Key, Vector3<f64>)>,
    /// Contacts that pushed in the last step.
    active: Vec<Key>,
    calm: usize,
    /// Steps in which nothing moved.
    still: usize,
    /// Energy that contacts took out since it was last asked for (J).
    lost: f64,
    pub(super) steps: usize,
    /// The step that is tried next (s).
    step: f64,
}

/// A step and what it did.
struct Made {
    position: Vec<f64>,
    velocity: Vec<f64>,
    forces: Vec<(Key, Vector3<f64>)>,
    lost: f64,
}

/// The stepper of (1).
pub(in crate::simulate) struct Capture {
    progress: Progress,
    /// Positions may differ by this, in parts of their scales.
    tolerance: f64,
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
        Ok(Self { progress, tolerance: tolerance.max(COARSE), before, next: Vec::new() })
    }
}

impl Stepper<Motion> for Capture {
    fn step(&mut self, motion: &mut Motion) -> Result<(), StepError> {
        let (time, left) = (self.progress.time(), self.progress.end() - self.progress.time());
        if left <= 0.0 {
            return Ok(());
        }
        let span = motion.model().time_scale();
        let (q, v) = (self.progress.position().to_vec(), self.progress.velocity().to_vec());
        let Some(contacts) = &motion.contacts else { return Ok(()) };
        let mut h = if contacts.memory.step > 0.0 { contacts.memory.step } else { 0.1 * LONGEST * span };
        loop {
            h = h.min(LONGEST * span).max(SHORTEST * span);
            let last = h >= left * (1.0 - 1e-12);
            let step = if last { left } else { h };
            let fail = |fault: Fault| StepError::Underflow { time, step, limit: Limit::Failure(fault.into()) };
            let warm = motion.contacts.as_ref().map_or_else(Vec::new, |contacts| contacts.memory.forces.clone());
            let whole = moreau(motion, time, [&q, &v], step, &warm).map_err(fail)?;
            let first = moreau(motion, time, [&q, &v], 0.5 * step, &warm).map_err(fail)?;
            let from = [first.position.as_slice(), first.velocity.as_slice()];
            let second = moreau(motion, time + 0.5 * step, from, 0.5 * step, &first.forces).map_err(fail)?;
            let (scales, _) = motion.scales();
            let off =
                whole.position.iter().zip(&second.position).zip(scales).map(|((a, b), scale)| (a - b).abs() / scale);
            let error = off.fold(0.0, f64::max) / self.tolerance;
            let proposed = h * (0.8 * error.max(1e-9).powf(-0.5)).clamp(0.2, 3.0);
            if !(error <= 1.0) && step > SHORTEST * span {
                self.progress.reject();
                h = proposed.min(0.5 * step);
                continue;
            }
            // Contacts take energy out; what has sunk may rise by a little.
            let after = motion.system.at(time + step, &second.position, &second.velocity).energies().kinetic;
            let gained = -(first.lost + second.lost);
            let rounding = motion
                .contacts
                .as_ref()
                .map_or(0.0, |contacts| ROUNDING * contacts.scale * contacts.model.length_scale());
            if !(gained <= GAINED * after + rounding) {
                if step <= SHORTEST * span {
                    let message = format!("captured contacts would gain {gained:.3e} J in it");
                    return Err(StepError::Underflow { time, step, limit: Limit::Failure(Failure { message }) });
                }
                self.progress.reject();
                h = 0.5 * step;
                continue;
            }
            self.before = (q, v);
            self.next = [second.position.as_slice(), second.velocity.as_slice()].concat();
            let Some(contacts) = &mut motion.contacts else { return Ok(()) };
            let memory = &mut contacts.memory;
            memory.lost += first.lost + second.lost;
            memory.steps += 1;
            memory.step = if last { memory.step.max(proposed.min(h)) } else { proposed };
            let active: Vec<Key> = second.forces.iter().map(|(key, _)| *key).collect();
            memory.calm = if active == memory.active { memory.calm + 1 } else { 0 };
            memory.active = active;
            memory.forces = second.forces;
            let slow = contacts.slow * 1e2 / contacts.model.length_scale();
            let still = motion.scales().1.iter().zip(&second.velocity).all(|(scale, v)| v.abs() <= slow * span * scale);
            if let Some(contacts) = &mut motion.contacts {
                contacts.memory.still = if still { contacts.memory.still + 1 } else { 0 };
            }
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
    /// `a ← q̈(t, q, v)` without contact, with the factorization that belongs to it.
    ///
    /// # Errors
    /// As [`Evaluated::accelerations`].
    fn free(&mut self, time: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<(), Fault> {
        if let Some(nonsmooth) = &self.nonsmooth {
            nonsmooth.press(q, v, self.system.outside());
        }
        self.system.pressed().fill(Wrench::ZERO);
        self.system.at(time, q, v).accelerations(a).map(|_| ())
    }
}

impl Contacts {
    /// Lets captured steps take over.
    pub(in crate::simulate) fn capture(&mut self) {
        let (steps, step) = (self.memory.steps, self.memory.step);
        self.memory = Memory { steps, step, ..Memory::default() };
        self.capturing = true;
        self.closed.clear();
        self.frames.clear();
        self.resting = false;
    }

    /// The couple that has sunk deepest in the last place, and how far, in parts of its size.
    pub(in crate::simulate) fn deepest(&self) -> Option<([String; 2], f64)> {
        let each = (0..self.pairs.couples.len()).filter(|couple| self.pairs.apart(*couple) <= 0.0);
        let depth = |couple: usize| (couple, self.pairs.depth(couple) / self.pairs.couples[couple].size);
        let (couple, depth) = each.map(depth).max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some((self.between(couple), depth))
    }

    /// The same if it is lost; places shapes at the place of the system.
    pub(in crate::simulate) fn sunk(&mut self, system: &System) -> Option<([String; 2], f64)> {
        self.pairs.place_at(system.links());
        self.deepest().filter(|(_, depth)| *depth > LOST)
    }

    /// Lets events go on: what captured steps have brought together is closed.
    pub(in crate::simulate) fn end_capture(&mut self) {
        self.capturing = false;
        self.closing = COARSE;
    }

    /// Energy that captured contacts took out since this was last asked (J).
    pub(in crate::simulate) fn taken(&mut self) -> f64 {
        std::mem::take(&mut self.memory.lost)
    }

    /// Whether events may take over again.
    pub(in crate::simulate) fn is_calm(&self, time: f64) -> bool {
        let few = 3 * self.memory.active.len() <= super::MOST_ROWS && self.pairs.couples.len() <= super::MOST_COUPLES;
        self.capturing && few && self.memory.calm >= CALM && time >= self.until
    }

    /// Whether nothing has moved for some captured steps.
    pub(in crate::simulate) fn is_still(&self) -> bool {
        self.capturing && self.memory.still >= 3
    }

    /// Adds what the forces of the last captured step do to accelerations, and hands them to the system.
    pub(super) fn carry(&mut self, system: &mut System, q: &[f64], v: &[f64], a: &mut [f64]) {
        let motion = system.at(system.time(), q, v);
        frame::carried(motion.motion(), &self.model, &mut self.carried);
        self.pairs.place(motion.motion());
        let mut push = vec![0.0; v.len()];
        let mut wrenches = Vec::new();
        for (key, force) in &self.memory.forces {
            let Some(meeting) = self.pairs.meeting(key) else { continue };
            let frame = Frame::new(&self.model, motion.motion(), &self.pairs, &self.carried, *key, meeting, None);
            frame.push(&frame.basis.tr_mul(force), &mut push);
            wrenches.push((frame.links, meeting.point, *force));
        }
        let mut change = vec![0.0; v.len()];
        frame::respond(system, q, v, &push, &mut change);
        a.iter_mut().zip(&change).for_each(|(a, change)| *a += change);
        if self.resting {
            a.fill(0.0);
        }
        wrenches.into_iter().for_each(|(links, point, force)| super::rows::press(system, links, &point, &force));
    }

    /// Frames of all pairs whose gap is at most what velocities make up in a step.
    fn ahead(&mut self, motion: &crate::motion::Motion, h: f64) -> Vec<Frame> {
        frame::carried(motion, &self.model, &mut self.carried);
        self.pairs.place(motion);
        let fall = h * self.model.gravity.norm();
        let mut found: Vec<(Key, crate::contact::geometry::feature::Meeting)> = Vec::new();
        for couple in 0..self.pairs.couples.len() {
            let reach = h * (self.pairs.fastest(couple, motion) + fall);
            if self.pairs.apart(couple) > reach {
                continue;
            }
            let (first, size) = (found.len(), self.pairs.couples[couple].size);
            let overlap = std::cell::OnceCell::new();
            self.pairs.meetings(couple, LOOSE * size, reach, |meeting| {
                let depth = || *overlap.get_or_init(|| self.pairs.depth(couple));
                let counts = meeting.gap > -1e-6 * size || meeting.gap >= -DEEPER * depth();
                let double = |(_, other): &(Key, crate::contact::geometry::feature::Meeting)| {
                    (other.point - meeting.point).norm() < 1e-4 * size && other.normal.dot(&meeting.normal) > 0.99
                };
                if counts && !found[first..].iter().any(double) {
                    found.push((Key { couple, features: meeting.features }, meeting));
                }
            });
        }
        let frame = |(key, meeting)| Frame::new(&self.model, motion, &self.pairs, &self.carried, key, meeting, None);
        found.into_iter().map(frame).collect()
    }
}

/// (1) and (2).
fn moreau(
    motion: &mut Motion,
    time: f64,
    [q, v]: [&[f64]; 2],
    h: f64,
    warm: &[(Key, Vector3<f64>)],
) -> Result<Made, Fault> {
    let mut position = q.to_vec();
    let half = |v: &[f64]| -> Vec<f64> { v.iter().map(|v| 0.5 * h * v).collect() };
    System::displace(motion.model(), &mut position, &half(v));
    let mut velocity = vec![0.0; v.len()];
    motion.free(time + 0.5 * h, &position, v, &mut velocity)?;
    velocity.iter_mut().zip(v).for_each(|(a, v)| *a = v + h * *a);
    let Motion { contacts: Some(contacts), system, .. } = motion else {
        return Ok(Made { position, velocity, forces: Vec::new(), lost: 0.0 });
    };
    let frames = contacts.ahead(system.at(time + 0.5 * h, &position, v).motion(), h);
    let blocks = Blocks::new(contacts, system, &position, v, &frames);
    let laws = frames.iter().map(|frame| {
        let friction = contacts.law(frame.key.couple).friction;
        Law::Coulomb { stick: friction.stick, slide: friction.slide }
    });
    let rate = |frame: &Frame| {
        let e = restitution(contacts.law(frame.key.couple).law);
        let gap = frame.meeting.gap;
        let bounce = if -frame.speed.x > contacts.rest && gap <= 0.0 { e * frame.speed.x } else { 0.0 };
        let way = if gap > 0.0 { 2.0 * gap / h } else { RISES * gap / h.max(LONGEST * contacts.model.time_scale()) };
        frame.rates(&velocity) + Vector3::x() * (way + bounce)
    };
    let problem = Problem { blocks: blocks.matrix(), rates: frames.iter().map(rate).collect(), laws: laws.collect() };
    let known = |frame: &Frame| warm.iter().find(|(key, _)| *key == frame.key).map(|(_, force)| force * h);
    let guess = |frame: &Frame| known(frame).map_or_else(Vector3::zeros, |force| frame.basis.tr_mul(&force));
    let guess: Vec<Vector3<f64>> = frames.iter().map(guess).collect();
    let found = problem.solve(&guess, FOUND, MOST_SWEEPS);
    let before: Vec<Vector3<f64>> = frames.iter().map(|frame| frame.rates(&velocity)).collect();
    blocks.push(&found.forces, &mut velocity);
    let mut lost = 0.0;
    for ((frame, force), before) in frames.iter().zip(&found.forces).zip(&before) {
        lost -= 0.5 * force.dot(&(before + frame.rates(&velocity)));
    }
    System::displace(&contacts.model, &mut position, &half(&velocity));
    let forces = frames.iter().zip(&found.forces).filter(|(_, force)| **force != Vector3::zeros());
    let forces = forces.map(|(frame, force)| (frame.key, frame.basis * force / h)).collect();
    Ok(Made { position, velocity, forces, lost })
}

/// The part of `J` and of `M⁻¹ Jᵀ` of a contact in one tree.
struct Part {
    tree: usize,
    rows: DMatrix<f64>,
    answers: DMatrix<f64>,
}

/// `J` and `M⁻¹ Jᵀ`, by contacts and trees.
struct Blocks {
    /// Velocity coordinates of every tree.
    trees: Vec<Vec<usize>>,
    parts: Vec<Vec<Part>>,
    /// Contacts of every tree.
    contacts: Vec<Vec<usize>>,
}

impl Blocks {
    fn new(contacts: &Contacts, system: &mut System, q: &[f64], v: &[f64], frames: &[Frame]) -> Self {
        let trees = contacts.trees.clone();
        let mut of = vec![(0, 0); v.len()];
        trees.iter().enumerate().for_each(|(tree, own)| own.iter().enumerate().for_each(|(k, i)| of[*i] = (tree, k)));
        let mut parts: Vec<Vec<Part>> = frames.iter().map(|frame| split(&frame.columns, &of, &trees)).collect();
        let largest = parts.iter().flatten().map(|part| part.rows.ncols()).max().unwrap_or(0);
        if largest <= LARGE {
            let inverse = inverses(system, q, v, &trees, largest);
            for part in parts.iter_mut().flatten() {
                part.answers = &inverse[part.tree] * part.rows.transpose();
            }
        } else {
            let full = frame::responses(system, q, v, frames);
            for (parts, full) in parts.iter_mut().zip(&full) {
                for part in parts {
                    let own = &trees[part.tree];
                    part.answers = DMatrix::from_fn(own.len(), 3, |i, j| full[j][own[i]]);
                }
            }
        }
        let mut touching = vec![Vec::new(); trees.len()];
        parts.iter().enumerate().for_each(|(i, own)| own.iter().for_each(|part| touching[part.tree].push(i)));
        Self { trees, parts, contacts: touching }
    }

    fn matrix(&self) -> Vec<Vec<(usize, Matrix3<f64>)>> {
        let mut all: Vec<Vec<(usize, Matrix3<f64>)>> = vec![Vec::new(); self.parts.len()];
        for (i, parts) in self.parts.iter().enumerate() {
            for part in parts {
                for j in &self.contacts[part.tree] {
                    let Some(other) = self.parts[*j].iter().find(|other| other.tree == part.tree) else { continue };
                    let product = &part.rows * &other.answers;
                    let block = Matrix3::from_fn(|r, c| product[(r, c)]);
                    match all[i].iter_mut().find(|(k, _)| k == j) {
                        Some((_, sum)) => *sum += block,
                        None => all[i].push((*j, block)),
                    }
                }
            }
        }
        all
    }

    /// Adds `M⁻¹ Jᵀ λ`.
    fn push(&self, forces: &[Vector3<f64>], v: &mut [f64]) {
        for (parts, force) in self.parts.iter().zip(forces) {
            for part in parts {
                for (k, i) in self.trees[part.tree].iter().enumerate() {
                    v[*i] += (0..3).map(|j| part.answers[(k, j)] * force[j]).sum::<f64>();
                }
            }
        }
    }
}

fn split(columns: &[Column; 3], of: &[(usize, usize)], trees: &[Vec<usize>]) -> Vec<Part> {
    let mut parts: Vec<Part> = Vec::new();
    for (row, column) in columns.iter().enumerate() {
        for (i, value) in column {
            let (tree, k) = of[*i];
            let at = parts.iter().position(|part| part.tree == tree).unwrap_or_else(|| {
                let rows = DMatrix::zeros(3, trees[tree].len());
                parts.push(Part { tree, rows, answers: DMatrix::zeros(0, 0) });
                parts.len() - 1
            });
            parts[at].rows[(row, k)] = *value;
        }
    }
    parts
}

/// `M⁻¹` of every tree: unit forces on one coordinate of all of them at once.
fn inverses(system: &mut System, q: &[f64], v: &[f64], trees: &[Vec<usize>], largest: usize) -> Vec<DMatrix<f64>> {
    let mut all: Vec<DMatrix<f64>> = trees.iter().map(|own| DMatrix::zeros(own.len(), own.len())).collect();
    let (mut impulse, mut change) = (vec![0.0; v.len()], vec![0.0; v.len()]);
    for k in 0..largest {
        impulse.fill(0.0);
        trees.iter().filter_map(|own| own.get(k)).for_each(|i| impulse[*i] = 1.0);
        frame::respond(system, q, v, &impulse, &mut change);
        for (own, inverse) in trees.iter().zip(&mut all).filter(|(own, _)| own.len() > k) {
            own.iter().enumerate().for_each(|(row, i)| inverse[(row, k)] = change[*i]);
        }
    }
    all
}

/// Velocity coordinates of the trees that stand on the ground; all in one if loops, drives or gears tie them.
pub(super) fn trees(model: &crate::model::Model) -> Vec<Vec<usize>> {
    let mut of = vec![0; model.links.len()];
    let mut trees: Vec<Vec<usize>> = Vec::new();
    for (index, link) in model.links.iter().enumerate().skip(1) {
        let begins = link.parent == 0 && (trees.is_empty() || !model.is_constrained());
        if begins {
            trees.push(Vec::new());
        }
        of[index] = if begins || link.parent == 0 { trees.len() - 1 } else { of[link.parent] };
        let tree = of[index];
        trees[tree].extend(link.velocity..link.velocity + link.joint.counts().1);
    }
    trees
}
