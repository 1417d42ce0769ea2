//! The certificate of a pose: whether its residual proves an equilibrium, what kind that is, and what holds it.
//!
//! | file | its one job |
//! |---|---|
//! | `equilibrium` | the equilibrium with its certificate; what is not balanced is named in `unbalanced` |
//! | `beams` | whether the balance of a beam's elements is one of the beam |
//! | `stability`, `modes` | how many directions leave it or have zero stiffness, and its natural modes; of large systems in `subspace` |
//! | `motion` | roots of the linearized motion, by its energy or by the pairs of `eigen`, and which grow |
//! | `damped` | damped modes, and the modes of steady motions and of loads without a potential |
//! | `known` | what is known of a stiffness that is small beside its terms |
//! | `closed` | with loops, drives and gears: motions along the closed positions |
//! | `bearing` | which stops bear, and the scene in which they do |
//! | `weak` | stops that bear nothing and kinks of forces: what happens on each side; `kinks` finds the latter |
//! | `sides`, `sided`, `rays`, `growing` | the cones on the sides of all of them, and the stiffness or the motion there |
//! | `cone`, `copositive` | the critical cone of a search in a tree, and whether a stiffness is copositive |
//! | `falling` | motions that nothing ends |

mod beams;
pub(super) mod bearing;
pub(super) mod closed;
pub(super) mod cone;
mod copositive;
pub(super) mod damped;
mod eigen;
pub(super) mod equilibrium;
pub(super) mod falling;
pub(super) mod growing;
mod kinks;
pub(super) mod known;
pub(super) mod modes;
pub(super) mod motion;
mod rays;
pub(super) mod sided;
pub(super) mod sides;
pub(super) mod stability;
mod subspace;
pub(super) mod unbalanced;
pub(super) mod weak;
