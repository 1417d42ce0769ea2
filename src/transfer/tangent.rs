//! The tangent in O(n): solves `(c₂ ∂r/∂q̈ + c₁ ∂r/∂q̇ + ∂r/∂q) δq = rhs` for the inverse dynamics residual `r`, by the
//! same reduction as the accelerations, applied to the variation of the marker state.
//!
//! ```text
//! z = [δθ, δω, δω̇, δr̈, δr, δv]            variation of a root marker's state, 18; δr, δv where forces depend on them
//! (1) body     δf_R = S z_R + e                                     S from differentiating the body's equations, 6×18
//! (2) hinge    z_R = T z_P + h δq                                   the outward sweep, differentiated
//! (3) row      Hᵀ δf_R + (∂Hᵀ) f_R + κ δq = rhs                     κ: hinge spring, damper, armature, shift
//!              one coordinate: (δθ_P × n)·m = δθ_P·(n × m);   ball, inertial axes: [m]× δθ_R
//! (4)          D = g h + κ,  g = Hᵀ S,   row = g T + (∂Hᵀ) f_R
//! (5)          δq = D⁻¹ (u − row z_P),   u = rhs − Hᵀ e
//! (6)          S_P += Xᵀ S T − w D⁻¹ row + shift,   e_P += Xᵀ e + w D⁻¹ u,   w = Xᵀ S h + (slide) [0; n × f]
//! (7) shift    the moment at the parent gains (δθ_P × d) × f
//! ```
//!
//! At rest in equilibrium of loads with a potential the matrix is symmetric, and by Sylvester's law the negative pivots
//! `D` count its negative eigenvalues.

mod blocks;
mod eliminate;
mod hinge;

pub use blocks::{Applied, Column};
pub use eliminate::Coupling;

use super::balance::Balance;
use super::plan::{Place, To, plan};
use crate::model::{Joint, Link, Model};
use crate::motion::variation::{LinkAcceleration, LinkVariation};
use crate::motion::{LinkMotion, Motion};
use crate::spatial::Wrench;
use blocks::{
    ACCELERATION, AT_REST, AT_REST_IN_PLACE, Blocks, MOVING, MOVING_IN_PLACE, RATE, TURN, TURN_ACCELERATION,
    cross_times, dot, placed, times, times_cross, twice,
};
use eliminate::{NegativeAxes, One, Three, eliminate_ball, eliminate_one};
use hinge::Hinge;
use nalgebra::{Matrix3, Vector3};

/// The point at which the tangent is taken, and its coefficients.
#[derive(Debug, Clone, Copy)]
pub struct At<'a> {
    /// Positions and velocities.
    pub motion: &'a Motion,
    /// Accelerations of the links, and the wrenches in the hinges.
    pub balance: &'a Balance,
    /// Hinge accelerations.
    pub hinge: &'a [f64],
    /// Factor of ∂/∂q̇ (1/s).
    pub c1: f64,
    /// Factor of ∂/∂q̈ (1/s²).
    pub c2: f64,
    /// `κ` of every velocity coordinate: spring, damper, armature and shift; the diagonal part. Infinite for a
    /// coordinate that is held.
    pub diagonal: &'a [f64],
    /// How force elements load the link they are attached to when it moves: subtracted from `S`; by link, empty for
    /// none.
    pub applied: &'a [(usize, Applied)],
    /// What force elements between a link and its parent add beside their `applied`: by link, one for each pair.
    pub coupled: &'a [(usize, Coupling)],
    /// Full 3×3 springs of balls, link axes: `−∂τ/∂(turn)` by link.
    pub ball_springs: &'a [(usize, Matrix3<f64>)],
}

/// The factorized tangent.
#[derive(Debug, Clone)]
pub struct Tangent {
    /// How the links hang together.
    plan: Vec<Place>,
    /// What arrives at links with several children from all but the first; nothing between two sweeps.
    joins: Vec<Blocks>,
    /// Whether the last factorization broke down and may have left something there.
    broken: bool,
    /// The point of the tangent, for the solutions that follow.
    at: Vec<Hinge>,
    hinges: Vec<Eliminated>,
    balls: Vec<Three>,
    e: Vec<Wrench>,
    u: Vec<Vector3<f64>>,
    z: Vec<LinkVariation>,
    /// Negative pivots.
    negative: usize,
    /// How much of `z` takes part.
    reach: usize,
}

