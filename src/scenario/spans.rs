//! Where the elements of a description are written.

use super::findings::{Finding, Findings};
use crate::model::problem::{Element, Problem};
use std::collections::{BTreeSet, HashMap};
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// From the elements of a description to their tables in the file; spans are looked up only when they are asked for.
#[derive(Debug)]
pub(super) struct SpanTable<'a> {
    document: &'a DeTable<'a>,
    bodies: Vec<Origin>,
    forces: Vec<usize>,
    /// Which `[[loop]]`, `[[drive]]`, `[[gear]]`, `[[motor]]` the description's ones come from.
    pub(super) loops: Vec<usize>,
    pub(super) drives: Vec<usize>,
    pub(super) gears: Vec<usize>,
    pub(super) motors: Vec<usize>,
    /// And `[[controller]]`.
    pub(super) controllers: Vec<usize>,
    /// And `[[stage]]`.
    pub(super) stages: Vec<usize>,
    pub(super) contacts: Vec<usize>,
    pub(super) outputs: Vec<usize>,
    /// Of `beam` or of `cable`.
    pub(super) beams: Vec<(&'static str, usize)>,
    pub(super) cables: Vec<usize>,
    events: Vec<usize>,
    /// There are bodies whose names could not be read.
    nameless: bool,
}

/// Which `[[body]]` a body comes from.
#[derive(Debug, Clone, Copy)]
struct Origin {
    index: usize,
    copy: Option<usize>,
}

impl<'a> SpanTable<'a> {
    pub(super) fn new(document: &'a DeTable<'a>) -> Self {
        let (bodies, forces) = (Vec::new(), Vec::new());
        let (loops, drives, gears) = (Vec::new(), Vec::new(), Vec::new());
        let (motors, contacts, outputs, events) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let (beams, cables) = (Vec::new(), Vec::new());
        Self {
            document,
            bodies,
            forces,
            events,
            loops,
            drives,
            gears,
            motors,
            controllers: Vec::new(),
            stages: Vec::new(),
            contacts,
            outputs,
            beams,
            cables,
            nameless: false,
        }
    }

    /// The next bodies of the description come from `[[body]]` number `index`.
    pub(super) fn add_bodies(&mut self, index: usize, repeat: Option<usize>) {
        match repeat {
            None => self.bodies.push(Origin { index, copy: None }),
            Some(copies) => self.bodies.extend((0..copies).map(|copy| Origin { index, copy: Some(copy) })),
        }
    }

    /// The next force of the description comes from `[[force]]` number `index`.
    pub(super) fn add_force(&mut self, index: usize) {
        self.forces.push(index);
    }

    /// The next event of the description comes from `[[event]]` number `index`.
    pub(super) fn add_event(&mut self, index: usize) {
        self.events.push(index);
    }

    /// A body's name could not be read: that others do not find it is not worth saying.
    pub(super) fn add_nameless(&mut self) {
        self.nameless = true;
    }

    fn element(&self, element: Element) -> Option<&'a Spanned<DeValue<'a>>> {
        let (list, index) = match element {
            Element::Scene => return None,
            Element::Body(body) => ("body", self.bodies.get(body)?.index),
            Element::Force(force) => ("force", *self.forces.get(force)?),
            // Cables close loops of their own after the others.
            Element::Loop(index) if index >= self.loops.len() => ("cable", *self.cables.get(index - self.loops.len())?),
            Element::Loop(index) => ("loop", self.loops[index]),
            Element::Drive(index) => ("drive", *self.drives.get(index)?),
            Element::Gear(index) => ("gear", *self.gears.get(index)?),
            Element::Motor(index) => ("motor", *self.motors.get(index)?),
            Element::Contact(index) => ("contact", *self.contacts.get(index)?),
            Element::Event(event) => ("event", *self.events.get(event)?),
            Element::Output(index) => ("output", *self.outputs.get(index)?),
            Element::Controller(index) => ("controller", *self.controllers.get(index)?),
            Element::Stage(index) => ("stage", *self.stages.get(index)?),
            Element::Beam(index) => *self.beams.get(index)?,
        };
        self.document.get(list)?.get_ref().as_array()?.get(index)
    }

    /// Names of elements that are written and could not be read.
    fn unread(&self) -> BTreeSet<&'a str> {
        let beams = |list: &str| self.beams.iter().filter(|(of, _)| *of == list).map(|(_, index)| *index).collect();
        let lists: [(&str, &[usize]); 11] = [
            ("force", &self.forces),
            ("loop", &self.loops),
            ("drive", &self.drives),
            ("gear", &self.gears),
            ("motor", &self.motors),
            ("contact", &self.contacts),
            ("output", &self.outputs),
            ("event", &self.events),
            ("controller", &self.controllers),
            ("stage", &self.stages),
            ("cable", &self.cables),
        ];
        let of_list = |(list, read): (&str, &[usize])| {
            let tables = self.document.get(list).and_then(|list| list.get_ref().as_array());
            let is_unread = |(index, table): (usize, &'a Spanned<DeValue<'a>>)| {
                let name = table.get_ref().as_table()?.get("name")?.get_ref().as_str()?;
                (!read.contains(&index)).then_some(name)
            };
            tables.into_iter().flatten().enumerate().filter_map(is_unread).collect::<Vec<_>>()
        };
        let read: Vec<usize> = beams("beam");
        lists.into_iter().chain([("beam", &read[..])]).flat_map(of_list).collect()
    }

    fn copy(&self, element: Element) -> Option<usize> {
        match element {
            Element::Body(body) => self.bodies.get(body)?.copy,
            _ => None,
        }
    }
}

