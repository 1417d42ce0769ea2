//! One captured step, and its cone problem: (1) and (2) of [`super::capture`].

use super::Contacts;
use super::blocks::Blocks;
use crate::contact::cone::{Law, Problem, Swept};
use crate::contact::frame::{self, Frame, along};
use crate::contact::geometry::feature::Meeting;
use crate::contact::hinges::{self, Id, Support};
use crate::contact::pairs::Key;
use crate::dynamics::{Factorized, Fault, System};
use crate::model::Model;
use crate::simulate::problem::Equations;
use crate::simulate::stops::nonsmooth::Nonsmooth;
use nalgebra::{Matrix3, Vector3};

/// What has sunk or rises has turned by as much: features count to this part of a size beyond where they do. Edges that lie across each other would lose
/// their contact to a turn of 1e-7.
const ASKEW: f64 = 1e-4;
/// Sweeps of the cone problem of a step, at most.
pub(super) const SWEEPS_OF_STEP: usize = 1200;
/// Velocities without contact are found to this part of the largest, in so many iterations at most: what a step errs by is far more.
const FLIES: f64 = 1e-9;
const MOST_ITERATIONS: usize = 20;
/// Energy that impulses may gain, in parts of what they move, as they are found to so much only.
const BALANCED: f64 = 1e-6;
/// How exactly the part of the rebounds is found that gains no energy.
const NEARLY: f64 = 1e-6;
/// What answers a push with less than this part of what it would do without loops, drives and gears is held by them, but for rounding.
const IMMOVABLE: f64 = 1e-12;

/// A step and what it did.
#[derive(Default)]
pub(super) struct Made {
    pub(super) position: Vec<f64>,
    pub(super) velocity: Vec<f64>,
    /// What impulses accelerate with over the step (m/s², rad/s²); empty where something is struck, for that they do at once.
    pub(super) pressed: Vec<f64>,
    /// Impulses over the length of the step (N, N m).
    pub(super) forces: Vec<(Id, Vector3<f64>)>,
    /// What impulses and compliant stops take out (J).
    pub(super) lost: f64,
    /// What drives put into impulses (J).
    pub(super) work: f64,
    /// What impulses take out behind all other forces of the step, whose work on the way is not theirs (J): never negative.
    pub(super) opposed: f64,
    /// Whether its forces are found.
    pub(super) found: bool,
    /// How often less came back than restitution says, for it would have gained energy.
    pub(super) held_back: usize,
    /// Whether anything was struck, so that velocities have jumped.
    pub(super) struck: bool,
    /// How fast at its beginning what turned back against its friction in it slid (parts of the scene's speeds), for friction pushed in all of
    /// the step as it does behind the turn, or what a damper that is run into changes in it: what either errs by is no more.
    pub(super) turned: f64,
}

impl Contacts {
    /// What may bear within a step: contacts, and rigid stops and dry friction of hinges.
    fn supports(&self, frames: &[Frame], q: &[f64], v: &[f64]) -> Vec<Support> {
        let contact = |frame: &Frame| {
            let friction = self.law(frame.key.couple).friction;
            // What slides has the friction of motion to the end of the step; what rests gives way at its limit and has it from the next one on.
            let slides = frame.slip().norm() > self.kept;
            let [stick, slide] = [friction.stick, friction.slide].map(|has| Law::Coulomb { stick: has, slide: has });
            let (columns, gap) = (frame.columns.clone(), frame.meeting.gap);
            let at_rest = (slides && friction.slide < friction.stick).then_some(stick);
            Support { id: Id::Contact(frame.key), columns, gap, law: if slides { slide } else { stick }, at_rest }
        };
        let mut all: Vec<Support> = frames.iter().map(contact).collect();
        all.extend(hinges::supports(&self.model, q, v, self.kept));
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

/// Dry friction of hinges that drives move: nothing that it does changes their motion, so that (2) does not know it. It pushes against
/// that with all that it has; where drives keep a hinge still, it is not known, and none.
fn drag(
    mass: &mut Factorized<'_>,
    problem: &Problem,
    supports: &[Support],
    v: &[f64],
    forces: &mut [Vector3<f64>],
    still: f64,
) {
    let rubs = |support: &Support| matches!(support.id, Id::Friction(_));
    if !mass.system().model().is_constrained() || !supports.iter().any(rubs) {
        return;
    }
    let mut inertia = vec![0.0; v.len()];
    mass.articulated_inertia(&mut inertia);
    for (i, support) in supports.iter().enumerate().filter(|(_, support)| rubs(support)) {
        let (Law::Bounded { bound }, Some((velocity, _))) = (problem.laws[i], support.columns[0].first()) else {
            continue;
        };
        let (rate, free) = (support.rates(v), inertia[*velocity].recip());
        if problem.own(i).amax() <= IMMOVABLE * free && rate.norm() > still {
            forces[i] = -rate * (bound / rate.norm());
        }
    }
}

/// What becomes of contacts within a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ahead {
    /// What meets strikes.
    Strikes,
    /// What meets is left alone.
    Waits,
    /// All that is near touches: gaps are round-off.
    Rests,
}

/// How (2) is asked.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ask<'a> {
    /// Forces to begin with.
    pub(super) warm: &'a [(Id, Vector3<f64>)],
    /// What impulses are expected to accelerate with; empty for nothing.
    pub(super) pressed: &'a [f64],
    /// Rates of contacts are found to this over the step (m).
    pub(super) fine: f64,
    /// Sweeps at most.
    pub(super) sweeps: usize,
    pub(super) ahead: Ahead,
}

