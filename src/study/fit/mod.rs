//! Fits: numbers of a scene that bring its answers closest to measurements, and how well these determine them.
//!
//! ```text
//! (1)  r_i(x) = (y_i(x) − measured_i) / σ_i,     Σ r_i² → least over x, low ≤ x ≤ high
//! (2)  ∂y/∂x: sensitivities of the equilibrium (`statics::sensitivities`) where it has them, else central differences
//! ```
//!
//! `σ` is the deviation of a column: as given, else the spread of what was measured in it, so that columns of different units count
//! alike. Rows whose numbers were set alike share one equilibrium, or one run.
//!
//! | file | its one job |
//! |---|---|
//! | [`table`] | measured columns, in SI units |
//! | `roles` | what a column is: the time, a number that was set, something measured |
//! | `scenes` | the scene of a row |
//! | `observe` | what it answers, and the derivatives of that |
//! | `problem` | residuals of all rows, and their Jacobian |
//! | `residuals` | what a search asks for, and where it has ended |
//! | `marquardt` | least squares within bounds |
//! | `runaway` | whether they have a minimum where the search ends |
//! | `notes` | what a person should know of the result |
//! | `confidence` | covariance, intervals, and what is not determined |

mod confidence;
mod marquardt;
mod notes;
mod observe;
mod problem;
mod residuals;
mod roles;
mod runaway;
mod scenes;
pub mod table;

use crate::model::{Model, Parameter};
use crate::quantity::Quantity;
use crate::scenario::{Diagnostics, Override, Scenario};
use confidence::Confidence;
use marquardt::least_squares;
use problem::Problem;
use residuals::{Minimum, Stop};
use roles::Roles;
use table::MeasuredTable;

/// Singular values of the Jacobian below this part of the largest are zero: by exact derivatives, and by differences.
const RANK: [f64; 2] = [1e-8, 1e-5];

/// A number that is fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Adjusted {
    /// As after `--set`.
    pub address: String,
    /// Where the search begins, in SI units; `None` for its value in the scenario.
    pub start: Option<f64>,
    /// Its least and largest value, in SI units; infinite for none.
    pub range: [f64; 2],
}

impl Adjusted {
    /// Reads `address`, `address=start`, `address=low..high` or `address=start,low..high`; either end may be left out, and
    /// numbers may have units.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(text: &str) -> Result<Self, String> {
        let (address, written) = text.split_once('=').unwrap_or((text, ""));
        let address = address.trim().to_owned();
        if address.is_empty() {
            return Err(
                "write an address, as `spring.length`, `spring.length=0.5` or `spring.length=0.5,0.1..1`".to_owned()
            );
        }
        let mut adjusted = Self { address, start: None, range: [f64::NEG_INFINITY, f64::INFINITY] };
        let number = |text: &str| {
            let found = Quantity::parse(text.trim()).map_err(|why| format!("`{}`: {why}", text.trim()))?;
            if found.value.is_finite() {
                Ok(found.value)
            } else {
                Err(format!("`{}` is not a finite number", text.trim()))
            }
        };
        for part in written.split(',').filter(|part| !part.trim().is_empty()) {
            if let Some((low, high)) = part.split_once("..") {
                for (end, text) in adjusted.range.iter_mut().zip([low, high]) {
                    if !text.trim().is_empty() {
                        *end = number(text)?;
                    }
                }
            } else {
                adjusted.start = Some(number(part)?);
            }
        }
        adjusted.check()?;
        Ok(adjusted)
    }

    fn check(&self) -> Result<(), String> {
        let [low, high] = self.range;
        if !(low < high) {
            return Err(format!("`{}`: the range {low}..{high} is empty", self.address));
        }
        match self.start {
            Some(start) if !(low..=high).contains(&start) => {
                Err(format!("`{}`: the start {start} is not within {low}..{high}", self.address))
            }
            _ => Ok(()),
        }
    }
}

/// Reads `column=deviation`: a measured column and its standard deviation, in SI units or with a unit.
///
/// # Errors
/// What is wrong with it.
pub fn deviation(text: &str) -> Result<(String, f64), String> {
    let wrong = || "write a column and its deviation, as `travel=0.2e-3` or `travel=0.2 mm`".to_owned();
    let (name, value) = text.rsplit_once('=').ok_or_else(wrong)?;
    let value = Quantity::parse(value.trim()).map_err(|_| wrong())?.value;
    match value > 0.0 && value.is_finite() {
        true => Ok((name.trim().to_owned(), value)),
        false => Err(format!("a deviation is a finite number > 0, not {value}")),
    }
}

/// What is asked of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FitQuestion {
    /// The numbers that are fitted.
    pub parameters: Vec<Adjusted>,
    /// Measurements are of a run, at the times of the column `time`; else of the equilibrium.
    pub run: bool,
    /// Standard deviations of measured columns (SI units); only their ratios move the parameters.
    pub deviations: Vec<(String, f64)>,
    /// Columns that are left out.
    pub ignored: Vec<String>,
    /// Probability of the intervals, above 0 and below 1.
    pub level: f64,
}