impl<'a> SpanTable<'a> {
    /// What is written in a problem's field, if that is a text.
    fn text(&self, problem: &Problem) -> Option<&'a str> {
        let table = self.element(problem.element)?.get_ref().as_table()?;
        walk(table, &problem.field)?.get_ref().as_str()
    }
}

/// Where a problem's field is written; if it is not, the nearest table around it. `None` for the scene as a whole.
pub(super) fn locate(spans: &SpanTable<'_>, problem: &Problem) -> Option<Range<usize>> {
    let Some(element) = spans.element(problem.element) else {
        return walk(spans.document, &problem.field).map(Spanned::span);
    };
    let Some(table) = element.get_ref().as_table() else { return Some(element.span()) };
    let copy = spans.copy(problem.element);
    let field = written_field(table, &problem.field, copy);
    let Some(value) = walk(table, field) else { return Some(element.span()) };
    Some(of_copy(table, field, value, copy).span())
}

/// The key that stands in the file for a field of the description.
fn written_field<'f>(body: &DeTable<'_>, field: &'f str, copy: Option<usize>) -> &'f str {
    match field {
        "mass" | "center" | "inertia" if !body.contains_key(field) && body.contains_key("density") => "density",
        "hinge.at" if copy.is_some_and(|copy| copy > 0) => {
            let hinge = body.get("hinge").and_then(|hinge| hinge.get_ref().as_table());
            match (body.contains_key("next"), hinge.is_some_and(|hinge| hinge.contains_key("next"))) {
                (_, true) => "hinge.next",
                (true, false) => "next",
                (false, false) => field,
            }
        }
        _ => field,
    }
}

/// The deepest value on a path like `hinge.position[2]` that is there; `None` if not even its first key is.
pub(super) fn walk<'a>(table: &'a DeTable<'a>, path: &str) -> Option<&'a Spanned<DeValue<'a>>> {
    // Names that users choose may hold dots and brackets: the longest key wins.
    let (value, rest) = match table.get(path) {
        Some(value) => (value, ""),
        None => {
            let cut = path.find(['.', '[']).unwrap_or(path.len());
            (table.get(&path[..cut])?, &path[cut..])
        }
    };
    Some(descend(value, rest))
}

fn descend<'a>(value: &'a Spanned<DeValue<'a>>, rest: &str) -> &'a Spanned<DeValue<'a>> {
    let deeper = match value.get_ref() {
        DeValue::Table(table) => rest.strip_prefix('.').and_then(|rest| walk(table, rest)),
        DeValue::Array(items) => {
            rest.strip_prefix('[').and_then(|rest| rest.split_once(']')).and_then(|(index, rest)| {
                let item = items.get(index.parse::<usize>().ok()?)?;
                Some(descend(item, rest))
            })
        }
        _ => None,
    };
    deeper.unwrap_or(value)
}

/// The part of a list of values per copy that belongs to this copy.
fn of_copy<'a>(
    body: &DeTable<'_>,
    field: &str,
    value: &'a Spanned<DeValue<'a>>,
    copy: Option<usize>,
) -> &'a Spanned<DeValue<'a>> {
    let (Some(copy), Some(items)) = (copy, value.get_ref().as_array()) else { return value };
    let one_coordinate = || {
        let of_type = body.get("hinge").and_then(|hinge| hinge.get_ref().get("type"));
        matches!(of_type.and_then(|of_type| of_type.get_ref().as_str()), Some("revolute" | "prismatic"))
    };
    const PER_COPY: [&str; 7] = ["position", "velocity", "stiffness", "damping", "rest", "armature", "force"];
    let key = field.strip_prefix("hinge.").filter(|key| PER_COPY.contains(key));
    let nested = items.first().is_some_and(|item| item.get_ref().is_array());
    let per_copy = field == "mass" || key.is_some_and(|_| nested || one_coordinate());
    // A list of one number is meant for all copies.
    if per_copy { items.get(copy).unwrap_or(value) } else { value }
}

