//! The elastic catenary (Irvine, Cable Structures, 1981): a cable without bending stiffness between two points under a weight
//! per unstretched length.
//!
//! ```text
//! (1) x(s) = H s/EA + H/w (asinh V/H − asinh (V − w s)/H)                 across
//! (2) z(s) = s/EA (V − w s/2) + 1/w (√(H² + V²) − √(H² + (V − w s)²))     along the weight
//! ```
//!
//! `H` and `V` are the parts of the tension at the start. `x(L)` and `z(L)` are the gradient of a convex function of them, the
//! complementary energy, so that Newton's method with a line search finds them from anywhere.

use nalgebra::{Matrix2, Vector2};

/// A cable between two points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Catenary {
    /// Parts of the tension at its start, across and along the weight (N).
    pub tension: Vector2<f64>,
    /// Per unstretched length (N/m).
    weight: f64,
}

const MOST_STEPS: usize = 200;

impl Catenary {
    /// A cable of an unstretched length (m) whose end lies `way` (m) from its start: across, not negative, and along the
    /// weight (N/m). `compliance` is `1/EA` (1/N), 0 for one that does not stretch. `None` if it has no shape: too
    /// short, or slack without weight.
    pub fn between(way: Vector2<f64>, length: f64, compliance: f64, weight: f64) -> Option<Self> {
        let chord = way.norm();
        if !(weight * length > 0.0) {
            let tension = (chord / length - 1.0) / compliance;
            let direction = way / chord;
            return (tension > 0.0 && tension.is_finite()).then(|| Self { tension: tension * direction, weight: 0.0 });
        }
        // Straight down it has no width.
        let way = Vector2::new(way.x.max(1e-6 * length), way.y);
        let mut at = Self { tension: first(way, length, compliance, weight), weight };
        let mut gap = at.end(length, compliance) - way;
        for _ in 0..MOST_STEPS {
            if gap.norm() <= 1e-13 * length {
                return Some(at);
            }
            let step = at.stiffness(length, compliance)?.lu().solve(&-gap)?;
            let mut part = 1.0;
            loop {
                let mut next = at;
                next.tension += part * step;
                let left = next.end(length, compliance) - way;
                if next.tension.x > 0.0 && left.norm() < gap.norm() {
                    (at, gap) = (next, left);
                    break;
                }
                part *= 0.5;
                if part < 1e-12 {
                    return (gap.norm() <= 1e-9 * length).then_some(at);
                }
            }
        }
        None
    }

    /// The unstretched length, of a taut cable first, at which the tension at the start falls to the given one; `None` if it
    /// never does, for the weight alone is more.
    pub fn tensioned(way: Vector2<f64>, tension: f64, compliance: f64, weight: f64) -> Option<f64> {
        let chord = way.norm();
        if !(weight > 0.0) {
            return (compliance > 0.0 && chord > 0.0).then_some(chord / (1.0 + tension * compliance));
        }
        // The start may bear less than the rest, by no more than the weight.
        let taut = chord / (1.0 + (tension + weight * chord) * compliance);
        let excess =
            |length: f64| Self::between(way, length, compliance, weight).map(|one| one.tension.norm() - tension);
        let (mut short, mut step) = (taut * (1.0 + 1e-12), 1e-9 * chord);
        if !(excess(short)? >= 0.0) {
            return None;
        }
        let mut long = short + step;
        while excess(long)? > 0.0 {
            (short, step) = (long, 2.0 * step);
            long = short + step;
            if step > 4.0 * chord {
                return None;
            }
        }
        for _ in 0..100 {
            let middle = 0.5 * (short + long);
            if excess(middle)? > 0.0 { short = middle } else { long = middle }
        }
        Some(short)
    }

    /// Of (1) and (2) at the end.
    fn end(&self, length: f64, compliance: f64) -> Vector2<f64> {
        let (h, v, w) = (self.tension.x, self.tension.y, self.weight);
        let (far, here) = (v - w * length, h.hypot(v));
        let there = h.hypot(far);
        // As products: the differences of (1) and (2) lose their digits where the cable is taut.
        let middle = length * (v - 0.5 * w * length);
        let sum = if v * far > 0.0 {
            2.0 * w * middle / (v * there + far * here)
        } else {
            (v * there - far * here) / (h * h)
        };
        let across = h * length * compliance + h / w * sum.asinh();
        Vector2::new(across, middle * compliance + 2.0 * middle / (here + there))
    }

