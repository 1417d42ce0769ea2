//! How the coupled stages of a collocation method are taken apart: a lower triangular `L` in place of `A`.
//!
//! The iteration of `stages.rs` takes the rates with weights `L` anew and those with weights `A − L` from before. For `ẋ = λ x`,
//! `z = h λ`, it multiplies errors by
//!
//! ```text
//! G(z) = z (1 − z L)⁻¹ (A − L).
//! ```
//!
//! Any `L` does. Of equal diagonal entries `γ` all stages share one tangent, and two `L` of the same `γ` share it too: so
//! there are two, one for what the step resolves and one for stiff systems.
//! `γ` is such that `γ^s = det A`: then `1 − L⁻¹ A`, which is left for `z → −∞`, can be nilpotent, as with triangular factors
//! `A = L U` (P.J. van der Houwen, J.J.B. de Swart, *Triangularly implicit iteration methods for ODE-IVP solvers*, SIAM J. Sci.
//! Comput. 18, 1997). The other entries make the mean of `log ‖G³‖^{1/3}` least, as `docs/splitting.py` finds them,
//!
//! * at `z = iy`, `y = 0.3, 0.6, 1, 1.5, 2, 3, 4`;
//! * on rays through the left half plane, `|z| = 10 … 10⁴`. With five stages the minimum is flat: entries a tenth apart leave
//!   two thousandths more.
//!
//! | `‖G³‖^{1/3}` at | i, 2i, 4i | −1000 | | of `A = L U` | |
//! |---|---|---|---|---|---|
//! | Gauss, 3 stages | 0.07, 0.13, 0.27 | 0.06 | | 0.11, 0.20, 0.29 | 0.06 |
//! | Radau IIA, 3 stages | 0.11, 0.23, 0.43 | 0.08 | | 0.18, 0.30, 0.38 | 0.07 |
//! | Radau IIA, 5 stages | 0.08, 0.18, 0.40 | 0.32 | | 0.19, 0.34, 0.52 | 0.42 |

/// Two `L`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Splitting {
    /// All entries of their diagonals.
    pub(crate) diagonal: f64,
    /// The rows as far as the diagonal, for what the step resolves.
    pub(crate) smooth: &'static [&'static [f64]],
    /// The rows as far as the diagonal, for stiff systems.
    pub(crate) stiff: &'static [&'static [f64]],
}

/// Of Gauss with three stages.
pub(crate) const GAUSS_3: Splitting = Splitting {
    diagonal: 0.202740,
    smooth: &[&[], &[0.2793], &[0.2805, 0.4696]],
    stiff: &[&[], &[0.2814], &[0.0380, 0.3379]],
};

/// Of Radau IIA with three stages.
pub(crate) const RADAU_3: Splitting = Splitting {
    diagonal: 0.255436,
    smooth: &[&[], &[0.4790], &[0.5401, 0.2790]],
    stiff: &[&[], &[0.3451], &[0.1620, 0.3220]],
};

/// Of Radau IIA with five stages.
pub(crate) const RADAU_5: Splitting = Splitting {
    diagonal: 0.145912,
    smooth: &[&[], &[0.1410], &[0.1432, 0.2907], &[0.1476, 0.2127, 0.4001], &[0.1388, 0.1414, 0.6945, 0.0332]],
    stiff: &[&[], &[0.0749], &[0.1445, 0.2760], &[0.1499, 0.1418, 0.2322], &[-0.1979, 0.0003, 0.2880, 0.0707]],
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrate::implicit::collocation::Collocation;

    type Complex = [f64; 2];

    fn times([a, b]: Complex, [c, d]: Complex) -> Complex {
        [a * c - b * d, a * d + b * c]
    }

    fn over(x: Complex, [c, d]: Complex) -> Complex {
        times(x, [c, -d]).map(|part| part / (c * c + d * d))
    }

    /// `e ← G(z) e`.
    fn sweep(method: &Collocation, diagonal: f64, below: &[&[f64]], z: Complex, e: &mut [Complex]) {
        let old = e.to_vec();
        for (i, row) in method.rows.iter().enumerate() {
            let mut sum = [0.0; 2];
            for (j, a) in row.iter().enumerate() {
                let l = below[i].get(j).copied().unwrap_or(if i == j { diagonal } else { 0.0 });
                let new = if j < i { l } else { 0.0 };
                for part in 0..2 {
                    sum[part] += (a - l) * old[j][part] + new * e[j][part];
                }
            }
            e[i] = over(times(z, sum), [1.0 - diagonal * z[0], -diagonal * z[1]]);
        }
    }

    /// `‖Gᵏ(z)‖^{1/k}` in the Frobenius norm.
    fn left(method: &Collocation, (diagonal, below): (f64, &[&[f64]]), z: Complex, k: i32) -> f64 {
        let s = method.stages();
        let mut sum = 0.0;
        for j in 0..s {
            let mut e = vec![[0.0; 2]; s];
            e[j] = [1.0, 0.0];
            (0..k).for_each(|_| sweep(method, diagonal, below, z, &mut e));
            sum += e.iter().flatten().map(|part| part * part).sum::<f64>();
        }
        sum.powf(0.5 / f64::from(k))
    }

    /// The largest spectral radius in the left half plane, on rays: the factor of one of many sweeps.
    fn radius(method: &Collocation, rows: (f64, &[&[f64]])) -> f64 {
        let angles = [90.0_f64, 100.0, 120.0, 135.0, 150.0, 180.0].map(f64::to_radians);
        let at = |angle: f64, i: i32| [angle.cos(), angle.sin()].map(|part| 0.1 * 1.25_f64.powi(i) * part);
        let points = angles.into_iter().flat_map(|angle| (0..60).map(move |i| at(angle, i)));
        points.map(|z| left(method, rows, z, 200)).fold(0.0, f64::max)
    }

    #[test]
    fn what_steps_resolve_converges_fast_by_one_of_two_and_what_is_stiff_by_the_other() {
        let (gauss, three, five) = (Collocation::gauss(3), Collocation::radau(3), Collocation::radau(5));
        // The table above, and bounds on the radius, with what 200 sweeps show of a matrix that is not normal.
        let methods = [
            (&gauss, GAUSS_3, [0.07, 0.14, 0.27, 0.07], [0.30, 0.30]),
            (&three, RADAU_3, [0.11, 0.23, 0.43, 0.09], [0.39, 0.34]),
            (&five, RADAU_5, [0.085, 0.18, 0.40, 0.33], [0.67, 0.58]),
        ];
        for (method, Splitting { diagonal, smooth, stiff }, errors, radii) in methods {
            for (y, error) in [1.0, 2.0, 4.0].into_iter().zip(errors) {
                let left = left(method, (diagonal, smooth), [0.0, y], 3);
                assert!(left < error, "{y}: {left}");
            }
            assert!(left(method, (diagonal, stiff), [-1000.0, 0.0], 3) < errors[3]);
            for (rows, bound) in [smooth, stiff].into_iter().zip(radii) {
                let radius = radius(method, (diagonal, rows));
                assert!(radius < bound, "{radius}");
            }
        }
    }
}
