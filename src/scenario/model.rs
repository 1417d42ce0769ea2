//! `model`: bodies and what belongs to them out of another program's file.
//!
//! An importer gives scenario text; it is parsed like any other, with the places of the model behind it, and put before
//! what the file itself says. From then on nobody knows the difference.

use super::diagnostic::Diagnostics;
use super::findings::{Finding, Findings};
use super::format::{HINGE, SCENARIO};
use super::overrides::moved;
use super::reader::Reader;
use super::sources::Sources;
use super::spans::walk;
use super::{LoadError, check, checked, quantities, report};
use crate::budget::SUGGESTIONS;
use crate::import::{self, Imported, Options, Problem, Refused, Source};
use crate::suggest::closest_of_many;
use crate::text_file;
use std::borrow::Cow;
use std::collections::HashMap;
use std::ops::Range;
use std::path::Path;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

type Key<'a> = Spanned<Cow<'a, str>>;
type Value<'a> = Spanned<DeValue<'a>>;
/// Whose hinge, which key, which value.
type Setting<'a> = (Key<'a>, Key<'a>, Value<'a>);

/// A model that a scenario names, and what became of it.
pub(super) struct Model<'a> {
    /// Where the scenario names it.
    span: Range<usize>,
    prefix: String,
    /// What its hinges have beside what it says.
    settings: Vec<Setting<'a>>,
    pub(super) result: Result<Imported, Refused>,
}

/// Imports a model and checks what comes out.
///
/// # Errors
/// If the file cannot be read or is no model that is known, and where something is wrong in it: then with all
/// problems at once, each at its place in the model.
pub fn convert(path: &Path, options: &Options) -> Result<Imported, LoadError> {
    convert_text(path, text_file::read(path, "model")?, options)
}

/// As [`convert`], of a text that has been read; `path` is what it is called, and where its meshes are found from.
///
/// # Errors
/// As [`convert`].
pub fn convert_text(path: &Path, text: String, options: &Options) -> Result<Imported, LoadError> {
    let name = path.display().to_string();
    let result = import::import_text(path, text, options);
    let findings = Findings::default();
    let mut models = vec![Model { span: 0..0, prefix: String::new(), settings: Vec::new(), result }];
    let mut sources = Sources::new(&name, "");
    let document = merge(DeTable::new(), &models, &mut sources, &findings);
    if findings.errors() == 0 {
        let folder = options.folder.as_deref().or(path.parent()).unwrap_or(Path::new(""));
        let (description, spans) = checked(&document, folder, &quantities::Numbers::default(), &findings);
        report(&document, &description, &spans, &findings);
    }
    let fine = findings.errors() == 0;
    let diagnostics = Diagnostics::new(&name, findings.into_diagnostics(&sources));
    match models.pop().map(|model| model.result) {
        Some(Ok(imported)) if fine => Ok(imported),
        _ => Err(diagnostics.into()),
    }
}

/// A model given by its file alone, written as a table.
pub(super) fn open<'a>(document: &mut DeTable<'a>) {
    let Some(model) = document.get_mut("model") else { return };
    if model.get_ref().as_str().is_some() {
        let span = model.span();
        let file = std::mem::replace(model.get_mut(), DeValue::Table(DeTable::new()));
        let DeValue::Table(table) = model.get_mut() else { return };
        table.insert(Spanned::new(span.clone(), Cow::Borrowed("file")), Spanned::new(span, file));
    }
}

/// Takes the models out of a document and imports them. `given` are the parameters before changes, `folder` is that of the scenario.
pub(super) fn import<'a>(
    document: &mut DeTable<'a>,
    given: &quantities::Parameters,
    folder: &Path,
    findings: &Findings,
) -> Vec<Model<'a>> {
    // Changes may have named another file.
    open(document);
    let Some((key, value)) = document.remove_entry("model") else { return Vec::new() };
    let mut written = DeTable::new();
    written.insert(key, value);
    let before = findings.errors();
    let numbers = quantities::evaluate_alone(&written, document, given, findings);
    // What hinges are given keeps its units until the hinges are known.
    let mut alone = written.clone();
    numbers.put(&mut alone);
    check::table(&SCENARIO, &alone, findings);
    if findings.errors() > before {
        return Vec::new();
    }
    let of = |(value, written): (&Value<'_>, &Value<'a>)| {
        let reader = Reader::new(value.get_ref().as_table()?, value.span(), findings);
        model(&reader, settings(written.get_ref().as_table()?), folder)
    };
    match (alone.get("model"), written.get("model")) {
        (Some(value), Some(written)) if value.get_ref().is_array() => {
            let items = value.get_ref().as_array().into_iter().flat_map(|items| items.iter());
            let as_written = written.get_ref().as_array().into_iter().flat_map(|items| items.iter());
            items.zip(as_written).filter_map(of).collect()
        }
        (Some(value), Some(written)) => of((value, written)).into_iter().collect(),
        _ => Vec::new(),
    }
}

