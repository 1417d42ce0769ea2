//! Rows as Parquet: a column of its own type for each column, its unit in the metadata of the field.

use super::case::Row;
use super::column::{Cell, Column, Kind};
use crate::foreign;
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
use std::io::Read;
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

/// Key of the SHA-256 of a file, with zeros for these digits of it, in its metadata: Parquet's own checksums of pages are not written by the
/// library. Metadata are not compressed, and this is their last pair: it is found without reading the file as Parquet, which damaged bytes
/// may send anywhere.
const SUM: &[u8] = b"whole_sha256";
/// Between a key and its value stand the kind and the length of a string.
const HEAD: usize = 2;
const DIGITS: usize = 64;

/// Key of how a file is written: by it, one whose sum is not found any more is damaged. Files of earlier versions have neither.
const FORMAT: &str = "format";

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
    /// Refuses a file that says of itself that it comes from elsewhere; whether it says all that is asked of a part.
    ///
    /// # Errors
    /// Where it comes from.
    pub fn check(&self, told: &Told) -> Result<bool, String> {
        let Some(said) = &told.origin else { return Ok(false) };
        if said == self {
            return Ok(told.is_summed);
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
    /// Whether it has a sum of its bytes, which is right then; parts of earlier versions have none.
    pub is_summed: bool,
}

/// The bytes of a file of these rows.
///
/// # Errors
/// If columns and rows do not fit together.
pub fn encoded(columns: &[Column], rows: &[Row], origin: &Origin) -> Result<Vec<u8>, ParquetError> {
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
    let said = [(FAILED, failed.to_string()), (STUDY, origin.study.clone()), (CASES, cases), (FORMAT, "2".to_owned())];
    let said = said.into_iter().map(|(key, value)| KeyValue::new(key.to_owned(), value));
    let mut properties = properties().set_key_value_metadata(Some(said.collect()));
    for column in columns.iter().filter(|column| column.kind == Kind::Word) {
        properties = properties.set_column_dictionary_enabled(ColumnPath::new(vec![column.name.clone()]), true);
    }
    let mut writer = ArrowWriter::try_new(Vec::new(), schema.clone(), Some(properties.build()))?;
    let arrays = columns.iter().enumerate().map(|(index, column)| array(column.kind, index, rows)).collect();
    writer.write(&RecordBatch::try_new(schema, arrays)?)?;
    writer.append_key_value_metadata(KeyValue::new(String::from_utf8_lossy(SUM).into_owned(), "0".repeat(DIGITS)));
    let mut bytes = writer.into_inner()?;
    let digits = digits(&bytes).ok_or_else(|| ParquetError::General("it has no place for a sum".to_owned()))?;
    let sum = sum(&bytes, &digits);
    bytes[digits].copy_from_slice(sum.as_bytes());
    Ok(bytes)
}

/// Where the digits of the sum are.
fn digits(bytes: &[u8]) -> Option<Range<usize>> {
    let begin = bytes.windows(SUM.len()).rposition(|window| window == SUM)? + SUM.len() + HEAD;
    (begin + DIGITS <= bytes.len()).then_some(begin..begin + DIGITS)
}

/// The sum of a file whose digits of it are there.
fn sum(bytes: &[u8], digits: &Range<usize>) -> String {
    let mut sum = Sha256::new();
    for part in [&bytes[..digits.start], &[b'0'; DIGITS], &bytes[digits.end..]] {
        sum.update(part);
    }
    sum.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// What a file says of itself, if its bytes are those that were written. Files of earlier versions do not say which these are.
///
/// # Errors
/// If it is no Parquet file, or its bytes are others.
pub fn told(mut file: File) -> Result<Told, ParquetError> {
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes)?;
    let others = || ParquetError::General("its bytes are not those that were written".to_owned());
    let digits = digits(&bytes);
    if digits.as_ref().is_some_and(|digits| bytes[digits.clone()] != *sum(&bytes, digits).as_bytes()) {
        return Err(others());
    }
    let reader = guarded(|| SerializedFileReader::new(file))?;
    let metadata = reader.metadata().file_metadata();
    if digits.is_none() && value(metadata, FORMAT).is_some() {
        return Err(others());
    }
    Ok(Told {
        rows: u64::try_from(metadata.num_rows()).unwrap_or(0),
        failed: value(metadata, FAILED).and_then(|text| text.parse().ok()),
        origin: Origin::of(metadata),
        is_summed: digits.is_some(),
    })
}

/// Reads Parquet: of files without a sum nobody knows what is in them.
///
/// # Errors
/// Those of the reader, and its panics.
pub fn guarded<T, E>(read: impl FnOnce() -> Result<T, E>) -> Result<T, ParquetError>
where
    ParquetError: From<E>,
{
    Ok(foreign::parse("the reader of Parquet", read).map_err(ParquetError::General)??)
}

fn value<'m>(metadata: &'m FileMetaData, key: &str) -> Option<&'m str> {
    metadata.key_value_metadata().into_iter().flatten().find(|pair| pair.key == key)?.value.as_deref()
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
