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

use super::bounded::bounded;
use nalgebra::{DMatrix, DVector, Matrix3, Vector2, Vector3};

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
pub(crate) enum State {
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

/// One equation of states: what it measures at a contact, and what it pushes there.
struct Row {
    of: usize,
    measures: Vector3<f64>,
    pushes: Vector3<f64>,
}

/// An answer to (1).
#[derive(Debug, Clone)]
pub(crate) struct Answer {
    /// λ, from the first body on the second.
    pub(crate) forces: Vec<Vector3<f64>>,
    /// w
    pub(crate) rates: Vec<Vector3<f64>>,
    pub(crate) states: Vec<State>,
    /// Largest change of a force in the last sweep, in parts of the largest force.
    pub(crate) change: f64,
    pub(crate) sweeps: usize,
}

/// Parts of a turn in which the direction of slip is looked for: more of them if there is none in few, as close to sticking, where
/// there are two that are near each other.
const DIRECTIONS: [usize; 3] = [16, 128, 2048];
/// After so many sweeps, and three times as many each time, the equations of the states are solved: they may be right long before
/// the forces are.
const FIRST_ATTEMPT: usize = 12;
/// Rows of these equations, and refinements of their solution.
const MOST_ROWS: usize = 120;
const MOST_POLISHED: usize = 8;
/// What their solution may lack, in parts of rates and of forces.
const POLISHED: f64 = 1e-12;
/// Eigenvalues of a contact's own matrix below this part of the largest are zero.
const RANK: f64 = 1e-12;
/// Steps of Newton's method from the direction of the last sweep.
const MOST_NEWTON: usize = 8;

impl Problem {
    /// Sweeps until no force changes by more than `tolerance` of the largest, or `most` times. `forces` is the guess.
    pub(crate) fn solve(&self, forces: &[Vector3<f64>], tolerance: f64, most: usize) -> Answer {
        let n = self.rates.len();
        let own: Vec<Matrix3<f64>> = (0..n).map(|i| self.own(i)).collect();
        let inverse: Vec<Inverse> = own.iter().map(Inverse::of).collect();
        let mut forces = forces.to_vec();
        let mut states = vec![State::Open; n];
        let (mut change, mut sweeps, mut attempt) = (f64::INFINITY, 0, FIRST_ATTEMPT);
        while sweeps < most && change > tolerance {
            let (mut moved, mut largest, mut steady) = (0.0_f64, f64::MIN_POSITIVE, true);
            for i in 0..n {
                let mut rate = self.rates[i];
                self.blocks[i].iter().filter(|(j, _)| *j != i).for_each(|(j, block)| rate += block * forces[*j]);
                let (force, state) = local(&own[i], &inverse[i], &rate, &self.laws[i], &forces[i]);
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
                }
            }
        }
        let rates = (0..n).map(|i| self.rate(i, &forces)).collect();
        Answer { forces, rates, states, change, sweeps }
    }

    /// Forces that meet the equations of these states, as near as can be to those that are given; `None` if they are not within their
    /// laws: then the states are not the right ones, or there are too many rows.
    fn polished(&self, near: &[Vector3<f64>], states: &[State]) -> Option<Vec<Vector3<f64>>> {
        let size = (0..near.len()).map(|i| self.rate_size(i, near)).fold(0.0, f64::max);
        let mut forces = near.to_vec();
        for _ in 0..MOST_POLISHED {
            for i in (0..forces.len()).filter(|i| states[*i] == State::Slip) {
                let rate = self.rate(i, &forces).yz();
                if let (Law::Coulomb { slide, .. }, Some(d)) = (self.laws[i], rate.try_normalize(POLISHED * size)) {
                    let normal = forces[i].x;
                    (forces[i].y, forces[i].z) = (-slide * normal * d.x, -slide * normal * d.y);
                }
            }
            let rows = self.rows(&forces, states)?;
            let missing = DVector::from_iterator(
                rows.len(),
                rows.iter().map(|row| -row.measures.dot(&self.rate(row.of, &forces))),
            );
            if missing.amax() <= POLISHED * size && self.obeys(&forces, states, size) {
                return Some(forces);
            }
            let matrix = DMatrix::from_fn(rows.len(), rows.len(), |i, j| {
                let block = self.blocks[rows[i].of].iter().find(|(k, _)| *k == rows[j].of);
                block.map_or(0.0, |(_, block)| rows[i].measures.dot(&(block * rows[j].pushes)))
            });
            let parts = matrix.svd(true, true);
            let cut = RANK.sqrt() * parts.singular_values.max();
            let change = parts.solve(&missing, cut).ok()?;
            rows.iter().zip(change.iter()).for_each(|(row, change)| forces[row.of] += row.pushes * *change);
        }
        None
    }

