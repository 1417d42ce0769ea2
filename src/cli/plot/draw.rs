//! The picture: one panel per unit above a common axis.

use super::super::palette::{COLORS, range, tick};
use super::Line;
use plotters::prelude::*;

/// The library draws on whole points: this many of them are a pixel.
const FINE: u32 = 10;
const WIDTH: u32 = 1120 * FINE;
/// Room for the names right of the curves.
const LEGEND: u32 = 300 * FINE;
const PANEL: u32 = 300 * FINE;
const CAPTION: u32 = 40 * FINE;
/// Height of a line of the legend.
const ROW: i32 = 20 * FINE as i32;
/// Longer series are thinned: so many stretches of time, and of each its lowest and its highest point.
const STRETCHES: usize = 1000;

type Area<'a> = DrawingArea<SVGBackend<'a>, plotters::coord::Shift>;

/// As SVG; `across` is what the axis along x is called.
///
/// # Errors
/// Where the drawing library gives up.
pub(in crate::cli) fn draw(lines: &[Line], title: &str, across: &str) -> anyhow::Result<String> {
    let mut units: Vec<&str> = Vec::new();
    for line in lines {
        if !units.contains(&line.unit.as_str()) {
            units.push(&line.unit);
        }
    }
    let times = span(lines.iter().flat_map(finite).map(|(time, _)| time));
    let of_unit = |unit: &str| lines.iter().filter(|line| line.unit == unit).collect::<Vec<_>>();
    let heights: Vec<u32> =
        units.iter().map(|unit| PANEL.max(60 * FINE + ROW as u32 * of_unit(unit).len() as u32)).collect();
    let height = CAPTION + heights.iter().sum::<u32>();
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
        root.fill(&WHITE)?;
        let mut rest = root.titled(title, ("sans-serif", 22 * FINE))?;
        for (unit, height) in units.iter().zip(heights) {
            let (area, below) = rest.split_vertically(height);
            rest = below;
            panel(&area, &of_unit(unit), (across, unit), times)?;
        }
        root.present()?;
    }
    // As large as it is meant; the points stay.
    let size = |edge: u32| (edge.to_string(), (edge / FINE).to_string());
    let (width, height) = (size(WIDTH), size(height));
    let fine = format!("width=\"{}\" height=\"{}\"", width.0, height.0);
    Ok(svg.replacen(&fine, &format!("width=\"{}\" height=\"{}\"", width.1, height.1), 1))
}

/// The curves of one unit, and their names beside them.
fn panel(area: &Area<'_>, lines: &[&Line], (across, unit): (&str, &str), times: (f64, f64)) -> anyhow::Result<()> {
    let (curves, legend) = area.split_horizontally(WIDTH - LEGEND);
    let values = range(lines.iter().flat_map(|line| finite(line)).map(|(_, value)| value));
    let values = if values.0.is_finite() && values.1.is_finite() { values } else { (0.0, 1.0) };
    let mut chart = ChartBuilder::on(&curves)
        .margin(12 * FINE)
        .x_label_area_size(46 * FINE)
        .y_label_area_size(86 * FINE)
        .build_cartesian_2d(times.0..times.1, values.0..values.1)?;
    chart
        .configure_mesh()
        .x_desc(across)
        .y_desc(format!("({unit})"))
        .x_label_formatter(&|x| tick(*x, times))
        .y_label_formatter(&|y| tick(*y, values))
        .label_style(("sans-serif", 15 * FINE))
        .axis_desc_style(("sans-serif", 16 * FINE))
        .set_all_tick_mark_size(5 * FINE)
        .axis_style(BLACK.mix(0.6).stroke_width(FINE))
        .bold_line_style(BLACK.mix(0.12).stroke_width(FINE))
        .light_line_style(TRANSPARENT)
        .draw()?;
    for (row, line) in lines.iter().enumerate() {
        let RGBColor(red, green, blue) = COLORS[line.color % COLORS.len()];
        // Every recording after the first is darker and has dashes of its own, so that curves that coincide are both seen.
        let darker = 1 + u8::from(line.file > 0);
        let style = RGBColor(red / darker, green / darker, blue / darker).stroke_width(17 * FINE / 10);
        let points = thinned(finite(line));
        let fine = FINE as i32;
        let y = 22 * fine + ROW * row as i32;
        let sample = [(0, y), (28 * fine, y)];
        match [None, Some((9 * fine, 6 * fine)), Some((3 * fine, 5 * fine))][line.file.min(2)] {
            None => {
                chart.draw_series(LineSeries::new(points, style))?;
                legend.draw(&PathElement::new(sample, style))?;
            }
            Some((dash, gap)) => {
                chart.draw_series(DashedLineSeries::new(points, dash, gap, style))?;
                for start in (0..28 * fine).step_by((dash + gap) as usize) {
                    let end = (start + dash).min(28 * fine);
                    legend.draw(&PathElement::new([(start, y), (end, y)], style))?;
                }
            }
        }
        let name = format!("{} ({unit})", line.label);
        legend.draw(&Text::new(name, (36 * fine, y - 7 * fine), ("sans-serif", 14 * FINE)))?;
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
    // A curve that turns back has no stretches of its own.
    if points.len() <= 2 * STRETCHES || !points.is_sorted_by(|a, b| a.0 <= b.0) {
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
