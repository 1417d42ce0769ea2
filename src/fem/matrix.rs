//! Sparse symmetric matrices from entries in any order.

use super::Flaw;
use crate::fem::counted;
use crate::sparse::{Pattern, times};
use std::collections::BTreeMap;

/// Entries of both triangles that differ by more than this part of the larger one are not those of one symmetric matrix: files in
/// text have six digits or more.
const SYMMETRIC: f64 = 1e-5;

/// A symmetric matrix by its upper triangle, column by column; every diagonal entry is there.
#[derive(Debug, Clone, PartialEq)]
pub struct Symmetric {
    starts: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
}

impl Symmetric {
    /// Of entries (row, column, value) of n rows: of one triangle, or of both, which must agree. Entries of one place are added.
    ///
    /// # Errors
    /// A place outside, a number that is not finite, or two triangles that do not agree: the rows and the values.
    pub fn of(
        name: &str,
        n: usize,
        entries: impl IntoIterator<Item = (usize, usize, f64)>,
        label: impl Fn(usize) -> String,
    ) -> Result<Self, Flaw> {
        let mut triangles = [BTreeMap::new(), BTreeMap::new()];
        for (row, column, value) in entries {
            if row.max(column) >= n {
                let message = format!("{name}: entry ({row}, {column}) of a matrix of {}", counted(n, "row", "rows"));
                return Err(Flaw::new(message).help("rows and columns count from 0"));
            }
            if !value.is_finite() {
                return Err(Flaw::new(format!("{name}: entry ({row}, {column}) is {value}")));
            }
            let (place, side) = if row <= column { ((column, row), 0) } else { ((row, column), 1) };
            *triangles[side].entry(place).or_insert(0.0) += value;
        }
        let [mut upper, lower] = triangles;
        let has_both = !lower.is_empty() && upper.keys().any(|(column, row)| column != row);
        let size = |i: usize| upper.get(&(i, i)).map_or(0.0, |x: &f64| x.abs());
        if has_both {
            let zero = 0.0;
            let off = |place: &(usize, usize)| {
                let (one, other) = (upper.get(place).unwrap_or(&zero), lower.get(place).unwrap_or(&zero));
                let noise = SYMMETRIC * (size(place.0) * size(place.1)).sqrt();
                (one - other).abs() > SYMMETRIC * one.abs().max(other.abs()) + noise * SYMMETRIC
            };
            let mut places = lower.keys().chain(upper.keys().filter(|(column, row)| column != row));
            if let Some(place) = places.find(|place| off(place)) {
                let (one, other) = (upper.get(place).unwrap_or(&zero), lower.get(place).unwrap_or(&zero));
                let (row, column) = (label(place.1), label(place.0));
                let message =
                    format!("{name} is not symmetric: {row} against {column} has {one:e}, its mirror {other:e}");
                return Err(Flaw::new(message).help("give both triangles of a symmetric matrix, or one"));
            }
            for (place, value) in upper.iter_mut().filter(|(place, _)| place.0 != place.1) {
                *value = 0.5 * (*value + lower.get(place).unwrap_or(&0.0));
            }
            lower.into_iter().filter(|(place, _)| !upper.contains_key(place)).collect::<Vec<_>>().into_iter().for_each(
                |(place, value)| {
                    upper.insert(place, 0.5 * value);
                },
            );
        } else {
            upper.extend(lower);
        }
        (0..n).for_each(|i| {
            upper.entry((i, i)).or_insert(0.0);
        });
        let mut matrix = Self { starts: vec![0], rows: Vec::new(), values: Vec::new() };
        for ((column, row), value) in upper {
            while matrix.starts.len() <= column {
                matrix.starts.push(matrix.rows.len());
            }
            matrix.rows.push(row);
            matrix.values.push(value);
        }
        matrix.starts.push(matrix.rows.len());
        matrix.starts.resize(n + 1, matrix.rows.len());
        Ok(matrix)
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(super) fn pattern(&self) -> Pattern<'_> {
        (&self.starts, &self.rows)
    }

    pub(super) fn values(&self) -> &[f64] {
        &self.values
    }

    /// The entries of the upper triangle: row, column, value.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        (0..self.len()).flat_map(move |column| {
            (self.starts[column]..self.starts[column + 1]).map(move |at| (self.rows[at], column, self.values[at]))
        })
    }

    /// `A x`.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        times(self.pattern(), &self.values, x, &mut y);
        y
    }

    /// `|A| |x|`.
    pub(super) fn sizes(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for (row, column, value) in self.entries() {
            y[row] += (value * x[column]).abs();
            if row != column {
                y[column] += (value * x[row]).abs();
            }
        }
        y
    }

    /// The part of the rows that `place` keeps, by their new numbers.
    pub(super) fn part(&self, place: &[Option<usize>], n: usize) -> Self {
        let kept = self.entries().filter_map(|(row, column, value)| Some((place[row]?, place[column]?, value)));
        let mut columns: Vec<Vec<(usize, f64)>> = vec![Vec::new(); n];
        kept.for_each(|(row, column, value)| columns[row.max(column)].push((row.min(column), value)));
        let mut part = Self { starts: vec![0], rows: Vec::new(), values: Vec::new() };
        for mut column in columns {
            column.sort_by_key(|(row, _)| *row);
            part.rows.extend(column.iter().map(|(row, _)| *row));
            part.values.extend(column.iter().map(|(_, value)| *value));
            part.starts.push(part.rows.len());
        }
        part
    }
}
