//! What contacts push with as a table: for every two bodies that ever press on each other the sum over their points.

use super::table::Column;
use super::{ContactPush, RecordError, Recording, Table};
use std::collections::HashMap;
use std::sync::Arc;

/// Ends of the names of the columns of two bodies.
const ENDS: [(&str, &str); 5] =
    [("force.x", "N"), ("force.y", "N"), ("force.z", "N"), ("points", "1"), ("slipping", "1")];

/// The table `contacts`, and its rows: one a sample.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactTable {
    /// Columns `crate on floor.force.x` … `.z` (the sum on the crate, inertial axes), `.points` and `.slipping` (how many points there
    /// are, and how many of them slip), in the order in which pairs first touch.
    pub table: Table,
    /// In the order of the samples.
    pub rows: Vec<Vec<f64>>,
}

impl ContactTable {
    /// Of a recording; `None` if its scene has no contact.
    ///
    /// # Errors
    /// If the recording cannot be read.
    pub fn of(recording: &Recording) -> Result<Option<Self>, RecordError> {
        let instants = recording.contacts()?;
        Ok((!instants.is_empty()).then(|| Self::new(&instants)))
    }

    fn new(instants: &[(f64, Arc<Vec<ContactPush>>)]) -> Self {
        let mut known: HashMap<&[String; 2], usize> = HashMap::new();
        let mut pairs = Vec::new();
        for push in instants.iter().flat_map(|(_, pushes)| pushes.iter()) {
            known.entry(&push.between).or_insert_with(|| {
                pairs.push(&push.between);
                pairs.len() - 1
            });
        }
        let column = |pair: &[String; 2]| {
            let [one, other] = pair.clone();
            ENDS.map(|(end, unit)| Column { name: format!("{other} on {one}.{end}"), unit: unit.to_owned() })
        };
        let columns = pairs.iter().flat_map(|pair| column(pair)).collect();
        let row = |(_, pushes): &(f64, Arc<Vec<ContactPush>>)| {
            let mut row = vec![0.0; ENDS.len() * pairs.len()];
            for push in pushes.iter() {
                let first = ENDS.len() * known[&push.between];
                (0..3).for_each(|i| row[first + i] += push.force[i]);
                row[first + 3] += 1.0;
                row[first + 4] += f64::from(u8::from(push.slips));
            }
            row
        };
        Self { table: Table { name: "contacts", columns }, rows: instants.iter().map(row).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_of_a_pair_are_summed_and_pairs_keep_their_columns() {
        let push = |between: [&str; 2], z: f64, slips: bool| ContactPush {
            between: between.map(str::to_owned),
            point: [0.0; 3],
            normal: [0.0, 0.0, 1.0],
            force: [0.25 * z, 0.0, z],
            slips,
        };
        let first = vec![push(["floor", "box"], 3.0, true), push(["floor", "box"], 5.0, false)];
        let instants = [(0.0, first), (0.5, Vec::new()), (1.0, vec![push(["box", "ball"], 2.0, false)])]
            .map(|(time, pushes)| (time, Arc::new(pushes)));
        let found = ContactTable::new(&instants);
        let names: Vec<&str> = found.table.columns.iter().map(|column| column.name.as_str()).collect();
        assert_eq!((names[2], names[5], names.len()), ("box on floor.force.z", "ball on box.force.x", 10));
        assert_eq!(found.rows[0], [2.0, 0.0, 8.0, 2.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
        assert_eq!(found.rows[1], [0.0; 10]);
        assert_eq!(found.rows[2][5..], [0.5, 0.0, 2.0, 1.0, 0.0]);
    }
}
