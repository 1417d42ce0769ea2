//! How the records of MCAP are laid out, as far as lengths are written in them: a length that claims more than the record
//! holds is found before a parser reserves room for it.

use mcap::records::op;

/// A part of a record.
enum Part {
    /// So many bytes.
    Fixed(usize),
    /// Four bytes of length, then so many bytes.
    Text,
    /// Four bytes of length, then texts in pairs.
    Texts,
    /// Eight bytes of length, then so many bytes.
    Content,
}
use Part::*;

/// The parts of a record up to the last length in it; none for kinds in which there is no length.
fn parts(opcode: u8) -> &'static [Part] {
    match opcode {
        op::HEADER => &[Text, Text],
        op::SCHEMA => &[Fixed(2), Text, Text, Text],
        op::CHANNEL => &[Fixed(4), Text, Text, Texts],
        op::CHUNK => &[Fixed(28), Text, Content],
        op::MESSAGE_INDEX => &[Fixed(2), Text],
        op::CHUNK_INDEX => &[Fixed(32), Text, Fixed(8), Text, Fixed(16)],
        op::ATTACHMENT => &[Fixed(16), Text, Text, Content, Fixed(4)],
        op::ATTACHMENT_INDEX => &[Fixed(40), Text, Text],
        op::STATISTICS => &[Fixed(42), Text],
        op::METADATA => &[Text, Texts],
        op::METADATA_INDEX => &[Fixed(16), Text],
        _ => &[],
    }
}

/// Whether every part of a record lies in it.
pub(super) fn fits(opcode: u8, record: &[u8]) -> bool {
    let mut rest = record;
    parts(opcode).iter().all(|part| skip(part, &mut rest).is_some())
}

fn skip(part: &Part, rest: &mut &[u8]) -> Option<()> {
    match part {
        Fixed(count) => take(*count, rest).map(drop),
        Text => text(rest).map(drop),
        Texts => {
            let mut pairs = text(rest)?;
            while !pairs.is_empty() {
                text(&mut pairs)?;
                text(&mut pairs)?;
            }
            Some(())
        }
        Content => {
            let (length, after) = rest.split_first_chunk::<8>()?;
            *rest = after;
            take(usize::try_from(u64::from_le_bytes(*length)).ok()?, rest).map(drop)
        }
    }
}

fn text<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let (length, after) = rest.split_first_chunk::<4>()?;
    *rest = after;
    take(u32::from_le_bytes(*length) as usize, rest)
}

fn take<'a>(count: usize, rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let (part, after) = rest.split_at_checked(count)?;
    *rest = after;
    Some(part)
}
