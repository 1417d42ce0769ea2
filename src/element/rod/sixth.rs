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

use super::{Rod, Step};
use crate::element::exponential::{bracket, tangent, tangent_gradient, tangents};
use nalgebra::{Matrix6, Vector6};

/// A value and its derivatives by time, `N` of them in all.
type Jet<const N: usize> = [Vector6<f64>; N];

const BINOMIALS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [1.0, 2.0, 1.0]];

fn product<const N: usize>(a: &Jet<N>, b: &Jet<N>) -> Jet<N> {
    std::array::from_fn(|k| (0..=k).map(|j| BINOMIALS[k][j] * bracket(&a[j], &b[k - j])).sum())
}

fn sum<const N: usize, const M: usize>(parts: [(f64, &Jet<N>); M]) -> Jet<N> {
    std::array::from_fn(|k| parts.iter().map(|(factor, jet)| *factor * jet[k]).sum())
}

/// Eqs. (1) to (3), or their variation in one direction.
#[derive(Debug, Clone, Copy)]
struct Magnus<const N: usize> {
    alpha: [Jet<N>; 3],
    c1: Jet<N>,
    x: Jet<N>,
    y: Jet<N>,
    omega: Jet<N>,
}

impl<const N: usize> Magnus<N> {
    fn new(alpha: [Jet<N>; 3]) -> Self {
        let [a1, a2, a3] = &alpha;
        let c1 = product(a2, a1);
        let c2 = product(a1, &sum([(2.0, a3), (1.0, &c1)]));
        let x = sum([(1.0, &c1), (-20.0, a1), (-1.0, a3)]);
        let y = sum([(1.0, a2), (1.0 / 60.0, &c2)]);
        let omega = sum([(1.0, a1), (1.0 / 12.0, a3), (-1.0 / 240.0, &product(&x, &y))]);
        Self { alpha, c1, x, y, omega }
    }

    /// The variation for one of `α`.
    fn varied(&self, by: [Jet<N>; 3]) -> Self {
        let ([a1, a2, a3], [b1, b2, b3]) = (&self.alpha, &by);
        let c1 = sum([(1.0, &product(b2, a1)), (1.0, &product(a2, b1))]);
        let first = product(b1, &sum([(2.0, a3), (1.0, &self.c1)]));
        let second = product(a1, &sum([(2.0, b3), (1.0, &c1)]));
        let x = sum([(1.0, &c1), (-20.0, b1), (-1.0, b3)]);
        let y = sum([(1.0, b2), (1.0 / 60.0, &first), (1.0 / 60.0, &second)]);
        let products = [product(&x, &self.y), product(&self.x, &y)];
        let omega = sum([(1.0, b1), (1.0 / 12.0, b3), (-1.0 / 240.0, &products[0]), (-1.0 / 240.0, &products[1])]);
        Self { alpha: by, c1, x, y, omega }
    }

    /// The value alone.
    fn still(&self) -> Magnus<1> {
        Magnus {
            alpha: self.alpha.map(|jet| [jet[0]]),
            c1: [self.c1[0]],
            x: [self.x[0]],
            y: [self.y[0]],
            omega: [self.omega[0]],
        }
    }
}

impl Magnus<1> {
    /// The second variation of `Ω` for two variations of `α`.
    fn twice(&self, one: &Self, other: &Self) -> Vector6<f64> {
        let second = |a: &Self, b: &Self| bracket(&a.alpha[1][0], &b.alpha[0][0]);
        let c1 = second(one, other) + second(other, one);
        let half = |a: &Self, b: &Self| bracket(&a.alpha[0][0], &(2.0 * b.alpha[2][0] + b.c1[0]));
        let y = (half(one, other) + half(other, one) + bracket(&self.alpha[0][0], &c1)) / 60.0;
        let mixed = bracket(&one.x[0], &other.y[0]) + bracket(&other.x[0], &one.y[0]);
        -(bracket(&c1, &self.y[0]) + mixed + bracket(&self.x[0], &y)) / 240.0
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
        Self { rod, step, twist, b: tangents(&twist, &rate, &twice), magnus, moves: true }
    }

    /// What a unit of a coordinate adds to `α`.
    fn direction<const N: usize>(&self, i: usize) -> [Jet<N>; 3] {
        let (strain, degree) = (self.rod.strain_of(i), i / self.rod.free.len());
        let weights = alphas(self.step.per_degree.map(|of| of[degree]), self.step.length);
        weights.map(|weight| std::array::from_fn(|k| Vector6::ith(strain, if k == 0 { weight } else { 0.0 })))
    }

    /// A column of `E`.
    fn column(&self, i: usize) -> Magnus<1> {
        self.magnus.still().varied(self.direction(i))
    }

    pub(super) fn subspace(&self, i: usize) -> Vector6<f64> {
        self.b[0] * self.column(i).omega[0]
    }

    pub(super) fn subspaces(&self, i: usize) -> [Vector6<f64>; 3] {
        if !self.moves {
            return [self.subspace(i), Vector6::zeros(), Vector6::zeros()];
        }
        let [e, first, second] = self.magnus.varied(self.direction(i)).omega;
        let [b, rate, twice] = &self.b;
        [b * e, rate * e + b * first, twice * e + 2.0 * rate * first + b * second]
    }

    pub(super) fn rates(&self) -> [Vector6<f64>; 2] {
        let without = self.magnus.alpha.map(|[value, first, _]| [value, first, Vector6::zeros()]);
        let [_, first, second] = Magnus::new(without).omega;
        [self.b[0] * first, self.b[1] * first + self.b[0] * second]
    }

    pub(super) fn gradient(&self, f: &Vector6<f64>) -> (Vector6<f64>, Matrix6<f64>) {
        (self.b[0].tr_mul(f), tangent_gradient(&self.twist, f))
    }

    pub(super) fn curvature(&self, (pulled, gradient): &(Vector6<f64>, Matrix6<f64>), i: usize, j: usize) -> f64 {
        let (one, other) = (self.column(i), self.column(j));
        let twice = self.magnus.still().twice(&one, &other);
        pulled.dot(&twice) + one.omega[0].dot(&(gradient * other.omega[0]))
    }
}
