//! Reading the columns of a dataset, part by part: nothing is kept.

use super::dataset::{self, MANIFEST};
use super::parquet::{self as part, Origin};
use super::sample::Sampling;
use super::variance::Spread;
use arrow_array::cast::AsArray;
use arrow_array::types::{Float64Type, Int64Type};
use arrow_array::{Array, ArrayRef, BooleanArray};
use arrow_schema::DataType;
use parquet::arrow::ProjectionMask;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use serde_json::Value;
use std::collections::HashMap;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

/// A dataset that is read.
#[derive(Debug)]
pub struct Reader {
    parts: Vec<PathBuf>,
    /// Cases that its plan asks for.
    pub cases: u64,
    /// What its plan varies.
    pub inputs: Vec<String>,
    /// How evenly its plan spreads the inputs.
    pub spread: Spread,
    /// Names and units of its columns of numbers, in order.
    pub numbers: Vec<(String, String)>,
    /// The words of those of its inputs that are no numbers.
    pub words: Vec<Words>,
    /// How many of its parts do not say which study they belong to or have no sum: those of earlier versions.
    pub silent: usize,
}

/// The words that a column holds.
#[derive(Debug)]
pub struct Words {
    /// The column.
    pub name: String,
    /// In the order in which they first appear.
    pub all: Vec<String>,
    places: HashMap<String, usize>,
}

impl Words {
    fn of(name: &str) -> Self {
        Self { name: name.to_owned(), all: Vec::new(), places: HashMap::new() }
    }

    fn add(&mut self, word: &str) {
        if !self.places.contains_key(word) {
            self.places.insert(word.to_owned(), self.all.len());
            self.all.push(word.to_owned());
        }
    }
}

impl Reader {
    /// Opens a folder.
    ///
    /// # Errors
    /// If it holds no dataset, one without any part, or a part that is damaged.
    pub fn open(folder: &Path) -> Result<Self, String> {
        let path = folder.join(MANIFEST);
        let text = fs::read_to_string(&path).map_err(|error| {
            format!("`{}` is no dataset of a study: `{}`: {error}", folder.display(), path.display())
        })?;
        let manifest: Value =
            serde_json::from_str(&text).map_err(|error| format!("`{}` is no manifest: {error}", path.display()))?;
        let texts = |value: &Value| value.as_array().cloned().unwrap_or_default();
        let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        let is_number = |column: &&Value| matches!(column["kind"].as_str(), Some("number" | "whole"));
        let columns = texts(&manifest["columns"]);
        let parts = dataset::files(folder).map_err(|error| format!("`{}`: {error}", folder.display()))?;
        if parts.is_empty() {
            return Err(format!("`{}` has no part yet", folder.display()));
        }
        let silent = check(&parts, &manifest)?;
        let inputs: Vec<String> = texts(&manifest["inputs"]).iter().map(text).collect();
        let are_words = columns.iter().filter(|column| column["kind"] == "word").map(|column| text(&column["name"]));
        let of_words: Vec<String> = are_words.filter(|name| inputs.contains(name)).collect();
        let mut reader = Self {
            parts,
            cases: manifest["cases"].as_u64().unwrap_or_default(),
            inputs,
            spread: match manifest["sample"].as_str() {
                Some(name) if name == Sampling::Sobol.name() => Spread::Even,
                _ => Spread::Chance,
            },
            numbers: columns.iter().filter(is_number).map(|one| (text(&one["name"]), text(&one["unit"]))).collect(),
            words: Vec::new(),
            silent,
        };
        for name in of_words {
            let mut words = Words::of(&name);
            reader.batches(&[&name], &mut |_, columns| {
                columns[0].as_string_opt::<i32>().into_iter().flatten().flatten().for_each(|word| words.add(word));
            })?;
            reader.words.push(words);
        }
        Ok(reader)
    }

    /// Hands over these columns of every row: whether the case was answered, and its numbers, NaN for an empty cell; of an input of
    /// words the place of the word in [`Words::all`].
    ///
    /// # Errors
    /// If a part cannot be read, or has no such column.
    pub fn each(&self, columns: &[&str], take: &mut dyn FnMut(bool, &[f64])) -> Result<(), String> {
        let mut row = vec![0.0; columns.len()];
        let words: Vec<Option<&Words>> =
            columns.iter().map(|name| self.words.iter().find(|words| words.name == *name)).collect();
        self.batches(columns, &mut |ok, found| {
            let numbers = found.iter().zip(&words).map(|(column, words)| match words {
                Some(words) => places(column, words),
                None => doubles(column),
            });
            let numbers: Vec<Vec<f64>> = numbers.collect();
            for index in 0..ok.len() {
                for (cell, numbers) in row.iter_mut().zip(&numbers) {
                    *cell = numbers[index];
                }
                take(ok.value(index), &row);
            }
        })
    }

