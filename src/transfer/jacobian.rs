//! The Jacobians of the hinge accelerations, ∂q̈/∂q and ∂q̈/∂q̇, of a tree without force elements.
//!
//! A hinge coordinate `j` moves the subtree it carries as one rigid body, by `H_j`. Seen from that body, what is left of
//! the variation of every link `k` in it are two fields that are the same for all of them (Carpentier & Mansard 2018;
//! Singh, Russo & Wensing 2022), and the wrench that its body asks for varies by
//!
//! ```text
//! (J1) δf_k = M_k α + 2B_k β  (+ H_j ×* f_k, by which forces turn with the bodies)
//!      ∂q_j    β = V_P × H_j,   α = A_P × H_j + V_P × β
//!      ∂q̇_j    β = H_j,         α = (V_P + V_j) × H_j
//! ```
//!
//! with `V`, `A` the velocity and acceleration fields of link and parent (weight as an acceleration of the ground). Of `β`
//! only the angular part `w` counts – a uniform velocity asks for no force – so that `2B` has three columns, the
//! same about every point but for the moment of its forces:
//!
//! ```text
//! (J2) 2B w = [2 w × p;  2m c × (w × v) + 2 ω × J w − tr(J) ω × w],   p = m (v + ω × c)
//! ```
//!
//! A matrix of M, C or K is never formed. Everything outboard of a link answers `α` and `w` as one body of reduced
//! matrix `S` and reduced `N`, the sum of the `2B`, eliminated like `S` in eqs. (5) and (7):
//!
//! ```text
//! (J3) δf = S α + N w,   N' = N − S H D⁻¹ Hᵀ N,   N_P += X(d)ᵀ N'
//! ```
//!
//! So the inboard side of hinge `j` is loaded by `e = S' α + N' w + H_j ×* f_j`; from there to the root eqs. (6) and (7)
//! hold, and outward again eq. (8), with `α` and `w` added where the subtree begins:
//!
//! ```text
//! (J4) q̈ = D⁻¹ (u − Hᵀ S a_in − Hᵀ N w)
//! ```
//!
//! Two columns for each of [`TOGETHER`] coordinates go through the tree side by side: what a hinge multiplies is loaded
//! once for all of them. A ball is three turns about its link's axes, one after the other. Each column costs O(n), all of
//! them O(n²), without allocation.
//!
//! Velocities are taken relative to the first body of the branch: a scene that moves as a whole loses no digits.
//!
//! Precision: nothing is carried to a distant common point and no mass matrix is factorized, so the error does not grow
//! with the condition of a long chain's mass matrix but with that of single pivots. Relative to the largest entry it is
//! some hundred ε, and some ten ε J_max/J_min where balls carry bodies as slender as that: so much does one step of
//! refinement correct in chains of up to 100 balls.

mod cause;
mod lanes;
mod place;

use super::LinkAcceleration;
use super::Singular;
use super::balance::Balance;
use super::element::Reduced;
use crate::model::{Joint, Link, Model};
use crate::motion::{LinkMotion, Motion};
use crate::round_off::COLUMNS_PIVOT;
use crate::spatial::Wrench;
use cause::Cause;
use lanes::{Field, Load};
use nalgebra::{Matrix3, Vector3};
use place::{ColumnKind, ColumnPlace};
use std::ops::Range;

/// Coordinates whose columns are found together.
pub const TOGETHER: usize = 4;

/// Columns found together: those by position, then those by velocity.
pub const LANES: usize = 2 * TOGETHER;

/// One number of each column.
pub type Lanes = [f64; LANES];

/// The hinges eliminated at one state, and scratch memory for their columns.
#[derive(Debug, Clone)]
pub struct Jacobian {
    /// How the velocity coordinates hang together.
    places: Vec<ColumnPlace>,
    /// For every link the first one with mass on its branch from the ground.
    reference: Vec<usize>,
    /// Every velocity coordinate, eliminated; written by [`Jacobian::update`].
    rows: Vec<Row>,
    /// What varies with every coordinate and with its velocity; written by [`Jacobian::update`].
    causes: Vec<[Cause; 2]>,
    /// What arrives at each link from those it carries.
    carried: Vec<Carried>,
    /// Fields of links from which several branches leave.
    kept: Vec<Field>,
    /// The columns of the last [`Jacobian::columns`], row by row; before that `D⁻¹ u`.
    x: Vec<Lanes>,
}

