//! The plot of a path: a coordinate over the parameter.

use super::super::frame::{self, at, px};
use super::super::palette::{BLUE, GREEN, Theme, VERMILION, range, tick};
use super::super::plot::draw::with_unit;
use super::Followed;
use crate::statics::StabilityVerdict;
use crate::statics::path::{EventKind, PathPoint};
use plotters::element::IntoDynElement;
use plotters::prelude::*;

const VERDICTS: [StabilityVerdict; 3] =
    [StabilityVerdict::Stable, StabilityVerdict::Unstable, StabilityVerdict::Neutral];
/// What is marked.
const EVENTS: [EventKind; 5] =
    [EventKind::Fold, EventKind::Bifurcation, EventKind::Flutter, EventKind::Stop, EventKind::Lift];

fn color(verdict: StabilityVerdict) -> RGBColor {
    match verdict {
        StabilityVerdict::Stable => BLUE,
        StabilityVerdict::Unstable => VERMILION,
        StabilityVerdict::Neutral => GREEN,
    }
}

/// The coordinate over the parameter: stable solid, unstable dashed, events marked; as SVG.
///
/// # Errors
/// If the drawing library fails.
pub(super) fn draw(followed: &Followed, title: &str) -> anyhow::Result<String> {
    let points = || followed.path.branches.iter().flat_map(|branch| branch.points.iter());
    let place = |point: &PathPoint| (point.parameter, followed.drawn(point));
    let across = range(points().map(|point| place(point).0));
    let up = range(points().map(|point| place(point).1));
    let coordinate = &followed.coordinate;
    let names =
        [with_unit(&followed.settings.parameter, followed.unit()), with_unit(&coordinate.name, coordinate.unit)];
    let (title, theme) = (format!("{title}: equilibria"), Theme::default());
    frame::svg(frame::SIZE, theme, |root| {
        let below = frame::titled(root, theme, &title)?;
        let names_beside = VERDICTS.map(StabilityVerdict::name).into_iter().chain(EVENTS.map(EventKind::name));
        let (area, mut legend) = frame::with_legend(&below, theme, frame::legend_width(names_beside));
        let axes: [frame::Axis<'_>; 2] = [(&names[0], &|x| tick(*x, across)), (&names[1], &|y| tick(*y, up))];
        let mut chart = frame::linear(&area, theme, (across, up), axes)?;
        for verdict in VERDICTS {
            let style = color(verdict).stroke_width(px(2));
            let dashes = (verdict == StabilityVerdict::Unstable).then_some((8, 5));
            let all = runs(followed, verdict);
            for run in &all {
                let line: Vec<(f64, f64)> = run.iter().map(|point| place(point)).collect();
                match dashes {
                    Some((dash, gap)) => chart.draw_series(DashedLineSeries::new(line, at(dash), at(gap), style))?,
                    None => chart.draw_series(LineSeries::new(line, style))?,
                };
            }
            if !all.is_empty() {
                legend.line(verdict.name(), style, dashes)?;
            }
        }
        for kind in EVENTS {
            let mine = |point: &&PathPoint| point.event.as_ref().is_some_and(|event| event.kind == kind);
            let marks: Vec<(f64, f64)> = points().filter(mine).map(place).collect();
            for (x, y) in &marks {
                let (x, y) = chart.backend_coord(&(*x, *y));
                root.draw(&mark(kind, (x, y)))?;
            }
            if !marks.is_empty() {
                legend.entry(kind.name(), |(x, y)| mark(kind, (x + at(14), y)))?;
            }
        }
        Ok(())
    })
}

/// What marks an event.
fn mark<'a>(kind: EventKind, place: (i32, i32)) -> frame::Element<'a> {
    match kind {
        EventKind::Fold => Circle::new(place, at(6), BLACK.filled()).into_dyn(),
        EventKind::Bifurcation => TriangleMarker::new(place, at(8), BLACK.filled()).into_dyn(),
        EventKind::Flutter => Cross::new(place, at(7), BLACK.stroke_width(px(2))).into_dyn(),
        EventKind::Stop => TriangleMarker::new(place, at(8), BLUE.filled()).into_dyn(),
        EventKind::Lift => Circle::new(place, at(6), BLUE.stroke_width(px(2))).into_dyn(),
    }
}

/// Stretches of neighbouring points of one kind; where the kind changes, both stretches reach the point between.
fn runs(followed: &Followed, verdict: StabilityVerdict) -> Vec<Vec<&PathPoint>> {
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
