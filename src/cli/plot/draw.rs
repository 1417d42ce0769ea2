//! The picture: one panel per unit above a common time axis.

use super::super::palette::{COLORS, range, tick};
use super::Line;
use plotters::prelude::*;

const WIDTH: u32 = 1120;
/// Room for the names right of the curves.
const LEGEND: u32 = 300;
const PANEL: u32 = 300;
const CAPTION: u32 = 40;
/// Height of a line of the legend.
const ROW: i32 = 20;
/// Longer series are thinned: so many stretches of time, and of each its lowest and its highest point.
const STRETCHES: usize = 1000;

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

/// As SVG.
///
/// # Errors
/// Where the drawing library gives up.
pub(super) fn draw(lines: &[Line], title: &str) -> anyhow::Result<String> {
    let mut units: Vec<&str> = Vec::new();
    for line in lines {
        if !units.contains(&line.unit.as_str()) {
            units.push(&line.unit);
        }
    }
    let times = span(lines.iter().flat_map(finite).map(|(time, _)| time));
    let of_unit = |unit: &str| lines.iter().filter(|line| line.unit == unit).collect::<Vec<_>>();
    let heights: Vec<u32> = units.iter().map(|unit| PANEL.max(60 + ROW as u32 * of_unit(unit).len() as u32)).collect();
    let mut svg = String::new();
    {
        let root =
            SVGBackend::with_string(&mut svg, (WIDTH, CAPTION + heights.iter().sum::<u32>())).into_drawing_area();
        root.fill(&WHITE)?;
        let mut rest = root.titled(title, ("sans-serif", 22))?;
        for (unit, height) in units.iter().zip(heights) {
            let (area, below) = rest.split_vertically(height);
            rest = below;
            panel(&area, &of_unit(unit), unit, times)?;
        }
        root.present()?;
    }
    Ok(svg)
}

/// The curves of one unit, and their names beside them.
fn panel(area: &Area<'_>, lines: &[&Line], unit: &str, times: (f64, f64)) -> anyhow::Result<()> {
    let (curves, legend) = area.split_horizontally(WIDTH - LEGEND);
    let values = range(lines.iter().flat_map(|line| finite(line)).map(|(_, value)| value));
    let values = if values.0.is_finite() && values.1.is_finite() { values } else { (0.0, 1.0) };
    let mut chart = ChartBuilder::on(&curves)
        .margin(12)
        .x_label_area_size(46)
        .y_label_area_size(86)
        .build_cartesian_2d(times.0..times.1, values.0..values.1)?;
    chart
        .configure_mesh()
        .x_desc("time (s)")
        .y_desc(format!("({unit})"))
        .x_label_formatter(&|x| tick(*x, times))
        .y_label_formatter(&|y| tick(*y, values))
        .label_style(("sans-serif", 15))
        .axis_desc_style(("sans-serif", 16))
        .bold_line_style(BLACK.mix(0.2))
        .light_line_style(BLACK.mix(0.05))
        .draw()?;
    for (row, line) in lines.iter().enumerate() {
        let RGBColor(red, green, blue) = COLORS[line.color % COLORS.len()];
        // Every recording after the first is darker and has dashes of its own, so that curves that coincide are both seen.
        let darker = 1 + u8::from(line.file > 0);
        let style = RGBColor(red / darker, green / darker, blue / darker).stroke_width(2);
        let points = thinned(finite(line));
        let y = 22 + ROW * row as i32;
        let sample = [(0, y), (28, y)];
        match [None, Some((9, 6)), Some((3, 5))][line.file.min(2)] {
            None => {
                chart.draw_series(LineSeries::new(points, style))?;
                legend.draw(&PathElement::new(sample, style))?;
            }
            Some((dash, gap)) => {
                chart.draw_series(DashedLineSeries::new(points, dash, gap, style))?;
                for start in (0..28).step_by((dash + gap) as usize) {
                    let end = (start + dash).min(28);
                    legend.draw(&PathElement::new([(start, y), (end, y)], style))?;
                }
            }
        }
        let name = format!("{} ({unit})", line.label);
        legend.draw(&Text::new(name, (36, y - 7), ("sans-serif", 14)))?;
    }
    Ok(())
}

fn finite(line: &Line) -> Vec<(f64, f64)> {
    line.points.iter().copied().filter(|(time, value)| time.is_finite() && value.is_finite()).collect()
}

/// Ends of the time axis.
fn span(times: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), t| (low.min(t), high.max(t)));
    match high > low {
        true => (low, high),
        false if low.is_finite() => (low, low + 1.0),
        false => (0.0, 1.0),
    }
}

/// No more points than can be seen, the extremes among them.
fn thinned(points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    if points.len() <= 2 * STRETCHES {
        return points;
    }
    let mut kept = Vec::with_capacity(2 * STRETCHES + 2);
    for part in points.chunks(points.len().div_ceil(STRETCHES)) {
        let by_value = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let (low, high) = (part.iter().min_by(by_value), part.iter().max_by(by_value));
        let mut ends: Vec<(f64, f64)> = low.into_iter().chain(high).copied().collect();
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        kept.extend(ends);
    }
    kept.extend(points.last());
    kept
}

#[cfg(test)]
mod tests {
    use super::thinned;

    #[test]
    fn long_series_keep_their_extremes_and_their_order() {
        let wave = |k: usize| (k as f64, if k == 12_345 { 9.0 } else { (k as f64 * 0.01).sin() });
        let kept = thinned((0..100_000).map(wave).collect());
        assert!(kept.len() < 2100 && kept.contains(&(12_345.0, 9.0)));
        assert!(kept.is_sorted_by(|a, b| a.0 <= b.0) && kept.last().is_some_and(|last| last.0 == 99_999.0));
        assert_eq!(thinned(vec![(0.0, 1.0), (1.0, 2.0)]).len(), 2);
    }
}
