//! A step of an element of degree 2: the Magnus expansion of 6th order.
//!
//! With fourth order the strains of degree 2 would be better than the places that follow from them: what an axial force does in
//! bending is of second order in the curvature, which the expansion of fourth order has to fourth order alone.
//!
//! ```text
//! (1) I_k = ∫(s − s̄)ᵏ ξ ds,   α₁ = 9/4 I₀ − 15 I₂/l²,   α₂ = 12 I₁/l,   α₃ = −15 I₀ + 180 I₂/l²
//! (2) C₁ = [α₂, α₁],   C₂ = [α₁, 2α₃ + C₁]/60
//! (3) X = C₁ − 20 α₁ − α₃,   Y = α₂ + C₂,   Ω = α₁ + α₃/12 − [X, Y]/240
//! ```
//!
//! Blanes, Casas, Oteo and Ros, The Magnus expansion and some of its applications, Physics Reports 470 (2009), with the signs of
//! `g' = g ξ`. The derivatives of (2) and (3) are by the rule of products, those by time in lists of a value, its rate and its second
//! rate.

use super::{MOST_COORDINATES, Rod, Step};
use crate::element::exponential::{bracket, halves, joined, tangent, tangent_and_rate, tangent_gradient, tangents};
use nalgebra::{Matrix6, Vector6};

/// A value and its derivatives by time, `N` of them in all.
type Jet<const N: usize> = [Vector6<f64>; N];

const BINOMIALS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 2.0, 1.0]];

fn product<const N: usize>(a: &Jet<N>, b: &Jet<N>) -> Jet<N> {
    let mut out = [Vector6::zeros(); N];
    for k in 0..N {
        for j in 0..=k {
            out[k] += BINOMIALS[k][j] * bracket(&a[j], &b[k - j]);
        }
    }
    out
}

/// The product with a constant.
fn times<const N: usize>(a: &Vector6<f64>, b: &Jet<N>) -> Jet<N> {
    b.each_ref().map(|b| bracket(a, b))
}

/// A sum of two, each with a factor.
fn sum<const N: usize>(f: f64, a: &Jet<N>, g: f64, b: &Jet<N>) -> Jet<N> {
    std::array::from_fn(|k| f * a[k] + g * b[k])
}

/// Eqs. (1) to (3).
#[derive(Debug, Clone, Copy)]
struct Magnus<const N: usize> {
    alpha: [Jet<N>; 3],
    c1: Jet<N>,
    x: Jet<N>,
    y: Jet<N>,
    omega: Jet<N>,
}

/// Their variation in a direction that does not change.
#[derive(Debug, Clone, Copy)]
struct Varied<const N: usize> {
    c1: Jet<N>,
    x: Jet<N>,
    y: Jet<N>,
    omega: Jet<N>,
}

impl<const N: usize> Magnus<N> {
    fn new(alpha: [Jet<N>; 3]) -> Self {
        let [a1, a2, a3] = &alpha;
        let c1 = product(a2, a1);
        let c2 = product(a1, &sum(2.0, a3, 1.0, &c1));
        let x = sum(1.0, &sum(1.0, &c1, -20.0, a1), -1.0, a3);
        let y = sum(1.0, a2, 1.0 / 60.0, &c2);
        let omega = sum(1.0, &sum(1.0, a1, 1.0 / 12.0, a3), -1.0 / 240.0, &product(&x, &y));
        Self { alpha, c1, x, y, omega }
    }

    /// The variation for one of `α`.
    fn varied(&self, [b1, b2, b3]: &[Vector6<f64>; 3]) -> Varied<N> {
        let [a1, a2, a3] = &self.alpha;
        let c1 = sum(1.0, &times(b2, a1), -1.0, &times(b1, a2));
        let mut inner = c1;
        inner[0] += 2.0 * b3;
        let c2 = sum(1.0, &times(b1, &sum(2.0, a3, 1.0, &self.c1)), 1.0, &product(a1, &inner));
        let (mut x, mut y) = (c1, c2.map(|c2| c2 / 60.0));
        x[0] -= 20.0 * b1 + b3;
        y[0] += b2;
        let mut omega = sum(-1.0 / 240.0, &product(&x, &self.y), -1.0 / 240.0, &product(&self.x, &y));
        omega[0] += b1 + b3 / 12.0;
        Varied { c1, x, y, omega }
    }

