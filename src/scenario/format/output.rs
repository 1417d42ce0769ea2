//! Outputs: what a user asks of a scene.

use super::super::fields::{Key, Kind, Table};
use super::force::END;
use super::{NOT_NEGATIVE, VECTOR};

/// `[[output]]`
pub const OUTPUT: Table = Table {
    name: "output",
    doc: "A number, or a list of numbers, that is asked of the scene: in answers, recordings, tables and plots by its name.",
    types: &[
        ("position", "Where a point is."),
        ("velocity", "How fast a point moves, seen from the ground."),
        ("acceleration", "The acceleration of a point, seen from the ground."),
        ("distance", "Distance of two points."),
        ("angle", "Angle by which the direction `against` must be turned to come to the direction `of`."),
        ("orientation", "Orientation of a body: quaternion w, x, y, z that turns its axes into inertial ones."),
        ("coordinate", "Coordinates of a hinge."),
        ("rate", "Velocities of a hinge."),
        (
            "force",
            "What an element pushes with: of springs, curves, ropes and rods the pull; of sliders what they are pressed with; of motors, drives, gears and stops the force in the coordinate; of bushings, loads and loops six numbers; of contacts the force on the second body.",
        ),
        ("length", "Length of a spring, a curve, the path of a rope, or the centre line of a beam or cable; of a slider how far it is from the root of its beam."),
        ("reaction", "What a hinge passes to its body at the body's root marker: force, then moment."),
        (
            "section",
            "What a beam or cable bears at `s`, in the section's axes: normal force (tension > 0), shear along y and z, torque, bending moments about y and z, exerted by the part beyond.",
        ),
        ("energy", "An energy of the scene."),
        ("power", "A power of the scene."),
        ("expression", "A formula in other outputs and the time `t`."),
    ],
    keys: &[
        Key::new("name", Kind::Text, "Unique name.").required().example("\"camber\""),
        Key::new("of", END, "The point; of two points the second.").only(POINTS).example("\"upright.hub\""),
        Key::new("of", Kind::Table(&DIRECTION), "The one direction.")
            .required()
            .only(&["angle"])
            .example("{ body = \"upright\", axis = [0.0, 1.0, 0.0] }"),
        Key::new("of", Kind::Text, "The body; for `reaction` the one whose hinge it is.")
            .required()
            .only(&["orientation", "reaction"])
            .example("\"upright\""),
        Key::new(
            "of",
            Kind::Text,
            "Address: `crank` for all coordinates of its hinge, `slider.position[1]`, or `crank.angle` by the coordinate's own name; of rates `slider.velocity[1]`.",
        )
        .required()
        .only(&["coordinate", "rate"])
        .example("\"crank\""),
        Key::new(
            "of",
            Kind::Text,
            "Name of a force element, motor, drive, gear, loop or contact, `drive[0]` by its place, or of a body for the stops of its hinge.",
        )
        .required()
        .only(&["force"])
        .example("\"strut\""),
        Key::new("of", Kind::Text, "Name of a spring, curve, rope, slider, beam or cable.").required().only(&["length"]).example("\"strut\""),
        Key::new("of", Kind::Text, "Name of a beam or cable.").required().only(&["section"]).example("\"boom\""),
        Key::new("s", NOT_NEGATIVE, "Distance of the section from the root, along the beam without load.")
            .unit("m")
            .required()
            .only(&["section"])
            .example("0.5"),
        Key::new("component", Kind::Choice(SECTIONS), "The one number that is asked for; without, all but the stress.")
            .only(&["section"])
            .example("\"my\""),
        Key::new("of", Kind::Choice(ENERGIES), "Which one.").required().only(&["energy"]).example("\"kinetic\""),
        Key::new("of", Kind::Choice(POWERS), "Which one.").required().only(&["power"]).example("\"input\""),
        Key::new("between", Kind::List(&END, &[2]), "The two points; or `of` and `against`.")
            .only(&["distance"])
            .example("[\"chassis.strut\", \"lower arm.seat\"]"),
        Key::new("against", END, "The first point.").only(&["distance"]).example("\"chassis.strut\""),
        Key::new("against", Kind::Table(&DIRECTION), "The direction from which the angle is measured.")
            .required()
            .only(&["angle"])
            .example("{ body = \"ground\", axis = [0.0, 1.0, 0.0] }"),
        Key::new(
            "about",
            VECTOR,
            "Axis about which the angle is positive, axes of the body of `against`; both directions are projected along it. Without: 0 to π.",
        )
        .only(&["angle"])
        .example("[1.0, 0.0, 0.0]"),
        Key::new("axis", VECTOR, "Direction of the one component that is asked for; all three without.")
            .only(KINEMATIC)
            .example("[0.0, 0.0, 1.0]"),
        Key::new("in", Kind::Choice(AXES), "Axes of the components, and of `axis`.")
            .default("\"inertial\"")
            .only(&["position", "velocity", "acceleration", "reaction"])
            .example("\"body\""),
        Key::new("component", Kind::Choice(COMPONENTS), "The one of six numbers that is asked for, of a contact one of the first three; all without.")
            .only(&["reaction", "force"])
            .example("\"fz\""),
        Key::new(
            "expression",
            Kind::Text,
            "Formula in names of other outputs, one of several numbers as `{tip[2]}`, and the time `t` [s], with the operators and functions of Python.",
        )
        .required()
        .only(&["expression"])
        .example("\"left - right\""),
        Key::new("unit", Kind::Text, "What the formula measures, for headings.")
            .default("\"1\"")
            .only(&["expression"])
            .example("\"m\""),
    ],
};

const KINEMATIC: &[&str] = &["position", "velocity", "acceleration"];
const POINTS: &[&str] = &["position", "velocity", "acceleration", "distance"];

const AXES: &[(&str, &str)] = &[("inertial", "Fixed in space."), ("body", "Those of the body.")];

const ENERGIES: &[(&str, &str)] = &[
    ("kinetic", "Of the motion."),
    ("potential", "Of gravity, springs and stops, and of loads and motors that have one."),
    ("input", "Work of motors, drives and loads without a potential since the start of the run."),
    ("dissipated", "What dampers and impacts have taken out since the start of the run."),
];

const POWERS: &[(&str, &str)] =
    &[("input", "Put in by motors, drives and loads without a potential."), ("dissipated", "Taken out by dampers.")];

/// Names of the six numbers of a section, in their order, and of its stress.
pub const SECTIONS: &[(&str, &str)] = &[
    ("n", "Normal force, tension > 0."),
    ("qy", "Shear along y."),
    ("qz", "Shear along z."),
    ("t", "Torque."),
    ("my", "Bending moment about y."),
    ("mz", "Bending moment about z."),
    ("stress", "Von Mises' stress where it is largest in the section, which needs a size (Pa)."),
];

/// Names of the six numbers of a force and a moment, in their order.
pub const COMPONENTS: &[(&str, &str)] = &[
    ("fx", "Force along x."),
    ("fy", "Force along y."),
    ("fz", "Force along z."),
    ("mx", "Moment about x."),
    ("my", "Moment about y."),
    ("mz", "Moment about z."),
];

/// A direction that a body carries.
pub const DIRECTION: Table = Table {
    name: "direction",
    doc: "A direction that a body carries.",
    types: &[],
    keys: &[
        Key::new("body", Kind::Text, "The body, or `ground`.").required().example("\"upright\""),
        Key::new("axis", VECTOR, "In the axes of the body, of any length but zero.")
            .required()
            .example("[0.0, 1.0, 0.0]"),
    ],
};
