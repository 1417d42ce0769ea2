//! One case after the other: from the number of a case to its row.

use super::answer::{self, Answer, Question};
use super::axis;
use super::clash;
use super::column::{Cell, Column, Kind};
use super::plan::{Plan, Value, texts};
use crate::constraint;
use crate::foreign;
use crate::model::parameter::Field;
use crate::model::{Description, Model, Parameter, Problem};
use crate::scenario::{Diagnostics, Override, Scenario, locate};
use crate::simulate::outputs::OutputRanges;
use crate::simulate::{self, State, Summary};
use crate::statics::{self, Equilibrium};
use std::borrow::Cow;
use std::collections::HashSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// The option that varies by a distribution, as messages name it.
pub const VARY: &str = "--vary";

/// All cases of a plan, and how each is answered.
#[derive(Debug)]
pub struct Cases {
    pub(super) scenario: Scenario,
    pub(super) set: Vec<Override>,
    /// Which cases there are.
    pub plan: Plan,
    /// What is asked of each.
    pub question: Question,
    columns: Vec<Column>,
    pub(super) direct: Option<Direct>,
    /// Whether cases are computed side by side.
    pub(super) together: bool,
}

/// A plan that sets plain numbers of the scene alone: its scenes need no reading.
#[derive(Debug)]
pub(super) struct Direct {
    /// A scene of the plan.
    pub(super) scenario: Scenario,
    /// What each path sets.
    numbers: Vec<Vec<Parameter>>,
}

/// Why there is nothing to ask.
#[derive(Debug, thiserror::Error)]
pub enum Refusal {
    /// No case makes a scene.
    #[error(transparent)]
    Problems(#[from] Diagnostics),
    /// The plan contradicts itself.
    #[error("{0}")]
    Plan(String),
}

/// One row: as many cells as there are [columns](Cases::columns).
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// The number of the case.
    pub case: u64,
    /// Why there is no answer.
    pub error: Option<String>,
    /// What stands in the columns.
    pub cells: Vec<Cell>,
}

/// A case before its run: its scene, where it starts, and its equilibrium if that is asked for.
pub(super) struct Begun {
    pub(super) model: Arc<Model>,
    pub(super) start: State,
    found: Option<Equilibrium>,
}

/// Why a case has no answer.
pub(super) enum Failure {
    /// The reason, and what there is all the same.
    No(String, Option<Vec<Cell>>),
    /// The caller ended it.
    Interrupted,
}

/// Columns before those of the plan.
const BEFORE: usize = 1;

impl Cases {
    /// The cases of a plan. `set` are changes that all of them have; `scenario` has been read with them.
    ///
    /// # Errors
    /// If an address is not there or no value fits there, or if two columns would have one name.
    pub fn new(scenario: Scenario, set: Vec<Override>, plan: Plan, question: Question) -> Result<Self, Refusal> {
        let mut cases = Self { scenario, set, plan, question, columns: Vec::new(), direct: None, together: false };
        let scenes = cases.scenes()?;
        let mut columns = vec![Column::new("case", Kind::Whole, "")];
        for (path, number) in cases.plan.paths().zip(cases.plan.are_numbers()) {
            columns.push(match number {
                true => Column::new(path, Kind::Number, cases.scenario.unit(&cases.set, path)),
                false => Column::new(path, Kind::Word, ""),
            });
        }
        columns.extend([Column::new("ok", Kind::Flag, ""), Column::new("error", Kind::Word, "")]);
        let last = Column::new("wall_seconds", Kind::Number, "s");
        let inputs = columns.len();
        let beside: Vec<Column> = columns.iter().chain([&last]).cloned().collect();
        for (scenario, set) in &scenes {
            let Ok(model) = Model::build(&scenario.description) else { continue };
            let clashes = clash::clashes(scenario, &model, &cases.question, &beside);
            if !clashes.is_empty() {
                return Err(Refusal::Problems(locate(scenario, set, clashes)));
            }
            let own = answer::columns(scenario, &model, &cases.question);
            let all: Vec<Column> = beside.iter().chain(&own).cloned().collect();
            if let Some(twice) = twice(&all) {
                let problems = clash::twice(&model, &twice.name);
                return Err(match problems.is_empty() {
                    true => refused(twice),
                    false => Refusal::Problems(locate(scenario, set, problems)),
                });
            }
            for column in own {
                if !columns[inputs..].iter().any(|other| other.name == column.name) {
                    columns.push(column);
                }
            }
        }
        columns.push(last);
        if let Some(twice) = twice(&columns) {
            return Err(refused(twice));
        }
        cases.columns = columns;
        cases.direct = cases.directly();
        cases.together = cases.may_go_together();
        Ok(cases)
    }

