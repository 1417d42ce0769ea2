//! Changes of structure in a run.

use super::super::fields::{Key, Kind, Table};
use super::NOT_NEGATIVE;

/// When a stage comes.
pub const WHEN: Table = Table {
    name: "when",
    doc: "When a stage comes: at a time, or at the first crossing of an event.",
    types: &[],
    keys: &[
        Key::new("time", NOT_NEGATIVE, "Time.").unit("s").example("1.5"),
        Key::new("event", Kind::Text, "Name of an `[[event]]`, in place of `time`.").example("\"touchdown\""),
    ],
};

const NAMES: Kind = Kind::List(&Kind::Text, &[]);

/// `[[stage]]`
pub const STAGE: Table = Table {
    name: "stage",
    doc: "A change of structure in a run. What `open` or `release` names first is closed from the beginning; what `close` or \
          `lock` names first is open until then. What comes together exchanges momentum in an impact without rebound.",
    types: &[],
    keys: &[
        Key::new("name", Kind::Text, "Unique name; `stage[i]` with its place in the file, from 0, where left out.")
            .example("\"ignition\""),
        Key::new("when", Kind::Table(&WHEN), "When it comes.").required().example("{ time = 1.5 }"),
        Key::new(
            "open",
            NAMES,
            "Hinges (by their bodies), loops, contacts, drives, gears and motors that go. The body of a hinge that opens is \
             free from then on; what acted in the hinge goes with it.",
        )
        .example("[\"latch\"]"),
        Key::new("close", NAMES, "Loops, contacts, drives, gears and motors that come.").example("[\"port\"]"),
        Key::new("lock", NAMES, "Hinges that are held where they are from then on; of anything else the same as `close`.")
            .example("[\"boom\"]"),
        Key::new("outputs", NAMES, "Outputs that are told with it, as they are before it.")
            .example("[\"elevation\", \"pitch_rate\"]"),
        Key::new("release", NAMES, "Locked hinges that are let go; of anything else the same as `open`.")
            .example("[\"panel\"]"),
    ],
};
