//! What is taken, and as what.

use super::{scenario, world};
use nalgebra::Vector3;
use stillpoint::dynamics::System;
use stillpoint::model::Model;
use stillpoint::model::description::{BodyDescription, HingeKind, Point};
use stillpoint::scenario::{Scenario, load};
use stillpoint::simulate::settings::Start;

fn body<'s>(scenario: &'s Scenario, name: &str) -> &'s BodyDescription {
    scenario.description.bodies.iter().find(|body| body.name == name).unwrap_or_else(|| panic!("no body {name}"))
}

#[test]
fn joints_of_one_body_are_a_chain_that_ends_with_the_body() {
    let scenario = scenario(&world(
        r#"<body name="box" pos="0 0 2">
             <joint name="slide" type="slide" axis="1 0 0"/> <joint name="turn" axis="0 1 0" pos="0 0 0.5"/>
             <joint axis="1 0 0" pos="0.1 0 0.5"/>
             <geom size="0.1" pos="0.3 0 0"/> <site name="eye" pos="0.1 0 1"/>
           </body>"#,
    ));
    let names: Vec<&str> = scenario.description.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["box/slide", "box/turn", "box"]);
    let at = |name: &str| body(&scenario, name).hinge.at.clone();
    assert_eq!(at("box/slide"), Point::At(Vector3::new(0.0, 0.0, 2.0)));
    assert_eq!(at("box/turn"), Point::At(Vector3::new(0.0, 0.0, 0.5)));
    assert_eq!(at("box"), Point::At(Vector3::new(0.1, 0.0, 0.0)));
    // The body's points count from its last joint.
    let last = body(&scenario, "box");
    assert_eq!(last.mass.center, Vector3::new(0.3 - 0.1, 0.0, -0.5));
    assert_eq!(last.markers, [("eye".to_owned(), Vector3::new(0.0, 0.0, 0.5))]);
    assert_eq!(body(&scenario, "box/turn").mass.mass, 0.0);
}

#[test]
fn coordinates_count_from_the_reference() {
    let scenario = scenario(
        r#"<mujoco><worldbody><body name="a"><joint axis="0 1 0" ref="10" springref="40" stiffness="2" range="-20 70"/>
             <geom size="0.1" pos="1 0 0"/></body></worldbody>
           <keyframe><key qpos="0.5" qvel="0.25"/></keyframe></mujoco>"#,
    );
    let hinge = &body(&scenario, "a").hinge;
    let degree = std::f64::consts::PI / 180.0;
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-15, "{a} {b}");
    near(hinge.position[0], 0.5 - 10.0 * degree);
    near(hinge.rest[0], 30.0 * degree);
    near(hinge.limits[0].low, -30.0 * degree);
    near(hinge.limits[0].high, 60.0 * degree);
    assert_eq!(hinge.velocity, [0.25]);
    // A model that moves is not put to rest.
    assert_eq!(scenario.simulate.start, Start::Given);
}

#[test]
fn a_servo_and_a_spring_in_one_hinge_add_up() {
    let scenario = scenario(
        r#"<mujoco><worldbody><body name="a"><joint name="j" axis="0 1 0" stiffness="2" springref="0.3" ref="0.1" damping="0.1"/>
             <geom size="0.1" pos="1 0 0"/></body></worldbody><compiler angle="radian"/>
           <actuator><position joint="j" kp="4" kv="0.5" gear="3"/></actuator>
           <keyframe><key ctrl="1.5"/></keyframe></mujoco>"#,
    );
    let hinge = &body(&scenario, "a").hinge;
    // The servo holds still where 3 qpos = 1.5.
    let (k, servo) = (2.0, 36.0);
    assert!((hinge.stiffness[0] - (k + servo)).abs() < 1e-14);
    assert!((hinge.rest[0] - (k * 0.2 + servo * (0.5 - 0.1)) / (k + servo)).abs() < 1e-15);
    assert!((hinge.damping[0] - (0.1 + 0.5 * 9.0)).abs() < 1e-14);
}

