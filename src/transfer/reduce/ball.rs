//! A ball, eliminated.
//!
//! Its three turns go one after the other: `D = L diag(d) Lᵀ`, where digits are lost the best resisted first. Each leaves of
//! the force part of `S H` what the others have not taken, so a turn that hardly anything resists, before a heavy body that
//! only the other two move, keeps the digits of what resists it. `D⁻¹` as a matrix has lost them: its largest entries
//! round off what belongs to the smallest.

use super::{LOST_BY_BALL, LinkAcceleration, Lost, SINGULAR};
use crate::model::{Link, Model};
use crate::motion::LinkMotion;
use crate::spatial::fused::fma;
use crate::spatial::quad::{Columns, Quad};
use crate::spatial::{Sym3, Wrench};
use crate::transfer::element::Reduced;
use nalgebra::{Matrix3, Vector3};

/// The factors of an eliminated ball, `H` being the moment part: `S H = [fm; mm]`, `D = L diag(d) Lᵀ`, and of the last solution `L⁻¹ u`.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Ball {
    /// `fm L⁻ᵀ`, inertial axes.
    fm: Matrix3<f64>,
    mm: Sym3,
    factors: Factors,
    u: Vector3<f64>,
    pivot: Pivot,
    /// Whether rotors turn with it. Without, `D = mm` and their parts cancel exactly.
    is_geared: bool,
}

/// The axes in which a ball's pivot is factorized.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) enum Pivot {
    /// Inertial ones.
    #[default]
    OfTree,
    /// The link's own, where it carries nothing but its body: there `D` is exact, and a slender body's smallest moment
    /// keeps its digits.
    OfBody,
}

/// `P D Pᵀ = L diag(d) Lᵀ`, `L` with ones on its diagonal.
#[derive(Debug, Clone, Copy, Default)]
struct Factors {
    /// The axes in the order in which they are eliminated.
    order: [usize; 3],
    l21: f64,
    l31: f64,
    l32: f64,
    /// `1/d`.
    inverse: Vector3<f64>,
}

/// `P` is the identity.
const GIVEN: [usize; 3] = [0, 1, 2];

impl Factors {
    /// In a given order; also the pivots.
    #[inline(always)]
    fn of(D: &Sym3, order: [usize; 3]) -> (Self, Vector3<f64>) {
        let D = match order {
            GIVEN => *D,
            _ => permuted(D, order),
        };
        let i1 = 1.0 / D.xx;
        let (l21, l31) = (D.xy * i1, D.xz * i1);
        let d2 = fma(-l21, D.xy, D.yy);
        let i2 = 1.0 / d2;
        let under = fma(-l31, D.xy, D.yz);
        let l32 = under * i2;
        let d3 = fma(-l32, under, fma(-l31, D.xz, D.zz));
        (Self { order, l21, l31, l32, inverse: Vector3::new(i1, i2, 1.0 / d3) }, Vector3::new(D.xx, d2, d3))
    }

    /// With diagonal pivoting: the largest remaining pivot comes next.
    #[cold]
    #[inline(never)]
    fn pivoted(D: &Sym3) -> (Self, Vector3<f64>) {
        let diagonal = [D.xx, D.yy, D.zz];
        let larger = |a: usize, b: usize| if diagonal[b] > diagonal[a] { b } else { a };
        let first = larger(larger(0, 1), 2);
        let order = [GIVEN, [1, 0, 2], [2, 0, 1]][first];
        let P = permuted(D, order);
        let left = |beside: f64, own: f64| own - beside * beside / P.xx;
        match left(P.xy, P.yy) >= left(P.xz, P.zz) {
            true => Self::of(D, order),
            false => Self::of(D, [order[0], order[2], order[1]]),
        }
    }

    /// `P v`.
    #[inline(always)]
    fn ordered(&self, v: &Vector3<f64>) -> Vector3<f64> {
        match self.order {
            GIVEN => *v,
            order => Vector3::from(order.map(|axis| v[axis])),
        }
    }

