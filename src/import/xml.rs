//! Reading XML: every element and attribute with its place, and a count of what has been read.
//!
//! Every accessor marks what it was asked for. What an importer never asked for is found by [`Element::sweep`].

use super::bounds;
use super::log::{Log, Place, Problem, Taken};
use crate::budget::XML_NODES;
use crate::foreign;
use roxmltree::{Document, Node, ParsingOptions};
use std::ops::Range;

/// Parses a text; what is wrong with it is in the log.
pub(super) fn parse<'t>(text: &'t str, source: usize, log: &Log) -> Option<Document<'t>> {
    match document(text) {
        Ok(document) => Some(document),
        Err(Unread::Beyond(at, what)) => {
            log.refuse(Problem::at(Place { source, span: at..(at + 1).min(text.len()) }, what));
            None
        }
        Err(Unread::Syntax(error)) => {
            let at = byte_at(text, error.pos().row, error.pos().col);
            let span = at..at + text[at..].chars().next().map_or(0, char::len_utf8);
            // The place is shown beside the message.
            let said = error.to_string();
            let said = said.rsplit_once(" at ").map_or(said.as_str(), |(said, _)| said);
            let mut problem = Problem::at(Place { source, span }, format!("not valid XML: {said}"));
            if matches!(&error, roxmltree::Error::UnknownNamespace(prefix, _) if prefix == "xacro") {
                problem = problem.help("this is a macro: expand it first, as in `xacro robot.urdf.xacro > robot.urdf`");
            }
            log.refuse(problem);
            None
        }
    }
}

/// Why a text is no document.
pub(super) enum Unread {
    /// It asks for more than its budget, from this byte on, or the parser gave up on it.
    Beyond(usize, String),
    /// It is not XML.
    Syntax(roxmltree::Error),
}

/// The document of a text, within its budget.
pub(super) fn document(text: &str) -> Result<Document<'_>, Unread> {
    if let Some((at, what)) = bounds::beyond(text) {
        return Err(Unread::Beyond(at, what));
    }
    let options = ParsingOptions { nodes_limit: XML_NODES, allow_dtd: true, ..ParsingOptions::default() };
    match foreign::parse("the reader of XML", || Document::parse_with_options(text, options)) {
        Ok(Ok(document)) => Ok(document),
        Ok(Err(roxmltree::Error::NodesLimitReached)) => {
            Err(Unread::Beyond(0, format!("more than {XML_NODES} elements and texts, the most that is read")))
        }
        Ok(Err(error)) => Err(Unread::Syntax(error)),
        Err(panicked) => Err(Unread::Beyond(0, panicked)),
    }
}

/// The byte of a line and a column, both from 1.
fn byte_at(text: &str, row: u32, column: u32) -> usize {
    let line_start: usize = text.split_inclusive('\n').take(row.saturating_sub(1) as usize).map(str::len).sum();
    let rest = &text[line_start..];
    let inside = rest.char_indices().nth(column.saturating_sub(1) as usize).map_or(rest.len(), |(at, _)| at);
    line_start + inside
}

/// The outermost element.
pub(super) fn root<'a>(document: &'a Document<'a>, source: usize, log: &'a Log) -> Element<'a> {
    let root = Element { node: document.root_element(), source, log };
    root.see();
    root
}

/// An element.
#[derive(Clone, Copy)]
pub(super) struct Element<'a> {
    node: Node<'a, 'a>,
    source: usize,
    pub(super) log: &'a Log,
}

/// An attribute.
#[derive(Clone, Copy)]
pub(super) struct Attribute<'a> {
    pub(super) element: Element<'a>,
    pub(super) key: &'a str,
    pub(super) value: &'a str,
    start: usize,
    end: usize,
}

impl<'a> Element<'a> {
    /// Marks it as read.
    pub(super) fn see(&self) {
        self.log.see(self.source, self.node.range().start);
    }

