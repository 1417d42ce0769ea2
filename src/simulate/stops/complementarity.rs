//! Rows whose multipliers have bounds: the law of what pushes and never pulls (Signorini's), and of what holds up to a largest
//! force (Coulomb's, at rest), between the rates of some rows and their multipliers,
//!
//! ```text
//! (1)  l ≤ λ ≤ h,   w = A λ + b:   w ≥ 0 if λ = l,   w ≤ 0 if λ = h,   w = 0 between,   A = H M⁻¹ Hᵀ  positive semidefinite
//! ```
//!
//! a mixed linear complementarity problem, and the optimality condition of min ½ λᵀ A λ + bᵀ λ, l ≤ λ ≤ h. A stop has l = 0 and
//! h = ∞. It is solved by the active set method of Lawson and Hanson for bounded variables (*Solving Least Squares Problems*,
//! 1974, ch. 23; Stark and Parker, *Bounded-variable least squares*, 1995), which keeps the free rows linearly independent: a
//! row that depends on the free ones replaces one of them, if that can be. A row that cannot enter now may do so once the free
//! rows are others.

/// A pivot below this part of a row's own entry without loops, drives and gears counts as zero.
const DEPENDENT: f64 = 1e-9;

/// Of a row that pushes and never pulls.
pub(in crate::simulate) const ONE_SIDED: [f64; 2] = [0.0, f64::INFINITY];

/// The problem (1).
#[derive(Debug, Clone)]
pub(in crate::simulate) struct Problem<'a> {
    /// `A` by rows.
    pub(in crate::simulate) matrix: &'a [f64],
    /// The diagonal of `A` without loops, drives and gears, > 0: what pivots are compared with.
    pub(in crate::simulate) free: &'a [f64],
    /// `b`.
    pub(in crate::simulate) rates: &'a [f64],
    /// `l ≤ 0` and `h ≥ 0`, per row.
    pub(in crate::simulate) bounds: &'a [[f64; 2]],
    /// A rate between −tolerance and tolerance counts as zero, per row.
    pub(in crate::simulate) tolerances: &'a [f64],
}

/// A solution, as far as there is one.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::simulate) struct Solution {
    /// `λ`.
    pub(in crate::simulate) multipliers: Vec<f64>,
    /// Rows whose multipliers are free, so that their rates vanish; they are linearly independent.
    pub(in crate::simulate) active: Vec<bool>,
    /// `w`.
    pub(in crate::simulate) rates: Vec<f64>,
    /// Rows whose rates no multipliers satisfy.
    pub(in crate::simulate) violated: Vec<bool>,
}

