//! Contact and dry friction.

use super::super::fields::{Key, Kind, Range, Table};
use super::{NOT_NEGATIVE, POSITIVE};

/// Two numbers in place of one: friction at rest and in motion.
pub const FRICTION: Table = Table {
    name: "friction",
    doc: "Dry friction that is larger at rest than in motion.",
    types: &[],
    keys: &[
        Key::new("stick", NOT_NEGATIVE, "At rest: a coefficient between bodies, a force or torque in a hinge.")
            .required()
            .example("5.0"),
        Key::new("slide", NOT_NEGATIVE, "In motion, at most `stick`.").required().example("4.0"),
    ],
};

/// One number, or two.
pub(super) const DRY: Kind = Kind::Either(&[NOT_NEGATIVE, Kind::Table(&FRICTION)]);

/// `[[contact]]`
pub const CONTACT: Table = Table {
    name: "contact",
    doc: "Bodies that cannot pass through each other: those of their shapes that do not say `contact = false`. \
          Without any nothing touches. Of several entries that name a pair the last one counts; a body touches the one \
          that it hangs on only if both are named without `*`.",
    types: &[],
    keys: &[
        Key::new("name", Kind::Text, "Unique name; `contact[i]` with its place in the file, from 0, where left out.")
            .example("\"feet\""),
        Key::new(
            "between",
            Kind::List(&Kind::Text, &[2]),
            "Two names of bodies, or patterns in which `*` stands for any text.",
        )
        .required()
        .example("[\"crate[*]\", \"floor\"]"),
        Key::new("friction", DRY, "Coefficient of dry friction, the same in all directions.")
            .default("0.0")
            .example("0.5"),
        Key::new(
            "restitution",
            Kind::Number(Range::Between(0.0, 1.0)),
            "Rigid: part of the approaching speed that they part with.",
        )
        .default("0.0")
        .example("0.5"),
        Key::new("stiffness", POSITIVE, "Compliant: stiffness of every point of contact, along the normal.")
            .unit("N/m")
            .example("1e5"),
        Key::new("damping", NOT_NEGATIVE, "Compliant: damping of every point of contact; a contact never pulls.")
            .unit("N s/m")
            .default("0.0")
            .example("100.0"),
    ],
};
