//! What is asked of a run.

use super::super::fields::{Key, Kind, Range, Table};
use super::POSITIVE;

const TOLERANCE: Kind = Kind::Number(Range::Between(1e-14, 1.0));

/// `(simulate)`
pub const SIMULATE: Table = Table {
    name: "simulate",
    doc: "What is asked of a run.",
    types: &[],
    keys: &[
        Key::new("start", Kind::Choice(STARTS), "Where the run starts.")
            .default("\"equilibrium\"")
            .example("\"given\""),
        Key::new("duration", POSITIVE, "Simulated time.").unit("s").default("10.0").example("10.0"),
        Key::new("integrator", Kind::Planned(INTEGRATORS, LATER_INTEGRATORS), "The time stepping method.")
            .default("\"auto\"")
            .example("\"dopri5\""),
        Key::new("tolerance", TOLERANCE, "Relative tolerance of adaptive methods.").default("1e-8").example("1e-8"),
        Key::new(
            "absolute_tolerance",
            POSITIVE,
            "Absolute tolerance beside it, in units of the scene's own length, 1 rad and the scene's time; without it the same number as `tolerance`.",
        )
        .example("1e-8"),
        Key::new("step", POSITIVE, "Step of fixed-step methods, first step of adaptive ones.")
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
    ("sdirk4", "L-stable, stiffly accurate, order 4, adaptive."),
];

const LATER_INTEGRATORS: &[&str] = &["radau5", "generalized-alpha", "gauss"];

/// `(statics)`
pub const STATICS: Table = Table {
    name: "statics",
    doc: "What is asked of statics.",
    types: &[],
    keys: &[
        Key::new("want", Kind::Choice(WANTS), "Which equilibrium.").default("\"stable\"").example("\"stable\""),
        Key::new("method", Kind::Choice(METHODS), "How it is found.").default("\"auto\"").example("\"newton\""),
        Key::new(
            "unknown",
            Kind::List(&Kind::Text, &[]),
            "Inverse statics: the pose is given, and these numbers of the scene are found so that they hold it.",
        )
        .example("[\"upper.force\", \"strut.length\"]"),
        Key::new("path", Kind::Refused("equilibrium paths cannot be followed by this version"), "Follows a parameter."),
    ],
};

const WANTS: &[(&str, &str)] = &[
    ("stable", "A stable one: a saddle is left, and said so."),
    ("any", "The nearest one, whatever it is, and what it is."),
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
    keys: &[Key::new("rate", POSITIVE, "Samples per second of simulated time.")
        .unit("1/s")
        .default("100.0")
        .example("100.0")],
};
