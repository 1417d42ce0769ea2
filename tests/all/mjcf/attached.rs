//! Models within models, and files within files.

use std::fs;
use std::path::Path;
use stillpoint::import::{Imported, Options, Refused, import};
use stillpoint::scenario::{Scenario, parse};

/// A folder with files in it.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, &str)]) -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder"));
        for (name, text) in files {
            let path = folder.0.path().join(name);
            fs::create_dir_all(path.parent().unwrap_or(Path::new(""))).expect("a folder");
            fs::write(path, text).expect("a file");
        }
        folder
    }

    fn import(&self, key: Option<&str>) -> Result<Imported, Refused> {
        let options = Options { key: key.map(str::to_owned), ..Options::default() };
        import(&self.0.path().join("main.xml"), &options)
    }

    fn scenario(&self, key: Option<&str>) -> Scenario {
        let imported = self.import(key).unwrap_or_else(|refused| panic!("{refused}"));
        parse("main.toml", &imported.scenario, &[]).unwrap_or_else(|error| panic!("{error}"))
    }
}

const PART: &str = r#"<mujoco model="part"><compiler angle="radian"/><default><geom density="500"/></default>
<worldbody><body name="p"><joint name="j" axis="0 1 0" range="-1 1"/><geom size=".1" pos="0 0 .3"/>
<body name="q" pos="0 0 .5" euler="0 0.5 0"><joint name="k" axis="0 1 0"/><geom size=".1" pos="0 0 .3"/></body></body></worldbody>
<actuator><motor joint="j" gear="2"/><motor joint="k"/></actuator>
<keyframe><key name="home" qpos=".1 .2" ctrl="3 4"/></keyframe></mujoco>"#;

const MAIN: &str = r#"<mujoco><asset><model name="part" file="part.xml"/></asset><worldbody><body name="w">
<joint name="a" axis="0 1 0"/><geom size=".1" pos="0 0 .3"/><frame pos="0 0 1"><attach model="part" body="p" prefix="x_"/></frame>
<frame pos="0 1 0"><attach model="part" body="q" prefix="y_"/></frame></body></worldbody>
<actuator><motor joint="x_k" gear="10"/></actuator></mujoco>"#;

#[test]
fn what_is_attached_keeps_its_own_settings_and_names() {
    let scenario = Folder::new(&[("part.xml", PART), ("main.xml", MAIN)]).scenario(Some("x_home"));
    let bodies = &scenario.description.bodies;
    let names: Vec<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["w", "x_p", "x_q", "y_q"]);
    let hinge = |name: &str| &bodies.iter().find(|body| body.name == name).expect(name).hinge;
    assert_eq!((hinge("x_p").position[0], hinge("x_q").position[0]), (0.1, 0.2));
    assert!(hinge("w").position.iter().chain(&hinge("y_q").position).all(|position| *position == 0.0));
    // Its angles are radians, those of the main model degrees.
    assert_eq!((hinge("x_p").limits[0].low, hinge("x_p").limits[0].high), (-1.0, 1.0));
    assert!((hinge("x_q").frame.euler_angles().1 - 0.5).abs() < 1e-14);
    // Controls of its key: 3 · 2 and 4; those of the main model are zero then.
    assert_eq!((hinge("x_p").force[0], hinge("x_q").force[0]), (6.0, 4.0));
    // Half as dense.
    let ratio = bodies[0].mass.mass / bodies[1].mass.mass;
    assert!((ratio - 2.0).abs() < 1e-14, "{ratio}");
}

#[test]
fn what_is_not_attached_is_not_referred_to_in_silence() {
    let imported = Folder::new(&[("part.xml", PART), ("main.xml", MAIN)]).import(None).expect("a model");
    let said: Vec<&str> = imported.notes.iter().map(|note| note.what.as_str()).collect();
    assert!(said.iter().any(|what| what.starts_with("the joint `j` of its model is not attached")), "{said:#?}");
}

#[test]
fn mistakes_in_what_is_attached_are_told() {
    let main = |attach: &str| MAIN.replace(r#"<attach model="part" body="p" prefix="x_"/>"#, attach);
    for (attach, expected) in [
        (
            r#"<attach model="prt" prefix="x_"/>"#,
            "`model` is \"prt\": there is no such model in <asset> (did you mean `part`?)",
        ),
        (r#"<attach model="part" body="z" prefix="x_"/>"#, "`body` is \"z\": there is no such body in the model"),
        (r#"<attach model="part" body="p"/>"#, "`prefix` is missing"),
        (r#"<attach prefix="x_"/>"#, "it names neither a model nor a body or frame of this one"),
        (r#"<attach body="w" prefix="x_"/>"#, "with what is attached, elements are deeper than 300 levels"),
        (r#"<attach model="part" body="q" prefix="y_"/>"#, "two bodies are called `y_q`"),
    ] {
        let folder = Folder::new(&[("part.xml", PART), ("main.xml", &main(attach))]);
        let refused = folder.import(None).map(|imported| imported.scenario).expect_err(attach).to_string();
        assert!(refused.contains(expected), "{refused}");
    }
    let circle = r#"<mujoco><asset><model name="a" file="main.xml"/></asset></mujoco>"#;
    let refused = Folder::new(&[("main.xml", circle)]).import(None).expect_err("a circle").to_string();
    assert!(refused.contains("which this model is part of"), "{refused}");
    let missing = Folder::new(&[("main.xml", MAIN)]).import(None).expect_err("no file").to_string();
    assert!(missing.contains("`file` cannot be read: no model"), "{missing}");
}

/// From the folder of the main model first, then from that of the file.
#[test]
fn files_are_found_from_the_main_folder_and_from_their_own() {
    let leaf = |radius: &str| format!("<mujocoinclude><geom size=\"{radius}\"/></mujocoinclude>");
    let middle = "<mujocoinclude><include file=\"leaf.xml\"/></mujocoinclude>";
    let main = "<mujoco><worldbody><body><joint/><include file=\"sub/middle.xml\"/></body></worldbody></mujoco>";
    let mass = |files: &[(&str, &str)]| Folder::new(files).scenario(None).description.bodies[0].mass.mass;
    let (large, small) = (leaf("0.2"), leaf("0.1"));
    let near = mass(&[("main.xml", main), ("sub/middle.xml", middle), ("sub/leaf.xml", &small)]);
    let both = mass(&[("main.xml", main), ("sub/middle.xml", middle), ("sub/leaf.xml", &small), ("leaf.xml", &large)]);
    assert!((both / near - 8.0).abs() < 1e-12, "{both} {near}");
}
