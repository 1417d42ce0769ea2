//! What is in a recording, counted message by message.

use super::Recording;
use super::chunks::{Records, Stop, each_of_chunk};
use super::reader::open;
use super::samples::Assembly;
use crate::record::RecordError;
use mcap::records::Record;
use std::collections::BTreeMap;

/// What a recording holds, counted to its last readable message.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Survey {
    /// Size of the file (bytes).
    pub bytes: u64,
    /// The channels in the order of their numbers.
    pub channels: Vec<ChannelSurvey>,
    /// Name, media type and size (bytes) of every attachment.
    pub attachments: Vec<(String, String, usize)>,
    /// Names of the metadata records.
    pub metadata: Vec<String>,
    /// Why reading stopped in the middle of the file: what is wrong there. A file that was cut is not damaged.
    pub damage: Option<String>,
}

/// A channel and its messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelSurvey {
    /// Topic.
    pub topic: String,
    /// Name of the schema of its messages.
    pub schema: String,
    /// How messages are encoded.
    pub encoding: String,
    /// Field → name in the scenario and unit.
    pub fields: BTreeMap<String, String>,
    /// How many messages there are.
    pub messages: u64,
    /// Log times of the first and the last one (ns of simulated time).
    pub span: Option<(u64, u64)>,
}

impl Recording {
    /// Counts what is in the file: reads and checks all of it once.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn survey(&self) -> Result<Survey, RecordError> {
        let failed = |source| RecordError::Read { path: self.path.clone(), source };
        let (source, bytes) = open(&self.path)?;
        let mut counted = Counted {
            survey: Survey { bytes, ..Survey::default() },
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            assembly: Assembly::new(&self.scene),
        };
        let mut records = Records::outline(source, bytes);
        loop {
            match records.next() {
                // Its messages are counted as they lie in it.
                Some(Ok(Record::Chunk { header, data })) => {
                    let read = each_of_chunk(&header, &data, &mut |record| counted.take(record));
                    counted.survey.damage = counted.survey.damage.take().or(read.err());
                    if counted.survey.damage.is_some() {
                        break;
                    }
                }
                Some(Ok(record)) => counted.take(record),
                None | Some(Err(Stop::Truncated)) => break,
                Some(Err(Stop::Damaged(what))) => {
                    counted.survey.damage = Some(what);
                    break;
                }
                Some(Err(Stop::Io(source))) => return Err(failed(source)),
            }
        }
        let Counted { mut survey, channels, .. } = counted;
        survey.channels = channels.into_values().collect();
        Ok(survey)
    }
}

/// What was counted so far.
struct Counted {
    survey: Survey,
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, ChannelSurvey>,
    assembly: Assembly,
}

impl Counted {
    fn take(&mut self, record: Record<'_>) {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) => {
                self.assembly.channel(channel.id, &channel.topic);
                // They stand once more in the summary.
                self.channels.entry(channel.id).or_insert_with(|| ChannelSurvey {
                    topic: channel.topic,
                    schema: self.schemas.get(&channel.schema_id).cloned().unwrap_or_default(),
                    encoding: channel.message_encoding,
                    fields: channel.metadata,
                    messages: 0,
                    span: None,
                });
            }
            Record::Message { header, data } => {
                if self.survey.damage.is_none() {
                    self.survey.damage = self.assembly.message(&header, &data).err();
                }
                if let Some(channel) = self.channels.get_mut(&header.channel_id) {
                    channel.messages += 1;
                    let (first, last) = channel.span.unwrap_or((header.log_time, header.log_time));
                    channel.span = Some((first.min(header.log_time), last.max(header.log_time)));
                }
            }
            Record::Attachment { header, data, .. } => {
                self.survey.attachments.push((header.name, header.media_type, data.len()));
            }
            Record::Metadata(metadata) => self.survey.metadata.push(metadata.name),
            _ => {}
        }
    }
}
