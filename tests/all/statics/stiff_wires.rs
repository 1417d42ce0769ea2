//! Weights on wires so stiff that what swings them is next to nothing beside what stretches them: the verdict knows it, and knows
//! what it does not know.

use crate::common::{Random, build};
use std::f64::consts::TAU;
use stillpoint::scenario;
use stillpoint::statics::{Equilibrium, StabilityVerdict, equilibrium};

fn rest(text: &str) -> Equilibrium {
    let scenario = scenario::parse("wire.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
    let model = build(&scenario.description);
    equilibrium(&model, &scenario.statics, &model.start_position).expect("numbers")
}

/// A ball on three slides, and a spring from the ground to it. `up` has it stand on the spring.
fn ball(mass: f64, length: f64, stiffness: f64, down: [f64; 3], up: bool, statics: &str) -> String {
    let at: Vec<f64> = down.iter().map(|x| if up { -length * x } else { length * x }).collect();
    let slide = |name: &str, parent: &str, axis: usize, mass: f64| {
        let unit: Vec<f64> = (0..3).map(|i| f64::from(u8::from(i == axis))).collect();
        format!(
            "[[body]]\nname = \"{name}\"\nmass = {mass:?}\nhinge = {{ {parent}type = \"prismatic\", axis = {unit:?}, position = {:?} }}\n",
            at[axis]
        )
    };
    let gravity: Vec<f64> = down.iter().map(|x| 10.0 * x).collect();
    format!(
        "gravity = {gravity:?}\n{statics}{}{}{}[[force]]\nname = \"wire\"\ntype = \"spring\"\nbetween = [{{ body = \"ground\" }}, \"n\"]\n\
         stiffness = {stiffness:?}\nlength = {length:?}\n",
        slide("x", "", 0, 0.0),
        slide("y", "parent = \"x\", ", 1, 0.0),
        slide("n", "parent = \"y\", ", 2, mass)
    )
}

fn direction(random: &mut Random) -> [f64; 3] {
    let (height, turn) = (random.between(-1.0, 1.0), random.between(0.0, TAU));
    let radius = (1.0 - height * height).sqrt();
    [radius * turn.cos(), radius * turn.sin(), height]
}

/// ω² = T/(m L) with T = m g and L = L₀ + m g/k, twice; the tension is known to ε k L of m g. Upside down the same stiffness is
/// negative, and two directions run away.
#[test]
fn pendulums_on_wires_swing_by_their_length_however_stiff() {
    let mut most = 0.0_f64;
    for seed in 0..60 {
        let random = &mut Random::new(seed);
        let (mass, length) = (10_f64.powf(random.between(-3.0, 2.0)), random.between(0.2, 5.0));
        // Up to 10¹¹ times the stiffness that swings it: beyond, forces are known too badly to tell where it hangs.
        let stiffness = 10_f64.powf(random.between(2.0, 11.0)) * mass * 10.0 / length;
        let (down, up) = (direction(random), seed % 3 == 0);
        let statics = if up { "[statics]\nwant = \"any\"\n" } else { "" };
        let found = rest(&ball(mass, length, stiffness, down, up, statics));
        assert!(found.converged, "seed {seed}: {:?}", found.notes);
        let stability = found.stability.expect("a verdict");
        let ratio = stiffness / (mass * 10.0 / length);
        if up {
            assert_eq!(
                (stability.verdict, stability.unstable_directions),
                (StabilityVerdict::Unstable, 2),
                "seed {seed}, {ratio:e}"
            );
            continue;
        }
        assert_eq!(stability.verdict, StabilityVerdict::Stable, "seed {seed}, {ratio:e}");
        let stretched = length + 10.0 * mass / stiffness;
        let expected = (10.0 / stretched).sqrt() / TAU;
        for mode in &stability.modes[..2] {
            let error = (mode.frequency_hz / expected - 1.0).abs();
            // Half of what is known of the tension, and what the eigenvalues of a matrix of that condition lose.
            assert!(error < 1e-9 + 50.0 * f64::EPSILON * ratio, "seed {seed}, {ratio:e}: {error:e}");
            most = most.max(error);
        }
    }
    assert!(most > 0.0);
}

/// A ball between two springs without tension, in line: sideways the potential is k y⁴/(4 L²) each, without stiffness, wherever the
/// search stops. Turned in space the terms that cancel are of all sizes.
#[test]
fn what_has_no_stiffness_stays_neutral_beside_any() {
    for seed in 0..30 {
        let random = &mut Random::new(seed);
        let (length, stiffness) = (random.between(0.5, 2.0), 10_f64.powf(random.between(0.0, 10.0)));
        let down = direction(random);
        let mut text = ball(1.0, length, stiffness, down, false, "").replacen("gravity = [", "#", 1);
        text = format!("gravity = [0, 0, 0]\n{text}");
        let far: Vec<f64> = down.iter().map(|x| 2.0 * length * x).collect();
        text += &format!(
            "[[force]]\nname = \"other\"\ntype = \"spring\"\nbetween = [{{ body = \"ground\", at = {far:?} }}, \"n\"]\n\
             stiffness = {stiffness:?}\nlength = {length:?}\n"
        );
        let found = rest(&text);
        let stability = found.stability.expect("a verdict");
        assert_eq!(
            (stability.verdict, stability.neutral_directions),
            (StabilityVerdict::Neutral, 2),
            "seed {seed}: {:?}",
            found.notes
        );
    }
}
