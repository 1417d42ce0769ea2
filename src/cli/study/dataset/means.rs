//! Inputs of words: the cases of one word are a class, and in place of the word stands the mean of a column in that class.
//!
//! The variance of these means is what the input explains by itself; that a line in them meets the column as well as means of classes can
//! makes them an input like those that are numbers. Its coefficient is not negative, and its square is its part of the variance.

use super::super::super::text::number;
use super::Study;
use serde_json::{Map, Value, json};

/// Means of one column.
pub(super) struct Means {
    /// Where inputs of words begin.
    first: usize,
    /// Of every input of words the mean in each class; NaN if no case of this word has an answer.
    of: Vec<Vec<f64>>,
}

/// Words whose means are shown.
const MOST_WORDS: usize = 8;

impl Means {
    /// Means of a column, by the words of every input.
    ///
    /// # Errors
    /// If the dataset cannot be read.
    pub(super) fn new(study: &Study, name: &str) -> anyhow::Result<Self> {
        let (first, words) = (study.numbers, &study.reader.words);
        if words.is_empty() {
            return Ok(Self { first, of: Vec::new() });
        }
        // Means row by row, as moments have them: a sum of large numbers would lose digits.
        let mut classes: Vec<Vec<(f64, f64)>> = words.iter().map(|words| vec![(0.0, 0.0); words.all.len()]).collect();
        let last = study.inputs.len();
        study.answered(name, &mut |row| {
            for (place, classes) in row[first..last].iter().zip(&mut classes) {
                let (count, mean) = &mut classes[*place as usize];
                *count += 1.0;
                *mean += (row[last] - *mean) / *count;
            }
        })?;
        let mean = |(count, mean): (f64, f64)| if count > 0.0 { mean } else { f64::NAN };
        Ok(Self { first, of: classes.into_iter().map(|classes| classes.into_iter().map(mean).collect()).collect() })
    }

    /// Hands over the inputs, of words the means, and the column of every case that has an answer there.
    ///
    /// # Errors
    /// If the dataset cannot be read.
    pub(super) fn answered(&self, study: &Study, name: &str, take: &mut dyn FnMut(&[f64])) -> anyhow::Result<()> {
        if self.of.is_empty() {
            return study.answered(name, take);
        }
        let mut with = Vec::new();
        study.answered(name, &mut |row| {
            with.clear();
            with.extend_from_slice(row);
            for (cell, means) in with[self.first..].iter_mut().zip(&self.of) {
                *cell = means[*cell as usize];
            }
            take(&with);
        })
    }

    /// The inputs of several words.
    pub(super) fn inputs(&self) -> impl Iterator<Item = usize> {
        let several = self.of.iter().enumerate().filter(|(_, means)| known(means).count() > 1);
        several.map(|(index, _)| self.first + index)
    }

    /// How many more numbers these means are than the coefficients of their inputs.
    pub(super) fn fitted(&self) -> usize {
        self.of.iter().map(|means| known(means).count().saturating_sub(2)).sum()
    }

    /// Upper ends of the classes of every input but the last: one for each mean.
    pub(super) fn ends(&self) -> impl Iterator<Item = Vec<f64>> {
        self.of.iter().map(|means| {
            let mut ends: Vec<f64> = known(means).collect();
            ends.sort_by(f64::total_cmp);
            ends.dedup();
            ends.pop();
            ends
        })
    }

    /// The means of an input of words, by word.
    pub(super) fn json(&self, study: &Study, input: usize) -> Option<Value> {
        let named = self.named(study, input)?.map(|(word, mean)| (word.clone(), json!(mean)));
        Some(Value::Object(named.collect::<Map<_, _>>()))
    }

    /// A line of them.
    pub(super) fn text(&self, study: &Study, input: usize) -> Option<String> {
        let named: Vec<String> =
            self.named(study, input)?.map(|(word, mean)| format!("`{word}` {}", number(mean))).collect();
        let more = if named.len() > MOST_WORDS { ", …" } else { "" };
        let shown = named.iter().take(MOST_WORDS).cloned().collect::<Vec<_>>().join(", ");
        Some(format!("  means by `{}`: {shown}{more}\n", study.inputs[input]))
    }

    fn named<'s>(&'s self, study: &'s Study, input: usize) -> Option<impl Iterator<Item = (&'s String, f64)>> {
        let index = input.checked_sub(self.first)?;
        let pairs = study.reader.words[index].all.iter().zip(&self.of[index]);
        Some(pairs.map(|(word, mean)| (word, *mean)).filter(|(_, mean)| !mean.is_nan()))
    }
}

fn known(means: &[f64]) -> impl Iterator<Item = f64> {
    means.iter().copied().filter(|mean| !mean.is_nan())
}
