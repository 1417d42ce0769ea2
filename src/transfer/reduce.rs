//! The reduction: a factorization of the tree, and solutions with it.

mod ball;
mod carried;
mod part;
mod refine;
mod way;

pub(super) use refine::SOFT;
pub use way::parts;

use super::flexible::{ModalPivot, RodPivot};
use super::plan::{Place, plan};
use super::{LinkAcceleration, along};
use crate::model::{Halves, Joint, Link, Model};
use crate::motion::{LinkMotion, Motion, at_once};
use crate::pages::Pages;
use crate::round_off::PIVOT;
use crate::spatial::Wrench;
use ball::Ball;
use carried::Carried;
use nalgebra::Vector3;
use part::{First, Outward, Part, Scene};
use refine::Refinement;
use std::ops::Range;

/// A pivot below this part of the moment of inertia (or mass) that the hinge could see is round-off: four units in the
/// last place of the sums it is the difference of.
pub(super) const SINGULAR: f64 = PIVOT.of(1.0);

/// The pivot of a turn or screw below this part of it, and its square below this part of the square of `S H`, lost a digit or more.
/// Where such pivots follow each other hardly any may be left: accelerations with one are looked at, and refined where
/// that is so.
pub(super) const LOST: f64 = 1.0 / 16.0;

/// A pivot of a ball below this part of it has lost digits: its three axes are eliminated at once, and a dozen units in the last place over this are 10⁻¹⁰.
pub(super) const LOST_BY_BALL: f64 = 1e-5;

/// The factorized tree: hinge pivots at one position.
#[derive(Debug, Clone)]
pub struct Reduction {
    /// How the links hang together.
    plan: Pages<Place>,
    /// The factors of every eliminated hinge; those of a ball are in `balls`.
    hinges: Pages<One>,
    balls: Vec<Ball>,
    rods: Vec<RodPivot>,
    modals: Vec<ModalPivot>,
    /// What arrives at links with several children from all but the first; nothing between two sweeps.
    joins: Vec<Carried>,
    /// Where the halves of a large tree begin, and what follows them.
    firsts: [First; 3],
    /// Scratch of [`Reduction::solve`].
    e: Pages<Wrench>,
    /// Accelerations of the root markers in the last solution.
    a: Pages<LinkAcceleration>,
    /// What is needed where digits were lost.
    refinement: Refinement,
}

/// Digits lost in an elimination.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
enum Lost {
    /// Nothing.
    #[default]
    None,
    /// Some may be lost: the accelerations tell.
    Perhaps,
    /// A pivot has lost five or more.
    Many,
}

/// A hinge of one coordinate, eliminated: `S H`, `D⁻¹` and the `u` of the last solution.
#[derive(Debug, Clone, Copy, Default)]
struct One {
    SH: Wrench,
    inverse: f64,
    u: f64,
}

impl One {
    /// Whether a pivot below `least` has lost many digits.
    #[inline(always)]
    fn lost(&self, least: f64) -> Lost {
        if self.inverse * least > 1.0 { Lost::Many } else { Lost::None }
    }
}

/// A hinge whose acceleration is not determined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Singular {
    /// The link.
    pub link: usize,
    /// The pivot `D` (kg or kg m²).
    pub pivot: f64,
}

/// A right side of the transfer equations.
#[derive(Debug, Clone, Copy)]
pub struct Load<'a> {
    /// Wrenches that act on the links at their root markers; empty for none.
    pub applied: &'a [Wrench],
    /// `τ`, one per velocity.
    pub tau: &'a [f64],
}

impl Reduction {
    /// Room for a model's links.
    pub fn new(model: &Model) -> Self {
        let n = model.links.len();
        let (plan, joins, balls) = plan(model);
        let first = |link: usize| First {
            link,
            join: plan[..link].iter().filter(|place| place.join.is_some()).count(),
            ball: plan[link..].first().map_or(balls, |place| place.ball as usize),
        };
        let firsts = match &model.halves {
            Some(Halves { links: [one, other], .. }) => [one.start, other.start, other.end].map(first),
            None => [First::default(); 3],
        };
        let may_lose = |place: &Place| place.is_delicate && !place.is_slender || place.least > 0.0;
        let refinement = match balls > 0 || plan.iter().any(may_lose) {
            true => Refinement::new(model),
            false => Refinement::default(),
        };
        Self {
            firsts,
            plan,
            hinges: Pages::filled(One::default(), n),
            balls: vec![Ball::default(); balls],
            rods: model.rods.iter().map(RodPivot::new).collect(),
            modals: model.modals.iter().map(|modal| ModalPivot::new(&modal.modal)).collect(),
            joins: vec![Carried::default(); joins],
            e: Pages::filled(Wrench::ZERO, n),
            a: Pages::filled(LinkAcceleration::default(), n),
            refinement,
        }
    }

