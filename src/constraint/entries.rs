//! The rows as sparse rows. Where their entries stand follows from the structure: it is found once, and filled in at every position.

use super::Constraints;
use crate::model::Model;
use crate::motion::Motion;
use crate::sparse::SparseRows;

/// Of an entry of a hinge that both ends of a loop stand on: it carries nothing of the loop.
const OUTSIDE: usize = usize::MAX;

/// Where the entries of the rows solved for stand.
#[derive(Debug)]
pub(super) struct Entries {
    /// Where each row begins, and where the last one ends.
    starts: Vec<usize>,
    /// Velocity coordinates of the entries, of each row ascending.
    columns: Vec<usize>,
    /// The entry of each number in the order in which [`Constraints::gradient`] puts them, or [`OUTSIDE`].
    places: Vec<usize>,
}

impl Constraints {
    /// The rows solved for, as placed last, without the hinges that both ends of a loop stand on.
    pub(crate) fn sparse_rows(&mut self, model: &Model, motion: &Motion) -> SparseRows {
        // Which entries a modal body has follows from its position.
        let known = if model.modals.is_empty() { self.entries.take() } else { None };
        let known = known.unwrap_or_else(|| std::sync::Arc::new(self.find_entries(model, motion)));
        let (mut values, mut next) = (vec![0.0; known.columns.len()], 0);
        self.gradient(model, motion, |_, _, entry| {
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
        self.gradient(model, motion, |row, velocity, _| put.push((row, velocity)));
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
