//! The exponential of a twist and its right trivialized tangent, without a division by a small angle.
//!
//! ```text
//! (1) c_k(x) = Σ (−x)ʲ/(2j + k)!,   c_k' = ½ (k c_{k+2} − c_{k+1}),   c_k = 1/k! − x c_{k+2}       Stumpff
//! (2) exp(v, w) = (R, p),   R = 1 + c₁ ŵ + c₂ ŵ²,   p = (1 + c₂ ŵ + c₃ ŵ²) v,   x = w·w
//! (3) A(w) = 1 − c₂ ŵ + c₃ ŵ²,   B(v, w) = [A, dA(w; v); 0, A] = Σ (−ad)ⁿ/(n+1)!
//! (4) A = 1 + ŝ + S,   s = −c₂ w,   S = c₃ (w wᵀ − x),   x' = 2 w·w'
//! ```
//!
//! SE(3) is SO(3) over dual numbers, so `B` is `A(w + εv)`. Derivatives of `A` are those of both parts of (4).

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// Stumpff functions `c₀ … c₉`.
type Stumpff = [f64; 10];

/// Beyond this the series needs too many terms and the closed forms are safe (rad²).
const FAR: f64 = 9.0;
/// Terms of the series at most: `9¹³/(26 + 8)!` is below 10⁻²⁵.
const TERMS: usize = 13;
/// Up to these x so many terms are enough: the first that is left out is less than 2·10⁻¹⁷ of the first.
const FEWER: [(f64, usize); 2] = [(0.01, 4), (0.25, 6)];
/// `1/k!`.
const INVERSE: [f64; 10] =
    [1.0, 1.0, 0.5, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0, 1.0 / 5040.0, 1.0 / 40320.0, 1.0 / 362_880.0];
/// `1/((2j + k − 1)(2j + k))` of `k` = 8 and 9.
const RATIOS: [[f64; 2]; TERMS] = {
    let mut ratios = [[0.0; 2]; TERMS];
    let mut j = 1;
    while j < TERMS {
        ratios[j] = [1.0 / ((2 * j + 7) * (2 * j + 8)) as f64, 1.0 / ((2 * j + 8) * (2 * j + 9)) as f64];
        j += 1;
    }
    ratios
};

/// Eq. (1).
fn stumpff(x: f64) -> Stumpff {
    let mut c = [0.0; 10];
    if x > FAR {
        let root = x.sqrt();
        (c[0], c[1]) = (root.cos(), root.sin() / root);
        for k in 2..10 {
            c[k] = (INVERSE[k - 2] - c[k - 2]) / x;
        }
        return c;
    }
    let terms = FEWER.iter().find(|(end, _)| x <= *end).map_or(TERMS, |(_, terms)| *terms);
    let mut sums = [1.0; 2];
    for ratios in RATIOS[1..terms].iter().rev() {
        sums = [0, 1].map(|k| 1.0 - x * ratios[k] * sums[k]);
    }
    (c[8], c[9]) = (sums[0] * INVERSE[8], sums[1] * INVERSE[9]);
    for k in (0..8).rev() {
        c[k] = INVERSE[k] - x * c[k + 2];
    }
    c
}

/// `c_k` and its first three derivatives by x, of `k` = 2 and 3.
fn derivatives(c: &Stumpff) -> [[f64; 4]; 2] {
    let first = |k: usize| 0.5 * (k as f64 * c[k + 2] - c[k + 1]);
    let second = |k: usize| 0.5 * (k as f64 * first(k + 2) - first(k + 1));
    let third = |k: usize| 0.5 * (k as f64 * second(k + 2) - second(k + 1));
    [2, 3].map(|k| [c[k], first(k), second(k), third(k)])
}

/// The two halves of a twist.
#[inline(always)]
pub(crate) fn halves(x: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (x.fixed_rows::<3>(0).into_owned(), x.fixed_rows::<3>(3).into_owned())
}

