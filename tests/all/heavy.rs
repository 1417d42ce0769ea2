//! Runs of light chains that carry a heavy body, by implicit methods: what they need of a tangent that is right about the light links.

use crate::common::{Random, build};
use std::fmt::Write;
use std::sync::Arc;
use stillpoint::model::Model;
use stillpoint::record::{Memory, Opening};
use stillpoint::scenario::{Override, Scenario};
use stillpoint::simulate::{self, RunError, State, Summary};

/// One to four light links on balls and revolute hinges, the first one free in some, slender or not, in line or not, and a body 10³ to
/// 10⁹ times heavier at their end.
fn chain(random: &mut Random) -> String {
    let count = 2 + random.below(4);
    let ratio = 10_f64.powf(random.between(3.0, 9.0));
    let mut text =
        "[simulate]\nstart = \"given\"\nduration = 0.02\ntolerance = 1e-8\n[record]\nrate = 50.0\n".to_owned();
    for index in 0..count {
        let is_last = index + 1 == count;
        let mass = if is_last { ratio } else { random.between(0.3, 3.0) };
        let thin = [1e-4, 1e-3, 1e-2][random.below(3)];
        let inertia = [0.08, 0.08, if is_last { 0.05 } else { thin }].map(|part| part * mass);
        let size = if index > 0 && random.below(5) < 3 { 1e-3 } else { 0.8 };
        let on = if index == 0 { String::new() } else { format!(", parent = \"l{}\", at = [0, 0, -1]", index - 1) };
        let turn = random.vector(size);
        let (half, axis) = (0.5 * turn.norm(), turn.normalize());
        let q = [half.cos(), half.sin() * axis.x, half.sin() * axis.y, half.sin() * axis.z];
        let rates = random.list(3, -0.3, 0.3);
        let hinge = match random.below(10) {
            0 if index == 0 => format!(
                "type = \"free\", position = [0, 0, 0, {}, {}, {}, {}], velocity = [0.1, 0, 0, {}, {}, {}]",
                q[0], q[1], q[2], q[3], rates[0], rates[1], rates[2]
            ),
            0..6 => format!("type = \"spherical\", position = {q:?}, velocity = {rates:?}"),
            _ => format!("type = \"revolute\", axis = [0, 1, 0], position = {:?}, velocity = {:?}", turn.y, rates[0]),
        };
        let _ = write!(
            text,
            "[[body]]\nname = \"l{index}\"\nmass = {mass:?}\ncenter = [0, 0, -0.5]\ninertia = {inertia:?}\nhinge = {{ {hinge}{on} }}\n"
        );
    }
    text
}

fn scenario(text: &str, integrator: &str) -> (Scenario, Arc<Model>) {
    let by = Override::parse(&format!("simulate.integrator={integrator}")).expect("a change");
    let scenario =
        stillpoint::scenario::parse("heavy.toml", text, &[by]).unwrap_or_else(|found| panic!("{found}\n{text}"));
    let model = build(&scenario.description);
    (scenario, model)
}

/// A run that is interrupted after so many steps.
fn go((scenario, model): &(Scenario, Arc<Model>), most_steps: u64) -> Result<Summary, RunError> {
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let scene = simulate::scene(model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: &scenario.text, statics: None });
    let mut steps = 0;
    simulate::run(model, &scenario.simulate, 10.0, &start, &mut memory, &mut |_, _| {
        steps += 1;
        steps < most_steps
    })
}

/// As an explicit method of order 8 finds them, whose accelerations are compared with long numbers in `light`, and in steps that follow from
/// the motion: methods of lower order take more of its steps. Newton iterations that fail took thousands, or ended the run. Chains whose
/// zigzags are too fast for that are left out: their steps are short whatever the method.
#[test]
fn implicit_methods_carry_heavy_bodies_on_light_chains() {
    let mut compared = 0;
    for seed in 0..20 {
        let text = chain(&mut Random::new(seed));
        let expected =
            go(&scenario(&text, "dop853"), 40).unwrap_or_else(|error| panic!("seed {seed}: {error}\n{text}"));
        if expected.interrupted {
            continue;
        }
        compared += 1;
        let steps = expected.statistics.steps;
        for (integrator, most) in [("radau5", 60 + 10 * steps), ("radau9", 20 + 3 * steps), ("sdirk4", 80 + 20 * steps)]
        {
            let found = go(&scenario(&text, integrator), most)
                .unwrap_or_else(|error| panic!("seed {seed}, {integrator}: {error}\n{text}"));
            assert!(!found.interrupted, "seed {seed}, {integrator}: creeps at {} s\n{text}", found.end_time);
            let pairs = found.state.position.iter().zip(&expected.state.position);
            let error = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            // The tolerance, times what a fast zigzag makes of it.
            assert!(error < 1e-6, "seed {seed}, {integrator}: {error:.1e}\n{text}");
        }
    }
    assert!(compared > 10, "{compared} chains were slow enough to compare");
}
