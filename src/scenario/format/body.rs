//! Bodies, their shapes, and points on them.

use super::super::fields::{Key, Kind, Range, Table};
use super::hinge::HINGE;
use super::{MOST_BODIES, NOT_NEGATIVE, POINT, POSITIVE, VECTOR};

/// `[[body]]`
pub const BODY: Table = Table {
    name: "body",
    doc: "A rigid body and the hinge that carries it.",
    types: &[],
    keys: &[
        Key::new("name", Kind::Text, "Unique name; copies of a repeat are called `name[0]`, `name[1]`, ….")
            .required()
            .example("\"upper\""),
        Key::new(
            "repeat",
            Kind::Integer(Range::Between(1.0, MOST_BODIES as f64)),
            "Number of copies in a chain: the first hangs on `hinge.parent` at `hinge.at`, every other one on the copy before it at `hinge.next`.",
        )
        .example("3"),
        Key::new(
            "next",
            POINT,
            "With `repeat`: where on a copy the following one hangs; the same as `hinge.next`, to be written in one of the two places.",
        )
        .unit("m")
        .example("\"tip\""),
        Key::new(
            "mass",
            Kind::Either(&[NOT_NEGATIVE, Kind::List(&NOT_NEGATIVE, &[])]),
            "Mass; with `repeat` also a list of one mass per copy.",
        )
        .unit("kg")
        .default("0.0")
        .example("2.0"),
        Key::new("density", POSITIVE, "In place of `mass`, `center` and `inertia`: they follow from the shapes filled with it (meshes must be closed).")
            .unit("kg/m³")
            .example("7850.0"),
        Key::new("center", VECTOR, "Centre of mass from the root marker, body axes.")
            .unit("m")
            .default("[0.0, 0.0, 0.0]")
            .example("[0.0, 0.0, -0.5]"),
        Key::new(
            "inertia",
            Kind::List(&super::NUMBER, &[3, 6]),
            "Inertia about the centre of mass, body axes: xx, yy, zz, or xx, yy, zz, xy, xz, yz. Without it the body is a point mass.",
        )
        .unit("kg m²")
        .default("[0.0, 0.0, 0.0]")
        .example("[0.17, 0.17, 0.004]"),
        Key::new(
            "unphysical",
            Kind::Flag,
            "Take `inertia` though no body can have it: its largest principal moment above the sum of the others, one below zero, or no mass with it. Models of other programs have such.",
        )
        .default("false")
        .example("true"),
        Key::new(
            "modal",
            Kind::Text,
            "A flexible body in place of a rigid one: the file of finite elements (`.npz`) that it is reduced from. Its interfaces are markers that other bodies, springs and loops are attached to; the first is the root marker.",
        )
        .example("\"arm.npz\""),
        Key::new(
            "modes",
            Kind::Integer(Range::Between(0.0, 96.0)),
            "Of a body with `modal`: how many modes with all interfaces held its displacements consist of, beside those that the interfaces give.",
        )
        .default("0")
        .example("6"),
        Key::new(
            "geometric",
            Kind::Flag,
            "Of a body with `modal`: whether it takes the geometric stiffness that its file has, by which spin and loads along it stiffen it.",
        )
        .default("true")
        .example("false"),
        Key::new("modal_damping", Kind::Table(&MODAL_DAMPING), "Of a body with `modal`: its damping.")
            .example("{ ratio = 0.01 }"),
        Key::new("burn", Kind::Table(&BURN), "In place of `mass`, `center` and `inertia`: they follow a table over time. What leaves has the body's velocity; thrust is a load.")
            .example("{ times = [0.0, 2.0], mass = [12.0, 4.0] }"),
        Key::new("markers", Kind::Map(&VECTOR), "Named points, body axes, from the root marker.")
            .unit("m")
            .example("{ tip = [0.0, 0.0, -1.0] }"),
        Key::new(
            "shape",
            Kind::Either(&[Kind::Table(&SHAPE), Kind::List(&Kind::Table(&SHAPE), &[])]),
            "What it looks like, and with `density` what it weighs: one solid or a list of solids.",
        )
        .example("{ box = [0.05, 0.05, 1.0], at = [0.0, 0.0, -0.5] }"),
        Key::new("hinge", Kind::Table(&HINGE), "The hinge that carries it.")
            .required()
            .example("{ type = \"revolute\", parent = \"ground\", axis = [0.0, 1.0, 0.0] }"),
    ],
};

/// The damping of a modal body.
const MODAL_DAMPING: Table = Table {
    name: "modal_damping",
    doc: "Damping of a modal body: `ratio`, or the sum of `mass` times its mass matrix and `stiffness` times its stiffness matrix.",
    types: &[],
    keys: &[
        Key::new(
            "ratio",
            NOT_NEGATIVE,
            "Part of the critical damping that every mode of the body with its root held has.",
        )
        .example("0.01"),
        Key::new("mass", NOT_NEGATIVE, "Factor of the mass matrix.").unit("1/s").example("0.5"),
        Key::new("stiffness", NOT_NEGATIVE, "Factor of the stiffness matrix.").unit("s").example("1e-5"),
    ],
};

