//! What plots of curves over two axes have in common: an SVG, a caption, axes with grids, a legend.

use plotters::chart::SeriesLabelPosition;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::coord::{Shift, cartesian::Cartesian2d, combinators::LogCoord};
use plotters::prelude::*;

const SIZE: (u32, u32) = (960, 640);

/// The whole drawing.
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Curves over axes `X` and `Y`.
pub(super) type Chart<'a, X, Y = X> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<X, Y>>;

/// What is written at one axis: its name, and how a number on it.
pub(super) type Axis<'a> = (&'a str, &'a dyn Fn(&f64) -> String);

/// A drawing of its own as SVG.
///
/// # Errors
/// Where the drawing library gives up.
pub(super) fn svg(draw: impl FnOnce(&Area<'_>) -> anyhow::Result<()>) -> anyhow::Result<String> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        draw(&root)?;
        root.present()?;
    }
    Ok(text)
}

/// Two linear axes.
///
/// # Errors
/// Where the drawing library gives up.
pub(super) fn linear<'a>(
    root: &Area<'a>,
    title: &str,
    (across, up): ((f64, f64), (f64, f64)),
    axes: [Axis<'_>; 2],
) -> anyhow::Result<Chart<'a, RangedCoordf64>> {
    let mut chart = builder(root, title).build_cartesian_2d(across.0..across.1, up.0..up.1)?;
    grid(&mut chart, axes, [0.2, 0.05])?;
    Ok(chart)
}

/// Two logarithmic axes over whole decades.
///
/// # Errors
/// Where the drawing library gives up.
pub(super) fn logarithmic<'a>(
    root: &Area<'a>,
    title: &str,
    points: impl Iterator<Item = (f64, f64)> + Clone,
    names: [&str; 2],
) -> anyhow::Result<Chart<'a, LogCoord<f64>>> {
    let (across, up) = (decades(points.clone().map(|(x, _)| x)), decades(points.map(|(_, y)| y)));
    let mut chart =
        builder(root, title).build_cartesian_2d((across.0..across.1).log_scale(), (up.0..up.1).log_scale())?;
    grid(&mut chart, names.map(|name| (name, &(|x: &f64| format!("{x:.0e}")) as _)), [0.25, 0.07])?;
    Ok(chart)
}

fn builder<'a, 'b>(root: &'b Area<'a>, title: &str) -> ChartBuilder<'b, 'static, SVGBackend<'a>> {
    let mut builder = ChartBuilder::on(root);
    builder.caption(title, ("sans-serif", 22)).margin(16).x_label_area_size(52).y_label_area_size(78);
    builder
}

fn grid<X, Y>(chart: &mut Chart<'_, X, Y>, [across, up]: [Axis<'_>; 2], [bold, light]: [f64; 2]) -> anyhow::Result<()>
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    chart
        .configure_mesh()
        .x_desc(across.0)
        .y_desc(up.0)
        .x_label_formatter(across.1)
        .y_label_formatter(up.1)
        .label_style(("sans-serif", 15))
        .axis_desc_style(("sans-serif", 16))
        .bold_line_style(BLACK.mix(bold))
        .light_line_style(BLACK.mix(light))
        .draw()?;
    Ok(())
}

/// What the curves are called.
///
/// # Errors
/// Where the drawing library gives up.
pub(super) fn legend<X, Y>(chart: &mut Chart<'_, X, Y>, position: SeriesLabelPosition) -> anyhow::Result<()>
where
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    chart
        .configure_series_labels()
        .position(position)
        .legend_area_size(32)
        .margin(12)
        .label_font(("sans-serif", 16))
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.5))
        .draw()?;
    Ok(())
}

/// The range of whole decades around positive numbers.
fn decades(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = numbers.fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
    if !(low > 0.0 && high.is_finite()) {
        return (1.0, 10.0);
    }
    let (low, high) = (low.log10().floor(), high.log10().ceil());
    (10.0_f64.powf(low), 10.0_f64.powf(high.max(low + 1.0)))
}
