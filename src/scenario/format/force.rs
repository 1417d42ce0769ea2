//! What pushes.

use super::super::fields::{Key, Kind, Table};
use super::{ATTACHMENT, NOT_NEGATIVE, NUMBER, POSITIVE, VECTOR};

/// `[[force]]`
pub const FORCE: Table = Table {
    name: "force",
    doc: "Something that pushes.",
    types: &[
        ("spring", "Along the line between two points: tension k (distance − length) + c d(distance)/dt."),
        (
            "bushing",
            "Six-degree spring and damper; without a preload relaxed where both points coincide and both bodies' axes are parallel.",
        ),
        (
            "rope",
            "Pulls and never pushes: tension max(0, k (path − length) + c d(path)/dt) along the path through its points.",
        ),
        (
            "curve",
            "A spring and damper by tables of points, along the line between two points; what is positive pulls them together.",
        ),
        (
            "slider",
            "Presses a point onto the axis of a beam or cable, along which it slides: a spring k and damper c across the axis, as far as the beam goes.",
        ),
        ("load", "A constant force and torque on a body."),
    ],
    keys: &[
        Key::new("name", Kind::Text, "Unique name; `force[i]` with its place in the file, from 0, where left out.")
            .example("\"stay\""),
        Key::new("between", Kind::List(&END, &[2]), "Its two ends.")
            .required()
            .only(LINKS)
            .example("[\"link[2].tip\", { body = \"ground\", at = [1.0, 0.0, 0.5] }]"),
        Key::new("through", Kind::List(&END, &[]), "Its points, two or more; it slides through the inner ones without friction.")
            .required()
            .only(&["rope"])
            .example("[\"link[0].tip\", { body = \"ground\", at = [0.0, 0.0, 1.0] }, \"link[1].tip\"]"),
        Key::new("on", END, "Where it acts; of a slider the point that slides.").required().only(&["load", "slider"]).example("\"link[2].tip\""),
        Key::new("stiffness", NOT_NEGATIVE, "Stiffness.").unit("N/m").default("0.0").only(&["spring"]).example("40.0"),
        Key::new("damping", NOT_NEGATIVE, "Damping.").unit("N s/m").default("0.0").only(&["spring", "rope", "slider"]).example("0.5"),
        Key::new("along", Kind::Text, "Name of the beam or cable.").required().only(&["slider"]).example("\"tube\""),
        Key::new("stiffness", POSITIVE, "Stiffness across the axis.").unit("N/m").required().only(&["slider"]).example("1e7"),
        Key::new("stiffness", POSITIVE, "Stiffness along the whole path.").unit("N/m").required().only(&["rope"]).example("4e4"),
        Key::new("length", POSITIVE, "Unstretched length of the whole path.").unit("m").required().only(&["rope"]).example("2.5"),
        Key::new("stiffness", SIX, "Stiffness along x, y, z [N/m], then about x, y, z [N m/rad], bushing axes.")
            .unit("N/m and N m/rad")
            .default("{ translation = 0.0, rotation = 0.0 }")
            .only(&["bushing"])
            .example("{ translation = 1000.0, rotation = [1.0, 1.0, 0.0] }"),
        Key::new("damping", SIX, "Damping along x, y, z [N s/m], then about x, y, z [N m s/rad], bushing axes.")
            .unit("N s/m and N m s/rad")
            .default("{ translation = 0.0, rotation = 0.0 }")
            .only(&["bushing"])
            .example("[1.0, 1.0, 1.0, 0.1, 0.1, 0.1]"),
        Key::new("preload", Kind::List(&NUMBER, &[6]), "What it pushes the second body with where both points coincide and both axes are parallel: along x, y, z [N], then about x, y, z [N m], bushing axes.")
            .unit("N and N m")
            .default("[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]")
            .only(&["bushing"])
            .example("[0.0, 0.0, 400.0, 0.0, 0.0, 0.0]"),
        Key::new("length", NOT_NEGATIVE, "Unstretched length; must be said where `stiffness` is not zero, and with a curve against the extension.")
            .unit("m")
            .only(&["spring", "curve"])
            .example("1.2"),
        Key::new("rpy", VECTOR, "Turn of the bushing's axes in the first body: roll, pitch, yaw as in URDF.")
            .unit("rad")
            .default("[0.0, 0.0, 0.0]")
            .only(&["bushing"])
            .example("[0.0, 0.0, 0.0]"),
        Key::new("force", VECTOR, "Force.")
            .unit("N")
            .default("[0.0, 0.0, 0.0]")
            .only(&["load"])
            .example("[0.0, 0.0, 1.0]"),
        Key::new("force", CURVE, "Pull by points `[extension, force]`, the extension beyond `length` increasing [m]; or `{ extension = …, rate = … }` with one table against the extension and one against its rate [m/s], which add.")
            .unit("N")
            .required()
            .only(&["curve"])
            .example("[[-0.05, -2000.0], [0.0, 0.0], [0.1, 1500.0]]"),
        Key::new("interpolation", Kind::Choice(INTERPOLATIONS), "Between the points; beyond its ends a curve goes on with its slope.")
            .default("\"smooth\"")
            .only(&["curve"])
            .example("\"linear\""),
        Key::new("torque", VECTOR, "Torque.")
            .unit("N m")
            .default("[0.0, 0.0, 0.0]")
            .only(&["load"])
            .example("[0.0, 0.0, 1.0]"),
        Key::new("axes", Kind::Choice(AXES), "The axes in which it is constant.")
            .default("\"inertial\"")
            .only(&["load"])
            .example("\"body\""),
        Key::new("over_time", Kind::Table(&OVER_TIME), "Scales force and torque over time.")
            .only(&["load"])
            .example("{ times = [0.0, 0.1, 2.0, 2.0], values = [0.0, 1.0, 1.0, 0.0] }"),
    ],
};

