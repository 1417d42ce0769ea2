//! Scenes that fall for ever: a motion along which the potential falls at a constant rate, with nothing on the way that stops it.
//!
//! Let some slides move at constant rates `ṡ` while every other coordinate keeps its value. No link turns, so the axes `aᵢ` of the
//! slides stay as they are:
//!
//! ```text
//! v_link = Σ aᵢ ṡᵢ                   over the slides between the ground and the link              (1)
//! A ṡ = 0                            both ends of a force element or a rod move alike, the ends of
//!                                    a loop along the axes that it locks, gears in their ratio      (2)
//! V(s) = V(0) − c·s,                 cᵢ = aᵢ·Fᵢ + τᵢ                                              (3)
//! ```
//!
//! `Fᵢ` is the weight of the subtree that the slide carries, with its dead loads, and `τᵢ` a constant motor force. If the
//! projection `d` of `c` onto the null space of `A` is not zero, `V` has no lower bound: along `d` it falls at the rate `d·c`, and
//! `K d·d = 0` forbids a strict minimum. No search is needed to say so.
//!
//! A turn or screw takes part if nothing is attached to what it carries and nothing slides there. Beside its motor force (and the
//! weight along a screw's pitch) it feels the moment of the weight, which changes within one turn by no more than
//!
//! ```text
//! |S − a a·S| |g − a a·g|,           S = Σ m r from the axis:    d·c > Σ |dᵢ| |Sᵢ⊥| |gᵢ⊥|           (4)
//! ```
//!
//! What is not known to leave the motion alone (springs, stops in its way, drives and locks of these coordinates, loads that follow a
//! link) holds it: the certificate is sufficient, not necessary.

use crate::force::Act;
use crate::hinge::Condition;
use crate::model::couplings::Closure;
use crate::model::problem::rounded;
use crate::model::stop;
use crate::model::{Coordinate, CurveOver, Drive, Model, Motor};
use crate::motion::Motion;
use crate::round_off::{EIGENVECTOR, NORMAL_EIGENVALUE};
use crate::statics::problem::parts::joined;
use crate::statics::problem::place::BALANCED;
use faer::{Mat, Side};
use nalgebra::Vector3;

/// If all eigenvalues are above this part of the largest, a Cholesky factorization says so without computing them.
const CLEARLY_FEELS: f64 = 1e-9;
/// Coordinates of one component beyond which its eigenvectors would take longer than the search.
const MOST: usize = 400;

/// A motion along which the potential falls for ever.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::statics) struct Fall {
    /// Whether the motion exists in every position, with the same force: then no position is an equilibrium.
    pub everywhere: bool,
    note: String,
}

impl Fall {
    /// Names the body, the direction and the force.
    pub(in crate::statics) fn note(&self) -> String {
        let end = if self.everywhere { ": no position is an equilibrium" } else { "" };
        format!("{}{end}", self.note)
    }
}

/// Such a motion from the positions of `motion` on; `None` when none is found.
pub(in crate::statics) fn falling(model: &Model, motion: &Motion) -> Option<Fall> {
    let scene = Scene::of(model, motion);
    if scene.large {
        return None;
    }
    scene.components().into_iter().filter(|columns| columns.len() <= MOST).find_map(|columns| scene.fall(columns))
}

/// A coordinate that may move for ever.
#[derive(Debug, Clone, Copy)]
struct Column {
    link: usize,
    /// `cᵢ`, eq. (3) (N or N m).
    force: f64,
    /// The sum of the magnitudes in it.
    size: f64,
    /// The most by which the moment of the weight changes, eq. (4) (N m); 0 for slides.
    swing: f64,
    /// Whether axis and force are the same in every position.
    fixed: bool,
}

/// Per link what the subtree that begins there carries.
struct Carried {
    /// Weights and dead loads, inertial axes (N).
    weight: Vec<Vector3<f64>>,
    /// The sum of their magnitudes (N).
    load: Vec<f64>,
    /// Whether a force element or a loop ends there.
    attached: Vec<bool>,
}

/// A row of `A`: its columns and their factors, and whether it is the same in every position.
struct Row {
    parts: Vec<(usize, f64)>,
    fixed: bool,
}

struct Scene<'m> {
    model: &'m Model,
    motion: &'m Motion,
    columns: Vec<Column>,
    /// Per link the column of the nearest slide between the ground and it, its own included.
    above: Vec<Option<usize>>,
    /// Per velocity coordinate its column.
    column: Vec<Option<usize>>,
    rows: Vec<Row>,
    /// Whether a row has more columns than a component may have.
    large: bool,
}

