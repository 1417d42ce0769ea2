//! Diagrams of section forces over arc length: `statics --diagram`.

use super::super::frame::{self, Area, px};
use super::super::number::{exact, without_noise};
use super::super::output;
use super::super::palette::{Theme, range, tick};
use super::super::plot::draw::with_unit;
use crate::dynamics::DiagramPoint;
use crate::model::Model;
use crate::model::contact::fits;
use crate::round_off::SHOWN;
use crate::statics::{Equilibrium, diagrams};
use crate::suggest::closest;
use anyhow::{Context, bail, ensure};
use plotters::element::IntoDynElement;
use plotters::prelude::*;
use std::fmt::Write;
use std::path::Path;
use std::sync::Arc;

/// Stretches of an element between the points of its curves.
const STRETCHES: usize = 10;
/// More beams make no picture that can be read.
const MOST_BEAMS: usize = 12;
/// Height of a panel, of the name of a beam above its panels, and width of all (pixels).
const PANEL: u32 = 230;
const NAME: u32 = 34;
const WIDTH: u32 = 1120;
/// What dots are called, the longest name beside the panels.
const DOTS: &str = "by strains, element ends";
/// Names of the section forces.
const NAMES: [&str; 6] = ["n", "qy", "qz", "t", "my", "mz"];

/// One panel: what it shows, its unit, and which section forces; no forces for the stress.
type Panel = (&'static str, &'static str, &'static [usize]);
const PANELS: [Panel; 3] =
    [("force", "N", &[0, 1, 2]), ("moment", "N m", &[3, 4, 5]), ("von Mises stress", "MPa", &[])];

/// The diagram of one beam.
struct Diagram<'a> {
    name: &'a str,
    points: Vec<DiagramPoint>,
}

/// Writes the diagrams of all beams, or of those whose names fit one of the patterns: a plot (.svg) or a table (.csv). Returns how many
/// beams there are in it.
///
/// # Errors
/// No beam, no such beam, too many for a plot, another ending, or a file that cannot be written.
pub(in crate::cli) fn write(
    model: &Arc<Model>,
    found: &Equilibrium,
    file: &Path,
    patterns: &[String],
    title: &str,
) -> anyhow::Result<usize> {
    let ending = file.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
    let is_plot = match ending.as_deref() {
        Some("svg") => true,
        Some("csv") => false,
        _ => bail!("`--diagram {}`: its name ends in .svg (plot) or .csv (table)", file.display()),
    };
    let chosen = chosen(model, patterns)?;
    if is_plot && chosen.len() > MOST_BEAMS {
        bail!(
            "`--diagram {}`: {} beams are more than one plot shows, {MOST_BEAMS}: name some with `--beams`, or write a table (.csv)",
            file.display(),
            chosen.len()
        );
    }
    let points = diagrams(model, found, &chosen, STRETCHES).context("what the beams bear is not known")?;
    let of = |(index, points): (&usize, Vec<DiagramPoint>)| Diagram { name: &model.beams[*index].name, points };
    let diagrams: Vec<Diagram<'_>> = chosen.iter().zip(points).map(of).collect();
    let text = if is_plot { plot(&diagrams, title)? } else { table(&diagrams) };
    output::save(file, text.as_bytes())?;
    Ok(chosen.len())
}

/// Indices of the beams that are asked for.
fn chosen(model: &Model, patterns: &[String]) -> anyhow::Result<Vec<usize>> {
    ensure!(!model.beams.is_empty(), "`--diagram`: the scene has neither beams nor cables");
    let names = || model.beams.iter().map(|beam| beam.name.as_str());
    if let Some(none) = patterns.iter().find(|pattern| !names().any(|name| fits(pattern, name))) {
        let near = closest(none, names()).map_or(String::new(), |near| format!(": did you mean `{near}`?"));
        bail!("`--beams {none}`: no beam or cable is called so{near}");
    }
    let is_meant = |name: &str| patterns.is_empty() || patterns.iter().any(|pattern| fits(pattern, name));
    Ok(names().enumerate().filter(|(_, name)| is_meant(name)).map(|(index, _)| index).collect())
}

