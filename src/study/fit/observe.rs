//! What the scene of an experiment answers: measured numbers at its equilibrium, or over a run.

use super::residuals::Stop;
use super::roles::Measure;
use crate::constraint;
use crate::model::description::Description;
use crate::model::{Model, Parameter, Problem};
use crate::record::{Outcome, RecordError, Recorder, Sample};
use crate::scenario::Scenario;
use crate::simulate::{self, Start, State};
use crate::statics::{self, Equilibrium, SensitivityError, sensitivities};
use std::sync::Arc;

/// Times that differ from a multiple of the sampling time by less than this part of it are that.
const SAME: f64 = 1e-6;
/// A sample that is earlier than a measured time by more than this part of the sampling time is another one.
const EARLY: f64 = 1e-3;
/// A run is sampled at so many instants for one that was measured, at most; else it is run from each of these to the next.
const MOST_SAMPLES: f64 = 1000.0;

/// An equilibrium, with the scene that it belongs to.
pub(super) struct Solved {
    pub description: Description,
    pub model: Arc<Model>,
    pub found: Equilibrium,
}

/// What was measured, by the scene: a row for each time of a run, one row of an equilibrium.
pub(super) struct Observed {
    pub rows: Vec<Vec<f64>>,
    /// Of an equilibrium.
    pub solved: Option<Solved>,
}

/// The equilibrium of a scenario.
fn solve(scenario: &Scenario, go_on: &dyn Fn() -> bool) -> Result<Solved, Stop> {
    let model = Model::build(&scenario.description).map_err(listed)?;
    let (model, _) = constraint::assemble(model).map_err(listed)?;
    let Scenario { description, statics, margin, .. } = scenario;
    let held = statics::answer(description.clone(), model, scenario.sought(), statics, margin, go_on)
        .map_err(|why| Stop::No(format!("statics cannot start: {why}")))?;
    if !go_on() {
        return Err(Stop::Interrupted);
    }
    if !held.found.converged {
        let why = held.found.notes.first().map_or_else(String::new, |note| format!(": {note}"));
        return Err(Stop::No(format!("no equilibrium found{why}")));
    }
    Ok(Solved { description: held.description, model: held.model, found: held.found })
}

fn listed(problems: Vec<Problem>) -> Stop {
    Stop::No(problems.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))
}

/// The measured numbers at the equilibrium.
pub(super) fn at_rest(scenario: &Scenario, measures: &[Measure], go_on: &dyn Fn() -> bool) -> Result<Observed, Stop> {
    let solved = solve(scenario, go_on)?;
    let outputs = statics::outputs(&solved.model, &solved.found).map_err(|fault| Stop::No(fault.to_string()))?;
    let frequencies: Vec<f64> = solved.found.stability.iter().flat_map(|of| of.frequencies()).collect();
    let number = |measure: &Measure| match measure {
        Measure::Output(label) => Ok(outputs[place(&solved.model, label)?]),
        Measure::Frequency(index) => frequencies.get(*index).copied().ok_or_else(|| {
            Stop::No(format!("there is no frequency {index}: the equilibrium has {}", frequencies.len()))
        }),
    };
    let row = measures.iter().map(number).collect::<Result<Vec<f64>, Stop>>()?;
    Ok(Observed { rows: vec![row], solved: Some(solved) })
}

/// The place of an output's number.
fn place(model: &Model, label: &str) -> Result<usize, Stop> {
    let all = model.outputs.iter().flat_map(|output| output.range().zip(output.labels()));
    let found = all.into_iter().find(|(_, own)| own == label).map(|(place, _)| place);
    found.ok_or_else(|| Stop::No(format!("the scene has no output `{label}` any more")))
}

/// Derivatives of the measured numbers at an equilibrium, exact where there are any: a row a measure, `None` where differences have to do.
pub(super) fn derivatives(
    solved: &Solved,
    measures: &[Measure],
    parameters: &[Option<Vec<Parameter>>],
    go_on: &dyn Fn() -> bool,
) -> Result<Vec<Vec<Option<f64>>>, Stop> {
    let none = vec![vec![None; parameters.len()]; measures.len()];
    let numbers: Vec<Parameter> = parameters.iter().flatten().flatten().cloned().collect();
    let name = |measure: &Measure| match measure {
        Measure::Output(label) => label.clone(),
        Measure::Frequency(index) => format!("frequency[{index}]"),
    };
    let names: Vec<String> = measures.iter().map(name).collect();
    let Solved { description, model, found } = solved;
    let table = match sensitivities(description, model, found, &names, Some(numbers.clone()), go_on) {
        Ok(table) => table,
        Err(SensitivityError::Interrupted) => return Err(Stop::Interrupted),
        Err(_) => return Ok(none),
    };
    if table.derivatives.len() != measures.len() {
        return Ok(none);
    }
    let column = |one: &Parameter| numbers.iter().position(|other| other == one);
    let by = |row: &Vec<Option<f64>>, of: &Option<Vec<Parameter>>| {
        // All numbers of an address move together.
        of.as_ref()?.iter().map(|one| row[column(one)?]).sum::<Option<f64>>()
    };
    Ok(table.derivatives.iter().map(|row| parameters.iter().map(|of| by(row, of)).collect()).collect())
}

