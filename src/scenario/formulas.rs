//! Texts of formulas in variables of their own, with `[parameters]` put in.

use super::findings::Finding;
use super::quantities::Parameters;
use super::reader::Reader;
use crate::formula::{Formula, FormulaError};
use std::ops::Range;

/// The text of a formula in these variables, with numbers in place of parameters; what is wrong with it is said at its
/// place.
pub(super) fn formula(table: &Reader<'_>, owner: &str, variables: &[&str], parameters: &Parameters) -> Option<String> {
    const KEY: &str = "expression";
    let text = table.text(KEY)?;
    Some(put_into(table, (KEY, text), owner, variables, parameters))
}

/// As [`formula`], of the text under a key.
pub(super) fn put_into(
    table: &Reader<'_>,
    (key, text): (&'static str, &str),
    owner: &str,
    variables: &[&str],
    parameters: &Parameters,
) -> String {
    let names: Vec<&str> = variables.iter().copied().chain(parameters.names()).collect();
    let error = match (Formula::parse(text, &names), parameters.ambiguous(text, variables)) {
        (Ok(_), None) => return parameters.put_into(text, variables),
        (Ok(_), Some(both)) => ambiguous(both),
        (Err(error), _) => error,
    };
    let finding = Finding::error(table.span_of(key), format!("{owner}: {}", error.message));
    table.findings.push_value(finding.within(error.span).maybe_help(error.help));
    // Stands in for it, so that nothing else is found wrong because of it.
    "0".to_owned()
}

/// A name that stands for two things.
pub(super) fn ambiguous((name, span): (String, Range<usize>)) -> FormulaError {
    let message = format!("`{name}` is a variable of this formula and a number of `[parameters]`");
    FormulaError { span, message, help: Some("give the parameter another name".to_owned()) }
}