impl<'m> Scene<'m> {
    fn of(model: &'m Model, motion: &'m Motion) -> Self {
        let (links, coordinates) = (model.links.len(), model.velocity_count());
        let (columns, rows) = (Vec::new(), Vec::new());
        let mut scene = Self {
            model,
            motion,
            columns,
            above: vec![None; links],
            column: vec![None; coordinates],
            rows,
            large: false,
        };
        scene.take_columns();
        if !scene.columns.is_empty() {
            scene.take_rows();
        }
        scene
    }

    fn take_columns(&mut self) {
        let (model, count) = (self.model, self.model.links.len());
        let pushes = constant_forces(model);
        let mut weight: Vec<Vector3<f64>> = model.links.iter().map(|link| link.mass * model.gravity).collect();
        let mut load: Vec<f64> = weight.iter().map(Vector3::norm).collect();
        let mut attached = vec![false; count];
        for force in model.forces.iter() {
            force.law.ends().iter().for_each(|end| attached[end.link] = true);
            if let Some((link, dead)) = force.law.dead() {
                weight[link] += dead;
                load[link] += dead.norm();
            }
        }
        model.loops.iter().flat_map(|closed| &closed.ends).for_each(|end| attached[end.link] = true);
        for index in (1..count).rev() {
            let parent = model.links[index].parent;
            let (moved, size, holds) = (weight[index], load[index], attached[index]);
            weight[parent] += moved;
            load[parent] += size;
            attached[parent] |= holds;
        }
        let turned = turned(model);
        for (index, link) in model.links.iter().enumerate().skip(1) {
            self.above[index] = self.above[link.parent];
            if link.joint.is_slide()
                && let Some(push) = pushes[link.velocity]
            {
                let axis = self.motion.links[index].axis;
                let (force, size) = (axis.dot(&weight[index]) + push, load[index] + push.abs());
                self.above[index] = Some(self.columns.len());
                self.push(Column { link: index, force, size, swing: 0.0, fixed: !turned[link.parent] });
            }
        }
        self.take_turns(&Carried { weight, load, attached }, &pushes, &turned);
    }

    /// Turns and screws that a motor, a gear or a thread moves; from the tips on: what the outer ones do is known.
    fn take_turns(&mut self, carried: &Carried, pushes: &[Option<f64>], turned: &[bool]) {
        let (model, count) = (self.model, self.model.links.len());
        let mut geared = vec![false; model.velocity_count()];
        model.gears.iter().flat_map(|gear| &gear.coordinates).for_each(|one| geared[one.velocity] = true);
        // Whether what a link carries turns another way than about the axis of its own balance.
        let mut swings = vec![false; count];
        for index in (1..count).rev() {
            let (link, parent) = (&model.links[index], model.links[index].parent);
            let (all, pitch) = (index..link.subtree_end, link.joint.pitch());
            let push = pushes[link.velocity].filter(|_| link.joint.is_angle());
            if let Some(push) = push.filter(|push| *push != 0.0 || pitch != 0.0 || geared[link.velocity])
                && !(carried.attached[index] || swings[index])
                && !all.clone().any(|at| model.links[at].joint.is_slide() && self.has_column(at))
            {
                let axis = self.motion.links[index].axis;
                let (force, size) =
                    (pitch * axis.dot(&carried.weight[index]) + push, pitch.abs() * carried.load[index] + push.abs());
                let (swing, balanced) = self.swing(index);
                let rigid = all.skip(1).all(|at| is_locked(model, at));
                self.push(Column { link: index, force, size, swing, fixed: rigid && !turned[parent] });
                swings[index] = pitch != 0.0 || !balanced;
            }
            swings[parent] |= swings[index];
        }
    }

    fn push(&mut self, column: Column) {
        self.column[self.model.links[column.link].velocity] = Some(self.columns.len());
        self.columns.push(column);
    }

    fn has_column(&self, link: usize) -> bool {
        self.column[self.model.links[link].velocity].is_some()
    }

    /// `|S⊥| |g⊥|` of what a turn carries, eq. (4), and whether `S⊥` is round-off.
    fn swing(&self, index: usize) -> (f64, bool) {
        let (model, links) = (self.model, &self.motion.links);
        let across = |x: Vector3<f64>| x - links[index].axis * links[index].axis.dot(&x);
        let (mut sum, mut size) = (Vector3::zeros(), 0.0);
        for at in index..model.links[index].subtree_end {
            let moment = model.links[at].mass * (links[at].position + links[at].center - links[index].position);
            sum += moment;
            size += moment.norm();
        }
        let off = across(sum).norm();
        (off * across(model.gravity).norm(), off <= BALANCED * size)
    }