    /// What the rates of a contact are made of.
    fn rate_size(&self, i: usize, forces: &[Vector3<f64>]) -> f64 {
        let parts = self.blocks[i].iter().map(|(j, block)| (block * forces[*j]).amax());
        parts.fold(self.rates[i].amax(), f64::max)
    }

    /// The equations of states; what slips does so along the velocity that it has with these forces. `None` if there are too many.
    fn rows(&self, forces: &[Vector3<f64>], states: &[State]) -> Option<Vec<Row>> {
        let mut rows = Vec::new();
        for (of, state) in states.iter().enumerate() {
            let own = self.own(of);
            let mut add = |measures: Vector3<f64>, pushes: Vector3<f64>| rows.push(Row { of, measures, pushes });
            match (state, self.laws[of]) {
                (State::Open, _) | (State::Slip, Law::Bounded { .. }) => {}
                (State::Stick, _) => {
                    (0..3)
                        .filter(|k| own[(*k, *k)] > 0.0)
                        .for_each(|k| add(Vector3::ith(k, 1.0), Vector3::ith(k, 1.0)));
                }
                (State::Slip, Law::Sliding { friction, direction }) => {
                    add(Vector3::x(), Vector3::new(1.0, -friction * direction.x, -friction * direction.y));
                }
                (State::Slip, Law::Coulomb { .. }) => {
                    // Along the force that it has: a change of it keeps the direction.
                    let tangential = forces[of].yz() / forces[of].x;
                    add(Vector3::x(), Vector3::new(1.0, tangential.x, tangential.y));
                }
            }
        }
        (rows.len() <= MOST_ROWS && rows.iter().all(|row| row.pushes.iter().all(|x| x.is_finite()))).then_some(rows)
    }

    /// Whether forces and the rates that they leave are those of states.
    fn obeys(&self, forces: &[Vector3<f64>], states: &[State], size: f64) -> bool {
        let largest = forces.iter().map(|force| force.amax()).fold(0.0, f64::max);
        let slack = POLISHED * largest;
        (0..forces.len()).all(|i| {
            let (force, rate) = (forces[i], self.rate(i, forces));
            match (states[i], self.laws[i]) {
                (State::Open, _) => rate.x >= -POLISHED * size,
                (State::Stick, Law::Coulomb { stick, .. }) => {
                    force.x >= -slack && force.yz().norm() <= stick * force.x + slack
                }
                (State::Stick, Law::Bounded { bound }) => force.norm() <= bound + slack,
                (State::Stick, Law::Sliding { .. }) => false,
                // Of a force at its bound the sweeps have the direction.
                (State::Slip, Law::Bounded { .. }) => {
                    force.dot(&rate) <= 0.0 && force.cross(&rate).norm() <= POLISHED.sqrt() * force.norm() * size
                }
                (State::Slip, Law::Sliding { .. }) => force.x >= -slack,
                (State::Slip, Law::Coulomb { stick, .. }) => {
                    let (along, across) = (force.yz().dot(&rate.yz()), force.yz().perp(&rate.yz()));
                    let straight = along <= 0.0 && across.abs() <= POLISHED * force.yz().norm() * size;
                    force.x >= -slack && (stick == 0.0 || straight)
                }
            }
        })
    }

    fn own(&self, i: usize) -> Matrix3<f64> {
        self.blocks[i].iter().find(|(j, _)| *j == i).map_or_else(Matrix3::zeros, |(_, block)| *block)
    }

    /// `(A λ + b)` of a contact.
    pub(crate) fn rate(&self, i: usize, forces: &[Vector3<f64>]) -> Vector3<f64> {
        self.rates[i] + self.blocks[i].iter().map(|(j, block)| block * forces[*j]).sum::<Vector3<f64>>()
    }
}

/// (2) at one contact whose rate without its own force is `rate`.
fn local(
    a: &Matrix3<f64>,
    inverse: &Inverse,
    rate: &Vector3<f64>,
    law: &Law,
    guess: &Vector3<f64>,
) -> (Vector3<f64>, State) {
    if let Law::Bounded { bound } = *law {
        let (force, holds) = bounded(a, rate, bound);
        return (force, if holds { State::Stick } else { State::Slip });
    }
    if rate.x >= 0.0 || !(a[(0, 0)] > 0.0) {
        return (Vector3::zeros(), State::Open);
    }
    match *law {
        Law::Bounded { .. } => (Vector3::zeros(), State::Open),
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
            let hold = -(inverse.matrix * rate);
            if hold.x >= 0.0 && hold.yz().norm() <= stick * hold.x {
                return (hold, State::Stick);
            }
            if inverse.singular
                && let Some(hold) = held_otherwise(a, rate, stick, &hold)
            {
                return (hold, State::Stick);
            }
            let guess = if guess.yz() != Vector2::zeros() { -guess.yz() } else { -hold.yz() };
            (slipping(a, rate, slide, &guess), State::Slip)
        }
    }
}