/// A velocity coordinate, eliminated.
#[derive(Debug, Clone, Copy, Default)]
struct Row {
    /// `S H D⁻¹`.
    gain: Wrench,
    /// `D⁻¹ Hᵀ N`.
    rate: Vector3<f64>,
    axis: Vector3<f64>,
    arm: Vector3<f64>,
    /// `D⁻¹`.
    inverse: f64,
}

/// `S` and `N` of everything outboard.
#[derive(Debug, Clone, Copy, Default)]
struct Carried {
    S: Reduced,
    N: Rated,
}

/// A 6×3 matrix from angular velocities to wrenches.
#[derive(Debug, Clone, Copy, Default)]
struct Rated {
    force: Matrix3<f64>,
    moment: Matrix3<f64>,
}

impl Jacobian {
    /// Room for a model.
    pub fn new(model: &Model) -> Self {
        let (places, kept) = place::places(model);
        let n = places.len();
        Self {
            reference: place::references(model),
            rows: vec![Row::default(); n],
            causes: vec![[Cause::default(); 2]; n],
            carried: vec![Carried::default(); model.links.len()],
            kept: vec![Field::default(); kept],
            x: vec![[0.0; LANES]; n],
            places,
        }
    }

    /// Tips → root: eqs. (5), (7) and (J1) to (J3) at the state of `motion`, with the true accelerations in `balance`.
    /// `spring` is `∂τ/∂(turn)` of a ball, link axes (N m).
    ///
    /// # Errors
    /// A hinge that nothing with inertia resists.
    pub fn update(
        &mut self,
        model: &Model,
        motion: &Motion,
        balance: &Balance,
        spring: impl Fn(&Link) -> Option<Matrix3<f64>>,
    ) -> Result<(), Singular> {
        self.carried.fill(Carried::default());
        for index in (1..model.links.len()).rev() {
            let link = &model.links[index];
            let mut at = motion.links[index];
            at.velocity -= motion.links[self.reference[index]].velocity;
            let mut carried = self.carried[index];
            if !link.is_massless() {
                carried.S.add_body(link.mass, &at.center, &at.inertia);
                carried.N.add_body(link.mass, &at);
            }
            let (_, count) = link.joint.counts();
            let own = link.velocity..link.velocity + count;
            for i in own.clone().rev() {
                let axis = match link.joint {
                    Joint::Ball { .. } => at.turn.column(i - own.start).into_owned(),
                    _ => at.axis,
                };
                let armature = model.coordinates[i].armature;
                let eliminated = carried.eliminate(axis, at.arm, self.places[i].kind, armature);
                self.rows[i] = eliminated.map_err(|pivot| Singular { link: index, pivot })?;
            }
            if link.joint.is_ball() && own.clone().all(|i| model.coordinates[i].armature == 0.0) {
                // Without armature Hᵀ S' and Hᵀ N' vanish identically.
                carried.S = Reduced { ff: carried.S.ff, ..Reduced::default() };
                carried.N.moment = Matrix3::zeros();
            }
            let spring = spring(link).unwrap_or_default();
            for i in own.clone() {
                let coordinate = &model.coordinates[i];
                let stiffness = match link.joint {
                    Joint::Ball { .. } => -spring.column(i - own.start).into_owned(),
                    _ => Vector3::new(coordinate.stiffness, 0.0, 0.0),
                };
                let damping = Vector3::ith(i - own.start, coordinate.damping);
                let mut causes = match link.joint {
                    Joint::Slide { .. } => cause::of_slide(&at.axis, motion, balance, link, index),
                    Joint::Screw { pitch } => {
                        let mut causes = cause::of_turn(&at.axis, model, motion, balance, &at, index);
                        let slides = cause::of_slide(&at.axis, motion, balance, link, index);
                        causes.iter_mut().zip(&slides).for_each(|(cause, slide)| cause.add_times(pitch, slide));
                        causes
                    }
                    _ => cause::of_turn(&self.rows[i].axis, model, motion, balance, &at, index),
                };
                for (cause, resistance) in causes.iter_mut().zip([stiffness, damping]) {
                    cause.passed += carried.S.times(&cause.alpha) + carried.N.times(&cause.rate);
                    if resistance != Vector3::zeros() {
                        cause.passed += self.resist(own.clone(), &resistance, &mut cause.own);
                    }
                    cause.move_to_parent(&at.arm);
                }
                self.causes[i] = causes;
            }
            if link.parent != 0 {
                self.carried[link.parent].add(&carried.shifted(&at.arm));
            }
        }
        Ok(())
    }

