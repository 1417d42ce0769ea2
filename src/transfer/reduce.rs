//! The reduction: a factorization of the tree, and solutions with it.

mod ball;
mod way;

use super::element::{Reduced, bias, moment_in_link_axes};
use super::plan::{Place, To, plan};
use super::{LinkAcceleration, accelerate, along, inboard};
use crate::model::{Joint, Link, Model};
use crate::motion::{LinkMotion, Motion};
use crate::spatial::Wrench;
use crate::spatial::fused::{dot_add, times, transposed_times};
use ball::{Ball, Pivot};
use nalgebra::Vector3;

/// A pivot below this part of the moment of inertia (or mass) that the hinge could see is round-off: four units in the
/// last place of the sums it is the difference of.
const SINGULAR: f64 = 4.0 * f64::EPSILON;

/// The factorized tree: hinge pivots at one position.
#[derive(Debug, Clone)]
pub struct Reduction {
    /// How the links hang together.
    plan: Vec<Place>,
    /// What is left of every hinge; of a ball it is in `balls`.
    hinges: Vec<One>,
    balls: Vec<Ball>,
    /// What arrives at links with several children from all but the first; nothing between two sweeps.
    joins: Vec<Carried>,
    /// Scratch of [`Reduction::solve`].
    e: Vec<Wrench>,
    /// Accelerations of the root markers in the last solution.
    a: Vec<LinkAcceleration>,
}

/// A hinge of one coordinate, eliminated: `S H`, `D⁻¹` and the `u` of the last solution.
#[derive(Debug, Clone, Copy, Default)]
struct One {
    SH: Wrench,
    inverse: f64,
    u: f64,
}

/// What a link passes on to its parent: `X(d)ᵀ S' X(d)` and `X(d)ᵀ e'`. Kept in registers along a chain.
#[derive(Debug, Clone, Copy, Default)]
struct Carried {
    S: Reduced,
    e: Wrench,
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
        Self {
            plan,
            hinges: vec![One::default(); n],
            balls: vec![Ball::default(); balls],
            joins: vec![Carried::default(); joins],
            e: vec![Wrench::ZERO; n],
            a: vec![LinkAcceleration::default(); n],
        }
    }

    /// Factorizes and solves for the accelerations of the hinges: eqs. (5) to (8) with weight and velocity terms.
    ///
    /// # Errors
    /// A hinge that nothing with inertia resists, or a number that is not finite.
    #[inline(always)]
    pub fn accelerations(
        &mut self,
        model: &Model,
        motion: &Motion,
        load: &Load<'_>,
        hinge: &mut [f64],
    ) -> Result<(), Singular> {
        if let Err(singular) = self.factorize(model, motion, load) {
            self.joins.fill(Carried::default());
            return Err(singular);
        }
        self.outward::<true>(model, motion, hinge);
        Ok(())
    }

    /// Eqs. (6) to (8) with the last factorization for a load alone: no weight, no velocity terms, `q̈ = M⁻¹ (…)`.
    pub fn solve(&mut self, model: &Model, motion: &Motion, load: &Load<'_>, hinge: &mut [f64]) {
        self.inward(model, motion, load);
        self.outward::<false>(model, motion, hinge);
    }

    /// Tips → root: eqs. (5) to (7). `S` and `e` go from link to link in registers; only where branches meet they are
    /// summed in memory.
    #[inline(always)]
    fn factorize(&mut self, model: &Model, motion: &Motion, load: &Load<'_>) -> Result<(), Singular> {
        let mut carried = Carried::default();
        let links = model.links.iter().zip(&motion.links).zip(&self.plan).zip(&mut self.hinges);
        for (index, (((link, at), place), left)) in links.enumerate().skip(1).rev() {
            if place.is_leaf {
                carried = Carried::default();
            } else if let Some(join) = place.join {
                carried.add(&std::mem::take(&mut self.joins[join as usize]));
            }
            let applied = load.applied.get(index);
            let failed = |pivot| Singular { link: index, pivot };
            let across = match link.joint {
                Joint::None => carried,
                Joint::Turn | Joint::Slide { .. } => {
                    let here = carried.with_body(link, at, &model.gravity, applied);
                    let (armature, tau) = (model.coordinates[link.velocity].armature, load.tau[link.velocity]);
                    let one = match link.joint {
                        Joint::Turn => One::turn(&here.S, &at.axis, armature, tau, &here.e),
                        _ => One::slide(&here.S, &at.axis, armature, tau, &here.e),
                    };
                    let one = one.map_err(failed)?;
                    *left = one;
                    if matches!(place.to, To::Ground) {
                        continue;
                    }
                    one.across(here.S, here.e, at)
                }
                Joint::Ball { .. } => {
                    let here = carried.with_body(link, at, &model.gravity, applied);
                    let ball = &mut self.balls[place.ball as usize];
                    let pivot = if place.is_leaf { Pivot::OfBody } else { Pivot::OfTree };
                    let (eliminated, across) = ball::eliminate(model, link, at, &here.S, pivot).map_err(failed)?;
                    *ball = eliminated;
                    let tau = three(load.tau, link.velocity);
                    let applied = applied.map_or(Vector3::zeros(), |wrench| wrench.moment);
                    let own = || moment_in_link_axes(link, &model.gravity, at) - at.turn.tr_mul(&applied);
                    let passed = ball.load(at, &tau, &here.e, own);
                    Carried { e: passed + across.times(&at.velocity_terms()), S: across }
                }
            };
            if matches!(place.to, To::Ground) {
                continue;
            }
            carried = Carried { S: across.S.shifted(&at.arm), e: across.e.shifted(at.arm) };
            if let To::Join(join) = place.to {
                self.joins[join as usize].add(&carried);
            }
        }
        Ok(())
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
                Joint::Turn | Joint::Slide { .. } => {
                    let left = &mut self.hinges[index];
                    left.u = load.tau[link.velocity] - along(&link.joint, &at.axis, &e);
                    e.add_times(left.inverse * left.u, &left.SH);
                }
                Joint::Ball { .. } => {
                    let ball = &mut self.balls[self.plan[index].ball as usize];
                    e = ball.load(at, &three(load.tau, link.velocity), &e, || at.turn.tr_mul(&e.moment));
                }
            }
            self.e[link.parent] += e.shifted(at.arm);
        }
    }

    /// Root → tips: eq. (8).
    #[inline(always)]
    fn outward<const BIAS: bool>(&mut self, model: &Model, motion: &Motion, hinge: &mut [f64]) {
        let mut before = LinkAcceleration::default();
        self.a[0] = before;
        let links = model.links.iter().zip(&motion.links).zip(&self.hinges);
        for (index, ((link, at), left)) in links.enumerate().skip(1) {
            // Along a chain the parent's acceleration is still in registers.
            let parent = if link.parent + 1 == index { before } else { self.a[link.parent] };
            let mut a = inboard(at, &parent, BIAS);
            match link.joint {
                Joint::None => {}
                Joint::Turn | Joint::Slide { .. } => {
                    let free = dot_add(&-left.SH.moment, &a.angular, left.u);
                    hinge[link.velocity] = left.inverse * dot_add(&-left.SH.force, &a.linear, free);
                }
                Joint::Ball { .. } => {
                    let seen = a;
                    let relative = self.balls[self.plan[index].ball as usize].solve(link, at, &seen);
                    hinge[link.velocity..link.velocity + 3].copy_from_slice(relative.as_slice());
                }
            }
            accelerate(link, at, hinge, &mut a);
            self.a[index] = a;
            before = a;
        }
    }

    /// The inertia that each hinge coordinate sees while everything outboard moves freely: the diagonal of `D`,
    /// armature included (kg, kg m²).
    pub fn articulated_inertia(&self, model: &Model, motion: &Motion, out: &mut [f64]) {
        for (index, link) in model.links.iter().enumerate().skip(1) {
            let first = link.velocity;
            match link.joint {
                Joint::None => {}
                Joint::Turn | Joint::Slide { .. } => out[first] = 1.0 / self.hinges[index].inverse,
                Joint::Ball { .. } => {
                    let seen = self.balls[self.plan[index].ball as usize].inertia(&motion.links[index]);
                    for i in 0..3 {
                        out[first + i] = seen[i] + model.coordinates[first + i].armature;
                    }
                }
            }
        }
    }
}

