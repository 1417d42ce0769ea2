//! Coefficients of collocation methods, computed instead of copied.
//!
//! A collocation method of `s` stages asks the polynomial of degree `s` that leaves the state `x` to satisfy the system
//! at the nodes `c_i`. With the Lagrange polynomials `ℓ_j` of the nodes
//!
//! ```text
//! (1)  X_i = x + h Σ_j a_ij k_j,   a_ij = ∫₀^{c_i} ℓ_j,   x' = x + h Σ_j b_j k_j,   b_j = ∫₀¹ ℓ_j
//! (2)  x(θ) = x + h Σ_j k_j ∫₀^θ ℓ_j                                                 between the ends
//! ```
//!
//! | nodes | zeros on (0, 1) of | order | |
//! |---|---|---|---|
//! | Gauss | `P_s` | 2s | symmetric: forwards and back ends at the start |
//! | Radau IIA | `P_s − P_{s−1}` | 2s − 1 | L-stable and stiffly accurate: `c_s = 1`, so that `X_s = x'` |
//!
//! with the Legendre polynomials `P` shifted to (0, 1). Both have stage order `s`: stages and (2) are of local order
//! `h^{s+1}`. Hairer, Wanner, *Solving ODEs II*, IV.5.

/// Intervals of (−1, 1) that are searched for a zero each. Up to ten stages the closest two zeros are three apart.
/// Odd: the zero in the middle is then at the end of none.
const INTERVALS: usize = 201;
/// Halvings that leave an interval as short as rounding.
const HALVINGS: usize = 60;

/// A method of `s` stages.
#[derive(Debug, Clone)]
pub(crate) struct Collocation {
    /// `c_i`, ascending.
    pub(crate) nodes: Vec<f64>,
    /// `a_ij`.
    pub(crate) rows: Vec<Vec<f64>>,
    /// `b_j`.
    pub(crate) weights: Vec<f64>,
    /// What (2) has beyond a line, in the nested form of `step/dense.rs`: weights of `r₂, …, r_s`.
    pub(crate) nested: Vec<Vec<f64>>,
}

impl Collocation {
    /// Gauss: order `2 stages`.
    pub(crate) fn gauss(stages: usize) -> Self {
        Self::new(gauss_nodes(stages))
    }

    /// Radau IIA: order `2 stages − 1`.
    pub(crate) fn radau(stages: usize) -> Self {
        let mut nodes = zeros(|x| {
            let (value, before) = legendre(stages, x);
            value - before
        });
        nodes.push(1.0);
        Self::new(nodes)
    }

    fn new(nodes: Vec<f64>) -> Self {
        let integral = |end: f64| -> Vec<f64> {
            (0..nodes.len()).map(|j| integrate(&nodes, end, |t| lagrange(&nodes, j, t))).collect()
        };
        let rows: Vec<Vec<f64>> = nodes.iter().map(|c| integral(*c)).collect();
        let weights = integral(1.0);
        let nested = nested_weights(&nodes, &weights);
        Self { nodes, rows, weights, nested }
    }

    /// Number of stages.
    pub(crate) fn stages(&self) -> usize {
        self.nodes.len()
    }

    /// `ℓ_j(t)`.
    pub(crate) fn lagrange(&self, j: usize, t: f64) -> f64 {
        lagrange(&self.nodes, j, t)
    }
}

/// `ℓ_j(t)` of the nodes.
fn lagrange(nodes: &[f64], j: usize, t: f64) -> f64 {
    let others = nodes.iter().enumerate().filter(|(i, _)| *i != j);
    others.map(|(_, c)| (t - c) / (nodes[j] - c)).product()
}