/// Why there is no fit.
#[derive(Debug, thiserror::Error)]
pub enum Trouble {
    /// Numbers that make no scene.
    #[error("{}", .0.summary())]
    Problems(Diagnostics),
    /// A column of the data, or all of it.
    #[error("{0}")]
    Data(String),
    /// Data, parameters or scene do not fit together.
    #[error("{0}")]
    Wrong(String),
    /// The caller ended it.
    #[error("interrupted")]
    Interrupted,
}

/// A parameter where the sum of squares is least.
#[derive(Debug, Clone, PartialEq)]
pub struct Fitted {
    /// As after `--set`.
    pub address: String,
    /// SI unit; empty where that is not said.
    pub unit: &'static str,
    /// Where the search began.
    pub start: f64,
    /// The fitted value.
    pub value: f64,
    /// Standard error; `None` at a bound, or where the data does not determine it.
    pub error: Option<f64>,
    /// Its interval of confidence.
    pub interval: Option<[f64; 2]>,
    /// It is held by a bound.
    pub is_held: bool,
    /// The sum of squares has no minimum along it: the value is where the search gave up.
    pub runs_off: bool,
}

/// A measured column.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnFit {
    /// As in the heading.
    pub name: String,
    /// SI unit.
    pub unit: String,
    /// Numbers that were measured.
    pub count: usize,
    /// Root of the mean square of what is left.
    pub rms: f64,
    /// What residuals were divided by: as given, or the spread of what was measured.
    pub deviation: f64,
    /// Row by row, the scene less what was measured; `None` where nothing was.
    pub left: Vec<Option<f64>>,
}

/// What a fit has found.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The parameters, in the order of the question.
    pub parameters: Vec<Fitted>,
    /// The measured columns.
    pub columns: Vec<ColumnFit>,
    /// Covariances of the parameters, row by row; `NaN` of those that have no standard error.
    pub covariance: Vec<Vec<f64>>,
    /// Measurements less parameters that they determine.
    pub freedom: usize,
    /// Combinations of parameters that change nothing that was measured: address and part, the first of them 1.
    pub together: Vec<Vec<(String, f64)>>,
    /// Parameters that nothing measured follows from where the search has ended.
    pub unfelt: Vec<String>,
    /// Whether it is a minimum.
    pub converged: bool,
    /// Steps of the search.
    pub steps: usize,
    /// Equilibria or runs that were computed.
    pub evaluations: usize,
    /// Parameters whose derivatives are differences.
    pub by_differences: Vec<String>,
    /// What a person should know.
    pub notes: Vec<String>,
}

impl Fit {
    /// Correlation of two parameters; `None` where one has no standard error.
    pub fn correlation(&self, i: usize, j: usize) -> Option<f64> {
        let of = |i: usize, j: usize| self.covariance[i][j];
        Some(of(i, j) / (of(i, i) * of(j, j)).sqrt()).filter(|x| x.is_finite())
    }
}

