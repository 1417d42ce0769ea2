//! What people see when something is wrong in a scenario: exact messages.

use stillpoint::scenario::{self, Override};

/// What is said about a scenario that must be refused.
fn said(text: &str, overrides: &[&str]) -> String {
    let overrides: Vec<Override> =
        overrides.iter().map(|text| Override::parse(text).expect("an override with path and value")).collect();
    match scenario::parse("scene.toml", text, &overrides) {
        Ok(_) => "nothing".to_owned(),
        Err(diagnostics) => diagnostics.to_string(),
    }
}

#[test]
fn an_unknown_key_near_a_known_one() {
    let text = r#"
[[body]]
name = "bob"
masss = 1.0
hinge = { type = "free" }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: body `bob`: unknown key `masss`
     --> scene.toml:3:1
      |
    3 | masss = 1.0
      | ^^^^^
      |
      = help: did you mean `mass`?

    scene.toml: 1 error
    "#);
}

#[test]
fn an_unknown_key_far_from_all() {
    let text = r#"
[[body]]
name = "bob"
mass = 1.0
hinge = { type = "free" }

[record]
colour = "red"
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: [record]: unknown key `colour`
     --> scene.toml:7:1
      |
    7 | colour = "red"
      | ^^^^^^
      |
      = help: allowed: `rate`, `ros`

    scene.toml: 1 error
    "#);
}

#[test]
fn a_wrong_type() {
    let text = r#"
[[body]]
name = "bob"
mass = "heavy"
center = [0.0, 1.0]
hinge = { type = "free" }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: body `bob`: `mass` must be a number or a list of numbers, found the text "heavy"
     --> scene.toml:3:8
      |
    3 | mass = "heavy"
      |        ^^^^^^^
      |
      = help: for example `mass = 2.0`

    error: body `bob`: `center` must be a list of 3 numbers, found a list of 2
     --> scene.toml:4:10
      |
    4 | center = [0.0, 1.0]
      |          ^^^^^^^^^^
      |
      = help: for example `center = [0.0, 0.0, -0.5]`

    scene.toml: 2 errors
    "#);
}

#[test]
fn numbers_that_are_not_finite() {
    let text = r#"
[[body]]
name = "bob"
mass = nan
center = [0.0, inf, 0.0]
hinge = { type = "free" }

[simulate]
duration = 1e999
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: body `bob`: `mass` is nan, which is not a finite number
     --> scene.toml:3:8
      |
    3 | mass = nan
      |        ^^^

    error: body `bob`: `center[1]` is inf, which is not a finite number
     --> scene.toml:4:16
      |
    4 | center = [0.0, inf, 0.0]
      |                ^^^

    error: [simulate]: `duration` is 1e999, which is not a finite number
     --> scene.toml:8:12
      |
    8 | duration = 1e999
      |            ^^^^^

    scene.toml: 3 errors
    "#);
}

#[test]
fn numbers_out_of_range() {
    let text = r#"
[[body]]
name = "bob"
mass = -1
hinge = { type = "free" }

[simulate]
duration = 0
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: body `bob`: `mass` is -1, allowed: ≥ 0 kg
     --> scene.toml:3:8
      |
    3 | mass = -1
      |        ^^

    error: [simulate]: `duration` is 0, allowed: > 0 s
     --> scene.toml:7:12
      |
    7 | duration = 0
      |            ^

    scene.toml: 2 errors
    "#);
}

#[test]
fn a_missing_hinge_type() {
    let text = r#"
[[body]]
name = "bob"
mass = 1.0
hinge = { parent = "ground" }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: hinge of body `bob`: `type` is missing
     --> scene.toml:4:9
      |
    4 | hinge = { parent = "ground" }
      |         ^^^^^^^^^^^^^^^^^^^^^
      |
      = help: `type` is one of `fixed`, `revolute`, `prismatic`, `screw`, `along`, `cylindrical`, `universal`, `planar`, `spherical`, `free`

    scene.toml: 1 error
    "#);
}

#[test]
fn an_unknown_hinge_type() {
    let text = r#"
[[body]]
name = "bob"
mass = 1.0
hinge = { type = "revolut" }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: hinge of body `bob`: unknown hinge type `revolut`
     --> scene.toml:4:18
      |
    4 | hinge = { type = "revolut" }
      |                  ^^^^^^^^^
      |
      = help: did you mean `revolute`?

    scene.toml: 1 error
    "#);
}

