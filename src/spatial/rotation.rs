//! Rotation vectors: logarithm of a rotation and the map between its rate and the angular velocity.
//!
//! ```text
//! φ = log R,     φ̇ = G(φ) ω,     G(φ) = 1 + ½[φ]× + g(|φ|) [φ]×²      (ω in the axes that R leads from)
//! g(x) = 1/x² − (1 + cos x)/(2 x sin x)                                  Bullo & Murray 1995, eq. (2.7)
//! ```

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// The rotation vector of a unit quaternion, `|φ| ≤ π`; accurate for small angles.
pub fn rotation_vector(rotation: &UnitQuaternion<f64>) -> Vector3<f64> {
    let q = if rotation.w < 0.0 { -rotation.into_inner() } else { rotation.into_inner() };
    let v = q.imag();
    let s = v.norm();
    if s < 1e-9 {
        // log = 2 v/w + O(|v|³), below round-off here
        return v * (2.0 / q.w);
    }
    v * (2.0 * s.atan2(q.w) / s)
}

/// A torsion spring over a rotation: potential `½ φᵀ K φ − pᵀ φ` with `K = diag(stiffness)`, `p` its preload.
///
/// Both results are in the axes that the rotation leads from (the body's): the torque on the body, and the matrix
/// `∂torque/∂(turn of the body)`, exact for any angle below π.
pub fn torsion_spring(
    rotation: &UnitQuaternion<f64>,
    stiffness: Vector3<f64>,
    preload: Vector3<f64>,
) -> (Vector3<f64>, Matrix3<f64>) {
    let phi = rotation_vector(rotation);
    let y = stiffness.component_mul(&phi) - preload;
    let (g, dg_over_x) = series(phi.norm());
    let rate = rate_from_turn(&phi);
    // Gᵀ y = y − ½ φ×y + g φ×(φ×y), and its derivative with respect to φ
    let inner = phi.cross(&y);
    let outer = phi.cross(&inner);
    let torque = -(y - 0.5 * inner + g * outer);
    let by_phi = 0.5 * y.cross_matrix() + outer * (dg_over_x * phi).transpose()
        - g * (inner.cross_matrix() + phi.cross_matrix() * y.cross_matrix());
    let total = by_phi + rate.transpose() * Matrix3::from_diagonal(&stiffness);
    (torque, -total * rate)
}

/// `G(φ)`: the rate of the rotation vector from the angular velocity in the axes that the rotation leads from.
pub fn rate_from_turn(phi: &Vector3<f64>) -> Matrix3<f64> {
    let (g, _) = series(phi.norm());
    let cross = phi.cross_matrix();
    Matrix3::identity() + 0.5 * cross + g * cross * cross
}

/// `|B₂ₖ|/(2k)!` for k = 1…7: the Taylor coefficients of `g` in x².
const SERIES: [f64; 7] = [
    1.0 / 12.0,
    1.0 / 720.0,
    1.0 / 30_240.0,
    1.0 / 1_209_600.0,
    1.0 / 47_900_160.0,
    691.0 / 1_307_674_368_000.0,
    1.0 / 74_724_249_600.0,
];

/// `g(x)` and `g′(x)/x`; by Taylor series where the closed forms cancel.
fn series(x: f64) -> (f64, f64) {
    let x2 = x * x;
    if x < 0.5 {
        // The first term left out is below 2e-17 here.
        let g = SERIES.iter().rev().fold(0.0, |sum, c| sum * x2 + c);
        let dg = SERIES.iter().enumerate().skip(1).rev().fold(0.0, |sum, (k, c)| sum * x2 + 2.0 * k as f64 * c);
        return (g, dg);
    }
    let half = 0.5 * x;
    let cot = half.cos() / half.sin();
    let g = 1.0 / x2 - cot / (2.0 * x);
    let dg = -2.0 / (x2 * x) + cot / (2.0 * x2) + 1.0 / (4.0 * x * half.sin().powi(2));
    (g, dg / x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The tangent of the torsion spring is the derivative of its torque, at small and large angles.
    #[test]
    fn torsion_tangent_is_the_derivative_of_the_torque() {
        let (stiffness, preload) = (Vector3::new(3.0, 1.0, 0.5), Vector3::new(-0.7, 0.4, 1.1));
        for size in [1e-7, 0.1, 0.49, 0.51, 1.5, 3.0] {
            let rotation = UnitQuaternion::from_scaled_axis(size * Vector3::new(0.6, -0.64, 0.48));
            let (_, tangent) = torsion_spring(&rotation, stiffness, preload);
            for axis in 0..3 {
                let turned = |angle: f64| {
                    let turn = UnitQuaternion::from_scaled_axis(Vector3::ith(axis, angle));
                    torsion_spring(&(rotation * turn), stiffness, preload).0
                };
                // Central differences: error of order step² and round-off/step, both near 1e-10.
                let difference = (turned(1e-5) - turned(-1e-5)) / 2e-5;
                assert!((difference - tangent.column(axis)).norm() < 1e-8, "{size} {axis}");
            }
        }
    }
}
