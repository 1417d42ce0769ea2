//! Rows as Parquet: a column of its own type for each column, its unit in the metadata of the field.

use super::case::Row;
use super::column::{Cell, Column, Kind};
use arrow_array::{ArrayRef, BooleanArray, Float64Array, Int64Array, RecordBatch, StringArray};
use arrow_schema::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::basic::{Compression, ZstdLevel};
use parquet::errors::ParquetError;
use parquet::file::metadata::{FileMetaData, KeyValue};
use parquet::file::properties::{WriterProperties, WriterPropertiesBuilder};
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::schema::types::ColumnPath;
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{self, Read, Seek, Write};
use std::ops::Range;
use std::sync::Arc;

/// How files of numbers that hardly ever repeat are written.
pub fn properties() -> WriterPropertiesBuilder {
    WriterProperties::builder()
        .set_compression(Compression::ZSTD(ZstdLevel::default()))
        .set_dictionary_enabled(false)
        .set_created_by(concat!("stillpoint ", env!("CARGO_PKG_VERSION")).to_owned())
}

/// Key of the number of failed cases in the metadata of a file.
const FAILED: &str = "failed";

/// Key of the number of bytes before the metadata, and of their SHA-256, in the metadata of a file: Parquet's own checksums of pages are
/// not written by the library.
const SUM: &str = "sha256";

/// Keys of the study that a file belongs to, and of its cases.
const STUDY: &str = "study";
const CASES: &str = "cases";

/// Where the rows of a file come from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Origin {
    /// The hash of the study.
    pub study: String,
    /// Which of its cases.
    pub cases: Range<u64>,
}

impl Origin {
    /// Refuses a file that says of itself that it comes from elsewhere; whether it says anything.
    ///
    /// # Errors
    /// Where it comes from.
    pub fn check(&self, said: Option<&Self>) -> Result<bool, String> {
        let Some(said) = said else { return Ok(false) };
        if said == self {
            return Ok(true);
        }
        let of = |one: &Self| format!("cases {} to {}", one.cases.start, one.cases.end.saturating_sub(1));
        let short = |one: &Self| one.study.chars().take(12).collect::<String>();
        Err(match said.study == self.study {
            true => format!("it has {} of this study, not {}", of(said), of(self)),
            false => {
                format!("it has {} of another study (hash {}, this one has {})", of(said), short(said), short(self))
            }
        })
    }

    /// What a file says.
    fn of(metadata: &FileMetaData) -> Option<Self> {
        let (first, last) = value(metadata, CASES)?.split_once("..")?;
        let cases = first.parse().ok()?..last.parse().ok()?;
        Some(Self { study: value(metadata, STUDY)?.to_owned(), cases })
    }
}

/// What a file says of itself.
#[derive(Debug)]
pub struct Told {
    /// Number of rows.
    pub rows: u64,
    /// How many of its cases failed; `None` if it is no part of a study.
    pub failed: Option<u64>,
    /// Where it comes from; parts of earlier versions do not say.
    pub origin: Option<Origin>,
}