    /// Factorizes and solves for the accelerations of the hinges: eqs. (5) to (8) with weight and velocity terms.
    ///
    /// # Errors
    /// A hinge that nothing with inertia resists, or whose inertia is round-off of what it carries; a number that is not finite.
    #[inline(always)]
    pub fn accelerations(
        &mut self,
        model: &Model,
        motion: &Motion,
        load: &Load<'_>,
        hinge: &mut [f64],
    ) -> Result<(), Singular> {
        let lost = self.factorize(model, motion, load)?;
        self.outward::<true>(model, motion, hinge);
        if lost != Lost::None {
            self.refine(model, motion, load, hinge, lost)?;
        }
        Ok(())
    }

    /// Eqs. (6) to (8) with the last factorization for a load alone: no weight, no velocity terms, `q̈ = M⁻¹ (…)`.
    pub fn solve(&mut self, model: &Model, motion: &Motion, load: &Load<'_>, hinge: &mut [f64]) {
        self.inward(model, motion, load);
        self.outward::<false>(model, motion, hinge);
    }

    /// Tips → root: eqs. (5) to (7). Says what happened to digits.
    #[inline(always)]
    fn factorize(&mut self, model: &Model, motion: &Motion, load: &Load<'_>) -> Result<Lost, Singular> {
        let lost = self.eliminate(model, motion, load);
        if lost.is_err() {
            self.joins.fill(Carried::default());
            self.modals.iter_mut().for_each(ModalPivot::forget);
        }
        lost
    }

    #[inline(always)]
    fn eliminate(&mut self, model: &Model, motion: &Motion, load: &Load<'_>) -> Result<Lost, Singular> {
        let Self { plan, hinges, balls, rods, modals, joins, firsts, .. } = self;
        let scene = Scene { model, motion, plan };
        let mut all = Part { first: First::default(), hinges, balls, rods, modals, joins };
        let Some(Halves { hub, links: [one, other], .. }) = &model.halves else {
            return all.inward(&scene, load, 1..model.links.len(), Carried::default()).map(|passed| passed.lost);
        };
        let after = all.inward(&scene, load, other.end..model.links.len(), Carried::default())?;
        let (mut low, rest) = all.split(firsts[0]);
        let (mut first, rest) = rest.split(firsts[1]);
        let (mut second, _) = rest.split(firsts[2]);
        let (first, second) = at_once(
            || first.inward(&scene, load, one.clone(), Carried::default()),
            || second.inward(&scene, load, other.clone(), Carried::default()),
        );
        let (second, first) = (second?, first?);
        if let Some(join) = plan[*hub].join {
            low.joins[join as usize].add(&second.others);
            low.joins[join as usize].add(&first.others);
        }
        let lost = after.lost.max(first.lost).max(second.lost);
        low.inward(&scene, load, 1..hub + 1, first.first).map(|passed| passed.lost.max(lost))
    }

    /// Tips → root: `e` and `u` alone.
    fn inward(&mut self, model: &Model, motion: &Motion, load: &Load<'_>) {
        match load.applied.is_empty() {
            true => self.e.fill(Wrench::ZERO),
            false => self.e.iter_mut().zip(load.applied).for_each(|(e, applied)| *e = Wrench::ZERO - *applied),
        }
        for index in (1..model.links.len()).rev() {
            let (link, at) = (&model.links[index], &motion.links[index]);
            let mut e = self.e[index];
            match link.joint {
                Joint::None => {}
                Joint::Interface { modal, tip } => {
                    self.modals[modal].load_interface(&motion.modals[modal], tip, &e);
                }
                Joint::Modal { modal, .. } => e += self.modals[modal].load(&load.tau[link.velocity..]),
                Joint::Flex { rod, .. } | Joint::Along { rod } => {
                    let tau = &load.tau[link.velocity..link.velocity + link.joint.counts().1];
                    self.e[link.parent] += self.rods[rod].load(&motion.rods[rod], tau, &e);
                }
                Joint::Ball { .. } => {
                    let ball = &mut self.balls[self.plan[index].ball as usize];
                    e = ball.load(at, &three(load.tau, link.velocity), &e, || at.turn.tr_mul(&e.moment));
                }
                _ => {
                    let left = &mut self.hinges[index];
                    left.u = load.tau[link.velocity] - along(&link.joint, &at.axis, &e);
                    e.add_times(left.inverse * left.u, &left.SH);
                }
            }
            self.e[link.parent] += e.shifted(at.arm);
        }
    }

