//! What the reader has found so far. It never stops at the first problem.

use super::diagnostic::{Diagnostic, Severity};
use super::sources::Sources;
use std::cell::{Cell, RefCell};
use std::collections::BTreeSet;
use std::ops::Range;

/// A finding before its place is looked up.
#[derive(Debug)]
pub(super) struct Finding {
    severity: Severity,
    span: Option<Range<usize>>,
    message: String,
    label: String,
    help: Option<String>,
}

impl Finding {
    pub(super) fn error(span: Range<usize>, message: String) -> Self {
        Self { severity: Severity::Error, span: Some(span), message, label: String::new(), help: None }
    }

    pub(super) fn warning(span: Range<usize>, message: String) -> Self {
        Self { severity: Severity::Warning, ..Self::error(span, message) }
    }

    /// An error that has no place in the file.
    pub(super) fn without_place(message: String) -> Self {
        Self { span: None, ..Self::error(0..0, message) }
    }

    pub(super) fn label(mut self, label: impl Into<String>) -> Self {
        self.label = label.into();
        self
    }

    pub(super) fn help(self, help: impl Into<String>) -> Self {
        self.maybe_help(Some(help.into()))
    }

    pub(super) fn maybe_help(mut self, help: Option<String>) -> Self {
        self.help = help;
        self
    }
}

/// All findings, and which values must not be read because of them.
#[derive(Debug, Default)]
pub(super) struct Findings {
    list: RefCell<Vec<Finding>>,
    errors: Cell<usize>,
    unreadable: RefCell<BTreeSet<(usize, usize)>>,
}

impl Findings {
    pub(super) fn push(&self, finding: Finding) {
        self.errors.set(self.errors.get() + usize::from(finding.severity == Severity::Error));
        self.list.borrow_mut().push(finding);
    }

    /// Adds a finding about a value, which is not read from now on.
    pub(super) fn push_value(&self, finding: Finding) {
        if let Some(span) = &finding.span {
            self.unreadable.borrow_mut().insert((span.start, span.end));
        }
        self.push(finding);
    }

    /// Whether something was found within this value.
    pub(super) fn touch(&self, value: &Range<usize>) -> bool {
        let unreadable = self.unreadable.borrow();
        unreadable.range((value.start, 0)..(value.end, 0)).next().is_some()
    }

    /// Whether this value lies within one about which something was found.
    pub(super) fn cover(&self, value: &Range<usize>) -> bool {
        let unreadable = self.unreadable.borrow();
        let before = unreadable.range(..=(value.start, usize::MAX)).next_back();
        before.is_some_and(|(start, end)| *start <= value.start && value.end <= *end)
    }

    /// How many errors there are.
    pub(super) fn errors(&self) -> usize {
        self.errors.get()
    }

    /// With lines and columns, in the order of the file.
    pub(super) fn into_diagnostics(self, sources: &Sources<'_>) -> Vec<Diagnostic> {
        let mut list = self.list.into_inner();
        list.sort_by_key(|finding| finding.span.as_ref().map(|span| span.start));
        let resolve = |finding: Finding| Diagnostic {
            severity: finding.severity,
            message: finding.message,
            place: finding.span.map(|span| sources.place(&span)),
            label: finding.label,
            help: finding.help,
        };
        list.into_iter().map(resolve).collect()
    }
}
