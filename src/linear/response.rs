//! The frequency response, with its limits where the equations have a motion of that very frequency: at 0 Hz what drifts, the targets
//! of drives above all, which are double integrators.
//!
//! ```text
//! (1)  G(s) = C (s − A)⁻¹ B + D
//! (2)  Qᴴ (A − s₀) Q = [ T S ; 0 R ],     T nilpotent, R regular
//! (3)  X = (S + T X) R⁻¹
//! (4)  G(s) = Σₖ C Q₁ Tᵏ (Q₁ᴴ − X Q₂ᴴ) B / (s − s₀)ᵏ⁺¹  +  D − C (Q₁ X + Q₂) R⁻¹ Q₂ᴴ B  +  O(s − s₀)
//! ```
//!
//! (4) is the Laurent series of the resolvent, which the Drazin inverse of `A − s₀` gives (Campbell and Meyer, *Generalized Inverses of
//! Linear Transformations*, 1979; Kato, *Perturbation Theory for Linear Operators*, I.5.3). (2) is the staircase form of Kublanovskaya
//! (1966) by singular values (Golub and Wilkinson 1976), of the states balanced as Parlett and Reinsch (1969) do; (3) ends after as
//! many rounds as `T` has steps. A pair of an input and an output has a finite limit if its coefficients of negative powers vanish: poles
//! and zeros cancel.

use super::{Signal, StateSpace};
use crate::round_off::SINGULAR_VALUE;
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};

impl Signal {
    /// Whether this input is the acceleration of a drive's target.
    fn is_acceleration(&self) -> bool {
        matches!(self.unit.as_str(), "m/s²" | "rad/s²")
    }
}

impl StateSpace {
    /// The frequency response `C (iω − A)⁻¹ B + D` at a circular frequency (rad/s).
    ///
    /// Where the equations swing freely with that frequency it is the limit. Of what grows without bound there it is infinite, along the
    /// axis that its phase tends to; no entry is NaN.
    pub fn response(&self, omega: f64) -> Mat<c64> {
        self.swing(omega, false)
    }

    /// The frequency response in which drives count by how far their targets move, in place of the acceleration: times `−ω²`.
    pub fn transmissibility(&self, omega: f64) -> Mat<c64> {
        self.swing(omega, true)
    }

    /// The response; with `displacement` of drives by how far they move.
    fn swing(&self, omega: f64, displacement: bool) -> Mat<c64> {
        let is_moved = |j: usize| displacement && self.inputs[j].is_acceleration();
        if omega != 0.0 {
            let plain = self.plain(omega);
            if plain.col_iter().all(|column| column.iter().all(|x| x.is_finite())) {
                return Mat::from_fn(plain.nrows(), plain.ncols(), |i, j| {
                    plain[(i, j)] * if is_moved(j) { -omega * omega } else { 1.0 }
                });
            }
        }
        let series = Laurent::about(self, omega);
        Mat::from_fn(self.c.nrows(), self.b.ncols(), |i, j| {
            // At 0 the square of s takes two of the powers.
            let (taken, by) = match is_moved(j) {
                true if omega == 0.0 => (2, 1.0),
                true => (0, -omega * omega),
                false => (0, 1.0),
            };
            series.limit(i, j, taken) * by
        })
    }

    /// (1) by one factorization.
    fn plain(&self, omega: f64) -> Mat<c64> {
        let n = self.a.nrows();
        let shifted = Mat::from_fn(n, n, |i, j| c64::new(-self.a[(i, j)], if i == j { omega } else { 0.0 }));
        let x = shifted.partial_piv_lu().solve(complex(&self.b));
        complex(&self.c) * x + complex(&self.d)
    }
}

fn complex(m: &Mat<f64>) -> Mat<c64> {
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| c64::new(m[(i, j)], 0.0))
}

/// The sizes of all entries.
fn sizes(m: &Mat<c64>) -> Mat<f64> {
    Mat::from_fn(m.nrows(), m.ncols(), |i, j| m[(i, j)].norm())
}

/// Coefficients of one power, and what they are wrong by: `part · (condition · turned + summed)`.
struct Coefficient {
    value: Mat<c64>,
    /// Sizes of the terms whose sums the entries are, if the null spaces turn.
    turned: Mat<f64>,
    /// Likewise of the round-off of `T`.
    summed: Mat<f64>,
}

const NOTHING: c64 = c64::new(0.0, 0.0);

