//! Cases side by side: those that follow each other are scenes of one structure with other numbers, and their runs are computed
//! together, each as it would be alone.

use super::case::{Cases, Failure, Row, no};
use super::column::Cell;
use super::plan::Value;
use crate::foreign;
use crate::model::Model;
use crate::simulate::outputs::OutputRanges;
use crate::simulate::{State, run_together, runs_together};
use crate::spatial::lanes::WIDTH;
use std::ops::Range;
use std::time::Instant;

impl Cases {
    /// Whether runs of this study can be computed side by side: there are enough of them, plain numbers of the scene alone are
    /// varied, nothing limits the time of a case, and scene and method are [covered](runs_together).
    pub(super) fn may_go_together(&self) -> bool {
        let enough = self.question.run && self.plan.cases() >= WIDTH as u64;
        let Some(direct) = self.direct.as_ref().filter(|_| enough) else { return false };
        let model = Model::build(&direct.scenario.description);
        let covered = model.is_ok_and(|model| runs_together(&model, &direct.scenario.simulate));
        covered && !self.question.time_limit.is_finite()
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
        let direct = self.direct.as_ref()?;
        let values: [Vec<Value<'_>>; WIDTH] = std::array::from_fn(|lane| self.plan.values(first + lane as u64));
        let mut begun = Vec::with_capacity(WIDTH);
        for values in &values {
            let description = direct.description(values)?;
            let model = Model::build(&description).ok()?;
            let ended = || Failure::Interrupted;
            // A case without an equilibrium is told of by itself.
            begun.push(self.begin(&direct.scenario, description, model, &|| go_on(), &ended).ok()?);
        }
        let models = std::array::from_fn(|lane| begun[lane].model.clone());
        let starts: [State; WIDTH] = std::array::from_fn(|lane| begun[lane].start.clone());
        let mut ranges: [OutputRanges; WIDTH] = std::array::from_fn(|_| OutputRanges::default());
        let (settings, rate) = (&direct.scenario.simulate, direct.scenario.record.rate);
        let mut recorders = ranges.each_mut().map(|range| range as &mut dyn crate::record::Recorder);
        let ran = run_together(&models, settings, rate, &starts, &mut recorders, &mut |_, _| go_on())?;
        let mut outcomes = ran.into_iter().zip(begun).zip(&ranges).map(|((summary, begun), ranges)| {
            let summary = summary.map_err(|error| no(error.to_string()))?;
            match summary.interrupted {
                true => Err(Failure::Interrupted),
                false => self.ran(&direct.scenario, begun, summary, ranges),
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
