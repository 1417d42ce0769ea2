//! What an importer has to say: notes on what was taken how, and problems.

use crate::suggest::closest_of_many;
use crate::text_file::ReadError;
use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, HashSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A file that was read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Source {
    /// As it was asked for.
    pub path: PathBuf,
    /// Its text.
    pub text: Arc<str>,
    /// Where its lines end: models are long, and much is said of them.
    ends: Arc<[usize]>,
}

impl Source {
    fn new(path: &Path, text: String) -> Self {
        let ends = text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at).collect();
        Self { path: path.to_owned(), text: text.into(), ends }
    }

    /// The line of a byte, from 1.
    pub fn line(&self, byte: usize) -> usize {
        1 + self.ends.partition_point(|end| *end < byte)
    }
}

/// Where something is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Which source.
    pub source: usize,
    /// Which bytes of it.
    pub span: Range<usize>,
}

impl Place {
    /// In the order of the sources.
    fn key(&self) -> (usize, usize) {
        (self.source, self.span.start)
    }
}

/// How an element was taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Taken {
    /// As it is meant, with something to know about it.
    Used,
    /// As something that is near to it.
    Approximated,
    /// Not at all.
    Ignored,
}

impl Taken {
    /// In one word.
    pub fn word(self) -> &'static str {
        match self {
            Self::Used => "used",
            Self::Approximated => "approximated",
            Self::Ignored => "ignored",
        }
    }
}

/// What became of an element.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Note {
    /// The file, as it was asked for.
    pub file: PathBuf,
    /// Line, from 1.
    pub line: usize,
    /// The element, for people: ``joint `elbow` ``.
    pub element: String,
    /// How it was taken.
    pub verdict: Taken,
    /// What that means.
    pub what: String,
}

/// How many notes there are of each kind: `2 approximated, 3 ignored`; empty for none.
pub fn counted(notes: &[Note]) -> String {
    let count = |verdict: Taken| (notes.iter().filter(|note| note.verdict == verdict).count(), verdict);
    let all = [Taken::Used, Taken::Approximated, Taken::Ignored].map(count);
    let said = all.iter().filter(|(count, _)| *count > 0).map(|(count, verdict)| match verdict {
        Taken::Used => format!("{count} used with a remark"),
        other => format!("{count} {}", other.word()),
    });
    said.collect::<Vec<_>>().join(", ")
}

/// How many of the ignored notes there are for each kind of element (`joint`, `sensor`), the most frequent first.
pub fn ignored_kinds(notes: &[Note]) -> Vec<(String, usize)> {
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for note in notes.iter().filter(|note| note.verdict == Taken::Ignored) {
        let kind = note.element.split_whitespace().next().unwrap_or_default();
        *kinds.entry(kind.trim_matches(['<', '>', '`'])).or_default() += 1;
    }
    let mut kinds: Vec<(String, usize)> = kinds.into_iter().map(|(kind, count)| (kind.to_owned(), count)).collect();
    kinds.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    kinds
}

/// Why a model cannot be taken.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Where; `None` for the file as a whole.
    pub place: Option<Place>,
    /// What is wrong, with the element's name and the value.
    pub message: String,
    /// Short words at the place, often what is allowed; may be empty.
    pub label: String,
    /// What to do about it.
    pub help: Option<String>,
}

impl Problem {
    pub(super) fn at(place: Place, message: String) -> Self {
        Self { place: Some(place), message, label: String::new(), help: None }
    }

    pub(super) fn help(self, help: impl Into<String>) -> Self {
        self.maybe_help(Some(help.into()))
    }

    pub(super) fn maybe_help(mut self, help: Option<String>) -> Self {
        self.help = help;
        self
    }
}

/// A model that cannot be taken.
#[derive(Debug, thiserror::Error)]
pub enum Refused {
    /// Its file cannot be read.
    #[error(transparent)]
    File(#[from] ReadError),
    /// Something is wrong in it.
    #[error("{}", listed(problems, sources))]
    Problems {
        /// Everything that is wrong.
        problems: Vec<Problem>,
        /// The files that were read.
        sources: Vec<Source>,
    },
}

/// One line per problem: `robot.urdf:12: …`.
fn listed(problems: &[Problem], sources: &[Source]) -> String {
    let line = |problem: &Problem| {
        let place = problem.place.as_ref().and_then(|place| Some((sources.get(place.source)?, place)));
        let place = place.map(|(source, at)| format!("{}:{}: ", source.path.display(), source.line(at.span.start)));
        let help = problem.help.as_ref().map(|help| format!(" ({help})"));
        format!("{}{}{}", place.unwrap_or_default(), problem.message, help.unwrap_or_default())
    };
    problems.iter().map(line).collect::<Vec<_>>().join("\n")
}

/// Everything that is said during an import. It never stops at the first problem.
#[derive(Debug)]
pub(super) struct Log {
    sources: RefCell<Vec<Source>>,
    notes: RefCell<Vec<(Place, String, Taken, String)>>,
    problems: RefCell<Vec<Problem>>,
    /// Source and first byte of every element and attribute that was read.
    seen: RefCell<HashSet<(usize, usize)>>,
    /// How many similar names were looked for.
    searches: Cell<usize>,
}

impl Log {
    pub(super) fn new(path: &Path, text: String) -> Self {
        Self {
            sources: RefCell::new(vec![Source::new(path, text)]),
            notes: RefCell::default(),
            problems: RefCell::default(),
            seen: RefCell::default(),
            searches: Cell::default(),
        }
    }

