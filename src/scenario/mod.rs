//! Scenario files: the only place that knows TOML.
//!
//! ```text
//! text ─ syntax ─► TOML values with spans ─ overrides ─► check ─► lower ─► Description + settings
//!                                                          │         │
//!                                            fields, format┘         └ spans ◄─ problems of the model
//! ```
//!
//! The format is declared once in [`mod@format`]; the check, the [JSON Schema](schema) and the [reference](reference()) follow from it.
//! All problems of a file are found in one go, each with its line and column.
//!
//! ```
//! let text = r#"
//!     [[body]]
//!     name = "bob"
//!     mass = 1.0
//!     inertia = [0.004, 0.004, 0.004]
//!     hinge = { type = "spherical", at = [0.0, 0.0, 1.0] }
//! "#;
//! let scenario = stillpoint::scenario::parse("pendulum.toml", text, &[])?;
//! assert_eq!(scenario.description.bodies[0].name, "bob");
//! # Ok::<(), stillpoint::scenario::Diagnostics>(())
//! ```

pub mod diagnostic;
pub mod fields;
pub mod format;
pub mod overrides;
mod schema;

mod aim;
mod beam;
mod body;
mod check;
mod contact;
mod controller;
mod couplings;
mod curve;
mod event;
mod findings;
mod force;
mod formulas;
mod hinge;
mod lint;
mod lower;
mod mass;
mod measured;
mod modal;
mod model;
mod motor;
mod naming;
mod output;
mod path;
mod quantities;
mod reader;
mod reference;
mod settings;
mod shape;
mod sources;
mod spans;
mod stage;
pub mod start;
mod syntax;
mod unknown;

pub use crate::text_file::ReadError;
pub use diagnostic::{Diagnostic, Diagnostics, Severity};
pub use model::{convert, convert_text};
pub use overrides::{Override, OverrideError};
pub use reference::reference;
pub use schema::schema;
pub use shape::unreadable_meshes;
pub use start::{Started, load_start};

use crate::import::{self, Imported};
use crate::model::parameter::NamedNumbers;
use crate::model::{Description, Model, Parameter, Problem};
use crate::{constraint, record, simulate, statics, text_file};
use findings::Findings;
use quantities::{Numbers, Parameters};
use reader::Reader;
use sources::Sources;
use spans::SpanTable;
use std::path::Path;
use std::sync::Arc;
use toml::de::{DeTable, DeValue};

/// Why a scenario cannot be loaded.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// Its file cannot be read.
    #[error(transparent)]
    File(#[from] ReadError),
    /// Something is wrong in it.
    #[error(transparent)]
    Problems(#[from] Diagnostics),
}

/// A scenario, read and checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Scenario {
    /// File, as it is called in messages.
    pub name: String,
    /// What is written in it.
    pub text: String,
    /// The scene.
    pub description: Description,
    /// What is asked of a run.
    pub simulate: simulate::settings::Settings,
    /// What is asked of statics.
    pub statics: statics::settings::Settings,
    /// Numbers that statics finds: those that hold the pose or, with an aim, those that give the equilibrium its outputs; none if
    /// the scene has all of its numbers.
    pub unknown: Vec<Parameter>,
    /// What outputs of the equilibrium shall be.
    pub aim: Vec<statics::Aim>,
    /// Numbers that a start file gave it: address and value.
    pub given: Vec<(String, f64)>,
    /// What may move while a pose with friction or contact stands.
    pub margin: statics::settings::Margin,
    /// The path that is followed, if one is asked for.
    pub path: Option<statics::path::PathSettings>,
    /// What is asked of the recording.
    pub record: record::Settings,
    /// The models of other programs that it takes.
    pub models: Vec<Imported>,
    /// What will not happen although it is written.
    pub warnings: Diagnostics,
    /// The model that its check has built.
    pub built: Built,
}

/// The model of a description with its loops closed, as checking has built it: whoever needs it first may take it.
#[derive(Debug, Clone, Default)]
pub struct Built(Option<(Arc<Model>, constraint::Assembly)>);

impl Built {
    /// The model and what assembly found, once; `None` if they have been taken.
    pub fn take(&mut self) -> Option<(Arc<Model>, constraint::Assembly)> {
        self.0.take()
    }
}

/// It follows from the description, which is compared.
impl PartialEq for Built {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl Scenario {
    /// What statics finds besides the pose.
    pub fn sought(&self) -> statics::Sought<'_> {
        statics::Sought { unknown: &self.unknown, aim: &self.aim }
    }
}

