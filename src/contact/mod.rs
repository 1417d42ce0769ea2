//! Contact and dry friction: what touches in one place, and which forces it can bear.
//!
//! | file | its one job |
//! |---|---|
//! | [`geometry`] | gap, normal and points of two solids, and the pairs of their features as smooth functions; knows no model |
//! | `pairs` | which shapes of a model may touch, and how they stand to each other in a place |
//! | `frame` | contacts in a place: directions, motion, and how the scene answers to what they push with |
//! | `cone` | Coulomb's law at several contacts at once, exactly; that of one in `cone/local`, states once they are found in `cone/states` |
//! | `bounded` | dry friction of a hinge in that problem: forces whose size is bounded |
//! | `hinges` | rigid stops and dry friction of hinges as supports of that problem, beside contacts |
//! | [`support`] | at rest: whether forces within cones can balance loads, by how much, and along which motion they give way |
//!
//! What contacts do as a scene moves is in `simulate/contact`; poses that stand are asked about in [`crate::statics::standing`].

mod bounded;
pub(crate) mod cone;
pub(crate) mod frame;
pub mod geometry;
pub(crate) mod hinges;
pub(crate) mod pairs;
pub mod support;
