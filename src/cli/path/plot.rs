//! The plot of a path: parameter against coordinate.

use super::super::palette::{BLUE, GREEN, VERMILION, range, tick};
use super::Followed;
use crate::statics::Verdict;
use crate::statics::path::{EventKind, PathPoint};
use plotters::prelude::*;

const SIZE: (u32, u32) = (960, 640);

fn color(verdict: Verdict) -> RGBColor {
    match verdict {
        Verdict::Stable => BLUE,
        Verdict::Unstable => VERMILION,
        Verdict::Neutral => GREEN,
    }
}

/// Stable solid, unstable dashed, events marked; as SVG.
///
/// # Errors
/// Where the drawing library gives up.
pub(super) fn draw(followed: &Followed, title: &str) -> anyhow::Result<String> {
    let points = || followed.path.branches.iter().flat_map(|branch| branch.points.iter());
    let place = |point: &PathPoint| (followed.drawn(point), point.parameter);
    let across = range(points().map(|point| place(point).0));
    let up = range(points().map(|point| place(point).1));
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        root.fill(&WHITE)?;
        let mut chart = ChartBuilder::on(&root)
            .caption(format!("{title}: equilibria"), ("sans-serif", 22))
            .margin(16)
            .x_label_area_size(52)
            .y_label_area_size(78)
            .build_cartesian_2d(across.0..across.1, up.0..up.1)?;
        let coordinate = &followed.coordinate;
        chart
            .configure_mesh()
            .x_desc(format!("{} ({})", coordinate.name, coordinate.unit))
            .y_desc(format!("{} ({})", followed.settings.parameter, followed.unit()))
            .x_label_formatter(&|x| tick(*x, across))
            .y_label_formatter(&|y| tick(*y, up))
            .label_style(("sans-serif", 15))
            .axis_desc_style(("sans-serif", 16))
            .bold_line_style(BLACK.mix(0.2))
            .light_line_style(BLACK.mix(0.05))
            .draw()?;
        for verdict in [Verdict::Stable, Verdict::Unstable, Verdict::Neutral] {
            let style = color(verdict).stroke_width(2);
            let mut named = false;
            for run in runs(followed, verdict) {
                let line: Vec<(f64, f64)> = run.into_iter().map(place).collect();
                let drawn = match verdict {
                    Verdict::Unstable => chart.draw_series(DashedLineSeries::new(line, 8, 5, style))?,
                    _ => chart.draw_series(LineSeries::new(line, style))?,
                };
                if !named {
                    drawn.label(verdict.name()).legend(move |(x, y)| {
                        let middle = if verdict == Verdict::Unstable { x + 9 } else { x + 12 };
                        let from = if verdict == Verdict::Unstable { x + 15 } else { middle };
                        EmptyElement::at((0, 0))
                            + PathElement::new([(x, y), (middle, y)], style)
                            + PathElement::new([(from, y), (x + 24, y)], style)
                    });
                    named = true;
                }
            }
        }
        for kind in [EventKind::Fold, EventKind::Bifurcation, EventKind::Flutter, EventKind::Stop, EventKind::Lift] {
            let mine = |point: &&PathPoint| point.event.as_ref().is_some_and(|event| event.kind == kind);
            let marks: Vec<(f64, f64)> = points().filter(mine).map(place).collect();
            if marks.is_empty() {
                continue;
            }
            let series =
                match kind {
                    EventKind::Fold => {
                        chart.draw_series(marks.iter().map(|at| Circle::new(*at, 6, BLACK.filled()).into_dyn()))?
                    }
                    EventKind::Bifurcation => chart
                        .draw_series(marks.iter().map(|at| TriangleMarker::new(*at, 8, BLACK.filled()).into_dyn()))?,
                    EventKind::Flutter => chart
                        .draw_series(marks.iter().map(|at| Cross::new(*at, 7, BLACK.stroke_width(2)).into_dyn()))?,
                    EventKind::Stop => chart
                        .draw_series(marks.iter().map(|at| TriangleMarker::new(*at, 8, BLUE.filled()).into_dyn()))?,
                    EventKind::Lift => chart
                        .draw_series(marks.iter().map(|at| Circle::new(*at, 6, BLUE.stroke_width(2)).into_dyn()))?,
                };
            series.label(kind.name()).legend(move |(x, y)| match kind {
                EventKind::Fold => Circle::new((x + 12, y), 5, BLACK.filled()).into_dyn(),
                EventKind::Bifurcation => TriangleMarker::new((x + 12, y), 7, BLACK.filled()).into_dyn(),
                EventKind::Flutter => Cross::new((x + 12, y), 6, BLACK.stroke_width(2)).into_dyn(),
                EventKind::Stop => TriangleMarker::new((x + 12, y), 7, BLUE.filled()).into_dyn(),
                EventKind::Lift => Circle::new((x + 12, y), 5, BLUE.stroke_width(2)).into_dyn(),
            });
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .legend_area_size(32)
            .margin(12)
            .label_font(("sans-serif", 16))
            .background_style(WHITE.mix(0.85))
            .border_style(BLACK.mix(0.5))
            .draw()?;
        root.present()?;
    }
    Ok(svg)
}

/// Stretches of neighbouring points of one kind; where the kind changes, both stretches reach the point between.
fn runs(followed: &Followed, verdict: Verdict) -> Vec<Vec<&PathPoint>> {
    let mut all = Vec::new();
    for branch in &followed.path.branches {
        // A branch begins in the bifurcation it leaves from.
        let parent = branch.parent.map(|(index, at)| &followed.path.branches[index].points[at]);
        let points: Vec<&PathPoint> = parent.into_iter().chain(&branch.points).collect();
        let mut run: Vec<&PathPoint> = Vec::new();
        for pair in points.windows(2) {
            // A segment is of the kind of its end that is no event: an event is where kinds meet.
            let kind = if pair[0].event.is_some() { pair[1].verdict } else { pair[0].verdict };
            if kind == verdict {
                if run.is_empty() {
                    run.push(pair[0]);
                }
                run.push(pair[1]);
            } else if !run.is_empty() {
                all.push(std::mem::take(&mut run));
            }
        }
        if !run.is_empty() {
            all.push(run);
        }
    }
    all
}