    /// The derivatives of [`Self::end`] by the tension: symmetric, positive definite.
    fn stiffness(&self, length: f64, compliance: f64) -> Option<Matrix2<f64>> {
        let (h, v, w) = (self.tension.x, self.tension.y, self.weight);
        let far = v - w * length;
        let (here, there) = (h.hypot(v), h.hypot(far));
        let stretch = length * compliance;
        let beside = h / w * (1.0 / here - 1.0 / there);
        let sines = (v / here - far / there) / w;
        let across = stretch + ((v / h).asinh() - (far / h).asinh()) / w - sines;
        let matrix = Matrix2::new(across, beside, beside, stretch + sines);
        matrix.iter().all(|x| x.is_finite()).then_some(matrix)
    }

    /// How far the cable points along the weight, from across it, at an unstretched distance from its start (rad).
    pub fn slope(&self, s: f64) -> f64 {
        (self.tension.y - self.weight * s).atan2(self.tension.x)
    }

    /// Rate of the slope (rad/m).
    pub fn curvature(&self, s: f64) -> f64 {
        let v = self.tension.y - self.weight * s;
        -self.weight * self.tension.x / (self.tension.x * self.tension.x + v * v)
    }

    /// The tension at an unstretched distance from its start (N).
    pub fn tension_at(&self, s: f64) -> f64 {
        self.tension.x.hypot(self.tension.y - self.weight * s)
    }
}

/// A tension to begin with: of a parabola with that sag (Peyrot and Goulois 1979), or of the chord where it is longer than the cable.
fn first(way: Vector2<f64>, length: f64, compliance: f64, weight: f64) -> Vector2<f64> {
    let (chord, half) = (way.norm(), 0.5 * weight);
    if chord >= length {
        let pull = if compliance > 0.0 { (chord / length - 1.0) / compliance } else { weight * length };
        return way * (pull.max(weight * length) / chord) + Vector2::new(0.0, half * length);
    }
    let sag = (3.0 * ((length * length - way.y * way.y) / (way.x * way.x) - 1.0)).sqrt();
    let vertical = half * (way.y / sag.tanh() + length);
    Vector2::new(half * way.x / sag, vertical)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two cables of 110 m over a span of 100 m (Irvine's closed form, solved to 15 digits elsewhere).
    #[test]
    fn tensions_of_elastic_catenaries() {
        for (compliance, below, expected) in [
            (1e-6, 0.0, [3_203.365_716_381_921, 2_750.0]),
            (1e-4, 20.0, [1_567.865_453_410_525, 3_187.956_594_603_747]),
        ] {
            let found = Catenary::between(Vector2::new(100.0, below), 110.0, compliance, 50.0).expect("a shape");
            assert!((found.tension - Vector2::from(expected)).norm() < 1e-8, "{found:?}");
        }
    }

    /// Back from the tension at the start; a cable as slack as to bear more than at its best has a taut one beside it.
    #[test]
    fn a_tension_has_a_length() {
        let way = Vector2::new(100.0, 20.0);
        for length in [98.0, 101.9, 101.98, 102.0, 103.0] {
            let found = Catenary::between(way, length, 1e-6, 50.0).expect("a shape");
            let back = Catenary::tensioned(way, found.tension.norm(), 1e-6, 50.0).expect("a length");
            assert!((back - length).abs() < 1e-9, "{length} {back}");
        }
        assert_eq!(Catenary::tensioned(way, 2000.0, 1e-6, 50.0), None);
    }

    /// From taut ones to those that hang straight down and up again, stiff and soft.
    #[test]
    fn every_cable_that_is_long_enough_has_a_shape() {
        for length in [0.9, 0.999, 1.0, 1.001, 1.1, 2.0, 10.0] {
            for angle in [-1.57, -1.0, 0.0, 0.3, 1.5] {
                for compliance in [1e-9, 1e-4, 1.0] {
                    let way = Vector2::new(f64::cos(angle), f64::sin(angle));
                    let found = Catenary::between(way, length, compliance, 2.0);
                    let found = found.unwrap_or_else(|| panic!("{length} m at {angle} rad, 1/EA = {compliance}"));
                    let gap = found.end(length, compliance) - way;
                    assert!(gap.norm() < 1e-5 * length, "{length} {angle} {compliance}: {gap:?}");
                }
            }
        }
        assert_eq!(Catenary::between(Vector2::new(1.0, 0.0), 0.999, 0.0, 2.0), None);
        assert_eq!(Catenary::between(Vector2::new(1.0, 0.0), 1.1, 1e-6, 0.0), None);
    }
}
