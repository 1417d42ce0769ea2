//! What couples hinges beyond the tree: loops, drives, gears.

use super::super::fields::{Key, Kind, Range, Table};
use super::force::END;
use super::hinge::{ACROSS, ALONG, PITCH};
use super::{NUMBER, POSITIVE, VECTOR};
use crate::hinge::{DECLARED, Which, count, names};

/// `[[loop]]`
pub const LOOP: Table = Table {
    name: "loop",
    doc: "Closes a kinematic loop: a hinge or a rigid rod between two points that hang together through the tree. \
          Its frame is carried by the first end: the axes of the first body, turned by `rpy`. On the second body it is \
          the frame that coincides with this one in the positions as given, or what `rpy_second` says.",
    types: &CLOSURES,
    keys: &[
        Key::new("name", Kind::Text, "Unique name; `loop[i]` with its place in the file, from 0, where left out.")
            .example("\"coupler-ground\""),
        Key::new("between", Kind::List(&END, &[2]), "Its two ends, on different bodies.")
            .required()
            .example("[\"coupler.tip\", { body = \"ground\", at = [0.4, 0.0, 0.0] }]"),
        Key::new("axis", VECTOR, "Axis in the loop's frame, of any length but zero.")
            .required()
            .only(&ALONG)
            .example("[0.0, 1.0, 0.0]"),
        Key::new("axes", Kind::List(&VECTOR, &[2]), "Both axes in the loop's frame, not parallel.")
            .required()
            .only(&ACROSS)
            .example("[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]"),
        PITCH,
        Key::new("rpy", VECTOR, "Turn of the loop's frame in the first body: roll, pitch, yaw as in URDF.")
            .unit("rad")
            .default("[0.0, 0.0, 0.0]")
            .only(&FRAMED)
            .example("[0.0, 0.0, 1.5708]"),
        Key::new(
            "rpy_second",
            VECTOR,
            "Turn of the loop's frame in the second body; where it is left out, the frames coincide in the positions as given.",
        )
        .unit("rad")
        .only(&FRAMED)
        .example("[0.0, 0.0, 0.0]"),
        Key::new("length", POSITIVE, "Length of the rod.").unit("m").required().only(&["rod"]).example("0.5"),
    ],
};

/// The hinges that close loops, and the rod.
const CLOSURES: [(&str, &str); FRAMED.len() + 1] = {
    let rod = ("rod", "A rigid rod without mass: the two points keep the distance `length`.");
    let (mut closures, mut found, mut at) = ([rod; FRAMED.len() + 1], 0, 0);
    while at < DECLARED.len() {
        if let Some(doc) = DECLARED[at].closes {
            closures[found] = (DECLARED[at].name, doc);
            found += 1;
        }
        at += 1;
    }
    closures
};

const FRAMED: [&str; count(Which::Closing)] = names(Which::Closing);

/// Motions of drives and of motors' targets, and their keys.
pub(super) const MOTIONS: &[(&str, &str)] = &[
    ("hold", "Stays where it is given."),
    ("rate", "At a constant rate from the given position."),
    ("ramp", "Smoothly from the given position to `to`, at rest before and after."),
    ("sine", "offset + amplitude sin(2π frequency t + phase)."),
    ("table", "A cubic spline through points, at rest before the first and after the last."),
    ("expression", "A formula in the time `t`."),
];

pub(super) const RATE: Key =
    Key::new("rate", NUMBER, "Rate.").unit("m/s or rad/s").required().only(&["rate"]).example("6.28");
pub(super) const TO: Key =
    Key::new("to", NUMBER, "Where it ends.").unit("m or rad").required().only(&["ramp"]).example("0.5");
pub(super) const BEGIN: Key =
    Key::new("begin", NUMBER, "When it begins.").unit("s").default("0.0").only(&["ramp"]).example("1.0");
pub(super) const DURATION: Key =
    Key::new("duration", POSITIVE, "How long it takes.").unit("s").required().only(&["ramp"]).example("2.0");
pub(super) const AMPLITUDE: Key =
    Key::new("amplitude", NUMBER, "Amplitude.").unit("m or rad").required().only(&["sine"]).example("0.1");
pub(super) const FREQUENCY: Key =
    Key::new("frequency", NUMBER, "Frequency.").unit("Hz").required().only(&["sine"]).example("2.0");
