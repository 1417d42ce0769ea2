//! Stress in cross sections that have a size, from the section forces.
//!
//! ```text
//! (1) σ = N/A + M_y z/I_y − M_z y/I_z                          axial force and bending (Euler, Bernoulli)
//! (2) τ = T r/J                                                 torsion of discs and rings
//!     τ = (2 T b/J) (1 − 8/π² Σ cosh(n π t/2b) / (n² cosh(n π a/2b)))     n odd; of rectangles (Saint-Venant), at t on a side of
//!                                                               length 2a that is b from the middle
//! (3) τ = k Q/A · cos φ, k = 4/3 (R² + R r + r²)/(R² + r²)      transverse shear of discs and rings, φ from the direction of Q
//!     τ = 3/2 Q/A (1 − (t/a)²)                                  of rectangles (Jourawski)
//! (4) σ_v = √(σ² + 3 τ²)                                        von Mises
//! ```
//!
//! Timoshenko and Goodier, Theory of Elasticity, §§ 109 and 121. Eq. (4) is largest on the outline, along which it is searched:
//! exactly on a circle, by its values at seventeen points of each side of a rectangle and a parabola through the largest and
//! its neighbours, which leaves some 10⁻⁴ of it where the maximum is inside a side, nothing at corners and middles.
//! Eqs. (1) to (3) are those of a straight rod: the factors of Wahl for coils and of Winkler for hooks are not in them, nor are
//! concentrations at clamps and holes.

use super::section::Section;
use nalgebra::Vector6;
use std::f64::consts::{PI, TAU};

/// The stress at the point of a section where von Mises' is largest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stress {
    /// Von Mises: eq. (4) (Pa).
    pub von_mises: f64,
    /// Normal stress there, tension > 0: eq. (1) (Pa).
    pub normal: f64,
    /// Shear stress there, along the outline: eqs. (2) and (3) (Pa).
    pub shear: f64,
    /// The point, in the section's y and z (m).
    pub at: [f64; 2],
}

/// Stress at a parameter of a curve on the outline: normal, shear and the point.
type Outline<'a> = &'a dyn Fn(f64) -> Stress;

impl Stress {
    fn new(normal: f64, shear: f64, at: [f64; 2]) -> Self {
        Self { von_mises: (normal * normal + 3.0 * shear * shear).sqrt(), normal, shear, at }
    }

    fn larger(self, other: Self) -> Self {
        if other.von_mises > self.von_mises { other } else { self }
    }
}

/// Where the outline of a disc is looked at; between these places Newton's method goes on.
const AROUND: usize = 16;
/// Newton steps from the best of these.
const STEPS: usize = 6;
/// Places on a side of a rectangle.
const ALONG: i32 = 8;
/// Terms of the series of eq. (2).
const TERMS: usize = 40;

impl Section {
    /// The largest stress that section forces (N, N m; as in [`crate::element`]) make; `None` of a stiffness, which has no size.
    pub fn stress(&self, forces: &Vector6<f64>) -> Option<Stress> {
        let [area, second_y, second_z, torsion] = self.geometry()?;
        let [n, qy, qz, t, my, mz] = <[f64; 6]>::from(*forces);
        match *self {
            Self::Circle { radius } => {
                let shear = [qy, qz].map(|q| 4.0 / 3.0 * q / area);
                let bending = [my, mz].map(|m| m * radius / second_y);
                Some(around(radius, n / area, bending, t * radius / torsion, shear))
            }
            Self::Tube { outer, inner } => {
                let squares = outer * outer + inner * inner;
                let shear = [qy, qz].map(|q| 4.0 / 3.0 * (squares + outer * inner) / squares * q / area);
                let bending = [my, mz].map(|m| m * outer / second_y);
                Some(around(outer, n / area, bending, t * outer / torsion, shear))
            }
            Self::Rectangle { width, height } => {
                let (a, b) = (0.5 * width, 0.5 * height);
                let normal = |y: f64, z: f64| n / area + my * z / second_y - mz * y / second_z;
                let across = |q: f64, part: f64| 1.5 * q / area * (1.0 - part * part);
                // Along z at y = ±a, then along y at z = ±b; a torque turns y to z.
                let upright = [1.0, -1.0].map(|side| {
                    side_of(&|part: f64| {
                        let twisted = side * t / torsion * twist_shear(b, a, part);
                        Stress::new(normal(side * a, part * b), twisted + across(qz, part), [side * a, part * b])
                    })
                });
                let flat = [1.0, -1.0].map(|side| {
                    side_of(&|part: f64| {
                        let twisted = -side * t / torsion * twist_shear(a, b, part);
                        Stress::new(normal(part * a, side * b), twisted + across(qy, part), [part * a, side * b])
                    })
                });
                upright.into_iter().chain(flat).reduce(Stress::larger)
            }
            Self::Stiffness(_) => None,
        }
    }
}

