//! Plots of a comparison: residual against iteration of one scene, time against size of several.

use super::super::frame;
use super::super::palette::{BLUE, GREEN, PURPLE, Theme, VERMILION};
use super::{Row, Run};
use crate::statics::Method;
use plotters::prelude::*;

/// Residuals below this are drawn there: round-off.
const LEAST: f64 = 1e-18;

/// One method: its points, and those of them where it did not find what was wanted.
struct Line {
    label: &'static str,
    color: RGBColor,
    points: Vec<(f64, f64)>,
    failed: Vec<(f64, f64)>,
}

impl Line {
    fn name(&self) -> String {
        let crossed = if self.failed.is_empty() { "" } else { " (crossed: not what was wanted)" };
        format!("{}{crossed}", self.label)
    }
}

fn color(method: Method) -> RGBColor {
    match method {
        Method::Auto => BLUE,
        Method::Newton => VERMILION,
        Method::Relaxation => GREEN,
        Method::Lagrange => PURPLE,
    }
}

/// Residual against iteration; of a relaxation against time steps.
///
/// # Errors
/// If the drawing library fails.
pub(super) fn residuals(rows: &[Row], title: &str) -> anyhow::Result<String> {
    let lines = rows.iter().filter_map(|row| {
        let found = row.found.as_ref().ok()?;
        // A relaxation keeps its residual at every new start from rest only.
        let each = found.iterations as f64 / found.history.len().max(1) as f64;
        let point = |(i, residual): (usize, f64)| ((i + 1) as f64 * each, residual.max(LEAST));
        let points: Vec<(f64, f64)> = found.history.iter().map(|at| at.residual).enumerate().map(point).collect();
        let failed = points.last().filter(|_| !found.converged).copied().into_iter().collect();
        Some(Line { label: row.method.name(), color: color(row.method), points, failed })
    });
    draw(
        lines.collect(),
        &format!("{title}: residual against iteration"),
        ["iterations, time steps", "largest unbalanced force, relative"],
    )
}

/// Time of the search against the degrees of freedom.
///
/// # Errors
/// If the drawing library fails.
pub(super) fn times(runs: &[Run], title: &str) -> anyhow::Result<String> {
    let lines = Method::ALL.into_iter().map(|method| {
        let mine = |converged: bool| {
            let of_run = |run: &Run| {
                let row = run.rows.iter().find(|row| row.method == method)?;
                let found = row.found.as_ref().ok()?;
                (found.converged == converged).then_some((run.degrees_of_freedom as f64, row.search.as_secs_f64()))
            };
            runs.iter().filter_map(of_run).collect::<Vec<_>>()
        };
        let failed = mine(false);
        let mut points: Vec<(f64, f64)> = mine(true).into_iter().chain(failed.iter().copied()).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Line { label: method.name(), color: color(method), points, failed }
    });
    draw(lines.collect(), &format!("{title}: time of the search"), ["degrees of freedom", "time (s)"])
}

fn draw(lines: Vec<Line>, title: &str, axes: [&str; 2]) -> anyhow::Result<String> {
    let all = || lines.iter().flat_map(|line| line.points.iter().copied());
    let theme = Theme::default();
    frame::svg(frame::SIZE, theme, |root| {
        let root = frame::titled(root, theme, title)?;
        let lines: Vec<&Line> = lines.iter().filter(|line| !line.points.is_empty()).collect();
        let names: Vec<String> = lines.iter().map(|line| line.name()).collect();
        let width = frame::legend_width(names.iter().map(String::as_str));
        let (area, mut legend) = frame::with_legend(&root, theme, width);
        let mut chart = frame::logarithmic(&area, theme, all(), axes)?;
        for (Line { color, points, failed, .. }, name) in lines.into_iter().zip(&names) {
            let style = color.stroke_width(frame::px(2));
            chart.draw_series(LineSeries::new(points.iter().copied(), style))?;
            let found = points.iter().filter(|at| !failed.contains(at));
            chart.draw_series(found.map(|at| Circle::new(*at, frame::at(4), color.filled())))?;
            chart.draw_series(failed.iter().map(|at| Cross::new(*at, frame::at(6), style)))?;
            legend.line(name, style, None)?;
        }
        Ok(())
    })
}
