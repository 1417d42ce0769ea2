//! Rows of doubles as protobuf messages: field k of a message is number k of the row, always written.

use prost::bytes::Buf;
use prost::encoding::{self, WireType};

/// Numbers 19000 to 19999 belong to protobuf itself.
const RESERVED: std::ops::Range<u32> = 19_000..20_000;

/// Field number of the entry at `index`, from 0.
pub(super) fn field_number(index: usize) -> u32 {
    let number = index as u32 + 1;
    if number < RESERVED.start { number } else { number + RESERVED.len() as u32 }
}

fn index_of(number: u32) -> usize {
    let skipped = if number >= RESERVED.end { RESERVED.len() as u32 } else { 0 };
    (number - 1 - skipped) as usize
}

/// Appends the row as fields of the message being written.
pub(super) fn put_row(row: &[f64], buffer: &mut Vec<u8>) {
    put_more(0, row, buffer);
}

/// Appends the row to the `before` fields that the message being written has.
pub(super) fn put_more(before: usize, row: &[f64], buffer: &mut Vec<u8>) {
    for (index, value) in row.iter().enumerate() {
        encoding::double::encode(field_number(before + index), value, buffer);
    }
}

/// Appends the row as a message of its own in field `number`.
pub(super) fn put_nested_row(number: u32, row: &[f64], buffer: &mut Vec<u8>) {
    put_nested(number, row_length(row.len()), buffer);
    put_row(row, buffer);
}

/// Opens a message of `length` bytes in field `number`; its fields come next.
pub(super) fn put_nested(number: u32, length: usize, buffer: &mut Vec<u8>) {
    encoding::encode_key(number, WireType::LengthDelimited, buffer);
    encoding::encode_varint(length as u64, buffer);
}

/// Bytes of a row of `count` numbers.
pub(super) fn row_length(count: usize) -> usize {
    // A key is a varint of the field number times eight: one byte up to 15, two up to 2047, three up to 262143.
    let key = |number: u32| encoding::encoded_len_varint(u64::from(number) << 3);
    (0..count).map(|index| key(field_number(index)) + 8).sum()
}

/// Reads a message written by [`put_row`] into `row`; absent fields are zero. `None` when it is something else.
pub(super) fn get_row(message: &[u8], row: &mut [f64]) -> Option<()> {
    row.fill(0.0);
    each_field(message, |index, field| {
        *row.get_mut(index)? = field.number()?;
        Some(())
    })
}

/// A field of a message.
pub(super) enum Field<'a> {
    /// A double.
    Number(f64),
    /// A nested message.
    Message(&'a [u8]),
}

impl<'a> Field<'a> {
    /// The double, if it is one.
    pub(super) fn number(self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(value),
            Self::Message(_) => None,
        }
    }

    /// The nested message, if it is one.
    pub(super) fn message(self) -> Option<&'a [u8]> {
        match self {
            Self::Number(_) => None,
            Self::Message(bytes) => Some(bytes),
        }
    }
}

/// Calls `take` with the index and content of every field. `None` when the message or a field is not as expected.
pub(super) fn each_field<'a>(
    mut message: &'a [u8],
    mut take: impl FnMut(usize, Field<'a>) -> Option<()>,
) -> Option<()> {
    while !message.is_empty() {
        let (number, wire_type) = encoding::decode_key(&mut message).ok()?;
        let field = match wire_type {
            WireType::SixtyFourBit => Field::Number(message.try_get_f64_le().ok()?),
            WireType::LengthDelimited => {
                let length = usize::try_from(encoding::decode_varint(&mut message).ok()?).ok()?;
                let (inner, rest) = message.split_at_checked(length)?;
                message = rest;
                Field::Message(inner)
            }
            _ => return None,
        };
        take(index_of(number), field)?;
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_bit_for_bit_across_the_reserved_numbers() {
        let mut row: Vec<f64> = (0..19_100).map(|k| 1.0 / f64::from(k + 1)).collect();
        row[0] = -0.0;
        row[1] = f64::NAN;
        let mut message = Vec::new();
        put_row(&row, &mut message);
        assert_eq!(message.len(), row_length(row.len()));
        let mut back = vec![1.0; row.len()];
        get_row(&message, &mut back).expect("a row");
        assert!(row.iter().zip(&back).all(|(a, b)| a.to_bits() == b.to_bits()));
        assert_eq!((field_number(18_998), field_number(18_999)), (18_999, 20_000));
    }

    #[test]
    fn a_damaged_row_is_refused() {
        let mut message = Vec::new();
        put_row(&[1.0, 2.0], &mut message);
        for end in 0..message.len() {
            let whole_fields = end % 9 == 0;
            assert_eq!(get_row(&message[..end], &mut [0.0; 2]).is_some(), whole_fields, "cut at {end}");
        }
        assert!(get_row(&message, &mut [0.0; 1]).is_none(), "more fields than the scene has");
    }
}
