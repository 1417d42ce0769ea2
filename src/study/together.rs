//! Cases side by side: those that follow each other are scenes of one structure with other numbers, and their runs are computed
//! together, each as it would be alone.

use super::case::{Cases, Failure, Row, is_alike, no};
use super::column::Cell;
use super::plan::Value;
use crate::dynamics::Ensemble;
use crate::foreign;
use crate::model::{Description, Model};
use crate::scenario::Scenario;
use crate::simulate::outputs::OutputRanges;
use crate::simulate::{State, run_together, runs_together};
use crate::spatial::lanes::WIDTH;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

impl Cases {
    /// Whether runs of this study can be computed side by side: there are enough of them, numbers alone are varied, nothing limits the
    /// time of a case, scene and method are [covered](runs_together), and scenes from all over the plan are of one structure.
    pub(super) fn may_go_together(&self) -> bool {
        let enough = self.question.run && self.plan.cases() >= WIDTH as u64;
        if !enough || self.question.time_limit.is_finite() || self.plan.are_numbers().any(|number| !number) {
            return false;
        }
        let probes = [(false, 0.1), (true, 0.9), (false, 0.5), (true, 0.5)];
        let scenes = probes.into_iter().filter_map(|(last, u)| self.scene(&self.plan.probe(last, u)).ok());
        let covered = |(scenario, _, model): &(Cow<'_, Scenario>, Description, Arc<Model>)| {
            runs_together(model, &scenario.simulate)
        };
        let scenes: Vec<_> = scenes.collect();
        let Some(first) = scenes.first().filter(|_| scenes.iter().all(covered)) else { return false };
        let alike = scenes.iter().all(|other| is_alike(&first.0, &other.0));
        let models = std::array::from_fn(|lane| Arc::clone(&scenes[lane % scenes.len()].2));
        alike && Ensemble::new(&models).is_some()
    }

    /// Computes every case by itself from now on. The answers are the same to round-off.
    pub fn go_alone(&mut self) {
        self.together = false;
    }

    /// How many cases are computed side by side.
    pub fn width(&self) -> usize {
        if self.together { WIDTH } else { 1 }
    }

    /// The rows of cases that follow each other; `None` if `go_on` ended them.
    pub fn rows(&self, cases: Range<u64>, go_on: &(dyn Fn() -> bool + Sync)) -> Option<Vec<Row>> {
        if self.together && cases.end - cases.start == WIDTH as u64 {
            let side_by_side = foreign::caught(|| self.rows_together(cases.start, go_on));
            // Of what panics, as of what has another structure, each case is asked alone.
            if let Ok(Some(rows)) = side_by_side {
                return rows.into_iter().collect();
            }
        }
        cases.map(|case| self.row(case, go_on)).collect()
    }

    /// The rows of [`WIDTH`] cases, none for one that was ended; `None` if they cannot be computed together.
    fn rows_together(&self, first: u64, go_on: &(dyn Fn() -> bool + Sync)) -> Option<[Option<Row>; WIDTH]> {
        let begin = Instant::now();
        let values: [Vec<Value<'_>>; WIDTH] = std::array::from_fn(|lane| self.plan.values(first + lane as u64));
        let scenes: Vec<_> = values.iter().map(|values| self.scene(values).ok()).collect::<Option<_>>()?;
        let scenarios: Vec<Cow<'_, Scenario>> = scenes.iter().map(|(scenario, ..)| scenario.clone()).collect();
        if !scenarios.iter().all(|other| is_alike(&scenarios[0], other)) {
            return None;
        }
        let mut begun = Vec::with_capacity(WIDTH);
        for (scenario, description, model) in scenes {
            let ended = || Failure::Interrupted;
            // A case without an equilibrium is told of by itself.
            begun.push(self.begin(&scenario, description, model, &|| go_on(), &ended).ok()?);
        }
        let models = std::array::from_fn(|lane| begun[lane].model.clone());
        let starts: [State; WIDTH] = std::array::from_fn(|lane| begun[lane].start.clone());
        let mut ranges: [OutputRanges; WIDTH] = std::array::from_fn(|_| OutputRanges::default());
        let (settings, rate) = (&scenarios[0].simulate, scenarios[0].record.rate);
        let mut recorders = ranges.each_mut().map(|range| range as &mut dyn crate::record::Recorder);
        let ran = run_together(&models, settings, rate, &starts, &mut recorders, &mut |_, _| go_on())?;
        let each = ran.into_iter().zip(begun).zip(&ranges).zip(&scenarios);
        let mut outcomes = each.map(|(((summary, begun), ranges), scenario)| {
            let summary = summary.map_err(|error| no(error.to_string()))?;
            match summary.interrupted {
                true => Err(Failure::Interrupted),
                false => self.ran(scenario, begun, summary, ranges),
            }
        });
        let outcomes: [Result<Vec<Cell>, Failure>; WIDTH] =
            std::array::from_fn(|_| outcomes.next().unwrap_or(Err(Failure::Interrupted)));
        let took = begin.elapsed() / WIDTH as u32;
        let mut each = values.into_iter().zip(outcomes).zip(first..);
        Some(std::array::from_fn(|_| {
            let ((values, outcome), case) = each.next()?;
            self.row_of(case, values, outcome, took)
        }))
    }
}
