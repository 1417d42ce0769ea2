//! Measured tables: columns of numbers with names, in SI units.

use crate::model::problem::counted;
use crate::quantity::{Dimension, Quantity};

/// A measured column.
#[derive(Debug, Clone, PartialEq)]
pub struct DataColumn {
    /// As in the heading, without the unit.
    pub name: String,
    /// What the unit measures, if the heading has one; the numbers are in SI units and radians.
    pub dimension: Option<Dimension>,
    /// One number a row, in SI units; `NaN` where nothing was measured.
    pub values: Vec<f64>,
}

/// What was measured, row by row.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MeasuredTable {
    /// Columns of one length.
    pub columns: Vec<DataColumn>,
}

impl MeasuredTable {
    /// A table of headings and columns. A heading is a name, or a name with a unit as in `travel [mm]`: its numbers become SI units
    /// then. `NaN` is a cell in which nothing was measured.
    ///
    /// # Errors
    /// A name that stands there twice, a unit that is not known, columns of different lengths, a number that is infinite.
    pub fn new(columns: Vec<(String, Vec<f64>)>) -> Result<Self, String> {
        let rows = columns.first().map_or(0, |(_, values)| values.len());
        if rows == 0 {
            return Err("there are no rows of measurements".to_owned());
        }
        let mut table = Self::default();
        for (heading, mut values) in columns {
            let (name, unit) = split(&heading);
            if values.len() != rows {
                return Err(format!("`{name}` has {}, the first column {rows}", counted(values.len(), "row", "rows")));
            }
            if let Some(row) = values.iter().position(|x| x.is_infinite()) {
                return Err(format!("`{name}` is infinite in row {}", row + 1));
            }
            if table.columns.iter().any(|other| other.name == name) {
                return Err(format!("two columns are called `{name}`"));
            }
            let mut dimension = None;
            if let Some(unit) = unit.filter(|unit| !matches!(*unit, "" | "1" | "-")) {
                let one = Quantity::parse(&format!("1 {unit}"))
                    .map_err(|why| format!("the heading `{heading}` has no unit that is known: {why}"))?;
                values.iter_mut().for_each(|x| *x *= one.value);
                dimension = Some(one.dimension);
            }
            table.columns.push(DataColumn { name: name.to_owned(), dimension, values });
        }
        Ok(table)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }
}

/// `travel [mm]` → `travel` and `mm`; `tip[2]` is a name.
fn split(heading: &str) -> (&str, Option<&str>) {
    let heading = heading.trim();
    match heading.strip_suffix(']').and_then(|rest| rest.rsplit_once(" [")) {
        Some((name, unit)) => (name.trim_end(), Some(unit.trim())),
        None => (heading, None),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_headings_become_si_units() {
        let columns = vec![("travel [mm]".to_owned(), vec![1.0, f64::NAN]), ("tip[2]".to_owned(), vec![2.0, 3.0])];
        let table = MeasuredTable::new(columns).expect("a table");
        assert_eq!(table.columns[0].name, "travel");
        assert_eq!(table.columns[0].values[0], 1e-3);
        assert_eq!((table.columns[1].name.as_str(), table.columns[1].dimension), ("tip[2]", None));
        let wrong = MeasuredTable::new(vec![("travel [mn]".to_owned(), vec![1.0])]).expect_err("no unit");
        assert!(wrong.contains("travel [mn]"), "{wrong}");
    }
}
