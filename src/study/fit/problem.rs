//! The residuals of all measurements, and their Jacobian.

use super::observe::{Observed, Solved, at_rest, derivatives, over_time};
use super::residuals::{Residuals, Stop};
use super::roles::{Measure, Roles};
use super::scenes::Scenes;
use super::table::MeasuredTable;
use super::{ColumnFit, FitQuestion, Trouble};
use crate::model::Parameter;
use crate::scenario::{Override, Scenario};
use nalgebra::{DMatrix, DVector};
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Half the distance of central differences between equilibria, as a part of a number's size: the third root of what a search leaves
/// open.
const AT_REST: f64 = 3e-5;
/// Between runs it is the third root of their tolerance, within these.
const OVER_TIME: [f64; 2] = [1e-5, 3e-3];

/// Rows whose numbers were set alike: one equilibrium, or one run.
struct Experiment {
    /// The numbers of the rows.
    settings: Vec<f64>,
    /// Of a run: times, ascending.
    times: Vec<f64>,
    readings: Vec<Reading>,
}

/// One number that was measured.
struct Reading {
    /// Row of the table.
    row: usize,
    /// Which of the measures.
    measure: usize,
    /// Place of its time among those of the experiment; 0 at rest.
    time: usize,
    value: f64,
}

/// Residuals as functions of the parameters.
pub(super) struct Problem<'p> {
    scenes: Scenes<'p>,
    experiments: Vec<Experiment>,
    measures: Vec<Measure>,
    /// Headings, units, deviations, and whether those are the spread.
    about: Vec<(String, String, f64)>,
    by_spread: bool,
    rows: usize,
    run: bool,
    /// What each parameter sets, where that is known.
    numbers: Vec<Option<Vec<Parameter>>>,
    /// Half the distances of differences, over the sizes of the parameters.
    distance: f64,
    /// Sizes of parameters that are zero.
    sizes: Vec<f64>,
    ranges: Vec<[f64; 2]>,
    /// The scenes where the residuals were evaluated last.
    last: Vec<Observed>,
    /// Equilibria or runs that were computed.
    pub evaluations: usize,
    /// Whether a parameter's derivatives were differences anywhere.
    pub by_differences: Vec<bool>,
    go_on: &'p (dyn Fn() -> bool + Sync),
}

impl<'p> Problem<'p> {
    pub(super) fn new(
        (scenario, set): (&'p Scenario, &'p [Override]),
        table: &MeasuredTable,
        question: &FitQuestion,
        roles: &Roles,
        start: &[f64],
        go_on: &'p (dyn Fn() -> bool + Sync),
    ) -> Result<Self, Trouble> {
        let settings = roles.settings.iter().map(|place| table.columns[*place].name.clone());
        let paths: Vec<String> = settings.chain(question.parameters.iter().map(|one| one.address.clone())).collect();
        let experiments = experiments(table, roles);
        let Some(first) = experiments.first() else { return Err(nothing_measured(table, roles)) };
        let first: Vec<f64> = first.settings.iter().chain(start).copied().collect();
        let scenes = Scenes::new((scenario, set), paths, &first, roles.more.clone())?;
        let about = about(table, question, roles, &experiments)?;
        let numbers = |address: &str| Parameter::find(&scenario.description, address).ok();
        let size = |start: f64, [low, high]: [f64; 2]| match (high - low).is_finite() {
            true if start == 0.0 => high - low,
            _ if start == 0.0 => 1.0,
            _ => start.abs(),
        };
        let distance = match question.run {
            true => scenario.simulate.tolerance.cbrt().clamp(OVER_TIME[0], OVER_TIME[1]),
            false => AT_REST,
        };
        Ok(Self {
            scenes,
            experiments,
            measures: roles.measured.iter().map(|one| one.of.clone()).collect(),
            by_spread: about.iter().any(|(name, ..)| !question.deviations.iter().any(|(given, _)| given == name)),
            about,
            rows: table.rows(),
            run: question.run,
            numbers: question.parameters.iter().map(|one| numbers(&one.address)).collect(),
            distance,
            sizes: question.parameters.iter().zip(start).map(|(one, start)| size(*start, one.range)).collect(),
            ranges: question.parameters.iter().map(|one| one.range).collect(),
            last: Vec::new(),
            evaluations: 0,
            by_differences: vec![false; start.len()],
            go_on,
        })
    }

