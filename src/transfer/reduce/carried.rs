//! What a link passes on to its parent, in registers.

use super::{LOST, Lost, One, SINGULAR};
use crate::model::Link;
use crate::motion::LinkMotion;
use crate::spatial::Wrench;
use crate::spatial::quad::{Columns, Quad, wrench};
use crate::transfer::element::Reduced;
use nalgebra::Vector3;

/// `S` and `e` of eq. (4); `ff` and `mm` are symmetric to the last bit.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Carried {
    ff: Columns,
    fm: Columns,
    mm: Columns,
    force: Quad,
    moment: Quad,
}

impl Carried {
    /// Of what is in memory.
    #[inline]
    pub(super) fn of(S: &Reduced, e: &Wrench) -> Self {
        Self {
            ff: Columns::symmetric(&S.ff),
            fm: Columns::of(&S.fm),
            mm: Columns::symmetric(&S.mm),
            force: Quad::of(&e.force),
            moment: Quad::of(&e.moment),
        }
    }

    /// `S` in memory.
    #[inline]
    pub(super) fn matrix(&self) -> Reduced {
        Reduced { ff: self.ff.triangle(), fm: self.fm.matrix(), mm: self.mm.triangle() }
    }

    /// `e` in memory.
    #[inline]
    pub(super) fn vector(&self) -> Wrench {
        wrench(self.force, self.moment)
    }

    /// What branches carry, summed.
    #[inline(always)]
    pub(super) fn add(&mut self, other: &Self) {
        self.ff += other.ff;
        self.fm += other.fm;
        self.mm += other.mm;
        self.force += other.force;
        self.moment += other.moment;
    }

    /// With what the link itself adds by eq. (1): `M`, `b` with the weight, and what is applied to it.
    #[inline(always)]
    pub(super) fn with_body(&self, mass: f64, at: &LinkMotion, gravity: &Vector3<f64>) -> Self {
        let (mass, J) = (Quad::all(mass), Columns::symmetric(&at.inertia));
        let (w, c, g) = (Quad::of(&at.angular_velocity), Quad::of(&at.center), Quad::of(gravity));
        let mc = mass * c;
        // In the same form as the velocity terms of the arms: where the two cancel, so does their round-off.
        let swing = w.cross(w.cross(c)) - g;
        let gyroscopic = w.cross_add(J.times(&at.angular_velocity), g.cross(mc));
        Self {
            ff: self.ff.plus_scalar(mass),
            fm: self.fm.minus_cross_of(mc),
            mm: self.mm + J,
            force: self.force + mass * swing,
            moment: self.moment + gyroscopic,
        }
    }

    /// Less a wrench that acts on the link.
    #[inline(always)]
    pub(super) fn loaded(&self, applied: &Wrench) -> Self {
        Self { force: self.force - Quad::of(&applied.force), moment: self.moment - Quad::of(&applied.moment), ..*self }
    }

    /// Eqs. (5) and (6) for a turn: its factors; on failure the pivot.
    #[inline(always)]
    pub(super) fn turn(&self, axis: &Vector3<f64>, armature: f64, tau: f64) -> Result<Left, f64> {
        let n = Quad::of(axis);
        let (force, moment) = (self.fm.times(axis), self.mm.times(axis));
        Left::of(force, moment, n.dot(moment) + armature, self.mm.trace(), tau - n.dot(self.moment))
    }

    /// Eqs. (5) and (6) for a screw, `H = [p n; n]`.
    #[inline]
    pub(super) fn screw(&self, axis: &Vector3<f64>, pitch: f64, armature: f64, tau: f64) -> Result<Left, f64> {
        let (n, p) = (Quad::of(axis), Quad::all(pitch));
        let force = p.times_add(self.ff.times(axis), self.fm.times(axis));
        let moment = p.times_add(self.fm.transposed().times(axis), self.mm.times(axis));
        let along = |force: Quad, moment: Quad| n.dot(p.times_add(force, moment));
        let seen = self.mm.trace() + pitch * pitch * self.ff.trace();
        Left::of(force, moment, along(force, moment) + armature, seen, tau - along(self.force, self.moment))
    }

    /// Eqs. (5) and (6) for a turn or screw below which bodies may resist hardly anything: notes if digits are lost. The
    /// elimination multiplies what is known of the rest by the square of `|S H|/D`.
    #[inline(always)]
    pub(super) fn delicate(
        &self,
        axis: &Vector3<f64>,
        pitch: f64,
        armature: f64,
        tau: f64,
        lost: &mut Lost,
    ) -> Result<Left, f64> {
        let left = if pitch == 0.0 { self.turn(axis, armature, tau)? } else { self.screw(axis, pitch, armature, tau)? };
        let D = 1.0 / left.inverse;
        if D < LOST * self.mm.trace() && D * D < LOST * left.moment.dot(left.moment) {
            *lost = Lost::Perhaps.max(*lost);
        }
        Ok(left)
    }