fn model<'a>(table: &Reader<'_>, settings: Vec<Setting<'a>>, folder: &Path) -> Option<Model<'a>> {
    let path = folder.join(table.text("file")?);
    let array = |key: &str| table.vector(key).map_or([0.0; 3], Into::into);
    let package = |(name, all): (&str, Reader<'_>)| Some((name.to_owned(), folder.join(all.text(name)?)));
    let options = Options {
        prefix: table.text("prefix").unwrap_or_default().to_owned(),
        without_limits: table.flag("limits") == Some(false),
        without_friction: table.flag("friction") == Some(false),
        contact: table.flag("contact") == Some(true),
        without_mimics: table.flag("mimics") == Some(false),
        weld_massless: table.text("massless") == Some("weld"),
        floating: table.text("base") == Some("free"),
        key: table.text("key").map(str::to_owned),
        at: array("at"),
        rpy: array("rpy"),
        folder: Some(folder.to_owned()),
        packages: table.names("packages").into_iter().filter_map(package).collect(),
        ..Options::from_environment()
    };
    let result = import::import(&path, &options);
    Some(Model { span: table.span_of("file"), prefix: options.prefix, settings, result })
}

/// `positions` and `hinges`, what is said of all before what is said of one.
fn settings<'a>(table: &DeTable<'a>) -> Vec<Setting<'a>> {
    let inner = |key: &str| table.get(key).and_then(|value| value.get_ref().as_table()).into_iter().flatten();
    let mut settings: Vec<Setting<'a>> = Vec::new();
    for (name, hinge) in inner("hinges") {
        let keys = hinge.get_ref().as_table().into_iter().flatten();
        settings.extend(keys.map(|(key, value)| (name.clone(), key.clone(), value.clone())));
    }
    settings.sort_by_key(|(name, ..)| name.get_ref() != ALL);
    for (name, value) in inner("positions") {
        settings.push((name.clone(), Spanned::new(name.span(), "position".into()), value.clone()));
    }
    settings
}

/// The name that stands for all hinges.
const ALL: &str = "*";

/// The document with all models before it.
pub(super) fn merge<'m>(
    document: DeTable<'m>,
    models: &'m [Model<'m>],
    sources: &mut Sources<'m>,
    findings: &Findings,
) -> DeTable<'m> {
    let (mut whole, mut document) = (DeTable::new(), document);
    for model in models {
        match &model.result {
            Err(Refused::File(error)) => findings.push(Finding::error(model.span.clone(), error.to_string())),
            Err(Refused::Problems { problems, sources: files }) => {
                let starts = add(files, sources);
                problems.iter().for_each(|problem| findings.push(finding(problem, &starts, &model.span)));
            }
            Ok(imported) => {
                let starts = add(&imported.sources, sources);
                if let Some(mut table) = parse(imported, &starts, sources) {
                    model.settle(imported, &mut table, findings);
                    bound_motors(&mut document, imported);
                    whole = combine(whole, table);
                } else {
                    let message = "what was imported is no scenario".to_owned();
                    findings.push(Finding::error(model.span.clone(), message));
                }
            }
        }
    }
    combine(whole, document)
}

/// Motors of a scenario in the hinges of a model do no more than the model allows, if they do not say themselves how much.
fn bound_motors<'m>(document: &mut DeTable<'m>, imported: &'m Imported) {
    let Some(DeValue::Array(motors)) = document.get_mut("motor").map(Spanned::get_mut) else { return };
    for motor in motors.iter_mut() {
        let span = motor.span();
        let DeValue::Table(motor) = motor.get_mut() else { continue };
        let hinge = motor.get("hinge").and_then(|hinge| hinge.get_ref().as_str());
        let Some((_, most)) = imported.efforts.iter().find(|(body, _)| Some(body.as_str()) == hinge) else { continue };
        if motor.contains_key("limit") {
            continue;
        }
        if let Ok(number) = DeValue::parse(most) {
            let number = Spanned::new(span.clone(), number.into_inner());
            motor.insert(Spanned::new(span, Cow::Borrowed("limit")), number);
        }
    }
}

/// Adds the files of a model and tells where each of them starts.
fn add<'m>(files: &'m [Source], sources: &mut Sources<'m>) -> Vec<usize> {
    files.iter().map(|file| sources.add(&file.path.display().to_string(), &file.text)).collect()
}

fn finding(problem: &Problem, starts: &[usize], model: &Range<usize>) -> Finding {
    let at = problem.place.as_ref().map(|place| (starts[place.source], &place.span));
    let span = at.map_or_else(|| model.clone(), |(start, span)| start + span.start..start + span.end);
    Finding::error(span, problem.message.clone()).label(problem.label.as_str()).maybe_help(problem.help.clone())
}

