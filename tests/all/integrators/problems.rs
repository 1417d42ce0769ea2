//! Small systems with closed forms.

use nalgebra::{Matrix3, Quaternion, Vector3};
use stillpoint::integrate::{Failure, ImplicitProblem, Point, Problem};

type Law = Box<dyn Fn(f64, f64, f64) -> f64>;
type Slopes = Box<dyn Fn(f64, f64, f64) -> (f64, f64)>;

/// One coordinate: `q̈ = f(t, q, q̇)`, all scales 1.
pub(super) struct Scalar {
    law: Law,
    /// `(∂f/∂q, ∂f/∂q̇)`.
    slopes: Slopes,
    pivot: f64,
}

impl Scalar {
    pub(super) fn new(
        law: impl Fn(f64, f64, f64) -> f64 + 'static,
        slopes: impl Fn(f64, f64, f64) -> (f64, f64) + 'static,
    ) -> Self {
        Self { law: Box::new(law), slopes: Box::new(slopes), pivot: 1.0 }
    }

    /// `q̈ + damping q̇ + stiffness q = force(t)`.
    pub(super) fn oscillator(stiffness: f64, damping: f64, force: impl Fn(f64) -> f64 + 'static) -> Self {
        Self::new(move |t, q, v| force(t) - damping * v - stiffness * q, move |_, _, _| (-stiffness, -damping))
    }

    /// A pendulum of unit frequency, its angle measured from the horizontal.
    pub(super) fn pendulum() -> Self {
        Self::new(|_, q, _| -q.cos(), |_, q, _| (q.sin(), 0.0))
    }

    /// `q̈ = μ (1 − q²) q̇ − q`.
    pub(super) fn van_der_pol(mu: f64) -> Self {
        Self::new(
            move |_, q, v| mu * (1.0 - q * q) * v - q,
            move |_, q, v| (-2.0 * mu * q * v - 1.0, mu * (1.0 - q * q)),
        )
    }
}

impl Problem for Scalar {
    fn position_count(&self) -> usize {
        1
    }
    fn velocity_count(&self) -> usize {
        1
    }
    fn acceleration(&mut self, time: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<(), Failure> {
        a[0] = (self.law)(time, q[0], v[0]);
        Ok(())
    }
    fn position_rate(&self, _q: &[f64], v: &[f64], rate: &mut [f64]) {
        rate.copy_from_slice(v);
    }
    fn normalize(&self, _q: &mut [f64]) {}
    fn scales(&self) -> (&[f64], &[f64]) {
        (&[1.0], &[1.0])
    }
}

impl ImplicitProblem for Scalar {
    fn implicit_position(&self, start: &[f64], step: f64, v: &[f64], q: &mut [f64]) {
        q[0] = start[0] + step * v[0];
    }
    fn displace(&self, from: &[f64], by: &[f64], q: &mut [f64]) {
        q[0] = from[0] + by[0];
    }
    fn residual(&mut self, time: f64, q: &[f64], v: &[f64], a: &[f64], r: &mut [f64]) -> Result<(), Failure> {
        r[0] = a[0] - (self.law)(time, q[0], v[0]);
        Ok(())
    }
    fn reserve(&mut self) {}
    fn factorize(&mut self, at: Point<'_>, c1: f64, c2: f64) -> Result<(), Failure> {
        let (by_q, by_v) = (self.slopes)(at.time, at.q[0], at.v[0]);
        self.pivot = c2 - c1 * by_v - by_q;
        Ok(())
    }
    fn solve(&mut self, rhs: &mut [f64]) {
        rhs[0] /= self.pivot;
    }
}

/// A rigid body on a fixed point: `q` its attitude as a quaternion (w, x, y, z), `v` its angular velocity in body axes.
pub(super) struct Body {
    inertia: Matrix3<f64>,
    /// The weight's moment arm, in body axes, times the weight: torque `arm × (−up)`.
    arm: Vector3<f64>,
    inverse: Matrix3<f64>,
}

impl Body {
    pub(super) fn new(moments: [f64; 3], arm: [f64; 3]) -> Self {
        Self { inertia: Matrix3::from_diagonal(&moments.into()), arm: arm.into(), inverse: Matrix3::identity() }
    }

