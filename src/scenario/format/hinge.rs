//! Hinges.

use super::super::fields::{Key, Kind, Range, Table};
use super::contact::DRY;
use super::force::{INTERPOLATIONS, POINTS};
use super::{NOT_NEGATIVE, NUMBER, POINT, POSITIVE, VECTOR};
use crate::hinge::{AlongTurn, DECLARED, Which, count, names};

/// `hinge = { … }`
pub const HINGE: Table = Table {
    name: "hinge",
    doc: "Where a body hangs, which motion is free there, and what acts in it. \
          Values per coordinate or per velocity are one number for hinges with one, else a list. \
          With `repeat` they may differ from copy to copy: where one body takes a number, a list of one number per \
          copy; where one body takes a list, a list of one list per copy.",
    types: &TYPES,
    keys: &[
        Key::new("parent", Kind::Text, "The body it hangs on.").default("\"ground\"").example("\"upper\""),
        Key::new(
            "at",
            POINT,
            "Where on the parent: coordinates in the parent's axes, or the name of a marker of the parent.",
        )
        .unit("m")
        .default("[0.0, 0.0, 0.0]")
        .example("\"tip\""),
        Key::new(
            "next",
            POINT,
            "With `repeat`: where on a copy the following one hangs; the same as `at` where it is left out.",
        )
        .unit("m")
        .example("\"tip\""),
        Key::new(
            "rpy",
            VECTOR,
            "Fixed turn of the hinge frame in the parent: roll, pitch, yaw as in URDF, Rz(yaw) Ry(pitch) Rx(roll).",
        )
        .unit("rad")
        .default("[0.0, 0.0, 0.0]")
        .example("[0.0, 0.0, 1.5708]"),
        Key::new("axis", VECTOR, "Axis in the hinge frame, of any length but zero.")
            .required()
            .only(&ALONG)
            .example("[0.0, 1.0, 0.0]"),
        Key::new("axes", Kind::List(&VECTOR, &[2]), "Both axes in the hinge frame, not parallel.")
            .required()
            .only(&ACROSS)
            .example("[[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]"),
        PITCH,
        Key::new("curve", Kind::Table(&GUIDE_CURVE), "The curve, hinge frame.")
            .required()
            .only(&["along"])
            .example("{ helix = [0.3, 0.1, 2.0] }"),
        Key::new("turn", Kind::Choice(AlongTurn::WORDS), "How it turns along the curve.")
            .default("\"follows\"")
            .only(&["along"])
            .example("\"held\""),
        Key::new("position", PER_COORDINATE, "Coordinates at the start, or the guess from which statics starts.")
            .unit("m or rad")
            .default("0.0")
            .only(&MOVING)
            .example("0.3"),
        Key::new("velocity", PER_COORDINATE, "Velocities at the start.")
            .unit("m/s or rad/s")
            .default("0.0")
            .only(&MOVING)
            .example("0.1"),
        Key::new("stiffness", PER_COORDINATE, "Stiffness of the hinge spring; one number stands for every velocity.")
            .unit("N/m or N m/rad")
            .default("0.0")
            .only(&MOVING)
            .example("5.0"),
        Key::new("damping", PER_VELOCITY, "Damping in the hinge; one number stands for every velocity.")
            .unit("N s/m or N m s/rad")
            .default("0.0")
            .only(&MOVING)
            .example("0.1"),
        Key::new("rest", PER_COORDINATE, "Coordinates at which the hinge spring is relaxed.")
            .unit("m or rad")
            .default("0.0")
            .only(&MOVING)
            .example("0.2"),
        Key::new("armature", PER_VELOCITY, "Added hinge inertia; one number stands for every velocity.")
            .unit("kg or kg m²")
            .default("0.0")
            .only(&MOVING)
            .example("0.01"),
        Key::new("force", PER_COORDINATE, "Constant motor force or torque.")
            .unit("N or N m")
            .default("0.0")
            .only(&MOVING)
            .example("1.5"),
        Key::new("lock", Kind::Flag, "Held at `position` during statics.")
            .default("false")
            .only(&MOVING)
            .example("true"),
        Key::new(
            "limits",
            LIMITS,
            "Lowest and highest coordinate, or a list of such pairs, of stops that hold; or one stop in full, or a list of those. Runs and statics heed them.",
        )
        .unit("m or rad")
        .only(&MOVING)
        .example("[-1.0, 1.0]"),
        Key::new("spring", CURVES, "A spring by a table of points, beside `stiffness`; or a list of such.")
            .only(&MOVING)
            .example("{ curve = [[-0.1, -900.0], [0.0, 0.0], [0.1, 500.0]] }"),
        Key::new("damper", CURVES, "A damper by a table of points, beside `damping`; or a list of such.")
            .only(&MOVING)
            .example("{ curve = [[-1.0, -300.0], [0.0, 0.0], [1.0, 900.0]], interpolation = \"linear\" }"),
        Key::new(
            "friction",
            FRICTION,
            "Dry friction; one value stands for every velocity, and bounds the size of the torque of a spherical hinge.",
        )
        .unit("N or N m")
        .default("0.0")
        .only(&MOVING)
        .example("4.0"),
    ],
};

/// Of a screw, in the tree or in a loop.
pub(super) const PITCH: Key =
    Key::new("pitch", NUMBER, "Distance along the axis per angle, not zero; negative for a left-hand thread.")
        .unit("m/rad")
        .required()
        .only(&["screw"])
        .example("0.0008");

