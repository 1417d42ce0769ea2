//! One way to address numbers, wherever an address is written: `--set`, `--over`, `[statics] unknown`, `[statics.path]`
//! and start files.

use std::ops::Range;
use stillpoint::model::{Description, Model, Parameter};
use stillpoint::scenario::{self, Override, Scenario, start};
use toml::de::DeValue;

const SCENE: &str = r#"
gravity = [0.0, 0.0, -9.0]

[[body]]
name = "upper"
mass = 2.0
inertia = [0.2, 0.2, 0.2]
center = [0.0, 0.0, -0.5]
markers = { tip = [0.0, 0.0, -1.0] }
hinge = { type = "revolute", axis = [0.0, 1.0, 0.0], stiffness = 50.0, position = 0.2 }

[[body]]
name = "link"
repeat = 4
mass = 1.0
center = [0.0, 0.0, -0.25]
inertia = [0.02, 0.02, 0.001]
markers = { tip = [0.0, 0.0, -0.5] }
hinge = { type = "revolute", parent = "upper", at = "tip", axis = [0.0, 1.0, 0.0], stiffness = 5.0 }

[[body]]
name = "slider.a"
mass = 1.0
inertia = [0.1, 0.1, 0.1]
hinge = { type = "planar", rpy = [1.5707963267948966, 0.0, 0.0], stiffness = 30.0 }

[[body]]
name = "crank"
mass = 1.0
inertia = [0.1, 0.1, 0.1]
hinge = { type = "revolute", axis = [0.0, 1.0, 0.0] }

[[body]]
name = "arm"
mass = 1.0
inertia = [0.1, 0.1, 0.1]
center = [0.3, 0.0, 0.0]
hinge = { type = "revolute", axis = [0.0, 1.0, 0.0], stiffness = 20.0 }

[[force]]
name = "push"
type = "load"
on = "link[3].tip"
force = [0.1, 0.2, 0.3]

[[force]]
type = "spring"
between = ["upper.tip", { body = "ground", at = [1.0, 0.0, 0.0] }]
stiffness = 40.0
length = 1.2

[[force]]
name = "mount"
type = "bushing"
between = ["slider.a", "ground"]
stiffness = { translation = 10.0, rotation = [1.0, 2.0, 3.0] }

[[drive]]
name = "engine"
type = "rate"
hinge = "crank"
rate = 3.0

[[motor]]
name = "servo"
type = "constant"
hinge = "arm"
force = 1.5
"#;

fn read(text: &str, set: &[String]) -> Result<Scenario, String> {
    let set: Vec<Override> = set.iter().map(|text| Override::parse(text).expect("path and value")).collect();
    scenario::parse("scene.toml", text, &set).map_err(|problems| problems.to_string())
}

/// The number that an address stands for, read by the model's own rules.
fn value(scenario: &Scenario, address: &str) -> f64 {
    match Parameter::find(&scenario.description, address).as_deref() {
        Ok([one]) => one.value(&scenario.description),
        other => panic!("{address}: {other:?}"),
    }
}

/// Without lists of zeros: what is not given is zero.
fn bare(mut scene: Description) -> Description {
    for body in &mut scene.bodies {
        let hinge = &mut body.hinge;
        for list in [&mut hinge.force, &mut hinge.stiffness, &mut hinge.rest, &mut hinge.position] {
            if list.iter().all(|x| *x == 0.0) {
                list.clear();
            }
        }
    }
    scene
}

/// Addresses of one number that statics feels, with its value in the scene.
const NUMBERS: [(&str, f64); 17] = [
    ("gravity[2]", -9.0),
    ("upper.mass", 2.0),
    ("upper.hinge.stiffness", 50.0),
    ("upper.stiffness[0]", 50.0),
    ("link[3].stiffness", 5.0),
    ("link[0].hinge.force", 0.0),
    ("link[2].mass", 1.0),
    ("slider.a.stiffness[1]", 30.0),
    ("slider.a.force[2]", 0.0),
    ("push.force[2]", 0.3),
    ("force[0].force[1]", 0.2),
    ("push.torque[1]", 0.0),
    ("force[1].length", 1.2),
    ("mount.stiffness[0]", 10.0),
    ("mount.stiffness[4]", 2.0),
    ("drive[0].rate", 3.0),
    ("motor[0].force", 1.5),
];

