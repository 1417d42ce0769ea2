//! The pivot of a ball, eliminated one direction after the other.
//!
//! Before a heavy body a light link's `D` has directions that this resists and others that nothing but the link does, 10¹² times less.
//! `D⁻¹` as a matrix keeps none of their digits: its determinant is the difference of products of the largest entries, and what
//! belongs to the smallest rounds the others. With the largest entry first, `P D Q = L U`, each direction is left what those before
//! have not taken.

use crate::spatial::quad::{Columns, Quad};
use nalgebra::{Matrix3, Vector3};

/// The factors of a matrix: `P D Q = L U`, `L` with ones on its diagonal.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pivots {
    /// `P` and `Q`: which row and which column comes where.
    rows: [usize; 3],
    columns: [usize; 3],
    l21: f64,
    l31: f64,
    l32: f64,
    u12: f64,
    u13: f64,
    u23: f64,
    /// One over the diagonal of `U`.
    inverse: [f64; 3],
}

impl Pivots {
    /// Of a matrix; `None` for one that is singular or not finite.
    pub(super) fn of(D: &Matrix3<f64>) -> Option<Self> {
        let (mut m, mut rows, mut columns) = (*D, [0, 1, 2], [0, 1, 2]);
        for k in 0..2 {
            let mut largest = (k, k);
            for (i, j) in (k..3).flat_map(|i| (k..3).map(move |j| (i, j))) {
                if m[(i, j)].abs() > m[largest].abs() {
                    largest = (i, j);
                }
            }
            m.swap_rows(k, largest.0);
            m.swap_columns(k, largest.1);
            rows.swap(k, largest.0);
            columns.swap(k, largest.1);
            for i in k + 1..3 {
                m[(i, k)] /= m[(k, k)];
                for j in k + 1..3 {
                    m[(i, j)] -= m[(i, k)] * m[(k, j)];
                }
            }
        }
        let inverse = [0, 1, 2].map(|k| 1.0 / m[(k, k)]);
        if !(m.iter().all(|x| x.is_finite()) && inverse.iter().all(|x| x.is_finite())) {
            return None;
        }
        let (l21, l31, l32) = (m[(1, 0)], m[(2, 0)], m[(2, 1)]);
        let (u12, u13, u23) = (m[(0, 1)], m[(0, 2)], m[(1, 2)]);
        Some(Self { rows, columns, l21, l31, l32, u12, u13, u23, inverse })
    }

    /// `L⁻¹ P v`.
    #[inline(always)]
    pub(super) fn forward(&self, v: Quad) -> Quad {
        let [x, y, z] = self.rows.map(|row| v.at(row));
        let y = y - self.l21 * x;
        Quad::of(&Vector3::new(x, y, z - self.l31 * x - self.l32 * y))
    }

    /// `L⁻¹ P M`.
    #[inline(always)]
    pub(super) fn left(&self, M: &Columns) -> Columns {
        Columns(M.0.map(|column| self.forward(column)))
    }

    /// `M Q U⁻¹`.
    #[inline(always)]
    pub(super) fn right(&self, M: &Columns) -> Columns {
        let [first, second, third] = self.columns.map(|column| M.0[column]);
        let [i1, i2, i3] = self.inverse.map(Quad::all);
        let first = i1 * first;
        let second = i2 * Quad::all(self.u12).times_from(first, second);
        let third = Quad::all(self.u23).times_from(second, Quad::all(self.u13).times_from(first, third));
        Columns([first, second, i3 * third])
    }

    /// `Q U⁻¹ y`.
    #[inline(always)]
    pub(super) fn backward(&self, y: Quad) -> Quad {
        let z = self.inverse[2] * y.at(2);
        let second = self.inverse[1] * (y.at(1) - self.u23 * z);
        let first = self.inverse[0] * (y.at(0) - self.u12 * second - self.u13 * z);
        let mut placed = Vector3::zeros();
        [first, second, z].into_iter().zip(self.columns).for_each(|(x, column)| placed[column] = x);
        Quad::of(&placed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_solve_and_say_what_is_singular() {
        let D = Matrix3::new(2.0, -1.0, 0.5, 3.0, 8.0, -2.0, 0.25, 1.0, 4.0);
        let pivots = Pivots::of(&D).expect("a regular matrix");
        let v = Vector3::new(1.0, -2.0, 3.0);
        let found = pivots.backward(pivots.forward(Quad::of(&v))).vector();
        assert!((D * found - v).norm() < 1e-14, "{found}");
        let M = Matrix3::new(1.0, 2.0, 3.0, -4.0, 5.0, 6.0, 7.0, 8.0, -9.0);
        let product = pivots.right(&Columns::of(&M)).by(&pivots.left(&Columns::of(&D))).matrix();
        assert!((product - M).norm() < 1e-13, "M D⁻¹ D = M: {product}");
        assert!(Pivots::of(&Matrix3::new(1.0, 2.0, 3.0, 2.0, 4.0, 6.0, 1.0, 0.0, 1.0)).is_none());
        assert!(Pivots::of(&Matrix3::from_element(f64::NAN)).is_none());
    }

    /// One direction 10⁹ times heavier than another and 10¹³ times than the third, askew: what the light ones do keeps the digits
    /// that the numbers of the matrix have, here 10⁻¹⁶ · 10¹³.
    #[test]
    fn light_directions_keep_their_digits_beside_heavy_ones() {
        let turn = *nalgebra::Rotation3::from_scaled_axis(Vector3::new(0.3, -0.8, 0.5)).matrix();
        let D = turn * Matrix3::from_diagonal(&Vector3::new(1e9, 1.0, 1e-4)) * turn.transpose();
        let pivots = Pivots::of(&D).expect("a regular matrix");
        let expected = turn * Vector3::new(0.5, -2.0, 1.0);
        let force = turn * Vector3::new(0.5e9, -2.0, 1e-4);
        let found = pivots.backward(pivots.forward(Quad::of(&force))).vector();
        assert!((found - expected).norm() < 0.02, "{found} for {expected}");
        let adjugate = D.try_inverse().map_or(f64::INFINITY, |inverse| (inverse * force - expected).norm());
        assert!(adjugate > 1.0, "{adjugate}: the matrix is no test any more");
    }
}
