//! The blocks of `S`, the 6×18 matrix from a marker's varied state to the varied wrench.

use crate::motion::variation::LinkVariation;
use crate::spatial::Wrench;
use nalgebra::{Matrix3, Vector3};

/// Block columns of `S`, in the order of `z`: places last, for only force elements depend on them.
pub(super) const TURN: usize = 0;
pub(super) const RATE: usize = 1;
pub(super) const TURN_ACCELERATION: usize = 2;
pub(super) const ACCELERATION: usize = 3;
pub(super) const VELOCITY: usize = 5;

/// The column of the position, of the last but one block or, at rest, the last.
pub(super) const fn position<const N: usize>() -> usize {
    if N == AT_REST_IN_PLACE { 1 } else { 4 }
}

/// Force and moment from one block of `z`: 6×3.
#[derive(Debug, Clone, Copy, Default)]
pub struct Column {
    /// Upper three rows.
    pub force: Matrix3<f64>,
    /// Lower three rows.
    pub moment: Matrix3<f64>,
}

/// How many blocks of `z` take part: the turn alone (at rest, no force depends on places).
pub(super) const AT_REST: usize = 1;
/// Turn and place (at rest).
pub(super) const AT_REST_IN_PLACE: usize = 2;
/// Turn, rates and accelerations.
pub(super) const MOVING: usize = 4;
/// All of them.
pub(super) const MOVING_IN_PLACE: usize = 6;

/// How the wrench at a root marker varies with the marker's state: the blocks of `S`, 6×18.
pub(super) type Blocks = [Column; 6];

/// How a force element's wrench varies with a link's turn, place, angular velocity and velocity.
pub type Applied = [Column; 4];

/// Where the blocks of a force element stand among those of `S`.
const fn columns<const N: usize>() -> [Option<usize>; 4] {
    match N {
        AT_REST_IN_PLACE => [Some(TURN), Some(position::<N>()), None, None],
        MOVING_IN_PLACE => [Some(TURN), Some(position::<N>()), Some(RATE), Some(VELOCITY)],
        _ => [None; 4],
    }
}

/// The blocks of a force element at their places among those of `S`.
#[inline]
pub(super) fn placed<const N: usize>(blocks: &Applied) -> [Column; N] {
    let mut S = [Column::default(); N];
    for (block, column) in blocks.iter().zip(columns::<N>()) {
        if let Some(column) = column {
            S[column] = *block;
        }
    }
    S
}

impl Column {
    /// `self += other`.
    #[inline]
    pub(super) fn add(&mut self, other: &Self) {
        self.force += other.force;
        self.moment += other.moment;
    }

    /// `self −= other`.
    #[inline]
    pub(super) fn take(&mut self, other: &Self) {
        self.force -= other.force;
        self.moment -= other.moment;
    }

    /// `self −= other [d]×`.
    #[inline]
    pub(super) fn minus_cross(&mut self, other: &Self, d: &Vector3<f64>) {
        self.force -= times_cross(&other.force, d);
        self.moment -= times_cross(&other.moment, d);
    }

    /// `self −= other M`.
    #[inline]
    pub(super) fn minus(&mut self, other: &Self, matrix: &Matrix3<f64>) {
        self.force -= other.force * matrix;
        self.moment -= other.moment * matrix;
    }

    /// `self ← Xᵀ self`: the moment gains `d × force`.
    #[inline]
    pub(super) fn shift(&mut self, d: &Vector3<f64>) {
        for i in 0..3 {
            let gain = d.cross(&self.force.column(i));
            let mut column = self.moment.column_mut(i);
            column += gain;
        }
    }
}

/// `Y [d]×`, column by column.
#[inline]
pub(super) fn times_cross(y: &Matrix3<f64>, d: &Vector3<f64>) -> Matrix3<f64> {
    let (a, b, c) = (y.column(0), y.column(1), y.column(2));
    Matrix3::from_columns(&[b * d.z - c * d.y, c * d.x - a * d.z, a * d.y - b * d.x])
}

/// `[a]× [b]× = b aᵀ − (a·b) 1`.
#[inline]
pub(super) fn twice(a: &Vector3<f64>, b: &Vector3<f64>) -> Matrix3<f64> {
    b * a.transpose() - Matrix3::from_diagonal_element(a.dot(b))
}

/// `[d]× Y`, column by column.
#[inline]
pub(super) fn cross_times(d: &Vector3<f64>, y: &Matrix3<f64>) -> Matrix3<f64> {
    Matrix3::from_columns(&[0, 1, 2].map(|i| d.cross(&y.column(i))))
}

/// The blocks of `z` in the order of the columns.
#[inline]
fn blocks<const N: usize>(z: &LinkVariation) -> [Vector3<f64>; 6] {
    let second = if N == AT_REST_IN_PLACE { z.position } else { z.angular_velocity };
    [z.turn, second, z.angular_acceleration, z.acceleration, z.position, z.velocity]
}

/// `S z`.
#[inline]
pub(super) fn apply<const N: usize>(S: &[Column; N], z: &LinkVariation) -> Wrench {
    let z = blocks::<N>(z);
    let mut sum = Wrench::ZERO;
    for i in 0..N {
        sum.force += S[i].force * z[i];
        sum.moment += S[i].moment * z[i];
    }
    sum
}

#[inline]
pub(super) fn dot<const N: usize>(row: &[Vector3<f64>; 6], z: &LinkVariation) -> f64 {
    let z = blocks::<N>(z);
    (0..N).map(|i| row[i].dot(&z[i])).sum()
}

#[inline]
pub(super) fn times<const N: usize>(row: &[Matrix3<f64>; 6], z: &LinkVariation) -> Vector3<f64> {
    let z = blocks::<N>(z);
    (0..N).map(|i| row[i] * z[i]).sum()
}