/// What is left of a hinge after its elimination; balls are kept apart, by index, for being three times as large.
#[derive(Debug, Clone, Copy)]
enum Eliminated {
    None,
    One(One),
    Three(usize),
}

/// A pivot that is zero or not finite: the link it belongs to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Breakdown {
    /// The link.
    pub link: usize,
    /// For a ball, the axis about which it gives way, inertial axes.
    pub axis: Option<Vector3<f64>>,
}

impl Tangent {
    /// Room for a model's links.
    pub fn new(model: &Model) -> Self {
        let n = model.links.len();
        let (plan, joins, _) = plan(model);
        Self {
            plan,
            joins: vec![Blocks::default(); joins],
            broken: false,
            at: vec![Hinge::default(); n],
            hinges: model.links.iter().scan(0, kind_of).collect(),
            balls: vec![Three::default(); model.links.iter().filter(is_ball).count()],
            e: vec![Wrench::ZERO; n],
            u: vec![Vector3::zeros(); n],
            z: vec![LinkVariation::default(); n],
            negative: 0,
            reach: MOVING_IN_PLACE,
        }
    }

    /// Number of negative pivots: at an equilibrium with a potential, of negative eigenvalues.
    pub fn negative_pivots(&self) -> usize {
        self.negative
    }

    /// Tips → root: eqs. (4), (6) and (7). With `definite` it stops at the first pivot that is not positive.
    ///
    /// # Errors
    /// A pivot that is zero or not finite, or negative where a definite matrix is wanted.
    pub fn factorize(&mut self, model: &Model, at: &At<'_>, definite: bool) -> Result<(), Breakdown> {
        let moving = at.motion.links.iter().any(|link| link.angular_velocity != Vector3::zeros());
        let accelerating = at.hinge.iter().any(|a| *a != 0.0);
        self.reach = match (at.c1 != 0.0 || at.c2 != 0.0 || moving || accelerating, at.applied.is_empty()) {
            (true, false) => MOVING_IN_PLACE,
            (true, true) => MOVING,
            (false, false) => AT_REST_IN_PLACE,
            (false, true) => AT_REST,
        };
        self.negative = 0;
        match self.reach {
            AT_REST => self.inward::<AT_REST>(model, at, definite),
            AT_REST_IN_PLACE => self.inward::<AT_REST_IN_PLACE>(model, at, definite),
            MOVING => self.inward::<MOVING>(model, at, definite),
            _ => self.inward::<MOVING_IN_PLACE>(model, at, definite),
        }
    }

    fn inward<const N: usize>(&mut self, model: &Model, at: &At<'_>, definite: bool) -> Result<(), Breakdown> {
        // What a breakdown left behind.
        if std::mem::replace(&mut self.broken, true) {
            self.joins.fill(Blocks::default());
        }
        let mut balls = at.ball_springs.iter().rev().peekable();
        let mut forces = at.applied.iter().rev().peekable();
        let mut couplings = at.coupled.iter().rev().peekable();
        let mut S = [Column::default(); N];
        for index in (1..model.links.len()).rev() {
            let (link, own, place) = (&model.links[index], &at.motion.links[index], self.plan[index]);
            if place.is_leaf {
                S = [Column::default(); N];
            } else if let Some(join) = place.join {
                let join = &mut self.joins[join as usize];
                S.iter_mut().zip(join.iter_mut()).for_each(|(sum, more)| sum.add(&std::mem::take(more)));
            }
            if !place.is_massless {
                add_body::<N>(link, own, &at.balance.accelerations[index], &model.gravity, &mut S);
            }
            while let Some((_, blocks)) = forces.next_if(|(link, _)| *link == index) {
                S.iter_mut().zip(placed::<N>(blocks)).for_each(|(sum, block)| sum.take(&block));
            }
            let spring = balls.next_if(|(link, _)| *link == index).map(|(_, spring)| *spring);
            let coupling = couplings.next_if(|(link, _)| *link == index).map(|(_, coupling)| coupling);
            self.eliminate::<N>(model, at, index, (spring, coupling), definite, &mut S)?;
            if let To::Join(join) = place.to {
                self.joins[join as usize].iter_mut().zip(&S).for_each(|(sum, more)| sum.add(more));
            }
        }
        self.broken = false;
        Ok(())
    }

