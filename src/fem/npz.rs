//! Finite elements from an archive of NumPy arrays (`.npz`), as `numpy.savez` writes it.
//!
//! | array | shape | what |
//! |---|---|---|
//! | `nodes` | N×3 | places (m) |
//! | `dofs` | n×2, whole | node and direction (0 … 5: x, y, z, about x, y, z) of every row |
//! | `mass_row`, `mass_column`, `mass_value`, or `mass` | k, k, k, or n×n | entries of the mass matrix, of both triangles or of one |
//! | `stiffness_row`, … or `stiffness` | | likewise |
//! | `interface_names` | b, text | names; the first is the root |
//! | `interface_points` | b×3 | their points (m) |
//! | `interface_nodes` | j×2, whole | interface and node |
//! | `geometric_load`, `geometric_row`, `geometric_column`, `geometric_value` | k | optional: unit load ([`UnitLoad::of_number`]), row, column, entry |
//! | `total_mass`, `center`, `inertia` | 1, 3, 3 | optional: compared with the matrices |

use super::{Declared, FiniteElements, Flaw, Freedom, Interface, Symmetric, UnitLoad};
use crate::budget::{FEM_BYTES, FEM_ENTRIES, FEM_FREEDOMS};
use crate::fem::counted;
use crate::foreign;
use nalgebra::Vector3;
use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use zip::ZipArchive;

/// Names of arrays that mean something.
const KNOWN: &[&str] = &[
    "nodes",
    "dofs",
    "mass",
    "mass_row",
    "mass_column",
    "mass_value",
    "stiffness",
    "stiffness_row",
    "stiffness_column",
    "stiffness_value",
    "interface_names",
    "interface_points",
    "interface_nodes",
    "geometric_load",
    "geometric_row",
    "geometric_column",
    "geometric_value",
    "total_mass",
    "center",
    "inertia",
];

/// One array.
#[derive(Debug, Clone, PartialEq)]
struct Array {
    shape: Vec<usize>,
    numbers: Vec<f64>,
    texts: Vec<String>,
}

/// Reads the bytes of an archive.
///
/// # Errors
/// What is not as the table of the module says, by the name of the array.
pub fn read(bytes: &[u8]) -> Result<FiniteElements, Flaw> {
    let arrays = foreign::parse("the reader of archives", || arrays(bytes)).map_err(Flaw::new)??;
    let all = Arrays(arrays);
    let freedoms: Vec<Freedom> = all
        .rows("dofs", 2)?
        .map(|row| Ok(Freedom { node: all.whole("dofs", row[0])?, direction: all.whole("dofs", row[1])? }))
        .collect::<Result<_, Flaw>>()?;
    let n = freedoms.len();
    if n == 0 || n > FEM_FREEDOMS {
        return Err(
            Flaw::new(format!("`dofs` has {}", counted(n, "row", "rows"))).help(format!("allowed: 1 … {FEM_FREEDOMS}"))
        );
    }
    let nodes: Vec<Vector3<f64>> = all.rows("nodes", 3)?.map(|row| Vector3::new(row[0], row[1], row[2])).collect();
    let mut model = FiniteElements {
        nodes,
        freedoms,
        mass: Symmetric::of("mass", 0, [], |_| String::new())?,
        stiffness: Symmetric::of("stiffness", 0, [], |_| String::new())?,
        interfaces: all.interfaces()?,
        geometric: Vec::new(),
        declared: all.declared()?,
    };
    if let Some(row) =
        model.freedoms.iter().position(|freedom| freedom.node >= model.nodes.len() || freedom.direction > 5)
    {
        let Freedom { node, direction } = model.freedoms[row];
        let message = format!("`dofs`: row {row} is direction {direction} of node {node}");
        let help = format!("nodes count from 0 to {}, directions from 0 to 5", model.nodes.len().max(1) - 1);
        return Err(Flaw::new(message).help(help));
    }
    model.mass = all.matrix("mass", &model)?;
    model.stiffness = all.matrix("stiffness", &model)?;
    model.geometric = all.geometric(&model)?;
    Ok(model)
}

struct Arrays(BTreeMap<String, Array>);

