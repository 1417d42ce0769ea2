//! What makes no sense is refused, with place, value and a way out.

use super::{import, world};

/// The one thing that is wrong with a model.
fn wrong(text: &str) -> String {
    let refused = import(text).map(|imported| imported.scenario).expect_err("it makes no sense").to_string();
    refused
        .lines()
        .map(|line| line.rsplit_once("model.xml:").map_or(line, |(_, rest)| rest))
        .collect::<Vec<_>>()
        .join("\n")
}

#[test]
fn every_mistake_names_its_place() {
    let body = |inner: &str| world(&format!("\n<body name=\"a\">\n{inner}\n<geom size=\"0.1\"/></body>"));
    let after = |inner: &str| {
        format!(
            "<mujoco><worldbody><body name=\"a\"><joint name=\"elbow\"/><geom size=\"0.1\"/></body></worldbody>\n{inner}</mujoco>"
        )
    };
    let cases = [
        (
            body("<joint type=\"hing\"/>"),
            "3: <joint> of body `a`: `type` must be one of \"hinge\", \"slide\", \"ball\", \"free\", found \"hing\" (did you mean \"hinge\"?)",
        ),
        (
            body("<joint axis=\"0 0 0\"/>"),
            "3: <joint> of body `a`: `axis` is \"0 0 0\", which has no direction (for example axis=\"0 1 0\")",
        ),
        (body("<joint pos=\"1 2\"/>"), "3: <joint> of body `a`: `pos` must be 3 numbers, found 2: \"1 2\""),
        (
            body("<joint range=\"1 -1\"/>"),
            "3: <joint> of body `a`: `range` is \"1 -1\", from high to low (the lower end comes first)",
        ),
        (body("<joint damping=\"-1\"/>"), "3: <joint> of body `a`: `damping` must be ≥ 0, found -1"),
        (
            body("<geom type=\"box\" size=\"1 2\"/>"),
            "3: <geom> of body `a`: a box needs 3 positive numbers in `size`, found [1.0, 2.0] (sizes are half sizes: radius, half the height, half the edges)",
        ),
        (
            body("<geom type=\"mesh\" mesh=\"x\"/>"),
            "3: <geom> of body `a`: `mesh` is \"x\": there is no such mesh in <asset>",
        ),
        (body("<inertial pos=\"0 0 0\"/>"), "3: <inertial> of body `a`: `mass` is missing"),
        (
            body("<geom size=\"0.1\" quat=\"1 0 0 0\" euler=\"1 2 3\"/>"),
            "3: <geom> of body `a`: `euler` is written beside `quat` (one orientation is enough: keep one of the two)",
        ),
        (
            body("<joint/><freejoint/>"),
            "3: <freejoint> of body `a`: a body with a free joint has no other joints (put it into a body within this one)",
        ),
        (
            body("<joint class=\"arn\"/>"),
            "3: <joint> of body `a`: `class` is \"arn\": there is no such class (classes are declared in <default>)",
        ),
        (
            after("<actuator><motor joint=\"elbo\"/></actuator>"),
            "2: <motor> of <actuator>: `joint` is \"elbo\": there is no such joint (did you mean `elbow`?)",
        ),
        (
            after("<keyframe><key qpos=\"1 2\"/></keyframe>"),
            "2: keyframe 0: `qpos` must have 1 number, found 2 (one number for each hinge and slide, 4 (velocities: 3) for a ball, 7 (6) for a free joint)",
        ),
        (
            after("<equality><weld body1=\"a\" body2=\"a\"/></equality>"),
            "2: <weld> of <equality>: both ends are on the same body",
        ),
        (
            after("<compiler eulerseq=\"xyw\"/>"),
            "2: <compiler>: `eulerseq` must be three of x, y, z, X, Y, Z, found \"xyw\" (\"xyz\" is the default; \"XYZ\" is roll, pitch, yaw as in URDF)",
        ),
        (after("<option gravity=\"0 0 nan\"/>"), "2: <option>: `gravity` is nan, which is not a finite number"),
    ];
    for (model, expected) in cases {
        assert_eq!(wrong(&model), expected);
    }
}

#[test]
fn a_mass_that_only_a_mesh_knows_is_asked_for() {
    let model = r#"<mujoco><asset><mesh name="m" file="none.stl"/></asset><worldbody>
<body name="a"><joint/><geom type="mesh" mesh="m"/></body></worldbody></mujoco>"#;
    let refused = wrong(model);
    assert!(refused.starts_with("2: body `a`: its mass follows from a mesh"), "{refused}");
    assert!(refused.contains("give the body an <inertial>"), "{refused}");
}

/// What MuJoCo refuses, too: nothing that moves with the body by no joint of its own weighs anything.
#[test]
fn a_body_that_moves_without_mass_is_refused_if_geoms_do_not_weigh() {
    let inner = |joint: &str, bound: &str| {
        format!(
            r#"<mujoco><compiler inertiafromgeom="false"{bound}/><worldbody><body name="a"><joint/><geom size="0.1"/>
<body name="b">{joint}<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/></body></body></worldbody></mujoco>"#
        )
    };
    let expected = "1: body `a`: `<inertial>` is missing";
    assert!(wrong(&inner("<joint axis=\"1 0 0\"/>", "")).starts_with(expected));
    assert!(
        wrong(&inner("<joint axis=\"1 0 0\"/>", " boundmass=\"0.1\"")).starts_with(expected),
        "mass without inertia"
    );
    assert!(super::import(&inner("", "")).is_ok());
}

#[test]
fn what_bends_alone_is_named() {
    let said =
        wrong(&world("\n<composite type=\"cable\" count=\"9 1 1\" size=\"1\"><geom size=\"0.01\"/></composite>"));
    assert!(said.starts_with("2: `composite` is not imported, and the model has no other body"), "{said}");
    assert!(said.contains("[[beam]]"), "{said}");
}

#[test]
fn all_mistakes_are_said_at_once() {
    let model = world("\n<body name=\"a\"><joint axis=\"0 0 0\"/>\n<geom size=\"-1\"/>\n<geom type=\"bix\"/></body>");
    assert_eq!(wrong(&model).lines().count(), 3, "{}", wrong(&model));
}