/// Every kind with what it does.
const TYPES: [(&str, &str); DECLARED.len()] = {
    let (mut types, mut at) = ([("", ""); DECLARED.len()], 0);
    while at < DECLARED.len() {
        types[at] = (DECLARED[at].name, DECLARED[at].doc);
        at += 1;
    }
    types
};
const MOVING: [&str; count(Which::Moving)] = names(Which::Moving);
/// The kinds with one axis.
pub(super) const ALONG: [&str; count(Which::Axes(1))] = names(Which::Axes(1));
/// The kinds with two axes.
pub(super) const ACROSS: [&str; count(Which::Axes(2))] = names(Which::Axes(2));

const PER_COORDINATE: Kind =
    Kind::Either(&[NUMBER, Kind::List(&NUMBER, &[]), Kind::List(&Kind::List(&NUMBER, &[]), &[])]);

const PER_VELOCITY: Kind =
    Kind::Either(&[NOT_NEGATIVE, Kind::List(&NOT_NEGATIVE, &[]), Kind::List(&Kind::List(&NOT_NEGATIVE, &[]), &[])]);

const FRICTION: Kind = Kind::Either(&[NOT_NEGATIVE, Kind::Table(&super::contact::FRICTION), Kind::List(&DRY, &[])]);

const LIMITS: Kind = Kind::Either(&[
    Kind::List(&Kind::Number(Range::Any), &[2]),
    Kind::List(&Kind::List(&NUMBER, &[2]), &[]),
    Kind::Table(&LIMIT),
    Kind::List(&Kind::Table(&LIMIT), &[]),
]);

const CURVES: Kind = Kind::Either(&[Kind::Table(&HINGE_CURVE), Kind::List(&Kind::Table(&HINGE_CURVE), &[])]);

/// The curve of a hinge of type `along`.
pub(super) const GUIDE_CURVE: Table = Table {
    name: "curve",
    doc: "A curve that a body is guided along: exactly one of `straight`, `points`, `helix` and `parameter`. The coordinate is its \
          arc length, from its beginning, or from parameter 0 where its range has that. A run or an equilibrium beyond its ends is an error.",
    types: &[],
    keys: &[
        Key::new("straight", POSITIVE, "Along x, of this length.").unit("m").example("1.2"),
        Key::new(
            "points",
            Kind::List(&VECTOR, &[]),
            "The spline of degree 5 through these points: four continuous derivatives.",
        )
        .unit("m")
        .example("[[0.0, 0.0, 0.0], [1.0, 0.0, 0.2], [2.0, 0.5, 0.0]]"),
        Key::new(
            "helix",
            Kind::List(&NUMBER, &[3]),
            "Radius (m), rise per turn (m) and number of turns of a helix about z that begins at [radius, 0, 0]; right-handed with a rise above zero.",
        )
        .example("[0.3, 0.1, 2.0]"),
        Key::new("parameter", Kind::Text, "The name of the parameter of the formulas `x`, `y` and `z`.").example("\"u\""),
        Key::new("x", Kind::Text, "Formula of the parameter.").unit("m").default("\"0\"").example("\"u\""),
        Key::new("y", Kind::Text, "Formula of the parameter.").unit("m").default("\"0\"").example("\"sin(u)\""),
        Key::new("z", Kind::Text, "Formula of the parameter.").unit("m").default("\"0\"").example("\"0.5*u^2\""),
        Key::new("range", Kind::List(&NUMBER, &[2]), "Where the parameter begins and ends.").example("[-1.0, 1.0]"),
    ],
};

/// A spring or damper of a hinge by a table of points.
pub const HINGE_CURVE: Table = Table {
    name: "hinge curve",
    doc: "What a hinge opposes, by a table of points; beyond its ends it goes on with its slope.",
    types: &[],
    keys: &[
        Key::new("curve", POINTS, "Points `[x, f]`, x increasing: of a spring the distance from `rest` [m or rad], of a damper the speed [m/s or rad/s]; f is what opposes it.")
            .unit("N or N m")
            .required()
            .example("[[-0.1, -900.0], [0.0, 0.0], [0.1, 500.0]]"),
        Key::new("interpolation", Kind::Choice(INTERPOLATIONS), "Between the points.")
            .default("\"smooth\"")
            .example("\"linear\""),
        Key::new("coordinate", Kind::Integer(Range::AtLeast(0.0)), "Which of the hinge's coordinates, from 0.")
            .default("0")
            .example("0"),
    ],
};

/// A stop in full.
pub const LIMIT: Table = Table {
    name: "limits",
    doc: "A stop on one or both sides: rigid, or with `stiffness` compliant.",
    types: &[],
    keys: &[
        Key::new("low", NUMBER, "Lowest coordinate; without it there is none.").unit("m or rad").example("-1.0"),
        Key::new("high", NUMBER, "Highest coordinate; without it there is none.").unit("m or rad").example("1.0"),
        Key::new("coordinate", Kind::Integer(Range::AtLeast(0.0)), "Which of the hinge's coordinates, from 0.")
            .default("0")
            .example("0"),
        Key::new(
            "restitution",
            Kind::Number(Range::Between(0.0, 1.0)),
            "Rigid: the part of the speed that comes back.",
        )
        .default("0.0")
        .example("0.5"),
        Key::new("stiffness", POSITIVE, "Compliant: stiffness.").unit("N/m or N m/rad").example("1e5"),
        Key::new("damping", NOT_NEGATIVE, "Compliant: damping; the stop never pulls.")
            .unit("N s/m or N m s/rad")
            .default("0.0")
            .example("10.0"),
    ],
};
