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

/// A chain of so many links of one length that hangs between two points, its far end held by as many equal loops.
fn hanging(links: usize, loops: usize) -> String {
    let (mut text, mut end, bend) = (String::new(), [0.0, 0.0], 1.2 / links as f64);
    let first = 0.5 * bend * (links as f64 - 1.0);
    for i in 0..links {
        let parent = if i == 0 { String::new() } else { format!("parent = \"link{}\", at = [1.0, 0.0, 0.0], ", i - 1) };
        let angle = if i == 0 { -first } else { bend };
        let _ = writeln!(
            text,
            "[[body]]\nname = \"link{i}\"\nmass = 1.0\ncenter = [0.5, 0.0, 0.0]\ninertia = [0.001, 0.1, 0.1]\n\
             hinge = {{ type = \"revolute\", {parent}axis = [0.0, -1.0, 0.0], position = {angle:?} }}"
        );
        let turned: f64 = -first + bend * i as f64;
        end = [end[0] + turned.cos(), end[1] + turned.sin()];
    }
    for _ in 0..loops {
        let _ = writeln!(
            text,
            "[[loop]]\ntype = \"revolute\"\naxis = [0.0, 1.0, 0.0]\nbetween = [{{ body = \"link{}\", at = [1.0, 0.0, 0.0] }}, \
             {{ body = \"ground\", at = [{:?}, 0.0, {:?}] }}]",
            links - 1,
            end[0],
            end[1]
        );
    }
    text
}

/// Equal loops share equally, whatever the metric is in which it is found how one depends on the other: loops over few links, and over
/// so many that their products with the inertia are not made.
#[test]
fn equal_loops_share_equally_at_any_length() {
    for links in [4, 12, 40, 90] {
        let carried = |loops: usize| {
            let text = hanging(links, loops);
            let scenario = scenario::parse("chain.toml", &text, &[]).unwrap_or_else(|found| panic!("{found}"));
            let (model, _) = scenario.clone().built.take().expect("a sound scene");
            let found = equilibrium(&model, &scenario.statics, &model.start_position).expect("no fault");
            assert!(found.converged, "{links} links: {:?}", found.notes);
            found.loops.iter().map(|one| one.force).collect::<Vec<_>>()
        };
        let alone = carried(1)[0];
        // By symmetry half of the weight.
        assert!((alone.z.abs() / (0.5 * links as f64 * 9.80665) - 1.0).abs() < 1e-6, "{links}: {alone}");
        for loops in [2, 3] {
            for force in carried(loops) {
                // The residual of both searches, times how far a long chain is from its own.
                assert!(
                    (force * loops as f64 - alone).norm() < 1e-6 * alone.norm(),
                    "{links}, {loops}: {force} {alone}"
                );
            }
        }
    }
}
