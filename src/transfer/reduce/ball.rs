//! A ball, eliminated.

use super::part::Lost;
use super::{LOST_BY_BALL, LinkAcceleration, SINGULAR};
use crate::model::{Link, Model};
use crate::motion::LinkMotion;
use crate::spatial::quad::Columns;
use crate::spatial::{Sym3, Wrench};
use crate::transfer::element::Reduced;
use nalgebra::{Matrix3, Vector3};

/// What is left of a ball, `H` being the moment part: `S H = [fm; mm]`, `D⁻¹` and the `u` of the last solution.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Ball {
    fm: Matrix3<f64>,
    mm: Sym3,
    inverse: Sym3,
    u: Vector3<f64>,
    pivot: Pivot,
}

/// The axes in which a ball's pivot is inverted.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) enum Pivot {
    /// Inertial ones.
    #[default]
    OfTree,
    /// The link's own, where it carries nothing but its body: there `D` is exact, and a slender body's smallest moment
    /// keeps its digits.
    OfBody,
}

/// Eq. (5) for a ball: what is left of it and `S'`, and what happened to digits (a pivot below `doubtful` has lost many); on failure the pivot that is not positive.
/// Without armature `S' H = 0` holds identically, so those blocks are set, not computed.
#[inline]
pub(super) fn eliminate(
    model: &Model,
    (link, at): (&Link, &LinkMotion),
    S: &Reduced,
    (pivot, doubtful): (Pivot, f64),
    lost: &mut Lost,
) -> Result<(Ball, Reduced), f64> {
    let armature = [0, 1, 2].map(|i| model.coordinates[link.velocity + i].armature);
    let rotor = match armature {
        [0.0, 0.0, 0.0] => Sym3::ZERO,
        _ => Sym3::diagonal(Vector3::from(armature)).turned(&at.turn),
    };
    let D = match pivot {
        Pivot::OfTree => S.mm + rotor,
        Pivot::OfBody => link.inertia + Sym3::diagonal(Vector3::from(armature)),
    };
    let (in_its_axes, pivots) = D.inverse().ok_or(0.0)?;
    let least = pivots.min();
    if !(least > LOST_BY_BALL * D.trace()) {
        if !(least > SINGULAR * D.trace()) {
            return Err(least);
        }
        if pivot == Pivot::OfTree {
            *lost = Lost::Perhaps.max(*lost);
        }
    }
    if least < doubtful {
        *lost = Lost::Many;
    }
    let inverse = match pivot {
        Pivot::OfTree => in_its_axes,
        Pivot::OfBody => in_its_axes.turned(&at.turn),
    };
    let fm = Columns::of(&S.fm);
    let weighted = fm.by(&Columns::symmetric(&inverse));
    let mut across = Reduced { ff: S.ff, ..Reduced::default() };
    across.ff += Sym3::symmetric_part(&-weighted.by(&fm.transposed()).matrix());
    if rotor != Sym3::ZERO {
        // S' H = A D⁻¹ Hᵀ S
        let full = rotor.matrix();
        across.fm = weighted.matrix() * full;
        across.mm = rotor + Sym3::symmetric_part(&-(full * inverse.matrix() * full));
    }
    Ok((Ball { fm: S.fm, mm: S.mm, inverse: in_its_axes, u: Vector3::zeros(), pivot }, across))
}

impl Ball {
    /// Eq. (6): `e + S H D⁻¹ u`. `tau` is in link axes; `own` is the moment of `e` there, asked for where the pivot is.
    #[inline]
    pub(super) fn load(
        &mut self,
        at: &LinkMotion,
        tau: &Vector3<f64>,
        e: &Wrench,
        own: impl FnOnce() -> Vector3<f64>,
    ) -> Wrench {
        let step = match self.pivot {
            Pivot::OfTree => {
                self.u = at.turn * tau - e.moment;
                self.inverse * self.u
            }
            Pivot::OfBody => {
                self.u = tau - own();
                at.turn * (self.inverse * self.u)
            }
        };
        *e + Wrench { force: self.fm * step, moment: self.mm * step }
    }

    /// Eq. (8): the relative acceleration, link axes, where the inboard side accelerates by `a`.
    #[inline]
    pub(super) fn solve(&self, link: &Link, at: &LinkMotion, a: &LinkAcceleration) -> Vector3<f64> {
        match self.pivot {
            Pivot::OfTree => {
                let resisted = self.fm.tr_mul(&a.linear) + self.mm * a.angular;
                at.turn.tr_mul(&(self.inverse * (self.u - resisted)))
            }
            Pivot::OfBody => {
                let (linear, angular) = (at.turn.tr_mul(&a.linear), at.turn.tr_mul(&a.angular));
                let resisted = link.mass * link.center.cross(&linear) + link.inertia * angular;
                self.inverse * (self.u - resisted)
            }
        }
    }

    /// Eq. (6) for a load without velocity terms and hinge forces, nothing of it kept: `u`, `D⁻¹ u` and `e + S H D⁻¹ u`.
    pub(super) fn pass(&self, at: &LinkMotion, e: &Wrench) -> (Vector3<f64>, Vector3<f64>, Wrench) {
        let mut ball = *self;
        let passed = ball.load(at, &Vector3::zeros(), e, || at.turn.tr_mul(&e.moment));
        (ball.u, ball.inverse * ball.u, passed)
    }

    /// `uᵀ D⁻¹ u` of the last solution.
    pub(super) fn resisted(&self) -> f64 {
        self.u.dot(&(self.inverse * self.u))
    }

    /// The moments of inertia it sees about the link's axes.
    pub(super) fn inertia(&self, at: &LinkMotion) -> [f64; 3] {
        [0, 1, 2].map(|i| {
            let axis = at.turn.column(i).into_owned();
            axis.dot(&(self.mm * axis))
        })
    }
}
