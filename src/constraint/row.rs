//! One constraint row: its gap, how fast the gap opens, and the load of its multiplier.
//!
//! A row is a scalar condition `g(q, t) = 0`. Its multiplier λ pushes along `Gᵀ λ`, `G = ∂g/∂q`: for a loop by a wrench
//! at the root marker of each end's link, for a coordinate by a hinge force. The same numbers give the rates, by duality:
//!
//! ```text
//! ġ = Σ w·(v, ω) + Σ c q̇ + g_t          g̈ = Σ w·(r̈, ω̇) + Σ c q̈ + bias
//! ```
//!
//! with `w` the wrench of a unit multiplier at a root marker and `(r̈, ω̇)` the acceleration of that marker. `d` is the
//! vector from the first end to the second, `t` an axis of the first link, `m` one of the second:
//!
//! ```text
//! along      g = t·d            load: t on the second end, −t on the same point of the first link
//! aligned    g = t·m − cos      load: the moment m×t on the second link, −m×t on the first
//! thread     g = t·d − p φ      load: as along, and the moment −p m on the second link, p m on the first
//!            φ, m: angle about t between the links and its gradient, see `spatial::twist`; g up to full turns
//! distance   g = |d| − length   load: d/|d| on the second end, −d/|d| on the first
//! motion     g = c₁ q₁ + c₂ q₂ − s(t)
//! ```

use crate::model::prescribed::Instant;
use crate::model::{End, Scalar};
use crate::motion::variation::LinkVariation;
use crate::motion::{LinkMotion, Motion};
use crate::round_off::ROW_GAP;
use crate::spatial::Wrench;
use crate::spatial::twist::Twist;
use nalgebra::Vector3;

/// The condition of a row.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Rule {
    /// The second end stays in a plane of the first link.
    Along {
        /// Normal of the plane, axes of the first link.
        axis: Vector3<f64>,
    },
    /// Two axes keep their angle.
    Aligned {
        /// Axes of the first link.
        first: Vector3<f64>,
        /// Axes of the second link.
        second: Vector3<f64>,
        /// Cosine of the angle.
        cosine: f64,
    },
    /// The distance along an axis goes with the angle about it.
    Thread {
        /// Unit vector of the axis, and one across it, axes of the first link.
        first: [Vector3<f64>; 2],
        /// Unit vector of the axis, and one across it, axes of the second link.
        second: [Vector3<f64>; 2],
        /// Pitch (m/rad).
        pitch: f64,
    },
    /// The ends keep their distance.
    Distance {
        /// Length (m).
        length: f64,
    },
    /// Coordinates keep a sum.
    Motion {
        /// Coordinates and their factors; a factor of zero for none.
        parts: [(Scalar, f64); 2],
    },
}

impl Rule {
    /// The hinge force of a unit multiplier on a link's coordinate.
    #[inline]
    pub(super) fn tau(&self, link: usize) -> f64 {
        let Self::Motion { parts } = self else { return 0.0 };
        let of = |(scalar, factor): &(Scalar, f64)| if scalar.link == link { *factor } else { 0.0 };
        parts.iter().map(of).sum()
    }

    /// Whether the gap is an angle.
    pub(super) fn turns(&self) -> bool {
        match self {
            Self::Along { .. } | Self::Thread { .. } | Self::Distance { .. } => false,
            Self::Aligned { .. } => true,
            Self::Motion { parts } => !parts[0].0.slides,
        }
    }

    /// The angle that a gap is (rad); `None` for the gap of a distance. That of two axes is a difference of cosines.
    pub(super) fn angle(&self, gap: f64) -> Option<f64> {
        match self {
            Self::Aligned { cosine, .. } => Some(((cosine + gap).clamp(-1.0, 1.0).acos() - cosine.acos()).abs()),
            _ => self.turns().then_some(gap.abs()),
        }
    }
}

/// A row at one state.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Placed {
    /// What a unit multiplier applies to the links of both ends, at their root markers.
    pub(super) wrenches: [Wrench; 2],
    /// `g` (m or rad).
    pub(super) gap: f64,
    /// `∂g/∂t` (m/s or rad/s).
    pub(super) drift: f64,
    /// What velocities and time add to `g̈` (m/s² or rad/s²).
    pub(super) bias: f64,
}

