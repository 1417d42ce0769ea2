//! The multipliers of rows whose loops are short, in a time proportional to the number of links: each is eliminated at the link where the
//! two ways of its loop meet (constraint embedding; Jain, *Nonlinear Dynamics* 67, 2012), and none is passed on to the ground.
//!
//! ```text
//! link       F = I X + p − U λ,   rates = Uᵀ X + Λ λ + c       X its acceleration, λ the multipliers of rows that are open there    (1)
//! hinge      D = Hᵀ I H + a,   Q = Hᵀ U + Φ,   q̈ = D⁻¹ (Q λ − Hᵀ p − Hᵀ I X)
//!            I −= I H D⁻¹ Hᵀ I,   p −= I H D⁻¹ Hᵀ p,   U −= I H D⁻¹ Q,   Λ += Qᵀ D⁻¹ Q,   c −= Qᵀ D⁻¹ Hᵀ p
//! loop       λₖ = Λₖₖ⁻¹ (rₖ − cₖ − Uₖᵀ X − Λₖₒ λₒ)             rows k close here, rows o stay open
//! ```
//!
//! `A λ = r` for `A = G M⁻¹ Gᵀ` is what this solves, without `A`.

use super::plan::{Kind, plan};
use super::tangent::Pull;
use crate::model::{Joint, Link, Model};
use crate::motion::Motion;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn, Matrix6, Matrix6xX, MatrixXx6, Vector3, Vector6};

/// What (1) has of one link.
struct Carried {
    inertia: Matrix6<f64>,
    bias: Vector6<f64>,
    open: Vec<usize>,
    pulls: Matrix6xX<f64>,
    response: DMatrix<f64>,
    rates: DVector<f64>,
}

impl Carried {
    fn new() -> Self {
        Self {
            inertia: Matrix6::zeros(),
            bias: Vector6::zeros(),
            open: Vec::new(),
            pulls: Matrix6xX::zeros(0),
            response: DMatrix::zeros(0, 0),
            rates: DVector::zeros(0),
        }
    }

    /// The places of these rows, which are open from now on.
    fn places(&mut self, rows: &[usize]) -> Vec<usize> {
        let known = self.open.len();
        let place = |row: &usize| {
            self.open.iter().position(|open| open == row).unwrap_or_else(|| {
                self.open.push(*row);
                self.open.len() - 1
            })
        };
        let places = rows.iter().map(place).collect();
        if self.open.len() > known {
            let count = self.open.len();
            self.pulls.resize_horizontally_mut(count, 0.0);
            self.response.resize_mut(count, count, 0.0);
            self.rates.resize_vertically_mut(count, 0.0);
        }
        places
    }

    fn add(&mut self, other: &Self) {
        self.inertia += other.inertia;
        self.bias += other.bias;
        let places = self.places(&other.open);
        for (j, place) in places.iter().enumerate() {
            let mut column = self.pulls.column_mut(*place);
            column += other.pulls.column(j);
            self.rates[*place] += other.rates[j];
            places.iter().enumerate().for_each(|(i, row)| self.response[(*row, *place)] += other.response[(i, j)]);
        }
    }

    /// Closes rows; `None` if they are linearly dependent.
    fn close(&mut self, closes: impl Fn(usize) -> bool, wanted: &[f64]) -> Option<Closed> {
        let (own, left): (Vec<usize>, Vec<usize>) = (0..self.open.len()).partition(|place| closes(self.open[*place]));
        let factor = self.response.select_rows(&own).select_columns(&own).cholesky()?;
        let beside = self.response.select_rows(&own).select_columns(&left);
        let pulls = self.pulls.select_columns(&own);
        let gaps = DVector::from_fn(own.len(), |k, _| wanted[self.open[own[k]]] - self.rates[own[k]]);
        let (solved, per_pull, per_open) =
            (factor.solve(&gaps), factor.solve(&pulls.transpose()), factor.solve(&beside));
        self.inertia += &pulls * &per_pull;
        self.bias -= &pulls * &solved;
        self.rates = self.rates.select_rows(&left) + beside.tr_mul(&solved);
        self.pulls = self.pulls.select_columns(&left) - &pulls * &per_open;
        self.response = self.response.select_rows(&left).select_columns(&left) - beside.tr_mul(&per_open);
        let rows = [&own, &left].map(|places| places.iter().map(|place| self.open[*place]).collect::<Vec<_>>());
        self.open.clone_from(&rows[1]);
        Some(Closed { rows, factor, gaps, pulls, beside })
    }
}

/// Rows that closed at a link, and those that stayed open there.
struct Closed {
    rows: [Vec<usize>; 2],
    factor: Cholesky<f64, Dyn>,
    gaps: DVector<f64>,
    pulls: Matrix6xX<f64>,
    beside: DMatrix<f64>,
}

