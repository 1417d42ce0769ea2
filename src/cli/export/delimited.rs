//! CSV: a line of names with units, then one line per sample; every number with all its digits.

use super::super::number::exact;
use super::Sheet;
use crate::record::table::Column;
use std::fs::File;
use std::io::Write;

struct Csv<W: Write>(csv::Writer<W>);

pub(super) fn create(file: File, columns: &[Column]) -> anyhow::Result<Box<dyn Sheet>> {
    over(file, columns)
}

/// A table that goes anywhere.
pub(super) fn over<'a>(to: impl Write + 'a, columns: &[Column]) -> anyhow::Result<Box<dyn Sheet + 'a>> {
    let mut csv = csv::Writer::from_writer(to);
    csv.write_record(columns.iter().map(|column| format!("{} [{}]", column.name, column.unit)))?;
    Ok(Box::new(Csv(csv)))
}

impl<W: Write> Sheet for Csv<W> {
    fn row(&mut self, time: f64, numbers: &mut dyn Iterator<Item = f64>) -> anyhow::Result<()> {
        for number in std::iter::once(time).chain(numbers) {
            self.0.write_field(exact(number))?;
        }
        Ok(self.0.write_record(None::<&[u8]>)?)
    }

    fn finish(mut self: Box<Self>) -> anyhow::Result<()> {
        Ok(self.0.flush()?)
    }
}