/// The largest on a circle: `mean + bending_y sin φ − bending_z cos φ` beside `torsion + shear_z cos φ − shear_y sin φ`.
fn around(radius: f64, mean: f64, bending: [f64; 2], torsion: f64, shear: [f64; 2]) -> Stress {
    let at = |angle: f64| {
        let (sin, cos) = angle.sin_cos();
        let normal = mean + bending[0] * sin - bending[1] * cos;
        Stress::new(normal, torsion + shear[1] * cos - shear[0] * sin, [radius * cos, radius * sin])
    };
    // The derivative of σ² + 3 τ² by the angle, and that of it.
    let slopes = |angle: f64| {
        let ((sin, cos), here) = (angle.sin_cos(), at(angle));
        let (s, t) = (here.normal, here.shear);
        let (ds, dt) = (bending[0] * cos + bending[1] * sin, -shear[1] * sin - shear[0] * cos);
        let (dds, ddt) = (mean - s, torsion - t);
        (s * ds + 3.0 * t * dt, ds * ds + s * dds + 3.0 * (dt * dt + t * ddt))
    };
    let mut best = at(0.0);
    let mut begin = 0.0;
    for k in 1..AROUND {
        let angle = TAU * k as f64 / AROUND as f64;
        let here = at(angle);
        if here.von_mises > best.von_mises {
            (best, begin) = (here, angle);
        }
    }
    let mut angle = begin;
    for _ in 0..STEPS {
        let (first, second) = slopes(angle);
        if !(second < 0.0) {
            break;
        }
        angle -= first / second;
        best = best.larger(at(angle));
    }
    best
}

/// The largest on a side from −1 to 1.
fn side_of(at: Outline<'_>) -> Stress {
    let size = |k: i32| at(f64::from(k) / f64::from(ALONG)).von_mises;
    let best = (-ALONG..=ALONG).max_by(|a, b| size(*a).total_cmp(&size(*b))).unwrap_or(0);
    let found = at(f64::from(best) / f64::from(ALONG));
    if best.abs() == ALONG {
        return found;
    }
    let [before, here, after] = [size(best - 1), size(best), size(best + 1)];
    let bent = before - 2.0 * here + after;
    if !(bent < 0.0) {
        return found;
    }
    let vertex = f64::from(best) + 0.5 * (before - after) / bent;
    found.larger(at(vertex / f64::from(ALONG)))
}

