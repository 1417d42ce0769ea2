//! The tangent in O(n): solves `(c₂ ∂r/∂q̈ + c₁ ∂r/∂q̇ + ∂r/∂q) δq = rhs` for the inverse dynamics residual `r`, by the
//! same reduction as the accelerations, applied to the variation of the marker state.
//!
//! A link sees its variations in axes that turn with it: `δ'x = δx − δθ × x`. There masses, arms and axes stand still, the
//! row of a hinge is its axis, and what is left of turns is what velocities and accelerations do.
//!
//! ```text
//! z = [δ'r̈, δ'ω̇ − δ'ω×ω, δ'ω, δθ, δr, δv]   varied state of a root marker; the last three where forces depend on them
//! (1) body     δ'f_R = S z_R + e             force: m 1,     −m [c]×,  −2m [ω×c]×
//!                                            moment: m [c]×,  J,        [ω]× (2J − tr J)
//! (2) hinge    z_R = T z_P + h δq            δ'r̈ gains δ'ω̇_P × d + 2 δ'ω_P × s,   s = ω_P × d + slip
//!     turn     h = [(r̈−g) × n, c₂ n + 2c₁ ω_P×n + ω̇_P×n + ω_P×(ω_P×n), c₁ n + ω_P×n, n, 0, 0]
//!     slide    h = [c₂ n + 2c₁ ω_P×n + ω̇_P×n + ω_P×(ω_P×n), 0, 0, 0, n, c₁ n + ω_P×n]
//!     screw    the turn's and p times the slide's; so are its row and its w
//! (3) row      Hᵀ δ'f_R + κ δq = rhs         κ: hinge spring, damper, armature, shift
//! (4)          D = Hᵀ S h + κ,   row = Hᵀ S
//! (5)          δq = D⁻¹ (u − row T z_P),   u = rhs − Hᵀ e
//! (6)          S_P += Xᵀ (S − w D⁻¹ row) T,   e_P += Xᵀ (e + w D⁻¹ u),   w = S h + [n × f; n × m] (slide: [0; n × f])
//! ```
//!
//! `w` is where it is not symmetric: what a hinge passes on turns with the link, and the parent does not. `Xᵀ` is the
//! shift of a wrench by the arm. At rest in equilibrium of loads with a potential the matrix is symmetric, and by Sylvester's
//! law the negative pivots `D` count its negative eigenvalues. Only the parts of `z` that a state needs are computed with
//! (`parts.rs`), and under weight alone nearly none (`weight.rs`).

mod applied;
mod block;
mod eliminate;
mod hinge;
mod matrix;
mod modal;
mod parts;
mod pivots;
mod rod;
mod twists;
mod weight;

pub use applied::{Applied, Column, Coupling};
pub use matrix::{Pair, TangentMatrix};
pub use twists::{Pull, Twists};

use super::balance::Balance;
use super::plan::{Kind, Place, To, plan};
use crate::model::Model;
use crate::motion::Motion;
use crate::pages::Pages;
use crate::spatial::Wrench;
use crate::spatial::quad::Quad;
use eliminate::{eliminate_ball, eliminate_one};
use hinge::{Around, Left, Three, Way};
use modal::ModalTangent;
use nalgebra::{Matrix3, Vector3};
use parts::{ACCELERATIONS, Carried, PLACES, RATES, Varied};
use pivots::Pivots;
use rod::RodTangent;
use std::ops::Range;
use weight::Weight;

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
    /// What they push on the links with, one per link.
    pub wrenches: &'a [Wrench],
    /// What force elements between a link and its parent add beside their `applied`: by link, one for each pair.
    pub coupled: &'a [(usize, Coupling)],
    /// Full 3×3 springs of balls, link axes: `−∂τ/∂(turn)` by link.
    pub ball_springs: &'a [(usize, Matrix3<f64>)],
}

