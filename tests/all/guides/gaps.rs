//! Curves that jump, and curves with parts that are so short and so steep that few looks meet them.

use super::{bead, formulas, heavy, run};
use crate::common::{Random, build};
use stillpoint::element::guide::{Guide, GuideCurve};
use stillpoint::model::Model;
use stillpoint::simulate::State;

fn slope(z: &str) -> GuideCurve {
    formulas("u", "0", z, [0.0, 5.0])
}

/// A curve that goes on elsewhere than where it has come to is refused, with the value of the parameter there: by whatever rule it jumps,
/// in whatever direction, and if it jumps there and back within a millionth of its range.
#[test]
fn a_curve_with_a_gap_is_refused_where_it_jumps() {
    for seed in 0..150 {
        let mut random = Random::new(seed);
        let (at, by) = (random.between(0.1, 4.9), random.between(-1.0, 1.0) * 10.0_f64.powf(random.between(-5.0, 0.0)));
        let width = 10.0_f64.powf(random.between(-8.0, -1.0));
        let jump = match random.below(6) {
            0 => format!("if(u > {at}, {by}, 0)"),
            1 => format!("if(u < {at}, sin(u), sin(u) + {by})"),
            2 => format!("{by}*floor(u - {at})"),
            3 => format!("0.1*u^2 + {by}*sign(u - {at})"),
            4 => format!("if(abs(u - {at}) < {width}, {by}, 0)"),
            _ => format!("{by}*abs(u - {at})/(u - {at} + 1e-300)"),
        };
        // Across, along and back along: a jump back along the curve shortens the chord.
        let curve = match random.below(3) {
            0 => slope(&jump),
            1 => formulas(&format!("u + {jump}"), "0.2*u", "0", [0.0, 5.0]),
            _ => formulas(&format!("u - {jump}"), "0", "0.1*u^2", [0.0, 5.0]),
        };
        let problems = Model::build(&heavy(bead(curve.clone()))).expect_err(&format!("seed {seed}: {curve:?}"));
        let said = problems[0].to_string();
        let told = said.split("parameter ").nth(1).and_then(|rest| rest.split([',', ' ', ';', ':']).next());
        let told: f64 =
            told.and_then(|told| told.trim_end_matches('.').parse().ok()).unwrap_or_else(|| panic!("{said}"));
        let first = at.min(at - width).max(0.0);
        // Of what jumps at every whole number after the first, the first.
        let near = [at, first, at + width, at % 1.0].iter().any(|place| (told - place).abs() < 1e-6);
        assert!(near && said.contains("has a gap"), "seed {seed}: {said}, at {at}");
    }
}

/// Steep parts have their arc length, or are refused where they are: a bead that goes down keeps its energy, and is as high as the curve says.
#[test]
fn narrow_steep_parts_are_gone_through() {
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let (at, by) = (random.between(0.2, 4.8), random.between(0.3, 1.0));
        let sharp = 10.0_f64.powf(random.between(0.5, 5.0));
        let z = match random.below(3) {
            0 => format!("-{by}*tanh({sharp}*(u - {at}))"),
            1 => format!("-{by}*atan({sharp}*(u - {at}))"),
            _ => format!("{by}*exp(-({sharp}*(u - {at}))^2)"),
        };
        let curve = slope(&z);
        let guide = Guide::new(&curve, false).unwrap_or_else(|flaw| panic!("seed {seed}: {z}: {flaw:?}"));
        // Along any chord it is no shorter than that, as far as the parameter has digits.
        let [from, to] = guide.range();
        let rounded = 8.0 * f64::EPSILON * at * by * sharp / ((to - from) / 1000.0);
        let mut longest = 0.0_f64;
        for k in 0..1000 {
            let [a, b] = [k, k + 1].map(|k| guide.at(from + (to - from) * f64::from(k) / 1000.0).place);
            longest = longest.max((b - a).norm() / ((to - from) / 1000.0));
        }
        assert!(longest < 1.0 + 1e-9 + rounded, "seed {seed}: {z}: {longest}");
        let model = build(&heavy(bead(curve)));
        let start = State { position: vec![from], velocity: vec![6.0] };
        let found = run(&model, 0.5, &start).unwrap_or_else(|error| panic!("seed {seed}: {z}: {error}"));
        assert!(found.energy_drift < 1e-7 * found.energy_largest, "seed {seed}: {z}: {:e}", found.energy_drift);
    }
}