#[test]
fn a_bad_axis() {
    let text = r#"
[[body]]
name = "bob"
mass = 1.0
hinge = { type = "revolute", axis = "y" }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: hinge of body `bob`: `axis` must be a list of 3 numbers, found the text "y"
     --> scene.toml:4:37
      |
    4 | hinge = { type = "revolute", axis = "y" }
      |                                     ^^^
      |
      = help: for example `axis = [0.0, 1.0, 0.0]`

    scene.toml: 1 error
    "#);
}

#[test]
fn a_missing_axis() {
    let text = r#"
[[body]]
name = "bob"
mass = 1.0
hinge = { type = "prismatic" }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: hinge of body `bob`: `axis` is missing
     --> scene.toml:4:9
      |
    4 | hinge = { type = "prismatic" }
      |         ^^^^^^^^^^^^^^^^^^^^^^
      |
      = help: for example `axis = [0.0, 1.0, 0.0]`

    scene.toml: 1 error
    "#);
}

#[test]
fn a_key_of_another_hinge_type() {
    let text = r#"
[[body]]
name = "bob"
mass = 1.0
hinge = { type = "spherical", axis = [0, 1, 0] }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: hinge of body `bob`: a spherical hinge has no `axis`
     --> scene.toml:4:31
      |
    4 | hinge = { type = "spherical", axis = [0, 1, 0] }
      |                               ^^^^
      |
      = help: for the types `revolute`, `prismatic`, `screw`, `cylindrical`

    scene.toml: 1 error
    "#);
}

#[test]
fn a_scalar_where_a_list_is_needed() {
    let text = r#"
[[body]]
name = "bob"
mass = 1.0
hinge = { type = "planar", stiffness = 2.0, position = 0.3 }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: hinge of body `bob`: `position` of a planar hinge must be a list of 3 numbers; found one number
     --> scene.toml:4:56
      |
    4 | hinge = { type = "planar", stiffness = 2.0, position = 0.3 }
      |                                                        ^^^
      |
      = help: in this order: x, y, about z

    scene.toml: 1 error
    "#);
}

#[test]
fn both_errors_of_a_file() {
    let text = r#"
[[body]]
name = "a"
mass = -1.0
hinge = { type = "free", parent = "b" }

[[body]]
name = "c"
inertia = [1.0, 1.0, 3.0]
mass = 2.0
hinge = { type = "fixed" }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: body `a`: `mass` is -1.0, allowed: ≥ 0 kg
     --> scene.toml:3:8
      |
    3 | mass = -1.0
      |        ^^^^

    error: there is no body `b`
     --> scene.toml:4:35
      |
    4 | hinge = { type = "free", parent = "b" }
      |                                   ^^^

    error: no body can have the inertia of `c`: the sum of its two smaller principal moments falls short of the largest by 33.333 % (principal moments 1, 1, 3 kg m²)
     --> scene.toml:8:11
      |
    8 | inertia = [1.0, 1.0, 3.0]
      |           ^^^^^^^^^^^^^^^
      |
      = help: inertia is about the centre of mass, in body axes; a flat body sits exactly on the limit

    scene.toml: 3 errors
    "#);
}

#[test]
fn an_error_in_a_repeat_once() {
    let text = r#"
[[body]]
name = "link"
repeat = 1000
mass = 1.0
hinge = { type = "revolute", axis = [0, 0, 0] }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: the axis of the hinge of `link[0]` is [0, 0, 0] (and 999 more copies)
     --> scene.toml:5:37
      |
    5 | hinge = { type = "revolute", axis = [0, 0, 0] }
      |                                     ^^^^^^^^^
      |
      = help: allowed: a finite vector that is not zero

    scene.toml: 1 error
    "#);
}

#[test]
fn a_screw_without_pitch() {
    let text = r#"
[[body]]
name = "nut"
mass = 1.0
inertia = [0.1, 0.1, 0.1]
hinge = { type = "screw", axis = [0, 0, 1], pitch = 0.0 }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: the pitch of the hinge of `nut` is 0 m/rad
     --> scene.toml:5:53
      |
    5 | hinge = { type = "screw", axis = [0, 0, 1], pitch = 0.0 }
      |                                                     ^^^
      |
      = help: allowed: a finite number that is not zero, negative for a left-hand thread; a hinge that turns without sliding is `revolute`

    scene.toml: 1 error
    "#);
}

