//! Which numbers are plotted, and under which names.

use super::forces::tension;
use super::sdk::EntityPath;
use super::survey::{Range, Survey};
use crate::record::scene::{Channel, LinePicture};
use crate::record::{Sample, Scene};

/// More curves in one plot cannot be distinguished.
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
    Coupling(usize),
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
            Source::Coupling(index) => sample.couplings[index],
        }
    }
}

/// Numbers of one kind: one plot for each unit.
struct Family<'a> {
    word: &'static str,
    /// Where its curves are in the viewer.
    folder: &'static str,
    channels: Vec<(usize, &'a Channel)>,
    source: fn(usize) -> Source,
    /// How much each channel matters, as far as that is known.
    weights: Option<Vec<f64>>,
    /// What those do that matter most, where it is said that others are left out.
    most: Option<&'static str>,
}

/// The plots of a scene in groups: energy and its error; hinge coordinates and rates, one plot for each unit, and the
/// pull of springs; what drives, motors, gears and loops push. Of many coordinates those are drawn that move most, as
/// far as that is known. Also what is left out.
pub(super) fn plots(scene: &Scene, known: Option<&Survey>) -> (Vec<Vec<Plot>>, Vec<String>) {
    let mut notes = Vec::new();
    let widths = |ranges: &[Range]| ranges.iter().map(|range| range.width()).collect();
    let hinges = Family {
        word: "Hinges",
        folder: "hinges",
        channels: numbered(&scene.positions),
        source: Source::Position,
        weights: known.map(|known| widths(&known.positions)),
        most: Some("move"),
    };
    let rates = Family {
        word: "Rates",
        folder: "rates",
        channels: numbered(&scene.velocities),
        source: Source::Velocity,
        weights: known.map(|known| widths(&known.velocities)),
        most: None,
    };
    let mut motion = hinges.plots(&mut notes);
    // The modes and the iterates of statics have poses alone.
    if rates.weights.as_ref().is_none_or(|widths: &Vec<f64>| widths.iter().any(|width| *width != 0.0)) {
        motion.extend(rates.plots(&mut notes));
    }
    let springs: Vec<Curve> = scene.lines.iter().enumerate().filter_map(spring).collect();
    if !springs.is_empty() && springs.len() <= CURVES_PER_PLOT {
        motion.push(Plot { title: "Springs [N]".into(), curves: springs });
    }
    (vec![energies(known), motion, couplings(scene, known, &mut notes)], notes)
}

/// What drives, motors, gears and loops push, and how far they are from being closed.
fn couplings(scene: &Scene, known: Option<&Survey>, notes: &mut Vec<String>) -> Vec<Plot> {
    let largest = known.map(|known| known.couplings.iter().map(|range| range.largest()).collect());
    let (gaps, pushes) = numbered(&scene.couplings).into_iter().partition(|(_, channel)| channel.name == "gap");
    let (folder, source) = ("couplings", Source::Coupling as fn(usize) -> Source);
    let pushes =
        Family { word: "Couplings", folder, channels: pushes, source, weights: largest.clone(), most: Some("push") };
    let gaps = Family { word: "Gaps", folder, channels: gaps, source, weights: largest, most: None };
    [pushes, gaps].iter().flat_map(|family| family.plots(notes)).collect()
}

fn numbered(channels: &[Channel]) -> Vec<(usize, &Channel)> {
    channels.iter().enumerate().collect()
}

impl Family<'_> {
    fn plots(&self, notes: &mut Vec<String>) -> Vec<Plot> {
        let mut plots = Vec::new();
        for unit in self.units() {
            let title = match unit {
                "" | "1" => format!("{}, quaternions", self.word),
                unit => format!("{} [{unit}]", self.word),
            };
            let (curves, total) = self.curves(unit);
            let count = curves.len();
            if total == count {
                plots.push(Plot { title, curves });
                continue;
            }
            notes.extend(self.most.map(|most| match self.weights {
                Some(_) => format!("{title}: the {count} of {total} that {most} most are plotted"),
                None => format!("{title}: the first {count} of {total} are plotted"),
            }));
            plots.push(Plot { title: format!("{title}, {count} of {total}"), curves });
        }
        plots
    }

    fn units(&self) -> Vec<&str> {
        let mut units: Vec<&str> = Vec::new();
        for (_, channel) in &self.channels {
            if !units.contains(&channel.unit.as_str()) {
                units.push(&channel.unit);
            }
        }
        units
    }

    /// The curves of one unit, and how many there are in all.
    fn curves(&self, unit: &str) -> (Vec<Curve>, usize) {
        let mut chosen: Vec<(usize, &Channel)> =
            self.channels.iter().copied().filter(|(_, channel)| channel.unit == unit).collect();
        let total = chosen.len();
        if let Some(weights) = self.weights.as_ref().filter(|_| total > CURVES_PER_PLOT) {
            chosen.sort_by(|(a, _), (b, _)| weights[*b].total_cmp(&weights[*a]));
        }
        chosen.truncate(CURVES_PER_PLOT);
        chosen.sort_unstable_by_key(|(index, _)| *index);
        let curve = |(index, channel): (usize, &Channel)| Curve {
            name: format!("{} {}", channel.body, channel.name),
            path: super::entity::path(&[self.folder, &channel.body, &channel.name]),
            source: (self.source)(index),
        };
        (chosen.into_iter().map(curve).collect(), total)
    }
}

/// Plots of the energies, without those known to be zero throughout; the potential energy always.
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
        let path = super::entity::path(&["energy", name]);
        shown(index).then(|| Curve { name: name.into(), path, source })
    };
    let mut curves: Vec<Curve> = all.into_iter().enumerate().filter_map(curve).collect();
    let error = curves.pop_if(|curve| curve.name == "error");
    let error = error.map(|curve| Plot { title: "Energy error [J]".into(), curves: vec![curve] });
    [Plot { title: "Energy [J]".into(), curves }].into_iter().chain(error).collect()
}

fn spring((index, line): (usize, &LinePicture)) -> Option<Curve> {
    line.spring?;
    let path = super::entity::path(&["pulls", &line.name]);
    Some(Curve { name: line.name.clone(), path, source: Source::Tension(index) })
}

/// Every curve of every plot.
pub(super) fn curves(groups: &[Vec<Plot>]) -> impl Iterator<Item = &Curve> {
    groups.iter().flatten().flat_map(|plot| &plot.curves)
}
