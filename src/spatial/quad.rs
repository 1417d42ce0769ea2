//! Three-vectors and 3×3 matrices in registers of four lanes: what the sweeps compute with between loads and stores.
//!
//! A matrix is three columns, so `M a` is three products with one number each, and a whole reduced matrix stays in
//! registers, where single numbers would be moved to and fro. The fourth lane is idle; nothing reads it. Products and
//! sums are fused where the processor has that (`wide` asks for it), never emulated.

use super::{Sym3, Wrench};
use nalgebra::{Matrix3, Vector3};
use std::ops::{Add, AddAssign, Mul, Neg, Sub};
use wide::f64x4;

/// A three-vector.
#[derive(Debug, Clone, Copy, Default)]
pub struct Quad(f64x4);

/// A 3×3 matrix by its columns.
#[derive(Debug, Clone, Copy, Default)]
pub struct Columns(pub [Quad; 3]);

impl Quad {
    /// Of three numbers. The idle lane repeats the last: a zero there would cost an instruction.
    #[inline(always)]
    pub const fn new(x: f64, y: f64, z: f64) -> Self {
        Self(f64x4::new([x, y, z, z]))
    }

    /// Of a vector in memory.
    #[inline(always)]
    pub fn of(v: &Vector3<f64>) -> Self {
        Self::new(v.x, v.y, v.z)
    }

    /// One number in every lane.
    #[inline(always)]
    pub fn all(s: f64) -> Self {
        Self(f64x4::splat(s))
    }

    /// Back to a vector in memory.
    #[inline(always)]
    pub fn vector(self) -> Vector3<f64> {
        let [x, y, z, _] = self.0.to_array();
        Vector3::new(x, y, z)
    }

    /// One component.
    #[inline(always)]
    pub fn at(self, i: usize) -> f64 {
        self.0.to_array()[i]
    }

    /// `self · b + c`, lane by lane.
    #[inline(always)]
    pub fn times_add(self, b: Self, c: Self) -> Self {
        Self(self.0.mul_add(b.0, c.0))
    }

    /// `c − self · b`, lane by lane.
    #[inline(always)]
    pub fn times_from(self, b: Self, c: Self) -> Self {
        Self(self.0.mul_neg_add(b.0, c.0))
    }

    #[inline(always)]
    fn yzx(self) -> Self {
        let [x, y, z, rest] = self.0.to_array();
        Self(f64x4::new([y, z, x, rest]))
    }

    #[inline(always)]
    fn zxy(self) -> Self {
        let [x, y, z, rest] = self.0.to_array();
        Self(f64x4::new([z, x, y, rest]))
    }

    /// `self × b + c`.
    #[inline(always)]
    pub fn cross_add(self, b: Self, c: Self) -> Self {
        self.yzx().times_add(b.zxy(), self.zxy().times_from(b.yzx(), c))
    }

    /// `self × b`.
    #[inline(always)]
    pub fn cross(self, b: Self) -> Self {
        let subtracted = self.zxy() * b.yzx();
        Self(self.yzx().0.mul_sub(b.zxy().0, subtracted.0))
    }

    /// `x², y², z²` and `xy, xz, yz`.
    #[inline(always)]
    pub fn squares(self) -> (Self, Self) {
        let [x, y, z, rest] = self.0.to_array();
        (self * self, Self(f64x4::new([x, x, y, rest])) * Self(f64x4::new([y, z, z, rest])))
    }

    /// `self · b` as a number.
    #[inline(always)]
    pub fn dot(self, b: Self) -> f64 {
        (self * b).sum()
    }

    /// Sum of the three components.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        let [x, y, z, _] = self.0.to_array();
        x + y + z
    }
}

impl Columns {
    /// Of a matrix in memory.
    #[inline(always)]
    pub fn of(m: &Matrix3<f64>) -> Self {
        Self([Quad::new(m.m11, m.m21, m.m31), Quad::new(m.m12, m.m22, m.m32), Quad::new(m.m13, m.m23, m.m33)])
    }

    /// Of a symmetric matrix in memory.
    #[inline(always)]
    pub fn symmetric(s: &Sym3) -> Self {
        Self([Quad::new(s.xx, s.xy, s.xz), Quad::new(s.xy, s.yy, s.yz), Quad::new(s.xz, s.yz, s.zz)])
    }

    /// Back to a matrix in memory.
    #[inline(always)]
    pub fn matrix(&self) -> Matrix3<f64> {
        let [x, y, z] = self.0;
        let [x, y, z] = [x.vector(), y.vector(), z.vector()];
        Matrix3::new(x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z)
    }

    /// Its lower triangle.
    #[inline(always)]
    pub fn triangle(&self) -> Sym3 {
        let [x, y, z] = self.0;
        Sym3 { xx: x.at(0), yy: y.at(1), zz: z.at(2), xy: x.at(1), xz: x.at(2), yz: y.at(2) }
    }

    /// The lower triangle on both sides: what is symmetric stays so to the last bit.
    #[inline(always)]
    pub fn mirrored(&self) -> Self {
        let [x, y, z] = self.0;
        Self([x, Quad::new(x.at(1), y.at(1), y.at(2)), Quad::new(x.at(2), y.at(2), z.at(2))])
    }

    /// `Mᵀ`.
    #[inline(always)]
    pub fn transposed(&self) -> Self {
        let [x, y, z] = self.0;
        let row = |i| Quad::new(x.at(i), y.at(i), z.at(i));
        Self([row(0), row(1), row(2)])
    }

