//! What is wrong with a formula, and where.

use std::fmt;
use std::ops::Range;

/// Why a text is no formula.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FormulaError {
    /// Where in the text (in bytes).
    pub span: Range<usize>,
    /// What is wrong there.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
}

impl FormulaError {
    pub(super) fn new(span: Range<usize>, message: impl Into<String>) -> Self {
        Self { span, message: message.into(), help: None }
    }

    pub(super) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// With the place in words, for those who cannot point at it: `unknown name `tt` at character 5 of `sin(tt)``.
    pub fn in_words(&self, text: &str) -> String {
        const LONGEST: usize = 60;
        let column = text.get(..self.span.start).map_or(0, |before| before.chars().count()) + 1;
        let shown: String = text.chars().take(LONGEST).collect();
        let cut = if shown.len() < text.len() { "…" } else { "" };
        format!("{} at character {column} of the formula `{shown}{cut}`", self.message)
    }
}

impl fmt::Display for FormulaError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.help {
            Some(help) => write!(f, "{} ({help})", self.message),
            None => f.write_str(&self.message),
        }
    }
}

impl std::error::Error for FormulaError {}
