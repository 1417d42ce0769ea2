//! The samples of a run as columns.

use stillpoint::record::{Outcome, RecordError, Recorder, Sample, Scene, Table};

/// Every column of every table of a recording, beside the time.
pub(crate) struct Columns {
    tables: Vec<Table>,
    row: Vec<f64>,
    pub(crate) time: Vec<f64>,
    pub(crate) columns: Vec<Vec<f64>>,
}

impl Columns {
    /// Room for as many samples; `None` if there is no such memory.
    pub(crate) fn new(scene: &Scene, samples: usize) -> Option<Self> {
        let tables = Table::all(scene);
        let count = tables.iter().map(|table| table.columns.len()).sum();
        let room = || {
            let mut column = Vec::new();
            column.try_reserve_exact(samples).ok().map(|()| column)
        };
        let columns = (0..count).map(|_| room()).collect::<Option<_>>()?;
        Some(Self { tables, row: Vec::new(), time: room()?, columns })
    }

    /// Names and units in the order of the columns.
    pub(crate) fn names(&self) -> Vec<(String, String)> {
        let columns = self.tables.iter().flat_map(|table| &table.columns);
        columns.map(|column| (column.name.clone(), column.unit.clone())).collect()
    }
}

impl Recorder for Columns {
    fn sample(&mut self, sample: &Sample) -> Result<(), RecordError> {
        let owned = sample.to_owned();
        self.time.push(sample.time);
        let mut columns = self.columns.iter_mut();
        for table in &self.tables {
            table.fill(&owned, &mut self.row);
            self.row.iter().zip(&mut columns).for_each(|(number, column)| column.push(*number));
        }
        Ok(())
    }

    fn finish(&mut self, _outcome: &Outcome) -> Result<(), RecordError> {
        Ok(())
    }
}
