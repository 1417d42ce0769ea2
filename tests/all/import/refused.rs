//! What cannot be meant is refused, with file, line and a way out.

use super::fixture::{joint, link, refused, robot};

#[test]
fn names_that_are_not_there() {
    let text = robot(&format!(
        "{}{}",
        link("arm"),
        joint("j", "revolut", ["bas", "arm"], "<mimic joint=\"k\"/><limit lower=\"1\" upper=\"-1\"/>")
    ));
    insta::assert_snapshot!(refused(&text), @"");
    insta::assert_snapshot!(refused(&text.replace("bas\"/><child", "base\"/><child")), @"");
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
    insta::assert_snapshot!(refused(&text), @"");
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
    insta::assert_snapshot!(refused(&circle), @"");
    let twice = robot(&format!(
        "{}{}{}{}",
        link("a"),
        link("a"),
        joint("j", "continuous", ["base", "a"], ""),
        joint("j", "continuous", ["base", "a"], "")
    ));
    insta::assert_snapshot!(refused(&twice), @"");
    insta::assert_snapshot!(refused(&robot(&link("loose"))), @"");
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
    insta::assert_snapshot!(refused(&text), @"");
}

#[test]
fn files_that_are_no_robots() {
    insta::assert_snapshot!(refused("<robot name=\"cut\"><link name=\"a\""), @"");
    insta::assert_snapshot!(refused("<sdf version=\"1.7\"/>"), @"");
    insta::assert_snapshot!(refused("<robot name=\"empty\"/>"), @"");
    let xacro = "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\">\n<xacro:include filename=\"a.xacro\"/></robot>";
    insta::assert_snapshot!(refused(xacro), @"");
}