/// Both ends of a loop at one state.
pub(super) struct Ends<'a> {
    links: [&'a LinkMotion; 2],
    arms: [Vector3<f64>; 2],
    between: Vector3<f64>,
}

impl<'a> Ends<'a> {
    /// `branches` are the links from each end to where the two meet, that one left out: the vector between the ends is
    /// summed over them, with its rounding kept, so that it has all digits however far away the loop is.
    pub(super) fn of(ends: &[End; 2], branches: &[Vec<usize>; 2], motion: &'a Motion) -> Self {
        let links = [&motion.links[ends[0].link], &motion.links[ends[1].link]];
        let arms = [links[0].turn * ends[0].point, links[1].turn * ends[1].point];
        let (mut between, mut rounding) = (arms[1], Vector3::zeros());
        let mut add = |term: Vector3<f64>| {
            // Knuth's sum: the rounding of each addition is exactly known.
            let sum = between + term;
            let back = sum - between;
            rounding += (between - (sum - back)) + (term - back);
            between = sum;
        };
        branches[1].iter().for_each(|link| add(motion.links[*link].arm));
        add(-arms[0]);
        branches[0].iter().for_each(|link| add(-motion.links[*link].arm));
        Self { links, arms, between: between + rounding }
    }

    /// From the first end to the second (m).
    pub(super) fn between(&self) -> Vector3<f64> {
        self.between
    }

    /// The angle of a thread; axes as in [`Rule::Thread`].
    fn twist(&self, first: &[Vector3<f64>; 2], second: &[Vector3<f64>; 2]) -> Twist {
        let across = |link: &LinkMotion, [n, t]: &[Vector3<f64>; 2]| [link.turn * t, link.turn * n.cross(t)];
        Twist::between(across(self.links[0], first), across(self.links[1], second))
    }

    pub(super) fn place(&self, rule: &Rule) -> Placed {
        let ([a, b], [arm_a, arm_b], d) = (self.links, self.arms, self.between);
        let (wa, wb) = (a.angular_velocity, b.angular_velocity);
        let swing = |w: Vector3<f64>, r: Vector3<f64>| w.cross(&w.cross(&r));
        let along = |t: Vector3<f64>| {
            let reach = arm_a + d;
            // The second end seen from the first link.
            let slip = (b.velocity + wb.cross(&arm_b)) - (a.velocity + wa.cross(&reach));
            Placed {
                wrenches: pair(t, reach, arm_b),
                gap: t.dot(&d),
                drift: 0.0,
                bias: t.dot(&(swing(wb, arm_b) - swing(wa, reach) - 2.0 * wa.cross(&slip))),
            }
        };
        match *rule {
            Rule::Along { axis } => along(a.turn * axis),
            Rule::Thread { first, second, pitch } => {
                let (mut placed, twist) = (along(a.turn * first[0]), self.twist(&first, &second));
                placed.gap = twist.off_thread(placed.gap, pitch);
                placed.bias -= pitch * (wb - wa).dot(&twist.vary(&wa, &wb));
                Placed { wrenches: with_moments(placed.wrenches, -pitch * twist.gradient), ..placed }
            }
            Rule::Aligned { first, second, cosine } => {
                let (t, m) = (a.turn * first, b.turn * second);
                let normal = m.cross(&t);
                let normal_rate = wb.cross(&m).cross(&t) + m.cross(&wa.cross(&t));
                let turn = |moment: Vector3<f64>| Wrench { force: Vector3::zeros(), moment };
                Placed {
                    wrenches: [turn(-normal), turn(normal)],
                    gap: t.dot(&m) - cosine,
                    drift: 0.0,
                    bias: (wb - wa).dot(&normal_rate),
                }
            }
            Rule::Distance { length } => {
                let distance = d.norm();
                let e = d / distance;
                let rate = (b.velocity + wb.cross(&arm_b)) - (a.velocity + wa.cross(&arm_a));
                let across = rate - e * e.dot(&rate);
                Placed {
                    wrenches: pair(e, arm_a, arm_b),
                    gap: distance - length,
                    drift: 0.0,
                    bias: e.dot(&(swing(wb, arm_b) - swing(wa, arm_a))) + across.norm_squared() / distance,
                }
            }
            Rule::Motion { .. } => Placed::default(),
        }
    }

