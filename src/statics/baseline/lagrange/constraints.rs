//! Hinges as constraints between the poses of two links, with their gradients and second derivatives.
//!
//! ```text
//! s, o   hinge point on the parent P;   D = r − r_P;   u, a carried by P, b carried by the link; inertial axes
//! coincide  g = D − s          unit multiplier: force e on the link, −e and moment e × s on P     (three rows)
//! across    g = u·(D − o)      u on the link, −u and u × D on P
//! square    g = a·b            moments b × a on the link, a × b on P
//! ```
//!
//! | hinge | constraints |
//! |---|---|
//! | turn about n | coincide; square for n against the two axes across it |
//! | slide along n | across for the two axes; square for three pairs of axes |
//! | screw about n | across and square for the two axes across it; thread |
//! | ball | coincide |
//!
//! A locked hinge is one without freedom: coincide, and square for three pairs.
//!
//! The independent rows of loops are constraints between two links that are not neighbours; `A`, `B` are the arms from the
//! root markers of P and of the link to the ends of the loop:
//!
//! ```text
//! plane     g = u·(D + B − A)        u on the link at B; −u on P at D + B
//! distance  g = |D + B − A| − l      along that line, at B and at A
//! square    g = a·b − cosine
//! thread    g = u·(D + B − A) − p φ    as plane, and the moment −p m on the link, p m on P; φ, m: see `spatial::twist`
//! ```

use super::entries::Entries;
use super::gradient::{Gradient, Part};
use crate::constraint::{IndependentRow, Rule};
use crate::model::{Joint, Link, Model};
use crate::motion::{LinkMotion, Motion, hinge_from_link};
use crate::spatial::twist::Twist;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// One constraint: three rows for `Coincide`, else one.
#[derive(Debug, Clone, Copy)]
pub(super) struct Constraint {
    pub(super) link: usize,
    pub(super) parent: usize,
    /// First row, from the first constraint on.
    pub(super) row: usize,
    kind: Kind,
}

#[derive(Debug, Clone, Copy)]
enum Kind {
    /// The point of the parent that the root marker sits on, parent axes.
    Coincide { point: Vector3<f64> },
    /// Axis and hinge point, parent axes.
    Across { axis: Vector3<f64>, point: Vector3<f64> },
    /// One axis of the parent and one of the link, each in its own axes, and the cosine between them.
    Square { on_parent: Vector3<f64>, on_link: Vector3<f64>, cosine: f64 },
    /// A point of the link in a plane of the parent: its normal and a point of it, parent axes.
    Plane { axis: Vector3<f64>, point: Vector3<f64>, on_link: Vector3<f64> },
    /// A plane at the angle of a thread: axis and an axis across it on the parent and on the link, each in its own axes.
    Thread {
        on_parent: [Vector3<f64>; 2],
        on_link: [Vector3<f64>; 2],
        pitch: f64,
        point: Vector3<f64>,
        end: Vector3<f64>,
    },
    /// A point of the parent and one of the link.
    Distance { length: f64, point: Vector3<f64>, on_link: Vector3<f64> },
}

/// All constraints of a tree with locked hinges held at `q`, and the number of their rows.
pub(super) fn of_model(model: &Model, q: &[f64]) -> (Vec<Constraint>, usize) {
    let (mut list, mut row) = (Vec::new(), 0);
    for (index, link) in model.links.iter().enumerate().skip(1) {
        for kind in of_link(model, link, q) {
            list.push(Constraint { link: index, parent: link.parent, row, kind });
            row += if matches!(kind, Kind::Coincide { .. }) { 3 } else { 1 };
        }
    }
    (list, row)
}

