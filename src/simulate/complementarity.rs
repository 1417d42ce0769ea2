//! Rows that push and never pull: Signorini's condition between the rates of some rows and their multipliers,
//!
//! ```text
//! (1)  0 ≤ λ ⊥ w = A λ + b ≥ 0,   A = H M⁻¹ Hᵀ  positive semidefinite
//! ```
//!
//! a linear complementarity problem, and the optimality condition of min ½ λᵀ A λ + bᵀ λ, λ ≥ 0. It is solved by the active
//! set method of Lawson and Hanson (*Solving Least Squares Problems*, 1974, ch. 23), which keeps the active rows linearly
//! independent: a row that depends on the active ones replaces one of them, if that can be. A row that cannot enter now may
//! do so once the active set is another one.

/// A pivot below this part of a row's own entry without loops, drives and gears counts as zero.
const DEPENDENT: f64 = 1e-9;

/// The problem (1).
#[derive(Debug, Clone)]
pub(super) struct Problem<'a> {
    /// `A` by rows.
    pub(super) matrix: &'a [f64],
    /// The diagonal of `A` without loops, drives and gears, > 0: what pivots are compared with.
    pub(super) free: &'a [f64],
    /// `b`.
    pub(super) rates: &'a [f64],
    /// A rate above −tolerance counts as ≥ 0, per row.
    pub(super) tolerances: &'a [f64],
}

/// A solution, as far as there is one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Solution {
    /// `λ`.
    pub(super) multipliers: Vec<f64>,
    /// Rows that push; they are linearly independent.
    pub(super) active: Vec<bool>,
    /// `w`.
    pub(super) rates: Vec<f64>,
    /// Rows with `w` below −tolerance: no multipliers satisfy them.
    pub(super) violated: Vec<bool>,
}

