//! Whether a symmetric matrix is copositive: `vᵀ S v ≥ 0` for every `v ≥ 0`.
//!
//! A matrix is copositive if and only if no principal submatrix has an eigenvector of positive entries with a negative
//! eigenvalue (Kaplan 2000). Up to [`MOST_ENUMERATED`] rows all submatrices are asked; above, directions are searched for by
//! projected descent, which proves that there is one when it finds it, and nothing when it does not.

use crate::round_off::EIGENVECTOR;
use faer::{Mat, Side};

/// Rows up to which all principal submatrices are asked: 2¹⁰ eigenvalue problems.
pub(in crate::statics) const MOST_ENUMERATED: usize = 10;
/// Steps of the projected descent from each start.
const DESCENTS: usize = 200;

/// A direction `v ≥ 0` of unit length with `vᵀ S v < −least`; `None` when there is none (above [`MOST_ENUMERATED`] rows: when
/// none was found).
pub(in crate::statics) fn violation(matrix: &Mat<f64>, least: f64) -> Option<Vec<f64>> {
    let n = matrix.nrows();
    let (values, vectors) = eigen(matrix)?;
    if values.first().is_none_or(|lowest| *lowest >= -least) {
        return None;
    }
    if n <= MOST_ENUMERATED {
        return (1_usize..1 << n).find_map(|set| on_face(matrix, set, least));
    }
    let units = (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect::<Vec<f64>>());
    let ones = std::iter::once(vec![1.0; n]);
    let parts = vectors.iter().zip(&values).filter(|(_, value)| **value < -least).flat_map(|(v, _)| both_parts(v));
    let starts: Vec<Vec<f64>> = units.chain(ones).chain(parts).collect();
    starts.into_iter().find_map(|start| descend(matrix, start, least))
}

/// Ascending eigenvalues with their vectors.
fn eigen(matrix: &Mat<f64>) -> Option<(Vec<f64>, Vec<Vec<f64>>)> {
    let n = matrix.nrows();
    let eigen = matrix.self_adjoint_eigen(Side::Lower).ok()?;
    let vectors = (0..n).map(|k| (0..n).map(|i| eigen.U()[(i, k)]).collect()).collect();
    Some(((0..n).map(|k| eigen.S()[k]).collect(), vectors))
}

fn both_parts(v: &[f64]) -> [Vec<f64>; 2] {
    [1.0, -1.0].map(|sign| v.iter().map(|x| (sign * x).max(0.0)).collect())
}

/// Among directions whose positive entries are those of `set`, a bit for each row.
fn on_face(matrix: &Mat<f64>, set: usize, least: f64) -> Option<Vec<f64>> {
    let rows: Vec<usize> = (0..matrix.nrows()).filter(|i| set >> i & 1 == 1).collect();
    let part = Mat::from_fn(rows.len(), rows.len(), |i, j| matrix[(rows[i], rows[j])]);
    let (values, vectors) = eigen(&part)?;
    let negative = || vectors.iter().zip(&values).filter(|(_, value)| **value < -least).map(|(v, _)| v);
    let signed = |v: &Vec<f64>| {
        both_parts(v).into_iter().find(|p| p.iter().zip(v).all(|(p, x)| (p - x.abs()).abs() < EIGENVECTOR.of(1.0)))
    };
    // Of equal eigenvalues any combination is an eigenvector: the one nearest to equal entries.
    let middle = (0..rows.len()).map(|i| negative().map(|v| v[i] * v.iter().sum::<f64>()).sum()).collect();
    let found = negative().find_map(signed).or_else(|| signed(&middle))?;
    let v = spread(&rows, &found, matrix.nrows());
    unit(v).filter(|v| form(matrix, v) < -least)
}

fn spread(rows: &[usize], part: &[f64], n: usize) -> Vec<f64> {
    let mut v = vec![0.0; n];
    rows.iter().zip(part).for_each(|(row, x)| v[*row] = *x);
    v
}

fn unit(v: Vec<f64>) -> Option<Vec<f64>> {
    let size = v.iter().map(|x| x * x).sum::<f64>().sqrt();
    (size > 0.0).then(|| v.iter().map(|x| x / size).collect())
}

fn times(matrix: &Mat<f64>, v: &[f64]) -> Vec<f64> {
    (0..v.len()).map(|i| v.iter().enumerate().map(|(j, x)| matrix[(i, j)] * x).sum()).collect()
}

fn form(matrix: &Mat<f64>, v: &[f64]) -> f64 {
    times(matrix, v).iter().zip(v).map(|(y, x)| y * x).sum()
}

/// Projected power iteration, `v ← [v − S v/‖S‖]₊` of unit length: the form falls in every step.
fn descend(matrix: &Mat<f64>, start: Vec<f64>, least: f64) -> Option<Vec<f64>> {
    let n = start.len();
    let norm = (0..n).map(|i| (0..n).map(|j| matrix[(i, j)].abs()).sum::<f64>()).fold(f64::MIN_POSITIVE, f64::max);
    let mut v = unit(start)?;
    for _ in 0..DESCENTS {
        if form(matrix, &v) < -least {
            return Some(v);
        }
        let next = times(matrix, &v).iter().zip(&v).map(|(y, x)| (x - y / norm).max(0.0)).collect();
        v = unit(next)?;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Horn's form is copositive without being positive semidefinite or a sum of such and a nonnegative matrix.
    fn horn() -> Mat<f64> {
        let row = [1.0, -1.0, 1.0, 1.0, -1.0];
        Mat::from_fn(5, 5, |i, j| row[(j + 5 - i) % 5])
    }

    #[test]
    fn the_form_of_horn_is_copositive_and_less_of_it_is_not() {
        assert!(violation(&horn(), 1e-9).is_none());
        let less = Mat::from_fn(5, 5, |i, j| horn()[(i, j)] - if i == j { 1e-3 } else { 0.0 });
        let v = violation(&less, 1e-9).expect("a direction");
        assert!(v.iter().all(|x| *x >= 0.0) && form(&less, &v) < -1e-9);
    }

    /// Against a fine grid of directions: wherever that finds a negative form, so does the enumeration, and what the enumeration
    /// finds is one.
    #[test]
    fn random_forms_of_three_rows_agree_with_a_grid() {
        let mut seed = 1_u64;
        let mut random = || {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 53) as f64 * 2.0 - 1.0
        };
        let (mut copositive, mut not) = (0, 0);
        for _ in 0..300 {
            let raw: Vec<f64> = (0..9).map(|_| random()).collect();
            let s = Mat::from_fn(3, 3, |i, j| raw[3 * i.min(j) + i.max(j)] + if i == j { 0.7 } else { 0.0 });
            let grid = (0..=60).flat_map(|i| (0..=60 - i).map(move |j| [i, j, 60 - i - j]));
            let lowest = grid.map(|v| v.map(f64::from)).filter_map(|v| unit(v.to_vec())).map(|v| form(&s, &v));
            let lowest = lowest.fold(f64::INFINITY, f64::min);
            match violation(&s, 1e-9) {
                Some(v) => {
                    assert!(v.iter().all(|x| *x >= 0.0) && form(&s, &v) < -1e-9);
                    not += 1;
                }
                None => {
                    assert!(lowest >= -1e-9, "{lowest}");
                    copositive += 1;
                }
            }
        }
        assert!(copositive > 30 && not > 30, "{copositive} {not}");
    }
}
