//! Controllers: what sets motors of type `input` while a run goes on.

use super::super::fields::{ANY_UNIT, Key, Kind, Table};
use super::{NUMBER, POSITIVE};

/// `[[controller]]`
pub const CONTROLLER: Table = Table {
    name: "controller",
    doc: "Reads outputs at the instants 0, T, 2 T … of its period and sets motors of type `input`, which hold their value until the next instant.",
    types: &[
        ("gain", "u = bias − matrix (y − setpoint)."),
        ("pid", "u = bias + proportional e + integral Σ T e + derivative (e − e before)/T, with e = setpoint − y."),
        ("expression", "A formula for each input, in the names of what is sensed and the time `t`."),
    ],
    keys: &[
        Key::new(
            "name",
            Kind::Text,
            "Unique name; `controller[i]` with its place in the file, from 0, where left out.",
        )
        .example("\"balance\""),
        Key::new("period", POSITIVE, "Time between its instants; steps end there.")
            .unit("s")
            .required()
            .example("0.01"),
        Key::new(
            "senses",
            TEXTS,
            "Outputs that it reads, by name; `tip` for all numbers of one, `tip[2]` for one of them.",
        )
        .required()
        .example("[\"x\", \"angle\", \"speed\", \"rate\"]"),
        Key::new("drives", TEXTS, "Motors of type `input` that it sets, by name.").required().example("\"push\""),
        Key::new(
            "matrix",
            Kind::List(&Kind::List(&NUMBER, &[]), &[]),
            "A row for each input, a column for each number that is sensed: units of what it drives over units of what it senses.",
        )
        .unit(ANY_UNIT)
        .required()
        .only(&["gain"])
        .example("[[-1.0, 30.0, -2.0, 6.0]]"),
        Key::new("setpoint", Kind::List(&NUMBER, &[]), "Where what is sensed is wanted; zeros where left out.")
            .unit(ANY_UNIT)
            .only(&["gain"])
            .example("[0.5, 0.0, 0.0, 0.0]"),
        Key::new(
            "bias",
            Kind::List(&NUMBER, &[]),
            "What the inputs are at the setpoint, and in statics; zeros where left out.",
        )
        .unit("N or N m")
        .only(&["gain"])
        .example("[0.0]"),
        Key::new("proportional", NUMBER, "Gain on the error e: unit of what it drives over that of what it senses.")
            .unit(ANY_UNIT)
            .default("0.0")
            .only(&["pid"])
            .example("800.0"),
        Key::new("integral", NUMBER, "Gain on the sum of T e: the same, by a second.")
            .unit(ANY_UNIT)
            .default("0.0")
            .only(&["pid"])
            .example("200.0"),
        Key::new("derivative", NUMBER, "Gain on the rate of the error, nothing at the first instant: the same, times a second.")
            .unit(ANY_UNIT)
            .default("0.0")
            .only(&["pid"])
            .example("60.0"),
        Key::new("setpoint", NUMBER, "Where what is sensed is wanted.")
            .unit(ANY_UNIT)
            .default("0.0")
            .only(&["pid"])
            .example("0.3"),
        Key::new("bias", NUMBER, "Added; what the input is in statics.")
            .unit("N or N m")
            .default("0.0")
            .only(&["pid"])
            .example("98.0665"),
        Key::new(
            "limit",
            POSITIVE,
            "The value is cut there, either way; the sum then does not grow further in that direction (no windup).",
        )
        .unit("N or N m")
        .only(&["pid"])
        .example("150.0"),
        Key::new("expression", TEXTS, "A formula for each input, with the operators and functions of Python.")
            .unit("N or N m")
            .required()
            .only(&["expression"])
            .example("\"if(angle > 0, 5, -5) - 2*rate\""),
    ],
};

const TEXTS: Kind = Kind::Either(&[Kind::Text, Kind::List(&Kind::Text, &[])]);
