//! One number of several systems side by side, and vectors and matrices of such numbers: what ensembles compute with.
//!
//! [`super::quad`] has the three components of one vector in a register; here a register has one component of the vectors of
//! [`WIDTH`] systems. No lane is idle, and nothing is moved across lanes.

pub mod link;

pub use link::LinkLanes;
use nalgebra::{Matrix3, Vector3};

/// How many systems are computed side by side: as many as a register of the processor that it is compiled for has numbers.
#[cfg(not(target_feature = "avx512f"))]
pub const WIDTH: usize = 4;
/// How many systems are computed side by side: as many as a register of the processor that it is compiled for has numbers.
#[cfg(target_feature = "avx512f")]
pub const WIDTH: usize = 8;

/// One number of every system.
#[cfg(not(target_feature = "avx512f"))]
pub type Lanes = wide::f64x4;
/// One number of every system.
#[cfg(target_feature = "avx512f")]
pub type Lanes = wide::f64x8;

/// A three-vector of every system.
pub type LaneVector = [Lanes; 3];
/// A 3×3 matrix of every system, by its columns.
pub type LaneMatrix = [LaneVector; 3];
/// A symmetric 3×3 matrix of every system: xx, xy, xz, yy, yz, zz.
pub type LaneSymmetric = [Lanes; 6];

/// Where the entries of a symmetric matrix are in the list of six.
pub const AT: [[usize; 3]; 3] = [[0, 1, 2], [1, 3, 4], [2, 4, 5]];

/// A force and a moment on every system.
#[derive(Debug, Clone, Copy, Default)]
pub struct LaneWrench {
    /// Force (N).
    pub force: LaneVector,
    /// Moment (N m).
    pub moment: LaneVector,
}

/// One number in every lane.
#[inline(always)]
pub fn all(x: f64) -> Lanes {
    Lanes::splat(x)
}

/// A number that each system has of its own.
#[inline]
pub fn each(of: impl FnMut(usize) -> f64) -> Lanes {
    Lanes::new(std::array::from_fn(of))
}

/// A vector that each system has of its own.
#[inline]
pub fn each_vector(mut of: impl FnMut(usize) -> Vector3<f64>) -> LaneVector {
    let own: [Vector3<f64>; WIDTH] = std::array::from_fn(&mut of);
    vector(|i| each(|lane| own[lane][i]))
}

/// A matrix that each system has of its own.
#[inline]
pub fn each_matrix(mut of: impl FnMut(usize) -> Matrix3<f64>) -> LaneMatrix {
    let own: [Matrix3<f64>; WIDTH] = std::array::from_fn(&mut of);
    std::array::from_fn(|column| vector(|i| each(|lane| own[lane][(i, column)])))
}

/// The vector of one system.
#[inline]
pub fn of_lane(v: &LaneVector, lane: usize) -> Vector3<f64> {
    Vector3::from(v.map(|x| x.to_array()[lane]))
}

/// The matrix of one system.
#[inline]
pub fn matrix_of_lane(m: &LaneMatrix, lane: usize) -> Matrix3<f64> {
    Matrix3::from_columns(&[0, 1, 2].map(|column| of_lane(&m[column], lane)))
}

/// By components.
#[inline(always)]
pub fn vector(of: impl FnMut(usize) -> Lanes) -> LaneVector {
    std::array::from_fn(of)
}

/// `a b + c`
#[inline(always)]
pub fn fma(a: Lanes, b: Lanes, c: Lanes) -> Lanes {
    a.mul_add(b, c)
}

/// `c − a b`
#[inline(always)]
pub fn less(a: Lanes, b: Lanes, c: Lanes) -> Lanes {
    a.mul_neg_add(b, c)
}

/// `a + b`
#[inline(always)]
pub fn sum(a: &LaneVector, b: &LaneVector) -> LaneVector {
    vector(|i| a[i] + b[i])
}

/// `a − b`
#[inline(always)]
pub fn difference(a: &LaneVector, b: &LaneVector) -> LaneVector {
    vector(|i| a[i] - b[i])
}

/// `s a`
#[inline(always)]
pub fn scaled(s: Lanes, a: &LaneVector) -> LaneVector {
    vector(|i| s * a[i])
}

/// `s a + b`
#[inline(always)]
pub fn scale_add(s: Lanes, a: &LaneVector, b: &LaneVector) -> LaneVector {
    vector(|i| fma(s, a[i], b[i]))
}

/// `a · b`
#[inline(always)]
pub fn dot(a: &LaneVector, b: &LaneVector) -> Lanes {
    fma(a[0], b[0], fma(a[1], b[1], a[2] * b[2]))
}

/// `a · b + c`
#[inline(always)]
pub fn dot_add(a: &LaneVector, b: &LaneVector, c: Lanes) -> Lanes {
    fma(a[0], b[0], fma(a[1], b[1], fma(a[2], b[2], c)))
}

/// `a × b`
#[inline(always)]
pub fn cross(a: &LaneVector, b: &LaneVector) -> LaneVector {
    vector(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        less(a[k], b[j], a[j] * b[k])
    })
}

/// `a × b + c`
#[inline(always)]
pub fn cross_add(a: &LaneVector, b: &LaneVector, c: &LaneVector) -> LaneVector {
    vector(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        less(a[k], b[j], fma(a[j], b[k], c[i]))
    })
}

/// `M v`
#[inline(always)]
pub fn times(m: &LaneMatrix, v: &LaneVector) -> LaneVector {
    vector(|i| fma(m[0][i], v[0], fma(m[1][i], v[1], m[2][i] * v[2])))
}

/// `M v + c`
#[inline(always)]
pub fn times_add(m: &LaneMatrix, v: &LaneVector, c: &LaneVector) -> LaneVector {
    vector(|i| fma(m[0][i], v[0], fma(m[1][i], v[1], fma(m[2][i], v[2], c[i]))))
}

/// `Mᵀ v`
#[inline(always)]
pub fn transposed_times(m: &LaneMatrix, v: &LaneVector) -> LaneVector {
    vector(|i| dot(&m[i], v))
}

/// `S v`
#[inline(always)]
pub fn symmetric_times(s: &LaneSymmetric, v: &LaneVector) -> LaneVector {
    vector(|i| fma(s[AT[i][0]], v[0], fma(s[AT[i][1]], v[1], s[AT[i][2]] * v[2])))
}

/// `S v + c`
#[inline(always)]
pub fn symmetric_times_add(s: &LaneSymmetric, v: &LaneVector, c: &LaneVector) -> LaneVector {
    vector(|i| fma(s[AT[i][0]], v[0], fma(s[AT[i][1]], v[1], fma(s[AT[i][2]], v[2], c[i]))))
}

/// Sum of the diagonal.
#[inline(always)]
pub fn trace(s: &LaneSymmetric) -> Lanes {
    s[0] + s[3] + s[5]
}
