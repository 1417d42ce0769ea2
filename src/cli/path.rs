//! `statics` of a scenario with `[statics.path]`: the path as text, JSON, table, plot and recording.

mod plot;

use super::number::{self, exact};
use super::output::{self, Interrupt, Progress, bold};
use super::{Common, json, recording, text};
use crate::model::Model;
use crate::record::scene::Channel;
use crate::record::{Energy, Opening, Outcome, Recorder, Sample, Scene};
use crate::scenario::Scenario;
use crate::simulate;
use crate::statics::path::{BranchEnd, Path, PathBranch, PathPoint, PathSettings, follow};
use crate::whole_file::WholeFile;
use anyhow::Context;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::Arc;

/// What is drawn against the parameter: a hinge coordinate, or where a beam ends.
#[derive(Debug, Clone)]
struct Coordinate {
    at: Place,
    name: String,
    unit: &'static str,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    /// Index into positions.
    Position(usize),
    /// x, y or z of a body.
    Of { body: usize, axis: usize },
}

impl Place {
    fn of(self, point: &PathPoint) -> f64 {
        match self {
            Self::Position(at) => point.position.get(at).copied().unwrap_or(0.0),
            Self::Of { body, axis } => point.poses.get(body).map_or(0.0, |pose| pose.translation.vector[axis]),
        }
    }
}

/// A path, and where its files are.
pub(super) struct Followed {
    pub(super) path: Path,
    settings: PathSettings,
    coordinate: Coordinate,
    files: Vec<PathBuf>,
}

/// Follows the path of a scenario and writes PREFIX.path.csv, .svg and .mcap.
pub(super) fn main(
    scenario: &Scenario,
    settings: &PathSettings,
    model: &Arc<Model>,
    common: &Common,
    prefix: Option<&std::path::Path>,
) -> anyhow::Result<Followed> {
    let interrupt = Interrupt::install()?;
    let path = {
        let mut progress = Progress::new(1.0, common.quiet || common.json);
        let range = settings.to - settings.from;
        let mut go_on = |parameter: f64| {
            progress.part(((parameter - settings.from) / range).clamp(0.0, 1.0));
            !interrupt.requested()
        };
        follow(&scenario.description, &scenario.statics, settings, &mut go_on)
    };
    let path = path.map_err(|reason| anyhow::anyhow!("{}: {reason}", scenario.name))?;
    let coordinate = coordinate(settings, model, &path);
    let mut followed = Followed { path, settings: settings.clone(), coordinate, files: Vec::new() };
    if followed.path.branches.is_empty() {
        return Ok(followed);
    }
    let name = |kind: &str| {
        let stem = common.scenario.file_stem().filter(|stem| *stem != "-").unwrap_or("scenario".as_ref());
        let mut name = prefix.map_or(stem, std::path::Path::as_os_str).to_owned();
        name.push(format!(".path.{kind}"));
        PathBuf::from(name)
    };
    let [csv, svg, mcap] = ["csv", "svg", "mcap"].map(name);
    followed.table(model, &csv).with_context(|| format!("cannot write `{}`", csv.display()))?;
    let title = if model.title.is_empty() { &scenario.name } else { &model.title };
    let picture = plot::draw(&followed, title)?;
    output::save(&svg, picture.as_bytes())?;
    followed.record(scenario, model, &mcap)?;
    followed.files = vec![csv, svg, mcap];
    Ok(followed)
}

