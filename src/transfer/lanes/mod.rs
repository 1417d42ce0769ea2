//! Sweeps over several trees at once: models of one structure that differ in their numbers, one in each lane of the registers.
//!
//! Read [`plain`](super::plain) beside it: the equations are those of [`super`], and every number of theirs is one of each model
//! ([`crate::spatial::lanes`]). Nothing is shared but the structure: masses, arms, axes, springs and gravity are each model's own.
//!
//! | file | its one job |
//! |---|---|
//! | `tree` | the structure, and the numbers of all models |
//! | `motion` | where the links are and how fast they move |
//! | `carried` | what a link passes to its parent: eqs. (1), (5), (6), (7) |
//! | `sweep` | both sweeps; which lanes have lost digits |
//!
//! A ball is eliminated as three turns about the axes of its link, one after the other. Lanes in which a pivot has lost digits, or
//! which no inertia resists, are named and not repaired: whoever asks computes those by [`super::Reduction`], which refines
//! them. Each stage is a function of its own that is not inlined: what it computes with fits into the registers, a whole link does not.

mod carried;
mod motion;
mod sweep;
mod tree;

pub use sweep::Sweep;
pub use tree::Tree;