    /// Hands over these columns batch by batch, after whether the cases were answered.
    fn batches(&self, columns: &[&str], take: &mut dyn FnMut(&BooleanArray, &[ArrayRef])) -> Result<(), String> {
        for path in &self.parts {
            let failed = |error: &dyn std::fmt::Display| format!("`{}`: {error}", path.display());
            let file = File::open(path).map_err(|error| failed(&error))?;
            let damaged = |error: &dyn std::fmt::Display| damaged(path, error);
            let builder = part::guarded(|| ParquetRecordBatchReaderBuilder::try_new(file));
            let builder = builder.map_err(|error| damaged(&error))?;
            let place = |name: &str| {
                let fields = builder.schema().fields();
                let place = fields.iter().position(|field| field.name() == name);
                place.ok_or_else(|| failed(&format!("there is no column `{name}`")))
            };
            let places = ["ok"].iter().chain(columns).map(|name| place(name)).collect::<Result<Vec<_>, _>>()?;
            let mask = ProjectionMask::roots(builder.parquet_schema(), places.iter().copied());
            let mut reader = builder.with_projection(mask).build().map_err(|error| failed(&error))?;
            while let Some(batch) = part::guarded(|| reader.next().transpose()).map_err(|error| damaged(&error))? {
                let column = |name: &str| {
                    let found = batch.column_by_name(name);
                    found.cloned().ok_or_else(|| failed(&format!("there is no column `{name}`")))
                };
                let ok = column("ok")?;
                let ok = ok.as_boolean_opt().ok_or_else(|| failed(&"`ok` is not yes or no"))?;
                take(ok, &columns.iter().map(|name| column(name)).collect::<Result<Vec<_>, _>>()?);
            }
        }
        Ok(())
    }
}

/// Refuses parts that are damaged, that belong to another study, and that have other cases than their names say; how many do not say what
/// they are.
fn check(parts: &[PathBuf], manifest: &Value) -> Result<usize, String> {
    let study = manifest["hash"].as_str().unwrap_or_default();
    let [rows, cases] = ["rows_per_part", "cases"].map(|key| manifest[key].as_u64().unwrap_or_default().max(1));
    let mut silent = 0;
    for path in parts {
        let stray = |why: &str| format!("`{}` is no part of this dataset: {why}; move it away", path.display());
        let number = dataset::number(path, cases.div_ceil(rows)).map_err(|why| stray(&why))?;
        let told = File::open(path).map_err(Into::into).and_then(part::told);
        let told = told.map_err(|error| damaged(path, &error))?;
        let wanted =
            Origin { study: study.to_owned(), cases: number * rows..(number + 1).saturating_mul(rows).min(cases) };
        silent += usize::from(!wanted.check(&told).map_err(|why| stray(&why))?);
    }
    Ok(silent)
}

fn damaged(path: &Path, error: &dyn std::fmt::Display) -> String {
    format!("`{}` is damaged: {error}; delete it, and `sweep --resume` computes it again", path.display())
}

/// The places of a column's words, NaN for empty cells.
fn places(column: &ArrayRef, words: &Words) -> Vec<f64> {
    let place = |word: Option<&str>| word.and_then(|word| words.places.get(word)).map_or(f64::NAN, |at| *at as f64);
    column.as_string_opt::<i32>().map_or_else(|| vec![f64::NAN; column.len()], |all| all.iter().map(place).collect())
}

/// A column as doubles, NaN for empty cells and for what is no number.
fn doubles(column: &ArrayRef) -> Vec<f64> {
    match column.data_type() {
        DataType::Float64 => column.as_primitive::<Float64Type>().iter().map(|cell| cell.unwrap_or(f64::NAN)).collect(),
        DataType::Int64 => {
            column.as_primitive::<Int64Type>().iter().map(|cell| cell.map_or(f64::NAN, |whole| whole as f64)).collect()
        }
        _ => vec![f64::NAN; column.len()],
    }
}
