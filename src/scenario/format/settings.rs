//! What is asked of a run.

use super::super::fields::{ANY_UNIT, Key, Kind, Range, Table};
use super::{NUMBER, POSITIVE};
use crate::simulate::TOLERANCES;

const TOLERANCE: Kind = Kind::Number(Range::Between(TOLERANCES[0], TOLERANCES[1]));

/// `[simulate]`
pub const SIMULATE: Table = Table {
    name: "simulate",
    doc: "What is asked of a run.",
    types: &[],
    keys: &[
        Key::new("start", Kind::Choice(STARTS), "Where the run starts.")
            .default("\"equilibrium\"")
            .example("\"given\""),
        Key::new("duration", POSITIVE, "Simulated time.").unit("s").default("10.0").example("10.0"),
        Key::new("integrator", Kind::Choice(INTEGRATORS), "The time stepping method.")
            .default("\"auto\"")
            .example("\"dopri5\""),
        Key::new("tolerance", TOLERANCE, "Error allowed at the end of the run by adaptive methods, relative; what the motion itself makes of an error is not counted.").default("1e-8").example("1e-8"),
        Key::new(
            "absolute_tolerance",
            POSITIVE,
            "Absolute tolerance beside it, in units of the scene's own length, 1 rad and the scene's time; without it the same number as `tolerance`.",
        )
        .example("1e-8"),
        Key::new(
            "rho_infinity",
            Kind::Number(Range::Between(0.0, 1.0)),
            "For `generalized-alpha`: the part of motions far faster than the step that a step leaves.",
        )
        .default("0.8")
        .example("0.8"),
        Key::new("step", POSITIVE, "Step of fixed-step methods, first step of adaptive ones. Without it a fixed one is a hundredth of the scene's own time, at most 1 ms, and at most a twentieth of √(m/k) of every compliant stop.")
            .unit("s")
            .example("1e-3"),
    ],
};

const STARTS: &[(&str, &str)] = &[
    ("equilibrium", "At the equilibrium that statics finds."),
    ("given", "At the hinge positions and velocities as they stand."),
];

const INTEGRATORS: &[(&str, &str)] = &[
    ("auto", "Chosen by a stated rule."),
    ("rk4", "Classical Runge–Kutta, fixed step."),
    ("dopri5", "Dormand–Prince 5(4), adaptive."),
    ("dop853", "Dormand–Prince 8(5,3), adaptive, for tight tolerances."),
    ("adams", "Adams methods of variable order, adaptive: smooth scenes, at the fewest evaluations."),
    ("sdirk4", "L-stable, stiffly accurate, order 4, adaptive: stiff scenes."),
    ("radau5", "Radau IIA, order 5, adaptive: stiff scenes."),
    ("radau9", "Radau IIA, order 9, adaptive: stiff scenes at tight tolerances."),
    ("generalized-alpha", "Order 2, adaptive; `rho_infinity` says how much of what is too fast for the step lives on."),
    ("gauss", "Symmetric, order 6, fixed step: long runs without dissipation."),
];

