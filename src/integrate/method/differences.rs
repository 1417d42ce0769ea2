//! Scaled divided differences of rates at times that are not equally spaced, and integrals of their polynomial.
//!
//! With the times `t_0 > t_1 > …` backwards from the newest,
//!
//! ```text
//! (1)  Φ_j = f[t_0, …, t_j] Π_{i<j} (t_0 − t_{i+1}),   f(s) ≈ P(s) = Σ_j Φ_j Π_{i<j} (s − t_i) / (t_0 − t_{i+1})
//! (2)  ∫ P from t_0 to t_0 + h  =  h Σ_j G_j(h) Φ_j
//! ```
//!
//! Hairer, Nørsett, Wanner, *Solving ODEs I*, III.5; Shampine, Gordon (1975), chapter 5.

/// Differences that are kept.
pub(crate) const MOST_TERMS: usize = 14;

/// Components side by side: what a compiler makes vector instructions of.
const LANES: usize = 4;
/// `Φ_0, Φ_1, …` of some components.
type Block = [[f64; LANES]; MOST_TERMS];

/// Of every component of a state.
#[derive(Debug, Clone)]
pub(crate) struct Differences {
    /// `t_0, t_1, …`; the first `known` of them.
    times: [f64; MOST_TERMS],
    known: usize,
    blocks: Vec<Block>,
}

/// What a step of a length is made with.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Weights {
    /// `G_0(h), G_1(h), …` of (2).
    pub(crate) integrals: [f64; MOST_TERMS],
    /// `β_0, β_1, …`: what the differences are scaled with where a rate at `t_0 + h` follows.
    pub(crate) ratios: [f64; MOST_TERMS],
}

impl Differences {
    /// Of one rate alone.
    pub(crate) fn new(time: f64, rate: &[f64]) -> Self {
        let mut blocks = vec![[[0.0; LANES]; MOST_TERMS]; rate.len().div_ceil(LANES)];
        for (block, rate) in blocks.iter_mut().zip(rate.chunks(LANES)) {
            block[0] = lanes(rate);
        }
        Self { times: [time; MOST_TERMS], known: 1, blocks }
    }

    /// `sum ← start + step Σ_j weights_j Φ_j`, the smallest terms first.
    pub(crate) fn sum(&self, start: &[f64], step: f64, weights: &[f64], sum: &mut [f64]) {
        let ends = sum.chunks_mut(LANES).zip(start.chunks(LANES));
        for (block, (sum, start)) in self.blocks.iter().zip(ends) {
            let mut total = [0.0; LANES];
            for (term, weight) in block.iter().zip(weights).rev() {
                (0..LANES).for_each(|lane| total[lane] += weight * term[lane]);
            }
            for (lane, (sum, start)) in sum.iter_mut().zip(start).enumerate() {
                *sum = start + step * total[lane];
            }
        }
    }

    /// `sum ← start + factor Φ_j`.
    pub(crate) fn add(&self, start: &[f64], factor: f64, j: usize, sum: &mut [f64]) {
        let ends = sum.chunks_mut(LANES).zip(start.chunks(LANES));
        for (block, (sum, start)) in self.blocks.iter().zip(ends) {
            for (lane, (sum, start)) in sum.iter_mut().zip(start).enumerate() {
                *sum = start + factor * block[j][lane];
            }
        }
    }

    /// The largest `|weights Φ_j|` of all components.
    pub(crate) fn largest(&self, j: usize, weights: &[f64]) -> f64 {
        let mut largest = [0.0; LANES];
        for (block, weights) in self.blocks.iter().zip(weights.chunks(LANES)) {
            for (lane, weight) in weights.iter().enumerate() {
                let size = (block[j][lane] * weight).abs();
                largest[lane] = if size > largest[lane] { size } else { largest[lane] };
            }
        }
        largest.into_iter().fold(0.0, f64::max)
    }

    /// `Φ_j` of component `i`.
    pub(crate) fn of(&self, i: usize, j: usize) -> f64 {
        self.blocks[i / LANES][j][i % LANES]
    }

