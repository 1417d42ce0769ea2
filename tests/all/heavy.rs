//! Runs of light chains that carry a heavy body, by implicit methods: what they need of a tangent that is right about the light links.

use crate::common::{Random, build};
use std::fmt::Write;
use std::sync::Arc;
use stillpoint::model::Model;
use stillpoint::record::{Memory, Opening};
use stillpoint::scenario::{Override, Scenario};
use stillpoint::simulate::{self, RunError, State, Summary};

/// One to three light links on balls and turns, slender or not, in line or not, and a body 10⁶ to 3·10⁹ times heavier.
fn chain(random: &mut Random) -> String {
    let count = 2 + random.below(3);
    let ratio = 10_f64.powf(random.between(6.0, 9.5));
    let mut text =
        "[simulate]\nstart = \"given\"\nduration = 0.2\ntolerance = 1e-8\n[record]\nrate = 10.0\n".to_owned();
    for index in 0..count {
        let is_last = index + 1 == count;
        let mass = if is_last { ratio } else { random.between(0.3, 3.0) };
        let thin = [1e-4, 1e-3, 1e-2][random.below(3)];
        let inertia = [0.08, 0.08, if is_last { 0.05 } else { thin }].map(|part| part * mass);
        let size = if index > 0 && random.below(5) < 3 { 1e-3 } else { 0.8 };
        let on = if index == 0 { String::new() } else { format!(", parent = \"l{}\", at = [0, 0, -1]", index - 1) };
        let hinge = if random.below(4) < 3 {
            let turn = random.vector(size);
            let (half, axis) = (0.5 * turn.norm(), turn.normalize());
            let q = [half.cos(), half.sin() * axis.x, half.sin() * axis.y, half.sin() * axis.z];
            format!("type = \"spherical\", position = {q:?}, velocity = {:?}", random.list(3, -0.3, 0.3))
        } else {
            let [position, velocity] = [size, 0.3].map(|size| random.between(-size, size));
            format!("type = \"revolute\", axis = [0, 1, 0], position = {position:?}, velocity = {velocity:?}")
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

fn go((scenario, model): &(Scenario, Arc<Model>), most_steps: u64) -> Result<Summary, RunError> {
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let scene = simulate::scene(model);
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: &scenario.text, statics: None });
    let mut steps = 0;
    simulate::run(model, &scenario.simulate, 0.2, &start, &mut memory, &mut |_, _| {
        steps += 1;
        steps < most_steps
    })
}

#[test]
fn implicit_methods_carry_heavy_bodies_on_light_balls() {
    for seed in 0..24 {
        let text = chain(&mut Random::new(seed));
        let expected =
            go(&scenario(&text, "dop853"), 4000).unwrap_or_else(|error| panic!("seed {seed}: {error}\n{text}"));
        // Zigzags of light links that are nearly in line are fast: the explicit method says so in steps.
        if expected.end_time < 0.2 {
            continue;
        }
        for integrator in ["radau5", "radau9", "gauss", "sdirk4"] {
            let found = go(&scenario(&text, integrator), 4000)
                .unwrap_or_else(|error| panic!("seed {seed}, {integrator}: {error}\n{text}"));
            assert!(found.end_time >= 0.2, "seed {seed}, {integrator}: creeps at {} s\n{text}", found.end_time);
            let pairs = found.state.position.iter().zip(&expected.state.position);
            let error = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(error < 1e-5, "seed {seed}, {integrator}: {error:.1e}\n{text}");
        }
    }
}
