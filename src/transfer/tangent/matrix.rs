//! The tangent as a sparse matrix in hinge coordinates: what the sweep eliminates on the way, written down instead, and with
//! the elements that couple links of different branches.
//!
//! ```text
//! (1) S        of a link and all that it carries: Xᵀ S T summed without elimination
//! (2) column   w = S h + [n × f; n × m],   w ← Xᵀ w up to the root:    K_ij = H_iᵀ w    i inboard of j, or j itself
//! (3) row      ρ = Hᵀ S,   ρ ← ρ T up to the root:                     K_ji = ρ h_i
//! (4) pair     a link a that feels (−B) how another one b moves, up to the link p where their ways to the root meet:
//!              e = B T … T h_j,  e ← Xᵀ e:   K_ij += H_iᵀ e             j from b to p, i from a to p
//!              at p:   w of column j gains e,   ρ of row i gains H_iᵀ B T … T,   S gains Xᵀ … B T …
//! ```
//!
//! with the symbols of the parent module. A pair takes the product of its two distances to `p`, everything else one step for each entry
//! of the pattern. Of a symmetric tangent (at rest, loads with a potential) (3) is (2) transposed, and pairs give the
//! mean of both sides. Pattern and places of the entries are worked out once.

mod structure;

use super::applied::Applied;
use super::hinge::{Around, Left, Three, Way};
use super::parts::{Carried, PLACES, Varied};
use super::{At, MOVING};
use crate::model::Model;
use crate::spatial::Wrench;
use crate::spatial::quad::Quad;
use crate::transfer::plan::{Kind, Place, To, plan};
use nalgebra::Matrix3;
use std::collections::BTreeMap;
use structure::meet;

/// All that a varied state can have.
const ALL: u8 = MOVING | PLACES;

/// Two links of one element: what the first feels when the second moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pair {
    /// The link that feels.
    pub feels: usize,
    /// The link that moves.
    pub moves: usize,
}

/// A pair and where its ways to the root meet.
#[derive(Debug, Clone, Copy)]
struct Meeting {
    pair: Pair,
    link: usize,
    /// Index of that link among the links where pairs meet; `None` for the ground.
    sum: Option<usize>,
}

/// One coordinate at the point of the tangent.
#[derive(Debug, Clone, Copy)]
struct Axis {
    n: Quad,
    way: Way,
    h: Varied,
}

/// The sparse tangent of one model.
#[derive(Debug, Clone)]
pub struct TangentMatrix {
    plan: Vec<Place>,
    /// Coordinates of every link: the first one and how many.
    coordinates: Vec<(usize, usize)>,
    /// Upper triangle by columns: where each begins, and its rows, ascending, the diagonal last.
    starts: Vec<usize>,
    rows: Vec<usize>,
    /// Entries at and above the diagonal, and those below it at the places of their mirror images.
    upper: Vec<f64>,
    lower: Vec<f64>,
    /// Places of the entries in the order in which (2) comes to them, and where those of each column begin.
    inboard: Vec<u32>,
    inboard_starts: Vec<usize>,
    /// Places of the entries in the order in which (4) comes to them.
    across: Vec<u32>,
    meetings: Vec<Meeting>,
    /// `S` that the links where pairs meet gain, ascending by link.
    sums: Vec<(usize, Carried)>,
    /// Where each coordinate's column and row gain something: the links, by coordinate and then from the tips; what columns
    /// gain there, and rows.
    gain_starts: Vec<usize>,
    gain_links: Vec<usize>,
    column_gains: Vec<(Quad, Quad)>,
    row_gains: Vec<Varied>,
    axes: Vec<Axis>,
    left: Vec<Left>,
    balls: Vec<Three>,
    joins: Vec<Carried>,
}