    /// Its tag.
    pub(super) fn name(&self) -> &'a str {
        self.node.tag_name().name()
    }

    /// The tag where it opens.
    pub(super) fn place(&self) -> Place {
        let start = self.node.range().start;
        Place { source: self.source, span: self.open_tag(start) }
    }

    fn open_tag(&self, start: usize) -> Range<usize> {
        let text = self.node.document().input_text();
        let name = text[start..].find(|c: char| c.is_whitespace() || c == '>' || c == '/').unwrap_or(1);
        start..start + name
    }

    /// What it is called in messages: ``joint `elbow` ``, ``axis of joint `elbow` ``.
    pub(super) fn label(&self) -> String {
        let mut label = String::new();
        for node in self.node.ancestors().filter(Node::is_element) {
            if node.parent_element().is_none() {
                break;
            }
            let tag = node.tag_name().name();
            let name = node.attribute("name");
            if !label.is_empty() {
                label += " of ";
            }
            match name {
                Some(name) => {
                    label += &format!("{tag} `{}`", cut(name));
                    break;
                }
                None => label += &format!("<{tag}>"),
            }
        }
        if label.is_empty() { format!("<{}>", self.name()) } else { label }
    }

    /// The first element in it, itself included, of a namespace whose address holds this word.
    pub(super) fn of_namespace(&self, word: &str) -> Option<Element<'a>> {
        let of =
            |node: &Node<'a, 'a>| node.is_element() && node.tag_name().namespace().is_some_and(|n| n.contains(word));
        self.node.descendants().find(of).map(|node| Element { node, ..*self })
    }

    /// The first child of this name.
    pub(super) fn child(&self, name: &str) -> Option<Element<'a>> {
        let child = self.elements().find(|child| child.name() == name)?;
        child.see();
        Some(child)
    }

    /// All children of this name.
    pub(super) fn children(&self, name: &'a str) -> impl Iterator<Item = Element<'a>> + use<'a> {
        self.elements().filter(move |child| child.name() == name).inspect(Self::see)
    }

    /// All children, marked as read.
    pub(super) fn all_children(&self) -> impl Iterator<Item = Element<'a>> + use<'a> {
        self.elements().inspect(Self::see)
    }

    /// The first element in it with one of these names, which is not marked as read.
    pub(super) fn within(&self, names: &[&str]) -> Option<Self> {
        self.elements().find_map(|child| if names.contains(&child.name()) { Some(child) } else { child.within(names) })
    }

    /// Marks everything in it as read, for what is noted as a whole.
    pub(super) fn see_all(&self) {
        for node in self.node.descendants().filter(Node::is_element) {
            self.log.see(self.source, node.range().start);
            node.attributes().for_each(|attribute| self.log.see(self.source, attribute.range().start));
        }
    }

    fn elements(&self) -> impl Iterator<Item = Element<'a>> + use<'a> {
        let (source, log) = (self.source, self.log);
        self.node.children().filter(Node::is_element).map(move |node| Element { node, source, log })
    }

    /// All children, not marked as read.
    pub(super) fn unread_children(&self) -> impl Iterator<Item = Element<'a>> + use<'a> {
        self.elements()
    }

    /// Whether it is marked as read.
    pub(super) fn was_seen(&self) -> bool {
        self.log.has_seen(self.source, self.node.range().start)
    }

    /// The attributes that are not marked as read.
    pub(super) fn unread_attributes(&self) -> impl Iterator<Item = Attribute<'a>> + use<'a> {
        let element = *self;
        self.node.attributes().filter_map(move |attribute| {
            let range = attribute.range();
            let unread = !element.log.has_seen(element.source, range.start);
            unread.then(|| Attribute {
                element,
                key: attribute.name(),
                value: attribute.value(),
                start: range.start,
                end: range.end,
            })
        })
    }

    /// An attribute.
    pub(super) fn attribute(&self, key: &str) -> Option<Attribute<'a>> {
        let found =
            self.node.attributes().find(|attribute| attribute.name() == key && attribute.namespace().is_none())?;
        let range = found.range();
        self.log.see(self.source, range.start);
        Some(Attribute { element: *self, key: found.name(), value: found.value(), start: range.start, end: range.end })
    }

    /// The text of an attribute.
    pub(super) fn text(&self, key: &str) -> Option<&'a str> {
        self.attribute(key).map(|attribute| attribute.value)
    }

    /// The text of an attribute that must be there.
    pub(super) fn required(&self, key: &str) -> Option<Attribute<'a>> {
        let found = self.attribute(key);
        if found.is_none() {
            let known: Vec<&str> = self.node.attributes().map(|attribute| attribute.name()).collect();
            let help = self.log.near(key, known.into_iter()).map(|near| format!("`{near}` is there: is it meant?"));
            let message = format!("{}: `{key}` is missing", self.label());
            self.refuse(Problem::at(self.place(), message).maybe_help(help));
        }
        found
    }

    /// The number of an attribute; `None` if it is absent or was refused.
    pub(super) fn number(&self, key: &str) -> Option<f64> {
        self.attribute(key)?.number()
    }

    /// The numbers of an attribute; `None` if it is absent or was refused.
    pub(super) fn vector<const N: usize>(&self, key: &str) -> Option<[f64; N]> {
        self.attribute(key)?.vector()
    }

    /// Says that something is wrong.
    pub(super) fn refuse(&self, problem: Problem) {
        self.log.refuse(problem);
    }

    /// Says how this element was taken.
    pub(super) fn note(&self, verdict: Taken, what: impl Into<String>) {
        self.log.note(self.place(), self.label(), verdict, what);
    }

    /// Notes everything in this element that nobody has read. `why` may know a reason, by the element's tag.
    pub(super) fn sweep(&self, why: fn(&str) -> Option<&'static str>) {
        let mut node = Some(self.node);
        let root = self.node;
        while let Some(current) = node {
            let seen = current.is_element() && self.log.has_seen(self.source, current.range().start);
            if seen {
                self.sweep_attributes(current);
            } else if current.is_element() {
                let element = Element { node: current, ..*self };
                let what = why(element.name()).unwrap_or("not known here, nor is anything within it");
                element.note(Taken::Ignored, what);
            } else if current.is_text() && current.text().is_some_and(|text| !text.trim().is_empty()) {
                let parent = current.parent().map_or(*self, |node| Element { node, ..*self });
                let place = Place { source: self.source, span: current.range() };
                let text = cut(current.text().unwrap_or_default().trim());
                self.log.note(place, parent.label(), Taken::Ignored, format!("the text `{text}`"));
            }
            node = if seen && current.has_children() { current.first_child() } else { following(current, root) };
        }
    }

    fn sweep_attributes(&self, node: Node<'a, 'a>) {
        for attribute in node.attributes() {
            let range = attribute.range();
            if !self.log.has_seen(self.source, range.start) {
                let element = Element { node, ..*self };
                let what = format!("`{} = \"{}\"` is not known here", attribute.name(), cut(attribute.value()));
                let place = Place { source: self.source, span: range };
                self.log.note(place, element.label(), Taken::Ignored, what);
            }
        }
    }
}

