//! The tangent in O(n): solves `(c₂ ∂r/∂q̈ + c₁ ∂r/∂q̇ + ∂r/∂q) δq = rhs` for the inverse dynamics residual `r`, by the
//! same reduction as the accelerations, applied to the variation of the marker state.
//!
//! ```text
//! z = [δθ, δr, δω, δv, δω̇, δr̈]            variation of a root marker's state, 18
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

use super::balance::Balance;
use crate::model::{Joint, Link, Model};
use crate::motion::variation::{LinkAcceleration, LinkVariation};
use crate::motion::{LinkMotion, Motion};
use crate::spatial::Wrench;
use nalgebra::{Matrix3, Vector3};

/// Block columns of `S`, in the order of `z`.
const TURN: usize = 0;
const RATE: usize = 2;
const TURN_ACCELERATION: usize = 4;
const ACCELERATION: usize = 5;

/// Force and moment from one block of `z`: 6×3.
#[derive(Debug, Clone, Copy, Default)]
pub struct Column {
    /// Upper three rows.
    pub force: Matrix3<f64>,
    /// Lower three rows.
    pub moment: Matrix3<f64>,
}

/// How the wrench at a root marker varies with the marker's state: the blocks of `S`, 6×18.
pub type Blocks = [Column; 6];

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
    /// How force elements load the link they are attached to when it moves: subtracted from `S`; empty for none.
    pub applied: &'a [(usize, Blocks)],
    /// Full 3×3 springs of balls, link axes: `−∂τ/∂(turn)` by link.
    pub ball_springs: &'a [(usize, Matrix3<f64>)],
}

/// The factorized tangent.
#[derive(Debug, Clone)]
pub struct Tangent {
    S: Vec<Blocks>,
    /// The point of the tangent, for the solutions that follow.
    at: Vec<Hinge>,
    hinges: Vec<Eliminated>,
    e: Vec<Wrench>,
    u: Vec<Vector3<f64>>,
    z: Vec<LinkVariation>,
    /// Negative pivots.
    negative: usize,
    /// Whether velocities or accelerations take part.
    dynamic: bool,
}

/// What is left of a hinge after its elimination.
#[derive(Debug, Clone, Copy)]
enum Eliminated {
    None,
    One { w: Wrench, row: [Vector3<f64>; 6], inverse: f64 },
    Three { w: Column, row: [Matrix3<f64>; 6], inverse: Matrix3<f64> },
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
        Self {
            S: vec![Blocks::default(); n],
            at: vec![Hinge::default(); n],
            hinges: vec![Eliminated::None; n],
            e: vec![Wrench::ZERO; n],
            u: vec![Vector3::zeros(); n],
            z: vec![LinkVariation::default(); n],
            negative: 0,
            dynamic: false,
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
        self.dynamic = at.c1 != 0.0 || at.c2 != 0.0 || moving || accelerating;
        self.negative = 0;
        for index in 1..model.links.len() {
            self.S[index] = body(
                &model.links[index],
                &at.motion.links[index],
                &at.balance.accelerations[index],
                &model.gravity,
                self.dynamic,
            );
        }
        for (link, blocks) in at.applied {
            for (sum, block) in self.S[*link].iter_mut().zip(blocks) {
                sum.force -= block.force;
                sum.moment -= block.moment;
            }
        }
        let mut balls = at.ball_springs.iter().rev().peekable();
        for index in (1..model.links.len()).rev() {
            let spring = balls.next_if(|(link, _)| *link == index).map(|(_, spring)| *spring);
            self.eliminate(model, at, index, spring, definite)?;
        }
        Ok(())
    }

