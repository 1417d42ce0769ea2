//! Parquet: one column of doubles per number, its unit in the metadata of the field.

use super::Sheet;
use crate::record::table::Column;
use crate::study::parquet::properties;
use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use std::fs::File;
use std::sync::Arc;

/// Numbers that are held before they are written (8 MiB).
const HELD: usize = 1 << 20;

struct Parquet {
    writer: ArrowWriter<File>,
    schema: Arc<Schema>,
    columns: Vec<Vec<f64>>,
    /// Rows that are held at most.
    most: usize,
}

pub(super) fn create(file: File, columns: &[Column]) -> anyhow::Result<Box<dyn Sheet>> {
    let field = |column: &Column| {
        let unit = [("unit".to_owned(), column.unit.clone())];
        Field::new(&column.name, DataType::Float64, false).with_metadata(unit.into())
    };
    let schema = Arc::new(Schema::new(columns.iter().map(field).collect::<Vec<_>>()));
    let writer = ArrowWriter::try_new(file, schema.clone(), Some(properties().build()))?;
    let most = (HELD / columns.len()).max(1);
    Ok(Box::new(Parquet { writer, schema, columns: vec![Vec::new(); columns.len()], most }))
}

impl Parquet {
    fn write(&mut self) -> anyhow::Result<()> {
        let take = |column: &mut Vec<f64>| Arc::new(Float64Array::from(std::mem::take(column))) as ArrayRef;
        let arrays = self.columns.iter_mut().map(take).collect();
        self.writer.write(&RecordBatch::try_new(self.schema.clone(), arrays)?)?;
        // A group of rows of its own: the writer holds no more than one.
        Ok(self.writer.flush()?)
    }
}

impl Sheet for Parquet {
    fn row(&mut self, time: f64, numbers: &mut dyn Iterator<Item = f64>) -> anyhow::Result<()> {
        for (column, number) in self.columns.iter_mut().zip(std::iter::once(time).chain(numbers)) {
            column.push(number);
        }
        if self.columns[0].len() >= self.most { self.write() } else { Ok(()) }
    }

    fn finish(mut self: Box<Self>) -> anyhow::Result<()> {
        if !self.columns[0].is_empty() {
            self.write()?;
        }
        Ok(self.writer.into_inner()?.sync_all()?)
    }
}
