//! Reading a recording: its samples.

use super::chunks::{Records, Stop};
use super::frames;
use super::numbers::{each_field, get_row};
use super::*;
use crate::foreign;
use crate::record::{Energy, OwnedSample, RecordError, Scene};
use crate::spatial::Wrench;
use foxglove::messages::FrameTransforms;
use mcap::records::{MessageHeader, Record};
use nalgebra::Vector3;
use prost::Message;
use std::collections::HashMap;
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

/// The samples of a recording in the order they were written.
///
/// If the file was cut, the iteration ends with the last whole chunk, without an error:
/// [`Recording::complete`](super::Recording::complete) tells. If the content is wrong, it ends with one.
pub struct Samples {
    path: PathBuf,
    records: Records<BufReader<File>>,
    assembly: Assembly,
    over: bool,
}

/// Makes samples of the messages that they were written as, and judges them: whoever reads a recording, counts what is in it or recovers it
/// finds the same samples damaged.
pub(super) struct Assembly {
    topics: HashMap<u16, Topic>,
    blank: OwnedSample,
    /// The sample whose messages are coming, and their sequence number.
    begun: Option<(OwnedSample, u32)>,
    /// Time of the last whole sample (s).
    last: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Topic {
    Hinges,
    Energy,
    Reactions,
    Couplings,
    Outputs,
    Frames,
}

impl Assembly {
    pub(super) fn new(scene: &Scene) -> Self {
        let blank = OwnedSample {
            positions: vec![0.0; scene.positions.len()],
            velocities: vec![0.0; scene.velocities.len()],
            accelerations: vec![0.0; scene.velocities.len()],
            bodies: Vec::with_capacity(scene.bodies.len()),
            reactions: vec![Wrench::default(); scene.bodies.len()],
            couplings: vec![0.0; scene.couplings.len()],
            outputs: vec![0.0; scene.outputs.len()],
            ..OwnedSample::default()
        };
        Self { topics: HashMap::new(), blank, begun: None, last: f64::NEG_INFINITY }
    }

    /// Takes note of a channel.
    pub(super) fn channel(&mut self, id: u16, name: &str) {
        self.topics.extend(topic(name).map(|topic| (id, topic)));
    }

    /// Takes a message; with the last one of a sample that is whole. Times of samples are finite and do not decrease.
    pub(super) fn message(&mut self, header: &MessageHeader, data: &[u8]) -> Result<Option<OwnedSample>, String> {
        let Some(&topic) = self.topics.get(&header.channel_id) else { return Ok(None) };
        let bodies = self.blank.reactions.len();
        let (sample, sequence) = self.begun.get_or_insert_with(|| (self.blank.clone(), header.sequence));
        if *sequence != header.sequence {
            return Err(wrong("a sample without all its messages", header));
        }
        let decoded = match topic {
            Topic::Hinges => get_hinges(data, sample),
            Topic::Energy => get_energy(data, &mut sample.energy),
            Topic::Reactions => get_reactions(data, &mut sample.reactions),
            Topic::Couplings => get_timed(data, &mut sample.couplings),
            Topic::Outputs => get_timed(data, &mut sample.outputs),
            Topic::Frames => get_frames(data, bodies, sample),
        };
        decoded.ok_or_else(|| wrong("a message that does not fit the scene", header))?;
        // The last one written of each sample.
        if topic != Topic::Frames {
            return Ok(None);
        }
        let Some((sample, _)) = self.begun.take() else { return Ok(None) };
        if !(sample.time >= self.last && sample.time.is_finite()) {
            return Err(match self.last == f64::NEG_INFINITY {
                true => format!("its first sample is at {} s", sample.time),
                false => format!("a sample at {} s comes after one at {} s", sample.time, self.last),
            });
        }
        self.last = sample.time;
        Ok(Some(sample))
    }

    /// Whether the last sample that was begun is whole.
    pub(super) fn is_between_samples(&self) -> bool {
        self.begun.is_none()
    }

