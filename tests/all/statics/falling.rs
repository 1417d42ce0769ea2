//! Scenes that nothing holds up: the motion along which they fall for ever is told, in some tens of steps at most.

use crate::common::Random;
use std::fmt::Write;
use std::sync::Arc;
use std::time::Instant;
use stillpoint::constraint::assemble;
use stillpoint::dynamics::System;
use stillpoint::model::Model;
use stillpoint::scenario;
use stillpoint::statics::{Equilibrium, equilibrium};

/// An arm with a slide along it, and a body that a loop clasps to what slides.
fn scene(random: &mut Random) -> String {
    let (slide, lift) = (["[1, 0, 0]", "[1, 0.2, 0]", "[1, 0, 0.1]"][random.below(3)], random.between(-0.3, 0.3));
    let mass = 10_f64.powf(random.between(-2.0, 2.0));
    let mut text = format!(
        "[[body]]\nname = \"arm\"\nmass = 0.5\ncenter = [0.1, 0, 0]\ninertia = [0.001, 0.003, 0.003]\n\
         hinge = {{ type = \"revolute\", at = [0, 0, 1], axis = [0, 1, 0], position = {lift:?} }}\n\
         [[body]]\nname = \"sleeve\"\nmass = {mass:?}\ninertia = [0.001, 0.002, 0.003]\n\
         hinge = {{ type = \"prismatic\", parent = \"arm\", at = [0.2, 0, 0], axis = {slide} }}\n"
    );
    let _ = write!(
        text,
        "[[body]]\nname = \"parcel\"\nmass = 0.2\ninertia = [0.0001, 0.0002, 0.0002]\n\
         hinge = {{ type = \"free\", position = [0.6, 0, 1.1, 1, 0, 0, 0] }}\n\
         [[loop]]\ntype = \"fixed\"\nbetween = [{{ body = \"sleeve\", at = [0.3, 0, 0] }}, {{ body = \"parcel\", at = [0.05, 0, 0] }}]\n"
    );
    text
}