impl One {
    /// Eqs. (5) and (6) for a turn; on failure the pivot.
    #[inline(always)]
    fn turn(S: &Reduced, axis: &Vector3<f64>, armature: f64, tau: f64, e: &Wrench) -> Result<Self, f64> {
        let SH = Wrench { force: times(&S.fm, axis), moment: S.mm * *axis };
        let D = dot_add(axis, &SH.moment, armature);
        Self::of(SH, D, S.mm.trace(), dot_add(&-axis, &e.moment, tau))
    }

    /// The same for a slide.
    #[inline(always)]
    fn slide(S: &Reduced, axis: &Vector3<f64>, armature: f64, tau: f64, e: &Wrench) -> Result<Self, f64> {
        let SH = Wrench { force: S.ff * *axis, moment: transposed_times(&S.fm, axis) };
        let D = dot_add(axis, &SH.force, armature);
        Self::of(SH, D, S.ff.trace(), dot_add(&-axis, &e.force, tau))
    }

    /// On failure the pivot: below round-off of what the hinge could see, or not finite.
    #[inline(always)]
    fn of(SH: Wrench, D: f64, seen: f64, u: f64) -> Result<Self, f64> {
        if !(D > SINGULAR * seen && D.is_finite()) {
            return Err(D);
        }
        Ok(Self { SH, inverse: 1.0 / D, u })
    }

    /// Eqs. (5) and (6): `S'` and `e'`. `S' γ` is summed on its own: `e` is what the next link waits for.
    #[inline(always)]
    fn across(&self, mut S: Reduced, e: Wrench, at: &LinkMotion) -> Carried {
        S.downdate(&self.SH, self.inverse);
        let mut e = e + S.times(&at.velocity_terms());
        e.add_times(self.inverse * self.u, &self.SH);
        Carried { S, e }
    }
}

impl Carried {
    /// With what the link itself adds by eq. (1).
    #[inline(always)]
    fn with_body(&self, link: &Link, at: &LinkMotion, gravity: &Vector3<f64>, applied: Option<&Wrench>) -> Self {
        let mut sum = *self;
        sum.S.add_body(link.mass, &at.center, &at.inertia);
        sum.e += bias(link.mass, gravity, at);
        if let Some(applied) = applied {
            sum.e = sum.e - *applied;
        }
        sum
    }

    #[inline(always)]
    fn add(&mut self, other: &Self) {
        self.S.add(&other.S);
        self.e += other.e;
    }
}

#[inline]
fn three(list: &[f64], at: usize) -> Vector3<f64> {
    Vector3::new(list[at], list[at + 1], list[at + 2])
}
