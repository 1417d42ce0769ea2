//! When given motions, motors, loads and masses change their rules, so that no step crosses such a time.
//!
//! A table that begins to move at 5 s is nothing but rest to a step from 1 s to 10 s whose evaluations all lie at its
//! ends, and a jump of accelerations inside of a step costs every method its order. Steps end just before a break, and
//! begin anew at it. Formulas have no breaks that could be known: steps are a hundredth of the run at most there.

use crate::model::Model;

/// The breaks of a model's motions, motors, loads and masses.
#[derive(Debug)]
pub(in crate::simulate) struct Timetable {
    /// Increasing, within the run (s).
    breaks: Vec<f64>,
    /// Of the run (s).
    end: f64,
    /// Longest step (s).
    pub(in crate::simulate) longest_step: Option<f64>,
}

impl Timetable {
    /// Of a run from one time to another (s).
    pub(in crate::simulate) fn new(model: &Model, [begin, end]: [f64; 2]) -> Self {
        let duration = end - begin;
        let (drives, motors) = (&model.drives, &model.motors);
        let each = drives.iter().map(|drive| drive.motion.breaks()).chain(motors.iter().map(|motor| motor.breaks()));
        let tables = model.table_times();
        let within = |time: &f64| *time > begin && *time < end;
        let mut breaks: Vec<f64> = each.flatten().copied().chain(tables).filter(within).collect();
        breaks.sort_by(f64::total_cmp);
        // Times that were meant to be the same are one.
        breaks.dedup_by(|later, earlier| *later - *earlier <= 1e-12 * duration);
        let drives = drives.iter().map(|drive| drive.motion.longest_step(duration));
        let longest =
            drives.chain(motors.iter().map(|motor| motor.longest_step(duration))).fold(f64::INFINITY, f64::min);
        Self { breaks, end, longest_step: (longest < duration).then_some(longest) }
    }

    /// Whether anything changes its rule within the run.
    pub(in crate::simulate) fn is_empty(&self) -> bool {
        self.breaks.is_empty()
    }

    /// The next break after `time`, or the end of the run.
    pub(in crate::simulate) fn next(&self, time: f64) -> f64 {
        self.breaks.get(self.breaks.partition_point(|at| *at <= time)).copied().unwrap_or(self.end)
    }

    /// Whether a break is at this time.
    pub(in crate::simulate) fn breaks_at(&self, time: f64) -> bool {
        self.breaks.contains(&time)
    }

    /// Where steps towards a break end: just before it, so that all of them go by the rule that holds until then.
    pub(in crate::simulate) fn end(&self, next: f64) -> f64 {
        if next < self.end { next.next_down() } else { next }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_end_just_before_a_break_and_at_the_end() {
        let table = Timetable { breaks: vec![0.5, 2.0], end: 3.0, longest_step: None };
        assert_eq!((table.next(0.0), table.next(0.5), table.next(2.5)), (0.5, 2.0, 3.0));
        assert!(table.end(0.5) < 0.5 && table.next(table.end(0.5)) == 0.5);
        assert_eq!(table.end(3.0), 3.0);
    }
}