/// A twist or wrench of two halves.
#[inline(always)]
pub(crate) fn joined(linear: &Vector3<f64>, angular: &Vector3<f64>) -> Vector6<f64> {
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

/// `[x, y] = ad(x) y` of two twists.
pub(crate) fn bracket(x: &Vector6<f64>, y: &Vector6<f64>) -> Vector6<f64> {
    let ((v, w), (a, b)) = (halves(x), halves(y));
    joined(&(w.cross(&a) + v.cross(&b)), &w.cross(&b))
}

/// `[x, e]` of a twist and the unit twist of an index.
#[inline]
pub(crate) fn bracket_unit(x: &Vector6<f64>, index: usize) -> Vector6<f64> {
    let (v, w) = halves(x);
    match index {
        0 => Vector6::new(0.0, w.z, -w.y, 0.0, 0.0, 0.0),
        1 => Vector6::new(-w.z, 0.0, w.x, 0.0, 0.0, 0.0),
        2 => Vector6::new(w.y, -w.x, 0.0, 0.0, 0.0, 0.0),
        3 => Vector6::new(0.0, v.z, -v.y, 0.0, w.z, -w.y),
        4 => Vector6::new(-v.z, 0.0, v.x, -w.z, 0.0, w.x),
        _ => Vector6::new(v.y, -v.x, 0.0, w.y, -w.x, 0.0),
    }
}

/// Eq. (2).
pub(crate) fn exponential(twist: &Vector6<f64>) -> (Matrix3<f64>, Vector3<f64>) {
    let (v, w) = halves(twist);
    let c = stumpff(w.norm_squared());
    let (hat, wv) = (w.cross_matrix(), w.cross(&v));
    let turn = Matrix3::identity() + c[1] * hat + c[2] * (hat * hat);
    (turn, v + c[2] * wv + c[3] * w.cross(&wv))
}

/// A scalar with its first two derivatives in time, and the dual part of the same.
#[derive(Clone, Copy, Default)]
struct Jet {
    real: [f64; 3],
    dual: [f64; 3],
}

fn product(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[0] * b[0], a[1] * b[0] + a[0] * b[1], a[2] * b[0] + 2.0 * a[1] * b[1] + a[0] * b[2]]
}

impl Jet {
    fn times(&self, other: &Self) -> Self {
        let (one, two) = (product(&self.dual, &other.real), product(&self.real, &other.dual));
        Self { real: product(&self.real, &other.real), dual: std::array::from_fn(|i| one[i] + two[i]) }
    }

    fn plus(&self, other: &Self) -> Self {
        Self {
            real: std::array::from_fn(|i| self.real[i] + other.real[i]),
            dual: std::array::from_fn(|i| self.dual[i] + other.dual[i]),
        }
    }

    fn scaled(&self, s: f64) -> Self {
        Self { real: self.real.map(|x| s * x), dual: self.dual.map(|x| s * x) }
    }

    /// `f(self)` from the value and three derivatives of `f`.
    fn of(&self, f: &[f64; 4]) -> Self {
        let x = &self.real;
        let along = |k: usize| [f[k], f[k + 1] * x[1], f[k + 1] * x[2] + f.get(k + 2).unwrap_or(&0.0) * x[1] * x[1]];
        Self { real: along(0), dual: product(&along(1), &self.dual) }
    }
}

/// `B`, `Ḃ`, `B̈` of eq. (3) along a twist with its first two derivatives in time.
pub(crate) fn tangents(twist: &Vector6<f64>, rate: &Vector6<f64>, second: &Vector6<f64>) -> [Matrix6<f64>; 3] {
    let w: [Jet; 3] = std::array::from_fn(|i| Jet {
        real: [twist[3 + i], rate[3 + i], second[3 + i]],
        dual: [twist[i], rate[i], second[i]],
    });
    let squares = [0, 1, 2].map(|i| w[i].times(&w[i]));
    let x = squares[0].plus(&squares[1]).plus(&squares[2]);
    let [c2, c3] = derivatives(&stumpff(x.real[0])).map(|f| x.of(&f));
    let mut b = [Matrix6::zeros(); 3];
    for i in 0..3 {
        for j in 0..3 {
            let square = if i == j { squares[i].plus(&x.scaled(-1.0)) } else { w[i].times(&w[j]) };
            let mut entry = c3.times(&square);
            if i == j {
                entry.real[0] += 1.0;
            } else {
                // −ŵ: entry (i, j) of ŵ is −w_k for an even order i, j, k.
                let sign = if (i + 1) % 3 == j { 1.0 } else { -1.0 };
                entry = entry.plus(&c2.times(&w[3 - i - j]).scaled(sign));
            }
            for (order, b) in b.iter_mut().enumerate() {
                b[(i, j)] = entry.real[order];
                b[(i + 3, j + 3)] = entry.real[order];
                b[(i, j + 3)] = entry.dual[order];
            }
        }
    }
    b
}

/// A skew and a symmetric part of a matrix: `ŝ + S`.
#[derive(Clone, Copy)]
struct Parts {
    skew: Vector3<f64>,
    symmetric: Matrix3<f64>,
}

impl Parts {
    fn sum(&self) -> Matrix3<f64> {
        self.skew.cross_matrix() + self.symmetric
    }
}

