//! The symmetric tangent of a scene at rest with the small motions of its links beside its coordinates: sparse however deep the
//! tree is and however far its elements reach.
//!
//! ```text
//! X = (δθ, δr) of a link at its root marker,  z = (δq, X),  wrenches (moment, force)
//! (1) hinge        C z = X_i − T_i X_p − H_i δq_i = 0
//! (2) work         zᵀ W z = Σ X_kᵀ S_k X_k + Σ X_aᵀ B_ab X_b + Σ X_jᵀ N_j δq_j + δqᵀ κ δq
//! (3) tangent      K = Jᵀ W J,    z = J δq by (1), from the root to the tips;   Jᵀ back
//! (4)              P = W + Cᵀ R C + gᵀ ρ g,   R and ρ larger than what the hinges and rows g pass on by `STIFFER`  (penalties)
//! ```
//!
//! `N = [n × m; n × f]` (slide: `[n × f; 0]`) is what a hinge passes on and turns with its link, `S` and `B` are those of the
//! parent module, in their symmetric parts. With the links' motions eliminated, `P` is `K` with hinges and rows that give a little:
//! softer in every direction, so where it is definite, `K` is along the rows. Solutions are refined with (3) itself.

use super::At;
use super::applied::Applied;
use super::matrix::Pair;
use super::parts::{Carried, PLACES};
use crate::model::Model;
use crate::spatial::Wrench;
use crate::spatial::quad::Quad;
use crate::transfer::plan::{Kind, plan};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

/// How much stiffer than what they hold hinges and rows are in (4) at most, and at least. In between it is what there are digits for: a chain
/// of `N` links as stiff as its hinges bends `N⁴` times as much as one of them.
const STIFFER: [f64; 2] = [1e3, 1e6];
/// A lever below this part of the scene's length is none.
const LEVER: f64 = 1e-6;

/// What a row of a loop, a drive or a gear pulls at with a unit multiplier.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Pull {
    /// Links and the wrenches at their root markers.
    pub links: Vec<(usize, Wrench)>,
    /// Velocity coordinates and factors.
    pub coordinates: Vec<(usize, f64)>,
}

impl Pull {
    /// That of a multiplier which counts for so many.
    pub fn scale(&mut self, factor: f64) {
        self.coordinates.iter_mut().for_each(|(_, by)| *by *= factor);
        for (_, wrench) in &mut self.links {
            *wrench = Wrench { force: factor * wrench.force, moment: factor * wrench.moment };
        }
    }
}

/// One link at the point of the tangent.
#[derive(Debug, Clone, Copy)]
struct Local {
    parent: usize,
    first: usize,
    count: usize,
    arm: Vector3<f64>,
    S: Matrix6<f64>,
    H: [Vector6<f64>; 3],
    N: [Vector6<f64>; 3],
    /// Springs of a ball beside `κ`.
    spring: Matrix3<f64>,
    lever: f64,
    /// Stiffness against turns and shifts that its hinge has to pass on.
    stiff: [f64; 2],
}

/// The matrix (4), and what (3) takes.
#[derive(Debug, Clone)]
pub struct Twists {
    links: Vec<Local>,
    /// Of every coordinate its link.
    link_of: Vec<usize>,
    pairs: Vec<Pair>,
    far: Vec<Matrix6<f64>>,
    pulls: Vec<Pull>,
    /// `ρ`.
    rho: Vec<f64>,
    /// `κ` with the shift; zero for what is held.
    kappa: Vec<f64>,
    held: Vec<bool>,
    starts: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
    /// Places of the entries in the order in which they are written.
    slots: Vec<u32>,
    x: Vec<Vector6<f64>>,
    y: Vec<Vector6<f64>>,
    /// Between the bounds of `STIFFER`.
    stiffer: f64,
}