/// A factor by a table over time.
pub(super) const OVER_TIME: Table = Table {
    name: "over_time",
    doc: "A factor by a table over time: straight from point to point, constant before the first and after the last. A time \
          given twice is a jump.",
    types: &[],
    keys: &[
        TIMES,
        Key::new("values", Kind::List(&NUMBER, &[]), "The factor at those times.")
            .required()
            .example("[0.0, 1.0, 0.0]"),
    ],
};

/// The times of a table.
pub(super) const TIMES: Key = Key::new("times", Kind::List(&NUMBER, &[]), "Times, not decreasing.")
    .unit("s")
    .required()
    .example("[0.0, 0.5, 2.0]");

const LINKS: &[&str] = &["spring", "bushing", "curve"];

const CURVE: Kind = Kind::Either(&[POINTS, Kind::Table(&CURVE_VALUES)]);

/// Points of a table.
pub(super) const POINTS: Kind = Kind::List(&Kind::List(&NUMBER, &[2]), &[]);

pub(super) const INTERPOLATIONS: &[(&str, &str)] = &[
    ("smooth", "With a continuous slope; rises and falls with the points and nowhere else (PCHIP)."),
    ("linear", "Straight from point to point; the slope jumps there."),
];

/// The tables of a curve.
pub const CURVE_VALUES: Table = Table {
    name: "curve value",
    doc: "Pull by tables of points; both add.",
    types: &[],
    keys: &[
        Key::new("extension", POINTS, "Points `[extension, force]`, the extension beyond `length` increasing [m].")
            .unit("N")
            .example("[[-0.05, -2000.0], [0.0, 0.0], [0.1, 1500.0]]"),
        Key::new("rate", POINTS, "Points `[rate, force]`, the rate of the extension increasing [m/s].")
            .unit("N")
            .example("[[-1.0, -800.0], [0.0, 0.0], [1.0, 2500.0]]"),
    ],
};

pub(super) const END: Kind = Kind::Either(&[Kind::Text, Kind::Table(&ATTACHMENT)]);

const SIX: Kind = Kind::Either(&[Kind::List(&NOT_NEGATIVE, &[6]), Kind::Table(&BUSHING_VALUES)]);

const AXES: &[(&str, &str)] = &[
    ("inertial", "Keeps its direction in space."),
    ("body", "Turns with the body: a follower load, not conservative."),
];

/// Stiffness or damping of a bushing by kind of motion.
pub const BUSHING_VALUES: Table = Table {
    name: "bushing value",
    doc: "One number for all three directions, or three.",
    types: &[],
    keys: &[
        Key::new("translation", THREE, "Along x, y, z.").unit("N/m or N s/m").default("0.0").example("1000.0"),
        Key::new("rotation", THREE, "About x, y, z.")
            .unit("N m/rad or N m s/rad")
            .default("0.0")
            .example("[1.0, 1.0, 0.0]"),
    ],
};

const THREE: Kind = Kind::Either(&[NOT_NEGATIVE, Kind::List(&NOT_NEGATIVE, &[3])]);
