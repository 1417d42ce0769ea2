//! The work–precision plot.

use super::super::palette::COLORS;
use crate::integrate::Method;
use crate::simulate::precision::Study;
use plotters::prelude::*;

const SIZE: (u32, u32) = (960, 640);

/// What is drawn of one method.
struct Line {
    label: String,
    color: RGBColor,
    /// Time (s) and error.
    points: Vec<(f64, f64)>,
}

/// Error against time, both logarithmic, one line per method, as SVG; `None` where there is nothing to draw.
///
/// # Errors
/// Where the drawing library gives up.
pub(super) fn draw(study: &Study, title: &str) -> anyhow::Result<Option<String>> {
    let lines = lines(study);
    let all = || lines.iter().flat_map(|line| line.points.iter().copied());
    if all().next().is_none() {
        return Ok(None);
    }
    let (times, errors) = (decades(all().map(|(time, _)| time)), decades(all().map(|(_, error)| error)));
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&root)
            .caption(format!("{title}: error against time"), ("sans-serif", 22))
            .margin(16)
            .x_label_area_size(52)
            .y_label_area_size(78)
            .build_cartesian_2d((times.0..times.1).log_scale(), (errors.0..errors.1).log_scale())?;
        chart
            .configure_mesh()
            .x_desc("time of the steps (s)")
            .y_desc("largest error (rad, scene lengths, the same per scene time)")
            .x_label_formatter(&|x| format!("{x:.0e}"))
            .y_label_formatter(&|y| format!("{y:.0e}"))
            .label_style(("sans-serif", 15))
            .axis_desc_style(("sans-serif", 16))
            .bold_line_style(BLACK.mix(0.25))
            .light_line_style(BLACK.mix(0.07))
            .draw()?;
        for Line { label, color, points } in lines {
            let style = color.stroke_width(2);
            chart
                .draw_series(LineSeries::new(points.iter().copied(), style))?
                .label(label)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 24, y)], style));
            chart.draw_series(points.iter().map(|point| Circle::new(*point, 4, color.filled())))?;
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::LowerLeft)
            .legend_area_size(32)
            .margin(12)
            .label_font(("sans-serif", 16))
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.5))
            .draw()?;
        root.present()?;
    }
    Ok(Some(svg))
}

/// One line per method, also where all its points failed; an error of zero is drawn at the rounding of one.
fn lines(study: &Study) -> Vec<Line> {
    let of_method = |(method, color): (Method, RGBColor)| {
        let mine = || study.points.iter().filter(move |point| point.method == method);
        let failed = mine().filter(|point| point.outcome.is_err()).count();
        let points: Vec<(f64, f64)> = mine()
            .filter_map(|point| Some((point.wall.as_secs_f64(), point.outcome.as_ref().ok()?.state.max(f64::EPSILON))))
            .collect();
        let name = method.name();
        let label = if failed > 0 { format!("{name} ({failed} failed)") } else { name.to_owned() };
        Line { label, color, points }
    };
    let measured = |(method, _): &(Method, RGBColor)| study.points.iter().any(|point| point.method == *method);
    Method::ALL.into_iter().zip(COLORS.into_iter().cycle()).filter(measured).map(of_method).collect()
}

/// The range of whole decades around positive numbers.
fn decades(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = numbers.fold((f64::INFINITY, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
    let (low, high) = (low.log10().floor(), high.log10().ceil());
    (10.0_f64.powf(low), 10.0_f64.powf(high.max(low + 1.0)))
}