/// The factorized tangent.
#[derive(Debug, Clone)]
pub struct Tangent {
    /// How the links hang together.
    plan: Pages<Place>,
    /// What arrives at links with several children from all but the first; nothing between two sweeps.
    joins: Vec<Carried>,
    /// Whether the last factorization broke down and may have left something there.
    broken: bool,
    left: Pages<Left>,
    balls: Vec<Three>,
    rods: Vec<RodTangent>,
    modals: Vec<ModalTangent>,
    /// Under weight alone.
    weight: Weight,
    /// Of every link what [`Joint::pitch`](crate::model::Joint::pitch) says; empty without screws.
    pitches: Vec<f64>,
    /// As `joins`, for right sides.
    loads: Vec<(Quad, Quad)>,
    z: Pages<Varied>,
    /// Negative pivots.
    negative: usize,
    /// Which parts of `z` take part; none under weight alone.
    parts: u8,
}

/// A pivot that is zero or not finite: the link it belongs to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Breakdown {
    /// The link.
    pub link: usize,
    /// For a ball, the axis about which it gives way, inertial axes.
    pub axis: Option<Vector3<f64>>,
}

/// Calls a sweep for the parts that take part.
macro_rules! with_parts {
    ($parts:expr, $self:ident . $sweep:ident ($($argument:expr),*)) => {
        match $parts {
            PLACES => $self.$sweep::<PLACES>($($argument),*),
            ACCELERATIONS => $self.$sweep::<ACCELERATIONS>($($argument),*),
            MOVING => $self.$sweep::<MOVING>($($argument),*),
            STILL_IN_PLACE => $self.$sweep::<STILL_IN_PLACE>($($argument),*),
            _ => $self.$sweep::<{ MOVING | PLACES }>($($argument),*),
        }
    };
}

const MOVING: u8 = ACCELERATIONS | RATES;
const STILL_IN_PLACE: u8 = ACCELERATIONS | PLACES;

impl Tangent {
    /// Room for a model's links.
    pub fn new(model: &Model) -> Self {
        let n = model.links.len();
        let (plan, joins, balls) = plan(model);
        let has_screws = plan.iter().any(|place| place.kind == Kind::Screw);
        let pitches = model.links.iter().take(if has_screws { n } else { 0 }).map(|link| link.joint.pitch()).collect();
        Self {
            plan,
            pitches,
            joins: vec![Carried::default(); joins],
            broken: false,
            left: Pages::filled(Left::default(), n),
            balls: vec![Three::default(); balls],
            rods: model.rods.iter().map(RodTangent::new).collect(),
            modals: model.modals.iter().map(|modal| ModalTangent::new(&modal.modal)).collect(),
            weight: Weight::default(),
            loads: vec![(Quad::default(), Quad::default()); joins],
            z: Pages::filled(Varied::default(), n),
            negative: 0,
            parts: 0,
        }
    }

    /// Number of negative pivots: at an equilibrium with a potential, of negative eigenvalues.
    pub fn negative_pivots(&self) -> usize {
        self.negative
    }

    /// Tips → root: eqs. (4) and (6). With `definite` it stops at the first pivot that is not positive.
    ///
    /// # Errors
    /// A pivot that is zero or not finite, or negative where a definite matrix is wanted.
    pub fn factorize(&mut self, model: &Model, at: &At<'_>, definite: bool) -> Result<(), Breakdown> {
        let placed = !at.applied.is_empty() || model.rods.iter().any(|rod| rod.load != Vector3::zeros());
        let accelerated = !model.rods.is_empty()
            || !model.modals.is_empty()
            || !at.motion.still
            || at.c1 != 0.0
            || at.c2 != 0.0
            || at.hinge.iter().any(|a| *a != 0.0);
        let rated = !at.motion.still || (at.c1 != 0.0 && placed);
        self.parts = [(accelerated, ACCELERATIONS), (rated, RATES), (placed, PLACES)]
            .iter()
            .map(|(there, part)| if *there { *part } else { 0 })
            .sum();
        self.negative = 0;
        if self.parts == 0 {
            self.negative = self.weight.factorize(model, &self.plan, at, definite)?;
            return Ok(());
        }
        with_parts!(self.parts, self.inward(model, at, definite))
    }