/// Eq. (2) for a torque `J`, at a part −1 … 1 of a side of length `2a` that is `b` from the middle (m).
fn twist_shear(a: f64, b: f64, part: f64) -> f64 {
    if part.abs() >= 1.0 {
        return 0.0;
    }
    let ratio = |n: f64| {
        let (t, end) = (n * PI * part.abs() * a / (2.0 * b), n * PI * a / (2.0 * b));
        // cosh t / cosh end without overflow.
        (t - end).exp() * (1.0 + (-2.0 * t).exp()) / (1.0 + (-2.0 * end).exp())
    };
    let sum: f64 = (0..TERMS).map(|k| (2 * k + 1) as f64).map(|n| ratio(n) / (n * n)).sum();
    2.0 * b * (1.0 - 8.0 / (PI * PI) * sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(section: Section, forces: [f64; 6]) -> Stress {
        section.stress(&Vector6::from(forces)).expect("a size")
    }

    const ROD: Section = Section::Circle { radius: 0.01 };

    /// Handbook cases of a disc: each alone, bending about any direction, and bending with torsion by Guest's formula.
    #[test]
    fn a_disc() {
        let (area, second) = (PI * 1e-4, PI / 4.0 * 1e-8);
        let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} {b}");
        close(of(ROD, [100.0, 0.0, 0.0, 0.0, 0.0, 0.0]).von_mises, 100.0 / area);
        close(of(ROD, [0.0, 0.0, 0.0, 0.0, 3.0, 4.0]).von_mises, 5.0 * 0.01 / second);
        close(of(ROD, [0.0, 0.0, 0.0, 2.0, 0.0, 0.0]).shear, 2.0 * 0.01 / (2.0 * second));
        close(of(ROD, [0.0, 3.0, 4.0, 0.0, 0.0, 0.0]).shear.abs(), 4.0 / 3.0 * 5.0 / area);
        close(of(ROD, [0.0, 0.0, 0.0, 2.0, 3.0, 4.0]).von_mises, (25.0 + 0.75 * 4.0_f64).sqrt() * 0.01 / second);
        let at = of(ROD, [-1.0, 0.0, 0.0, 0.0, 3.0, 0.0]).at;
        assert!(at[0].abs() < 1e-9 && (at[1] + 0.01).abs() < 1e-12, "pressed where z < 0: {at:?}");
    }

    /// A thin tube is sheared by 2 Q/A, and twisted by T/(2 A t) (Bredt).
    #[test]
    fn a_thin_tube() {
        let (outer, inner) = (0.1, 0.099_9);
        let tube = Section::Tube { outer, inner };
        let area = tube.geometry().expect("a size")[0];
        assert!((of(tube, [0.0, 5.0, 0.0, 0.0, 0.0, 0.0]).shear.abs() * area / 10.0 - 1.0).abs() < 1e-3);
        let bredt = 7.0 / (2.0 * PI * 0.099_95_f64.powi(2) * (outer - inner));
        assert!((of(tube, [0.0, 0.0, 0.0, 7.0, 0.0, 0.0]).shear / bredt - 1.0).abs() < 2e-3);
    }

    /// The largest shear of twisted rectangles, T/(k₂ a b²), and where: Timoshenko and Goodier, table 7.
    #[test]
    fn twisted_rectangles() {
        for (ratio, tabulated) in [(1.0, 0.208), (1.5, 0.231), (2.0, 0.246), (3.0, 0.267), (10.0, 0.312)] {
            let found = of(Section::Rectangle { width: ratio, height: 1.0 }, [0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
            assert!((1.0 / (found.shear.abs() * ratio) - tabulated).abs() < 8e-4, "{ratio}: {found:?}");
            assert!(ratio == 1.0 || found.at[0].abs() < 1e-9, "on the long side: {found:?}");
        }
        // Bent about both axes: the corner.
        let bent = of(Section::Rectangle { width: 0.03, height: 0.02 }, [5.0, 0.0, 0.0, 0.0, 2.0, -3.0]);
        let corner = 5.0 / 6e-4 + 2.0 * 6.0 / (0.03 * 4e-4) + 3.0 * 6.0 / (0.02 * 9e-4);
        assert!((bent.von_mises / corner - 1.0).abs() < 1e-12 && bent.at == [0.015, 0.01], "{bent:?}");
    }

    /// Within a side, where neither bending nor torsion alone is largest: against a search in small steps.
    #[test]
    fn bent_and_twisted_rectangles() {
        let section = Section::Rectangle { width: 0.01, height: 0.03 };
        let forces = Vector6::new(0.0, 0.0, 200.0, 3.0, 12.0, 0.6);
        let found = section.stress(&forces).expect("a size");
        let [_, about_y, about_z, torsion] = section.geometry().expect("a size");
        // On the upper side, where bending about y is largest.
        let at = |y: f64| {
            let sigma = forces[4] * 0.015 / about_y - forces[5] * y / about_z;
            let tau = forces[3] / torsion * twist_shear(0.005, 0.015, y / 0.005);
            (sigma * sigma + 3.0 * tau * tau).sqrt()
        };
        let fine = (0..=4000).map(|k| at(0.005 * (f64::from(k) / 2000.0 - 1.0))).fold(0.0, f64::max);
        assert!((found.von_mises / fine - 1.0).abs() < 5e-4, "{found:?} {fine}");
        assert!(found.at[1] == 0.015 && found.at[0] < -1e-4 && found.at[0] > -0.0049, "inside the side: {found:?}");
    }
}
