//! Roots of the linearized motion `M ẍ + C ẋ + K x = 0`: the numbers `s` with `x e^(st)`, and which of them grow.
//!
//! In units of the mass, `M = B Bᵀ`, `x = B⁻ᵀ z`, `K' = B⁻¹ K B⁻ᵀ`, `C' = B⁻¹ C B⁻ᵀ`, and lengths of time in units of `1/ω`, `ω² = |K'|`:
//!
//! ```text
//!      [  0      ω 1 ]
//! s =  [             ],   y = (ω z, ż)                                                            (1)
//!      [ −K'/ω  −C'  ]
//! ```
//!
//! What the energy `ẋᵀ M ẋ/2 + xᵀ K x/2` says needs no roots. If `K` is symmetric and positive definite it has its minimum at rest,
//! and it changes by `−ẋᵀ D ẋ` with the symmetric part `D` of `C`; Coriolis forces, the other part `G`, do no work. With `D = 0` it is
//! kept, with `D ≥ 0` it falls, and nothing grows, however `G` couples motions of nearly one frequency (Kelvin, Tait, Chetaev). With
//! `K = L Lᵀ` and the state `(Lᵀ x, Bᵀ ẋ)`, whose square is the energy, the motion that keeps it is skew, and its roots are imaginary:
//!
//! ```text
//!      [  0    P   ]
//! s =  [           ],   P = Lᵀ B⁻ᵀ,   G' = B⁻¹ G B⁻ᵀ;   i·(2) is Hermitian                          (2)
//!      [ −Pᵀ  −G'  ]
//! ```
//!
//! Elsewhere a root of the matrix (1), `A`, with right and left vectors `x` and `y` is known to
//!
//! ```text
//! |δs| ≤ |δA| |y| |x| / |yᴴ x|                                                                    (3)
//! ```
//!
//! (Wilkinson's condition number; Golub & Van Loan, §7.2.2) if it is simple, a double one to the square root of a unit in the last place: slower
//! growth than the smaller of both is not known to be any.

use super::eigen;
use crate::dynamics::Linearization;
use crate::round_off::{CLOSED_STIFFNESS, DOUBLE_ROOT, FORCE, POWER};
use crate::statics::problem::sizes::{comparable, count_by_stiffness, symmetric};
use faer::linalg::solvers::Solve;
use faer::linalg::triangular_solve::{solve_lower_triangular_in_place, solve_upper_triangular_in_place};
use faer::{Mat, Par, Side, c64};

/// Motions that grow faster than this part of their `|s|` run away: what is less is the round-off of a double root.
const GROWS: f64 = 1e-6;

/// A root, one of each conjugate pair, with the real and the imaginary part of its `x`.
#[derive(Clone)]
pub(super) struct Root {
    pub value: c64,
    pub parts: [Vec<f64>; 2],
}

/// What the energy says of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Energy {
    /// It has a minimum at rest, and nothing changes it.
    Kept,
    /// It has a minimum at rest, and nothing feeds it.
    Falls,
    /// It has a minimum at rest, and something feeds it.
    Fed,
    /// Nothing is known of it.
    Open,
}

/// A linearized motion.
pub(in crate::statics) struct LinearMotion {
    linear: Linearization,
    energy: Energy,
}

impl LinearMotion {
    /// `sizes` are those of the stiffness terms.
    pub(in crate::statics) fn new(linear: &Linearization, sizes: &[f64]) -> Self {
        Self { linear: linear.clone(), energy: energy(linear, sizes) }
    }

    /// Nothing is asked of the energy.
    pub(super) fn open(linear: &Linearization) -> Self {
        Self { linear: linear.clone(), energy: Energy::Open }
    }

    /// The roots with the part of `C` alone that does no work: their mirror images are roots, too, so that what is not known to grow
    /// does not decay either.
    pub(super) fn undamped_roots(&self) -> Vec<Root> {
        let mut roots = self.undamped().roots();
        let least = roots.iter().map(|root| root.value.re).filter(|re| *re > 0.0).fold(f64::INFINITY, f64::min);
        for root in &mut roots {
            // The mirror image of what grows decays as fast.
            if -root.value.re < 0.5 * least {
                root.value.re = root.value.re.max(0.0);
            }
        }
        roots
    }