impl TangentMatrix {
    /// The pattern for a model with these pairs.
    pub fn new(model: &Model, pairs: &[Pair]) -> Self {
        let (pages, joins, balls) = plan(model);
        let coordinates: Vec<(usize, usize)> =
            model.links.iter().map(|link| (link.velocity, link.joint.counts().1)).collect();
        let n = model.velocity_count();
        let mut met: BTreeMap<usize, usize> = BTreeMap::new();
        for link in pairs.iter().map(|pair| meet(model, *pair)).filter(|link| *link != 0) {
            met.insert(link, 0);
        }
        met.values_mut().enumerate().for_each(|(index, place)| *place = index);
        let meeting = |pair: &Pair| {
            let link = meet(model, *pair);
            Meeting { pair: *pair, link, sum: met.get(&link).copied() }
        };
        let none = Axis { n: Quad::default(), way: Way { slides: false, pitch: 0.0 }, h: Varied::default() };
        let mut new = Self {
            plan: pages.iter().copied().collect(),
            coordinates,
            starts: Vec::new(),
            rows: Vec::new(),
            upper: Vec::new(),
            lower: Vec::new(),
            inboard: Vec::new(),
            inboard_starts: Vec::new(),
            across: Vec::new(),
            meetings: pairs.iter().map(meeting).collect(),
            sums: met.keys().map(|link| (*link, Carried::default())).collect(),
            gain_starts: Vec::new(),
            gain_links: Vec::new(),
            column_gains: Vec::new(),
            row_gains: Vec::new(),
            axes: vec![none; n],
            left: vec![Left::default(); model.links.len()],
            balls: vec![Three::default(); balls],
            joins: vec![Carried::default(); joins],
        };
        new.find_pattern(n);
        new.find_gains(n);
        new
    }

    /// Where each column of the upper triangle begins, and its rows, ascending.
    pub fn pattern(&self) -> (&[usize], &[usize]) {
        (&self.starts, &self.rows)
    }

    /// Entries at and above the diagonal in the order of the pattern.
    pub fn upper(&self) -> &[f64] {
        &self.upper
    }

    /// Entries below the diagonal, each at the place of its mirror image; those on it. Of a symmetric tangent zeros.
    pub fn lower(&self) -> &[f64] {
        &self.lower
    }

    fn parent(&self, link: usize) -> usize {
        self.plan[link].parent as usize
    }

    fn of_link(&self, link: usize) -> std::ops::Range<usize> {
        let (first, count) = self.coordinates[link];
        first..first + count
    }

    /// Writes the tangent down. `felt` has for each pair what the one link feels when the other moves; `at.coupled` is not
    /// looked at. `at.diagonal` is finite.
    pub fn assemble(&mut self, model: &Model, at: &At<'_>, felt: &[Applied], symmetric: bool) {
        let accelerated = !at.motion.still || at.c1 != 0.0 || at.c2 != 0.0 || at.hinge.iter().any(|a| *a != 0.0);
        self.upper.fill(0.0);
        self.lower.fill(0.0);
        self.sums.iter_mut().for_each(|(_, sum)| *sum = Carried::default());
        self.column_gains.fill(Default::default());
        if !symmetric {
            self.row_gains.fill(Varied::default());
        }
        match accelerated {
            true => self.write::<ALL>(model, at, felt, symmetric),
            false => self.write::<PLACES>(model, at, felt, symmetric),
        }
    }

    fn write<const PARTS: u8>(&mut self, model: &Model, at: &At<'_>, felt: &[Applied], symmetric: bool) {
        self.place::<PARTS>(model, at);
        let mut across = 0;
        for index in 0..self.meetings.len() {
            across = self.add_pair::<PARTS>(self.meetings[index], &felt[index], symmetric, across);
        }
        self.inward::<PARTS>(model, at, symmetric);
    }

    /// Axes, arms and the columns `h` of every hinge.
    fn place<const PARTS: u8>(&mut self, model: &Model, at: &At<'_>) {
        for index in 1..self.plan.len() {
            let (place, own) = (self.plan[index], &at.motion.links[index]);
            let around = Around::new(at, (&at.balance.accelerations[index], own), self.parent(index), &model.gravity);
            let pitch = if place.kind == Kind::Screw { model.links[index].joint.pitch() } else { 0.0 };
            let way = Way { slides: place.kind == Kind::Slide, pitch };
            self.left[index].arm = own.arm;
            self.left[index].swing = around.swing(own, way);
            let first = place.velocity as usize;
            match place.kind {
                // No scene with flexible elements gets here (`TangentSolver::is_sparse`).
                Kind::None | Kind::Flex | Kind::Modal | Kind::Interface => {}
                Kind::Turn | Kind::Slide | Kind::Screw => {
                    let n = Quad::of(&own.axis);
                    self.axes[first] = Axis { n, way, h: around.one::<PARTS>(n, way) };
                }
                Kind::Ball => {
                    let ball = &mut self.balls[place.ball as usize];
                    ball.h = around.three();
                    for k in 0..3 {
                        let n = Quad::of(&own.turn.column(k).into_owned());
                        let mut h = Varied::default();
                        ball.turn_by(&mut h, n);
                        self.axes[first + k] = Axis { n, way, h };
                    }
                }
            }
        }
    }

