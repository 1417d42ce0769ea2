//! What a person should know of a fit beside its numbers.

use super::residuals::{Minimum, Way};
use super::table::MeasuredTable;
use super::{ColumnFit, Fit};
use crate::model::problem::{number, significant};

/// Parameters that are correlated by more than this are told.
const CLOSE: f64 = 0.99;

/// All of them; `by_spread` if a column counts by the spread of what was measured.
pub(super) fn of(fit: &Fit, found: &Minimum, table: &MeasuredTable, by_spread: bool) -> Vec<String> {
    let mut notes = falling(fit, found);
    if !fit.converged && notes.is_empty() {
        let why = found.refused.as_ref().map(|why| format!("; where it would have gone on there is no answer: {why}"));
        let why = why.unwrap_or_default();
        notes.push(format!("the search has not converged: other starts or ranges may help{why}"));
    }
    for one in fit.parameters.iter().filter(|one| fit.unfelt.contains(&one.address)) {
        let name = &one.address;
        notes.push(match one.value == one.start {
            true => format!("nothing measured follows from `{name}`: it stays where it was"),
            false => format!("nothing measured follows from `{name}` any more where the search has ended"),
        });
    }
    for direction in &fit.together {
        notes.push(format!("the data does not determine these alone; nothing changes along {}", sum(direction)));
    }
    for one in fit.parameters.iter().filter(|one| one.is_held) {
        notes.push(format!("`{}` is held at the end of its range: intervals are those of the others", one.address));
    }
    if fit.freedom == 0 {
        notes.push("as many measurements as parameters: there are no standard errors".to_owned());
    }
    for i in 0..fit.parameters.len() {
        for j in i + 1..fit.parameters.len() {
            if let Some(correlation) = fit.correlation(i, j).filter(|x| x.abs() > CLOSE) {
                let [a, b] = [i, j].map(|at| &fit.parameters[at].address);
                notes.push(format!(
                    "`{a}` and `{b}` are correlated by {}: the data determines mostly one combination",
                    number(correlation)
                ));
            }
        }
    }
    notes.extend(fit.columns.iter().filter_map(|column| empty(column, table)));
    if by_spread && fit.columns.len() > 1 {
        notes.push(
            "columns count by the spread of what was measured: say their deviations if they are known".to_owned(),
        );
    }
    notes
}

/// A combination of parameters: `1 a - 0.2 b`, with their names in quotes.
fn sum(direction: &[(String, f64)]) -> String {
    let mut text = String::new();
    for (name, part) in direction {
        let sign = match (text.is_empty(), *part < 0.0) {
            (true, false) => "",
            (true, true) => "-",
            (false, false) => " + ",
            (false, true) => " - ",
        };
        text += &format!("{sign}{} `{name}`", significant(part.abs(), 4));
    }
    text
}

/// The parameters along which the sum of squares has no minimum.
fn falling(fit: &Fit, found: &Minimum) -> Vec<String> {
    let name = |j: usize| format!("`{}`", fit.parameters[j].address);
    let of_one = |(j, way): &(usize, Way)| {
        let name = name(*j);
        let until = match way {
            Way::Up => "it falls all the way to +∞",
            Way::Down => "it falls all the way to −∞",
            Way::Zero => "it falls all the way to zero, where there is no answer",
            Way::Together => return None,
        };
        Some(format!("{name} runs off: the sum of squares has no minimum along it, {until}"))
    };
    let mut notes: Vec<String> = found.falls.iter().filter_map(of_one).collect();
    let together: Vec<String> =
        found.falls.iter().filter(|(_, way)| *way == Way::Together).map(|(j, _)| name(*j)).collect();
    if let [some @ .., last] = &together[..] {
        notes.push(format!(
            "{} and {last} run off together: the sum of squares has no minimum along them, it falls all the way",
            some.join(", ")
        ));
    }
    if !notes.is_empty() {
        notes.push(
            "where such a parameter stands says nothing; a range (`ADDRESS=START,LOW..HIGH`) keeps it, or leave it out"
                .to_owned(),
        );
    }
    notes
}

/// How many cells of a measured column have no number.
fn empty(column: &ColumnFit, table: &MeasuredTable) -> Option<String> {
    let empty = table.rows() - column.count;
    let (which, are) = if empty == 1 { ("cell", "is") } else { ("cells", "are") };
    let name = &column.name;
    (empty > 0).then(|| format!("{empty} {which} of `{name}` {are} empty or `nan`: nothing was measured there"))
}

#[cfg(test)]
mod tests {
    use super::sum;

    #[test]
    fn combinations_are_sums() {
        let parts = [("a", 1.0), ("b", -0.2), ("c", 2.5e-9)].map(|(name, part)| (name.to_owned(), part));
        assert_eq!(sum(&parts), "1 `a` - 0.2 `b` + 2.5e-9 `c`");
    }
}
