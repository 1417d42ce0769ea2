//! The element: what of eqs. (1) to (7) does not change.

mod local;
mod sixth;

use super::exponential::{bracket, exponential, tangent, tangent_and_rate, tangents};
use super::guide::Guide;
use super::quadrature::GAUSS;
use crate::spatial::Sym3;
pub use local::Local;
use local::Strained;
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use sixth::Sixth;
use std::sync::Arc;

/// Legendre polynomials `P₀ … P₂`.
fn legendre(t: f64) -> [f64; 3] {
    [1.0, t, 0.5 * (3.0 * t * t - 1.0)]
}

/// Nodes and weights of the Gauss–Lobatto quadrature of `p + 3` points on [−1, 1].
fn lobatto(degree: usize) -> Vec<(f64, f64)> {
    let (inner, outer) = ((1.0_f64 / 5.0).sqrt(), (3.0_f64 / 7.0).sqrt());
    match degree {
        0 => vec![(-1.0, 1.0 / 3.0), (0.0, 4.0 / 3.0), (1.0, 1.0 / 3.0)],
        1 => vec![(-1.0, 1.0 / 6.0), (-inner, 5.0 / 6.0), (inner, 5.0 / 6.0), (1.0, 1.0 / 6.0)],
        _ => vec![(-1.0, 0.1), (-outer, 49.0 / 90.0), (0.0, 32.0 / 45.0), (outer, 49.0 / 90.0), (1.0, 0.1)],
    }
}

/// Coordinates of an element, at most: six strains of degree 2.
pub const MOST_COORDINATES: usize = 18;

/// What a cross section has per length, in its own axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RodSection {
    /// `C`, from strains to section forces: stretch, shear y and z (N); twist, bending about y and z (N m²).
    pub stiffness: Matrix6<f64>,
    /// Mass per length (kg/m).
    pub mass: f64,
    /// Rotary inertia about the axes (kg m).
    pub rotary: Vector3<f64>,
}

/// A slice of mass at a station, and the length of rod that it stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slice {
    /// Mass (kg).
    pub mass: f64,
    /// About the station, section axes (kg m²).
    pub inertia: Sym3,
    /// Weight of the quadrature (m).
    pub length: f64,
    /// From the root of the element (m).
    pub at: f64,
}

/// One step of eq. (3).
#[derive(Debug, Clone, PartialEq)]
struct Step {
    length: f64,
    /// `I₀`, `I₁` and `I₂` of the reference strain.
    reference: [Vector6<f64>; 3],
    /// What a unit of a coordinate of each degree adds to them.
    per_degree: [[f64; 3]; 3],
}

/// A flexible element, or a guide: an element of one coordinate and one step without mass or stiffness, whose step is a
/// curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Rod {
    /// `h` (m).
    pub length: f64,
    /// `η` (s).
    pub damping: f64,
    /// Force per length beside gravity (N/m); in section axes if it follows them.
    pub load: Vector3<f64>,
    /// Whether the load follows the section's axes.
    pub follows: bool,
    /// `C` at the stations.
    pub sections: Vec<Matrix6<f64>>,
    /// The stations, `K + 1` of them. The slices of the first and the last belong to the links there.
    pub slices: Vec<Slice>,
    steps: Vec<Step>,
    free: Vec<usize>,
    degree: usize,
    /// `ξ₀` by Legendre coefficients.
    reference: Vec<Vector6<f64>>,
    /// `Kₑ`, row by row.
    stiffness: Vec<f64>,
    /// In place of the strains.
    guide: Option<Arc<Guide>>,
}

impl Rod {
    /// An element of length `h` (m) and degree 0, 1 or 2 with these free strains (0 stretch, 1 and 2 shear, 3 twist, 4 and 5
    /// bending), reference strain by Legendre coefficients, and section at a distance from its root (m).
    pub fn new(
        length: f64,
        degree: usize,
        free: &[usize],
        reference: &[Vector6<f64>],
        section: impl Fn(f64) -> RodSection,
    ) -> Self {
        let at = |t: f64| 0.5 * length * (1.0 + t);
        let stations = lobatto(degree);
        let slice = |(t, w): &(f64, f64)| {
            let (of, span) = (section(at(*t)), 0.5 * w * length);
            Slice { mass: span * of.mass, inertia: Sym3::diagonal(span * of.rotary), length: span, at: at(*t) }
        };
        let m = free.len() * (degree + 1);
        let mut stiffness = vec![0.0; m * m];
        for (t, w) in GAUSS {
            let (of, p) = (section(at(t)), legendre(t));
            for i in 0..m {
                for j in 0..m {
                    let entry = of.stiffness[(free[i % free.len()], free[j % free.len()])];
                    stiffness[i * m + j] += 0.5 * w / length * p[i / free.len()] * p[j / free.len()] * entry;
                }
            }
        }
        Self {
            length,
            damping: 0.0,
            load: Vector3::zeros(),
            follows: false,
            sections: stations.iter().map(|(t, _)| section(at(*t)).stiffness).collect(),
            slices: stations.iter().map(slice).collect(),
            steps: stations.windows(2).map(|ends| Step::new(length, [ends[0].0, ends[1].0], reference)).collect(),
            free: free.to_vec(),
            degree,
            reference: reference.to_vec(),
            stiffness,
            guide: None,
        }
    }