    /// Eq. (6) for the coordinates of one link and `u = −resistance`: `D⁻¹ u` and the `e` that is passed on.
    fn resist(&self, coordinates: Range<usize>, resistance: &Vector3<f64>, own: &mut [f64; 3]) -> Wrench {
        let mut e = Wrench::ZERO;
        for (at, i) in coordinates.enumerate().rev() {
            let row = &self.rows[i];
            let met = match self.places[i].kind {
                ColumnKind::Slide => row.axis.dot(&e.force),
                ColumnKind::Turn | ColumnKind::Further => row.axis.dot(&e.moment),
                ColumnKind::Screw { pitch } => row.axis.dot(&(e.moment + pitch * e.force)),
            };
            let u = -(met + resistance[at]);
            own[at] = u * row.inverse;
            e += row.gain.times(u);
        }
        e
    }

    /// The columns of the coordinates from `first` on, [`TOGETHER`] of them (fewer at the end), and the rows they
    /// touch: all others do not vary. Number `k` of a row is by position, number `TOGETHER + k` by velocity.
    pub fn columns(&mut self, first: usize) -> (Range<usize>, &[Lanes]) {
        let last = (first + TOGETHER).min(self.places.len()) - 1;
        let touched = self.places[first].branch.start..self.places[last].branch.end;
        self.x[touched.clone()].fill([0.0; LANES]);
        self.inward(first, last);
        self.outward(first, last, touched.clone());
        (touched.clone(), &self.x[touched])
    }

    /// Tips → root: eqs. (6) and (7), from each coordinate to the ground.
    fn inward(&mut self, first: usize, last: usize) {
        let mut load = Load::default();
        let mut lead = self.places[last].first;
        // Links of the group itself: some columns pass through, others begin.
        loop {
            let ColumnPlace { next, end, .. } = self.places[lead];
            let carried = next.max(first)..end.min(last + 1);
            if !carried.is_empty() {
                self.pass(lead, carried.start - first..carried.end - first, &mut load);
            }
            for i in lead.max(first)..next.min(last + 1) {
                for (way, cause) in self.causes[i].iter().enumerate() {
                    let lane = way * TOGETHER + i - first;
                    load.set(lane, &cause.passed);
                    for (x, own) in self.x[lead..next].iter_mut().zip(cause.own) {
                        x[lane] = own;
                    }
                }
            }
            if lead <= first {
                break;
            }
            lead = self.places[lead - 1].first;
        }
        // And the way from there to the ground: whatever hangs on it holds the first column.
        while let Some(above) = self.places[lead].above {
            lead = above;
            let end = self.places[lead].end.min(last + 1);
            self.pass(lead, 0..end - first, &mut load);
        }
    }

    /// One link on the way to the ground, for the columns of some of the coordinates.
    #[inline]
    fn pass(&mut self, lead: usize, coordinates: Range<usize>, load: &mut Load) {
        let own = lead..self.places[lead].next;
        let kind = self.places[lead].kind;
        if coordinates == (0..TOGETHER) {
            load.pass::<false>(kind, &self.rows[own.clone()], &[1.0; LANES], &mut self.x[own]);
        } else {
            let mut mask = [0.0; LANES];
            mask[coordinates.clone()].fill(1.0);
            mask[TOGETHER..][coordinates].fill(1.0);
            load.pass::<true>(kind, &self.rows[own.clone()], &mask, &mut self.x[own]);
        }
    }