#[test]
fn a_wrong_marker_between_copies_once() {
    let text = r#"
[[body]]
name = "link"
repeat = 1000
mass = 1.0
markers = { tip = [0, 0, -1] }
hinge = { type = "revolute", axis = [0, 1, 0], next = "tpi" }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: `link[0]` has no marker `tpi` (and 998 more copies)
     --> scene.toml:6:55
      |
    6 | hinge = { type = "revolute", axis = [0, 1, 0], next = "tpi" }
      |                                                       ^^^^^
      |
      = help: did you mean `tip`?

    scene.toml: 1 error
    "#);
}

#[test]
fn the_bad_one_of_a_list_per_copy() {
    let text = r#"
[[body]]
name = "link"
repeat = 3
mass = [1.0, -2.0, 3.0]
hinge = { type = "revolute", axis = [0, 1, 0], position = [0.1, 0.2] }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: body `link`: `mass[1]` is -2.0, allowed: ≥ 0 kg
     --> scene.toml:4:14
      |
    4 | mass = [1.0, -2.0, 3.0]
      |              ^^^^

    error: hinge of body `link`: `position` of a revolute hinge must be one number, or a list of 3, one per copy; found a list of 2
     --> scene.toml:5:59
      |
    5 | hinge = { type = "revolute", axis = [0, 1, 0], position = [0.1, 0.2] }
      |                                                           ^^^^^^^^^^

    scene.toml: 2 errors
    "#);
}

#[test]
fn a_wrong_marker_of_a_force() {
    let text = r#"
[[body]]
name = "bob"
mass = 1.0
hinge = { type = "free" }

[[force]]
type = "load"
on = "bob.tip"
force = [0, 0, 1]

[[force]]
type = "spring"
between = ["bbo", { body = "ground", at = [0, 0, 1] }]
stiffness = 3.0
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: `bob` has no marker `tip`
     --> scene.toml:8:6
      |
    8 | on = "bob.tip"
      |      ^^^^^^^^^
      |
      = help: `bob` has no markers: give coordinates instead

    error: there is no body `bbo`
      --> scene.toml:13:12
       |
    13 | between = ["bbo", { body = "ground", at = [0, 0, 1] }]
       |            ^^^^^
       |
       = help: did you mean `bob`?

    error: force `force[1]`: `length` is missing beside `stiffness`
      --> scene.toml:14:1
       |
    14 | stiffness = 3.0
       | ^^^^^^^^^
       |
       = help: without its unstretched length [m] the tension of a spring is not known; write `length = 0.0` if it is meant

    scene.toml: 3 errors
    "#);
}

#[test]
fn density_beside_mass() {
    let text = r#"
[[body]]
name = "bob"
mass = 1.0
density = 7850.0
shape = { sphere = 0.1 }
hinge = { type = "free" }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: body `bob`: both `density` and `mass`
     --> scene.toml:3:1
      |
    3 | mass = 1.0
      | ^^^^
      |
      = help: with `density`, mass, centre and inertia follow from the shapes: keep one of the two

    scene.toml: 1 error
    "#);
}

#[test]
fn density_without_a_volume() {
    let text = r#"
[[body]]
name = "bob"
density = 7850.0
hinge = { type = "free" }

[[body]]
name = "mesh"
density = 7850.0
shape = { mesh = "bob.stl" }
hinge = { type = "free" }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: body `bob`: `density` needs a shape with a volume
     --> scene.toml:3:1
      |
    3 | density = 7850.0
      | ^^^^^^^
      |
      = help: give a `shape`: a box, sphere, cylinder, capsule or closed mesh

    error: body `mesh`: cannot read the mesh `bob.stl`: No such file or directory (os error 2)
     --> scene.toml:9:9
      |
    9 | shape = { mesh = "bob.stl" }
      |         ^^^^^^^^^^^^^^^^^^^^
      |
      = help: with `density` the mesh is needed for its volume

    warning: there is no mesh file `bob.stl`: it is not drawn
     --> scene.toml:9:18
      |
    9 | shape = { mesh = "bob.stl" }
      |                  ^^^^^^^^^

    scene.toml: 2 errors, 1 warning
    "#);
}