/// Reads a scenario file; `-` is standard input. The file of a model (URDF, MJCF) is read as a scenario of nothing but
/// this model.
///
/// # Errors
/// If the file cannot be read, is no text or larger than [`TEXT_BYTES`](crate::budget::TEXT_BYTES), and if something is wrong in it: then
/// with all problems at once.
pub fn load(path: &Path) -> Result<Scenario, LoadError> {
    load_with(path, &[])
}

/// As [`load`], with changes from the command line.
///
/// # Errors
/// As [`load`]; a problem with a change is shown at the change.
pub fn load_with(path: &Path, overrides: &[Override]) -> Result<Scenario, LoadError> {
    let mut text = text_file::read(path, "scenario")?;
    if import::is_model(&text) && path != Path::new("-") {
        text = import::alone(path);
    }
    let name = if path == Path::new("-") { text_file::STANDARD_INPUT.to_owned() } else { path.display().to_string() };
    Ok(parse_owned(&name, text, overrides)?)
}

/// Reads a scenario from text. `name` is what it is called in messages; mesh files are found from its folder.
///
/// # Errors
/// Where something is wrong in it: with all problems at once.
pub fn parse(name: &str, text: &str, overrides: &[Override]) -> Result<Scenario, Diagnostics> {
    parse_owned(name, text.to_owned(), overrides)
}

/// Problems of a scene that was read with these changes, at their places: for those who ask of it what its model does not.
pub fn locate(scenario: &Scenario, overrides: &[Override], problems: Vec<Problem>) -> Diagnostics {
    let changes = overrides.iter().collect::<Vec<_>>();
    let (_, mut located) = document(&scenario.name, &scenario.text, &changes, |document, _, numbers, findings| {
        let (_, spans) = checked(document, folder(&scenario.name), numbers, findings);
        spans::report(&spans, problems, findings);
    });
    // Warnings were told when it was read.
    located.retain(|one| one.severity == Severity::Error);
    Diagnostics::new(&scenario.name, located)
}

/// The model of a description; else what is wrong with it, and what keeps its loops from closing.
fn build(description: &Description, has_others: bool) -> Result<Built, Vec<Problem>> {
    let model = if has_others { Model::build_loosely(description) } else { Model::build(description) }?;
    let assembled = constraint::assemble(model)?;
    Ok(Built((!has_others).then_some(assembled)))
}

fn parse_owned(name: &str, text: String, overrides: &[Override]) -> Result<Scenario, Diagnostics> {
    let (scenario, diagnostics) = parse_text(name, &text, overrides);
    let diagnostics = Diagnostics::new(name, diagnostics);
    match scenario {
        Some(scenario) if diagnostics.errors() == 0 => Ok(Scenario { text, warnings: diagnostics, ..scenario }),
        _ => Err(diagnostics),
    }
}

fn parse_text(name: &str, text: &str, overrides: &[Override]) -> (Option<Scenario>, Vec<Diagnostic>) {
    let changes = overrides.iter().collect::<Vec<_>>();
    document(name, text, &changes, |document, models, numbers, findings| {
        let (mut description, spans) = checked(document, folder(name), numbers, findings);
        description.named = named(numbers, (name, text, overrides));
        let built = report(document, &description, &spans, findings);
        check_start(document, &description, (&built, &spans), findings);
        let model = built.0.as_ref().map(|(model, _)| &**model);
        lint::check(document, (&description, model), numbers, findings);
        Scenario { built, ..read(name, document, description, models, numbers, findings) }
    })
}

/// What `then` makes of the document of a scenario: models imported, changes made, numbers in the places of their texts. `None`
/// where it cannot be read so far. What is wrong is told beside it.
fn document<T>(
    name: &str,
    text: &str,
    overrides: &[&Override],
    then: impl FnOnce(&DeTable<'_>, &[model::Model<'_>], &Numbers, &Findings) -> T,
) -> (Option<T>, Vec<Diagnostic>) {
    let findings = Findings::default();
    let mut sources = Sources::new(name, text);
    let mut document = syntax::parse(text, &sources, &findings);
    if findings.errors() > 0 {
        return (None, findings.into_diagnostics(&sources));
    }
    model::open(&mut document);
    let parameters = Parameters::read(&document);
    let (of_model, of_scene): (Vec<&Override>, Vec<&Override>) =
        overrides.iter().partition(|change| change.is_of_model());
    overrides::apply(of_model, &mut document, &mut sources, &findings);
    // An override may name another file.
    model::open(&mut document);
    let models = model::import(&mut document, &parameters, folder(name), &findings);
    let mut document = model::merge(document, &models, &mut sources, &findings);
    if findings.errors() > 0 {
        // Without the model's bodies nothing else could be judged.
        return (None, findings.into_diagnostics(&sources));
    }
    overrides::apply(of_scene, &mut document, &mut sources, &findings);
    let numbers = quantities::evaluate(&document, &parameters, &findings);
    // From here on the document may hold what `numbers` owns.
    let document = numbers.put_into(document);
    let found = then(&document, &models, &numbers, &findings);
    (Some(found), findings.into_diagnostics(&sources))
}