    /// The motion with the part of `C` alone that does no work.
    fn undamped(&self) -> Self {
        let c = &self.linear.damping;
        let damping = Mat::from_fn(c.nrows(), c.ncols(), |i, j| 0.5 * (c[(i, j)] - c[(j, i)]));
        let energy = if self.energy == Energy::Open { Energy::Open } else { Energy::Kept };
        Self { linear: Linearization { damping, ..self.linear.clone() }, energy }
    }

    /// Whether the energy says that nothing grows.
    fn bounded(&self) -> bool {
        matches!(self.energy, Energy::Kept | Energy::Falls)
    }

    /// How many motions grow, and how many neither grow nor swing.
    pub(in crate::statics) fn count(&self) -> (usize, usize) {
        if self.bounded() {
            return (0, 0);
        }
        let roots = self.roots();
        let unstable = roots.iter().filter(|root| root.value.re > 0.0).count();
        let neutral = roots.iter().filter(|root| root.value == c64::new(0.0, 0.0)).count();
        (unstable, neutral.div_ceil(2))
    }

    /// All roots. The real part of those that are not known to grow is not positive.
    pub(super) fn roots(&self) -> Vec<Root> {
        let kept = (self.energy == Energy::Kept).then(|| kept(&self.linear)).flatten();
        let mut roots = kept.unwrap_or_else(|| in_units_of_mass(&self.linear));
        if self.bounded() {
            roots.iter_mut().for_each(|root| root.value.re = root.value.re.min(0.0));
        }
        roots
    }
}

/// What the energy of a motion does.
fn energy(linear: &Linearization, sizes: &[f64]) -> Energy {
    let Linearization { mass, damping, stiffness } = linear;
    let n = mass.nrows();
    let root: Vec<f64> = (0..n).map(|i| mass[(i, i)].sqrt()).collect();
    if n == 0 || !root.iter().all(|x| *x > 0.0) {
        return Energy::Open;
    }
    let rates = Mat::from_fn(n, n, |i, j| damping[(i, j)] / root[i] / root[j]);
    let fastest = rates.norm_max();
    // Inertia forces of a steady motion are terms, too.
    let terms: Vec<f64> = comparable(sizes).iter().zip(&root).map(|(k, m)| k.sqrt() + fastest * m).collect();
    let round_off = FORCE.of(n as f64).max(CLOSED_STIFFNESS.of(1.0));
    let circulates =
        |i: usize, j: usize| !((stiffness[(i, j)] - stiffness[(j, i)]).abs() <= round_off * terms[i] * terms[j]);
    let somewhere = (0..n).any(|i| (0..i).any(|j| circulates(i, j)));
    if somewhere || count_by_stiffness(&symmetric(stiffness), sizes) != (0, 0) {
        return Energy::Open;
    }
    let power = symmetric(&rates);
    match power.norm_max() <= POWER.of(fastest) {
        true => Energy::Kept,
        false if takes(&power) => Energy::Falls,
        false => Energy::Fed,
    }
}

/// Whether forces that go with speeds, by this symmetric matrix, feed no motion.
fn takes(power: &Mat<f64>) -> bool {
    let least = POWER.of(power.norm_max());
    power.self_adjoint_eigenvalues(Side::Lower).is_ok_and(|values| values.iter().all(|x| *x >= -least))
}

/// Whether forces that go with speeds feed some motion.
pub(super) fn is_fed(linear: &Linearization) -> bool {
    let root: Vec<f64> = (0..linear.mass.nrows()).map(|i| linear.mass[(i, i)].sqrt()).collect();
    let rates = Mat::from_fn(root.len(), root.len(), |i, j| linear.damping[(i, j)] / root[i] / root[j]);
    !root.is_empty() && !takes(&symmetric(&rates))
}

/// `B⁻¹ A`
fn forward(lower: &Mat<f64>, a: &Mat<f64>) -> Mat<f64> {
    let mut x = a.clone();
    solve_lower_triangular_in_place(lower.as_ref(), x.as_mut(), Par::Seq);
    x
}

