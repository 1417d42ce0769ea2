//! The scenario format, declared: every table, key, unit, range, default and sentence, said once.

mod beam;
mod body;
mod contact;
mod controller;
mod couplings;
mod event;
mod force;
mod hinge;
mod model;
mod motor;
mod output;
mod settings;
mod stage;
mod start;

pub use beam::{BEAM, BEAM_CURVE, CABLE, LINE_LOAD, MATERIAL, SECTION};
pub use body::{BODY, ROUND, SHAPE};
pub use contact::{CONTACT, FRICTION};
pub use controller::CONTROLLER;
pub use couplings::{DRIVE, GEAR, HINGE_COORDINATE, LOOP};
pub use event::EVENT;
pub use force::{BUSHING_VALUES, CURVE_VALUES, FORCE};
pub use hinge::{HINGE, HINGE_CURVE, LIMIT};
pub use model::{MODEL, MODEL_HINGE};
pub use motor::{MOTOR, TARGET};
pub use output::{COMPONENTS, DIRECTION, OUTPUT, SECTIONS};
pub use settings::{PATH, RECORD, SIMULATE, STATICS};
pub use stage::{STAGE, WHEN};
pub use start::START;

use super::fields::{ANY_UNIT, Key, Kind, Range, Table};

/// The most bodies a scenario may have, copies counted.
pub const MOST_BODIES: usize = crate::budget::BODIES;

const NUMBER: Kind = Kind::Number(Range::Any);
const NOT_NEGATIVE: Kind = Kind::Number(Range::AtLeast(0.0));
const POSITIVE: Kind = Kind::Number(Range::Above(0.0));
/// Three numbers.
const VECTOR: Kind = Kind::List(&NUMBER, &[3]);

/// Coordinates or a marker's name.
const POINT: Kind = Kind::Either(&[VECTOR, Kind::Text]);

/// `{ body = …, at = … }`
pub const ATTACHMENT: Table = Table {
    name: "attachment",
    doc: "A point on a body; `\"body.marker\"` says the same of a marker and `\"body\"` of the root marker.",
    types: &[],
    keys: &[
        Key::new("body", Kind::Text, "Name of the body, or \"ground\".").required().example("\"ground\""),
        Key::new("at", VECTOR, "Coordinates from the root marker, body axes.")
            .unit("m")
            .default("[0.0, 0.0, 0.0]")
            .example("[1.0, 0.0, 0.5]"),
        Key::new("marker", Kind::Text, "A marker's name, in place of `at`.").example("\"tip\""),
    ],
};

/// A whole file.
pub const SCENARIO: Table = Table {
    name: "scenario",
    doc: "A scene of rigid bodies on hinges, what pushes them, and what is asked. SI units and radians.",
    types: &[],
    keys: &[
        Key::new("title", Kind::Text, "One line for people.").example("\"Two links from a bracket\""),
        Key::new("gravity", VECTOR, "Gravitational acceleration, inertial axes.")
            .unit("m/s²")
            .default("[0.0, 0.0, -9.80665]")
            .example("[0.0, 0.0, -9.80665]"),
        Key::new(
            "parameters",
            Kind::Map(&NUMBER),
            "Numbers with names, for formulas and, in braces, for every number of the file: `mass = \"2*{m}\"`.",
        )
        .unit(ANY_UNIT)
        .example("{ m = 2.5 }"),
        Key::new("simulate", Kind::Table(&SIMULATE), "The run.").example("{ duration = 10.0 }"),
        Key::new("statics", Kind::Table(&STATICS), "The equilibrium.").example("{ want = \"stable\" }"),
        Key::new("record", Kind::Table(&RECORD), "The recording.").example("{ rate = 100.0 }"),
        Key::new(
            "model",
            Kind::Either(&[Kind::Text, Kind::Table(&MODEL), Kind::List(&Kind::Table(&MODEL), &[])]),
            "A model of another program (URDF or MJCF): its file, or how it is taken; or several.",
        )
        .example("\"robots/arm.urdf\""),
        Key::new(
            "body",
            Kind::List(&Kind::Table(&BODY), &[]),
            "The bodies, in any order; without a `model` or a `beam` at least one.",
        ),
        Key::new("beam", Kind::List(&Kind::Table(&BEAM), &[]), "Flexible beams, in any order."),
        Key::new("cable", Kind::List(&Kind::Table(&CABLE), &[]), "Cables between two points, in any order."),
        Key::new(
            "force",
            Kind::List(&Kind::Table(&FORCE), &[]),
            "Springs, bushings, ropes, curves, sliders and loads.",
        ),
        Key::new("contact", Kind::List(&Kind::Table(&CONTACT), &[]), "What cannot pass through what."),
        Key::new("event", Kind::List(&Kind::Table(&EVENT), &[]), "What a run takes note of, or ends with."),
        Key::new("stage", Kind::List(&Kind::Table(&STAGE), &[]), "Changes of structure in a run."),
        Key::new("loop", Kind::List(&Kind::Table(&LOOP), &[]), "What closes kinematic loops."),
        Key::new("drive", Kind::List(&Kind::Table(&DRIVE), &[]), "Coordinates with a given motion."),
        Key::new("gear", Kind::List(&Kind::Table(&GEAR), &[]), "Coordinates in a fixed ratio."),
        Key::new("motor", Kind::List(&Kind::Table(&MOTOR), &[]), "Forces in coordinates that follow a law."),
        Key::new(
            "controller",
            Kind::List(&Kind::Table(&CONTROLLER), &[]),
            "What reads outputs and sets motors of type `input` at the instants of a period.",
        ),
        Key::new("output", Kind::List(&Kind::Table(&OUTPUT), &[]), "Numbers that are asked of the scene."),
    ],
};
