//! Coefficients of the methods, with their sources.
//!
//! ```text
//! X_i = x + h Σ_j A_ij k_j,   k_i = f(t + C_i h, X_i),   x' = x + h Σ_i B_i k_i,   e = h Σ_i E_i k_i
//! ```

/// Classical Runge–Kutta, order 4: Hairer, Nørsett, Wanner, *Solving ODEs I*, II.1, Table 1.2.
pub(crate) mod rk4 {
    pub(crate) const C: [f64; 4] = [0.0, 0.5, 0.5, 1.0];
    pub(crate) const A: [&[f64]; 4] = [&[], &[0.5], &[0.0, 0.5], &[0.0, 0.0, 1.0]];
    pub(crate) const B: [f64; 4] = [1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0];
}

/// Dormand–Prince 5(4): Hairer, Nørsett, Wanner, *Solving ODEs I*, II.5, Table 5.2; `DENSE` is the highest coefficient
/// of the continuous extension, II.6, in the nested form of `step/dense.rs`.
#[rustfmt::skip]
pub(crate) mod dopri5 {
    pub(crate) const C: [f64; 7] = [0.0, 1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];
    /// The last row is the step itself: the seventh stage is the first of the next step.
    pub(crate) const A: [&[f64]; 7] = [
        &[],
        &[1.0 / 5.0],
        &[3.0 / 40.0, 9.0 / 40.0],
        &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
        &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
        &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
        &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
    ];
    pub(crate) const E: [f64; 7] = [
        71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0,
    ];
    pub(crate) const DENSE: [f64; 7] = [
        -12715105075.0 / 11282082432.0, 0.0, 87487479700.0 / 32700410799.0, -10690763975.0 / 1880347072.0,
        701980252875.0 / 199316789632.0, -1453857185.0 / 822651844.0, 69997945.0 / 29380423.0,
    ];
}

pub(crate) mod dop853;

/// L-stable, stiffly accurate SDIRK 4(3) with γ = 1/4: Hairer, Wanner, *Solving ODEs II*, IV.6, Table 6.5.
///
/// The diagonal `GAMMA` is not listed in `A`.
#[rustfmt::skip]
pub(crate) mod sdirk4 {
    pub(crate) const GAMMA: f64 = 0.25;
    pub(crate) const C: [f64; 5] = [1.0 / 4.0, 3.0 / 4.0, 11.0 / 20.0, 1.0 / 2.0, 1.0];
    /// The last row, with `GAMMA`, is the step itself.
    pub(crate) const A: [&[f64]; 5] = [
        &[],
        &[1.0 / 2.0],
        &[17.0 / 50.0, -1.0 / 25.0],
        &[371.0 / 1360.0, -137.0 / 2720.0, 15.0 / 544.0],
        &[25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0],
    ];
    /// That row, `GAMMA` included: the weights of the step.
    pub(crate) const B: [f64; 5] = [25.0 / 24.0, -49.0 / 48.0, 125.0 / 16.0, -85.0 / 12.0, GAMMA];
    /// The step less the embedded rule `(59/48, −17/96, 225/32, −85/12, 0)` of order 3.
    pub(crate) const E: [f64; 5] = [-3.0 / 16.0, -27.0 / 32.0, 25.0 / 32.0, 0.0, 1.0 / 4.0];
    /// Weights `b_i(θ) = … + θ² SQUARES_i + θ³ CUBES_i` of the continuous extension.
    ///
    /// No weights of five stages satisfy the eight conditions of order 4 for all θ; the four of order 3 leave `b_5(θ)`
    /// free. `b_5 = θ² (2θ − 1) / 4` makes the extension end with the slope `k_5`.
    pub(crate) const SQUARES: [f64; 5] = [-19.0 / 8.0, -93.0 / 16.0, 475.0 / 16.0, -85.0 / 4.0, -1.0 / 4.0];
    /// See [`SQUARES`].
    pub(crate) const CUBES: [f64; 5] = [2.0 / 3.0, 41.0 / 12.0, -75.0 / 4.0, 85.0 / 6.0, 1.0 / 2.0];
    /// The linear terms follow from the two others; only the test of the order conditions needs them.
    #[cfg(test)]
    pub(crate) const LINEAR: [f64; 5] = [11.0 / 4.0, 11.0 / 8.0, -25.0 / 8.0, 0.0, 0.0];
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A rooted tree of the order conditions of Hairer, Nørsett, Wanner, *Solving ODEs I*, II.2.
    struct Tree {
        order: u32,
        gamma: f64,
        /// `Φ_i` of every stage.
        phi: Vec<f64>,
    }