    /// How to make the scenes without reading them, if all that is varied are plain numbers of the scene, and scenes that are
    /// read are the same as scenes whose numbers are set, in the middle and at both ends of the plan.
    fn directly(&self) -> Option<Direct> {
        let find = |path: &str| Parameter::find(&self.scenario.description, path).ok();
        let numbers = self.plan.paths().map(find).collect::<Option<Vec<_>>>()?;
        // What named numbers mean is known to who reads them.
        if numbers.iter().flatten().any(|one| one.field == Field::Named)
            || self.plan.are_numbers().any(|number| !number)
        {
            return None;
        }
        let mut found: Option<Direct> = None;
        for (last, u) in [(false, 0.5), (false, 0.1), (true, 0.9)] {
            let values = self.plan.probe(last, u);
            let Ok(read) = self.read(&texts(&values)) else {
                // No scene when it is read: none when it is set, either.
                let set = Direct { scenario: self.scenario.clone(), numbers: numbers.clone() };
                match set.description(&values).is_some_and(|set| Model::build(&set).is_err()) {
                    true => continue,
                    false => return None,
                }
            };
            let direct = found.get_or_insert_with(|| Direct { scenario: read.clone(), numbers: numbers.clone() });
            if direct.description(&values)? != read.description || !is_alike(&direct.scenario, &read) {
                return None;
            }
        }
        found
    }

    /// The columns of every row, in order.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The row of a case; `None` if `go_on` ended it.
    pub fn row(&self, case: u64, go_on: &(dyn Fn() -> bool + Sync)) -> Option<Row> {
        self.row_by(case, |values| self.solve(values, go_on))
    }

