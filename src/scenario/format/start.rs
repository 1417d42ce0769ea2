//! Start files: where a run begins, by name.

use super::super::fields::{Key, Kind, Range, Table};
use super::{NOT_NEGATIVE, NUMBER, POSITIVE};

const LISTS: Kind = Kind::Map(&Kind::List(&NUMBER, &[]));

/// A whole start file.
pub const START: Table = Table {
    name: "start",
    doc: "Where a run begins: the coordinates of every hinge, and inputs that hold it there. SI units and radians.",
    types: &[],
    keys: &[
        Key::new("title", Kind::Text, "One line for people: the scene it belongs to.").example("\"A crane\""),
        Key::new("time", NOT_NEGATIVE, "When: of the end of a run that goes on; 0 where left out.")
            .unit("s")
            .example("2.5"),
        Key::new("integrator", Kind::Table(&INTEGRATOR), "What the method goes on with.")
            .example("{ method = \"rk4\" }"),
        Key::new("mode", Kind::List(&NUMBER, &[]), "What stops, dry friction and contacts did at the end of a run that goes on, as it wrote that; decided anew where left out.")
            .example("[1.0, 0.0, 0.0, 0.0, 0.0]"),
        Key::new("positions", LISTS, "Coordinates of every hinge, by the body it carries.")
            .required()
            .example("{ upper = [0.3] }"),
        Key::new("velocities", LISTS, "Velocities of hinges; zero where left out.").example("{ upper = [0.0] }"),
        Key::new("strains", LISTS, "The coordinates of the elements of every beam, from its root to its tip.")
            .example("{ jib = [0.001, 0.0, 0.0005, 0.0] }"),
        Key::new("strain_rates", LISTS, "Their rates; zero where left out.").example("{ jib = [0.0, 0.0, 0.0, 0.0] }"),
        Key::new("inputs", Kind::Map(&NUMBER), "Numbers of the scene that the start needs, by address.")
            .example("{ \"upper.force\" = 12.5 }"),
        Key::new("controllers", LISTS, "What controllers remember, by their names: of the end of a run that goes on.")
            .example("{ height = [0.3, -0.01, 1.0] }"),
        Key::new("multipliers", LISTS, "What loops, drives and gears push there, row by row: checked, not used.")
            .example("{ \"drive engine\" = [12.5] }"),
    ],
};

/// `[integrator]` of a start file.
const INTEGRATOR: Table = Table {
    name: "integrator",
    doc: "What a method goes on with where a run ended.",
    types: &[],
    keys: &[
        Key::new("method", Kind::Text, "Its name.").required().example("\"rk4\""),
        Key::new("step", POSITIVE, "The next step.").unit("s").example("1e-3"),
        Key::new("origin", NUMBER, "The time from which fixed steps are counted.").unit("s").example("0.0"),
        Key::new("steps", Kind::Integer(Range::AtLeast(0.0)), "How many of them were made.").example("2500"),
    ],
};
