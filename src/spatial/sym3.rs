//! Symmetric 3×3 matrices, one triangle stored: what is symmetric stays so to the last bit.

use nalgebra::{Matrix3, Vector3};
use std::ops::{Add, AddAssign, Mul};

/// A symmetric 3×3 matrix.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[allow(missing_docs)]
pub struct Sym3 {
    pub xx: f64,
    pub yy: f64,
    pub zz: f64,
    pub xy: f64,
    pub xz: f64,
    pub yz: f64,
}

impl Sym3 {
    /// The zero matrix.
    pub const ZERO: Self = Self { xx: 0.0, yy: 0.0, zz: 0.0, xy: 0.0, xz: 0.0, yz: 0.0 };

    /// `s 1`.
    #[inline]
    pub fn scalar(s: f64) -> Self {
        Self { xx: s, yy: s, zz: s, ..Self::ZERO }
    }

    /// `diag(d)`.
    #[inline]
    pub fn diagonal(d: Vector3<f64>) -> Self {
        Self { xx: d.x, yy: d.y, zz: d.z, ..Self::ZERO }
    }

    /// `s v vᵀ`.
    #[inline]
    pub fn outer(s: f64, v: Vector3<f64>) -> Self {
        let w = s * v;
        Self { xx: w.x * v.x, yy: w.y * v.y, zz: w.z * v.z, xy: w.x * v.y, xz: w.x * v.z, yz: w.y * v.z }
    }

    /// The symmetric part of a full matrix.
    pub fn symmetric_part(m: &Matrix3<f64>) -> Self {
        Self {
            xx: m.m11,
            yy: m.m22,
            zz: m.m33,
            xy: 0.5 * (m.m12 + m.m21),
            xz: 0.5 * (m.m13 + m.m31),
            yz: 0.5 * (m.m23 + m.m32),
        }
    }

    /// The same as a full matrix.
    #[inline]
    pub fn matrix(&self) -> Matrix3<f64> {
        Matrix3::new(self.xx, self.xy, self.xz, self.xy, self.yy, self.yz, self.xz, self.yz, self.zz)
    }

    /// `R S Rᵀ`: the same tensor in the axes that `turn` leads to.
    #[inline]
    pub fn turned(&self, turn: &Matrix3<f64>) -> Self {
        let t = turn * self.matrix();
        let entry = |i: usize, j: usize| t[(i, 0)] * turn[(j, 0)] + t[(i, 1)] * turn[(j, 1)] + t[(i, 2)] * turn[(j, 2)];
        Self { xx: entry(0, 0), yy: entry(1, 1), zz: entry(2, 2), xy: entry(0, 1), xz: entry(0, 2), yz: entry(1, 2) }
    }

    /// `s (|d|² 1 − d dᵀ)`: what moving the reference point by `d` adds to the inertia of a mass `s` (Steiner).
    #[inline]
    pub fn steiner(s: f64, d: Vector3<f64>) -> Self {
        let w = s * d;
        Self {
            xx: w.y * d.y + w.z * d.z,
            yy: w.x * d.x + w.z * d.z,
            zz: w.x * d.x + w.y * d.y,
            xy: -w.x * d.y,
            xz: -w.x * d.z,
            yz: -w.y * d.z,
        }
    }

    /// Sum of the diagonal.
    #[inline]
    pub fn trace(&self) -> f64 {
        self.xx + self.yy + self.zz
    }

    /// The inverse by LDLᵀ, and the three pivots; `None` where a pivot is zero or not finite.
    #[inline]
    pub fn inverse(&self) -> Option<(Self, Vector3<f64>)> {
        let d1 = self.xx;
        let (l21, l31) = (self.xy / d1, self.xz / d1);
        let d2 = self.yy - l21 * self.xy;
        let l32 = (self.yz - l31 * self.xy) / d2;
        let d3 = self.zz - l31 * self.xz - l32 * l32 * d2;
        let pivots = Vector3::new(d1, d2, d3);
        if !pivots.iter().all(|d| d.is_finite() && *d != 0.0) {
            return None;
        }
        // Rows of L⁻¹: (1,0,0), (−l21,1,0), (l21 l32 − l31, −l32, 1).
        let m31 = l21 * l32 - l31;
        let (i1, i2, i3) = (1.0 / d1, 1.0 / d2, 1.0 / d3);
        let inverse = Self {
            xx: i1 + l21 * l21 * i2 + m31 * m31 * i3,
            yy: i2 + l32 * l32 * i3,
            zz: i3,
            xy: -l21 * i2 - m31 * l32 * i3,
            xz: m31 * i3,
            yz: -l32 * i3,
        };
        Some((inverse, pivots))
    }
}

impl Mul<Vector3<f64>> for Sym3 {
    type Output = Vector3<f64>;
    #[inline]
    fn mul(self, v: Vector3<f64>) -> Vector3<f64> {
        Vector3::new(
            self.xx * v.x + self.xy * v.y + self.xz * v.z,
            self.xy * v.x + self.yy * v.y + self.yz * v.z,
            self.xz * v.x + self.yz * v.y + self.zz * v.z,
        )
    }
}

impl Add for Sym3 {
    type Output = Self;
    #[inline]
    fn add(self, o: Self) -> Self {
        Self {
            xx: self.xx + o.xx,
            yy: self.yy + o.yy,
            zz: self.zz + o.zz,
            xy: self.xy + o.xy,
            xz: self.xz + o.xz,
            yz: self.yz + o.yz,
        }
    }
}

impl AddAssign for Sym3 {
    #[inline]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}
