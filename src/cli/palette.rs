//! What plots have in common: colours readable on white and by the colour-blind (Okabe and Ito), and axes.

use super::text;
use plotters::style::RGBColor;

pub(super) const BLUE: RGBColor = RGBColor(0, 114, 178);
pub(super) const VERMILION: RGBColor = RGBColor(213, 94, 0);
pub(super) const GREEN: RGBColor = RGBColor(0, 158, 115);
pub(super) const PURPLE: RGBColor = RGBColor(204, 121, 167);

/// For many lines, without yellow.
pub(super) const COLORS: [RGBColor; 9] = [
    BLUE,
    VERMILION,
    GREEN,
    PURPLE,
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
    RGBColor(230, 159, 0),
    RGBColor(120, 120, 120),
    RGBColor(140, 80, 20),
];

/// A number at an axis: no minus before a zero.
pub(super) fn tick(x: f64, range: (f64, f64)) -> String {
    text::number(text::without_noise(x, range.1 - range.0))
}

/// The range of numbers with some room around it.
pub(super) fn range(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let room = 0.05 * (high - low);
    let room = if room > 0.0 { room } else { 1e-3 * high.abs().max(1.0) };
    (low - room, high + room)
}
