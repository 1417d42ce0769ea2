//! Small faults of XML are read over, with a word about them.

use super::fixture::{import, notes, refused};
use crate::common::Random;
use stillpoint::import::Options;

const ROBOT: &str = include_str!("../../../scenarios/robots/arm.urdf");

/// Prefixes that nobody declares, in tags and in attributes, and declarations between the elements.
#[test]
fn undeclared_prefixes_and_further_declarations_change_nothing() {
    let mut random = Random::new(51);
    let plain = import(ROBOT, &Options::default());
    let ends: Vec<usize> =
        ROBOT.match_indices("<link").chain(ROBOT.match_indices("<joint")).map(|(at, _)| at).collect();
    let pieces = [
        "<controller:gains p:kp=\"1\" kd='2 > 1'><sensor:a/></controller:gains>\n",
        "<gazebo:plugin name=\"p:q r:s\">t:u</gazebo:plugin>\n",
        "<?xml version=\"1.0\"?>\n",
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n",
        "<!-- a:b <c:d/> --><e:f/>\n",
    ];
    for _ in 0..60 {
        let (at, piece) = (ends[random.below(ends.len())], pieces[random.below(pieces.len())]);
        let text = format!("{}{piece}{}", &ROBOT[..at], &ROBOT[at..]);
        let found = import(&text, &Options::default());
        assert_eq!(found.scenario, plain.scenario, "{piece}");
        let line = 1 + text[..at].matches('\n').count();
        let said = notes(&found);
        let mended: Vec<&str> = said.lines().filter(|note| note.contains("approximated: `")).collect();
        assert!(!mended.is_empty(), "{said}");
        assert!(mended.iter().all(|note| note.starts_with(&format!("{line}: "))), "line {line}: {mended:?}");
    }
}

#[test]
fn a_macro_is_none_of_them() {
    let text = "<robot name=\"a\"><xacro:include filename=\"b\"/></robot>";
    let said = refused(text);
    assert!(said.contains("unknown namespace prefix 'xacro'") && said.contains("expand it first"), "{said}");
}