/// The table of what was imported; its spans lead to the model's files.
fn parse<'m>(imported: &'m Imported, files: &[usize], sources: &mut Sources<'m>) -> Option<DeTable<'m>> {
    let text = imported.scenario.as_str();
    let table = DeTable::parse(text).ok()?.into_inner();
    let name = imported.sources.first().map_or_else(String::new, |source| source.path.display().to_string());
    let start = sources.add(&format!("{name} (as imported)"), text);
    let lists = table.values().filter_map(|value| value.get_ref().as_array());
    let mut headers: Vec<usize> = lists.flat_map(|items| items.iter().map(|item| item.span().start)).collect();
    headers.sort_unstable();
    let origins = imported.origins.iter().filter_map(|(address, place)| {
        let mut here = walk(&table, address)?.span();
        if address.ends_with(']') && !address.contains('.') {
            // A table with a header of its own reaches to the next one.
            let next = headers.partition_point(|header| *header <= here.start);
            here.end = headers.get(next).copied().unwrap_or(text.len());
        }
        let file = files.get(place.source)?;
        Some((start + here.start..start + here.end, file + place.span.start..file + place.span.end))
    });
    let origins = origins.collect();
    sources.made_from(origins);
    match moved(Spanned::new(0..0, DeValue::Table(table)), start).into_inner() {
        DeValue::Table(table) => Some(table),
        _ => None,
    }
}

impl<'m> Model<'m> {
    /// Gives the hinges what the scenario says of them.
    fn settle(&'m self, imported: &Imported, table: &mut DeTable<'m>, findings: &Findings) {
        let Some(DeValue::Array(bodies)) = table.get_mut("body").map(Spanned::get_mut) else { return };
        let mut by_name: HashMap<String, &mut DeTable<'m>> = HashMap::new();
        for body in bodies.iter_mut() {
            let DeValue::Table(body) = body.get_mut() else { continue };
            let name = body.get("name").and_then(|name| name.get_ref().as_str()).map(str::to_owned);
            if let (Some(name), Some(DeValue::Table(hinge))) = (name, body.get_mut("hinge").map(Spanned::get_mut)) {
                by_name.insert(name, hinge);
            }
        }
        for (name, key, value) in &self.settings {
            let word = name.get_ref().as_ref();
            if word == ALL {
                let has = |hinge: &&mut &mut DeTable<'m>| {
                    let of_type = hinge.get("type").and_then(|of_type| of_type.get_ref().as_str()).unwrap_or_default();
                    HINGE.declarations(key.get_ref()).any(|key| key.belongs_to(of_type))
                };
                by_name.values_mut().filter(has).for_each(|hinge| set(hinge, key, value));
                continue;
            }
            match self.body(imported, word, |name| by_name.contains_key(name)) {
                Some(body) => by_name.get_mut(&body).into_iter().for_each(|hinge| set(hinge, key, value)),
                None => findings.push(self.stranger(imported, name, by_name.keys(), findings.errors())),
            }
        }
    }

    /// The body that a name means: of a joint, or of a body with or without the prefix.
    fn body(&self, imported: &Imported, name: &str, known: impl Fn(&str) -> bool) -> Option<String> {
        let joint = imported.joints.iter().find(|(joint, _)| joint == name).map(|(_, body)| body.clone());
        joint.or_else(|| [format!("{}{name}", self.prefix), name.to_owned()].into_iter().find(|name| known(name)))
    }

    fn stranger<'n>(
        &self,
        imported: &Imported,
        name: &Key<'_>,
        bodies: impl Iterator<Item = &'n String>,
        before: usize,
    ) -> Finding {
        let word = name.get_ref().as_ref();
        let mut known: Vec<&str> = bodies.map(String::as_str).collect();
        if before < SUGGESTIONS {
            known.sort_unstable();
        }
        let joints = imported.joints.iter().map(|(joint, _)| joint.as_str());
        let near = closest_of_many(before, word, joints.chain(known));
        let message = format!("the model has no joint or body `{word}`");
        Finding::error(name.span(), message).maybe_help(near.map(|near| format!("did you mean `{near}`?")))
    }
}

fn set<'m>(hinge: &mut DeTable<'m>, key: &Key<'m>, value: &Value<'m>) {
    hinge.remove(key.get_ref().as_ref());
    hinge.insert(key.clone(), value.clone());
}

/// Both documents in one: lists one after the other, tables with the keys of both. Where both say something the second
/// counts.
fn combine<'m>(first: DeTable<'m>, second: DeTable<'m>) -> DeTable<'m> {
    let mut whole = first;
    for (key, value) in second {
        let span = value.span();
        let value = match (whole.remove(key.get_ref().as_ref()).map(Spanned::into_inner), value.into_inner()) {
            (Some(DeValue::Array(first)), DeValue::Array(second)) if is_of_tables(&first) && is_of_tables(&second) => {
                DeValue::Array(first.into_iter().chain(second).collect())
            }
            (Some(DeValue::Table(first)), DeValue::Table(second)) => DeValue::Table(combine(first, second)),
            (_, second) => second,
        };
        whole.insert(key, Spanned::new(span, value));
    }
    whole
}

fn is_of_tables(items: &[Value<'_>]) -> bool {
    items.iter().all(|item| item.get_ref().is_table())
}
