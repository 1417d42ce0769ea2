//! The blocks of `S`, the 6×18 matrix from a marker's varied state to the varied wrench.

use crate::motion::variation::LinkVariation;
use crate::spatial::Wrench;
use nalgebra::{Matrix3, Vector3};

/// Block columns of `S`, in the order of `z`.
pub(super) const TURN: usize = 0;
pub(super) const RATE: usize = 2;
pub(super) const TURN_ACCELERATION: usize = 4;
pub(super) const ACCELERATION: usize = 5;

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

impl Column {
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
pub(super) fn apply(S: &Blocks, z: &LinkVariation) -> Wrench {
    let mut sum = Wrench::ZERO;
    for (column, z) in S.iter().zip(blocks(z)) {
        sum.force += column.force * z;
        sum.moment += column.moment * z;
    }
    sum
}

#[inline]
pub(super) fn dot(row: &[Vector3<f64>; 6], z: &LinkVariation, dynamic: bool) -> f64 {
    let count = if dynamic { 6 } else { 2 };
    row.iter().zip(blocks(z)).take(count).map(|(row, z)| row.dot(&z)).sum()
}

#[inline]
pub(super) fn times(row: &[Matrix3<f64>; 6], z: &LinkVariation, dynamic: bool) -> Vector3<f64> {
    let count = if dynamic { 6 } else { 2 };
    row.iter().zip(blocks(z)).take(count).map(|(row, z)| row * z).sum()
}