    /// One hinge: `S` at its root marker becomes what the link passes on; the breakdown where its pivot does not do.
    #[inline]
    fn eliminate<const N: usize>(
        &mut self,
        model: &Model,
        at: &At<'_>,
        index: usize,
        (spring, coupling): (Option<Matrix3<f64>>, Option<&Coupling>),
        definite: bool,
        S: &mut [Column; N],
    ) -> Result<(), Breakdown> {
        let link = &model.links[index];
        let hinge = Hinge::new(link, at, index);
        self.at[index] = hinge;
        let f = &at.balance.reactions[index];
        let first = link.velocity;
        let negative = match &mut self.hinges[index] {
            Eliminated::None => NegativeAxes::default(),
            Eliminated::One(slot) => {
                let (one, negative) = eliminate_one(&hinge, S, f, at.diagonal[first], coupling)
                    .ok_or(Breakdown { link: index, axis: None })?;
                *slot = one;
                negative
            }
            Eliminated::Three(slot) => {
                let turn = &hinge.turn;
                let mut kappa = Matrix3::from_diagonal(&Vector3::from_fn(|i, _| at.diagonal[first + i]));
                kappa += spring.unwrap_or_else(Matrix3::zeros);
                let held = at.diagonal[first].is_infinite();
                let kappa = turn * kappa * turn.transpose();
                let (three, negative) = eliminate_ball(&hinge, S, f, &kappa, held, coupling)
                    .map_err(|axis| Breakdown { link: index, axis: Some(axis) })?;
                self.balls[*slot] = three;
                negative
            }
        };
        if definite && let Some(axis) = negative.first() {
            return Err(Breakdown { link: index, axis: matches!(link.joint, Joint::Ball { .. }).then_some(*axis) });
        }
        self.negative += negative.len();
        // (7): (δθ × d) × f = [f]× [d]× δθ
        let (f, d) = (&f.force, &hinge.arm);
        S[TURN].moment += twice(f, d);
        Ok(())
    }

    /// A direction `x` with `xᵀ K x < 0`, after a factorization for a definite matrix broke down at a hinge: that hinge
    /// moves, everything outboard of it follows as it likes best, the rest stays. Then `xᵀ K x` is the pivot `D`.
    pub fn negative_direction(&mut self, model: &Model, breakdown: Breakdown, x: &mut [f64]) {
        x.fill(0.0);
        let root = breakdown.link;
        let mut z = LinkVariation::default();
        match breakdown.axis {
            None => {
                x[model.links[root].velocity] = 1.0;
                self.at[root].add_one(&mut z, 1.0);
            }
            Some(axis) => {
                let local = self.at[root].turn.tr_mul(&axis);
                x[model.links[root].velocity..model.links[root].velocity + 3].copy_from_slice(local.as_slice());
                self.at[root].add_ball(&mut z, &axis);
            }
        }
        self.z[root] = z;
        let outboard = root + 1..model.links[root].subtree_end;
        self.u[outboard.clone()].fill(Vector3::zeros());
        match self.reach {
            AT_REST => self.outward::<AT_REST>(model, outboard, x),
            AT_REST_IN_PLACE => self.outward::<AT_REST_IN_PLACE>(model, outboard, x),
            MOVING => self.outward::<MOVING>(model, outboard, x),
            _ => self.outward::<MOVING_IN_PLACE>(model, outboard, x),
        }
    }