    /// `L⁻¹ P v`.
    #[inline(always)]
    fn forward(&self, v: &Vector3<f64>) -> Vector3<f64> {
        let v = self.ordered(v);
        let second = fma(-self.l21, v.x, v.y);
        Vector3::new(v.x, second, fma(-self.l32, second, fma(-self.l31, v.x, v.z)))
    }

    /// `Pᵀ L⁻ᵀ y`.
    #[inline(always)]
    fn backward(&self, y: &Vector3<f64>) -> Vector3<f64> {
        let second = fma(-self.l32, y.z, y.y);
        let x = Vector3::new(fma(-self.l21, second, fma(-self.l31, y.z, y.x)), second, y.z);
        match self.order {
            GIVEN => x,
            order => {
                let mut placed = Vector3::zeros();
                order.iter().zip(&x).for_each(|(axis, x)| placed[*axis] = *x);
                placed
            }
        }
    }

    /// `M Pᵀ L⁻ᵀ`.
    #[inline(always)]
    fn columns(&self, M: &Columns) -> [Quad; 3] {
        let [first, second, third] = match self.order {
            GIVEN => M.0,
            order => order.map(|axis| M.0[axis]),
        };
        let second = Quad::all(self.l21).times_from(first, second);
        [first, second, Quad::all(self.l32).times_from(second, Quad::all(self.l31).times_from(first, third))]
    }
}

/// `P D Pᵀ`.
fn permuted(D: &Sym3, [i, j, k]: [usize; 3]) -> Sym3 {
    let diagonal = [D.xx, D.yy, D.zz];
    let beside = |a: usize, b: usize| [D.xy, D.xz, D.yz][a + b - 1];
    Sym3 { xx: diagonal[i], yy: diagonal[j], zz: diagonal[k], xy: beside(i, j), xz: beside(i, k), yz: beside(j, k) }
}

