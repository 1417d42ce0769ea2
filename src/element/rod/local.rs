//! A step of an element at a state, in the axes of the station where it ends: eqs. (2) to (6), or what a curve has there.

use super::sixth::{Halves, Sixth};
use super::{Rod, Step};
use crate::element::exponential::{bracket, bracket_unit, exponential, tangent_gradient};
use crate::element::guide::Guided;
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// A step at a state: eqs. (2) to (6) in the axes of the station where it ends.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "it lives within one evaluation, which asks for no memory")]
pub enum Local<'a> {
    /// Of a flexible element.
    Strained(Strained<'a>),
    /// Of one of degree 2.
    Sixth(Sixth<'a>),
    /// Of a guide.
    Guided(Guiding),
}

/// A step along a curve.
#[derive(Debug)]
pub struct Guiding {
    at: Guided,
    /// `Z`, `Ż`, `Z̈`.
    columns: [Vector6<f64>; 3],
    rate: f64,
}

impl<'a> Local<'a> {
    pub(super) fn guided(at: Guided, [rate, second]: [f64; 2]) -> Self {
        Self::Guided(Guiding { columns: at.moving(rate, second), at, rate })
    }

    /// Turn and shift across the step.
    pub fn pose(&self) -> (Matrix3<f64>, Vector3<f64>) {
        match self {
            Self::Strained(step) => exponential(&step.twist),
            Self::Sixth(step) => exponential(&step.twist),
            Self::Guided(step) => (step.at.turn, step.at.place),
        }
    }

    /// A column of `Z`.
    pub fn subspace(&self, i: usize) -> Vector6<f64> {
        match self {
            Self::Strained(step) => step.subspace(i),
            Self::Sixth(step) => step.subspace(i),
            Self::Guided(step) => step.columns[0],
        }
    }

    /// Columns of `Z`, `Ż` and `Z̈`: eqs. (4) and (5).
    pub fn subspaces(&self, i: usize) -> [Vector6<f64>; 3] {
        match self {
            Self::Strained(step) => step.subspaces(i),
            Self::Sixth(step) => step.subspaces(i),
            Self::Guided(step) => step.columns,
        }
    }

    /// `W` and `Ż q̇` of eq. (4), for second rates that are zero.
    pub fn rates(&self) -> [Vector6<f64>; 2] {
        match self {
            Self::Strained(step) => step.rates(),
            Self::Sixth(step) => step.rates(),
            Self::Guided(step) => [step.columns[0] * step.rate, step.at.subspaces[1] * (step.rate * step.rate)],
        }
    }

    /// What of eq. (6) is the same for all pairs of coordinates.
    pub fn gradient(&self, f: &Vector6<f64>) -> Gradient {
        match self {
            Self::Strained(step) => {
                let (pulled, by_twist) = step.gradient(f);
                Gradient::Pulled(pulled, by_twist)
            }
            Self::Sixth(step) => Gradient::Halves(step.halves(f)),
            Self::Guided(_) => Gradient::Pulled(*f, Matrix6::zeros()),
        }
    }

    /// An entry of `Γ`, eq. (6); of a guide `Z'ᵀ f`.
    pub fn curvature(&self, gradient: &Gradient, i: usize, j: usize) -> f64 {
        match (self, gradient) {
            (_, Gradient::Halves(halves)) => halves.entry(i, j),
            (Self::Strained(step), Gradient::Pulled(pulled, by_twist)) => step.curvature(pulled, by_twist, i, j),
            (Self::Guided(step), Gradient::Pulled(pulled, _)) => step.at.subspaces[1].dot(pulled),
            // Halves alone belong to it.
            (Self::Sixth(_), Gradient::Pulled(..)) => 0.0,
        }
    }
}

/// What [`Local::curvature`] is made of.
#[derive(Debug)]
#[expect(clippy::large_enum_variant, reason = "it lives within one evaluation, which asks for no memory")]
pub enum Gradient {
    /// `Bᵀ f` and `∂(Bᵀ f)/∂Ω`; of a guide `f` alone.
    Pulled(Vector6<f64>, Matrix6<f64>),
    /// Of a step of 6th order, by coordinates.
    Halves(Halves),
}

/// A step of a flexible element.
#[derive(Debug)]
pub struct Strained<'a> {
    pub(super) rod: &'a Rod,
    pub(super) step: &'a Step,
    pub(super) twist: Vector6<f64>,
    pub(super) b: [Matrix6<f64>; 3],
    /// `I₀`, `I₁`; of the rates; of the second rates.
    pub(super) moments: [[Vector6<f64>; 2]; 3],
    pub(super) moves: bool,
}

impl Strained<'_> {
    fn weights(&self, i: usize) -> (usize, [f64; 2]) {
        let degree = i / self.rod.free.len();
        (self.rod.strain_of(i), [self.step.per_degree[0][degree], self.step.per_degree[1][degree]])
    }

    /// A column of `E` (order 0), `Ė` (1) or `Ë` (2).
    fn column(&self, i: usize, order: usize) -> Vector6<f64> {
        let (strain, [w0, w1]) = self.weights(i);
        let [i0, i1] = &self.moments[order];
        let mut column = bracket_unit(&((w1 * i0 - w0 * i1) / self.step.length), strain);
        if order == 0 {
            column[strain] += w0;
        }
        column
    }

    fn subspace(&self, i: usize) -> Vector6<f64> {
        self.b[0] * self.column(i, 0)
    }

    fn subspaces(&self, i: usize) -> [Vector6<f64>; 3] {
        let e = self.column(i, 0);
        if !self.moves {
            return [self.b[0] * e, Vector6::zeros(), Vector6::zeros()];
        }
        let [first, second] = [1, 2].map(|order| self.column(i, order));
        let [b, rate, twice] = &self.b;
        [b * e, rate * e + b * first, twice * e + 2.0 * rate * first + b * second]
    }

    fn rates(&self) -> [Vector6<f64>; 2] {
        let ([i0, i1], [r0, r1]) = (&self.moments[0], &self.moments[1]);
        let l = self.step.length;
        let first = r0 + (bracket(r0, i1) + bracket(i0, r1)) / l;
        let second = 2.0 * bracket(r0, r1) / l;
        [self.b[0] * first, self.b[1] * first + self.b[0] * second]
    }

    fn gradient(&self, f: &Vector6<f64>) -> (Vector6<f64>, Matrix6<f64>) {
        (self.b[0].tr_mul(f), tangent_gradient(&self.twist, f))
    }

    fn curvature(&self, pulled: &Vector6<f64>, by_twist: &Matrix6<f64>, i: usize, j: usize) -> f64 {
        let ((one, [a0, a1]), (other, [b0, b1])) = (self.weights(i), self.weights(j));
        let commuted = bracket(&Vector6::ith(one, 1.0), &Vector6::ith(other, 1.0));
        pulled.dot(&commuted) * (a0 * b1 - b0 * a1) / self.step.length
            + self.column(i, 0).dot(&(by_twist * self.column(j, 0)))
    }
}
