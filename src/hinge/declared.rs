//! What scenario files say of the kinds of hinge, known when the tables of their keys are compiled.

use super::DECLARED;
use super::question::Freedom;

/// A kind as files know it.
#[derive(Debug, Clone, Copy)]
pub struct Declared {
    /// Its name.
    pub name: &'static str,
    /// What it does between a body and its parent.
    pub doc: &'static str,
    /// What it does in a loop that it closes; `None` if it closes nothing.
    pub closes: Option<&'static str>,
    /// How many axes it is given.
    pub axes: usize,
    /// How many velocities it has.
    pub velocities: usize,
}

/// Some of the kinds, in the order of their list.
#[derive(Debug, Clone, Copy)]
pub enum Which {
    /// Kinds with at least one coordinate.
    Moving,
    /// Kinds that close loops.
    Closing,
    /// Kinds that are given so many axes.
    Axes(usize),
}

impl Declared {
    pub(super) const fn of<F: Freedom>() -> Self {
        Self { name: F::NAME, doc: F::DOC, closes: F::CLOSES, axes: F::AXES, velocities: F::VELOCITIES.len() }
    }

    /// Whether this is one of them.
    pub const fn is(&self, which: Which) -> bool {
        match which {
            Which::Moving => self.velocities > 0,
            Which::Closing => self.closes.is_some(),
            Which::Axes(count) => self.axes == count,
        }
    }
}

/// How many they are.
pub const fn count(which: Which) -> usize {
    let (mut found, mut at) = (0, 0);
    while at < DECLARED.len() {
        if DECLARED[at].is(which) {
            found += 1;
        }
        at += 1;
    }
    found
}

/// Their names; `N` is their [`count`].
pub const fn names<const N: usize>(which: Which) -> [&'static str; N] {
    let (mut names, mut found, mut at) = ([""; N], 0, 0);
    while at < DECLARED.len() {
        if DECLARED[at].is(which) {
            names[found] = DECLARED[at].name;
            found += 1;
        }
        at += 1;
    }
    names
}
