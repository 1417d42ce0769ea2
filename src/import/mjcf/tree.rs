//! The elements of a model with everything it includes, as one tree.

use super::super::log::{Log, Problem};
use super::super::mend;
use super::super::xml::{self, Element};
use crate::import::is_model;
use crate::text_file;
use roxmltree::Document;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// More levels of elements than any model has. Nothing recurses deeper than this.
const DEEPEST: usize = 200;

/// More models than these within a model are none that anybody has written.
const MOST_MODELS: usize = 500;

/// Included files and attached models are found and read first, so that all documents stay where they are.
#[derive(Debug)]
pub(super) struct Files {
    /// Source number and text of every file besides the main one.
    pub(super) texts: Vec<(usize, Arc<str>)>,
    /// Which of them an `<include>` means: source and first byte of the element.
    links: HashMap<(usize, usize), usize>,
    /// Which of them a `<model>` means, and its file.
    models: HashMap<(usize, usize), (usize, PathBuf)>,
}

impl Files {
    /// Reads what the model includes and attaches; what is wrong with that is in the log.
    pub(super) fn gather(root: &Element<'_>, path: &Path) -> Option<Self> {
        let log = root.log;
        let mut search = Search {
            tops: vec![Top { folder: folder(path), known: HashSet::from([real(path)]), around: vec![real(path)] }],
            places: Vec::new(),
            found: Self { texts: Vec::new(), links: HashMap::new(), models: HashMap::new() },
        };
        search.follow(root, &Around { top: 0, folder: folder(path) });
        let mut next = 0;
        while next < search.found.texts.len() {
            let (source, text) = search.found.texts[next].clone();
            let document = xml::parse(&text, source, log)?;
            let place = search.places[next].clone();
            search.follow(&xml::root(&document, source, log), &place);
            next += 1;
        }
        log.is_fine().then_some(search.found)
    }

    /// The documents of the texts.
    pub(super) fn documents<'t>(&'t self, log: &Log) -> Option<Vec<Document<'t>>> {
        self.texts.iter().map(|(source, text)| xml::parse(text, *source, log)).collect()
    }
}

/// A model with what it includes: the main one, or one that is attached.
struct Top {
    folder: PathBuf,
    /// What is included.
    known: HashSet<PathBuf>,
    /// The files of this model and of those it is part of.
    around: Vec<PathBuf>,
}

/// Where an element stands.
#[derive(Clone)]
struct Around {
    top: usize,
    /// Of the file.
    folder: PathBuf,
}

struct Search {
    tops: Vec<Top>,
    /// Of every text.
    places: Vec<Around>,
    found: Files,
}

impl Search {
    fn follow(&mut self, root: &Element<'_>, around: &Around) {
        let (deepest, others) = descendants(root);
        if let Some(deep) = deepest {
            let message = format!("{}: elements are nested deeper than {DEEPEST} levels", deep.label());
            deep.refuse(Problem::at(deep.place(), message));
        }
        for element in others {
            let place = element.place();
            let key = (place.source, place.span.start);
            if element.name() == "include" {
                if let Some(index) = self.include(&element, around) {
                    self.found.links.insert(key, index);
                }
            } else if let Some(found) = self.model(&element, around) {
                self.found.models.insert(key, found);
            }
        }
    }

    /// A file is found from the folder of the whole model, failing that from the folder of the file that includes it.
    fn include(&mut self, include: &Element<'_>, around: &Around) -> Option<usize> {
        let file = include.required("file")?;
        let near = around.folder.join(file.value);
        let path = Some(self.tops[around.top].folder.join(file.value)).filter(|path| path.is_file());
        let path = path.unwrap_or(near);
        if !self.tops[around.top].known.insert(real(&path)) {
            let problem = file.wrong(&format!("is \"{}\", which is included already", file.value));
            include.refuse(problem.help("a file can be included once, and not by itself"));
            return None;
        }
        let help =
            "included files are found from the folder of the main model, then from that of the file that includes them";
        self.read(include, &path, around.top, ["included file", "cannot be included", help])
    }