    /// The attitude at `time` of a torque-free body with moments `(a, a, c)`, from the identity with `spin`:
    /// `exp(½ t L/a) exp(½ t (1 − c/a) ω₃ e₃)`, see Landau, Lifshitz, *Mechanics*, § 33.
    pub(super) fn symmetric_attitude(a: f64, c: f64, spin: Vector3<f64>, time: f64) -> [f64; 4] {
        let turn = |rate: Vector3<f64>| Quaternion::from_imag(0.5 * time * rate).exp();
        let precession = Vector3::new(spin.x, spin.y, c / a * spin.z);
        numbers(turn(precession) * turn(Vector3::new(0.0, 0.0, (1.0 - c / a) * spin.z)))
    }

    fn up(q: &[f64]) -> Vector3<f64> {
        let p = quaternion(q).normalize();
        (p.conjugate() * Quaternion::from_imag(Vector3::z()) * p).imag()
    }

    fn torque(&self, q: &[f64], v: &[f64]) -> Vector3<f64> {
        let spin = Vector3::from_column_slice(v);
        -self.arm.cross(&Self::up(q)) - spin.cross(&(self.inertia * spin))
    }
}

fn quaternion(q: &[f64]) -> Quaternion<f64> {
    Quaternion::new(q[0], q[1], q[2], q[3])
}

fn numbers(p: Quaternion<f64>) -> [f64; 4] {
    [p.w, p.i, p.j, p.k]
}

fn half_rate(p: Quaternion<f64>, v: &[f64]) -> Quaternion<f64> {
    p * Quaternion::from_imag(0.5 * Vector3::from_column_slice(v))
}

impl Problem for Body {
    fn position_count(&self) -> usize {
        4
    }
    fn velocity_count(&self) -> usize {
        3
    }
    fn acceleration(&mut self, _time: f64, q: &[f64], v: &[f64], a: &mut [f64]) -> Result<(), Failure> {
        let torque = self.torque(q, v);
        a.iter_mut().enumerate().for_each(|(i, a)| *a = torque[i] / self.inertia[(i, i)]);
        Ok(())
    }
    fn position_rate(&self, q: &[f64], v: &[f64], rate: &mut [f64]) {
        rate.copy_from_slice(&numbers(half_rate(quaternion(q), v)));
    }
    fn normalize(&self, q: &mut [f64]) {
        q.copy_from_slice(&numbers(quaternion(q).normalize()));
    }
    fn scales(&self) -> (&[f64], &[f64]) {
        (&[1.0; 4], &[1.0; 3])
    }
}

impl ImplicitProblem for Body {
    fn implicit_position(&self, start: &[f64], step: f64, v: &[f64], q: &mut [f64]) {
        // (I − ½ h Ω) p = p*, Ω² = −|ω|² I.
        let start = quaternion(start);
        let squared: f64 = v.iter().map(|v| v * v).sum();
        let p = (start + half_rate(start, v) * step) / (1.0 + 0.25 * step * step * squared);
        q.copy_from_slice(&numbers(p));
    }
    fn displace(&self, from: &[f64], by: &[f64], q: &mut [f64]) {
        let turn = Quaternion::from_imag(0.5 * Vector3::from_column_slice(by)).exp();
        q.copy_from_slice(&numbers(quaternion(from) * turn));
    }
    fn residual(&mut self, _time: f64, q: &[f64], v: &[f64], a: &[f64], r: &mut [f64]) -> Result<(), Failure> {
        r.copy_from_slice((self.inertia * Vector3::from_column_slice(a) - self.torque(q, v)).as_slice());
        Ok(())
    }
    fn reserve(&mut self) {}
    fn factorize(&mut self, at: Point<'_>, c1: f64, c2: f64) -> Result<(), Failure> {
        let spin = Vector3::from_column_slice(at.v);
        let by_v = spin.cross_matrix() * self.inertia - (self.inertia * spin).cross_matrix();
        let by_q = self.arm.cross_matrix() * Self::up(at.q).cross_matrix();
        let matrix = self.inertia * c2 + by_v * c1 + by_q;
        self.inverse = matrix.try_inverse().ok_or_else(|| Failure { message: "the body is singular".into() })?;
        Ok(())
    }
    fn solve(&mut self, rhs: &mut [f64]) {
        let solution = self.inverse * Vector3::from_column_slice(rhs);
        rhs.copy_from_slice(solution.as_slice());
    }
}
