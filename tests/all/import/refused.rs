//! What cannot be meant is refused, with file, line and a way out.

use super::fixture::{joint, link, refused, robot};

#[test]
fn names_that_are_not_there() {
    let text = robot(&format!(
        "{}{}",
        link("arm"),
        joint("j", "revolut", ["bas", "arm"], "<mimic joint=\"k\"/><limit lower=\"1\" upper=\"-1\"/>")
    ));
    insta::assert_snapshot!(refused(&text), @r###"
    error: joint `j`: there is no link `bas`
     --> robot.urdf:4:40
      |
    4 | <joint name="j" type="revolut"><parent link="bas"/><child link="arm"/><mimic joint="k"/><limit lower="1" upper="-1"/></joint>
      |                                        ^^^^^^^^^^
      |
      = help: did you mean `base`?

    robot.urdf: 1 error
    "###);
    insta::assert_snapshot!(refused(&text.replace("bas\"/><child", "base\"/><child")), @r###"
    error: joint `j`: `type` does not know `revolut`
     --> robot.urdf:4:17
      |
    4 | <joint name="j" type="revolut"><parent link="base"/><child link="arm"/><mimic joint="k"/><limit lower="1" upper="-1"/></joint>
      |                 ^^^^^^^^^^^^^^
      |
      = help: did you mean `revolute`?

    error: <mimic> of joint `j`: there is no joint `k`
     --> robot.urdf:4:79
      |
    4 | <joint name="j" type="revolut"><parent link="base"/><child link="arm"/><mimic joint="k"/><limit lower="1" upper="-1"/></joint>
      |                                                                               ^^^^^^^^^
      |
      = help: `mimics = false` in `model`, or `convert --no-mimics`, leaves out all of them

    robot.urdf: 2 errors
    "###);
}

#[test]
fn numbers_that_are_none() {
    let text = robot(&format!(
        "{}{}",
        link("arm").replace("value=\"2\"", "value=\"heavy\"").replace("0 0 -0.5", "0 0 nan"),
        joint(
            "j",
            "continuous",
            ["base", "arm"],
            "<origin xyz=\"0 1\" rpy=\"0 0 ${pi}\"/><axis xyz=\"0 0 0\"/><dynamics damping=\"-1\"/>"
        )
    ));
    insta::assert_snapshot!(refused(&text), @r###"
    error: <mass> of <inertial> of link `arm`: `value` must be a number, found "heavy"
     --> robot.urdf:3:57
      |
    3 | <link name="arm"><inertial><origin xyz="0 0 nan"/><mass value="heavy"/><inertia ixx="0.2" iyy="0.2" izz="0.05" ixy="0" ixz="0" iyz="0...
      |                                                         ^^^^^^^^^^^^^

    error: <origin> of joint `j`: `xyz` must be 3 numbers, found 2: "0 1"
     --> robot.urdf:4:83
      |
    4 | <joint name="j" type="continuous"><parent link="base"/><child link="arm"/><origin xyz="0 1" rpy="0 0 ${pi}"/><axis xyz="0 0 0"/><dyna...
      |                                                                                   ^^^^^^^^^

    error: <origin> of joint `j`: `rpy` must be numbers, found "${pi}"
     --> robot.urdf:4:93
      |
    4 | <joint name="j" type="continuous"><parent link="base"/><child link="arm"/><origin xyz="0 1" rpy="0 0 ${pi}"/><axis xyz="0 0 0"/><dyna...
      |                                                                                             ^^^^^^^^^^^^^^^
      |
      = help: this is a macro: expand it first, as in `xacro robot.xacro > robot.urdf`

    error: <axis> of joint `j`: `xyz` is zero
     --> robot.urdf:4:116
      |
    4 | <joint name="j" type="continuous"><parent link="base"/><child link="arm"/><origin xyz="0 1" rpy="0 0 ${pi}"/><axis xyz="0 0 0"/><dyna...
      |                                                                                                                    ^^^^^^^^^^^
      |
      = help: an axis has a direction

    error: <dynamics> of joint `j`: `damping` is -1, allowed: ≥ 0
     --> robot.urdf:4:139
      |
    4 | ...in xyz="0 1" rpy="0 0 ${pi}"/><axis xyz="0 0 0"/><dynamics damping="-1"/></joint>
      |                                                               ^^^^^^^^^^^^

    robot.urdf: 5 errors
    "###);
}

#[test]
fn links_that_are_no_tree() {
    let circle = robot(&format!(
        "{}{}{}{}",
        link("a"),
        link("b"),
        joint("j", "continuous", ["a", "b"], ""),
        joint("k", "continuous", ["b", "a"], "")
    ));
    insta::assert_snapshot!(refused(&circle), @r###"
    error: the links form a cycle of parents: `b`, child of `a`, child of `b`
     --> robot.urdf:5:43
      |
    5 | <joint name="j" type="continuous"><parent link="a"/><child link="b"/></joint>
      |                                           ^^^^^^^^
      |
      = help: a URDF is a tree; close loops in the scenario, with a [[loop]]

    robot.urdf: 1 error
    "###);
    let twice = robot(&format!(
        "{}{}{}{}",
        link("a"),
        link("a"),
        joint("j", "continuous", ["base", "a"], ""),
        joint("j", "continuous", ["base", "a"], "")
    ));
    insta::assert_snapshot!(refused(&twice), @r###"
    error: there are two links called `a`
     --> robot.urdf:4:7
      |
    4 | <link name="a"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/><inertia ixx="0.2" iyy="0.2" izz="0.05" ixy="0" ixz="0" iyz="0"/></...
      |       ^^^^^^^^
      |
      = help: a link's name stands for it alone

    error: there are two joints called `j`
     --> robot.urdf:6:8
      |
    6 | <joint name="j" type="continuous"><parent link="base"/><child link="a"/></joint>
      |        ^^^^^^^^
      |
      = help: a joint's name stands for it alone

    robot.urdf: 2 errors
    "###);
    insta::assert_snapshot!(refused(&robot(&link("loose"))), @r###"
    error: 2 links are not reached by any joint: `base`, `loose`
     --> robot.urdf:3:1
      |
    3 | <link name="loose"><inertial><origin xyz="0 0 -0.5"/><mass value="2"/><inertia ixx="0.2" iyy="0.2" izz="0.05" ixy="0" ixz="0" iyz="0"...
      | ^^^^^
      |
      = help: a URDF has one root, on which everything hangs; a joint is missing

    robot.urdf: 1 error
    "###);
}

/// A hinge that moves nothing has no acceleration.
#[test]
fn a_moving_leaf_without_mass() {
    let text = robot(&format!(
        "{}<link name=\"ghost\"/>{}{}",
        link("arm"),
        joint("j", "continuous", ["base", "arm"], ""),
        joint("k", "continuous", ["arm", "ghost"], "")
    ));
    insta::assert_snapshot!(refused(&text), @r###"
    error: neither `ghost` nor anything it carries has mass: its hinge would be undetermined
     --> robot.urdf:4:1
      |
    4 | <link name="ghost"/><joint name="j" type="continuous"><parent link="base"/><child link="arm"/></joint>
      | ^^^^^
      |
      = help: give it a mass, weld it with a fixed hinge (`massless = "weld"` in `model`, or `convert --weld-massless`, for all of a model), or give the hinge an armature, as with `--set ghost.armature=1e-6`

    robot.urdf: 1 error
    "###);
}

#[test]
fn files_that_are_no_robots() {
    insta::assert_snapshot!(refused("<robot name=\"cut\"><link name=\"a\""), @r###"
    error: not valid XML: the root node was opened but never closed
     --> robot.urdf:1:1
      |
    1 | <robot name="cut"><link name="a"
      | ^

    robot.urdf: 1 error
    "###);
    insta::assert_snapshot!(refused("<sdf version=\"1.7\"/>"), @r###"
    error: <sdf> is not a model that can be read
     --> robot.urdf:1:1
      |
    1 | <sdf version="1.7"/>
      | ^^^^
      |
      = help: a model is a URDF file, with <robot> around everything, or MJCF, with <mujoco>

    robot.urdf: 1 error
    "###);
    insta::assert_snapshot!(refused("<robot name=\"empty\"/>"), @r###"
    error: <robot> has no <link>
     --> robot.urdf:1:1
      |
    1 | <robot name="empty"/>
      | ^^^^^^

    robot.urdf: 1 error
    "###);
    let xacro = "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n<xacro:include filename=\"a.xacro\"/></robot>";
    insta::assert_snapshot!(refused(xacro), @r###"
    error: <include> is a macro of xacro
     --> robot.urdf:2:1
      |
    2 | <xacro:include filename="a.xacro"/></robot>
      | ^^^^^^^^^^^^^^
      |
      = help: expand it first, as in `xacro robot.urdf.xacro > robot.urdf`

    robot.urdf: 1 error
    "###);
}