#[test]
fn every_place_knows_every_address() {
    let plain = read(SCENE, &[]).expect("the scene");
    let model = Model::build(&plain.description).expect("a model");
    for (address, before) in NUMBERS {
        assert_eq!(value(&plain, address), before, "{address}");
        let now = before + 0.5;
        // `--set`, which is `--over` case by case: this number, and no other.
        let set = read(SCENE, &[format!("{address}={now}")]).unwrap_or_else(|error| panic!("{address}: {error}"));
        let mut expected = plain.description.clone();
        Parameter::find(&expected, address).expect("found")[0].set(&mut expected, now).expect(address);
        assert_eq!(bare(set.description), bare(expected), "{address}");
        // `[statics] unknown` and `[statics.path]`.
        let unknown = read(&format!("statics.unknown = [\"{address}\"]\n{SCENE}"), &[]).expect(address);
        assert_eq!(unknown.unknown, Parameter::find(&plain.description, address).expect("found"));
        let path = format!("statics.path = {{ parameter = \"{address}\", to = {} }}\n{SCENE}", before + 0.25);
        let path = read(&path, &[]).unwrap_or_else(|error| panic!("{address}: {error}")).path.expect("a path");
        assert_eq!((path.numbers, path.from), (unknown.unknown, before));
        // Start files.
        let inputs = [(address.to_owned(), now)];
        let text = start::text(&model, &model.start_position, &model.start_velocity, &inputs, &[]);
        let started = start::parse_start("start.toml", &text, &plain.description).expect(address);
        assert_eq!(started.changes.len(), 1, "{address}");
        assert_eq!((started.changes[0].1, started.changes[0].2), (before, now), "{address}");
    }
}

/// Wrong addresses, and a word of the answer, which is the same in every place.
const WRONG: [(&str, &str); 10] = [
    ("uper.mass", "did you mean `upper`?"),
    ("upper.mas", "did you mean `mass`?"),
    ("pushh.force[2]", "did you mean `push`?"),
    ("gravty[2]", "did you mean `gravity`?"),
    ("gravity[3]", "components are 0 to 2"),
    ("push.force[3]", "components are 0 to 2"),
    ("upper.mass[1]", "one number, without a component"),
    ("link[4].stiffness", "link["),
    ("drive[1].rate", "drive"),
    ("slider.a.stiffness[3]", "components are 0 to 2"),
];

#[test]
fn wrong_addresses_are_answered_alike() {
    let plain = read(SCENE, &[]).expect("the scene");
    let model = Model::build(&plain.description).expect("a model");
    for (address, word) in WRONG {
        let refused = |place: &str, answer: Result<Scenario, String>| {
            let error = answer.map(|_| ()).expect_err(&format!("{address} in {place}"));
            assert!(error.contains(word), "{address} in {place}: {error}");
        };
        refused("--set", read(SCENE, &[format!("{address}=1.0")]));
        refused("unknown", read(&format!("statics.unknown = [\"{address}\"]\n{SCENE}"), &[]));
        let path = format!("statics.path = {{ parameter = \"{address}\", to = 1.0 }}\n{SCENE}");
        refused("path", read(&path, &[]));
        let inputs = [(address.to_owned(), 1.0)];
        let text = start::text(&model, &model.start_position, &model.start_velocity, &inputs, &[]);
        let started = start::parse_start("start.toml", &text, &plain.description);
        refused("start", started.map(|_| plain.clone()).map_err(|problems| problems.to_string()));
    }
}

