//! What is wrong with a scenario, for the person who must fix it: file, line, column, the line with a caret, what is
//! allowed and a hint.

use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use std::fmt;
use std::ops::Range;

/// The most diagnostics that are printed; the rest is counted.
pub const MOST_PRINTED: usize = 50;

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The scenario cannot be used.
    Error,
    /// It can, but not all that it says will happen.
    Warning,
}

/// One finding.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong, with the element's name and the value.
    pub message: String,
    /// Where it is written; `None` for what is missing from the file as a whole.
    pub place: Option<Place>,
    /// Short words under the caret, often what is allowed; may be empty.
    pub label: String,
    /// What to do about it.
    pub help: Option<String>,
}

/// A place in a file or on the command line.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// Name of the file, or `command line`.
    pub file: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// The line, or the part of a very long one around the place.
    pub excerpt: String,
    /// What the caret marks: bytes of the excerpt.
    pub marked: Range<usize>,
}

/// All findings about one scenario, in the order of the file.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Diagnostics {
    file: String,
    list: Vec<Diagnostic>,
}

impl Diagnostics {
    /// The findings about a file.
    pub fn new(file: &str, list: Vec<Diagnostic>) -> Self {
        Self { file: file.to_owned(), list }
    }

    /// One by one.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.list.iter()
    }

    /// Whether there is nothing to say.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// How many of them are errors.
    pub fn errors(&self) -> usize {
        self.list.iter().filter(|one| one.severity == Severity::Error).count()
    }

    /// As text for people: the [findings](Self::findings), then a line that counts them all.
    pub fn render(&self, color: bool) -> String {
        if self.list.is_empty() { String::new() } else { self.findings(color) + &self.summary() }
    }

    /// As text for people: the first [`MOST_PRINTED`] findings, errors first. With `color` it holds ANSI escape codes.
    pub fn findings(&self, color: bool) -> String {
        let renderer = if color { Renderer::styled() } else { Renderer::plain() };
        let mut shown: Vec<&Diagnostic> = self.list.iter().collect();
        shown.sort_by_key(|one| one.severity);
        let mut text = String::new();
        for diagnostic in shown.iter().take(MOST_PRINTED) {
            text += &diagnostic.render(&renderer, &self.file);
            text += "\n\n";
        }
        if shown.len() > MOST_PRINTED {
            text += &format!("and {} more\n", shown.len() - MOST_PRINTED);
        }
        text
    }

    /// `scene.toml: 2 errors, 1 warning`
    pub fn summary(&self) -> String {
        let errors = self.errors();
        let warnings = self.list.len() - errors;
        let counts = [(errors, "error"), (warnings, "warning")];
        let said: Vec<String> = counts
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {what}{}", if *count == 1 { "" } else { "s" }))
            .collect();
        format!("{}: {}", self.file, said.join(", "))
    }
}

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for Diagnostics {}

impl<'a> IntoIterator for &'a Diagnostics {
    type Item = &'a Diagnostic;
    type IntoIter = std::slice::Iter<'a, Diagnostic>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl Diagnostic {
    fn render(&self, renderer: &Renderer, file: &str) -> String {
        let level = match self.severity {
            Severity::Error => Level::ERROR,
            Severity::Warning => Level::WARNING,
        };
        let group = Group::with_title(level.primary_title(&self.message));
        let group = match &self.place {
            None => group.element(Origin::path(file)),
            Some(place) => {
                let mark = AnnotationKind::Primary.span(place.marked.clone());
                let label = (!self.label.is_empty()).then_some(self.label.as_str());
                let snippet = Snippet::source(&place.excerpt).line_start(place.line).annotation(mark.label(label));
                if place.excerpt[..place.marked.start].chars().count() + 1 == place.column {
                    group.element(snippet.path(&place.file))
                } else {
                    // Cut from a long line: its columns are not those of the file.
                    let origin = Origin::path(&place.file).line(place.line).char_column(place.column);
                    group.element(origin).element(snippet)
                }
            }
        };
        renderer.render(&[group.elements(self.help.iter().map(|help| Level::HELP.message(help)))])
    }
}
