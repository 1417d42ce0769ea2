//! The plot of a path: parameter against coordinate.

use super::super::frame;
use super::super::palette::{BLUE, GREEN, VERMILION, range, tick};
use super::Followed;
use crate::statics::Verdict;
use crate::statics::path::{EventKind, PathPoint};
use plotters::prelude::*;

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
    let coordinate = &followed.coordinate;
    let names = [
        format!("{} ({})", coordinate.name, coordinate.unit),
        format!("{} ({})", followed.settings.parameter, followed.unit()),
    ];
    let title = format!("{title}: equilibria");
    frame::svg(|root| {
        let axes: [frame::Axis<'_>; 2] = [(&names[0], &|x| tick(*x, across)), (&names[1], &|y| tick(*y, up))];
        let mut chart = frame::linear(root, &title, (across, up), axes)?;
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
        frame::legend(&mut chart, SeriesLabelPosition::UpperRight)
    })
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
