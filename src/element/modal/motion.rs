//! A modal body at a state: eqs. (1) and (3) of the parent module in inertial axes.

use super::{Modal, TipMotion};
use crate::spatial::link::{LinkAcceleration, LinkMotion, LinkVariation};
use crate::spatial::{Sym3, Wrench};
use nalgebra::{Matrix3, Vector3};

/// A modal body at a state. What has m entries is by coordinate; vectors and tensors are in inertial axes unless a name says
/// otherwise.
#[derive(Debug, Clone)]
pub struct ModalMotion {
    /// The coordinates and their rates.
    pub q: Vec<f64>,
    /// See `q`.
    pub v: Vec<f64>,
    /// Whether a rate is not zero.
    pub moves: bool,
    /// `s` (kg m).
    pub first: Vector3<f64>,
    /// `J` about the frame (kg m²).
    pub inertia: Sym3,
    /// `[Cᵢ; Gᵢ]`: what the frame gets from a unit of `q̈ᵢ`.
    pub columns: Vec<Wrench>,
    /// What the velocities add to force and moment at the frame.
    pub bias: Wrench,
    /// What the velocities add to the rows.
    pub row_bias: Vec<f64>,
    /// The interfaces.
    pub tips: Vec<TipMotion>,
    /// In frame axes: `∂J/∂qᵢ`, `Σⱼ G₁ᵢⱼ q̇ⱼ` and `Σⱼ G₁ⱼᵢ q̇ⱼ`, `Ċᵢ`; `w`.
    slopes: Vec<Sym3>,
    turning: Vec<[Vector3<f64>; 2]>,
    drift: Vec<Vector3<f64>>,
    spin: Vector3<f64>,
    /// In frame axes: `C q̇`, `G q̇`, `J̇`.
    flow: Vector3<f64>,
    roll: Vector3<f64>,
    inertia_rate: Sym3,
}

fn scaled(j: &Sym3, s: f64) -> Sym3 {
    Sym3 { xx: s * j.xx, yy: s * j.yy, zz: s * j.zz, xy: s * j.xy, xz: s * j.xz, yz: s * j.yz }
}

fn turned(turn: &Matrix3<f64>, force: &Vector3<f64>, moment: &Vector3<f64>) -> Wrench {
    Wrench { force: turn * force, moment: turn * moment }
}

impl ModalMotion {
    /// Room for a body.
    pub fn new(modal: &Modal) -> Self {
        let (m, none) = (modal.count(), Vector3::zeros());
        Self {
            q: vec![0.0; m],
            v: vec![0.0; m],
            moves: false,
            first: none,
            inertia: Sym3::ZERO,
            columns: vec![Wrench::ZERO; m],
            bias: Wrench::ZERO,
            row_bias: vec![0.0; m],
            tips: modal.tips.iter().map(TipMotion::new).collect(),
            slopes: vec![Sym3::ZERO; m],
            turning: vec![[none; 2]; m],
            drift: vec![none; m],
            spin: none,
            flow: none,
            roll: none,
            inertia_rate: Sym3::ZERO,
        }
    }

    /// Everything that follows from coordinates, rates and the motion of the frame, but for the interfaces.
    pub fn update(&mut self, modal: &Modal, q: &[f64], v: &[f64], frame: &LinkMotion) {
        let (m, turn) = (q.len(), &frame.turn);
        self.q.copy_from_slice(q);
        self.v.copy_from_slice(v);
        self.moves = v.iter().any(|x| *x != 0.0);
        self.spin = turn.tr_mul(&frame.angular_velocity);
        let ((s0, c0, s2), (j0, j1, j2)) = (&modal.first, &modal.inertia);
        let (g0, g1) = &modal.turning;
        let (mut first, mut inertia) = (*s0, *j0);
        (self.flow, self.roll, self.inertia_rate) = (Vector3::zeros(), Vector3::zeros(), Sym3::ZERO);
        let mut drift = Vector3::zeros();
        let mut gyration = Vector3::zeros();
        for i in 0..m {
            let row = i * m..(i + 1) * m;
            let (mut c, mut half) = (c0[i], Vector3::zeros());
            self.drift[i] = Vector3::zeros();
            if !s2.is_empty() {
                for (second, (q, v)) in s2[row.clone()].iter().zip(q.iter().zip(v)) {
                    half += *q * second;
                    self.drift[i] += *v * second;
                }
            }
            first += q[i] * (c + 0.5 * half);
            c += half;
            let mut half = Sym3::ZERO;
            j2[row].iter().zip(q).for_each(|(second, q)| half += scaled(second, *q));
            inertia += scaled(&(j1[i] + half), q[i]);
            self.slopes[i] = j1[i] + scaled(&half, 2.0);
            let (mut g, mut turning) = (g0[i], [Vector3::zeros(); 2]);
            for j in 0..m {
                g += q[j] * g1[j * m + i];
                turning[0] += v[j] * g1[i * m + j];
                turning[1] += v[j] * g1[j * m + i];
            }
            self.turning[i] = turning;
            self.flow += v[i] * c;
            self.roll += v[i] * g;
            self.inertia_rate += scaled(&self.slopes[i], v[i]);
            drift += v[i] * self.drift[i];
            gyration += v[i] * turning[0];
            self.columns[i] = turned(turn, &c, &g);
        }
        let w = self.spin;
        let force = w.cross(&(w.cross(&first) + 2.0 * self.flow)) + drift;
        let moment = w.cross(&(inertia * w + self.roll)) + self.inertia_rate * w + gyration;
        self.bias = turned(turn, &force, &moment);
        for i in 0..m {
            let [out, back] = self.turning[i];
            self.row_bias[i] = w.dot(&(back - out)) - 0.5 * w.dot(&(self.slopes[i] * w));
        }
        self.first = turn * first;
        self.inertia = inertia.turned(turn);
    }