/// Values of copies and components that statics does not feel, too.
#[test]
fn parts_of_values_are_written_out() {
    let set = |changes: &[&str]| {
        let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
        read(SCENE, &changes).unwrap_or_else(|error| panic!("{changes:?}: {error}")).description.bodies
    };
    let bodies = set(&["link[1].damping=0.5", "link[2].damping=0.7", "link[2].position=0.3"]);
    let of = |name: &str| bodies.iter().find(|body| body.name == name).expect("a body");
    let damping = |name: &str| of(name).hinge.damping.first().copied().unwrap_or(0.0);
    assert_eq!(["link[0]", "link[1]", "link[2]", "link[3]"].map(damping), [0.0, 0.5, 0.7, 0.0]);
    assert_eq!(of("link[2]").hinge.position, [0.3]);
    let bodies = set(&["slider.a.position[1]=0.4", "upper.center[0]=0.1", "slider.a.damping=2", "hinge.rest[2]=0.1"]);
    let of = |name: &str| bodies.iter().find(|body| body.name == name).expect("a body");
    assert_eq!(of("slider.a").hinge.position, [0.0, 0.4, 0.0]);
    assert_eq!(of("slider.a").hinge.damping, [2.0; 3]);
    assert_eq!((of("slider.a").hinge.rest[2], of("upper").hinge.rest.len()), (0.1, 0));
    assert_eq!(of("upper").mass.center.x, 0.1);
    let refused = |change: &str| read(SCENE, &[change.to_owned()]).expect_err(change);
    assert!(refused("link[1].center=[0,0,0]").contains("all copies have the same `center`"));
    assert!(refused("upper.name[0]=x").contains("without a component"));
}

/// The numbers of a value that stand within a list of a list, or of a table in one, with their addresses and places in the text.
fn nested(value: &toml::Spanned<DeValue<'_>>, address: &str, lists: usize, found: &mut Vec<(String, Range<usize>)>) {
    match value.get_ref() {
        DeValue::Array(items) => {
            for (index, item) in items.iter().enumerate() {
                nested(item, &format!("{address}[{index}]"), lists + 1, found);
            }
        }
        DeValue::Table(table) => {
            for (key, value) in table.iter().filter(|(key, _)| key.get_ref() != "markers") {
                nested(value, &format!("{address}.{}", key.get_ref()), lists + usize::from(lists > 0), found);
            }
        }
        DeValue::Integer(_) | DeValue::Float(_) if lists > 1 => found.push((address.to_owned(), value.span())),
        _ => {}
    }
}

/// Numbers within lists within elements of a file, by their addresses: set there, they are as if they were written there, whatever
/// that makes of the scene.
#[test]
fn numbers_within_lists_are_those_of_the_file() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/scenarios");
    let mut texts = vec![SCENE.to_owned()];
    for entry in std::fs::read_dir(folder).expect("the scenes") {
        let path = entry.expect("an entry").path();
        if path.extension().is_some_and(|end| end == "toml") {
            texts.push(std::fs::read_to_string(path).expect("a scene"));
        }
    }
    let (mut set, mut differ) = (0, 0);
    for text in texts {
        let document = toml::de::DeTable::parse(&text).expect("TOML");
        let mut found = Vec::new();
        for (list, elements) in document.get_ref().iter() {
            let Some(elements) = elements.get_ref().as_array() else { continue };
            for (index, element) in elements.iter().enumerate() {
                let Some(table) = element.get_ref().as_table() else { continue };
                let name = table.get("name").and_then(|name| name.get_ref().as_str());
                let address = match name {
                    // Copies have rules of their own.
                    _ if table.contains_key("repeat") => continue,
                    Some(name) => name.to_owned(),
                    None => format!("{}[{index}]", list.get_ref()),
                };
                nested(element, &address, 0, &mut found);
            }
        }
        let Ok(plain) = read(&text, &[]) else { continue };
        for (address, span) in found.into_iter().step_by(7) {
            let written = [&text[..span.start], "0.123", &text[span.end..]].concat();
            let now = read(&text, &[format!("{address}=0.123")]).map(|scene| scene.description);
            match read(&written, &[]) {
                Ok(expected) => {
                    differ += u32::from(plain.description != expected.description);
                    assert_eq!(now.as_ref(), Ok(&expected.description), "{address}");
                }
                Err(_) => assert!(now.is_err_and(|error| !error.contains("is not given")), "{address}"),
            }
            set += 1;
        }
    }
    assert!(set > 100 && differ > 50, "{set} numbers, {differ} of them change something");
}

