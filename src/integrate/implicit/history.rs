//! Rates at past times, continued as a polynomial: what stages that are solved together start from.

/// The rates of the last steps' stages.
#[derive(Debug)]
pub(crate) struct History {
    /// Oldest first; the last `known` of them are.
    rates: Vec<Vec<f64>>,
    /// When, in s from the end of the last step.
    times: Vec<f64>,
    known: usize,
    /// A prediction is made from so many of them, the nearest in time.
    most: usize,
}

impl History {
    /// With the rate at the start of a run. Room for `room` rates, of which `most` predict.
    pub(crate) fn new(rate: &[f64], room: usize, most: usize) -> Self {
        Self { rates: vec![rate.to_vec(); room], times: vec![0.0; room], known: 1, most }
    }

    /// Takes the rates at the `nodes` of an accepted step, and leaves others in their place.
    pub(crate) fn advance(&mut self, step: f64, nodes: &[f64], rates: &mut [Vec<f64>]) {
        // The rate at the start of the run only stands in for those.
        let held = if self.known == 1 { 0 } else { self.known };
        self.known = (held + nodes.len()).min(self.rates.len());
        self.rates.rotate_left(nodes.len());
        self.times.rotate_left(nodes.len());
        let (older, newest) = self.times.split_at_mut(self.rates.len() - nodes.len());
        older.iter_mut().for_each(|time| *time -= step);
        newest.iter_mut().zip(nodes).for_each(|(time, node)| *time = (node - 1.0) * step);
        self.rates[older.len()..].iter_mut().zip(rates).for_each(|(kept, rate)| std::mem::swap(kept, rate));
    }

    /// `to ←` the rate at the time `at`, in s from the end of the last step, by the polynomial through the last rates and
    /// the `found` ones of a step of length `step`, with their nodes.
    pub(crate) fn predict(&self, (step, nodes, found): (f64, &[f64], &[Vec<f64>]), at: f64, to: &mut [f64]) {
        let start = self.rates.len() - self.known;
        let kept = self.times.iter().copied().zip(&self.rates).skip(start);
        let known = kept.chain(nodes.iter().map(|node| node * step).zip(found));
        let known = || known.clone().skip((self.known + found.len()).saturating_sub(self.most));
        to.fill(0.0);
        for (j, (time, rate)) in known().enumerate() {
            let others = known().map(|(other, _)| other).enumerate().filter(|(k, _)| *k != j);
            let weight: f64 = others.map(|(_, other)| (at - other) / (time - other)).product();
            to.iter_mut().zip(rate).for_each(|(to, rate)| *to += weight * rate);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NODES: [f64; 2] = [0.4, 1.0];

    fn cubic(t: f64) -> f64 {
        2.0 - 3.0 * t + 0.5 * t * t - t * t * t
    }

    #[test]
    fn a_polynomial_is_continued_over_steps_of_any_length() {
        let mut history = History::new(&[cubic(0.0)], 4, 4);
        let mut end = 0.0;
        for step in [0.5, 0.2, 0.3] {
            let mut rates = NODES.map(|node| vec![cubic(end + node * step)]);
            history.advance(step, &NODES, &mut rates);
            end += step;
        }
        let found = [vec![cubic(end + NODES[0] * 0.1)]];
        for (nodes, found) in [(&NODES[..0], &found[..0]), (&NODES[..1], &found[..])] {
            let mut rate = [0.0];
            history.predict((0.1, nodes, found), 0.1, &mut rate);
            // Rounding of four terms with weights up to 10.
            assert!((rate[0] - cubic(end + 0.1)).abs() < 1e-13, "{}", rate[0]);
        }
    }

    #[test]
    fn the_first_step_is_predicted_from_its_start_and_the_second_from_the_first_alone() {
        let mut history = History::new(&[7.0], 4, 4);
        let mut rate = [0.0];
        history.predict((0.1, &[], &[]), 0.05, &mut rate);
        assert_eq!(rate, [7.0]);
        history.advance(1.0, &NODES, &mut [vec![1.0], vec![2.0]]);
        history.predict((0.1, &[], &[]), 0.6, &mut rate);
        assert!((rate[0] - 3.0).abs() < 1e-14);
    }
}