impl Problem<'_> {
    /// Solves (1). Rows that cannot be satisfied show in the rates.
    pub(super) fn solve(&self) -> Solution {
        let n = self.rates.len();
        let mut state = Solution {
            multipliers: vec![0.0; n],
            active: vec![false; n],
            rates: self.rates.to_vec(),
            violated: vec![false; n],
        };
        if self.all_at_once(&mut state) {
            return state;
        }
        let mut unreachable = vec![false; n];
        // Each round lowers the objective; the bound is for rounding.
        for _ in 0..20 * (n + 1) {
            state.rates = self.rates_of(&state.multipliers);
            let worst = |row: usize| state.rates[row] / self.free[row].sqrt();
            let open = (0..n)
                .filter(|row| !state.active[*row] && !unreachable[*row] && state.rates[*row] < -self.tolerances[*row]);
            let Some(row) = open.min_by(|a, b| worst(*a).total_cmp(&worst(*b))) else { break };
            match self.enter(&mut state, row) {
                true => unreachable.fill(false),
                false => unreachable[row] = true,
            }
        }
        state.rates = self.rates_of(&state.multipliers);
        state.violated = (0..n).map(|row| !state.active[row] && state.rates[row] < -self.tolerances[row]).collect();
        state
    }

    /// The usual case: all rows that are violated push.
    fn all_at_once(&self, state: &mut Solution) -> bool {
        let rows: Vec<usize> = (0..self.rates.len()).filter(|row| self.rates[*row] < -self.tolerances[*row]).collect();
        let Some(multipliers) = self.stationary(&rows) else { return false };
        if multipliers.iter().any(|multiplier| !(*multiplier > 0.0)) {
            return false;
        }
        let mut all = vec![0.0; self.rates.len()];
        rows.iter().zip(&multipliers).for_each(|(row, multiplier)| all[*row] = *multiplier);
        let rates = self.rates_of(&all);
        let satisfied = rates.iter().zip(self.tolerances).all(|(rate, tolerance)| *rate >= -tolerance);
        if satisfied {
            rows.iter().for_each(|row| state.active[*row] = true);
            (state.multipliers, state.rates) = (all, rates);
        }
        satisfied
    }

    /// Takes a row among the active ones; false if that leaves the active set as it is: no multiplier of the row helps.
    fn enter(&self, state: &mut Solution, row: usize) -> bool {
        let (active, before) = (state.rows(), state.active.clone());
        let Some(combination) = self.combine(&active, row) else { return false };
        let pivot = self.entry(row, row)
            - active.iter().zip(&combination).map(|(other, c)| self.entry(row, *other) * c).sum::<f64>();
        if pivot <= DEPENDENT * self.free[row] {
            // λ + t (e_row − combination) changes no rate: as far as the active rows allow it.
            let steps = active.iter().zip(&combination).filter(|(_, c)| **c > DEPENDENT);
            let steps = steps.map(|(other, c)| (state.multipliers[*other] / c, *other));
            let Some((step, leaving)) = steps.min_by(|a, b| a.0.total_cmp(&b.0)) else { return false };
            for (other, c) in active.iter().zip(&combination) {
                state.multipliers[*other] -= step * c;
            }
            (state.multipliers[row], state.multipliers[leaving]) = (step, 0.0);
            state.active[leaving] = false;
        }
        state.active[row] = true;
        self.descend(state);
        state.active != before
    }

    /// To the stationary point of the active rows, or to where multipliers vanish on the way; those rows leave.
    fn descend(&self, state: &mut Solution) {
        loop {
            let active = state.rows();
            let Some(target) = self.stationary(&active) else { return };
            let step_of = |at: usize| {
                let (from, to) = (state.multipliers[active[at]], target[at]);
                if to > 0.0 { f64::INFINITY } else { from / (from - to).max(f64::MIN_POSITIVE) }
            };
            let first = (0..active.len()).min_by(|a, b| step_of(*a).total_cmp(&step_of(*b)));
            let Some(first) = first else { return };
            let step = step_of(first).min(1.0);
            for (row, to) in active.iter().zip(&target) {
                state.multipliers[*row] += step * (to - state.multipliers[*row]);
            }
            if target.iter().all(|to| *to > 0.0) {
                return;
            }
            state.multipliers[active[first]] = 0.0;
            state.active[active[first]] = false;
        }
    }

    fn entry(&self, row: usize, column: usize) -> f64 {
        self.matrix[row * self.rates.len() + column]
    }

    /// `A λ + b`.
    fn rates_of(&self, multipliers: &[f64]) -> Vec<f64> {
        let n = multipliers.len();
        let product = |row: usize| self.matrix[row * n..(row + 1) * n].iter().zip(multipliers).map(|(a, x)| a * x);
        (0..n).map(|row| self.rates[row] + product(row).sum::<f64>()).collect()
    }

    /// The multipliers with which the rates of these rows vanish; `None` if the rows are linearly dependent.
    pub(super) fn stationary(&self, rows: &[usize]) -> Option<Vec<f64>> {
        self.solve_among(rows, rows.iter().map(|row| -self.rates[*row]).collect())
    }

    /// Coefficients of a row as a combination of others, in the metric `A`.
    fn combine(&self, rows: &[usize], row: usize) -> Option<Vec<f64>> {
        self.solve_among(rows, rows.iter().map(|other| self.entry(*other, row)).collect())
    }

    /// Gaussian elimination; `A` is positive definite among independent rows, so that pivots need no search.
    fn solve_among(&self, rows: &[usize], mut x: Vec<f64>) -> Option<Vec<f64>> {
        let n = rows.len();
        let mut a: Vec<f64> = rows.iter().flat_map(|i| rows.iter().map(|j| self.entry(*i, *j))).collect();
        for k in 0..n {
            if !(a[k * n + k] > 0.1 * DEPENDENT * self.free[rows[k]]) {
                return None;
            }
            for i in k + 1..n {
                let factor = a[i * n + k] / a[k * n + k];
                if factor != 0.0 {
                    (k..n).for_each(|j| a[i * n + j] -= factor * a[k * n + j]);
                    x[i] -= factor * x[k];
                }
            }
        }
        for k in (0..n).rev() {
            let known: f64 = (k + 1..n).map(|j| a[k * n + j] * x[j]).sum();
            x[k] = (x[k] - known) / a[k * n + k];
        }
        Some(x)
    }
}

