//! The elimination of a modal body in the tangent: what its interfaces bring to its coordinates, then the coordinates themselves.
//!
//! ```text
//! (7) at an interface, S and f of its link, h = δz of it for a unit of a coordinate while the frame stays:
//!       N += S h,   P += Zᵀ S h + Γ,   row += Zᵀ S,   N += [φ×F; φ×M + δr×F],   N and row seen from the frame
//! (8) at the frame: S, N, P and row of eq. (3) of `element::modal`, varied
//! (9) D = P + K + c₁ D + shift,   δq = D⁻¹ (u − row z),   S ← S − N D⁻¹ row
//! ```

use super::At;
use super::block::FlexBlock;
use super::parts::{Carried, RATES, Varied};
use super::rod::carry_row;
use crate::element::modal::Modal;
use crate::model::{Link, Model};
use crate::motion::LinkMotion;
use crate::spatial::Wrench;
use crate::spatial::link::LinkVariation;
use crate::spatial::quad::{Columns, Quad, wrench};
use nalgebra::Vector3;

/// A modal body, eliminated.
#[derive(Debug, Clone)]
pub(super) struct ModalTangent {
    pub(super) u: Vec<f64>,
    /// `N`, then `N D⁻¹`.
    columns: Vec<(Quad, Quad)>,
    rows: Vec<Varied>,
    block: FlexBlock,
    products: Vec<(Quad, Quad)>,
    tips: Vec<Tip>,
    /// A unit of one coordinate, of its rate and of its second rate.
    direction: [Vec<f64>; 3],
    /// What right sides have brought from the interfaces; zero between two sweeps.
    brought: Vec<f64>,
}

/// An interface at the point of the tangent.
#[derive(Debug, Clone)]
struct Tip {
    /// The coordinates that move it.
    moved_by: Vec<usize>,
    /// `h` of each.
    h: Vec<Varied>,
    /// `Z`: shift and turn of each.
    z: Vec<(Vector3<f64>, Vector3<f64>)>,
}

impl ModalTangent {
    pub(super) fn new(modal: &Modal) -> Self {
        let m = modal.count();
        let none = (Quad::default(), Quad::default());
        let tips = modal.tips.iter().map(|tip| {
            let count = tip.moved_by.len();
            let zero = (Vector3::zeros(), Vector3::zeros());
            Tip { moved_by: tip.moved_by.clone(), h: vec![Varied::default(); count], z: vec![zero; count] }
        });
        Self {
            u: vec![0.0; m],
            columns: vec![none; m],
            rows: vec![Varied::default(); m],
            block: FlexBlock::new(m),
            products: vec![none; m],
            tips: tips.collect(),
            direction: [0, 1, 2].map(|_| vec![0.0; m]),
            brought: vec![0.0; m],
        }
    }

    /// Begins anew: before the first interface.
    pub(super) fn clear(&mut self) {
        self.block.pivot.clear();
        self.columns.fill((Quad::default(), Quad::default()));
        self.rows.fill(Varied::default());
    }

    /// Eq. (7): `S` of the interface's link, and how fast its arm from the frame changes.
    #[inline(never)]
    pub(super) fn interface<const PARTS: u8>(
        &mut self,
        model: &Model,
        at: &At<'_>,
        (modal, tip, index): (usize, usize, usize),
        S: &Carried,
    ) -> Vector3<f64> {
        let (link, body) = (&model.links[index], &model.modals[modal]);
        let (frame, own) = (&at.motion.links[link.parent], &at.motion.links[index]);
        let (moves, given) = (&at.motion.modals[modal], &body.modal.tips[tip]);
        let (here, f) = (&moves.tips[tip], &at.balance.reactions[index]);
        let second = &at.hinge[link.velocity..link.velocity + body.modal.count()];
        let carried = (frame, &at.balance.accelerations[link.parent]);
        let swing = here.swing(frame);
        let state = [&moves.q[..], &moves.v, second];
        let Self { tips, direction, block: FlexBlock { pivot, .. }, columns, rows, .. } = self;
        let Tip { moved_by, h, z } = &mut tips[tip];
        z.copy_from_slice(&here.columns);
        for (k, j) in moved_by.iter().enumerate() {
            [1.0, at.c1, at.c2].iter().zip(direction.iter_mut()).for_each(|(x, list)| list[*j] = *x);
            let by = [0, 1, 2].map(|order| &direction[order][..]);
            let varied = here.vary(given, carried, state, &LinkVariation::default(), by);
            direction.iter_mut().for_each(|list| list[*j] = 0.0);
            h[k] = in_turning_axes(&varied, own, &(at.balance.accelerations[index].linear - model.gravity), at, index);
            let (force, moment) = S.times::<PARTS>(&h[k]);
            let reached = wrench(force, moment);
            for (i, (shift, spin)) in moved_by.iter().zip(&*z) {
                *pivot.entry(*i, *j) += shift.dot(&reached.force) + spin.dot(&reached.moment);
            }
            let (shift, spin) = z[k];
            let turned = Wrench { force: spin.cross(&f.force), moment: spin.cross(&f.moment) + shift.cross(&f.force) };
            let (force, moment) = (force + Quad::of(&turned.force), moment + Quad::of(&turned.moment));
            let column = &mut columns[*j];
            *column = (column.0 + force, column.1 + Quad::of(&own.arm).cross_add(force, moment));
            let mut row = S.row::<PARTS>(Quad::of(&shift), true);
            row.add_times::<PARTS>(1.0, &S.row::<PARTS>(Quad::of(&spin), false));
            carry_row(&mut row, &own.arm, &swing);
            rows[*j].add_times::<PARTS>(1.0, &row);
        }
        here.curvature(given, frame, f, |i, j, entry| *pivot.entry(i, j) += entry);
        swing
    }