#[test]
fn what_falls_along_a_slide_with_loops_on_it_is_told() {
    for seed in 0..15 {
        let text = scene(&mut Random::new(seed));
        let scenario =
            scenario::parse("falling.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
        let (model, _) = assemble(Model::build(&scenario.description).expect("a model")).expect("an assembly");
        let found = equilibrium(&model, &scenario.statics, &model.start_position).expect("statics");
        let told = found.notes.iter().any(|note| note.starts_with("falls for ever: nothing holds `"));
        assert!(!found.converged && told, "seed {seed}: {:?} at {:?}\n{text}", found.notes, found.position);
        assert!(found.iterations < 2000, "seed {seed}: {} steps", found.iterations);
    }
}

/// An arm of limp hinges and springs at random, without loops.
fn arm(random: &mut Random) -> String {
    let mut text = String::new();
    for index in 0..2 + random.below(6) {
        let numbers = |random: &mut Random, size: f64| <[f64; 3]>::from(random.vector(size));
        let (center, at, axis) = (numbers(random, 0.2), numbers(random, 0.4), numbers(random, 1.0));
        let kind = ["revolute", "prismatic", "spherical", "cylindrical", "screw"][random.below(5)];
        let about = match kind {
            "spherical" => String::new(),
            "screw" => format!(", axis = {axis:?}, pitch = 0.1"),
            _ => format!(", axis = {axis:?}"),
        };
        let parent = if index > 0 { format!("b{}", random.below(index)) } else { "ground".to_owned() };
        let held = ["revolute", "prismatic"].contains(&kind) && random.below(3) == 0;
        let spring = if held { format!(", stiffness = {:?}", random.between(1.0, 200.0)) } else { String::new() };
        let _ = write!(
            text,
            "[[body]]\nname = \"b{index}\"\nmass = {:?}\ncenter = {center:?}\ninertia = [0.01, 0.012, 0.011]\n\
             hinge = {{ type = \"{kind}\", parent = \"{parent}\", at = {at:?}{about}{spring} }}\n",
            10_f64.powf(random.between(-1.0, 1.0))
        );
    }
    text
}

fn read(text: &str) -> (Arc<Model>, Equilibrium) {
    let scenario = scenario::parse("scene.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
    let (model, _) = assemble(Model::build(&scenario.description).expect("a model")).expect("an assembly");
    let found = equilibrium(&model, &scenario.statics, &model.start_position).expect("statics");
    (model, found)
}

/// The body that a note says falls, turns or is pushed for ever.
fn falls(found: &Equilibrium) -> Option<&str> {
    let note = found.notes.iter().find(|note| note.contains(" for ever: nothing "))?;
    note.split('`').nth(1)
}

/// What is said to fall does: somewhere its slide, or its screw, takes the potential down at a constant mean rate. What is not
/// said to fall comes to rest.
#[test]
fn a_limp_arm_rests_or_falls_for_ever() {
    let mut told = 0;
    for seed in 0..100 {
        let text = arm(&mut Random::new(seed));
        let began = Instant::now();
        let (model, found) = read(&text);
        assert!(began.elapsed().as_secs_f64() < 10.0, "seed {seed}: {:?}", began.elapsed());
        let Some(body) = falls(&found) else {
            assert!(found.converged, "seed {seed}: {:?}\n{text}", found.notes);
            continue;
        };
        told += 1;
        let hinge = &model.bodies[model.body(body).expect("a body")].hinge;
        let last = hinge.position + hinge.kind.counts().0 - 1;
        let mut system = System::new(&model);
        let still = vec![0.0; model.velocity_count()];
        // Beside the guess: there an axis may be level.
        let mut q = model.start_position.clone();
        for link in model.links.iter().filter(|link| link.joint.is_turn()) {
            q[link.position] += 0.1;
        }
        let mut potential = |way: f64| {
            let mut q = q.clone();
            // A cylindrical hinge has its distance before its angle.
            q[if hinge.kind.counts().0 == 2 { last - 1 } else { last }] += way;
            system.at(0.0, &q, &still).energies().potential
        };
        let turns = 200.0 * std::f64::consts::PI;
        let [one, two] = [potential(turns) - potential(0.0), potential(2.0 * turns) - potential(0.0)];
        assert!((two - 2.0 * one).abs() <= 1e-9 * two.abs() && one != 0.0, "seed {seed}: {body}: {one} {two}\n{text}");
    }
    assert!(told > 30, "{told} of 100");
}

/// A load on a rope, a drum and a motor: stronger or weaker than the load, it winds for ever in one direction or the other; a stop
/// in that direction bears what is between.
#[test]
fn a_winch_winds_for_ever_unless_a_stop_is_in_its_way() {
    for seed in 0..40 {
        let mut random = Random::new(seed);
        let (radius, mass) = (random.between(0.05, 0.5), random.between(1.0, 50.0));
        let torque = radius * mass * 9.80665 * random.between(0.1, 3.0);
        let up = torque > radius * mass * 9.80665;
        let stop = random.below(3);
        let limits = ["", ", limits = { high = 2.0 }", ", limits = { low = -2.0 }"][stop];
        let text = format!(
            "[[body]]\nname = \"drum\"\nmass = 6\ninertia = [0.05, 0.04, 0.05]\nhinge = {{ type = \"revolute\", at = [0, 0, 3], axis = [0, 1, 0] }}\n\
             [[body]]\nname = \"load\"\nmass = {mass:?}\ninertia = [1, 1, 1]\nhinge = {{ type = \"prismatic\", axis = [0, 0, 1]{limits} }}\n\
             [[gear]]\nname = \"rope\"\ntype = \"rack\"\nradius = {radius:?}\nbetween = [\"load\", \"drum\"]\n\
             [[motor]]\nname = \"motor\"\nhinge = \"drum\"\ntype = \"constant\"\nforce = {torque:?}\n"
        );
        let (_, found) = read(&text);
        let held = stop == if up { 1 } else { 2 };
        assert_eq!(found.converged, held, "seed {seed}: {:?}\n{text}", found.notes);
        let leads = if up { "drum" } else { "load" };
        assert_eq!(falls(&found), (!held).then_some(leads), "seed {seed}: {:?}", found.notes);
        assert!(held || found.iterations == 0, "seed {seed}: {} steps", found.iterations);
    }
}
