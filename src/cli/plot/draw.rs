//! The picture: one panel per unit above a common axis.

use super::super::frame::{self, Area, CAPTION, Legend, ROW, px};
use super::super::palette::{Theme, range, tick};
use super::Line;
use plotters::prelude::*;

/// Width, and height of a panel (pixels).
const WIDTH: u32 = 1120;
const PANEL: u32 = 300;
/// Points that are as close as this to the straight line between their neighbours are left out (pixels).
const STRAIGHT: f64 = 0.12;
/// Longer series are thinned: so many stretches of time, and of each its lowest and its highest point.
const STRETCHES: usize = 1000;

/// As SVG; `across` is what the axis along x is called.
///
/// # Errors
/// If the drawing library fails.
pub(in crate::cli) fn draw(lines: &[Line], title: &str, across: &str, theme: Theme) -> anyhow::Result<String> {
    let mut units: Vec<&str> = Vec::new();
    for line in lines {
        if !units.contains(&line.unit.as_str()) {
            units.push(&line.unit);
        }
    }
    let times = span(lines.iter().flat_map(finite).map(|(time, _)| time));
    let of_unit = |unit: &str| lines.iter().filter(|line| line.unit == unit).collect::<Vec<_>>();
    let heights: Vec<u32> = units.iter().map(|unit| PANEL.max(60 + ROW * of_unit(unit).len() as u32)).collect();
    let names: Vec<String> = lines.iter().map(|line| with_unit(&line.label, &line.unit)).collect();
    let legend = frame::legend_width(names.iter().map(String::as_str));
    frame::svg((WIDTH, CAPTION + heights.iter().sum::<u32>()), theme, |root| {
        let mut rest = frame::titled(root, theme, title)?;
        for (unit, height) in units.iter().zip(heights) {
            let (area, below) = rest.split_vertically(px(height));
            rest = below;
            let (curves, mut names) = frame::with_legend(&area, theme, legend);
            panel(&curves, &mut names, &of_unit(unit), (across, unit), times, theme)?;
        }
        Ok(())
    })
}

/// What is measured in a unit, for an axis; of one curve its name.
fn quantity(lines: &[&Line], unit: &str) -> String {
    let name = match (lines, unit) {
        ([one], _) => one.label.as_str(),
        (_, "m") => "length",
        (_, "rad") => "angle",
        (_, "m/s") => "speed",
        (_, "rad/s") => "angular velocity",
        (_, "m/s²") => "acceleration",
        (_, "rad/s²") => "angular acceleration",
        (_, "N") => "force",
        (_, "N m") => "moment",
        (_, "J") => "energy",
        (_, "W") => "power",
        _ => "value",
    };
    with_unit(name, unit)
}

/// `angle (rad)`; numbers without a unit have none.
pub(in crate::cli) fn with_unit(name: &str, unit: &str) -> String {
    if matches!(unit, "" | "1") { name.to_owned() } else { format!("{name} ({unit})") }
}