    /// Eq. (4), from the entry `across` on; returns where the next pair's entries begin.
    fn add_pair<const PARTS: u8>(
        &mut self,
        Meeting { pair, link, sum }: Meeting,
        felt: &Applied,
        symmetric: bool,
        mut across: usize,
    ) -> usize {
        let mut B = Carried::default();
        B.take_applied::<PARTS>(felt);
        let mut b = pair.moves;
        while b != link {
            for j in self.of_link(b) {
                let (force, mut moment) = B.times::<PARTS>(&self.axes[j].h);
                let mut a = pair.feels;
                while a != link {
                    for i in self.of_link(a) {
                        let Axis { n, way, .. } = self.axes[i];
                        self.add_mean(self.across[across], way.project(n, force, moment), symmetric);
                        across += 1;
                    }
                    moment = Quad::of(&self.left[a].arm).cross_add(force, moment);
                    a = self.parent(a);
                }
                if let Some(gain) = self.gain(j, link) {
                    let gain = &mut self.column_gains[gain];
                    *gain = (gain.0 + force, gain.1 + moment);
                }
            }
            B.compose::<PARTS>(&self.left[b].arm, &self.left[b].swing);
            b = self.parent(b);
        }
        let Some(sum) = sum else { return across };
        let mut a = pair.feels;
        while a != link {
            if !symmetric {
                for i in self.of_link(a) {
                    let row = row::<PARTS>(&B, &self.axes[i]);
                    if let Some(gain) = self.gain(i, link) {
                        self.row_gains[gain].add_times::<PARTS>(1.0, &row);
                    }
                }
            }
            B.shift::<PARTS>(&self.left[a].arm);
            a = self.parent(a);
        }
        self.sums[sum].1.add::<PARTS>(&B);
        across
    }

    /// Which gain of a coordinate is that at a link.
    fn gain(&self, coordinate: usize, link: usize) -> Option<usize> {
        let own = self.gain_starts[coordinate]..self.gain_starts[coordinate + 1];
        self.gain_links[own.clone()].binary_search_by(|at| link.cmp(at)).ok().map(|place| own.start + place)
    }

    /// An entry whose mirror image comes too.
    fn add_mean(&mut self, place: u32, value: f64, symmetric: bool) {
        let at = place as usize / 2;
        match (symmetric, place % 2) {
            (true, _) => self.upper[at] += 0.5 * value,
            (false, 0) => self.upper[at] += value,
            (false, _) => self.lower[at] += value,
        }
    }

    /// Tips → root: eqs. (1) to (3).
    fn inward<const PARTS: u8>(&mut self, model: &Model, at: &At<'_>, symmetric: bool) {
        let mut springs = at.ball_springs.iter().rev().peekable();
        let mut forces = at.applied.iter().rev().peekable();
        let mut met = self.sums.len();
        let mut S = Carried::default();
        for index in (1..self.plan.len()).rev() {
            let (place, own) = (self.plan[index], &at.motion.links[index]);
            if place.is_leaf {
                S.each::<PARTS>(|block| *block = Default::default());
            } else if let Some(join) = place.join {
                S.add::<PARTS>(&std::mem::take(&mut self.joins[join as usize]));
            }
            if !place.is_massless {
                let b = Quad::of(&at.balance.accelerations[index].linear) - Quad::of(&model.gravity);
                S.add_body::<PARTS>(&model.links[index], own, b);
            }
            if forces.peek().is_some_and(|(link, _)| *link == index) {
                while let Some((_, blocks)) = forces.next_if(|(link, _)| *link == index) {
                    S.take_applied::<PARTS>(blocks);
                }
                S.take_turned(&at.wrenches[index]);
            }
            if met > 0 && self.sums[met - 1].0 == index {
                met -= 1;
                S.add::<PARTS>(&self.sums[met].1);
            }
            let spring = springs.next_if(|(link, _)| *link == index).map(|(_, spring)| spring);
            for j in self.of_link(index) {
                self.add_column::<PARTS>(index, j, &S, (at, spring), symmetric);
                if !symmetric {
                    self.add_row::<PARTS>(index, j, &S);
                }
            }
            if matches!(place.to, To::Ground) {
                continue;
            }
            S.shift::<PARTS>(&own.arm);
            S.compose::<PARTS>(&own.arm, &self.left[index].swing);
            if let To::Join(join) = place.to {
                self.joins[join as usize].add::<PARTS>(&S);
            }
        }
    }

