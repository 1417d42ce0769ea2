//! Guesses that are far from closed.

use super::read;
use crate::common::Random;
use nalgebra::Point3;
use stillpoint::dynamics::System;

/// Links of together 1 m, drawn straight out along x, whose tip belongs at `span` on the same line.
fn straight(links: usize, span: f64) -> String {
    let length = 1.0 / links as f64;
    format!(
        "[[body]]\nname = \"link\"\nrepeat = {links}\nmass = {length:?}\ncenter = [{:?}, 0, 0]\ninertia = [0, {inertia:?}, {inertia:?}]\n\
         markers = {{ tip = [{length:?}, 0, 0] }}\nhinge = {{ type = \"revolute\", at = [0, 0, 0], next = \"tip\", axis = [0, 1, 0] }}\n\
         [[loop]]\ntype = \"spherical\"\nbetween = [\"link[{}].tip\", {{ body = \"ground\", at = [{span:?}, 0, 0] }}]\n",
        length / 2.0,
        links - 1,
        inertia = length.powi(3) / 12.0,
    )
}

/// To first order nothing moves the tip of a straight chain along it: what closes is found beside it. The chain bends as
/// a whole, no link turns over.
#[test]
fn a_straight_guess_bends_until_its_tip_is_in_place() {
    for (links, span, bend) in [(3, 0.5, 2.2), (20, 0.9999, 0.1), (60, 0.8, 0.8), (60, 0.1, 0.8), (300, 0.8, 0.8)] {
        let (_, model) = read(&straight(links, span));
        let mut system = System::new(&model);
        let mut poses = Vec::new();
        system.at(0.0, &model.start_position, &vec![0.0; links]).poses(&mut poses);
        let last = poses[model.body(&format!("link[{}]", links - 1)).expect("the last link")];
        let tip = last * Point3::new(1.0 / links as f64, 0.0, 0.0);
        let gap = (tip - Point3::new(span, 0.0, 0.0)).norm();
        assert!(gap < 1e-9, "{links} links to {span} m: a gap of {gap:e} m");
        let most = model.start_position.iter().fold(0.0_f64, |most, angle| most.max(angle.abs()));
        assert!(most < bend, "{links} links to {span} m: a hinge turned by {most} rad");
    }
}

/// Conditions on slides are linear: they are met to the last digit from any distance, beside loops that stay as they are.
#[test]
fn drives_on_slides_close_from_any_distance() {
    for seed in 0..60 {
        let mut random = Random::new(seed);
        let distance = 10.0_f64.powf(random.between(0.0, 12.0)) * [-1.0, 1.0][random.below(2)];
        let (start, ratio) = (random.between(-1.0, 1.0), random.between(-3.0, 3.0));
        let slide = |name: &str, position: f64| {
            format!(
                "[[body]]\nname = \"{name}\"\nmass = {}\nhinge = {{ type = \"prismatic\", axis = [1, 0, 0], position = {position} }}\n",
                1.0 + position.abs()
            )
        };
        let mut text = slide("carriage", start) + &slide("follower", 0.0);
        text += &format!(
            "[[drive]]\nname = \"far\"\nhinge = \"carriage\"\ntype = \"sine\"\noffset = {distance:?}\namplitude = 0.0\nfrequency = 1.0\n"
        );
        let geared = random.below(2) == 0;
        if geared {
            text += &format!(
                "[[gear]]\nname = \"rack\"\ntype = \"ratio\"\nratio = {ratio:?}\nbetween = [\"carriage\", \"follower\"]\n"
            );
        }
        let with_loop = random.below(2) == 0;
        if with_loop {
            text += super::FOUR_BAR;
        }
        let (_, model) = read(&text);
        let at = |body: &str| super::coordinate(&model, &model.start_position, body);
        assert!(
            (at("carriage") - distance).abs() <= f64::EPSILON * distance.abs(),
            "seed {seed}: {} m",
            at("carriage")
        );
        if geared {
            let (gap, terms) = (at("carriage") - start - ratio * at("follower"), distance.abs() + start.abs());
            assert!(gap.abs() <= 4.0 * f64::EPSILON * terms, "seed {seed}: {gap:e} m of {terms:e} m\n{text}");
        }
        if with_loop {
            assert!((at("coupler") - 1.1).abs() < 1.0, "seed {seed}: the loop went far away");
        }
    }
}
