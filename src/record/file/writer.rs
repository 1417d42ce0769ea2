//! Writing while a run goes on.

use super::numbers::{put_more, put_nested, put_nested_row, put_row, row_length};
use super::partial::Paths;
use super::pictures::scene_update;
use super::ros::{self, Joints};
use super::schema::{self, Schema};
use super::*;
use super::{contacts, events, frames};
use crate::record::{ContactPush, Event, Opening, Outcome, RecordError, Recorder, Sample, Scene};
use crate::spatial::Wrench;
use crate::whole_file;
use foxglove::Encode;
use foxglove::messages::{FrameTransforms, Log, SceneUpdate};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, Compression, McapError, McapResult, WriteOptions};
use prost::Message;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Seek, Write};
use std::time::{Duration, Instant};

/// A chunk is closed and flushed when it is this old, so that a killed run loses little …
const FLUSH_PERIOD: Duration = Duration::from_millis(500);
/// … and when it is this long before compression, so that readers need not hold much.
const CHUNK_BYTES: usize = 1 << 20;

/// Writes the samples of a run to an MCAP file; see [`file`](super) for the layout.
///
/// Dropped without [`finish`](Recorder::finish), it leaves a readable `.partial` file.
pub struct FileWriter {
    paths: Paths,
    /// `None` once finished or failed.
    output: Option<Output<File>>,
    scene: Scene,
    transforms: FrameTransforms,
    /// On what earlier runs left: as long as it lives, no other run writes this output.
    _locks: Vec<File>,
}

impl FileWriter {
    pub(super) fn begin(
        file: File,
        paths: Paths,
        opening: &Opening,
        ros: bool,
        locks: Vec<File>,
    ) -> Result<Self, RecordError> {
        let output = Output::begin(file, opening, ros)
            .map_err(|error| RecordError::Create { path: paths.asked.clone(), source: io_error(error) })?;
        let transforms = frames::transforms(opening.scene);
        Ok(Self { paths, output: Some(output), scene: opening.scene.clone(), transforms, _locks: locks })
    }

    /// After a failure nothing more is written.
    fn lost_where_failed(&mut self, written: McapResult<()>) -> Result<(), RecordError> {
        written.map_err(|error| {
            self.output = None;
            self.failed(error)
        })
    }

    fn failed(&self, error: McapError) -> RecordError {
        let kept = self.paths.place.is_some();
        RecordError::Write { path: self.paths.written.clone(), source: io_error(error), kept }
    }

    /// Where the finished recording will be.
    pub fn path(&self) -> &std::path::Path {
        &self.paths.asked
    }
}

impl Recorder for FileWriter {
    fn sample(&mut self, sample: &Sample) -> Result<(), RecordError> {
        sample.check(&self.scene)?;
        let Some(output) = &mut self.output else {
            return Err(self.failed(McapError::AttemptedWriteAfterFailure));
        };
        let written = output.sample(sample, &mut self.transforms);
        self.lost_where_failed(written)
    }

    fn event(&mut self, event: &Event) -> Result<(), RecordError> {
        let Some(output) = &mut self.output else {
            return Err(self.failed(McapError::AttemptedWriteAfterFailure));
        };
        let written = output.event(event);
        self.lost_where_failed(written)
    }

    fn contacts(&mut self, time: f64, contacts: &[ContactPush]) -> Result<(), RecordError> {
        let Some(output) = &mut self.output else {
            return Err(self.failed(McapError::AttemptedWriteAfterFailure));
        };
        let written = output.contacts(time, contacts);
        self.lost_where_failed(written)
    }

    fn pause(&mut self) -> Result<(), RecordError> {
        let written = self.output.as_mut().map_or(Ok(()), Output::pause);
        self.lost_where_failed(written)
    }

    fn finish(&mut self, outcome: &Outcome) -> Result<(), RecordError> {
        let Some(output) = self.output.take() else { return Ok(()) };
        // The file carries the lock: it lives until it has its name.
        let file = output.finish(outcome).map_err(|error| self.failed(error))?;
        let Some(place) = &self.paths.place else { return Ok(()) };
        let named = file
            .sync_all()
            .and_then(|()| std::fs::rename(&self.paths.written, place))
            .and_then(|()| whole_file::sync_folder(place));
        named.map_err(|error| self.failed(error.into()))
    }
}

fn io_error(error: McapError) -> io::Error {
    match error {
        McapError::Io(source) => source,
        other => io::Error::other(other),
    }
}

/// The open file and everything that is reused from sample to sample.
pub(super) struct Output<W: Write + Seek> {
    mcap: mcap::Writer<BufWriter<W>>,
    channels: Channels,
    joints: Option<(u16, Joints)>,
    sequence: u32,
    /// What contacts pushed with when that was last written.
    pushes: Vec<ContactPush>,
    buffer: Vec<u8>,
    chunk_bytes: usize,
    flushed: Instant,
    paused: Instant,
}

