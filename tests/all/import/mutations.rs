//! Damaged files are answered, never with a panic: cut, doubled, swapped and replaced pieces of a robot.

use crate::common::Random;
use std::path::Path;
use stillpoint::import::Options;
use stillpoint::scenario::convert_text;

const ROBOTS: [&str; 2] =
    [include_str!("../../../scenarios/robots/arm.urdf"), include_str!("../../../scenarios/robots/gripper.urdf")];
const PIECES: [&str; 24] = [
    "",
    "<",
    ">",
    "/>",
    "\"",
    "&",
    "&lt;",
    "<!--",
    "]]>",
    "\0",
    "µ",
    "nan",
    "inf",
    "-1",
    "1e999",
    "0 0",
    "<link/>",
    "<joint name=\"j\"/>",
    "<mimic joint=\"elbow\"/>",
    "<inertial/>",
    "type=\"planar\"",
    "type=\"floating\"",
    "<!DOCTYPE a [<!ENTITY b \"c\">]>",
    "xmlns:a=\"b\"",
];

fn answered(text: String) {
    for floating in [false, true] {
        let options = Options { floating, ..Options::default() };
        match convert_text(Path::new("robot.urdf"), text.clone(), &options) {
            Ok(imported) => assert!(!imported.scenario.is_empty()),
            Err(error) => assert!(!error.to_string().is_empty()),
        }
    }
}

#[test]
fn damaged_robots_are_answered() {
    let (cases, mut random) = Random::for_mutations(1000, 11);
    for case in 0..cases {
        let mut text = ROBOTS[case % 2].to_owned();
        for _ in 0..1 + random.below(3) {
            let boundary = |text: &str, mut at: usize| {
                while !text.is_char_boundary(at) {
                    at -= 1;
                }
                at
            };
            let from = boundary(&text, random.below(text.len() + 1));
            let to = boundary(&text, (from + random.below(40)).min(text.len()).max(from));
            match random.below(4) {
                0 => text.replace_range(from..to, PIECES[random.below(PIECES.len())]),
                1 => text.insert_str(from, PIECES[random.below(PIECES.len())]),
                2 => text.truncate(from),
                _ => {
                    let piece = text[from..to].to_owned();
                    let at = boundary(&text, random.below(text.len() + 1));
                    text.insert_str(at, &piece);
                }
            }
        }
        answered(text);
    }
}

/// A word of the file for another one: names, numbers and types that do not belong there.
#[test]
fn swapped_words_are_answered() {
    let (cases, mut random) = Random::for_mutations(1000, 12);
    for case in 0..cases {
        let text = ROBOTS[case % 2];
        let mut words: Vec<&str> = text.split('"').collect();
        let count = words.len();
        for _ in 0..1 + random.below(4) {
            // Odd pieces stand between quotes.
            let (a, b) = (2 * random.below(count / 2) + 1, 2 * random.below(count / 2) + 1);
            words.swap(a, b);
        }
        answered(words.join("\""));
    }
}

#[test]
fn what_is_nested_deeply_or_long_is_answered() {
    answered(format!("<robot>{}{}</robot>", "<a>".repeat(100_000), "</a>".repeat(100_000)));
    answered(format!("<robot>{}", "<a>".repeat(100_000)));
    let entities: String =
        (0..9).map(|i| format!("<!ENTITY e{} \"{}\">", i + 1, format!("&e{i};").repeat(10))).collect();
    answered(format!("<!DOCTYPE robot [<!ENTITY e0 \"ha\">{entities}]><robot name=\"&e9;\"/>"));
    // Each link hangs on the one before it.
    let links: String = (0..3_000)
        .map(|i| {
            let parent = format!("l{}", i);
            format!(
                "<link name=\"l{0}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>\
                 </inertial></link><joint name=\"j{0}\" type=\"continuous\"><parent link=\"{parent}\"/><child link=\"l{0}\"/></joint>",
                i + 1
            )
        })
        .collect();
    let text = format!("<robot name=\"chain\"><link name=\"l0\"/>{links}</robot>");
    let imported = convert_text(Path::new("chain.urdf"), text, &Options::default()).expect("a chain");
    assert_eq!(imported.joints.len(), 3_000);
}