/// One hinge: `H`, and `q̈` of it.
struct Passed {
    axes: Matrix6xX<f64>,
    open: Vec<usize>,
    /// `D⁻¹ (Q, Hᵀ p, Hᵀ I)`
    by_open: DMatrix<f64>,
    by_bias: DVector<f64>,
    by_motion: MatrixXx6<f64>,
}

/// Of every row the link where its ways meet, and the operations that follow from it.
fn meeting(model: &Model, pulls: &[Pull]) -> (Vec<usize>, usize) {
    let mut open = vec![0_usize; model.links.len()];
    let mut owner = vec![0; model.velocity_count()];
    for (index, link) in model.links.iter().enumerate() {
        owner[link.velocity..link.velocity + link.joint.counts().1].fill(index);
    }
    let of = |pull: &Pull| {
        let links = pull.links.iter().map(|(link, _)| *link);
        let mut ends: Vec<usize> = links.chain(pull.coordinates.iter().map(|(j, _)| owner[*j])).collect();
        // A loop with one end at a link has its other end on the ground, a coordinate has it on the link before.
        if pull.links.len() == 1 {
            ends.push(0);
        }
        let before: Vec<usize> = pull.coordinates.iter().map(|(j, _)| model.links[owner[*j]].parent).collect();
        ends.extend(before);
        while ends.iter().any(|end| *end != ends[0]) {
            // Parents have lower indices than their children.
            let last = ends.iter().copied().max().unwrap_or(0);
            open[last] += 1;
            ends.iter_mut().filter(|end| **end == last).for_each(|end| *end = model.links[last].parent);
        }
        ends.first().copied().unwrap_or(0)
    };
    let meet: Vec<usize> = pulls.iter().map(of).collect();
    let mut closing = vec![0_usize; model.links.len()];
    meet.iter().for_each(|link| closing[*link] += 1);
    let work = open.iter().zip(&closing).map(|(open, closing)| (open + closing + 6).pow(2) + closing.pow(3)).sum();
    (meet, work)
}

/// Operations of [`multipliers`], about; `None` for models with elements that it does not know.
pub fn operations(model: &Model, pulls: &[Pull]) -> Option<usize> {
    let is_known = |link: &Link| {
        matches!(link.joint, Joint::None | Joint::Turn | Joint::Slide { .. } | Joint::Screw { .. } | Joint::Ball { .. })
    };
    model.links.iter().all(is_known).then(|| meeting(model, pulls).1)
}

/// `λ` of `A λ = wanted`; `None` if rows are linearly dependent or a hinge has no inertia.
pub fn multipliers(model: &Model, motion: &Motion, pulls: &[Pull], wanted: &[f64]) -> Option<Vec<f64>> {
    let ((meet, _), (pages, ..)) = (meeting(model, pulls), plan(model));
    let (mut at_link, mut at_coordinate) =
        (vec![Vec::new(); model.links.len()], vec![Vec::new(); model.velocity_count()]);
    for (row, pull) in pulls.iter().enumerate() {
        pull.links.iter().for_each(|(link, wrench)| at_link[*link].push((row, six(&wrench.moment, &wrench.force))));
        pull.coordinates.iter().for_each(|(j, factor)| at_coordinate[*j].push((row, *factor)));
    }
    let mut carried: Vec<Option<Carried>> = model.links.iter().map(|_| None).collect();
    let mut passed: Vec<Option<(Closed, Passed)>> = model.links.iter().map(|_| None).collect();
    for index in (1..model.links.len()).rev() {
        let mut own = carried[index].take().unwrap_or_else(Carried::new);
        own.inertia += of_body(model, motion, index);
        for (row, pull) in &at_link[index] {
            let place = own.places(&[*row])[0];
            let mut column = own.pulls.column_mut(place);
            column += pull;
        }
        let closed = own.close(|row| meet[row] == index, wanted)?;
        let hinge = pass(model, index, axes(model, motion, index, pages[index].kind), &at_coordinate, &mut own)?;
        let parent = model.links[index].parent;
        shift(&mut own, &motion.links[index].arm);
        carried[parent].get_or_insert_with(Carried::new).add(&own);
        passed[index] = Some((closed, hinge));
    }
    let mut ground = carried[0].take().unwrap_or_else(Carried::new);
    let closed = ground.close(|_| true, wanted)?;
    let mut found = vec![0.0; pulls.len()];
    let mut moves = vec![Vector6::zeros(); model.links.len()];
    take(&closed, &moves[0], &mut found);
    for index in 1..model.links.len() {
        let Some((closed, hinge)) = &passed[index] else { continue };
        let before = carry(&moves[model.links[index].parent], &motion.links[index].arm);
        let open = DVector::from_iterator(hinge.open.len(), hinge.open.iter().map(|row| found[*row]));
        let rates = &hinge.by_open * open - &hinge.by_bias - &hinge.by_motion * before;
        moves[index] = before + &hinge.axes * rates;
        take(closed, &moves[index], &mut found);
    }
    found.iter().all(|x| x.is_finite()).then_some(found)
}

