//! Modal bodies: a flexible body of small deformation in a floating frame, whose coordinates are the displacements of its
//! interfaces and the amplitudes of modes.
//!
//! The frame is that of the root interface. The finite element model behind it is in `fem`; what is left of it are the
//! coefficients of polynomials in the coordinates `q`. In the axes of the frame, with its velocity `(V, w)` and its acceleration
//! against free fall `(A, α)`:
//!
//! ```text
//! (1) s = s₀ + C₀ q + ½ qᵀ S₂ q,   C = ∂s/∂q = C₀ + S₂ q              first moment of mass
//!     J = J₀ + Σ qᵢ J₁ᵢ + Σ qᵢ qⱼ J₂ᵢⱼ,   Gᵢ = G₀ᵢ + Σ qⱼ G₁ⱼᵢ          inertia, moment from q̈
//! (2) T = ½ m V² + V·(w × s + C q̇) + ½ wᵀ J w + w·G q̇ + ½ q̇ᵀ P q̇
//! (3) force   m A + α × s + w × (w × s) + 2 w × C q̇ + q̇ᵀ S₂ q̇ + C q̈
//!     moment  s × A + J α + w × J w + J̇ w + w × G q̇ + Ġ q̇ + G q̈
//!     row i   Cᵢ·A + Gᵢ·α + (P q̈)ᵢ + w·Σⱼ (G₁ⱼᵢ − G₁ᵢⱼ) q̇ⱼ − ½ wᵀ (∂J/∂qᵢ) w + (K q + D q̇)ᵢ
//! (4) interface t: place p = p₀ + Φ q + ½ qᵀ X q, axes exp(Ψ q)
//! ```
//!
//! (3) are the equations of Lagrange and Hamel of (2), term by term, so that energy and momentum are those of (2) whatever the
//! coefficients are. The terms of second order `S₂`, `X`, the symmetric part of `G₁` and a part of `J₂` are the geometric stiffness:
//! how far points are drawn in when the body bends. Wallrapp and Schwertassek, "Representation of geometric stiffening in
//! multibody system simulation" (1991), have the same from the stresses of unit loads.

mod motion;
mod tip;

pub use motion::ModalMotion;
pub use tip::{ModalTip, TipMotion};

use crate::spatial::Sym3;
use nalgebra::Vector3;

/// Coordinates of a modal body, at most.
pub const MOST_MODAL_COORDINATES: usize = 96;

/// The coefficients of (1) to (4). Lists of m vectors or tensors have one entry per coordinate, lists of m² entry `i m + j`.
#[derive(Debug, Clone, PartialEq)]
pub struct Modal {
    /// m (kg).
    pub mass: f64,
    /// `s₀` (kg m), m of `C₀`, m² of `S₂`: empty without geometric stiffness.
    pub first: (Vector3<f64>, Vec<Vector3<f64>>, Vec<Vector3<f64>>),
    /// `J₀` (kg m²), m of `J₁`, m² of `J₂`, symmetric in both indices.
    pub inertia: (Sym3, Vec<Sym3>, Vec<Sym3>),
    /// m of `G₀`, m² of `G₁`: entry (j, i) is `∂Gᵢ/∂qⱼ`.
    pub turning: (Vec<Vector3<f64>>, Vec<Vector3<f64>>),
    /// `P`, m×m by rows, symmetric.
    pub mass_matrix: Vec<f64>,
    /// `K`, m×m by rows, symmetric.
    pub stiffness: Vec<f64>,
    /// `D`, m×m by rows, symmetric; empty for none.
    pub damping: Vec<f64>,
    /// The interfaces other than the root.
    pub tips: Vec<ModalTip>,
    /// What each coordinate is called, and whether it is a length (m) and not an angle (rad).
    pub coordinates: Vec<(String, bool)>,
    /// Whether a load stiffens it: see the module.
    pub stiffens: bool,
}

impl Modal {
    /// Number of coordinates, `m`.
    pub fn count(&self) -> usize {
        self.coordinates.len()
    }

    /// Whether a coordinate is a length and not an angle.
    pub fn is_length(&self, coordinate: usize) -> bool {
        self.coordinates[coordinate].1
    }

    /// One row of `K`.
    pub fn stiffness_row(&self, i: usize) -> &[f64] {
        let m = self.count();
        &self.stiffness[i * m..(i + 1) * m]
    }

    /// `(K x)ᵢ`.
    pub fn elastic(&self, i: usize, x: &[f64]) -> f64 {
        product(&self.stiffness, self.count(), i, x)
    }

    /// `(D x)ᵢ`.
    pub fn damped(&self, i: usize, x: &[f64]) -> f64 {
        if self.damping.is_empty() { 0.0 } else { product(&self.damping, self.count(), i, x) }
    }

    /// An entry of `K + c₁ D`.
    pub fn pivot_entry(&self, i: usize, j: usize, c1: f64) -> f64 {
        let at = i * self.count() + j;
        self.stiffness[at] + self.damping.get(at).map_or(0.0, |d| c1 * d)
    }

    /// Elastic energy (J).
    pub fn elastic_energy(&self, q: &[f64]) -> f64 {
        (0..self.count()).map(|i| 0.5 * q[i] * self.elastic(i, q)).sum()
    }

    /// Power that damping takes out (W).
    pub fn dissipated(&self, v: &[f64]) -> f64 {
        (0..self.count()).map(|i| v[i] * self.damped(i, v)).sum()
    }

    /// Centre of mass in the frame without deformation (m).
    pub fn center(&self) -> Vector3<f64> {
        self.first.0 / self.mass
    }
}

fn product(matrix: &[f64], m: usize, i: usize, x: &[f64]) -> f64 {
    matrix[i * m..(i + 1) * m].iter().zip(x).map(|(k, x)| k * x).sum()
}