/// A mass that burns away.
const BURN: Table = Table {
    name: "burn",
    doc: "Mass properties by a table over time: straight from point to point, constant before the first and after the last. A time \
          given twice is a jump.",
    types: &[],
    keys: &[
        super::force::TIMES,
        Key::new("mass", Kind::List(&POSITIVE, &[]), "Mass at those times.")
            .unit("kg")
            .required()
            .example("[12.0, 4.0]"),
        Key::new("center", Kind::List(&VECTOR, &[]), "Centre of mass at those times, body axes; without it always the root marker.")
            .unit("m")
            .example("[[0.4, 0.0, 0.0], [0.7, 0.0, 0.0]]"),
        Key::new("inertia", Kind::List(&Kind::List(&super::NUMBER, &[3, 6]), &[]), "Inertia about the centre of mass at those times, as the body's `inertia`; without it the body is a point mass.")
            .unit("kg m²")
            .example("[[0.02, 1.1, 1.1], [0.01, 0.5, 0.5]]"),
    ],
};

/// A `shape`.
pub const SHAPE: Table = Table {
    name: "shape",
    doc: "A solid in body axes: exactly one of `box`, `sphere`, `cylinder`, `capsule`, `plane` and `mesh`.",
    types: &[],
    keys: &[
        Key::new("box", Kind::List(&POSITIVE, &[3]), "Edge lengths.").unit("m").example("[0.05, 0.05, 1.0]"),
        Key::new("sphere", NOT_NEGATIVE, "Radius; 0 is a point.").unit("m").example("0.1"),
        Key::new("cylinder", ROUNDED, "Radius and length, along its z.").unit("m").example("[0.05, 1.0]"),
        Key::new(
            "capsule",
            EDGED,
            "Radius (0: an edge) and length of the cylindrical part, along its z, with half spheres on both ends.",
        )
        .unit("m")
        .example("{ radius = 0.05, length = 1.0 }"),
        Key::new("plane", VECTOR, "Outward normal of a plane through `at`: all that is behind it is solid.")
            .example("[0.0, 0.0, 1.0]"),
        Key::new("contact", Kind::Flag, "Whether it touches other bodies, if there is a `[[contact]]` between them.")
            .default("true")
            .example("false"),
        Key::new("visible", Kind::Flag, "Whether it is drawn.").default("true").example("false"),
        Key::new(
            "mesh",
            Kind::Text,
            "A triangle mesh: a file (.stl, .obj, .gltf, .glb), as found from the scenario's folder.",
        )
        .example("\"link.stl\""),
        Key::new(
            "scale",
            Kind::Either(&[POSITIVE, Kind::List(&Kind::Number(Range::Any), &[3])]),
            "Scale of a mesh, along all axes or along each; negative to mirror it.",
        )
        .default("1.0")
        .example("0.001"),
        Key::new("hull", Kind::Flag, "Of a mesh: whether its convex hull touches other shapes, whatever its own form.")
            .default("false")
            .example("true"),
        Key::new("at", VECTOR, "Where its middle stands, body axes.")
            .unit("m")
            .default("[0.0, 0.0, 0.0]")
            .example("[0.0, 0.0, -0.5]"),
        Key::new("rpy", VECTOR, "Its turn in the body: roll, pitch, yaw as in URDF, Rz(yaw) Ry(pitch) Rx(roll).")
            .unit("rad")
            .default("[0.0, 0.0, 0.0]")
            .example("[0.0, 1.5708, 0.0]"),
        Key::new(
            "color",
            Kind::Either(&[Kind::List(&Kind::Number(Range::Between(0.0, 1.0)), &[3, 4]), Kind::Text]),
            "Red, green, blue and perhaps opacity, each 0 … 1; \"#rrggbb\"; or a name as \"red\".",
        )
        .example("[0.8, 0.2, 0.1]"),
        Key::new(
            "density",
            Kind::Refused("`density` stands beside `shape`, in the body: all its solids have it"),
            "Of the body.",
        ),
    ],
};

/// The size of a capsule: without a radius it is an edge.
const EDGED: Kind = Kind::Either(&[Kind::List(&NOT_NEGATIVE, &[2]), Kind::Table(&EDGE)]);
const ROUNDED: Kind = Kind::Either(&[Kind::List(&POSITIVE, &[2]), Kind::Table(&ROUND)]);

/// The size of a capsule.
const EDGE: Table = Table {
    name: "size",
    doc: "The size of a capsule; `[radius, length]` says the same.",
    types: &[],
    keys: &[
        Key::new("radius", NOT_NEGATIVE, "Radius; 0 is an edge.").unit("m").required().example("0.05"),
        Key::new("length", POSITIVE, "Length of the cylindrical part.").unit("m").required().example("1.0"),
    ],
};

/// The size of a cylinder.
pub const ROUND: Table = Table {
    name: "size",
    doc: "The size of a cylinder; `[radius, length]` says the same.",
    types: &[],
    keys: &[
        Key::new("radius", POSITIVE, "Radius.").unit("m").required().example("0.05"),
        Key::new("length", POSITIVE, "Length of the cylindrical part.").unit("m").required().example("1.0"),
    ],
};
