//! From a file that was cut or damaged to a whole one.

use super::chunks::{Records, Stop, each_of_chunk};
use super::reader::open;
use super::samples::Assembly;
use super::writer::options;
use super::{FRAMES_TOPIC, JSON, RECOVERED, Recording};
use crate::record::RecordError;
use crate::whole_file::{self, WholeFile};
use mcap::records::{ChunkHeader, MessageHeader, Metadata, Record, op};
use mcap::{Attachment, McapError, McapResult};
use std::collections::BTreeMap;
use std::fs::{File, TryLockError};
use std::io::{self, BufWriter, Read, Seek, SeekFrom};
use std::path::Path;

/// What was saved and what was not.
#[derive(Debug, Clone, PartialEq, Default, serde::Serialize)]
pub struct Recovered {
    /// Whole samples in the new file.
    pub samples: u64,
    /// Messages in the new file.
    pub messages: u64,
    /// Simulated time of the first and the last of them (s).
    pub span: Option<(f64, f64)>,
    /// Chunks that could not be read, in the order of the file.
    pub lost: Vec<Lost>,
    /// Bytes of the old file behind its last whole record.
    pub lost_bytes: u64,
}

/// A chunk that could not be read.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Lost {
    /// Simulated time of its first and its last message, as its header says (s).
    pub span: (f64, f64),
    /// What is wrong with it.
    pub why: String,
}

impl Recording {
    /// Writes everything that can be read of this recording into a finished one at `target`: its description, and the
    /// messages of every intact chunk (its checksum is right), also behind a damaged one. The new file says in its
    /// metadata `recovered` what is missing. This recording stays as it is.
    ///
    /// # Errors
    /// When a run is still writing this recording, when it cannot be read, and when `target` cannot be written; nothing
    /// is left there then.
    pub fn recover(&self, target: &Path) -> Result<Recovered, RecordError> {
        let failed = |source| RecordError::Create { path: target.into(), source };
        if whole_file::is_same(target, &self.path) {
            return Err(failed(io::Error::other("it would replace what is being recovered; choose another name")));
        }
        // The lock lives as long as the file.
        let (lock, _) = open(&self.path)?;
        if let Err(TryLockError::WouldBlock) = lock.get_ref().try_lock_shared() {
            return Err(RecordError::Unfinished { path: self.path.clone() });
        }
        let known = self.definitions()?;
        let file = WholeFile::create(target).map_err(failed)?;
        let written = file.handle().map_err(failed).map(|handle| self.copy(handle, &known))?;
        let written = written.and_then(|recovered| file.finish().map(|()| recovered).map_err(Failure::from));
        written.map_err(|failure| {
            let write = |source| RecordError::Write { path: target.into(), source, kept: false };
            match failure {
                Failure::Read(source) => RecordError::Read { path: self.path.clone(), source },
                Failure::Write(McapError::Io(source)) => write(source),
                Failure::Write(other) => write(io::Error::other(other)),
            }
        })
    }

    /// Schemas and channels of all intact chunks and of the summary: a damaged chunk may have been the one to define
    /// what later ones use.
    fn definitions(&self) -> Result<Definitions, RecordError> {
        let mut known = Definitions::default();
        let (source, bytes) = open(&self.path)?;
        let mut records = Records::outline(source, bytes);
        while let Some(Ok(record)) = records.next() {
            match record {
                Record::Chunk { header, data } => {
                    let _ = each_of_chunk(&header, &data, &mut |record| known.take(record));
                }
                other => known.take(other),
            }
        }
        Ok(known)
    }

    fn copy(&self, file: File, known: &Definitions) -> Result<Recovered, Failure> {
        let read = |error: RecordError| Failure::Read(io::Error::other(error));
        let mut mcap = options().create(BufWriter::new(file))?;
        let mut recovered = Recovered::default();
        let (source, bytes) = open(&self.path).map_err(read)?;
        let mut records = Records::outline(source, bytes);
        known.write(&mut mcap)?;
        let mut assembly = Assembly::new(&self.scene);
        known.channels.values().for_each(|channel| assembly.channel(channel.id, &channel.topic));
        loop {
            match records.next() {
                Some(Ok(Record::Attachment { header, data, .. })) => mcap.attach(&Attachment {
                    log_time: header.log_time,
                    create_time: header.create_time,
                    name: header.name,
                    media_type: header.media_type,
                    data,
                })?,
                Some(Ok(Record::Metadata(metadata))) => mcap.write_metadata(&metadata)?,
                Some(Ok(Record::Chunk { header, data })) => match messages(&header, &data, &mut assembly) {
                    Ok(messages) => {
                        for (header, data) in &messages {
                            recovered.write(&mut mcap, known, header, data)?;
                        }
                        mcap.flush()?;
                    }
                    Err(why) => recovered.lost.push(Lost { span: span(&header), why }),
                },
                Some(Ok(_)) => {}
                Some(Err(Stop::Io(error))) => return Err(Failure::Read(error)),
                Some(Err(stop)) => {
                    recovered.lost_behind(&self.path, records.passed(), &stop).map_err(Failure::Read)?;
                    break;
                }
                None => break,
            }
        }
        if !recovered.is_all() || self.outcome.is_none() {
            let json = serde_json::to_string(&recovered).map_err(io::Error::from)?;
            mcap.write_metadata(&Metadata { name: RECOVERED.into(), metadata: [(JSON.to_owned(), json)].into() })?;
        }
        mcap.finish()?;
        mcap.into_inner().into_inner().map_err(io::IntoInnerError::into_error)?;
        Ok(recovered)
    }
}

