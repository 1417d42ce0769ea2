//! A force by a table of points: interpolated, with its slope and its integral.
//!
//! ```text
//! between two points   f(x) = c₀ + c₁ s + c₂ s² + c₃ s³,   s = x − x_k,   integrated term by term
//! beyond the ends      a straight line with the slope of the end
//! smooth               cubic with slopes m_k at the points, Δ_k the slopes of the chords, h_k their lengths:
//! (1) m_k = (w₁ + w₂) / (w₁/Δ_{k−1} + w₂/Δ_k),  w₁ = 2 h_k + h_{k−1},  w₂ = h_k + 2 h_{k−1};   0 where Δ_{k−1} Δ_k ≤ 0
//! (2) m_0 = ((2 h_0 + h_1) Δ_0 − h_0 Δ_1) / (h_0 + h_1);   0 where its sign is not that of Δ_0, at most 3 Δ_0 where Δ_1 has the other
//! linear               straight from point to point: the slope jumps there
//! ```
//!
//! Cubics with such slopes rise and fall with the points and nowhere else: F. N. Fritsch, R. E. Carlson, Monotone Piecewise
//! Cubic Interpolation, SIAM J. Numer. Anal. 17 (1980); the slopes (1) are those of F. N. Fritsch, J. Butland, A Method for
//! Constructing Local Monotone Piecewise Cubic Interpolants, SIAM J. Sci. Stat. Comput. 5 (1984).

/// How a table is read between its points.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Interpolation {
    /// A continuous slope; rises and falls with the points and nowhere else.
    #[default]
    Smooth,
    /// Straight from point to point.
    Linear,
}

/// What is wrong with the points of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BadPoint {
    /// Which point; `None` for the table as a whole.
    pub index: Option<usize>,
    /// What is wrong with it.
    pub message: String,
    /// What to do about it.
    pub help: &'static str,
}

/// A table, compiled.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    /// Increasing.
    at: Vec<f64>,
    /// Before the first point, between each two, after the last.
    pieces: Vec<Piece>,
    /// The integral from the first point to zero.
    origin: f64,
    /// Whether its slope jumps at its points.
    has_kinks: bool,
    /// The piece in which it is kept; `None` to take that of each number.
    kept: Option<usize>,
}

/// A cubic from a point on.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Piece {
    from: f64,
    coefficients: [f64; 4],
    /// The integral from the first point to `from`.
    area: f64,
}

impl Table {
    /// The shortest of the intervals between its points, but no shorter than a thousandth of them all.
    pub fn shortest_interval(&self) -> f64 {
        let whole = self.at.last().zip(self.at.first()).map_or(f64::INFINITY, |(to, from)| to - from);
        let each = self.at.windows(2).map(|pair| pair[1] - pair[0]);
        each.fold(f64::INFINITY, f64::min).max(1e-3 * whole)
    }

    /// From its first to its last point: a straight line continues it beyond them.
    pub fn span(&self) -> [f64; 2] {
        let end = |of: Option<&f64>| of.copied().unwrap_or(0.0);
        [end(self.at.first()), end(self.at.last())]
    }

    /// What is wrong with points `[x, f]`.
    pub fn check(points: &[[f64; 2]]) -> Option<BadPoint> {
        let bad = |index, message, help| Some(BadPoint { index, message, help });
        if points.len() < 2 {
            let message = if points.is_empty() { "has no points" } else { "has only one point" };
            return bad(None, message.to_owned(), "a curve needs two points or more");
        }
        for (index, [x, f]) in points.iter().enumerate() {
            if !(x.is_finite() && f.is_finite()) {
                return bad(Some(index), format!("has the point [{x}, {f}]"), "give finite numbers");
            }
            if index > 0 && *x <= points[index - 1][0] {
                let message = format!("has {x} after {}", points[index - 1][0]);
                return bad(Some(index), message, "the first numbers of the points must increase");
            }
        }
        None
    }