/// `B⁻ᵀ x` of both parts.
fn back(lower: &Mat<f64>, parts: [Vec<f64>; 2]) -> [Vec<f64>; 2] {
    let n = lower.nrows();
    let mut x = Mat::from_fn(n, 2, |i, j| parts[j][i]);
    solve_upper_triangular_in_place(lower.transpose(), x.as_mut(), Par::Seq);
    [0, 1].map(|j| (0..n).map(|i| x[(i, j)]).collect())
}

/// Lower triangular `B` with `B Bᵀ` this matrix, if that is positive definite.
fn root(matrix: &Mat<f64>) -> Option<Mat<f64>> {
    let factor = symmetric(matrix).llt(Side::Lower).ok()?;
    let lower = factor.L();
    let n = matrix.nrows();
    Some(Mat::from_fn(n, n, |i, j| if j > i { 0.0 } else { lower[(i, j)] }))
}

/// The roots of (2).
fn kept(linear: &Linearization) -> Option<Vec<Root>> {
    let n = linear.mass.nrows();
    let (b, l) = (root(&linear.mass)?, root(&linear.stiffness)?);
    // Pᵀ
    let p = forward(&b, &l);
    let c = forward(&b, &forward(&b, &linear.damping).transpose().to_owned());
    // `C'` comes out transposed.
    let gyroscopic = |i: usize, j: usize| 0.5 * (c[(j, i)] - c[(i, j)]);
    let hermitian = Mat::from_fn(2 * n, 2 * n, |i, j| {
        let entry = match (i < n, j < n) {
            (true, true) => 0.0,
            (true, false) => p[(j - n, i)],
            (false, true) => -p[(i - n, j)],
            (false, false) => -gyroscopic(i - n, j - n),
        };
        c64::new(0.0, entry)
    });
    let eigen = hermitian.self_adjoint_eigen(Side::Lower).ok()?;
    // Of i·(2) the values are i s, ascending: the first half has Im s > 0.
    let one = |k: usize| {
        let part = |of: fn(c64) -> f64| (0..n).map(|i| of(eigen.U()[(i, k)])).collect::<Vec<f64>>();
        let parts = back(&l, [part(|z| z.re), part(|z| z.im)]);
        Root { value: c64::new(0.0, -eigen.S()[k].re), parts }
    };
    let roots: Vec<Root> = (0..n).map(one).collect();
    roots.iter().all(|root| root.value.im > 0.0).then_some(roots)
}

/// The roots of (1); where there is no `B` with `M⁻¹ K` and `M⁻¹ C` in the place of `K'` and `C'`.
fn in_units_of_mass(linear: &Linearization) -> Vec<Root> {
    let Some(b) = root(&linear.mass) else {
        let lu = linear.mass.partial_piv_lu();
        return of(&lu.solve(&linear.stiffness), &lu.solve(&linear.damping));
    };
    let both = |m: &Mat<f64>| forward(&b, &forward(&b, m).transpose().to_owned()).transpose().to_owned();
    let found = of(&both(&linear.stiffness), &both(&linear.damping));
    found.into_iter().map(|Root { value, parts }| Root { value, parts: back(&b, parts) }).collect()
}

/// Roots of (1), one of each pair; a root that is zero stands as often as it is one.
pub(super) fn of(k: &Mat<f64>, c: &Mat<f64>) -> Vec<Root> {
    let n = k.nrows();
    let largest = (0..n).map(|i| (0..n).map(|j| k[(i, j)].abs()).sum::<f64>()).fold(0.0, f64::max);
    let unit = if largest > 0.0 { largest.sqrt() } else { 1.0 };
    let mut found = if c.norm_max() == 0.0 { of_stiffness(k) } else { of_both(k, c, unit) };
    let sizes: Vec<f64> = found.roots.iter().map(|root| root.value.re.hypot(root.value.im)).collect();
    let fastest = sizes.iter().copied().fold(0.0, f64::max);
    let of_double = |size: f64| {
        (GROWS * size).max(FORCE.of(fastest)).max(DOUBLE_ROOT.of(unit).powi(2) / size.max(f64::MIN_POSITIVE))
    };
    let double: Vec<f64> = sizes.iter().map(|size| of_double(*size)).collect();
    let is_open = found.roots.iter().zip(&double).any(|(root, noise)| root.value.re > 0.0 && root.value.re <= *noise);
    let simple = if is_open { found.noise() } else { None };
    let mut known = Vec::new();
    for (i, Root { value, parts }) in found.roots.drain(..).enumerate() {
        if !(sizes[i] > DOUBLE_ROOT.of(unit)) {
            let count = if value.im == 0.0 { 1 } else { 2 };
            known.extend(std::iter::repeat_n(Root { value: c64::new(0.0, 0.0), parts }, count));
            continue;
        }
        let noise = simple.as_ref().map_or(double[i], |simple| simple[i].min(double[i]));
        let re = if value.re > noise { value.re } else { value.re.min(0.0) };
        known.push(Root { value: c64::new(re, value.im), parts });
    }
    known
}

