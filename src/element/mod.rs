//! Flexible rods in relative coordinates: a strain-based Cosserat element whose local coordinates are Legendre coefficients
//! of its free strains.
//!
//! Twists and wrenches have their linear part above their angular part; `x` runs along the rod. An element of length `h` and
//! degree `p` consists of `K = p + 2` steps between `p + 3` Gauss–Lobatto stations, at which slices of mass sit; with fewer
//! stations a free rod without rotary inertia would have a singular mass matrix.
//!
//! ```text
//! (1) ξ(s) = ξ₀(s) + Σ_d P_d(2s/h − 1) F q_d / h            F picks the free strains: stretch, shear y z; twist, bend y z
//! (2) I₀ = ∫ξ,  I₁ = ∫(s − s̄) ξ                             over a step of length l with its middle at s̄, affine in q
//! (3) Ω = I₀ + [I₀, I₁]/l,   g⁺ = g exp Ω                   Magnus expansion of 4th order, see `exponential`; of 6th for degree 2
//! (4) E = ∂Ω/∂q,   Z = B(Ω) E,   W = Z q̇,   Ẇ = Z q̈ + Ż q̇    twist of a station against the one before, its own axes
//! (5) Ż = Ḃ E + B Ė,   Z̈ = B̈ E + 2 Ḃ Ė + B Ë
//! (6) δ(Zᵀ f) = Zᵀ δf + Γ δq,   Γ = ⟨Ω_qq, Bᵀ f⟩ + Eᵀ (∂(Bᵀ f)/∂Ω) E
//! (7) V = ½ qᵀ Kₑ q,   Kₑ = ∫ P_d P_e Fᵀ C F ds / h²          dissipated: η q̇ᵀ Kₑ q̇ (Kelvin and Voigt)
//! ```
//!
//! The coordinates are lengths (stretch, shear; m) and angles (twist, bend; rad) over one element. Across a step a station
//! moves as a link does across a hinge whose motion subspace is `Z`; [`RodMotion`] has that in inertial axes.

pub mod catenary;
mod exponential;
pub mod guide;
pub(crate) mod lu;
pub mod modal;
mod motion;
pub mod pivot;
mod quadrature;
mod rod;
pub mod section;
pub mod stress;
mod variation;

pub(crate) use exponential::{bracket, halves, joined};
pub(crate) use motion::row;
pub use motion::{RodMotion, Station};
pub(crate) use quadrature::quadrature;
pub use rod::{Local, MOST_COORDINATES, Rod, RodSection, Slice};
pub use variation::{RodDirection, RodPoint};
