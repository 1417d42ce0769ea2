//! The reduction: a factorization of the tree, and solutions with it.

mod ball;
mod carried;
mod way;

use super::element::{axial_moment, moment_in_link_axes};
use super::plan::{Kind, Place, To, plan};
use super::{LinkAcceleration, along, inboard};
use crate::model::{Joint, Link, Model};
use crate::motion::{LinkMotion, Motion};
use crate::spatial::Wrench;
use crate::spatial::fused::{dot, dot_add, scale_add, times_add};
use ball::{Ball, Pivot};
use carried::Carried;
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
        let links = model.links[1..].iter().zip(&motion.links[1..]).zip(&self.plan[1..]).zip(&mut self.hinges[1..]);
        for ((((link, at), place), left), index) in links.zip(1..model.links.len()).rev() {
            if place.is_leaf {
                carried = Carried::default();
            } else if let Some(join) = place.join {
                carried.add(&std::mem::take(&mut self.joins[join as usize]));
            }
            let applied = load.applied.get(index);
            if place.translates {
                carried = translate(model, (link, at), place.is_massless, applied, &carried, load.tau, left)
                    .map_err(|pivot| Singular { link: index, pivot })?;
                if let To::Join(join) = place.to {
                    self.joins[join as usize].add(&carried);
                }
                continue;
            }
            let mut here = if place.is_massless { carried } else { carried.with_body(place.mass, at, &model.gravity) };
            if let Some(applied) = applied {
                here = here.loaded(applied);
            }
            let failed = |pivot| Singular { link: index, pivot };
            let to_ground = matches!(place.to, To::Ground);
            let first = place.velocity as usize;
            carried = match place.kind {
                Kind::None => here,
                Kind::Turn | Kind::Slide => {
                    let (armature, tau) = (place.armature, load.tau[first]);
                    let one = match place.kind {
                        Kind::Turn if place.is_slender => {
                            let given = applied.map_or(0.0, |wrench| dot(&at.axis, &wrench.moment));
                            let axial = axial_moment(link, &model.gravity, at) - given;
                            let (straight, one) = here.slender(link, at, armature, (tau, axial));
                            here = straight;
                            one
                        }
                        Kind::Turn => here.turn(&at.axis, armature, tau),
                        _ => here.slide(&at.axis, armature, tau),
                    };
                    let one = one.map_err(failed)?;
                    *left = one.one();
                    if to_ground {
                        continue;
                    }
                    here.without(&one).shifted(at)
                }
                Kind::Ball => {
                    let ball = &mut self.balls[place.ball as usize];
                    let pivot = if place.is_leaf { Pivot::OfBody } else { Pivot::OfTree };
                    let (eliminated, across) =
                        ball::eliminate(model, link, at, &here.matrix(), pivot).map_err(failed)?;
                    *ball = eliminated;
                    let tau = three(load.tau, first);
                    let applied = applied.map_or(Vector3::zeros(), |wrench| wrench.moment);
                    let own = || moment_in_link_axes(link, &model.gravity, at) - at.turn.tr_mul(&applied);
                    let passed = ball.load(at, &tau, &here.vector(), own);
                    if to_ground {
                        continue;
                    }
                    Carried::of(&across, &passed).shifted(at)
                }
            };
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
        let links = self.plan[1..].iter().zip(&motion.links[1..]).zip(&self.hinges[1..]);
        for (((place, at), left), index) in links.zip(1..) {
            // Along a chain the parent's acceleration is still in registers.
            let (parent, first) = (place.parent as usize, place.velocity as usize);
            let parent = if parent + 1 == index { before } else { self.a[parent] };
            let mut a = inboard(at, &parent, BIAS);
            match place.kind {
                Kind::None => {}
                Kind::Turn | Kind::Slide => {
                    let free = dot_add(&-left.SH.moment, &a.angular, left.u);
                    let relative = left.inverse * dot_add(&-left.SH.force, &a.linear, free);
                    hinge[first] = relative;
                    match place.kind {
                        Kind::Turn => a.angular = scale_add(relative, &at.axis, &a.angular),
                        _ => a.linear = scale_add(relative, &at.axis, &a.linear),
                    }
                }
                Kind::Ball => {
                    let relative = self.balls[place.ball as usize].solve(&model.links[index], at, &a);
                    hinge[first..first + 3].copy_from_slice(relative.as_slice());
                    a.angular = times_add(&at.turn, &relative, &a.angular);
                }
            }
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
