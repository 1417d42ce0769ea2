//! Models of other programs.

use super::super::fields::{Key, Kind, Range, Table};
use super::contact::DRY;
use super::{NOT_NEGATIVE, NUMBER, VECTOR};

/// `model = { … }`
pub const MODEL: Table = Table {
    name: "model",
    doc: "A model of another program (URDF or MJCF) whose bodies and hinges come before those of the file. They keep the names \
          of the model's links; a hinge has the name of the link that it carries.",
    types: &[],
    keys: &[
        Key::new("file", Kind::Text, "The model, as found from the scenario's folder.")
            .required()
            .example("\"robots/arm.urdf\""),
        Key::new("prefix", Kind::Text, "Put before the names of its bodies.").default("\"\"").example("\"left/\""),
        Key::new(
            "base",
            Kind::Choice(&[("fixed", "Welded to the ground."), ("free", "Moves freely.")]),
            "How its root is held.",
        )
        .default("\"fixed\"")
        .example("\"free\""),
        Key::new("at", VECTOR, "Where its root stands, inertial axes.")
            .unit("m")
            .default("[0.0, 0.0, 0.0]")
            .example("[0.0, 0.0, 0.8]"),
        Key::new("rpy", VECTOR, "How its root is turned: roll, pitch, yaw.")
            .unit("rad")
            .default("[0.0, 0.0, 0.0]")
            .example("[0.0, 0.0, 1.5708]"),
        Key::new("key", Kind::Text, "The keyframe of an MJCF model that is the start, by name or number from 0; else the first one.")
            .example("\"home\""),
        Key::new("limits", Kind::Flag, "Whether the limits of its joints become stops.").default("true").example("false"),
        Key::new("friction", Kind::Flag, "Whether its joints have the dry friction that the model gives them.")
            .default("true")
            .example("false"),
        Key::new(
            "contact",
            Kind::Flag,
            "Whether its shapes can touch: those of `<collision>` in a URDF, if a `[[contact]]` names their bodies; geoms in MJCF, \
             with the contacts between them.",
        )
        .default("false")
        .example("true"),
        Key::new("mimics", Kind::Flag, "Whether joints of a URDF that follow others become gears; else they move by themselves.")
            .default("true")
            .example("false"),
        Key::new(
            "massless",
            Kind::Choice(&[
                ("refuse", "They are an error."),
                ("weld", "Their joints are fixed, and each is noted."),
            ]),
            "What becomes of joints on whose bodies nothing weighs anything, nor has any inertia.",
        )
        .default("\"refuse\"")
        .example("\"weld\""),
        Key::new("packages", Kind::Map(&Kind::Text), "Folders of packages by name, for `package://name/…`.")
            .example("{ arm_description = \"../arm_description\" }"),
        Key::new("positions", Kind::Map(&VALUES), "Where its hinges start, by the name of the joint or of the body.")
            .unit("m or rad")
            .example("{ elbow = 1.2 }"),
        Key::new(
            "hinges",
            Kind::Map(&Kind::Table(&MODEL_HINGE)),
            "What its hinges have beside what the model says, by the name of the joint or of the body; `\"*\"` stands for \
             all that move, and is overruled by names.",
        )
        .example("{ \"*\" = { stiffness = 400.0, damping = 10.0 } }"),
    ],
};

const VALUES: Kind = Kind::Either(&[NUMBER, Kind::List(&NUMBER, &[])]);
const POSITIVE_VALUES: Kind = Kind::Either(&[NOT_NEGATIVE, Kind::List(&NOT_NEGATIVE, &[])]);

/// What a model's hinge may be given.
pub const MODEL_HINGE: Table = Table {
    name: "hinge",
    doc: "What a hinge of a model has beside what the model says; as in a `hinge`.",
    types: &[],
    keys: &[
        Key::new("position", VALUES, "Coordinates at the start, or the guess.").unit("m or rad").example("0.3"),
        Key::new("velocity", VALUES, "Velocities at the start.").unit("m/s or rad/s").example("0.1"),
        Key::new("stiffness", VALUES, "Stiffness of the hinge spring.").unit("N/m or N m/rad").example("400.0"),
        Key::new("damping", POSITIVE_VALUES, "Damping in the hinge.").unit("N s/m or N m s/rad").example("10.0"),
        Key::new("rest", VALUES, "Coordinates at which the spring is relaxed.").unit("m or rad").example("0.2"),
        Key::new("armature", POSITIVE_VALUES, "Added hinge inertia.").unit("kg or kg m²").example("0.01"),
        Key::new("friction", DRY, "Dry friction of the hinge.").unit("N or N m").example("4.0"),
        Key::new("force", VALUES, "Constant motor force or torque.").unit("N or N m").example("1.5"),
        Key::new("lock", Kind::Flag, "Held at `position` during statics.").example("true"),
        Key::new("limits", Kind::List(&Kind::Number(Range::Any), &[2]), "Lowest and highest coordinate.")
            .unit("m or rad")
            .example("[-1.0, 1.0]"),
    ],
};
