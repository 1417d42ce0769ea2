//! Cross sections: what they weigh and how stiff they are.

use super::rod::RodSection;
use nalgebra::{Matrix6, Vector3, Vector6};
use std::f64::consts::PI;

/// The shape of a cross section in the section's y and z, or its stiffness.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "few of them, copied while a scene is built")]
pub enum Section {
    /// A disc.
    Circle {
        /// Radius (m).
        radius: f64,
    },
    /// A ring.
    Tube {
        /// Outer radius (m).
        outer: f64,
        /// Inner radius (m).
        inner: f64,
    },
    /// A rectangle.
    Rectangle {
        /// Along y (m).
        width: f64,
        /// Along z (m).
        height: f64,
    },
    /// Stiffness alone, symmetric: rows and columns are stretch, shear y and z (N); twist, bending about y and z (N m²).
    Stiffness(Matrix6<f64>),
}

/// What a section is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Young's modulus (Pa).
    pub young: f64,
    /// Poisson's ratio, −1 … 0.5.
    pub poisson: f64,
    /// Density (kg/m³).
    pub density: f64,
}

/// Shear correction of a disc (Timoshenko 1921; Cowper has 0.886 for Poisson's ratio 0.3), and of a rectangle (Reissner 1945).
const OF_DISC: f64 = 0.9;
const OF_RECTANGLE: f64 = 5.0 / 6.0;

/// Shear correction of a ring by Poisson's ratio (Cowper 1966, The shear coefficient in
/// Timoshenko's beam theory, table 1).
fn shear_of_ring(outer: f64, inner: f64, poisson: f64) -> f64 {
    let m = (inner / outer).powi(2);
    let whole = (1.0 + m).powi(2);
    6.0 * (1.0 + poisson) * whole / ((7.0 + 6.0 * poisson) * whole + (20.0 + 12.0 * poisson) * m)
}

/// Terms of the series of a rectangle's torsion: the fifth powers of the odd numbers leave less than 10⁻⁹ after these.
const TERMS: usize = 40;

/// Saint-Venant torsion constant of a rectangle (m⁴).
fn rectangle_torsion(width: f64, height: f64) -> f64 {
    let (a, b) = (width.max(height), width.min(height));
    let term = |n: usize| {
        let odd = (2 * n + 1) as f64;
        (odd * PI * a / (2.0 * b)).tanh() / odd.powi(5)
    };
    a * b.powi(3) * (1.0 / 3.0 - 64.0 / PI.powi(5) * b / a * (0..TERMS).map(term).sum::<f64>())
}

impl Section {
    /// Area (m²), second moments about y and z and the torsion constant (m⁴); `None` of a stiffness.
    pub fn geometry(&self) -> Option<[f64; 4]> {
        match *self {
            Self::Circle { radius } => {
                let second = PI / 4.0 * radius.powi(4);
                Some([PI * radius * radius, second, second, 2.0 * second])
            }
            Self::Tube { outer, inner } => {
                let second = PI / 4.0 * (outer.powi(4) - inner.powi(4));
                Some([PI * (outer * outer - inner * inner), second, second, 2.0 * second])
            }
            Self::Rectangle { width, height } => {
                let moments = [width * height.powi(3) / 12.0, height * width.powi(3) / 12.0];
                Some([width * height, moments[0], moments[1], rectangle_torsion(width, height)])
            }
            Self::Stiffness(_) => None,
        }
    }

    /// The part of the area that bears shear evenly, for Poisson's ratio; of a stiffness all of it.
    fn shear_correction(&self, poisson: f64) -> f64 {
        match *self {
            Self::Circle { .. } => OF_DISC,
            Self::Tube { outer, inner } => shear_of_ring(outer, inner, poisson),
            Self::Rectangle { .. } => OF_RECTANGLE,
            Self::Stiffness(_) => 1.0,
        }
    }

    /// Per length, of a material. A stiffness has neither mass nor rotary inertia.
    pub fn of(&self, material: Option<&Material>) -> RodSection {
        match (self, self.geometry(), material) {
            (Self::Stiffness(stiffness), _, _) => {
                RodSection { stiffness: *stiffness, mass: 0.0, rotary: Vector3::zeros() }
            }
            (_, Some([area, y, z, torsion]), Some(material)) => {
                let (e, g) = (material.young, material.young / (2.0 * (1.0 + material.poisson)));
                let sheared = self.shear_correction(material.poisson) * g * area;
                let diagonal = Vector6::new(e * area, sheared, sheared, g * torsion, e * y, e * z);
                let rotary = material.density * Vector3::new(y + z, y, z);
                RodSection { stiffness: Matrix6::from_diagonal(&diagonal), mass: material.density * area, rotary }
            }
            _ => RodSection { stiffness: Matrix6::zeros(), mass: 0.0, rotary: Vector3::zeros() },
        }
    }

    /// Between two sections of one kind: sizes are interpolated, and so is a stiffness.
    pub fn between(&self, other: &Self, part: f64) -> Option<Self> {
        let mix = |a: f64, b: f64| a + part * (b - a);
        match (*self, *other) {
            (Self::Circle { radius: a }, Self::Circle { radius: b }) => Some(Self::Circle { radius: mix(a, b) }),
            (Self::Tube { outer: a, inner: c }, Self::Tube { outer: b, inner: d }) => {
                Some(Self::Tube { outer: mix(a, b), inner: mix(c, d) })
            }
            (Self::Rectangle { width: a, height: c }, Self::Rectangle { width: b, height: d }) => {
                Some(Self::Rectangle { width: mix(a, b), height: mix(c, d) })
            }
            (Self::Stiffness(a), Self::Stiffness(b)) => Some(Self::Stiffness(a + part * (b - a))),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Cowper's values for Poisson's ratio 0.3: a disc, a tube of half its radius, a thin ring; and Timoshenko's 6/7 and 1/2 without
    /// contraction.
    #[test]
    fn shear_of_discs_and_tubes() {
        let of = |inner: f64, poisson: f64| shear_of_ring(1.0, inner, poisson);
        for (inner, poisson, known) in
            [(0.0, 0.3, 7.8 / 8.8), (0.5, 0.3, 0.6202), (1.0, 0.3, 2.6 / 4.9), (0.0, 0.0, 6.0 / 7.0), (1.0, 0.0, 0.5)]
        {
            assert!((of(inner, poisson) - known).abs() < 5e-5, "{} and not {known}", of(inner, poisson));
        }
    }

    /// Torsion constants of rectangles 1:1, 2:1 and 10:1 over a b³ (Timoshenko and Goodier, Theory of Elasticity, table 7).
    #[test]
    fn torsion_of_rectangles() {
        for (ratio, tabulated) in [(1.0, 0.1406), (2.0, 0.229), (10.0, 0.312)] {
            assert!((rectangle_torsion(ratio, 1.0) / ratio - tabulated).abs() < 5e-4);
            assert_eq!(rectangle_torsion(ratio, 1.0), rectangle_torsion(1.0, ratio));
        }
    }
}