impl Arrays {
    fn get(&self, name: &str) -> Result<&Array, Flaw> {
        self.0.get(name).ok_or_else(|| {
            let found: Vec<String> = self.0.keys().map(|name| format!("`{name}`")).collect();
            let help = if found.is_empty() { "it has none".to_owned() } else { format!("it has {}", found.join(", ")) };
            Flaw::new(format!("the file has no array `{name}`")).help(help)
        })
    }

    /// The rows of a table of numbers with this many columns.
    fn rows(&self, name: &str, columns: usize) -> Result<impl Iterator<Item = &[f64]>, Flaw> {
        let array = self.get(name)?;
        if array.shape.len() != 2 || array.shape[1] != columns || !array.texts.is_empty() {
            let message = format!("`{name}` has the shape {:?}", array.shape);
            return Err(Flaw::new(message).help(format!("it needs rows of {}", counted(columns, "number", "numbers"))));
        }
        Ok(array.numbers.chunks_exact(columns))
    }

    fn list(&self, name: &str, count: Option<usize>) -> Result<&[f64], Flaw> {
        let array = self.get(name)?;
        let is_list = array.shape.len() <= 1 && array.texts.is_empty();
        if !is_list || count.is_some_and(|count| count != array.numbers.len()) {
            let wanted = count.map_or("a list of numbers".to_owned(), |count| {
                format!("a list of {}", counted(count, "number", "numbers"))
            });
            return Err(
                Flaw::new(format!("`{name}` has the shape {:?}", array.shape)).help(format!("it needs {wanted}"))
            );
        }
        Ok(&array.numbers)
    }

    /// A number that counts from 0.
    fn whole(&self, name: &str, x: f64) -> Result<usize, Flaw> {
        if x >= 0.0 && x.fract() == 0.0 && x < 1e9 {
            return Ok(x as usize);
        }
        Err(Flaw::new(format!("`{name}` has {x}")).help("it needs whole numbers from 0 on"))
    }

    fn interfaces(&self) -> Result<Vec<Interface>, Flaw> {
        let names = &self.get("interface_names")?.texts;
        let points: Vec<&[f64]> = self.rows("interface_points", 3)?.collect();
        if names.len() != points.len() || names.is_empty() {
            let message = format!("{} `interface_names` and {} `interface_points`", names.len(), points.len());
            return Err(Flaw::new(message).help("one text and one point for every interface; the first is the root"));
        }
        let interface = |(name, at): (&String, &&[f64])| Interface {
            name: name.clone(),
            point: Vector3::new(at[0], at[1], at[2]),
            nodes: Vec::new(),
        };
        let mut interfaces: Vec<Interface> = names.iter().zip(&points).map(interface).collect();
        for row in self.rows("interface_nodes", 2)? {
            let (index, node) = (self.whole("interface_nodes", row[0])?, self.whole("interface_nodes", row[1])?);
            let count = interfaces.len();
            let Some(interface) = interfaces.get_mut(index) else {
                return Err(Flaw::new(format!("`interface_nodes` has interface {index} of {count}")));
            };
            interface.nodes.push(node);
        }
        match interfaces.iter().find(|interface| interface.point.iter().any(|x| !x.is_finite())) {
            Some(interface) => Err(Flaw::new(format!("the point of interface `{}` is not finite", interface.name))),
            None => Ok(interfaces),
        }
    }

    fn declared(&self) -> Result<Declared, Flaw> {
        let list = |name: &str, count| self.0.contains_key(name).then(|| self.list(name, Some(count))).transpose();
        Ok(Declared {
            mass: list("total_mass", 1)?.map(|list| list[0]),
            center: list("center", 3)?.map(Vector3::from_column_slice),
            inertia: list("inertia", 3)?.map(Vector3::from_column_slice),
        })
    }

