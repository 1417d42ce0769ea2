//! The records of an MCAP file from front to back, as far as it goes.

use mcap::McapError;
use mcap::records::{Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::io::{self, Read};

/// Longest record or chunk that is believed; a damaged length would ask for any amount of memory. Chunks of ours are
/// little over a mebibyte, descriptions of the largest scenes some ten.
const LONGEST: usize = 1 << 28;

/// Reads records one after the other, holding one chunk in memory at most.
pub(super) struct Records<R> {
    source: R,
    reader: LinearReader,
    over: bool,
    passed: u64,
}

/// Why reading stopped before the end of the file's format.
#[derive(Debug)]
pub(super) enum Stop {
    /// The file ends in the middle: its writer was killed, or is still writing.
    Truncated,
    /// The content is wrong.
    Damaged(McapError),
    /// The file cannot be read.
    Io(io::Error),
}

impl<R: Read> Records<R> {
    /// Chunks come as records of their own, not unpacked.
    pub(super) fn outline(source: R) -> Self {
        Self::new(source, LinearReaderOptions::default().with_emit_chunks(true))
    }

    /// Chunks are checked, unpacked, and their messages come as records.
    pub(super) fn contents(source: R) -> Self {
        Self::new(source, LinearReaderOptions::default().with_prevalidate_chunk_crcs(true))
    }

    fn new(source: R, options: LinearReaderOptions) -> Self {
        let reader = LinearReader::new_with_options(options.with_record_length_limit(LONGEST));
        Self { source, reader, over: false, passed: mcap::MAGIC.len() as u64 }
    }

    /// Where the last whole record ended (bytes from the start of the file); of an outline only.
    pub(super) fn passed(&self) -> u64 {
        self.passed
    }

    /// The next record; `None` after the last one of a whole file, an error once where the file stops early.
    pub(super) fn next(&mut self) -> Option<Result<Record<'static>, Stop>> {
        if self.over {
            return None;
        }
        loop {
            let need = match self.reader.next_event() {
                None => {
                    self.over = true;
                    return None;
                }
                Some(Err(error)) => {
                    self.over = true;
                    return Some(Err(stop(error)));
                }
                Some(Ok(LinearReadEvent::ReadRequest(need))) => need,
                Some(Ok(LinearReadEvent::Record { data, opcode })) => {
                    // An opcode and a length stand before it.
                    self.passed += 9 + data.len() as u64;
                    let record = match opcode == op::ATTACHMENT && !is_attachment(data) {
                        true => Err(McapError::UnexpectedEoc),
                        false => mcap::parse_record(opcode, data).map(Record::into_owned),
                    };
                    self.over = record.is_err();
                    return Some(record.map_err(stop));
                }
            };
            match read(&mut self.source, self.reader.insert(need)) {
                Ok(count) => self.reader.notify_read(count),
                Err(error) => {
                    self.over = true;
                    return Some(Err(Stop::Io(error)));
                }
            }
        }
    }
}

/// Whether the lengths in an attachment's record fit into it, which the parser takes for granted.
fn is_attachment(record: &[u8]) -> bool {
    // Two times, two texts, the content, a checksum.
    let text = |rest: &mut &[u8]| -> Option<()> {
        let (length, after) = rest.split_first_chunk::<4>()?;
        *rest = after.split_at_checked(u32::from_le_bytes(*length) as usize)?.1;
        Some(())
    };
    let mut rest = record.get(16..).unwrap_or_default();
    text(&mut rest).and_then(|()| text(&mut rest)).is_some() && rest.len() >= 12
}

fn read(source: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    loop {
        match source.read(buffer) {
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            result => return result,
        }
    }
}

fn stop(error: McapError) -> Stop {
    match error {
        McapError::UnexpectedEof | McapError::UnexpectedEoc => Stop::Truncated,
        other => Stop::Damaged(other),
    }
}