    /// One hinge; the breakdown where its pivot does not do.
    fn eliminate(
        &mut self,
        model: &Model,
        at: &At<'_>,
        index: usize,
        spring: Option<Matrix3<f64>>,
        definite: bool,
    ) -> Result<(), Breakdown> {
        let link = &model.links[index];
        let hinge = Hinge::new(link, at, index);
        self.at[index] = hinge;
        let own = self.S[index];
        let mut across = own;
        hinge.compose(&mut across, self.dynamic);
        let f = &at.balance.reactions[index];
        let (first, d) = (link.velocity, hinge.arm);
        let (eliminated, negative) = match link.joint {
            Joint::None => (Eliminated::None, NegativeAxes::default()),
            Joint::Turn { .. } | Joint::Slide { .. } => eliminate_one(&hinge, &own, &mut across, f, at.diagonal[first])
                .ok_or(Breakdown { link: index, axis: None })?,
            Joint::Ball { .. } => {
                let turn = &hinge.turn;
                let mut kappa = Matrix3::from_diagonal(&Vector3::from_fn(|i, _| at.diagonal[first + i]));
                kappa += spring.unwrap_or_else(Matrix3::zeros);
                let held = at.diagonal[first].is_infinite();
                eliminate_ball(&hinge, &own, &mut across, f, &(turn * kappa * turn.transpose()), held)
                    .map_err(|axis| Breakdown { link: index, axis: Some(axis) })?
            }
        };
        if definite && let Some(axis) = negative.first() {
            return Err(Breakdown { link: index, axis: matches!(link.joint, Joint::Ball { .. }).then_some(*axis) });
        }
        self.negative += negative.len();
        self.hinges[index] = eliminated;
        // (7): (δθ × d) × f = [f]× [d]× δθ
        across[TURN].moment += f.force.cross_matrix() * d.cross_matrix();
        if link.parent != 0 {
            for (sum, block) in self.S[link.parent].iter_mut().zip(&across) {
                sum.force += block.force;
                sum.moment += block.moment;
            }
        }
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
        for index in root + 1..model.links[root].subtree_end {
            self.u[index] = Vector3::zeros();
            self.step_outward(model, index, x);
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
                Eliminated::One { w, inverse, .. } => {
                    let u = x[link.velocity] - super::along(&link.joint, &own.axis, &e);
                    self.u[index].x = u;
                    passed += Wrench { force: (inverse * u) * w.force, moment: (inverse * u) * w.moment };
                }
                Eliminated::Three { w, inverse, .. } => {
                    let rhs = Vector3::new(x[link.velocity], x[link.velocity + 1], x[link.velocity + 2]);
                    let u = own.turn * rhs - e.moment;
                    self.u[index] = u;
                    let step = inverse * u;
                    passed += Wrench { force: w.force * step, moment: w.moment * step };
                }
            }
            self.e[link.parent] += passed;
        }
        for index in 1..model.links.len() {
            self.step_outward(model, index, x);
        }
    }

    /// Eqs. (5) and (2) for one hinge.
    #[inline]
    fn step_outward(&mut self, model: &Model, index: usize, x: &mut [f64]) {
        let link = &model.links[index];
        let parent = self.z[link.parent];
        let hinge = &self.at[index];
        let mut z = hinge.carry(&parent, self.dynamic);
        match &self.hinges[index] {
            Eliminated::None => {}
            Eliminated::One { row, inverse, .. } => {
                let step = inverse * (self.u[index].x - dot(row, &parent, self.dynamic));
                x[link.velocity] = step;
                hinge.add_one(&mut z, step);
            }
            Eliminated::Three { row, inverse, .. } => {
                let step = inverse * (self.u[index] - times(row, &parent, self.dynamic));
                let local = hinge.turn.tr_mul(&step);
                x[link.velocity..link.velocity + 3].copy_from_slice(local.as_slice());
                hinge.add_ball(&mut z, &step);
            }
        }
        self.z[index] = z;
    }
}

/// `S` of eq. (1): the variation of the body's wrench (see [`super::variation`] for the terms).
fn body(link: &Link, at: &LinkMotion, a: &LinkAcceleration, gravity: &Vector3<f64>, dynamic: bool) -> Blocks {
    let mut S = Blocks::default();
    if link.is_massless() {
        return S;
    }
    let (m, c, w) = (link.mass, at.center, at.angular_velocity);
    let C = c.cross_matrix();
    S[TURN].moment = m * (a.linear - gravity).cross_matrix() * C;
    if !dynamic {
        return S;
    }
    let (W, J) = (w.cross_matrix(), at.inertia.matrix());
    let varied = |y: Vector3<f64>| J * y.cross_matrix() - (at.inertia * y).cross_matrix();
    S[TURN].force = -m * (a.angular.cross_matrix() + W * W) * C;
    S[TURN].moment += varied(a.angular) + W * varied(w);
    S[RATE].force = -m * (w.cross(&c).cross_matrix() + W * C);
    S[RATE].moment = W * J - (at.inertia * w).cross_matrix();
    S[TURN_ACCELERATION] = Column { force: -m * C, moment: J };
    S[ACCELERATION] = Column { force: m * Matrix3::identity(), moment: m * C };
    S
}

