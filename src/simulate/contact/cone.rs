//! Coulomb's law at several contacts at once, exactly: the cone complementarity problem of an instant.
//!
//! ```text
//! (1)  w = A λ + b,   K* ∋ w + μ |w_t| n  ⊥  λ ∈ K(μ)        (de Saxcé, Feng, "The bipotential method", 1998)
//! (2)  open  λ = 0, w_n ≥ 0     stick  w = 0, λ ∈ K     slip  w_n = 0, λ_t = −μ λ_n w_t / |w_t|
//! ```
//!
//! `w` are accelerations or velocities of the contacts, three numbers each: along the normal and two tangents. Solved by
//! the nonsmooth Gauss–Seidel method (Jean, Moreau 1992; Jean 1999) with (2) exact at each contact: there the direction of slip is the
//! root of one function of one angle.

use nalgebra::{Matrix3, Vector2, Vector3};

/// The law of one contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Law {
    /// Coulomb's, from rest: what it holds with and what it slides with.
    Coulomb {
        /// μ at rest.
        stick: f64,
        /// μ in motion.
        slide: f64,
    },
    /// It slides in this direction already.
    Sliding {
        /// μ in motion.
        friction: f64,
        /// Unit vector in its tangents.
        direction: Vector2<f64>,
    },
}

/// What a contact does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    Open,
    Stick,
    Slip,
}

/// (1): the blocks of `A` by rows of contacts, each with those that it meets and itself.
#[derive(Debug, Clone, Default)]
pub(super) struct Problem {
    pub(super) blocks: Vec<Vec<(usize, Matrix3<f64>)>>,
    pub(super) rates: Vec<Vector3<f64>>,
    pub(super) laws: Vec<Law>,
}

/// An answer to (1).
#[derive(Debug, Clone)]
pub(super) struct Answer {
    /// λ, from the first body on the second.
    pub(super) forces: Vec<Vector3<f64>>,
    /// w
    pub(super) rates: Vec<Vector3<f64>>,
    pub(super) states: Vec<State>,
    /// Largest change of a force in the last sweep, in parts of the largest force.
    pub(super) change: f64,
    pub(super) sweeps: usize,
}

/// Parts of a turn in which the direction of slip is looked for: more of them if there is none in few, as close to sticking, where
/// there are two that are near each other.
const DIRECTIONS: [usize; 3] = [16, 128, 2048];

impl Problem {
    /// Sweeps until no force changes by more than `tolerance` of the largest, or `most` times. `forces` is the guess.
    pub(super) fn solve(&self, forces: &[Vector3<f64>], tolerance: f64, most: usize) -> Answer {
        let n = self.rates.len();
        let own: Vec<Matrix3<f64>> = (0..n).map(|i| self.own(i)).collect();
        let inverse: Vec<Matrix3<f64>> = own.iter().map(|a| a.try_inverse().unwrap_or_else(Matrix3::zeros)).collect();
        let mut forces = forces.to_vec();
        let mut states = vec![State::Open; n];
        let (mut change, mut sweeps) = (f64::INFINITY, 0);
        while sweeps < most && change > tolerance {
            let (mut moved, mut largest) = (0.0_f64, f64::MIN_POSITIVE);
            for i in 0..n {
                let mut rate = self.rates[i];
                self.blocks[i].iter().filter(|(j, _)| *j != i).for_each(|(j, block)| rate += block * forces[*j]);
                let (force, state) = local(&own[i], &inverse[i], &rate, &self.laws[i], &forces[i]);
                moved = moved.max((force - forces[i]).amax());
                largest = largest.max(force.amax());
                (forces[i], states[i]) = (force, state);
            }
            change = moved / largest;
            sweeps += 1;
        }
        let rates = (0..n).map(|i| self.rate(i, &forces)).collect();
        Answer { forces, rates, states, change, sweeps }
    }

    fn own(&self, i: usize) -> Matrix3<f64> {
        self.blocks[i].iter().find(|(j, _)| *j == i).map_or_else(Matrix3::zeros, |(_, block)| *block)
    }

    /// `(A λ + b)` of a contact.
    pub(super) fn rate(&self, i: usize, forces: &[Vector3<f64>]) -> Vector3<f64> {
        self.rates[i] + self.blocks[i].iter().map(|(j, block)| block * forces[*j]).sum::<Vector3<f64>>()
    }
}

/// (2) at one contact whose rate without its own force is `rate`.
fn local(
    a: &Matrix3<f64>,
    inverse: &Matrix3<f64>,
    rate: &Vector3<f64>,
    law: &Law,
    guess: &Vector3<f64>,
) -> (Vector3<f64>, State) {
    if rate.x >= 0.0 || !(a[(0, 0)] > 0.0) {
        return (Vector3::zeros(), State::Open);
    }
    match *law {
        Law::Sliding { friction, direction } => {
            let push = Vector3::new(1.0, -friction * direction.x, -friction * direction.y);
            let resist = a.row(0).transpose().dot(&push);
            // Painlevé's: pressing harder does not lift it.
            if resist > 0.0 { (push * (-rate.x / resist), State::Slip) } else { (push * f64::INFINITY, State::Slip) }
        }
        Law::Coulomb { stick, slide } => {
            if stick == 0.0 {
                return (Vector3::new(-rate.x / a[(0, 0)], 0.0, 0.0), State::Slip);
            }
            let hold = -(inverse * rate);
            if hold.x >= 0.0 && hold.yz().norm() <= stick * hold.x {
                return (hold, State::Stick);
            }
            let guess = if guess.yz() != Vector2::zeros() { -guess.yz() } else { -hold.yz() };
            (slipping(a, rate, slide, &guess), State::Slip)
        }
    }
}