    /// A guide.
    pub fn guided(guide: Guide) -> Self {
        let [from, to] = guide.range();
        let end = |at: f64| Slice { mass: 0.0, inertia: Sym3::ZERO, length: 0.0, at };
        let length = to - from;
        Self {
            length,
            damping: 0.0,
            load: Vector3::zeros(),
            follows: false,
            sections: Vec::new(),
            slices: vec![end(0.0), end(length)],
            steps: vec![Step::new(length, [-1.0, 1.0], &[])],
            free: vec![0],
            degree: 0,
            reference: Vec::new(),
            stiffness: vec![0.0],
            guide: Some(Arc::new(guide)),
        }
    }

    /// The curve, if it is a guide.
    pub fn guide(&self) -> Option<&Arc<Guide>> {
        self.guide.as_ref()
    }

    /// The coordinates whose strains are nearest to given ones: by (1) the projection on the polynomials.
    pub fn fit(&self, strain: impl Fn(f64) -> Vector6<f64>) -> Vec<f64> {
        let mut q = vec![0.0; self.count()];
        for (t, w) in GAUSS {
            let p = legendre(t);
            let reference: Vector6<f64> = self.reference.iter().zip(p).map(|(of, p)| p * of).sum();
            let beyond = strain(0.5 * self.length * (1.0 + t)) - reference;
            for (i, q) in q.iter_mut().enumerate() {
                let degree = i / self.free.len();
                *q += 0.5 * w * self.length * (2 * degree + 1) as f64 * p[degree] * beyond[self.strain_of(i)];
            }
        }
        q
    }

    /// Number of coordinates, `m`.
    pub fn count(&self) -> usize {
        self.free.len() * (self.degree + 1)
    }

    /// Number of steps, `K`.
    pub fn steps(&self) -> usize {
        self.steps.len()
    }

    /// The strain that a coordinate belongs to.
    pub fn strain_of(&self, coordinate: usize) -> usize {
        self.free[coordinate % self.free.len()]
    }

    /// The strain without load by Legendre coefficients, constant part first.
    pub fn reference(&self) -> &[Vector6<f64>] {
        &self.reference
    }

