//! Scenario files.

use super::{each, edits};
use crate::scenarios::file;
use proptest::prelude::*;
use stillpoint::scenario::{self, Override};

/// What a TOML file and our format are made of.
const WORDS: &[&[u8]] = &[
    b"[",
    b"]",
    b"{",
    b"}",
    b"[[",
    b"]]",
    b"=",
    b"\"",
    b"'''",
    b"\"\"\"",
    b"#",
    b"\n",
    b"\r\n",
    b",",
    b".",
    b"-",
    b"\\",
    b"\0",
    b"\xEF\xBB\xBF",
    b"\xC3",
    b"nan",
    b"inf",
    b"-inf",
    b"1e308",
    b"-1e308",
    b"5e-324",
    b"0.0",
    b"-0.0",
    b"0",
    b"1",
    b"-1",
    b"true",
    b"1979-05-27",
    b"9223372036854775807",
    b"[[body]]\n",
    b"[[force]]\n",
    b"[[loop]]\n",
    b"[[drive]]\n",
    b"[[gear]]\n",
    b"[[event]]\n",
    b"name",
    b"repeat = 3\n",
    b"mass = ",
    b"density = ",
    b"inertia = ",
    b"hinge = ",
    b"parent = ",
    b"at = ",
    b"type = ",
    b"\"free\"",
    b"\"spherical\"",
    b"\"universal\"",
    b"\"planar\"",
    b"\"fixed\"",
    b"\"ground\"",
    b"\"rod\"",
    b"between = ",
    b"position = ",
    b"limits = ",
    b"expression = \"sin(t)^",
    b"[0.0, 0.0, 0.0]",
    b"[0, 0, 0, 0]",
    b"[[[[[[[[",
];

/// The shipped scenarios, but for those whose chains would make every case slow.
fn shipped() -> Vec<String> {
    let folder = file("pendulum").parent().expect("the folder").to_owned();
    let mut paths: Vec<_> =
        std::fs::read_dir(folder).expect("listed").map(|entry| entry.expect("an entry").path()).collect();
    paths.sort();
    let texts = paths.iter().filter(|path| path.extension().is_some_and(|e| e == "toml"));
    let texts: Vec<String> = texts.map(|path| std::fs::read_to_string(path).expect("a text")).collect();
    assert!(texts.len() > 20, "{} scenarios", texts.len());
    texts
}

/// A repeat of a million bodies is allowed, and takes its time.
fn is_small(text: &str) -> bool {
    let counts = text.split("repeat").skip(1).map(|rest| {
        let digits = rest
            .trim_start_matches([' ', '=', '"', '\''])
            .chars()
            .take_while(|c| c.is_ascii_alphanumeric() || *c == '_');
        digits.count()
    });
    counts.max().unwrap_or(0) <= 2
}

#[test]
fn a_damaged_scenario_is_an_error_with_a_place_or_a_scenario() {
    let strategy = (proptest::sample::select(shipped()), edits(200, WORDS));
    each(1000, strategy, |(text, edits)| {
        let mut bytes = text.into_bytes();
        edits.iter().for_each(|edit| edit.apply(&mut bytes));
        let text = String::from_utf8_lossy(&bytes);
        prop_assume!(is_small(&text));
        match scenario::parse("scene.toml", &text, &[]) {
            Ok(scenario) => prop_assert!(scenario.description.bodies.iter().all(|body| body.mass.mass.is_finite())),
            Err(problems) => {
                prop_assert!(problems.errors() > 0);
                let said = problems.render(false);
                prop_assert!(said.contains("error") && !said.contains('\0'), "{said}");
                prop_assert!(said.len() < 200_000, "{} bytes of messages", said.len());
            }
        }
        Ok(())
    });
}

#[test]
fn any_text_is_an_answer() {
    each(1000, ".{0,200}", |text| {
        if let Err(problems) = scenario::parse("scene.toml", &text, &[]) {
            prop_assert!(!problems.render(true).is_empty());
        }
        Ok(())
    });
}

#[test]
fn any_override_is_an_answer() {
    let text = std::fs::read_to_string(file("four_bar")).expect("a scenario");
    let word = proptest::sample::select(vec![
        "crank",
        "coupler-rocker",
        "hinge",
        "simulate",
        "statics",
        "record",
        "gravity",
        "title",
        "body",
        "mass",
        "position",
        "duration",
        "markers",
        "pin",
        "between",
        "axis",
        "[0]",
        "",
        "type",
        "inertia",
        "rate",
    ]);
    let value = prop_oneof![
        any::<f64>().prop_map(|x| format!("{x:?}")),
        any::<i64>().prop_map(|x| x.to_string()),
        proptest::sample::select(vec!["nan", "[1,2,3]", "{}", "{a=1}", "\"x", "[", "", "true", "given", "0.5"])
            .prop_map(str::to_owned),
        ".{0,12}",
    ];
    each(1000, (proptest::collection::vec(word, 1..4), value), |(path, value)| {
        let Ok(change) = Override::parse(&format!("{}={value}", path.join("."))) else { return Ok(()) };
        if let Err(problems) = scenario::parse("four_bar.toml", &text, &[change]) {
            prop_assert!(problems.errors() > 0 && problems.render(false).contains("error"));
        }
        Ok(())
    });
}
