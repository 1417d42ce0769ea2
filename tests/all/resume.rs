//! Runs that are saved at their end and go on.

use crate::common::{Options, Random, build, random_scene};
use crate::scenarios::file;
use assert_cmd::Command;
use serde_json::Value;
use std::path::Path;
use std::sync::Arc;
use stillpoint::integrate::Method;
use stillpoint::model::Model;
use stillpoint::model::couplings::{CoordinateName, MotionDescription};
use stillpoint::model::description::*;
use stillpoint::model::motor::{MotorDescription, MotorLawDescription, TargetDescription};
use stillpoint::record::Fanout;
use stillpoint::scenario::start::{parse_start, text_at_end};
use stillpoint::simulate::{self, Integrator, Settings, State, Summary};

fn run(model: &Arc<Model>, settings: &Settings, state: &State) -> Summary {
    simulate::run(model, settings, 10.0, state, &mut Fanout::new(), &mut |_, _| true).unwrap()
}

fn fixed(duration: f64, step: f64) -> Settings {
    Settings { duration, step: Some(step), integrator: Integrator::Method(Method::Rk4), ..Settings::default() }
}

fn same(one: &State, other: &State) -> bool {
    let bits = |state: &State| state.position.iter().chain(&state.velocity).map(|x| x.to_bits()).collect::<Vec<_>>();
    bits(one) == bits(other)
}

/// Random scenes with quaternions, motors by the time and times that no step divides in binary: the same bits, through the
/// text of a file.
#[test]
fn fixed_steps_go_on_bit_for_bit() {
    let mut cases = 0;
    for seed in 0..60 {
        let options = Options { bodies: 1 + seed as usize % 6, springs: true, welds: true };
        let mut scene = random_scene(seed + 400, &options);
        let turns = |body: &&BodyDescription| matches!(body.hinge.kind, HingeKind::Revolute { .. });
        if let Some(body) = scene.bodies.iter().find(turns) {
            let target = MotionDescription::Sine { offset: None, amplitude: 0.3, frequency: 1.7, phase: 0.2 };
            let law = MotorLawDescription::Pd {
                target: TargetDescription::Motion(target),
                stiffness: 3.0,
                damping: 0.1,
                force: 0.0,
            };
            let coordinate = CoordinateName { body: body.name.clone(), index: 0 };
            scene = scene.motor(MotorDescription { name: "swing".into(), coordinate, law, limit: None });
        }
        if scene.bodies.iter().all(|body| body.hinge.kind == HingeKind::Fixed) {
            continue;
        }
        let model = build(&scene);
        let mut random = Random::new(seed);
        let step = [1e-3, 0.01 / 3.0, 0.007, 2e-3][seed as usize % 4];
        let (first, second) = (3 + random.below(40), 2 + random.below(40));
        let begin = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
        let whole = run(&model, &fixed((first + second) as f64 * step, step), &begin);
        let half = run(&model, &fixed(first as f64 * step, step), &begin);
        assert!(half.resume.grid.is_some(), "{seed}: {:?}", half.resume);
        let text = text_at_end(&model, &half.resume, &half.state, &[], &half.memories);
        let read = parse_start("end.toml", &text, &scene).unwrap_or_else(|bad| panic!("{bad}\n{text}"));
        assert_eq!(read.resume, Some(half.resume));
        let state = State { position: read.model.start_position.clone(), velocity: read.model.start_velocity.clone() };
        assert!(same(&state, &half.state), "{seed}");
        let settings = Settings { resume: read.resume, ..fixed(second as f64 * step, step) };
        let rest = run(&model, &settings, &state);
        assert_eq!(rest.end_time.to_bits(), whole.end_time.to_bits(), "{seed}: {} {}", rest.end_time, whole.end_time);
        assert!(same(&rest.state, &whole.state), "{seed}: {first} and {second} steps of {step}");
        cases += 1;
    }
    assert!(cases > 40, "{cases}");
}

/// An event that is crossed within some digits of where a run ends and another goes on is told once, by one of them.
#[test]
fn an_event_where_a_run_goes_on_is_told_once() {
    for digits in -6..=6 {
        let mut value = 0.4_f64;
        (0..i32::abs(digits)).for_each(|_| value = if digits > 0 { value.next_up() } else { value.next_down() });
        for direction in [1.0, -1.0] {
            let hinge = HingeDescription::prismatic([1.0, 0.0, 0.0]).velocity([direction]);
            let of = WatchedDescription::Hinge { body: "s".to_owned(), coordinate: 0 };
            let mut scene =
                Description::new("sliding").gravity([0.0; 3]).body(BodyDescription::new("s", hinge).mass(2.0));
            scene.events.push(EventDescription {
                name: "e".to_owned(),
                of,
                value: direction * value,
                direction: Direction::Both,
                stops: false,
            });
            let model = build(&scene);
            let begin = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
            let part = Settings { start: simulate::Start::Given, duration: 0.4, ..Settings::default() };
            let half = run(&model, &part, &begin);
            let rest = run(&model, &Settings { resume: Some(half.resume.clone()), duration: 0.6, ..part }, &half.state);
            let crossings = |done: &Summary| done.events.iter().filter(|one| one.name == "e").count();
            let told = [crossings(&half), crossings(&rest)];
            assert_eq!(told[0] + told[1], 1, "{digits} digits, {direction}: {told:?}");
        }
    }
}