    /// Whether a column counts by the spread of what was measured.
    pub(super) fn weighted_by_spread(&self) -> bool {
        self.by_spread
    }

    /// What is left in each column.
    pub(super) fn columns(&self, residuals: &DVector<f64>) -> Vec<ColumnFit> {
        let mut all: Vec<ColumnFit> = self
            .about
            .iter()
            .map(|(name, unit, deviation)| ColumnFit {
                name: name.clone(),
                unit: unit.clone(),
                count: 0,
                rms: 0.0,
                deviation: *deviation,
                left: vec![None; self.rows],
            })
            .collect();
        for (reading, residual) in self.readings().zip(residuals.iter()) {
            let column = &mut all[reading.measure];
            let left = residual * column.deviation;
            column.left[reading.row] = Some(left);
            column.rms += left * left;
            column.count += 1;
        }
        all.iter_mut().for_each(|column| column.rms = (column.rms / column.count.max(1) as f64).sqrt());
        all
    }

    fn readings(&self) -> impl Iterator<Item = &Reading> {
        self.experiments.iter().flat_map(|one| &one.readings)
    }

    /// What an experiment answers to these parameters.
    fn observe(&self, experiment: &Experiment, x: &[f64]) -> Result<Observed, Stop> {
        let values: Vec<f64> = experiment.settings.iter().chain(x).copied().collect();
        let go_on = &|| (self.go_on)();
        let observed = self.scenes.at(&values).map_err(Stop::No).and_then(|scenario| match self.run {
            true => over_time(&scenario, &self.measures, &experiment.times, go_on),
            false => at_rest(&scenario, &self.measures, go_on),
        });
        observed.map_err(|stop| match stop {
            Stop::No(why) => Stop::No(format!("{}: {why}", self.called(experiment))),
            ended => ended,
        })
    }

    /// An experiment in messages.
    fn called(&self, experiment: &Experiment) -> String {
        match experiment.readings.iter().map(|reading| reading.row + 1).min() {
            Some(row) => format!("row {row} of the data"),
            None => "the data".to_owned(),
        }
    }

    /// Columns of the Jacobian that have exact derivatives, experiment by experiment.
    fn exact(&self) -> Result<Vec<Vec<Vec<Option<f64>>>>, Stop> {
        let of = |index: usize| {
            let none = vec![vec![None; self.numbers.len()]; self.measures.len()];
            let Some(Observed { solved: Some(solved), .. }) = self.last.get(index) else { return Ok(none) };
            self.derivatives(solved)
        };
        side_by_side(self.experiments.len(), &of).into_iter().collect()
    }

    fn derivatives(&self, solved: &Solved) -> Result<Vec<Vec<Option<f64>>>, Stop> {
        derivatives(solved, &self.measures, &self.numbers, &|| (self.go_on)())
    }

    /// Central differences of an experiment's answers by a parameter; one-sided at the end of what is allowed.
    fn difference(&self, index: usize, j: usize, x: &[f64]) -> Result<Vec<Vec<f64>>, Stop> {
        let size = if x[j] == 0.0 { self.sizes[j] } else { x[j].abs() };
        let h = self.distance * size;
        let [low, high] = self.ranges[j];
        let beside = |by: f64| {
            let mut moved = x.to_vec();
            moved[j] += by;
            match (low..=high).contains(&moved[j]) {
                true => self.observe(&self.experiments[index], &moved).map(|seen| (moved[j], seen.rows)),
                false => Err(Stop::No("beyond its range".to_owned())),
            }
        };
        let here = || (x[j], self.last[index].rows.clone());
        let ((after, up), (before, down)) = match (beside(h), beside(-h)) {
            (Err(Stop::Interrupted), _) | (_, Err(Stop::Interrupted)) => return Err(Stop::Interrupted),
            (Ok(up), Ok(down)) => (up, down),
            (Ok(up), Err(_)) => (up, here()),
            (Err(_), Ok(down)) => (here(), down),
            (Err(why), Err(_)) => return Err(why),
        };
        let row = |(up, down): (&Vec<f64>, &Vec<f64>)| {
            up.iter().zip(down).map(|(up, down)| (up - down) / (after - before)).collect()
        };
        Ok(up.iter().zip(&down).map(row).collect())
    }
}