/// One hinge at the point of the tangent: `T` and `h` of eq. (2).
#[derive(Debug, Clone, Copy, Default)]
struct Hinge {
    slides: bool,
    turn: Matrix3<f64>,
    axis: Vector3<f64>,
    arm: Vector3<f64>,
    /// Angular velocity and acceleration of the parent.
    w: Vector3<f64>,
    dw: Vector3<f64>,
    /// Relative motion: turning and its rate, sliding and its rate.
    spin: Vector3<f64>,
    spin_rate: Vector3<f64>,
    slip: Vector3<f64>,
    slip_rate: Vector3<f64>,
    c1: f64,
    c2: f64,
}

impl Hinge {
    fn new(link: &Link, at: &At<'_>, index: usize) -> Self {
        let own = &at.motion.links[index];
        let zero = Vector3::zeros();
        let first = link.velocity;
        let (spin, spin_rate, slip, slip_rate) = match link.joint {
            Joint::None => (zero, zero, zero, zero),
            Joint::Turn { .. } => (own.relative, own.axis * at.hinge[first], zero, zero),
            Joint::Slide { .. } => (zero, zero, own.relative, own.axis * at.hinge[first]),
            Joint::Ball { .. } => {
                let local = Vector3::new(at.hinge[first], at.hinge[first + 1], at.hinge[first + 2]);
                (own.relative, own.turn * local, zero, zero)
            }
        };
        Self {
            slides: matches!(link.joint, Joint::Slide { .. }),
            turn: own.turn,
            axis: own.axis,
            arm: own.arm,
            w: at.motion.links[link.parent].angular_velocity,
            dw: at.balance.accelerations[link.parent].angular,
            spin,
            spin_rate,
            slip,
            slip_rate,
            c1: at.c1,
            c2: at.c2,
        }
    }

    /// `S ← Xᵀ S T`.
    fn compose(&self, S: &mut Blocks, dynamic: bool) {
        let d = &self.arm;
        let [mut turn, position, mut rate, velocity, mut turn_acceleration, acceleration] = *S;
        turn.minus_cross(&position, d);
        if dynamic {
            let (W, D) = (self.w.cross_matrix(), d.cross_matrix());
            let swing = self.w.cross(d);
            let swinging = W * D + self.slip.cross_matrix();
            turn.minus_cross(&rate, &self.spin);
            turn.minus(&velocity, &swinging);
            turn.minus(&turn_acceleration, &(self.spin_rate.cross_matrix() + W * self.spin.cross_matrix()));
            let by_turn =
                self.dw.cross_matrix() * D + W * (swinging + self.slip.cross_matrix()) + self.slip_rate.cross_matrix();
            turn.minus(&acceleration, &by_turn);
            rate.minus_cross(&velocity, d);
            rate.minus_cross(&turn_acceleration, &self.spin);
            rate.minus(&acceleration, &((swing + 2.0 * self.slip).cross_matrix() + W * D));
            turn_acceleration.minus_cross(&acceleration, d);
        }
        *S = [turn, position, rate, velocity, turn_acceleration, acceleration];
        for column in S.iter_mut() {
            column.shift(d);
        }
    }

    /// `S h` for one coordinate.
    fn reach_one(&self, S: &Blocks) -> Wrench {
        let mut h = LinkVariation::default();
        self.add_one(&mut h, 1.0);
        apply(S, &h)
    }

    /// `z += h δq` for one coordinate.
    fn add_one(&self, z: &mut LinkVariation, step: f64) {
        let (c1, c2) = (self.c1, self.c2);
        let n = self.axis * step;
        let wn = self.w.cross(&n);
        if self.slides {
            z.position += n;
            z.velocity += c1 * n + wn;
            z.acceleration += c2 * n + self.dw.cross(&n) + self.w.cross(&(wn + 2.0 * c1 * n));
        } else {
            z.turn += n;
            z.angular_velocity += c1 * n;
            z.angular_acceleration += c2 * n + c1 * wn;
        }
    }

