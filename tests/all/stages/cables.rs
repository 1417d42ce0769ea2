//! Cables that snap and hook on: a cable is closed by a loop of its name.

use super::{given, ran, stage};
use crate::common::{Random, build};
use nalgebra::Vector3;
use stillpoint::model::description::Description;
use stillpoint::scenario::parse;

const STAY: &str = r#"
gravity = [0, 0, -10.0]
[[body]]
name = "m"
mass = 10.0
center = [1.0, 0, 0]
inertia = [0.1, 0.1, 0.1]
hinge = { type = "revolute", axis = [0, 1.0, 0] }
markers = { e = [1.0, 0, 0] }
[[cable]]
name = "stay"
between = [{ body = "ground", at = [0, 0, 1.0] }, "m.e"]
length = 1.43
bending = 0.0
section = { circle = 0.004 }
material = { young = 1e6, density = 1000.0 }
elements = 2
damping = 0.01
"#;

fn scene(ends: &str) -> Description {
    let scene = parse("scene.toml", &format!("{STAY}ends = {ends}\n"), &[]);
    scene.unwrap_or_else(|problem| panic!("{}", problem.render(false))).description
}

/// Nothing jumps when a cable snaps or when the body at its end flies off with it: everything is where it was and as fast, and no energy
/// goes. The mast falls by itself from then on.
#[test]
fn a_cable_that_snaps_lets_go_and_moves_nothing() {
    for seed in 0..6 {
        let mut random = Random::new(seed);
        let ends =
            ["[\"spherical\", \"spherical\"]", "[\"fixed\", \"spherical\"]", "[\"fixed\", \"fixed\"]"][random.below(3)];
        let (mut description, when) = (scene(ends), random.between(0.01, 0.05));
        let mut open = stage(when);
        open.open.push(["stay", "m"][random.below(2)].to_owned());
        let snaps = open.open[0] == "stay";
        description.stages.push(open);
        let model = build(&description);
        let before = ran(&model, &given(&model), when * (1.0 - 1e-12));
        let after = ran(&model, &given(&model), when);
        assert_eq!((before.events.len(), after.events.len()), (0, 1), "seed {seed}");
        for body in &before.model.bodies {
            let place = |found: &stillpoint::simulate::Summary| {
                found.poses[found.model.body(&body.name).expect("the body")].translation.vector
            };
            let apart: Vector3<f64> = place(&before) - place(&after);
            assert!(apart.norm() < 1e-9, "seed {seed}: `{}` by {}", body.name, apart.norm());
        }
        assert!((before.energy_end - after.energy_end).abs() < 1e-7, "seed {seed}: {}", after.energy_end);
        assert!((before.dissipated - after.dissipated).abs() < 1e-7, "seed {seed}");
        let later = ran(&model, &given(&model), when + 0.02);
        assert!(later.energy_drift < 1e-6, "seed {seed}: {:e}", later.energy_drift);
        if snaps {
            // ½ I ω² = m g (z − z₀) of the mast alone.
            let of = |found: &stillpoint::simulate::Summary| {
                let hinge = &found.model.bodies[found.model.body("m").expect("the mast")].hinge;
                let (q, v) = (found.state.position[hinge.position], found.state.velocity[hinge.velocity]);
                0.5 * 10.1 * v * v - 100.0 * q.sin()
            };
            assert!((of(&later) - of(&after)).abs() < 1e-6, "seed {seed}: {} {}", of(&later), of(&after));
        }
    }
}

/// A cable that is named wrongly is told with what there is.
#[test]
fn a_cable_has_a_name_that_stages_know() {
    let stage = |name: &str| format!("{STAY}[[stage]]\nname = \"s\"\nwhen = {{ time = 0.1 }}\nopen = [\"{name}\"]\n");
    assert!(parse("scene.toml", &stage("stay"), &[]).is_ok());
    let said = parse("scene.toml", &stage("sty"), &[]).expect_err("a wrong name").render(false);
    assert!(said.contains("did you mean `stay`?"), "{said}");
}