    /// `rows += Σ Zᵀ f` of wrenches on the links of the interfaces, in their order (N or N m).
    pub fn pull<'a>(&self, wrenches: impl Iterator<Item = &'a Wrench>, rows: &mut [f64]) {
        for (tip, wrench) in self.tips.iter().zip(wrenches).filter(|(_, wrench)| **wrench != Wrench::ZERO) {
            tip.rows(wrench).for_each(|(i, row)| rows[i] += row);
        }
    }

    /// Eq. (2) (J).
    pub fn kinetic_energy(&self, modal: &Modal, frame: &LinkMotion) -> f64 {
        let (velocity, w, m) = (frame.turn.tr_mul(&frame.velocity), &self.spin, self.v.len());
        let first = frame.turn.tr_mul(&self.first);
        let inner: f64 = (0..m)
            .map(|i| {
                self.v[i] * modal.mass_matrix[i * m..(i + 1) * m].iter().zip(&self.v).map(|(p, v)| p * v).sum::<f64>()
            })
            .sum();
        0.5 * modal.mass * velocity.norm_squared()
            + velocity.dot(&(w.cross(&first) + self.flow))
            + 0.5 * frame.angular_velocity.dot(&(self.inertia * frame.angular_velocity))
            + w.dot(&self.roll)
            + 0.5 * inner
    }

    /// Eq. (3) for an acceleration of the frame and second rates: force and moment that the body needs at its frame. Without
    /// velocity terms and weight for a change of the accelerations alone (`gravity` is `None`).
    pub fn wrench(
        &self,
        modal: &Modal,
        gravity: Option<&Vector3<f64>>,
        a: &LinkAcceleration,
        second: &[f64],
    ) -> Wrench {
        let linear = gravity.map_or(a.linear, |gravity| a.linear - gravity);
        let mut sum = Wrench {
            force: modal.mass * linear + a.angular.cross(&self.first),
            moment: self.first.cross(&linear) + self.inertia * a.angular,
        };
        if gravity.is_some() {
            sum += self.bias;
        }
        self.columns.iter().zip(second).for_each(|(column, second)| sum.add_times(*second, column));
        sum
    }

    /// Eq. (3) likewise: what the coordinates need, without elasticity and damping.
    pub fn rows(
        &self,
        modal: &Modal,
        gravity: Option<&Vector3<f64>>,
        a: &LinkAcceleration,
        second: &[f64],
        rows: &mut [f64],
    ) {
        let (linear, m) = (gravity.map_or(a.linear, |gravity| a.linear - gravity), second.len());
        for (i, (column, row)) in self.columns.iter().zip(rows).enumerate() {
            let inner = modal.mass_matrix[i * m..(i + 1) * m].iter().zip(second);
            *row = column.force.dot(&linear)
                + column.moment.dot(&a.angular)
                + inner.map(|(p, x)| p * x).sum::<f64>()
                + if gravity.is_some() { self.row_bias[i] } else { 0.0 };
        }
    }

    /// Eq. (3) varied with coordinate `j`, its rate (`c1`) and second rate (`c2`), the frame held: force and moment in axes that
    /// turn with the frame; `rows` get the variations of the rows, without elasticity and damping.
    pub fn column(
        &self,
        modal: &Modal,
        (frame, b, a): (&LinkMotion, &Vector3<f64>, &LinkAcceleration),
        second: &[f64],
        (j, c1, c2): (usize, f64, f64),
        mut rows: impl FnMut(usize, f64),
    ) -> Wrench {
        let (turn, w, m) = (&frame.turn, &self.spin, second.len());
        let (linear, angular) = (turn.tr_mul(b), turn.tr_mul(&a.angular));
        let (_, g1) = &modal.turning;
        let (c, g) = (turn.tr_mul(&self.columns[j].force), turn.tr_mul(&self.columns[j].moment));
        let slope = &self.slopes[j];
        let (s2, j2) = (&modal.first.2, &modal.inertia.2);
        let (mut second_drift, mut slope_rate, mut second_turning) = (Vector3::zeros(), Sym3::ZERO, Vector3::zeros());
        for i in 0..m {
            if !s2.is_empty() {
                second_drift += second[i] * s2[j * m + i];
            }
            if self.moves {
                slope_rate += scaled(&j2[j * m + i], 2.0 * self.v[i]);
            }
            second_turning += second[i] * g1[j * m + i];
        }
        let [out, back] = self.turning[j];
        let force = angular.cross(&c)
            + w.cross(&(w.cross(&c) + 2.0 * (c1 * c + self.drift[j])))
            + c2 * c
            + 2.0 * c1 * self.drift[j]
            + second_drift;
        let moment = c.cross(&linear)
            + *slope * angular
            + w.cross(&(*slope * *w + c1 * g + out))
            + c1 * (*slope * *w)
            + slope_rate * *w
            + c1 * (out + back)
            + c2 * g
            + second_turning;
        for i in 0..m {
            let mut row = angular.dot(&g1[j * m + i]) + c1 * w.dot(&(g1[j * m + i] - g1[i * m + j]))
                - w.dot(&(j2[i * m + j] * *w))
                + c2 * modal.mass_matrix[i * m + j];
            if !s2.is_empty() {
                row += linear.dot(&s2[i * m + j]);
            }
            rows(i, row);
        }
        turned(turn, &force, &moment)
    }

    /// How the rows and the wrench vary with the rate of turn of the frame while its axes are held, beside what a rigid body with
    /// the same first moment and inertia has: `2 C q̇` (kg m/s), `J̇`, `G q̇`, inertial axes.
    pub fn flows(&self, frame: &LinkMotion) -> (Vector3<f64>, Sym3, Vector3<f64>) {
        let turn = &frame.turn;
        (turn * self.flow, self.inertia_rate.turned(turn), turn * self.roll)
    }

    /// How row `i` varies with `δ'ω` of the frame where `z` has `δ'ω̇ − δ'ω×ω`: inertial axes.
    pub fn row_by_rate(&self, i: usize, frame: &LinkMotion) -> Vector3<f64> {
        let [out, back] = self.turning[i];
        let g = frame.turn.tr_mul(&self.columns[i].moment);
        frame.turn * (self.spin.cross(&g) + back - out - self.slopes[i] * self.spin)
    }

    /// The variation of eq. (3) along one direction: what the frame needs more, and in `rows` what the coordinates do. All in
    /// inertial axes, not in turning ones.
    pub fn vary(
        &self,
        modal: &Modal,
        (frame, gravity, a): (&LinkMotion, &Vector3<f64>, &LinkAcceleration),
        second: &[f64],
        p: &LinkVariation,
        by: [&[f64]; 3],
        rows: &mut [f64],
    ) -> Wrench {
        let m = second.len();
        // In turning axes first.
        let b = a.linear - gravity;
        let (dt, w) = (p.turn, frame.angular_velocity);
        let linear = p.acceleration - dt.cross(&b);
        let angular = p.angular_acceleration - dt.cross(&a.angular);
        let rate = p.angular_velocity - dt.cross(&w);
        let (flow, inertia_rate, roll) = self.flows(frame);
        let s = self.first;
        let mut sum = Wrench {
            force: modal.mass * linear
                + angular.cross(&s)
                + rate.cross(&(w.cross(&s)))
                + w.cross(&rate.cross(&s))
                + 2.0 * rate.cross(&flow),
            moment: s.cross(&linear)
                + self.inertia * angular
                + rate.cross(&(self.inertia * w))
                + w.cross(&(self.inertia * rate))
                + inertia_rate * rate
                + rate.cross(&roll),
        };
        for (i, (column, row)) in self.columns.iter().zip(rows.iter_mut()).enumerate() {
            let by_rate = self.row_by_rate(i, frame) - w.cross(&column.moment);
            *row = column.force.dot(&linear) + column.moment.dot(&angular) + by_rate.dot(&rate);
        }
        let part = |list: &[f64], j: usize| list.get(j).copied().unwrap_or(0.0);
        for j in 0..m {
            let [position, velocity, acceleration] = by.map(|list| part(list, j));
            if position != 0.0 {
                let at = (frame, &b, a);
                sum.add_times(position, &self.column(modal, at, second, (j, 0.0, 0.0), |i, x| rows[i] += position * x));
            }
            if velocity == 0.0 && acceleration == 0.0 {
                continue;
            }
            // What is linear in the rates: differences of columns would lose digits.
            let [out, back] = self.turning[j].map(|x| frame.turn * x);
            let c = self.columns[j].force;
            let drift = frame.turn * self.drift[j];
            let slope = self.slopes[j].turned(&frame.turn);
            sum.force += velocity * (2.0 * w.cross(&c) + 2.0 * drift) + acceleration * c;
            let g = self.columns[j].moment;
            sum.moment += velocity * (w.cross(&g) + slope * w + out + back) + acceleration * g;
            let (_, g1) = &modal.turning;
            for (i, row) in rows.iter_mut().enumerate() {
                let gyroscopic = self.spin.dot(&(g1[j * m + i] - g1[i * m + j]));
                *row += velocity * gyroscopic + acceleration * modal.mass_matrix[i * m + j];
            }
        }
        // Back from turning axes.
        let given = self.wrench(modal, Some(gravity), a, second);
        sum.force += dt.cross(&given.force);
        sum.moment += dt.cross(&given.moment);
        sum
    }
}