impl Twists {
    /// Room for a model with these pairs and rows.
    pub fn new(model: &Model, pairs: &[Pair], pulls: &[Pull]) -> Self {
        let n = model.velocity_count();
        let none = Vector6::zeros();
        let mut depths = vec![0_usize; model.links.len()];
        for (index, link) in model.links.iter().enumerate().skip(1) {
            depths[index] = depths[link.parent] + 1;
        }
        let deepest = depths.iter().copied().max().unwrap_or(1).max(1) as f64;
        let local = |link: &crate::model::Link| Local {
            parent: link.parent,
            first: link.velocity,
            count: link.joint.counts().1,
            arm: Vector3::zeros(),
            S: Matrix6::zeros(),
            H: [none; 3],
            N: [none; 3],
            spring: Matrix3::zeros(),
            lever: 0.0,
            stiff: [0.0; 2],
        };
        let mut link_of = vec![0; n];
        for (index, link) in model.links.iter().enumerate() {
            link_of[link.velocity..link.velocity + link.joint.counts().1].fill(index);
        }
        let mut new = Self {
            link_of,
            links: model.links.iter().map(local).collect(),
            pairs: pairs.to_vec(),
            far: vec![Matrix6::zeros(); pairs.len()],
            pulls: pulls.to_vec(),
            rho: vec![0.0; pulls.len()],
            kappa: vec![0.0; n],
            held: vec![false; n],
            starts: Vec::new(),
            rows: Vec::new(),
            values: Vec::new(),
            slots: Vec::new(),
            x: vec![none; model.links.len()],
            y: vec![none; model.links.len()],
            stiffer: (1.0 / (f64::EPSILON * deepest.powi(4))).clamp(STIFFER[0], STIFFER[1]),
        };
        new.find_pattern();
        new
    }

    /// Where each column of the upper triangle begins, and its rows, ascending.
    pub fn pattern(&self) -> (&[usize], &[usize]) {
        (&self.starts, &self.rows)
    }

    /// Entries in the order of the pattern.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Other rows; false if the pattern is another now.
    pub fn set_pulls(&mut self, pulls: &[Pull]) -> bool {
        let same = self.pulls.len() == pulls.len()
            && self.pulls.iter().zip(pulls).all(|(a, b)| {
                a.links.iter().map(|l| l.0).eq(b.links.iter().map(|l| l.0))
                    && a.coordinates.iter().map(|c| c.0).eq(b.coordinates.iter().map(|c| c.0))
            });
        self.pulls = pulls.to_vec();
        if !same {
            self.rho = vec![0.0; pulls.len()];
            self.find_pattern();
        }
        same
    }

    /// Calls `put` for the unknowns of every entry, twice the same way.
    fn each(&self, mut put: impl FnMut(usize, usize)) {
        let n = self.kappa.len();
        let of_link = |link: usize, i: usize| n + 6 * (link - 1) + i;
        let mut unknowns = Vec::new();
        let mut all = |unknowns: &[usize]| {
            for (j, column) in unknowns.iter().enumerate() {
                unknowns[..=j].iter().for_each(|row| put(*row.min(column), *row.max(column)));
            }
        };
        for (index, link) in self.links.iter().enumerate().skip(1) {
            unknowns.clear();
            unknowns.extend(link.first..link.first + link.count);
            unknowns.extend((0..6).map(|i| of_link(index, i)));
            if link.parent != 0 {
                unknowns.extend((0..6).map(|i| of_link(link.parent, i)));
            }
            all(&unknowns);
        }
        for pull in &self.pulls {
            unknowns.clear();
            unknowns.extend(pull.coordinates.iter().map(|c| c.0));
            unknowns.extend(pull.links.iter().flat_map(|(link, _)| (0..6).map(|i| of_link(*link, i))));
            all(&unknowns);
        }
        for pair in &self.pairs {
            for (i, j) in (0..6).flat_map(|i| (0..6).map(move |j| (i, j))) {
                let (a, b) = (of_link(pair.feels, i), of_link(pair.moves, j));
                put(a.min(b), a.max(b));
            }
        }
    }

    fn find_pattern(&mut self) {
        let whole = self.kappa.len() + 6 * (self.links.len() - 1);
        let mut columns = vec![Vec::new(); whole];
        self.each(|row, column| columns[column].push(row as u32));
        self.starts = vec![0];
        self.rows.clear();
        for column in &mut columns {
            column.sort_unstable();
            column.dedup();
            self.rows.extend(column.iter().map(|row| *row as usize));
            self.starts.push(self.rows.len());
        }
        let mut slots = Vec::new();
        self.each(|row, column| {
            let place = columns[column].binary_search(&(row as u32)).unwrap_or(0);
            slots.push((self.starts[column] + place) as u32);
        });
        self.slots = slots;
        self.values = vec![0.0; self.rows.len()];
    }

