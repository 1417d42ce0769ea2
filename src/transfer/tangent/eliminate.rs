//! The elimination of one hinge: eqs. (4) and (6).

use super::applied::Coupling;
use super::hinge::{Left, Three, Way};
use super::parts::Carried;
use super::pivots::Pivots;
use crate::spatial::quad::{Columns, Quad};
use crate::spatial::{Sym3, Wrench};
use nalgebra::{Matrix3, Vector3};

/// What couples a link to its parent, as the hinge sees it: in terms of the state at the link's marker.
struct Coupled {
    by_parent: Carried,
    on_parent: Carried,
}

impl Coupled {
    /// `T⁻¹` and `X⁻ᵀ` of eqs. (2) and (6).
    fn new<const PARTS: u8>(coupling: &Coupling, left: &Left) -> Self {
        let (mut by_parent, mut on_parent) = (Carried::of(&coupling.by_parent), Carried::of(&coupling.on_parent));
        by_parent.compose::<PARTS>(&-left.arm, &-left.swing);
        on_parent.shift::<PARTS>(&-left.arm);
        Self { by_parent, on_parent }
    }
}

/// One coordinate; false if the pivot does not do. `S` is left as the parent's side sees it, at the link's marker.
#[inline(always)]
pub(super) fn eliminate_one<const PARTS: u8>(
    left: &mut Left,
    way: Way,
    S: &mut Carried,
    f: &Wrench,
    kappa: f64,
    coupling: Option<&Coupling>,
) -> Option<f64> {
    let n = left.axis;
    let (mut force, mut moment) = S.times::<PARTS>(&left.h);
    let D = kappa + way.project(n, force, moment);
    if D == 0.0 || D.is_nan() {
        return None;
    }
    let coupled = coupling.map(|coupling| Coupled::new::<PARTS>(coupling, left));
    if let Some(coupled) = &coupled {
        S.take::<PARTS>(&coupled.by_parent);
    }
    let mut row = S.row::<PARTS>(n, way.slides);
    if way.pitch != 0.0 {
        row.add_times::<PARTS>(way.pitch, &S.row::<PARTS>(n, true));
    }
    if let Some(coupled) = &coupled {
        let (on_force, on_moment) = coupled.on_parent.times::<PARTS>(&left.h);
        (force, moment) = (force - on_force, moment - on_moment);
        S.take::<PARTS>(&coupled.on_parent);
    }
    // What the hinge passes on turns, or slides along, with the link.
    let passed = Quad::of(&f.force);
    if way.slides {
        moment = n.cross_add(passed, moment);
    } else {
        force = n.cross_add(passed, force);
        moment = n.cross_add(Quad::of(&f.moment), moment);
        if way.pitch != 0.0 {
            moment = Quad::all(way.pitch).times_add(n.cross(passed), moment);
        }
    }
    // Zero for a coordinate that is held.
    let inverse = 1.0 / D;
    S.downdate::<PARTS>((force, moment), inverse, &row);
    (left.w, left.inverse, left.row) = ((force, moment), inverse, row);
    Some(D)
}

/// A ball, in inertial axes; `kappa` likewise, `None` for a ball that is held. `Err` where the pivot is singular.
pub(super) fn eliminate_ball<const PARTS: u8>(
    left: &Left,
    ball: &mut Three,
    S: &mut Carried,
    f: &Wrench,
    kappa: Option<&Matrix3<f64>>,
    coupling: Option<&Coupling>,
) -> Result<NegativeAxes, Vector3<f64>> {
    let mut w = ball.reach::<PARTS>(S);
    let D = kappa.map(|kappa| w.moment.matrix() + kappa);
    let coupled = coupling.map(|coupling| Coupled::new::<PARTS>(coupling, left));
    if let Some(coupled) = &coupled {
        S.take::<PARTS>(&coupled.by_parent);
    }
    let (Some(D), Some(kappa)) = (D, kappa) else {
        if let Some(coupled) = &coupled {
            S.take::<PARTS>(&coupled.on_parent);
        }
        ball.pivots = None;
        return Ok(NegativeAxes::default());
    };
    let pivots = Pivots::of(&D).ok_or_else(|| ball.turn.column(0).into_owned())?;
    ball.row = *S;
    ball.row.each::<PARTS>(|block| block.moment = pivots.left(&block.moment));
    // What the hinge passes on turns with the link.
    w.force = w.force.minus_cross_of(Quad::of(&f.force));
    // D − w, not as a difference: κ + [m]×, nothing at all of a ball without springs.
    let mut kept = Columns::of(&(kappa + f.moment.cross_matrix()));
    if let Some(coupled) = &coupled {
        let felt = ball.reach::<PARTS>(&coupled.on_parent);
        w.force = w.force - felt.force;
        kept += felt.moment;
    }
    let (by_force, by_moment) = (pivots.right(&w.force), pivots.right(&kept));
    S.each_with::<PARTS>(&ball.row, |block, row| {
        block.force = block.force - by_force.by(&row.moment);
        block.moment = by_moment.by(&row.moment);
    });
    if let Some(coupled) = &coupled {
        S.take::<PARTS>(&coupled.on_parent);
    }
    (ball.force, ball.kept, ball.pivots) = (by_force, by_moment, Some(pivots));
    Ok(NegativeAxes::of(&D))
}

/// The directions in which one hinge's pivot is negative: at most three, no memory asked for.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct NegativeAxes {
    axes: [Vector3<f64>; 3],
    count: usize,
}

impl NegativeAxes {
    /// Eigenvectors of negative eigenvalues of the symmetric part; none for a positive definite one.
    pub(super) fn of(D: &Matrix3<f64>) -> Self {
        let part = Sym3::symmetric_part(D);
        if part.inverse().is_some_and(|(_, pivots)| pivots.min() > 0.0) {
            return Self::default();
        }
        let eigen = part.matrix().symmetric_eigen();
        let mut found = Self::default();
        for i in 0..3 {
            if eigen.eigenvalues[i] < 0.0 {
                found.axes[found.count] = eigen.eigenvectors.column(i).into_owned();
                found.count += 1;
            }
        }
        found
    }

    pub(super) fn len(&self) -> usize {
        self.count
    }

    pub(super) fn first(&self) -> Option<&Vector3<f64>> {
        self.axes[..self.count].first()
    }
}
