//! The interpolating spline of degree 5 through points: four continuous derivatives.
//!
//! The parameter is the sum of the chords. Its knots are the points but for the first two and the last two inside ("not a
//! knot"), so that a polynomial of degree 5 is reproduced; with fewer than six points it is the polynomial through them.

use nalgebra::Vector3;

/// Degree of the pieces.
const DEGREE: usize = 5;

/// Polynomials one after the other.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Spline {
    /// Where the pieces begin, and where the last one ends.
    pub(super) knots: Vec<f64>,
    /// Taylor coefficients of each piece from its beginning on.
    pieces: Vec<[Vector3<f64>; DEGREE + 1]>,
}

impl Spline {
    /// Through at least two points, no two in succession at the same place.
    pub(super) fn through(points: &[Vector3<f64>]) -> Self {
        let mut chords = vec![0.0];
        for pair in points.windows(2) {
            chords.push(chords[chords.len() - 1] + (pair[1] - pair[0]).norm());
        }
        let (n, degree) = (points.len(), DEGREE.min(points.len() - 1));
        // Not a knot: as many points inside are left out at both ends as there are functions too many.
        let skipped = (degree - 1) / 2;
        let inside = if n > degree + 1 { &chords[1 + skipped..n - 1 - skipped] } else { &[] };
        let (first, last) = (chords[0], chords[n - 1]);
        let all: Vec<f64> = [vec![first; degree + 1], inside.to_vec(), vec![last; degree + 1]].concat();
        let coefficients = collocated(&all, degree, &chords, points);
        let knots: Vec<f64> = [&[first], inside, &[last]].concat();
        let pieces = (0..knots.len() - 1).map(|i| taylor(&all, degree, degree + i, &coefficients)).collect();
        Self { knots, pieces }
    }

    /// The place and its first four derivatives.
    pub(super) fn at(&self, u: f64) -> [Vector3<f64>; 5] {
        let i = self.knots[1..self.knots.len() - 1].partition_point(|knot| *knot <= u);
        let (piece, x) = (&self.pieces[i], u - self.knots[i]);
        std::array::from_fn(|k| {
            let factor = |j: usize| (j - k + 1..=j).map(|i| i as f64).product::<f64>();
            (k..=DEGREE).rev().fold(Vector3::zeros(), |sum, j| sum * x + factor(j) * piece[j])
        })
    }
}

/// The basis functions of a degree that do not vanish on the span after knot `span`, at `u`: `span − degree` is the first.
fn basis(knots: &[f64], degree: usize, span: usize, u: f64) -> [f64; DEGREE + 1] {
    let mut n = [0.0; DEGREE + 1];
    n[0] = 1.0;
    for d in 1..=degree {
        let mut saved = 0.0;
        for r in 0..d {
            let (right, left) = (knots[span + r + 1], knots[span + 1 + r - d]);
            let part = n[r] / (right - left);
            n[r] = saved + (right - u) * part;
            saved = (u - left) * part;
        }
        n[d] = saved;
    }
    n
}

/// Solves for the coefficients: by rows a banded matrix whose minors are not negative, eliminated without pivoting.
fn collocated(knots: &[f64], degree: usize, at: &[f64], values: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let n = at.len();
    let (width, mut x) = (2 * DEGREE + 1, values.to_vec());
    // Row i has the columns i − DEGREE … i + DEGREE.
    let mut rows = vec![[0.0; 2 * DEGREE + 1]; n];
    for (i, u) in at.iter().enumerate() {
        let span = knots[..n].partition_point(|knot| knot <= u).max(degree + 1) - 1;
        for (k, value) in basis(knots, degree, span, *u).into_iter().enumerate().take(degree + 1) {
            let column = span - degree + k;
            if value != 0.0 {
                rows[i][column + DEGREE - i] = value;
            }
        }
    }
    for k in 0..n {
        for i in k + 1..n.min(k + DEGREE + 1) {
            let factor = rows[i][k + DEGREE - i] / rows[k][DEGREE];
            if factor != 0.0 {
                for column in k..n.min(k + DEGREE + 1) {
                    let above = rows[k][column + DEGREE - k];
                    rows[i][column + DEGREE - i] -= factor * above;
                }
                x[i] = x[i] - factor * x[k];
            }
        }
    }
    for i in (0..n).rev() {
        for column in i + 1..n.min(i + width - DEGREE) {
            x[i] = x[i] - rows[i][column + DEGREE - i] * x[column];
        }
        x[i] /= rows[i][DEGREE];
    }
    x
}

/// The polynomial on the span after a knot, from that knot on: derivatives of the control points.
fn taylor(knots: &[f64], degree: usize, span: usize, coefficients: &[Vector3<f64>]) -> [Vector3<f64>; DEGREE + 1] {
    let mut control = coefficients[span - degree..=span].to_vec();
    let mut out = [Vector3::zeros(); DEGREE + 1];
    let mut factorial = 1.0;
    for (k, out) in out.iter_mut().enumerate().take(degree + 1) {
        let d = degree - k;
        factorial *= k.max(1) as f64;
        let n = basis(knots, d, span, knots[span]);
        *out = control.iter().zip(n).map(|(c, n)| *c * n).sum::<Vector3<f64>>() / factorial;
        control = (0..d)
            .map(|j| {
                let first = span - d + j + 1;
                (control[j + 1] - control[j]) * (d as f64 / (knots[first + d] - knots[first]))
            })
            .collect();
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(count: usize) -> Vec<Vector3<f64>> {
        let at = |i: usize| {
            let x = 0.37 * i as f64;
            Vector3::new(x.sin() + 0.2 * x, (1.3 * x).cos(), 0.3 * x + 0.1 * (2.0 * x).sin())
        };
        (0..count).map(at).collect()
    }

    /// It goes through its points, and four derivatives are continuous at its knots.
    #[test]
    fn it_is_smooth_and_goes_through_the_points() {
        for count in [2, 3, 4, 5, 6, 7, 8, 9, 20, 200] {
            let points = points(count);
            let spline = Spline::through(&points);
            let mut u = 0.0;
            for (i, point) in points.iter().enumerate() {
                u += if i > 0 { (point - points[i - 1]).norm() } else { 0.0 };
                assert!((spline.at(u)[0] - point).norm() < 1e-13, "{count} {i}");
            }
            for knot in &spline.knots[1..spline.knots.len() - 1] {
                let (before, after) = (spline.at(knot * (1.0 - 1e-15) - 1e-15), spline.at(*knot));
                for k in 0..5 {
                    // Round-off, and a factor of the degree over a chord for each derivative.
                    assert!((before[k] - after[k]).norm() < 1e-12 * 20.0_f64.powi(k as i32), "{count} {knot} {k}");
                }
            }
        }
    }

    /// Halving the distances divides the error by 64: order 6.
    #[test]
    fn it_is_of_order_six() {
        let circle = |count: usize| {
            let at = |i: usize| {
                let angle = 3.0 * i as f64 / (count - 1) as f64;
                Vector3::new(angle.cos(), angle.sin(), 0.0)
            };
            let spline = Spline::through(&(0..count).map(at).collect::<Vec<_>>());
            let end = spline.knots[spline.knots.len() - 1];
            (0..1000).map(|i| (spline.at(end * i as f64 / 999.0)[0].norm() - 1.0).abs()).fold(0.0, f64::max)
        };
        let order = (circle(20) / circle(39)).log2();
        assert!(order > 5.5, "{order}");
    }
}
