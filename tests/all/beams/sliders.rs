//! Points that slide along beams: against closed forms, what they keep, and what is wrong with them.

use crate::common::build;
use nalgebra::Vector3;
use std::f64::consts::PI;
use stillpoint::dynamics::{MassAction, System};
use stillpoint::model::Model;
use stillpoint::record::{Memory, Opening};
use stillpoint::scenario::{Override, Scenario, parse};
use stillpoint::simulate::events::Kind;
use stillpoint::simulate::{State, Summary, run};
use stillpoint::statics::{Settings, equilibrium};

fn read(file: &str, changes: &[String]) -> Scenario {
    let path = format!("{}/scenarios/{file}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).expect("a shipped scenario");
    let changes: Vec<_> = changes.iter().map(|text| Override::parse(text).expect("a change")).collect();
    parse(file, &text, &changes).unwrap_or_else(|why| panic!("{why}"))
}

/// Runs from a state; the samples have the outputs of the scenario.
fn ran(scenario: &Scenario, model: &std::sync::Arc<Model>, start: &State) -> (Summary, Memory) {
    let still = stillpoint::simulate::scene(model);
    let mut memory = Memory::new(&Opening { scene: &still, scenario: &scenario.text, statics: None });
    let summary = run(model, &scenario.simulate, 200.0, start, &mut memory, &mut |_, _| true).expect("a run");
    (summary, memory)
}

fn given(model: &Model) -> State {
    State { position: model.start_position.clone(), velocity: model.start_velocity.clone() }
}

/// The deck of the shipped bridge.
const SPAN: f64 = 20.0;
const LOAD: f64 = 1e5;
const BENDING: f64 = 4e8;
const PER_LENGTH: f64 = 800.0;

/// A load at rest anywhere on a beam on two bearings: `w = F b x (l² − b² − x²)/(6 EI l)` in the middle, x = l/2, b the distance to the
/// far bearing of a load beyond it.
#[test]
fn a_load_at_rest_bends_a_bridge_by_the_closed_form() {
    for at in [4.0, 8.0, 10.0, 11.3, 16.0, 19.0] {
        let changes = [format!("trolley.hinge.position[0]={at}"), "trolley.hinge.velocity=[0,0,0]".to_owned()];
        let mut scenario = read("beams/moving_load.toml", &changes);
        scenario.description.drives[0].motion = stillpoint::model::couplings::MotionDescription::Hold;
        let model = build(&scenario.description);
        let found = equilibrium(&model, &Settings::default(), &model.start_position).expect("statics");
        assert!(found.converged, "{at}: {:?}", found.notes);
        let mut system = System::new(&model);
        let still = vec![0.0; model.velocity_count()];
        let evaluated = system.at(0.0, &found.position, &still);
        let middle = evaluated.motion().links[model.beams[0].elements[1].link].position.z;
        // By symmetry the load is beyond the middle.
        let beyond = if at < SPAN / 2.0 { SPAN - at } else { at };
        let (b, x) = (SPAN - beyond, SPAN / 2.0);
        let expected = -LOAD * b * x * (SPAN * SPAN - b * b - x * x) / (6.0 * BENDING * SPAN);
        // Under a load between the ends of an element of length h a beam gives way by up to P h³/(192 EI) too little, with four elements 1 in 256 of
        // the most that its middle does; the middle is a node, where that is felt the less.
        assert!((middle - expected).abs() < 2e-3 * expected.abs(), "{at}: {middle} {expected}");
    }
}

/// A force that rolls over the bridge (Frýba 1972): by how much its middle gives way at any time.
fn moving_force(speed: f64, t: f64) -> f64 {
    let frequency = |j: f64| (j * PI / SPAN).powi(2) * (BENDING / PER_LENGTH).sqrt();
    let (turn, first) = (PI * speed / SPAN, frequency(1.0));
    let part = turn / first;
    let of = |j: f64| {
        let shape = (j * turn * t).sin() - part / j * (frequency(j) * t).sin();
        shape * (j * PI / 2.0).sin() / (j * j * (j * j - part * part))
    };
    let sum: f64 = (1..40).map(|j| of(f64::from(j))).sum();
    -2.0 * LOAD * SPAN.powi(3) / (PI.powi(4) * BENDING) * sum
}

#[test]
fn a_load_that_rolls_over_a_bridge_bends_it_as_fryba_says() {
    for speed in [40.0] {
        let changes = [
            "simulate.tolerance=1e-4".to_owned(),
            format!("trolley.hinge.velocity[0]={speed}"),
            format!("haul.rate={speed}"),
            format!("simulate.duration={}", 0.98 * SPAN / speed),
        ];
        let scenario = read("beams/moving_load.toml", &changes);
        let model = build(&scenario.description);
        let (_, memory) = ran(&scenario, &model, &given(&model));
        let (mut worst, mut most) = (0.0_f64, 0.0_f64);
        for sample in &memory.samples {
            let expected = moving_force(speed, sample.time);
            worst = worst.max((sample.outputs[2] - expected).abs());
            most = most.max(expected.abs());
        }
        // The trolley has a thousandth of the mass of the deck below it, and rides on a spring.
        assert!(worst < 0.01 * most, "{speed} m/s: {worst:e} of {most:e}");
    }
}

/// From a rigid tube a rocket tips off about its aft shoe: under gravity alone at a constant speed g a b/(v (k² + a²)).
#[test]
fn a_rocket_tips_off_a_rigid_tube_by_the_closed_form() {
    let changes = |speed: f64| {
        [
            "tube.material.young=210e12".to_owned(),
            "simulate.integrator=radau9".to_owned(),
            "thrust.force=[0,0,0]".to_owned(),
            "simulate.start=given".to_owned(),
            format!("simulate.duration={}", 2.05 / speed),
            "rocket.hinge.position=[2.0,0,0]".to_owned(),
            format!("rocket.hinge.velocity=[{speed},0,0]"),
        ]
    };
    for speed in [30.0, 60.0] {
        let mut scenario = read("stages/flexible_tube.toml", &changes(speed));
        // Let go from the beginning.
        scenario.description.loops.clear();
        scenario.description.stages.clear();
        // Its shoes bear it from the beginning, too: half of its weight each.
        let sag = 66.0 * G / 2.0 / 5e6;
        scenario.description.bodies[0].hinge.position[1] = -sag;
        let model = build(&scenario.description);
        let (summary, _) = ran(&scenario, &model, &given(&model));
        let told: Vec<_> = summary.events.iter().map(|event| (event.kind, event.name.as_str())).collect();
        assert_eq!(told, [(Kind::Force("exit"), "fore shoe"), (Kind::Force("exit"), "aft shoe")]);
        let rate = *summary.state.velocity.get(2).expect("its turn");
        let expected = -G * 0.9 * 1.8 / (speed * (40.0 / 66.0 + 0.81));
        // The shoes give way: the rocket bounces on them, by the root of a deflection of a tenth of a millimetre against that of its fall.
        assert!((rate / expected - 1.0).abs() < 0.05, "{speed} m/s: {rate} {expected}");
    }
}

const G: f64 = 9.80665;

/// A rod and a ball that slides off it, both free: momentum, angular momentum and energy are kept.
#[test]
fn what_slides_off_a_free_rod_keeps_its_momentum() {
    let text = "gravity = [0, 0, 0]\n[simulate]\nduration = 1.0\ntolerance = 1e-9\nstart = \"given\"\n\
         [[beam]]\nname = \"rod\"\nhinge = { type = \"free\", velocity = [0, 0, 0, 0.1, 0.4, 0.3] }\nlength = 1.0\nelements = 3\n\
         section = { circle = 0.01 }\nmaterial = { young = 7e9, density = 2700.0, poisson = 0.3 }\nfree = [\"bend\"]\ndamping = 1e-3\n\
         [[body]]\nname = \"ball\"\nmass = 0.4\ninertia = [1e-3, 1e-3, 2e-3]\n\
         hinge = { type = \"free\", position = [0.3, 0.0, 0.02, 1, 0, 0, 0], velocity = [1.5, 0.0, 0.0, 0, 0, 1] }\n\
         [[force]]\nname = \"ring\"\ntype = \"slider\"\non = { body = \"ball\", at = [0, 0, -0.02] }\nalong = \"rod\"\nstiffness = 2e3\ndamping = 2.0\n";
    let scenario = parse("scene.toml", text, &[]).unwrap_or_else(|why| panic!("{why}"));
    let model = build(&scenario.description);
    let momentum = |state: &State| {
        let (mut system, mut action) = (System::new(&model), MassAction::new(&model));
        let mut of = vec![0.0; model.velocity_count()];
        let at = system.at(0.0, &state.position, &state.velocity);
        let links = at.motion().links.clone();
        system.at(0.0, &state.position, &state.velocity).mass_times(&mut action, &state.velocity, &mut of);
        // Per free hinge: linear, and about its own root marker in its own axes.
        let mut all = [Vector3::zeros(); 2];
        for body in &model.bodies[..2] {
            let link = &links[body.link];
            let first = model.links[body.link].velocity - 3;
            let part = |i: usize| Vector3::new(of[first + i], of[first + i + 1], of[first + i + 2]);
            all[0] += part(0);
            all[1] += link.position.cross(&part(0)) + link.turn * part(3);
        }
        all
    };
    let (summary, _) = ran(&scenario, &model, &given(&model));
    let [before, after] = [momentum(&given(&model)), momentum(&summary.state)];
    let left = summary.events.iter().filter(|event| event.kind == Kind::Force("exit")).count();
    assert_eq!(left, 1, "{:?}", summary.events);
    for (before, after) in before.iter().zip(&after) {
        assert!((before - after).norm() < 1e-7 * (1.0 + before.norm()), "{before} {after}");
    }
    assert!(summary.energy_drift.abs() < 1e-6 * summary.energy_start, "{:e}", summary.energy_drift);
}

/// Between the ends of an element, too, the moment is that of a beam on two bearings: `F b s/l` before the load, `F a (l − s)/l` beyond it; the error that
/// is told is about that of the moment.
#[test]
fn a_beam_bears_what_it_should_under_a_point_within_an_element() {
    for (elements, at) in [(2, 3.1), (4, 6.7), (8, 3.1)] {
        let text = format!(
            "gravity = [0, 0, 0]\n[[beam]]\nname = \"deck\"\nhinge = {{ type = \"revolute\", axis = [0, 1, 0] }}\nlength = 10.0\nelements = {elements}\n\
             section = {{ stiffness = [1e10, 1e10, 1e10, 1e6, 4e6, 4e6] }}\nmass_per_length = 1.0\nfree = [\"bend\"]\n\
             [[loop]]\nname = \"bearing\"\ntype = \"rod\"\nbetween = [{{ body = \"ground\", at = [10, 0, -1000] }}, \"deck.tip\"]\nlength = 1000.0\n\
             [[body]]\nname = \"load\"\nmass = 1.0\nhinge = {{ type = \"prismatic\", axis = [0, 0, 1], at = [{at}, 0, 0], force = -50.0 }}\n\
             [[force]]\nname = \"foot\"\ntype = \"slider\"\non = \"load\"\nalong = \"deck\"\nstiffness = 1e6\n"
        );
        let moments: Vec<f64> = (1..20).map(|k| f64::from(k) / 2.0).filter(|s| (s - at).abs() > 1e-9).collect();
        let outputs: String = moments
            .iter()
            .map(|s| {
                format!("[[output]]\nname = \"m{s}\"\ntype = \"section\"\nof = \"deck\"\ns = {s}\ncomponent = \"my\"\n")
            })
            .collect();
        let scenario = parse("scene.toml", &format!("{text}{outputs}"), &[]).unwrap_or_else(|why| panic!("{why}"));
        let model = build(&scenario.description);
        let found = equilibrium(&model, &Settings::default(), &model.start_position).expect("statics");
        assert!(found.converged, "{:?}", found.notes);
        let told = stillpoint::statics::outputs(&model, &found).expect("numbers");
        let most = 50.0 * at * (10.0 - at) / 10.0;
        for (s, told) in moments.iter().zip(&told) {
            let expected = if *s < at { 50.0 * (10.0 - at) * s / 10.0 } else { 50.0 * at * (10.0 - s) / 10.0 };
            assert!((told.abs() - expected).abs() < 1e-3 * most, "{elements} elements, {at}, {s}: {told} {expected}");
        }
        let error = stillpoint::statics::beams(&model, &found).expect("a state")[0].error.forces;
        assert!(error > 0.2 / f64::from(elements) / 10.0 && error < 0.3, "{elements} elements: {error}");
    }
}

/// Every bad slider is refused with its line, and the caret on what is bad.
#[test]
fn bad_sliders_are_shown_where_they_are() {
    let beam = "[[beam]]\nname = \"tube\"\nhinge = { type = \"fixed\" }\nlength = 1.0\nsection = { stiffness = [1, 1, 1, 1, 1, 1] }\n\
        mass_per_length = 1.0\n[[body]]\nname = \"bob\"\nmass = 1.0\nhinge = { type = \"planar\" }\n[[force]]\nname = \"shoe\"\n\
        type = \"slider\"\n";
    for (text, message, place) in [
        ("on = \"bob\"\nalong = \"tub\"\nstiffness = 1.0\n", "did you mean `tube`?", "15:9"),
        ("on = \"bob\"\nalong = \"bob\"\nstiffness = 1.0\n", "no beam or cable `bob`", "15:9"),
        ("on = \"tube.tip\"\nalong = \"tube\"\nstiffness = 1.0\n", "is on it, too", "14:6"),
        ("on = \"bob\"\nalong = \"tube\"\nstiffness = 0.0\n", "allowed: > 0 N/m", "16:13"),
        ("on = \"bob\"\nalong = \"tube\"\nstiffness = 1.0\ndamping = -1.0\n", "allowed: ≥ 0", "17:11"),
        ("on = \"bob\"\nalong = \"tube\"\n", "`stiffness` is missing", "11:1"),
    ] {
        let found = match parse("scene.toml", &format!("{beam}{text}"), &[]) {
            Ok(scenario) => format!("{:?}", Model::build(&scenario.description).err()),
            Err(found) => found.to_string(),
        };
        assert!(found.contains(message) && found.contains(&format!("scene.toml:{place}")), "{text}\n{found}");
    }
    let moved = |at: &str| {
        format!(
            "{}on = \"bob\"\nalong = \"tube\"\nstiffness = 1.0\n",
            beam.replace(
                "mass = 1.0\nhinge = { type = \"planar\"",
                &format!("mass = 1.0\ninertia = [0.1, 0.1, 0.1]\nhinge = {{ type = \"planar\", position = {at}")
            )
        )
    };
    for (at, warned) in [
        ("[-0.5, 0, 0]", "beyond the end of `tube`"),
        ("[0.5, 0.4, 0]", "0.4 m beside the axis"),
        ("[0.5, 0.05, 0]", ""),
    ] {
        let scenario = parse("scene.toml", &moved(at), &[]).unwrap_or_else(|why| panic!("{why}"));
        let told = scenario.warnings.to_string();
        assert_ne!(told.contains("`shoe`"), warned.is_empty(), "{at}: {told}");
        assert!(told.contains(warned), "{at}: {told}");
    }
}
