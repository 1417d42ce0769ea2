//! Contacts in one place: their directions, how bodies move there, and how the scene answers to what they push with.
//!
//! ```text
//! (1)  u = J v,   u̇ = J q̈ + c:   along the normal g̈, across it the acceleration of what touches,
//!      u̇_t = t·(a_b(p) + ω_b × (ṗ − v_b(p)) − a_a(p) − ω_a × (ṗ − v_a(p))),   p the point of contact, which moves over both
//! (2)  X = M⁻¹ Jᵀ beside loops, drives and gears,   A = J X
//! ```

use super::cone;
use super::geometry::feature::Meeting;
use super::geometry::tangents;
use super::pairs::{Key, Pairs};
use crate::dynamics::Factorized;
use crate::model::Model;
use crate::motion::{Motion, project};
use crate::spatial::Wrench;
use crate::spatial::link::LinkAcceleration;
use nalgebra::{Matrix3, Vector3};

/// Entries of a generalized force that are not zero: velocity coordinate and value.
pub(crate) type Column = Vec<(usize, f64)>;

/// One contact in a place.
#[derive(Debug, Clone)]
pub(crate) struct Frame {
    pub(crate) key: Key,
    pub(crate) meeting: Meeting,
    /// Links of both bodies.
    pub(crate) links: [usize; 2],
    /// Normal and two tangents.
    pub(crate) basis: Matrix3<f64>,
    /// `J` by rows: normal, tangents.
    pub(crate) columns: [Column; 3],
    /// `u`, in the basis (m/s).
    pub(crate) speed: Vector3<f64>,
    /// `c` of (1), in the basis (m/s²).
    pub(crate) bias: Vector3<f64>,
    /// Relative angular velocity (rad/s).
    pub(crate) spin: Vector3<f64>,
}

/// `Σ c x` of a column.
pub(crate) fn along(column: &Column, x: &[f64]) -> f64 {
    column.iter().map(|(i, c)| c * x[*i]).sum()
}

/// Accelerations of all links for hinge accelerations of zero.
pub(crate) fn carried(motion: &Motion, model: &Model, out: &mut Vec<LinkAcceleration>) {
    out.clear();
    out.push(LinkAcceleration::default());
    for (link, at) in model.links.iter().zip(&motion.links).skip(1) {
        let parent = out[link.parent];
        out.push(at.carry(&parent));
    }
}

impl Frame {
    /// A contact where the links of `motion` are; `carried` as [`carried`]. Its first tangent is that of `across`, so that it turns
    /// with the normal and does not jump.
    pub(crate) fn new(
        model: &Model,
        motion: &Motion,
        pairs: &Pairs,
        carried: &[LinkAcceleration],
        key: Key,
        meeting: Meeting,
        across: Option<Vector3<f64>>,
    ) -> Self {
        let pieces = pairs.couples[key.couple].pieces.map(|piece| &pairs.pieces[piece]);
        let links = pieces.map(|piece| piece.link);
        let n = meeting.normal;
        let first = across.and_then(|across| (across - n * n.dot(&across)).try_normalize(0.1));
        let [first, second] = first.map_or_else(|| tangents(&n), |first| [first, n.cross(&first)]);
        let basis = Matrix3::from_columns(&[meeting.normal, first, second]);
        let moving = links.map(|link| &motion.links[link]);
        let (at, velocities) = (moving.map(|link| link.position), moving.map(|link| link.velocity));
        let spins = moving.map(|link| link.angular_velocity);
        let p = meeting.point;
        let drift = meeting.drift(at, velocities, spins);
        // Of a material point at `x`: its velocity, and its acceleration without those of the hinges.
        let speed = |i: usize, x: &Vector3<f64>| velocities[i] + spins[i].cross(&(x - at[i]));
        let accelerated = |i: usize, x: &Vector3<f64>| {
            let (arm, a) = (x - at[i], carried[links[i]]);
            a.linear + a.angular.cross(&arm) + spins[i].cross(&spins[i].cross(&arm))
        };
        let u = speed(1, &p) - speed(0, &p);
        let normal_speed = meeting.normal.dot(&(speed(1, &meeting.cores[1]) - speed(0, &meeting.cores[0])));
        let core = accelerated(1, &meeting.cores[1]) - accelerated(0, &meeting.cores[0]);
        let normal_bias = meeting.normal.dot(&core) + meeting.bias(at, velocities, spins, &drift);
        // The acceleration of the material point is a + ω × (p − x) + ω × (ω × arm); the point moves over the body.
        let moved = |i: usize| {
            let (arm, a) = (p - at[i], carried[links[i]]);
            a.linear + a.angular.cross(&arm) + spins[i].cross(&(drift.point - velocities[i]))
        };
        let across = moved(1) - moved(0);
        let ends = links;
        Self {
            key,
            meeting,
            links,
            basis,
            columns: [0, 1, 2].map(|i| column_of(model, motion, ends, &p, &basis.column(i).into_owned())),
            speed: Vector3::new(normal_speed, first.dot(&u), second.dot(&u)),
            bias: Vector3::new(normal_bias, first.dot(&across), second.dot(&across)),
            spin: spins[1] - spins[0],
        }
    }