/// A file, and the hash of what has been written to it.
struct Summed<W> {
    file: W,
    sum: Sha256,
    bytes: u64,
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        let count = self.file.write(buffer)?;
        self.sum.update(&buffer[..count]);
        self.bytes += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Writes rows as one file.
///
/// # Errors
/// If it cannot be written.
pub fn write(file: impl Write + Send, columns: &[Column], rows: &[Row], origin: &Origin) -> Result<(), ParquetError> {
    let field = |column: &Column| {
        let field = Field::new(&column.name, data_type(column.kind), true);
        match column.unit.as_ref() {
            "" => field,
            unit => field.with_metadata([("unit".to_owned(), unit.to_owned())].into()),
        }
    };
    let schema = Arc::new(Schema::new(columns.iter().map(field).collect::<Vec<_>>()));
    let failed = rows.iter().filter(|row| row.error.is_some()).count();
    let cases = format!("{}..{}", origin.cases.start, origin.cases.end);
    let said = [(FAILED, failed.to_string()), (STUDY, origin.study.clone()), (CASES, cases)];
    let said = said.into_iter().map(|(key, value)| KeyValue::new(key.to_owned(), value));
    let mut properties = properties().set_key_value_metadata(Some(said.collect()));
    for column in columns.iter().filter(|column| column.kind == Kind::Word) {
        properties = properties.set_column_dictionary_enabled(ColumnPath::new(vec![column.name.clone()]), true);
    }
    let file = Summed { file, sum: Sha256::new(), bytes: 0 };
    let mut writer = ArrowWriter::try_new(file, schema.clone(), Some(properties.build()))?;
    let arrays = columns.iter().enumerate().map(|(index, column)| array(column.kind, index, rows)).collect();
    writer.write(&RecordBatch::try_new(schema, arrays)?)?;
    writer.flush()?;
    writer.sync()?;
    let Summed { sum, bytes, .. } = writer.inner();
    let sum = format!("{bytes} {}", hex(sum.clone()));
    writer.append_key_value_metadata(KeyValue::new(SUM.to_owned(), sum));
    writer.into_inner()?.flush()?;
    Ok(())
}

fn hex(sum: Sha256) -> String {
    sum.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// What a file says of itself. With `sums` its bytes have to be those that were written, if it says which: parts of earlier versions do
/// not.
///
/// # Errors
/// If it is no Parquet file, or its bytes are others.
pub fn told(file: File, sums: bool) -> Result<Told, ParquetError> {
    let reader = SerializedFileReader::new(file.try_clone()?)?;
    let metadata = reader.metadata().file_metadata();
    if let Some(sum) = value(metadata, SUM).filter(|_| sums) {
        check_sum(file, sum)?;
    }
    Ok(Told {
        rows: u64::try_from(metadata.num_rows()).unwrap_or(0),
        failed: value(metadata, FAILED).and_then(|text| text.parse().ok()),
        origin: Origin::of(metadata),
    })
}

fn value<'m>(metadata: &'m FileMetaData, key: &str) -> Option<&'m str> {
    metadata.key_value_metadata().into_iter().flatten().find(|pair| pair.key == key)?.value.as_deref()
}

/// Refuses a file whose first bytes have another sum than it says.
fn check_sum(mut file: File, said: &str) -> Result<(), ParquetError> {
    let bytes = said.split_once(' ').and_then(|(bytes, _)| bytes.parse().ok()).unwrap_or(u64::MAX);
    file.rewind()?;
    let mut found = Summed { file: io::sink(), sum: Sha256::new(), bytes: 0 };
    io::copy(&mut file.take(bytes), &mut found)?;
    let Summed { sum, bytes, .. } = found;
    match said == format!("{bytes} {}", hex(sum)) {
        true => Ok(()),
        false => Err(ParquetError::General("its bytes are not those that were written".to_owned())),
    }
}

fn data_type(kind: Kind) -> DataType {
    match kind {
        Kind::Number => DataType::Float64,
        Kind::Whole => DataType::Int64,
        Kind::Word => DataType::Utf8,
        Kind::Flag => DataType::Boolean,
    }
}

fn array(kind: Kind, index: usize, rows: &[Row]) -> ArrayRef {
    let cells = rows.iter().map(|row| &row.cells[index]);
    match kind {
        Kind::Number => Arc::new(Float64Array::from_iter(cells.map(|cell| match cell {
            Cell::Number(number) => Some(*number),
            _ => None,
        }))),
        Kind::Whole => Arc::new(Int64Array::from_iter(cells.map(|cell| match cell {
            Cell::Whole(number) => Some(*number),
            _ => None,
        }))),
        Kind::Word => Arc::new(StringArray::from_iter(cells.map(|cell| match cell {
            Cell::Word(word) => Some(word.as_ref()),
            _ => None,
        }))),
        Kind::Flag => Arc::new(BooleanArray::from_iter(cells.map(|cell| match cell {
            Cell::Flag(flag) => Some(*flag),
            _ => None,
        }))),
    }
}
