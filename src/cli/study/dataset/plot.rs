//! One column of a study: histogram, course over the input that matters most, and a tornado of what the inputs do.

use super::super::super::frame::{self, Area};
use super::super::super::palette::{BLUE, Theme, VERMILION, range, tick};
use super::super::super::plot::draw::with_unit;
use super::{MOST_INPUTS, Output, Study};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// Bars of the histogram.
const BARS: usize = 40;
/// Points that are drawn: of more, every n-th.
const MOST_POINTS: u64 = 3000;
/// Room for names left of bars (pixels).
const MOST_NAME: u32 = 260;

/// As SVG.
///
/// # Errors
/// If the dataset cannot be read, or the drawing library gives up.
pub(super) fn draw(study: &Study, output: &Output, theme: Theme) -> anyhow::Result<String> {
    let last = study.inputs.len();
    let ends = output.moments.ends[last];
    let effects = output.ranked();
    let first = effects.first().map(|(effect, _)| effect.input);
    let (mut bars, mut points, mut row) = (vec![0_u64; BARS], Vec::new(), 0_u64);
    let width = (ends.1 - ends.0) / BARS as f64;
    let every = output.moments.count.div_ceil(MOST_POINTS);
    study.answered(&output.name, &mut |cells| {
        let place = ((cells[last] - ends.0) / width) as usize;
        bars[place.min(BARS - 1)] += 1;
        if let Some(first) = first.filter(|_| row.is_multiple_of(every)) {
            points.push((cells[first], cells[last]));
        }
        row += 1;
    })?;
    let name = with_unit(&output.name, &output.unit);
    frame::svg(frame::SIZE, theme, |root| {
        let (above, below) = root.split_vertically(root.dim_in_pixel().1 / 2);
        histogram(&above, theme, &name, ends, &bars)?;
        let (left, right) = below.split_horizontally(root.dim_in_pixel().0 / 2);
        if let Some(first) = first {
            let input = &study.inputs[first];
            let words = first.checked_sub(study.numbers).map(|index| &study.reader.words[index].all);
            let words = words.map(|all| {
                let named = all.iter().enumerate().map(|(place, word)| format!("{place} {word}"));
                format!("{input}: {}", named.collect::<Vec<_>>().join(", "))
            });
            let unit = study.reader.numbers.iter().find(|(other, _)| other == input).map_or("", |(_, unit)| unit);
            let across = words.unwrap_or_else(|| with_unit(input, unit));
            scatter(&left, theme, [&across, &name], &points)?;
        }
        let alone = output.ranks_alone();
        let effects: Vec<(&str, f64, f64)> = effects
            .iter()
            .take(MOST_INPUTS)
            .map(|(effect, index)| match index.filter(|_| alone) {
                Some(index) => (effect.input, index.index, index.confidence),
                None => (effect.input, effect.coefficient, effect.confidence),
            })
            .map(|(input, bar, confidence)| (study.inputs[input].as_str(), bar, confidence))
            .collect();
        let quantity = if alone { "first-order Sobol index" } else { "standardized regression coefficient" };
        tornado(&right, theme, quantity, &effects)
    })
}

fn histogram(area: &Area<'_>, theme: Theme, name: &str, ends: (f64, f64), bars: &[u64]) -> anyhow::Result<()> {
    let area = frame::titled(area, theme, "distribution")?;
    let (across, most) = (range([ends.0, ends.1].into_iter()), bars.iter().copied().max().unwrap_or(1) as f64);
    let up = (0.0, 1.05 * most);
    let axes: [frame::Axis<'_>; 2] = [(name, &|x| tick(*x, across)), ("cases", &|y| tick(*y, up))];
    let mut chart = frame::linear(&area, theme, (across, up), axes)?;
    let width = (ends.1 - ends.0) / bars.len() as f64;
    let bar = |(index, cases): (usize, &u64)| {
        let left = ends.0 + index as f64 * width;
        Rectangle::new([(left, 0.0), (left + width, *cases as f64)], theme.shown(BLUE).mix(0.7).filled())
    };
    chart.draw_series(bars.iter().enumerate().map(bar))?;
    Ok(())
}

fn scatter(area: &Area<'_>, theme: Theme, names: [&str; 2], points: &[(f64, f64)]) -> anyhow::Result<()> {
    let area = frame::titled(area, theme, "what matters most")?;
    let (across, up) = (range(points.iter().map(|point| point.0)), range(points.iter().map(|point| point.1)));
    let axes: [frame::Axis<'_>; 2] = [(names[0], &|x| tick(*x, across)), (names[1], &|y| tick(*y, up))];
    let mut chart = frame::linear(&area, theme, (across, up), axes)?;
    chart.draw_series(
        points.iter().map(|point| Circle::new(*point, frame::at(2), theme.shown(BLUE).mix(0.4).filled())),
    )?;
    Ok(())
}

/// Bars of the inputs, the largest on top, with their confidence intervals, the names left of them.
fn tornado(area: &Area<'_>, theme: Theme, quantity: &str, effects: &[(&str, f64, f64)]) -> anyhow::Result<()> {
    let area = frame::titled(area, theme, "what every input does")?;
    let room = effects.iter().map(|(name, ..)| frame::text_width(name)).max().unwrap_or(0).min(MOST_NAME);
    let (names, bars) = area.split_horizontally(frame::px(room));
    let ends =
        effects.iter().flat_map(|(_, coefficient, confidence)| [coefficient - confidence, coefficient + confidence]);
    let (across, up) = (range(ends.chain([0.0])), (-(effects.len().max(1) as f64), 0.0));
    let axes: [frame::Axis<'_>; 2] = [(quantity, &|x| tick(*x, across)), ("", &|_| String::new())];
    let mut chart = frame::linear(&bars, theme, (across, up), axes)?;
    let style = frame::letters(theme, 14).pos(Pos::new(HPos::Right, VPos::Center));
    for (index, (name, coefficient, confidence)) in effects.iter().enumerate() {
        let y = -(index as f64);
        let color = theme.shown(if *coefficient < 0.0 { VERMILION } else { BLUE });
        chart.draw_series([Rectangle::new([(0.0, y - 0.15), (*coefficient, y - 0.85)], color.mix(0.7).filled())])?;
        let interval = [(coefficient - confidence, y - 0.5), (coefficient + confidence, y - 0.5)];
        chart.draw_series([PathElement::new(interval, theme.ink().stroke_width(frame::px(2)))])?;
        let middle = chart.backend_coord(&(0.0, y - 0.5)).1 - names.get_base_pixel().1;
        names.draw(&Text::new((*name).to_owned(), (frame::at(room as i32), middle), style.clone()))?;
    }
    Ok(())
}