    /// The first `count` weights of a step from `t_0` to `t_0 + h`; `h` may be negative.
    ///
    /// `G_j` by moments of the product in (1): with one more factor `w_q ← (h + t_0 − t_j) w_q − h w_{q+1}`, divided by
    /// `t_0 − t_{j+1}`, and `G_j = w_0`.
    pub(crate) fn weights(&self, h: f64, count: usize) -> Weights {
        let mut w: [f64; MOST_TERMS] = std::array::from_fn(|q| 1.0 / (q + 1) as f64);
        let mut weights = Weights { integrals: [0.0; MOST_TERMS], ratios: [1.0; MOST_TERMS] };
        weights.integrals[0] = 1.0;
        let mut before = 0.0;
        for j in 1..count {
            let span = self.span(j);
            let (now, next) = ((h + before) / span, h / span);
            weights.ratios[j] = weights.ratios[j - 1] * now;
            for q in 0..count - j {
                w[q] = now * w[q] - next * w[q + 1];
            }
            weights.integrals[j] = w[0];
            before = span;
        }
        weights
    }

    /// Becomes `past` with one more rate at `time`, as far as the ratios go and one more.
    pub(crate) fn advance(&mut self, past: &Self, time: f64, rate: &[f64], ratios: &[f64]) {
        self.known = (past.known + 1).min(MOST_TERMS);
        self.times[1..].copy_from_slice(&past.times[..MOST_TERMS - 1]);
        self.times[0] = time;
        for ((block, past), rate) in self.blocks.iter_mut().zip(&past.blocks).zip(rate.chunks(LANES)) {
            let mut difference = lanes(rate);
            let [first, rest @ ..] = block;
            *first = difference;
            for ((to, past), ratio) in rest.iter_mut().zip(past).zip(ratios) {
                (0..LANES).for_each(|lane| difference[lane] -= ratio * past[lane]);
                *to = difference;
            }
        }
    }

    /// `t_0 − t_j`; for a time before the first known one a length as if the steps had gone on.
    fn span(&self, j: usize) -> f64 {
        if j < self.known {
            return self.times[0] - self.times[j];
        }
        let last = self.times[0] - self.times[self.known - 1];
        if last > 0.0 { last * j as f64 / (self.known - 1) as f64 } else { j as f64 }
    }
}

/// Some components, zeros beyond the last.
fn lanes(values: &[f64]) -> [f64; LANES] {
    let mut lanes = [0.0; LANES];
    lanes[..values.len()].copy_from_slice(values);
    lanes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Steps that are not equal.
    const TIMES: [f64; 7] = [0.0, 0.3, 0.5, 0.9, 1.0, 1.4, 1.5];

    fn monomials_at(times: &[f64]) -> Differences {
        let rate = |t: f64| -> Vec<f64> { (0..TIMES.len() as i32).map(|n| t.powi(n)).collect() };
        let mut past = Differences::new(times[0], &rate(times[0]));
        for (count, pair) in times.windows(2).enumerate() {
            let ratios = past.weights(pair[1] - pair[0], count + 1).ratios;
            let mut next = past.clone();
            next.advance(&past, pair[1], &rate(pair[1]), &ratios[..=count]);
            past = next;
        }
        past
    }

    #[test]
    fn a_polynomial_through_all_its_rates_is_integrated_exactly_forwards_and_back() {
        let known = monomials_at(&TIMES);
        let end = TIMES[TIMES.len() - 1];
        for h in [0.4_f64, -0.05, -1.1] {
            let weights = known.weights(h, TIMES.len()).integrals;
            let sum = |terms: usize| {
                let mut sum = vec![0.0; TIMES.len()];
                known.sum(&vec![0.0; TIMES.len()], h, &weights[..terms], &mut sum);
                sum
            };
            for degree in 0..TIMES.len() {
                let power = degree as i32 + 1;
                let exact = ((end + h).powi(power) - end.powi(power)) / f64::from(power);
                // Rounding of sums of numbers up to 1.9⁷.
                assert!((sum(TIMES.len())[degree] - exact).abs() < 1e-12, "{degree} {h}");
                // One term less misses the highest degree alone.
                let short = sum(TIMES.len() - 1)[degree];
                assert_eq!((short - exact).abs() > 1e-9, degree + 1 == TIMES.len(), "{degree} {h}");
            }
        }
    }

    #[test]
    fn differences_of_a_degree_vanish_above_it() {
        let known = monomials_at(&TIMES);
        for degree in 0..TIMES.len() {
            for j in 0..TIMES.len() {
                assert_eq!(known.of(degree, j).abs() > 1e-12, j <= degree, "{degree} {j}");
            }
        }
    }
}
