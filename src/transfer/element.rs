//! The transfer relations of one body and one hinge, as named blocks.

use crate::model::Link;
use crate::motion::LinkMotion;
use crate::motion::variation::LinkAcceleration;
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
    #[inline]
    pub fn times(&self, a: &LinkAcceleration) -> Wrench {
        Wrench {
            force: self.ff * a.linear + self.fm * a.angular,
            moment: self.fm.tr_mul(&a.linear) + self.mm * a.angular,
        }
    }

    /// `S −= w wᵀ / D`.
    #[inline]
    pub fn downdate(&mut self, w: &Wrench, inverse_pivot: f64) {
        self.ff += Sym3::outer(-inverse_pivot, w.force);
        self.mm += Sym3::outer(-inverse_pivot, w.moment);
        self.fm -= (inverse_pivot * w.force) * w.moment.transpose();
    }

    /// `X(d)ᵀ S X(d)`: the same matrix seen from a marker from which this one is `d` away. Only one triangle of each
    /// symmetric block is computed.
    #[inline]
    pub fn shifted(&self, d: &Vector3<f64>) -> Self {
        // fm' = fm − ff [d]×, row by row: −row [d]× = −(row × d)ᵀ
        let (a, b, c) = (&self.ff, &self.fm, &self.mm);
        let row = |ax: f64, ay: f64, az: f64, bx: f64, by: f64, bz: f64| {
            (bx - (ay * d.z - az * d.y), by - (az * d.x - ax * d.z), bz - (ax * d.y - ay * d.x))
        };
        let (m11, m12, m13) = row(a.xx, a.xy, a.xz, b.m11, b.m12, b.m13);
        let (m21, m22, m23) = row(a.xy, a.yy, a.yz, b.m21, b.m22, b.m23);
        let (m31, m32, m33) = row(a.xz, a.yz, a.zz, b.m31, b.m32, b.m33);
        // mm' = mm + [d]× fm' + ([d]× fm)ᵀ: entry (i, j) gains (d × column j of fm')ᵢ + (d × column i of fm)ⱼ
        let mm = Sym3 {
            xx: c.xx + d.y * (m31 + b.m31) - d.z * (m21 + b.m21),
            yy: c.yy + d.z * (m12 + b.m12) - d.x * (m32 + b.m32),
            zz: c.zz + d.x * (m23 + b.m23) - d.y * (m13 + b.m13),
            xy: c.xy + d.y * m32 - d.z * (m22 - b.m11) - d.x * b.m31,
            xz: c.xz + d.y * (m33 - b.m11) - d.z * m23 + d.x * b.m21,
            yz: c.yz + d.z * m13 - d.x * (m33 - b.m22) - d.y * b.m12,
        };
        Self { ff: *a, fm: Matrix3::new(m11, m12, m13, m21, m22, m23, m31, m32, m33), mm }
    }

    /// `S += M` of eq. (1): mass `m`, centre `c` from the root marker, inertia about the root marker.
    #[inline]
    pub fn add_body(&mut self, mass: f64, center: &Vector3<f64>, inertia: &Sym3) {
        let c = mass * center;
        self.ff += Sym3::scalar(mass);
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

/// The moment of [`bias`] in link axes. There the inertia is known to the last digit, and a slender body's small moment
/// of inertia is not drowned in the round-off of its large ones: `ω × J ω` as differences of moments of inertia.
#[inline]
pub fn moment_in_link_axes(link: &Link, gravity: &Vector3<f64>, at: &LinkMotion) -> Vector3<f64> {
    let (w, g, j) = (at.turn.tr_mul(&at.angular_velocity), at.turn.tr_mul(gravity), &link.inertia);
    let gyroscopic = Vector3::new(
        (j.zz - j.yy) * w.y * w.z + j.yz * (w.y * w.y - w.z * w.z) + w.x * (j.xz * w.y - j.xy * w.z),
        (j.xx - j.zz) * w.z * w.x + j.xz * (w.z * w.z - w.x * w.x) + w.y * (j.xy * w.z - j.yz * w.x),
        (j.yy - j.xx) * w.x * w.y + j.xy * (w.x * w.x - w.y * w.y) + w.z * (j.yz * w.x - j.xz * w.y),
    );
    gyroscopic - link.mass * link.center.cross(&g)
}

/// `b` of eq. (1) with gravity: the wrench at the root marker that the body's velocities and weight ask for.
#[inline]
pub fn bias(mass: f64, gravity: &Vector3<f64>, at: &LinkMotion) -> Wrench {
    let (w, c) = (&at.angular_velocity, &at.center);
    // In the same form as the velocity terms of the arms: where the two cancel, so does their round-off.
    let force = mass * (w.cross(&w.cross(c)) - gravity);
    Wrench { force, moment: w.cross(&(at.inertia * *w)) - mass * c.cross(gravity) }
}