    fn matrix(&self, name: &str, model: &FiniteElements) -> Result<Symmetric, Flaw> {
        let n = model.freedoms.len();
        let label = |row: usize| model.label(row);
        if let Some(dense) = self.0.get(name) {
            if dense.shape != [n, n] {
                let message = format!("`{name}` has the shape {:?}", dense.shape);
                return Err(
                    Flaw::new(message).help(format!("`dofs` has {}: it needs {n}×{n}", counted(n, "row", "rows")))
                );
            }
            let entries = dense.numbers.iter().enumerate().filter(|(_, x)| **x != 0.0);
            return Symmetric::of(name, n, entries.map(|(at, x)| (at / n, at % n, *x)), label);
        }
        let [rows, columns, values] = ["row", "column", "value"].map(|part| format!("{name}_{part}"));
        let value = self.list(&values, None)?;
        if value.len() > FEM_ENTRIES {
            let message = format!("`{values}` has {} entries", value.len());
            return Err(Flaw::new(message).help(format!("allowed: {FEM_ENTRIES}")));
        }
        let (row, column) = (self.list(&rows, Some(value.len()))?, self.list(&columns, Some(value.len()))?);
        let mut entries = Vec::with_capacity(value.len());
        for ((row, column), value) in row.iter().zip(column).zip(value) {
            entries.push((self.whole(&rows, *row)?, self.whole(&columns, *column)?, *value));
        }
        Symmetric::of(name, n, entries, label)
    }

    fn geometric(&self, model: &FiniteElements) -> Result<Vec<(UnitLoad, Symmetric)>, Flaw> {
        if !self.0.contains_key("geometric_value") {
            return Ok(Vec::new());
        }
        let (n, value) = (model.freedoms.len(), self.list("geometric_value", None)?);
        let part = |name: &str| self.list(name, Some(value.len()));
        let (loads, rows, columns) = (part("geometric_load")?, part("geometric_row")?, part("geometric_column")?);
        let mut by_load: BTreeMap<usize, Vec<(usize, usize, f64)>> = BTreeMap::new();
        for at in 0..value.len() {
            let row = self.whole("geometric_row", rows[at])?;
            let entry = (row, self.whole("geometric_column", columns[at])?, value[at]);
            by_load.entry(self.whole("geometric_load", loads[at])?).or_default().push(entry);
        }
        let matrix = |(number, entries): (usize, Vec<(usize, usize, f64)>)| {
            let count = model.interfaces.len();
            let load = UnitLoad::of_number(number, count).ok_or_else(|| {
                let help = format!("allowed with {count} interfaces: 0 … {}", 11 + 3 * (count - 1));
                Flaw::new(format!("`geometric_load` has {number}")).help(help)
            })?;
            let name = format!("geometric stiffness of load {number}");
            Ok((load, Symmetric::of(&name, n, entries, |row| model.label(row))?))
        };
        by_load.into_iter().map(matrix).collect()
    }
}

/// All arrays of an archive that mean something.
fn arrays(bytes: &[u8]) -> Result<BTreeMap<String, Array>, Flaw> {
    let broken = |why: &dyn std::fmt::Display| Flaw::new(format!("not an archive of NumPy arrays: {why}"));
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|why| broken(&why))?;
    let (mut all, mut left) = (BTreeMap::new(), FEM_BYTES);
    for index in 0..archive.len() {
        let mut member = archive.by_index(index).map_err(|why| broken(&why))?;
        let name = member.name().map_err(|why| broken(&why))?.trim_end_matches(".npy").to_owned();
        if !KNOWN.contains(&name.as_str()) {
            let near = crate::suggest::closest(&name, KNOWN.iter().copied());
            let help =
                near.map_or("see docs/guide/modal_bodies.md".to_owned(), |near| format!("did you mean `{near}`?"));
            return Err(Flaw::new(format!("unknown array `{name}`")).help(help));
        }
        let mut content = Vec::new();
        member.by_ref().take(left + 1).read_to_end(&mut content).map_err(|why| broken(&why))?;
        let size = content.len() as u64;
        if size > left {
            return Err(Flaw::new(format!("the arrays have more than {} MB", FEM_BYTES >> 20)));
        }
        left -= size;
        all.insert(name.clone(), array(&name, &content)?);
    }
    Ok(all)
}

