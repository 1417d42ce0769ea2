//! What the TOML parser says, in words for people who do not know its grammar.

use super::fields::Kind;
use super::findings::{Finding, Findings};
use super::format::SCENARIO;
use super::sources::Sources;
use crate::import::is_model;
use std::collections::HashSet;
use toml::de::DeTable;

/// Parses a text. If it is not TOML, all errors that were found are in `findings`.
pub(super) fn parse<'t>(text: &'t str, sources: &Sources<'_>, findings: &Findings) -> DeTable<'t> {
    if is_model(text) {
        let finding = Finding::error(0..0, "this is XML, and a scenario is TOML".to_owned());
        findings
            .push(finding.help("a URDF or MJCF model is taken by its file, or with `model = \"FILE\"` in a scenario"));
        return DeTable::new();
    }
    let (document, errors) = DeTable::parse_recoverable(text);
    let mut said = HashSet::new();
    // If the nesting is too deep, what follows is not worth saying.
    let deep = errors.iter().position(|error| is_depth(error.message()));
    for error in errors.iter().take(deep.map_or(errors.len(), |deep| deep + 1)) {
        // Every open bracket complains about the same missing end.
        if !said.insert((error.message(), error.span())) {
            continue;
        }
        let Some(span) = error.span() else {
            findings.push(Finding::without_place(readable(error.message())));
            continue;
        };
        let finding = if error.message() == "duplicate key" {
            let key = sources.text(&span);
            let help = match text[..span.start].ends_with('[') && is_list(key) {
                true => {
                    format!("`[{key}]` is the only one, `[[{key}]]` one of several: write `[[{key}]]` in both places")
                }
                false => "keep one of the two".to_owned(),
            };
            Finding::error(span, format!("`{key}` is given twice")).help(help)
        } else {
            Finding::error(span, readable(error.message()))
        };
        findings.push(finding);
    }
    document.into_inner()
}

/// Whether a key of a scenario holds a list of tables.
fn is_list(key: &str) -> bool {
    SCENARIO.declarations(key).any(|key| matches!(key.kind, Kind::List(of, _) if matches!(of, Kind::Table(_))))
}

fn readable(message: &str) -> String {
    if is_depth(message) {
        "values are nested too deeply: the most is 80 levels".to_owned()
    } else {
        format!("not valid TOML: {}", message.trim_end_matches(", expected nothing"))
    }
}

/// Whether the parser stopped to keep its stack.
fn is_depth(message: &str) -> bool {
    message.contains("recursion") || message.contains("recurse")
}
