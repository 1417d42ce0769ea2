//! The matrices as files of other programs: NumPy's `.npz`, MATLAB's `.mat` of level 4, JSON.
//!
//! `.npz` is a zip archive of `.npy` arrays, here stored without compression; a level 4 `.mat` is one header and its numbers
//! after the other, column by column.

use crate::linear::{Mat, Overflow, Signal, StateSpace};
use anyhow::bail;
use serde_json::Value;
use std::path::Path;

/// What is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Format {
    Json,
    Npz,
    Mat,
}

/// A named array.
struct Array {
    name: &'static str,
    content: Content,
}

enum Content {
    Numbers(Mat<f64>),
    /// A column of complex numbers.
    Complex(Vec<[f64; 2]>),
    Words(Vec<String>),
}

impl Format {
    /// By the ending of a name.
    ///
    /// # Errors
    /// If it is none of the three.
    pub(super) fn of(path: &Path) -> anyhow::Result<Self> {
        match path.extension().and_then(|ending| ending.to_str()) {
            Some("json") => Ok(Self::Json),
            Some("npz") => Ok(Self::Npz),
            Some("mat") => Ok(Self::Mat),
            _ => bail!("`{}`: the name must end in .json, .npz or .mat", path.display()),
        }
    }

    /// The content of the file.
    ///
    /// # Errors
    /// If an array is too large for the format, or the equations from step to step are not finite.
    pub(super) fn bytes(self, found: &StateSpace, step: Option<f64>, answer: &Value) -> anyhow::Result<Vec<u8>> {
        match self {
            Self::Json => Ok(format!("{answer:#}\n").into_bytes()),
            Self::Npz => npz(&arrays(found, step)?),
            Self::Mat => mat(&arrays(found, step)?),
        }
    }
}

fn arrays(found: &StateSpace, step: Option<f64>) -> Result<Vec<Array>, Overflow> {
    let words = |signals: &[Signal]| Content::Words(signals.iter().map(|signal| signal.name.clone()).collect());
    let numbers = |matrix: &Mat<f64>| Content::Numbers(matrix.clone());
    let mut all = vec![
        Array { name: "A", content: numbers(&found.a) },
        Array { name: "B", content: numbers(&found.b) },
        Array { name: "C", content: numbers(&found.c) },
        Array { name: "D", content: numbers(&found.d) },
        Array { name: "eigenvalues", content: Content::Complex(found.eigenvalues()) },
        Array { name: "states", content: words(&found.states) },
        Array { name: "inputs", content: words(&found.inputs) },
        Array { name: "outputs", content: words(&found.outputs) },
    ];
    if let Some(step) = step {
        let (a, b) = found.hold(step)?;
        all.push(Array { name: "Ad", content: Content::Numbers(a) });
        all.push(Array { name: "Bd", content: Content::Numbers(b) });
        all.push(Array { name: "step", content: Content::Numbers(Mat::from_fn(1, 1, |_, _| step)) });
    }
    Ok(all)
}

/// One array as `.npy`, format 1.0.
fn npy(content: &Content) -> Vec<u8> {
    let (kind, shape, data) = match content {
        Content::Numbers(m) => {
            let rows = (0..m.nrows()).flat_map(|i| (0..m.ncols()).map(move |j| m[(i, j)]));
            (
                "<f8".to_owned(),
                format!("({}, {})", m.nrows(), m.ncols()),
                rows.flat_map(f64::to_le_bytes).collect::<Vec<u8>>(),
            )
        }
        Content::Complex(list) => {
            let data = list.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
            ("<c16".to_owned(), format!("({},)", list.len()), data)
        }
        Content::Words(list) => {
            let longest = list.iter().map(|word| word.chars().count()).max().unwrap_or(0).max(1);
            let padded = |word: &String| {
                let letters: Vec<u32> = word.chars().map(u32::from).collect();
                (0..longest).map(|i| letters.get(i).copied().unwrap_or(0)).collect::<Vec<u32>>()
            };
            let data = list.iter().flat_map(padded).flat_map(u32::to_le_bytes).collect();
            (format!("<U{longest}"), format!("({},)", list.len()), data)
        }
    };
    let mut header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    // Magic, version and length are ten bytes; the data begin at a multiple of 64.
    let length = (10 + header.len() + 1).next_multiple_of(64) - 10;
    header += &" ".repeat(length - header.len() - 1);
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(data);
    bytes
}

