//! Symmetric 3×3 matrices, one triangle stored: what is symmetric stays so to the last bit.

use super::fused::{fma, product};
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

    /// `self += s v vᵀ`.
    #[inline(always)]
    pub fn add_outer(&mut self, s: f64, v: &Vector3<f64>) {
        let w = s * v;
        self.xx = fma(w.x, v.x, self.xx);
        self.yy = fma(w.y, v.y, self.yy);
        self.zz = fma(w.z, v.z, self.zz);
        self.xy = fma(w.x, v.y, self.xy);
        self.xz = fma(w.x, v.z, self.xz);
        self.yz = fma(w.y, v.z, self.yz);
    }

    /// `S v + c`.
    #[inline(always)]
    pub fn times_add(&self, v: &Vector3<f64>, c: &Vector3<f64>) -> Vector3<f64> {
        Vector3::new(
            fma(self.xz, v.z, fma(self.xy, v.y, fma(self.xx, v.x, c.x))),
            fma(self.yz, v.z, fma(self.yy, v.y, fma(self.xy, v.x, c.y))),
            fma(self.zz, v.z, fma(self.yz, v.y, fma(self.xz, v.x, c.z))),
        )
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

    /// This tensor as a full matrix.
    #[inline]
    pub fn matrix(&self) -> Matrix3<f64> {
        Matrix3::new(self.xx, self.xy, self.xz, self.xy, self.yy, self.yz, self.xz, self.yz, self.zz)
    }

    /// `R S Rᵀ`: the same tensor in the axes that `turn` leads to.
    #[inline]
    pub fn turned(&self, turn: &Matrix3<f64>) -> Self {
        let t = product(turn, &self.matrix());
        let entry =
            |i: usize, j: usize| fma(t[(i, 2)], turn[(j, 2)], fma(t[(i, 1)], turn[(j, 1)], t[(i, 0)] * turn[(j, 0)]));
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

    /// The inverse by LDLᵀ, and the three pivots; `None` if a pivot is zero or not finite.
    #[inline]
    pub fn inverse(&self) -> Option<(Self, Vector3<f64>)> {
        let d1 = self.xx;
        let i1 = 1.0 / d1;
        let (l21, l31) = (self.xy * i1, self.xz * i1);
        let d2 = fma(-l21, self.xy, self.yy);
        let i2 = 1.0 / d2;
        let under = fma(-l31, self.xy, self.yz);
        let l32 = under * i2;
        let d3 = fma(-l32, under, fma(-l31, self.xz, self.zz));
        let i3 = 1.0 / d3;
        let pivots = Vector3::new(d1, d2, d3);
        if !pivots.iter().all(|d| d.is_finite() && *d != 0.0) {
            return None;
        }
        // Rows of L⁻¹: (1,0,0), (−l21,1,0), (l21 l32 − l31, −l32, 1).
        let m31 = fma(l21, l32, -l31);
        let (xz, yz) = (m31 * i3, -l32 * i3);
        let inverse = Self {
            xx: fma(m31, xz, fma(l21 * l21, i2, i1)),
            yy: fma(-l32, yz, i2),
            zz: i3,
            xy: fma(m31, yz, -l21 * i2),
            xz,
            yz,
        };
        Some((inverse, pivots))
    }
}

impl Mul<Vector3<f64>> for Sym3 {
    type Output = Vector3<f64>;
    #[inline]
    fn mul(self, v: Vector3<f64>) -> Vector3<f64> {
        Vector3::new(
            fma(self.xz, v.z, fma(self.xy, v.y, self.xx * v.x)),
            fma(self.yz, v.z, fma(self.yy, v.y, self.xy * v.x)),
            fma(self.zz, v.z, fma(self.yz, v.y, self.xz * v.x)),
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
