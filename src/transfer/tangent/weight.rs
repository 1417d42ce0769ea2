//! The tangent of a scene at rest under its weight alone: no force depends on places, and no hinge passes on more or less
//! of one when links turn. Moments do, with the turn `δθ`: of the blocks of `S` one is left, 3×3.
//!
//! ```text
//! body     δm_R = [b]× [c]× δθ + …,   b = −m g                       eq. (1) of the parent module, plain variations
//! turn     D = n·S n + κ,   w = S n,   row = Sᵀ n + n × m            S ← S − w D⁻¹ row
//! slide    D = κ,           w = n × f = row
//! screw    D of the turn, w and row the turn's and p times the slide's
//! ball     D = S + [m]× + κ,   S ← S D⁻¹ κ
//! shift    S ← S + [f]× [d]×
//! ```

use super::eliminate::NegativeAxes;
use super::{At, Breakdown};
use crate::model::Model;
use crate::pages::Pages;
use crate::spatial::quad::{Columns, Quad};
use crate::transfer::plan::{Kind, Place, To};
use nalgebra::{Matrix3, Vector3};

/// The factorized tangent at rest.
#[derive(Debug, Clone, Default)]
pub(super) struct Weight {
    left: Pages<Left>,
    balls: Vec<Three>,
    /// What arrives at links with several children from all but the first; zero between two sweeps.
    joins: Vec<Columns>,
    /// Moments that arrive at links with several children from all but the first; zero between two sweeps.
    moments: Vec<Quad>,
    /// Turns of links with several children.
    turned: Pages<Quad>,
    /// Whether the last factorization broke down.
    broken: bool,
}

/// The factors of an eliminated turn, slide or screw.
#[derive(Debug, Clone, Copy, Default)]
struct Left {
    /// Of a turn or screw; zero for others.
    axis: Quad,
    w: Quad,
    row: Quad,
    /// `D⁻¹`, zero for a coordinate that is held; and `u`.
    inverse: f64,
    u: f64,
}

/// The factors of an eliminated ball, inertial axes.
#[derive(Debug, Clone, Copy, Default)]
struct Three {
    turn: Matrix3<f64>,
    w: Columns,
    row: Columns,
    inverse: Columns,
    u: Quad,
}

impl Weight {
    /// Tips → root. With `definite` it stops at the first pivot that is not positive. Returns the number of negative
    /// pivots.
    ///
    /// # Errors
    /// A pivot that is zero or not finite, or negative where a definite matrix is wanted.
    pub(super) fn factorize(
        &mut self,
        model: &Model,
        plan: &[Place],
        at: &At<'_>,
        definite: bool,
    ) -> Result<usize, Breakdown> {
        self.reserve(plan);
        if std::mem::replace(&mut self.broken, true) {
            self.joins.fill(Columns::default());
        }
        let mut springs = at.ball_springs.iter().rev().peekable();
        let mut negative = 0;
        let mut S = Columns::default();
        for index in (1..plan.len()).rev() {
            let (place, own) = (&plan[index], &at.motion.links[index]);
            if place.is_leaf {
                S = Columns::default();
            } else if let Some(join) = place.join {
                S += std::mem::take(&mut self.joins[join as usize]);
            }
            if !place.is_massless {
                let b = -model.links[index].mass * model.gravity;
                S = S.plus_twice(&b, &own.center);
            }
            let f = &at.balance.reactions[index];
            let first = place.velocity as usize;
            let left = &mut self.left[index];
            match place.kind {
                // Scenes with flexible elements do not come here.
                Kind::None | Kind::Flex | Kind::Modal | Kind::Interface => {}
                Kind::Turn | Kind::Slide | Kind::Screw => {
                    let (n, kappa) = (Quad::of(&own.axis), at.diagonal[first]);
                    let (D, w, row) = match place.kind {
                        Kind::Slide => {
                            let w = n.cross(Quad::of(&f.force));
                            (kappa, w, w)
                        }
                        _ => {
                            let mut w = S.times(&own.axis);
                            let mut row = S.transposed().times_add(&own.axis, n.cross(Quad::of(&f.moment)));
                            let D = kappa + n.dot(w);
                            if place.kind == Kind::Screw {
                                let p = Quad::all(model.links[index].joint.pitch());
                                let slid = n.cross(Quad::of(&f.force));
                                (w, row) = (p.times_add(slid, w), p.times_add(slid, row));
                            }
                            (D, w, row)
                        }
                    };
                    let axis = if place.kind == Kind::Slide { Quad::default() } else { n };
                    *left = Left { axis, w, row, inverse: 1.0 / D, u: 0.0 };
                    if D == 0.0 || D.is_nan() || (definite && D < 0.0) {
                        return Err(Breakdown { link: index, axis: None });
                    }
                    negative += usize::from(D < 0.0);
                    S = S.minus_dyad(Quad::all(left.inverse) * w, row);
                }
                Kind::Ball => {
                    let ball = &mut self.balls[place.ball as usize];
                    let spring = springs.next_if(|(link, _)| *link == index).map(|(_, spring)| spring);
                    let kappa = super::ball_kappa(at, &own.turn, first, spring);
                    let row = S.minus_cross_of(-Quad::of(&f.moment));
                    *ball = Three { turn: own.turn, w: S, row, ..Three::default() };
                    if let Some(kappa) = kappa {
                        let D = row.matrix() + kappa;
                        let inverse = D.try_inverse().filter(|inverse| inverse.iter().all(|x| x.is_finite()));
                        let singular = || Breakdown { link: index, axis: Some(own.turn.column(0).into_owned()) };
                        ball.inverse = Columns::of(&inverse.ok_or_else(singular)?);
                        let axes = NegativeAxes::of(&D);
                        if definite && let Some(axis) = axes.first() {
                            return Err(Breakdown { link: index, axis: Some(*axis) });
                        }
                        negative += axes.len();
                        S = S.by(&ball.inverse).by(&Columns::of(&kappa));
                    }
                }
            }
            S = S.plus_twice(&f.force, &own.arm);
            if let To::Join(join) = place.to {
                self.joins[join as usize] += S;
            }
        }
        self.broken = false;
        Ok(negative)
    }

