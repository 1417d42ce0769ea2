//! The frequency response as a plot: sizes above, phases below, over frequency.

use super::super::frame::{self, Area};
use super::super::palette::Theme;
use crate::linear::{Mat, StateSpace, c64};
use anyhow::bail;
use plotters::prelude::*;
use std::f64::consts::TAU;

/// Points over the range, and how far it reaches beyond the eigenvalues (decades).
const POINTS: usize = 600;
const BEYOND: f64 = 1.0;
/// Curves that can be distinguished.
const MOST: usize = 24;

/// One pair of input and output: size and phase at each frequency.
struct Curve {
    name: String,
    /// Frequency (Hz), size, phase (degrees).
    points: Vec<[f64; 3]>,
}

/// As SVG.
///
/// # Errors
/// Without inputs or outputs, and if the drawing library gives up.
pub(super) fn draw(found: &StateSpace, title: &str, theme: Theme) -> anyhow::Result<String> {
    let pairs = found.inputs.len() * found.outputs.len();
    if pairs == 0 {
        bail!("a Bode plot needs an input and an output: name them with `--input` and `--output`");
    }
    if pairs > MOST {
        bail!("{pairs} curves are more than {MOST}: choose with `--input` and `--output`");
    }
    let curves = curves(found);
    frame::svg(frame::SIZE, theme, |root| {
        let (above, below) = root.split_vertically(root.dim_in_pixel().1 * 3 / 5);
        sizes(&above, theme, &curves, &format!("{title}: frequency response"))?;
        phases(&below, theme, &curves)
    })
}

fn curves(found: &StateSpace) -> Vec<Curve> {
    let sizes = || found.eigenvalues().into_iter().map(|[re, im]| re.hypot(im) / TAU).filter(|x| *x > 1e-9);
    let (low, high) = sizes().fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
    let (low, high) = if high > 0.0 { (low.log10() - BEYOND, high.log10() + BEYOND) } else { (-1.0, 2.0) };
    let frequency = |k: usize| 10.0_f64.powf(low + (high - low) * k as f64 / (POINTS - 1) as f64);
    let responses: Vec<_> = (0..POINTS).map(|k| (frequency(k), found.response(TAU * frequency(k)))).collect();
    let mut curves = Vec::new();
    for (j, input) in found.inputs.iter().enumerate() {
        for (i, output) in found.outputs.iter().enumerate() {
            let mut before: Option<f64> = None;
            let mut point = |(frequency, response): &(f64, Mat<c64>)| {
                let x = response[(i, j)];
                let mut phase = x.im.atan2(x.re).to_degrees();
                // Without jumps by a whole turn.
                if let Some(before) = before {
                    phase -= 360.0 * ((phase - before) / 360.0).round();
                }
                before = Some(phase);
                [*frequency, x.re.hypot(x.im), phase]
            };
            let points = responses.iter().map(&mut point).filter(|point| point.iter().all(|x| x.is_finite())).collect();
            let units = format!("{}/({})", output.unit, input.unit);
            curves.push(Curve { name: format!("{} by {} [{units}]", output.name, input.name), points });
        }
    }
    curves
}

fn sizes(area: &Area<'_>, theme: Theme, curves: &[Curve], title: &str) -> anyhow::Result<()> {
    let all = curves.iter().flat_map(|curve| curve.points.iter().map(|[f, size, _]| (*f, *size)));
    let all = all.filter(|(_, size)| *size > 0.0);
    let (area, mut legend) = frame::with_legend(area, theme);
    let mut chart = frame::logarithmic(&area, theme, title, all, ["frequency (Hz)", "size"])?;
    for (Curve { name, points }, color) in curves.iter().zip(theme.colors()) {
        let style = color.stroke_width(frame::px(2));
        let line = points.iter().filter(|[_, size, _]| *size > 0.0).map(|[f, size, _]| (*f, *size));
        chart.draw_series(LineSeries::new(line, style))?;
        legend.line(name, style, None)?;
    }
    Ok(())
}

fn phases(area: &Area<'_>, theme: Theme, curves: &[Curve]) -> anyhow::Result<()> {
    let all = || curves.iter().flat_map(|curve| &curve.points);
    let span =
        |of: usize| all().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x[of]), high.max(x[of])));
    let (across, up) = (span(0), span(2));
    let across = (across.0.log10(), across.1.log10());
    let up = ((up.0 / 90.0).floor() * 90.0, (up.1 / 90.0).ceil().max((up.0 / 90.0).floor() + 1.0) * 90.0);
    let hertz = |x: &f64| format!("{:.0e}", 10.0_f64.powf(*x));
    let degrees = |y: &f64| format!("{y:.0}");
    let axes: [frame::Axis<'_>; 2] = [("frequency (Hz)", &hertz), ("phase (degrees)", &degrees)];
    let (area, _) = frame::with_legend(area, theme);
    let mut chart = frame::linear(&area, theme, "", (across, up), axes)?;
    for (curve, color) in curves.iter().zip(theme.colors()) {
        let line = curve.points.iter().map(|[f, _, phase]| (f.log10(), *phase));
        chart.draw_series(LineSeries::new(line, color.stroke_width(frame::px(2))))?;
    }
    Ok(())
}