#[derive(Clone, Copy)]
struct Channels {
    hinges: u16,
    energy: u16,
    reactions: u16,
    /// `None` if nothing couples hinges.
    couplings: Option<u16>,
    /// `None` for a scene without outputs.
    outputs: Option<u16>,
    frames: u16,
    /// Of a scene with contact.
    contacts: Option<u16>,
    /// Of a run that has had any.
    events: Option<u16>,
}

impl<W: Write + Seek> Output<W> {
    pub(super) fn begin(file: W, opening: &Opening, ros: bool) -> McapResult<Self> {
        let mut mcap = options().create(BufWriter::new(file))?;
        describe(&mut mcap, opening)?;
        let scene = opening.scene;
        let pictures = foxglove_channel::<SceneUpdate, _>(&mut mcap, SCENE_TOPIC)?;
        let channels = Channels {
            hinges: number_channel(&mut mcap, HINGES_TOPIC, schema::hinges(scene))?,
            energy: number_channel(&mut mcap, ENERGY_TOPIC, schema::energy())?,
            reactions: number_channel(&mut mcap, REACTIONS_TOPIC, schema::reactions(scene))?,
            couplings: match scene.couplings.is_empty() {
                true => None,
                false => Some(number_channel(&mut mcap, COUPLINGS_TOPIC, schema::couplings(scene))?),
            },
            outputs: match scene.outputs.is_empty() {
                true => None,
                false => Some(number_channel(&mut mcap, OUTPUTS_TOPIC, schema::outputs(scene))?),
            },
            frames: foxglove_channel::<FrameTransforms, _>(&mut mcap, FRAMES_TOPIC)?,
            contacts: None,
            events: None,
        };
        let header = MessageHeader { channel_id: pictures, sequence: 0, log_time: 0, publish_time: 0 };
        mcap.write_to_known_channel(&header, &scene_update(scene).encode_to_vec())?;
        if let Some(description) = ros.then(|| ros::description(scene)).flatten() {
            let channel_id = ros_channel(&mut mcap, ROBOT_TOPIC, ros::STRING, ros::STRING_SCHEMA)?;
            mcap.write_to_known_channel(&MessageHeader { channel_id, ..header }, &description)?;
        }
        let joints = match ros.then(|| Joints::new(scene)).flatten() {
            Some(joints) => Some((ros_channel(&mut mcap, JOINTS_TOPIC, ros::JOINTS, ros::JOINTS_SCHEMA)?, joints)),
            None => None,
        };
        mcap.flush()?;
        let now = Instant::now();
        let buffer = Vec::new();
        let pushes = Vec::new();
        Ok(Self { mcap, channels, joints, sequence: 0, pushes, buffer, chunk_bytes: 0, flushed: now, paused: now })
    }

    pub(super) fn sample(&mut self, sample: &Sample, transforms: &mut FrameTransforms) -> McapResult<()> {
        // Negative and not-a-number times become zero; the exact time is in the messages.
        let time = (sample.time * 1e9).round() as u64;
        let channels = self.channels;

        put_hinges(sample, &mut self.buffer);
        self.message(channels.hinges, time)?;
        let energy = &sample.energy;
        let row = [sample.time, energy.kinetic, energy.potential, energy.work, energy.dissipated, energy.error];
        put_row(&row, &mut self.buffer);
        self.message(channels.energy, time)?;
        put_reactions(sample.reactions, &mut self.buffer);
        self.message(channels.reactions, time)?;
        for (channel, row) in [(channels.couplings, sample.couplings), (channels.outputs, sample.outputs)] {
            let Some(channel) = channel else { continue };
            put_row(&[sample.time], &mut self.buffer);
            put_more(1, row, &mut self.buffer);
            self.message(channel, time)?;
        }
        if let Some((channel, joints)) = &self.joints {
            joints.put(sample, time, &mut self.buffer);
            let channel = *channel;
            self.message(channel, time)?;
        }
        // The last one of each sample, for readers.
        frames::fill(transforms, time, sample.bodies);
        Message::encode(&*transforms, &mut self.buffer).map_err(io::Error::other)?;
        self.message(channels.frames, time)?;

        self.sequence = self.sequence.wrapping_add(1);
        if self.chunk_bytes >= CHUNK_BYTES || self.flushed.elapsed() >= FLUSH_PERIOD {
            self.flush()?;
        }
        Ok(())
    }

    /// Flushes what a step gave that took long, all of it: the next one may take as long.
    pub(super) fn pause(&mut self) -> McapResult<()> {
        let before = std::mem::replace(&mut self.paused, Instant::now());
        match self.chunk_bytes > 0 && self.paused - before >= FLUSH_PERIOD {
            true => self.flush(),
            false => Ok(()),
        }
    }

    /// Closes the chunk, so that what is in it outlives this program.
    pub(super) fn flush(&mut self) -> McapResult<()> {
        self.mcap.flush()?;
        self.chunk_bytes = 0;
        self.flushed = Instant::now();
        Ok(())
    }

    fn event(&mut self, event: &Event) -> McapResult<()> {
        let channel = match self.channels.events {
            Some(channel) => channel,
            None => *self.channels.events.insert(foxglove_channel::<Log, _>(&mut self.mcap, EVENTS_TOPIC)?),
        };
        let time = (event.time * 1e9).round() as u64;
        Message::encode(&events::log(event, time), &mut self.buffer).map_err(io::Error::other)?;
        self.message(channel, time)
    }

