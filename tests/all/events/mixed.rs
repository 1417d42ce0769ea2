//! Rigid stops with restitution beside compliant ones, soft and stiff, damped or not: the account, and that every run ends.
//!
//! `EVENT_CASES=1000` tries more of them.

use super::generated::{cases, read, run_all};
use super::{go_watched, of, run};
use crate::common::Random;
use std::fmt::Write;
use stillpoint::simulate::events::Kind;

/// A stop of any kind for a coordinate of this inertia (kg or kg m²); damping up to beyond critical.
fn stop(random: &mut Random, inertia: f64, softest: f64) -> String {
    match random.below(4) {
        0 => "restitution = 0.0".to_owned(),
        1 => format!("restitution = {}", random.between(0.0, 0.9)),
        kind => {
            let stiffness = softest * 10.0_f64.powf(random.between(0.0, 5.0));
            let ratio = if kind == 2 { 0.0 } else { random.between(0.0, 1.5) };
            format!("stiffness = {stiffness}, damping = {}", 2.0 * ratio * (stiffness * inertia).sqrt())
        }
    }
}

/// A method, with a step a twentieth of the fastest period's radian where it needs one.
fn method(random: &mut Random) -> String {
    let methods = ["auto", "dop853", "dopri5", "radau5", "radau9", "sdirk4"];
    let tolerance = ["1e-6", "1e-8", "1e-10"][random.below(3)];
    format!("integrator = \"{}\"\ntolerance = {tolerance}\n", methods[random.below(methods.len())])
}

/// Masses on one line, each on a stop of the one below; many start at rest on each other or at equal heights.
#[test]
fn stacks_of_pads_and_walls_keep_their_account() {
    run_all(cases(120), |random| {
        let mut text =
            "[record]\nrate = 300.0\n[simulate]\nstart = \"given\"\nduration = 1.0\n".to_owned() + &method(random);
        for level in 0..1 + random.below(5) {
            let parent = if level == 0 { "ground".to_owned() } else { format!("m{}", level - 1) };
            let mass = if random.below(2) == 0 { 1.0 } else { random.between(0.1, 3.0) };
            let height = [0.0, 0.2, random.between(0.0, 0.5)][random.below(3)];
            let velocity = [0.0, random.between(-2.0, 2.0)][random.below(2)];
            let stop = stop(random, mass, 1e3);
            let _ = write!(
                text,
                "[[body]]\nname = \"m{level}\"\nmass = {mass}\nhinge = {{ type = \"prismatic\", parent = \"{parent}\", \
                 axis = [0, 0, 1], position = {height}, velocity = {velocity}, limits = {{ low = 0.0, {stop} }} }}\n"
            );
        }
        text
    });
}

/// A shaken mass leaves its pad before that is relaxed and meets it again before that, too: what the pad still holds
/// is spent on its damper only as far as the mass has gone.
#[test]
fn a_pad_that_is_met_again_before_it_is_relaxed_gives_back_no_energy() {
    let mut again = 0;
    for seed in 0..cases(40) {
        let mut random = Random::new(seed);
        let (stiffness, damping) = (random.between(500.0, 5e3), random.between(50.0, 500.0));
        let (force, pace) = (random.between(50.0, 400.0), random.between(20.0, 200.0));
        let method = ["dop853", "dopri5", "radau5", "radau9", "sdirk4", "gauss", "rk4"][random.below(7)];
        let step = if matches!(method, "gauss" | "rk4") { "step = 2e-4" } else { "tolerance = 1e-9" };
        let text = format!(
            "gravity = [0, 0, -10]\n[record]\nrate = 5e3\n[simulate]\nstart = \"given\"\nduration = 0.5\n\
             integrator = \"{method}\"\n{step}\n[[body]]\nname = \"mass\"\nmass = 1.0\nhinge = {{ type = \"prismatic\", \
             axis = [0, 0, 1], velocity = -1.0, limits = {{ low = 0.0, stiffness = {stiffness}, damping = {damping} }} }}\n\
             [[motor]]\nname = \"shaker\"\nhinge = \"mass\"\ntype = \"expression\"\nexpression = \"{force}*sin({pace}*t)\"\n"
        );
        let (scenario, model) = read(&text);
        let (summary, memory, _) =
            go_watched(&scenario, &model).unwrap_or_else(|error| panic!("{seed}: {error}\n{text}"));
        let energies = || memory.samples.iter().map(|sample| sample.energy);
        let falls = energies().zip(energies().skip(1)).map(|(a, b)| a.dissipated - b.dissipated).fold(0.0, f64::max);
        let size = summary.dissipated + summary.work.abs() + 1.0;
        // The round-off of a sum of some thousand terms.
        assert!(falls <= 1e-13 * size, "seed {seed}: dissipated falls by {falls:e} J\n{text}");
        assert!(summary.energy_drift < 1e-6 * size, "seed {seed}: {:e}\n{text}", summary.energy_drift);
        for contact in of(&summary, "mass").iter().filter(|event| event.kind == Kind::Contact) {
            let before = memory.samples.iter().rev().find(|sample| sample.time < contact.time);
            again += usize::from(before.is_some_and(|sample| sample.positions[0] < -1e-6));
        }
    }
    assert!(again > 2, "met again {again} times");
}

