//! A recording as tables: one per channel, one column per number, each with its name and unit.

use super::scene::{Channel, WRENCH};
use super::{OwnedSample, Scene};
use std::collections::HashMap;

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// `upper.angle`, `upper.force.x`, `kinetic`.
    pub name: String,
    /// SI unit.
    pub unit: String,
}

/// A channel as a table.
///
/// ```no_run
/// use stillpoint::record::{Recording, Table};
///
/// let recording = Recording::open("arm.mcap".as_ref())?;
/// let tables = Table::all(&recording.scene);
/// let hinges = &tables[0];
/// let mut row = Vec::new();
/// for sample in recording.samples()? {
///     let sample = sample?;
///     hinges.fill(&sample, &mut row);
///     println!("{} s: {} = {} {}", sample.time, hinges.columns[0].name, row[0], hinges.columns[0].unit);
/// }
/// # Ok::<(), stillpoint::record::RecordError>(())
/// ```
///
/// Its columns stand beside the time, which is no column of its own.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Table {
    /// Name of the channel without its slash: `hinges`, `energy`, `reactions`, `couplings`, `outputs`, `tf`.
    pub name: &'static str,
    /// In the order of [`fill`](Table::fill).
    pub columns: Vec<Column>,
}

/// Ends of the names of a pose's numbers.
const POSE: [(&str, &str); 7] = [
    ("position.x", "m"),
    ("position.y", "m"),
    ("position.z", "m"),
    ("quaternion.w", "1"),
    ("quaternion.x", "1"),
    ("quaternion.y", "1"),
    ("quaternion.z", "1"),
];

impl Table {
    /// The tables of a scene's recordings:
    ///
    /// | table | columns |
    /// |---|---|
    /// | `hinges` | coordinates `upper.angle`, velocities `upper.rate`, accelerations `upper.rate_dot` |
    /// | `energy` | `kinetic`, `potential`, `work`, `dissipated`, `error` |
    /// | `reactions` | `upper.force.x` … `upper.moment.z`: what the hinge passes to the body, inertial axes |
    /// | `couplings` | `crank motor.torque`, `belt.torque`, `belt.gap`, `coupler pin.force.x` … `coupler pin.gap`: what drives, motors, gears and loops push; not in scenes without |
    /// | `outputs` | `camber`, `tip[0]` … `tip[2]`: the outputs of the scenario by their names; not in scenes without |
    /// | `tf` | `upper.position.x` … `upper.quaternion.z`: the pose of the root marker in inertial axes |
    ///
    /// No two columns of a recording have the same name.
    pub fn all(scene: &Scene) -> Vec<Self> {
        // How many primes the next column of a name gets: a scene may have any number of equal ones.
        let mut taken: HashMap<String, usize> = HashMap::new();
        let mut column = |name: String, unit: &str| {
            let mut unique = name.clone();
            while let Some(count) = taken.get_mut(&unique) {
                *count += 1;
                unique = if *count < 4 { format!("{name}{}", "'".repeat(*count)) } else { format!("{name}'{count}") };
            }
            taken.insert(unique.clone(), 0);
            Column { name: unique, unit: unit.to_owned() }
        };
        // They have the names that they were given.
        let outputs: Vec<Column> = scene.outputs.iter().map(|one| column(one.name.clone(), &one.unit)).collect();
        let mut hinges = Vec::new();
        for channel in scene.positions.iter().chain(&scene.velocities) {
            hinges.push(column(format!("{}.{}", channel.body, channel.name), &channel.unit));
        }
        for channel in &scene.velocities {
            hinges.push(column(format!("{}.{}_dot", channel.body, channel.name), &per_second(&channel.unit)));
        }
        let energy = ["kinetic", "potential", "work", "dissipated", "error"].map(|name| column(name.to_owned(), "J"));
        let mut each_body = |ends: &[(&str, &str)]| -> Vec<Column> {
            let of_body = |body: &super::scene::BodyPicture| {
                ends.iter().map(|(end, unit)| (format!("{}.{end}", body.name), *unit)).collect::<Vec<_>>()
            };
            scene.bodies.iter().flat_map(of_body).map(|(name, unit)| column(name, unit)).collect()
        };
        let (reactions, poses) = (each_body(&WRENCH), each_body(&POSE));
        let of_coupling = |channel: &Channel| column(format!("{}.{}", channel.body, channel.name), &channel.unit);
        let couplings: Vec<Column> = scene.couplings.iter().map(of_coupling).collect();
        let mut tables = vec![
            Self { name: "hinges", columns: hinges },
            Self { name: "energy", columns: energy.into() },
            Self { name: "reactions", columns: reactions },
            Self { name: "tf", columns: poses },
        ];
        if !couplings.is_empty() {
            tables.push(Self { name: "couplings", columns: couplings });
        }
        if !outputs.is_empty() {
            tables.push(Self { name: "outputs", columns: outputs });
        }
        tables
    }

    /// Writes the row of one sample over `row`.
    pub fn fill(&self, sample: &OwnedSample, row: &mut Vec<f64>) {
        row.clear();
        match self.name {
            "hinges" => {
                row.extend(sample.positions.iter().chain(&sample.velocities).chain(&sample.accelerations));
            }
            "energy" => {
                let energy = &sample.energy;
                row.extend([energy.kinetic, energy.potential, energy.work, energy.dissipated, energy.error]);
            }
            "couplings" => row.extend(&sample.couplings),
            "outputs" => row.extend(&sample.outputs),
            "reactions" => {
                for wrench in &sample.reactions {
                    row.extend(wrench.force.iter().chain(wrench.moment.iter()));
                }
            }
            _ => {
                for pose in &sample.bodies {
                    let turn = &pose.rotation;
                    row.extend(pose.translation.vector.iter().chain(&[turn.w, turn.i, turn.j, turn.k]));
                }
            }
        }
    }
}

/// The unit of a quantity's rate: `rad/s` becomes `rad/s²`.
fn per_second(unit: &str) -> String {
    match unit.strip_suffix("/s") {
        Some(base) => format!("{base}/s²"),
        None => format!("{unit}/s"),
    }
}