/// Legendre's `P_n(x)` and `P_{n−1}(x)` on (−1, 1), `n ≥ 1`.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut value, mut before) = (x, 1.0);
    for k in 2..=n {
        let k = k as f64;
        (value, before) = (((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k, value);
    }
    (value, before)
}

/// The zeros of `f` inside (−1, 1), ascending, shifted to (0, 1).
fn zeros(f: impl Fn(f64) -> f64) -> Vec<f64> {
    let end = |i: usize| 2.0 * (i as f64 + 0.5) / (INTERVALS as f64 + 1.0) - 1.0;
    let zero = |i: usize| {
        let (mut low, mut high) = (end(i), end(i + 1));
        if f(low) * f(high) > 0.0 {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if f(low) * f(middle) <= 0.0 { high = middle } else { low = middle }
        }
        Some(0.5 * (1.0 + high))
    };
    (0..INTERVALS).filter_map(zero).collect()
}

fn gauss_nodes(stages: usize) -> Vec<f64> {
    zeros(|x| legendre(stages, x).0)
}

/// `∫₀^end f` for a polynomial of a degree below that of the nodes' number, by the Gauss rule of as many points.
fn integrate(nodes: &[f64], end: f64, f: impl Fn(f64) -> f64) -> f64 {
    let weight = |c: f64| {
        let x = 2.0 * c - 1.0;
        let n = nodes.len();
        // (1 − x²) P'_n = n (P_{n−1} − x P_n), and P_n = 0: w = (1 − x²) / (n P_{n−1})² on an interval of length 1.
        (1.0 - x * x) / (n as f64 * legendre(n, x).1).powi(2)
    };
    gauss_nodes(nodes.len()).into_iter().map(|c| end * weight(c) * f(end * c)).sum()
}

/// The weights of `r₂, …, r_s` in `∫₀^θ ℓ_j = θ (r₁ + (1 − θ) (r₂ + θ (r₃ + …)))`, by division.
fn nested_weights(nodes: &[f64], weights: &[f64]) -> Vec<Vec<f64>> {
    let n = nodes.len();
    let mut nested = vec![vec![0.0; n]; n - 1];
    for j in 0..n {
        // ∫₀^θ ℓ_j / θ in powers of θ.
        let mut p = vec![1.0];
        for (_, c) in nodes.iter().enumerate().filter(|(i, _)| *i != j) {
            p.push(0.0);
            for k in (0..p.len()).rev() {
                let below = if k > 0 { p[k - 1] } else { 0.0 };
                p[k] = (below - c * p[k]) / (nodes[j] - c);
            }
        }
        p.iter_mut().enumerate().for_each(|(k, p)| *p /= (k + 1) as f64);
        p[0] -= weights[j];
        divide_by_rest(&mut p);
        for (m, row) in nested.iter_mut().enumerate() {
            if m % 2 == 0 {
                row[j] = p[0];
                p.remove(0);
            } else {
                row[j] = p.iter().sum();
                p[0] -= row[j];
                divide_by_rest(&mut p);
            }
        }
    }
    nested
}

/// `p ← p / (1 − θ)` for a polynomial that vanishes at 1.
fn divide_by_rest(p: &mut Vec<f64>) {
    let mut sum = 0.0;
    for p in p.iter_mut() {
        sum += *p;
        *p = sum;
    }
    p.pop();
}

#[cfg(test)]
mod tests {
    use super::*;

    const STAGES: std::ops::RangeInclusive<usize> = 2..=6;

    /// Sums of up to six terms below 1, of coefficients that are themselves rounded.
    const SUMS: f64 = 1e-14;

    fn moment(weights: &[f64], nodes: &[f64], power: i32) -> f64 {
        weights.iter().zip(nodes).map(|(w, c)| w * c.powi(power)).sum()
    }

    /// The simplifying assumptions `B(p)`: `Σ b c^{k−1} = 1/k` to order `p`, and no further.
    fn assert_weights(method: &Collocation, order: usize) {
        for k in 1..=order {
            let off = moment(&method.weights, &method.nodes, k as i32 - 1) - 1.0 / k as f64;
            assert!(off.abs() < SUMS, "{order}: B({k}) off by {off:e}");
        }
        let next = moment(&method.weights, &method.nodes, order as i32) - 1.0 / (order + 1) as f64;
        assert!(next.abs() > 1e-8, "{order}");
    }

    /// `C(s)`: `Σ a_ij c_j^{k−1} = c_i^k / k` to `s`. With `B(p)` it gives order `p ≤ 2s`: Hairer, Wanner, IV.5.
    fn assert_stages(method: &Collocation) {
        for (row, c) in method.rows.iter().zip(&method.nodes) {
            for k in 1..=method.stages() as i32 {
                let off = moment(row, &method.nodes, k - 1) - c.powi(k) / f64::from(k);
                assert!(off.abs() < SUMS, "C({k}) off by {off:e}");
            }
        }
    }

    #[test]
    fn gauss_has_order_2s_and_radau_2s_less_1() {
        for stages in STAGES {
            let (gauss, radau) = (Collocation::gauss(stages), Collocation::radau(stages));
            assert_eq!((gauss.stages(), radau.stages()), (stages, stages));
            assert_weights(&gauss, 2 * stages);
            assert_weights(&radau, 2 * stages - 1);
            assert_stages(&gauss);
            assert_stages(&radau);
            assert_eq!(radau.rows[stages - 1], radau.weights);
        }
    }

    #[test]
    fn tables_are_those_of_the_book() {
        let root = 6.0_f64.sqrt();
        // Hairer, Wanner, *Solving ODEs II*, IV.5, Table 5.6.
        let published = [
            [(88.0 - 7.0 * root) / 360.0, (296.0 - 169.0 * root) / 1800.0, (-2.0 + 3.0 * root) / 225.0],
            [(296.0 + 169.0 * root) / 1800.0, (88.0 + 7.0 * root) / 360.0, (-2.0 - 3.0 * root) / 225.0],
            [(16.0 - root) / 36.0, (16.0 + root) / 36.0, 1.0 / 9.0],
        ];
        let radau = Collocation::radau(3);
        for (row, published) in radau.rows.iter().zip(&published) {
            assert!(row.iter().zip(published).all(|(a, b)| (a - b).abs() < 1e-15), "{row:?}");
        }
        assert!((Collocation::gauss(2).nodes[0] - (0.5 - 3.0_f64.sqrt() / 6.0)).abs() < 1e-15);
    }

    #[test]
    fn the_nested_form_is_the_integral_of_the_interpolation() {
        for method in STAGES.flat_map(|s| [Collocation::gauss(s), Collocation::radau(s)]) {
            for theta in [0.1, 0.45, 0.8, 1.0] {
                for j in 0..method.stages() {
                    let mut value = 0.0;
                    for (m, row) in method.nested.iter().enumerate().rev() {
                        value = row[j] + if m % 2 == 0 { theta } else { 1.0 - theta } * value;
                    }
                    let nested = theta * (method.weights[j] + (1.0 - theta) * value);
                    let exact = integrate(&method.nodes, theta, |t| method.lagrange(j, t));
                    // The coefficients in powers of θ reach some thousands.
                    assert!((nested - exact).abs() < 1e-12, "{theta}: {nested} {exact}");
                }
            }
        }
    }
}
