//! The reduction: a factorization of the tree, and solutions with it.

use super::element::{Reduced, bias, moment_in_link_axes};
use super::{LinkAcceleration, accelerate, along, inboard};
use crate::model::{Joint, Link, Model};
use crate::motion::{LinkMotion, Motion};
use crate::spatial::{Sym3, Wrench};
use nalgebra::{Matrix3, Vector3};

/// A pivot below this part of the moment of inertia (or mass) that the hinge could see is round-off: four units in the
/// last place of the sums it is the difference of.
const SINGULAR: f64 = 4.0 * f64::EPSILON;

/// The factorized tree: reduced matrices and hinge pivots at one position.
#[derive(Debug, Clone)]
pub struct Reduction {
    /// `S` at every root marker, before its own hinge is eliminated.
    S: Vec<Reduced>,
    /// `S'` across every hinge.
    across: Vec<Reduced>,
    /// `S H` and `D⁻¹`.
    hinges: Vec<Pivot>,
    /// Scratch of [`Reduction::solve`]: `e`, then the reactions `f`; and the links' accelerations.
    e: Vec<Wrench>,
    a: Vec<LinkAcceleration>,
    u: Vec<Vector3<f64>>,
}

/// `S H` and `D⁻¹` of one hinge.
#[derive(Debug, Clone, Copy)]
enum Pivot {
    None,
    /// One coordinate: the vector `S H` and `1/D`.
    One {
        SH: Wrench,
        inverse: f64,
    },
    /// A ball, `H` being the moment part in inertial axes: `S H = [fm; mm]` and `D⁻¹`.
    Three {
        fm: Matrix3<f64>,
        mm: Sym3,
        inverse: Sym3,
    },
    /// A ball that carries nothing but its own body: `D⁻¹` in link axes, where it is exact.
    Leaf {
        fm: Matrix3<f64>,
        mm: Sym3,
        inverse: Sym3,
    },
}

/// A hinge whose acceleration is not determined.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Singular {
    /// The link.
    pub link: usize,
    /// The pivot `D` (kg or kg m²).
    pub pivot: f64,
}

/// A right side of the transfer equations. Hinge forces are always given; wrenches and velocity terms may be left out.
#[derive(Debug, Clone, Copy)]
pub struct Load<'a> {
    /// `b − f_applied` at every root marker; empty for none.
    pub wrenches: &'a [Wrench],
    /// Whether the velocity terms `γ` take part.
    pub with_bias: bool,
    /// `τ`, one per velocity.
    pub tau: &'a [f64],
}

impl Reduction {
    /// Room for a model's links.
    pub fn new(model: &Model) -> Self {
        let n = model.links.len();
        Self {
            S: vec![Reduced::default(); n],
            across: vec![Reduced::default(); n],
            hinges: vec![Pivot::None; n],
            e: vec![Wrench::ZERO; n],
            a: vec![LinkAcceleration::default(); n],
            u: vec![Vector3::zeros(); n],
        }
    }

    /// Tips → root: eqs. (5) and (7) for `S`. Depends on positions only.
    ///
    /// # Errors
    /// A hinge that nothing with inertia resists, or a number that is not finite.
    pub fn factorize(&mut self, model: &Model, motion: &Motion) -> Result<(), Singular> {
        for (link, (S, at)) in model.links.iter().zip(self.S.iter_mut().zip(&motion.links)) {
            *S = Reduced::of_body(link.mass, at.center, at.inertia);
        }
        for index in (1..model.links.len()).rev() {
            let (link, at) = (&model.links[index], &motion.links[index]);
            let (pivot, across) = eliminate(model, link, at, &self.S[index], link.subtree_end == index + 1)
                .map_err(|pivot| Singular { link: index, pivot })?;
            self.hinges[index] = pivot;
            self.across[index] = across;
            self.S[link.parent].add_shifted(&across, &at.arm);
        }
        Ok(())
    }

    /// Eqs. (6) to (8): hinge accelerations `hinge` for one load. Positions and velocities as at the factorization.
    pub fn solve(&mut self, model: &Model, motion: &Motion, load: &Load<'_>, hinge: &mut [f64]) {
        self.inward(model, motion, load);
        self.outward(model, motion, load.with_bias, hinge);
    }