/// (4)
struct Laurent {
    /// The coefficients of the powers −1, −2, ….
    poles: Vec<Coefficient>,
    /// That of the power 0.
    regular: Coefficient,
    /// Round-off of a sum, as part of its terms.
    part: f64,
    /// By how much (2) and (3) enlarge it.
    condition: f64,
    /// Whether `s₀` is 0: then all coefficients are real.
    is_real: bool,
}

impl Laurent {
    /// About `s₀ = iω`.
    fn about(space: &StateSpace, omega: f64) -> Self {
        let n = space.a.nrows();
        let scales = balanced(&space.a);
        let a = Mat::from_fn(n, n, |i, j| {
            let shift = if i == j { omega } else { 0.0 };
            c64::new(space.a[(i, j)] * (scales[j] / scales[i]), -shift)
        });
        let b = Mat::from_fn(n, space.b.ncols(), |i, j| c64::new(space.b[(i, j)] / scales[i], 0.0));
        let c = Mat::from_fn(space.c.nrows(), n, |i, j| c64::new(space.c[(i, j)] * scales[j], 0.0));
        let stairs = Staircase::of(a);
        let (q, m) = (&stairs.turn, stairs.nilpotent);
        let [t, s, r] = [((0, 0), (m, m)), ((0, m), (m, n - m)), ((m, m), (n - m, n - m))]
            .map(|((i, j), (rows, columns))| stairs.form.submatrix(i, j, rows, columns).to_owned());
        let [q1, q2] = [(0, m), (m, n - m)].map(|(j, columns)| q.subcols(j, columns).to_owned());
        // X R = S + T X, transposed as the factorization takes it.
        let lu = r.transpose().to_owned().partial_piv_lu();
        let mut x: Mat<c64> = Mat::zeros(m, n - m);
        for _ in 0..stairs.steps {
            x = lu.solve((&s + &t * &x).transpose().to_owned()).transpose().to_owned();
        }
        let [b1, b2] = [&q1, &q2].map(|q| q.adjoint() * &b);
        // Q is wrong by as much in each of its entries, however small that is.
        let [b1_terms, b2_terms] = [m, n - m].map(|rows| Mat::<f64>::ones(rows, n) * sizes(&b));
        let [c1, c2] = [&q1, &q2].map(|q| &c * q);
        let [c1_terms, c2_terms] = [m, n - m].map(|columns| sizes(&c) * Mat::<f64>::ones(n, columns));
        let answer = r.partial_piv_lu().solve(&b2);
        let d = complex(&space.d);
        let regular = Coefficient {
            turned: sizes(&d) + (&c1_terms * sizes(&x) + c2_terms) * sizes(&answer),
            summed: Mat::zeros(d.nrows(), d.ncols()),
            value: d - (&c1 * &x + c2) * answer,
        };
        let t_terms = Mat::from_fn(m, m, |_, _| stairs.largest);
        let mut chain = Coefficient {
            value: b1 - &x * b2,
            turned: b1_terms + sizes(&x) * b2_terms,
            summed: Mat::zeros(m, b.ncols()),
        };
        let mut poles = Vec::with_capacity(stairs.steps);
        for _ in 0..stairs.steps {
            poles.push(Coefficient {
                value: &c1 * &chain.value,
                turned: sizes(&c1) * &chain.turned + &c1_terms * sizes(&chain.value),
                summed: sizes(&c1) * &chain.summed,
            });
            chain = Coefficient {
                turned: sizes(&t) * &chain.turned,
                summed: sizes(&t) * &chain.summed + &t_terms * sizes(&chain.value),
                value: &t * &chain.value,
            };
        }
        let part = SINGULAR_VALUE.of(n.max(1) as f64);
        Self { poles, regular, part, condition: stairs.condition, is_real: omega == 0.0 }
    }

    /// The limit of an entry of `G(s) (s − s₀)ᵗᵃᵏᵉⁿ`.
    fn limit(&self, i: usize, j: usize, taken: usize) -> c64 {
        for (k, pole) in self.poles.iter().enumerate().skip(taken).rev() {
            let x = self.entry(pole, i, j, self.condition);
            if x != NOTHING {
                // Along s = s₀ + iε: the powers of −i.
                let (re, im) = match (k + 1 - taken) % 4 {
                    0 => (x.re, x.im),
                    1 => (x.im, -x.re),
                    2 => (-x.re, -x.im),
                    _ => (-x.im, x.re),
                };
                return infinite(re, im);
            }
        }
        let finite = match taken.checked_sub(1) {
            None => self.entry(&self.regular, i, j, 1.0),
            Some(at) => self.poles.get(at).map_or(NOTHING, |pole| self.entry(pole, i, j, 1.0)),
        };
        if finite.is_finite() { finite } else { infinite(finite.re, finite.im) }
    }

