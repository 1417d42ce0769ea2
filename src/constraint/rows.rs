//! The rows of a model's loops, drives, gears and locks.

use super::row::Rule;
use super::selection::{HeldRow, RowSelection};
use crate::hinge::Condition;
use crate::model::couplings::Closure;
use crate::model::prescribed::Instant;
use crate::model::{End, Loop, Model, Scalar};
use crate::motion::Motion;
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

/// Where rows come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Owner {
    /// Index into `Model::loops`.
    Loop(usize),
    /// Index into `Model::drives`.
    Drive(usize),
    /// Index into `Model::gears`.
    Gear(usize),
    /// What is held, by its first velocity coordinate: while positions are closed, or on a stop.
    Held(usize),
}

/// A loop, drive, gear or held coordinate and its rows.
#[derive(Debug, Clone)]
pub struct RowGroup {
    /// What it is.
    pub owner: Owner,
    /// What messages call it: ``loop `coupler-ground` ``.
    pub name: String,
    /// Its rows.
    pub rows: Range<usize>,
    /// Both ends of a loop.
    pub(super) ends: Option<[End; 2]>,
    /// The links from each end of a loop to where the two ways meet, that one left out.
    pub(super) branches: [Vec<usize>; 2],
    /// The links whose coordinates it names; 0 for none.
    pub(super) named: [usize; 2],
    held: Instant,
}

impl RowGroup {
    /// The links of both ends of a loop.
    pub(super) fn links(&self) -> Option<[usize; 2]> {
        self.ends.as_ref().map(|ends| [ends[0].link, ends[1].link])
    }

    /// What a motion row follows.
    pub(super) fn target(&self, model: &Model, time: f64) -> Instant {
        match self.owner {
            Owner::Drive(index) => model.drives[index].motion.at(time),
            Owner::Gear(index) => Instant { position: model.gears[index].offset, ..Instant::default() },
            Owner::Loop(_) | Owner::Held(_) => self.held,
        }
    }
}

/// The links from `a` and from `b` to where both ways meet, that one left out.
pub(super) fn branches(model: &Model, mut a: usize, mut b: usize) -> [Vec<usize>; 2] {
    let mut branches = [Vec::new(), Vec::new()];
    while a != b {
        // Parents have lower indices than their children.
        let (end, branch) = if a > b { (&mut a, &mut branches[0]) } else { (&mut b, &mut branches[1]) };
        branch.push(*end);
        *end = model.links[*end].parent;
    }
    branches
}

/// The links from the ends of an element to the root, tips first; the ground is left out.
pub(super) fn way(model: &Model, element: &RowGroup) -> Vec<usize> {
    let [mut a, mut b] = element.links().unwrap_or(element.named);
    let mut way = Vec::new();
    // Parents have lower indices than their children.
    while a.max(b) != 0 {
        let link = a.max(b);
        way.push(link);
        [a, b] = [a, b].map(|tip| if tip == link { model.links[link].parent } else { tip });
    }
    way
}

/// Elements and rows of a selection; and the positions as given.
pub(super) fn of_model(model: &Model, selection: &RowSelection) -> (Vec<RowGroup>, Vec<Rule>, Motion) {
    let mut rules = Vec::new();
    let mut elements = Vec::new();
    let mut given = Motion::new(model);
    if !model.loops.is_empty() || !selection.held.is_empty() {
        given.update(model, &model.start_position, &vec![0.0; model.velocity_count()]);
    }
    let nothing = Instant::default();
    for (index, closed) in model.loops.iter().enumerate() {
        let first = rules.len();
        of_loop(closed, &given, &mut rules);
        let rows = first..rules.len();
        let name = format!("loop `{}`", closed.name);
        let ends = Some(closed.ends);
        let branches = branches(model, closed.ends[0].link, closed.ends[1].link);
        let owner = Owner::Loop(index);
        elements.push(RowGroup { owner, name, rows, ends, branches, named: [0, 0], held: nothing });
    }
    let mut motion = |owner: Owner, name: String, parts: [(Scalar, f64); 2], held: Instant| {
        of_motion((owner, name), parts, held, &mut elements, &mut rules);
    };
    for (index, drive) in model.drives.iter().enumerate().filter(|(index, _)| !selection.released.contains(index)) {
        let parts = [(drive.coordinate, 1.0), (drive.coordinate, 0.0)];
        motion(Owner::Drive(index), format!("drive `{}`", drive.name), parts, nothing);
    }
    for (index, gear) in model.gears.iter().enumerate() {
        let parts = [(gear.coordinates[0], 1.0), (gear.coordinates[1], -gear.ratio)];
        motion(Owner::Gear(index), format!("gear `{}`", gear.name), parts, nothing);
    }
    hold(model, &selection.held, &given, &mut elements, &mut rules);
    (elements, rules, given)
}

