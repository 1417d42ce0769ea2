//! How far driven coordinates move within a step.
//!
//! A drive says where its coordinate is, so no estimate of errors sees how far that goes: at a steady rate a step takes hundreds of turns,
//! and every state in it is right. Powers are not known from a few of these: the weight of an eccentric rotor goes up and down in each
//! turn.

use crate::model::{Model, Scalar};

/// Part of the scene's length over which forces change as much as over one radian.
const WAY: f64 = 0.1;
/// Powers have waves of twice the angle: of forces and lever arms, which both turn.
const WAVES: f64 = 2.0;
/// Any rule integrates waves over less than this (rad) as it does polynomials.
const SLIGHT: f64 = 0.01;

/// Coordinates that drives move, by themselves or through gears.
#[derive(Debug, Clone)]
pub(super) struct Driven {
    /// Velocity coordinates, and the radians that a unit of each counts for (1, rad/m).
    coordinates: Vec<(usize, f64)>,
}

impl Driven {
    pub(super) fn new(model: &Model) -> Self {
        let mut tied: Vec<Scalar> = model.drives.iter().map(|drive| drive.coordinate).collect();
        let mut known = 0;
        while known < tied.len() {
            let own = tied[known];
            for gear in model.gears.iter().filter(|gear| gear.coordinates.contains(&own)) {
                let news = gear.coordinates.iter().filter(|other| !tied.contains(other)).copied();
                let news: Vec<Scalar> = news.collect();
                tied.extend(news);
            }
            known += 1;
        }
        let per_unit = |slides: bool| if slides { 1.0 / (WAY * model.length_scale()) } else { 1.0 };
        Self { coordinates: tied.iter().map(|one| (one.velocity, per_unit(one.slides))).collect() }
    }

    /// How fast the fastest of them goes (rad/s).
    pub(super) fn rate(&self, v: &[f64]) -> f64 {
        self.coordinates.iter().map(|(i, per_unit)| per_unit * v[*i].abs()).fold(0.0, f64::max)
    }
}

/// What a rule on 0…1 misses of the integral of the waves of what turns by an angle (rad) there, from one part of it to another; `rule` has
/// its nodes and weights.
pub(super) fn missed(rule: impl Iterator<Item = (f64, f64)>, [from, until]: [f64; 2], turn: f64) -> f64 {
    if turn < SLIGHT {
        return 0.0;
    }
    let k = WAVES * turn;
    let [(sin_from, cos_from), (sin_until, cos_until)] = [from, until].map(|x| (k * x).sin_cos());
    let exact = [(sin_until - sin_from) / k, (cos_from - cos_until) / k];
    let [cosine, sine] = rule.fold(exact, |[cosine, sine], (node, weight)| {
        let (sin, cos) = (k * node).sin_cos();
        [cosine - weight * cos, sine - weight * sin]
    });
    cosine.hypot(sine)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Simpson's rule: its error over an interval of `k` radians is `k⁴/2880` of the wave's mean size.
    #[test]
    fn a_rule_misses_what_its_error_says() {
        let simpson = || [(0.0, 1.0 / 6.0), (0.5, 4.0 / 6.0), (1.0, 1.0 / 6.0)].into_iter();
        for turn in [0.02, 0.1] {
            let expected = (WAVES * turn).powi(4) / 2880.0;
            assert!((missed(simpson(), [0.0, 1.0], turn) / expected - 1.0).abs() < 0.01);
        }
        // Of whole turns it sees nothing but its first place.
        assert!(missed(simpson(), [0.0, 1.0], std::f64::consts::TAU) > 0.9);
        assert_eq!(missed(simpson(), [0.0, 1.0], 0.0), 0.0);
    }
}
