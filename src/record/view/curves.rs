//! Which numbers are plotted, and under which names.

use super::forces::tension;
use super::survey::{Range, Survey};
use crate::record::scene::{Channel, LinePicture};
use crate::record::{Sample, Scene};
use rerun::EntityPath;

/// More curves in one plot cannot be told apart.
const CURVES_PER_PLOT: usize = 8;

/// A plot: curves with one unit.
#[derive(Debug, Clone)]
pub(super) struct Plot {
    pub(super) title: String,
    pub(super) curves: Vec<Curve>,
}

/// A curve: a name, a place in the viewer and where its values come from.
#[derive(Debug, Clone)]
pub(super) struct Curve {
    pub(super) name: String,
    pub(super) path: EntityPath,
    source: Source,
}

#[derive(Debug, Clone, Copy)]
enum Source {
    Kinetic,
    Potential,
    Work,
    Dissipated,
    EnergyError,
    Position(usize),
    Velocity(usize),
    /// Of the line with this index.
    Tension(usize),
}

impl Curve {
    /// The curve's value in a sample whose arrays fit the scene.
    pub(super) fn value(&self, sample: &Sample, scene: &Scene) -> f64 {
        match self.source {
            Source::Kinetic => sample.energy.kinetic,
            Source::Potential => sample.energy.potential,
            Source::Work => sample.energy.work,
            Source::Dissipated => sample.energy.dissipated,
            Source::EnergyError => sample.energy.error,
            Source::Position(index) => sample.positions[index],
            Source::Velocity(index) => sample.velocities[index],
            Source::Tension(index) => tension(&scene.lines[index], sample.bodies).unwrap_or(0.0),
        }
    }
}

/// The plots of a scene in groups: energy and its error; hinge coordinates and rates, one plot for each unit, and the
/// pull of springs. Of many coordinates those are drawn that move most, as far as that is known. Also what is left out.
pub(super) fn plots(scene: &Scene, known: Option<&Survey>) -> (Vec<Vec<Plot>>, Vec<String>) {
    let mut notes = Vec::new();
    let mut plots = Vec::new();
    for (word, channels, of, widths) in [
        ("Hinges", &scene.positions, Source::Position as fn(usize) -> Source, known.map(|known| &known.positions)),
        ("Rates", &scene.velocities, Source::Velocity, known.map(|known| &known.velocities)),
    ] {
        // The modes and the iterates of statics have poses alone.
        if word == "Rates" && widths.is_some_and(|widths| widths.iter().all(|range| range.width() == 0.0)) {
            continue;
        }
        for unit in units(channels) {
            let title = match unit {
                "" | "1" => format!("{word}, quaternions"),
                unit => format!("{word} [{unit}]"),
            };
            let (curves, total) = hinges(channels, unit, of, widths);
            if total > curves.len() {
                let count = curves.len();
                if word == "Hinges" {
                    notes.push(match widths {
                        Some(_) => format!("{title}: the {count} of {total} that move most are plotted"),
                        None => format!("{title}: the first {count} of {total} are plotted"),
                    });
                }
                plots.push(Plot { title: format!("{title}, {count} of {total}"), curves });
            } else {
                plots.push(Plot { title, curves });
            }
        }
    }
    let springs: Vec<Curve> = scene.lines.iter().enumerate().filter_map(spring).collect();
    if !springs.is_empty() && springs.len() <= CURVES_PER_PLOT {
        plots.push(Plot { title: "Springs [N]".into(), curves: springs });
    }
    (vec![energies(known), plots], notes)
}

/// Those that are more than zero, where that is known; the potential energy always.
fn energies(known: Option<&Survey>) -> Vec<Plot> {
    let all = [
        ("kinetic", Source::Kinetic),
        ("potential", Source::Potential),
        ("work", Source::Work),
        ("dissipated", Source::Dissipated),
        ("error", Source::EnergyError),
    ];
    let shown = |index: usize| index == 1 || known.is_none_or(|known| known.energies[index] != 0.0);
    let curve = |(index, (name, source)): (usize, (&str, Source))| {
        let path = super::picture::path(&["energy", name]);
        shown(index).then(|| Curve { name: name.into(), path, source })
    };
    let mut curves: Vec<Curve> = all.into_iter().enumerate().filter_map(curve).collect();
    let error = curves.pop_if(|curve| curve.name == "error");
    let error = error.map(|curve| Plot { title: "Energy error [J]".into(), curves: vec![curve] });
    [Plot { title: "Energy [J]".into(), curves }].into_iter().chain(error).collect()
}

fn units(channels: &[Channel]) -> Vec<&str> {
    let mut units: Vec<&str> = Vec::new();
    for channel in channels {
        if !units.contains(&channel.unit.as_str()) {
            units.push(&channel.unit);
        }
    }
    units
}

/// The curves of one unit, and how many there are in all.
fn hinges(
    channels: &[Channel],
    unit: &str,
    of: fn(usize) -> Source,
    widths: Option<&Vec<Range>>,
) -> (Vec<Curve>, usize) {
    let mut chosen: Vec<usize> = (0..channels.len()).filter(|index| channels[*index].unit == unit).collect();
    let total = chosen.len();
    if let Some(widths) = widths.filter(|_| total > CURVES_PER_PLOT) {
        chosen.sort_by(|a, b| widths[*b].width().total_cmp(&widths[*a].width()));
    }
    chosen.truncate(CURVES_PER_PLOT);
    chosen.sort_unstable();
    let curve = |index: usize| {
        let (channel, source) = (&channels[index], of(index));
        let group = if matches!(source, Source::Velocity(_)) { "rates" } else { "hinges" };
        Curve {
            name: format!("{} {}", channel.body, channel.name),
            path: super::picture::path(&[group, &channel.body, &channel.name]),
            source,
        }
    };
    (chosen.into_iter().map(curve).collect(), total)
}

fn spring((index, line): (usize, &LinePicture)) -> Option<Curve> {
    line.spring?;
    let path = super::picture::path(&["pulls", &line.name]);
    Some(Curve { name: line.name.clone(), path, source: Source::Tension(index) })
}

/// Every curve of every plot.
pub(super) fn curves(groups: &[Vec<Plot>]) -> impl Iterator<Item = &Curve> {
    groups.iter().flatten().flat_map(|plot| &plot.curves)
}
