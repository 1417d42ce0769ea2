//! Solids that touch: the gap between two of them, its normal, and the points at which they press on each other.
//!
//! A solid is a convex core (a point, a segment, a cylinder, a polytope) with a radius about it, or a half space. Two solids that touch
//! have a common tangent plane with normal `n`, from the first to the second. The features of both cores in that plane,
//! projected along `n`, are convex polygons (or segments, or points); what they have in common is the region of contact, and
//! its corners are the points of contact: pressure anywhere in the region is a convex combination of forces at them. Where a disc
//! bounds it, every point of its rim is one.
//!
//! ```text
//! (1)  gap = min_b n·x − max_a n·x − r_a − r_b
//! (2)  F_a = { x ∈ a : n·x ≥ max_a − slack },  F_b likewise;   points = corners of P(F_a) ∩ P(F_b),  P: along n
//! ```
//!
//! The normal of cores that are apart is that of their nearest points. Polytopes that touch without a radius have the
//! normal of largest separation among those of their faces and of pairs of their edges (separating axes: Gottschalk, Lin,
//! Manocha, "OBBTree", SIGGRAPH 1996); if several are equally good, as of two edges that meet, it is their mean.

mod askew;
mod chord;
mod cylinder;
mod disc;
mod drift;
pub mod feature;
pub mod meet;
mod polygon;
mod rim;
mod solid;
mod touch;

pub use solid::{Core, NotConvex, Placed, Solid};
pub(crate) use touch::tangents;
pub use touch::{NoNormal, RimArcs, Touch, touch};
