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

/// How much of `z` takes part: the turn alone (at rest, no force depends on places), turn and place (at rest), or all.
pub(super) const AT_REST: usize = 1;
/// With forces that depend on places.
pub(super) const AT_REST_IN_PLACE: usize = 2;
/// Velocities and accelerations too.
pub(super) const MOVING: usize = 6;

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
pub(super) fn apply<const N: usize>(S: &[Column; N], z: &LinkVariation) -> Wrench {
    let z = blocks(z);
    let mut sum = Wrench::ZERO;
    for i in 0..N {
        sum.force += S[i].force * z[i];
        sum.moment += S[i].moment * z[i];
    }
    sum
}

#[inline]
pub(super) fn dot<const N: usize>(row: &[Vector3<f64>; 6], z: &LinkVariation) -> f64 {
    let z = blocks(z);
    (0..N).map(|i| row[i].dot(&z[i])).sum()
}

#[inline]
pub(super) fn times<const N: usize>(row: &[Matrix3<f64>; 6], z: &LinkVariation) -> Vector3<f64> {
    let z = blocks(z);
    (0..N).map(|i| row[i] * z[i]).sum()
}