/// A run that ends at an instant of its controller, as the user writes it, goes on bit for bit: 24 · 12.5 ms is not 0.3 s in doubles.
#[test]
fn fixed_steps_between_instants_go_on_bit_for_bit() {
    let text = "[simulate]\nstart = \"given\"\nintegrator = \"rk4\"\nstep = 0.0025\nduration = 1.0\n\
        [[body]]\nname = \"b\"\nmass = 1.0\ncenter = [0.1, 0, -0.3]\ninertia = [0.1, 0.1, 0.1]\n\
        hinge = { type = \"revolute\", axis = [0, 1, 0], position = 0.3 }\n\
        [[output]]\nname = \"q\"\ntype = \"coordinate\"\nof = \"b\"\n\
        [[motor]]\nname = \"m\"\nhinge = \"b\"\ntype = \"input\"\n\
        [[controller]]\nname = \"c\"\ntype = \"gain\"\nperiod = 0.0125\nsenses = [\"q\"]\ndrives = [\"m\"]\nmatrix = [[2.0]]\n";
    let scenario = stillpoint::scenario::parse("c.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
    let model = Model::build(&scenario.description).map(Arc::new).expect("a model");
    let begin = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let whole = run(&model, &fixed(1.0, 0.0025), &begin);
    for k in 1..20 {
        let first = f64::from(5 * k) / 100.0;
        let half = run(&model, &fixed(first, 0.0025), &begin);
        let inputs: Vec<(String, f64)> = vec![("m.force".to_owned(), half.inputs[0])];
        let text = text_at_end(&model, &half.resume, &half.state, &inputs, &half.memories);
        let read = parse_start("end.toml", &text, &scenario.description).unwrap_or_else(|bad| panic!("{bad}\n{text}"));
        let settings = Settings { resume: read.resume, ..fixed(1.0 - first, 0.0025) };
        let rest = run(&read.model, &settings, &half.state);
        assert!(same(&rest.state, &whole.state), "{first} s");
    }
}

/// Adaptive methods go on to their tolerance, with the step that they had.
#[test]
fn adaptive_methods_go_on_to_their_tolerance() {
    for method in [Method::Dopri5, Method::Dop853, Method::Adams, Method::Sdirk4, Method::Radau9] {
        let options = Options { bodies: 3, springs: true, welds: false };
        let model = build(&random_scene(77, &options));
        let begin = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
        let settings = |duration| Settings {
            duration,
            tolerance: 1e-9,
            absolute_tolerance: 1e-9,
            integrator: Integrator::Method(method),
            ..Settings::default()
        };
        let whole = run(&model, &settings(1.0), &begin);
        let half = run(&model, &settings(0.4), &begin);
        assert!(half.resume.grid.is_none() && half.resume.method == method);
        let rest = run(&model, &Settings { resume: Some(half.resume), ..settings(0.6) }, &half.state);
        assert_eq!(rest.end_time, 1.0);
        for (a, b) in whole.state.position.iter().zip(&rest.state.position) {
            assert!((a - b).abs() < 1e-7, "{method:?}: {a} {b}");
        }
    }
}

fn call(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let answer = Command::new(env!("CARGO_BIN_EXE_stillpoint")).current_dir(folder).args(arguments).output().unwrap();
    (answer.status.code(), String::from_utf8(answer.stdout).unwrap(), String::from_utf8(answer.stderr).unwrap())
}

/// The program: a bump of a road in the middle, loops, a ball; a drive's motion goes on where it was.
#[test]
fn a_saved_run_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let scenario = file("double_wishbone").display().to_string();
    let json = |arguments: &[&str]| -> Value {
        let (code, out, told) = call(folder.path(), arguments);
        assert_eq!(code, Some(0), "{told}");
        serde_json::from_str(&out).unwrap()
    };
    let with = |duration: &str, more: &[&str]| {
        let duration = format!("simulate.duration={duration}");
        let set = [
            "run",
            &scenario,
            "--json",
            "--out",
            "x.mcap",
            "--set",
            "simulate.integrator=rk4",
            "--set",
            "simulate.step=1e-4",
        ];
        json(&[&set[..], &["--set", &duration], more].concat())
    };
    let whole = with("0.8", &[]);
    let half = with("0.65", &["--save-end", "end.toml"]);
    assert_eq!(half["end_file"], "end.toml");
    let rest = with("0.15", &["--start", "end.toml"]);
    assert_eq!(rest["end_time"], whole["end_time"]);
    // The step ends at a break of the drive's table within, and begins anew there, in both.
    let close = |one: &Value, other: &Value| {
        let (one, other) = (one.as_object().unwrap(), other.as_object().unwrap());
        one.iter().all(|(name, list)| {
            let pairs = list.as_array().unwrap().iter().zip(other[name].as_array().unwrap());
            pairs.map(|(a, b)| (a.as_f64().unwrap() - b.as_f64().unwrap()).abs()).all(|apart| apart < 1e-12)
        })
    };
    assert!(close(&rest["final"]["positions"], &whole["final"]["positions"]), "{rest}\n{whole}");
    assert!(close(&rest["final"]["velocities"], &whole["final"]["velocities"]) || rest["final"] == whole["final"]);
    let seen = json(&["inspect", &scenario, "--json", "--start", "end.toml"]);
    assert_eq!(seen["outputs"]["camber"], half["outputs"]["camber"]);
    std::fs::write(folder.path().join("bad.toml"), "time = 1.0\n[positions]\n").unwrap();
    let (code, _, told) = call(folder.path(), &["run", &scenario, "--start", "bad.toml"]);
    assert!(code == Some(2) && told.contains("[integrator] method"), "{told}");
}