/// One line a point: what the balance says, the stress, and what the strains say, empty if a strain is not free.
fn table(diagrams: &[Diagram<'_>]) -> String {
    let mut out = "beam,element,s (m),n (N),qy (N),qz (N),t (N m),my (N m),mz (N m),stress (Pa)".to_owned();
    for (name, unit) in NAMES.iter().zip(["N", "N", "N", "N m", "N m", "N m"]) {
        let _ = write!(out, ",{name} by strains ({unit})");
    }
    out.push('\n');
    let cell = |x: f64| if x.is_nan() { String::new() } else { exact(x) };
    for diagram in diagrams {
        // As CSV wants it (RFC 4180).
        let name = match diagram.name.contains([',', '"', '\n']) {
            true => format!("\"{}\"", diagram.name.replace('"', "\"\"")),
            false => diagram.name.to_owned(),
        };
        for point in &diagram.points {
            let section = &point.section;
            let _ = write!(out, "{name},{},{}", point.element + 1, exact(section.s));
            section.forces.iter().for_each(|x| out.extend([",", &cell(*x)]));
            out.extend([",", &section.stress.map_or(String::new(), |stress| exact(stress.von_mises))]);
            point.by_strains.iter().for_each(|x| out.extend([",", &cell(*x)]));
            out.push('\n');
        }
    }
    out
}

/// What of a panel is not zero, as curves: by the balance, and dots by the strains at the ends of elements.
struct Curve {
    name: &'static str,
    line: Vec<(f64, f64)>,
    dots: Vec<(f64, f64)>,
}

impl Diagram<'_> {
    fn curves(&self, (name, _, forces): Panel) -> Vec<Curve> {
        if forces.is_empty() {
            let megapascal = |point: &DiagramPoint| Some((point.section.s, point.section.stress?.von_mises * 1e-6));
            let line: Vec<(f64, f64)> = self.points.iter().filter_map(megapascal).collect();
            return if line.is_empty() { Vec::new() } else { vec![Curve { name, line, dots: Vec::new() }] };
        }
        let size = |index: usize| self.points.iter().map(|point| point.section.forces[index].abs()).fold(0.0, f64::max);
        let length = self.points.last().map_or(0.0, |point| point.section.s);
        // Round-off of all forces and moments, as forces.
        let all = (0..6).map(|index| if index < 3 { size(index) } else { size(index) / length }).fold(0.0, f64::max);
        let noise = |index: usize| SHOWN.of(1.0).sqrt() * all * if index < 3 { 1.0 } else { length };
        let curve = |index: &usize| {
            let line =
                self.points.iter().map(|point| (point.section.s, without_noise(point.section.forces[*index], all)));
            let is_end = |k: &usize| k.is_multiple_of(STRETCHES + 1) || k % (STRETCHES + 1) == STRETCHES;
            let ends = (0..self.points.len()).filter(is_end).map(|k| &self.points[k]);
            let dots = ends.map(|point| (point.section.s, point.by_strains[*index])).filter(|(_, x)| x.is_finite());
            Curve { name: NAMES[*index], line: line.collect(), dots: dots.collect() }
        };
        forces.iter().filter(|index| size(**index) > noise(**index)).map(curve).collect()
    }
}

/// For each beam a panel of forces, one of moments, and one of the stress.
fn plot(diagrams: &[Diagram<'_>], title: &str) -> anyhow::Result<String> {
    let blocks: Vec<Vec<(Panel, Vec<Curve>)>> = diagrams
        .iter()
        .map(|diagram| {
            PANELS.map(|panel| (panel, diagram.curves(panel))).into_iter().filter(|(_, all)| !all.is_empty())
        })
        .map(Iterator::collect)
        .collect();
    let heights = blocks.iter().map(|panels| NAME + PANEL * panels.len() as u32);
    let theme = Theme::default();
    frame::svg((WIDTH, frame::CAPTION + heights.sum::<u32>()), theme, |root| {
        let mut rest = frame::titled(root, theme, title)?;
        for (diagram, panels) in diagrams.iter().zip(&blocks) {
            let (head, below) = rest.split_vertically(px(NAME));
            let unloaded = if panels.is_empty() { ": bears nothing" } else { "" };
            let name = format!("{}{unloaded}", diagram.name);
            head.draw(&Text::new(name, (frame::at(12), frame::at(10)), frame::letters(theme, 18)))?;
            rest = below;
            for (panel, curves) in panels {
                let (area, below) = rest.split_vertically(px(PANEL));
                rest = below;
                draw(&area, *panel, curves, theme)?;
            }
        }
        Ok(())
    })
}

fn draw(area: &Area<'_>, (what, unit, _): Panel, curves: &[Curve], theme: Theme) -> anyhow::Result<()> {
    let (plane, mut legend) = frame::with_legend(area, theme, frame::legend_width([DOTS]));
    let all = || curves.iter().flat_map(|curve| curve.line.iter().chain(&curve.dots));
    let across = (0.0, all().map(|(s, _)| *s).fold(f64::MIN_POSITIVE, f64::max));
    // From or to zero: what a beam bears is seen by its size.
    let up = range(all().map(|(_, x)| *x).chain([0.0]));
    let up_name = with_unit(what, unit);
    let axes: [frame::Axis<'_>; 2] = [("s (m)", &|x| tick(*x, across)), (&up_name, &|y| tick(*y, up))];
    let mut chart = frame::linear(&plane, theme, (across, up), axes)?;
    chart.draw_series(LineSeries::new([(across.0, 0.0), (across.1, 0.0)], theme.ink().mix(0.5).stroke_width(px(1))))?;
    let mut has_dots = false;
    for (index, curve) in curves.iter().enumerate() {
        let style = theme.color(index).0.stroke_width(px(17) / 10);
        chart.draw_series(LineSeries::new(curve.line.iter().copied(), style))?;
        let dot = |at: &(f64, f64)| Circle::new(*at, frame::at(3), theme.color(index).0.filled());
        chart.draw_series(curve.dots.iter().map(dot))?;
        has_dots |= !curve.dots.is_empty();
        legend.line(curve.name, style, None)?;
    }
    if has_dots {
        let sample =
            |(x, y): (i32, i32)| Circle::new((x + frame::at(14), y), frame::at(3), theme.ink().filled()).into_dyn();
        legend.entry(DOTS, sample)?;
    }
    Ok(())
}
