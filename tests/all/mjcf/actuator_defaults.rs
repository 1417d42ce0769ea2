//! Defaults of actuators: all tags share one default per class, and read from each other as MuJoCo's do.

use super::{import, scenario};
use stillpoint::dynamics::System;
use stillpoint::model::Model;

/// Defaults, an actuator, and what MuJoCo 4.0.0 compiled of them: the first three numbers of `actuator_gainprm` and of
/// `actuator_biasprm`, the first of `actuator_gear`, and `qacc` in the keyframe of [`model`].
type Case = (&'static str, &'static str, ([f64; 3], [f64; 3], f64), f64);

const CASES: [Case; 19] = [
    (
        r#"<general gear="3" gainprm="4" biastype="affine" biasprm="0 -2 -1"/>"#,
        r#"<position joint="j"/>"#,
        ([4.0, 0.0, 0.0], [0.0, -4.0, -1.0], 3.0),
        -5.448990343195633,
    ),
    (
        r#"<general gear="3" gainprm="4" biastype="affine" biasprm="0 -2 -1"/>"#,
        r#"<position joint="j" kp="5"/>"#,
        ([5.0, 0.0, 0.0], [0.0, -5.0, -1.0], 3.0),
        -10.020462112856467,
    ),
    (
        r#"<general gear="3" gainprm="4" biastype="affine" biasprm="0 -2 -1"/>"#,
        r#"<velocity joint="j"/>"#,
        ([4.0, 0.0, 0.0], [0.0, 0.0, -4.0], 3.0),
        -16.877669767347673,
    ),
    (
        r#"<general gear="3" gainprm="4" biastype="affine" biasprm="0 -2 -1"/>"#,
        r#"<motor joint="j"/>"#,
        ([1.0, 0.0, 0.0], [0.0, 0.0, 0.0], 3.0),
        33.40851969892137,
    ),
    (
        r#"<general gear="3" gainprm="4" biastype="affine" biasprm="0 -2 -1"/>"#,
        r#"<intvelocity joint="j" kv="2"/>"#,
        ([4.0, 0.0, 0.0], [0.0, -4.0, -2.0], 3.0),
        -32.115908999550435,
    ),
    (
        r#"<general biastype="affine" biasprm="0 -2 -1"/><position kp="7"/>"#,
        r#"<general joint="j"/>"#,
        ([7.0, 0.0, 0.0], [0.0, -7.0, -1.0], 1.0),
        30.61484250635086,
    ),
    (r#"<velocity kv="5"/>"#, r#"<position joint="j"/>"#, ([1.0, 0.0, 0.0], [0.0, -1.0, 0.0], 1.0), 29.344989237000632),
    (
        r#"<position kp="7" kv="3"/><general gear="2"/>"#,
        r#"<velocity joint="j"/>"#,
        ([7.0, 0.0, 0.0], [0.0, 0.0, -7.0], 2.0),
        0.392334695815425,
    ),
    (
        r#"<velocity kv="5" gear="2"/>"#,
        r#"<general joint="j" biasprm="0.5 -6"/>"#,
        ([5.0, 0.0, 0.0], [0.5, -6.0, -5.0], 2.0),
        -13.322080613167055,
    ),
    (
        r#"<general gainprm="4" biastype="affine" biasprm="0 -3 -1"/><velocity/>"#,
        r#"<position joint="j" gear="2"/>"#,
        ([1.0, 0.0, 0.0], [0.0, -1.0, 0.0], 2.0),
        27.82116531378036,
    ),
    (
        r#"<position kp="7" kv="3"/><default class="c"><velocity kv="2"/></default>"#,
        r#"<position joint="j" class="c"/>"#,
        ([7.0, 0.0, 0.0], [0.0, -7.0, -3.0], 1.0),
        27.059253352170224,
    ),
    (
        r#"<position kp="7" kv="3"/><default class="c"><velocity kv="2"/></default>"#,
        r#"<general joint="j" class="c"/>"#,
        ([2.0, 0.0, 0.0], [0.0, 0.0, -2.0], 1.0),
        28.329106621520452,
    ),
    (
        r#"<general gear="3" gainprm="4" biastype="affine" biasprm="0 -2 -1"/><default class="c"><velocity kv="2"/><default class="d"><intvelocity kv="5"/></default></default>"#,
        r#"<position joint="j" class="d"/>"#,
        ([4.0, 0.0, 0.0], [0.0, -4.0, -1.0], 3.0),
        -5.448990343195633,
    ),
    (
        r#"<position kp="7" kv="3"/><default class="c"><general gaintype="affine" gainprm="1 2 -3"/></default>"#,
        r#"<damper joint="j" class="c" ctrlrange="0 0.5"/>"#,
        ([0.0, 0.0, -3.0], [0.0, 0.0, 0.0], 1.0),
        26.17035606362506,
    ),
    (
        r#"<cylinder area="3" bias="1 -2 -3"/>"#,
        r#"<general joint="j"/>"#,
        ([3.0, 0.0, 0.0], [1.0, -2.0, -3.0], 1.0),
        28.583077275390497,
    ),
    (
        r#"<position kp="7" dampratio="1"/>"#,
        r#"<position joint="j" kv="2"/>"#,
        ([7.0, 0.0, 0.0], [0.0, -7.0, -2.0], 1.0),
        28.837047929260542,
    ),
    (
        r#"<position kp="7" dampratio="1"/>"#,
        r#"<general joint="j"/>"#,
        ([7.0, 0.0, 0.0], [0.0, -7.0, -3.3203758550799307], 1.0),
        26.489690894378448,
    ),
    (
        r#"<general gainprm="4" biastype="affine" biasprm="0 -4 0.5"/>"#,
        r#"<general joint="j" gear="2"/>"#,
        ([4.0, 0.0, 0.0], [0.0, -4.0, -0.6274920551289241], 2.0),
        20.311309576237964,
    ),
    (
        r#"<general gear="3" gainprm="4" biastype="affine" biasprm="0 -2 -1"/><default class="c"><damper kv="2" ctrlrange="0 0.5"/></default>"#,
        r#"<damper joint="j" class="c" gear="2"/>"#,
        ([0.0, 0.0, -2.0], [0.0, 0.0, 0.0], 2.0),
        21.72586962089926,
    ),
];

/// An arm with one actuator. The activation is that of the control for a filter, which acts at once here, and another one for
/// an integrator.
fn model(defaults: &str, actuator: &str) -> String {
    let activation = match actuator {
        _ if defaults.contains("<cylinder") => r#" act="0.6""#,
        _ if actuator.contains("<intvelocity") => r#" act="0.25""#,
        _ => "",
    };
    format!(
        r#"<mujoco><default>{defaults}</default><worldbody><body name="a"><joint name="j" axis="0 1 0"/>
<geom size="0.1" pos="0.3 0 0"/></body></worldbody><actuator>{actuator}</actuator>
<keyframe><key qpos="0.4" qvel="0.7" ctrl="0.6"{activation}/></keyframe></mujoco>"#
    )
}

/// The hinge has the stiffness and the damping of the servo that MuJoCo compiles, and the arm moves as there.
#[test]
fn actuators_start_from_the_one_default_of_their_class() {
    for (defaults, actuator, (gain, bias, gear), expected) in CASES {
        let scenario = scenario(&model(defaults, actuator));
        let case = format!("{defaults} {actuator}");
        // An affine gain counts with its control, here at the end of a range from 0 to 0.5.
        let control = if gain[1..] == [0.0; 2] { 0.0 } else { 0.5 };
        let factor = |index: usize| -gear * gear * (gain[index] * control + bias[index]);
        let hinge = &scenario.description.bodies[0].hinge;
        let near = |found: f64, wanted: f64| {
            assert!((found - wanted).abs() <= 1e-12 * wanted.abs(), "{case}: {found} {wanted}")
        };
        // What is zero is not written.
        let written = |list: &[f64]| list.first().copied().unwrap_or(0.0);
        near(written(&hinge.stiffness), factor(1));
        near(written(&hinge.damping), factor(2));
        let model = Model::build(&scenario.description).expect("a model");
        let mut accelerations = [0.0_f64];
        System::new(&model)
            .at(0.0, &model.start_position, &model.start_velocity)
            .accelerations(&mut accelerations)
            .expect("accelerations");
        // Round-off of a few sums, of which the parts are up to ten times as large.
        assert!((accelerations[0] - expected).abs() < 1e-12 * 40.0, "{case}: {} {expected}", accelerations[0]);
    }
}

/// What a muscle leaves in a default has no equal, also where another tag takes it over: that is said.
#[test]
fn a_default_without_an_equal_is_said() {
    for (defaults, actuator) in [
        (r#"<muscle force="2"/>"#, r#"<general joint="j"/>"#),
        (r#"<muscle force="2"/><general gaintype="fixed"/>"#, r#"<position joint="j"/>"#),
    ] {
        let imported = import(&model(defaults, actuator)).unwrap_or_else(|refused| panic!("{refused}"));
        let said = imported.notes.iter().any(|note| note.what == "a muscle has no equal here: nothing acts");
        assert!(said, "{actuator}: {:?}", imported.notes);
    }
    // A shortcut that cannot read it starts anew, as in MuJoCo.
    let found = scenario(&model(r#"<muscle force="2"/>"#, r#"<position joint="j"/>"#));
    assert_eq!(found.description.bodies[0].hinge.stiffness[0], 1.0);
}