/// A run that begins at the pose as given, whatever that is, begins within its rigid limits.
fn check_start(
    document: &DeTable<'_>,
    description: &Description,
    (built, spans): (&Built, &SpanTable<'_>),
    findings: &Findings,
) {
    let start = settings::simulate(&Reader::new(document, 0..0, findings)).start;
    if let Some((model, _)) = built.0.as_ref().filter(|_| start == simulate::Start::Given) {
        spans::report(spans, simulate::check_given(model, description), findings);
    }
}

fn folder(name: &str) -> &Path {
    Path::new(name).parent().unwrap_or(Path::new(""))
}

/// The numbers of `[parameters]`; with another value the scene is read again, from its name, its text and its changes.
fn named(numbers: &Numbers, (name, text, overrides): (&str, &str, &[Override])) -> NamedNumbers {
    if numbers.parameters.is_empty() {
        return NamedNumbers::default();
    }
    let (name, text, overrides) = (name.to_owned(), text.to_owned(), overrides.to_owned());
    NamedNumbers::new(numbers.parameters.clone(), move |set| {
        let values: Vec<Override> = set.iter().map(|(name, value)| Override::of_parameter(name, *value)).collect();
        let changes: Vec<&Override> = overrides.iter().chain(&values).collect();
        let (scene, problems) = document(&name, &text, &changes, |document, _, numbers, findings| {
            let (description, _) = checked(document, folder(&name), numbers, findings);
            Description { named: NamedNumbers::listed(numbers.parameters.clone()), ..description }
        });
        match problems.into_iter().find(|problem| problem.severity == Severity::Error) {
            Some(problem) => Err(problem.message),
            None => scene.ok_or_else(|| "there is no scene".to_owned()),
        }
    })
}

/// The scenario with its settings.
fn read(
    name: &str,
    document: &DeTable<'_>,
    description: Description,
    models: &[model::Model<'_>],
    numbers: &Numbers,
    findings: &Findings,
) -> Scenario {
    let whole = Reader::new(document, 0..0, findings);
    let unknown = unknown::read(&whole, &description);
    let aim = aim::read(&whole, &description, &unknown, numbers);
    let margin = unknown::margin(&whole, &description);
    let path = path::read(&whole, &description, numbers);
    let (simulate, record) = (settings::simulate(&whole), settings::record(&whole));
    settings::check_samples(&whole, &simulate, &record);
    settings::check_periods(&whole, &simulate, &description);
    settings::check_supports(&whole, &description);
    contact::check_neighbours(&whole, &description);
    Scenario {
        name: name.to_owned(),
        text: String::new(),
        description,
        simulate,
        statics: settings::statics(&whole),
        unknown,
        aim,
        given: Vec::new(),
        margin,
        path,
        record,
        models: models.iter().filter_map(|model| model.result.as_ref().ok().cloned()).collect(),
        warnings: Diagnostics::default(),
        built: Built::default(),
    }
}

/// The scene of a document, checked by itself; what is wrong with it is in `findings`.
fn checked<'a>(
    document: &'a DeTable<'a>,
    folder: &Path,
    numbers: &Numbers,
    findings: &'a Findings,
) -> (Description, SpanTable<'a>) {
    check::table(&format::SCENARIO, document, findings);
    let (mut description, spans) = lower::lower(document, folder, findings);
    measured::settle(&Reader::new(document, 0..0, findings), &mut description, numbers);
    (description, spans)
}

/// Builds the model of a scene; what is wrong with it is told at its places in the document.
fn report(document: &DeTable<'_>, description: &Description, spans: &SpanTable<'_>, findings: &Findings) -> Built {
    // Of elements that could not be read it is said why; that there are none would be said besides.
    let is_none = |list: &DeValue<'_>| list.as_array().is_some_and(|list| list.is_empty());
    let holds = |key: &&str| document.get(*key).is_some_and(|value| !is_none(value.get_ref()));
    let written = ["body", "beam", "cable"].iter().any(holds);
    if description.bodies.is_empty() && description.beams.is_empty() && written {
        return Built::default();
    }
    build(description, findings.errors() > 0).unwrap_or_else(|problems| {
        spans::report(spans, problems, findings);
        Built::default()
    })
}
