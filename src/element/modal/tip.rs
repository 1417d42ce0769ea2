//! An interface of a modal body: eq. (4) of the parent module, and how it varies.

use crate::element::exponential::{exponential, joined, tangent, tangents};
use crate::spatial::Wrench;
use crate::spatial::link::{LinkAcceleration, LinkMotion, LinkVariation};
use nalgebra::{Matrix3, Vector3};

/// An interface other than the root.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalTip {
    /// Name.
    pub name: String,
    /// `p₀` (m); its axes there are those of the frame.
    pub place: Vector3<f64>,
    /// m columns of `Φ`.
    pub shift: Vec<Vector3<f64>>,
    /// m columns of `Ψ`.
    pub spin: Vec<Vector3<f64>>,
    /// m² of `X`; empty without geometric stiffness.
    pub second: Vec<Vector3<f64>>,
    /// The coordinates that move it.
    pub moved_by: Vec<usize>,
}

/// An interface at a state, in inertial axes.
#[derive(Debug, Clone)]
pub struct TipMotion {
    /// The coordinates that move it.
    pub moved_by: Vec<usize>,
    /// For each of these, how a unit of its rate shifts the interface and turns it.
    pub columns: Vec<(Vector3<f64>, Vector3<f64>)>,
    /// The place in the frame, its rate and second rate for zero second rates of the coordinates; inertial axes.
    arm: [Vector3<f64>; 3],
    /// `W` and its rate, likewise.
    roll: [Vector3<f64>; 2],
    /// `∂W/∂Ψq̇` and its first and second rate, the latter for zero second rates: left trivialized, frame axes.
    left: [Matrix3<f64>; 3],
    /// Rotation vector and its rate, frame axes.
    vector: [Vector3<f64>; 2],
}

/// What an interface moves relative to the frame in one direction, inertial axes.
#[derive(Debug, Clone, Copy, Default)]
struct Own {
    shift: [Vector3<f64>; 3],
    spin: [Vector3<f64>; 3],
}

impl ModalTip {
    /// Column `i` of `Φ + X q`.
    fn shift_at(&self, i: usize, q: &[f64]) -> Vector3<f64> {
        if self.second.is_empty() { self.shift[i] } else { self.shift[i] + self.second_times(i, q) }
    }

    /// `Σⱼ Xᵢⱼ xⱼ`; zero of an empty list.
    fn second_times(&self, i: usize, x: &[f64]) -> Vector3<f64> {
        let m = self.shift.len();
        match self.second.is_empty() || x.is_empty() {
            true => Vector3::zeros(),
            false => self.second[i * m..(i + 1) * m].iter().zip(x).map(|(second, x)| *x * second).sum(),
        }
    }

    fn sum(&self, list: &[Vector3<f64>], x: &[f64]) -> Vector3<f64> {
        self.moved_by.iter().map(|i| x[*i] * list[*i]).sum()
    }

    /// `½ xᵀ X y`, doubled.
    fn second_form(&self, x: &[f64], y: &[f64]) -> Vector3<f64> {
        match self.second.is_empty() || x.is_empty() || y.is_empty() {
            true => Vector3::zeros(),
            false => (0..x.len()).map(|i| x[i] * self.second_times(i, y)).sum(),
        }
    }
}

/// The angular half of the right trivialized tangents along a rotation vector with two derivatives, transposed: the left
/// trivialized ones.
fn left_tangents(vector: [Vector3<f64>; 3]) -> [Matrix3<f64>; 3] {
    let none = Vector3::zeros();
    let [at, rate, second] = vector.map(|v| joined(&none, &v));
    tangents(&at, &rate, &second).map(|b| b.fixed_view::<3, 3>(3, 3).transpose())
}

impl TipMotion {
    /// Room for an interface.
    pub fn new(tip: &ModalTip) -> Self {
        let none = Vector3::zeros();
        Self {
            moved_by: tip.moved_by.clone(),
            columns: vec![(none, none); tip.moved_by.len()],
            arm: [none; 3],
            roll: [none; 2],
            left: [Matrix3::identity(), Matrix3::zeros(), Matrix3::zeros()],
            vector: [none; 2],
        }
    }

