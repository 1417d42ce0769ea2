//! What rows of contacts do to each other, `R M⁻¹ Pᵀ`: zero between rows that no tree ties to each other, directly or through others. Each
//! such component is solved by itself.

use nalgebra::{DMatrix, DVector};

/// Singular values below this part of the largest are those of linearly dependent rows.
pub(super) const RANK: f64 = 1e-9;
/// Rows that answer to what they push with by less than this part of those that answer the most do so by rounding, beside loops and drives.
const IMMOVABLE: f64 = 1e-13;

/// `R M⁻¹ Pᵀ` by components.
#[derive(Debug, Default)]
pub(super) struct Coupling {
    pub(super) components: Vec<Component>,
    /// The largest answer of a row to what it pushes with.
    most: f64,
    /// Rows of all components.
    pub(super) count: usize,
}

/// Rows that push on each other.
#[derive(Debug)]
pub(super) struct Component {
    /// In order.
    pub(super) rows: Vec<usize>,
    matrix: DMatrix<f64>,
}

/// Rows of a component that are linearly independent, in order.
pub(super) struct Pivots {
    pub(super) rows: Vec<usize>,
    /// The last pivot: how independent of the others the least of them is, 1 if it is across all of them.
    pub(super) least: f64,
}

/// Equations of independent rows with orthonormal coefficients, `Qᵀ λ = x`, forces in units of their rows: `Bᵢᵀ = Q R`, `x = R⁻ᵀ rᵢ`. Rows
/// are those of a component, in order.
pub(super) struct Across {
    pub(super) units: Vec<f64>,
    pub(super) q: DMatrix<f64>,
    pub(super) x: DVector<f64>,
}

impl Coupling {
    /// Of rows that belong to these trees each, from the entries of the matrix.
    pub(super) fn new(trees: &[Vec<usize>], entry: impl Fn(usize, usize) -> f64) -> Self {
        let components: Vec<Component> = components(trees)
            .into_iter()
            .map(|rows| {
                let matrix = DMatrix::from_fn(rows.len(), rows.len(), |i, j| entry(rows[i], rows[j]));
                Component { rows, matrix }
            })
            .collect();
        let largest = |component: &Component| component.matrix.diagonal().amax();
        let most = components.iter().map(largest).fold(0.0, f64::max);
        Self { components, most, count: trees.len() }
    }

    /// The solution of least norm, each row in units of its own entry: in the span of the rows `kept`, which are linearly independent.
    pub(super) fn solve(&self, rates: &DVector<f64>, kept: &[usize]) -> DVector<f64> {
        self.solve_each(rates, |component| component.own(kept))
    }

    /// The solution of least norm of symmetric rows that may be linearly dependent.
    pub(super) fn shortest(&self, rates: &DVector<f64>) -> DVector<f64> {
        self.solve_each(rates, |component| component.own(&self.pivots(component).rows))
    }

    fn solve_each(&self, rates: &DVector<f64>, kept: impl Fn(&Component) -> Vec<usize>) -> DVector<f64> {
        let mut found = DVector::zeros(rates.len());
        for component in &self.components {
            if let [row] = &component.rows[..] {
                // Along what moves by rounding alone nothing is pushed.
                let moves = self.units(component)[0] > 0.0;
                found[*row] = if moves { rates[*row] / component.matrix[(0, 0)] } else { 0.0 };
                continue;
            }
            let forces = match self.across(component, rates, &kept(component)) {
                Some(Across { units, q, x }) => (q * x).component_mul(&DVector::from_vec(units)),
                None => DVector::from_element(component.rows.len(), f64::NAN),
            };
            component.rows.iter().zip(forces.iter()).for_each(|(row, force)| found[*row] = *force);
        }
        found
    }

    /// What makes the rows of a component comparable: the diagonal of its matrix is 1 with them; 0 for rows along which hinges, loops and drives
    /// let nothing move.
    fn units(&self, component: &Component) -> Vec<f64> {
        let least = IMMOVABLE * self.most;
        let unit = |entry: &f64| if entry.abs() > least { entry.abs().sqrt().recip() } else { 0.0 };
        component.matrix.diagonal().iter().map(unit).collect()
    }

    /// Rows of a symmetric positive semidefinite component that are linearly independent (Cholesky's factorization with complete pivoting).
    pub(super) fn pivots(&self, component: &Component) -> Pivots {
        self.pivots_among(component, &(0..component.rows.len()).collect::<Vec<_>>())
    }

