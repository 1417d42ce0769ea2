//! Changes of structure in a run: what a stage does, and when.

use super::problem::number;
use std::fmt;

/// A change of structure.
#[derive(Debug, Clone, PartialEq)]
pub struct StageDescription {
    /// Unique name.
    pub name: String,
    /// When it comes.
    pub when: When,
    /// Hinges (by the names of their bodies), loops, contacts, drives, gears and motors that go.
    pub open: Vec<String>,
    /// Loops, contacts, drives, gears and motors that come.
    pub close: Vec<String>,
    /// Hinges whose coordinates are held from then on.
    pub lock: Vec<String>,
    /// Locked hinges that move from then on.
    pub release: Vec<String>,
    /// Outputs that are told with it, as they are before it.
    pub outputs: Vec<String>,
}

/// When a stage comes.
#[derive(Debug, Clone, PartialEq)]
pub enum When {
    /// At this time (s).
    Time(f64),
    /// At the first crossing of the event of this name.
    Event(String),
}

/// What a stage does to something.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verb {
    /// It goes.
    Open,
    /// It comes.
    Close,
    /// Its coordinates are held.
    Lock,
    /// They are free again.
    Release,
}

impl Verb {
    /// The key in scenario files.
    pub fn key(self) -> &'static str {
        match self {
            Self::Open => "open",
            Self::Close => "close",
            Self::Lock => "lock",
            Self::Release => "release",
        }
    }
}

impl StageDescription {
    /// A stage that changes nothing yet.
    pub fn new(name: &str, when: When) -> Self {
        let none = Vec::new;
        Self {
            name: name.to_owned(),
            when,
            open: none(),
            close: none(),
            lock: none(),
            release: none(),
            outputs: none(),
        }
    }

    /// What it names, with the place in the list of its verb.
    pub fn named(&self) -> impl Iterator<Item = (Verb, usize, &str)> {
        let lists = [
            (Verb::Open, &self.open),
            (Verb::Close, &self.close),
            (Verb::Lock, &self.lock),
            (Verb::Release, &self.release),
        ];
        lists
            .into_iter()
            .flat_map(|(verb, names)| names.iter().enumerate().map(move |(index, name)| (verb, index, name.as_str())))
    }
}

impl fmt::Display for When {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Time(time) => write!(f, "t = {} s", number(*time)),
            Self::Event(name) => write!(f, "event `{name}`"),
        }
    }
}
