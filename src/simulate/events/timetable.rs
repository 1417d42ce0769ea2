//! When given motions, motors, loads and masses change their rules, so that no step crosses such a time.
//!
//! A table that begins to move at 5 s is nothing but rest to a step from 1 s to 10 s whose evaluations all lie at its
//! ends, and a jump of accelerations inside of a step costs every method its order. Steps end just before a break, and
//! begin anew at it.
//!
//! Of formulas in the time the breaks are found before the run ([`crate::formula::Formula::instants`]): where they change their rule,
//! and around what they do for less than a fiftieth of the run. For all that they do besides, steps are a hundredth of the run at
//! most there.

use crate::model::Model;
use crate::round_off::{MEANT_TIME, TIME};

/// Times that are one.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Break {
    /// The first of them (s): until then the old rules hold.
    first: f64,
    /// The last of them (s): from here on the new rules hold.
    last: f64,
    /// Whether a formula of the time has one of them.
    formula: bool,
}

/// The breaks of a model's motions, motors, loads and masses.
#[derive(Debug)]
pub(in crate::simulate) struct Timetable {
    /// Increasing, within the run.
    breaks: Vec<Break>,
    /// Of the run (s).
    begin: f64,
    end: f64,
    /// Longest step (s).
    pub(in crate::simulate) longest_step: Option<f64>,
}

impl Timetable {
    /// Of a run from one time to another (s), whose longest steps are a part of what they may be.
    pub(in crate::simulate) fn new(model: &Model, run: [f64; 2], stride: f64) -> Self {
        let [begin, end] = run;
        let duration = end - begin;
        let (drives, motors) = (&model.drives, &model.motors);
        let mut times: Vec<(f64, bool)> = model.table_times().map(|time| (time, false)).collect();
        let mut add = |breaks: &[f64], formula| times.extend(breaks.iter().map(|time| (*time, formula)));
        drives.iter().for_each(|drive| add(&drive.motion.breaks(run), drive.motion.is_formula()));
        motors.iter().for_each(|motor| add(&motor.breaks(run), motor.is_formula()));
        times.retain(|(time, _)| *time > begin && *time < end);
        let drives = drives.iter().map(|drive| drive.motion.longest_step(duration));
        let longest =
            drives.chain(motors.iter().map(|motor| motor.longest_step(duration))).fold(f64::INFINITY, f64::min);
        let longest_step = (longest < duration).then_some(stride * longest);
        Self { breaks: breaks(times, duration), begin, end, longest_step }
    }

    /// Whether anything changes its rule within the run.
    pub(in crate::simulate) fn is_empty(&self) -> bool {
        self.breaks.is_empty()
    }

    /// The next break after `time`, or the end of the run.
    pub(in crate::simulate) fn next(&self, time: f64) -> f64 {
        self.breaks.get(self.breaks.partition_point(|at| at.last <= time)).map_or(self.end, |at| at.last)
    }

    /// From which break to which (s) a time lies, if a formula has one of them: it may do anything in between.
    pub(in crate::simulate) fn formula_stretch(&self, time: f64) -> Option<[f64; 2]> {
        let next = self.breaks.partition_point(|at| at.last <= time);
        let (before, after) = (next.checked_sub(1).map(|i| self.breaks[i]), self.breaks.get(next));
        let of_formula = before.iter().chain(after).any(|at| at.formula);
        of_formula.then(|| [before.map_or(self.begin, |at| at.last), after.map_or(self.end, |at| at.first.next_down())])
    }

    fn at(&self, time: f64) -> Option<&Break> {
        self.breaks.get(self.breaks.partition_point(|at| at.last < time)).filter(|at| at.last == time)
    }

    /// Whether a break is at this time.
    pub(in crate::simulate) fn breaks_at(&self, time: f64) -> bool {
        self.at(time).is_some()
    }

    /// Where steps towards a break end: just before it, so that all of them go by the rule that holds until then.
    pub(in crate::simulate) fn end(&self, next: f64) -> f64 {
        self.at(next).map_or(next, |at| at.first.next_down())
    }
}

/// Times in any order, those that are one put together.
fn breaks(mut times: Vec<(f64, bool)>, duration: f64) -> Vec<Break> {
    times.sort_by(|(one, _), (other, _)| one.total_cmp(other));
    let mut breaks: Vec<Break> = Vec::new();
    for (time, formula) in times {
        let same = MEANT_TIME.of(duration).max(TIME.of(time.abs()));
        match breaks.last_mut() {
            Some(at) if time - at.first <= same => (at.last, at.formula) = (time, at.formula || formula),
            _ => breaks.push(Break { first: time, last: time, formula }),
        }
    }
    breaks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_end_just_before_a_break_and_at_the_end() {
        let breaks = breaks(vec![(2.0, false), (0.5, false)], 3.0);
        let table = Timetable { breaks, begin: 0.0, end: 3.0, longest_step: None };
        assert_eq!((table.next(0.0), table.next(0.5), table.next(2.5)), (0.5, 2.0, 3.0));
        assert!(table.end(0.5) < 0.5 && table.next(table.end(0.5)) == 0.5);
        assert_eq!(table.end(3.0), 3.0);
    }

    /// Steps end before the first of times that are one, and begin at the last.
    #[test]
    fn times_that_are_one_are_passed_at_once() {
        let (first, last) = (0.5, 0.5 + 1e-13);
        let times = [last, 0.5_f64.next_up(), first].map(|time| (time, time == last));
        let table = Timetable { breaks: breaks(times.to_vec(), 3.0), begin: 0.0, end: 3.0, longest_step: None };
        assert_eq!(table.breaks, [Break { first, last, formula: true }]);
        assert_eq!((table.next(0.1), table.end(last)), (last, first.next_down()));
        assert!(table.breaks_at(last) && !table.breaks_at(first) && table.next(last) == 3.0);
    }

    #[test]
    fn a_stretch_of_a_formula_has_a_break_of_it_at_an_end() {
        let times = vec![(0.5, true), (1.0, false), (2.0, false)];
        let table = Timetable { breaks: breaks(times, 3.0), begin: 0.0, end: 3.0, longest_step: None };
        assert_eq!(table.formula_stretch(0.2), Some([0.0, 0.5_f64.next_down()]));
        assert_eq!(table.formula_stretch(0.5), Some([0.5, 1.0_f64.next_down()]));
        assert_eq!([1.0, 2.5].map(|time| table.formula_stretch(time)), [None; 2]);
        let table = Timetable { breaks: Vec::new(), ..table };
        assert_eq!(table.formula_stretch(0.5), None);
    }
}
