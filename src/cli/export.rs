//! `export`: a recording as tables for other programs.

#[cfg(feature = "parquet")]
mod columnar;
mod delimited;

use super::inputs::Inputs;
use super::number::count;
use super::samples::{self, Place, Rows};
use super::{Exit, output};
use crate::record::table::Column;
use crate::record::{ContactTable, Recording, Table};
use crate::whole_file::WholeFile;
use anyhow::{Context, bail};
use clap::Args;
use serde_json::json;
use std::fs::File;
use std::path::{Path, PathBuf};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// The recording, an MCAP file, finished or not
    recording: PathBuf,
    /// Where the table goes, as its name ends: .csv or .parquet
    #[arg(long, short = 'o', value_name = "FILE.csv|parquet", required_unless_present_any = ["csv", "parquet"])]
    out: Option<PathBuf>,
    /// Write CSV: a name ending in .csv is one file with all columns, `-` is standard output, a name without an ending a folder with one
    /// file per channel
    #[arg(long, value_name = "FILE.csv|-|DIR")]
    csv: Option<PathBuf>,
    /// Write Parquet: a name ending in .parquet is one file, a name without an ending a folder with one file per channel
    #[arg(long, value_name = "FILE.parquet|DIR")]
    parquet: Option<PathBuf>,
    /// Only this channel (hinges, energy, reactions, couplings, outputs, contacts, tf) or this column (upper.angle); may be repeated
    #[arg(long, value_name = "NAME")]
    channel: Vec<String>,
    /// Print one JSON object on standard output and nothing else there
    #[arg(long)]
    json: bool,
    /// Print errors only
    #[arg(long, short)]
    quiet: bool,
}

/// A kind of file that takes rows.
trait Sheet {
    /// Takes one row: the time and the numbers of the columns.
    fn row(&mut self, time: f64, numbers: &mut dyn Iterator<Item = f64>) -> anyhow::Result<()>;

    /// Writes the rows that are not written yet.
    fn finish(self: Box<Self>) -> anyhow::Result<()>;
}

/// Begins a table of these columns in a file.
type Create = fn(File, &[Column]) -> anyhow::Result<Box<dyn Sheet>>;

pub(super) fn main(arguments: &Arguments) -> anyhow::Result<Exit> {
    let [csv, parquet_files] = arguments.targets()?;
    let recording = samples::open(&arguments.recording, arguments.quiet)?;
    let mut tables = Table::all(&recording.scene);
    let contacts = ContactTable::of(&recording)?;
    tables.extend(contacts.as_ref().map(|contacts| contacts.table.clone()));
    let touching = contacts.map_or_else(Vec::new, |contacts| contacts.rows);
    let mut places = Vec::new();
    for name in &arguments.channel {
        places.extend(samples::columns(&tables, name)?);
    }
    if arguments.channel.is_empty() {
        for table in &tables {
            places.extend(samples::columns(&tables, table.name)?);
        }
    }
    let mut written = Vec::new();
    if let Some(target) = csv.iter().copied().find(|target| target.as_os_str() == "-") {
        let named = target.display();
        if arguments.json || csv.len() + parquet_files.len() > 1 {
            bail!(
                "`--csv {named}` writes the table on standard output, and nothing else can go there: leave out `--json` and other files"
            );
        }
        let export = Export { recording: &recording, tables: &tables, places: &places, touching: &touching };
        return export.print().map(|()| Exit::Done);
    }
    for target in csv {
        written.extend(Export { recording: &recording, tables: &tables, places: &places, touching: &touching }.write(
            target,
            "csv",
            delimited::create,
        )?);
    }
    for target in parquet_files {
        written.extend(Export { recording: &recording, tables: &tables, places: &places, touching: &touching }.write(
            target,
            "parquet",
            parquet()?,
        )?);
    }
    if arguments.json {
        let files: Vec<_> = written
            .iter()
            .map(|one| json!({ "file": one.file.display().to_string(), "rows": one.rows, "columns": one.columns }))
            .collect();
        output::print(&json!({ "recording": arguments.recording.display().to_string(), "files": files }).to_string())?;
    } else if !arguments.quiet {
        for one in &written {
            let (rows, columns) = (count(one.rows, "row", "rows"), count(one.columns, "column", "columns"));
            output::print(&format!("{}: {rows}, {columns}", one.file.display()))?;
        }
    }
    Ok(Exit::Done)
}

