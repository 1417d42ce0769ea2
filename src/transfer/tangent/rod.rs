//! The elimination of a flexible element in the tangent: eqs. (2) to (6) of the parent module with m coordinates and K steps.
//!
//! ```text
//! with φ = Z δq, y = δ'W, ẏ = δ'Ẇ of a step in turning axes, (v, w) = W, and ω, ω̇, r̈ of the station before it
//! (7) h   θ  φ_ω                     ω  y_ω + ω×φ_ω           ω̇  ẏ_ω + ω̇×φ_ω + 2 ω×y_ω + w×y_ω + ω×(ω×φ_ω)
//!         r  φ_v                     v  y_v + ω×φ_v + φ_ω×v
//!         r̈  (r̈ − g + ω̇×d + ω×(ω×d))×φ_ω + 2 (ω×φ_ω)×v + ω̇×φ_v + ω×(ω×φ_v) + 2 ω×y_v + y_ω×v + w×y_v + ẏ_v
//!     y = Ż + c₁ Z + [W, Z],   ẏ = Z̈ + 2c₁ Ż + c₂ Z + [Ẇ, Z] + [W, Ż + c₁ Z]             column by column
//! (8) f = S z + N δq + e,   r = row z + P δq:   N += S h,   P += row h + Zᵀ N + Γ,   row += Zᵀ S
//!     N += [φ_ω×F; φ_ω×M + φ_v×F],   then all shifted as across a hinge
//! (9) D = P + (1 + η c₁) Kₑ + shift,   S ← S − N D⁻¹ row
//! ```

use super::At;
use super::block::FlexBlock;
use super::parts::{ACCELERATIONS, Carried, PLACES, RATES, Varied};
use crate::element::{Local, Rod, RodMotion, bracket, halves, joined, row};
use crate::model::Model;
use crate::spatial::Wrench;
use crate::spatial::quad::{Quad, wrench};
use crate::transfer::LinkAcceleration;
use nalgebra::{Vector3, Vector6};

/// An element, eliminated.
#[derive(Debug, Clone)]
pub(super) struct RodTangent {
    /// How fast the arm from the parent link changes.
    pub(super) swing: Vector3<f64>,
    pub(super) u: Vec<f64>,
    /// `N`, then `N D⁻¹` as seen at the tip.
    columns: Vec<(Quad, Quad)>,
    rows: Vec<Varied>,
    /// Of one step, and of the whole element from its root to its tip.
    step: Vec<Varied>,
    whole: Vec<Varied>,
    /// `H` of the element as one hinge.
    tip: Vec<Vector6<f64>>,
    block: FlexBlock,
}

/// What eq. (7) needs of a step.
struct Step<'a> {
    at: &'a RodMotion,
    station: usize,
    /// Acceleration of the station before it.
    a: &'a LinkAcceleration,
    gravity: &'a Vector3<f64>,
    twist_rate: Vector6<f64>,
    c1: f64,
    c2: f64,
}

impl Step<'_> {
    /// A column of eq. (7).
    fn column(&self, local: &Local<'_>, i: usize) -> Varied {
        let [z, zd, zdd] = self.at.columns(local, self.station, i);
        let (last, station) = (&self.at.stations[self.station - 1].link, &self.at.stations[self.station]);
        let twist = &station.twist;
        let rated = zd + self.c1 * z;
        let y = rated + bracket(twist, &z);
        let second = zdd + 2.0 * self.c1 * zd + self.c2 * z;
        let y_rate = second + bracket(&self.twist_rate, &z) + bracket(twist, &rated);
        let ((shift, spin), (slip, roll)) = (halves(&z), halves(twist));
        let ((y_v, y_w), (y_v_rate, y_w_rate)) = (halves(&y), halves(&y_rate));
        let (w, dw, d) = (last.angular_velocity, self.a.angular, station.link.arm);
        let swept = w.cross(&spin);
        let base = self.a.linear - self.gravity + dw.cross(&d) + w.cross(&w.cross(&d));
        let linear = base.cross(&spin)
            + 2.0 * swept.cross(&slip)
            + dw.cross(&shift)
            + w.cross(&(w.cross(&shift) + 2.0 * y_v))
            + y_w.cross(&slip)
            + roll.cross(&y_v)
            + y_v_rate;
        let angular = y_w_rate + dw.cross(&spin) + 2.0 * w.cross(&y_w) + roll.cross(&y_w) + w.cross(&swept);
        Varied {
            linear: Quad::of(&linear),
            angular: Quad::of(&angular),
            rate: Quad::of(&(y_w + swept)),
            turn: Quad::of(&spin),
            place: Quad::of(&shift),
            speed: Quad::of(&(y_v + w.cross(&shift) + spin.cross(&slip))),
        }
    }
}

