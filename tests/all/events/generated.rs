//! Random scenes between stops: none is passed at any sample, step or event, no blow gains energy, and every run ends.
//!
//! `EVENT_CASES=1000` tries more of them.

use super::{go_watched, of};
use crate::common::{Random, build};
use std::fmt::Write;
use std::sync::Arc;
use stillpoint::model::{Model, StopLaw};
use stillpoint::record::Memory;
use stillpoint::scenario::Scenario;
use stillpoint::simulate::events::Kind;
use stillpoint::simulate::{Integrator, Summary};

/// A stop is kept to this (m or rad): the program's own bound, 10⁻⁹ of a radian or of the scene's length.
const KEPT: f64 = 1e-9;

pub(super) fn cases(usual: u64) -> u64 {
    std::env::var("EVENT_CASES").map_or(usual, |cases| cases.parse().expect("EVENT_CASES is a number"))
}

/// What stops the hinges of a chain.
#[derive(Clone, Copy, PartialEq)]
enum Between {
    Walls,
    Pads,
    /// Some of each, the pads stiff.
    Both,
}

/// A chain of links between limits ±0.2 rad, each with a coefficient of restitution of its own; some start on a limit.
fn chain(random: &mut Random, links: usize, between: Between, duration: f64) -> String {
    let mut text = format!("[record]\nrate = 300.0\n[simulate]\nstart = \"given\"\nduration = {duration}\n");
    let methods = ["auto", "adams", "dop853", "dopri5", "radau9", "sdirk4"];
    let tolerance = ["1e-6", "1e-8", "1e-10"][random.below(3)];
    let _ = writeln!(text, "integrator = \"{}\"\ntolerance = {tolerance}", methods[random.below(methods.len())]);
    for link in 0..links {
        let mass = random.between(0.3, 2.0);
        let between = match between {
            Between::Both if random.below(2) == 0 => Between::Walls,
            between => between,
        };
        let stop = match between {
            Between::Walls if random.below(4) == 0 => "restitution = 0.0".to_owned(),
            Between::Walls => format!("restitution = {}", random.between(0.0, 0.9)),
            Between::Pads => {
                let (stiffness, damping) = (random.between(100.0, 1e4), random.between(0.0, 2.0));
                format!("stiffness = {stiffness}, damping = {damping}")
            }
            Between::Both => {
                let damping = [0.0, 10.0, 100.0][random.below(3)];
                format!("stiffness = {}, damping = {damping}", 10_f64.powf(random.between(4.0, 7.0)))
            }
        };
        let position = match random.below(8) {
            0 => 0.2,
            1 => -0.2,
            _ => random.between(-0.2, 0.2),
        };
        let velocity = if random.below(2) == 0 { 0.0 } else { random.between(-2.0, 2.0) };
        let axis = if link == 0 || random.below(3) > 0 { "[0, 1, 0]" } else { "[1, 0, 0]" };
        let (parent, at) = if link == 0 { ("ground".to_owned(), 0.0) } else { (format!("l{}", link - 1), 0.2) };
        let _ = write!(
            text,
            "[[body]]\nname = \"l{link}\"\nmass = {mass}\ncenter = [0.1, 0, 0]\n\
             inertia = [{}, {}, {}]\nhinge = {{ type = \"revolute\", parent = \"{parent}\", at = [{at}, 0, 0], axis = {axis}, \
             position = {position}, velocity = {velocity}, limits = {{ low = -0.2, high = 0.2, {stop} }} }}\n",
            1e-3 * mass,
            3.3e-3 * mass,
            3.3e-3 * mass
        );
    }
    text
}