    /// All trees up to `order` for a method with these rows. A tree is a root and a multiset of trees on it, listed here
    /// with indices that do not rise.
    fn trees(rows: &[Vec<f64>], order: u32) -> Vec<Tree> {
        let mut all: Vec<Tree> = Vec::new();
        for order in 1..=order {
            let mut found = Vec::new();
            let bare = Tree { order: 1, gamma: f64::from(order), phi: vec![1.0; rows.len()] };
            graft(rows, &all, all.len(), bare, order, &mut found);
            all.append(&mut found);
        }
        all
    }

    /// Grafts trees of `all` before `end` onto `tree`, in every way that gives `order`.
    fn graft(rows: &[Vec<f64>], all: &[Tree], end: usize, tree: Tree, order: u32, found: &mut Vec<Tree>) {
        if tree.order == order {
            found.push(tree);
            return;
        }
        for (index, branch) in all[..end].iter().enumerate().filter(|(_, branch)| tree.order + branch.order <= order) {
            let phi = rows.iter().zip(&tree.phi).map(|(row, phi)| phi * dot(row, &branch.phi)).collect();
            let grown = Tree { order: tree.order + branch.order, gamma: tree.gamma * branch.gamma, phi };
            graft(rows, all, index + 1, grown, order, found);
        }
    }

    /// Order and defect of every condition up to `order`, for the weights `b` at the part `theta` of the step.
    fn defects(rows: &[Vec<f64>], b: &[f64], theta: f64, order: u32) -> Vec<(u32, f64)> {
        let defect = |tree: &Tree| (tree.order, dot(b, &tree.phi) - theta.powi(tree.order as i32) / tree.gamma);
        trees(rows, order).iter().map(defect).collect()
    }

    fn dot(x: &[f64], y: &[f64]) -> f64 {
        x.iter().zip(y).map(|(x, y)| x * y).sum()
    }

    /// Square rows from the strictly lower ones and the diagonal.
    fn full(rows: &[&[f64]], diagonal: f64) -> Vec<Vec<f64>> {
        let fill = |(i, row): (usize, &&[f64])| {
            let mut full = row.to_vec();
            full.push(diagonal);
            full.resize(rows.len(), 0.0);
            assert!(row.len() <= i);
            full
        };
        rows.iter().enumerate().map(fill).collect()
    }

    /// All conditions up to `order` hold to rounding: sums of a dozen terms up to 20.
    fn assert_order(order: u32, rows: &[Vec<f64>], b: &[f64], theta: f64) {
        for (of, defect) in defects(rows, b, theta, order) {
            assert!(defect.abs() < 1e-13, "condition of order {of} off by {defect:e}");
        }
    }

    /// Some condition of `order` is missed by more than `least`.
    fn misses(order: u32, rows: &[Vec<f64>], b: &[f64], least: f64) -> bool {
        defects(rows, b, 1.0, order).iter().any(|(of, defect)| *of == order && defect.abs() > least)
    }

    #[test]
    fn there_are_as_many_trees_as_the_book_says() {
        // Hairer, Nørsett, Wanner, *Solving ODEs I*, II.2, Table 2.1.
        let trees = trees(&[vec![0.0]], 8);
        let count = |order| trees.iter().filter(|tree| tree.order == order).count();
        assert_eq!((1..=8).map(count).collect::<Vec<_>>(), [1, 1, 2, 4, 9, 20, 48, 115]);
    }

    fn minus(b: &[f64], e: &[f64]) -> Vec<f64> {
        b.iter().zip(e).map(|(b, e)| b - e).collect()
    }

    #[test]
    fn rk4_has_order_4() {
        assert_order(4, &full(&rk4::A, 0.0), &rk4::B, 1.0);
    }

    #[test]
    fn dopri5_has_order_5_and_its_estimate_order_4() {
        let rows = full(&dopri5::A, 0.0);
        let step = rows[6].clone();
        assert_order(5, &rows, &step, 1.0);
        let embedded = minus(&step, &dopri5::E);
        assert_order(4, &rows, &embedded, 1.0);
        assert!(misses(5, &rows, &embedded, 1e-4) && misses(6, &rows, &step, 1e-4));
    }

