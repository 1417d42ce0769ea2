//! Probabilities for the varied numbers of a sample: independent, stratified, or evenly spread.
//!
//! Everything follows from the seed and the number of the sample: the generator (ChaCha with 8 rounds, Bernstein 2008) is
//! addressed by the sample, not advanced from one to the next, so that any part of a study can be computed anywhere.

use super::correlation::Correlation;
use super::distribution::BELOW_ONE;
use super::sobol::{self, Directions};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{RngCore, SeedableRng};

/// How samples are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Sampling {
    /// Independent of each other.
    #[default]
    Random,
    /// Latin hypercube: of `n` samples one in every `n`-th part of each number's distribution (McKay, Beckman and Conover
    /// 1979).
    Latin,
    /// Points of [`sobol`].
    Sobol,
}

impl Sampling {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Random, Self::Latin, Self::Sobol];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Random => "random",
            Self::Latin => "latin",
            Self::Sobol => "sobol",
        }
    }
}

/// Draws samples.
#[derive(Debug, Clone)]
pub struct Sampler {
    sampling: Sampling,
    /// Samples of the study.
    count: u64,
    generator: ChaCha8Rng,
    /// Of every dimension: the key of its permutation, or its digital shift.
    keys: Vec<u64>,
    directions: Vec<Directions>,
    correlation: Option<Correlation>,
}

impl Sampler {
    /// Of `count` samples with so many dimensions.
    ///
    /// # Errors
    /// If the way to sample gives no such number of samples or dimensions.
    pub fn new(
        (sampling, seed, count): (Sampling, u64, u64),
        dimensions: usize,
        correlation: Option<Correlation>,
    ) -> Result<Self, String> {
        if sampling == Sampling::Sobol && (dimensions > sobol::MOST_DIMENSIONS || count > sobol::MOST_POINTS) {
            return Err(format!(
                "Sobol points have at most {} numbers, and there are {} of them; `latin` and `random` have no such limit",
                sobol::MOST_DIMENSIONS,
                sobol::MOST_POINTS
            ));
        }
        let mut generator = ChaCha8Rng::seed_from_u64(seed);
        // A stream that no sample has.
        generator.set_stream(u64::MAX);
        let keys = (0..dimensions).map(|_| generator.next_u64()).collect();
        let directions = match sampling {
            Sampling::Sobol => (0..dimensions).map(Directions::new).collect(),
            _ => Vec::new(),
        };
        Ok(Self { sampling, count, generator, keys, directions, correlation })
    }

    /// The probabilities of a sample < `count`, each in (0, 1).
    pub fn probabilities(&self, sample: u64) -> Vec<f64> {
        let mut u: Vec<f64> = match self.sampling {
            Sampling::Random => self.stream(sample).map(unit).collect(),
            Sampling::Latin => {
                let parts = self.keys.iter().map(|key| permuted(sample, self.count, *key));
                // Rounding must not reach 1, where no quantile is.
                let inside = |(part, x): (u64, u64)| ((part as f64 + unit(x)) / self.count as f64).min(BELOW_ONE);
                parts.zip(self.stream(sample)).map(inside).collect()
            }
            Sampling::Sobol => {
                let point = |directions: &Directions| u64::from(directions.point(sample as u32)) << 32;
                self.directions
                    .iter()
                    .zip(&self.keys)
                    .map(|(directions, shift)| unit(point(directions) ^ shift))
                    .collect()
            }
        };
        if let Some(correlation) = &self.correlation {
            correlation.apply(&mut u);
        }
        u
    }

    /// The random numbers of a sample, one for each dimension.
    fn stream(&self, sample: u64) -> impl Iterator<Item = u64> {
        let mut generator = self.generator.clone();
        generator.set_stream(sample);
        generator.set_word_pos(0);
        (0..self.keys.len()).map(move |_| generator.next_u64())
    }
}