    /// Adds a source, as one that is included.
    pub(super) fn add(&self, path: &Path, text: String) -> usize {
        self.sources.borrow_mut().push(Source::new(path, text));
        self.sources.borrow().len() - 1
    }

    /// File name and line of a place.
    pub(super) fn line(&self, place: &Place) -> (String, usize) {
        let sources = self.sources.borrow();
        let source = &sources[place.source];
        let name = source.path.file_name().map(|name| name.to_string_lossy().into_owned());
        (name.unwrap_or_default(), source.line(place.span.start))
    }

    /// The text of a source.
    pub(super) fn text(&self, source: usize) -> Arc<str> {
        self.sources.borrow()[source].text.clone()
    }

    pub(super) fn note(&self, place: Place, element: String, verdict: Taken, what: impl Into<String>) {
        self.notes.borrow_mut().push((place, element, verdict, what.into()));
    }

    pub(super) fn refuse(&self, problem: Problem) {
        self.problems.borrow_mut().push(problem);
    }

    /// The known name nearest to one that is not known; for the first ones of an import, for each costs a comparison with
    /// all of them.
    pub(super) fn near<'n>(&self, name: &str, known: impl Iterator<Item = &'n str>) -> Option<&'n str> {
        let before = self.searches.replace(self.searches.get() + 1);
        closest_of_many(before, name, known)
    }

    pub(super) fn is_fine(&self) -> bool {
        self.problems.borrow().is_empty()
    }

    /// What starts at this byte has been read.
    pub(super) fn see(&self, source: usize, start: usize) {
        self.seen.borrow_mut().insert((source, start));
    }

    pub(super) fn has_seen(&self, source: usize, start: usize) -> bool {
        self.seen.borrow().contains(&(source, start))
    }

    /// Makes one note of all that say the same about elements of one kind in a source.
    pub(super) fn gather(&self) {
        const LISTED: usize = 6;
        /// Source, verdict, text and kind of element.
        type Said = (usize, Taken, String, String);
        let mut alike: BTreeMap<Said, Vec<(Place, String)>> = BTreeMap::new();
        for (place, element, verdict, what) in self.notes.take() {
            let kind = element.split(' ').next().unwrap_or_default().to_owned();
            alike.entry((place.source, verdict, what, kind)).or_default().push((place, element));
        }
        for ((_, verdict, what, _), mut elements) in alike {
            elements.sort_by_key(|(place, _)| place.span.start);
            // What is attached twice is said once.
            elements.dedup_by(|(one, _), (other, _)| one == other);
            let (place, element) = elements[0].clone();
            let others: Vec<String> =
                elements.iter().skip(1).take(LISTED).map(|(place, _)| self.line(place).1.to_string()).collect();
            let what = match elements.len() - 1 {
                0 => what,
                1 => format!("{what} (and so line {})", others[0]),
                count if count <= LISTED => format!("{what} (and so lines {})", others.join(", ")),
                count => format!("{what} (and so {count} others, lines {}, …)", others.join(", ")),
            };
            self.note(place, element, verdict, what);
        }
    }

    /// All notes in the order of the sources.
    pub(super) fn notes(&mut self) -> Vec<Note> {
        let mut list = self.notes.take();
        list.sort_by_key(|(place, ..)| place.key());
        let sources = self.sources.borrow();
        let note = |(place, element, verdict, what): (Place, String, Taken, String)| {
            let source = &sources[place.source];
            Note { file: source.path.clone(), line: source.line(place.span.start), element, verdict, what }
        };
        list.into_iter().map(note).collect()
    }

    /// All problems in the order of the sources.
    pub(super) fn take_problems(&mut self) -> Vec<Problem> {
        let mut list = self.problems.take();
        list.sort_by_key(|problem| problem.place.as_ref().map(Place::key));
        list
    }

    pub(super) fn into_sources(self) -> Vec<Source> {
        self.sources.into_inner()
    }
}