    /// The strains that are free.
    pub fn free_strains(&self) -> impl Iterator<Item = usize> + '_ {
        self.free.iter().copied()
    }

    /// The load at a station with this weight of the quadrature, in inertial axes.
    pub fn load_at(&self, station: usize, turn: &Matrix3<f64>) -> Vector3<f64> {
        let load = self.slices[station].length * self.load;
        if self.follows { turn * load } else { load }
    }

    /// One row of `Kₑ`.
    pub fn stiffness_row(&self, i: usize) -> &[f64] {
        let m = self.count();
        &self.stiffness[i * m..(i + 1) * m]
    }

    /// `Kₑ x` in one coordinate.
    pub fn elastic(&self, i: usize, x: &[f64]) -> f64 {
        self.stiffness_row(i).iter().zip(x).map(|(k, x)| k * x).sum()
    }

    /// Eq. (1): the strain less the reference strain, at a distance from the root (m).
    pub fn strained(&self, s: f64, q: &[f64]) -> Vector6<f64> {
        let p = legendre(2.0 * s / self.length - 1.0);
        let mut strain = Vector6::zeros();
        for (i, q) in q.iter().enumerate().take(self.count()) {
            strain[self.strain_of(i)] += p[i / self.free.len()] * q / self.length;
        }
        strain
    }

    /// The length of the centre line with these strains (m).
    pub fn stretched(&self, q: &[f64]) -> f64 {
        self.integral(q, |strain| strain.fixed_rows::<3>(0).norm())
    }

    /// How far its sections turn along it with these strains, what turns back counted, too (rad).
    pub fn winding(&self, q: &[f64]) -> f64 {
        self.integral(q, |strain| strain.fixed_rows::<3>(3).norm())
    }

    /// The integral of something that follows from the strain of eq. (1).
    fn integral(&self, q: &[f64], of: impl Fn(&Vector6<f64>) -> f64) -> f64 {
        let part = |(t, w): (f64, f64)| {
            let s = 0.5 * self.length * (1.0 + t);
            let reference: Vector6<f64> = self.reference.iter().zip(legendre(t)).map(|(of, p)| p * of).sum();
            0.5 * w * self.length * of(&(reference + self.strained(s, q)))
        };
        GAUSS.into_iter().map(part).sum()
    }

    /// The largest angle that one of the steps turns by, and that the whole element does (rad).
    pub fn turned(&self, q: &[f64]) -> [f64; 2] {
        let angle = |step: usize| self.moments(step, q, true)[0].fixed_rows::<3>(3).norm();
        let angles = (0..self.steps.len()).map(angle);
        angles.fold([0.0, 0.0], |[most, sum], angle| [f64::max(most, angle), sum + angle])
    }

    /// Where a point stands in the axes of the element's root: turn and place. By a step of its own from the station before
    /// it: as exact as the stations are.
    pub fn pose_at(&self, s: f64, q: &[f64]) -> (Matrix3<f64>, Vector3<f64>) {
        let (mut turn, mut place) = (Matrix3::identity(), Vector3::zeros());
        for (k, step) in self.steps.iter().enumerate() {
            let begin = self.slices[k].at;
            if s <= begin {
                break;
            }
            let twist = if s >= self.slices[k + 1].at {
                self.twist(step, q)
            } else {
                let ends = [begin, s].map(|s| 2.0 * s / self.length - 1.0);
                self.twist(&Step::new(self.length, ends, &self.reference), q)
            };
            let (r, p) = exponential(&twist);
            place += turn * p;
            turn *= r;
        }
        (turn, place)
    }

    /// `Ω` of a step: eq. (3), of 6th order in an element of degree 2.
    fn twist(&self, step: &Step, q: &[f64]) -> Vector6<f64> {
        if self.degree == 2 {
            return sixth::twist(self.three_moments(step, q, true), step.length);
        }
        let [i0, i1] = self.moments_of(step, q, true);
        i0 + bracket(&i0, &i1) / step.length
    }

    /// `I₀` and `I₁` of a step; without the reference of a velocity or acceleration.
    fn moments(&self, step: usize, q: &[f64], with_reference: bool) -> [Vector6<f64>; 2] {
        self.moments_of(&self.steps[step], q, with_reference)
    }

    fn moments_of(&self, step: &Step, q: &[f64], with_reference: bool) -> [Vector6<f64>; 2] {
        let mut i = if with_reference { [step.reference[0], step.reference[1]] } else { [Vector6::zeros(); 2] };
        for (index, x) in q.iter().enumerate().take(self.count()) {
            let (strain, degree) = (self.strain_of(index), index / self.free.len());
            i[0][strain] += step.per_degree[0][degree] * x;
            i[1][strain] += step.per_degree[1][degree] * x;
        }
        i
    }

    /// `I₀`, `I₁` and `I₂` of a step; without the reference of a velocity or acceleration.
    fn three_moments(&self, step: &Step, q: &[f64], with_reference: bool) -> [Vector6<f64>; 3] {
        let mut i = if with_reference { step.reference } else { [Vector6::zeros(); 3] };
        for (index, x) in q.iter().enumerate().take(self.count()) {
            let (strain, degree) = (self.strain_of(index), index / self.free.len());
            i.iter_mut().zip(&step.per_degree).for_each(|(i, weights)| i[strain] += weights[degree] * x);
        }
        i
    }

    /// A step at coordinates alone.
    pub fn still(&self, step: usize, q: &[f64]) -> Local<'_> {
        match &self.guide {
            Some(guide) => Local::guided(guide.at(q[0]), [0.0; 2]),
            None if self.degree == 2 => Local::Sixth(Sixth::still(self, step, q)),
            None => Local::Strained(self.strained_still(step, q)),
        }
    }

    fn strained_still(&self, step: usize, q: &[f64]) -> Strained<'_> {
        let moments = self.moments(step, q, true);
        let none = Vector6::zeros();
        let twist = moments[0] + bracket(&moments[0], &moments[1]) / self.steps[step].length;
        let b = [tangent(&twist), Matrix6::zeros(), Matrix6::zeros()];
        Strained {
            rod: self,
            step: &self.steps[step],
            twist,
            b,
            moments: [moments, [none; 2], [none; 2]],
            moves: false,
        }
    }

    /// A step at coordinates with their rates and second rates; without the latter `Z̈` is not known.
    pub fn moving(&self, step: usize, q: &[f64], qd: &[f64], qdd: &[f64]) -> Local<'_> {
        if let Some(guide) = &self.guide {
            let second = qdd.first().copied().unwrap_or(0.0);
            return Local::guided(guide.at(q[0]), [qd[0], second]);
        }
        if self.degree == 2 {
            return Local::Sixth(Sixth::moving(self, step, [q, qd, qdd]));
        }
        let l = self.steps[step].length;
        let at @ [i0, i1] = self.moments(step, q, true);
        let twist = i0 + bracket(&i0, &i1) / l;
        let first = self.moments(step, qd, false);
        let bilinear = |a: &[Vector6<f64>; 2]| a[0] + (bracket(&a[0], &i1) + bracket(&i0, &a[1])) / l;
        let rate = bilinear(&first);
        let (second, b) = if qdd.is_empty() {
            let [b, of_rate] = tangent_and_rate(&twist, &rate);
            ([Vector6::zeros(); 2], [b, of_rate, Matrix6::zeros()])
        } else {
            let second = self.moments(step, qdd, false);
            let rate_of_rate = bilinear(&second) + 2.0 * bracket(&first[0], &first[1]) / l;
            (second, tangents(&twist, &rate, &rate_of_rate))
        };
        let step = &self.steps[step];
        Local::Strained(Strained { rod: self, step, twist, b, moments: [at, first, second], moves: true })
    }
}