#[test]
fn inertia_without_mass() {
    let text = r#"
[[body]]
name = "bob"
inertia = [1.0, 1.0, 1.0]
hinge = { type = "free" }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: body `bob`: `inertia` without `mass`
     --> scene.toml:3:1
      |
    3 | inertia = [1.0, 1.0, 1.0]
      | ^^^^^^^
      |
      = help: give `mass`, or `density` to have both follow from the shapes

    scene.toml: 1 error
    "#);
}

#[test]
fn friction_that_is_larger_in_motion() {
    let text = r#"
[[body]]
name = "bob"
mass = 1.0
hinge = { type = "free", friction = { stick = 0.1, slide = 0.2 } }

"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: the friction of the hinge of `bob` is 0.1 at rest and 0.2 in motion
     --> scene.toml:4:37
      |
    4 | hinge = { type = "free", friction = { stick = 0.1, slide = 0.2 } }
      |                                     ^^^^^^^^^^^^^^^^^^^^^^^^^^^^
      |
      = help: allowed: 0 ≤ `slide` ≤ `stick`, finite

    scene.toml: 1 error
    "#);
}

#[test]
fn a_syntax_error() {
    let text = r#"
[[body]]
name = "bob
mass = = 1.0
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: not valid TOML: invalid basic string, expected `"`
     --> scene.toml:2:12
      |
    2 | name = "bob
      |            ^

    error: not valid TOML: extra `=`
     --> scene.toml:3:8
      |
    3 | mass = = 1.0
      |        ^

    error: not valid TOML: unexpected key or value, expected newline, `#`
     --> scene.toml:3:10
      |
    3 | mass = = 1.0
      |          ^

    scene.toml: 3 errors
    "#);
}

#[test]
fn a_key_given_twice() {
    let text = r#"
[[body]]
name = "bob"
mass = 1.0
mass = 2.0
hinge = { type = "free" }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: `mass` is given twice
     --> scene.toml:4:1
      |
    4 | mass = 2.0
      | ^^^^
      |
      = help: keep one of the two

    scene.toml: 1 error
    "#);
}

#[test]
fn a_body_without_a_name_but_not_that_others_miss_it() {
    let text = r#"
[[body]]
mass = 1.0
hinge = { type = "free" }

[[body]]
name = "tip"
mass = 1.0
hinge = { type = "fixed", parent = "arm" }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: body[0]: `name` is missing
     --> scene.toml:1:1
      |
    1 | [[body]]
      | ^^^^^^^^
      |
      = help: for example `name = "upper"`

    scene.toml: 1 error
    "#);
}

#[test]
fn an_empty_file() {
    let text = "";
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: the scene has no bodies
    --> scene.toml
     = help: add at least one [[body]]

    scene.toml: 1 error
    "#);
}

#[test]
fn overrides() {
    let text = r#"
[[body]]
name = "bob"
mass = 1.0
hinge = { type = "free" }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &["bob.mass=-1", "bob.hinge.type=spinning", "bbo.mass=2", "bob.mas=2", "statics.want=some"]), @r#"
    error: body `bob`: `mass` is -1, allowed: ≥ 0 kg
     --> command line:1:16
      |
    1 | --set bob.mass=-1
      |                ^^

    error: hinge of body `bob`: unknown hinge type `spinning`
     --> command line:1:22
      |
    1 | --set bob.hinge.type=spinning
      |                      ^^^^^^^^
      |
      = help: `type` is one of `fixed`, `revolute`, `prismatic`, `screw`, `along`, `cylindrical`, `universal`, `planar`, `spherical`, `free`

    error: nothing is called `bbo`
     --> command line:1:7
      |
    1 | --set bbo.mass=2
      |       ^^^^^^^^
      |
      = help: did you mean `bob`?

    error: `bob.mas`: unknown key `mas`
     --> command line:1:7
      |
    1 | --set bob.mas=2
      |       ^^^^^^^
      |
      = help: did you mean `mass`?

    error: [statics]: `want` does not know `some`
     --> command line:1:20
      |
    1 | --set statics.want=some
      |                    ^^^^
      |
      = help: one of `stable`, `any`

    scene.toml: 5 errors
    "#);
}

