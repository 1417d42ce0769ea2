//! The angle about an axis between two frames, with its derivatives: what a thread turns by.
//!
//! ```text
//! t, u    two unit axes across n, carried by the first frame;   t', u'  the same, carried by the second
//! (1)     φ = atan2(u·t' − t·u', t·t' + u·u')
//! (2)     t̂ = t cos φ + u sin φ,   û = u cos φ − t sin φ,   r = t̂·t' + û·u'
//! (3)     φ̇ = m·(ω' − ω),   m = (t' × û + t̂ × u')/r             m = n if both frames share n
//! (4)     ṁ = (t' × (ω × û) + (ω' × t') × û + t̂ × (ω' × u') + (ω × t̂) × u' − φ̇ Q − (Q·(ω' − ω)) m)/r
//!         Q = t' × t̂ + u' × û
//! ```
//!
//! `φ` is the twist of the relative rotation about `n`, between −π and π; where the second frame's `n` points against the
//! first's it is not defined. (4) holds for rates and for small turns alike.

use nalgebra::Vector3;

/// The angle about an axis between two frames, and its gradient.
#[derive(Debug, Clone, Copy)]
pub struct Twist {
    /// `φ` (rad), between −π and π.
    pub angle: f64,
    /// `m`: the rate of the angle for a unit of relative angular velocity.
    pub gradient: Vector3<f64>,
    /// `t̂`, `û` and `t'`, `u'`.
    axes: [Vector3<f64>; 4],
    /// `r`.
    size: f64,
}

impl Twist {
    /// From the axes `t`, `u` of the first frame and `t'`, `u'` of the second, all in the same axes.
    pub fn between([t, u]: [Vector3<f64>; 2], [of_t, of_u]: [Vector3<f64>; 2]) -> Self {
        let angle = (u.dot(&of_t) - t.dot(&of_u)).atan2(t.dot(&of_t) + u.dot(&of_u));
        let (sin, cos) = angle.sin_cos();
        let (t, u) = (cos * t + sin * u, cos * u - sin * t);
        let size = t.dot(&of_t) + u.dot(&of_u);
        let gradient = (of_t.cross(&u) + t.cross(&of_u)) / size;
        Self { angle, gradient, axes: [t, u, of_t, of_u], size }
    }

    /// Eq. (4): `ṁ` for angular velocities of both frames, or how `m` varies with small turns of them.
    pub fn vary(&self, first: &Vector3<f64>, second: &Vector3<f64>) -> Vector3<f64> {
        let [t, u, of_t, of_u] = &self.axes;
        let relative = second - first;
        let q = of_t.cross(t) + of_u.cross(u);
        let carried = of_t.cross(&first.cross(u))
            + second.cross(of_t).cross(u)
            + t.cross(&second.cross(of_u))
            + first.cross(t).cross(of_u);
        (carried - self.gradient.dot(&relative) * q - q.dot(&relative) * self.gradient) / self.size
    }

    /// How far `distance` (m) along the axis is from what a thread of `pitch` (m/rad) has for this angle, on its nearest turn.
    pub fn off_thread(&self, distance: f64, pitch: f64) -> f64 {
        let (off, lead) = (distance - pitch * self.angle, std::f64::consts::TAU * pitch);
        off - lead * (off / lead).round()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::UnitQuaternion;

    fn frame(turn: &UnitQuaternion<f64>) -> [Vector3<f64>; 2] {
        [turn * Vector3::x(), turn * Vector3::y()]
    }

    /// (3) and (4) are derivatives of (1) and (3), also where the frames do not share their axis. Central differences: errors
    /// of order step² and round-off/step, both near 1e-10.
    #[test]
    fn gradients_are_derivatives() {
        let step = 1e-5;
        let turned = |of: &UnitQuaternion<f64>, by: Vector3<f64>| UnitQuaternion::from_scaled_axis(by) * of;
        for i in 0..200 {
            let number = |k: u32| (f64::from(i * 37 + k) * 0.618_033_988_749_894_9).fract() * 2.0 - 1.0;
            let vector = |k: u32| Vector3::new(number(k), number(k + 1), number(k + 2));
            let first = UnitQuaternion::from_scaled_axis(3.0 * vector(0));
            let tilt = UnitQuaternion::from_scaled_axis(0.4 * vector(3));
            let second = first * UnitQuaternion::from_scaled_axis(Vector3::z() * (2.9 * number(6))) * tilt;
            let (w, of_w) = (vector(7), vector(10));
            let at = |s: f64| Twist::between(frame(&turned(&first, s * w)), frame(&turned(&second, s * of_w)));
            let (before, now, after) = (at(-step), at(0.0), at(step));
            let rate = (after.angle - before.angle) / (2.0 * step);
            assert!((rate - now.gradient.dot(&(of_w - w))).abs() < 1e-8, "{i}: {rate}");
            let varied = (after.gradient - before.gradient) / (2.0 * step);
            assert!((varied - now.vary(&w, &of_w)).norm() < 1e-8, "{i}: {varied}");
        }
    }

    /// Without a tilt the twist is the angle, and its gradient the axis.
    #[test]
    fn the_twist_about_a_shared_axis_is_the_angle() {
        for angle in [-3.1, -1.0, 0.0, 1e-9, 2.0, 3.1] {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::z() * angle);
            let twist = Twist::between(frame(&UnitQuaternion::identity()), frame(&turn));
            assert!((twist.angle - angle).abs() < 1e-15 && (twist.gradient - Vector3::z()).norm() < 1e-15);
            assert!(twist.off_thread(0.02 * (angle + std::f64::consts::TAU * 7.0), 0.02).abs() < 1e-15);
        }
    }
}
