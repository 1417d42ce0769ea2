//! Motors: forces in hinge coordinates that follow a law.

use super::super::fields::{Key, Kind, Range, Table};
use super::couplings::{
    AMPLITUDE, BEGIN, DURATION, EXPRESSION, FREQUENCY, MOTIONS, OFFSET, PHASE, RATE, TIMES, TO, VALUES,
};
use super::{NOT_NEGATIVE, NUMBER, POSITIVE};

/// `[[motor]]`
pub const MOTOR: Table = Table {
    name: "motor",
    doc: "A force or torque in a hinge coordinate that follows a law; what it puts in is work in the energy ledger.",
    types: &[
        ("constant", "Always the same `force`."),
        ("table", "Straight lines through points over time or speed, constant outside."),
        ("pd", "Towards a target s: stiffness (s − q) + damping (ṡ − q̇) + force."),
        ("expression", "A formula in the time `t`, the coordinate `q` and its rate `v`."),
        ("input", "A number from outside: of a `[[controller]]`, of a program, or an input of `linearize`."),
    ],
    keys: &[
        Key::new("name", Kind::Text, "Unique name; `motor[i]` with its place in the file, from 0, where left out.")
            .example("\"shoulder motor\""),
        Key::new("hinge", Kind::Text, "The body whose hinge it acts in.").required().example("\"upper_arm\""),
        Key::new("coordinate", Kind::Integer(Range::AtLeast(0.0)), "Which of the hinge's angles and distances, from 0.")
            .default("0")
            .example("0"),
        Key::new("force", NUMBER, "Force or torque.").unit("N or N m").required().only(&["constant"]).example("12.0"),
        Key::new(
            "over",
            Kind::Choice(&[("time", "Over the time [s]."), ("speed", "Over the coordinate's rate [m/s or rad/s].")]),
            "What the table is looked up by.",
        )
        .required()
        .only(&["table"])
        .example("\"speed\""),
        Key::new("at", Kind::List(&NUMBER, &[]), "Times or rates of the points, increasing.")
            .unit("s or m/s or rad/s")
            .required()
            .only(&["table"])
            .example("[0.0, 150.0]"),
        Key::new("forces", Kind::List(&NUMBER, &[]), "Forces at the points, as many.")
            .unit("N or N m")
            .required()
            .only(&["table"])
            .example("[2.5, 0.0]"),
        Key::new(
            "target",
            Kind::Either(&[NUMBER, Kind::Table(&TARGET)]),
            "Where the coordinate is wanted: a value, or a motion as drives have it; the given position where left out.",
        )
        .unit("m or rad")
        .only(&["pd"])
        .example("{ type = \"ramp\", to = 1.2, duration = 2.0 }"),
        Key::new("stiffness", NOT_NEGATIVE, "Gain on the distance to the target.")
            .unit("N/m or N m/rad")
            .default("0.0")
            .only(&["pd"])
            .example("400.0"),
        Key::new("damping", NOT_NEGATIVE, "Gain on the difference of the rates.")
            .unit("N s/m or N m s/rad")
            .default("0.0")
            .only(&["pd"])
            .example("20.0"),
        Key::new(
            "force",
            NUMBER,
            "What it pushes with until a number comes, and in statics; the `bias` of its controller where left out, zero without one.",
        )
        .unit("N or N m")
        .only(&["input"])
        .example("2.0"),
        Key::new("force", NUMBER, "Added to it.").unit("N or N m").default("0.0").only(&["pd"]).example("5.0"),
        Key::new(
            "expression",
            Kind::Text,
            "Force as a formula in `t` [s], `q` [m or rad] and `v` [m/s or rad/s], with the operators and functions of Python.",
        )
        .unit("N or N m")
        .required()
        .only(&["expression"])
        .example("\"-20*q - 2*v\""),
        Key::new("limit", POSITIVE, "It never pushes with more, either way.").unit("N or N m").example("80.0"),
    ],
};

/// `target = { … }`
pub const TARGET: Table = Table {
    name: "target",
    doc: "A motion of the coordinate that a motor follows.",
    types: MOTIONS,
    keys: &[RATE, TO, BEGIN, DURATION, AMPLITUDE, FREQUENCY, PHASE, OFFSET, TIMES, VALUES, EXPRESSION],
};