    fn take_rows(&mut self) {
        let model = self.model;
        for force in model.forces.iter().filter(|force| force.law.dead().is_none()) {
            let ends = force.law.ends();
            // What pushes on one link alone, and not always the same, counts as joined to the ground.
            let first = if ends.len() == 1 { 0 } else { ends[0].link };
            ends.iter().for_each(|end| self.tie([first, end.link]));
        }
        for closed in &model.loops {
            let links = [closed.ends[0].link, closed.ends[1].link];
            let Closure::Hinge(kind) = closed.closure else {
                self.tie(links);
                continue;
            };
            let conditions = kind.conditions();
            let along = |condition: &Condition| match condition {
                Condition::Along(axis) | Condition::Thread { axis, .. } => Some(*axis),
                Condition::Aligned { .. } => None,
            };
            let axes: Vec<Vector3<f64>> = conditions.iter().filter_map(along).collect();
            if axes.len() >= 3 {
                self.tie(links);
                continue;
            }
            let turn = self.motion.links[links[0]].turn * closed.frame;
            axes.iter().for_each(|axis| self.tie_along(links, turn * axis, false));
        }
        for gear in &model.gears {
            let of = |k: usize, factor: f64| Some((self.column[gear.coordinates[k].velocity]?, factor));
            let size = gear.ratio.abs().max(1.0);
            let parts: Vec<_> = [of(0, 1.0 / size), of(1, -gear.ratio / size)].into_iter().flatten().collect();
            self.rows.push(Row { parts, fixed: true });
        }
    }

    /// Both links move alike.
    fn tie(&mut self, links: [usize; 2]) {
        [Vector3::x(), Vector3::y(), Vector3::z()].into_iter().for_each(|axis| self.tie_along(links, axis, true));
    }

    /// Both links move alike along an axis: the slides between the two and where both ways to the ground meet.
    fn tie_along(&mut self, links: [usize; 2], axis: Vector3<f64>, fixed: bool) {
        let mut parts = Vec::new();
        let [mut one, mut other] = links.map(|link| self.above[link]);
        while one != other {
            // Outer slides have higher columns than inner ones.
            let (end, sign) = if one > other { (&mut one, -1.0) } else { (&mut other, 1.0) };
            let Some(column) = *end else { break };
            let link = self.columns[column].link;
            parts.push((column, sign * self.motion.links[link].axis.dot(&axis)));
            *end = self.above[self.model.links[link].parent];
            if parts.len() > MOST {
                self.large = true;
                return;
            }
        }
        self.rows.push(Row { parts, fixed });
    }

    /// Columns that rows, or slides on slides, join.
    fn components(&self) -> Vec<Vec<usize>> {
        let mut of: Vec<usize> = (0..self.columns.len()).collect();
        let first_of = |of: &[usize], mut column: usize| {
            while of[column] != column {
                column = of[column];
            }
            column
        };
        let mut join = |one: usize, other: usize| {
            let [one, other] = [first_of(&of, one), first_of(&of, other)];
            of[one.max(other)] = one.min(other);
        };
        for row in &self.rows {
            row.parts.windows(2).for_each(|pair| join(pair[0].0, pair[1].0));
        }
        for (index, column) in self.columns.iter().enumerate() {
            if let Some(inner) = self.above[self.model.links[column.link].parent] {
                join(index, inner);
            }
        }
        let mut components = vec![Vec::new(); self.columns.len()];
        (0..self.columns.len()).for_each(|column| components[first_of(&of, column)].push(column));
        components.retain(|columns| !columns.is_empty());
        components
    }

    /// The fall of a component. A coordinate that would come to a stop is held, and it is tried again.
    fn fall(&self, mut columns: Vec<usize>) -> Option<Fall> {
        while !columns.is_empty() {
            let motion = self.downhill(&columns)?;
            let largest = motion.iter().fold(0.0_f64, |m, d| m.max(d.abs()));
            let is_held = |k: usize| motion[k].abs() > EIGENVECTOR.of(largest) && self.stops(columns[k], motion[k]);
            let held: Vec<usize> = (0..columns.len()).filter(|k| is_held(*k)).map(|k| columns[k]).collect();
            if held.is_empty() {
                return self.told(&columns, &motion);
            }
            columns.retain(|column| !held.contains(column));
        }
        None
    }

