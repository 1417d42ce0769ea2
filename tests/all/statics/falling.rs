//! Mechanisms with loops that nothing holds up: they are told in some tens of steps, not in a minute.

use crate::common::Random;
use std::fmt::Write;
use stillpoint::constraint::assemble;
use stillpoint::model::Model;
use stillpoint::scenario;
use stillpoint::statics::equilibrium;

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
