//! Samples on their way to the viewer, as columns of single-precision numbers.

use super::curves::{Plot, curves};
use super::picture::{body_path, spring_path};
use crate::record::{Sample, Scene};
use rerun::{LineStrips3D, RecordingStream, RecordingStreamResult, Scalars, TimeColumn, Transform3D};

/// Name of the timeline.
pub(super) const TIMELINE: &str = "sim_time";

/// A stretch of samples.
#[derive(Debug, Clone, Default)]
pub(super) struct Columns {
    times: Vec<f64>,
    bodies: Vec<(Vec<[f32; 3]>, Vec<rerun::Quaternion>)>,
    springs: Vec<Vec<[[f32; 3]; 2]>>,
    curves: Vec<Vec<f64>>,
}

impl Columns {
    /// None yet.
    pub(super) fn new(scene: &Scene, plots: &[Vec<Plot>]) -> Self {
        Self {
            times: Vec::new(),
            bodies: vec![Default::default(); scene.bodies.len()],
            springs: vec![Vec::new(); scene.lines.len()],
            curves: vec![Vec::new(); curves(plots).count()],
        }
    }

    /// Number of samples.
    pub(super) fn len(&self) -> usize {
        self.times.len()
    }

    /// Adds a sample whose arrays fit the scene.
    pub(super) fn push(&mut self, sample: &Sample, scene: &Scene, plots: &[Vec<Plot>]) {
        self.times.push(sample.time);
        for ((at, turn), pose) in self.bodies.iter_mut().zip(sample.bodies) {
            at.push(pose.translation.vector.cast::<f32>().into());
            turn.push(quaternion(&pose.rotation));
        }
        for (column, line) in self.springs.iter_mut().zip(&scene.lines) {
            column.push(line.ends.map(|(body, point)| {
                let pose = body.and_then(|body| sample.bodies.get(body)).copied().unwrap_or_default();
                (pose * nalgebra::Point3::from(point)).coords.cast::<f32>().into()
            }));
        }
        for (column, curve) in self.curves.iter_mut().zip(curves(plots)) {
            column.push(curve.value(sample));
        }
    }

    /// Takes what was collected, leaving none.
    pub(super) fn take(&mut self) -> Self {
        let empty = Self {
            times: Vec::new(),
            bodies: vec![Default::default(); self.bodies.len()],
            springs: vec![Vec::new(); self.springs.len()],
            curves: vec![Vec::new(); self.curves.len()],
        };
        std::mem::replace(self, empty)
    }

    /// Sends everything.
    pub(super) fn send(
        self,
        stream: &RecordingStream,
        scene: &Scene,
        plots: &[Vec<Plot>],
    ) -> RecordingStreamResult<()> {
        let times = TimeColumn::new_duration_secs(TIMELINE, self.times);
        for ((at, turn), body) in self.bodies.into_iter().zip(&scene.bodies) {
            let poses = Transform3D::update_fields().with_many_translation(at).with_many_quaternion(turn);
            stream.send_columns(body_path(&body.name), [times.clone()], poses.columns_of_unit_batches()?)?;
        }
        for (ends, line) in self.springs.into_iter().zip(&scene.lines) {
            let strips = LineStrips3D::update_fields().with_strips(ends);
            stream.send_columns(spring_path(&line.name), [times.clone()], strips.columns_of_unit_batches()?)?;
        }
        for (values, curve) in self.curves.into_iter().zip(curves(plots)) {
            let scalars = Scalars::new(values).columns_of_unit_batches()?;
            stream.send_columns(curve.path.clone(), [times.clone()], scalars)?;
        }
        Ok(())
    }
}

pub(super) fn quaternion(turn: &nalgebra::UnitQuaternion<f64>) -> rerun::Quaternion {
    let turn = turn.quaternion().cast::<f32>();
    rerun::Quaternion::from_xyzw([turn.i, turn.j, turn.k, turn.w])
}
