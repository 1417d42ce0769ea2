//! The transfer relations of one body and one hinge, as named blocks.

use crate::model::Link;
use crate::motion::LinkMotion;
use crate::motion::variation::LinkAcceleration;
use crate::spatial::fused::{cross_add, fma, times_add, transposed_times};
use crate::spatial::{Sym3, Wrench};
use nalgebra::{Matrix3, Vector3};

/// A symmetric 6×6 matrix from accelerations to wrenches: `force = ff r̈ + fm ω̇`, `moment = fmᵀ r̈ + mm ω̇`.
#[derive(Debug, Clone, Copy, Default)]
pub struct Reduced {
    /// Force from linear acceleration (kg).
    pub ff: Sym3,
    /// Force from angular acceleration (kg m).
    pub fm: Matrix3<f64>,
    /// Moment from angular acceleration (kg m²).
    pub mm: Sym3,
}

impl Reduced {
    /// `S a`.
    #[inline(always)]
    pub fn times(&self, a: &LinkAcceleration) -> Wrench {
        Wrench {
            force: times_add(&self.fm, &a.angular, &(self.ff * a.linear)),
            moment: self.mm.times_add(&a.angular, &transposed_times(&self.fm, &a.linear)),
        }
    }

    /// `S −= w wᵀ / D`.
    #[inline(always)]
    pub fn downdate(&mut self, w: &Wrench, inverse_pivot: f64) {
        self.ff.add_outer(-inverse_pivot, &w.force);
        self.mm.add_outer(-inverse_pivot, &w.moment);
        let (p, m, fm) = (-inverse_pivot * w.force, &w.moment, &mut self.fm);
        fm.m11 = fma(p.x, m.x, fm.m11);
        fm.m12 = fma(p.x, m.y, fm.m12);
        fm.m13 = fma(p.x, m.z, fm.m13);
        fm.m21 = fma(p.y, m.x, fm.m21);
        fm.m22 = fma(p.y, m.y, fm.m22);
        fm.m23 = fma(p.y, m.z, fm.m23);
        fm.m31 = fma(p.z, m.x, fm.m31);
        fm.m32 = fma(p.z, m.y, fm.m32);
        fm.m33 = fma(p.z, m.z, fm.m33);
    }

    /// `X(d)ᵀ S X(d)`: the same matrix seen from a marker from which this one is `d` away. Only one triangle of each
    /// symmetric block is computed.
    #[inline(always)]
    pub fn shifted(&self, d: &Vector3<f64>) -> Self {
        // fm' = fm − ff [d]×, row by row: −row [d]× = −(row × d)ᵀ = (d × row)ᵀ
        let (a, b, c) = (&self.ff, &self.fm, &self.mm);
        let row = |ax, ay, az, bx, by, bz| cross_add(d, &Vector3::new(ax, ay, az), &Vector3::new(bx, by, bz));
        let first = row(a.xx, a.xy, a.xz, b.m11, b.m12, b.m13);
        let second = row(a.xy, a.yy, a.yz, b.m21, b.m22, b.m23);
        let third = row(a.xz, a.yz, a.zz, b.m31, b.m32, b.m33);
        // mm' = mm + [d]× fm' + ([d]× fm)ᵀ: entry (i, j) gains (d × column j of fm')ᵢ + (d × column i of fm)ⱼ
        let mm = Sym3 {
            xx: fma(d.y, third.x + b.m31, fma(-d.z, second.x + b.m21, c.xx)),
            yy: fma(d.z, first.y + b.m12, fma(-d.x, third.y + b.m32, c.yy)),
            zz: fma(d.x, second.z + b.m23, fma(-d.y, first.z + b.m13, c.zz)),
            xy: fma(d.y, third.y, fma(-d.z, second.y - b.m11, fma(-d.x, b.m31, c.xy))),
            xz: fma(d.y, third.z - b.m11, fma(-d.z, second.z, fma(d.x, b.m21, c.xz))),
            yz: fma(d.z, first.z, fma(-d.x, third.z - b.m22, fma(-d.y, b.m12, c.yz))),
        };
        Self { ff: *a, fm: Matrix3::from_rows(&[first.transpose(), second.transpose(), third.transpose()]), mm }
    }

    /// `S += M` of eq. (1): mass `m`, centre `c` from the root marker, inertia about the root marker.
    #[inline(always)]
    pub fn add_body(&mut self, mass: f64, center: &Vector3<f64>, inertia: &Sym3) {
        let c = mass * center;
        self.ff.xx += mass;
        self.ff.yy += mass;
        self.ff.zz += mass;
        self.mm += *inertia;
        self.fm.m12 += c.z;
        self.fm.m13 -= c.y;
        self.fm.m21 -= c.z;
        self.fm.m23 += c.x;
        self.fm.m31 += c.y;
        self.fm.m32 -= c.x;
    }

    /// `S += other`.
    #[inline]
    pub fn add(&mut self, other: &Self) {
        self.ff += other.ff;
        self.fm += other.fm;
        self.mm += other.mm;
    }
}

/// The moment that the body's velocities and weight ask for, `b` of eq. (1), in link axes. There the inertia is known to
/// the last digit, and a slender body's small moment of inertia is not drowned in the round-off of its large ones.
#[inline]
pub fn moment_in_link_axes(link: &Link, gravity: &Vector3<f64>, at: &LinkMotion) -> Vector3<f64> {
    let (w, g) = (at.turn.tr_mul(&at.angular_velocity), at.turn.tr_mul(gravity));
    gyroscopic(&link.inertia, &w) - link.mass * link.center.cross(&g)
}

/// `ω × J ω`, as differences of moments of inertia.
#[inline]
pub fn gyroscopic(j: &Sym3, w: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(
        (j.zz - j.yy) * w.y * w.z + j.yz * (w.y * w.y - w.z * w.z) + w.x * (j.xz * w.y - j.xy * w.z),
        (j.xx - j.zz) * w.z * w.x + j.xz * (w.z * w.z - w.x * w.x) + w.y * (j.xy * w.z - j.yz * w.x),
        (j.yy - j.xx) * w.x * w.y + j.xy * (w.x * w.x - w.y * w.y) + w.z * (j.yz * w.x - j.xz * w.y),
    )
}