    /// Eqs. (5) and (6) for one right side, in place.
    pub fn solve(&mut self, model: &Model, x: &mut [f64]) {
        self.e.fill(Wrench::ZERO);
        for index in (1..model.links.len()).rev() {
            let (link, own) = (&model.links[index], &self.at[index]);
            let e = self.e[index];
            let mut passed = e.shifted(own.arm);
            match &self.hinges[index] {
                Eliminated::None => {}
                Eliminated::One(One { w, inverse, .. }) => {
                    let u = x[link.velocity] - super::along(&link.joint, &own.axis, &e);
                    self.u[index].x = u;
                    passed += Wrench { force: (inverse * u) * w.force, moment: (inverse * u) * w.moment };
                }
                Eliminated::Three(ball) => {
                    let Three { w, inverse, .. } = &self.balls[*ball];
                    let rhs = Vector3::new(x[link.velocity], x[link.velocity + 1], x[link.velocity + 2]);
                    let u = own.turn * rhs - e.moment;
                    self.u[index] = u;
                    let step = inverse * u;
                    passed += Wrench { force: w.force * step, moment: w.moment * step };
                }
            }
            self.e[link.parent] += passed;
        }
        match self.reach {
            AT_REST => self.outward::<AT_REST>(model, 1..model.links.len(), x),
            AT_REST_IN_PLACE => self.outward::<AT_REST_IN_PLACE>(model, 1..model.links.len(), x),
            MOVING => self.outward::<MOVING>(model, 1..model.links.len(), x),
            _ => self.outward::<MOVING_IN_PLACE>(model, 1..model.links.len(), x),
        }
    }

    /// Root → tips: eqs. (5) and (2).
    fn outward<const N: usize>(&mut self, model: &Model, range: std::ops::Range<usize>, x: &mut [f64]) {
        for index in range {
            let link = &model.links[index];
            let parent = &self.z[link.parent];
            let hinge = &self.at[index];
            let mut z = hinge.carry::<N>(parent);
            match &self.hinges[index] {
                Eliminated::None => {}
                Eliminated::One(One { row, inverse, .. }) => {
                    let step = inverse * (self.u[index].x - dot::<N>(row, parent));
                    x[link.velocity] = step;
                    hinge.add_one(&mut z, step);
                }
                Eliminated::Three(ball) => {
                    let Three { row, inverse, .. } = &self.balls[*ball];
                    let step = inverse * (self.u[index] - times::<N>(row, parent));
                    let local = hinge.turn.tr_mul(&step);
                    x[link.velocity..link.velocity + 3].copy_from_slice(local.as_slice());
                    hinge.add_ball(&mut z, &step);
                }
            }
            self.z[index] = z;
        }
    }
}

fn is_ball(link: &&Link) -> bool {
    matches!(link.joint, Joint::Ball { .. })
}

/// Room for what is left of a link's hinge; balls are counted.
fn kind_of(balls: &mut usize, link: &Link) -> Option<Eliminated> {
    Some(match link.joint {
        Joint::None => Eliminated::None,
        Joint::Turn | Joint::Slide { .. } => Eliminated::One(One::default()),
        Joint::Ball { .. } => {
            *balls += 1;
            Eliminated::Three(*balls - 1)
        }
    })
}

/// Adds `S` of eq. (1): the variation of the body's wrench (see [`super::variation`] for the terms).
#[inline]
fn add_body<const N: usize>(
    link: &Link,
    at: &LinkMotion,
    a: &LinkAcceleration,
    gravity: &Vector3<f64>,
    S: &mut [Column; N],
) {
    let (m, c, w) = (link.mass, at.center, at.angular_velocity);
    let b = m * (a.linear - gravity);
    S[TURN].moment += twice(&b, &c);
    if N < MOVING {
        return;
    }
    let (C, J) = (m * c.cross_matrix(), at.inertia.matrix());
    let (dw, mw) = (a.angular, m * w);
    // δω × (ω × c) + ω × (δω × c) and the like
    let swinging = mw.cross(&c).cross_matrix() + twice(&mw, &c);
    let turned = |y: &Vector3<f64>| times_cross(&J, y) - (at.inertia * *y).cross_matrix();
    let spun = (turned(&w), at.inertia * w);
    S[TURN].force -= m * twice(&dw, &c) + cross_times(&w, &twice(&mw, &c));
    S[TURN].moment += turned(&dw) + cross_times(&w, &spun.0);
    S[RATE].force -= swinging;
    S[RATE].moment += cross_times(&w, &J) - spun.1.cross_matrix();
    S[TURN_ACCELERATION].force -= C;
    S[TURN_ACCELERATION].moment += J;
    S[ACCELERATION].force += Matrix3::from_diagonal_element(m);
    S[ACCELERATION].moment += C;
}
