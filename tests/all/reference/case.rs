//! The files of `tests/reference`: parameters, initial state, expected numbers and tolerances of one case each.

use serde_json::Value;
use std::path::Path;

/// A part of a case, and where it stands for messages.
#[derive(Clone)]
pub(crate) struct Node {
    value: Value,
    place: String,
}

/// The whole case `id`, the name of its file without `.json`.
pub(crate) fn case(id: &str) -> Node {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference").join(format!("{id}.json"));
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    Node { value, place: id.to_owned() }
}

impl Node {
    pub(crate) fn at(&self, key: &str) -> Self {
        let value = self.value.get(key).unwrap_or_else(|| panic!("{} has no `{key}`", self.place));
        Self { value: value.clone(), place: format!("{} {key}", self.place) }
    }

    pub(crate) fn parameter(&self, key: &str) -> f64 {
        self.at("parameters").at(key).number()
    }

    pub(crate) fn initial(&self, key: &str) -> f64 {
        self.at("initial_state").at(key).number()
    }

    pub(crate) fn tolerance(&self, key: &str) -> f64 {
        self.at("tolerance").at(key).number()
    }

    /// A number: plain, in a string, or a reference number, of which the decimals count.
    pub(crate) fn number(&self) -> f64 {
        let text = self.value.get("decimal").unwrap_or(&self.value);
        let number = text.as_f64().or_else(|| text.as_str()?.parse().ok());
        number.unwrap_or_else(|| panic!("{} is no number: {}", self.place, self.value))
    }

    /// The elements of a list.
    pub(crate) fn items(&self) -> Vec<Self> {
        let list = self.value.as_array().unwrap_or_else(|| panic!("{} is no list", self.place));
        let item = |(i, value): (usize, &Value)| Self { value: value.clone(), place: format!("{}[{i}]", self.place) };
        list.iter().enumerate().map(item).collect()
    }

    pub(crate) fn numbers(&self) -> Vec<f64> {
        self.items().iter().map(Self::number).collect()
    }

    /// Exactly `N` numbers.
    pub(crate) fn array<const N: usize>(&self) -> [f64; N] {
        let numbers = self.numbers();
        numbers.try_into().unwrap_or_else(|list: Vec<f64>| panic!("{} has {} numbers", self.place, list.len()))
    }

    pub(crate) fn keys(&self) -> Vec<String> {
        let table = self.value.as_object().unwrap_or_else(|| panic!("{} is no table", self.place));
        table.keys().cloned().collect()
    }

    /// The states of the reference, `t=…`, in order of time.
    pub(crate) fn states(&self) -> Vec<(f64, Self)> {
        self.at("reference").at_times()
    }

    /// What is told of times, `t=…`, in their order.
    pub(crate) fn at_times(&self) -> Vec<(f64, Self)> {
        let time = |key: &String| Some((key.strip_prefix("t=")?.parse().ok()?, self.at(key)));
        let mut states: Vec<(f64, Self)> = self.keys().iter().filter_map(time).collect();
        states.sort_by(|a, b| a.0.total_cmp(&b.0));
        states
    }

    /// Asserts that `found` is this number within `tolerance`, and prints the error that was reached.
    #[track_caller]
    pub(crate) fn check(&self, found: f64, tolerance: f64) {
        self.check_against(found, self.number(), tolerance);
    }

    /// As [`Node::check`] with the tolerance relative to the number.
    #[track_caller]
    pub(crate) fn check_relative(&self, found: f64, tolerance: f64) {
        let expected = self.number();
        self.check_against(found, expected, tolerance * expected.abs());
    }

    /// As [`Node::check`], number by number.
    #[track_caller]
    pub(crate) fn check_list(&self, found: &[f64], tolerance: f64) {
        let items = self.items();
        assert_eq!(items.len(), found.len(), "{}", self.place);
        for (item, found) in items.iter().zip(found) {
            item.check(*found, tolerance);
        }
    }

    /// As [`Node::check`] against a number that follows from this one.
    #[track_caller]
    pub(crate) fn check_against(&self, found: f64, expected: f64, tolerance: f64) {
        let error = (found - expected).abs();
        println!("{}: error {error:.1e}, allowed {tolerance:.1e}", self.place);
        assert!(
            error <= tolerance,
            "{}: found {found:e}, expected {expected:e}, off by {error:.3e} > {tolerance:.1e}",
            self.place
        );
    }
}
