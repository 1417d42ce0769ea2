//! The frequency response as a plot: sizes above, phases below, over frequency.

use super::super::frame::{self, Area, Decades};
use super::super::palette::Theme;
use super::super::plot::draw::with_unit;
use crate::linear::{Mat, StateSpace, c64};
use anyhow::bail;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use std::f64::consts::TAU;

/// Points over the range, and how far it reaches beyond the eigenvalues (decades).
const POINTS: usize = 600;
const BEYOND: f64 = 1.0;
/// Curves that can be distinguished.
const MOST: usize = 24;

/// The curves of all pairs of an input and an output.
struct Responses {
    /// Lowest and highest frequency (Hz).
    range: (f64, f64),
    curves: Vec<Curve>,
}

/// One pair of input and output: size and phase at each frequency.
struct Curve {
    name: String,
    unit: String,
    /// Frequency (Hz), size, phase (degrees).
    points: Vec<[f64; 3]>,
}

impl Curve {
    fn label(&self) -> String {
        format!("{} [{}]", self.name, self.unit)
    }
}

/// As SVG.
///
/// # Errors
/// Without inputs or outputs, with more curves than can be distinguished, and if the drawing library gives up.
pub(super) fn draw(found: &StateSpace, title: &str, theme: Theme) -> anyhow::Result<String> {
    let pairs = found.inputs.len() * found.outputs.len();
    if pairs == 0 {
        bail!("a Bode plot needs an input and an output: name them with `--input` and `--output`");
    }
    if pairs > MOST {
        bail!("a Bode plot shows {MOST} curves at most, and these are {pairs}: choose with `--input` and `--output`");
    }
    let responses = responses(found);
    let labels: Vec<String> = responses.curves.iter().map(Curve::label).collect();
    let width = frame::legend_width(labels.iter().map(String::as_str));
    frame::svg(frame::SIZE, theme, |root| {
        let root = frame::titled(root, theme, &format!("{title}: frequency response"))?;
        let (above, below) = root.split_vertically(root.dim_in_pixel().1 * 3 / 5);
        let (above, mut legend) = frame::with_legend(&above, theme, width);
        let (below, _) = frame::with_legend(&below, theme, width);
        sizes(&above, theme, &responses)?;
        phases(&below, theme, &responses)?;
        for (label, color) in labels.iter().zip(theme.colors()) {
            legend.line(label, color.stroke_width(frame::px(2)), None)?;
        }
        Ok(())
    })
}

/// The unit of an output over that of an input.
pub(super) fn quotient(output: &str, input: &str) -> String {
    match input {
        "" | "1" => output.to_owned(),
        _ if input.contains(['/', ' ']) => format!("{output}/({input})"),
        _ => format!("{output}/{input}"),
    }
}

fn responses(found: &StateSpace) -> Responses {
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
            let (name, unit) = (format!("{} by {}", output.name, input.name), quotient(&output.unit, &input.unit));
            curves.push(Curve { name, unit, points });
        }
    }
    Responses { range: (frequency(0), frequency(POINTS - 1)), curves }
}

fn sizes(area: &Area<'_>, theme: Theme, Responses { range, curves }: &Responses) -> anyhow::Result<()> {
    let positive = |curve: &Curve| {
        curve.points.iter().filter(|[_, size, _]| *size > 0.0).map(|[f, size, _]| (*f, *size)).collect::<Vec<_>>()
    };
    let up = Decades::around(curves.iter().flat_map(positive).map(|(_, size)| size));
    let unit = &curves[0].unit;
    let name = match curves.iter().all(|curve| curve.unit == *unit) {
        true => with_unit("size", unit),
        false => "size (units differ: see the names)".to_owned(),
    };
    let axes: [frame::Axis<'_>; 2] = [("frequency (Hz)", &Decades::tick), (&name, &Decades::tick)];
    let mut chart = frame::over(area, theme, Decades::new(range.0, range.1), up, axes)?;
    for (curve, color) in curves.iter().zip(theme.colors()) {
        chart.draw_series(LineSeries::new(positive(curve), color.stroke_width(frame::px(2))))?;
    }
    Ok(())
}

fn phases(area: &Area<'_>, theme: Theme, Responses { range, curves }: &Responses) -> anyhow::Result<()> {
    let all = curves.iter().flat_map(|curve| &curve.points).map(|[_, _, phase]| *phase);
    let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let (low, high) = if low <= high { (low, high) } else { (0.0, 0.0) };
    let low = (low / 90.0).floor();
    let up: RangedCoordf64 = (90.0 * low..90.0 * (high / 90.0).ceil().max(low + 1.0)).into();
    let degrees = |y: &f64| format!("{y:.0}");
    let axes: [frame::Axis<'_>; 2] = [("frequency (Hz)", &Decades::tick), ("phase (degrees)", &degrees)];
    let mut chart = frame::over(area, theme, Decades::new(range.0, range.1), up, axes)?;
    for (curve, color) in curves.iter().zip(theme.colors()) {
        let line = curve.points.iter().map(|[f, _, phase]| (*f, *phase));
        chart.draw_series(LineSeries::new(line, color.stroke_width(frame::px(2))))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::quotient;

    #[test]
    fn units_of_responses_are_quotients() {
        assert_eq!(quotient("m", "N"), "m/N");
        assert_eq!(quotient("rad", "N m"), "rad/(N m)");
        assert_eq!(quotient("m", "m/s²"), "m/(m/s²)");
        assert_eq!(quotient("m", "1"), "m");
    }
}
