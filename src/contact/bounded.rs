//! Forces whose size is bounded, of one support of the cone problem: dry friction of hinges.

use nalgebra::{Matrix3, Vector3};

/// Steps of Newton's method on the secular equation of bounded forces.
const MOST_SECULAR: usize = 60;

/// The force that holds, or the one at its bound that opposes what is left: `(A + κ) λ = −b`, `|λ| = bound`, with κ the root of the
/// secular equation; and whether it holds.
pub(super) fn bounded(a: &Matrix3<f64>, rate: &Vector3<f64>, bound: f64) -> (Vector3<f64>, bool) {
    let parts = a.symmetric_eigen();
    let along = parts.eigenvectors.tr_mul(rate);
    let cut = f64::EPSILON * parts.eigenvalues.amax();
    let parted = |shift: f64| {
        let part = |i: usize| if parts.eigenvalues[i] > cut { -along[i] / (parts.eigenvalues[i] + shift) } else { 0.0 };
        Vector3::from_fn(|i, _| part(i))
    };
    let hold = parted(0.0);
    if hold.norm() <= bound {
        return (parts.eigenvectors * hold, true);
    }
    if bound == 0.0 {
        return (Vector3::zeros(), false);
    }
    let mut shift = 0.0;
    for _ in 0..MOST_SECULAR {
        let force = parted(shift);
        let (size, slope) =
            (force.norm(), -(0..3).map(|i| force[i] * force[i] / (parts.eigenvalues[i].max(cut) + shift)).sum::<f64>());
        let step = (size / bound - 1.0) * size * size / -slope;
        shift += step;
        if !(step.abs() > f64::EPSILON * shift) {
            break;
        }
    }
    let force = parted(shift);
    (parts.eigenvectors * (force * (bound / force.norm())), false)
}