/// What happened but changes of the method, by kind and name.
fn told(done: &Summary) -> Vec<String> {
    let is_told = |one: &&simulate::events::Occurrence| one.kind != simulate::events::Kind::Switch;
    done.events
        .iter()
        .filter(is_told)
        .map(|one| format!("{} {} {:?}", one.kind.name(), one.name, one.between))
        .collect()
}

/// Runs of scenes with contact, stops and dry friction, cut into pieces that go on through the text of a file: they end where one run does, and
/// what happened is told once. Where captured steps are at work, which end at every cut, it is the same to their order, and of what tumbles the
/// account of energy is.
#[test]
fn what_touches_holds_and_slides_goes_on_as_it_did() {
    for (name, duration, pieces, apart) in [
        ("contact/coin", 1.0, 10, f64::INFINITY),
        ("contact/rubber_feet", 1.0, 10, 1e-6),
        ("contact/bouncing_ball", 1.0, 7, 1e-6),
        ("contact/rocking_block", 1.0, 7, 1e-6),
        ("contact/belt", 1.0, 10, 1e-6),
        ("contact/newtons_cradle", 1.0, 10, 1e-6),
        ("contact/incline", 1.0, 5, 1e-10),
        ("contact/dropped_arm", 0.6, 6, 2e-3),
        ("barrier", 1.0, 10, 1e-6),
        ("arm_on_stop", 1.0, 10, 1e-6),
        ("stick_slip", 2.0, 10, 1e-6),
        ("dry_wheel", 1.0, 10, 1e-6),
    ] {
        let scenario = stillpoint::scenario::load(&file(name)).unwrap_or_else(|error| panic!("{error}"));
        let model = build(&scenario.description);
        let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
        let settings = Settings { start: simulate::Start::Given, duration, ..scenario.simulate.clone() };
        let whole = run(&model, &settings, &start);
        let (mut state, mut resume, mut happened) = (start, None, Vec::new());
        for piece in 1..=pieces {
            let until = duration * f64::from(piece) / f64::from(pieces);
            let begun = resume.as_ref().map_or(0.0, |resume: &simulate::Resume| resume.time);
            let part = Settings { duration: until - begun, resume, ..settings.clone() };
            let done = run(&model, &part, &state);
            happened.extend(told(&done));
            let gained = done.energy_end - done.energy_start - done.work + done.dissipated;
            // As the coin rattles, captured steps are off by a thousandth of what it has.
            assert!(gained < 5e-3 * whole.energy_largest, "{name}: {gained:e} J from {begun} s on");
            let text = text_at_end(&model, &done.resume, &done.state, &[], &done.memories);
            let read = parse_start("end.toml", &text, &scenario.description).unwrap_or_else(|bad| panic!("{bad}"));
            state = State { position: read.model.start_position.clone(), velocity: read.model.start_velocity.clone() };
            resume = read.resume;
        }
        if whole.capture_steps == 0 {
            assert_eq!(happened, told(&whole), "{name}");
        }
        let off = state.position.iter().zip(&whole.state.position).map(|(one, other)| (one - other).abs());
        let off = off.fold(0.0, f64::max);
        assert!(off <= apart, "{name}: {off:e}");
    }
}
