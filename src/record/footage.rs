//! The motion of a recording, as far as it is drawn: which sample is when, and the poses of all.

use super::drawing::{Drawing, Extras};
use super::gltf::Clip;
use super::{OwnedSample, RecordError, Recording, Tubes, meshes};
use crate::spatial::Pose;
use serde_json::Value;
use std::path::Path;

/// A recording that is about to be drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Footage {
    /// Everything but its samples; mesh files that are not read are taken out of its scene.
    pub recording: Recording,
    /// What is not drawn, in words.
    pub notes: Vec<String>,
    /// Its beams. Poses of their cross sections stand behind those of the bodies in all samples and clips from here.
    pub tubes: Tubes,
}

/// A sample that was asked for by its time.
#[derive(Debug, Clone, PartialEq)]
pub struct Moment {
    /// The nearest one.
    pub sample: OwnedSample,
    /// Whether the time is beyond all samples.
    pub beyond: Option<Beyond>,
}

/// The end of a recording that a time is beyond.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Beyond {
    /// Before its first sample.
    Start,
    /// After its last one.
    End,
}

impl Footage {
    /// Opens a recording. A recording of somebody else may name any file: unless `meshes` says otherwise, only mesh files in the
    /// recording's folder are read.
    ///
    /// # Errors
    /// If the recording cannot be read.
    pub fn open(path: &Path, meshes: bool) -> Result<Self, RecordError> {
        let mut recording = Recording::open(path)?;
        if holds_poses(recording.outcome.as_deref()) {
            recording.scene.hold_loads();
        }
        let notes = if meshes { Vec::new() } else { meshes::keep_own(&mut recording.scene, path) };
        let tubes = Tubes::new(&recording.scene);
        Ok(Self { recording, notes, tubes })
    }

    /// The sample whose time is nearest to `at` (s), of two at one time the later, the first without; `None` of a recording
    /// without samples.
    ///
    /// # Errors
    /// If the samples cannot be read.
    pub fn sample(&self, at: Option<f64>) -> Result<Option<Moment>, RecordError> {
        let (asked, at) = (at, at.unwrap_or(f64::NEG_INFINITY));
        let mut nearest: Option<OwnedSample> = None;
        let (mut is_before, mut is_after) = (false, true);
        for sample in self.recording.samples()? {
            let sample = sample?;
            is_before |= nearest.is_none() && at < sample.time;
            is_after &= at > sample.time;
            // A stage has two samples at one time: the later one is what goes on.
            match &nearest {
                Some(before) if before.time < sample.time && (before.time - at).abs() <= (sample.time - at).abs() => {
                    break;
                }
                _ => nearest = Some(sample),
            }
        }
        let beyond = match asked {
            Some(_) if is_before => Some(Beyond::Start),
            Some(_) if is_after => Some(Beyond::End),
            _ => None,
        };
        Ok(nearest.map(|mut sample| {
            self.tubes.extend(&sample.positions, &mut sample.bodies);
            Moment { sample, beyond }
        }))
    }

    /// Its motions: the run, or one for each mode of a recording of modes.
    ///
    /// # Errors
    /// If the samples cannot be read.
    pub fn clips(&self) -> Result<Vec<Clip>, RecordError> {
        let outcome = self.recording.outcome.as_deref();
        let mut parts = parts(outcome);
        // In modes and iterates nothing balances: what would be borne is not known.
        let is_poses = holds_poses(outcome);
        for sample in self.recording.samples()? {
            let mut sample = sample?;
            self.tubes.extend(&sample.positions, &mut sample.bodies);
            let part = parts.iter_mut().find(|part| part.from <= sample.time && sample.time < part.to);
            if let Some(Part { clip, .. }) = part {
                // Times of a film increase, in single precision: of two samples at one, as a stage has, the later one stays.
                let since = |time: f64| (time - clip.times.first().copied().unwrap_or(time)) as f32;
                if clip.times.last().is_some_and(|last| since(sample.time) <= since(*last)) {
                    clip.times.pop();
                    clip.poses.pop();
                    clip.loads.pop();
                }
                clip.times.push(sample.time);
                if !self.tubes.is_empty() && !is_poses {
                    clip.loads.push(self.tubes.loads(&sample.bodies, &sample.reactions));
                }
                clip.poses.push(sample.bodies);
            }
        }
        Ok(parts.into_iter().map(|part| part.clip).filter(|clip| !clip.times.is_empty()).collect())
    }

    /// What the beams of a sample from here bear, in the order of their cross sections; `None` of a recording of poses alone.
    pub fn loads(&self, sample: &OwnedSample) -> Option<Vec<f64>> {
        let known = !self.tubes.is_empty() && !holds_poses(self.recording.outcome.as_deref());
        known.then(|| self.tubes.loads(&sample.bodies, &sample.reactions))
    }

    /// What is drawn of it, sized by these poses.
    pub fn drawing(&self, poses: &[Pose], extras: Extras) -> Drawing {
        Drawing::new(&self.recording.scene, poses, extras)
    }
}

/// `mode 1: 1.2500 Hz`: what the motion of a mode is called, from its index, frequency (Hz) and growth rate (1/s).
pub fn mode_name(index: usize, hz: f64, growth: f64) -> String {
    match growth > 0.0 {
        true => format!("mode {}: grows {growth:.4} per second", index + 1),
        false => format!("mode {}: {hz:.4} Hz", index + 1),
    }
}

/// Whether what was recorded are poses alone, without what holds them.
pub(super) fn holds_poses(outcome: Option<&str>) -> bool {
    let outcome: Value = outcome.and_then(|json| serde_json::from_str(json).ok()).unwrap_or_default();
    ["modes", "iterates", "collapse"].iter().any(|key| !outcome[key].is_null())
}

/// A stretch of the recording's time.
struct Part {
    from: f64,
    to: f64,
    clip: Clip,
}

/// All of it, or its modes by the summary at its end.
fn parts(outcome: Option<&str>) -> Vec<Part> {
    let outcome: Value = outcome.and_then(|json| serde_json::from_str(json).ok()).unwrap_or_default();
    let clip = |name: String| Clip { name, ..Clip::default() };
    let mode = |(index, mode): (usize, &Value)| {
        let [hz, growth] = ["frequency_hz", "growth_rate"].map(|key| mode[key].as_f64().unwrap_or_default());
        let name = mode_name(index, hz, growth);
        Some(Part { from: mode["from"].as_f64()?, to: mode["to"].as_f64()?, clip: clip(name) })
    };
    let modes: Vec<Part> = outcome["modes"].as_array().into_iter().flatten().enumerate().filter_map(mode).collect();
    match modes.is_empty() {
        true => vec![Part { from: f64::NEG_INFINITY, to: f64::INFINITY, clip: clip("run".to_owned()) }],
        false => modes,
    }
}
