//! What loops pass: of many reactions that would do, the smallest, and they are said not to be unique.

use super::read;
use stillpoint::dynamics::System;
use stillpoint::record::{Memory, Opening};
use stillpoint::simulate::{self, Settings, State};

/// A door on two ball hinges: nobody can say how they share its weight, so each is said to carry half. What they pull
/// sideways follows from the weight beside their axis.
const DOOR: &str = r#"
gravity = [0.0, 0.0, -10.0]
[[body]]
name = "door"
mass = 20.0
center = [0.4, 0.0, 0.0]
inertia = [5.0, 6.0, 1.0]
hinge = { type = "free" }
[[loop]]
name = "upper"
type = "spherical"
between = [{ body = "ground", at = [0.0, 0.0, 0.8] }, { body = "door", at = [0.0, 0.0, 0.8] }]
[[loop]]
name = "lower"
type = "spherical"
between = [{ body = "ground", at = [0.0, 0.0, -0.8] }, { body = "door", at = [0.0, 0.0, -0.8] }]
"#;

#[test]
fn a_door_shares_its_weight_among_its_hinges() {
    let (_, model) = read(DOOR);
    assert_eq!(model.degrees_of_freedom(), 1);
    let (q, v) = (&model.start_position, &model.start_velocity);
    let mut system = System::new(&model);
    let (mut a, mut residual) = (v.clone(), v.clone());
    system.accelerations(q, v, &mut a).expect("accelerations");
    system.share_multipliers(q);
    system.residual(q, v, &a, &mut residual).expect("a balance");
    assert!(residual.iter().all(|r| r.abs() < 1e-11), "they still hold the door: {residual:?}");
    let found = system.loop_reactions();
    let pull = 200.0 * 0.4 / 1.6;
    for (reaction, name, sign) in [(&found[0], "upper", -1.0), (&found[1], "lower", 1.0)] {
        assert_eq!(reaction.name, name);
        assert!((reaction.force.z - 100.0).abs() < 1e-10, "{reaction:?}");
        assert!((reaction.force.x - sign * pull).abs() < 1e-10 && reaction.force.y.abs() < 1e-10, "{reaction:?}");
        assert!(reaction.moment.norm() < 1e-10 && !reaction.unique && reaction.gap < 1e-15, "{reaction:?}");
    }
}

/// One of them alone, as a hinge of the tree, leaves nothing to choose but along the axis; a rod is unique.
#[test]
fn what_is_unique_is_said_to_be() {
    let text = "gravity = [0.0, 0.0, -10.0]\n[[body]]\nname = \"lamp\"\nmass = 3.0\ncenter = [1.0, 0.0, 0.0]\n\
                inertia = [0.1, 0.1, 0.1]\nhinge = { type = \"revolute\", axis = [0.0, 1.0, 0.0] }\n\
                [[body]]\nname = \"stay\"\nmass = 0.5\ninertia = [0.1, 0.1, 0.1]\n\
                hinge = { type = \"revolute\", at = [0.0, 0.0, 1.0], axis = [0.0, 1.0, 0.0] }\n\
                [[loop]]\nname = \"rod\"\ntype = \"rod\"\nlength = 1.4142135623730951\n\
                between = [\"stay\", { body = \"lamp\", at = [1.0, 0.0, 0.0] }]\n";
    let (_, model) = read(text);
    let (q, v) = (&model.start_position, &model.start_velocity);
    let mut system = System::new(&model);
    let mut a = v.clone();
    system.accelerations(q, v, &mut a).expect("accelerations");
    system.share_multipliers(q);
    let rod = &system.loop_reactions()[0];
    // A weight of 30 N at its end, on a rod at 45 degrees: it pulls with 30 N times the root of two.
    let pull = 30.0 * 2.0_f64.sqrt();
    assert!(rod.unique && (rod.force.norm() - pull).abs() < 1e-10, "{rod:?}");
    assert!((rod.force.x + 30.0).abs() < 1e-10 && (rod.force.z - 30.0).abs() < 1e-10, "{rod:?}");
}

/// Recordings tell what loops, drives, motors and gears push with, by name and with units.
#[test]
fn recordings_tell_what_couplings_push_with() {
    let text = format!(
        "{DOOR}[[body]]\nname = \"lift\"\nmass = 3.0\ninertia = [1, 1, 1]\n\
         hinge = {{ type = \"prismatic\", axis = [0, 0, 1] }}\n\
         [[drive]]\nname = \"winch\"\nhinge = \"lift\"\ntype = \"rate\"\nrate = 0.5\n\
         [[body]]\nname = \"wheel\"\nmass = 3.0\ninertia = [1, 1, 1]\n\
         hinge = {{ type = \"revolute\", axis = [0, 0, 1] }}\n\
         [[motor]]\nname = \"spindle\"\nhinge = \"wheel\"\ntype = \"constant\"\nforce = 2.5\n"
    );
    let (scenario, model) = read(&text);
    let scene = simulate::scene(&model);
    let names: Vec<String> =
        scene.couplings.iter().map(|one| format!("{}.{} [{}]", one.body, one.name, one.unit)).collect();
    assert_eq!(names[..3], ["winch.force [N]", "spindle.torque [N m]", "upper.force x [N]"]);
    assert_eq!((names.len(), names[8].as_str()), (16, "upper.gap [m]"));
    let mut memory = Memory::new(&Opening { scene: &scene, scenario: &scenario.text, statics: None });
    let start = State { position: model.start_position.clone(), velocity: model.start_velocity.clone() };
    let settings = Settings { duration: 0.2, ..Settings::default() };
    simulate::run(&model, &settings, 10.0, &start, &mut memory, &mut |_, _| true).expect("a run");
    assert_eq!(memory.samples.len(), 3);
    for sample in &memory.samples {
        assert!((sample.couplings[0] - 30.0).abs() < 1e-9 && sample.couplings[1] == 2.5);
        assert!((sample.couplings[4] - 100.0).abs() < 1e-6, "{:?}", sample.couplings);
    }
}