/// The coordinate that was asked for, else what moves most among hinge coordinates and the tips of beams.
fn coordinate(settings: &PathSettings, model: &Model, path: &Path) -> Coordinate {
    let positions = |body: &crate::model::Body| {
        let one = |(i, (name, unit)): (usize, &(&str, &'static str))| Coordinate {
            at: Place::Position(body.hinge.position + i),
            name: format!("{}.{name}", body.name),
            unit,
        };
        body.hinge.kind.positions().iter().enumerate().map(one).collect::<Vec<_>>()
    };
    let tips = |beam: &crate::model::Beam| {
        let body = beam.elements.last().map_or(beam.root, |last| last.body);
        let one = |axis: usize| {
            let name = format!("{}.tip {}", beam.name, ["x", "y", "z"][axis]);
            Coordinate { at: Place::Of { body, axis }, name, unit: "m" }
        };
        (0..3).map(one).collect::<Vec<_>>()
    };
    let all: Vec<Coordinate> =
        model.bodies.iter().flat_map(positions).chain(model.beams.iter().flat_map(tips)).collect();
    if let Some(asked) = &settings.coordinate
        && let crate::model::Element::Body(body) = asked.element
    {
        let at = model.bodies[body].hinge.position + asked.component();
        if let Some(found) = all.iter().find(|one| one.at == Place::Position(at)) {
            return found.clone();
        }
    }
    let length = model.length_scale();
    let extent = |one: &Coordinate| {
        let values = path.branches.iter().flat_map(|branch| branch.points.iter().map(|point| one.at.of(point)));
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
        (high - low) / if one.unit == "m" { length } else { 1.0 }
    };
    let none = Coordinate { at: Place::Position(0), name: String::new(), unit: "" };
    all.into_iter().max_by(|a, b| extent(a).total_cmp(&extent(b))).unwrap_or(none)
}

impl Followed {
    fn unit(&self) -> &'static str {
        self.settings.numbers.first().map_or("", |one| one.quantity.unit())
    }

    fn drawn(&self, point: &PathPoint) -> f64 {
        self.coordinate.at.of(point)
    }

    /// One line per point, branch by branch.
    fn table(&self, model: &Arc<Model>, path: &std::path::Path) -> anyhow::Result<()> {
        let mut csv = csv::Writer::from_writer(WholeFile::create(path)?);
        let scene = simulate::scene(model);
        let parameter = match self.unit() {
            "" => "parameter".to_owned(),
            unit => format!("parameter [{unit}]"),
        };
        let fixed = ["branch", "point", "arclength", &parameter, "stability", "unstable_directions", "event"];
        let more = ["relative_residual", "potential [J]"];
        let coordinates = scene.positions.iter().map(|one| format!("{}.{} [{}]", one.body, one.name, one.unit));
        let outputs = scene.outputs.iter().map(|one| format!("{} [{}]", one.name, one.unit));
        csv.write_record(fixed.iter().chain(&more).map(|name| (*name).to_owned()).chain(coordinates).chain(outputs))?;
        for (index, branch) in self.path.branches.iter().enumerate() {
            for (at, point) in branch.points.iter().enumerate() {
                let event = point.event.as_ref().map_or("", |event| event.kind.name());
                let fields = [
                    index.to_string(),
                    at.to_string(),
                    exact(point.arclength),
                    exact(point.parameter),
                    point.verdict.name().to_owned(),
                    point.unstable_directions.to_string(),
                    event.to_owned(),
                    exact(point.relative_residual),
                    exact(point.potential),
                ];
                let numbers = point.position.iter().chain(&point.outputs).copied().map(exact);
                csv.write_record(fields.into_iter().chain(numbers))?;
            }
        }
        Ok(output::whole(csv)?.finish()?)
    }

    /// One sample per point; arclength stands for time, branch after branch, and the parameter after the outputs.
    fn record(&self, scenario: &Scenario, model: &Arc<Model>, path: &std::path::Path) -> anyhow::Result<()> {
        let mut still = Scene { couplings: Vec::new(), watched: false, ..simulate::scene(model) };
        let (name, unit) = (self.settings.parameter.clone(), self.unit().to_owned());
        still.outputs.push(Channel { body: String::new(), name, unit });
        let statics = json::statics(model, &self.path.start, 0.0).to_string();
        let opening = Opening { scene: &still, scenario: &scenario.text, statics: Some(&statics) };
        let mut file = recording::recording_file(path, true)?.begin(&opening)?;
        let rest = vec![0.0; model.velocity_count()];
        let mut before = 0.0;
        for branch in &self.path.branches {
            for point in &branch.points {
                let energy = Energy { potential: point.potential, ..Energy::default() };
                let outputs: Vec<f64> = point.outputs.iter().copied().chain([point.parameter]).collect();
                file.sample(&Sample {
                    time: before + point.arclength,
                    positions: &point.position,
                    velocities: &rest,
                    accelerations: &rest,
                    bodies: &point.poses,
                    reactions: &point.reactions,
                    couplings: &[],
                    outputs: &outputs,
                    energy,
                })?;
            }
            before += branch.points.last().map_or(0.0, |point| point.arclength);
        }
        file.finish(&Outcome { summary: self.json(model).to_string() })?;
        Ok(())
    }

    pub(super) fn json(&self, model: &Model) -> Value {
        let event = |point: &PathPoint| {
            point.event.as_ref().map(
                |event| json!({ "kind": event.kind.name(), "directions": event.directions, "hinges": event.carriers }),
            )
        };
        let full = |point: &PathPoint| point.wanted || point.event.is_some();
        let point = |point: &PathPoint| {
            let mut value = json!({
                "parameter": point.parameter,
                "arclength": point.arclength,
                "coordinate": self.drawn(point),
                "stability": point.verdict.name(),
                "unstable_directions": point.unstable_directions,
                "relative_residual": point.relative_residual,
                "event": event(point),
                "wanted": point.wanted,
            });
            if full(point) {
                value["positions"] = json::by_hinge(model, &point.position, true);
            }
            if !point.outputs.is_empty() {
                value["outputs"] = json::outputs(model, &point.outputs);
            }
            value
        };
        let branch = |branch: &PathBranch| {
            json!({
                "parent": branch.parent.map(|(index, at)| json!({ "branch": index, "point": at })),
                "end": output::bare(&end(branch)),
                "points": branch.points.iter().map(point).collect::<Vec<_>>(),
            })
        };
        let events = self.path.events().map(|(index, at)| {
            let mut value = point(at);
            value["branch"] = json!(index);
            value
        });
        json!({
            "parameter": self.settings.parameter,
            "unit": self.unit(),
            "from": self.settings.from,
            "to": self.settings.to,
            "complete": self.path.complete,
            "coordinate": self.coordinate.name,
            "events": events.collect::<Vec<_>>(),
            "branches": self.path.branches.iter().map(branch).collect::<Vec<_>>(),
            "notes": self.path.notes,
            "files": self.files.iter().map(|file| file.display().to_string()).collect::<Vec<_>>(),
        })
    }

    /// What happens on the way, for people.
    pub(super) fn text(&self) -> String {
        let (mut out, unit) = (String::new(), self.unit());
        let with_unit = |x: f64| format!("{} {unit}", text::number(x)).trim_end().to_owned();
        let points: usize = self.path.branches.iter().map(|branch| branch.points.len()).sum();
        let _ = writeln!(
            out,
            "{} of `{}` from {} to {} ({} on {})",
            bold("path"),
            self.settings.parameter,
            with_unit(self.settings.from),
            with_unit(self.settings.to),
            number::count(points, "equilibrium", "equilibria"),
            number::count(self.path.branches.len(), "branch", "branches"),
        );
        let line = |out: &mut String, what: &str, index: usize, point: &PathPoint, more: &str| {
            let _ = writeln!(
                out,
                "  {what:<12} {:<18} {} = {} {}   branch {index}{more}",
                with_unit(point.parameter),
                self.coordinate.name,
                text::number(self.drawn(point)),
                self.coordinate.unit,
            );
        };
        for (index, point) in self.path.events() {
            let Some(event) = &point.event else { continue };
            line(&mut out, event.kind.name(), index, point, &format!(", {}", event.carriers.join(", ")));
        }
        for (index, branch) in self.path.branches.iter().enumerate() {
            for point in branch.points.iter().filter(|point| point.wanted) {
                line(&mut out, point.verdict.name(), index, point, "");
            }
        }
        for (index, branch) in self.path.branches.iter().enumerate() {
            let Some(last) = branch.points.last() else { continue };
            line(
                &mut out,
                if index == 0 { "ends" } else { "" },
                index,
                last,
                &format!(", {}, {}", last.verdict.name(), end(branch)),
            );
        }
        for note in &self.path.notes {
            let _ = writeln!(out, "  note         {note}");
        }
        for (index, file) in self.files.iter().enumerate() {
            let _ = writeln!(out, "  {:<12} {}", if index == 0 { "files" } else { "" }, file.display());
        }
        out.trim_end().to_owned()
    }
}

/// How a branch ends, in words.
fn end(branch: &PathBranch) -> String {
    match &branch.end {
        BranchEnd::Range => "at an end of the range".to_owned(),
        BranchEnd::Closed => "where it began".to_owned(),
        BranchEnd::Stop { hinge, limit, lifts: false } => format!("on the stop of {hinge} at {}", text::number(*limit)),
        BranchEnd::Stop { hinge, limit, lifts: true } => {
            format!("where {hinge} lifts off its stop at {}", text::number(*limit))
        }
        BranchEnd::Points => "after as many points as were asked for".to_owned(),
        BranchEnd::Lost(reason) => format!("lost: {reason}"),
    }
}