/// The multipliers of rows that closed at a link with this acceleration.
fn take(closed: &Closed, moves: &Vector6<f64>, found: &mut [f64]) {
    let [own, left] = &closed.rows;
    let open = DVector::from_iterator(left.len(), left.iter().map(|row| found[*row]));
    let values = closed.factor.solve(&(&closed.gaps - closed.pulls.tr_mul(moves) - &closed.beside * open));
    own.iter().zip(values.iter()).for_each(|(row, value)| found[*row] = *value);
}

/// The hinge of a link.
fn pass(
    model: &Model,
    index: usize,
    axes: Matrix6xX<f64>,
    at_coordinate: &[Vec<(usize, f64)>],
    own: &mut Carried,
) -> Option<Passed> {
    let (first, count) = (model.links[index].velocity, axes.ncols());
    let named: Vec<usize> = at_coordinate[first..first + count].iter().flatten().map(|(row, _)| *row).collect();
    own.places(&named);
    let mut open = axes.tr_mul(&own.pulls);
    for k in 0..count {
        for (row, factor) in &at_coordinate[first + k] {
            let place = own.places(&[*row])[0];
            open[(k, place)] += factor;
        }
    }
    let motion = axes.tr_mul(&own.inertia);
    let bias = axes.tr_mul(&own.bias);
    let mut pivot = &motion * &axes;
    (0..count).for_each(|k| pivot[(k, k)] += model.coordinates[first + k].armature);
    let factor = pivot.cholesky()?;
    let (by_open, by_bias, by_motion) = (factor.solve(&open), factor.solve(&bias), factor.solve(&motion));
    own.inertia -= motion.tr_mul(&by_motion);
    own.bias -= motion.tr_mul(&by_bias);
    own.pulls -= motion.tr_mul(&by_open);
    own.response += open.tr_mul(&by_open);
    own.rates -= open.tr_mul(&by_bias);
    Some(Passed { axes, open: own.open.clone(), by_open, by_bias, by_motion })
}

/// `H` of a link at its root marker.
fn axes(model: &Model, motion: &Motion, index: usize, kind: Kind) -> Matrix6xX<f64> {
    let (at, link, none) = (&motion.links[index], &model.links[index], Vector3::zeros());
    let axes: Vec<Vector6<f64>> = match kind {
        Kind::Slide => vec![six(&none, &at.axis)],
        Kind::Turn | Kind::Screw => vec![six(&at.axis, &(link.joint.pitch() * at.axis))],
        Kind::Ball => (0..3).map(|k| six(&at.turn.column(k).into_owned(), &none)).collect(),
        _ => Vec::new(),
    };
    Matrix6xX::from_columns(&axes)
}

fn of_body(model: &Model, motion: &Motion, index: usize) -> Matrix6<f64> {
    let (at, mass) = (&motion.links[index], model.links[index].mass);
    let across = mass * at.center.cross_matrix();
    let mut whole = Matrix6::zeros();
    whole.fixed_view_mut::<3, 3>(0, 0).copy_from(&at.inertia.matrix());
    whole.fixed_view_mut::<3, 3>(0, 3).copy_from(&across);
    whole.fixed_view_mut::<3, 3>(3, 0).copy_from(&-across);
    (3..6).for_each(|i| whole[(i, i)] = mass);
    whole
}

/// From the root marker of a link to that of its parent, `arm` before it.
fn shift(own: &mut Carried, arm: &Vector3<f64>) {
    let mut T = Matrix6::identity();
    T.fixed_view_mut::<3, 3>(3, 0).copy_from(&-arm.cross_matrix());
    own.inertia = T.tr_mul(&own.inertia) * T;
    own.bias = T.tr_mul(&own.bias);
    own.pulls = T.tr_mul(&own.pulls);
}

/// `T X`.
fn carry(x: &Vector6<f64>, arm: &Vector3<f64>) -> Vector6<f64> {
    let turn = Vector3::new(x[0], x[1], x[2]);
    six(&turn, &(Vector3::new(x[3], x[4], x[5]) + turn.cross(arm)))
}

fn six(turn: &Vector3<f64>, shift: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(turn.x, turn.y, turn.z, shift.x, shift.y, shift.z)
}