/// Adds the problems that the model finds, each at its place, and each once for all copies of a repeat. What lies in a
/// value that could not be read, or names an element that could not be, is left out: the reader has said what is wrong there.
pub(super) fn report(spans: &SpanTable<'_>, problems: Vec<Problem>, findings: &Findings) {
    let mut said: HashMap<(Option<Range<usize>>, String), usize> = HashMap::new();
    let mut kept: Vec<(Option<Range<usize>>, Problem, usize)> = Vec::new();
    let unread = if problems.is_empty() { BTreeSet::new() } else { spans.unread() };
    for problem in problems {
        if spans.nameless && is_reference(&problem.field) {
            continue;
        }
        if problem.field != "name" && spans.text(&problem).is_some_and(|text| names_one_of(&unread, text)) {
            continue;
        }
        let span = locate(spans, &problem);
        if span.as_ref().is_some_and(|span| findings.cover(span)) {
            continue;
        }
        let key = (span.clone(), without_copies(&problem.message));
        match said.get(&key) {
            Some(first) => kept[*first].2 += 1,
            None => {
                said.insert(key, kept.len());
                kept.push((span, problem, 0));
            }
        }
    }
    for (span, problem, more) in kept {
        let message = match more {
            0 => problem.message,
            1 => format!("{} (and 1 more copy)", problem.message),
            more => format!("{} (and {more} more copies)", problem.message),
        };
        let finding = match span {
            Some(span) => Finding::error(span, message),
            None => Finding::without_place(message),
        };
        findings.push(finding.maybe_help(problem.help));
    }
}

/// Whether a text is one of these names, or a part of what has it.
fn names_one_of(names: &BTreeSet<&str>, text: &str) -> bool {
    names.contains(text) || names.contains(text.split(['.', '[']).next().unwrap_or_default())
}

/// Whether a field names another body.
fn is_reference(field: &str) -> bool {
    matches!(field, "hinge.parent" | "hinge" | "on" | "of" | "of.body" | "against.body")
        || field.starts_with("between")
        || field.starts_with("through")
}

/// A message without the numbers of copies: `link(12)` reads `link[]`.
fn without_copies(message: &str) -> String {
    let mut text = String::with_capacity(message.len());
    let mut in_brackets = false;
    for letter in message.chars() {
        if !(in_brackets && letter.is_ascii_digit()) {
            in_brackets = letter == '[';
            text.push(letter);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"
gravity = [0, 0, 0]
[[body]]
name = "a.b"
mass = [1, -2, 3]
repeat = 3
markers = { "x.y" = [0, 0, 0], tip = [1, 2, 3] }
hinge = { type = "revolute", axis = [0, 0, 1], position = [4, 5, 6], next = "tip" }
[[body]]
name = "c"
density = 7
hinge.type = "free"
hinge.position = [0, 0, 0, 1, 0, 0, 0]
[[force]]
between = ["a.b[0]", { body = "c", at = [9, 9, 9] }]
"#;

    fn at(element: Element, field: &str) -> &'static str {
        let document = DeTable::parse(TEXT).expect("the text of the test");
        let mut spans = SpanTable::new(document.get_ref());
        spans.add_bodies(0, Some(3));
        spans.add_bodies(1, None);
        spans.add_force(0);
        let problem = Problem { element, field: field.to_owned(), message: String::new(), help: None };
        locate(&spans, &problem).map_or("", |span| &TEXT[span])
    }

    #[test]
    fn fields_are_found_where_they_are_written() {
        assert_eq!(at(Element::Scene, "gravity"), "[0, 0, 0]");
        assert_eq!(at(Element::Body(0), "name"), "\"a.b\"");
        assert_eq!(at(Element::Body(0), "markers.x.y"), "[0, 0, 0]");
        assert_eq!(at(Element::Body(0), "markers.tip[1]"), "2");
        assert_eq!(at(Element::Body(0), "hinge.axis"), "[0, 0, 1]");
        assert_eq!(at(Element::Body(3), "hinge.position[3]"), "1");
        assert_eq!(at(Element::Force(0), "between[0]"), "\"a.b[0]\"");
        assert_eq!(at(Element::Force(0), "between[1].at"), "[9, 9, 9]");
    }

    #[test]
    fn copies_share_their_template_but_for_their_own_values() {
        assert_eq!(at(Element::Body(1), "mass"), "-2");
        assert_eq!(at(Element::Body(2), "hinge.position"), "6");
        assert_eq!(at(Element::Body(2), "hinge.axis"), "[0, 0, 1]");
        assert_eq!(at(Element::Body(1), "hinge.at"), "\"tip\"");
    }

    #[test]
    fn what_is_absent_is_shown_at_the_table_around_it() {
        assert!(at(Element::Body(0), "hinge.at").starts_with("{ type"));
        assert_eq!(at(Element::Body(0), "inertia"), "[[body]]");
        assert_eq!(at(Element::Body(3), "inertia"), "7");
        assert_eq!(at(Element::Body(3), "hinge.at"), "hinge");
        assert_eq!(at(Element::Force(0), "stiffness"), "[[force]]");
        assert_eq!(at(Element::Scene, "title"), "");
    }

    #[test]
    fn copies_say_a_problem_once() {
        assert_eq!(without_copies("body `link[12]` on `link[11]`"), "body `link[]` on `link[]`");
    }
}