    /// Tips → root: the vectors `e` and `u`.
    fn inward(&mut self, model: &Model, motion: &Motion, load: &Load<'_>) {
        if load.wrenches.is_empty() {
            self.e.fill(Wrench::ZERO);
        } else {
            self.e.copy_from_slice(load.wrenches);
        }
        for index in (1..model.links.len()).rev() {
            let (link, at) = (&model.links[index], &motion.links[index]);
            let mut e = self.e[index];
            let gamma = LinkAcceleration { linear: at.bias, angular: at.angular_bias };
            match &self.hinges[index] {
                Pivot::None => {}
                Pivot::One { SH, inverse } => {
                    let u = load.tau[link.velocity] - along(&link.joint, &at.axis, &e);
                    self.u[index].x = u;
                    let step = inverse * u;
                    e += Wrench { force: step * SH.force, moment: step * SH.moment };
                }
                Pivot::Three { fm, mm, inverse } => {
                    let u = at.turn * three(load.tau, link.velocity) - e.moment;
                    self.u[index] = u;
                    let step = *inverse * u;
                    e += Wrench { force: fm * step, moment: *mm * step };
                }
                Pivot::Leaf { fm, mm, inverse } => {
                    let u = three(load.tau, link.velocity) - leaf_moment(model, link, at, &e, load.with_bias);
                    self.u[index] = u;
                    let step = at.turn * (*inverse * u);
                    e += Wrench { force: fm * step, moment: *mm * step };
                }
            }
            if load.with_bias {
                e += self.across[index].times(&gamma);
            }
            self.e[link.parent] += e.shifted(at.arm);
        }
    }

    /// Root → tips: accelerations.
    fn outward(&mut self, model: &Model, motion: &Motion, with_bias: bool, hinge: &mut [f64]) {
        self.a[0] = LinkAcceleration::default();
        for index in 1..model.links.len() {
            let (link, at) = (&model.links[index], &motion.links[index]);
            let mut a = inboard(at, &self.a[link.parent], with_bias);
            match &self.hinges[index] {
                Pivot::None => {}
                Pivot::One { SH, inverse } => {
                    let resisted = SH.force.dot(&a.linear) + SH.moment.dot(&a.angular);
                    hinge[link.velocity] = inverse * (self.u[index].x - resisted);
                }
                Pivot::Three { fm, mm, inverse } => {
                    let resisted = fm.tr_mul(&a.linear) + *mm * a.angular;
                    let relative = at.turn.tr_mul(&(*inverse * (self.u[index] - resisted)));
                    hinge[link.velocity..link.velocity + 3].copy_from_slice(relative.as_slice());
                }
                Pivot::Leaf { inverse, .. } => {
                    let (linear, angular) = (at.turn.tr_mul(&a.linear), at.turn.tr_mul(&a.angular));
                    let resisted = link.mass * link.center.cross(&linear) + link.inertia * angular;
                    let relative = *inverse * (self.u[index] - resisted);
                    hinge[link.velocity..link.velocity + 3].copy_from_slice(relative.as_slice());
                }
            }
            accelerate(link, at, hinge, &mut a);
            self.a[index] = a;
        }
    }

    /// Eq. (6) at one hinge for a load without velocity terms: takes `e` across it and gives `u` and `D⁻¹ u` (of a ball
    /// three numbers, else the first). Over the way from a loaded link to the root these are the only ones that are not
    /// zero, and `bᵀ M⁻¹ c = Σ uᵦ · D⁻¹ u꜀` for any two loads: small systems of loads need no outward sweep.
    #[inline]
    pub fn pass(
        &self,
        model: &Model,
        motion: &Motion,
        index: usize,
        tau: f64,
        e: &mut Wrench,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let (link, at) = (&model.links[index], &motion.links[index]);
        match &self.hinges[index] {
            Pivot::None => (Vector3::zeros(), Vector3::zeros()),
            Pivot::One { SH, inverse } => {
                let u = tau - along(&link.joint, &at.axis, e);
                let step = inverse * u;
                *e += Wrench { force: step * SH.force, moment: step * SH.moment };
                (Vector3::new(u, 0.0, 0.0), Vector3::new(step, 0.0, 0.0))
            }
            Pivot::Three { fm, mm, inverse } => {
                let u = -e.moment;
                let step = *inverse * u;
                *e += Wrench { force: fm * step, moment: *mm * step };
                (u, step)
            }
            Pivot::Leaf { fm, mm, inverse } => {
                let u = -at.turn.tr_mul(&e.moment);
                let own = *inverse * u;
                let step = at.turn * own;
                *e += Wrench { force: fm * step, moment: *mm * step };
                (u, own)
            }
        }
    }

    /// Accelerations of all links in the last solution.
    pub fn accelerations(&self) -> &[LinkAcceleration] {
        &self.a
    }

    /// What the inboard hinge passes to each link at its root marker in the last solution: `f = S a + e`.
    pub fn reaction(&self, link: usize) -> Wrench {
        self.S[link].times(&self.a[link]) + self.e[link]
    }