    /// Room, at the first factorization: what is never looked at at rest does without.
    fn reserve(&mut self, plan: &[Place]) {
        if self.left.len() != plan.len() {
            let count = |kind: fn(&Place) -> bool| plan.iter().filter(|place| kind(place)).count();
            let (joins, balls) = (count(|place| place.join.is_some()), count(|place| place.kind == Kind::Ball));
            self.left = Pages::filled(Left::default(), plan.len());
            self.balls = vec![Three::default(); balls];
            (self.joins, self.moments) = (vec![Columns::default(); joins], vec![Quad::default(); joins]);
            self.turned = Pages::filled(Quad::default(), plan.len());
        }
    }

    /// The solution for one right side, in place.
    pub(super) fn solve(&mut self, plan: &[Place], x: &mut [f64]) {
        let mut e = Quad::default();
        for (place, left) in plan.iter().zip(&mut self.left).skip(1).rev() {
            if place.is_leaf {
                e = Quad::default();
            } else if let Some(join) = place.join {
                e += std::mem::take(&mut self.moments[join as usize]);
            }
            let first = place.velocity as usize;
            match place.kind {
                Kind::None | Kind::Flex | Kind::Modal | Kind::Interface => {}
                Kind::Turn | Kind::Slide | Kind::Screw => {
                    left.u = x[first] - left.axis.dot(e);
                    e = Quad::all(left.inverse * left.u).times_add(left.w, e);
                }
                Kind::Ball => {
                    let ball = &mut self.balls[place.ball as usize];
                    ball.u = Quad::of(&(ball.turn * Vector3::new(x[first], x[first + 1], x[first + 2]))) - e;
                    e = ball.w.times_add(&ball.inverse.times(&ball.u.vector()).vector(), e);
                }
            }
            if let To::Join(join) = place.to {
                self.moments[join as usize] += e;
            }
        }
        self.turned[0] = Quad::default();
        self.outward(plan, 1..plan.len(), x);
    }

    /// Root → tips: eq. (5).
    fn outward(&mut self, plan: &[Place], range: std::ops::Range<usize>, x: &mut [f64]) {
        let mut before = self.turned[range.start - 1];
        for index in range {
            let (place, left) = (&plan[index], &self.left[index]);
            let parent = place.parent as usize;
            let mut turned = if parent + 1 == index { before } else { self.turned[parent] };
            let first = place.velocity as usize;
            match place.kind {
                Kind::None | Kind::Flex | Kind::Modal | Kind::Interface => {}
                Kind::Turn | Kind::Slide | Kind::Screw => {
                    let step = left.inverse * (left.u - left.row.dot(turned));
                    x[first] = step;
                    turned = Quad::all(step).times_add(left.axis, turned);
                }
                Kind::Ball => {
                    let ball = &self.balls[place.ball as usize];
                    let phi = ball.inverse.times(&(ball.u - ball.row.times(&turned.vector())).vector());
                    x[first..first + 3].copy_from_slice(ball.turn.tr_mul(&phi.vector()).as_slice());
                    turned += phi;
                }
            }
            if place.join.is_some() {
                self.turned[index] = turned;
            }
            before = turned;
        }
    }

    /// A direction of negative curvature after a breakdown: see the parent module.
    pub(super) fn negative_direction(
        &mut self,
        plan: &[Place],
        breakdown: Breakdown,
        outboard: std::ops::Range<usize>,
        x: &mut [f64],
    ) {
        let (root, first) = (breakdown.link, plan[breakdown.link].velocity as usize);
        self.turned[root] = match breakdown.axis {
            None => {
                x[first] = 1.0;
                self.left[root].axis
            }
            Some(axis) => {
                let turn = &self.balls[plan[root].ball as usize].turn;
                x[first..first + 3].copy_from_slice(turn.tr_mul(&axis).as_slice());
                Quad::of(&axis)
            }
        };
        for index in outboard.clone() {
            self.left[index].u = 0.0;
            if plan[index].kind == Kind::Ball {
                self.balls[plan[index].ball as usize].u = Quad::default();
            }
        }
        self.outward(plan, outboard, x);
    }
}