    /// Takes what follows from the place: still, without accelerations.
    pub fn assemble(&mut self, model: &Model, at: &At<'_>, felt: &[Applied]) {
        let (pages, ..) = plan(model);
        let mut springs = at.ball_springs.iter().rev().peekable();
        let mut forces = at.applied.iter().rev().peekable();
        for index in (1..self.links.len()).rev() {
            let (place, own) = (pages[index], &at.motion.links[index]);
            let mut S = Carried::default();
            if !place.is_massless {
                let b = Quad::of(&at.balance.accelerations[index].linear) - Quad::of(&model.gravity);
                S.add_body::<PLACES>(&model.links[index], own, b);
            }
            if forces.peek().is_some_and(|(link, _)| *link == index) {
                while let Some((_, blocks)) = forces.next_if(|(link, _)| *link == index) {
                    S.take_applied::<PLACES>(blocks);
                }
                S.take_turned(&at.wrenches[index]);
            }
            let mut whole = blocks(&S);
            if at.c2 != 0.0 && !place.is_massless {
                let mut of_mass = Carried::default();
                of_mass.add_body::<{ super::MOVING }>(&model.links[index], own, Quad::default());
                (of_mass.turn, of_mass.place) = (of_mass.angular, of_mass.linear);
                whole += at.c2 * blocks(&of_mass);
            }
            let link = &mut self.links[index];
            link.S = 0.5 * (whole + whole.transpose());
            link.arm = own.arm;
            link.lever = own.arm.norm().max(own.center.norm());
            let spring = springs.next_if(|(link, _)| *link == index).map(|(_, spring)| *spring);
            link.spring = spring.map_or_else(Matrix3::zeros, |k| 0.5 * (k + k.transpose()));
            let Wrench { force: f, moment: m } = at.balance.reactions[index];
            let six = |turn: Vector3<f64>, shift: Vector3<f64>| {
                Vector6::new(turn.x, turn.y, turn.z, shift.x, shift.y, shift.z)
            };
            for k in 0..link.count {
                let n = if place.kind == Kind::Ball { own.turn.column(k).into_owned() } else { own.axis };
                let p = if place.kind == Kind::Screw { model.links[index].joint.pitch() } else { 0.0 };
                (link.H[k], link.N[k]) = match place.kind {
                    Kind::Slide => (six(Vector3::zeros(), n), six(n.cross(&f), Vector3::zeros())),
                    _ => (six(n, p * n), six(n.cross(&m) + p * n.cross(&f), n.cross(&f))),
                };
            }
        }
        for index in 1..self.links.len() {
            let (parent, arm) = (self.links[index].parent, self.links[index].arm.norm());
            self.links[parent].lever = self.links[parent].lever.max(arm);
        }
        let length = model.length_scale();
        self.links.iter_mut().filter(|link| link.lever <= LEVER * length).for_each(|link| link.lever = length);
        for (far, felt) in self.far.iter_mut().zip(felt) {
            let mut B = Carried::default();
            B.take_applied::<PLACES>(felt);
            *far = 0.5 * blocks(&B);
        }
    }