/// Fits parameters of a scenario to a table. `set` are changes with which it has been read; `go_on` ends it by `false`.
///
/// # Errors
/// See [`Trouble`].
pub fn fit(
    scenario: &Scenario,
    set: &[Override],
    table: &MeasuredTable,
    question: &FitQuestion,
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Fit, Trouble> {
    if question.parameters.is_empty() {
        return Err(Trouble::Wrong("no parameter is to be fitted".to_owned()));
    }
    if !(question.level > 0.0 && question.level < 1.0) {
        return Err(Trouble::Wrong(format!("the confidence {} is not between 0 and 1", question.level)));
    }
    let model = Model::build(&scenario.description)
        .map_err(|problems| Trouble::Wrong(problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")))?;
    let roles = Roles::of(table, (scenario, set), &model, question)?;
    let start = question.parameters.iter().map(|one| started(one, scenario, set)).collect::<Result<Vec<f64>, _>>()?;
    for (index, one) in question.parameters.iter().enumerate() {
        let is_set = |place: &&usize| table.columns[**place].name == one.address;
        if roles.settings.iter().any(|place| is_set(&place)) {
            return Err(Trouble::Wrong(format!("`{}` is a column of the data and a parameter at once", one.address)));
        }
        if question.parameters[..index].iter().any(|other| other.address == one.address) {
            return Err(Trouble::Wrong(format!("`{}` is a parameter twice", one.address)));
        }
    }
    refuse_overlaps((scenario, set), table, &roles, question)?;
    let mut problem = Problem::new((scenario, set), table, question, &roles, &start, go_on)?;
    let ends = [0, 1].map(|end| question.parameters.iter().map(|one| one.range[end]).collect::<Vec<f64>>());
    let found = least_squares(&mut problem, &start, (&ends[0], &ends[1])).map_err(|stop| match stop {
        Stop::Interrupted => Trouble::Interrupted,
        Stop::No(why) => Trouble::Wrong(format!("at the start of the search: {why}")),
    })?;
    Ok(told(&found, &problem, &start, (scenario, question), table))
}

/// What the search has found, in words and numbers.
fn told(
    found: &Minimum,
    problem: &Problem<'_>,
    start: &[f64],
    (scenario, question): (&Scenario, &FitQuestion),
    table: &MeasuredTable,
) -> Fit {
    let count = start.len();
    let falls = |j: usize| found.falls.iter().any(|(falling, _)| *falling == j);
    let free: Vec<usize> = (0..count).filter(|j| !found.held[*j] && !falls(*j)).collect();
    let rank = RANK[usize::from(problem.by_differences.iter().any(|by| *by))];
    let confidence = Confidence::of(&found.jacobian, &found.residuals, &free, rank, question.level);
    let address = |j: usize| question.parameters[j].address.clone();
    let fitted = |j: usize| {
        let error = confidence.error(j);
        let half = error.map(|error| confidence.quantile * error);
        Fitted {
            address: address(j),
            unit: unit(&question.parameters[j].address, scenario),
            start: start[j],
            value: found.x[j],
            error,
            interval: half.map(|half| [found.x[j] - half, found.x[j] + half]),
            is_held: found.held[j],
            runs_off: falls(j),
        }
    };
    let mut fit = Fit {
        parameters: (0..count).map(fitted).collect(),
        columns: problem.columns(&found.residuals),
        covariance: (0..count).map(|i| (0..count).map(|j| confidence.covariance[(i, j)]).collect()).collect(),
        freedom: confidence.freedom,
        together: confidence
            .together
            .iter()
            .map(|direction| direction.iter().map(|(j, part)| (address(*j), *part)).collect())
            .collect(),
        unfelt: confidence.unfelt.iter().map(|j| address(*j)).collect(),
        converged: found.converged,
        steps: found.steps,
        evaluations: problem.evaluations,
        by_differences: (0..count).filter(|j| problem.by_differences[*j]).map(address).collect(),
        notes: Vec::new(),
    };
    fit.notes = notes::of(&fit, found, table, problem.weighted_by_spread());
    fit
}

/// Refuses addresses of which one would undo what another sets: derivatives and errors would be those of another scene.
fn refuse_overlaps(
    (scenario, set): (&Scenario, &[Override]),
    table: &MeasuredTable,
    roles: &Roles,
    question: &FitQuestion,
) -> Result<(), Trouble> {
    let settings = roles.settings.iter().map(|place| table.columns[*place].name.as_str());
    let paths: Vec<&str> = settings.chain(question.parameters.iter().map(|one| one.address.as_str())).collect();
    let Some((first, later, shared)) = scenario.overlap(set, &paths) else { return Ok(()) };
    let shown = |index: usize| match index < roles.settings.len() {
        true => format!("the column `{}`", paths[index]),
        false => format!("the parameter `{}`", paths[index]),
    };
    Err(Trouble::Wrong(format!(
        "{} and {} both set {shared}: the one would overwrite the other; take only one of them, or what they do not share",
        shown(first),
        shown(later)
    )))
}

/// Where the search begins.
fn started(one: &Adjusted, scenario: &Scenario, set: &[Override]) -> Result<f64, Trouble> {
    one.check().map_err(Trouble::Wrong)?;
    if let Some(start) = one.start {
        return Ok(start);
    }
    let start = match Parameter::find(&scenario.description, &one.address) {
        Ok(found) => found[0].value(&scenario.description),
        Err(_) if scenario.has_key(set, &one.address) => {
            return Err(Trouble::Wrong(format!(
                "`{}` is a number that only reading the file sets: say where it starts, `{}=…`",
                one.address, one.address
            )));
        }
        Err(unknown) => {
            return Err(Trouble::Wrong(match unknown.help {
                Some(near) => format!("{}; {near}", unknown.message),
                None => unknown.message,
            }));
        }
    };
    let [low, high] = one.range;
    match (low..=high).contains(&start) {
        true => Ok(start),
        false => Err(Trouble::Wrong(format!("`{}` is {start} in the scenario, not within {low}..{high}", one.address))),
    }
}

fn unit(address: &str, scenario: &Scenario) -> &'static str {
    Parameter::find(&scenario.description, address).map_or("", |found| found[0].quantity.unit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_are_read_with_start_and_range() {
        let of = |text: &str| Adjusted::parse(text).expect(text);
        let free = [f64::NEG_INFINITY, f64::INFINITY];
        assert_eq!(of("a.mass"), Adjusted { address: "a.mass".into(), start: None, range: free });
        assert_eq!(of("a.mass=2").start, Some(2.0));
        assert_eq!(of("a.rest = 45 deg").start, Some(std::f64::consts::FRAC_PI_4));
        assert_eq!(of("s.length=300 mm,0.1..1").range, [0.1, 1.0]);
        assert_eq!(of("s.length=0..").range, [0.0, f64::INFINITY]);
        for wrong in ["", "a=3,0..1", "a=1..0", "a=x"] {
            assert!(Adjusted::parse(wrong).is_err(), "{wrong}");
        }
    }
}
