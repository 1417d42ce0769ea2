//! Which rows are linearly independent: decided on closed positions, of the rows themselves (see [`super::choose`]).
//!
//! ```text
//! Ĝ = W G L        rows of unit size over turns (rad) and slides (parts of the component's lever)                (1)
//! ```
//!
//! Rank is a matter of geometry: `Ĝ` knows no masses, and each component (see [`super::component`]) is decided by itself. The
//! rows are looked at in the position itself and in closed positions around it: in a singular position (a change point, a dead
//! centre) rows are linearly dependent that are not elsewhere, and those have to be kept. Where nothing can move without a drive no
//! path leads to from here: that is another way to assemble the scene.

use super::choose::{self, DEPENDENT};
use super::close::{Closing, Metric};
use super::component::{between_ends, components, lengths, levers, members};
use super::row::Rule;
use super::rows::Owner;
use super::{Constraints, RowSelection};
use crate::model::{Link, Model};
use crate::motion::Motion;
use crate::sparse::SparseRows;

/// How far around the position is looked (rad; part of the component's reach).
const AROUND: f64 = 0.05;
/// Other positions that are looked at.
const OTHERS: usize = 2;
/// Positions whose gaps are below this part of the component's reach are closed.
const CLOSED: f64 = 1e-9;

/// What was decided.
#[derive(Debug, Clone)]
pub(super) struct Ranking {
    /// Per row.
    pub(super) independent: Vec<bool>,
    /// At the position itself fewer rows are independent than around it.
    pub(super) singular: bool,
}

/// Decides for a selection at a closed position, at the time of the drives.
pub(super) fn decide(model: &Model, selection: &RowSelection, q: &[f64], time: f64) -> Ranking {
    let mut closing = Closing::new(model, selection, time);
    closing.gap(model, q);
    let mut independent = closing.rows.independent_now(model, &closing.motion);
    let components = members(&components(model, &closing.rows.elements));
    let steps = (1..=OTHERS).map(|attempt| around(model, &closing, &components, attempt)).collect::<Vec<_>>();
    let mut singular = false;
    let metric = closing.nearby();
    // Those rows alone lead back, where products of all of them are made, unless they leave others open.
    let mut fewer = (metric == Metric::Coordinates && independent.contains(&false)).then(|| {
        let mut fewer = Closing::new(model, selection, time);
        fewer.rows.keep(|row| independent[row]);
        fewer
    });
    for mut step in steps {
        let mut near = q.to_vec();
        // From a step without a pattern a long chain needs many back onto its rows.
        if metric == Metric::Coordinates {
            let closing = fewer.as_mut().unwrap_or(&mut closing);
            closing.gap(model, q);
            closing.keep_closed(model, &mut step);
        }
        crate::motion::displace(model, &mut near, &step);
        let first = fewer.as_mut().map(|fewer| fewer.close(model, &mut near, metric));
        let is_closed = matches!(first, Some(Ok(gap)) if gap <= CLOSED);
        if !is_closed && closing.close(model, &mut near, metric).is_err() {
            continue;
        }
        closing.gap(model, &near);
        let there = closing.rows.independent_now(model, &closing.motion);
        let rows = &closing.rows;
        for component in &components {
            let members = || component.iter().flat_map(|e| rows.elements[*e].rows.clone());
            let count = |kept: &[bool]| members().filter(|row| kept[*row]).count();
            let is_closed = || members().all(|row| rows.relative_gap(row) <= CLOSED);
            let moves = || count(&there) < velocities(model, rows, component) || is_driven(rows, component);
            if count(&there) > count(&independent) && is_closed() && moves() {
                members().for_each(|row| independent[row] = there[row]);
                singular = true;
            }
        }
    }
    Ranking { independent, singular }
}

impl Constraints {
    /// Independent rows among those solved for, as placed last: loops first, then gears, drives last.
    pub(super) fn independent_now(&mut self, model: &Model, motion: &Motion) -> Vec<bool> {
        let unknowns = self.unit_rows(model, motion);
        let rows: Vec<usize> = self.plan.rows().collect();
        let mut kept = vec![false; self.rules.len()];
        let of = components(model, &self.elements);
        let mut members = vec![Vec::new(); self.elements.len()];
        for group in &self.plan.groups {
            members[of[group.element]].extend(group.first..group.first + group.rows.len());
        }
        for members in &mut members {
            members.retain(|unknown: &usize| !unknowns[*unknown].is_empty());
            members.sort_by_key(|unknown| rows[*unknown]);
        }
        let mut column = vec![usize::MAX; model.velocity_count()];
        let classes: Vec<usize> =
            self.plan.groups.iter().flat_map(|g| g.rows.iter().map(|_| self.elements[g.element].class())).collect();
        for members in members.iter().filter(|members| !members.is_empty()) {
            // The component's own columns.
            let mut columns = 0;
            for (velocity, _) in members.iter().flat_map(|row| &unknowns[*row]) {
                if column[*velocity] == usize::MAX {
                    column[*velocity] = columns;
                    columns += 1;
                }
            }
            let own =
                |row: &usize| unknowns[*row].iter().map(|(velocity, entry)| (column[*velocity], *entry)).collect();
            let of_component = SparseRows::of(members.iter().map(own).collect());
            let classes: Vec<usize> = members.iter().map(|unknown| classes[*unknown]).collect();
            let independent = choose::independent(&of_component, &classes, columns);
            members.iter().zip(independent).for_each(|(unknown, independent)| kept[rows[*unknown]] = independent);
        }
        kept
    }