    /// Writes (4) with this diagonal; infinite for a coordinate that is held. With `more` every coordinate has that part of what its
    /// hinge passes on beside it.
    pub fn write(&mut self, diagonal: impl Fn(usize) -> f64, more: f64) {
        for j in 0..self.kappa.len() {
            let kappa = diagonal(j);
            self.held[j] = kappa.is_infinite();
            self.kappa[j] = if self.held[j] { 0.0 } else { kappa };
        }
        self.find_stiff();
        self.values.fill(0.0);
        let mut slots = self.slots.iter();
        let values = &mut self.values;
        let mut add = |value: f64| {
            if let Some(slot) = slots.next() {
                values[*slot as usize] += value;
            }
        };
        for link in self.links.iter().skip(1) {
            let (nv, [turn, shift]) = (link.count, link.stiff);
            let R = Vector6::new(turn, turn, turn, shift, shift, shift);
            let mut C = [Vector6::zeros(); 15];
            let mut local = [[0.0; 15]; 15];
            for k in 0..nv {
                let is_held = self.held[link.first + k];
                C[k] = if is_held { Vector6::zeros() } else { -link.H[k] };
                for i in 0..nv {
                    let both = !is_held && !self.held[link.first + i];
                    local[i][k] = if both { link.spring[(i, k)] } else { 0.0 };
                }
                let passed = if link.H[k].fixed_rows::<3>(0).norm() > 0.5 { turn } else { shift };
                local[k][k] += if is_held { 1.0 } else { self.kappa[link.first + k] + more * passed };
                for i in 0..6 {
                    local[k][nv + i] = if is_held { 0.0 } else { 0.5 * link.N[k][i] };
                }
            }
            for i in 0..6 {
                C[nv + i][i] = 1.0;
                (0..=i).for_each(|k| local[nv + k][nv + i] = link.S[(k, i)]);
                if link.parent != 0 {
                    let mut unit = Vector6::zeros();
                    unit[i] = -1.0;
                    C[nv + 6 + i] = carried(&unit, &link.arm);
                }
            }
            for j in 0..nv + if link.parent == 0 { 6 } else { 12 } {
                let weighted = R.component_mul(&C[j]);
                (0..=j).for_each(|i| add(local[i][j] + C[i].dot(&weighted)));
            }
        }
        for (pull, rho) in self.pulls.iter().zip(&self.rho) {
            let coordinates = pull.coordinates.iter().map(|(j, factor)| if self.held[*j] { 0.0 } else { *factor });
            let links = pull.links.iter().flat_map(|(_, wrench)| of_wrench(wrench).iter().copied().collect::<Vec<_>>());
            let row: Vec<f64> = coordinates.chain(links).collect();
            for j in 0..row.len() {
                (0..=j).for_each(|i| add(rho * row[i] * row[j]));
            }
        }
        for far in &self.far {
            (0..6).for_each(|i| (0..6).for_each(|j| add(far[(i, j)])));
        }
    }

    /// What hinges and rows have to pass on, times what they are stiffer by. Loops bring it to hinges that do not carry it along the tree.
    fn find_stiff(&mut self) {
        for link in &mut self.links {
            let largest = |from: usize| (from..from + 3).map(|i| link.S[(i, i)].abs()).fold(0.0, f64::max);
            link.stiff = [largest(0), largest(3)];
        }
        for (pair, far) in self.pairs.iter().zip(&self.far) {
            let largest = (3..6).map(|i| far.row(i).abs().max()).fold(0.0, f64::max);
            let shift = &mut self.links[pair.feels].stiff[1];
            *shift = shift.max(largest);
        }
        for index in (1..self.links.len()).rev() {
            let link = &self.links[index];
            let (mut turn, mut shift) = (link.stiff[0], link.stiff[1]);
            for k in 0..link.count {
                let kappa = (self.kappa[link.first + k] + link.spring[(k, k)]).abs();
                *(if link.H[k].fixed_rows::<3>(0).norm() > 0.5 { &mut turn } else { &mut shift }) += kappa;
            }
            let (parent, square) = (link.parent, link.arm.norm_squared());
            self.links[index].stiff = [turn, shift];
            let above = &mut self.links[parent].stiff;
            above[0] += turn + square * shift;
            above[1] += shift;
        }
        let whole = |link: &Local| link.stiff[1] + link.stiff[0] / link.lever.powi(2);
        let most = self.links.iter().skip(1).map(whole).fold(0.0, f64::max);
        let is_tree = self.pulls.is_empty();
        for link in &mut self.links {
            let shift = self.stiffer * if is_tree { whole(link).max(1e-9 * most) } else { most };
            link.stiff = [shift * link.lever.powi(2), shift];
        }
        for (pull, rho) in self.pulls.iter().zip(&mut self.rho) {
            let of_link = |(link, wrench): &(usize, Wrench)| {
                let [turn, shift] = self.links[*link].stiff;
                match wrench.force.norm_squared() {
                    0.0 => turn / wrench.moment.norm_squared(),
                    square => shift / square,
                }
            };
            let of_coordinate = |(j, factor): &(usize, f64)| {
                let link = &self.links[self.link_of[*j]];
                let is_slide = link.H[j - link.first].fixed_rows::<3>(0).norm() == 0.0;
                link.stiff[usize::from(is_slide)] / (factor * factor)
            };
            let ends = pull.links.iter().map(of_link).chain(pull.coordinates.iter().map(of_coordinate));
            *rho = ends.filter(|rho| rho.is_finite()).fold(0.0, f64::max);
        }
    }

    /// Zero for what is held.
    pub fn hold(&self, x: &mut [f64]) {
        x.iter_mut().zip(&self.held).filter(|(_, held)| **held).for_each(|(x, _)| *x = 0.0);
    }