/// `T z` of eq. (2) for an arm and how fast it changes.
fn carry<const PARTS: u8>(z: &Varied, arm: &Vector3<f64>, swing: &Vector3<f64>) -> Varied {
    let (d, s, mut out) = (Quad::of(arm), Quad::of(swing), *z);
    out.linear = z.rate.cross_add(s + s, z.angular.cross_add(d, z.linear));
    out.place = z.turn.cross_add(d, z.place);
    out.speed = z.rate.cross_add(d, z.turn.cross_add(s, z.speed));
    out
}

/// `row T`.
pub(super) fn carry_row(row: &mut Varied, arm: &Vector3<f64>, swing: &Vector3<f64>) {
    let (d, s) = (Quad::of(arm), Quad::of(swing));
    row.rate = d.cross_add(row.speed, (s + s).cross_add(row.linear, row.rate));
    row.angular = d.cross_add(row.linear, row.angular);
    row.turn = s.cross_add(row.speed, d.cross_add(row.place, row.turn));
}

impl RodTangent {
    pub(super) fn new(rod: &Rod) -> Self {
        let m = rod.count();
        Self {
            swing: Vector3::zeros(),
            u: vec![0.0; m],
            columns: vec![(Quad::default(), Quad::default()); m],
            rows: vec![Varied::default(); m],
            step: vec![Varied::default(); m],
            whole: vec![Varied::default(); m],
            tip: vec![Vector6::zeros(); m],
            block: FlexBlock::new(m),
        }
    }

    /// `S` of the tip's link in, that of the parent link at its root marker out. Returns the number of negative eigenvalues of
    /// `D`, `None` if it is singular.
    #[inline(never)]
    pub(super) fn eliminate<const PARTS: u8>(
        &mut self,
        model: &Model,
        at: &At<'_>,
        (rod, index): (usize, usize),
        S: &mut Carried,
    ) -> Option<usize> {
        let (given, own, felt) = (&model.rods[rod], &at.motion.rods[rod], &at.balance.rods[rod]);
        self.columns.fill((Quad::default(), Quad::default()));
        self.rows.fill(Varied::default());
        self.whole.fill(Varied::default());
        self.block.pivot.clear();
        self.tip.copy_from_slice(&own.tip);
        let (mut arm, mut swing) = (Vector3::zeros(), Vector3::zeros());
        for k in (1..=given.steps()).rev() {
            let station = &own.stations[k].link;
            if k < given.steps() {
                let b = Quad::of(&felt.accelerations[k].linear) - Quad::of(&model.gravity);
                S.add_slice::<PARTS>(given.slices[k].mass, station, b);
                if given.load != Vector3::zeros() && !given.follows {
                    let load = Wrench { force: given.load_at(k, &station.turn), moment: Vector3::zeros() };
                    S.take_turned(&load);
                }
            }
            let (a, twist_rate) = (&felt.accelerations[k - 1], own.twist_rate(k, &felt.second));
            let (gravity, c1, c2) = (&model.gravity, at.c1, at.c2);
            let step = Step { at: own, station: k, a, gravity, twist_rate, c1, c2 };
            let local = own.local(given, k, &felt.second);
            for i in 0..given.count() {
                self.step[i] = step.column(&local, i);
                self.whole[i]
                    .add_times::<{ ACCELERATIONS | RATES | PLACES }>(1.0, &carry::<PARTS>(&self.step[i], &arm, &swing));
            }
            self.across::<PARTS>(&local, own, k, &felt.forces[k], S);
            let by = station.velocity - own.stations[k - 1].link.velocity;
            self.shift::<PARTS>(&station.arm, &by, S);
            (arm, swing) = (arm + station.arm, swing + by);
        }
        let (root, link) = (&own.stations[0].link, &model.links[index]);
        let by = root.velocity - at.motion.links[link.parent].velocity;
        self.shift::<PARTS>(&root.arm, &by, S);
        self.swing = swing + by;
        let diagonal = &at.diagonal[link.velocity..link.velocity + given.count()];
        self.close::<PARTS>(given, at.c1, diagonal, &(arm + root.arm), S)
    }

