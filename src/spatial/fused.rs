//! Products and sums in one rounding where the processor has that: what the sweeps consist of.
//!
//! Rust never contracts `a * b + c` by itself, so a fused operation is asked for where it is meant, and the same source
//! gives the same bits on every processor with it. Without it a product and a sum take its place: never the emulation of
//! the standard library, which is a hundred times slower.

use nalgebra::{Matrix3, Vector3};

/// `a b + c`.
#[inline(always)]
pub fn fma(a: f64, b: f64, c: f64) -> f64 {
    if cfg!(target_feature = "fma") { a.mul_add(b, c) } else { a * b + c }
}

/// `a · b`.
#[inline(always)]
pub fn dot(a: &Vector3<f64>, b: &Vector3<f64>) -> f64 {
    fma(a.z, b.z, fma(a.y, b.y, a.x * b.x))
}

/// `a · b + c`.
#[inline(always)]
pub fn dot_add(a: &Vector3<f64>, b: &Vector3<f64>, c: f64) -> f64 {
    fma(a.z, b.z, fma(a.y, b.y, fma(a.x, b.x, c)))
}

/// `a × b`.
#[inline(always)]
pub fn cross(a: &Vector3<f64>, b: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(fma(a.y, b.z, -(a.z * b.y)), fma(a.z, b.x, -(a.x * b.z)), fma(a.x, b.y, -(a.y * b.x)))
}

/// `a × b + c`.
#[inline(always)]
pub fn cross_add(a: &Vector3<f64>, b: &Vector3<f64>, c: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(
        fma(a.y, b.z, fma(-a.z, b.y, c.x)),
        fma(a.z, b.x, fma(-a.x, b.z, c.y)),
        fma(a.x, b.y, fma(-a.y, b.x, c.z)),
    )
}

/// `s a + c`.
#[inline(always)]
pub fn scale_add(s: f64, a: &Vector3<f64>, c: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(fma(s, a.x, c.x), fma(s, a.y, c.y), fma(s, a.z, c.z))
}

/// `M a`.
#[inline(always)]
pub fn times(m: &Matrix3<f64>, a: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(
        fma(m.m13, a.z, fma(m.m12, a.y, m.m11 * a.x)),
        fma(m.m23, a.z, fma(m.m22, a.y, m.m21 * a.x)),
        fma(m.m33, a.z, fma(m.m32, a.y, m.m31 * a.x)),
    )
}

/// `M a + c`.
#[inline(always)]
pub fn times_add(m: &Matrix3<f64>, a: &Vector3<f64>, c: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(
        fma(m.m13, a.z, fma(m.m12, a.y, fma(m.m11, a.x, c.x))),
        fma(m.m23, a.z, fma(m.m22, a.y, fma(m.m21, a.x, c.y))),
        fma(m.m33, a.z, fma(m.m32, a.y, fma(m.m31, a.x, c.z))),
    )
}

/// `Mᵀ a`.
#[inline(always)]
pub fn transposed_times(m: &Matrix3<f64>, a: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(
        fma(m.m31, a.z, fma(m.m21, a.y, m.m11 * a.x)),
        fma(m.m32, a.z, fma(m.m22, a.y, m.m12 * a.x)),
        fma(m.m33, a.z, fma(m.m23, a.y, m.m13 * a.x)),
    )
}

/// `A B`, column by column.
#[inline(always)]
pub fn product(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix3<f64> {
    let column = |x, y, z| times(a, &Vector3::new(x, y, z));
    Matrix3::from_columns(&[column(b.m11, b.m21, b.m31), column(b.m12, b.m22, b.m32), column(b.m13, b.m23, b.m33)])
}
