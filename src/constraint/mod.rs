//! What ties coordinates together beyond the tree: closed loops, drives, gears.
//!
//! Everything is rows: a loop is a cut hinge whose rows say how its two ends may move against each other, a
//! drive is a row on one coordinate that depends on time, a gear a row between two. Rows are solved with the tree's own
//! factorization `M` ([`crate::transfer`]); no matrix of the size of the system is ever made:
//!
//! ```text
//! (1)  M q̈ = f + Gᵀ λ,   G q̈ + bias = 0     ⇒     A λ = −(G q̈₀ + bias),   A = G M⁻¹ Gᵀ,   M q̈₀ = f
//! (2)  A = Uᵀ D⁻¹ U                               the inward pass of each row's load, over its way to the root only
//! (3)  position   q ← q ⊞ M⁻¹ Gᵀ μ,   A μ = −g    repeated: the nearest closed position in the metric of the inertia
//! (4)  velocity   v ← v + M⁻¹ Gᵀ ν,   A ν = −(G v + g_t)
//! ```
//!
//! **Redundant rows are normal**: a planar four-bar of four spatial revolute hinges has three. Which rows are
//! independent is decided once, on closed positions (see [`assemble`]): where a stage of an integrator is off by a little,
//! redundant rows look independent. The others are left out until the mechanism's rank really changes.
//!
//! A row costs its way to the root and its neighbours: loops in a long chain cost a time proportional to their number.
//!
//! | file | its one job |
//! |---|---|
//! | `rows`, `row` | the rows of a model; of one its gap, how fast that opens, and the load of its multiplier |
//! | `selection` | which rows act beside those of the model, and which of these do not |
//! | `rank`, `choose` | which rows are linearly independent, by a factorization of their products with pivoting |
//! | [`assembly`], `close` | (3) and (4): positions and velocities brought onto the rows |
//! | `plan`, `component`, `envelope` | (2): the sparse structure of `A`, its components and its factors |
//! | `hold` | rows of what rests, which come and go in a run |
//! | `depend` | how rows that are left out depend on those solved for |
//! | `loads` | what rows push, and how redundant ones share it |
//! | `entries`, `listed`, `sizes` | rows as sparse rows, rows apart from the tree, the sizes of their terms |

pub mod assembly;
mod choose;
mod close;
mod component;
mod depend;
mod entries;
mod envelope;
mod hold;
mod listed;
mod loads;
mod plan;
mod rank;
mod row;
mod rows;
mod selection;
mod sizes;

use crate::model::Model;
use crate::motion::variation::LinkAcceleration;
use crate::motion::{LinkMotion, Motion};
use crate::spatial::Wrench;
use crate::transfer::Reduction;
use crate::transfer::reduce::parts;
use crate::transfer::tangent::Pull;
pub use assembly::{Assembly, assemble, assemble_at, closed, open_at};
pub(crate) use close::Closer;
pub use close::OpenGap;
use component::Lengths;
use entries::Entries;
use envelope::Envelope;
pub(crate) use listed::IndependentRow;
pub use loads::LoopReaction;
use nalgebra::Vector3;
use plan::{Meetings, Plan, Run};
pub(crate) use row::Rule;
use row::{Ends, Placed, place_motion, power};
pub use rows::{Owner, RowGroup};
pub use selection::{HeldRow, RowSelection};
use std::sync::Arc;