    #[test]
    fn dopri5_between_its_ends_has_order_4() {
        let rows = full(&dopri5::A, 0.0);
        for theta in [0.2, 0.5, 0.9] {
            // The nested form of `step/dense.rs` with r₁ = h Σ b k, r₂ = h k₁ − r₁, r₃ = r₁ − h k₇ − r₂.
            let weight = |i: usize| {
                let r1 = rows[6][i];
                let r2 = f64::from(u8::from(i == 0)) - r1;
                let r3 = r1 - f64::from(u8::from(i == 6)) - r2;
                theta * (r1 + (1.0 - theta) * (r2 + theta * (r3 + (1.0 - theta) * dopri5::DENSE[i])))
            };
            let weights: Vec<f64> = (0..7).map(weight).collect();
            assert_order(4, &rows, &weights, theta);
        }
    }

    #[test]
    fn dop853_has_order_8_and_its_estimates_orders_5_and_3() {
        let rows = full(&dop853::A, 0.0);
        let step = rows[12].clone();
        let padded = |short: &[f64]| [short, &[0.0; 4]].concat();
        let (better, poorer) = (minus(&step, &padded(&dop853::E5)), minus(&step, &padded(&dop853::E3)));
        assert_order(8, &rows, &step, 1.0);
        assert_order(5, &rows, &better, 1.0);
        assert_order(3, &rows, &poorer, 1.0);
        assert!(misses(9, &rows, &step, 1e-8) && misses(6, &rows, &better, 1e-5) && misses(4, &rows, &poorer, 1e-4));
        for (row, c) in rows.iter().zip(dop853::C) {
            assert!((row.iter().sum::<f64>() - c).abs() < 1e-14);
        }
    }

    #[test]
    fn dop853_between_its_ends_has_order_7() {
        let rows = full(&dop853::A, 0.0);
        for theta in [0.2, 0.5, 0.9] {
            // The nested form of `step/dense.rs`, as above.
            let weight = |i: usize| {
                let r1 = rows[12][i];
                let r2 = f64::from(u8::from(i == 0)) - r1;
                let r3 = r1 - f64::from(u8::from(i == 12)) - r2;
                let [r4, r5, r6, r7] = dop853::DENSE.map(|row| row[i]);
                let rest = 1.0 - theta;
                let high = r4 + theta * (r5 + rest * (r6 + theta * r7));
                theta * (r1 + rest * (r2 + theta * (r3 + rest * high)))
            };
            let weights: Vec<f64> = (0..16).map(weight).collect();
            assert_order(7, &rows, &weights, theta);
        }
    }

    #[test]
    fn sdirk4_has_order_4_and_its_estimate_order_3() {
        let rows = full(&sdirk4::A, sdirk4::GAMMA);
        let step = rows[4].clone();
        assert_eq!(step, sdirk4::B);
        let embedded = minus(&step, &sdirk4::E);
        assert_order(4, &rows, &step, 1.0);
        assert_order(3, &rows, &embedded, 1.0);
        assert!(misses(4, &rows, &embedded, 1e-3));
        let published = [59.0 / 48.0, -17.0 / 96.0, 225.0 / 32.0, -85.0 / 12.0, 0.0];
        assert!(minus(&embedded, &published).iter().all(|off| off.abs() < 1e-14));
    }

    #[test]
    fn sdirk4_stages_lie_where_the_table_says() {
        for (row, c) in full(&sdirk4::A, sdirk4::GAMMA).iter().zip(sdirk4::C) {
            assert!((row.iter().sum::<f64>() - c).abs() < 1e-14);
        }
    }

    #[test]
    fn sdirk4_between_its_ends_has_order_3_and_ends_with_the_last_slope() {
        let rows = full(&sdirk4::A, sdirk4::GAMMA);
        let (linear, squares, cubes) = (sdirk4::LINEAR, sdirk4::SQUARES, sdirk4::CUBES);
        for theta in [0.2_f64, 0.5, 0.9, 1.0] {
            let weight = |i: usize| theta * (linear[i] + theta * (squares[i] + theta * cubes[i]));
            let weights: Vec<f64> = (0..5).map(weight).collect();
            assert_order(3, &rows, &weights, theta);
        }
        for i in 0..5 {
            let slope = linear[i] + 2.0 * squares[i] + 3.0 * cubes[i];
            assert!((slope - f64::from(u8::from(i == 4))).abs() < 1e-13);
        }
    }
}