/// `A⁻¹` of one contact; of one whose motions are fewer than three (a point on a hinge) that of least norm (Moore, Penrose).
struct Inverse {
    matrix: Matrix3<f64>,
    singular: bool,
}

impl Inverse {
    fn of(a: &Matrix3<f64>) -> Self {
        let parts = a.symmetric_eigen();
        let cut = RANK * parts.eigenvalues.max();
        let singular = parts.eigenvalues.min() <= cut;
        let inverse = parts.eigenvalues.map(|value| if value > cut { value.recip() } else { 0.0 });
        let (v, matrix) = (parts.eigenvectors, parts.eigenvectors * Matrix3::from_diagonal(&inverse));
        Self { matrix: matrix * v.transpose(), singular }
    }
}

/// A force within the cone that holds as well as one outside of it, if its motions are fewer than three: with friction used up along
/// that force, or with none.
fn held_otherwise(a: &Matrix3<f64>, rate: &Vector3<f64>, stick: f64, hold: &Vector3<f64>) -> Option<Vector3<f64>> {
    let along = hold.yz().try_normalize(0.0).unwrap_or_else(Vector2::zeros);
    [stick, 0.0].into_iter().find_map(|friction| {
        let push = Vector3::new(1.0, friction * along.x, friction * along.y);
        let resist = a.row(0).transpose().dot(&push);
        let force = (resist > 0.0).then(|| push * (-rate.x / resist))?;
        ((rate + a * force).norm() <= RANK.sqrt() * rate.norm()).then_some(force)
    })
}

/// The force of slip: the direction of `w_t` is that against which it acts.
fn slipping(a: &Matrix3<f64>, rate: &Vector3<f64>, friction: f64, guess: &Vector2<f64>) -> Vector3<f64> {
    let slip = Slip { a, rate, friction };
    if let Some(force) = guess.try_normalize(0.0).and_then(|guess| slip.near(guess)) {
        return force;
    }
    slip.anywhere(guess.y.atan2(guess.x))
}

/// A contact that slips, as a function of the unit vector `d` along which it does:
///
/// ```text
/// λ = −b_n / (a_nn − μ a_nt·d),   w_t = b_t + λ (a_tn − μ A_tt d),   d_⊥·w_t = 0,   d·w_t ≥ 0
/// ```
struct Slip<'a> {
    a: &'a Matrix3<f64>,
    rate: &'a Vector3<f64>,
    friction: f64,
}

impl Slip<'_> {
    /// The force and the velocity it leaves; `None` if pressing harder does not lift (Painlevé).
    fn at(&self, d: Vector2<f64>) -> Option<(Vector3<f64>, Vector2<f64>)> {
        let push = Vector3::new(1.0, -self.friction * d.x, -self.friction * d.y);
        let resist = self.a.row(0).transpose().dot(&push);
        let force = (resist > 0.0).then(|| push * (-self.rate.x / resist))?;
        Some((force, (self.rate + self.a * force).yz()))
    }

    /// The root near a direction, by Newton's method on its angle; `None` if that does not find it at once.
    fn near(&self, mut d: Vector2<f64>) -> Option<Vector3<f64>> {
        let (across, block) = (Vector2::new(self.a[(0, 1)], self.a[(0, 2)]), self.a.fixed_view::<2, 2>(1, 1));
        for _ in 0..MOST_NEWTON {
            let (force, w) = self.at(d)?;
            let side = Vector2::new(-d.y, d.x);
            let miss = side.dot(&w);
            let resist = self.a[(0, 0)] - self.friction * across.dot(&d);
            let grows = force.x * self.friction * across.dot(&side) / resist;
            let turned = (across - block * d * self.friction) * grows - block * side * (self.friction * force.x);
            let slope = side.dot(&turned) - d.dot(&w);
            let turn = -miss / slope;
            if !(turn.abs() < 0.5) {
                return None;
            }
            if turn.abs() <= 4.0 * f64::EPSILON {
                return (d.dot(&w) >= 0.0).then_some(force);
            }
            d = (d + side * turn).normalize();
        }
        None
    }

    /// The root nearest to an angle along which it slips, wherever it is.
    fn anywhere(&self, start: f64) -> Vector3<f64> {
        let direction = |angle: f64| Vector2::new(angle.cos(), angle.sin());
        let force = |angle: f64| self.at(direction(angle)).map(|(force, _)| force);
        // Component of the slip across the direction, and along it.
        let slip = |angle: f64| {
            let d = direction(angle);
            let (_, w) = self.at(d)?;
            Some((d.x * w.y - d.y * w.x, d.dot(&w)))
        };
        let mut best: Option<(f64, f64)> = None;
        for count in DIRECTIONS {
            let step = std::f64::consts::TAU / count as f64;
            // From the guess to both sides.
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
            assert!(found.states[0] != State::Stick || w.norm() < 1e-6 * rate.norm(), "case {case}: {found:?}");
        }
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