/// The rows of a model and the scratch memory to solve with them.
#[derive(Debug, Clone)]
pub struct Constraints {
    /// Loops, drives, gears, in this order; then coordinates that are held.
    elements: Vec<RowGroup>,
    /// How many of them are the model's own, and which of their rows are solved for: coordinates held on stops come and go.
    own: usize,
    independent: Vec<bool>,
    rules: Vec<Rule>,
    placed: Vec<Placed>,
    /// From each element's ends to the root, tips first.
    ways: Vec<Vec<usize>>,
    /// In how many parts a push is given, per link.
    parts: Vec<usize>,
    /// Which links are fixed to the ground by their hinges.
    grounded: Vec<bool>,
    /// Where the entries of the rows solved for stand, once that is known.
    entries: Option<Arc<Entries>>,
    /// What makes multipliers of angles comparable with those of lengths, per row: the span of its component (m); 1 for lengths.
    weights: Vec<f64>,
    /// What makes their pivots comparable, likewise: its lever where the model begins.
    levers: Vec<f64>,
    /// The length that gaps are compared with, per row: the reach of its component (m).
    reaches: Vec<f64>,
    plan: Plan,
    /// Where its groups meet; where all of many loops on one tree do, once the matrix is asked for.
    meetings: Option<Arc<Meetings>>,
    matrix: Envelope,
    /// `u` and `D⁻¹ u` of eq. (2), per group, part of the links of its way and row; likewise.
    pushes: Vec<[Vector3<f64>; 2]>,
    /// `e` along one way.
    passed: Vec<Wrench>,
    unknowns: Vec<f64>,
    /// What the pivots of the unknowns are compared with.
    sizes: Vec<f64>,
    /// Multipliers of all rows (N or N m).
    multipliers: Vec<f64>,
    /// Whether rows that are left out push too, and which rows' multipliers are not unique: known once they are shared.
    is_shared: bool,
    /// All multipliers as they were before that.
    unshared: Vec<f64>,
    not_unique: Vec<bool>,
    /// Multipliers that balance each other, by rows: one list for each row left out, once they are shared.
    self_stresses: Vec<Vec<(usize, f64)>>,
    /// Lengths of the model's own elements.
    lengths: Vec<Lengths>,
    /// Time (s).
    time: f64,
}

/// The largest rate among rows, and the row.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Largest {
    /// In parts of the component's reach, or radians.
    pub(crate) relative: f64,
    /// In metres, radians times the component's reach.
    pub(crate) absolute: f64,
    row: Option<usize>,
}

