//! Colours of beams by what they bear.

use super::place::Place;
use super::sweep::Sweep;
use super::{Drawing, Tubes};

/// What the colours mean: the darkest is the largest.
#[derive(Debug, Clone, PartialEq)]
pub struct Legend {
    /// What is shown.
    pub what: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// At the darkest colour, in that unit; the lightest is zero.
    pub most: f64,
    /// Significant digits that are shown of it.
    pub digits: usize,
}

/// From nothing to the most: grey as steel, amber, red, dark. Lightness falls throughout, so that they are told from each other
/// without seeing colours.
const COLORS: [[f64; 3]; 5] =
    [[0.82, 0.85, 0.89], [0.96, 0.76, 0.38], [0.93, 0.52, 0.20], [0.80, 0.21, 0.16], [0.44, 0.04, 0.16]];

/// The colour of a part 0 … 1 of the most.
pub fn shade(part: f64) -> [f64; 3] {
    let place = if part.is_finite() { part.clamp(0.0, 1.0) } else { 0.0 } * (COLORS.len() - 1) as f64;
    let from = (place as usize).min(COLORS.len() - 2);
    let within = place - from as f64;
    std::array::from_fn(|k| COLORS[from][k] + within * (COLORS[from + 1][k] - COLORS[from][k]))
}

impl Legend {
    /// Of what [`Tubes::loads`] says, which is at most this much; `None` if beams bear nothing.
    pub fn new(tubes: &Tubes, most: f64, digits: usize) -> Option<Self> {
        let (what, unit, factor) = match tubes.show_stress() {
            true => ("von Mises stress", "MPa", 1e-6),
            false => ("moment", "N m", 1.0),
        };
        (most > 0.0 && most.is_finite()).then_some(Self { what, unit, most: most * factor, digits })
    }

    /// The largest value.
    pub fn number(&self) -> String {
        let last = self.digits.saturating_sub(1);
        let rounded = format!("{:.last$e}", self.most);
        let size = rounded.split_once('e').and_then(|(_, size)| size.parse::<i32>().ok());
        match size.filter(|size| (-3..=last as i32).contains(size)) {
            Some(size) => format!("{:.*}", (last as i32 - size) as usize, self.most),
            None => rounded,
        }
    }
}

impl Drawing {
    /// How many cross sections of other beams there are before those of a beam.
    pub(in crate::record) fn rings_before(&self, sweep: &Sweep) -> usize {
        sweep.first - self.scene.bodies.len()
    }

    /// Colours the beams by what their cross sections bear, as [`Tubes::loads`] says; `most` has the darkest colour, and the legend shows so
    /// many digits of it. Nothing is coloured if nothing is borne.
    pub fn shaded(mut self, loads: &[f64], most: f64, digits: usize) -> Self {
        let tubes = Tubes::new(&self.scene);
        self.legend = Legend::new(&tubes, most, digits);
        if self.legend.is_none() {
            return self;
        }
        let mut loads = loads.iter();
        for part in &mut self.parts {
            if let Place::Swept { sweep, tints } = &mut part.place {
                *tints = loads.by_ref().take(sweep.rings()).map(|load| shade(load / most)).collect();
            }
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::{Legend, shade};

    /// Relative luminance of colours on a screen (WCAG 2).
    #[test]
    fn what_bears_more_is_darker() {
        let linear = |part: f64| if part <= 0.04045 { part / 12.92 } else { ((part + 0.055) / 1.055).powf(2.4) };
        let luminance = |part: f64| {
            let [r, g, b] = shade(part).map(linear);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for k in 0..100 {
            let (here, next) = (f64::from(k) / 100.0, f64::from(k + 1) / 100.0);
            assert!(luminance(next) < luminance(here) + 1e-12, "{here}");
        }
        assert_eq!(shade(f64::NAN), shade(0.0));
        assert_eq!(shade(7.0), shade(1.0));
    }

    #[test]
    fn legends_have_the_digits_that_are_asked_for() {
        let shown = |most: f64, digits: usize| Legend { what: "moment", unit: "N m", most, digits }.number();
        assert_eq!(
            [29_814.2, 162_835.0, 12.345, 999.97].map(|most| shown(most, 4)),
            ["2.981e4", "1.628e5", "12.35", "1000"]
        );
        assert_eq!([shown(29_814.2, 6), shown(0.012_345, 2), shown(3e-5, 1)], ["29814.2", "0.012", "3e-5"]);
    }
}
