//! Files that nobody should write: they are refused or read, within bounds, and nothing panics.

use super::import;
use crate::common::Random;
use std::fs;
use std::path::Path;
use stillpoint::import::{Options, import_text};
use stillpoint::scenario::parse;

const MODELS: [(&str, &str); 6] = [
    ("joints.xml", include_str!("../../models/mjcf/joints.xml")),
    ("geoms.xml", include_str!("../../models/mjcf/geoms.xml")),
    ("defaults.xml", include_str!("../../models/mjcf/defaults.xml")),
    ("springs.xml", include_str!("../../models/mjcf/springs.xml")),
    ("actuators.xml", include_str!("../../models/mjcf/actuators.xml")),
    ("loops.xml", include_str!("../../models/mjcf/loops.xml")),
];

/// Words that are put in the place of others.
const WORDS: [&str; 24] = [
    "0",
    "-1",
    "1e308",
    "-1e-300",
    "nan",
    "inf",
    "",
    "1 2 3",
    "0 0 0 0 0 0",
    "free",
    "ball",
    "mesh",
    "box",
    "true",
    "ground",
    "a",
    "main",
    "\"",
    "<body>",
    "</body>",
    "count=\"100000\"",
    "&amp;",
    "ß",
    "../../../../../etc/passwd",
];

fn mutated(random: &mut Random, text: &str) -> String {
    let mut words: Vec<String> = text.split_inclusive([' ', '"', '>', '=']).map(str::to_owned).collect();
    for _ in 0..=random.below(3) {
        let at = random.below(words.len());
        match random.below(4) {
            0 => drop(words.remove(at)),
            1 => words[at] = WORDS[random.below(WORDS.len())].to_owned(),
            2 => words[at] += WORDS[random.below(WORDS.len())],
            _ => {
                let other = random.below(words.len());
                words.swap(at, other);
            }
        }
    }
    words.concat()
}

#[test]
fn no_mutation_of_a_model_panics() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/models/mjcf");
    let (cases, mut random) = Random::for_mutations(1000, 26);
    let (mut fine, mut refused) = (0, 0);
    for round in 0..cases {
        let (name, text) = MODELS[round % MODELS.len()];
        let text = mutated(&mut random, text);
        match import_text(&folder.join(name), text, &Options::default()) {
            Ok(imported) => {
                fine += 1;
                // What comes out is a scenario, or is refused as one.
                drop(parse("model.toml", &imported.scenario, &[]));
            }
            Err(problems) => {
                refused += 1;
                assert!(!problems.to_string().is_empty());
            }
        }
    }
    // Both ways are taken, or the mutations test nothing.
    assert!(fine > 20 && refused > 20, "{fine} {refused}");
}

#[test]
fn deep_nesting_is_refused() {
    let depth = 100_000;
    let model = format!(
        "<mujoco><worldbody>{}{}</worldbody></mujoco>",
        "<body><joint/><geom size=\"1\"/>".repeat(depth),
        "</body>".repeat(depth)
    );
    let refused = import(&model).expect_err("too deep").to_string();
    assert!(refused.contains("nested deeper than 200 levels"), "{}", &refused[..refused.len().min(300)]);
}

#[test]
fn nested_copies_do_not_grow_without_bounds() {
    let model = format!(
        "<mujoco><worldbody>{}<body><geom size=\"1\"/></body>{}</worldbody></mujoco>",
        "<replicate count=\"1000\">".repeat(5),
        "</replicate>".repeat(5)
    );
    let refused = import(&model).expect_err("too many").to_string();
    assert!(refused.contains("<replicate> and <attach> make more than 100000 elements"), "{refused}");
}

#[test]
fn files_that_include_each_other_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| fs::write(folder.path().join(name), text).expect("write");
    write("a.xml", "<mujoco>\n<include file=\"b.xml\"/></mujoco>");
    write("b.xml", "<mujoco>\n\n<include file=\"a.xml\"/></mujoco>");
    let path = folder.path().join("a.xml");
    let refused = stillpoint::import::import(&path, &Options::default()).expect_err("a circle").to_string();
    assert!(refused.contains("b.xml:3: ") && refused.contains("included already"), "{refused}");
    write("c.xml", "<mujoco>\n<include file=\"c2.xml\"/></mujoco>");
    let path = folder.path().join("c.xml");
    let refused = stillpoint::import::import(&path, &Options::default()).expect_err("no file").to_string();
    assert!(refused.contains("c.xml:2: ") && refused.contains("c2.xml"), "{refused}");
}

#[test]
fn numbers_that_overflow_are_said() {
    let model = "<mujoco><worldbody><body name=\"a\"><joint axis=\"0 1 0\"/>\n<geom type=\"box\" size=\"1e200 1e200 1\"/></body></worldbody></mujoco>";
    let refused = import(model).expect_err("too large").to_string();
    assert!(refused.contains("body `a`: its numbers grow beyond all that can be computed with"), "{refused}");
}