/// `v_f` of (1) by fixed-point iteration, and the velocity in the middle of the step, with what impulses are expected to do by then; whether both
/// have been found: a step in which something turns by more than a radian or so is too long.
fn fly(
    system: &mut System,
    time: f64,
    [position, v]: [&[f64]; 2],
    (h, pressed): (f64, &[f64]),
    [after, middle]: [&mut Vec<f64>; 2],
) -> Result<bool, Fault> {
    let mut a = vec![0.0; v.len()];
    let by_impulses = |i: usize| 0.5 * h * pressed.get(i).copied().unwrap_or(0.0);
    middle.clear();
    middle.extend_from_slice(v);
    let mut last = f64::INFINITY;
    for _ in 0..MOST_ITERATIONS {
        system.at_without_contact(time, position, middle).into_accelerations(&mut a)?;
        after.clear();
        after.extend(v.iter().zip(&a).map(|(v, a)| v + h * a));
        let size = after.iter().chain(v).fold(0.0, |most: f64, v| most.max(v.abs()));
        let mut change = 0.0_f64;
        for (i, (middle, (v, after))) in middle.iter_mut().zip(v.iter().zip(&*after)).enumerate() {
            let next = 0.5 * (v + after) + by_impulses(i);
            change = change.max((next - *middle).abs());
            *middle = next;
        }
        if change <= FLIES * size {
            return Ok(true);
        }
        if !(change < last) {
            return Ok(false);
        }
        last = change;
    }
    Ok(false)
}

/// (2) with as much of these rebounds (m/s) as gains no energy: by Kane's paradox, or where several bounce that give back different parts,
/// all of them may. `free` are the rates without impulses. The answer, and whether something is held back.
fn bounced(
    problem: &mut Problem,
    rebounds: &[f64],
    free: &[Vector3<f64>],
    solve: impl Fn(&Problem) -> Swept,
) -> (Swept, bool) {
    if rebounds.iter().all(|rebound| *rebound == 0.0) {
        return (solve(problem), false);
    }
    let still = problem.rates.clone();
    let mut with = |share: f64| {
        let rates = still.iter().zip(rebounds).map(|(rate, rebound)| rate + Vector3::x() * (share * rebound));
        problem.rates = rates.collect();
        let found = solve(problem);
        // What contacts do to the rates is that of (2) less what their rates begin with.
        let change = |k: usize| problem.rate(k, &found.forces) - problem.rates[k];
        let each = |k: usize| found.forces[k].dot(&(free[k] + 0.5 * change(k)));
        let sizes = |k: usize| found.forces[k].norm() * (free[k].norm() + change(k).norm());
        let [gained, size] = [(0..free.len()).map(each).sum::<f64>(), (0..free.len()).map(sizes).sum()];
        (found, gained > BALANCED * size)
    };
    let (whole, gains) = with(1.0);
    if !gains {
        return (whole, false);
    }
    let (mut least, gains) = with(0.0);
    if gains {
        return (whole, false);
    }
    let (mut low, mut high) = (0.0, 1.0);
    while high - low > NEARLY {
        let share = 0.5 * (low + high);
        match with(share) {
            (found, false) => (low, least) = (share, found),
            (_, true) => high = share,
        }
    }
    (least, true)
}

