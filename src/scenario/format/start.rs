//! Start files: where a run begins, by name.

use super::super::fields::{Key, Kind, Table};
use super::NUMBER;

const LISTS: Kind = Kind::Map(&Kind::List(&NUMBER, &[]));

/// A whole start file.
pub const START: Table = Table {
    name: "start",
    doc: "Where a run begins: the coordinates of every hinge, and inputs that hold it there. SI units and radians.",
    types: &[],
    keys: &[
        Key::new("title", Kind::Text, "One line for people: the scene it belongs to.").example("\"A crane\""),
        Key::new("positions", LISTS, "Coordinates of every hinge, by the body it carries.")
            .required()
            .example("{ upper = [0.3] }"),
        Key::new("velocities", LISTS, "Velocities of hinges; zero where left out.").example("{ upper = [0.0] }"),
        Key::new("inputs", Kind::Map(&NUMBER), "Numbers of the scene that the start needs, by address.")
            .example("{ \"upper.force\" = 12.5 }"),
        Key::new("multipliers", LISTS, "What loops, drives and gears push there, row by row: checked, not used.")
            .example("{ \"drive engine\" = [12.5] }"),
    ],
};
