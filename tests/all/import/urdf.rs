//! URDF: every element becomes what it means.

use super::fixture::{import, joint, link, notes, refused, robot};
use crate::common::{build, relative_difference};
use nalgebra::{UnitQuaternion, Vector3};
use std::sync::Arc;
use stillpoint::dynamics::System;
use stillpoint::import::Options;
use stillpoint::model::Model;
use stillpoint::scenario::{self, Override};

const G: f64 = 9.80665;

fn model(text: &str, options: &Options, changes: &[&str]) -> Arc<Model> {
    let changes: Vec<Override> = changes.iter().map(|text| Override::parse(text).expect("a change")).collect();
    let imported = import(text, options);
    let scenario =
        scenario::parse("robot.toml", &imported.scenario, &changes).unwrap_or_else(|error| panic!("{error}"));
    build(&scenario.description)
}

fn accelerations(model: &Arc<Model>) -> Vec<f64> {
    let mut accelerations = model.start_velocity.clone();
    System::new(model)
        .at(0.0, &model.start_position, &model.start_velocity)
        .accelerations(&mut accelerations)
        .expect("accelerations");
    accelerations
}

#[test]
fn a_robot_reads_like_a_scenario() {
    let text = robot(&format!(
        "{}{}{}{}",
        link("upper").replace(
            "</link>",
            "<visual><origin xyz=\"0 0 -0.5\"/><geometry><box size=\"0.1 0.1 1\"/></geometry>\
             <material name=\"red\"><color rgba=\"1 0 0 1\"/></material></visual></link>"
        ),
        joint(
            "shoulder",
            "revolute",
            ["base", "upper"],
            "<origin xyz=\"0 0 2\" rpy=\"0 0 0.1\"/><axis xyz=\"0 1 0\"/>\
             <limit lower=\"-1\" upper=\"0.1\" effort=\"10\" velocity=\"3\"/><dynamics damping=\"0.3\" friction=\"0.1\"/>",
        ),
        link("lower").replace(
            "</link>",
            "<visual><geometry><sphere radius=\"0.1\"/></geometry><material name=\"red\"/></visual>\
             <visual><geometry><cylinder radius=\"0.1\" length=\"0.3\"/></geometry></visual></link>"
        ),
        joint("slide", "prismatic", ["upper", "lower"], "<axis xyz=\"0 0 -1\"/><limit lower=\"0.2\" upper=\"0.5\"/>"),
    ));
    let imported = import(&text, &Options { prefix: "left/".into(), at: [0.0, 0.0, 1.0], ..Options::default() });
    insta::assert_snapshot!(imported.scenario, @r###"
    # Imported from robot.urdf.
    title = "test"

    [[body]]
    name = "left/base"
    hinge = { type = "fixed", at = [0.0, 0.0, 1.0] }

    # joint `shoulder`, revolute
    # its effort: write `limit = 10.0` into every [[motor]] in it
    [[body]]
    name = "left/upper"
    hinge = { type = "revolute", parent = "left/base", at = [0.0, 0.0, 2.0], rpy = [0.0, 0.0, 0.1], axis = [0.0, 1.0, 0.0], limits = [-1.0, 0.1], damping = 0.3, friction = 0.1 }
    mass = 2.0
    center = [0.0, 0.0, -0.5]
    inertia = [0.2, 0.2, 0.05]
    shape = { box = [0.1, 0.1, 1.0], at = [0.0, 0.0, -0.5], color = [1.0, 0.0, 0.0, 1.0] }

    # joint `slide`, prismatic
    [[body]]
    name = "left/lower"
    hinge = { type = "prismatic", parent = "left/upper", axis = [0.0, 0.0, -1.0], position = 0.2, limits = [0.2, 0.5] }
    mass = 2.0
    center = [0.0, 0.0, -0.5]
    inertia = [0.2, 0.2, 0.05]
    shape = [
      { sphere = 0.1, color = [1.0, 0.0, 0.0, 1.0] },
      { cylinder = [0.1, 0.3] },
    ]
    "###);
    insta::assert_snapshot!(notes(&imported), @r###"
    4: used: <limit> of joint `shoulder`: `effort = 10`: no motor acts in it; of a scenario with this file as its `model` it is the `limit` of every [[motor]] in it that has none of its own; converted it is a comment, and limits nothing
    4: ignored: <limit> of joint `shoulder`: `velocity = 3`: hinges have no largest speed
    6: used: <limit> of joint `slide`: 0 is beyond them: the joint starts at 0.2
    "###);
    assert_eq!(
        imported.joints,
        [("shoulder", "left/upper"), ("slide", "left/lower")].map(|(a, b)| (a.into(), b.into()))
    );
}

/// Many a robot stands on a link of this name.
#[test]
fn a_link_called_ground_has_another_name() {
    let text = robot(&format!(
        "{}{}{}{}",
        link("ground"),
        joint("stand", "fixed", ["base", "ground"], ""),
        link("ground_link"),
        joint("turn", "continuous", ["ground", "ground_link"], "<axis xyz=\"0 1 0\"/>"),
    ));
    let imported = import(&text, &Options::default());
    insta::assert_snapshot!(notes(&imported), @"3: used: link `ground`: it is called `ground_link_link` here: `ground` is what does not move");
    let model = model(&text, &Options::default(), &[]);
    let named = |name: &str| model.bodies.iter().position(|body| body.name == name).expect("a body");
    let parent = model.bodies[named("ground_link")].parent;
    assert_eq!(parent, Some(named("ground_link_link")));
    // With a prefix it keeps its name.
    let prefixed = import(&text, &Options { prefix: "left/".into(), ..Options::default() });
    assert!(prefixed.notes.is_empty(), "{:?}", prefixed.notes);
    assert!(prefixed.scenario.contains("name = \"left/ground\""), "{}", prefixed.scenario);
}

/// What follows a joint that is not there has to be let go by whoever wants the rest.
#[test]
fn mimics_can_be_left_out() {
    let text = robot(&format!(
        "{}{}{}{}",
        link("a"),
        joint("left_a", "continuous", ["base", "a"], "<axis xyz=\"0 1 0\"/>"),
        link("b"),
        joint("left_b", "continuous", ["a", "b"], "<axis xyz=\"0 1 0\"/><mimic joint=\"a\" multiplier=\"2\"/>"),
    ));
    let said = refused(&text);
    assert!(said.contains("there is no joint `a`") && said.contains("did you mean `left_a`?"), "{said}");
    let options = Options { without_mimics: true, ..Options::default() };
    let imported = import(&text, &options);
    insta::assert_snapshot!(notes(&imported), @"6: ignored: <mimic> of joint `left_b`: left out, as asked for: the joint moves by itself");
    assert!(model(&text, &options, &[]).gears.is_empty());
}

#[test]
fn what_is_not_taken_is_listed_line_by_line() {
    let text = robot(&format!(
        "{}{}{}",
        link("arm").replace(
            "</link>",
            "<collision><geometry><box size=\"1 1 1\"/></geometry></collision>\n\
             <visual><geometry><mesh filename=\"package://parts/arm.stl\"/></geometry></visual>\n\
             <sensor name=\"eye\"><camera/></sensor></link>"
        ),
        joint(
            "turn",
            "continuous",
            ["base", "arm"],
            "<safety_controller k_velocity=\"3\"/><limit effort=\"2\" lower=\"1\"/>"
        ),
        "<transmission name=\"motor\"><joint name=\"turn\"/></transmission>\n<gazebo reference=\"arm\"/>\n\
         <wheel name=\"spare\"><rim/></wheel>\nstray words\n",
    ));
    insta::assert_snapshot!(notes(&import(&text.replace("<link name=\"base\"/>", "<link name=\"base\" colour=\"red\"/>"), &Options::default())), @r###"
    2: ignored: link `base`: `colour = "red"` is not known here
    3: ignored: <collision> of link `arm`: it touches nothing without `[model] contact = true`
    4: ignored: <mesh> of <geometry> of <visual> of link `arm`: no file `package://parts/arm.stl`: it is not drawn; say where the package is with `--package parts=FOLDER` or ROS_PACKAGE_PATH
    5: ignored: sensor `eye`: sensors are not imported: describe what they measure with `[[output]]`
    6: ignored: <safety_controller> of joint `turn`: controllers are not imported: describe them with `[[controller]]`
    6: used: <limit> of joint `turn`: `effort = 2`: no motor acts in it; of a scenario with this file as its `model` it is the `limit` of every [[motor]] in it that has none of its own; converted it is a comment, and limits nothing
    6: ignored: <limit> of joint `turn`: a continuous joint has no `lower` and `upper`
    7: ignored: transmission `motor`: actuators and their gears are not imported: describe them with `[[motor]]` and `[[gear]]`
    8: ignored: <gazebo>: meant for Gazebo
    9: ignored: wheel `spare`: not known here, nor is anything within it
    9: ignored: <robot>: the text `stray words`
    "###);
}

/// One joint of every type, and what its link does when it is let go.
#[test]
fn every_joint_moves_as_its_type_says() {
    let fall = |kind: &str, inner: &str| {
        let text = robot(&format!("{}{}", link("arm"), joint("j", kind, ["base", "arm"], inner)));
        accelerations(&model(&text, &Options::default(), &[]))
    };
    // 2 kg at 0.5 m, held by a horizontal axis through the origin, turned to the side by π/2: m g c / (m c² + J).
    let level = "<origin xyz=\"0 0 0\" rpy=\"0 1.5707963267948966 0\"/><axis xyz=\"0 1 0\"/>";
    let pendulum = 2.0 * G * 0.5 / (2.0 * 0.25 + 0.2);
    for kind in ["revolute", "continuous"] {
        let found = fall(kind, &format!("{level}<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/>"));
        assert!((found[0] + pendulum).abs() < 1e-12 || (found[0] - pendulum).abs() < 1e-12, "{kind}: {found:?}");
    }
    // Down a slope of 30°.
    let slope = fall(
        "prismatic",
        "<origin rpy=\"0 0.5235987755982988 0\"/><axis xyz=\"2 0 0\"/><limit lower=\"-1\" upper=\"1\"/>",
    );
    assert!((slope[0] - 0.5 * G).abs() < 1e-12, "{slope:?}");
    assert_eq!(fall("fixed", ""), [0.0; 0]);
    let free = fall("floating", "");
    assert!((free[2] + G).abs() < 1e-12 && free.iter().enumerate().all(|(i, a)| i == 2 || a.abs() < 1e-12), "{free:?}");
    // In a plane whose normal leans by 30° from upright: g sin 30° down the slope, nothing else.
    let axis = "<axis xyz=\"0.5 0 0.8660254037844386\"/>";
    let plane = fall("planar", axis);
    assert!((plane[0].hypot(plane[1]) - 0.5 * G).abs() < 1e-12, "{plane:?}");
    // In an upright plane it falls freely.
    let wall = fall("planar", "<axis xyz=\"1 0 0\"/>");
    assert!((wall[0].hypot(wall[1]) - G).abs() < 1e-12 && wall[2].abs() < 1e-11, "{wall:?}");
    assert_eq!(fall("planar", "<axis xyz=\"0 0 1\"/>"), [0.0; 3]);
}

/// The link of a planar joint keeps its own axes at zero, wherever the normal points.
#[test]
fn a_tilted_plane_leaves_the_link_where_its_joint_says() {
    for axis in ["1 0 0", "0 -2 0", "0 0 -1", "0.3 -0.4 0.5"] {
        let inner = format!("<origin xyz=\"1 2 3\" rpy=\"0.1 0.2 0.3\"/><axis xyz=\"{axis}\"/>");
        let text = robot(&format!("{}{}", link("sledge"), joint("slide", "planar", ["base", "sledge"], &inner)));
        let imported = import(&text, &Options::default());
        assert_eq!(imported.joints, [("slide".to_owned(), "slide".to_owned())], "the plane carries the joint's name");
        let model = model(&text, &Options::default(), &[]);
        let mut system = System::new(&model);
        let mut poses = Vec::new();
        system.at(0.0, &model.start_position, &model.start_velocity).poses(&mut poses);
        let pose = poses[model.body("sledge").expect("the link")];
        let turn = UnitQuaternion::from_euler_angles(0.1, 0.2, 0.3);
        assert!((pose.translation.vector - Vector3::new(1.0, 2.0, 3.0)).norm() < 1e-14);
        assert!(pose.rotation.angle_to(&turn) < 1e-14, "{axis}");
    }
}

/// An inertia given in turned axes is the same body as one given in the link's own.
#[test]
fn inertial_axes_may_be_turned() {
    let inertia = |rpy: &str, values: [f64; 6]| {
        let [xx, yy, zz, xy, xz, yz] = values;
        let inner = format!(
            "<link name=\"top\"><inertial><origin xyz=\"0.1 0 -0.3\" rpy=\"{rpy}\"/><mass value=\"3\"/><inertia ixx=\"{xx}\" \
             iyy=\"{yy}\" izz=\"{zz}\" ixy=\"{xy}\" ixz=\"{xz}\" iyz=\"{yz}\"/></inertial></link>{}",
            joint("j", "floating", ["base", "top"], "")
        );
        let spin = ["top.velocity=[0,0,0,1.0,2.0,3.0]"];
        accelerations(&model(&robot(&inner), &Options::default(), &spin))
    };
    // A quarter turn about z swaps x and y, and turns xy round.
    let turned = inertia("0 0 1.5707963267948966", [0.3, 0.2, 0.4, 0.05, 0.02, 0.01]);
    let plain = inertia("0 0 0", [0.2, 0.3, 0.4, -0.05, -0.01, 0.02]);
    assert!(relative_difference(&turned, &plain) < 1e-14, "{turned:?} {plain:?}");
}

#[test]
fn mimics_follow_with_factor_and_offset() {
    let inner = format!(
        "{}{}{}{}{}{}",
        link("a"),
        link("b"),
        link("c"),
        joint("lead", "revolute", ["base", "a"], "<axis xyz=\"0 1 0\"/><limit effort=\"1\" velocity=\"1\"/>"),
        joint(
            "follow",
            "continuous",
            ["a", "b"],
            "<axis xyz=\"0 1 0\"/><mimic joint=\"lead\" multiplier=\"-2\" offset=\"0.3\"/>"
        ),
        joint("slide", "prismatic", ["b", "c"], "<axis xyz=\"0 0 1\"/><mimic joint=\"follow\" multiplier=\"0.1\"/>"),
    );
    let model = model(&robot(&inner), &Options::default(), &["a.position=0.4", "a.velocity=1.0"]);
    let [lead, follow, slide] = model.start_position[..] else { panic!("three joints") };
    assert_eq!(lead, 0.4, "the leader is where it was told to be");
    assert!((follow - (0.3 - 0.8)).abs() < 1e-15 && (slide - 0.1 * follow).abs() < 1e-15, "{follow} {slide}");
    let found = accelerations(&model);
    assert!((found[1] + 2.0 * found[0]).abs() < 1e-12 * found[0].abs(), "{found:?}");
    assert!((found[2] - 0.1 * found[1]).abs() < 1e-12 * found[0].abs(), "{found:?}");
}

#[test]
fn a_turn_that_follows_a_slide_is_a_rack() {
    let inner = format!(
        "{}{}{}{}",
        link("rack"),
        link("pinion"),
        joint("slide", "prismatic", ["base", "rack"], "<axis xyz=\"1 0 0\"/>"),
        joint(
            "turn",
            "continuous",
            ["base", "pinion"],
            "<axis xyz=\"0 1 0\"/><mimic joint=\"slide\" multiplier=\"20\" offset=\"1\"/>"
        ),
    );
    let model = model(&robot(&inner), &Options::default(), &["rack.position=0.05", "pinion.position=2.0"]);
    assert_eq!(model.start_position, [0.05, 2.0]);
    let found = accelerations(&model);
    assert!((found[1] - 20.0 * found[0]).abs() < 1e-12 * found[1].abs(), "{found:?}");
}

#[test]
fn a_root_that_floats_falls() {
    let text = format!("<robot name=\"rock\">{}</robot>", link("stone"));
    let options = Options { floating: true, at: [0.0, 0.0, 5.0], rpy: [0.0, 0.0, 1.0], ..Options::default() };
    let found = accelerations(&model(&text, &options, &[]));
    assert!((found[2] + G).abs() < 1e-12, "{found:?}");
    assert_eq!(accelerations(&model(&text, &Options::default(), &[])), [0.0; 0]);
}

/// Links without mass on fixed joints are names for places, no more.
#[test]
fn welded_links_without_mass_change_nothing() {
    let arm = format!(
        "{}{}",
        link("arm"),
        joint("j", "continuous", ["base", "arm"], "<origin rpy=\"0 1 0\"/><axis xyz=\"0 1 0\"/>")
    );
    let tool = format!("<link name=\"tool\"/>{}", joint("mount", "fixed", ["arm", "tool"], "<origin xyz=\"0 0 -1\"/>"));
    let bare = accelerations(&model(&robot(&arm), &Options::default(), &[]));
    assert_eq!(accelerations(&model(&robot(&format!("{arm}{tool}")), &Options::default(), &[])), bare);
}

/// Every number of the file is found again, to the last bit.
#[test]
fn no_digit_is_lost() {
    let digits = "0.12345678901234567 -1e-300 7.000000000000001e22";
    let text = robot(&format!(
        "{}{}",
        link("arm"),
        joint("j", "continuous", ["base", "arm"], &format!("<origin xyz=\"{digits}\"/>"))
    ));
    let imported = import(&text, &Options::default());
    let written = imported.scenario.split_once("at = [").and_then(|(_, rest)| rest.split_once(']')).expect("a point").0;
    let bits = |list: &str, cut: &str| {
        list.split(cut).map(|x| x.trim().parse::<f64>().expect("a number").to_bits()).collect::<Vec<_>>()
    };
    assert_eq!(bits(written, ","), bits(digits, " "));
}