/// A zip archive, its files stored as they are.
fn npz(arrays: &[Array]) -> anyhow::Result<Vec<u8>> {
    let (mut bytes, mut directory) = (Vec::new(), Vec::new());
    for Array { name, content } in arrays {
        let (file, data) = (format!("{name}.npy"), npy(content));
        let (Ok(size), Ok(offset)) = (u32::try_from(data.len()), u32::try_from(bytes.len())) else {
            bail!("`{name}` is too large for an .npz file of 4 GB");
        };
        // Version 2.0, no flags, stored; 1980-01-01 for the date, which is not known to anyone who compares files.
        let mut common = Vec::new();
        [20_u16, 0, 0, 0, 0x21].iter().for_each(|word| common.extend(word.to_le_bytes()));
        [crc32(&data), size, size].iter().for_each(|word| common.extend(word.to_le_bytes()));
        common.extend((file.len() as u16).to_le_bytes());
        common.extend([0; 2]);
        bytes.extend(b"PK\x03\x04");
        bytes.extend(&common);
        bytes.extend(file.as_bytes());
        bytes.extend(&data);
        directory.extend(b"PK\x01\x02");
        directory.extend(20_u16.to_le_bytes());
        directory.extend(&common);
        // No comment, first disk, no attributes.
        directory.extend([0; 10]);
        directory.extend(offset.to_le_bytes());
        directory.extend(file.as_bytes());
    }
    let Ok(offset) = u32::try_from(bytes.len()) else { bail!("the matrices are too large for an .npz file of 4 GB") };
    bytes.extend(&directory);
    bytes.extend(b"PK\x05\x06");
    bytes.extend([0; 4]);
    [arrays.len() as u16; 2].iter().for_each(|count| bytes.extend(count.to_le_bytes()));
    bytes.extend((directory.len() as u32).to_le_bytes());
    bytes.extend(offset.to_le_bytes());
    bytes.extend([0; 2]);
    Ok(bytes)
}

/// The checksum of zip archives: CRC-32 by its reflected polynomial.
fn crc32(data: &[u8]) -> u32 {
    let byte = |crc: u32, byte: &u8| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| if crc & 1 == 1 { (crc >> 1) ^ 0xedb8_8320 } else { crc >> 1 })
    };
    !data.iter().fold(!0, byte)
}

/// Arrays as a `.mat` file of level 4.
fn mat(arrays: &[Array]) -> anyhow::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    for Array { name, content } in arrays {
        let by_columns = |m: &Mat<f64>| (0..m.ncols()).flat_map(|j| (0..m.nrows()).map(move |i| m[(i, j)])).collect();
        // 0 for numbers, 1 for text; rows and columns; whether there is an imaginary part.
        let (kind, shape, parts): (u32, [usize; 2], Vec<Vec<f64>>) = match content {
            Content::Numbers(m) => (0, [m.nrows(), m.ncols()], vec![by_columns(m)]),
            Content::Complex(list) => {
                (0, [list.len(), 1], [0, 1].map(|part| list.iter().map(|x| x[part]).collect()).into())
            }
            Content::Words(list) => {
                let longest = list.iter().map(|word| word.chars().count()).max().unwrap_or(0);
                let letter = |i: usize, j: usize| f64::from(list[i].chars().nth(j).map_or(32, u32::from));
                (1, [list.len(), longest], vec![by_columns(&Mat::from_fn(list.len(), longest, letter))])
            }
        };
        let header =
            [kind, u32::try_from(shape[0])?, u32::try_from(shape[1])?, parts.len() as u32 - 1, name.len() as u32 + 1];
        bytes.extend(header.into_iter().flat_map(u32::to_le_bytes));
        bytes.extend(name.as_bytes());
        bytes.push(0);
        bytes.extend(parts.iter().flatten().flat_map(|x| x.to_le_bytes()));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::crc32;

    #[test]
    fn the_checksum_is_the_published_one() {
        // The check value of CRC-32/ISO-HDLC.
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
    }
}