/// The next node that is not within this one, staying within `root`.
fn following<'a>(node: Node<'a, 'a>, root: Node<'a, 'a>) -> Option<Node<'a, 'a>> {
    let mut node = node;
    while node != root {
        if let Some(next) = node.next_sibling() {
            return Some(next);
        }
        node = node.parent()?;
    }
    None
}

impl<'a> Attribute<'a> {
    /// Where it is written.
    pub(super) fn place(&self) -> Place {
        Place { source: self.element.source, span: self.start..self.end }
    }

    /// Says that its value is wrong: ``limit of joint `elbow`: `lower` …``.
    pub(super) fn wrong(&self, what: &str) -> Problem {
        Problem::at(self.place(), format!("{}: `{}` {what}", self.element.label(), self.key))
    }

    /// The finite number it holds; otherwise that has been said.
    pub(super) fn number(&self) -> Option<f64> {
        self.vector::<1>().map(|[number]| number)
    }

    /// So many finite numbers; otherwise that has been said.
    pub(super) fn vector<const N: usize>(&self) -> Option<[f64; N]> {
        let numbers = self.numbers()?;
        let count = numbers.len();
        let vector = numbers.try_into().ok();
        if vector.is_none() {
            let wanted = if N == 1 { "one number".to_owned() } else { format!("{N} numbers") };
            self.element.refuse(self.wrong(&format!("must be {wanted}, found {count}: \"{}\"", cut(self.value))));
        }
        vector
    }

    /// Any number of finite numbers; otherwise that has been said.
    pub(super) fn numbers(&self) -> Option<Vec<f64>> {
        let mut numbers = Vec::new();
        for word in self.value.split_whitespace() {
            match word.parse::<f64>() {
                Ok(number) if number.is_finite() => numbers.push(number),
                Ok(_) => {
                    self.element.refuse(self.wrong(&format!("is {}, which is not a finite number", cut(word))));
                    return None;
                }
                Err(_) => {
                    let many = if self.value.trim() == word { "a number" } else { "numbers" };
                    let mut problem = self.wrong(&format!("must be {many}, found \"{}\"", cut(word)));
                    if word.contains("${") || word.contains("$(") {
                        problem =
                            problem.help("this is a macro: expand it first, as in `xacro robot.xacro > robot.urdf`");
                    }
                    self.element.refuse(problem);
                    return None;
                }
            }
        }
        Some(numbers)
    }
}

/// A text, cut where it is long.
pub(super) fn cut(text: &str) -> String {
    const LONGEST: usize = 60;
    match text.char_indices().nth(LONGEST) {
        Some((cut, _)) => format!("{}…", &text[..cut]),
        None => text.to_owned(),
    }
}