/// Eighty bounces on: an impact is found to the rounding of its time, and that of the fall is 10⁻¹³ of it.
#[test]
fn late_impacts_are_as_exact_as_early_ones() {
    let (height, gravity, duration) = (10.0_f64, 9.81_f64, 400.0);
    for method in ["dop853", "dopri5", "sdirk4", "radau5", "radau9"] {
        let (summary, _) = run(&format!(
            "gravity = [0, 0, -{gravity}]\n[record]\nrate = 1.0\n[simulate]\nstart = \"given\"\nduration = {duration}\n\
             tolerance = 1e-9\nintegrator = \"{method}\"\n[[body]]\nname = \"ball\"\nmass = 1.0\nhinge = {{ \
             type = \"prismatic\", axis = [0, 0, 1], position = {height}, limits = {{ low = 0.0, restitution = 1.0 }} }}\n"
        ));
        let fall = (2.0 * height / gravity).sqrt();
        let bounces = of(&summary, "ball");
        assert_eq!(bounces.len(), ((duration / fall + 1.0) / 2.0) as usize, "{method}");
        let last = bounces.last().expect("bounces");
        let expected = (2.0 * bounces.len() as f64 - 1.0) * fall;
        // A tolerance of 1e-9, for the run and each of its 140 new beginnings.
        assert!((last.time - expected).abs() < 1e-7, "{method}: {} s, not {expected} s", last.time);
    }
}

/// A ball that gets all of its speed back, on a hinge with a damper and on one without: without one it rises for ever to where it was let go; beside
/// one its rises fade as `exp(−2/3 c/m t)`, and it is at rest once they are below the tolerance, some hundred or thousand impacts later.
#[test]
fn what_only_a_damper_ends_comes_to_rest() {
    for (method, height) in [("dop853", 0.1), ("radau9", 0.02), ("dopri5", 0.05)] {
        for damping in [0.0, 1.0, 5.0] {
            let (summary, _) = run(&format!(
                "[simulate]\nstart = \"given\"\nduration = 3.0\nintegrator = \"{method}\"\n[[body]]\nname = \"ball\"\nmass = 0.1\nhinge = {{ \
                 type = \"prismatic\", axis = [0, 0, 1], position = {height}, damping = {damping}, limits = {{ low = 0.0, restitution = 1.0 }} }}\n"
            ));
            let (impacts, at) = (of(&summary, "ball").len(), summary.state.position[0]);
            if damping == 0.0 {
                let fall = (2.0 * height / 9.80665_f64).sqrt();
                assert_eq!(impacts, ((3.0 / fall + 1.0) / 2.0) as usize, "{method}");
                continue;
            }
            assert!(
                impacts < 5000 && at == 0.0 && summary.state.velocity[0] == 0.0,
                "{method}: {impacts} impacts, at {at:e}"
            );
            assert!((summary.dissipated / summary.energy_start - 1.0).abs() < 1e-6, "{method}: {}", summary.dissipated);
        }
    }
}