    /// The value alone.
    fn still(&self) -> Magnus<1> {
        let value = |jet: &Jet<N>| [jet[0]];
        Magnus {
            alpha: self.alpha.each_ref().map(value),
            c1: value(&self.c1),
            x: value(&self.x),
            y: value(&self.y),
            omega: value(&self.omega),
        }
    }
}

/// The covector of which the product with `v` is `p · [u, v]`.
fn against(p: &Vector6<f64>, u: &Vector6<f64>) -> Vector6<f64> {
    let ((force, moment), (v, w)) = (halves(p), halves(u));
    joined(&force.cross(&w), &(force.cross(&v) + moment.cross(&w)))
}

/// What of eq. (6) of [`crate::element`] belongs to one coordinate: `Γ` is a sum of products of these with those of the other.
#[derive(Debug, Clone, Copy)]
struct Half {
    /// `E`, and it times the derivative of `Bᵀ f`.
    column: [Vector6<f64>; 2],
    /// Pairs whose products with the other coordinate's are the parts of the second variation of `Ω`.
    pairs: [[Vector6<f64>; 2]; 3],
}

/// All of `Γ` of a step that does not depend on pairs of coordinates.
#[derive(Debug)]
pub struct Halves([Half; MOST_COORDINATES]);

impl Halves {
    /// An entry of `Γ`.
    pub(super) fn entry(&self, i: usize, j: usize) -> f64 {
        let (a, b) = (&self.0[i], &self.0[j]);
        let pairs = a.pairs.iter().zip(&b.pairs);
        let twice: f64 = pairs.map(|([g, x], [h, y])| g.dot(y) + h.dot(x)).sum();
        a.column[0].dot(&b.column[1]) - twice / 240.0
    }
}

/// Eq. (1), of moments or of what a unit of a coordinate adds to them.
fn alphas<T>(moments: [T; 3], length: f64) -> [T; 3]
where
    T: Copy + std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>,
{
    let [zeroth, first, second] = moments;
    let (first, second) = (first * (1.0 / length), second * (1.0 / (length * length)));
    [zeroth * 2.25 + second * -15.0, first * 12.0, zeroth * -15.0 + second * 180.0]
}

/// The twist of a step from its moments: eq. (3).
pub(super) fn twist(moments: [Vector6<f64>; 3], length: f64) -> Vector6<f64> {
    Magnus::new(alphas(moments, length).map(|alpha| [alpha])).omega[0]
}

/// A step of an element of degree 2 at a state.
#[derive(Debug)]
pub struct Sixth<'a> {
    rod: &'a Rod,
    step: &'a Step,
    pub(super) twist: Vector6<f64>,
    b: [Matrix6<f64>; 3],
    magnus: Magnus<3>,
    moves: bool,
}

impl<'a> Sixth<'a> {
    pub(super) fn still(rod: &'a Rod, step: usize, q: &[f64]) -> Self {
        let step = &rod.steps[step];
        let none = Vector6::zeros();
        let alpha = alphas(rod.three_moments(step, q, true), step.length).map(|value| [value, none, none]);
        // Rates are zero: the value alone is computed.
        let value = Magnus::new(alpha.map(|jet| [jet[0]]));
        let jet = |of: Jet<1>| [of[0], none, none];
        let magnus = Magnus { alpha, c1: jet(value.c1), x: jet(value.x), y: jet(value.y), omega: jet(value.omega) };
        let twist = value.omega[0];
        Self { rod, step, twist, b: [tangent(&twist), Matrix6::zeros(), Matrix6::zeros()], magnus, moves: false }
    }