impl Arguments {
    /// What is written as CSV, and what as Parquet.
    fn targets(&self) -> anyhow::Result<[Vec<&Path>; 2]> {
        let mut targets =
            [&self.csv, &self.parquet].map(|target| target.iter().map(PathBuf::as_path).collect::<Vec<_>>());
        if let Some(out) = &self.out {
            let ends_in = |ending: &str| out.extension().is_some_and(|found| found.eq_ignore_ascii_case(ending));
            match ["csv", "parquet"].iter().position(|ending| ends_in(ending)) {
                Some(kind) => targets[kind].push(out),
                None => bail!(
                    "`{}`: the name of a table ends in .csv or .parquet; `--csv DIR` and `--parquet DIR` write a folder with one file per \
                     channel",
                    out.display()
                ),
            }
        }
        Ok(targets)
    }
}

#[cfg(feature = "parquet")]
fn parquet() -> anyhow::Result<Create> {
    Ok(columnar::create)
}

#[cfg(not(feature = "parquet"))]
fn parquet() -> anyhow::Result<Create> {
    bail!("this program was built without Parquet; build it with `--features parquet`, or use `--csv`")
}

/// A file that was written.
struct Written {
    file: PathBuf,
    rows: usize,
    /// With that of the time.
    columns: usize,
}

struct Export<'a> {
    recording: &'a Recording,
    tables: &'a [Table],
    places: &'a [Place],
    /// Rows of the table `contacts`.
    touching: &'a [Vec<f64>],
}

impl Export<'_> {
    fn write(&self, target: &Path, extension: &str, create: Create) -> anyhow::Result<Vec<Written>> {
        if target.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension)) {
            return Ok(vec![self.sheet(target.to_owned(), self.places, create)?]);
        }
        // A folder is what a user names without an ending, or what is there.
        if let Some(ending) = target.extension().filter(|_| !target.is_dir()) {
            bail!(
                "`{}`: what is written is {extension}, not {}: name a file that ends in .{extension}, or a folder",
                target.display(),
                ending.display()
            );
        }
        if target.is_file() {
            bail!("`{}` is a file: name a folder, or a file that ends in .{extension}", target.display());
        }
        std::fs::create_dir_all(target).with_context(|| format!("cannot create the folder `{}`", target.display()))?;
        let mut written = Vec::new();
        for (index, table) in self.tables.iter().enumerate() {
            let places: Vec<Place> = self.places.iter().filter(|place| place.table == index).cloned().collect();
            if !places.is_empty() {
                written.push(self.sheet(target.join(table.name).with_extension(extension), &places, create)?);
            }
        }
        Ok(written)
    }

    /// Writes under another name until the file is whole.
    fn sheet(&self, file: PathBuf, places: &[Place], create: Create) -> anyhow::Result<Written> {
        Inputs::new([self.recording.path.as_path()]).spare(&file)?;
        let rows = self.fill(&file, places, create).with_context(|| format!("cannot write `{}`", file.display()))?;
        Ok(Written { file, rows, columns: places.len() + 1 })
    }

    /// Writes all columns on standard output. A reader that has seen enough is no error.
    fn print(&self) -> anyhow::Result<()> {
        let sheet = delimited::over(std::io::stdout().lock(), &self.columns(self.places));
        match sheet.and_then(|sheet| self.rows(sheet, self.places)) {
            Err(error) if output::is_closed(&error) => Ok(()),
            printed => printed.map(|_| ()).context("cannot write to standard output"),
        }
    }

    /// The time, and what was chosen.
    fn columns(&self, places: &[Place]) -> Vec<Column> {
        std::iter::once(samples::clock(self.recording, self.tables))
            .chain(places.iter().map(|place| place.column.clone()))
            .collect()
    }

    fn fill(&self, file: &Path, places: &[Place], create: Create) -> anyhow::Result<usize> {
        let whole = WholeFile::create(file)?;
        let written = self.rows(create(whole.handle()?, &self.columns(places))?, places)?;
        whole.finish()?;
        Ok(written)
    }

    /// Hands every sample to a sheet; how many there were.
    fn rows(&self, mut sheet: Box<dyn Sheet + '_>, places: &[Place]) -> anyhow::Result<usize> {
        let mut rows = Rows::new(self.tables, places).with_contacts(self.touching);
        let mut written = 0;
        samples::each(self.recording, |sample| {
            written += 1;
            sheet.row(sample.time, &mut rows.read(sample))
        })?;
        sheet.finish()?;
        Ok(written)
    }
}
