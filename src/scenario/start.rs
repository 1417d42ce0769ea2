//! Start files: a pose with its velocities and inputs, written by `statics --save` and taken by `--start`.
//!
//! ```toml
//! title = "A crane"
//! [positions]
//! "boom" = [0.7853981633974483]
//! [velocities]
//! "boom" = [0.0]
//! [inputs]
//! "boom.force" = 1234.5678901234567
//! [multipliers]
//! "loop boom pin" = [1234.5678901234567, 0.0, 0.0, 0.0, 0.0]
//! [strains]
//! "jib" = [0.00123, 0.00045]
//! ```
//!
//! Numbers have all their digits: what is read is what was written, bit for bit.
//!
//! A file that `run --save-end` writes has the `time` too, and in `[integrator]` what the method goes on with. The scene
//! itself is then as the scenario has it: motions of drives and offsets of gears follow from the positions there.

use super::LoadError;
use super::diagnostic::Diagnostics;
use super::findings::{Finding, Findings};
use super::format::START;
use super::reader::Reader;
use super::sources::Sources;
use super::{check, quantities, syntax};
use crate::constraint::Constraints;
use crate::integrate::Method;
use crate::model::description::Description;
use crate::model::parameter::{Field, Parameter};
use crate::model::problem::{Element, Problem, counted};
use crate::model::{Beam, Body, Link, ModalBody, Model};
use crate::simulate::{Grid, Integrator, Mode, Resume, State};
use crate::suggest::closest_of_many;
use crate::text_file;
use std::fmt::Write;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// A scene with a start.
#[derive(Debug, Clone)]
pub struct Started {
    /// The scene with the inputs of the file.
    pub description: Description,
    /// Its model; start position and velocity are those of the file. Of the end of a run: the one to take them from, see
    /// [`Started::resume`].
    pub model: Arc<Model>,
    /// Of the end of a run: where it goes on. The scene is then that of `description`, with this start.
    pub resume: Option<Resume>,
    /// Numbers of the scene that the file changed: address, value of the scenario, value of the file.
    pub changes: Vec<(String, f64, f64)>,
    /// What loops, drives and gears pushed when the file was written, in the names of the model's rows: to compare with.
    pub multipliers: Vec<(String, Vec<f64>)>,
}

/// The text of a start file. `inputs` are numbers of the scene by address, `multipliers` those of
/// [`Constraints::by_element`].
pub fn text(
    model: &Model,
    position: &[f64],
    velocity: &[f64],
    inputs: &[(String, f64)],
    multipliers: &[(String, Vec<f64>)],
) -> String {
    text_of(model, None, position, velocity, inputs, multipliers)
}

/// The start file of the end of a run, from which another run can go on; `memories` are what its controllers remember, in the order of the model.
pub fn text_at_end(
    model: &Model,
    resume: &Resume,
    state: &State,
    inputs: &[(String, f64)],
    memories: &[Vec<f64>],
) -> String {
    let mut out = text_of(model, Some(resume), &state.position, &state.velocity, inputs, &[]);
    let known = || model.controllers.iter().zip(memories).filter(|(_, memory)| !memory.is_empty());
    if known().next().is_some() {
        out += "\n[controllers]\n";
        for (controller, memory) in known() {
            let _ = writeln!(out, "{} = {memory:?}", quoted(&controller.name));
        }
    }
    out
}

