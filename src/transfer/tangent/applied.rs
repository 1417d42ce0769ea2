//! How force elements enter the tangent.

use nalgebra::Matrix3;

/// Force and moment from one part of a link's variation: 6×3.
#[derive(Debug, Clone, Copy, Default)]
pub struct Column {
    /// Upper three rows.
    pub force: Matrix3<f64>,
    /// Lower three rows.
    pub moment: Matrix3<f64>,
}

/// How a force element's wrench varies with `δθ`, `δr`, `δ'ω` and `δv` of a link: a small turn takes the angular
/// velocity with it.
pub type Applied = [Column; 4];

/// How force elements between a link and its parent couple the two: what each feels when the other moves.
#[derive(Debug, Clone, Copy, Default)]
pub struct Coupling {
    /// The link's wrench when its parent moves.
    pub by_parent: Applied,
    /// The parent's wrench, at its own marker, when the link moves.
    pub on_parent: Applied,
}