    /// Whether a stop is in the way of a coordinate.
    fn stops(&self, column: usize, direction: f64) -> bool {
        let velocity = self.model.links[self.columns[column].link].velocity;
        let stops = self.model.stops.iter().filter(|stop| stop.velocity == velocity);
        let side = if direction > 0.0 { stop::Side::High } else { stop::Side::Low };
        stops.into_iter().any(|stop| stop.limit(side).is_finite())
    }

    /// `d = N Nᵀ c` of some columns, the others held; `None` if it vanishes.
    fn downhill(&self, columns: &[usize]) -> Option<Vec<f64>> {
        let n = columns.len();
        let mut place = vec![None; self.columns.len()];
        columns.iter().enumerate().for_each(|(k, column)| place[*column] = Some(k));
        let mut square = Mat::<f64>::zeros(n, n);
        for row in &self.rows {
            let parts: Vec<_> = row.parts.iter().filter_map(|(column, x)| Some((place[*column]?, *x))).collect();
            for (i, x) in &parts {
                parts.iter().for_each(|(j, y)| square[(*i, *j)] += x * y);
            }
        }
        let largest = (0..n).map(|i| square[(i, i)]).fold(0.0, f64::max);
        let shift = |i: usize, j: usize| if i == j { CLEARLY_FEELS * largest } else { 0.0 };
        if Mat::from_fn(n, n, |i, j| square[(i, j)] - shift(i, j)).llt(Side::Lower).is_ok() {
            return None;
        }
        let eigen = square.self_adjoint_eigen(Side::Lower).ok()?;
        let (values, vectors) = (eigen.S().column_vector(), eigen.U());
        let mut motion = vec![0.0; n];
        for k in (0..n).filter(|k| values[*k] <= NORMAL_EIGENVALUE.of(n as f64 * largest)) {
            let part: f64 = (0..n).map(|i| vectors[(i, k)] * self.columns[columns[i]].force).sum();
            motion.iter_mut().enumerate().for_each(|(i, d)| *d += part * vectors[(i, k)]);
        }
        let norm = |of: &dyn Fn(usize) -> f64| (0..n).map(|k| of(k).powi(2)).sum::<f64>().sqrt();
        let size = norm(&|k| self.columns[columns[k]].size);
        (norm(&|k| motion[k]) > BALANCED * size).then_some(motion)
    }

    /// The fall along a motion; `None` if a moment of the weight may stop it, eq. (4).
    fn told(&self, columns: &[usize], motion: &[f64]) -> Option<Fall> {
        let of = |k: usize| &self.columns[columns[k]];
        let all = || 0..columns.len();
        let rate: f64 = all().map(|k| motion[k] * of(k).force).sum();
        let swings: f64 = all().map(|k| motion[k].abs() * of(k).swing).sum();
        if !(rate * (1.0 - BALANCED) > swings) {
            return None;
        }
        let leads = all().max_by(|a, b| (motion[*a] * of(*a).force).total_cmp(&(motion[*b] * of(*b).force)))?;
        let link = of(leads).link;
        let body = &self.model.bodies[self.model.links[link].body].name;
        let (turning, strong) = match &self.motors(columns, motion).join("`, `")[..] {
            "" => ("turns", String::new()),
            motors => ("winds up", format!(": `{motors}` is stronger than the load")),
        };
        let note = if self.model.links[link].joint.is_angle() {
            let moment = rounded(rate / motion[leads].abs());
            format!("{turning} for ever: nothing balances {moment} N m in `{body}`, the same all the way{strong}")
        } else {
            let speed = self.velocity(link, columns, motion);
            let (force, along) = (rounded(rate / speed.norm()), speed.normalize());
            let along = format!("along [{:.3}, {:.3}, {:.3}]", along.x, along.y, along.z);
            match speed.dot(&self.model.gravity) > 0.0 {
                true => {
                    format!("falls for ever: nothing holds `{body}` against gravity {along} ({force} N all the way)")
                }
                false => format!("is pushed for ever: nothing holds `{body}` against {force} N {along}{strong}"),
            }
        };
        let fixed = |row: &Row| row.fixed || !row.parts.iter().any(|(column, _)| columns.contains(column));
        let everywhere = all().all(|k| of(k).fixed) && self.rows.iter().all(fixed);
        Some(Fall { everywhere, note })
    }