    /// Eqs. (8) and (9): `S` of the link of the frame in, without its coordinates out. Returns the number of negative eigenvalues
    /// of `D`, `None` if it is singular.
    #[inline(never)]
    pub(super) fn eliminate<const PARTS: u8>(
        &mut self,
        model: &Model,
        at: &At<'_>,
        (modal, index): (usize, usize),
        S: &mut Carried,
    ) -> Option<usize> {
        let (given, moves) = (&*model.modals[modal].modal, &at.motion.modals[modal]);
        let (frame, a) = (&at.motion.links[index], &at.balance.accelerations[index]);
        let first = model.links[index].velocity;
        let (m, b) = (given.count(), a.linear - model.gravity);
        let second = &at.hinge[first..first + m];
        let body = Link { mass: given.mass, ..Link::ground() };
        let rigid = LinkMotion { center: moves.first / given.mass, inertia: moves.inertia, ..*frame };
        S.add_body::<PARTS>(&body, &rigid, Quad::of(&b));
        if PARTS & RATES != 0 {
            let (flow, inertia_rate, roll) = moves.flows(frame);
            S.rate.force = S.rate.force.minus_cross_of(Quad::of(&(2.0 * flow)));
            S.rate.moment += Columns::symmetric(&inertia_rate);
            S.rate.moment = S.rate.moment.minus_cross_of(Quad::of(&roll));
        }
        for j in 0..m {
            let pivot = &mut self.block.pivot;
            let state = (frame, &b, a);
            let varied = moves.column(given, state, second, (j, at.c1, at.c2), |i, x| *pivot.entry(i, j) += x);
            let column = &mut self.columns[j];
            *column = (column.0 + Quad::of(&varied.force), column.1 + Quad::of(&varied.moment));
            let row = &mut self.rows[j];
            row.linear += Quad::of(&moves.columns[j].force);
            row.angular += Quad::of(&moves.columns[j].moment);
            if PARTS & RATES != 0 {
                row.rate += Quad::of(&moves.row_by_rate(j, frame));
            }
        }
        self.close::<PARTS>(given, at.c1, &at.diagonal[first..first + m], S)
    }

    /// Eq. (9).
    fn close<const PARTS: u8>(&mut self, given: &Modal, c1: f64, diagonal: &[f64], S: &mut Carried) -> Option<usize> {
        let m = diagonal.len();
        for i in 0..m {
            for j in 0..m {
                *self.block.pivot.entry(i, j) += given.pivot_entry(i, j, c1);
            }
        }
        let negative = self.block.invert(diagonal)?;
        for j in 0..m {
            self.products[j] = self.block.solved_column(&self.columns, j);
        }
        self.columns.copy_from_slice(&self.products);
        for (column, row) in self.columns.iter().zip(&self.rows) {
            S.downdate::<PARTS>(*column, 1.0, row);
        }
        Some(negative)
    }

    /// Eq. (6) for a right side at an interface.
    pub(super) fn load_interface(&mut self, tip: usize, (force, moment): (Quad, Quad)) {
        let (given, tip) = (wrench(force, moment), &self.tips[tip]);
        for (i, (shift, spin)) in tip.moved_by.iter().zip(&tip.z) {
            self.brought[*i] -= shift.dot(&given.force) + spin.dot(&given.moment);
        }
    }

    /// Eq. (6) for a right side: what the frame passes on.
    pub(super) fn load(&mut self, x: &[f64], (mut force, mut moment): (Quad, Quad)) -> (Quad, Quad) {
        for (i, u) in self.u.iter_mut().enumerate() {
            *u = x[i] + self.brought[i];
            let by = Quad::all(*u);
            (force, moment) = (by.times_add(self.columns[i].0, force), by.times_add(self.columns[i].1, moment));
        }
        self.brought.fill(0.0);
        (force, moment)
    }

    /// Eq. (9): from the variation of the frame.
    pub(super) fn solve<const PARTS: u8>(&self, frame: &Varied, x: &mut [f64]) {
        let m = self.u.len();
        x[..m].fill(0.0);
        for (j, (u, row)) in self.u.iter().zip(&self.rows).enumerate() {
            let felt = u - row.dot::<PARTS>(frame);
            self.block.add_solution(x, j, felt);
        }
    }

    /// Adds to the variation of an interface what the coordinates do.
    pub(super) fn follow<const PARTS: u8>(&self, tip: usize, x: &[f64], z: &mut Varied) {
        let tip = &self.tips[tip];
        tip.moved_by.iter().zip(&tip.h).for_each(|(i, h)| z.add_times::<PARTS>(x[*i], h));
    }

    /// The direction in which `D` is most negative.
    pub(super) fn negative_direction(&self, x: &mut [f64]) {
        x[..self.block.lowest.len()].copy_from_slice(&self.block.lowest);
    }
}

/// A variation of an interface's link as `z` has it.
fn in_turning_axes(varied: &LinkVariation, own: &LinkMotion, b: &Vector3<f64>, at: &At<'_>, index: usize) -> Varied {
    let (turn, w) = (varied.turn, own.angular_velocity);
    let rate = varied.angular_velocity - turn.cross(&w);
    let angular = varied.angular_acceleration - turn.cross(&at.balance.accelerations[index].angular) - rate.cross(&w);
    Varied {
        linear: Quad::of(&(varied.acceleration - turn.cross(b))),
        angular: Quad::of(&angular),
        rate: Quad::of(&rate),
        turn: Quad::of(&turn),
        place: Quad::of(&varied.position),
        speed: Quad::of(&varied.velocity),
    }
}