    /// Compiles points that have passed the check.
    pub fn new(points: &[[f64; 2]], interpolation: Interpolation) -> Self {
        let chords: Vec<[f64; 2]> = points
            .windows(2)
            .map(|pair| {
                let h = pair[1][0] - pair[0][0];
                [h, (pair[1][1] - pair[0][1]) / h]
            })
            .collect();
        let last = chords.len() - 1;
        let slopes = match interpolation {
            Interpolation::Smooth => smooth(&chords),
            Interpolation::Linear => (0..=chords.len()).map(|k| chords[k.min(last)][1]).collect(),
        };
        let line = |[x, f]: [f64; 2], slope: f64| Piece { from: x, coefficients: [f, slope, 0.0, 0.0], area: 0.0 };
        let mut pieces = vec![line(points[0], slopes[0])];
        for (k, [h, slope]) in chords.iter().copied().enumerate() {
            let mut piece = line(points[k], slope);
            if interpolation == Interpolation::Smooth {
                let [m, n] = [slopes[k], slopes[k + 1]];
                piece.coefficients[1..].copy_from_slice(&[
                    m,
                    (3.0 * slope - 2.0 * m - n) / h,
                    (m + n - 2.0 * slope) / (h * h),
                ]);
            }
            piece.area = if k == 0 { 0.0 } else { pieces[k].integral(points[k][0]) };
            pieces.push(piece);
        }
        let mut end = line(points[last + 1], slopes[last + 1]);
        end.area = pieces[last + 1].integral(end.from);
        pieces.push(end);
        let at = points.iter().map(|point| point[0]).collect();
        let has_kinks = interpolation == Interpolation::Linear;
        let mut table = Self { at, pieces, origin: 0.0, has_kinks, kept: None };
        table.origin = table.piece(0.0).integral(0.0);
        table
    }

    fn piece(&self, x: f64) -> &Piece {
        &self.pieces[self.kept.unwrap_or_else(|| self.index(x))]
    }

    fn index(&self, x: f64) -> usize {
        self.at.partition_point(|at| *at <= x)
    }

    /// The kinks at the ends of the piece in which the table is kept, by the index of their points.
    pub fn kinks(&self) -> [Option<usize>; 2] {
        let piece = self.kept.unwrap_or(0);
        match self.has_kinks {
            true => [piece.checked_sub(1), (piece < self.at.len()).then_some(piece)],
            false => [None; 2],
        }
    }

    /// Where the kink at a point is.
    pub fn kink(&self, point: usize) -> f64 {
        self.at[point]
    }

    /// Keeps a table with kinks in the piece to which a number belongs, whatever the numbers are that follow.
    pub fn keep(&mut self, x: f64) {
        self.kept = self.has_kinks.then(|| self.index(x));
    }

    /// Whether the piece in which the table is kept is beyond a point.
    pub fn side(&self, point: usize) -> bool {
        self.kept.is_some_and(|piece| piece > point)
    }

    /// Keeps the table in the piece on the other side of a point at its end.
    pub fn cross(&mut self, point: usize) {
        self.kept = Some(if self.side(point) { point } else { point + 1 });
    }

    /// The force and its slope.
    pub fn value(&self, x: f64) -> [f64; 2] {
        let Piece { from, coefficients: [a, b, c, d], .. } = self.piece(x);
        let s = x - from;
        [a + s * (b + s * (c + s * d)), b + s * (2.0 * c + s * 3.0 * d)]
    }

    /// The integral of the force from zero on.
    pub fn integral(&self, x: f64) -> f64 {
        self.piece(x).integral(x) - self.origin
    }
}

impl Piece {
    /// From the first point of the table.
    fn integral(&self, x: f64) -> f64 {
        let [a, b, c, d] = self.coefficients;
        let s = x - self.from;
        self.area + s * (a + s * (b / 2.0 + s * (c / 3.0 + s * d / 4.0)))
    }
}

/// The slopes (1) and (2) at the points.
fn smooth(chords: &[[f64; 2]]) -> Vec<f64> {
    let [[_, only]] = chords else {
        let inner = chords.windows(2).map(|pair| {
            let [[h, before], [l, after]] = [pair[0], pair[1]];
            let (w, u) = (2.0 * l + h, l + 2.0 * h);
            if before * after <= 0.0 { 0.0 } else { (w + u) / (w / before + u / after) }
        });
        let n = chords.len();
        let first = end(chords[0], chords[1]);
        let last = end(chords[n - 1], chords[n - 2]);
        return std::iter::once(first).chain(inner).chain([last]).collect();
    };
    vec![*only; 2]
}

