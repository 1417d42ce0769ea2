//! Nothing is dropped in silence.

use super::{import, world};
use stillpoint::import::Taken;

/// What is said of a model: line, element, verdict and text.
fn said(text: &str) -> Vec<String> {
    let imported = import(text).unwrap_or_else(|refused| panic!("{refused}"));
    let note = |note: &stillpoint::import::Note| {
        format!("{} {} {}: {}", note.line, note.verdict.word(), note.element, note.what)
    };
    imported.notes.iter().map(note).collect()
}

#[test]
fn what_has_no_equal_is_listed_with_its_line() {
    let model = r#"<mujoco>
<option timestep="0.002" density="1.2"/>
<worldbody>
<light pos="0 0 3"/>
<geom type="plane" size="1 1 1"/>
<body name="a">
<joint name="j" axis="0 1 0" frictionloss="0.3" range="-90 90" solreflimit="0.01 1"/>
<joint name="k" axis="1 0 0" stiffness="1 0.5" range="-10 10"/>
<geom type="ellipsoid" size="0.1 0.2 0.3" friction="1 1 1" condim="4"/>
<camera name="eye"/>
<flexcomp name="cloth"/>
<geom size="0.1" colour="red"/>
</body>
</worldbody>
<contact><exclude body1="a" body2="world"/></contact>
<actuator>
<motor joint="j"/>
<motor joint="k"/>
<muscle joint="j"/>
</actuator>
<sensor><jointpos joint="j"/></sensor>
<novelty/>
</mujoco>"#;
    let expected = [
        "2 ignored <option>: `density = \"1.2\"`: nothing here moves in a fluid",
        "2 ignored <option>: `timestep = \"0.002\"`: `[simulate]` has its own integrator and tolerance",
        "4 ignored <light>: the viewer has its own",
        "5 ignored <geom> of <worldbody>: a plane is there for contacts, which are not imported without `contact = true`; it is not drawn",
        "7 approximated joint `j`: its limits and those of another joint are soft there and rigid stops here",
        "7 ignored joint: `solreflimit`: stops and dry friction are rigid",
        "8 approximated joint `k`: `stiffness`: only its linear part 1 is taken",
        "9 approximated <geom> of body `a`: an ellipsoid is drawn as the box around it; it weighs what it weighs",
        "9 ignored geom: `condim`, `friction`: 2 times: contacts are imported with `contact = true`, and then rigid; fluids are not simulated, constraints are exact",
        "10 ignored <camera>: the viewer has its own",
        "11 ignored <flexcomp>: bodies that bend are not imported: describe slender ones with `[[beam]]`; what it would make is missing",
        "12 ignored <geom> of body `a`: `colour = \"red\"` is not known here",
        "15 ignored <contact>: contacts are not imported without `[model] contact = true` or `convert --contact`",
        "17 used <motor> of <actuator>: nothing acts: its input is 0 (and so line 18)",
        "19 ignored <muscle> of <actuator>: a muscle has no equal here: nothing acts",
        "21 ignored <sensor>: there are no sensors: a recording has positions, velocities, accelerations and reactions",
        "22 ignored <novelty>: not known here, nor is anything within it",
    ];
    let found = said(model);
    for line in expected {
        assert!(found.iter().any(|note| note == line), "missing: {line}\n{}", found.join("\n"));
    }
    assert_eq!(found.len(), expected.len(), "{}", found.join("\n"));
}

#[test]
fn a_model_that_is_taken_as_it_stands_says_nothing() {
    let model = world(
        r#"<body name="a" pos="0 0 1"><joint name="j" axis="0 1 0" damping="0.1" armature="0.01" stiffness="2" springref="10"/>
           <geom type="capsule" fromto="0 0 0 1 0 0" size="0.05" rgba="1 0 0 1"/><site name="tip" pos="1 0 0"/></body>"#,
    );
    assert_eq!(said(&model), Vec::<String>::new());
}

#[test]
fn what_is_left_out_by_the_model_itself_is_left_out_here() {
    let model = r#"<mujoco><option><flag gravity="disable" spring="disable"/></option><worldbody>
        <body name="a"><joint axis="0 1 0" stiffness="5"/><geom size="0.1"/></body></worldbody></mujoco>"#;
    let imported = import(model).expect("a model");
    assert!(imported.notes.iter().all(|note| note.verdict == Taken::Used), "{:?}", imported.notes);
    assert!(imported.scenario.contains("gravity = [0.0, 0.0, 0.0]") && !imported.scenario.contains("stiffness"));
}

/// `mj_passive` computes nothing if springs and dampers are both switched off: a body with `gravcomp` falls then (MuJoCo 4.0).
#[test]
fn passive_forces_are_left_out_together_where_springs_and_dampers_are() {
    for (flags, acts) in [
        ("", true),
        (r#"spring="disable""#, true),
        (r#"damper="disable""#, true),
        (r#"spring="disable" damper="disable""#, false),
        (r#"passive="disable""#, false),
    ] {
        let model = format!(
            r#"<mujoco><option gravity="0 0 -10"><flag {flags}/></option><worldbody><body name="a" gravcomp="1">
            <joint type="slide" axis="0 0 1"/><geom size="0.1" mass="1"/></body></worldbody></mujoco>"#
        );
        let imported = import(&model).expect("a model");
        assert_eq!(imported.scenario.contains("gravcomp of a"), acts, "{flags}: {}", imported.scenario);
        let is_told = said(&model).iter().any(|note| note.contains("`gravcomp` does not act"));
        assert_eq!(is_told, !acts, "{flags}: {:?}", said(&model));
    }
}