    /// Forgets what was begun, but not the time of the last whole sample.
    pub(super) fn reset(&mut self) {
        self.begun = None;
    }
}

impl Samples {
    pub(super) fn new(path: PathBuf, records: Records<BufReader<File>>, scene: &Scene) -> Self {
        Self { path, records, assembly: Assembly::new(scene), over: false }
    }

    /// Reads the messages of one sample, which follow one another.
    fn read(&mut self) -> Result<Option<OwnedSample>, String> {
        loop {
            match self.records.next() {
                Some(Ok(Record::Message { header, data })) => {
                    if let Some(sample) = self.assembly.message(&header, &data)? {
                        return Ok(Some(sample));
                    }
                }
                Some(Ok(Record::Channel(channel))) => self.assembly.channel(channel.id, &channel.topic),
                Some(Ok(_)) => {}
                None | Some(Err(Stop::Truncated)) => return Ok(None),
                Some(Err(Stop::Damaged(what))) => return Err(what),
                Some(Err(Stop::Io(error))) => return Err(error.to_string()),
            }
        }
    }
}

impl Iterator for Samples {
    type Item = Result<OwnedSample, RecordError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.over {
            return None;
        }
        let read = self.read().map_err(|what| RecordError::Damaged { path: self.path.clone(), what });
        self.over = !matches!(read, Ok(Some(_)));
        read.transpose()
    }
}

fn wrong(what: &str, header: &MessageHeader) -> String {
    format!("{what}, at {} s", header.log_time as f64 * 1e-9)
}

fn topic(name: &str) -> Option<Topic> {
    match name {
        HINGES_TOPIC => Some(Topic::Hinges),
        ENERGY_TOPIC => Some(Topic::Energy),
        REACTIONS_TOPIC => Some(Topic::Reactions),
        COUPLINGS_TOPIC => Some(Topic::Couplings),
        OUTPUTS_TOPIC => Some(Topic::Outputs),
        FRAMES_TOPIC => Some(Topic::Frames),
        _ => None,
    }
}

fn get_hinges(message: &[u8], sample: &mut OwnedSample) -> Option<()> {
    each_field(message, |index, field| match index {
        0 => field.number().map(|time| sample.time = time),
        1 => get_row(field.message()?, &mut sample.positions),
        2 => get_row(field.message()?, &mut sample.velocities),
        3 => get_row(field.message()?, &mut sample.accelerations),
        _ => None,
    })
}

fn get_energy(message: &[u8], energy: &mut Energy) -> Option<()> {
    let mut row = [0.0; 6];
    get_row(message, &mut row)?;
    let [_, kinetic, potential, work, dissipated, error] = row;
    *energy = Energy { kinetic, potential, work, dissipated, error };
    Some(())
}

fn get_reactions(message: &[u8], reactions: &mut [Wrench]) -> Option<()> {
    each_field(message, |body, wrench| {
        let reaction = reactions.get_mut(body)?;
        each_field(wrench.message()?, |index, vector| {
            let mut row = [0.0; 3];
            get_row(vector.message()?, &mut row)?;
            match index {
                0 => reaction.force = Vector3::from(row),
                1 => reaction.moment = Vector3::from(row),
                _ => return None,
            }
            Some(())
        })
    })
}

/// The numbers after the time.
fn get_timed(message: &[u8], numbers: &mut [f64]) -> Option<()> {
    each_field(message, |index, field| match index.checked_sub(1) {
        None => Some(()),
        Some(index) => field.number().zip(numbers.get_mut(index)).map(|(number, slot)| *slot = number),
    })
}

fn get_frames(message: &[u8], bodies: usize, sample: &mut OwnedSample) -> Option<()> {
    let message = foreign::parse("the reader of protobuf", || FrameTransforms::decode(message)).ok()?.ok()?;
    sample.bodies.extend(frames::poses(&message));
    (sample.bodies.len() == bodies).then_some(())
}