    /// A model that others can attach.
    fn model(&mut self, model: &Element<'_>, around: &Around) -> Option<(usize, PathBuf)> {
        let file = model.required("file")?;
        let top = &self.tops[around.top];
        let path = top.folder.join(file.value);
        if top.around.contains(&real(&path)) {
            let problem = file.wrong(&format!("is \"{}\", which this model is part of", file.value));
            model.refuse(problem.help("a model cannot be attached to itself"));
            return None;
        }
        if self.tops.len() > MOST_MODELS {
            let problem = file.wrong(&format!("is one of more than {MOST_MODELS} models within this one"));
            model.refuse(problem.help("count those within them"));
            return None;
        }
        let around = top.around.iter().cloned().chain([real(&path)]).collect();
        let known = HashSet::from([real(&path)]);
        self.tops.push(Top { folder: folder(&path), known, around });
        let help = "models are found from the folder of the model that names them";
        let read = self.read(model, &path, self.tops.len() - 1, ["model", "cannot be read", help])?;
        Some((read, path))
    }

    fn read(
        &mut self,
        element: &Element<'_>,
        path: &Path,
        top: usize,
        [what, cannot, help]: [&'static str; 3],
    ) -> Option<usize> {
        match text_file::read_regular(path, what) {
            // What is no XML may be anything, and is not shown.
            Ok(text) if !is_model(&text) => {
                let file = element.attribute("file")?;
                element.refuse(file.wrong(&format!("is \"{}\", which is no XML file", file.value)));
                None
            }
            Ok(text) => {
                let source = element.log.add(path, text);
                let text = mend::readable(element.log.text(source), source, element.log);
                self.found.texts.push((source, text));
                self.places.push(Around { top, folder: folder(path) });
                Some(self.found.texts.len() - 1)
            }
            Err(error) => {
                let file = element.attribute("file")?;
                element.refuse(file.wrong(&format!("{cannot}: {error}")).help(help));
                None
            }
        }
    }
}

fn folder(path: &Path) -> PathBuf {
    path.parent().unwrap_or(Path::new("")).to_owned()
}

fn real(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// The first element that is too deep, and all that name other files of models.
fn descendants<'a>(root: &Element<'a>) -> (Option<Element<'a>>, Vec<Element<'a>>) {
    let (mut deepest, mut others) = (None, Vec::new());
    let mut stack = vec![(*root, 0)];
    while let Some((element, depth)) = stack.pop() {
        if depth > DEEPEST {
            deepest = deepest.or(Some(element));
            continue;
        }
        if ["include", "model"].contains(&element.name()) {
            others.push(element);
        }
        let children: Vec<Element<'a>> = element.unread_children().collect();
        stack.extend(children.into_iter().rev().map(|child| (child, depth + 1)));
    }
    (deepest, others)
}

/// The whole model: a root whose children may stand in other files.
#[derive(Clone, Copy)]
pub(super) struct Tree<'a> {
    pub(super) root: Element<'a>,
    pub(super) files: &'a Files,
    pub(super) documents: &'a [Document<'a>],
}

impl<'a> Tree<'a> {
    /// The model that a `<model>` means, and its file.
    pub(super) fn model(&self, element: &Element<'a>) -> Option<(Self, &'a Path)> {
        let place = element.place();
        let (index, path) = self.files.models.get(&(place.source, place.span.start))?;
        let source = self.files.texts[*index].0;
        Some((Self { root: xml::root(&self.documents[*index], source, self.root.log), ..*self }, path))
    }

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
                    let root = xml::root(&self.documents[index], source, self.root.log);
                    // What an included file calls itself says nothing of the model.
                    root.text("model");
                    self.collect(&root, list, depth + 1);
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
