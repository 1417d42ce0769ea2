//! The reduction: a factorization of the tree, and solutions with it.

mod ball;
mod way;

use super::element::{Reduced, bias, moment_in_link_axes};
use super::plan::{Place, To, plan};
use super::{LinkAcceleration, accelerate, along, inboard};
use crate::model::{Joint, Model};
use crate::motion::Motion;
use crate::spatial::Wrench;
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
            let Carried { S, e } = &mut carried;
            if !place.is_massless {
                S.add_body(link.mass, &at.center, &at.inertia);
                *e += bias(link.mass, &model.gravity, at);
            }
            if let Some(applied) = load.applied.get(index) {
                *e = *e - *applied;
            }
            let failed = |pivot| Singular { link: index, pivot };
            match link.joint {
                Joint::None => {}
                Joint::Turn => {
                    let SH = Wrench { force: S.fm * at.axis, moment: S.mm * at.axis };
                    let armature = model.coordinates[link.velocity].armature;
                    let D = at.axis.dot(&SH.moment) + armature;
                    *left = One::of(SH, D, S.mm.trace()).map_err(failed)?;
                    left.u = load.tau[link.velocity] - at.axis.dot(&e.moment);
                }
                Joint::Slide { .. } => {
                    let SH = Wrench { force: S.ff * at.axis, moment: S.fm.tr_mul(&at.axis) };
                    let armature = model.coordinates[link.velocity].armature;
                    let D = at.axis.dot(&SH.force) + armature;
                    *left = One::of(SH, D, S.ff.trace()).map_err(failed)?;
                    left.u = load.tau[link.velocity] - at.axis.dot(&e.force);
                }
                Joint::Ball { .. } => {
                    let ball = &mut self.balls[place.ball as usize];
                    let pivot = if place.is_leaf { Pivot::OfBody } else { Pivot::OfTree };
                    let (eliminated, across) = ball::eliminate(model, link, at, S, pivot).map_err(failed)?;
                    *ball = eliminated;
                    let tau = three(load.tau, link.velocity);
                    let applied = load.applied.get(index).map_or(Vector3::zeros(), |wrench| wrench.moment);
                    let own = || moment_in_link_axes(link, &model.gravity, at) - at.turn.tr_mul(&applied);
                    let passed = ball.load(at, &tau, e, own);
                    *S = across;
                    *e = passed;
                }
            }
            if matches!(place.to, To::Ground) {
                continue;
            }
            if !matches!(link.joint, Joint::Ball { .. }) {
                S.downdate(&left.SH, left.inverse);
                *e += left.SH.times(left.inverse * left.u);
            }
            *e += S.times(&LinkAcceleration { linear: at.bias, angular: at.angular_bias });
            carried = Carried { S: S.shifted(&at.arm), e: e.shifted(at.arm) };
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
                    e += left.SH.times(left.inverse * left.u);
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
        self.a[0] = LinkAcceleration::default();
        let links = model.links.iter().zip(&motion.links).zip(&self.hinges);
        for (index, ((link, at), left)) in links.enumerate().skip(1) {
            let mut a = inboard(at, &self.a[link.parent], BIAS);
            match link.joint {
                Joint::None => {}
                Joint::Turn | Joint::Slide { .. } => {
                    let resisted = left.SH.force.dot(&a.linear) + left.SH.moment.dot(&a.angular);
                    hinge[link.velocity] = left.inverse * (left.u - resisted);
                }
                Joint::Ball { .. } => {
                    let relative = self.balls[self.plan[index].ball as usize].solve(link, at, &a);
                    hinge[link.velocity..link.velocity + 3].copy_from_slice(relative.as_slice());
                }
            }
            accelerate(link, at, hinge, &mut a);
            self.a[index] = a;
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
    /// On failure the pivot: below round-off of what the hinge could see, or not finite.
    #[inline]
    fn of(SH: Wrench, D: f64, seen: f64) -> Result<Self, f64> {
        if !(D > SINGULAR * seen && D.is_finite()) {
            return Err(D);
        }
        Ok(Self { SH, inverse: 1.0 / D, u: 0.0 })
    }
}

impl Carried {
    #[inline]
    fn add(&mut self, other: &Self) {
        self.S.add(&other.S);
        self.e += other.e;
    }
}

#[inline]
fn three(list: &[f64], at: usize) -> Vector3<f64> {
    Vector3::new(list[at], list[at + 1], list[at + 2])
}
