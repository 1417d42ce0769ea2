//! What is wrong with a description, said so that a scenario file can point at it.

use std::fmt;

/// One problem of a description.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problem {
    /// Which element.
    pub element: Element,
    /// Which field of it, as in scenario files: `inertia`, `hinge.parent`, `between(1)`.
    pub field: String,
    /// What is wrong, with the element's name, the value and what is allowed.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
}

/// The element a problem belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Element {
    /// The scene as a whole.
    Scene,
    /// Index into `Description::bodies`.
    Body(usize),
    /// Index into `Description::forces`.
    Force(usize),
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.message)?;
        match &self.help {
            Some(help) => write!(f, " ({help})"),
            None => Ok(()),
        }
    }
}
