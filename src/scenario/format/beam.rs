//! Flexible beams.

use super::super::fields::{Key, Kind, Range, Table};
use super::force::END;
use super::hinge::HINGE;
use super::{NOT_NEGATIVE, NUMBER, POSITIVE, VECTOR};

/// `[[beam]]`
pub const BEAM: Table = Table {
    name: "beam",
    doc: "A flexible beam along the x axis of its root. On its name alone its tip is meant; it has the markers `root` and `tip`.",
    types: &[],
    keys: &[
        Key::new("name", Kind::Text, "Unique name among bodies and beams.").required().example("\"blade\""),
        Key::new("hinge", Kind::Table(&HINGE), "The hinge that carries its root, as a body's.")
            .required()
            .example("{ type = \"fixed\", parent = \"ground\" }"),
        Key::new("length", POSITIVE, "Length of a straight beam, unstrained.").unit("m").example("2.0"),
        Key::new("curve", Kind::Table(&BEAM_CURVE), "In place of `length`: its centre line without strain.")
            .example("{ arc = [100.0, 0.785] }"),
        Key::new("twist", NUMBER, "How far its sections turn about the centre line over its length, unstrained.")
            .unit("rad")
            .default("0.0")
            .example("1.5708"),
        ELEMENTS,
        DEGREE,
        SECTIONS,
        OF,
        MASS_PER_LENGTH,
        ROTARY,
        Key::new(
            "free",
            Kind::List(&Kind::Choice(STRAINS), &[]),
            "Which strains are free; the others keep their value without load.",
        )
        .default("[\"bend\", \"twist\"]")
        .example("[\"bend\", \"twist\", \"stretch\"]"),
        DAMPING,
        MARKERS,
        LOAD,
    ],
};

/// `[[cable]]`
pub const CABLE: Table = Table {
    name: "cable",
    doc: "A cable between two points: a flexible beam that begins in the shape of the elastic catenary and is closed at its far end by a loop of its name. \
          Its x axis points from the first end to the second, its z axis against its weight.",
    types: &[],
    keys: &[
        Key::new("name", Kind::Text, "Unique name among bodies, beams and cables.").required().example("\"stay\""),
        Key::new("between", Kind::List(&END, &[2]), "Its two ends.")
            .required()
            .example("[\"mast.top\", { body = \"ground\", at = [20.0, 0.0, 0.0] }]"),
        Key::new("ends", Kind::List(&Kind::Choice(ENDS), &[2]), "How it is held at each of them.")
            .default("[\"spherical\", \"spherical\"]")
            .example("[\"fixed\", \"spherical\"]"),
        Key::new("length", POSITIVE, "Unstretched length; this or `pretension`.").unit("m").example("22.0"),
        Key::new(
            "pretension",
            POSITIVE,
            "Tension at its first end in the given positions, from which its unstretched length follows.",
        )
        .unit("N")
        .example("4000.0"),
        Key::new("bending", NOT_NEGATIVE, "Bending stiffness in place of the section's: strands slide on each other.")
            .unit("N m²")
            .example("0.5"),
        ELEMENTS,
        DEGREE,
        SECTIONS,
        OF,
        MASS_PER_LENGTH,
        ROTARY,
        Key::new(
            "free",
            Kind::List(&Kind::Choice(STRAINS), &[]),
            "Which strains are free; the others keep their value without load.",
        )
        .default("[\"bend\", \"stretch\"]")
        .example("[\"bend\", \"twist\", \"stretch\"]"),
        DAMPING,
        MARKERS,
        LOAD,
    ],
};

const ENDS: &[(&str, &str)] = &[
    ("spherical", "It may point anywhere."),
    ("fixed", "It points along the line between both ends in the given positions."),
];

const ELEMENTS: Key =
    Key::new("elements", Kind::Integer(Range::AtLeast(1.0)), "Number of elements; at least one between markers.")
        .default("8")
        .example("16");

const DEGREE: Key = Key::new("degree", Kind::Integer(Range::Between(0.0, 2.0)), "Degree of the strains in an element.")
    .default("1")
    .example("2");

const SECTIONS: Key = Key::new(
    "section",
    Kind::Either(&[Kind::Table(&SECTION), Kind::List(&Kind::Table(&SECTION), &[])]),
    "Its section, or several at distances `s` from the root, with others between them.",
)
.required()
.example("{ rectangle = [0.05, 0.004] }");

const OF: Key = Key::new("material", Kind::Table(&MATERIAL), "What it is made of, for sections that have a size.")
    .example("{ young = 71.7e9, poisson = 0.31, density = 2800.0 }");

const MASS_PER_LENGTH: Key =
    Key::new("mass_per_length", POSITIVE, "In place of the material's density.").unit("kg/m").example("1.2");