    fn inward<const PARTS: u8>(&mut self, model: &Model, at: &At<'_>, definite: bool) -> Result<(), Breakdown> {
        // What a breakdown left behind.
        if std::mem::replace(&mut self.broken, true) {
            self.joins.fill(Carried::default());
        }
        self.modals.iter_mut().for_each(ModalTangent::clear);
        let mut springs = at.ball_springs.iter().rev().peekable();
        let mut forces = at.applied.iter().rev().peekable();
        let mut couplings = at.coupled.iter().rev().peekable();
        let mut S = Carried::default();
        for index in (1..self.plan.len()).rev() {
            let (place, own) = (self.plan[index], &at.motion.links[index]);
            if place.is_leaf {
                S.each::<PARTS>(|block| *block = Default::default());
            } else if let Some(join) = place.join {
                S.add::<PARTS>(&std::mem::take(&mut self.joins[join as usize]));
            }
            let parent = place.parent as usize;
            let around = Around::new(at, (&at.balance.accelerations[index], own), parent, &model.gravity);
            if !place.is_massless {
                S.add_body::<PARTS>(&model.links[index], own, around.b);
            }
            if PARTS & PLACES != 0 && forces.peek().is_some_and(|(link, _)| *link == index) {
                while let Some((_, blocks)) = forces.next_if(|(link, _)| *link == index) {
                    S.take_applied::<PARTS>(blocks);
                }
                S.take_turned(&at.wrenches[index]);
            }
            let coupling = match PARTS & PLACES {
                0 => None,
                _ => couplings.next_if(|(link, _)| *link == index).map(|(_, coupling)| coupling),
            };
            let f = &at.balance.reactions[index];
            let first = place.velocity as usize;
            let left = &mut self.left[index];
            let way = Way::of(place.kind, &self.pitches, index);
            (left.arm, left.swing) = (own.arm, around.swing(own, way));
            match place.kind {
                Kind::None => {}
                Kind::Turn | Kind::Slide | Kind::Screw => {
                    left.axis = Quad::of(&own.axis);
                    left.h = around.one::<PARTS>(left.axis, way);
                    let D = eliminate_one::<PARTS>(left, way, &mut S, f, at.diagonal[first], coupling)
                        .filter(|D| !definite || *D > 0.0)
                        .ok_or(Breakdown { link: index, axis: None })?;
                    self.negative += usize::from(D < 0.0);
                }
                Kind::Ball => {
                    let ball = &mut self.balls[place.ball as usize];
                    (ball.turn, ball.h) = (own.turn, around.three());
                    let spring = springs.next_if(|(link, _)| *link == index).map(|(_, spring)| spring);
                    let kappa = ball_kappa(at, &own.turn, first, spring);
                    let negative = eliminate_ball::<PARTS>(left, ball, &mut S, f, kappa.as_ref(), coupling)
                        .map_err(|axis| Breakdown { link: index, axis: Some(axis) })?;
                    if definite && let Some(axis) = negative.first() {
                        return Err(Breakdown { link: index, axis: Some(*axis) });
                    }
                    self.negative += negative.len();
                }
                Kind::Flex => {
                    self.flexible::<PARTS>(model, at, index, definite, &mut S)?;
                    continue;
                }
                Kind::Interface => {
                    let Some((modal, tip)) = model.links[index].joint.interface() else { continue };
                    left.swing = self.modals[modal].interface::<PARTS>(model, at, (modal, tip, index), &S);
                }
                Kind::Modal => {
                    self.modal::<PARTS>(model, at, (place.ball as usize, index), definite, &mut S)?;
                }
            }
            if matches!(place.to, To::Ground) {
                continue;
            }
            S.shift::<PARTS>(&own.arm);
            S.compose::<PARTS>(&own.arm, &self.left[index].swing);
            if let To::Join(join) = place.to {
                self.joins[join as usize].add::<PARTS>(&S);
            }
        }
        self.broken = false;
        Ok(())
    }

    /// Eqs. (4) and (6) for the coordinates of a modal body, whose index and link are given.
    fn modal<const PARTS: u8>(
        &mut self,
        model: &Model,
        at: &At<'_>,
        (modal, index): (usize, usize),
        definite: bool,
        S: &mut Carried,
    ) -> Result<(), Breakdown> {
        let negative = self.modals[modal].eliminate::<PARTS>(model, at, (modal, index), S);
        let negative = negative.filter(|negative| !definite || *negative == 0);
        self.negative += negative.ok_or(Breakdown { link: index, axis: None })?;
        Ok(())
    }