    /// Of every element the velocities of the hinges between its ends, ascending.
    pub(super) fn between_ends(&self, model: &Model) -> Vec<Vec<usize>> {
        let velocities = |link: usize| {
            let link = &model.links[link];
            link.velocity..link.velocity + link.joint.counts().1
        };
        let of = |element| {
            let mut inner: Vec<usize> = between_ends(model, element).into_iter().flat_map(velocities).collect();
            inner.sort_unstable();
            inner
        };
        self.elements.iter().map(of).collect()
    }

    /// Eq. (1): velocities and entries of every row that is solved for; none of one whose square is below [`DEPENDENT`] times
    /// that of the largest of its element, or times what its hinges could make it at most.
    fn unit_rows(&mut self, model: &Model, motion: &Motion) -> Vec<Vec<(usize, f64)>> {
        let levers = levers(model, &self.elements, &self.rules, motion);
        let (mut of_unknown, mut slides) = (Vec::new(), vec![false; model.velocity_count()]);
        self.plan.groups.iter().for_each(|group| of_unknown.extend(group.rows.iter().map(|_| group.element)));
        model.lengths().for_each(|velocity| slides[velocity] = true);
        let inner = self.between_ends(model);
        let mut entries: Vec<Vec<(usize, f64)>> = vec![Vec::new(); of_unknown.len()];
        self.gradient_over(model, motion, true, |unknown, velocity, entry| {
            // Hinges that both ends of a loop stand on carry nothing of it.
            if inner[of_unknown[unknown]].binary_search(&velocity).is_ok() {
                entries[unknown].push((velocity, entry));
            }
        });
        for group in &self.plan.groups {
            let [lever, own] = levers[group.element];
            let turns = |row: &usize| self.rules[*row].turns();
            let square = |k: usize, row: &usize, lever: f64| {
                let unit = |velocity: usize| if slides[velocity] { lever } else { 1.0 };
                let entries = entries[group.first + k].iter();
                let sum = entries.map(|(velocity, entry)| (unit(*velocity) * entry).powi(2)).sum::<f64>();
                if turns(row) { sum } else { sum / lever.powi(2) }
            };
            let squares: Vec<f64> = group.rows.iter().enumerate().map(|(k, row)| square(k, row, lever)).collect();
            let largest = squares.iter().fold(0.0, |m: f64, x| m.max(*x));
            let is_one: Vec<bool> = group
                .rows
                .iter()
                .enumerate()
                .zip(&squares)
                .map(|((k, row), of_component)| {
                    // A turn by 1 rad moves the ends by their lever at most, a thread by its pitch at least.
                    let could = match self.rules[*row] {
                        Rule::Motion { .. } => 0.0,
                        Rule::Thread { pitch, .. } => (pitch / own).powi(2).min(1.0),
                        _ => 1.0,
                    };
                    *of_component > DEPENDENT * largest && square(k, row, own) > DEPENDENT * could
                })
                .collect();
            for (k, (row, square)) in group.rows.iter().zip(&squares).enumerate() {
                let size = square.sqrt() * if turns(row) { 1.0 } else { lever };
                let entries = &mut entries[group.first + k];
                match is_one[k] {
                    true => entries
                        .iter_mut()
                        .for_each(|(velocity, entry)| *entry *= if slides[*velocity] { lever } else { 1.0 } / size),
                    false => entries.clear(),
                }
            }
        }
        entries
    }
}

impl super::RowGroup {
    /// What is chosen before what.
    fn class(&self) -> usize {
        match self.owner {
            Owner::Loop(_) => 0,
            Owner::Gear(_) => 1,
            Owner::Drive(_) => 2,
            Owner::Held(_) => 3,
        }
    }
}

/// A small step of every coordinate between the ends of loops: numbers without a pattern, the same in every run and whatever
/// else is in the scene.
fn around(model: &Model, closing: &Closing, components: &[Vec<usize>], attempt: usize) -> Vec<f64> {
    let mut step = vec![0.0; model.velocity_count()];
    let mut slides = vec![false; step.len()];
    model.lengths().for_each(|velocity| slides[velocity] = true);
    let sizes = lengths(model, &closing.rows.elements, &closing.rows.rules, &closing.motion);
    for component in components.iter().filter(|component| !component.is_empty()) {
        let reach = sizes[component[0]].reach;
        let mut random = Random(0x9e37_79b9_7f4a_7c15 ^ ((attempt as u64) << 32));
        for link in links(model, &closing.rows, component) {
            for i in link.velocity..link.velocity + link.joint.counts().1 {
                step[i] = if slides[i] { AROUND * reach } else { AROUND } * random.next();
            }
        }
    }
    step
}

/// The links between the ends of a component's elements, inner ones first.
fn links<'m>(model: &'m Model, rows: &Constraints, component: &[usize]) -> impl Iterator<Item = &'m Link> {
    let mut links: Vec<usize> = component.iter().flat_map(|e| between_ends(model, &rows.elements[*e])).collect();
    links.sort_unstable();
    links.dedup();
    links.into_iter().map(|link| &model.links[link])
}

/// How many velocities the hinges of a component have.
fn velocities(model: &Model, rows: &Constraints, component: &[usize]) -> usize {
    links(model, rows, component).map(|link| link.joint.counts().1).sum()
}

fn is_driven(rows: &Constraints, component: &[usize]) -> bool {
    component.iter().any(|e| matches!(rows.elements[*e].owner, Owner::Drive(_)))
}

/// Xorshift.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}