/// (2), from the chord at an end and the one next to it.
fn end([h, own]: [f64; 2], [l, next]: [f64; 2]) -> f64 {
    let slope = ((2.0 * h + l) * own - h * next) / (h + l);
    if slope * own <= 0.0 {
        0.0
    } else if own * next <= 0.0 && slope.abs() > 3.0 * own.abs() {
        3.0 * own
    } else {
        slope
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of SciPy's `PchipInterpolator`, which has the same slopes.
    #[test]
    fn smooth_tables_have_the_slopes_of_the_literature() {
        let table = Table::new(&[[0.0, 0.0], [1.0, 2.0], [3.0, 3.0], [4.0, 3.0], [5.0, -1.0]], Interpolation::Smooth);
        for (x, expected) in SCIPY {
            let [value, slope] = table.value(x);
            assert!((value - expected[0]).abs() < 1e-14 && (slope - expected[1]).abs() < 1e-14, "{x}: {value} {slope}");
        }
    }

    const SCIPY: [(f64, [f64; 2]); 12] = [
        (0.0, [0.0, 2.5]),
        (0.25, [0.6238839285714285, 2.4508928571428568]),
        (0.9, [1.8970714285714285, 1.195]),
        (1.0, [2.0, 0.8571428571428571]),
        (1.5, [2.3973214285714284, 0.7232142857142857]),
        (2.7, [2.9720357142857146, 0.1832142857142856]),
        (3.0, [3.0, 0.0]),
        (3.5, [3.0, 0.0]),
        (4.0, [3.0, 0.0]),
        (4.2, [2.776, -2.160000000000002]),
        (4.99, [-0.9400020000000018, -5.9994]),
        (5.0, [-1.0, -6.0]),
    ];

    /// Slope and integral against differences, on both sides of every point and beyond the ends.
    #[test]
    fn the_slope_is_the_derivative_and_the_integral_its_inverse() {
        for interpolation in [Interpolation::Smooth, Interpolation::Linear] {
            let table = Table::new(&[[-2.0, -1.0], [-0.5, -0.9], [0.25, 3.0], [1.0, 2.0]], interpolation);
            assert_eq!(table.integral(0.0), 0.0);
            for k in -40..40 {
                let (x, h) = (0.1 * f64::from(k) + 0.013, 1e-5);
                let by_differences = (table.value(x + h)[0] - table.value(x - h)[0]) / (2.0 * h);
                let inside = (table.integral(x + h) - table.integral(x - h)) / (2.0 * h);
                let [value, slope] = table.value(x);
                // Differences err by h² and by round-off over h.
                assert!((slope - by_differences).abs() < 1e-8, "{x}: {slope} {by_differences}");
                assert!((value - inside).abs() < 1e-8, "{x}: {value} {inside}");
            }
        }
    }

    /// Random rising tables rise everywhere, and go through their points.
    #[test]
    fn smooth_tables_rise_with_their_points() {
        let mut state = 7_u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / (1_u64 << 31) as f64
        };
        for count in 2..60 {
            let (mut x, mut f) = (-1.0, -1.0);
            let mut points = Vec::new();
            for _ in 0..count {
                x += 1e-3 + random();
                f += random().powi(6);
                points.push([x, f]);
            }
            let table = Table::new(&points, Interpolation::Smooth);
            for pair in points.windows(2) {
                assert!((table.value(pair[1][0])[0] - pair[1][1]).abs() < 1e-12);
                for part in 0..20 {
                    let [_, slope] = table.value(pair[0][0] + f64::from(part) / 20.0 * (pair[1][0] - pair[0][0]));
                    // Round-off of the coefficients of a short piece.
                    assert!(slope > -1e-9, "{points:?}: {slope}");
                }
            }
        }
    }
}
