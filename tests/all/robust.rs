//! Input that nobody meant to write: every answer is an error or a result, never a panic, and never wrong numbers.
//!
//! A thousand cases of each kind with a fixed seed belong to the tests; `ROBUST_CASES=100000` looks longer, with another seed each
//! time.

mod budgets;
mod meshes;
mod recordings;
mod scenarios;

use crate::common::robust_cases;
use proptest::strategy::Strategy;
use proptest::test_runner::{Config, RngAlgorithm, TestCaseResult, TestRng, TestRunner};

/// Tries a property on generated values and shrinks what breaks it.
fn each<S: Strategy>(cases: u32, strategy: S, property: impl Fn(S::Value) -> TestCaseResult) {
    let longer = robust_cases();
    let config = Config { cases: longer.unwrap_or(cases), failure_persistence: None, ..Config::default() };
    let mut runner = match longer {
        Some(_) => TestRunner::new(config),
        None => TestRunner::new_with_rng(config, TestRng::deterministic_rng(RngAlgorithm::ChaCha)),
    };
    if let Err(error) = runner.run(&strategy, property) {
        panic!("{error}");
    }
}

/// One change of a text or of a file.
#[derive(Debug, Clone)]
enum Edit {
    /// Takes a stretch out.
    Remove { at: usize, length: usize },
    /// Puts a stretch in once more, somewhere else.
    Copy { from: usize, length: usize, to: usize },
    /// Puts something in.
    Insert { at: usize, what: Vec<u8> },
    /// Puts something in the place of what is there.
    Replace { at: usize, what: Vec<u8> },
    /// Turns one bit around.
    Flip { at: usize, bit: u8 },
    /// Ends it here.
    Cut { at: usize },
}

impl Edit {
    fn apply(&self, bytes: &mut Vec<u8>) {
        let place = |at: usize| at % (bytes.len() + 1);
        match self {
            Self::Remove { at, length } => {
                let at = place(*at);
                bytes.drain(at..(at + length).min(bytes.len()));
            }
            Self::Copy { from, length, to } => {
                let (from, to) = (place(*from), place(*to));
                let stretch = bytes[from..(from + length).min(bytes.len())].to_vec();
                bytes.splice(to..to, stretch);
            }
            Self::Insert { at, what } => {
                let at = place(*at);
                bytes.splice(at..at, what.iter().copied());
            }
            Self::Replace { at, what } => {
                let at = place(*at);
                let end = (at + what.len()).min(bytes.len());
                bytes.splice(at..end, what.iter().copied());
            }
            Self::Flip { at, bit } => {
                let at = place(*at);
                if let Some(byte) = bytes.get_mut(at) {
                    *byte ^= 1 << bit;
                }
            }
            Self::Cut { at } => bytes.truncate(place(*at)),
        }
    }
}

/// A few changes with stretches of up to `longest` bytes; what is put in comes from `words`.
fn edits(longest: usize, words: &'static [&'static [u8]]) -> impl Strategy<Value = Vec<Edit>> {
    use proptest::prelude::*;
    let at = || any::<usize>();
    let word = || prop_oneof![3 => proptest::sample::select(words).prop_map(<[u8]>::to_vec), 1 => proptest::collection::vec(any::<u8>(), 1..9)];
    let edit = prop_oneof![
        1 => (at(), 1..longest).prop_map(|(at, length)| Edit::Remove { at, length }),
        1 => (at(), 1..longest, at()).prop_map(|(from, length, to)| Edit::Copy { from, length, to }),
        3 => (at(), word()).prop_map(|(at, what)| Edit::Insert { at, what }),
        3 => (at(), word()).prop_map(|(at, what)| Edit::Replace { at, what }),
        2 => (at(), 0..8_u8).prop_map(|(at, bit)| Edit::Flip { at, bit }),
        1 => (at(),).prop_map(|(at,)| Edit::Cut { at }),
    ];
    proptest::collection::vec(edit, 1..6)
}
