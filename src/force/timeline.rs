//! Numbers by a table over time: straight lines between its points, constant before the first and after the last.

/// The times of a table.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Timeline {
    /// Not decreasing (s). At a time given twice the numbers jump: those of the second count from there on.
    pub times: Vec<f64>,
}

/// A place in a table: two rows, and how far it is from the first to the second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Between {
    /// The row before.
    pub before: usize,
    /// The row after; the same before the first and after the last.
    pub after: usize,
    /// 0 … 1
    pub part: f64,
    /// How fast `part` grows (1/s).
    pub rate: f64,
}

impl Between {
    /// A number between its values in both rows.
    pub fn mix(&self, values: &[f64]) -> f64 {
        let (a, b) = (values[self.before], values[self.after]);
        a + self.part * (b - a)
    }
}

impl Timeline {
    /// Where a time is.
    pub fn at(&self, time: f64) -> Between {
        let (after, last) = (self.times.partition_point(|at| *at <= time), self.times.len() - 1);
        if after == 0 || after > last {
            let row = if after == 0 { 0 } else { last };
            return Between { before: row, after: row, part: 0.0, rate: 0.0 };
        }
        let (from, to) = (self.times[after - 1], self.times[after]);
        Between { before: after - 1, after, part: (time - from) / (to - from), rate: 1.0 / (to - from) }
    }

    /// What is wrong with the times, with as many values beside them.
    pub fn flaw(&self, values: usize) -> Option<String> {
        if self.times.is_empty() {
            return Some("has no times".to_owned());
        }
        if self.times.len() != values {
            return Some(format!(
                "has {} time{} and {values} value{}",
                self.times.len(),
                plural(self.times.len()),
                plural(values)
            ));
        }
        if let Some(bad) = self.times.iter().find(|time| !time.is_finite()) {
            return Some(format!("has the time {bad}"));
        }
        let back = self.times.windows(2).find(|pair| pair[1] < pair[0]);
        let thrice = self.times.windows(3).find(|three| three[0] == three[2]);
        back.map(|pair| format!("goes back from {} s to {} s", pair[0], pair[1]))
            .or_else(|| thrice.map(|three| format!("has the time {} s more than twice", three[0])))
    }
}

/// The end of the word for so many things.
fn plural(n: usize) -> &'static str {
    if n == 1 { "" } else { "s" }
}
