//! The samples of a run as columns, and columns as samples.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use stillpoint::record::sample::Energy;
use stillpoint::record::{Event, Outcome, OwnedSample, RecordError, Recorder, Sample, Scene, Table};
use stillpoint::spatial::Wrench;

/// Every column of every table of a recording, beside the time, and what happened.
pub(crate) struct Columns {
    tables: Vec<Table>,
    row: Vec<f64>,
    pub(crate) time: Vec<f64>,
    pub(crate) columns: Vec<Vec<f64>>,
    pub(crate) events: Vec<Event>,
}

impl Columns {
    /// Room for as many samples; `None` if there is no such memory.
    pub(crate) fn new(scene: &Scene, samples: usize) -> Option<Self> {
        let tables = Table::all(scene);
        let count = tables.iter().map(|table| table.columns.len()).sum();
        let room = || {
            let mut column = Vec::new();
            column.try_reserve_exact(samples).ok().map(|()| column)
        };
        let columns = (0..count).map(|_| room()).collect::<Option<_>>()?;
        Some(Self { tables, row: Vec::new(), time: room()?, columns, events: Vec::new() })
    }

    /// Names and units in the order of the columns.
    pub(crate) fn names(&self) -> Vec<(String, String)> {
        let columns = self.tables.iter().flat_map(|table| &table.columns);
        columns.map(|column| (column.name.clone(), column.unit.clone())).collect()
    }

    pub(crate) fn take(&mut self, sample: &OwnedSample) {
        self.time.push(sample.time);
        let mut columns = self.columns.iter_mut();
        for table in &self.tables {
            table.fill(sample, &mut self.row);
            self.row.iter().zip(&mut columns).for_each(|(number, column)| column.push(*number));
        }
    }
}

impl Recorder for Columns {
    fn sample(&mut self, sample: &Sample) -> Result<(), RecordError> {
        self.take(&sample.to_owned());
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<(), RecordError> {
        self.events.push(event.clone());
        Ok(())
    }

    fn finish(&mut self, _outcome: &Outcome) -> Result<(), RecordError> {
        Ok(())
    }
}

/// The sample whose numbers stand at this place of the columns of [`Columns`].
pub(crate) fn sample(scene: &Scene, time: f64, mut number: impl FnMut(usize) -> f64) -> OwnedSample {
    let mut sample = OwnedSample { time, ..OwnedSample::default() };
    let mut at = 0;
    let mut take = |count: usize| -> Vec<f64> {
        at += count;
        (at - count..at).map(&mut number).collect()
    };
    for table in Table::all(scene) {
        match table.name {
            "hinges" => {
                sample.positions = take(scene.positions.len());
                sample.velocities = take(scene.velocities.len());
                sample.accelerations = take(scene.velocities.len());
            }
            "energy" => {
                let [kinetic, potential, work, dissipated, error] = take(5)[..] else { continue };
                sample.energy = Energy { kinetic, potential, work, dissipated, error };
            }
            "couplings" => sample.couplings = take(table.columns.len()),
            "outputs" => sample.outputs = take(table.columns.len()),
            "reactions" => {
                sample.reactions = take(table.columns.len())
                    .chunks_exact(6)
                    .map(|x| Wrench { force: Vector3::new(x[0], x[1], x[2]), moment: Vector3::new(x[3], x[4], x[5]) })
                    .collect();
            }
            _ => {
                let pose = |x: &[f64]| {
                    let turn = UnitQuaternion::new_unchecked(Quaternion::new(x[3], x[4], x[5], x[6]));
                    Isometry3::from_parts(Translation3::new(x[0], x[1], x[2]), turn)
                };
                sample.bodies = take(table.columns.len()).chunks_exact(7).map(pose).collect();
            }
        }
    }
    sample
}