    /// From the frame to the interface: eq. (4) with its velocity terms.
    pub fn update(&mut self, tip: &ModalTip, q: &[f64], v: &[f64], frame: &LinkMotion, own: &mut LinkMotion) {
        let moves = v.iter().any(|x| *x != 0.0);
        let none = Vector3::zeros();
        self.vector = [tip.sum(&tip.spin, q), if moves { tip.sum(&tip.spin, v) } else { none }];
        let [at, rate] = self.vector;
        self.left = match moves {
            true => left_tangents([at, rate, none]),
            false => {
                let b = tangent(&joined(&none, &at));
                [b.fixed_view::<3, 3>(3, 3).transpose(), Matrix3::zeros(), Matrix3::zeros()]
            }
        };
        let turn = &frame.turn;
        for (column, i) in self.columns.iter_mut().zip(&tip.moved_by) {
            *column = (turn * tip.shift_at(*i, q), turn * (self.left[0] * tip.spin[*i]));
        }
        let place = tip.place + tip.sum(&tip.shift, q) + 0.5 * tip.second_form(q, q);
        let columns = || self.columns.iter().zip(&tip.moved_by);
        let slip = if moves { columns().map(|((shift, _), i)| v[*i] * shift).sum() } else { none };
        let slip_rate = if moves { turn * tip.second_form(v, v) } else { none };
        self.arm = [turn * place, slip, slip_rate];
        self.roll = [turn * (self.left[0] * rate), turn * (self.left[1] * rate)];
        let ([arm, slip, slip_rate], [roll, roll_rate]) = (self.arm, self.roll);
        let w = frame.angular_velocity;
        let (rotation, _) = exponential(&joined(&none, &at));
        own.turn = turn * rotation;
        own.arm = arm;
        own.position = frame.position + arm;
        own.velocity = frame.velocity + w.cross(&arm) + slip;
        own.angular_velocity = w + roll;
        own.relative = slip;
        own.bias = w.cross(&(w.cross(&arm) + 2.0 * slip)) + slip_rate;
        own.angular_bias = w.cross(&roll) + roll_rate;
    }

    /// How fast the arm from the frame changes, inertial axes (m/s).
    pub fn swing(&self, frame: &LinkMotion) -> Vector3<f64> {
        frame.angular_velocity.cross(&self.arm[0]) + self.arm[1]
    }

    /// The work of a wrench at the interface along each coordinate that moves it.
    pub fn rows<'a>(&'a self, f: &'a Wrench) -> impl Iterator<Item = (usize, f64)> + 'a {
        let row = |(shift, spin): &(Vector3<f64>, Vector3<f64>)| shift.dot(&f.force) + spin.dot(&f.moment);
        self.moved_by.iter().copied().zip(self.columns.iter().map(row))
    }

    /// Adds what second rates of the coordinates add to the acceleration of the interface.
    pub fn accelerate(&self, second: &[f64], a: &mut LinkAcceleration) {
        for ((shift, spin), i) in self.columns.iter().zip(&self.moved_by) {
            a.linear += second[*i] * shift;
            a.angular += second[*i] * spin;
        }
    }

    /// `δp`, its rates, `φ` and its rates for a direction: inertial axes, seen in the frame.
    fn own(&self, tip: &ModalTip, frame: &LinkMotion, at: [&[f64]; 3], by: [&[f64]; 3]) -> Own {
        let [q, v, second] = at;
        let mut own = Own::default();
        let turn = &frame.turn;
        let curves = !tip.second.is_empty();
        let mut spins = [Vector3::zeros(); 3];
        for i in &tip.moved_by {
            for (order, list) in by.iter().enumerate() {
                let Some(x) = list.get(*i).filter(|x| **x != 0.0) else { continue };
                let column = tip.shift_at(*i, q);
                own.shift[order] += *x * column;
                spins[order] += *x * tip.spin[*i];
                if !curves {
                    continue;
                }
                // d/dt of (Φ + X q) δq
                let rate = tip.second_times(*i, v);
                match order {
                    0 => {
                        own.shift[1] += *x * rate;
                        own.shift[2] += *x * tip.second_times(*i, second);
                    }
                    1 => own.shift[2] += 2.0 * *x * rate,
                    _ => {}
                }
            }
        }
        own.shift = own.shift.map(|x| turn * x);
        let [left, first, twice] = self.left_with(tip, second);
        own.spin = [
            left * spins[0],
            first * spins[0] + left * spins[1],
            twice * spins[0] + 2.0 * first * spins[1] + left * spins[2],
        ]
        .map(|x| turn * x);
        own
    }