/// `a bᵀ + b aᵀ − 2 (a·b)`.
fn both(a: &Vector3<f64>, b: &Vector3<f64>) -> Matrix3<f64> {
    let one = a * b.transpose();
    one + one.transpose() - Matrix3::from_diagonal_element(2.0 * a.dot(b))
}

/// `A(w)` of eq. (4) and its differentials along directions.
struct Differentials {
    w: Vector3<f64>,
    /// `c₂` and `c₃` with two derivatives by x.
    c2: [f64; 3],
    c3: [f64; 3],
    /// `w wᵀ − x`.
    square: Matrix3<f64>,
}

impl Differentials {
    fn at(w: Vector3<f64>) -> Self {
        let [[c2, d2, e2, _], [c3, d3, e3, _]] = derivatives(&stumpff(w.norm_squared()));
        Self { w, c2: [c2, d2, e2], c3: [c3, d3, e3], square: 0.5 * both(&w, &w) }
    }

    fn value(&self) -> Matrix3<f64> {
        Matrix3::identity() + Parts { skew: -self.c2[0] * self.w, symmetric: self.c3[0] * self.square }.sum()
    }

    fn first(&self, along: &Vector3<f64>) -> Matrix3<f64> {
        let x = 2.0 * self.w.dot(along);
        let skew = -(self.c2[1] * x * self.w + self.c2[0] * along);
        let symmetric = self.c3[1] * x * self.square + self.c3[0] * both(&self.w, along);
        Parts { skew, symmetric }.sum()
    }

    fn second(&self, a: &Vector3<f64>, b: &Vector3<f64>) -> Matrix3<f64> {
        let (w, [_, d2, e2], [c3, d3, e3]) = (&self.w, self.c2, self.c3);
        let [x, y, xy] = [2.0 * w.dot(a), 2.0 * w.dot(b), 2.0 * a.dot(b)];
        let skew = -((d2 * xy + e2 * x * y) * w + d2 * (x * b + y * a));
        let mixed = d3 * (x * both(w, b) + y * both(w, a)) + c3 * both(a, b);
        Parts { skew, symmetric: (d3 * xy + e3 * x * y) * self.square + mixed }.sum()
    }
}