    /// How the wrenches of [`Ends::place`] vary when the links move by `by`: the geometric stiffness of the row.
    pub(super) fn vary(&self, rule: &Rule, by: [&LinkVariation; 2]) -> [Wrench; 2] {
        let ([a, b], [arm_a, arm_b], d) = (self.links, self.arms, self.between);
        let [arm_a_by, arm_b_by] = [by[0].turn.cross(&arm_a), by[1].turn.cross(&arm_b)];
        let d_by = (by[1].position + arm_b_by) - (by[0].position + arm_a_by);
        let along = |t: Vector3<f64>| {
            let t_by = by[0].turn.cross(&t);
            vary_pair(t, t_by, [arm_a + d, arm_b], [arm_a_by + d_by, arm_b_by])
        };
        match *rule {
            Rule::Along { axis } => along(a.turn * axis),
            Rule::Thread { first, second, pitch } => {
                let moment = -pitch * self.twist(&first, &second).vary(&by[0].turn, &by[1].turn);
                with_moments(along(a.turn * first[0]), moment)
            }
            Rule::Aligned { first, second, .. } => {
                let (t, m) = (a.turn * first, b.turn * second);
                let moment = by[1].turn.cross(&m).cross(&t) + m.cross(&by[0].turn.cross(&t));
                let turn = |moment: Vector3<f64>| Wrench { force: Vector3::zeros(), moment };
                [turn(-moment), turn(moment)]
            }
            Rule::Distance { .. } => {
                let distance = d.norm();
                let e = d / distance;
                let e_by = (d_by - e * e.dot(&d_by)) / distance;
                vary_pair(e, e_by, [arm_a, arm_b], [arm_a_by, arm_b_by])
            }
            Rule::Motion { .. } => [Wrench::ZERO; 2],
        }
    }
}

/// A motion row: `drift` and `bias` from the prescribed motion. A gap below the round-off of its own terms is none, however
/// long they are compared with the scene.
pub(super) fn place_motion(parts: &[(Scalar, f64); 2], q: &[f64], now: &Instant) -> Placed {
    let [first, second] = parts.map(|(scalar, factor)| factor * q[scalar.position]);
    let (gap, terms) = (first + second - now.position, first.abs() + second.abs() + now.position.abs());
    let gap = if gap.is_finite() && ROW_GAP.hides(gap, terms) { 0.0 } else { gap };
    Placed { gap, drift: -now.velocity, bias: -now.acceleration, ..Placed::default() }
}

/// A force on the second link and its opposite on the first.
fn pair(force: Vector3<f64>, first: Vector3<f64>, second: Vector3<f64>) -> [Wrench; 2] {
    [Wrench::at_arm(-force, first), Wrench::at_arm(force, second)]
}

/// With a moment on the second link and its opposite on the first.
fn with_moments([mut first, mut second]: [Wrench; 2], moment: Vector3<f64>) -> [Wrench; 2] {
    first.moment -= moment;
    second.moment += moment;
    [first, second]
}

fn vary_pair(f: Vector3<f64>, by: Vector3<f64>, arms: [Vector3<f64>; 2], arms_by: [Vector3<f64>; 2]) -> [Wrench; 2] {
    let part = |sign: f64, end: usize| Wrench {
        force: sign * by,
        moment: sign * (arms_by[end].cross(&f) + arms[end].cross(&by)),
    };
    [part(-1.0, 0), part(1.0, 1)]
}

/// `w·(linear, angular)`.
#[inline]
pub(super) fn power(wrench: &Wrench, linear: &Vector3<f64>, angular: &Vector3<f64>) -> f64 {
    wrench.force.dot(linear) + wrench.moment.dot(angular)
}
