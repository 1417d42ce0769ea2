//! Coulomb's law at one contact, exactly: eq. (2).

use super::super::bounded::bounded;
use super::{ConeState, Law, RANK};
use nalgebra::{Matrix3, Vector2, Vector3};

/// Parts of a turn in which the direction of slip is looked for: more of them if there is none in few, as close to sticking, where
/// there are two that are near each other.
const DIRECTIONS: [usize; 3] = [16, 128, 2048];
/// A force holds what is left of a rate by rounding: far less than what friction is made smaller by where it has reached its limit.
const HOLDS: f64 = 1e-10;
/// Steps of Newton's method from the direction of the last sweep.
const MOST_NEWTON: usize = 8;

/// (2) at one contact whose rate without its own force is `rate`.
pub(super) fn local(
    a: &Matrix3<f64>,
    inverse: &Inverse,
    rate: &Vector3<f64>,
    law: &Law,
    guess: &Vector3<f64>,
) -> (Vector3<f64>, ConeState) {
    if let Law::Bounded { bound } = *law {
        let (force, holds) = bounded(a, rate, bound);
        return (force, if holds { ConeState::Stick } else { ConeState::Slip });
    }
    if rate.x >= 0.0 || !(a[(0, 0)] > 0.0) {
        return (Vector3::zeros(), ConeState::Open);
    }
    match *law {
        Law::Bounded { .. } => (Vector3::zeros(), ConeState::Open),
        Law::Sliding { friction, direction } => {
            let (push, resist) = pressed(a, friction, &direction);
            // Painlevé's: pressing harder does not lift it.
            if resist > 0.0 {
                (push * (-rate.x / resist), ConeState::Slip)
            } else {
                (push * f64::INFINITY, ConeState::Slip)
            }
        }
        Law::Coulomb { stick, slide } => {
            if stick == 0.0 {
                return (Vector3::new(-rate.x / a[(0, 0)], 0.0, 0.0), ConeState::Slip);
            }
            let hold = -(inverse.matrix * rate);
            if hold.x >= 0.0 && hold.yz().norm() <= stick * hold.x {
                return (hold, ConeState::Stick);
            }
            if inverse.singular
                && let Some(hold) = held_otherwise(a, rate, stick, &hold)
            {
                return (hold, ConeState::Stick);
            }
            let guess = if guess.yz() != Vector2::zeros() { -guess.yz() } else { -hold.yz() };
            (slipping(a, rate, slide, &guess), ConeState::Slip)
        }
    }
}

/// The force of a contact that slides in a direction, by its normal part, and how fast that lifts it.
pub(super) fn pressed(a: &Matrix3<f64>, friction: f64, direction: &Vector2<f64>) -> (Vector3<f64>, f64) {
    let push = Vector3::new(1.0, -friction * direction.x, -friction * direction.y);
    (push, a.row(0).transpose().dot(&push))
}

/// `A⁻¹` of one contact; of one whose motions are fewer than three (a point on a hinge) that of least norm (Moore, Penrose).
pub(super) struct Inverse {
    matrix: Matrix3<f64>,
    singular: bool,
}

impl Inverse {
    pub(super) fn of(a: &Matrix3<f64>) -> Self {
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
        ((rate + a * force).norm() <= HOLDS * rate.norm()).then_some(force)
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
            // From the guess to both sides, up to the part opposite to it: 0, 1, -1, 2, …
            for k in 0..count {
                let offset = k.div_ceil(2) as f64 * if k % 2 == 0 { -1.0 } else { 1.0 } - 0.5;
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
