//! Curves that jump, and curves with parts that are so short and so steep that few looks meet them.

use super::{bead, formulas, heavy, run};
use crate::common::{Random, build};
use stillpoint::element::guide::{Guide, GuideCurve};
use stillpoint::integrate::Method;
use stillpoint::model::Model;
use stillpoint::record::Fanout;
use stillpoint::simulate::{self, Integrator, Settings, Start, State};

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
        let guide = match Guide::new(&curve, false) {
            Ok(guide) => guide,
            Err(flaw) => {
                // A peak that turns by more than a piece may within the shortest one, a billionth of the range.
                let turned = 2.0 * by * sharp * sharp * 5e-9;
                assert!(z.contains("exp") && turned > 0.2, "seed {seed}: {z}: {flaw:?}");
                continue;
            }
        };
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

/// A bead that comes to a narrow hill goes over it if its energy suffices, and turns back if not, by whatever method and tolerance: steps that
/// have grown on the straight do not pass the hill by.
#[test]
fn hills_are_climbed_by_what_has_the_energy() {
    let methods = [
        None,
        Some(Method::Dopri5),
        Some(Method::Dop853),
        Some(Method::Adams),
        Some(Method::Radau5),
        Some(Method::Radau9),
    ];
    for seed in 0..60 {
        let mut random = Random::new(9_000 + seed);
        let (height, width) = (random.between(0.05, 0.5), 10.0_f64.powf(random.between(-3.0, -1.0)));
        let at = random.between(0.5, 2.0);
        let part = if seed % 2 == 0 { random.between(0.8, 0.99) } else { random.between(1.01, 1.2) };
        let curve = formulas("u", "0", &format!("{height}*exp(-((u - {at})/{width})^2)"), [-30.0, 30.0]);
        let model = build(&heavy(bead(curve)));
        let speed = (2.0 * 9.81 * height * part).sqrt();
        let start = State { position: vec![-3.0 - random.between(0.0, 4.0)], velocity: vec![speed] };
        let method = methods[seed as usize % methods.len()];
        let tolerance = 10.0_f64.powf(random.between(-10.0, -6.0));
        let settings = Settings {
            start: Start::Given,
            duration: 12.0 / speed,
            tolerance,
            absolute_tolerance: tolerance,
            integrator: method.map_or(Integrator::Auto, Integrator::Method),
            ..Settings::default()
        };
        let found = simulate::run(&model, &settings, 1.0, &start, &mut Fanout::new(), &mut |_, _| true);
        let found = found.unwrap_or_else(|error| panic!("seed {seed}: {error}"));
        let over = found.state.position[0] > at + 2.0 * height;
        assert_eq!(over, part > 1.0, "seed {seed}, {method:?}: {} m, {part} of the energy", found.state.position[0]);
        // On the straight it has the energy that it came with, as exactly as the loosest tolerance makes a hundred steps.
        assert!((found.state.velocity[0].abs() / speed - 1.0).abs() < 1e-3, "seed {seed}: {:?}", found.state.velocity);
    }
}
