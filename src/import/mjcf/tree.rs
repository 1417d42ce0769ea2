//! The elements of a model with everything it includes, as one tree.

use super::super::log::{Log, Problem};
use super::super::xml::{self, Element};
use crate::text_file;
use roxmltree::Document;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// More levels of elements than any model has. Nothing recurses deeper than this.
const DEEPEST: usize = 200;

/// Included files are found and read first, so that all documents stay where they are.
#[derive(Debug)]
pub(super) struct Files {
    /// Source number and text of every included file.
    pub(super) texts: Vec<(usize, Arc<str>)>,
    /// Which of them an `<include>` means: source and first byte of the element.
    links: HashMap<(usize, usize), usize>,
}

impl Files {
    /// Reads what the model includes; what is wrong with that is in the log.
    pub(super) fn gather(root: &Element<'_>, path: &Path) -> Option<Self> {
        let log = root.log;
        let mut search = Search {
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
            known: HashSet::from([real(path)]),
            found: Self { texts: Vec::new(), links: HashMap::new() },
        };
        search.includes(root);
        let mut next = 0;
        while next < search.found.texts.len() {
            let (source, text) = search.found.texts[next].clone();
            let document = xml::parse(&text, source, log)?;
            search.includes(&xml::root(&document, source, log));
            next += 1;
        }
        log.is_fine().then_some(search.found)
    }

    /// The documents of the texts.
    pub(super) fn documents<'t>(&'t self, log: &Log) -> Option<Vec<Document<'t>>> {
        self.texts.iter().map(|(source, text)| xml::parse(text, *source, log)).collect()
    }
}

struct Search {
    folder: PathBuf,
    known: HashSet<PathBuf>,
    found: Files,
}

impl Search {
    fn includes(&mut self, root: &Element<'_>) {
        let (deepest, includes) = descendants(root);
        if let Some(deep) = deepest {
            let message = format!("{}: elements are nested deeper than {DEEPEST} levels", deep.label());
            deep.refuse(Problem::at(deep.place(), message));
        }
        for include in includes {
            if let Some(index) = self.include(&include) {
                let place = include.place();
                self.found.links.insert((place.source, place.span.start), index);
            }
        }
    }

    fn include(&mut self, include: &Element<'_>) -> Option<usize> {
        let file = include.required("file")?;
        let path = self.folder.join(file.value);
        if !self.known.insert(real(&path)) {
            let problem = file.wrong(&format!("is \"{}\", which is included already", file.value));
            include.refuse(problem.help("a file can be included once, and not by itself"));
            return None;
        }
        match text_file::read(&path, "included file") {
            Ok(text) => {
                let source = include.log.add(&path, text);
                self.found.texts.push((source, include.log.text(source)));
                Some(self.found.texts.len() - 1)
            }
            Err(error) => {
                let problem = file.wrong(&format!("cannot be included: {error}"));
                include.refuse(problem.help("included files are found from the folder of the main model"));
                None
            }
        }
    }
}

fn real(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// The first element that is too deep, and all includes.
fn descendants<'a>(root: &Element<'a>) -> (Option<Element<'a>>, Vec<Element<'a>>) {
    let (mut deepest, mut includes) = (None, Vec::new());
    let mut stack = vec![(*root, 0)];
    while let Some((element, depth)) = stack.pop() {
        if depth > DEEPEST {
            deepest = deepest.or(Some(element));
            continue;
        }
        if element.name() == "include" {
            includes.push(element);
        }
        let children: Vec<Element<'a>> = element.unread_children().collect();
        stack.extend(children.into_iter().rev().map(|child| (child, depth + 1)));
    }
    (deepest, includes)
}

/// The whole model: a root whose children may stand in other files.
#[derive(Clone, Copy)]
pub(super) struct Tree<'a> {
    pub(super) root: Element<'a>,
    pub(super) files: &'a Files,
    pub(super) documents: &'a [Document<'a>],
}

impl<'a> Tree<'a> {
    /// The children of an element with those of included files in their places; none is marked as read.
    pub(super) fn children(&self, element: &Element<'a>) -> Vec<Element<'a>> {
        let mut list = Vec::new();
        self.collect(element, &mut list, 0);
        list
    }

    fn collect(&self, element: &Element<'a>, list: &mut Vec<Element<'a>>, depth: usize) {
        for child in element.unread_children() {
            let place = child.place();
            let link = self.files.links.get(&(place.source, place.span.start));
            match link.filter(|_| child.name() == "include" && depth <= DEEPEST) {
                Some(&index) => {
                    child.see();
                    let source = self.files.texts[index].0;
                    self.collect(&xml::root(&self.documents[index], source, self.root.log), list, depth + 1);
                }
                None => list.push(child),
            }
        }
    }

    /// The children of this name, marked as read.
    pub(super) fn all(&self, element: &Element<'a>, name: &str) -> Vec<Element<'a>> {
        let mut children = self.children(element);
        children.retain(|child| child.name() == name);
        children.iter().for_each(Element::see);
        children
    }

    /// What stands in all sections of this name: `<worldbody>`, `<actuator>`.
    pub(super) fn section(&self, name: &str) -> Vec<Element<'a>> {
        self.all(&self.root, name).iter().flat_map(|section| self.children(section)).collect()
    }

    /// All documents from their roots.
    pub(super) fn roots(&self) -> Vec<Element<'a>> {
        let included = self.documents.iter().zip(&self.files.texts);
        let included = included.map(|(document, (source, _))| xml::root(document, *source, self.root.log));
        [self.root].into_iter().chain(included).collect()
    }
}