fn text_of(
    model: &Model,
    resume: Option<&Resume>,
    position: &[f64],
    velocity: &[f64],
    inputs: &[(String, f64)],
    multipliers: &[(String, Vec<f64>)],
) -> String {
    let mut out =
        String::from("# Where a run begins: hinge coordinates, velocities and inputs by name. For `--start`.\n");
    if !model.title.is_empty() {
        let _ = writeln!(out, "title = {}", quoted(&model.title));
    }
    if let Some(Resume { time, method, step, grid, mode }) = resume {
        let _ = writeln!(out, "time = {time:?}");
        if let Some(mode) = mode {
            let _ = writeln!(out, "mode = {:?}", mode.numbers());
        }
        let _ = writeln!(out, "\n[integrator]\nmethod = {}", quoted(method.name()));
        if let Some(step) = step {
            let _ = writeln!(out, "step = {step:?}");
        }
        if let Some(Grid { origin, steps }) = grid {
            let _ = writeln!(out, "origin = {origin:?}\nsteps = {steps}");
        }
    }
    let hinges = || model.bodies.iter().filter(|body| body.hinge.kind.counts().1 > 0);
    let line = |out: &mut String, body: &Body, numbers: &[f64]| {
        let _ = writeln!(out, "{} = {numbers:?}", quoted(&body.name));
    };
    out += "\n[positions]\n";
    for body in hinges() {
        line(&mut out, body, &position[body.hinge.position..][..body.hinge.kind.counts().0]);
    }
    out += "\n[velocities]\n";
    for body in hinges() {
        line(&mut out, body, &velocity[body.hinge.velocity..][..body.hinge.kind.counts().1]);
    }
    strains(&mut out, model, position, velocity);
    if !inputs.is_empty() {
        out += "\n[inputs]\n";
        for (address, value) in inputs {
            let _ = writeln!(out, "{} = {value:?}", quoted(address));
        }
    }
    if !multipliers.is_empty() {
        out += "\n# What loops, drives and gears push there, row by row (N or N m): checked when the file is read.\n[multipliers]\n";
        for (name, numbers) in multipliers {
            let _ = writeln!(out, "{} = {numbers:?}", quoted(&plain(name)));
        }
    }
    out
}

/// Coordinates of the elements of beams and of modal bodies, and their rates where these move.
fn strains(out: &mut String, model: &Model, position: &[f64], velocity: &[f64]) {
    let of = |beam: &Beam, list: &[f64], first: &dyn Fn(&Link) -> usize| -> Vec<f64> {
        let links = beam.elements.iter().map(|element| &model.links[element.link]);
        links.flat_map(|link| list[first(link)..][..link.joint.counts().1].iter().copied()).collect()
    };
    let mut table = |title: &str, lists: Vec<Vec<f64>>| {
        let _ = writeln!(out, "\n[{title}]");
        let names = model.beams.iter().map(|beam| &beam.name).chain(model.modals.iter().map(|modal| &modal.name));
        for (name, numbers) in names.zip(lists) {
            let _ = writeln!(out, "{} = {numbers:?}", quoted(name));
        }
    };
    if model.beams.is_empty() && model.modals.is_empty() {
        return;
    }
    let all = |list: &[f64], first: &dyn Fn(&Link) -> usize| -> Vec<Vec<f64>> {
        let link = |modal: &ModalBody| first(&model.links[modal.link]);
        let modals = model.modals.iter().map(|modal| list[link(modal)..][..modal.modal.count()].to_vec());
        model.beams.iter().map(|beam| of(beam, list, first)).chain(modals).collect()
    };
    table("strains", all(position, &|link| link.position));
    let rates = all(velocity, &|link| link.velocity);
    if rates.iter().flatten().any(|rate| *rate != 0.0) {
        table("strain_rates", rates);
    }
}

/// ``loop `boom pin` `` → `loop boom pin`: easier to write.
fn plain(name: &str) -> String {
    name.replacen('`', "", 1).trim_end_matches('`').to_owned()
}

/// A TOML basic string.
fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' | '\\' => out.extend(['\\', letter]),
            control if control.is_control() => {
                let _ = write!(out, "\\U{:08X}", u32::from(control));
            }
            other => out.push(other),
        }
    }
    out.push('"');
    out
}

/// Reads a start file for a scene and checks it against that.
///
/// # Errors
/// If the file cannot be read, and if something in it does not fit the scene: with all problems at once.
pub fn load_start(path: &Path, description: &Description) -> Result<Started, LoadError> {
    let text = text_file::read(path, "start")?;
    Ok(parse_start(&path.display().to_string(), &text, description)?)
}