/// What is not there within a list is said, with what is.
#[test]
fn wrong_places_within_lists_are_answered() {
    for (address, word) in [
        ("force[1].between[2].at[0]", "its components are 0 to 1"),
        ("force[1].between[1].at[3]", "its components are 0 to 2"),
        ("force[1].between[0].at[2]", "`between[0]` is not a table"),
        ("push.force[0][1]", "`force[0]` is not a list"),
        ("force[1].curve[0][1]", "unknown key `curve`"),
        ("force[1].betwen[1].at[0]", "did you mean `between`?"),
    ] {
        let error = read(SCENE, &[format!("{address}=1.0")]).expect_err(address);
        assert!(error.contains(word), "{address}: {error}");
    }
    let moved = read(SCENE, &["force[1].between[1].at[2]=0.5".to_owned()]).expect("a scene");
    assert_ne!(moved.description, read(SCENE, &[]).expect("a scene").description);
}

#[test]
fn a_model_that_is_set_is_read() {
    for change in ["model=nofile.urdf", "model=\"nofile.urdf\"", "model.file=nofile.urdf"] {
        let error = read(SCENE, &[change.to_owned()]).expect_err(change);
        assert!(error.contains("nofile.urdf"), "{change}: {error}");
    }
}

/// A number of a material has one name everywhere, with and without `material.`.
#[test]
fn materials_are_addressed_with_and_without_their_name() {
    let scene = "[[beam]]\nname = \"boom\"\nhinge = { type = \"fixed\" }\nlength = 2.0\nsection = { circle = 0.01 }\n\
                 material = { young = 70e9, density = 2700.0 }\n";
    for address in ["boom.young", "boom.material.young"] {
        let set = read(scene, &[format!("{address}=\"200 GPa\"")]).expect(address);
        let found = Parameter::find(&set.description, address).expect(address);
        assert_eq!((found[0].value(&set.description), found[0].quantity.unit()), (200e9, "Pa"), "{address}");
        let path = format!("statics.path = {{ parameter = \"{address}\", to = \"210 GPa\" }}\n{scene}");
        assert_eq!(read(&path, &[]).expect(address).path.expect("a path").to, 210e9);
    }
    assert!(read(scene, &["boom.density=8000".to_owned()]).is_ok());
    let refused = read(scene, &["boom.yung=1".to_owned()]).expect_err("no such key");
    assert!(refused.contains("did you mean `young`?"), "{refused}");
    let whole = read(scene, &[]).expect("a scene");
    let (first, later, shared) = whole.overlap(&[], &["boom.young", "boom.material.young"]).expect("one number");
    assert_eq!((first, later, shared.as_str()), (0, 1, "`boom.material.young`"));
}

/// A motor, a spring, a rod and a drive with the names of bodies, a template among them, and of a contact.
const NAMESAKES: &str = r#"
[[body]]
name = "arm"
mass = 1.0
center = [0.3, 0.0, 0.0]
inertia = [0.1, 0.1, 0.1]
markers = { tip = [0.6, 0.0, 0.0] }
hinge = { type = "revolute", axis = [0.0, 1.0, 0.0], position = 0.3, stiffness = 3.0, force = 0.5 }

[[body]]
name = "link"
repeat = 2
mass = 1.0
inertia = [0.1, 0.1, 0.1]
markers = { tip = [0.0, 0.0, -0.5] }
hinge = { type = "revolute", axis = [0.0, 1.0, 0.0], at = [0.0, 1.0, 0.0], stiffness = 4.0, next = "tip" }

