//! What a run takes note of.

use super::super::fields::{ANY_UNIT, Key, Kind, Range, Table};
use super::{ATTACHMENT, NUMBER, VECTOR};

/// `[[event]]`
pub const EVENT: Table = Table {
    name: "event",
    doc: "A hinge coordinate, a point or an output that crosses a value; its time is found to twelve digits.",
    types: &[],
    keys: &[
        Key::new("name", Kind::Text, "Unique name; `event[i]` with its place in the file, from 0, where left out.")
            .example("\"lowest point\""),
        Key::new("hinge", Kind::Text, "Body whose hinge coordinate is watched.").example("\"arm\""),
        Key::new("coordinate", Kind::Integer(Range::AtLeast(0.0)), "Which of the hinge's coordinates, from 0.")
            .default("0")
            .example("0"),
        Key::new(
            "on",
            Kind::Either(&[Kind::Text, Kind::Table(&ATTACHMENT)]),
            "Point that is watched, in place of `hinge`.",
        )
        .example("\"arm.tip\""),
        Key::new("axis", VECTOR, "Direction along which the point is measured from the origin, inertial axes.")
            .default("[0.0, 0.0, 1.0]")
            .example("[0.0, 0.0, 1.0]"),
        Key::new(
            "output",
            Kind::Text,
            "Output that is watched, in place of `hinge`: its name, or `name[i]` for one of several numbers.",
        )
        .example("\"camber\""),
        Key::new("value", NUMBER, "The value that is crossed.").unit(ANY_UNIT).default("0.0").example("0.5"),
        Key::new("direction", Kind::Choice(DIRECTIONS), "Which way counts.").default("\"both\"").example("\"up\""),
        Key::new("action", Kind::Choice(ACTIONS), "What happens then.").default("\"log\"").example("\"stop\""),
    ],
};

const DIRECTIONS: &[(&str, &str)] =
    &[("both", "Either way."), ("up", "From below to above."), ("down", "From above to below.")];

const ACTIONS: &[(&str, &str)] = &[("log", "It is noted."), ("stop", "The run ends.")];