const ROTARY: Key = Key::new(
    "rotary",
    Kind::List(&NOT_NEGATIVE, &[3]),
    "Rotary inertia per length about x, y and z. Default: that of the material; with `stiffness` none, but that of a homogeneous section about x if twist is free and about y and z if shear is.",
)
.unit("kg m")
.example("[6e-4, 3e-4, 3e-4]");

const DAMPING: Key =
    Key::new("damping", NOT_NEGATIVE, "Kelvin–Voigt damping: stress by rate of strain over stress by strain.")
        .unit("s")
        .default("0.0")
        .example("1e-4");

const MARKERS: Key =
    Key::new("markers", Kind::Map(&NUMBER), "Named points, by their distance from the root along the unstrained beam.")
        .unit("m")
        .example("{ mid = 1.0 }");

const LOAD: Key = Key::new("load", Kind::Table(&LINE_LOAD), "Force per length beside gravity.")
    .example("{ force = [0.0, 0.0, -5.0] }");

const STRAINS: &[(&str, &str)] = &[
    ("bend", "Bending about y and z."),
    ("twist", "Twist about the centre line."),
    ("stretch", "Stretch along it."),
    ("shear", "Shear along y and z."),
];

/// The `curve` of a beam.
pub const BEAM_CURVE: Table = Table {
    name: "curve of a beam",
    doc: "A centre line: exactly one of `arc` and `helix`, which start along x, and `points`.",
    types: &[],
    keys: &[
        Key::new("arc", Kind::List(&NUMBER, &[2]), "Radius (m) and angle (rad) of an arc towards y.")
            .example("[100.0, 0.785]"),
        Key::new(
            "helix",
            Kind::List(&NUMBER, &[3]),
            "Radius (m), rise per turn (m) and number of turns of a right-handed helix; y points to its axis.",
        )
        .example("[0.05, 0.03, 5.0]"),
        Key::new(
            "points",
            Kind::List(&VECTOR, &[]),
            "Points in the axes of the root, from there on: the spline of degree 5 through them, with four continuous derivatives. \
             Sections turn with the tangent and not about it, from the shortest turn of the root's axes on.",
        )
        .unit("m")
        .example("[[0.0, 0.0, 0.0], [1.0, 0.0, 0.2], [2.0, 0.5, 0.0]]"),
    ],
};

/// A `section`.
pub const SECTION: Table = Table {
    name: "section",
    doc: "A cross section in the beam's y and z: exactly one of `circle`, `tube`, `rectangle` and `stiffness`.",
    types: &[],
    keys: &[
        Key::new("s", NOT_NEGATIVE, "In a list: its distance from the root along the unstrained beam.").unit("m").example("0.5"),
        Key::new("circle", POSITIVE, "Radius.").unit("m").example("0.005"),
        Key::new("tube", Kind::List(&NOT_NEGATIVE, &[2]), "Outer and inner radius.").unit("m").example("[0.02, 0.018]"),
        Key::new("rectangle", Kind::List(&POSITIVE, &[2]), "Width along y and height along z.")
            .unit("m")
            .example("[0.05, 0.004]"),
        Key::new(
            "stiffness",
            Kind::Either(&[Kind::List(&NUMBER, &[6]), Kind::List(&Kind::List(&NUMBER, &[6]), &[6])]),
            "EA, GA_y, GA_z (N), GJ, EI_y, EI_z (N m²), EI_y of bending about y; or a symmetric 6×6 matrix in this order.",
        )
        .example("[1e7, 4e6, 4e6, 80.0, 100.0, 100.0]"),
    ],
};

/// The `material` of a beam.
pub const MATERIAL: Table = Table {
    name: "material",
    doc: "An isotropic material.",
    types: &[],
    keys: &[
        Key::new("young", POSITIVE, "Young's modulus.").unit("Pa").required().example("71.7e9"),
        Key::new("poisson", NUMBER, "Poisson's ratio, above −1 up to 0.5.").default("0.3").example("0.31"),
        Key::new("density", POSITIVE, "Density.").unit("kg/m³").required().example("2800.0"),
    ],
};

/// The `load` of a beam.
pub const LINE_LOAD: Table = Table {
    name: "load per length",
    doc: "A force per unstrained length.",
    types: &[],
    keys: &[
        Key::new("force", VECTOR, "Force per length.").unit("N/m").required().example("[0.0, 0.0, -5.0]"),
        Key::new(
            "axes",
            Kind::Choice(&[
                ("inertial", "It keeps its direction in space."),
                ("body", "It turns with the section: a follower load, not conservative."),
            ]),
            "The axes in which it is constant.",
        )
        .default("\"inertial\"")
        .example("\"body\""),
    ],
};