fn of_link(model: &Model, link: &Link, q: &[f64]) -> Vec<Kind> {
    let point = link.offset;
    let (_, count) = link.joint.counts();
    let locked = model.coordinates[link.velocity..link.velocity + count].iter().any(|c| c.lock);
    match link.joint {
        // Scenes with flexible elements are refused before.
        Joint::None | Joint::Flex { .. } | Joint::Along { .. } | Joint::Modal { .. } | Joint::Interface { .. } => {
            welded(point, link.turn)
        }
        Joint::Turn | Joint::Screw { .. } if locked => {
            let (z, angle) = (Vector3::z_axis(), q[link.position]);
            let slid = link.joint.pitch() * angle * (link.turn * z.into_inner());
            welded(point + slid, link.turn * Rotation3::from_axis_angle(&z, angle).matrix())
        }
        Joint::Slide { axis } if locked => welded(point + q[link.position] * (link.turn * axis), link.turn),
        Joint::Ball { .. } if locked => {
            welded(point, link.turn * hinge_from_link(&q[link.position..link.position + 4]))
        }
        Joint::Turn => std::iter::once(Kind::Coincide { point }).chain(upright(link.turn)).collect(),
        Joint::Screw { pitch } => {
            let [z, x] = [Vector3::z(), Vector3::x()];
            let along = across(&z).map(|axis| Kind::Across { axis: link.turn * axis, point });
            let on_parent = [link.turn * z, link.turn * x];
            let thread = Kind::Thread { on_parent, on_link: [z, x], pitch, point, end: Vector3::zeros() };
            along.into_iter().chain(upright(link.turn)).chain([thread]).collect()
        }
        Joint::Slide { axis } => {
            let of = |axis: Vector3<f64>| Kind::Across { axis: link.turn * axis, point };
            across(&axis).into_iter().map(of).chain(parallel(link.turn)).collect()
        }
        Joint::Ball { .. } => vec![Kind::Coincide { point }],
    }
}

fn welded(point: Vector3<f64>, turn: Matrix3<f64>) -> Vec<Kind> {
    std::iter::once(Kind::Coincide { point }).chain(parallel(turn)).collect()
}

/// The link's z axis stands as `turn` says on the parent.
fn upright(turn: Matrix3<f64>) -> [Kind; 2] {
    across(&Vector3::z()).map(|axis| Kind::Square { on_parent: turn * axis, on_link: Vector3::z(), cosine: 0.0 })
}

/// The link's axes stand as `turn` on the parent.
fn parallel(turn: Matrix3<f64>) -> impl Iterator<Item = Kind> {
    [(1, 2), (2, 0), (0, 1)].into_iter().map(move |(i, j)| Kind::Square {
        on_parent: turn.column(i).into_owned(),
        on_link: Vector3::ith(j, 1.0),
        cosine: 0.0,
    })
}

/// The independent rows of loops, from row `first` on.
pub(super) fn of_loops(rows: &[IndependentRow], first: usize) -> Vec<Constraint> {
    let of = |(index, row): (usize, &IndependentRow)| {
        let [a, b] = row.ends?;
        let (point, on_link) = (a.point, b.point);
        let kind = match row.rule {
            Rule::Along { axis } => Kind::Plane { axis, point, on_link },
            Rule::Aligned { first, second, cosine } => Kind::Square { on_parent: first, on_link: second, cosine },
            Rule::Distance { length } => Kind::Distance { length, point, on_link },
            Rule::Thread { first: on_parent, second, pitch } => {
                Kind::Thread { on_parent, on_link: second, pitch, point, end: on_link }
            }
            Rule::Motion { .. } => return None,
        };
        Some(Constraint { link: b.link, parent: a.link, row: first + index, kind })
    };
    rows.iter().enumerate().filter_map(of).collect()
}

/// Two unit axes across one.
fn across(axis: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let first = axis.cross(&Vector3::ith(axis.iamin(), 1.0)).normalize();
    [first, axis.cross(&first)]
}

impl Constraint {
    /// Number of rows.
    pub(super) fn count(&self) -> usize {
        if matches!(self.kind, Kind::Coincide { .. }) { 3 } else { 1 }
    }

    /// Whether the gap is a length, else the cosine of an angle.
    pub(super) fn is_length(&self) -> bool {
        !matches!(self.kind, Kind::Square { .. })
    }

