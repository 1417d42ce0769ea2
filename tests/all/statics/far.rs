//! Poses and masses beyond any scale: a pose so far away that everything there is round-off is no equilibrium, and a heavy
//! pendulum hangs as a light one does.

use crate::common::{Random, build};
use std::fmt::Write;
use stillpoint::scenario;
use stillpoint::statics::{Equilibrium, StabilityVerdict, equilibrium};

fn find(text: &str) -> Equilibrium {
    let scenario = scenario::parse("far.toml", text, &[]).unwrap_or_else(|problems| panic!("{problems}\n{text}"));
    let model = build(&scenario.description);
    equilibrium(&model, &scenario.statics, &model.start_position).expect("statics")
}

#[test]
fn verdicts_do_not_depend_on_the_unit_of_mass() {
    for exponent in [-200, -150, -100, -8, 0, 8, 100, 149, 151] {
        let mass = 10_f64.powi(exponent);
        for (position, want, verdict) in
            [(0.3, "stable", StabilityVerdict::Stable), (std::f64::consts::PI, "any", StabilityVerdict::Unstable)]
        {
            let mut text = format!("[statics]\nwant = \"{want}\"\n");
            for (name, on) in [("a", String::new()), ("b", "parent = \"a\", at = [0, 0, -1], ".to_owned())] {
                let position = if name == "a" { position } else { 0.0 };
                let _ = write!(
                    text,
                    "[[body]]\nname = \"{name}\"\nmass = {mass:e}\ncenter = [0, 0, -1]\n\
                     hinge = {{ type = \"revolute\", {on}axis = [0, 1, 0], position = {position:?} }}\n"
                );
            }
            let found = find(&text);
            assert!(found.converged, "1e{exponent} kg: {:?}", found.notes);
            assert_eq!(found.stability.expect("an equilibrium").verdict, verdict, "1e{exponent} kg, {want}");
        }
    }
}

/// Newton's steps may go anywhere. What is called an equilibrium leaves no force that counts beside the weights, however far away
/// it is.
#[test]
fn a_balance_leaves_nothing_that_counts_beside_the_weights() {
    let (mut balanced, mut failed) = (0, 0);
    for seed in 0..400 {
        let mut random = Random::new(seed);
        let (count, mut weight, mut stiffest) = (1 + random.below(3), 0.0, 0.0_f64);
        let mut text = "[statics]\nmethod = \"newton\"\nwant = \"any\"\n".to_owned();
        for index in 0..count {
            let kinds = [
                "free\"",
                "planar\"",
                "prismatic\", axis = [1, 0.2, 0.3]",
                "revolute\", axis = [0, 1, 0]",
                "spherical\"",
            ];
            let kind = kinds[random.below(5)];
            let on = match index == 0 || random.below(2) == 0 {
                true => String::new(),
                false => format!(", parent = \"b{}\", at = [0.3, 0, 0]", index - 1),
            };
            let (mass, center) = (10_f64.powf(random.between(-2.0, 3.0)), random.list(3, -0.5, 0.5));
            weight += 9.80665 * mass;
            let _ = write!(
                text,
                "[[body]]\nname = \"b{index}\"\nmass = {mass:?}\ncenter = {center:?}\ninertia = [0.1, 0.1, 0.1]\n\
                 hinge = {{ type = \"{kind}{on} }}\n"
            );
        }
        for _ in 0..random.below(3) {
            let (body, at) = (random.below(count), random.between(-2.0, 2.0));
            let (stiffness, length) = (10_f64.powf(random.between(-3.0, 8.0)), [0.0, 1.0][random.below(2)]);
            stiffest = stiffest.max(stiffness);
            let _ = write!(
                text,
                "[[force]]\ntype = \"spring\"\nstiffness = {stiffness:?}\nlength = {length:?}\n\
                 between = [\"b{body}\", {{ body = \"ground\", at = [{at:?}, 0.3, 1] }}]\n"
            );
        }
        let found = find(&text);
        balanced += usize::from(found.balanced);
        failed += usize::from(!found.balanced);
        let farthest = found.position.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        // Moments of springs that are stretched far grow with their length, and so does their round-off: two of some units in the
        // last place of a few metres.
        let length = 3.0 + farthest.min(1e6);
        let allowed = 1e-9 * weight * length + 16.0 * f64::EPSILON * stiffest * length * length;
        assert!(
            !found.balanced || found.residual_force < allowed,
            "seed {seed}: {} N at {farthest} m\n{text}",
            found.residual_force
        );
    }
    assert!(balanced > 50 && failed > 50, "{balanced} {failed}");
}
