//! The stations of an element at a state, in inertial axes.

use super::exponential::{halves, joined};
use super::rod::Rod;
use crate::spatial::link::LinkMotion;
use crate::spatial::{Sym3, Wrench};
use nalgebra::{Matrix3, Vector3, Vector6};

/// A station: the frame at the end of a step.
#[derive(Debug, Clone, Copy)]
pub struct Station {
    /// Its place and motion, and its slice's inertia; the arm and the velocity terms are those from the station before it.
    pub link: LinkMotion,
    /// `W`: its twist against the station before it.
    pub twist: Vector6<f64>,
    /// `Ż q̇`: its rate while the second rates of the coordinates are zero.
    pub twist_bias: Vector6<f64>,
}

/// An element at a state. Station 0 is its root frame, the last one its tip, which is the root marker of its link.
#[derive(Debug, Clone)]
pub struct RodMotion {
    /// `K + 1` of them.
    pub stations: Vec<Station>,
    /// `Z` of the steps, K×m columns.
    subspaces: Vec<Vector6<f64>>,
    /// The twist of the tip for a unit of each coordinate while the root stays: `H` of the element as one hinge.
    pub tip: Vec<Vector6<f64>>,
    /// The coordinates and their rates.
    pub q: Vec<f64>,
    /// See `q`.
    pub v: Vec<f64>,
    /// Whether a rate is not zero.
    pub moves: bool,
}

impl RodMotion {
    /// Room for an element.
    pub fn new(rod: &Rod) -> Self {
        let (m, steps) = (rod.count(), rod.steps());
        Self {
            stations: vec![
                Station { link: LinkMotion::GROUND, twist: Vector6::zeros(), twist_bias: Vector6::zeros() };
                steps + 1
            ],
            subspaces: vec![Vector6::zeros(); steps * m],
            tip: vec![Vector6::zeros(); m],
            q: vec![0.0; m],
            v: vec![0.0; m],
            moves: false,
        }
    }

    /// `Z` of the step that ends at a station, one column per coordinate (m or 1 per coordinate).
    pub fn subspace(&self, station: usize) -> &[Vector6<f64>] {
        let m = self.q.len();
        &self.subspaces[(station - 1) * m..station * m]
    }

    /// Root → tip: eqs. (2) to (4). `offset` and `turn` place the root frame on the parent link; `own` is the link of the
    /// tip, of which place, motion, arm and velocity terms are written.
    pub fn update(
        &mut self,
        rod: &Rod,
        (offset, turn): (&Vector3<f64>, &Matrix3<f64>),
        parent: &LinkMotion,
        (q, v): (&[f64], &[f64]),
        own: &mut LinkMotion,
    ) {
        self.q.copy_from_slice(q);
        self.v.copy_from_slice(v);
        self.moves = v.iter().any(|x| *x != 0.0);
        self.stations[0] = root(offset, turn, parent);
        self.tip.fill(Vector6::zeros());
        let m = q.len();
        for k in 0..rod.steps() {
            let (before, from_here) = self.stations.split_at_mut(k + 1);
            let (last, next) = (&before[k].link, &mut from_here[0]);
            let local = if self.moves { rod.moving(k, q, v, &[]) } else { rod.still(k, q) };
            let (r, p) = local.pose();
            let turn = last.turn * r;
            let at = &mut next.link;
            (at.turn, at.arm) = (turn, last.turn * p);
            at.position = last.position + at.arm;
            if rod.slices[k + 1].inertia != Sym3::ZERO {
                at.inertia = rod.slices[k + 1].inertia.turned(&turn);
            }
            let turned = |x: &Vector6<f64>| {
                let (linear, angular) = halves(x);
                joined(&(turn * linear), &(turn * angular))
            };
            for i in 0..m {
                let z = turned(&local.subspace(i));
                self.subspaces[k * m + i] = z;
                self.tip[i] = carried(&self.tip[i], &at.arm) + z;
            }
            let [twist, bias] = if self.moves { local.rates().map(|x| turned(&x)) } else { [Vector6::zeros(); 2] };
            (next.twist, next.twist_bias) = (twist, bias);
            relative_motion(last, &twist, &bias, at);
        }
        self.close(parent, own);
    }

    /// What the link of the tip is across the whole element.
    fn close(&self, parent: &LinkMotion, own: &mut LinkMotion) {
        let tip = &self.stations[self.stations.len() - 1].link;
        (own.turn, own.position) = (tip.turn, tip.position);
        (own.velocity, own.angular_velocity) = (tip.velocity, tip.angular_velocity);
        own.arm = tip.position - parent.position;
        (own.bias, own.angular_bias) = (Vector3::zeros(), Vector3::zeros());
        for station in &self.stations {
            let at = &station.link;
            own.bias += own.angular_bias.cross(&at.arm) + at.bias;
            own.angular_bias += at.angular_bias;
        }
    }

    /// `Hᵀ f` of the element as one hinge, in one coordinate, for a wrench at its tip.
    pub fn project(&self, i: usize, wrench: &Wrench) -> f64 {
        row(&self.tip[i], wrench)
    }
}

/// The work of a wrench along a twist.
#[inline(always)]
pub(crate) fn row(twist: &Vector6<f64>, wrench: &Wrench) -> f64 {
    let (linear, angular) = halves(twist);
    linear.dot(&wrench.force) + angular.dot(&wrench.moment)
}

/// A twist as seen `arm` away.
fn carried(twist: &Vector6<f64>, arm: &Vector3<f64>) -> Vector6<f64> {
    let (linear, angular) = halves(twist);
    joined(&(linear + angular.cross(arm)), &angular)
}

fn root(offset: &Vector3<f64>, turn: &Matrix3<f64>, parent: &LinkMotion) -> Station {
    let (arm, w) = (parent.turn * offset, parent.angular_velocity);
    let swing = w.cross(&arm);
    let link = LinkMotion {
        turn: parent.turn * turn,
        position: parent.position + arm,
        velocity: parent.velocity + swing,
        angular_velocity: w,
        arm,
        bias: w.cross(&swing),
        ..LinkMotion::GROUND
    };
    Station { link, twist: Vector6::zeros(), twist_bias: Vector6::zeros() }
}

/// Velocities and velocity terms across a step: `ω̇⁺ = ω̇ + ω × w + ẇ`, `r̈⁺ = r̈ + ω̇ × d + ω × (ω × d + 2 v) + w × v + v̇` with the
/// relative twist (v, w) and its rate in axes that turn with the station.
fn relative_motion(last: &LinkMotion, twist: &Vector6<f64>, bias: &Vector6<f64>, at: &mut LinkMotion) {
    let ((v, w), (v_rate, w_rate)) = (halves(twist), halves(bias));
    let omega = last.angular_velocity;
    let swing = omega.cross(&at.arm);
    at.velocity = last.velocity + swing + v;
    at.angular_velocity = omega + w;
    at.bias = omega.cross(&(swing + 2.0 * v)) + w.cross(&v) + v_rate;
    at.angular_bias = omega.cross(&w) + w_rate;
}
