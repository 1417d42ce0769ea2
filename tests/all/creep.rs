//! Runs that are given up because their end is out of reach, and whom their message names.

use crate::common::{Random, build};
use std::fmt::Write;
use stillpoint::record::{Memory, Opening};
use stillpoint::simulate::{self, RunError, State};

/// Scenes of one mass on a spring of 10⁸ to 10⁹ rad/s, among bodies with dry friction of any speed, one of them at rest.
fn scene(random: &mut Random) -> (String, &'static str) {
    let integrator = ["radau5", "radau9", "sdirk4"][random.below(3)];
    let others = 1 + random.below(4);
    let fast = random.below(others + 1);
    let mut text = format!(
        "gravity = [0, 0, 0]\nsimulate = {{ start = \"given\", duration = 1000, integrator = \"{integrator}\" }}\n"
    );
    for index in 0..=others {
        let (name, hinge) = if index == fast {
            ("fast".to_owned(), format!("position = 1.0, stiffness = {:e}", 10f64.powf(random.between(16.0, 18.0))))
        } else {
            let speed = [0.0, random.between(1e-6, 1e-3), random.between(1.0, 50.0)][random.below(3)];
            let [friction, damping] =
                [-2.0..2.0, 0.0..8.0].map(|range| 10f64.powf(random.between(range.start, range.end)));
            (format!("rubs{index}"), format!("velocity = {speed:e}, friction = {friction:e}, damping = {damping:e}"))
        };
        let kind = ["prismatic", "revolute"][random.below(2)];
        let hinge = format!("hinge = {{ type = \"{kind}\", axis = [1, 0, 0], {hinge} }}");
        let _ = writeln!(text, "[[body]]\nname = \"{name}\"\nmass = 1.0\ninertia = [1, 1, 1]\n{hinge}");
    }
    (text, integrator)
}

#[test]
fn a_run_that_creeps_names_whose_error_asks_for_its_steps_beside_dry_friction() {
    let mut random = Random::new(23);
    for case in 0..6 {
        let (text, integrator) = scene(&mut random);
        let scenario =
            stillpoint::scenario::parse("creep.toml", &text, &[]).unwrap_or_else(|found| panic!("{found:?}"));
        let model = build(&scenario.description);
        let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
        let still = simulate::scene(&model);
        let mut memory = Memory::new(&Opening { scene: &still, scenario: &scenario.text, statics: None });
        let run = simulate::run(&model, &scenario.simulate, 1000.0, &start, &mut memory, &mut |_, _| true);
        let Err(error) = run else { panic!("case {case}: {integrator} came through: {text}") };
        assert!(matches!(error, RunError::Creep { .. }), "case {case}: {error}\n{text}");
        assert!(error.to_string().contains(" of `fast` asks for them"), "case {case}: {error}\n{text}");
    }
}
