//! Parts that nothing holds: told at once if a constant force pushes them, left where they were as a whole if none does.

use crate::common::Random;
use std::fmt::Write;
use stillpoint::dynamics::System;
use stillpoint::model::Model;
use stillpoint::scenario;
use stillpoint::statics::{StabilityVerdict, equilibrium};

/// A free body that falls, beside a machine that stands: its thrust has not begun.
#[test]
fn a_part_that_falls_beside_others_that_stand_is_named_at_once() {
    for seed in 0..20 {
        let random = &mut Random::new(seed);
        let (at, thrust) = (random.list(3, -5.0, 5.0), random.list(3, -100.0, 100.0));
        let text = format!(
            "[[body]]\nname = \"arm\"\nmass = 5.0\ncenter = [0.3, 0.0, 0.0]\ninertia = [0.1, 0.1, 0.1]\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], stiffness = 50.0 }}\n\
             [[force]]\nname = \"wind\"\ntype = \"load\"\non = \"arm\"\nforce = [0.0, 0.0, 1.0]\naxes = \"body\"\n\
             [[body]]\nname = \"rocket\"\nmass = 66.0\ninertia = [0.1, 40.0, 40.0]\n\
             hinge = {{ type = \"free\", position = [{:?}, {:?}, {:?}, 1.0, 0.0, 0.0, 0.0] }}\n\
             [[force]]\nname = \"thrust\"\ntype = \"load\"\non = \"rocket\"\nforce = {thrust:?}\naxes = \"body\"\n\
             over_time = {{ times = [1.0, 1.01, 2.7, 2.71], values = [0.0, 1.0, 1.0, 0.0] }}\n",
            at[0], at[1], at[2]
        );
        let scenario =
            scenario::parse("rocket.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
        let model = Model::build(&scenario.description).expect("a model");
        let found = equilibrium(&model, &scenario.statics, &model.start_position).expect("statics");
        let told = found.notes.iter().any(|note| note.contains("nothing holds `rocket`"));
        assert!(!found.balanced && told && found.iterations == 0, "seed {seed}: {:?}\n{text}", found.notes);
    }
}

/// What a drive keeps turning elsewhere holds nothing either.
#[test]
fn a_part_that_falls_beside_a_crank_that_turns_is_named_at_once() {
    let text = "
        [[body]]
        name = \"crank\"
        mass = 1.0
        inertia = [0.1, 0.1, 0.1]
        hinge = { type = \"revolute\", axis = [0, 1, 0] }
        [[body]]
        name = \"wheel\"
        mass = 1.0
        inertia = [0.1, 0.1, 0.1]
        hinge = { type = \"revolute\", axis = [0, 1, 0], at = [1, 0, 0] }
        [[gear]]
        type = \"ratio\"
        between = [\"wheel\", \"crank\"]
        ratio = 2.0
        [[drive]]
        hinge = \"crank\"
        type = \"rate\"
        rate = 3.0
        [[body]]
        name = \"stone\"
        mass = 2.0
        inertia = [0.1, 0.1, 0.1]
        hinge = { type = \"free\" }
    ";
    let scenario = scenario::parse("crank.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}"));
    let model = Model::build(&scenario.description).expect("a model");
    let found = equilibrium(&model, &scenario.statics, &model.start_position).expect("statics");
    assert!(found.notes.iter().any(|note| note.contains("nothing holds `stone`")), "{:?}", found.notes);
    assert_eq!(found.iterations, 0);
}

/// Free bodies on springs to each other, with limbs on hinge springs: no gravity, and nothing of the ground.
fn adrift(seed: u64) -> String {
    let random = &mut Random::new(seed);
    let mut text = "gravity = [0.0, 0.0, 0.0]\n".to_owned();
    let count = 1 + random.below(3);
    for index in 0..count {
        let (mass, place) = (10_f64.powf(random.between(-1.0, 1.5)), random.list(3, -0.2, 0.2));
        let _ = write!(
            text,
            "[[body]]\nname = \"b{index}\"\nmass = {mass:?}\ninertia = [{i:?}, {i:?}, {i:?}]\n\
             hinge = {{ type = \"free\", position = [{:?}, {:?}, {:?}, 1.0, 0.0, 0.0, 0.0] }}\n",
            1.2 * index as f64 + place[0],
            place[1],
            place[2],
            i = 0.1 * mass
        );
        for limb in 0..random.below(3) {
            let (rest, at) = (random.between(-0.5, 0.5), random.list(3, -0.3, 0.3));
            let _ = write!(
                text,
                "[[body]]\nname = \"b{index}l{limb}\"\nmass = 0.5\ncenter = [0.3, 0.1, 0.0]\ninertia = [0.01, 0.02, 0.02]\n\
                 hinge = {{ type = \"revolute\", parent = \"b{index}\", at = {at:?}, axis = [0, 1, 0], stiffness = 5.0, rest = {rest:?} }}\n"
            );
        }
        if index > 0 {
            let before = index - 1;
            let _ = writeln!(
                text,
                "[[force]]\nname = \"s{index}\"\ntype = \"spring\"\nbetween = [\"b{before}\", \"b{index}\"]\nlength = 1.0\nstiffness = 100.0"
            );
        }
    }
    text
}

/// Of the whole scene, which is one part: the centre of mass, and the mass-weighted turn from one position to another.
fn moved(model: &std::sync::Arc<Model>, from: &[f64], to: &[f64]) -> (f64, f64) {
    let mut system = System::new(model);
    let rest = vec![0.0; model.velocity_count()];
    let mut at = |q: &[f64]| system.at(0.0, q, &rest).motion().clone();
    let (before, after) = (at(from), at(to));
    let mass: f64 = model.links.iter().map(|link| link.mass).sum();
    let center = |motion: &stillpoint::motion::Motion| {
        let all = model.links.iter().zip(&motion.links);
        all.map(|(link, at)| link.mass * (at.position + at.center)).sum::<nalgebra::Vector3<f64>>() / mass
    };
    let (first, last) = (center(&before), center(&after));
    let mut turn = nalgebra::Vector3::zeros();
    for (link, (x, y)) in model.links.iter().zip(after.links.iter().zip(&before.links)) {
        // Points of the body at its centre of mass and its principal second moment: `∫ (x₀ − C₀) × (x − C) dm`.
        let (x_c, y_c) = (x.position + x.center - last, y.position + y.center - first);
        turn += link.mass * y_c.cross(&x_c);
        let about = x.inertia.matrix()
            - link.mass
                * (nalgebra::Matrix3::from_diagonal_element(x.center.norm_squared()) - x.center * x.center.transpose());
        let second = nalgebra::Matrix3::from_diagonal_element(0.5 * about.trace()) - about;
        let mixed = second * x.turn * y.turn.transpose();
        turn += nalgebra::Vector3::new(
            mixed[(2, 1)] - mixed[(1, 2)],
            mixed[(0, 2)] - mixed[(2, 0)],
            mixed[(1, 0)] - mixed[(0, 1)],
        );
    }
    ((last - first).norm(), turn.norm() / mass)
}

#[test]
fn a_scene_that_floats_keeps_its_centre_of_mass_and_its_mean_orientation() {
    for seed in 0..30 {
        let text = adrift(seed);
        let scenario =
            scenario::parse("adrift.toml", &text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
        let model = Model::build(&scenario.description).expect("a model");
        let found = equilibrium(&model, &scenario.statics, &model.start_position).expect("statics");
        assert!(found.converged, "seed {seed}: {:?}\n{text}", found.notes);
        assert_eq!(found.stability.as_ref().expect("a verdict").verdict, StabilityVerdict::Neutral, "seed {seed}");
        let (shift, turn) = moved(&model, &model.start_position, &found.position);
        assert!(shift < 1e-9 && turn < 1e-9, "seed {seed}: {shift:e} m, {turn:e}\n{text}");
    }
}