enum Failure {
    Read(io::Error),
    Write(McapError),
}

impl From<McapError> for Failure {
    fn from(error: McapError) -> Self {
        Self::Write(error)
    }
}

impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        Self::Write(error.into())
    }
}

impl Recovered {
    /// Whether everything in the old file is in the new one.
    pub fn is_all(&self) -> bool {
        self.lost.is_empty() && self.lost_bytes == 0
    }

    fn write<W: io::Write + Seek>(
        &mut self,
        mcap: &mut mcap::Writer<W>,
        known: &Definitions,
        header: &MessageHeader,
        data: &[u8],
    ) -> McapResult<()> {
        let Some(channel) = known.channels.get(&header.channel_id) else { return Ok(()) };
        mcap.write_to_known_channel(header, data)?;
        self.messages += 1;
        // The last message of each sample.
        if channel.topic == FRAMES_TOPIC {
            self.samples += 1;
            let time = header.log_time as f64 / 1e9;
            self.span = Some((self.span.map_or(time, |(first, _)| first), time));
        }
        Ok(())
    }

    /// What stood behind the last whole record: the header of a cut chunk tells how far it went.
    fn lost_behind(&mut self, path: &Path, passed: u64, stop: &Stop) -> io::Result<()> {
        let mut file = File::open(path)?;
        self.lost_bytes = file.metadata()?.len().saturating_sub(passed);
        let mut start = [0; 25];
        file.seek(SeekFrom::Start(passed))?;
        if file.read_exact(&mut start).is_ok() && start[0] == op::CHUNK {
            let time = |from: usize| {
                let bytes: [u8; 8] = std::array::from_fn(|k| start[from + k]);
                u64::from_le_bytes(bytes) as f64 / 1e9
            };
            let why = match stop {
                Stop::Damaged(what) => what.clone(),
                _ => "the file was cut in it".to_owned(),
            };
            self.lost.push(Lost { span: (time(9), time(17)), why });
        }
        Ok(())
    }
}

/// What messages need to be understood.
#[derive(Default)]
struct Definitions {
    schemas: BTreeMap<u16, (String, String, Vec<u8>)>,
    channels: BTreeMap<u16, mcap::records::Channel>,
}

impl Definitions {
    fn take(&mut self, record: Record<'_>) {
        match record {
            Record::Schema { header, data } => {
                self.schemas.entry(header.id).or_insert_with(|| (header.name, header.encoding, data.into_owned()));
            }
            Record::Channel(channel) => {
                self.channels.entry(channel.id).or_insert(channel);
            }
            _ => {}
        }
    }

    fn write<W: io::Write + Seek>(&self, mcap: &mut mcap::Writer<W>) -> McapResult<()> {
        for (id, (name, encoding, data)) in &self.schemas {
            mcap.add_schema_with_id(*id, name, encoding, data)?;
        }
        for (id, channel) in &self.channels {
            let schema = if self.schemas.contains_key(&channel.schema_id) { channel.schema_id } else { 0 };
            mcap.add_channel_with_id(*id, schema, &channel.topic, &channel.message_encoding, &channel.metadata)?;
        }
        Ok(())
    }
}

fn span(header: &ChunkHeader) -> (f64, f64) {
    (header.message_start_time as f64 / 1e9, header.message_end_time as f64 / 1e9)
}

type Message = (MessageHeader, Vec<u8>);

/// The messages of a chunk, if all of them are intact and make whole samples of the scene.
fn messages(header: &ChunkHeader, data: &[u8], assembly: &mut Assembly) -> Result<Vec<Message>, String> {
    let mut messages = Vec::new();
    let mut decoded = Ok(());
    assembly.reset();
    let mut take = |record: Record<'_>| {
        if let Record::Message { header, data } = record {
            if decoded.is_ok() {
                decoded = assembly.message(&header, &data).map(drop);
            }
            messages.push((header, data.into_owned()));
        }
    };
    each_of_chunk(header, data, &mut take)?;
    decoded?;
    if !assembly.is_between_samples() {
        return Err("its last sample has not all its messages".to_owned());
    }
    Ok(messages)
}