    /// The left trivialized tangent and its rates, with second rates of the coordinates.
    fn left_with(&self, tip: &ModalTip, second: &[f64]) -> [Matrix3<f64>; 3] {
        let [at, rate] = self.vector;
        let vector = if second.is_empty() { Vector3::zeros() } else { tip.sum(&tip.spin, second) };
        if rate == Vector3::zeros() && vector == Vector3::zeros() {
            return self.left;
        }
        left_tangents([at, rate, vector])
    }

    /// How the interface varies with the frame and with the coordinates, their rates and second rates (empty lists are zero),
    /// about second rates of the coordinates and an acceleration of the frame.
    pub fn vary(
        &self,
        tip: &ModalTip,
        (frame, acceleration): (&LinkMotion, &LinkAcceleration),
        at: [&[f64]; 3],
        p: &LinkVariation,
        by: [&[f64]; 3],
    ) -> LinkVariation {
        let own = self.own(tip, frame, at, by);
        let second = at[2];
        let [arm, slip, mut slip_rate] = self.arm;
        let [roll, mut roll_rate] = self.roll;
        for ((shift, spin), i) in self.columns.iter().zip(&tip.moved_by) {
            slip_rate += second[*i] * shift;
            roll_rate += second[*i] * spin;
        }
        let (w, dw, dt) = (frame.angular_velocity, p.angular_velocity, p.turn);
        let delta_arm = dt.cross(&arm) + own.shift[0];
        let delta_slip = dt.cross(&slip) + own.shift[1];
        let delta_slip_rate = dt.cross(&slip_rate) + own.shift[2];
        // δW = φ̇ + φ × W, δẆ = φ̈ + φ̇ × W + φ × Ẇ in axes that are given
        let [phi, phi_rate, phi_second] = own.spin;
        let delta_roll = dt.cross(&roll) + phi_rate + phi.cross(&roll);
        let delta_roll_rate = dt.cross(&roll_rate) + phi_second + phi_rate.cross(&roll) + phi.cross(&roll_rate);
        let delta_swing = dw.cross(&arm) + w.cross(&delta_arm);
        LinkVariation {
            turn: dt + phi,
            position: p.position + delta_arm,
            angular_velocity: dw + delta_roll,
            velocity: p.velocity + delta_swing + delta_slip,
            angular_acceleration: p.angular_acceleration + dw.cross(&roll) + w.cross(&delta_roll) + delta_roll_rate,
            acceleration: p.acceleration
                + p.angular_acceleration.cross(&arm)
                + acceleration.angular.cross(&delta_arm)
                + dw.cross(&(w.cross(&arm) + 2.0 * slip))
                + w.cross(&(delta_swing + 2.0 * delta_slip))
                + delta_slip_rate,
        }
    }

    /// `Γ` of the interface: how the rows `Zᵀ f` of a wrench change with the coordinates while the wrench turns with the
    /// interface; given to `put` for every pair of coordinates that move it.
    pub fn curvature(&self, tip: &ModalTip, frame: &LinkMotion, f: &Wrench, mut put: impl FnMut(usize, usize, f64)) {
        let (force, moment) = (frame.turn.tr_mul(&f.force), frame.turn.tr_mul(&f.moment));
        // In axes of the frame the wrench turns by φ: δ(zᵀ f) = (δz)ᵀ f + zᵀ (φ × f), less zᵀ δ'f.
        let along: [Matrix3<f64>; 3] = std::array::from_fn(|axis| {
            let unit = Vector3::ith(axis, 1.0);
            left_tangents([self.vector[0], unit, Vector3::zeros()])[1]
        });
        let m = tip.shift.len();
        for (&j, (_, spin)) in tip.moved_by.iter().zip(&self.columns) {
            let phi = frame.turn.tr_mul(spin);
            let (turned_force, turned_moment) = (phi.cross(&force), phi.cross(&moment));
            let varied: Matrix3<f64> = (0..3).map(|axis| tip.spin[j][axis] * along[axis]).sum();
            for (&i, (shift, own)) in tip.moved_by.iter().zip(&self.columns) {
                let (shift, own) = (frame.turn.tr_mul(shift), frame.turn.tr_mul(own));
                let second = tip.second.get(i * m + j).map_or(0.0, |second| second.dot(&force));
                let entry =
                    second + (varied * tip.spin[i]).dot(&moment) + shift.dot(&turned_force) + own.dot(&turned_moment);
                put(i, j, entry);
            }
        }
    }
}