    /// An entry; 0 if it is no more than the round-off of its terms with this condition.
    fn entry(&self, of: &Coefficient, i: usize, j: usize, condition: f64) -> c64 {
        let x = of.value[(i, j)];
        match x.norm() <= self.part * (condition * of.turned[(i, j)] + of.summed[(i, j)]) {
            true => NOTHING,
            false => c64::new(x.re, if self.is_real { 0.0 } else { x.im }),
        }
    }
}

/// Infinite along the axis that is nearest to a direction: ∞ times a small part is no direction.
fn infinite(re: f64, im: f64) -> c64 {
    match re.abs() >= im.abs() {
        true => c64::new(f64::INFINITY.copysign(re), 0.0),
        false => c64::new(0.0, f64::INFINITY.copysign(im)),
    }
}

/// (2)
struct Staircase {
    /// `Q`.
    turn: Mat<c64>,
    /// The right side of (2).
    form: Mat<c64>,
    /// Rows of `T`, and the most of its powers that do not vanish.
    nilpotent: usize,
    steps: usize,
    /// The largest singular value of `A − s₀`, and that over the smallest of `R`.
    largest: f64,
    condition: f64,
}

impl Staircase {
    /// Deflates null spaces until what is left has none. Singular values within the round-off of the largest entry are zero.
    fn of(a: Mat<c64>) -> Self {
        let n = a.nrows();
        let mut found =
            Self { turn: Mat::identity(n, n), form: a, nilpotent: 0, steps: 0, largest: 0.0, condition: 1.0 };
        while found.nilpotent < n {
            let m = found.nilpotent;
            let rest = found.form.submatrix(m, m, n - m, n - m).to_owned();
            let Ok(svd) = rest.svd() else { return found };
            let values: Vec<f64> = svd.S().column_vector().iter().map(|x| x.re).collect();
            if m == 0 {
                found.largest = values.first().copied().unwrap_or(0.0);
            }
            let zero = SINGULAR_VALUE.of(n as f64 * found.largest);
            let count = values.iter().filter(|x| **x <= zero).count();
            let Some(smallest) = values.iter().rfind(|x| **x > zero) else {
                // All that is left is zero.
                found.steps += 1;
                found.nilpotent = n;
                found.form.submatrix_mut(m, m, n - m, n - m).fill(NOTHING);
                break;
            };
            if count == 0 {
                found.condition = found.largest / smallest;
                break;
            }
            // The null space first.
            let v = svd.V();
            let turn = Mat::from_fn(n - m, n - m, |i, j| v[(i, n - m - 1 - j)]);
            let above = found.form.submatrix(0, m, m, n - m) * &turn;
            let inner = turn.adjoint() * &rest * &turn;
            let own = found.turn.subcols(m, n - m) * &turn;
            found.form.submatrix_mut(0, m, m, n - m).copy_from(&above);
            found.form.submatrix_mut(m, m, n - m, n - m).copy_from(&inner);
            found.form.submatrix_mut(m, m, n - m, count).fill(NOTHING);
            found.turn.subcols_mut(m, n - m).copy_from(&own);
            found.nilpotent += count;
            found.steps += 1;
        }
        found
    }
}

/// Powers of two by which states are measured, so that the rows and columns of the matrix are of one size. Parlett and Reinsch: what
/// gains less than a twentieth is left as it is, so that it comes to an end.
fn balanced(a: &Mat<f64>) -> Vec<f64> {
    const GAIN: f64 = 0.95;
    let n = a.nrows();
    let mut scales = vec![1.0_f64; n];
    loop {
        let mut is_done = true;
        for i in 0..n {
            let others = || (0..n).filter(|j| *j != i);
            let column: f64 = others().map(|j| a[(j, i)].abs() * scales[i] / scales[j]).sum();
            let row: f64 = others().map(|j| a[(i, j)].abs() * scales[j] / scales[i]).sum();
            let by = (0.5 * (row / column).log2()).round();
            if !by.is_finite() {
                continue;
            }
            let by = by.exp2();
            if column * by + row / by < GAIN * (column + row) {
                scales[i] *= by;
                is_done = false;
            }
        }
        if is_done {
            return scales;
        }
    }
}