    /// Eqs. (5) and (6) for a turn or screw with a last link that is slender, by its numbers in its own axes: there the moment
    /// part of `S H` and of `D` is a column of its inertia and that of `Hᵀ e` is its `axial` moment. Turned to inertial axes they are known to the round-off of its largest
    /// moment, which the elimination would multiply by the square of `|S H|/D`. Also `S` and `e` that agree with them.
    #[inline(always)]
    pub(super) fn slender(
        &self,
        link: &Link,
        at: &LinkMotion,
        armature: f64,
        (tau, axial): (f64, f64),
    ) -> (Self, Result<Left, f64>) {
        let (n, J, turn) = (Quad::of(&at.axis), &link.inertia, Columns::of(&at.turn));
        let c = link.mass * link.center;
        let (force, moment) = (turn.times(&Vector3::new(-c.y, c.x, 0.0)), turn.times(&Vector3::new(J.xz, J.yz, J.zz)));
        let (more_force, more) = (force - self.fm.times(&at.axis), moment - self.mm.times(&at.axis));
        let half = more - Quad::all(0.5 * n.dot(more)) * n;
        let straight = Self {
            fm: self.fm.minus_dyad(-more_force, n),
            mm: self.mm.minus_dyad(-half, n).minus_dyad(-n, half).mirrored(),
            moment: self.moment + Quad::all(axial - n.dot(self.moment)) * n,
            ..*self
        };
        // What a screw adds: `p S [n; 0]`. No first moment of mass takes part in `D`: `n · (c × n) = 0`.
        let (pitch, p) = (link.joint.pitch(), Quad::all(link.joint.pitch()));
        let (slid, turned) = (self.ff.times(&at.axis), straight.fm.transposed().times(&at.axis));
        let (force, moment) = (p.times_add(slid, force), p.times_add(turned, moment));
        let D = J.zz + pitch * pitch * link.mass + armature;
        let u = tau - axial - pitch * n.dot(self.force);
        (straight, Left::of(force, moment, D, J.trace() + 3.0 * pitch * pitch * link.mass, u))
    }

    /// Eliminates a slide.
    #[inline(always)]
    pub(super) fn slide(&self, axis: &Vector3<f64>, armature: f64, tau: f64) -> Result<Left, f64> {
        let n = Quad::of(axis);
        let (force, moment) = (self.ff.times(axis), self.fm.transposed().times(axis));
        Left::of(force, moment, n.dot(force) + armature, self.ff.trace(), tau - n.dot(self.force))
    }

    /// Eliminates a slide below which nothing turns: the moments do not count.
    #[inline(always)]
    pub(super) fn translation(&self, axis: &Vector3<f64>, armature: f64, tau: f64) -> Result<Left, f64> {
        let (n, force) = (Quad::of(axis), self.ff.times(axis));
        Left::of(force, Quad::default(), n.dot(force) + armature, self.ff.trace(), tau - n.dot(self.force))
    }

    /// `S'` and `e'` of such a slide: the force part alone.
    #[inline(always)]
    pub(super) fn without_force(&self, left: &Left) -> Self {
        let (f, step) = (left.force, Quad::all(left.inverse * left.u));
        let ff = self.ff.minus_outer(Quad::all(left.inverse), f, f);
        Self { ff, force: step.times_add(f, self.force), ..Self::default() }
    }

    /// `S'` and `e'` without the velocity terms, eqs. (5) and (6).
    #[inline(always)]
    pub(super) fn without(&self, left: &Left) -> Self {
        let (f, m, inverse) = (left.force, left.moment, Quad::all(left.inverse));
        let step = Quad::all(left.inverse * left.u);
        Self {
            ff: self.ff.minus_outer(inverse, f, f),
            fm: self.fm.minus_outer(inverse, f, m),
            mm: self.mm.minus_outer(inverse, m, m),
            force: step.times_add(f, self.force),
            moment: step.times_add(m, self.moment),
        }
    }

    /// Eq. (7), after `S' γ` of eq. (6): what the parent gets. `S' γ` is summed on its own, for `e` is what waits.
    #[inline(always)]
    pub(super) fn shifted(&self, at: &LinkMotion) -> Self {
        let (d, linear, angular) = (&at.arm, &at.bias, &at.angular_bias);
        let mf = self.fm.transposed();
        let force = self.force + self.fm.times_add(angular, self.ff.times(linear));
        let moment = self.moment + self.mm.times_add(angular, mf.times(linear));
        // fm' = fm − ff [d]×,  mm' = mm + ([d]× fm)ᵀ + [d]× fm'
        let fm = self.fm.minus_cross(&self.ff, d);
        let mm = self.mm.minus_cross(&mf, d).plus_cross(d, &fm).mirrored();
        Self { ff: self.ff, fm, mm, force, moment: Quad::of(d).cross_add(force, moment) }
    }
}

/// A hinge of one coordinate, eliminated, in registers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Left {
    force: Quad,
    moment: Quad,
    inverse: f64,
    u: f64,
}

impl Left {
    /// On failure the pivot: below round-off of what the hinge could see, or not finite.
    #[inline(always)]
    fn of(force: Quad, moment: Quad, D: f64, seen: f64, u: f64) -> Result<Self, f64> {
        if !(D > SINGULAR * seen && D.is_finite()) {
            return Err(D);
        }
        Ok(Self { force, moment, inverse: 1.0 / D, u })
    }

    /// In memory.
    #[inline(always)]
    pub(super) fn one(&self) -> One {
        One { SH: wrench(self.force, self.moment), inverse: self.inverse, u: self.u }
    }
}