/// One `.npy` file: magic, version, a header that is the text of a Python dictionary, numbers.
fn array(name: &str, bytes: &[u8]) -> Result<Array, Flaw> {
    let broken = |what: &str| Flaw::new(format!("`{name}`: {what}"));
    let (long, start) = match bytes {
        [0x93, b'N', b'U', b'M', b'P', b'Y', 1, _, low, high, ..] => (u32::from(u16::from_le_bytes([*low, *high])), 10),
        [0x93, b'N', b'U', b'M', b'P', b'Y', 2 | 3, _, a, b, c, d, ..] => (u32::from_le_bytes([*a, *b, *c, *d]), 12),
        _ => return Err(broken("no NumPy array")),
    };
    let header = bytes.get(start..start + long as usize).ok_or_else(|| broken("its header is cut off"))?;
    let header = String::from_utf8_lossy(header);
    let after = |key: &str| header.split_once(key).map(|(_, rest)| rest.trim_start_matches([':', ' ', '\'', '"']));
    let kind = after("descr'").and_then(|rest| rest.split('\'').next()).unwrap_or_default();
    let is_fortran = after("fortran_order'").is_some_and(|rest| rest.starts_with("True"));
    let shape = after("shape'").and_then(|rest| rest.strip_prefix('(')?.split(')').next());
    let shape = shape.ok_or_else(|| broken("its header has no shape"))?;
    let sizes = shape.split(',').map(str::trim).filter(|part| !part.is_empty()).map(str::parse::<usize>);
    let shape: Vec<usize> = sizes.collect::<Result<_, _>>().map_err(|_| broken("its shape is not one"))?;
    let count = shape.iter().try_fold(1_usize, |product, size| product.checked_mul(*size));
    let count = count.ok_or_else(|| broken("its shape is too large"))?;
    let data = &bytes[start + long as usize..];
    let width = width(kind).ok_or_else(|| {
        broken(&format!("its numbers are `{kind}`"))
            .help("allowed: little-endian numbers of 4 or 8 bytes, whole ones of 1 to 8, text")
    })?;
    if count.checked_mul(width).is_none_or(|size| size > data.len()) {
        return Err(broken("it is cut off"));
    }
    let mut read = Array { shape, numbers: Vec::new(), texts: Vec::new() };
    let cells = data.chunks_exact(width.max(1)).take(count);
    match kind.as_bytes() {
        [_, b'U', ..] => read.texts.extend(cells.map(wide_text)),
        [_, b'S', ..] => {
            read.texts.extend(cells.map(|cell| String::from_utf8_lossy(cell).trim_end_matches('\0').to_owned()))
        }
        _ => read.numbers.extend(cells.map(|cell| number(kind, cell))),
    }
    if is_fortran && read.shape.len() == 2 && read.texts.is_empty() {
        let [rows, columns] = [read.shape[0], read.shape[1]];
        let by_columns = std::mem::take(&mut read.numbers);
        read.numbers = (0..rows * columns).map(|at| by_columns[at % columns * rows + at / columns]).collect();
    }
    Ok(read)
}

/// Bytes of one cell.
fn width(kind: &str) -> Option<usize> {
    match kind {
        "<f8" | "<i8" | "<u8" => Some(8),
        "<f4" | "<i4" | "<u4" => Some(4),
        "<i2" | "<u2" => Some(2),
        "|i1" | "|u1" | "|b1" => Some(1),
        _ => {
            let size = |mark: &str| kind.strip_prefix(mark)?.parse::<usize>().ok();
            size("<U").and_then(|size| size.checked_mul(4)).or_else(|| size("|S")).filter(|size| *size > 0)
        }
    }
}

/// UTF-32, filled up with zeros.
fn wide_text(cell: &[u8]) -> String {
    let codes = cell.chunks_exact(4).map(|code| u32::from_le_bytes([code[0], code[1], code[2], code[3]]));
    codes.filter(|code| *code != 0).map(|code| char::from_u32(code).unwrap_or('\u{FFFD}')).collect()
}

fn number(kind: &str, cell: &[u8]) -> f64 {
    let mut eight = [0; 8];
    eight[..cell.len()].copy_from_slice(cell);
    let whole = u64::from_le_bytes(eight);
    match kind {
        "<f8" => f64::from_le_bytes(eight),
        "<f4" => f64::from(f32::from_le_bytes([cell[0], cell[1], cell[2], cell[3]])),
        "<i8" => whole as i64 as f64,
        "<i4" => f64::from(whole as u32 as i32),
        "<i2" => f64::from(whole as u16 as i16),
        "|i1" => f64::from(whole as u8 as i8),
        _ => whole as f64,
    }
}