    /// The gaps, `count` of them (m, rad), and their gradients.
    pub(super) fn at(&self, motion: &Motion) -> [(f64, Gradient); 3] {
        let (link, parent) = (&motion.links[self.link], &motion.links[self.parent]);
        let zero = Vector3::zeros();
        let between = link.position - parent.position;
        match self.kind {
            Kind::Coincide { point } => {
                let arm = parent.turn * point;
                [0, 1, 2].map(|i| {
                    let unit = Vector3::ith(i, 1.0);
                    let gradient = Gradient { force: unit, on_link: zero, on_parent: unit.cross(&arm) };
                    (between[i] - arm[i], gradient)
                })
            }
            Kind::Across { axis, point } => {
                let u = parent.turn * axis;
                let gradient = Gradient { force: u, on_link: zero, on_parent: u.cross(&between) };
                [(u.dot(&between) - axis.dot(&point), gradient); 3]
            }
            Kind::Square { on_parent, on_link, cosine } => {
                let (a, b) = (parent.turn * on_parent, link.turn * on_link);
                let moment = a.cross(&b);
                [(a.dot(&b) - cosine, Gradient { force: zero, on_link: -moment, on_parent: moment }); 3]
            }
            Kind::Plane { axis, point, on_link } => [plane((link, parent), axis, point, on_link); 3],
            Kind::Thread { on_parent, on_link, pitch, point, end } => {
                let (distance, mut gradient) = plane((link, parent), on_parent[0], point, end);
                let twist = twist((link, parent), on_parent, on_link);
                gradient.on_link -= pitch * twist.gradient;
                gradient.on_parent += pitch * twist.gradient;
                [(twist.off_thread(distance, pitch), gradient); 3]
            }
            Kind::Distance { length, point, on_link } => {
                let (arm, far) = (parent.turn * point, link.turn * on_link);
                let line = between + far - arm;
                let e = line / line.norm();
                let gradient = Gradient { force: e, on_link: far.cross(&e), on_parent: e.cross(&arm) };
                [(line.norm() - length, gradient); 3]
            }
        }
    }

    /// The geometric stiffness: how the forces of fixed multipliers vary with the poses.
    pub(super) fn vary(&self, motion: &Motion, multipliers: &[f64], entries: &mut Entries) {
        let (link, parent) = (&motion.links[self.link], &motion.links[self.parent]);
        let (i, p) = (self.link, self.parent);
        match self.kind {
            Kind::Coincide { point } => {
                let arm = (parent.turn * point).cross_matrix();
                let force = Vector3::from_column_slice(&multipliers[self.row..self.row + 3]);
                entries.add((p, Part::Turn), (p, Part::Turn), &(-force.cross_matrix() * arm));
            }
            Kind::Across { axis, .. } => {
                axial(motion, (i, p), parent.turn * axis, multipliers[self.row], entries);
            }
            Kind::Plane { axis, on_link, .. } => {
                vary_plane(motion, (i, p), (axis, on_link), multipliers[self.row], entries);
            }
            Kind::Thread { on_parent, on_link, pitch, end, .. } => {
                vary_plane(motion, (i, p), (on_parent[0], end), multipliers[self.row], entries);
                let (twist, size) = (twist((link, parent), on_parent, on_link), -pitch * multipliers[self.row]);
                let (none, units) = (Vector3::zeros(), [0, 1, 2].map(|axis| Vector3::ith(axis, size)));
                let by_parent = Matrix3::from_columns(&units.map(|unit| twist.vary(&unit, &none)));
                let by_link = Matrix3::from_columns(&units.map(|unit| twist.vary(&none, &unit)));
                entries.add((i, Part::Turn), (p, Part::Turn), &by_parent);
                entries.add((i, Part::Turn), (i, Part::Turn), &by_link);
                entries.add((p, Part::Turn), (p, Part::Turn), &-by_parent);
                entries.add((p, Part::Turn), (i, Part::Turn), &-by_link);
            }
            Kind::Distance { point, on_link, .. } => {
                let (arm, far) = (parent.turn * point, link.turn * on_link);
                let line = link.position - parent.position + far - arm;
                let (length, size) = (line.norm(), multipliers[self.row]);
                let e = line / length;
                let across = size / length * (Matrix3::identity() - e * e.transpose());
                let force = (size * e).cross_matrix();
                let (arm, far) = (arm.cross_matrix(), far.cross_matrix());
                let ends = [
                    ((i, Part::Place), Matrix3::identity()),
                    ((i, Part::Turn), -far),
                    ((p, Part::Place), -Matrix3::identity()),
                    ((p, Part::Turn), arm),
                ];
                for (by, line) in ends {
                    let change = across * line;
                    entries.add((i, Part::Place), by, &change);
                    entries.add((p, Part::Place), by, &-change);
                    entries.add((i, Part::Turn), by, &(far * change));
                    entries.add((p, Part::Turn), by, &(-arm * change));
                }
                entries.add((i, Part::Turn), (i, Part::Turn), &(force * far));
                entries.add((p, Part::Turn), (p, Part::Turn), &(-force * arm));
            }
            Kind::Square { on_parent, on_link, .. } => {
                let (a, b) = ((parent.turn * on_parent).cross_matrix(), (link.turn * on_link).cross_matrix());
                let size = multipliers[self.row];
                let (by_parent, by_link) = (size * (b * a), size * (a * b));
                entries.add((p, Part::Turn), (p, Part::Turn), &by_parent);
                entries.add((p, Part::Turn), (i, Part::Turn), &-by_link);
                entries.add((i, Part::Turn), (p, Part::Turn), &-by_parent);
                entries.add((i, Part::Turn), (i, Part::Turn), &by_link);
            }
        }
    }
}