/// The middle of one of 2⁵² equal parts of (0, 1).
fn unit(x: u64) -> f64 {
    ((x >> 12) as f64 + 0.5) / (1_u64 << 52) as f64
}

/// Rounds of the permutation below.
const ROUNDS: u64 = 8;

/// A permutation of 0 … `count` − 1 that follows from its key: a Feistel network on the next power of four, walked until it is
/// inside (Black and Rogaway 2002). Nothing has to be kept of it, whatever `count` is.
fn permuted(index: u64, count: u64, key: u64) -> u64 {
    let half = (64 - (count - 1).leading_zeros()).div_ceil(2).max(1);
    let mask = (1_u64 << half) - 1;
    let mut at = index;
    loop {
        let (mut left, mut right) = (at >> half, at & mask);
        for round in 0..ROUNDS {
            (left, right) = (right, left ^ (mixed(key ^ mixed(round << 32 | right)) & mask));
        }
        at = left << half | right;
        if at < count {
            return at;
        }
    }
}

/// The finalizer of SplitMix64 (Steele, Lea and Flood 2014).
fn mixed(x: u64) -> u64 {
    let x = x.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_permutation_takes_every_place_once() {
        for count in [1, 2, 3, 5, 64, 100, 1000] {
            for key in [0, 1, 0xdead_beef_1234_5678] {
                let mut found: Vec<u64> = (0..count).map(|i| permuted(i, count, key)).collect();
                found.sort_unstable();
                assert!(found.into_iter().eq(0..count), "{count}, key {key}");
            }
        }
    }

    /// A Latin hypercube has one sample in every part; means of Sobol points are better than those of random ones.
    #[test]
    fn samples_are_stratified_or_spread_as_they_should_be() {
        let count = 1000;
        let sampler = |sampling| Sampler::new((sampling, 7, count), 3, None).expect("few numbers");
        for d in 0..3 {
            let latin = sampler(Sampling::Latin);
            let mut parts: Vec<u64> = (0..count).map(|i| (latin.probabilities(i)[d] * count as f64) as u64).collect();
            parts.sort_unstable();
            assert!(parts.into_iter().eq(0..count), "dimension {d}");
            let mean = |sampling| {
                let sampler = sampler(sampling);
                (0..count).map(|i| sampler.probabilities(i)[d]).sum::<f64>() / count as f64
            };
            // Standard deviation of the mean of 1000 independent numbers: 0.0091; the star discrepancy bounds Sobol's error.
            assert!((mean(Sampling::Random) - 0.5).abs() < 5.0 * 0.0091);
            assert!((mean(Sampling::Sobol) - 0.5).abs() < 1e-3);
            assert!((mean(Sampling::Latin) - 0.5).abs() < 5.0 * 0.29 / (count as f64).powf(1.5));
        }
    }

    /// Numbers of two samples, of two dimensions and of two seeds have nothing to do with each other.
    #[test]
    fn a_sample_follows_from_seed_and_number_alone() {
        for sampling in Sampling::ALL {
            let of = |seed| Sampler::new((sampling, seed, 500), 4, None).expect("few numbers");
            let (one, again, other) = (of(1), of(1), of(2));
            for i in [499, 3, 0, 17] {
                assert_eq!(one.probabilities(i), again.probabilities(i));
                assert_ne!(one.probabilities(i), other.probabilities(i));
            }
            let rows: Vec<Vec<f64>> = (0..500).map(|i| one.probabilities(i)).collect();
            for (a, b) in [(0, 1), (0, 3), (1, 2), (2, 3)] {
                let r = rows.iter().map(|row| (row[a] - 0.5) * (row[b] - 0.5)).sum::<f64>() / 500.0 * 12.0;
                // Standard deviation of r for independent samples: 1/√500.
                assert!(r.abs() < 5.0 / 500_f64.sqrt(), "{}: {a} and {b}: {r}", sampling.name());
            }
        }
    }
}