#[test]
fn nesting_that_is_too_deep() {
    let text = said(&format!("a = {}", "[".repeat(100_000)), &[]);
    assert!(text.starts_with("error: values are nested too deeply: the most is 80 levels\n --> scene.toml:1:85\n"));
    assert!(text.ends_with("scene.toml: 1 error"));
}

#[test]
fn many_errors_are_counted_and_the_first_ones_shown() {
    let text = said(&"[[body]]\nname = 1\nhinge = { type = \"free\" }\n".repeat(200), &[]);
    assert_eq!(text.matches("error: body[").count(), scenario::diagnostic::MOST_PRINTED);
    assert!(text.ends_with("and 150 more\nscene.toml: 200 errors"));
}

#[test]
fn color_is_only_there_when_it_is_asked_for() {
    let diagnostics = scenario::parse("scene.toml", "", &[]).expect_err("no bodies");
    assert!(!diagnostics.render(false).contains('\x1b'));
    assert!(diagnostics.render(true).contains('\x1b'));
}

#[test]
fn a_stop_is_rigid_or_compliant_and_on_a_coordinate_that_has_a_size() {
    let text = r#"
[[body]]
name = "bob"
mass = 1.0
hinge = { type = "prismatic", axis = [0, 0, 1], limits = { low = 0, stiffness = 5.0, restitution = 0.5 } }

[[body]]
name = "ball"
mass = 1.0
hinge = { type = "spherical", limits = [-1, 1] }

[[event]]
hinge = "bobb"
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: hinge of body `bob`: a stop with `stiffness` has no `restitution`
     --> scene.toml:4:86
      |
    4 | hinge = { type = "prismatic", axis = [0, 0, 1], limits = { low = 0, stiffness = 5.0, restitution = 0.5 } }
      |                                                                                      ^^^^^^^^^^^
      |
      = help: a stop is rigid, with `restitution`, or compliant, with `stiffness` and `damping`

    error: the spherical hinge of `ball` has no coordinate 0 that can be limited
     --> scene.toml:9:40
      |
    9 | hinge = { type = "spherical", limits = [-1, 1] }
      |                                        ^^^^^^^
      |
      = help: angles and distances can; the numbers of a quaternion cannot

    error: there is no body `bobb`
      --> scene.toml:12:9
       |
    12 | hinge = "bobb"
       |         ^^^^^^
       |
       = help: did you mean `bob`?

    scene.toml: 3 errors
    "#);
}

/// Where it belongs is said, not only what a shape has.
#[test]
fn a_density_in_a_shape() {
    let text = "[[body]]\nname = \"bob\"\nshape = { sphere = 0.1, density = 7.0 }\nhinge = { type = \"free\" }\n";
    assert!(said(text, &[]).contains("shape of body `bob`: `density` stands beside `shape`, in the body"));
}