    /// `z += h φ` for a ball turned by `φ`, inertial axes.
    fn add_ball(&self, z: &mut LinkVariation, phi: &Vector3<f64>) {
        let spin = self.c1 * phi + phi.cross(&self.spin);
        z.turn += phi;
        z.angular_velocity += spin;
        z.angular_acceleration += self.c2 * phi + phi.cross(&self.spin_rate) + self.w.cross(&spin);
    }

    /// `T z_P`.
    fn carry(&self, p: &LinkVariation, dynamic: bool) -> LinkVariation {
        let d = &self.arm;
        let arm = p.turn.cross(d);
        let mut z = LinkVariation { turn: p.turn, position: p.position + arm, ..LinkVariation::default() };
        if dynamic {
            let (w, dw) = (self.w, p.angular_velocity);
            let (spin, slip) = (p.turn.cross(&self.spin), p.turn.cross(&self.slip));
            let swing = dw.cross(d) + w.cross(&arm);
            z.angular_velocity = dw + spin;
            z.velocity = p.velocity + swing + slip;
            z.angular_acceleration =
                p.angular_acceleration + p.turn.cross(&self.spin_rate) + dw.cross(&self.spin) + w.cross(&spin);
            z.acceleration = p.acceleration
                + p.angular_acceleration.cross(d)
                + self.dw.cross(&arm)
                + dw.cross(&(w.cross(d) + 2.0 * self.slip))
                + w.cross(&(swing + 2.0 * slip))
                + p.turn.cross(&self.slip_rate);
        }
        z
    }
}

/// Eqs. (4) and (6) for one coordinate: `across ← Xᵀ S T − w D⁻¹ row`.
fn eliminate_one(
    hinge: &Hinge,
    own: &Blocks,
    across: &mut Blocks,
    f: &Wrench,
    kappa: f64,
) -> Option<(Eliminated, NegativeAxes)> {
    let (n, d, slides) = (hinge.axis, &hinge.arm, hinge.slides);
    let reach = hinge.reach_one(own);
    let D = kappa + if slides { n.dot(&reach.force) } else { n.dot(&reach.moment) };
    if D == 0.0 || D.is_nan() {
        return None;
    }
    // Zero for a coordinate that is held.
    let inverse = 1.0 / D;
    // The row of Xᵀ S T: the shift leaves forces as they are, and takes d × force off the moments.
    let mut row = across.map(|column| match slides {
        true => column.force.tr_mul(&n),
        false => (column.moment - d.cross_matrix() * column.force).tr_mul(&n),
    });
    row[TURN] += if slides { n.cross(&f.force) } else { n.cross(&f.moment) };
    let mut w = reach.shifted(*d);
    if slides {
        w.moment += n.cross(&f.force);
    }
    for (column, row) in across.iter_mut().zip(&row) {
        column.force -= (inverse * w.force) * row.transpose();
        column.moment -= (inverse * w.moment) * row.transpose();
    }
    let negative = if D < 0.0 { NegativeAxes::one(n) } else { NegativeAxes::default() };
    Some((Eliminated::One { w, row, inverse }, negative))
}

/// Eqs. (4) and (6) for a ball, in inertial axes; `kappa` likewise.
fn eliminate_ball(
    hinge: &Hinge,
    own: &Blocks,
    across: &mut Blocks,
    f: &Wrench,
    kappa: &Matrix3<f64>,
    held: bool,
) -> Result<(Eliminated, NegativeAxes), Vector3<f64>> {
    let d = &hinge.arm;
    let mut reach = Column::default();
    for axis in 0..3 {
        let mut h = LinkVariation::default();
        hinge.add_ball(&mut h, &Vector3::ith(axis, 1.0));
        let wrench = apply(own, &h);
        reach.force.set_column(axis, &wrench.force);
        reach.moment.set_column(axis, &wrench.moment);
    }
    let turned = f.moment.cross_matrix();
    let D = reach.moment + turned + kappa;
    let inverse = match held {
        true => Matrix3::zeros(),
        false => D
            .try_inverse()
            .filter(|inverse| inverse.iter().all(|x| x.is_finite()))
            .ok_or(hinge.turn.column(0).into_owned())?,
    };
    let mut row = across.map(|column| column.moment - d.cross_matrix() * column.force);
    row[TURN] += turned;
    reach.shift(d);
    let weighted = Column { force: reach.force * inverse, moment: reach.moment * inverse };
    for (column, row) in across.iter_mut().zip(&row) {
        column.force -= weighted.force * row;
        column.moment -= weighted.moment * row;
    }
    let negative = if held { NegativeAxes::default() } else { NegativeAxes::of(&D) };
    Ok((Eliminated::Three { w: reach, row, inverse }, negative))
}

