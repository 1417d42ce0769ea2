//! The records of an MCAP file from front to back, as far as it goes.

use super::layout::fits;
use crate::budget;
use crate::foreign;
use mcap::McapError;
use mcap::records::{ChunkHeader, Record, op};
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::io::{self, Cursor, Read};

/// What messages call the parser.
const PARSER: &str = "the reader of MCAP files";

/// Reads records one after the other, holding one chunk in memory at most.
pub(super) struct Records<R> {
    file: Reader<R>,
    /// The chunk that is being read; `None` between chunks.
    chunk: Option<Reader<Cursor<Vec<u8>>>>,
    unpacks: bool,
    /// Bytes that the chunks up to here say they unpack to, and how many they may.
    claimed: u64,
    allowed: u64,
}

/// Why reading stopped before the end of the file's format.
#[derive(Debug)]
pub(super) enum Stop {
    /// The file ends in the middle: its writer was killed, or is still writing.
    Truncated,
    /// The content is wrong.
    Damaged(String),
    /// The file cannot be read.
    Io(io::Error),
}

impl<R: Read> Records<R> {
    /// Chunks come as records of their own, not unpacked. `length` is that of the file in bytes.
    pub(super) fn outline(source: R, length: u64) -> Self {
        Self { file: Reader::new(source), chunk: None, unpacks: false, claimed: 0, allowed: unpacked(length) }
    }

    /// Chunks are checked, unpacked, and their messages come as records.
    pub(super) fn contents(source: R, length: u64) -> Self {
        Self { unpacks: true, ..Self::outline(source, length) }
    }

    /// Where the last whole record ended (bytes from the start of the file); of an outline only.
    pub(super) fn passed(&self) -> u64 {
        self.file.passed
    }

    /// The next record; `None` after the last one of a whole file, an error once where the file stops early.
    pub(super) fn next(&mut self) -> Option<Result<Record<'static>, Stop>> {
        loop {
            if let Some(chunk) = &mut self.chunk {
                match chunk.next() {
                    Some(Ok(Record::Footer(_))) => continue,
                    Some(Ok(record)) => return Some(Ok(record)),
                    Some(Err(stop)) => {
                        self.file.over = true;
                        self.chunk = None;
                        return Some(Err(Stop::Damaged(stop.within_chunk())));
                    }
                    None => self.chunk = None,
                }
            }
            let record = match self.file.next()? {
                Ok(record) => record,
                Err(stop) => return Some(Err(stop)),
            };
            let Record::Chunk { header, data } = &record else { return Some(Ok(record)) };
            if let Err(what) = self.check(header) {
                self.file.over = true;
                return Some(Err(Stop::Damaged(what)));
            }
            if !self.unpacks {
                return Some(Ok(record));
            }
            self.chunk = Some(Reader::of_chunk(header, data));
        }
    }

    /// Whether a chunk keeps within the budgets, by its own words. That it keeps its word is checked when it is unpacked.
    fn check(&mut self, header: &ChunkHeader) -> Result<(), String> {
        let size = header.uncompressed_size;
        let most = unpacked(header.compressed_size).min(budget::CHUNK_BYTES);
        if size > most {
            let packed = header.compressed_size;
            return Err(format!(
                "a chunk of {size} bytes unpacked, where at most {most} are read of {packed} packed ones"
            ));
        }
        self.claimed = self.claimed.saturating_add(size);
        if self.claimed > self.allowed {
            let Self { claimed, allowed, .. } = self;
            return Err(format!(
                "chunks of {claimed} bytes unpacked, where at most {allowed} are read of a file of this size"
            ));
        }
        Ok(())
    }
}

/// The most that so many bytes may unpack to.
fn unpacked(packed: u64) -> u64 {
    packed.saturating_mul(budget::UNPACKED_RATIO).saturating_add(budget::UNPACKED_BYTES)
}