    /// Eqs. (4) and (6) across a flexible element: `S` of its tip in, that of its parent out.
    fn flexible<const PARTS: u8>(
        &mut self,
        model: &Model,
        at: &At<'_>,
        index: usize,
        definite: bool,
        S: &mut Carried,
    ) -> Result<(), Breakdown> {
        let place = self.plan[index];
        let eliminated = &mut self.rods[place.ball as usize];
        let negative = eliminated
            .eliminate::<PARTS>(model, at, (place.ball as usize, index), S)
            .filter(|negative| !definite || *negative == 0)
            .ok_or(Breakdown { link: index, axis: None })?;
        self.left[index].swing = eliminated.swing;
        self.negative += negative;
        if let To::Join(join) = place.to {
            self.joins[join as usize].add::<PARTS>(S);
        }
        Ok(())
    }

    /// A direction `x` with `xᵀ K x < 0`, after a factorization for a definite matrix broke down at a hinge: that hinge
    /// moves, everything outboard of it follows as it likes best, the rest stays. Then `xᵀ K x` is the pivot `D`.
    pub fn negative_direction(&mut self, model: &Model, breakdown: Breakdown, x: &mut [f64]) {
        x.fill(0.0);
        let (root, outboard) = (breakdown.link, breakdown.link + 1..model.links[breakdown.link].subtree_end);
        if self.parts == 0 {
            return self.weight.negative_direction(&self.plan, breakdown, outboard, x);
        }
        let (place, mut z) = (self.plan[root], Varied::default());
        let first = place.velocity as usize;
        match breakdown.axis {
            None if place.kind == Kind::Modal => {
                self.modals[place.ball as usize].negative_direction(&mut x[first..]);
            }
            None if place.kind == Kind::Flex => {
                z = self.rods[place.ball as usize].negative_direction(&mut x[first..]);
            }
            None => {
                x[first] = 1.0;
                z = self.left[root].h;
            }
            Some(axis) => {
                let ball = &self.balls[place.ball as usize];
                x[first..first + 3].copy_from_slice(ball.turn.tr_mul(&axis).as_slice());
                ball.turn_by(&mut z, Quad::of(&axis));
            }
        }
        self.z[root] = z;
        for index in outboard.clone() {
            self.left[index].u = 0.0;
            match self.plan[index].kind {
                Kind::Ball => self.balls[self.plan[index].ball as usize].u = Quad::default(),
                Kind::Flex => self.rods[self.plan[index].ball as usize].u.fill(0.0),
                Kind::Modal => self.modals[self.plan[index].ball as usize].u.fill(0.0),
                _ => {}
            }
        }
        with_parts!(self.parts, self.outward(outboard, x));
    }

    /// Eqs. (5) and (6) for one right side, in place.
    pub fn solve(&mut self, x: &mut [f64]) {
        self.solve_loaded(None, x);
    }

    /// As [`Tangent::solve`], with a wrench on one link in addition to the hinge forces: only where force elements depend on
    /// places.
    pub fn solve_loaded(&mut self, load: Option<(usize, Wrench)>, x: &mut [f64]) {
        if self.parts == 0 {
            return self.weight.solve(&self.plan, x);
        }
        self.load(load, x);
        self.z[0] = Varied::default();
        with_parts!(self.parts, self.outward(1..self.plan.len(), x));
    }

    /// How a link's `δθ`, `δr`, `δ'ω` and `δv` are in the last solution, where force elements depend on them: as in
    /// [`Applied`].
    pub fn variation(&self, link: usize) -> [Vector3<f64>; 4] {
        let z = &self.z[link];
        [z.turn, z.place, z.rate, z.speed].map(Quad::vector)
    }