[[body]]
name = "wall"
mass = 1.0
inertia = [0.1, 0.1, 0.1]
shape = [{ sphere = 0.1 }]
hinge = { type = "fixed", at = [0.0, 5.0, 0.0] }

[[force]]
name = "arm"
type = "spring"
between = ["arm.tip", { body = "ground", at = [2.0, 0.0, 0.0] }]
stiffness = 11.0
length = 1.2

[[motor]]
name = "arm"
type = "pd"
hinge = "arm"
target = -0.4
stiffness = 8.0
force = 0.2

[[motor]]
name = "link"
type = "pd"
hinge = "link[1]"
target = 0.1
stiffness = 9.0

[[motor]]
name = "wall"
type = "constant"
hinge = "link[0]"
force = 0.7
"#;

/// Every number is listed by an address of its own, which is that of this number wherever it is written: of elements that share a name,
/// too. So is a number that an address finds.
#[test]
fn numbers_of_namesakes_are_listed_by_addresses_of_their_own() {
    for scene in [NAMESAKES, SCENE] {
        let plain = read(scene, &[]).expect("the scene");
        let mut seen = std::collections::HashSet::new();
        for one in Parameter::all(&plain.description) {
            assert!(seen.insert(one.address.clone()), "`{}` is listed twice", one.address);
            assert_eq!(Parameter::find(&plain.description, &one.address), Ok(vec![one.clone()]));
            let now = one.value(&plain.description) + 0.125;
            let set = read(scene, &[format!("{}={now}", one.address)]).unwrap_or_else(|error| panic!("{error}"));
            let mut expected = plain.description.clone();
            one.set(&mut expected, now).expect("a number that can be set");
            assert_eq!(bare(set.description), bare(expected), "{}", one.address);
        }
    }
    let listed = |address: &str| {
        let scene = read(NAMESAKES, &[]).expect("the scene").description;
        let found = Parameter::find(&scene, address).expect(address);
        found.into_iter().map(|one| (one.address.clone(), one.value(&scene))).collect::<Vec<_>>()
    };
    let one = |address: &str, value: f64| vec![(address.to_owned(), value)];
    assert_eq!(listed("arm.stiffness"), one("arm.stiffness", 3.0));
    assert_eq!(listed("force[0].stiffness"), one("force[0].stiffness", 11.0));
    assert_eq!(listed("motor[0].stiffness"), one("motor[0].stiffness", 8.0));
    // What one of them alone has needs no place.
    assert_eq!(listed("arm.length"), one("arm.length", 1.2));
    assert_eq!(listed("motor[1].stiffness"), one("motor[1].stiffness", 9.0));
    assert_eq!(listed("link.stiffness").len(), 2, "the copies of the body stand before the motor");
    // A fixed hinge has no force, but its key: `--set` asks the body.
    assert_eq!(listed("motor[2].force"), one("motor[2].force", 0.7));
}

/// A number of the file that has no address says what to do, and that works.
#[test]
fn numbers_without_an_address_may_have_a_name() {
    let plain = read(SCENE, &[]).expect("the scene");
    for address in ["upper.center[2]", "upper.inertia[0]", "link[0].hinge.at[1]", "upper.markers.tip[2]", "servo.limit"]
    {
        let unknown = Parameter::find(&plain.description, address).expect_err(address);
        assert!(unknown.message.contains("is no number that can be addressed here"), "{unknown:?}");
        assert!(unknown.help.expect("help").contains("take `parameters.name`"), "{address}");
    }
    let named = SCENE.replacen("center = [0.0, 0.0, -0.5]", "center = [0.0, 0.0, \"{low}\"]", 1);
    let named = read(&format!("parameters = {{ low = -0.5 }}\n{named}"), &[]).expect("a scene");
    let mut moved = named.description.clone();
    Parameter::find(&moved, "parameters.low").expect("a number")[0].set(&mut moved, -0.75).expect("a scene");
    assert_eq!(moved.bodies[0].mass.center.z, -0.75);
}