/// `[a, b; 0, a]`.
fn dual(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Matrix6<f64> {
    let mut whole = Matrix6::zeros();
    whole.fixed_view_mut::<3, 3>(0, 0).copy_from(a);
    whole.fixed_view_mut::<3, 3>(3, 3).copy_from(a);
    whole.fixed_view_mut::<3, 3>(0, 3).copy_from(b);
    whole
}

/// `B` and `Ḃ` of eq. (3) along a twist with its rate.
pub(crate) fn tangent_and_rate(twist: &Vector6<f64>, rate: &Vector6<f64>) -> [Matrix6<f64>; 2] {
    let ((v, w), (v_rate, w_rate)) = (halves(twist), halves(rate));
    let a = Differentials::at(w);
    [dual(&a.value(), &a.first(&v)), dual(&a.first(&w_rate), &(a.first(&v_rate) + a.second(&v, &w_rate)))]
}

/// `B` of eq. (3) alone.
pub(crate) fn tangent(twist: &Vector6<f64>) -> Matrix6<f64> {
    let (v, w) = halves(twist);
    let a = Differentials::at(w);
    dual(&a.value(), &a.first(&v))
}

/// `∂(Bᵀ f)/∂Ω`, 6×6, for a wrench `f`: with `G(F) = ∂(Aᵀ F)/∂w` it is `[0, G(F); G(F), dG(F; v) + G(M)]`.
pub(crate) fn tangent_gradient(twist: &Vector6<f64>, wrench: &Vector6<f64>) -> Matrix6<f64> {
    let ((v, w), (force, moment)) = (halves(twist), halves(wrench));
    let [c2, c3] = derivatives(&stumpff(w.norm_squared()));
    let x = w.norm_squared();
    let swept = |f: &Vector3<f64>| (w.cross(f), w * w.dot(f) - x * f);
    let wide = |f: &Vector3<f64>| w * f.transpose() + w.dot(f) * Matrix3::identity() - 2.0 * f * w.transpose();
    let gradient = |f: &Vector3<f64>| {
        let (one, two) = swept(f);
        -c2[0] * f.cross_matrix() + c3[0] * wide(f) + 2.0 * (c2[1] * one + c3[1] * two) * w.transpose()
    };
    let by = w.dot(&v);
    let varied = |f: &Vector3<f64>| {
        let (one, two) = swept(f);
        let turned = 2.0 * by * (c2[2] * one + c3[2] * two)
            + c2[1] * v.cross(f)
            + c3[1] * (v * w.dot(f) + w * v.dot(f) - 2.0 * by * f);
        2.0 * by * (c3[1] * wide(f) - c2[1] * f.cross_matrix())
            + c3[0] * (v * f.transpose() + v.dot(f) * Matrix3::identity() - 2.0 * f * v.transpose())
            + 2.0 * (c2[1] * one + c3[1] * two) * v.transpose()
            + 2.0 * turned * w.transpose()
    };
    let of_force = gradient(&force);
    let mut all = Matrix6::zeros();
    all.fixed_view_mut::<3, 3>(0, 3).copy_from(&of_force);
    all.fixed_view_mut::<3, 3>(3, 0).copy_from(&of_force);
    all.fixed_view_mut::<3, 3>(3, 3).copy_from(&(varied(&force) + gradient(&moment)));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ad(x: &Vector6<f64>) -> Matrix6<f64> {
        Matrix6::from_fn(|i, j| bracket(x, &Vector6::ith(j, 1.0))[i])
    }

    /// Σ (−ad)ⁿ/(n+1)!, term by term.
    fn series(twist: &Vector6<f64>) -> Matrix6<f64> {
        let (minus, mut power, mut sum) = (-ad(twist), Matrix6::identity(), Matrix6::identity());
        for n in 1..60 {
            power = power * minus / f64::from(n + 1);
            sum += power;
        }
        sum
    }

    fn twists() -> impl Iterator<Item = Vector6<f64>> {
        let direction = Vector6::new(0.7, -0.4, 0.9, 0.5, -0.8, 0.3);
        [0.0, 1e-9, 1e-4, 0.3, 1.7, 2.9, 3.1, 5.0].into_iter().map(move |size| size * direction)
    }

    #[test]
    fn the_tangent_is_the_series_of_brackets() {
        for twist in twists() {
            (0..6).for_each(|k| assert_eq!(bracket_unit(&twist, k), bracket(&twist, &Vector6::ith(k, 1.0))));
            let scale = 1.0 + twist.norm();
            assert!((tangent(&twist) - series(&twist)).amax() < 1e-13 * scale * scale, "{twist}");
            let none = Vector6::zeros();
            assert!((tangents(&twist, &none, &none)[0] - tangent(&twist)).amax() < 1e-14 * scale, "{twist}");
        }
    }

    /// The exponential against a product of 2¹⁶ small steps of second order, to their error.
    #[test]
    fn the_exponential_is_a_product_of_small_steps() {
        for twist in twists() {
            let (mut turn, mut arm) = exponential(&(twist / 65536.0));
            for _ in 0..16 {
                (turn, arm) = (turn * turn, arm + turn * arm);
            }
            let (one, at) = exponential(&twist);
            assert!((one - turn).amax() < 1e-10 && (at - arm).amax() < 1e-10, "{twist}");
        }
    }

    #[test]
    fn rates_of_the_tangent_are_its_differences() {
        let (rate, second) =
            (Vector6::new(0.3, 0.2, -0.5, 0.4, 0.6, -0.2), Vector6::new(-0.1, 0.8, 0.3, 0.5, -0.3, 0.9));
        for twist in twists() {
            let at = |t: f64| tangent(&(twist + t * rate + 0.5 * t * t * second));
            let h = 1e-3;
            let [_, first, twice] = tangents(&twist, &rate, &second);
            let by_first = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
            let by_second = (16.0 * (at(h) + at(-h)) - at(2.0 * h) - at(-2.0 * h) - 30.0 * at(0.0)) / (12.0 * h * h);
            assert!((first - by_first).amax() < 1e-10, "{twist}");
            let [value, alone] = tangent_and_rate(&twist, &rate);
            let scale = 1.0 + twist.norm();
            assert!((value - at(0.0)).amax() == 0.0 && (alone - first).amax() < 1e-14 * scale * scale, "{twist}");
            assert!((twice - by_second).amax() < 1e-7, "{twist}");
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_transposed_tangent() {
        let f = Vector6::new(0.9, -1.2, 0.4, 0.3, 0.8, -0.6);
        for twist in twists() {
            let gradient = tangent_gradient(&twist, &f);
            let h = 1e-3;
            for j in 0..6 {
                let at = |t: f64| tangent(&(twist + t * Vector6::ith(j, 1.0))).transpose() * f;
                let by = (8.0 * (at(h) - at(-h)) - (at(2.0 * h) - at(-2.0 * h))) / (12.0 * h);
                assert!((gradient.column(j) - by).amax() < 1e-10, "{twist} {j}");
            }
        }
    }
}