    /// Root → tips: eq. (8).
    #[inline(always)]
    fn outward<const BIAS: bool>(&mut self, model: &Model, motion: &Motion, hinge: &mut [f64]) {
        let Self { plan, hinges, balls, rods, modals, a, .. } = self;
        let scene = Scene { model, motion, plan };
        let outside = LinkAcceleration::default();
        a[0] = outside;
        let links = 1..model.links.len();
        let Some(Halves { hub, links: [one, other], velocities, .. }) = &model.halves else {
            return Outward { hinges, balls, rods, modals, base: 0, outside, a, velocity: 0, hinge }
                .sweep::<BIAS>(&scene, links);
        };
        Outward { hinges, balls, rods, modals, base: 0, outside, a, velocity: 0, hinge }
            .sweep::<BIAS>(&scene, 1..hub + 1);
        let (low, rest) = a.split_at_mut(one.start);
        let (first, rest) = rest.split_at_mut(one.len());
        let half = |links: &Range<usize>, a, velocity, hinge| {
            let half =
                Outward { hinges, balls, rods, modals, base: links.start, outside: low[*hub], a, velocity, hinge };
            half.sweep::<BIAS>(&scene, links.clone());
        };
        let (before, other_hinge) = hinge.split_at_mut(velocities[1].start);
        let one_hinge = &mut before[velocities[0].clone()];
        at_once(
            || half(one, first, velocities[0].start, one_hinge),
            || half(other, &mut rest[..other.len()], velocities[1].start, &mut other_hinge[..velocities[1].len()]),
        );
        Outward { hinges, balls, rods, modals, base: 0, outside, a, velocity: 0, hinge }
            .sweep::<BIAS>(&scene, other.end..links.end);
    }

    /// The mass of a link from now on (kg).
    pub(crate) fn set_mass(&mut self, link: usize, mass: f64) {
        self.plan[link].mass = mass;
    }

    /// The inertia that each hinge coordinate sees while everything outboard moves freely: the diagonal of `D`,
    /// armature included (kg, kg m²).
    pub fn articulated_inertia(&self, model: &Model, motion: &Motion, out: &mut [f64]) {
        for (index, link) in model.links.iter().enumerate().skip(1) {
            let first = link.velocity;
            match link.joint {
                Joint::None | Joint::Interface { .. } => {}
                Joint::Modal { modal, .. } => {
                    let seen = self.modals[modal].inertia();
                    out[first..first + seen.len()].copy_from_slice(seen);
                }
                Joint::Ball { .. } => {
                    let seen = self.balls[self.plan[index].ball as usize].inertia(&motion.links[index]);
                    for i in 0..3 {
                        out[first + i] = seen[i] + model.coordinates[first + i].armature;
                    }
                }
                Joint::Flex { rod, .. } | Joint::Along { rod } => {
                    let seen = self.rods[rod].inertia();
                    out[first..first + seen.len()].copy_from_slice(seen);
                }
                _ => out[first] = 1.0 / self.hinges[index].inverse,
            }
        }
    }
}

/// Eqs. (5) to (7) for a link that can only translate: what it and the links below it feel of `S` and `e` is `ff` and the
/// force. (A floating base is three of these and a ball.)
#[inline(always)]
fn translate(
    model: &Model,
    (link, at): (&Link, &LinkMotion),
    is_massless: bool,
    applied: Option<&Wrench>,
    carried: &Carried,
    tau: &[f64],
    left: &mut One,
) -> Result<Carried, f64> {
    let mut here = *carried;
    if !is_massless {
        here = here.with_body(link.mass, at, &model.gravity);
    }
    if let Some(applied) = applied {
        here = here.loaded(applied);
    }
    let (armature, tau) = (model.coordinates[link.velocity].armature, tau[link.velocity]);
    let one = here.translation(&at.axis, armature, tau)?;
    *left = one.one();
    Ok(here.without_force(&one))
}

#[inline]
fn three(list: &[f64], at: usize) -> Vector3<f64> {
    Vector3::new(list[at], list[at + 1], list[at + 2])
}
