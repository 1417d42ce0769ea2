//! Long ladders of four-bars: each loop closes with an error of its own, and the search has to see past the sum of them.

use crate::common::relative_difference;
use std::fmt::Write;
use std::time::{Duration, Instant};
use stillpoint::dynamics::System;
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

/// A ladder on one rail: each rung hangs on the rail, and the piece of the other rail between two rungs closes a loop of four. The guess
/// leaves them open by `lean` (rad).
fn on_one_rail(count: usize, lean: f64) -> String {
    let mut text = String::new();
    let mut body = |name: &str, center: [f64; 3], hinge: &str| {
        let _ = writeln!(
            text,
            "[[body]]\nname = \"{name}\"\nmass = 1.0\ncenter = {center:?}\ninertia = [0.1, 0.1, 0.05]\n\
             hinge = {{ type = \"revolute\", axis = [0.0, 1.0, 0.0], {hinge} }}"
        );
    };
    for i in 0..count {
        let parent = if i == 0 { "\"ground\"".to_owned() } else { format!("\"rail{}\"", i - 1) };
        let at = if i == 0 { 0.0 } else { -1.0 };
        let lean = if i == 0 { lean } else { 0.0 };
        body(
            &format!("rail{i}"),
            [0.0, 0.0, -0.5],
            &format!("parent = {parent}, at = [0.0, 0.0, {at:?}], position = {lean:?}"),
        );
        body(&format!("rung{i}"), [0.25, 0.0, 0.0], &format!("parent = \"rail{i}\", at = [0.0, 0.0, -1.0]"));
        body(&format!("post{i}"), [0.0, 0.0, 0.5], &format!("parent = \"rung{i}\", at = [0.5, 0.0, 0.0]"));
    }
    for i in 0..count {
        let above = if i == 0 { "ground".to_owned() } else { format!("rung{}", i - 1) };
        let _ = writeln!(
            text,
            "[[loop]]\ntype = \"revolute\"\naxis = [0.0, 1.0, 0.0]\n\
             between = [{{ body = \"post{i}\", at = [0.0, 0.0, 1.0] }}, {{ body = \"{above}\", at = [0.5, 0.0, 0.0] }}]"
        );
    }
    text
}

/// All loops of such a ladder meet in the products of its rows with the inertia, as these stand on one tree. Nothing makes these
/// products: four times as many rungs do not take four to the power of three times as long. They hang straight down.
#[test]
fn a_ladder_on_one_rail_takes_no_products_of_all_its_loops() {
    let taken = |count: usize| {
        let run = || {
            let begin = Instant::now();
            let text = on_one_rail(count, 0.1);
            let scenario = scenario::parse("rail.toml", &text, &[]).unwrap_or_else(|found| panic!("{found}"));
            let (model, assembly) = scenario.clone().built.take().expect("a sound scene");
            let found = equilibrium(&model, &scenario.statics, &model.start_position).expect("no fault");
            let verdict = found.stability.as_ref().map(|stability| stability.verdict);
            assert!(found.converged && verdict == Some(StabilityVerdict::Stable), "{count}: {:?}", found.notes);
            assert!(found.iterations < 10, "{count}: {} steps", found.iterations);
            assert_eq!(assembly.degrees_of_freedom, count);
            assert!(found.position.iter().all(|angle| angle.abs() < 1e-6), "{count}: {:?}", found.position);
            begin.elapsed()
        };
        (0..3).map(|_| run()).min().unwrap_or(Duration::MAX).as_secs_f64()
    };
    let [few, many] = [75, 300].map(taken);
    // Twice as fast as the square. The products took 40 times as long.
    assert!(many < 16.0 * few, "{few} s, {many} s");
}

/// The accelerations that eliminate each multiplier where its loop closes are those by the products of all rows: with loops to the
/// ground, a drive, a gear, springs and velocities.
#[test]
fn multipliers_of_short_loops_are_those_of_all_rows() {
    for lean in [0.0, 0.3] {
        let mut text = on_one_rail(80, lean);
        text += "[[drive]]\nname = \"motor\"\nhinge = \"rail7\"\ntype = \"expression\"\nexpression = \"0.02*sin(3*t)\"\n\
                 [[body]]\nname = \"wheel\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
                 hinge = { type = \"revolute\", parent = \"rung11\", axis = [0.0, 1.0, 0.0] }\n\
                 [[gear]]\ntype = \"ratio\"\nbetween = [\"wheel\", \"post11\"]\nratio = -1.5\n\
                 [[force]]\ntype = \"spring\"\nstiffness = 70.0\nlength = 0.3\n\
                 between = [{ body = \"post40\", at = [0.1, 0.0, 0.0] }, { body = \"ground\", at = [2.0, 0.0, -30.0] }]\n";
        let scenario = scenario::parse("rail.toml", &text, &[]).unwrap_or_else(|found| panic!("{found}"));
        let (model, _) = scenario.clone().built.take().expect("a sound scene");
        let mut system = System::new(&model);
        let (q, v) = (&model.start_position, &model.start_velocity);
        let mut expected = v.clone();
        system.at(0.0, q, v).accelerations(&mut expected).expect("accelerations");
        let multipliers = system.constraints().expect("loops").multipliers().to_vec();
        let mut found = v.clone();
        system.at(0.0, q, v).accelerations_alone(&mut found).expect("accelerations");
        let error = relative_difference(&found, &expected);
        let of_loops = relative_difference(system.constraints().expect("loops").multipliers(), &multipliers);
        // Both are the round-off of eighty rungs on each other.
        assert!(error < 1e-8 && of_loops < 1e-8, "{lean}: {error} {of_loops}");
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
