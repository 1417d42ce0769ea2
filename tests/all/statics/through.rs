//! Forces through the point that a body turns about, and forces that are none: what is left of them is round-off, however small the
//! forces are that it is compared with.

use crate::common::Random;
use std::fmt::Write;
use stillpoint::constraint::assemble;
use stillpoint::model::Model;
use stillpoint::scenario;
use stillpoint::statics::{Equilibrium, equilibrium};

fn solved(text: &str) -> Equilibrium {
    let scenario = scenario::parse("scene.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
    let (model, _) = assemble(Model::build(&scenario.description).expect("a model")).expect("an assembly");
    equilibrium(&model, &scenario.statics, &model.start_position).expect("statics")
}

/// A free body on a bushing at its origin that is as stiff in all directions, with `stiffness` about its axes.
fn on_a_bushing(random: &mut Random, about: f64) -> String {
    let (along, first) = (10_f64.powf(random.between(0.0, 4.0)), random.below(2) == 0);
    let between = if first { "[\"hub\", \"ground\"]" } else { "[\"ground\", \"hub\"]" };
    format!(
        "[[body]]\nname = \"hub\"\nmass = {:?}\ninertia = [0.1, 0.1, 0.1]\nhinge = {{ type = \"free\" }}\n\
         [[force]]\ntype = \"bushing\"\nbetween = {between}\nstiffness = [{along:?}, {along:?}, {along:?}, {about:?}, {about:?}, {about:?}]\n",
        10_f64.powf(random.between(-1.0, 1.0))
    )
}

#[test]
fn a_free_body_on_a_bushing_stands_however_it_is_pushed_through_its_origin() {
    for seed in 0..40 {
        let random = &mut Random::new(seed);
        let mut text = on_a_bushing(random, 10.0);
        for index in 0..1 + random.below(3) {
            let push = random.list(3, -5.0, 5.0);
            let _ = match random.below(2) {
                0 => writeln!(text, "[[force]]\nname = \"p{index}\"\ntype = \"load\"\non = \"hub\"\nforce = {push:?}"),
                _ => writeln!(
                    text,
                    "[[force]]\nname = \"p{index}\"\ntype = \"spring\"\nbetween = [\"hub\", {{ body = \"ground\", at = {push:?} }}]\n\
                     stiffness = 10.0\nlength = 1.0"
                ),
            };
        }
        let found = solved(&text);
        assert!(found.converged && found.iterations < 200, "seed {seed}: {:?}\n{text}", found.notes);
    }
}

/// A moment is none only if it is round-off of the forces that it comes from.
#[test]
fn a_moment_that_nothing_balances_is_refused_however_small() {
    for seed in 0..10 {
        let random = &mut Random::new(seed);
        // Weightless: the weight would turn the body about what holds it, and the moment be small beside that.
        let mut text = format!("gravity = [0.0, 0.0, 0.0]\n{}", on_a_bushing(random, 0.0));
        let moment = 10_f64.powf(random.between(-8.0, -4.0));
        let _ =
            writeln!(text, "[[force]]\nname = \"m\"\ntype = \"load\"\non = \"hub\"\ntorque = [{moment:?}, 0.0, 0.0]");
        let _ = writeln!(text, "[statics]\ntime_limit = 5.0");
        let found = solved(&text);
        assert!(!found.balanced, "seed {seed}: {moment:e} N m\n{text}");
    }
}

#[test]
fn a_slack_cable_without_weight_is_balanced() {
    for seed in 0..6 {
        let random = &mut Random::new(seed);
        let (length, radius) = (random.between(1.1, 2.0), 10_f64.powf(random.between(-3.0, -2.0)));
        let text = format!(
            "gravity = [0.0, 0.0, 0.0]\n[[cable]]\nname = \"c\"\nlength = {length:?}\nbending = 0.0\n\
             between = [{{ body = \"ground\", at = [0.0, 0.0, 0.0] }}, {{ body = \"ground\", at = [1.0, 0.0, 0.0] }}]\n\
             section = {{ circle = {radius:?} }}\nmaterial = {{ young = 1e11, density = 7800.0 }}\n"
        );
        let found = solved(&text);
        assert!(found.balanced && found.factorizations < 5000, "seed {seed}: {:?}\n{text}", found.notes);
    }
}