    /// The motors that push along a motion.
    fn motors(&self, columns: &[usize], motion: &[f64]) -> Vec<&'m str> {
        let velocity = |k: usize| self.model.links[self.columns[columns[k]].link].velocity;
        let pushes = |motor: &&Motor| {
            let at = (0..columns.len()).find(|k| velocity(*k) == motor.coordinate.velocity);
            at.zip(motor.constant()).is_some_and(|(k, force)| force * motion[k] > 0.0)
        };
        self.model.motors.iter().filter(pushes).map(|motor| motor.name.as_str()).collect()
    }

    /// How fast a motion moves a link, eq. (1).
    fn velocity(&self, link: usize, columns: &[usize], motion: &[f64]) -> Vector3<f64> {
        let (mut velocity, mut next) = (Vector3::zeros(), self.above[link]);
        while let Some(column) = next {
            let slide = self.columns[column].link;
            if let Some(k) = columns.iter().position(|other| *other == column) {
                velocity += motion[k] * self.motion.links[slide].axis;
            }
            next = self.above[self.model.links[slide].parent];
        }
        velocity
    }
}

/// Per velocity coordinate the constant force that a motor applies at rest (N or N m); `None` for a coordinate that something
/// holds, pushes according to its place, or moves.
fn constant_forces(model: &Model) -> Vec<Option<f64>> {
    let is_free = |c: &Coordinate| !c.lock && c.stiffness == 0.0;
    let mut forces: Vec<Option<f64>> = model.coordinates.iter().map(|c| is_free(c).then_some(c.force)).collect();
    let mut add = |velocity: usize, force: Option<f64>| {
        let sum = forces[velocity].zip(force).map(|(sum, force)| sum + force);
        forces[velocity] = sum;
    };
    model.motors.iter().for_each(|motor| add(motor.coordinate.velocity, motor.constant()));
    for curve in model.curves.iter() {
        add(curve.coordinate.velocity, (curve.over == CurveOver::Velocity).then_some(-curve.at_rest));
    }
    model.drives.iter().for_each(|drive| add(drive.coordinate.velocity, None));
    // What a drive keeps turning has a potential of its centrifugal forces, and so has what loops and gears turn with it.
    let is_moving = |drive: &&Drive| drive.motion.at(0.0).velocity != 0.0;
    let moved = || model.drives.iter().filter(is_moving).map(|drive| drive.coordinate.link);
    let mut carried = vec![false; model.links.len()];
    moved().for_each(|link| carried[link] = true);
    if moved().next().is_some() && !(model.loops.is_empty() && model.gears.is_empty()) {
        let of = parts(model);
        let moving: Vec<usize> = moved().map(|link| of[link]).collect();
        carried.iter_mut().zip(&of).for_each(|(carried, of)| *carried |= moving.contains(of));
    }
    for (index, link) in model.links.iter().enumerate().skip(1) {
        carried[index] |= carried[link.parent];
        if carried[index] && link.joint.is_scalar() {
            add(link.velocity, None);
        }
    }
    for stop in model.stops.iter().filter(|stop| stop.range.iter().all(|end| end.is_finite())) {
        add(stop.velocity, None);
    }
    forces
}

/// Per link the first of those that it moves with, by hinges, loops and gears; the ground carries no motion.
fn parts(model: &Model) -> Vec<usize> {
    let hinges = model.links.iter().enumerate().skip(1).map(|(index, link)| [index, link.parent]);
    let loops = model.loops.iter().map(|closed| [closed.ends[0].link, closed.ends[1].link]);
    let gears = model.gears.iter().map(|gear| gear.coordinates.map(|one| one.link));
    joined(model.links.len(), hinges.chain(loops).chain(gears).filter(|pair| !pair.contains(&0)))
}

/// Whether statics holds the hinge of a link.
fn is_locked(model: &Model, link: usize) -> bool {
    let (first, count) = (model.links[link].velocity, model.links[link].joint.counts().1);
    model.coordinates[first..first + count].iter().all(|coordinate| coordinate.lock)
}

/// Per link whether something between the ground and it may turn it, its own hinge included.
fn turned(model: &Model) -> Vec<bool> {
    let mut turned = vec![false; model.links.len()];
    for (index, link) in model.links.iter().enumerate().skip(1) {
        turned[index] = turned[link.parent] || (link.joint.turns() && !is_locked(model, index));
    }
    turned
}
