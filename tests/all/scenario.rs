//! Scenario files: what is written arrives in the description.

use nalgebra::{Matrix3, Rotation3, Vector3};
use std::fs;
use std::path::Path;
use stillpoint::integrate::Method as Stepping;
use stillpoint::model::description::{
    Attachment, BodyDescription, Bushing, ForceKind, HingeKind, Load, LoadAxes, Point, Spring,
};
use stillpoint::model::shape::Geometry;
use stillpoint::scenario::{self, LoadError, Override, ReadError, Scenario};
use stillpoint::simulate::settings::{Integrator, Start};
use stillpoint::statics::settings::{Method, Want};

const TWO_LINKS: &str = r#"
title = "Two links from a bracket"

[simulate]
start = "given"
duration = 3
integrator = "dopri5"
tolerance = 1e-6

[statics]
want = "any"
method = "newton"

[record]
rate = 50

[[body]]
name = "upper"
mass = 2.0
center = [0.0, 0.0, -0.5]
inertia = [0.17, 0.17, 0.004, 0.001, 0.002, 0.003]
markers = { tip = [0.0, 0.0, -1.0] }
shape = { box = [0.05, 0.05, 1.0], at = [0.0, 0.0, -0.5], color = [1, 0, 0] }
hinge = { type = "revolute", at = [0.0, 0.0, 2.0], axis = [0.0, 1.0, 0.0], position = 0.3 }

[[body]]
name = "link"
repeat = 3
mass = 1.0
center = [0.0, 0.0, -0.25]
inertia = [0.02, 0.02, 0.001]
markers = { tip = [0.0, 0.0, -0.5] }
hinge = { type = "revolute", parent = "upper", at = "tip", axis = [0.0, 1.0, 0.0], stiffness = 5.0, damping = 0.1 }

[[force]]
type = "spring"
between = ["link[2].tip", { body = "ground", at = [1.0, 0.0, 0.5] }]
stiffness = 40.0
length = 1.2
damping = 0.5

[[force]]
type = "load"
on = "link[2].tip"
force = [0.0, 0.0, 0.0]
"#;

fn read(text: &str) -> Scenario {
    scenario::parse("scene.toml", text, &[]).unwrap_or_else(|diagnostics| panic!("{diagnostics}"))
}

fn set(text: &str, overrides: &[&str]) -> Scenario {
    let overrides: Vec<Override> = overrides.iter().map(|text| Override::parse(text).expect("an override")).collect();
    scenario::parse("scene.toml", text, &overrides).unwrap_or_else(|diagnostics| panic!("{diagnostics}"))
}

fn marker(name: &str) -> Point {
    Point::Marker(name.to_owned())
}

#[test]
fn a_scene_arrives_as_it_is_written() {
    let scenario = read(TWO_LINKS);
    let description = &scenario.description;
    assert_eq!(description.gravity, Vector3::new(0.0, 0.0, -9.80665));
    let names: Vec<&str> = description.bodies.iter().map(|body| body.name.as_str()).collect();
    assert_eq!(names, ["upper", "link[0]", "link[1]", "link[2]"]);
    let upper = &description.bodies[0];
    assert_eq!(upper.mass.inertia, Matrix3::new(0.17, 0.001, 0.002, 0.001, 0.17, 0.003, 0.002, 0.003, 0.004));
    assert_eq!(upper.hinge.kind, HingeKind::Revolute { axis: Vector3::y() });
    assert_eq!((upper.hinge.parent.as_str(), &upper.hinge.position[..]), ("ground", &[0.3][..]));
    assert_eq!(upper.shapes[0].geometry, Geometry::Box(Vector3::new(0.05, 0.05, 1.0)));
    assert_eq!(upper.shapes[0].color, Some([1.0, 0.0, 0.0, 1.0]));
    let tip = Attachment { body: "link[2]".to_owned(), point: marker("tip") };
    let ground = Attachment { body: "ground".to_owned(), point: Point::At(Vector3::new(1.0, 0.0, 0.5)) };
    let spring =
        ForceKind::Spring(Spring { between: [tip.clone(), ground], stiffness: 40.0, length: 1.2, damping: 0.5 });
    assert_eq!((description.forces[0].name.as_str(), &description.forces[0].kind), ("force[0]", &spring));
    let zero = Vector3::zeros();
    let load = ForceKind::Load(Load { on: tip, force: zero, torque: zero, axes: LoadAxes::Inertial, over_time: None });
    assert_eq!((description.forces[1].name.as_str(), &description.forces[1].kind), ("force[1]", &load));
}

