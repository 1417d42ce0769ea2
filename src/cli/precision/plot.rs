//! The work–precision plot.

use super::super::frame;
use super::super::palette::Theme;
use crate::integrate::Method;
use crate::simulate::precision::Study;
use plotters::prelude::*;

/// What is drawn of one method.
struct Line {
    label: String,
    color: RGBColor,
    /// Time (s) and error.
    points: Vec<(f64, f64)>,
}

/// Error against time, both logarithmic, one line per method, as SVG; `None` if there is nothing to draw.
///
/// # Errors
/// If the drawing library fails.
pub(super) fn draw(study: &Study, title: &str) -> anyhow::Result<Option<String>> {
    let lines = lines(study);
    let all = || lines.iter().flat_map(|line| line.points.iter().copied());
    if all().next().is_none() {
        return Ok(None);
    }
    let title = format!("{title}: error against time");
    let axes = ["time of the steps (s)", "largest error (rad, scene lengths, the same per scene time)"];
    let theme = Theme::default();
    let drawn = frame::svg(frame::SIZE, theme, |root| {
        let root = frame::titled(root, theme, &title)?;
        let width = frame::legend_width(lines.iter().map(|line| line.label.as_str()));
        let (area, mut legend) = frame::with_legend(&root, theme, width);
        let mut chart = frame::logarithmic(&area, theme, all(), axes)?;
        for Line { label, color, points } in &lines {
            let style = color.stroke_width(frame::px(2));
            chart.draw_series(LineSeries::new(points.iter().copied(), style))?;
            chart.draw_series(points.iter().map(|point| Circle::new(*point, frame::at(4), color.filled())))?;
            legend.line(label, style, None)?;
        }
        Ok(())
    });
    drawn.map(Some)
}

/// One line per method, also where all its points failed; an error of zero is drawn at the rounding of one.
fn lines(study: &Study) -> Vec<Line> {
    let of_method = |(method, color): (Method, RGBColor)| {
        let mine = || study.points.iter().filter(move |point| point.method == method);
        let failed = mine().filter(|point| point.outcome.is_err()).count();
        let points: Vec<(f64, f64)> = mine()
            .filter_map(|point| Some((point.wall.as_secs_f64(), point.outcome.as_ref().ok()?.state.max(f64::EPSILON))))
            .collect();
        let name = method.name();
        let label = if failed > 0 { format!("{name} ({failed} failed)") } else { name.to_owned() };
        Line { label, color, points }
    };
    let measured = |(method, _): &(Method, RGBColor)| study.points.iter().any(|point| point.method == *method);
    Method::ALL.into_iter().zip(Theme::default().colors()).filter(measured).map(of_method).collect()
}