/// The account of a run that nothing puts energy into.
pub(super) fn check(
    seed: u64,
    scenario: &Scenario,
    model: &Model,
    (summary, memory, deepest): &(Summary, Memory, f64),
) {
    let case = || format!("seed {seed}: {}", scenario.text);
    assert_eq!(summary.end_time, scenario.simulate.duration, "{}", case());
    let rigid = || model.stops.iter().filter(|stop| matches!(stop.law, StopLaw::Rigid { .. }));
    let mut worst = *deepest;
    for sample in &memory.samples {
        for stop in rigid() {
            let value = sample.positions[stop.position];
            worst = worst.max(value - stop.range[1]).max(stop.range[0] - value);
        }
    }
    assert!(worst <= KEPT, "{worst:e} beyond a stop, {}", case());
    // What the method has wrong: with tolerances of 1e-6 some thousand steps add up.
    let size = summary.energy_start.abs() + summary.dissipated + 1.0;
    let slack = (1e3 * scenario.simulate.tolerance).max(1e-7) * size;
    assert!(summary.energy_drift < slack, "{:e} lost, {}", summary.energy_drift, case());
    let mut energies = memory.samples.iter().map(|sample| sample.energy);
    let first = energies.next().expect("a sample");
    let mut before = first;
    for energy in energies {
        assert!(energy.kinetic + energy.potential <= first.kinetic + first.potential + slack, "{}", case());
        // What is booked is a difference of sums of this size.
        let fallen = before.dissipated - energy.dissipated;
        assert!(fallen <= 1e-12 * size, "dissipated falls by {fallen:e} J, {}", case());
        before = energy;
    }
}

pub(super) fn read(text: &str) -> (Scenario, Arc<Model>) {
    let scenario = stillpoint::scenario::parse("scene.toml", text, &[]).unwrap_or_else(|found| panic!("{found:?}"));
    let model = build(&scenario.description);
    (scenario, model)
}

pub(super) fn run_all(cases: u64, text: impl Fn(&mut Random) -> String) -> usize {
    let mut events = 0;
    for seed in 0..cases {
        let (scenario, model) = read(&text(&mut Random::new(seed)));
        let run =
            go_watched(&scenario, &model).unwrap_or_else(|error| panic!("seed {seed}: {error}\n{}", scenario.text));
        check(seed, &scenario, &model, &run);
        events += run.0.events.len();
    }
    events
}

#[test]
fn no_stop_is_passed_in_chains_of_two_to_eight_links() {
    let events = run_all(cases(200), |random| {
        let links = 2 + random.below(7);
        chain(random, links, Between::Walls, 0.5)
    });
    assert!(events > 1000, "{events}");
}

#[test]
fn chains_between_pads_keep_their_account() {
    run_all(cases(40), |random| {
        let links = 2 + random.below(4);
        chain(random, links, Between::Pads, 0.4)
    });
}

/// A rebound that is slower than the interpolant is exact between two points in time must not be taken for another blow.
#[test]
fn stiff_pads_beside_rebounds_make_no_storm_of_events() {
    for seed in 0..cases(12) {
        let mut random = Random::new(seed);
        let links = 3 + random.below(2);
        let text = chain(&mut random, links, Between::Both, 0.5);
        let of = |method: &str| {
            let (mut scenario, model) = read(&text);
            scenario.simulate.integrator = Integrator::named(method).expect("a method");
            scenario.simulate.tolerance = 1e-7;
            let run =
                go_watched(&scenario, &model).unwrap_or_else(|error| panic!("seed {seed}, {method}: {error}\n{text}"));
            check(seed, &scenario, &model, &run);
            run.0
        };
        // Explicit steps are the reference: their interpolant has the rates at both ends.
        let expected = of("dopri5");
        for method in ["radau5", "radau9", "sdirk4"] {
            let found = of(method);
            let (few, many) = (expected.events.len(), found.events.len());
            assert!(many <= 2 * few + 20, "seed {seed}, {method}: {many} events, dopri5 has {few}\n{text}");
        }
    }
}