    fn row_by(&self, case: u64, solve: impl FnOnce(&[Value<'_>]) -> Result<Vec<Cell>, Failure>) -> Option<Row> {
        let started = Instant::now();
        let values = self.plan.values(case);
        let outcome = foreign::caught(|| solve(&values))
            .unwrap_or_else(|message| Err(Failure::No(format!("the case ended in a panic: {message}"), None)));
        self.row_of(case, values, outcome, started.elapsed())
    }

    /// The row of an outcome that took so long; `None` if the caller ended it.
    pub(super) fn row_of(
        &self,
        case: u64,
        values: Vec<Value<'_>>,
        outcome: Result<Vec<Cell>, Failure>,
        took: Duration,
    ) -> Option<Row> {
        let (error, answered) = match outcome {
            Ok(answered) => (None, Some(answered)),
            Err(Failure::No(why, answered)) => (Some(why), answered),
            Err(Failure::Interrupted) => return None,
        };
        let answers = answered.unwrap_or_else(|| vec![Cell::Empty; self.columns.len() - values.len() - 4]);
        let mut cells = Vec::with_capacity(self.columns.len());
        cells.push(Cell::Whole(case as i64));
        cells.extend(values.into_iter().map(|value| match value {
            Value::Written(_, Some(number)) | Value::Drawn(number) => Cell::Number(number),
            Value::Written(text, None) => Cell::Word(axis::word(text).to_owned().into()),
        }));
        cells.push(Cell::Flag(error.is_none()));
        cells.push(error.clone().map_or(Cell::Empty, |why| Cell::Word(why.into())));
        cells.extend(answers);
        cells.push(Cell::Number(took.as_secs_f64()));
        Some(Row { case, error, cells })
    }

    /// What stands in the columns of answers.
    fn cells(&self, scenario: &Scenario, answer: &Answer) -> Result<Vec<Cell>, String> {
        let inputs = self.plan.axes.len() + self.plan.varied.len();
        let columns = &self.columns[BEFORE + inputs + 2..self.columns.len() - 1];
        // Numbers alone do not change what there is to answer.
        let is_same = self.direct.is_some() || answer::columns(scenario, &answer.model, &self.question) == columns;
        let mut cells = if is_same { answer::cells(scenario, answer, &self.question) } else { Vec::new() };
        if cells.len() != columns.len() {
            cells = vec![Cell::Empty; columns.len()];
            for (column, cell) in answer::pairs(scenario, answer, &self.question) {
                match columns.iter().position(|other| *other == column) {
                    Some(index) => cells[index] = cell,
                    None if cell == Cell::Empty => {}
                    None => {
                        let Column { name, unit, .. } = &column;
                        return Err(match columns.iter().find(|other| other.name == *name) {
                            Some(other) => format!(
                                "`{name}` is measured in {unit} in this case and in {} in the others, which have another structure",
                                other.unit
                            ),
                            None => format!("this case has a column that the others have not: `{name}`"),
                        });
                    }
                }
            }
        }
        let wrong = columns.iter().zip(&cells).find(|(_, cell)| matches!(cell, Cell::Number(x) if !x.is_finite()));
        match wrong {
            Some((column, cell)) => Err(format!("`{}` is not a finite number: {cell}", column.name)),
            None => Ok(cells),
        }
    }

    /// What stands in the columns of answers of one case.
    fn solve(&self, values: &[Value<'_>], go_on: &(dyn Fn() -> bool + Sync)) -> Result<Vec<Cell>, Failure> {
        let (scenario, description, model) = self.scene(values)?;
        self.answer(&scenario, description, model, go_on)
    }

    /// The scene of a case: settings, description and model.
    pub(super) fn scene(&self, values: &[Value<'_>]) -> Result<(Cow<'_, Scenario>, Description, Arc<Model>), Failure> {
        let direct = self.direct.as_ref();
        if let Some((direct, description)) = direct.and_then(|direct| Some((direct, direct.description(values)?)))
            && let Ok(model) = Model::build(&description)
        {
            return Ok((Cow::Borrowed(&direct.scenario), description, model));
        }
        // Also of numbers that make no scene: what is wrong with them is said by who reads them.
        let scenario = self.read(&texts(values)).map_err(|problems| no(first(&problems)))?;
        let description = scenario.description.clone();
        let model = Model::build(&description).map_err(|problems| no(listed(&problems)))?;
        Ok((Cow::Owned(scenario), description, model))
    }

    /// Equilibrium and, if it is asked for, run of a scene with the settings of a scenario.
    fn answer(
        &self,
        scenario: &Scenario,
        description: Description,
        model: Arc<Model>,
        go_on: &(dyn Fn() -> bool + Sync),
    ) -> Result<Vec<Cell>, Failure> {
        let limit = self.question.time_limit;
        let until = Duration::try_from_secs_f64(limit).ok().and_then(|limit| Instant::now().checked_add(limit));
        let goes_on = || go_on() && until.is_none_or(|until| Instant::now() < until);
        let ended = || match go_on() {
            false => Failure::Interrupted,
            true => no(format!("the time limit of {limit} s for a case ended it")),
        };
        let begun = self.begin(scenario, description, model, &goes_on, &ended)?;
        if !self.question.run {
            return self.still(scenario, begun);
        }
        let (settings, rate) = (&scenario.simulate, scenario.record.rate);
        let mut ranges = OutputRanges::default();
        let summary = simulate::run(&begun.model, settings, rate, &begun.start, &mut ranges, &mut |_, _| goes_on())
            .map_err(|error| no(error.to_string()))?;
        match summary.interrupted {
            true => Err(ended()),
            false => self.ran(scenario, begun, summary, &ranges),
        }
    }

    /// The scene with its loops closed, and its equilibrium if that is asked for.
    pub(super) fn begin(
        &self,
        scenario: &Scenario,
        description: Description,
        model: Arc<Model>,
        goes_on: &dyn Fn() -> bool,
        ended: &dyn Fn() -> Failure,
    ) -> Result<Begun, Failure> {
        let (model, _) = constraint::assemble(model).map_err(|problems| no(listed(&problems)))?;
        let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
        if !self.question.asks_statics(scenario) {
            return Ok(Begun { model, start, found: None });
        }
        let Scenario { statics, margin, .. } = scenario;
        let held = statics::answer(description, model, scenario.sought(), statics, margin, goes_on)
            .map_err(|error| no(format!("statics cannot start: {error}")))?;
        let (model, found) = (held.model, held.found);
        if found.converged {
            let start = State { position: found.position.clone(), velocity: found.velocity.clone() };
            return Ok(Begun { model, start, found: Some(found) });
        }
        if !goes_on() {
            return Err(ended());
        }
        let why = found.notes.first().map(|note| format!(": {note}"));
        let why = format!("no equilibrium found{}", why.unwrap_or_default());
        let answer = Answer { model, found: Some(found), run: None, outputs: Vec::new() };
        Err(Failure::No(why, self.cells(scenario, &answer).ok()))
    }

    /// The answer of a case that is not simulated.
    fn still(&self, scenario: &Scenario, begun: Begun) -> Result<Vec<Cell>, Failure> {
        let Begun { model, found, .. } = begun;
        let outputs = found.as_ref().map(|found| statics::outputs(&model, found)).transpose();
        let outputs = outputs.map_err(|fault| no(fault.to_string()))?.unwrap_or_default();
        self.cells(scenario, &Answer { model, found, run: None, outputs }).map_err(no)
    }

    /// The answer of a case whose run has ended.
    pub(super) fn ran(
        &self,
        scenario: &Scenario,
        begun: Begun,
        summary: Summary,
        ranges: &OutputRanges,
    ) -> Result<Vec<Cell>, Failure> {
        let Begun { model, found, .. } = begun;
        let outputs = ranges.columns(&model, &summary.outputs).into_iter().map(|(_, value)| value).collect();
        self.cells(scenario, &Answer { model, found, run: Some(summary), outputs }).map_err(no)
    }

    /// What else the answers follow from, for the hash of a study: the text of the scenario, its changes, and the files that
    /// it names.
    pub fn sources(&self) -> Vec<Arc<str>> {
        let changes = self.set.iter().map(|change| Arc::from(change.shown()));
        let models = self.scenario.models.iter().flat_map(|model| &model.sources).map(|source| source.text.clone());
        [Arc::from(self.scenario.text.as_str())].into_iter().chain(changes).chain(models).collect()
    }

    /// The scenario, as it is without the changes of a plan.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }
}

impl Direct {
    /// The scene with these values; `None` if they are no numbers.
    pub(super) fn description(&self, values: &[Value<'_>]) -> Option<Description> {
        let mut description = self.scenario.description.clone();
        for (numbers, value) in self.numbers.iter().zip(values) {
            let number = match value {
                Value::Written(_, number) => (*number)?,
                Value::Drawn(number) => *number,
            };
            numbers.iter().try_for_each(|one| one.set(&mut description, number)).ok()?;
        }
        Some(description)
    }
}

/// Whether scenes are asked the same, whatever they are.
pub(super) fn is_alike(one: &Scenario, other: &Scenario) -> bool {
    let settings = |one: &Scenario| {
        let settings = (one.simulate.clone(), one.statics, one.record, one.path.clone());
        (settings, one.unknown.clone(), one.aim.clone(), one.margin.clone())
    };
    settings(one) == settings(other)
}

/// A column whose name another one before it has.
fn twice(columns: &[Column]) -> Option<&Column> {
    let mut names = HashSet::new();
    columns.iter().find(|column| !names.insert(column.name.as_str()))
}

fn refused(twice: &Column) -> Refusal {
    Refusal::Plan(format!(
        "two columns would be called `{}`: what is varied, what is unknown and what is answered need names of their own",
        twice.name
    ))
}

/// A case without any answer.
pub(super) fn no(why: String) -> Failure {
    Failure::No(why, None)
}

/// The first problem, in one line.
fn first(problems: &Diagnostics) -> String {
    problems.iter().next().map_or(String::new(), |first| first.message.clone())
}

fn listed(problems: &[Problem]) -> String {
    problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::super::axis::Axis;
    use super::super::plan::Draw;
    use super::*;
    use crate::scenario::parse;

    const SCALE: &str = "[[body]]\nname = \"pan\"\nmass = 1.0\n\
        hinge = { type = \"prismatic\", axis = [0.0, 0.0, 1.0], stiffness = 100.0 }\n";

    fn cases(axis: &str) -> Cases {
        let scenario = parse("scale.toml", SCALE, &[]).expect("a scenario");
        let plan = Plan::new(vec![Axis::parse(axis).expect("an axis")], Vec::new(), Draw::default(), None);
        let question = Question { run: false, time_limit: f64::INFINITY };
        Cases::new(scenario, Vec::new(), plan.expect("a plan"), question).expect("cases")
    }

    #[test]
    fn a_panic_is_a_row_with_its_message() {
        let cases = cases("pan.mass=1,2");
        let row = cases.row_by(1, |_| panic!("index {} out of bounds", 7)).expect("a row");
        assert_eq!(row.error.as_deref(), Some("the case ended in a panic: index 7 out of bounds"));
        assert_eq!(row.cells.len(), cases.columns().len());
        assert_eq!(row.cells[..3], [Cell::Whole(1), Cell::Number(2.0), Cell::Flag(false)]);
        assert!(cases.row(1, &|| true).is_some_and(|row| row.error.is_none()));
    }

    /// Scenes that are read and scenes whose numbers are set give the same rows, also where numbers make no scene.
    #[test]
    fn numbers_that_are_set_are_numbers_that_are_read() {
        let set = cases("pan.mass=1,0,-1,2");
        assert!(set.direct.is_some());
        let read = Cases { direct: None, ..cases("pan.mass=1,0,-1,2") };
        for case in 0..4 {
            let [one, other] = [&set, &read].map(|cases| cases.row(case, &|| true).expect("a row"));
            let last = one.cells.len() - 1;
            assert_eq!(one.cells[..last], other.cells[..last]);
            assert_eq!(one.error.is_some(), matches!(case, 1 | 2));
        }
        // Words and named numbers are read.
        assert!(cases("statics.want=any,stable").direct.is_none());
    }

    #[test]
    fn words_stand_in_their_column_without_quotes() {
        let quoted = cases("statics.want=\"any\",'stable',any");
        let words = (0..3).map(|case| quoted.row(case, &|| true).expect("a row").cells[1].to_string());
        assert_eq!(words.collect::<Vec<_>>(), ["any", "stable", "any"]);
    }
}
