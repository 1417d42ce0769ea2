//! Numbers of `[parameters]` by address: what is set is what the file says with that value, whatever depends on it.

use crate::common::Random;
use stillpoint::dynamics::System;
use stillpoint::model::{Model, Parameter};
use stillpoint::scenario::{self, Override, Scenario, start};
use stillpoint::statics::{self, hold, path::follow};

fn read(text: &str, set: &[String]) -> Scenario {
    let set: Vec<Override> = set.iter().map(|text| Override::parse(text).expect("path and value")).collect();
    scenario::parse("named.toml", text, &set).unwrap_or_else(|problems| panic!("{problems}\n{text}"))
}

/// A chain whose masses, lengths, stiffnesses, points and loads follow from a few numbers.
fn chain(random: &mut Random) -> String {
    let mut pick = |low: f64, high: f64| (random.between(low, high) * 1e3).round() / 1e3;
    let mut text = format!(
        "[parameters]\nm = \"{} kg\"\nl = \"{} mm\"\nk = {}\nhalf = \"{{l}}/2\"\nangle = \"{} deg\"\n",
        pick(0.5, 3.0),
        pick(200.0, 900.0),
        pick(20.0, 90.0),
        pick(-80.0, 80.0)
    );
    for link in 0..1 + (pick(0.0, 3.0) as usize) {
        let parent = if link == 0 { String::new() } else { format!(", parent = \"link{}\", at = \"tip\"", link - 1) };
        text += &format!(
            "[[body]]\nname = \"link{link}\"\nmass = \"{} * {{m}}\"\ninertia = [\"{{m}}*{{l}}^2\", \"{{m}}*{{l}}^2\", \"{{m}}*{{l}}*{{half}}/9\"]\n\
             center = [\"{{half}}\", 0, {}]\nmarkers = {{ tip = [\"{{l}}\", 0, 0] }}\n\
             hinge = {{ type = \"revolute\", axis = [0, 1, 0], stiffness = \"{{k}}\", rest = \"{{angle}}\", position = {}{parent} }}\n",
            pick(0.5, 2.0),
            pick(-0.1, 0.1),
            pick(-1.0, 1.0)
        );
    }
    text + &format!(
        "[[force]]\nname = \"stay\"\ntype = \"spring\"\nstiffness = \"{{k}}*3\"\nlength = \"{{l}}*2\"\n\
         between = [\"link0.tip\", {{ body = \"ground\", at = [\"{{l}}\", 0, {}] }}]\n",
        pick(0.5, 2.0)
    )
}

const NAMES: [&str; 5] = ["m", "l", "k", "half", "angle"];

/// Setting a named number by its address is reading the file with it; what was set before stays.
#[test]
fn a_number_that_is_set_is_the_number_of_the_file() {
    let mut random = Random::new(5);
    for case in 0..60 {
        let text = chain(&mut random);
        let mut scene = read(&text, &[]).description;
        let mut set = Vec::new();
        for _ in 0..4 {
            let address = match random.below(3) {
                0 => "stay.length".to_owned(),
                1 => "link0.force".to_owned(),
                _ => format!("parameters.{}", NAMES[random.below(NAMES.len())]),
            };
            let found = &Parameter::find(&scene, &address).expect(&address)[0];
            let value = random.between(0.3, 2.0);
            found.set(&mut scene, value).expect(&address);
            assert_eq!(found.value(&scene), value, "case {case}: {address}");
            // A number that was set by itself is given back to its formula by nothing.
            set.retain(|(other, _): &(String, f64)| *other != address);
            set.push((address, value));
        }
        // The file's own numbers first: what is set by itself does not follow from them any more.
        set.sort_by_key(|(address, _)| !address.starts_with("parameters."));
        let changes: Vec<String> = set.iter().map(|(address, value)| format!("{address}={value:?}")).collect();
        let mut expected = read(&text, &changes).description;
        expected.bodies[0].hinge.force.resize(scene.bodies[0].hinge.force.len(), 0.0);
        assert_eq!(scene, expected, "case {case}: {changes:?}\n{text}");
    }
}

/// The value that inverse statics finds holds the pose of the file that is read with it.
#[test]
fn a_named_number_that_is_found_holds_the_pose() {
    let mut random = Random::new(11);
    let (mut held, mut tried) = (0, 0);
    for _ in 0..80 {
        let name = ["m", "l", "k", "angle"][random.below(4)];
        let text = chain(&mut random);
        // One hinge, one number: the others hold their pose by a force each.
        let links = text.matches("[[body]]").count();
        let others: String = (1..links).map(|link| format!(", \"link{link}.force\"")).collect();
        let scenario = read(&format!("statics = {{ unknown = [\"parameters.{name}\"{others}] }}\n{text}"), &[]);
        let pose = Model::build(&scenario.description).expect("a model").start_position.clone();
        let found = hold(&scenario.description, &scenario.unknown, &pose, &scenario.statics).expect("finite").found;
        tried += 1;
        if !found.converged {
            // Not every pose can be held by any mass or length: that is said.
            assert!(!found.notes.is_empty(), "{text}");
            continue;
        }
        let set: Vec<String> = found.unknowns.iter().map(|(address, value)| format!("{address}={value:?}")).collect();
        let model = Model::build(&read(&text, &set).description).expect("a model");
        let rest = vec![0.0; model.velocity_count()];
        let mut left = rest.clone();
        System::new(&model).at(0.0, &pose, &rest).residual(&rest, &mut left).expect("finite");
        let largest = left.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        // Forces are of the order of 10 to 1000 N.
        assert!(largest < 1e-9, "{name}: {largest} left with {set:?}\n{text}");
        held += 1;
    }
    assert!(held > tried / 2, "{held} of {tried}");
}