impl Step {
    /// Between two places on [−1, 1] of an element of this length.
    fn new(length: f64, ends: [f64; 2], reference: &[Vector6<f64>]) -> Self {
        let (middle, half) = (0.5 * (ends[0] + ends[1]), 0.5 * (ends[1] - ends[0]));
        let mut of = [[0.0; 3]; 3];
        for (t, w) in GAUSS {
            let (weight, offset) = (0.5 * w * half * length, 0.5 * half * t * length);
            for (degree, p) in legendre(middle + half * t).into_iter().enumerate() {
                of[0][degree] += weight * p;
                of[1][degree] += weight * offset * p;
                of[2][degree] += weight * offset * offset * p;
            }
        }
        let moment = |of: &[f64; 3]| reference.iter().zip(of).map(|(strain, weight)| *weight * strain).sum();
        Self {
            length: half * length,
            reference: [moment(&of[0]), moment(&of[1]), moment(&of[2])],
            per_degree: of.map(|of| of.map(|x| x / length)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rod(length: f64, degree: usize) -> Rod {
        let reference =
            [Vector6::new(1.0, 0.1, -0.1, 0.5, 0.8, -0.4), length * Vector6::new(0.1, 0.0, 0.2, 0.7, -0.3, 0.5)];
        let section = RodSection { stiffness: Matrix6::identity(), mass: 1.0, rotary: Vector3::new(0.2, 0.1, 0.1) };
        Rod::new(length, degree, &[0, 1, 2, 3, 4, 5], &reference, |_| section)
    }

    /// The end of an element, by steps of second order that are extrapolated.
    fn by_many(rod: &Rod, q: &[f64]) -> Vector3<f64> {
        let march = |steps: usize| {
            let (mut turn, mut at) = (Matrix3::identity(), Vector3::zeros());
            for i in 0..steps {
                let s = rod.length * (i as f64 + 0.5) / steps as f64;
                let strain = rod.reference[0] + (2.0 * s / rod.length - 1.0) * rod.reference[1] + rod.strained(s, q);
                let (r, p) = exponential(&(strain * rod.length / steps as f64));
                at += turn * p;
                turn *= r;
            }
            at
        };
        (4.0 * march(4000) - march(2000)) / 3.0
    }

    /// Halving an element divides the error of its end by 32, of degree 2 by 128: local orders 5 and 7.
    #[test]
    fn steps_are_of_fourth_and_sixth_order() {
        for (degree, lengths, local) in [(1, [0.4, 0.2, 0.1], 5.0), (2, [0.8, 0.4, 0.2], 7.0)] {
            let errors: Vec<f64> = lengths
                .into_iter()
                .map(|h| {
                    let rod = rod(h, degree);
                    let size = |i: usize| 0.2 * h.powi(1 + i as i32 / 6);
                    let q: Vec<f64> = (0..rod.count()).map(|i| size(i) * (1.3 * i as f64).sin()).collect();
                    (rod.pose_at(h, &q).1 - by_many(&rod, &q)).norm()
                })
                .collect();
            for pair in errors.windows(2) {
                let order = (pair[0] / pair[1]).log2();
                assert!((order - local).abs() < 0.4, "degree {degree}: errors {errors:?}");
            }
        }
    }

    /// Columns of Z, Ż and Z̈ are derivatives of the pose along the motion.
    #[test]
    fn subspaces_are_derivatives() {
        for degree in [1, 2] {
            columns_are_derivatives(&rod(0.7, degree));
        }
    }

    fn columns_are_derivatives(rod: &Rod) {
        let wave = |a: f64| (0..rod.count()).map(|i| 0.3 * (a + 1.7 * i as f64).sin()).collect::<Vec<f64>>();
        let (q, qd, qdd) = (wave(0.0), wave(1.0), wave(2.0));
        let at = |t: f64| -> Vec<f64> { (0..q.len()).map(|i| q[i] + t * qd[i] + 0.5 * t * t * qdd[i]).collect() };
        let h = 1e-3;
        for step in 0..rod.steps() {
            let whole = rod.moving(step, &q, &qd, &qdd);
            for i in 0..rod.count() {
                let z = |t: f64| rod.still(step, &at(t)).subspace(i);
                let [zero, first, second] = whole.subspaces(i);
                let by_first = (8.0 * (z(h) - z(-h)) - (z(2.0 * h) - z(-2.0 * h))) / (12.0 * h);
                let by_second = (16.0 * (z(h) + z(-h)) - z(2.0 * h) - z(-2.0 * h) - 30.0 * z(0.0)) / (12.0 * h * h);
                assert!((zero - z(0.0)).amax() < 1e-14);
                assert!((first - by_first).amax() < 1e-10 && (second - by_second).amax() < 1e-7);
                let mut moved = q.clone();
                moved[i] += 1e-6;
                let (turn, arm) = whole.pose();
                let (other, place) = rod.still(step, &moved).pose();
                let shift = turn.tr_mul(&(place - arm)) / 1e-6;
                let spin = turn.tr_mul(&((other - turn) / 1e-6));
                let seen = Vector6::new(shift.x, shift.y, shift.z, spin[(2, 1)], spin[(0, 2)], spin[(1, 0)]);
                assert!((seen - zero).amax() < 1e-5, "{seen} {zero}");
            }
            let [w, g] = whole.rates();
            let sum = |order: usize| (0..rod.count()).map(|i| whole.subspaces(i)[order] * qd[i]).sum::<Vector6<f64>>();
            let still = rod.moving(step, &q, &qd, &vec![0.0; q.len()]);
            let biased = (0..rod.count()).map(|i| still.subspaces(i)[1] * qd[i]).sum::<Vector6<f64>>();
            assert!((w - sum(0)).amax() < 1e-13 && (g - biased).amax() < 1e-12);
        }
    }

    #[test]
    fn the_curvature_is_the_derivative_of_the_row() {
        for degree in [1, 2] {
            curvature_is_the_derivative_of_the_row(&rod(0.7, degree));
        }
    }

    fn curvature_is_the_derivative_of_the_row(rod: &Rod) {
        let q: Vec<f64> = (0..rod.count()).map(|i| 0.3 * (1.0 + 1.7 * i as f64).sin()).collect();
        let f = Vector6::new(0.9, -1.2, 0.4, 0.3, 0.8, -0.6);
        for step in 0..rod.steps() {
            let at = rod.still(step, &q);
            let gradient = at.gradient(&f);
            for j in 0..rod.count() {
                let h = 1e-3;
                let moved =
                    |t: f64| -> Vec<f64> { (0..q.len()).map(|i| q[i] + if i == j { t } else { 0.0 }).collect() };
                for i in 0..rod.count() {
                    let row = |t: f64| rod.still(step, &moved(t)).subspace(i).dot(&f);
                    let by = (8.0 * (row(h) - row(-h)) - (row(2.0 * h) - row(-2.0 * h))) / (12.0 * h);
                    assert!((at.curvature(&gradient, i, j) - by).abs() < 1e-10, "{i} {j}");
                }
            }
        }
    }
}
