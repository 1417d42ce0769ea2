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

mod local;
mod momentum;
mod states;

use local::{Inverse, local, pressed};
pub(crate) use momentum::Swept;
use nalgebra::{Matrix3, Vector2, Vector3};

/// The law of one contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Law {
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
    /// Dry friction of a hinge, in as many of the three numbers as `A` has: |λ| ≤ bound, against what it does not hold.
    Bounded {
        /// (N, N m)
        bound: f64,
    },
}

impl Law {
    /// The law of impulses over a time (s).
    pub(crate) fn times(self, span: f64) -> Self {
        match self {
            Self::Bounded { bound } => Self::Bounded { bound: bound * span },
            Self::Coulomb { .. } | Self::Sliding { .. } => self,
        }
    }
}

/// What a contact does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ConeState {
    Open,
    Stick,
    Slip,
}

/// (1): the blocks of `A` by rows of contacts, each with those that it meets and itself.
#[derive(Debug, Clone, Default)]
pub(crate) struct Problem {
    pub(crate) blocks: Vec<Vec<(usize, Matrix3<f64>)>>,
    pub(crate) rates: Vec<Vector3<f64>>,
    pub(crate) laws: Vec<Law>,
}

/// An answer to (1).
#[derive(Debug, Clone)]
pub(crate) struct Answer {
    /// λ, from the first body on the second.
    pub(crate) forces: Vec<Vector3<f64>>,
    /// w
    pub(crate) rates: Vec<Vector3<f64>>,
    pub(crate) states: Vec<ConeState>,
    /// Largest change of a force in the last sweep, in parts of the largest force.
    pub(crate) change: f64,
    pub(crate) sweeps: usize,
}

/// `A` at each contact by itself.
struct Own {
    block: Matrix3<f64>,
    inverse: Inverse,
}

/// After so many sweeps, and three times as many each time, the equations of the states are solved: they may be right long before
/// the forces are.
const FIRST_ATTEMPT: usize = 12;
/// Singular values below this part of the largest are zero.
const RANK: f64 = 1e-12;

impl Problem {
    /// Sweeps until no force changes by more than `tolerance` of the largest, or `most` times. `forces` is the guess. What does not touch
    /// each other is solved by itself.
    pub(crate) fn solve(&self, forces: &[Vector3<f64>], tolerance: f64, most: usize) -> Answer {
        let islands = self.islands();
        if islands.len() == 1 {
            return self.solve_together(forces, tolerance, most);
        }
        let n = self.rates.len();
        let mut all = Answer {
            forces: vec![Vector3::zeros(); n],
            rates: self.rates.clone(),
            states: vec![ConeState::Open; n],
            change: 0.0,
            sweeps: 0,
        };
        for own in &islands {
            let island = self.of_island(own);
            let guess: Vec<Vector3<f64>> = own.iter().map(|i| forces[*i]).collect();
            let found = island.solve_together(&guess, tolerance, most);
            for (k, i) in own.iter().enumerate() {
                (all.forces[*i], all.rates[*i], all.states[*i]) = (found.forces[k], found.rates[k], found.states[k]);
            }
            all.change = all.change.max(found.change);
            all.sweeps = all.sweeps.max(found.sweeps);
        }
        all
    }

    /// The problem of an island, whose contacts ascend.
    fn of_island(&self, own: &[usize]) -> Self {
        let place = |j: usize| own.binary_search(&j).expect("islands are closed");
        let part = |i: &usize| self.blocks[*i].iter().map(|(j, block)| (place(*j), *block)).collect();
        Self {
            blocks: own.iter().map(part).collect(),
            rates: own.iter().map(|i| self.rates[*i]).collect(),
            laws: own.iter().map(|i| self.laws[*i]).collect(),
        }
    }

    /// Whether a contact slides so that pressing harder does not lift it (Painlevé).
    pub(crate) fn jams(&self, i: usize) -> bool {
        let own = self.own(i);
        match self.laws[i] {
            Law::Sliding { friction, direction } => own[(0, 0)] > 0.0 && pressed(&own, friction, &direction).1 <= 0.0,
            Law::Coulomb { .. } | Law::Bounded { .. } => false,
        }
    }

