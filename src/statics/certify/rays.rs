//! The extreme rays of a pointed cone `T v ≤ 0`, by the method of double description (Motzkin 1953; Fukuda & Prodon 1996).
//!
//! ```text
//! as many rows as there are entries of v, linearly independent:  the rays are the columns of −T⁻¹                        (1)
//! each further row a:  rays with a·r ≤ 0 stay, and of neighbours with a·p > 0 > a·n  (a·p) n − (a·n) p is a new one     (2)
//! ```
//!
//! Two rays are neighbours if no third one is on all the rows that both are on.

use crate::round_off::EIGENVECTOR;
use faer::Mat;
use faer::linalg::solvers::Solve;

/// Rays up to which further rows are taken: the matrix of a form on them is searched in the third power of their number.
const MOST_RAYS: usize = 400;

/// A ray of unit length, and on which rows it is.
struct Ray {
    v: Vec<f64>,
    on: Vec<bool>,
}

impl Ray {
    fn new(v: Vec<f64>, rows: &[Vec<f64>]) -> Option<Self> {
        let size = dot(&v, &v).sqrt();
        let v: Vec<f64> = v.iter().map(|x| x / size).collect();
        let on = rows.iter().map(|row| dot(row, &v).abs() <= EIGENVECTOR.of(dot(row, row).sqrt())).collect();
        (size > 0.0 && size.is_finite()).then_some(Self { v, on })
    }
}

/// The rays of `{v: row · v ≤ 0 for all rows}`; the first `rank` of the rows are linearly independent, and `rank` is the length of
/// each. `None` if there are too many.
pub(super) fn rays(rows: &[Vec<f64>], rank: usize) -> Option<Vec<Vec<f64>>> {
    let inverse = Mat::from_fn(rank, rank, |i, j| rows[i][j]).partial_piv_lu().solve(Mat::<f64>::identity(rank, rank));
    let column = |j: usize| (0..rank).map(|i| -inverse[(i, j)]).collect::<Vec<f64>>();
    let mut found: Vec<Ray> = (0..rank).filter_map(|j| Ray::new(column(j), rows)).collect();
    for (index, row) in rows.iter().enumerate().skip(rank) {
        let along = |ray: &Ray| if ray.on[index] { 0.0 } else { dot(row, &ray.v) };
        let mut new = Vec::new();
        for beyond in found.iter().filter(|ray| along(ray) > 0.0) {
            for within in found.iter().filter(|ray| along(ray) < 0.0) {
                if are_neighbours(&found, beyond, within, index) {
                    let (p, n) = (along(beyond), along(within));
                    let v = within.v.iter().zip(&beyond.v).map(|(within, beyond)| p * within - n * beyond).collect();
                    new.extend(Ray::new(v, rows));
                }
            }
        }
        found.retain(|ray| along(ray) <= 0.0);
        found.extend(new);
        if found.len() > MOST_RAYS {
            return None;
        }
    }
    Some(found.into_iter().map(|ray| ray.v).collect())
}

/// Whether no third ray is on all of the first `count` rows that both are on.
fn are_neighbours(all: &[Ray], a: &Ray, b: &Ray, count: usize) -> bool {
    let both: Vec<usize> = (0..count).filter(|row| a.on[*row] && b.on[*row]).collect();
    let third = |ray: &&Ray| !std::ptr::eq(*ray, a) && !std::ptr::eq(*ray, b);
    !all.iter().filter(third).any(|ray| both.iter().all(|row| ray.on[*row]))
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A cone over a regular polygon has one ray for each corner, and one over a cube's corners as many as a cube has.
    #[test]
    fn cones_over_polygons_have_their_corners() {
        for corners in 3..9 {
            let turn = |k: usize| std::f64::consts::TAU * k as f64 / corners as f64;
            let rows: Vec<Vec<f64>> = (0..corners).map(|k| vec![turn(k).cos(), turn(k).sin(), -1.0]).collect();
            let found = rays(&rows, 3).expect("few");
            assert_eq!(found.len(), corners);
            assert!(found.iter().all(|v| rows.iter().all(|row| dot(row, v) < 1e-12)));
        }
        let cube = |k: usize| -> Vec<f64> {
            let mut row = vec![0.0, 0.0, 0.0, -1.0];
            row[k / 2] = if k.is_multiple_of(2) { 1.0 } else { -1.0 };
            row
        };
        let order = [0, 2, 4, 1, 3, 5];
        assert_eq!(rays(&order.map(cube), 4).map(|found| found.len()), Some(8));
    }

    /// Two rows against each other leave the motions along them.
    #[test]
    fn opposite_rows_leave_what_is_along_them() {
        let rows = [vec![1.0, 0.0], vec![0.0, 1.0], vec![-1.0, 0.0]];
        let found = rays(&rows, 2).expect("few");
        assert_eq!(found, [vec![-0.0, -1.0]]);
        assert!(rays(&[vec![1.0], vec![-1.0]], 1).is_some_and(|found| found.is_empty()));
    }
}