    /// Root → tips: eq. (J4).
    fn outward(&mut self, first: usize, last: usize, touched: Range<usize>) {
        let beginning = self.places[first].first..last + 1;
        let mut field = Field::default();
        for i in touched {
            let (place, row) = (&self.places[i], &self.rows[i]);
            match place.from {
                place::From::Before => {}
                place::From::Ground => field = Field::default(),
                place::From::Kept(at) => field = self.kept[at],
            }
            if beginning.contains(&i) && place.first == i {
                for k in i.max(first)..place.next.min(last + 1) {
                    for (way, cause) in self.causes[k].iter().enumerate() {
                        field.begin(way * TOGETHER + k - first, cause);
                    }
                }
            }
            field.cross(place.kind, row, &mut self.x[i]);
            if let Some(at) = place.keep {
                self.kept[at] = field;
            }
        }
    }
}

impl Carried {
    /// Eq. (5) and (J3) for one coordinate; on failure its pivot.
    fn eliminate(
        &mut self,
        axis: Vector3<f64>,
        arm: Vector3<f64>,
        kind: ColumnKind,
        armature: f64,
    ) -> Result<Row, f64> {
        let Self { S, N } = self;
        let (SH, HN, D, seen) = match kind {
            ColumnKind::Slide => {
                let SH = Wrench { force: S.ff * axis, moment: S.fm.tr_mul(&axis) };
                (SH, N.force.tr_mul(&axis), axis.dot(&SH.force), S.ff.trace())
            }
            ColumnKind::Turn | ColumnKind::Further => {
                let SH = Wrench { force: S.fm * axis, moment: S.mm * axis };
                (SH, N.moment.tr_mul(&axis), axis.dot(&SH.moment), S.mm.trace())
            }
            ColumnKind::Screw { pitch } => {
                let slide = pitch * axis;
                let SH = S.times(&LinkAcceleration { linear: slide, angular: axis });
                let HN = N.force.tr_mul(&slide) + N.moment.tr_mul(&axis);
                let seen = S.mm.trace() + pitch * pitch * S.ff.trace();
                (SH, HN, slide.dot(&SH.force) + axis.dot(&SH.moment), seen)
            }
        };
        let D = D + armature;
        if !(D > COLUMNS_PIVOT.of(seen) && D.is_finite()) {
            return Err(D);
        }
        let inverse = 1.0 / D;
        let (gain, rate) = (SH.times(inverse), inverse * HN);
        S.downdate(&SH, inverse);
        N.force -= SH.force * rate.transpose();
        N.moment -= SH.moment * rate.transpose();
        Ok(Row { gain, rate, axis, arm, inverse })
    }

    fn add(&mut self, other: &Self) {
        self.S.add(&other.S);
        self.N.force += other.N.force;
        self.N.moment += other.N.moment;
    }

    /// Seen from a marker from which this one is `d` away.
    fn shifted(&self, d: &Vector3<f64>) -> Self {
        let N = Rated { force: self.N.force, moment: self.N.moment + d.cross_matrix() * self.N.force };
        Self { S: self.S.shifted(d), N }
    }
}

impl Rated {
    /// `N += 2B`, eq. (J2), of a body at its root marker.
    fn add_body(&mut self, mass: f64, at: &LinkMotion) {
        let (v, w, c) = (&at.velocity, &at.angular_velocity, mass * at.center);
        let (turning, inertia) = (w.cross_matrix(), at.inertia.matrix());
        self.force -= 2.0 * (mass * v + w.cross(&c)).cross_matrix();
        self.moment += 2.0 * (turning * inertia - c.cross_matrix() * v.cross_matrix()) - at.inertia.trace() * turning;
    }

    /// `N w`.
    fn times(&self, w: &Vector3<f64>) -> Wrench {
        Wrench { force: self.force * w, moment: self.moment * w }
    }
}