    /// Tips → root: eq. (6) for `e`.
    fn load(&mut self, load: Option<(usize, Wrench)>, x: &[f64]) {
        let nothing = (Quad::default(), Quad::default());
        let (mut force, mut moment) = nothing;
        for (index, (place, left)) in self.plan.iter().zip(&mut self.left).enumerate().skip(1).rev() {
            if place.is_leaf {
                (force, moment) = nothing;
            } else if let Some(join) = place.join {
                let (more_force, more_moment) = std::mem::take(&mut self.loads[join as usize]);
                (force, moment) = (force + more_force, moment + more_moment);
            }
            if let Some((_, wrench)) = load.filter(|(link, _)| *link == index) {
                (force, moment) = (force - Quad::of(&wrench.force), moment - Quad::of(&wrench.moment));
            }
            let first = place.velocity as usize;
            match place.kind {
                Kind::None => {}
                Kind::Turn | Kind::Slide | Kind::Screw => {
                    left.u = x[first] - Way::of(place.kind, &self.pitches, index).project(left.axis, force, moment);
                    let step = Quad::all(left.inverse * left.u);
                    (force, moment) = (step.times_add(left.w.0, force), step.times_add(left.w.1, moment));
                }
                Kind::Ball => {
                    let ball = &mut self.balls[place.ball as usize];
                    if let Some(pivots) = &ball.pivots {
                        let given = Quad::of(&(ball.turn * Vector3::new(x[first], x[first + 1], x[first + 2])));
                        ball.u = pivots.forward(given - moment);
                        let step = ball.u.vector();
                        // e + w D⁻¹ u = rhs − (D − w) D⁻¹ u
                        (force, moment) = (ball.force.times_add(&step, force), given - ball.kept.times(&step));
                    }
                }
                Kind::Flex => (force, moment) = self.rods[place.ball as usize].load(&x[first..], (force, moment)),
                Kind::Interface => {
                    self.modals[place.ball as usize].load_interface(place.tip as usize, (force, moment));
                }
                Kind::Modal => {
                    (force, moment) = self.modals[place.ball as usize].load(&x[first..], (force, moment));
                }
            }
            moment = Quad::of(&left.arm).cross_add(force, moment);
            if let To::Join(join) = place.to {
                let sum = &mut self.loads[join as usize];
                *sum = (sum.0 + force, sum.1 + moment);
            }
        }
    }

    /// Root → tips: eqs. (2) and (5).
    fn outward<const PARTS: u8>(&mut self, range: Range<usize>, x: &mut [f64]) {
        let mut before = self.z[range.start - 1];
        for index in range {
            let (place, left) = (&self.plan[index], &self.left[index]);
            let parent = place.parent as usize;
            // Along a chain the parent's state is still in registers.
            let inboard = if parent + 1 == index { &before } else { &self.z[parent] };
            let mut z = left.carry::<PARTS>(inboard);
            let first = place.velocity as usize;
            match place.kind {
                Kind::None => {}
                Kind::Turn | Kind::Slide | Kind::Screw => {
                    let step = left.inverse * (left.u - left.row.dot::<PARTS>(&z));
                    x[first] = step;
                    z.add_times::<PARTS>(step, &left.h);
                }
                Kind::Ball => {
                    let ball = &self.balls[place.ball as usize];
                    let left = |pivots: &Pivots| pivots.backward(ball.u - ball.seen::<PARTS>(&z));
                    let phi = ball.pivots.as_ref().map_or(Quad::default(), left);
                    x[first..first + 3].copy_from_slice(ball.turn.tr_mul(&phi.vector()).as_slice());
                    ball.turn_by(&mut z, phi);
                }
                Kind::Flex => self.rods[place.ball as usize].solve::<PARTS>(inboard, &mut x[first..], &mut z),
                Kind::Modal => self.modals[place.ball as usize].solve::<PARTS>(&z, &mut x[first..]),
                Kind::Interface => {
                    self.modals[place.ball as usize].follow::<PARTS>(place.tip as usize, &x[first..], &mut z);
                }
            }
            if PARTS & PLACES != 0 || place.join.is_some() {
                self.z[index] = z;
            }
            before = z;
        }
    }
}

/// `κ` of a ball, inertial axes; `None` for one that is held.
fn ball_kappa(at: &At<'_>, turn: &Matrix3<f64>, first: usize, spring: Option<&Matrix3<f64>>) -> Option<Matrix3<f64>> {
    let diagonal = Vector3::new(at.diagonal[first], at.diagonal[first + 1], at.diagonal[first + 2]);
    if diagonal.x.is_infinite() {
        return None;
    }
    if diagonal == Vector3::zeros() && spring.is_none() {
        return Some(Matrix3::zeros());
    }
    let kappa = Matrix3::from_diagonal(&diagonal) + spring.unwrap_or(&Matrix3::zeros());
    Some(turn * kappa * turn.transpose())
}