    /// Contacts that `A` couples, directly or by others, in order: in either direction, for what drives hold may answer in one by rounding.
    fn islands(&self) -> Vec<Vec<usize>> {
        let n = self.rates.len();
        let mut back: Vec<Vec<usize>> = vec![Vec::new(); n];
        for (i, row) in self.blocks.iter().enumerate() {
            row.iter().for_each(|(j, _)| back[*j].push(i));
        }
        let mut seen = vec![false; n];
        let mut islands = Vec::new();
        for first in 0..n {
            if std::mem::replace(&mut seen[first], true) {
                continue;
            }
            let mut island = vec![first];
            let mut at = 0;
            while at < island.len() {
                let own = island[at];
                for other in self.blocks[own].iter().map(|(j, _)| *j).chain(back[own].iter().copied()) {
                    if !std::mem::replace(&mut seen[other], true) {
                        island.push(other);
                    }
                }
                at += 1;
            }
            island.sort_unstable();
            islands.push(island);
        }
        islands
    }

    fn solve_together(&self, forces: &[Vector3<f64>], tolerance: f64, most: usize) -> Answer {
        let n = self.rates.len();
        let own: Vec<Own> = (0..n).map(|i| self.alone(i)).collect();
        let mut forces = forces.to_vec();
        let mut states = vec![ConeState::Open; n];
        let (mut change, mut sweeps, mut attempt) = (f64::INFINITY, 0, FIRST_ATTEMPT);
        while sweeps < most && change > tolerance {
            let (mut moved, mut largest, mut steady) = (0.0_f64, f64::MIN_POSITIVE, true);
            for i in 0..n {
                let (force, state) = self.answer(i, &own[i], &forces);
                moved = moved.max((force - forces[i]).amax());
                largest = largest.max(force.amax());
                steady &= states[i] == state;
                (forces[i], states[i]) = (force, state);
            }
            change = moved / largest;
            sweeps += 1;
            // States that still change are not the right ones.
            if sweeps >= attempt && change > tolerance && steady {
                attempt = 3 * sweeps;
                if let Some(found) = self.polished(&forces, &states) {
                    (forces, change) = (found, 0.0);
                } else if let Some(found) = self.newton(&forces, &states) {
                    ((forces, states), change) = (found, 0.0);
                }
            }
        }
        let rates = (0..n).map(|i| self.rate(i, &forces)).collect();
        Answer { forces, rates, states, change, sweeps }
    }

    fn alone(&self, i: usize) -> Own {
        let block = self.own(i);
        Own { block, inverse: Inverse::of(&block) }
    }

    /// The force and the state of a contact by (2) with the forces of all others.
    fn answer(&self, i: usize, own: &Own, forces: &[Vector3<f64>]) -> (Vector3<f64>, ConeState) {
        let mut rate = self.rates[i];
        self.blocks[i].iter().filter(|(j, _)| *j != i).for_each(|(j, block)| rate += block * forces[*j]);
        local(&own.block, &own.inverse, &rate, &self.laws[i], &forces[i])
    }

    /// What a contact answers to its own force.
    pub(crate) fn own(&self, i: usize) -> Matrix3<f64> {
        self.blocks[i].iter().find(|(j, _)| *j == i).map_or_else(Matrix3::zeros, |(_, block)| *block)
    }

    /// `(A λ + b)` of a contact.
    pub(crate) fn rate(&self, i: usize, forces: &[Vector3<f64>]) -> Vector3<f64> {
        self.rates[i] + self.blocks[i].iter().map(|(j, block)| block * forces[*j]).sum::<Vector3<f64>>()
    }
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

    /// A contact that moves in one or two ways only, as a point on a hinge does: it holds, and within its cone.
    #[test]
    fn contacts_of_few_motions_hold() {
        let mut seed = 0x51_7e5d_e9f3;
        for case in 0..400 {
            let ways = 1 + case % 2;
            let rows: Vec<Vector3<f64>> = (0..ways).map(|_| Vector3::from_fn(|_, _| next(&mut seed))).collect();
            let a: Matrix3<f64> = rows.iter().map(|row| row * row.transpose()).sum();
            let rate: Vector3<f64> = rows.iter().map(|row| row * next(&mut seed)).sum();
            let law = Law::Coulomb { stick: 0.5, slide: 0.5 };
            let problem = Problem { blocks: vec![vec![(0, a)]], rates: vec![rate], laws: vec![law] };
            let found = problem.solve(&[Vector3::zeros()], 1e-14, 10);
            let (f, w) = (found.forces[0], found.rates[0]);
            assert!(f.x >= 0.0 && w.x >= -1e-9 && f.x * w.x <= 1e-9, "case {case}: {found:?}");
            assert!(f.yz().norm() <= 0.5 * f.x * (1.0 + 1e-9), "case {case}: {found:?}");
            assert!(found.states[0] != ConeState::Stick || w.norm() < 1e-6 * rate.norm(), "case {case}: {found:?}");
        }
    }