/// Gives what slides and has more friction at rest that at its turn (`rests`), or takes it away again; whether there is any.
fn turn(problem: &mut Problem, supports: &[Support], h: f64, wanted: impl Fn(&Support) -> bool, rests: bool) -> bool {
    let mut any = false;
    for (support, law) in supports.iter().zip(&mut problem.laws) {
        let Some(at_rest) = support.at_rest.filter(|_| wanted(support)) else { continue };
        let next = if rests { at_rest } else { support.law }.times(h);
        any |= *law != next;
        *law = next;
    }
    any
}

/// What dampers of compliant stops that are run into in a step accelerate their coordinates with at once (parts of the scene's speeds, per second):
/// they push in all of the step or in none of it.
fn run_into(mass: &mut Factorized<'_>, nonsmooth: &Nonsmooth, from: [&[f64]; 2], to: [&[f64]; 2]) -> f64 {
    let jumps = nonsmooth.run_into(from, to);
    if jumps.is_empty() {
        return 0.0;
    }
    let mut inertia = vec![0.0; from[1].len()];
    mass.articulated_inertia(&mut inertia);
    let model = mass.system().model();
    let each = |(velocity, force): &(usize, f64)| force / inertia[*velocity] / hinges::speed(model, *velocity);
    jumps.iter().map(each).fold(0.0, f64::max)
}

/// How fast what turns back in a step slides at its beginning (parts of the scene's speeds).
fn turned(model: &Model, supports: &[Support], [v, after]: [&[f64]; 2]) -> f64 {
    let turns = |support: &&Support| support.slid(v).dot(&support.slid(after)) < 0.0;
    supports.iter().filter(turns).map(|support| support.slid(v).norm() / support.speed(model)).fold(0.0, f64::max)
}

/// (2) with the friction of what turns: that at rest, if it holds. From the velocity without impulses to that with them; whether rebounds
/// are held back. What slides faster than `kept` behind the step has not been held.
fn pushed(
    problem: &mut Problem,
    supports: &[Support],
    blocks: &Blocks,
    (v, velocity): (&[f64], &mut Vec<f64>),
    (h, kept): (f64, f64),
    solve: impl Fn(&mut Problem) -> (Swept, bool),
) -> (Swept, bool) {
    let flown = velocity.clone();
    let mut answer = solve(problem);
    blocks.push(&answer.0.forces, velocity);
    let comes_to_rest = |support: &Support| support.slid(v).dot(&support.slid(velocity)) <= 0.0;
    if turn(problem, supports, h, comes_to_rest, true) {
        answer = solve(problem);
        velocity.clone_from(&flown);
        blocks.push(&answer.0.forces, velocity);
        // What its friction at rest does not hold slides back.
        if turn(problem, supports, h, |support| support.slid(velocity).norm() > kept, false) {
            answer = solve(problem);
            *velocity = flown;
            blocks.push(&answer.0.forces, velocity);
        }
    }
    answer
}

/// What impulses take out along the way of a step, and behind all other forces in it, which leave the rates `free` (J).
fn taken_out(
    supports: &[Support],
    forces: &[Vector3<f64>],
    free: &[Vector3<f64>],
    [v, after]: [&[f64]; 2],
) -> [f64; 2] {
    let each = supports.iter().zip(forces).zip(free).map(|((support, force), before)| {
        let at_end = support.rates(after);
        // Positions go ½ h (v + v⁺): along that impulses do their work.
        [-0.5 * force.dot(&(support.rates(v) + at_end)), -0.5 * force.dot(&(before + at_end))]
    });
    each.fold([0.0; 2], |sum, one| [sum[0] + one[0], sum[1] + one[1]])
}

