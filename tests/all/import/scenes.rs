//! Models within scenarios: merged, named, moved, and problems told at their place.

use super::fixture::{joint, link, robot};
use stillpoint::scenario::{Override, load_with};

struct Folder(tempfile::TempDir);

impl Folder {
    fn new(robot: &str, scenario: &str) -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder"));
        std::fs::create_dir(folder.0.path().join("robots")).expect("a folder");
        std::fs::write(folder.0.path().join("robots/r.urdf"), robot).expect("a file");
        std::fs::write(folder.0.path().join("scene.toml"), scenario).expect("a file");
        folder
    }

    fn said(&self, changes: &[&str]) -> String {
        let changes: Vec<Override> = changes.iter().map(|text| Override::parse(text).expect("a change")).collect();
        let text = match load_with(&self.0.path().join("scene.toml"), &changes) {
            Ok(_) => "nothing".to_owned(),
            Err(error) => error.to_string(),
        };
        text.replace(&format!("{}/", self.0.path().display()), "")
    }

    fn loaded(&self, changes: &[&str]) -> stillpoint::scenario::Scenario {
        let changes: Vec<Override> = changes.iter().map(|text| Override::parse(text).expect("a change")).collect();
        load_with(&self.0.path().join("scene.toml"), &changes).unwrap_or_else(|error| panic!("{error}"))
    }
}

fn two_links() -> String {
    let turn = "<origin xyz=\"0 0 -1\"/><axis xyz=\"0 1 0\"/>";
    robot(&format!(
        "{}{}{}{}",
        link("upper"),
        joint("shoulder", "continuous", ["base", "upper"], turn),
        link("lower"),
        joint("elbow", "continuous", ["upper", "lower"], turn)
    ))
}

#[test]
fn a_string_is_enough_and_hinges_are_set_by_body() {
    let folder = Folder::new(&two_links(), "model = \"robots/r.urdf\"\n");
    let scenario = folder.loaded(&["lower.position=0.7", "hinge.damping=0.5"]);
    let names: Vec<&str> = scenario.description.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["base", "upper", "lower"]);
    assert_eq!(scenario.description.bodies[2].hinge.position, [0.7]);
    assert!(scenario.description.bodies[1..].iter().all(|body| body.hinge.damping == [0.5]));
    assert_eq!(scenario.models[0].joints[1], ("elbow".to_owned(), "lower".to_owned()));
    let free = folder.loaded(&["model.base=free", "model.at=[0,0,3]"]);
    assert_eq!(free.description.bodies[0].hinge.kind.name(), "free");
}

#[test]
fn positions_and_hinges_are_given_by_joint_or_body() {
    let scene = r#"
[[model]]
file = "robots/r.urdf"
prefix = "left/"
positions = { elbow = 0.3 }
hinges = { "*" = { stiffness = 4.0 }, upper = { stiffness = 7.0, rest = 0.1 } }

[[model]]
file = "robots/r.urdf"
prefix = "right/"
positions = { "right/lower" = -0.3 }
at = [1.0, 0.0, 0.0]

[[body]]
name = "tool"
mass = 1.0
hinge = { type = "fixed", parent = "left/lower" }

[[force]]
type = "spring"
between = ["left/lower", "right/lower"]
stiffness = 1.0
length = 0.0
"#;
    let scenario = Folder::new(&two_links(), scene).loaded(&[]);
    let body = |name: &str| scenario.description.bodies.iter().find(|body| body.name == name).expect(name);
    assert_eq!(body("left/lower").hinge.position, [0.3]);
    assert_eq!((&body("left/lower").hinge.stiffness, &body("left/upper").hinge.stiffness), (&vec![4.0], &vec![7.0]));
    assert_eq!(body("left/upper").hinge.rest, [0.1]);
    assert_eq!(body("right/lower").hinge.position, [-0.3]);
    assert_eq!(body("tool").hinge.parent, "left/lower");
}

#[test]
fn problems_are_told_where_they_are() {
    let typo =
        Folder::new(&two_links(), "[model]\nfile = \"robots/r.urdf\"\nbase = \"fre\"\npositions = { elbo = 1.0 }\n");
    insta::assert_snapshot!(typo.said(&[]), @r###"
    error: [model]: `base` does not know `fre`
     --> scene.toml:3:8
      |
    3 | base = "fre"
      |        ^^^^^
      |
      = help: did you mean `free`?

    scene.toml: 1 error
    "###);
    insta::assert_snapshot!(typo.said(&["model.base=free"]), @r###"
    error: the model has no joint or body `elbo`
     --> scene.toml:4:15
      |
    4 | positions = { elbo = 1.0 }
      |               ^^^^
      |
      = help: did you mean `elbow`?

    scene.toml: 1 error
    "###);
    let missing = Folder::new(&two_links(), "model = \"robots/s.urdf\"\n");
    insta::assert_snapshot!(missing.said(&[]), @r###"
    error: no model `robots/s.urdf`: did you mean `robots/r.urdf`?
     --> scene.toml:1:9
      |
    1 | model = "robots/s.urdf"
      |         ^^^^^^^^^^^^^^^

    scene.toml: 1 error
    "###);
    let inside = Folder::new(
        &two_links().replacen("parent link=\"upper\"", "parent link=\"uper\"", 1),
        "model = \"robots/r.urdf\"\n",
    );
    insta::assert_snapshot!(inside.said(&[]), @r###"
    error: joint `elbow`: there is no link `uper`
     --> robots/r.urdf:6:47
      |
    6 | <joint name="elbow" type="continuous"><parent link="uper"/><child link="lower"/><origin xyz="0 0 -1"/><axis xyz="0 1 0"/></joint>
      |                                               ^^^^^^^^^^^
      |
      = help: did you mean `upper`?

    scene.toml: 1 error
    "###);
    let heavy = Folder::new(
        &two_links(),
        "model = \"robots/r.urdf\"\n\n[[body]]\nname = \"upper\"\nmass = 1.0\nhinge = { type = \"free\" }\n",
    );
    insta::assert_snapshot!(heavy.said(&[]), @r###"
    error: two bodies are called `upper`
     --> scene.toml:4:8
      |
    4 | name = "upper"
      |        ^^^^^^^
      |
      = help: names must be unique

    scene.toml: 1 error
    "###);
}
