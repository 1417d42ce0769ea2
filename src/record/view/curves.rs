//! Which numbers are plotted, and under which names.

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
}

impl Curve {
    /// The curve's value in a sample whose arrays fit the scene.
    pub(super) fn value(&self, sample: &Sample) -> f64 {
        match self.source {
            Source::Kinetic => sample.energy.kinetic,
            Source::Potential => sample.energy.potential,
            Source::Work => sample.energy.work,
            Source::Dissipated => sample.energy.dissipated,
            Source::EnergyError => sample.energy.error,
            Source::Position(index) => sample.positions[index],
        }
    }
}

/// The plots of a scene in two groups: energy and its error; the hinge coordinates, one plot for each unit. Also what is
/// left out.
pub(super) fn plots(scene: &Scene) -> (Vec<Vec<Plot>>, Vec<String>) {
    let energies = vec![
        energy(
            "Energy [J]",
            &[
                ("kinetic", Source::Kinetic),
                ("potential", Source::Potential),
                ("work", Source::Work),
                ("dissipated", Source::Dissipated),
            ],
        ),
        energy("Energy error [J]", &[("error", Source::EnergyError)]),
    ];
    let mut plots = Vec::new();
    let mut notes = Vec::new();
    let mut units: Vec<&str> = Vec::new();
    for channel in &scene.positions {
        if !units.contains(&channel.unit.as_str()) {
            units.push(&channel.unit);
        }
    }
    for unit in units {
        let mut curves = hinges(scene, unit);
        let title = match unit {
            "" | "1" => "Hinges, quaternions".to_owned(),
            unit => format!("Hinges [{unit}]"),
        };
        let total = curves.len();
        if total > CURVES_PER_PLOT {
            curves.truncate(CURVES_PER_PLOT);
            notes.push(format!("{title}: the first {CURVES_PER_PLOT} of {total} are plotted"));
            plots.push(Plot { title: format!("{title}, {CURVES_PER_PLOT} of {total}"), curves });
        } else {
            plots.push(Plot { title, curves });
        }
    }
    (vec![energies, plots], notes)
}

fn energy(title: &str, sources: &[(&str, Source)]) -> Plot {
    let curve = |&(name, source): &(&str, Source)| Curve {
        name: name.into(),
        path: super::picture::path(&["energy", name]),
        source,
    };
    Plot { title: title.into(), curves: sources.iter().map(curve).collect() }
}

fn hinges(scene: &Scene, unit: &str) -> Vec<Curve> {
    let channels = scene.positions.iter().enumerate().filter(|(_, channel)| channel.unit == unit);
    channels
        .map(|(index, channel)| Curve {
            name: format!("{} {}", channel.body, channel.name),
            path: super::picture::path(&["hinges", &channel.body, &channel.name]),
            source: Source::Position(index),
        })
        .collect()
}

/// Every curve of every plot.
pub(super) fn curves(groups: &[Vec<Plot>]) -> impl Iterator<Item = &Curve> {
    groups.iter().flatten().flat_map(|plot| &plot.curves)
}