/// (1) and (2).
pub(super) fn moreau(
    motion: &mut Equations,
    time: f64,
    [q, v]: [&[f64]; 2],
    h: f64,
    Ask { warm, pressed, fine, sweeps, ahead }: Ask<'_>,
) -> Result<Made, Fault> {
    let mut position = q.to_vec();
    let half = |v: &[f64]| -> Vec<f64> { v.iter().map(|v| 0.5 * h * v).collect() };
    System::displace(motion.model(), &mut position, &half(v));
    let mut velocity = vec![0.0; v.len()];
    motion.press_stops(&position, v);
    let Equations { contacts, system, nonsmooth, .. } = motion;
    let mut middle = Vec::with_capacity(v.len());
    let flies = fly(system, time + 0.5 * h, [&position, v], (h, pressed), [&mut velocity, &mut middle])?;
    let damped = |nonsmooth: &Nonsmooth| h * nonsmooth.dissipated(system.phase(), &position, &middle);
    let by_stops = nonsmooth.as_ref().map_or(0.0, damped);
    let mut mass =
        system.at_without_contact(time + 0.5 * h, &position, v).into_accelerations(&mut vec![0.0; v.len()])?;
    let Some(contacts) = contacts else {
        return Ok(Made { position, velocity, found: flies, ..Made::default() });
    };
    let mut frames = contacts.ahead(mass.motion(), h);
    let mut supports = contacts.supports(&frames, &position, v);
    let waits = |support: &Support| {
        let bounces = support.gap > 0.0 && contacts.restitution(support) > 0.0;
        let is_friction = matches!(support.id, Id::Friction(_));
        (bounces || ahead != Ahead::Strikes && !is_friction) && along(&support.columns[0], v) < -contacts.rest
    };
    // Frames are those of the first supports.
    let mut own = supports.iter();
    frames.retain(|_| own.next().is_some_and(|support| !waits(support)));
    supports.retain(|support| !waits(support));
    let blocks = Blocks::new(contacts, &mut mass, &supports);
    let way = |support: &Support| if ahead == Ahead::Rests { 0.0 } else { 2.0 * support.gap.max(0.0) / h };
    let free: Vec<Vector3<f64>> = supports.iter().map(|support| support.rates(&velocity)).collect();
    let bends: Vec<Vector3<f64>> =
        supports.iter().zip(&free).enumerate().map(|(i, (support, u))| bend(frames.get(i), support, u, h)).collect();
    let rate = |(i, support): (usize, &Support)| free[i] + bends[i] + Vector3::x() * way(support);
    let rebound = |(i, support): (usize, &Support)| {
        let (approach, e) = (along(&support.columns[0], v) - bends[i].x, contacts.restitution(support));
        if -approach > contacts.rest && support.gap <= 0.0 { e * approach } else { 0.0 }
    };
    let rebounds: Vec<f64> = supports.iter().enumerate().map(rebound).collect();
    // Of hinges the three numbers are their own.
    let basis = |i: usize| frames.get(i).map_or_else(Matrix3::identity, |frame| frame.basis);
    let known = |support: &Support| remembered(warm, support.id).map(|force| force * h);
    let guess = |i: usize| known(&supports[i]).map_or_else(Vector3::zeros, |force| basis(i).tr_mul(&force));
    let mut problem = Problem {
        blocks: blocks.matrix(),
        rates: supports.iter().enumerate().map(rate).collect(),
        laws: supports.iter().map(|support| support.law.times(h)).collect(),
    };
    let guesses: Vec<Vector3<f64>> = (0..supports.len()).map(guess).collect();
    let solve = |problem: &mut Problem| {
        bounced(problem, &rebounds, &free, |problem| problem.sweep_to(&guesses, fine / h, sweeps))
    };
    let flown = velocity.clone();
    let (mut found, held_back) =
        pushed(&mut problem, &supports, &blocks, (v, &mut velocity), (h, contacts.kept), solve);
    drag(&mut mass, &problem, &supports, &velocity, &mut found.forces, contacts.slow);
    let struck = supports.iter().zip(&found.forces).any(|(support, force)| {
        !matches!(support.id, Id::Friction(_)) && force.x > 0.0 && along(&support.columns[0], v) < -contacts.rest
    });
    let [by_impulses, opposed] = taken_out(&supports, &found.forces, &free, [v, &velocity]);
    let work = driven(&mut mass, &supports, &found.forces);
    let mut end = position.clone();
    System::displace(&contacts.model, &mut end, &half(&velocity));
    hinges::within_limits(&mut mass, &mut end);
    let stops = nonsmooth.as_ref().map_or(0.0, |stops| run_into(&mut mass, stops, [q, v], [&end, &velocity]));
    let turned = turned(&contacts.model, &supports, [v, &velocity]).max(h * stops);
    let forces = supports.iter().zip(&found.forces).enumerate().filter(|(_, (_, force))| **force != Vector3::zeros());
    let forces = forces.map(|(i, (support, force))| (support.id, basis(i) * force / h)).collect();
    let accelerated = |(after, before): (&f64, &f64)| (after - before) / h;
    let pressed = if struck { Vec::new() } else { velocity.iter().zip(&flown).map(accelerated).collect() };
    Ok(Made {
        position: end,
        velocity,
        pressed,
        forces,
        lost: by_stops + by_impulses,
        work,
        opposed,
        found: found.found && flies,
        held_back: usize::from(held_back),
        struck,
        turned,
    })
}