impl Problem<'_> {
    /// Solves (1). Rows that cannot be satisfied show in the rates.
    pub(in crate::simulate) fn solve(&self) -> Solution {
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
            let worst = |row: usize| -state.rates[row].abs() / self.free[row].sqrt();
            let open = (0..n).filter(|row| !unreachable[*row] && self.wants(&state, *row).is_some());
            let Some(row) = open.min_by(|a, b| worst(*a).total_cmp(&worst(*b))) else { break };
            let Some(sign) = self.wants(&state, row) else { break };
            match self.enter(&mut state, row, sign) {
                true => unreachable.fill(false),
                false => unreachable[row] = true,
            }
        }
        state.rates = self.rates_of(&state.multipliers);
        state.violated = (0..n).map(|row| self.wants(&state, row).is_some()).collect();
        state
    }

    /// Which way the multiplier of a row that is not free has to go; `None` if it may stay.
    fn wants(&self, state: &Solution, row: usize) -> Option<f64> {
        let (rate, [low, high], at) = (state.rates[row], self.bounds[row], state.multipliers[row]);
        let up = rate < -self.tolerances[row] && at < high;
        let down = rate > self.tolerances[row] && at > low;
        (!state.active[row] && (up || down)).then_some(if up { 1.0 } else { -1.0 })
    }

    /// The usual case: all rows that are violated at λ = 0 are free.
    fn all_at_once(&self, state: &mut Solution) -> bool {
        let n = self.rates.len();
        let rows: Vec<usize> = (0..n).filter(|row| self.wants(state, *row).is_some()).collect();
        let Some(multipliers) = self.stationary(&rows) else { return false };
        let within = |(row, at): (&usize, &f64)| self.bounds[*row][0] < *at && *at < self.bounds[*row][1];
        if !rows.iter().zip(&multipliers).all(within) {
            return false;
        }
        let mut all = Solution { multipliers: vec![0.0; n], ..state.clone() };
        for (row, multiplier) in rows.iter().zip(&multipliers) {
            (all.multipliers[*row], all.active[*row]) = (*multiplier, true);
        }
        all.rates = self.rates_of(&all.multipliers);
        let satisfied = (0..n).all(|row| self.wants(&all, row).is_none());
        if satisfied {
            *state = all;
        }
        satisfied
    }

    /// Frees a row whose multiplier wants to go up (sign 1) or down (−1); false if that leaves the multipliers as they are.
    fn enter(&self, state: &mut Solution, row: usize, sign: f64) -> bool {
        let (active, before) = (state.rows(), state.clone());
        let Some(combination) = self.combine(&active, row) else { return false };
        if self.pivot(&active, &combination, row) <= DEPENDENT * self.free[row] {
            // λ + t (e_row − combination) changes no rate: as far as the bounds of all of them allow it.
            let to_bound = |of: usize, slope: f64| {
                let [low, high] = self.bounds[of];
                let towards = if slope > 0.0 { high } else { low };
                ((towards - state.multipliers[of]) / slope, of, towards)
            };
            let others = active.iter().zip(&combination).filter(|(_, c)| c.abs() > DEPENDENT);
            let steps = others.map(|(other, c)| to_bound(*other, -sign * c)).chain([to_bound(row, sign)]);
            let Some((step, stops, bound)) = steps.min_by(|a, b| a.0.total_cmp(&b.0)) else { return false };
            if !step.is_finite() {
                return false;
            }
            for (other, c) in active.iter().zip(&combination) {
                state.multipliers[*other] -= sign * step * c;
            }
            state.multipliers[row] += sign * step;
            (state.multipliers[stops], state.active[stops]) = (bound, false);
            if stops == row {
                return state.multipliers != before.multipliers;
            }
        }
        state.active[row] = true;
        self.descend(state);
        (&state.active, &state.multipliers) != (&before.active, &before.multipliers)
    }

    /// To the stationary point of the free rows, or to the first bound on the way; that row is free no longer.
    fn descend(&self, state: &mut Solution) {
        loop {
            let active = state.rows();
            let Some(target) = self.stationary_from(&active, &state.multipliers) else { return };
            let step_of = |at: usize| {
                let (row, from, to) = (active[at], state.multipliers[active[at]], target[at]);
                let [low, high] = self.bounds[row];
                match (to > low, to < high) {
                    (true, true) => f64::INFINITY,
                    (false, _) => (from - low) / (from - to).max(f64::MIN_POSITIVE),
                    (true, false) => (high - from) / (to - from).max(f64::MIN_POSITIVE),
                }
            };
            let first = (0..active.len()).min_by(|a, b| step_of(*a).total_cmp(&step_of(*b)));
            let Some(first) = first else { return };
            let whole = step_of(first) == f64::INFINITY;
            let step = step_of(first).min(1.0);
            for (row, to) in active.iter().zip(&target) {
                state.multipliers[*row] += step * (to - state.multipliers[*row]);
            }
            if whole {
                return;
            }
            let [low, high] = self.bounds[active[first]];
            state.multipliers[active[first]] = if target[first] > low { high } else { low };
            state.active[active[first]] = false;
        }
    }

    /// Whether a row depends linearly on the free rows of a solution: it moves as they do.
    pub(in crate::simulate) fn follows(&self, solution: &Solution, row: usize) -> bool {
        self.combination(solution, row).is_some()
    }

    /// The free rows that a row depends on linearly, each with how far the row moves as that moves by 1; `None` for a row that moves by
    /// itself.
    pub(in crate::simulate) fn combination(&self, solution: &Solution, row: usize) -> Option<Vec<(usize, f64)>> {
        let active = solution.rows();
        let combination = self.combine(&active, row)?;
        let depends = self.pivot(&active, &combination, row) <= DEPENDENT * self.free[row];
        depends.then(|| active.into_iter().zip(combination).collect())
    }

    /// Part of a row's own entry that its combination of other rows does not give.
    fn pivot(&self, others: &[usize], combination: &[f64], row: usize) -> f64 {
        let common = others.iter().zip(combination).map(|(other, c)| self.entry(row, *other) * c);
        self.entry(row, row) - common.sum::<f64>()
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

    /// The multipliers with which the rates of these rows vanish, all others being zero; `None` if the rows are linearly dependent.
    pub(in crate::simulate) fn stationary(&self, rows: &[usize]) -> Option<Vec<f64>> {
        self.solve_among(rows, rows.iter().map(|row| -self.rates[*row]).collect())
    }

    /// The multipliers with which the rates of these rows vanish while all other multipliers stay.
    fn stationary_from(&self, rows: &[usize], multipliers: &[f64]) -> Option<Vec<f64>> {
        let rates = self.rates_of(multipliers);
        let change = self.solve_among(rows, rows.iter().map(|row| -rates[*row]).collect())?;
        Some(rows.iter().zip(change).map(|(row, change)| multipliers[*row] + change).collect())
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
            let (tolerances, bounds) = (vec![1e-10; n], vec![ONE_SIDED; n]);
            let found =
                Problem { matrix: &matrix, free: &free, rates: &rates, bounds: &bounds, tolerances: &tolerances }
                    .solve();
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
            let (tolerances, bounds) = (vec![1e-10; n], vec![ONE_SIDED; n]);
            let found =
                Problem { matrix: &matrix, free: &free, rates: &rates, bounds: &bounds, tolerances: &tolerances }
                    .solve();
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
        let found =
            Problem { matrix: &[0.0], free: &[1.0], rates: &[-1.0], bounds: &[ONE_SIDED], tolerances: &[1e-12] }
                .solve();
        assert_eq!((found.rates[0], found.active[0]), (-1.0, false));
    }

    /// Small integers again, with bounds on both sides: such a problem always has a solution, and (1) is its proof.
    #[test]
    fn bounded_problems_of_any_rank_are_solved() {
        let (mut seed, mut saturated) = (0x6c07_8965_1b4d_91d3, 0);
        let mut whole = |size: f64| (size * next(&mut seed)).round();
        for case in 0..3000 {
            let (n, rank) = (1 + case % 5, 1 + (case / 5) % 4);
            let b: Vec<f64> = (0..n * rank).map(|_| whole(2.0)).collect();
            let dot = |i: usize, x: &[f64]| (0..rank).map(|k| b[i * rank + k] * x[k]).sum::<f64>();
            let matrix: Vec<f64> = (0..n * n).map(|at| dot(at / n, &b[at % n * rank..at % n * rank + rank])).collect();
            let free: Vec<f64> = (0..n).map(|i| matrix[i * n + i].max(1.0)).collect();
            let rates: Vec<f64> = (0..n).map(|_| whole(3.0)).collect();
            let (tolerances, bounds) = (vec![1e-10; n], (0..n).map(|_| [-whole(1.4).abs(), whole(1.4).abs()]));
            let bounds: Vec<[f64; 2]> = bounds.collect();
            let problem =
                Problem { matrix: &matrix, free: &free, rates: &rates, bounds: &bounds, tolerances: &tolerances };
            let found = problem.solve();
            saturated += usize::from((0..n).any(|i| !found.active[i] && found.rates[i].abs() > 1e-6));
            for i in 0..n {
                let ([low, high], at, w) = (bounds[i], found.multipliers[i], found.rates[i]);
                let fits = (low - 1e-9..=high + 1e-9).contains(&at)
                    && (w > -1e-8 || at > high - 1e-9)
                    && (w < 1e-8 || at < low + 1e-9);
                assert!(fits && !found.violated[i], "case {case}, row {i}: {found:?} of {problem:?}");
            }
        }
        assert!(saturated > 1000, "{saturated}");
    }
}