    /// The inertia that each hinge coordinate sees while everything outboard moves freely: the diagonal of `D`,
    /// armature included (kg, kg m²).
    pub fn articulated_inertia(&self, model: &Model, motion: &Motion, out: &mut [f64]) {
        for (index, link) in model.links.iter().enumerate().skip(1) {
            let at = &motion.links[index];
            let first = link.velocity;
            match &self.hinges[index] {
                Pivot::None => {}
                Pivot::One { inverse, .. } => out[first] = 1.0 / inverse,
                Pivot::Three { mm, .. } | Pivot::Leaf { mm, .. } => {
                    for i in 0..3 {
                        let axis = at.turn.column(i).into_owned();
                        out[first + i] = axis.dot(&(*mm * axis)) + model.coordinates[first + i].armature;
                    }
                }
            }
        }
    }
}

/// Eq. (5) for one hinge; on failure the pivot that is not positive.
#[inline]
fn eliminate(model: &Model, link: &Link, at: &LinkMotion, S: &Reduced, leaf: bool) -> Result<(Pivot, Reduced), f64> {
    let (SH, seen) = match link.joint {
        Joint::None => return Ok((Pivot::None, *S)),
        Joint::Turn { .. } => (Wrench { force: S.fm * at.axis, moment: S.mm * at.axis }, S.mm.trace()),
        Joint::Slide { .. } => (Wrench { force: S.ff * at.axis, moment: S.fm.tr_mul(&at.axis) }, S.ff.trace()),
        Joint::Ball { .. } => return eliminate_ball(model, link, at, S, leaf),
    };
    let D = along(&link.joint, &at.axis, &SH) + model.coordinates[link.velocity].armature;
    if !(D > SINGULAR * seen && D.is_finite()) {
        return Err(D);
    }
    let inverse = 1.0 / D;
    let mut across = *S;
    across.downdate(&SH, inverse);
    Ok((Pivot::One { SH, inverse }, across))
}

/// Eq. (5) for a ball. Without armature `S' H = 0` holds identically, so those blocks are set, not computed.
#[inline]
fn eliminate_ball(
    model: &Model,
    link: &Link,
    at: &LinkMotion,
    S: &Reduced,
    leaf: bool,
) -> Result<(Pivot, Reduced), f64> {
    let armature = [0, 1, 2].map(|i| model.coordinates[link.velocity + i].armature);
    let rotor = match armature {
        [0.0, 0.0, 0.0] => Sym3::ZERO,
        _ => Sym3::diagonal(Vector3::from(armature)).turned(&at.turn),
    };
    // A leaf's pivot in link axes, then turned: a slender body's smallest moment keeps its digits.
    let own = link.inertia + Sym3::diagonal(Vector3::from(armature));
    let D = if leaf { own } else { S.mm + rotor };
    let (in_its_axes, pivots) = D.inverse().ok_or(0.0)?;
    let least = pivots.min();
    if !(least > SINGULAR * D.trace()) {
        return Err(least);
    }
    let inverse = if leaf { in_its_axes.turned(&at.turn) } else { in_its_axes };
    let weighted = S.fm * inverse.matrix();
    let mut across = Reduced { ff: S.ff, ..Reduced::default() };
    let taken = weighted * S.fm.transpose();
    let minus = Sym3::symmetric_part(&-taken);
    across.ff += minus;
    if rotor != Sym3::ZERO {
        // S' H = A D⁻¹ Hᵀ S
        let full = rotor.matrix();
        across.fm = weighted * full;
        across.mm = rotor + Sym3::symmetric_part(&-(full * inverse.matrix() * full));
    }
    let pivot = match leaf {
        true => Pivot::Leaf { fm: S.fm, mm: S.mm, inverse: in_its_axes },
        false => Pivot::Three { fm: S.fm, mm: S.mm, inverse },
    };
    Ok((pivot, across))
}

/// `e` of a leaf's moments in link axes: its own terms computed there, and what is applied beside them turned there.
#[inline]
fn leaf_moment(model: &Model, link: &Link, at: &LinkMotion, e: &Wrench, with_bias: bool) -> Vector3<f64> {
    if !with_bias {
        return at.turn.tr_mul(&e.moment);
    }
    let own = bias(link.mass, &model.gravity, at).moment;
    moment_in_link_axes(link, &model.gravity, at) + at.turn.tr_mul(&(e.moment - own))
}

#[inline]
fn three(list: &[f64], at: usize) -> Vector3<f64> {
    Vector3::new(list[at], list[at + 1], list[at + 2])
}