/// The measured numbers over a run at these times (s), which ascend.
pub(super) fn over_time(
    scenario: &Scenario,
    measures: &[Measure],
    times: &[f64],
    go_on: &dyn Fn() -> bool,
) -> Result<Observed, Stop> {
    let model = Model::build(&scenario.description).map_err(listed)?;
    let (mut model, _) = constraint::assemble(model).map_err(listed)?;
    let mut start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    if scenario.simulate.start == Start::Equilibrium {
        let solved = solve(scenario, go_on)?;
        start = State { position: solved.found.position.clone(), velocity: solved.found.velocity.clone() };
        model = solved.model;
    }
    let label = |measure: &Measure| match measure {
        Measure::Output(label) => place(&model, label),
        Measure::Frequency(index) => Err(Stop::No(format!("a run has no frequency {index}"))),
    };
    let places = measures.iter().map(label).collect::<Result<Vec<usize>, Stop>>()?;
    let last = times.last().copied().unwrap_or_default();
    let sampled = sampling(times);
    let mut taken = Taken { times, places: &places, gap: sampled.unwrap_or_default(), rows: Vec::new() };
    let duration = if last > 0.0 { last } else { scenario.simulate.duration };
    let settings = simulate::Settings { duration, ..scenario.simulate.clone() };
    let failed = |why: simulate::RunError| Stop::No(why.to_string());
    if let Some(gap) = sampled {
        let goes_on = &mut |_: f64, _: &State| go_on();
        simulate::run(&model, &settings, 1.0 / gap, &start, &mut taken, goes_on).map_err(failed)?;
    } else {
        let mut simulator = crate::simulator::Simulator::new(model, settings, start);
        for time in times {
            if *time > simulator.snapshot().time {
                simulator.advance(*time, go_on).map_err(failed)?;
            }
            if simulator.snapshot().stopped_by.is_some() || !go_on() {
                break;
            }
            let outputs = simulator.outputs().map_err(failed)?;
            taken.rows.push(places.iter().map(|place| outputs[*place]).collect());
        }
    }
    if !go_on() {
        return Err(Stop::Interrupted);
    }
    match times.get(taken.rows.len()) {
        Some(time) => Err(Stop::No(format!("the run ended before the time {time} s"))),
        None => Ok(Observed { rows: taken.rows, solved: None }),
    }
}

/// The time between samples that hits all times, if there is one: the smallest distance of two of them, zero counted as one.
fn sampling(times: &[f64]) -> Option<f64> {
    let mut before = 0.0;
    let mut gap = f64::INFINITY;
    for time in times {
        if *time > before {
            gap = gap.min(time - before);
            before = *time;
        }
    }
    let last = times.last()?;
    // The longest of them gives the gap with the most digits.
    let count = (last / gap).round();
    let gap = last / count;
    let hits = |time: &f64| ((time / gap) - (time / gap).round()).abs() <= SAME;
    (gap.is_finite() && count <= MOST_SAMPLES * times.len() as f64 && times.iter().all(hits)).then_some(gap)
}

/// Takes the outputs at the measured times.
struct Taken<'a> {
    times: &'a [f64],
    places: &'a [usize],
    /// Between samples (s).
    gap: f64,
    rows: Vec<Vec<f64>>,
}

impl Recorder for Taken<'_> {
    fn sample(&mut self, sample: &Sample) -> Result<(), RecordError> {
        while let Some(time) = self.times.get(self.rows.len()) {
            if sample.time < time - EARLY * self.gap {
                break;
            }
            self.rows.push(self.places.iter().map(|place| sample.outputs[*place]).collect());
        }
        Ok(())
    }

    fn finish(&mut self, _outcome: &Outcome) -> Result<(), RecordError> {
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_on_a_grid_are_samples_of_one_run() {
        let gap = sampling(&[0.0, 0.1, 0.2, 0.2, 0.5, 1.2]).expect("a grid");
        assert!((gap - 0.1).abs() < 1e-12, "{gap}");
        assert_eq!(sampling(&[0.1, 0.25, 1.3]), None);
        assert_eq!(sampling(&[0.0]), None);
    }
}
