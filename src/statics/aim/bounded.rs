//! The step of an aim: Gauss and Newton's within a radius and within bounds.
//!
//! ```text
//! least |J s + r|² + μ² |s|²,     |s| ≤ Δ,   s ≥ low         of all such steps with μ = 0 the shortest
//! ```
//!
//! `μ` is what makes the step as long as the radius where Newton's is longer (Levenberg 1944, Marquardt 1963; Nocedal & Wright,
//! *Numerical Optimization*, 10.3). Numbers whose part of the step passes their bound are held at it, one after the other, and the rest is
//! solved for again (an active set, as in Stark & Parker's bounded least squares, 1995): a step begins with none held, so a number leaves
//! its bound where that is of use.

use faer::Mat;

/// Bisections for `μ`, which leave it to 1e-9 of itself.
const BISECTIONS: usize = 60;
/// The radius is met to this part.
const NEAR: f64 = 1e-3;

/// A step, and what it promises.
pub(super) struct Step {
    /// `s`
    pub s: Vec<f64>,
    /// `|J s + r|`
    pub left: f64,
    /// `|J s|`
    pub moves: f64,
    /// Numbers that are held at their bound.
    pub held: Vec<usize>,
}

/// The step from residuals `r` with slopes `J`; singular values below `rank` of the largest count as zero. `None` if the slopes are
/// not finite.
pub(super) fn step(slopes: &Mat<f64>, r: &[f64], low: &[f64], radius: f64, rank: f64) -> Option<Step> {
    let count = slopes.ncols();
    let (mut s, mut held) = (vec![0.0; count], Vec::new());
    loop {
        let free: Vec<usize> = (0..count).filter(|j| !held.contains(j)).collect();
        let fixed = |i: usize| held.iter().map(|j: &usize| slopes[(i, *j)] * s[*j]).sum::<f64>();
        let rest: Vec<f64> = r.iter().enumerate().map(|(i, r)| r + fixed(i)).collect();
        let of_held = held.iter().map(|j| s[*j] * s[*j]).sum::<f64>();
        let part = Mat::from_fn(slopes.nrows(), free.len(), |i, k| slopes[(i, free[k])]);
        let left_radius = (radius * radius - of_held).max(0.0).sqrt();
        let along = within(&part, &rest, left_radius, rank)?;
        free.iter().zip(&along).for_each(|(j, x)| s[*j] = *x);
        // What passes its bound by most, of the distance to it.
        let passes = |j: &usize| s[*j] < low[*j];
        let by = |j: usize| s[j] / low[j].min(-f64::MIN_POSITIVE);
        let Some(worst) = free.iter().copied().filter(passes).max_by(|a, b| by(*a).total_cmp(&by(*b))) else { break };
        s[worst] = low[worst];
        held.push(worst);
    }
    let change = |i: usize| (0..count).map(|j| slopes[(i, j)] * s[j]).sum::<f64>();
    let left = (0..r.len()).map(|i| (r[i] + change(i)).powi(2)).sum::<f64>().sqrt();
    let moves = (0..r.len()).map(|i| change(i).powi(2)).sum::<f64>().sqrt();
    Some(Step { s, left, moves, held })
}

/// The step without bounds.
fn within(slopes: &Mat<f64>, r: &[f64], radius: f64, rank: f64) -> Option<Vec<f64>> {
    let count = slopes.ncols();
    if count == 0 {
        return Some(Vec::new());
    }
    let svd = slopes.thin_svd().ok()?;
    let (u, sigma, v) = (svd.U(), svd.S(), svd.V());
    let kept = (0..sigma.dim()).take_while(|k| sigma[*k] > rank * sigma[0]).count();
    let along: Vec<f64> = (0..kept).map(|k| (0..r.len()).map(|i| u[(i, k)] * r[i]).sum()).collect();
    let parts =
        |mu: f64| -> Vec<f64> { (0..kept).map(|k| -along[k] * sigma[k] / (sigma[k] * sigma[k] + mu * mu)).collect() };
    let length = |parts: &[f64]| parts.iter().map(|x| x * x).sum::<f64>().sqrt();
    let mut chosen = parts(0.0);
    if length(&chosen) > radius {
        let (mut low, mut high) = (0.0_f64, sigma[0]);
        while length(&parts(high)) > radius && high < 1e30 * sigma[0] {
            (low, high) = (high, 8.0 * high);
        }
        for _ in 0..BISECTIONS {
            // Values of μ are of many sizes.
            let between = if low > 0.0 { (low * high).sqrt() } else { high / 8.0 };
            let long = length(&parts(between));
            if long > radius {
                low = between
            } else {
                high = between
            }
            if (1.0 - NEAR..=1.0).contains(&(long / radius)) {
                break;
            }
        }
        chosen = parts(high);
    }
    Some((0..count).map(|j| (0..kept).map(|k| v[(j, k)] * chosen[k]).sum()).collect())
}