/// Reads a start file from text; `name` is what it is called in messages.
///
/// # Errors
/// Where something in it does not fit the scene: with all problems at once.
pub fn parse_start(name: &str, text: &str, description: &Description) -> Result<Started, Diagnostics> {
    let findings = Findings::default();
    let sources = Sources::new(name, text);
    let document = syntax::parse(text, &sources, &findings);
    let mut started = None;
    let numbers = quantities::evaluate_start(&document, description, &findings);
    let document = numbers.put_into(document);
    if findings.errors() == 0 {
        check::table(&START, &document, &findings);
        let whole = Reader::new(&document, 0..0, &findings);
        let changed = description.clone();
        let file = File { whole, changed, changes: Vec::new(), inputs: Vec::new(), multipliers: Vec::new() };
        started = file.read(description);
    }
    match started {
        Some(started) if findings.errors() == 0 => Ok(started),
        _ => Err(Diagnostics::new(name, findings.into_diagnostics(&sources))),
    }
}

struct File<'a> {
    whole: Reader<'a>,
    changed: Description,
    changes: Vec<(String, f64, f64)>,
    /// Inputs and where they are written.
    inputs: Vec<(Parameter, Range<usize>)>,
    multipliers: Vec<(String, Vec<f64>)>,
}

impl File<'_> {
    fn read(mut self, given: &Description) -> Option<Started> {
        if !self.whole.has("positions") {
            let finding = Finding::without_place("a start file needs `[positions]`".to_owned());
            self.whole.findings.push(finding.help("write one with `stillpoint statics SCENARIO --save START.toml`"));
        }
        // Named numbers may move the pose of the scene; that of the file stands.
        self.read_inputs(given);
        self.read_memories();
        let scene = self.changed.clone();
        self.lists("positions");
        self.changed.bodies.iter_mut().for_each(|body| body.hinge.velocity.clear());
        self.changed.beams.iter_mut().for_each(|beam| beam.hinge.velocity.clear());
        self.lists("velocities");
        self.read_strains();
        let model = match Model::build(&self.changed) {
            Ok(model) => model,
            Err(problems) => {
                problems.into_iter().for_each(|problem| self.report(problem));
                return None;
            }
        };
        self.read_multipliers(&model);
        let resume = self.resume(&model);
        let Self { changed, changes, multipliers, .. } = self;
        let description = if resume.is_some() { scene } else { changed };
        Some(Started { description, model, resume, changes, multipliers })
    }

    /// Where a run goes on; `None` if the file has no time.
    fn resume(&self, model: &Model) -> Option<Resume> {
        let time = self.whole.number("time")?;
        let integrator = self.whole.table("integrator");
        let number = |key: &str| integrator.as_ref().and_then(|table| table.number(key));
        let word = integrator.as_ref().and_then(|table| table.text("method")).unwrap_or_default();
        let Some(Integrator::Method(method)) = Integrator::named(word) else {
            let message = format!("`time` needs the method that led there: `[integrator] method` is `{word}`");
            let help = format!("it is one of {}", Method::ALL.map(Method::name).join(", "));
            self.whole.findings.push(Finding::error(self.whole.key_span("time"), message).help(help));
            return None;
        };
        let steps = integrator.as_ref().and_then(|table| table.count("steps")).map(|steps| steps as u64);
        let grid = number("origin").zip(steps).map(|(origin, steps)| Grid { origin, steps });
        let read = |numbers: Vec<f64>| Mode::of_numbers(&numbers).filter(|mode| mode.fits(model)).map(Arc::new);
        let mode = self.whole.numbers("mode").map(read);
        if mode == Some(None) {
            let message =
                "`mode` is of another scene: it says what stops, dry friction and contacts of the run before did";
            let help = "leave it out, and that is decided anew";
            self.whole.findings.push(Finding::error(self.whole.key_span("mode"), message.to_owned()).help(help));
        }
        Some(Resume { time, method, step: number("step"), grid, mode: mode.flatten() })
    }

    /// Of every loop, drive and gear that the file names: the scene must have it, with as many rows.
    fn read_multipliers(&mut self, model: &Model) {
        let Some(table) = self.whole.table("multipliers") else { return };
        let rows = Constraints::new(model).map_or(Vec::new(), |rows| rows.by_element());
        for (name, _) in self.whole.names("multipliers") {
            let Some(numbers) = table.numbers(name) else { continue };
            let Some((element, known)) = rows.iter().find(|(element, _)| plain(element) == name) else {
                let all: Vec<String> = rows.iter().map(|(element, _)| plain(element)).collect();
                let near = closest_of_many(self.whole.findings.errors(), name, all.iter().map(String::as_str));
                let finding = Finding::error(table.key_span(name), format!("the scene has no {name}"));
                self.whole.findings.push(finding.maybe_help(near.map(|near| format!("did you mean `{near}`?"))));
                continue;
            };
            if numbers.len() != known.len() {
                let message = format!("{element} has {}, not {}", counted(known.len(), "row", "rows"), numbers.len());
                self.whole.findings.push(Finding::error(table.span_of(name), message));
                continue;
            }
            self.multipliers.push((element.clone(), numbers));
        }
    }

    /// One of the tables of lists.
    fn lists(&mut self, list: &'static str) {
        let Some(table) = self.whole.table(list) else { return };
        let cable = self.changed.beams.iter().find(|beam| beam.far.is_some());
        if let Some(cable) = cable.filter(|_| list == "positions") {
            let message = format!("`{}` is a cable: its length follows from the scenario's own positions", cable.name);
            let help = "start from the scenario's own guess: cables begin in the shape of the elastic catenary";
            self.whole.findings.push(Finding::error(self.whole.key_span(list), message).help(help));
            return;
        }
        for (name, _) in self.whole.names(list) {
            let Description { bodies, beams, .. } = &mut self.changed;
            let own = bodies.iter_mut().map(|body| (&body.name, &mut body.hinge));
            let of_beams = beams.iter_mut().map(|beam| (&beam.name, &mut beam.hinge));
            let Some((_, hinge)) = own.chain(of_beams).find(|(body, _)| *body == name) else {
                let bodies = self.changed.bodies.iter().map(|body| body.name.as_str());
                let known = bodies.chain(self.changed.beams.iter().map(|beam| beam.name.as_str()));
                let near = closest_of_many(self.whole.findings.errors(), name, known);
                let finding = Finding::error(table.key_span(name), format!("the scene has no body `{name}`"));
                let help = near.map(|near| format!("did you mean `{near}`?"));
                self.whole.findings.push(finding.maybe_help(help));
                continue;
            };
            let Some(numbers) = table.numbers(name) else { continue };
            match list {
                "positions" => hinge.position = numbers,
                _ => hinge.velocity = numbers,
            }
        }
        if list == "velocities" {
            return;
        }
        let bodies = self.changed.bodies.iter().map(|body| (&body.name, &body.hinge));
        for (name, hinge) in bodies.chain(self.changed.beams.iter().map(|beam| (&beam.name, &beam.hinge))) {
            if hinge.kind.counts().0 > 0 && !table.has(name) {
                let message = format!("the position of `{name}` is missing");
                let help = "a start gives the coordinates of every hinge of the scene";
                self.whole.findings.push(Finding::error(self.whole.key_span(list), message).help(help));
            }
        }
    }

    /// Of every beam: all of its strains, and their rates where the file has them.
    fn read_strains(&mut self) {
        for beam in &mut self.changed.beams {
            beam.strain_rates.clear();
        }
        self.changed.modals.iter_mut().for_each(|modal| modal.velocity.clear());
        for (list, needed) in [("strains", true), ("strain_rates", false)] {
            let Some(table) = self.whole.table(list) else {
                let names = self.changed.beams.iter().map(|beam| &beam.name);
                let mut names = names.chain(self.changed.modals.iter().map(|modal| &modal.body));
                if let Some(name) = names.next().filter(|_| needed) {
                    let message = format!("the strains of `{name}` are missing");
                    let help = "a start gives the strains of every beam of the scene, under `[strains]`";
                    self.whole.findings.push(Finding::error(self.whole.key_span("positions"), message).help(help));
                }
                continue;
            };
            for (name, _) in self.whole.names(list) {
                let Some(numbers) = table.numbers(name) else { continue };
                if let Some(modal) = self.changed.modals.iter_mut().find(|modal| modal.body == name) {
                    *if needed { &mut modal.position } else { &mut modal.velocity } = numbers;
                    continue;
                }
                let Some(beam) = self.changed.beams.iter_mut().find(|beam| beam.name == name) else {
                    let message = format!("the scene has no beam and no modal body `{name}`");
                    self.whole.findings.push(Finding::error(table.key_span(name), message));
                    continue;
                };
                *if needed { &mut beam.strains } else { &mut beam.strain_rates } = numbers;
            }
            let beams = self.changed.beams.iter().filter(|beam| beam.strains.is_empty()).map(|beam| &beam.name);
            let modals = self.changed.modals.iter().filter(|modal| modal.position.is_empty()).map(|modal| &modal.body);
            for name in beams.chain(modals).filter(|_| needed) {
                let message = format!("the strains of `{name}` are missing");
                self.whole.findings.push(Finding::error(self.whole.key_span(list), message));
            }
        }
    }

    fn read_inputs(&mut self, given: &Description) {
        let Some(table) = self.whole.table("inputs") else { return };
        for (address, _) in self.whole.names("inputs") {
            let Some(value) = table.number(address) else { continue };
            let found = Parameter::find(given, address);
            let refuse = |message: String, help: Option<String>| {
                self.whole.findings.push(Finding::error(table.key_span(address), message).maybe_help(help));
            };
            match found.as_deref() {
                Ok([one]) if one.field == Field::Position => {
                    refuse(
                        format!("`{address}` is a coordinate, not an input"),
                        Some("write it in [positions]".to_owned()),
                    );
                }
                Ok([one]) => {
                    let before = one.value(given);
                    if before.to_bits() != value.to_bits() {
                        self.changes.push((one.address.clone(), before, value));
                    }
                    if let Err(why) = one.set(&mut self.changed, value) {
                        refuse(why, None);
                    }
                    self.inputs.push((one.clone(), table.span_of(address)));
                }
                Ok(many) => refuse(
                    format!("`{address}` stands for {} numbers", many.len()),
                    Some(format!("address each of them, for example `{}`", many[0].address)),
                ),
                Err(error) => refuse(error.message.clone(), error.help.clone()),
            }
        }
    }

    /// What controllers remember.
    fn read_memories(&mut self) {
        let Some(table) = self.whole.table("controllers") else { return };
        for (name, _) in self.whole.names("controllers") {
            let Some(numbers) = table.numbers(name) else { continue };
            let controllers = &mut self.changed.controllers;
            if let Some(one) = controllers.iter_mut().find(|one| one.name == name) {
                one.memory = numbers;
                continue;
            }
            let known = controllers.iter().map(|one| one.name.as_str());
            let near = closest_of_many(self.whole.findings.errors(), name, known);
            let finding = Finding::error(table.key_span(name), format!("the scene has no controller `{name}`"));
            self.whole.findings.push(finding.maybe_help(near.map(|near| format!("did you mean `{near}`?"))));
        }
    }

    /// A problem that the model finds, at the place in this file that causes it.
    fn report(&self, problem: Problem) {
        let body = match problem.element {
            Element::Body(body) => Some(self.changed.bodies[body].name.as_str()),
            Element::Beam(beam) => Some(self.changed.beams[beam].name.as_str()),
            _ => None,
        };
        let list = match problem.field.as_str() {
            "hinge.position" => Some("positions"),
            "hinge.velocity" => Some("velocities"),
            "strains" => Some("strains"),
            "strain_rates" => Some("strain_rates"),
            _ => None,
        };
        let written = list.zip(body).and_then(|(list, body)| Some(self.whole.table(list)?.span_of(body)));
        let input = || {
            let same = |(one, _): &&(Parameter, Range<usize>)| {
                one.element == problem.element && problem.field.trim_start_matches("hinge.") == one.field.name()
            };
            self.inputs.iter().find(same).map(|(_, span)| span.clone())
        };
        let span = written.or_else(input);
        if span.as_ref().is_some_and(|span| self.whole.findings.cover(span)) {
            return;
        }
        let finding = match span {
            Some(span) => Finding::error(span, problem.message),
            None => Finding::without_place(problem.message),
        };
        self.whole.findings.push(finding.maybe_help(problem.help));
    }
}
