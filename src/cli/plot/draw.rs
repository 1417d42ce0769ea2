//! The picture: one panel per unit above a common axis.

use super::super::frame::{self, Area, CAPTION, Legend, ROW, px};
use super::super::palette::{Theme, range, tick};
use super::super::sizes::Sizes;
use super::Line;
use crate::round_off::SHOWN;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use std::collections::BTreeSet;

/// Width, and height of a panel (pixels).
const WIDTH: u32 = 1120;
const PANEL: u32 = 300;
/// Points that are as close as this to the straight line between their neighbours are left out (pixels).
const STRAIGHT: f64 = 0.12;
/// Longer series are thinned: so many stretches of time, and of each its lowest and its highest point.
const STRETCHES: usize = 1000;
/// What lines of one colour are told from each other by: the length and the gap of dashes (pixels).
const DASHES: [Option<(i32, i32)>; 6] = [None, Some((9, 6)), Some((3, 5)), Some((18, 5)), Some((9, 14)), Some((2, 10))];

/// What is drawn.
pub(in crate::cli) struct Plot<'p> {
    pub(in crate::cli) lines: &'p [Line],
    pub(in crate::cli) title: &'p str,
    /// What the axis along x is called.
    pub(in crate::cli) across: &'p str,
    /// What is round-off of the scene is drawn as zero.
    pub(in crate::cli) sizes: Sizes,
    pub(in crate::cli) theme: Theme,
}

/// The curves of one unit, over the axes that they are drawn on.
struct Panel<'p> {
    lines: Vec<&'p Line>,
    unit: &'p str,
    times: (f64, f64),
    values: (f64, f64),
    /// All is round-off, and drawn as zero.
    is_noise: bool,
    /// How many recordings there are.
    files: usize,
}

/// As SVG, the panels below each other over one axis along x.
///
/// # Errors
/// If the drawing library fails.
pub(in crate::cli) fn draw(plot: &Plot<'_>) -> anyhow::Result<String> {
    let Plot { lines, title, across, sizes, theme } = *plot;
    let mut units: Vec<&str> = Vec::new();
    for line in lines {
        if !units.contains(&line.unit.as_str()) {
            units.push(&line.unit);
        }
    }
    let times = span(lines.iter().flat_map(finite).map(|(time, _)| time));
    let files = lines.iter().map(|line| line.file + 1).max().unwrap_or(1);
    let of_unit = |unit| {
        let lines: Vec<&Line> = lines.iter().filter(|line| line.unit == unit).collect();
        let values = || lines.iter().flat_map(|line| finite(line)).map(|(_, value)| value);
        let size = sizes.of_unit(unit);
        let is_noise = size > 0.0 && values().all(|value| SHOWN.hides(value, size));
        let ends = if is_noise { (-size, size) } else { range(values()) };
        let ends = if ends.0.is_finite() && ends.1.is_finite() { ends } else { (0.0, 1.0) };
        Panel { unit, times, values: ends, is_noise, files, lines }
    };
    let panels: Vec<Panel<'_>> = units.into_iter().map(of_unit).collect();
    let heights: Vec<u32> = panels.iter().map(|panel| PANEL.max(60 + ROW * panel.lines.len() as u32)).collect();
    // All curves begin at the left edge of those with the longest numbers.
    let beside: Vec<u32> = panels.iter().map(Panel::beside).collect();
    let most = beside.iter().copied().max().unwrap_or(0);
    let names: Vec<String> = lines.iter().map(|line| with_unit(&line.label, &line.unit)).collect();
    let legend = frame::legend_width(names.iter().map(String::as_str));
    frame::svg((WIDTH, CAPTION + heights.iter().sum::<u32>()), theme, |root| {
        let mut rest = frame::titled(root, theme, title)?;
        for (index, (panel, height)) in panels.iter().zip(&heights).enumerate() {
            let (area, below) = rest.split_vertically(px(*height));
            rest = below;
            let (curves, mut names) = frame::with_legend(&area, theme, legend);
            let curves = curves.margin(0, 0, most - beside[index], 0);
            let across = if index + 1 == panels.len() { across } else { "" };
            panel.draw(&curves, &mut names, across, theme)?;
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
        (_, "1") if lines.iter().all(|line| is_of_quaternion(&line.label)) => "quaternion",
        _ => "value",
    };
    with_unit(name, unit)
}

/// Whether a column is a number of a quaternion: `body.qw`, `body.quaternion.w`.
fn is_of_quaternion(label: &str) -> bool {
    let last = label.rsplit('.').next().unwrap_or_default();
    matches!(last, "qw" | "qx" | "qy" | "qz") || label.contains(".quaternion.")
}

/// `angle (rad)`; numbers without a unit have none.
pub(in crate::cli) fn with_unit(name: &str, unit: &str) -> String {
    if matches!(unit, "" | "1") { name.to_owned() } else { format!("{name} ({unit})") }
}

/// The dashes of a line of one of so many recordings, with so many lines of its colour before it.
fn dashes(file: usize, files: usize, round: usize) -> Option<(i32, i32)> {
    DASHES[(file + files * round) % DASHES.len()]
}

impl Panel<'_> {
    /// Room for the numbers at its upright axis.
    fn beside(&self) -> u32 {
        let up = RangedCoordf64::from(self.values.0..self.values.1);
        frame::beside(&up, (&quantity(&self.lines, self.unit), &|y| tick(*y, self.values)))
    }

    /// Which of the panel's columns a line shows: those of several recordings look alike.
    fn place(&self, line: &Line) -> usize {
        let before = self.lines.iter().map(|other| other.column).filter(|other| *other < line.column);
        before.collect::<BTreeSet<_>>().len()
    }

    /// Draws the curves, and their names beside them.
    fn draw(&self, area: &Area<'_>, legend: &mut Legend<'_>, across: &str, theme: Theme) -> anyhow::Result<()> {
        let Self { unit, times, values, .. } = *self;
        let up = quantity(&self.lines, unit);
        let axes: [frame::Axis<'_>; 2] = [(across, &|x| tick(*x, times)), (&up, &|y| tick(*y, values))];
        let mut chart = frame::linear(area, theme, (times, values), axes)?;
        for line in &self.lines {
            // Every recording after the first is nearer to the ink and has dashes of its own, so that curves that coincide are both seen.
            let ((color, round), ink) = (theme.color(self.place(line)), theme.ink());
            let [red, green, blue] = [(color.0, ink.0), (color.1, ink.1), (color.2, ink.2)]
                .map(|(a, b)| if line.file > 0 { a / 2 + b / 2 } else { a });
            let style = RGBColor(red, green, blue).stroke_width(px(17) / 10);
            let scale = [f64::from(WIDTH) / (times.1 - times.0), f64::from(PANEL) / (values.1 - values.0)];
            let shown = |(time, value): (f64, f64)| (time, if self.is_noise { 0.0 } else { value });
            let points = straightened(thinned(finite(line).into_iter().map(shown).collect()), scale);
            let dashes = dashes(line.file, self.files, round);
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
    use super::super::MOST_LINES;
    use super::{STRAIGHT, Theme, dashes, straightened, thinned};
    use std::collections::HashSet;

    #[test]
    fn no_two_lines_of_a_recording_look_the_same() {
        let look = |line: usize| {
            let (color, round) = Theme::Light.color(line);
            ((color.0, color.1, color.2), dashes(0, 1, round))
        };
        assert_eq!((0..MOST_LINES).map(look).collect::<HashSet<_>>().len(), MOST_LINES);
    }

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