/// Eq. (5) for a ball: its factors and `S'`, and what happened to digits (a pivot below `doubtful` has lost many); on failure the pivot that is not positive.
/// Without armature `S' H = 0` holds identically, so those blocks are set, not computed.
#[inline]
pub(super) fn eliminate(
    model: &Model,
    (link, at): (&Link, &LinkMotion),
    S: &Reduced,
    (pivot, doubtful): (Pivot, f64),
    lost: &mut Lost,
) -> Result<(Ball, Reduced), f64> {
    let armature = Vector3::from([0, 1, 2].map(|i| model.coordinates[link.velocity + i].armature));
    let is_geared = armature != Vector3::zeros();
    let (D, fm) = match pivot {
        Pivot::OfTree if is_geared => (S.mm + Sym3::diagonal(armature).turned(&at.turn), Columns::of(&S.fm)),
        Pivot::OfTree => (S.mm, Columns::of(&S.fm)),
        Pivot::OfBody => {
            let own = Columns::default().minus_cross_of(Quad::of(&(link.mass * link.center)));
            (link.inertia + Sym3::diagonal(armature), own)
        }
    };
    let (mut factors, pivots) = Factors::of(&D, GIVEN);
    let mut least = pivots.min();
    if !(least > LOST_BY_BALL * D.trace()) {
        let (again, pivots) = Factors::pivoted(&D);
        (factors, least) = (again, pivots.min());
        if !(least > SINGULAR * D.trace()) {
            return Err(least);
        }
        if pivot == Pivot::OfTree {
            *lost = Lost::Many;
        }
    }
    if least < doubtful {
        *lost = Lost::Many;
    }
    let mut fm = factors.columns(&fm);
    if pivot == Pivot::OfBody {
        let turn = Columns::of(&at.turn);
        fm = fm.map(|column| turn.times(&column.vector()));
    }
    let inverse = [0, 1, 2].map(|k| Quad::all(factors.inverse[k]));
    let without =
        |sum: Columns, a: &[Quad; 3], b: &[Quad; 3]| (0..3).fold(sum, |sum, k| sum.minus_outer(inverse[k], a[k], b[k]));
    let mut across = Reduced { ff: without(Columns::symmetric(&S.ff), &fm, &fm).triangle(), ..Reduced::default() };
    if is_geared {
        // S' H = A D⁻¹ Hᵀ S
        let rotor = Sym3::diagonal(armature).turned(&at.turn);
        let weighted = match pivot {
            Pivot::OfTree => factors.columns(&Columns::symmetric(&rotor)),
            Pivot::OfBody => factors.columns(&Columns::of(&(at.turn * Matrix3::from_diagonal(&armature)))),
        };
        across.fm = -without(Columns::default(), &fm, &weighted).matrix();
        across.mm = without(Columns::symmetric(&rotor), &weighted, &weighted).triangle();
    }
    let fm = Columns(fm).matrix();
    Ok((Ball { fm, mm: S.mm, factors, u: Vector3::zeros(), pivot, is_geared }, across))
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
        let given = at.turn * tau;
        self.u = self.factors.forward(&match self.pivot {
            Pivot::OfTree => given - e.moment,
            Pivot::OfBody => tau - own(),
        });
        let step = self.u.component_mul(&self.factors.inverse);
        let moment = match self.is_geared {
            false => given,
            true => e.moment + self.mm * self.inertial(at, &self.factors.backward(&step)),
        };
        Wrench { force: e.force + self.fm * step, moment }
    }

    /// A vector in the pivot's axes, in inertial ones.
    #[inline]
    fn inertial(&self, at: &LinkMotion, v: &Vector3<f64>) -> Vector3<f64> {
        match self.pivot {
            Pivot::OfTree => *v,
            Pivot::OfBody => at.turn * v,
        }
    }

    /// Eq. (8): the relative acceleration, link axes, where the inboard side accelerates by `a`.
    #[inline]
    pub(super) fn solve(&self, at: &LinkMotion, a: &LinkAcceleration) -> Vector3<f64> {
        let mut left = self.u - self.fm.tr_mul(&a.linear);
        if self.is_geared {
            let resisted = self.mm * a.angular;
            left -= self.factors.forward(&match self.pivot {
                Pivot::OfTree => resisted,
                Pivot::OfBody => at.turn.tr_mul(&resisted),
            });
        }
        let step = self.factors.backward(&left.component_mul(&self.factors.inverse));
        let turned = if self.is_geared { Vector3::zeros() } else { a.angular };
        match self.pivot {
            Pivot::OfTree => at.turn.tr_mul(&(step - turned)),
            Pivot::OfBody => step - at.turn.tr_mul(&turned),
        }
    }

    /// Eq. (6) for a load without velocity terms and hinge forces, nothing of it kept: `L⁻¹ u`, `diag(d)⁻¹ L⁻¹ u` and
    /// `e + S H D⁻¹ u`.
    pub(super) fn pass(&self, at: &LinkMotion, e: &Wrench) -> (Vector3<f64>, Vector3<f64>, Wrench) {
        let mut ball = *self;
        let passed = ball.load(at, &Vector3::zeros(), e, || at.turn.tr_mul(&e.moment));
        (ball.u, ball.u.component_mul(&ball.factors.inverse), passed)
    }

    /// `uᵀ D⁻¹ u` of the last solution.
    pub(super) fn resisted(&self) -> f64 {
        self.u.dot(&self.u.component_mul(&self.factors.inverse))
    }

    /// The smallest pivot (kg m²).
    pub(super) fn least_pivot(&self) -> f64 {
        1.0 / self.factors.inverse.max()
    }

    /// The moments of inertia it sees about the link's axes.
    pub(super) fn inertia(&self, at: &LinkMotion) -> [f64; 3] {
        [0, 1, 2].map(|i| {
            let axis = at.turn.column(i).into_owned();
            axis.dot(&(self.mm * axis))
        })
    }
}
