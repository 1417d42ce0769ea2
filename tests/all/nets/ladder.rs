//! Long ladders of four-bars: each loop closes with an error of its own, and the search has to see past the sum of them.

use std::fmt::Write;
use stillpoint::scenario;
use stillpoint::statics::{StabilityVerdict, equilibrium};

/// The numbers of `benches/peers/nets.py` (xorshift).
fn random(state: &mut u64) -> f64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 11) as f64 / (1_u64 << 53) as f64
}

/// Parallelograms side by side that share their cranks; each crank stands on a spring. The scene `ladder` of `benches/peers/nets.py`.
fn ladder(count: usize) -> String {
    let (lean, mut state, mut text) = (std::f64::consts::FRAC_PI_2 + 0.3, 5, String::new());
    let bar = |text: &mut String, name: &str, length: f64, hinge: &str, angle: f64| {
        let across = length.powi(3) / 12.0 + length * 1e-3;
        let _ = writeln!(
            text,
            "[[body]]\nname = \"{name}\"\nmass = {length:?}\ncenter = [{:?}, 0.0, 0.0]\ninertia = [0.001, {across:?}, {across:?}]\n\
             markers = {{ end = [{length:?}, 0.0, 0.0] }}\n\
             hinge = {{ type = \"revolute\", {hinge}, axis = [0.0, -1.0, 0.0], position = {angle:?} }}",
            0.5 * length
        );
    };
    for i in 0..=count {
        let foot = 2.0 * i as f64;
        bar(&mut text, &format!("crank{i}"), 1.0, &format!("at = [{foot:?}, 0.0, 0.0]"), lean);
        if i > 0 {
            let hinge = format!("parent = \"crank{}\", at = \"end\"", i - 1);
            bar(&mut text, &format!("rung{i}"), 2.0, &hinge, -lean);
            let _ = writeln!(
                text,
                "[[loop]]\ntype = \"revolute\"\nbetween = [\"rung{i}.end\", \"crank{i}.end\"]\naxis = [0.0, 1.0, 0.0]"
            );
        }
        let (stiffness, length) = (5.0 + 25.0 * random(&mut state), 0.2 + random(&mut state));
        let _ = writeln!(
            text,
            "[[force]]\ntype = \"spring\"\nbetween = [\"crank{i}.end\", {{ body = \"ground\", at = [{:?}, 0.0, 1.2] }}]\n\
             stiffness = {stiffness:?}\nlength = {length:?}",
            foot - 1.0
        );
    }
    text
}

/// Of every length, in a few steps.
#[test]
fn a_long_ladder_takes_the_steps_of_a_short_one() {
    for count in [100, 4000, 5000] {
        let scenario = scenario::parse("ladder.toml", &ladder(count), &[]).unwrap_or_else(|found| panic!("{found}"));
        let (model, _) = scenario.clone().built.take().expect("a sound scene");
        let found = equilibrium(&model, &scenario.statics, &model.start_position).expect("no fault");
        let verdict = found.stability.as_ref().map(|stability| stability.verdict);
        assert!(found.converged && verdict == Some(StabilityVerdict::Stable), "{count}: {:?}", found.notes);
        assert!(found.iterations < 20, "{count}: {} steps", found.iterations);
    }
}
