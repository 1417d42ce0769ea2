//! What an integrator needs to know of a system: nothing of mechanics.

use std::fmt;

/// A second-order system in hinge coordinates: `q̇ = N(q) v`, `v̇ = a(t, q, v)`.
///
/// `q` may hold unit quaternions (then it is longer than `v`); they are stepped as plain numbers in R⁴ and normalised
/// after the step. Within a step they are off unit length by `O(h²)`: the functions here should take the rotation of
/// `p / |p|` (any smooth extension keeps the order, this one is the most accurate).
///
/// No method here may allocate, if the steps are not to.
pub trait Problem {
    /// Number of coordinates `q`.
    fn position_count(&self) -> usize;
    /// Number of velocities `v`.
    fn velocity_count(&self) -> usize;
    /// `a ← a(t, q, v)`.
    ///
    /// # Errors
    /// If the system is singular or a number is not finite; the failure names the element.
    fn acceleration(&mut self, time: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<(), Failure>;
    /// `rate ← N(q) v`: for plain coordinates `v`, for a quaternion `½ p ∘ (0, ω)`.
    fn position_rate(&self, q: &[f64], v: &[f64], rate: &mut [f64]);
    /// Normalises the quaternions of `q`.
    fn normalize(&self, q: &mut [f64]);
    /// Brings a state back onto what binds its coordinates beyond the quaternions' norm (closed loops); true where that
    /// changed it. Asked once per accepted step, after [`normalize`](Self::normalize).
    ///
    /// # Errors
    /// Where there is no such state nearby: the step is then tried again, shorter.
    fn project(&mut self, _time: f64, _q: &mut [f64], _v: &mut [f64]) -> Result<bool, Failure> {
        Ok(false)
    }
    /// The longest step (s) from a state in which nothing is overlooked that estimates of errors do not see.
    fn longest_step(&self, _q: &[f64], _v: &[f64]) -> f64 {
        f64::INFINITY
    }
    /// The sizes at which an absolute error counts as much as a relative one, per coordinate of `q` and of `v`:
    /// 1 rad (also for the numbers of a quaternion) and the scene's length for positions, the same per the scene's time
    /// for velocities. All above 0; the integrators take their ratio as the time in which things happen.
    fn scales(&self) -> (&[f64], &[f64]);
}

/// What implicit methods need beyond [`Problem`].
pub trait ImplicitProblem: Problem {
    /// Solves `q = start + step N(q) v` for `q`, without normalising it: `start + step v` for plain coordinates, and for
    /// a quaternion, with `Ω(ω) p = p ∘ (0, ω)` and `Ω² = −|ω|²`,
    ///
    /// ```text
    /// p = (p* + ½ step Ω p*) / (1 + ¼ step² |ω|²).
    /// ```
    fn implicit_position(&self, start: &[f64], step: f64, v: &[f64], q: &mut [f64]);
    /// `q ← from ⊞ by`: plain coordinates add, a quaternion is turned by the rotation vector `by` in body axes.
    fn displace(&self, from: &[f64], by: &[f64], q: &mut [f64]);
    /// `r ← M(q) a + b(t, q, v) − τ(t, q, v)`, the inverse dynamics residual; it must be affine in `a` and vanish where
    /// [`acceleration`](Problem::acceleration) says so.
    ///
    /// # Errors
    /// If a number is not finite.
    fn residual(&mut self, time: f64, q: &[f64], v: &[f64], a: &[f64], r: &mut [f64]) -> Result<(), Failure>;
    /// Whether a step whose Newton iteration fails is tried again with a tangent at the place of each correction before it is
    /// shortened: where residuals of some rows are 10⁸ times those of others, the tangent of a place that is turned by 10⁻⁵ takes
    /// parts of the former for the latter.
    fn asks_for_care(&self) -> bool {
        false
    }
    /// Makes room for a factorization; asked once, when a method starts.
    fn reserve(&mut self);
    /// Factorizes `c₂ ∂r/∂a + c₁ ∂r/∂v + ∂r/∂q` at this point (`∂q` in velocity coordinates).
    ///
    /// # Errors
    /// If it is singular.
    fn factorize(&mut self, at: Point<'_>, c1: f64, c2: f64) -> Result<(), Failure>;
    /// Solves with the factorization last made, in place.
    fn solve(&mut self, rhs: &mut [f64]);
}

/// A point at which to linearise.
#[derive(Debug, Clone, Copy)]
pub struct Point<'a> {
    /// In s.
    pub time: f64,
    /// Coordinates, `position_count` of them; quaternions need not be normalised.
    pub q: &'a [f64],
    /// Velocities, `velocity_count` of them.
    pub v: &'a [f64],
    /// Accelerations, `velocity_count` of them.
    pub a: &'a [f64],
}

/// Why a system could not be evaluated.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    /// The element and what happened there, for people.
    pub message: String,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}