#[test]
fn settings_arrive_as_they_are_written() {
    let scenario = read(TWO_LINKS);
    assert_eq!(
        (scenario.simulate.start, scenario.simulate.integrator),
        (Start::Given, Integrator::Method(Stepping::Dopri5))
    );
    assert_eq!((scenario.simulate.duration, scenario.simulate.tolerance), (3.0, 1e-6));
    assert_eq!((scenario.statics.want, scenario.statics.method), (Want::Any, Method::Newton));
    assert_eq!(scenario.record.rate, 50.0);
}

#[test]
fn copies_hang_on_the_copy_before() {
    let scenario = read(TWO_LINKS);
    let hangs = |body: &BodyDescription| (body.hinge.parent.clone(), body.hinge.at.clone());
    let chain: Vec<_> = scenario.description.bodies[1..].iter().map(hangs).collect();
    let on = |parent: &str| (parent.to_owned(), marker("tip"));
    assert_eq!(chain, [on("upper"), on("link[0]"), on("link[1]")]);
}

#[test]
fn next_says_where_copies_hang() {
    let chain = |next_in_body: &str, next_in_hinge: &str| {
        let text = format!(
            "[[body]]\nname = \"a\"\nrepeat = 2\nmass = 1\ninertia = [1, 1, 1]\nmarkers.tip = [0, 0, 1]\n{next_in_body}\n\
             hinge = {{ type = \"spherical\", at = [5, 0, 0]{next_in_hinge} }}"
        );
        read(&text).description.bodies.into_iter().map(|body| body.hinge.at).collect::<Vec<_>>()
    };
    let first = Point::At(Vector3::new(5.0, 0.0, 0.0));
    assert_eq!(chain("", ", next = \"tip\""), [first.clone(), marker("tip")]);
    assert_eq!(chain("next = \"tip\"", ""), [first.clone(), marker("tip")]);
    assert_eq!(chain("", ""), [first.clone(), first]);
}

#[test]
fn lists_give_one_value_per_copy() {
    let scenario = read(
        r#"
        [[body]]
        name = "a"
        repeat = 2
        mass = [1, 2]
        inertia = [1, 1, 1]
        hinge = { type = "revolute", axis = [0, 1, 0], position = [0.1, 0.2], stiffness = 7 }
        [[body]]
        name = "b"
        repeat = 2
        mass = 1
        inertia = [1, 1, 1]
        hinge = { type = "planar", position = [[1, 2, 3], [4, 5, 6]], velocity = [7, 8, 9], damping = 0.5 }
        "#,
    );
    let bodies = &scenario.description.bodies;
    let hinge = |body: usize| &bodies[body].hinge;
    assert_eq!((bodies[0].mass.mass, bodies[1].mass.mass), (1.0, 2.0));
    assert_eq!((&hinge(0).position[..], &hinge(1).position[..]), (&[0.1][..], &[0.2][..]));
    assert_eq!(hinge(1).stiffness, [7.0]);
    assert_eq!((&hinge(2).position[..], &hinge(3).position[..]), (&[1.0, 2.0, 3.0][..], &[4.0, 5.0, 6.0][..]));
    assert_eq!((&hinge(3).velocity[..], &hinge(3).damping[..]), (&[7.0, 8.0, 9.0][..], &[0.5; 3][..]));
}

#[test]
fn density_fills_the_shapes() {
    let scenario = read(
        r#"
        [[body]]
        name = "dumbbell"
        density = 1000
        shape = [
            { box = [0.1, 0.1, 0.1], at = [0.5, 0, 0] },
            { box = [0.1, 0.1, 0.1], at = [-0.5, 0, 0], rpy = [0.1, 0.2, 0.3] },
        ]
        hinge = { type = "free" }
        "#,
    );
    let mass = &scenario.description.bodies[0].mass;
    // Two cubes of 1 kg, each a² / 6 about its own axes, 0.5 m off the middle; round-off of numbers below 3.
    let own = 2.0 * 0.01 / 6.0;
    assert!((mass.mass - 2.0).abs() < 1e-14 && mass.center.norm() < 1e-15);
    let expected = Matrix3::from_diagonal(&Vector3::new(own, own + 0.5, own + 0.5));
    assert!((mass.inertia - expected).norm() < 1e-14, "{}", mass.inertia);
}