    fn contacts(&mut self, time: f64, pushes: &[ContactPush]) -> McapResult<()> {
        let channel = match self.channels.contacts {
            Some(_) if self.pushes == pushes => return Ok(()),
            Some(channel) => channel,
            None => {
                let schema = self.mcap.add_schema(contacts::NAME, "jsonschema", contacts::schema().as_bytes())?;
                let channel = self.mcap.add_channel(schema, CONTACTS_TOPIC, "json", &BTreeMap::new())?;
                *self.channels.contacts.insert(channel)
            }
        };
        contacts::message(time, pushes, &mut self.buffer).map_err(io::Error::other)?;
        self.message(channel, (time * 1e9).round() as u64)?;
        self.pushes.clear();
        self.pushes.extend_from_slice(pushes);
        Ok(())
    }

    /// Writes the buffer as a message and empties it.
    fn message(&mut self, channel_id: u16, time: u64) -> McapResult<()> {
        let header = MessageHeader { channel_id, sequence: self.sequence, log_time: time, publish_time: time };
        self.mcap.write_to_known_channel(&header, &self.buffer)?;
        self.chunk_bytes += self.buffer.len();
        self.buffer.clear();
        Ok(())
    }

    /// Writes the end, and gives back what was written to.
    pub(super) fn finish(mut self, outcome: &Outcome) -> McapResult<W> {
        metadata(&mut self.mcap, RUN, &[(JSON, &outcome.summary)])?;
        self.mcap.finish()?;
        Ok(self.mcap.into_inner().into_inner().map_err(io::IntoInnerError::into_error)?)
    }
}

/// How files are written.
pub(super) fn options() -> WriteOptions {
    WriteOptions::new()
        .compression(Some(Compression::Zstd))
        .compression_threads(0)
        .library(concat!("stillpoint ", env!("CARGO_PKG_VERSION")))
        // Chunks are closed here, between samples, and written whole, not patched in place.
        .chunk_size(None)
        .disable_seeking(true)
}

fn describe<W: Write + Seek>(mcap: &mut mcap::Writer<W>, opening: &Opening) -> McapResult<()> {
    mcap.attach(&Attachment {
        log_time: 0,
        create_time: 0,
        name: SCENARIO.into(),
        media_type: "application/toml".into(),
        data: Cow::Borrowed(opening.scenario.as_bytes()),
    })?;
    metadata(mcap, PROGRAM, &[("version", env!("CARGO_PKG_VERSION")), ("format", &FORMAT.to_string())])?;
    let scene = serde_json::to_string(opening.scene).map_err(io::Error::from)?;
    metadata(mcap, SCENE, &[(JSON, &scene)])?;
    opening.statics.map_or(Ok(()), |statics| metadata(mcap, STATICS, &[(JSON, statics)]))
}

fn metadata<W: Write + Seek>(mcap: &mut mcap::Writer<W>, name: &str, entries: &[(&str, &str)]) -> McapResult<()> {
    let metadata = entries.iter().map(|&(key, value)| (key.to_owned(), value.to_owned())).collect();
    mcap.write_metadata(&Metadata { name: name.into(), metadata })
}

fn foxglove_channel<M: Encode, W: Write + Seek>(mcap: &mut mcap::Writer<W>, topic: &str) -> McapResult<u16> {
    let schema = match M::get_schema() {
        Some(schema) => mcap.add_schema(&schema.name, &schema.encoding, &schema.data)?,
        None => 0,
    };
    mcap.add_channel(schema, topic, &M::get_message_encoding(), &BTreeMap::new())
}

fn ros_channel<W: Write + Seek>(mcap: &mut mcap::Writer<W>, topic: &str, name: &str, schema: &str) -> McapResult<u16> {
    let schema = mcap.add_schema(name, "ros2msg", schema.as_bytes())?;
    mcap.add_channel(schema, topic, "cdr", &BTreeMap::new())
}

fn number_channel<W: Write + Seek>(mcap: &mut mcap::Writer<W>, topic: &str, schema: Schema) -> McapResult<u16> {
    let id = mcap.add_schema(schema.name, "protobuf", &schema.data)?;
    mcap.add_channel(id, topic, "protobuf", &schema.fields)
}

fn put_hinges(sample: &Sample, buffer: &mut Vec<u8>) {
    put_row(&[sample.time], buffer);
    put_nested_row(2, sample.positions, buffer);
    put_nested_row(3, sample.velocities, buffer);
    put_nested_row(4, sample.accelerations, buffer);
}

fn put_reactions(reactions: &[Wrench], buffer: &mut Vec<u8>) {
    // Two vectors of three numbers, each with a key and a length of one byte.
    let length = 2 * (2 + row_length(3));
    for (index, wrench) in reactions.iter().enumerate() {
        put_nested(super::numbers::field_number(index), length, buffer);
        put_nested_row(1, wrench.force.as_slice(), buffer);
        put_nested_row(2, wrench.moment.as_slice(), buffer);
    }
}