/// The row of a sum of coordinates.
fn of_motion(
    (owner, name): (Owner, String),
    parts: [(Scalar, f64); 2],
    held: Instant,
    elements: &mut Vec<RowGroup>,
    rules: &mut Vec<Rule>,
) {
    let rows = rules.len()..rules.len() + 1;
    rules.push(Rule::Motion { parts });
    let named = parts.map(|(scalar, factor)| if factor == 0.0 { 0 } else { scalar.link });
    elements.push(RowGroup { owner, name, rows, ends: None, branches: [Vec::new(), Vec::new()], named, held });
}

/// Adds a row for each coordinate that is held, and three for each ball, which is held as it stands at `given`.
pub(super) fn hold(
    model: &Model,
    held: &[HeldRow],
    given: &Motion,
    elements: &mut Vec<RowGroup>,
    rules: &mut Vec<Rule>,
) {
    for held in held {
        match held {
            HeldRow::Coordinate { coordinate, at } => {
                let what = (Owner::Held(coordinate.velocity), format!("held {}", model.label(coordinate.velocity)));
                of_motion(what, [(*coordinate, 1.0), (*coordinate, 0.0)], *at, elements, rules);
            }
            HeldRow::Ball(link) => of_ball(model, *link, given, elements, rules),
        }
    }
}

/// The rows of a ball that is held.
fn of_ball(model: &Model, link: usize, given: &Motion, elements: &mut Vec<RowGroup>, rules: &mut Vec<Rule>) {
    let (parent, velocity) = (model.links[link].parent, model.links[link].velocity);
    let first = rules.len();
    let turned = given.links[link].turn.transpose() * given.links[parent].turn;
    rules.extend(turns_together(&Matrix3::identity(), &turned));
    elements.push(RowGroup {
        owner: Owner::Held(velocity),
        name: format!("held {}", model.label(velocity)),
        rows: first..rules.len(),
        ends: Some([parent, link].map(|link| End { link, body: None, point: Vector3::zeros() })),
        branches: branches(model, parent, link),
        named: [0, 0],
        held: Instant::default(),
    });
}

/// Turns of the loops' frames on their second links, taken where they stand at the given positions.
pub(super) fn second_frame(closed: &Loop, given: &Motion) -> Matrix3<f64> {
    let [first, second] = [&given.links[closed.ends[0].link], &given.links[closed.ends[1].link]];
    closed.second_frame.unwrap_or_else(|| second.turn.transpose() * first.turn * closed.frame)
}

/// The rows by which two frames, on two links, stand as one.
fn turns_together(one: &Matrix3<f64>, other: &Matrix3<f64>) -> [Rule; 3] {
    let aligned =
        |a: usize, b: usize| Rule::Aligned { first: one.column(a).into(), second: other.column(b).into(), cosine: 0.0 };
    [aligned(0, 1), aligned(1, 2), aligned(2, 0)]
}

/// The rows of one loop; both frames are taken where they stand at `given`.
fn of_loop(closed: &Loop, given: &Motion, rules: &mut Vec<Rule>) {
    let kind = match closed.closure {
        Closure::Rod { length } => {
            rules.push(Rule::Distance { length });
            return;
        }
        Closure::Hinge(kind) => kind,
    };
    let (one, other) = (closed.frame, second_frame(closed, given));
    rules.extend(kind.conditions().into_iter().map(|condition| match condition {
        Condition::Along(axis) => Rule::Along { axis: one * axis },
        Condition::Thread { axis, across, pitch } => {
            let [first, second] = [one, other].map(|frame| [frame * axis, frame * across]);
            Rule::Thread { first, second, pitch }
        }
        Condition::Aligned { first, second, cosine } => {
            Rule::Aligned { first: one * first, second: other * second, cosine }
        }
    }));
}