    /// Eq. (2) for coordinate `j` of a link.
    fn add_column<const PARTS: u8>(
        &mut self,
        index: usize,
        j: usize,
        S: &Carried,
        (at, spring): (&At<'_>, Option<&Matrix3<f64>>),
        symmetric: bool,
    ) {
        let Axis { n, way, h } = self.axes[j];
        let (mut force, mut moment) = S.times::<PARTS>(&h);
        let mut next = self.inboard_starts[j];
        let first = self.coordinates[index].0;
        for i in self.of_link(index) {
            let value = way.project(self.axes[i].n, force, moment) + spring.map_or(0.0, |k| k[(i - first, j - first)]);
            match i == j {
                true => self.upper[self.inboard[next] as usize / 2] += value + at.diagonal[j],
                false => self.add_mean(self.inboard[next], value, symmetric),
            }
            next += 1;
        }
        // What the hinge passes on turns, or slides along, with the link.
        let Wrench { force: passed, moment: passed_moment } = at.balance.reactions[index];
        let passed = Quad::of(&passed);
        if way.slides {
            moment = n.cross_add(passed, moment);
        } else {
            force = n.cross_add(passed, force);
            moment = n.cross_add(Quad::of(&passed_moment), moment);
            if way.pitch != 0.0 {
                moment = Quad::all(way.pitch).times_add(n.cross(passed), moment);
            }
        }
        let (mut link, mut gained) = (index, self.gain_starts[j]);
        loop {
            moment = Quad::of(&self.left[link].arm).cross_add(force, moment);
            link = self.parent(link);
            if link == 0 {
                break;
            }
            if gained < self.gain_starts[j + 1] && self.gain_links[gained] == link {
                let more = self.column_gains[gained];
                (force, moment) = (force + more.0, moment + more.1);
                gained += 1;
            }
            for i in self.of_link(link) {
                let Axis { n, way, .. } = self.axes[i];
                self.upper[self.inboard[next] as usize / 2] += way.project(n, force, moment);
                next += 1;
            }
        }
    }

    /// Eq. (3) for coordinate `j` of a link.
    fn add_row<const PARTS: u8>(&mut self, index: usize, j: usize, S: &Carried) {
        let mut row = row::<PARTS>(S, &self.axes[j]);
        let mut next = self.inboard_starts[j] + self.coordinates[index].1;
        let (mut link, mut gained) = (index, self.gain_starts[j]);
        loop {
            row.compose(&self.left[link].arm, &self.left[link].swing);
            link = self.parent(link);
            if link == 0 {
                break;
            }
            if gained < self.gain_starts[j + 1] && self.gain_links[gained] == link {
                row.add_times::<PARTS>(1.0, &self.row_gains[gained]);
                gained += 1;
            }
            for i in self.of_link(link) {
                self.lower[self.inboard[next] as usize / 2] += row.dot::<PARTS>(&self.axes[i].h);
                next += 1;
            }
        }
    }
}

/// `Hᵀ S`.
fn row<const PARTS: u8>(S: &Carried, axis: &Axis) -> Varied {
    let mut row = S.row::<PARTS>(axis.n, axis.way.slides);
    if axis.way.pitch != 0.0 {
        row.add_times::<PARTS>(axis.way.pitch, &S.row::<PARTS>(axis.n, true));
    }
    row
}
