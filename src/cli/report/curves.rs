//! The curves of a run, and its numbers in single precision.

use super::super::palette::Theme;
use super::super::plot::Line;
use super::super::plot::draw::{self, Plot};
use super::super::samples::Rows;
use super::super::samples::{self, Place};
use super::super::sizes::Sizes;
use super::material::Material;
use crate::record::Table;

/// Columns of one channel that are drawn.
const MOST_CURVES: usize = 20;
/// Numbers that a page holds: with four bytes each in letters 0.45 megabytes.
const MOST_NUMBERS: usize = 84_000;

/// The curves of each channel that has some, as SVG.
pub(super) fn curves(material: &Material) -> anyhow::Result<Vec<String>> {
    let tables = Table::all(&material.scene);
    let mut drawn = Vec::new();
    for (channel, title) in
        [("outputs", "Outputs"), ("hinges", "Hinge coordinates"), ("couplings", "Couplings"), ("energy", "Energy")]
    {
        let Some(index) = tables.iter().position(|table| table.name == channel) else { continue };
        let all = samples::columns(&tables, channel)?;
        // Of the hinges the coordinates, which come first.
        let count = if channel == "hinges" { material.scene.positions.len() } else { all.len() };
        let places: Vec<Place> = all.into_iter().filter(|place| place.table == index).take(count).collect();
        let shown = &places[..places.len().min(MOST_CURVES)];
        if shown.is_empty() || material.samples.len() < 2 {
            continue;
        }
        let mut lines: Vec<Line> = (shown.iter().enumerate())
            .map(|(column, place)| Line {
                label: place.column.name.clone(),
                unit: place.column.unit.clone(),
                file: 0,
                column,
                points: Vec::with_capacity(material.samples.len()),
            })
            .collect();
        let mut rows = Rows::new(&tables, shown);
        for sample in &material.samples {
            for (line, value) in lines.iter_mut().zip(rows.read(sample)) {
                line.points.push((sample.time, value));
            }
        }
        let title = match places.len() - shown.len() {
            0 => title.to_owned(),
            more => format!("{title}: the first {} of {}", shown.len(), shown.len() + more),
        };
        let (across, sizes) = ("time (s)", Sizes::of(&material.scene));
        drawn.push(draw::draw(&Plot { lines: &lines, title: &title, across, sizes, theme: Theme::default() })?);
    }
    Ok(drawn)
}

/// The numbers that can be saved.
pub(super) struct Numbers {
    /// Headings, as of a CSV file; the time first.
    pub(super) columns: Vec<String>,
    /// Row by row.
    pub(super) values: Vec<f32>,
    /// Every `stride`-th sample is there.
    pub(super) stride: usize,
}

pub(super) fn numbers(material: &Material) -> anyhow::Result<Numbers> {
    let tables = Table::all(&material.scene);
    let mut places = Vec::new();
    for channel in ["hinges", "energy", "couplings", "outputs"] {
        if tables.iter().any(|table| table.name == channel) {
            places.extend(samples::columns(&tables, channel)?);
        }
    }
    let mut columns = vec!["time [s]".to_owned()];
    columns.extend(places.iter().map(|place| format!("{} [{}]", place.column.name, place.column.unit)));
    let stride = (material.samples.len() * columns.len()).div_ceil(MOST_NUMBERS).max(1);
    let mut rows = Rows::new(&tables, &places);
    let mut values = Vec::new();
    for sample in material.samples.iter().step_by(stride) {
        values.push(sample.time as f32);
        values.extend(rows.read(sample).map(|x| x as f32));
    }
    Ok(Numbers { columns, values, stride })
}