impl Residuals for Problem<'_> {
    /// Stiffer runs take more steps.
    fn reach(&self) -> f64 {
        if self.run { 100.0 } else { 1e6 }
    }

    fn at(&mut self, x: &[f64]) -> Result<DVector<f64>, Stop> {
        self.evaluations += self.experiments.len();
        let seen = side_by_side(self.experiments.len(), &|index| self.observe(&self.experiments[index], x));
        let seen = seen.into_iter().collect::<Result<Vec<_>, Stop>>()?;
        let of = |experiment: &Experiment, seen: &Observed| -> Vec<f64> {
            let residual = |reading: &Reading| {
                (seen.rows[reading.time][reading.measure] - reading.value) / self.about[reading.measure].2
            };
            experiment.readings.iter().map(residual).collect()
        };
        let all: Vec<f64> = self.experiments.iter().zip(&seen).flat_map(|(one, seen)| of(one, seen)).collect();
        self.last = seen;
        Ok(DVector::from_vec(all))
    }

    fn jacobian(&mut self, x: &[f64]) -> Result<DMatrix<f64>, Stop> {
        let exact = self.exact()?;
        let missing = |index: usize, j: usize| exact[index].iter().any(|row| row[j].is_none());
        let jobs: Vec<(usize, usize)> = (0..self.experiments.len())
            .flat_map(|index| (0..x.len()).map(move |j| (index, j)))
            .filter(|(index, j)| missing(*index, *j))
            .collect();
        let differences = side_by_side(jobs.len(), &|at| self.difference(jobs[at].0, jobs[at].1, x));
        let differences = differences.into_iter().collect::<Result<Vec<_>, Stop>>()?;
        self.evaluations += 2 * jobs.len();
        jobs.iter().for_each(|(_, j)| self.by_differences[*j] = true);
        let mut places = vec![None; self.experiments.len() * x.len()];
        jobs.iter().enumerate().for_each(|(at, (index, j))| places[index * x.len() + j] = Some(at));
        let mut jacobian = DMatrix::zeros(self.readings().count(), x.len());
        let mut first = 0;
        for (index, experiment) in self.experiments.iter().enumerate() {
            for (i, reading) in experiment.readings.iter().enumerate() {
                for j in 0..x.len() {
                    let derivative = match (exact[index][reading.measure][j], places[index * x.len() + j]) {
                        (Some(derivative), _) => derivative,
                        (None, Some(at)) => differences[at][reading.time][reading.measure],
                        (None, None) => 0.0,
                    };
                    jacobian[(first + i, j)] = derivative / self.about[reading.measure].2;
                }
            }
            first += experiment.readings.len();
        }
        match jacobian.iter().all(|x| x.is_finite()) {
            true => Ok(jacobian),
            false => Err(Stop::No("a derivative is not finite".to_owned())),
        }
    }
}

/// Why columns without a single number cannot be fitted to.
fn empty(names: &[&str]) -> String {
    let cells = if names.len() == 1 { "its cells" } else { "their cells" };
    format!(
        "nothing was measured in `{}`: all of {cells} are empty or `nan`; `--ignore` leaves a column out",
        names.join("`, `")
    )
}

/// Of a table in which nothing was measured at all.
fn nothing_measured(table: &MeasuredTable, roles: &Roles) -> Trouble {
    let names: Vec<&str> = roles.measured.iter().map(|one| table.columns[one.column].name.as_str()).collect();
    Trouble::Data(empty(&names))
}