    /// Linearly independent rows among some of a component.
    pub(super) fn pivots_among(&self, component: &Component, among: &[usize]) -> Pivots {
        let (n, units, matrix) = (among.len(), self.units(component), &component.matrix);
        let entry = |i: usize, j: usize| matrix[(among[i], among[j])] * units[among[i]] * units[among[j]];
        let mut left = DMatrix::from_fn(n, n, entry);
        let (mut found, mut least) = (Vec::new(), 0.0);
        for _ in 0..n {
            let others = (0..n).filter(|i| !found.contains(i));
            let largest = others.max_by(|a, b| left[(*a, *a)].total_cmp(&left[(*b, *b)]));
            let Some(at) = largest.filter(|at| left[(*at, *at)] > RANK) else { break };
            least = left[(at, at)];
            let column = left.column(at) / f64::sqrt(least);
            left -= &column * column.transpose();
            found.push(at);
        }
        found.sort_unstable();
        Pivots { rows: found.into_iter().map(|i| component.rows[among[i]]).collect(), least }
    }

    /// The equations of a component; `kept` are places in it.
    pub(super) fn across(&self, component: &Component, rates: &DVector<f64>, kept: &[usize]) -> Option<Across> {
        let (units, rows) = (self.units(component), &component.rows);
        let entry = |j: usize, i: usize| component.matrix[(kept[i], j)] * units[kept[i]] * units[j];
        let factors = DMatrix::from_fn(rows.len(), kept.len(), entry).qr();
        let mut x = DVector::from_iterator(kept.len(), kept.iter().map(|i| rates[rows[*i]] * units[*i]));
        factors.r().tr_solve_upper_triangular_mut(&mut x).then(|| Across { units, q: factors.q(), x })
    }
}

impl Component {
    /// Places of those among these rows, in order, that are its own.
    pub(super) fn own(&self, rows: &[usize]) -> Vec<usize> {
        (0..self.rows.len()).filter(|at| rows.binary_search(&self.rows[*at]).is_ok()).collect()
    }
}

/// Rows that are tied to each other by the trees that they belong to; each in order.
fn components(trees: &[Vec<usize>]) -> Vec<Vec<usize>> {
    // A row that a tree was met in first stands for all in it, and its own first for that.
    let mut first: Vec<usize> = (0..trees.len()).collect();
    let root = |first: &[usize], mut row: usize| {
        while first[row] != row {
            row = first[row];
        }
        row
    };
    let mut met: Vec<(usize, usize)> = Vec::new();
    for (row, own) in trees.iter().enumerate() {
        for tree in own {
            match met.binary_search_by_key(tree, |(tree, _)| *tree) {
                Ok(at) => {
                    let [one, other] = [met[at].1, row].map(|row| root(&first, row));
                    first[one.max(other)] = one.min(other);
                }
                Err(at) => met.insert(at, (*tree, row)),
            }
        }
    }
    let mut all: Vec<Vec<usize>> = Vec::new();
    let mut place = vec![usize::MAX; trees.len()];
    for row in 0..trees.len() {
        let root = root(&first, row);
        if place[root] == usize::MAX {
            place[root] = all.len();
            all.push(Vec::new());
        }
        all[place[root]].push(row);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_one_tree_are_one_component_however_they_are_tied() {
        let trees = [vec![0], vec![3, 5], vec![1], vec![], vec![5, 0], vec![1, 2], vec![]];
        assert_eq!(components(&trees), [vec![0, 1, 4], vec![2, 5], vec![3], vec![6]]);
    }

    #[test]
    fn components_are_solved_as_all_rows_at_once_would_be() {
        let trees = [vec![0], vec![1], vec![0], vec![1], vec![2], vec![3]];
        // Two rows of the second tree are one.
        let matrix = DMatrix::from_row_slice(
            6,
            6,
            &[
                2.0, 0.0, 0.5, 0.0, 0.0, 0.0, //
                0.0, 3.0, 0.0, 3.0, 0.0, 0.0, //
                0.5, 0.0, 1.0, 0.0, 0.0, 0.0, //
                0.0, 3.0, 0.0, 3.0, 0.0, 0.0, //
                0.0, 0.0, 0.0, 0.0, 4.0, 0.0, //
                0.0, 0.0, 0.0, 0.0, 0.0, 4e-33,
            ],
        );
        let coupling = Coupling::new(&trees, |i, j| matrix[(i, j)]);
        // The last moves by rounding alone: it pushes nothing, whatever it is off by.
        let rates = DVector::from_vec(vec![1.0, 6.0, 2.0, 6.0, 8.0, 1e-16]);
        let found = coupling.shortest(&rates);
        // Of numbers below ten the round-off.
        assert!((&matrix * &found - &rates).amax() < 1e-14, "{found}");
        assert!((found[1] - found[3]).abs() < 1e-14 && found[4] == 2.0 && found[5] == 0.0, "{found}");
        assert_eq!(coupling.components.iter().map(|own| coupling.pivots(own).rows.len()).sum::<usize>(), 4);
    }
}
