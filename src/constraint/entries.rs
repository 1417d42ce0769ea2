//! The entries of rows, and the rows as sparse rows. Where their entries stand follows from the structure: it is found once, and filled in at every position.

use super::{Constraints, Rule, clear_interfaces};
use crate::element::modal::MOST_MODAL_COORDINATES;
use crate::model::{Link, Model};
use crate::motion::Motion;
use crate::sparse::SparseRows;
use crate::spatial::Wrench;

/// Of an entry of a hinge that both ends of a loop stand on: it carries nothing of the loop.
const OUTSIDE: usize = usize::MAX;

/// Where the entries of the rows solved for stand.
#[derive(Debug)]
pub(super) struct Entries {
    /// Where each row begins, and where the last one ends.
    starts: Vec<usize>,
    /// Velocity coordinates of the entries, of each row ascending.
    columns: Vec<usize>,
    /// The entry of each number in the order in which [`Constraints::gradient_over`] puts them, or [`OUTSIDE`].
    places: Vec<usize>,
}

impl Constraints {
    /// The entries of `G` for the rows solved for, as placed last: `put(unknown, velocity, entry)`.
    pub(crate) fn gradient(&mut self, model: &Model, motion: &Motion, put: impl FnMut(usize, usize, f64)) {
        self.gradient_over(model, motion, false, put);
    }

    /// The entries of `G` of the hinges between the ends of loops at least; if not `inner`, of all hinges below them: those
    /// that both ends of a loop stand on carry nothing of it.
    pub(super) fn gradient_over(
        &mut self,
        model: &Model,
        motion: &Motion,
        inner: bool,
        mut put: impl FnMut(usize, usize, f64),
    ) {
        let Self { plan, elements, rules, placed, passed, ways, .. } = self;
        // Which links carry the interfaces of a modal body is not looked at here.
        let inner = inner && model.modals.is_empty();
        for group in &plan.groups {
            let (element, way) = (&elements[group.element], &ways[group.element]);
            // A way begins with both branches.
            let way = if inner { &way[..element.branches.iter().map(Vec::len).sum()] } else { way };
            for (k, row) in group.rows.iter().enumerate() {
                let unknown = group.first + k;
                if let Rule::Motion { parts } = &rules[*row] {
                    parts.iter().filter(|part| part.1 != 0.0).for_each(|(s, factor)| put(unknown, s.velocity, *factor));
                    continue;
                }
                way.iter().for_each(|link| passed[*link] = Wrench::ZERO);
                if let Some(ends) = &element.ends {
                    ends.iter().zip(placed[*row].wrenches).for_each(|(end, wrench)| passed[end.link] += wrench);
                }
                for link in way {
                    let (given, at, w) = (&model.links[*link], &motion.links[*link], passed[*link]);
                    let put = |velocity: usize, value: f64| put(unknown, velocity, value);
                    match given.joint.modal() {
                        Some(modal) => project_modal(model, motion, (modal, given), passed, put),
                        // What interfaces pass on is projected at the frame, once for all of them.
                        None if given.joint.interface().is_some() => {}
                        None => crate::motion::project(motion, given, *link, &w, put),
                    }
                    passed[given.parent] += w.shifted(at.arm);
                }
                clear_interfaces(model, way, passed);
            }
        }
    }

    /// The rows solved for, as placed last, without the hinges that both ends of a loop stand on.
    pub(crate) fn sparse_rows(&mut self, model: &Model, motion: &Motion) -> SparseRows {
        // Which entries a modal body has follows from its position.
        let known = if model.modals.is_empty() { self.entries.take() } else { None };
        let known = known.unwrap_or_else(|| std::sync::Arc::new(self.find_entries(model, motion)));
        let (mut values, mut next) = (vec![0.0; known.columns.len()], 0);
        self.gradient_over(model, motion, true, |_, _, entry| {
            if let Some(sum) = values.get_mut(known.places[next]) {
                *sum += entry;
            }
            next += 1;
        });
        let rows = SparseRows { starts: known.starts.clone(), columns: known.columns.clone(), values };
        self.entries = Some(known);
        rows
    }

    fn find_entries(&mut self, model: &Model, motion: &Motion) -> Entries {
        let inner = self.between_ends(model);
        let of_row: Vec<usize> = self.plan.groups.iter().flat_map(|g| g.rows.iter().map(|_| g.element)).collect();
        let mut put = Vec::new();
        self.gradient_over(model, motion, true, |row, velocity, _| put.push((row, velocity)));
        let is_inner = |row: usize, velocity: usize| inner[of_row[row]].binary_search(&velocity).is_ok();
        let mut rows = vec![Vec::new(); of_row.len()];
        put.iter().filter(|(row, velocity)| is_inner(*row, *velocity)).for_each(|(row, v)| rows[*row].push(*v));
        let (mut starts, mut columns) = (vec![0], Vec::new());
        for row in &mut rows {
            row.sort_unstable();
            row.dedup();
            columns.extend_from_slice(row);
            starts.push(columns.len());
        }
        let place = |(row, velocity): (usize, usize)| match rows[row].binary_search(&velocity) {
            Ok(place) => starts[row] + place,
            Err(_) => OUTSIDE,
        };
        let places = put.into_iter().map(place).collect();
        Entries { starts, columns, places }
    }
}

/// What wrenches on the interfaces of a modal body do in its coordinates.
fn project_modal(
    model: &Model,
    motion: &Motion,
    (modal, link): (usize, &Link),
    passed: &[Wrench],
    mut put: impl FnMut(usize, f64),
) {
    let (body, mut rows) = (&model.modals[modal], [0.0; MOST_MODAL_COORDINATES]);
    motion.modals[modal].pull(body.links.iter().map(|link| &passed[*link]), &mut rows);
    let rows = rows.iter().enumerate().take(body.modal.count());
    rows.filter(|(_, row)| **row != 0.0).for_each(|(i, row)| put(link.velocity + i, *row));
}
