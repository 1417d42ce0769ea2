//! A search ends when its time is over or the caller says so, and tells what it found until then.

use crate::common::{Random, build};
use nalgebra::{Matrix3, Vector3};
use std::cell::Cell;
use std::sync::Arc;
use std::time::Instant;
use stillpoint::model::Model;
use stillpoint::model::description::*;
use stillpoint::scenario;
use stillpoint::statics::{Equilibrium, Method, Observers, Settings, Want, equilibrium, equilibrium_observed};

/// A crumpled chain: the search takes hundreds of steps.
fn crumpled(seed: u64) -> Arc<Model> {
    let mut random = Random::new(seed);
    let body = |index: usize| {
        let mut hinge = HingeDescription::new(HingeKind::Universal { axes: [Vector3::x(), Vector3::y()] });
        if index > 0 {
            hinge.parent = format!("b{}", index - 1);
        }
        hinge.at = Point::At(Vector3::new(0.0, 0.0, 0.2));
        hinge.position = random.list(2, -2.0, 2.0);
        let mass = 10_f64.powf(random.between(-2.0, 2.0));
        let mass = MassProperties { mass, center: random.vector(0.1), inertia: 1e-3 * mass * Matrix3::identity() };
        BodyDescription { name: format!("b{index}"), mass, markers: Vec::new(), shapes: Vec::new(), hinge }
    };
    build(&Description { bodies: (0..150).map(body).collect(), ..Description::default() })
}

fn says(found: &Equilibrium, what: &str) -> bool {
    found.notes.iter().any(|note| note.starts_with(what) && note.contains("the best residual until then is"))
}

#[test]
fn the_time_limit_ends_every_method() {
    for (seed, want, method) in [
        (0, Want::Stable, Method::Auto),
        (1, Want::Any, Method::Auto),
        (2, Want::Stable, Method::Relaxation),
        (3, Want::Stable, Method::Auto),
    ] {
        let model = crumpled(seed);
        for time_limit in [1e-9, 3e-3] {
            let settings = Settings { want, method, time_limit, ..Settings::default() };
            let before = Instant::now();
            let found = equilibrium(&model, &settings, &model.start_position).expect("statics");
            let took = before.elapsed().as_secs_f64();
            let note = format!("the time limit of {time_limit} s ended the search");
            let ended = !found.converged && says(&found, &note);
            // Three milliseconds may be enough on a fast machine.
            assert!(ended || (found.converged && time_limit > 1e-6), "{seed}, {time_limit}: {:?}", found.notes);
            assert!(took < time_limit + 1.0, "{seed}: {took} s");
            assert!(found.position.iter().all(|q| q.is_finite()));
        }
    }
    let model = crumpled(0);
    let found = equilibrium(&model, &Settings::default(), &model.start_position).expect("statics");
    assert!(found.converged, "{:?}", found.notes);
}

#[test]
fn the_caller_ends_the_search_within_a_step() {
    for most in [1, 5, 20] {
        let model = crumpled(most);
        let asked = Cell::new(0);
        let go_on = || {
            asked.set(asked.get() + 1);
            asked.get() <= most
        };
        let observers = Observers { go_on: Some(&go_on), ..Observers::default() };
        let settings = Settings::default();
        let found = equilibrium_observed(&model, &settings, &model.start_position, observers).expect("statics");
        assert!(!found.converged && says(&found, "the search was stopped"), "{most}: {:?}", found.notes);
        assert!(found.iterations as u64 <= most, "{} steps", found.iterations);
    }
}

#[test]
fn the_time_limit_of_a_file_is_that_of_the_search() {
    let text = |limit: &str| {
        format!(
            "[statics]\ntime_limit = {limit}\n[[body]]\nname = \"a\"\nmass = 1\ninertia = [1, 1, 1]\nhinge = {{ type = \"revolute\", axis = [0, 1, 0] }}\n"
        )
    };
    let read = |limit: &str| scenario::parse("scene.toml", &text(limit), &[]);
    assert_eq!(read("2.5").expect("a sound scene").statics.time_limit, 2.5);
    for wrong in ["0", "-1", "\"soon\""] {
        let problems = read(wrong).expect_err("no time limit");
        assert!(problems.to_string().contains("time_limit"), "{problems}");
    }
}

/// A load over time is a dead load where time stands still: the same search finds the same place as with the load that it is at t = 0.
#[test]
fn loads_over_time_are_what_they_are_at_the_start() {
    let mut random = Random::new(17);
    for _ in 0..6 {
        let factor = random.between(-2.0, 2.0);
        let force: Vec<f64> = random.list(3, -3.0, 3.0);
        let links: String = (0..6)
            .map(|index| {
                let parent =
                    if index > 0 { format!("parent = \"b{}\", at = [0, 0, -0.3], ", index - 1) } else { String::new() };
                format!(
                    "[[body]]\nname = \"b{index}\"\nmass = 0.4\ncenter = [0, 0, -0.15]\ninertia = [0.01, 0.01, 0.005]\n\
                     hinge = {{ type = \"universal\", axes = [[1, 0, 0], [0, 1, 0]], {parent}position = [1.0, 0.4] }}\n"
                )
            })
            .collect();
        let load = |scale: f64, more: &str| {
            let force: Vec<f64> = force.iter().map(|x| scale * x).collect();
            format!("{links}[[force]]\nname = \"push\"\ntype = \"load\"\non = \"b5\"\nforce = {force:?}\n{more}")
        };
        let over_time = format!("over_time = {{ times = [0.0, 1.0], values = [{factor:?}, 5.0] }}\n");
        let [dead, over_time] = [load(factor, ""), load(1.0, &over_time)].map(|text| {
            let model = build(&scenario::parse("scene.toml", &text, &[]).expect("a sound scene").description);
            equilibrium(&model, &Settings::default(), &model.start_position).expect("statics")
        });
        assert!(over_time.converged && dead.converged, "{:?}", over_time.notes);
        // The motion that would be looked for without a potential takes thousands.
        assert!(over_time.iterations < 500, "{} steps", over_time.iterations);
        let apart = over_time.position.iter().zip(&dead.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-9, "{apart}");
    }
}

/// A beam whose weight is near the end of all numbers: the shift of its steps is beyond them, and each step vanishes.
#[test]
fn a_weight_at_the_end_of_all_numbers_ends() {
    let text = r#"
        gravity = [0.0, 0.0, 1e154]
        [[beam]]
        name = "rod"
        hinge = { type = "fixed" }
        length = 1.0
        elements = 8
        section = { stiffness = [1e4, 1e4, 1e4, 1.0, 1.0, 1.0] }
        mass_per_length = 1.0
        free = ["bend"]
    "#;
    let scenario = scenario::parse("scene.toml", text, &[]).expect("a sound scene");
    let (model, time_limit) = (build(&scenario.description), 2.0);
    let before = Instant::now();
    let found = equilibrium(&model, &Settings { time_limit, ..Settings::default() }, &model.start_position);
    assert!(found.map_or(true, |found| !found.converged));
    // Some steps may be under way when the time is over.
    assert!(before.elapsed().as_secs_f64() < time_limit + 8.0, "{:?}", before.elapsed());
}