    /// Velocity of what touches, across the normal (m/s).
    pub(crate) fn slip(&self) -> Vector3<f64> {
        self.basis.column(1) * self.speed.y + self.basis.column(2) * self.speed.z
    }

    /// `J x`.
    pub(crate) fn rates(&self, x: &[f64]) -> Vector3<f64> {
        Vector3::from_fn(|i, _| along(&self.columns[i], x))
    }

    /// The generalized force of a force on the second body, in the basis.
    pub(crate) fn push(&self, force: &Vector3<f64>, out: &mut [f64]) {
        for (column, f) in self.columns.iter().zip(force) {
            column.iter().for_each(|(i, c)| out[*i] += c * f);
        }
    }

    /// A vector across the normal, in the tangents.
    pub(crate) fn flat(&self, vector: &Vector3<f64>) -> nalgebra::Vector2<f64> {
        nalgebra::Vector2::new(self.basis.column(1).dot(vector), self.basis.column(2).dot(vector))
    }
}

/// `X` of (2) for all three rows of every contact.
pub(crate) fn responses(mass: &mut Factorized<'_>, frames: &[Frame]) -> Vec<[Vec<f64>; 3]> {
    responses_to(mass, frames.iter().map(|frame| &frame.columns))
}

/// `X` of (2) for three rows each.
pub(crate) fn responses_to<'a>(
    mass: &mut Factorized<'_>,
    columns: impl Iterator<Item = &'a [Column; 3]>,
) -> Vec<[Vec<f64>; 3]> {
    let n = mass.system().model().velocity_count();
    let mut impulse = vec![0.0; n];
    let mut answer = |column: &Column| {
        column.iter().for_each(|(i, c)| impulse[*i] = *c);
        let mut change = vec![0.0; n];
        mass.answer_impulse(&impulse, &mut change);
        column.iter().for_each(|(i, _)| impulse[*i] = 0.0);
        change
    };
    columns.map(|columns| [0, 1, 2].map(|i| answer(&columns[i]))).collect()
}

/// `A` of (2), by blocks.
pub(crate) fn blocks(frames: &[Frame], responses: &[[Vec<f64>; 3]]) -> Vec<Vec<(usize, Matrix3<f64>)>> {
    let block = |i: usize, j: usize| Matrix3::from_fn(|r, c| along(&frames[i].columns[r], &responses[j][c]));
    let row = |i: usize| {
        let all = (0..frames.len()).map(|j| (j, block(i, j)));
        all.filter(|(j, block)| *j == i || *block != Matrix3::zeros()).collect()
    };
    (0..frames.len()).map(row).collect()
}

/// The problem of contacts with these rates and laws.
pub(crate) fn problem(
    frames: &[Frame],
    responses: &[[Vec<f64>; 3]],
    rates: Vec<Vector3<f64>>,
    laws: Vec<cone::Law>,
) -> cone::Problem {
    cone::Problem { blocks: blocks(frames, responses), rates, laws }
}

/// How a unit force along a direction at a point, on the second link and against the first, pushes the coordinates.
pub(crate) fn column_of(
    model: &Model,
    motion: &Motion,
    ends: [usize; 2],
    point: &Vector3<f64>,
    along: &Vector3<f64>,
) -> Vec<(usize, f64)> {
    let mut column: Vec<(usize, f64)> = Vec::new();
    for (end, sign) in ends.into_iter().zip([-1.0, 1.0]) {
        let force = along * sign;
        let mut at = end;
        while at != 0 {
            let (link, moving) = (&model.links[at], &motion.links[at]);
            let wrench = Wrench { force, moment: (point - moving.position).cross(&force) };
            project(motion, link, at, &wrench, |velocity, value| {
                match column.iter_mut().find(|(i, _)| *i == velocity) {
                    Some((_, sum)) => *sum += value,
                    None => column.push((velocity, value)),
                }
            });
            at = link.parent;
        }
    }
    column.retain(|(_, value)| *value != 0.0);
    column
}