    /// `z += gᵀ ρ gaps`: what pushes where rows are open.
    pub fn push(&self, gaps: &[f64], z: &mut [f64]) {
        let n = self.kappa.len();
        for ((pull, rho), gap) in self.pulls.iter().zip(&self.rho).zip(gaps) {
            let by = rho * gap;
            pull.coordinates.iter().filter(|(j, _)| !self.held[*j]).for_each(|(j, factor)| z[*j] += by * factor);
            for (link, wrench) in &pull.links {
                let own = &mut z[n + 6 * (link - 1)..][..6];
                own.iter_mut().zip(of_wrench(wrench).iter()).for_each(|(z, w)| *z += by * w);
            }
        }
    }

    /// `g z` of a row.
    pub fn opened(&self, row: usize, z: &[f64]) -> f64 {
        let n = self.kappa.len();
        let pull = &self.pulls[row];
        let free = pull.coordinates.iter().filter(|(j, _)| !self.held[*j]);
        let links = pull.links.iter().map(|(link, wrench)| {
            let own = &z[n + 6 * (link - 1)..][..6];
            own.iter().zip(of_wrench(wrench).iter()).map(|(z, w)| z * w).sum::<f64>()
        });
        free.map(|(j, factor)| factor * z[*j]).sum::<f64>() + links.sum::<f64>()
    }

    /// `ρ` of a row.
    pub fn rho(&self, row: usize) -> f64 {
        self.rho[row]
    }

    /// `y ← K x` by (3); zero for what is held.
    pub fn times(&mut self, x: &[f64], y: &mut [f64]) {
        let Self { links, pairs, far, kappa, held, x: X, y: Y, .. } = self;
        for index in 1..links.len() {
            let link = &links[index];
            let mut z = carried(&X[link.parent], &link.arm);
            for k in 0..link.count {
                let j = link.first + k;
                if !held[j] {
                    z += x[j] * link.H[k];
                }
            }
            X[index] = z;
            Y[index] = link.S * z;
        }
        for (pair, far) in pairs.iter().zip(far) {
            Y[pair.feels] += *far * X[pair.moves];
            Y[pair.moves] += far.tr_mul(&X[pair.feels]);
        }
        for index in (1..links.len()).rev() {
            let link = &links[index];
            for k in (0..link.count).filter(|k| !held[link.first + k]) {
                Y[index] += 0.5 * x[link.first + k] * link.N[k];
            }
            for k in 0..link.count {
                let j = link.first + k;
                let spring: f64 = (0..link.count)
                    .filter(|i| !held[link.first + i])
                    .map(|i| link.spring[(k, i)] * x[link.first + i])
                    .sum();
                let sum = kappa[j] * x[j] + spring + 0.5 * link.N[k].dot(&X[index]) + link.H[k].dot(&Y[index]);
                y[j] = if held[j] { 0.0 } else { sum };
            }
            let own = Y[index];
            let (force, moment) = (own.fixed_rows::<3>(3).into_owned(), own.fixed_rows::<3>(0).into_owned());
            let moment = moment + link.arm.cross(&force);
            Y[link.parent] += Vector6::new(moment.x, moment.y, moment.z, force.x, force.y, force.z);
        }
        Y[0] = Vector6::zeros();
    }
}

/// `T X`: the motion of a marker from that of another, `d` away from it on the same body.
fn carried(x: &Vector6<f64>, d: &Vector3<f64>) -> Vector6<f64> {
    let turn = Vector3::new(x[0], x[1], x[2]);
    let shift = Vector3::new(x[3], x[4], x[5]) + turn.cross(d);
    Vector6::new(x[0], x[1], x[2], shift.x, shift.y, shift.z)
}

fn of_wrench(wrench: &Wrench) -> Vector6<f64> {
    let Wrench { force: f, moment: m } = wrench;
    Vector6::new(m.x, m.y, m.z, f.x, f.y, f.z)
}

/// Moment and force by turn and shift.
fn blocks(S: &Carried) -> Matrix6<f64> {
    let mut whole = Matrix6::zeros();
    let parts = [(0, 0, &S.turn.moment), (0, 3, &S.place.moment), (3, 0, &S.turn.force), (3, 3, &S.place.force)];
    for (row, column, block) in parts {
        whole.fixed_view_mut::<3, 3>(row, column).copy_from(&block.matrix());
    }
    whole
}