    /// Sum of the diagonal.
    #[inline(always)]
    pub fn trace(&self) -> f64 {
        let [x, y, z] = self.0;
        x.at(0) + y.at(1) + z.at(2)
    }

    /// `M a`, `a` taken from memory number by number.
    #[inline(always)]
    pub fn times(&self, a: &Vector3<f64>) -> Quad {
        let [x, y, z] = self.0;
        Quad::all(a.z).times_add(z, Quad::all(a.y).times_add(y, Quad::all(a.x) * x))
    }

    /// `M a + c`.
    #[inline(always)]
    pub fn times_add(&self, a: &Vector3<f64>, c: Quad) -> Quad {
        let [x, y, z] = self.0;
        Quad::all(a.z).times_add(z, Quad::all(a.y).times_add(y, Quad::all(a.x).times_add(x, c)))
    }

    /// `self · B`.
    #[inline(always)]
    pub fn product(&self, b: &Matrix3<f64>) -> Self {
        Self([
            self.times(&Vector3::new(b.m11, b.m21, b.m31)),
            self.times(&Vector3::new(b.m12, b.m22, b.m32)),
            self.times(&Vector3::new(b.m13, b.m23, b.m33)),
        ])
    }

    /// `A B`.
    #[inline(always)]
    pub fn by(&self, b: &Self) -> Self {
        let [x, y, z] = b.0;
        Self([self.times(&x.vector()), self.times(&y.vector()), self.times(&z.vector())])
    }

    /// `self + s 1`.
    #[inline(always)]
    pub fn plus_scalar(&self, s: Quad) -> Self {
        const AXES: [Quad; 3] = [Quad::new(1.0, 0.0, 0.0), Quad::new(0.0, 1.0, 0.0), Quad::new(0.0, 0.0, 1.0)];
        let [x, y, z] = self.0;
        Self([s.times_add(AXES[0], x), s.times_add(AXES[1], y), s.times_add(AXES[2], z)])
    }

    /// `self − [d]×`.
    #[inline(always)]
    pub fn minus_cross_of(&self, d: Quad) -> Self {
        const SIGNS: [Quad; 3] = [Quad::new(0.0, -1.0, 1.0), Quad::new(1.0, 0.0, -1.0), Quad::new(-1.0, 1.0, 0.0)];
        let ([x, y, z], [dx, dy, dz]) = (self.0, [d.at(0), d.at(1), d.at(2)]);
        Self([
            Quad::new(dx, dz, dy).times_add(SIGNS[0], x),
            Quad::new(dz, dy, dx).times_add(SIGNS[1], y),
            Quad::new(dy, dx, dz).times_add(SIGNS[2], z),
        ])
    }

    /// `self − M [d]×`.
    #[inline(always)]
    pub fn minus_cross(&self, m: &Self, d: &Vector3<f64>) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, m.0);
        let (dx, dy, dz) = (Quad::all(d.x), Quad::all(d.y), Quad::all(d.z));
        Self([
            dy.times_add(z, dz.times_from(y, a)),
            dz.times_add(x, dx.times_from(z, b)),
            dx.times_add(y, dy.times_from(x, c)),
        ])
    }

    /// `self + [d]× M`.
    #[inline(always)]
    pub fn plus_cross(&self, d: &Vector3<f64>, m: &Self) -> Self {
        let (d, [a, b, c], [x, y, z]) = (Quad::of(d), self.0, m.0);
        Self([d.cross_add(x, a), d.cross_add(y, b), d.cross_add(z, c)])
    }

    /// `self + [a]× [b]×`, which is `b aᵀ − (a·b) 1`.
    #[inline(always)]
    pub fn plus_twice(&self, a: &Vector3<f64>, b: &Vector3<f64>) -> Self {
        let b_negative = -Quad::of(b);
        self.minus_dyad(b_negative, Quad::of(a)).plus_scalar(Quad::all(b_negative.dot(Quad::of(a))))
    }

    /// `self − v wᵀ`.
    #[inline(always)]
    pub fn minus_dyad(&self, v: Quad, w: Quad) -> Self {
        let [a, b, c] = self.0;
        Self([
            v.times_from(Quad::all(w.at(0)), a),
            v.times_from(Quad::all(w.at(1)), b),
            v.times_from(Quad::all(w.at(2)), c),
        ])
    }

    /// `self − s v wᵀ`. For `v = w` what is symmetric stays so: the products of `v` and `w` come first.
    #[inline(always)]
    pub fn minus_outer(&self, s: Quad, v: Quad, w: Quad) -> Self {
        let [a, b, c] = self.0;
        let column = |i, sum| s.times_from(v * Quad::all(w.at(i)), sum);
        Self([column(0, a), column(1, b), column(2, c)])
    }
}

impl Sub for Columns {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, o.0);
        Self([a - x, b - y, c - z])
    }
}

impl Add for Columns {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, o.0);
        Self([a + x, b + y, c + z])
    }
}

impl AddAssign for Columns {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl Add for Quad {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0)
    }
}

impl AddAssign for Quad {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl Sub for Quad {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self(self.0 - o.0)
    }
}

impl Neg for Quad {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Mul for Quad {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self(self.0 * o.0)
    }
}

/// A wrench of two.
#[inline(always)]
pub fn wrench(force: Quad, moment: Quad) -> Wrench {
    Wrench { force: force.vector(), moment: moment.vector() }
}