/// The other path: a gear ties two coordinates of a chain, whose blows go through both.
#[test]
fn no_stop_is_passed_beside_gears() {
    run_all(cases(40), |random| {
        let links = 2 + random.below(4);
        let text = chain(random, links, Between::Walls, 0.4);
        let ratio = ["1.0", "-1.0", "0.5", "-2.0"][random.below(4)];
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        for line in lines.iter_mut().filter(|line| line.starts_with("hinge")).take(2) {
            let (head, tail) = line.split_once("position = ").expect("a position");
            let (_, limits) = tail.split_once("limits").expect("limits");
            *line = format!("{head}position = 0.0, limits{limits}");
        }
        lines.join("\n")
            + &format!("\n[[gear]]\nname = \"mesh\"\ntype = \"ratio\"\nratio = {ratio}\nbetween = [\"l1\", \"l0\"]\n")
    });
}

/// Masses on one line, each a stop for the next, some on springs that press them onto it.
fn stack(random: &mut Random, sprung: bool) -> String {
    let mut text = "[record]\nrate = 300.0\n[simulate]\nstart = \"given\"\nduration = 1.0\n".to_owned();
    for level in 0..2 + random.below(5) {
        let parent = if level == 0 { "ground".to_owned() } else { format!("m{}", level - 1) };
        let (mass, height) = (random.between(0.1, 3.0), [0.0, 0.3, random.between(0.0, 0.5)][random.below(3)]);
        let restitution = if random.below(3) == 0 { 0.0 } else { random.between(0.0, 0.9) };
        let spring = match sprung {
            true => format!(", stiffness = {}, damping = 0.1", 10_f64.powf(random.between(0.0, 5.0))),
            false => String::new(),
        };
        let _ = write!(
            text,
            "[[body]]\nname = \"m{level}\"\nmass = {mass}\nhinge = {{ type = \"prismatic\", parent = \"{parent}\", axis = \
             [0, 0, 1], position = {height}, limits = {{ low = 0.0, restitution = {restitution} }}{spring} }}\n"
        );
    }
    text
}

/// A blow drives the ones below onto stops that they touch already.
#[test]
fn no_stop_is_passed_in_stacks() {
    run_all(cases(40), |random| stack(random, false));
}

/// What falls together presses with nothing but round-off, and is not let go of again and again.
#[test]
fn no_stop_is_passed_in_sprung_stacks() {
    run_all(cases(40), |random| stack(random, true));
}

#[test]
fn what_rests_on_what_falls_is_let_go_of_once() {
    // Mass, height and stiffness.
    let levels = [
        [17.651071250936596, 0.5284911451702028, 355.7494816843878],
        [15.291610164689677, 0.7793396723977875, 941.4017942417763],
        [3.2349779097997127, 0.4085780468959439, 15863.966301616168],
        [1.3063923619449471, 0.7241634885127678, 66119.50739098094],
        [28.913953687114184, 0.0, 1409.9855544846828],
    ];
    let mut text = "[record]\nrate = 50.0\n[simulate]\nstart = \"given\"\nduration = 0.51\n".to_owned();
    for (level, [mass, height, stiffness]) in levels.iter().enumerate() {
        let parent = if level == 0 { "ground".to_owned() } else { format!("m{}", level - 1) };
        let _ = write!(
            text,
            "[[body]]\nname = \"m{level}\"\nmass = {mass:?}\nhinge = {{ type = \"prismatic\", parent = \"{parent}\", axis = \
             [0, 0, 1], position = {height:?}, limits = {{ low = 0.0, restitution = 0.5 }}, stiffness = {stiffness:?}, damping = \
             0.1 }}\n"
        );
    }
    let (scenario, model) = read(&text);
    let run = go_watched(&scenario, &model).unwrap_or_else(|error| panic!("{error}"));
    check(0, &scenario, &model, &run);
    assert!(run.0.events.len() < 2000, "{} events", run.0.events.len());
}