/// The directions in which one hinge's pivot is negative: at most three, no memory asked for.
#[derive(Debug, Clone, Copy, Default)]
struct NegativeAxes {
    axes: [Vector3<f64>; 3],
    count: usize,
}

impl NegativeAxes {
    fn one(axis: Vector3<f64>) -> Self {
        Self { axes: [axis, Vector3::zeros(), Vector3::zeros()], count: 1 }
    }

    /// Eigenvectors of negative eigenvalues of the symmetric part; none for a positive definite one.
    fn of(D: &Matrix3<f64>) -> Self {
        let part = crate::spatial::Sym3::symmetric_part(D);
        if part.inverse().is_some_and(|(_, pivots)| pivots.min() > 0.0) {
            return Self::default();
        }
        let eigen = part.matrix().symmetric_eigen();
        let mut found = Self::default();
        for i in 0..3 {
            if eigen.eigenvalues[i] < 0.0 {
                found.axes[found.count] = eigen.eigenvectors.column(i).into_owned();
                found.count += 1;
            }
        }
        found
    }

    fn len(&self) -> usize {
        self.count
    }

    fn first(&self) -> Option<&Vector3<f64>> {
        self.axes[..self.count].first()
    }
}

impl Column {
    /// `self −= other [d]×`.
    #[inline]
    fn minus_cross(&mut self, other: &Self, d: &Vector3<f64>) {
        self.force -= times_cross(&other.force, d);
        self.moment -= times_cross(&other.moment, d);
    }

    /// `self −= other M`.
    #[inline]
    fn minus(&mut self, other: &Self, matrix: &Matrix3<f64>) {
        self.force -= other.force * matrix;
        self.moment -= other.moment * matrix;
    }

    /// `self ← Xᵀ self`: the moment gains `d × force`.
    #[inline]
    fn shift(&mut self, d: &Vector3<f64>) {
        for i in 0..3 {
            let gain = d.cross(&self.force.column(i));
            let mut column = self.moment.column_mut(i);
            column += gain;
        }
    }
}

/// `Y [d]×`, column by column.
#[inline]
fn times_cross(y: &Matrix3<f64>, d: &Vector3<f64>) -> Matrix3<f64> {
    let (a, b, c) = (y.column(0), y.column(1), y.column(2));
    Matrix3::from_columns(&[b * d.z - c * d.y, c * d.x - a * d.z, a * d.y - b * d.x])
}

/// The blocks of `z` in the order of the columns.
#[inline]
fn blocks(z: &LinkVariation) -> [Vector3<f64>; 6] {
    [z.turn, z.position, z.angular_velocity, z.velocity, z.angular_acceleration, z.acceleration]
}

/// `S z`.
#[inline]
fn apply(S: &Blocks, z: &LinkVariation) -> Wrench {
    let mut sum = Wrench::ZERO;
    for (column, z) in S.iter().zip(blocks(z)) {
        sum.force += column.force * z;
        sum.moment += column.moment * z;
    }
    sum
}

#[inline]
fn dot(row: &[Vector3<f64>; 6], z: &LinkVariation, dynamic: bool) -> f64 {
    let count = if dynamic { 6 } else { 2 };
    row.iter().zip(blocks(z)).take(count).map(|(row, z)| row.dot(&z)).sum()
}

#[inline]
fn times(row: &[Matrix3<f64>; 6], z: &LinkVariation, dynamic: bool) -> Vector3<f64> {
    let count = if dynamic { 6 } else { 2 };
    row.iter().zip(blocks(z)).take(count).map(|(row, z)| row * z).sum()
}
