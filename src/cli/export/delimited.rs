//! CSV: a line of names with units, then one line per sample; every number with all its digits.

use super::Sheet;
use crate::record::table::Column;
use std::fs::File;

struct Csv(csv::Writer<File>);

pub(super) fn create(file: File, columns: &[Column]) -> anyhow::Result<Box<dyn Sheet>> {
    let mut csv = csv::Writer::from_writer(file);
    csv.write_record(columns.iter().map(|column| format!("{} [{}]", column.name, column.unit)))?;
    Ok(Box::new(Csv(csv)))
}

impl Sheet for Csv {
    fn row(&mut self, time: f64, numbers: &mut dyn Iterator<Item = f64>) -> anyhow::Result<()> {
        // The shortest digits that give the same number back, with an exponent where it is shorter.
        for number in std::iter::once(time).chain(numbers) {
            self.0.write_field(format!("{number:?}"))?;
        }
        Ok(self.0.write_record(None::<&[u8]>)?)
    }

    fn finish(mut self: Box<Self>) -> anyhow::Result<()> {
        self.0.flush()?;
        Ok(self.0.get_ref().sync_all()?)
    }
}