#[test]
fn rpy_turns_as_in_urdf() {
    let text =
        "[[body]]\nname = \"a\"\nmass = 1\ninertia = [1, 1, 1]\nhinge = { type = \"free\", rpy = [0.3, -0.4, 1.1] }";
    let turn = read(text).description.bodies[0].hinge.frame.to_rotation_matrix();
    let about = |axis, angle| Rotation3::from_axis_angle(&axis, angle);
    let expected = about(Vector3::z_axis(), 1.1) * about(Vector3::y_axis(), -0.4) * about(Vector3::x_axis(), 0.3);
    // Round-off of products of rotations.
    assert!((turn.matrix() - expected.matrix()).norm() < 1e-15 * 9.0);
}

#[test]
fn bushings_take_six_numbers_or_two_kinds() {
    let six = |stiffness: &str| {
        let text = format!(
            "[[body]]\nname = \"a\"\nmass = 1\ninertia = [1, 1, 1]\nhinge = {{ type = \"free\" }}\n\
             [[force]]\ntype = \"bushing\"\nbetween = [\"a\", \"ground\"]\nstiffness = {stiffness}"
        );
        match read(&text).description.forces.remove(0).kind {
            ForceKind::Bushing(Bushing { stiffness, .. }) => stiffness,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(six("[1, 2, 3, 4, 5, 6]"), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    assert_eq!(six("{ translation = 7, rotation = [4, 5, 6] }"), [7.0, 7.0, 7.0, 4.0, 5.0, 6.0]);
}

#[test]
fn overrides_reach_every_part_of_a_scene() {
    let scenario = set(
        TWO_LINKS,
        &[
            "gravity=[0,0,-1.6]",
            "simulate.duration=2",
            "statics.want=stable",
            "upper.mass=5",
            "upper.hinge.position=0.5",
            "upper.velocity=0.25",
            "upper.markers.tip=[0,0,-2]",
            "link.stiffness=[1,2,3]",
            "force[0].length=2",
            "hinge.armature=0.01",
        ],
    );
    let description = &scenario.description;
    assert_eq!(description.gravity.z, -1.6);
    assert_eq!((scenario.simulate.duration, scenario.statics.want), (2.0, Want::Stable));
    let upper = &description.bodies[0];
    assert_eq!(upper.mass.mass, 5.0);
    assert_eq!((upper.hinge.position[0], upper.hinge.velocity[0]), (0.5, 0.25));
    assert_eq!(upper.markers[0].1.z, -2.0);
    assert_eq!(description.bodies[2].hinge.stiffness, [2.0]);
    assert!(description.bodies.iter().all(|body| body.hinge.armature == [0.01]));
    assert!(matches!(description.forces[0].kind, ForceKind::Spring(Spring { length: 2.0, .. })));
}

#[test]
fn long_chains_are_short_files() {
    let scenario = read(
        "[[body]]\nname = \"link\"\nrepeat = 100_000\nmass = 0.1\ninertia = [1, 1, 1]\nmarkers.tip = [0, 0, -0.1]\n\
         hinge = { type = \"spherical\", next = \"tip\" }",
    );
    assert_eq!(scenario.description.bodies[99_999].hinge.parent, "link[99998]");
}

#[test]
fn the_schema_closes_every_table_and_names_the_units() {
    let schema = scenario::schema();
    assert_eq!(schema["$schema"], "https://json-schema.org/draft/2020-12/schema");
    assert_eq!(schema["additionalProperties"], false);
    let body = &schema["properties"]["body"]["items"];
    assert_eq!(body["required"], serde_json::json!(["name", "hinge"]));
    assert_eq!(body["properties"]["density"]["exclusiveMinimum"], 0.0);
    let hinges = body["properties"]["hinge"]["oneOf"].as_array().expect("one variant per type");
    assert_eq!(hinges.len(), 10);
    assert_eq!(hinges[1]["properties"]["type"]["const"], "revolute");
    assert_eq!(hinges[1]["required"], serde_json::json!(["type", "axis"]));
    let text = schema.to_string();
    assert_eq!(text.matches("\"properties\"").count(), text.matches("\"additionalProperties\":false").count());
    assert!(text.contains("kg m²"));
}

#[test]
fn lists_of_elements_may_be_empty_and_no_others() {
    let schema = scenario::schema();
    let keys = schema["properties"].as_object().expect("keys");
    let lists: Vec<&String> = keys.iter().filter(|(_, key)| key["minItems"] == 0).map(|(name, _)| name).collect();
    assert!(lists.len() > 10, "{lists:?}");
    let body = "[[body]]\nname = \"a\"\nmass = 1.0\nhinge = { type = \"prismatic\", axis = [0, 0, 1] }\n";
    let parse = |text: &str| scenario::parse("scene.toml", text, &[]).map_err(|problems| problems.to_string());
    for key in lists.iter().filter(|key| **key != "body") {
        let scenario = parse(&format!("{key} = []\n{body}")).unwrap_or_else(|problems| panic!("{key}: {problems}"));
        assert_eq!(scenario.description.bodies.len(), 1, "{key}");
    }
    let none = parse("body = []\n").expect_err("a scene of nothing");
    assert!(none.contains("the scene has no bodies") && none.contains("add at least one [[body]]"), "{none}");
    let moment = parse(&body.replace("mass = 1.0", "mass = 1.0\ninertia = []")).expect_err("an inertia of nothing");
    assert!(moment.contains("found an empty list"), "{moment}");
}

fn failure(path: &Path) -> String {
    scenario::load(path).expect_err("a file that cannot be read").to_string()
}

#[test]
fn files_that_are_no_scenarios_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name);
    let write = |name: &str, bytes: &[u8]| fs::write(path(name), bytes).expect("a file");
    write("chain.toml", TWO_LINKS.as_bytes());
    write("binary.toml", b"title = \"x\"\n\xC3\x28");
    write("zero.toml", b"\0\0");
    write("wide.toml", b"\xFF\xFE[\0[\0");
    write("marked.toml", [b"\xEF\xBB\xBF", TWO_LINKS.as_bytes()].concat().as_slice());

    let near =
        format!("no scenario `{}`: did you mean `{}`?", path("chian.toml").display(), path("chain.toml").display());
    assert_eq!(failure(&path("chian.toml")), near);
    assert_eq!(failure(folder.path()), format!("`{}` is a folder, not a scenario file", folder.path().display()));
    assert!(failure(&path("binary.toml")).ends_with("is not UTF-8 text: byte 12 (line 2) is 0xC3"));
    assert!(failure(&path("zero.toml")).ends_with("byte 0 (line 1) is 0x00, which stands in no text"));
    assert!(failure(&path("wide.toml")).ends_with("is 0xFF; it looks like UTF-16, save it as UTF-8"));
    assert!(scenario::load(&path("marked.toml")).is_ok(), "a byte order mark before UTF-8 is no harm");
    assert!(scenario::load(&path("chain.toml")).is_ok());
}

#[test]
fn large_files_load_and_huge_ones_are_refused_at_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("large.toml");
    let body = |index: usize| {
        format!(
            "[[body]]\nname = \"b{index}\"\nmass = 1.0\ninertia = [1, 1, 1]\nhinge = {{ type = \"free\", at = [{index}, 0, 0] }}\n\n"
        )
    };
    let text: String = (0..20_000).map(body).collect();
    fs::write(&path, &text).expect("a file");
    assert_eq!(scenario::load(&path).expect("20 000 bodies").description.bodies.len(), 20_000);
    fs::write(&path, text.repeat(1 + (50 << 20) / text.len())).expect("50 MB");
    assert!(matches!(scenario::load(&path), Err(LoadError::File(ReadError::TooLarge { .. }))));
    assert!(failure(&path).contains("larger than 32 MiB"));
}
#[test]
fn damaged_files_are_answered_without_panic() {
    for at in 0..TWO_LINKS.len() {
        for bit in ["", "[", "\"", "\n", "-", "nan", "µ"] {
            let text = format!("{}{bit}{}", &TWO_LINKS[..at], &TWO_LINKS[at + 1..]);
            if let Err(diagnostics) = scenario::parse("scene.toml", &text, &[]) {
                assert!(diagnostics.errors() > 0 && !diagnostics.render(true).is_empty());
            }
        }
    }
}