/// The distance of a point of the link along an axis of the parent from one of the parent, and its gradient.
fn plane(
    (link, parent): (&LinkMotion, &LinkMotion),
    axis: Vector3<f64>,
    point: Vector3<f64>,
    on_link: Vector3<f64>,
) -> (f64, Gradient) {
    let (u, arm) = (parent.turn * axis, link.turn * on_link);
    let reach = link.position - parent.position + arm;
    let gradient = Gradient { force: u, on_link: arm.cross(&u), on_parent: u.cross(&reach) };
    (u.dot(&(reach - parent.turn * point)), gradient)
}

/// How a force of fixed size on a point of the link, along an axis carried by the parent, varies with the poses.
fn vary_plane(
    motion: &Motion,
    (i, p): (usize, usize),
    (axis, on_link): (Vector3<f64>, Vector3<f64>),
    size: f64,
    entries: &mut Entries,
) {
    let (link, parent) = (&motion.links[i], &motion.links[p]);
    let arm = link.turn * on_link;
    let reach = (link.position - parent.position + arm).cross_matrix();
    let arm = arm.cross_matrix();
    let force = size * (parent.turn * axis).cross_matrix();
    entries.add((i, Part::Place), (p, Part::Turn), &-force);
    entries.add((p, Part::Place), (p, Part::Turn), &force);
    entries.add((i, Part::Turn), (i, Part::Turn), &(force * arm));
    entries.add((i, Part::Turn), (p, Part::Turn), &(-arm * force));
    entries.add((p, Part::Turn), (p, Part::Turn), &(reach * force));
    entries.add((p, Part::Turn), (i, Part::Turn), &(-force * arm));
    entries.add((p, Part::Turn), (i, Part::Place), &force);
    entries.add((p, Part::Turn), (p, Part::Place), &-force);
}

/// The angle of a thread.
fn twist(
    (link, parent): (&LinkMotion, &LinkMotion),
    on_parent: [Vector3<f64>; 2],
    on_link: [Vector3<f64>; 2],
) -> Twist {
    let across = |turn: &Matrix3<f64>, [n, t]: [Vector3<f64>; 2]| [turn * t, turn * n.cross(&t)];
    Twist::between(across(&parent.turn, on_parent), across(&link.turn, on_link))
}

/// How a force of fixed size along an axis carried by the parent varies with the poses.
pub(super) fn axial(motion: &Motion, ends: (usize, usize), u: Vector3<f64>, size: f64, entries: &mut Entries) {
    let (i, p) = ends;
    let between = motion.links[i].position - motion.links[p].position;
    let force = size * u.cross_matrix();
    entries.add((i, Part::Place), (p, Part::Turn), &-force);
    entries.add((p, Part::Place), (p, Part::Turn), &force);
    entries.add((p, Part::Turn), (p, Part::Turn), &(between.cross_matrix() * force));
    entries.add((p, Part::Turn), (i, Part::Place), &force);
    entries.add((p, Part::Turn), (p, Part::Place), &-force);
}
