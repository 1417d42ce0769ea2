//! What plots have in common: colours that the colour-blind tell apart (Okabe and Ito), on light and on dark paper, and axes.

use super::number::{number_to, without_noise};
use clap::ValueEnum;
use plotters::style::RGBColor;

pub(super) const BLUE: RGBColor = RGBColor(0, 114, 178);
pub(super) const VERMILION: RGBColor = RGBColor(213, 94, 0);
pub(super) const GREEN: RGBColor = RGBColor(0, 158, 115);
pub(super) const PURPLE: RGBColor = RGBColor(204, 121, 167);

/// For many lines, without yellow.
const COLORS: [RGBColor; 9] = [
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

/// Paper and ink of a plot.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(super) enum Theme {
    /// Dark on white
    #[default]
    Light,
    /// Light on nearly black
    Dark,
}

impl Theme {
    pub(super) fn paper(self) -> RGBColor {
        match self {
            Self::Light => RGBColor(255, 255, 255),
            Self::Dark => RGBColor(24, 26, 31),
        }
    }

    pub(super) fn ink(self) -> RGBColor {
        match self {
            Self::Light => RGBColor(0, 0, 0),
            Self::Dark => RGBColor(228, 230, 235),
        }
    }

    /// A colour as it is read on this paper: lighter on dark one.
    pub(super) fn shown(self, color: RGBColor) -> RGBColor {
        let lighter = |part: u8| part + (255 - part) / 3;
        match (self, color) {
            (Self::Light, _) => color,
            (Self::Dark, RGBColor(0, 0, 0)) => self.ink(),
            (Self::Dark, RGBColor(red, green, blue)) => RGBColor(lighter(red), lighter(green), lighter(blue)),
        }
    }

    /// The colours of many lines, over and over.
    pub(super) fn colors(self) -> impl Iterator<Item = RGBColor> {
        COLORS.into_iter().cycle().map(move |color| self.shown(color))
    }

    /// The colour of a line among many, and how many lines before it have that colour.
    pub(super) fn color(self, line: usize) -> (RGBColor, usize) {
        (self.shown(COLORS[line % COLORS.len()]), line / COLORS.len())
    }
}

/// A number at an axis: no minus before a zero, and so many digits that a hundredth of the axis is seen.
pub(super) fn tick(x: f64, range: (f64, f64)) -> String {
    let length = range.1 - range.0;
    let digits = (x.abs() / length).log10().floor() + 3.0;
    number_to(without_noise(x, length), if digits > 0.0 { digits.min(MOST_DIGITS) as usize } else { 0 })
}

/// Digits that a number has at most.
const MOST_DIGITS: f64 = 17.0;

/// Numbers that differ by less than this part of themselves are a flat line: what is left of an equilibrium after many steps, with more digits
/// at its axis than there is room for.
const FLAT: f64 = 5e-10;

/// The range of numbers with some room around it.
pub(super) fn range(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    let room = 0.05 * (high - low);
    let room = if room > 0.05 * FLAT * high.abs().max(low.abs()) { room } else { 1e-3 * high.abs().max(1.0) };
    (low - room, high + room)
}

#[cfg(test)]
mod tests {
    use super::{COLORS, RGBColor, Theme, range, tick};

    #[test]
    fn round_off_is_a_flat_line_and_ticks_differ() {
        let (low, high) = range([0.6, 0.6 + 1e-10, 0.6 - 1e-10].into_iter());
        assert!(high - low > 1e-3 && (0.5 * (low + high) - 0.6).abs() < 1e-12, "{low} {high}");
        assert_eq!(range([0.0; 3].into_iter()), (-1e-3, 1e-3));
        for size in [1e-9, 1e-6, 1e-3, 0.1, 1.0, 30.0] {
            let range = range([0.6, 0.6 + size].into_iter());
            let at = |k: usize| tick(range.0 + 0.1 * k as f64 * (range.1 - range.0), range);
            for k in 0..10 {
                assert_ne!(at(k), at(k + 1), "{size}: {range:?}");
            }
        }
        assert_eq!(tick(1e-17, (-1.0, 1.0)), "0");
        assert_eq!(tick(-0.5, (-1.0, 1.0)), "-0.5");
    }

    /// Relative luminance (WCAG 2).
    fn luminance(RGBColor(red, green, blue): RGBColor) -> f64 {
        let linear = |part: u8| {
            let part = f64::from(part) / 255.0;
            if part <= 0.04045 { part / 12.92 } else { ((part + 0.055) / 1.055).powf(2.4) }
        };
        0.2126 * linear(red) + 0.7152 * linear(green) + 0.0722 * linear(blue)
    }

    #[test]
    fn lines_stand_out_from_the_paper() {
        for theme in [Theme::Light, Theme::Dark] {
            let contrast = |color| {
                let [a, b] = [luminance(color), luminance(theme.paper())];
                (a.max(b) + 0.05) / (a.min(b) + 0.05)
            };
            assert!(contrast(theme.ink()) > 12.0);
            // The lightest of Okabe and Ito on white have 2.2.
            for color in COLORS {
                assert!(contrast(theme.shown(color)) > 2.1, "{theme:?} {color:?}");
            }
        }
    }
}