/// The experiments of a table, in the order in which they come first.
fn experiments(table: &MeasuredTable, roles: &Roles) -> Vec<Experiment> {
    let mut all: Vec<Experiment> = Vec::new();
    for row in 0..table.rows() {
        let settings: Vec<f64> = roles.settings.iter().map(|place| table.columns[*place].values[row]).collect();
        let known = all.iter().position(|one| one.settings == settings).unwrap_or_else(|| {
            all.push(Experiment { settings, times: Vec::new(), readings: Vec::new() });
            all.len() - 1
        });
        if let Some(time) = roles.time {
            all[known].times.push(table.columns[time].values[row]);
        }
        for (measure, one) in roles.measured.iter().enumerate() {
            let value = table.columns[one.column].values[row] / one.size;
            if !value.is_nan() {
                all[known].readings.push(Reading { row, measure, time: 0, value });
            }
        }
    }
    for one in &mut all {
        one.times.sort_by(f64::total_cmp);
        one.times.dedup();
        if let Some(time) = roles.time {
            for reading in &mut one.readings {
                let of = table.columns[time].values[reading.row];
                reading.time = one.times.iter().position(|time| *time == of).unwrap_or_default();
            }
        }
    }
    all.retain(|one| !one.readings.is_empty());
    all
}

/// Headings, units and deviations of the measured columns.
fn about(
    table: &MeasuredTable,
    question: &FitQuestion,
    roles: &Roles,
    experiments: &[Experiment],
) -> Result<Vec<(String, String, f64)>, Trouble> {
    for (name, deviation) in &question.deviations {
        if !roles.measured.iter().any(|one| table.columns[one.column].name == *name) {
            return Err(Trouble::Wrong(format!("`{name}` has a deviation and is no measured column")));
        }
        if !(*deviation > 0.0 && deviation.is_finite()) {
            return Err(Trouble::Wrong(format!(
                "the deviation of `{name}` is {deviation}, allowed: finite numbers > 0"
            )));
        }
    }
    let of = |(measure, one): (usize, &super::roles::MeasuredColumn)| {
        let name = table.columns[one.column].name.clone();
        let readings = experiments.iter().flat_map(|one| &one.readings).filter(|reading| reading.measure == measure);
        let values: Vec<f64> = readings.map(|reading| reading.value).collect();
        if values.is_empty() {
            return Err(Trouble::Data(empty(&[&name])));
        }
        let given = question.deviations.iter().find(|(given, _)| *given == name).map(|(_, deviation)| *deviation);
        Ok((name, one.unit.clone(), given.unwrap_or_else(|| spread(&values))))
    };
    roles.measured.iter().enumerate().map(of).collect()
}

/// The standard deviation of numbers; where they are equal their size, or 1.
fn spread(values: &[f64]) -> f64 {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let square = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count;
    match square.sqrt() {
        spread if spread > 1e-9 * mean.abs() => spread,
        _ if mean != 0.0 => mean.abs(),
        _ => 1.0,
    }
}

/// `of(0)`, …, on all processors.
fn side_by_side<T: Send>(count: usize, of: &(dyn Fn(usize) -> T + Sync)) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<Option<T>>> = Mutex::new((0..count).map(|_| None).collect());
    let work = || {
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= count {
                return;
            }
            let answer = of(index);
            done.lock().unwrap_or_else(PoisonError::into_inner)[index] = Some(answer);
        }
    };
    let threads = std::thread::available_parallelism().map_or(1, NonZeroUsize::get).min(count);
    std::thread::scope(|scope| {
        // As many threads as the system gives.
        let others = (1..threads).map_while(|_| std::thread::Builder::new().spawn_scoped(scope, work).ok());
        let others: Vec<_> = others.collect();
        work();
        drop(others);
    });
    done.into_inner().unwrap_or_else(PoisonError::into_inner).into_iter().flatten().collect()
}
