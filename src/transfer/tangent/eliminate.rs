//! The elimination of one hinge.

use super::blocks::{Applied, Column, TURN, apply, placed};
use super::hinge::Hinge;
use crate::motion::variation::LinkVariation;
use crate::spatial::{Sym3, Wrench};
use nalgebra::{Matrix3, Vector3};

/// What is left of a hinge with one coordinate.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct One {
    pub(super) w: Wrench,
    pub(super) row: [Vector3<f64>; 6],
    /// `D⁻¹`.
    pub(super) inverse: f64,
}

/// What is left of a ball, inertial axes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Three {
    pub(super) w: Column,
    pub(super) row: [Matrix3<f64>; 6],
    /// `D⁻¹`.
    pub(super) inverse: Matrix3<f64>,
}

/// How force elements between a link and its parent couple the two: what each feels when the other moves.
#[derive(Debug, Clone, Copy, Default)]
pub struct Coupling {
    /// The link's wrench when its parent moves.
    pub by_parent: Applied,
    /// The parent's wrench, at its own marker, when the link moves.
    pub on_parent: Applied,
}

/// Eqs. (4) and (6) for one coordinate: `S ← Xᵀ S T − w D⁻¹ row`.
#[inline]
pub(super) fn eliminate_one<const N: usize>(
    hinge: &Hinge,
    S: &mut [Column; N],
    f: &Wrench,
    kappa: f64,
    coupling: Option<&Coupling>,
) -> Option<(One, NegativeAxes)> {
    let (n, d, slides) = (hinge.axis, &hinge.arm, hinge.slides);
    let reach = hinge.reach_one(S);
    let D = kappa + if slides { n.dot(&reach.force) } else { n.dot(&reach.moment) };
    if D == 0.0 || D.is_nan() {
        return None;
    }
    // Zero for a coordinate that is held.
    let inverse = 1.0 / D;
    hinge.compose(S);
    if let Some(coupling) = coupling {
        S.iter_mut().zip(placed::<N>(&coupling.by_parent)).for_each(|(sum, block)| sum.take(&block));
    }
    hinge.shift(S);
    // The row of Xᵀ S T: the shift leaves forces as they are, and takes d × force off the moments.
    let mut row = [Vector3::zeros(); 6];
    // nᵀ (moment − [d]× force) = nᵀ moment + (d × n)ᵀ force
    let across_arm = d.cross(&n);
    for (row, column) in row.iter_mut().zip(S.iter()) {
        *row = match slides {
            true => column.force.tr_mul(&n),
            false => column.moment.tr_mul(&n) + column.force.tr_mul(&across_arm),
        };
    }
    row[TURN] += if slides { n.cross(&f.force) } else { n.cross(&f.moment) };
    let mut w = reach.shifted(*d);
    if slides {
        w.moment += n.cross(&f.force);
    }
    if let Some(coupling) = coupling {
        let mut moved = placed::<N>(&coupling.on_parent);
        w = w - hinge.reach_one(&moved);
        hinge.compose(&mut moved);
        S.iter_mut().zip(&moved).for_each(|(sum, block)| sum.take(block));
    }
    let (force, moment) = (inverse * w.force, inverse * w.moment);
    for (column, row) in S.iter_mut().zip(&row) {
        column.force -= force * row.transpose();
        column.moment -= moment * row.transpose();
    }
    let negative = if D < 0.0 { NegativeAxes::one(n) } else { NegativeAxes::default() };
    Some((One { w, row, inverse }, negative))
}

/// Eqs. (4) and (6) for a ball, in inertial axes; `kappa` likewise.
pub(super) fn eliminate_ball<const N: usize>(
    hinge: &Hinge,
    S: &mut [Column; N],
    f: &Wrench,
    kappa: &Matrix3<f64>,
    held: bool,
    coupling: Option<&Coupling>,
) -> Result<(Three, NegativeAxes), Vector3<f64>> {
    let d = &hinge.arm;
    let mut reach = reach_ball(hinge, S);
    let turned = f.moment.cross_matrix();
    let D = reach.moment + turned + kappa;
    let inverse = match held {
        true => Matrix3::zeros(),
        false => D
            .try_inverse()
            .filter(|inverse| inverse.iter().all(|x| x.is_finite()))
            .ok_or(hinge.turn.column(0).into_owned())?,
    };
    hinge.compose(S);
    if let Some(coupling) = coupling {
        S.iter_mut().zip(placed::<N>(&coupling.by_parent)).for_each(|(sum, block)| sum.take(&block));
    }
    hinge.shift(S);
    let mut row = [Matrix3::zeros(); 6];
    for (row, column) in row.iter_mut().zip(S.iter()) {
        *row = column.moment - d.cross_matrix() * column.force;
    }
    row[TURN] += turned;
    reach.shift(d);
    if let Some(coupling) = coupling {
        let mut moved = placed::<N>(&coupling.on_parent);
        reach.take(&reach_ball(hinge, &moved));
        hinge.compose(&mut moved);
        S.iter_mut().zip(&moved).for_each(|(sum, block)| sum.take(block));
    }
    let weighted = Column { force: reach.force * inverse, moment: reach.moment * inverse };
    for (column, row) in S.iter_mut().zip(&row) {
        column.force -= weighted.force * row;
        column.moment -= weighted.moment * row;
    }
    let negative = if held { NegativeAxes::default() } else { NegativeAxes::of(&D) };
    Ok((Three { w: reach, row, inverse }, negative))
}

/// `S h` for the three turns of a ball.
#[inline]
fn reach_ball<const N: usize>(hinge: &Hinge, S: &[Column; N]) -> Column {
    let mut reach = Column::default();
    for axis in 0..3 {
        let mut h = LinkVariation::default();
        hinge.add_ball(&mut h, &Vector3::ith(axis, 1.0));
        let wrench = apply(S, &h);
        reach.force.set_column(axis, &wrench.force);
        reach.moment.set_column(axis, &wrench.moment);
    }
    reach
}

/// The directions in which one hinge's pivot is negative: at most three, no memory asked for.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct NegativeAxes {
    axes: [Vector3<f64>; 3],
    count: usize,
}

impl NegativeAxes {
    fn one(axis: Vector3<f64>) -> Self {
        Self { axes: [axis, Vector3::zeros(), Vector3::zeros()], count: 1 }
    }

    /// Eigenvectors of negative eigenvalues of the symmetric part; none for a positive definite one.
    fn of(D: &Matrix3<f64>) -> Self {
        let part = Sym3::symmetric_part(D);
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

    pub(super) fn len(&self) -> usize {
        self.count
    }

    pub(super) fn first(&self) -> Option<&Vector3<f64>> {
        self.axes[..self.count].first()
    }
}