    /// Eq. (8) at one station.
    fn across<const PARTS: u8>(&mut self, local: &Local<'_>, own: &RodMotion, k: usize, f: &Wrench, S: &mut Carried) {
        let (turn, subspace) = (own.stations[k].link.turn, own.subspace(k));
        let in_its_axes = joined(&turn.tr_mul(&f.force), &turn.tr_mul(&f.moment));
        let gradient = local.gradient(&in_its_axes);
        for j in 0..subspace.len() {
            let (force, moment) = S.times::<PARTS>(&self.step[j]);
            self.columns[j] = (self.columns[j].0 + force, self.columns[j].1 + moment);
            let reached = wrench(self.columns[j].0, self.columns[j].1);
            for i in 0..subspace.len() {
                *self.block.pivot.entry(i, j) += self.rows[i].dot::<PARTS>(&self.step[j])
                    + row(&subspace[i], &reached)
                    + local.curvature(&gradient, i, j);
            }
        }
        for (i, z) in subspace.iter().enumerate() {
            let (shift, spin) = halves(z);
            self.rows[i].add_times::<PARTS>(1.0, &S.row::<PARTS>(Quad::of(&shift), true));
            self.rows[i].add_times::<PARTS>(1.0, &S.row::<PARTS>(Quad::of(&spin), false));
            let (force, moment) = (spin.cross(&f.force), spin.cross(&f.moment) + shift.cross(&f.force));
            self.columns[i].0 += Quad::of(&force);
            self.columns[i].1 += Quad::of(&moment);
        }
    }

    /// To the station before, or to the parent link.
    fn shift<const PARTS: u8>(&mut self, arm: &Vector3<f64>, swing: &Vector3<f64>, S: &mut Carried) {
        S.shift::<PARTS>(arm);
        S.compose::<PARTS>(arm, swing);
        for (force, moment) in &mut self.columns {
            *moment = Quad::of(arm).cross_add(*force, *moment);
        }
        self.rows.iter_mut().for_each(|row| carry_row(row, arm, swing));
    }

    /// Eq. (9).
    fn close<const PARTS: u8>(
        &mut self,
        rod: &Rod,
        c1: f64,
        diagonal: &[f64],
        arm: &Vector3<f64>,
        S: &mut Carried,
    ) -> Option<usize> {
        let m = rod.count();
        for i in 0..m {
            for (j, k) in rod.stiffness_row(i).iter().enumerate() {
                *self.block.pivot.entry(i, j) += (1.0 + rod.damping * c1) * k;
            }
        }
        let negative = self.block.invert(diagonal)?;
        // The step's memory is free now.
        for j in 0..m {
            (self.step[j].linear, self.step[j].angular) = self.block.solved_column(&self.columns, j);
        }
        for j in 0..m {
            let (force, moment) = (self.step[j].linear, self.step[j].angular);
            S.downdate::<PARTS>((force, moment), 1.0, &self.rows[j]);
            self.columns[j] = (force, Quad::of(&-arm).cross_add(force, moment));
        }
        Some(negative)
    }

    /// Eq. (6) for a right side: what the parent link gets, as seen at the tip.
    pub(super) fn load(&mut self, x: &[f64], (mut force, mut moment): (Quad, Quad)) -> (Quad, Quad) {
        let given = wrench(force, moment);
        for (i, (u, tip)) in self.u.iter_mut().zip(&self.tip).enumerate() {
            *u = x[i] - row(tip, &given);
            let by = Quad::all(*u);
            (force, moment) = (by.times_add(self.columns[i].0, force), by.times_add(self.columns[i].1, moment));
        }
        (force, moment)
    }

    /// Eq. (5): from the variation of the parent link; that of the tip without the element's own is in `z`.
    pub(super) fn solve<const PARTS: u8>(&self, parent: &Varied, x: &mut [f64], z: &mut Varied) {
        let m = self.u.len();
        x[..m].fill(0.0);
        for (j, (u, row)) in self.u.iter().zip(&self.rows).enumerate() {
            let felt = u - row.dot::<PARTS>(parent);
            self.block.add_solution(x, j, felt);
        }
        self.add_to::<PARTS>(x, z);
    }

    fn add_to<const PARTS: u8>(&self, x: &[f64], z: &mut Varied) {
        self.whole.iter().zip(x).for_each(|(h, x)| z.add_times::<PARTS>(*x, h));
    }

    /// The direction in which `D` is most negative, and how the tip varies with it.
    pub(super) fn negative_direction(&self, x: &mut [f64]) -> Varied {
        let mut z = Varied::default();
        x[..self.block.lowest.len()].copy_from_slice(&self.block.lowest);
        self.add_to::<{ ACCELERATIONS | RATES | PLACES }>(&self.block.lowest, &mut z);
        z
    }
}