/// `[statics]`
pub const STATICS: Table = Table {
    name: "statics",
    doc: "What is asked of statics.",
    types: &[],
    keys: &[
        Key::new("want", Kind::Choice(WANTS), "Which equilibrium.").default("\"stable\"").example("\"stable\""),
        Key::new("method", Kind::Choice(METHODS), "How it is found.").default("\"auto\"").example("\"newton\""),
        Key::new(
            "time_limit",
            POSITIVE,
            "How long the search may take; one that takes longer ends without an equilibrium and says what it found until then.",
        )
        .unit("s")
        .default("60.0")
        .example("600.0"),
        Key::new(
            "unknown",
            Kind::List(&Kind::Text, &[]),
            "Inverse statics: the pose is given, and these numbers of the scene are found so that they hold it.",
        )
        .example("[\"upper.force\", \"strut.length\"]"),
        Key::new(
            "aim",
            Kind::Map(&NUMBER),
            "What outputs of the equilibrium shall be: the `unknown` numbers are found so that they are, the pose follows.",
        )
        .unit(ANY_UNIT)
        .example("{ elevation = 0.8 }"),
        Key::new(
            "contact",
            Kind::Choice(CONTACTS),
            "What is asked of a scene with `[[contact]]`.",
        )
        .default("\"as-given\"")
        .example("\"settle\""),
        Key::new(
            "gap",
            Kind::Number(Range::Between(1e-12, 1e-2)),
            "Contacts whose gap is at most this part of the smaller of both shapes are closed; deeper overlap is an error.",
        )
        .default("1e-6")
        .example("1e-4"),
        Key::new(
            "margin",
            Kind::List(&Kind::Text, &[]),
            "What may move while a pose with friction or contact stands: `friction`, `tilt`, or addresses of numbers.",
        )
        .example("[\"friction\", \"tilt\", \"push.force[0]\"]"),
        Key::new("path", Kind::Table(&PATH), "Follows the equilibrium while one number of the scene moves.")
            .example("{ parameter = \"tip.force[2]\", to = -20.0 }"),
    ],
};

/// `[statics.path]`
pub const PATH: Table = Table {
    name: "path",
    doc: "Follows the equilibrium while one number of the scene moves over a range, around folds.",
    types: &[],
    keys: &[
        Key::new("parameter", Kind::Text, "Address of the number that moves.").required().example("\"tip.force[2]\""),
        Key::new("from", NUMBER, "Where the path starts; without it the number in the file.")
            .unit(ANY_UNIT)
            .example("0.0"),
        Key::new("to", NUMBER, "The other end of the range.").unit(ANY_UNIT).required().example("-20.0"),
        Key::new("at", Kind::List(&NUMBER, &[]), "Values of the parameter at which points are wanted.")
            .unit(ANY_UNIT)
            .example("[-5.0, -10.0]"),
        Key::new(
            "step",
            Kind::Number(Range::Between(1e-4, 1.0)),
            "Largest step: 1 is the whole range, or a radian or a length of every coordinate.",
        )
        .default("0.02")
        .example("0.01"),
        Key::new("points", Kind::Integer(Range::Between(2.0, 1e6)), "Most points of a branch.")
            .default("1000")
            .example("1000"),
        Key::new("branches", Kind::Flag, "Whether branches that leave at bifurcations are followed too.")
            .default("true")
            .example("false"),
        Key::new(
            "coordinate",
            Kind::Text,
            "The hinge coordinate that is drawn against the parameter; without it the one that moves most.",
        )
        .example("\"tip.position\""),
    ],
};

const WANTS: &[(&str, &str)] = &[
    ("stable", "A stable one: a saddle is left, and said so."),
    ("any", "The nearest one, whatever it is, and what it is."),
];

const CONTACTS: &[(&str, &str)] = &[
    ("as-given", "Whether it stands as it is put."),
    ("settle", "The same; what does not stand is moved until it does, as far as it takes."),
];

const METHODS: &[(&str, &str)] = &[
    ("auto", "The cascade."),
    ("newton", "Newton on the differentiated transfer equations alone."),
    ("relaxation", "Dynamic relaxation: an explicit motion with kinetic damping, to compare with."),
    ("lagrange", "Newton in maximal coordinates with Lagrange multipliers, to compare with."),
];

/// `[record]`
pub const RECORD: Table = Table {
    name: "record",
    doc: "What is asked of the recording.",
    types: &[],
    keys: &[
        Key::new("rate", POSITIVE, "Samples per second of simulated time.")
            .unit("1/s")
            .default("100.0")
            .example("100.0"),
        Key::new(
            "ros",
            Kind::Flag,
            "Writes the scene as ROS 2 messages too: `/robot_description` (up to 1000 bodies) and `/joint_states` (up to 64 hinges with one coordinate), from which Rerun draws a recording that is opened directly.",
        )
        .default("false")
        .example("true"),
    ],
};