/// The curves of one unit, and their names beside them.
fn panel(
    area: &Area<'_>,
    legend: &mut Legend<'_>,
    lines: &[&Line],
    (across, unit): (&str, &str),
    times: (f64, f64),
    theme: Theme,
) -> anyhow::Result<()> {
    let values = range(lines.iter().flat_map(|line| finite(line)).map(|(_, value)| value));
    let values = if values.0.is_finite() && values.1.is_finite() { values } else { (0.0, 1.0) };
    let up = quantity(lines, unit);
    let axes: [frame::Axis<'_>; 2] = [(across, &|x| tick(*x, times)), (&up, &|y| tick(*y, values))];
    let mut chart = frame::linear(area, theme, (times, values), axes)?;
    for line in lines {
        // Every recording after the first is nearer to the ink and has dashes of its own, so that curves that coincide are both seen.
        let (color, ink) = (theme.color(line.color), theme.ink());
        let [red, green, blue] = [(color.0, ink.0), (color.1, ink.1), (color.2, ink.2)]
            .map(|(a, b)| if line.file > 0 { a / 2 + b / 2 } else { a });
        let style = RGBColor(red, green, blue).stroke_width(px(17) / 10);
        let scale = [f64::from(WIDTH) / (times.1 - times.0), f64::from(PANEL) / (values.1 - values.0)];
        let points = straightened(thinned(finite(line)), scale);
        let dashes = [None, Some((9, 6)), Some((3, 5))][line.file.min(2)];
        match dashes {
            None => chart.draw_series(LineSeries::new(points, style))?,
            Some((dash, gap)) => {
                chart.draw_series(DashedLineSeries::new(points, frame::at(dash), frame::at(gap), style))?
            }
        };
        legend.line(&with_unit(&line.label, unit), style, dashes)?;
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

/// Without the points that a straight line between others passes as close as is not seen (Douglas and Peucker); `scale` are pixels per
/// unit of both axes.
fn straightened(points: Vec<(f64, f64)>, scale: [f64; 2]) -> Vec<(f64, f64)> {
    // Every point is compared with many others.
    if points.len() < 3 || points.len() > 4 * STRETCHES {
        return points;
    }
    let at = |index: usize| [points[index].0 * scale[0], points[index].1 * scale[1]];
    let mut kept = vec![false; points.len()];
    (kept[0], kept[points.len() - 1]) = (true, true);
    let mut open = vec![(0, points.len() - 1)];
    while let Some((first, last)) = open.pop() {
        let ([x, y], [end_x, end_y]) = (at(first), at(last));
        let (along, up) = (end_x - x, end_y - y);
        let square = along * along + up * up;
        let off = |index: usize| {
            let (dx, dy) = (at(index)[0] - x, at(index)[1] - y);
            let part = if square > 0.0 { ((dx * along + dy * up) / square).clamp(0.0, 1.0) } else { 0.0 };
            (dx - part * along).hypot(dy - part * up)
        };
        let farthest = (first + 1..last).map(|index| (index, off(index))).max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((index, _)) = farthest.filter(|(_, off)| *off > STRAIGHT) {
            kept[index] = true;
            open.extend([(first, index), (index, last)]);
        }
    }
    points.into_iter().zip(kept).filter(|(_, kept)| *kept).map(|(point, _)| point).collect()
}

#[cfg(test)]
mod tests {
    use super::{STRAIGHT, straightened, thinned};

    #[test]
    fn what_is_left_out_is_not_seen() {
        let wave: Vec<(f64, f64)> = (0..1000).map(|k| (k as f64, 100.0 * (k as f64 * 0.02).sin())).collect();
        let kept = straightened(wave.clone(), [1.0; 2]);
        assert!(kept.len() < 200, "{}", kept.len());
        for (x, y) in wave {
            let pair = kept.windows(2).find(|pair| pair[0].0 <= x && x <= pair[1].0).expect("a stretch");
            let part = (x - pair[0].0) / (pair[1].0 - pair[0].0);
            let there = pair[0].1 + part * (pair[1].1 - pair[0].1);
            // As seen straight up, where the curve is steepest: a slope of two.
            assert!((there - y).abs() < 2.3 * STRAIGHT, "{x}: {there} for {y}");
        }
        let jump = vec![(0.0, 0.0), (1.0, 0.0), (1.0, 5.0), (2.0, 5.0)];
        assert_eq!(straightened(jump.clone(), [100.0; 2]), jump);
    }

    #[test]
    fn long_series_keep_their_extremes_and_their_order() {
        let wave = |k: usize| (k as f64, if k == 12_345 { 9.0 } else { (k as f64 * 0.01).sin() });
        let kept = thinned((0..100_000).map(wave).collect());
        assert!(kept.len() < 2100 && kept.contains(&(12_345.0, 9.0)));
        assert!(kept.is_sorted_by(|a, b| a.0 <= b.0) && kept.last().is_some_and(|last| last.0 == 99_999.0));
        assert_eq!(thinned(vec![(0.0, 1.0), (1.0, 2.0)]).len(), 2);
    }
}
