//! Quadrature over an interval.

/// Nodes and weights of the Gauss–Legendre quadrature of six points on [−1, 1], exact to degree 11. The integrals of
/// rods have degree 6 at most with constant sections.
pub(super) const GAUSS: [(f64, f64); 6] = [
    (-0.932_469_514_203_152, 0.171_324_492_379_170_36),
    (-0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (-0.238_619_186_083_196_9, 0.467_913_934_572_691_04),
    (0.238_619_186_083_196_9, 0.467_913_934_572_691_04),
    (0.661_209_386_466_264_5, 0.360_761_573_048_138_6),
    (0.932_469_514_203_152, 0.171_324_492_379_170_36),
];

/// Nodes in 0 … 1 and weights of a quadrature that is exact to degree 11.
pub(crate) fn quadrature() -> impl Iterator<Item = (f64, f64)> {
    GAUSS.into_iter().map(|(t, w)| (0.5 * (1.0 + t), 0.5 * w))
}