/// Balls let go at equal heights land in one blow, each as if it were alone.
#[test]
fn balls_dropped_together_land_together() {
    for stop in ["restitution = 0.7", "stiffness = 1e5, damping = 10.0", "restitution = 0.0"] {
        let ball = |name: usize| {
            format!(
                "[[body]]\nname = \"b{name}\"\nmass = {}.0\nhinge = {{ type = \"prismatic\", axis = [0, 0, 1], \
                 position = 1.0, limits = {{ low = 0.0, {stop} }} }}\n",
                1 + name
            )
        };
        let all: String = (0..4).map(ball).collect();
        let text = format!("simulate = {{ start = \"given\", duration = 2.0 }}\n{all}");
        let (scenario, model) = read(&text);
        let run = go_watched(&scenario, &model).unwrap_or_else(|error| panic!("{stop}: {error}"));
        check(0, &scenario, &model, &run);
        let first = of(&run.0, "b0")[0];
        assert!((first.time - (2.0 / 9.80665_f64).sqrt()).abs() < 1e-9);
        for name in ["b1", "b2", "b3"] {
            assert_eq!((of(&run.0, name)[0].time, of(&run.0, name)[0].kind), (first.time, first.kind), "{stop}");
        }
        // Rigid stops know no mass.
        if stop.starts_with('r') {
            let state = &run.0.state.position;
            assert!(state.iter().all(|height| (height - state[0]).abs() < 1e-12), "{stop}: {state:?}");
        }
    }
}

/// A pendulum whose amplitude is beyond its limit by ever less touches it ever more softly; one that does not reach it
/// never does. Its step is longer than what lies beyond.
#[test]
fn grazing_is_seen_however_slight_it_is() {
    for method in ["dop853", "radau9", "rk4"] {
        for beyond in [-1e-6_f64, 1e-3, 1e-6, 1e-9] {
            let text = format!(
                "gravity = [0, 0, -9.81]\n[simulate]\nstart = \"given\"\nduration = 3.0\nintegrator = \"{method}\"\n\
                 tolerance = 1e-12\n[[body]]\nname = \"bob\"\nmass = 1.0\ncenter = [0, 0, -1]\n\
                 hinge = {{ type = \"revolute\", axis = [0, 1, 0], position = -0.5, \
                 limits = {{ low = -1.0, high = {}, restitution = 0.5 }} }}\n",
                0.5 - beyond
            );
            let (scenario, model) = read(&text);
            let run = go_watched(&scenario, &model).unwrap_or_else(|error| panic!("{error}"));
            check(0, &scenario, &model, &run);
            let touches = of(&run.0, "bob");
            assert_eq!(touches.is_empty(), beyond < 0.0, "{method} {beyond:e}: {touches:?}");
            if beyond > 1e-8 {
                // ½ ω² = g (cos(½ − δ) − cos ½).
                let speed = (2.0 * 9.81 * ((0.5 - beyond).cos() - 0.5_f64.cos())).sqrt();
                assert!(
                    (touches[0].speed - speed).abs() < 1e-5 * speed + 1e-7 / speed,
                    "{method} {beyond:e}: {touches:?}"
                );
                assert_eq!(touches[0].kind, Kind::Impact);
            }
        }
    }
}

/// Speeds far below rounding make no blows, and a run of many accumulating ones ends.
#[test]
fn accumulating_blows_end_in_rest() {
    for restitution in [0.3, 0.9, 0.99] {
        let text = format!(
            "simulate = {{ start = \"given\", duration = 3.0 }}\n[[body]]\nname = \"ball\"\nmass = 1.0\n\
             hinge = {{ type = \"prismatic\", axis = [0, 0, 1], position = 0.0, velocity = {}, \
             limits = {{ low = 0.0, restitution = {restitution} }} }}\n",
            9.80665 * 0.5 * (1.0 - restitution)
        );
        let (scenario, model) = read(&text);
        let run = go_watched(&scenario, &model).unwrap_or_else(|error| panic!("{error}"));
        check(0, &scenario, &model, &run);
        let last = run.0.events.last().expect("events");
        assert_eq!(last.kind, Kind::Rest);
        // 2 v/g (1 + e + e² + …) = 1; what is left of the sequence below the speed of rest, and the rounding of each time.
        assert!((last.time - 1.0).abs() < 1e-6 / (1.0 - restitution), "{restitution}: {last:?}");
        assert_eq!((run.0.state.position[0], run.0.state.velocity[0]), (0.0, 0.0));
    }
}