impl Solution {
    fn rows(&self) -> Vec<usize> {
        (0..self.active.len()).filter(|row| self.active[*row]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers without a pattern in −1…1, the same in every run (xorshift).
    fn next(state: &mut u64) -> f64 {
        *state ^= *state << 13;
        *state ^= *state >> 7;
        *state ^= *state << 17;
        (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// `A = B Bᵀ` of any rank with rates that some impulse can answer: all conditions of (1) hold at the solution.
    #[test]
    fn random_problems_of_any_rank_are_solved() {
        let mut seed = 0x9e37_79b9_7f4a_7c15;
        for case in 0..2000 {
            let (n, rank) = (1 + case % 9, 1 + (case / 9) % 9);
            let b: Vec<f64> = (0..n * rank).map(|_| next(&mut seed)).collect();
            let speed: Vec<f64> = (0..rank).map(|_| next(&mut seed)).collect();
            let dot = |i: usize, x: &[f64]| (0..rank).map(|k| b[i * rank + k] * x[k]).sum::<f64>();
            let matrix: Vec<f64> = (0..n * n).map(|at| dot(at / n, &b[at % n * rank..at % n * rank + rank])).collect();
            let free: Vec<f64> = (0..n).map(|i| matrix[i * n + i]).collect();
            // Approaching rows with one coefficient of restitution: answered by an impulse of all other rows together.
            let rates: Vec<f64> = (0..n).map(|i| 1.5 * dot(i, &speed)).collect();
            let tolerances = vec![1e-10; n];
            let found = Problem { matrix: &matrix, free: &free, rates: &rates, tolerances: &tolerances }.solve();
            for i in 0..n {
                assert!(found.multipliers[i] >= 0.0, "case {case}: {found:?}");
                assert!(found.rates[i] >= -1e-8, "case {case}: {found:?}");
                assert!((found.multipliers[i] * found.rates[i]).abs() < 1e-6, "case {case}: {found:?}");
                assert!(found.active[i] || found.multipliers[i] == 0.0, "case {case}: {found:?}");
            }
        }
    }

    /// The rates of (1) by trying all sets of active rows, which are unique; `None` if there is no solution.
    fn by_enumeration(matrix: &[f64], rates: &[f64]) -> Option<Vec<f64>> {
        let n = rates.len();
        (0..1_usize << n).find_map(|set| {
            let rows: Vec<usize> = (0..n).filter(|row| set >> row & 1 == 1).collect();
            let a = nalgebra::DMatrix::from_fn(rows.len(), rows.len(), |i, j| matrix[rows[i] * n + rows[j]]);
            let b = nalgebra::DVector::from_iterator(rows.len(), rows.iter().map(|row| -rates[*row]));
            let regular = |factor: &nalgebra::Cholesky<f64, nalgebra::Dyn>| factor.l().diagonal().min() > 1e-5;
            let multipliers = if rows.is_empty() { b } else { a.cholesky().filter(regular)?.solve(&b) };
            let w =
                |i: usize| rates[i] + rows.iter().zip(&multipliers).map(|(j, x)| matrix[i * n + j] * x).sum::<f64>();
            let w: Vec<f64> = (0..n).map(w).collect();
            let is_solution = multipliers.iter().all(|x| *x >= -1e-9) && w.iter().all(|w| *w >= -1e-9);
            is_solution.then_some(w)
        })
    }

    /// Small integers: rows that are multiples and sums of others, rows of zeros, multipliers of zero. Rates are unique also
    /// where multipliers are not; a problem without a solution is said to be one.
    #[test]
    fn degenerate_problems_have_the_rates_that_enumeration_finds() {
        let (mut seed, mut unsolvable) = (0x2545_f491_4f6c_dd1d, 0);
        let mut whole = |size: f64| (size * next(&mut seed)).round();
        for case in 0..6000 {
            let (n, rank) = (1 + case % 8, 1 + (case / 8) % 5);
            let b: Vec<f64> = (0..n * rank).map(|_| whole(2.0)).collect();
            let dot = |i: usize, x: &[f64]| (0..rank).map(|k| b[i * rank + k] * x[k]).sum::<f64>();
            let matrix: Vec<f64> = (0..n * n).map(|at| dot(at / n, &b[at % n * rank..at % n * rank + rank])).collect();
            let free: Vec<f64> = (0..n).map(|i| matrix[i * n + i].max(1.0)).collect();
            let speed: Vec<f64> = (0..rank).map(|_| whole(3.0)).collect();
            // Every other time rates that only some multipliers answer, if any do.
            let rates: Vec<f64> = (0..n).map(|i| if case % 2 == 0 { dot(i, &speed) } else { whole(3.0) }).collect();
            let tolerances = vec![1e-10; n];
            let found = Problem { matrix: &matrix, free: &free, rates: &rates, tolerances: &tolerances }.solve();
            match by_enumeration(&matrix, &rates) {
                None => {
                    unsolvable += 1;
                    assert!(found.violated.iter().any(|row| *row), "case {case}: {found:?} of {matrix:?}, {rates:?}");
                }
                Some(expected) => {
                    let off = expected.iter().zip(&found.rates).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                    let fine = off < 1e-8 && !found.violated.contains(&true);
                    assert!(fine, "case {case}: {found:?}, not {expected:?}, of {matrix:?}, {rates:?}");
                }
            }
        }
        assert!((500..3000).contains(&unsolvable), "{unsolvable}");
    }

    /// A coordinate that a drive moves answers no impulse.
    #[test]
    fn a_row_that_nothing_can_move_shows_in_its_rate() {
        let found = Problem { matrix: &[0.0], free: &[1.0], rates: &[-1.0], tolerances: &[1e-12] }.solve();
        assert_eq!((found.rates[0], found.active[0]), (-1.0, false));
    }
}