    /// A slip that has turned round is found from the direction that it had, whatever that is.
    #[test]
    fn slips_are_found_from_the_opposite_direction() {
        let a = Matrix3::from_diagonal(&Vector3::new(1.0, 3.5, 3.5));
        let law = Law::Coulomb { stick: 0.5, slide: 0.5 };
        for k in 0..360 {
            let (sine, cosine) = f64::from(k).to_radians().sin_cos();
            let rate = Vector3::new(-1.0, 8.0 * cosine, 8.0 * sine);
            let problem = Problem { blocks: vec![vec![(0, a)]], rates: vec![rate], laws: vec![law] };
            // As it was when it slipped the other way.
            let guess = Vector3::new(1.0, 0.5 * cosine, 0.5 * sine);
            let found = problem.solve(&[guess], 1e-14, 10);
            let right = Vector3::new(1.0, -0.5 * cosine, -0.5 * sine);
            assert!((found.forces[0] - right).norm() < 1e-12, "{k}: {found:?}");
            let swept = problem.sweep_to(&[guess], 1e-12, 10);
            assert!(swept.found && (swept.forces[0] - right).norm() < 1e-12, "{k}: {swept:?}");
        }
    }

    /// What answers in one direction only, by rounding, is one problem all the same.
    #[test]
    fn contacts_that_answer_in_one_direction_are_one_island() {
        let law = Law::Coulomb { stick: 0.0, slide: 0.0 };
        let own = Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, 1.0));
        let noise = Matrix3::from_element(1e-18);
        let problem = Problem {
            blocks: vec![vec![(0, own)], vec![(1, own)], vec![(2, own), (0, noise)], vec![(3, own), (1, noise)]],
            rates: vec![-Vector3::x(); 4],
            laws: vec![law; 4],
        };
        assert_eq!(problem.islands(), [vec![0, 2], vec![1, 3]]);
        let found = problem.solve(&[Vector3::zeros(); 4], 1e-14, 10);
        assert!(found.forces.iter().all(|force| (force.x - 1.0).abs() < 1e-12), "{found:?}");
    }

    /// Sweeps with momentum find what sweeps without do: a chain of bodies that press on each other.
    #[test]
    fn momentum_leads_to_the_same_forces() {
        let (n, law) = (60, Law::Coulomb { stick: 0.3, slide: 0.3 });
        let own = Matrix3::from_diagonal(&Vector3::new(2.0, 7.0, 7.0));
        let other = Matrix3::from_diagonal(&Vector3::new(-1.0, 0.5, 0.5));
        let near = |i: usize| [i.wrapping_sub(1), i + 1].into_iter().filter(move |j| *j < n).map(move |j| (j, other));
        let problem = Problem {
            blocks: (0..n).map(|i| std::iter::once((i, own)).chain(near(i)).collect()).collect(),
            rates: (0..n).map(|i| Vector3::new(-1.0, (i as f64).sin(), (2.0 * i as f64).cos())).collect(),
            laws: vec![law; n],
        };
        let guess = vec![Vector3::zeros(); n];
        let (slow, quick) = (problem.solve(&guess, 1e-13, 100_000), problem.sweep_to(&guess, 1e-9, 2000));
        let largest = slow.forces.iter().map(|force| force.norm()).fold(0.0, f64::max);
        let off = slow.forces.iter().zip(&quick.forces).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        assert!(quick.found && off < 1e-6 * largest, "{off} of {largest}");
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
                    ConeState::Open => assert!(f == Vector3::zeros() && w.x >= -1e-9, "case {case}: {found:?}"),
                    ConeState::Stick => {
                        assert!(w.amax() < 1e-9 && f.yz().norm() <= friction * f.x + 1e-9, "case {case}: {found:?}")
                    }
                    ConeState::Slip => {
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