/// The force of slip: the direction of `w_t` is that against which it acts.
fn slipping(a: &Matrix3<f64>, rate: &Vector3<f64>, friction: f64, guess: &Vector2<f64>) -> Vector3<f64> {
    let force = |angle: f64| {
        let push = Vector3::new(1.0, -friction * angle.cos(), -friction * angle.sin());
        let resist = a.row(0).transpose().dot(&push);
        (resist > 0.0).then(|| push * (-rate.x / resist))
    };
    // Component of the slip across the direction, and along it.
    let slip = |angle: f64| {
        let w = (rate + a * force(angle)?).yz();
        let (sin, cos) = angle.sin_cos();
        Some((cos * w.y - sin * w.x, cos * w.x + sin * w.y))
    };
    let start = guess.y.atan2(guess.x);
    let mut best: Option<(f64, f64)> = None;
    for count in DIRECTIONS {
        let step = std::f64::consts::TAU / count as f64;
        // From the guess to both sides: the nearest root along which it slips.
        for k in 0..count {
            let offset = (k / 2) as f64 * if k % 2 == 0 { 1.0 } else { -1.0 } - 0.5;
            let (left, right) = (start + offset * step, start + (offset + 1.0) * step);
            let (Some((l, _)), Some((r, _))) = (slip(left), slip(right)) else { continue };
            if l * r > 0.0 {
                continue;
            }
            let angle = bracketed(left, right, l, r, |angle| slip(angle).map_or(0.0, |(across, _)| across));
            let along = slip(angle).map_or(-1.0, |(_, along)| along);
            if along >= 0.0 {
                return force(angle).unwrap_or_else(Vector3::zeros);
            }
            if best.is_none_or(|(_, most)| along > most) {
                best = Some((angle, along));
            }
        }
    }
    best.and_then(|(angle, _)| force(angle)).or_else(|| force(start)).unwrap_or_else(Vector3::zeros)
}

/// A root between two signs (Illinois, then to rounding).
fn bracketed(mut left: f64, mut right: f64, mut l: f64, mut r: f64, f: impl Fn(f64) -> f64) -> f64 {
    if l == 0.0 {
        return left;
    }
    for _ in 0..60 {
        if r == 0.0 || (right - left).abs() < 1e-15 {
            return right;
        }
        let middle = right - r * (right - left) / (r - l);
        let at = f(middle);
        if at * r < 0.0 {
            (left, l) = (right, r);
        } else {
            l *= 0.5;
        }
        (right, r) = (middle, at);
    }
    right
}

#[cfg(test)]
mod tests {
    use super::*;

    fn next(state: &mut u64) -> f64 {
        *state ^= *state << 13;
        *state ^= *state >> 7;
        *state ^= *state << 17;
        (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    /// Random contacts on random bodies: (2) holds at each of them.
    #[test]
    fn coulombs_law_holds_at_every_contact() {
        let mut seed = 0x9e37_79b9_7f4a_7c15;
        for case in 0..400 {
            let (n, rank) = (1 + case % 5, 3 * (1 + case % 5) + 2);
            let friction = 0.1 + 0.2 * (case % 4) as f64;
            let rows: Vec<Vec<f64>> = (0..3 * n).map(|_| (0..rank).map(|_| next(&mut seed)).collect()).collect();
            let dot = |i: usize, j: usize| rows[i].iter().zip(&rows[j]).map(|(a, b)| a * b).sum::<f64>();
            let block = |i: usize, j: usize| Matrix3::from_fn(|r, c| dot(3 * i + r, 3 * j + c));
            let problem = Problem {
                blocks: (0..n).map(|i| (0..n).map(|j| (j, block(i, j))).collect()).collect(),
                rates: (0..n).map(|_| Vector3::from_fn(|_, _| next(&mut seed))).collect(),
                laws: vec![Law::Coulomb { stick: friction, slide: friction }; n],
            };
            let found = problem.solve(&vec![Vector3::zeros(); n], 1e-14, 100_000);
            if found.change > 1e-12 {
                continue;
            }
            for i in 0..n {
                let (f, w) = (found.forces[i], found.rates[i]);
                match found.states[i] {
                    State::Open => assert!(f == Vector3::zeros() && w.x >= -1e-9, "case {case}: {found:?}"),
                    State::Stick => {
                        assert!(w.amax() < 1e-9 && f.yz().norm() <= friction * f.x + 1e-9, "case {case}: {found:?}")
                    }
                    State::Slip => {
                        let against = f.yz() + friction * f.x * w.yz().normalize();
                        // A slip that has hardly begun has a direction to rounding of its rate.
                        let rounding = 1e-9 / w.yz().norm();
                        assert!(
                            w.x.abs() < 1e-9 && against.norm() < (1e-7 + rounding) * f.x.max(1.0),
                            "case {case}: {found:?}"
                        );
                    }
                }
            }
        }
    }
}