/// Roots as they come out, with the matrix (1) and its vectors where that was solved.
#[derive(Default)]
struct Found {
    roots: Vec<Root>,
    matrix: Option<Mat<f64>>,
    /// Of all roots, columns.
    vectors: Vec<Vec<c64>>,
    /// Which of them the roots have.
    columns: Vec<usize>,
}

impl Found {
    /// (3) for every root, infinite for one that is not simple.
    fn noise(&self) -> Option<Vec<f64>> {
        let n = self.vectors.len();
        let error = FORCE.of(n as f64) * self.matrix.as_ref()?.norm_l2();
        let x = Mat::from_fn(n, n, |i, j| self.vectors[j][i]);
        // With yᴴ x = 1.
        let y = x.partial_piv_lu().solve(Mat::<c64>::identity(n, n));
        let noise = |column: &usize| {
            let bound = error * y.row(*column).norm_l2() * x.col(*column).norm_l2();
            if bound.is_finite() { bound } else { f64::INFINITY }
        };
        Some(self.columns.iter().map(noise).collect())
    }
}

fn of_both(k: &Mat<f64>, c: &Mat<f64>, unit: f64) -> Found {
    let n = k.nrows();
    let first_order = Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => 0.0,
        (true, false) => unit * f64::from(u8::from(i + n == j)),
        (false, true) => -k[(i - n, j)] / unit,
        (false, false) => -c[(i - n, j - n)],
    });
    let Some(pairs) = eigen::pairs(&first_order) else { return Found::default() };
    let mut found = Found { matrix: Some(first_order), ..Found::default() };
    for (column, (root, vector)) in pairs.into_iter().enumerate() {
        let swings = root.im.abs() > DOUBLE_ROOT.of(root.re.hypot(root.im));
        // One of each pair.
        if !swings || root.im > 0.0 {
            let value = if swings { root } else { c64::new(root.re, 0.0) };
            found.roots.push(Root { value, parts: parts(&vector[..n]) });
            found.columns.push(column);
        }
        found.vectors.push(vector);
    }
    found
}

/// Without damping half as many equations: `s = ± √(−λ)` for the eigenvalues λ of `K'`.
fn of_stiffness(k: &Mat<f64>) -> Found {
    let one = |(value, vector): (c64, Vec<c64>)| {
        let size = value.re.hypot(value.im);
        // The root with a real part that is not negative.
        let (re, im) = ((0.5 * (size - value.re)).max(0.0).sqrt(), (0.5 * (size + value.re)).max(0.0).sqrt());
        let parts = parts(&vector);
        // The pair of complex values λ is one pair of roots that grows and one that decays.
        let (value, other) = match value.im {
            0.0 if value.re > 0.0 => (c64::new(0.0, im), None),
            0.0 => (c64::new(re, 0.0), Some(c64::new(-re, 0.0))),
            part if part < 0.0 => (c64::new(re, im), None),
            _ => (c64::new(-re, im), None),
        };
        let second = other.map(|value| Root { value, parts: parts.clone() });
        std::iter::once(Root { value, parts }).chain(second)
    };
    let Some(pairs) = eigen::pairs(k) else { return Found::default() };
    Found { roots: pairs.into_iter().flat_map(one).collect(), ..Found::default() }
}

fn parts(vector: &[c64]) -> [Vec<f64>; 2] {
    [vector.iter().map(|x| x.re).collect(), vector.iter().map(|x| x.im).collect()]
}
