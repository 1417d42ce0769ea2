//! What plots of curves over two axes have in common: an SVG at fractions of a pixel, axes with a quiet grid, names beside the curves.

use super::palette::Theme;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::coord::{Shift, cartesian::Cartesian2d, combinators::LogCoord};
use plotters::element::{DashedPathElement, DynElement, IntoDynElement};
use plotters::prelude::*;
use plotters::style::TextStyle;

/// The library draws on whole points: this many of them are a pixel.
const FINE: u32 = 10;
/// Width and height of most plots (pixels).
pub(super) const SIZE: (u32, u32) = (1120, 640);
/// Room for the names right of the curves (pixels).
pub(super) const LEGEND: u32 = 280;
/// Height of a line of the legend (pixels).
pub(super) const ROW: u32 = 20;

/// The whole drawing.
pub(super) type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Curves over axes `X` and `Y`.
pub(super) type Chart<'a, X, Y = X> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<X, Y>>;

/// What is drawn at a point.
pub(super) type Element<'a> = DynElement<'a, SVGBackend<'a>, (i32, i32)>;

/// What is written at one axis: its name, and how a number on it.
pub(super) type Axis<'a> = (&'a str, &'a dyn Fn(&f64) -> String);

/// So many points of the library are these pixels.
pub(super) const fn px(pixels: u32) -> u32 {
    pixels * FINE
}

/// As [`px`], along an axis.
pub(super) const fn at(pixels: i32) -> i32 {
    pixels * FINE as i32
}

/// Letters so high (pixels).
pub(super) fn letters(theme: Theme, height: u32) -> TextStyle<'static> {
    ("sans-serif", px(height)).into_font().color(&theme.ink())
}

/// A drawing of its own as SVG, of this size (pixels).
///
/// # Errors
/// If the drawing library fails.
pub(super) fn svg(
    size: (u32, u32),
    theme: Theme,
    draw: impl FnOnce(&Area<'_>) -> anyhow::Result<()>,
) -> anyhow::Result<String> {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (px(size.0), px(size.1))).into_drawing_area();
        root.fill(&theme.paper())?;
        draw(&root)?;
        root.present()?;
    }
    // XML has no other letters below the space, and names may have any.
    text.retain(|letter| letter >= ' ' || matches!(letter, '\t' | '\n' | '\r'));
    // As large as it is meant; the points stay.
    let edges = |width: u32, height: u32| format!("width=\"{width}\" height=\"{height}\"");
    Ok(text.replacen(&edges(px(size.0), px(size.1)), &edges(size.0, size.1), 1))
}

/// An area for curves, and the names beside them.
pub(super) fn with_legend<'a>(area: &Area<'a>, theme: Theme) -> (Area<'a>, Legend<'a>) {
    let (curves, names) = area.split_horizontally(area.dim_in_pixel().0 - px(LEGEND));
    (curves, Legend { area: names, theme, row: 0 })
}

/// The names of curves, one below the other, each after a sample.
pub(super) struct Legend<'a> {
    area: Area<'a>,
    theme: Theme,
    row: i32,
}

impl<'a> Legend<'a> {
    /// One more; `sample` is what it is drawn like, from a point on, in a width of 28 pixels.
    ///
    /// # Errors
    /// If the drawing library fails.
    pub(super) fn entry(&mut self, name: &str, sample: impl FnOnce((i32, i32)) -> Element<'a>) -> anyhow::Result<()> {
        let y = at(24) + at(ROW as i32) * self.row;
        self.row += 1;
        self.area.draw(&sample((0, y)))?;
        self.area.draw(&Text::new(name.to_owned(), (at(36), y - at(7)), letters(self.theme, 14)))?;
        Ok(())
    }

    /// A curve that is a line, in dashes if they are given (length and gap, pixels).
    ///
    /// # Errors
    /// If the drawing library fails.
    pub(super) fn line(&mut self, name: &str, style: ShapeStyle, dashes: Option<(i32, i32)>) -> anyhow::Result<()> {
        let (dash, gap) = dashes.unwrap_or((28, 1));
        self.entry(name, |(x, y)| {
            DashedPathElement::new([(x, y), (x + at(28), y)], at(dash), at(gap), style).into_dyn()
        })
    }
}

/// Two linear axes.
///
/// # Errors
/// If the drawing library fails.
pub(super) fn linear<'a>(
    root: &Area<'a>,
    theme: Theme,
    title: &str,
    (across, up): ((f64, f64), (f64, f64)),
    axes: [Axis<'_>; 2],
) -> anyhow::Result<Chart<'a, RangedCoordf64>> {
    let mut chart = builder(root, theme, title).build_cartesian_2d(across.0..across.1, up.0..up.1)?;
    grid(&mut chart, theme, axes)?;
    Ok(chart)
}

/// Two logarithmic axes over whole decades.
///
/// # Errors
/// If the drawing library fails.
pub(super) fn logarithmic<'a>(
    root: &Area<'a>,
    theme: Theme,
    title: &str,
    points: impl Iterator<Item = (f64, f64)> + Clone,
    names: [&str; 2],
) -> anyhow::Result<Chart<'a, LogCoord<f64>>> {
    let (across, up) = (decades(points.clone().map(|(x, _)| x)), decades(points.map(|(_, y)| y)));
    let mut chart =
        builder(root, theme, title).build_cartesian_2d((across.0..across.1).log_scale(), (up.0..up.1).log_scale())?;
    grid(&mut chart, theme, names.map(|name| (name, &(|x: &f64| format!("{x:.0e}")) as _)))?;
    Ok(chart)
}

fn builder<'a, 'b>(root: &'b Area<'a>, theme: Theme, title: &str) -> ChartBuilder<'b, 'static, SVGBackend<'a>> {
    let mut builder = ChartBuilder::on(root);
    builder.margin(px(12)).x_label_area_size(px(46)).y_label_area_size(px(86));
    if !title.is_empty() {
        builder.caption(title, letters(theme, 22));
    }
    builder
}

fn grid<X, Y>(chart: &mut Chart<'_, X, Y>, theme: Theme, [across, up]: [Axis<'_>; 2]) -> anyhow::Result<()>
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let ink = theme.ink();
    chart
        .configure_mesh()
        .x_desc(across.0)
        .y_desc(up.0)
        .x_label_formatter(across.1)
        .y_label_formatter(up.1)
        .label_style(letters(theme, 15))
        .axis_desc_style(letters(theme, 16))
        .set_all_tick_mark_size(px(5))
        .axis_style(ink.mix(0.6).stroke_width(px(1)))
        .bold_line_style(ink.mix(0.12).stroke_width(px(1)))
        .light_line_style(TRANSPARENT)
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