    pub(super) fn moving(rod: &'a Rod, step: usize, [q, qd, qdd]: [&[f64]; 3]) -> Self {
        let step = &rod.steps[step];
        let of = |x: &[f64], whole: bool| alphas(rod.three_moments(step, x, whole), step.length);
        let (value, first, second) = (of(q, true), of(qd, false), of(qdd, false));
        let magnus = Magnus::new(std::array::from_fn(|k| [value[k], first[k], second[k]]));
        let [twist, rate, twice] = magnus.omega;
        let b = if qdd.is_empty() {
            let [b, of_rate] = tangent_and_rate(&twist, &rate);
            [b, of_rate, Matrix6::zeros()]
        } else {
            tangents(&twist, &rate, &twice)
        };
        Self { rod, step, twist, b, magnus, moves: true }
    }

    /// What a unit of a coordinate adds to `α`.
    fn direction(&self, i: usize) -> [Vector6<f64>; 3] {
        let (strain, degree) = (self.rod.strain_of(i), i / self.rod.free.len());
        let weights = alphas(self.step.per_degree.map(|of| of[degree]), self.step.length);
        weights.map(|weight| Vector6::ith(strain, weight))
    }

    pub(super) fn subspace(&self, i: usize) -> Vector6<f64> {
        self.b[0] * self.magnus.still().varied(&self.direction(i)).omega[0]
    }

    pub(super) fn subspaces(&self, i: usize) -> [Vector6<f64>; 3] {
        if !self.moves {
            return [self.subspace(i), Vector6::zeros(), Vector6::zeros()];
        }
        let [e, first, second] = self.magnus.varied(&self.direction(i)).omega;
        let [b, rate, twice] = &self.b;
        [b * e, rate * e + b * first, twice * e + 2.0 * rate * first + b * second]
    }

    pub(super) fn rates(&self) -> [Vector6<f64>; 2] {
        let without = self.magnus.alpha.map(|[value, first, _]| [value, first, Vector6::zeros()]);
        let [_, first, second] = Magnus::new(without).omega;
        [self.b[0] * first, self.b[1] * first + self.b[0] * second]
    }

    /// What `Γ` is made of. With `p = Bᵀ f`, `w = 2 α₃ + C₁` and two variations, of (2) and (3):
    ///
    /// ```text
    /// −240 p·δδ'Ω = p·[δX, δ'Y] + p·[δ'X, δY] + q·[δα₁, δ'w] + q·[δ'α₁, δw] + r·[δα₂, δ'α₁] + r·[δ'α₂, δα₁]
    /// q·u = p·[X, u]/60,   r·u = p·[u, Y] + q·[α₁, u]
    /// ```
    pub(super) fn halves(&self, f: &Vector6<f64>) -> Halves {
        let magnus = self.magnus.still();
        let (pulled, gradient) = (self.b[0].tr_mul(f), tangent_gradient(&self.twist, f));
        // q and r.
        let second = against(&pulled, &magnus.x[0]) / 60.0;
        let first = against(&second, &magnus.alpha[0][0]) - against(&pulled, &magnus.y[0]);
        let none = Vector6::zeros();
        let mut halves = [Half { column: [none; 2], pairs: [[none; 2]; 3] }; MOST_COORDINATES];
        for (i, half) in halves.iter_mut().enumerate().take(self.rod.count()) {
            let by @ [b1, b2, b3] = self.direction(i);
            let varied = magnus.varied(&by);
            let e = varied.omega[0];
            half.column = [e, gradient * e];
            half.pairs = [
                [against(&pulled, &varied.x[0]), varied.y[0]],
                [against(&second, &b1), 2.0 * b3 + varied.c1[0]],
                [against(&first, &b2), b1],
            ];
        }
        Halves(halves)
    }
}
