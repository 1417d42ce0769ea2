//! What plots of curves over two axes have in common: an SVG at fractions of a pixel, axes with a quiet grid, names beside the curves.

mod decades;

use super::palette::Theme;
pub(super) use decades::Decades;
use plotters::coord::ranged1d::{BoldPoints, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::coord::{Shift, cartesian::Cartesian2d};
use plotters::element::{DashedPathElement, DynElement, IntoDynElement};
use plotters::prelude::*;
use plotters::style::TextStyle;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// The library draws on whole points: this many of them are a pixel.
const FINE: u32 = 10;
/// Width and height of most plots (pixels).
pub(super) const SIZE: (u32, u32) = (1120, 640);
/// Room for a title above the curves (pixels).
pub(super) const CAPTION: u32 = 44;
/// Room for the names right of the curves, at least and at most (pixels).
const LEGEND: [u32; 2] = [80, 420];
/// Height of a line of the legend, and of its letters (pixels).
pub(super) const ROW: u32 = 20;
const LETTERS: u32 = 14;
/// Where a name begins in the legend, after its sample, and what stays free behind it (pixels).
const NAME: i32 = 36;
const BEHIND: u32 = 12;

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

/// Writes the title of a drawing; what is below it.
///
/// # Errors
/// If the drawing library fails.
pub(super) fn titled<'a>(root: &Area<'a>, theme: Theme, title: &str) -> anyhow::Result<Area<'a>> {
    let (head, below) = root.split_vertically(px(CAPTION));
    let (width, height) = head.dim_in_pixel();
    let style = letters(theme, 22).pos(Pos::new(HPos::Center, VPos::Center));
    head.draw(&Text::new(title.to_owned(), (width as i32 / 2, height as i32 / 2), style))?;
    Ok(below)
}

/// Room for names right of the curves (pixels).
pub(super) fn legend_width<'n>(names: impl IntoIterator<Item = &'n str>) -> u32 {
    NAME as u32 + names.into_iter().map(text_width).fold(0, u32::max).clamp(LEGEND[0], LEGEND[1]) + BEHIND
}

/// How wide a name of a legend is at most (pixels): the letters of most fonts take less than 0.6 of their height.
pub(super) fn text_width(text: &str) -> u32 {
    (text.chars().count() as u32 * LETTERS * 3).div_ceil(5)
}

/// An area for curves, and one of this width (pixels) for the names beside them.
pub(super) fn with_legend<'a>(area: &Area<'a>, theme: Theme, width: u32) -> (Area<'a>, Legend<'a>) {
    let (curves, names) = area.split_horizontally(area.dim_in_pixel().0 - px(width));
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
        self.area.draw(&Text::new(
            name.to_owned(),
            (at(NAME), y - at(LETTERS as i32 / 2)),
            letters(self.theme, LETTERS),
        ))?;
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
    (across, up): ((f64, f64), (f64, f64)),
    axes: [Axis<'_>; 2],
) -> anyhow::Result<Chart<'a, RangedCoordf64>> {
    over(root, theme, (across.0..across.1).into(), (up.0..up.1).into(), axes)
}

/// Numbers at an axis, as many as the library writes at most, and the width of a letter of them (pixels).
const NUMBERS: usize = 11;
const LETTER: u32 = 9;

/// Two logarithmic axes over whole decades.
///
/// # Errors
/// If the drawing library fails.
pub(super) fn logarithmic<'a>(
    root: &Area<'a>,
    theme: Theme,
    points: impl Iterator<Item = (f64, f64)> + Clone,
    names: [&str; 2],
) -> anyhow::Result<Chart<'a, Decades>> {
    let (across, up) = (Decades::around(points.clone().map(|(x, _)| x)), Decades::around(points.map(|(_, y)| y)));
    over(root, theme, across, up, names.map(|name| (name, &Decades::tick as _)))
}

/// Room for the longest number at an upright axis and for what it is called; none without a name.
pub(super) fn beside<Y: Ranged<ValueType = f64>>(y: &Y, (name, number): Axis<'_>) -> u32 {
    let longest = y.key_points(BoldPoints(NUMBERS)).iter().map(|at| number(at).chars().count()).max().unwrap_or(0);
    if name.is_empty() { 0 } else { px(86).max(px(LETTER * longest as u32 + 30)) }
}

/// Axes of any kind. One without a name has no numbers, and needs no room for them.
///
/// # Errors
/// If the drawing library fails.
pub(super) fn over<'a, X, Y>(
    root: &Area<'a>,
    theme: Theme,
    x: X,
    y: Y,
    axes: [Axis<'_>; 2],
) -> anyhow::Result<Chart<'a, X, Y>>
where
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let mut builder = ChartBuilder::on(root);
    let below = if axes[0].0.is_empty() { 0 } else { px(46) };
    builder.margin(px(12)).x_label_area_size(below).y_label_area_size(beside(&y, axes[1]));
    let mut chart = builder.build_cartesian_2d(x, y)?;
    grid(&mut chart, theme, axes)?;
    Ok(chart)
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

#[cfg(test)]
mod tests {
    use super::{LEGEND, legend_width};

    #[test]
    fn legends_are_as_wide_as_their_names() {
        assert!(legend_width(["a", "kinetic (J)"]) < legend_width(["a", "the energy of all springs (J)"]));
        assert!(legend_width([]) > LEGEND[0] && legend_width([&*"x".repeat(200)]) < LEGEND[1] + 60);
    }
}