/// Every point of a path over a named number is an equilibrium of the file with that value.
#[test]
fn a_path_over_a_named_number_is_one_of_files() {
    let mut random = Random::new(3);
    for (name, factor) in [("m", 1.5), ("l", 0.8), ("k", 1.3), ("half", 1.2), ("angle", 0.5)] {
        let text = chain(&mut random);
        let at = read(&text, &[]).description;
        let from = Parameter::find(&at, &format!("parameters.{name}")).expect(name)[0].value(&at);
        let path = format!("statics.path = {{ parameter = \"parameters.{name}\", to = {} }}\n{text}", from * factor);
        let scenario = read(&path, &[]);
        let settings = scenario.path.as_ref().expect("a path");
        let path = follow(&scenario.description, &scenario.statics, settings, &mut |_| true).expect(name);
        let points = &path.branches[0].points;
        assert!(points.len() > 3 && path.complete, "{name}: {:?}\n{text}", path.notes);
        for point in points {
            let set = [format!("parameters.{name}={:?}", point.parameter)];
            let model = Model::build(&read(&text, &set).description).expect("a model");
            let rest = vec![0.0; model.velocity_count()];
            let mut left = rest.clone();
            System::new(&model).at(0.0, &point.position, &rest).residual(&rest, &mut left).expect("finite");
            // As precise as the path says of itself: forces of some 100 N.
            assert!(left.iter().all(|f| f.abs() < 1e-6), "{name} = {}: {left:?}", point.parameter);
        }
    }
}

#[test]
fn start_files_and_messages_know_named_numbers() {
    let text = chain(&mut Random::new(1));
    let scene = read(&text, &[]).description;
    let model = Model::build(&scene).expect("a model");
    let inputs = [("parameters.m".to_owned(), 7.25)];
    let start = start::text(&model, &model.start_position, &model.start_velocity, &inputs, &[]);
    let started = start::parse_start("start.toml", &start, &scene).expect("a start");
    let mut expected = read(&text, &["parameters.m=7.25".to_owned()]).description;
    for (body, given) in expected.bodies.iter_mut().zip(&started.description.bodies) {
        body.hinge.velocity.clone_from(&given.hinge.velocity);
        body.hinge.position.clone_from(&given.hinge.position);
    }
    assert_eq!(started.description, expected);
    assert_eq!(started.changes[0].0, "parameters.m");
    // In its unit, and in no other.
    assert!(start::parse_start("start.toml", &start.replace("7.25", "\"7250 g\""), &scene).is_ok());
    let error = start::parse_start("start.toml", &start.replace("7.25", "\"7 m\""), &scene).map(|_| ());
    assert!(error.expect_err("a length").to_string().contains("it is measured in kg"));
    let error = start::parse_start("start.toml", &start.replace("7.25", "-1.0"), &scene).map(|_| ());
    assert!(error.expect_err("a negative mass").to_string().contains("mass"));
    // Slips of the finger, everywhere.
    for place in ["unknown = [\"parameters.angel\"]", "path = { parameter = \"parameters.angel\", to = 1 }"] {
        let error = scenario::parse("s.toml", &format!("statics.{place}\n{text}"), &[]).map(|_| ()).expect_err(place);
        assert!(error.to_string().contains("did you mean `parameters.angle`?"), "{error}");
    }
    let moved = text.replacen("position = ", "position = \"{angle}\" # ", 1);
    let moved = moved.replace(", position = \"{angle}\" # ", ", position = \"{angle}\" }\n#");
    let error = scenario::parse("s.toml", &format!("statics.unknown = [\"parameters.angle\"]\n{moved}"), &[]);
    assert!(error.map(|_| ()).expect_err("the pose").to_string().contains("moves the pose"), "{moved}");
    let nothing = format!(
        "statics.unknown = [\"parameters.idle\"]\n{}",
        text.replacen("[parameters]", "[parameters]\nidle = 1", 1)
    );
    let scenario = read(&nothing, &[]);
    let pose = Model::build(&scenario.description).expect("a model").start_position.clone();
    let found =
        hold(&scenario.description, &scenario.unknown, &pose, &statics::Settings::default()).expect("finite").found;
    assert!(!found.converged && found.notes.iter().any(|note| note.contains("cannot influence")), "{:?}", found.notes);
}