/// One mistake, one error; and a lock that a rigid stop forbids.
#[test]
fn limits_that_limit_nothing_and_locks_beyond_them() {
    let text = r#"
[[body]]
name = "arm"
mass = 1.0
hinge = { type = "prismatic", axis = [0, 0, 1], limits = { lower = -1, stiffness = 3 } }

[[body]]
name = "tray"
mass = 1.0
hinge = { type = "prismatic", axis = [0, 0, 1], lock = true, position = 0.3, limits = [-0.1, 0.1] }

[[body]]
name = "pad"
mass = 1.0
hinge = { type = "prismatic", axis = [0, 0, 1], lock = true, position = 0.3, limits = { low = -0.1, high = 0.1, stiffness = 1e4 } }
"#
    .trim_start();
    insta::assert_snapshot!(said(text, &[]), @r#"
    error: hinge of body `arm`: `limits` without `low` and `high` limit nothing
     --> scene.toml:4:58
      |
    4 | hinge = { type = "prismatic", axis = [0, 0, 1], limits = { lower = -1, stiffness = 3 } }
      |                                                          ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^

    error: limits of hinge of body `arm`: unknown key `lower`
     --> scene.toml:4:60
      |
    4 | hinge = { type = "prismatic", axis = [0, 0, 1], limits = { lower = -1, stiffness = 3 } }
      |                                                            ^^^^^
      |
      = help: allowed: `low`, `high`, `coordinate`, `restitution`, `stiffness`, `damping`

    error: `tray` is locked at 0.3, beyond its limits from -0.1 to 0.1
     --> scene.toml:9:87
      |
    9 | hinge = { type = "prismatic", axis = [0, 0, 1], lock = true, position = 0.3, limits = [-0.1, 0.1] }
      |                                                                                       ^^^^^^^^^^^
      |
      = help: take off the lock, move the position or the limits, or give the stop a `stiffness`

    scene.toml: 3 errors
    "#);
}

#[test]
fn keys_of_inner_tables_say_where_they_belong() {
    let text = "[[body]]\nname = \"arm\"\nmass = 1.0\nparent = \"base\"\nhinge = { type = \"fixed\" }\n";
    let told = stillpoint::scenario::parse("s.toml", text, &[]).expect_err("a problem").render(false);
    assert!(told.contains("unknown key `parent`") && told.contains("`hinge = { parent = … }`"), "{told}");
}

/// A scene of one body, with this position.
fn at(position: &str) -> String {
    let hinge = format!("hinge = {{ type = \"prismatic\", axis = [0, 0, 1], position = {position} }}");
    format!("[[body]]\nname = \"a\"\nmass = 1.0\n{hinge}\n")
}

#[test]
fn a_number_without_a_digit_before_its_point_is_given_one() {
    let said = said(&at("1.0"), &["simulate.duration=.5"]);
    assert!(said.contains("`.5` needs a digit on both sides of its point"), "{said}");
    assert!(said.contains("write `0.5`, or `\"0.5 s\"`"), "{said}");
}

#[test]
fn a_table_beside_a_list_of_tables_gets_double_brackets() {
    let both = at("1.0").replace("[[body]]", "[body]") + &at("2.0").replace("\"a\"", "\"b\"");
    let said = said(&both, &[]);
    assert!(said.contains("write `[[body]]` in both places"), "{said}");
}

#[test]
fn a_single_table_in_place_of_a_list_gets_double_brackets() {
    let said = said(&at("1.0").replace("[[body]]", "[body]"), &[]);
    assert!(said.contains("write `[[body]]` in place of `[body]`"), "{said}");
}

#[test]
fn a_plural_is_taken_for_its_singular() {
    let said = said(&at("1.0").replace("[[body]]", "[[bodies]]"), &[]);
    assert!(said.contains("did you mean `body`?"), "{said}");
}

#[test]
fn constants_in_texts_are_explained() {
    let braces = said(&at("\"{pi}/2\""), &[]);
    assert!(braces.contains("`pi` is a constant") && braces.contains("write `pi` without braces"), "{braces}");
    let plain = said(&at("\"pi/2\""), &[]);
    assert!(plain.contains("write 1.5707963267948966"), "{plain}");
}

/// A run that begins as given begins within its rigid limits: what does not is said where the position is written, of a body, of a copy, and of
/// what a drive puts there; of compliant stops, and of a guess that statics moves, nothing.
#[test]
fn a_start_beyond_a_rigid_limit_is_told_at_its_position() {
    let scene = |start: &str, hinge: &str| {
        format!(
            "[simulate]\nstart = \"{start}\"\n[[body]]\nname = \"b\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], {hinge} }}\n"
        )
    };
    insta::assert_snapshot!(said(&scene("given", "position = 2.0, limits = [-1.0, 1.0]"), &[]), @r#"
    error: the hinge of `b` starts at 2, beyond its limits -1 to 1
     --> scene.toml:7:59
      |
    7 | hinge = { type = "revolute", axis = [0, 1, 0], position = 2.0, limits = [-1.0, 1.0] }
      |                                                           ^^^
      |
      = help: rigid limits are walls: begin the run within them, widen `limits`, or give the stop a `stiffness`

    scene.toml: 1 error
    "#);
    let copies = scene("given", "position = [0.1, 3.0], limits = [-1.0, 1.0]").replace("mass =", "repeat = 2\nmass =");
    let of_copy = said(&copies, &[]);
    assert!(of_copy.contains("`b[1]` starts at 3") && of_copy.contains("scene.toml:8:65"), "{of_copy}");
    let two = "[simulate]\nstart = \"given\"\n[[body]]\nname = \"b\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
               hinge = { type = \"cylindrical\", axis = [0, 1, 0], position = [0.0, 3.0], limits = { coordinate = 1, low = -1, high = 1 } }\n";
    let of_second = said(two, &[]);
    assert!(of_second.contains("`b` starts at 3") && of_second.contains("scene.toml:7:68"), "{of_second}");
    let drive = "[[drive]]\nhinge = \"b\"\ntype = \"sine\"\noffset = 2.0\namplitude = 0.1\nfrequency = 1.0\n";
    let driven = said(&(scene("given", "limits = [-1.0, 1.0]") + drive), &[]);
    assert!(driven.contains("`b` starts at 2"), "{driven}");
    let compliant = "position = 2.0, limits = { low = -1.0, high = 1.0, stiffness = 100.0 }";
    assert_eq!(said(&scene("given", compliant), &[]), "nothing");
    assert_eq!(said(&scene("equilibrium", "position = 2.0, limits = [-1.0, 1.0]"), &[]), "nothing");
}

/// A mesh that touches and is not there is said once, where it is named.
#[test]
fn a_missing_mesh_that_touches_is_told_once() {
    let scene = |shape: &str| {
        format!(
            "[[body]]\nname = \"floor\"\nshape = {{ plane = [0, 0, 1] }}\nhinge = {{ type = \"fixed\" }}\n[[body]]\nname = \"b\"\nmass = 1.0\n\
             inertia = [0.1, 0.1, 0.1]\nshape = {shape}\nhinge = {{ type = \"free\" }}\n[[contact]]\nbetween = [\"b\", \"floor\"]\n"
        )
    };
    for (shape, column) in [
        ("{ mesh = \"gone.stl\" }", 18),
        ("[{ mesh = \"gone.stl\" }]", 19),
        ("[{ sphere = 0.1 }, { mesh = \"gone.stl\" }]", 37),
    ] {
        let text = said(&scene(shape), &[]);
        assert_eq!(text.matches("gone.stl`").count(), 1, "{text}");
        assert!(text.contains(&format!("scene.toml:9:{column}")) && text.contains("contact[0]"), "{text}");
        assert!(!text.contains("hull") && text.contains("1 error") && !text.contains("warning"), "{text}");
    }
}

/// An element that cannot be read is not missed by those that name it.
#[test]
fn what_names_a_broken_element_is_not_told() {
    let body = "[[body]]\nname = \"b\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\nhinge = { type = \"revolute\", axis = [0, 1, 0] }\n";
    let stage = "[[stage]]\nname = \"s\"\nwhen = { time = 0.1 }\nopen = [\"d\"]\n";
    let drive = |keys: &str| format!("{body}[[drive]]\nname = \"d\"\nhinge = \"b\"\ntype = \"ramp\"\n{keys}{stage}");
    assert_eq!(said(&drive("to = 1.0\nduration = 1.0\n"), &[]), "nothing");
    let broken = said(&drive("to = 1.0\n"), &[]);
    assert!(broken.contains("`duration` is missing") && broken.contains("1 error"), "{broken}");
    let output =
        "[[output]]\nname = \"o\"\ntype = \"distance\"\n[[event]]\nname = \"e\"\noutput = \"o\"\nvalue = 1.0\n";
    let broken = said(&format!("{body}{output}"), &[]);
    assert!(broken.contains("two points are given by") && broken.contains("1 error"), "{broken}");
    // What is there under no name is.
    let other = said(&(body.to_owned() + stage), &[]);
    assert!(other.contains("there is no hinge") && other.contains("`d`"), "{other}");
}

/// The parameter of a gap is a number that can be read.
#[test]
fn a_gap_at_zero_is_told_at_zero() {
    let text = said(
        "[[body]]\nname = \"b\"\nmass = 1.0\ninertia = [0.1, 0.1, 0.1]\n\
         hinge = { type = \"along\", position = 0.1, curve = { parameter = \"u\", x = \"u\", z = \"floor(u)\", range = [-1.0, 1.0] } }\n",
        &[],
    );
    assert!(text.contains("has a gap at parameter 0.0\n"), "{text}");
}