#[test]
fn gravity_is_that_of_mujoco_where_nothing_is_said() {
    let scenario = scenario(&world(r#"<body><freejoint/><geom size="0.1"/></body>"#));
    assert_eq!(scenario.description.gravity, Vector3::new(0.0, 0.0, -9.81));
    assert_eq!(scenario.description.bodies[0].name, "body_1");
    assert!(matches!(scenario.description.bodies[0].hinge.kind, HingeKind::Free));
}

/// Virtual work: with θ the angle of the left crank from the vertical, the jaws (they keep their direction) are
/// d(θ) = 0.052 + 2 L sin θ apart and hang L cos θ below the palm, bars half as deep. The servo pulls to 0.5.
#[test]
fn the_gripper_rests_where_its_servo_its_spring_and_its_weight_balance() {
    let (length, kp, k, g) = (0.06, 3.0, 200.0, 9.81);
    let weight = 2.0 * g * length * (0.05 + 0.02);
    let slope = |angle: f64| {
        let apart = 0.052 + 2.0 * length * angle.sin();
        kp * (angle - 0.5) + k * (apart - 0.03) * 2.0 * length * angle.cos() + weight * angle.sin()
    };
    let (mut low, mut high) = (-0.5, 0.5);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if slope(middle) > 0.0 { high = middle } else { low = middle }
    }
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios/gripper_from_mjcf.toml");
    let scenario = load(std::path::Path::new(path)).unwrap_or_else(|error| panic!("{error}"));
    let model = Model::build(&scenario.description).expect("a model");
    let (model, _) = stillpoint::constraint::assemble(model).expect("it closes");
    let found =
        stillpoint::statics::equilibrium(&model, &scenario.statics, &model.start_position).expect("an equilibrium");
    let at = |name: &str| {
        let body = model.bodies.iter().find(|body| body.name == name).expect(name);
        found.position[body.hinge.position]
    };
    // The root is found to round-off; the equilibrium to its residual.
    assert!((at("left_crank") - low).abs() < 1e-9, "{} {low}", at("left_crank"));
    assert!((at("right_crank") + low).abs() < 1e-9);
    assert!((at("left_jaw") + low).abs() < 1e-9, "the jaws keep their direction");
    let mut system = System::new(&model);
    let mut accelerations = vec![0.0; model.start_velocity.len()];
    system
        .at(0.0, &found.position, &vec![0.0; accelerations.len()])
        .accelerations(&mut accelerations)
        .expect("accelerations");
    assert!(accelerations.iter().all(|a| a.abs() < 1e-6), "{accelerations:?}");
}

/// What bounds make of a body is said, of bodies without geoms, too.
#[test]
fn bounds_of_mass_are_said() {
    let text = r#"<mujoco><compiler boundmass="0.5" boundinertia="0.01"/><worldbody><body name="a"><joint/>
<geom size="0.1"/><body name="bare"><joint axis="1 0 0"/></body></body></worldbody></mujoco>"#;
    let imported = super::import(text).unwrap_or_else(|refused| panic!("{refused}"));
    let said: Vec<&str> = imported.notes.iter().map(|note| note.what.as_str()).collect();
    assert!(said.iter().any(|what| what.contains("make 0.5 kg of 0 kg")), "{said:?}");
    let scene = super::scenario(text).description;
    assert_eq!((scene.bodies[1].mass.mass, scene.bodies[1].mass.inertia.m11), (0.5, 0.01));
}

/// A body that moves may have no `<inertial>` although geoms weigh nothing, if one that is welded to it has mass, or if bounds
/// give it some: MuJoCo loads these. The masses are its own.
#[test]
fn a_welded_body_or_a_bound_weighs_for_one_without_inertial() {
    let carried = |compiler: &str, inertial: &str| {
        format!(
            r#"<mujoco><compiler inertiafromgeom="false"{compiler}/><worldbody><body name="a"><joint axis="0 1 0"/><geom size="0.1"/>
<body name="b"><body name="c" pos="0 0 -0.5">{inertial}<geom size="0.2"/></body></body></body></worldbody></mujoco>"#
        )
    };
    let masses = |text: &str| -> Vec<f64> {
        let bodies = scenario(text).description.bodies;
        bodies.iter().map(|body| body.mass.mass).collect()
    };
    let inertial = r#"<inertial pos="0 0 0" mass="1.25" diaginertia="0.02 0.02 0.02"/>"#;
    assert_eq!(masses(&carried("", inertial)), [0.0, 0.0, 1.25]);
    assert_eq!(masses(&carried(r#" boundmass="0.5" boundinertia="0.01""#, "")), [0.5, 0.5, 0.5]);
}

/// Joints that carry nothing with mass are fixed where they start, if that is asked for; what acts in them is left out.
#[test]
fn massless_joints_are_welded_if_asked_for() {
    let text = r#"<mujoco><worldbody><body name="a"><joint name="j" axis="0 1 0"/><geom size="0.1" pos="0.3 0 0"/>
<body name="f" pos="1 0 0"><joint name="k" axis="0 0 1" pos="0.1 0 0"/><joint name="s" type="slide" axis="1 0 0"/>
<site name="end" pos="0.2 0 0"/><body name="g" pos="0 0 1"><joint name="b" type="ball"/></body></body></body></worldbody>
<actuator><position joint="k" kp="3"/></actuator><keyframe><key qpos="0.2 0.5 0.25 0.8 0.6 0 0"/></keyframe></mujoco>"#;
    let path = std::path::Path::new("model.xml");
    let import = |weld_massless: bool| {
        let options = stillpoint::import::Options { weld_massless, ..Default::default() };
        stillpoint::scenario::convert_text(path, text.to_owned(), &options)
    };
    assert!(import(false).map(|_| ()).expect_err("massless").to_string().contains("--weld-massless"));
    let imported = import(true).unwrap_or_else(|error| panic!("{error}"));
    let said: Vec<&str> = imported.notes.iter().map(|note| note.what.as_str()).collect();
    assert!(said.iter().any(|what| what.contains("it is fixed, as asked for (and so lines 2, 3)")), "{said:?}");
    assert!(said.iter().any(|what| what.contains("the joint `k` is fixed")), "{said:?}");
    let scene =
        stillpoint::scenario::parse("m.toml", &imported.scenario, &[]).unwrap_or_else(|error| panic!("{error}"));
    let model = stillpoint::model::Model::build(&scene.description).expect("a model");
    assert_eq!((model.degrees_of_freedom(), imported.joints.len()), (1, 1));
    // Where MuJoCo's kinematics puts the site: turned by 0.5 about the anchor at (0.1, 0, 0), then slid along its own x.
    let mut poses = Vec::new();
    let mut system = stillpoint::dynamics::System::new(&model);
    let mut a = vec![0.0; 1];
    let q = [0.0];
    let mut at = system.at(0.0, &q, &[0.0]);
    at.accelerations(&mut a).expect("finite");
    at.poses(&mut poses);
    let f = model.body("f").expect("a body");
    let (sine, cosine) = 0.5_f64.sin_cos();
    let expected = [1.1 + 0.35 * cosine, 0.35 * sine];
    let end = scene.description.bodies.iter().find(|body| body.name == "f").expect("a body").markers[0].1;
    let found = (poses[f] * nalgebra::Point3::from(end)).coords;
    // Round-off of a product of turns.
    assert!((found.x - expected[0]).abs() < 1e-14 && (found.y - expected[1]).abs() < 1e-14, "{found}");
}