pub(super) const PHASE: Key =
    Key::new("phase", NUMBER, "Phase at t = 0.").unit("rad").default("0.0").only(&["sine"]).example("1.5708");
pub(super) const OFFSET: Key = Key::new("offset", NUMBER, "Mean; the given position where it is left out.")
    .unit("m or rad")
    .only(&["sine"])
    .example("0.0");
pub(super) const TIMES: Key = Key::new("times", Kind::List(&NUMBER, &[]), "Times of the points, increasing.")
    .unit("s")
    .required()
    .only(&["table"])
    .example("[0.0, 1.0, 2.0]");
pub(super) const VALUES: Key =
    Key::new("values", Kind::List(&NUMBER, &[]), "Positions at the points, as many as times.")
        .unit("m or rad")
        .required()
        .only(&["table"])
        .example("[0.0, 0.3, 0.0]");
pub(super) const EXPRESSION: Key = Key::new(
    "expression",
    Kind::Text,
    "Position [m or rad] as a formula in `t` [s], with the operators and functions of Python.",
)
.required()
.only(&["expression"])
.example("\"0.1*sin(2*pi*t)\"");

/// `[[drive]]`
pub const DRIVE: Table = Table {
    name: "drive",
    doc: "A hinge coordinate that follows a given motion, whatever force that takes; the force is reported.",
    types: MOTIONS,
    keys: &[
        Key::new("name", Kind::Text, "Unique name; `drive[i]` with its place in the file, from 0, where left out.")
            .example("\"motor\""),
        Key::new("hinge", Kind::Text, "The body whose hinge is driven.").required().example("\"crank\""),
        Key::new(
            "coordinate",
            Kind::Integer(Range::AtLeast(0.0)),
            "Which of the hinge's angles and distances, from 0.",
        )
        .default("0")
        .example("0"),
        RATE,
        TO,
        BEGIN,
        DURATION,
        AMPLITUDE,
        FREQUENCY,
        PHASE,
        OFFSET,
        TIMES,
        VALUES,
        EXPRESSION,
    ],
};

/// `[[gear]]`
pub const GEAR: Table = Table {
    name: "gear",
    doc: "A fixed ratio between two hinge coordinates, engaged in the positions as given, or with `offset` where that says.",
    types: &[
        ("ratio", "The first moves `ratio` times as far as the second; both turn or both slide."),
        ("rack", "A rack (first, slides) on a pinion (second, turns): `radius` times the angle."),
        ("screw", "A nut (first, slides) on a screw (second, turns): `lead` per full turn."),
    ],
    keys: &[
        Key::new("name", Kind::Text, "Unique name; `gear[i]` with its place in the file, from 0, where left out.")
            .example("\"reduction\""),
        Key::new("between", Kind::List(&COORDINATE, &[2]), "The two coordinates.")
            .required()
            .example("[\"wheel\", \"pinion\"]"),
        Key::new("ratio", NUMBER, "How far the first moves while the second moves by 1; negative for the other way.")
            .required()
            .only(&["ratio"])
            .example("-0.25"),
        Key::new("radius", NUMBER, "Radius of the pinion.").unit("m").required().only(&["rack"]).example("0.05"),
        Key::new("lead", NUMBER, "Way per full turn.").unit("m").required().only(&["screw"]).example("0.002"),
        Key::new(
            "offset",
            NUMBER,
            "The first where the second is zero. A first coordinate whose `position` is not given then starts where the gear has it.",
        )
        .unit("m or rad")
        .example("0.0"),
    ],
};

const COORDINATE: Kind = Kind::Either(&[Kind::Text, Kind::Table(&HINGE_COORDINATE)]);

/// A coordinate of a hinge.
pub const HINGE_COORDINATE: Table = Table {
    name: "coordinate",
    doc: "One coordinate of a body's hinge; a body's name alone means its first.",
    types: &[],
    keys: &[
        Key::new("hinge", Kind::Text, "The body whose hinge it is.").required().example("\"nut\""),
        Key::new(
            "coordinate",
            Kind::Integer(Range::AtLeast(0.0)),
            "Which of the hinge's angles and distances, from 0.",
        )
        .default("0")
        .example("1"),
    ],
};