/// What a rate of the rows is made of.
#[derive(Clone, Copy)]
pub(crate) enum Rate<'a> {
    /// `g`.
    Gap,
    /// `ġ` with these hinge velocities; the links' are in the motion.
    Speed(&'a [f64]),
    /// `G ν` of a change of hinge velocities `ν`, as `ġ` without what drives prescribe; the links' are in the motion.
    Change(&'a [f64]),
    /// `g̈` with these accelerations of links and hinges.
    Acceleration(&'a [LinkAcceleration], &'a [f64]),
}

impl Constraints {
    /// All rows of a selection, none left out.
    pub(crate) fn every_row(model: &Model, selection: &RowSelection) -> Self {
        let mut all = Self::unplanned(model, selection);
        all.keep(|_| true);
        all
    }

    /// The rows of a selection before it is said which of them are solved for.
    fn unplanned(model: &Model, selection: &RowSelection) -> Self {
        let (elements, rules, given) = rows::of_model(model, selection);
        let ways: Vec<Vec<usize>> = elements.iter().map(|element| rows::way(model, element)).collect();
        let [mut weights, mut levers, mut reaches] = [(); 3].map(|()| vec![1.0; rules.len()]);
        let lengths = component::lengths(model, &elements, &rules, &given);
        let spans = component::spans(model, &elements, &rules);
        for ((element, lengths), span) in elements.iter().zip(&lengths).zip(spans) {
            for row in element.rows.clone() {
                (weights[row], levers[row]) = if rules[row].turns() { (span, lengths.lever) } else { (1.0, 1.0) };
                reaches[row] = lengths.reach;
            }
        }
        Self {
            placed: vec![Placed::default(); rules.len()],
            multipliers: vec![0.0; rules.len()],
            is_shared: false,
            unshared: Vec::new(),
            not_unique: vec![false; rules.len()],
            self_stresses: Vec::new(),
            lengths,
            passed: vec![Wrench::ZERO; model.links.len()],
            own: elements.len(),
            independent: vec![true; rules.len()],
            elements,
            rules,
            ways,
            parts: model.links.iter().map(parts).collect(),
            grounded: model.links.iter().map(|link| link.parent == 0).collect(),
            entries: None,
            weights,
            levers,
            reaches,
            plan: Plan::default(),
            meetings: None,
            matrix: Envelope::default(),
            pushes: Vec::new(),
            unknowns: Vec::new(),
            sizes: Vec::new(),
            time: 0.0,
        }
    }

    /// The rows of a model; `None` if it has none. Which of them are independent is what [`assemble`] found, or is
    /// decided here at the given positions where the model has not been assembled.
    pub fn new(model: &Model) -> Option<Self> {
        if !model.is_constrained() {
            return None;
        }
        let independent = match &model.independent_rows {
            Some(rows) => rows.clone(),
            None => rank::decide(model, &RowSelection::default(), &model.start_position, 0.0).independent,
        };
        Some(Self::of_independent(model, &RowSelection::default(), independent))
    }

    /// The rows of a selection; `None` if it has none there. Which of them are independent is decided at a position and a
    /// time.
    pub fn selected(model: &Model, selection: &RowSelection, time: f64, q: &[f64]) -> Option<Self> {
        let is_empty = selection.held.is_empty() && selection.released.len() == model.drives.len();
        if is_empty && model.loops.is_empty() && model.gears.is_empty() {
            return None;
        }
        let independent = rank::decide(model, selection, q, time).independent;
        Some(Self::of_independent(model, selection, independent))
    }

    fn of_independent(model: &Model, selection: &RowSelection, independent: Vec<bool>) -> Self {
        let mut rows = Self::unplanned(model, selection);
        rows.keep(|row| independent[row]);
        rows.independent = independent;
        rows
    }

    /// Solves from now on for the rows that `wanted` says.
    fn keep(&mut self, wanted: impl Fn(usize) -> bool) {
        let rows_of = self.elements.iter().map(|element| element.rows.clone().filter(|row| wanted(*row)).collect());
        self.plan = Plan::new(rows_of.collect(), &self.ways, &self.parts, &self.grounded);
        self.entries = None;
        self.matrix = Envelope::new(self.plan.first_columns.clone());
        (self.meetings, self.pushes) = (None, Vec::new());
        self.unknowns = vec![0.0; self.plan.unknowns];
        self.sizes = vec![0.0; self.plan.unknowns];
        if !self.is_filled() {
            self.make_room();
        }
    }

    /// Room for the matrix, with zeros in it.
    fn make_room(&mut self) {
        if self.meetings.is_none() {
            self.meetings = Some(Arc::new(self.plan.meetings(&self.ways, &self.parts, &self.grounded)));
            self.pushes = vec![[Vector3::zeros(); 2]; self.plan.pushes];
        }
        self.matrix.clear();
    }

    /// The time at which drives are looked at (s).
    pub fn set_time(&mut self, time: f64) {
        self.time = time;
    }

    /// The time at which drives are looked at (s).
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Loops, drives, gears, in this order.
    pub fn elements(&self) -> &[RowGroup] {
        &self.elements
    }

    /// The multipliers of the last solution, one per row: what each row pushes with (N or N m). Zero for rows left out,
    /// unless they have been shared.
    pub fn multipliers(&self) -> &[f64] {
        &self.multipliers
    }

    /// Sine of the smallest angle between a row and those before it at the last factorization, in the metric of the
    /// inertia: 0 in a singular position.
    pub(crate) fn clearance(&self) -> f64 {
        self.matrix.smallest_pivot().sqrt()
    }

    /// Number of rows that are solved for.
    pub fn rank(&self) -> usize {
        self.plan.unknowns
    }

    /// Places rows at a state: those solved for, or all of them.
    pub(crate) fn place(&mut self, model: &Model, motion: &Motion, q: &[f64], all: bool) {
        let Self { elements, rules, placed, plan, time, .. } = self;
        let mut place = |index: usize, rows: &mut dyn Iterator<Item = usize>| {
            let element: &RowGroup = &elements[index];
            match &element.ends {
                Some(ends) => {
                    let ends = Ends::of(ends, &element.branches, motion);
                    rows.for_each(|row| placed[row] = ends.place(&rules[row]));
                }
                None => {
                    let now = element.target(model, *time);
                    for row in rows {
                        if let Rule::Motion { parts } = &rules[row] {
                            placed[row] = place_motion(parts, q, &now);
                        }
                    }
                }
            }
        };
        if all {
            (0..elements.len()).for_each(|index| place(index, &mut elements[index].rows.clone()));
        } else {
            plan.groups.iter().for_each(|group| place(group.element, &mut group.rows.iter().copied()));
        }
    }

    /// Eq. (2) and its factorization, at the position of the tree's last factorization; `damping` (0 for none) is added
    /// to the diagonal in units of the largest entry of the same element.
    pub(crate) fn factorize(&mut self, model: &Model, motion: &Motion, reduction: &Reduction, damping: f64) {
        self.assemble(model, motion, reduction);
        self.size_rows();
        if damping > 0.0 {
            for (i, size) in self.sizes.iter().enumerate() {
                *self.matrix.entry(i, i) += damping * size;
            }
        }
        self.matrix.factorize(&self.sizes);
    }

    /// What the pivots of rows are compared with: the largest entry of the same element, angles as lengths.
    fn size_rows(&mut self) {
        for group in &self.plan.groups {
            let weighted = group.rows.iter().enumerate().map(|(k, row)| {
                let at = group.first + k;
                self.levers[*row] * self.levers[*row] * self.matrix.get(at, at)
            });
            let largest = weighted.fold(0.0, f64::max);
            for (k, row) in group.rows.iter().enumerate() {
                self.sizes[group.first + k] = largest / (self.levers[*row] * self.levers[*row]);
            }
        }
    }

    /// Eq. (2), not factorized.
    fn assemble(&mut self, model: &Model, motion: &Motion, reduction: &Reduction) {
        self.make_room();
        let Some(meetings) = self.meetings.take() else { return };
        for group in 0..self.plan.groups.len() {
            self.push(model, motion, reduction, group);
        }
        for meeting in &meetings.pairs {
            let [later, earlier] = meeting.groups.map(|group| &self.plan.groups[group]);
            let (rows, columns) = (later.rows.len(), earlier.rows.len());
            for r in 0..rows {
                // Of a group with itself only the lower half.
                let until = if std::ptr::eq(later, earlier) { r + 1 } else { columns };
                for c in 0..until {
                    let mut sum = 0.0;
                    for Run { places: [i, j], count } in &meetings.common[meeting.common.clone()] {
                        let mine = self.pushes[later.pushes + i * rows..][..count * rows].chunks_exact(rows);
                        let other =
                            self.pushes[earlier.pushes + j * columns..][..count * columns].chunks_exact(columns);
                        mine.zip(other).for_each(|(mine, other)| sum += mine[r][0].dot(&other[c][1]));
                    }
                    *self.matrix.entry(later.first + r, earlier.first + c) += sum;
                }
            }
        }
        self.meetings = Some(meetings);
    }

    /// The inward pass of the loads of one group.
    fn push(&mut self, model: &Model, motion: &Motion, reduction: &Reduction, group: usize) {
        let group = &self.plan.groups[group];
        let way = &self.ways[group.element];
        for (k, row) in group.rows.iter().enumerate() {
            way.iter().for_each(|link| self.passed[*link] = Wrench::ZERO);
            if let Some(ends) = &self.elements[group.element].ends {
                for (end, wrench) in ends.iter().zip(self.placed[*row].wrenches) {
                    self.passed[end.link] += Wrench::ZERO - wrench;
                }
            }
            let mut at = group.pushes + k;
            for link in way {
                let tau = self.rules[*row].tau(*link);
                let mut e = self.passed[*link];
                let (pushes, passed) = (&mut self.pushes, &self.passed);
                reduction.pass((model, motion), (*link, passed), tau, &mut e, |push| {
                    pushes[at] = push;
                    at += group.rows.len();
                });
                self.passed[model.links[*link].parent] += e.shifted(motion.links[*link].arm);
            }
            clear_interfaces(model, way, &mut self.passed);
        }
    }

    /// One rate of a row.
    fn rate(&self, row: usize, ends: Option<[usize; 2]>, motion: &Motion, rate: Rate<'_>) -> f64 {
        let placed = &self.placed[row];
        let parts = |numbers: &[f64]| match &self.rules[row] {
            Rule::Motion { parts } => parts.iter().map(|(scalar, factor)| factor * numbers[scalar.velocity]).sum(),
            _ => 0.0,
        };
        let over_ends = |of: &dyn Fn(&Wrench, usize) -> f64| {
            ends.map_or(0.0, |ends| of(&placed.wrenches[0], ends[0]) + of(&placed.wrenches[1], ends[1]))
        };
        let speed = |w: &Wrench, link: usize| {
            let at: &LinkMotion = &motion.links[link];
            power(w, &at.velocity, &at.angular_velocity)
        };
        match rate {
            Rate::Gap => placed.gap,
            Rate::Speed(v) => over_ends(&speed) + parts(v) + placed.drift,
            Rate::Change(v) => over_ends(&speed) + parts(v),
            Rate::Acceleration(links, hinges) => {
                let acceleration = |w: &Wrench, link: usize| power(w, &links[link].linear, &links[link].angular);
                over_ends(&acceleration) + parts(hinges) + placed.bias
            }
        }
    }

    /// `A λ = −rate`: the multipliers that take a rate away.
    pub(crate) fn solve(&mut self, motion: &Motion, rate: Rate<'_>) {
        let mut unknowns = std::mem::take(&mut self.unknowns);
        for group in &self.plan.groups {
            let ends = self.elements[group.element].links();
            for (k, row) in group.rows.iter().enumerate() {
                unknowns[group.first + k] = -self.rate(*row, ends, motion, rate);
            }
        }
        self.matrix.solve(&mut unknowns);
        self.set_multipliers(&unknowns);
        self.unknowns = unknowns;
    }

    /// One rate of every row that is solved for.
    pub(crate) fn rates(&self, motion: &Motion, rate: Rate<'_>, out: &mut [f64]) {
        for group in &self.plan.groups {
            let ends = self.elements[group.element].links();
            for (k, row) in group.rows.iter().enumerate() {
                out[group.first + k] = self.rate(*row, ends, motion, rate);
            }
        }
    }

    /// The largest rate of the rows beside their components; of all rows or of those solved for.
    pub(crate) fn largest(&self, motion: &Motion, rate: Rate<'_>, all: bool) -> Largest {
        let mut largest = Largest::default();
        let mut look = |element: &RowGroup, row: usize| {
            let value = self.rate(row, element.links(), motion, rate).abs();
            let relative = self.relative(row, value);
            if relative > largest.relative || relative.is_nan() {
                largest = Largest { relative, absolute: relative * self.reaches[row], row: Some(row) };
            }
        };
        if all {
            self.elements.iter().for_each(|element| element.rows.clone().for_each(|row| look(element, row)));
        } else {
            for group in &self.plan.groups {
                group.rows.iter().for_each(|row| look(&self.elements[group.element], *row));
            }
        }
        largest
    }

    /// What a row says in metres or radians, in parts of its component's reach or radians.
    fn relative(&self, row: usize, value: f64) -> f64 {
        if self.rules[row].turns() { value } else { value / self.reaches[row] }
    }

    /// The gap of a row as placed last (part of its component's reach; rad).
    fn relative_gap(&self, row: usize) -> f64 {
        self.relative(row, self.placed[row].gap.abs())
    }

    /// What a unit multiplier of each row solved for pulls at, as placed last.
    pub(crate) fn pulls(&self) -> Vec<Pull> {
        let mut pulls = Vec::with_capacity(self.rank());
        for group in &self.plan.groups {
            let element = &self.elements[group.element];
            for row in &group.rows {
                let mut pull = Pull::default();
                match (&self.rules[*row], &element.ends) {
                    (Rule::Motion { parts }, _) => {
                        let parts = parts.iter().filter(|part| part.1 != 0.0);
                        pull.coordinates.extend(parts.map(|(scalar, factor)| (scalar.velocity, *factor)));
                    }
                    (_, Some(ends)) => {
                        let wrenches = ends.iter().zip(self.placed[*row].wrenches);
                        pull.links.extend(wrenches.filter(|(end, _)| end.link != 0).map(|(end, w)| (end.link, w)));
                    }
                    (_, None) => {}
                }
                pulls.push(pull);
            }
        }
        pulls
    }

    /// Which element a row belongs to.
    pub(crate) fn element_of(&self, row: usize) -> Option<&RowGroup> {
        self.elements.iter().find(|element| element.rows.contains(&row))
    }
}

/// Wrenches on interfaces that other rows do not load.
fn clear_interfaces(model: &Model, way: &[usize], passed: &mut [Wrench]) {
    if !model.modals.is_empty() {
        way.iter().for_each(|link| passed[*link] = Wrench::ZERO);
    }
}