/// Calls `take` with the records of a chunk, as they lie in it. It may have been called when the chunk turns out to be damaged.
pub(super) fn each_of_chunk(header: &ChunkHeader, data: &[u8], take: &mut dyn FnMut(Record<'_>)) -> Result<(), String> {
    let Reader { mut source, mut reader, .. } = Reader::of_chunk(header, data);
    let damaged = |error: McapError| stop(error).within_chunk();
    let each = || {
        while let Some(event) = reader.next_event() {
            match event.map_err(damaged)? {
                LinearReadEvent::ReadRequest(need) => {
                    let count = read(&mut source, reader.insert(need)).map_err(|error| error.to_string())?;
                    reader.notify_read(count);
                }
                LinearReadEvent::Record { data, opcode } if fits(opcode, data) => {
                    take(mcap::parse_record(opcode, data).map_err(damaged)?);
                }
                LinearReadEvent::Record { opcode, .. } => return Err(unfit(opcode)),
            }
        }
        Ok(())
    };
    foreign::parse(PARSER, each).unwrap_or_else(Err)
}

/// What a record says that is too short for its parts.
fn unfit(opcode: u8) -> String {
    format!("a record of kind {opcode:#04x} is shorter than what it says of its parts")
}

impl Stop {
    fn within_chunk(self) -> String {
        match self {
            Self::Truncated => "a chunk ends in the middle of a record".to_owned(),
            Self::Damaged(what) => what,
            Self::Io(error) => error.to_string(),
        }
    }
}

/// The records of a file or of one chunk; chunks of a file come whole.
struct Reader<R> {
    source: R,
    reader: LinearReader,
    over: bool,
    passed: u64,
}

/// What the parser wants or has.
enum Step {
    Read(usize),
    Record(Box<Record<'static>>, u64),
    Failed(McapError),
    Unfit(u8),
    Over,
}

impl Reader<Cursor<Vec<u8>>> {
    /// A file that holds nothing but this chunk, for the parser that checks and unpacks files.
    fn of_chunk(header: &ChunkHeader, data: &[u8]) -> Self {
        let mut chunk = Vec::new();
        for number in [header.message_start_time, header.message_end_time, header.uncompressed_size] {
            chunk.extend(number.to_le_bytes());
        }
        chunk.extend(header.uncompressed_crc.to_le_bytes());
        chunk.extend((header.compression.len() as u32).to_le_bytes());
        chunk.extend(header.compression.as_bytes());
        chunk.extend((data.len() as u64).to_le_bytes());
        let mut file = mcap::MAGIC.to_vec();
        file.push(op::CHUNK);
        file.extend(((chunk.len() + data.len()) as u64).to_le_bytes());
        file.extend(chunk);
        file.extend(data);
        file.push(op::FOOTER);
        file.extend(20_u64.to_le_bytes());
        file.extend([0; 20]);
        file.extend(mcap::MAGIC);
        let options = LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(usize::try_from(budget::CHUNK_BYTES).unwrap_or(usize::MAX));
        let reader = LinearReader::new_with_options(options);
        Self { source: Cursor::new(file), reader, over: false, passed: 0 }
    }
}

impl<R: Read> Reader<R> {
    fn new(source: R) -> Self {
        // A damaged length would ask for any amount of memory.
        let options =
            LinearReaderOptions::default().with_emit_chunks(true).with_record_length_limit(budget::RECORD_BYTES);
        let reader = LinearReader::new_with_options(options);
        Self { source, reader, over: false, passed: mcap::MAGIC.len() as u64 }
    }

    fn next(&mut self) -> Option<Result<Record<'static>, Stop>> {
        while !self.over {
            let step = foreign::parse(PARSER, || step(&mut self.reader));
            let ended = match step {
                Ok(Step::Read(need)) => match read(&mut self.source, self.reader.insert(need)) {
                    Ok(count) => {
                        self.reader.notify_read(count);
                        continue;
                    }
                    Err(error) => Some(Err(Stop::Io(error))),
                },
                Ok(Step::Record(record, length)) => {
                    self.passed += length;
                    return Some(Ok(*record));
                }
                Ok(Step::Over) => None,
                Ok(Step::Failed(error)) => Some(Err(stop(error))),
                Ok(Step::Unfit(opcode)) => Some(Err(Stop::Damaged(unfit(opcode)))),
                Err(panicked) => Some(Err(Stop::Damaged(panicked))),
            };
            self.over = true;
            return ended;
        }
        None
    }
}

fn step(reader: &mut LinearReader) -> Step {
    match reader.next_event() {
        None => Step::Over,
        Some(Err(error)) => Step::Failed(error),
        Some(Ok(LinearReadEvent::ReadRequest(need))) => Step::Read(need),
        Some(Ok(LinearReadEvent::Record { data, opcode })) => {
            // The parser reserves room for what a length says.
            if !fits(opcode, data) {
                return Step::Unfit(opcode);
            }
            // An opcode and a length stand before it.
            let length = 9 + data.len() as u64;
            match mcap::parse_record(opcode, data) {
                Ok(record) => Step::Record(Box::new(record.into_owned()), length),
                Err(error) => Step::Failed(error),
            }
        }
    }
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
        other => Stop::Damaged(other.to_string()),
    }
}
